"""What a robot is doing, from a log: its support, posture and pose, as teams compute them on the robot.

The inertial unit gives the direction of the vertical in the root link, the support sole its height, and odometry its
place and heading. Sensors of other conventions are recognised where this is possible: the sign of an accelerometer by
the legs, the bias of a gyrometer from rows in which the robot is at rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import TOUCHING, Floats, join_poses
from nao_kin._core.text import one_line_repr
from nao_kin.errors import BadArgument
from nao_kin.robot import Feet, RobotModel
from nao_kin.rotations import exp, matrix_from_rpy, rot_z
from nao_kin.world.odometry import LegLog, Measured, Odometry
from nao_kin.world.sensors import Ground, Mask, corrected, debounced, sole_heights

# Tilt of the root link from which a robot that does not stand flat on a sole is falling, lies, and is upright again,
# and from which it lies in any case. Between a standing robot that bends (up to 60° in Aldebaran's animations) and one
# that lies (83 to 90° in NAO's postures).
_FALLING, _LYING, _UPRIGHT_AGAIN, _SURELY_LYING = np.radians([30.0, 50.0, 30.0, 80.0])
# Angle between the vertical and the normal of a sole up to which the sole is flat on the floor: errors of joints,
# inertial unit and floor are below, and a robot that tilts so far over an edge of its sole falls.
_FLAT = np.radians(15.0)
# A fall lasts longer than _BRIEF; a robot without contact before or after a fall is lifted from _SHORT on [s].
_BRIEF, _SHORT = 0.1, 1.0
# Time constant of the filter of accelerometer and gyrometer [s]: longer than a step, shorter than the drift; and of
# the accelerometer alone, which shall follow a fall.
_TIME_CONSTANT, _ALONE = 1.0, 0.2
# The accelerometer is not used where its length differs from its median by more than this share: impacts, falls.
_SHAKEN = 0.2
# An inertial unit is not used if its vertical is so far from the normals of all soles in more than this share of the
# rows in which they carry.
_ASKEW, _SOME = np.radians(45.0), 0.1
# The accelerometer's sign is that of rows in which it is along the soles' normals up to 25°, in either direction: the
# soles of a robot that lies on its belly are turned by 135° from the vertical.
_ALONG = 0.9
# A robot is at rest where the means of its joints change by less than _STILL [rad] from each _REST [s] to the
# next, and the gyrometer shows less than _SLOW on average and varies by less than _QUIET [rad/s].
_REST, _STILL, _SLOW, _QUIET = 0.5, np.radians(0.3), 0.1, 0.05
# Deviations of roll, pitch [rad] and height [m] by errors of the joints' zeros, up to a degree (docs/calibration.md);
# of roll and pitch at least a third of it.
_BY_LEGS, _LEAST_ANGLE, _BY_LENGTH = np.radians(1.0), np.radians(0.3), 0.002
# A robot walks between two changes of its support that follow each other within this time [s].
_LONGEST_STEP = 1.0


@one_line_repr
@dataclass(frozen=True, eq=False)
class State:
    """What a robot does in each row of a log.

    Attributes:
        times: times of the n rows [s].
        soles: names of the s soles.
        posture: "upright"; "falling", also while it gets up; where it lies, the side that is down: "front", "back",
            "left" or "right"; "unknown" without values; shape (n,).
        contact: whether the robot is on the floor with its soles, shape (n,). An upright robot without contact is
            lifted, or sits.
        carrying: which soles carry it, shape (n, s).
        up: the vertical in the root link, a unit vector, shape (n, 3); NaN where it is not known.
        T_world_base: pose of the root link, shape (n, 4, 4): roll and pitch are those of `up`, heading, x and y those
            of `odometry`, and the origin of the support sole is on the floor. NaN where not `valid`.
        covariance: of roll, pitch and height, shape (n, 3, 3) [rad, m]; the covariance of x, y and heading is that of
            `odometry`. Roll and pitch have the mean square difference between inertial unit and support sole in the
            log, at least 0.3°; without inertial unit 1°.
        forces: force on each sole, shape (n, s), NaN for a sole whose sensors are not used; 0 or 1 for contacts, 1
            without them.
        sole_pressure: centre of pressure on each sole in the sole's frame, x and y, shape (n, s, 2) [m]; NaN where the
            sole carries nothing, or without the forces of its sensors.
        centre_of_pressure: of all soles, x and y in the world, shape (n, 2) [m].
        odometry: path, velocity, covariance and segments.
        notes: what was assumed about the sensors, what is odd about them, and what was therefore not used.
        longest_gap: largest time between two rows that counts in `seconds` [s].
    """

    times: Floats
    soles: tuple[str, ...]
    posture: NDArray[Any]
    contact: Mask
    carrying: Mask
    up: Floats
    T_world_base: Floats
    covariance: Floats
    forces: Floats
    sole_pressure: Floats
    centre_of_pressure: Floats
    odometry: Odometry
    notes: tuple[str, ...]
    longest_gap: float

    @property
    def valid(self) -> Mask:
        """In which rows the robot stands or walks, so that its pose is known, shape (n,)."""
        return self.odometry.valid

    @property
    def support(self) -> NDArray[Any]:
        """The soles that carry the robot, by name, "both" for all of several, or "none", shape (n,)."""
        found = np.full(len(self.times), "none", dtype=f"<U{max(4, *map(len, self.soles))}")
        for k, name in enumerate(self.soles):
            found[self.carrying[:, k]] = name
        found[self.carrying.sum(axis=1) > 1] = "both"
        return found

    @property
    def roll_pitch(self) -> Floats:
        """Roll and pitch of the root link, R = Ry(pitch) Rx(roll), AngleX and AngleY of a NAO, shape (n, 2) [rad]."""
        return _roll_pitch(self.up)

    @property
    def walking(self) -> Mask:
        """Which rows are between two changes of the support within 1 s, shape (n,)."""
        at = self.times[self.odometry.steps]
        if len(at) < 2:
            return np.zeros(len(self.times), dtype=np.bool_)
        after = np.searchsorted(at, self.times, side="right")
        between = (after > 0) & (after < len(at))
        lasting = at[np.minimum(after, len(at) - 1)] - at[np.maximum(after - 1, 0)]
        return np.asarray(between & (lasting <= _LONGEST_STEP) & self.valid)

    @property
    def seconds(self) -> dict[str, float]:
        """How long the robot was standing, walking, lifted, falling, lying, and in a state that is unknown [s]."""
        steps = np.diff(self.times, append=self.times[-1])
        steps[steps > self.longest_gap] = 0.0
        lying = np.isin(self.posture, ("front", "back", "left", "right"))
        rows = {
            "standing": self.valid & ~self.walking,
            "walking": self.walking,
            "lifted": (self.posture == "upright") & ~self.contact,
            "falling": self.posture == "falling",
            "lying": lying,
        }
        rows["unknown"] = ~np.logical_or.reduce(list(rows.values()))
        return {name: float(steps[mask].sum()) for name, mask in rows.items()}


def state(
    robot: RobotModel,
    q: ArrayLike,
    *,
    times: ArrayLike,
    soles: Sequence[str] | None = None,
    contacts: ArrayLike | None = None,
    forces: ArrayLike | None = None,
    angles: ArrayLike | None = None,
    accelerometer: ArrayLike | None = None,
    gyro: ArrayLike | None = None,
    start: ArrayLike | None = None,
    longest_gap: float = 0.5,
) -> State:
    """Return what a robot does in each row of a log: support, contact, posture, pose with covariance, and odometry.

    The vertical in the root link comes from `angles`, the filtered angles of NAOqi, or from `accelerometer` and `gyro`:
    a complementary filter with a time constant of 1 s, du/dt = u × ω + (a/‖a‖ − u)/τ, forwards and backwards in time,
    so that a constant bias of the gyrometer cancels. Without either, the support sole is level.

    A sole is flat on the floor if its normal is within 15° of the vertical. A robot that is in contact and flat on a
    sole stands, however far it bends; otherwise it falls from a tilt of 30° on, or over an edge of its sole, and lies
    from 50° on until its tilt is below 30°. Without an inertial unit a tilt of more than 50° is unknown: the joints
    alone do not show whether a robot lies. Contact is lost after 0.2 s in which the soles carry less than 20 % of the
    weight, and found after 0.1 s. Without contacts and forces, a robot is in contact where it is upright and flat.

    NaN is accepted, and odd sensors are not used, as in `odometry`; so is an inertial unit whose vertical is more than
    45° from the normals of the soles while these carry the robot. Errors of sensors that the robot's file states
    (`nk.robot.read_offsets`) are corrected.

    Args:
        robot: any robot whose semantics name soles, or for which `soles` does.
        q: configurations, shape (n, nq).
        times: of the rows, ascending; rows with one time are one row [s].
        soles: as in `odometry`, like `contacts`, `forces`, `start` and `longest_gap`.
        contacts: whether each sole touches the floor, shape (n, s).
        forces: force on each sole or on each sensor, shape (n, s) or (n, f) [kg, N or shares of the weight].
        angles: roll and pitch of the root link, AngleX and AngleY of NAOqi, R = Ry(AngleY) Rx(AngleX), shape (n, 2)
            [rad]. AngleX is positive when the robot leans to its right, AngleY when it leans forwards.
        accelerometer: in the axes of the root link, shape (n, 3), any unit. Its z is positive in a standing robot, as
            ROS and this library's virtual NAO have it (9.8 m/s²), or negative, as LoLA of NAO V6 has it: the sign that
            agrees with the legs is used.
        gyro: angular velocity in the axes of the root link, shape (n, 3) [rad/s], x positive when the robot turns to
            its right side, y forwards, z to the left. Its mean in rows at rest is its bias, and is subtracted.
        start: pose of the root link at the first valid row, shape (4, 4).
        longest_gap: largest time between two rows of a segment [s].

    Raises:
        BadArgument: times that go back, contacts and forces, angles and an accelerometer, a robot without soles.
        WrongShape: arrays of different lengths.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = np.tile(nao.posture("StandInit"), (100, 1))
        >>> lean = np.tile([0.0, np.radians(3.0)], (100, 1))
        >>> found = nk.world.state(nao, q, times=0.01 * np.arange(100), angles=lean, forces=np.full((100, 2), 2.7))
        >>> found.posture[0].item(), found.support[0].item(), found.seconds["standing"]
        ('upright', 'both', 0.99)
        >>> found.T_world_base[0, 2, 3].round(3).item()
        0.32

    Source: AngleX, AngleY and the axes: doc.aldebaran.com/2-8, inertial_naov6; signs of V6: docs.ros.org,
    nao_sensor_msgs; the negative accelerometer: B-Human's NaoProvider.cpp (d89d603), which changes LoLA's sign.
    """
    angles, gyro = corrected(robot, "angles", angles), corrected(robot, "gyro", gyro)
    accelerometer = corrected(robot, "accelerometer", accelerometer)
    log = LegLog.of(robot, times, q, soles, contacts, forces, longest_gap)
    ground, T_base_soles, rows = log.ground, log.T_base_soles, np.arange(len(log.moments))
    support = ground.supports(rows, T_base_soles)
    turns = _without_bias(log, log.gyro(gyro))
    measured = _vertical(log, angles, accelerometer, turns)
    up = T_base_soles[rows, support, :3, 2] if measured is None else measured
    carrying = _carrying(log, support)
    flat = (np.einsum("nsi,ni->ns", T_base_soles[..., :3, 2], up) >= np.cos(_FLAT)) & carrying
    posture = _postures(up, ground.stands & flat.any(axis=1), log, by_legs=measured is None)
    contact = (posture == "upright") & ground.stands
    path = log.followed(turns, start, contact)
    tilt, R_level_base = _roll_pitch(up), np.full((len(rows), 3, 3), np.nan)
    valid = path.valid
    R_level_base[valid] = matrix_from_rpy(np.pad(tilt[valid], ((0, 0), (0, 1))))
    T_world_base, lever = np.full((len(rows), 4, 4), np.nan), T_base_soles[rows, path.support, :3, 3]
    R = rot_z(path.pose[valid, 2]) @ R_level_base[valid]
    place = path.T_world_support[valid, :3, 3] * [1.0, 1.0, 0.0] - np.einsum("nij,nj->ni", R, lever[valid])
    T_world_base[valid] = join_poses(R, place)
    legs = None if measured is None else _roll_pitch(T_base_soles[rows, path.support, :3, 2])
    pressure = _sole_pressure(robot, log.feet, ground)
    found = State(
        times=log.moments,
        soles=log.feet.names,
        posture=posture,
        contact=contact,
        carrying=carrying & contact[:, None],
        up=up,
        T_world_base=T_world_base,
        covariance=_covariance(tilt, lever, legs, valid),
        forces=ground.pressed,
        sole_pressure=pressure,
        centre_of_pressure=_centre(T_world_base, T_base_soles, pressure, ground.pressed),
        odometry=log.rows.expanded(path),
        notes=path.notes,
        longest_gap=longest_gap,
    )
    return log.rows.expanded(found)


def _carrying(log: LegLog, support: NDArray[np.intp]) -> Mask:
    """Return which soles carry the robot or, from the joints alone, are as low as the support, shape (n, s)."""
    if log.ground.rule == "joints":
        heights = sole_heights(log.T_base_soles)[np.arange(len(support)), support]
        return np.asarray(np.abs(heights) <= TOUCHING)
    return log.feet.loaded(log.ground.pressed)


def _without_bias(log: LegLog, gyro: Measured | None) -> Measured | None:
    """Return the gyrometer (n, 3) without its mean in rows at rest, and where it is known; add a note."""
    if gyro is None:
        return None
    turns, near = gyro
    bins = np.unique(np.floor((log.moments - log.moments[0]) / _REST), return_inverse=True)[1]
    used = log.known & near & log.ground.stands
    counts = np.bincount(bins[used], minlength=bins[-1] + 1)

    def means(values: Floats) -> Floats:
        sums = [np.bincount(bins[used], column[used], len(counts)) for column in values.T]
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.transpose(sums) / counts[:, None]

    joints, mean = means(log.q), means(turns)
    deviation = np.sqrt(np.maximum(means(turns**2) - mean**2, 0.0))
    still = np.abs(np.diff(joints, axis=0)).max(axis=1, initial=0.0) < _STILL
    rest = (counts > 1) & (np.abs(mean).max(axis=1) < _SLOW) & (deviation.max(axis=1) < _QUIET)
    rest &= np.append(True, still) & np.append(still, True)
    rows = used & rest[bins]
    if rest.sum() > 1:
        bias = turns[rows].mean(axis=0)
        shown = ", ".join(f"{value:.4f}" for value in bias)
        log.notes.append(f"the gyrometer's mean at rest, {shown} rad/s, is subtracted")
        turns = turns - bias
    return turns, near


def _vertical(
    log: LegLog, angles: ArrayLike | None, accelerometer: ArrayLike | None, turns: Measured | None
) -> Floats | None:
    """Return the vertical in the root link (n, 3), NaN where it is not known; None without inertial unit to use."""
    if angles is not None and accelerometer is not None:
        raise BadArgument("give angles or an accelerometer, not both")
    ground, normals = log.ground, log.T_base_soles[..., :3, 2]
    if angles is not None:
        what = "angles"
        found = log.measured(log.rows.read(angles, 2, what), what, most=np.pi, hint=": are these degrees?")
        if found is None:
            return None
        tilt, near = found
        up = matrix_from_rpy(np.pad(tilt, ((0, 0), (0, 1))))[:, 2]
    elif accelerometer is not None:
        what, force = "accelerometer", log.rows.read(accelerometer, 3, "accelerometer")
        force[~force.any(axis=1)] = np.nan
        normal = normals.mean(axis=1)
        with np.errstate(invalid="ignore"):
            sure = np.abs(np.einsum("ni,ni->n", force, normal)) > _ALONG * np.linalg.norm(force, axis=1)
        along = np.where((sure & ground.stands)[:, None], normal, 0.0)
        found = log.measured(force, what, hint=", as LoLA has it", along=along)
        if found is None:
            return None
        force, near = found
        size = np.linalg.norm(force, axis=1)
        seen = near & (size > 0.0)
        used = np.where(seen, np.maximum(0.0, 1.0 - np.abs(size / np.median(size[seen]) - 1.0) / _SHAKEN), 0.0)
        direction, rates = force / np.where(seen, size, 1.0)[:, None], None if turns is None else turns[0]
        up = _filtered(direction, used, rates, log.moments, log.longest_gap)
    else:
        return None
    up = np.where(near[:, None], up, np.nan)
    if ground.rule == "forces":
        carries = log.known & near & ground.stands
        leaning = (np.einsum("nsi,ni->ns", normals, up).max(axis=1) < np.cos(_ASKEW))[carries]
        if leaning.sum() > _SOME * len(leaning):
            log.notes.append(f"{what}: in contradiction to the legs and the forces; not used")
            return None
    return up


def _filtered(direction: Floats, used: Floats, turns: Floats | None, moments: Floats, longest_gap: float) -> Floats:
    """Return the vertical (n, 3) from directions of the accelerometer (n, 3), used by their weights (n,), and turns.

    At its beginning the filter is a mean. It runs forwards and backwards, and the results count as much as the rows
    that they have averaged.
    """
    steps = np.diff(moments)
    rate = np.zeros((len(steps), 3)) if turns is None else 0.5 * np.nan_to_num(turns[1:] + turns[:-1])
    # From row to row the vertical, seen from the root link, turns by the opposite of the root link's turn.
    forwards = exp(-rate * steps[:, None])
    longest = _ALONE if turns is None else _TIME_CONSTANT
    gain = 1.0 - np.exp(-used * np.append(steps, np.median(steps) if len(steps) else 0.0) / longest)
    total, weights = np.zeros((len(moments), 3)), np.zeros(len(moments))
    for order, R in ((slice(None), forwards), (slice(None, None, -1), forwards.swapaxes(1, 2)[::-1])):
        restarts = np.append(True, steps[order] > longest_gap)
        found, count = _followed(direction[order], used[order], gain[order], R, restarts)
        total[order] += found * count[:, None]
        weights[order] += count
    size = np.linalg.norm(total, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(weights[:, None] > 0.0, total / size[:, None], np.nan))


def _followed(direction: Floats, used: Floats, gain: Floats, R: Floats, restarts: Mask) -> tuple[Floats, Floats]:
    """Return the filter's vertical (n, 3), and how many rows it has averaged (n,), in the order of the rows."""
    x = y = z = averaged = 0.0
    xs, ys, zs, counts = (np.zeros(len(used)) for _ in range(4))
    turning = np.concatenate([np.eye(3)[None], R]).reshape(-1, 9)
    # Lists of numbers, one for each column, take a third of the time of a list for each row.
    columns = [column.tolist() for column in (*direction.T, used, gain, restarts, *turning.T)]
    for k, (a, b, c, weight, least, restart, r0, r1, r2, r3, r4, r5, r6, r7, r8) in enumerate(
        zip(*columns, strict=True)
    ):
        if restart:
            x = y = z = averaged = 0.0
        x, y, z = r0 * x + r1 * y + r2 * z, r3 * x + r4 * y + r5 * z, r6 * x + r7 * y + r8 * z
        if weight > 0.0:
            averaged += weight
            part = max(least, weight / averaged)
            x, y, z = x + part * (a - x), y + part * (b - y), z + part * (c - z)
            averaged = weight / part
        xs[k], ys[k], zs[k], counts[k] = x, y, z, averaged
    return np.column_stack([xs, ys, zs]), counts


def _roll_pitch(up: Floats) -> Floats:
    """Return roll and pitch of verticals (n, 3) in the root link, shape (n, 2) [rad]."""
    x, y, z = up.T
    return np.column_stack([np.arctan2(y, z), np.arctan2(-x, np.hypot(y, z))])


def _postures(up: Floats, supported: Mask, log: LegLog, *, by_legs: bool) -> NDArray[Any]:
    """Return the posture of each row, from the vertical in the root link (n, 3), and rows that stand on a flat sole."""
    known = np.isfinite(up).all(axis=1)
    with np.errstate(invalid="ignore"):
        tilt = np.where(known, np.arccos(np.clip(up[:, 2], -1.0, 1.0)), 0.0)
    if by_legs:
        return np.where(known & (tilt <= _LYING), "upright", "unknown")
    # Rows that begin or end a time of lying; between them the last one counts.
    lies = (tilt > _SURELY_LYING) | (tilt > _LYING) & ~supported
    decided = lies | (tilt < _UPRIGHT_AGAIN) | supported
    last = np.maximum.accumulate(np.where(decided, np.arange(len(tilt)), 0))
    lying = lies[last]
    falls = ~lying & ~supported & ((tilt > _FALLING) | log.ground.stands)
    falls = debounced(falls, log.moments, True, _BRIEF)
    # A short time without contact before or after a fall belongs to it; otherwise the robot is lifted.
    loose = ~lying & ~falls & ~log.ground.stands
    short = loose & ~debounced(loose, log.moments, True, _SHORT)
    rows, down = np.arange(len(tilt)), lying | falls
    before = np.maximum.accumulate(np.where(short, 0, rows))
    after = np.minimum.accumulate(np.where(short, len(tilt) - 1, rows)[::-1])[::-1]
    falls |= short & (down[before] | down[after])
    x, y = np.nan_to_num(up[:, :2]).T
    side = np.where(np.abs(x) >= np.abs(y), np.where(x < 0.0, "front", "back"), np.where(y < 0.0, "left", "right"))
    return np.where(~known, "unknown", np.where(lying, side, np.where(falls, "falling", "upright")))


def _sole_pressure(robot: RobotModel, feet: Feet, ground: Ground) -> Floats:
    """Return the centre of pressure on each sole in its frame, shape (n, s, 2); NaN without forces of its sensors."""
    found = np.full((*ground.pressed.shape, 2), np.nan)
    if ground.sensors is not None:
        sensors = robot.semantics.force_sensors
        for k, (name, own) in enumerate(zip(feet.names, feet.carried(robot, sensors), strict=True)):
            places = robot.fk(robot.neutral(), np.array(sensors)[own].tolist(), reference=name)[:, :2, 3]
            with np.errstate(invalid="ignore", divide="ignore"):
                found[:, k] = ground.sensors[:, own] @ places / ground.pressed[:, k, None]
    return found


def _centre(T_world_base: Floats, T_base_soles: Floats, pressure: Floats, pressed: Floats) -> Floats:
    """Return the centre of pressure of all soles in the world, x and y, shape (n, 2)."""
    T = T_world_base[:, None] @ T_base_soles
    places = np.einsum("nsij,nsj->nsi", T[..., :2, :2], pressure) + T[..., :2, 3]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(
            np.where(pressed[..., None] > 0.0, places * pressed[..., None], 0.0).sum(axis=1)
            / pressed.sum(axis=1, keepdims=True)
        )


def _covariance(tilt: Floats, lever: Floats, legs: Floats | None, valid: Mask) -> Floats:
    """Return the covariance of roll, pitch and height, shape (n, 3, 3), NaN where not valid.

    The height is −up · lever, with the support sole at the `lever` (n, 3) in the root link; `legs` are roll and pitch
    by the support sole (n, 2), None if `tilt` is.
    """
    found = np.full((len(tilt), 3, 3), np.nan)
    if not valid.any():
        return found
    angles = np.eye(2) * _BY_LEGS**2
    if legs is not None:
        difference = (tilt - legs)[valid]
        angles = difference.T @ difference / len(difference) + np.eye(2) * _LEAST_ANGLE**2
    roll, pitch = tilt[valid].T
    x, y, z = lever[valid].T
    by_roll = -np.cos(pitch) * (np.cos(roll) * y - np.sin(roll) * z)
    by_pitch = np.cos(pitch) * x + np.sin(pitch) * (np.sin(roll) * y + np.cos(roll) * z)
    J = np.zeros((len(roll), 3, 2))
    J[:, 0, 0] = J[:, 1, 1] = 1.0
    J[:, 2] = np.column_stack([by_roll, by_pitch])
    found[valid] = J @ angles @ J.swapaxes(1, 2)
    found[valid, 2, 2] += _BY_LENGTH**2
    return found
