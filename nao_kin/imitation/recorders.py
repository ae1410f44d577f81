"""Files of recorders of motion capture: Kinect's of NTU RGB+D, Motive's CSV, TRC and C3D.

Sources: github.com/shahroudy/NTURGB-D; docs.optitrack.com, Data Export: CSV; opensimconfluence.atlassian.net, Marker
(.trc) Files; c3d.org, The C3D File Format.
"""

from __future__ import annotations

import csv
import io
import warnings
from collections.abc import Iterable, Sequence
from importlib import import_module

import numpy as np

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.text import MAX_SHOWN, quoted
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadInputFile
from nao_kin.imitation.layouts import side_and_word
from nao_kin.imitation.reading import Options, of_array, of_named
from nao_kin.imitation.skeleton import Skeleton

# NTU: numbers that describe a body, and those of each of its joints: x, y, z, four of images, a quaternion, a state.
_BODY, _JOINT = 10, 12
_UNITS = {
    "meters": "m",
    "metres": "m",
    "centimeters": "cm",
    "millimeters": "mm",
    "inches": "inch",
    "m": "m",
    "cm": "cm",
    "mm": "mm",
}
# Words of the names of markers.
_MARKERS = ("sho", "elb", "wra", "asi", "kne")


def _of_markers(joints: Iterable[str]) -> list[str]:
    """Return a note if names are those of markers on the skin."""
    words = {side_and_word(joint)[1] for joint in joints}
    return ["markers on the skin stand for joints: directions are some degrees off"] if words & {*_MARKERS} else []


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
    return of_array(name, array, None, options, notes=notes)


# --- Wide tables: the names of points above three columns of each.


def _floats(name: str, rows: Sequence[tuple[int, list[str]]], width: int) -> Floats:
    """Return numbers, NaN for empty cells and those that are missing at the end of a row."""
    table = np.full((len(rows), width), np.nan)
    for k, (line, cells) in enumerate(rows):
        for at, cell in enumerate(cells[:width]):
            if cell.strip():
                value = finite_decimal(cell)
                if value is None and cell.strip().lower() != "nan":
                    raise BadInputFile(name, f"{quoted(cell, MAX_SHOWN)}, expected a number", line, at + 1)
                table[k, at] = np.nan if value is None else value
    return table


def _rows(text: str, delimiter: str) -> list[tuple[int, list[str]]]:
    reader = csv.reader(io.StringIO(text), delimiter=delimiter)
    return [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]


def of_motive(name: str, text: str, options: Options) -> Skeleton:
    """Return the skeleton in the CSV of OptiTrack's Motive: the positions of bones, else of markers."""
    rows = _rows(text, ",")
    head = rows[0][1]
    stated = dict(zip(head[::2], head[1::2], strict=False))
    start = next((k for k, (_, cells) in enumerate(rows) if cells[0].strip().lower() == "frame"), None)
    if start is None:
        raise BadInputFile(name, "no row Frame, Time (Seconds) above the numbers")
    labels = {cells[1].strip().lower(): cells for _, cells in rows[1:start] if len(cells) > 1}
    axes, names = rows[start][1], labels.get("name", [])
    kinds, types = rows[start - 1][1], labels.get("type", rows[1][1])
    table = _floats(name, rows[start + 1 :], len(axes))
    at: dict[str, dict[str, dict[str, int]]] = {}
    for k, axis in enumerate(axes):
        if (
            k >= 2
            and axis.strip().lower() in "xyz"
            and k < min(len(names), len(kinds))
            and kinds[k].strip() == "Position"
        ):
            kind = types[k].strip().lower() if k < len(types) else ""
            at.setdefault(kind, {}).setdefault(names[k].split(":")[-1], {})[axis.strip().lower()] = k
    bones = at.get("bone") or at.get("marker") or {}
    joints = {joint: table[:, [places[axis] for axis in "xyz"]] for joint, places in bones.items() if len(places) == 3}
    if not joints:
        raise BadInputFile(name, f"no positions of bones or markers of a person; types: {', '.join(at) or 'none'}")
    units = _UNITS.get(stated.get("Length Units", "").lower())
    return of_named(name, joints, {}, table[:, 1], "s", options, units=units, notes=_of_markers(joints))


def of_trc(name: str, text: str, options: Options) -> Skeleton:
    """Return the skeleton in a TRC file, tab-separated or, as spreadsheets write it, with commas."""
    rows = _rows(text, "\t" if "\t" in text[:200] else ",")
    start = next((k for k, (_, cells) in enumerate(rows) if cells[0].strip().lower() == "frame#"), None)
    if start is None or start < 2 or len(rows) < start + 3:
        raise BadInputFile(name, "no row Frame#, Time and names above the numbers of TRC")
    stated = dict(zip(rows[start - 2][1], rows[start - 1][1], strict=False))
    names = {k: label.strip() for k, label in enumerate(rows[start][1]) if k >= 2 and label.strip()}
    table = _floats(name, rows[start + 2 :], max(names, default=2) + 3)
    joints = {label.split(":")[-1]: table[:, k : k + 3] for k, label in names.items()}
    units = _UNITS.get(stated.get("Units", "").strip().lower())
    return of_named(name, joints, {}, table[:, 1], "s", options, units=units, notes=_of_markers(joints))


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
    times = np.arange(len(frames)) / reader.point_rate
    unit = _UNITS.get(units.string_value.strip().lower()) if units is not None else None
    return of_named(name, joints, {}, times, "s", options, units=unit, notes=_of_markers(joints))
