"""The angular velocities at the keys of a spline with which its acceleration is continuous."""

from __future__ import annotations

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.kernels import evaluate
from nao_kin._common.turn_coefficients import jacobian_derivatives
from nao_kin._common.vectors import cross, dot
from nao_kin.errors import BadArgument
from nao_kin.rotations._jacobians import right_jacobian, right_jacobian_inverse

_MOST_STEPS = 60
# Relative length of a step after which Newton's next one changes nothing.
_SHORT_STEP = 1e-9


def key_velocities(steps: Floats, arcs: Floats, first: Floats, last: Floats) -> Floats:
    """Angular velocities at the keys in the moving frame, shape (..., n, 3).

    With vᵢ the arc and hᵢ the time from key i to the next, ωᵢ the velocity at key i, and the cubic v of each stretch:
    the acceleration at its start is 6 vᵢ/hᵢ² − 4 ωᵢ/hᵢ − 2 J⁻¹ωᵢ₊₁/hᵢ, and at its end −6 vᵢ/hᵢ² + 2 J ωᵢ/hᵢ +
    4 ωᵢ₊₁/hᵢ + a(vᵢ, J⁻¹ωᵢ₊₁), with J the right Jacobian of vᵢ and a quadratic in its second argument. Newton's method
    makes them equal at all inner keys.

    Args:
        steps: hᵢ, shape (n − 1,).
        arcs: vᵢ, shape (..., n − 1, 3).
        first: the velocity at the first key, shape (..., 3).
        last: the velocity at the last key, shape (..., 3).
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
    for _ in range(_MOST_STEPS):
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
    raise BadArgument("no smooth path through the keys was found: some are too far apart in too little time")


def turning_acceleration(v: Floats, rate: Floats) -> Floats:
    """What J_r changes: the angular acceleration in the moving frame is J_r(v) v̈ plus this, quadratic in v̇.

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
    """The derivative of `turning_acceleration` by the rate, exact because it is quadratic, shape (..., 3, 3)."""
    v, rate = v[..., None, :], rate[..., None, :]
    basis = np.eye(3)
    changes = turning_acceleration(v, rate + basis) - turning_acceleration(v, rate) - turning_acceleration(v, basis)
    return np.asarray(np.swapaxes(changes, -1, -2))


def _solved(lower: Floats, middle: Floats, upper: Floats, right: Floats) -> Floats:
    """X of lowerₖ xₖ₋₁ + middleₖ xₖ + upperₖ xₖ₊₁ = rightₖ, blocks of shape (..., n, 3, 3), by cyclic reduction.

    Every other unknown is expressed by its neighbours, which leaves a system of the same kind of half the size.
    """
    n = middle.shape[-3]
    if n == 1:
        return np.asarray(np.linalg.solve(middle, right))
    lower, upper = (np.broadcast_to(side, middle.shape) for side in (lower, upper))
    odd, even = slice(1, None, 2), slice(0, None, 2)
    known = np.concatenate([lower[..., odd, :, :], upper[..., odd, :, :], right[..., odd, :, :]], axis=-1)
    by = np.linalg.solve(middle[..., odd, :, :], known)
    # Beyond the last one there is none.
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


def _times(M: Floats, v: Floats) -> Floats:
    return np.asarray(np.einsum("...ij,...j->...i", M, v))
