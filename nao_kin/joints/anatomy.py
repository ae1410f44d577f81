"""Joints of the human body, the machine joints that move like them, and what a joint's name says of the body."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

from nao_kin._text import html_table, quoted, text_table
from nao_kin.errors import BadArgument
from nao_kin.joints.kinematic_pairs import KINEMATIC_PAIRS, KinematicPair
from nao_kin.joints.nao_anatomy import NAO_TWISTS


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

    Examples:
        >>> hinge = nk.joints.ANATOMY[0]
        >>> hinge.name, hinge.mechanical
        ('hinge', ('revolute',))
    """

    name: str
    mechanical: tuple[str, ...]
    freedoms: tuple[int, ...]
    allows: str
    forbids: str
    example: str
    table: str

    @property
    def pairs(self) -> tuple[KinematicPair, ...]:
        """The mechanical equivalents."""
        return tuple(KINEMATIC_PAIRS[name] for name in self.mechanical)


class AnatomyTable(tuple[AnatomicalJoint, ...]):
    """A tuple of anatomical joints that prints as a table.

    Examples:
        >>> len(nk.joints.ANATOMY), isinstance(nk.joints.ANATOMY, nk.joints.AnatomyTable)
        (6, True)
    """

    __slots__ = ()

    def __repr__(self) -> str:
        return text_table(_HEAD, self._cells())

    def _repr_html_(self) -> str:
        return html_table("Anatomical joints", _HEAD, self._cells())

    def _cells(self) -> list[tuple[str, ...]]:
        return [
            (kind.name, ", ".join(kind.mechanical), ", ".join(map(str, kind.freedoms)), kind.example) for kind in self
        ]


_HEAD = ("joint", "moves like", "freedoms", "example")

ANATOMY = AnatomyTable(
    (
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
)
"""Tables I and II of the source paper: six anatomical joints, their mechanical equivalents and degrees of freedom."""


_KIND_OF_PAIR = {pair: kind.name for kind in reversed(ANATOMY) for pair in kind.mechanical}
_PARTS = ("neck", "shoulder", "elbow", "wrist", "hand", "hip", "knee", "ankle")
_SIDES = (
    ("left", re.compile(r"^(L(?=[A-Z])|l_|left)|_l(eft)?_")),
    ("right", re.compile(r"^(R(?=[A-Z])|r_|right)|_r(ight)?_")),
)


def anatomical_kind(joints: tuple[str, ...], pair: KinematicPair, *, twists: Collection[str] = NAO_TWISTS) -> str:
    """The anatomical joint that a joint moves like: "hinge", "ball and socket" …; "" when the body has none like it.

    Args:
        joints: the joints of the URDF it is made of.
        pair: what kind of joint it is.
        twists: the revolutes known to turn a limb about its own length, NAO's unless given: such a one is a pivot, any
            other a hinge.

    Raises:
        BadArgument: the pair is none.

    Examples:
        >>> nk.joints.anatomical_kind(("LKneePitch",), nk.joints.kinematic_pair("revolute"))
        'hinge'
    """
    if not isinstance(pair, KinematicPair):
        raise BadArgument(f"pair must be a KinematicPair, got {type(pair).__name__}")
    if pair.name == "revolute" and joints[0] in twists:
        return "pivot"
    return _KIND_OF_PAIR.get(pair.name, "")


def body_part(joint: str) -> str:
    """The part of the body that a joint's name speaks of, as "left hip"; "" when it speaks of none.

    Raises:
        BadArgument: no name.

    Examples:
        >>> nk.joints.body_part("LHipRoll")
        'left hip'
    """
    if not isinstance(joint, str):
        raise BadArgument(f"joint must be a name, got {quoted(joint)}")
    lower = joint.lower()
    # The head turns in the neck.
    part = next((part for part in _PARTS if part in lower), "neck" if "head" in lower else "")
    side = next((side for side, pattern in _SIDES if pattern.search(joint)), "")
    return f"{side} {part}".strip() if part else ""
