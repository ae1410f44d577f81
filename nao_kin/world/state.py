"""What a robot is doing, from a log: its support, posture and pose, as teams compute them on the robot.

The inertial unit gives the direction of the vertical in the root link, the support sole its height, and odometry its
place and heading. Sensors of other conventions are recognised where this is possible: the sign of an accelerometer by
the legs, the bias of a gyrometer from rows in which the robot is at rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats
from nao_kin._core.text import one_line_repr
from nao_kin.errors import BadArgument
from nao_kin.robot import RobotModel
from nao_kin.rotations import matrix_from_rpy
from nao_kin.world.doing import DOINGS, Doing, Walk, decided
from nao_kin.world.legs import LegLog, Legs, centre_of_pressure
from nao_kin.world.odometry import Odometry, followed
from nao_kin.world.path import Column, Path, column, columns, cosine_sine, poses
from nao_kin.world.rest import Mask, Turns

# Angle between the vertical and the normal of a sole up to which the sole is flat on the floor: errors of joints,
# inertial unit and floor are below, and a robot that tilts so far over an edge of its sole falls. Without an inertial
# unit, a root link that is tilted by more than _UPRIGHT over its sole lies perhaps.
_FLAT, _UPRIGHT = np.radians([15.0, 50.0]).tolist()
# Time constant of the filter of accelerometer and gyrometer [s]: longer than a step, shorter than the drift; and of
# the accelerometer alone, which shall follow a fall.
TIME_CONSTANT, _ALONE = 1.0, 0.2
# The accelerometer is not used where its length differs from its median by more than this share: impacts, falls.
_SHAKEN = 0.2
# An inertial unit is not used if its vertical is so far from the normals of all soles in more than this share of the
# rows in which they carry.
_ASKEW, _SOME = np.radians(45.0), 0.1
# The accelerometer's sign is that of rows in which it is along the soles' normals up to 25°, in either direction: the
# soles of a robot that lies on its belly are turned by 135° from the vertical.
_ALONG = 0.9
# Deviations of roll, pitch [rad] and height [m] by errors of the joints' zeros, of a degree at each of the joints of a
# leg, of which two turn about the axis of roll and three and a half about that of pitch: 0.5, 0.6 and 1.7 mm in Stand,
# StandInit and Crouch (docs/calibration.md), and 0.5 mm by which a robot sinks; of roll and pitch by the bias of an
# inertial unit, 0.2 m/s². Without one, a sole may stand on its edge where its centre of pressure is not known, or
# beyond this share of the half width of its sensors.
_BY_LEGS, _BY_ROLL, _BY_PITCH, _BY_UNIT, _BY_EDGE = np.radians([1.7, 1.4, 1.9, 1.2, 4.0]).tolist()
_BY_LENGTH, _EDGE = 0.0012, 0.8
ONE = np.eye(2)
BY_JOINTS = "neither forces nor an inertial unit show whether the robot stands: it is taken to, where it is upright"


@one_line_repr
@dataclass(frozen=True, eq=False)
class State:
    """What a robot does in each row of a log.

    Attributes:
        times: times of the n rows [s].
        soles: names of the s soles.
        doing: "standing", "walking", "sitting", "lying", "falling", "lifted" (held upright in the air), "carried" (held
            in the air, tilted by more than 30°), or "unknown", shape (n,).
        carrying: which soles carry it, shape (n, s).
        up: the vertical in the root link, a unit vector, shape (n, 3); NaN where it is not known.
        T_world_base: pose of the root link, shape (n, 4, 4): roll and pitch are those of `up`, heading, x and y those
            of `odometry`, and the origin of the support sole is on the floor. NaN where not `valid`.
        covariance: of roll, pitch and height, shape (n, 3, 3) [rad, m]; the covariance of x, y and heading is that of
            `odometry`. Roll and pitch have 1°, as the bias of an inertial unit leaves it, and a third of the
            root mean square difference between the unit and the support sole in the log; without inertial unit 1.4°
            and 1.9°, and 4.2° and 4.4° where the sole may stand on its edge.
        T_base_soles: poses of the soles in the root link, on the ground, shape (n, s, 4, 4).
        forces: force on each sole, shape (n, s), NaN for a sole whose sensors are not used; 0 or 1 for contacts, 1
            without them.
        sole_pressure: centre of pressure on each sole in the sole's frame, x and y, shape (n, s, 2) [m]; NaN where the
            sole carries nothing, or without the forces of its sensors.
        odometry: path, velocity, covariance and segments.
        notes: what was assumed about the sensors, what is odd about them, and what was therefore not used.
        longest_gap: largest time between two rows that counts in `seconds` [s].
    """

    times: Floats
    soles: tuple[str, ...]
    doing: NDArray[Any]
    carrying: Mask
    up: Floats
    T_world_base: Floats
    covariance: Floats
    T_base_soles: Floats
    forces: Floats
    sole_pressure: Floats
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
    def centre_of_pressure(self) -> Floats:
        """Centre of pressure of all soles, x and y in the world, shape (n, 2) [m]."""
        return centre_of_pressure(self.T_world_base[:, None] @ self.T_base_soles, self.forces, self.sole_pressure)

    @property
    def roll_pitch(self) -> Floats:
        """Roll and pitch of the root link, R = Ry(pitch) Rx(roll), AngleX and AngleY of a NAO, shape (n, 2) [rad]."""
        return roll_pitch(self.up)

    @property
    def seconds(self) -> dict[str, float]:
        """How long the robot did what `doing` names [s]."""
        steps = np.diff(self.times, append=self.times[-1])
        steps[steps > self.longest_gap] = 0.0
        return {name: float(steps[self.doing == name].sum()) for name in DOINGS}


def state(
    robot: RobotModel,
    q: ArrayLike,
    times: ArrayLike,
    *,
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

    A robot stands on soles that carry and whose normals are within 15° of the vertical, however far it bends. It sits
    if its hips are low over its soles, or its soles carry less than half of its weight, and its trunk is quiet. It
    falls for less than a second, from a tilt of 30° or over an edge of its sole, and lies from 50° on until its tilt is
    below 30°; without such a turn, a tilted robot without load is carried, and an upright one lifted. Contact is lost
    after 0.2 s in which the soles carry less than 20 % of the weight, and found after 0.1 s.

    Without an inertial unit, a robot stands where its soles carry half of its weight and its tilt over the support is
    at most 50°, and everything else is unknown; without contacts and forces too, only the tilt counts.

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
            its right side, y forwards, z to the left. Its bias is found as in `odometry`.
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
        >>> found.doing[0].item(), found.support[0].item(), found.seconds["standing"]
        ('standing', 'both', 0.99)
        >>> found.T_world_base[0, 2, 3].round(3).item()
        0.32

    Source: AngleX, AngleY and the axes: doc.aldebaran.com/2-8, inertial_naov6; signs of V6: docs.ros.org,
    nao_sensor_msgs; the negative accelerometer: B-Human's NaoProvider.cpp (d89d603), which changes LoLA's sign.
    """
    log = LegLog.of(Legs(robot, soles), times, q, contacts, forces, longest_gap)
    turns, rest = log.turns(gyro)
    up = vertical(log, angles, accelerometer, turns)
    if turns is not None:
        log.notes.extend(rest.notes)
    elif up is not None:
        _, rest = log.turns(None, up)
    doing = done(log, up, rest.quiet, Doing())
    stands = doing == "standing"
    path = followed(log, rest.rest, turns, Path(start), stands)
    rows = zip((log.moments, path.support, lifts(log)), (np.inf, -1, 0.0), strict=True)  # nothing follows the log
    doing[decided(Walk(), *(np.append(*row) for row in rows))[:-1]] = "walking"
    unit = None
    if up is None:
        up = np.where(log.lost[:, None], np.nan, log.lever[..., :3, 2])
    else:
        away = (roll_pitch(up) - roll_pitch(log.lever[..., :3, 2]))[path.valid]
        unit = by_unit(away.T @ away / max(len(away), 1))
    found = stated(log, up, doing, stands, path, unit)
    return log.rows.expanded(replace(found, odometry=log.rows.expanded(path)))


def vertical(
    log: LegLog, angles: ArrayLike | None, accelerometer: ArrayLike | None, turns: Turns | None
) -> Floats | None:
    """Return the vertical in the root link (n, 3), NaN where it is not known; None without inertial unit to use."""
    if angles is not None and accelerometer is not None:
        raise BadArgument("give angles or an accelerometer, not both")
    ground, normals = log.ground, log.T_base_soles[..., :3, 2]
    if angles is not None:
        what, found = "angles", log.measured("angles", log.read("angles", angles))
        if found is None:
            return None
        tilt, near = found
        up = matrix_from_rpy(np.pad(tilt, ((0, 0), (0, 1))))[:, 2]
    elif accelerometer is not None:
        what, force = "accelerometer", log.read("accelerometer", accelerometer)
        force[~force.any(axis=1)] = np.nan
        normal = normals.mean(axis=1)
        with np.errstate(invalid="ignore"):
            sure = np.abs(np.einsum("ni,ni->n", force, normal)) > _ALONG * np.linalg.norm(force, axis=1)
        found = log.measured(what, force, along=np.where((sure & ground.stands)[:, None], normal, 0.0))
        if found is None:
            return None
        force, near = found
        size = np.linalg.norm(force, axis=1)
        seen = near & (size > 0.0)
        usual = np.median(size[seen])
        log.sensors[what].gain /= usual
        used = np.where(seen, trust(size / usual), 0.0)
        direction, rates = force / np.where(seen, size, 1.0)[:, None], None if turns is None else turns.rates
        up = _filtered(direction, used, rates, log.moments, log.longest_gap)
    else:
        return None
    up = np.where(near[:, None], up, np.nan)
    if ground.rule == "forces":
        carries = log.known & near & ground.heavy  # one that lies on its toes is light
        leaning = (np.einsum("nsi,ni->ns", normals, up).max(axis=1) < np.cos(_ASKEW))[carries]
        if leaning.sum() > _SOME * len(leaning):
            log.sensors[what].contradicts_the_legs()
            return None
    return up


def gain(used: Any, step: Any, *, gyro: bool) -> Any:
    """Return the share of an accelerometer's row, with its weight and the time from the row before, in the filter."""
    return 1.0 - np.exp(-used * step / (TIME_CONSTANT if gyro else _ALONE))


def trust(size: Any) -> Any:
    """Return the weight of an accelerometer's row from its length, usually 1: less for impacts and falls."""
    return np.maximum(0.0, 1.0 - np.abs(size - 1.0) / _SHAKEN)


class Vertical:
    """The complementary filter of accelerometer and gyrometer: the vertical (x, y, z) in the root link.

    At its beginning the filter is a mean; `averaged` is the number of rows that it averages.
    """

    def __init__(self) -> None:
        self.x = self.y = self.z = self.averaged = 0.0

    def row(self, a: float, b: float, c: float, used: float, least: float, turn: Sequence[float]) -> None:
        """Turn by the opposite of the root link's turn [rad], then come nearer to a direction (a, b, c)."""
        x, y, z = self.x, self.y, self.z
        p, q, r = turn
        square = p * p + q * q + r * r
        if square > 0.0:
            # u − sin φ / φ · w × u + (1 − cos φ) / φ² · w × (w × u)
            angle = math.sqrt(square)
            first, second = math.sin(angle) / angle, 2.0 * (math.sin(0.5 * angle) / angle) ** 2
            k, m, n = q * z - r * y, r * x - p * z, p * y - q * x
            x, y, z = (
                x - first * k + second * (q * n - r * m),
                y - first * m + second * (r * k - p * n),
                z - first * n + second * (p * m - q * k),
            )
        if used > 0.0:
            averaged = self.averaged + used
            part = max(least, used / averaged)
            x, y, z = x + part * (a - x), y + part * (b - y), z + part * (c - z)
            self.averaged = used / part
        self.x, self.y, self.z = x, y, z


def _filtered(direction: Floats, used: Floats, turns: Floats | None, moments: Floats, longest_gap: float) -> Floats:
    """Return the vertical (n, 3) from directions of the accelerometer (n, 3), used by their weights (n,), and turns.

    The filter runs forwards and backwards, and the results count as much as the rows that they have averaged.
    """
    steps = np.diff(moments)
    turned = np.zeros((len(steps), 3))
    if turns is not None:
        turned = 0.5 * np.nan_to_num(turns[1:] + turns[:-1]) * steps[:, None]
    parts = gain(used, np.append(steps, np.median(steps) if len(steps) else 0.0), gyro=turns is not None)
    total, weights = np.zeros((len(moments), 3)), np.zeros(len(moments))
    for order, sign in ((slice(None), 1.0), (slice(None, None, -1), -1.0)):
        restarts = np.append(True, steps[order] > longest_gap)
        # Lists of numbers, one for each column, take a third of the time of a list for each row.
        turning = np.concatenate([np.zeros((1, 3)), sign * turned[order]])
        columns = (*direction[order].T, used[order], parts[order], restarts)
        found, rule = np.empty((len(moments), 4)), Vertical()
        turns_of_rows = zip(*(column.tolist() for column in turning.T), strict=True)
        rows = zip(*(column.tolist() for column in columns), turns_of_rows, strict=True)
        for k, (a, b, c, weight, part, restart, turn) in enumerate(rows):
            if restart:
                rule = Vertical()
            rule.row(a, b, c, weight, part, turn)
            found[k] = rule.x, rule.y, rule.z, rule.averaged
        total[order] += found[:, :3] * found[:, 3:]
        weights[order] += found[:, 3]
    size = np.linalg.norm(total, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where(weights[:, None] > 0.0, total / size[:, None], np.nan))


def roll_pitch(up: Floats) -> Floats:
    """Return roll and pitch of verticals (n, 3) in the root link, shape (n, 2) [rad]."""
    x, y, z = columns(up)
    return np.array([np.arctan2(y, z), np.arctan2(-x, np.hypot(y, z))]).T.reshape(-1, 2)


def lifts(log: LegLog) -> Floats:
    """Return the height of the last sole over the first one in each row, shape (n,) [m]."""
    first, last = log.T_base_soles[:, 0, :3], log.T_base_soles[:, -1, :3, 3]
    return np.asarray(((last - first[:, :, 3]) * first[:, :, 2]).sum(axis=1))


def done(log: LegLog, up: Floats | None, quiet: Mask | None, rule: Doing) -> NDArray[Any]:
    """Return what the robot does in each row, but for walking; without verticals, by the legs alone."""
    legs, ground = log.legs, log.ground
    if up is None:
        if ground.rule == "joints":
            log.notes.append(BY_JOINTS)
        stands = ground.heavy & ~log.lost & (log.lever[:, 2, 2] >= math.cos(_UPRIGHT))
        return np.where(stands, "standing", "unknown").astype("<U8")
    soles = up[:, None, None] @ log.T_base_soles[..., :3, 2:]  # cosine of the tilt, and height
    flat: Mask = np.asarray(((soles[..., 0, 0] >= math.cos(_FLAT)) & log.carrying).any(axis=1))
    low = np.zeros(len(up), dtype=np.bool_)
    if len(legs.hips):
        low = (up @ legs.hips.T).min(axis=1) - soles[..., 0, 1].min(axis=1) < legs.low
    blind = np.full(len(up), None) if quiet is None else quiet
    return decided(rule, log.moments, up, ground.stands, flat, ground.share, low, blind).astype("<U8")


def by_unit(differences: Floats) -> Floats:
    """Return the covariance of roll and pitch by the mean square of differences between inertial unit and legs.

    Of a difference d, the unit has the share k d in the mean, and a variance of k _BY_LEGS².
    """
    k = _BY_UNIT**2 / (_BY_UNIT**2 + _BY_LEGS**2)
    return np.asarray(k * k * differences + k * _BY_LEGS**2 * ONE)


def _on_edge(log: LegLog) -> Mask:
    """Return in which rows the support may stand on its edge, by its centre of pressure, shape (n,)."""
    found = np.ones(len(log.support), dtype=np.bool_)
    for k, (_, places) in enumerate(log.legs.cells):
        if len(places) > 1:
            low, high = places.min(axis=0), places.max(axis=0)
            inside = np.abs(log.pressure[:, k] - 0.5 * (low + high)) <= _EDGE * 0.5 * (high - low)
            found &= ~(inside.all(axis=1) & (log.support == k))
    return found


def stated(log: LegLog, up: Floats, doing: NDArray[Any], stands: Mask, path: Odometry, unit: Floats | None) -> State:
    """Return the state in n rows; `unit` is the covariance of roll and pitch of an inertial unit."""
    valid, T = path.valid, path.T_world_base
    T_world_base, covariance = np.full((len(up), 4, 4), np.nan), np.full((len(up), 3, 3), np.nan)
    if valid.any():
        (x, y), lever = columns(path.T_world_support[:, :2, 3]), columns(log.lever[:, :3, 3])
        heading, tilt = column(np.arctan2(T[:, 1, 0], T[:, 0, 0])), columns(roll_pitch(up))
        if unit is None:
            edge = _BY_EDGE**2 * column(1.0 * _on_edge(log))
            a, b, d = _BY_ROLL**2 + edge, 0.0 * x, _BY_PITCH**2 + edge
        else:
            a, b, _, d = (entry + 0.0 * x for entry in unit.ravel().tolist())
        pose, entries = _upright(tilt, (heading, x, y), lever, (a, b, d))
        T_world_base[valid], covariance[valid] = poses(pose)[valid], np.array(entries).T.reshape(-1, 3, 3)[valid]
    return State(
        times=log.moments,
        soles=log.legs.feet.names,
        doing=doing,
        carrying=log.carrying & stands[:, None],
        up=up,
        T_world_base=T_world_base,
        covariance=covariance,
        T_base_soles=log.T_base_soles,
        forces=log.ground.pressed,
        sole_pressure=log.pressure,
        odometry=path,
        notes=tuple(log.notes),
        longest_gap=log.longest_gap,
    )


def _upright(
    tilt: Sequence[Column], place: Sequence[Column], lever: Sequence[Column], angles: Sequence[Column]
) -> tuple[list[Column], list[Column]]:
    """Return the pose of a tilted root link whose support at the `lever` is at (x, y, 0); and its covariance.

    They are the first three rows of the pose, and the nine covariances of roll, pitch and height by those of roll and
    pitch, xx, xy and yy: the height is −up · lever.
    """
    (heading, x, y), (i, j, k) = place, lever
    (cr, sr), (cp, sp), (c, s) = (cosine_sine(angle) for angle in (*tilt, heading))
    along, ahead = sr * j + cr * k, cr * j - sr * k
    # R = Rz(heading) Ry(pitch) Rx(roll)
    u, w = cp * i + sp * along, -sp * i + cp * along
    rows = [c * cp, c * sp * sr - s * cr, c * sp * cr + s * sr, x - (c * u - s * ahead)]
    rows += [s * cp, s * sp * sr + c * cr, s * sp * cr - c * sr, y - (s * u + c * ahead)]
    rows += [-sp, cp * sr, cp * cr, -w]
    p, q = -cp * ahead, u  # derivatives of the height by roll and pitch
    a, b, d = angles
    g, h = a * p + b * q, b * p + d * q
    return rows, [a, b, g, b, d, h, g, h, p * g + q * h + _BY_LENGTH**2]
