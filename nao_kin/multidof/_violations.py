"""Joints of one motor at odds, one row for each pair and configuration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nao_kin.multidof._selection import Mismatch


@dataclass(frozen=True)
class CouplingViolation:
    """Two joints of one motor that a typed configuration puts at values no motor position produces.

    Attributes:
        primary: the driving joint.
        mimic: the joint that follows it.
        primary_value: value of the driving joint.
        mimic_value: value of the joint that follows, by whole turns nearest to what is expected.
        expected: value the driving joint asks of it.
        nearest: value of the driving joint that, with what follows from it, is nearest to the values given.
        index: which configuration of the batch.
    """

    primary: str
    mimic: str
    primary_value: float
    mimic_value: float
    expected: float
    nearest: float
    index: tuple[int, ...] = ()


def coupling_violations(mismatches: Sequence[Mismatch], batch: tuple[int, ...]) -> tuple[CouplingViolation, ...]:
    """The rows of what was found for the flattened batch, by configuration."""
    rows = []
    for mismatch in mismatches:
        follower = mismatch.follower
        for i in np.flatnonzero(mismatch.violated):
            value = float(mismatch.driver_value[i])
            rows.append(
                CouplingViolation(
                    primary=follower.driver,
                    mimic=follower.name,
                    primary_value=value,
                    mimic_value=float(mismatch.follower_value[i]),
                    expected=follower.multiplier * value + follower.offset,
                    nearest=float(mismatch.nearest[i]),
                    index=tuple(int(k) for k in np.unravel_index(int(i), batch)) if batch else (),
                )
            )
    return tuple(sorted(rows, key=lambda row: row.index))
