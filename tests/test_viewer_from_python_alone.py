"""What a program does with the viewer beyond showing one robot, where no browser is needed to see it."""

from __future__ import annotations

import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_robots import J, made_up
from viewer_pages import messages_of

import nao_kin as nk
from nao_kin.viewer import Viewer, recording
from nao_kin.viewer.changes import Changes


def test_robots_beside_each_other_do_not_touch(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao)
    added = [viewer.add_robot(nao) for _ in range(3)]
    places = [0.0, *(robot.T_world_ground[1, 3] for robot in added)]
    width = added[0].reaches_aside
    assert np.all(np.diff(places) <= -(2.0 * width + 0.05))
    assert np.ptp(np.diff(places)) < 1e-12  # as far apart, all of them


def test_a_robot_that_is_removed_takes_no_other_one_along(tmp_path: Path, nao: nk.NaoModel) -> None:
    viewer, small = Viewer(nao), made_up(tmp_path, J("turn"))
    added = [viewer.add_robot(small, name=f"robot {number}") for number in range(12)]
    added[0].remove()
    document = messages_of(viewer.static_html())
    assert [m["name"] for m in document if m.get("kind") == "robot_added"] == [robot.name for robot in added[1:]]
    assert not any(m.get("robot") == 1 for m in document)


def test_a_recording_stands_still_where_the_robot_did_and_keeps_both_ends_when_it_is_halved(
    nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = [0.0]
    monkeypatch.setattr(recording, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    monkeypatch.setattr(recording, "_MOST", 20)
    viewer = Viewer(nao)
    begin = viewer.q
    with viewer.record(fps=10.0) as taken:
        for step in range(10):
            clock[0] = 100.0 + 0.1 * step
            viewer.display(nao.configuration({"HeadYaw": 0.5 + 1e-3 * step}))
        for time in (50.0, 99.8):
            assert np.array_equal(taken.motion.sample(time), begin[-25:])
        for step in range(10, 200):
            clock[0] = 100.0 + 0.1 * step
            viewer.display(nao.configuration({"HeadYaw": 0.5 + 1e-3 * step}))
        for time in (50.0, 99.0):
            assert np.array_equal(taken.motion.sample(time), begin[-25:])
        clock[0] = 1000.0
    assert len(taken) <= 21
    assert (taken.times[0], taken.times[-1]) == (0.0, 1000.0)
    assert np.array_equal(taken.q[0], begin)
    assert taken.q[-1, 0] == pytest.approx(0.699)


def test_a_callback_that_is_busy_hears_of_every_joint_later_and_gets_a_configuration_of_its_own() -> None:
    changes, busy, done = Changes(), threading.Event(), threading.Event()
    heard: list[tuple[np.ndarray, tuple[str, ...]]] = []
    began = threading.Event()

    def spoil(q: np.ndarray, joints: tuple[str, ...]) -> None:
        began.set()
        busy.wait(10.0)
        q[:] = np.nan

    def listen(q: np.ndarray, joints: tuple[str, ...]) -> None:
        heard.append((q, joints))
        if len(heard) == 2:
            done.set()

    changes.add(spoil)
    changes.add(listen)
    changes.tell(np.array([1.0, 0.0, 0.0]), ("a",))
    assert began.wait(10.0)
    changes.tell(np.array([1.0, 2.0, 0.0]), ("b",))
    changes.tell(np.array([1.0, 2.0, 3.0]), ("c",))
    busy.set()
    assert done.wait(10.0)
    assert [joints for _, joints in heard] == [("a",), ("b", "c")]
    assert np.array_equal([q for q, _ in heard], [[1.0, 0.0, 0.0], [1.0, 2.0, 3.0]])
