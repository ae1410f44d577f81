"""The robot's movements in a viewer: which page reports them, the callbacks, and the warnings."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from functools import partial

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.warn import warn_caller
from nao_kin.errors import NaoKinWarning
from nao_kin.robot import RobotModel

# --- The page whose playback is followed.

# A playing page reports up to thirty times a second. After this time without a report [s] it loses the lead; even a
# busy browser reports sooner.
_SILENCE = 3.0


class Lead:
    """The page whose playback is followed if several play at once; callers hold the viewer's lock.

    It is the page in which a user last began to play or moved the time, or else the first page that reported. A change
    of the robot by other means also takes the lead, so that outdated reports of a page are ignored.
    """

    def __init__(self) -> None:
        self._source = ""
        self._heard = -_SILENCE

    def take(self, source: str) -> None:
        """Give the lead to this page, or to the program, ""."""
        self._source, self._heard = source, time.monotonic()

    def release(self) -> None:
        """Give the lead to no page."""
        self._heard = -_SILENCE

    def admits(self, source: str, *, begins: bool) -> bool:
        """Return whether to follow a playing page; `begins`: whether its user just began to play or moved the time."""
        if not begins and source != self._source and time.monotonic() - self._heard < _SILENCE:
            return False
        self.take(source)
        return True


# --- Callbacks on changes by a page.

# Called with the configuration and the names of the joints that changed.
ChangeCallback = Callable[[Floats, tuple[str, ...]], object]

_LOG = logging.getLogger(__name__)


class Subscription:
    """A callback that is called until `remove`."""

    def __init__(self, callback: ChangeCallback, changes: Changes) -> None:
        self.callback = callback
        self._changes = changes

    def remove(self) -> None:
        """End the calls; a running call completes. Does nothing the second time."""
        self._changes.remove(self)


class Changes:
    """Calls callbacks on changes, one at a time and in order, in a separate thread.

    Changes during a call are combined into one: the newest configuration, and every joint that changed; the newest
    place of each target. A slow callback therefore delays neither the server nor the page, and no queue grows.
    """

    def __init__(self) -> None:
        self._subscriptions: list[Subscription] = []
        self._pending: tuple[Floats, dict[str, None]] | None = None
        self._calls: dict[object, Callable[[], object]] = {}
        self._running = False
        self._lock = threading.Lock()

    def add(self, callback: ChangeCallback) -> Subscription:
        """Call `callback` from now on."""
        subscription = Subscription(callback, self)
        with self._lock:
            self._subscriptions.append(subscription)
        return subscription

    def remove(self, subscription: Subscription) -> None:
        """End the calls of a subscription."""
        with self._lock:
            if subscription in self._subscriptions:
                self._subscriptions.remove(subscription)

    def tell(self, q: Floats, joints: tuple[str, ...]) -> None:
        """Report that the configuration is q now, after these joints changed."""
        with self._lock:
            if not self._subscriptions:
                return
            before = self._pending[1] if self._pending is not None else {}
            self._pending = np.array(q), before | dict.fromkeys(joints)
            self._start()

    def call(self, key: object, function: Callable[[], object]) -> None:
        """Schedule one call of a function; it replaces a function that still waits under the same key."""
        with self._lock:
            self._calls[key] = function
            self._start()

    def _start(self) -> None:
        if not self._running:
            self._running = True
            threading.Thread(target=self._run, name="nao_kin viewer changes", daemon=True).start()

    def _run(self) -> None:
        while True:
            with self._lock:
                pending, self._pending = self._pending, None
                calls, self._calls = self._calls, {}
                subscriptions = tuple(self._subscriptions)
                if pending is None and not calls:
                    self._running = False
                    return
            for function in calls.values():
                _guarded(function, "on_move of a target")
            if pending is None:
                continue
            q, joints = pending
            for subscription in subscriptions:
                if subscription in self._subscriptions:  # unless it was removed meanwhile
                    _guarded(partial(subscription.callback, q.copy(), tuple(joints)), "viewer.on_change")


def _guarded(function: Callable[[], object], what: str) -> None:
    try:
        function()
    except BaseException:  # a failing function, even with sys.exit(), must not end the calls
        _LOG.exception("a callback of %s failed", what)


# --- Warnings of joints that are shown outside their limits.


class OutsideLimitsWarning(NaoKinWarning):
    """A displayed configuration has joints outside their limits, other than joints at zero.

    Examples:
        >>> issubclass(nk.viewer.OutsideLimitsWarning, nk.errors.NaoKinWarning)
        True
    """


def warn_outside(robot: RobotModel, qs: Floats, warned: set[str]) -> None:
    """Warn of joints outside their limits in (nq,) or (n, nq), unless they are in `warned`, and add them to it."""
    if qs.ndim > 1:
        qs = qs[_first_outside(robot, qs)]
    violations = robot.limit_violations(qs)
    found = dict.fromkeys(row.joint for row in violations if row.value != 0.0 or row.of_value != 0.0)
    new = [joint for joint in found if joint not in warned]
    warned.update(new)
    if new:
        warn_caller(f"outside the joint limits, shown in red: {', '.join(new)}", OutsideLimitsWarning)


def _first_outside(robot: RobotModel, qs: Floats) -> list[int]:
    """Return, for each joint, the first configuration of a clip in which it is outside its limits, except at zero."""
    outside = ~robot.within_limits(qs, per_joint=True)
    values = qs[:, robot.nq_base :]
    moved = outside & (values != 0.0)
    for table in robot.coupled_limits:
        joint, of = robot.joint_names.index(table.joint), robot.joint_names.index(table.of)
        if robot.lower[joint] <= 0.0 <= robot.upper[joint]:  # otherwise its own range excludes zero
            moved[:, joint] |= outside[:, joint] & (values[:, of] != 0.0)
    return sorted({int(column.argmax()) for column in moved.T if column.any()})
