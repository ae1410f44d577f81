"""Where joints may be: boxes, and plane regions where one joint's range depends on another's value."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin.ik.compiling import copied, in_lists, kept, run_rows
from nao_kin.ik.descent import Region, project
from nao_kin.robot import LIMIT_TOLERANCE, RobotModel
from nao_kin.robot.semantics import CoupledLimit

# Where the joint that a table depends on has no limits, its region ends so far beyond the table [rad].
_FAR = 100.0
# Fewer rows are projected as Python, if nothing has been compiled yet.
_FEW = 16


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

    def range(self, of: Floats) -> tuple[Floats, Floats]:
        """Smallest and largest value of `joint` at values of `of`, any shape."""
        return np.interp(of, self.at, self.lower), np.interp(of, self.at, self.upper)


@dataclass(frozen=True, eq=False)
class Line:
    """A segment of a coupled limit, as a line joint = start + slope (of − begins).

    Attributes:
        of: the joint that the limit depends on, by its place in `RobotModel.joint_names`.
        joint: the joint that it limits.
        sign: 1 for a lower bound, −1 for an upper one.
        begins: where the segment begins, a value of `of`.
        ends: where it ends.
        start: the limit where it begins.
        slope: of the segment.
        region: what it belongs to.
    """

    of: int
    joint: int
    sign: float
    begins: float
    ends: float
    start: float
    slope: float
    region: PlaneRegion

    def at(self, of: Floats) -> Floats:
        """The line at values of `of`."""
        return np.asarray(self.start + self.slope * (of - self.begins))

    def bound(self, of: Floats) -> Floats:
        """The limit itself at values of `of`."""
        return self.region.range(of)[0 if self.sign > 0.0 else 1]


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

    def project(self, values: Floats) -> Floats:
        """The nearest values inside the limits, shape (n, joints); joints that do not move stay as they are."""
        rows, still = np.ascontiguousarray(values[:, self.moving]), self.still_values(values)
        found: Floats = np.empty_like(rows)

        def in_python(part: slice) -> None:
            numbers = in_lists(self.numbers)
            for row, its_still, its_found in zip(rows[part].tolist(), still[part].tolist(), found[part], strict=True):
                project(numbers, row, its_still, its_found)

        def solve(function: Callable[..., object], part: slice) -> None:
            function(copied(self.numbers), rows[part], still[part], found[part])

        if len(rows) < _FEW and not _projections.in_memory:
            in_python(slice(0, len(rows)))
        else:
            run_rows(_projections, solve, len(rows), 1, uncompiled=in_python)
        inside: Floats = np.array(values, dtype=np.float64)
        inside[:, self.moving] = found
        return inside

    @functools.cached_property
    def numbers(self) -> Region:
        """The same for scalar code."""
        place = {int(index): k for k, index in enumerate(self.moving)}
        tables: list[int] = []
        regions = [region for region, _, _ in self._tables]
        ends = list(itertools.accumulate((len(region.at) for region in regions), initial=0))
        for (_, of, joint), first, last in zip(self._tables, ends, ends[1:], strict=False):
            tables += [place.get(of, -1), place.get(joint, -1), first, last]
        winding = np.zeros(len(self.moving))
        winding[[place[int(index)] for index in self.winding]] = 1.0
        at, low, high = (
            np.concatenate([np.zeros(0), *(getattr(region, name) for region in regions)])
            for name in ("at", "lower", "upper")
        )
        lower, upper = (np.array(bound[self.moving], dtype=np.float64) for bound in (self.lower, self.upper))
        whole = np.array(tables, dtype=np.int64)
        return Region(lower, upper, winding, whole, at, low, high, bool(self._shared))

    def lines(self) -> list[Line]:
        """The segments of all coupled limits of joints that move."""
        found = []
        for region, of, joint in self._tables:
            for i in range(len(region.at) - 1):
                begins, ends = float(region.at[i]), float(region.at[i + 1])
                for sign, bound in ((1.0, region.lower), (-1.0, region.upper)):
                    slope = float(bound[i + 1] - bound[i]) / (ends - begins)
                    found.append(Line(of, joint, sign, begins, ends, float(bound[i]), slope, region))
        return found

    def still_values(self, values: Floats) -> Floats:
        """For each table the value of its joint that does not move, shape (n, t), from those of all, (n, joints)."""
        columns = [joint if self._is_moving[of] else of for _, of, joint in self._tables]
        return np.ascontiguousarray(values[:, columns])

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


def region_type() -> Any:
    """The type of a `Region` when compiled."""
    from numba import types

    row, whole = types.float64[::1], types.int64[::1]
    return types.NamedTuple((row, row, row, whole, row, row, row, types.boolean), Region)


def _arguments() -> tuple[Any, ...]:
    from numba import types

    rows = types.float64[:, ::1]
    return region_type(), rows, rows, rows


@kept("projections onto limits", _arguments)
def _projections(region: Region, values: Floats, still: Floats, inside: Floats) -> None:
    for i in range(values.shape[0]):
        project(region, values[i], still[i], inside[i])
