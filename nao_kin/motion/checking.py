"""Whether a robot can move so: limits, coupled limits, speed limits, and joints that share a motor."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, finite_or_none
from nao_kin.motion.configurations import HOLD, checked_rate
from nao_kin.motion.curves import Excesses, JointCurves, Quantity, combination, excesses, pieces_of
from nao_kin.motion.interpolation import Segments
from nao_kin.motion.motion import Motion, check_both
from nao_kin.robot import COUPLING_TOLERANCE, LIMIT_TOLERANCE, RobotModel
from nao_kin.robot.semantics import CoupledLimit

# --- What a check of a motion finds: stretches of time in which a joint may not do what it is to do.

Kind = Literal["limit", "coupled limit", "speed", "motor"]
# A message lists the worst this many stretches of a joint and kind.
_LISTED = 3


@dataclass(frozen=True)
class MotionViolation:
    """A stretch of time in which a joint is outside one bound.

    Attributes:
        kind: "limit": its own range. "coupled limit": the range that another joint leaves it. "speed": its largest
            speed. "motor": what its motor does, which is said otherwise by another joint of that motor.
        joint: its name.
        start: from when [s].
        end: until when [s].
        time: when it is worst [s].
        value: value then, or speed for "speed".
        lower: smallest value allowed then.
        upper: largest value allowed then.
        unit: unit of these three.
        of: the other joint, for a coupled limit and a motor; None for none.
        of_value: its value then.

    Examples:
        >>> nao = nk.load_nao()
        >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
        >>> violation = nk.motion.check(nao, turn).violations[0]
        >>> violation.joint, round(violation.value, 3), round(violation.upper, 3)
        ('HeadYaw', 15.0, 8.268)
    """

    kind: Kind
    joint: str
    start: float
    end: float
    time: float
    value: float
    lower: float
    upper: float
    unit: str
    of: str | None = None
    of_value: float = 0.0

    @property
    def excess(self) -> float:
        """How far outside it is where it is worst."""
        return max(self.lower - self.value, self.value - self.upper)

    def describe(self, *, degrees: bool = False) -> str:
        """The stretch in words, with angles in degrees if wanted.

        Examples:
            >>> nao = nk.load_nao()
            >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
            >>> nk.motion.check(nao, turn).violations[0].describe()
            'HeadYaw moves at 15 at 0 s, 6.73 rad/s outside [-8.26797, 8.26797] rad/s (0 to 0.1 s)'
        """
        turns = degrees and self.unit.startswith("rad")
        scale = math.degrees(1.0) if turns else 1.0
        unit = self.unit.replace("rad", "°") if turns else {"1": "", "1/s": "/s"}.get(self.unit, f" {self.unit}")
        value, lower, upper, excess, of_value = (
            number * scale for number in (self.value, self.lower, self.upper, self.excess, self.of_value)
        )
        when = f"{self.start:.6g} s" if self.start == self.end else f"{self.start:.6g} to {self.end:.6g} s"
        what = " moves at" if self.kind == "speed" else " ="
        text = f"{self.joint}{what} {value:.6g} at {self.time:.6g} s, "
        if self.kind == "motor":
            text += f"{self.of} = {of_value:.6g}{unit}: one motor, {excess:.3g}{unit} apart"
        else:
            text += f"{excess:.3g}{unit} outside [{lower:.6g}, {upper:.6g}]{unit}"
            text += f" at {self.of} = {of_value:.6g}" if self.of is not None else ""
        return f"{text} ({when})"

    def as_dict(self) -> dict[str, Any]:
        """For JSON: what is infinite is None.

        Examples:
            >>> nao = nk.load_nao()
            >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
            >>> nk.motion.check(nao, turn).violations[0].as_dict()["joint"]
            'HeadYaw'
        """
        numbers = ("start", "end", "time", "value", "lower", "upper", "excess")
        found: dict[str, Any] = {"kind": self.kind, "joint": self.joint, "unit": self.unit}
        found |= {name: finite_or_none(float(getattr(self, name))) for name in numbers}
        return found | ({} if self.of is None else {"of": self.of, "of_value": self.of_value})


@dataclass(frozen=True)
class MotionReport:
    """What is wrong with a motion.

    Attributes:
        robot: name of the robot.
        joints: those that the motion names.
        start: its first key [s].
        end: its last key [s].
        violations: by kind, joint and time; of one bound of one joint not more than the 1 000 worst.
        left_out: how many more there are.
        sampled: samples per second between which something of coupled limits or shared motors could hide; None where
            everything was found in closed form.

    Examples:
        >>> nao = nk.load_nao()
        >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
        >>> report = nk.motion.check(nao, turn)
        >>> report.ok, report.violations[0].kind
        (False, 'speed')
    """

    robot: str
    joints: tuple[str, ...]
    start: float
    end: float
    violations: tuple[MotionViolation, ...]
    left_out: int
    sampled: float | None

    @property
    def ok(self) -> bool:
        """Whether the robot can move so."""
        return not self.violations

    @property
    def worst(self) -> tuple[MotionViolation, ...]:
        """Of every kind and joint the stretch with the largest excess, in the order of `violations`."""
        found: dict[tuple[str, str], MotionViolation] = {}
        for violation in self.violations:
            key = violation.kind, violation.joint
            if key not in found or violation.excess > found[key].excess:
                found[key] = violation
        return tuple(found.values())

    def describe(self, *, degrees: bool = False) -> str:
        """One line for each stretch, the longest lists shortened; one line if all is well.

        Examples:
            >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
            >>> nk.motion.check(nk.load_nao(), nod).describe()
            'nao_v6 can move so: 1 joints, 0 to 1 s'
        """
        span = f"{len(self.joints)} joints, {self.start:g} to {self.end:g} s"
        if self.ok:
            return f"{self.robot} can move so: {span}"
        lines = [f"{self.robot} cannot move so: {span}, {_counted(self.violations)}"]
        groups: dict[tuple[str, str], list[MotionViolation]] = {}
        for violation in self.violations:
            groups.setdefault((violation.kind, violation.joint), []).append(violation)
        for (kind, _), group in groups.items():
            group.sort(key=lambda violation: -violation.excess)
            lines += [f"{kind}: {violation.describe(degrees=degrees)}" for violation in group[:_LISTED]]
            if len(group) > _LISTED:
                lines.append(f"{kind}: {group[0].joint}: and {len(group) - _LISTED} more stretches")
        if self.left_out:
            lines.append(f"and {self.left_out} smaller ones")
        if self.sampled is not None:
            lines.append(f"coupled limits and shared motors were looked at {self.sampled:g} times per second")
        return "\n".join(lines)

    def as_dict(self) -> dict[str, Any]:
        """For JSON, in seconds, radians, metres and ratios.

        Examples:
            >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
            >>> nk.motion.check(nk.load_nao(), nod).as_dict()["violations"]
            []
        """
        return {
            "robot": self.robot,
            "ok": self.ok,
            "joints": list(self.joints),
            "start": self.start,
            "end": self.end,
            "sampled": self.sampled,
            "left_out": self.left_out,
            "violations": [violation.as_dict() for violation in self.violations],
        }

    def __repr__(self) -> str:
        return f"<MotionReport: {'ok' if self.ok else _counted(self.violations)}>"


def _counted(violations: Iterable[MotionViolation]) -> str:
    counts = Counter(violation.kind for violation in violations)
    words = {"limit": "stretches outside limits", "coupled limit": "outside coupled limits"}
    words |= {"speed": "too fast", "motor": "of disagreeing joints"}
    return ", ".join(f"{count} {words[kind]}" for kind, count in counts.items())


# --- Whether a robot can move so: limits, coupled limits, speed limits, and joints that share a motor.

# Of a speed limit, as a share of it: times are differences of rounded numbers.
SPEED_TOLERANCE = 1e-9
_RATE = 1000.0

# Stretches, and how many more there are.
_Found = tuple[list[MotionViolation], int]


def check(robot: RobotModel, motion: Motion, *, fill: str | ArrayLike = HOLD, rate: float = _RATE) -> MotionReport:
    """Whether a robot can move so, between the keys too.

    The largest and smallest value and speed of every joint are found in closed form, whatever the interpolation, and so
    are the distances to coupled limits and between the joints of one motor of linear and smooth motions. For Bezier
    motions these two are sampled, with a cubic between two samples.

    Args:
        robot: which has all the joints named.
        motion: what it is to do.
        fill: where joints are that the motion does not name, as in `Motion.configurations`; coupled limits need it.
        rate: samples per second of what is sampled.

    Returns:
        The stretches of time in which a joint is outside a bound. Two joints of one motor, such as the two HipYawPitch,
        must agree to 1e-6.

    Raises:
        UnknownName: the robot has no such joint or posture.
        BadArgument: no positive rate.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.check(nk.load_nao(), nod).ok
        True
    """
    check_both(robot, motion)
    rate = checked_rate(rate)
    curves = JointCurves(motion, fill, robot, rate)
    findings = [
        *(_limits(robot, joint, curves[joint]) for joint in motion.joint_names),
        *(_coupled(robot, motion, table, curves) for table in robot.coupled_limits),
        *(_speeds(robot, joint, curves[joint]) for joint in motion.joint_names),
        *(
            _disagreement(robot, first, joint, curves)
            for first, *others in shared_motors(robot, motion).values()
            for joint in others
        ),
    ]
    return MotionReport(
        robot=robot.name,
        joints=motion.joint_names,
        start=motion.start,
        end=motion.end,
        violations=tuple(row for rows, _ in findings for row in rows),
        left_out=sum(left_out for _, left_out in findings),
        sampled=rate if curves.sampled else None,
    )


def joint_range(robot: RobotModel, joint: str) -> tuple[float, float]:
    """Smallest and largest value of a joint, one that follows another included."""
    mimic = robot.mimics.get(joint)
    column = robot.joint_names.index(joint if mimic is None else mimic.joint)
    box = float(robot.lower[column]), float(robot.upper[column])
    return box if mimic is None else mimic.range(*box)


def largest_speed(robot: RobotModel, joint: str) -> float:
    """Speed limit of a joint, one that follows another included."""
    mimic = robot.mimics.get(joint)
    column = robot.joint_names.index(joint if mimic is None else mimic.joint)
    return float(robot.velocity_limits[column]) * (1.0 if mimic is None else abs(mimic.multiplier))


def _limits(robot: RobotModel, joint: str, curve: Segments) -> _Found:
    lower, upper = joint_range(robot, joint)
    found = _both_sides(curve, "value", lower, upper, LIMIT_TOLERANCE)
    return _violations("limit", joint, found, lower, upper, robot.unit(joint))


def _speeds(robot: RobotModel, joint: str, curve: Segments) -> _Found:
    limit = largest_speed(robot, joint)
    found = _both_sides(curve, "speed", -limit, limit, SPEED_TOLERANCE * limit)
    return _violations("speed", joint, found, -limit, limit, f"{robot.unit(joint)}/s")


def _violations(kind: Kind, joint: str, found: Excesses, lower: float, upper: float, unit: str) -> _Found:
    rows = ((row.start, row.end, row.time, row.value, lower, upper, unit) for row in found.rows)
    return [MotionViolation(kind, joint, *row) for row in rows], found.left_out


def _coupled(robot: RobotModel, motion: Motion, table: CoupledLimit, curves: JointCurves) -> _Found:
    """Where a joint is outside the range that another one leaves it."""
    if table.joint not in motion.joint_names and table.of not in motion.joint_names:
        return [], 0
    joint, of = curves[table.joint], curves[table.of]
    times = curves.common_times(table.joint, table.of, bends=bends(of, table))
    unit = robot.unit(table.joint)
    rows, left_out = list[MotionViolation](), 0
    for bound, sign in ((table.upper, 1.0), (table.lower, -1.0)):
        slopes = np.concatenate([[0.0], np.diff(bound) / np.diff(table.at), [0.0]])
        # On each interval the bound is one straight line over the other joint's value.
        middle = curves.values(table.of, 0.5 * (times[:-1] + times[1:]))
        slope = slopes[np.searchsorted(table.at, middle)]
        at_ends = np.interp(curves.values(table.of, times), table.at, bound)
        over = combination(joint, of, times, slope, curves.values(table.joint, times) - at_ends)
        found = excesses(over, "value", 0.0, sign, LIMIT_TOLERANCE)
        left_out += found.left_out
        for row in found.rows:
            value, of_value = curves.values_at(row.time, table.joint, table.of)
            lower, upper = (float(end) for end in table.range(np.array(of_value)))
            numbers = row.start, row.end, row.time, value, lower, upper
            rows.append(MotionViolation("coupled limit", table.joint, *numbers, unit, table.of, of_value))
    return sorted(rows, key=lambda row: row.start), left_out


def bends(of: Segments, table: CoupledLimit) -> Floats:
    """When a joint passes a value at which the range of the other one bends [s]."""
    pieces = pieces_of(of, "value", np.arange(len(of.start)))
    low, high = pieces.values.min(axis=1), pieces.values.max(axis=1)
    found = [np.zeros(0)]
    for level in table.at:
        passed = np.flatnonzero((low < level) & (level < high))
        found.append(pieces.crossings(passed, level))
    return np.concatenate(found)


def _disagreement(robot: RobotModel, first: str, joint: str, curves: JointCurves) -> _Found:
    """Where a joint does not do what another one of its motor makes of it."""
    mimic, reference = robot.mimics[joint], robot.mimics.get(first)
    follows = mimic if reference is None else mimic.through(reference.inverted(first))
    factor = follows.multiplier
    times = curves.common_times(first, joint)
    miss = curves.values(joint, times) - follows.value(curves.values(first, times))
    apart = combination(curves[joint], curves[first], times, np.full(len(times) - 1, factor), miss)
    found = _both_sides(apart, "value", 0.0, 0.0, COUPLING_TOLERANCE)
    rows = []
    for row in found.rows:
        value, other = curves.values_at(row.time, joint, first)
        wanted = float(follows.value(other))
        numbers = row.start, row.end, row.time, value, wanted, wanted
        rows.append(MotionViolation("motor", joint, *numbers, robot.unit(joint), first, other))
    return rows, found.left_out


def shared_motors(robot: RobotModel, motion: Motion) -> dict[str, list[str]]:
    """Driving joint → those joints of a motion that its motor moves, itself first, where they are several."""
    found: dict[str, list[str]] = {}
    for joint in motion.joint_names:
        mimic = robot.mimics.get(joint)
        if mimic is None:
            found.setdefault(joint, []).insert(0, joint)
        elif mimic.multiplier != 0.0:
            found.setdefault(mimic.joint, []).append(joint)
    return {driver: joints for driver, joints in found.items() if len(joints) > 1}


def _both_sides(curve: Segments, quantity: Quantity, lower: float, upper: float, tolerance: float) -> Excesses:
    above = excesses(curve, quantity, upper, 1.0, tolerance)
    below = excesses(curve, quantity, lower, -1.0, tolerance)
    rows = sorted([*above.rows, *below.rows], key=lambda row: row.start)
    return Excesses(rows, above.left_out + below.left_out)
