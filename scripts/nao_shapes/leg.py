"""Leg of the left side: hip, thigh, shin, ankle, and a foot that is a low dome on the sole with bumpers at the toes."""

from __future__ import annotations

from manifold3d import Manifold

from nao_shapes.loft import End, Section, loft
from nao_shapes.solids import FAR, Part, Y, ball, box, lathe, pill, place, prism, rod

# Reaches to the front, back, outside and inside by height over the hip joint [mm].
_THIGH = (
    Section(-95.0, (31.0, 16.0, 36.0, 33.0), 2.6),
    Section(-72.0, (37.0, 25.0, 40.0, 36.0), 2.6),
    Section(-40.0, (42.0, 34.0, 44.0, 38.0), 2.6),
    Section(-12.0, (40.0, 35.0, 44.0, 36.0), 2.5),
    Section(20.0, (34.0, 30.0, 40.0, 30.0), 2.4),
)
# The same over the knee joint.
_SHIN = (
    Section(-91.0, (26.0, 37.0, 38.0, 35.0), 2.6),
    Section(-74.0, (35.0, 39.0, 41.5, 37.0), 2.6),
    Section(-52.0, (42.0, 32.0, 42.5, 37.5), 2.6),
    Section(-30.0, (42.5, 21.0, 40.0, 36.5), 2.6),
    Section(-12.0, (39.0, 13.0, 37.0, 34.5), 2.5),
    Section(10.0, (33.0, 8.0, 34.0, 32.0), 2.4),
)
# Reaches to the front, back, outside and inside by height over the ankle joint [mm].
_DOME = (
    Section(-42.0, (101.0, 52.5, 48.6, 37.4), 2.5),
    Section(-36.0, (100.0, 52.0, 48.2, 37.1), 2.5),
    Section(-29.0, (91.0, 49.5, 46.3, 36.0), 2.5),
    Section(-23.0, (72.0, 45.5, 43.0, 34.5), 2.5),
    Section(-17.0, (49.0, 39.5, 36.0, 30.5), 2.4),
    Section(-7.0, (33.0, 33.0, 29.0, 27.0), 2.3),
)
_SOLE = (Section(-45.1, (99.0, 51.0, 47.2, 36.4), 2.5), Section(-40.0, (101.0, 52.0, 48.0, 37.0), 2.5))
_BUMPER = (Section(-41.5, (103.3, 54.0, 50.0, 38.8), 2.5), Section(-31.0, (100.5, 52.0, 48.4, 37.4), 2.5))


def pelvis() -> Part:
    """What LHipYawPitch turns: the fork on the slanted axle."""
    return {"white": rod((0.0, 4.0, -4.0), (0.0, -19.0, 19.0), 26.5, 5.0, 28), "dark": ball(26.0, segments=24)}


def hip() -> Part:
    """What LHipRoll turns: the motor block behind the hip."""
    return {"grey": rod((-46.0, 0.0, -1.0), (12.0, 0.0, -1.0), 23.0, 4.0, 24)}


def thigh() -> Part:
    """What LHipPitch turns."""
    plate = prism([(-14.0, -28.0), (18.0, -28.0), (13.0, -80.0), (-8.0, -80.0)], 36.0, FAR, 6.0)
    disc = place(lathe(pill(16.0, 6.0, 0.0, 2.0), 24), (0.0, 40.0, 0.0), Y)
    return {"white": _thigh(0.0), "accent": _thigh(0.9) ^ plate, "grey": disc}


def shin() -> Part:
    """What LKneePitch turns."""
    plate = prism([(-12.0, -28.0), (20.0, -24.0), (22.0, -72.0), (-20.0, -80.0)], 34.0, FAR, 6.0)
    return {
        "white": _shin(0.0),
        "accent": _shin(0.9) ^ plate,
        "dark": rod((0.0, -28.0, 0.0), (0.0, 29.0, 0.0), 23.0, 4.0, 24),
    }


def ankle() -> Part:
    """What LAnklePitch turns: the cross of the two ankle axles."""
    return {"dark": rod((0.0, -25.5, 0.0), (0.0, 25.5, 0.0), 19.0, 1.5) + ball(24.0)}


def _thigh(grow: float) -> Manifold:
    return loft(_THIGH, End(9.0, 0.4), End(18.0, 0.65, 4), grow=grow, around=30, along=3)


def _shin(grow: float) -> Manifold:
    return loft(_SHIN, End(8.0, 0.35), End(14.0, 0.6), grow=grow, around=30, along=4)


def foot() -> Part:
    """What LAnkleRoll turns."""
    sole = loft(_SOLE, End(1.0, 0.01, 1), End(1.0, 0.01, 1), around=34, along=0)
    toes = box((62.0, 2.5, -FAR), (FAR, FAR, FAR)) + box((62.0, -FAR, -FAR), (FAR, 0.5, FAR))
    bumper = loft(_BUMPER, End(2.5, 0.02, 2), End(2.5, 0.02, 2), around=34, along=1) ^ toes
    light = place(lathe(pill(4.6, 4.0, 0.0, 1.2), 16).translate((0, 0, -3)), (47.0, 3.0, -15.5), (0.45, 0.0, 1.0))
    return {
        "white": loft(_DOME, End(1.5, 0.02, 1), End(4.0, 0.25), around=34, along=6),
        "dark": sole,
        "accent": bumper,
        "led": light,
    }
