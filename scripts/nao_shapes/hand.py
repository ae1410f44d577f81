"""The left hand: a palm that continues the wrist, and the phalanges, used for every finger of both hands."""

from __future__ import annotations

from manifold3d import Manifold

from nao_shapes.loft import End, Section, loft
from nao_shapes.solids import Part, Point, ball, both, lathe, pill, rod, union

# Reaches to the left, right, up and down along the hand [mm].
_PALM = (
    Section(6.0, (23.5, 23.5, 23.5, 21.0), 2.3),
    Section(26.0, (25.0, 25.0, 25.0, 22.0), 2.5),
    Section(46.0, (25.0, 25.0, 22.5, 21.5), 2.6),
    Section(62.0, (24.0, 24.0, 17.0, 19.0), 2.6),
    Section(72.0, (23.0, 23.0, 11.0, 15.0), 2.6),
)
_KNUCKLE: Point = (69.07, 11.57, -3.04)
_THUMB: Point = (48.95, 0.0, -26.38)
_PHALANX = 14.36


def palm() -> Part:
    """The link of LWristYaw."""
    shell = loft(_PALM, End(5.0, 0.25, 3), End(12.0, 0.7, 4), axis="x", around=36, along=4)
    wrist = rod((-8.0, 0.0, 0.0), (14.0, 0.0, 0.0), 21.0, 0.0, 24)
    x, _, z = _THUMB
    arm_of_thumb = Manifold.batch_hull([_pin(_THUMB, 7.2, 7.2), ball(7.0, (x - 4.0, 0.0, z + 10.0), 12)])
    return {
        "white": shell - both(_pin(_KNUCKLE, 9.0, 8.4)),
        "dark": union([wrist, both(_pin(_KNUCKLE, 7.4, 7.2)), arm_of_thumb]),
    }


def _pin(at: Point, radius: float, half_width: float) -> Manifold:
    """A short axle across the hand."""
    x, y, z = at
    return rod((x, y - half_width, z), (x, y + half_width, z), radius, 1.6, 16)


def phalanx() -> Part:
    """A finger bone between two hinges, in the frame of the finger: x along it, z the hinge."""
    return {"dark": _bone(6.5, 6.0, 6.2)}


def fingertip() -> Part:
    """The last bone: round at its end."""
    return {"dark": _bone(6.0, 5.0, 5.6)}


def _bone(near: float, far: float, half_width: float) -> Manifold:
    ends = ((0.0, near), (_PHALANX, far))
    rods = (lathe(pill(r, 2 * half_width, 4.5, 4.5, 3), 14).translate((x, 0.0, -half_width)) for x, r in ends)
    return Manifold.batch_hull(list(rods))
