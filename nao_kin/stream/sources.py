"""Where configurations come from: the kind of a file, by the ending of its name."""

from __future__ import annotations

from pathlib import Path

from nao_kin._common.optional import need_extra
from nao_kin._text import abbreviated
from nao_kin.errors import BadInputFile
from nao_kin.robot import RobotModel
from nao_kin.stream.blocks import Source
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
    return KINDS.get(Path(path).suffix.lower())


def open_source(path: str | Configurations, robot: RobotModel) -> Source:
    """The table in a file, whose kind its ending names; without an ending of ours, it is CSV.

    Raises:
        BadInputFile: it cannot be read, or its columns are not the joints of the robot.
        MissingExtra: pyarrow is needed and not installed.
    """
    if isinstance(path, Configurations):
        return ArraySource(path, robot)
    kind, json = kind_of(path), Path(path).suffix.lower() == ".json"
    if kind != NPY and not json:
        need_extra(f"reading {abbreviated(path)} as a stream", "arrow")
    try:
        if kind == NPY:
            return NpySource(path, robot)
        if kind == PARQUET:
            return ParquetSource(path, robot)
        if kind == ARROW:
            return ArrowSource(path, robot)
        if json:
            raise BadInputFile(path, "JSON is read whole, not as a stream; expected CSV, npy, Parquet or Arrow")
        return CsvSource(path, robot)
    except OSError as error:
        raise BadInputFile(path, f"cannot be read: {error.strerror or error}") from None
