"""Joints of the human body, the machine joints that move like them, and where the NAO has which."""

from __future__ import annotations

import re
from dataclasses import dataclass

from nao_kin.joints.pairs import LOWER_PAIRS, LowerPair
from nao_kin.parameters import JOINTS


@dataclass(frozen=True)
class AnatomicalJoint:
    """A kind of synovial joint.

    Attributes:
        name: its anatomical name.
        mechanical: names of the pairs that move like it, the closest first.
        freedoms: degrees of freedom of each of these.
        allows: what it allows.
        forbids: what it forbids.
        example: where the human body has it.
        table: the table of the source that lists it.
    """

    name: str
    mechanical: tuple[str, ...]
    freedoms: tuple[int, ...]
    allows: str
    forbids: str
    example: str
    table: str

    @property
    def pairs(self) -> tuple[LowerPair, ...]:
        """The mechanical equivalents."""
        return tuple(LOWER_PAIRS[name] for name in self.mechanical)


ANATOMY: tuple[AnatomicalJoint, ...] = (
    AnatomicalJoint(
        "hinge",
        ("revolute",),
        (1,),
        "rotation about one axis, across the bone",
        "rotation about any other axis; all translation",
        "elbow, knee, fingers",
        "I",
    ),
    AnatomicalJoint(
        "pivot",
        ("revolute", "cylindrical"),
        (1, 2),
        "rotation about one axis, along the bone; where it slides, translation along that axis too",
        "rotation about any other axis; translation across the axis",
        "atlas on the axis of the neck, radius on the ulna",
        "I",
    ),
    AnatomicalJoint(
        "ball and socket",
        ("spherical",),
        (3,),
        "rotation about every axis through one point",
        "all translation",
        "shoulder, hip",
        "I",
    ),
    AnatomicalJoint(
        "ellipsoid",
        ("condyloid",),
        (2,),
        "rotation about two axes: flexion and extension, abduction and adduction",
        "rotation about the bone's own axis; all translation",
        "wrist, skull on the atlas",
        "I",
    ),
    AnatomicalJoint(
        "saddle",
        ("universal",),
        (2,),
        "rotation about two crossing axes",
        "rotation about the bone's own axis; all translation",
        "base of the thumb",
        "I",
    ),
    AnatomicalJoint(
        "plane",
        ("planar", "prismatic"),
        (3, 1),
        "gliding in a plane and rotation about its normal; where it is guided, translation along one line only",
        "leaving the plane; rotation about directions in it",
        "between the bones of the carpus and of the tarsus, between vertebrae",
        "II",
    ),
)
"""Tables I and II of the source paper: six anatomical joints, their mechanical equivalents and degrees of freedom."""


@dataclass(frozen=True)
class BodyPart:
    """Where the NAO has a joint, and what the human has there.

    Attributes:
        name: part of the body.
        joints: NAO's joints there, from the trunk outwards, without the side.
        anatomical: the anatomical joint that moves like them.
        human: the anatomical joints of the human there.
        difference: what the NAO does otherwise than the human.
    """

    name: str
    joints: tuple[str, ...]
    anatomical: str
    human: tuple[str, ...]
    difference: str


NAO_ANATOMY: tuple[BodyPart, ...] = (
    BodyPart("neck", ("HeadYaw", "HeadPitch"), "saddle", ("pivot", "ellipsoid"), "does not lean the head sideways"),
    BodyPart(
        "shoulder",
        ("ShoulderPitch", "ShoulderRoll"),
        "saddle",
        ("ball and socket",),
        "the turn about the upper arm sits in the elbow",
    ),
    BodyPart(
        "elbow",
        ("ElbowYaw", "ElbowRoll"),
        "saddle",
        ("hinge", "pivot"),
        "turns the upper arm's share of the shoulder's motion; the forearm's turn sits in the wrist",
    ),
    BodyPart("wrist", ("WristYaw",), "pivot", ("ellipsoid",), "turns as the human forearm does; does not bend"),
    BodyPart("hand", ("Hand",), "hinge", ("hinge", "saddle"), "one motor opens all fingers"),
    BodyPart(
        "hip",
        ("HipYawPitch", "HipRoll", "HipPitch"),
        "ball and socket",
        ("ball and socket",),
        "the first axis lies at 45°, and one motor turns it for both hips",
    ),
    BodyPart("knee", ("KneePitch",), "hinge", ("hinge",), "none"),
    BodyPart(
        "ankle", ("AnklePitch", "AnkleRoll"), "saddle", ("hinge", "plane"), "rolls about an axis through the hinge"
    ),
)
"""NAO's own joints mapped to anatomy, as the versions from V3.2 to V6 have them."""

_KIND_OF_PAIR = {pair: kind.name for kind in reversed(ANATOMY) for pair in kind.mechanical}
_TWISTS = frozenset(row.name for row in JOINTS if row.motion == "twist")
_PARTS = tuple(part.name for part in NAO_ANATOMY)
_SIDES = (
    ("left", re.compile(r"^(L(?=[A-Z])|l_|left)|_l(eft)?_")),
    ("right", re.compile(r"^(R(?=[A-Z])|r_|right)|_r(ight)?_")),
)


def anatomical_kind(joints: tuple[str, ...], pair: LowerPair) -> str:
    """The anatomical joint that a joint moves like: "hinge", "ball and socket" …; "" when the body has none like it.

    A revolute is a pivot when it is known to turn a limb about its own length, else a hinge.
    """
    if pair.name == "revolute" and joints[0] in _TWISTS:
        return "pivot"
    return _KIND_OF_PAIR.get(pair.name, "")


def body_part(joint: str) -> str:
    """The part of the body that a joint's name speaks of, as "left hip"; "" when it speaks of none."""
    lower = joint.lower()
    # The head turns in the neck.
    part = next((part for part in _PARTS if part in lower), "neck" if "head" in lower else "")
    side = next((side for side, pattern in _SIDES if pattern.search(joint)), "")
    return f"{side} {part}".strip() if part else ""
