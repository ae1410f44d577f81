"""A limb and its targets along a path: solving them, interpolating between them, and comparing poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, as_numbers, join_poses, unit
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.ik.arm import arm
from nao_kin.ik.closed_form import torso_frame
from nao_kin.ik.head import head, look_at
from nao_kin.ik.leg import leg
from nao_kin.ik.legs import legs
from nao_kin.ik.results import IKResult, without_collisions
from nao_kin.ik.targets import named_posture, refuse_not_rigid
from nao_kin.robot import RobotModel
from nao_kin.rotations import check_rotation, exp, log

# Distance of compared points from a frame's origin [m]: one radian has the weight of 0.1 m, as in `arm`.
_LEVER = 0.1

Targets = tuple[Floats, ...]
_LEGS, _ARMS = ("LLeg", "RLeg"), ("LArm", "RArm")


@dataclass(frozen=True, eq=False)
class LimbPath:
    """Targets of one limb along a path, in the torso."""

    robot: RobotModel
    name: str  # "LLeg", "RLeg", "legs" for both, "LArm", "RArm" or "Head"
    frames: tuple[str, ...]  # the frame of the targets, or one for each leg; the camera of a gaze
    targets: Targets  # n feet poses; hand poses, or positions and directions; head orientations, or points of a gaze
    options: dict[str, Any]  # further arguments of its solver
    begin: Floats | None = None  # configuration whose overlaps are accepted; None for that of `near`

    @property
    def follows_only(self) -> bool:
        """Whether every target is a hand's position: its family of solutions makes it depend on the previous sample."""
        return self.name in _ARMS and len(self.targets) == 1 and self.targets[0].ndim == 2

    def solve(self, near: Floats, **changed: Any) -> IKResult:
        """Return all solutions, sorted by distance to `near` (n, nq); for a hand's positions the nearest ones."""
        options = {"near": near} | self.options | changed
        rule = options.pop("collisions", False)
        return without_collisions(self.robot, self._solved(options), rule, self.begin)

    def _solved(self, options: dict[str, Any]) -> IKResult:
        robot, frame, target = self.robot, self.frames[0], self.targets[0]
        if self.name == "legs":
            return legs(robot, target, self.targets[1], frames=(frame, self.frames[1]), **options)
        if self.name in _LEGS:
            return leg(robot, self.name[0], target, frame=frame, **options)
        if self.name in _ARMS:
            direction = self.targets[1] if len(self.targets) == 2 else None
            return arm(robot, self.name[0], target, direction=direction, frame=frame, **options)
        if target.ndim == 3:
            return head(robot, target, frame=frame, **options)
        return look_at(robot, target, frame, **options)

    def points(self, q: Floats) -> Floats:
        """Return points that represent the constrained part of the pose, shape (n, p, 3) [m].

        They are the origin and a point on each axis for a pose; the origin for a position; the origin and a point on
        the x-axis for a position with a direction; the points on the axes, relative to the origin, for the head; and
        the one on the optical axis, relative to the origin, for a gaze.
        """
        points = _pose_points(self._poses(q))
        if self.name == "Head":
            axes = points[:, 1:] - points[:, :1]
            return np.asarray(axes if self.targets[0].ndim == 3 else axes[:, :1])
        return points[:, : len(self.targets)] if self.targets[0].ndim == 2 else points

    def at(self, *rows: int) -> LimbPath:
        """Return the path of the targets with these indices, in any order and number."""
        return replace(self, targets=tuple(array[list(rows)] for array in self.targets))

    def between(self, first: Floats, second: Floats, shares: Floats) -> LimbPath:
        """Return targets at shares (m,) in [0, 1] of the path from the pose in one configuration to that in another.

        Positions move straight, orientations rotate about a fixed axis. The five joints of an arm cannot reach poses
        between two of their poses, so its targets are positions, with directions unless these are free. Targets of a
        gaze are orientations, because two of them can look at the same point.
        """
        q = np.stack([first, second])
        T = self._poses(q)
        if self.name == "Head":
            ends = [T[:, 0, :3, :3]]
        elif self.name not in _ARMS:
            ends = [T[:, k] for k in range(len(self.frames))]
        else:
            ends = [T[:, 0, :3, 3]]
            if not self.follows_only:
                forearm, torso = f"{self.name[0]}WristYaw", torso_frame(self.robot)
                ends.append(self.robot.rotation(q, forearm, reference=torso)[:, :, 0])
        return replace(self, targets=tuple(_between(begin, end, shares) for begin, end in ends))

    def _poses(self, q: Floats) -> Floats:
        return np.asarray(self.robot.fk(q, self.frames, reference=torso_frame(self.robot)))


def _pose_points(T: Floats) -> Floats:
    """Return the origin and points on the axes x, y and z of poses (n, f, 4, 4), shape (n, 4 f, 3), frame by frame."""
    origin = T[..., None, :3, 3]
    axes = np.swapaxes(T[..., :3, :3], -1, -2)
    return np.concatenate([origin, origin + _LEVER * axes], axis=-2).reshape(len(T), -1, 3)


def _between(first: Floats, second: Floats, shares: Floats) -> Floats:
    """Return poses, rotations or vectors interpolated between two."""
    if first.ndim == 1:
        return np.asarray(first + shares[:, None] * (second - first))
    turn = log(first[:3, :3].T @ second[:3, :3])
    R = first[:3, :3] @ exp(shares[:, None] * turn)
    if first.shape == (3, 3):
        return np.asarray(R)
    return join_poses(R, _between(first[:3, 3], second[:3, 3], shares))


# --- The path in the arguments of `follow`: checked, and expressed in the torso.

_POSE, _ROTATION, _PLACE = (4, 4), (3, 3), (3,)


@dataclass(frozen=True, eq=False)
class Path:
    """Arrays of n samples along a path."""

    n: int
    targets: dict[str, Floats]  # effector or camera → poses, rotations or positions
    directions: dict[str, Floats]  # arm → directions of its forearm
    torso: Floats | None  # T_world_torso, shape (n, 4, 4), for targets in the world; None for targets in the torso
    times: Floats | None  # shape (n,) [s]
    near: Floats | None  # shape (n, nq)

    def in_torso(self, array: Floats, *, free: bool = False) -> Floats:
        """Return poses, rotations, positions, or with `free` directions, in the torso's frame."""
        if self.torso is None:
            return array
        R = np.swapaxes(self.torso[:, :3, :3], -1, -2)
        if array.shape[1:] == _ROTATION:
            return np.asarray(R @ array)
        if array.shape[1:] == _PLACE:
            seen = array if free else array - self.torso[:, :3, 3]
            return np.asarray(np.einsum("nij,nj->ni", R, seen))
        return join_poses(self.in_torso(array[:, :3, :3]), self.in_torso(array[:, :3, 3]))


def checked_path(
    robot: RobotModel,
    path: Mapping[str, ArrayLike],
    directions: Mapping[str, ArrayLike] | None,
    torso: ArrayLike | None,
    times: ArrayLike | None,
    near: ArrayLike | None,
) -> Path:
    """Return the arguments of `follow` as checked arrays, with constants repeated for all samples."""
    names = (*_LEGS, *_ARMS, "Head", *robot.semantics.cameras)
    given: dict[str, tuple[Floats, int]] = {}
    for name, value in path.items():
        if name not in names:
            own = tuple(known for known in names if known in robot.frame_table)
            raise UnknownName("effector", name, own, "" if own else f"{robot.name} needs nk.ik.numeric for each sample")
        what = f"path[{quoted(name)}]"
        is_pose = name in _LEGS or (name in _ARMS and as_numbers(value, what).shape[-2:] == _POSE)
        given[what] = _samples(value, _POSE if is_pose else _ROTATION if name == "Head" else _PLACE, what)
    if not given:
        raise BadArgument(f"path names no effector; it takes {', '.join(names)}")
    heads = [name for name in path if name not in (*_LEGS, *_ARMS)]
    if len(heads) > 1:
        raise BadArgument(f"path[{quoted(heads[0])}] and path[{quoted(heads[1])}] both move the head: give one")
    for name, value in (directions or {}).items():
        what = f"directions[{quoted(name)}]"
        if name not in path or name not in _ARMS:
            arms = [arm for arm in _ARMS if arm in path]
            raise UnknownName("arm", name, arms, "a direction requires positions of that arm in the path")
        if given[f"path[{quoted(name)}]"][0].shape[1:] == _POSE:
            raise BadArgument(f"{what} requires positions (n, 3): a pose includes a direction")
        array, count = _samples(value, _PLACE, what)
        given[what] = unit(array, what)[0], count
    if torso is not None:
        given["torso"] = _samples(torso, _POSE, "torso")
    if near is not None:
        given["near"] = _samples(named_posture(robot, near), (robot.nq,), "near")
    if times is not None:
        given["times"] = _times(times)
    n = _common_length({what: count for what, (_, count) in given.items()})
    full = {what: np.array(np.broadcast_to(array, (n, *array.shape[1:]))) for what, (array, _) in given.items()}
    by_effector = {name: full[f"path[{quoted(name)}]"] for name in path}
    by_arm = {name: full[f"directions[{quoted(name)}]"] for name in directions or {}}
    return Path(n, by_effector, by_arm, *(full.get(what) for what in ("torso", "times", "near")))


def limb_paths(
    robot: RobotModel, path: Path, frames: Mapping[str, str] | None, options: dict[str, Any], priority: str
) -> tuple[LimbPath, ...]:
    """Return the limbs that follow a path, each with its targets in the torso."""
    frame = {name: name for name in path.targets}
    for name, value in (frames or {}).items():
        if name not in frame:
            raise UnknownName("effector of the path", name, tuple(frame))
        frame[name] = value
    seen: dict[str, Targets] = {name: (path.in_torso(array),) for name, array in path.targets.items()}
    for name, towards in path.directions.items():
        seen[name] += (path.in_torso(towards, free=True),)
    limbs: list[LimbPath] = []
    if set(_LEGS) <= seen.keys():
        feet = [seen.pop(name)[0] for name in _LEGS]
        both = {**options, "priority": priority}
        limbs.append(LimbPath(robot, "legs", tuple(frame[name] for name in _LEGS), tuple(feet), both))
    # A camera moves the head. Legs come first.
    for name in sorted(seen, key=lambda name: name not in _LEGS):
        limb = name if name in (*_LEGS, *_ARMS) else "Head"
        limbs.append(LimbPath(robot, limb, (frame[name],), seen[name], options))
    return tuple(limbs)


def _samples(value: ArrayLike, tail: tuple[int, ...], what: str) -> tuple[Floats, int]:
    """Return samples (n, *tail) and n, or a constant (1, *tail) and 0."""
    array = as_floats(value, (), what)
    shape = ", ".join(map(str, tail))
    if array.shape != tail and array.shape[1:] != tail:
        constant = f"({shape}{',' if len(tail) == 1 else ''})"
        raise WrongShape(what, f"(n, {shape}), or {constant} for all samples", array.shape)
    is_constant = array.shape == tail
    samples = array[None] if is_constant else array
    if not len(samples):
        raise BadArgument(f"{what} has no samples")
    if tail == _POSE:
        refuse_not_rigid(array, what)
    elif tail == _ROTATION:
        check_rotation(array, name=what)
    return samples, 0 if is_constant else len(samples)


def _times(value: ArrayLike) -> tuple[Floats, int]:
    array = as_floats(value, (), "times")
    if array.ndim != 1 or not len(array):
        raise WrongShape("times", "(n,)", array.shape)
    late = np.flatnonzero(np.diff(array) <= 0.0)
    if len(late):
        i = int(late[0])
        raise BadArgument(f"times must increase, got {array[i]:.6g} and then {array[i + 1]:.6g} at index [{i + 1}]")
    return array, len(array)


def _common_length(counts: dict[str, int]) -> int:
    sampled = {what: count for what, count in counts.items() if count}
    if not sampled:
        return 1
    first, n = next(iter(sampled.items()))
    for what, count in sampled.items():
        if count != n:
            raise BadArgument(f"a path's arrays must have one length: {first} has {n} samples and {what} has {count}")
    return n
