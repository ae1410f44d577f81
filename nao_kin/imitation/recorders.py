"""Files of recorders: Kinect's of NTU RGB+D, and C3D of motion capture.

Sources: github.com/shahroudy/NTURGB-D; c3d.org, The C3D File Format.
"""

from __future__ import annotations

import io
import warnings
from importlib import import_module

import numpy as np

from nao_kin._core.arrays import finite_decimal
from nao_kin._core.text import MAX_SHOWN, quoted
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadInputFile
from nao_kin.imitation.reading import Options, of_array
from nao_kin.imitation.skeleton import Skeleton
from nao_kin.imitation.tables import of_recorded

# NTU: numbers that describe a body, and those of each of its joints: x, y, z, four of images, a quaternion, a state.
_BODY, _JOINT = 10, 12


def is_ntu(text: str) -> bool:
    """Return whether a text begins as NTU's files: frames, bodies, a body, joints, and a joint."""
    counts = [len(line.split()) for line in text.split("\n", 6)[:6]]
    skip = counts[1:3].count(1) - 1 if len(counts) > 2 else 0
    return counts[:2] == [1, 1] and counts[2 + skip : 5 + skip] == [_BODY, 1, _JOINT]


def of_ntu(name: str, text: str, options: Options) -> Skeleton:
    """Return the skeleton of the body that is in most frames of a .skeleton file."""
    lines = text.split("\n")
    at = 0

    def take(count: int) -> list[float]:
        nonlocal at
        fields = lines[at].split() if at < len(lines) else []
        at += 1
        values = [finite_decimal(field) for field in fields]
        if len(values) != count or None in values:
            what = quoted(lines[at - 1], MAX_SHOWN) if fields else "the end of the file"
            raise BadInputFile(name, f"{what}, expected {count} numbers", min(at, len(lines)))
        return [value for value in values if value is not None]

    frames = int(take(1)[0])
    bodies: dict[str, list[tuple[int, list[list[float]]]]] = {}
    for k in range(frames):
        for _ in range(int(take(1)[0])):
            body = lines[at].split()[:1] if at < len(lines) else []  # a number too long for floating point
            take(_BODY)
            joints = [take(_JOINT) for _ in range(int(take(1)[0]))]
            bodies.setdefault(body[0], []).append((k, joints))
    if not bodies:
        raise BadInputFile(name, f"{frames} frames without a body")
    seen = max(bodies.values(), key=len)
    array = np.full((frames, len(seen[0][1]), 4), np.nan)
    array[..., 3] = 0.0
    for k, joints in seen:
        array[k] = np.array(joints)[:, [0, 1, 2, 11]]
    notes = [f"{len(bodies)} people: the one in most frames, {len(seen)} of {frames}"] if len(bodies) > 1 else []
    return of_array(name, array, options, notes=notes)


def of_c3d(name: str, data: bytes, options: Options) -> Skeleton:
    """Return the skeleton of the points of a C3D file, by the package c3d."""
    need_extra("reading C3D", "c3d", "c3d")
    c3d = import_module("c3d")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that the file has no analog data
            reader = c3d.Reader(io.BytesIO(data))
            labels = [label.strip().split(":")[-1] for label in reader.point_labels]
            units = reader.get("POINT:UNITS")
            frames = [points.copy() for _, points, _ in reader.read_frames()]
    except Exception as error:  # c3d raises AssertionError, KeyError, struct.error and others for a broken file
        raise BadInputFile(name, f"not a readable C3D file: {error}") from None
    if not frames:
        raise BadInputFile(name, "a C3D file without frames of points")
    array = np.array(frames, dtype=np.float64)
    array[array[..., 3] < 0.0] = np.nan  # points that were not seen
    joints = {label: array[:, k, :3] for k, label in enumerate(labels[: array.shape[1]]) if label}
    unit = "" if units is None else units.string_value.strip().lower()
    return of_recorded(name, joints, np.arange(len(frames)) / reader.point_rate, unit, options)
