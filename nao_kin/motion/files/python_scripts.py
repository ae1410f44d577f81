"""Motions in Python: Choregraphe's export, and the arguments of NAOqi's angleInterpolation."""

from __future__ import annotations

import ast
import json
import math
import operator
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nao_kin._core.files import described
from nao_kin._core.text import abbreviated
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadInputFile
from nao_kin.motion.files.choregraphe import control_points, plain_keys, points
from nao_kin.motion.files.source import (
    FilePosition,
    FilePositionOf,
    Format,
    MotionFileWarning,
    MotionSource,
    chosen,
    has_line,
    in_json,
)
from nao_kin.motion.files.tracks import Track, is_hand, motion_of
from nao_kin.motion.motion import Motion
from nao_kin.robot.nao import BODY_ORDER, CHAINS

# --- Split text of Python 2 or 3 into statements, without running or parsing it.
#
# Choregraphe's exports end in `except BaseException, err:` and `print err`, which the parser of Python 3 refuses.

_TOKEN = re.compile(
    r"""
    (?P<code> [^'"\#\\;\n]+ )
    | '{3}(?:.*?'{3}|.*) | "{3}(?:.*?"{3}|.*) | '(?:[^\\'\n]|\\.)*' | "(?:[^\\"\n]|\\.)*"
    | (?P<comment> \#[^\n]* ) | (?P<continued> \\\n ) | (?P<end> [;\n] ) | .
    """,
    re.DOTALL | re.VERBOSE,
)
_DEFINITION = re.compile(r"\s*def[ \t]+(?P<name>\w+)")


@dataclass(frozen=True)
class Statement:
    """A statement on its own line, or between semicolons; the head of a block counts as one."""

    text: str  # as in the file, with comments replaced by blanks
    line: int  # of its beginning, from 1
    column: int  # of its beginning, from 1
    function: str  # the innermost function around it, by indentation; "" for none

    def place(self, offset: int, where: str = "") -> FilePosition:
        """Return the place of a character of the statement."""
        lines, last = self.text.count("\n", 0, offset), self.text.rfind("\n", 0, offset)
        return FilePosition(self.line + lines, offset - last if lines else self.column + offset, where)


def statements(text: str) -> Iterator[Statement]:
    """Yield the statements of a text that ends in a line feed."""
    functions: list[tuple[int, str]] = []
    parts: list[str] = []
    depth, begin, line = 0, 0, 1
    for token in _TOKEN.finditer(text):
        part, kind = token[0], token.lastgroup
        if kind == "code":
            opened = part.count("(") + part.count("[") + part.count("{")
            depth = max(depth + opened - part.count(")") - part.count("]") - part.count("}"), 0)
        elif kind == "comment":
            part = " " * len(part)
        elif kind == "continued":
            part = " \n"
        ended = kind == "end" and depth == 0
        if not ended:
            parts.append(part)
        if ended or token.end() == len(text):
            statement, column = "".join(parts), begin - text.rfind("\n", 0, begin)
            if column == 1 and statement.strip():
                _enter(functions, statement)
            yield Statement(statement, line, column, functions[-1][1] if functions else "")
            line += text.count("\n", begin, token.end())
            parts, begin = [], token.end()


def _enter(functions: list[tuple[int, str]], statement: str) -> None:
    """Leave the functions that end before a statement, and enter the one that it defines."""
    depth = len(statement[: -len(statement.lstrip())].expandtabs(8))
    while functions and functions[-1][0] >= depth:
        functions.pop()
    definition = _DEFINITION.match(statement)
    if definition:
        functions.append((depth, definition["name"]))


# --- Choregraphe's Python export: lists of names, times and keys, with or without Bezier control points.
#
#     names = list()
#     times = list()
#     keys = list()
#
#     names.append("HeadYaw")
#     times.append([0.5, 1.0])
#     keys.append([[0.3, [3, -0.166667, 0], [3, 0.166667, 0]], [0, [3, -0.166667, 0], [3, 0, 0]]])
#
# Only statements that begin with names, times or keys (also self.names …) are read: an empty list, .append(…) or a list
# written out. Their numbers may be products, quotients and sums, math.radians(…), almath.TO_RAD and math.pi. Nothing in
# the file is ever run. A file may hold several motions: each `names = …` begins one, named after its function.

_LISTS = ("names", "times", "keys")
_STATEMENT = re.compile(
    r"\s*(?:self\s*\.\s*)?(?P<list>names|times|keys)\s*(?:(?P<append>\.\s*append\s*\()|=(?!=))\s*", re.ASCII
)
# All three lists emptied in one statement; and other changes of a list.
_EMPTIED = re.compile(r"\s*names\s*,\s*times\s*,\s*keys\s*=\s*(?:\[\]|list\(\))(?:\s*,\s*(?:\[\]|list\(\))){2}\s*")
_CHANGED = re.compile(
    r"\s*(?:self\s*\.\s*)?(?:names|times|keys)\s*(?:,|\[|[-+*/]=|\.\s*(?!append\b)\w+\s*\()", re.ASCII
)
_MENTION = re.compile(r"^[ \t]*(?:self\.)?names[ \t]*(?:=[^=]|\.append\()", re.MULTILINE)
# Numbers and lists that mean the same in JSON, which is read a hundred times faster than Python.
_PLAIN = re.compile(r"[\s\d.,\[\]eE+-]*", re.ASCII)
_CUT = re.compile(r"[,\[\]()]")
# Statements and numbers longer than this would need much memory or deep recursion in ast [characters].
_MAX_STATEMENT = 1 << 20
_MAX_NUMBER = 200
_CONSTANTS = {"almath.TO_RAD": math.pi / 180.0, "math.pi": math.pi}
_RADIANS = ("math.radians", "radians")
# The entries of a joint, and the position of each in the file.
_Entries = tuple[list[Any], FilePositionOf]
_OPERATIONS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


@dataclass
class _PythonExport:
    """One motion in the file: the entries of each list with their places, and the first error."""

    line: int
    function: str
    error: BadInputFile | None = None
    lists: dict[str, list[tuple[Any, FilePosition]]] = field(default_factory=lambda: {name: [] for name in _LISTS})


def _read_python(source: MotionSource) -> Motion:
    """Read the motion in an export."""
    full = [export for export in _exports(source) if any(export.lists.values()) or export.error]
    if not full:
        raise source.error("no names, times and keys")
    names = [export.function or f"line {export.line}" for export in full]
    export = full[chosen(source, names, "motions")]
    if export.error is not None:
        raise export.error
    lengths = {name: len(export.lists[name]) for name in _LISTS}
    if len(set(lengths.values())) > 1:
        shown = ", ".join(f"{count} {name}" for name, count in lengths.items())
        raise source.error(f"{shown}; expected as many of each", FilePosition(export.line))
    return _motion_of_export(source, export)


def _exports(source: MotionSource) -> list[_PythonExport]:
    """Return all motions in the file; one that cannot be read does not affect the others."""
    exports: list[_PythonExport] = []
    for statement in statements("\n".join([*source.lines, ""])):
        match = _STATEMENT.match(statement.text)
        if _EMPTIED.fullmatch(statement.text):
            exports.append(_PythonExport(statement.line, statement.function))
        elif match:
            if not exports or (match["list"] == "names" and not match["append"]):
                exports.append(_PythonExport(statement.line, statement.function))
            try:
                _take(source, exports[-1].lists, statement, match)
            except BadInputFile as error:
                exports[-1].error = exports[-1].error or error
        elif exports and _CHANGED.match(statement.text):
            shown = abbreviated(statement.text.strip(), 40)
            reason = f"{shown!r} changes a list in an unknown way; nothing in the file is run"
            place = statement.place(len(statement.text) - len(statement.text.lstrip()))
            exports[-1].error = exports[-1].error or source.error(reason, place)
    return exports


def _take(source: MotionSource, lists: dict[str, list[Any]], statement: Statement, match: re.Match[str]) -> None:
    """Add the entries of a statement to its list."""
    name, text = match["list"], statement.text[match.end() :].rstrip()
    place = statement.place(match.end(), name)
    if match["append"]:
        if not text.endswith(")"):
            raise source.error("no ) at the end of the statement", place)
        lists[name].append((_literal(source, text[:-1], place), place))
        return
    value = [] if re.fullmatch(r"list\s*\(\s*\)", text) else _literal(source, text, place)
    if not isinstance(value, list):
        raise source.error(f"expected a list, got {described(value)}", place)
    lists[name] = [(entry, place.entry(index)) for index, entry in enumerate(value)]


def _motion_of_export(source: MotionSource, export: _PythonExport) -> Motion:
    bezier = any(isinstance(rows, list) and not plain_keys(rows) for rows, _ in export.lists["keys"])
    tracks = []
    for (joint, at_name), (times, at_times), (keys, at_keys) in zip(*export.lists.values(), strict=True):
        source.check_joint(joint, at_name)
        for value, place in ((times, at_times), (keys, at_keys)):
            if not isinstance(value, list):
                raise source.error(f"expected a list, got {described(value)}", place)
        entries = (times, at_times.entry), (keys, at_keys.entry)
        tracks.append(_track(source, joint, at_name, *entries, at_keys, "key", bezier=bezier))
    return motion_of(source, tracks, "bezier" if bezier else "linear")


def _track(
    source: MotionSource,
    joint: str,
    place: FilePosition,
    times: _Entries,
    keys: _Entries,
    at_keys: FilePosition,
    what: str,
    *,
    bezier: bool,
) -> Track:
    """Return the track of a joint from its times, and as many keys, called `what` in messages, or control points."""
    (rows, time_of), (values, key_of) = times, keys
    stamps = source.floats(rows, "time", time_of)
    if len(values) != len(stamps):
        raise source.error(f"{joint} has {len(stamps)} times and {len(values)} keys", at_keys)
    handles = None
    if bezier:
        numbers, handles = control_points(source, values, stamps, key_of)
    else:
        numbers = source.floats(values, what, key_of)
    if source.degrees and not is_hand(joint):
        numbers = np.radians(numbers)
        if handles is not None:
            handles[..., 1] = np.radians(handles[..., 1])
    return Track(joint, stamps, numbers, handles, place, time_of, key_of)


def _literal(source: MotionSource, text: str, place: FilePosition) -> Any:
    """Return the list, text or number of an expression, without running it."""
    if _PLAIN.fullmatch(text):
        try:
            return json.loads(text)
        except (ValueError, RecursionError):
            pass  # numbers such as 1. and .5
    if len(text) > _MAX_STATEMENT:
        raise source.error(f"a statement of {len(text)} characters that are not only lists of decimal numbers", place)
    if max(map(len, _CUT.split(text))) > _MAX_NUMBER:
        raise source.error(f"a number or name of more than {_MAX_NUMBER} characters", place)
    try:
        tree = ast.parse(f"({text}\n)", mode="eval").body
        return _value(source, tree, place)
    except SyntaxError as error:
        raise source.error(f"not a Python list: {error.msg}", place) from None
    except (ValueError, RecursionError, MemoryError, OverflowError, ZeroDivisionError) as error:
        raise source.error(f"not a list of numbers: {abbreviated(error) or type(error).__name__}", place) from None


def _value(source: MotionSource, node: ast.expr, place: FilePosition) -> Any:
    if isinstance(node, (ast.List, ast.Tuple)):
        return [_value(source, entry, place) for entry in node.elts]
    if isinstance(node, ast.Constant) and type(node.value) in (int, float, str):
        return node.value
    name = ast.unparse(node) if isinstance(node, (ast.Attribute, ast.Name)) else ""
    if name in _CONSTANTS:
        return _CONSTANTS[name]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        number = _number(source, node.operand, place)
        return -number if isinstance(node.op, ast.USub) else number
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        left, right = _number(source, node.left, place), _number(source, node.right, place)
        return _OPERATIONS[type(node.op)](left, right)
    if isinstance(node, ast.Call) and len(node.args) == 1 and not node.keywords and ast.unparse(node.func) in _RADIANS:
        return math.radians(_number(source, node.args[0], place))
    # The parsed text has an added bracket in front.
    line, column = place.line + node.lineno - 1, node.col_offset + (place.column - 1 if node.lineno == 1 else 0)
    shown = abbreviated(ast.unparse(node), 60)
    raise source.error(
        f"{shown!r} is not a number written out; nothing in the file is run", FilePosition(line, column, place.where)
    )


def _number(source: MotionSource, node: ast.expr, place: FilePosition) -> float:
    value = _value(source, node, place)
    if type(value) not in (int, float):
        raise source.error(f"{described(value)} where a number was expected", place)
    return float(value)


def _write_python(motion: Motion, _: Motion) -> bytes:
    """Write an export: plain keys for a linear motion, otherwise Bezier control points."""
    _warn_of_zero(motion)
    kind = "simplified" if motion.interpolation == "linear" else "bezier"
    call = (
        "angleInterpolation(names, keys, times, True)"
        if motion.interpolation == "linear"
        else "angleInterpolationBezier(names, times, keys)"
    )
    lines = [f"# In the manner of Choregraphe's {kind} export, for ALMotion.{call}.", ""]
    lines += [f"{name} = list()" for name in _LISTS]
    for joint, times, keys in zip(motion.joint_names, motion.times, points(motion), strict=True):
        lines += ["", f"names.append({json.dumps(joint)})", f"times.append({times.tolist()})", f"keys.append({keys})"]
    return ("\n".join(lines) + "\n").encode()


def _warn_of_zero(motion: Motion) -> None:
    if any(times[0] <= 0.0 for times in motion.times):
        warn_caller(
            "NAOqi refuses keys at 0 s; nk.motion.time_warp(motion, lambda t: t + 1.0) (--lead 1) begins 1 s later",
            MotionFileWarning,
        )


PYTHON = Format("python", (".py",), "Choregraphe's Python export", has_line(_MENTION), _read_python, _write_python)


# --- The arguments of NAOqi's angleInterpolation and angleInterpolationBezier, as JSON.
#
#     [["HeadYaw", "HeadPitch"], [[0.3, 0.0], 0.2], [[1.0, 2.0], 1.0], true]
#     [["HeadYaw"], [[1.0]], [[[0.3, [3, -0.3, 0.0], [3, 0.0, 0.0]]]]]
#
# The first example has four arguments: names, angles, times and isAbsolute. The second has three: names, times and
# control points. As in NAOqi, names are one name, a list or a chain such as "Head" or "Body"; angles and times have a
# number or a list for each joint. An object with these arguments by name ("names", "angles" or "keys", "times",
# "isAbsolute") is read too.

_CHAINS = {**CHAINS, "Body": BODY_ORDER}
_ANGLES = ("angles", "angleLists", "keys", "controlPoints")
_TIMES = ("times", "timeLists")


def _recognises_naoqi(source: MotionSource) -> bool:
    """Return whether the file is a JSON list that begins with names, or an object with names and times."""
    value = source.json
    if isinstance(value, dict):
        return "names" in value and any(name in value for name in _TIMES)
    if not isinstance(value, list) or len(value) not in (3, 4):
        return False
    return isinstance(value[0], str) or (isinstance(value[0], list) and all(isinstance(x, str) for x in value[0]))


def _read_naoqi(source: MotionSource) -> Motion:
    """Read the motion of the call; relative angles are refused."""
    places = _places(source)
    names, single = _names(source, places["names"])
    keys, times = (_per_joint(source, places[what], names, single=single) for what in ("angles", "times"))
    bezier = any(not plain_keys(rows) for rows, _ in keys)
    at_names, at_keys = in_json(places["names"]), in_json(places["angles"])
    tracks = [
        _track(source, joint, at_names, stamps, rows, at_keys, "angle", bezier=bezier)
        for joint, stamps, rows in zip(names, times, keys, strict=True)
    ]
    return motion_of(source, tracks, "bezier" if bezier else "linear")


def _places(source: MotionSource) -> dict[str, str | int]:
    """Return the keys or indices of names, angles and times in the JSON value."""
    value, places = source.json, dict[str, str | int]()
    if isinstance(value, dict):
        source.fields(value, ("names", *_ANGLES, *_TIMES, "isAbsolute"), "argument")
        for what, choices in (("names", ("names",)), ("angles", _ANGLES), ("times", _TIMES)):
            given = [name for name in choices if name in value]
            if len(given) != 1:
                raise source.error(f"{len(given)} of {' and '.join(choices)}, expected one")
            places[what] = given[0]
        absolute, where = value.get("isAbsolute", True), in_json("isAbsolute")
    elif isinstance(value, list) and len(value) == 3:
        return {"names": 0, "times": 1, "angles": 2}
    elif isinstance(value, list) and len(value) == 4:
        places, absolute, where = {"names": 0, "angles": 1, "times": 2}, value[3], in_json(3)
    else:
        raise source.error(
            f"expected [names, angles, times, isAbsolute] or [names, times, keys], got {described(value)}"
        )
    if absolute is False or absolute == 0:
        raise source.error("relative angles: the file does not hold the angles that they are relative to", where)
    if absolute is not True and absolute != 1:
        raise source.error(f"isAbsolute is {described(absolute)}, expected true", where)
    return places


def _names(source: MotionSource, at: str | int) -> tuple[list[str], bool]:
    """Return the joints, and whether they are given as one name."""
    given = source.json[at]
    rows, place_of = _entries(given, in_json(at))
    names: list[str] = []
    for index, name in enumerate(rows):
        if isinstance(name, str) and name in _CHAINS and name not in source.joints:
            named: Sequence[str] = _CHAINS[name]
        else:
            named = [source.check_joint(name, place_of(index))]
        for joint in named:
            if joint in names:
                raise source.error(f"joint {joint} is given twice", place_of(index))
            names.append(joint)
    if not names:
        raise source.error("no names", in_json(at))
    return names, isinstance(given, str) and len(names) == 1


def _per_joint(source: MotionSource, at: str | int, names: list[str], *, single: bool) -> list[_Entries]:
    """Return the entries of each joint as a list, with the place of each entry."""
    given, place = source.json[at], in_json(at)
    if not isinstance(given, list):
        return [_entries(given, place)] * len(names)
    nested = any(isinstance(entry, list) for entry in given)
    if single and _is_points(given) if nested else 1 in (len(names), len(given)):
        return [_entries(given, place)] * len(names)
    if len(given) != len(names):
        raise source.error(f"{len(given)} entries for {len(names)} joints", place)
    return [_entries(entry, place.entry(row)) for row, entry in enumerate(given)]


def _entries(value: Any, place: FilePosition) -> _Entries:
    """Return the entries of a list with their places; any other value is one entry."""
    return (value, place.entry) if isinstance(value, list) else ([value], lambda _: place)


def _is_points(rows: list[Any]) -> bool:
    """Return whether a list is the control points of one joint, and not a list of such lists."""
    return isinstance(rows[0], list) and bool(rows[0]) and not isinstance(rows[0][0], list) and len(rows[0]) == 3


def _write_naoqi(motion: Motion, _: Motion) -> bytes:
    """Write the arguments of angleInterpolation for a linear motion, otherwise of angleInterpolationBezier."""
    _warn_of_zero(motion)
    names = json.dumps(list(motion.joint_names), ensure_ascii=False)
    stamps, keys = ([row.tolist() for row in motion.times], points(motion))
    rows = [_rows(stamps), _rows(keys)] if motion.interpolation != "linear" else [_rows(keys), _rows(stamps), "true"]
    return ("[" + ",\n ".join([names, *rows]) + "]\n").encode()


def _rows(rows: list[list[Any]]) -> str:
    return "[\n" + ",\n".join(f"  {json.dumps(row)}" for row in rows) + "]"


NAOQI = Format("naoqi", (".json",), "arguments of angleInterpolation", _recognises_naoqi, _read_naoqi, _write_naoqi)
