"""Robots whose zeros are shifted: calibrated ones, and those that count their joints from other zeros."""

from __future__ import annotations

import functools
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from ik_checks import Floats, distance_to_solutions
from loops import full

import nao_kin as nk
from nao_kin.ik import Family, IKResult, Reason

# Mountings at any angle, and zeros far from the usual ones.
pytestmark = pytest.mark.filterwarnings("ignore:large offsets")

NAO = nk.load_nao()
# The joints with a mounting of their own: both hips of the shared motor have one.
JOINTS = (*NAO.joint_names, "RHipYawPitch")
OFFSETS = (-0.05, 0.01)
FEET, HANDS = ["LLeg", "RLeg"], ["LArm", "RArm"]
# All joints together, and a camera and effectors that are mounted at any angle.
ALL = {
    name: float(value) for name, value in zip(JOINTS, np.random.default_rng(3).uniform(-0.05, 0.05, 26), strict=True)
}
ALL |= {"LHand": 0.0, "RHand": 0.0}
MOVES = {"lean": nk.rotations.rot_y(0.02), "yaw": nk.rotations.rot_z(0.02)}
MOUNTED = {"CameraTop": (0.004, -0.01, 0.003, 0.2, -0.1, 0.3), "LArm": (0.01, 0.02, -0.01, 0.4, 1.0, -2.0)}


@functools.cache
def calibrated(joint: str, offset: float) -> nk.NaoModel:
    return NAO.with_offsets({joint: offset})


@pytest.fixture(scope="module")
def mine() -> nk.NaoModel:
    return NAO.with_offsets(ALL, MOUNTED)


def fk(robot: nk.RobotModel, q: Floats, frame: str) -> Floats:
    """The pose of a frame in the torso, by Pinocchio alone, shape (n, 4, 4)."""
    data = robot.model.createData()
    poses = []
    for row in np.atleast_2d(q):
        pin.framesForwardKinematics(robot.model, data, row)
        torso, own = (data.oMf[robot.model.getFrameId(name)] for name in ("torso", frame))
        poses.append((torso.inverse() * own).homogeneous)
    return np.array(poses)


def samples(robot: nk.RobotModel, seed: int, n: int) -> Floats:
    """Configurations inside the limits; in every second one, some joints are at a limit."""
    rng = np.random.default_rng(seed)
    q = robot.random(rng, n)
    ends = np.where(rng.random(q.shape) < 0.5, robot.lower, robot.upper)
    at_limits = (rng.random(q.shape) < 0.2) & (np.arange(n)[:, None] % 2 == 0)
    return robot.clamp(np.where(at_limits, ends, q))


def assert_reached(robot: nk.RobotModel, frame: str, T: Floats, found: IKResult) -> None:
    """Every solution brings the frame to its pose by Pinocchio's forward kinematics, inside the limits."""
    assert found.success.all(), found.describe(tuple(np.argwhere(~found.success)[0]))
    for k in range(found.solutions.shape[-2]):
        rows = found.count > k
        q = found.solutions[rows, k]
        assert np.abs(fk(robot, q, frame) - T[rows]).max() < 1e-9
        assert robot.within_limits(q).all()


# --- Every function of `ik` on one robot.


def check_leg(robot: nk.NaoModel, q: Floats) -> None:
    for side in "LR":
        T = fk(robot, q, f"{side}Leg")
        found = nk.ik.leg(robot, side, T, near=q)
        assert_reached(robot, f"{side}Leg", T, found)
        assert distance_to_solutions(found, q).max() < 1e-7


def check_arm(robot: nk.NaoModel, q: Floats) -> None:
    for side in "LR":
        T = fk(robot, q, f"{side}Arm")
        found = nk.ik.arm(robot, side, T, near=q)
        assert_reached(robot, f"{side}Arm", T, found)
        assert distance_to_solutions(found, q).max() < 1e-7
        # The axis of WristYaw is the direction of the forearm, whatever the hand's mounting.
        forearm = robot.rotation(q, f"{side}WristYaw", reference="torso")[:, :, 0]
        towards = nk.ik.arm(robot, side, T[:, :3, 3], direction=forearm, near=q)
        assert towards.success.all()
        assert np.abs(fk(robot, towards.q, f"{side}Arm")[:, :3, 3] - T[:, :3, 3]).max() < 1e-9
        made = robot.rotation(towards.q, f"{side}WristYaw", reference="torso")[:, :, 0]
        assert np.abs(made - forearm).max() < 1e-9
        place = nk.ik.arm(robot, side, T[:2, :3, 3], near=q[:2])
        assert place.success.all()
        assert np.abs(fk(robot, place.q, f"{side}Arm")[:, :3, 3] - T[:2, :3, 3]).max() < 1e-9
        assert (np.abs(place.q - q[:2]).max(axis=-1) < 1e-6).all()


def check_head(robot: nk.NaoModel, q: Floats) -> None:
    T = fk(robot, q, "Head")
    found = nk.ik.head(robot, T[:, :3, :3], near=q)
    assert found.success.all()
    assert np.abs(fk(robot, found.q, "Head") - T).max() < 1e-9


def check_look_at(robot: nk.NaoModel, q: Floats) -> None:
    for camera in ("CameraTop", "CameraBottom", "MicroFrontLeft"):
        T = fk(robot, q, camera)
        points = T[:, :3, 3] + np.geomspace(0.3, 10.0, len(q))[:, None] * T[:, :3, 0]
        found = nk.ik.look_at(robot, points, camera, near=q)
        assert found.success.all()
        assert distance_to_solutions(found, q).max() < 1e-7
        for k in range(found.solutions.shape[-2]):
            rows = found.count > k
            seen = (
                np.linalg.inv(fk(robot, found.solutions[rows, k], camera))
                @ np.append(points[rows], np.ones((np.count_nonzero(rows), 1)), axis=1)[..., None]
            )
            assert np.abs(seen[:, 1:3]).max() < 1e-9
            assert (seen[:, 0] > 0.0).all()


def check_legs(robot: nk.NaoModel, q: Floats) -> None:
    T = [fk(robot, q, foot) for foot in FEET]
    found = nk.ik.legs(robot, *T, near=q)
    for foot, wanted in zip(FEET, T, strict=True):
        assert_reached(robot, foot, wanted, found)
    assert distance_to_solutions(found, q).max() < 1e-6
    # Feet that no hip value meets: the ankles and the normals of the soles are met, and the stated turns are true.
    turned = T[1] @ nk.screws.pose(nk.rotations.rot_z(0.05), np.zeros(3))
    other = nk.ik.legs(robot, T[0], turned, near=q, limits="ignore")
    assert (other.reasons == Reason.HIPS_DISAGREE).all()
    for foot, wanted, turn in zip(FEET, (T[0], turned), other.yaw_errors.T, strict=True):
        made = np.linalg.inv(wanted) @ fk(robot, other.q, foot)
        assert np.abs(made[:, :3, :3] - nk.rotations.rot_z(turn)).max() < 1e-9
    # The desired torso is off by a move that the solver may undo.
    hips = 0.5 * (fk(robot, q[:1], "LHipYawPitch") + fk(robot, q[:1], "RHipYawPitch"))[0, :3, 3]
    about = {free: nk.screws.pose(turn, hips - turn @ hips) for free, turn in MOVES.items()}
    for free, torso in (about | {"height": nk.screws.pose(np.eye(3), [0.0, 0.0, 0.01])}).items():
        world = nk.ik.legs(robot, *T, near=q, base="floating", free=free, torso=torso)
        assert world.success.all()
        for foot, wanted in zip(FEET, T, strict=True):
            assert np.abs(world.torso @ fk(robot, world.q, foot) - wanted).max() < 1e-9


def check_whole_body(robot: nk.NaoModel, q: Floats) -> None:
    stand = robot.posture("StandInit")
    T = robot.fk(stand, FEET)
    result = nk.ik.whole_body(
        robot, {"LArm": [0.18, 0.1, 0.1]}, feet={"L": T[0], "R": T[1]}, com="support", gaze=[1.0, 0.2, 0.1], near=stand
    )
    assert result.success
    for k, foot in enumerate(FEET):
        assert np.abs(result.torso @ fk(robot, result.q, foot)[0] - T[k]).max() < 1e-8


def check_follow(robot: nk.NaoModel, q: Floats) -> None:
    ends = robot.posture("StandInit"), robot.posture("Crouch")
    path = np.linspace(*ends, 8)
    found = nk.ik.follow(
        robot,
        {"LLeg": fk(robot, path, "LLeg"), "RLeg": fk(robot, path, "RLeg"), "LArm": fk(robot, path, "LArm")},
        near=path,
    )
    assert found.reached.all(), found.describe()
    for frame in ("LLeg", "RLeg", "LArm"):
        assert np.abs(fk(robot, found.q, frame) - fk(robot, path, frame)).max() < 1e-9


def check_search(robot: nk.NaoModel, q: Floats) -> None:
    """`numeric`, `velocity` and `analytic`."""
    start = robot.posture("StandInit")
    target = fk(robot, robot.clamp(start + 0.05), "LLeg")[0]
    found = nk.ik.numeric(robot, "LLeg", target, near=start)
    assert np.abs(fk(robot, found.q, "LLeg")[0] - target).max() < 1e-6
    speed = nk.ik.velocity(robot, start, [0.01, 0.0, 0.0, 0.0, 0.0, 0.1], "LLeg", expressed_in="mixed")
    moved = fk(robot, np.stack([start, start + 1e-5 * speed.v]), "LLeg")[:, :3, 3]
    assert np.abs((moved[1] - moved[0]) / 1e-5 - speed.twist[:3]).max() < 1e-5
    pytest.importorskip("eaik")
    T = fk(robot, q[1:2], "LLeg")[0]
    solved = nk.ik.analytic(robot, "LLeg", T, near=q[1])
    assert distance_to_solutions(solved, q[1]).max() < 1e-6


CHECKS: dict[str, Callable[[nk.NaoModel, Floats], None]] = {
    "leg": check_leg,
    "legs": check_legs,
    "arm": check_arm,
    "head": check_head,
    "look_at": check_look_at,
    "whole_body": check_whole_body,
    "follow": check_follow,
    "search": check_search,
}


@pytest.mark.parametrize("function", CHECKS)
def test_a_robot_with_offsets_of_all_joints_and_frames_has_every_solver(mine: nk.NaoModel, function: str) -> None:
    CHECKS[function](mine, samples(mine, 4, 12))


@pytest.mark.parametrize("offset", [OFFSETS[0], *full(*OFFSETS[1:])])
@pytest.mark.parametrize("joint", JOINTS)
def test_one_offset_leaves_the_closed_forms_of_its_limb(joint: str, offset: float) -> None:
    robot = calibrated(joint, offset)
    own = {"Head": ("head", "look_at"), "LHip": ("leg", "legs"), "RHip": ("leg", "legs")}
    legs = any(part in joint for part in ("Hip", "Knee", "Ankle"))
    for function in own.get(joint[:4], ("leg", "legs") if legs else ("arm",)):
        CHECKS[function](robot, samples(robot, 5, 6))


# --- The same solutions as those of the robot without offsets, minus the offsets.


def columns_of(limb: IKResult, offsets: dict[str, float]) -> Floats:
    """Return the offset of each coordinate that a limb moves."""
    return np.array([offsets.get(joint, 0.0) for joint in limb.joints])


def assert_shifted(found: IKResult, nominal: IKResult, offsets: dict[str, float]) -> None:
    np.testing.assert_array_equal(found.count, nominal.count)
    np.testing.assert_array_equal(found.families, nominal.families)
    np.testing.assert_array_equal(found.reasons, nominal.reasons)
    shift = columns_of(found, offsets)
    np.testing.assert_allclose(found.branches + shift, nominal.branches, rtol=0, atol=1e-9)
    np.testing.assert_allclose((found.best + shift)[found.success], nominal.best[found.success], rtol=0, atol=1e-9)
    # The nearest poses, where searches end in flat valleys.
    np.testing.assert_allclose(found.residual, nominal.residual, rtol=0, atol=1e-6)


def solved(robot: nk.NaoModel, function: str, T: Floats, near: Floats) -> IKResult:
    if function in ("leg", "arm"):
        return getattr(nk.ik, function)(robot, "L", T, near=near, limits="ignore")
    if function == "place":
        return nk.ik.arm(robot, "L", T[:, :3, 3], near=near, limits="ignore")
    if function == "head":
        return nk.ik.head(robot, T[:, :3, :3], near=near, limits="ignore")
    return nk.ik.look_at(robot, T[:, :3, 3], near=near, limits="ignore")


TARGETS = {"leg": "LLeg", "arm": "LArm", "place": "LArm", "head": "Head", "look_at": "LArm"}


@pytest.mark.parametrize("function", TARGETS)
def test_solutions_are_the_nominal_ones_minus_the_offsets(function: str) -> None:
    robot = NAO.with_offsets(ALL)
    shift = np.array([ALL[name] for name in robot.joint_names])
    near = samples(robot, 7, 8)
    T = fk(robot, samples(robot, 8, 8), TARGETS[function])
    T[-2:, :3, 3] *= 3.0  # out of reach, except for a gaze
    assert_shifted(solved(robot, function, T, near), solved(NAO, function, T, near + shift), ALL)


def test_families_are_the_same() -> None:
    robot = NAO.with_offsets(ALL)
    shift = np.array([ALL[name] for name in robot.joint_names])
    near = NAO.configuration({"HeadYaw": 0.3, "LHipYawPitch": -0.2, "LHipPitch": 0.1})

    lock = NAO.configuration({"LHipRoll": -np.pi / 4.0}, limits="ignore")
    for q in (lock,):
        T = fk(NAO, q, "LLeg")
        found, nominal = solved(robot, "leg", T, (near - shift)[None]), solved(NAO, "leg", T, near[None])
        assert (nominal.families == Family.HIP_LOCK).any()
        assert_shifted(found, nominal, ALL)
    up = np.eye(4)[None].repeat(1, axis=0)
    up[:, 2, 3] = 2.0
    found, nominal = solved(robot, "look_at", up, (near - shift)[None]), solved(NAO, "look_at", up, near[None])
    assert (nominal.families == Family.YAW_AXIS).any()
    assert_shifted(found, nominal, ALL)


def test_limits_are_those_of_reported_values() -> None:
    robot = NAO.with_offsets({"LKneePitch": 0.05, "HeadPitch": -0.05, "HeadYaw": 0.05})
    bent = robot.configuration({"LKneePitch": robot.upper[robot.joint_names.index("LKneePitch")]})
    assert nk.ik.leg(robot, "L", robot.fk(bent, "LLeg"), near=bent).success
    beyond = robot.configuration({"LKneePitch": bent.max() + 0.02}, limits="ignore")
    found = nk.ik.leg(robot, "L", robot.fk(beyond, "LLeg"), near=bent)
    assert found.reason is Reason.JOINT_LIMIT
    # The reason states the reported value that is needed, and the limit of reported values.
    assert found.joints[int(found.obstacles.joint)] == "LKneePitch"
    assert float(found.obstacles.needed) == pytest.approx(beyond.max(), abs=1e-9)
    assert float(found.obstacles.limit) == pytest.approx(bent.max(), abs=1e-12)
    table = robot.coupled_limits[0]
    for yaw in np.linspace(-2.0, 2.0, 5):
        low, high = table.range(np.array(yaw))
        for pitch in (low + 1e-4, low - 1e-4, high - 1e-4, high + 1e-4):
            q = robot.posture("StandInit")
            q[:2] = yaw, pitch
            assert bool(nk.ik.head(robot, robot.rotation(q, "Head")).success) == robot.within_limits(q)


# --- Robots that count from other zeros, without any record of it.


def other_zeros(folder: Path, zeros: dict[str, float]) -> nk.RobotModel:
    """Write a NAO whose joints read 0 at these angles, with the limits of the same postures, and read it again."""
    done = nk.export.urdf(NAO.with_offsets(zeros), folder / "other.urdf", meshes="none")
    tree = ET.parse(done.path)
    for joint in tree.iter("joint"):
        for limit in joint.iter("limit"):
            for end in ("lower", "upper"):
                limit.set(end, repr(float(limit.get(end)) - zeros.get(joint.get("name"), 0.0)))
    tree.write(done.path)
    return nk.RobotModel.from_urdf(done.path)


@pytest.mark.parametrize(
    "zeros",
    [
        {"LKneePitch": 0.5, "RKneePitch": 0.5},
        {"LShoulderPitch": 1.5, "LElbowRoll": -1.5, "LWristYaw": 2.0, "RShoulderPitch": np.pi},
        {"LHipPitch": -0.6, "LKneePitch": 1.2, "LAnklePitch": -0.6, "LAnkleRoll": 3.0, "RHipRoll": -0.3},
        {"HeadYaw": 1.0, "HeadPitch": -3.0},
    ],
)
def test_a_robot_that_counts_from_other_zeros_has_closed_forms(tmp_path: Path, zeros: dict[str, float]) -> None:
    robot = other_zeros(tmp_path, zeros)
    q = samples(robot, 9, 40)
    for side in "LR":
        for solve, limb in ((nk.ik.leg, "Leg"), (nk.ik.arm, "Arm")):
            T = fk(robot, q, side + limb)
            found = solve(robot, side, T, near=q)
            assert_reached(robot, side + limb, T, found)
            assert distance_to_solutions(found, q).max() < 1e-7
    found = nk.ik.head(robot, fk(robot, q, "Head")[:, :3, :3])
    assert distance_to_solutions(found, q).max() < 1e-7
