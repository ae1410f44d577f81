"""Further keys on curves that stay as they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.motion.interpolation import Segments, segment_of
from nao_kin.motion.monotone import slowest
from nao_kin.motion.motion import Motion


def cut(motion: Motion, times: Floats) -> Motion:
    """The same curves with a key of every joint at each time that lies within its keys; a smooth motion becomes Bezier.

    Args:
        motion: which.
        times: of the new keys, shape (n,) [s].
    """
    if motion.interpolation == "linear":
        columns = [_with(own, times) for own in motion.times]
        rows = zip(columns, motion.times, motion.keys, strict=True)
        return Motion(columns, motion.joint_names, [np.interp(new, own, keys) for new, own, keys in rows])
    curves = motion.as_bezier()
    assert curves.handles is not None
    columns, values, offsets = [], [], []
    for own, keys, handles, curve in zip(curves.times, curves.keys, curves.handles, curves.segments, strict=True):
        new = _with(own, times)
        new = _with(new, _slow_times(curve, own, new))
        kept = np.isin(new, own)
        columns.append(new)
        values.append(np.empty(len(new)))
        values[-1][kept] = keys
        offsets.append(np.zeros((len(new), 2, 2)))
        offsets[-1][kept] = handles
        if not kept.all():
            _cut_curve(curve, own, new, ~kept, values[-1], offsets[-1])
    return Motion(columns, motion.joint_names, values, "bezier", offsets)


def _with(own: Floats, times: Floats) -> Floats:
    """The times of a joint's keys and those between them."""
    return np.union1d(own, times[(times > own[0]) & (times < own[-1])])


def _slow_times(curve: Segments, own: Floats, new: Floats) -> Floats:
    """Where segments that are cut also must be, for handles to end within the pieces.

    The time x of a segment whose handles a and b are longer than itself runs slower and then faster again, and a piece
    with both may begin or end more than three times as fast as it is on average. Where x only becomes slower, or only
    faster, none does.
    """
    if curve.lengths is None:
        return np.zeros(0)
    is_cut = np.searchsorted(new, own[1:]) - np.searchsorted(new, own[:-1]) > 1
    long = np.flatnonzero(is_cut & (curve.lengths.sum(axis=1) > 1.0))
    return curve.time(long, slowest(curve.time_slopes(long)))


def _cut_curve(
    curve: Segments, own: Floats, new: Floats, added: NDArray[np.bool_], values: Floats, offsets: Floats
) -> None:
    """Fill in the values of added keys, and all handles beside them.

    With its polar form f, a cubic has between the parameters u and v the control points f(u, u, u), f(u, u, v),
    f(u, v, v) and f(v, v, v).

    Source: L. Ramshaw, Blossoming: A Connect-the-Dots Approach to Splines, DEC SRC report 19 (1987).
    """
    pieces = np.flatnonzero(added[:-1] | added[1:])
    segment = segment_of(own, new[pieces])
    u, v = curve.parameter(segment, new[pieces]), curve.parameter(segment, new[pieces + 1])
    a, b = np.full((2, len(pieces)), 1.0 / 3.0) if curve.lengths is None else curve.lengths[segment].T
    width = curve.width[segment]
    room = new[pieces + 1] - new[pieces]
    for axis, controls in enumerate(((a * width, (1.0 - b) * width, width), curve.controls[segment].T)):
        ends = _polar(controls, u, u, u), _polar(controls, v, v, v)
        after, before = _polar(controls, u, u, v) - ends[0], _polar(controls, u, v, v) - ends[1]
        if axis == 0:
            after, before = np.clip(after, 0.0, room), np.clip(before, -room, 0.0)
        offsets[pieces, 1, axis], offsets[pieces + 1, 0, axis] = after, before
    starts = added[pieces]
    values[pieces[starts]] = curve.value(segment[starts], u[starts])


def _polar(controls: tuple[Floats, Floats, Floats] | Floats, r: Floats, s: Floats, t: Floats) -> Floats:
    """The polar form of a cubic with the Bernstein coefficients 0, p, q and d."""
    p, q, d = controls
    once = r * (1.0 - s) * (1.0 - t) + s * (1.0 - r) * (1.0 - t) + t * (1.0 - r) * (1.0 - s)
    twice = r * s * (1.0 - t) + r * t * (1.0 - s) + s * t * (1.0 - r)
    return np.asarray(p * once + q * twice + d * r * s * t)
