"""What a robot is doing, while it does it: the rules of `state` for one row after the other."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from copy import copy
from typing import Literal, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, shaped
from nao_kin.errors import BadArgument
from nao_kin.robot import RobotModel
from nao_kin.world.doing import Contact, Doing, Walk
from nao_kin.world.legs import LARGEST, Ground, LegLog, Legs, Loads
from nao_kin.world.odometry import OVER, Odometry, ahead, followed
from nao_kin.world.path import Path
from nao_kin.world.rest import INTERVAL, KNOWN, Rest, Turns, bias_notes
from nao_kin.world.sensors import WIDTHS, Rows, Sensor, corrected
from nao_kin.world.state import (
    ONE,
    TIME_CONSTANT,
    State,
    Vertical,
    by_unit,
    done,
    gain,
    lifts,
    roll_pitch,
    stated,
    trust,
    vertical,
)

# The largest time between two rows of a segment [s], as in `state`.
_LONGEST_GAP = 0.5
# Sensors are judged by up to _KEPT rows, _EVERY apart [s]: the first _FIRST ones, and then those between which a joint
# of the legs has moved by _MOVED [rad]. They are judged whenever there are twice as many, and then after _AGAIN rows.
_KEPT, _EVERY, _FIRST, _MOVED, _AGAIN = 256, 0.035, 64, np.radians(1.0), 16
# What a robot does when its legs move and carry nothing.
_OFF_ITS_LEGS = "lying", "falling", "carried"
# Deviation of the direction of the accelerometer in a row of a robot that moves [rad].
_ROW = np.radians(5.0)
# The mean square difference between inertial unit and soles begins with this one of so many rows [rad²].
_UNSURE, _UNSURE_ROWS = np.radians(1.0) ** 2, 20.0

_Result = TypeVar("_Result", State, Odometry)
_FIRST_ROW, _TRUE = np.zeros(1, dtype=np.intp), np.ones(1, dtype=np.bool_)


class _Kept(NamedTuple):
    """A row by which sensors are judged: its time, joints, soles, and what the sensors showed."""

    moment: float
    q: Floats
    T_base_soles: Floats
    raw: dict[str, Floats]


class StateEstimator:
    """An estimator of what a robot does, from one row of its sensors after the other.

    It follows the rules of `state`, but knows only the rows before: a lost contact is known after 0.2 s, what needs
    some time after this time, and the bias of the gyrometer from the first second at rest on. Sensors that lie are
    found by the rules of `state` too, in rows in which the legs have moved lately: as soon as these rows show it. The
    rows in which sensors are judged take longer, one or two milliseconds; there are some in the first seconds, and then
    four in 0.6 s or more in which the legs move.

    Args:
        robot: any robot whose semantics name soles, or for which `soles` does.
        soles: frames of the soles; None for those of the semantics.
        start: pose of the root link at the first row in which it stands, shape (4, 4); None as in `odometry`.

    Examples:
        >>> nao = nk.load_nao()
        >>> estimator = nk.world.StateEstimator(nao)
        >>> for k in range(100):
        ...     now = estimator.update(nao.posture("StandInit"), 0.01 * k, forces=[2.7, 2.7], angles=[0.0, 0.05])
        >>> now.doing[0].item(), now.support[0].item(), now.T_world_base[0, 2, 3].round(3).item()
        ('standing', 'both', 0.32)
    """

    def __init__(
        self, robot: RobotModel, *, soles: Sequence[str] | None = None, start: ArrayLike | None = None
    ) -> None:
        self._legs = Legs(robot, soles)
        self._path, self._doing, self._walk = Path(start), Doing(), Walk()
        self._contact, self._heavy = Contact(), Contact()
        self._vertical, self._rest = Vertical(), Rest(None)
        self._kind: Literal["gyro", "up"] | None = None
        self._interval, self._sums = -1, np.zeros(0)
        self._differences, self._rows = np.eye(2) * _UNSURE * _UNSURE_ROWS, _UNSURE_ROWS
        self._before: dict[str, Floats] = {"q": robot.neutral()}
        self._kept: deque[_Kept] = deque(maxlen=_KEPT)
        self._new, self._names = 0, frozenset[str]()
        self._judging: Iterator[None] = iter(())
        self._sensors: dict[str, Sensor] = {}
        self._loads: Loads | None = None
        self._notes, self._bias_notes = list[str](), list[str]()
        self._support: int | None = None
        self._rates: Floats | None = None
        self._lost, self._first, self._time, self._did = True, 0.0, -math.inf, ""
        self._poses: deque[tuple[float, ...]] = deque()
        self._now: State | None = None

    def update(
        self,
        q: ArrayLike,
        time: float,
        *,
        contacts: ArrayLike | None = None,
        forces: ArrayLike | None = None,
        angles: ArrayLike | None = None,
        accelerometer: ArrayLike | None = None,
        gyro: ArrayLike | None = None,
    ) -> State:
        """Return the state in the next row: a `State` with n = 1, whose notes are those so far.

        Errors of sensors that the robot's file states are corrected, as in `state`.
        NaN is accepted: without the joints of the legs the row is not valid, other sensors keep their last value. After
        more than 0.5 s without a row a new segment begins. A row that repeats a time returns the last state.

        Args:
            q: configuration, shape (nq,).
            time: later than that of the row before [s].
            contacts: whether each sole touches the floor, shape (s,).
            forces: force on each sole or on each sensor, shape (s,) or (f,) [kg, N or shares of the weight].
            angles: roll and pitch of the root link, shape (2,) [rad].
            accelerometer: in the axes of the root link, shape (3,), any unit, of either sign.
            gyro: angular velocity in the axes of the root link, shape (3,) [rad/s].

        Raises:
            BadArgument: a time that goes back, contacts and forces, angles and an accelerometer.
            WrongShape: a value of another length.

        Examples:
            >>> nao = nk.load_nao()
            >>> estimator = nk.world.StateEstimator(nao)
            >>> now = estimator.update(nao.posture("Sit"), 0.0, forces=[0.3, 0.3], accelerometer=[-3.0, 0.0, 9.3])
            >>> bool(now.valid[0]), now.up[0].round(1).tolist()
            (False, [-0.3, 0.0, 1.0])
        """
        moment, now = float(time), self._now
        before = self._time
        if now is not None and moment == before:
            return _copied(now)
        if not before < moment < math.inf:
            raise BadArgument(f"times must ascend: {moment!r} s comes after {before!r} s")
        if contacts is not None and forces is not None:
            raise BadArgument("give contacts or forces, not both")
        if angles is not None and accelerometer is not None:
            raise BadArgument("give angles or an accelerometer, not both")
        self._time, self._first = moment, moment if now is None else self._first
        step, gap = (moment - before, moment - before > _LONGEST_GAP) if now is not None else (0.0, True)
        given = ("contacts", contacts), ("forces", forces), ("angles", angles), ("accelerometer", accelerometer)
        raw = {
            name: np.array(shaped(value, (self._width(name, value),), name, gaps=True))
            for name, value in (*given, ("gyro", gyro))
            if value is not None
        }
        joints = np.array(shaped(q, (self._legs.robot.nq,), "q", gaps=True))
        values, known = self._filled("q", joints), np.array([bool(np.isfinite(joints[self._legs.columns]).all())])
        T, rows = self._legs.soles(values), Rows(np.array([moment]), _FIRST_ROW, ())
        self._keep(_Kept(moment, values, T, raw))
        seen = {name: self._read(name, value) for name, value in raw.items() if self._used(name)}
        ground, T = self._ground(seen, rows.times), T[None]
        support = ground.supports(T, self._support)
        self._support = int(support[0])
        notes = [*self._notes, *self._bias_notes]
        log = LegLog(self._legs, rows, values[None], T, ground, support, known, _LONGEST_GAP, notes)
        return _copied(self._state(log, seen, step, gap))

    def _state(self, log: LegLog, seen: dict[str, Floats], step: float, gap: bool) -> State:
        """Return the state in a row with the values of its sensors, some time after the row before."""
        rates, by_legs = seen.get("gyro"), log.lever[:, :3, 2]
        up = self._upright(seen, gap, step)
        rest = np.array([self._judge(log, rates, up)])
        quiet = np.array([bool(self._rest.quiet)]) if up is not None or rates is not None else None
        doing = done(log, up, quiet, self._doing)
        stands = doing == "standing"
        self._lost |= gap or not (stands[0] and log.known[0])
        turns = None
        if rates is not None:
            deviation = np.array([math.sqrt(self._rest.variance)])
            turns = Turns((rates - self._rest.bias)[None], _TRUE, deviation)
        path = followed(log, rest, turns, self._path, stands, on=not self._lost)
        valid = path.segment[0] >= 0
        if valid:
            self._move(path)
        self._walk.row(self._time, int(path.support[0]), float(lifts(log)[0]))
        if self._walk.now:
            doing[0] = "walking"
        unit = None
        if up is not None and valid:
            away = roll_pitch(up) - roll_pitch(by_legs)
            self._differences, self._rows = self._differences + away.T * away, self._rows + 1.0
            unit = by_unit(self._differences / self._rows)
            if "accelerometer" in seen:
                # The filter has averaged few rows, or turns by a bias that is not known.
                drift = 0.0 if rates is None else self._rest.variance * TIME_CONSTANT**2
                unit = unit + ONE * (drift + _ROW**2 / max(self._vertical.averaged, 1.0))
        self._rates, self._did = rates, str(doing[0])
        self._now = stated(log, by_legs if up is None else up, doing, stands, path, unit)
        return self._now

    # --- Sensors: what they show, and whether they lie.

    def _width(self, what: str, given: ArrayLike) -> int:
        """Return how many numbers a sensor has."""
        soles, cells = self._legs.carried.shape
        one_by_one = what == "forces" and cells and np.shape(given) != (soles,)
        return WIDTHS.get(what) or (cells if one_by_one else soles)

    def _filled(self, what: str, values: Floats) -> Floats:
        """Return the values of a sensor; where they are NaN, or cannot be, those before, or 0."""
        missing = ~(np.abs(values) <= LARGEST.get(what, math.inf))
        if missing.any():
            values = np.where(missing, self._before.get(what, 0.0), values)
        self._before[what] = values
        return values

    def _used(self, what: str) -> bool:
        return what in self._sensors and bool(np.isfinite(self._sensors[what].gain).any())

    def _read(self, what: str, raw: Floats) -> Floats:
        """Return what a sensor shows, with the sign, the unit and the offset that were found."""
        values, sensor = self._filled(what, corrected(self._legs.robot, what, raw)), self._sensors[what]
        return sensor.gain * values - sensor.offset

    def _keep(self, row: _Kept) -> None:
        """Keep the row to judge the sensors, and go on to judge them if there are enough rows."""
        kept, raw = self._kept, row.raw
        if self._names != raw.keys():
            kept.clear()
            self._names, self._loads, self._sensors, self._new = frozenset(raw), None, {}, 0
            self._judging = iter(())
        far = moved = True
        if kept:
            far = row.moment - kept[-1].moment >= _EVERY
            moved = far and np.abs(row.q - kept[-1].q)[self._legs.columns].max(initial=0.0) > _MOVED
        if far and (len(kept) < _FIRST or (moved and self._did not in _OFF_ITS_LEGS)):
            kept.append(row)
            self._new += 1
            if raw and self._new >= min(len(kept) // 2, _AGAIN):
                self._new, self._judging = 0, self._judged(tuple(kept))
        next(self._judging, None)
        if not self._sensors:
            for _ in self._judging:
                pass

    def _judged(self, kept: Sequence[_Kept]) -> Iterator[None]:
        """Judge the sensors by the rules of a log, in four parts, which take one or two milliseconds at most."""
        moments, q, T, raw = zip(*kept, strict=True)
        given = {name: np.array([row[name] for row in raw]) for name in raw[0]}
        joints, soles, loads = np.array(q), np.array(T), (given.get("contacts"), given.get("forces"))
        yield
        log = LegLog.of(self._legs, moments, joints, *loads, _LONGEST_GAP, soles)
        yield
        turns, _ = log.turns(given.get("gyro"))
        yield
        vertical(log, given.get("angles"), given.get("accelerometer"), turns)
        self._loads, self._sensors, self._notes = log.ground.loads, log.sensors, log.notes

    def _ground(self, seen: dict[str, Floats], moments: Floats) -> Ground:
        """Return what contacts or forces of the row say."""
        loads = self._loads
        if loads is None:
            return Ground.by_legs(np.ones((1, len(self._legs.feet.names))))
        return loads.ground(seen[loads.sensor.what][None], _TRUE, moments, self._contact, self._heavy)

    def _upright(self, seen: dict[str, Floats], gap: bool, step: float) -> Floats | None:
        """Return the vertical in the root link, (1, 3), by the angles, or by the filter of the accelerometer."""
        if "angles" in seen:
            roll, pitch = seen["angles"].tolist()
            level = math.cos(pitch)
            return np.array([[-math.sin(pitch), level * math.sin(roll), level * math.cos(roll)]])
        if "accelerometer" not in seen:
            return None
        turn = [0.0, 0.0, 0.0]
        if "gyro" in seen:
            rates = seen["gyro"]
            before = rates if self._rates is None else self._rates
            turn = ((0.5 * (rates + before) - self._rest.bias) * step).tolist()
        if gap:
            self._vertical = Vertical()
        x, y, z = seen["accelerometer"].tolist()
        size, rule = math.sqrt(x * x + y * y + z * z), self._vertical
        if size > 0.0:
            used = float(trust(size))
            rule.row(x / size, y / size, z / size, used, float(gain(used, step, gyro="gyro" in seen)), turn)
        length = math.sqrt(rule.x**2 + rule.y**2 + rule.z**2)
        return np.array([[rule.x, rule.y, rule.z]]) / length if length > 0.0 else np.full((1, 3), np.nan)

    def _judge(self, log: LegLog, rates: Floats | None, up: Floats | None) -> bool:
        """Add the row to its interval, and close the one before; return whether the robot is still at rest."""
        kind: Literal["gyro", "up"] | None = "up" if up is not None else None
        shown, kind = (up, kind) if rates is None else (rates[None], "gyro")
        legs = log.q[:, self._legs.columns]
        if kind != self._kind:
            self._rest, self._kind, self._interval, self._bias_notes = Rest(kind), kind, -1, []
        number = int((float(log.moments[0]) - self._first) / INTERVAL)
        if number != self._interval:
            if self._interval >= 0:
                self._rest.close(self._interval, self._sums)
                if self._rest.rest:
                    self._path.settle()
                    if rates is not None and self._rest.variance < KNOWN**2:
                        self._bias_notes = bias_notes(self._rest.bias[None], False)
                self._path.mark()
            self._interval, self._sums = number, np.zeros(8 + len(self._legs.columns))
        if log.known[0]:
            self._sums += self._rest.values(legs, log.ground.stands, shown)[0]
        return self._rest.lasts(legs[0], None if shown is None else shown[0])

    def _move(self, path: Odometry) -> None:
        """Write the velocity over the poses of the last time, and go on with the segment."""
        poses = self._poses
        if self._lost:
            poses.clear()
        self._lost = False
        poses.append((float(path.times[0]), *path.pose[0].tolist()))
        while poses[-1][0] - poses[0][0] > OVER:
            poses.popleft()
        step, *way = (b - a for a, b in zip(poses[0], poses[-1], strict=True))
        if step > 0.0:
            path.velocity[0] = np.array(ahead(way, poses[-1][3])) / step


def _copied(found: _Result) -> _Result:
    """Return a state, or its odometry, with arrays of its own."""
    made = copy(found)
    for name, value in vars(found).items():
        if isinstance(value, np.ndarray | Odometry):
            object.__setattr__(made, name, value.copy() if isinstance(value, np.ndarray) else _copied(value))
    return made
