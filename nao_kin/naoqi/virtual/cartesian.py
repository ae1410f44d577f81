"""ALMotion's Cartesian control: paths of effectors over time, joint values that follow them, and the methods."""

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
    position6d,
    robot_frame,
    space_number,
    transform_list,
)
from nao_kin.naoqi.virtual import arguments, limb_solvers as limbs
from nao_kin.naoqi.virtual.engine import Call, Task
from nao_kin.naoqi.virtual.interpolation import ON_TIME, Approach
from nao_kin.naoqi.virtual.limb_solvers import Solution, Target
from nao_kin.naoqi.virtual.service import Service, variants
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
        read: `pose` for positions, `pose_from_list` for transforms.
        relative: the poses are changes.

    Raises:
        UnknownName: no effector or space of this name.
        BadArgument: lengths that do not fit, or what is no number, mask or space.
        WrongShape, NotFinite, NotARotation: what is no pose.
    """
    effectors = as_names(names)
    count = len(effectors)
    for name in effectors:
        if name not in EFFECTORS:
            raise UnknownName("effector", name, EFFECTORS)
    if len(set(effectors)) < count:
        raise BadArgument(f"an effector is named twice: {', '.join(effectors)}")
    if not effectors:
        raise BadArgument("effectorNames must name an effector at least")
    numbers = _each(spaces, count, "spaces", space_number)
    chosen = _each(masks, count, "axis masks", axis_mask)
    rows = [_path(path, read, effector) for path, effector in zip(_split(paths, count), effectors, strict=True)]
    when = [np.empty(0)] * count if times is None else _times(times, effectors, rows)
    for effector, space in zip(effectors, numbers, strict=True):
        if effector == "Torso" and space == FRAME_TORSO:
            raise BadArgument("Torso does not move in FRAME_TORSO, which is the torso: FRAME_WORLD or FRAME_ROBOT")
    fields = zip(effectors, numbers, chosen, rows, when, strict=True)
    return tuple(Wish(*entry, relative) for entry in fields)


def _each(value: Any, count: int, what: str, read: Callable[[Any], int]) -> list[int]:
    """One number for all, or one for each."""
    if not arguments.is_list(value):
        return [read(value)] * count
    if len(value) != count:
        raise BadArgument(f"{what} must be one for all effectors or {count}, got {len(value)}")
    return [read(entry) for entry in value]


def _depth(value: Any) -> int:
    """How many lists are inside each other, along the first entries."""
    depth = 0
    while arguments.is_list(value):
        depth += 1
        value = value[0] if len(value) else None
    return depth


def _split(paths: Any, count: int) -> Sequence[Any]:
    """The path of each effector."""
    if count == 1:
        return paths if _depth(paths) == 3 and len(paths) == 1 else [paths]
    if _depth(paths) < 2 or len(paths) != count:
        raise BadArgument(f"paths must be {count}, one for each effector, got {arguments.length(paths)}")
    return list(paths)


def _path(path: Any, read: ToPoses, effector: str) -> Floats:
    """The poses of one path, shape (k, 4, 4)."""
    if _depth(path) not in (1, 2) or not len(path):
        raise BadArgument(f"the path of {effector} must be a pose or a list of poses, got {quoted(path, 60)}")
    return read(list(path)).reshape(-1, 4, 4)


def _times(times: Any, effectors: Sequence[str], rows: Sequence[Floats]) -> list[Floats]:
    count, depth = len(effectors), _depth(times)
    if depth < 2:
        # A list of times for all, or where each has one pose and their numbers differ from that, one time for each.
        one_each = depth == 1 and len(times) == count > 1 and all(len(row) == 1 for row in rows)
        lists: list[Any] = [[time] for time in times] if one_each else [times if depth else [times]] * count
    elif depth == 2 and len(times) == count:
        lists = list(times)
    else:
        raise BadArgument(f"times must be a list for each of {count} effectors, got {len(times)}")
    found = [arguments.list_each([row], [name], "times")[0] for row, name in zip(lists, effectors, strict=True)]
    arguments.check_lengths(rows, found, effectors, "poses")
    arguments.check_times(found, effectors)
    return found


# --- The path of one effector: poses at times, and the curve through them.


class EffectorPath:
    """A curve through poses at times, at rest at both ends.

    x, y and z each go along the monotone cubic of `nao_kin.motion`: straight to a single target, and never beyond the
    keys beside it. The rotation turns from key to key about one axis (slerp); how far it has turned in all is such a
    cubic too.

    Args:
        times: of the keys, ascending, shape (k,) [s].
        poses: at these times, shape (k, 4, 4).

    Attributes:
        times: as given.
    """

    def __init__(self, times: Sequence[float] | Floats, poses: Floats) -> None:
        self.times = np.asarray(times, dtype=np.float64)
        self._R = np.array(poses[:, :3, :3])
        self._turns = log(np.swapaxes(self._R[:-1], -1, -2) @ self._R[1:])
        angles = np.linalg.norm(self._turns, axis=-1)
        self._turned = np.concatenate([[0.0], np.cumsum(angles)])
        keys = np.column_stack([poses[:, :3, 3], self._turned])
        self._motion = Motion(self.times, ("x", "y", "z", "turn"), keys, "smooth")

    def segment(self, time: float) -> int:
        """Which two keys a time lies between: 0 from the first to the second."""
        return int(np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, max(0, len(self.times) - 2)))

    def pose(self, time: float) -> Floats:
        """The pose at a time, shape (4, 4)."""
        x, y, z, turned = self._motion.sample(time)
        at, place = self.segment(time), np.array([x, y, z])
        if at >= len(self._turns):
            return join_poses(self._R[-1], place)
        whole = self._turned[at + 1] - self._turned[at]
        share = min(max((turned - self._turned[at]) / whole, 0.0), 1.0) if whole > 0.0 else 1.0
        return join_poses(self._R[at] @ exp(share * self._turns[at]), place)


# --- The motion tasks of Cartesian control: effectors along paths in time, and joints on their way to a solution.

# A path is tried out at so many places between two keys, before it is followed.
_TRIED = 8
# What is left of a target that scripts are told of: metres, and radians times 0.1.
NOTEWORTHY = 1e-3
# What is solved for before the effectors that hang on the torso.
_FIRST = (limbs.TORSO, *limbs.LEGS)


class Scene:
    """What poses of effectors mean, for a configuration and a torso in the world.

    Args:
        nao: the virtual NAO; its commands count.

    Attributes:
        q: configuration, shape (nq,).
        T_world_torso: shape (4, 4).
        T_world_robot: FRAME_ROBOT, shape (4, 4). It moves with the feet; a task takes it where it was at the beginning.
        T_world_feet: left and right, shape (2, 4, 4).
    """

    def __init__(self, nao: VirtualNao) -> None:
        self.robot = nao.robot
        self.q = nao.joints.q(sensor=False)
        self.T_world_torso = nao.base.torso(self.q)
        self.T_world_robot = robot_frame(nao.robot, self.q, torso_in_world=self.T_world_torso)
        self.T_world_feet = self.T_world_torso @ nao.robot.fk(self.q, limbs.LEGS)
        self._standing = nao.base.support

    def path(self, wish: Wish) -> Floats:
        """All poses of a wish from where the effector is now, changes added to it, shape (k + 1, 4, 4).

        They are in the world; those of FRAME_TORSO stay in the torso.
        """
        now = pose_in(self.robot, self.q, wish.effector, wish.space, torso_in_world=self.T_world_torso)
        poses = wish.poses
        if wish.relative:  # places add up, and turns are made about the axes of the space
            poses = join_poses(poses[:, :3, :3] @ now[:3, :3], now[:3, 3] + poses[:, :3, 3])
        if wish.effector == limbs.TORSO:
            poses = limbs.completed(poses, now, wish.mask)
        poses = np.concatenate([now[None], poses])
        return np.asarray(self.T_world_robot @ poses if wish.space == FRAME_ROBOT else poses)

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


def _moves_legs(wishes: Sequence[Wish]) -> bool:
    return any(wish.effector in _FIRST for wish in wishes)


def _needed_joints(nao: VirtualNao, wishes: Sequence[Wish]) -> tuple[str, ...]:
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
        self._columns = limbs.columns_of(scene.robot, [wish.effector])
        self._segment = -1
        self._straight: tuple[Floats, Floats] | None = None
        self.missing = 0.0

    def solve(self, time: float, q: Floats, T_world_torso: Floats) -> Floats:
        """The configuration at a time, from that of the tick before."""
        at = self.path.segment(time)
        begin, end = self.path.times[at : at + 2]
        if at != self._segment:
            self._segment = at
            self._look_ahead(begin, end, q, T_world_torso)
        if self._straight is None:
            return limbs.near(self._scene.robot, self._target(time, T_world_torso), q).q
        share = min(max((time - begin) / (end - begin), 0.0), 1.0)
        start, goal = self._straight
        found = q.copy()
        found[self._columns] = start + share * share * (3.0 - 2.0 * share) * (goal - start)
        return np.asarray(found)

    def _target(self, time: float, T_world_torso: Floats) -> Target:
        return self._scene.target(self.wish, self.path.pose(time), T_world_torso)

    def _look_ahead(self, begin: float, end: float, q: Floats, T_world_torso: Floats) -> None:
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
        self._joints = _needed_joints(nao, wishes)
        super().__init__(name, self._joints)
        self.keeps_feet = _moves_legs(wishes)
        self._wishes = tuple(wishes)

    def start(self, nao: VirtualNao, time: float) -> None:
        """Begin where the joints are commanded to be."""
        hold_still(nao, self._wishes)
        self._scene, self._start = Scene(nao), time
        self._columns = nao.joints.columns(self._joints)
        by_name = {wish.effector: _Limb(wish, self._scene) for wish in self._wishes}
        self._torso = by_name.pop(limbs.TORSO, None)
        self._legs = [by_name.pop(name) for name in list(by_name) if name in limbs.LEGS]
        self._others = list(by_name.values())
        self._end = max(float(wish.times[-1]) for wish in self._wishes)
        nao.joints.note_limp(self._columns, self.notes)

    def advance(self, nao: VirtualNao, time: float) -> bool:
        """Solve for this tick: torso and legs first, then what hangs on the torso."""
        t = time - self._start
        q = nao.joints.q(sensor=False)
        if self._torso is not None:
            q = self._over_feet(self._torso, t, q)
        else:
            where = self._scene.T_world_torso if len(self._legs) == 2 else nao.base.torso(q)
            for leg in self._legs:
                q = self._solved(leg, t, q, where)
        T_world_torso = nao.base.torso(q)
        for limb in self._others:
            q = self._solved(limb, t, q, T_world_torso)
        nao.joints.set(self._columns, nao.robot.to_body(q)[self._columns], self.notes)
        return t >= self._end - ON_TIME

    def _solved(self, limb: _Limb, t: float, q: Floats, T_world_torso: Floats) -> Floats:
        found = limb.solve(t, q, T_world_torso)
        if limb.missing > NOTEWORTHY:
            effector = limb.wish.effector
            self.notes.once(("missed", effector), f"{effector} does not reach its target; it goes as near as it can")
        return found

    def _over_feet(self, torso: _Limb, t: float, q: Floats) -> Floats:
        """Both legs for the torso on its path; a foot that has a path too is where that has it, the other stands."""
        feet = self._scene.T_world_feet.copy()
        for leg in self._legs:
            T = leg.path.pose(t)
            where = self._scene.T_world_torso @ T if leg.wish.space == FRAME_TORSO else T
            feet[limbs.LEGS.index(leg.wish.effector)] = where
        found = limbs.torso_over_feet(self._scene.robot, torso.path.pose(t), feet, q)
        if found.missing > NOTEWORTHY:
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


# --- The methods.

# How poses are read: positions or transforms, as the method's name says.
_FORMS: dict[str, ToPoses] = {"position": pose, "transform": pose_from_list}
# Compiled kernels of nk.ik that effectors need, by a part of their names.
_KERNELS = {
    "Arm": ("arms by pose", "arms by place"),
    "Torso": ("both legs", "projections onto limits", "damped least squares"),
}
_MOVES = ("setPosition", "setTransform", "changePosition", "changeTransform", "positionInt", "transformInt")
_ONE = "The same for one effector."
_CHANGED = "Change an effector's {0} from where it is commanded to be; else as set{1}."


@variants(
    "positionInterpolations",
    "_follow",
    positionInterpolation=("chainName space path axisMask durations", _ONE),
    transformInterpolations=("", "Move effectors through transforms at times; else as positionInterpolations."),
    transformInterpolation=("chainName space path axisMask duration", _ONE),
)
@variants(
    "setPositions",
    "_send",
    setPosition=("chainName", _ONE),
    changePosition=("effectorName space positionChange", _CHANGED.format("position", "Position")),
    setTransforms=("effectorNames space transform", "Send effectors to transforms; else as setPositions."),
    setTransform=("chainName space transform", _ONE),
    changeTransform=("chainName space transform", _CHANGED.format("transform", "Transform")),
)
class CartesianControl(Service):
    """The methods of ALMotion that move effectors by poses.

    Effectors are Head, LArm, RArm, LLeg, RLeg and Torso. A position is Position6D (x, y, z, wx, wy, wz), a transform
    its 4 x 4 matrix row by row, 16 numbers or 12. The axis mask says what counts, along the axes of the space: 7 for
    the place, 56 for the rotation, 63 for both.

    - The interpolations go from where the effector is commanded to be: to one target on a straight line, through
      several along a monotone cubic of x, y and z, turning about one axis from key to key; at rest at both ends, at
      each key in time. FRAME_ROBOT is taken where it is at the beginning.
    - setPositions and its relatives find joint values for the target and send the joints there, all arriving together,
      none faster than the fraction of its maximum speed: not on a straight line in space.
    - A relative target adds to the place, and turns about the axes of the space.
    - Torso moves the legs with the feet where they are; its yaw gives way where the one motor of both hips asks for it.
      A leg that is moved takes the other hip with it, as on the robot; in FRAME_WORLD and FRAME_ROBOT the other foot
      stays in place.
    - What is out of reach raises nothing: the effector goes as near as it can, and the log says so.
    """

    def kernels_for(self, name: str, given: tuple[Any, ...]) -> frozenset[str]:
        """Arms go by their closed form where they are set, and the torso by that of both legs."""
        named = str(given[:1]) if name.startswith(_MOVES) else ""
        needed = {kernel for part, kernels in _KERNELS.items() if part in named for kernel in kernels}
        return super().kernels_for(name, given) | needed

    def getPosition(self, name: Any, space: Any, useSensorValues: Any) -> list[float]:
        """Position6D of an effector, joint, sensor or camera [m, rad].

        Args:
            name: which.
            space: FRAME_TORSO 0, FRAME_WORLD 1, FRAME_ROBOT 2.
            useSensorValues: True for where the joints are, False for what they are commanded.
        """
        return [float(value) for value in position6d(self._pose(name, space, useSensorValues))]

    def getTransform(self, name: Any, space: Any, useSensorValues: Any) -> list[float]:
        """The same as a 4 x 4 matrix row by row, 16 numbers."""
        return [float(value) for value in transform_list(self._pose(name, space, useSensorValues))]

    def positionInterpolations(
        self, effectorNames: Any, space: Any, paths: Any, axisMasks: Any, times: Any, isAbsolute: Any = True
    ) -> Call:
        """Move effectors through positions at times; returns when the last is reached.

        Args:
            effectorNames: an effector, or a list of them.
            space: one for all, or a list of one for each.
            paths: a list of a path for each effector, a path being a list of positions or one position; of a single
                effector also its path alone.
            axisMasks: one for all, or a list of one for each.
            times: of one effector a time or a list of times, of several a list for each or one for all [s].
            isAbsolute: False for changes of where the effectors are at the beginning.
        """
        return self._follow("positionInterpolations", effectorNames, space, paths, axisMasks, times, isAbsolute)

    def setPositions(self, effectorNames: Any, space: Any, position: Any, fractionMaxSpeed: Any, axisMask: Any) -> None:
        """Send effectors to positions at a fraction of the joints' maximum speeds; returns at once.

        Args:
            effectorNames: an effector, or a list of them.
            space: one for all, or a list of one for each.
            position: a position, or a list of one for each.
            fractionMaxSpeed: above 0, at most 1.
            axisMask: one for all, or a list of one for each.
        """
        self._send("setPositions", effectorNames, space, position, fractionMaxSpeed, axisMask)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _pose(self, name: Any, space: Any, use_sensors: Any) -> Floats:
        q = self.nao.joints.q(sensor=arguments.flag(use_sensors, "useSensorValues"))
        number = space_number(space)
        return pose_in(self.nao.robot, q, arguments.text(name, "name"), number, torso_in_world=self.nao.base.torso(q))

    def _wishes(
        self, name: str, names: Any, spaces: Any, paths: Any, masks: Any, times: Any, *, relative: bool
    ) -> tuple[Wish, ...]:
        """What a method is asked for; those without an s at the end take one effector."""
        if not name.endswith("s"):
            arguments.text(names, next(iter(self._signatures[name].parameters)))
        read = next(read for form, read in _FORMS.items() if form in name.lower())
        return wishes(names, spaces, paths, masks, times, read, relative=relative)

    def _follow(
        self, name: str, names: Any, spaces: Any, paths: Any, masks: Any, times: Any, is_absolute: Any = True
    ) -> Call:
        """Have effectors follow paths: what the interpolations do."""
        relative = not arguments.flag(is_absolute, "isAbsolute")
        found = self._wishes(name, names, spaces, paths, masks, times, relative=relative)
        return self.nao.start_task(self._path_task(name, found))

    def _path_task(self, name: str, found: Sequence[Wish]) -> Task:
        """The task in which effectors follow their paths."""
        return PathTask(name, self.nao, found)

    def _send(self, name: str, names: Any, spaces: Any, poses: Any, fraction: Any, masks: Any) -> None:
        """Solve for all effectors, the torso and legs first, and send the joints there: what setPositions does."""
        found = self._wishes(name, names, spaces, poses, masks, None, relative=name.startswith("change"))
        for wish in found:
            if len(wish.poses) != 1:
                raise BadArgument(f"{wish.effector} must have one pose, got {len(wish.poses)}")
        share = arguments.fraction(fraction, "fractionMaxSpeed", positive=True)
        hold_still(self.nao, found)
        scene = Scene(self.nao)
        q, T_world_torso = scene.q, scene.T_world_torso
        missed: list[str] = []
        for wish in sorted(found, key=lambda one: (*_FIRST, one.effector).index(one.effector)):
            T = scene.path(wish)[-1]
            if wish.effector == limbs.TORSO:
                solution = limbs.torso_over_feet(self.nao.robot, T, scene.T_world_feet, q)
            else:
                solution = limbs.anywhere(self.nao.robot, scene.target(wish, T, T_world_torso), q)
            q = solution.q
            missed += [wish.effector] if solution.missing > NOTEWORTHY else []
            if wish.effector in _FIRST:
                T_world_torso = self.nao.base.torso(q)
        if missed:
            self.nao.log.write(f"{name}: {', '.join(missed)} cannot reach the target and goes as near as it can")
        joints = _needed_joints(self.nao, found)
        targets = self.nao.robot.to_body(q)[self.nao.joints.columns(joints)]
        task = TogetherTask(name, joints, targets, share)
        task.keeps_feet = _moves_legs(found)
        self.nao.start_task(task)
