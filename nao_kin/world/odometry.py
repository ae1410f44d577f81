"""Odometry of a walking robot: the trajectory of its trunk from a log of its joints.

One sole at a time is the support: flat on the floor, and in place. Its leg carries the trunk. When the support
changes, the other sole is put flat on the floor where it is. Rows in which no sole is in place are left out: the
trajectory consists of segments.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, between_samples, check_tolerance, join_poses, rigid_inverse, shaped
from nao_kin._core.text import one_line_repr
from nao_kin.errors import WrongShape
from nao_kin.robot import Feet, RobotModel, serial_chain
from nao_kin.rotations import log, rot_z
from nao_kin.screws import rigid_poses
from nao_kin.world.balance import feet_frame
from nao_kin.world.sensors import Ground, Mask, Rows, Sensor, bridged, corrected

# Values of a sensor, and in which rows they are known.
Measured = tuple[Floats, Mask]

# The covariance grows with each step by these deviations [m, rad], without a gyrometer also by that of the heading, and
# with the distance by a common error of scale, as slip makes it. With a gyrometer the heading diffuses [rad/√s].
# Source: simulated walks with encoder noise of 0.1 to 0.3° and slip (docs/balance.md).
_STEP, _STEP_TURN, _SCALE, _GYRO_DRIFT = 0.003, np.radians(0.5), 0.03, np.radians(0.3)
# Time over which the velocity is a mean [s]: a quarter of a step.
_OVER = 0.2
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
            step by 3 mm and 0.5°, and with the way from there by 3 %; with a gyrometer by 0.3° in a second instead of
            0.5° in a step.
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
    support turns about its origin where its leg disagrees. Roll and pitch are always those of a flat sole. Subtract the
    gyrometer's bias, as measured at rest, first; `state` does so, and takes roll and pitch from the inertial unit.

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
    return log.rows.expanded(log.followed(log.gyro(gyro), start, stands))


def _trajectory(
    T_base_soles: Floats, support: NDArray[np.intp], moments: Floats, turns: Floats | None, T_world_sole: Floats
) -> tuple[Floats, Floats]:
    """Return the poses of the root link and of the support, shape (n, 4, 4), in the n rows of a segment.

    `T_world_sole` is the pose of the first support.
    """
    T_soles_base = rigid_inverse(T_base_soles)
    T_world_base, T_world_support = np.empty((2, len(support), 4, 4))
    changes = [0, *(np.flatnonzero(np.diff(support)) + 1).tolist(), len(support)]
    for begin, end in itertools.pairwise(changes):
        sole = support[begin]
        if begin:
            # The row before still belongs to the former support: where both legs agree best.
            T_world_sole = on_floor(T_world_base[begin - 1] @ T_base_soles[begin - 1, sole])
        back = max(begin - 1, 0)
        legs = T_world_sole @ T_soles_base[back:end, sole]
        placed = np.broadcast_to(T_world_sole, legs.shape)
        if turns is not None:
            heading = np.concatenate([[0.0], np.cumsum(_slips(legs, turns[back:end], np.diff(moments[back:end])))])
            slip = join_poses(rot_z(heading), np.zeros(3))
            about = join_poses(np.eye(3), T_world_sole[:3, 3])
            turned = about @ slip @ rigid_inverse(about)
            legs, placed = turned @ legs, turned @ placed
        T_world_base[begin:end], T_world_support[begin:end] = legs[begin - back :], placed[begin - back :]
        T_world_sole = placed[-1]
    return T_world_base, T_world_support


# --- What a log has: times, rows without values, soles that touch or carry.


def _filled(robot: RobotModel, values: Floats, soles: Sequence[str]) -> tuple[Floats, Mask]:
    """Return configurations (n, nq), interpolated where they are NaN, and in which rows the soles' joints are known."""
    gaps = np.isnan(values)
    moving = {name for sole in soles for name in serial_chain(robot, robot.tree.root, sole).coordinates}
    columns = [robot.nq_base + k for k, name in enumerate(robot.joint_names) if name in moving]
    filled = between_samples(values)
    return robot.checked(np.where(np.isnan(filled), robot.neutral(), filled)), np.asarray(~gaps[:, columns].any(axis=1))


@dataclass(frozen=True, eq=False)
class LegLog:
    """A checked log of n rows: what its joints say about the soles, and contacts or forces about the ground.

    Attributes:
        feet: the s soles.
        rows: the rows with a time of their own, n of them.
        q: configurations, interpolated where they are NaN, shape (n, nq).
        T_base_soles: poses of the soles in the root link, on the ground, shape (n, s, 4, 4).
        ground: contacts or forces.
        known: in which rows the values of the legs and of the ground are known, shape (n,).
        longest_gap: largest time between two rows of a segment [s].
        notes: what is odd about the sensors.
    """

    feet: Feet
    rows: Rows
    q: Floats
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
        configurations, known = _filled(robot, rows.merged(values), feet.names)
        check_tolerance(longest_gap, "longest_gap")
        notes = list(rows.notes)
        T_base_soles = feet.on_ground(np.asarray(robot.fk(configurations, feet.names, reference=robot.tree.root)))
        forces = corrected(robot, "forces", forces)
        ground = Ground.of(robot, feet, T_base_soles, known, rows, contacts, forces, longest_gap, notes)
        known = known & ground.known
        return LegLog(feet, rows, configurations, T_base_soles, ground, known, float(longest_gap), notes)

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

    def gyro(self, gyro: ArrayLike | None) -> Measured | None:
        """Return the angular velocity (n, 3), and where it is known, as in `measured`."""
        if gyro is None:
            return None
        hint = ": are these deg/s? A heading such as GyroX [deg/s] says so"
        return self.measured(self.rows.read(gyro, 3, "gyro"), "gyro", most=_FASTEST, hint=hint)

    def _turns(self, *, about_all: bool) -> bool:
        """Return whether the legs turn the root link, about the vertical too or not."""
        path = self.followed(None, None, None)
        R = path.T_world_base[path.valid, :3, :3]
        turns = R.reshape(-1, 9) if about_all else R[:, 2]
        return len(R) > 0 and bool((np.diff(np.percentile(turns, [1.0, 99.0], axis=0), axis=0) > _TURNED).any())

    def followed(self, turns: Measured | None, start: ArrayLike | None, valid: Mask | None) -> Odometry:
        """Return the trajectory, with `start` of `odometry`, `measured` turns, and rows in which the robot stands."""
        moments, count = self.moments, len(self.moments)
        stands, known, rates = self.ground.stands, self.known, None
        if valid is not None:
            stands = stands & valid
        if turns is not None:
            rates, known = turns[0], known & turns[1]
        segment = _segments(moments, known, stands, self.longest_gap)

        T_world_feet, T_world_first = np.eye(4), None
        if start is not None:
            T_world_first = rigid_poses(shaped(start, (4, 4), "start"), "start")
        T_world_base, T_world_support = np.full((2, count, 4, 4), np.nan)
        support = np.full(count, -1)
        covariance, velocity = np.full((count, 3, 3), np.nan), np.full((count, 3), np.nan)
        for k in range(segment.max(initial=-1) + 1):
            own = np.flatnonzero(segment == k)
            T_soles, at = self.T_base_soles[own], moments[own]
            support[own] = self.ground.supports(own, T_soles)
            first = T_soles[0, support[own[0]]]
            if T_world_first is None:
                frame = feet_frame(rigid_inverse(first) @ T_soles[0])
                frame[2, 3] = 0.0
                T_world_sole = T_world_feet @ rigid_inverse(frame)
            else:
                T_world_sole, T_world_first = on_floor(T_world_first @ first), None
            T, T_world_support[own] = _trajectory(
                T_soles, support[own], at, None if rates is None else rates[own], T_world_sole
            )
            T_world_base[own] = T
            T_world_feet = on_floor(feet_frame(T[-1] @ T_soles[-1]))
            pose = np.column_stack([T[:, :2, 3], np.unwrap(np.arctan2(T[:, 1, 0], T[:, 0, 0]))])
            stepped = np.diff(support[own], prepend=support[own[0]]) != 0
            covariance[own] = _covariance(pose, at, stepped, by_gyro=rates is not None)
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


def _slips(T_world_base: Floats, gyro: Floats, steps: Floats) -> Floats:
    """Return how much farther the gyrometer turned about the vertical than the leg did, from row to row [rad]."""
    if not len(steps):
        return np.empty(0)
    R = T_world_base[:, :3, :3]
    by_leg = log(R[1:] @ R[:-1].swapaxes(-1, -2))[:, 2]
    measured = 0.5 * np.einsum("ni,ni->n", R[:, 2], gyro)
    return np.asarray((measured[1:] + measured[:-1]) * steps - by_leg)


def on_floor(T: Floats) -> Floats:
    """Return a pose on the floor below, with the same heading."""
    return join_poses(rot_z(np.arctan2(T[1, 0], T[0, 0])), T[:3, 3] * [1.0, 1.0, 0.0])


def _velocity(pose: Floats, moments: Floats) -> Floats:
    """Return the mean velocity about each row, ahead, to the left and of the heading, shape (n, 3)."""
    before, after = (np.clip(moments + sign * _OVER / 2.0, moments[0], moments[-1]) for sign in (-1.0, 1.0))
    ways = [np.interp(after, moments, column) - np.interp(before, moments, column) for column in pose.T]
    with np.errstate(invalid="ignore"):
        x, y, turn = ways / (after - before)
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    return np.column_stack([c * x + s * y, c * y - s * x, turn])


def _covariance(pose: Floats, moments: Floats, stepped: Mask, *, by_gyro: bool) -> Floats:
    """Return the covariance of the pose of each row relative to the first one, shape (n, 3, 3).

    An error of the heading at row i moves row n by (−(y_n − y_i), x_n − x_i) times the error; the sums over i are
    those of powers of x_i and y_i.
    """
    x, y, heading = (pose - pose[0]).T
    turning = _GYRO_DRIFT**2 * np.diff(moments, prepend=moments[0]) if by_gyro else _STEP_TURN**2 * stepped
    moved = np.cumsum(_STEP**2 * stepped)
    q, qx, qy, qxx, qxy, qyy = np.cumsum([turning * by for by in (1.0, x, y, x * x, x * y, y * y)], axis=1)
    xx, yy = moved + y * y * q - 2.0 * y * qy + qyy, moved + x * x * q - 2.0 * x * qx + qxx
    xy, xt, yt = -(x * y * q - x * qy - y * qx + qxy), qy - y * q, x * q - qx
    found = np.stack([xx, xy, xt, xy, yy, yt, xt, yt, q], axis=-1).reshape(-1, 3, 3)
    scaled = _SCALE * np.column_stack([x, y, np.zeros(len(x)) if by_gyro else heading])
    return found + scaled[:, :, None] * scaled[:, None, :]
