"""The check that named points are those of a person, which a wrong order or numbering of points does not pass.

Bones of the left and the right side have equal lengths, that are constant in time, neighbouring bones of a limb have
similar lengths, and the head is above the pelvis. Neither axes nor units count.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from nao_kin._core.arrays import Floats, dot, norm
from nao_kin.imitation.layouts import LIMBS, SIDES

# Points with less confidence count as unknown.
CONFIDENCE = 0.5
# Lengths that are equal in a person: the two ends of each, "*" for the side.
_SAME_ON_BOTH_SIDES = (
    *((f"*{one}", f"*{two}") for limb in LIMBS for one, two in pairwise(limb)),
    ("pelvis", "*shoulder"),
    ("head", "*hip"),
)
# The mean of |log| of the ratios of such lengths is below this; by as much more where a single frame shows them. People
# with errors of 3 cm in all points reach 0.2, in a single frame 0.4; a wrong order has 0.35 or more, mostly 0.7.
_RATIOS, _RATIOS_OF_A_FRAME = 0.28, 0.25
# The median of |log| of a bone's lengths to their median is below this on the mean; with errors of 3 cm it is 0.15.
_CHANGES = 0.3
# The cosine between the trunk and the line from the pelvis to the head is above this; people reach 0.9.
_UPRIGHT = 0.5
# Fewer ratios than this show nothing.
_FEWEST = 3
# The largest |log| that counts, of points that coincide.
_MOST = 3.0


def believed(points: Mapping[str, Floats], sure: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return points (n, 3) with NaN where their confidence (n,) is too small."""
    return {
        name: np.where((sure[name] >= CONFIDENCE)[:, None], places, np.nan) if name in sure else places
        for name, places in points.items()
    }


def misfit(points: Mapping[str, Floats], sure: Mapping[str, Floats]) -> tuple[float, str]:
    """Return how much the bones between points (n, 3) in any axes and units differ from a person's, and why.

    The number is the mean of |log| of the ratios, over sides and limbs, plus that over time; inf where nothing is
    known. The reason is empty if nothing speaks against a person.

    Args:
        points: name of `POINTS` → places; shoulders are among them.
        sure: name → confidence, shape (n,); points without an entry are certain.
    """
    known = believed(points, sure)
    lengths: dict[tuple[str, str], Floats] = {}

    def length(one: str, two: str) -> float:
        """Return the median distance between two points, NaN if it is never known or always zero."""
        if one not in known or two not in known:
            return np.nan
        found = norm(known[one] - known[two])
        found = lengths[one, two] = found[np.isfinite(found) & (found > 0.0)]
        return float(np.median(found)) if len(found) else np.nan

    sides = [[length(*(end.replace("*", side) for end in ends)) for side in SIDES] for ends in _SAME_ON_BOTH_SIDES]
    limbs = [[length(side + a, side + b) for a, b in pairwise(limb)] for side in SIDES for limb in LIMBS]
    one, other = np.array([*sides, *limbs]).T
    ratios = np.abs(np.log(one / other))
    ratios = np.minimum(ratios[np.isfinite(ratios)], _MOST)
    frames = max((len(found) for found in lengths.values()), default=0)
    if len(ratios) < _FEWEST:
        return np.inf, ""
    changes = [np.median(np.abs(np.log(found / np.median(found)))) for found in lengths.values() if len(found)]
    total = float(ratios.mean() + np.mean(changes))
    if ratios.mean() > _RATIOS + _RATIOS_OF_A_FRAME / np.sqrt(frames):
        return total, f"left and right bones, and those of a limb, differ by {np.expm1(ratios.mean()):.0%} on the mean"
    if np.mean(changes) > _CHANGES:
        return total, f"the lengths of bones change by {np.expm1(np.mean(changes)):.0%} on the mean"
    shoulders = (known["left_shoulder"] + known["right_shoulder"]) / 2.0
    pelvis = known.get("pelvis", np.full_like(shoulders, np.nan))
    trunk, up = shoulders - pelvis, known.get("head", np.full_like(shoulders, np.nan)) - pelvis
    with np.errstate(invalid="ignore", divide="ignore"):
        cosines = dot(trunk, up) / (norm(trunk) * norm(up))
    cosines = cosines[np.isfinite(cosines)]
    if len(cosines) and np.median(cosines) < _UPRIGHT:
        return total, "the head is not above the pelvis"
    return total, ""
