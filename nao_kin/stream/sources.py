"""Where configurations come from: the kind of a file, by the ending of its name, and several files as one."""

from __future__ import annotations

import glob
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from nao_kin._common.optional import need_extra
from nao_kin._text import abbreviated
from nao_kin.errors import BadInputFile
from nao_kin.robot import RobotModel
from nao_kin.stream.blocks import Block, Position, Source, TableOptions
from nao_kin.stream.csv_source import CsvSource
from nao_kin.stream.table_sources import ArraySource, ArrowSource, Configurations, NpySource, ParquetSource

CSV, NPY, PARQUET, ARROW = "csv", "npy", "parquet", "arrow"
KINDS = {
    ".csv": CSV,
    ".tsv": CSV,
    ".txt": CSV,
    ".npy": NPY,
    ".parquet": PARQUET,
    ".pq": PARQUET,
    ".arrow": ARROW,
    ".feather": ARROW,
    ".ipc": ARROW,
}


def kind_of(path: str) -> str | None:
    """The kind of file that the ending of a name promises."""
    name = Path(path)
    unpacked = name.with_suffix("") if name.suffix.lower() == ".gz" else name
    return KINDS.get(unpacked.suffix.lower())


def found_files(path: str) -> list[str]:
    """The file of a name, or the files that a pattern with * or ? or [ ] stands for, sorted.

    Raises:
        BadInputFile: a pattern stands for no file.
    """
    if not glob.has_magic(path) or Path(path).exists():
        return [path]
    found = sorted(name for name in glob.glob(path, recursive=True) if Path(name).is_file())
    if not found:
        raise BadInputFile(path, "no file has such a name")
    return found


def open_source(paths: Sequence[str] | Configurations, robot: RobotModel, options: TableOptions) -> Source:
    """The table in one file or several.

    Raises:
        BadInputFile, MissingExtra: as `_opened`; some files have times and others none.
    """
    if isinstance(paths, Configurations):
        return ArraySource(paths, robot)
    if len(paths) == 1:
        return _opened(paths[0], robot, options)
    return JoinedSource(paths, robot, options)


class JoinedSource(Source):
    """Several files, one behind the other. A place is the number of a file and a place in it."""

    def __init__(self, paths: Sequence[str], robot: RobotModel, options: TableOptions) -> None:
        self._robot, self._options = robot, options
        self._files = []
        for path in paths:
            if path == "-":
                raise BadInputFile(path, "it cannot be joined with other files")
            with closing(_opened(path, robot, options)) as file:
                self._files.append(file)
        first = self._files[0]
        for file in self._files:
            if file.table.timed != first.table.timed:
                with_times, without = (first, file) if first.table.timed else (file, first)
                raise BadInputFile(without.path, f"no column of times, which {abbreviated(with_times.path)} has")
            _check_times_alike(file, first)
        self.path, self.table, self.start = first.path, first.table, (0, *first.start)

    @property
    def files(self) -> tuple[Source, ...]:
        """As `Source`."""
        return tuple(self._files)

    def blocks(self, start: Position) -> Iterator[Block]:
        """As `Source`."""
        for index in range(start[0], len(self._files)):
            with closing(_opened(self._files[index].path, self._robot, self._options)) as file:
                # Times of ISO 8601 count from the first row of all.
                file.table = replace(file.table, iso_times=self.table.iso_times)
                for block in file.blocks(start[1:] if index == start[0] else file.start):
                    last = block.last and index + 1 == len(self._files)
                    yield replace(block, end=(index, *block.end), last=last, file=index)

    def fraction(self, place: Position) -> float:
        """As `Source`."""
        return (place[0] + (self._files[place[0]].fraction(place[1:]) or 0.0)) / len(self._files)


def _check_times_alike(file: Source, first: Source) -> None:
    """Refuse times that cannot be counted on from those of the first file."""
    times, before = file.table.iso_times, first.table.iso_times
    other = abbreviated(first.path)
    if (times is None) != (before is None):
        forms = "numbers", "dates and times"
        given, expected = forms if times is None else forms[::-1]
        raise BadInputFile(file.path, f"its times are {given}, those of {other} are {expected}")
    if times is not None and before is not None and times.zoned != before.zoned:
        given, expected = ("a", "none") if times.zoned else ("no", "one")
        raise BadInputFile(file.path, f"its times have {given} time zone, those of {other} have {expected}")


def _opened(path: str, robot: RobotModel, options: TableOptions) -> Source:
    """The table in a file, whose kind its ending names; without an ending of ours, it is CSV.

    Raises:
        BadInputFile: it cannot be read, or its columns are not the joints of the robot.
        MissingExtra: pyarrow is needed and not installed.
    """
    kind, json = kind_of(path), Path(path).suffix.lower() == ".json"
    if kind != NPY and not json:
        need_extra(f"reading {abbreviated(path)} as a stream", "arrow")
    try:
        if kind == NPY:
            return NpySource(path, robot, options)
        if kind == PARQUET:
            return ParquetSource(path, robot, options)
        if kind == ARROW:
            return ArrowSource(path, robot, options)
        if json:
            raise BadInputFile(path, "JSON is read whole, not as a stream; expected CSV, npy, Parquet or Arrow")
        return CsvSource(path, robot, options)
    except OSError as error:
        raise BadInputFile(path, f"cannot be read: {error.strerror or error}") from None
