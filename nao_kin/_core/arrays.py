"""Checks of arguments: arrays, vectors, numbers, poses, colours and names."""

from __future__ import annotations

import math
import numbers
import operator
from collections.abc import Iterable
from typing import Any, Literal, SupportsIndex, TypeGuard, cast, get_args

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, NotFinite, UnknownName, WrongShape, ZeroNorm, at_index

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]

# Below this size, setting up the error state of a sum costs more than the exact search.
_SMALL = 2000


def as_floats(value: ArrayLike, tail: tuple[int, ...], what: str, *, gaps: bool = False) -> Floats:
    """Return `value` as a finite float64 array of shape (..., *tail); not copied if it is one already.

    With `gaps`, NaN is accepted.
    """
    array = as_numbers(value, what)
    if array.shape[array.ndim - len(tail) :] != tail or array.ndim < len(tail):
        raise WrongShape(what, f"(..., {', '.join(map(str, tail))})" if tail else "(...)", array.shape)
    if not all_finite(array):
        refuse_non_finite(np.where(np.isnan(array), 0.0, array) if gaps else array, what)
    return array


def shaped(value: ArrayLike, shape: tuple[int, ...], what: str, *, gaps: bool = False) -> Floats:
    """Return `value` as a finite float64 array of exactly this shape; with `gaps`, NaN is accepted."""
    array = as_floats(value, (), what, gaps=gaps)
    if array.shape != shape:
        raise WrongShape(what, str(shape), array.shape)
    return array


def positive(value: ArrayLike, what: str, shape: tuple[int, ...] = ()) -> Floats:
    """Return `value` as finite numbers above zero of exactly this shape."""
    array = shaped(value, shape, what)
    if not (array > 0.0).all():
        raise BadArgument(f"{what} must be positive, got {quoted(value)}")
    return array


def all_finite(array: Floats) -> bool:
    """Return whether no entry is NaN or infinite; for large arrays at the cost of one sum."""
    if array.size > _SMALL:
        # A sum, not a dot product: BLAS would use threads, which take ten times as long on a busy machine.
        with np.errstate(over="ignore", invalid="ignore"):
            if math.isfinite(array.sum()):
                return True
    return bool(np.isfinite(array).all())


def as_numbers(value: ArrayLike, what: str) -> Floats:
    """Return `value` as a float64 array of any shape; refuse ragged, textual and complex input and masked entries."""
    if type(value) is np.ndarray and value.dtype == np.float64:
        return value
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise BadArgument(f"{what} has masked entries; fill them first, as in {what}.filled(0.0)")
    try:
        array: NDArray[Any] = np.asarray(value)
        if array.dtype.kind not in "fiub":
            raise TypeError
        with np.errstate(over="ignore"):  # of long doubles, which become infinite
            return array.astype(np.float64)
    except (TypeError, ValueError, np.ma.MaskError):
        way = "; robot.configuration takes joints by name, robot.posture names a posture" if what == "q" else ""
        raise BadArgument(f"{what} must be real numbers, got {quoted(value, 60)}{way}") from None


def refuse_non_finite(array: Floats, what: str) -> None:
    """Raise `NotFinite` for the first NaN or infinity of `array`, if it has one."""
    finite = np.isfinite(array)
    if not finite.all():
        index = tuple(int(i) for i in np.argwhere(~finite)[0])
        raise NotFinite(what, index, float(array[index]))


# --- Vectors along the last axis, and batch shapes.


def dot(a: Floats, b: Floats) -> Floats:
    """Return the scalar products a·b, shape (...)."""
    return np.asarray(np.einsum("...i,...i->...", a, b), dtype=np.float64)


def norm(v: Floats) -> Floats:
    """Return ‖v‖, shape (...); components under 1e-160 count as zero."""
    return np.asarray(np.sqrt(dot(v, v)), dtype=np.float64)


def largest(v: Floats) -> Floats:
    """Return the largest magnitude of the components, shape (...), in a tenth of the time of a NumPy reduction."""
    sizes = np.abs(v)
    found = sizes[..., 0]
    for i in range(1, v.shape[-1]):
        found = np.maximum(found, sizes[..., i])
    return np.asarray(found)


def unit(v: Floats, what: str) -> tuple[Floats, Floats]:
    """Return v/‖v‖ and ‖v‖, accurate even for the smallest floats; zero raises `ZeroNorm`."""
    _, exponent = np.frexp(largest(v))
    # A power of two scales the vector to a length near 1 without rounding, so that no square underflows. 2^1023 is
    # the largest power of two in float64, and large enough for the smallest floats.
    shift = np.minimum(-exponent, 1023)
    scaled = v * np.ldexp(1.0, shift)[..., None]
    length = norm(scaled)
    if not length.all():
        raise ZeroNorm(what, first_index(length == 0.0))
    with np.errstate(over="ignore"):
        return scaled / length[..., None], np.ldexp(length, -shift)


def runs(mask: NDArray[np.bool_]) -> list[slice]:
    """Return the slices of consecutive rows in which a mask (n,) is true."""
    edges = np.flatnonzero(np.diff(mask, prepend=False, append=False))
    return [slice(start, stop) for start, stop in edges.reshape(-1, 2).tolist()]


def eased(share: Floats) -> Floats:
    """Return shares from 0 to 1 that begin and end with a slope of zero, for shares that grow evenly."""
    return share * share * (3.0 - 2.0 * share)


def between_samples(values: Floats, times: Floats | None = None, at: Floats | None = None) -> Floats:
    """Return columns (n, c) with nan interpolated between neighbouring samples; a column of only nan is not changed.

    With `times` (n,) of the samples the lines are straight in time; with `at` (m,) the rows are at other times.
    """
    samples = np.arange(float(len(values))) if times is None else times
    wanted = samples if at is None else at
    found = np.array(values) if at is None else np.full((len(wanted), values.shape[1]), np.nan)
    for column in range(values.shape[1]) if at is not None else np.flatnonzero(np.isnan(values).any(axis=0)):
        known = ~np.isnan(values[:, column])
        if known.any():
            found[:, column] = np.interp(wanted, samples[known], values[known, column])
    return found


def drawn_ranges(lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    """Return the ends of ranges from which joint values are drawn: a turn from one limit, [−π, π] without limits."""
    low = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper - 2 * np.pi, -np.pi))
    return low, np.where(np.isfinite(upper), upper, low + 2 * np.pi)


def cross(a: Floats, b: Floats) -> Floats:
    """Return the vector products a × b, shape (..., 3), for any batch shape; np.cross allows only 32 axes."""
    (a0, a1, a2), (b0, b1, b2) = ([v[..., i] for i in range(3)] for v in (a, b))
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=-1)


def cross_matrix(v: Floats) -> Floats:
    """Return the matrices V of shape (..., 3, 3) with V w = v × w for every w."""
    V = np.zeros((*v.shape, 3))
    V[..., 2, 1], V[..., 0, 2], V[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    V[..., 1, 2], V[..., 2, 0], V[..., 0, 1] = -v[..., 0], -v[..., 1], -v[..., 2]
    return V


def rigid_inverse(T: Floats) -> Floats:
    """Return the inverses of rigid transforms, shape (..., 4, 4)."""
    found = np.zeros(T.shape)
    found[..., :3, :3] = np.swapaxes(T[..., :3, :3], -1, -2)
    found[..., :3, 3] = -np.einsum("...ji,...j->...i", T[..., :3, :3], T[..., :3, 3])
    found[..., 3, 3] = 1.0
    return found


def common_batch(what: str, *batch_shapes: tuple[int, ...]) -> tuple[int, ...]:
    """Return the shape to which all batch shapes broadcast, or raise `WrongShape`."""
    if len(set(batch_shapes)) == 1:
        return batch_shapes[0]
    try:
        return np.broadcast_shapes(*batch_shapes)
    except ValueError:
        shapes = " and ".join(map(str, batch_shapes))
        raise WrongShape(f"batch axes of {what}", "compatible for broadcasting", shapes) from None


def first_index(mask: NDArray[np.bool_]) -> tuple[int, ...]:
    """Return the index of the first true entry of `mask`."""
    return tuple(int(i) for i in np.argwhere(mask)[0])


# --- Single numbers.

# A larger number of threads, searches or steps is a mistake, and would take forever.
MAX_THREADS, MAX_SEARCHES = 10_000, 1_000_000


def finite_decimal(text: str) -> float | None:
    """Return the finite number that `text` writes in decimal digits, or None if it does not write one."""
    try:
        # In ASCII text `float` accepts only decimal digits and underscores; blanks of any script around it are allowed.
        number = float(text) if text.strip().isascii() and "_" not in text else math.nan
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def float_dtype(dtype: DTypeLike | None) -> np.dtype[Any]:
    """Return the dtype, which must be float64 or float32."""
    try:
        kind = np.dtype(dtype)
    except (TypeError, ValueError):
        kind = np.dtype(object)
    if kind not in (np.float64, np.float32):
        raise BadArgument(f"dtype must be float64 or float32, got {quoted(dtype)}")
    return kind


def finite_or_none(value: float) -> float | None:
    """Return `value`, or None if it is infinite or NaN, because JSON has no such numbers."""
    return value if math.isfinite(value) else None


def whole_number(value: SupportsIndex, what: str, minimum: int, maximum: int | None = None) -> int:
    """Return `value` as an int of at least `minimum`, and at most `maximum` if given, or raise `BadArgument`."""
    try:
        number = operator.index(value)
    except TypeError:
        raise BadArgument(f"{what} must be a whole number, got {quoted(value)}") from None
    if number >= minimum and (maximum is None or number <= maximum):
        return number
    bound = f"at least {minimum}" if number < minimum else f"at most {maximum}"
    raise BadArgument(f"{what} must be {bound}, got {number}")


def single_number(value: ArrayLike, what: str) -> float:
    """Return a number that is not NaN, or raise `BadArgument`."""
    number = as_numbers(value, what)
    if number.ndim or np.isnan(number):
        raise BadArgument(f"{what} must be a number, got {quoted(value, 60)}")
    return float(number)


def batch_index(index: object, shape: tuple[int, ...]) -> tuple[int, ...]:
    """Return the index of one entry of a batch as a tuple, or raise `BadArgument`."""
    several: Any = index if isinstance(index, (tuple, list)) else (index,)
    try:
        found = tuple(map(operator.index, several))
        if len(found) == len(shape) and all(-n <= i < n for i, n in zip(found, shape, strict=True)):
            return found
    except TypeError:
        pass
    raise BadArgument(f"index must be that of one entry of a batch of shape {shape}, got {quoted(index)}")


def generator(rng: object) -> np.random.Generator:
    """Return NumPy's generator of random numbers for a generator, a seed (whole numbers), or None.

    NumPy itself crashes the interpreter for a matrix and for a list that contains itself.
    """
    seed: Any = rng
    taken = np.random.Generator, np.random.BitGenerator, np.random.RandomState, np.random.SeedSequence
    try:
        if rng is not None and not isinstance(rng, taken):
            several = isinstance(rng, (list, tuple, range)) or (isinstance(rng, np.ndarray) and rng.ndim == 1)
            seed = list(map(operator.index, seed)) if several else operator.index(seed)
        return np.random.default_rng(seed)
    except (TypeError, ValueError):
        raise BadArgument(f"rng must be a generator, or a seed of whole numbers from 0, got {quoted(rng)}") from None


def check_tolerance(tolerance: object, what: str = "tolerance") -> None:
    """Raise `BadArgument` for anything but one number ≥ 0."""
    if not (isinstance(tolerance, numbers.Real) and float(tolerance) >= 0.0):
        raise BadArgument(f"{what} must be a number ≥ 0, got {quoted(tolerance)}")


# --- Poses [[R, t], [0, 1]].

_LAST_ROW = (0.0, 0.0, 0.0, 1.0)


def join_poses(R: Floats, t: Floats) -> Floats:
    """Return the poses [[R, t], [0, 1]], shape (..., 4, 4), of matrices (..., 3, 3) and translations (..., 3)."""
    T = np.empty((*common_batch("rotations and translations", R.shape[:-2], t.shape[:-1]), 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, :] = R, t, _LAST_ROW
    return T


# --- Colours of numbers: equally spaced (red, green, blue), from the lowest value to the highest.
COLD_TO_WARM: tuple[tuple[float, float, float], ...] = (
    (0.16, 0.32, 0.66),
    (0.36, 0.63, 0.83),
    (0.90, 0.91, 0.88),
    (0.95, 0.66, 0.36),
    (0.74, 0.17, 0.12),
)


def colours(values: ArrayLike, low: float, high: float) -> Floats:
    """Return the colours (red, green, blue) in [0, 1], shape (..., 3), of numbers on a scale from low to high > low."""
    at = np.linspace(low, high, len(COLD_TO_WARM))
    numbers = np.asarray(values, dtype=np.float64)
    return np.stack([np.interp(numbers, at, channel) for channel in zip(*COLD_TO_WARM, strict=True)], axis=-1)


# --- Names and booleans.


def choice(value: object, valid: Iterable[str], what: str, hint: str = "") -> str:
    """Return `value`, or raise `UnknownName` if it is not one of the valid names."""
    names = tuple(valid)
    if not isinstance(value, str) or value not in names:
        raise UnknownName(what, value, names, hint)
    return value


# What to do with joint values outside their limits: refuse them, move them to the nearest limit, or accept them.
LimitPolicy = Literal["enforce", "clamp", "ignore", "measured"]
SolverLimits = Literal["enforce", "ignore"]  # of inverse kinematics
_POLICIES: tuple[LimitPolicy, ...] = get_args(LimitPolicy)


def limit_policy(limits: object, valid: Iterable[LimitPolicy] = _POLICIES) -> LimitPolicy:
    """Return a limits policy, or raise `UnknownName` if it is not one of the `valid` ones."""
    return cast(LimitPolicy, choice(limits, valid, "limits policy"))


def check_kind(value: object, what: str, kind: type | tuple[type, ...]) -> None:
    """Raise `BadArgument` unless the value is of a type, or of one of several."""
    if not isinstance(value, kind):
        kinds = kind if isinstance(kind, tuple) else (kind,)
        raise BadArgument(f"{what} must be of the type {' or '.join(k.__name__ for k in kinds)}, got {quoted(value)}")


def flag(value: object, what: str) -> bool:
    """Return a boolean unchanged, or raise `BadArgument`; Python would take any non-empty text as true."""
    if not isinstance(value, (bool, np.bool_)):
        raise BadArgument(f"{what} must be True or False, got {quoted(value)}")
    return bool(value)


def is_several(values: object) -> TypeGuard[Iterable[Any]]:
    """Return whether a value can be iterated over; texts are one value, and arrays without axes have no entries."""
    return isinstance(values, Iterable) and not isinstance(values, str) and getattr(values, "ndim", 1) != 0


def texts(values: object, what: str) -> tuple[str, ...]:
    """Return the texts of a list or another sequence as a tuple, or raise `BadArgument`."""
    if not is_several(values):
        raise BadArgument(f"{what} must be a list of texts, got {quoted(values)}")
    found = tuple(values)
    for value in found:
        if not isinstance(value, str):
            raise BadArgument(f"{what} must be texts, got {quoted(value)}")
    return found


def rows_with_gravity(q: Floats, gravity: ArrayLike | None) -> tuple[tuple[int, ...], Floats, Floats | None]:
    """Return the common batch shape of q and gravity, and both as rows, gravity as unit vectors (n, 3) or None."""
    batch, down = q.shape[:-1], None
    if gravity is not None:
        given = unit(as_floats(gravity, (3,), "gravity"), "gravity")[0]
        batch = common_batch("configurations and gravity", batch, given.shape[:-1])
        down = np.broadcast_to(given, (*batch, 3)).reshape(-1, 3)
    return batch, np.broadcast_to(q, (*batch, q.shape[-1])).reshape(-1, q.shape[-1]), down


def as_pixels(pixels: ArrayLike) -> Floats:
    """Return pixels as an array (..., 2); NaN, which stands for no pixel, is allowed."""
    uv = as_numbers(pixels, "pixels")
    if uv.shape[-1:] != (2,):
        raise WrongShape("pixels", "(..., 2)", uv.shape)
    if np.isinf(uv).any():
        raise BadArgument(f"pixels must not be infinite{at_index(first_index(np.isinf(uv)))}")
    return uv


# --- Tolerances and thresholds that several rooms share.

# A value that exceeds a limit by no more than this [rad, m or ratio] is accepted unchanged: files have single precision
# (1e-7 of a value) or six decimals (5e-7), and limits converted from degrees are rounded.
LIMIT_TOLERANCE = 1e-6
# With limits="measured", joints of these units may exceed their limits by this: recordings of real NAOs do so by up to
# 4.3° (RoboCup and gesture logs, all joints), as their backlash, their zeros and the noise of their sensors add up.
MEASURED_TOLERANCES = {"rad": math.radians(5.0), "1": 0.02}
# Two values for one motor agree if they differ by less than the resolution of single precision.
COUPLING_TOLERANCE = 1e-6
# A quaternion whose norm differs from 1 by less than this is accepted, and divided by its norm.
UNIT_TOLERANCE = 1e-6
# How far above the floor a point may be and still touch it [m].
TOUCHING = 0.002
# How much lower the other sole must be to become the support [m].
LOWER = 1e-3
# From this number of configurations on, the kernels are used. When loaded, they are as fast as Pinocchio for 3 to 8
# configurations, but loading them takes as long as tens of thousands of configurations, too long for a handful.
CROSSOVER = 32
