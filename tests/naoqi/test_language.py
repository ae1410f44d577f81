"""NAOqi's names, orders, poses, spaces, masks and limits as pure functions."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin import naoqi
from nao_kin.errors import BadArgument, CouplingViolated, NotARotation, NotFinite, UnknownName, WrongShape
from nao_kin.naoqi.conventions import SPACES, frame_of, robot_frame, space_number, torso_in

CASES = json.loads((Path(__file__).parents[1] / "data" / "reference_cases.json").read_text(encoding="utf-8"))

# What a NAO answers to getBodyNames("Body"), as public scripts print it.
BODY = (
    "HeadYaw HeadPitch LShoulderPitch LShoulderRoll LElbowYaw LElbowRoll LWristYaw LHand "
    "LHipYawPitch LHipRoll LHipPitch LKneePitch LAnklePitch LAnkleRoll "
    "RHipYawPitch RHipRoll RHipPitch RKneePitch RAnklePitch RAnkleRoll "
    "RShoulderPitch RShoulderRoll RElbowYaw RElbowRoll RWristYaw RHand"
).split()
LOLA = (
    "HeadYaw HeadPitch LShoulderPitch LShoulderRoll LElbowYaw LElbowRoll LWristYaw "
    "LHipYawPitch LHipRoll LHipPitch LKneePitch LAnklePitch LAnkleRoll "
    "RHipRoll RHipPitch RKneePitch RAnklePitch RAnkleRoll "
    "RShoulderPitch RShoulderRoll RElbowYaw RElbowRoll RWristYaw LHand RHand"
).split()
ACTUATOR_TABLE = (
    "HeadPitch HeadYaw LAnklePitch LAnkleRoll LElbowRoll LElbowYaw LHand LHipPitch LHipRoll LHipYawPitch LKneePitch "
    "LShoulderPitch LShoulderRoll LWristYaw RAnklePitch RAnkleRoll RElbowRoll RElbowYaw RHand RHipPitch RHipRoll "
    "RKneePitch RShoulderPitch RShoulderRoll RWristYaw"
).split()


def _homogeneous(rotation: np.ndarray, place: np.ndarray) -> np.ndarray:
    T = np.zeros((*place.shape[:-1], 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = rotation, place, 1.0
    return T


def _random_pose(rng: np.random.Generator, shape: tuple[int, ...] = ()) -> np.ndarray:
    count = int(np.prod(shape))
    R = Rotation.random(count, random_state=rng).as_matrix().reshape(*shape, 3, 3)
    return _homogeneous(R, rng.uniform(-1.0, 1.0, (*shape, 3)))


# --- names ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("names", "joints"),
    [
        ("Body", BODY),
        ("JointActuators", BODY),
        (("Head", "LArm", "LLeg", "RLeg", "RArm"), BODY),
        ("Joints", [name for name in BODY if not name.endswith("Hand")]),
        ("Actuators", ["LHand", "RHand"]),
        ("LArm", BODY[2:8]),
        ("Legs", BODY[8:20]),
        ("Arms", BODY[2:8] + BODY[20:]),
        (["RHand", "Head", "HeadYaw"], ["RHand", "HeadYaw", "HeadPitch", "HeadYaw"]),
        ([], []),
    ],
)
def test_names_stand_for_their_joints_in_naoqis_order(nao: nk.NaoModel, names: str, joints: list[str]) -> None:
    assert list(naoqi.joint_names(nao, names)) == joints
    assert naoqi.chain_names(nao) == ("Head", "LArm", "LLeg", "RLeg", "RArm")


def test_an_unknown_name_is_answered_with_the_nearest(nao: nk.NaoModel) -> None:
    with pytest.raises(UnknownName, match=r"unknown joint, chain or group 'headyaw' \(nearest: HeadYaw"):
        naoqi.joint_names(nao, "headyaw")
    with pytest.raises(UnknownName, match="nearest: LArm"):
        naoqi.joint_names(nao, ["HeadYaw", "larm"])


def test_a_robot_without_naos_chains_is_refused() -> None:
    robot = nk.RobotModel.from_urdf(nk.load_nao().urdf_path, semantics=nk.semantics.Semantics())
    with pytest.raises(BadArgument, match="has none of NAOqi's chains"):
        naoqi.joint_names(robot, "Body")


def test_angles_repeat_the_shared_hip_and_keep_batches(nao: nk.NaoModel) -> None:
    q = nao.random(3, (2, 3))
    values = naoqi.angles(nao, q)
    assert values.shape == (2, 3, 26)
    assert np.array_equal(values, nao.to_body(q))
    assert np.array_equal(values[..., BODY.index("RHipYawPitch")], values[..., BODY.index("LHipYawPitch")])
    assert naoqi.angles(nao, q, "HeadPitch").shape == (2, 3, 1)
    assert naoqi.angles(nao, q[0, 0], []).shape == (0,)


# --- orders -----------------------------------------------------------------------------------------------------------


def test_orders_are_as_their_sources_have_them() -> None:
    assert list(naoqi.BODY_ORDERS["H25"]) == BODY
    without = {"LWristYaw", "LHand", "RWristYaw", "RHand"}
    assert list(naoqi.BODY_ORDERS["H21"]) == [name for name in BODY if name not in without]
    assert list(naoqi.BODY_ORDERS["LoLA"]) == LOLA
    assert list(naoqi.BODY_ORDERS["jointActuator"]) == ACTUATOR_TABLE


@pytest.mark.parametrize("order", sorted(naoqi.BODY_ORDERS))
def test_values_go_to_an_order_and_come_back(nao: nk.NaoModel, order: str) -> None:
    q = nao.random(5, (4, 2))
    values = naoqi.to_order(nao, q, order)
    names = naoqi.BODY_ORDERS[order]
    assert values.shape == (4, 2, len(names))
    by_name = nao.angles(q) | {"RHipYawPitch": nao.angles(q)["LHipYawPitch"]}
    for column, name in enumerate(names):
        assert np.array_equal(values[..., column], by_name[name])
    known = [column for column, name in enumerate(nao.joint_names) if name in names]
    assert np.array_equal(naoqi.from_order(nao, values, order)[..., known], q[..., known])


def test_joints_that_an_order_lacks_are_zero(nao: nk.NaoModel) -> None:
    q = naoqi.from_order(nao, naoqi.to_order(nao, nao.random(7), "H21"), "H21")
    assert q[nao.joint_names.index("LWristYaw")] == 0.0


def test_hips_that_disagree_are_refused_or_brought_together(nao: nk.NaoModel) -> None:
    values = naoqi.to_order(nao, nao.neutral(), "H25")
    values[BODY.index("LHipYawPitch")], values[BODY.index("RHipYawPitch")] = -0.2, -0.4
    with pytest.raises(CouplingViolated):
        naoqi.from_order(nao, values, "H25")
    hip = nao.joint_names.index("LHipYawPitch")
    for rule, expected in (("left", -0.2), ("right", -0.4), ("average", -0.3)):
        assert naoqi.from_order(nao, values, "H25", hips=rule)[hip] == pytest.approx(expected, abs=1e-15)  # type: ignore[arg-type]


def test_wrong_orders_are_refused(nao: nk.NaoModel) -> None:
    with pytest.raises(UnknownName, match="nearest: LoLA"):
        naoqi.to_order(nao, nao.neutral(), "lola")
    with pytest.raises(WrongShape, match="26"):
        naoqi.from_order(nao, np.zeros(25), "H25")
    with pytest.raises(NotFinite):
        naoqi.from_order(nao, np.full(22, np.nan), "H21")
    with pytest.raises(UnknownName, match="rule for the hips"):
        naoqi.from_order(nao, np.zeros(26), "H25", hips="both")  # type: ignore[arg-type]


# --- poses ------------------------------------------------------------------------------------------------------------


def test_position6d_is_scipys_extrinsic_xyz() -> None:
    T = _random_pose(np.random.default_rng(1), (50,))
    six = naoqi.position6d(T)
    assert np.array_equal(six[:, :3], T[:, :3, 3])
    assert np.abs(six[:, 3:] - Rotation.from_matrix(T[:, :3, :3]).as_euler("xyz")).max() < 1e-12
    assert np.abs(naoqi.pose(six) - T).max() < 1e-14


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("beside", [0.0, 1e-12, 1e-9, 1e-6, 1e-3])
def test_position6d_is_exact_at_and_beside_the_gimbal_corner(sign: float, beside: float) -> None:
    six = np.array([0.1, -0.2, 0.3, 0.7, sign * (0.5 * np.pi - beside), -0.4])
    T = naoqi.pose(six)
    assert np.abs(T[:3, :3] - Rotation.from_euler("xyz", six[3:]).as_matrix()).max() < 1e-15
    assert np.abs(naoqi.pose(naoqi.position6d(T)) - T).max() < 2e-15


@given(st.lists(st.floats(-10.0, 10.0), min_size=6, max_size=6))
@settings(max_examples=50, deadline=None)
def test_poses_survive_both_notations(numbers: list[float]) -> None:
    T = naoqi.pose(numbers)
    assert np.abs(naoqi.pose(naoqi.position6d(T)) - T).max() < 1e-13
    assert np.abs(naoqi.pose_from_list(naoqi.transform_list(T)) - T).max() < 1e-13


def test_transform_lists_go_row_by_row() -> None:
    T = _random_pose(np.random.default_rng(3), (2, 3))
    numbers = naoqi.transform_list(T)
    assert numbers.shape == (2, 3, 16)
    assert numbers[1, 2].tolist() == [value for row in T[1, 2].tolist() for value in row]
    assert np.abs(naoqi.pose_from_list(numbers) - T).max() < 1e-14
    assert np.abs(naoqi.pose_from_list(numbers[..., :12]) - T).max() < 1e-14
    numbers[:] = 0.0
    assert T.any()


def test_rounding_is_taken_out_of_a_transform_list() -> None:
    T = _random_pose(np.random.default_rng(4))
    for rounded in (T.astype(np.float32), T.round(4)):
        R = naoqi.pose_from_list(rounded.reshape(16).tolist())[:3, :3]
        assert np.abs(R.T @ R - np.eye(3)).max() < 1e-14


def test_numbers_that_are_no_pose_are_refused() -> None:
    with pytest.raises(NotARotation, match="transform: not a rotation matrix"):
        naoqi.pose_from_list([1.1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
    with pytest.raises(BadArgument, match="last row"):
        naoqi.pose_from_list([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2])
    with pytest.raises(WrongShape, match="16"):
        naoqi.pose_from_list(np.zeros(15))
    with pytest.raises(WrongShape, match="6"):
        naoqi.pose(np.zeros(5))
    with pytest.raises(NotFinite):
        naoqi.pose([0, 0, 0, 0, 0, np.inf])
    with pytest.raises(NotARotation, match="T: not a rotation matrix at index \\[1\\]"):
        naoqi.position6d(np.stack([np.eye(4), np.diag([1.0, 1.0, -1.0, 1.0])]))


# --- spaces -----------------------------------------------------------------------------------------------------------


def _reported(case: dict) -> dict[str, list[float]]:
    """Effector → Position6D of a case; the solution's joints, rounded, are worth 3e-7 m and rad."""
    pose = case.get("pose", case)
    return (
        {case["effector"]: pose["position6d"]}
        if "position6d" in pose
        else {k: v["position6d"] for k, v in pose.items()}
    )


@pytest.mark.parametrize("case", CASES["ik_targets"], ids=lambda case: case["id"])
def test_get_position_agrees_with_what_naoqi_reported(nao: nk.NaoModel, case: dict) -> None:
    q = nao.configuration(case["one_solution_rad"], limits="ignore")
    for effector, six in _reported(case).items():
        found = naoqi.position6d(naoqi.pose_in(nao, q, effector, naoqi.FRAME_TORSO))
        assert np.abs(found[:3] - six[:3]).max() < case["tolerance"]["position_m"] + 3e-7
        apart = Rotation.from_euler("xyz", found[3:]).inv() * Rotation.from_euler("xyz", six[3:])
        assert apart.magnitude() < case["tolerance"]["rotation_rad"] + 3e-7


@pytest.mark.parametrize("name", ["Head", "LArm", "RLeg", "Torso", "LElbowRoll", "RHipYawPitch", "CameraTop"])
def test_in_the_torso_poses_are_those_of_forward_kinematics(nao: nk.NaoModel, name: str) -> None:
    q = nao.random(11, 5)
    assert np.array_equal(naoqi.pose_in(nao, q, name), nao.fk(q, name))


def test_sensors_go_by_their_short_names(nao: nk.NaoModel) -> None:
    q = nao.random(12)
    assert np.array_equal(naoqi.pose_in(nao, q, "LFsrFL"), nao.fk(q, "LFoot/FSR/FrontLeft"))
    assert np.array_equal(naoqi.pose_in(nao, q, "HeadTouchFront"), nao.fk(q, "Head/Touch/Front"))
    with pytest.raises(UnknownName, match=r"unknown effector, joint or sensor 'cameratop' \(nearest: CameraTop"):
        frame_of(nao, "cameratop")


def _frame_by_hand(T_world_left: np.ndarray, T_world_right: np.ndarray) -> np.ndarray:
    left, right = (np.arctan2(T[1, 0], T[0, 0]) for T in (T_world_left, T_world_right))
    yaw = np.arctan2(np.sin(left) + np.sin(right), np.cos(left) + np.cos(right))
    place = 0.5 * (T_world_left[:3, 3] + T_world_right[:3, 3])
    place[2] = min(T_world_left[2, 3], T_world_right[2, 3])
    return _homogeneous(Rotation.from_euler("z", yaw).as_matrix(), place)


def test_frame_robot_is_between_the_feet_with_their_mean_yaw(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(13)
    q, T = nao.random(rng, 20), _random_pose(rng, (20,))
    found = robot_frame(nao, q, torso_in_world=T)
    for i in range(20):
        expected = _frame_by_hand(T[i] @ nao.fk(q[i], "LLeg"), T[i] @ nao.fk(q[i], "RLeg"))
        assert np.abs(found[i] - expected).max() < 1e-12


def test_frame_robot_is_level_below_a_level_torso_and_keeps_its_height(nao: nk.NaoModel) -> None:
    stand = nao.posture("StandInit")
    six = naoqi.position6d(naoqi.pose_in(nao, stand, "Torso", naoqi.FRAME_ROBOT))
    assert np.abs(six[[1, 3, 4, 5]]).max() < 1e-9
    assert six[2] == pytest.approx(-nao.fk(stand, "LLeg")[2, 3], abs=1e-12)
    for foot in ("LLeg", "RLeg"):
        assert abs(naoqi.pose_in(nao, stand, foot, naoqi.FRAME_ROBOT)[2, 3]) < 1e-12


def test_the_mean_yaw_is_taken_along_the_shorter_arc(nao: nk.NaoModel) -> None:
    q = nao.configuration({"LHipYawPitch": -0.5})
    apart = 0.5 * np.diff(naoqi.position6d(nao.fk(q, ["LLeg", "RLeg"]))[:, 5])[0]
    assert abs(apart) > 0.1
    for yaw in (3.1, np.pi, -3.1, 0.0):
        T = _homogeneous(Rotation.from_euler("z", yaw).as_matrix(), np.zeros(3))
        R = robot_frame(nao, q, torso_in_world=T)[:3, :3]
        assert np.abs(R - T[:3, :3]).max() < 1e-12


def test_the_spaces_fit_together(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(14)
    q, T = nao.random(rng, (2, 3)), _random_pose(rng, (2, 3))
    in_torso, in_world, in_robot = (naoqi.pose_in(nao, q, "RArm", s, torso_in_world=T) for s in range(3))
    assert np.abs(T @ in_torso - in_world).max() < 1e-12
    assert np.abs(robot_frame(nao, q, torso_in_world=T) @ in_robot - in_world).max() < 1e-12
    for space in range(3):
        T_space_torso = torso_in(nao, q, space, torso_in_world=T)
        assert np.abs(T_space_torso @ in_torso - (in_torso, in_world, in_robot)[space]).max() < 1e-12


def test_a_floating_base_says_where_the_torso_is() -> None:
    floating, fixed = nk.load_nao(base="floating"), nk.load_nao()
    q = floating.posture("Stand")
    q[:3] = 0.3, -0.2, 0.4
    q[3:7] = Rotation.from_euler("xyz", [0.1, 0.2, 0.3]).as_quat()
    T = floating.fk(q, "Torso")
    for space in range(3):
        found = naoqi.pose_in(floating, q, "LArm", space)
        assert np.abs(found - naoqi.pose_in(fixed, q[7:], "LArm", space, torso_in_world=T)).max() < 1e-12


def test_spaces_go_by_number_or_name() -> None:
    assert [space_number(name) for name in SPACES] == [0, 1, 2]
    assert space_number(2.0) == space_number(np.int64(2)) == naoqi.FRAME_ROBOT  # type: ignore[arg-type]
    for wrong in (3, -1, 1.5, None, [0]):
        with pytest.raises(BadArgument, match="FRAME_ROBOT 2"):
            space_number(wrong)  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="nearest: FRAME_ROBOT"):
        space_number("frame_robot")


def test_a_torso_that_is_no_pose_is_refused(nao: nk.NaoModel) -> None:
    with pytest.raises(NotARotation):
        robot_frame(nao, nao.neutral(), torso_in_world=2.0 * np.eye(4) - np.diag([0, 0, 0, 1.0]))


# --- masks and limits -------------------------------------------------------------------------------------------------


def test_masks_are_sums_of_their_bits() -> None:
    assert naoqi.AxisMask.VEL == 1 + 2 + 4
    assert naoqi.AxisMask.ROT == 8 + 16 + 32
    assert naoqi.AxisMask.PLANEZ == 4 + 8 + 16
    assert naoqi.AxisMask.WYWZ == 16 + 32
    assert naoqi.axis_mask("AXIS_MASK_ALL") == naoqi.axis_mask(naoqi.AxisMask.ALL) == naoqi.axis_mask(63.0) == 63  # type: ignore[arg-type]
    assert naoqi.controlled_axes("XY").tolist() == [True, True, False, False, False, False]
    assert naoqi.controlled_axes(12).tolist() == [False, False, True, True, False, False]


def test_wrong_masks_are_refused() -> None:
    for wrong in (-1, 64, 7.5, None):
        with pytest.raises(BadArgument, match="0 to 63"):
            naoqi.axis_mask(wrong)  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="nearest: VEL"):
        naoqi.axis_mask("vel")


@pytest.mark.parametrize("version", ["v6", "v3.2"])
def test_limits_are_those_of_the_robot(version: str) -> None:
    robot = nk.load_nao(version)
    rows = naoqi.limits(robot)
    assert rows.shape == (26, 4)
    for name, row in zip(BODY, rows, strict=True):
        own = robot.joint_names.index("LHipYawPitch" if name == "RHipYawPitch" else name)
        numbers = robot.lower, robot.upper, robot.velocity_limits, robot.effort_limits
        assert row.tolist() == [array[own] for array in numbers]


def test_limits_of_the_head_yaw_are_written_out(nao: nk.NaoModel) -> None:
    assert naoqi.limits(nao, "HeadYaw") == pytest.approx(np.array([[-2.0857, 2.0857, 8.26797, 1.547]]), abs=5e-5)
    assert naoqi.limits(nao, []).shape == (0, 4)
