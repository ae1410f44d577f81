"""Warnings that name the caller's line, of degrees too, errors for missing extras, and MuJoCo's warnings."""

from __future__ import annotations

import importlib
import math
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.extras import EXTRAS, with_remedy
from nao_kin._core.text import abbreviated
from nao_kin.errors import DegreesWarning, MissingExtra, NaoKinWarning

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


# --- Angles that look like degrees.

TURN = 2.0 * math.pi
# Whole numbers in between are probably degrees, up to ten turns; all floats from 2⁵³ on are whole numbers.
_LEAST_DEGREES, _MOST_DEGREES = 10.0, 3600.0
# NumPy takes longer than Python for fewer numbers.
_FEW = 16


def warn_of_degrees(angles: NDArray[np.float64], what: str, depth: int = 1) -> bool:
    """Return whether half or more of the angles beyond a turn are whole numbers from 10 on, as degrees are, and warn.

    An angle of several turns is honest, and hardly ever a whole number of radians. The warning is for the code that
    calls a function of this package, `depth` calls above this one: what the package itself passes on is not checked.
    """
    if angles.size <= _FEW:
        largest = max(map(abs, angles.ravel().tolist()), default=0.0)
    else:
        largest = max(float(angles.max()), -float(angles.min()))
    if not largest > TURN:
        return False
    beyond = np.abs(angles)
    beyond = beyond[beyond > TURN]
    whole = beyond[(beyond == np.rint(beyond)) & (beyond >= _LEAST_DEGREES) & (beyond <= _MOST_DEGREES)]
    caller = sys._getframe(depth + 1).f_globals.get("__name__")
    if not len(whole) or 2 * len(whole) < len(beyond) or str(caller).partition(".")[0] == _PACKAGE:
        return False
    warn_caller(
        f"{what} = {whole[0]:.6g} rad is more than a full turn, and a whole number; "
        "angles are in radians, np.deg2rad converts degrees",
        DegreesWarning,
        subject="degrees",
    )
    return True


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
