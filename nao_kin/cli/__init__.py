"""The command line: one thin command per capability."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import NoReturn

from nao_kin._common.ending import end_on_signals

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the program and exit.

    Exit codes: 0 when all is well, 1 when a check failed, 2 for bad input; 129, 130 and 143 when ended by the signals
    HUP, INT and TERM.

    Args:
        arguments: what stands behind the program's name; those of this process by default.
    """
    end_on_signals()
    from nao_kin.cli.app import run  # takes a while, in which signals are answered already

    sys.exit(run(arguments))
