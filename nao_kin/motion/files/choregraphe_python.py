"""Choregraphe's Python export: lists of names, times and keys, with or without Bezier control points.

    names = list()
    times = list()
    keys = list()

    names.append("HeadYaw")
    times.append([0.5, 1.0])
    keys.append([[0.3, [3, -0.166667, 0], [3, 0.166667, 0]], [0, [3, -0.166667, 0], [3, 0, 0]]])

Only statements that begin with names, times or keys (also self.names …) are looked at: an empty list, .append(…) or a
list written out. Their numbers may be products, quotients and sums, math.radians(…), almath.TO_RAD and math.pi. Nothing
in the file is ever run. A file may hold several motions: each `names = …` begins one, known by its function.
"""

from __future__ import annotations

import ast
import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from nao_kin._text import abbreviated
from nao_kin.errors import BadInputFile
from nao_kin.motion.files.choice import chosen
from nao_kin.motion.files.control_points import control_points, plain_keys, points
from nao_kin.motion.files.format import Format
from nao_kin.motion.files.python_statements import Statement, statements
from nao_kin.motion.files.source import Place, Source, described
from nao_kin.motion.files.tables import is_hand, sampled
from nao_kin.motion.files.tracks import Track, motion_of
from nao_kin.motion.motion import Motion

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


def recognises(source: Source) -> bool:
    """Whether some line begins with names = or names.append(."""
    return _MENTION.search(source.text) is not None


def read(source: Source) -> Motion:
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


def write(motion: Motion, rate: float | None) -> bytes:
    """An export: plain keys of a linear motion, Bezier control points of another one."""
    if rate is not None:
        stamps, values = sampled(motion, rate, "Python")
        motion = Motion(stamps, motion.joint_names, values)
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


PYTHON = Format("python", (".py",), "Choregraphe's Python export", recognises, read, write)
