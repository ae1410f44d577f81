"""Links under a real pointer: their tips, dragging, selecting and measuring; and handles moved by real keys."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loops import full
from made_up_robots import J, made_up
from viewer_pages import Page, opened

import nao_kin as nk
from nao_kin.viewer import Viewer

SIZE = (1100, 640)

# A place on the screen [px] at which a link is visible, as far inside its picture as a coarse grid can find.
SEEN = """(link) => {
    naoKin.settle();
    const { picker } = naoKin.pick;
    const number = naoKin.robot.about.links.findIndex(({ name }) => name === link);
    const { left, top, width, height } = document.getElementById("pane").getBoundingClientRect();
    const { Box2, Vector2 } = MeshCat.THREE;
    const box = new Box2();
    for (const { mesh } of naoKin.robot.meshes.filter((shape) => shape.link === number)) {
        const { position } = mesh.geometry.attributes;
        const vertex = new MeshCat.THREE.Vector3();
        for (let i = 0; i < position.count; i += 7) {
            const place = naoKin.pick.viewport.place(mesh.localToWorld(vertex.fromBufferAttribute(position, i)));
            box.expandByPoint(new Vector2(place.clientX, place.clientY));
        }
    }
    const origin = naoKin.pick.viewport.place(new MeshCat.THREE.Vector3().setFromMatrixPosition(
        naoKin.robot.nodes[number].matrixWorld));
    const found = [];
    for (let i = 1; i < 24; i++) for (let j = 1; j < 24; j++) {
        const x = box.min.x + (i / 24) * (box.max.x - box.min.x);
        const y = box.min.y + (j / 24) * (box.max.y - box.min.y);
        const at = { clientX: x, clientY: y, pointerType: "touch" };
        // Where a link of the limb gets a handle when it is selected, it is not seen either.
        const isFree = box.max.y - box.min.y < 40 || Math.hypot(x - origin.clientX, y - origin.clientY) > 14;
        if (isFree && !naoKin.drag.at(at) && picker.at(at)?.link === number) found.push([x, y]);
    }
    const middle = [0, 1].map((k) => found.reduce((sum, place) => sum + place[k], 0) / found.length);
    const away = (place) => Math.hypot(place[0] - middle[0], place[1] - middle[1]);
    return found.sort((a, b) => away(a) - away(b))[0] ?? null;
}"""
# The point of a link that is under a place of the screen, in the link, and where on the screen such a point is.
GRABBED = "([clientX, clientY]) => naoKin.pick.picker.at({ clientX, clientY }).local.toArray()"
SHOWN_AT = """([link, local]) => {
    const node = naoKin.robot.nodes[naoKin.robot.about.links.findIndex(({ name }) => name === link)];
    const point = node.localToWorld(new MeshCat.THREE.Vector3(...local));
    const { clientX, clientY } = naoKin.pick.viewport.place(point);
    return [clientX, clientY];
}"""
CAMERA = "() => naoKin.drag.camera.matrixWorld.elements"
LISTEN = """() => {
    window.gestures = [];
    naoKin.addEventListener("gesture", ({ detail }) => window.gestures.push(detail.held));
}"""


@pytest.fixture(scope="module")
def shared(shared: Page) -> Page:
    shared.run(LISTEN)
    return shared


@pytest.fixture
def page(page: Page) -> Page:
    """The shared page, in which nothing has been held yet."""
    page.run("() => { window.gestures.length = 0; }")
    return page


def look(page: Page, camera: str) -> None:
    page.tab.get_by_role("button", name=camera, exact=True).click()


def seen(page: Page, link: str) -> np.ndarray:
    place = page.run(SEEN, link)
    assert place is not None, f"{link} is not seen"
    return np.array(place)


def press(page: Page, place: Any, by: Any, steps: int = 10) -> None:
    """Press and move, in steps, and hold."""
    page.tab.mouse.move(*map(float, place))
    page.tab.mouse.down()
    page.tab.mouse.move(*map(float, np.add(place, by)), steps=steps)


def pull(page: Page, link: str, by: Any, steps: int = 10) -> None:
    """Select a link by a click, press and move, in steps, and hold."""
    place = seen(page, link)
    page.tab.mouse.click(*place)
    press(page, place, by, steps)


def said(page: Page) -> str:
    line = page.tab.locator("#drag")
    return _plain(line.inner_text()) if line.is_visible() else ""


def tip(page: Page) -> str:
    page.animation_frames(2)
    card = page.tab.locator(".tip")
    return _plain(card.inner_text()) if card.is_visible() else ""


def _plain(text: str) -> str:
    """Replace typographic signs and spaces by those of a keyboard."""
    return text.replace("\u00a0", " ").replace("−", "-")


def moved(nao: nk.RobotModel, before: np.ndarray, after: np.ndarray) -> set[str]:
    return {nao.joint_names[column] for column in np.flatnonzero(np.abs(after - before) > 1e-9)}


def test_a_click_on_a_link_marks_its_joint_whose_row_lights_the_link(page: Page, nao: nk.NaoModel) -> None:
    page.run("() => (document.querySelector('#panel details').open = false)")
    page.tab.get_by_label("Filter joints").fill("Elbow")
    page.tab.mouse.click(*seen(page, "RTibia"))
    row = page.tab.locator(".joint[aria-current=true]")
    assert row.get_attribute("data-joint") == "RKneePitch"
    panel, box = (page.tab.locator(where).bounding_box() for where in ("#panel > .body", ".joint[aria-current=true]"))
    assert panel["y"] + 40 < box["y"] < panel["y"] + panel["height"] - box["height"]

    lit = """() => [[...new Set(naoKin.pick.hover.highlight.links)].map((i) => naoKin.robot.about.links[i].name),
        naoKin.axes.lit?.parent.name ?? ""]"""
    row.locator(".name").hover()
    links, axis = page.run(lit)
    assert "RTibia" in links
    assert "RThigh" not in links
    assert axis == page.run("() => naoKin.robot.nodes[naoKin.robot.linkOf('RTibia')].parent.name")
    row.locator(".name").dblclick()
    assert page.q[nao.joint_names.index("RKneePitch")] == 0.0
    page.tab.mouse.move(30, 600)
    assert page.run(lit) == [[], ""]

    page.run("() => naoKin.posture('Crouch')")
    column, crouch = nao.joint_names.index("RKneePitch"), nao.posture("Crouch")
    for back in (
        lambda: row.locator("input[type=range]").press("Delete"),
        lambda: page.slider("RKneePitch").dblclick(),
    ):
        page.slide("RKneePitch", 0.3)
        assert page.q[column] == pytest.approx(0.3)
        back()
        assert page.q[column] == crouch[column]
    assert page.run(lit)[0] == links  # the slider has the keyboard's focus
    page.tab.keyboard.press("Escape")
    page.tab.mouse.click(30, 560)
    assert row.count() == 0


# --- what is under the pointer ---------------------------------------------------------------------------------------


def test_a_link_under_the_pointer_is_told_with_its_joint_its_pair_its_value_and_its_range(
    page: Page, nao: nk.NaoModel
) -> None:
    page.tab.mouse.move(*seen(page, "LTibia"))
    column = nao.joint_names.index("LKneePitch")
    angles = (page.q[column], nao.lower[column], nao.upper[column])
    value, low, high = (f"{math.degrees(x):.1f}°" for x in angles)
    assert tip(page).splitlines() == ["LTibia", "LKneePitch", "revolute pair", f"{value}, range {low} … {high}"]
    page.slide("LKneePitch", 0.5)
    page.animation_frames(3)
    assert tip(page).splitlines()[3].startswith("28.6°, ")
    page.tab.mouse.move(30, 600)
    assert tip(page) == ""


def test_nothing_is_drawn_while_the_pointer_stays_on_a_link(page: Page) -> None:
    place = seen(page, "LThigh")
    page.tab.mouse.move(*place)
    page.animation_frames(4)
    page.tab.wait_for_function("() => !naoKin.studio.quality.moving && !naoKin.viewer.needs_render")
    drawn = page.run("() => naoKin.drawn")
    for step in range(1, 5):
        page.tab.mouse.move(*(place + 0.5 * step))
    page.animation_frames(4)
    assert page.run("() => naoKin.drawn") == drawn
    page.tab.mouse.move(*seen(page, "LTibia"))
    page.animation_frames(4)
    assert page.run("() => naoKin.drawn") > drawn


def test_what_is_found_first_is_what_a_search_through_all_triangles_finds(page: Page) -> None:
    found = page.run("""() => {
        const { Raycaster } = MeshCat.THREE;
        const { left, top, width, height } = document.getElementById("pane").getBoundingClientRect();
        const caster = new Raycaster();
        const shapes = naoKin.robot.meshes;
        const both = [];
        for (let i = 0; i < 24; i++) for (let j = 0; j < 16; j++) {
            const at = { clientX: left + width * (0.3 + 0.4 * i / 24), clientY: top + height * (0.1 + 0.85 * j / 16) };
            caster.ray.copy(naoKin.pick.viewport.ray(at));
            const [first] = caster.intersectObjects(shapes.map(({ mesh }) => mesh));
            const link = first ? shapes.find(({ mesh }) => mesh === first.object).link : null;
            const hit = naoKin.pick.picker.at(at);
            const apart = hit && first ? hit.point.distanceTo(first.point) : 0;
            both.push([link, hit ? hit.link : null, apart]);
        }
        return both;
    }""")
    assert sum(link is not None for link, _, _ in found) > 60
    assert all(link == own and apart < 1e-12 for link, own, apart in found)


# --- a link is dragged -----------------------------------------------------------------------------------------------

LINKS = [
    ("side", "LThigh", "LHipPitch", -0.3),
    ("side", "LBicep", "LShoulderRoll", 0.2),
    ("front", "Head", "HeadPitch", 0.25),
    ("three-quarter", "RTibia", "RKneePitch", 0.6),
    *full(
        ("side", "LTibia", "LKneePitch", 0.4),
        ("front", "RBicep", "RShoulderRoll", -0.3),
        ("three-quarter", "LForeArm", "LElbowRoll", -0.25),
        ("three-quarter", "Head", "HeadPitch", -0.2),
    ),
]


def on_screen(page: Page, pose: np.ndarray, local: list[float]) -> np.ndarray:
    """Return the place on the screen of a point of a link, if the link had a given pose in the root."""
    to_screen = """(point) => {
        const at = new MeshCat.THREE.Vector3(...point).applyMatrix4(naoKin.robot.root.matrixWorld);
        const { clientX, clientY } = naoKin.pick.viewport.place(at);
        return [clientX, clientY];
    }"""
    return np.array(page.run(to_screen, (pose @ [*local, 1.0])[:3].tolist()))


@pytest.mark.parametrize(("camera", "link", "joint", "angle"), LINKS)
def test_a_link_goes_with_the_pointer_by_its_own_joint_and_no_other(
    page: Page, nao: nk.NaoModel, camera: str, link: str, joint: str, angle: float
) -> None:
    look(page, camera)
    before, root, view = page.q, page.run("() => naoKin.robot.root.matrixWorld.elements"), page.run(CAMERA)
    place = seen(page, link)
    local = page.run(GRABBED, place.tolist())
    column = nao.joint_names.index(joint)
    page.tab.mouse.click(*place)
    page.tab.mouse.down()
    for share in np.linspace(0, 1, 13)[1:]:
        wanted = before.copy()
        wanted[column] += share * angle
        pointer = on_screen(page, nao.fk(wanted, link), local)
        page.tab.mouse.move(*pointer)
    q = page.q
    assert moved(nao, before, q) == {joint}
    assert nao.within_limits(q)
    assert np.abs(page.poses((link,)) - nao.fk(q, link)).max() < 1e-6
    assert page.run("() => naoKin.robot.root.matrixWorld.elements") == root
    # Where the axis is seen from the side the link rolls under the pointer, which is the same only near the front.
    assert q[column] - before[column] == pytest.approx(angle, rel=0.35)
    assert np.linalg.norm(on_screen(page, nao.fk(q, link), local) - pointer) < 0.35 * np.linalg.norm(pointer - place)
    if camera == "side" and "Pitch" in joint:
        assert q[column] - before[column] == pytest.approx(angle, abs=0.002)
    page.tab.mouse.up()
    assert np.array_equal(page.q, q)
    assert page.run(CAMERA) == pytest.approx(view, abs=1e-12)
    assert page.run("() => window.gestures") == [True, False]


def test_at_its_limit_a_joint_stops_and_the_page_says_so(page: Page, nao: nk.NaoModel) -> None:
    look(page, "side")
    place = seen(page, "LTibia")
    pull(page, "LTibia", (150, -130), 24)
    q = page.q
    column = nao.joint_names.index("LKneePitch")
    assert q[column] in (nao.lower[column], nao.upper[column])
    bound = "at least" if q[column] == nao.lower[column] else "at most"
    assert said(page) == f"LKneePitch stops: {bound} {math.degrees(q[column]):.1f}°"
    # And it comes back when the pointer does.
    page.tab.mouse.move(*place, steps=24)
    assert page.q[column] == pytest.approx(nao.posture("StandInit")[column], abs=1e-3)
    assert said(page) == ""
    page.tab.mouse.up()


def test_a_link_that_follows_another_joint_moves_both(page: Page, nao: nk.NaoModel) -> None:
    look(page, "front")
    before = page.q
    pull(page, "RPelvis", (12, 8))
    q = page.q
    assert moved(nao, before, q) == {"LHipYawPitch"}
    assert nao.within_limits(q)
    assert np.abs(page.poses(("LPelvis", "RPelvis")) - nao.fk(q, ("LPelvis", "RPelvis"))).max() < 1e-6
    page.tab.mouse.up()
    page.run("() => naoKin.camera('hands')")
    before = page.q
    pull(page, "LFinger12_link", (15, 15))
    assert moved(nao, before, page.q) == {"LHand"}
    page.tab.mouse.up()


def test_a_drag_on_a_link_of_the_selected_limb_moves_its_joint(page: Page, nao: nk.NaoModel) -> None:
    look(page, "side")
    before = page.q
    page.tab.mouse.click(*seen(page, "LForeArm"))
    for link, joint in (("LForeArm", "LElbowRoll"), ("LBicep", "LShoulderRoll"), ("l_wrist", "LWristYaw")):
        place = seen(page, link)
        page.tab.mouse.move(*place)
        page.animation_frames(2)
        assert page.tab.locator("#pane").evaluate("(pane) => pane.style.cursor") == "grab"
        press(page, place, (20, 12), 3)
        page.tab.mouse.up()
        assert moved(nao, before, page.q) == {joint}
        page.set(before)
    place = seen(page, "LThigh")
    page.tab.mouse.move(*place)
    page.animation_frames(2)
    assert page.tab.locator("#pane").evaluate("(pane) => pane.style.cursor") == ""
    for _ in range(2):  # another limb; then, nothing selected, this one too
        press(page, place, (20, 12), 3)
        page.tab.mouse.up()
        assert np.array_equal(page.q, before)
        look(page, "side")
        page.tab.keyboard.press("Escape")
        place = seen(page, "LForeArm")


@pytest.mark.full
def test_the_camera_turns_where_no_joint_is_dragged(page: Page, nao: nk.NaoModel) -> None:
    def turned(place: Any, button: str = "left", key: str | None = None) -> bool:
        view, q = np.array(page.run(CAMERA)), page.q
        if key:
            page.tab.keyboard.down(key)
        page.tab.mouse.move(*map(float, place))
        page.tab.mouse.down(button=button)
        page.tab.mouse.move(*map(float, np.add(place, (40, 15))), steps=4)
        page.tab.mouse.up(button=button)
        if key:
            page.tab.keyboard.up(key)
        page.animation_frames(2)
        kept = bool(np.array_equal(page.q, q))
        changed = bool(np.abs(np.array(page.run(CAMERA)) - view).max() > 1e-3)
        assert kept == changed
        look(page, "three-quarter")
        return changed

    assert turned((60, 560))
    page.tab.mouse.click(*seen(page, "LThigh"))
    assert turned(seen(page, "torso"))
    assert turned(seen(page, "LThigh"), "right")
    assert turned(seen(page, "LThigh"), key="Alt")
    assert not turned(seen(page, "LThigh"))


def test_a_turn_of_the_camera_may_end_over_the_panel(page: Page, nao: nk.NaoModel) -> None:
    press(page, (60, 560), (SIZE[0] - 120, -300))
    page.tab.mouse.up()
    look(page, "three-quarter")
    before = page.q
    pull(page, "LThigh", (-20, -10))
    assert moved(nao, before, page.q) == {"LHipPitch"}
    page.tab.mouse.move(SIZE[0] - 60, 300)
    page.tab.mouse.up()
    assert page.run("() => naoKin.drag.held") is None
    page.tab.mouse.move(*seen(page, "LTibia"))
    assert tip(page).startswith("LTibia")


def test_escape_gives_back_what_was_before_the_drag(page: Page, nao: nk.NaoModel) -> None:
    for place in (seen(page, "LThigh"), np.array(page.run(SHOWN_AT, ["l_gripper", [0, 0, 0]]))):
        page.run("() => { window.gestures.length = 0; }")
        before = page.q
        page.tab.mouse.click(*place)
        press(page, place, (15, -12))
        assert np.abs(page.q - before).max() > 0.01
        page.tab.keyboard.press("Escape")
        assert np.array_equal(page.q, before)
        page.tab.mouse.move(*map(float, np.add(place, (40, -40))), steps=3)
        assert np.array_equal(page.q, before)
        page.tab.mouse.up()
        assert np.array_equal(page.q, before)
        assert page.run("() => window.gestures") == [True, False]
        assert page.run("() => naoKin.viewer.controls.enabled") is True


def test_a_finger_turns_the_camera_until_the_limb_is_selected_by_a_tap(page: Page, nao: nk.NaoModel) -> None:
    def swipe(place: np.ndarray) -> None:
        page.touch("touchStart", place)
        for share in (0.3, 0.6, 1.0):
            page.touch("touchMove", place + share * np.array((30, -6)))
        page.touch("touchEnd")
        page.animation_frames(2)

    place, before, view = seen(page, "LThigh"), page.q, np.array(page.run(CAMERA))
    swipe(place)
    assert np.array_equal(page.q, before)
    assert np.abs(np.array(page.run(CAMERA)) - view).max() > 1e-3
    look(page, "three-quarter")
    assert tip(page) == ""
    page.touch("touchStart", place)
    page.touch("touchEnd")
    assert page.run("() => naoKin.pick.selection.frame") == "LThigh"
    assert tip(page).splitlines()[:2] == ["LThigh", "LHipPitch"]
    view = page.run(CAMERA)
    swipe(place)
    assert moved(nao, before, page.q) == {"LHipPitch"}
    assert page.run(CAMERA) == pytest.approx(view, abs=1e-12)
    # The other leg is not selected: there the camera turns.
    before = page.q
    swipe(seen(page, "RTibia"))
    assert np.array_equal(page.q, before)


# --- a frame is selected ---------------------------------------------------------------------------------------------


def numbers(page: Page, *names: str) -> list[float]:
    """Return the numbers of the read-out with these names, in m and rad."""
    shown = "(all) => Object.fromEntries(all.map((o) => [o.ariaLabel, Number(o.dataset.value)]))"
    values = page.tab.locator(".readout output:visible").evaluate_all(shown)
    return [values[name] for name in names]


def read(page: Page) -> str:
    """Return the frame whose pose the read-out shows."""
    frame = page.tab.get_by_label("Frame", exact=True)
    return str(frame.evaluate("(select) => select.selectedOptions[0].text"))


def all_of_the_pose(page: Page) -> None:
    more = page.tab.get_by_role("button", name="Quaternion, axis and angle, copying")
    if more.get_attribute("aria-expanded") == "false":
        more.click()


def test_a_click_selects_the_frame_of_a_link_and_another_beside_the_robot_lets_it_go(page: Page) -> None:
    page.tab.mouse.click(*seen(page, "LThigh"))
    assert read(page) == "LThigh"
    assert page.run("() => naoKin.pick.selection.triad.parent === naoKin.robot.frameNode('LThigh')")
    assert page.run("() => window.gestures") == []
    page.tab.mouse.click(60, 560)
    assert page.run("() => [naoKin.pick.selection.frame, naoKin.pick.selection.triad]") == [None, None]
    page.tab.mouse.click(*np.array(page.run(SHOWN_AT, ["l_gripper", [0, 0, 0]])))
    assert page.run("() => naoKin.pick.selection.frame") == "LArm"
    page.tab.keyboard.press("Escape")
    assert page.run("() => naoKin.pick.selection.frame") is None
    assert read(page) == "LArm"  # its pose stays to be read


def test_over_the_floor_a_sole_of_a_standing_robot_is_at_height_zero(page: Page, nao: nk.NaoModel) -> None:
    page.tab.mouse.click(*seen(page, "Head"))
    page.tab.get_by_label("Frame", exact=True).select_option("l_sole")
    page.tab.get_by_label("Reference frame").select_option("floor")
    assert numbers(page, "z", "roll", "pitch") == pytest.approx([0, 0, 0], abs=1e-3)
    page.tab.get_by_label("Reference frame").select_option("torso")


def test_what_is_copied_is_the_pose_in_metres_and_radians(page: Page, nao: nk.NaoModel) -> None:
    page.tab.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.tab.mouse.click(*seen(page, "LForeArm"))
    all_of_the_pose(page)
    T = nao.fk(page.q, "LForeArm")
    rpy = nk.rotations.rpy_from_matrix(T[:3, :3])
    for name, expected in {
        "4×4 matrix": T,
        "position6d": [*T[:3, 3], *rpy],
        "rpy": rpy,
        "quaternion": nk.rotations.quat_from_matrix(T[:3, :3]),
    }.items():
        page.tab.get_by_role("button", name=name, exact=True).click()
        page.tab.get_by_text(f"{name} copied").wait_for()
        text = page.run("() => navigator.clipboard.readText()")
        assert np.abs(np.array(eval(text, {"np": np})) - expected).max() < 1e-6
    page.tab.context.clear_permissions()


# --- measuring -------------------------------------------------------------------------------------------------------


def points(page: Page) -> list[tuple[str, list[float]]]:
    return page.run("""() => naoKin.pick.measure.ends.map(({ link, local }) =>
        [naoKin.robot.about.links[link].name, local.toArray()])""")  # type: ignore[no-any-return]


@pytest.mark.full
@pytest.mark.parametrize("way", ["shift", "button"])
def test_two_points_of_the_surface_stay_on_their_links(page: Page, nao: nk.NaoModel, way: str) -> None:
    if way == "shift":
        page.tab.keyboard.down("Shift")
    else:
        page.tab.get_by_role("button", name="Measure", exact=True).click()
    for link in ("LThigh", "Head"):
        page.tab.mouse.click(*seen(page, link))
    if way == "shift":
        page.tab.keyboard.up("Shift")
    (one, p), (other, r) = points(page)
    assert (one, other) == ("LThigh", "Head")
    for q in (page.q, *nao.random(8, 2)):
        page.set(q)
        a, b = ((nao.fk(q, link) @ [*local, 1.0])[:3] for link, local in ((one, p), (other, r)))
        expected = [np.linalg.norm(b - a), *(b - a)]
        assert numbers(page, "distance", "Δx", "Δy", "Δz") == pytest.approx(expected, abs=1e-6)
        label = page.run("() => naoKin.labels.owners.get(naoKin.pick.measure)[0]?.text")
        assert label == f"{1000 * np.linalg.norm(b - a):.1f} mm"
    assert page.run("() => naoKin.pick.measure.thread.visible")
    page.tab.keyboard.press("Escape")
    assert not page.tab.get_by_label("Measure from").is_visible()
    assert not page.run("() => naoKin.pick.measure.thread.visible")
    # What was a click to measure selects again.
    page.tab.mouse.click(*seen(page, "LThigh"))
    assert page.run("() => naoKin.pick.selection.frame") == "LThigh"


def test_frames_are_measured_from_the_keyboard(page: Page, nao: nk.NaoModel) -> None:
    page.tab.get_by_role("button", name="Measure", exact=True).press("Enter")
    for label, keys in (("Measure from", "LArm"), ("Measure to", "RLeg")):
        page.tab.get_by_label(label).focus()
        page.tab.keyboard.type(keys)
    q = page.q
    T_a, T_b = nao.fk(q, ("LArm", "RLeg"))
    v = T_b[:3, 3] - T_a[:3, 3]
    assert numbers(page, "distance", "Δx", "Δy", "Δz") == pytest.approx([np.linalg.norm(v), *v], abs=1e-6)
    E = nao.fk(q, "RLeg", reference="LArm")
    angle = float(nk.rotations.natural_invariants(E[:3, :3])[1])
    assert numbers(page, "angle") == pytest.approx([angle], abs=1e-6)
    page.tab.keyboard.press("Escape")
    assert page.run("() => document.activeElement.ariaLabel") == "Measure"


# --- handles by keyboard ---------------------------------------------------------------------------------------------


def test_a_hand_is_moved_by_arrow_keys_and_let_go_by_enter(page: Page, nao: nk.NaoModel) -> None:
    look(page, "side")
    before = page.q
    button = page.tab.locator("#handles").get_by_role("button", name="LArm")
    button.focus()
    page.tab.keyboard.press("ArrowUp")
    page.tab.keyboard.press("Shift+ArrowUp")
    page.tab.keyboard.press("ArrowRight")
    assert button.get_attribute("aria-pressed") == "true"
    q = page.q
    by = nao.position(q, "LArm") - nao.position(before, "LArm")
    assert np.linalg.norm(by) == pytest.approx(math.hypot(0.011, 0.001), abs=2e-4)
    assert by[2] == pytest.approx(0.011, abs=1e-3)
    assert np.abs(page.poses(("LArm",)) - nao.fk(q, "LArm")).max() < 1e-6
    x, y, z = (f"{1000 * value:.0f}" for value in nao.position(q, "LArm"))
    assert said(page).endswith(f"at {x}, {y}, {z} mm in Torso")
    page.tab.keyboard.press("Enter")
    assert np.array_equal(page.q, q)
    assert button.get_attribute("aria-pressed") == "false"
    assert page.run("() => window.gestures") == [True, False]
    assert page.run("() => document.activeElement.textContent") == "LArm"
    # The whole hold is one step of undo; what follows is another one.
    page.tab.keyboard.press("ArrowUp")
    page.slider("HeadYaw").click(position={"x": 15, "y": 5})
    for expected in (None, q, before, before):
        page.tab.keyboard.press("Control+z")
        if expected is not None:
            assert np.array_equal(page.q, expected)


@pytest.mark.parametrize(("frame", "key", "axis"), [("LLeg", "x", 0), ("LArm", "y", 1), *full(("RLeg", "z", 2))])
def test_letters_turn_a_handle_about_the_axes_of_its_frame(
    page: Page, nao: nk.NaoModel, frame: str, key: str, axis: int
) -> None:
    q = page.q
    before = nao.fk(q, frame)
    button = page.tab.locator("#handles").get_by_role("button", name=frame)
    button.focus()
    assert key.upper() in page.tab.locator(f"#{button.get_attribute('aria-describedby')}").inner_text()
    for _ in range(5):
        page.tab.keyboard.press(key)
    page.tab.keyboard.press(f"Shift+{key.upper()}")
    after = nao.fk(page.q, frame)
    assert np.abs(page.poses((frame,)) - after).max() < 1e-6
    assert np.abs(after[:3, 3] - before[:3, 3]).max() < 1e-5
    wanted = before[:3, :3] @ getattr(nk.rotations, f"rot_{key}")(np.radians(4.0))
    # Five joints turn the forearm, not the hand about it.
    assert np.abs(after[:3, 0] - wanted[:, 0]).max() < 1e-2
    if frame != "LArm":
        assert np.abs(after[:3, :3] - wanted).max() < 1e-4
    assert said(page).endswith(f"turned by 4.0° about {key}")
    assert page.run("() => naoKin.drag.rings.length") == 3
    # Moved in the same hold, it keeps its orientation; Escape undoes both.
    page.tab.keyboard.press("Shift+ArrowUp")
    assert said(page).endswith("mm in Torso")
    moved = nao.fk(page.q, frame)
    assert np.linalg.norm(moved[:3, 3] - after[:3, 3]) == pytest.approx(0.01, abs=1e-3)
    if frame != "LArm":  # which may have to turn on its way
        assert np.abs(moved[:3, :3] - after[:3, :3]).max() < 1e-5
    page.tab.keyboard.press("Escape")
    assert np.array_equal(page.q, q)
    assert page.run("() => window.gestures") == [True, False]


def test_the_tab_key_reaches_the_handles_and_leaving_one_lets_it_go(page: Page, nao: nk.NaoModel) -> None:
    page.tab.locator("#handles").get_by_role("button", name="LArm").focus()
    page.tab.keyboard.press("ArrowUp")
    page.tab.keyboard.press("Tab")
    assert page.run("() => document.activeElement.textContent") == "RArm"
    assert page.run("() => naoKin.drag.held") is None
    assert page.run("() => window.gestures") == [True, False]
    page.switch("Handles")
    assert page.tab.locator("#handles").is_hidden()
    page.switch("Handles")


# --- other robots ----------------------------------------------------------------------------------------------------

BOX = '<visual><geometry><box size="0.05 0.05 0.12"/></geometry></visual></link>'


@pytest.fixture
def crane(tmp_path: Path) -> nk.RobotModel:
    """A mast that turns, a slide along x on it, and a second slide that goes half as far the other way."""
    made_up(
        tmp_path,
        J("mast", (0.0, 0.0, 1.0), (0.0, 0.0, 0.1), limits=(-1.0, 1.0)),
        J("slide", (1.0, 0.0, 0.0), (0.0, 0.0, 0.25), kind="prismatic", limits=(-0.1, 0.2)),
        J("weight", (1.0, 0.0, 0.0), (0.0, 0.0, 0.25), kind="prismatic", parent="mast", follows=("slide", -0.5, 0.01)),
    )
    path = tmp_path / "robot.urdf"
    path.write_text(path.read_text(encoding="utf-8").replace("</link>", BOX), encoding="utf-8")
    return nk.RobotModel.from_urdf(path)


@pytest.mark.full
def test_slides_and_what_follows_them_are_dragged_along_their_axes(
    browser: Any, crane: nk.RobotModel, tmp_path: Path
) -> None:
    with opened(browser, Viewer(crane).save_html(tmp_path / "crane.html"), SIZE) as page:
        look(page, "side")
        for link, factor in (("slide_l", 1.0), ("weight_l", -0.5)):
            page.set(crane.neutral())
            place = seen(page, link)
            local = page.run(GRABBED, place.tolist())
            before = crane.fk(page.q, link)
            towards = np.array(page.run(SHOWN_AT, [link, np.add(local, (0.03, 0, 0)).tolist()])) - place
            pull(page, link, towards)
            q = page.q
            assert moved(crane, crane.neutral(), q) == {"slide"}
            assert (crane.fk(q, link) - before)[0, 3] == pytest.approx(0.03, abs=1e-3)
            assert q[crane.joint_names.index("slide")] == pytest.approx(0.03 / factor, abs=2e-3)
            assert np.abs(page.poses((link,)) - crane.fk(q, link)).max() < 1e-6
            page.tab.mouse.move(*(place + 30 * towards / np.linalg.norm(towards) * factor * 20), steps=8)
            assert said(page) == "slide stops: at most 200.0 mm"
            page.tab.mouse.up()
        # The mast turns within its limits, whose axis is seen from the side.
        page.set(crane.neutral())
        pull(page, "mast_l", (30, 0))
        assert moved(crane, crane.neutral(), page.q) == {"mast"}
        page.tab.mouse.up()
