"""Variants of a robot's tree: what changes is said, and everything else stays."""

from __future__ import annotations

import numpy as np
import pytest

import nao_kin as nk
from nao_kin.export.variants.frames import keep_frames
from nao_kin.export.variants.inertia import make_physical

VERSIONS = ("v3.2", "v3.3", "v4", "v5", "v6")


@pytest.mark.parametrize("frames", ["all", "effectors", "none"])
@pytest.mark.parametrize("version", VERSIONS)
def test_links_that_stay_move_as_before(version: str, frames: str) -> None:
    nao = nk.load_nao(version)
    q = nao.random(np.random.default_rng(1), 20)
    tree, _ = keep_frames(nao.tree, frames, nao.semantics)
    robot = nk.RobotModel(tree)
    np.testing.assert_allclose(robot.fk(q, tree.links), nao.fk(q, tree.links), atol=1e-14)
    np.testing.assert_allclose(robot.com(q), nao.com(q), atol=1e-14)
    assert robot.mass == pytest.approx(nao.mass, abs=1e-14)


@pytest.mark.parametrize("version", VERSIONS)
def test_physical_inertias_keep_mass_and_centre_of_mass(version: str) -> None:
    nao = nk.load_nao(version)
    q = nao.random(np.random.default_rng(2), 50)
    robot = nk.RobotModel(make_physical(nao.tree)[0])
    assert robot.mass == pytest.approx(nao.mass, abs=1e-12)
    np.testing.assert_allclose(robot.com(q), nao.com(q), atol=1e-12)
