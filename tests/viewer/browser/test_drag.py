"""Dragging hands, feet and gaze in the page with a real pointer, and ghosts."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loops import full
from viewer_pages import Page, opened, read_png

import nao_kin as nk
from nao_kin.viewer import Viewer

SIZE = (1100, 640)

# Where on the screen a handle is, moved by so much in the world (y up).
ON_SCREEN = """([frame, by]) => {
    naoKin.settle();
    const { knob } = naoKin.drag.handles.find(({ limb }) => limb.frame === frame);
    const { Vector3 } = MeshCat.THREE;
    const { camera } = naoKin.drag;
    const { x, y } = knob.getWorldPosition(new Vector3()).add(new Vector3(...by)).project(camera);
    const { left, top, width, height } = document.getElementById("pane").getBoundingClientRect();
    return [left + (1 + x) / 2 * width, top + (1 - y) / 2 * height];
}"""
DISTANCE = "() => naoKin.viewer.camera.position.distanceTo(naoKin.viewer.controls.target)"
CAMERA = "() => naoKin.drag.camera.matrixWorld.elements"
ROOT = "() => naoKin.robot.root.matrixWorld.elements"


def on_screen(page: Page, frame: str, by: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> np.ndarray:
    return np.array(page.run(ON_SCREEN, [frame, list(by)]))


def drag(page: Page, frame: str, by: Any, steps: int = 8) -> np.ndarray:
    """Press on a handle, move it by some pixels in steps, and hold it; return the position of the pointer."""
    start = on_screen(page, frame)
    page.tab.mouse.move(*start)
    page.tab.mouse.down()
    page.tab.mouse.move(*(start + by), steps=steps)
    return start + np.array(by)


def said(page: Page) -> str:
    line = page.tab.locator("#drag")
    return str(line.inner_text()) if line.is_visible() else ""


def assert_consistent(page: Page, nao: nk.NaoModel) -> np.ndarray:
    """Check that the picture agrees with the joint values and that these are inside all limits; return them."""
    q = page.q
    frames = nao.semantics.end_effectors
    assert np.abs(page.poses(frames) - nao.fk(q, frames)).max() < 1e-6
    assert nao.within_limits(q)
    return q


@pytest.mark.parametrize(("frame", "by"), [("LLeg", (1, -66)), *full(("RLeg", (34, -54)), ("Torso", (-39, 39)))])
def test_a_search_that_begins_anew_stays_inside_the_coupled_limits(
    page: Page, nao: nk.NaoModel, frame: str, by: tuple[int, int]
) -> None:
    drag(page, frame, by)
    page.tab.wait_for_timeout(200)
    assert_consistent(page, nao)
    page.tab.mouse.up()


@pytest.mark.parametrize("frame", ["LArm", *full("RArm")])
@pytest.mark.parametrize(("camera", "by"), [("three-quarter", (0.0, 0.05, 0.0)), ("side", (0.048, 0.014, 0.0))])
def test_a_hand_dragged_five_centimetres_is_under_the_pointer(
    page: Page, nao: nk.NaoModel, frame: str, camera: str, by: tuple[float, float, float]
) -> None:
    page.tab.get_by_role("button", name=camera, exact=True).click()
    before = page.q
    pointer = drag(page, frame, on_screen(page, frame, by) - on_screen(page, frame))
    assert said(page) == ""
    assert np.abs(on_screen(page, frame) - pointer).max() < 0.1
    q = assert_consistent(page, nao)
    moved = {nao.joint_names[column] for column in np.flatnonzero(np.abs(q - before) > 1e-9)}
    assert moved <= set(nao.chains[frame])
    T, T_before = nao.fk(q, frame), nao.fk(before, frame)
    assert np.linalg.norm(T[:3, 3] - T_before[:3, 3]) == pytest.approx(0.05, abs=3e-3)
    # It turns less than by moving the shoulder alone, or the elbow alone.
    assert nk.rotations.natural_invariants(T_before[:3, :3].T @ T[:3, :3])[1] < 0.5
    for joint in nao.chains[frame]:
        shown = float(page.slider(joint).input_value())
        assert shown == pytest.approx(q[nao.joint_names.index(joint)], abs=1e-6)
    page.tab.mouse.up()
    assert np.array_equal(page.q, q)
    assert said(page) == ""


def test_with_shift_a_handle_moves_up_and_down_only(page: Page) -> None:
    start = on_screen(page, "LArm")
    page.tab.keyboard.down("Shift")
    drag(page, "LArm", (25, -30))
    page.tab.keyboard.up("Shift")
    assert on_screen(page, "LArm") - start == pytest.approx([0.0, -30.0], abs=0.2)
    page.tab.mouse.up()


@pytest.mark.parametrize(("frame", "by"), [("LArm", (250, 0)), ("RLeg", (-250, -30))])
def test_out_of_reach_the_limb_stays_at_the_nearest_and_the_page_says_how_far_it_is(
    page: Page, nao: nk.NaoModel, frame: str, by: tuple[int, int]
) -> None:
    start = on_screen(page, frame)
    drag(page, frame, by)
    found = re.fullmatch(rf"{frame}: out of reach by (\d+) mm(: .* stops at .*)?", said(page))
    assert found
    assert int(found[1]) > 20
    assert page.tab.locator("#drag").get_attribute("aria-live") == "polite"
    q = assert_consistent(page, nao)
    assert np.abs(q - nao.posture("StandInit")).max() > 0.05
    towards = on_screen(page, frame) - start
    assert towards @ by > 0.0
    page.tab.mouse.up()
    assert said(page) == ""
    assert np.array_equal(page.q, q)


def test_a_hand_that_is_stopped_where_it_need_not_be_swings_there_in_small_steps(page: Page, nao: nk.NaoModel) -> None:
    page.set(nao.random(168))
    page.run("""() => {
        window.shown = [[...naoKin.q]];
        window.note = () => shown.push([...naoKin.q]);
        naoKin.addEventListener("settled", note);
    }""")
    pointer = drag(page, "RArm", (-56, -75))
    assert said(page) == ""
    page.tab.wait_for_function("() => naoKin.drag.held.gesture.q.every((value, k) => value === naoKin.q[k])")
    page.run("() => naoKin.removeEventListener('settled', note)")
    assert np.abs(on_screen(page, "RArm") - pointer).max() < 0.1
    assert_consistent(page, nao)
    assert np.abs(np.diff(page.run("() => shown"), axis=0)).max() == pytest.approx(0.6, abs=1e-9)
    page.tab.mouse.up()


def test_a_foot_keeps_its_orientation_and_the_other_its_place(page: Page, nao: nk.NaoModel) -> None:
    page.slide("LHipYawPitch", -0.3)
    before = nao.fk(page.q, ("LLeg", "RLeg"))
    root = page.run(ROOT)
    pointer = drag(page, "LLeg", (30, -25))
    left, right = nao.fk(assert_consistent(page, nao), ("LLeg", "RLeg"))
    assert np.abs(on_screen(page, "LLeg") - pointer).max() < 0.1
    assert np.abs(left[:3, :3] - before[0, :3, :3]).max() < 1e-6
    assert np.linalg.norm(left[:3, 3] - before[0, :3, 3]) > 0.02
    assert np.abs(right[:3, 2:] - before[1, :3, 2:]).max() < 1e-6
    # What the shared motor leaves: a turn about the normal of the sole, in the line.
    found = re.fullmatch(r"LLeg: RLeg turns by (-?[\d.]+)° with RHipYawPitch", said(page).replace("−", "-"))
    assert found
    E = before[1, :3, :3].T @ right[:3, :3]
    assert float(found[1]) == pytest.approx(math.degrees(math.atan2(E[1, 0], E[0, 0])), abs=0.06)
    assert abs(float(found[1])) > 0.3
    # The trunk stays while the foot is held, and stands on the floor when it is let go.
    assert page.run(ROOT) == root
    page.tab.mouse.up()
    assert page.run("() => (naoKin.settle(), naoKin.robot.lowest())") == pytest.approx(0.0, abs=3e-4)


def test_a_foot_stops_at_the_floor(page: Page, nao: nk.NaoModel) -> None:
    page.tab.get_by_role("button", name="side", exact=True).click()
    root = page.run(ROOT)
    drag(page, "LLeg", (10, 60))
    assert_consistent(page, nao)
    assert page.run(ROOT) == root
    assert page.run("() => (naoKin.settle(), naoKin.robot.lowest())") == pytest.approx(0.0, abs=2e-4)
    assert said(page).startswith("LLeg: stands on the floor")
    page.tab.mouse.up()


# The place of a ring's point on the screen, so far round about its axis.
ON_RING = """([axis, angle]) => {
    const ring = naoKin.drag.rings.find((one) => one.axis.axis[axis] === 1);
    const radius = ring.mesh.geometry.parameters.radius;
    ring.mesh.updateWorldMatrix(true, false);
    const point = new MeshCat.THREE.Vector3(radius * Math.cos(angle), radius * Math.sin(angle), 0);
    const { clientX, clientY } = naoKin.pick.viewport.place(ring.mesh.localToWorld(point));
    return [clientX, clientY];
}"""


def turn(page: Page, frame: str, axis: int, angles: np.ndarray) -> None:
    """Select a handle, grab its ring about an axis and move along the ring as it is at the start."""
    page.tab.mouse.click(*on_screen(page, frame))
    places = [page.run(ON_RING, [axis, float(angle)]) for angle in angles]
    page.tab.mouse.move(*places[0])
    page.tab.mouse.down()
    for place in places[1:]:
        page.tab.mouse.move(*place)


PLACED = """(frames) => (naoKin.settle(), frames.map((frame) => {
    const { robot } = naoKin;
    return [...robot.fromWorld().multiply(robot.frameNode(frame).matrixWorld).transpose().elements];
}))"""
"""Poses of frames relative to the floor."""


def test_the_torso_is_dragged_and_turned_while_both_soles_stay(page: Page, nao: nk.NaoModel) -> None:
    feet = ("LLeg", "RLeg")
    before, soles = page.q, np.array(page.run(PLACED, feet))
    pointer = drag(page, "Torso", (10, 40))
    assert said(page) == ""
    assert np.abs(on_screen(page, "Torso") - pointer).max() < 0.1
    q = assert_consistent(page, nao)
    assert np.abs(np.array(page.run(PLACED, feet)) - soles).max() < 1e-6
    closed = nk.ik.legs(nao, *nao.fk(q, feet), near=before)
    assert closed.success
    assert np.abs(np.asarray(closed.q) - q).max() < 1e-5
    assert {nao.joint_names[k] for k in np.flatnonzero(q != before)} <= {*nao.chains["LLeg"], *nao.chains["RLeg"]}
    torso = on_screen(page, "Torso")
    page.tab.mouse.up()
    # The robot's place on the floor is that of its root; the camera goes along, so that the picture stays.
    assert np.array_equal(page.q, q)
    assert np.abs(on_screen(page, "Torso") - torso).max() < 0.1
    assert page.run("() => naoKin.robot.lowest()") == pytest.approx(0.0, abs=3e-4)
    assert np.array(page.run(PLACED, ["torso"]))[0, [3, 7]].tolist() == [0.0, 0.0]
    assert page.tab.get_by_label("Reference frame").evaluate("(select) => select.value") == "floor"
    page.tab.keyboard.press("ControlOrMeta+z")
    assert np.array_equal(page.q, before)
    # What stops it: a limit, or a leg that is straight.
    drag(page, "Torso", (0, 150), steps=2)
    assert re.fullmatch(r"Torso: out of reach by \d+ mm: .*(Knee|Ankle)Pitch stops at \S+°.*", said(page))
    page.tab.keyboard.press("Escape")
    assert np.array_equal(page.q, before)
    assert np.abs(np.array(page.run(PLACED, feet)) - soles).max() < 1e-9
    page.tab.mouse.up()
    drag(page, "Torso", (0, -150), steps=2)
    assert re.fullmatch(r"Torso: out of reach by \d+ mm", said(page))
    assert np.abs(np.array(page.run(PLACED, feet)) - soles).max() < 1e-4
    page.tab.keyboard.press("Escape")
    page.tab.mouse.up()
    turn(page, "Torso", 1, np.array([-0.7, -0.65, -0.6]))
    assert np.abs(np.array(page.run(PLACED, feet)) - soles).max() < 1e-6
    R, R_before = np.array(page.run(PLACED, ["torso"])).reshape(4, 4)[:3, :3], np.eye(3)
    about, angle = nk.rotations.natural_invariants(R_before.T @ R)
    assert abs(about[1]) == pytest.approx(1.0, abs=1e-4)
    assert angle == pytest.approx(0.1, abs=0.01)
    page.tab.mouse.up()


def test_the_torso_is_lowered_and_leans_by_keys(page: Page, nao: nk.NaoModel) -> None:
    feet = ("LLeg", "RLeg")
    before, soles = page.q, np.array(page.run(PLACED, feet))
    page.tab.get_by_role("button", name="front", exact=True).click()
    page.tab.locator("#handles").get_by_role("button", name="Torso").focus()
    page.tab.keyboard.press("Shift+ArrowDown")
    found = re.fullmatch(r"Torso, at (\S+), (\S+), (\S+) mm in its place before", said(page).replace("−", "-"))
    assert found
    assert np.linalg.norm(np.array(found.groups(), float)) == pytest.approx(10.0, abs=1.0)
    page.tab.keyboard.press("y")
    assert said(page) == "Torso turned by 1.0° about y"
    assert np.abs(np.array(page.run(PLACED, feet)) - soles).max() < 1e-6
    page.tab.keyboard.press("Enter")
    assert np.abs(page.q - before).max() > 0.02
    assert nao.within_limits(page.q)


@pytest.mark.full
@pytest.mark.parametrize(("frame", "axis"), [("LLeg", 2), ("RLeg", 2), ("RLeg", 1)])
def test_a_ring_turns_a_foot_about_its_axis_at_its_place(page: Page, nao: nk.NaoModel, frame: str, axis: int) -> None:
    other = {"LLeg": "RLeg", "RLeg": "LLeg"}[frame]
    before = nao.fk(page.q, (frame, other))
    root = page.run(ROOT)
    turn(page, frame, axis, np.linspace(-0.9, -0.5, 13))
    after = nao.fk(assert_consistent(page, nao), (frame, other))
    E = before[0, :3, :3].T @ after[0, :3, :3]
    about, angle = nk.rotations.natural_invariants(E)
    assert abs(about[axis]) == pytest.approx(1.0, abs=1e-6)
    assert float(angle * about[axis]) == pytest.approx(0.4, abs=0.01)
    assert np.abs(after[0, :3, 3] - before[0, :3, 3]).max() < 1e-5
    assert np.abs(after[1, :3, 2:] - before[1, :3, 2:]).max() < 1e-5
    assert page.run(ROOT) == pytest.approx(root, abs=1e-12)
    page.tab.mouse.up()
    assert page.run("() => naoKin.pick.selection.frame") == frame


@pytest.mark.parametrize("kind", ["page", *full("phone")])
def test_the_read_out_is_always_in_view_and_follows_what_is_clicked(
    request: pytest.FixtureRequest, nao: nk.NaoModel, kind: str
) -> None:
    page = request.getfixturevalue(kind)
    size = page.size if kind == "phone" else (1400, 900)
    page.reset(nao.posture("StandInit"), size)
    tab = page.tab
    click = tab.touchscreen.tap if kind == "phone" else tab.mouse.click
    card = tab.locator(".readout")

    def reads(frame: str, reference: str = "Torso") -> None:
        box = card.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= size[0]
        assert box["y"] + box["height"] <= size[1]
        chosen = "(select) => select.selectedOptions[0].text"
        assert tab.get_by_label("Frame", exact=True).evaluate(chosen) == frame
        assert tab.get_by_label("Reference frame").evaluate(chosen) == reference
        x = nao.fk(np.array(tab.evaluate("() => [...naoKin.q]")), frame, reference=reference)[0, 3]
        assert card.get_by_label("x", exact=True).inner_text() == f"{1000 * x:.1f} mm".replace("-", "−")
        assert tab.evaluate("() => naoKin.player.plots.frame") == frame

    reads("LArm")
    click(*tab.evaluate(ON_SCREEN, ["RLeg", [0, 0, 0]]))
    reads("RLeg")
    click(*tab.evaluate(ON_SCREEN, ["RArm", [0, 0, 0]]))
    reads("RArm")
    # A hand that is dragged is read, and the rings of the other stay.
    start = np.array(tab.evaluate(ON_SCREEN, ["LArm", [0, 0, 0]]))
    tab.mouse.move(*start)
    tab.mouse.down()
    tab.mouse.move(*(start - 12.0), steps=4)
    reads("LArm")
    tab.mouse.up()
    click(*tab.evaluate(ON_RING, [1, 0.3]))
    reads("RArm")
    tab.get_by_label("Frame", exact=True).select_option("LHand")
    tab.get_by_label("Reference frame").select_option("LForeArm")
    reads("LHand", "LForeArm")
    tab.get_by_label("Reference frame").select_option("root")
    tab.get_by_role("button", name="Measure", exact=True).click()
    for frame in ("LLeg", "RLeg"):
        click(*tab.evaluate(ON_SCREEN, [frame, [0, 0, 0]]))
    assert card.get_by_label("distance").inner_text() == "100.0 mm"
    assert card.get_by_label("Δy").inner_text() == "−100.0 mm"
    assert card.bounding_box()["y"] + card.bounding_box()["height"] <= size[1]
    tab.keyboard.press("Escape")
    reads("LHand")


def test_a_ring_stops_where_the_limb_does_and_escape_gives_back(page: Page, nao: nk.NaoModel) -> None:
    before = page.q
    turn(page, "LLeg", 2, np.linspace(-0.6, 1.4, 30))
    q = assert_consistent(page, nao)
    assert np.abs(q - before).max() > 0.1
    assert re.fullmatch(r"LLeg: \w+ stops at \S+°.*", said(page))
    page.tab.keyboard.press("Escape")
    assert np.array_equal(page.q, before)
    page.tab.mouse.up()


@pytest.mark.parametrize(("axis", "angle"), [(1, 0.2), (2, 0.06)])
def test_the_rings_of_a_hand_turn_its_forearm(page: Page, nao: nk.NaoModel, axis: int, angle: float) -> None:
    before = nao.fk(page.q, "LArm")
    # Beyond what is wanted, and back: the pointer may be where the arm does not follow.
    turn(page, "LArm", axis, np.array([-0.7, -0.6, -0.5, -0.3, -0.5, -0.7 + angle]))
    after = nao.fk(assert_consistent(page, nao), "LArm")
    assert np.abs(after[:3, 3] - before[:3, 3]).max() < 1e-5
    assert said(page) == ""
    turned = nk.rotations.matrix_from_natural(before[:3, axis], angle) @ before[:3, 0]
    assert np.abs(after[:3, 0] - turned).max() < 0.03
    assert page.run("() => naoKin.drag.rings.length") == 3
    page.tab.mouse.up()
    page.tab.keyboard.press("Escape")
    assert page.run("() => naoKin.drag.rings.length") == 0


def test_the_camera_looks_at_what_is_dragged(page: Page, nao: nk.NaoModel) -> None:
    before = page.q
    pointer = drag(page, "CameraTop", (50, 30))
    q = assert_consistent(page, nao)
    moved = {nao.joint_names[column] for column in np.flatnonzero(np.abs(q - before) > 1e-9)}
    assert moved == {"HeadYaw", "HeadPitch"}
    # The pointer is on the picture of the optical axis.
    axis = page.run("""() => {
        const { mark, ahead } = naoKin.drag.handles.find(({ limb }) => limb.frame === "CameraTop");
        const { left, top, width, height } = document.getElementById("pane").getBoundingClientRect();
        return [0.5, 1.5].map((share) => {
            const at = new MeshCat.THREE.Vector3(share * ahead, 0, 0).applyMatrix4(mark.matrixWorld);
            const { x, y } = at.project(naoKin.drag.camera);
            return [left + (1 + x) / 2 * width, top + (1 - y) / 2 * height];
        });
    }""")
    along = np.subtract(axis[1], axis[0])
    normal = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    assert abs(normal @ (pointer - axis[0])) < 0.1
    page.tab.mouse.up()


@pytest.mark.parametrize("by", [(-300, 60), (120, -40)])
def test_the_handle_of_the_gaze_stays_under_the_pointer_while_it_is_held(page: Page, by: tuple[int, int]) -> None:
    pointer = drag(page, "CameraTop", by)
    assert np.abs(on_screen(page, "CameraTop") - pointer).max() < 0.1
    page.tab.mouse.up()
    handle = "() => naoKin.drag.handles.find(({ limb }) => limb.frame === 'CameraTop')"
    assert page.run(f"() => {{ const {{ knob, ahead }} = ({handle})(); return knob.position.x === ahead; }}")


def test_the_camera_turns_about_the_robot_where_no_handle_is(page: Page, nao: nk.NaoModel) -> None:
    def orbited(start: Any) -> bool:
        before = np.array(page.run(CAMERA))
        page.tab.mouse.move(*map(float, start))
        page.tab.mouse.down()
        page.tab.mouse.move(*np.add(start, (80, 20)).tolist(), steps=4)
        page.tab.mouse.up()
        page.animation_frames(2)
        return bool(np.abs(np.array(page.run(CAMERA)) - before).max() > 1e-3)

    q = page.q
    assert orbited((90, 560))
    assert np.array_equal(page.q, q)
    assert not orbited(on_screen(page, "LArm"))
    assert np.abs(page.q - q).max() > 0.01
    assert orbited((90, 560))
    # With the handles hidden there is nothing to hold.
    assert not page.switch("Handles")
    q = page.q
    assert orbited(on_screen(page, "LArm"))
    assert np.array_equal(page.q, q)
    assert page.switch("Handles")
    assert not orbited(on_screen(page, "LArm"))


def test_a_finger_drags_a_hand_and_a_second_one_gives_both_to_the_camera(page: Page, nao: nk.NaoModel) -> None:
    start = np.add(on_screen(page, "LArm"), (15, -8))  # a finger is no needle
    q, before = page.q, on_screen(page, "LArm")
    page.touch("touchStart", start)
    page.touch("touchMove", np.add(start, (6, -20)))
    assert np.abs(on_screen(page, "LArm") - before - (6, -20)).max() < 0.2
    assert_consistent(page, nao)
    page.touch("touchStart", np.add(start, (6, -20)), (90, 560))
    assert page.run("() => naoKin.drag.held") is None
    distance = page.run(DISTANCE)
    page.touch("touchMove", np.add(start, (20, -60)), (60, 600))
    page.touch("touchEnd")
    np.testing.assert_array_equal(page.q, q)
    assert page.run(DISTANCE) < 0.95 * distance
    assert not page.run("() => naoKin.panel.past.history.past.length")
    # The next finger drags again.
    page.touch("touchStart", on_screen(page, "LArm"))
    page.touch("touchMove", np.add(on_screen(page, "LArm"), (6, -20)))
    page.touch("touchEnd")
    assert np.abs(page.q - q).max() > 0.01


@pytest.mark.full
def test_forty_pinches_over_the_robot_zoom_and_move_no_joint(phone: Page) -> None:
    rng = np.random.default_rng(5)
    handles = phone.run("() => naoKin.drag.handles.map(({ limb }) => limb.frame)")
    q = phone.q
    for number in range(40):
        # Every second one begins at a handle, where one finger would drag.
        near = on_screen(phone, str(rng.choice(handles))) + rng.uniform(-9.0, 9.0, 2)
        first = near if number % 2 else np.array([195.0, 175.0]) + rng.uniform(-80.0, 80.0, 2)
        angle, spread, moved = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(40.0, 70.0), rng.uniform(0.0, 9.0)
        way = np.array([math.cos(angle), math.sin(angle)])
        second = np.clip(first + spread * way, (10.0, 90.0), (380.0, 270.0))
        phone.touch("touchStart", first)
        phone.touch("touchMove", first - moved * way)
        phone.touch("touchStart", first - moved * way, second)
        distance = phone.run(DISTANCE)
        for step in (8.0, 16.0, 24.0):
            phone.touch("touchMove", first - (moved + step) * way, second + step * way)
        phone.touch("touchEnd")
        assert phone.run(DISTANCE) < 0.9 * distance, number
        np.testing.assert_array_equal(phone.q, q)
        phone.run("() => naoKin.camera('three-quarter')")


@pytest.mark.full
def test_what_is_dragged_in_a_live_page_is_known_to_the_program(browser: Any, nao: nk.NaoModel) -> None:
    with Viewer(nao) as viewer:
        viewer.display(nao.posture("StandInit"))
        with opened(browser, viewer.url, SIZE) as one, opened(browser, viewer.url) as other:
            drag(one, "RArm", (-10, -20))
            q = assert_consistent(one, nao)
            other.tab.wait_for_function("(x) => Math.abs(naoKin.q[19] - x) < 1e-12", arg=float(q[19]))
            assert np.array_equal(viewer.q, q)
            one.tab.mouse.up()
            assert np.array_equal(viewer.q, one.q)


@pytest.mark.full
def test_a_floating_robot_is_dragged_where_it_floats(browser: Any, tmp_path: Path) -> None:
    nao = nk.load_nao(base="floating")
    q = nao.neutral()
    q[7:] = nk.load_nao().posture("StandInit")
    q[:3], q[3:7] = [0.1, -0.2, 0.4], np.array([0.1, 0.2, -0.1, 0.9]) / np.linalg.norm([0.1, 0.2, -0.1, 0.9])
    viewer = Viewer(nao)
    viewer.display(q)
    with opened(browser, viewer.save_html(tmp_path / "floating.html"), SIZE) as page:
        pointer = drag(page, "LLeg", (5, -20))
        assert np.abs(on_screen(page, "LLeg") - pointer).max() < 0.1
        moved = page.q
        assert np.array_equal(moved[:7], q[:7])
        assert np.abs(page.poses(("LLeg",)) - nao.fk(moved, "LLeg")).max() < 1e-6
        page.tab.mouse.up()
        feet = nao.fk(moved, ("LLeg", "RLeg"))
        base = page.run("() => naoKin.drag.handles.at(-1).limb.frame")
        pointer = drag(page, base, (3, 10))
        assert np.abs(on_screen(page, base) - pointer).max() < 0.1
        page.tab.mouse.up()
        assert np.linalg.norm(page.q[:3] - q[:3]) > 0.005
        assert np.abs(nao.fk(page.q, ("LLeg", "RLeg")) - feet).max() < 1e-6


@pytest.mark.full
def test_hands_feet_and_gaze_of_a_calibrated_robot_are_dragged(browser: Any, nao: nk.NaoModel, tmp_path: Path) -> None:
    offsets = np.random.default_rng(2).normal(0.0, np.radians(1.0), nao.nq)
    mine = nao.with_offsets(
        {joint: float(value) for joint, value in zip(nao.joint_names, offsets, strict=True) if "Hand" not in joint},
        {"CameraTop": (0.0, 0.0, 0.0, 0.02, -0.03, 0.01)},
    )
    viewer = Viewer(mine)
    viewer.display(mine.posture("StandInit", limits="clamp"))
    with opened(browser, viewer.save_html(tmp_path / "calibrated.html"), SIZE) as page:
        # Both legs have the motor of the hips.
        drags = ("RArm", (12, -10), ["RArm"]), ("LLeg", (5, -20), ["LLeg", "RLeg"]), ("CameraTop", (-20, 8), ["Head"])
        for frame, by, chains in drags:
            before = page.q
            pointer = drag(page, frame, by)
            assert np.abs(on_screen(page, frame) - pointer).max() < 0.1
            page.tab.mouse.up()
            moved = np.flatnonzero(np.abs(assert_consistent(page, mine) - before) > 1e-9)
            assert moved.size
            joints = {joint for chain in chains for joint in mine.chains[chain]}
            assert {mine.joint_names[column] for column in moved} <= joints


@pytest.mark.full
def test_an_arm_of_another_kind_is_dragged_by_its_hand_and_a_selected_link(browser: Any, tmp_path: Path) -> None:
    panda = nk.load_robot("panda")
    with opened(browser, Viewer(panda).save_html(tmp_path / "panda.html"), SIZE) as page:
        assert page.run("() => naoKin.drag.handles.map(({ limb }) => limb.frame)") == ["panda_hand_tcp"]
        rows = page.tab.locator("#panel .joint").evaluate_all("(rows) => rows.map((row) => row.dataset.joint)")
        assert sorted(rows) == sorted(panda.joint_names)
        places = page.run("""() => naoKin.drag.handles[0].limb.chain.forward(naoKin.q).p""")
        assert places == pytest.approx(panda.position(page.q, "panda_hand_tcp", reference="panda_link0"), abs=1e-12)
        page.run("() => naoKin.pick.selection.select('panda_link5')")
        for frame in ("panda_hand_tcp", "panda_link5"):
            before = page.q
            pointer = drag(page, frame, (30, 20))
            q = page.q
            assert np.abs(on_screen(page, frame) - pointer).max() < 0.1
            assert np.abs(page.poses((frame,)) - panda.fk(q, frame)).max() < 1e-6
            assert panda.within_limits(q)
            moved = np.flatnonzero(q != before)
            assert set(moved) <= set(range(7 if frame == "panda_hand_tcp" else 5))
            page.tab.mouse.up()
        # It has no feet: its base stays where it is, also with the hand below the floor, where it can be dragged.
        root = page.run(ROOT)
        page.slide("panda_joint2", 1.7)
        page.slide("panda_joint4", -0.3)
        assert page.run("() => (naoKin.settle(), naoKin.robot.lowest())") < -0.01
        drag(page, "panda_hand_tcp", (0, 15))
        assert said(page) == ""
        page.tab.mouse.up()
        assert page.run(ROOT) == root


def test_a_hand_that_is_dragged_into_the_trunk_is_told_while_it_is_held(page: Page, nao: nk.NaoModel) -> None:
    page.set(nao.posture("Stand"))
    line = page.tab.locator(".body-state output").nth(1)
    assert line.inner_text() == "no links overlap"
    drag(page, "LArm", (-80, -80))
    pairs = {tuple(sorted(contact.links)) for contact in nao.collisions(page.q, exact=False)}
    assert {"torso"} < {link for pair in pairs for link in pair}
    told = f"{len(pairs)} pairs overlap" if len(pairs) > 1 else f"overlap: {', '.join(*pairs)}"
    assert line.inner_text() == told.replace("torso", "Torso")
    page.tab.mouse.up()


# --- ghosts from Python ----------------------------------------------------------------------------------------------


def ghosts_of(page: Page) -> list[tuple[str, list[float], bool]]:
    """Link, pose by rows, and whether it is drawn, of every copy."""
    return page.run("""() => (naoKin.settle(), naoKin.ghosts.group.children.map(({ userData, visible }) => [
        naoKin.robot.about.links[userData.link].name, userData.pose.clone().transpose().toArray(), visible,
    ]))""")  # type: ignore[no-any-return]


def assert_drawn_where_they_differ(page: Page, nao: nk.NaoModel, configurations: np.ndarray) -> set[tuple[int, str]]:
    """Check that every ghost link has its pose and is drawn only if it differs from the robot's; return those drawn."""
    copies, drawn, q = ghosts_of(page), set(), page.q
    per_ghost = len(copies) // len(configurations)
    for i, (link, T, visible) in enumerate(copies):
        expected = nao.fk(configurations[i // per_ghost], link)
        assert np.abs(np.reshape(T, (4, 4)) - expected).max() < 1e-6
        assert visible == bool(np.abs(expected - nao.fk(q, link)).max() > 1e-6)
        drawn |= {(i // per_ghost, link)} if visible else set()
    return drawn


@pytest.mark.full
def test_all_branches_of_a_leg_are_ghosts_in_the_file(browser: Any, nao: nk.NaoModel, tmp_path: Path) -> None:
    q = nao.posture("StandInit")
    found = nk.ik.leg(nao, "L", nao.fk(q, "LLeg"), near=q, limits="ignore")
    assert found.count == 8
    viewer = Viewer(nao)
    viewer.display(q)
    viewer.show_ghosts(found.solutions, opacity=0.4)
    with opened(browser, viewer.save_html(tmp_path / "ghosts.html")) as page:
        drawn = assert_drawn_where_they_differ(page, nao, found.solutions)
        assert {k for k, _ in drawn} == set(range(1, 8))  # the first is the robot itself
        assert not {link for _, link in drawn} & {"torso", "Head", "LBicep"}
        assert page.tab.locator("#legend").inner_text().split() == ["ghosts", *map(str, range(1, 9))]
        colours = page.run(
            "() => [...new Set(naoKin.ghosts.group.children.map((c) => c.material.color.getHex()))].length"
        )
        assert colours == 8
        page.set(nao.posture("Crouch"))  # what differed and what did not change places
        assert (0, "LThigh") in assert_drawn_where_they_differ(page, nao, found.solutions)


@pytest.mark.full
def test_ghosts_are_numbered_as_wanted_hidden_by_a_button_and_removed_by_a_drag(
    browser: Any, nao: nk.NaoModel, tmp_path: Path
) -> None:
    q = nao.posture("StandInit")
    found = nk.ik.leg(nao, "L", nao.fk(q, "LLeg"), near=q, limits="ignore")
    viewer = Viewer(nao)
    viewer.display(q)
    viewer.show_ghosts(found.solutions[1:], first=2)
    with opened(browser, viewer.save_html(tmp_path / "ghosts.html"), SIZE) as page:
        legend = page.tab.locator("#legend")
        assert legend.inner_text().split() == ["solutions", *map(str, range(1, 9)), "inside", "all", "limits"]
        assert not page.switch("Ghosts")
        assert not legend.is_visible()
        assert not page.run("() => naoKin.ghosts.group.visible")
        assert page.switch("Ghosts")
        assert legend.is_visible()
        assert page.run("() => naoKin.ghosts.group.visible")
        page.slide("HeadYaw", 0.3)  # a slider leaves them
        assert ghosts_of(page)
        drag(page, "RArm", (-10, -20))
        assert ghosts_of(page) == []
        page.tab.mouse.up()
        assert not legend.is_visible()
        assert page.run("() => naoKin.toggles.buttons.get('ghosts').hidden")


@pytest.mark.full
def test_a_picture_has_ghosts_and_no_handles(browser: Any, nao: nk.NaoModel, tmp_path: Path) -> None:
    with Viewer(nao) as viewer:
        q = nao.posture("StandInit")
        viewer.display(q)
        plain = read_png(viewer.save_png(tmp_path / "a.png", size=(320, 240)).read_bytes()).astype(int)
        raised = nao.configuration(nao.angles(q) | {"LShoulderPitch": -1.0})
        viewer.show_ghosts([raised])
        ghostly = read_png(viewer.save_png(tmp_path / "b.png", size=(320, 240)).read_bytes()).astype(int)
        with opened(browser, f"{viewer.url}?role=capture9", (320, 240)) as page:
            assert page.run("() => naoKin.drag.handles.every(({ mark }) => !mark.visible)")
    assert (np.abs(ghostly - plain).max(axis=2) > 20).mean() > 0.004
