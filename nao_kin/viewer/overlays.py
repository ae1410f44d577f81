"""The messages of the overlays, with arguments checked here so that the page can trust them.

Arguments and errors are those of the methods of `Viewer`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from threading import RLock
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    COLD_TO_WARM,
    Floats,
    as_floats,
    as_numbers,
    choice,
    flag,
    norm,
    shaped,
    unit,
    whole_number,
)
from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.motion import Motion
from nao_kin.reach import ReachMap
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import Cylinder, Sphere, UnreadableShape
from nao_kin.rotations import quat_from_matrix, quat_to_xyzw, quat_unwrap, rotation_between
from nao_kin.viewer.cubics import cubics
from nao_kin.viewer.meshes import Mesh, Shape, load_meshes, mesh_of
from nao_kin.viewer.messages import (
    RetainedMessages,
    geometry_document,
    hex_colour,
    packed,
    panel_message,
    track,
    typed_array,
)

# Quantity of a voxel → its name in the legend.
REACH_LABELS = {
    "best": "best manipulability",
    "mean": "mean manipulability",
    "count": "samples",
    "coverage": "share of directions",
}
# A browser without a graphics card can still rotate this many cubes.
_MAX_CUBES = 40_000
# A figure: its colour, the radius of a bone, and the size of one that is not seen [m].
_FIGURE, _BONE, _NOTHING = (0.35, 0.55, 0.8), 0.008, 1e-5


def number(value: ArrayLike, what: str) -> float:
    """Return `value` as one finite number."""
    return float(shaped(value, (), what))


def seconds(timeout: ArrayLike) -> float:
    """Return a time to wait, 0 or more."""
    found = number(timeout, "timeout")
    if found < 0.0:
        raise BadArgument(f"timeout must be 0 s or more, got {found:g}")
    return found


def positive(value: ArrayLike, what: str, largest: float = np.inf) -> float:
    """Return `value`, above 0 and at most `largest`."""
    found = number(value, what)
    if not 0.0 < found <= largest:
        limit = "" if largest == np.inf else f" and at most {largest:g}"
        raise BadArgument(f"{what} must be above 0{limit}, got {found:g}")
    return found


def checked_opacity(opacity: float) -> float:
    """Return `opacity`, above 0 and at most 1."""
    return positive(opacity, "opacity", 1.0)


def direction(value: ArrayLike, what: str) -> list[float]:
    """Return `value` as a unit vector."""
    found: list[float] = unit(shaped(value, (3,), what), what)[0].tolist()
    return found


def directions(value: ArrayLike, what: str, count: int) -> Floats:
    """Return one direction for all or one for each as unit vectors, shape (count, 3)."""
    vectors = as_floats(value, (3,), what)
    if vectors.shape not in ((3,), (count, 3)):
        raise WrongShape(what, f"(3,) or ({count}, 3)", vectors.shape)
    return np.broadcast_to(unit(vectors, what)[0], (count, 3))


def one_configuration(robot: RobotModel, q: ArrayLike) -> Floats:
    """Return `q` as a new array of shape (nq,)."""
    array = np.array(robot.checked(q))
    if array.ndim != 1:
        raise WrongShape("q", f"({robot.nq},)", array.shape)
    return array


def clip(robot: RobotModel, qs: ArrayLike | Motion, fps: float, missing: str | ArrayLike) -> tuple[Floats, float]:
    """Return configurations to play as a new array (n, nq), and their number per second."""
    rate = positive(fps, "fps")
    if isinstance(qs, Motion):
        qs = qs.configurations(robot, rate=rate, missing=missing).q
    array = np.array(robot.checked(as_floats(qs, (robot.nq,), "qs")))
    if array.ndim != 2 or len(array) == 0:
        raise WrongShape("qs", f"(n, {robot.nq}) with n ≥ 1", array.shape)
    return array, rate


def curves(robot: RobotModel, qs: Floats | Motion, fps: float, missing: str | ArrayLike) -> dict[str, Any]:
    """Return the times and configurations of a clip for a page, and the curves of a motion that has them."""
    found = cubics(qs, robot, missing) if isinstance(qs, Motion) else None
    if found is None:
        rows = clip(robot, qs, fps, missing)[0].astype(np.float32)
        return {"times": typed_array(np.arange(len(rows)) / fps), "q": typed_array(rows.reshape(-1)), "handles": None}
    handles = None if found.handles is None else typed_array(found.handles.reshape(-1))
    return {"times": typed_array(found.times), "q": typed_array(found.q.reshape(-1)), "handles": handles}


def margins(
    robot: RobotModel, qs: Floats | Motion, fps: float, missing: str | ArrayLike
) -> tuple[Floats, dict[str, Floats]]:
    """Return times from the beginning of a clip [s], and the margins of its balance then [mm]."""
    motion = qs
    if not isinstance(motion, Motion):
        motion = Motion(np.arange(len(motion)) / fps, robot.joint_names, motion[:, robot.nq_base :])
    found = motion.balance(robot, missing=missing)
    times = (found.times - motion.start).round(9)
    during = (times >= 0.0) & (times <= round(motion.duration, 9))
    lines = {"margin": found.margin, "centre-of-mass margin": found.com_margin}
    return times[during], {
        name: np.where(np.isfinite(line), 1e3 * line, np.nan)[during] for name, line in lines.items()
    }


def frame_names(robot: RobotModel, names: Iterable[str]) -> list[str]:
    """Return the frames to draw."""
    return [choice(name, robot.frame_names, "frame") for name in ([names] if isinstance(names, str) else names)]


def ghosts(robot: RobotModel, configurations: ArrayLike, opacity: float, first: int) -> bytes:
    """Return the message that draws ghosts; those of several configurations are numbered."""
    array = as_floats(configurations, (robot.nq,), "configurations")
    if array.ndim not in (1, 2):
        raise WrongShape("configurations", f"({robot.nq},) or (k, {robot.nq})", array.shape)
    numbered_from = whole_number(first, "first", 0) if array.ndim == 2 else None
    array = robot.checked(np.atleast_2d(array))
    content = {"qs": typed_array(array.reshape(-1)), "count": len(array), "first": numbered_from}
    return panel_message("ghosts", content | {"opacity": checked_opacity(opacity)})


def reach(robot: RobotModel, found: ReachMap | None, by: str, cut: tuple[str, float] | None) -> bytes:
    """Return the message that draws voxels in the colours of a scale, up to a plane."""
    if found is None:
        return panel_message("reach", {"cells": None})
    settings = found.settings
    if settings.robot != robot.name:
        raise BadArgument(f"the reach map is of {abbreviated(settings.robot)}, and the viewer shows {robot.name}")
    if settings.reference not in robot.frame_names:
        raise UnknownName("frame", settings.reference, robot.frame_names)
    if len(found.count) == 0:
        raise BadArgument("the reach map is empty: nothing to show")
    factor = max(1, round((len(found.count) / _MAX_CUBES) ** (1 / 3)))
    while len((shown := found.coarser(factor)).count) > _MAX_CUBES or np.ptp(shown.indices, axis=0).max() > 0xFFFF:
        factor += 1
    values, first = shown.column(by), shown.indices.min(axis=0)
    low, high = float(values.min()), float(values.max())
    cubic = by in ("best", "mean") and all(robot.unit(joint) == "rad" for joint in settings.joints)
    digits = max(0, 2 - math.floor(math.log10(high))) if high > 0.0 and by != "count" else 0
    share = (values - low) / (high - low) if high > low else np.zeros(len(values))
    content = {
        "frame": settings.reference,
        "voxel": shown.voxel,
        "first": first.tolist(),
        "cells": typed_array((shown.indices - first).astype(np.uint16).reshape(-1)),
        "values": typed_array(np.round(0xFFFF * share).astype(np.uint16)),
        "stops": COLD_TO_WARM,
        "label": f"{settings.frame}: {REACH_LABELS[by]}{' [m³]' if cubic else ''}",
        "low": f"{low:.{digits}f}",
        "high": f"{high:.{digits}f}",
        "cut": None if cut is None else {"axis": choice(cut[0], tuple("xyz"), "axis"), "place": number(cut[1], "cut")},
    }
    return panel_message("reach", content)


# --- Points, meshes and lines that are not part of a robot, as the fields of messages.

_LONGEST_NAME = 200
_BLUE = (0.15, 0.39, 0.92)


def checked_name(name: str) -> str:
    """Return `name` if a shape may have it."""
    if not name or len(name) > _LONGEST_NAME:
        raise BadArgument(f"name must be 1 to {_LONGEST_NAME} characters, got {quoted(name)}")
    packed(name)  # refuses names that cannot be sent
    return name


def points(array: ArrayLike, colours: ArrayLike | None, size: float) -> dict[str, Any]:
    """Return the fields of a cloud of points."""
    rows = _positions(array, "points")
    content = {"positions": _floats(rows), "size": positive(size, "size"), "colour": _BLUE, "colours": None}
    if colours is None:
        return content
    rgb = as_floats(colours, (3,), "colours")
    if rgb.shape not in ((3,), rows.shape):
        raise WrongShape("colours", f"(3,) or {rows.shape}", rgb.shape)
    _check_colours(rgb, "colours")
    if rgb.ndim == 1:
        return content | {"colour": rgb.tolist()}
    return content | {"colours": typed_array(np.round(255.0 * rgb).astype(np.uint8).reshape(-1))}


def mesh(
    shape: ArrayLike | Path | str, faces: ArrayLike | None, colour: ArrayLike | None, opacity: float
) -> dict[str, Any]:
    """Return the fields of a surface of triangles, from arrays or from a file."""
    if isinstance(shape, (str, Path)):
        if faces is not None:
            raise BadArgument("a mesh is a file, or vertices and faces; got a file and faces")
        parts: Iterable[Mesh] = _read(Path(shape))
    else:
        if faces is None:
            raise BadArgument("a mesh of vertices needs its faces, shape (m, 3)")
        parts = (_built(shape, faces),)
    share = checked_opacity(opacity)
    own = None if colour is None else one_colour(colour)
    documents = [
        {"geometry": geometry_document(part), "colour": own or (part.colour or (*_BLUE, 1.0))[:3], "opacity": share}
        for part in parts
    ]
    return {"parts": documents}


def line(array: ArrayLike, colour: ArrayLike | None, width: float) -> dict[str, Any]:
    """Return the fields of a round line through points."""
    rows = _positions(array, "points")
    if len(rows) < 2:
        raise WrongShape("points", "(n, 3) with n ≥ 2", rows.shape)
    rgb = _BLUE if colour is None else one_colour(colour)
    return {"positions": _floats(rows), "colour": rgb, "width": positive(width, "width")}


def arrow(start: ArrayLike, end: ArrayLike, colour: ArrayLike | None, width: float) -> dict[str, Any]:
    """Return the fields of an arrow."""
    return line(np.stack([shaped(start, (3,), "start"), shaped(end, (3,), "end")]), colour, width)


def label(text: str, place: ArrayLike) -> dict[str, Any]:
    """Return the fields of a text at a place."""
    if not text.strip() or len(text) > _LONGEST_NAME:
        raise BadArgument(f"text must be 1 to {_LONGEST_NAME} characters, got {quoted(text)}")
    return {"text": text, "positions": _floats(shaped(place, (3,), "place"))}


def figure(bones: ArrayLike, count: int, fps: float) -> dict[str, Any]:
    """Return a figure of bones, and the clip that moves it through its `count` places, as three.js reads them.

    A bone is a rod of unit length along y, placed, turned and stretched, with balls at both ends. Where an end is
    unknown (NaN), the bone shrinks to nothing.
    """
    ends = as_floats(bones, (2, 3), "figure", gaps=True)
    if ends.ndim != 4 or len(ends) != count or not ends.shape[1]:
        raise WrongShape("figure", f"({count}, bones, 2, 3)", ends.shape)
    known = np.asarray(np.isfinite(ends).all(axis=(-1, -2)))
    ends = np.where(known[..., None, None], ends, 0.0)
    across = ends[..., 1, :] - ends[..., 0, :]
    length = np.maximum(norm(across), _NOTHING)
    y = np.array([0.0, 1.0, 0.0])
    turns = quat_from_matrix(rotation_between(y, np.where((length > _NOTHING)[..., None], across, y)))
    shapes: dict[str, Shape] = {"rod": Cylinder(_BONE, 1.0), "start": Sphere(1.5 * _BONE), "end": Sphere(1.5 * _BONE)}
    material = {"uuid": "bone", "type": "MeshPhongMaterial", "color": hex_colour((*_FIGURE, 1.0))}
    children, tracks = [], list[dict[str, Any]]()
    for k in range(ends.shape[1]):
        size = np.where(known[:, k], 1.0, _NOTHING)
        parts = {"rod": ends[:, k].mean(axis=1), "start": ends[:, k, 0], "end": ends[:, k, 1]}
        for part, places in parts.items():
            children.append({"type": "Mesh", "name": f"{part}{k}", "geometry": part, "material": "bone"})
            tracks.append(track(f"{part}{k}.position", "vector", places))
            stretch = size * length[:, k] if part == "rod" else size
            tracks.append(track(f"{part}{k}.scale", "vector", np.stack([size, stretch, size], axis=1)))
        tracks.append(track(f"rod{k}.quaternion", "quaternion", quat_to_xyzw(quat_unwrap(turns[:, k]))))
    document = {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": [{"uuid": part, **geometry_document(shape)} for part, shape in shapes.items()],
        "materials": [material],
        "object": {"type": "Group", "children": children},
    }
    return {"object": document, "clip": {"fps": fps, "name": "figure", "tracks": tracks}}


def one_colour(colour: ArrayLike, what: str = "color") -> list[float]:
    """Return `colour` as red, green and blue from 0 to 1."""
    rgb = shaped(colour, (3,), what)
    _check_colours(rgb, what)
    found: list[float] = rgb.tolist()
    return found


def _check_colours(rgb: Floats, what: str) -> None:
    if rgb.size and not (rgb.min() >= 0.0 and rgb.max() <= 1.0):
        raise BadArgument(f"{what} must be red, green and blue from 0 to 1, got {rgb.min():g} to {rgb.max():g}")


def _positions(array: ArrayLike, what: str) -> Floats:
    rows = as_floats(array, (3,), what)
    if rows.ndim != 2:
        raise WrongShape(what, "(n, 3)", rows.shape)
    return rows


def _built(vertices: ArrayLike, faces: ArrayLike) -> Mesh:
    rows = _positions(vertices, "vertices")
    corners = as_numbers(faces, "faces")
    if corners.ndim != 2 or corners.shape[1] != 3 or len(corners) == 0:
        raise WrongShape("faces", "(m, 3) with m ≥ 1", corners.shape)
    if not np.isin(corners % 1.0, 0.0).all() or corners.min() < 0 or corners.max() >= len(rows):
        raise BadArgument(f"faces must be whole numbers from 0 to {len(rows) - 1}, the indices of their corners")
    triangles: NDArray[np.uint32] = corners.astype(np.uint32)
    try:
        return mesh_of(rows, triangles)
    except UnreadableShape as reason:
        raise BadArgument(f"the mesh cannot be drawn: {reason}") from None


def _read(path: Path) -> tuple[Mesh, ...]:
    try:
        return load_meshes(path, np.ones(3))
    except UnreadableShape as reason:
        raise BadArgument(f"{abbreviated(path)} is not a mesh that can be drawn: {abbreviated(reason)}") from None


def _floats(rows: Floats) -> Any:
    return typed_array(rows.astype(np.float32).reshape(-1))


# --- Buttons of the page.


# Initial state of the page's buttons.
SHOWN = dict.fromkeys(("frames", "axes", "com", "support", "collisions"), False) | {"ghosts": True, "handles": True}
# All buttons; those that are not in `SHOWN` begin as each page decides.
BUTTONS = (
    *("frames", "axes", "chains", "com", "support", "shapes", "inertia", "collisions"),
    *("ghosts", "together", "eye", "orthographic", "contrast", "handles"),
)
# Limits of a page's message on buttons: their number, and the length of their names.
_MAX_SHOWN = 64
_LONGEST_BUTTON = 40


class Buttons:
    """The state of the page's buttons, shared by all pages: `shown`, name → whether it is on."""

    def __init__(self, messages: RetainedMessages, lock: RLock) -> None:
        self._messages, self._lock = messages, lock
        self.shown = dict(SHOWN)

    def press(self, what: str, on: bool, source: str = "") -> None:
        """Set a button; `source` is the page in which it was pressed."""
        message = panel_message("shown", {"shown": {what: flag(on, "on")}, "source": source})
        with self._lock:
            self.shown[what] = bool(on)
            self._messages.put(f"shown {what}", message)

    def draw(self, what: str, message: bytes, *, on: bool) -> None:
        """Put a message that draws an overlay and sets its button; drop the older message of the button."""
        with self._lock:
            self._messages.put(what, message)
            self.shown[what] = on
            self._messages.drop(f"shown {what}")

    def receive(self, shown: object, source: str) -> None:
        """Set the state of the buttons from a page."""
        for what, on in list(shown.items())[:_MAX_SHOWN] if isinstance(shown, dict) else ():
            may_begin = len(self.shown) < _MAX_SHOWN and 0 < len(what) <= _LONGEST_BUTTON and what.isprintable()
            if (what in self.shown or may_begin) and isinstance(on, bool) and self.shown.get(what) is not on:
                self.press(what, on, source)
