"""Single decisions of the robot model and of its surroundings, each with the test that notices when it is reversed."""

from __future__ import annotations

import copy
import json
import math
import os
import pickle
import sys
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import FrameType
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.cli import doctor
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument, CouplingViolated, NotFinite, WrongShape
from nao_kin.robot.limits import JointLimits
from nao_kin.robot.nao import VERSIONS, nao_parameters
from nao_kin.robot.nao.model import nao_urdf_path

# --- building and unpickling ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_speed_and_torque_are_bounded_on_both_sides(tmp_path: Path, base: str) -> None:
    for robot in (nk.load_nao("v5", base=base), made_up(tmp_path, J("a"), J("b"), base=base)):
        joints = slice(robot.nv - len(robot.joint_names), None)
        assert np.array_equal(robot.model.lowerVelocityLimit[joints], -robot.velocity_limits)
        assert np.array_equal(robot.model.lowerEffortLimit[joints], -robot.effort_limits)
        assert np.all(robot.velocity_limits > 0)
        assert np.all(robot.effort_limits > 0)


@pytest.mark.parametrize("version", ["v3.3", "v6"])
def test_a_floating_base_leaves_every_joint_its_own_limits(version: str) -> None:
    fixed, free = nk.load_nao(version), nk.load_nao(version, base="floating")
    for limits in ("lower", "upper", "velocity_limits", "effort_limits"):
        assert getattr(free, limits).shape == (25,)
        assert np.array_equal(getattr(free, limits), getattr(fixed, limits)), limits


@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("duplicate", [lambda robot: pickle.loads(pickle.dumps(robot)), copy.copy, copy.deepcopy])
def test_copies_keep_every_number_that_was_changed_in_the_model(duplicate, base: str) -> None:
    nao = nk.NaoModel(version="v5", base=base)
    model, untouched = nao.model, nk.load_nao("v5", base=base)
    elbow, hip = model.getJointId("LElbowYaw"), model.getJointId("RHipYawPitch")
    model.jointPlacements[elbow].translation = np.array([0.11, 0.01, 0.02])
    body = model.inertias[hip]
    model.inertias[hip] = pin.Inertia(body.mass, np.add(body.lever, [0.0, 0.1, 0.0]), 2.0 * body.inertia)
    for name in ("CameraTop", "LArm"):
        frame = model.frames[model.getFrameId(name)]
        frame.placement = frame.placement * pin.SE3(pin.utils.rotate("x", 0.1), np.array([0.0, 0.0, 0.3]))
    arrays = [f"{side}{what}Limit" for side in ("lower", "upper") for what in ("Position", "Velocity", "Effort")]
    arrays += ["armature", "rotorInertia", "rotorGearRatio"]
    for place, name in enumerate(arrays):
        getattr(model, name)[-1] = 0.25 + place
    model.gravity.linear = np.array([0.0, 0.0, -1.62])
    other = duplicate(nao)

    q = nao.random(0)
    assert (other.version, other.base, other.mimics) == ("v5", base, nao.mimics)
    assert not other.lower.flags.writeable
    assert np.array_equal(other.posture("Sit"), nao.posture("Sit"))
    assert np.array_equal(other.fk(q), nao.fk(q))
    assert np.array_equal(other.com(q), nao.com(q))
    for name in ("CameraTop", "LArm", "LElbowYaw"):
        assert not np.allclose(nao.fk(q, name), untouched.fk(q, name), atol=1e-3)
    assert not np.allclose(nao.com(q), untouched.com(q), atol=1e-3)
    assert np.array_equal(other.model.inertias[hip].inertia, nao.model.inertias[hip].inertia)
    assert [getattr(other.model, name)[-1] for name in arrays] == [0.25 + place for place in range(9)]
    assert other.model.gravity.linear.tolist() == [0.0, 0.0, -1.62]


# --- limits -----------------------------------------------------------------------------------------------------------


def _at(nao: nk.NaoModel, **degrees: float) -> np.ndarray:
    return nao.configuration(
        {**nao.angles(nao.posture("Stand")), **{name: math.radians(value) for name, value in degrees.items()}},
        limits="ignore",
    )


def test_a_joint_outside_its_range_and_its_table_is_reported_once(nao: nk.NaoModel) -> None:
    (violation,) = nao.limit_violations(_at(nao, HeadYaw=62.45, HeadPitch=100.0))
    assert (violation.joint, violation.of) == ("HeadPitch", None)
    assert np.degrees([violation.lower, violation.upper]) == pytest.approx([-38.5, 29.5])
    (violation,) = nao.limit_violations(_at(nao, HeadYaw=62.45, HeadPitch=20.0))
    assert (violation.joint, violation.of) == ("HeadPitch", "HeadYaw")
    assert np.degrees([violation.lower, violation.upper]) == pytest.approx([-24.64, 17.19])


def test_in_a_batch_each_joint_is_reported_by_what_it_violates(nao: nk.NaoModel) -> None:
    q = np.stack([_at(nao, HeadYaw=62.45, HeadPitch=pitch) for pitch in (100.0, 0.0, 20.0)])
    found = [(violation.index, violation.joint, violation.of) for violation in nao.limit_violations(q)]
    assert found == [((0,), "HeadPitch", None), ((2,), "HeadPitch", "HeadYaw")]


def test_joints_with_one_limit_are_drawn_within_a_turn_of_it() -> None:
    names = ("above", "below", "free", "both")
    lower, upper = np.array([10.0, -math.inf, -math.inf, 0.5]), np.array([math.inf, -10.0, math.inf, 0.75])
    limits = JointLimits(names, lower, upper, ("rad",) * 4, ())
    values = limits.random(np.random.default_rng(0), (4000,))
    assert limits.violations(values) == ()
    widest = np.array([[10.0, 10.0 + 2 * math.pi], [-10.0 - 2 * math.pi, -10.0], [-math.pi, math.pi], [0.5, 0.75]])
    assert np.all(values >= widest[:, 0])
    assert np.all(values <= widest[:, 1])
    assert np.all(np.ptp(values, axis=0) > [6.2, 6.2, 6.2, 0.24])


# --- coordinates ------------------------------------------------------------------------------------------------------


@pytest.fixture
def offset_robot(tmp_path: Path) -> nk.RobotModel:
    return made_up(tmp_path, J("a"), J("b", follows=("a", 2.0, 0.5)))


def test_a_follower_with_an_offset_sets_its_driver(offset_robot: nk.RobotModel) -> None:
    q = offset_robot.configuration({"b": [1.5, 0.5, -0.5]})
    assert q == pytest.approx(np.array([[0.5], [0.0], [-0.5]]), abs=1e-15)
    for row, angle in zip(q, (1.5, 0.5, -0.5), strict=True):
        turn = offset_robot.rotation(row, "b", reference="a")
        assert np.allclose(turn, nk.rotations.rot_z(angle), atol=1e-15)


def test_a_follower_with_an_offset_must_suit_its_driver(offset_robot: nk.RobotModel) -> None:
    assert offset_robot.configuration({"a": 0.25, "b": 1.0})[0] == 0.25
    with pytest.raises(CouplingViolated) as caught:
        offset_robot.configuration({"a": 0.25, "b": 0.5})
    assert (caught.value.primary_value, caught.value.mimic_value, caught.value.expected) == (0.25, 0.5, 1.0)


# --- the command line -------------------------------------------------------------------------------------------------


def _joint_rows(capsys: pytest.CaptureFixture, *options: str) -> dict[tuple[str, ...], dict]:
    assert run(["joints", "--json", *options]) == 0
    return {tuple(row["parts"]): row for row in json.loads(capsys.readouterr().out)["rows"]}


@pytest.mark.parametrize("version", ["v3.2", "v6"])
def test_speeds_follow_the_angles_into_degrees_and_torques_do_not(capsys: pytest.CaptureFixture, version: str) -> None:
    plain = _joint_rows(capsys, "--nao", version)
    degrees = _joint_rows(capsys, "--nao", version, "--deg")
    for joint in nao_parameters(version).joints:
        radians_row, degrees_row = plain[(joint.name,)], degrees[(joint.name,)]
        scale = math.degrees(1.0) if joint.unit == "rad" else 1.0
        assert radians_row["velocity"] == [joint.velocity]
        assert degrees_row["velocity"] == pytest.approx([joint.velocity * scale], rel=1e-12)
        assert radians_row["effort"] == degrees_row["effort"] == [joint.effort]
        assert (radians_row["units"], degrees_row["units"]) == ([joint.unit], ["deg" if scale > 1.0 else "1"])
        assert degrees_row["lower"] == pytest.approx([joint.lower * scale], abs=1e-12)
        assert degrees_row["upper"] == pytest.approx([joint.upper * scale], abs=1e-12)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_phalanx_is_as_fast_as_the_hand_makes_it(version: str) -> None:
    hands = {joint.name: joint for joint in nao_parameters(version).joints if joint.unit == "1"}
    phalanges = [
        (joint.find("limit"), mimic)
        for joint in ET.parse(nao_urdf_path(version)).findall("joint")
        if (mimic := joint.find("mimic")) is not None and mimic.get("joint") in hands
    ]
    assert len(phalanges) == 16
    for limit, mimic in phalanges:
        hand, ratio = hands[mimic.get("joint")], float(mimic.get("multiplier"))
        assert ratio == 0.999899
        got = [float(limit.get(name)) for name in ("lower", "upper", "velocity", "effort")]
        assert got == pytest.approx([ratio * hand.lower, ratio * hand.upper, ratio * hand.velocity, hand.effort])


# --- the installation -------------------------------------------------------------------------------------------------


def _problems_with_pinocchio_at(folder: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the reported problems if Python would load Pinocchio from `folder`."""
    found = doctor.importlib.util.find_spec

    def find_spec(name: str, package: str | None = None) -> ModuleSpec | None:
        if name == "pinocchio":
            return ModuleSpec(name, None, origin=str(folder / "pinocchio" / "__init__.py"))
        return found(name, package)

    with monkeypatch.context() as patch:
        patch.setattr(doctor.importlib.util, "find_spec", find_spec)
        patch.setattr(doctor, "_probed", lambda program, _: (0, "25 " * ("load_nao" in program), ""))
        problems = doctor.inspect_installation({"PATH": os.environ.get("PATH", "")})["problems"]
    return [problem for problem in problems if "outside of this Python" in problem]


def test_pinocchio_from_elsewhere_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "environment"))
    (problem,) = _problems_with_pinocchio_at(tmp_path / "build" / "install", monkeypatch)
    assert str(tmp_path / "build" / "install" / "pinocchio") in problem
    assert str(tmp_path / "environment") in problem


@pytest.mark.parametrize("folder", ["environment/lib/cmeel.prefix", "home/.local/lib/python3.12/site-packages"])
def test_pinocchio_of_this_python_or_of_its_user_is_at_home(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: str
) -> None:
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "environment"))
    assert _problems_with_pinocchio_at(tmp_path / folder, monkeypatch) == []


def test_nobody_changes_the_tree_that_all_robots_of_a_version_share(nao: nk.NaoModel) -> None:
    for table in (nao.tree.inertials, nao.tree.shared_names, nao.semantics.postures["Stand"].angles):
        with pytest.raises(TypeError):
            table["torso"] = None  # type: ignore[index]
    for copied in (copy.deepcopy(nao.tree), pickle.loads(pickle.dumps(nao.tree))):
        assert copied == nao.tree
        assert copied.inertials == nao.tree.inertials


def test_a_robot_loaded_again_is_kept_where_it_can_be_and_a_model_of_its_own(nao: nk.NaoModel) -> None:
    calls = 0

    def count(frame: FrameType, event: str, _: object) -> None:
        nonlocal calls
        calls += event == "call" and frame.f_code.co_filename.startswith(str(Path(nk.__file__).parent))

    sys.setprofile(count)
    try:
        again = nk.load_nao()
    finally:
        sys.setprofile(None)
    assert calls < 300
    again.model.inertias[1].mass *= 2.0
    again.model.jointPlacements[1].translation *= 2.0
    again.model.lowerPositionLimit[0] = -9.0
    for robot in (nao, nk.load_nao()):
        assert robot.mass < again.mass
        assert robot.model.jointPlacements[1] != again.model.jointPlacements[1]
        assert robot.model.lowerPositionLimit[0] != -9.0


@pytest.mark.parametrize("base", ["fixed", "floating"])
def test_configurations_are_given_back_as_an_array_or_refused(base: str) -> None:
    nao = nk.load_nao(base=base)
    q = nao.random(0, (2, 3))
    q[..., -1] = 5.0  # outside the limits, and a configuration all the same
    checked = nao.checked(q.tolist())
    assert checked.dtype == np.float64
    assert checked == pytest.approx(q, abs=0.0)
    with pytest.raises(NotFinite, match="RHand"):
        nao.checked([*q[0, 0, :-1], math.nan])
    with pytest.raises(WrongShape):
        nao.checked(q[0, 0, 1:])
    if base == "floating":
        q[..., 3:7] *= 1.0 + 5e-7
        assert np.linalg.norm(nao.checked(q)[..., 3:7], axis=-1) == pytest.approx(1.0, abs=1e-15)
        q[..., 3:7] = nk.rotations.quat_from_matrix(nk.rotations.random_rotation(0, (2, 3)))
        assert np.array_equal(nao.checked(q), q)
        with pytest.raises(BadArgument, match="unit quaternion"):
            nao.checked(0.5 * q)


def test_results_are_c_contiguous_whatever_the_input(nao: nk.NaoModel) -> None:
    q = np.asfortranarray(nao.random(0, (4, 3)))
    for result in (
        nao.clamp(q),
        nao.check_limits(q),
        nao.within_limits(q, per_joint=True),
        nao.fk(q),
        nao.fk(q, "LArm", reference="Head"),
        nao.jacobian(q, "LArm"),
        nao.com(q),
    ):
        assert result.flags.c_contiguous


def test_the_centre_of_mass_follows_what_the_owner_changes_in_the_model(nao: nk.NaoModel) -> None:
    robot, q = copy.deepcopy(nao), nao.posture("Crouch")
    for _ in range(2):
        trunk = robot.model.inertias[0]
        before, mass = robot.com(q) * robot.mass, robot.mass
        robot.model.inertias[0] = pin.Inertia(trunk.mass + 1.0, trunk.lever, trunk.inertia)
        assert robot.mass == pytest.approx(mass + 1.0)
        assert np.allclose(robot.com(q) * robot.mass, before + trunk.lever, atol=1e-12)
        assert np.allclose(robot.com([q, q]), robot.com(q), atol=1e-15)
    last = robot.com(q)
    del robot.model
    assert np.array_equal(robot.com(q), last)
