"""The torso: a chest that tapers to a waist, the cover of the hips under it, and the battery on the back."""

from __future__ import annotations

from manifold3d import Manifold

from nao_shapes.loft import End, Section, loft
from nao_shapes.solids import FAR, Part, Point, ball, both, box, lathe, place, prism, rod, union

# Reaches to the front, back, left and right by height above the torso's origin [mm].
_CHEST = (
    Section(-52.0, (33.0, 50.0, 43.0, 43.0), 3.0),
    Section(-32.0, (40.0, 57.0, 47.5, 47.5), 3.1),
    Section(0.0, (46.5, 62.5, 54.0, 54.0), 3.1),
    Section(30.0, (51.0, 65.0, 60.0, 60.0), 3.0),
    Section(58.0, (53.0, 64.0, 63.5, 63.5), 2.9),
    Section(88.0, (49.5, 59.5, 63.5, 63.5), 2.7),
    Section(114.0, (42.0, 50.0, 57.0, 57.0), 2.5),
)
_WAIST = (
    Section(-63.0, (28.0, 44.0, 35.0, 35.0), 2.6),
    Section(-46.0, (32.0, 49.0, 40.0, 40.0), 2.8),
)
_PELVIS = (
    Section(-106.0, (6.0, 40.0, 24.0, 24.0), 2.4),
    Section(-92.0, (18.0, 49.0, 28.0, 28.0), 2.4),
    Section(-76.0, (29.0, 51.0, 33.0, 33.0), 2.4),
    Section(-57.0, (33.0, 49.5, 36.0, 36.0), 2.4),
)
# The plate on chest and belly from the front: half of its width, and the height.
_SHIELD = [(31.5, 150.0), (31.5, 92.0), (41.5, 62.0), (31.0, -36.0)]
_BUTTON: Point = (52.6, 0.0, 52.0)
# Outlines from behind, y and z: the hump of the battery, its lid, and the slot of the thumb that opens it.
_HUMP = box((-FAR, -33.0, -34.0), (-46.0, 33.0, 52.0), 11.0, 4)
_LID = box((-FAR, -25.0, -27.0), (-50.0, 25.0, 30.0), 7.0, 3)
_SLOT = box((-FAR, -9.0, 17.0), (-54.0, 9.0, 22.0), 2.4)
_SPEAKER = [box((-FAR, -22.0, z), (-50.0, 22.0, z + 2.2), 1.0, 1) for z in (64.0, 70.0, 76.0)]


def torso() -> Part:
    """Everything fixed to the trunk."""
    collar = lathe([(0, 102.0), (21.5, 102.0), (27.5, 130.0), (0, 130.0)], 48)
    rim = lathe([(8.8, -3.0), (12.4, -3.0), (12.4, 1.4), (11.4, 2.4), (8.8, 2.0)], 30)
    glow = lathe([(0.0, -3.0), (8.5, -3.0), (8.5, 1.4), (7.2, 2.2), (4.0, 2.7), (0.0, 2.9)], 28)
    dark = [
        both(rod((0.0, 46.0, -81.0), (0.0, 24.0, -59.0), 23.0, 0.0, 28)),
        lathe([(13.0, 98.0), (23.0, 98.0), (22.0, 109.0), (13.0, 109.0)], 28),
        loft(_WAIST, End(3.0, 0.1, 1), End(3.0, 0.1, 1), around=32, along=0),
        both(_sonar((50.9, 23.0, 74.0))),
        both(_sonar((50.6, 32.0, 53.0))),
        _behind(3.7, _SLOT),
        *(_behind(0.3, slit) for slit in _SPEAKER),
    ]
    lid = _behind(3.4, _LID)
    groove = _shield(0.0) - _shield(1.0)
    trunk = (_chest(0.0) - (groove - _chest(-1.0)) - collar) + both(_shoulder(0.0))
    return {
        "white": union([trunk - both(_flank(2.0)), _pelvis(), _behind(2.8, _HUMP)]),
        "accent": (_chest(0.9) + both(_shoulder(0.9))) ^ both(_flank()),
        "dark": union(dark),
        "grey": place(rim, _BUTTON, (1.0, 0.0, 0.02)) + lid + (((_chest(-0.25) - _chest(-1.2)) ^ groove) - collar),
        "led": place(glow, _BUTTON, (1.0, 0.0, 0.02)),
    }


def _chest(grow: float) -> Manifold:
    return loft(_CHEST, End(12.0, 0.35, 3), End(26.0, 0.72, 5), grow=grow, around=52, along=8)


def _shield(inset: float) -> Manifold:
    """Return the solid behind the outline of the plate."""
    left = [(y - inset, z + (inset if z < 0.0 else 0.0)) for y, z in _SHIELD]
    outline = [*left, *((-y, z) for y, z in reversed(left))]
    # Drawn in the x-z plane and turned to the front.
    return prism(outline, 10.0, FAR, 12.0 - inset).rotate((0.0, 0.0, -90.0))


def _shoulder(grow: float) -> Manifold:
    """Return the solid from the chest to the socket of an arm."""
    socket = rod((0.0, 40.0, 100.0), (0.0, 64.0 + grow, 100.0), 27.0 + grow, 7.0, 52)
    return Manifold.batch_hull([socket, ball(27.0 + grow, (-4.0, 30.0, 82.0), 36)])


def _pelvis() -> Manifold:
    return loft(_PELVIS, End(13.0, 0.6, 3), End(6.0, 0.2, 1), around=32, along=2)


def _behind(grow: float, outline: Manifold) -> Manifold:
    """A plate on the back."""
    return _chest(grow) ^ outline


def _flank(inset: float = 0.0) -> Manifold:
    """Return the region of the coloured inserts, from the armpit up over the collarbone."""
    low = [(60.0, 74.0 + inset), (22.0, 84.0 + inset), (-FAR, 86.0 + inset)]
    outline = [(60.0, 98.0), *low, (-FAR, 130.0), (22.0, 130.0)]
    # No sharp corner runs out over the shoulder.
    return prism(outline, 20.0, FAR, 6.0) ^ box((inset - 28.0, inset + 29.0, -FAR), (FAR, FAR, FAR), 14.0, 4)


def _sonar(at: Point) -> Manifold:
    ring = lathe([(0.0, -5.0), (7.4, -5.0), (7.4, 1.2), (6.2, 2.0), (5.0, 1.0), (0.0, 1.0)], 20)
    return place(ring, at, (1.0, 0.28, 0.06))
