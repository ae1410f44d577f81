"""Motion tasks: what moves joints over time, which joints each holds, and who waits for whom."""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable
from contextlib import suppress
from typing import TYPE_CHECKING

from nao_kin.naoqi.virtual.calls import Call, NaoqiError
from nao_kin.naoqi.virtual.log import Notes

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


class Task(ABC):
    """Something that takes more than one tick.

    A blocking method books its resources: names of joints, or "<joint>/Stiffness". Another task that needs one of them
    waits until they are free. A *reactive* task (setAngles, changeAngles, setPositions, move) books nothing: any later
    task that needs its joints takes them from it.

    Subclasses implement `advance`, and where needed `start`, `give_up` and `end`. All are called with the lock held.

    Args:
        name: NAOqi's method, "angleInterpolation".
        resources: what it needs.

    Attributes:
        reactive: whether later tasks may take its resources.
        keeps_feet: whether it plans with the standing foot in place. Where no task does, FRAME_ROBOT stays while both
            soles are down.
        id: number in the task list, from 1; 0 before it is there.
        call: the answer, given at the end.
        value: what the call answers at the end.
        notes: for remarks that are to be made once.
        started: robot time at which its resources were free [s]; None before.
    """

    reactive = False
    keeps_feet = False

    def __init__(self, name: str, resources: Iterable[str]) -> None:
        self.name = name
        self.resources = frozenset(resources)
        self.id = 0
        self.call = Call()
        self.value: object = None
        self.notes: Notes
        self.started: float | None = None

    def start(self, nao: VirtualNao, time: float) -> None:  # noqa: B027
        """The resources are free: note where the joints are. Nothing moves before the next tick."""

    @abstractmethod
    def advance(self, nao: VirtualNao, time: float) -> bool:
        """Command the joints (`nao.joints.set`) for this tick, that ends at `time`; whether the task is done."""

    def give_up(self, resources: frozenset[str]) -> None:
        """A reactive task loses some of its resources to another task; those left it keeps moving."""
        self.resources = self.resources - resources

    def end(self, nao: VirtualNao, *, killed: bool) -> None:  # noqa: B027
        """The task is over; called once, whether it started or not."""


class Tasks:
    """All motion tasks, in the order in which they came.

    Args:
        nao: the virtual NAO whose joints they move.
    """

    def __init__(self, nao: VirtualNao) -> None:
        self._nao = nao
        self._running: list[Task] = []
        self._waiting: list[Task] = []
        self._numbers = itertools.count(1)

    def add(self, task: Task) -> Call:
        """Start a task, or have it wait for its resources; its call ends when it does."""
        task.id = next(self._numbers)
        task.notes = Notes(self._nao.log, f"{task.name} (task {task.id})")
        task.call = Call(lambda: self.cancel(task))
        if task.reactive:
            self._take_over(task, [*self._running, *self._waiting])
        self._waiting.append(task)
        self.start_waiting()
        if task in self._waiting:
            task.notes.once("waits", f"waits for {', '.join(sorted(task.resources & self._booked()))}")
        return task.call

    def tick(self) -> None:
        """Advance all that run, and end what is done; `start_waiting` is for when the joints have moved."""
        for task in list(self._running):
            if task not in self._running:  # an earlier one of this tick killed it
                continue
            try:
                done = task.advance(self._nao, self._nao.clock.now)
            except Exception as error:  # one broken task must not stop the robot's time
                self._fail(task, error)
            else:
                if done:
                    self._finish(task, killed=False)

    def listing(self) -> list[list[object]]:
        """NAOqi's task list: [name, id] of each, those that wait last."""
        return [[task.name, task.id] for task in self.all]

    @property
    def all(self) -> tuple[Task, ...]:
        """All tasks, those that wait last."""
        return (*self._running, *self._waiting)

    @property
    def running(self) -> tuple[Task, ...]:
        """The tasks that move joints now."""
        return tuple(self._running)

    def find(self, number: int) -> Task | None:
        """The task with this id, running or waiting."""
        return next((task for task in self.all if task.id == number), None)

    def available(self, resources: Collection[str]) -> bool:
        """Whether no blocking task that runs has booked any of these."""
        return self._booked().isdisjoint(resources)

    def kill(self, number: int) -> bool:
        """End a task where it is; whether there was one with this id."""
        task = self.find(number)
        if task is not None:
            self._finish(task, killed=True)
            self.start_waiting()
        return task is not None

    def kill_all(self) -> None:
        """End all tasks where they are."""
        for task in (*self._waiting, *self._running):
            self._finish(task, killed=True)

    def kill_using(self, resources: Collection[str]) -> None:
        """End the blocking tasks that need any of these, running or waiting.

        Reactive tasks book no resources, so that as in NAOqi this does not end them.
        """
        for task in (*self._waiting, *self._running):
            if not task.reactive and not task.resources.isdisjoint(resources):
                self._finish(task, killed=True)
        self.start_waiting()

    def cancel(self, task: Task) -> None:
        """End a task from outside of the lock."""
        with self._nao.monitor:
            if task in self._running or task in self._waiting:
                self._finish(task, killed=True)
                self.start_waiting()

    def _booked(self) -> frozenset[str]:
        return frozenset[str]().union(*(task.resources for task in self._running if not task.reactive))

    def start_waiting(self) -> None:
        """Start every task, first come first, whose resources neither a running task nor an earlier one needs."""
        taken = set(self._booked())
        for task in list(self._waiting):
            if taken.isdisjoint(task.resources):
                self._waiting.remove(task)
                self._take_over(task, [other for other in self._running if other.reactive])
                task.started = self._nao.clock.now
                self._running.append(task)
                try:
                    task.start(self._nao, task.started)
                except Exception as error:
                    self._fail(task, error)
                    continue
            if not task.reactive:
                taken |= task.resources

    def _take_over(self, task: Task, others: Iterable[Task]) -> None:
        """Take resources away from reactive tasks."""
        for other in others:
            shared = other.resources & task.resources
            if other.reactive and shared:
                other.give_up(shared)
                if not other.resources:
                    self._finish(other, killed=True)

    def _remove(self, task: Task) -> None:
        for tasks in (self._running, self._waiting):
            if task in tasks:
                tasks.remove(task)

    def _finish(self, task: Task, *, killed: bool) -> None:
        self._remove(task)
        task.end(self._nao, killed=killed)
        value = task.value
        self._nao.monitor.later(lambda: task.call.finish(value))

    def _fail(self, task: Task, error: Exception) -> None:
        self._remove(task)
        with suppress(Exception):  # it is broken, and gets its chance to tidy
            task.end(self._nao, killed=True)
        failure = (
            error if isinstance(error, NaoqiError) else NaoqiError("ALMotion", task.name, str(error) or repr(error))
        )
        task.notes.once("failed", failure.reason)
        self._nao.monitor.later(lambda: task.call.fail(failure))
