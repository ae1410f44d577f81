"""The left foot: a low dome on the sole, bumpers around the toes."""

from __future__ import annotations

from nao_shapes.loft import End, Section, loft
from nao_shapes.palette import Part
from nao_shapes.solids import FAR, box, lathe, pill, place

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


def foot() -> Part:
    """What LAnkleRoll turns."""
    sole = loft(_SOLE, End(1.0, 0.01, 1), End(1.0, 0.01, 1), around=34, along=0)
    toes = box((62.0, 2.5, -FAR), (FAR, FAR, FAR)) + box((62.0, -FAR, -FAR), (FAR, 0.5, FAR))
    bumper = loft(_BUMPER, End(2.5, 0.02, 2), End(2.5, 0.02, 2), around=34, along=1) ^ toes
    light = place(lathe(pill(4.6, 4.0, 0.0, 1.2), 16).translate((0, 0, -3)), (47.0, 3.0, -17.5), (0.45, 0.0, 1.0))
    return {
        "white": loft(_DOME, End(1.5, 0.02, 1), End(4.0, 0.25), around=34, along=6),
        "dark": sole,
        "accent": bumper,
        "led": light,
    }
