"""JSON text that remembers where its values stand."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from typing import Any

from nao_kin._text import quoted
from nao_kin.errors import BadInputFile

_BLANK = re.compile(r"[ \t\n\r]*")
_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[{}]')
_COLON = re.compile(r"[ \t\n\r]*:")
_PLAIN = re.compile(r"[A-Za-z_]\w{0,39}", re.ASCII)


class Constant(str):
    """NaN, Infinity or -Infinity, which JSON does not know and Python's reader takes; kept to be refused by name."""


class JsonDocument:
    """A JSON text and its value.

    Positions are looked up in the text again, for messages only: reading stays as fast as Python's own.

    Attributes:
        value: what the text writes.
    """

    value: Any

    def __init__(self, name: str, text: str) -> None:
        """Read the text.

        Raises:
            BadInputFile: no JSON, a name twice in one object, too deep.
        """
        self._text = text
        self._members = dict[str | int, int]()
        try:
            self.value = json.loads(text, object_pairs_hook=_object, parse_constant=Constant)
        except _Twice:
            key, at = _second_key(text)
            raise BadInputFile(
                name, f"{quoted(key)} is given twice in one object", *self._line_and_column(at)
            ) from None
        except json.JSONDecodeError as error:
            raise BadInputFile(name, f"malformed JSON: {error.msg}", error.lineno, error.colno) from None
        except (ValueError, RecursionError) as error:  # a number of thousands of digits, lists in lists in lists
            raise BadInputFile(name, f"JSON of too long numbers or too deep lists: {error}") from None

    def position(self, path: Sequence[str | int]) -> tuple[int, int]:
        """1-based line and column of the value that a path of names and indices leads to."""
        return self._line_and_column(self._offset(path))

    @staticmethod
    def words(path: Sequence[str | int]) -> str:
        """A path as programmers write it: keys[3][2], motion[0].keyframes."""
        words = ""
        for step in path:
            if isinstance(step, int):
                words += f"[{step}]"
            elif _PLAIN.fullmatch(step):
                words += f".{step}" if words else step
            else:
                words += f"[{quoted(step, 40)}]"
        return words

    def _offset(self, path: Sequence[str | int]) -> int:
        if not path:
            return self._skip(0)
        # What stands behind a million numbers is looked up once.
        if path[0] not in self._members:
            self._members[path[0]] = self._walked(self._skip(0), path[:1])
        return self._walked(self._members[path[0]], path[1:])

    def _walked(self, at: int, path: Sequence[str | int]) -> int:
        """Where the value is that a path leads to from the value at an offset."""
        for step in path:
            is_list = self._text[at] == "["
            at = self._skip(at + 1)
            index = 0
            while True:
                if not is_list:
                    key, end = _DECODER.raw_decode(self._text, at)
                    at = self._skip(self._skip(end) + 1)
                if step == (index if is_list else key):
                    break
                at = self._skip(self._skip(_DECODER.raw_decode(self._text, at)[1]) + 1)
                index += 1
        return at

    def _skip(self, at: int) -> int:
        match = _BLANK.match(self._text, at)
        return match.end() if match else at

    def _line_and_column(self, at: int) -> tuple[int, int]:
        return self._text.count("\n", 0, at) + 1, at - self._text.rfind("\n", 0, at)


_DECODER = json.JSONDecoder()


class _Twice(Exception):
    """A name stands twice in one object."""


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise _Twice
    return found


def _second_key(text: str) -> tuple[str, int]:
    """The first name that its object already has, and where it stands, in a text that is valid up to there."""
    open_objects: list[set[str]] = []
    for token in _TOKEN.finditer(text):
        if token[0] == "{":
            open_objects.append(set())
        elif token[0] == "}":
            open_objects.pop()
        elif _COLON.match(text, token.end()):
            key = json.loads(token[0], strict=False)
            if key in open_objects[-1]:
                return key, token.start()
            open_objects[-1].add(key)
    return "a name", 0
