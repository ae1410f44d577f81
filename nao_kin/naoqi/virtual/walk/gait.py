"""How the virtual NAO walks: NAOqi's move configuration, with its defaults and bounds."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from nao_kin._text import quoted
from nao_kin.errors import BadArgument, UnknownName

SIDES: tuple[str, ...] = ("L", "R")
_PREFIXES = {"L": "Left", "R": "Right"}


@dataclass(frozen=True)
class Parameter:
    """One number of the move configuration.

    Attributes:
        default, least, most: as documented.
    """

    default: float
    least: float
    most: float


# Aldebaran documentation 2.1, locomotion control, "Move config parameters" of NAO. getMoveConfig("Default") of a robot
# prints the same defaults.
PARAMETERS: MappingProxyType[str, Parameter] = MappingProxyType(
    {
        "MaxStepX": Parameter(0.04, 0.001, 0.08),
        "MaxStepY": Parameter(0.14, 0.101, 0.16),
        "MaxStepTheta": Parameter(0.349, 0.001, 0.524),
        "MaxStepFrequency": Parameter(1.0, 0.0, 1.0),
        "StepHeight": Parameter(0.02, 0.005, 0.04),
        "TorsoWx": Parameter(0.0, -0.122, 0.122),
        "TorsoWy": Parameter(0.0, -0.122, 0.122),
    }
)
# moveToward takes the frequency under a name of its own.
_OTHER_NAMES = {"Frequency": "MaxStepFrequency"}

# A step lasts 21 cycles of 20 ms at frequency 1, and 30 at frequency 0; with MaxStepX that is 9.5 cm/s.
_SHORTEST, _LONGEST = 0.42, 0.6


@dataclass(frozen=True)
class FootGait:
    """The move configuration of one foot: the fields are those of `PARAMETERS` [m, rad, share].

    The lean of the torso is kept and not walked with: it stays level.
    """

    max_step_x: float = PARAMETERS["MaxStepX"].default
    max_step_y: float = PARAMETERS["MaxStepY"].default
    max_step_theta: float = PARAMETERS["MaxStepTheta"].default
    frequency: float = PARAMETERS["MaxStepFrequency"].default
    step_height: float = PARAMETERS["StepHeight"].default
    torso_wx: float = PARAMETERS["TorsoWx"].default
    torso_wy: float = PARAMETERS["TorsoWy"].default

    @property
    def period(self) -> float:
        """How long a step lasts [s]."""
        return _LONGEST + (_SHORTEST - _LONGEST) * self.frequency


_FIELDS = dict(zip(PARAMETERS, FootGait.__dataclass_fields__, strict=True))


@dataclass(frozen=True)
class Gait:
    """The move configuration of both feet.

    Attributes:
        left, right: of the steps of each foot.
    """

    left: FootGait = FootGait()
    right: FootGait = FootGait()

    def of(self, side: str) -> FootGait:
        """That of one foot, "L" or "R"."""
        return self.left if side == "L" else self.right


def gait_of(config: Any) -> Gait:
    """A gait from NAOqi's list of [name, value] pairs; numbers outside of the documented range are brought into it.

    A name holds for both feet, or with "Left" or "Right" before it for one. Later pairs count.

    Raises:
        BadArgument: no such list.
        UnknownName: no such parameter.
    """
    values: dict[str, dict[str, float]] = {side: {} for side in SIDES}
    for name, value in _pairs(config):
        sides = [side for side in SIDES if name.startswith(_PREFIXES[side])]
        plain = name.removeprefix(_PREFIXES[sides[0]]) if sides else name
        plain = _OTHER_NAMES.get(plain, plain)
        if plain not in PARAMETERS:
            raise UnknownName("move parameter", name, (*PARAMETERS, *_OTHER_NAMES))
        parameter = PARAMETERS[plain]
        for side in sides or SIDES:
            values[side][_FIELDS[plain]] = min(max(value, parameter.least), parameter.most)
    return Gait(FootGait(**values["L"]), FootGait(**values["R"]))


def move_config(which: str) -> list[list[object]]:
    """NAOqi's getMoveConfig: [name, value] pairs of "Default", "Min" or "Max".

    Raises:
        UnknownName: none of these.
    """
    columns = {"Max": "most", "Min": "least", "Default": "default"}
    if which not in columns:
        raise UnknownName("move configuration", which, tuple(columns))
    return [[name, getattr(parameter, columns[which])] for name, parameter in PARAMETERS.items()]


def _pairs(config: Any) -> list[tuple[str, float]]:
    pairs = list(config.items()) if isinstance(config, Mapping) else config
    if isinstance(pairs, str) or not isinstance(pairs, Sequence):
        raise BadArgument(f"a move configuration must be a list of [name, value] pairs, got {quoted(config, 60)}")
    found = []
    for pair in pairs:
        if isinstance(pair, str) or not isinstance(pair, Sequence) or len(pair) != 2 or not isinstance(pair[0], str):
            raise BadArgument(f"a move configuration must hold [name, value] pairs, got {quoted(pair, 60)}")
        name, value = pair
        number = isinstance(value, (int, float, np.integer, np.floating)) and math.isfinite(value)
        if not number:
            raise BadArgument(f"{name} must be a finite number, got {quoted(value, 60)}")
        found.append((name, float(value)))
    return found
