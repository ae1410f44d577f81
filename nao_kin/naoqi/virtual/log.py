"""What the virtual NAO has to say: limits that clipped, joints that are late, words spoken."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

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
        now: gives robot time.
        publish: takes every `Change`.
    """

    def __init__(self, now: Callable[[], float], publish: Callable[[Change], object]) -> None:
        self._now, self._publish = now, publish
        self._lines: deque[tuple[float, str]] = deque(maxlen=_KEPT)

    @property
    def lines(self) -> list[tuple[float, str]]:
        """Robot time and text of the last thousand lines."""
        return list(self._lines)

    def write(self, message: str) -> None:
        """One more line."""
        line = " ".join(message.split())
        self._lines.append((self._now(), line))
        self.change("log", line)

    def change(self, kind: str, value: Any) -> None:
        """Tell whoever watches that something happened."""
        self._publish(Change(self._now(), kind, value))


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
