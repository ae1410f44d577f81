"""The lights among a robot's shapes: the LEDs of this library's own NAO meshes.

A mesh of LEDs is drawn piece by piece, so that each light shines in a colour of its own. Other shapes are no lights,
whatever their looks: a robot without such meshes has none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import PurePosixPath

import numpy as np

from nao_kin.viewer.meshes import Mesh, pieces

# The light that a mesh is, by the stem of its file.
_WHOLE: Mapping[str, str] = {"torso_led": "Chest", "l_foot_led": "LeftFoot", "r_foot_led": "RightFoot"}
_EYES = "head_led"
# Which side of the head, y > 0 or < 0, each eye is on.
_SIDES: Mapping[str, float] = {"LeftEye": 1.0, "RightEye": -1.0}
_SEGMENTS = 8

# Name of several lights → their names.
GROUPS: Mapping[str, tuple[str, ...]] = {eye: tuple(f"{eye}{number}" for number in range(_SEGMENTS)) for eye in _SIDES}


def lights_of(filename: str, mesh: Mesh) -> dict[str, Mesh]:
    """The lights that a mesh is made of, by name; empty for a mesh that is none.

    Segments of an eye are numbered from its top towards the nose, as NAOqi's FaceLedLeft0 … 7 and FaceLedRight0 … 7
    are. Source: docs.ros.org, nao_command_msgs, LeftEyeLeds and RightEyeLeds.

    Args:
        filename: of the mesh, as the URDF has it.
        mesh: its triangles, x to the front and z upwards.
    """
    stem = PurePosixPath(filename).stem
    if stem in _WHOLE:
        return {_WHOLE[stem]: mesh}
    return _eyes(mesh) if stem == _EYES else {}


def _eyes(mesh: Mesh) -> dict[str, Mesh]:
    parts = pieces(mesh)
    centres = [part.vertices.mean(axis=0) for part in parts]
    found: dict[str, Mesh] = {}
    for eye, side in _SIDES.items():
        ring = [(part, centre) for part, centre in zip(parts, centres, strict=True) if side * centre[1] > 0.0]
        middle = np.mean([centre for _, centre in ring], axis=0) if ring else np.zeros(3)
        for part, centre in ring:
            turn = math.atan2(-side * (centre[1] - middle[1]), centre[2] - middle[2])  # from the top to the nose
            found[f"{eye}{round(turn / math.tau * _SEGMENTS) % _SEGMENTS}"] = part
    complete = len(found) == len(parts) == len(_SIDES) * _SEGMENTS
    return {name: found[name] for eye in GROUPS.values() for name in eye} if complete else {}
