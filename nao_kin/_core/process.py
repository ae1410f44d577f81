"""Remove child processes, temporary files and folders, however the program ends.

For a signal, cleanup actions are registered here. `end_on_signals`, which only the command line calls, makes INT, TERM
and HUP run them and exit immediately. It raises no exception: an exception would be lost in an import, a destructor or
a callback from C, and the program would continue.

A process that is killed (SIGKILL, the out-of-memory killer) or crashes cannot clean up. A program that must end with it
runs under a supervisor: this file as a script, in a session of its own.
"""

from __future__ import annotations

import _thread
import os
import re
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from types import FrameType
from typing import IO, TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    import subprocess
    from pathlib import Path

_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
# Cleanup takes milliseconds; if a disk or a lock delays it, the program exits without it.
_MAX_SECONDS = 0.8
_LOOK_SECONDS = 0.1

_registered: dict[object, Callable[[], object]] = {}
_uninterrupted: set[object] = set()
_postponed: list[int] = []
_ending: list[int] = []


def end_on_signals() -> None:
    """From now on, clean up and exit with code 128 + n when signal n arrives: INT (2), TERM (15) or HUP (1).

    An ignored signal, as under nohup and in background jobs of shells, remains ignored. Call this in the main thread.
    """
    for name in _SIGNALS:
        number = getattr(signal, name, None)
        # None means a handler that Python does not know and could not restore.
        if number is not None and signal.getsignal(number) not in (signal.SIG_IGN, None):
            signal.signal(number, _answer)


def before_ending(action: Callable[[], object]) -> ExitStack:
    """Run `action` if a signal ends the program before the returned context ends; the newest action runs first."""
    key, registered = object(), ExitStack()
    _registered[key] = action
    registered.callback(_registered.pop, key, None)
    return registered


@contextmanager
def uninterrupted() -> Iterator[Callable[[], bool]]:
    """Delay signals during a few quick steps; the yielded function, for longer steps, tells whether one is waiting."""
    key = object()
    _uninterrupted.add(key)
    try:
        yield lambda: bool(_postponed)
    finally:
        _uninterrupted.discard(key)
        if _postponed and not _uninterrupted:
            _end(_postponed[0])


def wait_for_signal() -> NoReturn:
    """Wait until a signal ends the program."""
    # One long wait would miss a signal that arrives just before it or in another thread.
    while True:
        time.sleep(_LOOK_SECONDS)


def _answer(number: int, frame: FrameType | None) -> None:
    if _uninterrupted:
        _postponed.append(number)
    else:
        _end(number)


def _end(number: int) -> None:
    if _ending:
        return
    _ending.append(number)
    with suppress(RuntimeError):  # no new thread while the interpreter is exiting
        _thread.start_new_thread(_leave_anyway, (number,))
    for action in reversed(tuple(_registered.values())):
        with suppress(Exception):
            action()
    os._exit(128 + number)


def _leave_anyway(number: int) -> None:
    time.sleep(_MAX_SECONDS)
    os._exit(128 + number)


# --- Processors.


def usable_cores() -> int:
    """Return the number of cores that this process may use, which may be fewer than the machine has."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # macOS
        return os.cpu_count() or 1


# --- Browsers that can draw pictures: Chromium and Chrome.

BROWSER_VARIABLE = "NAO_KIN_BROWSER"
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge")
_MAC_BROWSERS = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
)


def find_browsers(environment: Mapping[str, str] = os.environ) -> list[Path]:
    """Return the browsers to try, in this order: the one in the variable NAO_KIN_BROWSER, or all on the path.

    Raises:
        NoBrowser: there is none.
    """
    # Imported late, because the supervisor below starts quickly and finds no packages.
    import shutil
    from pathlib import Path

    from nao_kin._core.text import quoted
    from nao_kin.errors import NoBrowser

    named = environment.get(BROWSER_VARIABLE, "")
    found: dict[Path, Path] = {}
    for name in [named] if named else [*_BROWSERS, *_MAC_BROWSERS]:
        program = shutil.which(name, path=environment.get("PATH"))
        if program is not None:
            found.setdefault(Path(program).resolve(), Path(program))
    if found:
        return list(found.values())
    if named:
        raise NoBrowser(f"{BROWSER_VARIABLE} names {quoted(named)}, which is not a program")
    raise NoBrowser(
        f"a picture needs Chromium or Chrome, and none was found: install one (Debian: apt install chromium) "
        f"or name it in {BROWSER_VARIABLE}"
    )


# --- The supervisor runs a program that must end with the process that needs it, and removes its folder.
#
# It is started by path and without site packages (`python -I -S`), which takes some 25 ms. The end of the process that
# needs the program closes a pipe. Unlike the parent-death signal of Linux, this works on macOS too, and for any thread
# that starts the program.
#
#     process.py FOLDER PREFIX PROGRAM ARGUMENTS…
#
# It ends the program and its process group, and removes FOLDER, in any of three cases: standard input has a byte or is
# at its end, the supervisor's parent has changed, or the program has ended. It prints one line about how the program
# ended, and the last line that the program wrote to standard error. It also removes folders next to FOLDER whose names
# begin with PREFIX and whose supervisor has ended.

# This file is locked while the folder is in use; a lock ends with its process, and works across containers.
_LOCK = "in_use"
# Younger folders are not removed, because a folder is created a moment before it is locked.
_YOUNG_SECONDS = 60.0
_POLL_SECONDS = 0.02
_KILL_SECONDS = _REMOVE_SECONDS = 0.3
_TAIL_BYTES = 4096


def main(folder: str, prefix: str, *command: str) -> None:
    """Run the command until it ends or has to be ended, then remove the folder."""
    import subprocess

    parent = os.getppid()
    asked: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, frame: asked.append(number))
    lock = _locked(os.path.join(folder, _LOCK))
    try:
        program = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
            bufsize=0,
        )
    except OSError as error:
        _say(f"does not start: {error.strerror or error}")
    else:
        _remove_orphans(os.path.dirname(folder), prefix)
        errors = _Tail(program.stderr)
        while program.poll() is None and not asked and os.getppid() == parent:
            if sys.stdin in errors.read(_POLL_SECONDS, sys.stdin):
                break
        else:
            while errors.stream in errors.read(0.0):
                pass
            _say(f"{_end_of(program.poll())}\n{errors.last_line()}")
        kill_group(program)
    _remove(folder)
    del lock


class _Tail:
    """The end of what a program writes to its standard error."""

    def __init__(self, stream: IO[bytes] | None) -> None:
        self.stream, self._bytes = stream, b""

    def read(self, seconds: float, *others: IO[Any]) -> list[Any]:
        """Wait until the program has written, or one of other streams can be read; return the streams with news."""
        ready = select.select([*others, *filter(None, [self.stream])], [], [], seconds)[0]
        if self.stream is not None and self.stream in ready:
            news = os.read(self.stream.fileno(), _TAIL_BYTES)
            self._bytes = (self._bytes + news)[-_TAIL_BYTES:]
            if not news:
                self.stream = None
        return ready

    def last_line(self) -> str:
        """Return the last fatal error of Chromium, or the last line, without the place in its source."""
        lines = [line for line in self._bytes.decode("utf-8", "replace").splitlines() if line.strip()]
        fatal = [line for line in lines if ":FATAL:" in line]
        return re.sub(r"^\[[^\]]*\]\s*", "", (fatal or lines or [""])[-1]).strip()


def _say(line: str) -> None:
    with suppress(OSError):  # no reader is left
        os.write(1, line.encode())


def _end_of(code: int | None) -> str:
    if code is None:
        return "was told to end"
    if code >= 0:
        return f"ended with exit code {code}"
    with suppress(ValueError):  # real-time signals have no names
        return f"was ended by {signal.Signals(-code).name}"
    return f"was ended by signal {-code}"


def kill_group(program: subprocess.Popen[bytes] | subprocess.Popen[str]) -> None:
    """Kill the program and its process group; wait for a moment until they are gone."""
    end = time.monotonic() + _KILL_SECONDS
    with suppress(OSError):  # no such group any more
        while time.monotonic() < end:
            os.killpg(program.pid, signal.SIGKILL)
            program.poll()
            time.sleep(0.005)


def _remove(folder: str) -> None:
    """Remove a folder to which a program that was just killed may still be writing."""
    import shutil

    end = time.monotonic() + _REMOVE_SECONDS
    while os.path.exists(folder) and time.monotonic() < end:
        shutil.rmtree(folder, ignore_errors=True)


def _locked(path: str) -> int | None:
    """Lock a file and return its descriptor; None if another process holds the lock."""
    import fcntl

    with suppress(OSError):
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(descriptor)
            raise
        return descriptor
    return None


def _remove_orphans(parent: str, prefix: str) -> None:
    """Remove folders left behind when a program and its supervisor were killed together."""
    import shutil

    with suppress(OSError), os.scandir(parent) as entries:
        for entry in entries:
            if not entry.name.startswith(prefix) or not entry.is_dir(follow_symlinks=False):
                continue
            with suppress(OSError):
                state = entry.stat(follow_symlinks=False)
                if state.st_uid != os.geteuid() or time.time() - state.st_mtime < _YOUNG_SECONDS:
                    continue
                descriptor = _locked(os.path.join(entry.path, _LOCK))
                if descriptor is not None:
                    shutil.rmtree(entry.path, ignore_errors=True)
                    os.close(descriptor)


if __name__ == "__main__":
    main(*sys.argv[1:])
