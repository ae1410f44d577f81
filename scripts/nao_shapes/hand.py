"""Hand: a rounded palm on the wrist, and phalanges that serve every finger of both hands."""

from __future__ import annotations

from manifold3d import Manifold

from nao_shapes.loft import End, Section, loft
from nao_shapes.palette import Part
from nao_shapes.solids import Point, both, box, rod, union

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
