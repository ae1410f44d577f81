"""Rates of three angles and the angular velocity: the Jacobians of the 24 conventions, and their inverses."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_batch, choice, first_index
from nao_kin._core.kernels import Functions, Kernel, Number, evaluate
from nao_kin.errors import BadArgument, SingularMatrix
from nao_kin.rotations._three_angles import LOCK, REQUIRED, Axes, Convention, find_convention

Side = Literal["fixed", "moving"]


def euler_rate_jacobian(
    angles: ArrayLike, sequence: str, *, axes: Axes = REQUIRED, expressed_in: Side = REQUIRED
) -> Floats:
    """The matrix J from the rates of three angles to the angular velocity, ω = J (α̇, β̇, γ̇).

    Its columns are the current axes of the three rotations: for moving axes "ijk", in the fixed frame, eᵢ, Ri(α) eⱼ and
    Ri(α) Rj(β) eₖ; in the moving frame J is multiplied by Rᵀ. With R = `matrix_from_euler(angles, ...)`, ω in the fixed
    frame is the vector of Ṙ Rᵀ, in the moving frame that of Rᵀ Ṙ. det J is ± cos β, or ± sin β if the first and third
    axes are the same: at lock these axes coincide, and J has rank two.

    Args:
        angles: shape (..., 3) [rad], in the order of the sequence.
        sequence: three of "x", "y", "z", neighbours different, lower case.
        axes: "moving" or "fixed", the axes of the rotations; required.
        expressed_in: "fixed" or "moving", the frame of the angular velocity; required.

    Returns:
        Matrices, shape (..., 3, 3); columns in the order of the sequence.

    Source: Diebel, Representing attitude, Stanford University, 2006.

    Examples:
        >>> J = nk.rotations.euler_rate_jacobian([0.1, 0.2, 0.3], "xyz", axes="fixed", expressed_in="fixed")
        >>> J @ [0.0, 0.0, 2.0]  # the last of three fixed axes does not move
        array([0., 0., 2.])
    """
    convention, body = find_convention(sequence, axes), is_moving(expressed_in)
    values = as_batch(angles, (3,), "angles")
    return evaluate(_jacobian(convention, body), [values], (3, 3))[0]


def euler_rate_jacobian_inverse(
    angles: ArrayLike, sequence: str, *, axes: Axes = REQUIRED, expressed_in: Side = REQUIRED
) -> Floats:
    """The matrix J⁻¹ from the angular velocity to the rates of three angles, (α̇, β̇, γ̇) = J⁻¹ ω.

    The inverse of `euler_rate_jacobian`, in closed form. Near lock it grows as 1/cos β, or 1/sin β if the first and
    third axes are the same.

    Args:
        angles: shape (..., 3) [rad], in the order of the sequence.
        sequence: three of "x", "y", "z", neighbours different, lower case.
        axes: "moving" or "fixed", the axes of the rotations; required.
        expressed_in: "fixed" or "moving", the frame of the angular velocity; required.

    Returns:
        Matrices, shape (..., 3, 3); rows in the order of the sequence.

    Raises:
        SingularMatrix: at lock, |cos β| (|sin β| for equal outer axes) up to 4 × 2⁻⁵²; carries the index.

    Source: Diebel, Representing attitude, Stanford University, 2006.

    Examples:
        >>> convention = {"sequence": "zyx", "axes": "moving", "expressed_in": "moving"}
        >>> J = nk.rotations.euler_rate_jacobian([0.1, 0.2, 0.3], **convention)
        >>> np.allclose(nk.rotations.euler_rate_jacobian_inverse([0.1, 0.2, 0.3], **convention) @ J, np.eye(3))
        True
    """
    convention, body = find_convention(sequence, axes), is_moving(expressed_in)
    values = as_batch(angles, (3,), "angles")
    found, determinant = evaluate(_inverse(convention, body), [values], (3, 3), ())
    locked = np.asarray(np.abs(determinant) <= LOCK)
    if locked.any():
        outer = "sin β = 0" if convention.symmetric else "cos β = 0"
        raise SingularMatrix("Jacobian of the angles' rates", f"the angles are at lock, {outer}", first_index(locked))
    return found


def is_moving(expressed_in: Side) -> bool:
    if expressed_in is None:
        raise BadArgument("expressed_in= must be given: 'fixed' or 'moving', the frame of the vector's components")
    return choice(expressed_in, ("fixed", "moving"), "expressed_in") == "moving"


def _sines(f: Functions, convention: Convention, body: bool, angles: tuple[Number, ...]) -> tuple[Number, ...]:
    """Cosines and sines of the two angles that J depends on, for moving axes in the fixed frame.

    In the moving frame, Rᵀ consists of rotations by the negative angles in the opposite order.
    """
    first, middle, third = angles[::-1] if convention.reversed else angles
    if body:
        first, middle = 0.0 - third, 0.0 - middle
    return f.cos(first), f.sin(first), f.cos(middle), f.sin(middle)


def _order(convention: Convention, body: bool) -> tuple[int, int, int, float, bool]:
    """The axes i, j, k and their sign, as for J in the fixed frame, and whether the angles are in the same order."""
    i, k, sign = convention.i, convention.k, convention.sign
    if body and not convention.symmetric:
        i, k, sign = k, i, -sign
    return i, convention.j, k, sign, convention.reversed == body


def _jacobian(convention: Convention, body: bool) -> Kernel:
    i, j, k, s, in_order = _order(convention, body)

    def kernel(f: Functions, *angles: Number) -> tuple[Number, ...]:
        ca, sa, cb, sb = _sines(f, convention, body, angles)
        m: list[Number] = [0.0] * 9
        first, last = (0, 2) if in_order else (2, 0)
        m[3 * i + first] = 1.0
        m[3 * j + 1], m[3 * k + 1] = ca, s * sa
        if convention.symmetric:
            m[3 * i + last], m[3 * j + last], m[3 * k + last] = cb, sa * sb, 0.0 - s * ca * sb
        else:
            m[3 * i + last], m[3 * j + last], m[3 * k + last] = s * sb, 0.0 - s * sa * cb, ca * cb
        return tuple(m)

    return kernel


def _inverse(convention: Convention, body: bool) -> Kernel:
    i, j, k, s, in_order = _order(convention, body)

    def kernel(f: Functions, *angles: Number) -> tuple[Number, ...]:
        ca, sa, cb, sb = _sines(f, convention, body, angles)
        # The component of the last axis along the first, and the one across it.
        along, across = (cb, 0.0 - s * sb) if convention.symmetric else (s * sb, cb)
        divisor = f.where(across == 0.0, 1.0, across)
        gj, gk = 0.0 - s * sa / divisor, ca / divisor
        m: list[Number] = [0.0] * 9
        first, last = (0, 6) if in_order else (6, 0)
        m[first + i], m[first + j], m[first + k] = 1.0, 0.0 - along * gj, 0.0 - along * gk
        m[3 + j], m[3 + k] = ca, s * sa
        m[last + j], m[last + k] = gj, gk
        return *m, across

    return kernel
