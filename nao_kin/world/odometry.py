"""Odometry of a walking robot: the trajectory of its trunk from a log of its joints.

One sole at a time is the support: flat on the floor, and in place. Its leg carries the trunk. When the support
changes, the other sole is put flat on the floor where it is. Rows in which no sole is in place are left out: the
trajectory consists of segments.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, between_samples, check_tolerance, shaped
from nao_kin._core.text import one_line_repr
from nao_kin.errors import WrongShape
from nao_kin.robot import Feet, RobotModel, serial_chain
from nao_kin.world.path import Path
from nao_kin.world.rest import KNOWN, Mask, RestLog, Turns, bias_notes
from nao_kin.world.sensors import Ground, Rows, Sensor, bridged, corrected

# Values of a sensor, and in which rows they are known.
Measured = tuple[Floats, Mask]

# Time over which the velocity is a mean [s]: a quarter of a step.
OVER = 0.2
# The fastest that a NAO's gyrometer measures, 500 °/s [rad/s]; source: doc.aldebaran.com/2-8, inertial_naov6.
_FASTEST = np.radians(500.0)
# By this much the legs must turn the root link, so that an inertial sensor that never changes is odd [rad].
_TURNED = np.radians(3.0)


@one_line_repr
@dataclass(frozen=True, eq=False)
class Odometry:
    """The trajectory of a robot's root link, in segments.

    Rows that belong to no segment have NaN, and −1 as `support` and `segment`: values of the legs' joints are NaN, or
    the robot does not stand. A segment begins where the one before it ended, because the motion between them is not
    known.

    Attributes:
        times: times of the n rows [s].
        T_world_base: pose of the root link, shape (n, 4, 4). The floor is z = 0, z points up [m].
        soles: names of the soles.
        support: index in `soles` of the sole that is in place, shape (n,).
        T_world_support: its pose, shape (n, 4, 4).
        segment: number of each row's segment, from 0, shape (n,).
        covariance: of `pose`, relative to the first row of the segment, shape (n, 3, 3) [m, rad]. It grows with each
            step by 3 mm and 0.5°, with the way from there by 3 %, and with the time in which the robot is not at rest
            by 4 mm and 1.5° in √s, as soles slide; with a gyrometer the heading grows by 0.3° in √s, 1 % and the bias
            that is not known instead. Two rows differ by 1.5 mm and 0.15°.
        velocity: mean velocity over 0.2 s: ahead, to the left [m/s], and of the heading [rad/s], shape (n, 3).
        notes: what is odd about the log and its sensors, and what was therefore not used.
    """

    times: Floats
    T_world_base: Floats
    soles: tuple[str, ...]
    support: NDArray[np.intp]
    T_world_support: Floats
    segment: NDArray[np.intp]
    covariance: Floats
    velocity: Floats
    notes: tuple[str, ...] = ()

    @property
    def valid(self) -> Mask:
        """Which rows belong to a segment, shape (n,)."""
        return np.asarray(self.segment >= 0)

    @property
    def pose(self) -> Floats:
        """Position x, y [m] and heading [rad] of the root link on the floor, shape (n, 3)."""
        T = self.T_world_base
        return np.column_stack([T[:, :2, 3], np.arctan2(T[:, 1, 0], T[:, 0, 0])])

    @property
    def segments(self) -> int:
        """Number of segments."""
        return int(self.segment.max(initial=-1)) + 1

    @property
    def steps(self) -> Mask:
        """The rows in which the support has changed, shape (n,)."""
        rows = np.flatnonzero(self.valid)
        found = np.zeros(len(self.times), dtype=np.bool_)
        changed = (np.diff(self.support[rows]) != 0) & (np.diff(self.segment[rows]) == 0)
        found[rows[1:][changed]] = True
        return found

    @property
    def distance(self) -> float:
        """Sum of the ways of the root link from step to step in all segments, seen from above [m]."""
        rows = np.flatnonzero(self.valid)
        if not len(rows):
            return 0.0
        begins = np.diff(self.segment[rows], prepend=-1) != 0
        rows = rows[begins | np.roll(begins, -1) | self.steps[rows]]  # the last row precedes a first one, also the next
        ways = np.linalg.norm(np.diff(self.T_world_base[rows, :2, 3], axis=0), axis=1)
        return float(ways[np.diff(self.segment[rows]) == 0].sum())


def odometry(
    robot: RobotModel,
    times: ArrayLike,
    q: ArrayLike,
    *,
    soles: Sequence[str] | None = None,
    contacts: ArrayLike | None = None,
    forces: ArrayLike | None = None,
    gyro: ArrayLike | None = None,
    start: ArrayLike | None = None,
    longest_gap: float = 0.5,
    valid: ArrayLike | None = None,
) -> Odometry:
    """Return the trajectory of the root link from a log of joint values.

    The support changes only on evidence, so that it does not switch back and forth while both soles are down:

    - with `contacts`, when the support loses contact and another sole has it;
    - with `forces`, when another sole carries more than 60 % of the total;
    - with neither, when another sole is lower than the support by more than 1 mm, seen from both soles.

    With `gyro` the heading is that of the gyrometer: it integrates the angular velocity about the vertical, and the
    support turns about its origin where its leg disagrees. Its bias is its mean where the robot is at rest: the
    gyrometer and the joints of the legs are still, and the soles carry. Between rests the bias drifts; if the robot is
    never at rest, 1° in a second is in the covariance, and a note says so. Roll and pitch are always those of a flat
    sole; `state` takes them from the inertial unit.

    A new segment begins after rows that are not `valid`, after 0.2 s in which no sole touches or carries (less than
    20 % of the weight), and after more than `longest_gap` without a row whose values are known. NaN is accepted: in the
    legs' joints it leaves the row out, in other joints it does not matter, and in sensors it is interpolated across up
    to `longest_gap`.

    A sensor is not used if it is never known, never changes although the robot moves, is beyond its unit, or
    contradicts the legs: where these put one sole at least 10 mm below the other, it carries, and the other does not.
    The other sensors of a sole count for one that is not used; without any, the legs decide for all soles. `notes` says
    so. Errors of sensors that the robot's file states (`nk.robot.read_offsets`) are corrected.

    Args:
        robot: any robot whose semantics name soles, or for which `soles` does.
        times: of the n rows, ascending; of rows with one time, which all get its result, the first value counts [s].
        q: configurations, shape (n, nq). The pose of a floating base in them is not used.
        soles: frames of the soles; None for those of the semantics.
        contacts: whether each of the s soles touches the floor, shape (n, s).
        forces: force on each sole, shape (n, s), or on each of the `force_sensors` of the semantics, shape (n, f), such
            as the eight of a NAO, in kg as NAOqi has it, N, or shares of the weight. Soles that carry less than half of
            the robot's mass in kg throughout do not stand.
        gyro: angular velocity in the axes of the root link, shape (n, 3) [rad/s].
        start: pose of the root link at the first row of a segment, shape (4, 4). None for a world with its origin on
            the floor between the feet at that row, and its x axis along theirs (`feet_frame`).
        longest_gap: largest time between two rows of a segment [s].
        valid: in which rows the robot stands or walks, shape (n,); None for all.

    Raises:
        BadArgument: times that go back, both contacts and forces, a robot without soles.
        WrongShape: arrays of different lengths.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = np.linspace(nao.posture("StandInit"), nao.posture("Crouch"), 50)
        >>> found = nk.world.odometry(nao, 0.02 * np.arange(50), q)
        >>> found.T_world_base[[0, -1], 2, 3].round(3).tolist()
        [0.32, 0.227]
    """
    gyro = corrected(robot, "gyro", gyro)
    log = LegLog.of(robot, times, q, soles, contacts, forces, longest_gap)
    stands = None if valid is None else log.rows.merged(shaped(valid, (len(log.rows.own),), "valid")) != 0.0
    turns, rest = log.turns(gyro)
    return log.rows.expanded(log.followed(rest.rest, turns, start, stands))


# --- What a log has: times, rows without values, soles that touch or carry.


def leg_columns(robot: RobotModel, soles: Sequence[str]) -> list[int]:
    """Return the columns of a configuration that move soles."""
    moving = {name for sole in soles for name in serial_chain(robot, robot.tree.root, sole).coordinates}
    return [robot.nq_base + k for k, name in enumerate(robot.joint_names) if name in moving]


@dataclass(frozen=True, eq=False)
class LegLog:
    """A checked log of n rows: what its joints say about the soles, and contacts or forces about the ground.

    Attributes:
        feet: the s soles.
        rows: the rows with a time of their own, n of them.
        q: configurations, interpolated where they are NaN, shape (n, nq).
        legs: values of the joints that move the soles, shape (n, j).
        T_base_soles: poses of the soles in the root link, on the ground, shape (n, s, 4, 4).
        ground: contacts or forces.
        known: in which rows the values of the legs and of the ground are known, shape (n,).
        longest_gap: largest time between two rows of a segment [s].
        notes: what is odd about the sensors.
    """

    feet: Feet
    rows: Rows
    q: Floats
    legs: Floats
    T_base_soles: Floats
    ground: Ground
    known: Mask
    longest_gap: float
    notes: list[str]

    @staticmethod
    def of(
        robot: RobotModel,
        times: ArrayLike,
        q: ArrayLike,
        soles: Sequence[str] | None,
        contacts: ArrayLike | None,
        forces: ArrayLike | None,
        longest_gap: float,
    ) -> LegLog:
        """Return the log that the arguments of `odometry` give."""
        feet = Feet.of(robot, soles, needed=True, or_origin=True)
        values = as_floats(q, (robot.nq,), "q", gaps=True)
        if values.ndim != 2 or not len(values):
            raise WrongShape("q", f"(n, {robot.nq}), one configuration at least", values.shape)
        rows = Rows.of(times, len(values))
        measured, legs = rows.merged(values), leg_columns(robot, feet.names)
        filled, known = between_samples(measured), np.asarray(~np.isnan(measured[:, legs]).any(axis=1))
        configurations = robot.checked(np.where(np.isnan(filled), robot.neutral(), filled))
        check_tolerance(longest_gap, "longest_gap")
        notes = list(rows.notes)
        T_base_soles = feet.on_ground(np.asarray(robot.fk(configurations, feet.names, reference=robot.tree.root)))
        forces = corrected(robot, "forces", forces)
        ground = Ground.of(robot, feet, T_base_soles, known, rows, contacts, forces, longest_gap, notes)
        known = known & ground.known
        moving = configurations[:, legs]
        return LegLog(feet, rows, configurations, moving, T_base_soles, ground, known, float(longest_gap), notes)

    @property
    def moments(self) -> Floats:
        """Times of the rows, shape (n,) [s]."""
        return self.rows.times

    def measured(
        self, values: Floats, what: str, *, most: float = np.inf, hint: str = "", along: Floats | None = None
    ) -> Measured | None:
        """Return values (n, k) of an inertial sensor, interpolated in time, and where they are known; or None.

        None stands for a sensor that cannot be used, and the notes say why. `most`, `hint` and `along` are those of
        `Sensor`.
        """
        known = values[np.isfinite(values).all(axis=1)]
        moves = len(known) > 1 and bool((known == known[0]).all()) and self._turns(about_all=what == "gyro")
        found = Sensor(what, values, None, self.notes)
        found.must_be_within(most, hint)
        found.must_move(moves)
        if along is not None and np.isfinite(found.values).any():
            found.agree_with(along, hint)
        return bridged(found.values, self.moments, self.longest_gap) if np.isfinite(found.values).any() else None

    def turns(self, gyro: ArrayLike | None, up: Floats | None = None) -> tuple[Turns | None, RestLog]:
        """Return the angular velocity without its bias, and the rest in the log; None without gyrometer to use.

        Without gyrometer, verticals `up` (n, 3) show whether the trunk is quiet.
        """
        hint = ": are these deg/s? A heading such as GyroX [deg/s] says so"
        values = None if gyro is None else self.rows.read(gyro, 3, "gyro")
        found = None if values is None else self.measured(values, "gyro", most=_FASTEST, hint=hint)
        if found is None:
            used = self.known if up is None else self.known & np.isfinite(up).all(axis=1)
            return None, RestLog.of(self.moments, self.legs, self.ground.stands, used, up=up)
        rates, near = found
        rest = RestLog.of(self.moments, self.legs, self.ground.stands, self.known & near, rates)
        self.notes.extend(bias_notes(rest.bias[rest.rest], bool(rest.deviation.max(initial=0.0) > KNOWN)))
        return Turns(rates - rest.bias, near, rest.deviation), rest

    def _turns(self, *, about_all: bool) -> bool:
        """Return whether the legs turn the root link, about the vertical too or not."""
        path = self.followed(np.zeros(len(self.moments), dtype=np.bool_), None, None, None)
        R = path.T_world_base[path.valid, :3, :3]
        turns = R.reshape(-1, 9) if about_all else R[:, 2]
        return len(R) > 0 and bool((np.diff(np.percentile(turns, [1.0, 99.0], axis=0), axis=0) > _TURNED).any())

    def followed(self, rest: Mask, turns: Turns | None, start: ArrayLike | None, valid: Mask | None) -> Odometry:
        """Return the trajectory with `start` of `odometry`, where the robot stands; `rest` is that of `RestLog`."""
        moments, count, path = self.moments, len(self.moments), Path(start)
        stands = self.ground.stands if valid is None else self.ground.stands & valid
        known = self.known if turns is None else self.known & turns.near
        segment = _segments(moments, known, stands, self.longest_gap)
        T_world_base, T_world_support = np.full((2, count, 4, 4), np.nan)
        support = np.full(count, -1)
        covariance, velocity = np.full((count, 3, 3), np.nan), np.full((count, 3), np.nan)
        for k in range(segment.max(initial=-1) + 1):
            own = np.flatnonzero(segment == k)
            T_soles, at = self.T_base_soles[own], moments[own]
            support[own] = self.ground.supports(own, T_soles)
            path.begin(T_soles[0], int(support[own[0]]))
            T_world_base[own], T_world_support[own], pose, covariance[own] = path.extend(
                T_soles, support[own], at, rest[own], None if turns is None else turns[own]
            )
            velocity[own] = _velocity(pose, at)
        T_world_support[:, 2, 3] -= self.feet.heights[support]
        found = T_world_base, self.feet.names, support, T_world_support, segment, covariance, velocity
        return Odometry(moments, *found, tuple(self.notes))


def _segments(moments: Floats, known: Mask, stands: Mask, longest_gap: float) -> NDArray[np.intp]:
    """Return the number of the segment of each row, −1 for none, shape (n,)."""
    segment = np.full(len(moments), -1)
    rows = np.flatnonzero(known & stands)
    if len(rows):
        lifted = np.cumsum(~stands)[rows]
        new = (np.diff(moments[rows]) > longest_gap) | (np.diff(lifted) > 0)
        segment[rows] = np.concatenate([[0], np.cumsum(new)])
    return segment


# --- The motion from row to row.


def _velocity(pose: Floats, moments: Floats) -> Floats:
    """Return the mean velocity about each row, ahead, to the left and of the heading, shape (n, 3)."""
    before, after = (np.clip(moments + sign * OVER / 2.0, moments[0], moments[-1]) for sign in (-1.0, 1.0))
    ways = [np.interp(after, moments, column) - np.interp(before, moments, column) for column in pose.T]
    with np.errstate(invalid="ignore"):
        x, y, turn = ways / (after - before)
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    return np.column_stack([c * x + s * y, c * y - s * x, turn])
