"""`follow`: a path of targets to a joint trajectory, continuous where that is possible, within the speed limits."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import SupportsIndex, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik.follow_branches import Choice, FollowedLimb, Jump, choose, jumps_of
from nao_kin.ik.follow_limbs import Path, checked_path, limb_paths
from nao_kin.ik.geometry import torso_frame
from nao_kin.ik.legs import Free, Priority, legs
from nao_kin.ik.results import Codes
from nao_kin.ik.targets import Limits, check_threads, inside_limits, is_enforced, with_unit_quaternion
from nao_kin.robot import RobotModel, check_robot
from nao_kin.rotations import quat_from_matrix, quat_from_xyzw, quat_to_xyzw, slerp

# --- Times at which a path can be followed without any joint exceeding its speed limit.


@dataclass(frozen=True)
class Stretch:
    """A segment that takes longer than was asked.

    Attributes:
        index: it is between this sample and the next one.
        joint: the joint that needs the time.
        given: the time that was asked for [s].
        needed: the time that it takes [s].

    Examples:
        >>> nao = nk.load_nao()
        >>> path = np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 5)
        >>> result = nk.ik.follow(nao, {"LArm": path}, times=np.linspace(0.0, 0.01, 5))
        >>> stretch = result.stretched[0]
        >>> stretch.index, stretch.given < stretch.needed
        (0, True)
    """

    index: int
    joint: str
    given: float
    needed: float

    def describe(self) -> str:
        """The segment in a sentence.

        Examples:
            >>> nk.ik.Stretch(0, "LElbowYaw", given=0.1, needed=0.25).describe()
            'LElbowYaw needs 0.25 s instead of 0.1 s after sample 0'
        """
        return f"{self.joint} needs {self.needed:.3g} s instead of {self.given:.3g} s after sample {self.index}"


def scaled(
    robot: RobotModel, joints: Floats, times: Floats | None, speed: float
) -> tuple[Floats, Floats, tuple[Stretch, ...]]:
    """The times of samples, stretched where a joint would be too fast; or the least times.

    Segment by segment dt = max(given, max_j |Δq_j| / (speed · v_j)).

    Args:
        robot: whose speed limits v_j.
        joints: values of all joints, shape (n, joints).
        times: as asked, shape (n,), increasing; None for the least.
        speed: the share of the limits that may be used.

    Returns:
        Times, shape (n,) [s]; the speed of each joint in each segment as a share of its limit, shape (n − 1, joints);
        and the segments that take longer than was asked.

    Raises:
        BadArgument: a joint is to move whose speed limit is zero.
    """
    moved = np.abs(np.diff(joints, axis=0))
    stuck = (moved > 0.0).any(axis=0) & (robot.velocity_limits <= 0.0)
    if stuck.any():
        joint = robot.joint_names[int(np.argmax(stuck))]
        raise BadArgument(f"{joint} is to move, and its speed limit is 0: no time is long enough")
    limits = np.where(moved.any(axis=0), robot.velocity_limits, np.inf)
    least = moved / limits
    needed = least.max(axis=1, initial=0.0) / speed
    given = np.zeros(len(moved)) if times is None else np.diff(times)
    # Differences of times are rounded: what is too short by no more than that is kept as it is.
    short = needed > given * (1.0 + 1e-12) + (0.0 if times is None else 4.0 * np.spacing(np.abs(times).max()))
    taken = np.where(short, needed, given)
    if times is not None and not short.any():
        found = np.array(times)
    else:
        found = np.concatenate([[0.0], np.cumsum(taken)]) + (0.0 if times is None else times[0])
    shares = np.divide(least, taken[:, None], out=np.zeros_like(least), where=taken[:, None] > 0.0)
    stretched = [] if times is None else np.flatnonzero(short).tolist()
    names = [robot.joint_names[int(np.argmax(least[i]))] for i in stretched]
    return (
        found,
        shares,
        tuple(Stretch(i, name, float(given[i]), float(needed[i])) for i, name in zip(stretched, names, strict=True)),
    )


def between_samples(values: Floats) -> Floats:
    """Columns of values with what is missing put between the samples beside it, or equal to the only one beside it.

    Args:
        values: shape (n, c); nan where missing. A column of nothing else stays so.
    """
    filled = np.array(values)
    places = np.arange(len(values))
    for column in np.flatnonzero(np.isnan(values).any(axis=0)):
        known = ~np.isnan(values[:, column])
        if known.any():
            filled[:, column] = np.interp(places, places[known], values[known, column])
    return filled


# --- `FollowedPath`: a joint trajectory along a path of targets, and what is to be said about it.

_BASE = 7
# How many of each kind a message lists.
_LISTED = 3


@dataclass(frozen=True, eq=False)
class FollowedPath:
    """A joint trajectory along a path of n samples.

    Attributes:
        joint_names: the joints in the order of q, after the seven numbers of a floating base.
        times: of the samples, shape (n,) [s]; equal where nothing moves and no times were given.
        q: configurations, shape (n, nq). Where a sample is not reached the limb is at the nearest pose, if its solver
            offers one, else its joints are nan.
        torso: the pose of the torso in the world, shape (n, 4, 4); None where targets are in the torso.
        limbs: what each limb does.
        jumps: where a limb cannot move continuously, in order.
        stretched: segments that take longer than was asked, in order.
        speed_shares: speed of each joint in each segment as a share of its limit, shape (n − 1, joints).
        motion: the sum over the path of the squared motion Σ (Δq_j / v_j)² of the limbs that follow it [s²].
        notes: what else is to be said, one line each.

    Examples:
        >>> nao = nk.load_nao()
        >>> path = np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 5)
        >>> result = nk.ik.follow(nao, {"LArm": path})
        >>> result.q.shape, bool(result.success)
        ((5, 25), True)
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
        """From the first sample to the last [s]."""
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
        """Whether all targets are reached, and without a jump."""
        return bool(self.reached.all()) and not self.jumps

    @property
    def largest_speed_share(self) -> float:
        """The largest joint speed as a share of its limit; 0 where nothing moves."""
        return float(self.speed_shares.max(initial=0.0))

    @property
    def message(self) -> str:
        """What came of it, in words."""
        n = len(self.times)
        reached = int(np.count_nonzero(self.reached))
        lines = [f"{reached} of {n} {'sample' if n == 1 else 'samples'} reached in {self.duration:.4g} s"]
        for limb in self.limbs:
            if limb.messages:
                first, text = next(iter(limb.messages.items()))
                count = len(limb.messages)
                more = f" and {count - 1} more" if count > 1 else ""
                lines.append(f"{limb.name} does not reach sample {first}{more}: {text}")
        lines.extend([_some([jump.describe() for jump in self.jumps])] if self.jumps else [])
        lines.extend([_some([segment.describe() for segment in self.stretched])] if self.stretched else [])
        return "; ".join([*lines, *self.notes])

    def sampled(self, fps: float = 30.0) -> Floats:
        """Configurations at equal steps of time, as `Viewer.animate` plays them.

        Joints and the place of the base are interpolated linearly, the orientation of the base by slerp. A limb without
        values at some samples moves from the sample before them to the one behind them.

        Args:
            fps: configurations per second.

        Returns:
            Shape (m, nq); the last is that of the last sample, which may be less than a step after the one before.

        Raises:
            BadArgument: no positive number, or a limb has no values at any sample.

        Examples:
            >>> nao = nk.load_nao()
            >>> path = np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 5)
            >>> result = nk.ik.follow(nao, {"LArm": path})
            >>> result.sampled(fps=100).shape[1]
            25
        """
        rate = positive(fps, "fps")
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


def positive(value: float, what: str) -> float:
    """One number above zero.

    Raises:
        BadArgument, WrongShape, NotFinite: it is none.
    """
    array = as_floats(value, (), what)
    if array.shape != () or not array > 0.0:
        raise BadArgument(f"{what} must be a number above zero, got {value}")
    return float(array)


def _some(texts: list[str]) -> str:
    more = f" and {len(texts) - _LISTED} more" if len(texts) > _LISTED else ""
    return "; ".join(texts[:_LISTED]) + more


# --- `follow`: a path of targets to a joint trajectory, continuous where that is possible, within the speed limits.

_PRIORITIES = get_args(Priority)


def follow(
    robot: RobotModel,
    path: Mapping[str, ArrayLike],
    *,
    times: ArrayLike | None = None,
    torso: ArrayLike | None = None,
    directions: Mapping[str, ArrayLike] | None = None,
    frames: Mapping[str, str] | None = None,
    reference: ArrayLike | None = None,
    limits: Limits = "enforce",
    speed: float = 1.0,
    priority: Priority = "balanced",
    free: Free | None = None,
    threads: SupportsIndex | None = None,
) -> FollowedPath:
    """A joint trajectory along a path of targets for any of feet, hands and head.

    Of all branches of each limb at each sample those are taken that make the sum of the squared motion
    Σ (Δq_j / v_j)² least, v_j being the speed limits, by dynamic programming; each limb by itself, both legs as one.
    Along a family of solutions, also that of a hand of which only the place is asked for, a sample takes the member
    nearest to the sample before. Where a target is not reached and the solver knows the nearest pose, that is taken.

    Args:
        robot: a NAO of any version, or another robot with limbs of its geometry.
        path: targets along one parameter, one array of n samples for each effector, or one target for all samples:
            "LLeg", "RLeg": poses (n, 4, 4); "LArm", "RArm": poses (n, 4, 4) or places (n, 3); "Head": orientations
            (n, 3, 3), or under the name of a camera points (n, 3) that it looks at [m].
        times: of the samples, increasing, shape (n,) [s]. Segments in which a joint would be too fast are stretched.
            None for the least times that the speed limits allow.
        torso: the pose of the torso in the world, T_world_torso, shape (n, 4, 4) or (4, 4): targets are then in the
            world. None: they are in the torso.
        directions: arm → where its forearm is to point, shape (n, 3), with places of that arm.
        frames: effector → the frame on it that the targets are of, for other frames than the effector's own.
        reference: configurations that all joints not in the path are taken from, shape (n, nq) or (nq,). The way from
            the first to the path counts as motion. Outside the limits they are projected onto them, and `notes` says
            so. None for all joints at zero, or at the limit nearest to it: that way does then not count.
        limits: "enforce" leaves out branches with a joint outside its own or a coupled limit; "ignore" takes all.
        speed: the share of the speed limits that may be used, above 0.
        priority: which foot keeps its yaw where both feet ask for different values of the one hip motor: "left",
            "right", or "balanced" for half of the error each.
        free: with `torso` and both feet: in what the torso gives way so that they do not disagree: "height", "lean" or
            "yaw", at each sample as little as is needed. The result's `torso` is where it then is, and all other
            targets are met from there.
        threads: how many threads may work; None for all cores where that is worthwhile.

    Returns:
        The trajectory, with the samples that are not reached, the jumps and the stretched segments.

    Raises:
        UnknownName: no such effector, frame, policy or priority.
        BadArgument: no effector or sample at all, lengths that differ, times that do not increase, a pose that is no
            rigid transform, coordinates above 1e150, a speed that is not above zero; or the robot has no such limb.
        NotARotation, ZeroNorm, NotFinite, WrongShape: targets that are none; the message says of which effector and
            sample.

    Examples:
        >>> nao = nk.load_nao()
        >>> path = np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 5)
        >>> result = nk.ik.follow(nao, {"LArm": path})
        >>> np.allclose(nao.position(result.q, "LArm"), path)
        True
    """
    check_robot(robot)
    enforce, workers = is_enforced(limits), check_threads(threads)
    share = positive(speed, "speed")
    if not isinstance(priority, str) or priority not in _PRIORITIES:
        raise UnknownName("priority", priority, _PRIORITIES)
    given = checked_path(robot, path, directions, torso, times, reference)
    references, notes = _references(robot, given, enforce)
    if free is not None:
        given = _given_way(robot, given, frames, references, limits, free, workers)
    options = {"limits": limits, "threads": workers}
    limbs = limb_paths(robot, given, frames, options, priority)
    q, weights = np.array(references), _weights(robot)
    start = None if reference is None else references[0]
    choices: list[Choice] = []
    jumps: list[Jump] = []
    for limb in limbs:
        choice = choose(limb, references, weights, start=start)
        q[:, list(choice.limb.columns)] = choice.values
        choices.append(choice)
        jumps.extend(jumps_of(limb, choice, references, weights))
    if given.torso is not None and robot.base == "floating":
        q[:, :7] = _bases(robot, given.torso)
    joints = np.nan_to_num(between_samples(q[:, robot.nq - len(robot.joint_names) :]))
    found, shares, stretched = scaled(robot, joints, given.times, share)
    return FollowedPath(
        joint_names=robot.joint_names,
        times=found,
        q=q,
        torso=given.torso,
        limbs=tuple(choice.limb for choice in choices),
        jumps=tuple(sorted(jumps, key=lambda jump: jump.index)),
        stretched=stretched,
        speed_shares=shares,
        motion=sum(choice.cost for choice in choices),
        notes=notes,
    )


def _references(robot: RobotModel, path: Path, enforce: bool) -> tuple[Floats, tuple[str, ...]]:
    """Configurations for all samples, inside the limits where these are enforced, and notes."""
    if path.reference is None:
        return np.tile(robot.clamp(robot.neutral()), (path.n, 1)), ()
    same = bool((path.reference == path.reference[0]).all())
    given = path.reference[0] if same else path.reference
    found, notes = inside_limits(robot, given) if enforce else (with_unit_quaternion(robot, given), ())
    return np.array(np.broadcast_to(found, path.reference.shape)), notes


def _given_way(
    robot: RobotModel,
    path: Path,
    frames: Mapping[str, str] | None,
    references: Floats,
    limits: Limits,
    free: Free,
    threads: int | None,
) -> Path:
    """The path with the torso where both feet let it be.

    Raises:
        BadArgument: no torso or not both feet.
    """
    if path.torso is None or not {"LLeg", "RLeg"} <= path.targets.keys():
        raise BadArgument("free goes with torso and the poses of both feet in the world")
    named = frames or {}
    found = legs(
        robot,
        path.targets["LLeg"],
        path.targets["RLeg"],
        frames=(named.get("LLeg", "LLeg"), named.get("RLeg", "RLeg")),
        reference=references,
        limits=limits,
        base="floating",
        torso=path.torso,
        free=free,
        threads=threads,
    )
    given_way = np.asarray(found.torso)
    is_found = np.isfinite(given_way).all(axis=(1, 2), keepdims=True)
    return dataclasses.replace(path, torso=np.where(is_found, given_way, path.torso))


def _weights(robot: RobotModel) -> Floats:
    """What motion of each coordinate counts: 1/v_j, 1 where a joint has no speed limit, and 0 for the base."""
    v = robot.velocity_limits
    limited = np.isfinite(v) & (v > 0.0)
    weights = np.zeros(robot.nq)
    weights[robot.nq - len(v) :] = np.where(limited, 1.0 / np.where(limited, v, 1.0), 1.0)
    return weights


def _bases(robot: RobotModel, torso: Floats) -> Floats:
    """Coordinates of the floating base for poses of the torso, quaternions without a change of sign, shape (n, 7)."""
    T_base_torso = robot.fk(robot.neutral(), torso_frame(robot))
    T = torso @ np.linalg.inv(T_base_torso)
    quaternions = quat_to_xyzw(quat_from_matrix(T[:, :3, :3]))
    turned = np.einsum("ni,ni->n", quaternions[1:], quaternions[:-1]) < 0.0
    signs = np.cumprod(np.concatenate([[1.0], np.where(turned, -1.0, 1.0)]))
    return np.concatenate([T[:, :3, 3], quaternions * signs[:, None]], axis=1)
