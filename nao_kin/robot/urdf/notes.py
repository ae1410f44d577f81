"""Notes on a URDF: on words that no reader uses, on what this library does not use, and on improbable numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._core.text import abbreviated, nearest_names, quoted
from nao_kin.robot.urdf.document import finite_numbers
from nao_kin.robot.urdf.tree import Inertial, UrdfJoint, has_quaternions

# Element → its attributes and, after the bar, its elements: URDF 1.0, 1.1 and the limits on acceleration of urdfdom.
# Those that end in * may be repeated.
_WORDS = {
    "joint": "name type dont_collapse | origin parent child axis calibration dynamics limit mimic safety_controller",
    "link": "name type | inertial visual* collision*",
    "inertial": "| origin mass inertia",
    "visual": "name | origin geometry material",
    "collision": "name | origin geometry verbose* material",
    "verbose": "value |",
    "geometry": "name | box cylinder sphere capsule mesh",
    "material": "name | color texture",
    "origin": "xyz rpy quat_xyzw |",
    "parent": "link |",
    "child": "link |",
    "axis": "xyz |",
    "calibration": "rising falling reference_position |",
    "dynamics": "damping friction |",
    "limit": "lower upper effort velocity acceleration deceleration jerk |",
    "mimic": "joint multiplier offset |",
    "safety_controller": "soft_lower_limit soft_upper_limit k_position k_velocity |",
    "mass": "value |",
    "inertia": "ixx ixy ixz iyy iyz izz |",
    "box": "size |",
    "cylinder": "radius length |",
    "sphere": "radius |",
    "capsule": "radius length |",
    "mesh": "filename scale |",
    "color": "rgba |",
    "texture": "filename |",
}
# Elements of Gazebo, Bullet, ROS and other simulators inside links and joints; they say nothing on kinematics.
_EXTENSIONS = frozenset(
    "actuator audio_source collision_checking contact contact_coefficients dampingFactor force_torque gazebo gravity "
    "hardwareInterface kd kinematic kp maxVel mechanicalReduction minDepth mu1 mu2 mujoco plugin selfCollide "
    "self_collide self_collision_checking self_filter sensor surface transmission turnGravityOff verbose".split()
)
# Words of SDF and MJCF → the word of a URDF.
_OTHERS = {"pose": "origin", "pos": "xyz", "quat": "quat_xyzw", "min": "lower", "max": "upper", "file": "filename"}
# The least similarity of a misspelt word, and of one outside of links and joints, where files have words of their own.
_SIMILAR, _MISSPELT = 0.6, 0.8
# Larger angles are more than a turn, also if a turn was rounded.
_TURN = 6.3


def notes_on_words(document: ET.Element) -> Iterator[str]:
    """Yield a note for each kind of element that has words nobody reads: what they are, and how many there are."""
    words = _Words()
    for element in document:
        if element.tag in ("link", "joint", "material"):
            words.look(element, f"{element.tag} {quoted(element.get('name', ''))}")
        elif _own(element.tag) and nearest_names(element.tag, _WORDS, 1, _MISSPELT):
            words.add("robot", f"<{element.tag}>", _advice(element.tag, ("link", "joint", "material"), "<{}>"), "")
    yield from words.notes()


class _Words:
    """What nobody reads: the element that has it and the word → how often, advice, and where it is first."""

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], tuple[int, str, str]] = {}
        self._turned: list[str] = []  # angles of more than a turn

    def look(self, element: ET.Element, where: str) -> None:
        """Look at an element and all in it that is known."""
        attributes, children = (part.split() for part in _WORDS[element.tag].split("|"))
        known = [child.removesuffix("*") for child in children]
        for name in element.attrib:
            if name not in attributes and _own(name):
                self.add(element.tag, name, _advice(name, attributes, "{}"), where)
        text = " ".join([element.text or "", *(child.tail or "" for child in element)]).strip()
        if text:
            self.add(element.tag, "text", f", {quoted(text, 40)}", where)
        if element.tag == "origin" and max(map(abs, finite_numbers(element.get("rpy", ""))), default=0.0) > _TURN:
            self._turned.append(f"{where} has an origin with rpy {quoted(element.get('rpy'), 60)}")
        seen = set[str]()
        for child in element:
            if child.tag in known:
                # One of all shapes is read.
                alike = "shape" if element.tag == "geometry" else child.tag
                if alike in seen and f"{child.tag}*" not in children:
                    self.add(element.tag, f"a second <{child.tag}>", "", where)
                else:
                    self.look(child, where)
                seen.add(alike)
            # An unknown shape without a known one is noted as one that cannot be read.
            elif child.tag not in _EXTENSIONS and _own(child.tag) and (element.tag != "geometry" or seen):
                self.add(element.tag, f"<{child.tag}>", _advice(child.tag, known, "<{}>"), where)

    def add(self, owner: str, word: str, advice: str, where: str) -> None:
        """Count a word of the element `owner` that nobody reads."""
        count, advice, where = self._found.get((owner, word), (0, advice, where))
        self._found[owner, word] = count + 1, advice, where

    def notes(self) -> Iterator[str]:
        """Yield a note for each kind of element, and one on angles of more than a turn."""
        for owner in dict.fromkeys(owner for owner, _ in self._found):
            rows = [(word, *row) for (other, word), row in self._found.items() if other == owner]
            words = [f"{word}{f' ({count} times)' if count > 1 else ''}{advice}" for word, count, advice, _ in rows]
            where = f"; the first in {rows[0][3]}" if rows[0][3] else ""
            yield f"not read in <{owner}>: {abbreviated(', '.join(words), 300)}{where}"
        if self._turned:
            more = f" (and {len(self._turned) - 1} more)" if len(self._turned) > 1 else ""
            yield f"{self._turned[0]}, more than a turn: are these degrees?{more}"


def _advice(word: str, known: Sequence[str], form: str) -> str:
    """Return where a known element belongs, or the nearest known words, or the only one; "" for none."""
    owners = [owner for owner, words in _WORDS.items() if word in words.partition("|")[2].replace("*", "").split()]
    if owners and form == "<{}>":
        return f" (belongs into {' or '.join(map(form.format, owners))})"
    other = _OTHERS.get(word.lower(), "")
    near = [other] if other in known else nearest_names(word, known, 1, _SIMILAR) or known[: len(known) == 1]
    return f" (nearest: {', '.join(map(form.format, near))})" if near else ""


def _own(word: str) -> bool:
    """Return whether a word has no prefix, as those of extensions do."""
    return ":" not in word and word != "xmlns"


# --- Notes on what a URDF says and this library does not use, and on numbers that no robot has.

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
