"""Uses of the viewer beyond showing one robot: other robots, shapes, and callbacks about what pages do."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from viewer_pages import Page, opened, until

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.joints import MultiDofModel
from nao_kin.viewer import Viewer

HOSTILE = ("__proto__", "</script><script>window.hacked = 1</script>", "a/b", "toString", "Ω" * 200)


@pytest.fixture(scope="module")
def live(nao: nk.NaoModel) -> Iterator[Viewer]:
    with Viewer(nao) as viewer:
        yield viewer


@pytest.fixture(scope="module")
def page(browser: Any, live: Viewer) -> Iterator[Page]:
    with opened(browser, live.url) as page:
        yield page


def _poses(page: Page, number: int, links: tuple[str, ...]) -> np.ndarray:
    """Poses of links of another robot in its root's frame, shape (n, 4, 4)."""
    rows = page.run(
        """([number, links]) => {
            const { robot } = naoKin.others.robots.get(number).shown;
            return links.map((name) => robot.pose(robot.linkOf(name)).transpose().toArray());
        }""",
        [number, list(links)],
    )
    return np.reshape(rows, (-1, 4, 4))


def _on_ground(page: Page, number: int) -> np.ndarray:
    """Pose of the root of another robot over its ground."""
    return np.reshape(page.run("(n) => naoKin.others.robots.get(n).shown.robot.placement().elements", number), (4, 4)).T


def _in_world(page: Page, number: int) -> np.ndarray:
    """Pose of the root of another robot over the floor of the scene."""
    elements = page.run(
        """(n) => new MeshCat.THREE.Matrix4().copy(naoKin.viewer.scene.matrixWorld).invert()
            .multiply(naoKin.others.robots.get(n).shown.robot.root.matrixWorld).elements""",
        number,
    )
    return np.reshape(elements, (4, 4)).T


# --- other robots -----------------------------------------------------------------------------------------------------


@pytest.mark.full
def test_every_robot_of_a_saved_page_is_where_its_forward_kinematics_says(
    browser: Any, nao: nk.NaoModel, tmp_path: Path
) -> None:
    viewer, typed = Viewer(nao), MultiDofModel(nao)
    viewer.display(nao.posture("Crouch"))
    old = nk.load_nao("v4")
    second, third = viewer.add_robot(old, name="second"), viewer.add_robot(typed, opacity=0.5)
    second.display(old.posture("LyingBack"))
    q_typed = typed.from_q(nao.random(4))
    third.display(q_typed)
    with opened(browser, viewer.save_html(tmp_path / "three.html")) as page:
        assert page.requests == [(tmp_path / "three.html").as_uri()]
        assert np.abs(page.poses(nao.link_names) - nao.fk(nao.posture("Crouch"))).max() < 1e-6
        assert np.abs(_poses(page, 1, old.link_names) - old.fk(old.posture("LyingBack"))).max() < 1e-6
        assert np.abs(_poses(page, 2, typed.link_names) - typed.fk(q_typed)).max() < 1e-6
        assert _on_ground(page, 1)[2, 0] > 0.95  # it lies on its back
        for number in (1, 2):
            lowest = page.run("(n) => naoKin.others.robots.get(n).shown.robot.lowest()", number)
            assert lowest == pytest.approx(0.0, abs=1e-9)
        apart = np.diff([0.0, *(_in_world(page, number)[1, 3] for number in (1, 2))])
        assert (apart < -0.3).all()
        corners = page.run(
            """() => {
                const { Vector3 } = MeshCat.THREE;
                const { camera } = naoKin.viewer;
                camera.updateMatrixWorld();
                return [1, 2].flatMap((n) => {
                    const { robot } = naoKin.others.robots.get(n).shown;
                    return robot.nodes.map((node) => node.getWorldPosition(new Vector3()).project(camera).toArray());
                });
            }"""
        )
        assert np.abs(corners).max() < 1.0  # the camera looks at all of them
        page.draw(True)
        page.tab.wait_for_function("() => naoKin.studio.floor.uniforms.spread.value > 0")
        middle, spread = page.run(
            "() => ['middle', 'spread'].map((name) => naoKin.studio.floor.uniforms[name].value)"
            ".map((value) => value.toArray?.() ?? value)"
        )
        places = np.array([[0.0, 0.0], *(_in_world(page, number)[:2, 3] for number in (1, 2))])
        assert np.linalg.norm(places - middle, axis=1).max() < spread + 0.3  # the floor is under all of them
    assert np.array_equal(second.q, old.posture("LyingBack"))
    assert np.allclose(typed.fk(third.q), typed.fk(q_typed), atol=1e-12)


@pytest.mark.full
def test_a_robot_comes_moves_and_goes_in_an_open_page_and_leaves_nothing_behind(
    page: Page, live: Viewer, nao: nk.NaoModel
) -> None:
    memory = "() => (naoKin.viewer.render(), { ...naoKin.viewer.renderer.info.memory })"
    before, kept = page.run(memory), sum(map(len, live._messages.messages()))
    T = np.eye(4)
    T[:2, :2], T[:3, 3] = [[0.0, -1.0], [1.0, 0.0]], [0.5, 0.2, 0.3]
    other = live.add_robot(nao, name="twin", at=T)
    page.tab.wait_for_function("() => naoKin.others.robots.size === 1")
    (number,) = page.run("() => [...naoKin.others.robots.keys()]")
    q = nao.posture("Stand")
    other.display(q)
    page.tab.wait_for_function(
        "([n, x]) => naoKin.others.robots.get(n).shown.robot.q[1] === x", arg=[number, float(q[1])]
    )
    assert np.abs(_poses(page, number, nao.link_names) - nao.fk(q)).max() < 1e-6
    assert np.allclose(_in_world(page, number), T @ _on_ground(page, number), atol=1e-9)
    shared = """(n) => naoKin.others.robots.get(n).shown.robot.meshes
        .every(({ mesh }, i) => mesh.geometry === naoKin.robot.meshes[i].mesh.geometry)"""
    assert page.run(shared, number)  # on the graphics card, too
    old = live.add_robot(nk.load_nao("v4"))
    page.tab.wait_for_function("() => naoKin.others.robots.size === 2")
    assert page.run(memory)["geometries"] > before["geometries"]
    other.color_links({"Head": 1.0, "torso": 0.0})
    page.tab.wait_for_function("(n) => naoKin.others.robots.get(n).shown.colours.scale.size > 0", arg=number)
    assert page.run("() => naoKin.colours.scale.size") == 0
    other.display(q, up=[0.0, 1.0, 0.0])
    page.tab.wait_for_function(
        "(n) => naoKin.others.robots.get(n).shown.robot.placement().elements[6] > 0.999", arg=number
    )
    other.place(np.eye(4))
    page.tab.wait_for_function(
        "(n) => Math.abs(naoKin.others.robots.get(n).shown.robot.root.parent.position.x) < 1e-12", arg=number
    )
    page.run("() => { const { fastLook, shapes } = naoKin.studio; fastLook.draw(shapes, naoKin.viewer.camera); }")
    other.remove()
    other.remove()
    old.remove()
    page.tab.wait_for_function("() => naoKin.others.robots.size === 0")
    looks = "() => [naoKin.studio.fastLook.materials.size, naoKin.robot.meshes.length]"
    assert len(set(page.run(looks))) == 1
    of_one = """() => [naoKin.parts.models.size - 1, naoKin.parts.geometries.size -
        new Set(naoKin.robot.meshes.map(({ mesh }) => mesh.geometry)).size]"""
    page.tab.wait_for_function(f"() => String(({of_one})()) === '0,0'")
    live.color_links({})
    # What draws a picture while something moves may be made only now; a robot would have left dozens behind.
    assert all(count <= before[kind] + 1 for kind, count in page.run(memory).items())
    assert sum(map(len, live._messages.messages())) - kept < 200
    with pytest.raises(BadArgument, match="twin was removed"):
        other.display(q)


@pytest.mark.full
def test_what_one_robot_looks_like_leaves_its_equal_alone(browser: Any, nao: nk.NaoModel) -> None:
    boxes = """() => {
        const { Vector3 } = MeshCat.THREE;
        const { camera } = naoKin.viewer;
        const { width, height } = naoKin.viewer.renderer.domElement.getBoundingClientRect();
        camera.updateMatrixWorld();
        return [naoKin.robot, naoKin.others.robots.get(1).shown.robot].map((robot) => {
            const places = robot.nodes.map((node) => node.getWorldPosition(new Vector3()).project(camera));
            const [x, y] = [places.map((p) => (p.x + 1) / 2 * width), places.map((p) => (1 - p.y) / 2 * height)];
            return [Math.min(...x), Math.max(...x), Math.min(...y), Math.max(...y)].map(Math.round);
        });
    }"""
    with Viewer(nao) as viewer:
        twin = viewer.add_robot(nao, name="twin")
        viewer.camera("front")
        with opened(browser, viewer.url, draws=True) as page:
            tab = page.tab
            # They may cover the feet.
            page.run("() => { for (const id of ['legend', 'hint']) document.getElementById(id).style.opacity = 0; }")

            def pictures() -> list[np.ndarray]:
                page.animation_frames(3)
                tab.wait_for_function("() => !naoKin.studio.quality.moving && naoKin.studio.began === null")
                page.animation_frames(3)
                whole, places = page.picture(), page.run(boxes)
                return [whole[top:bottom, left:right] for left, right, top, bottom in places]

            before = pictures()

            def assert_changed(change: Callable[[], object], done: str, own: bool) -> None:
                """Only the page's own robot, or only the twin, looks different afterwards."""
                change()
                tab.wait_for_function(done)
                old, before[:] = before[:], pictures()
                for was, picture, is_meant in zip(old, before, (own, not own), strict=True):
                    assert np.array_equal(picture, was) != is_meant

            other = "naoKin.others.robots.get(1).shown.colours"
            own = "() => naoKin.colours"
            assert_changed(lambda: twin.color_links({"torso": 1.0}), f"() => {other}.scale.size > 0", own=False)
            assert_changed(lambda: viewer.color_links({"Head": 1.0}), f"{own}.scale.size > 0", own=True)
            lit = "() => naoKin.lights.shapes.get('Chest').mesh.userData.lit"
            assert_changed(lambda: viewer.show_lights({"Chest": (0.0, 1.0, 0.0)}), lit, own=True)

            def fade() -> None:
                tab.get_by_role("button", name="Settings").click()
                tab.wait_for_function("() => document.activeElement.value === 'deg'")
                tab.get_by_role("slider", name="Opacity").focus()
                tab.keyboard.press("Home")
                tab.keyboard.press("Escape")

            assert_changed(fade, "() => naoKin.studio.opacity < 0.2", own=True)
            # A pale one, of the same shapes, comes and goes.
            pale = viewer.add_robot(nao, name="pale", opacity=0.3)
            tab.wait_for_function("() => naoKin.others.robots.size === 2")
            assert page.run("() => naoKin.others.robots.get(2).shown.robot.meshes[0].mesh.material.opacity") == 0.3
            pale.remove()
            tab.wait_for_function("() => naoKin.others.robots.size === 1")
            assert all(np.array_equal(a, b) for a, b in zip(pictures(), before, strict=True))


@pytest.mark.full
def test_robots_are_named_hidden_and_looked_at_in_the_panel(
    browser: Any, nao: nk.NaoModel, tmp_path: Path, page: Page
) -> None:
    assert not page.tab.get_by_role("region", name="Robots in the scene").is_visible()
    viewer = Viewer(nao)
    viewer.add_robot(nao, name="twin")
    viewer.add_robot(nk.load_nao("v4"), name=HOSTILE[1])
    viewer.add_robot(nao, name=HOSTILE[1])
    box = "(n) => { const b = naoKin.others.box([]); return [b.min.z, b.max.z]; }"
    with opened(browser, viewer.save_html(tmp_path / "several.html"), (900, 700)) as several:
        several.draw(False)
        section = several.tab.get_by_role("region", name="Robots in the scene")
        names = section.get_by_role("listitem").all_inner_texts()
        assert [name.split("\n")[0].strip() for name in names] == [
            nao.name,
            "twin",
            f"{HOSTILE[1]} (3)",
            f"{HOSTILE[1]} (4)",
        ]
        assert "“Move together” in View moves the others along" in section.inner_text()
        all_of_them = several.run(box)
        show = section.get_by_role("checkbox", name=f"Show {HOSTILE[1]} (4)", exact=True)
        show.focus()
        several.tab.keyboard.press("Space")
        assert not several.run("() => naoKin.others.robots.get(3).shown.robot.root.visible")
        assert several.run(box)[1] < all_of_them[1] - 0.1  # cameras look at what is seen
        several.tab.keyboard.press("Space")
        assert several.run("() => naoKin.others.robots.get(3).shown.robot.root.visible")
        assert several.run(box) == all_of_them

        for name, number in (("twin", 1), (f"{HOSTILE[1]} (3)", 2), (nao.name, 0)):
            section.get_by_role("button", name=f"Look at {name}", exact=True).click()
            middle, corners = several.run(
                """(n) => {
                    const { Vector3 } = MeshCat.THREE;
                    const robot = n ? naoKin.others.robots.get(n).shown.robot : naoKin.robot;
                    const { camera, controls } = naoKin.viewer;
                    camera.updateMatrixWorld();
                    const centre = robot.box([]).getCenter(new Vector3());
                    return [controls.target.distanceTo(centre),
                        robot.nodes.map((node) => node.getWorldPosition(new Vector3()).project(camera).toArray())];
                }""",
                number,
            )
            assert middle < 1e-6
            assert np.abs(corners).max() < 1.0
            assert np.ptp(np.array(corners)[:, 1]) > 1.0  # it fills the view


# --- shapes -----------------------------------------------------------------------------------------------------------


def _rows(count: int) -> np.ndarray:
    return np.random.default_rng(3).normal(size=(count, 3))


@pytest.mark.full
def test_points_lines_and_meshes_are_in_a_saved_page(browser: Any, nao: nk.NaoModel, tmp_path: Path) -> None:
    viewer, points, solid = Viewer(nao), _rows(500), trimesh.creation.icosphere(subdivisions=2, radius=0.05)
    solid.export(tmp_path / "ball.stl")
    viewer.add_points("cloud", points, colors=np.clip(np.abs(points), 0.0, 1.0), size=0.004)
    viewer.add_line("way", points[:7], color=(1.0, 0.0, 0.0), width=0.01)
    viewer.add_mesh("ball", solid.vertices, solid.faces, color=(0.0, 1.0, 0.0), frame="LArm")
    viewer.add_mesh("file", tmp_path / "ball.stl", opacity=0.5)
    q = nao.random(1)
    viewer.display(q)
    with opened(browser, viewer.save_html(tmp_path / "shapes.html")) as page:
        assert page.run("() => [...naoKin.extras.shapes.keys()]") == ["cloud", "way", "ball", "file"]
        drawn = page.run("() => Array.from(naoKin.extras.shapes.get('cloud').geometry.attributes.position.array)")
        assert np.array_equal(np.reshape(drawn, (-1, 3)), points.astype(np.float32))
        ends = page.run(
            """() => {
                const { Matrix4, Vector3 } = MeshCat.THREE;
                const [rods] = naoKin.extras.shapes.get('way').children;
                return [...Array(rods.count).keys()].flatMap((i) => {
                    const at = new Matrix4();
                    rods.getMatrixAt(i, at);
                    return [-0.5, 0.5].map((y) => new Vector3(0, y, 0).applyMatrix4(at).toArray());
                });
            }"""
        )
        expected = np.repeat(points[:7], 2, axis=0)[1:-1]
        assert np.abs(np.array(ends) - expected).max() < 1e-5
        pose = page.run(
            """() => {
                naoKin.settle();
                const root = new MeshCat.THREE.Matrix4().copy(naoKin.robot.root.matrixWorld).invert();
                return root.multiply(naoKin.extras.shapes.get('ball').matrixWorld).transpose().elements;
            }"""
        )
        page.run("() => naoKin.viewer.render()")
        assert np.abs(np.reshape(pose, (4, 4)) - nao.fk(q, "LArm")).max() < 1e-6
        vertices = page.run("() => naoKin.extras.shapes.get('file').children[0].geometry.attributes.position.count")
        assert vertices == len(solid.vertices)
        # Neither a shadow nor a ghost of the robot takes them for parts of it.
        # The planes of flat soles are on the floor, not the lowest vertices.
        assert page.run("() => naoKin.robot.lowest()") == pytest.approx(0.0, abs=3e-4)


def test_shapes_are_replaced_and_removed_in_an_open_page(page: Page, live: Viewer) -> None:
    memory = "() => (naoKin.viewer.render(), { ...naoKin.viewer.renderer.info.memory })"
    # A page that falls behind gets the missing messages in the order in which they became outstanding.
    names = "(expected) => JSON.stringify([...naoKin.extras.shapes.keys()].sort()) === JSON.stringify(expected)"
    live.show_targets({})
    # What is drawn for a movement alone has a shape of its own.
    page.run("() => { naoKin.studio.alwaysFine = true; }")
    before = page.run(memory)
    for count in (5, 50, 500):
        live.add_points("cloud", _rows(count))
        live.add_line("way", _rows(count))
        live.add_mesh("ring", *(lambda m: (m.vertices, m.faces))(trimesh.creation.torus(0.2, 0.05)))
    page.tab.wait_for_function("() => naoKin.extras.shapes.get('cloud')?.geometry.attributes.position.count === 500")
    page.tab.wait_for_function(names, arg=["cloud", "ring", "way"])
    assert page.run(memory)["geometries"] == before["geometries"] + 4
    live.remove("way")
    page.tab.wait_for_function(names, arg=["cloud", "ring"])
    live.remove("cloud")
    live.remove("ring")
    page.tab.wait_for_function(names, arg=[])
    assert page.run(memory) == before
    page.run("() => { naoKin.studio.alwaysFine = false; }")
    with pytest.raises(UnknownName, match="unknown shape 'cloud'"):
        live.remove("cloud")


# --- what pages do ----------------------------------------------------------------------------------------------------


def test_a_slider_calls_back_until_told_otherwise(page: Page, live: Viewer, nao: nk.NaoModel) -> None:
    live.display(nao.posture("StandInit"))
    page.tab.wait_for_function("(x) => naoKin.q[3] === x", arg=float(nao.posture("StandInit")[3]))
    heard: list[tuple[np.ndarray, tuple[str, ...]]] = []
    threads = set()

    def note(q: np.ndarray, joints: tuple[str, ...]) -> None:
        threads.add(threading.current_thread().name)
        heard.append((q.copy(), joints))
        q[:] = np.nan  # a copy

    subscription = live.on_change(note)
    page.slider("HeadYaw").focus()
    page.tab.keyboard.press("ArrowRight")
    assert until(lambda: len(heard) > 0)
    q, joints = heard[-1]
    assert joints == ("HeadYaw",)
    assert np.array_equal(q, page.q)
    assert np.array_equal(live.q, q)
    page.tab.get_by_role("button", name="Crouch", exact=True).click()
    assert until(lambda: np.array_equal(heard[-1][0], nao.posture("Crouch")))
    assert set(heard[-1][1]) > {"HeadYaw", "LKneePitch"}
    assert threads == {"nao_kin viewer changes"}
    subscription.remove()
    subscription.remove()
    count = len(heard)
    page.tab.get_by_role("button", name="Stand", exact=True).click()
    assert until(lambda: np.array_equal(live.q, nao.posture("Stand")))
    live.display(nao.posture("Crouch"))
    time.sleep(0.1)
    assert len(heard) == count


@pytest.mark.full
def test_a_button_of_one_page_is_known_here_and_in_the_other_page(browser: Any, page: Page, live: Viewer) -> None:
    assert live.shown["com"] is False
    with opened(browser, live.url) as other:
        page.switch("Centre of mass")
        assert until(lambda: live.shown["com"] is True)
        other.tab.wait_for_function("() => naoKin.toggles.shown.com")
        other.switch("Centre of mass")
        page.tab.wait_for_function("() => !naoKin.toggles.shown.com")
        assert live.shown["com"] is False
        live.show_joint_axes()
        assert live.shown["axes"] is True
        for each in (page, other):
            each.tab.wait_for_function("() => naoKin.toggles.shown.axes")
        other.switch("Joint axes")
        page.tab.wait_for_function("() => !naoKin.toggles.shown.axes")
    live.show_frames(["LArm"])
    assert live.shown["frames"] is True
    page.tab.wait_for_function("() => naoKin.frames.triads.length === 1")
    page.switch("None")
    assert until(lambda: live.shown["frames"] is False)
    with opened(browser, live.url) as late:
        assert late.run("() => naoKin.frames.triads.length") == 0
    live.show_frames(["LArm", "RArm"])  # shown again, also to pages that come later
    with opened(browser, live.url) as late:
        assert late.run("() => naoKin.frames.triads.length") == 2
    live.show_frames([])


def test_a_clip_plays_that_follows_a_configuration_or_another_clip(page: Page, live: Viewer, nao: nk.NaoModel) -> None:
    plays = "(end) => { const { playback } = naoKin.player; return playback?.duration === end && playback.playing; }"
    for _ in range(3):
        live.display(nao.posture("Stand"))
        for fps in (0.1, 0.2):
            live.animate([nao.posture("Stand"), nao.posture("Crouch")], fps=fps)
            page.tab.wait_for_function(plays, arg=1.0 / fps)
        live.display(nao.posture("Sit"))
        page.tab.wait_for_function("() => !naoKin.player.loaded")
        page.tab.wait_for_function("(q) => q.every((x, i) => naoKin.q[i] === x)", arg=nao.posture("Sit").tolist())


@pytest.mark.full
def test_a_page_that_opens_when_a_slider_has_stopped_the_clip_does_not_play_it(
    browser: Any, page: Page, live: Viewer, nao: nk.NaoModel
) -> None:
    live.animate([nao.posture("Stand"), nao.posture("Crouch")], fps=0.1)
    page.tab.wait_for_function("() => naoKin.player.playback?.playing && naoKin.player.time > 0")
    page.type_number("HeadYaw", "20")
    assert until(lambda: bool(np.isclose(live.q[0], np.radians(20.0))))
    with opened(browser, live.url) as late:
        assert np.array_equal(late.q, live.q)
        assert late.run("() => [naoKin.player.loaded, naoKin.player.playback.playing]") == [True, False]
    live.animate([nao.posture("Stand"), nao.posture("Crouch")], fps=0.1)
    with opened(browser, live.url) as late:
        late.tab.wait_for_function("() => naoKin.player.playback?.playing && naoKin.player.time > 0")
    live.display(nao.posture("Stand"))
    page.tab.wait_for_function("() => !naoKin.player.loaded")


@pytest.mark.full
def test_of_two_pages_that_play_a_clip_callbacks_hear_one(
    browser: Any, page: Page, live: Viewer, nao: nk.NaoModel
) -> None:
    clip = np.tile(nao.posture("Stand"), (101, 1))
    clip[:, 0] = np.linspace(-1.0, 1.0, 101)
    heard: list[float] = []
    subscription = live.on_change(lambda q, joints: heard.append(q[0]))
    live.animate(clip, fps=10.0, loop=False)
    assert until(lambda: len(heard) > 2)
    with opened(browser, live.url) as late:  # its clip begins anew
        late.tab.wait_for_timeout(800)
        assert late.q[0] < page.q[0] - 0.1
        assert len(heard) > 6
        begun = heard[heard.index(min(heard)) :]  # the page may still tell where it was before
        assert begun == sorted(begun)
        # Now this one is the one that somebody uses.
        late.tab.get_by_label("Time").focus()
        late.tab.keyboard.press("Home")
        assert until(lambda: live.q[0] < -0.99)
    subscription.remove()
    live.display(nao.posture("Stand"))


def test_what_is_shown_is_recorded_as_a_motion(page: Page, live: Viewer, nao: nk.NaoModel) -> None:
    live.display(nao.posture("StandInit"))
    with live.record(fps=50.0) as taken:
        time.sleep(0.3)
        live.display(nao.posture("Crouch"))
        page.tab.wait_for_function("(x) => naoKin.q[5] === x", arg=float(nao.posture("Crouch")[5]))
        page.slider("HeadYaw").focus()
        page.tab.keyboard.press("ArrowRight")
        assert until(lambda: live.q[0] != nao.posture("Crouch")[0])
        last = live.q
    live.display(nao.posture("Stand"))
    assert np.array_equal(taken.q[0], nao.posture("StandInit"))
    assert np.array_equal(taken.q[-1], last)
    motion = taken.motion
    assert isinstance(motion, nk.Motion)
    assert motion.joint_names == nao.joint_names
    assert motion.start == 0.0
    assert motion.end == pytest.approx(taken.times[-1])
    assert np.allclose(motion.sample(0.2), nao.posture("StandInit"))  # it stood still until it moved
    assert len(taken.times) < 30
