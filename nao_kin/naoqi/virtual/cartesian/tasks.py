"""The motion tasks of Cartesian control: effectors along paths in time, and joints on their way to a solution."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import rigid_inverse
from nao_kin.naoqi.axis_mask import controlled_axes
from nao_kin.naoqi.spaces import FRAME_ROBOT, FRAME_TORSO, pose_in, robot_frame
from nao_kin.naoqi.virtual.cartesian import effectors as limbs
from nao_kin.naoqi.virtual.cartesian.descent import Solution, Target
from nao_kin.naoqi.virtual.cartesian.forms import Wish
from nao_kin.naoqi.virtual.cartesian.paths import EffectorPath, moved_by
from nao_kin.naoqi.virtual.interpolation import Approach
from nao_kin.naoqi.virtual.tasks import Task

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao

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
            return limbs.near(self._scene.robot, [self._target(time, T_world_torso)], q).q
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
            found = limbs.near(self._scene.robot, [target], found.q)
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
