"""Run a program that must end with the process that needs it, and remove its folder, however that process ends.

The supervisor is a separate process in its own session. It is started by path and without site packages
(`python -I -S`), which takes some 20 ms. A process that is killed (SIGKILL, the out-of-memory killer) or crashes cannot
clean up, but its end closes a pipe. Unlike the parent-death signal of Linux, this works on macOS too, and for any
thread that starts the program.

    supervisor.py FOLDER PREFIX PROGRAM ARGUMENTS…

It ends the program and its process group, and removes FOLDER, in any of three cases: standard input has a byte or is at
its end, the supervisor's parent has changed, or the program has ended. It prints one line about how the program ended.
It also removes folders next to FOLDER whose names begin with PREFIX and whose supervisor has ended.
"""

from __future__ import annotations

import fcntl
import os
import select
import shutil
import signal
import subprocess
import sys
import time
from contextlib import suppress

# This file is locked while the folder is in use; a lock ends with its process, and works across containers.
_LOCK = "in_use"
# Younger folders are not removed, because a folder is created a moment before it is locked.
_YOUNG_SECONDS = 60.0
_LOOK_SECONDS = 0.02
_KILL_SECONDS = _REMOVE_SECONDS = 0.3


def main(folder: str, prefix: str, *command: str) -> None:
    """Run the command until it ends or has to be ended, then remove the folder."""
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
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
    except OSError as error:
        _say(f"does not start: {error.strerror or error}")
    else:
        _remove_orphans(os.path.dirname(folder), prefix)
        while program.poll() is None and not asked and os.getppid() == parent:
            if select.select([sys.stdin], [], [], _LOOK_SECONDS)[0]:
                break
        else:
            _say(_end_of(program.poll()))
        kill_group(program)
    _remove(folder)
    del lock


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
    end = time.monotonic() + _REMOVE_SECONDS
    while os.path.exists(folder) and time.monotonic() < end:
        shutil.rmtree(folder, ignore_errors=True)


def _locked(path: str) -> int | None:
    """Lock a file and return its descriptor; None if another process holds the lock."""
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
