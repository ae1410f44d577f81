"""The kernels of the reach maps, compared with the robot's own answers and with independent formulas."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loops import every_value
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.reach._kernels import DIRECTION_COUNT, MovedChain, direction_cells, moved_chain
from nao_kin.reach.sampling import _draws
from nao_kin.robot.semantics import CoupledLimit, Semantics

ROOT = Path(__file__).resolve().parents[2]
SAMPLES = 200


@pytest.fixture(scope="module")
def kernels() -> Any:
    from nao_kin.reach import _kernels

    return _kernels


def drawn(kernels: Any, chain: MovedChain, count: int = SAMPLES, seed: int = 3) -> np.ndarray:
    values = np.empty((count, len(chain.joints)))
    kernels.joint_values(_draws(seed, (0, count), len(chain.joints)), chain.tables, values)
    return values


def hands(kernels: Any, chain: MovedChain, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    positions, axes, manipulability = np.empty((len(values), 3)), np.empty((len(values), 3)), np.empty(len(values))
    kernels.hands(values, chain.tables, positions, axes, manipulability)
    return positions, axes, manipulability


def configurations(robot: nk.RobotModel, chain: MovedChain, values: np.ndarray) -> np.ndarray:
    columns = dict(zip(chain.joints, values.T, strict=True))
    return robot.configuration(columns, limits="ignore")


def singular_volume(jacobian: np.ndarray) -> np.ndarray:
    """Return the product of the singular values that the number of columns allows to be nonzero."""
    return np.linalg.svd(jacobian, compute_uv=False).prod(axis=-1)


def check_hands(kernels: Any, robot: nk.RobotModel, frame: str, reference: str | None) -> None:
    chain = moved_chain(robot, frame, reference)
    values = drawn(kernels, chain)
    q = configurations(robot, chain, values)
    positions, axes, manipulability = hands(kernels, chain, values)
    poses = robot.fk(q, chain.frame, reference=reference)
    assert np.abs(positions - poses[:, :3, 3]).max() < 1e-12
    assert np.abs(axes - poses[:, :3, 0]).max() < 1e-12
    if reference is None:
        offset = robot.nv - len(robot.joint_names)
        moving = [offset + robot.joint_names.index(name) for name in chain.joints[: chain.tables.moving]]
        jacobian = robot.jacobian(q, chain.frame)[:, :3, moving]
        assert np.abs(manipulability - singular_volume(jacobian)).max() < 1e-12
        others = np.delete(robot.jacobian(q, chain.frame)[:, :3, offset:], [m - offset for m in moving], axis=-1)
        assert np.abs(others).max(initial=0.0) < 1e-12
    assert (np.linalg.norm(positions - chain.centre, axis=-1) <= chain.radius).all()
    assert manipulability.max() <= chain.manipulability_step * 2**30


@pytest.mark.parametrize(
    ("reference", "frame"),
    every_value([None, "RElbowYaw", "RLeg"], ["LArm", "RArm", "LLeg", "CameraTop", "LHand", "LElbowYaw"]),
)
def test_hands_are_where_the_robot_says(kernels: Any, nao: nk.NaoModel, frame: str, reference: str | None) -> None:
    check_hands(kernels, nao, frame, reference)


def test_one_motor_between_two_feet_counts_once(kernels: Any, nao: nk.NaoModel) -> None:
    chain = moved_chain(nao, "LLeg", "RLeg")
    assert chain.joints.count("LHipYawPitch") == 1
    assert len(chain.joints) == 11
    check_hands(kernels, nao, "LLeg", "RLeg")


def test_the_manipulability_in_another_frame_agrees_with_finite_differences(kernels: Any, nao: nk.NaoModel) -> None:
    chain = moved_chain(nao, "LLeg", "RLeg")
    values, h = drawn(kernels, chain, 20), 1e-6
    columns = []
    for c in range(len(chain.joints)):
        step = np.eye(len(chain.joints))[c] * h
        ahead, behind = (configurations(nao, chain, values + sign * step) for sign in (1, -1))
        there = nao.position(ahead, "LLeg", reference="RLeg") - nao.position(behind, "LLeg", reference="RLeg")
        columns.append(there / (2 * h))
    expected = singular_volume(np.stack(columns, axis=-1))
    assert np.allclose(hands(kernels, chain, values)[2], expected, rtol=1e-7, atol=1e-10)


# A frame away from all axes, so that every joint moves it.
TIP = J("tip", kind="fixed", xyz=(0.1, 0.2, 0.05))
MADE_UP = {
    "slides": (
        J("a", (1, 0, 0), (0.1, 0, 0), kind="prismatic", limits=(-0.2, 0.3)),
        J("b", (0, 1, 0), (0, 0.1, 0.2)),
        TIP,
    ),
    "skew": (
        J("a", (0.6, 0, 0.8), (0.1, 0.2, 0.3), (0.1, -0.4, 0.9)),
        J("b", (0, 0.6, -0.8), (0, 0.1, 0), (1.2, 0.3, -0.5)),
        J("c", (0.36, 0.48, 0.8), (0.3, 0, 0.1), (-2.0, 0.7, 0.2)),
        J("d", (-1, 0, 0), (0.05, 0.1, 0)),
        TIP,
    ),
    "follows": (
        J("a", (0, 0, 1), (0.1, 0, 0)),
        J("b", (0, 1, 0), (0.2, 0, 0), follows=("a", -1.5, 0.3)),
        J("c", (1, 0, 0), (0, 0.1, 0.1), kind="continuous"),
        J("d", (0, 0, 1), (0.1, 0, 0), kind="prismatic", follows=("c", 0.1, 0.05)),
        J("e", (0, 1, 0), (0.1, 0.1, 0), kind="fixed"),
        J("f", (0, 1, 0), (0.1, 0, 0.1)),
        TIP,
    ),
    "one": (J("a", (0, 1, 0), (0, 0, 0.1)), J("b", kind="fixed", xyz=(0.3, 0.2, 0.1), rpy=(0.3, 0.2, 0.1))),
}


@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("name", MADE_UP)
def test_any_joints_of_any_robot(kernels: Any, tmp_path: Path, name: str, base: str) -> None:
    robot = made_up(tmp_path, *MADE_UP[name], base=base)
    check_hands(kernels, robot, robot.link_names[-1], None)
    check_hands(kernels, robot, "base" if name != "one" else "b_l", robot.link_names[-1] if name != "one" else "base")


def test_romeo_too(kernels: Any) -> None:
    pytest.importorskip("pinocchio")
    try:
        romeo = nk.load_robot("romeo")
    except nk.errors.MissingExtra:
        pytest.skip("example-robot-data is not installed")
    check_hands(kernels, romeo, "l_sole", None)
    check_hands(kernels, romeo, "l_sole", "r_sole")
    assert moved_chain(romeo, "l_leg", None).frame == "l_sole"


class _Given:
    """A random generator that gives `JointLimits.random` the numbers that were already drawn."""

    def __init__(self, uniform: np.ndarray) -> None:
        self.uniform = uniform

    def random(self, shape: tuple[int, ...]) -> np.ndarray:
        assert self.uniform.shape == shape
        return self.uniform


def check_values(kernels: Any, robot: nk.RobotModel, chain: MovedChain) -> np.ndarray:
    """Check that the drawn values equal those that `random` makes from the same uniform numbers."""
    words = _draws(5, (0, SAMPLES), len(chain.joints))
    uniform = np.random.Generator(np.random.Philox(5)).random((SAMPLES, len(chain.joints)))
    assert np.array_equal((words >> np.uint64(11)) * 2.0**-53, uniform)
    columns = [robot.joint_names.index(name) for name in chain.joints]
    everywhere = np.zeros((SAMPLES, len(robot.joint_names)))
    everywhere[:, columns] = uniform
    expected = robot._limits.random(_Given(everywhere), (SAMPLES,))[:, columns]
    values = drawn(kernels, chain, seed=5)
    assert np.abs(values - expected).max() < 1e-14
    return values


@pytest.mark.parametrize("frame", ["LArm", "LLeg", "RLeg", "Head"])
def test_values_are_those_of_the_robots_random(kernels: Any, nao: nk.NaoModel, frame: str) -> None:
    chain = moved_chain(nao, frame, None)
    values = check_values(kernels, nao, chain)
    columns = [nao.joint_names.index(name) for name in chain.joints]
    assert nao.within_limits(configurations(nao, chain, values), per_joint=True)[:, columns].all()


def test_limits_that_depend_on_a_joint_outside_the_chain_are_obeyed(kernels: Any, tmp_path: Path) -> None:
    plain = made_up(tmp_path, J("a", parent="base", xyz=(0, 0, 0.1)), J("b", parent="base", xyz=(0.1, 0, 0)), J("c"))
    tables = (
        CoupledLimit("c", "b", (-1.0, 0.0, 2.0), (-0.5, -0.1, -2.0), (0.5, 0.2, 0.1)),
        CoupledLimit("b", "a", (0.0,), (-2.0,), (9.0,)),
    )
    robot = nk.RobotModel(plain.tree, Semantics(coupled_limits=tables))
    chain = moved_chain(robot, "c_l", None)
    assert chain.joints == ("b", "c", "a")
    assert chain.tables.moving == 2
    check_values(kernels, robot, chain)


def test_a_joint_with_one_value_only_stays_there(kernels: Any, tmp_path: Path) -> None:
    plain = made_up(tmp_path, J("a", limits=(0.25, 0.25)), J("b", xyz=(0.1, 0, 0)))
    robot = nk.RobotModel(plain.tree, Semantics(coupled_limits=(CoupledLimit("a", "b", (0.0,), (-1.0,), (1.0,)),)))
    assert (drawn(kernels, moved_chain(robot, "b_l", None))[:, 0] == 0.25).all()


def test_every_direction_is_in_the_cell_of_the_nearest_ring_and_its_area_is_one_48th(kernels: Any) -> None:
    centres = direction_cells()
    assert np.allclose(np.linalg.norm(centres, axis=1), 1.0)
    assert [kernels.direction_cell(*centre) for centre in centres] == list(range(DIRECTION_COUNT))
    v = np.random.default_rng(1).normal(size=(48_000, 3))
    v /= np.linalg.norm(v, axis=1)[:, None]
    cells = np.array([kernels.direction_cell(*row) for row in v])
    counts = np.bincount(cells, minlength=DIRECTION_COUNT)
    assert np.abs(counts - 1000).max() < 5 * np.sqrt(1000)
    # No point of a cell of this size is further than 38° from its middle.
    assert (v * centres[cells]).sum(axis=1).min() > np.cos(np.deg2rad(38))


# As astropy-healpix 2.0.1 answers: HEALPix(nside=2, order="ring").lonlat_to_healpix.
HEALPIX = [
    ((0.003, 0.7369, -0.6759), 37),
    ((-0.6322, -0.3231, -0.7042), 40),
    ((0.042, 0.938, -0.344), 30),
    ((-0.7152, 0.5652, 0.4111), 15),
    ((0.113, -0.9931, -0.031), 26),
    ((0.4401, -0.8502, -0.2891), 35),
    ((-0.6457, -0.4378, -0.6257), 40),
    ((-0.178, -0.9622, 0.206), 18),
    ((0.062, -0.074, -0.9953), 47),
    ((-0.9748, -0.088, 0.205), 16),
    ((-0.8149, -0.254, -0.521), 40),
    ((-0.519, 0.68, -0.518), 31),
    ((-0.031, 0.834, -0.551), 30),
    ((-0.6587, 0.6518, 0.3759), 15),
    ((-0.669, 0.042, 0.742), 7),
    ((-0.8724, 0.4842, 0.067), 23),
    ((-0.287, 0.8951, 0.3411), 14),
    ((-0.8997, 0.056, 0.4329), 16),
    ((-0.2649, 0.9598, -0.093), 22),
    ((0.3869, 0.8347, -0.3919), 37),
    ((0.3891, -0.8883, 0.2441), 26),
    ((-0.8889, -0.4339, -0.147), 24),
    ((0.4569, 0.5819, -0.6728), 37),
    ((-0.355, 0.289, -0.8891), 45),
]


@pytest.mark.parametrize(("direction", "cell"), HEALPIX)
def test_the_cells_are_those_of_healpix(kernels: Any, direction: tuple[float, ...], cell: int) -> None:
    assert kernels.direction_cell(*direction) == cell


def test_uncompiled_the_kernels_give_the_same_map(nao: nk.NaoModel, tmp_path: Path) -> None:
    program = (
        "import sys, nao_kin as nk; nk.reach.workspace(nk.load_nao('v6'), 'LLeg', 400, seed=9).save(sys.argv[1]); "
        "from nao_kin.reach import _kernels; assert not hasattr(_kernels.volume, 'py_func')"
    )
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-c", program, str(tmp_path / "m.npz")], check=True, env=environment, timeout=120)
    plain, compiled = nk.reach.load(tmp_path / "m.npz"), nk.reach.workspace(nao, "LLeg", 400, seed=9)
    assert np.array_equal(plain.indices, compiled.indices)
    assert np.array_equal(plain.masks, compiled.masks)
    assert np.abs(plain.total_steps - compiled.total_steps).max() <= 400
