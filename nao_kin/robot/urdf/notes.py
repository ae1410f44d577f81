"""Notes on what a URDF says and this library does not use, and on numbers that no robot has."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._core.text import abbreviated, quoted
from nao_kin.robot.urdf.tree import Inertial, UrdfJoint, has_quaternions

# Names of elements that close loops: <loop_joint> of Isaac Sim, <drake:ball_constraint>, <drake:linear_bushing_rpy> …
_CLOSING = re.compile("loop|constraint|bushing", re.IGNORECASE)
# Larger limits of a turning joint, up to two turns in degrees, seem to be in degrees; still larger ones mean none.
_MOST_TURNED, _TWO_TURNS = 4.0 * math.pi, 720.0
# A lighter body is a placeholder, whose tensor means nothing [kg].
_PLACEHOLDER = 1e-5
# Rounding of published tensors, as a share of the largest principal moment.
_ROUNDING = 1e-3


def notes_on_elements(document: ET.Element) -> Iterator[str]:
    """Yield notes on quaternions in a version of URDF that has none, and on elements that close loops."""
    ignored = [
        origin
        for owner in document
        if owner.tag in ("link", "joint")
        for origin in owner.iter("origin")
        if origin.get("quat_xyzw") is not None
    ]
    if ignored and not has_quaternions(document):
        yield f'quat_xyzw of {len(ignored)} origins is ignored: it needs <robot version="1.1">, as in other readers'
    closing = [f"<{element.tag}>" for element in document if _CLOSING.search(element.tag)]
    closing += ["<gazebo><joint>" for element in document.findall("gazebo") for _ in element.findall("joint")]
    if closing:
        kinds = abbreviated(", ".join(dict.fromkeys(closing)))
        yield f"{len(closing)} elements that close loops are left out, and the loops stay open: {kinds}"


def notes_on_numbers(
    joints: Sequence[UrdfJoint], inertials: Mapping[str, Inertial], speedless: Sequence[str]
) -> Iterator[str]:
    """Yield notes on limits and inertias that no robot has; only a velocity limit of 0 is not kept as it is."""
    moving = [joint for joint in joints if joint.kind != "fixed"]
    found: dict[str, Sequence[str]] = {
        "velocity 0: taken as unlimited": speedless,
        "an effort limit of 0": [joint.name for joint in moving if joint.effort == 0.0],
        "lower and upper limits of 0, and cannot move": [
            joint.name for joint in moving if joint.lower == joint.upper == 0.0
        ],
        "limits that seem to be in degrees": [
            joint.name
            for joint in moving
            if joint.kind == "revolute" and _MOST_TURNED < max(-joint.lower, joint.upper) <= _TWO_TURNS
        ],
    }
    for what, names in found.items():
        if names:
            yield f"{_several('joint', names)} {what}"
    impossible = [link for link, body in inertials.items() if body.mass > _PLACEHOLDER and not _is_possible(body)]
    if impossible:
        yield f"{_several('link', impossible)} an inertia tensor that no body has"


def notes_on_shapes(shapes: Mapping[str, Sequence[Any]]) -> Iterator[str]:
    """Yield notes on shapes that cannot be read, from the fields of `UrdfTree`."""
    for kind in ("visual", "collision"):
        notes = shapes[f"{kind}_notes"]
        if notes:
            yield f"{notes[0]}{f' (and {len(notes) - 1} more)' if len(notes) > 1 else ''}"


def _several(kind: str, names: Sequence[str]) -> str:
    """Return the names as the subject of a sentence, with its verb: "joint 'a' has", "3 joints ('a', …) have"."""
    if len(names) == 1:
        return f"{kind} {quoted(names[0])} has"
    return f"{len(names)} {kind}s ({abbreviated(', '.join(map(quoted, names)), 100)}) have"


def _is_possible(body: Inertial) -> bool:
    """Return whether some body has this tensor: its principal moments A ≤ B ≤ C have A + B ≥ C, and so A ≥ 0."""
    xx, xy, xz, yy, yz, zz = body.inertia
    a, b, c = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return bool(a + b - c >= -_ROUNDING * max(-a, c))
