"""Arm of the left side, shoulder to fingertips: a cap around the shoulder, a sleeve that widens to the wrist, a hand.

The finger bones serve every finger of both hands.
"""

from __future__ import annotations

from manifold3d import Manifold

from nao_shapes.loft import End, Section, loft
from nao_shapes.solids import FAR, Part, Point, X, ball, both, box, rod, slab, union

# Radius of the upper arm about the shoulder.
_CAP = 34.5
# Reaches to the left, right, up and down along the hand [mm].
_PALM = (
    Section(8.0, (21.0, 21.0, 21.0, 18.0), 2.5),
    Section(26.0, (25.0, 25.0, 25.0, 21.0), 2.7),
    Section(48.0, (25.0, 25.0, 22.0, 21.0), 2.8),
    Section(70.0, (23.0, 23.0, 12.0, 16.0), 2.8),
)
_KNUCKLE: Point = (69.07, 11.57, -3.04)
_THUMB: Point = (48.95, 0.0, -26.38)
_PHALANX = 14.36


def shoulder() -> Part:
    """What LShoulderPitch turns: the axle out of the trunk."""
    return {"dark": rod((0.0, -42.0, 0.0), (0.0, -12.0, 0.0), 21.0, 0.0, 24)}


def shoulder_pad() -> Part:
    """The coloured cap on the shoulder, fixed to the upper arm."""
    outside = slab((-0.35, 1.0, 0.30), 10.0, FAR) ^ slab(X, -FAR, 9.0)
    return {"accent": ball(_CAP + 1.0, segments=28) ^ outside}


def upper_arm(length: float, offset: float) -> Part:
    """What LShoulderRoll turns, elbow at (length, offset): round about the shoulder, so that no motion opens a gap."""
    sections = [
        Section(-_CAP, (_CAP, _CAP, _CAP, _CAP), 2.0),
        Section(0.0, (_CAP, _CAP, _CAP, _CAP), 2.0),
        Section(11.0, (33.0, 32.0, 32.6, 32.6), 2.05),
        Section(30.0, (32.0, 28.5, 31.0, 31.0), 2.2),
        Section(0.65 * length, (28.0 + 0.6 * offset, 26.5 - 0.45 * offset, 27.5, 27.5)),
        Section(length - 15.0, (22.0 + offset, 22.0 - offset, 23.0, 23.0)),
    ]
    return {"white": loft(sections, End(_CAP, 1.0, 7), End(8.0, 0.35), axis="x", along=6)}


def elbow() -> Part:
    """What LElbowYaw turns: a tube in the sleeve and the ball of the elbow."""
    return {"dark": rod((-30.0, 0.0, 0.0), (0.0, 0.0, 0.0), 18.5, 0.0) + ball(21.5)}


def hinge() -> Part:
    """The pin of the elbow, fixed to the forearm."""
    return {"dark": rod((0.0, 0.0, -24.0), (0.0, 0.0, 24.0), 13.5, 1.5)}


def forearm(length: float) -> Part:
    """What LElbowRoll turns, wrist at length."""
    sections = [
        Section(7.0, (21.0, 20.0, 22.0, 22.0)),
        Section(0.45 * length, (30.0, 27.0, 30.0, 29.0)),
        Section(0.85 * length, (35.0, 32.0, 35.0, 33.5)),
        Section(length + 12.0, (33.5, 31.0, 34.0, 32.5)),
    ]
    shell = loft(sections, End(12.0, 0.6), End(7.0, 0.25), axis="x", around=30, along=3)
    return {"white": shell - rod((length + 4.0, 0.0, 0.0), (length + 40.0, 0.0, 0.0), 25.5, 0.0, 24)}


def palm() -> Part:
    """What LWristYaw turns."""
    shell = loft(_PALM, End(6.0, 0.3, 2), End(12.0, 0.7), axis="x", along=3)
    x, _, z = _THUMB
    arm_of_thumb = box((x - 7.2, -6.5, z), (x + 7.2, 6.5, z + 14.0))
    wrist = rod((-8.0, 0.0, 0.0), (14.0, 0.0, 0.0), 20.0, 0.0)
    return {
        "white": shell - both(_pin(_KNUCKLE, 9.2, 8.6)),
        "dark": union([wrist, both(_pin(_KNUCKLE, 7.6, 7.4)), _pin(_THUMB, 7.2, 7.5), arm_of_thumb]),
    }


def _pin(at: Point, radius: float, half_width: float) -> Manifold:
    """A short axle across the hand."""
    x, y, z = at
    return rod((x, y - half_width, z), (x, y + half_width, z), radius, 1.2)


def phalanx() -> Part:
    """A finger bone between two hinges, in the frame of the finger: x along it, z the hinge."""
    return {"dark": _bone(6.6, 6.2, 6.0)}


def fingertip() -> Part:
    """The last bone: round at its end."""
    return {"dark": _bone(6.2, 5.2, 5.4)}


def _bone(near: float, far: float, half_width: float) -> Manifold:
    ends = ((0.0, near), (_PHALANX, far))
    return Manifold.batch_hull([rod((x, 0, -half_width), (x, 0, half_width), r, 2.5, 16) for x, r in ends])
