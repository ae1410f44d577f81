"""Arm of the left side, shoulder to wrist: a cap around the shoulder, a shell that flows from the elbow to the hand."""

from __future__ import annotations

from manifold3d import Manifold

from nao_shapes.loft import End, Section, loft
from nao_shapes.solids import FAR, Part, X, ball, prism, rod, slab

# Radius of the upper arm about the shoulder, and of the ball in the elbow [mm].
_CAP, _ELBOW = 34.5, 22.5
# The region of the upper arm that the cap on the shoulder covers.
_PAD = slab((-0.62, 0.68, 0.38), 7.0, FAR)


def shoulder() -> Part:
    """The link of LShoulderPitch: the axle out of the trunk."""
    return {"dark": rod((0.0, -42.0, 0.0), (0.0, -12.0, 0.0), 22.0, 0.0, 32)}


def shoulder_pad() -> Part:
    """The coloured cap on the shoulder, fixed to the upper arm: over the top and the outside."""
    return {"accent": _upper_arm(100.0, 0.0, 1.0) ^ _PAD}


def upper_arm(length: float, offset: float) -> Part:
    """The link of LShoulderRoll, elbow at (length, offset): round about the shoulder, so that no motion opens a gap."""
    return {"white": _upper_arm(length, offset, 0.0) - _PAD}


def _upper_arm(length: float, offset: float, grow: float) -> Manifold:
    sections = [
        Section(-_CAP, (_CAP, _CAP, _CAP, _CAP), 2.0),
        Section(0.0, (_CAP, _CAP, _CAP, _CAP), 2.0),
        Section(11.0, (33.2, 32.2, 32.8, 32.8), 2.05),
        Section(30.0, (32.0, 28.5, 31.0, 31.0), 2.2),
        Section(0.65 * length, (28.0 + 0.6 * offset, 26.5 - 0.45 * offset, 28.0, 28.0)),
        Section(length - 14.0, (24.0 + offset, 24.0 - offset, 25.0, 25.0)),
    ]
    return loft(sections, End(_CAP, 1.0, 8), End(5.0, 0.14, 2), axis="x", grow=grow, around=42, along=6)


def elbow() -> Part:
    """The link of LElbowYaw: a tube in the sleeve and the ball of the elbow."""
    return {"dark": rod((-24.0, 0.0, 0.0), (0.0, 0.0, 0.0), 20.2, 0.0, 24) + ball(_ELBOW, segments=20)}


def hinge() -> Part:
    """The pin of the elbow, fixed to the forearm."""
    return {"grey": rod((0.0, 0.0, -26.2), (0.0, 0.0, 26.2), 9.5, 1.5, 24)}


def forearm(length: float) -> Part:
    """The link of LElbowRoll, wrist at length: open towards the upper arm on the side to which the elbow bends."""
    # The rim is flat and wider than the ball in it, so that the ball leaves it in a clean arc.
    bend = slab((1.0, 0.55, 0.0), -FAR, 1.0) + slab(X, -FAR, -9.0)
    inside = bend + rod((length + 5.0, 0.0, 0.0), (length + 40.0, 0.0, 0.0), 26.0, 0.0, 32)
    outline = [
        (2.0, 9.0),
        (2.0, -9.0),
        (0.45 * length, -22.0),
        (length + 30.0, -26.0),
        (length + 30.0, 26.0),
        (0.45 * length, 20.0),
    ]
    # Drawn in the x-z plane and rotated to the upper side.
    cover = _forearm(length, 0.9) ^ prism(outline, 15.0, FAR, 8.5).rotate((90.0, 0.0, 0.0))
    return {"white": _forearm(length, 0.0) - inside, "accent": cover - inside}


def _forearm(length: float, grow: float) -> Manifold:
    sections = [
        Section(-24.0, (24.0, 23.0, 24.5, 24.5), 2.2),
        Section(4.0, (26.0, 24.5, 25.5, 25.5), 2.25),
        Section(0.45 * length, (31.0, 27.5, 30.0, 29.5)),
        Section(0.85 * length, (33.5, 30.5, 33.0, 32.0)),
        Section(length + 12.0, (30.5, 28.0, 30.5, 30.0), 2.2),
    ]
    return loft(sections, End(4.0, 0.1, 1), End(4.0, 0.12, 2), axis="x", grow=grow, around=42, along=7)
