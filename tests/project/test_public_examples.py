"""Every public function, class and method shows how it is called."""

from __future__ import annotations

import dataclasses
import inspect

from public_names import called

NEEDS_A_ROBOT = "reads a robot, or a server of qi, on the network"
NEEDS_THE_LOCK = "for the services of a virtual NAO, which hold its lock"
WITHOUT = {
    "distributed.connect": "starts processes of its own",
    "naoqi.JointSource.connect": NEEDS_A_ROBOT,
    "naoqi.JointSource.read": NEEDS_A_ROBOT,
    "naoqi.JointSource.close": NEEDS_A_ROBOT,
    "naoqi.LolaSource.read": NEEDS_A_ROBOT,
    "naoqi.LolaSource.close": NEEDS_A_ROBOT,
    "naoqi.NaoqiSource": NEEDS_A_ROBOT,
    "naoqi.NaoqiSource.connect": NEEDS_A_ROBOT,
    "naoqi.NaoqiSource.read": NEEDS_A_ROBOT,
    "naoqi.NaoqiSource.close": NEEDS_A_ROBOT,
    "naoqi.QiServer": NEEDS_A_ROBOT,
    "naoqi.QiServer.close": NEEDS_A_ROBOT,
    "naoqi.readings": NEEDS_A_ROBOT,
    "naoqi.VirtualNao.after": NEEDS_THE_LOCK,
    "naoqi.VirtualNao.announce": NEEDS_THE_LOCK,
    "naoqi.VirtualNao.await_answer": NEEDS_THE_LOCK,
    "naoqi.VirtualNao.start_task": NEEDS_THE_LOCK,
    "viewer.Viewer.open": "opens a browser window",
    "viewer.Viewer.save_png": "starts a browser",
}
# The mathematical packages have their own tests.
APART = ("lines.", "rank_one.", "rotations.")
CALLED = {name: value for name, value in called() if not name.startswith(APART)}


def _is_called(name: str) -> bool:
    """Return whether a user calls it; results, rows and exceptions, which functions make, show their fields instead."""
    owner = CALLED.get(name.rpartition(".")[0], CALLED[name])
    return not (dataclasses.is_dataclass(owner) or (inspect.isclass(owner) and issubclass(owner, BaseException)))


def test_everything_that_a_user_calls_has_an_example() -> None:
    without = {name for name in CALLED if ">>> " not in (CALLED[name].__doc__ or "").partition("Examples:\n")[2]}
    assert {name for name in without if _is_called(name)} - set(WITHOUT) == set()


def test_what_has_none_for_a_reason_is_there_and_has_none() -> None:
    assert not [name for name in WITHOUT if ">>> " in (CALLED[name].__doc__ or "")]
