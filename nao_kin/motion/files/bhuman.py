"""B-Human's key frames, whose blocks make up motions; and those of NaoDevils.

    motions = {
      sit = {keyframes = [sit, sitDown]; …};
    };
    keyframeBlock = {
      sit = {
        keyframes = [
          {
            duration = 500;
            interpolationType = Default;
            angles = {
              head = [0deg, 0deg];
              positions = {leftArm = […]; rightArm = […]; leftLeg = […]; rightLeg = […];};
            };
            …
          }
        ];
        interpolationType = SinusZeroToMax;
      };
    };

Source: bhuman/BHumanCodeRelease, keyframeMotionEngine.cfg and KeyframePhaseBase. Durations are in milliseconds, numbers
without a unit in radians; 10000 and 20000 are not angles; hands are in radians from 0 closed to 1 open. Interpolations
to a key frame are Linear, SinusMinToMax (½ − ½ cos π s) and SinusZeroToMax (sin ½ π s); Default is the interpolation of
the block. Up to 2021, and in getUpEngine.cfg, the file has mofs = {front = {lines = […]}} instead, in degrees, and a
line contains head, leftArm and so on directly.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np

from nao_kin._core.arrays import finite_decimal
from nao_kin._core.text import MAX_SHOWN, nearest_names, quoted
from nao_kin.motion.files.key_frames import (
    ConfigStream,
    Ease,
    Fields,
    Items,
    KeyFrame,
    Word,
    ease_of,
    key_frame,
    motion_of_frames,
    warn_of_sensors,
)
from nao_kin.motion.files.source import FilePosition, Format, MotionSource, chosen, has_line
from nao_kin.motion.motion import Motion

_BEGINS = re.compile(r"^\s*(?:keyframeBlock|mofs)\s*=\s*[\[{]", re.MULTILINE)
_BLOCKS, _OLD = "keyframeBlock", "mofs"
_LIMBS = ("leftArm", "leftLeg", "rightLeg", "rightArm")
# The default of a key frame is that of its block, the default of a block is linear.
_EASES: dict[str, Ease | None] = {
    "Default": None,
    "Linear": "linear",
    "SinusMinToMax": "cosine",
    "SinusZeroToMax": "sine",
}
# Actions that depend on the robot's sensors.
_BY_SENSORS = ("keyframeBranches", "waitConditions", "jointCompensation", "startAsNextPhaseMotion")


# B-Human's key frames of Booster's robots have the same form; the folder of such a file has the robot's name.
_BOOSTER = ("K1", "T1")
# Their left arm hangs down at a roll of −80°; that of a NAO does not pass −21° in any of B-Human's releases.
_LEFT_ROLL = re.compile(r"\bleftArm\s*=\s*\[[^],]*,\s*(-[\d.]+)deg")
_NO_NAO_ROLLS = -45.0


def _refuse_other_robots(source: MotionSource) -> None:
    """Refuse the key frames of a robot that is no NAO."""
    folder = Path(source.name).parent.name
    if folder in _BOOSTER:
        raise source.error(f"in the folder {folder}: key frames of Booster's {folder}, expected those of a NAO")
    for match in _LEFT_ROLL.finditer(source.text):
        roll = finite_decimal(match[1])
        if roll is not None and roll < _NO_NAO_ROLLS:
            line = source.text.count("\n", 0, match.start()) + 1
            raise source.error(
                f"the left shoulder rolls to {roll:g}°, which no NAO's does; key frames of another robot, such as "
                f"Booster's {' or '.join(_BOOSTER)}",
                FilePosition(line),
            )


def _read_bhuman(source: MotionSource) -> Motion:
    """Read the motion that `timeline` chooses: one of the motions, or a block as keyframeBlock/name."""
    _refuse_other_robots(source)
    stream = ConfigStream(source)
    old = _OLD in stream.fields
    blocks = _blocks(stream, _OLD if old else _BLOCKS)
    motions = Fields() if old else stream.fields.get("motions", Fields())
    rows = "lines" if old else "keyframes"
    choices: dict[str, list[str]] = {}
    for name in motions:
        words = stream.get(stream.get(motions, name, Fields), rows, Items)
        choices[name] = [_block_name(stream, blocks, word) for word in words]
    choices |= {name if old else f"{_BLOCKS}/{name}": [name] for name in blocks}
    full = {
        name: own
        for name, own in choices.items()
        if any(stream.get(stream.get(blocks, block, Fields), rows, Items) for block in own)
    }
    if not full:
        raise source.error("no key frames")
    name = list(full)[chosen(source, list(full), "motions")]
    frames, left_out = list[KeyFrame](), set[str]()
    for block in full[name]:
        frames += _frames(stream, blocks[block], rows, left_out, old=old)
    left_out |= _given(motions.get(name, Fields()), ("startAsNextPhaseMotion",))
    warn_of_sensors(source, left_out)
    if not frames:
        raise source.error(f"all key frames of {quoted(name, MAX_SHOWN)} wait for the robot's sensors")
    return motion_of_frames(source, frames)


def _blocks(stream: ConfigStream, name: str) -> Fields:
    """Return the blocks by name; before 2015 they were a list, each with its name in it."""
    given = stream.fields.get(name)
    if not isinstance(given, Items):
        return cast(Fields, stream.get(stream.fields, name, Fields))
    blocks = Fields()
    blocks.at = given.at
    for entry in stream.objects(given, ""):
        blocks[stream.get(entry, "name", Word).text] = entry
    return blocks


def _block_name(stream: ConfigStream, blocks: Fields, word: object) -> str:
    name = word.text if isinstance(word, Word) else ""
    if name not in blocks:
        near = ", ".join(nearest_names(name, blocks))
        at = word if isinstance(word, (Word, Fields, Items)) else blocks
        raise stream.error(f"no block {quoted(name, MAX_SHOWN)} of key frames (nearest: {near})", at)
    return name


def _given(fields: Fields, names: Iterable[str]) -> set[str]:
    """Return the names of the lists that are not empty."""
    return {name for name in names if fields.get(name)}


def _frames(stream: ConfigStream, block: Fields, rows: str, left_out: set[str], *, old: bool) -> list[KeyFrame]:
    """Return the key frames of a block, and add the names of ignored parts to `left_out`."""
    frames = []
    for row in stream.objects(stream.get(block, rows, Items), " for a key frame"):
        left_out |= _given(row, _BY_SENSORS)
        if row.get("conditions"):
            left_out |= {"lines with conditions"}
            continue
        angles = row if old else stream.get(row, "angles", Fields)
        limbs = angles if old else stream.get(angles, "positions", Fields)
        lists = [(angles, "head", 2), *((limbs, limb, 6) for limb in _LIMBS)]
        ease = ease_of(stream, "interpolationType", _EASES, row, block)
        frames.append(key_frame(stream, row, ease, lists, "deg" if old else "rad"))
    return frames


BHUMAN = Format("bhuman", (".cfg",), "B-Human's key frames", has_line(_BEGINS), _read_bhuman)


# --- NaoDevils' key frames (.kfm).
#
#     keyFrameID = nod;
#     keyFrames = [
#       {
#         headAngles = [0, 20deg];
#         armsAngles = [90deg, 11deg, 0, 90deg, -90deg, 0, 90deg, -11deg, 0, -90deg, 90deg, 0];
#         legsAngles = [0, 0, -21deg, 49deg, -27.5deg, 0, 0, 0, -21deg, 49deg, -27.5deg, 0];
#         duration = 400;
#         intType = sine;
#         …
#       }
#     ];
#
# Source: NaoDevils/CodeRelease, KeyFrameEngine: the left arm or leg comes before the right one; durations are in
# milliseconds, numbers without a unit in radians; 10000 and 20000 are not angles; a step is linear or sine
# (½ − ½ cos π s). Of two fields of one name the last counts (Tools/Streams/SimpleMap.cpp). Stiffnesses, and actions
# that depend on the robot's sensors, are left out.
#
# NaoDevils' .kmc files, like those of B-Human, hold no joint values: they move feet, elbows and the centre of mass
# through space, and the running robot's balance determines the joints.

_KFM_BEGINS = re.compile(r"^\s*(?:keyFrames|phaseParameters)\s*=\s*\[", re.MULTILINE)
_KFM_LISTS = {"headAngles": 2, "armsAngles": 12, "legsAngles": 12}
# NAOqi's order has the right arm after the legs.
_KFM_ORDER = np.array([*range(8), *range(14, 26), *range(8, 14)])
_KFM_EASES: dict[str, Ease | None] = {"linear": "linear", "sine": "cosine"}


def _read_kfm(source: MotionSource) -> Motion:
    """Read the motion in a .kfm file; a .kmc file, which contains no joint values, is refused."""
    stream = ConfigStream(source, last_counts=True)
    if "phaseParameters" in stream.fields:
        raise source.error(
            "a kick of feet, arms and centre of mass (.kmc): its joint values depend on the running robot's balance "
            "and are not in the file; expected key frames (.kfm)"
        )
    frames = []
    for row in stream.objects(stream.get(stream.fields, "keyFrames", Items), " for a key frame"):
        lists = [(row, name, count) for name, count in _KFM_LISTS.items()]
        frame = key_frame(stream, row, ease_of(stream, "intType", _KFM_EASES, row), lists)
        frames.append(replace(frame, values=frame.values[_KFM_ORDER]))
    if not frames:
        raise source.error("no key frames")
    return motion_of_frames(source, frames)


NAODEVILS = Format("naodevils", (".kfm", ".kmc"), "NaoDevils' key frames", has_line(_KFM_BEGINS), _read_kfm)
