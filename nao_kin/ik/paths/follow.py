"""`follow`: a path of targets to a joint trajectory, continuous where that is possible, within the speed limits."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import SupportsIndex, get_args

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik.closed_forms.legs import Free, Priority, legs
from nao_kin.ik.geometry import torso_frame
from nao_kin.ik.paths.branch_choice import choose
from nao_kin.ik.paths.followed_path import FollowedLimb, FollowedPath, followed_limb, positive
from nao_kin.ik.paths.jumps import Jump, jumps_of
from nao_kin.ik.paths.path_targets import Path, checked_path, limb_paths
from nao_kin.ik.paths.time_scaling import between_samples, scaled
from nao_kin.ik.targets import Limits, check_threads, inside_limits, is_enforced, with_unit_quaternion
from nao_kin.robot import RobotModel, check_robot
from nao_kin.rotations import quat_from_matrix, quat_to_xyzw

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
    followed: list[FollowedLimb] = []
    jumps: list[Jump] = []
    motion = 0.0
    for limb in limbs:
        choice = choose(limb, references, weights, start=start)
        q[:, list(choice.columns)] = choice.values
        followed.append(followed_limb(limb.name, choice))
        jumps.extend(jumps_of(limb, choice, references, weights))
        motion += choice.cost
    if given.torso is not None and robot.base == "floating":
        q[:, :7] = _bases(robot, given.torso)
    joints = np.nan_to_num(between_samples(q[:, robot.nq - len(robot.joint_names) :]))
    timing = scaled(robot, joints, given.times, share)
    return FollowedPath(
        joint_names=robot.joint_names,
        times=timing.times,
        q=q,
        torso=given.torso,
        limbs=tuple(followed),
        jumps=tuple(sorted(jumps, key=lambda jump: jump.index)),
        stretched=timing.stretched,
        speed_shares=timing.shares,
        motion=motion,
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
    there = np.isfinite(given_way).all(axis=(1, 2), keepdims=True)
    return dataclasses.replace(path, torso=np.where(there, given_way, path.torso))


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
