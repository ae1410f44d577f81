"""Calls that take their time, the lock that all state is behind, and the errors that scripts get."""

from __future__ import annotations

import heapq
import itertools
import logging
import math
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Collection, Hashable, Iterable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

from nao_kin.errors import BadArgument, NaoKinError
from nao_kin.naoqi.virtual.arguments import check_duration, number

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


class NaoqiError(NaoKinError):
    """What a method of a service answers where it cannot do as asked, in NAOqi's two lines.

    The text is `ALMotion::setAngles`, a line break, a tab and the reason: what NAOqi sends over the wire, and scripts
    search for names in. It is the one error of the library that is not a single line.

    Attributes:
        service: "ALMotion" …
        method: "setAngles" …
        reason: one line.

    Examples:
        >>> with nk.naoqi.VirtualNao(stepped=True) as nao:
        ...     try:
        ...         nao.call("ALMotion", "getAngles", "HeadYa", True)
        ...     except nk.naoqi.NaoqiError as error:
        ...         print(error.service, error.method)
        ALMotion getAngles
    """

    def __init__(self, service: str, method: str, reason: str) -> None:
        self.service, self.method, self.reason = service, method, " ".join(reason.split())
        Exception.__init__(self, f"{service}::{method}\n\t{self.reason}")


class Call(Future[Any]):
    """The answer of a blocking method: there when the robot has done what was asked.

    `result(timeout)`, `done()`, `add_done_callback` are those of `concurrent.futures.Future`. A call that was killed
    ends without an error, as NAOqi's do, and answers False where it tells success, else None.

    Args:
        stop: how to stop what is under way; None where nothing can.
    """

    def __init__(self, stop: Callable[[], object] | None = None) -> None:
        super().__init__()
        self._stop = stop

    def cancel(self) -> bool:
        """Stop what is under way; whether there was anything to stop."""
        if self.done():
            return False
        if self._stop is None:
            return super().cancel()
        self._stop()
        return True

    def finish(self, value: Any = None) -> None:
        """Give the answer; without effect when there is one already."""
        with suppress(InvalidStateError):
            self.set_result(value)

    def fail(self, error: BaseException) -> None:
        """Give an error for an answer; without effect when there is one already."""
        with suppress(InvalidStateError):
            self.set_exception(error)


class Monitor:
    """One lock for all state; what others must be told is told when it is free again.

    Whoever is called back may wait for another thread, which may wait for the lock. So nothing outside of the virtual
    NAO is called while it is held: `later` keeps such calls until the thread leaves the outermost `with`.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._depth = 0
        self._later: list[Callable[[], object]] = []

    def later(self, action: Callable[[], object]) -> None:
        """Do this when the lock is free again; only for a thread that holds it."""
        self._later.append(action)

    def __enter__(self) -> Monitor:
        self._lock.acquire()
        self._depth += 1
        return self

    def __exit__(self, *_: object) -> None:
        self._depth -= 1
        actions: list[Callable[[], object]] = []
        if self._depth == 0:
            actions, self._later = self._later, actions
        self._lock.release()
        for action in actions:
            try:
                action()
            except Exception:  # whoever watches must not stop the robot's time
                logging.getLogger("nao_kin.naoqi").exception("a callback of the virtual NAO failed")


# --- Robot time: counted in ticks, that follow the wall clock at some speed or are stepped by hand.

TICKS_PER_SECOND = 100
TICK = 1.0 / TICKS_PER_SECOND
# A time that misses a tick by less than this share of it, from rounding, is that tick's.
_SHARE = 1e-6
# Where the machine is busy, ticks are made up for; where it slept, robot time stands still meanwhile.
_MOST_SECONDS_BEHIND = 1.0


@dataclass(order=True)
class Timer:
    """An action to be done at a tick; `cancel` takes it back."""

    tick: int
    number: int
    action: Callable[[], None] | None = field(compare=False)

    def cancel(self) -> None:
        """Do not do it; without effect when it is done."""
        self.action = None


class Clock:
    """How far robot time has come.

    Time starts at zero and moves in ticks of 10 ms. The clock does not tick by itself: who owns it asks how many ticks
    are due, and makes them one by one.

    Args:
        speed: seconds of robot time in one second of the wall clock.

    Attributes:
        speed: as given.
        ticks: how many there were.

    Raises:
        BadArgument: a speed that is no positive number.
    """

    def __init__(self, speed: float = 1.0) -> None:
        self.speed = number(speed, "speed")
        if self.speed <= 0.0:
            raise BadArgument(f"speed must be positive, got {self.speed:g}")
        self.ticks = 0
        self._timers: list[Timer] = []
        self._numbers = itertools.count()
        self._wall_start: float | None = None
        self._made = 0
        self._rest = 0.0

    @property
    def now(self) -> float:
        """Robot time [s]."""
        return self.ticks / TICKS_PER_SECOND

    def tick(self) -> list[Callable[[], None]]:
        """One tick; returns the actions whose time has come, in order."""
        self.ticks += 1
        due = []
        while self._timers and self._timers[0].tick <= self.ticks:
            action = heapq.heappop(self._timers).action
            if action is not None:
                due.append(action)
        return due

    def after(self, seconds: float, action: Callable[[], None]) -> Timer:
        """Have `action` done at the first tick at or after so many seconds of robot time from now."""
        timer = Timer(self.ticks + max(1, math.ceil(seconds * TICKS_PER_SECOND - _SHARE)), next(self._numbers), action)
        heapq.heappush(self._timers, timer)
        return timer

    def due(self, wall: float) -> int:
        """Ticks to be made so that robot time keeps up with the wall clock.

        Args:
            wall: what the wall clock says, from any start [s].
        """
        if self._wall_start is None:
            self._wall_start = wall
        behind = (wall - self._wall_start) * self.speed * TICKS_PER_SECOND - self._made
        most = _MOST_SECONDS_BEHIND * self.speed * TICKS_PER_SECOND
        if behind > most:
            self._wall_start += (behind - most) / (self.speed * TICKS_PER_SECOND)
            behind = most
        count = max(0, math.floor(behind + _SHARE))
        self._made += count
        return count

    def step(self, seconds: float) -> int:
        """Ticks in so many seconds of robot time; what is less than a tick counts with the next step.

        Raises:
            BadArgument: seconds that are no number, negative, or more than a day.
        """
        dt = number(seconds, "a step")
        if dt < 0.0:
            raise BadArgument(f"a step must not be negative, got {dt:g} s")
        check_duration(dt, "a step")
        self._rest += dt * TICKS_PER_SECOND
        count = math.floor(self._rest + _SHARE)
        self._rest = max(0.0, self._rest - count)
        return count


# --- What the virtual NAO has to say: limits that clipped, joints that are late, words spoken.

_KEPT = 1000


@dataclass(frozen=True)
class Change:
    """Something that happened, for those who watch.

    Attributes:
        time: robot time [s].
        kind: "log", "limp", "leds", "speech", "posture", "life" …
        value: a text for "log" and for "limp", a command to joints without stiffness; else what the service that makes
            it says in its documentation.

    Examples:
        >>> seen = []
        >>> with nk.naoqi.VirtualNao(stepped=True, on_change=seen.append) as nao:
        ...     _ = nao.call("ALLeds", "fadeRGB", "FaceLeds", "red", 0.1)
        >>> "leds" in {change.kind for change in seen}
        True
    """

    time: float
    kind: str
    value: Any


class Log:
    """The last lines, newest last, and everything that happens passed on to whoever watches.

    Args:
        clock: gives robot time.
        monitor: the lock; whoever watches is told when it is free.
        watcher: takes every `Change`; None for nobody.
    """

    def __init__(self, clock: Clock, monitor: Monitor, watcher: Callable[[Change], object] | None) -> None:
        self._clock, self._monitor, self._watcher = clock, monitor, watcher
        self._lines: deque[tuple[float, str]] = deque(maxlen=_KEPT)

    @property
    def lines(self) -> list[tuple[float, str]]:
        """Robot time and text of the last thousand lines."""
        return list(self._lines)

    def write(self, message: str) -> None:
        """One more line."""
        line = " ".join(message.split())
        self._lines.append((self._clock.now, line))
        self.change("log", line)

    def change(self, kind: str, value: Any) -> None:
        """Tell whoever watches that something happened."""
        if self._watcher is not None:
            with self._monitor:
                self._monitor.later(partial(self._watcher, Change(self._clock.now, kind, value)))


class Notes:
    """The remarks on one command, each made once, however many ticks it holds for.

    Args:
        log: where they are written.
        subject: what they begin with: "setAngles (task 7)".
    """

    def __init__(self, log: Log, subject: str) -> None:
        self._log, self._subject = log, subject
        self._made: set[Hashable] = set()

    def once(self, key: Hashable, message: str) -> None:
        """Write a message, unless one with this key was written."""
        if key not in self._made:
            self._made.add(key)
            self._log.write(f"{self._subject}: {message}")

    def tell(self, kind: str, message: str) -> None:
        """Tell whoever watches of a message that is not only a line of the log."""
        self._log.change(kind, f"{self._subject}: {message}")


# --- Motion tasks: what moves joints over time, which joints each holds, and who waits for whom.


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
        task.call = Call(lambda: self.kill(task.id))
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
        with self._nao.monitor:
            task = self.find(number)
            self.kill_each([] if task is None else [task])
        return task is not None

    def kill_each(self, tasks: Iterable[Task]) -> None:
        """End tasks where they are."""
        for task in tuple(tasks):
            self._finish(task, killed=True)
        self.start_waiting()

    def kill_all(self) -> None:
        """End all tasks where they are."""
        self.kill_each((*self._waiting, *self._running))

    def kill_using(self, resources: Collection[str]) -> None:
        """End the blocking tasks that need any of these, running or waiting.

        Reactive tasks book no resources, so that as in NAOqi this does not end them.
        """
        blocking = (task for task in (*self._waiting, *self._running) if not task.reactive)
        self.kill_each(task for task in blocking if not task.resources.isdisjoint(resources))

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
