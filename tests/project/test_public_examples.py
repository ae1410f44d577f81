"""Every public function, class and method shows how it is called."""

from __future__ import annotations

import pytest
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
    "parameters.VersionPage.over": "takes all tables of a version, which nothing public hands out",
    "robot.Kinematics.answer": "takes a question, which only the room itself makes",
    "viewer.Viewer.open": "opens a browser window",
    "viewer.Viewer.save_png": "starts a browser",
}
# The rooms of mathematics are gone through by themselves.
APART = ("lines.", "rank_one.", "rotations.")
CALLED = {name: value for name, value in called() if not name.startswith(APART)}


@pytest.mark.parametrize("name", [name for name in CALLED if name not in WITHOUT])
def test_it_has_an_example(name: str) -> None:
    text = CALLED[name].__doc__ or ""
    assert "Examples:\n" in text, f"{name} has no example"
    assert ">>> " in text.split("Examples:\n")[1]


@pytest.mark.parametrize("name", WITHOUT)
def test_what_has_none_for_a_reason_is_there_and_has_none(name: str) -> None:
    assert ">>> " not in (CALLED[name].__doc__ or "")
