"""Which page says where a motion is that is played."""

from __future__ import annotations

import threading
import time

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
