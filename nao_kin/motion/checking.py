"""Whether a robot can move so: limits, coupled limits, speed limits, and joints that share a motor."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats, as_floats
from nao_kin._text import quoted
from nao_kin.errors import BadArgument
from nao_kin.motion.configurations import HOLD, check_joints, filled
from nao_kin.motion.curves import JointCurves, combination
from nao_kin.motion.interpolation import Segments
from nao_kin.motion.monotone import Excesses, Quantity, excesses, pieces_of
from nao_kin.motion.motion import Motion, check_motion
from nao_kin.motion.report import MotionReport, MotionViolation
from nao_kin.robot import COUPLING_TOLERANCE, LIMIT_TOLERANCE, RobotModel, check_robot
from nao_kin.semantics import CoupledLimit

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
    check_robot(robot)
    check_motion(motion)
    check_joints(robot, motion)
    number = as_floats(rate, (), "rate")
    if number.shape != () or not number > 0.0:
        raise BadArgument(f"rate must be a number above zero, got {quoted(rate)}")
    curves = JointCurves(motion, filled(robot, fill)[robot.nq - len(robot.joint_names) :], robot, float(number))
    findings = [
        *(_limits(robot, joint, curves[joint]) for joint in motion.joint_names),
        *(_coupled(robot, motion, table, curves) for table in robot.coupled_limits),
        *(_speeds(robot, joint, curves[joint]) for joint in motion.joint_names),
        *_motors(robot, motion, curves),
    ]
    return MotionReport(
        robot=robot.name,
        joints=motion.joint_names,
        start=motion.start,
        end=motion.end,
        violations=tuple(row for rows, _ in findings for row in rows),
        left_out=sum(left_out for _, left_out in findings),
        sampled=float(number) if curves.sampled else None,
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
    unit = robot.unit(joint)
    found = _both_sides(curve, "value", lower, upper, LIMIT_TOLERANCE)
    return [
        MotionViolation("limit", joint, row.start, row.end, row.time, row.value, lower, upper, unit)
        for row in found.rows
    ], found.left_out


def _speeds(robot: RobotModel, joint: str, curve: Segments) -> _Found:
    limit = largest_speed(robot, joint)
    unit = f"{robot.unit(joint)}/s"
    found = _both_sides(curve, "speed", -limit, limit, SPEED_TOLERANCE * limit)
    return [
        MotionViolation("speed", joint, row.start, row.end, row.time, row.value, -limit, limit, unit)
        for row in found.rows
    ], found.left_out


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
            value, of_value = (float(curves.values(name, np.array([row.time]))[0]) for name in (table.joint, table.of))
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


def _motors(robot: RobotModel, motion: Motion, curves: JointCurves) -> list[_Found]:
    """Where joints of one motor are to do different things."""
    return [
        _disagreement(robot, joints[0], joint, curves)
        for joints in shared_motors(robot, motion).values()
        for joint in joints[1:]
    ]


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
        value, other = (float(curves.values(name, np.array([row.time]))[0]) for name in (joint, first))
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
