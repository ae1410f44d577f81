"""`legs`: both legs, whose hips share one motor: the call, the result, and the displacement of the torso."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, SolverLimits, batch_index, choice, rigid_inverse
from nao_kin._kernels.cache import Row, both_ways
from nao_kin.errors import BadArgument
from nao_kin.ik.branches import (
    NOT_RIGID,
    POSITION_ERROR,
    REASON,
    Selection,
    Vector,
    Workspace,
    add_shortfall,
    least,
    local_minima,
)
from nao_kin.ik.closed_form import (
    ClosedForm,
    KernelOutput,
    Limb,
    base_coordinates,
    cached_limb,
    geometry_error,
    limb_types,
    missed_targets,
    result_fields,
    shifted,
    solve_targets,
)
from nao_kin.ik.least_squares import nearest_values
from nao_kin.ik.leg import Leg, foot_of, leg_limb, nearest_foot, within_reach
from nao_kin.ik.legs_equations import (
    BALANCED,
    FAILED_LEG,
    JOINTS,
    LEFT,
    LEFT_FIRST,
    LEFT_FOOT,
    MAX_BRANCHES,
    MORE,
    MOVED,
    NEITHER,
    OF_ONE,
    PRIORITY,
    RIGHT,
    RIGHT_FIRST,
    RIGHT_FOOT,
    Legs,
    LegsRanges,
    foot_yaw,
    solve_disagreeing,
    solve_legs,
    solve_separately,
)
from nao_kin.ik.results import (
    Codes,
    IKResult,
    Reason,
    angle_in_words,
    crossing_in_words,
    errors_in_words,
    without_collisions,
)
from nao_kin.ik.targets import Options, as_options, as_poses, broadcast, refuse_not_rigid
from nao_kin.robot import CollisionRule, RobotModel
from nao_kin.rotations import exp, log, nearest_rotation, rot_y, rot_z

# Codes, in a target, for the number of the torso's pose that is free; `NOTHING` for feet given in the torso.
NOTHING, HEIGHT, LEAN, YAW = -1.0, 0.0, 1.0, 2.0
# Indices in a target of the free number and of the desired pose of the torso; lengths of a target in the torso and in
# the world.
FREE, TORSO = PRIORITY + 1, PRIORITY + 2
LENGTH, LENGTH_IN_WORLD = TORSO, TORSO + 16
# Numbers in q after the joints: the joints of each leg alone, and a target in the torso.
IN_TORSO = 2 * OF_ONE
SCRATCH = IN_TORSO + PRIORITY + 1

# Steps between the bounds.
_STEPS = 96
_MAX_LEAN = 0.5 * math.pi
# Hips that disagree by less than this [rad] for every s agree everywhere.
_AGREEMENT = 1e-10

_SIDES = "left", "right"


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class LegsResult(IKResult):
    """Solutions for both feet: HipYawPitch and five joints of each leg; `residual` is the larger one of both feet.

    Attributes:
        foot_residuals: errors of the left and the right foot at `best` in position and rotation angle,
            shape (..., 2, 2) [m, rad].
        yaw_errors: turns of the left and the right foot about the normals of their soles, relative to their targets,
            positive to the left, shape (..., 2) [rad]; nan if ankles and normals are not met.
        leg: the leg that does not reach its own target, 0 the left and 1 the right one; −1 for neither, shape (...).
        torso: for feet given in the world, the pose of the torso there, shape (..., 4, 4) [m]; else None.
        base_coordinates: the first seven entries of q for this torso, if the robot has a floating base; else None.
    """

    foot_residuals: Floats
    yaw_errors: Floats
    leg: Codes
    torso: Floats | None = None
    base_coordinates: Floats | None = None

    @property
    def q(self) -> Floats:
        """The best configuration, shape (..., nq): `near` with `best` and, if the base floats, its new pose."""
        q = super().q
        if self.base_coordinates is not None:
            unknown = np.isnan(self.best).any(axis=-1, keepdims=True)
            q[..., :7] = np.where(unknown, np.nan, self.base_coordinates)
        return q

    @property
    def solutions(self) -> Floats:
        """All solutions as configurations, best first, shape (k, nq), for a batch (..., k, nq); nan from `count` on."""
        solutions = super().solutions
        if self.base_coordinates is not None:
            exists = np.arange(solutions.shape[-2]) < self.count[..., None]
            solutions[..., :7] = np.where(exists[..., None], self.base_coordinates[..., None, :], np.nan)
        return solutions

    def describe(self, index: tuple[int, ...] = (), *, degrees: bool = False) -> str:
        """Return the reason of one pair of feet as a sentence.

        Args:
            index: index of the pair in the batch; () for a single one.
            degrees: whether angles are in degrees.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("StandInit")
            >>> nk.ik.legs(nao, *nao.fk(q, ["LLeg", "RLeg"])).describe()
            'reached, 1 solution'
        """
        index = batch_index(index, self.reasons.shape)
        reason = Reason(int(self.reasons[index]))
        if reason in (Reason.REACHED, Reason.COLLISION):
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
    near: ArrayLike | None = None,
    limits: SolverLimits = "enforce",
    priority: Priority = "balanced",
    base: Base = "fixed",
    torso: ArrayLike | None = None,
    free: Free = "height",
    threads: SupportsIndex | None = None,
    collisions: bool | CollisionRule = False,
) -> LegsResult:
    """Compute all joint values of both legs that give both feet their poses; one motor drives both hips.

    - If some HipYawPitch meets both feet to 1e-10 m and rad, the result has all such joint values. With `base="fixed"`
      a foot may be out of reach of a straight leg by up to 1e-6 m, as in `leg`.
    - Otherwise (also for poses rounded to float32) the ankles and the normals of both soles stay exact, and
      HipYawPitch is the value inside the limits that turns the feet least about these normals. `q` is this
      configuration, `yaw_errors` are the rotations, and the reason is `HIPS_DISAGREE`, or the obstacle to one leg
      alone. A frame that is not on the normal through the ankle also moves: see `foot_residuals`.
    - If a leg is too short, or its limits exclude all such values, `q` is the configuration inside the limits with the
      smallest Σ (distance² + (0.1 m · angle)²) over both feet that a search finds, of equal ones the nearest to
      `near`; the torso is unchanged.

    With `base="floating"` feet and torso are given in the world, and one number of the torso's pose is changed as
    little as possible so that both feet are met. If the robot has a floating base, `q` has the changed base.

    Args:
        robot: a NAO of any version, or another robot with legs of its geometry on one motor.
        T_left: the pose of the left foot in the torso, or in the world, shape (..., 4, 4) [m].
        T_right: the pose of the right foot; they broadcast with each other.
        frames: a frame on the left and one on the right foot; None for the end effectors "LLeg" and "RLeg".
        near: as in all solvers, see `nao_kin.ik`; distances are over the eleven joints.
        priority: which foot turns least if both cannot be met: "left" or "right", with the other as little as possible;
            "balanced" for the least sum of squares.
        base: "fixed" for feet in the torso, "floating" for feet in the world.
        torso: with a floating base the desired pose of the torso in the world, shape (..., 4, 4) [m]; None for its pose
            relative to the middle of the feet in `near`.
        free: the number of the torso's pose to change: "height" along the world's z, as far as both legs reach; "lean"
            about the torso's y-axis through the middle of the hips, or "yaw" about the vertical through it, up to ±π/2.
        limits: as in all solvers.
        threads: as in all solvers.
        collisions: as in all solvers.

    Raises:
        BadArgument: the robot has no such legs; the message says what is missing. Or the last row of a target is not
            0, 0, 0, 1.
        NotARotation: the 3×3 part of a target is not a rotation; the error has the argument, its index and its defect.

    Source: the derivation is in docs/inverse_kinematics.md.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.legs(nao, *nao.fk(q, ["LLeg", "RLeg"]))
        >>> np.allclose(nao.fk(result.q, "RLeg"), nao.fk(q, "RLeg"))
        True
    """
    left, right = _as_frames(frames)
    limb = cached_limb(robot, _legs_of, left, right)
    for option, value, valid in (("priority", priority, _PRIORITIES), ("base", base, _BASES), ("free", free, _FREE)):
        choice(value, valid, option)
    if base == "fixed" and torso is not None:
        raise BadArgument('a pose of the torso requires feet in the world: base="floating"')
    poses = as_poses(T_left, "T_left"), as_poses(T_right, "T_right")
    batch = _broadcast(poses[0].shape[:-2], poses[1].shape[:-2], "T_right")
    desired = None if torso is None else as_poses(torso, "torso")
    if desired is not None:
        refuse_not_rigid(desired, "torso")
        batch = _broadcast(batch, desired.shape[:-2], "torso")
    options = as_options(robot, limb.rest, near, batch, limits, threads)
    rows = np.empty((*batch, LENGTH_IN_WORLD if base == "floating" else LENGTH))
    for first, T in zip((LEFT, RIGHT), poses, strict=True):
        rows[..., first : first + 16] = T.reshape(*T.shape[:-2], 16)
    rows[..., PRIORITY] = _PRIORITIES[priority]
    rows[..., FREE] = _FREE[free] if base == "floating" else NOTHING
    if base == "floating":
        if desired is None:
            _refuse(poses)
            desired = _kept_torso(robot, limb, (left, right), poses, options.near)
        rows[..., TORSO:] = desired.reshape(*desired.shape[:-2], 16)
    output = solve_targets(_LEGS, limb, rows, options, lambda: _refuse(poses))
    result = _as_result(robot, limb, rows, base == "floating", output, options)
    if output.is_complete:
        return without_collisions(robot, result, collisions)
    missed, options = missed_targets(result, options)
    if missed.any():
        T = np.stack([np.broadcast_to(pose, (*batch, 4, 4))[missed] for pose in poses], axis=1)
        if result.torso is not None:
            T = rigid_inverse(result.torso[missed])[:, None] @ T
        result.best[missed], errors = _nearest(robot, limb, (left, right), T, options)
        result.foot_residuals[missed], result.residual[missed] = errors, errors.max(axis=1)
    return without_collisions(robot, result, collisions)


def _as_frames(frames: Sequence[str] | None) -> tuple[str, str]:
    if frames is None:
        return "LLeg", "RLeg"
    if isinstance(frames, str) or len(frames) != 2:
        raise BadArgument(f"frames must be two names, of a frame on the left and one on the right foot, got {frames!r}")
    return frames[0], frames[1]


def _broadcast(one: tuple[int, ...], other: tuple[int, ...], what: str) -> tuple[int, ...]:
    return broadcast(what, one, other, f"(4, 4) or {(*one, 4, 4)} as T_left", (*other, 4, 4))


def _refuse(poses: tuple[Floats, Floats]) -> None:
    """Raise for the first pose that is not a rigid transform, as `refuse_not_rigid` does."""
    for T, name in zip(poses, ("T_left", "T_right"), strict=True):
        refuse_not_rigid(T, name)


def _nearest(
    robot: RobotModel, limb: Limb, frames: tuple[str, str], T: Floats, options: Options
) -> tuple[Floats, Floats]:
    """Return the coordinates nearest to n pairs of feet, by a search from those for each foot, and errors (n, 2, 2)."""
    left = nearest_foot(robot, leg_limb(robot, "L", frames[0]), T[:, 0], options)[0]
    right = nearest_foot(robot, leg_limb(robot, "R", frames[1]), T[:, 1], options)[0]
    hips = left[:, :1], right[:, :1], 0.5 * (left[:, :1] + right[:, :1])
    starts = [np.concatenate([hip, left[:, 1:], right[:, 1:]], axis=-1) for hip in hips]
    best = nearest_values(robot, frames, limb, T, starts, options)[0]
    q = robot.neutral()[None].repeat(len(T), axis=0)
    turn = 2.0 * math.pi / limb.multiplier
    q[:, limb.index] = best - turn * np.round(best / turn)  # whole turns do not move the feet, and `fk` warns of them
    made = np.array(robot.fk(q, list(frames), reference=limb.torso))
    turns = log(made[..., :3, :3].swapaxes(-1, -2) @ nearest_rotation(T[..., :3, :3]))
    return best, np.linalg.norm([made[..., :3, 3] - T[..., :3, 3], turns], axis=-1).transpose(1, 2, 0)


def _kept_torso(
    robot: RobotModel, limb: Limb, frames: tuple[str, str], poses: tuple[Floats, Floats], near: Floats
) -> Floats:
    """Return the torso in the world, relative to the middle of the feet as in `near`, shape (..., 4, 4)."""
    T_torso_feet = robot.fk(near, list(frames), reference=limb.torso)
    T_torso_middle = _middle(T_torso_feet[..., 0, :, :], T_torso_feet[..., 1, :, :])
    return _middle(*poses) @ np.linalg.inv(T_torso_middle)


def _middle(one: Floats, other: Floats) -> Floats:
    """Return the pose half-way between two, shape (..., 4, 4)."""
    one, other = np.broadcast_arrays(one, other)
    R = nearest_rotation(one[..., :3, :3])
    middle = np.array(one)
    middle[..., :3, :3] = R @ exp(0.5 * log(R.swapaxes(-1, -2) @ nearest_rotation(other[..., :3, :3])))
    middle[..., :3, 3] = 0.5 * (one[..., :3, 3] + other[..., :3, 3])
    return middle


def _moved_torso(legs: Legs, rows: Floats, moved: Floats) -> Floats:
    """Return the moved torso in the world, shape (..., 4, 4)."""
    desired = rows[..., TORSO:].reshape(*rows.shape[:-1], 4, 4)
    hips = 0.5 * np.add(legs.left.hip, legs.right.hip)
    torso, free = np.array(desired), rows[..., FREE].flat[0] if rows.size else HEIGHT
    if free == HEIGHT:
        torso[..., 2, 3] += moved
        return torso
    R = desired[..., :3, :3]
    pivot = R @ hips + desired[..., :3, 3]
    torso[..., :3, :3] = R @ rot_y(moved) if free == LEAN else rot_z(moved) @ R
    torso[..., :3, 3] = pivot - torso[..., :3, :3] @ hips
    return torso


def _as_result(
    robot: RobotModel, limb: Limb, rows: Floats, in_world: bool, output: KernelOutput, options: Options
) -> LegsResult:
    batch = rows.shape[:-1]
    report = output.report.reshape(*batch, output.length)
    torso = base = None
    if in_world:
        torso = _moved_torso(limb.numbers, rows, report[..., MOVED])
        base = base_coordinates(robot, torso) if robot.base == "floating" else None
    fields = result_fields(limb, batch, output, options)
    fields["notes"] += _notes(limb.numbers, rows, torso)
    feet = report[..., LEFT_FOOT : LEFT_FOOT + 6].reshape(*batch, 2, 3)
    return LegsResult(
        **fields,
        foot_residuals=feet[..., :2],
        yaw_errors=feet[..., 2],
        leg=np.asarray(report[..., FAILED_LEG], dtype=np.int8),
        torso=torso,
        base_coordinates=base,
    )


def _notes(legs: Legs, rows: Floats, torso: Floats | None) -> tuple[str, ...]:
    """Return a note if the ankles are on swapped sides of the torso."""
    # Along the torso's y-axis, in the frame of the targets.
    along = np.array([0.0, 1.0, 0.0]) if torso is None else torso[..., :3, 1]
    sides = []
    for leg, first in ((legs.left, LEFT), (legs.right, RIGHT)):
        T = rows[..., first : first + 16].reshape(*rows.shape[:-1], 4, 4)
        # The frame's origin from the ankle, in the axes of the frame.
        frame = leg.place @ np.reshape(leg.rotation, (3, 3))
        sides.append((along * (T[..., :3, 3] - T[..., :3, :3] @ frame)).sum(axis=-1))
    return crossing_in_words(np.asarray(sides[0] < sides[1]), "targets")


def _legs_of(robot: RobotModel, left: str, right: str) -> Limb:
    one, other = leg_limb(robot, "L", left), leg_limb(robot, "R", right)
    motor = [(limb.columns[0], limb.multiplier[0]) for limb in (one, other)]
    if motor[0] != motor[1]:
        why = f"{one.joints[0]} and {other.joints[0]} are not one motor that turns both alike; nk.ik.leg takes each"
        raise geometry_error(robot, "pair of legs", why)
    # The value of the right hip is the left one's plus `turn`.
    turn = float(other.offset[0] - one.offset[0])
    ranges = LegsRanges(one.ranges, shifted(other.ranges, np.eye(OF_ONE)[0] * turn))
    return replace(
        one,
        joints=one.joints + other.joints[1:],
        columns=one.columns + other.columns[1:],
        index=np.concatenate([one.index, other.index[1:]]),
        zeros=np.concatenate([one.zeros, other.zeros[1:]]),
        multiplier=np.concatenate([one.multiplier, other.multiplier[1:]]),
        offset=np.concatenate([one.offset, other.offset[1:]]),
        ranges=ranges,
        numbers=Legs(one.numbers, other.numbers, turn),
    )


# --- Both feet in the world, with one number s of the torso's pose changed until the hips agree; or feet in the torso.
#
# The roots of ψ of both feet have the tangents −Y_cos / Y_sin. These are equal where
#
#     G(s) = Y_cos,L Y_sin,R − Y_sin,L Y_cos,R
#
# is zero: a polynomial of second degree in the height, and of fourth in cosine and sine of a lean or a yaw. So its few
# roots are found from even steps of s, as the local minima of the angle between the roots.


@both_ways
def solve_fixed(legs: Legs, target: Row, selection: Selection, work: Workspace) -> int:
    """Find all joint values that meet both feet with the torso as desired, as `branches` describes."""
    short = _write_desired_target(legs, target, work.q)
    count = solve_legs(legs, work.q[IN_TORSO:SCRATCH], selection, work)
    _add_shortfalls(short, count, work)
    return count


@both_ways
def solve_pair(legs: Legs, target: Row, selection: Selection, work: Workspace) -> int:
    """Find all joint values that meet both feet, or the best ones; move a torso in the world as little as possible."""
    short, moved = _write_desired_target(legs, target, work.q), 0.0
    in_torso = work.q[IN_TORSO:SCRATCH]
    count = solve_legs(legs, in_torso, selection, work)
    if count > 0 or work.report[REASON] == NOT_RIGID:
        _add_shortfalls(short, count, work)
        return count
    if target[FREE] != NOTHING:
        moved = _smallest_move(legs, target, selection, work)
        move_torso(legs, target, moved, work.q)
        count = solve_legs(legs, in_torso, selection, work)
    if count == 0:
        count = solve_disagreeing(legs, in_torso, selection, work)
    _add_shortfalls(short, count, work)
    work.report[MOVED] = moved
    return count


@both_ways
def _write_desired_target(legs: Legs, target: Row, q: Row) -> tuple[float, float]:
    """Write the target in the desired torso; move feet given in the torso as `within_reach`, and return how far."""
    move_torso(legs, target, 0.0, q)
    if target[FREE] != NOTHING:
        return 0.0, 0.0  # the torso is moved instead
    return _into_reach(legs.left, q, IN_TORSO + LEFT), _into_reach(legs.right, q, IN_TORSO + RIGHT)


@both_ways
def _into_reach(leg: Leg, q: Row, first: int) -> float:
    """Move the foot at index `first` of q as `within_reach` does; return how far."""
    foot = foot_of(leg, q[first : first + 16])[1]
    moved, short = within_reach(leg, foot)
    if short > 0.0:
        x, y, z = moved.x - foot.x, moved.y - foot.y, moved.z - foot.z
        q[first + 3] += x
        q[first + 7] += leg.cos_kappa * y - leg.sin_kappa * z
        q[first + 11] += leg.sin_kappa * y + leg.cos_kappa * z
    return short


@both_ways
def _add_shortfalls(short: tuple[float, float], count: int, work: Workspace) -> None:
    """Add the distances by which the feet were moved to the errors in position."""
    report = work.report
    if max(short[0], short[1]) > 0.0:
        add_shortfall(work.branches, JOINTS, count, max(short[0], short[1]))
        report[LEFT_FOOT] += short[0]
        report[RIGHT_FOOT] += short[1]
        report[POSITION_ERROR] = max(report[LEFT_FOOT], report[RIGHT_FOOT])


@both_ways
def _smallest_move(legs: Legs, target: Row, selection: Selection, work: Workspace) -> float:
    """Return the smallest |s| with which both feet are met; if none, the s with which the hips disagree least."""
    low, high = _bounds(legs, target)
    if not low < high:
        return 0.0
    given = legs, target, selection, work
    shifts, agreed = np.linspace(low, high, _STEPS + 1), np.empty(_STEPS + 1)
    largest = 0.0
    for k in range(_STEPS + 1):
        largest = max(largest, _disagreement(given, shifts[k]))
    if largest < _AGREEMENT:
        best = least(_shift, given, low, high, low, _STEPS)
        return best if _shift(given, best) < math.inf else 0.0
    count = local_minima(_disagreement, given, shifts, agreed)
    for k in np.argsort(np.abs(agreed[:count])):
        if _shift(given, agreed[k]) < math.inf:
            return float(agreed[k])
    best = least(_gap, given, low, high, low, _STEPS)
    return best if _gap(given, best) < math.inf else 0.0


@both_ways
def _shift(given: tuple[Legs, Row, Selection, Workspace], moved: float) -> float:
    """Return |s| if both feet are met with the torso moved by s, else infinity."""
    legs, target, selection, work = given
    move_torso(legs, target, moved, work.q)
    return abs(moved) if solve_legs(legs, work.q[IN_TORSO:SCRATCH], selection, work) > 0 else math.inf


@both_ways
def move_torso(legs: Legs, target: Row, moved: float, q: Row) -> None:
    """Write the target in the torso, with the torso moved by s, into q from `IN_TORSO` on.

    The right foot is turned back about its hip's axis by `legs.turn`, so that both hips have one value.
    """
    if target[FREE] == NOTHING:
        q[IN_TORSO:SCRATCH] = target[LEFT : PRIORITY + 1]
    else:
        _write_in_torso(legs, target, moved, q)
    if legs.turn == 0.0:
        return
    leg, s, c = legs.right, math.sin(legs.turn), math.cos(legs.turn)
    for column in range(4):
        at, part = IN_TORSO + RIGHT + column, 1.0 if column == 3 else 0.0
        x, y, z = part * leg.hip[0], part * leg.hip[1], part * leg.hip[2]
        turned = _turned_back((q[at] - x, q[at + 4] - y, q[at + 8] - z), (0.0, leg.cos_kappa, leg.sin_kappa), s, c)
        q[at], q[at + 4], q[at + 8] = turned[0] + x, turned[1] + y, turned[2] + z


@both_ways
def _turned_back(vector: Vector, axis: Vector, s: float, c: float) -> Vector:
    """Return a vector rotated about an axis by minus the angle with this sine and cosine: Rodrigues' formula."""
    (x, y, z), (ux, uy, uz) = vector, axis
    along = (1.0 - c) * (ux * x + uy * y + uz * z)
    return (
        c * x - s * (uy * z - uz * y) + along * ux,
        c * y - s * (uz * x - ux * z) + along * uy,
        c * z - s * (ux * y - uy * x) + along * uz,
    )


@both_ways
def _write_in_torso(legs: Legs, target: Row, moved: float, q: Row) -> None:
    """Write a target in the world as `move_torso` does."""
    mode = target[FREE]
    left, right = legs.left.hip, legs.right.hip
    cx, cy, cz = 0.5 * (left[0] + right[0]), 0.5 * (left[1] + right[1]), 0.5 * (left[2] + right[2])
    s, c = math.sin(moved), math.cos(moved)
    ox, oy, oz = target[TORSO + 3], target[TORSO + 7], target[TORSO + 11] + (moved if mode == HEIGHT else 0.0)
    # The torso's y-axis, or the vertical in the torso.
    ux, uy, uz = (0.0, 1.0, 0.0) if mode == LEAN else (target[TORSO + 8], target[TORSO + 9], target[TORSO + 10])
    for side in range(2):
        first = LEFT if side == 0 else RIGHT
        for column in range(4):
            # A column of the foot's pose in the world, the position from the torso's origin.
            part = 1.0 if column == 3 else 0.0
            vx, vy, vz = target[first + column], target[first + 4 + column], target[first + 8 + column]
            vx, vy, vz = vx - part * ox, vy - part * oy, vz - part * oz
            # In the axes of the desired torso.
            x = target[TORSO] * vx + target[TORSO + 4] * vy + target[TORSO + 8] * vz
            y = target[TORSO + 1] * vx + target[TORSO + 5] * vy + target[TORSO + 9] * vz
            z = target[TORSO + 2] * vx + target[TORSO + 6] * vy + target[TORSO + 10] * vz
            if mode != HEIGHT:
                # Rotated by −s about the axis u through the middle of the hips.
                x, y, z = _turned_back((x - part * cx, y - part * cy, z - part * cz), (ux, uy, uz), s, c)
                x, y, z = x + part * cx, y + part * cy, z + part * cz
            at = IN_TORSO + first + column
            q[at], q[at + 4], q[at + 8] = x, y, z
            q[at + 12] = target[first + 12 + column]
    q[IN_TORSO + PRIORITY] = target[PRIORITY]


@both_ways
def _bounds(legs: Legs, target: Row) -> tuple[float, float]:
    """Return the bounds of s: as far as both legs reach, or a quarter of a turn."""
    if target[FREE] != HEIGHT:
        return -_MAX_LEAN, _MAX_LEAN
    low, high = -math.inf, math.inf
    for side in range(2):
        leg, first = (legs.left, LEFT) if side == 0 else (legs.right, RIGHT)
        foot = foot_of(leg, target[first : first + 16])[1]
        # The ankle in the world, from the one in axes turned by κ with the hip in the world's origin.
        C, S, hip = leg.cos_kappa, leg.sin_kappa, leg.hip
        ax, ay, az = foot.x + hip[0], C * foot.y - S * foot.z + hip[1], S * foot.y + C * foot.z + hip[2]
        (x, y, z), t = hip, TORSO
        hx = target[t] * x + target[t + 1] * y + target[t + 2] * z + target[t + 3]
        hy = target[t + 4] * x + target[t + 5] * y + target[t + 6] * z + target[t + 7]
        hz = target[t + 8] * x + target[t + 9] * y + target[t + 10] * z + target[t + 11]
        aside = (ax - hx) * (ax - hx) + (ay - hy) * (ay - hy)
        longest = leg.thigh + leg.tibia
        span = math.sqrt(max(0.0, longest * longest - aside))
        low, high = max(low, az - hz - span), min(high, az - hz + span)
    return low, high


@both_ways
def _disagreement(given: tuple[Legs, Row, Selection, Workspace], moved: float) -> float:
    """Return the angle between the roots of both feet, up to half turns, with the torso moved by s."""
    legs, target, _, work = given
    move_torso(legs, target, moved, work.q)
    left = foot_yaw(foot_of(legs.left, work.q[IN_TORSO + LEFT : IN_TORSO + RIGHT])[1])
    right = foot_yaw(foot_of(legs.right, work.q[IN_TORSO + RIGHT : IN_TORSO + PRIORITY])[1])
    sine = left.y_cos * right.y_sin - left.y_sin * right.y_cos
    return math.atan2(abs(sine), abs(left.y_cos * right.y_cos + left.y_sin * right.y_sin))


@both_ways
def _gap(given: tuple[Legs, Row, Selection, Workspace], moved: float) -> float:
    """Return by how much the hips disagree with the torso moved by s; infinite if a leg does not reach its foot."""
    legs, target, selection, work = given
    move_torso(legs, target, moved, work.q)
    gap = solve_separately(legs, work.q[IN_TORSO:SCRATCH], selection, work)
    return gap if work.report[FAILED_LEG] == NEITHER else math.inf


def _types() -> tuple[Any, Any]:
    from numba import types

    leg, ranges = limb_types(Leg, OF_ONE)
    return types.NamedTuple((leg, leg, types.float64), Legs), types.NamedUniTuple(ranges, 2, LegsRanges)


_LEGS = ClosedForm(
    "both legs", solve_pair, _types, MAX_BRANCHES, alone=solve_fixed, usual=4, more=MORE, scratch=SCRATCH, seconds=20.0
)
