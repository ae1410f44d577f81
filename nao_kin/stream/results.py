"""Results of a run over a large file."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.text import one_line_repr
from nao_kin.robot import OutsideRows, RobotModel

# Bad rows that are listed; the others are only counted.
MAX_LISTED = 20


@dataclass(frozen=True)
class BadRow:
    """A row without a valid configuration.

    Attributes:
        row: its index among the rows of the source, from 0, as in the column "row" of the output.
        line: its line in a CSV file, from 1; 0 in other files.
        column: the wrong column in a CSV file, from 1; 0 for none.
        reason: description of the error.
        file: its file, if there are several; otherwise "".
    """

    row: int
    line: int
    column: int
    reason: str
    file: str = ""

    def __str__(self) -> str:
        place = f"line {self.line}" if self.line else f"row {self.row}"
        place += f", column {self.column}" if self.column else ""
        return f"{f'{self.file}, ' if self.file else ''}{place}: {self.reason}"


NOT_CLAMPED = OutsideRows()


def clamp(robot: RobotModel, q: Floats) -> tuple[Floats, OutsideRows]:
    """Return `robot.clamp(q)` and the changes that exceed the tolerance of limits.

    Args:
        robot: its limits apply.
        q: configurations, shape (n, nq).

    Examples:
        >>> nao = nk.load_nao()
        >>> clamp(nao, nao.posture("Stand")[None])[1].rows
        0
    """
    inside = robot.clamp(q)
    base = robot.nq_base
    return inside, OutsideRows.of(np.asarray(q)[:, base:], inside[:, base:], robot.joint_names)


@one_line_repr
@dataclass(frozen=True)
class StreamResult:
    """Summary of a run.

    Attributes:
        sink: the file that was written.
        frames: the frames whose poses are in the file.
        columns: names of the numbers of a pose.
        rows_read: rows of the source, bad ones included.
        rows_written: rows of the output, each with one pose per frame.
        rows_resumed: how many of the rows read an earlier run had finished.
        bad_rows: rows without a valid configuration: left out, or written as NaN.
        first_bad_rows: the first of them, each with its `row` in the source, from 0, its `line` and `column` in a CSV
            file, from 1 (0 for none), its `reason`, and its `file`, "" if there is only one.
        clamped: rows outside the limits that limits="clamp" has moved, or "measured" accepted: the number of `rows`,
            the `largest` distance of a joint from its range [rad, m or ratio], that `joint`, "" for none, and the
            distances of all `joints` that are outside.
        notes: assumptions about the source.
    """

    sink: str
    frames: tuple[str, ...]
    columns: tuple[str, ...]
    rows_read: int
    rows_written: int
    rows_resumed: int
    bad_rows: int
    first_bad_rows: tuple[BadRow, ...]
    clamped: OutsideRows = NOT_CLAMPED
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        found = {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()}
        for row in found["first_bad_rows"]:
            if not row["file"]:
                del row["file"]
        return found
