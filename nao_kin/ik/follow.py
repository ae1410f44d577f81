"""`follow`: from a path of targets to a joint trajectory, continuous if possible, within the speed limits."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, SupportsIndex, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, SolverLimits, between_samples, choice, positive
from nao_kin.errors import BadArgument
from nao_kin.ik.closed_form import base_coordinates
from nao_kin.ik.follow_branches import Choice, FollowedLimb, Jump, choose, jumps_of
from nao_kin.ik.follow_limbs import LimbPath, Path, checked_path, limb_paths
from nao_kin.ik.legs import Free, Priority, legs
from nao_kin.ik.results import Codes, Reason
from nao_kin.ik.targets import check_threads, checked_reference, is_enforced
from nao_kin.robot import CollisionRule, RobotModel
from nao_kin.rotations import quat_from_xyzw, quat_to_xyzw, quat_unwrap, slerp

# --- Times for which no joint exceeds its speed limit.


@dataclass(frozen=True)
class Stretch:
    """A segment that takes longer than requested.

    Attributes:
        index: the sample at its start.
        joint: the joint that needs the time.
        given: the requested time [s].
        needed: the time that it takes [s].
    """

    index: int
    joint: str
    given: float
    needed: float

    def describe(self) -> str:
        """Return the segment in a sentence.

        Examples:
            >>> Stretch(0, "LElbowYaw", given=0.1, needed=0.25).describe()
            'LElbowYaw needs 0.25 s instead of 0.1 s after sample 0'
        """
        return f"{self.joint} needs {self.needed:.3g} s instead of {self.given:.3g} s after sample {self.index}"


def scaled(
    robot: RobotModel, joints: Floats, times: Floats | None, speed: float
) -> tuple[Floats, Floats, tuple[Stretch, ...]]:
    """Return times of samples with segments dt = max(given, max_j |Δq_j| / (speed · v_j)), given = 0 if it is None.

    Also return the speeds of the joints in the segments as shares of their limits v_j, shape (n − 1, joints), and the
    segments that take longer than requested.
    """
    moved = np.abs(np.diff(joints, axis=0))
    least = moved / robot.velocity_limits
    needed = least.max(axis=1, initial=0.0) / speed
    given = np.zeros(len(moved)) if times is None else np.diff(times)
    # Differences of times are rounded: a segment that is too short by no more than rounding is not changed.
    short = needed > given * (1.0 + 1e-12) + (0.0 if times is None else 4.0 * np.spacing(np.abs(times).max()))
    taken = np.where(short, needed, given)
    if times is not None and not short.any():
        new_times = np.array(times)
    else:
        new_times = np.concatenate([[0.0], np.cumsum(taken)]) + (0.0 if times is None else times[0])
    shares = np.divide(least, taken[:, None], out=np.zeros_like(least), where=taken[:, None] > 0.0)
    stretched = tuple(
        Stretch(i, robot.joint_names[int(np.argmax(least[i]))], float(given[i]), float(needed[i]))
        for i in ([] if times is None else np.flatnonzero(short).tolist())
    )
    return new_times, shares, stretched


# --- The result: a joint trajectory along a path of targets.

_BASE = 7
# The number of jumps, or of stretched segments, that a message lists.
_LISTED = 3


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """A joint trajectory along a path of n samples.

    Attributes:
        joint_names: the joints in the order of q, after the seven numbers of a floating base.
        times: the times of the samples, shape (n,) [s]; all equal if nothing moves and no times were given.
        q: configurations, shape (n, nq). At a sample that is not reached, the limb is at the nearest pose, or its
            joints are nan if its solver does not find one.
        torso: the pose of the torso in the world, shape (n, 4, 4); None if targets are in the torso.
        limbs: the limbs, each with its `name` ("LLeg", "RLeg", "legs", "LArm", "RArm" or "Head"), the `columns` of q
            that it moves, the samples `reached`, their `reasons` and `residual`, as in `IKResult`, and `messages`,
            sample → reason in words, for the samples that are not reached.
        jumps: steps in which a limb cannot move continuously, in order, each with the `index` of its first sample, the
            `limb`, the `joint` that takes longest, its change `size` [rad] and the `cause`; `describe()` says it in
            words.
        stretched: segments that take longer than requested, in order, each with the `index` of its first sample, the
            `joint` that needs the time, and the times `given` and `needed` [s]; `describe()` says it in words.
        speed_shares: speed of each joint in each segment as a share of its limit, shape (n − 1, joints).
        motion: the sum over the path of the squared motion Σ (Δq_j / v_j)² of the limbs that follow it [s²].
        notes: notes on the call, one line each.
    """

    joint_names: tuple[str, ...]
    times: Floats
    q: Floats
    torso: Floats | None
    limbs: tuple[FollowedLimb, ...]
    jumps: tuple[Jump, ...]
    stretched: tuple[Stretch, ...]
    speed_shares: Floats
    motion: float
    notes: tuple[str, ...]

    @property
    def duration(self) -> float:
        """Time from the first sample to the last [s]."""
        return float(self.times[-1] - self.times[0])

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Samples whose targets are all reached, shape (n,)."""
        return np.asarray(np.logical_and.reduce([limb.reached for limb in self.limbs]))

    @property
    def reasons(self) -> Mapping[str, Codes]:
        """Limb → a `Reason` for each sample as a number, shape (n,)."""
        return MappingProxyType({limb.name: limb.reasons for limb in self.limbs})

    @property
    def success(self) -> bool:
        """Whether all targets are reached without a jump."""
        return bool(self.reached.all()) and not self.jumps

    @property
    def largest_speed_share(self) -> float:
        """The largest joint speed as a share of its limit; 0 if nothing moves."""
        return float(self.speed_shares.max(initial=0.0))

    @property
    def message(self) -> str:
        """The outcome in words."""
        n = len(self.times)
        reached = int(np.count_nonzero(self.reached))
        lines = [f"{reached} of {n} {'sample' if n == 1 else 'samples'} reached in {self.duration:.4g} s"]
        for limb in self.limbs:
            if limb.messages:
                first, text = next(iter(limb.messages.items()))
                count = len(limb.messages)
                more = f" and {count - 1} more" if count > 1 else ""
                lines.append(f"{limb.name} does not reach sample {first}{more}: {text}")
        for rows in (self.jumps, self.stretched):
            lines += [row.describe() for row in rows[:_LISTED]]
            if len(rows) > _LISTED:
                lines[-1] += f" and {len(rows) - _LISTED} more"
        return "; ".join([*lines, *self.notes])

    def sampled(self, rate: float = 30.0) -> Floats:
        """Return configurations at equal time steps, as for `Viewer.animate`, shape (m, nq).

        Joints and the position of the base are interpolated linearly, the orientation of the base by slerp, also across
        samples at which a limb has no values. The last step, to the last sample, may be shorter.

        Args:
            rate: configurations per second.

        Raises:
            BadArgument: a limb has no values at any sample.

        Examples:
            >>> nao = nk.load_nao()
            >>> path = np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 5)
            >>> result = nk.ik.follow(nao, {"LArm": path})
            >>> result.sampled(rate=100).shape[1]
            25
        """
        rate = float(positive(rate, "rate"))
        q = between_samples(self.q)
        if np.isnan(q).any():
            empty = next(limb.name for limb in self.limbs if np.isnan(q[0, list(limb.columns)]).any())
            raise BadArgument(f"{empty} has no values at any sample: {self.message}")
        if len(q) == 1:
            return q
        steps = max(0, int(np.ceil(self.duration * rate - 1e-9)))
        times = np.minimum(self.times[0] + np.arange(steps + 1) / rate, self.times[-1])
        after = np.clip(np.searchsorted(self.times, times, side="right"), 1, len(self.times) - 1)
        start, width = self.times[after - 1], self.times[after] - self.times[after - 1]
        share = np.divide(times - start, width, out=np.ones_like(times), where=width > 0.0)
        found = q[after - 1] + share[:, None] * (q[after] - q[after - 1])
        if q.shape[1] > len(self.joint_names):
            turn = slice(_BASE - 4, _BASE)
            first, second = quat_from_xyzw(q[after - 1, turn]), quat_from_xyzw(q[after, turn])
            found[:, turn] = quat_to_xyzw(slerp(first, second, share))
        return np.asarray(found)

    def __repr__(self) -> str:
        limbs = ", ".join(limb.name for limb in self.limbs)
        return f"<FollowedPath of {limbs}: {self.message}>"


# --- `follow`.


def follow(
    robot: RobotModel,
    path: Mapping[str, ArrayLike],
    *,
    times: ArrayLike | None = None,
    torso: ArrayLike | None = None,
    directions: Mapping[str, ArrayLike] | None = None,
    frames: Mapping[str, str] | None = None,
    near: ArrayLike | None = None,
    limits: SolverLimits = "enforce",
    speed: float = 1.0,
    priority: Priority = "balanced",
    free: Free | None = None,
    threads: SupportsIndex | None = None,
    collisions: bool | CollisionRule = False,
) -> FollowedPath:
    """Return a joint trajectory along a path of targets for any of feet, hands and head.

    For each limb (both legs are one), dynamic programming selects the branches with the least sum of the squared motion
    Σ (Δq_j / v_j)² with the speed limits v_j. In a family of solutions, including that of a hand with only a position,
    each sample uses the member nearest to the previous sample. For a target that is not reached, the nearest pose is
    used if the solver finds it.

    Args:
        robot: a NAO of any version, or another robot with limbs of its geometry.
        path: effector → targets at n samples, or one target for all samples. "LLeg", "RLeg": poses (n, 4, 4); "LArm",
            "RArm": poses (n, 4, 4) or positions (n, 3); "Head": orientations (n, 3, 3); the name of a camera: points
            (n, 3) that it looks at [m].
        times: the times of the samples, increasing, shape (n,) [s]; a segment in which a joint would be too fast is
            stretched. None for the least times within the speed limits.
        torso: the pose of the torso in the world, T_world_torso, shape (n, 4, 4) or (4, 4), for targets in the world.
            None for targets in the torso.
        directions: arm → direction of its forearm, shape (n, 3), with positions of that arm.
        frames: effector → the frame on it that its targets refer to, if not its own.
        near: configurations of the joints that are not in the path, shape (n, nq) or (nq,). The motion from the
            first one to the start of the path counts. Configurations outside the limits are projected onto them, and
            `notes` says so. None for all joints at zero, or at the limit nearest to it; the motion from there does not
            count.
        speed: the share of the speed limits that may be used, above 0.
        priority: the foot that keeps its yaw if both feet need different values of the shared hip motor: "left",
            "right", or "balanced" for half of the error each.
        free: with `torso` and both feet, the direction in which the torso moves, at each sample as little as necessary,
            so that both legs agree: "height", "lean" or "yaw". The result's `torso` is the moved torso, from which all
            other targets are met.
        limits: as in all solvers, see `nao_kin.ik`.
        threads: as in all solvers.
        collisions: as in all solvers, for the branches at each sample, with the other limbs where they are
            without this check. If links overlap in all branches, the sample is not reached: the branch with the largest
            clearance is used, and the message names the links.

    Raises:
        UnknownName: an effector or frame that does not exist.
        BadArgument: arrays of different lengths, times that do not increase, a speed that is not above zero, or a robot
            without such a limb.
        NotARotation, ZeroNorm: an invalid target; the message names the effector and the sample.

    Examples:
        >>> nao = nk.load_nao()
        >>> path = np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 5)
        >>> result = nk.ik.follow(nao, {"LArm": path})
        >>> np.allclose(nao.position(result.q, "LArm"), path)
        True
    """
    enforce, workers = is_enforced(limits), check_threads(threads)
    share = float(positive(speed, "speed"))
    choice(priority, get_args(Priority), "priority")
    given = checked_path(robot, path, directions, torso, times, near)
    references, notes = _references(robot, given, enforce)
    options = {"limits": limits, "threads": workers}
    if free is not None:
        given = _with_free_torso(robot, given, frames, references, options, free)
    limbs = limb_paths(robot, given, frames, options, priority)
    q, weights = np.array(references), _weights(robot)
    start = None if near is None else references[0]
    choices = [_chosen(limb, q, references, weights, start) for limb in limbs]
    rule, columns = CollisionRule.of(collisions), [column for chosen in choices for column in chosen.limb.columns]

    def are_free(rule: CollisionRule) -> NDArray[np.bool_]:
        found = robot.link_shapes.clearance_from(_complete(q, references), references[0], rule, columns)
        return np.asarray(found.is_free)

    if rule is not None and not np.all(are_free(rule)):
        limbs = tuple(
            dataclasses.replace(limb, options={**limb.options, "collisions": rule}, begin=references[0])
            for limb in limbs
        )
        choices = [_chosen(limb, q, references, weights, start) for limb in limbs]
        is_free = are_free(rule)
        choices = [chosen._replace(limb=_without_resolved(chosen.limb, is_free)) for chosen in choices]
    others = _complete(q, references)
    jumps = [
        jump for limb, chosen in zip(limbs, choices, strict=True) for jump in jumps_of(limb, chosen, others, weights)
    ]
    if given.torso is not None and robot.base == "floating":
        q[:, :7] = _bases(robot, given.torso)
    joints = np.nan_to_num(between_samples(q[:, robot.nq_base :]))
    new_times, shares, stretched = scaled(robot, joints, given.times, share)
    return FollowedPath(
        joint_names=robot.joint_names,
        times=new_times,
        q=q,
        torso=given.torso,
        limbs=tuple(chosen.limb for chosen in choices),
        jumps=tuple(sorted(jumps, key=lambda jump: jump.index)),
        stretched=stretched,
        speed_shares=shares,
        motion=sum(chosen.cost for chosen in choices),
        notes=notes,
    )


def _chosen(limb: LimbPath, q: Floats, references: Floats, weights: Floats, start: Floats | None) -> Choice:
    """Return the branches of a limb, with the other limbs as in q, and write their values into q."""
    chosen = choose(limb, _complete(q, references), weights, start=start)
    q[:, list(chosen.limb.columns)] = chosen.values
    return chosen


def _complete(q: Floats, references: Floats) -> Floats:
    """Return configurations with the values of the references where they are nan."""
    return np.where(np.isnan(q), references, q)


def _without_resolved(limb: FollowedLimb, free: NDArray[np.bool_]) -> FollowedLimb:
    """Return the limb as reached at the `free` samples, where another limb has moved out of its way."""
    resolved = free & (limb.reasons == Reason.COLLISION)
    messages = {sample: text for sample, text in limb.messages.items() if not resolved[sample]}
    reasons = np.where(resolved, np.int8(Reason.REACHED), limb.reasons)
    return dataclasses.replace(limb, reasons=reasons, messages=messages)


def _references(robot: RobotModel, path: Path, enforce: bool) -> tuple[Floats, tuple[str, ...]]:
    """Return configurations for all samples, inside the limits if these are enforced, and notes."""
    if path.near is None:
        return np.tile(robot.clamp(robot.neutral()), (path.n, 1)), ()
    same = bool((path.near == path.near[0]).all())
    given = path.near[0] if same else path.near
    inside, notes = checked_reference(robot, given, enforce)
    return np.array(np.broadcast_to(inside, path.near.shape)), notes


def _with_free_torso(
    robot: RobotModel,
    path: Path,
    frames: Mapping[str, str] | None,
    references: Floats,
    options: dict[str, Any],
    free: Free,
) -> Path:
    """Return the path with the torso moved so that both legs agree."""
    if path.torso is None or not {"LLeg", "RLeg"} <= path.targets.keys():
        raise BadArgument("free requires torso and the poses of both feet in the world")
    feet = path.targets["LLeg"], path.targets["RLeg"]
    named = (frames or {}).get("LLeg", "LLeg"), (frames or {}).get("RLeg", "RLeg")
    options = {**options, "base": "floating", "torso": path.torso, "free": free}
    torso = np.asarray(legs(robot, *feet, frames=named, near=references, **options).torso)
    is_found = np.isfinite(torso).all(axis=(1, 2), keepdims=True)
    return dataclasses.replace(path, torso=np.where(is_found, torso, path.torso))


def _weights(robot: RobotModel) -> Floats:
    """Return the weight of motion of each coordinate: 1/v_j, 1 for a joint without speed limit, and 0 for the base."""
    weights = np.zeros(robot.nq)
    weights[robot.nq_base :] = np.where(np.isfinite(robot.velocity_limits), 1.0 / robot.velocity_limits, 1.0)
    return weights


def _bases(robot: RobotModel, torso: Floats) -> Floats:
    """Return base coordinates (n, 7) for poses of the torso, with quaternions that do not change their sign."""
    base = base_coordinates(robot, torso)
    base[:, 3:] = quat_unwrap(base[:, 3:])
    return base
