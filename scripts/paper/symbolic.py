"""Symbolic proofs for all values; they need sympy, and a note says so if it is missing."""

from __future__ import annotations

import importlib
from typing import Any

from paper.rows import Row

_ABSENT = "sympy is not installed: the symbolic proofs are left out (pip install sympy)"
Proofs = tuple[tuple[Row, ...], tuple[str, ...]]


def rank_one() -> Proofs:
    """Prove det T = 1 + u·v and T u = (1 + u·v) u for all u and v."""
    sp = _sympy()
    if sp is None:
        return (), (_ABSENT,)
    u, v = (sp.Matrix(sp.symbols(f"{name}1:4", real=True)) for name in "uv")
    T = sp.eye(3) + u * v.T
    return (
        Row("det T − 1 − u·v = 0 for all u, v", "sympy", _is_zero(sp, sp.Matrix([T.det() - 1 - u.dot(v)])), True),
        Row("T u = (1 + u·v) u for all u, v", "sympy", _is_zero(sp, T * u - (1 + u.dot(v)) * u), True),
    ), ()


def turn_about_the_diagonal() -> Proofs:
    """Prove that R(t) of problem 8 is the rotation by αt about (1, 1, 1)/√3 for all t."""
    sp = _sympy()
    if sp is None:
        return (), (_ABSENT,)
    angle = sp.symbols("theta", real=True)
    c, s = sp.cos(angle / 2), sp.sin(angle / 2)
    rho = 2 * sp.sqrt(3) / 3 * s * c
    diagonal, minus, plus = c**2 - s**2 / 3, 2 * s**2 / 3 - rho, 2 * s**2 / 3 + rho
    R = sp.Matrix([[diagonal, minus, plus], [plus, diagonal, minus], [minus, plus, diagonal]])
    e = sp.ones(3, 1) / sp.sqrt(3)
    E = sp.Matrix([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
    r, r0 = s * e, c
    natural = sp.eye(3) + sp.sin(angle) * E + (1 - sp.cos(angle)) * E**2
    quadratic = (r0**2 - r.dot(r)) * sp.eye(3) + 2 * r * r.T + 2 * r0 * s * E
    return (
        Row("R(t) − rotation by αt about (1, 1, 1)/√3 = 0 for all t", "sympy", _is_zero(sp, R - natural), True),
        Row(
            "r = sin(αt/2) (1, 1, 1)/√3, r0 = cos(αt/2) give R(t) for all t", "sympy", _is_zero(sp, R - quadratic), True
        ),
    ), ()


def _sympy() -> Any:
    try:
        return importlib.import_module("sympy")
    except ImportError:
        return None


def _is_zero(sp: Any, matrix: Any) -> bool:
    return bool(matrix.applyfunc(lambda entry: sp.simplify(sp.expand(entry))).is_zero_matrix)
