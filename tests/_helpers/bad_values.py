"""What no function should choke on: expressions of wrong values, and ways to damage a file."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from typing import Any

import numpy as np


class Anything:
    """An object that no function takes."""


class Lying:
    """An object that says it is an array, and gives another shape each time."""

    shape, ndim, dtype = (25,), 1, np.dtype(np.float64)

    def __init__(self) -> None:
        self._rows = 0

    def __array__(self, *_: Any, **__: Any) -> Any:
        self._rows += 1
        return np.zeros((self._rows, 2))

    def __len__(self) -> int:
        return 10**9


class Text(str):
    """A text that is no `str` itself."""


def in_itself() -> list[Any]:
    endless: list[Any] = []
    endless.append(endless)
    return endless


def deep(levels: int) -> list[Any]:
    return [deep(levels - 1)] if levels else []


def structured() -> Any:
    return np.zeros(2, [("x", float), ("y", float)])


# Expressions of wrong values. Those with `given`, the right value, are left out where they have no meaning.
VALUES = [
    value.strip()
    for value in """
    None; True; 0; -1; 2**63; 10**30; 10**400; 0.5; 1e308; -1e308; 1e-320; np.nan; -np.inf; 1j;
    np.float32("nan"); np.int8(-128); np.uint64(2**64 - 1); np.longdouble("1e4000"); Decimal("1e999");
    np.datetime64("2026-01-01"); np.timedelta64(1, "s"); ""; "no such"; "a\\0b\\x1b[31m\\n"; "L" * 100_000;
    "\\ud800"; Text("LArm"); b"L\\0\\xff"; memoryview(b"12"); Path("no_such"); Path("."); (); []; [[]];
    [[1], [2, 3]]; [None]; ["a", 1]; [10**400]; [np.nan] * 25; in_itself(); deep(500); {}; {"HeadYaw": np.nan};
    {None: None}; {1, 2}; range(3); iter([1]); (x for x in "abc"); lambda *_: None; Anything; object();
    Anything(); [Anything()]; Lying(); Ellipsis; np; np.array(1.0); np.zeros(0); np.zeros((0, 25));
    np.zeros((2, 2)); np.zeros((1,) * 32); np.full(25, np.nan); np.full(3, 1e308); np.full((3, 3), -np.inf);
    np.zeros(25, complex); np.zeros(25, bool); np.array([None, "x"], object); np.array(["a", "b"]);
    structured(); np.zeros(25, "datetime64[s]"); np.ma.masked_all(25); np.matrix(np.eye(3));
    np.broadcast_to(0.0, (10**12, 3)); np.broadcast_to(0.0, (10**12, 25)); given * np.nan; given * 1e308;
    -given; np.asarray(given)[..., :-1]; np.asarray(given, object); np.asarray(given, ">f8");
    np.ma.masked_equal(given, np.ravel(given)[0]); np.broadcast_to(given, (0, *np.shape(given)));
    np.broadcast_to(given, (10**12, *np.shape(given))); [given, *given]; given[:-1]; given[::-1]
    """.split(";")
]

_NUMBER = re.compile(rb"\d+(?:\.\d*)?")
_HUGE = (b"1e308", b"1" * 400, b"nan", b"-1", b"1e-400", b"0", b"99999999999", b"x", b"")


def _one_number(data: bytes, rng: random.Random) -> bytes:
    found = list(_NUMBER.finditer(data))
    if not found:
        return data
    match = rng.choice(found)
    return data[: match.start()] + rng.choice(_HUGE) + data[match.end() :]


def _flipped(data: bytes, rng: random.Random) -> bytes:
    flipped = bytearray(data)
    for _ in range(8 if data else 0):
        flipped[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(flipped)


def _text(change: Callable[[str], str], encoding: str = "utf-8") -> Callable[[bytes, random.Random], bytes]:
    return lambda data, rng: change(data.decode("latin-1")).encode(encoding)


def _lines(data: bytes, rng: random.Random) -> bytes:
    lines = data.splitlines(keepends=True)
    rng.shuffle(lines)
    return b"".join(lines)


# A way to damage a file → its bytes from those of the right one.
DAMAGES: dict[str, Callable[[bytes, random.Random], bytes]] = {
    "empty": lambda data, rng: b"",
    "cut": lambda data, rng: data[: rng.randrange(len(data) or 1)],
    "without its end": lambda data, rng: data[:-1],
    "without its beginning": lambda data, rng: data[rng.randrange(len(data) or 1) :],
    "of NUL": lambda data, rng: b"\0" * len(data),
    "with a NUL": lambda data, rng: data[: len(data) // 2] + b"\0" + data[len(data) // 2 :],
    "with escapes": lambda data, rng: data.replace(b"a", b"\x1b[31m"),
    "in UTF-16": _text(str, "utf-16"),
    "with a mark": lambda data, rng: b"\xef\xbb\xbf" + data,
    "with CRLF": lambda data, rng: data.replace(b"\n", b"\r\n"),
    "with CR": lambda data, rng: data.replace(b"\n", b"\r"),
    "without UTF-8": lambda data, rng: data.replace(b"e", b"\xe9\xff"),
    "with flipped bits": _flipped,
    "with a wrong number": _one_number,
    "with another wrong number": _one_number,
    "with wrong numbers": lambda data, rng: _NUMBER.sub(lambda _: rng.choice(_HUGE), data),
    "with huge numbers": lambda data, rng: _NUMBER.sub(b"1e308", data),
    "with nan": lambda data, rng: _NUMBER.sub(b"nan", data),
    "with nines": lambda data, rng: re.sub(rb"\d", b"9", data),
    "with zeros": lambda data, rng: re.sub(rb"\d", b"0", data),
    "with another magic": lambda data, rng: b"\x93NUMPY" + data[6:],
    "shuffled": _lines,
    "of brackets": lambda data, rng: b"[" * 100_000,
    "of tags": lambda data, rng: b"<a>" * 100_000,
    "of a long line": lambda data, rng: b"x" * 1_000_000,
    "of long names": lambda data, rng: data.replace(b"Head", b"H" * 10_000),
    "twice": lambda data, rng: data + data,
    "of another format": lambda data, rng: b"PK\x03\x04" + data,
    "of JSON": lambda data, rng: b'{"positions": [null, {"a": [1e999, NaN]}], "name": 3}',
    "of TOML": lambda data, rng: b"LArm = nan\n[joints]\nHeadYaw = [1, {}]\n",
    "of CSV": lambda data, rng: b"time,HeadYaw,HeadYaw,\n\n0,,nan\n1,2,3,4,5\n",
    "of XML": lambda data, rng: b'<robot name="\xc3"><link/><joint type="revolute"><limit lower="nan"/></joint>',
}
