"""Solutions in collision are left out, and the report says so."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.ik import IKResult, Reason

CROSSED = {"LShoulderRoll": -0.3, "LElbowRoll": -1.5, "RElbowRoll": 0.04}


def _solved(nao: nk.NaoModel, solver: str, q: np.ndarray, **more: Any) -> IKResult:
    if solver in ("leg", "arm"):
        frame = {"leg": "LLeg", "arm": "LArm"}[solver]
        # The limits leave some targets with fewer solutions than others.
        limits = {"leg": "enforce", "arm": "ignore"}[solver]
        return getattr(nk.ik, solver)(nao, "L", nao.fk(q, frame), reference=q, limits=limits, **more)
    if solver == "legs":
        return nk.ik.legs(nao, nao.fk(q, "LLeg"), nao.fk(q, "RLeg"), reference=q, limits="ignore", **more)
    if solver == "head":
        return nk.ik.head(nao, nao.rotation(q, "Head"), reference=q, **more)
    if solver == "look_at":
        T = nao.fk(q, "CameraTop")
        return nk.ik.look_at(nao, T[..., :3, 3] + 0.5 * T[..., :3, 0], reference=q, limits="ignore", **more)
    return nk.ik.numeric(nao, "LArm", nao.fk(q, "LArm"), reference=q, **more)


@pytest.mark.parametrize("solver", ["leg", "arm", "legs", "head", "look_at", "numeric"])
def test_exactly_the_solutions_in_collision_are_left_out(solver: str) -> None:
    nao = nk.load_nao()
    q = nao.random(3, 10 if solver == "numeric" else 60)
    every, free = _solved(nao, solver, q), _solved(nao, solver, q, collisions=True)
    for index in range(len(q)):
        solutions = every.solutions[index, : every.count[index]]
        kept = solutions[[bool(nao.clearance(row).is_free) for row in solutions]]
        np.testing.assert_array_equal(free.solutions[index, : free.count[index]], kept)
        assert np.isnan(free.solutions[index, free.count[index] :]).all()
        if len(kept):
            np.testing.assert_array_equal(free.q[index], kept[0])
            assert free.reasons[index] == Reason.REACHED
        elif len(solutions):
            assert free.reasons[index] == Reason.COLLISION
            least = [float(nao.clearance(row).distance) for row in solutions]
            assert nao.clearance(free.q[index]).distance == pytest.approx(max(least), abs=1e-12)
            assert free.obstacles.needed[index] == pytest.approx(-max(least), abs=1e-12)
            assert "every solution has links that overlap" in free.describe((index,))
        else:
            assert free.reasons[index] == every.reasons[index]
    assert (free.reasons == Reason.REACHED).any()
    assert (free.reasons == Reason.COLLISION).any()
    left = int(every.count.sum() - free.count.sum())
    assert free.notes[-1] == f"{left} of {every.count.sum()} solutions are left out: links overlap"


def test_one_target_says_which_links_overlap() -> None:
    nao = nk.load_nao()
    q = nao.configuration(CROSSED)
    result = nk.ik.arm(nao, "L", nao.fk(q, "LArm"), reference=q, collisions=True)
    assert result.reason is Reason.COLLISION
    assert not result.success
    assert result.message == "every solution has links that overlap: RBicep and l_wrist by 15.94 mm or more"
    np.testing.assert_allclose(result.q, q, atol=1e-9)


def test_a_result_without_collisions_is_unchanged() -> None:
    nao = nk.load_nao()
    q = nao.posture("StandInit")
    one, other = (nk.ik.arm(nao, "L", nao.fk(q, "LArm"), collisions=collisions) for collisions in (False, True))
    np.testing.assert_array_equal(one.q, other.q)
    assert one.notes == other.notes == ()
    far = nk.ik.arm(nao, "L", [1.0, 0.0, 0.0], collisions=True)
    assert far.reason is Reason.OUT_OF_REACH
