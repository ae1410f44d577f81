"""Shoulder, upper arm and forearm of the left side: a cap around the shoulder, a sleeve that widens to the wrist."""

from __future__ import annotations

from nao_shapes.loft import End, Section, loft
from nao_shapes.palette import Part
from nao_shapes.solids import FAR, X, ball, rod, slab

# Radius of the upper arm about the shoulder.
_CAP = 34.5


def shoulder() -> Part:
    """What LShoulderPitch turns: the axle out of the trunk."""
    return {"dark": rod((0.0, -42.0, 0.0), (0.0, -12.0, 0.0), 21.0, 0.0, 24)}


def shoulder_pad() -> Part:
    """The coloured cap on the shoulder, fixed to the upper arm."""
    outside = slab((-0.35, 1.0, 0.30), 10.0, FAR) ^ slab(X, -FAR, 9.0)
    return {"accent": ball(_CAP + 1.0, segments=28) ^ outside}


def upper_arm(length: float, offset: float) -> Part:
    """What LShoulderRoll turns, elbow at (length, offset): round about the shoulder, so that no motion opens a gap."""
    sections = [
        Section(-_CAP, (_CAP, _CAP, _CAP, _CAP), 2.0),
        Section(0.0, (_CAP, _CAP, _CAP, _CAP), 2.0),
        Section(11.0, (33.0, 32.0, 32.6, 32.6), 2.05),
        Section(30.0, (32.0, 28.5, 31.0, 31.0), 2.2),
        Section(0.65 * length, (28.0 + 0.6 * offset, 26.5 - 0.45 * offset, 27.5, 27.5)),
        Section(length - 15.0, (22.0 + offset, 22.0 - offset, 23.0, 23.0)),
    ]
    return {"white": loft(sections, End(_CAP, 1.0, 7), End(8.0, 0.35), axis="x", along=6)}


def elbow() -> Part:
    """What LElbowYaw turns: a tube in the sleeve and the ball of the elbow."""
    return {"dark": rod((-30.0, 0.0, 0.0), (0.0, 0.0, 0.0), 18.5, 0.0) + ball(21.5)}


def hinge() -> Part:
    """The pin of the elbow, fixed to the forearm."""
    return {"dark": rod((0.0, 0.0, -24.0), (0.0, 0.0, 24.0), 13.5, 1.5)}


def forearm(length: float) -> Part:
    """What LElbowRoll turns, wrist at length."""
    sections = [
        Section(7.0, (21.0, 20.0, 22.0, 22.0)),
        Section(0.45 * length, (30.0, 27.0, 30.0, 29.0)),
        Section(0.85 * length, (35.0, 32.0, 35.0, 33.5)),
        Section(length + 12.0, (33.5, 31.0, 34.0, 32.5)),
    ]
    shell = loft(sections, End(12.0, 0.6), End(7.0, 0.25), axis="x", around=30, along=3)
    return {"white": shell - rod((length + 4.0, 0.0, 0.0), (length + 40.0, 0.0, 0.0), 25.5, 0.0, 24)}
