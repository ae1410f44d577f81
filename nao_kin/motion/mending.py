"""Motions that leave the limits of a robot moved into them, and joints of one motor made to agree."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats
from nao_kin.errors import BadArgument
from nao_kin.motion.changes import STRAIGHT_RATE, Change, Mended, changed_stretches, straightened
from nao_kin.motion.checking import bends, check, joint_range, shared_motors
from nao_kin.motion.configurations import HOLD, Hips, check_hips, check_joints, filled, motor_values
from nao_kin.motion.curves import JointCurves
from nao_kin.motion.monotone import pieces_of
from nao_kin.motion.motion import Motion, check_motion
from nao_kin.motion.sides import side_of
from nao_kin.robot import LIMIT_TOLERANCE, RobotModel, check_robot
from nao_kin.semantics import CoupledLimit


def clamp(robot: RobotModel, motion: Motion, *, fill: str | ArrayLike = HOLD) -> Mended:
    """The motion with keys moved into the limits, and then into the coupled ones.

    A key outside the range of its joint goes to the end of the range. A Bezier segment that overshoots has the ends of
    its handles moved too: a curve stays within the hull of its control points. Then, where a joint leaves the range
    that another one gives it, a linear motion gets further keys and a smooth or a Bezier one becomes linear, with 100
    keys per second and one wherever a coupled limit bends; and these keys are moved into the range.

    Args:
        robot: which has all the joints named.
        motion: what to change.
        fill: where joints are that the motion does not name, as in `Motion.configurations`.

    Raises:
        UnknownName: the robot has no such joint or posture.
        BadArgument: a joint that the motion does not name is where a coupled limit refuses one that it names.

    Examples:
        >>> nao = nk.load_nao()
        >>> turn = nk.Motion([0.0, 2.0], ["HeadYaw"], [[0.0], [3.0]])
        >>> float(nk.motion.clamp(nao, turn).motion.sample(2.0)[0].round(4))
        2.0857
    """
    check_robot(robot)
    check_motion(motion)
    check_joints(robot, motion)
    boxed, changes = _into_boxes(robot, motion)
    others = filled(robot, fill)[robot.nq - len(robot.joint_names) :]
    coupled = [row for row in check(robot, boxed, fill=fill).violations if row.kind == "coupled limit"]
    if not coupled:
        return Mended(boxed if changes else motion, tuple(changes))
    fixed = next((row for row in coupled if row.joint not in motion.joint_names), None)
    if fixed is not None:
        raise BadArgument(
            f"the motion moves {fixed.of} and not {fixed.joint}, which would be outside: {fixed.describe()}; "
            "fill it in from another posture, or add it to the motion"
        )
    if boxed.interpolation != "linear":
        boxed, change = straightened(robot, boxed)
        changes.append(change)
    for table in robot.coupled_limits:
        if table.joint in boxed.joint_names:
            boxed, moved = _into_table(robot, boxed, table, others)
            changes += moved
    return Mended(boxed, tuple(changes))


def share_motors(robot: RobotModel, motion: Motion, hips: Hips = "average") -> Mended:
    """The motion with joints of one motor, such as the two HipYawPitch, made to agree.

    The left or the right curve is copied. The average of smooth or Bezier curves is exact where both have their keys at
    the same times, the motion then being a Bezier one; else the motion becomes linear, with 100 keys per second.

    Args:
        robot: which has all the joints named.
        motion: what to change.
        hips: which of them is right, as in `Motion.configurations`.

    Raises:
        UnknownName: the robot has no such joint, or there is no such rule.

    Examples:
        >>> nao = nk.load_nao()
        >>> split = nk.Motion([0.0, 1.0], ["LHipYawPitch", "RHipYawPitch"], [[0.0, 0.0], [-0.2, -0.4]])
        >>> nk.motion.share_motors(nao, split).motion.sample(1.0).round(9).tolist()
        [-0.3, -0.3]
    """
    check_robot(robot)
    check_motion(motion)
    check_joints(robot, motion)
    check_hips(hips)
    apart = {row.of for row in check(robot, motion).violations if row.kind == "motor"}
    groups = [joints for joints in shared_motors(robot, motion).values() if joints[0] in apart]
    if not groups:
        return Mended(motion, ())
    mended = motion if motion.interpolation == "linear" else motion.as_bezier()
    changes = list[Change]()
    if mended.handles is not None and not all(_same_times(mended, _chosen(joints, hips)) for joints in groups):
        mended, change = straightened(robot, motion)
        changes.append(change)
    times, keys, handles = list(mended.times), list(mended.keys), list(mended.handles or ())
    for joints in groups:
        sources = [mended.joint_names.index(joint) for joint in _chosen(joints, hips)]
        knots = np.unique(np.concatenate([mended.times[column] for column in sources]))
        values = dict(zip(mended.joint_names, mended.sample(knots).T, strict=True))
        ((_, motor),) = motor_values(robot, {name: values[name] for name in joints}, hips).items()
        for joint in joints:
            column, mimic = mended.joint_names.index(joint), robot.mimics.get(joint)
            times[column], keys[column] = knots, motor if mimic is None else mimic.value(motor)
            if handles:
                offsets = [
                    mended.handles[source] * (1.0, _scale(robot, mended.joint_names[source], joint))  # type: ignore[index]
                    for source in sources
                ]
                handles[column] = np.mean(offsets, axis=0)
            miss = keys[column] - values[joint]
            changes += changed_stretches("one motor", joint, knots, miss, robot.unit(joint))
    return Mended(Motion(times, mended.joint_names, keys, mended.interpolation, handles or None), tuple(changes))


def _chosen(joints: list[str], hips: Hips) -> list[str]:
    """Those joints of one motor that say what it does."""
    return [joint for joint in joints if side_of(joint) == hips] or joints


def _same_times(motion: Motion, joints: list[str]) -> bool:
    """Whether the keys of some joints, and the ends of their handles, are at the same times."""
    columns = [motion.joint_names.index(joint) for joint in joints]
    handles = motion.handles or ()
    return all(
        np.array_equal(motion.times[column], motion.times[columns[0]])
        and np.allclose(handles[column][..., 0], handles[columns[0]][..., 0], rtol=1e-12, atol=0.0)
        for column in columns[1:]
    )


def _scale(robot: RobotModel, source: str, joint: str) -> float:
    """How much a joint moves while another one of its motor moves by one."""
    moves = [robot.mimics[name].multiplier if name in robot.mimics else 1.0 for name in (joint, source)]
    return moves[0] / moves[1]


def _into_boxes(robot: RobotModel, motion: Motion) -> tuple[Motion, list[Change]]:
    keys, handles = list[Floats](), list[Floats]()
    changes = list[Change]()
    for column, joint in enumerate(motion.joint_names):
        lower, upper = joint_range(robot, joint)
        given = motion.keys[column]
        outside = (given < lower - LIMIT_TOLERANCE) | (given > upper + LIMIT_TOLERANCE)
        clipped = np.where(outside, np.clip(given, lower, upper), given)
        miss = np.abs(clipped - given)
        if motion.handles is not None:
            offsets = np.array(motion.handles[column])
            # The end of a handle stays where it was, or goes to the end of the range, if its segment overshoots.
            ends = given[:, None] + offsets[..., 1]
            offsets[..., 1] = np.where(outside[:, None], ends - clipped[:, None], offsets[..., 1])
            for side, neighbours in ((0, slice(1, None)), (1, slice(None, -1))):
                over = _overshoots(motion, column, lower, upper)
                wanted = np.clip(ends[neighbours, side], lower, upper)
                moved = over & (np.abs(wanted - ends[neighbours, side]) > LIMIT_TOLERANCE)
                offsets[neighbours, side, 1] = np.where(
                    moved, wanted - clipped[neighbours], offsets[neighbours, side, 1]
                )
                miss[neighbours] = np.maximum(miss[neighbours], moved * np.abs(wanted - ends[neighbours, side]))
            handles.append(offsets)
        keys.append(clipped)
        changes += changed_stretches("clamped", joint, motion.times[column], miss, robot.unit(joint))
    if not changes:
        return motion, []
    return Motion(motion.times, motion.joint_names, keys, motion.interpolation, handles or None), changes


def _overshoots(motion: Motion, column: int, lower: float, upper: float) -> NDArray[np.bool_]:
    """Which segments of a joint leave its range somewhere, its keys included."""
    curve = motion.segments[column]
    pieces = pieces_of(curve, "value", np.arange(len(curve.start)))
    outside = ((pieces.values < lower - LIMIT_TOLERANCE) | (pieces.values > upper + LIMIT_TOLERANCE)).any(axis=1)
    found = np.zeros(len(curve.start), dtype=np.bool_)
    found[pieces.segment[outside]] = True
    return found


def _into_table(robot: RobotModel, motion: Motion, table: CoupledLimit, others: Floats) -> tuple[Motion, list[Change]]:
    """A linear motion with one joint moved into what another one leaves it."""
    joint = table.joint
    curves = JointCurves(motion, others, robot, STRAIGHT_RATE)
    times = curves.common_times(table.joint, table.of, bends=bends(curves[table.of], table))
    times = np.unique(times)
    given = curves.values(joint, times)
    wanted = np.clip(given, *table.range(curves.values(table.of, times)))
    moved = np.abs(wanted - given) > LIMIT_TOLERANCE
    if not moved.any():
        return motion, []
    # Beside what is moved, the keys that were there keep the rest as it was.
    column = motion.joint_names.index(joint)
    near = moved.copy()
    near[1:] |= moved[:-1]
    near[:-1] |= moved[1:]
    kept = near | np.isin(times, motion.times[column])
    new_times, keys = list(motion.times), list(motion.keys)
    new_times[column], keys[column] = times[kept], np.where(moved, wanted, given)[kept]
    changes = changed_stretches("clamped", joint, times, wanted - given, robot.unit(joint))
    return Motion(new_times, motion.joint_names, keys), changes
