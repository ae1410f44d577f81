"""Tables of joint values, read block by block from any place that a block begins at."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from nao_kin._common.arrays import Floats

# Where a block begins: bytes, lines and rows before it, as far as the kind of file needs them.
Position = tuple[int, ...]


@dataclass(frozen=True)
class Block:
    """Some rows of a table.

    Attributes:
        values: shape (n, columns); NaN in rows that could not be read.
        end: where the next block begins.
        problems: column, from 1 and 0 for none, and reason of rows that could not be read, by their place in the block.
        last: no block follows.
        lines: finds the line of every row of the block, which takes a while; None where there are no lines.
    """

    values: Floats
    end: Position
    problems: Mapping[int, tuple[int, str]] = field(default_factory=dict)
    last: bool = False
    lines: Callable[[], Sequence[int]] | None = None


class Source(ABC):
    """A table of joint values in a file.

    Attributes:
        path: the file.
        names: joint of every column.
        whole: the columns are those of q itself, a floating base included.
        radians: turning joints are in radians, whatever the caller says of files.
        start: where the first block begins.
    """

    path: str
    names: tuple[str, ...]
    whole: bool = False
    radians: bool = False
    start: Position

    @abstractmethod
    def blocks(self, start: Position) -> Iterator[Block]:
        """The blocks from a place on; the same ones whatever came before."""

    @abstractmethod
    def fraction(self, place: Position) -> float | None:
        """How much of the file lies before a place; None where its length is not known."""

    def close(self) -> None:
        """Nothing more is read."""
        return
