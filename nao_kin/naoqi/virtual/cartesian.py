"""ALMotion's Cartesian control: paths of effectors, joint values that follow them, tasks, and the methods."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_kin import ik
from nao_kin._core.arrays import Floats, choice, eased, join_poses, rigid_inverse
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.motion import Motion
from nao_kin.naoqi.conventions import (
    ARMS,
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
from nao_kin.naoqi.virtual.engine import Call
from nao_kin.naoqi.virtual.machine import ON_TIME, Approach, Machine, MotionTask
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
    times: Floats  # of the poses, shape (k,) [s]; empty for a method without times
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


def _times(times: Any, effectors: Sequence[str], rows: Sequence[Floats]) -> list[Floats]:
    count, depth = len(effectors), _depth(times)
    if depth < 2:
        # A list of times is for all effectors; but if every effector has one pose, and the list has one time for each
        # effector, each gets its own time.
        one_each = depth == 1 and len(times) == count > 1 and all(len(row) == 1 for row in rows)
        lists: list[Any] = [[time] for time in times] if one_each else [times if depth else [times]] * count
    else:
        lists = arguments.entries(times, "times", count)
    times_of_each = [arguments.list_each([row], [name], "times")[0] for row, name in zip(lists, effectors, strict=True)]
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

    def segment(self, time: float) -> int:
        """Return the index of the key at which the segment of a time begins."""
        return int(np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, max(0, len(self.times) - 2)))

    def pose(self, time: float) -> Floats:
        """Return the pose at a time, shape (4, 4)."""
        x, y, z, turned = self._motion.sample(time)
        at, place = self.segment(time), np.array([x, y, z])
        if at >= len(self._turns):
            return join_poses(self._R[-1], place)
        whole = self._turned[at + 1] - self._turned[at]
        share = min(max((turned - self._turned[at]) / whole, 0.0), 1.0) if whole > 0.0 else 1.0
        return join_poses(self._R[at] @ exp(share * self._turns[at]), place)


# --- Joint values for targets that control some axes only.
#
# NAOqi solves Cartesian control with the pseudo-inverse of the Jacobian of the controlled axes, from cycle to cycle.
# So does this module: damped least squares from the joint values of the cycle before, which keeps joint motion along a
# path small.

# One radian has the weight of 0.1 m.
RADIAN = 0.1
_MAX_STEPS = 60
_CONVERGED = 1e-10


def axis_weights(mask: int) -> Floats:
    """Return the weights of x, y, z, wx, wy, wz, 0 for those that a mask does not control, shape (6,)."""
    return np.repeat([1.0, RADIAN], 3) * controlled_axes(mask)


@dataclass(frozen=True, eq=False)
class LimbTarget:
    """The target pose of a frame, relative to the torso or to the sole of the standing foot."""

    frame: str
    T_reference_target: Floats
    mask: int  # which of x, y, z, wx, wy, wz, along the axes of the space, are controlled
    R_reference_space: Floats
    reference: str = TORSO  # the frame that stays in place: "Torso", or a foot, whose leg then moves too


@dataclass(frozen=True, eq=False)
class LimbSolution:
    """A configuration inside the limits, shape (nq,), and the norm of its errors: metres, radians times `RADIAN`."""

    q: Floats
    missing: float


def descend(robot: NaoModel, target: LimbTarget, q: Floats) -> LimbSolution:
    """Return joint values of one limb near q, inside all limits, that bring it to its target or to a local minimum."""
    joints = tuple(robot.joint_names[column] for column in columns_of(robot, [target.frame]))
    frames, weights = (target.frame, target.reference), axis_weights(target.mask)
    T, R = target.T_reference_target, target.R_reference_space
    return LimbSolution(*ik.descended_along(robot, joints, frames, T, R, weights, _CONVERGED, _MAX_STEPS, q))


# --- The six effectors of Cartesian control, each with its joints and its solvers.

# The residual below which a target counts as reached [m].
MET = 1e-6
# The largest number of corrections of the torso's position, and the position error that ends them [m].
_MAX_CORRECTIONS, _IN_PLACE = 5, 1e-9
# The number of random starts after a descent from the current joints that misses its target.
_STARTS = 12


def joints_of(robot: NaoModel, effectors: Sequence[str]) -> tuple[str, ...]:
    """Return the joints that move effectors, each once, by their 26 names, without the hands."""
    chains = ["Legs" if effector == TORSO else effector for effector in effectors]
    return tuple(joint for joint in dict.fromkeys(joint_names(robot, chains)) if robot.unit(joint) != "1")


def columns_of(robot: NaoModel, effectors: Sequence[str]) -> list[int]:
    """Return the columns of these joints in q; LHipYawPitch and RHipYawPitch share one."""
    names = [LEFT_HIP if joint == RIGHT_HIP else joint for joint in joints_of(robot, effectors)]
    return [robot.joint_names.index(name) for name in dict.fromkeys(names)]


def anywhere(robot: NaoModel, target: LimbTarget, q: Floats) -> LimbSolution:
    """Return joint values for one limb: of the solution nearest to the current ones, or else of the nearest pose.

    Poses of arms and legs, positions of hands and orientations of the head are solved in closed form, other masks by
    descents from the current joint values and from random ones.
    """
    near = descend(robot, target, q)
    if near.missing <= MET:
        return near
    columns = columns_of(robot, [target.frame])
    starts = np.tile(q, (_STARTS, 1))
    starts[:, columns] = robot.random(np.random.default_rng(0), _STARTS)[:, columns]
    closed = _closed_form(robot, target, q)
    if closed is not None and np.isfinite(closed).all():  # a solution for the torso's current pose only
        starts[0] = closed
    if closed is not None and target.reference == TORSO:
        starts = starts[: int(np.isfinite(closed).all())]
    others = [descend(robot, target, robot.clamp(start)) for start in starts]
    reached = [one for one in others if one.missing <= MET]
    if reached:
        return min(reached, key=lambda one: float(np.abs(one.q - q).max()))
    return min(near, *others, key=lambda one: one.missing)


def torso_over_feet(robot: NaoModel, T_world_torso: Floats, T_world_feet: Floats, q: Floats) -> LimbSolution:
    """Return joint values near q for fixed poses of the left and right foot (2, 4, 4) and the nearest torso pose.

    The yaw of the torso is adapted, because one motor drives both hips. If limits exclude that pose, the torso goes to
    the nearest one for which both feet hold. `missing` is the torso's error, its yaw included; infinite if a foot does
    not reach its pose.
    """
    q_legs, adapted = _with_fitting_yaw(robot, T_world_torso, T_world_feet, q)
    if q_legs is None or not robot.within_limits(q_legs):
        # One descent with the feet as constraints.
        feet = dict(zip("LR", T_world_feet, strict=True))
        solution = ik.whole_body(robot, {}, feet=feet, torso=adapted, weights={"posture": 0.0}, near=q, restarts=0)
        if not np.isfinite(solution.q).all():
            return LimbSolution(np.array(q), np.inf)
        q_legs, adapted = solution.q, solution.torso
    turn = log(T_world_torso[:3, :3].T @ adapted[:3, :3])
    away = T_world_torso[:3, 3] - adapted[:3, 3]
    return LimbSolution(q_legs, float(np.linalg.norm([away, RADIAN * turn])))


def _with_fitting_yaw(
    robot: NaoModel, T_world_torso: Floats, T_world_feet: Floats, q: Floats
) -> tuple[Floats | None, Floats]:
    """Return joint values for both feet, regardless of limits, and the torso with the nearest yaw that fits the hips.

    If a leg is too short, return None and the torso as it is.
    """
    left, right = T_world_feet
    target = T_world_torso
    for _ in range(_MAX_CORRECTIONS):
        # A batch of one uses the compiled kernel: in Python, a tick of 10 ms would take longer than 10 ms to compute.
        solution = ik.legs(robot, left[None], right, base="floating", torso=target, free="yaw", near=q, limits="ignore")
        if not np.all(solution.success):
            return None, T_world_torso
        torso = np.asarray(solution.torso)[0]
        # The solver adapts the yaw about the middle of the hips, which displaces a leaning torso: correct its position.
        six = position6d(T_world_torso)
        six[5] = position6d(torso)[5]
        target = pose(six)
        if np.abs(target[:3, 3] - torso[:3, 3]).max() < _IN_PLACE:
            break
    return solution.q[0], torso


def _closed_form(robot: NaoModel, target: LimbTarget, q: Floats) -> Floats | None:
    T, frame, axes = target.T_reference_target, target.frame, target.mask
    if target.reference != TORSO:
        T = robot.fk(q, target.reference) @ T
    if frame in ARMS and axes in (AxisMask.ALL, AxisMask.VEL):
        return ik.arm(robot, frame[0], T if axes == AxisMask.ALL else T[:3, 3], near=q).q
    if frame in LEGS and axes == AxisMask.ALL:
        return ik.leg(robot, frame[0], T, near=q).q
    if frame == "Head" and axes in (AxisMask.ROT, AxisMask.ALL):
        return ik.head(robot, T[:3, :3], near=q).q
    return None


# --- The motion tasks of Cartesian control: effectors along timed paths, and joints moving to a solution.

# The number of points between two keys at which a path is checked before it is followed.
_CHECKED = 8
# The residual of a target above which the log reports it: metres, and radians times 0.1.
NOTEWORTHY = 1e-3
# The effectors to solve for first; the head and the arms depend on the torso.
_FIRST = (TORSO, *LEGS)


class CartesianState:
    """The commanded q with torso, FRAME_ROBOT and feet in the world; a task keeps the FRAME_ROBOT of its beginning."""

    def __init__(self, nao: Machine) -> None:
        self.robot = nao.robot
        self.q = nao.joints.q(sensor=False)
        self.T_world_torso = nao.base.torso(self.q)
        self.T_world_robot = robot_frame(nao.robot, self.q, torso_in_world=self.T_world_torso)
        self.T_world_feet = self.T_world_torso @ nao.robot.fk(self.q, LEGS)
        self._standing = nao.base.support

    def path(self, request: EffectorRequest) -> Floats:
        """Return the effector's current pose and all of a request, in the world, or in the torso for FRAME_TORSO."""
        now = pose_in(self.robot, self.q, request.effector, request.space, torso_in_world=self.T_world_torso)
        poses = request.poses
        if request.relative:  # positions add up, and rotations are about the axes of the space
            poses = join_poses(poses[:, :3, :3] @ now[:3, :3], now[:3, 3] + poses[:, :3, 3])
        if request.effector == TORSO:
            # The coordinates of Position6D that are not controlled keep their values.
            wanted, six = position6d(poses), position6d(now)
            poses = pose(np.where(controlled_axes(request.mask), wanted, six))
        poses = np.concatenate([now[None], poses])
        return np.asarray(self.T_world_robot @ poses if request.space == FRAME_ROBOT else poses)

    def curve(self, request: EffectorRequest) -> EffectorPath:
        """Return the curve of a request over its times."""
        return EffectorPath(np.concatenate([[0.0], request.times]), self.path(request))

    def target(self, request: EffectorRequest, T: Floats, T_world_torso: Floats) -> LimbTarget:
        """Return the target for the solvers from a request, a pose T as returned by `path`, and the torso's pose."""
        effector, standing, reference = request.effector, self._standing, TORSO
        R_world_space = self.T_world_robot[:3, :3] if request.space == FRAME_ROBOT else np.eye(3)
        T_reference_world = np.eye(4) if request.space == FRAME_TORSO else rigid_inverse(T_world_torso)
        if request.space != FRAME_TORSO and effector in LEGS and standing is not None and standing != effector:
            # A leg moves the hip of the other leg and so the torso: only the standing foot stays in place.
            reference = standing
            T_reference_world = rigid_inverse(self.T_world_torso @ self.robot.fk(self.q, standing))
        R = T_reference_world[:3, :3] @ R_world_space
        return LimbTarget(effector, T_reference_world @ T, request.mask, R, reference)


def hold_still(nao: Machine, requests: Sequence[EffectorRequest]) -> None:
    """Stand on the other foot if the requests move the standing foot alone."""
    moved = [request.effector for request in requests if request.effector in LEGS]
    if len(moved) == 1 and nao.base.support == moved[0]:
        nao.base.stand_on(LEGS[1 - LEGS.index(moved[0])], nao.joints.q(sensor=False))


class _LimbFollower:
    """One limb on its path, from segment to segment.

    Descents from tick to tick follow a segment. If they miss the key at its end, and other joint values reach this key,
    the joints move straight to those values instead.
    """

    def __init__(self, request: EffectorRequest, state: CartesianState) -> None:
        self.request, self._initial = request, state
        self.path = state.curve(request)
        self._columns = columns_of(state.robot, [request.effector])
        self._segment = -1
        self._straight: tuple[Floats, Floats] | None = None
        self.missing = 0.0

    def solve(self, time: float, q: Floats, T_world_torso: Floats) -> Floats:
        """Return the configuration at a time, from that of the previous tick."""
        at = self.path.segment(time)
        begin, end = self.path.times[at : at + 2]
        if at != self._segment:
            self._segment = at
            self._look_ahead(begin, end, q, T_world_torso)
        if self._straight is None:
            return descend(self._initial.robot, self._target(time, T_world_torso), q).q
        share = min(max((time - begin) / (end - begin), 0.0), 1.0)
        start, goal = self._straight
        result = q.copy()
        result[self._columns] = start + eased(share) * (goal - start)
        return np.asarray(result)

    def _target(self, time: float, T_world_torso: Floats) -> LimbTarget:
        return self._initial.target(self.request, self.path.pose(time), T_world_torso)

    def _look_ahead(self, begin: float, end: float, q: Floats, T_world_torso: Floats) -> None:
        """Follow the segment in a few steps; if that misses its key, search for other joint values that reach it."""
        solution = LimbSolution(q, 0.0)
        for time in begin + (end - begin) * np.arange(1, _CHECKED + 1) / _CHECKED:
            target = self._target(float(time), T_world_torso)
            solution = descend(self._initial.robot, target, solution.q)
        self._straight = None
        if solution.missing > MET:
            other = anywhere(self._initial.robot, target, q)
            if other.missing < solution.missing - MET:
                self._straight = q[self._columns].copy(), other.q[self._columns]
                solution = other
        self.missing = solution.missing


class PathTask(MotionTask):
    """Effectors follow paths: positionInterpolations and transformInterpolations."""

    def __init__(self, name: str, nao: Machine, requests: Sequence[EffectorRequest]) -> None:
        by_name = {request.effector: request for request in requests}
        super().__init__(name, joints_of(nao.robot, tuple(by_name)))
        self.keeps_feet = not by_name.keys().isdisjoint(_FIRST)
        self._requests = by_name

    def start(self, nao: Machine, time: float) -> None:
        """Begin at the commanded joint values."""
        super().start(nao, time)
        hold_still(nao, tuple(self._requests.values()))
        self._initial = CartesianState(nao)
        by_name = {effector: _LimbFollower(request, self._initial) for effector, request in self._requests.items()}
        self._end = max(float(limb.path.times[-1]) for limb in by_name.values())
        self._torso = by_name.pop(TORSO, None)
        self._legs = [by_name.pop(name) for name in list(by_name) if name in LEGS]
        self._others = list(by_name.values())

    def advance(self, nao: Machine, time: float) -> bool:
        """Solve for this tick: torso and legs first, then the effectors that depend on the torso."""
        t = time - self.begin
        q = nao.joints.q(sensor=False)
        if self._torso is not None:
            q = self._over_feet(self._torso, t, q)
        else:
            T_world_torso = self._initial.T_world_torso if len(self._legs) == 2 else nao.base.torso(q)
            q = self._solved(self._legs, t, q, T_world_torso)
        q = self._solved(self._others, t, q, nao.base.torso(q))
        nao.joints.set(self.columns, nao.robot.to_body(q)[self.columns], self.notes)
        return t >= self._end - ON_TIME

    def _solved(self, limbs_on_paths: Sequence[_LimbFollower], t: float, q: Floats, T_world_torso: Floats) -> Floats:
        for limb in limbs_on_paths:
            q = limb.solve(t, q, T_world_torso)
            if limb.missing > NOTEWORTHY:
                name = limb.request.effector
                self.notes.once(("missed", name), f"{name} does not reach its target; it goes as near as it can")
        return q

    def _over_feet(self, torso: _LimbFollower, t: float, q: Floats) -> Floats:
        """Solve both legs for the torso on its path; a foot with a path follows it, a foot without one stays."""
        feet = self._initial.T_world_feet.copy()
        for leg in self._legs:
            T = leg.path.pose(t)
            T_world_foot = self._initial.T_world_torso @ T if leg.request.space == FRAME_TORSO else T
            feet[LEGS.index(leg.request.effector)] = T_world_foot
        solution = torso_over_feet(self._initial.robot, torso.path.pose(t), feet, q)
        if solution.missing > NOTEWORTHY:
            limits = "feet in place, the joints' limits and the one motor of both hips"
            self.notes.once("torso", f"Torso goes as near to its target as {limits} allow")
        return solution.q


class SynchronizedApproach(Approach):
    """Joints move to values and arrive together, none faster than a fraction of its maximum speed: setPositions."""

    def start(self, nao: Machine, time: float) -> None:
        """Slow the joints down so that all arrive with the slowest."""
        super().start(nao, time)
        ways = np.abs(self._targets - self._at)
        ticks = float((ways / self._step).max(initial=0.0))
        if ticks > 1.0:
            self._step = ways / ticks


# --- The methods.


class CartesianControl(Service):
    """The methods of ALMotion that move effectors by poses.

    Effectors are Head, LArm, RArm, LLeg, RLeg and Torso. A position is Position6D (x, y, z, wx, wy, wz), a transform
    its matrix row by row, 16 numbers or 12. In an axis mask, 7 is the position, 56 the rotation, 63 both.

    - Interpolations begin at the commanded pose, reach every key at its time, and are at rest at both ends.
      FRAME_ROBOT is the one at the beginning.
    - setPositions and its relatives send the joints straight to values for the target: the path in space is not
    straight.
    - A relative target adds to the position, and rotates about the axes of the space.
    - Torso moves the legs with the feet in place; its yaw is adapted if the shared hip motor requires it. At the
      limits of joints, the torso goes to the nearest pose for which both feet stay.
      A moving leg moves the other hip too; in FRAME_WORLD and FRAME_ROBOT the other foot stays in place.
    - An unreachable target raises no error: the effector moves as near as it can, and the log says so.
    """

    def getPosition(self, name: Text, space: Any, useSensorValues: Flag) -> list[float]:
        """Position6D of an effector, joint, sensor or camera, from the sensors or the commands [m, rad]."""
        return [float(value) for value in position6d(self._pose(name, space, useSensorValues))]

    def getTransform(self, name: Text, space: Any, useSensorValues: Flag) -> list[float]:
        """The same pose as a 4 x 4 matrix, row by row, 16 numbers."""
        return [float(value) for value in transform_list(self._pose(name, space, useSensorValues))]

    def positionInterpolations(
        self, effectorNames: Any, space: Any, paths: Any, axisMasks: Any, times: Any, isAbsolute: Flag = True
    ) -> Call:
        """Move effectors through positions at times; returns when the last is reached.

        space and axisMasks are one value for all effectors, or a list of one for each. paths is a list of one path for
        each effector; a path is one position or a list of positions. For a single effector, paths may be just its path.
        times is a time or a list of times for one effector; for several, a list for each or one list for all [s]. With
        isAbsolute False, positions are relative to the initial one.
        """
        return self._follow("positionInterpolations", effectorNames, space, paths, axisMasks, times, isAbsolute)

    def positionInterpolation(
        self, chainName: Any, space: Any, path: Any, axisMask: Any, durations: Any, isAbsolute: Flag = True
    ) -> Call:
        """The same as positionInterpolations, for one effector."""
        return self._follow("positionInterpolation", chainName, space, path, axisMask, durations, isAbsolute)

    def transformInterpolations(
        self, effectorNames: Any, space: Any, paths: Any, axisMasks: Any, times: Any, isAbsolute: Flag = True
    ) -> Call:
        """The same as positionInterpolations, with transforms."""
        return self._follow("transformInterpolations", effectorNames, space, paths, axisMasks, times, isAbsolute)

    def transformInterpolation(
        self, chainName: Any, space: Any, path: Any, axisMask: Any, duration: Any, isAbsolute: Flag = True
    ) -> Call:
        """The same as transformInterpolations, for one effector."""
        return self._follow("transformInterpolation", chainName, space, path, axisMask, duration, isAbsolute)

    def setPositions(
        self, effectorNames: Any, space: Any, position: Any, fractionMaxSpeed: Share, axisMask: Any
    ) -> None:
        """Send effectors to positions at a fraction of the joints' maximum speeds, above 0; returns immediately.

        space, position and axisMask are one value for all effectors, or a list of one for each.
        """
        self._send("setPositions", effectorNames, space, position, fractionMaxSpeed, axisMask)

    def setPosition(self, chainName: Any, space: Any, position: Any, fractionMaxSpeed: Share, axisMask: Any) -> None:
        """The same as setPositions, for one effector."""
        self._send("setPosition", chainName, space, position, fractionMaxSpeed, axisMask)

    def changePosition(
        self, effectorName: Any, space: Any, positionChange: Any, fractionMaxSpeed: Share, axisMask: Any
    ) -> None:
        """Change an effector's position from its commanded one; otherwise the same as setPosition."""
        self._send("changePosition", effectorName, space, positionChange, fractionMaxSpeed, axisMask)

    def setTransforms(
        self, effectorNames: Any, space: Any, transform: Any, fractionMaxSpeed: Share, axisMask: Any
    ) -> None:
        """The same as setPositions, with transforms."""
        self._send("setTransforms", effectorNames, space, transform, fractionMaxSpeed, axisMask)

    def setTransform(self, chainName: Any, space: Any, transform: Any, fractionMaxSpeed: Share, axisMask: Any) -> None:
        """The same as setTransforms, for one effector."""
        self._send("setTransform", chainName, space, transform, fractionMaxSpeed, axisMask)

    def changeTransform(
        self, chainName: Any, space: Any, transform: Any, fractionMaxSpeed: Share, axisMask: Any
    ) -> None:
        """Change an effector's transform from its commanded one; otherwise the same as setTransform."""
        self._send("changeTransform", chainName, space, transform, fractionMaxSpeed, axisMask)

    # --- inside ---------------------------------------------------------------------------------------------------

    def _pose(self, name: str, space: Any, use_sensors: bool) -> Floats:
        q = self.nao.joints.q(sensor=use_sensors)
        return pose_in(self.nao.robot, q, name, space, torso_in_world=self.nao.base.torso(q))

    def _requests(
        self, name: str, names: Any, spaces: Any, paths: Any, masks: Any, times: Any, *, relative: bool
    ) -> tuple[EffectorRequest, ...]:
        """Return the requests of a method from its arguments; a method without a final s takes one effector.

        Spaces and masks are one for all effectors, or a list. `paths` has a path for each effector, a list of poses or
        one pose; `times` a time or a list for one effector, for several a list for each, or one for all; None without
        times.
        """
        if not name.endswith("s"):
            arguments.text(names, next(iter(self.takes[name].parameters)))
        read = pose if "position" in name.lower() else pose_from_list
        effectors = tuple(choice(name, EFFECTORS, "effector") for name in as_names(names))
        count = len(effectors)
        if len(set(effectors)) < count:
            raise BadArgument(f"an effector is named twice: {', '.join(effectors)}")
        if not effectors:
            raise BadArgument("effectorNames must name at least one effector")
        numbers = _each(spaces, count, "spaces", space_number)
        chosen = _each(masks, count, "axis masks", axis_mask)
        rows = [_path(path, read, effector) for path, effector in zip(_split(paths, count), effectors, strict=True)]
        when = [np.empty(0)] * count if times is None else _times(times, effectors, rows)
        if (TORSO, FRAME_TORSO) in zip(effectors, numbers, strict=True):
            raise BadArgument("Torso does not move in FRAME_TORSO, the torso itself; use FRAME_WORLD or FRAME_ROBOT")
        columns = zip(effectors, numbers, chosen, rows, when, strict=True)
        return tuple(EffectorRequest(*fields, relative) for fields in columns)

    def _follow(
        self, name: str, names: Any, spaces: Any, paths: Any, masks: Any, times: Any, is_absolute: bool
    ) -> Call:
        """Make effectors follow paths over time: the interpolation methods."""
        requests = self._requests(name, names, spaces, paths, masks, times, relative=not is_absolute)
        return self.nao.tasks.add(self._path_task(name, requests))

    def _path_task(self, name: str, requests: Sequence[EffectorRequest]) -> MotionTask:
        return PathTask(name, self.nao, requests)

    def _send(self, name: str, names: Any, spaces: Any, poses: Any, fraction: float, masks: Any) -> None:
        """Solve for all effectors, torso and legs first, and send the joints to the solution: setPositions etc."""
        requests = self._requests(name, names, spaces, poses, masks, None, relative=name.startswith("change"))
        for request in requests:
            if len(request.poses) != 1:
                raise BadArgument(f"{request.effector} must have one pose, got {len(request.poses)}")
        hold_still(self.nao, requests)
        state = CartesianState(self.nao)
        q, T_world_torso = state.q, state.T_world_torso
        missed: list[str] = []
        for request in sorted(requests, key=lambda one: (*_FIRST, one.effector).index(one.effector)):
            T = state.path(request)[-1]
            if request.effector == TORSO:
                solution = torso_over_feet(self.nao.robot, T, state.T_world_feet, q)
            else:
                solution = anywhere(self.nao.robot, state.target(request, T, T_world_torso), q)
            q = solution.q
            missed += [request.effector] if solution.missing > NOTEWORTHY else []
            if request.effector in _FIRST:
                T_world_torso = self.nao.base.torso(q)
        if missed:
            self.nao.log.write(f"{name}: {', '.join(missed)} cannot reach the target and goes as near as it can")
        effectors = [request.effector for request in requests]
        joints = joints_of(self.nao.robot, effectors)
        targets = self.nao.robot.to_body(q)[self.nao.joints.columns(joints)]
        task = SynchronizedApproach(name, joints, targets, fraction)
        task.keeps_feet = not set(effectors).isdisjoint(_FIRST)
        self.nao.tasks.add(task)
