"""ROS messages of joint states as tools print them to files: JSON lines, CSV without headings, and YAML.

{"header": {"stamp": {"sec": 7, "nanosec": 500000000}}, "name": ["HeadYaw"], "position": [0.1]}

7,500000000,,HeadYaw,0.1,0.0,0.0

header:
  stamp:
    sec: 7
    nanosec: 500000000
name:
- HeadYaw
position: [0.1]
---
"""

from __future__ import annotations

import math
import re
from typing import Any

from nao_kin._core.files import read_json
from nao_kin._core.headings import is_decimal
from nao_kin._core.text import MAX_SHOWN, quoted
from nao_kin.errors import BadInputFile

_NOT_A_NUMBER = ("nan", ".nan")
# Fields of `ros2 topic echo --csv` before the names: seconds, nanoseconds, and the frame.
_BEFORE = 3
_ROW = re.compile(r"\d{1,19},\d{1,9},[^,]*,[A-Za-z_]", re.ASCII)
_FIRST_KEYS = ("header:", "---\n", "name:")
_STAMP = re.compile(r"\b(n?secs?|nanosec): *(\d{1,19})", re.ASCII)


def printed_messages(name: str, text: str) -> list[Any] | None:
    """Return the JSON objects of JSON lines, or the joint states that `topic echo` printed; None for other texts."""
    begin = text.lstrip()
    if begin.startswith("{") or _ROW.match(begin):
        lines = {at: line for at, line in enumerate(map(str.strip, text.splitlines()), start=1) if line}
        if not begin.startswith("{"):
            return [_of_csv(name, line, at) for at, line in lines.items()]
        several = len(lines) > 1 and all(line.startswith("{") and line.endswith("}") for line in lines.values())
        return [_of_json(name, line, at) for at, line in lines.items()] if several else None
    if begin.startswith(_FIRST_KEYS):
        return [_of_yaml(part) for part in re.split(r"^---$", text, flags=re.MULTILINE) if part.strip()]
    return None


def _of_json(name: str, line: str, at: int) -> Any:
    """Return the JSON value in a line."""
    try:
        return read_json(name, line)
    except BadInputFile as error:
        raise BadInputFile(name, error.reason, at, error.column) from None


def _of_csv(name: str, line: str, at: int) -> dict[str, Any]:
    """Return the joint state in a row: names, as many positions, and perhaps velocities and efforts."""
    if not _ROW.match(line):
        expected = "seconds, nanoseconds, a frame, names and positions, as in the first row"
        raise BadInputFile(name, f"expected {expected}, got {quoted(line, MAX_SHOWN)}", at)
    fields = line.split(",")
    values = fields[_BEFORE:]
    count = next((k for k, field in enumerate(values) if is_decimal(field) or field in _NOT_A_NUMBER), len(values))
    stamp = {"sec": int(fields[0]), "nanosec": int(fields[1])}
    return _joint_state(stamp, values[:count], values[count : 2 * count])


def _of_yaml(text: str) -> dict[str, Any]:
    """Return the joint state in a document of `ros2 topic echo` or `rostopic echo`."""
    lists: dict[str, list[str]] = {}
    current: list[str] = []
    for line in text.splitlines():
        key, sign, rest = line.partition(":")
        if sign and not line.startswith((" ", "-")):
            current = lists.setdefault(key, [])
            current += [entry.strip(" '\"") for entry in rest.strip(" []").split(",") if entry.strip()]
        elif line.lstrip().startswith("- "):
            current.append(line.strip()[2:].strip("'\""))
    stamp = {key: int(value) for key, value in _STAMP.findall(text)}
    return _joint_state(stamp, lists.get("name", []), lists.get("position", []))


def _joint_state(stamp: dict[str, int], names: list[str], positions: list[str]) -> dict[str, Any]:
    """Return the joint state as JSON has it; a position that is no number remains a text, which its reader refuses."""
    values = [math.nan if one in _NOT_A_NUMBER else float(one) if is_decimal(one) else one for one in positions]
    return {"header": {"stamp": stamp}, "name": names, "position": values}
