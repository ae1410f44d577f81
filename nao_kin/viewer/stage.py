"""What is on show: the newest message of every kind, kept once, whoever is or is not looking."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator


class Stage:
    """Messages by key. A newer message takes the place of the one before it, so that no history piles up.

    May be used from several threads at once.
    """

    def __init__(self) -> None:
        self._messages: dict[str, bytes] = {}
        self._lock = threading.Lock()
        self._watchers: list[Callable[[str], None]] = []

    def put(self, key: str, message: bytes) -> None:
        """Show `message`; a key keeps the place in the order that its first message had."""
        with self._lock:
            self._messages[key] = message
        for watcher in self._watchers:
            watcher(key)

    def get(self, key: str) -> bytes | None:
        """The newest message under `key`."""
        return self._messages.get(key)

    def names(self) -> tuple[str, ...]:
        """All keys, in the order in which a page must hear of them."""
        with self._lock:
            return tuple(self._messages)

    def messages(self) -> Iterator[bytes]:
        """The newest messages, in that order."""
        with self._lock:
            kept = list(self._messages.values())
        yield from kept

    def watch(self, watcher: Callable[[str], None]) -> None:
        """Call `watcher` with the key of every message put from now on, in the thread that puts it."""
        self._watchers.append(watcher)

    def unwatch(self, watcher: Callable[[str], None]) -> None:
        """Stop calling `watcher`."""
        if watcher in self._watchers:
            self._watchers.remove(watcher)
