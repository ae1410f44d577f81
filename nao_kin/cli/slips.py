"""The commonest slips on a command line: numbers without quotes, and names where a file is expected.

What can mean one thing only is taken as that; the rest is refused with the way to write it.
"""

from __future__ import annotations

import os
import re
from collections import deque
from collections.abc import Mapping
from typing import Any

import nao_kin as nk
from nao_kin._core.arrays import finite_decimal
from nao_kin._core.text import nearest_names, quoted
from nao_kin.errors import BadArgument

# What does a job → words for it that are no commands.
_SYNONYMS = {
    "nao-kin --help": "help list docs",
    "nao-kin --version": "version",
    "nao-kin balance": "com stability",
    "nao-kin check": "compare test",
    "nao-kin export --format ros2": "ros",
    "nao-kin fk": "forward frames pose",
    "nao-kin ik": "inverse inverse-kinematics solve",
    "nao-kin imitate": "retarget",
    "nao-kin info": "mass postures robots versions",
    "nao-kin info --compare V": "diff",
    "nao-kin joints": "limits",
    "nao-kin joints --dh FRAME": "dh",
    "nao-kin motion convert": "convert",
    "nao-kin motion convert --mirror": "mirror",
    "nao-kin motion plot": "plot",
    "nao-kin reach": "workspace",
    "nao-kin serve": "simulate",
    "nao-kin state FILE -o -": "log odom odometry",
    "nao-kin view": "gui play show visualize",
    "nk.Viewer in Python": "notebook",
    "nk.rotations in Python": "rotate",
    "robot.jacobian in Python": "jacobian",
}
ELSEWHERE = {word: job for job, words in _SYNONYMS.items() for word in words.split()}


def mended(words: list[str], options: Mapping[str, Any]) -> list[str]:
    """Return the words after a command with numbers after an option as one value, and names after their option.

    `options` are those of the command by name, each an `Option` of the module `parsing`, which calls this one.
    """
    flags = {flag: option for option in options.values() for name in option.flags for flag in name.split("/")}
    arguments = [f"--{option.label.lower()}" for option in options.values() if not option.flags]
    left, out = deque(word if os.path.exists(word) else word.strip("“”„") for word in words), list[str]()
    while left:
        word = _as_typed(left.popleft(), flags)
        name, joined, value = word.partition("=")
        option = flags.get(name)
        if word in arguments:  # as in `ik --frame LArm`: the argument alone remains
            continue
        if option is None and word.startswith("--") and not (word[2:] and left and f"--{left[0]}" in flags):
            return [*out, word, *left]  # refused as unknown, whatever follows; but in --format json, --json is meant
        if option is None:
            is_option = word.startswith("-") and not _is_number(word)
            out += [word] if is_option else _after_its_option(word, options, [*out, *words], left)
            continue
        if joined and _takes_numbers(option):  # as in --target=0.15 0.12 0.05
            left.appendleft(value.strip("“”„"))
            word = name
        out.append(word)
        if option.kind is not bool and left and "=" not in word:
            out += _values(option, left)
    return out


def _takes_numbers(option: Any) -> bool:
    form = option.field.metadata["metavar"] or ""
    return form in ("NUMBERS", "U,V") or form.startswith("X,Y,Z")


def _as_typed(word: str, flags: Mapping[str, Any]) -> str:
    """Return an option with the two hyphens that it has: an editor writes —frame, a habit -deg."""
    name = word.lstrip("-–—")
    return f"--{name}" if name != word and f"--{name.partition('=')[0]}" in flags else word


def _values(option: Any, left: deque[str]) -> list[str]:
    """Take the value of an option from the words that are left: `0.15 0.12 0.05`, `HeadYaw 0.3`, `LArm RArm`."""
    value, form = left.popleft(), option.field.metadata["metavar"] or ""
    if form == "NAME=VALUE":
        if "=" not in value and left and _is_number(left[0]):
            return [f"{value}={left.popleft()}"]
        parts = value.replace(",", " ").split()
        if all(re.fullmatch("[^=]+=[^=]+", part) for part in parts):
            return [word for part in parts for word in (option.label, part)][1:]
    elif _takes_numbers(option):
        while left and _is_number(left[0]):
            value += f" {left.popleft()}"
    elif form == "FRAME" and option.several:
        while left and _is_frame(left[0]):
            value += f",{left.popleft()}"
    return [value]


def _after_its_option(word: str, options: Mapping[str, Any], given: list[str], left: deque[str]) -> list[str]:
    """Return a word that stands alone, behind the option it means if it is no file."""
    if "file" not in options and any(not option.flags for option in options.values()):
        return [word]
    name = word.rstrip("/")
    meant = next((flag for option in options.values() for flag in option.flags if flag == f"--{name}"), None)
    if "file" in options and meant is not None and not os.path.isfile(word):
        raise BadArgument(f"{quoted(name)} is no file; the option is {meant}")
    if os.path.isfile(word) and "urdf" in options and word.lower().endswith((".urdf", ".xacro")):
        return ["--urdf", word]
    if "file" in options and os.path.exists(word) and not os.path.isdir(word):
        return [word]
    free = [flag for flag in ("--nao", "--compare") if flag[2:] in options and flag not in given]
    if word.lower() in nk.robot.nao.VERSIONS and free:
        return [free[0], word.lower()]
    if "joint" in options and re.fullmatch("[^=]+=[^=]+", word):
        return ["--joint", word]
    if "file" in options and _is_number(word):
        if "target" in options and "--target" not in given:
            left.appendleft(word)
            return ["--target", *_values(options["target"], left)]
        way = "--joint NAME=VALUE sets a joint" if "joint" in options else "numbers stand after their option"
        raise BadArgument(f"{quoted(word)} is a number, expected a file; {way}")
    known = {"posture": nk.load_nao().posture_names, "frame": nk.load_nao().frame_names}
    places = {name: kind for kind, names in known.items() if kind in options and options[kind].flags for name in names}
    near = nearest_names(word, places, 1, similar=0.7) if "." not in word else ()
    return [f"--{places[near[0]]}", word] if near else [word]


def _is_number(word: str) -> bool:
    return finite_decimal(word) is not None


def _is_frame(word: str) -> bool:
    """Return whether a word is a frame of a NAO, and neither an option nor a file."""
    return not word.startswith("-") and not os.path.exists(word) and word in nk.load_nao().frame_names
