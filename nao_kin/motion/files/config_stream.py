"""Configuration streams, the text form of B-Human's data and of that of teams that began with B-Human's code.

    name = value;  // a comment

A value is a number, with or without a unit behind it (30deg), a word, a text in quotes, a list [value, value] or an
object {name = value; name = value;}.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from nao_kin._core.arrays import decimal
from nao_kin._core.text import MOST_SHOWN, quoted
from nao_kin.motion.files.source import Place, Source

_TOKEN = re.compile(
    r'\s+|//[^\n]*|/\*.*?\*/|(?P<mark>[{}\[\]=;,])|(?P<word>"(?:[^"\\]|\\.)*"|(?:(?!//|/\*)[^\s{}\[\]=;,"])+)',
    re.DOTALL,
)
_NUMBER = re.compile(r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)([A-Za-z]*)", re.ASCII)
_ANGLES = {"rad": 1.0, "deg": math.pi / 180.0}
_DEEPEST = 200


@dataclass(frozen=True)
class Word:
    """A number or a word.

    Attributes:
        text: as it stands in the file.
        at: where, in characters.
    """

    text: str
    at: int


class Fields(dict[str, Any]):
    """The values of an object by name, and where it begins."""

    at = 0


class Items(list[Any]):
    """The values of a list, and where it begins."""

    at = 0


class ConfigStream:
    """A file that is read as a configuration stream.

    Attributes:
        fields: all that it holds.
    """

    def __init__(self, source: Source) -> None:
        """Read the file.

        Raises:
            BadInputFile: with line and column.
        """
        self._source = source
        self._tokens = self._split(source.text)
        self._next = 0
        self.fields = self._fields("", 0)

    def place(self, value: Word | Fields | Items) -> Place:
        """Where a value stands."""
        return self._place(value.at)

    def error(self, reason: str, value: Word | Fields | Items) -> Exception:
        """What to raise for a value."""
        return self._source.error(reason, self.place(value))

    def get(self, fields: Fields, name: str, kind: type[Any]) -> Any:
        """A value of an object, which must be there and be a Word, Fields or Items."""
        value = fields.get(name)
        if not isinstance(value, kind):
            wanted = {Fields: "an object {…}", Items: "a list […]", Word: "a number or a word"}[kind]
            got = "nothing" if value is None else _kind(value)
            raise self.error(f"{name} is {got}, expected {wanted}", fields if value is None else value)
        return value

    def objects(self, rows: Items, what: str) -> Iterator[Fields]:
        """The objects of a list, which all its values must be."""
        for row in rows:
            if not isinstance(row, Fields):
                raise self.error(f"expected an object {{…}}{what}", row)
            yield row

    def number(self, value: Any, what: str, plain: str = "rad") -> float:
        """A finite number, angles in radians; one without a unit is in the unit `plain`, or in none ("")."""
        match = _NUMBER.fullmatch(value.text) if isinstance(value, Word) else None
        units: dict[str, float] = _ANGLES if plain else {"": 1.0}
        try:
            if match is None or (match[2] and match[2] not in units):
                raise ValueError
            number = decimal(match[1]) * units[match[2] or plain]
        except ValueError:
            number = math.inf
        if not math.isfinite(number):
            got = quoted(value.text, MOST_SHOWN) if isinstance(value, Word) else _kind(value)
            unit = f" in {' or '.join(_ANGLES)}" if plain else ""
            raise self.error(f"{what} is {got}, expected a number{unit}", value)
        return number

    def _place(self, at: int) -> Place:
        before = self._source.text[:at]
        return Place(before.count("\n") + 1, at - before.rfind("\n"))

    def _split(self, text: str) -> list[tuple[str, str, int]]:
        """Marks and words, each with where it stands, and an empty mark at the end."""
        tokens, at = [], 0
        while at < len(text):
            match = _TOKEN.match(text, at)
            if match is None:
                raise self._source.error(f"unexpected {quoted(text[at : at + 10])}", self._place(at))
            if match.lastgroup:
                tokens.append((match.lastgroup, match[0], at))
            at = match.end()
        return [*tokens, ("mark", "", len(text))]

    def _take(self, *wanted: str) -> tuple[str, str, int]:
        """The next token, which is to be one of some marks, or "a word"."""
        kind, text, at = self._tokens[self._next]
        if not (text in wanted if kind == "mark" else "a word" in wanted):
            got = quoted(text, MOST_SHOWN) if text else "the end of the file"
            shown = " or ".join(mark or "the end of the file" for mark in wanted)
            raise self._source.error(f"{got}, expected {shown}", self._place(at))
        self._next += 1
        return kind, text, at

    def _value(self, depth: int) -> Word | Fields | Items:
        kind, text, at = self._take("a word", "{", "[")
        if kind == "word":
            return Word(text.strip('"'), at)
        if depth > _DEEPEST:
            raise self._source.error(f"values more than {_DEEPEST} deep", self._place(at))
        found = self._fields("}", depth) if text == "{" else self._items(depth)
        found.at = at
        return found

    def _fields(self, end: str, depth: int) -> Fields:
        found = Fields()
        while self._tokens[self._next][:2] != ("mark", end):
            _, name, at = self._take("a word", end)
            if name in found:
                raise self._source.error(f"{quoted(name, MOST_SHOWN)} is given twice", self._place(at))
            self._take("=")
            found[name] = self._value(depth + 1)
            self._take(";")
        self._take(end)
        return found

    def _items(self, depth: int) -> Items:
        found = Items()
        while self._tokens[self._next][:2] != ("mark", "]"):
            found.append(self._value(depth + 1))
            if self._tokens[self._next][:2] != ("mark", "]"):
                self._take(",", "]")
        self._take("]")
        return found


def _kind(value: Any) -> str:
    return "an object" if isinstance(value, Fields) else "a list" if isinstance(value, Items) else "a word"
