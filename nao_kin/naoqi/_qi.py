"""The module `qi`, loaded before Pinocchio if possible.

qi and Pinocchio each bring their own C++ libraries. If a process loads Pinocchio first, the libraries of qi use
Pinocchio's in place of their own: a call to connect never ends if the connection is refused, and closing a server
corrupts the memory (qi 3.1.5, pin 3). In the other order, both work. Therefore this package imports this module first.
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
