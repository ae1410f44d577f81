"""Checks of arguments: poses, preferred configurations and options."""

from __future__ import annotations

import math
from typing import NamedTuple, SupportsIndex, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import (
    Floats,
    SolverLimits,
    as_floats,
    as_numbers,
    common_batch,
    limit_policy,
    whole_number,
)
from nao_kin.errors import NotFinite, OutsideLimits, UnknownName, WrongShape
from nao_kin.ik.branches import rigid_rotation
from nao_kin.ik.limit_regions import LimitRegion
from nao_kin.robot import RobotModel
from nao_kin.screws import refuse_not_rigid as refuse_not_rigid, rigid_poses as nearest_rigid_poses

Shape: TypeAlias = tuple[int, ...]
Threads: TypeAlias = SupportsIndex | None
_ENFORCE: SolverLimits = "enforce"
_POLICIES: tuple[SolverLimits, ...] = ("enforce", "ignore")


def as_poses(T: ArrayLike, what: str) -> Floats:
    """Return finite poses of shape (..., 4, 4); their solver checks whether they are rigid."""
    if type(T) is np.ndarray and T.shape == (4, 4) and T.dtype == np.float64:
        one: Floats = T
        if sum(map(abs, one.ravel().tolist())) < math.inf:  # for sixteen numbers quicker than a reduction of NumPy
            return one
    return as_floats(T, (4, 4), what)


def is_pose(value: ArrayLike, what: str) -> bool:
    """Return whether targets are poses, shape (..., 4, 4), or positions, shape (..., 3); refuse other shapes."""
    shape: Shape = value.shape if type(value) is np.ndarray else as_numbers(value, what).shape
    # Three points in the rows of a rotation are a slip, unless they lie on the axes.
    turned = shape == (3, 3) and np.any(np.mod(value, 1)) and np.allclose(np.dot(value, np.transpose(value)), np.eye(3))
    if turned or (shape[-2:] != (4, 4) and shape[-1:] != (3,)):
        raise WrongShape(what, "(..., 4, 4) for poses or (..., 3) for positions", shape)
    return shape[-2:] == (4, 4)


def rigid_poses(T: ArrayLike, what: str) -> Floats:
    """Return a copy of poses of shape (..., 4, 4) with the nearest rotations; raise for the first one not rigid."""
    poses = as_poses(T, what)
    if poses.shape == (4, 4):
        is_rigid, R = rigid_rotation(poses.ravel().tolist())
        if is_rigid and tuple(poses[:3, :3].ravel().tolist()) == R:  # there is nothing to correct in the rotation
            exact: Floats = poses.copy()
            exact[3] = 0.0, 0.0, 0.0, 1.0
            return exact
    return nearest_rigid_poses(poses, what)


def rows_of(array: Floats, batch: Shape, tail: int) -> Floats:
    """Return an array, whose last `tail` axes belong to one target, as rows of the batch."""
    own = array.shape[array.ndim - tail :]
    if array.shape[: array.ndim - tail] != batch:
        array = np.broadcast_to(array, (*batch, *own))
    return array.reshape(-1, *own)


def is_enforced(limits: object) -> bool:
    """Return whether limits are enforced."""
    if limits is _ENFORCE:
        return True
    if isinstance(limits, str) and limits == "clamp":
        hint = 'with "enforce", the result\'s `best` has the nearest values inside the limits'
        raise UnknownName("limits policy", limits, _POLICIES, hint)
    return limit_policy(limits, _POLICIES) == "enforce"


def broadcast(what: str, one: Shape, other: Shape, wanted: str, shape: Shape) -> Shape:
    """Return the common batch shape of two, or raise WrongShape for argument `what` with its `wanted` shape."""
    try:
        return common_batch(what, one, other)
    except WrongShape:
        raise WrongShape(what, wanted, shape) from None


class Options(NamedTuple):
    """Checked options of a closed form; `notes` has a note if `near` was projected into the limits.

    Do not write to `near`, which may belong to a limb.
    """

    near: Floats
    notes: tuple[str, ...]
    enforce: bool
    threads: int | None


def as_options(
    robot: RobotModel, rest: Floats, near: ArrayLike | None, batch: Shape, limits: object, threads: Threads
) -> Options:
    """Return the options of a call for targets of a batch shape; `rest` replaces None for `near`."""
    enforce, workers = is_enforced(limits), None if threads is None else check_threads(threads)
    if near is None:
        return Options(rest, (), enforce, workers)
    array = as_floats(named_posture(robot, near), (robot.nq,), "near")
    try:
        fits = common_batch("near", array.shape[:-1], batch) == batch
    except WrongShape:
        fits = False
    if not fits:
        raise WrongShape("near", f"({robot.nq},) or {(*batch, robot.nq)} as the targets", array.shape)
    inside, notes = _projected(robot, array, "near") if enforce else (with_unit_quaternion(robot, array), ())
    return Options(inside, notes, enforce, workers)


def named_posture(robot: RobotModel, near: ArrayLike) -> ArrayLike:
    """Return the posture of this name, or configurations unchanged."""
    return robot.posture(near) if isinstance(near, str) else near


def checked_reference(
    robot: RobotModel, q: ArrayLike, enforce: bool, what: str = "near"
) -> tuple[Floats, tuple[str, ...]]:
    """Return configurations with unit quaternions, shape (..., nq), and a note if enforced limits have moved them."""
    if not enforce:
        return with_unit_quaternion(robot, q, what), ()
    return _projected(robot, _finite(robot, q, what), what)


def _projected(robot: RobotModel, reference: Floats, what: str) -> tuple[Floats, tuple[str, ...]]:
    """Return finite configurations inside all limits, the nearest ones, and a note if they differ."""
    try:
        return robot.check_limits(reference), ()
    except OutsideLimits as error:
        q, joints = with_unit_quaternion(robot, reference, what), len(robot.joint_names)
        values = q[..., -joints:]
        values[...] = LimitRegion(robot, np.arange(joints)).project(values.reshape(-1, joints)).reshape(values.shape)
        return q, (f"{what} projected into the limits: {error.violations[0].describe()}",)


def with_unit_quaternion(robot: RobotModel, q: ArrayLike, what: str = "near") -> Floats:
    """Return a copy of configurations, shape (..., nq), with unit quaternions of a floating base."""
    unit: Floats = np.array(_finite(robot, q, what))
    unit[..., : robot.nq_base] = robot.clamp(unit)[..., : robot.nq_base]
    return unit


def _finite(robot: RobotModel, reference: ArrayLike, what: str) -> Floats:
    """Return configurations, shape (..., nq); an error names the argument and the joint."""
    try:
        return as_floats(named_posture(robot, reference), (robot.nq,), what)
    except NotFinite as error:
        joint = error.index[-1] - robot.nq_base
        name = robot.joint_names[joint] if joint >= 0 else "base"
        raise NotFinite(what, error.index, error.value, name) from None


def check_threads(threads: Threads) -> int | None:
    """Return a number of threads, at least 1, or None."""
    return None if threads is None else whole_number(threads, "threads", 1)
