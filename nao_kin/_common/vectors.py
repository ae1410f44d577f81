"""Vectors along the last axis: unit vectors at every scale, cross-product matrices, batch shapes that fit together."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats, as_floats
from nao_kin.errors import BadArgument, WrongShape, ZeroNorm

LARGEST = 1e150
MOST_BATCH_AXES = 62


def as_batch(value: ArrayLike, tail: tuple[int, ...], what: str) -> Floats:
    """`value` as in `as_floats`, of shape (..., *tail), with at most 62 batch axes.

    NumPy's arrays end at 64 axes, and what is computed of one item is a matrix at most.

    Raises:
        WrongShape: more batch axes; or as in `as_floats`.
        BadArgument, NotFinite: as in `as_floats`.
    """
    array = as_floats(value, tail, what)
    if array.ndim - len(tail) > MOST_BATCH_AXES:
        raise _too_many_axes(array.ndim - len(tail), tail, what)
    return array


def as_vectors(value: ArrayLike, what: str, size: int = 3, *, rows: bool = False) -> Floats:
    """`value` as finite vectors of shape (..., size), or (..., n, size) for `rows`, whose squares do not overflow.

    Raises:
        BadArgument: a component outside ±1e150; or not numbers.
        WrongShape, NotFinite: as in `as_batch`.
    """
    with np.errstate(over="ignore"):
        vectors = as_floats(value, (size,), what)
    batch_axes = vectors.ndim - (2 if rows else 1)
    if batch_axes > MOST_BATCH_AXES:
        raise _too_many_axes(batch_axes, (size,), what)
    if vectors.size and np.abs(vectors).max() > LARGEST:
        raise BadArgument(f"{what} must not exceed {LARGEST:.0e} in magnitude, got {np.abs(vectors).max():.3g}")
    return vectors


def dot(a: Floats, b: Floats) -> Floats:
    """The scalar products a·b, shape (...)."""
    return np.asarray(np.einsum("...i,...i->...", a, b), dtype=np.float64)


def norm(v: Floats) -> Floats:
    """‖v‖, shape (...); components under 1e-160 count as zero."""
    return np.asarray(np.sqrt(dot(v, v)), dtype=np.float64)


def largest(v: Floats) -> Floats:
    """The largest magnitude of the components, shape (...).

    Component by component: along so short an axis a reduction costs ten times as much.
    """
    sizes = np.abs(v)
    found = sizes[..., 0]
    for i in range(1, v.shape[-1]):
        found = np.maximum(found, sizes[..., i])
    return np.asarray(found)


def unit(v: Floats, what: str) -> tuple[Floats, Floats]:
    """v/‖v‖ and ‖v‖, right down to the smallest floats; lengths beyond the largest are infinite.

    Raises:
        ZeroNorm: some vector is exactly zero; carries its index.
    """
    _, exponent = np.frexp(largest(v))
    # A power of two takes the vector near length 1 without rounding it, so that no square underflows. One below
    # 2^1024, that of the smallest floats, ends as near to 1 as need be.
    shift = np.minimum(-exponent, 1023)
    scaled = v * np.ldexp(1.0, shift)[..., None]
    length = norm(scaled)
    if not length.all():
        raise ZeroNorm(what, first_index(length == 0.0))
    with np.errstate(over="ignore"):
        return scaled / length[..., None], np.ldexp(length, -shift)


def cross(a: Floats, b: Floats) -> Floats:
    """The vector products a × b, shape (..., 3); unlike np.cross, which ends at 32 axes, for every batch."""
    (a0, a1, a2), (b0, b1, b2) = ([v[..., i] for i in range(3)] for v in (a, b))
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=-1)


def cross_matrix(v: Floats) -> Floats:
    """The matrices V of shape (..., 3, 3) with V w = v × w for every w."""
    V = np.zeros((*v.shape, 3))
    V[..., 2, 1], V[..., 0, 2], V[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    V[..., 1, 2], V[..., 2, 0], V[..., 0, 1] = -v[..., 0], -v[..., 1], -v[..., 2]
    return V


def rigid_inverse(T: Floats) -> Floats:
    """The inverses of rigid transforms, shape (..., 4, 4)."""
    found = np.zeros(T.shape)
    found[..., :3, :3] = np.swapaxes(T[..., :3, :3], -1, -2)
    found[..., :3, 3] = -np.einsum("...ji,...j->...i", T[..., :3, :3], T[..., :3, 3])
    found[..., 3, 3] = 1.0
    return found


def common_batch(what: str, *batch_shapes: tuple[int, ...]) -> tuple[int, ...]:
    """The batch shape that all of `batch_shapes` broadcast to.

    Raises:
        WrongShape: there is none.
    """
    if len(set(batch_shapes)) == 1:
        return batch_shapes[0]
    # Not by np.broadcast_shapes, which ends at 32 axes.
    longest = max(map(len, batch_shapes))
    common = []
    for sizes in zip(*((1,) * (longest - len(shape)) + shape for shape in batch_shapes), strict=True):
        others = {size for size in sizes if size != 1}
        if len(others) > 1:
            raise WrongShape(f"batch axes of {what}", "that broadcast together", " and ".join(map(str, batch_shapes)))
        common.append(others.pop() if others else 1)
    return tuple(common)


def first_index(mask: NDArray[np.bool_]) -> tuple[int, ...]:
    """Where the first true entry of `mask` stands."""
    return tuple(int(i) for i in np.argwhere(mask)[0])


def _too_many_axes(count: int, tail: tuple[int, ...], what: str) -> WrongShape:
    shape = f"(..., {', '.join(map(str, tail))})" if tail else "(...)"
    return WrongShape(what, f"{shape} with at most {MOST_BATCH_AXES} batch axes", f"{count} of them")
