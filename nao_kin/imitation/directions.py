"""The directions of a person's limbs in the torso, from the person's points, and the same in a mirror.

Directions are in the person's torso frame: x ahead, y left, z up. The upper arm is the line from shoulder to elbow, the
forearm that from elbow to wrist.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, cross, dot, norm
from nao_kin.imitation.layouts import SIDES

DIRECTIONS = (*(side + part for side in SIDES for part in ("upper_arm", "forearm", "hand")), "gaze")


@dataclass(frozen=True, eq=False)
class Directions:
    """The directions of a person's limbs in the torso frame, for n frames; NaN where unknown.

    Attributes:
        torso: R_world_torso, shape (n, 3, 3): z from the hips to the shoulders, y to the left, x ahead.
        upper_arms: from shoulder to elbow, left and right, shape (n, 2, 3); made unit vectors, as the others.
        forearms: from elbow to wrist, shape (n, 2, 3).
        hands: R_torso_hand, x from the wrist to the knuckles, z out of the back, shape (n, 2, 3, 3).
        gaze: ahead of the face, shape (n, 3).
        notes: what was substituted for unknown points.
    """

    torso: Floats
    upper_arms: Floats
    forearms: Floats
    hands: Floats
    gaze: Floats
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("upper_arms", "forearms", "gaze"):
            object.__setattr__(self, name, _unit(getattr(self, name)))

    @classmethod
    def of(cls, points: Mapping[str, Floats], orientations: Mapping[str, Floats] | None = None) -> Directions:
        """Return the directions for points (n, 3) and orientations (n, 3, 3) of a `Skeleton`, by their names."""
        n = len(points["left_shoulder"])
        turned, gaps, no_part = orientations or {}, np.full((n, 3), np.nan), np.full((n, 3, 3), np.nan)

        def point(name: str) -> Floats:
            return points.get(name, gaps)

        def lines(start: str, end: str) -> Floats:
            return np.stack([point(side + end) - point(side + start) for side in SIDES], axis=1)

        torso, notes = _torso(point)
        hands = np.stack([turned.get(side + "hand", no_part) for side in SIDES], axis=1)
        eyes, ears = ((point(f"left_{part}") + point(f"right_{part}")) / 2.0 for part in ("eye", "ear"))
        nose, up = point("nose"), _unit(point("head") - point("neck"))
        # The line from the ears to the eyes rises as much as that to the nose falls.
        ahead = _known_first((eyes + nose) / 2.0, nose, eyes) - ears
        beside = nose - point("neck")
        ahead = _known_first(turned.get("head", no_part)[..., 0], ahead, beside - dot(beside, up)[:, None] * up)
        return cls(
            torso=torso,
            upper_arms=lines("shoulder", "elbow") @ torso,
            forearms=lines("elbow", "wrist") @ torso,
            hands=np.swapaxes(torso, -1, -2)[:, None] @ hands,
            gaze=(ahead[:, None] @ torso)[:, 0],
            notes=notes,
        )

    def only(self, *, arms: bool, head: bool) -> Directions:
        """Return the directions with those of arms or head unknown."""
        parts = ("upper_arms", "forearms", "hands") * (not arms) + ("gaze",) * (not head)
        if not parts:
            return self
        return replace(self, **{name: np.full_like(getattr(self, name), np.nan) for name in parts})


def mirrored(
    points: Mapping[str, Floats], orientations: Mapping[str, Floats]
) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Return points and orientations in a mirror: those of left and right exchanged, and y reversed."""
    flip = np.array([1.0, -1.0, 1.0])

    def other(name: str) -> str:
        side = next((side for side in SIDES if name.startswith(side)), "")
        return SIDES[1 - SIDES.index(side)] + name.removeprefix(side) if side else name

    turned = {other(name): R * flip[:, None] * flip for name, R in orientations.items()}
    return {other(name): p * flip for name, p in points.items()}, turned


def _unit(v: Floats) -> Floats:
    """Return unit vectors; NaN for zero."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return v / norm(v)[..., None]


def _unknown(v: Floats) -> NDArray[np.bool_]:
    """Return which vectors are unknown, shape (n,)."""
    return np.asarray(np.isnan(v).any(axis=-1))


def _known_first(*choices: Floats) -> Floats:
    """Return the first known vector of several, in each frame."""
    found = choices[0]
    for other in choices[1:]:
        unknown = _unknown(found)
        if not unknown.any():
            break
        found = np.where(unknown[:, None], other, found)
    return found


def _torso(point: Callable[[str], Floats]) -> tuple[Floats, tuple[str, ...]]:
    """Return R_world_torso, and notes on points that were substituted.

    A missing shoulder or hip is placed at the median distance from the other one, along the line of the other pair;
    with no hip at all, the trunk is vertical.
    """
    pairs = {part: (point(f"left_{part}"), point(f"right_{part}")) for part in ("shoulder", "hip")}
    leftwards = _unit(_known_first(*(left - right for left, right in pairs.values())))
    middles, notes = [], []
    for part, (left, right) in pairs.items():
        middle = (left + right) / 2.0
        if part == "hip":
            middle = _known_first(middle, point("pelvis"))
        lacking = _unknown(middle)
        if lacking.any():
            widths = norm(left - right)
            half = (np.nanmedian(widths) / 2.0 if np.isfinite(widths).any() else 0.0) * leftwards
            middle = _known_first(middle, left - half, right + half)
            count = np.count_nonzero(lacking & ~_unknown(middle))
            if count:
                notes.append(f"{count} frames lack a {part}, which is placed beside the other one")
        middles.append(middle)
    trunk = middles[0] - middles[1]
    lost = _unknown(trunk) & ~_unknown(leftwards)
    if lost.any():
        notes.append(f"{np.count_nonzero(lost)} frames lack both hips: their trunk is taken as vertical")
    up = _unit(np.where(lost[:, None], (0.0, 0.0, 1.0), trunk))
    ahead = _unit(cross(leftwards, up))
    return np.stack([ahead, cross(up, ahead), up], axis=-1), tuple(notes)
