"""The module `qi`, loaded before Pinocchio where that can be.

Both bring C++ libraries of their own. In a process that loads Pinocchio first, those of qi find Pinocchio's in place of
their own: a connection that is refused is never answered, and closing a server corrupts the memory (qi 3.1.5, pin 3).
The other way round, both work. So this is the first that the room imports.
"""

from __future__ import annotations

import importlib
from contextlib import suppress
from typing import Any

from nao_kin._core.warn import need_extra

with suppress(ImportError):
    importlib.import_module("qi")


def load_qi(purpose: str) -> Any:
    """The module qi.

    Args:
        purpose: what it is needed for.

    Raises:
        MissingExtra: it is not installed.
    """
    need_extra(purpose, "naoqi")
    return importlib.import_module("qi")
