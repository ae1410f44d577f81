"""`legs`: both legs on the one motor that drives both hips, by the closed forms of `legs_equations`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, choice, common_batch, rigid_inverse
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.ik.geometry import (
    ClosedForm,
    Found,
    Limb,
    found_for,
    kept_limb,
    limb_types,
    missing_geometry,
    parts_of_result,
    torso_in_trunk,
)
from nao_kin.ik.leg import Leg, leg_limb, missed, nearest_feet, nearest_foot
from nao_kin.ik.legs_apart import BALANCED, LEFT_FIRST, RIGHT_FIRST
from nao_kin.ik.legs_equations import (
    BLAMED,
    LEFT,
    LEFT_FOOT,
    MORE,
    MOST_BRANCHES,
    MOVED,
    OF_ONE,
    PRIORITY,
    RIGHT,
    Legs,
    LegsRanges,
)
from nao_kin.ik.legs_torso import (
    FREE,
    HEIGHT,
    LEAN,
    LENGTH,
    LENGTH_IN_WORLD,
    NOTHING,
    SCRATCH,
    TORSO,
    YAW,
    solve_at_wish,
    solve_pair,
)
from nao_kin.ik.results import Codes, IKResult, Reason, angle_in_words, crossing_in_words, errors_in_words
from nao_kin.ik.targets import Limits, as_poses, as_reference, check_threads, is_enforced, refuse_not_rigid
from nao_kin.robot import RobotModel
from nao_kin.rotations import exp, log, nearest_rotation, quat_from_matrix, quat_to_xyzw, rot_y, rot_z

# --- What inverse kinematics of both legs answers beside an `IKResult`: each foot by itself, and the torso.

_SIDES = "left", "right"


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class LegsResult(IKResult):
    """Solutions for both feet: HipYawPitch and five joints of each leg.

    `residual` is the larger of those of both feet.

    Attributes:
        foot_residuals: errors of the left and the right foot at `best` in position and rotation angle,
            shape (..., 2, 2) [m, rad].
        yaw_errors: how far the left and the right foot are turned about the normals of their soles against their
            targets, positive to the left, shape (..., 2) [rad]; nan where ankles and normals are not met.
        leg: which leg does not reach its own target, 0 the left and 1 the right one; −1 where none is to blame, shape
            (...).
        torso: the pose of the torso in the world where the feet were given there, shape (..., 4, 4) [m]; else None.
        base_coordinates: of a robot with a floating base, its base there as the first seven entries of q; else None.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.legs(nao, *nao.fk(q, ["LLeg", "RLeg"]))
        >>> bool(result.success), result.foot_residuals.shape
        (True, (2, 2))
    """

    foot_residuals: Floats
    yaw_errors: Floats
    leg: Codes
    torso: Floats | None = None
    base_coordinates: Floats | None = None

    @property
    def q(self) -> Floats:
        """The best configuration, shape (..., nq): `best`, and the base if it moves, in the reference."""
        q = super().q
        if self.base_coordinates is not None:
            unknown = np.isnan(self.best).any(axis=-1, keepdims=True)
            q[..., :7] = np.where(unknown, np.nan, self.base_coordinates)
        return q

    @property
    def solutions(self) -> Floats:
        """All solutions as configurations, best first, shape (k, nq), of a batch (..., k, nq); nan from `count` on."""
        solutions = super().solutions
        if self.base_coordinates is not None:
            there = np.arange(solutions.shape[-2]) < self.count[..., None]
            solutions[..., :7] = np.where(there[..., None], self.base_coordinates[..., None, :], np.nan)
        return solutions

    def describe(self, index: tuple[int, ...] = (), *, degrees: bool = False) -> str:
        """The reason of one pair of feet in a sentence.

        Args:
            index: which pair of the batch; () where there is one.
            degrees: angles in degrees.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("StandInit")
            >>> result = nk.ik.legs(nao, *nao.fk(q, ["LLeg", "RLeg"]))
            >>> result.describe()
            'reached, 1 solution'
        """
        reason = Reason(int(self.reasons[index]))
        if reason is Reason.REACHED:
            return super().describe(index, degrees=degrees)
        turns = [float(error) for error in self.yaw_errors[index]]
        left, right = (angle_in_words(turn, degrees) for turn in turns)
        feet = f"; the feet are turned by {left} (left) and {right} (right)"
        if np.isnan(turns[0]):
            off = [errors_in_words(float(away), float(turn), degrees) for away, turn in self.foot_residuals[index]]
            feet = f"; the nearest feet are off by {off[0]} (left) and {off[1]} (right)"
        if reason is Reason.HIPS_DISAGREE:
            return f"the hips disagree by {angle_in_words(float(self.obstacles.needed[index]), degrees)}{feet}"
        why, *hint = super().describe(index, degrees=degrees).split("; ")
        unit = "".join(f"; {part}" for part in hint if not part.startswith("the nearest pose"))
        return f"{_SIDES[int(self.leg[index])]} leg: {why}{unit}{feet}"


# --- `legs`: both legs on the one motor that drives both hips, by the closed forms of `legs_equations`.

Priority = Literal["left", "right", "balanced"]
Base = Literal["fixed", "floating"]
Free = Literal["height", "lean", "yaw"]

_PRIORITIES = {"left": LEFT_FIRST, "right": RIGHT_FIRST, "balanced": BALANCED}
_BASES = ("fixed", "floating")
_FREE = {"height": HEIGHT, "lean": LEAN, "yaw": YAW}


def legs(
    robot: RobotModel,
    T_left: ArrayLike,
    T_right: ArrayLike,
    *,
    frames: Sequence[str] | None = None,
    reference: ArrayLike | None = None,
    limits: Limits = "enforce",
    priority: Priority = "balanced",
    base: Base = "fixed",
    torso: ArrayLike | None = None,
    free: Free = "height",
    threads: SupportsIndex | None = None,
) -> LegsResult:
    """All joint values of both legs with which both feet have given poses; both hips hang on one motor.

    Where one HipYawPitch meets both feet to 1e-10 m and rad, all such joint values are returned. That is what every
    solution is verified to; it is asked of the feet and not of the motor, whose value rounding leaves open beside a
    singularity, where it hardly moves the feet.

    Feet that are rounded, to float32 for instance, are not met to that: their hips disagree by some 1e-8 rad, and `q`
    is the nearest, as follows. With `base="fixed"` a foot may be out of reach of a straight leg by up to 1e-6 m, as in
    `leg`.

    Otherwise ankles and normals of both soles stay exact, and of all values of HipYawPitch inside the limits that one
    is taken which turns the feet least about the normals through their ankles: `q` is this best, `yaw_errors` are the
    turns, and the reason is that the hips disagree, or what is in the way of one leg alone. A frame that is not on the
    normal through the ankle, as the effectors are, is carried around it, as `foot_residuals` say.

    Where a leg is too short, or its limits leave no such value, `q` is the nearest pose inside the limits that a search
    finds: with the smallest Σ (distance² + (0.1 m · angle)²) over both feet, and with the torso where it stands.

    With `base="floating"` feet and torso are given in the world, and one number of the torso's pose gives way so that
    both feet are met: the least change that does. `q` has the base of a robot whose base floats, otherwise the joints
    only.

    Args:
        robot: a NAO of any version, or another robot with legs of its geometry on one motor.
        T_left: the pose of the left foot in the torso, or in the world, shape (..., 4, 4) [m].
        T_right: that of the right one; they broadcast with each other.
        frames: a frame on the left and one on the right foot; None for the end effectors "LLeg" and "RLeg".
        reference: configurations that broadcast with the targets, shape (..., nq): solutions are sorted by their
            distance to it over the eleven joints, and take from it the other joints. None for all joints at zero, or
            at the limit nearest to it.
        limits: "enforce" leaves out what has a joint outside its own or a coupled limit; "ignore" takes all, each joint
            with the whole turns that bring it within half a turn of the reference.
        priority: whose foot is turned less where both cannot be met: "left" or "right", the other only as little as
            that leaves; "balanced" for the least sum of squares.
        base: "fixed" where the feet are given in the torso, "floating" where in the world.
        torso: with a floating base the wished pose of the torso in the world, shape (..., 4, 4) [m]; None for where
            the reference has it relative to the middle of its own feet.
        free: what of it gives way: "height" along the world's z, as far as both legs reach; "lean" about the torso's
            y-axis through the middle of the hips, or "yaw" about the vertical through it, up to ±π/2.
        threads: how many threads may work on a batch; None for all cores where that is worthwhile.

    Raises:
        UnknownName: no such frame, policy, priority, base or free number.
        BadArgument: the robot has no such legs; the message says what is missing. Or the last row of a target is not
            0, 0, 0, 1, or a number is beyond ±1e150.
        NotARotation: a target has no rotation; names the argument, its index and its defect.
        WrongShape, NotFinite: arrays of other shapes, NaN or infinity.

    Source: the derivation is in docs/inverse_kinematics.md.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.legs(nao, *nao.fk(q, ["LLeg", "RLeg"]))
        >>> np.allclose(nao.fk(result.q, "RLeg"), nao.fk(q, "RLeg"))
        True
    """
    left, right = _as_frames(frames)
    limb = kept_limb(robot, _legs_of, left, right)
    for option, value, valid in (("priority", priority, _PRIORITIES), ("base", base, _BASES), ("free", free, _FREE)):
        choice(value, valid, option)
    if base == "fixed" and torso is not None:
        raise BadArgument('a pose of the torso goes with feet in the world: base="floating"')
    workers, enforce = check_threads(threads), is_enforced(limits)
    poses = as_poses(T_left, "T_left"), as_poses(T_right, "T_right")
    batch = _broadcast(poses[0].shape[:-2], poses[1].shape[:-2], "T_right")
    wished = None if torso is None else as_poses(torso, "torso")
    if wished is not None:
        _refuse((wished,), ("torso",))
        batch = _broadcast(batch, wished.shape[:-2], "torso")
    references = as_reference(robot, limb.rest, reference, batch, enforce)
    rows = np.empty((*batch, LENGTH_IN_WORLD if base == "floating" else LENGTH))
    for first, T in zip((LEFT, RIGHT), poses, strict=True):
        rows[..., first : first + 16] = T.reshape(*T.shape[:-2], 16)
    rows[..., PRIORITY] = _PRIORITIES[priority]
    rows[..., FREE] = _FREE[free] if base == "floating" else NOTHING
    if base == "floating":
        if wished is None:
            _refuse(poses)
            wished = _as_in_reference(robot, limb, (left, right), poses, references[0])
        rows[..., TORSO:] = wished.reshape(*wished.shape[:-2], 16)
    found = found_for(_LEGS, limb, rows, references[0], enforce, workers, lambda: _refuse(poses))
    result = _as_result(robot, limb, rows, base == "floating", found, references)
    away = missed(result)
    if away.any():
        T = np.stack([np.broadcast_to(pose, (*batch, 4, 4))[away] for pose in poses], axis=1)
        if result.torso is not None:
            T = rigid_inverse(result.torso[away])[:, None] @ T
        near = np.broadcast_to(references[0], (*batch, robot.nq))[away]
        result.best[away], errors = _nearest(robot, limb, (left, right), T, near, enforce, workers)
        result.foot_residuals[away], result.residual[away] = errors, errors.max(axis=1)
    return result


def _as_frames(frames: Sequence[str] | None) -> tuple[str, str]:
    if frames is None:
        return "LLeg", "RLeg"
    if isinstance(frames, str) or not isinstance(frames, Sequence) or len(frames) != 2:
        raise BadArgument(f"frames must be two names, of a frame on the left and one on the right foot, got {frames!r}")
    return frames[0], frames[1]


def _broadcast(one: tuple[int, ...], other: tuple[int, ...], what: str) -> tuple[int, ...]:
    try:
        return common_batch(what, one, other)
    except WrongShape:
        raise WrongShape(what, f"(4, 4) or {(*one, 4, 4)} as T_left", (*other, 4, 4)) from None


def _refuse(poses: tuple[Floats, ...], names: tuple[str, ...] = ("T_left", "T_right")) -> None:
    """Raise for the first pose that is no rigid transform, as `refuse_not_rigid` does."""
    for T, name in zip(poses, names, strict=True):
        refuse_not_rigid(T, name)


def _nearest(
    robot: RobotModel,
    limb: Limb,
    frames: tuple[str, str],
    T: Floats,
    reference: Floats,
    enforce: bool,
    threads: int | None,
) -> tuple[Floats, Floats]:
    """Coordinates nearest to n pairs of feet, as `nearest_feet`, searched for from what is nearest to each foot."""
    one, other = leg_limb(robot, "L", frames[0]), leg_limb(robot, "R", frames[1])
    left = nearest_foot(robot, one, T[:, 0], reference, enforce, threads)[0]
    right = nearest_foot(robot, other, T[:, 1], reference, enforce, threads)[0]
    hips = left[:, :1], right[:, :1], 0.5 * (left[:, :1] + right[:, :1])
    starts = [np.concatenate([hip, left[:, 1:], right[:, 1:]], axis=-1) for hip in hips]
    return nearest_feet(robot, frames, limb, T, reference, starts, enforce, threads)


# --- the torso in the world -------------------------------------------------------------------------------------------


def _as_in_reference(
    robot: RobotModel, limb: Limb, frames: tuple[str, str], poses: tuple[Floats, Floats], reference: Floats
) -> Floats:
    """The torso in the world as the reference has it relative to the middle of its own feet, shape (..., 4, 4)."""
    T_torso_feet = robot.fk(reference, list(frames), reference=limb.torso)
    T_torso_middle = _middle(T_torso_feet[..., 0, :, :], T_torso_feet[..., 1, :, :])
    return _middle(*poses) @ np.linalg.inv(T_torso_middle)


def _middle(one: Floats, other: Floats) -> Floats:
    """The pose half-way between two, shape (..., 4, 4)."""
    one, other = np.broadcast_arrays(one, other)
    R = nearest_rotation(one[..., :3, :3])
    middle = np.array(one)
    middle[..., :3, :3] = R @ exp(0.5 * log(R.swapaxes(-1, -2) @ nearest_rotation(other[..., :3, :3])))
    middle[..., :3, 3] = 0.5 * (one[..., :3, 3] + other[..., :3, 3])
    return middle


def _moved_torso(legs: Legs, rows: Floats, moved: Floats) -> Floats:
    """The torso in the world after what gave way, shape (..., 4, 4)."""
    wished = rows[..., TORSO:].reshape(*rows.shape[:-1], 4, 4)
    hips = 0.5 * np.add(legs.left.hip, legs.right.hip)
    torso, free = np.array(wished), rows[..., FREE].flat[0] if rows.size else HEIGHT
    if free == HEIGHT:
        torso[..., 2, 3] += moved
        return torso
    R = wished[..., :3, :3]
    pivot = R @ hips + wished[..., :3, 3]
    torso[..., :3, :3] = R @ rot_y(moved) if free == LEAN else rot_z(moved) @ R
    torso[..., :3, 3] = pivot - torso[..., :3, :3] @ hips
    return torso


def _base_coordinates(robot: RobotModel, limb: Limb, torso: Floats) -> Floats:
    """The first seven entries of q with the torso there: place and quaternion of the root, scalar last."""
    root = torso @ np.linalg.inv(torso_in_trunk(robot))
    quaternions = quat_to_xyzw(quat_from_matrix(nearest_rotation(root[..., :3, :3])))
    return np.concatenate([root[..., :3, 3], quaternions], axis=-1)


# --- what comes back --------------------------------------------------------------------------------------------------


def _as_result(
    robot: RobotModel,
    limb: Limb,
    rows: Floats,
    in_world: bool,
    found: Found,
    references: tuple[Floats, tuple[str, ...]],
) -> LegsResult:
    batch = rows.shape[:-1]
    report = found.report.reshape(*batch, found.report.shape[1])
    torso = base = None
    if in_world:
        torso = _moved_torso(limb.numbers, rows, report[..., MOVED])
        base = _base_coordinates(robot, limb, torso) if robot.base == "floating" else None
    parts = parts_of_result(limb, batch, found, references)
    parts["notes"] += _notes(limb.numbers, rows, torso)
    feet = report[..., LEFT_FOOT : LEFT_FOOT + 6].reshape(*batch, 2, 3)
    return LegsResult(
        **parts,
        foot_residuals=feet[..., :2],
        yaw_errors=feet[..., 2],
        leg=np.asarray(report[..., BLAMED], dtype=np.int8),
        torso=torso,
        base_coordinates=base,
    )


def _notes(legs: Legs, rows: Floats, torso: Floats | None) -> tuple[str, ...]:
    """Whether ankles are on swapped sides of the torso."""
    # Along the torso's y-axis; without a torso that is the y of the target.
    along = np.array([0.0, 1.0, 0.0]) if torso is None else torso[..., :3, 1]
    sides = []
    for leg, first in ((legs.left, LEFT), (legs.right, RIGHT)):
        T = rows[..., first : first + 16].reshape(*rows.shape[:-1], 4, 4)
        # The frame's origin seen from the ankle, in the axes of the frame.
        frame = leg.place @ np.reshape(leg.rotation, (3, 3))
        sides.append((along * (T[..., :3, 3] - T[..., :3, :3] @ frame)).sum(axis=-1))
    return crossing_in_words(np.asarray(sides[0] < sides[1]), "targets")


def _legs_of(robot: RobotModel, left: str, right: str) -> Limb:
    one, other = leg_limb(robot, "L", left), leg_limb(robot, "R", right)
    motor = [(limb.columns[0], limb.multiplier[0], limb.offset[0]) for limb in (one, other)]
    if motor[0] != motor[1]:
        why = f"{one.joints[0]} and {other.joints[0]} are not one motor that turns both alike; nk.ik.leg takes each"
        raise missing_geometry(robot, "pair of legs", why)
    return replace(
        one,
        joints=one.joints + other.joints[1:],
        columns=one.columns + other.columns[1:],
        index=np.concatenate([one.index, other.index[1:]]),
        multiplier=np.concatenate([one.multiplier, other.multiplier[1:]]),
        offset=np.concatenate([one.offset, other.offset[1:]]),
        ranges=LegsRanges(one.ranges, other.ranges),
        numbers=Legs(one.numbers, other.numbers),
        follows=one.follows or other.follows,
    )


# --- the kernels ------------------------------------------------------------------------------------------------------


def _types() -> tuple[Any, Any]:
    from numba import types

    leg, ranges = limb_types(Leg, OF_ONE)
    return types.NamedUniTuple(leg, 2, Legs), types.NamedUniTuple(ranges, 2, LegsRanges)


_LEGS = ClosedForm(
    "both legs",
    solve_pair,
    _types,
    MOST_BRANCHES,
    alone=solve_at_wish,
    usual=4,
    more=MORE,
    scratch=SCRATCH,
    seconds=60.0,
)
