"""Targets, images of cameras and plots, as the program sees them."""

from __future__ import annotations

import io
import threading
import time
from typing import Any

import numpy as np
import pytest
from PIL import Image
from viewer_pages import messages_of, until

import nao_kin as nk
from nao_kin._core.files import png
from nao_kin.errors import BadArgument
from nao_kin.viewer import Target, panels


@pytest.fixture
def viewer(nao: nk.NaoModel) -> nk.Viewer:
    return nk.Viewer(nao)


def _drag(viewer: nk.Viewer, name: Any, matrix: Any) -> None:
    """Move a target as a page does."""
    viewer._receive({"kind": "target", "name": name, "matrix": matrix, "source": "page 1"})


def _shown(viewer: nk.Viewer, kind: str) -> list[dict[str, Any]]:
    return [message for message in messages_of(viewer.static_html()) if message.get("kind") == kind]


def _at(*place: float) -> list[float]:
    return nk.screws.pose(np.eye(3), place).T.reshape(-1).tolist()


# --- targets ----------------------------------------------------------------------------------------------------------


def test_a_target_calls_back_with_the_newest_place_and_is_where_the_page_has_it(viewer: nk.Viewer) -> None:
    moves: list[np.ndarray] = []
    gate = threading.Event()

    def on_move(T: np.ndarray) -> None:
        gate.wait(10.0)
        moves.append(T)

    ball = viewer.add_target("ball", [0.2, 0.1, 0.1], on_move=on_move)
    for step in range(50):
        _drag(viewer, "ball", _at(0.01 * step, 0.0, 0.0))
    assert ball.T.tolist() == [0.49, 0.0, 0.0]
    gate.set()
    assert until(lambda: len(moves) > 0 and moves[-1][0] == 0.49)
    assert len(moves) <= 2  # those in between were combined
    moves[-1][:] = 9.0
    assert ball.T.tolist() == [0.49, 0.0, 0.0]
    ball.place([0.1, 0.1, 0.1])
    (message,) = _shown(viewer, "targets")
    (row,) = message["targets"]
    assert row.pop("source").startswith("program ")
    assert row == {"name": "ball", "matrix": _at(0.1, 0.1, 0.1), "point": True}
    assert len(moves) <= 2


def test_on_move_may_fail_and_goes_on(viewer: nk.Viewer, caplog: pytest.LogCaptureFixture) -> None:
    seen: list[float] = []

    def on_move(T: np.ndarray) -> None:
        seen.append(float(T[0, 3]))
        raise SystemExit("no")

    viewer.add_target("pose", np.eye(4), on_move=on_move)
    _drag(viewer, "pose", _at(1.0, 0.0, 0.0))
    assert until(lambda: seen == [1.0])
    _drag(viewer, "pose", _at(2.0, 0.0, 0.0))
    assert until(lambda: seen == [1.0, 2.0])
    assert until(lambda: "on_move of pose failed" in caplog.text)


def test_what_no_target_could_be_is_not_taken_from_a_page(viewer: nk.Viewer) -> None:
    moves: list[np.ndarray] = []
    target = viewer.add_target("pose", np.eye(4), on_move=moves.append)
    viewer.show_targets({"mark": [0.1, 0.0, 0.0]})
    bent = _at(0.0, 0.0, 0.0)
    bent[0] = 2.0
    for name, matrix in (
        ("pose", bent), ("pose", [np.nan] * 16), ("pose", [1.0]), ("pose", None), ("pose", "x"), ("pose", [1e9] * 16),
        ("mark", _at(1.0, 0.0, 0.0)), ("other", _at(1.0, 0.0, 0.0)), (3, _at(1.0, 0.0, 0.0)), ([], None),
    ):  # fmt: skip
        _drag(viewer, name, matrix)
    time.sleep(0.1)
    assert moves == []
    assert np.array_equal(target.T, np.eye(4))


def test_a_target_of_the_same_name_replaces_the_old_one_and_marks_are_apart(viewer: nk.Viewer) -> None:
    old = viewer.add_target("ball", [0.2, 0.1, 0.1])
    new = viewer.add_target("ball", [0.2, 0.1, 0.2])
    viewer.show_targets({"cup": [0.1, 0.0, 0.0]})
    with pytest.raises(BadArgument, match="ball was removed"):
        old.place([0.0, 0.0, 0.0])
    old.remove()
    viewer.show_targets({})
    (message,) = _shown(viewer, "targets")
    assert [row["name"] for row in message["targets"]] == ["ball"]
    new.remove()
    new.remove()
    assert repr(new) == "<Target ball, removed>"
    assert _shown(viewer, "targets")[0]["targets"] == []
    assert isinstance(new, Target)


# --- images -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(3, 5), (4, 7, 3)])
def test_an_array_becomes_a_png_of_the_same_pixels(shape: tuple[int, ...]) -> None:
    pixels = np.random.default_rng(0).integers(0, 256, shape, dtype=np.uint8)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(png(pixels)))), pixels)
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(png(pixels[::-1, ::-1])))), pixels[::-1, ::-1])


@pytest.mark.parametrize("kind", ["png", "jpeg"])
def test_files_are_passed_on(viewer: nk.Viewer, kind: str) -> None:
    file = io.BytesIO()
    Image.new("RGB", (40, 30), "red").save(file, kind)
    viewer.show_image("CameraTop", file.getvalue())
    (message,) = _shown(viewer, "image")
    assert message["format"] == f"image/{kind}"
    assert message["data"].data == file.getvalue()
    assert viewer.shown["eye"]
    viewer.show_image("CameraTop", None)
    viewer.show_image("CameraTop", None)
    assert _shown(viewer, "image") == []


# --- plots ------------------------------------------------------------------------------------------------------------


def _points(viewer: nk.Viewer, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Times and rows of a plot, from the messages of a page."""
    messages = [message for message in _shown(viewer, "plot") if message["name"] == name]
    assert [message["first"] for message in messages] == sorted(message["first"] for message in messages)
    times, values = (np.concatenate([np.frombuffer(m[key].data) for m in messages]) for key in ("times", "values"))
    return times, values.reshape(len(times), -1)


def test_points_of_a_plot_are_all_in_the_page_in_order(viewer: nk.Viewer) -> None:
    for i in range(1234):
        viewer.plot("force", {"front": i} if i % 2 else {"front": i, "rear": -i}, time=0.01 * i)
    times, values = _points(viewer, "force")
    assert np.allclose(times, 0.01 * np.arange(1234))
    assert np.array_equal(values[:, 0], np.arange(1234))
    assert np.isnan(values[1::2, 1]).all()
    viewer.plot("force", {"front": 5.0}, time=3.0)  # back in time: anew
    assert _points(viewer, "force")[0].tolist() == [3.0]
    viewer.plot("force", None)
    assert _shown(viewer, "plot") == []


def test_the_newest_hundred_thousand_points_are_kept(viewer: nk.Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(panels, "MAX_POINTS", 2000)
    for i in range(7001):
        viewer.plot("x", i, time=i)
    times, _ = _points(viewer, "x")
    assert times[-1] == 7000.0
    assert 2000 <= len(times) <= 2501


def test_points_that_come_fast_are_sent_together_and_soon(viewer: nk.Viewer) -> None:
    sent: list[str] = []
    viewer._messages.watch(lambda key: sent.append(key) if key.startswith("plot ") else None)
    begin = time.monotonic()
    for i in range(400):
        viewer.plot("x", i)
    took = time.monotonic() - begin
    assert len(sent) <= 2 + took / 0.05
    message = viewer._messages.get(sent[0])
    assert until(lambda: viewer._messages.get(sent[0]) is not message)
    assert until(lambda: viewer._streams._timer is None)
    assert not viewer._streams._waiting


def test_points_count_their_time_from_animate_and_are_in_a_recording(viewer: nk.Viewer, nao: nk.NaoModel) -> None:
    viewer.plot("x", 1.0, time=50.0)
    viewer.animate(np.stack([nao.posture("Stand"), nao.posture("Crouch")]))
    viewer.plot("x", 2.0)
    times, _ = _points(viewer, "x")
    assert times.shape == (1,)
    assert 0.0 <= times[0] < 30.0
    with viewer.record() as recording:
        viewer.plot("x", 3.0)
        viewer.plot("force", {"front": 4.0})
    viewer.plot("x", 5.0)
    assert list(recording.plots) == [("x", "x"), ("force", "front")]
    assert recording.plots["x", "x"][:, 1].tolist() == [3.0]


def test_margins_of_the_balance_come_with_their_clip_and_go_with_it(viewer: nk.Viewer, nao: nk.NaoModel) -> None:
    times = np.linspace(0.0, 1.0, 51)
    pitch = -0.15 * np.sin(3.5 * np.pi * times) * np.sin(np.pi * times)
    rock = nk.Motion(5.0 + times, ["LAnklePitch", "RAnklePitch"], np.column_stack([pitch, pitch]))
    viewer.plot("Force", 1.0)
    viewer.animate(rock, missing="Stand", balance=True)
    (message,) = [message for message in _shown(viewer, "plot") if message["margins"]]
    assert message["lines"] == ["margin", "centre-of-mass margin"]
    at, values = _points(viewer, message["name"])
    assert at == pytest.approx(0.01 * np.arange(101))
    (part,) = nk.motion.check(nao, rock, missing="Stand", balance=True).balance
    assert values.min(axis=0) == pytest.approx([1e3 * part.margin, 1e3 * part.com_margin])
    assert part.margin < 0.0
    # Configurations at a speed of one's own: at half the speed, a fourth of the accelerations.
    q = nao.posture("Stand", LAnklePitch=pitch, RAnklePitch=pitch)
    viewer.animate(q, fps=25, balance=True)
    at, slow = _points(viewer, message["name"])
    assert (at[-1], len(_shown(viewer, "plots")[-1]["names"])) == (2.0, 2)
    assert values[:, 0].min() + 20.0 < slow[:, 0].min() < slow[:, 1].min()
    viewer.animate(np.repeat(nao.posture("LyingBack")[None], 3, axis=0), balance=True)
    assert np.isnan(_points(viewer, message["name"])[1]).all()
    viewer.animate(q)
    assert [message["name"] for message in _shown(viewer, "plot")] == ["Force"]


# --- refusals ---------------------------------------------------------------------------------------------------------
