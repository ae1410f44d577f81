"""Modules that scripts for NAOqi import: `naoqi`, `almath`, `motion` and `vision_definitions`.

`nao-kin run` puts this folder at the end of a script's search path. For other programs, add it to `PYTHONPATH`.
"""

from __future__ import annotations

from pathlib import Path

__all__ = ["FOLDER"]


FOLDER = Path(__file__).resolve().parent
