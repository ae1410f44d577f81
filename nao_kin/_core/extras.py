"""The extras: optional packages, their purposes, and what works without them.

`errors.MissingExtra`, `nao-kin doctor` and the table in docs/installation.md use the rows of extras.json, and a test
compares them with pyproject.toml.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ALL = "all"
"""The extra that is the union of all others."""


@dataclass(frozen=True)
class Extra:
    """One extra: `pip install 'nao-kin[name]'`."""

    name: str
    packages: Sequence[str]  # its distributions, as in pyproject.toml; messages name the first
    brings: str  # the features that it adds
    without: str  # the features that work without it
    imported: Sequence[str] | None = None  # modules to import; () for data alone, None for the packages' names

    @property
    def modules(self) -> Sequence[str]:
        """The modules imported from the distributions."""
        return self.packages if self.imported is None else self.imported


_ROWS = json.loads(Path(__file__).with_name("extras.json").read_text(encoding="utf-8"))
EXTRAS = {name: Extra(name, **row) for name, row in _ROWS.items()}


def missing(purpose: str, name: str, reason: str = "") -> str:
    """Return one line: the required package, how to get it or why it fails, and the features that work without it."""
    extra = EXTRAS.get(name)
    if extra is None:
        return f"{purpose} needs an optional package: {command(name)}"
    remedy = f", which does not load ({reason})" if reason else f": {command(name)}"
    return f"{purpose} needs {extra.packages[0]}{remedy}; {extra.without}"


def with_remedy(problem: str) -> str:
    """Return why a library does not load, and which package of the operating system adds the missing part, if known."""
    if "libgomp.so.1" not in problem or "libgomp1" in problem:
        return problem
    return f"{problem}; install libgomp: apt-get install libgomp1 (Debian, Ubuntu), dnf install libgomp (Fedora)"


def command(name: str) -> str:
    """Return the command that installs an extra."""
    return f"pip install 'nao-kin[{name}]'"
