"""Checks shared by the tests of inverse kinematics."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import nao_kin as nk
from nao_kin.ik import IKResult

Floats = NDArray[np.float64]
BESIDE = [0.0, *(10.0**k for k in range(-15, -2))]


def pose_errors(T: Floats, wanted: Floats) -> Floats:
    """Distances [m] and angles [rad] between poses, shape (..., 2)."""
    away = np.linalg.norm(T[..., :3, 3] - wanted[..., :3, 3], axis=-1)
    chord = np.linalg.norm((T - wanted)[..., :3, :3], axis=(-2, -1))
    return np.stack([away, 2.0 * np.arcsin(np.minimum(1.0, chord / np.sqrt(8.0)))], axis=-1)


def derivatives(errors: Callable[[Floats], Floats]) -> Callable[[Floats], Floats]:
    """Return the Jacobian of `errors`, which takes values (n, k) and returns (n, m), by forward differences at once."""

    def jacobian(values: Floats) -> Floats:
        step = 1e-8
        rows = errors(np.vstack([values, values + step * np.eye(len(values))]))
        return (rows[1:] - rows[0]).T / step

    return jacobian


def assert_solved(robot: nk.RobotModel, frame: str, T: Floats, found: IKResult, *, inside: bool = True) -> None:
    """Check that every target is reached, and that all solutions meet it to 1e-10 inside the limits."""
    assert np.all(found.success), found
    solutions = found.solutions
    real = ~np.isnan(solutions).any(axis=-1)
    np.testing.assert_array_equal(real.sum(axis=-1), found.count)
    rows = solutions[real]
    wanted = np.broadcast_to(T[..., None, :, :], (*real.shape, 4, 4))[real]
    errors = pose_errors(robot.fk(rows, frame), wanted)
    assert errors.max() < 1e-10, errors.max(axis=0)
    if inside:
        assert robot.within_limits(rows).all()
    assert np.nanmax(found.residual) < 1e-10


def distance_to_solutions(found: IKResult, q: Floats) -> Floats:
    """The largest joint difference between configurations and the solution nearest to each, shape (...)."""
    differences = np.abs(found.branches - q[..., None, found.columns]).max(axis=-1)
    return np.asarray(np.nanmin(differences, axis=-1))
