"""Leg of the left side, hip to ankle: a cover over the slanted axle, a thigh, and a shin whose knee is a drum.

The drum of the knee and the balls of hip and ankle are round about their joints: what slides over them leaves no gap.
"""

from __future__ import annotations

import numpy as np
from manifold3d import Manifold

from nao_shapes.loft import End, Floats, Section, loft
from nao_shapes.solids import FAR, Part, Y, Z, ball, box, lathe, pill, place, prism, rod, slab

_THIGH_LENGTH = 100.0
# Radii of the knee's drum and the ankle's ball, and the gap around them [mm].
_KNEE, _ANKLE, _GAP = 31.5, 27.0, 0.8
# Reaches to the front, back, outside and inside by height over the hip joint [mm].
_THIGH = (
    Section(-100.0, (29.0, 25.0, 36.0, 33.5), 2.7),
    Section(-78.0, (35.5, 30.0, 38.5, 35.0), 2.7),
    Section(-55.0, (40.5, 36.0, 42.0, 37.0), 2.6),
    Section(-28.0, (42.0, 43.0, 44.0, 37.5), 2.6),
    Section(0.0, (40.0, 41.0, 43.0, 35.0), 2.5),
    Section(26.0, (37.0, 36.0, 40.0, 30.0), 2.4),
)
# The same over the knee joint.
_SHIN = (
    Section(-97.0, (24.5, 33.0, 33.5, 31.5), 2.5),
    Section(-80.0, (31.5, 38.0, 38.5, 35.5), 2.6),
    Section(-60.0, (38.5, 36.0, 41.5, 37.0), 2.6),
    Section(-38.0, (41.0, 28.0, 41.0, 37.0), 2.6),
    Section(-16.0, (37.5, 24.0, 38.0, 35.0), 2.6),
    Section(2.0, (31.0, 22.0, 35.5, 33.0), 2.6),
)


def pelvis() -> Part:
    """What LHipYawPitch turns: the cover of the slanted axle, over the ball of the hip."""
    disc = rod((0.0, -14.0, 14.0), (0.0, -20.5, 20.5), 25.5, 3.0, 28)
    return {"white": Manifold.batch_hull([disc, ball(27.0, segments=24)])}


def hip() -> Part:
    """What LHipRoll turns: the motor behind the hip, under the cover that the robot sits on."""
    cap = rod((-50.6, 0.0, -1.0), (-40.0, 0.0, -1.0), 11.0, 1.2, 20)
    return {"white": box((-49.5, -25.0, -45.5), (12.0, 25.0, 24.0), 16.0, 4), "grey": cap}


def thigh() -> Part:
    """What LHipPitch turns: hollow below, where the knee's drum turns in it."""
    plate = prism([(-15.0, -24.0), (20.0, -24.0), (14.0, -62.0), (-10.0, -62.0)], 36.0, FAR, 7.0)
    disc = place(lathe(pill(14.0, 4.9, 0.0, 1.6), 28), (0.0, 40.0, -9.0), Y)
    drum = rod((0.0, -60.0, -_THIGH_LENGTH), (0.0, 60.0, -_THIGH_LENGTH), _KNEE + _GAP, 0.0, 48)
    # Seen through the gap alone.
    fork = rod((0.0, 0.0, -60.0), (0.0, 0.0, -_THIGH_LENGTH), 12.0, 0.0, 12)
    return {"white": _thigh(0.0) - drum, "accent": _thigh(0.9) ^ plate, "grey": disc + fork}


def shin() -> Part:
    """What LKneePitch turns."""
    plate = prism([(-14.0, -34.0), (17.0, -30.0), (18.0, -66.0), (-16.0, -74.0)], 34.0, FAR, 7.0)
    return {
        "white": _shin(0.0) + rod((0.0, -33.0, 0.0), (0.0, 36.0, 0.0), _KNEE, 5.0, 48),
        "accent": _shin(0.9) ^ plate,
        "grey": rod((0.0, -34.0, 0.0), (0.0, 37.2, 0.0), 13.0, 1.5, 24),
    }


def ankle() -> Part:
    """What LAnklePitch turns: the ball between shin and foot, and in it the cross of the two axles."""
    return {"grey": ball(_ANKLE, segments=28) ^ slab(Z, -20.0, 22.0)}


def _thigh(grow: float) -> Manifold:
    return loft(_THIGH, End(4.0, 0.1, 1), End(30.0, 0.8, 5), grow=grow, around=44, along=7)


def _shin(grow: float) -> Manifold:
    return loft(_SHIN, End(6.0, 0.25, 2), End(10.0, 0.5, 2), grow=grow, around=44, along=8, press=_cuff)


def _cuff(points: Floats) -> Floats:
    """The lower rim of the shin rises to the front, where the foot comes up to it."""
    x, y, z = points.T
    share = np.clip((-45.0 - z) / 50.0, 0.0, 1.0)
    return np.column_stack([x, y, z + 0.24 * (x + 14.0) * share**2])
