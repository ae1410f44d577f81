"""Tables of joint values, read block by block from any place that a block begins at."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from nao_kin._common.arrays import Floats
from nao_kin.configuration_files import TableColumns, table_columns
from nao_kin.robot import RobotModel

# Where a block begins: bytes, lines and rows before it, as far as the kind of file needs them.
Position = tuple[int, ...]


@dataclass(frozen=True)
class Block:
    """Some rows of a table.

    Attributes:
        values: shape (n, columns); NaN in rows that could not be read.
        end: where the next block begins.
        times: shape (n,), in the unit of the file; None where it has none.
        problems: column, from 1 and 0 for none, and reason of rows that could not be read, by their place in the block.
        last: no block follows.
        lines: finds the line of every row of the block, which takes a while; None where there are no lines.
        file: which of several files it is from.
    """

    values: Floats
    end: Position
    times: Floats | None = None
    problems: Mapping[int, tuple[int, str]] = field(default_factory=dict)
    last: bool = False
    lines: Callable[[], Sequence[int]] | None = None
    file: int = 0


class Source(ABC):
    """A table of joint values in a file.

    Attributes:
        path: the file.
        table: which columns are joints and times, and their units.
        whole: the columns are those of q itself, a floating base included.
        start: where the first block begins.
    """

    path: str
    table: TableColumns
    whole: bool = False
    start: Position

    @property
    def files(self) -> tuple[Source, ...]:
        """The source itself, or the sources that it joins."""
        return (self,)

    @abstractmethod
    def blocks(self, start: Position) -> Iterator[Block]:
        """The blocks from a place on; the same ones whatever came before."""

    @abstractmethod
    def fraction(self, place: Position) -> float | None:
        """How much of the file lies before a place; None where its length is not known."""

    def close(self) -> None:
        """Nothing more is read."""
        return


@dataclass(frozen=True)
class TableOptions:
    """How the columns of a file are understood: the arguments of `table_columns`.

    Attributes:
        degrees: turning joints without a unit are in degrees.
        columns: heading in the file → what to read it as; None leaves it out.
        ignore_other: leave out columns of other names.
    """

    degrees: bool = False
    columns: Mapping[str, str | None] | None = None
    ignore_other: bool = False

    def table(self, path: str, headings: Sequence[str], robot: RobotModel, line: int = 0) -> TableColumns:
        """What the columns of a table are."""
        return table_columns(
            path, headings, robot, line, degrees=self.degrees, columns=self.columns, ignore_other=self.ignore_other
        )

    def of_q(self, robot: RobotModel) -> TableColumns:
        """What the columns of an array of configurations are, behind those of a floating base."""
        return TableOptions(self.degrees).table("", robot.joint_names, robot)
