"""Programs in processes forked from one that has imported what they need: to start one takes milliseconds."""

from __future__ import annotations

import json
import os
import select
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from viewer_pages import PATIENCE

# Replies with the number of each program's process, and at its end with its exit code.
_FORKING = """
import json, os, struct, sys, traceback
{imports}
sys.stdout.flush()  # or each program would print it again
for line in sys.stdin:
    cwd, environment, code, words = json.loads(line)
    if program := os.fork():
        os.write({reply}, struct.pack("i", program))
        os.write({reply}, struct.pack("i", os.waitstatus_to_exitcode(os.waitpid(program, 0)[1])))
        continue
    os.close({reply})
    os.chdir(cwd)
    os.environ |= environment
    for stream in (0, 1, 2):
        os.dup2(os.open(os.path.join({folder!r}, str(stream)), os.O_RDWR | os.O_TRUNC), stream)
    sys.argv[1:] = words
    status = 1
    try:
        exec(code, {{"__name__": "__main__"}})
        status = 0
    except SystemExit as end:
        status = end.code
    except BaseException:
        traceback.print_exc()
    sys.stdout.flush()
    os._exit(status)  # to take down all that has been imported takes longer than the program
"""


class Forks:
    """A process from which programs are forked, one after the other."""

    def __init__(self, process: subprocess.Popen[str], reply: int, folder: Path) -> None:
        self._process, self._reply, self._folder = process, reply, folder

    def start(self, code: str, *words: str, cwd: Path, **environment: str) -> int:
        """Start a program in a folder; return the number of its process."""
        for stream in range(3):
            (self._folder / str(stream)).write_bytes(b"")
        assert self._process.stdin is not None
        print(json.dumps([str(cwd), environment, code, words]), file=self._process.stdin, flush=True)
        return self._number()

    def end(self) -> tuple[int, str, str]:
        """Wait for the end of the program; return its exit code, standard output and standard error."""
        code = self._number()
        out, err = ((self._folder / str(stream)).read_text(encoding="utf-8") for stream in (1, 2))
        return code, out, err

    def run(self, code: str, *words: str, cwd: Path, **environment: str) -> tuple[int, str, str]:
        """Run a program to its end."""
        self.start(code, *words, cwd=cwd, **environment)
        return self.end()

    def _number(self) -> int:
        assert select.select([self._reply], [], [], PATIENCE)[0], "no answer in time"
        return int(struct.unpack("i", os.read(self._reply, 4))[0])


@contextmanager
def forks(imports: str, folder: Path) -> Iterator[Forks]:
    """Yield a process that has run `imports`; what its programs print goes through files in the folder."""
    reading, reply = os.pipe()
    code = _FORKING.format(imports=imports, reply=reply, folder=str(folder))
    command = [sys.executable, "-c", code]
    with (
        open(reading, "rb", buffering=0),
        subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, pass_fds=[reply], text=True
        ) as process,
    ):
        os.close(reply)
        yield Forks(process, reading, folder)
