"""Checks of a motion on a robot: limits, coupled limits, speed limits, joints that share a motor; and diagrams."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import (
    COUPLING_TOLERANCE,
    LIMIT_TOLERANCE,
    MEASURED_TOLERANCES,
    Floats,
    choice,
    finite_or_none,
    flag,
    positive,
    runs,
)
from nao_kin._core.warn import need_extra
from nao_kin.errors import UnknownName
from nao_kin.motion.curves import Excess, JointCurves, Quantity, combination, excesses, pieces_of
from nao_kin.motion.interpolation import Segments
from nao_kin.motion.motion import HOLD, REST, Motion, check_joints, checked_names
from nao_kin.robot import CollisionRule, RobotModel
from nao_kin.robot.semantics import CoupledLimit
from nao_kin.world import EDGES, DynamicBalance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# --- The violations that a check finds.

Kind = Literal["limit", "coupled limit", "speed", "motor", "collision", "balance"]
# For each joint and kind a message lists this many intervals, those with the largest excess.
_MAX_LISTED = 3
# A smaller tilt about an edge of the soles is not named [rad].
_STEADY = math.radians(0.1)


def interval(start: float, end: float) -> str:
    """Return a time interval in words."""
    return f"{start:.6g} s" if start == end else f"{start:.6g} to {end:.6g} s"


@dataclass(frozen=True)
class MotionViolation:
    """A time interval in which a joint is outside one bound.

    Attributes:
        kind: "limit": its own range. "coupled limit": the range that depends on another joint. "speed": its largest
            speed. "motor": the value that follows from another joint of its motor. "collision": the least distance
            between its links. "balance": how far the robot tilts about an edge of its soles.
        joint: name of the joint; of a link for "collision"; the soles on the floor for "balance".
        start: beginning of the interval [s].
        end: end of the interval [s].
        time: time of the largest excess [s].
        value: value at that time, or speed for "speed".
        lower: smallest value allowed then.
        upper: largest value allowed then.
        unit: unit of value, lower and upper.
        of: the other joint, for a coupled limit and a motor; the other link for "collision"; for "balance" the edge
            over which the robot falls, "front", "left", "back" or "right", or "" if only an edge or a corner of a sole
            is on the floor; else None.
        of_value: its value at that time; 0 for a link; for "balance" the least margin of the zero-moment point [m].
    """

    kind: Kind
    joint: str
    start: float
    end: float
    time: float
    value: float
    lower: float
    upper: float
    unit: str
    of: str | None = None
    of_value: float = 0.0

    @property
    def excess(self) -> float:
        """Distance from the bound at `time`."""
        return max(self.lower - self.value, self.value - self.upper)

    def describe(self, *, degrees: bool = False) -> str:
        """Return one line of text, with angles in degrees if wanted.

        Examples:
            >>> nao = nk.load_nao()
            >>> turn = nk.Motion([0.0, 0.1], ["HeadYaw"], [[0.0], [1.5]])
            >>> nk.motion.check(nao, turn).violations[0].describe()
            'HeadYaw moves at 15 at 0 s, 6.73 rad/s outside [-8.26797, 8.26797] rad/s (0 to 0.1 s)'
        """
        if self.kind == "collision":
            overlap = f"overlap by {self.excess * 1e3:.3g} mm at {self.time:.6g} s"
            return f"{self.joint} and {self.of} {overlap} ({interval(self.start, self.end)})"
        if self.kind == "balance":
            if not self.of:
                return f"{self.joint}: only an edge or a corner is on the floor ({interval(self.start, self.end)})"
            outside = f"{-self.of_value * 1e3:.3g} mm outside" if self.of_value > -math.inf else "in the air"
            why = f"its zero-moment point is {outside}, and it tilts by more than {math.degrees(self.upper):.3g}°"
            return f"{self.joint}: falls over the {self.of} edge, {why} ({interval(self.start, self.end)})"
        turns = degrees and self.unit.startswith("rad")
        scale = math.degrees(1.0) if turns else 1.0
        unit = self.unit.replace("rad", "°") if turns else {"1": "", "1/s": "/s"}.get(self.unit, f" {self.unit}")
        value, lower, upper, excess, of_value = (
            number * scale for number in (self.value, self.lower, self.upper, self.excess, self.of_value)
        )
        what = " moves at" if self.kind == "speed" else " ="
        text = f"{self.joint}{what} {value:.6g} at {self.time:.6g} s, "
        if self.kind == "motor":
            text += f"{self.of} = {of_value:.6g}{unit}: one motor, {excess:.3g}{unit} apart"
        else:
            text += f"{excess:.3g}{unit} outside [{lower:.6g}, {upper:.6g}]{unit}"
            text += f" at {self.of} = {of_value:.6g}" if self.of is not None else ""
        return f"{text} ({interval(self.start, self.end)})"

    def as_dict(self) -> dict[str, Any]:
        """Return the fields for JSON; an infinite bound is None."""
        numbers = ("start", "end", "time", "value", "lower", "upper", "excess")
        row: dict[str, Any] = {"kind": self.kind, "joint": self.joint, "unit": self.unit}
        row |= {name: finite_or_none(float(getattr(self, name))) for name in numbers}
        return row | ({} if self.of is None else {"of": self.of, "of_value": finite_or_none(self.of_value)})


@dataclass(frozen=True)
class BalanceInterval:
    """A time interval of a motion in which the same soles are on the floor.

    Attributes:
        start: beginning of the interval [s].
        end: end of the interval [s].
        soles: the soles on the floor; none if the robot does not stand on its soles, and then nothing is known.
        com_margin: least signed distance of the centre of mass, seen from above, from the edge of the support polygon,
            positive inside [m]: the margin of a robot that moves slowly.
        margin: least signed distance of the zero-moment point from that edge [m].
        time: when it is least [s].
        edge: the nearest edge then, as the robot sees it: "front", "left", "back" or "right"; "" if only an edge or a
            corner of the soles is on the floor, and both margins are −∞.
        rocking: largest tilt about an edge of the soles [rad]; from 5° on the robot falls.
    """

    start: float
    end: float
    soles: tuple[str, ...]
    com_margin: float
    margin: float
    time: float
    edge: str
    rocking: float

    def describe(self) -> str:
        """Return one line of text."""
        span = interval(self.start, self.end)
        if not self.soles:
            return f"{span}: not on its soles"
        soles = " and ".join(self.soles)
        if not self.edge:
            return f"{span}: only an edge or a corner of {soles} on the floor at {self.time:.6g} s"
        moving = f"{self.margin * 1e3:.3g} mm moving" if self.margin > -math.inf else "leaves the floor moving"
        margins = f"margin {self.com_margin * 1e3:.3g} mm at rest, {moving}"
        rocks = f", rocks by {math.degrees(self.rocking):.2g}°" if self.rocking > _STEADY else ""
        return f"{span}: on {soles}, {margins} ({self.edge} edge at {self.time:.6g} s){rocks}"

    def as_dict(self) -> dict[str, Any]:
        """Return the fields for JSON; what is not known is None, and so is an infinite factor."""
        row = {**vars(self), "soles": list(self.soles), "edge": self.edge or None}
        return row | {name: finite_or_none(float(row[name])) for name in ("com_margin", "margin", "time", "rocking")}


@dataclass(frozen=True)
class MotionReport:
    """The violations of a motion.

    Attributes:
        robot: name of the robot.
        joints: joints that the motion names.
        start: time of the first key [s].
        end: time of the last key [s].
        violations: by kind, joint and time. Each has a `kind` ("limit", "coupled limit", "speed", "motor", "collision"
            or "balance"), a `joint` (a link for "collision", the soles for "balance"), the interval from `start` to
            `end` [s], the `time` of the largest excess [s], the `value` then, the bounds `lower` and `upper`, their
            `unit`, and for all but "limit" and "speed" the other joint or link `of` (the edge for "balance"), and its
            value `of_value`; `describe()` says it in words.
        sampled: samples per second of coupled limits and shared motors, if they were sampled; None if all violations
            were found in closed form.
        collisions_sampled: samples per second of collisions; None if they were not checked.
        accepted: with `limits="measured"`, the limits that are exceeded by no more than its tolerances; no violations.
        balance: with `balance=True`, the intervals of the motion in which the same `soles` are on the floor (none if it
            does not stand on them), from `start` to `end` [s], with the least margin of the centre of mass at rest,
            `com_margin`, and of the zero-moment point, `margin` [m], the `time` of the latter, the nearest `edge` then,
            and the largest tilt about an edge of the soles, `rocking` [rad].
    """

    robot: str
    joints: tuple[str, ...]
    start: float
    end: float
    violations: tuple[MotionViolation, ...]
    sampled: float | None
    collisions_sampled: float | None = None
    accepted: tuple[MotionViolation, ...] = ()
    balance: tuple[BalanceInterval, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether there are no violations."""
        return not self.violations

    @property
    def worst(self) -> tuple[MotionViolation, ...]:
        """For each kind and joint the violation with the largest excess, in the order of `violations`."""
        worst: dict[tuple[str, str], MotionViolation] = {}
        for violation in self.violations:
            key = violation.kind, violation.joint
            if key not in worst or violation.excess > worst[key].excess:
                worst[key] = violation
        return tuple(worst.values())

    def describe(self, *, degrees: bool = False) -> str:
        """Return one line for each violation, long lists shortened, or one line without violations.

        Examples:
            >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
            >>> nk.motion.check(nk.load_nao(), nod).describe()
            'nao_v6 can perform the motion: 1 joints, 0 to 1 s'
        """
        span = f"{len(self.joints)} joints, {self.start:g} to {self.end:g} s"
        if self.ok:
            return "\n".join([f"{self.robot} can perform the motion: {span}", *self._more(degrees)])
        lines = [f"{self.robot} cannot perform the motion: {span}, {_counted(self.violations)}"]
        groups: dict[tuple[str, str], list[MotionViolation]] = {}
        for violation in self.violations:
            groups.setdefault((violation.kind, violation.joint), []).append(violation)
        for (kind, _), group in groups.items():
            group.sort(key=lambda violation: -violation.excess)
            lines += [f"{kind}: {violation.describe(degrees=degrees)}" for violation in group[:_MAX_LISTED]]
            if len(group) > _MAX_LISTED:
                lines.append(f"{kind}: {group[0].joint}: and {len(group) - _MAX_LISTED} more intervals")
        if self.sampled is not None:
            lines.append(f"coupled limits and shared motors were sampled {self.sampled:g} times per second")
        if self.collisions_sampled is not None:
            lines.append(f"collisions were sampled {self.collisions_sampled:g} times per second")
        return "\n".join([*lines, *self._more(degrees)])

    def _more(self, degrees: bool) -> list[str]:
        """Return a line on what `limits="measured"` accepted, if anything, and lines on the balance, if checked."""
        lines = [f"balance: {row.describe()}" for row in self.balance[:_MAX_LISTED]]
        if len(self.balance) > _MAX_LISTED:
            lines.append(f"balance: and {len(self.balance) - _MAX_LISTED} more intervals")
        if not self.accepted:
            return lines
        worst = max(self.accepted, key=lambda row: row.excess / MEASURED_TOLERANCES[row.unit])
        count = len({row.joint for row in self.accepted})
        line = f"accepted as measured: {count} joint{'s'[: count > 1]}, most {worst.describe(degrees=degrees)}"
        return [*lines, line]

    def as_dict(self) -> dict[str, Any]:
        """Return the report for JSON, in seconds, radians, metres and ratios."""
        return {
            "robot": self.robot,
            "ok": self.ok,
            "joints": list(self.joints),
            "start": self.start,
            "end": self.end,
            "sampled": self.sampled,
            "collisions_sampled": self.collisions_sampled,
            "violations": [violation.as_dict() for violation in self.violations],
            "accepted": [violation.as_dict() for violation in self.accepted],
            "balance": [part.as_dict() for part in self.balance],
        }

    def __repr__(self) -> str:
        return f"<MotionReport: {'ok' if self.ok else _counted(self.violations)}>"


def _counted(violations: Iterable[MotionViolation]) -> str:
    counts = Counter(violation.kind for violation in violations)
    words = {"limit": "outside limits", "coupled limit": "outside coupled limits"}
    words |= {"speed": "too fast", "motor": "of disagreeing joints", "collision": "with links that overlap"}
    words |= {"balance": "in which it falls"}
    return ", ".join(f"{count} {words[kind]}" for kind, count in counts.items())


# --- The check.

# Tolerance as a share of a speed limit, because times are differences of rounded numbers.
SPEED_TOLERANCE = 1e-9
_RATE = 1000.0


def check(
    robot: RobotModel,
    motion: Motion,
    *,
    missing: str | ArrayLike = HOLD,
    rate: float = _RATE,
    collisions: bool | CollisionRule = False,
    balance: bool = False,
    limits: Literal["enforce", "measured"] = "enforce",
) -> MotionReport:
    """Return the violations of a robot's limits by a motion, also between its keys.

    The extreme values and speeds of every joint are found in closed form for each interpolation, and so are the
    distances to coupled limits and between the joints of one motor for linear and smooth motions. For Bezier motions
    these two distances are sampled, with a cubic between two samples. Two joints of one motor, such as the two
    HipYawPitch, must agree to 1e-6.

    Args:
        robot: a robot with all the named joints.
        motion: the motion to check.
        missing: values of the joints that the motion does not name, as in `Motion.configurations`; coupled limits need
            them.
        rate: samples per second.
        collisions: also report the links that overlap, by `RobotModel.clearance`, at `rate` samples per second: True,
            or a `nk.robot.CollisionRule`.
        balance: also report where the robot falls, by `nk.world.dynamic_balance` at 100 samples per second; the robot
            stands still before and after the motion.
        limits: "enforce", or "measured" for a recorded motion: joints may be past their limits by the noise of sensors
            (5°, 0.02 of a hand's opening), and the report counts them as `accepted`.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.check(nk.load_nao(), nod).ok
        True
    """
    check_joints(robot, motion)
    choice(limits, ("enforce", "measured"), "limits")
    rate = float(positive(rate, "rate"))
    curves, rule = JointCurves(motion, missing, robot, rate), CollisionRule.of(collisions)
    motors = robot.joints_by_motor(motion.joint_names).values()
    intervals, falls = _balance(motion.balance(robot, missing=missing)) if balance else ([], [])
    findings: Iterable[list[MotionViolation]] = (
        *(_limits(robot, joint, curves[joint]) for joint in motion.joint_names),
        *(_coupled(robot, motion, table, curves) for table in robot.coupled_limits),
        *(_speeds(robot, joint, curves[joint]) for joint in motion.joint_names),
        *(_disagreement(robot, first, joint, curves) for first, *others in motors for joint in others),
        [] if rule is None else _collisions(robot, motion, missing, rate, rule),
        falls,
    )
    rows = [(row, limits == "measured" and _is_noise(row)) for found in findings for row in found]
    return MotionReport(
        robot=robot.name,
        joints=motion.joint_names,
        start=motion.start,
        end=motion.end,
        violations=tuple(row for row, accepted in rows if not accepted),
        sampled=rate if curves.sampled else None,
        collisions_sampled=None if rule is None else rate,
        accepted=tuple(row for row, accepted in rows if accepted),
        balance=tuple(intervals),
    )


def _is_noise(row: MotionViolation) -> bool:
    return row.kind in ("limit", "coupled limit") and row.excess <= MEASURED_TOLERANCES.get(row.unit, 0.0)


def _collisions(
    robot: RobotModel, motion: Motion, missing: str | ArrayLike, rate: float, rule: CollisionRule
) -> list[MotionViolation]:
    """Return the intervals of samples in which links overlap, each with the links that overlap most."""
    moves = motion.configurations(robot, rate=rate, missing=missing)
    times = moves.times
    clearance = robot.clearance(moves.q, **vars(rule))
    rows = []
    for part in runs(~np.asarray(clearance.is_free)):
        worst = part.start + int(np.argmin(clearance.distance[part]))
        one, other = clearance.pairs[int(clearance.pair_index[worst])]
        start, end, at = (float(times[k]) for k in (part.start, part.stop - 1, worst))
        value = float(clearance.distance[worst])
        rows.append(MotionViolation("collision", one, start, end, at, value, 0.0, math.inf, "m", other))
    return rows


# −1 stands for no edge.
_EDGES = (*EDGES, "")


def _balance(found: DynamicBalance) -> tuple[list[BalanceInterval], list[MotionViolation]]:
    """Return the intervals in which the same soles are on the floor, and those in which the robot falls."""
    on_floor, soles, moving = found.down.touching & found.stands[:, None], found.down.soles, slice(REST, -REST)
    arrays: tuple[Any, ...] = found.times, on_floor, found.com_margin, found.margin, found.edge, found.rocking
    times, on_floor, com_margin, margin, edge, rocking = (array[moving] for array in arrays)
    # What the robot does when the motion has ended belongs to its last row.
    rocking = np.append(rocking[:-1], found.rocking[-REST - 1 :].max())
    intervals, falls = [], []
    changes = np.flatnonzero(np.diff(on_floor, axis=0).any(axis=1)) + 1
    for part in itertools.starmap(slice, itertools.pairwise([0, *changes.tolist(), len(times)])):
        names = tuple(name for name, down in zip(soles, on_floor[part.start], strict=True) if down)
        span = float(times[part.start]), float(times[part.stop - 1])
        if not names:
            intervals.append(BalanceInterval(*span, (), math.nan, math.nan, math.nan, "", math.nan))
            continue
        worst = part.start + int(margin[part].argmin())
        least = float(com_margin[part].min()), float(margin[worst]), float(times[worst])
        intervals.append(BalanceInterval(*span, names, *least, _EDGES[edge[worst]], float(rocking[part].max())))
    for run in runs(rocking > 0.0):
        if rocking[run].max() > found.FALLS:
            first = max(run.start - 1, 0)
            worst, most = first + int(margin[first : run.stop].argmin()), run.start + int(rocking[run].argmax())
            name = " and ".join(name for name, down in zip(soles, on_floor[worst], strict=True) if down)
            at = float(times[run.start]), float(times[run.stop - 1]), float(times[most]), float(rocking[most])
            margin_then = float(margin[worst])
            falls.append(
                MotionViolation("balance", name, *at, 0.0, found.FALLS, "rad", _EDGES[edge[worst]], margin_then)
            )
    return intervals, falls


def _limits(robot: RobotModel, joint: str, curve: Segments) -> list[MotionViolation]:
    lower, upper, _ = robot.joints.limits(joint)
    rows = _both_sides(curve, "value", lower, upper, LIMIT_TOLERANCE)
    return [MotionViolation("limit", joint, *row, lower, upper, robot.unit(joint)) for row in rows]


def _speeds(robot: RobotModel, joint: str, curve: Segments) -> list[MotionViolation]:
    *_, limit = robot.joints.limits(joint)
    rows = _both_sides(curve, "speed", -limit, limit, SPEED_TOLERANCE * limit)
    return [MotionViolation("speed", joint, *row, -limit, limit, f"{robot.unit(joint)}/s") for row in rows]


def _coupled(robot: RobotModel, motion: Motion, table: CoupledLimit, curves: JointCurves) -> list[MotionViolation]:
    """Return where a joint is outside the range that depends on another joint."""
    if table.joint not in motion.joint_names and table.of not in motion.joint_names:
        return []
    joint, of = curves[table.joint], curves[table.of]
    times = curves.common_times(table.joint, table.of, bends=bends(of, table))
    unit = robot.unit(table.joint)
    rows = list[MotionViolation]()
    for bound, sign in ((table.upper, 1.0), (table.lower, -1.0)):
        slopes = np.concatenate([[0.0], np.diff(bound) / np.diff(table.at), [0.0]])
        # On each interval the bound is linear in the other joint's value.
        middle = curves.values(table.of, 0.5 * (times[:-1] + times[1:]))
        slope = slopes[np.searchsorted(table.at, middle)]
        at_ends = np.interp(curves.values(table.of, times), table.at, bound)
        over = combination(joint, of, times, slope, curves.values(table.joint, times) - at_ends)
        for row in excesses(over, "value", 0.0, sign, LIMIT_TOLERANCE):
            value, of_value = curves.values_at(row.time, table.joint, table.of)
            lower, upper = (float(end) for end in table.range(np.array(of_value)))
            numbers = *row[:3], value, lower, upper
            rows.append(MotionViolation("coupled limit", table.joint, *numbers, unit, table.of, of_value))
    return sorted(rows, key=lambda row: row.start)


def bends(of: Segments, table: CoupledLimit) -> Floats:
    """Return the times at which a joint crosses a bend of the other joint's range [s]."""
    pieces = pieces_of(of, "value", np.arange(len(of.start)))
    low, high = pieces.values.min(axis=1), pieces.values.max(axis=1)
    times = [pieces.crossings(np.flatnonzero((low < level) & (level < high)), level) for level in table.at]
    return np.concatenate([np.zeros(0), *times])


def _disagreement(robot: RobotModel, first: str, joint: str, curves: JointCurves) -> list[MotionViolation]:
    """Return where a joint differs from the value that follows from another joint of its motor."""
    mimic, reference = robot.mimics[joint], robot.mimics.get(first)
    follows = mimic if reference is None else mimic.through(reference.inverted(first))
    times = curves.common_times(first, joint)
    miss = curves.values(joint, times) - follows.value(curves.values(first, times))
    difference = combination(curves[joint], curves[first], times, np.full(len(times) - 1, follows.multiplier), miss)
    rows = []
    for row in _both_sides(difference, "value", 0.0, 0.0, COUPLING_TOLERANCE):
        value, other = curves.values_at(row.time, joint, first)
        expected = float(follows.value(other))
        numbers = *row[:3], value, expected, expected
        rows.append(MotionViolation("motor", joint, *numbers, robot.unit(joint), first, other))
    return rows


def _both_sides(curve: Segments, quantity: Quantity, lower: float, upper: float, tolerance: float) -> list[Excess]:
    above = excesses(curve, quantity, upper, 1.0, tolerance)
    below = excesses(curve, quantity, lower, -1.0, tolerance)
    return sorted([*above, *below], key=lambda row: row.start)


# --- Diagrams of motions: every joint over time, between its limits.

_SAMPLES = 2000
# Largest number of keys drawn as dots; more would look like a line.
_MAX_DOTS = 60
_COLUMNS = 3
_SIZE = (4.2, 2.0)
_LINE, _LIMIT, _OUTSIDE = "#1f6fb4", "#888888", "#d62728"


def plot(
    robot: RobotModel,
    motion: Motion,
    *,
    joints: Sequence[str] | None = None,
    speed: bool = False,
    balance: bool = False,
    missing: str | ArrayLike = HOLD,
) -> Figure:
    """Draw a diagram for each joint: its values over time, its limits dashed, and violations of them in red.

    Args:
        robot: has all the joints named.
        motion: the motion to draw.
        joints: names of the joints to draw; None for all.
        speed: draw speeds and their limits instead.
        balance: add a diagram of the margins of the centre of mass and of the zero-moment point, as in `check`.
        missing: values of the joints that the motion does not name, for `balance`.

    Returns:
        A matplotlib figure: `figure.savefig("motion.png")` writes it. Angles are in degrees.

    Raises:
        MissingExtra: matplotlib is not installed.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> figure = nk.motion.plot(nk.load_nao(), nod)
        >>> len(figure.axes)
        1
    """
    need_extra("plotting a motion", "plot", "matplotlib.figure")
    from matplotlib.figure import Figure

    check_joints(robot, motion)
    flag(balance, "balance")
    names = motion.joint_names if joints is None else checked_names(joints)
    for name in names:
        if name not in motion.joint_names:
            raise UnknownName("joint of the motion", name, motion.joint_names)
    violations = check(robot, motion).violations
    count = len(names) + balance
    columns = min(_COLUMNS, count)
    rows = math.ceil(count / columns)
    figure = Figure(figsize=(_SIZE[0] * columns, _SIZE[1] * rows + 0.4), layout="constrained")
    grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
    t = np.unique(np.concatenate([np.linspace(motion.start, motion.end, _SAMPLES), motion.key_times]))
    values = motion.speed(t) if speed else motion.sample(t)
    for axes, name in zip(grid.flat, names, strict=False):
        turns = robot.unit(name) == "rad"
        scale = math.degrees(1.0) if turns else 1.0
        column = motion.joint_names.index(name)
        kinds = ("speed",) if speed else ("limit", "coupled limit", "motor")
        bad = [row for row in violations if row.joint == name and row.kind in kinds]
        lower, upper, limit = robot.joints.limits(name)
        bounds = (-limit, limit) if speed else (lower, upper)
        _draw(axes, t, values[:, column] * scale, [bound * scale for bound in bounds], bad)
        if not speed and len(motion.keys[column]) <= _MAX_DOTS:
            axes.plot(motion.times[column], motion.keys[column] * scale, ".", color=_LINE, markersize=5)
        unit = "°" if turns else "" if robot.unit(name) == "1" else robot.unit(name)
        unit += "/s" if speed else ""
        axes.set_title(f"{name}{f' [{unit}]' if unit else ''}", fontsize=9)
    if balance:
        _draw_margins(grid.flat[len(names)], motion.balance(robot, missing=missing))
    for index, axes in enumerate(grid.flat):
        axes.grid(alpha=0.3)
        axes.tick_params(labelsize=8)
        axes.margins(x=0.01)
        if index >= count:
            axes.set_visible(False)
        elif index + columns >= count:
            axes.set_xlabel("time [s]", fontsize=8)
            axes.tick_params(labelbottom=True)
    return figure


def _draw_margins(axes: Any, found: DynamicBalance) -> None:
    for margin, colour, name in ((found.com_margin, _LIMIT, "at rest"), (found.margin, _LINE, "moving")):
        axes.plot(found.times, 1e3 * margin, color=colour, linewidth=1.2, label=name)
    axes.axhline(0.0, color=_LIMIT, linewidth=0.9, linestyle="--")
    for run in runs(found.margin < 0.0):
        axes.axvspan(found.times[run.start], found.times[run.stop - 1], color=_OUTSIDE, alpha=0.25, linewidth=1.0)
    axes.set_title("balance: margin [mm]", fontsize=9)
    axes.legend(fontsize=7, loc="best", frameon=False)


def _draw(axes: Any, t: Any, values: Any, bounds: Sequence[float], bad: Sequence[Any]) -> None:
    finite = np.where(np.isfinite(values), values, np.nan)
    axes.plot(t, finite, color=_LINE, linewidth=1.2)
    # Only limits near the curve are drawn, so that a joint that hardly moves still shows its movement.
    low, high = float(np.nanmin(finite)), float(np.nanmax(finite))
    room = max(high - low, 1e-3)
    for bound in bounds:
        if low - room <= bound <= high + room:
            axes.axhline(bound, color=_LIMIT, linewidth=0.9, linestyle="--")
    for row in bad:
        axes.axvspan(row.start, row.end, color=_OUTSIDE, alpha=0.25, linewidth=1.0)
