"""Compare functions of rigid motions with a Python loop over Pinocchio: the ratio of speeds, and the accuracy.

Each row is one function at one count of motions. Both get the same numbers and return arrays; they take turns, so that
a busy machine slows both, and the best turn is used. Accuracy is measured once for each function, on rotations near 0
(1e-12 … 1e-3), near π and on random ones, against power series in long double arithmetic.
"""

from __future__ import annotations

import argparse
import json
import platform
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from racing import race

from nao_kin import screws

Array = NDArray[Any]


@dataclass(frozen=True)
class Function:
    """One function in both libraries, with the required ratio of throughputs at 1e5 motions."""

    name: str
    source: str
    ours: Callable[[Array], Array]
    pinocchio: Callable[[Any], Any]
    at_many: float


FUNCTIONS = (
    Function("exp", "twist", screws.exp, lambda xi: pin.exp6(xi).homogeneous, 2.0),
    Function("log", "pose", screws.log, lambda M: pin.log6(M).vector, 2.0),
    Function("right_jacobian", "twist", screws.right_jacobian, lambda xi: pin.Jexp6(pin.Motion(xi)), 1.0),
    Function(
        "right_jacobian_inverse of log",
        "pose",
        lambda T: screws.right_jacobian_inverse(screws.log(T)),
        pin.Jlog6,
        1.0,
    ),
)


def main(arguments: list[str] | None = None) -> None:
    """Measure and print one JSON document."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counts", type=int, nargs="+", default=[1, 1_000, 100_000], help="motions per call")
    parser.add_argument("--repeats", type=int, default=5, help="turns of each library; the best one is used")
    options = parser.parse_args(arguments)
    rows = []
    errors = {function.name: _errors(function) for function in FUNCTIONS}
    for count in options.counts:
        twists = _random_twists(count)
        poses = screws.exp(twists)
        # Pinocchio's own objects are constructed in advance: only the functions are measured.
        inputs = {"twist": (twists, list(twists)), "pose": (poses, [pin.SE3(T) for T in poses])}
        for function in FUNCTIONS:
            ours, theirs = _race(function, *inputs[function.source], options.repeats)
            ratio = theirs / ours
            target = function.at_many if count == 100_000 else None
            rows.append(
                {
                    "function": function.name,
                    "count": count,
                    "nao_kin_ns": round(ours * 1e9 / count, 1),
                    "pinocchio_loop_ns": round(theirs * 1e9 / count, 1),
                    "throughput_ratio": round(ratio, 2),
                    "target_ratio": target,
                    "reached": None if target is None else ratio >= target,
                    **errors[function.name],
                }
            )
    about = {"python": platform.python_version(), "numpy": np.__version__, "pinocchio": pin.__version__}
    print(json.dumps({**about, "machine": platform.machine(), "rows": rows}, indent=2, ensure_ascii=False))


def _race(function: Function, ours: Array, theirs: list[Any], repeats: int) -> tuple[float, float]:
    """Return the seconds per call of each library for all motions, the best of its turns."""
    loops = max(1, 50 // len(theirs))
    single = ours[0] if len(theirs) == 1 else ours
    return race(
        lambda: function.ours(single),
        lambda: np.array([function.pinocchio(each) for each in theirs]),
        loops,
        repeats,
    )


def _random_twists(count: int, angles: Array | None = None) -> Array:
    rng = np.random.default_rng(0)
    v, e = rng.normal(size=(2, count, 3))
    turns = rng.uniform(0.0, 3.0, count) if angles is None else angles
    turned: Array = turns[:, None] * e / np.linalg.norm(e, axis=-1, keepdims=True)
    return np.concatenate([v, turned], axis=-1)


def _errors(function: Function) -> dict[str, float]:
    """Return the largest entry of the difference from the exact result, for each library."""
    small = 10.0 ** np.linspace(-12, -3, 181)
    rng = np.random.default_rng(1)
    # Slightly less than π, because at π the logarithm may also be that of the opposite rotation.
    twists = _random_twists(1362, np.concatenate([small, np.pi - small, rng.uniform(0.0, np.pi, 1000)]))
    hat, ad = _matrices(twists)
    T = _series(hat, 0).astype(np.float64)
    if function.source == "twist":
        exact = T if function.name == "exp" else _series(-ad, 1)
        theirs = [function.pinocchio(xi) for xi in twists]
        ours = function.ours(twists)
    else:
        exact = twists if function.name == "log" else _inverses(_series(-ad, 1))
        theirs = [function.pinocchio(pin.SE3(each)) for each in T]
        ours = function.ours(T)
    return {
        name: float(f"{float(np.abs(np.asarray(found) - exact).max()):.2g}")
        for name, found in (("nao_kin_error", ours), ("pinocchio_error", theirs))
    }


def _matrices(twists: Array) -> tuple[Array, Array]:
    """Return [ξ], 4 × 4, and the matrix of the bracket with ξ, 6 × 6, in long double."""
    v, omega = twists[:, :3].astype(np.longdouble), twists[:, 3:].astype(np.longdouble)

    def skew(w: Array) -> Array:
        # The columns of [w×] are w × eᵢ.
        return np.stack([np.cross(w, e) for e in np.eye(3)], axis=-1)

    hat = np.zeros((len(twists), 4, 4), np.longdouble)
    hat[:, :3, :3], hat[:, :3, 3] = skew(omega), v
    ad = np.zeros((len(twists), 6, 6), np.longdouble)
    ad[:, :3, :3] = ad[:, 3:, 3:] = skew(omega)
    ad[:, :3, 3:] = skew(v)
    return hat, ad


def _series(A: Array, shift: int) -> Array:
    """Return Σ Aⁿ/(n + shift)! of matrices; shift is 0 or 1."""
    term = np.broadcast_to(np.eye(A.shape[-1], dtype=A.dtype), A.shape)
    total: Array = term.copy()
    for n in range(1, 50):
        term = np.einsum("nij,njk->nik", term, A) / (n + shift)
        total += term
    return total


def _inverses(J: Array) -> Array:
    """Return inverses in long double: those of NumPy, improved by two Newton steps."""
    found: Array = np.linalg.inv(J.astype(np.float64)).astype(np.longdouble)
    for _ in range(2):
        found = 2 * found - np.einsum("nij,njk,nkl->nil", found, J, found)
    return found


if __name__ == "__main__":
    main()
