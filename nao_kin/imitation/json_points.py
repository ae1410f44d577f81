"""Points of a person in JSON, however a program nests frames, people and coordinates.

A point is [x, y, z], [x, y, z, confidence] or an object with x, y and z; a frame is a list of points, a flat list of
their numbers, or an object name → point, under one of `_FRAMES` or `_PEOPLE`, of which the first person is taken.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.files import described, is_finite_number, read_json
from nao_kin.errors import BadInputFile
from nao_kin.imitation.layouts import by_order, key_of
from nao_kin.imitation.reading import Options, of_array, skeleton_of
from nao_kin.imitation.skeleton import Points, Skeleton

# Keys of the points of a frame, those in metres first: MediaPipe, tf.js, OpenPose, EasyMocap, Azure Kinect.
_POINTS = (
    *("poseworldlandmarks", "worldlandmarks", "keypoints3d", "posekeypoints3d", "jointpositions", "joints3d"),
    *("landmarks", "landmark", "poselandmarks", "keypoints", "points", "joints", "pose"),
)
_PEOPLE = ("people", "bodies", "persons", "poses")
_FRAMES = ("frames", "data", "results")
_TIMES = ("times", "timestamps", "timestamp", "time", "t", "timestampms", "timestampusec", "timems")
_RATES = ("fps", "rate", "framerate")
_CONFIDENCE = ("visibility", "score", "confidence", "confidencelevel", "c", "trackingstate")
_UNKNOWN = [math.nan] * 4
_EXPECTED = 'expected {"times": [s, …], "landmarks": [[[x, y, z, visibility], …], …]}, or a list of frames'


def _by_key(value: Any) -> dict[str, Any]:
    return {key_of(key): entry for key, entry in value.items()} if isinstance(value, dict) else {}


def _first(keyed: Mapping[str, Any], keys: Sequence[str]) -> Any:
    return next((keyed[key] for key in keys if key in keyed), None)


def of_json(name: str, texts: Sequence[str], options: Options) -> Skeleton:
    """Return the skeleton of a JSON document, or of one document for each frame; a frame without points is unknown."""
    documents = [read_json(name, text) for text in texts]
    document = documents[0] if len(documents) == 1 else documents
    keyed = _by_key(document)
    times, rate = _first(keyed, _TIMES), _first(keyed, _RATES)
    frames = document if isinstance(document, list) else _first(keyed, (*_FRAMES, *_POINTS))
    if not isinstance(frames, list) or not all(entry is None or isinstance(entry, (list, dict)) for entry in frames):
        raise BadInputFile(name, _EXPECTED)
    stamps = [_first(_by_key(frame), _TIMES) for frame in frames]
    if times is None and any(stamp is not None for stamp in stamps):
        times = stamps
    elif times is None and is_finite_number(rate) and rate > 0.0:
        times = [k / rate for k in range(len(frames))]
    notes: set[str] = set()
    found = [_points_of(name, frame, f"landmarks[{n}]", notes) for n, frame in enumerate(frames)]
    names = tuple(dict.fromkeys(joint for own, _ in found for joint in own))
    by_name = (dict(zip(own, points, strict=True)) for own, points in found if names)
    rows = _stacked(name, [[at.get(joint, _UNKNOWN) for joint in names] for at in by_name] or [at for _, at in found])
    if np.isnan(rows[..., 3]).all():  # no point has a confidence
        rows = rows[..., :3]
    if not names:
        return of_array(name, rows, options, notes=sorted(notes), times=times)
    points = Points(*by_order(rows, names), times=times, notes=tuple(sorted(notes)))
    return skeleton_of(name, options.named(points), options)


def _stacked(name: str, frames: Sequence[list[list[float]]]) -> Floats:
    count = max(map(len, frames), default=0)
    rows = np.full((len(frames), count, 4), math.nan)
    for n, frame in enumerate(frames):
        if frame and len(frame) != count:
            raise BadInputFile(name, f"landmarks[{n}] has {len(frame)} points, another frame has {count}")
        if frame:
            rows[n] = frame
    return rows


def _points_of(name: str, frame: Any, where: str, notes: set[str]) -> tuple[tuple[str, ...], list[list[float]]]:
    """Return the names of the points of a frame, none if they have only an order, and x, y, z and confidence."""
    keyed = _by_key(frame)
    if keyed:
        if keyed.get("posekeypoints2d") and not keyed.get("posekeypoints3d"):
            raise BadInputFile(name, f"{where}: pose_keypoints_2d alone; two coordinates give no directions")
        inside = _first(keyed, (*_PEOPLE, *_POINTS))
        if inside is not None:
            return _points_of(name, inside, where, notes)
        points = {joint: point for joint, point in frame.items() if isinstance(point, (dict, list))}
        return tuple(points), [_point(name, point, f"{where}.{joint}") for joint, point in points.items()]
    if not isinstance(frame, list) or not frame:
        return (), []
    if all(isinstance(entry, (int, float)) for entry in frame):  # x, y, z, confidence of all points in a row
        width = 4 if len(frame) % 4 == 0 else 3
        frame = [frame[k : k + width] for k in range(0, len(frame), width)]
    if _people(frame):
        if len(frame) > 1:
            notes.add("several people: the first one of each frame is taken")
        return _points_of(name, frame[0], where, notes)
    names = [_by_key(entry).get("name") for entry in frame]
    rows = [_point(name, entry, f"{where}[{k}]") for k, entry in enumerate(frame)]
    return tuple(map(str, names)) if all(names) else (), rows


def _people(frame: list[Any]) -> bool:
    """Return whether a list contains people, rather than points."""
    first = frame[0]
    if isinstance(first, dict):
        return any(key in _by_key(first) for key in (*_PEOPLE, *_POINTS, "posekeypoints2d"))
    return isinstance(first, list) and bool(first) and isinstance(first[0], (list, dict))


def _point(name: str, entry: Any, where: str) -> list[float]:
    """Return x, y, z and the confidence of a point: a list, or an object as MediaPipe prints it."""
    values = entry
    if isinstance(entry, dict):
        keyed = _by_key(entry)
        keyed = _by_key(keyed["position"]) | keyed if isinstance(keyed.get("position"), dict) else keyed
        sure = _first(keyed, _CONFIDENCE)
        values = [keyed.get(key) for key in "xyz"] + ([] if sure is None else [sure])
    if isinstance(values, list) and len(values) in (3, 4):
        numbers = [math.nan if value in (None, "NaN") else value for value in values]
        if all(value != value or is_finite_number(value) for value in numbers):
            return numbers if len(numbers) == 4 else [*numbers, math.nan]
    flat = "; two coordinates give no directions" if isinstance(values, list) and len(values) == 2 else ""
    raise BadInputFile(name, f"{where}: expected [x, y, z] or [x, y, z, visibility], got {described(entry)}{flat}")
