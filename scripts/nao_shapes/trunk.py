"""What is its own mirror image: the torso, the neck and the head.

A chest that tapers to the waist, with the button, sonars, coloured flanks, and the pelvis between the hips; a wide
skull with round eyes and their LED rings, ears, two cameras, and the touch strip on top.
"""

from __future__ import annotations

import math

from manifold3d import Manifold

from nao_shapes.loft import End, Section, loft
from nao_shapes.solids import FAR, Part, Point, Y, ball, both, box, lathe, pill, place, prism, rod, slab, union

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

# Reaches to the front, back, left and right by height above the neck joint [mm].
_SKULL = (
    Section(-5.0, (44.0, 42.0, 39.0, 39.0), 2.2),
    Section(9.0, (51.0, 49.0, 49.0, 49.0), 2.3),
    Section(28.0, (57.0, 57.0, 58.0, 58.0), 2.4),
    Section(48.0, (60.0, 61.5, 62.0, 62.0), 2.4),
    Section(70.0, (60.0, 62.5, 62.5, 62.5), 2.4),
    Section(113.5, (58.0, 61.0, 61.0, 61.0), 2.3),
)

_EYE: Point = (57.4, 26.0, 46.5)
_EYE_TURN = math.radians(20.0)
_EYE_LOOKS: Point = (math.cos(_EYE_TURN), math.sin(_EYE_TURN), 0.0)
_EAR: Point = (3.8, 56.0, 52.6)
_FOREHEAD: Point = (59.6, 0.0, 65.0)
_MOUTH: Point = (54.2, 0.0, 17.2)
_FOREHEAD_DOWN, _MOUTH_DOWN = 0.02, 0.45


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


def neck() -> Part:
    """The dark column that carries the head and turns in the collar."""
    column = [(0.0, -34.0), (17.0, -34.0), (17.0, -20.0), (14.5, -12.0), (14.5, 0.0), (0.0, 0.0)]
    return {"dark": lathe(column) + ball(19.0)}


def head() -> Part:
    """Everything that nods, in the frame of HeadPitch."""
    socket = place(lathe([(0, -9.0), (17.6, -9.0), (18.4, 4.0), (0, 4.0)], 28), _EYE, _EYE_LOOKS)
    ear_well = place(lathe([(0, -2.0), (25.4, -2.0), (25.4, 12.0), (0, 12.0)], 28), _EAR, Y)
    touch = _skull(0.8) ^ box((-34.0, -8.5, 80.0), (38.0, 8.5, FAR))
    touch -= union(slab((1.0, 0.0, 0.0), x - 0.8, x + 0.8) for x in (-10.5, 15.0))
    seam = _skull(0.2) ^ slab((1.0, 0.0, 0.10), -3.0, -1.8)
    cameras = (_FOREHEAD, _FOREHEAD_DOWN), (_MOUTH, _MOUTH_DOWN)
    return {
        "white": _skull(0.0) - both(socket) - both(ear_well),
        "dark": union([both(_eye_bed()), both(_ear_grille()), touch, *(_bezel(*camera) for camera in cameras)]),
        "black": union([both(_pupil()), *(_lens(*camera) for camera in cameras)]),
        "led": both(_eye_leds()),
        "grey": both(_ear_disc()) + (seam - both(ear_well)),
        "accent": both(_ear_ring()),
    }


def _skull(grow: float) -> Manifold:
    return loft(_SKULL, End(9.0, 0.5, 3), End(56.0, 1.0, 8), grow=grow, around=48, along=5)


def _eye(radii: tuple[float, ...], lift: float, depth: float, segments: int) -> Manifold:
    """A ring, or a disc from radius 0, on the curve of the face."""
    front = [(radius, lift - radius**2 / 110.0) for radius in radii]
    return place(lathe([*front, (radii[-1], depth), (radii[0], depth)], segments), _EYE, _EYE_LOOKS)


def _eye_bed() -> Manifold:
    return _eye((0.0, 16.9), -0.6, -8.0, 28)


def _eye_leds() -> Manifold:
    """Eight segments of a ring."""
    gaps = union(box((0.0, -0.5, -30.0), (FAR, 0.5, 30.0)).rotate((0.0, 0.0, 22.5 + 45.0 * i)) for i in range(8))
    return _eye((9.2, 15.2), 0.4, -4.5, 32) - place(gaps, _EYE, _EYE_LOOKS)


def _pupil() -> Manifold:
    return _eye((0.0, 4.5, 8.0), 0.6, -4.0, 20)


def _ear_ring() -> Manifold:
    profile = [(18.8, 0.0), (25.0, 0.0), (25.0, 5.0), (23.6, 7.4), (20.0, 8.6), (18.8, 8.2)]
    return place(lathe(profile, 28), _EAR, Y)


def _ear_disc() -> Manifold:
    return place(lathe([(0, 0.0), (18.3, 0.0), (18.3, 7.2), (16.8, 8.0), (10.6, 8.6), (0, 8.6)], 28), _EAR, Y)


def _ear_grille() -> Manifold:
    return place(lathe([(0, 4.0), (9.8, 4.0), (9.8, 9.0), (0, 9.8)]), _EAR, Y)


def _bezel(at: Point, down: float) -> Manifold:
    return place(lathe(pill(6.4, 6.0, 0.0, 1.2)).translate((0, 0, -5.0)), at, _looking(down))


def _lens(at: Point, down: float) -> Manifold:
    return place(lathe(pill(4.0, 4.0, 0.0, 1.0), 16).translate((0, 0, -2.2)), at, _looking(down))


def _looking(down: float) -> Point:
    return math.cos(down), 0.0, -math.sin(down)
