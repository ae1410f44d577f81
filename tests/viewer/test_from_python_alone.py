"""Uses of the viewer beyond showing one robot, tested without a browser."""

from __future__ import annotations

import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_robots import J, made_up
from viewer_pages import messages_of

import nao_kin as nk
from nao_kin.viewer import Viewer, handles
from nao_kin.viewer.description import SceneRobot
from nao_kin.viewer.shown_scene import Changes


def test_robots_beside_each_other_do_not_touch(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao)
    added = [viewer.add_robot(nao) for _ in range(3)]
    places = [0.0, *(robot.T_world_ground[1, 3] for robot in added)]
    width = SceneRobot(nao).aside
    assert np.all(np.diff(places) <= -(2.0 * width + 0.05))
    assert np.ptp(np.diff(places)) < 1e-12  # as far apart, all of them


def test_a_robot_that_is_removed_takes_no_other_one_along(tmp_path: Path, nao: nk.NaoModel) -> None:
    viewer, small = Viewer(nao), made_up(tmp_path, J("turn"))
    added = [viewer.add_robot(small, name=f"robot {number}") for number in range(12)]
    added[0].remove()
    document = messages_of(viewer.static_html())
    assert [m["name"] for m in document if m.get("kind") == "robot_added"] == [robot.name for robot in added[1:]]
    assert not any(m.get("robot") == 1 for m in document)


def test_equal_robots_are_sent_once_and_kept_while_one_of_them_is_there(nao: nk.NaoModel) -> None:
    viewer, old = Viewer(nao), nk.load_nao("v4")
    alone, sent = len(viewer.static_html()), list[str]()
    viewer._messages.watch(sent.append)
    added = [viewer.add_robot(robot) for robot in (nao, old, old, nk.load_nao(), *[nao] * 6)]
    assert len(viewer.static_html()) < min(1.5 * alone, 4e6)
    parts = [key for key in sent if key.startswith(("geometry ", "model "))]
    assert len(parts) == len(set(parts)) >= 2  # a shape of the old NAO, and its description

    def named(kind: str) -> set[str]:
        return {m["name"] for m in messages_of(viewer.static_html()) if m.get("kind") == kind}

    used, models = named("geometry"), named("model")
    assert len(models) == 2
    added[1].remove()
    assert (named("geometry"), named("model")) == (used, models)
    added[2].remove()
    assert named("geometry") < used
    assert len(named("model")) == 1
    for robot in added:
        robot.remove()
    assert alone <= len(viewer.static_html()) < alone + 200
    viewer.add_robot(old)
    assert (named("geometry"), named("model")) == (used, models)


def test_a_robot_whose_links_are_elsewhere_shares_the_shapes_alone(nao: nk.NaoModel) -> None:
    viewer, sent = Viewer(nao), list[str]()
    viewer._messages.watch(sent.append)
    viewer.add_robot(nao.with_offsets({"HeadYaw": 0.01}))
    assert [key.split()[0] for key in sent][:2] == ["model", "robot"]


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The time of recordings, which have 20 rows at most."""
    now = [0.0]
    monkeypatch.setattr(handles, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(handles, "_MAX_ROWS", 20)
    return now


def test_a_recording_stands_still_where_the_robot_did_and_keeps_both_ends_when_it_is_halved(
    nao: nk.NaoModel, clock: list[float]
) -> None:
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
    assert len(taken.times) <= 21
    assert (taken.times[0], taken.times[-1]) == (0.0, 1000.0)
    assert np.array_equal(taken.q[0], begin)
    assert taken.q[-1, 0] == pytest.approx(0.699)


def test_a_recording_that_is_halved_keeps_where_the_robot_then_stays(nao: nk.NaoModel, clock: list[float]) -> None:
    viewer = Viewer(nao)
    with viewer.record(fps=10.0) as taken:
        rows = 0
        while len(taken.times) > rows:
            rows = len(taken.times)
            clock[0] += 0.11
            viewer.display(nao.configuration({"HeadYaw": 0.02 * clock[0]}))
        assert rows == 19
        last = clock[0]
        clock[0] += 50.0
        viewer.display(nao.configuration({"HeadYaw": 1.0}))
    assert taken.motion.sample(last + 25.0)[0] == pytest.approx(0.02 * last, abs=1e-9)


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


def test_a_callback_that_ends_its_thread_is_called_again(caplog: pytest.LogCaptureFixture) -> None:
    changes, heard = Changes(), threading.Semaphore(0)

    def leave(q: np.ndarray, joints: tuple[str, ...]) -> None:
        heard.release()
        raise SystemExit(1)

    changes.add(leave)
    for _ in range(2):
        changes.tell(np.zeros(1), ("a",))
        assert heard.acquire(timeout=10.0)


def test_a_callback_that_another_one_removes_is_not_called() -> None:
    changes, done, heard = Changes(), threading.Event(), []
    changes.add(lambda q, joints: second.remove())
    second = changes.add(lambda q, joints: heard.append(joints))
    changes.add(lambda q, joints: done.set())
    changes.tell(np.zeros(1), ("a",))
    assert done.wait(10.0)
    assert heard == []


def test_what_is_on_show_is_what_pages_are_told_whoever_moves_the_robot_at_once(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao)
    page = {"kind": "joints", "q": nao.posture("Sit").tolist()}
    other = threading.Thread(target=lambda: viewer._receive(page))

    def interrupt(key: str) -> None:
        viewer._messages.unwatch(interrupt)
        other.start()
        other.join(0.3)

    viewer._messages.watch(interrupt)
    viewer.display(nao.posture("Crouch"))
    other.join()
    told = next(m for m in messages_of(viewer.static_html()) if m.get("kind") == "joints")
    assert np.array_equal(np.frombuffer(told["q"].data), viewer.q)


def test_one_page_that_goes_leaves_no_other_one_behind(nao: nk.NaoModel) -> None:
    viewer, heard = Viewer(nao), []

    def going(key: str) -> None:
        viewer._messages.unwatch(going)

    viewer._messages.watch(going)
    viewer._messages.watch(heard.append)
    viewer.display(nao.posture("Crouch"))
    assert heard == ["joints"]


def test_numbers_of_numpy_are_numbers(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao, port=np.int64(0))
    viewer.show_frames("LArm", size=np.array(0.1))
    with viewer:
        assert viewer.url.startswith("http://127.0.0.1:")
