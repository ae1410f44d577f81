"""Calls that take their time, the lock that all state is behind, and the errors that scripts get."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from types import TracebackType
from typing import Any

from nao_kin.errors import NaoKinError


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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
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
