"""What is drawn over the robot, as messages: checked here, so that the page can trust them.

Arguments and errors are those of the methods of `Viewer`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import COLD_TO_WARM, Floats, as_floats, as_numbers, as_vectors, choice, unit, whole_number
from nao_kin._core.arrays import colours as scale_colours
from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.motion import Hips, Motion
from nao_kin.reach import ReachMap
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import UnreadableShape
from nao_kin.rotations import check_rotation
from nao_kin.viewer.meshes import Mesh, load_meshes, mesh_of
from nao_kin.viewer.messages import mesh_document, panel_message, typed_array

# What the numbers of a voxel are called in the legend.
REACH_LABELS = {
    "best": "best manipulability",
    "mean": "mean manipulability",
    "count": "samples",
    "coverage": "share of directions",
}
# A browser without a graphics card still turns so many cubes.
_MOST_CUBES = 40_000
_MOST_GHOSTS = 64
_LARGEST_FIRST = 1_000_000
# The colours that NAO's shells were sold in.
EDITIONS = ("orange", "blue", "red", "grey")
# Further out a double keeps an angle to 1e-10 rad no longer, and a graphics card, which computes in floats, draws
# nothing that is still a robot.
LARGEST = 1e6
# Further away [m] it draws nothing that keeps its shape.
FARTHEST = 1e4


def number(value: ArrayLike, what: str) -> float:
    """`value` as one finite number.

    Raises:
        BadArgument, WrongShape, NotFinite: it is none.
    """
    array = as_floats(value, (), what)
    if array.shape != ():
        raise WrongShape(what, "()", array.shape)
    return float(array)


def checked_opacity(opacity: float) -> float:
    """`opacity`, above 0 and at most 1.

    Raises:
        BadArgument, WrongShape, NotFinite: it is none.
    """
    share = number(opacity, "opacity")
    if not 0.0 < share <= 1.0:
        raise BadArgument(f"opacity must be above 0 and at most 1, got {share:g}")
    return share


def checked_length(value: ArrayLike, what: str) -> float:
    """`value`, a size that can be drawn [m].

    Raises:
        BadArgument, WrongShape, NotFinite: it is none.
    """
    length = number(value, what)
    if not 0.0 < length <= FARTHEST:
        raise BadArgument(f"{what} must be above 0 and at most {FARTHEST:g} m, got {length:g}")
    return length


def direction(value: ArrayLike, what: str) -> list[float]:
    """`value` as a unit vector.

    Raises:
        BadArgument, WrongShape, NotFinite, ZeroNorm: it is none.
    """
    vector = as_vectors(value, what)
    if vector.shape != (3,):
        raise WrongShape(what, "(3,)", vector.shape)
    return [float(component) for component in unit(vector, what)[0]]


def directions(value: ArrayLike, what: str, count: int) -> Floats:
    """`value`, one direction for all or one for each, as `count` unit vectors, shape (count, 3).

    Raises:
        BadArgument, WrongShape, NotFinite, ZeroNorm: it is none.
    """
    vectors = as_vectors(value, what)
    if vectors.shape not in ((3,), (count, 3)):
        raise WrongShape(what, f"(3,) or ({count}, 3)", vectors.shape)
    return np.broadcast_to(unit(vectors, what)[0], (count, 3))


def blanks(robot: RobotModel) -> dict[str, bytes]:
    """Under the key of each message that draws something, the one that takes it away."""
    return {
        "clip": panel_message("still", {}),
        "ghosts": ghosts(robot, np.zeros((0, robot.nq)), 1.0, 1),
        "targets": targets({}),
        "colours": colours({}, {}, {}, None, None, ""),
        "edition": edition(""),
        "reach": reach(robot, None, "best", None),
        "lights": lights((), {}, {}),
        "speech": speech(""),
        "robots": panel_message("robots", {"robots": []}),
        "extras": panel_message("extras", {"names": []}),
    }


def one_configuration(robot: RobotModel, q: ArrayLike) -> Floats:
    """`q` as a fresh array of shape (nq,).

    Raises:
        WrongShape, NotFinite, BadArgument: q is no configuration, or too large a one.
    """
    array = np.array(robot.checked(q))
    if array.ndim != 1:
        raise WrongShape("q", f"({robot.nq},)", array.shape)
    check_size(robot, array)
    return array


def clip(
    robot: RobotModel, qs: ArrayLike | Motion, fps: float, fill: str | ArrayLike, hips: Hips
) -> tuple[Floats, float]:
    """Configurations to play, as a fresh array (n, nq), and how many of them in a second.

    Raises:
        WrongShape, NotFinite, BadArgument: qs are no configurations, or fps no positive number.
        UnknownName: a motion of joints that the robot does not have, no such posture, no such rule.
    """
    rate = number(fps, "fps")
    if rate <= 0.0:
        raise BadArgument(f"fps must be positive, got {rate:g}")
    if isinstance(qs, Motion):
        qs = qs.configurations(robot, rate=rate, fill=fill, hips=hips).q
    array = np.array(robot.checked(as_floats(qs, (robot.nq,), "qs")))
    if array.ndim != 2 or len(array) == 0:
        raise WrongShape("qs", f"(n, {robot.nq}) with n ≥ 1", array.shape)
    check_size(robot, array)
    return array, rate


def check_size(robot: RobotModel, qs: Floats) -> None:
    """Refuse configurations, shape (..., nq), with values beyond ±1e6 rad or m, which no page draws.

    They are not wrapped: q is what is shown, and a turn more or less is another q.

    Raises:
        BadArgument: there is one.
    """
    beyond = np.argwhere(np.abs(qs) > LARGEST)
    if len(beyond):
        column = int(beyond[0][-1]) - (robot.nq - len(robot.joint_names))
        name = robot.joint_names[column] if column >= 0 else "the base"
        value = float(qs[tuple(beyond[0])])
        raise BadArgument(f"{name} is {value:g}; values from {-LARGEST:g} to {LARGEST:g} rad or m are shown")


def frame_names(robot: RobotModel, names: Iterable[str]) -> list[str]:
    """The frames to draw.

    Raises:
        BadArgument: no names.
        UnknownName: no such frame.
    """
    if not isinstance(names, Iterable):
        raise BadArgument(f"show_frames takes frame names, got {quoted(names)}")
    chosen = [names] if isinstance(names, str) else list(names)
    return [choice(name, robot.frame_names, "frame") for name in chosen]


def frames(robot: RobotModel, names: Iterable[str], size: float | None) -> bytes:
    """Triads at frames."""
    chosen = frame_names(robot, names)
    length = None if size is None else checked_length(size, "size")
    return panel_message("frames", {"names": chosen, "size": length})


def ghosts(robot: RobotModel, configurations: ArrayLike, opacity: float, first: int) -> bytes:
    """Links in another configuration, or in several, which are numbered."""
    array = as_floats(configurations, (robot.nq,), "configurations")
    if array.ndim not in (1, 2):
        raise WrongShape("configurations", f"({robot.nq},) or (k, {robot.nq})", array.shape)
    numbered_from = whole_number(first, "first", 0, _LARGEST_FIRST) if array.ndim == 2 else None
    array = robot.checked(np.atleast_2d(array))
    check_size(robot, array)
    if len(array) > _MOST_GHOSTS:
        raise BadArgument(f"at most {_MOST_GHOSTS} ghosts are drawn, got {len(array)} configurations")
    share = checked_opacity(opacity)
    content = {"qs": typed_array(array.reshape(-1)), "count": len(array), "opacity": share}
    return panel_message("ghosts", {**content, "first": numbered_from})


def targets(poses: Mapping[str, ArrayLike]) -> bytes:
    """Marks at positions or poses in the robot's root frame."""
    if not isinstance(poses, Mapping):
        raise BadArgument(f"targets are a mapping from names to positions or poses, got {type(poses).__name__}")
    rows = []
    for name, target in poses.items():
        array = as_floats(target, (), f"target {name}")
        T = np.eye(4)
        if array.shape == (3,):
            T[:3, 3] = array
        elif array.shape == (4, 4):
            check_rotation(array[:3, :3])
            T[:3] = array[:3]
        else:
            raise WrongShape(f"target {name}", "(3,) or (4, 4)", array.shape)
        if np.abs(T).max() > LARGEST:
            raise BadArgument(f"target {abbreviated(name)} is {np.abs(T).max():g} m away; up to {LARGEST:g} m is shown")
        rows.append({"name": str(name), "matrix": T.T.reshape(-1).tolist(), "point": array.shape == (3,)})
    return panel_message("targets", {"targets": rows})


def reach(robot: RobotModel, found: ReachMap | None, by: str, cut: tuple[str, float] | None) -> bytes:
    """Voxels in the colours of a scale, behind a plane."""
    if found is None:
        return panel_message("reach", {"cells": None})
    if not isinstance(found, ReachMap):
        raise BadArgument(f"show_reach takes a reach map, got {type(found).__name__}")
    settings = found.settings
    if settings.robot != robot.name:
        raise BadArgument(f"the reach map is of {abbreviated(settings.robot)}, and the robot on show is {robot.name}")
    if settings.reference not in robot.frame_names:
        raise UnknownName("frame", settings.reference, robot.frame_names)
    if len(found.count) == 0:
        raise BadArgument("the reach map is empty: nothing to show")
    factor = max(1, round((len(found.count) / _MOST_CUBES) ** (1 / 3)))
    while len((shown := found.coarser(factor)).count) > _MOST_CUBES or np.ptp(shown.indices, axis=0).max() > 0xFFFF:
        factor += 1
    values, first = shown.column(by), shown.indices.min(axis=0)
    low, high = float(values.min()), float(values.max())
    share = (values - low) / (high - low) if high > low else np.zeros(len(values))
    content = {
        "frame": settings.reference,
        "voxel": shown.voxel,
        "first": first.tolist(),
        "cells": typed_array((shown.indices - first).astype(np.uint16).reshape(-1)),
        "values": typed_array(np.round(0xFFFF * share).astype(np.uint16)),
        "stops": COLD_TO_WARM,
        "label": f"{settings.frame}: {REACH_LABELS[by]}",
        "low": f"{low:.3g}",
        "high": f"{high:.3g}",
        "cut": None if cut is None else _plane(cut),
    }
    return panel_message("reach", content)


def lights(known: Sequence[str], groups: Mapping[str, tuple[str, ...]], values: Mapping[str, ArrayLike]) -> bytes:
    """Lights in colours of their own; a light that is named beside its group has its own."""
    if not isinstance(values, Mapping):
        raise BadArgument(f"lights are a mapping from names to colours, got {type(values).__name__}")
    rgb: dict[str, list[float]] = {}
    for name in sorted(values, key=lambda name: name not in groups):
        if name not in known:
            raise UnknownName("light", name, known)
        colour = as_floats(values[name], (), f"colour of {name}")
        if colour.shape != (3,):
            raise WrongShape(f"colour of {name}", "(3,)", colour.shape)
        if colour.min() < 0.0 or colour.max() > 1.0:
            raise BadArgument(f"colour of {name} must be red, green and blue from 0 to 1, got {colour.tolist()}")
        rgb |= dict.fromkeys(groups.get(name, (name,)), colour.tolist())
    return panel_message("lights", {"lights": [{"name": name, "rgb": colour} for name, colour in rgb.items()]})


def edition(name: str) -> bytes:
    """The accents of NAO's shells in the colour of an edition, or for "" in their own."""
    if not isinstance(name, str) or name:
        choice(name, EDITIONS, "edition")
    return panel_message("edition", {"name": name})


def speech(text: str) -> bytes:
    """A bubble with words."""
    if not isinstance(text, str):
        raise BadArgument(f"text must be words to show, got {quoted(text)}")
    return panel_message("speech", {"text": text})


def _plane(cut: tuple[str, float]) -> dict[str, Any]:
    if not isinstance(cut, (tuple, list)) or len(cut) != 2 or cut[0] not in ("x", "y", "z"):
        raise BadArgument(f"cut must be an axis, x, y or z, and a place on it, got {quoted(cut)}")
    return {"axis": cut[0], "place": number(cut[1], "cut")}


def colours(
    links: Mapping[str, int],
    carriers: Mapping[str, str],
    values: Mapping[str, float],
    low: float | None,
    high: float | None,
    label: str,
    robot: int = 0,
) -> bytes:
    """Links in the colours of a scale, with its legend.

    `robot` is the number of the robot, 0 for the viewer's own. `links` has the place of every link. `carriers` leads
    from a link without a shape to the link with one that it is fixed to, which shows its colour unless it has a value
    of its own.
    """
    if not isinstance(values, Mapping):
        raise BadArgument(f"colours are a mapping from link names to numbers, got {type(values).__name__}")
    for name in values:
        if name not in links:
            raise UnknownName("link", name, tuple(links))
    content: dict[str, Any] = {"robot": robot, "links": [], "label": str(label), "low": "", "high": "", "stops": None}
    if values:
        numbers = {name: number(value, f"value of {name}") for name, value in values.items()}
        bottom = min(numbers.values()) if low is None else number(low, "low")
        top = max(numbers.values()) if high is None else number(high, "high")
        if bottom == top and (low is None or high is None):
            bottom, top = (bottom - 0.5 if low is None else bottom), (top + 0.5 if high is None else top)
        if not bottom < top:
            raise BadArgument(f"the colour scale needs low < high, got {bottom:g} and {top:g}")
        rgb = {name: scale_colours(value, bottom, top).tolist() for name, value in numbers.items()}
        own = {carriers[name]: rgb[name] for name in numbers if name in carriers} | rgb
        content["links"] = [{"link": links[name], "rgb": own[name]} for name in own]
        content |= {"low": f"{bottom:.4g}", "high": f"{top:.4g}", "stops": COLD_TO_WARM}
    return panel_message("colours", content)


# --- Points, meshes and lines that are no part of a robot, as messages: checked here, so that the page can trust
# them.
#
# Arguments and errors are those of the methods of `Viewer`.

MOST = 1000
MOST_POINTS = 2_000_000
_MOST_CORNERS = 2_000_000
_MOST_LINE_POINTS = 100_000
_LONGEST_NAME = 200
_BLUE = (0.15, 0.39, 0.92)


def checked_name(name: str) -> str:
    """`name`, if a shape may bear it.

    Raises:
        BadArgument: no text, or too long a one.
    """
    if not isinstance(name, str) or not name or len(name) > _LONGEST_NAME:
        raise BadArgument(f"name must be 1 to {_LONGEST_NAME} characters, got {quoted(name)}")
    panel_message("name", {"name": name})  # refuses what cannot be sent
    return name


def points(
    robot: RobotModel, name: str, array: ArrayLike, colours: ArrayLike | None, size: float, frame: str | None
) -> bytes:
    """A cloud of points."""
    rows = _positions(array, "points", MOST_POINTS)
    content = {"positions": _floats(rows), "size": checked_length(size, "size")}
    if colours is None:
        return _message(robot, name, "points", frame, content | {"colour": _BLUE, "colours": None})
    rgb = as_floats(colours, (3,), "colours")
    if rgb.shape not in ((3,), rows.shape):
        raise WrongShape("colours", f"(3,) or {rows.shape}", rgb.shape)
    _check_colours(rgb, "colours")
    if rgb.ndim == 1:
        return _message(robot, name, "points", frame, content | {"colour": rgb.tolist(), "colours": None})
    each = typed_array(np.round(255.0 * rgb).astype(np.uint8).reshape(-1))
    return _message(robot, name, "points", frame, content | {"colour": _BLUE, "colours": each})


def mesh(
    robot: RobotModel,
    name: str,
    shape: ArrayLike | Path | str,
    faces: ArrayLike | None,
    colour: ArrayLike | None,
    opacity: float,
    frame: str | None,
) -> bytes:
    """A surface of triangles, from arrays or from a file."""
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
        {"geometry": mesh_document(part), "colour": own or (part.colour or (*_BLUE, 1.0))[:3], "opacity": share}
        for part in parts
    ]
    return _message(robot, name, "mesh", frame, {"parts": documents})


def line(
    robot: RobotModel, name: str, array: ArrayLike, colour: ArrayLike | None, width: float, frame: str | None
) -> bytes:
    """A line through points, round and with a width."""
    rows = _positions(array, "points", _MOST_LINE_POINTS)
    if len(rows) < 2:
        raise WrongShape("points", "(n, 3) with n ≥ 2", rows.shape)
    rgb = _BLUE if colour is None else one_colour(colour)
    content = {"positions": _floats(rows), "colour": rgb, "width": checked_length(width, "width")}
    return _message(robot, name, "line", frame, content)


def one_colour(colour: ArrayLike) -> tuple[float, float, float]:
    """`colour` as red, green and blue from 0 to 1.

    Raises:
        BadArgument, WrongShape, NotFinite: it is none.
    """
    rgb = as_floats(colour, (), "color")
    if rgb.shape != (3,):
        raise WrongShape("color", "(3,)", rgb.shape)
    _check_colours(rgb, "color")
    red, green, blue = rgb.tolist()
    return red, green, blue


def _check_colours(rgb: Floats, what: str) -> None:
    if rgb.size and not (rgb.min() >= 0.0 and rgb.max() <= 1.0):
        raise BadArgument(f"{what} must be red, green and blue from 0 to 1, got {rgb.min():g} to {rgb.max():g}")


def _positions(array: ArrayLike, what: str, most: int) -> Floats:
    rows = as_floats(array, (3,), what)
    if rows.ndim != 2:
        raise WrongShape(what, "(n, 3)", rows.shape)
    if len(rows) > most:
        raise BadArgument(f"at most {most} {what} are drawn, got {len(rows)}; leave some out")
    if rows.size and np.abs(rows).max() > FARTHEST:
        raise BadArgument(f"{what} reach to {np.abs(rows).max():g} m; at most {FARTHEST:g} m is drawn")
    return rows


def _built(vertices: ArrayLike, faces: ArrayLike) -> Mesh:
    rows = _positions(vertices, "vertices", _MOST_CORNERS)
    corners = as_numbers(faces, "faces")
    if corners.ndim != 2 or corners.shape[1] != 3 or len(corners) == 0:
        raise WrongShape("faces", "(m, 3) with m ≥ 1", corners.shape)
    if len(corners) > _MOST_CORNERS:
        raise BadArgument(f"at most {_MOST_CORNERS} faces are drawn, got {len(corners)}; leave some out")
    if not np.isin(corners % 1.0, 0.0).all() or corners.min() < 0 or corners.max() >= len(rows):
        raise BadArgument(f"faces must be whole numbers from 0 to {len(rows) - 1}, the places of their corners")
    triangles: NDArray[np.uint32] = corners.astype(np.uint32)
    try:
        return mesh_of(rows, triangles)
    except UnreadableShape as reason:
        raise BadArgument(f"the mesh cannot be drawn: {reason}") from None


def _read(path: Path) -> tuple[Mesh, ...]:
    try:
        parts = load_meshes(path, np.ones(3))
    except UnreadableShape as reason:
        raise BadArgument(f"{abbreviated(path)} is no mesh that can be drawn: {abbreviated(reason)}") from None
    if sum(len(part.vertices) for part in parts) > _MOST_CORNERS:
        raise BadArgument(f"{abbreviated(path)} has more than {_MOST_CORNERS} vertices")
    for part in parts:
        _positions(part.vertices, "vertices", _MOST_CORNERS)
    return parts


def _message(robot: RobotModel, name: str, shape: str, frame: str | None, content: dict[str, Any]) -> bytes:
    if frame is not None:
        choice(frame, robot.frame_names, "frame")
    return panel_message("extra", {"name": checked_name(name), "shape": shape, "frame": frame, **content})


def _floats(rows: Floats) -> Any:
    return typed_array(rows.astype(np.float32).reshape(-1))
