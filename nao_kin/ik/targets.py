"""What callers give: poses, references and options, looked at once at the door."""

from __future__ import annotations

from typing import Literal, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import (
    LARGEST,
    MAX_THREADS,
    Floats,
    as_floats,
    as_vectors,
    choice,
    common_batch,
    first_index,
    whole_number,
)
from nao_kin.errors import BadArgument, NotARotation, NotFinite, OutsideLimits, WrongShape, at_index
from nao_kin.ik.limit_regions import LimitRegion
from nao_kin.ik.ranges import RIGID, ROUNDING
from nao_kin.robot import RobotModel
from nao_kin.rotations import RotationDefects, check_rotation, nearest_rotation

Limits = Literal["enforce", "ignore"]
_LIMITS = ("enforce", "ignore")


def as_poses(T: ArrayLike, what: str) -> Floats:
    """Poses of shape (..., 4, 4), finite; whether they are rigid is found out where they are solved.

    Raises:
        BadArgument: no numbers, or one beyond ±1e150, whose square would overflow.
        WrongShape, NotFinite: not of this shape, NaN or infinity.
    """
    if isinstance(T, np.ndarray) and T.shape == (4, 4) and T.dtype == np.float64 and np.abs(T).max() <= LARGEST:
        return T
    with np.errstate(over="ignore"):
        poses = as_floats(T, (4, 4), what)
    return as_vectors(poses, what, 4, rows=True)


def rigid_poses(T: ArrayLike, what: str) -> Floats:
    """Poses of shape (..., 4, 4), what is left of rounding taken out of their rotations; a copy.

    Raises:
        NotARotation, BadArgument: one is not rigid; with its index and its defect.
        WrongShape, NotFinite: not of shape (..., 4, 4), NaN or infinity.
    """
    poses = as_poses(T, what)
    off = refuse_not_rigid(poses, what).orthogonality > ROUNDING
    nearest: Floats = poses.copy()
    if np.any(off):
        nearest[off, :3, :3] = nearest_rotation(poses[off, :3, :3])
    nearest[..., 3, :] = 0.0, 0.0, 0.0, 1.0
    return nearest


def refuse_not_rigid(T: Floats, what: str) -> RotationDefects:
    """Raise for the first of these poses that is no rigid transform; the defects of their rotations.

    Raises:
        NotARotation: its rotation is none; names the argument, the index and the defect.
        BadArgument: its last row is not 0, 0, 0, 1; names the argument and the index.
    """
    defects = refuse_not_rotation(T[..., :3, :3], what)
    wrong = np.abs(T[..., 3, :] - np.array([0.0, 0.0, 0.0, 1.0])).sum(axis=-1) > RIGID
    if wrong.any():
        index = first_index(wrong)
        row = ", ".join(f"{value:.6g}" for value in T[index][3])
        raise BadArgument(f"{what}{at_index(index)} is no rigid transform: its last row is {row}, not 0, 0, 0, 1")
    return defects


def refuse_not_rotation(R: Floats, what: str) -> RotationDefects:
    """Raise for the first of these matrices that is no rotation; the defects of all.

    Raises:
        NotARotation: names the argument, the index and the defect.
    """
    try:
        return check_rotation(R)
    except NotARotation as error:
        error.args = (f"{what}: {error}",)
        raise


def is_enforced(limits: object) -> bool:
    """Whether limits are enforced.

    Raises:
        UnknownName: neither "enforce" nor "ignore".
    """
    return choice(limits, _LIMITS, "limits policy") == "enforce"


def as_reference(
    robot: RobotModel, rest: Floats, reference: ArrayLike | None, batch: tuple[int, ...], enforce: bool
) -> tuple[Floats, tuple[str, ...]]:
    """Reference configurations that broadcast with the targets, inside the limits if these are enforced, and notes.

    None stands for `rest`, all joints at zero or at the limit nearest to it.

    Raises:
        WrongShape, NotFinite, BadArgument: no configurations, or more of them than targets.
    """
    if reference is None:
        return rest.copy(), ()
    array = as_floats(reference, (robot.nq,), "reference")
    try:
        fits = common_batch("reference", array.shape[:-1], batch) == batch
    except WrongShape:
        fits = False
    if not fits:
        raise WrongShape("reference", f"({robot.nq},) or {(*batch, robot.nq)} as the targets", array.shape)
    return _projected(robot, array, "reference") if enforce else (with_unit_quaternion(robot, array), ())


def inside_limits(robot: RobotModel, reference: ArrayLike, what: str = "reference") -> tuple[Floats, tuple[str, ...]]:
    """The nearest configurations inside the limits, shape (..., nq), and a note where they are others.

    Two joints with a coupled limit go to the nearest point of their plane region.

    Args:
        robot: whose limits.
        reference: configurations.
        what: their name in messages.

    Raises:
        WrongShape, NotFinite, BadArgument: no configurations.
    """
    return _projected(robot, _finite(robot, reference, what), what)


def _projected(robot: RobotModel, reference: Floats, what: str) -> tuple[Floats, tuple[str, ...]]:
    """What `inside_limits` returns, for finite configurations."""
    try:
        return robot.check_limits(reference), ()
    except OutsideLimits as error:
        q, joints = with_unit_quaternion(robot, reference, what), len(robot.joint_names)
        values = q[..., -joints:]
        values[...] = LimitRegion(robot, np.arange(joints)).project(values.reshape(-1, joints)).reshape(values.shape)
        return q, (f"{what} projected into the limits: {error.violations[0].describe()}",)


def with_unit_quaternion(robot: RobotModel, reference: ArrayLike, what: str = "reference") -> Floats:
    """Configurations wherever their joints are, shape (..., nq), a copy; a floating base with quaternions of norm 1.

    Args:
        robot: whose.
        reference: configurations.
        what: their name in messages.

    Raises:
        WrongShape, NotFinite, BadArgument: no configurations.
    """
    q: Floats = np.array(_finite(robot, reference, what))
    base = robot.nq - len(robot.joint_names)
    q[..., :base] = robot.clamp(q)[..., :base]
    return q


def _finite(robot: RobotModel, reference: ArrayLike, what: str) -> Floats:
    """Configurations, shape (..., nq), refused by the name of their argument and of the joint."""
    try:
        return as_floats(reference, (robot.nq,), what)
    except NotFinite as error:
        joint = error.index[-1] - (robot.nq - len(robot.joint_names))
        name = robot.joint_names[joint] if joint >= 0 else "base"
        raise NotFinite(what, error.index, error.value, name) from None


def check_threads(threads: SupportsIndex | None) -> int | None:
    """A number of threads, or None.

    Raises:
        BadArgument: no whole number from 1 to 10 000.
    """
    return None if threads is None else whole_number(threads, "threads", 1, MAX_THREADS)
