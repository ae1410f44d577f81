"""Leg of the left side, hip to ankle: a cover over the slanted axle, a thigh, and a shin whose knee is a drum.

The drum of the knee and the balls of hip and ankle are round about their joints, so that shells slide over them without
a gap.
"""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from nao_shapes.loft import End, Floats, Section, loft
from nao_shapes.solids import FAR, Part, Y, Z, ball, lathe, pill, place, prism, rod, slab, union

# Radii of the knee's drum and the ankle's ball, the gap around them, and how much wider the drum is in the middle [mm].
_KNEE, _ANKLE, _GAP, _BULGE = 31.5, 27.0, 0.8, 2.2
# The cover that the robot sits on, rounded as if over rollers across it: x, z and radius [mm]. In Sit it touches the
# floor with flat soles, and in SitRelax it carries the robot and not the fingers.
_SEAT = ((-31.0, 5.0, 18.5), (-5.0, 7.0, 17.0), (-25.0, -15.5, 28.6), (-7.0, -38.0, 21.0))
# Reaches to the front, back, outside and inside by height over the hip joint [mm]; the lowest section is at the knee.
_AT_KNEE = ((29.0, 25.0, 36.0, 33.5), 2.7)
_THIGH = (
    Section(-78.0, (35.5, 30.0, 38.5, 35.0), 2.7),
    Section(-55.0, (40.5, 36.0, 42.0, 37.0), 2.6),
    Section(-28.0, (42.0, 43.0, 44.0, 37.5), 2.6),
    Section(0.0, (40.0, 41.0, 43.0, 35.0), 2.5),
    Section(26.0, (37.0, 36.0, 40.0, 30.0), 2.4),
)
# The same over the knee joint; the lowest section is 5.9 mm above the ankle.
_AT_ANKLE = ((24.5, 33.0, 33.5, 31.5), 2.5)
_SHIN = (
    Section(-80.0, (31.5, 38.0, 38.5, 35.5), 2.6),
    Section(-60.0, (38.5, 36.0, 41.5, 37.0), 2.6),
    Section(-38.0, (41.0, 28.0, 41.0, 37.0), 2.6),
    Section(-16.0, (37.5, 24.0, 38.0, 35.0), 2.6),
    Section(2.0, (31.0, 22.0, 35.5, 33.0), 2.6),
)


def pelvis() -> Part:
    """The link of LHipYawPitch: the cover of the slanted axle, over the ball of the hip."""
    disc = rod((0.0, -14.0, 14.0), (0.0, -20.5, 20.5), 25.5, 3.0, 24)
    return {"white": Manifold.batch_hull([disc, ball(27.0, segments=20)])}


def hip() -> Part:
    """The link of LHipRoll: the motor behind the hip, under the cover on which the robot sits."""
    cover = [_roller(x, z, radius) for x, z, radius in _SEAT]
    cap = rod((-52.2, 0.0, -0.2), (-42.4, 0.0, -2.3), 8.8, 1.2, 24)
    return {"white": Manifold.batch_hull(cover), "grey": cap}


def _roller(x: float, z: float, radius: float) -> Manifold:
    return place(lathe(pill(radius, 50.0, 14.0, 14.0, 4), 36), (x, -25.0, z), Y)


def thigh(length: float) -> Part:
    """The link of LHipPitch, knee at length: hollow below, where the knee's drum turns in it."""
    plate = prism([(-15.0, -24.0), (20.0, -24.0), (14.0, -62.0), (-10.0, -62.0)], 36.0, FAR, 7.0)
    disc = place(lathe(pill(14.0, 4.9, 0.0, 1.6), 28), (0.0, 40.0, -9.0), Y)
    drum = _drum(-60.0, 60.0, 1.0, _GAP).translate((0.0, 0.0, -length))
    # Visible only through the gap.
    fork = rod((0.0, 0.0, -60.0), (0.0, 0.0, -length), 12.0, 0.0, 12)
    return {"white": _thigh(length, 0.0) - drum, "accent": _thigh(length, 0.9) ^ plate, "grey": disc + fork}


def shin(length: float) -> Part:
    """The link of LKneePitch, ankle at length."""
    plate = prism([(-14.0, -34.0), (17.0, -30.0), (18.0, -66.0), (-16.0, -74.0)], 34.0, FAR, 7.0)
    # The pin is in a recess on each side, because the shell bulges below it.
    wells = (rod((0.0, start, 0.0), (0.0, end, 0.0), 13.8, 0.0, 32) for start, end in ((-60.0, -31.0), (34.0, 60.0)))
    return {
        "white": _shin(length, 0.0) + _drum(-33.0, 36.0, 8.5) - union(wells),
        "accent": _shin(length, 0.9) ^ plate,
        "grey": rod((0.0, -33.8, 0.0), (0.0, 36.8, 0.0), 13.0, 1.2, 32),
    }


def ankle() -> Part:
    """The link of LAnklePitch: the ball between shin and foot, and in it the cross of the two axles."""
    return {"grey": ball(_ANKLE, segments=24) ^ slab(Z, -20.0, 22.0)}


def _drum(low: float, high: float, edge: float, grow: float = 0.0) -> Manifold:
    """The knee: a body of revolution about y, wider in the middle, its rims rounded with radius `edge`."""
    turn = np.linspace(0.0, np.pi / 2, 3)
    rim = edge * (1 - np.cos(turn))
    y = np.concatenate([low + rim, np.linspace(low + edge, high - edge, 5)[1:-1], high - rim[::-1]])
    inwards = np.clip(1 - np.minimum(y - low, high - y) / edge, 0.0, 1.0)
    radius = _KNEE + grow - _BULGE * np.clip(y / 36.0, -1.0, 1.0) ** 2 - edge * (1 - np.sqrt(1 - inwards**2))
    profile = [(0.0, low), *zip(radius.tolist(), y.tolist(), strict=True), (0.0, high)]
    return place(lathe(profile, 38), (0.0, 0.0, 0.0), Y)


def _thigh(length: float, grow: float) -> Manifold:
    sections = (Section(-length, *_AT_KNEE), *_THIGH)
    return loft(sections, End(4.0, 0.1, 1), End(30.0, 0.8, 5), grow=grow, around=44, along=7)


def _shin(length: float, grow: float) -> Manifold:
    sections = (Section(5.9 - length, *_AT_ANKLE), *_SHIN)
    return loft(sections, End(6.0, 0.25, 2), End(10.0, 0.5, 2), grow=grow, around=44, along=8, press=_cuff)


def _cuff(points: Floats) -> Floats:
    """The lower rim of the shin rises to the front, where the foot comes up to it."""
    x, y, z = points.T
    share = np.clip((-45.0 - z) / 50.0, 0.0, 1.0)
    return np.column_stack([x, y, z + 0.24 * (x + 14.0) * share**2])
