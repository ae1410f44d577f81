"""NaoDevils' key frames (.kfm).

    keyFrameID = nod;
    keyFrames = [
      {
        headAngles = [0, 20deg];
        armsAngles = [90deg, 11deg, 0, 90deg, -90deg, 0, 90deg, -11deg, 0, -90deg, 90deg, 0];
        legsAngles = [0, 0, -21deg, 49deg, -27.5deg, 0, 0, 0, -21deg, 49deg, -27.5deg, 0];
        duration = 400;
        intType = sine;
        …
      }
    ];

Source: NaoDevils/CodeRelease, KeyFrameEngine: arms and legs are the left one and then the right one, durations
milliseconds, numbers without a unit radians, 10000 and 20000 no angles; a step is linear or sine (½ − ½ cos π s).
Stiffnesses, and what the robot does by its sensors, are left out.

Their .kmc files, as B-Human's, are none of joints: they move feet, elbows and the centre of mass through space, and
what the joints do comes of the running robot's balance.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from nao_kin.motion.files.config_stream import ConfigStream, Items
from nao_kin.motion.files.key_frames import Ease, ease_of, key_frame, motion_of_frames
from nao_kin.motion.files.source import Format, Source
from nao_kin.motion.motion import Motion

_BEGINS = re.compile(r"^\s*(?:keyFrames|phaseParameters)\s*=\s*\[", re.MULTILINE)
_LISTS = {"headAngles": 2, "armsAngles": 12, "legsAngles": 12}
# NAOqi's order has the right arm behind the legs.
_ORDER = np.array([*range(8), *range(14, 26), *range(8, 14)])
_EASES: dict[str, Ease | None] = {"linear": "linear", "sine": "cosine"}


def recognises(source: Source) -> bool:
    """Whether some line begins with keyFrames = [ or, in a kick, phaseParameters = [."""
    return _BEGINS.search(source.text) is not None


def read(source: Source) -> Motion:
    """The motion in a .kfm file.

    Raises:
        BadInputFile: with line and column; a .kmc file, which holds no joint values.
    """
    stream = ConfigStream(source)
    if "phaseParameters" in stream.fields:
        raise source.error(
            "a kick of feet, arms and centre of mass (.kmc): its joint values come of the running robot's balance and "
            "are not in the file; expected key frames (.kfm)"
        )
    frames = []
    for row in stream.objects(stream.get(stream.fields, "keyFrames", Items), " for a key frame"):
        lists = [(row, name, count) for name, count in _LISTS.items()]
        frame = key_frame(stream, row, ease_of(stream, "intType", _EASES, row), lists)
        frames.append(replace(frame, values=frame.values[_ORDER]))
    if not frames:
        raise source.error("no key frames")
    return motion_of_frames(source, frames)


NAODEVILS = Format("naodevils", (".kfm", ".kmc"), "NaoDevils' key frames", recognises, read)
