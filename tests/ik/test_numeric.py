"""Numerical inverse kinematics: random reachable poses, limits, reasons, derivatives and bad input."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from ik_checks import derivatives
from loops import for_all
from made_up_robots import J, made_up
from scipy.optimize import least_squares
from scipy.spatial import cKDTree

import nao_kin as nk
from nao_kin._core.arrays import Floats
from nao_kin.errors import BadArgument, NotARotation, NotFinite, UnknownName, WrongShape
from nao_kin.ik import Family, Reason, numeric
from nao_kin.ik.least_squares import FrameMotion, Goal, errors_at, new_scratch
from nao_kin.ik.limit_regions import LimitRegion
from nao_kin.ik.targets import rigid_poses
from nao_kin.robot.semantics import CoupledLimit, Semantics

FRAMES = ("Head", "LArm", "RArm", "LLeg", "RLeg", "CameraTop", "LFoot")
COUNT = 200


def check_reached(
    robot: nk.RobotModel, frame: str, T: np.ndarray, found: nk.ik.IKResult, tolerance: float = 1e-8
) -> None:
    """Every target is met by Pinocchio's pose, inside the limits, and only joints on the way have moved."""
    assert found.success.all(), found.notes  # type: ignore[union-attr]
    assert robot.within_limits(found.q).all()
    data = robot.model.createData()
    frame_id = robot.frame_table[frame]
    for q, target in zip(found.q.reshape(-1, robot.nq), T.reshape(-1, 4, 4), strict=True):
        pin.forwardKinematics(robot.model, data, q)
        error = pin.updateFramePlacement(robot.model, data, frame_id).inverse() * pin.SE3(target)
        assert np.linalg.norm(error.translation) <= 1.01 * tolerance
        assert np.linalg.norm(pin.log3(error.rotation)) <= 1.01 * tolerance
    still = np.ones(robot.nq, dtype=bool)
    still[list(found.columns)] = False
    np.testing.assert_array_equal(found.q[..., still], found.near[..., still])


# --- reachable poses ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("frame", FRAMES)
def test_random_reachable_poses_of_every_limb_are_met(nao: nk.NaoModel, frame: str) -> None:
    T = nao.fk(nao.random(11, COUNT), frame)
    found = numeric(nao, frame, T, near=nao.posture("StandInit"))
    check_reached(nao, frame, T, found)
    assert (found.reason == Reason.REACHED).all()
    assert found.solutions.shape == (COUNT, 1, 25)
    assert not found.families.any()


@pytest.mark.parametrize(
    ("name", "frame"), [("romeo", "l_wrist"), ("romeo", "r_sole"), ("panda", "panda_link8"), ("ur5_robot", "tool0")]
)
def test_random_reachable_poses_of_other_robots_are_met(name: str, frame: str) -> None:
    robot = nk.load_robot(name)
    T = robot.fk(robot.random(5, COUNT), frame)
    found = numeric(robot, frame, T)
    check_reached(robot, frame, T, found)
    assert any("restarts" in note for note in found.notes)
    redundant = len(found.joints) > 6
    assert (found.family == (Family.REDUNDANT if redundant else Family.NONE)).all()


@pytest.mark.parametrize("frame", ["Head", "RArm", "LLeg"])
def test_poses_at_the_edges_of_limits_are_met(nao: nk.NaoModel, frame: str) -> None:
    rng = np.random.default_rng(2)
    T = nao.fk(nao.clamp(nao.random(rng, COUNT) + rng.normal(size=(COUNT, 25))), frame)
    check_reached(nao, frame, T, numeric(nao, frame, T))


@pytest.mark.parametrize("knee", [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3])
def test_poses_of_straight_legs_are_met(nao: nk.NaoModel, knee: float) -> None:
    q = nao.random(2, 50)
    q[:, nao.joint_names.index("LKneePitch")] = knee
    T = nao.fk(q, "LLeg")
    check_reached(nao, "LLeg", T, numeric(nao, "LLeg", T))


def test_from_a_reference_nearby_the_nearby_solution_is_found(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit") + np.random.default_rng(0).uniform(-0.05, 0.05, (50, 25))
    for frame in ("LArm", "RLeg"):
        T = nao.fk(q, frame)
        found = numeric(nao, frame, T, near=nao.posture("StandInit"), tolerance=1e-12)
        check_reached(nao, frame, T, found, 1e-12)
        np.testing.assert_allclose(found.q[:, list(found.columns)], q[:, list(found.columns)], atol=1e-9)


def test_a_floating_base_stays_where_the_reference_has_it() -> None:
    nao = nk.load_nao("v6", base="floating")
    rng = np.random.default_rng(3)
    reference = nao.random(rng)
    reference[:7] = [
        0.3,
        -0.2,
        0.5,
        *nk.rotations.quat_to_xyzw(nk.rotations.quat_from_matrix(nk.rotations.exp([0.2, 1, -0.4]))),
    ]
    reached = nao.random(rng, 30)
    reached[:, :7] = reference[:7]
    T = nao.fk(reached, "LLeg")
    check_reached(nao, "LLeg", T, numeric(nao, "LLeg", T, near=reference))
    far = T[0].copy()
    far[:3, 3] += 1.0
    assert numeric(nao, "LLeg", far, near=reference).reason is Reason.OUT_OF_REACH


def test_followers_sliders_and_joints_without_limits_are_solved(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("turn", kind="continuous"),
        J("slide", axis=(0.0, 0.0, 1.0), kind="prismatic", limits=(-0.2, 0.4)),
        J("bend", axis=(0.0, 1.0, 0.0), xyz=(0.1, 0.0, 0.0)),
        J("half", axis=(0.0, 1.0, 0.0), xyz=(0.3, 0.0, 0.0), follows=("bend", 0.5, 0.2)),
        J("roll", axis=(1.0, 0.0, 0.0), xyz=(0.2, 0.0, 0.0)),
        J("yaw", axis=(0.0, 0.0, 1.0), xyz=(0.1, 0.0, 0.0)),
    )
    q = robot.random(2, COUNT)
    T = robot.fk(q, "yaw_l")
    found = numeric(robot, "yaw_l", T)
    check_reached(robot, "yaw_l", T, found)
    turn = robot.joint_names.index("turn")
    assert (np.abs(found.q[:, turn]) <= np.pi).all()
    wound = robot.neutral()
    wound[turn] = 20.0
    found = numeric(robot, "yaw_l", T, near=wound)
    assert (np.abs(found.q[:, turn] - 20.0) <= np.pi + 1e-12).all()


def test_without_limits_joints_may_leave_their_ranges_and_stay_within_half_a_turn(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(9)
    q = np.zeros((100, 25))
    q[:] = rng.uniform(-2.5, 2.5, q.shape)
    T = nao.fk(q, "LLeg")
    found = numeric(nao, "LLeg", T, limits="ignore")
    assert found.success.all()  # type: ignore[union-attr]
    np.testing.assert_allclose(nao.fk(found.q, "LLeg"), T, atol=3e-8)
    assert not nao.within_limits(found.q).all()
    # The hip that drives the other one cannot take back whole turns; here it is the same, for it follows 1 : 1.
    assert (np.abs(found.q) <= 2 * np.pi).all()


def pose_errors(poses: np.ndarray, targets: np.ndarray) -> np.ndarray:
    R = targets[:, :3, :3]
    away = np.einsum("nji,nj->ni", R, targets[:, :3, 3] - poses[:, :3, 3])
    return np.concatenate([away, nk.rotations.log(poses[:, :3, :3].swapaxes(-1, -2) @ R)], axis=-1)


# --- weights --------------------------------------------------------------------------------------------------------


@for_all(
    "name, frame", [("v6", "LArm"), ("v4", "LLeg"), ("v6", "CameraTop"), ("romeo", "r_wrist"), ("ur5_robot", "tool0")]
)
@for_all("base", ["fixed", "floating"])
def test_positions_are_met_by_pinocchio_with_any_orientation(name: str, frame: str, base: str) -> None:
    robot = nk.load_nao(name, base=base) if name[0] == "v" else nk.load_robot(name, base=base)
    rng = np.random.default_rng(3)
    near = robot.random(rng, (4, 5))
    if base == "floating":
        near[..., :3] = rng.normal(size=3)
        near[..., 3:7] = nk.rotations.quat_to_xyzw(nk.rotations.quat_from_matrix(nk.rotations.random_rotation(rng)))
    q = robot.random(rng, (4, 5))
    q[..., : robot.nq_base] = near[..., : robot.nq_base]
    p = robot.position(q, frame)
    found = numeric(robot, frame, p, near=near)
    assert found.success.all(), found.notes  # type: ignore[union-attr]
    assert robot.within_limits(found.q).all()
    data = robot.model.createData()
    for row, target in zip(found.q.reshape(-1, robot.nq), p.reshape(-1, 3), strict=True):
        pin.forwardKinematics(robot.model, data, row)
        pose = pin.updateFramePlacement(robot.model, data, robot.frame_table[frame])
        assert np.linalg.norm(pose.translation - target) <= 1.01e-8
    np.testing.assert_array_equal(found.residual[..., 1], 0.0)
    one = numeric(robot, frame, p[1, 2].tolist(), near=near[1, 2])
    assert one.q.shape == (robot.nq,)
    np.testing.assert_allclose(one.q, found.q[1, 2], rtol=0, atol=1e-9)


def test_a_position_is_a_pose_whose_rotation_has_no_weight(nao: nk.NaoModel) -> None:
    T = np.tile(np.eye(4), (40, 1, 1))
    T[:, :3, 3] = nao.position(nao.random(1, 40), "LArm") * np.linspace(0.5, 1.5, 40)[:, None]
    weights = np.array([1.0, 2.0, 0.0, 0.3, 0.2, 0.1])
    for given, same in (((1.0, 0.1), (1.0, 0.0)), (weights, [*weights[:3], 0.0, 0.0, 0.0])):
        positions = numeric(nao, "LArm", T[:, :3, 3], weights=given, restarts=2)
        poses = numeric(nao, "LArm", T, weights=same, restarts=2)
        np.testing.assert_array_equal(positions.q, poses.q)
        np.testing.assert_array_equal(positions.reasons, poses.reasons)
        assert 0 < np.count_nonzero(positions.success) < 40
    np.testing.assert_array_equal(weights, [1.0, 2.0, 0.0, 0.3, 0.2, 0.1])
    assert numeric(nao, "LArm", np.eye(3)).q.shape == (3, 25)


def test_a_position_beyond_reach_or_joints_has_the_nearest_one(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(0)
    places = nao.position(nao.random(rng, 20), "CameraTop") + rng.normal(size=(20, 3)) * 0.05
    found = numeric(nao, "CameraTop", places)
    assert set(found.reasons.tolist()) <= {Reason.NOT_ENOUGH_JOINTS, Reason.OUT_OF_REACH}
    assert nao.within_limits(found.q).all()
    np.testing.assert_array_equal(found.residual[:, 1], 0.0)
    distances = np.linalg.norm(nao.position(found.q, "CameraTop") - places, axis=-1)
    np.testing.assert_allclose(found.residual[:, 0], distances, rtol=0, atol=1e-12)
    drawn, _ = cKDTree(nao.position(nao.random(rng, 200_000), "CameraTop")).query(places)
    assert (distances <= drawn).all()
    assert np.median(drawn - distances) < 1e-4


def test_six_weights_are_along_the_axes_of_the_target(nao: nk.NaoModel) -> None:
    # A hand whose x axis is given, turned about it by anything.
    T = nao.fk(nao.random(1, 50), "LArm")
    T[:, :3, :3] = T[:, :3, :3] @ nk.rotations.rot_x(np.linspace(-3.0, 3.0, 50))
    found = numeric(nao, "LArm", T, weights=(1.0, 1.0, 1.0, 0.0, 0.1, 0.1), tolerance=1e-10)
    assert found.success.all()  # type: ignore[union-attr]
    assert nao.within_limits(found.q).all()
    poses = nao.fk(found.q, "LArm")
    np.testing.assert_allclose(poses[:, :3, 3], T[:, :3, 3], atol=1e-9)
    left = nk.rotations.log(poses[:, :3, :3].swapaxes(-1, -2) @ T[:, :3, :3])
    np.testing.assert_allclose(left[:, 1:], 0.0, atol=1e-9)
    assert np.abs(left[:, 0]).max() > 0.5


# --- what is not met ------------------------------------------------------------------------------------------------


def test_a_lower_bound_is_not_called_a_distance(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("x", kind="prismatic", axis=(1.0, 0.0, 0.0), limits=(-1.0, 1.0)),
        J("y", kind="prismatic", axis=(0.0, 1.0, 0.0), limits=(-1.0, 1.0)),
        J("turn", axis=(0.0, 0.0, 1.0)),
        J("tip", axis=(0.0, 0.0, 1.0), xyz=(2.0, 0.0, 0.0)),
    )
    target = np.array([9.0, 9.0, 9.0])
    found = numeric(robot, "tip_l", target)
    assert found.reason is Reason.OUT_OF_REACH
    away = float(np.linalg.norm(robot.position(found.q, "tip_l") - target))
    assert float(found.obstacles.needed) < away - 1.0
    assert [float(n) for n in re.findall(r"[0-9.]+", str(found.message))] == [pytest.approx(away, abs=5e-3)]


def test_a_target_beyond_the_stretched_leg_says_how_far(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.neutral(), "LLeg")
    T[2, 3] -= 0.05
    found = numeric(nao, "LLeg", T)
    assert found.success is False
    assert found.reason is Reason.OUT_OF_REACH
    assert float(found.obstacles.needed) == pytest.approx(0.05, abs=1e-9)
    assert found.message == "out of reach; the nearest pose is off by 50 mm"
    assert found.residual[0] == pytest.approx(0.05, abs=1e-3)
    assert nao.within_limits(found.q)


@for_all(("joint", "frame", "side"), [("LKneePitch", "LLeg", 1.0), ("LElbowRoll", "LArm", -1.0)])
def test_a_target_that_needs_a_joint_outside_its_range_names_it(
    nao: nk.NaoModel, joint: str, frame: str, side: float
) -> None:
    q, column = nao.posture("StandInit"), nao.joint_names.index(joint)
    limit = (nao.upper if side > 0.0 else nao.lower)[column]
    q[column] = limit + 0.1 * side
    found = numeric(nao, frame, nao.fk(q, frame), near=nao.posture("Crouch"))
    assert found.success is False
    assert found.reason is Reason.JOINT_LIMIT
    assert found.joints[int(found.obstacles.joint)] == joint
    assert float(found.obstacles.needed) == pytest.approx(q[column], abs=1e-6)
    assert float(found.obstacles.limit) == limit
    assert nao.within_limits(found.q)
    assert str(found.message).startswith(f"{joint} needs {q[column]:.3g} rad, limit {limit:.3g};")


def test_a_target_that_only_a_coupled_limit_forbids_says_so(nao: nk.NaoModel) -> None:
    yaw, pitch = (nao.joint_names.index(name) for name in ("HeadYaw", "HeadPitch"))
    q = nao.neutral()
    q[yaw], q[pitch] = 1.5, 0.4
    assert (q >= nao.lower)[[yaw, pitch]].all()
    assert (q <= nao.upper)[[yaw, pitch]].all()
    found = numeric(nao, "Head", nao.fk(q, "Head"))
    assert found.reason is Reason.COUPLED_LIMIT
    assert found.joints[int(found.obstacles.joint)] == "HeadPitch"
    assert float(found.obstacles.needed) == pytest.approx(0.4, abs=1e-6)
    (table,) = (table for table in nao.coupled_limits if table.joint == "HeadPitch")
    assert float(found.obstacles.limit) == pytest.approx(float(np.interp(1.5, table.at, table.upper)), abs=1e-6)
    assert nao.within_limits(found.q)


def test_the_nearest_pose_is_a_minimum_no_step_inside_the_limits_improves(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(8)
    T = nao.fk(nao.random(rng, 20), "LArm")
    T[:, :3, :3] = T[:, :3, :3] @ nk.rotations.exp(rng.normal(size=(20, 3)))
    found = numeric(nao, "LArm", T, restarts=4)
    lost = np.flatnonzero(~np.asarray(found.success))
    assert lost.size > 15
    motion = FrameMotion(nao, "LArm")
    weights = np.repeat([1.0, 0.1], 3)
    low, high = nao.lower[motion.joints], nao.upper[motion.joints]
    for k in lost:

        def cost(values: np.ndarray, k: int = k) -> np.ndarray:
            q = np.tile(found.q[k], (*values.shape[:-1], 1))
            q[..., motion.columns] = values
            errors = pose_errors(nao.fk(q, "LArm").reshape(-1, 4, 4), T[k : k + 1])
            return (weights * errors).reshape(*values.shape[:-1], 6)

        best = found.best[k]
        ours = 0.5 * float(np.square(cost(best)).sum())
        scipys = least_squares(
            cost, np.clip(best, low + 1e-9, high - 1e-9), derivatives(cost), bounds=(low, high), xtol=1e-12, ftol=1e-12
        )
        assert ours <= float(scipys.cost) * (1.0 + 1e-6) + 1e-15


@pytest.mark.full
@pytest.mark.parametrize(("name", "frame"), [("kinova", "j2s6s200_link_5"), ("nao", "LArm"), ("nao", "LLeg")])
def test_beyond_the_stretched_limb_no_search_of_scipy_ends_nearer(nao: nk.NaoModel, name: str, frame: str) -> None:
    robot = nao if name == "nao" else nk.load_robot(name)
    motion, rng = FrameMotion(robot, frame), np.random.default_rng(8)
    T = robot.fk(robot.random(rng, 8), frame)
    centre = motion.chain.links[3:12:4]
    outwards = T[:, :3, 3] - centre
    T[:, :3, 3] = centre + outwards * ((motion.length + 0.05) / np.linalg.norm(outwards, axis=-1))[:, None]
    found = numeric(robot, frame, T)
    assert (found.reasons == Reason.OUT_OF_REACH).all()
    weights = np.repeat([1.0, 0.1], 3)
    low, high = np.maximum(robot.lower, -np.pi)[motion.joints], np.minimum(robot.upper, np.pi)[motion.joints]
    for k in range(8):

        def cost(values: np.ndarray, k: int = k) -> np.ndarray:
            q = np.tile(found.q[k], (*values.shape[:-1], 1))
            q[..., motion.columns] = values
            errors = pose_errors(robot.fk(q, frame).reshape(-1, 4, 4), T[k : k + 1])
            return (weights * errors).reshape(*values.shape[:-1], 6)

        for start in rng.uniform(low, high, (8, len(low))):
            other, q = least_squares(cost, start, derivatives(cost), bounds=(low, high)), found.q[k].copy()
            q[motion.columns] = other.x
            if robot.within_limits(q):  # coupled ones are unknown to SciPy
                assert 0.5 * np.square(cost(found.best[k])).sum() <= other.cost * (1.0 + 1e-6)


def test_a_joint_without_limits_is_no_obstacle_and_no_warning(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("turn", kind="continuous"), J("bend", axis=(0.0, 1.0, 0.0), limits=(-0.5, 0.5)))
    q = np.array([0.3, 1.2])
    found = numeric(robot, "bend_l", robot.fk(q, "bend_l"))
    assert found.reason is Reason.JOINT_LIMIT
    assert found.joints[int(found.obstacles.joint)] == "bend"


def test_in_a_batch_some_targets_are_met_and_others_say_why(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.random(3, 6), "RLeg")
    T[2, :3, 3] *= 3.0
    T[4, :3, 3] *= 1e3
    found = numeric(nao, "RLeg", T)
    np.testing.assert_array_equal(found.success, [True, True, False, True, False, True])
    assert found.reasons[4] == Reason.OUT_OF_REACH
    assert "out of reach" in found.describe((4,))
    np.testing.assert_array_equal(np.isnan(found.solutions[:, 0, 0]), ~np.asarray(found.success))
    assert np.isfinite(found.q).all()


def test_restarts_never_end_farther_away_and_often_nearer(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(8)
    T = nao.fk(nao.random(rng, 40), "LArm")
    T[:, :3, :3] = T[:, :3, :3] @ nk.rotations.exp(rng.normal(size=(40, 3)))
    once, often = (numeric(nao, "LArm", T, restarts=restarts) for restarts in (0, 10))
    lost = ~np.asarray(often.success)
    costs = [np.square(found.residual[lost] * [1.0, 0.1]).sum(axis=-1) for found in (once, often)]
    assert (costs[1] <= costs[0] * (1.0 + 1e-9)).all()
    assert (costs[1] < 0.9 * costs[0]).any()


def test_success_without_restarts_is_success(nao: nk.NaoModel) -> None:
    # Some of these are met only by the search without limits, which ends inside them.
    T = nao.fk(nao.random(1, 400), "LLeg")
    found = numeric(nao, "LLeg", T, restarts=0)
    met = np.asarray(found.success)
    assert 200 < met.sum() < 400
    np.testing.assert_allclose(nao.fk(found.q[met], "LLeg"), T[met], atol=3e-8)
    assert nao.within_limits(found.q).all()


def test_a_joint_that_stays_keeps_its_range_where_another_sets_it(nao: nk.NaoModel) -> None:
    # HeadPitch stays at 0.4, which HeadYaw = 1.5 does not allow.
    reference, q = nao.neutral(), nao.neutral()
    reference[nao.joint_names.index("HeadPitch")] = 0.4
    q[nao.joint_names.index("HeadYaw")] = 1.5
    frame = next(joint.child for joint in nao.tree.moving_joints if joint.name == "HeadYaw")
    found = numeric(nao, frame, nao.fk(q, frame), near=nao.clamp(reference))
    assert found.joints == ("HeadYaw",)
    assert found.success is False
    assert nao.within_limits(found.q)
    assert found.q[nao.joint_names.index("HeadPitch")] == 0.4


def test_a_search_that_was_stopped_says_so(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.random(3, 40), "LLeg")
    found = numeric(nao, "LLeg", T, iterations=1, restarts=0)
    assert not np.asarray(found.success).all()
    assert any("stopped" in note for note in found.notes)


def test_a_search_that_was_stopped_tells_nothing_of_the_joints(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.posture("Crouch"), "LArm")
    found = numeric(nao, "LArm", T, restarts=0, iterations=1)
    assert found.reason is Reason.NOT_CONVERGED
    T[:3, 3] += 0.05
    assert numeric(nao, "LArm", T).reason is Reason.NOT_ENOUGH_JOINTS


# --- references -----------------------------------------------------------------------------------------------------


def test_a_reference_outside_the_limits_is_projected_and_this_is_said(nao: nk.NaoModel) -> None:
    q = nao.posture("StandInit")
    q[nao.joint_names.index("RElbowRoll")] = 3.0
    T = nao.fk(nao.posture("StandInit"), "LLeg")
    found = numeric(nao, "LLeg", T, near=q)
    assert found.success is True
    assert nao.within_limits(found.q)
    assert any("RElbowRoll" in note and "projected" in note for note in found.notes)
    ignored = numeric(nao, "LLeg", T, near=q, limits="ignore")
    assert ignored.notes == ()
    assert ignored.q[nao.joint_names.index("RElbowRoll")] == 3.0


def test_references_broadcast_with_targets(nao: nk.NaoModel) -> None:
    T = nao.fk(nao.random(3, 5), "Head")
    references = nao.random(4, (3, 1))
    found = numeric(nao, "Head", T, near=references)
    assert found.q.shape == (3, 5, 25)
    np.testing.assert_array_equal(found.q[1, 2, 2:], references[1, 0, 2:])


# --- derivatives and regions ----------------------------------------------------------------------------------------


def _errors(motion: FrameMotion, weights: Floats, target: Floats, values: Floats) -> tuple[Floats, Floats, float]:
    """Errors, their derivative and half their square, as the search computes them of a target in the base."""
    scratch = new_scratch(1, len(motion.chain.place), len(values), 0)
    goal = Goal(weights, 1e-8, 1)
    cost = errors_at(motion.chain, goal, target.reshape(16), values, scratch, scratch.e, scratch.J)
    return scratch.e, scratch.J.reshape(6, len(values)), cost


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 0.0099, 0.0101, 1.0, 3.0, np.pi - 1e-3])
def test_the_derivative_of_the_error_is_that_of_finite_differences(nao: nk.NaoModel, angle: float) -> None:
    motion, weights = FrameMotion(nao, "RLeg"), np.array([1.0, 2.0, 3.0, 0.1, 0.2, 0.3])
    q, h = nao.random(6, 3), 1e-5
    axes = np.random.default_rng(1).normal(size=(3, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    T = nao.fk(q, "RLeg")
    T[:, :3, :3] = T[:, :3, :3] @ nk.rotations.exp(angle * axes)
    T[:, :3, 3] += 0.1
    for target, values in zip(T, q[:, motion.columns], strict=True):
        derivative = _errors(motion, weights, target, values)[1]
        for column, step in enumerate(h * np.eye(len(values))):
            ahead, behind = (_errors(motion, weights, target, values + way)[0] for way in (step, -step))
            difference = (ahead - behind) / (2 * h)
            np.testing.assert_allclose(derivative[:, column], difference, atol=2e-8 if angle < 3.1 else 1e-6)


def test_the_search_sees_the_errors_of_the_poses(nao: nk.NaoModel) -> None:
    for robot, frame in ((nao, "RLeg"), (nao, "Head"), (nk.load_nao("v5", base="floating"), "LArm")):
        motion, weights = FrameMotion(robot, frame), np.array([1.0, 2.0, 3.0, 0.0, 0.2, 0.3])
        q, T = robot.random(3, 40), robot.fk(robot.random(4, 40), frame)
        T[0] = robot.fk(q[:1], frame)[0]
        expected = weights * pose_errors(robot.fk(q, frame), T)
        for row, target in enumerate(motion.in_base(T, q)):
            e, _, cost = _errors(motion, weights, target, q[row, motion.columns])
            np.testing.assert_allclose(e, expected[row], atol=1e-12)
            assert cost == pytest.approx(0.5 * np.square(expected[row]).sum(), abs=1e-12)


@pytest.mark.full
@pytest.mark.parametrize("which", range(3))
def test_the_nearest_point_of_a_plane_region_is_nearer_than_all_points_of_a_fine_grid(
    nao: nk.NaoModel, which: int
) -> None:
    table = nao.coupled_limits[which]
    boxes = [(nao.lower[i], nao.upper[i]) for i in (nao.joint_names.index(n) for n in (table.of, table.joint))]
    names = [nao.joint_names.index(table.of), nao.joint_names.index(table.joint)]
    points = np.random.default_rng(2).uniform(-3.0, 3.0, (300, 2))
    q = np.zeros((300, 25))
    q[:, names] = points
    q = LimitRegion(nao, np.array(names)).project(q)
    found = q[:, names]
    assert not np.delete(q, names, axis=1).any()
    assert nao.within_limits(q, per_joint=True)[:, names].all()
    at = np.linspace(*boxes[0], 1500)
    low, high = (np.clip(bound, *boxes[1]) for bound in table.range(at))
    share = np.linspace(0.0, 1.0, 60)[:, None]
    grid = np.stack(np.broadcast_arrays(at, low + share * (high - low)), axis=-1).reshape(-1, 2)
    distances = cKDTree(grid).query(points)[0]
    gaps = np.linalg.norm(found - points, axis=-1)
    assert (gaps <= distances + 1e-12).all()
    assert (gaps >= distances - 0.05).all()
    inside = gaps == 0.0
    assert inside.any()
    np.testing.assert_array_equal(found[inside], points[inside])


def test_where_only_one_joint_of_a_table_moves_the_other_keeps_its_value(nao: nk.NaoModel) -> None:
    yaw, pitch = (nao.joint_names.index(name) for name in ("HeadYaw", "HeadPitch"))
    values = np.zeros((2, 25))
    values[:, yaw], values[:, pitch] = [1.5, -1.9], [0.4, 0.4]
    for moving in (yaw, pitch):
        inside = LimitRegion(nao, np.array([moving])).project(values)
        assert nao.within_limits(inside, per_joint=True)[:, [yaw, pitch]].all()
        changed = inside != values
        assert changed[:, moving].all()
        assert changed.sum() == 2
    # The nearest such HeadYaw, by a fine scan.
    inside = LimitRegion(nao, np.array([yaw])).project(values)
    scan = np.tile(values[0], (200_001, 1))
    scan[:, yaw] = np.linspace(nao.lower[yaw], nao.upper[yaw], len(scan))
    allowed = scan[nao.within_limits(scan, per_joint=True)[:, pitch], yaw]
    for row in range(2):
        assert abs(inside[row, yaw] - values[row, yaw]) == pytest.approx(
            np.abs(allowed - values[row, yaw]).min(), abs=1e-4
        )


def test_tables_that_share_a_joint_are_all_obeyed(tmp_path: Path) -> None:
    tables = (
        CoupledLimit("b", "a", (-1.0, 1.0), (-0.2, -1.0), (0.2, 1.0)),
        CoupledLimit("c", "b", (-1.0, 1.0), (-0.5, 0.0), (0.0, 0.5)),
    )
    made_up(tmp_path, J("a"), J("b", axis=(0.0, 1.0, 0.0)), J("c", axis=(1.0, 0.0, 0.0)))
    robot = nk.RobotModel.from_urdf(tmp_path / "robot.urdf", semantics=Semantics(coupled_limits=tables))
    values = np.random.default_rng(0).uniform(-3.0, 3.0, (500, 3))
    inside = LimitRegion(robot, np.arange(3)).project(values)
    assert robot.within_limits(inside).all()
    T = robot.fk(robot.random(1, 100), "c_l")
    check_reached(robot, "c_l", T, numeric(robot, "c_l", T))


# --- bad input ------------------------------------------------------------------------------------------------------


def _poses(changes: dict[tuple[int, ...], float]) -> np.ndarray:
    T = np.tile(np.eye(4), (2, 3, 1, 1))
    for place, value in changes.items():
        T[place] = value
    return T


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"frame": "LLag"}, UnknownName, "LLeg"),
        ({"frame": "torso"}, BadArgument, "no joint moves"),
        ({"target": _poses({(0, 1, 0, 3): np.nan})}, NotFinite, r"\[0, 1, 0, 3\]"),
        (
            {"target": np.zeros(7)},
            WrongShape,
            r"\(\.\.\., 4, 4\) for poses or \(\.\.\., 3\) for positions, got \(7,\)$",
        ),
        ({"target": [0.1, np.nan, 0.1]}, NotFinite, r"target.*\[1\]"),
        ({"target": [0.1, 0.0, 0.1], "weights": (0.0, 1.0)}, BadArgument, "not all of those of a position 0"),
        ({"target": "pose"}, BadArgument, "target must be"),
        ({"near": np.zeros(24)}, WrongShape, r"near must have shape \(\.\.\., 25\)"),
        ({"near": np.full(25, np.nan)}, NotFinite, "HeadYaw"),
        ({"near": np.zeros((4, 25)), "target": _poses({})}, WrongShape, "broadcast"),
        ({"limits": "clamp"}, UnknownName, r"\(valid: enforce, ignore\); with .enforce., the result's `best`"),
        ({"weights": (1.0, -1.0)}, BadArgument, "weights"),
        ({"weights": (1.0, 1.0, 1.0)}, BadArgument, "weights"),
        ({"restarts": -1}, BadArgument, "restarts"),
        ({"iterations": 0}, BadArgument, "iterations"),
        ({"tolerance": -1.0}, BadArgument, "tolerance"),
        ({"seed": 0.5}, BadArgument, "seed"),
    ],
)
def test_bad_input_is_named(nao: nk.NaoModel, changes: dict[str, object], error: type, words: str) -> None:
    arguments: dict[str, object] = {"frame": "LLeg", "target": np.eye(4), **changes}
    with pytest.raises(error, match=words):
        numeric(nao, **arguments)  # type: ignore[arg-type]


def test_a_pose_alone_gets_the_rotation_that_it_gets_in_a_batch(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(4)
    T = nao.fk(nao.random(rng, COUNT), "LArm")
    T[:, :3] += rng.normal(size=(COUNT, 3, 4)) * 10.0 ** rng.uniform(-18.0, -7.5, (COUNT, 1, 1))
    T[:, 3] += rng.normal(size=(COUNT, 4)) * 1e-9
    rigid = rigid_poses(T, "T")
    assert (rigid != T)[:, :3, :3].any(axis=(1, 2)).mean() > 0.2
    for pose, expected in zip(T, rigid, strict=True):
        np.testing.assert_array_equal(rigid_poses(pose, "T"), expected)
    T[0, 0, 0] += 1e-5
    with pytest.raises(NotARotation):
        rigid_poses(T[0], "T")
