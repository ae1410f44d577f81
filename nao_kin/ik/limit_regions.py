"""Where joints may be: boxes, and plane regions where one joint's range depends on another's value."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.robot import LIMIT_TOLERANCE, RobotModel
from nao_kin.semantics import CoupledLimit

# Where the joint that a table depends on has no limits, its region ends so far beyond the table [rad].
_FAR = 100.0
# Tables that share a joint are obeyed in turn, so often at most.
_MOST_TURNS = 20
# Directions are probed by a step of this length [rad or m]: far above rounding, far below the bends of a table.
_PROBE = 1e-6


class PlaneRegion:
    """The points (of, joint) that a coupled limit and the boxes of its two joints allow.

    The region lies between two polylines over the range of `of`; it need not be convex.

    Attributes:
        at: values of `of` where a bound bends, both ends of its range included, shape (k,).
        lower: smallest value of `joint` there, shape (k,).
        upper: largest value there, shape (k,).
    """

    def __init__(self, table: CoupledLimit, of_box: tuple[float, float], joint_box: tuple[float, float]) -> None:
        first, last = max(of_box[0], table.at[0] - _FAR), min(of_box[1], table.at[-1] + _FAR)
        at = {first, last, *(value for value in table.at if first < value < last)}
        for bound in (table.lower, table.upper):
            for end in joint_box:
                at |= {value for value in _crossings(table.at, bound, end) if first < value < last}
        self.at: Floats = np.array(sorted(at))
        self.lower: Floats = np.clip(np.interp(self.at, table.at, table.lower), *joint_box)
        self.upper: Floats = np.clip(np.interp(self.at, table.at, table.upper), *joint_box)
        low, high = np.column_stack([self.at, self.lower]), np.column_stack([self.at, self.upper])
        # The boundary as segments: both polylines, and the two ends of the range.
        self._starts: Floats = np.concatenate([low[:-1], high[:-1], low[[0, -1]]])
        ends: Floats = np.concatenate([low[1:], high[1:], high[[0, -1]]])
        self._along: Floats = ends - self._starts
        squares = np.einsum("si,si->s", self._along, self._along)
        self._squares: Floats = np.where(squares > 0.0, squares, 1.0)

    def range(self, of: Floats) -> tuple[Floats, Floats]:
        """Smallest and largest value of `joint` at values of `of`, any shape."""
        return np.interp(of, self.at, self.lower), np.interp(of, self.at, self.upper)

    def nearest(self, points: Floats) -> Floats:
        """The nearest points (of, joint) of the region, shape (n, 2) for (n, 2)."""
        of, joint = points[:, 0], points[:, 1]
        low, high = self.range(of)
        outside = (of < self.at[0]) | (of > self.at[-1]) | (joint < low) | (joint > high)
        result: Floats = points.copy()
        rows = np.flatnonzero(outside)
        if rows.size:
            from_start = points[rows, None, :] - self._starts
            share = np.clip(np.einsum("nsi,si->ns", from_start, self._along) / self._squares, 0.0, 1.0)
            feet = self._starts + share[..., None] * self._along
            distances = np.square(points[rows, None, :] - feet).sum(axis=-1)
            best = feet[np.arange(rows.size), np.argmin(distances, axis=-1)]
            # The foot of a perpendicular lies on the boundary to rounding; the last bit is clipped away.
            best[:, 1] = np.clip(best[:, 1], *self.range(best[:, 0]))
            result[rows] = best
        return result

    def nearest_of(self, of: Floats, joint: Floats) -> Floats:
        """The nearest values of `of` at which `joint` may have its value, shape (n,); as they are where there is none.

        Between two bends the allowed values are an interval, given by two linear inequalities.
        """
        left, width = self.at[:-1], np.diff(self.at)
        first, last = np.zeros((of.size, width.size)), np.ones((of.size, width.size))
        for bound, sign in ((self.lower, 1.0), (self.upper, -1.0)):
            # sign · (joint − bound) ≥ 0 with bound = start + share · rise.
            rise, room = sign * np.diff(bound), sign * (joint[:, None] - bound[:-1])
            with np.errstate(divide="ignore", invalid="ignore"):
                share = room / rise
            np.minimum(last, np.where(rise > 0.0, share, 1.0), out=last)
            np.maximum(first, np.where(rise < 0.0, share, 0.0), out=first)
            last[(rise == 0.0) & (room < 0.0)] = -1.0
        candidates = np.clip(of[:, None], left + first * width, left + last * width)
        gaps = np.where(first <= last, np.abs(candidates - of[:, None]), np.inf)
        best = np.argmin(gaps, axis=-1)
        rows = np.arange(of.size)
        return np.where(np.isfinite(gaps[rows, best]), candidates[rows, best], of)


@dataclass(frozen=True, eq=False)
class Violations:
    """For each of n configurations, the joint that is farthest outside its limits.

    Attributes:
        joint: its place in `RobotModel.joint_names`, shape (n,).
        value: its value, shape (n,).
        limit: the limit that is nearest to the value, shape (n,).
        outside: whether it is outside at all, shape (n,).
        coupled: whether it is inside its box, and outside the range that another joint's value leaves it, shape (n,).
    """

    joint: NDArray[np.intp]
    value: Floats
    limit: Floats
    outside: NDArray[np.bool_]
    coupled: NDArray[np.bool_]


class LimitRegion:
    """The joint values a search may take, when only some joints move and the others stay where they are.

    Values are those of all joints with a coordinate of their own, shape (n, joints), in the order of
    `RobotModel.joint_names`. Boxes are obeyed by clipping. A coupled limit is obeyed by the nearest point of its plane
    region where both of its joints move, and along a line of that plane where one of them does.

    Without limits, a joint that others follow still keeps within a turn of zero: whole turns of it are no whole turns
    of the followers, and cannot be taken back.

    Attributes:
        moving: places of the joints that move, shape (m,).
        enforced: whether limits hold.
        winding: places of those that turn without limits, which are the same after a whole turn.
    """

    def __init__(self, robot: RobotModel, moving: NDArray[np.intp], *, enforced: bool = True) -> None:
        self.moving, self.enforced = moving, enforced
        turning = np.array([unit == "rad" for unit in robot.joint_units], dtype=np.bool_)
        drivers = {mimic.joint for mimic in robot.mimics.values()}
        followed = np.array([name in drivers for name in robot.joint_names], dtype=np.bool_)
        if enforced:
            self.lower, self.upper = robot.lower, robot.upper
        else:
            self.upper = np.where(turning & followed, 2.0 * np.pi, np.inf)
            self.lower = -self.upper
        unlimited = np.isinf(self.lower) & np.isinf(self.upper)
        self.winding = moving[(turning & unlimited & ~followed)[moving]]
        self._is_moving = np.zeros(len(robot.joint_names), dtype=np.bool_)
        self._is_moving[moving] = True
        column = {name: index for index, name in enumerate(robot.joint_names)}
        self._tables: list[tuple[PlaneRegion, int, int]] = []
        for table in robot.coupled_limits if enforced else ():
            of, joint = column[table.of], column[table.joint]
            if self._is_moving[of] or self._is_moving[joint]:
                boxes = [(float(robot.lower[i]), float(robot.upper[i])) for i in (of, joint)]
                self._tables.append((_plane_region(table, boxes[0], boxes[1]), of, joint))
        coupled = [index for _, of, joint in self._tables for index in (of, joint)]
        self._shared = len(set(coupled)) < len(coupled)
        place = {int(index): k for k, index in enumerate(moving)}
        # Tables of which both joints move, and the places of these among the joints that move.
        self._planes = [row for row in self._tables if self._is_moving[row[1]] and self._is_moving[row[2]]]
        self._lines = [row for row in self._tables if row not in self._planes]
        self._pairs = [(place[of], place[joint]) for _, of, joint in self._planes]

    def project(self, values: Floats) -> Floats:
        """The nearest values inside the limits, shape (n, joints); joints that do not move stay as they are."""
        inside: Floats = values.copy()
        inside[:, self.moving] = np.clip(values[:, self.moving], self.lower[self.moving], self.upper[self.moving])
        # What a plane's nearest point is asked for are the values as given: clipping them first would move the point.
        for region, of, joint in self._planes:
            inside[:, [of, joint]] = region.nearest(values[:, [of, joint]])
        for region, of, joint in self._lines:
            self._obey(region, of, joint, inside)
        for _ in range(_MOST_TURNS if self._shared else 0):
            before = inside.copy()
            for region, of, joint in self._tables:
                self._obey(region, of, joint, inside)
            if np.array_equal(before, inside):
                break
        return inside

    def tangents(self, values: Floats, directions: Floats) -> Floats:
        """Along which directions a step may go that wants to go along `directions`.

        Args:
            values: joint values inside the limits, shape (n, joints).
            directions: of the moving joints, shape (n, m).

        Returns:
            Symmetric projectors, shape (n, m, m): identity inside the region, nothing of a joint that is held at its
            limit, and of two joints at the edge of their plane region only the direction along that edge.
        """
        count, width = directions.shape
        probes = np.sign(directions)
        for pair in self._pairs:
            two = directions[:, pair]
            length = np.linalg.norm(two, axis=-1, keepdims=True)
            probes[:, pair] = two / np.where(length > 0.0, length, 1.0)
        ahead = values.copy()
        ahead[:, self.moving] += _PROBE * probes
        inside = self.project(ahead)
        if np.array_equal(inside, ahead):
            return np.broadcast_to(np.eye(width), (count, width, width))
        gone = (inside[:, self.moving] - values[:, self.moving]) / _PROBE
        held = (probes != 0.0) & (np.abs(gone) < 0.5)
        for pair in self._pairs:
            held[:, pair] = False
        projectors = np.zeros((count, width, width))
        diagonal = np.arange(width)
        projectors[:, diagonal, diagonal] = ~held
        for of, joint in self._pairs:
            two = gone[:, (of, joint)]
            length = np.linalg.norm(two, axis=-1)
            edge = np.flatnonzero(np.abs(two - probes[:, (of, joint)]).max(axis=-1) > 1e-3)
            if edge.size:
                along = two[edge] / np.where(length[edge] > 1e-3, length[edge], np.inf)[:, None]
                for i, a in enumerate((of, joint)):
                    for k, b in enumerate((of, joint)):
                        projectors[edge, a, b] = along[:, i] * along[:, k]
        return projectors

    def unwind(self, values: Floats, near: Floats | float = 0.0) -> None:
        """Take whole turns away, in place, so that joints that turn without limits are within half a turn of `near`."""
        if self.winding.size:
            centre = near if isinstance(near, float) else near[:, self.winding]
            values[:, self.winding] -= 2.0 * np.pi * np.round((values[:, self.winding] - centre) / (2.0 * np.pi))

    def worst(self, values: Floats) -> Violations:
        """The joint that is farthest outside its limits, for each row of `values`, shape (n, joints)."""
        below, above = self.lower - values, values - self.upper
        excess = np.where(self._is_moving, np.maximum(below, above), -np.inf)
        joint = np.argmax(excess, axis=-1)
        rows = np.arange(len(values))
        worst = excess[rows, joint]
        limit = np.where(below[rows, joint] > 0.0, self.lower[joint], self.upper[joint])
        coupled = np.zeros(len(values), dtype=np.bool_)
        for region, of, column in self._tables:
            low, high = region.range(values[:, of])
            over = np.maximum(low - values[:, column], values[:, column] - high)
            # A table is to blame where no box is.
            worse = (over > LIMIT_TOLERANCE) & (worst <= LIMIT_TOLERANCE) | coupled & (over > worst)
            coupled |= worse
            joint = np.where(worse, column if self._is_moving[column] else of, joint)
            limit = np.where(worse, np.where(values[:, column] < low, low, high), limit)
            worst = np.where(worse, over, worst)
        return Violations(joint, values[rows, joint], limit, worst > LIMIT_TOLERANCE, coupled)

    def _obey(self, region: PlaneRegion, of: int, joint: int, values: Floats) -> None:
        """Take the values of the moving joints of one table to its region, in place."""
        if self._is_moving[of] and self._is_moving[joint]:
            values[:, [of, joint]] = region.nearest(values[:, [of, joint]])
        elif self._is_moving[joint]:
            values[:, joint] = np.clip(values[:, joint], *region.range(values[:, of]))
        else:
            values[:, of] = region.nearest_of(values[:, of], values[:, joint])


@functools.cache
def _plane_region(table: CoupledLimit, of_box: tuple[float, float], joint_box: tuple[float, float]) -> PlaneRegion:
    """The region of a table, made once: robots of one kind share it."""
    return PlaneRegion(table, of_box, joint_box)


def _crossings(at: tuple[float, ...], bound: tuple[float, ...], level: float) -> list[float]:
    """Where a polyline crosses a level between two of its bends."""
    found = []
    for (a, y), (b, z) in zip(zip(at, bound, strict=True), list(zip(at, bound, strict=True))[1:], strict=False):
        if (y - level) * (z - level) < 0.0:
            found.append(a + (level - y) / (z - y) * (b - a))
    return found
