"""The module `qi`, loaded before Pinocchio if possible.

Both bring their own C++ libraries. In a process that loads Pinocchio first, the libraries of qi find Pinocchio's in
place of their own: a refused connection is never answered, and closing a server corrupts the memory (qi 3.1.5, pin 3).
In the other order, both work. Therefore this package imports this module first.
"""

from __future__ import annotations

import importlib
from contextlib import suppress
from typing import Any

from nao_kin._core.warn import need_extra

with suppress(ImportError):
    importlib.import_module("qi")


def load_qi(purpose: str) -> Any:
    """Return the module qi; raise MissingExtra with the purpose if it is not installed."""
    need_extra(purpose, "naoqi")
    return importlib.import_module("qi")
