"""The program's camera, controls, arrows, grabbed targets and motions in a page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from loops import full
from viewer_pages import Page, opened, until

import nao_kin as nk

SIZE = (1100, 800)


@pytest.fixture(scope="module")
def live(nao: nk.NaoModel) -> Iterator[nk.Viewer]:
    with nk.Viewer(nao) as viewer:
        yield viewer


@pytest.fixture(scope="module")
def page(browser: Any, live: nk.Viewer) -> Iterator[Page]:
    with opened(browser, live.url, SIZE) as page:
        yield page


def _screen(page: Page, points: np.ndarray) -> np.ndarray:
    """Where points of the world are on the screen, shape (n, 2) [px]."""
    script = """(points) => points.map((point) => {
        const at = naoKin.viewer.scene.localToWorld(new MeshCat.THREE.Vector3(...point));
        const { clientX, clientY } = naoKin.pick.viewport.place(at);
        return [clientX, clientY];
    })"""
    return np.array(page.run(script, points.tolist()))


def test_a_program_moves_the_camera_and_reads_where_a_user_turns_it(live: nk.Viewer, page: Page) -> None:
    assert until(lambda: live.camera_pose is not None)
    tilted = nk.rotations.rot_z(2.5) @ nk.rotations.rot_y(0.3) @ nk.rotations.rot_x(0.4)
    for R in (nk.rotations.rot_z(3.0) @ nk.rotations.rot_y(0.2), tilted):
        T = nk.screws.pose(R, [1.2, -0.3, 0.7])
        live.camera_pose = T
        assert until(lambda T=T: np.abs(np.reshape(page.run("() => naoKin.cameraPose"), (4, 4)).T - T).max() < 1e-12)
    down = nk.screws.pose(nk.rotations.rot_z(2.0) @ nk.rotations.rot_y(np.pi / 2), [0.1, 0.0, 2.0])
    live.camera_pose = down
    assert until(lambda: np.abs(np.reshape(page.run("() => naoKin.cameraPose"), (4, 4)).T - down).max() < 1e-4)
    # A point one metre ahead is in the middle of the picture, one to its left and above it are there.
    T = nk.screws.pose(nk.rotations.rot_z(np.pi), [2.0, 0.0, 0.3])
    live.camera_pose = T
    assert until(lambda: np.abs(np.reshape(page.run("() => naoKin.cameraPose"), (4, 4)).T - T).max() < 1e-12)
    middle, left, above = _screen(page, np.array([[1.0, 0.0, 0.3], [1.0, -0.1, 0.3], [1.0, 0.0, 0.4]]))
    box = page.tab.locator("#pane").bounding_box()
    assert middle == pytest.approx([box["x"] + box["width"] / 2, box["y"] + box["height"] / 2], abs=1e-6)
    assert left[0] < middle[0] - 10
    assert above[1] < middle[1] - 10
    page.tab.mouse.move(middle[0] + 250, middle[1] - 150)
    page.tab.mouse.down()
    page.tab.mouse.move(middle[0] + 150, middle[1] - 150, steps=3)
    page.tab.mouse.up()
    assert until(lambda: np.abs(live.camera_pose - T).max() > 0.1)
    assert until(
        lambda: np.allclose(np.reshape(page.run("() => naoKin.cameraPose"), (4, 4)).T, live.camera_pose, atol=1e-9)
    )


def test_parallel_projection_keeps_sizes_and_presets_are_along_axes(live: nk.Viewer, page: Page) -> None:
    live.show("orthographic")
    live.camera("right")
    assert until(lambda: page.run("() => naoKin.view") == "right")
    assert until(lambda: np.allclose(live.camera_pose[:3, 0], [0.0, 1.0, 0.0], atol=1e-9))
    near = _screen(page, np.array([[0.0, -1.0, 0.1], [0.2, -1.0, 0.1], [0.0, 1.0, 0.1]]))
    assert near[0] == pytest.approx(near[2], abs=1e-6)
    # Pixels of a length, and a ray through a place of the screen back to the point.
    per_pixel = page.run("() => naoKin.pick.viewport.metresPerPixel(new MeshCat.THREE.Vector3())")
    assert abs(near[1, 0] - near[0, 0]) * per_pixel == pytest.approx(0.2, rel=2e-3)
    away = page.run(
        """([x, y]) => naoKin.pick.viewport.ray({ clientX: x, clientY: y })
            .distanceToPoint(naoKin.viewer.scene.localToWorld(new MeshCat.THREE.Vector3(0.2, -1, 0.1)))""",
        near[1].tolist(),
    )
    assert away < 1e-6
    live.show("orthographic", False)
    assert until(lambda: page.run("() => !naoKin.projection.isParallel"))
    assert until(lambda: not np.allclose(live.camera_pose[:3, 0], [0.0, 1.0, 0.0], atol=1e-3))


def test_a_user_works_the_controls_of_a_program(live: nk.Viewer, page: Page) -> None:
    calls: list[Any] = []
    depth = live.add_slider("depth", -1.0, 1.0, 0.0, calls.append, unit="m")
    side = live.add_select("side", ["left", "right"], on_change=calls.append)
    go = live.add_button("go", lambda: calls.append("go"))
    name = live.add_text("name", "NAO", calls.append)
    state = live.add_text("state", "ready")
    slider = page.tab.get_by_role("slider", name="depth")
    box = slider.bounding_box()
    page.tab.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.tab.mouse.down()
    page.tab.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + box["height"] / 2, steps=4)
    page.tab.mouse.up()
    dragged = float(slider.input_value())
    assert 0.4 < dragged < 0.6
    assert until(lambda: depth.value == dragged and calls[-1:] == [dragged])
    page.tab.keyboard.press("Home")
    assert until(lambda: depth.value == -1.0)
    page.tab.keyboard.press("Control+z")
    assert until(lambda: depth.value == dragged)
    page.tab.keyboard.press("Control+z")
    assert until(lambda: depth.value == 0.0 and calls[-1] == 0.0)
    page.tab.keyboard.press("Control+Shift+z")
    assert until(lambda: depth.value == dragged)
    page.tab.locator(".control.slider .number").click()
    field = page.tab.get_by_role("textbox", name="depth")
    field.fill("12")
    field.press("Enter")
    assert until(lambda: depth.value == 1.0)
    assert "the limit is 1.00" in page.tab.locator(".control .note").text_content()
    page.tab.keyboard.type("0x")
    page.tab.keyboard.press("Enter")
    assert "expected −1.00" in page.tab.locator(".control .note").text_content()
    field.press("Escape")
    assert page.tab.locator(".control.slider .number").inner_text() == "1.000"
    page.tab.get_by_label("side").select_option("right")
    assert until(lambda: side.value == "right")
    page.tab.get_by_role("button", name="go", exact=True).press("Enter")
    page.tab.get_by_role("button", name="go", exact=True).click()
    page.tab.get_by_role("textbox", name="name").fill("Ada")
    page.tab.keyboard.press("Enter")
    assert until(lambda: name.value == "Ada" and calls[-4:] == ["right", "go", "go", "Ada"])
    # The program sets them, and the elements stay the same.
    page.run("() => { document.querySelector('.control select').kept = true; }")
    side.value, state.value, depth.value = "left", "walks", 0.5
    assert until(lambda: page.tab.locator(".control.slider .number").inner_text() == "0.500")
    assert page.run("() => document.querySelector('.control select').kept")
    assert page.tab.get_by_label("side").input_value() == "left"
    assert page.tab.locator(".control output").text_content() == "walks"
    for control in (depth, side, name):
        control.remove()
    assert until(lambda: page.tab.locator(".control").count() == 2)
    go.remove()
    state.remove()


def test_a_change_stays_while_the_program_sends_others(live: nk.Viewer, page: Page) -> None:
    calls: list[Any] = []
    name = live.add_text("name", "NAO", calls.append)
    depth = live.add_slider("depth", 0.0, 1.0, 0.5, calls.append)
    ball = live.add_target("ball", [0.2, 0.1, 0.1], on_move=lambda T: calls.append("ball"))
    assert until(lambda: page.run("() => naoKin.targets.list.length === 1 && naoKin.controls.rows.length === 2"))
    # The program has sent its lists for another reason before it knows of the changes: they wait, and are on their way.
    moved = page.run(
        """() => {
            const { controls, targets } = naoKin;
            const [rows, [target]] = [controls.rows.map(({ control }) => control), targets.list];
            const again = () => {
                controls.show(rows);
                targets.show([target.row]);
            };
            controls.rows[0].change("Ada");
            targets.move(target, target.node.matrix.clone().setPosition(0.3, 0, 0));
            again();
            controls.changes.report();
            targets.changes.report();
            again();
            return [controls.rows[0].value, target.node.matrix.elements[12]];
        }"""
    )
    assert moved == ["Ada", 0.3]
    assert until(lambda: name.value == "Ada" and ball.T[0] == 0.3)
    assert until(lambda: sorted(map(str, calls)) == ["Ada", "ball"])
    # What the program changes afterwards is shown, also if it is what it was at first.
    name.value, depth.value = "NAO", 0.75
    ball.place([0.2, 0.1, 0.1])
    shown = "() => [...naoKin.controls.rows.map((row) => row.value), naoKin.targets.list[0].node.matrix.elements[12]]"
    assert until(lambda: page.run(shown) == ["NAO", 0.75, 0.2])
    # A change that the program has not received yet replaces the program's own, in the page as in the program.
    moved = page.run(
        """() => {
            const { controls, targets } = naoKin;
            const [rows, [target]] = [controls.rows.map(({ control }) => control), targets.list];
            controls.rows[1].change(0.9);
            targets.move(target, target.node.matrix.clone().setPosition(0.4, 0, 0));
            controls.show([rows[0], { ...rows[1], value: 0.1, source: "program 0" }]);
            targets.show([{ ...target.row, source: "program 0" }]);
            return [controls.rows[1].value, target.node.matrix.elements[12]];
        }"""
    )
    assert moved == [0.9, 0.4]
    assert until(lambda: depth.value == 0.9 and ball.T[0] == 0.4)
    for one in (name, depth, ball):
        one.remove()


def test_collision_shapes_and_boxes_of_inertia_are_at_their_links(
    live: nk.Viewer, page: Page, nao: nk.NaoModel
) -> None:
    live.show("shapes")
    live.show("inertia")
    assert until(lambda: page.run("() => naoKin.bodyShapes.collision.length") == len(nao.tree.collisions))
    assert until(lambda: page.run("() => naoKin.bodyShapes.inertia.length > 0"))
    masses = sum(inertia.mass for inertia in nao.model.inertias)
    boxes = page.run(
        """() => naoKin.bodyShapes.inertia.map((mesh, i) => {
            const { mass } = naoKin.robot.about.bodies[i];
            const { width, height, depth } = mesh.geometry.parameters;
            return [mass, mesh.position.toArray(), [width, height, depth], mesh.matrix.elements];
        })"""
    )
    assert sum(mass for mass, *_ in boxes) == pytest.approx(masses)
    bodies = [inertia for inertia in nao.model.inertias if inertia.mass > 0.0]
    for inertia, (mass, centre, edges, matrix) in zip(bodies, boxes, strict=True):
        assert centre == pytest.approx(np.array(inertia.lever))
        R, squares = np.reshape(matrix, (4, 4)).T[:3, :3], np.square(edges)
        assert np.linalg.det(R) == pytest.approx(1.0)
        around = R @ np.diag(mass / 12.0 * (squares.sum() - squares)) @ R.T
        assert np.abs(around - inertia.inertia).max() < 1e-2 * np.abs(inertia.inertia).max()
    live.show("shapes", False)
    live.show("inertia", False)
    assert until(lambda: page.run("() => naoKin.bodyShapes.collision.length + naoKin.bodyShapes.inertia.length") == 0)


def test_arrows_and_labels_are_where_they_belong(live: nk.Viewer, page: Page) -> None:
    live.add_arrow("force", [0.3, 0.0, 0.1], [0.3, 0.0, 0.4])
    live.add_label("note", "a place", [0.3, 0.1, 0.4])
    assert until(lambda: page.run("() => naoKin.labels.shown.some(({ text }) => text === 'a place')"))
    low, high = page.run(
        """() => {
            naoKin.viewer.scene.updateMatrixWorld(true);
            const box = new MeshCat.THREE.Box3().setFromObject(naoKin.extras.shapes.get("force"));
            return [box.min.toArray(), box.max.toArray()];
        }"""
    )
    assert [low[1], high[1]] == pytest.approx([0.1, 0.4])  # three.js has y up
    assert high[0] - low[0] == pytest.approx(0.018, abs=1e-3)
    live.remove("force")
    live.remove("note")
    assert until(lambda: page.run("() => !naoKin.labels.shown.some(({ text }) => text === 'a place')"))


@pytest.mark.parametrize("interpolation", ["bezier", *full("linear", "smooth")])
def test_a_motion_plays_along_its_own_curves(live: nk.Viewer, page: Page, nao: nk.NaoModel, interpolation: Any) -> None:
    rng = np.random.default_rng(1)
    names = ("HeadYaw", "LShoulderRoll", "LHipYawPitch", "RHipYawPitch")
    times = [2.0 + np.cumsum(rng.uniform(0.1, 0.7, 5)) for _ in names]
    times[3] = times[2]
    motion = nk.Motion(times, names, [rng.uniform(-0.3, 0.3, 5) for _ in names], interpolation)
    if motion.handles is not None:
        handles = [np.array(each) for each in motion.handles]
        for each in handles:
            each[..., 0] *= rng.uniform(0.1, 2.9, (5, 2))
            each[..., 1] += rng.normal(0.0, 0.1, (5, 2))
        handles[3] = handles[2]
        motion = nk.Motion(times, names, motion.keys, interpolation, handles)
    live.animate(motion, play=False)
    assert until(lambda: page.run("(end) => Math.abs(naoKin.player.motion?.end - end) < 1e-9", motion.duration))
    at = np.append(rng.uniform(0.0, motion.duration, 40), [0.0, motion.duration])
    shown = page.run(
        "(at) => at.map((t) => { naoKin.player.seek(t); naoKin.settle(); return [...naoKin.q]; })", at.tolist()
    )
    expected = motion.configurations(nao, times=motion.start + at).q
    assert np.abs(np.array(shown) - expected).max() < 1e-9
    assert until(lambda: np.abs(live.q - expected[-1]).max() < 1e-9)
    live.display(nao.posture("StandInit"))
    assert until(lambda: not page.run("() => naoKin.player.loaded"))


def test_a_script_around_the_page_moves_it(live: nk.Viewer, page: Page, nao: nk.NaoModel) -> None:
    """All expressions that docs/viewer_embedding.md lists, from a document with a saved page in a frame."""
    live.animate(np.stack([nao.posture("Stand"), nao.posture("Crouch")]), fps=1.0, play=False)
    q, pose = nao.posture("Sit"), nk.screws.pose(nk.rotations.rot_z(3.0), [1.0, 0.2, 0.3])
    saved = live.static_html()
    found = page.run(
        """async ([saved, q, pose]) => {
            const frame = document.createElement("iframe");
            frame.srcdoc = saved;
            document.body.append(frame);
            const isReady = () => frame.contentDocument?.body?.hasAttribute("data-ready");
            while (!isReady()) await new Promise((done) => setTimeout(done, 50));
            const { naoKin } = frame.contentWindow;
            const found = {};
            const heard = [];
            naoKin.addEventListener("settled", ({ detail }) => heard.push(detail.own));
            naoKin.set(q);
            naoKin.settle();
            found.q = [...naoKin.q];
            found.hand = naoKin.pose("LArm");
            found.com = naoKin.com();
            naoKin.posture("Crouch");
            naoKin.settle();
            found.crouch = [...naoKin.q];
            naoKin.camera(pose);
            found.pose = naoKin.cameraPose;
            naoKin.camera("top");
            found.top = naoKin.cameraPose;
            naoKin.show({ com: true });
            found.shown = naoKin.toggles.shown.com;
            const { player } = naoKin;
            found.duration = player.duration;
            player.setSpeed(0.5);
            player.setLoop(false);
            player.seek(0.25);
            naoKin.settle();
            found.time = player.time;
            found.middle = [...naoKin.q];
            player.play();
            found.plays = player.playback.playing;
            player.pause();
            found.pauses = !player.playback.playing;
            found.heard = heard;
            frame.remove();
            return found;
        }""",
        [saved, q.tolist(), pose.T.reshape(-1).tolist()],
    )
    assert np.array_equal(found["q"], q)
    assert np.abs(np.reshape(found["hand"], (4, 4)) - nao.fk(q, "LArm")).max() < 1e-12
    assert np.abs(found["com"] - nao.com(q)).max() < 1e-12
    assert np.array_equal(found["crouch"], nao.posture("Crouch"))
    assert np.abs(np.reshape(found["pose"], (4, 4)).T - pose).max() < 1e-12
    assert np.reshape(found["top"], (4, 4)).T[:3, 0] == pytest.approx([0.0, 0.0, -1.0], abs=1e-4)
    assert (found["shown"], found["duration"], found["time"]) == (True, 1.0, 0.25)
    assert found["middle"] == pytest.approx(0.75 * nao.posture("Stand") + 0.25 * nao.posture("Crouch"), abs=1e-6)
    assert found["plays"]
    assert found["pauses"]
    assert found["heard"][:2] == [True, True]


def test_without_its_program_the_controls_are_disabled(
    nao: nk.NaoModel, browser: Any, live: nk.Viewer, page: Page
) -> None:
    live.add_slider("depth", 0.0, 1.0, 0.5)
    assert until(lambda: page.tab.get_by_role("slider", name="depth").count() == 1)
    assert page.tab.get_by_role("slider", name="depth").is_enabled()
    live.close()
    assert until(lambda: page.tab.get_by_role("slider", name="depth").is_disabled())
    assert page.tab.get_by_text("These work while their program is connected.").is_visible()
