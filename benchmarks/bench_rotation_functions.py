"""Compare functions of rotations with scipy: the ratio of speeds, and the largest difference.

Powers, means, rotated vectors, interpolation, random rotations, fits to directions. Each row is one function at one
count of rotations; both libraries get the same arrays and take turns, and the best turn is used. Differences are
measured on random rotations, for which both libraries are accurate.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from racing import race
from scipy.spatial.transform import Rotation, RotationSpline, Slerp

from nao_kin import rotations

Array = NDArray[Any]


@dataclass(frozen=True)
class Inputs:
    """The same rotations as matrices and as quaternions, and vectors and times."""

    matrices: Array
    quaternions: Array
    vectors: Array
    times: Array


@dataclass(frozen=True)
class Function:
    """One function in both libraries, with results that can be compared."""

    name: str
    ours: Callable[[Inputs], Any]
    scipy: Callable[[Inputs], Any]
    most: int = 1_000_000


FUNCTIONS = (
    Function(
        "power",
        lambda i: rotations.power(i.matrices, 0.3),
        lambda i: (Rotation.from_matrix(i.matrices) ** 0.3).as_matrix(),
    ),
    Function(
        "angle between",
        lambda i: rotations.angle_between(i.matrices[..., ::-1, :, :], i.matrices),
        lambda i: (Rotation.from_matrix(i.matrices[::-1]).inv() * Rotation.from_matrix(i.matrices)).magnitude(),
    ),
    Function(
        "vectors rotated by quaternions",
        lambda i: rotations.quat_rotate(i.quaternions, i.vectors),
        lambda i: _rotations(i.quaternions).apply(i.vectors),
    ),
    Function(
        "chordal mean, with its spread here",
        lambda i: rotations.mean_rotation(i.matrices, method="chordal").rotation,
        lambda i: Rotation.from_matrix(i.matrices).mean().as_matrix(),
    ),
    Function(
        "modified Rodrigues parameters",
        lambda i: rotations.mrp_from_matrix(i.matrices),
        lambda i: Rotation.from_matrix(i.matrices).as_mrp(),
    ),
    Function(
        "and back",
        lambda i: rotations.matrix_from_mrp(0.5 * i.vectors),
        lambda i: Rotation.from_mrp(0.5 * i.vectors).as_matrix(),
    ),
    Function(
        "two moving axes → matrix",
        lambda i: rotations.matrix_from_euler(i.vectors[..., :2], "zy", axes="moving"),
        lambda i: Rotation.from_euler("ZY", i.vectors[..., :2]).as_matrix(),
    ),
    Function(
        "slerp between two",
        lambda i: rotations.slerp(i.quaternions[0], i.quaternions[1], i.times),
        lambda i: Slerp([0, 1], Rotation.from_quat(i.quaternions[:2], scalar_first=True))(i.times).as_quat(
            scalar_first=True
        ),
    ),
    Function(
        "spline through 10 keys",
        lambda i: rotations.RotationSpline(np.linspace(0, 1, 10), _keys())(i.times),
        lambda i: RotationSpline(np.linspace(0, 1, 10), Rotation.from_matrix(_keys()))(i.times).as_matrix(),
    ),
    Function(
        "spline through all",
        lambda i: rotations.RotationSpline(np.arange(len(i.matrices)), _near(i)).velocities,
        lambda i: RotationSpline(np.arange(len(i.matrices)), Rotation.from_matrix(_near(i)))(
            np.arange(len(i.matrices)), 1
        ),
        most=10_000,
    ),
    Function(
        "fit to directions",
        lambda i: rotations.rotation_from_directions(_directions(i), i.vectors).rotation,
        lambda i: Rotation.align_vectors(_units(i.vectors), _units(_directions(i)))[0].as_matrix(),
    ),
    Function(
        "random",
        lambda i: rotations.random_rotation(0, len(i.matrices)),
        lambda i: Rotation.random(len(i.matrices), random_state=np.random.default_rng(0)).as_matrix(),
    ),
)


def main(arguments: list[str] | None = None) -> None:
    """Measure and print one JSON document."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counts", type=int, nargs="+", default=[10, 1_000, 1_000_000], help="rotations per call")
    parser.add_argument("--repeats", type=int, default=5, help="turns of each library; the best one is used")
    options = parser.parse_args(arguments)
    rows = []
    for count in options.counts:
        inputs = _inputs(count)
        for function in FUNCTIONS:
            if count > function.most:
                continue
            calls = partial(function.ours, inputs), partial(function.scipy, inputs)
            ours, theirs = race(*calls, max(1, 200 // count), options.repeats)
            apart = np.abs(np.asarray(function.ours(inputs)) - np.asarray(function.scipy(inputs))).max()
            rows.append(
                {
                    "function": function.name,
                    "count": count,
                    "nao_kin_us": round(ours * 1e6, 1),
                    "scipy_us": round(theirs * 1e6, 1),
                    "throughput_ratio": round(theirs / ours, 2),
                    "difference": None if function.name == "random" else float(f"{apart:.2g}"),
                }
            )
    print(json.dumps({"rows": rows}, indent=2, ensure_ascii=False))


def _inputs(count: int) -> Inputs:
    rng = np.random.default_rng(0)
    theirs = Rotation.from_rotvec(rng.normal(scale=0.4, size=(count, 3)))
    vectors = rng.normal(size=(count, 3))
    quaternions = theirs.as_quat(canonical=True, scalar_first=True)
    return Inputs(theirs.as_matrix(), quaternions, vectors, np.sort(rng.random(count)))


def _rotations(quaternions: Array) -> Rotation:
    return Rotation.from_quat(quaternions, scalar_first=True)


def _keys() -> Array:
    return rotations.rot_z(np.linspace(0.0, 2.0, 10)) @ rotations.rot_x(np.sin(np.arange(10)))


def _near(inputs: Inputs) -> Array:
    """Return rotations about the same axes by 0.3 of the angles, which are near each other."""
    return rotations.power(inputs.matrices, 0.3)


def _directions(inputs: Inputs) -> Array:
    """Return the vectors before the rotation, with small errors."""
    turned: Array = inputs.vectors @ rotations.rot_x(0.5) + 0.01 * inputs.vectors[..., ::-1]
    return turned


def _units(vectors: Array) -> Array:
    directions: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return directions


if __name__ == "__main__":
    main()
