"""The bar under the view by real pointers, keys, fingers and files: key frames, recordings and plots."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viewer_pages import Page, messages_of, opened, until, visitor

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.errors import WrongShape
from nao_kin.motion import check, read_motion
from nao_kin.viewer import Viewer

SIZE = (1100, 760)
POSTURES = ("StandInit", "Crouch", "StandZero")


def press(page: Page, name: str) -> None:
    page.tab.get_by_role("button", name=name, exact=True).click()


def make_keys(page: Page) -> None:
    """Three key frames, at 0, 1 and 2 s."""
    press(page, "Key frames")
    for posture in POSTURES:
        press(page, posture)
        page.tab.keyboard.press("k")


def times(page: Page) -> list[float]:
    diamonds = page.tab.locator("#player [role=slider]")
    return [float(diamonds.nth(i).get_attribute("aria-valuenow")) for i in range(diamonds.count())]


def across(page: Page, time: float) -> tuple[float, float]:
    """Return the place of a time on the track, in the lower part of the track, where the keys are."""
    box = page.tab.locator(".lane").bounding_box()
    return box["x"] + box["width"] * time / page.run("() => naoKin.player.editor.track.span"), (
        box["y"] + box["height"] - 18
    )


def save(page: Page, kind: str, folder: Path) -> Path:
    press(page, "Save the motion")
    with page.tab.expect_download() as download:
        press(page, f"Save as {kind}")
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def message(page: Page) -> str:
    return str(page.tab.locator("#message span").text_content(timeout=5000))


def test_keys_are_added_behind_each_other_and_poses_between_are_those_of_python(page: Page, nao: nk.NaoModel) -> None:
    make_keys(page)
    assert times(page) == [0.0, 1.0, 2.0]
    page.tab.get_by_role("slider", name="Key 3 of 3").focus()
    for _ in range(5):
        page.tab.keyboard.press("ArrowRight")
    assert times(page) == [0.0, 1.0, 2.5]
    keys = [nao.posture(name) for name in POSTURES]
    for interpolation in ("linear", "smooth"):
        page.tab.get_by_label("Interpolation").select_option(interpolation)
        motion = nk.Motion([0.0, 1.0, 2.5], nao.joint_names, keys, interpolation)
        at = [0.0, 0.1, 0.5, 0.77, 1.0, 1.25, 2.499, 2.5]
        for time, expected in zip(at, motion.configurations(nao, times=at).q, strict=True):
            page.run("(time) => naoKin.player.seek(time)", time)
            q = page.q
            assert np.abs(q - expected).max() < 1e-9
            assert np.abs(page.poses(nao.link_names) - nao.fk(q)).max() < 1e-6


@pytest.mark.full
def test_a_key_is_dragged_retimed_duplicated_replaced_and_deleted(page: Page, nao: nk.NaoModel) -> None:
    make_keys(page)
    x, y = across(page, 1.0)
    page.tab.mouse.move(x, y)
    page.tab.mouse.down()
    page.tab.mouse.move(*across(page, 1.3), steps=4)
    page.tab.mouse.move(*across(page, 1.5), steps=4)
    page.tab.mouse.up()
    assert times(page) == pytest.approx([0.0, 1.5, 2.0], abs=0.051)
    assert np.abs(page.q - nao.posture("Crouch")).max() < 1e-12  # the key under the pointer is on show
    dragged = times(page)[1]
    page.tab.keyboard.press("ArrowLeft")
    page.tab.keyboard.press("Shift+ArrowRight")
    assert times(page)[1] == pytest.approx(dragged - 0.09)
    page.tab.keyboard.press("Control+z")
    assert times(page)[1] == dragged  # a series of arrow keys is one step
    page.tab.keyboard.press("Control+z")
    assert times(page) == [0.0, 1.0, 2.0]  # a drag is one step
    key = page.tab.get_by_role("slider", name="Key 2 of 3")
    assert key.get_attribute("aria-valuetext") == "1.00 s, selected"
    page.tab.get_by_role("slider", name="Key 3 of 3").press("Enter")
    page.animation_frames(2)
    page.run("() => { const { editor } = naoKin.player; editor.grab(1); editor.drag(1.5); }")  # before the next picture
    page.tab.keyboard.press("Control+z")
    assert times(page) == [0.0, 1.0, 2.0]
    assert key.get_attribute("aria-valuetext") == "1.00 s, selected"
    press(page, "Duplicate the key")
    assert times(page) == [0.0, 1.0, 2.0, 3.0]
    assert np.abs(page.q - nao.posture("Crouch")).max() < 1e-12
    press(page, "Stand")
    press(page, "Replace by the current configuration")
    page.run("() => naoKin.player.seek(3)")
    assert np.abs(page.q - nao.posture("Stand")).max() < 1e-12
    page.tab.get_by_role("slider", name="Key 4 of 4").focus()
    page.tab.keyboard.press("Home")
    page.tab.keyboard.press("ArrowDown")
    page.tab.keyboard.press("Delete")
    assert times(page) == [0.0, 2.0, 3.0]
    press(page, "Undo")
    assert len(times(page)) == 4
    press(page, "Redo")
    assert len(times(page)) == 3


def test_the_track_beside_the_keys_and_the_plots_go_to_a_time(page: Page, nao: nk.NaoModel) -> None:
    make_keys(page)
    x, y = across(page, 0.5)
    page.tab.mouse.click(x, y)
    middle = (nao.posture("StandInit") + nao.posture("Crouch")) / 2
    assert np.abs(page.q - middle).max() < 0.02
    press(page, "Plots")
    over = page.tab.locator(".plot .u-over").first
    over.wait_for()
    box = over.bounding_box()
    page.tab.mouse.move(box["x"] + 0.25 * box["width"], box["y"] + 20)
    page.tab.mouse.down()
    page.tab.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 30, steps=3)
    page.tab.mouse.up()
    assert page.run("() => naoKin.player.time") == pytest.approx(1.5, abs=0.02)
    page.run("() => naoKin.player.seek(1)")
    shown = page.tab.locator(".plot .values").first.inner_text()
    assert f"{math.degrees(nao.angles(nao.posture('Crouch'))['LKneePitch']):.1f}°" in shown


def test_the_wheel_and_keys_zoom_the_time_of_the_track(page: Page) -> None:
    make_keys(page)
    track, key = page.tab.locator(".track"), page.tab.get_by_role("slider", name="Key 2 of 3")
    middle = lambda: key.bounding_box()["x"] + key.bounding_box()["width"] / 2  # noqa: E731
    wide, before = page.tab.locator(".lane").bounding_box()["width"], middle()
    page.tab.mouse.move(before, across(page, 1.0)[1])
    page.tab.mouse.wheel(0, -500)
    page.tab.wait_for_function("() => naoKin.player.editor.track.zoom > 2.5")
    assert middle() == pytest.approx(before, abs=1.5)  # the time under the pointer stays there
    assert page.tab.locator(".lane").bounding_box()["width"] == pytest.approx(wide * math.e, rel=0.01)
    page.tab.mouse.click(across(page, 1.1)[0], across(page, 1.1)[1] - 25)
    assert page.run("() => naoKin.player.editor.now") == pytest.approx(1.1, abs=0.011)
    page.run("() => naoKin.player.seek(2)")  # out of sight until the track turns its page
    box = track.bounding_box()
    assert box["x"] < page.tab.locator(".playhead").bounding_box()["x"] < box["x"] + box["width"]
    key.focus()
    for sign in "-", "-", "+":
        page.tab.keyboard.press(sign)
    assert page.run("() => naoKin.player.editor.track.zoom") == 2.0
    page.tab.keyboard.press("-")
    assert page.tab.locator(".lane").bounding_box()["width"] == pytest.approx(wide, abs=0.5)


def test_a_plot_says_in_words_what_it_draws(page: Page, nao: nk.NaoModel) -> None:
    make_keys(page)
    press(page, "Plots")
    assert page.tab.locator(".plot h3").all_inner_texts() == ["Joints [°]", "LArm in Torso [mm]"]
    joints, places = (page.tab.locator(".plot .picture").nth(i).get_attribute("aria-label") for i in (0, 1))
    knee = [math.degrees(nao.angles(nao.posture(name))["LKneePitch"]) for name in POSTURES]
    assert f"LKneePitch from {min(knee):.1f} to {max(knee):.1f} °" in joints
    motion = nk.Motion([0.0, 1.0, 2.0], nao.joint_names, [nao.posture(name) for name in POSTURES])
    z = 1000 * nao.fk(motion.configurations(nao, rate=200.0).q, "LArm")[:, 2, 3]
    assert f"z from {z.min():.1f} to {z.max():.1f} mm".replace("-", "−") in places
    press(page, "Plots")
    assert page.tab.locator(".plot canvas").count() == 0


@pytest.mark.full
@pytest.mark.parametrize("kind", ["CSV", "JSON"])
def test_what_is_saved_is_read_by_python(
    page: Page, nao: nk.NaoModel, tmp_path: Path, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    make_keys(page)
    page.tab.get_by_role("slider", name="Key 3 of 3").focus()
    page.tab.keyboard.press("ArrowRight")
    path = save(page, kind, tmp_path)
    assert path.suffix == f".{kind.lower()}"
    motion = read_motion(path)
    assert motion.interpolation == "linear"
    assert motion.joint_names == nao.joint_names
    assert np.abs(motion.key_times - [0.0, 1.0, 2.1]).max() < 1e-12
    expected = np.array([nao.posture(name) for name in POSTURES])
    assert np.abs(motion.configurations(nao).q - expected).max() < 1e-12
    assert run(["fk", str(path), "--frame", "LLeg", "--json", "--as", "matrix", "--limits", "ignore"]) == 0
    rows = json.loads(capsys.readouterr().out)["configurations"]
    assert np.abs([row["LLeg"] for row in rows] - nao.fk(expected, "LLeg")).max() < 1e-12
    html = tmp_path / "played.html"
    assert run(["view", str(path), "--fps", "30", "--html", str(html)]) == 0
    [clip] = [m for m in messages_of(html.read_text(encoding="utf-8")) if m.get("kind") == "clip"]
    assert clip["fps"] == 30.0


@pytest.mark.full
def test_the_last_step_that_is_undone_leaves_the_focus_where_it_is(page: Page) -> None:
    make_keys(page)
    undo = page.tab.get_by_role("button", name="Undo", exact=True)
    undo.focus()
    steps = 3 + 2  # the keys, and the postures that they hold, of which one was shown at first
    page.tab.wait_for_function("(steps) => naoKin.panel.past.history.past.length === steps", arg=steps)
    for _ in range(steps + 2):
        page.tab.keyboard.press("Enter")
    assert times(page) == []
    assert page.run("() => document.activeElement.ariaLabel") == "Undo"
    assert undo.is_disabled()


def test_what_choregraphe_exports_is_pasted_as_key_frames(page: Page) -> None:
    text = """
names = list(); times = list(); keys = list()
names.append("HeadYaw")
times.append([0.52, 0.8])
keys.append([30*almath.TO_RAD, 0])
names.append("LHand")
times.append([1.0])
keys.append([[0.75, [3, -0.4, 0], [3, 0, 0]]])
try:
  motion = ALProxy("ALMotion")
  motion.angleInterpolation(names, keys, times, True)
except BaseException, err:
  print err
"""
    page.tab.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.run("(text) => navigator.clipboard.writeText(text)", text)
    page.tab.keyboard.press("ControlOrMeta+V")
    page.tab.get_by_text("angleInterpolation: 3 key frames, 1.00 s").wait_for()
    page.tab.context.clear_permissions()
    assert page.run("() => [...naoKin.player.motion.times]") == [0.52, 0.8, 1.0]
    assert page.run("() => { naoKin.player.seek(0); return naoKin.q[0]; }") == pytest.approx(
        math.radians(30.0), abs=1e-15
    )


@pytest.mark.full
def test_keys_that_are_too_fast_are_named_and_slowed_down(page: Page, nao: nk.NaoModel, tmp_path: Path) -> None:
    make_keys(page)
    page.tab.get_by_role("slider", name="Key 3 of 3").focus()
    for _ in range(8):
        page.tab.keyboard.press("ArrowLeft")
    rise = np.abs(nao.posture("StandZero") - nao.posture("Crouch")) / nao.velocity_limits
    worst = nao.joint_names[int(rise.argmax())]
    assert f"{worst} needs {rise.max():.2f} s" in page.tab.locator(".tooFast").inner_text()
    for interpolation in ("linear", "smooth"):
        page.tab.get_by_label("Interpolation").select_option(interpolation)
        press(page, "Slow down")
        assert not page.tab.get_by_role("button", name="Slow down").is_visible()
        path = save(page, "JSON", tmp_path)
        assert [found for found in check(nao, read_motion(path)).violations if "speed" in str(found).lower()] == []


@pytest.mark.full
def test_what_moves_is_recorded_played_and_made_into_keys(page: Page, nao: nk.NaoModel, tmp_path: Path) -> None:
    press(page, "Record the motion")
    page.slider("HeadYaw").focus()
    for _ in range(12):
        page.tab.keyboard.press("Shift+ArrowRight")
        page.tab.wait_for_timeout(40)
    press(page, "Stop recording")
    assert "configurations recorded" in message(page)
    last = page.q
    # The bar stands where the robot is.
    assert page.run("() => naoKin.player.time === naoKin.player.playback.duration")
    clock = page.tab.locator("#player .own output").inner_text().split()
    assert clock[0] == clock[2]
    motion = read_motion(save(page, "CSV", tmp_path))
    yaw = motion.sample(motion.key_times)[:, motion.joint_names.index("HeadYaw")]
    assert yaw[0] == 0.0
    assert yaw[-1] == pytest.approx(last[0], abs=1e-12)
    assert len(yaw) > 8
    assert (np.diff(motion.key_times)[:-1] > 0.02).all()  # the last one is where the recording was stopped
    press(page, "Play")
    page.tab.wait_for_function("() => naoKin.player.time > 0.1")
    press(page, "Pause")
    expected = motion.sample(page.run("() => naoKin.player.time"))
    assert np.abs(page.q - expected).max() < 1e-9
    press(page, "Key frames")
    assert "became" in message(page)
    assert 2 <= len(times(page)) <= len(yaw)


@pytest.mark.full
def test_a_figure_moves_with_the_robot_and_leaves_with_its_clip(browser: Any, nao: nk.NaoModel, tmp_path: Path) -> None:
    viewer, q = Viewer(nao), np.tile(nao.posture("StandInit"), (3, 1))
    bones = np.array(
        [[[[0.1 * k, 0.5, 0.2], [0.1 * k, 0.5, 0.6]], [[0.0, 0.5, 0.6], [0.2 * k, 0.5, 0.6]]] for k in range(3)]
    )
    bones[1, 1, 1] = np.nan
    viewer.animate(q, 10.0, play=False, figure=bones)
    viewer.plot("force", 1.0)
    viewer.plot("force", 2.0)
    places = """(time) => {
        const { player } = naoKin;
        player.seek(time);
        return ["rod0", "end0", "rod1"].map((name) => {
            const part = player.figure.object.getObjectByName(name);
            return [name, part.position.toArray(), part.scale.toArray()];
        });
    }"""
    with opened(browser, viewer.save_html(tmp_path / "figure.html"), SIZE) as page:
        for k in range(3):
            found = {name: (position, scale) for name, position, scale in page.run(places, k / 10.0)}
            np.testing.assert_allclose(found["rod0"][0], [0.1 * k, 0.5, 0.4], atol=1e-6)
            np.testing.assert_allclose(found["rod0"][1], [1.0, 0.4, 1.0], atol=1e-6)
            np.testing.assert_allclose(found["end0"][0], [0.1 * k, 0.5, 0.6], atol=1e-6)
            assert (found["rod1"][1][0] < 1e-3) == (k == 1)
        # Plots would take its room, and it is in the picture at all times.
        assert not page.tab.locator(".plots").is_visible()
        far = page.run("() => (naoKin.player.seek(0), naoKin.player.figure.box.max.toArray())")
        assert far[0] > 0.4
        assert 0.6 < far[1] < 0.65  # in the world of the page, up is y
        assert page.run("() => (naoKin.player.unload(), naoKin.player.figure)") is None
    for wrong in (bones[:2], bones[..., :2], np.zeros((3, 0, 2, 3))):
        with pytest.raises(WrongShape, match="figure must have shape"):
            viewer.animate(q, figure=wrong)


def test_python_and_other_pages_follow_what_one_plays(browser: Any, nao: nk.NaoModel) -> None:
    with Viewer(nao) as viewer, opened(browser, viewer.url, SIZE) as page, opened(browser, viewer.url) as other:
        make_keys(page)
        page.run("() => naoKin.player.seek(0)")
        other.tab.wait_for_function("(x) => Math.abs(naoKin.q[5] - x) < 1e-9", arg=float(nao.posture("StandInit")[5]))
        heard: list[np.ndarray] = []
        subscription = viewer.on_change(lambda q, joints: heard.append(q))
        reports = other.run("() => naoKin.reports.count")
        press(page, "Play")
        seen = []

        def several_came() -> bool:
            seen.append(other.q)
            return all(len({q.tobytes() for q in rows}) >= 4 for rows in (list(heard), seen))

        assert until(several_came)
        assert page.run("() => naoKin.player.playback.playing")  # its own reports do not stop it
        press(page, "Pause")
        motion = nk.Motion([0.0, 1.0, 2.0], nao.joint_names, [nao.posture(name) for name in POSTURES])
        way = motion.configurations(nao, rate=1000.0).q
        for q in (*heard, *seen):
            assert np.abs(way - q).max(axis=1).min() < 5e-3
        other.tab.wait_for_function("(q) => q.every((x, i) => Math.abs(naoKin.q[i] - x) < 1e-9)", arg=page.q.tolist())
        assert np.array_equal(viewer.q, page.q)
        # Nothing goes round and round.
        assert other.run("() => naoKin.reports.count") == reports
        told = page.run("() => naoKin.reports.count")
        page.tab.wait_for_timeout(200)
        assert page.run("() => naoKin.reports.count") == told

        # Who takes hold of the robot elsewhere stops it.
        press(page, "Play")
        page.tab.wait_for_function("(told) => naoKin.reports.count > told + 1 && !naoKin.reports.begins", arg=told)
        other.slider("HeadYaw").focus()
        other.tab.keyboard.press("Home")
        page.tab.wait_for_function("() => !naoKin.player.playback.playing && naoKin.q[0] < -1.5")
        page.tab.wait_for_timeout(200)
        assert np.array_equal(viewer.q, page.q)
        assert np.array_equal(other.q, page.q)
        subscription.remove()


@pytest.mark.full
def test_plots_open_by_themselves_only_beside_a_picture_of_half_the_height(
    browser: Any, nao: nk.NaoModel, tmp_path: Path
) -> None:
    viewer = nk.Viewer(nao)
    viewer.plot("force", 1.0)
    viewer.plot("force", 2.0)
    path = viewer.save_html(tmp_path / "plots.html")
    for size, opened_at_first in (((390, 844), False), ((1400, 900), True)):
        with opened(browser, path, size) as saved:
            plots, button = saved.tab.locator(".plots"), saved.tab.get_by_role("button", name="Plots")
            assert plots.is_visible() == opened_at_first
            button.click()
            assert plots.is_visible() != opened_at_first


@pytest.mark.full
def test_keys_are_made_and_moved_by_touch(browser: Any, document: Path) -> None:
    with visitor(browser, viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True) as context:
        tab = context.new_page()
        tab.goto(document.as_uri())
        tab.wait_for_selector("body[data-ready]")
        tab.get_by_role("button", name="Key frames").tap()
        for posture in ("StandInit", "Crouch"):
            tab.get_by_role("button", name=posture, exact=True).tap()
            tab.get_by_role("button", name="Add key").tap()
        small = tab.evaluate(
            """() => [...document.querySelectorAll('#player :is(button, select, input, .key)')]
                .filter((one) => one.checkVisibility())
                .map((one) => [one.ariaLabel ?? one.textContent, one.getBoundingClientRect()])
                .filter(([, { width, height }]) => width < 43.5 || height < 43.5)
                .map(([name, { width, height }]) => `${name} ${width} x ${height}`)"""
        )
        assert small == []
        track = tab.locator(".track").bounding_box()
        assert track["x"] >= 0
        assert track["x"] + track["width"] <= 390
        box = tab.get_by_role("slider", name="Key 1 of 2").bounding_box()
        lane = tab.locator(".lane").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        touch = context.new_cdp_session(tab)
        for kind, share in (("touchStart", 0.0), ("touchMove", 0.1), ("touchMove", 0.25), ("touchEnd", None)):
            points = [] if share is None else [{"x": x + share * lane["width"], "y": y}]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        moved = float(tab.get_by_role("slider", name="Key 1 of 2").get_attribute("aria-valuenow"))
        assert moved == pytest.approx(0.5, abs=0.1)
        for kind, apart in (("touchStart", None), ("touchStart", 60), ("touchMove", 120), ("touchMove", 150)):
            points = [{"x": 120, "y": y - 10, "id": 1}, {"x": 120 + (apart or 0), "y": y - 10, "id": 2}]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points[: 1 if apart is None else 2]})
        touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        assert tab.evaluate("() => naoKin.player.editor.track.zoom") == pytest.approx(2.5, rel=0.02)
        assert tab.evaluate("() => naoKin.player.editor.track.fingers.size") == 0


@pytest.mark.full
def test_the_bar_has_no_barriers(page: Page) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    make_keys(page)
    press(page, "Plots")
    for scheme in ("light", "dark"):
        page.tab.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        page.tab.wait_for_timeout(200)
        found = axe.run(page.tab, context="#player")
        assert found.violations_count == 0, found.generate_report()
