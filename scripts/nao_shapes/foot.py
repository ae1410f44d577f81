"""The left foot: a low dome on the sole, with a collar around the ankle and two bumpers at the toes."""

from __future__ import annotations

from nao_shapes.loft import End, Section, loft
from nao_shapes.solids import FAR, Part, box, lathe, pill, place

# Reaches to the front, back, outside and inside by height over the ankle joint [mm].
_DOME = (
    Section(-42.0, (101.0, 52.5, 48.6, 37.4), 2.5),
    Section(-36.0, (100.0, 52.0, 48.2, 37.1), 2.5),
    Section(-29.0, (89.0, 49.5, 46.3, 36.0), 2.5),
    Section(-23.0, (68.0, 45.5, 42.0, 34.3), 2.45),
    Section(-17.0, (45.0, 40.5, 36.0, 32.0), 2.35),
    Section(-11.0, (34.0, 36.5, 32.5, 30.5), 2.2),
    Section(-6.0, (30.0, 33.5, 31.0, 29.5), 2.1),
)
# Inside the rim of the dome, so that it ends in a shadow and not in an intersection.
_SOLE = (Section(-45.1, (98.5, 50.2, 46.4, 35.6), 2.5), Section(-40.0, (99.5, 51.0, 47.0, 36.0), 2.5))
_BUMPER = (
    Section(-42.0, (103.2, 54.0, 50.0, 38.8), 2.5),
    Section(-36.0, (103.3, 54.0, 49.8, 38.6), 2.5),
    Section(-29.0, (97.0, 51.5, 47.8, 37.0), 2.5),
)
_AROUND = 60


def foot() -> Part:
    """The link of LAnkleRoll."""
    sole = loft(_SOLE, End(1.0, 0.01, 1), End(1.0, 0.01, 1), around=44, along=0)
    dome = loft(_DOME, End(1.5, 0.008, 1), End(2.5, 0.1, 2), around=_AROUND, along=7)
    toes = box((60.0, 2.2, -FAR), (FAR, FAR, FAR)) + box((60.0, -FAR, -FAR), (FAR, 0.8, FAR))
    bumper = loft(_BUMPER, End(2.5, 0.03, 2), End(3.0, 0.04, 2), around=_AROUND, along=2) ^ toes
    light = place(lathe(pill(4.6, 4.0, 0.0, 1.2, 1), 20).translate((0, 0, -3)), (44.0, 3.0, -16.6), (0.30, 0.0, 1.0))
    return {"white": dome, "dark": sole, "accent": bumper, "led": light}
