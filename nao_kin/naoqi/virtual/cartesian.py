"""Cartesian control: paths of effectors over time, and the joint values that follow them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._core.arrays import Floats, join_poses, rigid_inverse
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.motion import Motion
from nao_kin.naoqi.names import as_names
from nao_kin.naoqi.spaces import (
    EFFECTORS,
    FRAME_ROBOT,
    FRAME_TORSO,
    axis_mask,
    controlled_axes,
    pose,
    pose_from_list,
    pose_in,
    robot_frame,
    space_number,
)
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual import limb_solvers as limbs
from nao_kin.naoqi.virtual.engine import Task
from nao_kin.naoqi.virtual.interpolation import Approach
from nao_kin.naoqi.virtual.limb_solvers import Solution, Target
from nao_kin.rotations import exp, log

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


# --- What Cartesian calls take: effectors, spaces, masks, poses and times, in the forms that NAOqi takes them.

ToPoses = Callable[[Any], Floats]


@dataclass(frozen=True, eq=False)
class Wish:
    """What is asked of one effector.

    Attributes:
        effector: one of the six.
        space: the space of its poses.
        mask: the axes that count, along those of the space.
        poses: of its path, shape (k, 4, 4), in the space; or changes.
        times: of these, shape (k,) [s]; empty where there is no time.
        relative: the poses are changes of where the effector is at the beginning.
    """

    effector: str
    space: int
    mask: int
    poses: Floats
    times: Floats
    relative: bool


def positions(value: Any) -> Floats:
    """Poses of Position6D, shape (..., 6)."""
    return pose(value)


def transforms(value: Any) -> Floats:
    """Poses of transforms, shape (..., 16) or (..., 12)."""
    return pose_from_list(value)


def wishes(
    names: Any, spaces: Any, paths: Any, masks: Any, times: Any, read: ToPoses, *, relative: bool = False
) -> tuple[Wish, ...]:
    """Every effector's path.

    Args:
        names: an effector, or a list of them.
        spaces: a space for all, or a list of one for each.
        paths: a list of one path for each effector, a path being a list of poses or one pose; of a single effector also
            its path alone.
        masks: a mask for all, or a list of one for each.
        times: of one effector a time or a list of times; of several a list of times for each, or one list for all; one
            time for each pose. None where there are none.
        read: `positions` or `transforms`.
        relative: the poses are changes.

    Raises:
        UnknownName: no effector or space of this name.
        BadArgument: lengths that do not fit, or what is no number, mask or space.
        WrongShape, NotFinite, NotARotation: what is no pose.
    """
    effectors = _effectors(names)
    count = len(effectors)
    numbers = _each(spaces, count, "spaces", space_number)
    chosen = _each(masks, count, "axis masks", axis_mask)
    rows = [_path(path, read, effector) for path, effector in zip(_split(paths, count), effectors, strict=True)]
    when = [np.empty(0)] * count if times is None else _times(times, effectors, rows)
    for effector, space in zip(effectors, numbers, strict=True):
        if effector == "Torso" and space == FRAME_TORSO:
            raise BadArgument("Torso does not move in FRAME_TORSO, which is the torso: FRAME_WORLD or FRAME_ROBOT")
    fields = zip(effectors, numbers, chosen, rows, when, strict=True)
    return tuple(Wish(*entry, relative) for entry in fields)


def single(
    names: Any, spaces: Any, poses: Any, masks: Any, read: ToPoses, *, relative: bool = False
) -> tuple[Wish, ...]:
    """Every effector's one pose, without a time; arguments and errors as in `wishes`."""
    found = wishes(names, spaces, poses, masks, None, read, relative=relative)
    for wish in found:
        if len(wish.poses) != 1:
            raise BadArgument(f"{wish.effector} must have one pose, got {len(wish.poses)}")
    return found


def _effectors(names: Any) -> tuple[str, ...]:
    effectors = as_names(names)
    for name in effectors:
        if name not in EFFECTORS:
            raise UnknownName("effector", name, EFFECTORS)
    if len(set(effectors)) < len(effectors):
        raise BadArgument(f"an effector is named twice: {', '.join(effectors)}")
    if not effectors:
        raise BadArgument("effectorNames must name an effector at least")
    return effectors


def _each(value: Any, count: int, what: str, read: Callable[[Any], int]) -> list[int]:
    """One number for all, or one for each."""
    if not isinstance(value, (list, tuple, np.ndarray)):
        return [read(value)] * count
    if len(value) != count:
        raise BadArgument(f"{what} must be one for all effectors or {count}, got {len(value)}")
    return [read(entry) for entry in value]


def _depth(value: Any) -> int:
    """How many lists are inside each other, along the first entries."""
    depth = 0
    while isinstance(value, (list, tuple, np.ndarray)):
        depth += 1
        value = value[0] if len(value) else None
    return depth


def _split(paths: Any, count: int) -> Sequence[Any]:
    """The path of each effector."""
    if count == 1:
        return paths if _depth(paths) == 3 and len(paths) == 1 else [paths]
    if _depth(paths) < 2 or len(paths) != count:
        got = len(paths) if isinstance(paths, (list, tuple, np.ndarray)) else quoted(paths, 60)
        raise BadArgument(f"paths must be {count}, one for each effector, got {got}")
    return list(paths)


def _path(path: Any, read: ToPoses, effector: str) -> Floats:
    """The poses of one path, shape (k, 4, 4)."""
    depth = _depth(path)
    if depth not in (1, 2) or not len(path):
        raise BadArgument(f"the path of {effector} must be a pose or a list of poses, got {quoted(path, 60)}")
    poses = read(list(path))
    return poses[None] if poses.ndim == 2 else poses


def _times(times: Any, effectors: Sequence[str], rows: Sequence[Floats]) -> list[Floats]:
    count, lengths = len(effectors), [len(row) for row in rows]
    depth = _depth(times)
    if depth == 1 and count > 1:
        for_all = all(length == len(times) for length in lengths)
        one_each = len(times) == count and all(length == 1 for length in lengths)
        lists: list[Any] = [times] * count if for_all or not one_each else [[time] for time in times]
    elif depth == 2 and len(times) == count:
        lists = list(times)
    elif depth < 2:
        lists = [[times] if depth == 0 else times] * count
    else:
        got = len(times) if depth else quoted(times, 60)
        raise BadArgument(f"times must be a list for each of {count} effectors, got {got}")
    found = [arguments.list_each([row], [name], "times")[0] for row, name in zip(lists, effectors, strict=True)]
    arguments.check_lengths(rows, found, effectors, "poses")
    arguments.check_times(found, effectors)
    return found


# --- The path of one effector: poses at times, and the curve through them.

_COORDINATES = ("x", "y", "z")


class EffectorPath:
    """A curve through poses at times, at rest at both ends.

    x, y and z each go along the monotone cubic of `nao_kin.motion`: straight to a single target, and never beyond the
    keys beside it. The rotation turns from key to key about one axis (slerp); how far it has turned in all is such a
    cubic too.

    Args:
        times: of the keys, ascending, shape (k,) [s].
        poses: at these times, shape (k, 4, 4).
    """

    def __init__(self, times: Sequence[float] | Floats, poses: Floats) -> None:
        self._times = np.asarray(times, dtype=np.float64)
        self._R = np.array(poses[:, :3, :3])
        self._turns = log(np.swapaxes(self._R[:-1], -1, -2) @ self._R[1:])
        angles = np.linalg.norm(self._turns, axis=-1)
        self._turned = np.concatenate([[0.0], np.cumsum(angles)])
        keys = np.column_stack([poses[:, :3, 3], self._turned])
        self._motion = Motion(self._times, (*_COORDINATES, "turn"), keys, "smooth")

    @property
    def end(self) -> float:
        """Time of the last key [s]."""
        return float(self._times[-1])

    def segment(self, time: float) -> int:
        """Which two keys a time lies between: 0 from the first to the second."""
        return int(np.clip(np.searchsorted(self._times, time, side="right") - 1, 0, max(0, len(self._times) - 2)))

    def pose(self, time: float) -> Floats:
        """The pose at a time, shape (4, 4)."""
        x, y, z, turned = self._motion.sample(time)
        at, place = self.segment(time), np.array([x, y, z])
        if at >= len(self._turns):
            return join_poses(self._R[-1], place)
        whole = self._turned[at + 1] - self._turned[at]
        share = min(max((turned - self._turned[at]) / whole, 0.0), 1.0) if whole > 0.0 else 1.0
        return join_poses(self._R[at] @ exp(share * self._turns[at]), place)


def moved_by(change: Floats, T: Floats) -> Floats:
    """A pose after a change along the axes of its space: places add up, and turns are made about these axes.

    Args:
        change: shape (..., 4, 4).
        T: the pose before, shape (4, 4).
    """
    return join_poses(change[..., :3, :3] @ T[:3, :3], T[:3, 3] + change[..., :3, 3])


# --- The motion tasks of Cartesian control: effectors along paths in time, and joints on their way to a solution.

_ON_TIME = 1e-9
# A path is tried out at so many places between two keys, before it is followed.
_TRIED = 8
# What is left of a target that scripts are told of: metres, and radians times 0.1.
_NOTEWORTHY = 1e-3


class Scene:
    """What poses of effectors mean, for a configuration and a torso in the world.

    Args:
        nao: the virtual NAO; its commands count.
    """

    def __init__(self, nao: VirtualNao) -> None:
        self.robot = nao.robot
        self.q = nao.joints.q(sensor=False)
        self.T_world_torso = nao.base.torso(self.q)
        # FRAME_ROBOT moves with the feet; a task takes it where it was at the beginning.
        self.T_world_robot = robot_frame(nao.robot, self.q, torso_in_world=self.T_world_torso)
        self._standing = nao.base.support

    def pose(self, effector: str, space: int) -> Floats:
        """Where an effector is in a space, shape (4, 4)."""
        return pose_in(self.robot, self.q, effector, space, torso_in_world=self.T_world_torso)

    def in_world(self, poses: Floats, space: int) -> Floats:
        """Poses of a space in the world; those of FRAME_TORSO stay in the torso."""
        return np.asarray(self.T_world_robot @ poses if space == FRAME_ROBOT else poses)

    def path(self, wish: Wish) -> Floats:
        """All poses of a wish from where the effector is now, changes added to it, shape (k + 1, 4, 4)."""
        now = self.pose(wish.effector, wish.space)
        poses = moved_by(wish.poses, now) if wish.relative else wish.poses
        if wish.effector == limbs.TORSO:
            poses = limbs.completed(poses, now, wish.mask)
        return self.in_world(np.concatenate([now[None], poses]), wish.space)

    def target(self, wish: Wish, T: Floats, T_world_torso: Floats) -> Target:
        """What the solvers are asked for.

        Args:
            wish: of which effector, space and mask.
            T: its pose, as `path` gives it.
            T_world_torso: where the torso is then.
        """
        axes = controlled_axes(wish.mask)
        if wish.space == FRAME_TORSO:
            return Target(wish.effector, T, axes, np.eye(3))
        R_world_space = self.T_world_robot[:3, :3] if wish.space == FRAME_ROBOT else np.eye(3)
        if wish.effector in limbs.LEGS and self._standing not in (None, wish.effector):
            # A leg takes the hip of the other one with it, and so the torso: only the standing foot stays.
            T_sole_world = rigid_inverse(self.T_world_torso @ self.robot.fk(self.q, self._standing))
            return Target(wish.effector, T_sole_world @ T, axes, T_sole_world[:3, :3] @ R_world_space, self._standing)
        R_torso_world = T_world_torso[:3, :3].T
        return Target(wish.effector, limbs.in_torso(T_world_torso, T), axes, R_torso_world @ R_world_space)


def hold_still(nao: VirtualNao, wishes: Sequence[Wish]) -> None:
    """Stand on the foot that is not moved, where one is."""
    moved = [wish.effector for wish in wishes if wish.effector in limbs.LEGS]
    if len(moved) == 1 and nao.base.support == moved[0]:
        nao.base.stand_on(limbs.LEGS[1 - limbs.LEGS.index(moved[0])], nao.joints.q(sensor=False))


def moves_legs(wishes: Sequence[Wish]) -> bool:
    """Whether a task for these wishes moves the legs."""
    return any(wish.effector in (limbs.TORSO, *limbs.LEGS) for wish in wishes)


def needed_joints(nao: VirtualNao, wishes: Sequence[Wish]) -> tuple[str, ...]:
    """The joints that a task for these wishes moves, each once, by their 26 names."""
    return limbs.joints_of(nao.robot, [wish.effector for wish in wishes])


class _Limb:
    """One limb on its path, from segment to segment.

    A segment is followed by descents from tick to tick. Where that ends beside its key, and other joint values meet it,
    the joints go straight to these instead.
    """

    def __init__(self, wish: Wish, scene: Scene) -> None:
        self.wish, self._scene = wish, scene
        self.path = EffectorPath(np.concatenate([[0.0], wish.times]), scene.path(wish))
        self._keys = np.concatenate([[0.0], wish.times])
        self._columns = limbs.columns_of(scene.robot, [wish.effector])
        self._segment = -1
        self._straight: tuple[Floats, Floats] | None = None
        self.missing = 0.0

    def solve(self, time: float, q: Floats, T_world_torso: Floats) -> Floats:
        """The configuration at a time, from that of the tick before."""
        at = self.path.segment(time)
        if at != self._segment:
            self._segment = at
            self._look_ahead(at, q, T_world_torso)
        if self._straight is None:
            return limbs.near(self._scene.robot, self._target(time, T_world_torso), q).q
        begin, end = self._keys[at], self._keys[at + 1]
        share = min(max((time - begin) / (end - begin), 0.0), 1.0)
        start, goal = self._straight
        found = q.copy()
        found[self._columns] = start + share * share * (3.0 - 2.0 * share) * (goal - start)
        return np.asarray(found)

    def _target(self, time: float, T_world_torso: Floats) -> Target:
        return self._scene.target(self.wish, self.path.pose(time), T_world_torso)

    def _look_ahead(self, at: int, q: Floats, T_world_torso: Floats) -> None:
        begin, end = self._keys[at], self._keys[at + 1]
        found = Solution(q, 0.0)
        for share in np.arange(1, _TRIED + 1) / _TRIED:
            target = self._target(float(begin + share * (end - begin)), T_world_torso)
            found = limbs.near(self._scene.robot, target, found.q)
        self._straight = None
        if found.missing > limbs.MET:
            other = limbs.anywhere(self._scene.robot, target, q)
            if other.missing < found.missing - limbs.MET:
                self._straight = q[self._columns].copy(), other.q[self._columns]
                found = other
        self.missing = found.missing


class PathTask(Task):
    """Effectors follow paths; what positionInterpolations and transformInterpolations do.

    Args:
        name: NAOqi's method.
        nao: the virtual NAO.
        wishes: of each effector its path.
    """

    def __init__(self, name: str, nao: VirtualNao, wishes: Sequence[Wish]) -> None:
        super().__init__(name, needed_joints(nao, wishes))
        self.keeps_feet = moves_legs(wishes)
        self._wishes = tuple(wishes)
        self._joints = needed_joints(nao, wishes)

    def start(self, nao: VirtualNao, time: float) -> None:
        """Begin where the joints are commanded to be."""
        hold_still(nao, self._wishes)
        scene = Scene(nao)
        self._scene, self._start = scene, time
        self._columns = nao.joints.columns(self._joints)
        self._T_world_feet = np.stack([scene.T_world_torso @ nao.robot.fk(scene.q, foot) for foot in limbs.LEGS])
        by_name = {wish.effector: _Limb(wish, scene) for wish in self._wishes}
        self._torso = by_name.pop(limbs.TORSO, None)
        legs = [name for name in by_name if name in limbs.LEGS]
        self._legs = [by_name.pop(name) for name in legs]
        self._others = list(by_name.values())
        self._end = max(float(wish.times[-1]) for wish in self._wishes)
        nao.joints.note_limp(self._columns, self.notes)

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """Solve for this tick: torso and legs first, then what hangs on the torso."""
        t = time - self._start
        q = nao.joints.q(sensor=False)
        T_world_torso = nao.base.torso(q)
        if self._torso is not None:
            q = self._over_feet(t, q)
        elif self._legs:
            where = self._scene.T_world_torso if len(self._legs) == 2 else T_world_torso
            for leg in self._legs:
                q = self._solved(leg, t, q, where)
        T_world_torso = nao.base.torso(q)
        for limb in self._others:
            q = self._solved(limb, t, q, T_world_torso)
        nao.joints.set(self._columns, nao.robot.to_body(q)[self._columns], self.notes)
        return t >= self._end - _ON_TIME

    def _solved(self, limb: _Limb, t: float, q: Floats, T_world_torso: Floats) -> Floats:
        found = limb.solve(t, q, T_world_torso)
        if limb.missing > _NOTEWORTHY:
            effector = limb.wish.effector
            self.notes.once(("missed", effector), f"{effector} does not reach its target; it goes as near as it can")
        return found

    def _over_feet(self, t: float, q: Floats) -> Floats:
        """Both legs for the torso on its path; a foot that has a path too is where that has it, the other stands."""
        assert self._torso is not None
        feet = self._T_world_feet.copy()
        for leg in self._legs:
            T = leg.path.pose(t)
            where = self._scene.T_world_torso @ T if leg.wish.space == FRAME_TORSO else T
            feet[limbs.LEGS.index(leg.wish.effector)] = where
        found = limbs.torso_over_feet(self._scene.robot, self._torso.path.pose(t), feet, q)
        if found.missing > _NOTEWORTHY:
            what = "legs" if np.isinf(found.missing) else "one motor of both hips"
            self.notes.once("torso", f"Torso goes as near to its target as it can; the feet stay, and the {what} it is")
        return found.q


class TogetherTask(Approach):
    """Joints go to values all together, none faster than a fraction of its maximum; what setPositions does."""

    def start(self, nao: VirtualNao, time: float) -> None:
        """Slow the joints so that all arrive with the one that needs longest."""
        super().start(nao, time)
        ways = np.abs(self._targets - self._at)
        ticks = float((ways / self._step).max(initial=0.0))
        if ticks > 1.0:
            self._step = ways / ticks
