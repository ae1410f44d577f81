"""How far two results are apart: one number for each pair."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_kin._arrays import Floats


def gap(ours: Any, theirs: Floats) -> Floats:
    """Largest difference of any component, shape (n,); infinite where the shapes differ."""
    mine = np.asarray(ours, dtype=np.float64)
    if mine.shape != theirs.shape:
        return np.full(len(theirs), np.inf)
    return np.asarray(np.abs(mine - theirs).max(axis=tuple(range(1, mine.ndim)), initial=0.0))


def angle_gap(ours: Floats, theirs: Floats) -> Floats:
    """Difference of angles modulo a turn, in magnitude, component by component [rad]."""
    difference = ours - theirs
    return np.asarray(np.abs(difference - 2.0 * np.pi * np.round(difference / (2.0 * np.pi))))


def direction_gap(ours: Any, theirs: Floats) -> Floats:
    """Gap of vectors of which v and −v mean the same."""
    return np.minimum(gap(ours, theirs), gap(ours, -theirs))


def rotation_vector_gap(ours: Any, theirs: Floats) -> Floats:
    """Gap of rotation vectors, of which v and v − 2π v/‖v‖ mean the same: none jumps at π."""
    length = np.sqrt(np.square(theirs).sum(axis=1, keepdims=True))
    round_the_other_way = theirs - 2.0 * np.pi * theirs / np.where(length > 0.0, length, 1.0)
    return np.minimum(gap(ours, theirs), gap(ours, round_the_other_way))


def beyond(value: Floats, lower: float, upper: float) -> Floats:
    """How far a value is outside [lower, upper]."""
    return np.maximum(np.maximum(lower - value, value - upper), 0.0)


def largest(*gaps: Floats) -> Floats:
    """The largest of several discrepancies of each pair; NaN counts as the largest."""
    return np.asarray(np.maximum.reduce(gaps))
