"""Samples of angles, axes and matrices at which rotations go wrong and which uniform sampling never meets."""

from __future__ import annotations

import itertools
import math

import numpy as np
from hypothesis import settings, strategies as st
from scipy.spatial.transform import Rotation

PROPERTY = settings(derandomize=True, max_examples=60, deadline=None)

CONVENTIONS = [
    (a + b + c, axes) for a in "xyz" for b in "xyz" for c in "xyz" if a != b != c for axes in ("moving", "fixed")
]

# Distances from a special angle: zero, the smallest beside π, and up to where nothing is special.
DISTANCES = [0.0, 1e-17, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4]
DISTANCES += [1e-3, 1e-2, 0.1]


def beside(*places: float) -> st.SearchStrategy[float]:
    distance = st.one_of(st.just(0.0), st.floats(-18.0, -3.0).map(lambda e: 10.0**e))
    return st.builds(lambda p, d, s: p + s * d, st.sampled_from(places), distance, st.sampled_from([-1.0, 1.0]))


angles = st.one_of(
    st.floats(-math.pi, math.pi),
    beside(0.0, math.pi, -math.pi),
    beside(math.pi / 2, -math.pi / 2),
    st.integers(-2, 2).map(lambda k: k * math.pi / 2),
)
turns = st.one_of(st.floats(0.0, math.pi), beside(0.0).map(abs), beside(math.pi).map(lambda a: min(a, math.pi)))


def _normalised(v: tuple[float, ...]) -> np.ndarray:
    array = np.array(v)
    return array / np.linalg.norm(array)


components = st.one_of(st.floats(-1.0, 1.0), beside(0.0), st.sampled_from([-1.0, 0.0, 1.0]))
axes = st.tuples(components, components, components).filter(lambda v: np.linalg.norm(v) > 0.1).map(_normalised)
rotation_vectors = st.builds(lambda e, a: e * a, axes, turns)


def scipy_matrix(vector: np.ndarray) -> np.ndarray:
    return Rotation.from_rotvec(vector).as_matrix()


matrices = rotation_vectors.map(scipy_matrix)
quaternions = st.builds(lambda e, a: np.array([math.cos(a / 2), *(e * math.sin(a / 2))]), axes, angles)


def many_axes(count: int, seed: int = 0) -> np.ndarray:
    """Return unit vectors, shape (count, 3): half uniform, the others along, in or near the coordinate planes."""
    rng = np.random.default_rng(seed)
    v = rng.normal(size=(count, 3))
    eighth = count // 8
    v[:eighth] = np.eye(3)[rng.integers(0, 3, eighth)] * rng.choice([-1.0, 1.0], (eighth, 1))
    v[eighth : 2 * eighth, rng.integers(0, 3)] = 0.0
    v[2 * eighth : 3 * eighth] *= 10.0 ** rng.uniform(-18.0, 0.0, (eighth, 3))
    v[3 * eighth : 4 * eighth] = rng.choice([-1.0, 1.0], (eighth, 3))
    rng.shuffle(v)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def many_angles(shape: tuple[int, ...], seed: int = 0) -> np.ndarray:
    """Return angles near [−π, π]: a third uniform, a third right angles, a third at every distance from these."""
    rng = np.random.default_rng(seed)
    right = rng.integers(-2, 3, shape) * (math.pi / 2)
    distance = rng.choice(DISTANCES, shape) * rng.choice([-1.0, 1.0], shape)
    return np.choose(rng.integers(0, 3, shape), [rng.uniform(-math.pi, math.pi, shape), right, right + distance])


def many_rotation_vectors(count: int, seed: int = 0) -> np.ndarray:
    """Rotation vectors, shape (count, 3), up to half a turn long."""
    return many_axes(count, seed) * np.minimum(np.abs(many_angles((count, 1), seed + 1)), math.pi)


def many_rotations(count: int, seed: int = 0) -> np.ndarray:
    return scipy_matrix(many_rotation_vectors(count, seed))


def many_quaternions(count: int, seed: int = 0) -> np.ndarray:
    """Unit quaternions of either sign, shape (count, 4)."""
    half = 0.5 * many_angles((count, 1), seed + 1)
    return np.concatenate([np.cos(half), np.sin(half) * many_axes(count, seed)], axis=-1)


def integer_rotations() -> np.ndarray:
    """The 24 rotations of the cube, exact in floating point."""
    found = []
    for permutation in itertools.permutations(range(3)):
        for signs in itertools.product([-1.0, 1.0], repeat=3):
            M = np.zeros((3, 3))
            M[range(3), permutation] = signs
            if np.linalg.det(M) > 0.0:
                found.append(M)
    return np.array(found)


def random_rotations(count: int, seed: int = 0) -> np.ndarray:
    return Rotation.random(count, random_state=np.random.default_rng(seed)).as_matrix()


def worst(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.abs(np.asarray(a) - np.asarray(b)).max(initial=0.0))
