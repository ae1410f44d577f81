"""The neck and the head: a skull with a flat face under a brow, round eyes with their LED rings, and speaker ears.

Lines between shells are gaps with a grey strip in them, because rasterizers show dots of long hidden walls seen from
their edge, and of a strip that is on a shell.

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
from nao_shapes.solids import FAR, Part, Point, Profile, X, Y, ball, both, box, lathe, place, prism, rod, slab, union

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

# The plane that fits the face around an eye: its middle, and how far it turns outwards and down.
_EYE: Point = (53.0, 26.5, 46.0)
_EYE_TURN, _EYE_DOWN = math.radians(18.0), math.radians(7.0)
_EYE_LOOKS: Point = (math.cos(_EYE_TURN), math.sin(_EYE_TURN), -math.tan(_EYE_DOWN))
# Radius and height over that plane: the floor under the segments with a rim around the lens, the lens, a segment.
_EYE_FLOOR = [(0.0, -8.0), (17.0, -8.0), (17.0, -2.2), (9.6, -3.0), (9.2, -1.3), (7.8, -1.5), (0.0, -1.5)]
_LENS = [(0.0, -2.8), (8.1, -2.8), (8.1, -1.6), (7.2, -0.6), (5.2, 0.2), (2.8, 0.6), (0.0, 0.8)]
_LEDS = [(10.0, -4.0), (15.9, -4.0), (15.9, -0.6), (10.0, -1.7)]
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
# Where the shell of the face meets that of the back, behind the ears and over the crown, and the jaw, from ear to ear
# round the chin: normals of planes, and how far these are from the neck joint [mm].
_SEAM, _SEAM_AT = (1.0, 0.0, 0.16), 3.8
_JAW, _JAW_AT = (0.42, 0.0, 0.907), 25.0
_GROOVE = 0.5


def neck() -> Part:
    """The dark column that carries the head and turns in the collar."""
    column = [(0.0, -34.0), (17.0, -34.0), (17.0, -20.0), (14.5, -12.0), (14.5, 0.0), (0.0, 0.0)]
    return {"dark": lathe(column, 24) + ball(19.0, segments=14)}


def head() -> Part:
    """The link of HeadPitch without the ears and the sensors, in the frame of HeadPitch."""
    socket = place(rod((0.0, 0.0, -9.0), (0.0, 0.0, 30.0), 17.7, 0.0, 56), _EYE, _EYE_LOOKS)
    well = place(rod((0.0, 0.0, -2.0), (0.0, 0.0, 16.0), _EAR_RADIUS - 3.0, 0.0, 32), _EAR, Y)
    # Turned up from the x-z plane.
    outline = prism(_TOUCH, 95.0, FAR, 4.0).rotate((90.0, 0.0, 0.0))
    # No line runs behind an ear.
    ear = rod((_EAR[0], -FAR, _EAR[2]), (_EAR[0], FAR, _EAR[2]), _EAR_RADIUS - 1.5, 0.0, 40)
    gaps = union(slab(X, x - 0.7, x + 0.7) for x in (-10.5, 15.0))
    touch = (_skull(0.8, fine=True) - _skull(-0.7)) ^ (outline - gaps)
    grooves, strips = _lines(_GROOVE) - ear, _lines(_GROOVE + 0.3) - ear
    return {
        "white": _skull(0.0, fine=True) - grooves - both(socket) - both(well),
        "dark": both(_eye_rim() + _lathe_eye(_EYE_FLOOR)) + touch,
        "black": both(_lathe_eye(_LENS)),
        "led": both(_eye_leds()),
        "grey": _skull(-0.2, fine=True) ^ strips,
    }


def _lines(half_width: float) -> Manifold:
    """Return the seams between the shells of the head, as solids of twice this width."""
    seam = slab(_SEAM, _SEAM_AT - half_width, _SEAM_AT + half_width)
    return seam + (slab(_JAW, _JAW_AT - half_width, _JAW_AT + half_width) ^ slab(_SEAM, _SEAM_AT, FAR))


def ears(ring: str) -> Part:
    """The loudspeakers: a ring in the colour `ring` around a dish with a grille of concentric bars."""
    r = _EAR_RADIUS
    rim = [(r - 3.6 * (1 - math.cos(turn)), 5.2 + 3.4 * math.sin(turn)) for turn in np.linspace(0.0, 1.4, 3)]
    frame = [(r - 5.5, -4.0), (r, -4.0), *rim, (r - 4.8, 8.2)]
    dish = [(0.0, 0.0), (r - 4.8, 0.0), (r - 4.8, 6.4), (15.6, 6.0)]
    for bar in (15.6, 10.8):
        dish += [(bar - 0.8, 4.2), (bar - 1.6, 7.0), (bar - 4.8, 7.2)]
    dish[-1] = (0.0, 7.4)
    behind = lathe([(0.0, 3.0), (16.0, 3.0), (16.0, 5.6), (0.0, 5.6)], 12)
    found = {"grey": both(place(lathe(dish, 28), _EAR, Y)), "dark": both(place(behind, _EAR, Y))}
    rings = both(place(lathe(frame, 46), _EAR, Y))
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
        rims.append(_skull(0.5, fine=True) ^ rod(start, end, 6.4, 0.0, 32))
        lenses.append(_skull(0.8, fine=True) ^ rod(start, end, 4.4, 0.0, 24))
    middle = np.array((0.0, 0.0, 45.0))
    holes = []
    for at in np.array(microphones):
        start, end = (tuple(middle + share * (at - middle)) for share in (0.93, 3.0))
        holes.append(_skull(0.33, fine=True) ^ rod(start, end, 1.4, 0.0, 10))
    return {"dark": union(rims) + union(holes), "black": union(lenses)}


def _skull(grow: float, fine: bool = False) -> Manifold:
    """The skull, with more corners where its outline shows or it must lie close to the shell."""
    press = partial(_with_face, grow=grow)
    around, along, crown = (68, 8, 12) if fine else (44, 5, 8)
    ends = End(11.0, 0.55, 5 if fine else 3), End(50.0, 1.0, crown)
    return loft(_SKULL, *ends, grow=grow, around=around, along=along, press=press)


def _with_face(points: Floats, grow: float) -> Floats:
    """The front of the skull limited by the face: a smooth minimum of both."""
    x, y, z = points.T
    face = _FACE(np.clip(z, -12.0, 115.0)) - y**2 / (2 * _FACE_RADIUS) + grow
    softly = -_FACE_EDGE * np.logaddexp(-x / _FACE_EDGE, -face / _FACE_EDGE)
    return np.column_stack([np.where(x > 0.0, np.minimum(x, softly), x), y, z])


def _eye_rim() -> Manifold:
    """A frame that follows the face."""
    inside, outside = (rod((0.0, 0.0, -5.0), (0.0, 0.0, 30.0), radius, 0.0, 44) for radius in (16.4, 18.6))
    return _skull(0.5) ^ place(outside - inside, _EYE, _EYE_LOOKS)


def _lathe_eye(profile: Profile) -> Manifold:
    return place(lathe(profile, 40), _EYE, _EYE_LOOKS)


def _eye_leds() -> Manifold:
    """Eight segments of a dish."""
    gaps = union(box((0.0, -0.4, -30.0), (FAR, 0.4, 30.0)).rotate((0.0, 0.0, 22.5 + 45.0 * i)) for i in range(8))
    return _lathe_eye(_LEDS) - place(gaps, _EYE, _EYE_LOOKS)
