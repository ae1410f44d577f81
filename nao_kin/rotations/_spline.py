"""Smooth paths through key rotations."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, cross, dot, first_index
from nao_kin._core.kernels import evaluate, jacobian_derivatives
from nao_kin.errors import BadArgument, WrongShape, at_index
from nao_kin.rotations._checks import as_rotations
from nao_kin.rotations._exponential import exp, log, right_jacobian, right_jacobian_inverse
from nao_kin.rotations._three_angles import REQUIRED, Side, is_moving

# --- The angular velocities at the keys that make the acceleration continuous.

_MAX_STEPS = 60
# Relative length of a Newton step after which the next step changes nothing.
_SHORT_STEP = 1e-9


@np.errstate(over="ignore", invalid="ignore")  # where Newton's method diverges
def key_velocities(steps: Floats, arcs: Floats, first: Floats, last: Floats) -> Floats:
    """Angular velocities at the keys in the moving frame, shape (..., n, 3), from those of the first and last key.

    For step i with arc vᵢ, time hᵢ, right Jacobian J of vᵢ and velocity ωᵢ at key i, the acceleration is 6 vᵢ/hᵢ² − 4
    ωᵢ/hᵢ − 2 J⁻¹ωᵢ₊₁/hᵢ at the start and −6 vᵢ/hᵢ² + 2 J ωᵢ/hᵢ + 4 ωᵢ₊₁/hᵢ + a(vᵢ, J⁻¹ωᵢ₊₁) at the end, where the
    function a is quadratic in its second argument. Newton's method makes both equal at all inner keys.
    """
    means = arcs / steps[:, None]
    between = 0.5 * (means[..., :-1, :] + means[..., 1:, :])
    found = np.concatenate([first[..., None, :], between, last[..., None, :]], axis=-2)
    if len(steps) == 1 or not found.size:
        return found
    rates = 1.0 / steps[:, None, None]
    J, inverse = rates * right_jacobian(arcs), right_jacobian_inverse(arcs)
    A = rates * inverse
    before, after = slice(None, -1), slice(1, None)
    lower, upper = 2.0 * J[..., before, :, :], 2.0 * A[..., after, :, :]
    straight = 4.0 * (rates[before] + rates[after]) * np.eye(3)
    pull = 6.0 * (means[..., before, :] / steps[before, None] + means[..., after, :] / steps[after, None])
    scale = np.abs(means).max(axis=(-2, -1), keepdims=True) + np.abs(found).max(axis=(-2, -1), keepdims=True)
    for _ in range(_MAX_STEPS):
        inner = found[..., 1:-1, :]
        arriving = _times(inverse[..., before, :, :], inner)
        jump = (
            _times(lower, found[..., :-2, :])
            + _times(straight, inner)
            + _times(upper, found[..., 2:, :])
            + turning_acceleration(arcs[..., before, :], arriving)
            - pull
        )
        bent = _turning_derivative(arcs[..., before, :], arriving) @ inverse[..., before, :, :]
        change = _solved(lower, straight + bent, upper, jump[..., None])[..., 0]
        found[..., 1:-1, :] -= change
        if (np.abs(change) <= _SHORT_STEP * scale).all():
            return found
        if not np.isfinite(change).all():
            break
    raise BadArgument("no smooth path through the keys was found: some are too far apart in too little time")


def turning_acceleration(v: Floats, rate: Floats) -> Floats:
    """J̇_r v̇, quadratic in v̇: the angular acceleration in the moving frame is J_r(v) v̈ + J̇_r v̇.

    J_r(v) = 1 − b [v×] + c [v×]² with b = (1 − cos φ)/φ², c = (φ − sin φ)/φ³, and so
    J̇_r v̇ = −ḃ v × v̇ + ċ v × (v × v̇) + c v̇ × (v × v̇).
    """
    # ḃ and ċ are db and dc times v·v̇.
    _, c, db, dc = evaluate(jacobian_derivatives, [dot(v, v)[..., None]], (), (), (), ())
    normal = cross(v, rate)
    along = dot(v, rate)
    bend = (dc * along)[..., None] * v + c[..., None] * rate
    return np.asarray(cross(bend, normal) - (db * along)[..., None] * normal)


def _turning_derivative(v: Floats, rate: Floats) -> Floats:
    """The derivative of `turning_acceleration` by the rate, shape (..., 3, 3); exact, since that is quadratic."""
    v, rate = v[..., None, :], rate[..., None, :]
    basis = np.eye(3)
    changes = turning_acceleration(v, rate + basis) - turning_acceleration(v, rate) - turning_acceleration(v, basis)
    return np.asarray(np.swapaxes(changes, -1, -2))


def _solved(lower: Floats, middle: Floats, upper: Floats, right: Floats) -> Floats:
    """Solve lowerₖ xₖ₋₁ + middleₖ xₖ + upperₖ xₖ₊₁ = rightₖ, blocks of shape (..., n, 3, 3), by cyclic reduction.

    Expressing every other unknown by its neighbours leaves a system of the same kind and half the size.
    """
    n = middle.shape[-3]
    if n == 1:
        return np.asarray(np.linalg.solve(middle, right))
    lower, upper = (np.broadcast_to(side, middle.shape) for side in (lower, upper))
    odd, even = slice(1, None, 2), slice(0, None, 2)
    known = np.concatenate([lower[..., odd, :, :], upper[..., odd, :, :], right[..., odd, :, :]], axis=-1)
    by = np.linalg.solve(middle[..., odd, :, :], known)
    # The last unknown has no right neighbour.
    none = np.zeros((*by.shape[:-3], 1, 3, 7))
    left_of = np.concatenate([none, by], axis=-3)[..., : (n + 1) // 2, :, :]
    right_of = np.concatenate([by, none], axis=-3)[..., : (n + 1) // 2, :, :]
    before, after = lower[..., even, :, :], upper[..., even, :, :]
    x = _solved(
        -before @ left_of[..., :3],
        middle[..., even, :, :] - before @ left_of[..., 3:6] - after @ right_of[..., :3],
        -after @ right_of[..., 3:6],
        right[..., even, :, :] - before @ left_of[..., 6:] - after @ right_of[..., 6:],
    )
    found = np.empty((*x.shape[:-3], n, 3, 1))
    found[..., even, :, :] = x
    following = np.concatenate([x, np.zeros((*x.shape[:-3], 1, 3, 1))], axis=-3)[..., 1 : n // 2 + 1, :, :]
    found[..., odd, :, :] = by[..., 6:] - by[..., :3] @ x[..., : n // 2, :, :] - by[..., 3:6] @ following
    return found


# --- Smooth paths through key rotations.

Places = NDArray[np.intp]


class RotationSpline:
    """A path through key rotations at given times, with continuous angular velocity and acceleration.

    Between two keys R(t) = Rᵢ exp(v(t)), with v a cubic from 0 to log(RᵢᵀRᵢ₊₁). This is the shorter arc, so keys should
    be less than half a turn apart (at exactly half a turn `log` selects the direction). The angular velocities at the
    inner keys make the acceleration continuous; about one axis the path is the cubic spline of the angle. Batches of
    paths share their times.

    Attributes:
        times: the times of the keys, shape (n,) [s].
        keys: rotations at these times, shape (..., n, 3, 3).
        velocities: angular velocities at these times in the moving frame, shape (..., n, 3) [rad/s].

    Source: Kang and Park, Cubic spline algorithms for orientation interpolation, Int. J. Numerical Methods in
    Engineering 46, 1999.

    Examples:
        >>> keys = nk.rotations.rot_z([0.0, 0.5, 0.2])
        >>> path = nk.rotations.RotationSpline([0.0, 1.0, 3.0], keys, start=[0, 0, 0], end=[0, 0, 0])
        >>> path.angular_velocity([0.0, 0.5], expressed_in="fixed").round(4).tolist()
        [[0.0, 0.0, 0.0], [0.0, 0.0, 0.6438]]
    """

    def __init__(
        self, times: ArrayLike, keys: ArrayLike, *, start: ArrayLike | None = None, end: ArrayLike | None = None
    ) -> None:
        """Make a path through `keys` at `times`.

        Args:
            times: increasing, shape (n,), n ≥ 2 [s].
            keys: rotation matrices, shape (..., n, 3, 3).
            start: angular velocity at the first key in its moving frame, shape (..., 3) [rad/s]; by default the mean
                velocity up to the second key. Zeros start at rest.
            end: the same at the last key.

        Raises:
            BadArgument: keys so far apart in so little time that no smooth path was found.
        """
        self.times = np.array(as_floats(times, (), "times"))
        if self.times.ndim != 1 or len(self.times) < 2:
            raise BadArgument(f"times must be at least two in a row, got shape {self.times.shape}")
        steps = np.diff(self.times)
        if not (steps > 0.0).all():
            index = first_index(np.asarray(~(steps > 0.0)))[0]
            raise BadArgument(
                f"times must increase, got {self.times[index]:g} and then {self.times[index + 1]:g} at {index + 1}"
            )
        self.keys = as_rotations(keys)
        if self.keys.ndim < 3 or self.keys.shape[-3] != len(self.times):
            raise WrongShape("keys", f"(..., {len(self.times)}, 3, 3), one for each time", self.keys.shape)
        arcs = log(np.swapaxes(self.keys[..., :-1, :, :], -1, -2) @ self.keys[..., 1:, :, :])
        means = arcs / steps[:, None]
        ends = [
            _end(value, mean, f"angular velocity at the {what}")
            for value, mean, what in ((start, means[..., 0, :], "start"), (end, means[..., -1, :], "end"))
        ]
        self.velocities = key_velocities(steps, arcs, *ends)
        # v(u) = u (linear + u (square + u cube)), with u the time since the key.
        first, last = self.velocities[..., :-1, :], right_jacobian_inverse(arcs) @ self.velocities[..., 1:, :, None]
        self._square = (3.0 * means - 2.0 * first - last[..., 0]) / steps[:, None]
        self._cube = (first + last[..., 0] - 2.0 * means) / np.square(steps)[:, None]
        for array in (self.times, self.keys, self.velocities):
            array.flags.writeable = False

    def __call__(self, t: ArrayLike) -> Floats:
        """Return the rotations at times t.

        Args:
            t: from the first key's time to the last one's, any shape [s].

        Returns:
            Rotation matrices, shape `(..., *t.shape, 3, 3)`, with the batch axes of the paths first.
        """
        place, v, _, _ = self._at(t)
        return np.asarray(self.keys[..., place, :, :] @ exp(v))

    def angular_velocity(self, t: ArrayLike, *, expressed_in: Side = REQUIRED) -> Floats:
        """Return the angular velocities at times t.

        Args:
            t: from the first key's time to the last one's, any shape [s].
            expressed_in: "fixed" or "moving", the frame of the angular velocity; required.

        Returns:
            Vectors, shape `(..., *t.shape, 3)` [rad/s].
        """
        place, v, rate, _ = self._at(t)
        return self._expressed(_times(right_jacobian(v), rate), place, v, expressed_in)

    def angular_acceleration(self, t: ArrayLike, *, expressed_in: Side = REQUIRED) -> Floats:
        """Return the angular accelerations at times t, the derivatives of the velocities.

        Args:
            t: from the first key's time to the last one's, any shape [s].
            expressed_in: "fixed" or "moving", the frame of the angular acceleration; required.

        Returns:
            Vectors, shape `(..., *t.shape, 3)` [rad/s²].
        """
        place, v, rate, second = self._at(t)
        moving = _times(right_jacobian(v), second) + turning_acceleration(v, rate)
        return self._expressed(moving, place, v, expressed_in)

    def _expressed(self, moving: Floats, place: Places, v: Floats, expressed_in: Side) -> Floats:
        if is_moving(expressed_in):
            return moving
        return _times(self.keys[..., place, :, :], _times(exp(v), moving))

    def _at(self, t: ArrayLike) -> tuple[Places, Floats, Floats, Floats]:
        """The index of the key before each time, and v and its first two derivatives at that time."""
        instants = as_floats(t, (), "t")
        outside = (instants < self.times[0]) | (instants > self.times[-1])
        if outside.any():
            index = first_index(np.asarray(outside))
            raise BadArgument(
                f"t must be from {self.times[0]:g} to {self.times[-1]:g}, got {instants[index]:g}{at_index(index)}"
            )
        # The last key belongs to the last segment.
        place = np.searchsorted(self.times[1:-1], instants, side="right")
        u = (instants - self.times[place])[..., None]
        linear, square, cube = (c[..., place, :] for c in (self.velocities, self._square, self._cube))
        v = u * (linear + u * (square + u * cube))
        return place, v, linear + u * (2.0 * square + 3.0 * u * cube), 2.0 * square + 6.0 * u * cube


def _end(value: ArrayLike | None, mean: Floats, what: str) -> Floats:
    if value is None:
        return mean
    return np.broadcast_to(as_floats(value, (3,), what), mean.shape)


def _times(M: Floats, v: Floats) -> Floats:
    return np.asarray(np.einsum("...ij,...j->...i", M, v))
