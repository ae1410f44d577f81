"""Headings of tables of joint values: names and units, NAOqi's keys of its devices, times, and an index.

time [s], HeadYaw [deg], LHand (%)
timestamp, Device/SubDeviceList/HeadYaw/Position/Sensor/Value
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nao_kin._common.arrays import Floats

# Units that a heading may name, for joints whose values are in rad, m or ratios.
JOINT_UNITS = {"rad": ("rad", "deg", "°"), "m": ("m",), "1": ("1", "%")}
# Units of times, and how many of each a second has.
TIME_UNITS = {"s": 1.0, "ms": 1e3, "us": 1e6, "µs": 1e6, "ns": 1e9}
_TIME_NAMES = ("time", "timestamp", "t", "stamp")
_HEADING = re.compile(r"(?P<name>[^\[\]()]*?)\s*(?:[\[(]\s*(?P<unit>[^\[\]()]*?)\s*[\])])?")
_DEVICE = re.compile(r"(?:Device/SubDeviceList/)?(?P<joint>\w+)/Position/(?:Sensor|Actuator)/Value")
# As pandas writes it to CSV, reads it again, and writes it to Parquet.
_INDEX_NAMES = ("", "Unnamed: 0", "__index_level_0__")
# Seconds since 1970 have ten digits until the year 2286; what is larger than this in s is so in the next smaller unit.
_LARGEST_SECONDS = 1e11


@dataclass(frozen=True)
class Heading:
    """What stands above a column.

    Attributes:
        name: the joint or "time", or any other name.
        unit: in brackets behind it; None for none.
    """

    name: str
    unit: str | None = None

    @property
    def is_time(self) -> bool:
        """Whether times stand in the column."""
        return self.name.lower() in _TIME_NAMES


def read_heading(text: str) -> Heading:
    """The name and the unit of a heading; of a key of NAOqi's devices, the joint."""
    text = text.strip()
    match = _HEADING.fullmatch(text)
    name, unit = (text, None) if match is None else (match["name"], match["unit"])
    device = _DEVICE.fullmatch(name)
    return Heading(name if device is None else device["joint"], unit)


def is_index(text: str) -> bool:
    """Whether the heading of a first column is that of row numbers, which have no name of their own."""
    return text.strip() in _INDEX_NAMES


def in_si_units(values: Floats, units: Sequence[str]) -> Floats:
    """Values (n, k), with one unit for each column, in rad, m and ratios."""
    given = np.array(units)
    degrees, percent = np.isin(given, ("deg", "°")), given == "%"
    if not degrees.any() and not percent.any():
        return values
    values = np.where(degrees, np.radians(values), values)
    return np.where(percent, values / 100.0, values)


def time_unit_of(times: Floats) -> str:
    """The unit of times since 1970 by their size; "s" for smaller ones, such as times since a start."""
    size = float(np.median(np.abs(times[np.isfinite(times)]))) if np.isfinite(times).any() else 0.0
    for unit in ("s", "ms", "us"):
        if size < _LARGEST_SECONDS * TIME_UNITS[unit]:
            return unit
    return "ns"


def seconds(times: Floats, unit: str) -> Floats:
    """Times in seconds."""
    return times / TIME_UNITS[unit]
