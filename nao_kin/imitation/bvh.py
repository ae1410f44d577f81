"""Read BVH files.

A BVH file has a hierarchy of joints, each with an OFFSET from its parent and CHANNELS, and a row of channel values for
each frame:

    R_parent_joint = R_a(α) R_b(β) R_c(γ), about moving axes, in the order in which the rotation channels are listed
    p_parent_joint = OFFSET, or its position channels where it has some

Source: Meredith and Maddock, Motion Capture File Formats Explained, University of Sheffield, CS-01-11.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from nao_kin._core.arrays import Floats, finite_decimal
from nao_kin._core.csv_numbers import plain_floats
from nao_kin._core.text import MAX_SHOWN, nearest_names, quoted
from nao_kin.errors import BadInputFile
from nao_kin.imitation.reading import Options, seconds
from nao_kin.imitation.skeleton import Skeleton
from nao_kin.imitation.trees import of_tree
from nao_kin.rotations import matrix_from_euler

_CHANNELS = tuple(axis + kind for kind in ("position", "rotation") for axis in "XYZ")
_INSIDE = ("OFFSET", "CHANNELS", "JOINT", "End Site", "}")


@dataclass
class Joint:
    """A joint or an End Site of a BVH file."""

    name: str
    parent: int
    offset: Floats = field(default_factory=lambda: np.full(3, np.nan))  # NaN until it is read
    channels: tuple[str, ...] | None = None
    column: int = 0  # of its first channel


class Bvh:
    """The joints and channel values of a BVH file."""

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self._lines = text.split("\n")
        self._words = (
            (word.group(), number, word.start() + 1)
            for number, line in enumerate(self._lines, start=1)
            for word in re.finditer(r"[{}]|[^\s{}]+", line)
        )
        self._line = self._column = 1
        self.joints: list[Joint] = []
        self._names: set[str] = set()
        self._hierarchy()
        self.frame_time, self.values = self._motion()

    def _error(self, reason: str) -> BadInputFile:
        return BadInputFile(self.name, reason, self._line, self._column)

    def _take(self, *expected: str) -> str:
        """Return the next word, which must be one of those expected, in any letter case, if there are any."""
        try:
            word, self._line, self._column = next(self._words)
        except StopIteration:
            where = expected[0] if expected else "a value"
            raise BadInputFile(
                self.name, f"ends where {where} is expected; it is incomplete", len(self._lines)
            ) from None
        if not expected:
            return word
        for one in expected:
            if word.lower() == one.split()[0].lower():
                return one
        near = nearest_names(word, expected, 1)
        wanted = (
            f"{near[0]}, or another of {', '.join(expected)}" if near and len(expected) > 1 else ", ".join(expected)
        )
        raise self._error(f"{quoted(word, MAX_SHOWN)}, expected {wanted}")

    def _number(self, what: str) -> float:
        word = self._take()
        value = finite_decimal(word)
        if value is None:
            raise self._error(f"{what} is {quoted(word, MAX_SHOWN)}, expected a finite number")
        return value

    def _count(self, what: str, least: int) -> int:
        value = self._number(what)
        if value != int(value) or value < least:
            raise self._error(f"{what} is {value:g}, expected a whole number of at least {least}")
        return int(value)

    def _open(self, parent: int, end: bool = False) -> int:
        """Begin a joint, whose name lasts until the brace; return its index."""
        words: list[str] = []
        while (word := self._take()) != "{":
            if word in _INSIDE:
                raise self._error(f"{word}, expected {{ after the name of a joint")
            words.append(word)
        name = f"{self.joints[parent].name}_end" if end else " ".join(words)
        if not name:
            raise self._error("a joint without a name")
        if not end and name in self._names:
            raise self._error(f"a second joint {quoted(name)}")
        self._names.add(name)
        self.joints.append(Joint(name, parent, channels=() if end else None))
        return len(self.joints) - 1

    def _hierarchy(self) -> None:
        """Read the joints, each after its parent."""
        self._take("HIERARCHY")
        self._take("ROOT")
        at, column = self._open(-1), 0
        while at >= 0:
            joint = self.joints[at]
            word = self._take(*_INSIDE)
            if word == "OFFSET":
                joint.offset = np.array([self._number(f"OFFSET of {joint.name}") for _ in range(3)])
            elif word == "CHANNELS":
                if joint.channels is not None:
                    raise self._error(f"CHANNELS of {joint.name}, which has them already or is an End Site")
                count = self._count("the number of channels", 0)
                joint.channels = tuple(self._take(*_CHANNELS) for _ in range(count))
                joint.column, column = column, column + count
                if len(set(joint.channels)) < count:
                    raise self._error(f"a channel twice in {joint.name}")
            elif word == "JOINT":
                at = self._open(at)
            elif word == "End Site":
                if not (site := self._take()).lower().startswith("site"):  # some number them: End Site-7
                    raise self._error(f"{quoted(site, MAX_SHOWN)}, expected Site")
                at = self._open(at, end=True)
            else:
                if joint.channels is None or np.isnan(joint.offset).any():
                    lacking = "CHANNELS" if joint.channels is None else "OFFSET"
                    raise self._error(f"{joint.name} ends without {lacking}")
                at = joint.parent
        self._width = column

    def _motion(self) -> tuple[float, Floats]:
        """Return the time from frame to frame [s], and the channel values, shape (frames, channels)."""
        self._take("MOTION")
        self._take("Frames:")
        count = self._count("the number of frames", 1)
        self._take("Frame")
        self._take("Time:")
        step = self._number("the frame time")
        if step <= 0.0:
            raise self._error(f"the frame time is {step:g}, expected more than 0")
        rows = []
        for number, line in enumerate(self._lines[self._line :], start=self._line + 1):
            fields = line.split()
            if not fields:
                continue
            self._line, self._column = number, 0
            row = plain_floats(fields) if line.isascii() and "_" not in line else None
            if row is None:
                for word in re.finditer(r"\S+", line):
                    if finite_decimal(word.group()) is None:
                        self._column = word.start() + 1
                        raise self._error(f"{quoted(word.group(), MAX_SHOWN)}, expected a finite number")
            if len(fields) != self._width:
                raise self._error(f"{len(fields)} values, expected one for each of {self._width} channels")
            rows.append(row)
        if len(rows) != count:
            ends = "; the file is incomplete" if len(rows) < count else ""
            raise self._error(f"frame {len(rows)} is the last one, but {count} frames are stated{ends}")
        return step, np.array(rows, dtype=np.float64).reshape(count, self._width)

    def local(self, joint: Joint) -> tuple[Floats, Floats]:
        """Return p_parent_joint and R_parent_joint in all frames, shapes (n, 3) and (n, 3, 3)."""
        position = np.tile(joint.offset, (len(self.values), 1))
        sequence, columns = "", []
        for column, channel in enumerate(joint.channels or (), start=joint.column):
            if channel.endswith("position"):
                position[:, "XYZ".index(channel[0])] = self.values[:, column]
            else:
                sequence += channel[0].lower()
                columns.append(column)
        if not sequence:
            return position, np.tile(np.eye(3), (len(position), 1, 1))
        return position, matrix_from_euler(np.radians(self.values[:, columns]), sequence, axes="moving")


def of_bvh(name: str, text: str, options: Options) -> Skeleton:
    """Return the skeleton of the text of a BVH file."""
    file = Bvh(name, text)
    local = [file.local(joint) for joint in file.joints]
    rest = [(joint.offset[None], np.eye(3)[None]) for joint in file.joints]
    count = len(file.values)
    times, _ = seconds(name, options, count, np.linspace(0.0, (count - 1) * file.frame_time, count), "s")
    names, parents = [joint.name for joint in file.joints], [joint.parent for joint in file.joints]
    return of_tree(times, names, parents, local, rest, options)
