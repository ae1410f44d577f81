"""Who wants to know what a page does to the robot, and how they hear of it."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable

import numpy as np

from nao_kin._common.arrays import Floats

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
