"""Warnings that name the caller's line, of degrees too, missing extras, MuJoCo's warnings, and the former names."""

from __future__ import annotations

import importlib
import inspect
import math
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import ModuleType
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.extras import EXTRAS, with_remedy
from nao_kin._core.text import abbreviated
from nao_kin.errors import BadArgument, DegreesWarning, FormerNameWarning, MissingExtra, NaoKinWarning

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


# --- Former names of arguments, values, attributes and options: accepted for one more release, with a warning.
#
# `FORMER_NAMES` is the table of all of them; the documentation shows it. A function whose argument was renamed ends
# with `**_former: NoReturn`, so that type checkers refuse former names. A call without one costs an empty dictionary:
#
#     @hides_former
#     def arm(robot, target, *, near=None, **_former: NoReturn):
#         if _former:
#             near = NEAR.argument(_former, near)

_Function = TypeVar("_Function", bound=Callable[..., Any])


class FormerName(NamedTuple):
    """A name that was replaced by another one, and where."""

    old: str
    new: str
    where: str

    def warn(self) -> None:
        """Warn at the caller's line that the name has changed."""
        warn_caller(
            f"{self.old} is now {self.new}; the next release does not accept {self.old}", FormerNameWarning, self.old
        )

    @property
    def value(self) -> str:
        """The former value of an argument, as in name="value"."""
        return self.old.split('"')[1]

    def argument(self, former: Mapping[str, object], value: Any, default: object = None) -> Any:
        """Return an argument from the keywords that its function does not know; its `value` must be the default."""
        if former.keys() != {self.old.removesuffix("=")}:
            unknown = next(name for name in former if f"{name}=" != self.old)
            function = sys._getframe(1).f_code.co_name
            raise TypeError(f"{function}() got an unexpected keyword argument {unknown!r}")
        (given,) = former.values()
        return self.instead(given, value, default)

    def instead(self, given: Any, value: Any, default: object = None) -> Any:
        """Return what is given under the former name; refuse it if the new name has another value than its default."""
        if value is not default and (default is None or value != default):
            raise BadArgument(f"{self.old} is the former name of {self.new}; give one of them")
        self.warn()
        return given


def hides_former(function: _Function) -> _Function:
    """Hide `**_former` in the signature that help and documentation show."""
    signature = inspect.signature(function)
    shown = [parameter for parameter in signature.parameters.values() if parameter.name != "_former"]
    function.__signature__ = signature.replace(parameters=shown)  # type: ignore[attr-defined]
    return function


# The table.
LIMITS_RAISE = FormerName('limits="raise"', 'limits="enforce"', "robots, nk.stream")
LIMITS_REDISTRIBUTE = FormerName('limits="redistribute"', 'limits="enforce"', "nk.ik.velocity")
NEAR = FormerName("reference=", "near=", "nk.ik, nk.naoqi.from_order, nk.joints.MultiDofModel")
RESULT_REFERENCE = FormerName(".reference", ".near", "results of nk.ik")
ROOT = FormerName("root=", "reference=", "nk.ik.analytic")
SAMPLED_FPS = FormerName("fps=", "rate=", "nk.ik.FollowedPath.sampled")
MOST = FormerName("most=", "max_configurations=", "robot.limit_violations")
COLOUR_BY = FormerName("colour_by=", "by=", "nk.reach.ReachMap.save_ply")
CLAMPED_MOST = FormerName("clamped.most", "clamped.largest", "nk.stream.StreamResult")
HIPS_AGREE = FormerName('hips="agree"', "hips=None", "nk.naoqi.from_order")
START_TASK = FormerName(".start_task", ".tasks.add", "nk.naoqi.VirtualNao")

FORMER_NAMES = (
    *(LIMITS_RAISE, LIMITS_REDISTRIBUTE, NEAR, RESULT_REFERENCE, ROOT, SAMPLED_FPS),
    *(MOST, COLOUR_BY, CLAMPED_MOST, HIPS_AGREE, START_TASK),
    # Options, and the commands that had them; "nao-kin" for all.
    FormerName("--clamp", "--limits clamp", "nao-kin fk, balance, motion convert"),
    FormerName("--ignore-limits", "--limits ignore", "nao-kin fk, ik, balance, collisions, camera"),
    FormerName("--reference", "--near", "nao-kin ik"),
    FormerName("--frames", "--frame", "nao-kin view"),
    FormerName("--record", "--output", "nao-kin live"),
    FormerName("--version", "--nao", "nao-kin"),
)
