"""Warnings that point at the caller's line, however deep inside the package they arise."""

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


# --- Optional packages at the place where they are needed.


def need_extra(purpose: str, name: str, *modules: str) -> None:
    """Refuse to go on without an extra.

    Args:
        purpose: what needs it, as the message begins.
        name: of the extra.
        modules: what is going to be imported; by default all that the extra brings.

    Raises:
        MissingExtra: it is not installed, or does not load.
    """
    for module in modules or EXTRAS[name].modules:
        try:
            importlib.import_module(module)
        except ImportError as error:
            absent = isinstance(error, ModuleNotFoundError) and error.name in (module, module.partition(".")[0])
            raise MissingExtra(purpose, name, "" if absent else with_remedy(abbreviated(error))) from None


# --- What MuJoCo warns of, as texts: by itself it prints them and leaves a MUJOCO_LOG.TXT in the working directory.

# MuJoCo has one place for warnings in a process.
_LISTENING = threading.RLock()


@contextmanager
def mujoco_warnings(mujoco: ModuleType) -> Iterator[list[str]]:
    """The warnings of what is done inside, which are complete behind it; nothing is printed or written.

    Args:
        mujoco: the package, which only some who are here have.
    """
    said: list[str] = []
    with _LISTENING:
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(said.append)
        try:
            with warnings.catch_warnings(record=True) as others:
                warnings.simplefilter("always")
                yield said
        finally:
            mujoco.set_mju_user_warning(before)
            said += [str(other.message) for other in others]
