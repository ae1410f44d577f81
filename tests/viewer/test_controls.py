"""The camera and the program's own controls, as the program sees them, without a browser."""

from __future__ import annotations

import re
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viewer_pages import messages_of, until

import nao_kin as nk
from nao_kin.errors import BadArgument, NotARotation, UnknownName, WrongShape
from nao_kin.viewer.overlays import BUTTONS

MENU = Path(__file__).resolve().parents[2] / "web" / "src" / "view_menu.ts"


@pytest.fixture
def viewer(nao: nk.NaoModel) -> nk.Viewer:
    return nk.Viewer(nao)


def _shown(viewer: nk.Viewer, kind: str) -> list[dict[str, Any]]:
    return [message for message in messages_of(viewer.static_html()) if message.get("kind") == kind]


# --- the camera -------------------------------------------------------------------------------------------------------


def test_the_camera_is_where_the_program_or_a_page_put_it_last(viewer: nk.Viewer) -> None:
    assert viewer.camera_pose is None
    T = nk.screws.pose(nk.rotations.rot_z(2.0), [1.0, 2.0, 0.5])
    viewer.camera_pose = T
    assert np.array_equal(viewer.camera_pose, T)
    assert _shown(viewer, "camera")[0]["camera"] == T.T.reshape(-1).tolist()
    moved = nk.screws.pose(nk.rotations.rot_z(1.0), [3.0, 2.0, 0.5])
    viewer._receive({"kind": "camera", "pose": moved.T.reshape(-1).tolist(), "source": "page 1"})
    assert np.array_equal(viewer.camera_pose, moved)
    viewer.camera("top")
    assert _shown(viewer, "camera")[0]["camera"] == "top"
    for wrong in (None, 3, "x", [1.0] * 16, [np.nan] * 16, list(range(15)), {"a": 1}):
        viewer._receive({"kind": "camera", "pose": wrong})
    assert np.array_equal(viewer.camera_pose, moved)
    with pytest.raises(NotARotation):
        viewer.camera_pose = 2.0 * np.eye(4)
    with pytest.raises(WrongShape):
        viewer.camera_pose = np.eye(3)
    assert np.array_equal(viewer.camera_pose, moved)


def test_the_buttons_are_those_of_the_menu(viewer: nk.Viewer) -> None:
    table = MENU.read_text(encoding="utf-8").partition("const TOGGLES")[2].partition("\n};")[0]
    assert sorted(BUTTONS) == sorted(re.findall(r"^  (\w+): \{", table, re.M))
    viewer.show("orthographic")
    assert viewer.shown["orthographic"]
    viewer.show("orthographic", False)
    assert not viewer.shown["orthographic"]
    with pytest.raises(UnknownName, match="orthographic"):
        viewer.show("ortographic")


# --- controls ---------------------------------------------------------------------------------------------------------


def _set(viewer: nk.Viewer, name: Any, value: Any) -> None:
    """Set a control as a page does."""
    viewer._receive({"kind": "control", "name": name, "value": value, "source": "page 1"})


def test_controls_have_the_values_of_the_page_and_call_their_functions(viewer: nk.Viewer) -> None:
    calls: list[Any] = []
    go = viewer.add_button("go", lambda: calls.append("go"))
    speed = viewer.add_slider("speed", -1.0, 2.0, 0.5, calls.append, unit="m/s")
    side = viewer.add_select("side", ["left", "right"], "right", calls.append)
    name = viewer.add_text("name", "NAO", calls.append)
    state = viewer.add_text("state", "ready")
    assert [control.value for control in (go, speed, side, name, state)] == [0, 0.5, "right", "NAO", "ready"]
    for control, value in (("go", 1), ("speed", 2.0), ("side", "left"), ("name", "Ada"), ("state", "broken")):
        _set(viewer, control, value)
    assert until(lambda: calls == ["go", 2.0, "left", "Ada"])
    assert [control.value for control in (go, speed, side, name, state)] == [1, 2.0, "left", "Ada", "ready"]
    speed.value, side.value, name.value, state.value = 1, "right", "", "walks"
    (message,) = _shown(viewer, "controls")
    assert [row["value"] for row in message["controls"]] == [1, 1.0, "right", "", "walks"]
    pressed, *sources = [row.pop("source") for row in message["controls"]]
    assert pressed == "page 1"
    assert len(set(sources)) == 4
    assert all(source.startswith("program ") for source in sources)
    assert message["controls"][1] == {
        "kind": "slider", "name": "speed", "value": 1.0, "low": -1.0, "high": 2.0, "unit": "m/s",
    }  # fmt: skip
    assert len(calls) == 4


def test_a_page_sets_no_value_that_a_control_cannot_have(viewer: nk.Viewer) -> None:
    calls: list[Any] = []
    controls = [
        viewer.add_slider("speed", 0.0, 1.0, on_change=calls.append),
        viewer.add_select("side", ["left"], on_change=calls.append),
        viewer.add_text("name", "NAO", calls.append),
    ]
    for name, value in (
        ("speed", 1.1), ("speed", np.nan), ("speed", None), ("speed", "x"), ("speed", [1.0, 0.0]), ("side", "right"),
        ("side", []), ("name", 3), ("name", "\ud800"), ("other", 1), (None, 1), ([], 1),
    ):  # fmt: skip
        _set(viewer, name, value)
    assert [control.value for control in controls] == [0.0, "left", "NAO"]
    assert calls == []


def test_every_press_of_a_button_calls_even_while_its_function_is_busy(
    viewer: nk.Viewer, caplog: pytest.LogCaptureFixture
) -> None:
    calls: list[float] = []
    started, gate = threading.Event(), threading.Event()

    def press() -> None:
        started.set()
        gate.wait(10.0)
        calls.append(len(calls))
        if len(calls) == 1:
            raise SystemExit("no")

    button = viewer.add_button("go", press)
    viewer.add_slider("x", 0.0, 100.0, on_change=calls.append)
    _set(viewer, "go", 0)
    assert started.wait(10.0)  # what comes now waits for it
    for step in range(1, 5):
        _set(viewer, "go", step)
        _set(viewer, "x", step)
    gate.set()
    # The presses are five calls, the newest value of the slider is one, after them.
    assert until(lambda: calls[-1:] == [4.0], 20.0)
    assert calls == [0, 1, 2, 3, 4, 4.0]
    assert button.value == 5
    assert "on_click of go failed" in caplog.text


def test_a_control_of_the_same_name_replaces_the_old_one_in_its_place(viewer: nk.Viewer) -> None:
    calls: list[Any] = []
    old = viewer.add_slider("x", 0.0, 1.0, on_change=calls.append)
    viewer.add_button("go")
    new = viewer.add_text("x", "now a text")
    _set(viewer, "x", 0.5)
    with pytest.raises(BadArgument, match="x was removed"):
        old.value = 0.5
    old.remove()
    assert [row["name"] for row in _shown(viewer, "controls")[0]["controls"]] == ["x", "go"]
    new.remove()
    new.remove()
    assert repr(new) == "<Control x, removed>"
    assert [row["name"] for row in _shown(viewer, "controls")[0]["controls"]] == ["go"]
    assert calls == []


# --- targets that are grabbed, arrows and labels ----------------------------------------------------------------------


def test_a_target_tells_when_it_is_grabbed_moved_and_let_go(viewer: nk.Viewer) -> None:
    told: list[tuple[str, float]] = []
    tell = {event: (lambda T, event=event: told.append((event, float(T[0])))) for event in ("grab", "move", "release")}
    viewer.add_target("ball", [0.1, 0.0, 0.0], on_move=tell["move"], on_grab=tell["grab"], on_release=tell["release"])
    for message in (
        {"kind": "held", "name": "ball", "held": True},
        {"kind": "held", "name": "ball", "held": 3},
        {"kind": "held", "name": "other", "held": True},
        {"kind": "held", "name": [], "held": True},
    ):
        viewer._receive(message)
    assert until(lambda: told == [("grab", 0.1)])
    matrix = nk.screws.pose(np.eye(3), [0.2, 0.0, 0.0]).T.reshape(-1).tolist()
    viewer._receive({"kind": "target", "name": "ball", "matrix": matrix, "source": "page 1"})
    viewer._receive({"kind": "held", "name": "ball", "held": False})
    assert until(lambda: told == [("grab", 0.1), ("move", 0.2), ("release", 0.2)])


def test_arrows_and_labels_are_shapes_with_names(viewer: nk.Viewer) -> None:
    viewer.add_arrow("force", [0.0, 0.0, 0.1], [0.0, 0.0, 0.3], color=[1.0, 0.0, 0.0])
    viewer.add_label("hand", "here", [0.1, 0.0, 0.0], frame="LArm")
    arrow, label = _shown(viewer, "extra")
    assert np.frombuffer(arrow["positions"].data, np.float32).tolist() == pytest.approx([0, 0, 0.1, 0, 0, 0.3])
    assert (label["text"], label["frame"], label["shape"]) == ("here", "LArm", "label")
    viewer.add_arrow("force", [0.0, 0.0, 0.1], [0.0, 0.0, 0.3], frame="RArm", width=0.01)
    viewer.add_line("path", np.eye(3), frame="Head")
    shown = {message["name"]: message for message in _shown(viewer, "extra")}
    arrow, line = shown["force"], shown["path"]
    assert (arrow["frame"], arrow["width"], line["frame"]) == ("RArm", 0.01, "Head")
    viewer.remove("path")
    viewer.remove("force")
    assert [message["name"] for message in _shown(viewer, "extra")] == ["hand"]
    with pytest.raises(WrongShape, match="start"):
        viewer.add_arrow("force", [0.0, 0.0], [0.0, 0.0, 0.3])
    with pytest.raises(BadArgument, match="text must be 1 to 200 characters"):
        viewer.add_label("hand", " ", [0.0, 0.0, 0.0])
    with pytest.raises(UnknownName, match="LArm"):
        viewer.add_label("hand", "here", [0.0, 0.0, 0.0], frame="LArmm")


def test_drawings_are_shown_and_hidden(viewer: nk.Viewer) -> None:
    def press(on: bool) -> dict[str, bool]:
        viewer.show_com(on=on)
        viewer.show_joint_axes(on=on)
        viewer.show_support_polygon(on=on)
        return {name: is_on for message in _shown(viewer, "shown") for name, is_on in message["shown"].items()}

    names = ("com", "axes", "support")
    assert press(True) | dict.fromkeys(names, True) == press(True)
    assert press(False) | dict.fromkeys(names, False) == press(False)
