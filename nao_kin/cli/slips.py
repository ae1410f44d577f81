"""The commonest slips on a command line: numbers without quotes, and names where a file is expected.

What can mean one thing only is taken as that; the rest is refused with the way to write it.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Mapping
from typing import Any

import nao_kin as nk
from nao_kin._core.arrays import finite_decimal
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument

# Words that are no commands → what does that.
ELSEWHERE = {
    "com": "nao-kin balance",
    "compare": "nao-kin check",
    "convert": "nao-kin motion convert",
    "dh": "nao-kin joints --dh FRAME",
    "diff": "nao-kin info --compare V",
    "frames": "nao-kin fk",
    "gui": "nao-kin view",
    "jacobian": "robot.jacobian in Python",
    "limits": "nao-kin joints",
    "mirror": "nao-kin motion convert --mirror",
    "notebook": "nk.Viewer in Python",
    "plot": "nao-kin motion plot",
    "ros": "nao-kin export --format ros2",
    "rotate": "nk.rotations in Python",
    "show": "nao-kin view",
    "simulate": "nao-kin serve",
    "versions": "nao-kin info --nao",
    "workspace": "nao-kin reach",
}


def mended(words: list[str], options: Mapping[str, Any]) -> list[str]:
    """Return the words after a command with numbers after an option as one value, and names after their option.

    `options` are those of the command by name, each an `Option` of the module `parsing`, which calls this one.
    """
    flags = {flag: option for option in options.values() for name in option.flags for flag in name.split("/")}
    left, out = deque(words), list[str]()
    while left:
        word = left.popleft()
        option = flags.get(word)
        if word == "--":
            return [*out, word, *left]
        if option is None:
            out += [word] if word.startswith("-") else _after_its_option(word, options, words)
            continue
        out.append(word)
        if option.kind is not bool and left:
            out.append(_value(option, left))
    return out


def _value(option: Any, left: deque[str]) -> str:
    """Take the value of an option from the words that are left: `0.15 0.12 0.05`, `HeadYaw 0.3`, `LArm RArm`."""
    value, form = left.popleft(), option.field.metadata["metavar"] or ""
    if form == "NAME=VALUE" and "=" not in value and left and _is_number(left[0]):
        return f"{value}={left.popleft()}"
    if form in ("NUMBERS", "U,V") or form.startswith("X,Y,Z"):
        while left and _is_number(left[0]):
            value += f" {left.popleft()}"
    elif form == "FRAME" and option.several:
        while left and _is_frame(left[0]):
            value += f",{left.popleft()}"
    return value


def _after_its_option(word: str, options: Mapping[str, Any], words: list[str]) -> list[str]:
    """Return a word that stands alone, behind the option it means if it is no file."""
    meant = next((flag for option in options.values() for flag in option.flags if flag == f"--{word}"), None)
    if "file" in options and meant is not None and not os.path.isfile(word):
        raise BadArgument(f"{quoted(word)} is no file; the option is {meant}")
    if ("file" not in options and any(not option.flags for option in options.values())) or os.path.exists(word):
        return [word]
    if word.lower() in nk.robot.nao.VERSIONS and "nao" in options and "--nao" not in words:
        return ["--nao", word.lower()]
    if "file" in options and _is_number(word):
        way = "--joint NAME=VALUE sets a joint" if "joint" in options else "numbers stand after their option"
        raise BadArgument(f"{quoted(word)} is a number, expected a file; {way}")
    known = options.get("frame")
    return ["--frame", word] if known is not None and known.flags and _is_frame(word) else [word]


def _is_number(word: str) -> bool:
    return finite_decimal(word) is not None


def _is_frame(word: str) -> bool:
    """Return whether a word is a frame of a NAO, and neither an option nor a file."""
    return not word.startswith("-") and not os.path.exists(word) and word in nk.load_nao().frame_names
