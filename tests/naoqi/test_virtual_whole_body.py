"""Whole-body control of the virtual NAO: feet that stay, a centre of mass above them, effectors that are held."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from loops import full
from naoqi_script import ROBOT, TORSO, WORLD, Script
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from nao_kin.naoqi.virtual import Call, NaoqiError

SENSORS = ("FrontLeft", "FrontRight", "RearLeft", "RearRight")


class Balancing(Script):
    """A script that looks at the centre of mass and at what supports it."""

    def com(self) -> np.ndarray:
        return np.array(self("getCOM", "Body", WORLD, True))[:2]

    def soles(self, *feet: str) -> np.ndarray:
        """The pressure sensors of feet on the floor, shape (n, 2)."""
        frames = [f"{foot[0]}Foot/FSR/{sensor}" for foot in feet for sensor in SENSORS]
        T = self.torso() @ self.nao.robot.fk(self.nao.joints.q(), frames)
        return T[:, :2, 3]

    def inside(self, *feet: str) -> float:
        """How far the centre of mass is inside the hull of these soles, by scipy [m]."""
        planes = ConvexHull(self.soles(*feet)).equations
        return float(-(planes[:, :2] @ self.com() + planes[:, 2]).max())

    def wait(self, call: Call, least: float = -1.0, *feet: str) -> float:
        """Let time pass until a call is over; check that both soles stay, and optionally the centre of mass."""
        begin, soles = self.nao.clock.now, self.feet()
        while not call.done():
            self.nao.step(0.02)
            assert np.abs(self.feet() - soles).max() < 1e-6
            assert self.nao.robot.within_limits(self.nao.joints.q()).all()
            assert not feet or self.inside(*feet) > least
        call.result()
        return self.nao.clock.now - begin


@pytest.fixture
def script() -> Iterator[Balancing]:
    with Balancing() as made:
        made("moveInit")
        yield made


@pytest.mark.parametrize(("support", "feet"), [("LLeg", ("LLeg",)), ("RLeg", ("RLeg",)), ("Legs", ("LLeg", "RLeg"))])
def test_the_centre_of_mass_goes_above_the_middle_of_what_supports_it(
    script: Balancing, support: str, feet: tuple[str, ...]
) -> None:
    script("wbEnable", True)
    time = script.wait(script.nao.post("ALMotion", "wbGoToBalance", support, 1.0))
    assert time == pytest.approx(1.0, abs=0.011)
    assert np.abs(script.com() - script.soles(*feet).mean(axis=0)).max() < 1e-6


def test_going_to_balance_tells_whether_it_is_there(script: Balancing) -> None:
    assert script("wbGoToBalance", "LLeg", 0.6) is True
    going = script.nao.post("ALMotion", "wbGoToBalance", "RLeg", 1.0)
    script.nao.step(0.1)
    script("killAll")
    assert going.result(0) is False
    script("setStiffnesses", "RArm", 0.0)
    assert script("wbGoToBalance", "RLeg", 0.5) is False


def test_a_foot_that_is_free_is_moved_in_balance_on_the_other(script: Balancing) -> None:
    script("wbEnable", True)
    script("wbGoToBalance", "LLeg", 1.0)
    script("wbFootState", "Free", "RLeg")
    script("wbEnableBalanceConstraint", True, "LLeg")
    start, standing = script.position("RLeg", WORLD), script.feet()[0]
    path = [[-0.04, 0.0, 0.03, 0.0, 0.0, 0.0], [0.05, 0.0, 0.03, 0.0, 0.0, 0.0]]
    call = script.nao.post("ALMotion", "positionInterpolation", "RLeg", WORLD, path, 63, [0.6, 1.2], False)
    while not call.done():
        script.nao.step(0.05)
        assert script.inside("LLeg") > 0.004
        assert np.abs(script.feet()[0] - standing).max() < 1e-6
    assert np.abs(script.position("RLeg", WORLD) - start - path[1]).max() < 1e-6


def test_a_kick_with_one_foot_and_then_with_the_other_moves_both(script: Balancing) -> None:
    """The calls of Aldebaran's example wbKick: the foot that kicked first is still "Free" when it must stand."""
    script("wbEnable", True)
    script("wbFootState", "Fixed", "Legs")
    script("wbEnableBalanceConstraint", True, "Legs")
    for support, kicking in (("LLeg", "RLeg"), ("RLeg", "LLeg")):
        assert script("wbGoToBalance", support, 1.0) is True
        script("wbFootState", "Free", kicking)
        start = script.position(kicking, WORLD)
        path = [[0.03, 0.0, 0.03, 0.0, 0.0, 0.0], [0.0] * 6]
        call = script.nao.post(
            "ALMotion", "positionInterpolations", [kicking], WORLD, [path], [63], [[0.6, 1.2]], False
        )
        script.nao.step(0.6)
        assert np.abs(script.position(kicking, WORLD) - start - path[0]).max() < 2e-3
        script.nao.step(0.7)
        assert call.done()
    assert "no foot stands" not in script.log()


def test_there_is_no_balance_on_a_foot_in_the_air(script: Balancing) -> None:
    script("wbEnable", True)
    assert script("wbGoToBalance", "LLeg", 1.0) is True
    script("wbFootState", "Free", "RLeg")
    script("positionInterpolation", "RLeg", WORLD, [0.0, 0.0, 0.02, 0.0, 0.0, 0.0], 63, 0.5, False)
    assert script("wbGoToBalance", "RLeg", 1.0) is False
    assert "RLeg is above the floor" in script.log()


def test_a_hand_that_is_too_far_for_its_arm_is_taken_there_by_the_body(script: Balancing) -> None:
    target = script.position("LArm", ROBOT)
    target[:3] = 0.24, 0.12, 0.3
    script("positionInterpolations", "LArm", ROBOT, target.tolist(), 7, 1.0)
    alone = np.linalg.norm(script.position("LArm", ROBOT)[:3] - target[:3])
    assert alone > 0.01
    script("wbEnable", True)
    script("wbFootState", "Fixed", "Legs")
    script("wbEnableBalanceConstraint", True, "Legs")
    call = script.nao.post("ALMotion", "positionInterpolations", "LArm", ROBOT, target.tolist(), 7, 2.0)
    assert script.wait(call, 0.004, "LLeg", "RLeg") == pytest.approx(2.0, abs=0.021)
    assert np.abs(script.position("LArm", ROBOT)[:3] - target[:3]).max() < 1e-5


@pytest.mark.parametrize(
    ("effector", "space", "time"),
    [
        ("RArm", ROBOT, 0.1),
        *full(("LArm", WORLD, 0.1), ("Head", WORLD, 0.1), ("RLeg", WORLD, 0.2), ("Torso", ROBOT, 0.1)),
    ],
)
def test_every_axis_mask_is_met_in_balance(script: Balancing, effector: str, space: int, time: float) -> None:
    """With both feet in place the shared hip motor leaves the torso x, z and wy."""
    script("wbEnable", True)
    feet = ("LLeg",) if effector == "RLeg" else ("LLeg", "RLeg")
    if effector == "RLeg":
        script("wbGoToBalance", "LLeg", 0.6)
        script("wbFootState", "Free", effector)
        script("positionInterpolation", effector, WORLD, [0.0, 0.0, 0.02, 0.0, 0.0, 0.0], 63, 0.4, False)
    script("wbEnableBalanceConstraint", True, "LLeg" if effector == "RLeg" else "Legs")
    start, soles = np.array(script("getTransform", effector, space, True)).reshape(4, 4), script.feet()[: len(feet)]
    change = np.array([0.004, 0.003, 0.005, 0.015, 0.02, 0.01])
    if effector == "Torso":
        change[[1, 3, 5]] = 0.0
    for mask in range(1, 64):
        T = start.copy()
        T[:3, 3] += change[:3] if mask % 2 else -change[:3]
        T[:3, :3] = Rotation.from_rotvec(change[3:] if mask % 2 else -change[3:]).as_matrix() @ T[:3, :3]
        script("transformInterpolations", effector, space, T.ravel().tolist(), mask, time)
        found = np.array(script("getTransform", effector, space, True)).reshape(4, 4)
        turn = Rotation.from_matrix(T[:3, :3] @ found[:3, :3].T).as_rotvec()
        errors = np.concatenate([(T - found)[:3, 3], turn])[[bit for bit in range(6) if mask >> bit & 1]]
        assert np.abs(errors).max() < 1e-4, mask
        assert np.abs(script.feet()[: len(feet)] - soles).max() < 1e-6
        assert script.inside(*feet) > 0.004
    assert "does not reach" not in script.log()


@pytest.mark.parametrize("mask", [5, 7, 56])
def test_a_hand_that_moves_in_the_torso_does_not_move_the_torso(script: Balancing, mask: int) -> None:
    script("wbEnable", True)
    script("wbEnableBalanceConstraint", True, "Legs")
    torso, change = script.torso(), np.array([0.02, 0.01, 0.02, 0.1, 0.1, 0.0])
    wanted = script.position("LArm", TORSO) + change
    script("positionInterpolations", "LArm", TORSO, wanted.tolist(), mask, 0.5)
    used = [mask >> bit & 1 == 1 for bit in range(6)]
    assert np.abs(script.position("LArm", TORSO) - wanted)[used].max() < 1e-5
    assert np.abs(script.torso() - torso).max() < 1e-5


@pytest.mark.full
def test_balance_comes_before_what_is_out_of_reach(script: Balancing) -> None:
    script("wbEnable", True)
    script("wbEnableBalanceConstraint", True, "Legs")
    call = script.nao.post("ALMotion", "positionInterpolations", "RArm", ROBOT, [0.6, -0.1, 0.3, 0, 0, 0], 7, 2.0)
    script.wait(call, 0.004, "LLeg", "RLeg")
    assert "RArm does not reach its target" in script.log()


def test_the_head_is_held_in_its_rotation_and_goes_where_it_is_told(script: Balancing) -> None:
    soles = script.feet()
    script("wbEnableEffectorControl", "Head", True)
    before = script.position("Head", ROBOT)
    script.nao.step(0.5)
    assert np.abs(script.position("Head", ROBOT)[3:] - before[3:]).max() < 1e-6
    script("wbSetEffectorControl", "Head", [0.1, 0.2, 0.5])
    script.nao.step(2.0)
    found = Rotation.from_euler("xyz", script.position("Head", ROBOT)[3:])
    assert (found.inv() * Rotation.from_euler("xyz", [0.1, 0.2, 0.5])).magnitude() < 1e-5
    assert np.abs(script.feet() - soles).max() < 1e-6
    assert script.inside("LLeg", "RLeg") > 0.004


def test_hands_are_held_beside_each_other_until_they_are_let_go(script: Balancing) -> None:
    goals = {"LArm": [0.17, 0.1, 0.3], "RArm": [0.15, -0.12, 0.28]}
    for arm in goals:
        script("wbEnableEffectorControl", arm, True)
    for arm, goal in goals.items():
        script("wbSetEffectorControl", arm, goal)
    speeds, before = [], script.position("LArm", ROBOT)[:3]
    for _ in range(200):
        script.nao.step(0.01)
        now = script.position("LArm", ROBOT)[:3]
        speeds.append(np.linalg.norm(now - before) / 0.01)
        before = now
    for arm, goal in goals.items():
        assert np.abs(script.position(arm, ROBOT)[:3] - goal).max() < 1e-5
    assert max(speeds) < 0.21
    script("wbEnableEffectorControl", "LArm", False)
    assert len(script("getTaskList")) == 1
    script("wbEnableEffectorControl", "RArm", False)
    assert script("getTaskList") == []


def test_switching_off_forgets_all(script: Balancing) -> None:
    script("wbEnableEffectorControl", "Head", True)
    script("wbFootState", "Free", "Legs")
    script("wbEnable", False)
    assert script("getTaskList") == []
    with pytest.raises(NaoqiError, match="Head is not held"):
        script("wbSetEffectorControl", "Head", [0.0, 0.0, 0.0])
    # Without it, an arm moves alone again.
    legs = script("getAngles", "Legs", True)
    script("positionInterpolations", "LArm", TORSO, [0.15, 0.12, 0.06, 0, 0, 0], 7, 0.5)
    assert script("getAngles", "Legs", True) == legs


def test_a_later_task_takes_an_arm_from_what_is_held(script: Balancing) -> None:
    script("wbEnableEffectorControl", "Head", True)
    script("angleInterpolation", "RShoulderPitch", 0.5, 0.5, True)
    assert script("getAngles", "RShoulderPitch", True) == pytest.approx([0.5], abs=1e-9)
    script("wbSetEffectorControl", "Head", [0.0, 0.2, 0.3])
    script.nao.step(1.0)
    assert script("getAngles", "RShoulderPitch", True) == pytest.approx([0.5], abs=1e-9)
    assert script.position("Head", TORSO)[5] == pytest.approx(0.3, abs=0.05)


def test_a_leg_may_be_optimized_as_in_aldebarans_kick(script: Balancing) -> None:
    for effector in ("RLeg", "Torso", "Com"):
        assert script("wbEnableEffectorOptimization", effector, False) is None


def test_a_robot_that_sits_has_nothing_to_balance_on() -> None:
    script = Script("Sit")
    for name, *rest in (("wbGoToBalance", "Legs", 1.0), ("wbEnableEffectorControl", "Head", True)):
        with pytest.raises(NaoqiError, match="does not stand on its feet"):
            script(name, *rest)
    script.nao.close()
