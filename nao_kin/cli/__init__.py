"""The command line: one thin command per capability."""

from __future__ import annotations

import atexit
import importlib
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn

from nao_kin._core.process import end_on_signals

__all__ = [
    "main",
]


# The commands that talk to NAOqi.
_WITH_QI = ("serve", "run", "live")


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the program and exit.

    Exit codes: 0 for success, 1 if a check failed, 2 for bad input; 129, 130 and 143 after the signals HUP, INT and
    TERM.

    Args:
        arguments: the words after the program's name; those of this process by default.

    Examples:
        >>> nk.cli.main(["fk", "--posture", "Stand", "--frame", "LHnd"])
        Traceback (most recent call last):
            ...
        SystemExit: 2
    """
    end_on_signals()
    codes: list[int] = []
    atexit.register(_leave_qi, codes)  # registered first, and so called last
    words = sys.argv[1:]
    if arguments is not None:
        from nao_kin._core.arrays import texts  # these imports take a while; signals are already handled

        words = list(texts(arguments, "arguments"))
    if words and words[0] in _WITH_QI:
        with suppress(ImportError):
            importlib.import_module("qi")  # before Pinocchio, see nao_kin.naoqi._qi
    from nao_kin.cli.app import run

    codes.append(run(words))
    sys.exit(codes[0])


def _leave_qi(codes: list[int]) -> None:
    """Exit without the rest of Python's shutdown if qi is loaded: qi's threads would abort the program during it."""
    if codes and "qi" in sys.modules:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(codes[0])
