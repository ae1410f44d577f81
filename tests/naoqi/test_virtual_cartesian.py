"""Cartesian control of the virtual NAO, against forward kinematics and paths written out."""

from __future__ import annotations

import numpy as np
import pytest
from loops import full
from naoqi_script import ROBOT, TORSO, WORLD, Script
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation, Slerp

import nao_kin as nk
from nao_kin import naoqi
from nao_kin.naoqi.virtual.cartesian import EffectorPath, axis_weights, columns_of, descend, search

# --- reading ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["Head", "LArm", "RLeg", "Torso", "LElbowRoll", "RHipYawPitch", "CameraTop", "LFsrFL"])
def test_poses_are_those_of_forward_kinematics_in_every_space(script: Script, name: str) -> None:
    robot = script.nao.robot
    script("moveInit")
    script("angleInterpolation", ["LHipRoll", "LKneePitch", "HeadYaw", "LElbowRoll"], [0.1, 1.0, 0.5, -0.4], 1.0, True)
    q, T_world_torso = script.nao.joints.q(), script.torso()
    T_torso_name = robot.fk(q, name if name in robot.frame_names else f"{name}_frame")
    left, right = (T_world_torso @ robot.fk(q, foot) for foot in ("LLeg", "RLeg"))
    yaw = [np.arctan2(T[1, 0], T[0, 0]) for T in (left, right)]
    T_world_robot = np.eye(4)
    T_world_robot[:3, :3] = Rotation.from_euler("z", np.mean(yaw)).as_matrix()
    T_world_robot[:3, 3] = *(0.5 * (left + right))[:2, 3], min(left[2, 3], right[2, 3])
    expected = T_torso_name, T_world_torso @ T_torso_name, np.linalg.inv(T_world_robot) @ T_world_torso @ T_torso_name
    for space in (TORSO, WORLD, ROBOT):
        assert np.abs(script.pose(name, space) - expected[space]).max() < 1e-9
        six = script.position(name, space)
        assert np.abs(six[:3] - expected[space][:3, 3]).max() < 1e-9
        turned = Rotation.from_euler("xyz", six[3:]).inv() * Rotation.from_matrix(expected[space][:3, :3])
        assert turned.magnitude() < 1e-9


def test_commands_and_sensors_are_read_apart(script: Script) -> None:
    before = script.position("Head", TORSO)
    script("setAngles", "HeadYaw", 1.0, 0.1)
    script.nao.step(0.01)
    assert script("getPosition", "Head", TORSO, False)[5] > 0.0
    script("setStiffnesses", "Head", 0.0)
    script.nao.step(1.0)
    assert script("getPosition", "Head", TORSO, False)[5] > script.position("Head", TORSO)[5] + 0.5
    assert script.position("Head", TORSO)[5] < before[5] + 0.1


# --- in time ----------------------------------------------------------------------------------------------------------


def test_a_hand_goes_straight_to_its_target_in_its_time(script: Script) -> None:
    start = script.position("LArm", TORSO)
    target = start + np.array([0.04, 0.03, 0.06, 0.0, 0.0, 0.0])
    begin = script.nao.clock.now
    call = script.nao.post("ALMotion", "positionInterpolations", ["LArm"], TORSO, [[target.tolist()]], [7], [[1.0]])
    way = target[:3] - start[:3]
    while not call.done():
        script.nao.step(0.01)
        share = script.nao.clock.now - begin
        place = script.position("LArm", TORSO)[:3] - start[:3]
        smooth = share * share * (3.0 - 2.0 * share)
        assert np.abs(place - smooth * way).max() < 1e-6
    assert script.nao.clock.now - begin == pytest.approx(1.0, abs=1e-9)
    assert np.abs(script.position("LArm", TORSO)[:3] - target[:3]).max() < 1e-6


TARGET = [0.15, 0.12, 0.06, 0.0, 0.0, 0.0]
OTHER = [0.16, 0.11, 0.02, 0.0, 0.0, 0.0]
MIRRORED = [0.15, -0.12, 0.06, 0.0, 0.0, 0.0]
FORMS = [
    ("positionInterpolation", ("LArm", TORSO, TARGET, 7, 0.5, True)),
    ("positionInterpolation", ("LArm", TORSO, [TARGET], 7, [0.5], True)),
    ("positionInterpolation", ("LArm", TORSO, [OTHER, TARGET], 7, [0.3, 0.5], True)),
    ("positionInterpolation", ("LArm", TORSO, [OTHER, TARGET], 7, [0.3, 0.5])),
    ("positionInterpolations", ("LArm", TORSO, TARGET, 7, 0.5)),
    ("positionInterpolations", (["LArm"], [TORSO], [[TARGET]], [7], [[0.5]])),
    ("positionInterpolations", (["LArm"], TORSO, [TARGET], [7], [0.5], True)),
    ("positionInterpolations", (["LArm"], TORSO, [OTHER, TARGET], 7, [0.3, 0.5], True)),
    ("positionInterpolations", (["LArm"], TORSO, [[OTHER, TARGET]], [7], [[0.3, 0.5]], True)),
    ("transformInterpolation", ("LArm", TORSO, naoqi.transform_list(naoqi.pose(TARGET)).tolist(), 7, 0.5, True)),
    ("transformInterpolations", (["LArm"], TORSO, [[naoqi.transform_list(naoqi.pose(TARGET)).tolist()]], [7], [[0.5]])),
    ("transformInterpolations", ("LArm", TORSO, naoqi.transform_list(naoqi.pose(TARGET))[:12].tolist(), 7, 0.5)),
]


@pytest.mark.parametrize(("name", "given"), FORMS, ids=range(len(FORMS)))
def test_every_form_of_the_arguments_means_the_same(script: Script, name: str, given: tuple) -> None:
    script(name, *given)
    assert np.abs(script.position("LArm", TORSO)[:3] - TARGET[:3]).max() < 1e-6
    assert script.nao.clock.now == pytest.approx(0.5, abs=1e-9)


def test_effectors_keep_their_own_times_spaces_and_masks(script: Script) -> None:
    right, head = MIRRORED, [0.0, 0.0, 0.0, 0.0, 0.2, 0.5]
    names, paths = ["LArm", "RArm", "Head"], [[TARGET, OTHER], [right], [head]]
    script("positionInterpolations", names, [TORSO, TORSO, TORSO], paths, [7, 7, 56], [[0.4, 0.8], [0.3], [1.2]], True)
    assert script.nao.clock.now == pytest.approx(1.2, abs=1e-9)
    assert np.abs(script.position("LArm", TORSO)[:3] - OTHER[:3]).max() < 1e-6
    assert np.abs(script.position("RArm", TORSO)[:3] - right[:3]).max() < 1e-6
    assert np.abs(script.position("Head", TORSO)[3:] - head[3:]).max() < 1e-6


@pytest.mark.parametrize("times", [[0.5, 1.0], [[0.5, 1.0], [0.5, 1.0]]])
def test_one_list_of_times_may_be_for_all(script: Script, times: list) -> None:
    mirrored = [[x, -y, *rest] for x, y, *rest in (OTHER, TARGET)]
    script("positionInterpolations", ["LArm", "RArm"], TORSO, [[OTHER, TARGET], mirrored], 7, times, True)
    assert script.nao.clock.now == pytest.approx(1.0, abs=1e-9)
    assert np.abs(script.position("RArm", TORSO)[:3] - mirrored[1][:3]).max() < 1e-6


def test_a_foot_turns_by_slerp(script: Script) -> None:
    start = script.pose("LLeg", TORSO)
    target = naoqi.pose([start[0, 3] + 0.03, start[1, 3] + 0.02, start[2, 3] + 0.03, 0.05, 0.1, 0.3])
    call = script.nao.post(
        "ALMotion", "transformInterpolations", "LLeg", TORSO, naoqi.transform_list(target).tolist(), 63, 1.0
    )
    turn = Slerp([0.0, 1.0], Rotation.from_matrix(np.stack([start[:3, :3], target[:3, :3]])))
    for time in (0.25, 0.5, 0.75, 1.0):
        script.nao.step(0.25)
        share = time * time * (3.0 - 2.0 * time)
        found = script.pose("LLeg", TORSO)
        assert np.abs(found[:3, 3] - ((1.0 - share) * start + share * target)[:3, 3]).max() < 1e-6
        assert np.abs(found[:3, :3] - turn(share).as_matrix()).max() < 1e-6
    assert call.done()


def test_relative_targets_add_along_the_axes_of_the_space(script: Script) -> None:
    start = script.pose("RLeg", TORSO)
    script("positionInterpolation", "RLeg", TORSO, [0.02, -0.01, 0.03, 0.0, 0.1, -0.1], 63, 0.5, False)
    found, change = script.pose("RLeg", TORSO), naoqi.pose([0.02, -0.01, 0.03, 0.0, 0.1, -0.1])
    assert np.abs(found[:3, 3] - start[:3, 3] - change[:3, 3]).max() < 1e-6
    assert np.abs(found[:3, :3] - change[:3, :3] @ start[:3, :3]).max() < 1e-6


def test_a_curve_passes_its_keys_in_time_and_never_leaves_their_range() -> None:
    six = np.zeros((4, 6))
    six[:, 0], six[:, 1], six[:, 5] = (0.0, 1.0, 1.5, 1.0), (0.0, 0.2, 0.2, 0.0), (0.0, 0.5, 0.5, -0.5)
    path = EffectorPath([0.0, 1.0, 2.0, 4.0], naoqi.pose(six))
    for time, row in zip((0.0, 1.0, 2.0, 4.0, 9.0), (*six, six[-1]), strict=True):
        assert np.abs(naoqi.position6d(path.pose(time)) - row).max() < 1e-12
    samples = np.array([naoqi.position6d(path.pose(time)) for time in np.linspace(0.0, 4.0, 401)])
    assert samples[:, 0].max() <= 1.5 + 1e-12
    assert samples[100:201, 1] == pytest.approx(0.2, abs=1e-12)
    assert samples[100:201, 5] == pytest.approx(0.5, abs=1e-12)
    # At rest at both ends.
    assert np.abs(np.diff(samples, axis=0)[[0, -1]]).max() < 4e-4


# --- solving ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("effector", "mask"),
    [("LArm", 7), ("RArm", 7), ("LArm", 63), ("LLeg", 63), ("RLeg", 7), ("Head", 56), ("Head", 48), ("RArm", 15)],
)
def test_what_some_joint_values_reach_is_reached(nao: nk.NaoModel, effector: str, mask: int) -> None:
    q = nao.clamp(nao.posture("StandInit"))
    axes = naoqi.controlled_axes(mask)
    R = Rotation.from_euler("z", 0.5).as_matrix()
    for wanted in nao.random(mask, 6):
        T = nao.fk(wanted, effector)
        found, missing = search(nao, effector, (T, (axis_weights(mask), R)), np.eye(4), q)
        assert missing < 1e-6
        assert nao.within_limits(found).all()
        away = nao.fk(found, effector)[:3, 3] - T[:3, 3]
        turn = Rotation.from_matrix(nao.fk(found, effector)[:3, :3] @ T[:3, :3].T).as_rotvec()
        error = np.concatenate([away, turn]).reshape(2, 3) @ R
        assert (np.abs(error.ravel()) < np.repeat([1e-6, 1e-5], 3))[axes].all()
        others = np.setdiff1d(np.arange(nao.nq), columns_of(nao, [effector]))
        assert np.array_equal(found[others], q[others])


def test_only_the_axes_of_the_mask_count_along_those_of_the_space(nao: nk.NaoModel) -> None:
    q = nao.clamp(nao.posture("StandInit"))
    R = Rotation.from_euler("z", 0.6).as_matrix()
    before = nao.fk(q, "LArm")
    T = before.copy()
    T[:3, 3] += R @ [0.02, 0.5, 0.5]
    found, _ = descend(nao, "LArm", (T, (axis_weights(naoqi.axis_mask("X")), R)), np.eye(4), q)
    moved = nao.fk(found, "LArm")[:3, 3] - before[:3, 3]
    assert (R.T @ moved)[0] == pytest.approx(0.02, abs=1e-8)
    assert np.linalg.norm(moved) < 0.03


def test_what_is_out_of_reach_is_approached_and_logged(script: Script) -> None:
    target = [0.5, 0.2, 0.1, 0.0, 0.0, 0.0]
    nearest = nk.ik.arm(script.nao.robot, "L", target[:3]).residual[0]
    script("positionInterpolations", "LArm", TORSO, target, 7, 2.0)
    missing = np.linalg.norm(script.position("LArm", TORSO)[:3] - target[:3])
    assert missing == pytest.approx(nearest, abs=1e-3)
    assert "LArm does not reach its target" in script.log()
    assert script.nao.robot.within_limits(script.nao.joints.q()).all()


# --- at once ----------------------------------------------------------------------------------------------------------


def test_set_positions_returns_at_once_and_keeps_to_its_speed(script: Script) -> None:
    script("setPositions", "LArm", TORSO, TARGET, 0.3, 7)
    assert script.nao.clock.now == 0.0
    most = 0.3 * script.nao.joints.max_speed * 0.01
    before = script.nao.joints.sensor
    moved = []
    for _ in range(300):
        script.nao.step(0.01)
        now = script.nao.joints.sensor
        assert (np.abs(now - before) <= most + 1e-9).all()
        moved.append(np.abs(now - before) > 0.0)
        before = now
    assert np.abs(script.position("LArm", TORSO)[:3] - TARGET[:3]).max() < 1e-6
    lengths = np.sum(moved, axis=0)
    assert len(set(lengths[lengths > 0].tolist())) == 1  # all arrive together


def test_a_later_set_positions_takes_the_joints_over(script: Script) -> None:
    script("setPositions", ["LArm", "RArm"], TORSO, [TARGET, MIRRORED], 0.1, [7, 7])
    script.nao.step(0.1)
    script("setPositions", "LArm", TORSO, OTHER, 0.5, 7)
    script.nao.step(6.0)
    assert np.abs(script.position("LArm", TORSO)[:3] - OTHER[:3]).max() < 1e-6
    assert np.abs(script.position("RArm", TORSO)[:3] - MIRRORED[:3]).max() < 1e-6
    assert script("getTaskList") == []


def test_old_names_do_the_same(script: Script) -> None:
    script("setPosition", "LArm", TORSO, TARGET, 0.5, 7)
    script.nao.step(3.0)
    assert np.abs(script.position("LArm", TORSO)[:3] - TARGET[:3]).max() < 1e-6
    script("changePosition", "LArm", TORSO, [0.02, 0.01, -0.02, 0, 0, 0], 0.5, 7)
    script.nao.step(3.0)
    assert np.abs(script.position("LArm", TORSO)[:3] - TARGET[:3] - [0.02, 0.01, -0.02]).max() < 1e-6
    for name in ("setTransform", "setTransforms"):
        script(
            name, "RLeg", TORSO, naoqi.transform_list(naoqi.pose([0.02, -0.06, -0.29, 0, 0, -0.1])).tolist(), 0.5, 63
        )
        script.nao.step(3.0)
        assert np.abs(script.position("RLeg", TORSO) - [0.02, -0.06, -0.29, 0, 0, -0.1]).max() < 1e-6
    script("changeTransform", "RLeg", TORSO, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.01], 0.5, 63)
    script.nao.step(3.0)
    assert np.abs(script.position("RLeg", TORSO) - [0.02, -0.06, -0.28, 0, 0, -0.1]).max() < 1e-6


# --- the torso and the feet -------------------------------------------------------------------------------------------


def test_the_torso_moves_over_feet_that_stay(script: Script) -> None:
    feet, start = script.feet(), script.pose("Torso", ROBOT)
    path = [[0.03, 0.0, -0.02, 0.0, 0.0, 0.0], [0.0, 0.03, -0.02, 0.05, 0.1, 0.0]]
    call = script.nao.post("ALMotion", "positionInterpolation", "Torso", ROBOT, path, 63, [0.5, 1.0], False)
    while not call.done():
        script.nao.step(0.05)
        assert np.abs(script.feet() - feet).max() < 1e-9
    wanted = start.copy()
    wanted[:3, 3] += path[1][:3]
    wanted[:3, :3] = naoqi.pose(path[1])[:3, :3] @ start[:3, :3]
    off = script.position("Torso", ROBOT) - naoqi.position6d(wanted)
    assert np.abs(off[:5]).max() < 1e-6
    # Of a torso that leans and is beside the feet, the two hips ask for different values: its yaw gives way.
    assert abs(off[5]) < 0.06


def test_the_yaw_of_the_torso_gives_way_and_the_log_says_so(script: Script) -> None:
    feet, start = script.feet(), script.position("Torso", WORLD)
    script("positionInterpolation", "Torso", WORLD, [0.0, 0.0, -0.02, 0.0, 0.0, 0.4], 63, 1.0, False)
    assert np.abs(script.feet() - feet).max() < 1e-9
    assert np.abs(script.position("Torso", WORLD)[:3] - start[:3] - [0, 0, -0.02]).max() < 1e-6
    assert "Torso does not reach its target" in script.log()


def test_the_torso_keeps_what_the_mask_leaves_out(script: Script) -> None:
    start = script.position("Torso", ROBOT)
    script("positionInterpolation", "Torso", ROBOT, [9.0, 9.0, start[2] - 0.03, 9.0, 9.0, 9.0], 4, 1.0, True)
    assert np.abs(script.position("Torso", ROBOT) - start - [0, 0, -0.03, 0, 0, 0]).max() < 1e-6
    script("setPositions", "Torso", ROBOT, start.tolist(), 0.5, 63)
    script.nao.step(2.0)
    assert np.abs(script.position("Torso", ROBOT) - start).max() < 1e-6


def _error(T: np.ndarray, wanted: np.ndarray) -> float:
    """Metres, with a radian as 0.1 m."""
    turn = Rotation.from_matrix(T[:3, :3].T @ wanted[:3, :3]).magnitude()
    return float(np.hypot(np.linalg.norm(T[:3, 3] - wanted[:3, 3]), 0.1 * turn))


@pytest.mark.parametrize("change", [(0.02, 0.0, 0.0), (0.03, 0.0, 0.0), (0.02, 0.0, 0.005)])
def test_in_crouch_the_torso_goes_as_near_as_scipy_finds_with_both_feet_in_place(change: tuple) -> None:
    script = Script("Crouch")
    robot, q, start = script.nao.robot, script.nao.joints.q(), script.pose("Torso", WORLD)
    feet, wanted, columns = script.feet(), start.copy(), columns_of(robot, ["Legs"])
    wanted[:3, 3] += change

    def torso(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        moved = q.copy()
        moved[columns] = x
        left, right = robot.fk(moved, ["LLeg", "RLeg"])
        T = feet[0] @ np.linalg.inv(left)
        return T, np.linalg.inv(feet[1]) @ T @ right

    def slip(x: np.ndarray) -> np.ndarray:
        T = torso(x)[1]
        return np.concatenate([T[:3, 3], Rotation.from_matrix(T[:3, :3]).as_rotvec()])

    found = minimize(
        lambda x: 1e4 * _error(torso(x)[0], wanted) ** 2,
        q[columns],
        method="SLSQP",
        bounds=list(zip(robot.lower[columns], robot.upper[columns], strict=True)),
        constraints={"type": "eq", "fun": slip},
        options={"maxiter": 300, "ftol": 1e-12},
    )
    best = q.copy()
    best[columns] = found.x
    assert np.abs(slip(found.x)).max() < 1e-6
    assert robot.within_limits(robot.clamp(best))
    assert np.abs(robot.clamp(best) - best).max() < 1e-6
    script("positionInterpolation", "Torso", WORLD, [*change, 0.0, 0.0, 0.0], 63, 0.3, False)
    script.nao.step(0.1)
    assert np.abs(script.feet() - feet).max() < 1e-6
    assert _error(script.pose("Torso", WORLD), wanted) == pytest.approx(_error(torso(found.x)[0], wanted), abs=2e-5)
    assert "Torso does not reach its target" in script.log()
    script.nao.close()


def test_a_hand_holds_its_place_in_the_world_while_the_torso_moves(script: Script) -> None:
    hand, torso = script.position("LArm", WORLD), script.position("Torso", WORLD)
    lower = torso + np.array([0.02, 0.0, -0.03, 0.0, 0.0, 0.0])
    paths = [[hand.tolist()], [lower.tolist()]]
    call = script.nao.post("ALMotion", "positionInterpolations", ["LArm", "Torso"], WORLD, paths, [7, 63], [1.0])
    while not call.done():
        script.nao.step(0.1)
        assert np.abs(script.position("LArm", WORLD)[:3] - hand[:3]).max() < 1e-6
    assert np.abs(script.position("Torso", WORLD) - lower).max() < 1e-6


# --- tasks and errors -------------------------------------------------------------------------------------------------


def test_a_path_waits_for_its_joints_and_can_be_killed(script: Script) -> None:
    script.nao.post("ALMotion", "angleInterpolation", "LShoulderPitch", 1.0, 1.0, True)
    call = script.nao.post("ALMotion", "positionInterpolations", "LArm", TORSO, TARGET, 7, 1.0)
    script.nao.step(1.5)
    assert not call.done()
    assert [name for name, _ in script("getTaskList")] == ["positionInterpolations"]
    script("killAll")
    script.nao.step(0.01)
    assert call.done()
    where = script.position("LArm", TORSO)
    script.nao.step(1.0)
    assert np.abs(script.position("LArm", TORSO) - where).max() < 0.02


# --- a leg that moves in the world ------------------------------------------------------------------------------------

LIFTED = [(leg, space, wx) for leg in ("LLeg", "RLeg") for space in (WORLD, ROBOT) for wx in (0.0, np.radians(5.0))]


def _shifted(script: Script) -> None:
    """Bring the torso 20 mm to the left, so that the hips' motor moves with a leg."""
    script("positionInterpolations", ["Torso"], ROBOT, [[[0.0, 0.02, 0.0, 0.0, 0.0, 0.0]]], [63], [[1.0]], False)


@pytest.mark.parametrize(("leg", "space", "wx"), [LIFTED[0], *full(*LIFTED[1:])])
def test_a_leg_in_the_world_goes_straight_to_its_target_while_the_other_foot_stands(
    script: Script, leg: str, space: int, wx: float
) -> None:
    other = "RLeg" if leg == "LLeg" else "LLeg"
    _shifted(script)
    start, standing = script.position(leg, WORLD), script.pose(other, WORLD)
    change = np.array([0.0, 0.0, 0.02, wx, 0.0, 0.0])
    target = script.position(leg, space) + change
    call = script.nao.post("ALMotion", "positionInterpolations", [leg], space, [[target.tolist()]], [63], [[1.0]], True)
    for tick in range(200):
        share = min((tick + 1) / 100, 1.0)
        script.nao.step(0.01)
        moved = script.position(leg, WORLD) - start
        assert np.abs(moved - share * share * (3.0 - 2.0 * share) * change).max() < 1e-5
        assert np.abs(script.pose(other, WORLD) - standing).max() < 1e-9
    assert call.done()
    assert f"{leg} does not reach" not in script.log()


@pytest.mark.parametrize("leg", ["LLeg", "RLeg"])
def test_a_leg_is_set_to_a_position_in_the_world(script: Script, leg: str) -> None:
    other = "RLeg" if leg == "LLeg" else "LLeg"
    _shifted(script)
    change, standing = np.array([0.01, 0.0, 0.03, 0.05, 0.0, 0.1]), script.pose(other, WORLD)
    target = script.position(leg, WORLD) + change
    script("setPositions", [leg], WORLD, target.tolist(), 0.5, 63)
    script.nao.step(3.0)
    assert np.abs(script.position(leg, WORLD) - target).max() < 1e-6
    assert np.abs(script.pose(other, WORLD) - standing).max() < 1e-9


@pytest.mark.parametrize("space", [WORLD, TORSO])
def test_both_feet_and_the_torso_keep_to_their_paths_seen_from_each_other(script: Script, space: int) -> None:
    before = script.pose("Torso", WORLD)
    legs = [script.pose(leg, WORLD) for leg in ("LLeg", "RLeg")]
    changes = [[[0.01, 0.0, -0.02, 0.0, 0.0, 0.0]], *[[[0.0, 0.0, 0.01, 0.0, 0.0, 0.0]]] * 2]
    names, spaces = ["Torso", "LLeg", "RLeg"], [WORLD, space, space]
    script("positionInterpolations", names, spaces, changes, [63] * 3, [[0.5]] * 3, False)
    up = (before[:3, :3] if space == TORSO else np.eye(3)) @ [0.0, 0.0, 0.01]
    for leg, T in zip(("LLeg", "RLeg"), legs, strict=True):
        expected = T[:3, 3] + up - before[:3, 3] - [0.01, 0.0, -0.02]
        assert np.abs(script.pose("Torso", WORLD)[:3, :3] @ script.pose(leg, TORSO)[:3, 3] - expected).max() < 1e-6


@pytest.mark.parametrize("leg", ["LLeg", "RLeg"])
def test_a_leg_that_moves_with_the_torso_leaves_the_other_foot_in_place(script: Script, leg: str) -> None:
    other = "RLeg" if leg == "LLeg" else "LLeg"
    up = np.array([0.0, 0.0, 0.01, 0.0, 0.0, 0.0])
    standing, foot = script.pose(other, WORLD), script.position(leg, WORLD) + 2.0 * up
    torso = script.position("Torso", WORLD) - up
    paths = [[torso.tolist()], [foot.tolist()]]
    script.nao.post("ALMotion", "positionInterpolations", ["Torso", leg], WORLD, paths, [63, 63], [[1.0], [1.0]], True)
    for _ in range(150):
        script.nao.step(0.01)
        assert np.abs(script.pose(other, WORLD) - standing).max() < 1e-6
    assert np.abs(script.position(leg, WORLD) - foot).max() < 1e-6
    assert np.abs(script.position("Torso", WORLD)[:3] - torso[:3]).max() < 1e-6
