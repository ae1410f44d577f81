"""Torso: a chest that tapers to the waist, the button, sonars, coloured flanks, and the pelvis between the hips."""

from __future__ import annotations

from manifold3d import Manifold

from nao_shapes.loft import End, Section, loft
from nao_shapes.palette import Part
from nao_shapes.solids import FAR, Point, ball, both, box, lathe, pill, place, prism, rod, slab, union

# Reaches to the front, back, left and right by height above the torso's origin [mm].
_TRUNK = (
    Section(-68.0, (30.0, 46.0, 38.0, 38.0), 2.4),
    Section(-45.0, (36.0, 56.0, 44.0, 44.0), 2.5),
    Section(-10.0, (44.0, 65.0, 50.5, 50.5), 2.6),
    Section(25.0, (50.5, 69.0, 57.0, 57.0), 2.7),
    Section(55.0, (52.5, 68.0, 62.0, 62.0), 2.8),
    Section(88.0, (49.0, 62.0, 64.0, 64.0), 2.7),
    Section(113.0, (42.0, 52.0, 60.0, 60.0), 2.5),
)
_TAIL = (
    Section(-101.0, (3.0, 50.0, 28.0, 28.0), 2.3),
    Section(-70.0, (5.0, 57.0, 31.0, 31.0), 2.3),
    Section(-30.0, (0.0, 48.0, 27.0, 27.0), 2.3),
)
_BUTTON: Point = (52.2, 0.0, 55.0)
# Where the battery's lid lies, on the back.
_BATTERY = box((-FAR, -25.0, -22.0), (-40.0, 25.0, 60.0), 9.0)


def torso() -> Part:
    """Everything fixed to the trunk."""
    collar = lathe([(0, 104.0), (20.0, 104.0), (26.0, 130.0), (0, 130.0)], 28)
    tail = loft(_TAIL, End(22.0, 0.85, 4), End(10.0, 0.5, 1), around=28, along=2)
    socket = rod((0.0, 54.0, 100.0), (0.0, 63.0, 100.0), 25.5, 4.0, 28)
    shoulder = Manifold.batch_hull([socket, ball(24.0, (-3.0, 30.0, 82.0), 28)])
    seam = _trunk(0.2) ^ slab((0.30, 0.0, 1.0), -16.0, -14.8)
    rim = lathe([(8.6, -2.0), (12.0, -2.0), (12.0, 1.6), (11.0, 2.6), (8.6, 2.6)], 28)
    glow = lathe(pill(8.3, 5.0, 0.0, 2.0), 24).translate((0.0, 0.0, -2.0))
    dark = [
        both(rod((0.0, 46.0, -81.0), (0.0, 24.0, -59.0), 23.0, 0.0)),
        lathe([(13.0, 100.0), (22.5, 100.0), (22.5, 108.5), (20.5, 110.0), (13.0, 110.0)], 24),
        both(_sonar((50.3, 22.5, 75.0))),
        both(_sonar((49.8, 31.5, 56.0))),
    ]
    return {
        "white": union([_trunk(0.0) - collar, tail, both(shoulder)]),
        "accent": _trunk(0.9) ^ both(_flank()),
        "dark": union(dark),
        "grey": place(rim, _BUTTON, (1.0, 0.0, 0.03)) + seam + (_trunk(0.8) ^ _BATTERY),
        "led": place(glow, _BUTTON, (1.0, 0.0, 0.03)),
    }


def _trunk(grow: float) -> Manifold:
    return loft(_TRUNK, End(18.0, 0.75, 3), End(26.0, 0.72, 4), grow=grow, around=40, along=5)


def _flank() -> Manifold:
    """Where the coloured inserts lie: from the armpit up over the collarbone."""
    outline = [(60.0, 99.0), (60.0, 76.0), (20.0, 86.0), (-26.0, 86.0), (-26.0, 130.0), (20.0, 130.0)]
    return prism(outline, 28.0, FAR, 4.0)


def _sonar(at: Point) -> Manifold:
    return place(lathe(pill(7.0, 6.0, 0.0, 1.0)).translate((0, 0, -4.0)), at, (1.0, 0.28, 0.1))
