"""Observations from files: from JSON, and from photos of a chessboard with a log of the joints."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, choice, finite_decimal, positive, shaped, whole_number
from nao_kin._core.csv_numbers import delimiter_of
from nao_kin._core.files import MAX_NUMBERS, described, read_bytes, read_json, read_text
from nao_kin._core.text import abbreviated, listed, quoted
from nao_kin._core.warn import need_extra, warn_caller
from nao_kin.calibration.observations import FIELDS, Contacts, Lines, Pixels, Poses, errors_of
from nao_kin.calibration.problem import AnyObservation
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError, NaoKinWarning, UnknownName
from nao_kin.robot import RobotModel
from nao_kin.screws import pose_of, transform_point
from nao_kin.stream import read_log
from nao_kin.world import camera, configurations_at

# --- Observations in a JSON file.

_HEAD = {"joints", "frames", "start", "prior", "joint_noise", "observations"}
_CAMERA = "resolution", "intrinsics", "distortion"
# Of each type of observation: the members that must be names, all others, and those of each posture.
_MEMBERS = {
    "pixels": (("camera",), {*_CAMERA, "points", "frame", "board", "on_floor", "field"}, {"pixels", "velocities"}),
    "lines": (("camera",), {*_CAMERA, "frame", "board", "field"}, {"lines", "velocities"}),
    "poses": (("frame",), {"world", "marker", "reference"}, {"pose"}),
    "contacts": (("frame", "reference"), {"height"}, set[str]()),
}
_COMMON = {"type", "noise", "posture", "seen"}
# Members that are texts, and that are the attributes of the same names.
_TEXTS = ("frame", "board", "world", "marker", "reference")
_PASSED_ON = (*_TEXTS, "height", "noise", "on_floor")
# Intrinsics that differ from the published ones by more than this factor, or place the axis so far from the middle of
# the image, in parts of its size, belong to another resolution.
_OTHER_FOCUS, _OFF_CENTRE = 1.5, 0.2


def read_observations(robot: RobotModel, path: Path | str) -> dict[str, Any]:
    """Return the arguments of `calibrate` from a JSON file.

    The file has the members `observations` and, as for `calibrate`, `joints`, `frames`, `start`, `prior` and
    `joint_noise`.
    An observation has a `type`: "pixels", "lines", "poses" or "contacts"; the attributes of `Pixels`, `Lines`, `Poses`
    or `Contacts`; and `seen`, a list with one object for each posture: `joints` (name → reported value [rad], joints
    not named as in the `posture` of the observation, or zero) and `pixels` ([u, v] or null for each point), `lines`
    (name of a line → list of [u, v]) or `pose` (six numbers, or rows of four). A camera is named, with a `resolution`
    and perhaps its own `intrinsics` [fx, fy, cx, cy] and `distortion`. `points` may be names of points of a `field`.
    If joints move in images, `velocities` beside `joints` (name → [rad/s], others are still) tell `calibrate` to
    estimate how late the images are.

    Args:
        robot: the nominal robot.
        path: the file, "-" for standard input.

    Returns:
        {"observations": […], "joints": …, "frames": …, "start": …}, and other arguments of `calibrate` in the file.

    Raises:
        BadInputFile: the file cannot be read or is not valid; the message names the observation and posture.

    Examples:
        >>> import json, pathlib
        >>> seen = [{"joints": {"HeadYaw": 0.3}, "pose": [0.0, 0.0, 0.1265, 0.0, 0.0, 0.31]}]
        >>> document = {"joints": ["HeadYaw"], "observations": [{"type": "poses", "frame": "Head", "seen": seen}]}
        >>> path = pathlib.Path("observations.json")
        >>> path.write_text(json.dumps(document)) > 0
        True
        >>> arguments = nk.calibration.read_observations(nk.load_nao(), path)
        >>> found = nk.calibration.calibrate(nk.load_nao(), **arguments)
        >>> round(found.joints["HeadYaw"], 4), round(found.standard_deviations["HeadYaw offset"], 4)
        (0.0075, 0.0088)
    """
    name = str(path)
    document = read_json(name, read_text(name))
    try:
        _check_members(document, _HEAD)
        given = _list(document.get("observations"), "observations")
        joints, frames = document.get("joints", []), document.get("frames", [])
        if not isinstance(joints, list) or not isinstance(frames, list | dict):
            raise BadArgument("joints must be a list of names, and frames too, or an object of lists")
        start = {
            board: pose_of(T, f"start of {board}") for board, T in _object(document.get("start", {}), "start").items()
        }
        observations = []
        for number, one in enumerate(given):
            with errors_of(f"observation {number}"):
                observations.append(_observation(robot, one))
    except NaoKinError as error:
        raise BadInputFile(name, str(error)) from None
    options = {key: document[key] for key in ("prior", "joint_noise") if key in document}
    return {"observations": observations, "joints": joints, "frames": frames, "start": start, **options}


def _observation(robot: RobotModel, given: Any) -> AnyObservation:
    kind = _object(given, "an observation").get("type")
    if not isinstance(kind, str) or kind not in _MEMBERS:
        raise UnknownName("type of observation", kind, tuple(_MEMBERS))
    names, others, of_seen = _MEMBERS[kind]
    _check_members(given, _COMMON | set(names) | others)
    for key in names:
        if not isinstance(given.get(key), str):
            raise BadArgument(f"{key} must be given: the name of a frame")
    for key in _TEXTS:
        if not isinstance(given.get(key), str | None):
            raise BadArgument(f"{key} must be a text, got {quoted(given[key])}")
    own = {key: given[key] for key in _PASSED_ON if key in given}
    seen, posture, rows, speeds = _list(given.get("seen"), "seen"), given.get("posture"), [], []
    with_posture = robot.configuration if posture is None else partial(robot.posture, posture)
    for number, one in enumerate(seen):
        _check_members(one, {"joints"} | of_seen, f"seen {number}: ")
        with errors_of(f"seen {number}"):
            rows.append(with_posture(_object(one.get("joints", {}), "joints"), limits="ignore"))
            speeds.append(robot.configuration(_object(one.get("velocities", {}), "velocities"), limits="ignore"))
    q, v = np.array(rows), np.array(speeds) - robot.configuration({})
    if v.any():
        own["moving"] = partial(_moving, q, v)
    if kind == "contacts":
        return Contacts(q, **own)
    if kind == "poses":
        poses = [pose_of(one.get("pose"), f"pose of seen {number}") for number, one in enumerate(seen)]
        return Poses(q, poses=np.array(poses), **own)
    if kind == "lines":
        own |= {"field": given["field"]} if "field" in given else {}
        return Lines(q, _camera(robot, given), *_lines(seen), **own)
    points = _points(_list(given.get("points"), "points"), given.get("field"))
    pixels = [_pixels(one.get("pixels"), len(points), f"pixels of seen {number}") for number, one in enumerate(seen)]
    return Pixels(q, _camera(robot, given), np.array(pixels), points, **own)


def _moving(q: Floats, velocities: Floats, later: float) -> Floats:
    """Return the configurations at times later than those of the images."""
    return q + later * velocities


def _points(given: list[Any], name: Any) -> Floats:
    """Return points, shape (k, 3), of which some may be names of points of a field."""
    if name is None:
        return as_floats(given, (3,), "points")
    known = FIELDS[choice(name, FIELDS, "field")].points
    where = f"point of the field {name}"
    return as_floats([known[choice(p, known, where)] if isinstance(p, str) else p for p in given], (3,), "points")


def _lines(seen: list[Any]) -> tuple[Floats, list[str]]:
    """Return pixels on lines, with a column for the most pixels that one posture has of each line, and their lines."""
    given = [_object(one.get("lines"), f"lines of seen {number}") for number, one in enumerate(seen)]
    parts, lines = list[Floats](), list[str]()
    for name in dict.fromkeys(name for one in given for name in one):
        rows = [_list(one[name], f"{name} of seen {n}") if name in one else [] for n, one in enumerate(given)]
        most = max(map(len, rows))
        filled = ([*row, *[None] * (most - len(row))] for row in rows)
        parts.append(np.array([_pixels(row, most, f"{name} of seen {n}") for n, row in enumerate(filled)]))
        lines += [name] * most
    if not lines:
        raise BadArgument("lines must name at least one line")
    return np.concatenate(parts, axis=1), lines


def _camera(robot: RobotModel, given: Mapping[str, Any]) -> Any:
    resolution = given.get("resolution", "VGA")
    found = camera(robot, given["camera"], tuple(resolution) if isinstance(resolution, list) else resolution)
    if "intrinsics" in given:
        fx, fy, cx, cy = as_floats(given["intrinsics"], (4,), "intrinsics").tolist()
        centre = (cx + 0.5) / found.width - 0.5, (cy + 0.5) / found.height - 0.5
        if max(map(abs, centre)) > _OFF_CENTRE or not 1.0 / _OTHER_FOCUS < fx / found.fx < _OTHER_FOCUS:
            size = f"{round(2.0 * cx)} × {round(2.0 * cy)}"
            raise BadArgument(f"intrinsics are of images of about {size} pixels, not {found.width} × {found.height}")
        found = replace(found, fx=fx, fy=fy, cx=cx, cy=cy, nominal=False)
    if "distortion" in given:
        found = replace(found, distortion=tuple(as_floats(given["distortion"], (), "distortion").ravel().tolist()))
    return found


def _pixels(given: Any, count: int, what: str) -> Floats:
    rows = [[np.nan, np.nan] if row is None else row for row in _list(given, what)]
    try:
        found = np.array(rows, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadArgument(f"{what} must be [u, v] or null for each point") from None
    if found.shape != (count, 2):
        raise BadArgument(f"{what} must be [u, v] or null for each of {count} points, got {len(rows)}")
    return found


def _list(value: Any, what: str) -> list[Any]:
    if not isinstance(value, list) or not value:
        raise BadArgument(f"{what} must be a list that is not empty, got {quoted(described(value))}")
    return value


def _object(value: Any, what: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise BadArgument(f"{what} must be an object, got {quoted(described(value))}")
    return value


def _check_members(value: Any, known: set[str], where: str = "") -> None:
    for name in _object(value, where.rstrip(": ") or "the document"):
        if name not in known:
            raise UnknownName(f"{where}member", name, sorted(known))


# --- Photos of a chessboard.

_SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".ppm", ".pgm", ".tif", ".tiff", ".webp")
# Units of times in the names of photos, as parts of a second.
_UNITS = (1.0, 1e3, 1e6, 1e9)
# Longest time between the rows of a log around a photo [s].
_LONGEST_GAP = 0.5
_MOST_CORNERS = 1000
# A longer side would keep OpenCV busy for minutes, as a part of the other one.
_LONGEST_SIDE = 10
# If a corner of a part of a board is farther from its place, its grid is wrong, in parts of a square; lenses bend less.
_ASTRAY = 0.2


def from_photos(
    robot: RobotModel,
    photos: Path | str | Iterable[Path | str],
    log: Path | str,
    *,
    board: tuple[int, int],
    square: float,
    camera: str = "CameraTop",
    lens: ArrayLike | None = None,
    times: Mapping[str, float] | Path | str | None = None,
    place: ArrayLike | None = None,
    frame: str | None = None,
    name: str = "chessboard",
    noise: float = 0.5,
    missing: str | float | None = None,
    degrees: bool = False,
) -> Pixels:
    """Return what photos of a chessboard show, with the joint values of a log at their times.

    OpenCV finds the inner corners, to parts of a pixel. Their order is the same in all photos, as if the board were not
    turned by more than 90° in the image from the first one to another: the first corner is the one nearest to the upper
    left in the first photo, the next ones follow along a row of the board. In the board, x is along a row, y from row
    to row, and z away from the camera. Joint values are interpolated between the rows of the log.

    Args:
        robot: the nominal robot.
        photos: a folder of images, or their paths, all of one size.
        log: a file of joint values and times, as `nk.stream.read_log` reads it.
        board: inner corners of a row, and rows.
        square: the side of a square [m].
        camera: name of the camera.
        lens: its measured fx, fy, cx, cy and distortion for photos of this size, as `cv2.calibrateCamera` finds them.
            None if it is not known: `calibrate` then estimates it, from the published one.
        times: name of a photo → its time, or a CSV file with the columns `file` and `time` [s]. None for the number at
            the end of the names of the photos, as in top_1712345678.250.png: seconds, or milli-, micro- or nanoseconds
            if the log has their times in seconds. If the joints move, `calibrate` estimates how late the photos are.
        place: the measured pose of the board in the frame, shape (4, 4), or (x, y, z, roll, pitch, yaw); None if it is
            unknown.
        frame: the frame that carries the board; None for the root.
        name: name of the board.
        noise: standard deviation of u and of v [pixels].
        missing: values of joints that the log does not have, as in `nk.stream.read_log`.
        degrees: turning joints of the log are in degrees if it does not give their unit.

    Returns:
        One posture for each photo, in the order of their names. Its pixels are NaN for corners beyond the edge of a
        photo, and for all corners if it is not clear which part of the board is seen. Warnings name photos of no board
        and of parts, and say what is assumed about the log.

    Raises:
        MissingExtra: OpenCV is not installed.
        BadInputFile: a photo cannot be read, or the log has no times.
        BadArgument: no photos; no photo shows the board; photos of several sizes; a photo without a time, or with one
            that the log does not have.

    Examples:
        >>> seen = nk.calibration.from_photos(
        ...     nk.load_nao(), "photos", "log.csv", board=(9, 6), square=0.03
        ... )  # doctest: +SKIP
        >>> found = nk.calibration.calibrate(
        ...     nk.load_nao(), [seen], joints=["HeadYaw", "HeadPitch"], frames={"CameraTop": ["roll", "pitch", "yaw"]}
        ... )  # doctest: +SKIP
    """
    need_extra("chessboards in photos", "photos")
    paths = _photos(photos)
    if np.shape(board) != (2,):
        raise BadArgument(f"board must be the columns and rows of inner corners, got {quoted(board)}")
    columns = whole_number(board[0], "columns of board", 3, _MOST_CORNERS)
    rows = whole_number(board[1], "rows of board", 3, _MOST_CORNERS)
    size = float(positive(square, "square"))
    read = read_log(robot, log, limits="ignore", hips="average", missing=missing, degrees=degrees)
    for note in read.notes:
        warn_caller(f"{quoted(str(log))}: {note}", NaoKinWarning)
    if read.times is None:
        raise BadInputFile(str(log), "no column of times, which photos need")
    taken = _times(paths, times, read.times)
    q = _interpolated(robot, read.times, read.q, taken, paths)
    pixels, (width, height) = _corners(paths, columns, rows)
    seen_by = _camera(robot, {"camera": camera, "resolution": [width, height], **({} if lens is None else _lens(lens))})
    count, sides = np.isfinite(pixels[..., 0]).sum(axis=1), f"{columns} × {rows} inner corners"
    if not count.any():
        raise BadArgument(f"none of {len(paths)} photos shows a whole chessboard with {sides}")
    for what, those in (("no chessboard", count == 0), ("a part of the board", (count > 0) & (count < columns * rows))):
        if those.any():
            named = listed([path.name for path, one in zip(paths, those, strict=True) if one])
            warn_caller(f"{those.sum()} of {len(paths)} photos show {what} with {sides}: {named}", NaoKinWarning)
    y, x = np.divmod(np.arange(columns * rows), columns)
    points = size * np.stack((x, y, np.zeros_like(x)), axis=-1)
    moving, unknown = partial(_later, robot, read.times, read.q, taken), name if place is None else None
    if place is not None:
        points = transform_point(pose_of(place, "place"), points)
    return Pixels(q, seen_by, pixels, points, frame, unknown, noise, moving=moving)


def _lens(numbers: ArrayLike) -> dict[str, Floats]:
    """Return intrinsics and distortion, given in one list."""
    array = as_floats(numbers, (), "lens").ravel()
    if len(array) < 4:
        raise BadArgument(f"lens must be fx, fy, cx, cy and perhaps a distortion, got {len(array)} numbers")
    return {"intrinsics": array[:4], "distortion": array[4:]}


def _photos(photos: Path | str | Iterable[Path | str]) -> list[Path]:
    """Return the paths of photos, sorted by name."""
    if isinstance(photos, Path | str):
        folder = Path(photos)
        if not folder.is_dir():
            raise BadArgument(f"no folder of photos: {quoted(str(folder))}")
        found = [path for path in folder.iterdir() if path.suffix.lower() in _SUFFIXES]
        if not found:
            raise BadArgument(f"no photos ({', '.join(_SUFFIXES[:3])} …) in {quoted(str(folder))}")
    else:
        found = [Path(path) for path in photos]
        if not found:
            raise BadArgument("photos must have at least one path")
    for path in found:
        if not path.is_file():  # opening a named pipe would wait for ever
            raise BadInputFile(str(path), "is no photo: there is no such regular file")
    return sorted(found)


def _times(paths: Sequence[Path], times: Mapping[str, float] | Path | str | None, moments: Floats) -> Floats:
    """Return the times of photos [s]."""
    if times is None:
        ends = [re.search(r"\d+(\.\d+)?$", path.stem) for path in paths]
        if None in ends:
            what = "a time at the end of its name, as in top_12.250.png"
            raise BadArgument(f"the photo {paths[ends.index(None)].name} has not {what}; give times")
        given = np.array([float(end[0]) for end in ends if end is not None])
        low, high = given.min(), given.max()
        return np.asarray(given / next((u for u in _UNITS if moments[0] <= low / u and high / u <= moments[-1]), 1.0))
    known = times if isinstance(times, Mapping) else _read_times(str(times))
    for path in paths:
        choice(path.name, known, "photo in times")
    return np.array([float(shaped(known[path.name], (), f"time of {path.name}")) for path in paths])


def _read_times(path: str) -> dict[str, float]:
    """Return the times in a CSV file with the columns file and time."""
    text = read_text(path)
    mark, found = delimiter_of(text.partition("\n")[0]), dict[str, float]()
    for number, row in enumerate(csv.DictReader(text.splitlines(), delimiter=mark, skipinitialspace=True), start=2):
        time = finite_decimal(row.get("time") or "")
        if not row.get("file") or time is None:
            raise BadInputFile(path, f"line {number}: expected the columns file and time [s], as in top_1.png,12.25")
        found[row["file"]] = time
    return found


def _interpolated(robot: RobotModel, moments: Floats, q: Floats, times: Floats, paths: Sequence[Path]) -> Floats:
    """Return the configurations at the times of photos."""
    found = configurations_at(robot, q, moments, times, longest_gap=_LONGEST_GAP)
    for path, time, row in zip(paths, times, found, strict=True):
        if not moments[0] <= time <= moments[-1]:
            ends = f"from {moments[0]:.6f} to {moments[-1]:.6f} s"
            raise BadArgument(f"the photo {path.name} is of {time:.6f} s, and the log {ends}")
        if np.isnan(row).any():
            raise BadArgument(f"the log has a gap of more than {_LONGEST_GAP:.3g} s around the photo {path.name}")
    return found


def _later(robot: RobotModel, moments: Floats, q: Floats, times: Floats, later: float) -> Floats:
    """Return the configurations at times later than those of photos, within the log."""
    within = np.clip(times + later, moments[0], moments[-1])
    return configurations_at(robot, q, moments, within, longest_gap=float(np.ptp(moments)))


def _corners(paths: Sequence[Path], columns: int, rows: int) -> tuple[Floats, tuple[int, int]]:
    """Return the corners in each photo, (n, columns · rows, 2), NaN for those not seen, and the size of photos."""
    import cv2

    found, size, along = np.full((len(paths), rows, columns, 2), np.nan), None, np.ones(2)
    parts, whole = dict[int, tuple[Any, Floats]](), None
    for number, path in enumerate(paths):
        data = np.frombuffer(read_bytes(str(path), unpack=False), dtype=np.uint8)
        try:
            image = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE) if len(data) else None
            if image is None:
                raise BadInputFile(str(path), "is no image that OpenCV reads")
            own = image.shape[1], image.shape[0]
            size = own if size is None else size
            pixels = f"{path.name} has {own[0]} × {own[1]} pixels"
            if own != size:
                raise BadArgument(f"photos must have one size: {pixels}, the first one {size[0]} × {size[1]}")
            if image.size > MAX_NUMBERS or max(own) > _LONGEST_SIDE * min(own):
                raise BadArgument(f"{pixels}; expected at most {MAX_NUMBERS}, and sides like those of a photo")
            # Stretched brightness shows boards in the dark, but moves the corners of others a little.
            for flags in (0, cv2.CALIB_CB_NORMALIZE_IMAGE):
                seen, at = cv2.findChessboardCornersSB(image, (columns, rows), flags=cv2.CALIB_CB_ACCURACY | flags)
                if seen:
                    break
            else:
                flags = cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_LARGER
                seen, at, grid = cv2.findChessboardCornersSBWithMeta(image, (3, 3), flags)
                if seen:
                    parts[number] = image, np.asarray(at, dtype=np.float64).reshape(*grid.shape, 2)
                continue
        except cv2.error as error:  # too many pixels, too little memory
            raise BadInputFile(str(path), f"refused by OpenCV: {abbreviated(error.err)}") from None
        corners = np.asarray(at, dtype=np.float64).reshape(rows, columns, 2)
        diagonal = corners[-1, -1] - corners[0, 0]
        if diagonal @ along < 0.0:
            corners, diagonal = corners[::-1, ::-1], -diagonal
        if whole is None:
            along, whole = diagonal, (corners, float(_squares(image, corners).mean()))
        found[number] = corners
    if whole is not None:
        for number, (image, part) in parts.items():
            _put(image, part, found[number], *whole)
    return found.reshape(len(paths), -1, 2), size or (0, 0)


def _squares(image: Any, corners: Floats) -> Floats:
    """Return how much brighter the squares between corners (r, c, 2) are than their mean, of every other one less."""
    centres = 0.25 * (corners[1:, 1:] + corners[1:, :-1] + corners[:-1, 1:] + corners[:-1, :-1])
    rows, columns = (
        np.rint(np.clip(centres[..., 1 - k], 0.0, side - 1.0)).astype(int) for k, side in enumerate(image.shape)
    )
    shown = image.astype(np.float64)[rows, columns]
    return np.asarray((shown - shown[1:-1, 1:-1].mean()) * (-1.0) ** np.indices(shown.shape).sum(axis=0))


def _put(image: Any, part: Floats, board: Floats, whole: Floats, bright: float) -> None:
    """Write the corners of a part (r, c, 2) into those of the board (rows, columns, 2), if it is clear where they are.

    The board is turned by less than 45° from the whole one of another photo. Its rows, or columns, are missing on one
    side, where the next one would not be wholly in the image, at least a square from its edge; on the other side are
    the squares of its end. The colours of its squares are those of the whole one.
    """
    import cv2

    def way(corners: Floats) -> Floats:
        x, y = corners[0, -1] - corners[0, 0], corners[-1, 0] - corners[0, 0]
        return np.concatenate((x / np.linalg.norm(x), y / np.linalg.norm(y)))

    turns = (np.rot90(one, turn) for one in (part, part[:, ::-1]) for turn in range(4))
    part = np.ascontiguousarray(max(turns, key=lambda one: float(way(one) @ way(whole))))
    (r, c), (rows, columns) = part.shape[:2], board.shape[:2]
    # Rows and columns from −1 to r and c.
    lines = np.stack(np.meshgrid(np.arange(-1.0, c + 1.0), np.arange(-1.0, r + 1.0)), axis=-1)
    H: Any = cv2.findHomography(lines[1:-1, 1:-1].reshape(-1, 2), part.reshape(-1, 2), cv2.LMEDS)[0]
    if H is None:
        return
    at = np.asarray(cv2.perspectiveTransform(lines.reshape(1, -1, 2), H), dtype=np.float64).reshape(lines.shape)
    square = np.ptp(part, axis=(0, 1)).max() / (max(r, c) - 1.0)
    within = ((at > square) & (at < np.array(image.shape[::-1]) - square)).all(axis=-1)
    squares = _squares(image, at)
    mean = squares[1:-1, 1:-1].mean()
    if not mean or np.linalg.norm(part - at[1:-1, 1:-1], axis=-1).max() > _ASTRAY * square:
        return
    row = _first(rows - r, within[:, 1:-1], squares[:, 1:-1] / mean)
    column = _first(columns - c, within[1:-1].T, squares[1:-1].T / mean)
    if row is not None and column is not None and mean * bright * (-1.0) ** (row + column) > 0.0:
        board[row : row + r, column : column + c] = part


def _first(missing: int, within: NDArray[np.bool_], squares: Floats) -> int | None:
    """Return the first line of a part of a board with so many more lines; None if it is not clear on which side."""
    if missing <= 0:
        return None if missing else 0
    # A line may be cut off as far as one of the part, two lines from it, is within the image.
    cut = [bool((within[inner] & ~within[line]).any()) for line, inner in ((0, 2), (-1, -3))]
    if cut[0] == cut[1] or squares[-1 if cut[0] else 0].mean() < 0.5:
        return None
    return missing if cut[0] else 0
