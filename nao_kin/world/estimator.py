"""What a robot is doing, while it does it: the rules of `state` for one row after the other."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from copy import copy
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, shaped
from nao_kin.errors import BadArgument
from nao_kin.robot import Feet, RobotModel
from nao_kin.world.doing import HALF, UNLOADED, Contact, Doing
from nao_kin.world.odometry import OVER, LegLog, Odometry, leg_columns
from nao_kin.world.path import Path
from nao_kin.world.rest import INTERVAL, KNOWN, Rest, Turns, bias_notes
from nao_kin.world.sensors import MOST, Ground, Rows, corrected
from nao_kin.world.state import (
    ALONG,
    BY_JOINTS,
    LONGEST_STEP,
    TIME_CONSTANT,
    State,
    StateRules,
    Vertical,
    carrying_soles,
    gain,
    roll_pitch,
    trust,
)

# The largest time between two rows of a segment [s], as in `state`.
_LONGEST_GAP = 0.5
# The usual length of the accelerometer's vector is a mean of so many rows; then it follows with this time constant [s],
# and impacts and falls count by this share of it at most.
_USUAL, _FOLLOWING, _SHAKEN = 50, 10.0, 0.2
# Deviation of the direction of the accelerometer in a row of a robot that moves [rad].
_ROW = np.radians(5.0)
# The mean square difference between inertial unit and soles begins with this one of so many rows [rad²].
_FIRST, _FIRST_ROWS = np.radians(1.0) ** 2, 20.0


_UNKNOWN = np.full((1, 3, 3), np.nan), np.full((1, 3), np.nan)

_Result = TypeVar("_Result", State, Odometry)


class StateEstimator:
    """An estimator of what a robot does, from one row of its sensors after the other.

    It follows the rules of `state`, but knows only the rows before: a lost contact is known after 0.2 s, what needs
    some time after this time, and the bias of the gyrometer from the first second at rest on. Forces are compared with
    the robot's mass in kg, and not with the log; the sensors are believed. `state` of a recorded log shows whether they
    may be.

    Args:
        robot: any robot whose semantics name soles, or for which `soles` does.
        soles: frames of the soles; None for those of the semantics.
        weight: force on all soles of the standing robot in the unit of the forces; None for its mass in kg.
        start: pose of the root link at the first row in which it stands, shape (4, 4); None as in `odometry`.

    Examples:
        >>> nao = nk.load_nao()
        >>> estimator = nk.world.StateEstimator(nao)
        >>> for k in range(100):
        ...     now = estimator.update(0.01 * k, nao.posture("StandInit"), forces=[2.7, 2.7], angles=[0.0, 0.05])
        >>> now.doing[0].item(), now.support[0].item(), now.T_world_base[0, 2, 3].round(3).item()
        ('standing', 'both', 0.32)
    """

    def __init__(
        self,
        robot: RobotModel,
        *,
        soles: Sequence[str] | None = None,
        weight: float | None = None,
        start: ArrayLike | None = None,
    ) -> None:
        self._robot, self._feet = robot, Feet.of(robot, soles, needed=True, or_origin=True)
        self._rules = StateRules(robot, self._feet)
        self._legs = np.array(leg_columns(robot, self._feet.names), dtype=np.intp)
        self._heights = self._feet.heights
        self._carried = self._feet.carried(robot, robot.semantics.force_sensors).T.astype(np.float64)
        self._weight = float(robot.mass if weight is None else weight)
        self._path, self._contact, self._doing = Path(start), Contact(), Doing()
        self._heavy, self._over = Contact(), Contact()
        self._vertical, self._rest = Vertical(), Rest(len(self._legs), gyro=False, vertical=False)
        self._interval, self._sums = -1, np.zeros(0)
        self._differences, self._rows = np.eye(2) * _FIRST * _FIRST_ROWS, _FIRST_ROWS
        self._kept: dict[str, Floats] = {"q": robot.neutral()}
        self._notes: dict[str, None] = {}
        self._agreement = self._size = 0.0
        self._sizes, self._bias_notes = 0, list[str]()
        self._support: int | None = None
        self._lost, self._carrier, self._changes = True, -1, (-math.inf, -math.inf)
        self._poses: deque[tuple[float, ...]] = deque()
        self._first: float | None = None
        self._now: State | None = None

    def update(
        self,
        time: float,
        q: ArrayLike,
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
        more than 0.5 s without a row a new segment begins. A row that repeats a time has the state of the row before.

        Args:
            time: later than that of the row before [s].
            q: configuration, shape (nq,).
            contacts: whether each sole touches the floor, shape (s,).
            forces: force on each sole or on each sensor, shape (s,) or (f,).
            angles: roll and pitch of the root link, shape (2,) [rad].
            accelerometer: in the axes of the root link, shape (3,), any unit, of either sign.
            gyro: angular velocity in the axes of the root link, shape (3,) [rad/s].

        Raises:
            BadArgument: a time that goes back, contacts and forces, angles and an accelerometer.
            WrongShape: a value of another length.

        Examples:
            >>> nao = nk.load_nao()
            >>> estimator = nk.world.StateEstimator(nao, weight=52.6)  # forces in N
            >>> now = estimator.update(0.0, nao.posture("Sit"), forces=[3.0, 3.0], accelerometer=[-3.0, 0.0, 9.3])
            >>> bool(now.valid[0]), now.up[0].round(1).tolist()
            (False, [-0.3, 0.0, 1.0])
        """
        moment, now = float(time), self._now
        before = -math.inf if now is None else float(now.times[0])
        if now is not None and moment == before:
            return _copied(now)
        if not before < moment < math.inf:
            raise BadArgument(f"times must ascend: {moment!r} s comes after {before!r} s")
        if self._first is None:
            self._first = moment
        step, gap = (moment - before, moment - before > _LONGEST_GAP) if now is not None else (0.0, True)
        values = self._read("q", q, self._robot.nq)
        known = bool(np.isfinite(np.asarray(q, dtype=np.float64)[self._legs]).all())
        T = np.asarray(self._robot.fk(values, self._feet.names, reference=self._robot.tree.root))[None]
        T = self._feet.on_ground(T) if self._heights.any() else T
        rows = Rows(np.array([moment]), np.zeros(1, dtype=np.intp), ())
        ground, legs, notes = self._ground(moment, contacts, forces), values[None, self._legs], list[str]()
        log = LegLog(self._feet, rows, values[None], legs, T, ground, np.array([known]), _LONGEST_GAP, notes)
        support = ground.supports(slice(None), T, self._support)
        self._support = int(support[0])
        unit = angles is not None or accelerometer is not None
        rates, turn = self._turned(gyro, step)
        by_legs = self._rules.up_by_legs(log, support)
        up = self._upright(angles, accelerometer, by_legs[0], ground, gap, step, turn) if unit else by_legs
        self._judge(moment, log, rates, up if unit else None)
        if not unit and ground.rule == "joints":
            self._notes[BY_JOINTS] = None
        notes += [*self._notes, *self._bias_notes]
        quiet = np.array([bool(self._rest.quiet)]) if unit or gyro is not None else None
        carrying = carrying_soles(log, support)
        doing = self._rules.doing(log, carrying, up, quiet, self._doing if unit else None)
        path = self._followed(log, support, rates, doing, gap)
        angle = None
        if unit:
            away = (roll_pitch(up) - roll_pitch(by_legs))[path.valid]
            self._differences, self._rows = self._differences + away.T @ away, self._rows + len(away)
            angle = self._differences / self._rows
        if accelerometer is not None:
            # The filter has averaged few rows, or turns by a bias that is not known.
            drift = 0.0 if rates is None else self._rest.variance * TIME_CONSTANT**2
            angle = angle + np.eye(2) * (drift + _ROW**2 / max(self._vertical.averaged, 1.0))
        found = self._rules.state(log, carrying, up, doing, path, angle)
        self._now = _copied(found)  # the caller may change the arrays
        return found

    def _read(self, what: str, value: ArrayLike, width: int) -> Floats:
        """Return the values of a sensor, (width,), without its known errors; where they are NaN those before, or 0."""
        values = shaped(corrected(self._robot, what, value), (width,), what, gaps=True)
        missing = np.isnan(values)
        if missing.any():
            values = np.where(missing, self._kept.get(what, 0.0), values)
        self._kept[what] = values
        return values

    def _ground(self, moment: float, contacts: ArrayLike | None, forces: ArrayLike | None) -> Ground:
        """Return what contacts or forces of the row say."""
        if contacts is not None and forces is not None:
            raise BadArgument("give contacts or forces, not both")
        count, share, cells = len(self._feet.names), math.nan, None
        rule, pressed, loaded = "joints", np.ones((1, count)), True
        if contacts is not None:
            rule, pressed = "contacts", (self._read("contacts", contacts, count)[None] != 0.0).astype(np.float64)
            loaded = bool(pressed.any())
        elif forces is not None:
            sensors = len(forces) != count and len(self._carried) > 0  # type: ignore[arg-type]
            values = self._read("forces", forces, len(self._carried) if sensors else count)
            rule, pressed = "forces", np.maximum(values, 0.0)[None]
            if sensors:
                cells, pressed = pressed, pressed @ self._carried
            share = float(pressed.sum()) / self._weight
            loaded = share >= UNLOADED
            self._over.row(share > MOST, moment)
            if self._over.stands:
                text = f"forces: the soles carry more than {MOST:g} times the weight, {self._weight:.3g}"
                self._notes[f"{text}: another unit, or an offset?"] = None
        self._contact.row(loaded, moment)
        self._heavy.row(loaded and not share < HALF, moment)
        stands, heavy = (np.array([bool(each.stands)]) for each in (self._contact, self._heavy))
        return Ground(rule, pressed, cells, np.array([True]), stands, np.array([share]), heavy)

    def _turned(self, gyro: ArrayLike | None, step: float) -> tuple[Floats | None, tuple[float, float, float]]:
        """Return what the gyrometer shows, (3,), and the turn since the row before without its bias [rad]."""
        if gyro is None:
            return None, (0.0, 0.0, 0.0)
        before = self._kept.get("gyro")
        rates = self._read("gyro", gyro, 3)
        turn = (0.5 * (rates + (rates if before is None else before)) - self._rest.bias) * step
        return rates, (float(turn[0]), float(turn[1]), float(turn[2]))

    def _upright(
        self,
        angles: ArrayLike | None,
        accelerometer: ArrayLike | None,
        by_legs: Floats,
        ground: Ground,
        gap: bool,
        step: float,
        turn: tuple[float, float, float],
    ) -> Floats:
        """Return the vertical in the root link, (1, 3), by the angles, or by the filter of the accelerometer."""
        if angles is not None:
            if accelerometer is not None:
                raise BadArgument("give angles or an accelerometer, not both")
            roll, pitch = self._read("angles", angles, 2).tolist()
            level = math.cos(pitch)
            return np.array([[-math.sin(pitch), level * math.sin(roll), level * math.cos(roll)]])
        assert accelerometer is not None
        x, y, z = force = self._read("accelerometer", accelerometer, 3).tolist()
        size, rule = math.sqrt(x * x + y * y + z * z), Vertical() if gap else self._vertical
        self._vertical = rule
        along = float(by_legs @ force)
        if size > 0.0:
            if abs(along) > ALONG * size and ground.stands[0]:
                self._agreement += along
            if self._agreement < 0.0:
                self._notes["accelerometer: negative when the robot stands, as LoLA has it; its sign is changed"] = None
                x, y, z = -x, -y, -z
            self._sizes += 1
            if self._sizes <= _USUAL:
                self._size += (size - self._size) / self._sizes
            else:
                most = _SHAKEN * self._size
                self._size += min(max(size - self._size, -most), most) * min(step / _FOLLOWING, 1.0)
            used = float(trust(size, self._size))
            rule.row(x / size, y / size, z / size, used, float(gain(used, step, gyro="gyro" in self._kept)), turn)
        up = np.array([[rule.x, rule.y, rule.z]])
        length = math.sqrt(rule.x**2 + rule.y**2 + rule.z**2)
        return up / length if length > 0.0 else np.full((1, 3), np.nan)

    def _judge(self, moment: float, log: LegLog, rates: Floats | None, up: Floats | None) -> None:
        """Close the interval before if this row begins one, and add the row to its own."""
        number = int((moment - (self._first or 0.0)) / INTERVAL)
        if self._interval < 0:
            self._rest = Rest(len(self._legs), gyro=rates is not None, vertical=up is not None)
        if number != self._interval:
            if self._interval >= 0:
                self._rest.close(self._interval, self._sums)
                if self._rest.rest:
                    self._path.settle()
                    if rates is not None and self._rest.variance < KNOWN**2:
                        self._bias_notes = bias_notes(self._rest.bias[None], False)
                self._path.mark()
            self._interval, self._sums = number, np.zeros(8 + len(self._legs))
        if log.known[0]:
            stands = log.ground.stands.astype(np.float64)
            self._sums += self._rest.values(log.legs, stands, rates, up)[0]

    def _followed(
        self, log: LegLog, support: NDArray[np.intp], rates: Floats | None, doing: NDArray[Any], gap: bool
    ) -> Odometry:
        """Return the odometry of the row, and write in `doing` where it walks."""
        moment, path, stands = float(log.moments[0]), self._path, doing[0] == "standing"
        self._lost |= gap or not stands
        names, notes = log.feet.names, tuple(log.notes)
        if not (stands and log.known[0]):
            none, nowhere = np.array([-1]), np.full((1, 4, 4), np.nan)
            return Odometry(log.moments, nowhere, names, none, nowhere, none, *_UNKNOWN, notes)
        if self._lost:
            path.begin(log.T_base_soles[0], int(support[0]))
            self._lost, self._changes, self._poses = False, (-math.inf, -math.inf), deque()
        turns = None
        if rates is not None:
            deviation = np.array([math.sqrt(self._rest.variance)])
            turns = Turns((rates - self._rest.bias)[None], np.array([True]), deviation)
        moves = np.zeros(1, dtype=np.bool_)
        T, T_world_support, pose, covariance = path.extend(log.T_base_soles, support, log.moments, moves, turns)
        if self._poses and self._carrier != support[0]:
            self._changes = self._changes[1], moment
        self._carrier = int(support[0])
        # It has walked on if its last step lasts no longer than one and a half of the one before.
        lasted = self._changes[1] - self._changes[0]
        if lasted <= LONGEST_STEP and moment - self._changes[1] <= 1.5 * lasted:
            doing[0] = "walking"
        poses = self._poses
        poses.append((moment, *pose[0].tolist()))
        while moment - poses[0][0] > OVER:
            poses.popleft()
        velocity = _velocity(poses[0], poses[-1])
        height = self._heights[support]
        if height[0]:
            T_world_support = T_world_support.copy()
            T_world_support[:, 2, 3] -= height
        segment = np.array([path.segment])
        return Odometry(log.moments, T, names, support, T_world_support, segment, covariance, velocity, notes)


def _velocity(first: Sequence[float], last: Sequence[float]) -> Floats:
    """Return the mean velocity between two poses (time, x, y, heading): ahead, to the left, of the heading, (1, 3)."""
    step, x, y, turn = (b - a for a, b in zip(first, last, strict=True))
    if step == 0.0:
        return np.full((1, 3), np.nan)
    c, s = math.cos(last[3]), math.sin(last[3])
    return np.array([[c * x + s * y, c * y - s * x, turn]]) / step


def _copied(found: _Result) -> _Result:
    """Return a state, or its odometry, with arrays of its own."""
    made = copy(found)
    for name, value in vars(found).items():
        if isinstance(value, np.ndarray | Odometry):
            object.__setattr__(made, name, value.copy() if isinstance(value, np.ndarray) else _copied(value))
    return made
