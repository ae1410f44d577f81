"""What a run over a large file reports when it is done."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.robot import LIMIT_TOLERANCE, RobotModel, check_robot

# Bad rows that are kept to be shown; the others are counted.
MOST_LISTED = 20


@dataclass(frozen=True)
class BadRow:
    """A row from which no configuration could be made.

    Attributes:
        row: its number among the rows of the source, from 0, as in the column "row" of the sink.
        line: its line in a CSV file, from 1; 0 in other files, which have none.
        column: its column in a CSV file that is to blame, from 1; 0 for none.
        reason: what is wrong with it.
        file: which of several files it is from; "" where there is one.

    Examples:
        >>> bad = nk.stream.BadRow(row=7, line=9, column=3, reason="no finite number: 'x'")
        >>> bad.line, bad.reason
        (9, "no finite number: 'x'")
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


@dataclass(frozen=True)
class Clamped:
    """What moving joints to their limits has changed.

    Attributes:
        rows: how many configurations.
        most: by how much a joint at most [rad, m or ratio].
        joint: which one that was; "" for none.

    Examples:
        >>> nao = nk.load_nao()
        >>> _, clamped = nk.stream.clamp(nao, nao.configuration({"HeadYaw": [0.0, 3.0]}, limits="ignore"))
        >>> clamped.rows, clamped.joint, round(clamped.most, 3)
        (2, 'HeadYaw', 0.914)
    """

    rows: int = 0
    most: float = 0.0
    joint: str = ""

    def and_then(self, other: Clamped) -> Clamped:
        """Return the sum of both rows, with the larger amount and its joint.

        Examples:
            >>> nk.stream.Clamped(2, 0.1, "HeadYaw").and_then(nk.stream.Clamped(1, 0.3, "LHand"))
            Clamped(rows=3, most=0.3, joint='LHand')
        """
        larger = self if self.most >= other.most else other
        return Clamped(self.rows + other.rows, larger.most, larger.joint)


NOT_CLAMPED = Clamped()


def clamp(robot: RobotModel, q: Floats) -> tuple[Floats, Clamped]:
    """Return `robot.clamp(q)` and what it has changed by more than the tolerance of limits.

    Args:
        robot: whose limits.
        q: configurations, shape (n, nq).

    Examples:
        >>> nao = nk.load_nao()
        >>> nk.stream.clamp(nao, nao.posture("Stand")[None])[1].rows
        0
    """
    check_robot(robot)
    inside = robot.clamp(q)
    joints = len(robot.joint_names)
    off = np.abs(inside[:, -joints:] - np.asarray(q)[:, -joints:])
    moved = off.max(axis=1, initial=0.0) > LIMIT_TOLERANCE
    if not moved.any():
        return inside, Clamped()
    _, column = np.unravel_index(int(np.argmax(off)), off.shape)
    return inside, Clamped(int(moved.sum()), float(off.max()), robot.joint_names[int(column)])


@dataclass(frozen=True)
class StreamResult:
    """What was read and written.

    Attributes:
        sink: the file that was written.
        frames: the frames whose poses are in it.
        columns: names of the numbers of a pose.
        rows_read: rows of the source, bad ones included.
        rows_written: rows of the sink, each with one pose per frame.
        rows_resumed: rows that an earlier run had done already, of those read.
        bad_rows: rows from which no configuration could be made: left out, or written as NaN.
        first_bad_rows: the first of them.
        clamped: what limits="clamp" has changed.
        notes: what was understood of the source that it does not say.

    Examples:
        >>> from pathlib import Path
        >>> nao = nk.load_nao()
        >>> lines = nao.joint_names, map(str, nao.posture("Stand"))
        >>> _ = Path("q.csv").write_text(chr(10).join(map(",".join, lines)))
        >>> result = nk.stream.fk(nao, "q.csv", "LArm", "poses.npy")
        >>> result.rows_read, result.rows_written, result.bad_rows
        (1, 1, 0)
    """

    sink: str
    frames: tuple[str, ...]
    columns: tuple[str, ...]
    rows_read: int
    rows_written: int
    rows_resumed: int
    bad_rows: int
    first_bad_rows: tuple[BadRow, ...]
    clamped: Clamped = NOT_CLAMPED
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON.

        Examples:
            >>> from pathlib import Path
            >>> nao = nk.load_nao()
            >>> lines = nao.joint_names, map(str, nao.posture("Stand"))
            >>> _ = Path("q.csv").write_text(chr(10).join(map(",".join, lines)))
            >>> nk.stream.fk(nao, "q.csv", "LArm", "poses.npy").as_dict()["rows_written"]
            1
        """
        found = {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()}
        for row in found["first_bad_rows"]:
            if not row["file"]:
                del row["file"]
        return found
