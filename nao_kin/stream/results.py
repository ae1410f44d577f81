"""What a run over a large file reports when it is done."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

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

    Examples:
        >>> bad = nk.stream.BadRow(row=7, line=9, column=3, reason="no finite number: 'x'")
        >>> bad.line, bad.reason
        (9, "no finite number: 'x'")
    """

    row: int
    line: int
    column: int
    reason: str

    def __str__(self) -> str:
        place = f"line {self.line}" + (f", column {self.column}" if self.column else "")
        return f"{place if self.line else f'row {self.row}'}: {self.reason}"


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
        bad = [{"row": b.row, "line": b.line, "column": b.column, "reason": b.reason} for b in self.first_bad_rows]
        return {
            "sink": self.sink,
            "frames": list(self.frames),
            "columns": list(self.columns),
            "rows_read": self.rows_read,
            "rows_written": self.rows_written,
            "rows_resumed": self.rows_resumed,
            "bad_rows": self.bad_rows,
            "first_bad_rows": bad,
        }
