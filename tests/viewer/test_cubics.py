"""The cubics of a motion evaluate to its configurations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.motion.interpolation import bezier_parameter
from nao_kin.viewer.cubics import Cubics, cubics

NAMES = ("HeadYaw", "LShoulderPitch", "LHipYawPitch", "RHipYawPitch")


def _motion(interpolation: Any, seed: int) -> nk.Motion:
    """A motion whose joints have their own times, but the hips share theirs."""
    rng = np.random.default_rng(seed)
    times = [seed + np.cumsum(rng.uniform(0.05, 1.0, 6)) for _ in NAMES]
    times[3] = times[2]
    motion = nk.Motion(times, NAMES, list(rng.normal(0.0, 0.5, (4, 6))), interpolation)
    if motion.handles is None:
        return motion
    handles = [each * rng.uniform(0.0, 2.9, each.shape) for each in motion.handles]
    handles[3] = handles[3] * [1.0, 0.0] + handles[2] * [0.0, 1.0]
    handles[3][..., 0] = handles[2][..., 0]
    return nk.Motion(times, NAMES, motion.keys, interpolation, handles)


def _evaluated(found: Cubics, t: np.ndarray) -> np.ndarray:
    """The formula of `nao_kin.motion.interpolation`, segment by segment."""
    place = np.clip(np.searchsorted(found.times, t, side="right") - 1, 0, len(found.times) - 2)
    x = ((t - found.times[place]) / np.diff(found.times)[place])[:, None] * np.ones(found.q.shape[1])
    rise = np.diff(found.q, axis=0)[place]
    if found.handles is None:
        return found.q[place] + x * rise
    p, q, a, b = np.moveaxis(found.handles[place], -1, 0)
    u = bezier_parameter(a.ravel(), b.ravel(), x.ravel()).reshape(x.shape)
    return found.q[place] + 3 * u * (1 - u) ** 2 * p + 3 * u**2 * (1 - u) * q + u**3 * rise


@pytest.mark.parametrize("interpolation", ["linear", "smooth", "bezier"])
def test_cubics_are_the_configurations(nao: nk.NaoModel, interpolation: Any) -> None:
    for seed in range(3):
        motion = _motion(interpolation, seed)
        found = cubics(motion, nao, "Stand")
        assert found is not None
        t = np.linspace(0.0, motion.duration, 1000)
        wanted = motion.configurations(nao, times=motion.start + t, missing="Stand").q
        assert np.abs(_evaluated(found, t) - wanted).max() < 1e-12


def test_an_average_of_bezier_curves_that_differ_in_time_has_no_cubics(nao: nk.NaoModel) -> None:
    motion = _motion("bezier", 0)
    handles = [np.array(each) for each in motion.handles or ()]
    handles[3][..., 0] *= 0.5
    other = nk.Motion(motion.times, NAMES, motion.keys, "bezier", handles)
    assert cubics(other, nao, "Stand") is None
    single = nk.Motion([3.0], ["HeadYaw"], [[0.2]], "smooth")
    found = cubics(single, nao, "Stand")
    assert found is not None
    assert (found.times.tolist(), found.handles, found.q.shape) == ([0.0], None, (1, 25))
