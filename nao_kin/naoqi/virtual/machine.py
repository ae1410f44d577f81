"""The machine of the virtual NAO: its parts, its time, and the tasks that move its joints."""

from __future__ import annotations

import itertools
import threading
import time as wall
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from itertools import compress
from pathlib import Path
from typing import Any, TypeVar

from nao_kin.errors import BadArgument
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
        ended: set when the virtual NAO is closed.
        held: how many blocks stop robot time.
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
        self.ended, self.held = threading.Event(), 0
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

    @contextmanager
    def time_held(self) -> Iterator[None]:
        """Stop robot time inside the block, if it runs by itself; it does not catch up afterwards."""
        with self.monitor:
            self.held += 1
        try:
            yield
        finally:
            with self.monitor:
                self.clock.due(wall.monotonic())
                self.held -= 1

    def after(self, seconds: float) -> Call:
        """Return a call that ends after some seconds of robot time, or when it is cancelled. Needs the lock."""

        def stop() -> None:
            timer.cancel()
            call.finish()

        call = Call(stop)
        timer = self.clock.after(seconds, lambda: self.monitor.later(call.finish))
        return call

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
