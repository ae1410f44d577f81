"""Points, meshes and lines that are no part of a robot, as messages: checked here, so that the page can trust them.

Arguments and errors are those of the methods of `Viewer`.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats, as_floats, as_numbers
from nao_kin._common.choices import choice
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot import RobotModel
from nao_kin.viewer.meshes import Mesh, UnreadableMesh, load_meshes, mesh_of
from nao_kin.viewer.messages import mesh_document, panel_message, typed_array
from nao_kin.viewer.overlays import FARTHEST, checked_length, checked_opacity

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
    except UnreadableMesh as reason:
        raise BadArgument(f"the mesh cannot be drawn: {reason}") from None


def _read(path: Path) -> tuple[Mesh, ...]:
    try:
        parts = load_meshes(path, np.ones(3))
    except (UnreadableMesh, OSError, ValueError) as reason:
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
