"""Mirror images of configurations."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from made_up_robots import J, made_up

import nao_kin as nk

MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])


@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("version", ["v3.2", "v4", "v6"])
def test_everything_that_stands_in_a_mirror_is_on_the_other_side(
    version: str, base: Literal["fixed", "floating"]
) -> None:
    nao = nk.load_nao(version, base=base)
    rng = np.random.default_rng(0)
    q = nao.random(rng=rng, n=20).reshape(4, 5, -1)
    q[0, 0, nao.nq_base :] = nao.lower
    q[0, 1, nao.nq_base :] = nao.upper
    if base == "floating":
        q[..., :3] = rng.normal(size=(4, 5, 3))
    image = nao.mirror(q)
    reference = None if base == "fixed" else "world"
    for frame in ("Head", "LArm", "RArm", "LLeg", "RLeg", "Torso"):
        other = {"L": "R", "R": "L"}.get(frame[0], frame[0]) + frame[1:]
        T = nao.fk(q, frame, reference=reference)
        assert np.allclose(nao.fk(image, other, reference=reference), MIRROR @ T @ MIRROR, rtol=0.0, atol=1e-12), frame
    assert np.allclose(nao.com(image), nao.com(q) * (1.0, -1.0, 1.0), rtol=0.0, atol=2e-3)
    assert np.allclose(nao.mirror(image), q, rtol=0.0, atol=1e-15)


def test_the_mirror_image_of_a_configuration_is_that_of_a_motion_with_one_key() -> None:
    nao = nk.load_nao()
    for name in nao.posture_names:
        q = nao.posture(name)
        motion = nk.Motion([0.0], nao.joint_names, q[None])
        assert np.array_equal(nao.mirror(q), nk.motion.mirror(nao, motion).configurations(nao).q[0])


def test_what_is_no_configuration_is_refused() -> None:
    nao = nk.load_nao()
    with pytest.raises(nk.errors.WrongShape):
        nao.mirror(np.zeros(24))
    with pytest.raises(nk.errors.NotFinite, match="HeadYaw"):
        nao.mirror(np.full(25, np.nan))


def test_a_calibrated_robot_is_mirrored_by_its_reported_values() -> None:
    nao = nk.load_nao()
    rng = np.random.default_rng(1)
    offsets = {name: float(value) for name, value in zip(nao.joint_names, rng.normal(0.0, 0.01, 25), strict=True)}
    hands = ("LHand", "RHand")
    calibrated = nao.with_offsets(joints={name: value for name, value in offsets.items() if name not in hands})
    for name in nao.posture_names:
        assert np.array_equal(calibrated.mirror(nao.posture(name)), nao.mirror(nao.posture(name)))


def _robot(name: str) -> nk.RobotModel:
    try:
        return nk.load_robot(name)
    except nk.errors.MissingExtra:
        pytest.skip("example-robot-data is not installed")


PAIRS = {
    "solo": [("FL_FOOT", "FR_FOOT"), ("HL_FOOT", "HR_FOOT")],  # all its axes are along y
    "go1": [("FL_foot", "FR_foot"), ("RL_foot", "RR_foot")],
    "anymal": [("LF_FOOT", "RF_FOOT"), ("LH_FOOT", "RH_FOOT")],
    "hyq_no_sensors": [("lf_foot", "rf_foot"), ("lh_foot", "rh_foot")],
    "talos_reduced": [("left_sole_link", "right_sole_link"), ("arm_left_7_link", "arm_right_7_link")],
    "simple_humanoid": [("l_wrist", "r_wrist"), ("l_ankle", "r_ankle")],  # LLEG_HIP_R is a roll
    "pr2": [("l_gripper_l_finger_tip_link", "r_gripper_r_finger_tip_link"), ("base_link", "base_link")],
    "z1": [("link06", "link06")],
}


@pytest.mark.parametrize("name", PAIRS)
def test_the_links_of_other_robots_are_on_the_other_side_too(name: str) -> None:
    robot = _robot(name)
    q = robot.random(1, 20)
    image = robot.mirror(q)
    for one, other in PAIRS[name]:
        for a, b in ((one, other), (other, one)):
            apart = robot.position(image, b) - robot.position(q, a) * (1.0, -1.0, 1.0)
            assert np.abs(apart).max() < 1e-9, (a, b)
    assert np.array_equal(robot.mirror(image), q)


@pytest.mark.parametrize(
    ("name", "joint", "reason"),
    [
        ("finger_edu", "finger_upper_to_middle_joint", "is not its own mirror image"),  # beside the plane, axis along y
        ("ur5_robot", "shoulder_lift_joint", "shows no side"),
        ("human", "left_hip_Z", "left_hip_Z and right_hip_Z are not mirror images"),  # its left is at z > 0
        ("borinot_flying_arm_2", "flying_arm_2__j_bl_link1", "which is not its own mirror image"),
        ("talos_left_arm", "arm_left_2_joint", "arm_right_2_joint"),
        ("alex_sake_hands", "Left_GRIPPER_X1", "Right_GRIPPER_X1 are not mirror images"),
    ],
)
def test_joints_that_are_no_mirror_images_are_refused(name: str, joint: str, reason: str) -> None:
    robot = _robot(name)
    for call in (lambda: robot.mirror(robot.neutral()), lambda: robot.mirror_image(joint)):
        with pytest.raises((nk.errors.BadArgument, nk.errors.UnknownName), match=joint) as caught:
            call()
        assert reason in str(caught.value)


def test_the_origin_of_a_joint_may_be_anywhere_on_its_axis(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("l_yaw", axis=(0.0, 0.0, 1.0), xyz=(0.0, 0.1, 0.0), parent="base"),
        J("l_roll", axis=(1.0, 0.0, 0.0), xyz=(0.1, 0.0, 0.0), parent="l_yaw"),
        J("r_yaw", axis=(0.0, 0.0, 1.0), xyz=(0.0, -0.1, 0.3), parent="base"),
        J("r_roll", axis=(1.0, 0.0, 0.0), xyz=(0.1, 0.0, -0.3), parent="r_yaw"),
    )
    q = robot.random(0)
    l_roll, r_roll = robot.position(q, "l_roll"), robot.position(robot.mirror(q), "r_roll")
    assert r_roll == pytest.approx(l_roll * (1.0, -1.0, 1.0), abs=1e-12)


def test_a_joint_that_moves_what_has_no_mirror_image_has_none_either(tmp_path: Path) -> None:
    # At zero all axes are mirror images; when the trunk is turned they are not.
    robot = made_up(
        tmp_path,
        J("trunk", axis=(0.0, 0.0, 1.0), xyz=(0.3, 0.1, 0.0), parent="base"),
        J("l_arm", axis=(0.0, 1.0, 0.0), xyz=(0.0, 0.2, 0.0), parent="trunk"),
        J("r_arm", axis=(0.0, 1.0, 0.0), xyz=(0.0, -0.4, 0.0), parent="trunk"),
    )
    for name in robot.joint_names:
        with pytest.raises(nk.errors.BadArgument, match=f"{name} .*mirror image"):
            robot.mirror_image(name)


@pytest.mark.parametrize(("multiplier", "offset", "fits"), [(-1.0, 0.0, True), (-2.0, 0.0, False), (-1.0, 0.1, False)])
def test_a_mimic_joint_that_does_not_follow_as_the_mirror_image_is_refused(
    multiplier: float, offset: float, fits: bool, tmp_path: Path
) -> None:
    def joint(side: str, y: float, mimic: str = "") -> str:
        return (
            f'<link name="{side}"/><joint name="{side}J" type="revolute"><parent link="b"/><child link="{side}"/>'
            f'<origin xyz="0 {y} 0"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>'
            f"{mimic}</joint>"
        )

    follows = f'<mimic joint="LJ" multiplier="{multiplier}" offset="{offset}"/>'
    path = tmp_path / "r.urdf"
    path.write_text(f'<robot name="r"><link name="b"/>{joint("L", 0.1)}{joint("R", -0.1, follows)}</robot>')
    robot = nk.RobotModel.from_urdf(path)
    if fits:
        assert robot.mirror([0.3]).tolist() == [0.3]
        assert robot.mirror_image("RJ") == nk.semantics.Mimic("LJ", -1.0)
        return
    for call in (lambda: robot.mirror([0.3]), lambda: robot.mirror_image("RJ"), lambda: robot.mirror_image("LJ")):
        with pytest.raises(
            nk.errors.BadArgument,
            match=r"no mirror image: RJ = (-2 LJ \+0|-1 LJ \+0.1) of the mimic joint would not hold in it",
        ):
            call()
