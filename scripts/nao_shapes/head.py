"""The neck and the head: a skull with a flat face under a brow, round eyes with their LED rings, and speaker ears.

Parts in the skull are only slightly below its surface, because rasterizers show dots of long hidden walls seen from
their edge.

The cameras and microphones are at the frames of each version.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np
from manifold3d import Manifold
from scipy.interpolate import PchipInterpolator

from nao_shapes.loft import End, Floats, Section, loft
from nao_shapes.solids import FAR, Part, Point, X, Y, ball, both, box, lathe, place, prism, rod, slab, union

# Reaches to the front, back, left and right by height above the neck joint [mm]. The front is pressed into the face.
_SKULL = (
    Section(-8.0, (50.0, 36.0, 36.0, 36.0), 2.3),
    Section(4.0, (58.0, 46.0, 47.5, 47.5), 2.4),
    Section(22.0, (64.0, 55.5, 57.5, 57.5), 2.5),
    Section(42.0, (68.0, 60.0, 61.5, 61.5), 2.5),
    Section(60.0, (69.0, 62.0, 62.0, 62.0), 2.5),
    Section(82.0, (66.0, 61.5, 61.0, 61.0), 2.45),
    Section(113.5, (60.0, 58.0, 59.0, 59.0), 2.3),
)
# Reach of the middle of the face, from the chin over the mouth and the eyes to the brow.
_FACE = PchipInterpolator(
    [-12.0, -4.0, 6.0, 17.0, 30.0, 46.0, 56.0, 64.0, 76.0, 92.0, 115.0],
    [33.0, 39.5, 48.0, 53.0, 55.0, 57.0, 59.0, 61.0, 60.5, 55.0, 36.0],
)
# Radius of the face seen from above, and the width of the transition to the cheeks [mm].
_FACE_RADIUS, _FACE_EDGE = 82.0, 2.2

_EYE: Point = (57.0, 26.0, 46.0)
_EYE_TURN = math.radians(19.0)
_EYE_LOOKS: Point = (math.cos(_EYE_TURN), math.sin(_EYE_TURN), 0.0)
_EAR: Point = (3.8, 55.5, 52.6)
_EAR_RADIUS = 26.5
_TOUCH = [
    (-37.0, 6.0),
    (-37.0, -6.0),
    (-34.0, -9.0),
    (37.0, -9.0),
    (40.0, -6.0),
    (40.0, 6.0),
    (37.0, 9.0),
    (-34.0, 9.0),
]
# Where the shell of the face meets that of the back: behind the ears, over the crown.
_SEAM: Point = (1.0, 0.0, 0.16)


def neck() -> Part:
    """The dark column that carries the head and turns in the collar."""
    column = [(0.0, -34.0), (17.0, -34.0), (17.0, -20.0), (14.5, -12.0), (14.5, 0.0), (0.0, 0.0)]
    return {"dark": lathe(column, 28) + ball(19.0, segments=20)}


def head() -> Part:
    """The link of HeadPitch without the ears and the sensors, in the frame of HeadPitch."""
    socket = place(lathe([(0, -4.4), (17.4, -4.4), (17.4, -1.6), (21.5, 4.0), (0, 4.0)], 48), _EYE, _EYE_LOOKS)
    well = place(lathe([(0, -2.0), (_EAR_RADIUS + 0.8, -2.0), (_EAR_RADIUS + 0.8, 16.0), (0, 16.0)], 48), _EAR, Y)
    # Turned up from the x-z plane.
    outline = prism(_TOUCH, 95.0, FAR, 4.0).rotate((90.0, 0.0, 0.0))
    gaps = union(slab(X, x - 0.7, x + 0.7) for x in (-10.5, 15.0))
    seam = _skull(0.15) ^ slab(_SEAM, 3.25, 4.3)
    return {
        "white": _skull(0.0) - both(socket) - both(well),
        "dark": both(_eye((0.0, 17.0), -0.9, -4.2, 40)) + ((_skull(0.8) ^ outline) - gaps),
        "black": both(_eye((0.0, 4.5, 8.2), 0.7, -3.5, 32)),
        "led": both(_eye_leds()),
        "grey": seam - both(well),
    }


def ears(ring: str) -> Part:
    """The loudspeakers: a ring in the colour `ring` around a dish with a grille of concentric bars."""
    r = _EAR_RADIUS
    frame = [(r - 5.5, 0.0), (r, 0.0), (r, 5.4), (r - 0.9, 7.7), (r - 2.6, 8.6), (r - 5.5, 8.2)]
    dish = [(0.0, 0.0), (r - 5.8, 0.0), (r - 5.8, 6.6), (15.6, 6.0)]
    for bar in (15.6, 10.8):
        dish += [(bar, 5.0), (bar - 1.6, 5.0), (bar - 1.6, 7.0), (bar - 4.8, 7.2)]
    dish[-1] = (0.0, 7.4)
    behind = lathe([(0.0, 3.0), (16.0, 3.0), (16.0, 5.6), (0.0, 5.6)], 12)
    found = {"grey": both(place(lathe(dish, 30), _EAR, Y)), "dark": both(place(behind, _EAR, Y))}
    rings = both(place(lathe(frame, 40), _EAR, Y))
    return found | {ring: found[ring] + rings if ring in found else rings}


def sensors(cameras: Sequence[tuple[Point, float]], microphones: Sequence[Point]) -> Part:
    """The two cameras and the holes of the microphones.

    Args:
        cameras: position in the frame of HeadPitch, and downward tilt [rad].
        microphones: their positions; the holes are drawn on the shell.
    """
    rims, lenses = [], []
    for at, down in cameras:
        look = (math.cos(down), 0.0, -math.sin(down))
        start = (at[0] - look[0], 0.0, at[2] - look[2])
        end = (at[0] + 25.0 * look[0], 0.0, at[2] + 25.0 * look[2])
        rims.append(_skull(0.5) ^ rod(start, end, 6.4, 0.0, 32))
        lenses.append(_skull(0.8) ^ rod(start, end, 4.4, 0.0, 24))
    middle = np.array((0.0, 0.0, 45.0))
    holes = []
    for at in np.array(microphones):
        start, end = (tuple(middle + share * (at - middle)) for share in (0.93, 3.0))
        holes.append(_skull(0.25) ^ rod(start, end, 1.4, 0.0, 10))
    return {"dark": union(rims) + union(holes), "black": union(lenses)}


def _skull(grow: float) -> Manifold:
    press = partial(_with_face, grow=grow)
    return loft(_SKULL, End(11.0, 0.55, 4), End(50.0, 1.0, 11), grow=grow, around=60, along=8, press=press)


def _with_face(points: Floats, grow: float) -> Floats:
    """The front of the skull limited by the face: a smooth minimum of both."""
    x, y, z = points.T
    face = _FACE(np.clip(z, -12.0, 115.0)) - y**2 / (2 * _FACE_RADIUS) + grow
    softly = -_FACE_EDGE * np.logaddexp(-x / _FACE_EDGE, -face / _FACE_EDGE)
    return np.column_stack([np.where(x > 0.0, np.minimum(x, softly), x), y, z])


def _eye(radii: tuple[float, ...], lift: float, depth: float, segments: int) -> Manifold:
    """A ring, or a disc from radius 0, on the curve of the face."""
    front = [(radius, lift - radius**2 / 130.0) for radius in radii]
    return place(lathe([*front, (radii[-1], depth), (radii[0], depth)], segments), _EYE, _EYE_LOOKS)


def _eye_leds() -> Manifold:
    """Eight segments of a ring."""
    gaps = union(box((0.0, -0.5, -30.0), (FAR, 0.5, 30.0)).rotate((0.0, 0.0, 22.5 + 45.0 * i)) for i in range(8))
    return _eye((9.4, 15.4), 0.3, -3.5, 32) - place(gaps, _EYE, _EYE_LOOKS)
