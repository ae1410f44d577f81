"""What moves the robot of a viewer: which page says where it is, who is told, and what is warned of."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.warn import warn_caller
from nao_kin.errors import NaoKinWarning
from nao_kin.robot import RobotModel

# --- Which page says where a motion is that is played.

# A page that plays says where it is up to thirty times a second. One that is silent for so long [s] leads no more: it
# has ended or is gone, for even a browser that is busy with another page is heard sooner.
_SILENCE = 3.0


class Lead:
    """Who leads: of several pages that play at once, each at a time of its own, only one is listened to.

    It is the page in which somebody began to play, or went to a time, last; before anybody did, the one that was heard
    first. Who moves the robot otherwise leads too, so that what a page has sent before it stopped is not taken for new.
    """

    def __init__(self) -> None:
        self._source = ""
        self._heard = -_SILENCE
        self._lock = threading.Lock()

    def take(self, source: str) -> None:
        """Let this page lead, or the program, ""."""
        with self._lock:
            self._source, self._heard = source, time.monotonic()

    def release(self) -> None:
        """Let nobody lead."""
        with self._lock:
            self._heard = -_SILENCE

    def admits(self, source: str, *, begins: bool) -> bool:
        """Whether to listen to a page that plays.

        Args:
            source: who it is.
            begins: whether somebody has just begun to play in it, or gone to a time.
        """
        with self._lock:
            now = time.monotonic()
            if not begins and source != self._source and now - self._heard < _SILENCE:
                return False
            self._source, self._heard = source, now
            return True


# --- Who wants to know what a page does to the robot, and how they hear of it.

# Called with the configuration and the names of the joints that changed.
ChangeCallback = Callable[[Floats, tuple[str, ...]], object]

_LOG = logging.getLogger(__name__)


class Subscription:
    """A callback that is called until `remove`."""

    def __init__(self, callback: ChangeCallback, changes: Changes) -> None:
        self.callback = callback
        self._changes = changes

    def remove(self) -> None:
        """Call it no more; does nothing the second time. A call under way ends by itself."""
        self._changes.remove(self)


class Changes:
    """Tells callbacks of changes, one at a time and in their order, in a thread of its own.

    The thread lives while there is something to tell. What happens while callbacks run is told in one when they have
    ended: the newest configuration, and every joint that changed. So a slow callback holds up neither the server nor
    the page, and nothing piles up.
    """

    def __init__(self) -> None:
        self._subscriptions: list[Subscription] = []
        self._pending: tuple[Floats, dict[str, None]] | None = None
        self._running = False
        self._lock = threading.Lock()

    def add(self, callback: ChangeCallback) -> Subscription:
        """Call `callback` from now on."""
        subscription = Subscription(callback, self)
        with self._lock:
            self._subscriptions.append(subscription)
        return subscription

    def remove(self, subscription: Subscription) -> None:
        """Call it no more."""
        with self._lock:
            if subscription in self._subscriptions:
                self._subscriptions.remove(subscription)

    def tell(self, q: Floats, joints: tuple[str, ...]) -> None:
        """Say that the configuration is q now, after these joints changed."""
        with self._lock:
            if not self._subscriptions:
                return
            before = self._pending[1] if self._pending is not None else {}
            self._pending = np.array(q), before | dict.fromkeys(joints)
            if self._running:
                return
            self._running = True
        threading.Thread(target=self._run, name="nao_kin viewer changes", daemon=True).start()

    def _run(self) -> None:
        while True:
            with self._lock:
                pending, self._pending = self._pending, None
                subscriptions = tuple(self._subscriptions)
                if pending is None:
                    self._running = False
                    return
            q, joints = pending
            for subscription in subscriptions:
                if subscription not in self._subscriptions:  # removed by the one before it, or meanwhile
                    continue
                try:
                    subscription.callback(q.copy(), tuple(joints))
                except BaseException:  # whatever a caller's function raises, sys.exit() too, is the caller's
                    _LOG.exception("a callback of viewer.on_change failed")


# --- Warnings of joints that are shown outside their limits.


class OutsideLimitsWarning(NaoKinWarning):
    """A configuration on show has joints outside their limits, and not because nobody moved them from zero.

    Examples:
        >>> issubclass(nk.viewer.OutsideLimitsWarning, nk.errors.NaoKinWarning)
        True
    """


class OutsideWarnings:
    """Warns of each joint of a robot once."""

    def __init__(self, robot: RobotModel) -> None:
        self._robot = robot
        self._warned: set[str] = set()

    def check(self, qs: Floats) -> None:
        """Warn of the joints that are outside in one configuration, shape (nq,), or in several, shape (n, nq)."""
        if qs.ndim > 1:
            qs = qs[_first_outside(self._robot, qs)]
        violations = self._robot.limit_violations(qs)
        found = dict.fromkeys(row.joint for row in violations if row.value != 0.0 or row.of_value != 0.0)
        new = [joint for joint in found if joint not in self._warned]
        self._warned.update(new)
        if new:
            warn_caller(f"outside the joint limits, shown in red: {', '.join(new)}", OutsideLimitsWarning)


def _first_outside(robot: RobotModel, qs: Floats) -> list[int]:
    """Of a clip, the first configuration in which each joint is outside its limits and not because all is at zero.

    A clip that runs outside of them for minutes has a violation in every frame, and they say no more than these.
    """
    outside = ~robot.within_limits(qs, per_joint=True)
    values = qs[:, robot.nq - len(robot.joint_names) :]
    moved = outside & (values != 0.0)
    for table in robot.coupled_limits:
        joint, of = robot.joint_names.index(table.joint), robot.joint_names.index(table.of)
        if robot.lower[joint] <= 0.0 <= robot.upper[joint]:  # else the box refuses zero, whatever the table says
            moved[:, joint] |= outside[:, joint] & (values[:, of] != 0.0)
    return sorted({int(column.argmax()) for column in moved.T if column.any()})
