"""Joint limits: boxes, and plane regions for coupled limits."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import LIMIT_TOLERANCE, Floats
from nao_kin._kernels.cache import CachedKernel, Floats2, IntRow, Row, both_ways
from nao_kin._kernels.rows import copied, in_lists, run_rows
from nao_kin.robot import RobotModel
from nao_kin.robot.semantics import CoupledLimit

# --- The limits of a `LimitRegion` for scalar code, one configuration after the other.

# Largest number of passes over tables that share a joint.
MAX_PASSES = 20
# Length of the step that probes a direction [rad or m]: far above rounding, far below the segments of a table.
PROBE = 1e-6
# A probe that moves two joints by a smaller share than this of its length is held by a corner of their plane region.
_AT_CORNER = 1e-8
# A line of a table within this distance of the table's bound [rad] coincides with it.
_SAME = 1e-12
# Numbers of a table: the indices of joint `of` and of the joint whose range depends on it, −1 for a joint that does not
# move; the first of its rows, and the end of its rows.
TABLE = 4


class Region(NamedTuple):
    """Limits of m joints: boxes `lower`, `upper`, and `TABLE` whole numbers in `tables` for each coupled limit."""

    lower: Row
    upper: Row
    winding: Row  # 1 for a joint without limits that is the same after a whole turn
    tables: IntRow
    at: Row  # the rows of all tables: values of joint `of`
    low: Row  # bounds of the other joint inside the box
    high: Row
    shared: bool  # whether two tables share a joint


@both_ways
def project(region: Region, values: Row, fixed: Row, inside: Row) -> None:
    """Write the nearest values inside the limits; `fixed` has each table's value of its joint that does not move."""
    for j in range(len(region.lower)):
        inside[j] = min(max(values[j], region.lower[j]), region.upper[j])
    count = len(region.tables) // TABLE
    # Find the nearest point of the plane region from the given values: clipping them first would move it.
    for t in range(count):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        if of >= 0 and joint >= 0:
            inside[of], inside[joint] = nearest_point(region, t, values[of], values[joint])
    for _ in range(MAX_PASSES if region.shared else 1):
        changed = False
        for t in range(count):
            changed = obey(region, t, fixed, inside) or changed
        if not changed:
            break


@both_ways
def obey(region: Region, t: int, fixed: Row, values: Row) -> bool:
    """Move the moving joints of a table into its region; return whether that changed them."""
    of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
    before = values[of] if of >= 0 else fixed[t], values[joint] if joint >= 0 else fixed[t]
    x, y = before
    if joint < 0:
        x = nearest_of(region, t, x, y)
    elif of < 0:
        low, high = range_at(region, t, x)
        y = min(max(y, low), high)
    else:
        x, y = nearest_point(region, t, x, y)
    if of >= 0:
        values[of] = x
    if joint >= 0:
        values[joint] = y
    return bool(x != before[0] or y != before[1])


@both_ways
def range_at(region: Region, t: int, of: float) -> tuple[float, float]:
    """Return the range of the joint of a table where the other is at `of`; constant outside the table."""
    first, last = region.tables[TABLE * t + 2], region.tables[TABLE * t + 3] - 1
    at, low, high = region.at, region.low, region.high
    if of <= at[first]:
        return low[first], high[first]
    if of >= at[last]:
        return low[last], high[last]
    right = first + 1
    while at[right] < of:
        right += 1
    left = right - 1
    share = (of - at[left]) / (at[right] - at[left])
    return low[left] + share * (low[right] - low[left]), high[left] + share * (high[right] - high[left])


@both_ways
def nearest_point(region: Region, t: int, of: float, joint: float) -> tuple[float, float]:
    """Return the nearest point of a plane region: on a segment of its boundary, if the point is not inside."""
    first, last = region.tables[TABLE * t + 2], region.tables[TABLE * t + 3] - 1
    low, high = range_at(region, t, of)
    if region.at[first] <= of <= region.at[last] and low <= joint <= high:
        return of, joint
    best, x, y = math.inf, of, joint
    for side in range(2):
        bound = region.low if side == 0 else region.high
        for i in range(first, last):
            dx, dy = region.at[i + 1] - region.at[i], bound[i + 1] - bound[i]
            square = dx * dx + dy * dy
            share = ((of - region.at[i]) * dx + (joint - bound[i]) * dy) / square if square > 0.0 else 0.0
            share = min(max(share, 0.0), 1.0)
            foot_x, foot_y = region.at[i] + share * dx, bound[i] + share * dy
            away = (of - foot_x) * (of - foot_x) + (joint - foot_y) * (joint - foot_y)
            if away < best:
                best, x, y = away, foot_x, foot_y
    for side in range(2):
        i = first if side == 0 else last
        foot = min(max(joint, region.low[i]), region.high[i])
        away = (of - region.at[i]) * (of - region.at[i]) + (joint - foot) * (joint - foot)
        if away < best:
            best, x, y = away, region.at[i], foot
    # The foot of a perpendicular lies on the boundary only up to rounding: clip it.
    low, high = range_at(region, t, x)
    return x, min(max(y, low), high)


@both_ways
def nearest_corner(region: Region, t: int, of: float, joint: float) -> tuple[float, float]:
    """Return the nearest corner of a plane region."""
    best, x, y = math.inf, of, joint
    for i in range(region.tables[TABLE * t + 2], region.tables[TABLE * t + 3]):
        for side in range(2):
            corner = region.low[i] if side == 0 else region.high[i]
            away = (of - region.at[i]) * (of - region.at[i]) + (joint - corner) * (joint - corner)
            if away < best:
                best, x, y = away, region.at[i], corner
    return x, y


@both_ways
def nearest_of(region: Region, t: int, of: float, joint: float) -> float:
    """Return the value nearest to `of` at which the range includes `joint`; `of` if there is none.

    Between two rows the allowed values are an interval, given by two linear inequalities.
    """
    first, last = region.tables[TABLE * t + 2], region.tables[TABLE * t + 3] - 1
    distance, nearest = math.inf, of
    for i in range(first, last):
        start, end = 0.0, 1.0
        for side in range(2):
            # sign · (joint − bound) ≥ 0 with bound = left + share · rise.
            sign = 1.0 if side == 0 else -1.0
            left, right = (region.low[i], region.low[i + 1]) if side == 0 else (region.high[i], region.high[i + 1])
            rise, slack = sign * (right - left), sign * (joint - left)
            if rise > 0.0:
                end = min(end, slack / rise)
            elif rise < 0.0:
                start = max(start, slack / rise)
            elif slack < 0.0:
                end = -1.0
        if start <= end:
            width = region.at[i + 1] - region.at[i]
            value = min(max(of, region.at[i] + start * width), region.at[i] + end * width)
            if abs(value - of) < distance:
                distance, nearest = abs(value - of), value
    return nearest


@both_ways
def open_directions(
    region: Region, values: Row, fixed: Row, wanted: Row, ahead: Row, inside: Row, is_open: Row, along: Row
) -> bool:
    """Write the directions in which a step along `wanted` may go; return whether all are open.

    `is_open` is 0 for a joint at its limit. Two joints at the edge of their plane region may move along this edge only,
    whose direction is in `along`; (2, 0) if they are free.
    """
    count, width = len(region.tables) // TABLE, len(region.lower)
    for j in range(width):
        ahead[j] = 1.0 if wanted[j] > 0.0 else -1.0 if wanted[j] < 0.0 else 0.0
    for t in range(count):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        along[2 * t], along[2 * t + 1] = 2.0, 0.0
        if of >= 0 and joint >= 0:
            length = math.sqrt(wanted[of] * wanted[of] + wanted[joint] * wanted[joint])
            if length > 0.0:
                ahead[of], ahead[joint] = wanted[of] / length, wanted[joint] / length
    for j in range(width):
        ahead[j] = values[j] + PROBE * ahead[j]
    project(region, ahead, fixed, inside)
    all_open = True
    for j in range(width):
        free = abs(inside[j] - values[j]) >= 0.5 * PROBE or ahead[j] == values[j]
        is_open[j] = 1.0 if free else 0.0
        all_open = all_open and bool(inside[j] == ahead[j])
    if all_open:
        return True
    for t in range(count):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        if of >= 0 and joint >= 0:
            is_open[of], is_open[joint] = 1.0, 1.0
            x, y = (inside[of] - values[of]) / PROBE, (inside[joint] - values[joint]) / PROBE
            off_x, off_y = (inside[of] - ahead[of]) / PROBE, (inside[joint] - ahead[joint]) / PROBE
            if max(abs(off_x), abs(off_y)) > 1e-3:
                along[2 * t], along[2 * t + 1] = 0.0, 0.0
                length = math.sqrt(x * x + y * y)
                if length <= 1e-3 and length > _AT_CORNER:
                    # The wanted direction is almost perpendicular to the edge, so that rounding changes (x, y).
                    x, y, length = -off_y, off_x, math.sqrt(off_x * off_x + off_y * off_y)
                if length > _AT_CORNER:
                    along[2 * t], along[2 * t + 1] = x / length, y / length
    return False


@both_ways
def clipped(region: Region, values: Row) -> None:
    """Clip values that are outside by rounding, or at the rows of tables; both joints of each table must move."""
    for j in range(len(region.lower)):
        values[j] = min(max(values[j], region.lower[j]), region.upper[j])
    for t in range(len(region.tables) // TABLE):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        low, high = range_at(region, t, values[of])
        values[joint] = min(max(values[joint], low, region.lower[joint]), high, region.upper[joint])


@both_ways
def outside(region: Region, values: Row) -> float:
    """Return the sum of the excesses over the limits [rad or m]; both joints of each table must move."""
    total = 0.0
    for j in range(len(region.lower)):
        total += max(0.0, region.lower[j] - values[j], values[j] - region.upper[j])
    for t in range(len(region.tables) // TABLE):
        low, high = range_at(region, t, values[region.tables[TABLE * t]])
        value = values[region.tables[TABLE * t + 1]]
        total += max(0.0, low - value, value - high)
    return total


@both_ways
def max_rows(region: Region) -> int:
    """Return how many rows `limit_rows` writes at most."""
    return 2 * (len(region.lower) + len(region.at))


@both_ways
def limit_rows(region: Region, values: Row, fixed: Row, longest: Row, A: Floats, b: Floats, count: int) -> int:
    """Add rows A δ ≥ b that keep a step δ inside the limits and at most `longest`; return their new number.

    A joint that is outside is brought back as far as a step may go. Every segment of a table within reach of a step
    gives a row, unless its line would exclude allowed values: the region need not be convex.
    """
    first_box = count
    for j in range(len(region.lower)):
        for side in range(2):
            slack = region.lower[j] - values[j] if side == 0 else values[j] - region.upper[j]
            A[count] = 0.0
            A[count, j] = 1.0 if side == 0 else -1.0
            b[count] = min(max(slack, -longest[j]), longest[j])
            count += 1
    for t in range(len(region.tables) // TABLE):
        of, joint = region.tables[TABLE * t], region.tables[TABLE * t + 1]
        at_of = values[of] if of >= 0 else fixed[t]
        at_joint = values[joint] if joint >= 0 else fixed[t]
        reach = longest[of] if of >= 0 else 0.0
        bounds = range_at(region, t, at_of)
        for i in range(region.tables[TABLE * t + 2], region.tables[TABLE * t + 3] - 1):
            begins, ends = region.at[i], region.at[i + 1]
            if begins > at_of + reach or ends < at_of - reach:
                continue
            for side in range(2):
                sign, bound = (1.0, region.low) if side == 0 else (-1.0, region.high)
                slope = (bound[i + 1] - bound[i]) / (ends - begins)
                line = bound[i] + slope * (at_of - begins)
                if sign * (line - bounds[side]) > _SAME:
                    continue
                A[count] = 0.0
                # A row demands at most what the boxes allow.
                largest = 0.0
                if joint >= 0:
                    A[count, joint] = sign
                    largest += -b[first_box + 2 * joint + 1 - side]
                if of >= 0 and slope != 0.0:
                    A[count, of] = -sign * slope
                    largest += -abs(slope) * b[first_box + 2 * of + (1 if A[count, of] > 0.0 else 0)]
                b[count] = min(sign * (line - at_joint), largest)
                count += 1
    return count


# --- The limits of a robot, for many configurations at a time.

# If the joint that a table depends on has no limits, the region ends this far beyond the table [rad].
_FAR = 100.0
# Fewer rows than this are projected as Python if nothing is compiled yet.
_FEW = 16


class Violations(NamedTuple):
    """For each of n configurations, the joint farthest outside its limits."""

    joint: NDArray[np.intp]  # its index
    value: Floats
    limit: Floats  # the nearest limit
    outside: NDArray[np.bool_]  # whether it is outside at all
    coupled: NDArray[np.bool_]  # whether it is inside its box, and outside a coupled limit


class LimitRegion:
    """The limits of a search in which only the joints with the indices `moving`, shape (m,), move.

    Values are those of all joints of `RobotModel.joint_names`, shape (n, joints). They are clipped to boxes; a coupled
    limit is met at the nearest point of its plane region, or of a line of this plane if one of its joints moves. If
    limits are not enforced, a joint that drives mimic joints stays within a turn of zero: its whole turns are not whole
    turns of the mimic joints. `winding` has the joints that are the same after a whole turn.
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
        self._is_moving = np.isin(np.arange(len(robot.joint_names)), moving)
        self._tables: list[tuple[Floats, int, int]] = []
        for table in robot.coupled_limits if enforced else ():
            of, joint = robot.joint_names.index(table.of), robot.joint_names.index(table.joint)
            if self._is_moving[of] or self._is_moving[joint]:
                boxes = [(float(robot.lower[i]), float(robot.upper[i])) for i in (of, joint)]
                self._tables.append((_plane_region(table, boxes[0], boxes[1]), of, joint))

    def project(self, values: Floats) -> Floats:
        """Return the nearest values inside the limits, shape (n, joints); only moving joints change."""
        rows, fixed = np.ascontiguousarray(values[:, self.moving]), self.fixed_values(values)
        projected: Floats = np.empty_like(rows)

        def in_python(part: slice) -> None:
            numbers = in_lists(self.numbers)
            for row, constant, inside in zip(rows[part].tolist(), fixed[part].tolist(), projected[part], strict=True):
                project(numbers, row, constant, inside)

        def solve(function: Callable[..., object], part: slice) -> None:
            function(copied(self.numbers), rows[part], fixed[part], projected[part])

        if len(rows) < _FEW and not _projections.in_memory:
            in_python(slice(0, len(rows)))
        else:
            run_rows(_projections, solve, len(rows), 1, uncompiled=in_python)
        inside: Floats = np.array(values, dtype=np.float64)
        inside[:, self.moving] = projected
        return inside

    @functools.cached_property
    def numbers(self) -> Region:
        """The limits for scalar code."""
        place = np.full(len(self._is_moving), -1)
        place[self.moving] = np.arange(len(self.moving))
        winding = np.isin(self.moving, self.winding).astype(np.float64)
        tables = [(place[of], place[joint], bends) for bends, of, joint in self._tables]
        return region_of(self.lower[self.moving], self.upper[self.moving], winding, tables)

    def fixed_values(self, values: Floats) -> Floats:
        """Return each table's value of its joint that does not move, shape (n, t), from values (n, joints)."""
        columns = [joint if self._is_moving[of] else of for _, of, joint in self._tables]
        return np.ascontiguousarray(values[:, columns])

    def unwind(self, values: Floats, near: Floats | float = 0.0) -> None:
        """Subtract whole turns, in place, so that joints without limits are within half a turn of `near`."""
        if self.winding.size:
            centre = near if isinstance(near, float) else near[:, self.winding]
            values[:, self.winding] -= 2.0 * np.pi * np.round((values[:, self.winding] - centre) / (2.0 * np.pi))

    def worst(self, values: Floats) -> Violations:
        """Return the joint farthest outside its limits for each row of `values`, shape (n, joints)."""
        below, above = self.lower - values, values - self.upper
        excess = np.where(self._is_moving, np.maximum(below, above), -np.inf)
        joint = np.argmax(excess, axis=-1)
        rows = np.arange(len(values))
        worst = excess[rows, joint]
        limit = np.where(below[rows, joint] > 0.0, self.lower[joint], self.upper[joint])
        coupled = np.zeros(len(values), dtype=np.bool_)
        for region, of, column in self._tables:
            low, high = (np.interp(values[:, of], region[0], bound) for bound in region[1:])
            over = np.maximum(low - values[:, column], values[:, column] - high)
            # A table counts only where no box is exceeded.
            worse = (over > LIMIT_TOLERANCE) & (worst <= LIMIT_TOLERANCE) | coupled & (over > worst)
            coupled |= worse
            joint = np.where(worse, column if self._is_moving[column] else of, joint)
            limit = np.where(worse, np.where(values[:, column] < low, low, high), limit)
            worst = np.where(worse, over, worst)
        return Violations(joint, values[rows, joint], limit, worst > LIMIT_TOLERANCE, coupled)


def region_of(lower: Floats, upper: Floats, winding: Floats, tables: list[tuple[int, int, Floats]]) -> Region:
    """Return limits for scalar code, from tables as indices of joint `of` and the limited joint, and rows (3, k)."""
    ends = np.cumsum([0, *(bends.shape[1] for _, _, bends in tables)])
    rows = [(of, joint, *ends[t : t + 2]) for t, (of, joint, _) in enumerate(tables)]
    places = [place for of, joint, _ in tables for place in (of, joint) if place >= 0]
    at, low, high = np.concatenate([np.zeros((3, 0)), *(bends for _, _, bends in tables)], axis=1)
    numbers = np.array(rows, dtype=np.int64).reshape(-1)
    is_shared = len(set(places)) < len(places)
    return Region(lower.astype(np.float64), upper.astype(np.float64), winding, numbers, at, low, high, is_shared)


def extended(table: CoupledLimit) -> Floats:
    """Return the rows of a coupled limit with its constant ends extended far: values and bounds, (3, k + 2)."""
    bends = np.pad([table.at, table.lower, table.upper], ((0, 0), (1, 1)), mode="edge")
    bends[0, 0], bends[0, -1] = bends[0, 0] - _FAR, bends[0, -1] + _FAR
    return bends


@functools.cache
def _plane_region(table: CoupledLimit, of_box: tuple[float, float], joint_box: tuple[float, float]) -> Floats:
    """Return the region of points (of, joint) inside a coupled limit and the boxes of its two joints, shape (3, k).

    It is between two polylines, and need not be convex. Its rows are values of `of`, including both ends of its range,
    and the smallest and largest values of `joint` there. Robots with equal limits share the array.
    """
    first, last = max(of_box[0], table.at[0] - _FAR), min(of_box[1], table.at[-1] + _FAR)
    bends = {first, last, *table.at}
    for bound in (table.lower, table.upper):
        points = zip(table.at, bound, strict=True)
        for ((left, y), (right, z)), end in itertools.product(itertools.pairwise(points), joint_box):
            if (y - end) * (z - end) < 0.0:
                bends.add(left + (end - y) / (z - y) * (right - left))
    at = np.array(sorted(value for value in bends if first <= value <= last))
    return np.array(
        [at, *(np.clip(np.interp(at, table.at, bound), *joint_box) for bound in (table.lower, table.upper))]
    )


@functools.partial(
    CachedKernel,
    what="a kernel of inverse kinematics, projections onto limits",
    name="ik kernel, projections onto limits",
)
def _projections(region: Region, values: Floats2, fixed: Floats2, inside: Floats2) -> None:
    for i in range(values.shape[0]):
        project(region, values[i], fixed[i], inside[i])
