"""Motions in Python: Choregraphe's export, and the arguments of NAOqi's angleInterpolation."""

from __future__ import annotations

import ast
import json
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from nao_kin._core.arrays import Floats
from nao_kin._core.files import described
from nao_kin._core.text import abbreviated
from nao_kin.errors import BadInputFile, nearest_names
from nao_kin.motion.files.choregraphe import control_points, plain_keys, points
from nao_kin.motion.files.source import Format, Place, Source, chosen, in_json
from nao_kin.motion.files.tracks import Track, is_hand, motion_of, sampled
from nao_kin.motion.motion import Motion
from nao_kin.robot.nao import BODY_ORDER, CHAINS

# --- Python text cut into statements, of Python 2 as well as 3, without running or even parsing it.
#
# Choregraphe's exports end in `except BaseException, err:` and `print err`, which today's parser refuses.

_TOKEN = re.compile(
    r"'''|\"\"\"|'(?:[^\\']|\\.)*'|\"(?:[^\\\"]|\\.)*\"|#.*|[()\[\]{};]|\\$",
)
# A line without any of these is only looked at for its brackets.
_SPECIAL = re.compile(r"['\"#\\;]")
_DEFINITION = re.compile(r"(?P<indent>[ \t]*)def[ \t]+(?P<name>\w+)")
_INDENT = re.compile(r"[ \t]*")


@dataclass(frozen=True)
class Statement:
    """A statement on a line of its own, or between semicolons; what ends in a colon counts as one.

    Attributes:
        text: as it stands in the file, comments replaced by blanks.
        line: 1-based line that it begins on.
        column: 1-based column that it begins at.
        function: the innermost function that it stands in, by indentation; "" for none.
    """

    text: str
    line: int
    column: int
    function: str


class _Reader:
    """Where in brackets and long strings the reading is."""

    def __init__(self) -> None:
        self.depth = 0
        self.quote = ""
        self.continued = False

    def split(self, line: str) -> list[str]:
        """The line without comment, cut where statements end inside of it."""
        self.continued = False
        if not self.quote and not _SPECIAL.search(line):
            self._count(line)
            return [line]
        pieces, begin, at = [], 0, 0
        while at <= len(line):
            if self.quote:
                end = line.find(self.quote, at)
                if end < 0:
                    break
                at, self.quote = end + 3, ""
            token = _TOKEN.search(line, at)
            if token is None:
                break
            at = token.end()
            mark = token[0]
            if mark in ("'''", '"""'):
                self.quote = mark
            elif mark[0] == "#":
                line = line[: token.start()] + " " * len(mark)
            elif mark == "\\":
                line, self.continued = line[: token.start()] + " ", True
            elif mark == ";" and self.depth == 0:
                pieces.append(line[begin : token.start()])
                begin = at
            else:
                self._count(mark if len(mark) == 1 else "")
        return [*pieces, line[begin:]]

    def _count(self, text: str) -> None:
        opened = text.count("(") + text.count("[") + text.count("{")
        self.depth = max(self.depth + opened - text.count(")") - text.count("]") - text.count("}"), 0)


def statements(lines: list[str]) -> Iterator[Statement]:
    """The statements of a text."""
    reader = _Reader()
    functions: list[tuple[int, str]] = []
    parts: list[str] = []
    begin, column = 1, 1
    for number, line in enumerate(lines, start=1):
        if not parts:
            begin, column = number, 1
            _enter(functions, line)
        for index, piece in enumerate(reader.split(line)):
            if index:
                yield Statement("\n".join(parts), begin, column, functions[-1][1] if functions else "")
                column = len("\n".join(parts)) + 1 + column if begin == number else 1
                parts, begin = [], number
            parts.append(piece)
        if reader.depth == 0 and not reader.quote and not reader.continued:
            yield Statement("\n".join(parts), begin, column, functions[-1][1] if functions else "")
            parts = []
    if parts:
        yield Statement("\n".join(parts), begin, column, functions[-1][1] if functions else "")


def _enter(functions: list[tuple[int, str]], line: str) -> None:
    """Leave the functions that end before a line, and enter the one that it defines."""
    if not line.strip() or line.lstrip().startswith("#"):
        return
    indent = _INDENT.match(line)
    depth = len(indent[0].expandtabs(8)) if indent else 0
    while functions and functions[-1][0] >= depth:
        functions.pop()
    found = _DEFINITION.match(line)
    if found:
        functions.append((depth, found["name"]))


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
# Only statements that begin with names, times or keys (also self.names …) are looked at: an empty list, .append(…) or
# a list written out. Their numbers may be products, quotients and sums, math.radians(…), almath.TO_RAD and math.pi.
# Nothing in the file is ever run. A file may hold several motions: each `names = …` begins one, known by its
# function.

_LISTS = ("names", "times", "keys")
_STATEMENT = re.compile(
    r"\s*(?:self\s*\.\s*)?(?P<list>names|times|keys)\s*(?:(?P<append>\.\s*append\s*\()|=(?!=))\s*", re.ASCII
)
# Empty lists for all of them at once; and what else changes one of them.
_EMPTIED = re.compile(r"\s*names\s*,\s*times\s*,\s*keys\s*=\s*(?:\[\]|list\(\))(?:\s*,\s*(?:\[\]|list\(\))){2}\s*")
_CHANGED = re.compile(
    r"\s*(?:self\s*\.\s*)?(?:names|times|keys)\s*(?:,|\[|[-+*/]=|\.\s*(?!append\b)\w+\s*\()", re.ASCII
)
_MENTION = re.compile(r"^[ \t]*(?:self\.)?names[ \t]*(?:=[^=]|\.append\()", re.MULTILINE)
# Numbers and lists that JSON reads as Python does, at a hundred times its speed.
_PLAIN = re.compile(r"[\s\d.,\[\]eE+-]*", re.ASCII)
_CUT = re.compile(r"[,\[\]()]")
# Beyond these, ast would need much memory or deep recursion: characters of a statement, and of a number in it.
_LONGEST_STATEMENT = 1 << 20
_LONGEST_NUMBER = 200
_CONSTANTS = {"almath.TO_RAD": math.pi / 180.0, "math.pi": math.pi}
_RADIANS = ("math.radians", "radians")
_OPERATIONS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
}


@dataclass
class _Export:
    """One motion in the file: what was put into each list, and where; and what is wrong with it, if something is."""

    line: int
    function: str
    error: BadInputFile | None = None
    lists: dict[str, list[Any]] = field(default_factory=lambda: {name: [] for name in _LISTS})
    places: dict[str, list[Place]] = field(default_factory=lambda: {name: [] for name in _LISTS})

    def put(self, name: str, value: Any, place: Place) -> None:
        self.lists[name].append(value)
        self.places[name].append(place)


def _recognises_python(source: Source) -> bool:
    """Whether some line begins with names = or names.append(."""
    return _MENTION.search(source.text) is not None


def _read_python(source: Source) -> Motion:
    """The motion in an export.

    Raises:
        BadInputFile: with line and column; several motions and none or an unknown one is chosen.
    """
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
        raise source.error(f"{shown}; expected as many of each", Place(export.line))
    return _motion(source, export)


def _exports(source: Source) -> list[_Export]:
    """All motions in the file; one that cannot be read does no harm to the others."""
    exports: list[_Export] = []
    for statement in statements(source.lines):
        match = _STATEMENT.match(statement.text)
        if _EMPTIED.fullmatch(statement.text):
            exports.append(_Export(statement.line, statement.function))
        elif match:
            if not exports or (match["list"] == "names" and not match["append"]):
                exports.append(_Export(statement.line, statement.function))
            try:
                _take(source, exports[-1], statement, match)
            except BadInputFile as error:
                exports[-1].error = exports[-1].error or error
        elif exports and _CHANGED.match(statement.text):
            shown = abbreviated(statement.text.strip(), 40)
            reason = f"{shown!r} changes a list in a way that is not known; nothing in the file is run"
            indent = len(statement.text) - len(statement.text.lstrip())
            place = Place(statement.line, statement.column + indent)
            exports[-1].error = exports[-1].error or source.error(reason, place)
    return exports


def _motion(source: Source, export: _Export) -> Motion:
    bezier = any(isinstance(rows, list) and not plain_keys(rows) for rows in export.lists["keys"])
    tracks = []
    for row, joint in enumerate(export.lists["names"]):
        at_name, at_times, at_keys = (export.places[name][row] for name in _LISTS)
        source.check_joint(joint, at_name)
        for value, place in ((export.lists["times"][row], at_times), (export.lists["keys"][row], at_keys)):
            if not isinstance(value, list):
                raise source.error(f"expected a list, got {described(value)}", place)
        times = source.floats(export.lists["times"][row], "time", _entry(at_times))
        rows, handles = export.lists["keys"][row], None
        if len(rows) != len(times):
            raise source.error(f"{joint} has {len(times)} times and {len(rows)} keys", at_keys)
        if bezier:
            keys, handles = control_points(source, rows, times, _entry(at_keys))
        else:
            keys = source.floats(rows, "key", _entry(at_keys))
        if source.degrees and not is_hand(joint):
            keys = keys * (math.pi / 180.0)
            if handles is not None:
                handles[..., 1] *= math.pi / 180.0
        tracks.append(Track(joint, times, keys, handles, at_name, _entry(at_times), _entry(at_keys)))
    return motion_of(source, tracks, "bezier" if bezier else "linear")


def _entry(place: Place) -> Callable[[int], Place]:
    return lambda index: Place(place.line, place.column, f"{place.where}[{index}]")


def _take(source: Source, export: _Export, statement: Statement, match: re.Match[str]) -> None:
    """Put what a statement says into the export that it belongs to."""
    name, text = match["list"], statement.text[match.end() :].rstrip()
    offset = match.end()
    before = statement.text[:offset]
    line = statement.line + before.count("\n")
    column = offset - before.rfind("\n") if "\n" in before else statement.column + offset
    place = Place(line, column, name)
    if match["append"]:
        if not text.endswith(")"):
            raise source.error("no ) at the end of the statement", place)
        export.put(name, _literal(source, text[:-1], place), place)
        return
    value = [] if re.fullmatch(r"list\s*\(\s*\)", text) else _literal(source, text, place)
    if not isinstance(value, list):
        raise source.error(f"expected a list, got {described(value)}", place)
    export.lists[name], export.places[name] = [], []
    for index, entry in enumerate(value):
        export.put(name, entry, Place(line, column, f"{name}[{index}]"))


def _literal(source: Source, text: str, place: Place) -> Any:
    """The list, text or number that an expression writes, without running it."""
    if _PLAIN.fullmatch(text):
        try:
            return json.loads(text)
        except (ValueError, RecursionError):
            pass  # numbers such as 1. and .5
    if len(text) > _LONGEST_STATEMENT:
        raise source.error(f"a statement of {len(text)} characters that are not only lists of decimal numbers", place)
    if max(map(len, _CUT.split(text))) > _LONGEST_NUMBER:
        raise source.error(f"a number or name of more than {_LONGEST_NUMBER} characters", place)
    try:
        tree = ast.parse(f"({text}\n)", mode="eval").body
        return _value(source, tree, place)
    except SyntaxError as error:
        raise source.error(f"no Python list: {error.msg}", place) from None
    except (ValueError, RecursionError, MemoryError, OverflowError, ZeroDivisionError) as error:
        raise source.error(f"no list of numbers: {abbreviated(error) or type(error).__name__}", place) from None


def _value(source: Source, node: ast.expr, place: Place) -> Any:
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
    # The expression stands behind a bracket of ours.
    line, column = place.line + node.lineno - 1, node.col_offset + (place.column - 1 if node.lineno == 1 else 0)
    shown = abbreviated(ast.unparse(node), 60)
    raise source.error(
        f"{shown!r} is not a number written out; nothing in the file is run", Place(line, column, place.where)
    )


def _number(source: Source, node: ast.expr, place: Place) -> float:
    value = _value(source, node, place)
    if type(value) not in (int, float):
        raise source.error(f"{described(value)} where a number was expected", place)
    return float(value)


def _write_python(motion: Motion, rate: float | None) -> bytes:
    """An export: plain keys of a linear motion, Bezier control points of another one."""
    motion = sampled(motion, rate)
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


PYTHON = Format("python", (".py",), "Choregraphe's Python export", _recognises_python, _read_python, _write_python)


# --- The arguments of NAOqi's angleInterpolation and angleInterpolationBezier, as JSON.
#
#     [["HeadYaw", "HeadPitch"], [[0.3, 0.0], 0.2], [[1.0, 2.0], 1.0], true]
#     [["HeadYaw"], [[1.0]], [[[0.3, [3, -0.3, 0.0], [3, 0.0, 0.0]]]]]
#
# The first, of four, are names, angles, times and isAbsolute; the second, of three, names, times and control points.
# As in NAOqi, names are one name, a list or a chain such as "Head" or "Body", and angles and times a number or a list
# for each joint. An object of the same things by name ("names", "angles" or "keys", "times", "isAbsolute") is read
# too.

_CHAINS = {**CHAINS, "Body": BODY_ORDER}
_ANGLES = ("angles", "angleLists", "keys", "controlPoints")
_TIMES = ("times", "timeLists")
Path = list[str | int]


def _recognises_naoqi(source: Source) -> bool:
    """Whether it is a JSON list that begins with names, or an object with names and times."""
    value = source.json
    if isinstance(value, dict):
        return "names" in value and any(name in value for name in _TIMES)
    if not isinstance(value, list) or len(value) not in (3, 4):
        return False
    return isinstance(value[0], str) or (isinstance(value[0], list) and all(isinstance(x, str) for x in value[0]))


def _read_naoqi(source: Source) -> Motion:
    """The motion that the call makes.

    Raises:
        BadInputFile: with the path to the value; relative angles, for what they are relative to is
            not in the file.
    """
    paths = _paths(source)
    names, single = _names(source, paths["names"])
    keys, times = (_per_joint(source, paths[what], names, single=single) for what in ("angles", "times"))
    tracks = []
    bezier = any(not plain_keys(rows) for rows, _ in keys)
    for row, joint in enumerate(names):
        (own, key_path), (stamps, time_path) = keys[row], times[row]

        def time_of(key: int, path: Path | None = time_path) -> Place:
            return Place() if path is None else in_json(*([*path, key] if path[-1:] != ["="] else path[:-1]))

        def key_of(key: int, path: Path | None = key_path) -> Place:
            return Place() if path is None else in_json(*([*path, key] if path[-1:] != ["="] else path[:-1]))

        seconds = source.floats(stamps, "time", time_of)
        if len(own) != len(seconds):
            raise source.error(f"{joint} has {len(seconds)} times and {len(own)} keys", in_json(*paths["angles"]))
        values, handles = _curve(source, own, seconds, key_of, bezier=bezier)
        if source.degrees and not is_hand(joint):
            values = values * (math.pi / 180.0)
            if handles is not None:
                handles[..., 1] *= math.pi / 180.0
        tracks.append(Track(joint, seconds, values, handles, in_json(*paths["names"]), time_of, key_of))
    return motion_of(source, tracks, "bezier" if bezier else "linear")


def _curve(source: Source, rows: list[Any], times: Floats, place: Any, *, bezier: bool) -> tuple[Floats, Floats | None]:
    if bezier:
        return control_points(source, rows, times, place)
    return source.floats(rows, "angle", place), None


def _paths(source: Source) -> dict[str, Path]:
    """Where names, angles and times stand."""
    value = source.json
    if isinstance(value, dict):
        known = ("names", *_ANGLES, *_TIMES, "isAbsolute")
        for name in value:
            if name not in known:
                near = ", ".join(nearest_names(name, known)) or ", ".join(known)
                raise source.error(f"unknown argument (nearest: {near})", in_json(name))
        found: dict[str, Path] = {}
        for what, choices in (("names", ("names",)), ("angles", _ANGLES), ("times", _TIMES)):
            given = [name for name in choices if name in value]
            if len(given) != 1:
                raise source.error(f"{len(given)} of {' and '.join(choices)}, expected one")
            found[what] = [given[0]]
        absolute, where = value.get("isAbsolute", True), ["isAbsolute"]
    elif isinstance(value, list) and len(value) == 3:
        return {"names": [0], "times": [1], "angles": [2]}
    elif isinstance(value, list) and len(value) == 4:
        found, absolute, where = {"names": [0], "angles": [1], "times": [2]}, value[3], [3]  # type: ignore[list-item]
    else:
        raise source.error(
            f"expected [names, angles, times, isAbsolute] or [names, times, keys], got {described(value)}"
        )
    if absolute is False or absolute == 0:
        raise source.error("relative angles: what they are relative to is not in the file", in_json(*where))
    if absolute is not True and absolute != 1:
        raise source.error(f"isAbsolute is {described(absolute)}, expected true", in_json(*where))
    return found


def _names(source: Source, path: Path) -> tuple[list[str], bool]:
    """The joints, and whether they are one name."""
    given = source.json[path[0]]
    single = isinstance(given, str)
    names: list[str] = []
    for index, name in enumerate(given if isinstance(given, list) else [given]):
        where = [*path, index] if isinstance(given, list) else path
        if isinstance(name, str) and name in _CHAINS and name not in source.joints:
            named: Sequence[str] = _CHAINS[name]
        else:
            named = [source.check_joint(name, in_json(*where))]
        for joint in named:
            if joint in names:
                raise source.error(f"joint {joint} is given twice", in_json(*where))
            names.append(joint)
    if not names:
        raise source.error("no names", in_json(*path))
    return names, single and len(names) == 1


def _per_joint(source: Source, path: Path, names: list[str], *, single: bool) -> list[tuple[list[Any], Path | None]]:
    """What stands for each joint as a list, and its path; a path that ends in "=" is that of a single value."""
    given = source.json[path[0]]
    if not isinstance(given, list):
        return [([given], [*path, "="])] * len(names)
    nested = any(isinstance(entry, list) for entry in given)
    if single and (not nested or _is_points(given)):
        return [(given, path)]
    if len(names) == 1 and not nested:
        return [(given, path)]
    if len(given) == 1 and not nested:
        return [(given, path)] * len(names)
    if len(given) != len(names):
        raise source.error(f"{len(given)} entries for {len(names)} joints", in_json(*path))
    return [
        (entry, [*path, row]) if isinstance(entry, list) else ([entry], [*path, row, "="])
        for row, entry in enumerate(given)
    ]


def _is_points(rows: list[Any]) -> bool:
    """Whether a list is the control points of one joint, and not a list of such lists."""
    return isinstance(rows[0], list) and bool(rows[0]) and not isinstance(rows[0][0], list) and len(rows[0]) == 3


def _write_naoqi(motion: Motion, rate: float | None) -> bytes:
    """The arguments of angleInterpolation for a linear motion, else those of angleInterpolationBezier."""
    motion = sampled(motion, rate)
    names = json.dumps(list(motion.joint_names), ensure_ascii=False)
    stamps, keys = ([row.tolist() for row in motion.times], points(motion))
    rows = [_rows(stamps), _rows(keys)] if motion.interpolation != "linear" else [_rows(keys), _rows(stamps), "true"]
    return ("[" + ",\n ".join([names, *rows]) + "]\n").encode()


def _rows(rows: list[list[Any]]) -> str:
    return "[\n" + ",\n".join(f"  {json.dumps(row)}" for row in rows) + "]"


NAOQI = Format("naoqi", (".json",), "arguments of angleInterpolation", _recognises_naoqi, _read_naoqi, _write_naoqi)
