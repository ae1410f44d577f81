"""Warnings that name the caller's line, errors for missing extras, and MuJoCo's warnings."""

from __future__ import annotations

import importlib
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

from nao_kin._core.extras import EXTRAS, with_remedy
from nao_kin._core.text import abbreviated
from nao_kin.errors import MissingExtra, NaoKinWarning

_PACKAGE = __name__.partition(".")[0]


class _Message(str):
    """A message that equals all others on its subject: Python shows a warning once for each text and line."""

    subject: str

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Message) and self.subject == other.subject

    def __hash__(self) -> int:
        return hash(self.subject)


def warn_caller(message: str, category: type[NaoKinWarning], subject: str = "") -> None:
    """Warn at the innermost line outside this package; messages of one `subject` count as the same warning."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).partition(".")[0] == _PACKAGE:
        level, frame = level + 1, frame.f_back
    text = _Message(message)
    text.subject = subject or message
    warnings.warn(text, category, stacklevel=level + 1)


# --- Optional packages.


def need_extra(purpose: str, name: str, *modules: str) -> None:
    """Raise `MissingExtra` if an extra, or one of the given modules of it, is not installed or does not load."""
    for module in modules or EXTRAS[name].modules:
        try:
            importlib.import_module(module)
        except ImportError as error:
            absent = isinstance(error, ModuleNotFoundError) and error.name in (module, module.partition(".")[0])
            raise MissingExtra(purpose, name, "" if absent else with_remedy(abbreviated(error))) from None


# --- Warnings of MuJoCo, which prints them and writes a MUJOCO_LOG.TXT in the working directory.

# MuJoCo has one handler of warnings per process.
_LISTENING = threading.RLock()


@contextmanager
def mujoco_warnings(mujoco: ModuleType) -> Iterator[list[str]]:
    """Yield a list of MuJoCo's warnings inside the context, complete at its end; nothing is printed or logged."""
    messages: list[str] = []
    with _LISTENING:
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(messages.append)
        try:
            with warnings.catch_warnings(record=True) as others:
                warnings.simplefilter("always")
                yield messages
        finally:
            mujoco.set_mju_user_warning(before)
            messages += [str(other.message) for other in others]
