"""The default installation, compared with Pinocchio and finite differences, and its messages about missing extras.

Needs pytest and nothing of the other tests, so that it runs where only the default dependencies are:
`.ci/light`. Where extras are installed their absence is left to test_without_extras.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import nao_kin as nk
from nao_kin._core.extras import EXTRAS
from nao_kin._kernels import cache as compiler
from nao_kin.cli import doctor
from nao_kin.cli.app import run
from nao_kin.errors import MissingExtra, NotCompiledWarning

HAS_NUMBA = importlib.util.find_spec("numba") is not None
MANY = 100  # more than Pinocchio is left to answer where there are kernels
pytestmark = [
    pytest.mark.full,  # with the extras, the tests of the rooms check the same
    pytest.mark.filterwarnings("ignore::nao_kin.errors.NotCompiledWarning"),  # without Numba, of what takes long
]


@pytest.fixture(scope="module")
def robot() -> nk.NaoModel:
    return nk.load_nao("v6")


@pytest.fixture(scope="module")
def q(robot: nk.NaoModel) -> np.ndarray:
    return robot.random(0, MANY)


def test_poses_of_one_and_of_many_are_pinocchios(robot: nk.NaoModel, q: np.ndarray) -> None:
    data = robot.model.createData()
    frames = ("LArm", "RLeg", "CameraTop_optical_frame")
    expected = np.empty((MANY, 3, 4, 4))
    for row, T in zip(q, expected, strict=True):
        pin.framesForwardKinematics(robot.model, data, row)
        T[:] = [data.oMf[index].homogeneous for index in robot.frame_ids(frames)]
    np.testing.assert_allclose(robot.fk(q, frames), expected, atol=1e-14)
    np.testing.assert_allclose(robot.fk(q, frames, threads=2), expected, atol=1e-14)
    np.testing.assert_allclose(robot.fk(q, frames, dtype=np.float32), expected, atol=1e-6)
    np.testing.assert_allclose(robot.fk(q[7], frames), expected[7], atol=1e-14)
    inverse = np.linalg.inv(expected[:, 2]) @ expected[:, 0]
    np.testing.assert_allclose(robot.fk(q, "LArm", reference="CameraTop_optical_frame"), inverse, atol=1e-14)


def test_the_jacobian_and_the_velocity_are_finite_differences(robot: nk.NaoModel, q: np.ndarray) -> None:
    v, step = np.random.default_rng(1).normal(size=q.shape), 1e-6
    moved = (robot.position(q + step * v, "LArm") - robot.position(q - step * v, "LArm")) / (2 * step)
    by_jacobian = np.einsum("nij,nj->ni", robot.jacobian(q, "LArm")[:, :3], v)
    np.testing.assert_allclose(by_jacobian, moved, atol=1e-8)
    np.testing.assert_allclose(robot.velocity(q, v, "LArm")[:, :3], moved, atol=1e-8)


def test_the_centre_of_mass_is_the_mean_of_all_bodies(robot: nk.NaoModel, q: np.ndarray) -> None:
    data, expected = robot.model.createData(), np.zeros((MANY, 3))
    for row, centre in zip(q, expected, strict=True):
        pin.forwardKinematics(robot.model, data, row)
        for inertia, placement in zip(robot.model.inertias, data.oMi, strict=True):
            centre += inertia.mass * placement.act(inertia.lever) / robot.mass
    np.testing.assert_allclose(robot.com(q), expected, atol=1e-14)
    np.testing.assert_allclose(robot.com(q[3]), expected[3], atol=1e-14)


def test_nan_is_refused_in_any_batch(robot: nk.NaoModel, q: np.ndarray) -> None:
    with pytest.raises(nk.errors.NotFinite):
        robot.fk(np.where(np.arange(25) == 3, np.nan, q), "LArm")


@pytest.mark.parametrize("count", [1, 12])
def test_inverse_kinematics_in_closed_form_gives_the_poses_back(robot: nk.NaoModel, q: np.ndarray, count: int) -> None:
    some = q[0] if count == 1 else q[:count]
    arm = nk.ik.arm(robot, "L", robot.fk(some, "LArm"))
    leg = nk.ik.leg(robot, "R", robot.fk(some, "RLeg"))
    legs = nk.ik.legs(robot, robot.fk(some, "LLeg"), robot.fk(some, "RLeg"))
    head = nk.ik.head(robot, robot.rotation(some, "Head"))
    place = nk.ik.arm(robot, "R", robot.position(some, "RArm"))
    for found, frame in ((arm, "LArm"), (leg, "RLeg"), (legs, "LLeg"), (legs, "RLeg")):
        assert np.all(found.success)
        np.testing.assert_allclose(robot.fk(found.q, frame), robot.fk(some, frame), atol=1e-9)
    assert np.all(head.success)
    np.testing.assert_allclose(robot.rotation(head.q, "Head"), robot.rotation(some, "Head"), atol=1e-9)
    assert np.all(place.success)
    np.testing.assert_allclose(robot.position(place.q, "RArm"), robot.position(some, "RArm"), atol=1e-9)


def test_numeric_inverse_kinematics_meets_its_targets(robot: nk.NaoModel, q: np.ndarray) -> None:
    for some in (q[0], q[:3]):
        found = nk.ik.numeric(robot, "LArm", robot.fk(some, "LArm"))
        assert np.all(found.success)
        np.testing.assert_allclose(robot.fk(found.q, "LArm"), robot.fk(some, "LArm"), atol=1e-7)


def test_the_whole_body_reaches_and_stands(robot: nk.NaoModel) -> None:
    q = robot.posture("StandInit")
    target = robot.position(q, "LArm") + 0.01
    found = nk.ik.whole_body(robot, {"LArm": target}, com="support", near=q)
    assert found.success
    T_world_torso = robot.fk(q, "LLeg") @ np.linalg.inv(robot.fk(found.q, "LLeg"))
    np.testing.assert_allclose(T_world_torso @ robot.fk(found.q, "RLeg"), robot.fk(q, "RLeg"), atol=1e-7)
    hand = T_world_torso @ robot.fk(found.q, "LArm")
    np.testing.assert_allclose(hand[:3, 3], target, atol=1e-7)


def test_a_reach_map_holds_its_samples_within_the_arms_length(robot: nk.NaoModel) -> None:
    reach = nk.reach.workspace(robot, "LArm", samples=300, voxel=0.02)
    assert reach.samples == 300
    shoulder = robot.position(robot.neutral(), "LShoulderPitch")
    arm = np.linalg.norm(robot.position(robot.neutral(), "LArm") - shoulder)
    assert np.linalg.norm(reach.centres - shoulder, axis=-1).max() < arm + 0.04


def test_a_page_and_a_motion_are_written(robot: nk.NaoModel, tmp_path: Path) -> None:
    viewer = nk.Viewer(robot)
    viewer.display(robot.posture("Sit"))
    page = tmp_path / "nao.html"
    viewer.save_html(page)
    viewer.close()
    assert page.read_text(encoding="utf-8").lstrip().lower().startswith("<!doctype html>")
    nod = nk.Motion([0.0, 1.0, 2.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
    assert nk.motion.check(robot, nod).ok
    nk.motion.write_motion(nod, tmp_path / "nod.json")
    np.testing.assert_array_equal(nk.motion.read_motion(tmp_path / "nod.json").sample([1.0]), [[0.3]])


def test_the_independent_implementations_agree(robot: nk.NaoModel) -> None:
    report = nk.crosscheck.run(robot, samples=3)
    assert report.ok
    assert any("batch kernels" in row.convention for row in report.rows) == HAS_NUMBA


@pytest.mark.parametrize(
    "words",
    [
        "info",
        "joints --typed",
        "fk --posture Stand --frame LArm",
        "ik LArm --target 0.15,0.12,0.05",
        "doctor",
        "reach LArm --samples 200",
    ],
)
def test_a_command_ends_well(words: str, capsys: pytest.CaptureFixture) -> None:
    assert run(words.split()) == 0
    assert capsys.readouterr().out


def test_doctor_names_every_extra(capsys: pytest.CaptureFixture, monkeypatch: pytest.MonkeyPatch) -> None:
    # Whether the libraries load is tried in processes of their own, above.
    monkeypatch.setattr(doctor, "_probed", lambda program, _: (0, "25 " * ("load_nao" in program), ""))
    assert run(["doctor", "--json"]) == 0
    found = {extra["name"]: extra["version"] for extra in json.loads(capsys.readouterr().out)["extras"]}
    assert found.keys() == EXTRAS.keys()
    assert {name for name, version in found.items() if version is None} == {n for n in EXTRAS if _absent(n)}


# --- what is said where an extra is absent --------------------------------------------------------------------------


def _absent(name: str) -> bool:
    extra = EXTRAS[name]
    if extra.modules:
        return any(importlib.util.find_spec(module) is None for module in extra.modules)
    try:
        importlib.metadata.version(extra.packages[0])
    except importlib.metadata.PackageNotFoundError:
        return True
    return False


def _stream(robot: nk.NaoModel, folder: Path) -> object:
    return nk.stream.fk(robot, folder / "q.parquet", folder / "poses.npy", frame="LArm")


ASKED: dict[str, Callable[[nk.NaoModel, Path], object]] = {
    "batch": lambda robot, folder: nk._kernels.kernel(np.dtype(float), np.dtype(float)),
    "robots": lambda robot, folder: nk.load_robot("romeo"),
    "arrow": _stream,
    "dask": lambda robot, folder: nk.distributed.connect(),
    "naoqi": lambda robot, folder: nk.naoqi.NaoqiSource("localhost"),
    "plot": lambda robot, folder: nk.motion.plot(robot, nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.1]])),
    "mujoco": lambda robot, folder: nk.export.mjcf(robot, folder / "nao"),
    "analytic": lambda robot, folder: nk.ik.analytic(robot, "LArm", np.eye(4)),
    "calibration": lambda robot, folder: nk.calibration.calibrate(robot, [], joints=["HeadYaw"]),
    "photos": lambda robot, folder: nk.calibration.from_photos(robot, folder, "log.csv", board=(9, 6), square=0.03),
    "symbolic": lambda robot, folder: nk.joints.dh_table(robot, "LArm").symbolic(),
}


def test_every_extra_that_can_be_asked_for_is_asked_for() -> None:
    # Without anywidget a cell shows the page as it is; a xacro source and an unknown name are refused in other words.
    assert ASKED.keys() | {"notebook", "xacro", "descriptions", "c3d"} == EXTRAS.keys()


@pytest.mark.parametrize("name", ASKED)
def test_an_absent_extra_is_one_line_that_says_what_works_without_it(
    robot: nk.NaoModel, tmp_path: Path, name: str
) -> None:
    if not _absent(name):
        pytest.skip("it is installed")
    with pytest.raises(MissingExtra) as caught:
        ASKED[name](robot, tmp_path)
    text = str(caught.value)
    package, without = EXTRAS[name].packages[0], EXTRAS[name].without
    assert text.endswith(f" needs {package}: pip install 'nao-kin[{name}]'; {without}")
    assert isinstance(caught.value, ImportError)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(HAS_NUMBA, reason="Numba is installed")
def test_without_numba_what_takes_long_is_warned_of_once(robot: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "_NOTICEABLE_SECONDS", 0.01)
    slowness = compiler._Slowness()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        slowness.add(0.009)
        assert caught == []
        slowness.add(0.009)
        slowness.add(1.0)
    (warning,) = caught
    assert warning.category is NotCompiledWarning
    assert str(warning.message) == (
        "numba is not installed: this runs as plain Python, with the same result but slowly; "
        "pip install 'nao-kin[batch]'"
    )


@pytest.mark.skipif(HAS_NUMBA, reason="Numba is installed")
def test_without_numba_one_configuration_and_a_thousand_are_not_warned_of(tmp_path: Path) -> None:
    code = (
        "import nao_kin as nk; nao = nk.load_nao(); q = nao.random(0, 1000); nao.fk(q); nao.com(q)\n"
        "nk.ik.arm(nao, 'L', nao.position(q[0], 'LArm')); nk.ik.leg(nao, 'L', nao.fk(q, 'LLeg'))"
    )
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True, cwd=tmp_path)


@pytest.mark.skipif(HAS_NUMBA, reason="Numba is installed")
def test_nothing_is_compiled_ahead_without_numba(capsys: pytest.CaptureFixture) -> None:
    assert nk.warm_up() == ()
    assert run(["warmup"]) == 2
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == (
        "",
        "nao-kin: warmup needs numba: pip install 'nao-kin[batch]'; "
        "same results without it; large batches are slower\n",
    )
