"""The 26 actuators: what they are commanded, where they are, and how stiff."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nao_kin import NaoModel
from nao_kin._common.arrays import Floats
from nao_kin.naoqi.names import chain_names
from nao_kin.naoqi.virtual.log import Notes

LEFT_HIP, RIGHT_HIP = "LHipYawPitch", "RHipYawPitch"
# Below this, a command that was clipped or a joint that is late is rounding.
_NOTEWORTHY = 1e-9


class Joints:
    """Commands, sensors and stiffnesses of NAOqi's 26 joints, in the order of "Body".

    In every tick the tasks `set` commands, and `advance` makes them the robot's:

    1. LHipYawPitch and RHipYawPitch are one motor. Where both are commanded in a tick, the left one counts, as NAOqi
       documents; where only the right one is, it moves both.
    2. The commands are clipped as `robot.clamp` does: first every joint into its box, then into its table. A joint that
       nobody commands is clipped too where its table narrows (HeadPitch when HeadYaw turns), and stays there.
    3. A joint whose stiffness is above zero goes to its command, at most at its maximum speed; one whose stiffness is
       zero stays where it is. Stiffness between 0 and 1 does not slow a joint: there is no load here.

    What was clipped or is too fast is noted once for each command and joint.

    Args:
        robot: a NAO.
        q: configuration to begin with, shape (25,).

    Attributes:
        names: the 26 names.
        column: name → place in the arrays.
        lower, upper: limits, shape (26,).
        max_speed: largest speeds, shape (26,) [rad/s, 1/s for the hands].
    """

    def __init__(self, robot: NaoModel, q: Floats) -> None:
        self.robot = robot
        self.names = robot.body_order
        self.column = {name: index for index, name in enumerate(self.names)}
        places = {name: index for index, name in enumerate(robot.joint_names)}
        self._from_q = np.array([places[LEFT_HIP if name == RIGHT_HIP else name] for name in self.names])
        self._to_q = np.array([self.column[name] for name in robot.joint_names])
        self.lower, self.upper = robot.lower[self._from_q], robot.upper[self._from_q]
        self.max_speed = robot.velocity_limits[self._from_q]
        self._left, self._right = self.column[LEFT_HIP], self.column[RIGHT_HIP]
        self._command: Floats = robot.clamp(q)[self._from_q]
        self._sensor = self._command.copy()
        self._stiffness = np.zeros(len(self.names))
        self._set: list[tuple[list[int], Floats, Notes]] = []
        self._released: list[int] = []
        self._chain = {self.column[name]: chain for chain in chain_names(robot) for name in robot.chains[chain]}
        self._told_limp: set[str] = set()

    # --- reading --------------------------------------------------------------------------------------------------

    @property
    def command(self) -> Floats:
        """What the actuators are commanded, shape (26,); a copy."""
        return np.array(self._command)

    @property
    def sensor(self) -> Floats:
        """Where the joints are, shape (26,); a copy."""
        return np.array(self._sensor)

    @property
    def stiffness(self) -> Floats:
        """Stiffnesses from 0 to 1, shape (26,); a copy."""
        return np.array(self._stiffness)

    def sensor_at(self, column: int) -> float:
        """Where one joint is."""
        return float(self._sensor[column])

    def command_at(self, column: int) -> float:
        """What one joint is commanded."""
        return float(self._command[column])

    def stiffness_at(self, column: int) -> float:
        """How stiff one joint is."""
        return float(self._stiffness[column])

    def columns(self, names: Sequence[str]) -> list[int]:
        """Places of joints in the arrays."""
        return [self.column[name] for name in names]

    def q(self, *, sensor: bool = True) -> Floats:
        """The configuration that the sensors show, or that the actuators are commanded, shape (25,)."""
        return np.array((self._sensor if sensor else self._command)[self._to_q])

    # --- commanding -----------------------------------------------------------------------------------------------

    def set(self, columns: Sequence[int], values: Floats, notes: Notes) -> None:
        """Command joints in this tick; of several commands for one joint, the last counts.

        Args:
            columns: places of the joints.
            values: one for each, not clipped.
            notes: of the command, for what must be remarked.
        """
        self._set.append((list(columns), values, notes))

    def set_q(self, q: Floats, notes: Notes) -> None:
        """Command all joints in this tick, as a configuration of shape (25,)."""
        self.set(range(len(self.names)), q[self._from_q], notes)

    def set_stiffness(self, columns: Sequence[int], values: Floats | float) -> None:
        """Set stiffnesses at once; the two HipYawPitch share a motor, and so the value set last."""
        chosen = list(columns)
        self._stiffness[chosen] = values
        self._told_limp -= {self._chain[column] for column in chosen if self._stiffness[column] > 0.0}
        if self._left in chosen:
            self._stiffness[self._right] = self._stiffness[self._left]
        elif self._right in chosen:
            self._stiffness[self._left] = self._stiffness[self._right]

    def release(self, columns: Sequence[int]) -> None:
        """Take the stiffness of joints away at the end of this tick, when they have followed its commands."""
        self._released += columns

    def hold(self) -> None:
        """Command every joint to stay where it is."""
        self._command = self._sensor.copy()

    def note_limp(self, columns: Sequence[int], notes: Notes) -> None:
        """Remark which of these joints have no stiffness, and will not move.

        Whoever watches is told too, as a change of kind "limp": at the first command to a chain that moves none of its
        joints, and at the first after the chain has had stiffness again.
        """
        limp = [self.names[column] for column in columns if self._stiffness[column] == 0.0]
        if limp:
            named = ", ".join(limp) if len(limp) <= 4 else f"{len(limp)} joints, from {limp[0]} to {limp[-1]},"
            message = f"{named} without stiffness: no movement (wakeUp or setStiffnesses gives them some)"
            notes.once("limp", message)
            stiff = {self._chain[column] for column in columns if self._stiffness[column] > 0.0}
            untold = {self._chain[column] for column in columns} - stiff - self._told_limp
            if untold:
                self._told_limp |= untold
                notes.tell("limp", message)

    def note_outside(self, columns: Sequence[int], values: Floats, notes: Notes) -> None:
        """Remark which joints will be clipped, from some of the values that they will get, (n, joints)."""
        outside = (values < self.lower[columns] - _NOTEWORTHY) | (values > self.upper[columns] + _NOTEWORTHY)
        for place in np.flatnonzero(outside.any(axis=0)).tolist():
            column = columns[place]
            name, box = self.names[column], (self.lower[column], self.upper[column])
            value = values[outside[:, place], place][0]
            notes.once(("box", name), f"{name} = {value:.6g} is clipped to [{box[0]:.6g}, {box[1]:.6g}]")

    def advance(self, dt: float) -> bool:
        """One tick: take what was set, clip it, and move the joints; whether any moved."""
        if self._set:
            self._take(dt)
        moved = self._follow(dt)
        if self._released:
            self.set_stiffness(self._released, 0.0)
            self._released.clear()
        return moved

    def _follow(self, dt: float) -> bool:
        """Move every stiff joint towards its command; whether any moved."""
        reach = np.where(self._stiffness > 0.0, self.max_speed * dt, 0.0)
        missing = self._command - self._sensor
        if not missing.any():
            return False
        near = np.abs(missing) <= reach
        before = self._sensor
        self._sensor = np.where(near, self._command, before + np.clip(missing, -reach, reach))
        return bool((self._sensor != before).any())

    def _take(self, dt: float) -> None:
        """Make what was set in this tick the command."""
        wanted = self._command.copy()
        writers: dict[int, Notes] = {}
        for columns, values, notes in self._set:
            wanted[columns] = values
            writers.update(dict.fromkeys(columns, notes))
        self._set.clear()
        if self._left in writers and self._right in writers:
            if abs(wanted[self._left] - wanted[self._right]) > _NOTEWORTHY:
                writers[self._right].once("hips", f"{LEFT_HIP} and {RIGHT_HIP} are one motor: {LEFT_HIP} counts")
        elif self._right in writers:
            wanted[self._left] = wanted[self._right]
            writers[self._left] = writers[self._right]
        wanted[self._right] = wanted[self._left]
        command: Floats = self.robot.clamp(wanted[self._to_q])[self._from_q]
        clipped = np.abs(command - wanted) > _NOTEWORTHY
        fast = np.abs(command - self._command) > self.max_speed * dt * (1.0 + _NOTEWORTHY)
        if clipped.any() or fast.any():
            self._remark(wanted, command, clipped, fast, writers, dt)
        self._command = command

    def _remark(
        self, wanted: Floats, command: Floats, clipped: Floats, fast: Floats, writers: dict[int, Notes], dt: float
    ) -> None:
        anyone = next(iter(writers.values()))
        for column in np.flatnonzero(clipped).tolist():
            name, value, limit = self.names[column], wanted[column], command[column]
            if name == RIGHT_HIP:  # the left one is the same
                continue
            notes = writers.get(column, anyone)
            if self.lower[column] - _NOTEWORTHY <= value <= self.upper[column] + _NOTEWORTHY:
                others = " and ".join(table.of for table in self.robot.coupled_limits if table.joint == name)
                notes.once(
                    ("table", name), f"{name} = {value:.6g} is clipped to {limit:.6g}: {others} narrows its range"
                )
            else:
                self.note_outside([column], np.array([[value]]), notes)
        for column in np.flatnonzero(fast).tolist():
            name = self.names[column]
            if name == RIGHT_HIP or self._stiffness[column] == 0.0:
                continue
            speed, most = abs(command[column] - self._command[column]) / dt, self.max_speed[column]
            notes = writers.get(column, anyone)
            notes.once(("fast", name), f"{name} is asked for {speed:.4g} per second, does {most:.4g}, and comes late")
