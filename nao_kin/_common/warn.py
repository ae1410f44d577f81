"""Warnings that point at the caller's line, however deep inside the package they arise."""

from __future__ import annotations

import sys
import warnings

from nao_kin.errors import NaoKinWarning

_PACKAGE = __name__.partition(".")[0]


class _Message(str):
    """A text equal to every other on the same subject.

    Python shows a warning once for each text and line, and would take texts that differ by a number for different.
    """

    subject: str

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Message) and self.subject == other.subject

    def __hash__(self) -> int:
        return hash(self.subject)


def warn_caller(message: str, category: type[NaoKinWarning], subject: str = "") -> None:
    """Warn at the innermost line outside of this package; Python's default shows it once for each such line.

    Args:
        message: what is said.
        category: kind of the warning.
        subject: messages of one subject count as one, whatever their numbers; "" for this message alone.
    """
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).partition(".")[0] == _PACKAGE:
        level, frame = level + 1, frame.f_back
    text = _Message(message)
    text.subject = subject or message
    warnings.warn(text, category, stacklevel=level + 1)
