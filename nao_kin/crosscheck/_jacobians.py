"""Joint axes as Plücker lines, against Pinocchio's Jacobians."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from nao_kin._arrays import Floats
from nao_kin.crosscheck._gaps import gap
from nao_kin.crosscheck._tally import LEFT_OUT, Tally
from nao_kin.crosscheck.conversions import Conversions
from nao_kin.robot import RobotModel

_EXPRESSIONS: tuple[Literal["frame", "root", "mixed"], ...] = ("frame", "root", "mixed")


class Jacobians:
    """One row for each way to express a Jacobian: the columns are the axes' Plücker coordinates."""

    def __init__(self, robot: RobotModel, conversions: Conversions, frames: Sequence[str]) -> None:
        self._robot, self._frames = robot, frames
        self._axes = conversions.joint_axes(robot)
        note = "each frame at one configuration in a hundred"
        ways = _EXPRESSIONS if robot.joint_names else ()
        self._tallies = {way: Tally(f"joint axes as lines, {way}", "Pinocchio", note=note) for way in ways}

    @property
    def tallies(self) -> list[Tally]:
        """The rows; none without joints."""
        return list(self._tallies.values())

    def add(self, q: Floats, first: int) -> None:
        """Compare every frame at one of the configurations (n, nq), another one for each frame."""
        for way, tally in self._tallies.items():
            apart = np.full((len(q), len(self._frames)), LEFT_OUT)
            for column, frame in enumerate(self._frames):
                row = (first + column) % len(q)
                ours = self._axes.jacobian(q[row], frame, expressed_in=way)
                apart[row, column] = gap(ours[None], self._robot.jacobian(q[row], frame, expressed_in=way)[None])[0]
            tally.add(apart, first, self._frames)
