"""The words of a URDF: notes on elements, attributes and texts that no reader of URDF uses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from xml.etree import ElementTree as ET

from nao_kin._core.text import abbreviated, nearest_names, quoted
from nao_kin.robot.urdf.document import finite_numbers

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
# Words of SDF, MJCF and of everyday language → the word of a URDF.
_OTHERS = {
    **dict.fromkeys(("pose", "com", "transform"), "origin"),
    **dict.fromkeys(("pos", "position", "translation"), "xyz"),
    **dict.fromkeys(("rot", "rotation", "orientation", "euler"), "rpy"),
    **dict.fromkeys(("quat", "quaternion", "wxyz", "xyzw"), "quat_xyzw"),
    **dict.fromkeys(("min", "minimum"), "lower"),
    **dict.fromkeys(("max", "maximum"), "upper"),
    **dict.fromkeys(("torque", "force"), "effort"),
    **dict.fromkeys(("file", "uri", "url"), "filename"),
    **dict.fromkeys(("ratio", "factor", "gearing"), "multiplier"),
    "speed": "velocity",
}
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
