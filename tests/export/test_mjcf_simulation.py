"""Exported robots in MuJoCo's simulation and in mink: standing, sensing, couplings, inverse kinematics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_robots import J, made_up

import nao_kin as nk

mujoco = pytest.importorskip("mujoco")
from mujoco_models import exported, simulate  # noqa: E402

GRAVITY = 9.81


@pytest.fixture(scope="module")
def model(nao: nk.NaoModel, tmp_path_factory: pytest.TempPathFactory) -> Any:
    return exported(nao, tmp_path_factory.mktemp("mjcf") / "nao", meshes="none")


def _check_that_it_stands(model: Any, key: str, seconds: float) -> Any:
    data, (tilt, sinking, drift) = simulate(model, key, seconds)
    assert np.isfinite(data.qpos).all()
    assert not any(warning.number for warning in data.warning)
    assert np.degrees(tilt) < 3.0
    assert sinking < 0.005
    assert drift < 0.01
    assert abs(data.joint("LHipYawPitch").qpos[0] - data.joint("RHipYawPitch").qpos[0]) < 1e-4
    return data


def test_every_version_stands_ten_seconds(each_nao: nk.NaoModel, tmp_path: Path) -> None:
    model = exported(each_nao, tmp_path / "nao", meshes="none")
    data = _check_that_it_stands(model, "StandInit", 10.0)
    assert np.abs(data.qvel).max() < 1e-2
    for key in ("Stand", "Crouch"):
        _check_that_it_stands(model, key, 1.5)


@pytest.mark.parametrize("options", [{"typed": True}, {"typed": True, "coupling": "independent"}])
def test_it_stands_on_typed_joints_too(nao: nk.NaoModel, tmp_path: Path, options: dict[str, Any]) -> None:
    model = exported(nao, tmp_path / "nao", meshes="none", **options)
    data, (tilt, sinking, _) = simulate(model, "StandInit", 4.0)
    assert np.isfinite(data.qpos).all()
    assert np.degrees(tilt) < 3.0
    assert sinking < 0.005


def test_one_motor_turns_both_hips(model: Any) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("StandInit").id)
    data.qpos[2] += 1.0
    model_in_space = model.__copy__()
    model_in_space.opt.gravity[:] = 0.0
    data.actuator("LHipYawPitch").ctrl = -0.3
    for _ in range(1000):
        mujoco.mj_step(model_in_space, data)
        assert abs(data.joint("LHipYawPitch").qpos[0] - data.joint("RHipYawPitch").qpos[0]) < 2e-3
    assert data.joint("LHipYawPitch").qpos[0] == pytest.approx(-0.3, abs=5e-3)


def test_followers_go_where_their_coupling_says(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("a", (0.0, 1.0, 0.0), (0.0, 0.0, 0.3), limits=(-1.0, 1.0)),
        J("b", (1.0, 0.0, 0.0), (0.0, 0.0, 0.3), follows=("a", -0.5, 0.25)),
        J("c", (0.0, 0.0, 1.0), kind="prismatic", parent="base", follows=("a", 0.2, 0.01)),
    )
    model = exported(robot, tmp_path / "model", base="fixed")
    model.opt.gravity[:] = 0.0
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.actuator("a").ctrl = 0.6
    for _ in range(4000):
        mujoco.mj_step(model, data)
    a, b, c = (data.joint(name).qpos[0] for name in "abc")
    assert a == pytest.approx(0.6, abs=0.01)
    assert b == pytest.approx(0.25 - 0.5 * a, abs=1e-4)
    assert c == pytest.approx(0.01 + 0.2 * a, abs=1e-4)


def _reading(data: Any, name: str) -> np.ndarray:
    return np.array(data.sensor(name).data)


def test_sensors_say_what_they_measure(nao: nk.NaoModel, model: Any) -> None:
    data, _ = simulate(model, "StandInit", 2.0)
    R_world_torso = data.body("torso").xmat.reshape(3, 3)
    # At rest an accelerometer shows the reaction to gravity, upwards.
    np.testing.assert_allclose(_reading(data, "Accelerometer_acceleration"), R_world_torso[2] * GRAVITY, atol=0.05)
    weight = nao.mass * GRAVITY
    forces = {name: float(_reading(data, f"{name}_force")[0]) for name in nao.semantics.force_sensors}
    assert sum(forces.values()) == pytest.approx(weight, rel=0.01)
    left = sum(force for name, force in forces.items() if name.startswith("L"))
    assert left == pytest.approx(0.5 * weight, rel=0.05)
    np.testing.assert_allclose(
        nk.rotations.matrix_from_quat(_reading(data, "torso_orientation")), R_world_torso, atol=1e-6
    )
    assert _reading(data, "LKneePitch_position")[0] == pytest.approx(data.joint("LKneePitch").qpos[0], abs=1e-4)
    data.qvel[:] = 0.0
    data.qvel[3:6] = 0.1, -0.2, 0.3  # in the frame of the torso
    data.joint("HeadYaw").qvel[0] = 0.7
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(_reading(data, "Gyrometer_angular_velocity"), (0.1, -0.2, 0.3), atol=1e-12)
    assert _reading(data, "HeadYaw_velocity")[0] == 0.7


@pytest.mark.parametrize(
    ("lean", "pressed"),
    [({"LAnklePitch": -0.1, "RAnklePitch": -0.1}, "Rear"), ({"LAnklePitch": 0.1, "RAnklePitch": 0.1}, "Front")],
)
def test_who_leans_presses_on_the_sensors_there(model: Any, lean: dict[str, float], pressed: str) -> None:
    data, _ = simulate(model, "StandInit", 1.0)
    other = {"Rear": "Front", "Front": "Rear"}[pressed]
    for joint, value in lean.items():
        data.actuator(joint).ctrl += value
    # Turning the feet up presses on the heels at once.
    for _ in range(20):
        mujoco.mj_step(model, data)

    def load(part: str) -> float:
        return sum(
            float(_reading(data, f"{side}Foot/FSR/{part}{s}_force")[0]) for side in "LR" for s in ("Left", "Right")
        )

    assert load(pressed) > load(other)


def test_the_sensors_of_a_foot_share_it_without_a_gap(nao: nk.NaoModel, model: Any) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    foot = model.geom("LAnkleRollShape")
    names = [name for name in nao.semantics.force_sensors if name.startswith("L")]
    for corner in np.array([(x, y) for x in (-1.0, 1.0) for y in (-1.0, 1.0)]):
        point = data.geom("LAnkleRollShape").xpos + foot.size * (*corner, -1.0)
        inside = [
            name for name in names if np.all(np.abs(point - data.site(name).xpos) <= model.site(name).size + 1e-12)
        ]
        x, y = ("Rear", "Front")[int(corner[0] > 0)], ("Right", "Left")[int(corner[1] > 0)]
        assert inside == [f"LFoot/FSR/{x}{y}"]


def test_mink_brings_a_hand_to_its_target(each_nao: nk.NaoModel, tmp_path: Path) -> None:
    mink = pytest.importorskip("mink")
    model = exported(each_nao, tmp_path / "nao", meshes="none", base="fixed")
    configuration = mink.Configuration(model)
    configuration.update_from_keyframe("StandInit")
    q = each_nao.posture("StandInit")
    wanted = each_nao.fk(each_nao.clamp(q + 0.15), "LArm")
    task = mink.FrameTask("LArm", "site", position_cost=1.0, orientation_cost=0.0, lm_damping=1e-6)
    task.set_target(mink.SE3.from_matrix(wanted))
    limits = [mink.ConfigurationLimit(model)]
    equality = mink.EqualityConstraintTask(model, cost=1.0)
    for _ in range(100):
        velocity = mink.solve_ik(configuration, [task, equality], 0.1, "daqp", limits=limits)
        configuration.integrate_inplace(velocity, 0.1)
    T = configuration.get_transform_frame_to_world("LArm", "site").as_matrix()
    np.testing.assert_allclose(T[:3, 3], wanted[:3, 3], atol=1e-4)
    values = {name: float(configuration.data.joint(name).qpos[0]) for name in each_nao.joint_names}
    ours = each_nao.fk(each_nao.configuration(values, limits="ignore"), "LArm")
    np.testing.assert_allclose(T, ours, atol=1e-9)
