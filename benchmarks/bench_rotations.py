"""Compare conversions of rotations with scipy.spatial.transform.Rotation: the ratio of speeds, and the accuracy.

Each row is one conversion at one count of rotations. Both libraries get the same arrays and check them as they do by
default; they take turns, so that a busy machine slows both, and the best turn is used. Accuracy is measured once for
each conversion, on rotations near 0, near π and near gimbal lock (1e-12 … 1e-3) and on random ones, against long double
arithmetic.
"""

from __future__ import annotations

import argparse
import json
import platform
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray
from racing import race
from scipy.spatial.transform import Rotation

from nao_kin import rotations

Array = NDArray[Any]

MOVING = "zyx"


@dataclass(frozen=True)
class Conversion:
    """One conversion in both libraries, with the required ratio of throughputs at N = 1 and at N = 1e6."""

    name: str
    source: str
    ours: Callable[[Array], Any]
    scipy: Callable[[Array], Any]
    error: str
    at_one: float | None = None
    at_million: float | None = None


CONVERSIONS = (
    Conversion(
        "matrix → euler",
        "matrix",
        lambda R: rotations.euler_from_matrix(R, MOVING, axes="moving").angles,
        lambda R: Rotation.from_matrix(R).as_euler(MOVING.upper()),
        "largest entry of R(angles) − R, near lock",
        1.0,
        2.0,
    ),
    Conversion(
        "euler → matrix",
        "euler",
        lambda a: rotations.matrix_from_euler(a, MOVING, axes="moving"),
        lambda a: Rotation.from_euler(MOVING.upper(), a).as_matrix(),
        "largest entry of R − R(angles)",
        0.5,
        2.0,
    ),
    Conversion(
        "matrix → quaternion",
        "matrix",
        rotations.quat_from_matrix,
        lambda R: Rotation.from_matrix(R).as_quat(canonical=True, scalar_first=True),
        "largest component of q − q(R), up to sign",
        0.5,
        2.0,
    ),
    Conversion(
        "quaternion → matrix",
        "quaternion",
        rotations.matrix_from_quat,
        lambda q: Rotation.from_quat(q, scalar_first=True).as_matrix(),
        "largest entry of R − R(q)",
        0.5,
    ),
    Conversion(
        "log",
        "matrix",
        rotations.log,
        lambda R: Rotation.from_matrix(R).as_rotvec(),
        "largest component of v − v(R), relative to ‖v‖ below 1 rad",
        0.5,
        2.0,
    ),
    Conversion(
        "exp",
        "vector",
        rotations.exp,
        lambda v: Rotation.from_rotvec(v).as_matrix(),
        "largest entry of R − R(v)",
        0.5,
        0.8,
    ),
)


def main(arguments: list[str] | None = None) -> None:
    """Measure and print one JSON document."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counts", type=int, nargs="+", default=[1, 1_000, 1_000_000], help="rotations per call")
    parser.add_argument("--repeats", type=int, default=7, help="turns of each library; the best one is used")
    options = parser.parse_args(arguments)
    errors = {conversion.name: _errors(conversion) for conversion in CONVERSIONS}
    rows = []
    for count in options.counts:
        inputs = _inputs(count)
        for conversion in CONVERSIONS:
            values = inputs[conversion.source]
            loops = max(1, 2_000 // max(1, values.size // 9))
            calls = partial(conversion.ours, values), partial(conversion.scipy, values)
            ours, theirs = race(*calls, loops, options.repeats)
            target = {1: conversion.at_one, 1_000_000: conversion.at_million}.get(count)
            ratio = theirs / ours
            rows.append(
                {
                    "conversion": conversion.name,
                    "count": count,
                    "nao_kin_ns": round(ours * 1e9 / count, 1),
                    "scipy_ns": round(theirs * 1e9 / count, 1),
                    "throughput_ratio": round(ratio, 2),
                    "target_ratio": target,
                    "reached": None if target is None else ratio >= target,
                    "nao_kin_error": errors[conversion.name][0],
                    "scipy_error": errors[conversion.name][1],
                    "error_is": conversion.error,
                }
            )
    about = {"python": platform.python_version(), "numpy": np.__version__, "scipy": scipy.__version__}
    print(json.dumps({**about, "machine": platform.machine(), "rows": rows}, indent=2, ensure_ascii=False))


def _inputs(count: int) -> dict[str, Array]:
    """Return random rotations in each representation; a single one has no batch axis."""
    random = Rotation.random(count, random_state=np.random.default_rng(0))
    forms = {
        "matrix": random.as_matrix(),
        "euler": random.as_euler(MOVING.upper()),
        "quaternion": random.as_quat(scalar_first=True),
        "vector": random.as_rotvec(),
    }
    return {name: values[0] if count == 1 else values for name, values in forms.items()}


def _errors(conversion: Conversion) -> tuple[float, float]:
    """Return the largest error of each library over difficult samples."""
    with warnings.catch_warnings():
        # scipy warns at gimbal lock.
        warnings.simplefilter("ignore", UserWarning)
        return _worst(conversion.name, conversion.ours), _worst(conversion.name, conversion.scipy)


def _worst(name: str, convert: Callable[[Array], Any]) -> float:
    angles, vectors = _angles_beside_lock(), _vectors_near_zero_and_pi()
    if name == "matrix → euler":
        R = _from_angles(angles).astype(np.float64)
        return _largest(_from_angles(convert(R)) - R)
    if name == "euler → matrix":
        return _largest(convert(angles) - _from_angles(angles))
    half = np.linalg.norm(vectors, axis=-1, keepdims=True).astype(np.longdouble) / 2
    exact = np.concatenate([np.cos(half), np.sin(half) * (vectors / (2 * half))], axis=-1)
    R = _from_quaternions(exact)
    if name == "exp":
        return _largest(convert(vectors) - R)
    if name == "quaternion → matrix":
        q = exact.astype(np.float64)
        return _largest(convert(q) - _from_quaternions(q.astype(np.longdouble)))
    found = convert(R.astype(np.float64))
    expected, scale = (exact, 1.0) if name == "matrix → quaternion" else (vectors, np.minimum(2 * half, 1.0))
    same, opposite = (np.abs(found - sign * expected) / scale for sign in (1, -1))
    # Within rounding of half a turn, v and −v are the same rotation.
    either = np.pi - 2 * half < 1e-15 if name == "log" else np.ones_like(half, dtype=bool)
    return _largest(np.where(either, np.minimum(same.max(-1), opposite.max(-1))[:, None], same))


def _angles_beside_lock() -> Array:
    rng = np.random.default_rng(1)
    distances = np.concatenate([[0.0], 10.0 ** np.linspace(-12, -3, 181)])
    angles = rng.uniform(-np.pi, np.pi, (4, len(distances), 2, 3))
    angles[..., 1] = rng.choice([-1.0, 1.0], angles.shape[:-1]) * np.pi / 2 + distances[:, None] * np.array([-1, 1])
    everywhere = rng.uniform(-np.pi, np.pi, (2000, 3))
    return np.concatenate([angles.reshape(-1, 3), everywhere])


def _vectors_near_zero_and_pi() -> Array:
    rng = np.random.default_rng(2)
    small = 10.0 ** np.linspace(-12, -3, 181)
    angles = np.concatenate([small, np.pi - small, [np.pi], rng.uniform(0.0, np.pi, 2000)])
    axes = rng.normal(size=(len(angles), 3))
    vectors: Array = angles[:, None] * axes / np.linalg.norm(axes, axis=-1, keepdims=True)
    return vectors


def _from_angles(angles: Array) -> Array:
    """Rz(α) Ry(β) Rx(γ) in long double."""
    (ca, cb, cc), (sa, sb, sc) = (f(angles.astype(np.longdouble)).T for f in (np.cos, np.sin))
    rows: list[list[Array]] = [
        [ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc],
        [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc],
        [-sb, cb * sc, cb * cc],
    ]
    matrices: Array = np.array(rows).transpose(2, 0, 1)
    return matrices


def _from_quaternions(q: Array) -> Array:
    """Rotation matrices of quaternions of any length, in long double."""
    unit: Array = q / np.sqrt((q * q).sum(axis=-1, keepdims=True))
    w, x, y, z = unit.T
    rows: list[list[Array]] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    matrices: Array = np.array(rows).transpose(2, 0, 1)
    return matrices


def _largest(values: Array) -> float:
    return float(f"{float(np.abs(values).max()):.2g}")


if __name__ == "__main__":
    main()
