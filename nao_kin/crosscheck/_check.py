"""A comparison of one conversion with one oracle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from nao_kin._arrays import Floats
from nao_kin.crosscheck._sample import Sample
from nao_kin.crosscheck._tally import TOLERANCE
from nao_kin.crosscheck.conversions import Conversions


@dataclass(frozen=True)
class Check:
    """A row of the report as a function of rotations.

    Attributes:
        convention, against, tolerance, note: as in `Row`.
        gap: discrepancies of n rotations, shape (n,); `LEFT_OUT` where a rotation says nothing.
    """

    convention: str
    against: str
    gap: Callable[[Sample, Conversions], Floats]
    tolerance: float = TOLERANCE
    note: str = ""
