"""Where to stand so that most targets are within reach."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats, as_floats
from nao_kin._common.scalars import whole_number
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.rotations import rot_z

if TYPE_CHECKING:
    from nao_kin.reach.chain_tables import Integers
    from nao_kin.reach.reach_map import ReachMap

# Places that are compared at once, 8 bytes each.
_MOST_PLACES = 30_000_000
# A place's score: the number of targets above these bits, the sum of their manipulability in them.
_BITS = 40


@dataclass(frozen=True, eq=False)
class Stance:
    """A place for the reference frame of a reach map, upright.

    Attributes:
        position: its origin in the targets' frame, shape (3,) [m].
        yaw: its heading about the vertical, in (−π, π] [rad].
        reached: which targets are within reach, shape (m,).
        manipulability: the best manipulability at each target, 0 out of reach, shape (m,).

    Examples:
        >>> reach = nk.reach.workspace(nk.load_nao(), "LArm", 1000, voxel=0.05)
        >>> stance = reach.best_stance([[0.5, 0.0, 0.1]])
        >>> stance.position.shape, bool(stance.reached.all())
        ((3,), True)
    """

    position: Floats
    yaw: float
    reached: NDArray[np.bool_]
    manipulability: Floats

    @property
    def count(self) -> int:
        """How many targets are within reach."""
        return int(self.reached.sum())

    @property
    def pose(self) -> Floats:
        """T_targets_reference: coordinates in the reference frame to those of the targets, shape (4, 4)."""
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = rot_z(self.yaw), self.position
        return T


def best_stance(reach: ReachMap, targets: ArrayLike, height: float | tuple[float, float] | None, yaws: int) -> Stance:
    """As `ReachMap.best_stance`.

    A target in voxel t, counted from the place, is within reach from place g when voxel t − g is in the map. So every
    target votes for the map, mirrored, moved to t; the votes of all targets are counted on one grid, heading by
    heading.
    """
    points = as_floats(targets, (3,), "targets")
    if points.ndim != 2 or len(points) == 0:
        raise WrongShape("targets", "(m, 3) with m ≥ 1", points.shape)
    if len(reach.count) == 0:
        raise BadArgument("the map is empty: nothing is within reach")
    headings = whole_number(yaws, "yaws", 1)
    votes = _Votes(reach, points, _heights(height))
    best, place, yaw = -1, np.zeros(3), 0.0
    for heading in np.arange(headings) * (2.0 * math.pi / headings):
        score, found = votes.best_place(rot_z(heading))
        if score > best:
            best, place, yaw = score, found, float(heading)
    yaw = yaw - 2.0 * math.pi if yaw > math.pi else yaw
    seen = (points - place) @ rot_z(yaw)
    return Stance(place, yaw, reach.reachable(seen), reach.best_at(seen))


def _heights(height: float | tuple[float, float] | None) -> tuple[float, float] | None:
    if height is None:
        return None
    array = as_floats(height, (), "height")
    if array.shape not in ((), (2,)):
        raise WrongShape("height", "() or (2,)", array.shape)
    low, high = (float(array), float(array)) if array.shape == () else (float(array[0]), float(array[1]))
    if low > high:
        raise BadArgument(f"height must be from low to high, got {low:g} and {high:g}")
    return low, high


class _Votes:
    """Counts, place by place, which targets are within reach there, and how well.

    Places are the points (g + ½) · voxel with whole numbers g, turned by the heading: targets on round numbers then
    stand in the middle of voxels, and not between two. Where the height is given, its places start at its low end.
    """

    def __init__(self, reach: ReachMap, targets: Floats, heights: tuple[float, float] | None) -> None:
        self._targets, self._voxel, self._heights = targets, reach.voxel, heights
        self._low, high = reach.indices.min(axis=0).astype(np.int64), reach.indices.max(axis=0).astype(np.int64)
        self._sides = high - self._low + 1
        # Large numbers of targets leave fewer bits for each.
        shift = max(0, int(reach.best_steps.max()).bit_length() + len(targets).bit_length() - _BITS)
        scores = np.zeros(tuple(self._sides), dtype=np.int64)
        scores[tuple((reach.indices - self._low).T)] = (1 << _BITS) + (reach.best_steps >> shift)
        self._mirrored = scores[::-1, ::-1, ::-1]

    def best_place(self, R: Floats) -> tuple[int, Floats]:
        """The score of the best place at a heading, and the place in the targets' frame."""
        origin = np.full(3, 0.5 * self._voxel)
        if self._heights is not None:
            origin[2] = self._heights[0]
        cells = np.floor((self._targets @ R - origin) / self._voxel)
        if np.abs(cells).max() >= 2**40:
            raise BadArgument("targets are too far away for voxels of this size")
        # The mirrored map, moved to a target, starts here.
        starts: Integers = cells.astype(np.int64) - (self._low + self._sides - 1)
        first, last = starts.min(axis=0), starts.max(axis=0) + self._sides
        if self._heights is not None:
            first[2], last[2] = 0, math.floor((self._heights[1] - self._heights[0]) / self._voxel + 1e-9) + 1
        if math.prod((last - first).tolist()) > _MOST_PLACES:
            raise BadArgument("targets are too far apart to compare all places between them: give fewer at a time")
        votes = np.zeros(tuple(last - first), dtype=np.int64)
        for start in starts - first:
            low, high = np.maximum(start, 0), np.minimum(start + self._sides, votes.shape)
            if (low < high).all():
                there = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
                here = tuple(slice(a, b) for a, b in zip(low - start, high - start, strict=True))
                votes[there] += self._mirrored[here]
        best = int(np.argmax(votes))
        place = np.array(np.unravel_index(best, votes.shape)) + first
        return int(votes.flat[best]), R @ (origin + place * self._voxel)
