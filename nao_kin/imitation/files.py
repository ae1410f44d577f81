"""Read skeletons from files: BVH, tables and arrays of points, and the rotations of SMPL in AMASS.

A BVH file has a hierarchy of joints, each with an OFFSET from its parent and CHANNELS, and a row of channel values for
each frame:

    R_parent_joint = R_a(α) R_b(β) R_c(γ), about moving axes, in the order in which the rotation channels are listed
    p_parent_joint = OFFSET, or its position channels where it has some

Source: Meredith and Maddock, Motion Capture File Formats Explained, University of Sheffield, CS-01-11.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, choice, cross, finite_decimal, norm, shaped
from nao_kin._core.csv_numbers import CsvHead, TableColumns, plain_floats, read_csv
from nao_kin._core.files import described, is_finite_number, read_arrays, read_bytes, read_json
from nao_kin._core.headings import seconds_of
from nao_kin._core.text import MAX_SHOWN, abbreviated, nearest_names, quoted
from nao_kin.errors import BadArgument, BadInputFile, DegeneratePoints, NotFinite, WrongShape
from nao_kin.imitation.bones import doubt_of
from nao_kin.imitation.skeleton import (
    NAMINGS,
    SIDES,
    UNITS,
    Naming,
    Skeleton,
    assembled,
    by_joint,
    check_points,
    frame_times,
    key_of,
    landmark_array,
    named_points,
    of_landmarks,
    refuse_plane,
    tables,
    with_names,
)
from nao_kin.rotations import exp, matrix_from_euler

_SAMPLES = Path(__file__).with_name("samples")
#: Small skeletons of our own making, to try things with: name → file.
SAMPLES: Mapping[str, Path] = MappingProxyType(
    {name: _SAMPLES / file for name, file in (("wave", "wave.bvh"), ("bow", "bow.json"), ("circles", "circles.bvh"))}
)
# Other files of motion capture: their first bytes, and what they are.
_OTHERS = (
    (re.compile(rb"[\x01-\x08]\x50"), "a C3D file of motion capture: markers, not joints"),
    (re.compile(rb"Kaydara FBX|\s*; FBX"), "an FBX file of motion capture, which Blender writes as BVH"),
    (re.compile(rb"PathFileType"), "a TRC file of motion capture: markers, not joints"),
)
_CONTENTS = "BVH, JSON or CSV of points, a .npy or .npz array, or an .npz file of AMASS"


@dataclass(frozen=True)
class _Options:
    """The options of the caller, as in `read_skeleton`."""

    source: str | None
    names: Mapping[str, str] | None
    rate: float | None
    units: str | None
    up: str | None

    def naming(self, joints: Sequence[str], namings: Iterable[Naming] = NAMINGS.values()) -> tuple[Naming, list[str]]:
        """Return the naming of the caller, or the one that gives the most points; then the one that they fill most.

        A note names the one that was found.
        """
        if self.source:
            return with_names(NAMINGS[self.source], self.names, joints), []
        found = max(namings, key=lambda naming: _fit(naming, joints))
        return with_names(found, self.names, joints), [f"names of {found.name}"]


def _fit(naming: Naming, joints: Sequence[str]) -> tuple[int, float]:
    count = len(naming.resolved(joints))
    return count, count / len([name for name, alternatives in naming.points.items() if alternatives])


def read_skeleton(
    path: Path | str,
    *,
    source: str | None = None,
    names: Mapping[str, str] | None = None,
    rate: float | None = None,
    units: str | None = None,
    up: str | None = None,
) -> Skeleton:
    """Return the skeleton in a file of motion capture, of a depth camera or of a pose estimator.

    Files are recognised by their content:

    - BVH, with any hierarchy, order of channels and naming of `source`;
    - JSON, `{"times": [s …], "landmarks": [[[x, y, z, visibility] …] …]}`, null for a frame without a person;
    - CSV with a column of times and columns such as SpineBase_X, left_wrist.y, z11 or left_wrist_visibility;
    - NumPy's .npy, shape (n, k, 3 or 4), or .npz with such an array, and an array `times` if it has one;
    - AMASS, .npz with `poses` (n, 66 or more), `trans` (n, 3) and `mocap_framerate`; the rotations of the joints turn
      the bones of the mean shape of SMPL.

    Args:
        path: the file, unpacked if its name ends in .gz, or "-" for standard input.
        source: the naming, or the order of points: "mediapipe", "kinect_v2", "azure_kinect", "coco17", "body25",
            "h36m17", "h36m32", "smpl"; "mixamo", "lafan1", "rokoko", "xsens", "cmu", "biovision", "daz", "points"
            (`POINTS`). None finds it by names, or by the number of points and the lengths of bones, and notes it.
        names: name of `POINTS` → joint of the file, where its naming is another; "a + b" for the mean of two joints.
        rate: frames per second, 1 to 1000, of a file without times, or instead of its times.
        units: as in `Skeleton.from_landmarks`.
        up: as in `Skeleton.from_landmarks`.

    Raises:
        UnknownName: an unknown source, unit, axis, point or joint.
        BadInputFile: the file cannot be read, is malformed or incomplete, or its points are no skeleton. The message is
            one line, with the file and, for text, line and column.

    Examples:
        >>> wave = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
        >>> wave.source, len(wave), wave.notes[1:]
        ('mixamo', 65, ('y points up, by the direction of the trunk', 'unit cm, by the size of the trunk: 0.53 m'))
    """
    if source is not None:
        choice(source, NAMINGS, "source")
    name, options = str(path), _Options(source, names, rate, units, up)
    data = read_bytes(name)
    with _errors_of(name):
        for first, what in _OTHERS:
            if first.match(data):
                raise BadInputFile(name, f"{what}; expected {_CONTENTS}")
        if data.startswith((b"\x93NUMPY", b"PK\x03\x04")):
            return _of_arrays(name, data, options)
        text = _text(name, data)
        start = text.lstrip()[:9]
        if start.upper() == "HIERARCHY" or name.lower().removesuffix(".gz").endswith(".bvh"):
            return _of_bvh(_Bvh(name, text), options)
        if start[:1] in ("{", "["):
            return _of_json(name, text, options)
        return _of_csv(name, text.encode(), options)


def _seconds(
    name: str,
    options: _Options,
    count: int,
    times: Any = None,
    unit: str | None = None,
    advice: str = "rate= (--rate) says otherwise",
) -> tuple[Floats, tuple[str, ...]]:
    """Return the times of a file's frames [s], or those of the caller's rate, and a note if their unit is guessed."""
    stated = times is None or options.rate is not None
    given = frame_times(None, options.rate, count) if stated else shaped(times, (count,), "times")
    seconds, note = seconds_of(name, given, "s" if stated else unit, frames=True, advice=advice)
    return seconds, (note,) if note else ()


@contextmanager
def _errors_of(name: str) -> Iterator[None]:
    """Name the file in errors about its points; numbers that become too large are refused as infinite ones."""
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            yield
    except (BadArgument, DegeneratePoints, NotFinite, WrongShape) as error:
        raise BadInputFile(name, str(error)) from None


def _text(name: str, data: bytes) -> str:
    try:
        text = data.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise BadInputFile(name, f"not UTF-8 text (byte {error.start}); expected {_CONTENTS}") from None
    if not text.strip():
        raise BadInputFile(name, f"empty; expected {_CONTENTS}")
    return text


# --- BVH.

_CHANNELS = tuple(axis + kind for kind in ("position", "rotation") for axis in "XYZ")
_INSIDE = ("OFFSET", "CHANNELS", "JOINT", "End Site", "}")


@dataclass
class _Joint:
    """A joint or an End Site of a BVH file."""

    name: str
    parent: int
    offset: Floats = field(default_factory=lambda: np.full(3, np.nan))  # NaN until it is read
    channels: tuple[str, ...] | None = None
    column: int = 0  # of its first channel


class _Bvh:
    """The joints and channel values of a BVH file."""

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self._lines = text.split("\n")
        self._words = (
            (word.group(), number, word.start() + 1)
            for number, line in enumerate(self._lines, start=1)
            for word in re.finditer(r"[{}]|[^\s{}]+", line)
        )
        self._line = self._column = 1
        self.joints: list[_Joint] = []
        self._names: set[str] = set()
        self._hierarchy()
        self.frame_time, self.values = self._motion()

    def _error(self, reason: str) -> BadInputFile:
        return BadInputFile(self.name, reason, self._line, self._column)

    def _take(self, *expected: str) -> str:
        """Return the next word, which must be one of those expected, in any letter case, if there are any."""
        try:
            word, self._line, self._column = next(self._words)
        except StopIteration:
            where = expected[0] if expected else "a value"
            raise BadInputFile(
                self.name, f"ends where {where} is expected; it is incomplete", len(self._lines)
            ) from None
        if not expected:
            return word
        for one in expected:
            if word.lower() == one.split()[0].lower():
                return one
        near = nearest_names(word, expected, 1)
        wanted = (
            f"{near[0]}, or another of {', '.join(expected)}" if near and len(expected) > 1 else ", ".join(expected)
        )
        raise self._error(f"{quoted(word, MAX_SHOWN)}, expected {wanted}")

    def _number(self, what: str) -> float:
        word = self._take()
        value = finite_decimal(word)
        if value is None:
            raise self._error(f"{what} is {quoted(word, MAX_SHOWN)}, expected a finite number")
        return value

    def _count(self, what: str, least: int) -> int:
        value = self._number(what)
        if value != int(value) or value < least:
            raise self._error(f"{what} is {value:g}, expected a whole number of at least {least}")
        return int(value)

    def _open(self, parent: int, end: bool = False) -> int:
        """Begin a joint, whose name lasts until the brace; return its index."""
        words: list[str] = []
        while (word := self._take()) != "{":
            if word in _INSIDE:
                raise self._error(f"{word}, expected {{ after the name of a joint")
            words.append(word)
        name = f"{self.joints[parent].name}_end" if end else " ".join(words)
        if not name:
            raise self._error("a joint without a name")
        if not end and name in self._names:
            raise self._error(f"a second joint {quoted(name)}")
        self._names.add(name)
        self.joints.append(_Joint(name, parent, channels=() if end else None))
        return len(self.joints) - 1

    def _hierarchy(self) -> None:
        """Read the joints, each after its parent."""
        self._take("HIERARCHY")
        self._take("ROOT")
        at, column = self._open(-1), 0
        while at >= 0:
            joint = self.joints[at]
            word = self._take(*_INSIDE)
            if word == "OFFSET":
                joint.offset = np.array([self._number(f"OFFSET of {joint.name}") for _ in range(3)])
            elif word == "CHANNELS":
                if joint.channels is not None:
                    raise self._error(f"CHANNELS of {joint.name}, which has them already or is an End Site")
                count = self._count("the number of channels", 0)
                joint.channels = tuple(self._take(*_CHANNELS) for _ in range(count))
                joint.column, column = column, column + count
                if len(set(joint.channels)) < count:
                    raise self._error(f"a channel twice in {joint.name}")
            elif word == "JOINT":
                at = self._open(at)
            elif word == "End Site":
                if not (site := self._take()).lower().startswith("site"):  # some number them: End Site-7
                    raise self._error(f"{quoted(site, MAX_SHOWN)}, expected Site")
                at = self._open(at, end=True)
            else:
                if joint.channels is None or np.isnan(joint.offset).any():
                    lacking = "CHANNELS" if joint.channels is None else "OFFSET"
                    raise self._error(f"{joint.name} ends without {lacking}")
                at = joint.parent
        self._width = column

    def _motion(self) -> tuple[float, Floats]:
        """Return the time from frame to frame [s], and the channel values, shape (frames, channels)."""
        self._take("MOTION")
        self._take("Frames:")
        count = self._count("the number of frames", 1)
        self._take("Frame")
        self._take("Time:")
        step = self._number("the frame time")
        if step <= 0.0:
            raise self._error(f"the frame time is {step:g}, expected more than 0")
        rows = []
        for number, line in enumerate(self._lines[self._line :], start=self._line + 1):
            fields = line.split()
            if not fields:
                continue
            self._line, self._column = number, 0
            row = plain_floats(fields) if line.isascii() and "_" not in line else None
            if row is None:
                for word in re.finditer(r"\S+", line):
                    if finite_decimal(word.group()) is None:
                        self._column = word.start() + 1
                        raise self._error(f"{quoted(word.group(), MAX_SHOWN)}, expected a finite number")
            if len(fields) != self._width:
                raise self._error(f"{len(fields)} values, expected one for each of {self._width} channels")
            rows.append(row)
        if len(rows) != count:
            ends = "; the file is incomplete" if len(rows) < count else ""
            raise self._error(f"frame {len(rows)} is the last one, but {count} frames are stated{ends}")
        return step, np.array(rows, dtype=np.float64).reshape(count, self._width)

    def local(self, joint: _Joint) -> tuple[Floats, Floats]:
        """Return p_parent_joint and R_parent_joint in all frames, shapes (n, 3) and (n, 3, 3)."""
        position = np.tile(joint.offset, (len(self.values), 1))
        sequence, columns = "", []
        for column, channel in enumerate(joint.channels or (), start=joint.column):
            if channel.endswith("position"):
                position[:, "XYZ".index(channel[0])] = self.values[:, column]
            else:
                sequence += channel[0].lower()
                columns.append(column)
        if not sequence:
            return position, np.tile(np.eye(3), (len(position), 1, 1))
        return position, matrix_from_euler(np.radians(self.values[:, columns]), sequence, axes="moving")


def _of_bvh(file: _Bvh, options: _Options) -> Skeleton:
    joints = file.joints
    local = [file.local(joint) for joint in joints]
    rest = [(joint.offset[None], np.eye(3)[None]) for joint in joints]
    count = len(file.values)
    times, _ = _seconds(file.name, options, count, np.linspace(0.0, (count - 1) * file.frame_time, count), "s")
    return _of_tree(times, [joint.name for joint in joints], [joint.parent for joint in joints], local, rest, options)


# --- Trees of joints: BVH and SMPL.


def _of_tree(
    times: Floats,
    names: Sequence[str],
    parents: Sequence[int],
    local: Sequence[tuple[Floats, Floats]],
    rest: Sequence[tuple[Floats, Floats]],
    options: _Options,
) -> Skeleton:
    """Return the skeleton of joints that have positions and rotations relative to their parents, and a rest pose."""
    # The names of points in an order are those of other files.
    naming, notes = options.naming(names, [naming for naming in NAMINGS.values() if not naming.orders])
    points, rotations = _forward(parents, local)
    resolved = naming.resolved(names)
    standing, _ = _forward(parents, rest)
    at = {name: i for i, name in enumerate(names)}
    frames = _part_frames({name: np.mean([standing[at[p]][0] for p in parts], 0) for name, parts in resolved.items()})
    turned = {}
    for part, R_rest_part in frames.items():
        joint = resolved.get(part.replace("hand", "wrist"), ())
        if len(joint) == 1:
            turned[part] = rotations[at[joint[0]]] @ R_rest_part
    joints = dict(zip(names, points, strict=True))
    return assembled(times, joints, naming, units=options.units, up=options.up, orientations=turned, notes=tuple(notes))


def _forward(parents: Sequence[int], local: Sequence[tuple[Floats, Floats]]) -> tuple[list[Floats], list[Floats]]:
    """Return positions (n, 3) and rotations (n, 3, 3) of joints in the axes of the root's parent."""
    points: list[Floats] = []
    rotations: list[Floats] = []
    for parent, (p, R) in zip(parents, local, strict=True):
        if parent < 0:
            points.append(p)
            rotations.append(R)
        else:
            points.append(points[parent] + np.einsum("nij,nj->ni", rotations[parent], p))
            rotations.append(rotations[parent] @ R)
    return points, rotations


def _part_frames(rest: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return R_rest_part, of the axes that `Skeleton` states, in a rest pose; nothing unless it stands along the axes.

    The person is taken to look ahead in it, and the palms to be turned to the body or, with arms stretched out, down.
    """
    needed = ("pelvis", "neck", "left_shoulder", "right_shoulder", "left_knee", "right_knee")
    if not all(name in rest for name in needed):
        return {}
    left = _nearest_axis(rest["left_shoulder"] - rest["right_shoulder"])
    up = _nearest_axis(rest["neck"] - rest["pelvis"])
    legs = _nearest_axis(rest["left_knee"] + rest["right_knee"] - 2.0 * rest["pelvis"])
    if left is None or up is None or legs is None or left @ up or (legs != -up).any():
        return {}
    ahead = cross(left, up)
    trunk = np.stack([ahead, left, up], axis=1)
    frames = dict.fromkeys(("pelvis", "chest", "head"), trunk)
    for side, y in zip(SIDES, (-ahead, ahead), strict=True):
        ends = [rest[side + part] for part in ("elbow", "wrist", "hand") if side + part in rest][-2:]
        x = ends[-1] - ends[0] if ends else ahead
        z = cross(x, y)
        if norm(z) > 0.5 * norm(x):
            x, z = x / norm(x), z / norm(z)
            frames[side + "hand"] = np.stack([x, cross(z, x), z], axis=1)
    return frames


def _nearest_axis(vector: Floats) -> Floats | None:
    """Return the signed coordinate axis within 30° of a vector."""
    k = int(np.abs(vector).argmax())
    return np.sign(vector[k]) * np.eye(3)[k] if abs(vector[k]) > np.cos(np.pi / 6.0) * norm(vector) else None


def _of_amass(name: str, arrays: Mapping[str, NDArray[Any]], options: _Options) -> Skeleton:
    """Return the skeleton of the rotations of the joints of SMPL, SMPL-H or SMPL-X; those of fingers are left out."""
    table = tables()["smpl"]
    joints, parents = NAMINGS["smpl"].order, table["parents"]
    turning = len(joints) - 2  # the hands of SMPL turn with the wrists in SMPL-H
    poses = arrays["poses"]
    if poses.ndim != 2 or poses.shape[1] < 3 * turning or poses.dtype.kind != "f" or not np.isfinite(poses).all():
        raise BadInputFile(name, f"poses must be finite numbers (n, {3 * turning} or more), got {poses.shape}")
    n = len(poses)
    if not n:
        raise BadInputFile(name, "poses has no frames")
    trans = arrays.get("trans", np.zeros((n, 3)))
    if trans.shape != (n, 3) or trans.dtype.kind != "f" or not np.isfinite(trans).all():
        raise BadInputFile(name, f"trans must be finite numbers ({n}, 3), got {trans.shape}")
    rates = [arrays[key] for key in ("mocap_framerate", "mocap_frame_rate") if key in arrays]
    if rates and (rates[0].size != 1 or rates[0].dtype.kind not in "fiu"):
        raise BadInputFile(name, f"mocap_framerate must be one number, got {rates[0].dtype} of shape {rates[0].shape}")
    if rates and options.rate is None:
        options = replace(options, rate=float(rates[0].item()))
    times, _ = _seconds(name, options, n)
    rotations = exp(poses[:, : 3 * turning].astype(np.float64).reshape(n, turning, 3))
    still = np.tile(np.eye(3), (n, 1, 1))
    local, rest = [], []
    for k, joint in enumerate(joints):
        side = next((side for side in SIDES if joint.startswith(side)), "")
        offset = _rest_offset(table["rest"][joint.removeprefix(side)], side)
        local.append((np.tile(offset, (n, 1)) if k else trans, rotations[:, k] if k < turning else still))
        rest.append((offset[None], still[:1]))
    return _of_tree(times, joints, parents, local, rest, options)


def _rest_offset(row: Sequence[float], side: str) -> Floats:
    """Return the place of a joint from its parent for a row of [smpl.rest]: direction on the left side, and length."""
    direction = np.array(row[:3])
    return direction * ((-1.0 if side == "right_" else 1.0), 1.0, 1.0) * row[3] / (norm(direction) or 1.0)


# --- Points: JSON, arrays and CSV.


def _of_json(name: str, text: str, options: _Options) -> Skeleton:
    """Return the skeleton of `{"times": …, "landmarks": …}`; a frame without landmarks is unknown."""
    document = read_json(name, text)
    frames = document.get("landmarks") if isinstance(document, dict) else None
    if not isinstance(frames, list) or not all(frame is None or isinstance(frame, list) for frame in frames):
        raise BadInputFile(name, 'expected {"times": [s, …], "landmarks": [[[x, y, z, visibility], …], …]}')
    count = max((len(frame) for frame in frames if frame), default=0)
    rows = np.tile([math.nan, math.nan, math.nan, 0.0], (len(frames), count, 1))
    for n, frame in enumerate(frames):
        if frame and len(frame) != count:
            raise BadInputFile(name, f"landmarks[{n}] has {len(frame)} points, another frame has {count}")
        for k, entry in enumerate(frame or ()):
            rows[n, k] = _landmark(name, entry, f"landmarks[{n}][{k}]")
    return _of_array(name, rows, document.get("times"), options)


def _landmark(name: str, entry: Any, where: str) -> list[float]:
    """Return x, y, z and the confidence of a landmark: a list, or an object as MediaPipe prints it."""
    values = entry
    if isinstance(entry, dict):
        values = [entry.get(key) for key in "xyz"] + [entry[key] for key in ("visibility",) if key in entry]
    if isinstance(values, list) and len(values) in (3, 4):
        numbers = [math.nan if value in (None, "NaN") else value for value in values]
        if all(value != value or is_finite_number(value) for value in numbers):
            return numbers if len(numbers) == 4 else [*numbers, 1.0]
    flat = "; two coordinates give no directions" if isinstance(values, list) and len(values) == 2 else ""
    raise BadInputFile(name, f"{where}: expected [x, y, z] or [x, y, z, visibility], got {described(entry)}{flat}")


def _of_arrays(name: str, data: bytes, options: _Options) -> Skeleton:
    """Return the skeleton in a .npy or .npz file, without unpickling anything."""
    if not data.startswith(b"PK"):
        return _of_array(name, read_arrays(name, data)[""], None, options)
    amass = read_arrays(name, data, ("poses", "trans", "mocap_framerate", "mocap_frame_rate"))
    if "poses" in amass:
        return _of_amass(name, amass, options)
    arrays = read_arrays(name, data)
    times = arrays.pop("times", None)
    points = [key for key, array in arrays.items() if array.ndim == 3]
    if len(points) != 1:
        listed = abbreviated(", ".join(f"{key} {array.shape}" for key, array in arrays.items()) or "none")
        raise BadInputFile(name, f"expected one array of points (n, k, 3 or 4), or poses of AMASS; arrays: {listed}")
    return _of_array(name, arrays[points[0]], times, options)


def _of_array(name: str, array: Any, times: Any, options: _Options) -> Skeleton:
    """Return the skeleton of points in the order of a source, which their number and their bones show."""
    count = array.shape[-2] if array.ndim > 1 else 0
    fitting = [naming for naming in NAMINGS.values() if naming.order_of(count)]
    if options.source is not None:
        naming, notes = NAMINGS[options.source], list[str]()
    elif fitting:
        given = landmark_array(array, fitting[0])
        refuse_plane(by_joint(given, fitting[0])[0])
        orders = {naming.name: _Ordered(naming, *by_joint(given, naming)) for naming in fitting}
        (naming, *_), *notes = _person_among(f"{count} points", orders, "source= (--source)")
    else:
        known = ", ".join(f"{naming.name} ({len(order)})" for naming in NAMINGS.values() for order in naming.orders)
        raise BadArgument(f"{count} points: no source has as many; points of each: {known}; state source= (--source)")
    if options.names is not None:
        raise BadArgument(f"names= is for joints with names; an array has the order of {naming.name}")
    array = landmark_array(array, naming)
    seconds, noted = _seconds(name, options, len(array), times)
    return of_landmarks(array, naming, times=seconds, units=options.units, up=options.up, notes=(*noted, *notes))


class _Ordered(NamedTuple):
    """Points without names, which have those of a source if they are in its order."""

    naming: Naming
    joints: Mapping[str, Floats]
    confidence: Mapping[str, Floats]

    def doubt(self) -> str:
        """Return why these points are not those of a person; empty if nothing speaks against it."""
        try:
            points, sure = named_points(self.joints, self.naming, self.confidence)
            check_points(points)
        except BadArgument as error:
            return str(error)
        return doubt_of(points, sure)


def _person_among(what: str, orders: Mapping[str, _Ordered], advice: str) -> tuple[_Ordered, str]:
    """Return the only order in which points are those of a person, and a note on it.

    Raises BadArgument if there is none, or more than one.
    """
    doubts = {label: order.doubt() for label, order in orders.items()}
    fitting = [label for label, doubt in doubts.items() if not doubt]
    if len(fitting) == 1:
        others = [label for label in orders if label not in fitting]
        shown = f"by the lengths of bones, not {' or '.join(others)}" if others else "by their number"
        return orders[fitting[0]], f"{what} in the order of {fitting[0]}, {shown}"
    why = f", but {next(iter(doubts.values()))}" if not fitting else ""
    raise BadArgument(f"{what}: {' or '.join(fitting or orders)}{why}; state {advice}")


# A column of a coordinate or a confidence: SpineBase_X, left_wrist.y, left_wrist_visibility; or z11, v_11.
_CONFIDENCE = ("trackingstate", "visibility", "confidence", "state", "score", "v")  # longer ones before their ends
_NUMBERED = re.compile(rf"(?P<what>[xyz]|{'|'.join(_CONFIDENCE)})[\s_.:-]*(?P<joint>\d+)", re.IGNORECASE)
_SIGNS = " \t_.:-"
# Words around the name of a joint.
_AROUND = re.compile(r"K4ABT_JOINT_|JointType_|landmark|[\s_.:-]position", re.IGNORECASE)


def _column(heading: str) -> tuple[str, str]:
    """Return joint and "x", "y", "z" or "v" of a heading, or two empty texts."""
    match = _NUMBERED.fullmatch(heading)
    if match is not None:
        joint, what = match["joint"], match["what"].lower()
    else:
        what = next((end for end in (*_CONFIDENCE, *"xyz") if heading.lower().endswith(end)), "")
        joint = heading[: len(heading) - len(what)].rstrip(_SIGNS)
        if not what or not joint:
            return "", ""
    return _AROUND.sub("", joint), what if what in "xyz" else "v"


def _numbered(
    joints: Mapping[str, Floats], confidence: Mapping[str, Floats], options: _Options
) -> tuple[_Ordered, list[str]] | None:
    """Return points with numbers in the order of a source, and a note on it; None unless there are some.

    The order is that of a source with as many points, or of MediaPipe, counted from 0 or from 1. If the numbers allow
    several, the lengths of bones decide.
    """
    at = {int(key_of(joint)): joint for joint in joints if re.fullmatch("[0-9]{1,3}", key_of(joint))}
    if not at or any(key_of(part).isdecimal() for text in (options.names or {}).values() for part in text.split("+")):
        return None
    orders = {}
    for naming in NAMINGS.values():
        for order, first in itertools.product(naming.orders, (0, 1)):
            whole = sorted(at) == [*range(first, first + len(order))]
            part = naming.name == (options.source or "mediapipe") and first <= min(at) and max(at) < first + len(order)
            if options.source in (None, naming.name) and (whole or part):
                orders[f"{naming.name}, counted from {first}"] = _Ordered(
                    naming,
                    *(
                        {order[k - first]: a[joint] for k, joint in at.items() if joint in a}
                        for a in (joints, confidence)
                    ),
                )
    if not orders:
        return None
    what, advice = f"{len(at)} numbered points", "source= (--source), or names= (--names) such as left_shoulder=11"
    if options.source and len(orders) == 1:
        return next(iter(orders.values())), [f"{what} in the order of {next(iter(orders))}"]
    ordered, note = _person_among(what, orders, advice)
    return ordered, [note]


def _of_csv(name: str, data: bytes, options: _Options) -> Skeleton:
    """Return the skeleton in a table with a column for each coordinate of each joint."""

    def units_of(_: str, heading: str, __: int) -> Sequence[str]:
        return ("", *UNITS) if _column(heading)[0] else ()

    def understood(head: CsvHead) -> TableColumns:
        def error(reason: str, place: int) -> BadInputFile:
            return BadInputFile(name, reason, head.line, place + 1)

        table, _ = TableColumns.of(head.fields, (), units_of, error)
        known = {_column(heading) for heading in table.names}
        if not any({(joint, "y"), (joint, "z")} <= known for joint, what in known if what == "x"):
            flat = any((joint, "y") in known for joint, what in known if what == "x")
            reason = "only x and y: two coordinates give no directions" if flat else "no columns such as left_wrist_x"
            raise BadInputFile(name, f"{reason}; expected columns x, y and z of each point")
        return replace(table, gaps=True)

    table, rows, _ = read_csv(name, data, understood, _CONTENTS)
    values, times = table.split(rows)
    columns: dict[str, dict[str, Floats]] = {}
    for heading, column in zip(table.names, values.T, strict=True):
        joint, what = _column(heading)
        columns.setdefault(joint, {})[what] = column
    joints = {joint: np.stack([c["x"], c["y"], c["z"]], 1) for joint, c in columns.items() if {*"xyz"} <= c.keys()}
    if not len(rows):
        raise BadInputFile(name, "a header and no rows")
    refuse_plane(joints)
    stated = {unit for unit in table.units if unit}
    if len(stated) > 1:
        raise BadInputFile(name, f"columns in different units: {', '.join(sorted(stated))}")
    advice = "a heading such as time [s], or rate= (--rate), says otherwise"
    seconds, noted = _seconds(name, options, len(rows), times, table.time_unit, advice)
    confidence = {joint: columns[joint]["v"] for joint in joints if "v" in columns[joint]}
    numbered = _numbered(joints, confidence, options)
    if numbered is None:
        naming, notes = options.naming(list(joints))
    else:
        ordered, notes = numbered
        joints, confidence = {**ordered.joints}, {**ordered.confidence}
        naming = with_names(ordered.naming, options.names, list(joints))
    return assembled(
        seconds,
        joints,
        naming,
        confidence,
        units=options.units or next(iter(stated), None),
        up=options.up,
        notes=(*noted, *notes),
    )
