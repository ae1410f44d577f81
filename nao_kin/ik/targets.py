"""Checks of arguments: poses, references and options."""

from __future__ import annotations

from typing import Literal, NamedTuple, SupportsIndex, TypeAlias

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
Shape: TypeAlias = tuple[int, ...]
Threads: TypeAlias = SupportsIndex | None
_LIMITS = ("enforce", "ignore")


def as_poses(T: ArrayLike, what: str) -> Floats:
    """Return finite poses of shape (..., 4, 4), within ±1e150; their solver checks whether they are rigid."""
    if isinstance(T, np.ndarray) and T.shape == (4, 4) and T.dtype == np.float64 and np.abs(T).max() <= LARGEST:
        return T
    with np.errstate(over="ignore"):
        poses = as_floats(T, (4, 4), what)
    return as_vectors(poses, what, 4, rows=True)


def rigid_poses(T: ArrayLike, what: str) -> Floats:
    """Return a copy of poses of shape (..., 4, 4) with the nearest rotations; raise for the first one not rigid."""
    poses = as_poses(T, what)
    off = refuse_not_rigid(poses, what).orthogonality > ROUNDING
    nearest: Floats = poses.copy()
    if np.any(off):
        nearest[off, :3, :3] = nearest_rotation(poses[off, :3, :3])
    nearest[..., 3, :] = 0.0, 0.0, 0.0, 1.0
    return nearest


def refuse_not_rigid(T: Floats, what: str) -> RotationDefects:
    """Return the defects of the poses' rotations; raise NotARotation or BadArgument for the first one not rigid."""
    defects = refuse_not_rotation(T[..., :3, :3], what)
    wrong = np.abs(T[..., 3, :] - np.array([0.0, 0.0, 0.0, 1.0])).sum(axis=-1) > RIGID
    if wrong.any():
        index = first_index(wrong)
        row = ", ".join(f"{value:.6g}" for value in T[index][3])
        raise BadArgument(f"{what}{at_index(index)} is not a rigid transform: its last row is {row}, not 0, 0, 0, 1")
    return defects


def refuse_not_rotation(R: Floats, what: str) -> RotationDefects:
    """Return the defects of matrices; raise NotARotation, with the argument's name, for the first non-rotation."""
    try:
        return check_rotation(R)
    except NotARotation as error:
        error.args = (f"{what}: {error}",)
        raise


def is_enforced(limits: object) -> bool:
    """Return whether limits are enforced."""
    return choice(limits, _LIMITS, "limits policy") == "enforce"


def broadcast(what: str, one: Shape, other: Shape, wanted: str, shape: Shape) -> Shape:
    """Return the common batch shape of two, or raise WrongShape for argument `what` with its `wanted` shape."""
    try:
        return common_batch(what, one, other)
    except WrongShape:
        raise WrongShape(what, wanted, shape) from None


class Options(NamedTuple):
    """Checked options of a closed form; `notes` has a note if the reference was projected into the limits."""

    reference: Floats
    notes: tuple[str, ...]
    enforce: bool
    threads: int | None


def as_options(
    robot: RobotModel, rest: Floats, reference: ArrayLike | None, batch: Shape, limits: object, threads: Threads
) -> Options:
    """Return the options of a call for targets of a batch shape; `rest` replaces a reference of None."""
    enforce, workers = is_enforced(limits), check_threads(threads)
    if reference is None:
        return Options(rest.copy(), (), enforce, workers)
    array = as_floats(reference, (robot.nq,), "reference")
    try:
        fits = common_batch("reference", array.shape[:-1], batch) == batch
    except WrongShape:
        fits = False
    if not fits:
        raise WrongShape("reference", f"({robot.nq},) or {(*batch, robot.nq)} as the targets", array.shape)
    found, notes = _projected(robot, array, "reference") if enforce else (with_unit_quaternion(robot, array), ())
    return Options(found, notes, enforce, workers)


def inside_limits(robot: RobotModel, reference: ArrayLike, what: str = "reference") -> tuple[Floats, tuple[str, ...]]:
    """Return the nearest configurations inside the limits, shape (..., nq), and a note if they differ.

    Two joints with a coupled limit move to the nearest point of their plane region.
    """
    return _projected(robot, _finite(robot, reference, what), what)


def _projected(robot: RobotModel, reference: Floats, what: str) -> tuple[Floats, tuple[str, ...]]:
    """Do as `inside_limits` for finite configurations."""
    try:
        return robot.check_limits(reference), ()
    except OutsideLimits as error:
        q, joints = with_unit_quaternion(robot, reference, what), len(robot.joint_names)
        values = q[..., -joints:]
        values[...] = LimitRegion(robot, np.arange(joints)).project(values.reshape(-1, joints)).reshape(values.shape)
        return q, (f"{what} projected into the limits: {error.violations[0].describe()}",)


def with_unit_quaternion(robot: RobotModel, reference: ArrayLike, what: str = "reference") -> Floats:
    """Return a copy of configurations, shape (..., nq), with unit quaternions of a floating base."""
    q: Floats = np.array(_finite(robot, reference, what))
    q[..., : robot.nq_base] = robot.clamp(q)[..., : robot.nq_base]
    return q


def _finite(robot: RobotModel, reference: ArrayLike, what: str) -> Floats:
    """Return configurations, shape (..., nq); an error names the argument and the joint."""
    try:
        return as_floats(reference, (robot.nq,), what)
    except NotFinite as error:
        joint = error.index[-1] - robot.nq_base
        name = robot.joint_names[joint] if joint >= 0 else "base"
        raise NotFinite(what, error.index, error.value, name) from None


def check_threads(threads: Threads) -> int | None:
    """Return a number of threads from 1 to 10 000, or None."""
    return None if threads is None else whole_number(threads, "threads", 1, MAX_THREADS)
