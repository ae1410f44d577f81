"""The summary of a run, and the folder next to its output with finished parts, so that it can be resumed.

    poses.parquet.parts/
        run.json           inputs of the parts: source, robot, arguments, version
        part-000000        rows of the first part, in a form that is quickly joined
        part-000000.json   end of the part in the source, counts so far, and a checksum; without it a part is not valid
        unfinished         the file being written
        lock               held by the process that writes here

Every file is written under the name "unfinished", synchronised with the disk, and renamed. The checksum, a crc32, is
that of the inputs, the part and its record together, so that a part of another run or a damaged one is not valid.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import pickle
import tempfile
import threading
import zlib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

from nao_kin._core.files import sync
from nao_kin._core.process import before_ending
from nao_kin._core.text import abbreviated, one_line_repr
from nao_kin.errors import BadArgument
from nao_kin.robot import OutsideRows, RobotModel
from nao_kin.stream.sources import Position

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
    clamped: OutsideRows = field(default_factory=OutsideRows)
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        found = {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()}
        for row in found["first_bad_rows"]:
            if not row["file"]:
                del row["file"]
        return found


# --- The folder.

_RUN, _LOCK, _UNFINISHED = "run.json", "lock", "unfinished"
_READ_AT_ONCE = 1 << 20


@dataclass(frozen=True)
class Progress:
    """Progress of a run."""

    end: Position  # beginning of the next block in the source
    rows_read: int = 0  # bad ones included
    rows_written: int = 0  # rows of the parts so far
    bad_rows: int = 0  # without a valid configuration
    first_bad_rows: tuple[BadRow, ...] = ()
    clamped: OutsideRows = field(default_factory=OutsideRows)

    @classmethod
    def of(cls, record: dict[str, Any]) -> Progress:
        """Return the progress in a record, which `dataclasses.asdict` has made."""
        end, bad, clamped = (record.pop(name) for name in ("end", "first_bad_rows", "clamped"))
        return cls(
            tuple(end), first_bad_rows=tuple(BadRow(**row) for row in bad), clamped=OutsideRows(**clamped), **record
        )


class PartFolder:
    """The finished parts of one output."""

    def __init__(self, output: Path | None) -> None:
        """Open and lock the folder of an output file; a device or a pipe (None) gets a temporary folder."""
        self.resumable = output is not None  # a later run may use them
        self.busy = threading.RLock()  # held while a part is written, so that a signal never interrupts a part
        self.parts: list[Path] = []
        self.last: Progress | None = None  # progress at their end; None before the first
        self._run = 0  # checksum of the inputs
        if output is None:
            self.path = Path(tempfile.mkdtemp(prefix="nao_kin-"))
        else:
            self.path = output.with_name(f"{output.name}.parts")
            self._check_ours()
            self.path.mkdir(exist_ok=True)
        import fcntl

        self._lock = (self.path / _LOCK).open("wb")
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._lock.close()
            raise BadArgument(f"cannot write {abbreviated(output)}: another process is writing it") from None
        self._registered = before_ending(self._end)

    @property
    def unfinished(self) -> Path:
        """The file to write first."""
        return self.path / _UNFINISHED

    def resume(self, run: Mapping[str, Any] | None) -> str:
        """Find the parts of an earlier run of the same inputs, or delete the parts and return which inputs changed."""
        self.resumable = self.resumable and run is not None
        before = _read_json(self.path / _RUN)
        run = run or {}
        changed = ", ".join(key for key in run if before and before.get(key) != run[key])
        if changed or not (run and before):
            self._clear()
        self._write_json(_RUN, run)
        self._run = zlib.crc32(json.dumps(run).encode())
        self._find_parts()
        return changed

    def add(self, file: BinaryIO, progress: Progress) -> None:
        """Turn `file`, the file named "unfinished", into the next part."""
        sync(file)
        file.close()
        part = self.path / f"part-{len(self.parts):06d}"
        os.replace(self.unfinished, part)
        record = asdict(progress)
        self._write_json(f"{part.name}.json", {"progress": record, "crc32": self._checksum(part, record)})
        self.parts.append(part)
        self.last = progress

    def leave(self) -> None:
        """Delete the files that no later run can use."""
        if self.resumable and self.parts:
            with suppress(OSError):
                self.unfinished.unlink()
            return
        self._clear()
        for name in (_RUN, _LOCK):
            with suppress(OSError):
                (self.path / name).unlink()
        with suppress(OSError):
            self.path.rmdir()

    def _end(self) -> None:
        """Leave when the process ends; the lock on writing stays held, so that no further part is written."""
        self.busy.acquire()
        self.leave()

    def close(self) -> None:
        """Leave, and release the locks."""
        self.leave()
        self._registered.close()
        self._lock.close()

    def _check_ours(self) -> None:
        """Refuse a file or folder at the path of the parts that is not from an earlier run."""
        with suppress(FileNotFoundError):
            names = set(os.listdir(self.path))
            if names and not names <= {_LOCK, _UNFINISHED} and not (self.path / _RUN).is_file():
                raise BadArgument(f"{abbreviated(self.path)} is in the way: it is not from an earlier run")

    def _find_parts(self) -> None:
        while True:
            part = self.path / f"part-{len(self.parts):06d}"
            record = _read_json(part.with_name(f"{part.name}.json")) or {}
            try:
                if record["crc32"] != self._checksum(part, record["progress"]):
                    return
                self.last = Progress.of(record["progress"])
            except (OSError, KeyError, TypeError, ValueError, AttributeError):
                return  # no record of this version
            self.parts.append(part)

    def _checksum(self, part: Path, record: Any) -> int:
        found = zlib.crc32(json.dumps(record).encode(), self._run)
        with part.open("rb") as file:
            while block := file.read(_READ_AT_ONCE):
                found = zlib.crc32(block, found)
        return found

    def _clear(self) -> None:
        self.parts.clear()
        self.last = None
        for path in (*self.path.glob("part-*"), self.unfinished):
            with suppress(OSError):
                path.unlink()

    def _write_json(self, name: str, content: Mapping[str, Any]) -> None:
        with self.unfinished.open("wb") as file:
            file.write(json.dumps(content).encode())
            sync(file)
        os.replace(self.unfinished, self.path / name)


def _read_json(path: Path) -> dict[str, Any] | None:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return content if isinstance(content, dict) else None


def digest_of(robot: RobotModel) -> str:
    """Return a digest of the pickled values of a robot, independent of objects shared in memory.

    dask's `tokenize` is ten times slower here, and before 2025 it orders dictionaries by hashes with a random seed.
    """
    written = io.BytesIO()
    pickler = pickle.Pickler(written, protocol=4)
    pickler.fast = True  # every value in full, not as a reference to an earlier equal value
    pickler.dump((type(robot).__module__, type(robot).__qualname__, robot.__getstate__()))
    return hashlib.sha256(written.getvalue()).hexdigest()[:32]
