"""The machine of the virtual NAO: its parts, its time, and the tasks that move its joints by angles."""

from __future__ import annotations

import itertools
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from itertools import compress
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin.errors import BadArgument
from nao_kin.motion import Motion
from nao_kin.naoqi.virtual.body import Base, Joints
from nao_kin.naoqi.virtual.engine import Call, Clock, Event, EventLog, Monitor, NaoqiError, Notes
from nao_kin.robot import NaoModel

# --- Motion tasks: they move joints over time, reserve the joints that they need, and wait for each other.


class MotionTask(ABC):
    """An action that takes more than one tick.

    A blocking method reserves its resources: names of joints, or "<joint>/Stiffness". Another task that needs one of
    them waits until they are free. A *reactive* task (setAngles, changeAngles, setPositions, move) reserves nothing:
    any later task that needs its joints takes them over. Subclasses implement `advance`, and `start`, `give_up` and
    `end` if needed. All are called with the lock held.
    """

    reactive = False  # whether later tasks may take its resources
    keeps_feet = False  # whether its plan keeps the standing foot, not FRAME_ROBOT, in place

    def __init__(self, name: str, resources: Iterable[str]) -> None:
        self.name, self.joints = name, tuple(resources)
        self.resources, self.columns = frozenset(self.joints), list[int]()
        self.id = 0  # number in the task list, from 1; 0 before it is listed
        self.call = Call()  # gets the result, `value`, at the end
        self.value: object = None
        self.notes: Notes
        self.started: float | None = None  # robot time [s]; None before, when `begin` is not set either

    def start(self, nao: Machine, time: float) -> None:
        """Start the task when its resources are free: find its joints. Nothing moves before the next tick."""
        self.columns, self.begin = nao.joints.columns(self.joints), time
        nao.joints.note_limp(self.columns, self.notes)

    @abstractmethod
    def advance(self, nao: Machine, time: float) -> bool:
        """Command the joints (`nao.joints.set`) for the tick that ends at `time`; return whether the task is done."""

    def give_up(self, resources: frozenset[str]) -> None:
        """Leave some resources of a reactive task to another task, and continue with the others."""
        self.resources = self.resources - resources
        kept = [joint not in resources for joint in self.joints]
        self.joints, self.columns = tuple(compress(self.joints, kept)), list(compress(self.columns, kept))

    def end(self, nao: Machine, *, killed: bool) -> None:  # noqa: B027
        """End the task; called exactly one time, even if the task never started."""


_T = TypeVar("_T", bound=MotionTask)


class Tasks:
    """All motion tasks of a virtual NAO, in the order in which they came."""

    def __init__(self, nao: Machine) -> None:
        self._nao = nao
        self.running: list[MotionTask] = []
        self._waiting: list[MotionTask] = []
        self._numbers = itertools.count(1)

    def add(self, task: MotionTask) -> Call:
        """Start a task, or make it wait for its resources; its call ends with the task."""
        task.id = next(self._numbers)
        task.notes = Notes(self._nao.log, f"{task.name} (task {task.id})")
        task.call = Call(lambda: self.kill(lambda other: other is task))
        if task.reactive:
            self._take_over(task, [*self.running, *self._waiting])
        self._waiting.append(task)
        self.start_waiting()
        if task in self._waiting:
            task.notes.once("waits", f"waits for {', '.join(sorted(task.resources & self.booked()))}")
        return task.call

    def tick(self) -> None:
        """Advance all running tasks, and end those that are done; call `start_waiting` after the joints moved."""
        for task in list(self.running):
            if task not in self.running:  # an earlier task killed it in this tick
                continue
            try:
                done = task.advance(self._nao, self._nao.clock.now)
            except Exception as error:  # one broken task must not stop the robot's time
                self._fail(task, error)
            else:
                if done:
                    self._finish(task, killed=False)

    @property
    def all(self) -> tuple[MotionTask, ...]:
        """All tasks, waiting ones last."""
        return (*self.running, *self._waiting)

    def find(self, number: int) -> MotionTask | None:
        """The task with this id, running or waiting."""
        return next((task for task in self.all if task.id == number), None)

    def of(self, kind: type[_T]) -> _T | None:
        """Return the first task of a kind, running or waiting."""
        return next((task for task in self.all if isinstance(task, kind)), None)

    def kill(self, wanted: Callable[[MotionTask], bool] = lambda task: True) -> bool:
        """End the tasks for which `wanted` is true, waiting ones first; return whether there were any."""
        with self._nao.monitor:
            killed = [task for task in (*self._waiting, *self.running) if wanted(task)]
            for task in killed:
                self._finish(task, killed=True)
            self.start_waiting()
        return bool(killed)

    def booked(self) -> frozenset[str]:
        """Return the resources of the running blocking tasks."""
        return frozenset[str]().union(*(task.resources for task in self.running if not task.reactive))

    def start_waiting(self) -> None:
        """Start the waiting tasks, in order of arrival, whose resources no running or earlier waiting task needs."""
        taken = set(self.booked())
        for task in list(self._waiting):
            if taken.isdisjoint(task.resources):
                self._waiting.remove(task)
                self._take_over(task, [other for other in self.running if other.reactive])
                task.started = self._nao.clock.now
                self.running.append(task)
                try:
                    task.start(self._nao, task.started)
                except Exception as error:
                    self._fail(task, error)
                    continue
            if not task.reactive:
                taken |= task.resources

    def _take_over(self, task: MotionTask, others: Iterable[MotionTask]) -> None:
        """Take resources away from reactive tasks."""
        for other in others:
            shared = other.resources & task.resources
            if other.reactive and shared:
                other.give_up(shared)
                if not other.resources:
                    self._finish(other, killed=True)

    def _remove(self, task: MotionTask) -> None:
        for tasks in (self.running, self._waiting):
            if task in tasks:
                tasks.remove(task)

    def _finish(self, task: MotionTask, *, killed: bool) -> None:
        self._remove(task)
        task.end(self._nao, killed=killed)
        value = task.value
        self._nao.monitor.later(lambda: task.call.finish(value))

    def _fail(self, task: MotionTask, error: Exception) -> None:
        self._remove(task)
        with suppress(Exception):  # even a broken task may clean up
            task.end(self._nao, killed=True)
        failure = error
        if not isinstance(failure, NaoqiError):
            failure = NaoqiError("ALMotion", task.name, str(error) or repr(error))
        task.notes.once("failed", failure.reason)
        self._nao.monitor.later(lambda: task.call.fail(failure))


# --- The machine.


class Machine:
    """The parts of a virtual NAO, as its tasks and services see them; `VirtualNao` documents the arguments.

    Hold `monitor` while you read or change more than one part.

    Attributes:
        robot, monitor, clock, log, joints, base, tasks: the parts.
        behaviors: the folder of behaviours, or None.
        services: name → service.
        picture: draws what a camera sees, given its frame and (width, height), without the lock; (height, width, 3).
        stepped: whether time only advances by steps.
        ended: set when the virtual NAO is closed.
    """

    def __init__(
        self,
        robot: NaoModel,
        posture: str,
        speed: float,
        behaviors: Path | None,
        on_change: Callable[[Event], object] | None,
    ) -> None:
        self.robot, self.behaviors = robot, behaviors
        self.monitor, self.clock = Monitor(), Clock(speed)
        self.log = EventLog(self.clock, self.monitor, on_change)
        q = robot.clamp(robot.posture(posture))
        self.joints, self.base, self.tasks = Joints(robot, q), Base(robot, q, posture), Tasks(self)
        self.services: Mapping[str, Any] = {}
        self.picture: Callable[[str, tuple[int, int]], NDArray[np.uint8]]
        self.stepped = False
        self.ended = threading.Event()
        self._pending = set[Call]()

    def tick(self) -> None:
        """Advance robot time by one tick."""
        with self.monitor:
            keeps_feet = any(task.keeps_feet for task in self.tasks.running)
            before = self.joints.q()
            for action in self.clock.tick():
                try:
                    action()
                except Exception as error:  # one broken action must not stop the robot's time
                    self.log.write(f"internal error: {error!r}")
            self.tasks.tick()
            if self.joints.advance():
                self.base.update(self.joints.q(), None if keeps_feet else before)
            self.tasks.start_waiting()

    def announce(self, event: str, value: Any) -> None:
        """Raise an event of the robot in ALMemory. Needs the lock."""
        self.services["ALMemory"]._announce(event, value)

    def check_open(self) -> None:
        """Raise BadArgument if the virtual NAO is closed."""
        if self.ended.is_set():
            raise BadArgument("the virtual NAO is closed")

    def await_answer(self, call: Call) -> None:
        """Make a call fail if the virtual NAO is closed before the call is done."""
        self._pending.add(call)
        call.add_done_callback(self._pending.discard)

    def end_calls(self) -> None:
        """Make the pending calls fail, and end all tasks."""
        for call in tuple(self._pending):
            call.fail(BadArgument("the virtual NAO was closed"))
        with self.monitor:
            self.tasks.kill()


# --- Tasks that move joints: along keys in time, or towards angles at limited speed.

# The longest handle of a joint that begins with a velocity away from its next key [s].
_BRAKING = 0.1
# The rounding that a task ignores in its last tick [s].
ON_TIME = 1e-9


class Interpolation(MotionTask):
    """Joints follow a motion: angleInterpolation and its relatives.

    When the joints are free, `plan` makes their motion, from time zero, given their commanded values, shape (joints,).
    """

    def __init__(self, name: str, joints: Sequence[str], plan: Callable[[Floats], Motion]) -> None:
        super().__init__(name, joints)
        self._plan = plan

    def start(self, nao: Machine, time: float) -> None:
        """Make the motion from the commanded joint values."""
        super().start(nao, time)
        self._motion = self._plan(nao.joints.command[self.columns])
        velocity = nao.joints.velocity_left(self.columns, nao.clock.ticks)
        if velocity.any() and self._motion.interpolation != "linear":
            self._motion = _begun_moving(self._motion, velocity)
        self._end = self._motion.end
        extremes = np.array([[row.min() for row in self._motion.keys], [row.max() for row in self._motion.keys]])
        nao.joints.note_outside(self.columns, extremes, self.notes)

    def advance(self, nao: Machine, time: float) -> bool:
        """Command the motion's values at this time."""
        t = time - self.begin
        done = t >= self._end - ON_TIME
        values = self._motion.sample(self._end if done else t)
        nao.joints.set(self.columns, values[[name in self.resources for name in self._motion.joint_names]], self.notes)
        return done

    def give_up(self, resources: frozenset[str]) -> None:
        """Leave some joints to another task, and end with the last of the others."""
        super().give_up(resources)
        if self.started is not None:
            ends = zip(self._motion.joint_names, self._motion.times, strict=True)
            self._end = max((float(times[-1]) for name, times in ends if name in self.resources), default=0.0)

    def end(self, nao: Machine, *, killed: bool) -> None:
        """Note the velocity of joints whose movement is killed."""
        if killed and self.started is not None:
            velocity = self._motion.speed(nao.clock.now - self.begin)
            nao.joints.leave_moving(nao.joints.columns(self._motion.joint_names), velocity, nao.clock.ticks)


def _begun_moving(motion: Motion, velocity: Floats) -> Motion:
    """Return the motion with velocities (n,) at its beginning; joints brake before they pass their next keys, or soon.

    A joint that moves towards its next key keeps within it; any other brakes within a tenth of a second.
    """
    curves = motion.as_bezier()
    assert curves.handles is not None
    handles = [np.array(rows) for rows in curves.handles]
    for joint, speed in enumerate(velocity.tolist()):
        if speed != 0.0:
            gap, way = float(curves.times[joint][1] - curves.times[joint][0]), np.diff(curves.keys[joint][:2])[0]
            longest = way / speed if way * speed > 0.0 else _BRAKING
            length = min(gap / 3.0, longest)
            handles[joint][0, 1] = length, speed * length
    return Motion(curves.times, motion.joint_names, curves.keys, "bezier", handles)


class AtSpeed(Interpolation):
    """Joints move straight to targets, at fractions of their maximum speeds: setAngles, goToPosture and others.

    With `together`, all arrive with the slowest, after max |target − start| / (fraction · max_speed).
    """

    def __init__(
        self,
        name: str,
        nao: Machine,
        joints: Sequence[str],
        targets: Floats,
        fraction: float,
        *,
        relative: bool = False,
        together: bool = True,
        reactive: bool = False,
    ) -> None:
        columns = nao.joints.columns(joints)
        speeds = fraction * nao.joints.max_speed[columns]

        def plan(start: Floats) -> Motion:
            wanted = start + targets if relative else targets
            nao.joints.note_outside(columns, wanted[None], self.notes)
            goal = np.clip(wanted, nao.joints.lower[columns], nao.joints.upper[columns])
            durations = np.abs(goal - start) / speeds
            ends = np.broadcast_to(durations.max(), durations.shape) if together else durations
            rows = zip(start, goal, ends, strict=True)
            curves = [([a, b], [0.0, end]) if end > 0.0 else ([b], [0.0]) for a, b, end in rows]
            return Motion([times for _, times in curves], joints, [keys for keys, _ in curves])

        super().__init__(name, joints, plan)
        self.reactive = reactive


class HandMove(AtSpeed):
    """A hand opens or closes with full stiffness, and then has none: openHand and closeHand."""

    def start(self, nao: Machine, time: float) -> None:
        """Set full stiffness only now: a task that this one waited for may have removed it at its end."""
        nao.joints.set_stiffness(nao.joints.columns(self.joints), 1.0)
        super().start(nao, time)

    def end(self, nao: Machine, *, killed: bool) -> None:
        """Remove the stiffness."""
        super().end(nao, killed=killed)
        if self.started is None:
            return
        if killed:
            nao.joints.set_stiffness(self.columns, 0.0)
        else:
            nao.joints.release(self.columns)


class StiffnessRamp(MotionTask):
    """Stiffnesses follow a motion, on straight lines from key to key: stiffnessInterpolation."""

    def __init__(self, joints: Sequence[str], times: Sequence[Floats], keys: Sequence[Floats]) -> None:
        super().__init__("stiffnessInterpolation", [f"{joint}/Stiffness" for joint in joints])
        self.joints, self._times, self._keys = tuple(joints), times, keys

    def start(self, nao: Machine, time: float) -> None:
        """Begin at the current stiffnesses."""
        self.columns, self.begin = nao.joints.columns(self.joints), time
        self._motion = through(self.joints, self._times, self._keys, nao.joints.stiffness[self.columns], "linear")

    def advance(self, nao: Machine, time: float) -> bool:
        """Set the motion's values at this time."""
        done = time - self.begin >= self._motion.end - ON_TIME
        nao.joints.set_stiffness(self.columns, self._motion.sample(self._motion.end if done else time - self.begin))
        return done


def through(
    joints: Sequence[str],
    times: Sequence[Floats],
    keys: Sequence[Floats],
    start: Floats,
    kind: Literal["smooth", "linear", "bezier"] = "smooth",
    handles: Sequence[Floats] | None = None,
) -> Motion:
    """Return the motion from `start` (n,) through n lists of keys (k,) at times > 0 [s], with handles (k + 1, 2, 2)."""
    with_start = [np.concatenate([[first], row]) for first, row in zip(start, keys, strict=True)]
    return Motion([np.concatenate([[0.0], row]) for row in times], joints, with_start, kind, handles)
