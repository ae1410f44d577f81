"""Modules that scripts for NAOqi import: `naoqi`, `almath` and `motion`.

They are found by scripts that `nao-kin run` starts, for it puts this folder at the end of their search path. With any
other program, `PYTHONPATH` does the same.
"""

from __future__ import annotations

from pathlib import Path

__all__ = [
    "FOLDER",
]


# To be on the search path of a script.
FOLDER = Path(__file__).resolve().parent
