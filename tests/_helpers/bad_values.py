"""Wrong values as users give them, as expressions, and ways to damage a file."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

# Expressions of wrong values. Those with `given`, the right value, are left out where they have no meaning.
VALUES = [
    value.strip()
    for value in """
    None; True; 0; -1; 10**6; 0.5; 1e6; 1e-12; np.nan; -np.inf; 1j; np.float32(0.1); np.int8(-1); ""; "no such";
    "LArm"; b"LArm"; Path("no_such"); Path("."); (); []; [[]]; [[1], [2, 3]]; [None]; ["a", 1]; [np.nan] * 25; {};
    {"HeadYaw": np.nan}; {"HeadYaw": "0.1"}; {None: None}; {"LArm"}; range(3); iter([1]); (x for x in "abc");
    lambda *_: None; object(); np.array(1.0); np.zeros(0); np.zeros((0, 25)); np.zeros((2, 2)); np.zeros(26);
    np.full(25, np.nan); np.full((3, 3), -np.inf); np.zeros(25, complex); np.zeros(25, bool); np.zeros((25, 2)).T;
    np.array([None, "x"], object); np.array(["a", "b"]); np.ma.masked_all(25); given * np.nan; given * 1e6;
    np.degrees(given); -given; np.asarray(given)[..., :-1]; np.asarray(given)[::-1]; np.asarray(given, object);
    np.asarray(given, ">f8"); np.asarray(given, "f4"); np.broadcast_to(given, (0, *np.shape(given)));
    np.stack([given] * 40); [given, *given]; given[:-1]; given[::-1]; given.upper()
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
