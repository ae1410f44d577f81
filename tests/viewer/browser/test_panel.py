"""The panel of the viewer by real keys, pointers and fingers: numbers, undo, copies, links, sizes, accessibility."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loops import for_all, full
from viewer_pages import Page, opened, until, visitor

import nao_kin as nk
from nao_kin.stream.tables import read_log
from nao_kin.viewer import Viewer

SIZE = (1100, 760)
STEP = math.radians(1.0)


@pytest.fixture(scope="module")
def document(nao: nk.NaoModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    viewer = Viewer(nao)
    viewer.display(nao.posture("StandInit"))
    viewer.animate([nao.posture("StandInit"), nao.posture("Crouch")], 1.0, play=False)
    return viewer.save_html(tmp_path_factory.mktemp("viewer") / "nao.html")


@pytest.fixture(scope="module")
def shared(shared: Page) -> Page:
    shared.tab.context.grant_permissions(["clipboard-read", "clipboard-write"])
    return shared


@contextmanager
def another(browser: Any, where: Path | str, size: tuple[int, int] = SIZE, **options: Any) -> Iterator[Any]:
    """The tab of a page that nobody has used before."""
    with opened(browser, where, size, **options) as page:
        yield page.tab


def field(page: Page, joint: str) -> Any:
    return page.tab.locator(f'.joint[data-joint="{joint}"] input[type="text"]')


def note(page: Page, joint: str) -> str:
    return str(page.tab.locator(f'.joint[data-joint="{joint}"] .note').inner_text())


def press(page: Page, *keys: str) -> None:
    for key in keys:
        page.tab.keyboard.press(key)


def tool(page: Page, label: str) -> Any:
    return page.tab.get_by_role("button", name=label, exact=True)


def said(page: Page) -> str:
    page.tab.wait_for_selector("#message > span")
    return str(page.tab.locator("#message > span").inner_text())


def message_away(page: Page) -> None:
    page.run("() => naoKin.panel.messages.close()")


# --- words and icons --------------------------------------------------------------------------------------------------

# The words of the buttons with icons that can be read, and the buttons whose label lacks their word.
WORDS = """() => {
    const buttons = [...document.querySelectorAll(":is(.tools, #player .actions) .icon-button")];
    const word = (one) => one.querySelector(".word");
    return [buttons.filter((one) => one.checkVisibility() && !word(one)?.checkVisibility()).map((one) => one.ariaLabel),
        buttons.filter((one) => !one.ariaLabel.toLowerCase().includes(word(one).textContent.toLowerCase())).length];
}"""


def test_icons_have_words_on_a_touch_screen_and_where_there_is_room(page: Page, phone: Page) -> None:
    assert phone.run(WORDS) == [[], 0]
    page.tab.set_viewport_size({"width": 1440, "height": 900})
    assert page.run(WORDS) == [[], 0]
    page.tab.set_viewport_size({"width": 1000, "height": 700})
    assert page.run(WORDS)[0] == ["Record the motion", "Key frames", "Plots", "Save the motion"]
    page.tab.set_viewport_size({"width": SIZE[0], "height": SIZE[1]})


# --- the robot in the picture -----------------------------------------------------------------------------------------

CAMERA = """() => {
    const [x, y, z, a, b, c] = naoKin.panel.address.places();
    const way = [x - a, y - b, z - c];
    return [naoKin.isInSight, way.map((part) => part / Math.hypot(...way)), [x, y, z]];
}"""


def test_a_posture_stays_in_the_picture_and_the_camera_moves_only_for_that(page: Page) -> None:
    page.run("""() => {
        naoKin.camera("side");
        naoKin.viewer.camera.position.x += 0.4;  // no longer a preset
        naoKin.viewer.controls.update();
    }""")
    seen, direction, place = page.run(CAMERA)
    assert seen
    tool(page, "Crouch").click()
    assert page.run(CAMERA)[2] == pytest.approx(place)
    tool(page, "LyingBelly").click()
    seen, now, moved = page.run(CAMERA)
    assert seen
    assert now == pytest.approx(direction, abs=1e-6)
    assert moved != pytest.approx(place, abs=0.05)
    page.run("() => naoKin.camera('hands')")  # who looks at a part keeps looking at it
    place = page.run(CAMERA)[2]
    tool(page, "Sit").click()
    assert page.run(CAMERA)[2] == pytest.approx(place)


# --- own poses --------------------------------------------------------------------------------------------------------


def test_a_pose_is_kept_under_a_name_shown_again_and_removed(page: Page, nao: nk.NaoModel) -> None:
    page.slide("LShoulderPitch", 0.25)
    wanted = page.q

    def keep() -> None:
        tool(page, "+ Pose").click()
        page.tab.wait_for_function("() => document.activeElement.ariaLabel === 'Name of the pose'")

    keep()
    problem = page.tab.locator(".poses .problem")
    for name, reason in [("", "A pose needs a name."), ("Crouch", "Crouch is a posture of the robot.")]:
        page.tab.keyboard.type(name)
        press(page, "Enter")
        assert problem.inner_text() == reason
        press(page, "ControlOrMeta+A")
    page.tab.keyboard.type(' <b>"wave"</b> ')
    press(page, "Enter")
    own = tool(page, '<b>"wave"</b>')
    assert not page.tab.locator(".poses").is_visible()
    (stored,) = json.loads(page.run("() => localStorage.getItem('nao-kin.poses.nao_v6')"))
    assert stored["name"] == '<b>"wave"</b>'
    assert np.array_equal(stored["q"], wanted)

    tool(page, "Crouch").click()
    own.click()
    assert np.array_equal(page.q, wanted)
    page.slide("LShoulderPitch", 1.0)
    page.slider("LShoulderPitch").press("Delete")  # back to the pose chosen last
    assert page.q[nao.joint_names.index("LShoulderPitch")] == 0.25
    tool(page, "Undo").click()

    # Another page of the same robot removes it, and this one follows.
    page.run("""() => {
        localStorage.setItem("nao-kin.poses.nao_v6", '[{"name":"far","q":[1],"up":null}]');
        dispatchEvent(new StorageEvent("storage"));
    }""")
    assert own.count() == 0
    assert tool(page, "far").count() == 0
    keep()
    page.tab.keyboard.type("twice")
    press(page, "Enter")
    keep()
    tool(page, "Remove twice").click()
    assert page.tab.locator(".postures .own").count() == 0
    press(page, "Escape")
    assert page.run("() => localStorage.getItem('nao-kin.poses.nao_v6')") == "[]"


# --- numbers and steps ------------------------------------------------------------------------------------------------


def test_a_number_that_is_only_looked_at_stays_as_exact_as_it_was(page: Page, nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    page.edit_number("LKneePitch")
    press(page, "Tab", "Shift+Tab", "Enter", "Enter", "Enter", "Tab")
    assert np.array_equal(page.q, q)


def test_what_is_no_number_says_so_and_changes_nothing(page: Page, nao: nk.NaoModel) -> None:
    page.edit_number("HeadYaw")
    page.tab.keyboard.type("left")
    press(page, "Tab")
    number = field(page, "HeadYaw")
    assert number.get_attribute("aria-invalid") == "true"
    assert note(page, "HeadYaw") == "not a number; expected −119.5° to 119.5°"
    described = page.tab.locator(f"#{number.get_attribute('aria-describedby')}")
    assert described.inner_text() == note(page, "HeadYaw")
    assert np.array_equal(page.q, nao.posture("StandInit"))
    number.click()
    page.tab.keyboard.type("5")
    assert number.get_attribute("aria-invalid") is None
    press(page, "Enter")
    assert page.q[0] == pytest.approx(math.radians(5.0))


def test_a_number_beyond_a_limit_stops_there_and_says_so(page: Page, nao: nk.NaoModel) -> None:
    page.edit_number("HeadYaw")
    page.tab.keyboard.type("500")
    press(page, "Enter")
    assert page.q[0] == nao.upper[0]
    assert note(page, "HeadYaw") == "the limit is 119.5°"


@for_all(("key", "degrees"), [("Shift+ArrowUp", 10.0), ("Control+ArrowDown", -0.1), ("PageDown", -10.0)])
def test_keys_step_sliders_and_numbers_alike(page: Page, nao: nk.NaoModel, key: str, degrees: float) -> None:
    column = nao.joint_names.index("LKneePitch")
    for control in (page.slider("LKneePitch").focus, lambda: page.edit_number("LKneePitch")):
        q = nao.posture("StandInit")
        page.set(q)
        control()
        press(page, key)
        q[column] += math.radians(degrees)
        assert np.allclose(page.q, q, rtol=0.0, atol=1e-9)
        assert field(page, "LKneePitch").input_value() == f"{math.degrees(q[column]):.1f}"


def test_sliders_say_their_value_and_range(page: Page) -> None:
    page.slider("HeadYaw").focus()
    press(page, "ArrowRight")
    assert page.slider("HeadYaw").get_attribute("aria-valuetext") == "1.0°, from −119.5° to 119.5°"
    press(page, "End")
    assert page.slider("HeadPitch").get_attribute("aria-valuetext") == (
        "0.0°, from −38.5° to 29.5°, here from −25.7° to 18.9°"
    )


# --- units ------------------------------------------------------------------------------------------------------------


def choose(page: Page, text: str) -> None:
    tool(page, "Settings").click()
    page.tab.get_by_text(text, exact=True).click()
    press(page, "Escape")


def test_units_are_switched_everywhere_and_typed_too(page: Page, nao: nk.NaoModel) -> None:
    page.set(nao.posture("Crouch"))
    knee = nao.joint_names.index("LKneePitch")
    choose(page, "Radians")
    choose(page, "Metres")
    assert field(page, "LKneePitch").input_value() == f"{page.q[knee]:.3f}"
    limits = page.tab.locator('.joint[data-joint="LKneePitch"] .limits').inner_text().split()
    assert [float(end.replace("−", "-")) for end in limits] == pytest.approx([-0.092, 2.112], abs=1e-3)
    assert re.fullmatch(r"−?0\.\d{4} m", page.tab.locator(".readout output").all_inner_texts()[2])
    page.type_number("LKneePitch", "0.5")
    assert page.q[knee] == pytest.approx(0.5)
    choose(page, "Degrees")
    choose(page, "Millimetres")
    assert field(page, "LKneePitch").input_value() == "28.6"


@pytest.mark.full
def test_units_and_colours_are_remembered(browser: Any, document: Path) -> None:
    with visitor(browser, viewport={"width": 900, "height": 600}) as context:
        for visit in range(2):
            tab = context.new_page()
            tab.goto(document.as_uri())
            tab.wait_for_selector("body[data-ready]")
            if visit == 0:
                tab.get_by_role("button", name="Settings").click()
                tab.get_by_text("Radians", exact=True).click()
                tab.get_by_text("Dark", exact=True).click()
            assert tab.locator('.joint[data-joint="HeadYaw"] .unit').inner_text() == "rad"
            assert tab.evaluate("() => getComputedStyle(document.querySelector('#panel')).backgroundColor") == (
                "rgb(24, 28, 36)"
            )
            tab.close()


# --- the list of joints -----------------------------------------------------------------------------------------------


def test_joints_are_found_by_parts_of_their_names(page: Page) -> None:
    press(page, "/")
    page.tab.keyboard.type("knee")
    visible = "() => [...document.querySelectorAll('.joint')].filter((r) => r.offsetParent).map((r) => r.dataset.joint)"
    assert page.run(visible) == ["LKneePitch", "RKneePitch"]
    count = page.tab.locator(".joints .count")
    assert count.inner_text() == "2 of 26"
    page.tab.keyboard.type("xyz")
    assert page.run(visible) == []
    assert count.inner_text() == "0 of 26"
    assert page.tab.locator(".joints > p").inner_text() == "No joint is called “kneexyz”."
    press(page, "Escape")
    assert len(page.run(visible)) == 26
    assert count.inner_text() == ""


# --- the past ---------------------------------------------------------------------------------------------------------


def pull(page: Page, joint: str, pixels: float) -> None:
    """Take a slider's thumb with the mouse and move it in several steps."""
    # Under the read-out nothing can be taken hold of.
    page.slider(joint).evaluate("(slider) => slider.scrollIntoView({ block: 'center' })")
    box = page.slider(joint).bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.tab.mouse.move(*middle)
    page.tab.mouse.down()
    for share in (0.3, 0.6, 1.0):
        page.tab.mouse.move(middle[0] + share * pixels, middle[1])
        page.animation_frames(2)
    page.tab.mouse.up()
    page.animation_frames(2)


def test_one_drag_is_one_step_back_and_forth(page: Page, nao: nk.NaoModel) -> None:
    start = nao.posture("StandInit")
    pull(page, "HeadYaw", 20)
    one = page.q
    pull(page, "HeadPitch", -10)
    two = page.q
    assert one[0] != start[0]
    assert two[1] != one[1]
    for key, expected in (
        ("Control+z", one),
        ("Control+z", start),
        ("Control+z", start),
        ("Control+Shift+Z", one),
        ("Control+y", two),
        ("Control+y", two),
    ):
        press(page, key)
        assert np.array_equal(page.q, expected), key
    tool(page, "Undo").click()
    assert np.array_equal(page.q, one)
    pull(page, "LHand", 10)
    # Undone steps can no longer be redone.
    assert tool(page, "Redo").get_attribute("aria-disabled") == "true"
    press(page, "Control+y")
    assert page.q[1] == one[1]


def test_a_series_of_arrow_keys_on_a_slider_is_one_step(page: Page, nao: nk.NaoModel) -> None:
    page.slider("HeadYaw").focus()
    press(page, "ArrowRight", "Shift+ArrowRight", "ArrowLeft")
    page.tab.keyboard.down("ArrowRight")
    for _ in range(3):  # the key repeats
        page.tab.keyboard.down("ArrowRight")
    page.tab.keyboard.up("ArrowRight")
    assert page.q[0] == pytest.approx(14 * STEP)
    # Another slider is another step, and so is the same one after a while.
    page.slider("HeadPitch").focus()
    press(page, "ArrowRight")
    page.tab.wait_for_function("() => naoKin.panel.past.history.past.length === 2", timeout=15_000)
    press(page, "ArrowRight")
    for yaw, pitch in ((14, 1), (14, 0), (0, 0), (0, 0)):
        press(page, "Control+z")
        assert page.q[:2] == pytest.approx([yaw * STEP, pitch * STEP])
    for pitch in (0, 1, 2, 2):
        press(page, "Control+y")
        assert page.q[:2] == pytest.approx([14 * STEP, pitch * STEP])


def test_undo_gives_back_a_direction_up_that_was_given(page: Page, nao: nk.NaoModel) -> None:
    page.run("() => { location.hash = 'v=1&q=&up=0,-1,0'; }")
    page.tab.wait_for_function("() => naoKin.stance.up !== null")
    tool(page, "Crouch").click()
    assert page.run("() => (naoKin.settle(), naoKin.stance.up)") is None
    press(page, "Control+z")
    assert page.run("() => (naoKin.settle(), [...naoKin.stance.up])") == [0, -1, 0]


def test_undo_works_in_a_number_unless_it_is_being_typed(page: Page) -> None:
    yaw = field(page, "HeadYaw")

    def shows(degrees: float) -> None:
        assert yaw.input_value() == f"{degrees:.1f}"
        assert page.q[0] == pytest.approx(math.radians(degrees))

    page.edit_number("HeadYaw")
    for text in ("22", "11"):
        page.tab.keyboard.type(text)
        press(page, "Enter")
    for key, degrees in (("Control+z", 22), ("Control+z", 0), ("Control+y", 22), ("Control+Shift+Z", 11)):
        press(page, key)
        shows(degrees)
    # A text that is not finished is the browser's to undo, then the robot is undone again.
    page.tab.keyboard.type("5")
    press(page, "Control+z")
    shows(11)
    press(page, "Control+z")
    shows(22)
    page.tab.keyboard.type("7")
    press(page, "Control+z", "Escape")
    shows(22)
    press(page, "Control+z")
    shows(0)


def test_one_history_has_every_change_and_is_reached_from_everywhere(page: Page, nao: nk.NaoModel) -> None:
    keys = page.tab.get_by_role("slider", name="Key ")
    page.run("() => navigator.clipboard.writeText('{\"LElbowYaw\": -1}')")
    changes: list[Callable[[], Any]] = [
        lambda: page.type_number("HeadYaw", "11"),
        lambda: pull(page, "HeadPitch", -10),
        lambda: tool(page, "Crouch").click(),
        lambda: (page.slider("RHand").focus(), press(page, "ArrowUp")),
        lambda: (page.tab.locator("canvas").first.focus(), press(page, "ControlOrMeta+V"), message_away(page)),
        lambda: tool(page, "Mirror left and right").click(),
        lambda: tool(page, "Reset to the beginning").click(),
        lambda: (tool(page, "Key frames").click(), message_away(page)),  # the clip becomes keys
    ]
    focus: list[Callable[[], Any]] = [
        lambda: keys.first.focus(),
        lambda: page.edit_number("LKneePitch"),
        lambda: page.tab.get_by_label("Speed").focus(),
        lambda: tool(page, "Stand").focus(),
        lambda: page.tab.get_by_label("Reference frame").focus(),
        lambda: page.tab.locator("canvas").first.focus(),
        lambda: page.slider("HeadYaw").focus(),
        lambda: tool(page, "Settings").press("Enter"),
    ]
    seen = [page.q]
    for change in changes:
        change()
        page.animation_frames(2)
        seen.append(page.q)
    assert keys.count() == 2
    for place, before in zip(focus, seen[-2::-1], strict=True):
        place()
        press(page, "ControlOrMeta+Z")
        assert np.array_equal(page.q, before)
        assert keys.count() == 0
    assert page.tab.locator(".menu:popover-open").count() == 1
    press(page, "Escape")
    tool(page, "Key frames").click()
    assert tool(page, "Undo").get_attribute("aria-disabled") == "true"


def test_a_robot_without_sides_has_no_mirror_and_no_naoqi(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="arm"><link name="a"/><link name="b"/><joint name="turn" type="continuous"><parent link="a"/>'
        '<child link="b"/></joint></robot>',
        encoding="utf-8",
    )
    with opened(browser, Viewer(nk.RobotModel.from_urdf(path)).save_html(tmp_path / "arm.html")) as page:
        assert not tool(page, "Mirror left and right").is_visible()
        tool(page, "Copy the configuration").click()
        assert len(page.tab.locator(".menu:popover-open button").all()) == 4
        press(page, "Escape")
        page.slider("turn").focus()
        press(page, "End", "ArrowLeft")
        assert page.q[0] == pytest.approx(math.pi - STEP)


# --- copies -----------------------------------------------------------------------------------------------------------


def copied(page: Page, title: str) -> str:
    tool(page, "Copy the configuration").click()
    page.tab.get_by_role("button", name=re.compile(f"^{title}")).click()
    assert said(page) == f"{title} copied"
    message_away(page)
    return str(page.run("() => navigator.clipboard.readText()"))


def test_copies_are_what_python_reads(page: Page, nao: nk.NaoModel, tmp_path: Path) -> None:
    q = nao.random(3)
    page.set(q)
    for title, suffix in (("JSON", "json"), ("CSV", "csv")):
        file = tmp_path / f"q.{suffix}"
        file.write_text(copied(page, title), encoding="utf-8")
        assert np.array_equal(np.ravel(read_log(nao, file).q), q)
    space: dict[str, Any] = {"nao": nao}
    exec(copied(page, "Python"), space)
    assert np.array_equal(space["q"], q)


def test_what_was_copied_is_pasted_by_the_keyboard(page: Page, nao: nk.NaoModel) -> None:
    q = nao.random(5)
    page.set(q)
    copied(page, "JSON")
    page.set(nao.neutral())
    press(page, "ControlOrMeta+V")
    assert said(page).startswith("25 values from JSON")
    assert np.array_equal(page.q, q)
    press(page, "Control+z")
    assert np.array_equal(page.q, nao.neutral())


# --- links ------------------------------------------------------------------------------------------------------------


def state_of(tab: Any) -> dict[str, Any]:
    return dict(
        tab.evaluate("""() => (naoKin.settle(), {
            q: [...naoKin.q], up: naoKin.stance.up, shown: naoKin.toggles.shown, units: naoKin.panel.settings.units,
            frame: naoKin.pick.selection.read,
            camera: [...naoKin.viewer.camera.position.toArray(), ...naoKin.viewer.controls.target.toArray()],
        })""")
    )


@pytest.mark.full
def test_a_link_reproduces_everything(page: Page, browser: Any, nao: nk.NaoModel) -> None:
    tool(page, "LyingBack").click()
    q = nao.random(6)
    page.run("(q) => naoKin.set(q)", q.tolist())
    for name in ("Joint axes", "Support"):
        assert page.switch(name)
    page.switch("feet")
    page.tab.locator("canvas").first.focus()
    press(page, "ArrowLeft", "ArrowUp", "+")
    page.tab.get_by_label("Frame", exact=True).select_option("LFoot/Bumper/Left")
    choose(page, "Radians")
    tool(page, "Copy the configuration").click()
    page.tab.get_by_role("button", name="Link").click()
    assert said(page) == "Link copied"
    link, before = page.run("() => navigator.clipboard.readText()"), state_of(page.tab)
    assert len(link.split("#")[1]) < 1000
    with another(browser, link) as tab:
        after = state_of(tab)
        camera, expected = (np.array(state.pop("camera")) for state in (after, before))
        assert np.abs(np.subtract(after.pop("q"), before.pop("q"))).max() < 1e-6
        assert after == before
        assert np.abs(camera - expected).max() < 1e-3
        assert tab.evaluate("() => naoKin.robot.outside(naoKin.q).size") == 0
    for name in ("Joint axes", "Support"):
        assert not page.switch(name)
    tool(page, "three-quarter").click()
    choose(page, "Degrees")


def test_a_joint_at_a_coupled_limit_is_still_inside_where_a_link_leads(page: Page, nao: nk.NaoModel) -> None:
    (table,) = (table for table in nao.coupled_limits if table.joint == "HeadPitch")
    yaws = np.linspace(0.5, 1.9, 9).round(6)
    bounds = np.interp(yaws, table.at, table.upper)
    beyond = np.ceil(bounds * 1e6) / 1e6  # as a link writes them, if rounding goes that way
    assert (beyond - bounds).max() > 1e-7
    for yaw, pitch, bound in zip(yaws, beyond, bounds, strict=True):
        joints = f"HeadYaw:{yaw:.6f},HeadPitch:{pitch:.6f},LElbowRoll:-0.5,RElbowRoll:0.5"
        page.run("(joints) => { location.hash = `v=1&q=${joints}`; }", joints)
        page.tab.wait_for_function("(yaw) => naoKin.q[0] === yaw", arg=float(yaw))
        assert page.q[1] == pytest.approx(bound, abs=1e-12)
        assert page.run("() => naoKin.robot.outside(naoKin.q).size") == 0


def test_a_link_is_followed_though_the_page_writes_its_address_at_that_moment(page: Page, nao: nk.NaoModel) -> None:
    page.set(nao.posture("Stand"))
    page.run("() => { location.hash = 'v=1&q=HeadYaw:0.375'; naoKin.panel.address.write(); }")
    page.tab.wait_for_function("() => naoKin.q[0] === 0.375")


@pytest.mark.full
def test_the_address_follows_and_is_no_step_of_the_browsers_history(browser: Any, document: Path) -> None:
    with another(browser, document) as tab:
        entries = tab.evaluate("() => history.length")
        tab.get_by_role("button", name="Crouch").click()
        tab.wait_for_function("() => location.hash.includes('LKneePitch:')")
        assert tab.evaluate("() => history.length") == entries
        q = state_of(tab)["q"]
        tab.reload()
        tab.wait_for_selector("body[data-ready]")
        assert state_of(tab)["q"] == pytest.approx(q, abs=1e-6)


def test_a_link_that_is_none_changes_nothing(page: Page, nao: nk.NaoModel) -> None:
    page.run("() => { location.hash = 'v=1&q=HeadYow:1'; }")
    assert "nearest: HeadYaw" in said(page)
    assert np.array_equal(page.q, nao.posture("StandInit"))


@pytest.mark.full
def test_a_live_page_goes_where_a_link_leads_but_not_where_it_was(browser: Any, nao: nk.NaoModel) -> None:
    with Viewer(nao) as viewer:
        viewer.display(nao.posture("Crouch"))
        with another(browser, f"{viewer.url}#v=1&q=HeadYaw:0.5") as tab:
            assert state_of(tab)["q"][0] == 0.5
            tab.wait_for_function("() => naoKin.received > 0")

            assert until(lambda: nao.angles(viewer.q)["HeadYaw"] == 0.5)
            viewer.display(nao.posture("Stand"))
            tab.wait_for_function("(x) => Math.abs(naoKin.q[5] - x) < 1e-9", arg=float(nao.posture("Stand")[5]))
            tab.goto(f"{viewer.url}#v=1&q=HeadYaw:0.25")  # the same page: only what is behind the # changes
            assert until(lambda: nao.angles(viewer.q)["HeadYaw"] == 0.25)
            viewer.display(nao.posture("Stand"))
            tab.wait_for_function("(x) => Math.abs(naoKin.q[5] - x) < 1e-9", arg=float(nao.posture("Stand")[5]))
            tab.reload()
            tab.wait_for_selector("body[data-ready]")
            assert np.allclose(state_of(tab)["q"], nao.posture("Stand"))


def framed(document: Path, outer: Path, attributes: str) -> Path:
    """Write a page that has another one in a frame."""
    inside = document.read_text(encoding="utf-8").replace("&", "&amp;").replace('"', "&quot;")
    frame = f'<iframe {attributes} width="900" height="600"'
    outer.write_text(f'<!doctype html><meta charset="utf-8">{frame} srcdoc="{inside}"></iframe>', encoding="utf-8")
    return outer


def test_a_page_that_is_hidden_when_it_opens_shows_the_robot_later(
    browser: Any, document: Path, tmp_path: Path
) -> None:
    outer = framed(document, tmp_path / "hidden.html", 'style="display: none"')
    with visitor(browser, viewport={"width": 950, "height": 650}) as context:
        tab = context.new_page()
        tab.goto(outer.as_uri())
        page = next(frame for frame in tab.frames if frame.parent_frame)
        page.wait_for_function("() => document.body.dataset.ready")
        tab.evaluate("() => { document.querySelector('iframe').style.display = 'block'; }")
        page.wait_for_function("() => naoKin.pane.clientHeight > 0")
        place = page.evaluate("() => naoKin.viewer.camera.position.toArray()")
        assert np.isfinite(place).all()


# --- keys -------------------------------------------------------------------------------------------------------------


def test_space_plays_and_pauses(page: Page) -> None:
    playing = "() => naoKin.player.playback.playing"
    assert not page.run(playing)
    press(page, "Space")
    assert page.run(playing)
    press(page, "Space")
    assert not page.run(playing)
    for place in (page.slider("HeadYaw"), tool(page, "Play"), page.tab.locator("canvas").first):
        place.focus()
        press(page, "Space")
        assert page.run(playing)
        press(page, "Space")
        assert not page.run(playing)
    # A button is pressed, once; menus, lists and sections open and close.
    lying = page.run("() => naoKin.robot.about.postures.find(({ name }) => name === 'LyingBack').q")
    tool(page, "LyingBack").press("Space")
    assert page.q == pytest.approx(lying)
    chain = page.tab.locator("summary", has_text="LArm")
    for expected in (False, True):
        chain.press("Space")
        assert chain.evaluate("(one) => one.parentElement.open") == expected
    speed = page.tab.get_by_label("Speed")
    page.run("""() => document.addEventListener(
        "keydown", ({ defaultPrevented }) => (window.spared = !defaultPrevented), { once: true })""")
    speed.press("Space")
    assert page.run("() => window.spared")
    press(page, "Escape")
    assert not page.run(playing)
    # In a text it is a space, a choice it makes, and Enter presses a button.
    page.tab.get_by_label("Filter joints").focus()
    press(page, "Space", "Backspace")
    tool(page, "Settings").press("Enter")
    page.tab.wait_for_function("() => document.activeElement.value === 'deg'")
    radians = page.tab.get_by_role("radio", name="Radians")
    radians.focus()
    press(page, "Space")
    assert radians.is_checked()
    press(page, "ArrowLeft", "Escape")
    assert not page.run(playing)
    tool(page, "Crouch").press("Enter")
    assert page.q != pytest.approx(lying)


def test_a_question_mark_lists_the_keys_and_escape_ends_it(page: Page) -> None:
    press(page, "?")
    dialog = page.tab.get_by_role("dialog", name="Keys")
    assert dialog.is_visible()
    assert "Ctrl+Z" in dialog.inner_text()
    # No key is broken over two lines or covers its meaning.
    assert not dialog.locator("dl div").evaluate_all("""(lines) => lines.filter((line) => {
        const [means, ...keys] = [line.querySelector("dd"), ...line.querySelectorAll("kbd")];
        return keys.some((key) => key.getClientRects().length > 1
            || key.getBoundingClientRect().right > means.getBoundingClientRect().left);
    }).map(({ textContent }) => textContent)""")
    press(page, "p")
    assert page.tab.locator("#panel").is_visible()
    press(page, "Escape")
    page.tab.locator("dialog").wait_for(state="detached")


def test_single_keys_can_be_switched_off(page: Page) -> None:
    choose(page, "Off")
    press(page, "p", "?")
    assert page.tab.locator("#panel").is_visible()
    page.tab.locator("dialog").wait_for(state="detached")
    choose(page, "On")
    press(page, "p")
    assert not page.tab.locator("#panel").is_visible()
    press(page, "p")


def test_the_camera_is_moved_by_keys(page: Page) -> None:
    place = "() => naoKin.viewer.camera.position.clone().sub(naoKin.viewer.controls.target).toArray()"

    def spherical() -> tuple[float, float, float]:
        x, y, z = page.run(place)
        radius = math.sqrt(x * x + y * y + z * z)
        return radius, math.atan2(x, z), math.acos(y / radius)

    page.tab.locator("canvas").first.focus()
    press(page, "1")
    assert page.run("() => naoKin.view") == "front"
    radius, around, down = spherical()
    press(page, "ArrowRight", "ArrowDown", "+")
    assert spherical() == pytest.approx(
        (radius / 1.15, around + math.radians(5), min(down + math.radians(5), math.pi)), abs=1e-6
    )
    press(page, "0")
    assert spherical() == pytest.approx((radius, around, down), abs=1e-6)
    for _ in range(60):
        press(page, "Shift+ArrowUp", "+")
    least = spherical()
    assert least[0] > 0.01
    assert least[2] > 0.0
    press(page, "3", "Home")
    assert page.run("() => naoKin.view") == "three-quarter"


def test_the_first_stop_leads_to_the_joints(page: Page) -> None:
    press(page, "Tab")
    assert page.run("() => document.activeElement.textContent") == "Skip to the joints"
    press(page, "Enter")
    assert page.run("() => document.activeElement.id") == "joints"
    assert "joints" not in page.run("() => location.hash")
    press(page, "Tab")
    assert page.run("() => document.activeElement.type") == "search"


def test_one_tab_stop_for_each_bar_of_buttons(page: Page) -> None:
    """There are few stops before the first joint, and arrows go through a bar."""
    stops = []
    for _ in range(40):
        press(page, "Tab")
        stops.append(page.run("() => document.activeElement.ariaLabel || document.activeElement.textContent"))
        if stops[-1] == "HeadYaw":
            break
    assert stops[-1] == "HeadYaw"
    assert len(stops) < 25
    assert [
        name for name in ("front", "Copy the configuration", "Stand", "Record the motion") if name in stops[:-1]
    ] == [*("front", "Copy the configuration", "Stand", "Record the motion")]
    assert not {"side", "Undo", "StandInit", "Plots"} & set(stops)
    page.tab.locator(".tools [tabindex='0']").focus()
    steps = (
        ("ArrowRight", "Paste a configuration"),
        ("End", "Mirror left and right"),
        ("ArrowRight", "Copy the configuration"),
    )
    for key, name in steps:
        press(page, key)
        assert page.run("() => document.activeElement.ariaLabel") == name
    # The bar is left and entered again where it was.
    press(page, "ArrowLeft", "Tab")
    assert page.run("() => document.activeElement.textContent") == "Stand"
    press(page, "Shift+Tab")
    assert page.run("() => document.activeElement.ariaLabel") == "Mirror left and right"


# The controls that can be reached at once: those in view that nothing covers.
WITHIN_REACH = """() => {
    const kinds = "button, input, select, summary, textarea, a[href], [tabindex='0']";
    return [...document.querySelectorAll(kinds)].filter((one) => {
        const { left, right, top, bottom } = one.getBoundingClientRect();
        const there = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
        return one.checkVisibility({ visibilityProperty: true }) && (one.contains(there) || there?.contains(one));
    }).length;
}"""


def test_a_new_page_has_few_controls(browser: Any, nao: nk.NaoModel, tmp_path: Path) -> None:
    with another(browser, Viewer(nao).save_html(tmp_path / "nao.html"), (1440, 900)) as tab:
        assert tab.evaluate(WITHIN_REACH) <= 40
        tab.locator("button.view").click()
        assert tab.locator(".menu.view :is(button, input)").filter(visible=True).count() <= 25


def test_sliders_are_as_long_as_the_panel_and_numbers_become_fields(page: Page) -> None:
    tab = page.tab
    row = tab.locator('.joint[data-joint="LElbowYaw"]')
    slider, number = (row.locator(f'input[type="{kind}"]') for kind in ("range", "text"))
    assert slider.bounding_box()["width"] > 0.85 * tab.locator("#panel").bounding_box()["width"]
    assert not number.is_visible()
    # By keyboard a digit or Enter opens the field, Enter and Escape lead back.
    slider.focus()
    press(page, "4", "2", "Enter")
    assert page.run("() => document.activeElement.type") == "range"
    assert row.locator(".number").inner_text() == "42.0"
    press(page, "Enter")
    assert page.run("() => document.activeElement.value") == "42.0"
    press(page, "7", "Escape")
    assert row.locator(".number").inner_text() == "42.0"
    limits = row.locator(".limits")
    tab.get_by_label("Filter joints").focus()
    tab.mouse.move(200, 400)
    assert limits.evaluate("(e) => getComputedStyle(e).opacity") == "0"
    before = row.bounding_box()
    row.hover()
    assert limits.evaluate("(e) => getComputedStyle(e).opacity") == "1"
    assert row.bounding_box() == before
    # Both minus signs are read, and one is written.
    for typed in ("-12.5", "−" + "12.5"):
        row.locator(".number").click()
        tab.keyboard.insert_text(typed)
        tab.keyboard.press("Enter")
        assert number.input_value() == "−" + "12.5"
    assert "-" not in limits.inner_text()


# --- sizes ------------------------------------------------------------------------------------------------------------


PHONE = {"has_touch": True, "is_mobile": True}


def of_kind(request: pytest.FixtureRequest, kind: str, size: tuple[int, int]) -> Any:
    """The tab of the module's page on a desk or on a phone, as at first but for the size of its window."""
    shared: Page = request.getfixturevalue("shared_phone" if kind == "phone" else "shared")
    shared.reset(request.getfixturevalue("nao").posture("StandInit"), size)
    return shared.tab


@pytest.mark.parametrize(
    ("kind", "size"),
    [
        ("phone", (320, 568)),
        *full(
            ("phone", (844, 390)),
            ("desk", (1400, 300)),
            ("phone", (390, 844)),
            ("desk", (760, 420)),
            ("desk", (3840, 2160)),
        ),
    ],
)
def test_every_joint_can_be_reached_in_every_window(
    request: pytest.FixtureRequest, kind: str, size: tuple[int, int]
) -> None:
    tab = of_kind(request, kind, size)
    for joint in ("HeadYaw", "RAnkleRoll", "RHand"):
        row = tab.locator(f'.joint[data-joint="{joint}"]')
        text, number = row.locator(".number"), row.locator('input[type="text"]')
        text.scroll_into_view_if_needed()
        text.tap() if kind == "phone" else text.click()
        box = number.bounding_box()
        assert box["width"] > 30
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= size[0]
        tab.keyboard.type("3")
        tab.keyboard.press("Enter")
        assert number.input_value().startswith("3")
    tab.get_by_label("Frame", exact=True).scroll_into_view_if_needed()
    view = tab.locator("#view").bounding_box()
    assert view["width"] > 150
    assert view["height"] > 150
    assert tab.evaluate("() => document.documentElement.scrollWidth") == size[0]
    before = view["width"] * view["height"]
    tab.get_by_role("button", name="Panel", exact=True).click()
    view = tab.locator("#view").bounding_box()
    assert view["width"] * view["height"] > before
    assert (view["width"], view["height"]) == size
    tab.get_by_role("button", name="Panel", exact=True).click()
    assert tab.locator("#panel").is_visible()


# How many rows of joints are in view as a whole.
JOINTS_IN_VIEW = """() => {
    const { top, bottom } = document.querySelector("#panel > .body").getBoundingClientRect();
    const boxes = [...document.querySelectorAll("#panel .joint")].map((row) => row.getBoundingClientRect());
    return boxes.filter((box) => box.top > top - 1 && box.bottom < bottom + 1).length;
}"""


@pytest.mark.full
def test_targets_for_fingers_are_large_enough(request: pytest.FixtureRequest) -> None:
    small = """(shown) => [...document.querySelectorAll('button, select, input, summary, [role="separator"]')]
        .filter((e) => e.checkVisibility() && (shown ? e.closest(shown) : !e.closest('[popover], #player')))
        .map((e) => [e.ariaLabel ?? e.textContent, (e.type === 'checkbox' ? e.closest('label') : e)])
        .map(([name, e]) => [name, e.getBoundingClientRect(), e.closest('.joint') ? 34 : 44])
        .filter(([, { width, height }, least]) => Math.min(width, height) < least).map(([name]) => name)"""
    for size in ((390, 844), (844, 390)):
        tab = of_kind(request, "phone", size)
        assert tab.evaluate(small) == []
        assert tab.evaluate(JOINTS_IN_VIEW) >= (6 if size[0] < size[1] else 3)
        assert [tab.locator(".readout .numbers output").nth(i).is_visible() for i in range(3)] == [True] * 3
        tab.locator("button.view").tap()
        assert tab.evaluate(small, ".menu.view") == []
        tab.locator("button.view").tap()
        tab.get_by_role("button", name="Settings").tap()
        assert tab.evaluate(small, ":popover-open") == []


def test_a_finger_moves_a_slider_by_its_thumb_alone_and_scrolls_anywhere_else(phone: Page) -> None:
    tab = phone.tab
    slider = tab.locator('.joint[data-joint="HeadYaw"] input[type="range"]')
    thumb = "(s) => (s.value - s.min) / (s.max - s.min) * (s.clientWidth - 22) + 11"

    def swipe(x: float, way: tuple[float, float]) -> tuple[float, float]:
        """Swipe from a place on the slider; return how far HeadYaw moved [rad] and the panel scrolled [px]."""
        # There is room to scroll either way, and what the swipe before scrolled does not add up.
        tab.locator("#panel > .body").evaluate("(body) => body.scrollTo(0, 100)")
        box, before = slider.bounding_box(), state_of(tab)["q"]
        start = np.array([box["x"] + x, box["y"] + box["height"] / 2])
        phone.touch("touchStart", start)
        for share in np.linspace(0.1, 1.0, 8):
            phone.touch("touchMove", start + share * np.array(way))
        phone.touch("touchEnd")
        until(lambda: abs(way[1]) < 20 or abs(box["y"] - slider.bounding_box()["y"]) > 20, 60.0)
        last = math.inf
        while last != (last := slider.bounding_box()["y"]):
            tab.wait_for_timeout(300)  # what is left of the scrolling
        after = state_of(tab)["q"]
        assert after[1:] == before[1:]
        return after[0] - before[0], box["y"] - last

    middle = slider.evaluate(thumb)
    width = slider.bounding_box()["width"]
    assert swipe(middle + 8, (0, 0)) == (0.0, 0.0)  # it does not jump under the finger
    turned, scrolled = swipe(middle + 8, (30, 3))
    assert turned == pytest.approx(30 / (width - 22) * math.radians(239), rel=0.02)
    assert scrolled == 0.0
    assert slider.evaluate(thumb) == pytest.approx(middle + 30, abs=0.6)
    for x, way in ((15, (0, -60)), (15, (40, 0)), (slider.evaluate(thumb), (3, 60))):
        turned, scrolled = swipe(x, way)
        assert turned == 0.0
        assert (abs(scrolled) > 20) == (way[1] != 0)


@pytest.mark.parametrize("phone", [False, *full(True)])
def test_what_can_be_done_is_said_once_until_something_is(browser: Any, document: Path, phone: bool) -> None:
    size, options = ((390, 844), PHONE) if phone else (SIZE, {})
    with another(browser, document, size, **options) as tab:
        hint, pane = tab.locator("#hint"), tab.locator("#pane")
        says = ["Drag to turn", "Tap a limb to drag it", "Pull a ring"]
        if not phone:
            says = [says[0], "Click a limb to drag it", says[2], "? lists the keys"]
        assert hint.locator("span").all_inner_texts() == says
        lines = hint.evaluate("(line) => new Set([...line.children].map((part) => part.offsetTop)).size")
        assert lines == (len(says) if phone else 1)
        before = pane.bounding_box()
        if phone:
            tab.touchscreen.tap(30, 200)
        else:
            tab.keyboard.press("Tab")
        hint.wait_for(state="hidden")
        assert pane.bounding_box() == before
        tab.reload()
        tab.wait_for_selector("body[data-ready]")
        assert hint.is_hidden()


@pytest.mark.full
def test_the_panel_is_resized_by_pointer_and_keys_and_stays_so(browser: Any, document: Path) -> None:
    with another(browser, document) as tab:
        width: Callable[[], float] = lambda: tab.locator("#panel").bounding_box()["width"]  # noqa: E731
        separator = tab.get_by_role("separator", name="Size of the panel")
        usual, box = width(), separator.bounding_box()
        at = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        tab.mouse.move(*at)
        tab.mouse.down()
        tab.mouse.move(at[0] - 60, at[1] + 5)
        tab.mouse.move(at[0] - 120, at[1] + 5)
        tab.mouse.up()
        assert width() == pytest.approx(usual + 120, abs=2)
        assert float(separator.get_attribute("aria-valuenow")) == pytest.approx(100 * width() / SIZE[0], abs=1)
        separator.focus()
        tab.keyboard.press("ArrowLeft")
        assert width() == pytest.approx(usual + 120 + 0.02 * SIZE[0], abs=2)
        tab.reload()
        tab.wait_for_selector("body[data-ready]")
        assert width() == pytest.approx(usual + 120 + 0.02 * SIZE[0], abs=2)
        separator.focus()
        tab.keyboard.press("End")
        assert width() <= 0.81 * SIZE[0]
        tab.keyboard.press("Enter")
        assert not tab.locator("#panel").is_visible()
        assert tab.evaluate("() => document.activeElement.ariaLabel") == "Panel"
        tab.keyboard.press("Enter")
        assert tab.locator("#panel").is_visible()


# --- everybody --------------------------------------------------------------------------------------------------------


def violations(tab: Any, part: str = "", *rules: str) -> list[str]:
    """What axe finds in the page, or in a part of it alone, by all of its rules or by some."""
    results = tab.evaluate(
        """([part, rules]) => axe.run(part || document, {
            resultTypes: ["violations"], ...(rules.length > 0 ? { runOnly: rules } : {}),
        })""",
        [part, rules],
    )
    return [
        f"{violation['id']}: {[node['html'][:120] for node in violation['nodes'][:3]]}"
        for violation in results["violations"]
    ]


@pytest.mark.full
@pytest.mark.parametrize("kind", ["desk", "phone", "4k"])
def test_axe_finds_nothing(browser: Any, document: Path, kind: str) -> None:
    """On a desk everything is looked at again after each step, in both schemes; elsewhere what the step has added."""
    axe = pytest.importorskip("axe_playwright_python", reason="axe-playwright-python is not installed")
    script = (Path(axe.__file__).parent / "axe.min.js").read_text(encoding="utf-8")
    size = {"desk": (1400, 900), "phone": (390, 844), "4k": (3840, 2160)}[kind]
    options: dict[str, Any] = {"color_scheme": "dark", **PHONE} if kind == "phone" else {}

    def assert_nothing(part: str = "") -> None:
        if kind != "desk":
            assert violations(tab, part) == []
            return
        assert violations(tab) == []
        tab.emulate_media(color_scheme="dark")
        assert violations(tab, "", "color-contrast", "link-in-text-block") == []
        tab.emulate_media(color_scheme="light")

    with another(browser, document, size, **options) as tab:
        tab.evaluate(script)
        assert_nothing()
        tab.evaluate("""() => {
            naoKin.show({ axes: true, frames: true });
            naoKin.set(naoKin.q.map((value, i) => (i === 0 ? 3 : value)));
            naoKin.settle();
            naoKin.panel.messages.say('something went wrong', { bad: true });
        }""")
        tab.locator('.joint[data-joint="HeadPitch"] .number').click()
        tab.keyboard.type("x")
        tab.keyboard.press("Enter")
        assert_nothing()
        tab.get_by_role("button", name="Settings").click()
        assert_nothing(":popover-open")
        tab.get_by_text("Keys …").click()
        assert_nothing("dialog[open]")
        tab.keyboard.press("Escape")
        tab.get_by_role("button", name="Copy the configuration").click()
        assert_nothing(":popover-open")


@pytest.mark.full
def test_reduced_motion_and_forced_colours_are_obeyed(browser: Any, document: Path) -> None:
    with another(browser, document, reduced_motion="reduce", forced_colors="active") as tab:
        assert tab.evaluate("() => getComputedStyle(document.querySelector('button')).transitionDuration") == "0s"
        pressed = "() => getComputedStyle(document.querySelector('[aria-pressed=\"true\"]')).backgroundColor"
        plain = "() => getComputedStyle(document.querySelector('[aria-pressed=\"false\"]')).backgroundColor"
        assert tab.evaluate(pressed) != tab.evaluate(plain)
