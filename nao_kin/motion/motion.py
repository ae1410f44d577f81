"""`Motion`: joints with their own keys, and a curve through the keys of each joint; and its configurations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, all_finite, as_floats, as_numbers, choice, is_several, positive, shaped
from nao_kin._core.guesses import Guessing
from nao_kin._core.sides import Hips, check_hips
from nao_kin._core.text import quoted
from nao_kin._core.warn import warn_of_degrees
from nao_kin.errors import BadArgument, NotFinite, UnknownName, WrongShape
from nao_kin.motion.interpolation import INTERPOLATIONS, Interpolation, Segments, bezier_handles, segments
from nao_kin.robot import RobotModel
from nao_kin.world import DynamicBalance, dynamic_balance

# --- Conversion and checks of the names, times, keys and handles of a motion.

# A handle may leave its segment by this share of it: rounding, also of single precision.
_HANDLE_ROUNDING = 1e-6

Columns = tuple[Floats, ...]


def checked_names(names: Any) -> tuple[str, ...]:
    """Return the joint names of a motion as texts, each given once."""
    if not is_several(names):
        raise BadArgument(f"joint_names must be a list of names, got {quoted(names)}")
    result = tuple(names)
    if not result:
        raise BadArgument("a motion needs at least one joint, got no joint_names")
    twice = next((name for index, name in enumerate(result) if name in result[:index]), None)
    if twice is not None:
        raise BadArgument(f"joint_names has {quoted(twice)} twice")
    return result


def checked_times(times: Any, names: tuple[str, ...]) -> tuple[Columns, bool]:
    """Return the ascending times of each joint, and whether all joints share one list."""
    rows = _rows(times, "times")
    if _is_single(rows[0]):
        column = _checked_column(times if isinstance(times, np.ndarray) else rows, "times")
        _check_ascending(column, "times")
        return (column,) * len(names), True
    if len(rows) != len(names):
        raise BadArgument(f"times must have one list for each of {len(names)} joints, got {len(rows)}")
    columns = list[Floats]()
    for index, (name, row) in enumerate(zip(names, rows, strict=True)):
        if index and row is rows[index - 1]:
            columns.append(columns[-1])
            continue
        column = _checked_column(row, f"times of {name}")
        _check_ascending(column, f"times of {name}")
        # Joints with equal times share one array, so that segments are looked up once.
        columns.append(columns[-1] if index and np.array_equal(column, columns[-1]) else column)
    return tuple(columns), False


def checked_keys(keys: Any, names: tuple[str, ...], times: Columns, *, shared: bool) -> Columns:
    """Return the keys of each joint, from a row for each of `shared` times, or else from a list for each joint."""
    if shared:
        array = as_numbers(keys, "keys")
        if array.ndim == 1 and len(names) == 1:
            array = array[:, None]
        wanted = (len(times[0]), len(names))
        if array.shape != wanted:
            hint = "; a list for each joint goes with times for each joint" if array.shape == wanted[::-1] else ""
            raise WrongShape("keys", f"{wanted}, a row for each time{hint}", array.shape)
        if not all_finite(array):
            row, column = np.argwhere(~np.isfinite(array))[0].tolist()
            raise NotFinite("keys", (row, column), float(array[row, column]), names[column])
        # One row for each joint in memory.
        return tuple(np.array(array.T, order="C"))
    rows = _rows(keys, "keys")
    if len(rows) != len(names):
        raise BadArgument(f"keys must have one list for each of {len(names)} joints, got {len(rows)}")
    columns = []
    for name, row, column in zip(names, rows, times, strict=True):
        values = _checked_column(row, f"keys of {name}")
        if len(values) != len(column):
            raise BadArgument(f"{name} has {len(column)} times and {len(values)} keys; expected one for each")
        columns.append(values)
    return tuple(columns)


def checked_handles(handles: Any, names: tuple[str, ...], times: Columns, interpolation: str) -> Columns:
    """Return the handles of each joint, shape (k, 2, 2), within their segments in time."""
    if interpolation != "bezier":
        raise BadArgument(f"handles belong to bezier interpolation, got {interpolation}")
    rows = _rows(handles, "handles")
    if len(rows) != len(names):
        raise BadArgument(f"handles must have one array for each of {len(names)} joints, got {len(rows)}")
    columns = []
    for name, row, column in zip(names, rows, times, strict=True):
        values = np.array(shaped(row, (len(column), 2, 2), f"handles of {name}"))
        _check_within(values, column, name)
        columns.append(values)
    return tuple(columns)


def _check_within(handles: Floats, times: Floats, name: str) -> None:
    """Refuse handles that leave their segment in time; the outermost handles may have any length."""
    widths = np.diff(times)
    limits = [np.concatenate([[np.inf], widths]), np.concatenate([widths, [np.inf]])]
    for side, (word, sign) in enumerate((("before", -1.0), ("after", 1.0))):
        length = sign * handles[:, side, 0]
        slack = _HANDLE_ROUNDING * np.where(np.isfinite(limits[side]), limits[side], 1.0)
        wrong = (length < -slack) | (length > limits[side] + slack)
        if wrong.any():
            key = int(np.argmax(wrong))
            offset = float(handles[key, side, 0])
            lower, upper = (-limits[side][key], 0.0) if side == 0 else (0.0, limits[side][key])
            raise BadArgument(
                f"{name}: the handle {word} key {key} is {offset:.9g} s from it, expected between {lower:.9g} and "
                f"{upper:.9g} s: within the segment"
            )


def out_of_order(times: Floats) -> tuple[int, str] | None:
    """Return the index of the first time that does not ascend, and how it compares with its predecessor, or None."""
    ascends = np.diff(times) > 0.0
    if ascends.all():
        return None
    key = int(np.argmin(ascends)) + 1
    return key, "the same as" if times[key] == times[key - 1] else "before"


def _check_ascending(times: Floats, what: str) -> None:
    wrong = out_of_order(times)
    if wrong is not None:
        key, word = wrong
        raise BadArgument(
            f"{what} must ascend: {times[key]:.9g} s at index [{key}] is {word} {times[key - 1]:.9g} s at [{key - 1}]"
        )


def _checked_column(values: Any, what: str) -> Floats:
    array = np.array(as_floats(values, (), what))
    if array.ndim != 1:
        raise WrongShape(what, "(k,)", array.shape)
    if len(array) == 0:
        raise BadArgument(f"{what} must have at least one key, got none")
    return array


def _rows(values: Any, what: str) -> list[Any]:
    """Return the entries of a list; for a 1-D array of numbers, only the first."""
    array = values if isinstance(values, np.ndarray) and values.ndim < 2 else None
    rows = list(values if array is None else array.reshape(-1)[:1])
    if not rows:
        raise BadArgument(f"{what} must have at least one entry, got none")
    return rows


def _is_single(value: Any) -> bool:
    return value.ndim == 0 if isinstance(value, np.ndarray) else not isinstance(value, Iterable)


# --- Configurations of a robot: sampling times, and values of the joints that a motion does not name.

HOLD = "hold"
# Configurations, samples or keys of a joint: 800 MB for 25 joints.
MAX_SAMPLES = 4_000_000
# Samples per second of the balance, samples at rest before and after a motion, and the longest motion [s].
_BALANCE_RATE, REST, _LONGEST = 100.0, 20, 3600.0
# A last step shorter than this share of a step is rounding.
_ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Configurations at times.

    Attributes:
        times: shape (n,) [s].
        q: configurations, shape (n, nq).
    """

    times: Floats
    q: Floats

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        span = f", {self.times[0]:g} to {self.times[-1]:g} s" if len(self.times) else ""
        return f"<Trajectory of {len(self.times)} configurations{span}>"


def sampling_times(motion: Motion, rate: float | None, times: ArrayLike | None) -> Floats:
    """Return the sampling times (n,): the given times, times at a rate, or the key times."""
    if times is not None:
        if rate is not None:
            raise BadArgument("rate and times both set the times; give one")
        at = np.array(as_floats(times, (), "times"))
        if at.ndim != 1:
            raise WrongShape("times", "(n,)", at.shape)
        return at
    if rate is None:
        return motion.key_times
    number = float(positive(rate, "rate"))
    steps = motion.duration * number
    if not steps < MAX_SAMPLES:
        raise BadArgument(
            f"{motion.duration:g} s at {number:g} per second are {steps:.3g} samples, "
            f"more than {MAX_SAMPLES}; give a smaller rate"
        )
    at = motion.start + np.arange(int(steps + _ROUNDING) + 1) / number
    # A duration that rounds to a whole number of steps has no short step at its end.
    if steps - (len(at) - 1) > _ROUNDING:
        return np.append(at, motion.end)
    at[-1] = motion.end
    return at


def filled(robot: RobotModel, missing: str | ArrayLike) -> Floats:
    """Return the configuration (nq,) with the values of the joints that a motion does not name."""
    if isinstance(missing, str):
        if missing != HOLD:
            if missing not in robot.posture_names:
                raise UnknownName("posture", missing, (*robot.posture_names, HOLD))
            return robot.posture(missing)
        start = robot.semantics.start
        return robot.posture(start) if start in robot.posture_names else robot.clamp(robot.neutral())
    q = as_floats(missing, (), "missing")
    if q.shape == ():
        return robot.configuration({}, missing=float(q))
    if q.shape != (robot.nq,):
        raise WrongShape("missing", f"({robot.nq},), or be a number or the name of a posture", q.shape)
    return np.array(robot.checked(q))


# --- The motion itself.


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Motion(Guessing):
    """Joints that move through keys, each at its own times.

    Before its first and after its last key a joint stands still. A motion names only the joints that it moves; the
    other joints get their values when the motion is converted to configurations.

    Attributes:
        times: for each joint the times of its keys, strictly ascending, shape (k,) [s].
        joint_names: the joints, by their names in the URDF; RHipYawPitch may be named as well as LHipYawPitch.
        keys: for each joint its values at these times, shape (k,) [rad, m or ratio; a hand is 0 closed to 1 open].
        interpolation: the curve between two keys of a joint. "linear": a straight line. "smooth": a monotone cubic
            (Fritsch–Butland), at rest at the first and the last key. "bezier": a cubic in time and value with handles.
        handles: for "bezier", for each joint shape (k, 2, 2): key, before or after it, offset in time [s] and in value,
            as in NAOqi; otherwise None. By default they are a third of their segment long, along the slope of "smooth".
            Offsets in time are ≤ 0 before and ≥ 0 after a key, and end within the segment.

    The arrays are read-only copies.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nod.joint_names, float(nod.sample(0.25)[0])
        (('HeadPitch',), 0.15)
    """

    times: tuple[Floats, ...]
    joint_names: tuple[str, ...]
    keys: tuple[Floats, ...]
    interpolation: Interpolation
    handles: tuple[Floats, ...] | None

    def __init__(
        self,
        times: ArrayLike | Sequence[ArrayLike],
        joint_names: Sequence[str],
        keys: ArrayLike | Sequence[ArrayLike],
        interpolation: Interpolation = "linear",
        handles: Sequence[ArrayLike] | None = None,
    ) -> None:
        """Make a motion from its keys.

        Args:
            times: one list for all joints, (n,), or a list of lists, one for each joint.
            joint_names: the joints.
            keys: for one list of times a row for each time, (n, joints); otherwise a list for each joint.
            interpolation: "linear", "smooth" or "bezier".
            handles: for "bezier", one array (k, 2, 2) for each joint.

        Raises:
            BadArgument: no joints or keys, a joint named twice, times that do not ascend, handles that leave their
                segment, or handles without "bezier".
            WrongShape: times, keys and handles that do not fit together.
        """
        names = checked_names(joint_names)
        choice(interpolation, INTERPOLATIONS, "interpolation")
        columns, shared = checked_times(times, names)
        values = checked_keys(keys, names, columns, shared=shared)
        offsets = None
        if handles is not None:
            offsets = checked_handles(handles, names, columns, interpolation)
        elif interpolation == "bezier":
            offsets = tuple(bezier_handles("smooth", t, v) for t, v in zip(columns, values, strict=True))
        for name, column in zip(names, values, strict=True):
            if warn_of_degrees(column, name):
                break
        for array in (*columns, *values, *(offsets or ())):
            array.flags.writeable = False
        for field, value in zip(fields(self), (columns, names, values, interpolation, offsets), strict=True):
            object.__setattr__(self, field.name, value)

    @property
    def start(self) -> float:
        """Time of the first key of all joints [s]."""
        return float(min(times[0] for times in self.times))

    @property
    def end(self) -> float:
        """Time of the last key of all joints [s]."""
        return float(max(times[-1] for times in self.times))

    @property
    def duration(self) -> float:
        """Time from the first key to the last [s]."""
        return self.end - self.start

    @property
    def key_times(self) -> Floats:
        """All times at which some joint has a key, ascending, shape (n,) [s]."""
        distinct = {id(times): times for times in self.times}
        return np.unique(np.concatenate(list(distinct.values())))

    def sample(self, t: ArrayLike) -> Floats:
        """Return joint values at times.

        Args:
            t: times, shape (...) [s].

        Returns:
            Shape (..., joints), in the order of `joint_names` [rad, m or ratio].

        Examples:
            >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
            >>> nod.sample([0.0, 0.25, 0.5]).tolist()
            [[0.0], [0.15], [0.3]]
        """
        return self._evaluated(t, speed=False)

    def speed(self, t: ArrayLike) -> Floats:
        """Return joint speeds at times: the derivative of `sample`.

        At a key the speed is that of the segment that begins there, at a joint's last key that of the segment that ends
        there; before and after its keys a joint does not move. A vertical Bezier curve has infinite speed.

        Args:
            t: times, shape (...) [s].

        Returns:
            Shape (..., joints) [unit of the joint per s].

        Examples:
            >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
            >>> nod.speed([0.25, 0.75]).round(3).tolist()
            [[0.6], [-0.6]]
        """
        return self._evaluated(t, speed=True)

    def configurations(
        self,
        robot: RobotModel,
        *,
        rate: float | None = None,
        times: ArrayLike | None = None,
        missing: str | ArrayLike = HOLD,
        hips: Hips = "average",
    ) -> Trajectory:
        """Return the configurations of a robot that performs the motion; limits are not checked.

        Args:
            robot: has all the joints named.
            rate: configurations per second, from the first key on; the last one is at the last key, possibly after a
                shorter step. Without `rate` and `times` there is one for each key time.
            times: times of the configurations, shape (n,) [s].
            missing: values of the joints not named, and of a floating base: the name of a posture, a number, a
                configuration (nq,), or "hold": the robot's start posture (StandInit for a NAO), or else zero, moved to
                the nearest limit.
            hips: value of a motor that the motion names twice, such as LHipYawPitch and RHipYawPitch: the "average", or
                the "left" or "right" one. It applies to all mimic joints; without sides in their names the average is
                used.

        Returns:
            Times (n,) and q (n, nq).

        Raises:
            BadArgument: more than 4 million configurations.

        Examples:
            >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
            >>> trajectory = nod.configurations(nk.load_nao(), rate=50.0)
            >>> trajectory.q.shape
            (51, 25)
        """
        check_joints(robot, self)
        check_hips(hips)
        at = sampling_times(self, rate, times)
        q = np.tile(filled(robot, missing), (len(at), 1))
        values = dict(zip(self.joint_names, self.sample(at).T, strict=True))
        for joint, column in robot.motor_values(values, hips).items():
            q[:, robot.nq_base + robot.joint_names.index(joint)] = column
        return Trajectory(at, q)

    def balance(self, robot: RobotModel, *, missing: str | ArrayLike = HOLD) -> DynamicBalance:
        """Return the balance of a robot that performs the motion, in 100 samples per second.

        The robot stands still before and after the motion, and the first and the last 20 samples are of these times.

        Args:
            robot: has all the joints named.
            missing: values of the joints not named, as in `configurations`.

        Raises:
            BadArgument: the motion lasts more than an hour; the errors of `nk.world.dynamic_balance`.

        Examples:
            >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
            >>> round(float(nod.balance(nk.load_nao()).margin.min()), 3)
            0.058
        """
        if not self.duration <= _LONGEST:
            raise BadArgument(f"the balance of at most an hour is sampled, {_LONGEST:g} s, got {self.duration:.6g} s")
        count = math.ceil(self.duration * _BALANCE_RATE) + 2 * REST + 1
        times = self.start + (np.arange(count) - REST) / _BALANCE_RATE
        q = self.configurations(robot, times=np.clip(times, self.start, self.end), missing=missing).q
        return dynamic_balance(robot, q, times)

    def as_bezier(self) -> Motion:
        """Return the same curves, up to rounding, as Bezier curves with handles.

        Examples:
            >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
            >>> bezier = nod.as_bezier()
            >>> bezier.interpolation, np.allclose(bezier.sample(0.3), nod.sample(0.3))
            ('bezier', True)
        """
        if self.interpolation == "bezier":
            return self
        pairs = zip(self.times, self.keys, strict=True)
        handles = [bezier_handles(self.interpolation, times, keys) for times, keys in pairs]
        return Motion(self.times, self.joint_names, self.keys, "bezier", handles)

    @cached_property
    def segments(self) -> tuple[Segments, ...]:
        """The cubics between the keys of each joint."""
        handles = self.handles or (None,) * len(self.keys)
        return tuple(map(partial(segments, self.interpolation), self.times, self.keys, handles))

    @cached_property
    def _polynomials(self) -> list[Floats] | None:
        """The curves of all joints as polynomials in the share of a segment's time, if their key times are the same.

        The coefficients, in ascending order, have the shape (segments, joints); None if a curve is not a polynomial.
        """
        times, curves = self.times[0], self.segments
        if len(times) < 2 or len(curves) < 2 or any(column is not times for column in self.times[1:]):
            return None
        if any(curve.lengths is not None for curve in curves):
            return None
        first = np.stack([curve.first for curve in curves], axis=-1)
        p, q, d = np.moveaxis(np.stack([curve.controls for curve in curves], axis=-1), 1, 0)
        straight = self.interpolation == "linear"
        return [first, d] if straight else [first, 3.0 * p, 3.0 * (q - 2.0 * p), d - 3.0 * (q - p)]

    def _at_once(self, coefficients: list[Floats], t: Floats, *, speed: bool) -> Floats:
        """Return the values or speeds (n, joints) of all joints at times (n,), by Horner's method."""
        curve, times = self.segments[0], self.times[0]
        segment = curve.at(t)
        x = curve.parameter(segment, t)[:, None]
        if speed:
            coefficients = [power * column for power, column in enumerate(coefficients)][1:]
        rows = coefficients[-1][segment]
        for column in coefficients[-2::-1]:
            rows *= x
            rows += column[segment]
        if speed:
            rows /= curve.width[segment, None]
            rows[(t < times[0]) | (t > times[-1])] = 0.0
        else:
            rows[t >= times[-1]] = [keys[-1] for keys in self.keys]  # exactly the keys: a sum would be rounded
        return rows

    def _evaluated(self, t: ArrayLike, *, speed: bool) -> Floats:
        wanted = as_floats(t, (), "t")
        flat = np.clip(wanted.reshape(-1), self.start - 1.0, self.end + 1.0)  # outside, nothing moves
        if self._polynomials is not None:
            return self._at_once(self._polynomials, flat, speed=speed).reshape(*wanted.shape, len(self.keys))
        # Joint by joint in memory, as it is filled.
        result = np.empty((len(self.keys), len(flat)))
        column_times, place = None, np.zeros(0, dtype=np.intp)
        for column, (times, keys) in enumerate(zip(self.times, self.keys, strict=True)):
            if len(keys) == 1:
                result[column] = 0.0 if speed else keys[0]
            elif self.interpolation == "linear" and not speed:
                result[column] = np.interp(flat, times, keys)
            else:
                pieces = self.segments[column]
                if times is not column_times:
                    column_times, place = times, pieces.at(flat)
                u = pieces.parameter(place, flat)
                if speed:
                    inside = (flat >= times[0]) & (flat <= times[-1])
                    result[column] = np.where(inside, pieces.speed(place, u), 0.0)
                else:
                    result[column] = np.where(u >= 1.0, keys[place + 1], pieces.value(place, u))
        return np.ascontiguousarray(result.T).reshape(*wanted.shape, len(self.keys))

    def __eq__(self, other: object) -> bool:
        """Whether names, times, keys, interpolation and handles are equal, to the last bit."""
        if not isinstance(other, Motion):
            return NotImplemented
        if self.joint_names != other.joint_names or self.interpolation != other.interpolation:
            return False
        mine = (*self.times, *self.keys, *(self.handles or ()))
        theirs = (*other.times, *other.keys, *(other.handles or ()))
        return all(one is two or np.array_equal(one, two) for one, two in zip(mine, theirs, strict=True))

    __hash__ = None  # type: ignore[assignment]

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(**state)  # type: ignore[misc]

    def __repr__(self) -> str:
        count = sum(map(len, self.keys))
        joints = len(self.joint_names)
        return (
            f"<Motion of {joints} joint{'s' if joints > 1 else ''}, {count} keys, "
            f"{self.interpolation}, {self.start:g} to {self.end:g} s>"
        )


def check_joints(robot: RobotModel, motion: Motion) -> None:
    """Refuse a motion with joints that the robot does not have."""
    for name in motion.joint_names:
        if name not in robot.joint_names and name not in robot.mimics:
            raise UnknownName("joint", name, (*robot.joint_names, *robot.mimics))
