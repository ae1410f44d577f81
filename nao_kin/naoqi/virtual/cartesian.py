"""ALMotion's Cartesian control: paths of effectors, the joint values that follow them, and the methods."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nao_kin import ik
from nao_kin._core.arrays import Floats, choice, join_poses, rigid_inverse
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.motion import Motion
from nao_kin.naoqi.conventions import (
    EFFECTORS,
    FRAME_ROBOT,
    FRAME_TORSO,
    LEFT_HIP,
    LEGS,
    RIGHT_HIP,
    TORSO,
    AxisMask,
    as_names,
    axis_mask,
    controlled_axes,
    joint_names,
    pose,
    pose_from_list,
    pose_in,
    position6d,
    robot_frame,
    space_number,
    transform_list,
)
from nao_kin.naoqi.virtual import arguments
from nao_kin.naoqi.virtual.arguments import Flag, Share, Text
from nao_kin.naoqi.virtual.engine import TICK, Call
from nao_kin.naoqi.virtual.machine import ON_TIME, AtSpeed, Machine, MotionTask
from nao_kin.naoqi.virtual.service import Service
from nao_kin.robot import NaoModel
from nao_kin.rotations import exp, log

# --- The arguments of Cartesian calls: effectors, spaces, masks, poses and times, in NAOqi's forms.

ToPoses = Callable[[Any], Floats]


@dataclass(frozen=True, eq=False)
class EffectorRequest:
    """The request for one effector."""

    effector: str
    space: int
    mask: int  # the controlled axes of the space
    poses: Floats  # of its path in the space, or changes if `relative`, shape (k, 4, 4)
    times: Floats  # of the poses, shape (k,) [s]
    relative: bool  # whether the poses are changes of the effector's initial pose


def _each(value: Any, count: int, what: str, read: Callable[[Any], int]) -> list[int]:
    """Return one number for each effector, from one number for all or a list."""
    if not arguments.is_list(value):
        return [read(value)] * count
    return [read(entry) for entry in arguments.entries(value, what, count)]


def _depth(value: Any) -> int:
    """Return the nesting depth of a list, along its first entries."""
    depth = 0
    while arguments.is_list(value):
        depth += 1
        value = value[0] if len(value) else None
    return depth


def _split(paths: Any, count: int) -> Sequence[Any]:
    """Return the path of each effector."""
    if count == 1:
        return paths if _depth(paths) == 3 and len(paths) == 1 else [paths]
    if _depth(paths) == 1:
        raise BadArgument(f"paths must be {count}, one for each effector, got one pose")
    return arguments.entries(paths, "paths", count)


def _path(path: Any, read: ToPoses, effector: str) -> Floats:
    """Return the poses of one path, shape (k, 4, 4)."""
    if _depth(path) not in (1, 2) or not len(path):
        raise BadArgument(f"the path of {effector} must be a pose or a list of poses, got {quoted(path, 60)}")
    return read(list(path)).reshape(-1, 4, 4)


def _times(times: Any, effectors: Sequence[str], rows: Sequence[Floats]) -> tuple[Floats, ...]:
    # A list of times is for all effectors; but if every effector has one pose, and the list has one time for each
    # effector, each gets its own time.
    one_each = all(len(row) == 1 for row in rows) and len(effectors) > 1
    if _depth(times) == 1 and not (one_each and len(times) == len(effectors)):
        times = [times] * len(effectors)
    times_of_each = arguments.list_each(times, effectors, "times")
    arguments.check_lengths(rows, times_of_each, effectors, "poses")
    arguments.check_times(times_of_each, effectors)
    return times_of_each


# --- The path of one effector: poses at times, and the curve through them.


class EffectorPath:
    """A curve through poses (k, 4, 4) at ascending times (k,) [s], at rest at both ends.

    x, y, z and the sum of the angles each follow the monotone cubic of `nao_kin.motion`: straight to a single target,
    and never beyond the two neighbouring keys. The rotation from key to key is about one axis (slerp).
    """

    def __init__(self, times: Sequence[float] | Floats, poses: Floats) -> None:
        self.times = np.asarray(times, dtype=np.float64)
        self._R = np.array(poses[:, :3, :3])
        self._turns = log(np.swapaxes(self._R[:-1], -1, -2) @ self._R[1:])
        angles = np.linalg.norm(self._turns, axis=-1)
        self._turned = np.concatenate([[0.0], np.cumsum(angles)])
        keys = np.column_stack([poses[:, :3, 3], self._turned])
        self._motion = Motion(self.times, ("x", "y", "z", "turn"), keys, "smooth")

    def pose(self, time: float) -> Floats:
        """Return the pose at a time, shape (4, 4)."""
        x, y, z, turned = self._motion.sample(time)
        at = int(np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, len(self._turns) - 1))
        whole = self._turned[at + 1] - self._turned[at]
        share = min(max((turned - self._turned[at]) / whole, 0.0), 1.0) if whole > 0.0 else 1.0
        return join_poses(self._R[at] @ exp(share * self._turns[at]), np.array([x, y, z]))


# --- Joint values for targets.
#
# NAOqi solves Cartesian control with the pseudo-inverse of the Jacobian of the controlled axes, from cycle to cycle.
# So does this module: damped least squares from the joint values of the cycle before. Targets that move the feet or the
# torso are solved for the whole robot on its feet (`nk.ik.whole_body`), then each other limb for itself.

# A pose in the world, and the weights of x, y, z, wx, wy, wz along the axes of a space, as in `nk.ik.whole_body`.
Target = tuple[Floats, tuple[Floats, Floats]]
Targets = dict[str, Target]

# One radian has the weight of 0.1 m.
RADIAN = 0.1
_MAX_STEPS = 60
_CONVERGED = 1e-10
# The error of a target above which the log reports it: metres, and radians times 0.1.
NOTEWORTHY = 1e-3
# The error below which two solutions are equally good [m], and the number of random starts for a target that is missed.
_MET, _STARTS = 1e-6, 6
# The weights of a foot and of a torso that must keep their poses, relative to other targets.
_HELD, _TORSO_HELD = 100.0, 10.0
# One motor drives both hips: on two feet, the torso's yaw gives way to its other coordinates.
_YAW_GIVES_WAY = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1e-3])
# The distance of the centre of mass from the edge of the support polygon [m].
_MARGIN = 0.005
# The names in the log for those of `nk.ik.whole_body`.
_NAMES = {"torso": TORSO, "com": "the centre of mass"}
# The largest number of times that targets are moved nearer so that joints are not too fast.
_MAX_HALVINGS = 7


def axis_weights(mask: int) -> Floats:
    """Return the weights of x, y, z, wx, wy, wz, 0 for those that a mask does not control, shape (6,)."""
    return np.repeat([1.0, RADIAN], 3) * controlled_axes(mask)


def descend(robot: NaoModel, name: str, target: Target, T_world_torso: Floats, q: Floats) -> tuple[Floats, float]:
    """Return joint values of one limb near q, (nq,), at its target or at a local minimum, and the norm of its errors.

    They are inside all limits. The errors are in metres, radians times `RADIAN`.
    """
    T, (weights, R) = target
    T_torso_world = rigid_inverse(T_world_torso)
    R_torso = T_torso_world[:3, :3] @ R
    return ik.descended_along(robot, name, T_torso_world @ T, R_torso, weights, _CONVERGED, _MAX_STEPS, q)


def search(robot: NaoModel, name: str, target: Target, T_world_torso: Floats, q: Floats) -> tuple[Floats, float]:
    """Return the same as `descend`; if that misses its target, the nearest solution from random values of the limb."""
    found = descend(robot, name, target, T_world_torso, q)
    if found[1] <= NOTEWORTHY:
        return found
    columns = columns_of(robot, [name])
    starts = np.tile(q, (_STARTS, 1))
    starts[:, columns] = robot.random(np.random.default_rng(0), _STARTS)[:, columns]
    others = [descend(robot, name, target, T_world_torso, robot.clamp(start)) for start in starts]
    best = min(others, key=lambda one: (max(one[1], _MET), float(np.abs(one[0] - q).max())))
    return best if best[1] < found[1] - NOTEWORTHY else found


def joints_of(robot: NaoModel, effectors: Sequence[str]) -> tuple[str, ...]:
    """Return the joints of limbs, each once, by their 26 names, without the hands."""
    return tuple(joint for joint in dict.fromkeys(joint_names(robot, effectors)) if robot.unit(joint) != "1")


def columns_of(robot: NaoModel, effectors: Sequence[str]) -> list[int]:
    """Return the columns of these joints in q; LHipYawPitch and RHipYawPitch share one."""
    names = [LEFT_HIP if joint == RIGHT_HIP else joint for joint in joints_of(robot, effectors)]
    return [robot.joint_names.index(name) for name in dict.fromkeys(names)]


# --- The motion task: effectors on timed paths.


@dataclass
class BalanceControl:
    """The constraints of whole-body control."""

    enabled: bool = False
    # "Fixed", "Plane" or "Free".
    feet: dict[str, str] = field(default_factory=lambda: dict.fromkeys(LEGS, "Fixed"))
    support: str | None = None  # "Legs", "LLeg" or "RLeg" below the centre of mass; None for no constraint


class CartesianState:
    """The commanded q, with torso, FRAME_ROBOT and feet in the world."""

    def __init__(self, nao: Machine) -> None:
        self.robot = nao.robot
        self.q = nao.joints.q(sensor=False)
        self.T_world_torso = nao.base.torso(self.q)
        self.T_world_robot = robot_frame(nao.robot, self.q, torso_in_world=self.T_world_torso)
        self.T_world_feet = self.T_world_torso @ nao.robot.fk(self.q, LEGS)

    def curve(self, request: EffectorRequest) -> EffectorPath:
        """Return the curve of a request from the current pose, in the world, or in the torso for FRAME_TORSO."""
        now = pose_in(self.robot, self.q, request.effector, request.space, torso_in_world=self.T_world_torso)
        poses = request.poses
        if request.relative:  # positions add up, and rotations are about the axes of the space
            poses = join_poses(poses[:, :3, :3] @ now[:3, :3], now[:3, 3] + poses[:, :3, 3])
        if request.effector == TORSO:
            # The coordinates of Position6D that are not controlled keep their values.
            wanted, six = position6d(poses), position6d(now)
            poses = pose(np.where(controlled_axes(request.mask), wanted, six))
        poses = np.concatenate([now[None], poses])
        T = self.T_world_robot @ poses if request.space == FRAME_ROBOT else poses
        return EffectorPath(np.concatenate([[0.0], request.times]), T)


class PathTask(MotionTask):
    """Effectors follow paths, with the whole robot if `balance` is enabled; other effectors and feet stay."""

    def __init__(self, name: str, nao: Machine, requests: Sequence[EffectorRequest], balance: BalanceControl) -> None:
        self._robot, self._balance, self._halvings = nao.robot, balance, 0
        self.requests = {request.effector: request for request in requests}
        names, self._on_feet = list(self.requests), list[str]()
        if balance.enabled:
            names = ["Joints"]
        elif TORSO in names or not set(LEGS) <= set(names):
            in_world = [one for one in names if TORSO in names or self.requests[one].space != FRAME_TORSO]
            self._on_feet = [one for one in in_world if one in (TORSO, *LEGS)]
            names = ["Legs" if one in self._on_feet else one for one in names]
        super().__init__(name, joints_of(nao.robot, names))
        self.keeps_feet = balance.enabled or not self.requests.keys().isdisjoint((TORSO, *LEGS))

    def prepare(self, nao: Machine) -> None:
        """Begin the paths at the commanded joint values, and stand on the other foot if the standing one moves."""
        moved = [effector for effector in self.requests if effector in LEGS]
        if len(moved) == 1 and nao.base.support == moved[0]:
            nao.base.stand_on(LEGS[1 - LEGS.index(moved[0])], nao.joints.q(sensor=False))
        self.initial = CartesianState(nao)
        self._paths = {effector: self.initial.curve(request) for effector, request in self.requests.items()}

    def start(self, nao: Machine, time: float) -> None:
        """Begin at the commanded joint values."""
        super().start(nao, time)
        self.prepare(nao)
        self._end = max((float(path.times[-1]) for path in self._paths.values()), default=np.inf)

    def advance(self, nao: Machine, time: float) -> bool:
        """Command the joint values for this tick."""
        q, missed = self.solve(nao, time - self.begin, nao.joints.q(sensor=False))
        for name in missed:
            self.notes.once(("missed", name), f"{name} does not reach its target; it goes as near as it can")
        nao.joints.set(self.columns, nao.robot.to_body(q)[self.columns], self.notes)
        return time - self.begin >= self._end - ON_TIME

    def solve(self, nao: Machine, time: float, q: Floats) -> tuple[Floats, list[str]]:
        """Return joint values near q for the poses at a time, (nq,), and the effectors that miss their targets."""
        state, together = self.initial, list(self.requests) if self._balance.enabled else self._on_feet
        missed: list[str] = []
        if together:
            targets = {name: self._target(name, time, state.T_world_torso) for name in together}
            in_torso = any(self.requests[name].space == FRAME_TORSO for name in together)
            if TORSO not in targets and (in_torso or not self._balance.enabled):
                # The torso would run away from a target that moves with it.
                axes = AxisMask.ALL if self._balance.enabled else AxisMask.ALL & ~AxisMask.WZ
                targets[TORSO] = state.T_world_torso, (_TORSO_HELD * axis_weights(axes), np.eye(3))
            q, missed = self.stand(nao, targets, q)
        alone = [name for name in self.requests if name not in together]
        for name in sorted(alone, key=lambda name: name not in LEGS):
            # Two legs move in the world about the torso as it was; arms and head follow the torso.
            T_world_torso = state.T_world_torso if name in LEGS else nao.base.torso(q)
            q, error = search(nao.robot, name, self._target(name, time, T_world_torso), T_world_torso, q)
            missed += [name] if error > NOTEWORTHY else []
        return q, missed

    def stand(self, nao: Machine, targets: Targets, q: Floats, com: Floats | None = None) -> tuple[Floats, list[str]]:
        """Return joint values of the whole robot for targets that can be reached in a tick, and the missed targets.

        Near the limit of the robot's reach, the solution may be far from the current joint values. The distance of the
        targets is then halved until no joint is too fast: joints that come late would let the feet slip. The next tick
        begins with twice the share of this one.
        """
        T_world_torso, fastest = nao.base.torso(q), nao.joints.max_speed[self.columns] * TICK
        above = com_above(nao.robot, q, T_world_torso)
        nearer, missed = targets, list[str]()
        for halvings in range(max(self._halvings - 1, 0), _MAX_HALVINGS):
            self._halvings, share = halvings, 0.5**halvings
            if halvings:
                now = {name: T_world_torso @ nao.robot.fk(q, name) for name in targets}
                nearer = {name: (part_of_way(now[name], T, share), weights) for name, (T, weights) in targets.items()}
            found, away = self.standing(nearer, q, None if com is None else above + share * (com - above))
            # Targets that were moved nearer count as missed.
            missed = missed or list(targets) if halvings else away
            if np.all(np.abs(nao.robot.to_body(found) - nao.robot.to_body(q))[self.columns] <= fastest):
                return found, missed
        return q, missed

    def standing(self, targets: Targets, q: Floats, com: Floats | None = None) -> tuple[Floats, list[str]]:
        """Return joint values of the whole robot on its feet, near q, (nq,), and the targets that it misses.

        A foot with a target is not fixed. `com` is the centre of mass on the floor, (2,); None for any above the
        support. If no foot stands, nothing moves.
        """
        feet, balance = dict(zip(LEGS, self.initial.T_world_feet, strict=True)), self._balance
        fixed = {foot: T for foot, T in feet.items() if foot not in targets and balance.feet[foot] != "Free"}
        standing = {balance.support: fixed[balance.support]} if com is None and balance.support in fixed else fixed
        if not fixed and not balance.enabled:  # both feet are on paths
            standing = {foot: targets[foot][0] for foot in LEGS}
            targets = {name: target for name, target in targets.items() if name not in standing}
        if not standing:
            self.notes.once("feet", "no foot stands, so nothing moves (wbFootState sets which feet stay)")
            return q, []
        held = _HELD * axis_weights(AxisMask.ALL), np.eye(3)
        rows = targets | {foot: (T, held) for foot, T in fixed.items() if foot not in standing}
        weights = {"torso" if name == TORSO else name: six for name, (_, six) in rows.items()}
        if TORSO in rows and not balance.enabled:
            weights["torso"] = weights["torso"][0] * _YAW_GIVES_WAY, weights["torso"][1]
        supported = com is None and balance.support is not None
        result = ik.whole_body(
            self._robot,
            {name: T for name, (T, _) in rows.items() if name != TORSO},
            feet={foot[0]: T for foot, T in standing.items()},
            com="support" if supported else com,
            margin=_MARGIN if supported else 0.0,
            torso=rows[TORSO][0] if TORSO in rows else None,
            weights=weights,
            near=q,
            posture=self.initial.q if balance.enabled else q,
            restarts=0,
        )
        if not np.isfinite(result.q).all():
            return q, list(targets)
        away = {name: np.hypot(way, RADIAN * turn) for name, (way, turn) in result.residuals.items()}
        return result.q, [_NAMES.get(name, name) for name in away if away[name] > NOTEWORTHY]

    def _target(self, effector: str, time: float, T_world_torso: Floats) -> Target:
        """Return the target of an effector at a time, with the torso at a pose."""
        request, T = self.requests[effector], self._paths[effector].pose(time)
        mask = AxisMask.ALL if effector == TORSO else request.mask
        R = self.initial.T_world_robot[:3, :3] if request.space == FRAME_ROBOT else np.eye(3)
        if request.space == FRAME_TORSO:
            T, R = T_world_torso @ T, T_world_torso[:3, :3]
        return T, (axis_weights(mask), R)


def com_above(robot: NaoModel, q: Floats, T_world_torso: Floats) -> Floats:
    """Return the projection of the centre of mass onto the floor, shape (2,) [m]."""
    return np.asarray((T_world_torso[:3, :3] @ robot.com(q) + T_world_torso[:3, 3])[:2])


def part_of_way(now: Floats, wanted: Floats, share: float) -> Floats:
    """Return the pose at a fraction of the path between two, shape (4, 4)."""
    R = now[:3, :3] @ exp(share * log(now[:3, :3].T @ wanted[:3, :3]))
    return join_poses(R, now[:3, 3] + share * (wanted[:3, 3] - now[:3, 3]))


# --- The methods.


def _follows(name: str) -> Callable[..., Call]:
    """Return an interpolation method; one whose name ends in s takes several effectors."""

    def method(
        self: CartesianControl,
        effectorNames: Any,
        space: Any,
        paths: Any,
        axisMasks: Any,
        times: Any,
        isAbsolute: Flag = True,
    ) -> Call:
        requests = self._requests(name, effectorNames, space, paths, axisMasks, times, relative=not isAbsolute)
        return self.nao.tasks.add(PathTask(name, self.nao, requests, self.balance))

    method.__doc__ = f"""Move effectors through {_kind(name)}s at times; returns when the last is reached.

    space and axisMasks are one value for all effectors, or a list of one for each. paths is a list of one path for
    each effector; a path is one {_kind(name)} or a list of them. For a single effector, paths may be just its path.
    times is a time or a list of times for one effector; for several, a list for each or one list for all [s]. With
    isAbsolute False, {_kind(name)}s are relative to the initial one."""
    return method


def _sends(name: str) -> Callable[..., None]:
    """Return a method that sends effectors to poses immediately; one whose name ends in s takes several effectors."""

    def method(
        self: CartesianControl, effectorNames: Any, space: Any, poses: Any, fractionMaxSpeed: Share, axisMasks: Any
    ) -> None:
        self._send(name, effectorNames, space, poses, fractionMaxSpeed, axisMasks)

    method.__doc__ = f"""Send effectors to {_kind(name)}s, at a fraction of the joints' maximum speeds, above 0.

    Returns immediately. space, poses and axisMasks are one value for all effectors, or a list of one for each. Those of
    a change are relative to the commanded ones."""
    return method


def _kind(name: str) -> str:
    return "position" if "position" in name.lower() else "transform"


class CartesianControl(Service):
    """The methods of ALMotion that move effectors by poses.

    Effectors are Head, LArm, RArm, LLeg, RLeg and Torso. A position is Position6D (x, y, z, wx, wy, wz), a transform
    its matrix row by row, 16 numbers or 12. In an axis mask, 7 is the position, 56 the rotation, 63 both.

    - Interpolations begin at the commanded pose and are at rest at both ends. FRAME_ROBOT is the one at the beginning.
    - setPositions and its relatives send the joints straight to values for the target: the path in space is not
      straight.
    - A relative target adds to the position, and rotates about the axes of the space.
    - Torso moves the legs with the feet in place. A leg in FRAME_WORLD or FRAME_ROBOT moves with the other foot and the
      torso in place. In both cases the torso's yaw is adapted if the shared hip motor requires it.
    - An unreachable target raises no error: the effector moves as near as it can, and the log says so. If a limit stops
      a limb on its path, and other joint values reach the target, the limb moves to them at its maximum speeds.
    """

    def __init__(self, nao: Machine) -> None:
        super().__init__(nao)
        self.balance = BalanceControl()

    def getPosition(self, name: Text, space: Any, useSensorValues: Flag) -> list[float]:
        """Position6D of an effector, joint, sensor or camera, from the sensors or the commands [m, rad]."""
        return [float(value) for value in position6d(self._pose(name, space, useSensorValues))]

    def getTransform(self, name: Text, space: Any, useSensorValues: Flag) -> list[float]:
        """The same pose as a 4 x 4 matrix, row by row, 16 numbers."""
        return [float(value) for value in transform_list(self._pose(name, space, useSensorValues))]

    positionInterpolation, positionInterpolations = map(_follows, ("positionInterpolation", "positionInterpolations"))
    transformInterpolation, transformInterpolations = map(
        _follows, ("transformInterpolation", "transformInterpolations")
    )
    setPosition, setPositions, changePosition = map(_sends, ("setPosition", "setPositions", "changePosition"))
    setTransform, setTransforms, changeTransform = map(_sends, ("setTransform", "setTransforms", "changeTransform"))

    # --- inside ---------------------------------------------------------------------------------------------------

    def _pose(self, name: str, space: Any, use_sensors: bool) -> Floats:
        q = self.nao.joints.q(sensor=use_sensors)
        return pose_in(self.nao.robot, q, name, space, torso_in_world=self.nao.base.torso(q))

    def _requests(
        self, name: str, names: Any, spaces: Any, paths: Any, masks: Any, times: Any, *, relative: bool
    ) -> tuple[EffectorRequest, ...]:
        """Return the requests of a method from its arguments; a method without a final s takes one effector.

        Spaces and masks are one for all effectors, or a list. `paths` has a path for each effector, a list of poses or
        one pose; `times` a time or a list for one effector, for several a list for each, or one for all; None for 1 s.
        """
        if not name.endswith("s"):
            arguments.text(names, "effectorName")
        read = pose if _kind(name) == "position" else pose_from_list
        effectors = tuple(choice(name, EFFECTORS, "effector") for name in as_names(names))
        count = len(effectors)
        if len(set(effectors)) < count:
            raise BadArgument(f"an effector is named twice: {', '.join(effectors)}")
        if not effectors:
            raise BadArgument("effectorNames must name at least one effector")
        numbers = _each(spaces, count, "spaces", space_number)
        chosen = _each(masks, count, "axis masks", axis_mask)
        rows = [_path(path, read, effector) for path, effector in zip(_split(paths, count), effectors, strict=True)]
        when = (np.ones(1),) * count if times is None else _times(times, effectors, rows)
        if (TORSO, FRAME_TORSO) in zip(effectors, numbers, strict=True):
            raise BadArgument("Torso does not move in FRAME_TORSO, the torso itself; use FRAME_WORLD or FRAME_ROBOT")
        columns = zip(effectors, numbers, chosen, rows, when, strict=True)
        return tuple(EffectorRequest(*fields, relative) for fields in columns)

    def _send(self, name: str, names: Any, spaces: Any, poses: Any, fraction: float, masks: Any) -> None:
        """Send the joints to values for the end of paths of one pose, without whole-body control."""
        requests = self._requests(name, names, spaces, poses, masks, None, relative=name.startswith("change"))
        for request in requests:
            if len(request.poses) != 1:
                raise BadArgument(f"{request.effector} must have one pose, got {len(request.poses)}")
        path = PathTask(name, self.nao, requests, BalanceControl())
        path.prepare(self.nao)
        q, missed = path.solve(self.nao, 1.0, path.initial.q)
        if missed:
            self.nao.log.write(f"{name}: {', '.join(missed)} cannot reach the target and goes as near as it can")
        targets = self.nao.robot.to_body(q)[self.nao.joints.columns(path.joints)]
        task = AtSpeed(name, self.nao, path.joints, targets, fraction, reactive=True)
        task.keeps_feet = path.keeps_feet
        self.nao.tasks.add(task)
