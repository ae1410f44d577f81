"""NAOqi's control points: [value, [type, time, value] before, [type, time, value] after], offsets from the key.

Types, as Aldebaran's qicore has them: 0 constant, 1 linear, 2 Bezier, 3 Bezier with automatic handles, which the points
hold too.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.motion.files.source import PlaceOf, Source, described
from nao_kin.motion.motion import Motion

CONSTANT, LINEAR, BEZIER, AUTOMATIC = range(4)
_EXPECTED = "[value, [type, time, value], [type, time, value]]"


def plain_keys(rows: list[Any]) -> bool:
    """Whether the keys of a joint are values without handles."""
    return not any(isinstance(row, list) for row in rows)


def control_points(source: Source, rows: list[Any], times: Floats, place: PlaceOf) -> tuple[Floats, Floats]:
    """Values (k,) and handles (k, 2, 2) of the control points of one joint.

    Raises:
        BadInputFile: no control point, or one that jumps.
    """
    for key, row in enumerate(rows):
        if not (
            type(row) is list
            and len(row) == 3
            and type(row[1]) is list is type(row[2])
            and len(row[1]) == 3 == len(row[2])
        ):
            raise source.error(f"expected {_EXPECTED}, got {described(row)}", place(key))
    if len(rows) != len(times):
        raise source.error(f"{len(times)} times and {len(rows)} keys", place(0))
    flat = [number for row in rows for number in (row[0], *row[1], *row[2])]
    table = source.floats(flat, "control point", lambda at: place(at // 7)).reshape(-1, 7)
    types = table[:, [1, 4]]
    known = np.isin(types, (LINEAR, BEZIER, AUTOMATIC))
    if not known.all():
        key = int(np.argmin(known.all(axis=1)))
        kind = types[key][~known[key]][0]
        what = "constant, and so jumps to the next key" if kind == CONSTANT else f"of type {kind:g}"
        raise source.error(f"the curve beside this key is {what}; expected type 1, 2 or 3", place(key))
    handles = table[:, [[2, 3], [5, 6]]]
    straight(times, table[:, 0], handles, types == LINEAR)
    return table[:, 0].copy(), handles


def straight(times: Floats, keys: Floats, handles: Floats, linear: Any) -> None:
    """Lay the handles that are marked as linear along the straight line to the next key, a third of it long."""
    chords = np.stack([np.diff(times), np.diff(keys)], axis=-1) / 3.0
    handles[1:, 0][linear[1:, 0]] = -chords[linear[1:, 0]]
    handles[:-1, 1][linear[:-1, 1]] = chords[linear[:-1, 1]]


def points(motion: Motion) -> list[list[Any]]:
    """The keys of each joint as NAOqi takes them: plain for a linear motion, else control points."""
    if motion.interpolation == "linear":
        return [keys.tolist() for keys in motion.keys]
    curves = motion.as_bezier()
    assert curves.handles is not None
    return [
        [[key, [AUTOMATIC, *before], [AUTOMATIC, *after]] for key, (before, after) in zip(keys, handles, strict=True)]
        for keys, handles in zip((k.tolist() for k in curves.keys), (h.tolist() for h in curves.handles), strict=True)
    ]
