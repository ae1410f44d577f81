"""The left hand: a shell over its back, the dark palm under it, and the finger bones, which serve all fingers."""

from __future__ import annotations

from manifold3d import Manifold

from nao_shapes.loft import End, Section, loft
from nao_shapes.solids import FAR, Part, Point, X, both, box, lathe, pill, place, prism, rod, slab, union

# Reaches to the left, right, up and down along the hand [mm].
_HAND = (
    Section(11.0, (21.5, 21.5, 21.0, 19.5), 2.3),
    Section(24.0, (24.5, 24.5, 24.8, 21.5), 2.5),
    Section(42.0, (26.0, 26.0, 23.8, 21.0), 2.7),
    Section(60.0, (25.2, 25.2, 18.5, 19.0), 2.8),
    Section(75.0, (23.0, 23.0, 11.5, 15.0), 2.8),
)
_KNUCKLE: Point = (69.07, 11.57, -3.04)
_THUMB: Point = (48.95, 0.0, -26.38)
# Radius along the wrist: the disc that closes the forearm, and the neck of the hand.
_WRIST = [(0.0, -8.0), (25.2, -8.0), (25.2, 8.6), (20.0, 9.2), (20.0, 11.6), (0.0, 11.6)]
# Cut from the shell as seen from the side, x and z: where the palm lies and the fingers come out.
_OPEN = [(47.0, -FAR), (47.0, -15.0), (61.0, 3.2), (FAR, 3.2), (FAR, -FAR)]
# The palm under it, in the same view.
_PAD = [(44.0, -16.4), (50.5, -16.4), (64.0, -6.0), (64.0, 2.6), (44.0, 2.6)]
# Touch sensors on the back and on both sides [mm]: x from and to, and half of the width.
_TOUCH = (25.0, 49.0, 8.0)
# Length of a finger bone, and the planes at its ends [mm]: the inner side, at negative y, leaves room to bend.
_PHALANX = 14.36
_MITRE, _GAP = (1.0, 0.30, 0.0), 2.0


def palm() -> Part:
    """The link of LWristYaw."""
    wrist = place(lathe(_WRIST, 32), (0.0, 0.0, 0.0), X)
    x, y, _ = _KNUCKLE
    slot = box((x - 8.0, y - 6.9, -FAR), (FAR, y + 6.9, FAR))
    pad = prism(_PAD, -17.4, 17.4) - both(slot)
    x, _, z = _THUMB
    thumb = Manifold.batch_hull([_pin(_THUMB, 6.0, 8.6), box((x - 10.0, -8.6, z + 6.0), (x + 5.0, 8.6, z + 15.0))])
    fork = rod((x, -5.6, z), (x, 5.6, z), 8.0, 0.0, 14)
    start, end, half = _TOUCH
    back = box((start, -half, 19.0), (end, half, FAR), 4.0)
    side = box((start, 21.0, -5.0), (end - 4.0, FAR, 9.0), 4.0)
    under = box((start - 4.0, -17.0, -FAR), (47.0, 17.0, -14.0), 4.0)
    touch = _hand(0.35) ^ (back + both(side) + under)
    pins = both(_pin(_KNUCKLE, 6.6, 6.7)) + _pin(_THUMB, 6.2, 6.7)
    return {
        "white": _hand(0.0) - prism(_OPEN, -FAR, FAR, 4.0),
        "dark": union([wrist, pad, thumb - fork, pins, touch]),
    }


def _hand(grow: float) -> Manifold:
    return loft(_HAND, End(4.0, 0.2, 3), End(11.0, 0.5, 5), axis="x", grow=grow, around=48, along=5)


def _pin(at: Point, radius: float, half_width: float) -> Manifold:
    """A short axle across the hand."""
    x, y, z = at
    return rod((x, y - half_width, z), (x, y + half_width, z), radius, 0.0, 16)


def phalanx() -> Part:
    """A finger bone between two hinges, in the frame of the finger: x along it, y to its back, z the hinge."""
    x, y, _ = _MITRE
    far = slab((-x, y, 0.0), -FAR, _GAP).translate((_PHALANX, 0.0, 0.0))
    bone = _bone((0.0, 6.4, 6.4), (_PHALANX, 6.2, 6.2))
    return {"dark": (bone - _near() - far) + _hinge(0.0) + _hinge(_PHALANX)}


def fingertip() -> Part:
    """The last bone: round at its end."""
    return {"dark": (_bone((0.0, 6.2, 6.2), (_PHALANX - 0.4, 5.4, 5.6)) - _near()) + _hinge(0.0)}


def _bone(*ends: tuple[float, float, float]) -> Manifold:
    """Return a rounded body along x; each end has a position on x, a radius and half of the width."""
    rods = (lathe(pill(r, 2 * half, 4.4, 4.4, 3), 14).translate((x, 0.0, -half)) for x, r, half in ends)
    return Manifold.batch_hull(list(rods))


def _near() -> Manifold:
    return slab(_MITRE, -FAR, _GAP)


def _hinge(x: float) -> Manifold:
    return rod((x, 0.0, -4.6), (x, 0.0, 4.6), 4.6, 0.0, 10)
