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

from nao_kin._core.arrays import Floats, shaped
from nao_kin._core.text import one_line_repr
from nao_kin.robot import RobotModel
from nao_kin.world.legs import LegLog, Legs
from nao_kin.world.path import Column, Path, cosine_sine
from nao_kin.world.rest import Mask, Turns

# Time over which the velocity is a mean [s]: a quarter of a step.
OVER = 0.2


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
            step by 3 mm and 0.5°, with the way from there by 3.5 %, and with the time in which the robot is not at rest
            by 4 mm and 1.9° in √s, as soles slide; with a gyrometer the heading grows by 0.3° in √s, 1 % and the bias
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
        """Length of the ways of the root link in all segments, seen from above [m].

        They lead through the middles between its places at two steps, so that a robot that sways from foot to foot
        does not get on.
        """
        length, steps = 0.0, self.steps
        for k in range(self.segments):
            rows = np.flatnonzero(self.segment == k)
            at = self.T_world_base[[rows[0], *rows[steps[rows]], rows[-1]], :2, 3]
            way = np.concatenate([at[:1], 0.5 * (at[1:] + at[:-1]), at[-1:]])
            length += float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
        return length


def odometry(
    robot: RobotModel,
    q: ArrayLike,
    times: ArrayLike,
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
        q: configurations, shape (n, nq). The pose of a floating base in them is not used.
        times: of the n rows, ascending; of rows with one time, which all get its result, the first value counts [s].
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
        >>> found = nk.world.odometry(nao, q, 0.02 * np.arange(50))
        >>> found.T_world_base[[0, -1], 2, 3].round(3).tolist()
        [0.32, 0.227]
    """
    log = LegLog.of(Legs(robot, soles), times, q, contacts, forces, longest_gap)
    stands = None if valid is None else log.rows.merged(shaped(valid, (len(log.rows.own),), "valid")) != 0.0
    turns, rest = log.turns(gyro)
    log.notes.extend(rest.notes if turns is not None else ())
    return log.rows.expanded(followed(log, rest.rest, turns, Path(start), stands))


def followed(
    log: LegLog, rest: Mask, turns: Turns | None, path: Path, stands: Mask | None, *, on: bool = False
) -> Odometry:
    """Return the trajectory where the robot stands; `on` goes on with the segment of the path."""
    moments, count = log.moments, len(log.moments)
    stands = log.ground.stands if stands is None else log.ground.stands & stands
    segment = _segments(moments, log.known if turns is None else log.known & turns.near, stands, log.longest_gap)
    T_world_base, T_world_support = np.full((2, count, 4, 4), np.nan)
    covariance, velocity = np.full((count, 3, 3), np.nan), np.full((count, 3), np.nan)
    for k in range(int(segment.max(initial=-1)) + 1):
        own = np.flatnonzero(segment == k) if count > 1 else slice(None)
        if not on:
            path.begin(log.T_base_soles[own][0], int(log.support[own][0]))
        T_world_base[own], T_world_support[own], pose, covariance[own] = path.extend(
            log.T_base_soles[own],
            log.support[own],
            moments[own],
            rest[own],
            None if turns is None else Turns(turns.rates[own], turns.near[own], turns.deviation[own]),
        )
        segment[own] = path.segment
        if count > 1:
            velocity[own] = _velocity(pose, moments[own])
    support = np.where(segment >= 0, log.support, -1)
    if not log.legs.flat:
        T_world_support[:, 2, 3] -= log.legs.heights[support]
    found = T_world_base, log.legs.feet.names, support, T_world_support, segment, covariance, velocity
    return Odometry(moments, *found, tuple(log.notes))


def _segments(moments: Floats, known: Mask, stands: Mask, longest_gap: float) -> NDArray[np.intp]:
    """Return the number of the segment of each row, −1 for none, shape (n,)."""
    used = known & stands
    segment = used - 1  # for a single row
    rows = np.flatnonzero(used)
    if len(moments) > 1:
        lifted = np.cumsum(~stands)[rows]
        new = (np.diff(moments[rows]) > longest_gap) | (np.diff(lifted) > 0)
        segment[rows] = np.concatenate([[0], np.cumsum(new)])
    return segment


def _velocity(pose: Floats, moments: Floats) -> Floats:
    """Return the mean velocity about each row, ahead, to the left and of the heading, shape (n, 3)."""
    before, after = (np.clip(moments + sign * OVER / 2.0, moments[0], moments[-1]) for sign in (-1.0, 1.0))
    ways = [np.interp(after, moments, column) - np.interp(before, moments, column) for column in pose.T]
    with np.errstate(invalid="ignore"):
        return np.column_stack(ahead(ways / (after - before), pose[:, 2]))


def ahead(way: Sequence[Column], heading: Column) -> tuple[Column, Column, Column]:
    """Return a way on the floor and its turn, as seen by a robot with a heading."""
    (x, y, turn), (c, s) = way, cosine_sine(heading)
    return c * x + s * y, c * y - s * x, turn
