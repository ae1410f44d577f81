"""Warnings that point at the caller's line, however deep inside the package they arise."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

from nao_kin.errors import NaoKinWarning

_PACKAGE = str(Path(__file__).resolve().parent.parent)


def warn_caller(message: str, category: type[NaoKinWarning]) -> None:
    """Warn at the innermost line outside of this package; Python's default shows it once for each such line."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, category, stacklevel=level + 1)
