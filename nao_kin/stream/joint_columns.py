"""Rows of joint values, in any order of the joints, as configurations; and what is wrong with those that are none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin._common.headings import in_si_units
from nao_kin.configuration_files import HIPS_ADVICE, Hips, TableColumns, limits_advice, shared_motors
from nao_kin.errors import CouplingViolated, OutsideLimits, UnknownName
from nao_kin.robot import COUPLING_TOLERANCE, UNIT_TOLERANCE, LimitPolicy, RobotModel
from nao_kin.stream.results import Clamped, clamp

_OUTSIDE = "outside the joint limits: "


@dataclass(frozen=True)
class JointColumns:
    """What the columns of a table of joint values stand for.

    Attributes:
        robot: whose joints they are.
        table: joint and unit of every column; with `whole`, of those behind the seven of a floating base.
        limits: what to do with joints outside their limits: "raise", which makes the row a bad one, "clamp", "ignore".
        hips: how to settle two joints of one motor; None makes a row where they differ a bad one.
        whole: the columns are those of q itself.
    """

    robot: RobotModel
    table: TableColumns
    limits: LimitPolicy = "raise"
    hips: Hips | None = None
    whole: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.limits, str) or self.limits not in get_args(LimitPolicy):
            raise UnknownName("limits policy", self.limits, get_args(LimitPolicy))

    @property
    def base(self) -> int:
        """Columns of a floating base, which stand before the joints."""
        return self.robot.nq - len(self.robot.joint_names) if self.whole else 0

    def configurations(self, values: Floats) -> tuple[Floats, NDArray[np.bool_], Clamped]:
        """Configurations (m, nq) of the good rows of `values` (n, columns), which rows are good, what was clamped."""
        good: NDArray[np.bool_] = np.asarray(np.isfinite(values).all(axis=1))
        kept = values if good.all() else values[good]
        if self.base:
            unit = np.abs(np.linalg.norm(kept[:, 3:7], axis=1) - 1.0) <= UNIT_TOLERANCE
            kept = _narrow(good, unit, kept)
        q, agreeing = self._assembled(kept)
        q = _narrow(good, agreeing, q)
        if self.limits == "raise":
            q = _narrow(good, self.robot.within_limits(q), q)
        elif self.limits == "clamp":
            q, clamped = clamp(self.robot, q)
            return q, good, clamped
        return q, good, Clamped()

    def advice(self, row: Floats) -> str:
        """What may be done about a row (columns,) that is outside the limits, or whose joints disagree; else ""."""
        reason = self.problem(row)[1]
        if reason.startswith(_OUTSIDE):
            return limits_advice(self.robot, self.table, row[self.base :])
        return HIPS_ADVICE if " drives " in reason else ""

    def problem(self, row: Floats) -> tuple[int, str]:
        """Column, from 0 and -1 for none, and reason why a row (columns,) is no configuration."""
        for column in np.flatnonzero(~np.isfinite(row)).tolist():
            name = self.table.names[column - self.base] if column >= self.base else f"number {column + 1} of the base"
            return column, f"{name} is {float(row[column])}, expected a finite number"
        if self.base and abs(float(np.linalg.norm(row[3:7])) - 1.0) > UNIT_TOLERANCE:
            return 3, f"the base's quaternion has norm {float(np.linalg.norm(row[3:7])):.6g}, expected 1"
        names, values = shared_motors(
            self.robot, self.table.names, in_si_units(row[None, self.base :], self.table.units), self.hips
        )
        angles = dict(zip(names, values[0].tolist(), strict=True))
        try:
            self.robot.configuration(angles, limits=self.limits)
        except CouplingViolated as error:
            both_turn = self.robot.unit(error.mimic) == self.robot.unit(error.primary) == "rad"
            reason = error.describe(degrees=self.table.in_degrees and both_turn)
            return self.table.names.index(error.mimic) + self.base, reason
        except OutsideLimits as error:
            first = error.violations[0]
            more = f" (and {error.count - 1} more)" if error.count > 1 else ""
            # A joint that is named only through one that follows it has no column of its own.
            column = self.table.names.index(first.joint) + self.base if first.joint in self.table.names else -1
            reason = first.describe(degrees=self.table.in_degrees, index=False)
            return column, f"{_OUTSIDE}{reason}{more}"
        return -1, "no configuration"

    def _assembled(self, values: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Configurations (n, nq) of finite rows, and in which of them the joints of one motor agree."""
        robot = self.robot
        q = np.empty((len(values), robot.nq))
        q[:] = robot.neutral()
        q[:, : self.base] = values[:, : self.base]
        names, values = shared_motors(
            robot, self.table.names, in_si_units(values[:, self.base :], self.table.units), self.hips
        )
        joints = q[:, robot.nq - len(robot.joint_names) :]
        place = {name: column for column, name in enumerate(robot.joint_names)}
        own = [column for column, name in enumerate(names) if name in place]
        joints[:, [place[names[column]] for column in own]] = values[:, own]
        named = {names[column] for column in own}
        agreeing = np.ones(len(q), dtype=np.bool_)
        for column, name in enumerate(names):
            mimic = robot.mimics.get(name)
            if mimic is None:
                continue
            driver, value = joints[:, place[mimic.joint]], values[:, column]
            if mimic.joint not in named and mimic.multiplier != 0.0:
                driver[:] = mimic.driver_value(value)
                named.add(mimic.joint)
            else:
                agreeing &= np.abs(mimic.value(driver) - value) <= COUPLING_TOLERANCE
        return q, agreeing


def _narrow(good: NDArray[np.bool_], still: NDArray[np.bool_], rows: Floats) -> Floats:
    """Take off `good` what is not `still` good among the rows that were, and give the rows that stay."""
    if still.all():
        return rows
    good[np.flatnonzero(good)[~still]] = False
    return rows[still]
