"""Poses as the numbers people write down, and their printing: JSON, CSV, a table, or lines as they come."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.cli.output import print_json, print_json_list, print_table, without_sign_of_zero

if TYPE_CHECKING:
    from nao_kin.stream import PoseColumns, PoseStyle

# First row and numbers of the poses (n, frames, k) of one piece after another.
Pieces = Iterator[tuple[int, Floats]]


class PoseFormat(str, Enum):
    """How a pose is written.

    matrix: the 16 entries of the homogeneous matrix, row by row, as NAOqi's getTransform has them.
    position6d: x, y, z, wx, wy, wz with R = Rz(wz) Ry(wy) Rx(wx), as NAOqi's getPosition has them.
    rpy: x, y, z, roll, pitch, yaw with R = Rz(yaw) Ry(pitch) Rx(roll).
    quaternion: x, y, z and the unit quaternion r0, r1, r2, r3, scalar first.
    """

    matrix = "matrix"
    position6d = "position6d"
    rpy = "rpy"
    quaternion = "quaternion"


STYLES: dict[PoseFormat, PoseStyle] = {
    PoseFormat.matrix: "matrix",
    PoseFormat.position6d: "position6d",
    PoseFormat.rpy: "rpy",
    PoseFormat.quaternion: "position_quaternion",
}


@dataclass(frozen=True)
class PosePrinter:
    """Prints poses of named frames.

    Attributes:
        frames: the names.
        style: how a pose is written.
        degrees: angles in degrees.
        times: of the rows, shape (n,) [s]; None for none.
    """

    frames: Sequence[str]
    style: PoseFormat
    degrees: bool
    times: Floats | None = None

    @property
    def columns(self) -> PoseColumns:
        """The numbers of a pose and their names."""
        from nao_kin.stream import PoseColumns  # which loads Pinocchio; an installation without it must get this far

        return PoseColumns(STYLES[self.style], self.degrees)

    def print_json(self, pieces: Pieces, robot: str, reference: str | None, *, many: bool) -> None:
        """One document: the poses of the one configuration, or of each of `many`."""
        head: dict[str, Any] = {
            "robot": robot,
            "reference": reference or "root",
            "as": self.style.value,
            "units": {"length": "m", "angle": "deg" if self.degrees else "rad"},
        }
        if self.times is not None:
            head["times"] = self.times.tolist()
        poses = (dict(zip(self.frames, map(self._json_pose, rows), strict=True)) for _, rows in self._rows(pieces))
        if many:
            print_json_list(head, "configurations", poses)
        else:
            print_json({**head, "poses": next(poses)})

    def print_csv(self, pieces: Pieces) -> None:
        """One line per configuration and frame, with a header."""
        from nao_kin.stream import csv_header, pose_lines

        sys.stdout.write(csv_header(self.columns.names, timed=self.times is not None))
        for start, numbers in pieces:
            rows = np.arange(start, start + len(numbers))
            times = None if self.times is None else self.times[start : start + len(numbers)]
            sys.stdout.write(pose_lines(rows, self.frames, numbers, times).decode())

    def print_table(self, pieces: Pieces) -> None:
        """The poses of one configuration, laid out for a reader."""
        matrix = self.style is PoseFormat.matrix
        columns = ("x axis", "y axis", "z axis", "origin\n[m]") if matrix else self._headings()
        table = []
        for _, rows in self._rows(pieces):
            for name, row in zip(self.frames, rows, strict=True):
                cells = [_fixed(value) for value in row]
                if matrix:  # the 4×4 matrix as it is written on paper; its columns are the axes and the origin
                    cells = ["\n".join(cells[column::4]) for column in range(4)]
                table.append([name, *cells])
        print_table(["frame", *columns], table, numbers=columns)

    def print_lines(self, pieces: Pieces) -> None:
        """One line per row and frame as they come: no waiting until a table of many thousand rows is laid out."""
        width = max(5, *map(len, self.frames))
        times = [] if self.times is None else [f"{time:.6f}" for time in self.times.tolist()]
        wide = max(map(len, ("time", *times)))
        print(f"{'row':>7}" + (f"  {'time':>{wide}}" if times else "") + f"  {'frame':{width}}", end="")
        print("".join(f"{name:>11}" for name in self.columns.names))
        for index, rows in self._rows(pieces):
            start = f"{index:>7}" + (f"  {times[index]:>{wide}}" if times else "")
            for name, row in zip(self.frames, rows, strict=True):
                print(f"{start}  {name:{width}}" + "".join(f"{_fixed(value):>11}" for value in row))

    def _rows(self, pieces: Pieces) -> Iterator[tuple[int, list[list[float]]]]:
        """Index of every configuration, and the numbers of each frame."""
        for start, numbers in pieces:
            yield from enumerate(numbers.tolist(), start)

    def _json_pose(self, row: list[float]) -> object:
        if self.style is PoseFormat.matrix:
            return [row[i : i + 4] for i in range(0, 16, 4)]
        return dict(zip(self.columns.names, row, strict=True))

    def _headings(self) -> tuple[str, ...]:
        unit = "" if self.style is PoseFormat.quaternion else "\n[°]" if self.degrees else "\n[rad]"
        columns = self.columns
        position = columns.names[: -len(columns.orientation)]
        orientation = (name.removesuffix("_deg") for name in columns.orientation)
        return (*(f"{name}\n[m]" for name in position), *(name + unit for name in orientation))


def _fixed(value: float) -> str:
    return f"{without_sign_of_zero(value, 5):.5f}"
