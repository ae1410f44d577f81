"""Targets of inverse kinematics in files: positions, orientations, or poses, also those that `nk.stream.fk` writes.

The count of numbers determines the kind: 3 a position, 4 a quaternion and 9 a rotation matrix, 6 a position with roll,
pitch and yaw, 7 a position with a quaternion, 16 a homogeneous matrix; for several frames as many times more.
Quaternions must have unit length, so that a position with a stray number is not one. In a CSV file the header
determines the kind.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, flag, join_poses, texts, whole_number
from nao_kin._core.csv_numbers import Records, TableColumns, csv_head, read_csv
from nao_kin._core.files import described, is_finite_number, read_arrays, read_bytes, read_json, read_table_text
from nao_kin._core.text import abbreviated, one_line_repr, quoted
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError, WrongShape
from nao_kin.robot import PoseForm, RobotModel
from nao_kin.rotations import matrix_from_quat, matrix_from_rpy
from nao_kin.stream.sinks import PoseColumns

Kind = Literal["position", "orientation", "pose"]

_TURN = 2.0 * math.pi
# Count of numbers → kind of target, and conversion of rows.
_READ: dict[int, tuple[Kind, Callable[[Floats], Floats]]] = {
    3: ("position", lambda rows: rows),
    4: ("orientation", matrix_from_quat),
    9: ("orientation", lambda rows: rows.reshape(-1, 3, 3)),
    6: ("pose", lambda rows: join_poses(matrix_from_rpy(rows[:, 3:]), rows[:, :3])),
    7: ("pose", lambda rows: join_poses(matrix_from_quat(rows[:, 3:]), rows[:, :3])),
    16: ("pose", lambda rows: rows.reshape(-1, 4, 4)),
}
# The kinds with a quaternion, which is last.
_WITH_QUATERNION = {4: "an orientation as a quaternion", 7: "a position with a quaternion"}
# Largest difference of a quaternion's length from 1, as of numbers with three decimals.
_UNIT = 1e-3
_EXPECTED = "3 numbers for a position, 4 or 9 for an orientation, 6, 7 or 16 for a pose"


class _BadTarget(BadArgument):
    """A target, by its row in the numbers, that cannot be used."""

    def __init__(self, message: str, row: int) -> None:
        self.index = (row,)
        super().__init__(message)


@one_line_repr
@dataclass(frozen=True, eq=False)
class Targets:
    """Targets of one kind.

    Attributes:
        kind: "position", "orientation" or "pose".
        values: positions, shape (n, 3), rotations, shape (n, 3, 3), or poses, shape (n, 4, 4) [m]; for several frames
            poses, shape (n, frames, 4, 4).
        many: whether they come from a list; False for a single target.
        notes: assumptions about the numbers.
    """

    kind: Kind
    values: Floats
    many: bool = True
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, numbers: ArrayLike, *, frames: int = 1, degrees: bool = False) -> Targets:
        """Return the targets in rows of numbers, shape (n, k); the count k determines their kind.

        Args:
            numbers: a target in each row [m, rad or degrees]: 3 numbers for a position, 4 (unit quaternion, scalar
                first) or 9 (rows of the matrix) for an orientation, 6 (x, y, z, roll, pitch, yaw), 7 (x, y, z,
                quaternion) or 16 (rows of the matrix) for a pose.
            frames: number of frames; several have a pose each, one after another in the row.
            degrees: roll, pitch and yaw are in degrees.

        Raises:
            BadArgument: another count of numbers, or a quaternion whose length is not 1.
            NotARotation: a matrix that is no rotation.

        Examples:
            >>> nk.stream.Targets.of([[0.1, 0.0, 0.2, 0.0, 0.0, 90.0]], degrees=True).values[0].round(3)[:3, 1]
            array([-1.,  0.,  0.])
        """
        rows = as_floats(numbers, (), "numbers")
        if rows.ndim != 2:
            raise WrongShape("numbers", "(n, k)", rows.shape)
        n, count = rows.shape
        flag(degrees, "degrees")
        if whole_number(frames, "frames", 1, 10_000) > 1:
            if count % frames or _READ.get(count // frames, ("",))[0] != "pose":
                expected = f"{6 * frames}, {7 * frames} or {16 * frames} for the poses of {frames} frames"
                raise BadArgument(f"{count} numbers; expected {expected}, one after another")
            found = cls.of(rows.reshape(frames * n, count // frames), degrees=degrees)
            return replace(found, values=found.values.reshape(n, frames, 4, 4))
        if count not in _READ:
            raise BadArgument(f"{count} numbers; expected {_EXPECTED}")
        notes: tuple[str, ...] = ()
        if count == 6:
            worst = float(np.abs(rows[:, 3:]).max(initial=0.0))
            if not degrees and worst > _TURN:
                advice = "degrees=True (--deg, of a file --file-deg) takes degrees"
                notes = (f"an angle of {worst:.6g} rad is more than a full turn; {advice}",)
            if degrees and n > 1 and 0.0 < worst <= _TURN:
                notes = (f"all angles are below {worst:.3g}°: are these radians?",)
            rows = np.hstack([rows[:, :3], np.radians(rows[:, 3:]) if degrees else rows[:, 3:]])
        if count in _WITH_QUATERNION:
            lengths = np.linalg.norm(rows[:, -4:], axis=1)
            off = np.flatnonzero(~(np.abs(lengths - 1.0) <= _UNIT))
            if off.size:
                length = f"whose length must be 1, not {lengths[off[0]]:.6g}"
                what = f"{count} numbers are {_WITH_QUATERNION[count]}, {length}; expected {_EXPECTED}"
                raise _BadTarget(what, int(off[0]))
        kind, read = _READ[count]
        return cls(kind, read(rows), notes=notes)


@dataclass(frozen=True)
class _Rows:
    """Rows of numbers (n, k), the line of each if it has one, whether they are a list, and the unit of their angles."""

    numbers: Floats
    lines: Sequence[int]
    many: bool
    degrees: bool


def read_targets(robot: RobotModel, path: Path | str, frame: str | Sequence[str], *, degrees: bool = False) -> Targets:
    """Return the targets for a frame, or for several frames, in a file.

    Args:
        robot: the frames are its own.
        path: a CSV file with the headings of `nao-kin fk --csv` or of `nk.stream.fk`, of which only the rows of the
            `frame` are used if it has a column "frame"; a JSON file with a list of lists of numbers, or as printed by
            `nao-kin fk --json`; a .npy file with one target in each row; or "-" for standard input.
        frame: a frame, or several frames, which have a pose each in every row of a JSON or .npy file.
        degrees: roll, pitch and yaw are in degrees; headings that end in _deg also mean degrees.

    Raises:
        UnknownName: the robot has no such frame.
        BadInputFile: the file is unreadable, empty or malformed, has no target for a frame, or poses in another frame
            than the root link's. The message has line and column if the file has them.

    Examples:
        >>> nao = nk.load_nao()
        >>> walk = np.array([nao.posture("Stand"), nao.posture("Crouch")])
        >>> _ = nk.stream.fk(nao, nk.stream.Configurations(walk), "feet.csv", frame=["LLeg", "RLeg"], as_="rpy")
        >>> found = nk.stream.read_targets(nao, "feet.csv", "LLeg")
        >>> found.kind, np.allclose(found.values, nao.fk(walk, "LLeg"))
        ('pose', True)
    """
    flag(degrees, "degrees")
    frames = tuple(texts([frame] if isinstance(frame, str) else frame, "frame"))
    if not frames:
        raise BadArgument("no frames; expected at least one name")
    robot.frame_ids(frames)
    name = str(path)
    if not name:
        raise BadArgument("no file name; expected a CSV, JSON or .npy file, or - for standard input")
    if Path(name).suffix.lower() == ".npy":
        rows = _Rows(_from_npy(name), (), True, degrees)
    else:
        text, is_json = read_table_text(name, "targets")
        rows = _from_json(robot, name, text, frames, degrees) if is_json else _from_csv(name, text, frames, degrees)
    try:
        found = Targets.of(rows.numbers, frames=len(frames), degrees=rows.degrees)
    except NaoKinError as error:
        at = getattr(error, "index", ())
        row = at[0] // len(frames) if at else 0
        raise BadInputFile(name, str(error), rows.lines[row] if row < len(rows.lines) else 0) from None
    return replace(found, many=rows.many)


def _from_npy(name: str) -> Floats:
    array = read_arrays(name, read_bytes(name, unpack=False), ("",), wrong="not a .npy file").get("")
    if array is None or array.dtype.kind not in "fiu" or array.ndim == 0:
        raise BadInputFile(name, "expected an array of numbers, one target in each row")
    if not len(array):
        raise BadInputFile(name, "the array has no targets")
    rows = np.asarray(array, dtype=np.float64).reshape(len(array), math.prod(array.shape[1:]))
    bad = np.argwhere(~np.isfinite(rows))
    if len(bad):
        raise BadInputFile(name, f"row {bad[0][0]} has a number that is not finite")
    return rows


def _from_csv(name: str, text: str, frames: Sequence[str], degrees: bool) -> _Rows:
    poses = [PoseColumns(style, unit).names for style in get_args(PoseForm) for unit in (False, True)]
    known = {*poses, ("x", "y", "z"), ("r0", "r1", "r2", "r3")}
    data = text.encode()
    head = csv_head(name, data, "targets")
    names = [field.strip() for field in head.fields]
    wanted = next((columns for columns in known if set(columns) == {*names} - {"row", "time", "frame"}), None)
    if wanted is None or len({*names}) < len(names):
        expected = "x,y,z; r0,r1,r2,r3; x,y,z,roll,pitch,yaw; x,y,z,r0,r1,r2,r3; t11,…,t44"
        given = abbreviated(", ".join(names))
        raise BadInputFile(name, f"the header names {given}; expected one of {expected}", head.line)
    table = TableColumns(wanted, (), tuple(map(names.index, wanted)), all=len(names))
    _, numbers, lines = read_csv(name, data, lambda _: table, "targets")
    if "frame" in names:
        at = names.index("frame")
        named = [fields[at].strip() for _, fields, _ in Records(data[head.size :], head.delimiter)]
    elif len(frames) > 1:
        raise BadInputFile(name, f"no column frame; it must name {' and '.join(frames)}", head.line)
    else:
        named = [*frames] * len(numbers)
    places = [np.flatnonzero(np.array(named) == frame) for frame in frames]
    for frame, found in zip(frames, places, strict=True):
        if not len(found):
            raise BadInputFile(name, f"no targets for {quoted(frame)}")
        if len(found) != len(places[0]):
            raise BadInputFile(name, f"{len(found)} targets for {frame}, {len(places[0])} for {frames[0]}")
    together = np.concatenate([numbers[found] for found in places], axis=1)
    return _Rows(together, [lines[row] for row in places[0].tolist()], True, degrees or wanted[-1].endswith("_deg"))


def _from_json(robot: RobotModel, name: str, text: str, frames: Sequence[str], degrees: bool) -> _Rows:
    document = read_json(name, text)
    many = True
    if isinstance(document, dict):  # as `nao-kin fk --json` writes it
        units = document.get("units")
        degrees = degrees or (isinstance(units, dict) and units.get("angle") == "deg")
        roots = ("root", robot.semantics.root, robot.tree.root, *(() if "world" in robot.frame_names else ("world",)))
        if document.get("reference", "root") not in roots:
            asked = abbreviated(json.dumps(document["reference"], ensure_ascii=False))
            raise BadInputFile(name, f"poses in {asked}; expected them in the torso, as without --reference")
        many = "configurations" in document
        entries = document.get("configurations", [document.get("poses")])
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise BadInputFile(name, "expected a list of targets, or what nao-kin fk --json prints")
        for index, entry in enumerate(entries):
            for frame in frames:
                if frame not in entry:
                    raise BadInputFile(name, f"target {index}: no pose of {quoted(frame)}")
        document = [[entry[frame] for frame in frames] for entry in entries]
    if not isinstance(document, list) or not document:
        raise BadInputFile(name, "expected a list of targets, each a list of numbers")
    if not any(isinstance(entry, (list, dict)) for entry in document):
        document, many = [document], False
    rows = [_flat(name, index, entry) for index, entry in enumerate(document)]
    if len({len(row) for row in rows}) > 1:
        odd = next(index for index, row in enumerate(rows) if len(row) != len(rows[0]))
        raise BadInputFile(name, f"target {odd} has {len(rows[odd])} numbers, the first {len(rows[0])}")
    return _Rows(np.array(rows), (), many, degrees)


def _flat(name: str, index: int, entry: Any) -> list[float]:
    """Return the numbers of nested lists or of an object's values, in order."""
    if isinstance(entry, (list, dict)):
        parts = entry.values() if isinstance(entry, dict) else entry
        return [number for part in parts for number in _flat(name, index, part)]
    if not is_finite_number(entry):
        raise BadInputFile(name, f"target {index}: {described(entry)} is not a finite number")
    return [float(entry)]
