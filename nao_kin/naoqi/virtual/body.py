"""The body of the virtual NAO: its 26 actuators, its pose in the world, and its masses."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import LOWER, Floats, join_poses, rigid_inverse
from nao_kin.errors import BadArgument
from nao_kin.naoqi.conventions import LEFT_HIP, LEGS, RIGHT_HIP, TORSO, chain_names, joint_names, robot_frame
from nao_kin.naoqi.virtual.engine import TICK, Notes
from nao_kin.robot import NaoModel
from nao_kin.rotations import rot_z, rotation_between
from nao_kin.world import feet_frame, standing_sole

# The difference below which a clipped command or a late joint counts as rounding.
_NOTEWORTHY = 1e-9


class Joints:
    """Commands, sensors and stiffnesses of NAOqi's 26 joints, in the order of "Body".

    In every tick the tasks `set` commands, and `advance` applies them:

    1. LHipYawPitch and RHipYawPitch share one motor. If both are commanded in a tick, the left command is used, as
       NAOqi documents; a command for the right one alone moves both.
    2. Commands are clipped as `robot.clamp` does. A joint without a command is clipped too, and stays there, if another
       joint narrows its range (HeadPitch when HeadYaw turns).
    3. A joint with stiffness moves to its command at most at its maximum speed; without stiffness it stays.

    A command that is clipped or too fast is noted in the log, one line for each command and joint.
    """

    def __init__(self, robot: NaoModel, q: Floats) -> None:
        self.robot = robot
        self.names = robot.body_order
        self.column = {name: index for index, name in enumerate(self.names)}
        places = {name: index for index, name in enumerate(robot.joint_names)}
        self._from_q = np.array([places[LEFT_HIP if name == RIGHT_HIP else name] for name in self.names])
        self._to_q = np.array([self.column[name] for name in robot.joint_names])
        self.lower, self.upper = robot.lower[self._from_q], robot.upper[self._from_q]
        self.max_speed = robot.velocity_limits[self._from_q]  # [rad/s, 1/s for the hands]
        self._left, self._right = self.column[LEFT_HIP], self.column[RIGHT_HIP]
        self._command: Floats = robot.clamp(q)[self._from_q]
        self._sensor = self._command.copy()
        self._stiffness = np.zeros(len(self.names))
        self._set: list[tuple[list[int], Floats, Notes]] = []
        self._released: list[int] = []
        self._left_moving: dict[int, tuple[float, int]] = {}  # velocity and tick of joints whose task was killed
        self._chain = {self.column[name]: chain for chain in chain_names(robot) for name in robot.chains[chain]}
        self._reported_limp: set[str] = set()

    # --- reading --------------------------------------------------------------------------------------------------

    @property
    def command(self) -> Floats:
        """The commanded joint values, shape (26,); a copy."""
        return np.array(self._command)

    @property
    def sensor(self) -> Floats:
        """The measured joint values, shape (26,); a copy."""
        return np.array(self._sensor)

    @property
    def stiffness(self) -> Floats:
        """Stiffnesses from 0 to 1, shape (26,); a copy."""
        return np.array(self._stiffness)

    def columns(self, names: Sequence[str]) -> list[int]:
        """Return the indices of joints in the arrays."""
        return [self.column[name] for name in names]

    def q(self, *, sensor: bool = True) -> Floats:
        """Return the measured or the commanded configuration, shape (25,)."""
        return np.array((self._sensor if sensor else self._command)[self._to_q])

    # --- commanding -----------------------------------------------------------------------------------------------

    def set(self, columns: Sequence[int], values: Floats, notes: Notes) -> None:
        """Command joints in this tick, with values that are not clipped yet; the last command for a joint is used."""
        self._set.append((list(columns), values, notes))

    def set_stiffness(self, columns: Sequence[int], values: Floats | float) -> None:
        """Set stiffnesses immediately; the two HipYawPitch share a motor, so the last value applies to both."""
        chosen = list(columns)
        self._stiffness[chosen] = values
        self._reported_limp -= {self._chain[column] for column in chosen if self._stiffness[column] > 0.0}
        if self._left in chosen:
            self._stiffness[self._right] = self._stiffness[self._left]
        elif self._right in chosen:
            self._stiffness[self._left] = self._stiffness[self._right]

    def release(self, columns: Sequence[int]) -> None:
        """Remove the stiffness of joints at the end of this tick, after they have followed its commands."""
        self._released += columns

    def leave_moving(self, columns: Sequence[int], velocity: Floats, tick: int) -> None:
        """Note the velocities of joints whose movement ends before it is done, in a tick [rad/s]."""
        self._left_moving = {column: (float(speed), tick) for column, speed in zip(columns, velocity, strict=True)}

    def velocity_left(self, columns: Sequence[int], tick: int) -> Floats:
        """Return the velocities of joints whose movement ended before it was done in this tick, else 0 [rad/s]."""
        left = [self._left_moving.get(column, (0.0, tick)) for column in columns]
        return np.array([speed if ended == tick else 0.0 for speed, ended in left])

    def hold(self) -> None:
        """Command every joint to stay at its measured value."""
        self._command = self._sensor.copy()

    def note_limp(self, columns: Sequence[int], notes: Notes) -> None:
        """Note joints without stiffness; notify the watcher once per chain, and again after it has had stiffness."""
        limp = [self.names[column] for column in columns if self._stiffness[column] == 0.0]
        if limp:
            named = ", ".join(limp) if len(limp) <= 4 else f"{len(limp)} joints, from {limp[0]} to {limp[-1]},"
            message = f"{named} without stiffness: no movement (call wakeUp or setStiffnesses)"
            notes.once("limp", message)
            stiff = {self._chain[column] for column in columns if self._stiffness[column] > 0.0}
            unreported = {self._chain[column] for column in columns} - stiff - self._reported_limp
            if unreported:
                self._reported_limp |= unreported
                notes.notify("limp", message)

    def note_outside(self, columns: Sequence[int], values: Floats, notes: Notes) -> None:
        """Note the joints whose future values will be clipped; `values` are some of these, shape (n, joints)."""
        outside = (values < self.lower[columns] - _NOTEWORTHY) | (values > self.upper[columns] + _NOTEWORTHY)
        for place in np.flatnonzero(outside.any(axis=0)).tolist():
            column, value = columns[place], values[outside[:, place], place][0]
            name, box = self.names[column], f"[{self.lower[column]:.6g}, {self.upper[column]:.6g}]"
            notes.once(("box", name), f"{name} = {value:.6g} is clipped to {box}")

    def advance(self) -> bool:
        """Make one tick: apply and clip the commands, move every stiff joint; return whether any moved."""
        if self._set:
            self._apply()
        before, way = self._sensor, self._command - self._sensor
        if way.any():
            reach = np.where(self._stiffness > 0.0, self.max_speed * TICK, 0.0)
            self._sensor = np.where(np.abs(way) <= reach, self._command, before + np.clip(way, -reach, reach))
        if self._released:
            self.set_stiffness(self._released, 0.0)
            self._released.clear()
        return bool((self._sensor != before).any())

    def _apply(self) -> None:
        """Apply the commands of this tick."""
        wanted = self._command.copy()
        writers: dict[int, Notes] = {}
        for columns, values, notes in self._set:
            wanted[columns] = values
            writers.update(dict.fromkeys(columns, notes))
        self._set.clear()
        if self._left in writers and self._right in writers:
            if abs(wanted[self._left] - wanted[self._right]) > _NOTEWORTHY:
                writers[self._right].once("hips", f"{LEFT_HIP} and {RIGHT_HIP} share one motor: {LEFT_HIP} is used")
        elif self._right in writers:
            wanted[self._left] = wanted[self._right]
            writers[self._left] = writers[self._right]
        wanted[self._right] = wanted[self._left]
        command: Floats = self.robot.clamp(wanted[self._to_q])[self._from_q]
        self._remark(wanted, command, writers)
        self._command = command

    def _remark(self, wanted: Floats, command: Floats, writers: dict[int, Notes]) -> None:
        """Note the commands that were clipped or are too fast for their joints; LHipYawPitch stands for both hips."""
        default = next(iter(writers.values()))
        clipped = np.abs(command - wanted) > _NOTEWORTHY
        speed = np.abs(command - self._command) / TICK
        fast = (speed > self.max_speed * (1.0 + _NOTEWORTHY)) & (self._stiffness > 0.0)
        clipped[self._right] = fast[self._right] = False
        for column in np.flatnonzero(clipped).tolist():
            name, value, notes = self.names[column], wanted[column], writers.get(column, default)
            if self.lower[column] - _NOTEWORTHY <= value <= self.upper[column] + _NOTEWORTHY:
                others = " and ".join(table.of for table in self.robot.coupled_limits if table.joint == name)
                limit = f"{command[column]:.6g}: {others} narrows its range"
                notes.once(("table", name), f"{name} = {value:.6g} is clipped to {limit}")
            else:
                self.note_outside([column], np.array([[value]]), notes)
        for column in np.flatnonzero(fast).tolist():
            limits = f"{speed[column]:.4g} per second, moves at {self.max_speed[column]:.4g}"
            notes, name = writers.get(column, default), self.names[column]
            notes.once(("fast", name), f"{name} would need {limits}, and comes late")


# --- The torso in the world while the joints move: one sole stays on the floor, or the robot rests on it.


class Base:
    """The torso's pose in the world: kinematics only, without weight or balance.

    When the robot is on its feet, one sole is flat on the floor z = 0, initially the left one. If the other sole is
    lower by more than 1 mm, that foot becomes the standing foot: its sole is put flat, with its current position and
    yaw. If the feet are so inclined to each other that each is the lower one when the other is flat, the standing foot
    does not change. A walk sets the standing foot itself (`stand_on`). The standing sole stays in place while the other
    one is lifted, and during tasks with `MotionTask.keeps_feet`. Otherwise both soles slide equally, and FRAME_ROBOT
    between them stays in place.

    In a posture on the floor (Sit, LyingBack …) the posture defines the vertical in the torso's frame, and the torso
    turns until it points up, gradually during a movement; its x, y and yaw in the world do not change. When the robot
    stands again, FRAME_ROBOT is where it last stood. The world's
    origin is on the floor below the initial FRAME_ROBOT, and its x axis along that of FRAME_ROBOT.
    """

    def __init__(self, robot: NaoModel, q: Floats, posture: str | None = None) -> None:
        self._robot = robot
        # The standing foot, "LLeg" or "RLeg"; None if the robot rests on the floor.
        self.support: str | None = None
        self._T_world_sole = np.eye(4)
        self._place, self._yaw, self._R_world_torso = np.zeros(2), 0.0, np.eye(3)
        self._T_world_stood: Floats | None = None  # FRAME_ROBOT when the robot last stood
        up = None if posture is None else robot.semantics.postures[posture].up
        if up is None:
            self.stand_on(self.standing_foot(q), q)
            T_world_robot = self._robot_frame(q)
            T_world_robot[2, 3] = 0.0
            self._T_world_sole = rigid_inverse(T_world_robot) @ self._T_world_sole
        else:
            self.rest(up, q)

    def torso(self, q: Floats) -> Floats:
        """Return T_world_torso in a configuration, for the current support; shape (4, 4)."""
        if self.support is not None:
            T_torso_sole = self._robot.fk(q, self.support)
            return np.asarray(self._T_world_sole @ rigid_inverse(T_torso_sole))
        height = self._robot.set_down(q, gravity=-self._R_world_torso[2]).T_world_base[2, 3]
        return join_poses(self._R_world_torso, np.append(self._place, height))

    def update(self, q: Floats, before: Floats | None = None) -> None:
        """Change the standing foot if the other sole is lower after the joints have moved.

        With `before`, the configuration before the movement, FRAME_ROBOT stays in place while both soles are down; with
        None, the standing sole stays in place.
        """
        if self.support is None:
            return
        T_torso_soles = self._robot.fk(q[None] if before is None else np.stack([before, q]), LEGS)
        if before is not None and np.array_equal(*T_torso_soles):
            return  # the legs did not move
        own = LEGS.index(self.support)
        foot, T_sole_torso = LEGS[standing_sole(T_torso_soles[-1], own)], rigid_inverse(T_torso_soles[:, own])
        height = (T_sole_torso @ T_torso_soles[:, 1 - own])[:, 2, 3]  # of the other sole
        if foot != self.support:
            self.stand_on(foot, q)
        elif before is not None and (height <= LOWER).all():  # both are down
            T_world_torso = self._T_world_sole @ T_sole_torso
            T_world_before, T_world_robot = feet_frame(T_world_torso[:, None] @ T_torso_soles)
            self._move(T_world_before @ rigid_inverse(T_world_robot))

    def check_stands(self) -> None:
        """Refuse a robot that does not stand on its feet."""
        if self.support is None:
            raise BadArgument("the robot does not stand on its feet; call goToPosture first")

    def stand_on(self, foot: str, q: Floats) -> None:
        """Stand on a foot, "LLeg" or "RLeg", put flat on the floor at its pose in a configuration."""
        T_world_foot = feet_frame((self.torso(q) @ self._robot.fk(q, foot))[None])
        T_world_foot[2, 3] = 0.0
        self.support, self._T_world_sole = foot, T_world_foot

    def stand_up(self, foot: str, q: Floats) -> None:
        """Stand on a foot after a rest on the floor, with FRAME_ROBOT where the robot last stood."""
        self.stand_on(foot, q)
        if self._T_world_stood is not None:
            self._move(self._T_world_stood @ rigid_inverse(self._robot_frame(q)))

    def _robot_frame(self, q: Floats) -> Floats:
        return robot_frame(self._robot, q, torso_in_world=self.torso(q))

    def _move(self, change: Floats) -> None:
        """Move the standing foot along the floor by the change of FRAME_ROBOT's pose in the world."""
        change[2, 3] = 0.0
        self._T_world_sole = change @ self._T_world_sole

    def rest(self, up: Floats | tuple[float, float, float], q: Floats) -> None:
        """Rest on the floor with the vertical `up`, shape (3,), in the torso's frame."""
        if self.support is not None:
            before, self._T_world_stood = self.torso(q), self._robot_frame(q)
            # The torso's rotation is the smallest rotation that makes its vertical upright, followed by the yaw.
            level = before[:3, :3] @ _upright(before[2, :3]).T
            self._place, self._yaw = before[:2, 3].copy(), math.atan2(level[1, 0], level[0, 0])
        self.support = None
        self._R_world_torso = rot_z(self._yaw) @ _upright(up)

    def vertical(self, q: Floats) -> Floats:
        """The world's vertical in the torso's frame, as an accelerometer at rest measures it; shape (3,)."""
        return np.array(self.torso(q)[2, :3])

    def is_down(self, foot: str, q: Floats) -> bool:
        """Return whether the robot stands on its feet with this sole on the floor, to a millimetre."""
        return self.support is not None and bool((self.torso(q) @ self._robot.fk(q, foot))[2, 3] <= LOWER)

    def standing_foot(self, q: Floats, before: str = LEGS[0]) -> str:
        """Return the standing foot: `before`, unless the other foot is lower in the frames of both soles."""
        return LEGS[standing_sole(self._robot.fk(q, LEGS), LEGS.index(before))]


def _upright(up: ArrayLike) -> Floats:
    """Return the smallest rotation that makes `up` the z axis, shape (3, 3); about y if up points down."""
    return rotation_between(up, [0.0, 0.0, 1.0], axis=[0.0, 1.0, 0.0])


# --- Masses and centres of mass of the robot's parts, for getMass and getCOM.

WHOLE = ("Body", "Joints", "Com")


def mass_and_com(robot: NaoModel, q: ArrayLike, name: str) -> tuple[float, Floats]:
    """Return a part's mass [kg] and centre of mass in the torso's frame, shape (3,) [m]; without mass, the origin.

    The name of a joint means the segment that it moves, that of a chain or group the segments of all its joints.
    """
    if name in WHOLE:
        return robot.mass, np.array(robot.com(q))
    total, moment = 0.0, np.zeros(3)
    for part in (TORSO,) if name == TORSO else joint_names(robot, name):
        inertia = robot.model.inertias[0 if part == TORSO else robot.model.getJointId(part)]
        T_torso_segment = robot.fk(q, part)
        total += inertia.mass
        moment += inertia.mass * (T_torso_segment[:3, :3] @ inertia.lever + T_torso_segment[:3, 3])
    return float(total), moment / total if total > 0.0 else np.zeros(3)
