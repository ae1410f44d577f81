"""Where the NAO has which joint of the human body: all that is NAO's own among the joint types."""

from __future__ import annotations

from dataclasses import dataclass

from nao_kin.parameters import JOINTS

NAO_TWISTS = frozenset(row.name for row in JOINTS if row.motion == "twist")
"""NAO's joints that turn a limb about its own length."""


@dataclass(frozen=True)
class BodyPart:
    """Where the NAO has a joint, and what the human has there.

    Attributes:
        name: part of the body.
        joints: NAO's joints there, from the trunk outwards, without the side.
        anatomical: the anatomical joint that moves like them.
        human: the anatomical joints of the human there.
        difference: what the NAO does otherwise than the human.

    Examples:
        >>> part = nk.joints.NAO_ANATOMY[0]
        >>> part.name, part.joints
        ('neck', ('HeadYaw', 'HeadPitch'))
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
