"""Caches made from a robot do not keep the robot in memory."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import nao_kin as nk

SOLVERS: dict[str, Callable[[nk.NaoModel, np.ndarray], Any]] = {
    "leg": lambda nao, q: nk.ik.leg(nao, "L", nao.fk(q, "LLeg")),
    "legs": lambda nao, q: nk.ik.legs(nao, *nao.fk(q, ["LLeg", "RLeg"])),
    "arm": lambda nao, q: nk.ik.arm(nao, "L", nao.fk(q, "LArm")),
    "head": lambda nao, q: nk.ik.head(nao, nao.rotation(q, "Head")),
    "look_at": lambda nao, q: nk.ik.look_at(nao, [1.0, 0.0, 0.2]),
    "numeric": lambda nao, q: nk.ik.numeric(nao, "LArm", nao.fk(q, "LArm")),
    "velocity": lambda nao, q: nk.ik.velocity(nao, q, np.zeros(6), "LLeg"),
    "follow": lambda nao, q: nk.ik.follow(nao, {"LLeg": nao.fk(q, "LLeg")[None]}),
    "limbs": lambda nao, q: nk.ik.limbs(nao),
}


@pytest.mark.full
@pytest.mark.parametrize("name", SOLVERS)
def test_a_robot_that_nobody_needs_is_let_go(name: str) -> None:
    nao = nk.load_nao("v6")
    answer = SOLVERS[name](nao, nao.posture("Crouch"))
    robot = weakref.ref(nao)
    del nao
    gc.collect()
    assert robot() is None
    assert answer is not None
