"""Every former name works for a release and warns, and the documentation lists it."""

import re
import warnings
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin._core.warn import FORMER_NAMES
from nao_kin.errors import BadArgument, FormerNameWarning
from nao_kin.naoqi.virtual import Machine, MotionTask
from nao_kin.robot import OutsideRows

PAGE = Path(__file__).parents[2] / "docs" / "former_names.md"
NAO = nk.load_nao()
Q = NAO.posture("Stand")


def nodding() -> nk.ik.FollowedPath:
    return nk.ik.follow(NAO, {"Head": nk.rotations.rot_y([0.0, 0.1, 0.2])})


class Nod(MotionTask):
    def advance(self, nao: Machine, time: float) -> bool:
        return True


def begun(add: Callable[[nk.naoqi.VirtualNao, MotionTask], Future[Any]]) -> bool:
    with nk.naoqi.VirtualNao(NAO, stepped=True) as robot, robot.monitor:
        return add(robot, Nod("nod", ["HeadPitch"])).done()


# Two calls for each former name outside the command line: with it, and with the new one.
CALLS: dict[tuple[str, str], tuple[Callable[[], Any], Callable[[], Any]]] = {
    ('limits="raise"', 'limits="enforce"'): (
        lambda: NAO.configuration({"HeadYaw": 0.1}, limits="raise"),
        lambda: NAO.configuration({"HeadYaw": 0.1}, limits="enforce"),
    ),
    ('limits="redistribute"', 'limits="enforce"'): (
        lambda: nk.ik.velocity(NAO, Q, np.ones(6), "LArm", limits="redistribute").v,
        lambda: nk.ik.velocity(NAO, Q, np.ones(6), "LArm", limits="enforce").v,
    ),
    (".reference", ".near"): (lambda: nk.ik.head(NAO, np.eye(3)).reference, lambda: nk.ik.head(NAO, np.eye(3)).near),
    ("root=", "reference="): (
        lambda: nk.ik.analytic(NAO, "torso", np.linalg.inv(NAO.fk(Q, "LLeg")), root="LLeg").q,
        lambda: nk.ik.analytic(NAO, "torso", np.linalg.inv(NAO.fk(Q, "LLeg")), reference="LLeg").q,
    ),
    ("fps=", "rate="): (lambda: nodding().sampled(fps=10.0), lambda: nodding().sampled(rate=10.0)),
    ("most=", "max_configurations="): (
        lambda: NAO.limit_violations([np.full(25, 3.0)] * 2, most=1),
        lambda: NAO.limit_violations([np.full(25, 3.0)] * 2, max_configurations=1),
    ),
    ('hips="agree"', "hips=None"): (
        lambda: nk.naoqi.from_order(NAO, NAO.to_body(Q), "H25", hips="agree"),
        lambda: nk.naoqi.from_order(NAO, NAO.to_body(Q), "H25", hips=None),
    ),
    ("reference=", "near="): (
        lambda: nk.naoqi.from_order(NAO, np.zeros(22), "H21", reference=Q),
        lambda: nk.naoqi.from_order(NAO, np.zeros(22), "H21", near=Q),
    ),
    (".start_task", ".tasks.add"): (
        lambda: begun(lambda robot, task: robot.start_task(task)),
        lambda: begun(lambda robot, task: robot.tasks.add(task)),
    ),
    ("clamped.most", "clamped.largest"): (
        lambda: OutsideRows(1, 0.25, "a").most,
        lambda: OutsideRows(1, 0.25, "a").largest,
    ),
    ("colour_by=", "by="): (
        lambda: nk.reach.workspace(NAO, "LArm", 9, voxel=0.1).save_ply("a.ply", colour_by="count").read_bytes(),
        lambda: nk.reach.workspace(NAO, "LArm", 9, voxel=0.1).save_ply("b.ply", by="count").read_bytes(),
    ),
}
# Every function with the former name `reference`, and its other arguments.
T_FOOT, T_HAND, FEET = NAO.fk(Q, "LLeg"), NAO.fk(Q, "LArm"), NAO.fk(Q, ["LLeg", "RLeg"])
TYPED = nk.joints.MultiDofModel(NAO)
SOLVERS: dict[str, Callable[..., Any]] = {
    "head": lambda **more: nk.ik.head(NAO, np.eye(3), **more).q,
    "look_at": lambda **more: nk.ik.look_at(NAO, [1.0, 0.2, 0.1], **more).q,
    "arm": lambda **more: nk.ik.arm(NAO, "L", T_HAND, **more).q,
    "leg": lambda **more: nk.ik.leg(NAO, "L", T_FOOT, **more).q,
    "legs": lambda **more: nk.ik.legs(NAO, *FEET, **more).q,
    "numeric": lambda **more: nk.ik.numeric(NAO, "LLeg", T_FOOT, **more).q,
    "whole_body": lambda **more: nk.ik.whole_body(NAO, {}, **more).q,
    "follow": lambda **more: nk.ik.follow(NAO, {"Head": [np.eye(3)] * 2}, **more).q,
    "analytic": lambda **more: nk.ik.analytic(NAO, "LLeg", T_FOOT, **more).q,
    "to_q": lambda **more: TYPED.to_q(TYPED.from_q(Q), **more),
    "violations": lambda **more: TYPED.violations(TYPED.from_q(Q), **more),
    "from_order": lambda **more: nk.naoqi.from_order(NAO, np.zeros(22), "H21", **more),
}
ROWS = [row for row in FORMER_NAMES if not row.where.startswith("nao-kin")]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.old)
def test_a_former_name_gives_the_same_result_and_one_warning(
    row: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if row.where == "nk.ik.analytic":
        pytest.importorskip("eaik")
    former, new = CALLS[row.old, row.new]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        expected = new()
    with pytest.warns(FormerNameWarning, match=f"^{re.escape(row.old)} is now {re.escape(row.new)};") as caught:
        found = former()
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert str(found) == str(expected)


@pytest.mark.parametrize("name", SOLVERS)
def test_a_preferred_configuration_may_still_be_called_the_reference(name: str) -> None:
    if name == "analytic":
        pytest.importorskip("eaik")
    ask = SOLVERS[name]
    with pytest.warns(FormerNameWarning, match="^reference= is now near=") as caught:
        found = ask(reference=Q)
    assert len(caught) == 1
    assert str(found) == str(ask(near=Q))
    with pytest.raises(BadArgument, match="^reference= is the former name of near=; give one of them$"):
        ask(reference=Q, near=Q)


def test_the_documentation_lists_every_former_name() -> None:
    rows = re.findall(r"^\| `(.+?)` \| `(.+?)` \| (.+?) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert rows == [(row.old, row.new, row.where) for row in FORMER_NAMES]
