"""Limits and mimics: the robot's beside two other readings of its URDF, and its judgements beside a scalar formula.

A driving joint has the limits that it shares with the joints that mimic it: the values at which all of them are inside
their own. That is worked out here once more, from what the other parsers read.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from nao_kin._common.arrays import Floats
from nao_kin._text import quoted
from nao_kin.crosscheck.mujoco_oracle import Oracle
from nao_kin.crosscheck.report import Tally
from nao_kin.crosscheck.yourdfpy_oracle import ParsedJoint, YourdfpyOracle
from nao_kin.robot import RobotModel
from nao_kin.semantics import CoupledLimit

_UNLIMITED = (-math.inf, math.inf)
# A value that misses a limit by less is on it, by the library's own definition.
_ON_THE_LIMIT = 1e-6


class LimitChecks:
    """The rows about limits and mimics."""

    def __init__(self, robot: RobotModel, second: Oracle) -> None:
        self._robot, self._second = robot, second
        self._tables = robot.coupled_limits
        self._fixed: list[Tally] = []
        is_urdf = isinstance(second, YourdfpyOracle)
        direct, note = _read_by_pinocchio(robot, second.joints) if is_urdf else (None, "")
        for oracle, joints in ((second.name, second.joints), ("pin.buildModelFromUrdf", direct)):
            if joints is not None:
                self._compare_limits(oracle, joints, note)
        self._compare_mimics(second.joints)
        self._violations = Tally("limit_violations", "scalar formula")
        self._clamped = Tally("clamp", "scalar formula")

    @property
    def tallies(self) -> list[Tally]:
        """The rows; none without joints."""
        return [*self._fixed, self._violations, self._clamped] if self._robot.joint_names else []

    def add(self, q: Floats, first: int) -> None:
        """Compare what the robot says about the limits of configurations (n, nq)."""
        names = self._robot.joint_names
        self._violations.compare(lambda: self._violation_differences(q), len(q), first, names)
        self._clamped.compare(lambda: self._clamp_differences(q), len(q), first, names)

    def _compare_limits(self, oracle: str, joints: Mapping[str, ParsedJoint], note: str) -> None:
        names = self._robot.joint_names
        expected = [_shared_limits(name, joints) for name in names]
        ours = (self._robot.lower, self._robot.upper, self._robot.velocity_limits, self._robot.effort_limits)
        for index, kind in enumerate(("lower", "upper", "velocity", "effort")):
            if kind not in self._second.kinds:
                continue
            theirs = [limits[index] for limits in expected]
            apart = [_apart(float(mine), other) for mine, other in zip(ours[index], theirs, strict=True)]
            tally = Tally(f"{kind} limits", oracle, note=note)
            tally.add(np.array([apart]), 0, names)
            self._fixed.append(tally)

    def _compare_mimics(self, joints: Mapping[str, ParsedJoint]) -> None:
        names = sorted(name for name in joints if name in self._robot.mimics or name not in self._robot.joint_names)
        if not names:
            return
        apart = []
        for name in names:
            mimic = self._robot.mimics.get(name)
            expected = None if mimic is None else _relation(name, mimic.joint, joints)
            if mimic is None or expected is None:
                apart.append(math.inf)
            else:
                apart.append(max(_apart(mimic.multiplier, expected[0]), _apart(mimic.offset, expected[1])))
        tally = Tally("mimics", self._second.name)
        tally.add(np.array([apart]), 0, names)
        self._fixed.append(tally)

    def _violation_differences(self, q: Floats) -> Floats:
        """How far the ranges are apart of each joint that is outside, infinite where only one finds it outside."""
        column = {name: index for index, name in enumerate(self._robot.joint_names)}
        found = {(v.index[0], column[v.joint]): (v.lower, v.upper) for v in self._robot.limit_violations(q)}
        apart = np.zeros(q.shape)
        for row, values in enumerate(q.tolist()):
            expected = self._violated(values)
            for index in range(len(values)):
                ours, theirs = found.get((row, index)), expected.get(index)
                if ours is not None and theirs is not None:
                    apart[row, index] = max(map(_apart, ours, theirs))
                elif ours is not theirs:
                    apart[row, index] = math.inf
        return apart

    def _violated(self, values: Sequence[float]) -> dict[int, tuple[float, float]]:
        """The joints outside their range, by column, with that range: the box, or inside it the table."""
        found = {}
        for index, name in enumerate(self._robot.joint_names):
            value, box = values[index], self._box(index)
            ranges = [box, *(self._table_range(table, values) for table in self._tables if table.joint == name)]
            for lower, upper in ranges:
                if value < lower - _ON_THE_LIMIT or value > upper + _ON_THE_LIMIT:
                    found[index] = (lower, upper)
                    break
        return found

    def _clamp_differences(self, q: Floats) -> Floats:
        return np.asarray(np.abs(self._robot.clamp(q) - np.array([self._clamp(row) for row in q.tolist()])))

    def _clamp(self, values: list[float]) -> list[float]:
        """Every joint into its box, then into its table at what the joint it depends on has become."""
        inside = [_between(value, *self._box(index)) for index, value in enumerate(values)]
        for table in self._tables:
            index = self._robot.joint_names.index(table.joint)
            inside[index] = _between(_between(inside[index], *self._table_range(table, inside)), *self._box(index))
        return inside

    def _box(self, index: int) -> tuple[float, float]:
        return float(self._robot.lower[index]), float(self._robot.upper[index])

    def _table_range(self, table: CoupledLimit, values: Sequence[float]) -> tuple[float, float]:
        """The range at a value of the other joint: linear between the rows of the table, constant outside."""
        value = values[self._robot.joint_names.index(table.of)]
        if value <= table.at[0]:
            return table.lower[0], table.upper[0]
        for i in range(1, len(table.at)):
            if value <= table.at[i]:
                part = (value - table.at[i - 1]) / (table.at[i] - table.at[i - 1])
                return (
                    (1.0 - part) * table.lower[i - 1] + part * table.lower[i],
                    (1.0 - part) * table.upper[i - 1] + part * table.upper[i],
                )
        return table.lower[-1], table.upper[-1]


@dataclass(frozen=True)
class _Bounds:
    """What one joint of a coupled group allows the driving joint."""

    lower: float
    upper: float
    velocity: float


def _read_by_pinocchio(
    robot: RobotModel, joints: Mapping[str, ParsedJoint]
) -> tuple[dict[str, ParsedJoint] | None, str]:
    """The moving joints as Pinocchio's own parser reads the file, mimics as given; or None and a note why not."""
    # The parser says on standard error what it misses: better not to ask.
    incomplete = [
        name
        for name, joint in joints.items()
        if not joint.continuous and (joint.velocity is None or joint.effort is None)
    ]
    if incomplete:
        return (
            None,
            f"not compared with Pinocchio's own parser, which needs velocity and effort of {quoted(incomplete[0])}",
        )
    try:
        expanded = robot.tree.expanded
        model = pin.buildModelFromXML(expanded) if expanded else pin.buildModelFromUrdf(str(robot.urdf_path))
    except (RuntimeError, ValueError):
        return None, "not compared with Pinocchio's own parser, which refuses the file"
    found = dict(joints)
    for name, joint in joints.items():
        if not model.existJointName(name):
            return None, f"not compared with Pinocchio's own parser, which has no joint {quoted(name)}"
        index = model.joints[model.getJointId(name)]
        speeds = float(model.upperVelocityLimit[index.idx_v]), float(model.upperEffortLimit[index.idx_v])
        found[name] = replace(joint, velocity=speeds[0], effort=speeds[1])
        # A limit without lower and upper is [0, 0] to this parser; what the file does not say it cannot confirm.
        if not joint.continuous and (joint.lower is not None or joint.upper is not None):
            lower, upper = float(model.lowerPositionLimit[index.idx_q]), float(model.upperPositionLimit[index.idx_q])
            found[name] = replace(found[name], lower=lower, upper=upper)
    return found, ""


def _shared_limits(driver: str, joints: Mapping[str, ParsedJoint]) -> tuple[float, float, float, float]:
    """lower, upper, velocity and effort of a driving joint and of all that follows it.

    Limits that were copied from joint to joint may leave no value, or a single one, to joints that can all move: then
    the driving joint's own range stands.
    """
    own = _own_bounds(joints[driver])
    followers = []
    for name, joint in joints.items():
        relation = _relation(name, driver, joints) if name != driver else None
        if relation is not None and relation[0] != 0.0:
            followers.append((_own_bounds(joint), *relation))
    lower, upper, velocity = [own.lower], [own.upper], [own.velocity]
    for bounds, multiplier, offset in followers:
        ends = sorted(((bounds.lower - offset) / multiplier, (bounds.upper - offset) / multiplier))
        lower.append(ends[0])
        upper.append(ends[1])
        velocity.append(bounds.velocity / abs(multiplier))
    low, high = _tightest(lower, max), _tightest(upper, min)
    can_move = own.lower < own.upper and all(bounds.lower < bounds.upper for bounds, _, _ in followers)
    if low >= high and can_move:
        low, high = own.lower, own.upper
    effort = joints[driver].effort
    return low, high, _tightest(velocity, min), math.inf if effort is None or effort < 0.0 else effort


def _own_bounds(joint: ParsedJoint) -> _Bounds:
    """The limits of one joint alone: none where the file gives no range, or one whose ends are the wrong way round."""
    velocity = math.inf if joint.velocity is None or joint.velocity < 0.0 else joint.velocity
    lower, upper = joint.lower or 0.0, joint.upper or 0.0
    if joint.continuous or (joint.lower is None and joint.upper is None) or lower > upper:
        lower, upper = _UNLIMITED
    return _Bounds(lower, upper, velocity)


def _relation(name: str, driver: str, joints: Mapping[str, ParsedJoint]) -> tuple[float, float] | None:
    """(multiplier, offset) with value of `name` = multiplier · value of `driver` + offset; None where there is none.

    The file may couple the two the other way round, or both to a third joint.
    """
    (root, m, b), (other_root, m_driver, b_driver) = _root(name, joints), _root(driver, joints)
    if root != other_root or m_driver == 0.0:
        return None
    return m / m_driver, b - m / m_driver * b_driver


def _root(name: str, joints: Mapping[str, ParsedJoint]) -> tuple[str, float, float]:
    """The joint at the end of a chain of mimics, and the multiplier and offset that lead back from it."""
    multiplier, offset = 1.0, 0.0
    for _ in joints:
        follows = joints[name].follows if name in joints else None
        if follows is None:
            break
        name, offset, multiplier = follows[0], offset + multiplier * follows[2], multiplier * follows[1]
    return name, multiplier, offset


def _tightest(bounds: Sequence[float], choose: Callable[[Sequence[float]], float]) -> float:
    """The tightest bound; the first of those that differ from it by rounding only."""
    tightest = choose(bounds)
    return next(
        bound for bound in bounds if bound == tightest or math.isclose(bound, tightest, rel_tol=1e-9, abs_tol=1e-12)
    )


def _between(value: float, lower: float, upper: float) -> float:
    return min(max(value, lower), upper)


def _apart(ours: float, theirs: float) -> float:
    """|ours − theirs|, zero for equal infinities."""
    return 0.0 if ours == theirs else abs(ours - theirs)
