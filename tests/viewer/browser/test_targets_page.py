"""Targets that a user drags in the page, images of cameras, and plots of the program."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viewer_pages import Page, opened, until

import nao_kin as nk

DESK, PHONE = (1400, 900), (390, 844)
# Place on the screen of a point in the frame of a target [px].
PLACE = """([name, point]) => {
    const { node } = naoKin.targets.list.find(({ row }) => row.name === name);
    node.updateWorldMatrix(true, false);
    const { clientX, clientY } = naoKin.pick.viewport.place(node.localToWorld(new MeshCat.THREE.Vector3(...point)));
    return [clientX, clientY];
}"""
# What is under a place on the screen: an axis, and whether it turns.
GRIP = """([clientX, clientY]) => {
    const found = naoKin.drag.at({ clientX, clientY, pointerType: "mouse" });
    return found && `${found.grip.axis?.name} ${found.grip.turns}`;
}"""


class Visit(Page):
    """A page with targets."""

    def place(self, name: str, point: Any = (0.0, 0.0, 0.0)) -> np.ndarray:
        return np.array(self.run(PLACE, [name, list(point)]))

    def matrix(self, name: str) -> np.ndarray:
        script = "(name) => naoKin.targets.list.find(({ row }) => row.name === name).node.matrix.elements"
        return np.reshape(self.run(script, name), (4, 4)).T

    def drag(self, start: np.ndarray, by: tuple[float, float]) -> None:
        """Press, and move there; the button stays down."""
        self.tab.mouse.move(*map(float, start))
        self.tab.mouse.down()
        self.tab.mouse.move(*map(float, start + by), steps=5)


@pytest.fixture
def live(nao: nk.NaoModel) -> Iterator[nk.Viewer]:
    with nk.Viewer(nao) as viewer:
        viewer.display(nao.posture("Stand"))
        yield viewer


@pytest.fixture
def page(browser: Any, live: nk.Viewer) -> Iterator[Visit]:
    with opened(browser, live.url, DESK, kind=Visit) as page:
        yield page


def test_the_arm_follows_a_ball_that_the_pointer_and_the_keys_move(
    page: Visit, live: nk.Viewer, nao: nk.NaoModel
) -> None:
    moves: list[np.ndarray] = []
    told: list[tuple[str, np.ndarray]] = []
    held_by = {event: (lambda T, event=event: told.append((event, T))) for event in ("on_grab", "on_release")}

    def follow(T: np.ndarray) -> None:
        moves.append(T)
        live.display(nk.ik.arm(nao, "L", T, near=live.q).q)

    before = nao.position(live.q, "LArm")
    ball = live.add_target("ball", before, on_move=follow, **held_by)
    page.tab.wait_for_function("() => naoKin.targets.list.length === 1")
    # The hand's own handle is at the same place: the ball goes first.
    page.drag(page.place("ball"), (20.0, -60.0))
    assert until(lambda: np.abs(page.matrix("ball")[:3, 3] - ball.T).max() < 1e-12)
    assert until(lambda: bool(moves) and np.array_equal(moves[-1], ball.T))
    assert np.linalg.norm(ball.T - before) > 0.03
    assert until(lambda: np.abs(page.poses(("LArm",))[0, :3, 3] - nao.position(live.q, "LArm")).max() < 1e-6)
    assert until(lambda: np.linalg.norm(nao.position(live.q, "LArm") - ball.T) < 1e-3)
    held = ball.T
    page.tab.mouse.up()
    assert until(lambda: [event for event, _ in told] == ["on_grab", "on_release"])
    assert np.array_equal([T for _, T in told], [before, held])
    # Along an arrow only one coordinate changes; Escape restores the state before.
    page.drag(page.place("ball", (0.0, 0.0, 0.05)), (0.0, -40.0))
    assert until(lambda: ball.T[2] > held[2] + 0.01)
    assert np.abs(ball.T - held)[:2].max() < 1e-9
    page.tab.keyboard.press("Escape")
    page.tab.mouse.up()
    assert until(lambda: np.allclose(ball.T, held, atol=1e-12))
    # Keys move it as they move a handle.
    page.tab.locator("#handles").get_by_role("button", name="ball").focus()
    page.tab.keyboard.press("ArrowUp")
    page.tab.keyboard.press("Shift+ArrowUp")
    x, y, z = (f"{1000 * value:.0f}" for value in page.matrix("ball")[:3, 3])
    assert page.run("() => naoKin.drag.line.textContent") == f"ball, at {x}, {y}, {z} mm in Torso".replace("-", "−")
    page.tab.keyboard.press("x")
    assert page.run("() => naoKin.drag.line.textContent") == "ball has no ring to turn"
    assert until(lambda: abs(np.linalg.norm(ball.T - held) - 0.011) < 1e-6)
    page.tab.keyboard.press("Escape")
    assert until(lambda: np.allclose(ball.T, held, atol=1e-12))
    # The program moves and removes it; the focus is not lost with the others.
    ball.place([0.2, 0.1, 0.1])
    page.tab.wait_for_function("() => naoKin.targets.list[0].node.matrix.elements[12] === 0.2")
    live.add_target("second", [0.2, 0.1, 0.2])
    page.tab.wait_for_function("() => naoKin.targets.list.length === 2")
    assert page.run("() => document.activeElement.textContent") == "ball"
    ball.remove()
    page.tab.wait_for_function("() => naoKin.targets.list.length === 1")
    assert page.tab.locator("#handles").get_by_role("button", name="ball").count() == 0
    # Without handles there is nothing to take hold of.
    page.switch("Handles")
    start = live._targets._items["second"].T
    page.drag(page.place("second"), (30.0, 30.0))
    page.tab.mouse.up()
    assert np.array_equal(live._targets._items["second"].T, start)


def test_a_pose_is_turned_by_its_rings_and_two_pages_agree(page: Visit, live: nk.Viewer, browser: Any) -> None:
    T = nk.screws.pose(nk.rotations.rot_z(0.4), [0.15, -0.25, 0.1])
    seen: list[np.ndarray] = []
    grasp = live.add_target("grasp", T, on_move=seen.append)
    page.tab.wait_for_function("() => naoKin.targets.list.length === 1")
    radius = 0.056 * page.run("() => naoKin.studio.markScale")
    ring = [page.place("grasp", radius * np.array([np.cos(a), np.sin(a), 0.0])) for a in np.arange(0.1, 6.0, 0.4)]
    # Where no other grip of it is nearer.
    start = next(i for i, place in enumerate(ring[:-2]) if page.run(GRIP, place.tolist()) == "z true")
    page.drag(ring[start], tuple(ring[start + 2] - ring[start]))
    page.tab.mouse.up()
    assert until(lambda: np.abs(grasp.T - T).max() > 0.1)
    assert until(lambda: np.allclose(page.matrix("grasp"), grasp.T, atol=1e-12))
    R = T[:3, :3].T @ grasp.T[:3, :3]
    assert np.arctan2(R[1, 0], R[0, 0]) == pytest.approx(0.8, abs=0.1)  # as far as the pointer went around
    assert abs(R[2, 2] - 1.0) < 1e-9  # about its z
    assert np.allclose(grasp.T[:3, 3], T[:3, 3], atol=1e-12)
    assert until(lambda: bool(seen) and np.array_equal(seen[-1], grasp.T))
    turned = grasp.T
    page.tab.locator("#handles").get_by_role("button", name="grasp").focus()
    for _ in range(3):
        page.tab.keyboard.press("x")
    assert page.run("() => naoKin.drag.line.textContent") == "grasp turned by 3.0° about x"
    page.tab.keyboard.press("Enter")
    wanted = turned @ nk.screws.pose(nk.rotations.rot_x(np.radians(3.0)), np.zeros(3))
    assert until(lambda: np.abs(grasp.T - wanted).max() < 1e-9)
    # A phone sees the same, and drags it with a finger.
    with opened(browser, live.url, PHONE, kind=Visit, has_touch=True, is_mobile=True) as phone:
        assert np.allclose(phone.matrix("grasp"), grasp.T, atol=1e-12)
        start = phone.place("grasp")
        phone.touch("touchStart", start)
        for step in range(1, 8):
            phone.touch("touchMove", start + step * np.array((3.0, -6.0)))
        phone.touch("touchEnd")
        assert until(lambda: np.linalg.norm(grasp.T[:3, 3] - T[:3, 3]) > 0.02)
        assert np.allclose(grasp.T[:3, :3], wanted[:3, :3], atol=1e-9)
        assert until(lambda: np.allclose(page.matrix("grasp"), phone.matrix("grasp"), atol=1e-12))


@pytest.mark.full
def test_undo_puts_a_target_back_in_a_live_page_and_in_a_saved_one(
    page: Visit, live: nk.Viewer, nao: nk.NaoModel, browser: Any, tmp_path: Path
) -> None:
    start = nao.position(live.q, "LArm")
    ball = live.add_target("ball", start, on_move=lambda T: live.display(nk.ik.arm(nao, "L", T, near=live.q).q))
    page.tab.wait_for_function("() => naoKin.targets.list.length === 1")

    def follows(place: np.ndarray) -> bool:
        """Whether the program and the page have the hand there, and agree."""
        is_there = np.linalg.norm(nao.position(live.q, "LArm") - place) < 1e-3
        return bool(is_there and np.abs(page.q - live.q).max() < 1e-9)

    page.drag(page.place("ball"), (20.0, -60.0))
    page.tab.mouse.up()
    assert until(lambda: np.array_equal(ball.T, page.matrix("ball")[:3, 3]))
    moved = ball.T
    assert until(lambda: follows(moved))
    assert np.linalg.norm(moved - start) > 0.03
    page.tab.keyboard.press("Control+z")
    assert until(lambda: np.allclose(ball.T, start, atol=1e-12))
    assert until(lambda: follows(start))
    page.tab.keyboard.press("Control+Shift+Z")
    assert until(lambda: np.allclose(ball.T, moved, atol=1e-12))
    assert until(lambda: follows(moved))
    # What the program has done to it since another step stays.
    page.tab.get_by_role("slider", name="HeadYaw").press("ArrowUp")
    assert until(lambda: abs(page.q[nao.joint_names.index("HeadYaw")] - np.radians(1.0)) < 1e-6)
    ball.place([0.2, 0.1, 0.1])
    page.tab.wait_for_function("() => naoKin.targets.list[0].node.matrix.elements[12] === 0.2")
    page.tab.get_by_role("button", name="Undo").click()
    assert until(lambda: abs(page.q[nao.joint_names.index("HeadYaw")]) < 1e-6)
    assert np.allclose(page.matrix("ball")[:3, 3], [0.2, 0.1, 0.1], atol=1e-12)
    # In a saved page nothing follows, which the page says.
    live.add_target("grasp", nk.screws.pose(nk.rotations.rot_z(0.4), [0.15, -0.25, 0.1]))
    with opened(browser, live.save_html(tmp_path / "targets.html"), DESK, kind=Visit) as saved:
        before = saved.matrix("grasp")
        # A drag that is given up is no step.
        saved.drag(saved.place("grasp"), (20.0, -60.0))
        saved.tab.keyboard.press("Escape")
        saved.tab.mouse.up()
        assert not saved.tab.get_by_role("button", name="Undo").is_visible()
        saved.drag(saved.place("grasp"), (0.0, -40.0))
        assert saved.run("() => naoKin.drag.line.textContent") == "grasp: no program follows it"
        saved.tab.mouse.up()
        dragged = saved.matrix("grasp")
        assert np.linalg.norm((dragged - before)[:3, 3]) > 0.02
        # Moved and turned by keys in one hold, all of it is given back.
        saved.tab.locator("#handles").get_by_role("button", name="grasp").focus()
        for key in ("ArrowUp", "x", "Escape"):
            saved.tab.keyboard.press(key)
        assert np.allclose(saved.matrix("grasp"), dragged, atol=1e-12)
        for _ in range(4):  # each key is a step, Escape too
            saved.tab.keyboard.press("Control+z")
        assert np.allclose(saved.matrix("grasp"), before, atol=1e-12)


def _colours(page: Any) -> list[list[int]]:
    """Colours in the middle of the four quarters of the camera view."""
    box = page.tab.locator("#eye .sight").bounding_box()
    pane = page.tab.locator("#pane").bounding_box()
    picture = page.picture()
    return [
        picture[int(box["y"] - pane["y"] + v * box["height"]), int(box["x"] - pane["x"] + u * box["width"])].tolist()
        for v in (0.25, 0.75)
        for u in (0.25, 0.75)
    ]


def test_an_image_is_in_the_camera_view_and_on_the_frustum(browser: Any, nao: nk.NaoModel, tmp_path: Path) -> None:
    image = np.zeros((48, 64, 3), np.uint8)
    corners = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 0]]
    image[:24, :32], image[:24, 32:], image[24:, :32], image[24:, 32:] = corners
    with nk.Viewer(nao) as viewer:
        viewer.show_image("CameraBottom", image)
        path = viewer.save_html(tmp_path / "image.html")
        with opened(browser, path, (640, 420)) as page:
            page.run("() => naoKin.eyes.complete()")
            assert page.run("() => naoKin.eyes.eye.name") == "CameraBottom"
            assert page.tab.locator("#eye select").input_value() == "CameraBottom"
            page.draw(True)
            page.animation_frames(3)
            assert np.abs(np.subtract(_colours(page), corners)).max() < 12
            page.draw(False)
            # The far end of the frustum has the shape of the field of view, and its upper left corner is to the left.
            flat = page.run(
                """() => {
                    const [shape] = naoKin.eyes.frustums;
                    const image = shape.children.find(({ material }) => material.map);
                    const { width, height } = image.geometry.parameters;
                    const corner = image.localToWorld(new MeshCat.THREE.Vector3(-width / 2, height / 2, 0));
                    const eye = naoKin.robot.frameNode("CameraBottom");
                    return [shape.aspect - width / height, ...eye.worldToLocal(corner).toArray()];
                }"""
            )
            assert abs(flat[0]) < 1e-9
            assert all(number > 0 for number in flat[1:])  # ahead, left, up
        with opened(browser, viewer.url) as page:
            page.run("() => naoKin.eyes.complete()")
            page.tab.locator("#eye select").select_option("CameraTop")
            assert page.run("() => naoKin.eyes.frustums.length") == 2
            page.switch("Camera view")
            viewer.show_image("CameraBottom", image[::-1])
            page.tab.wait_for_function("() => !naoKin.eyes.images.get('CameraBottom').decoding")
            assert page.run("() => naoKin.eyes.frustums.length") == 0  # a newer image does not press the button again
            viewer.show_image("CameraBottom", None)
            page.tab.wait_for_function("() => naoKin.eyes.images.size === 0")


@pytest.mark.full
def test_plots_grow_live_go_with_a_clip_and_are_in_a_saved_page(
    browser: Any, nao: nk.NaoModel, live: nk.Viewer, page: Visit, tmp_path: Path
) -> None:
    name = "</strong><img src=x onerror=alert(1)>"
    live.plot("force", {"front": 1.0, "rear": 2.0}, time=0.0)
    plots = page.tab.locator(".plots .stream")
    plots.first.wait_for()  # the first point opens the plots
    for i in range(1, 1500):
        live.plot("force", {"front": 1.0 + i, "rear": 2.0}, time=0.01 * i)
    live.plot(name, 7.0)
    page.tab.wait_for_function("() => document.querySelectorAll('.plots .stream').length === 2")
    label = plots.first.locator(".picture")
    expected = "force over 14.99 s: front from 1 to 1500, rear from 2 to 2"
    assert until(lambda: label.get_attribute("aria-label") == expected)
    assert plots.first.locator("output").all_inner_texts() == ["1500", "2"]
    assert page.tab.locator(".plots img").count() == 0
    assert plots.nth(1).locator("h3").inner_text() == name
    # In a saved page the clip and the plot have the same time.
    live.animate(np.linspace(nao.posture("Stand"), nao.posture("Crouch"), 31), fps=10, play=False)
    for i in range(31):
        live.plot("force", {"front": i, "rear": 2.0}, time=0.1 * i)
    live.plot(name, None)
    with opened(browser, live.save_html(tmp_path / "plots.html"), (1400, 900)) as saved:
        front = saved.tab.locator(".plots .stream output").first
        front.wait_for()
        box = saved.tab.locator(".plots .stream .u-over").bounding_box()
        saved.tab.mouse.click(box["x"] + box["width"] / 2, box["y"] + 20)
        time = saved.run("() => naoKin.player.time")
        assert time == pytest.approx(1.5, abs=0.05)
        assert until(lambda: front.inner_text() == str(int(time * 10 + 1e-6)))
        assert saved.q[nao.joint_names.index("LKneePitch")] == pytest.approx(
            0.5 * (nao.posture("Stand") + nao.posture("Crouch"))[nao.joint_names.index("LKneePitch")], abs=0.05
        )


@pytest.mark.full
def test_margins_are_red_where_the_robot_tips_and_are_shown_with_their_clip_only(
    browser: Any, nao: nk.NaoModel, tmp_path: Path
) -> None:
    times = np.linspace(0.0, 1.0, 31)
    pitch = -0.15 * np.sin(3.5 * np.pi * times) * np.sin(np.pi * times)
    viewer = nk.Viewer(nao)
    viewer.animate(nao.posture("Stand", LAnklePitch=pitch, RAnklePitch=pitch), play=False, balance=True)
    with opened(browser, viewer.save_html(tmp_path / "tips.html"), (1400, 900)) as page:
        plot = page.tab.locator(".plots .stream")
        plot.wait_for()
        assert "margin from −" in (plot.locator(".picture").get_attribute("aria-label") or "")
        # The middle of each of fifty columns of the plot, just below its upper edge.
        reddish = page.run(
            """() => {
                const [{ plot: { plot }, curves }] = naoKin.player.plots.streams.values();
                const { left, top } = plot.bbox;
                return Array.from({ length: 99 }, (_, i) => {
                    const x = plot.valToPos((i + 0.5) * 0.01, "x", true);
                    const [r, g, , a] = plot.ctx.getImageData(x, top + 3, 1, 1).data;
                    return [a > 0 && r > g + 60, curves.values[0][i] < 0];
                });
            }"""
        )
        agree = [drawn == negative for drawn, negative in reddish]
        assert sum(agree) >= 95  # lines of the grid and the curve itself cover some
        assert 20 < sum(drawn for drawn, _ in reddish) < 80
        page.run("() => naoKin.player.unload()")
        assert until(lambda: plot.count() == 0)
