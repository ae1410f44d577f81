"""Checks of configurations: units, masks, names, limits as arrays, and the fast path for plain numbers."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings, strategies as st
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin import rotations
from nao_kin.errors import (
    BadArgument,
    CouplingViolated,
    DegreesWarning,
    NotFinite,
    OutsideLimits,
    UnknownName,
    WrongShape,
)
from nao_kin.robot.semantics import Posture

# --- degrees ----------------------------------------------------------------------------------------------------------


def _poses(nao: nk.NaoModel) -> list:
    return [
        lambda q: nao.fk(q, "LArm"),
        lambda q: nao.fk(q),
        lambda q: nao.fk(q, ["Head"], reference="LLeg"),
        lambda q: nao.rotation(q, "LArm"),
        lambda q: nao.position(q, "LArm"),
        lambda q: nao.jacobian(q, "LArm"),
        lambda q: nao.com(q),
    ]


@pytest.mark.parametrize("shape", [(), (40,), (2, 2)])
@pytest.mark.parametrize("kind", [np.asarray, np.float32, np.ndarray.tolist])
def test_degrees_in_place_of_radians_are_warned_of(nao: nk.NaoModel, shape: tuple[int, ...], kind) -> None:
    q = nao.random(0, shape)
    q[(*(0 for _ in shape), 5)] = 45.0
    for call in _poses(nao):
        with pytest.warns(DegreesWarning, match=r"= 45 rad is more than a full turn; .* np\.deg2rad\(q\)") as caught:
            call(kind(q))
        assert len(caught) == 1
        assert caught[0].filename == __file__
        assert nao.joint_names[5] in str(caught[0].message)


def test_a_call_in_a_loop_warns_once(nao: nk.NaoModel) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        for angle in (10.0, 20.0, 30.0):
            nao.fk(np.full(25, angle), "LArm")
        nao.fk(np.full(25, 10.0), "LArm")
    assert len([w for w in caught if "HeadYaw = 10 rad" in str(w.message)]) == 2  # one for each of the two lines
    assert len(caught) == 2
    assert {w.lineno for w in caught} != {caught[0].lineno}


def test_what_may_turn_that_far_is_not_taken_for_degrees(tmp_path: Path) -> None:
    robot = made_up(
        tmp_path,
        J("free", kind="continuous"),
        J("wide", limits=(-20.0, 20.0)),
        J("slide", kind="prismatic"),
        J("bound"),
    )
    robot.fk([100.0, 15.0, 50.0, 6.0], "bound_l")  # no more than a turn outside is no sign of degrees
    for q, joint in (([0.0, 30.0, 0.0, 0.0], "wide"), ([0.0, 0.0, 0.0, -6.4], "bound")):
        with pytest.warns(DegreesWarning, match=f"^{joint} ="):
            robot.fk(q, "bound_l")


def test_a_joint_at_a_limit_of_a_full_turn_is_not_taken_for_degrees(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("shoulder", limits=(-6.28318530718, 6.28318530718)))  # a UR5's
    for q in (robot.upper + 1e-12, robot.lower - 9e-7):
        assert robot.within_limits(q)
        robot.fk(q, "shoulder_l")
    with pytest.warns(DegreesWarning, match=r"^shoulder = 6\.2832 rad"):
        robot.fk(robot.upper + 1.5e-5, "shoulder_l")


def test_whoever_looks_at_the_limits_needs_no_warning(nao: nk.NaoModel) -> None:
    q = np.full((2, 25), 45.0)
    assert not nao.within_limits(q).any()
    assert nao.limit_violations(q)
    nao.clamp(q)
    nao.angles(q)
    with pytest.raises(OutsideLimits):
        nao.fk(nao.configuration({"HeadYaw": 45.0}, limits="ignore") * 0 + 45.0, "Head", limits="enforce")


# --- masks, names, rows -----------------------------------------------------------------------------------------------


def test_masked_entries_are_refused(nao: nk.NaoModel) -> None:
    q = np.ma.array(nao.neutral(), mask=False)
    assert np.array_equal(nao.fk(q, "LArm"), nao.fk(nao.neutral(), "LArm"))
    q[3] = np.ma.masked
    for call in (lambda: nao.fk(q, "LArm"), lambda: nao.check_limits(q), lambda: nk.rotations.exp(q[2:5])):
        with pytest.raises(BadArgument, match=r"has masked entries; fill them first"):
            call()


def test_the_row_of_a_batch_whose_hips_disagree_is_named(nao: nk.NaoModel) -> None:
    body = nao.to_body(nao.random(0, (4, 5)))
    body[2, 3, nao.body_order.index("RHipYawPitch")] += 0.1
    body[3, 0, nao.body_order.index("RHipYawPitch")] += 0.2
    with pytest.raises(CouplingViolated, match=r"\(configuration 2, 3\)$") as caught:
        nao.from_body(body)
    assert caught.value.index == (2, 3)
    assert caught.value.mimic_value == body[2, 3, nao.body_order.index("RHipYawPitch")]


# --- limits as arrays -------------------------------------------------------------------------------------------------


def test_the_mask_of_a_batch_says_what_the_rows_say(nao: nk.NaoModel) -> None:
    rng = np.random.default_rng(0)
    q = nao.random(rng, (40, 50)) + rng.choice([0.0, 0.3], (40, 50, 25), p=[0.98, 0.02])
    joints, inside = nao.within_limits(q, per_joint=True), nao.within_limits(q)
    assert joints.shape == (40, 50, 25)
    assert np.array_equal(inside, joints.all(axis=-1))
    expected = np.ones_like(joints)
    for violation in nao.limit_violations(q):
        expected[(*violation.index, nao.joint_names.index(violation.joint))] = False
    assert np.array_equal(joints, expected)
    assert 0 < inside.sum() < inside.size
    assert (~joints).any(axis=(0, 1))[nao.joint_names.index("HeadPitch")]  # by its table, too
    assert nao.within_limits(nao.posture("Stand")).shape == ()


def test_as_many_rows_of_violations_as_asked_for(nao: nk.NaoModel) -> None:
    q = np.full((1000, 25), 3.0)
    assert {violation.index for violation in nao.limit_violations(q, max_configurations=2)} == {(0,), (1,)}
    assert nao.limit_violations(q, max_configurations=0) == ()


# --- couplings --------------------------------------------------------------------------------------------------------


def test_a_follower_shares_its_speed_limit_by_its_multiplier(tmp_path: Path) -> None:
    for multiplier in (-4.0, 0.25):
        robot = made_up(tmp_path, J("a"), J("b", follows=("a", multiplier, 0.0), limits=(-30.0, 30.0)))
        assert robot.velocity_limits[0] == pytest.approx(min(2.0, 2.0 / abs(multiplier)))


@pytest.mark.parametrize("difference", [1.1e-6, -1.1e-6, 1e-4, 1e-3])
def test_joints_of_one_motor_agree_to_single_precision(nao: nk.NaoModel, difference: float) -> None:
    for values in ([0.1, 0.1 + difference], [np.array([0.1]), np.array([0.1 + difference])]):
        with pytest.raises(CouplingViolated):
            nao.configuration({"LHipYawPitch": values[0], "RHipYawPitch": values[1]})
    nao.configuration({"LHipYawPitch": 0.1, "RHipYawPitch": 0.1 + 0.9e-6 * math.copysign(1.0, difference)})


@pytest.mark.parametrize("multiplier", [4.0, -4.0, 0.25])
def test_a_follower_agrees_to_single_precision_of_its_own_value(tmp_path: Path, multiplier: float) -> None:
    robot = made_up(tmp_path, J("a"), J("b", follows=("a", multiplier, 0.5), limits=(-30.0, 30.0)))
    expected = multiplier * 0.1 + 0.5
    for number in (float, np.array, lambda value: np.array([value])):
        for names in (("a", "b"), ("b", "a")):
            for miss in (1.1e-6, -1.1e-6):
                values = {"a": number(0.1), "b": number(expected + miss)}
                with pytest.raises(CouplingViolated):
                    robot.configuration({name: values[name] for name in names})
                values["b"] = number(expected + 0.8 * miss)
                assert robot.configuration({name: values[name] for name in names}).ravel().tolist() == [0.1]


# --- the quick way ----------------------------------------------------------------------------------------------------

_JOINTS = nk.load_nao().joint_names


@settings(max_examples=100, deadline=None)
@given(
    st.dictionaries(
        st.sampled_from(
            (*_JOINTS, "RHipYawPitch", "LHandFinger11", "HeadPitch", "HeadYaw", "LAnkleRoll", "LAnklePitch")
        ),
        st.one_of(st.floats(-0.6, 0.6), st.floats(-3.0, 3.0), st.integers(-2, 2), st.just(math.nan), st.just(1e400)),
        max_size=6,
    ),
    st.sampled_from(["enforce", "clamp", "ignore"]),
)
def test_plain_numbers_take_the_same_way_as_arrays(angles: dict[str, float], limits: str) -> None:
    nao = nk.load_nao()

    def answer(values: object) -> object:
        try:
            return np.atleast_2d(nao.configuration(values, limits=limits)).tolist()  # type: ignore[arg-type]
        except nk.NaoKinError as error:
            return type(error), str(error).replace(" (configuration 0)", "").replace(" at index [0]", "")

    assert answer(angles) == answer({name: np.array([value], dtype=np.float64) for name, value in angles.items()})


def test_plain_numbers_face_either_bound(nao: nk.NaoModel) -> None:
    for name, lower, upper in zip(nao.joint_names, nao.lower.tolist(), nao.upper.tolist(), strict=True):
        for bound, outwards in ((lower, -1.0), (upper, 1.0)):
            for miss in (2e-6, 0.01, 3.0):
                with pytest.raises(OutsideLimits, match=name):
                    nao.configuration({name: bound + outwards * miss})


def test_not_a_number_is_named_on_every_way(nao: nk.NaoModel) -> None:
    q = nao.neutral()
    for value in (math.nan, math.inf, -math.inf):
        q[7] = value
        for shaped in (q, q[None], q.tolist(), np.tile(q, (200, 1))):
            with pytest.raises(NotFinite, match=nao.joint_names[7]):
                nao.fk(shaped, "LArm")
        with pytest.raises(NotFinite, match="HeadYaw"):
            nao.configuration({"HeadYaw": value}, limits="ignore")
    # Squares that overflow hide nothing, and are not taken for infinity.
    large = np.zeros((200, 25))
    large[150, 3] = 1e200
    with pytest.warns(DegreesWarning):
        nao.fk(large, "LArm")
    large[151, 4] = math.nan
    with pytest.raises(NotFinite, match=r"index \[151, 4\]"):
        nao.fk(large, "LArm")


def test_a_posture_takes_other_values_for_some_joints(nao: nk.NaoModel) -> None:
    stand = nao.angles(nao.posture("Stand"))
    turned = nao.angles(nao.posture("Stand", HeadYaw=0.3, RHipYawPitch=-0.1))
    assert turned == stand | {"HeadYaw": 0.3, "LHipYawPitch": -0.1}
    assert np.array_equal(nao.posture("Stand", {"HeadYaw": 0.3}), nao.posture("Stand", HeadYaw=0.3))
    assert np.array_equal(nao.posture("Stand", {"HeadYaw": 0.1}, HeadYaw=0.3), nao.posture("Stand", HeadYaw=0.3))


def test_a_posture_with_many_values_is_many_configurations(nao: nk.NaoModel) -> None:
    q = nao.posture("Stand", HeadYaw=[-0.3, 0.0, 0.3], LArm=[1.4, 0.2, -1.2, -0.4, 0.0, 0.5])
    assert q.shape == (3, 25)
    assert nao.angles(q)["HeadYaw"].tolist() == [-0.3, 0.0, 0.3]
    assert nao.angles(q)["LElbowRoll"].tolist() == [-0.4] * 3


def test_other_values_leave_the_posture_and_a_floating_base_alone() -> None:
    nao = nk.load_nao(base="floating")
    before = nao.posture("Sit")
    q = nao.posture("Sit", HeadYaw=0.3)
    assert np.flatnonzero(q != before).tolist() == [7 + nao.joint_names.index("HeadYaw")]
    assert np.array_equal(nao.posture("Sit"), before)


def test_only_the_limits_of_named_joints_are_checked(nao: nk.NaoModel) -> None:
    stretched = {"Stretched": Posture({"HeadPitch": 0.4})}
    robot = nk.RobotModel(nao.tree, replace(nao.semantics, start="", postures=stretched))
    for make in (robot.configuration, lambda given: robot.posture("Stretched", given)):
        assert robot.angles(make({"HeadYaw": 0.3}))["LElbowRoll"] == 0.0  # outside, and not named
        with pytest.raises(OutsideLimits, match="LElbowRoll = 0 not in"):
            make({"LElbowRoll": 0.0})
    # The range of HeadPitch depends on HeadYaw, and so counts too.
    with pytest.raises(OutsideLimits, match="HeadPitch = 0.4 not in"):
        robot.posture("Stretched", HeadYaw=1.2)
    clamped = robot.posture("Stretched", HeadYaw=1.2, limits="clamp")
    outside = {violation.joint for violation in robot.limit_violations(clamped)}
    assert outside == {"LElbowRoll", "RElbowRoll"}


def test_a_posture_with_other_values_faces_the_limits_of_those(nao: nk.NaoModel) -> None:
    with pytest.raises(OutsideLimits, match="HeadYaw = 3 not in"):
        nao.posture("Stand", HeadYaw=3.0)
    # The range of HeadPitch depends on HeadYaw.
    low = nao.posture("Stand", HeadPitch=0.5)
    with pytest.raises(OutsideLimits, match="HeadPitch"):
        nao.posture("Stand", {**nao.angles(low), "HeadYaw": 1.2})
    clamped = nao.posture("Stand", HeadYaw=3.0, limits="clamp")
    assert nao.angles(clamped)["HeadYaw"] == nao.upper[nao.joint_names.index("HeadYaw")]
    assert nao.angles(nao.posture("Stand", HeadYaw=3.0, limits="ignore"))["HeadYaw"] == 3.0


def test_a_chain_stands_for_its_joints(nao: nk.NaoModel) -> None:
    values = [-0.1, 0.02, -0.3, 0.7, -0.35, 0.01]
    for side in "LR":
        leg = nao.chains[f"{side}Leg"]
        one = nao.configuration({f"{side}Leg": values, "HeadYaw": 0.2})
        assert np.array_equal(one, nao.configuration({"HeadYaw": 0.2, **dict(zip(leg, values, strict=True))}))
    many = nao.configuration({"LLeg": [values, values], "HeadYaw": 0.2})
    assert np.array_equal(many, np.stack([nao.configuration({"LLeg": values, "HeadYaw": 0.2})] * 2))


def test_chains_that_contradict_are_refused(nao: nk.NaoModel) -> None:
    arm = [1.4, 0.2, -1.2, -0.4, 0.0, 0.5]
    with pytest.raises(WrongShape, match=r"LArm \(LShoulderPitch, .*, LHand\) must have shape \(\.\.\., 6\)"):
        nao.configuration({"LArm": arm[:5]})
    with pytest.raises(BadArgument, match="LHand is given twice"):
        nao.configuration({"LArm": arm, "LHand": 0.5})
    with pytest.raises(CouplingViolated):
        nao.configuration({"LLeg": [-0.1, 0, 0, 0, 0, 0], "RLeg": [-0.2, 0, 0, 0, 0, 0]})
    with pytest.raises(UnknownName, match=r"nearest: LArm"):
        nao.configuration({"LArn": arm})


def test_a_data_frame_gives_the_values_of_its_columns(nao: nk.NaoModel) -> None:
    class Frame:  # what pandas' and polars' have in common
        def __init__(self, table: dict[str, list[float]]) -> None:
            self.columns, self._table = list(table), table

        def __getitem__(self, name: str) -> list[float]:
            return self._table[name]

    table = {"HeadYaw": [0.1, 0.2], "LHipYawPitch": [-0.1, -0.2], "RHipYawPitch": [-0.1, -0.2]}
    expected = nao.configuration(table)
    assert np.array_equal(nao.configuration(Frame(table)), expected)
    assert np.array_equal(nao.configuration(Frame(table | {"time": [0.0, 1.0]}), ignore_other=True), expected)
    assert np.array_equal(nao.posture("Stand", Frame(table)), nao.posture("Stand", table))
    with pytest.raises(UnknownName, match="HeadYow"):
        nao.configuration(Frame({"HeadYow": [0.0]}))
    twice = Frame(table)
    twice.columns.append("HeadYaw")
    with pytest.raises(BadArgument, match="column 'HeadYaw' of the data frame occurs twice"):
        nao.configuration(twice)

    class Row:  # a series of pandas
        def __init__(self, values: dict[Any, float]) -> None:
            self._values, self.keys = values, values.keys

        def __getitem__(self, name: str) -> float:
            return self._values[name]

    row = {name: values[0] for name, values in table.items()}
    assert np.array_equal(nao.configuration(Row(row)), expected[0])
    with pytest.raises(UnknownName, match="0"):
        nao.configuration(Row({0: 0.1}))


def test_degrees_go_in_and_out_for_turning_joints_alone(nao: nk.NaoModel) -> None:
    q = nao.configuration({"HeadYaw": 30.0, "LHand": 0.5, "RHipYawPitch": -10.0}, limits="ignore", degrees=True)
    expected = {"HeadYaw": np.radians(30.0), "LHand": 0.5, "LHipYawPitch": np.radians(-10.0)}
    np.testing.assert_allclose(q, nao.configuration(expected, limits="ignore"), rtol=0, atol=1e-16)
    back = nao.angles(q, degrees=True)
    assert (back["HeadYaw"], back["LHand"], back["LHipYawPitch"]) == pytest.approx((30.0, 0.5, -10.0), abs=1e-13)
    chain = nao.configuration({"LArm": [[60.0, 10.0, -80.0, -40.0, 5.0, 0.3]] * 2, "RElbowRoll": 40.0}, degrees=True)
    assert nao.angles(chain, degrees=True)["LShoulderPitch"] == pytest.approx([60.0, 60.0], abs=1e-13)
    assert nao.angles(chain)["LHand"].tolist() == [0.3, 0.3]
    with pytest.raises(OutsideLimits, match="HeadYaw"):
        nao.configuration({"HeadYaw": 130.0}, degrees=True)
    with pytest.raises(BadArgument, match="HeadYaw"):
        nao.configuration({"HeadYaw": "thirty"}, degrees=True)


def test_joint_values_of_a_mimic_with_an_offset_are_taken_in_degrees_before_the_coupling(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("a"), J("b", follows=("a", -2.0, 0.5)))
    q = robot.configuration({"b": np.degrees(0.1)}, degrees=True)
    assert q == pytest.approx([(0.1 - 0.5) / -2.0], abs=1e-15)


# --- Euler angles of a floating base --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["v6", "romeo"])
def test_roll_pitch_and_yaw_of_a_floating_base_are_those_of_pinocchio_and_lead_back(name: str) -> None:
    """The recipe of the documentation, also at gimbal lock and beside it, and its rates by differences."""
    robot = nk.load_nao(base="floating") if name == "v6" else nk.load_robot(name, base="floating")
    rng = np.random.default_rng(0)
    rpy = rng.uniform(-3.0, 3.0, (60, 3)) * [1.0, 0.5, 1.0]
    rpy[:20, 1] = np.pi / 2 * np.sign(rpy[:20, 1]) + np.repeat([0.0, 1e-12, -1e-8, 1e-4], 5)
    x = np.concatenate([rng.normal(size=(60, 3)), rpy, robot.random(rng, 60)[:, 7:]], axis=-1)

    def from_angles(x: np.ndarray) -> np.ndarray:
        quaternion = rotations.quat_from_euler(x[..., 3:6], "xyz", axes="fixed")
        return np.concatenate([x[..., :3], rotations.quat_to_xyzw(quaternion), x[..., 6:]], axis=-1)

    q = from_angles(x)
    again = np.concatenate([robot.fk(q, robot.tree.root, as_="rpy"), q[..., 7:]], axis=-1)
    for row, wanted, found in zip(q, x, again, strict=True):
        R = pin.rpy.rpyToMatrix(wanted[3:6])
        np.testing.assert_allclose(pin.Quaternion(row[3:7]).matrix(), R, rtol=0, atol=1e-15)
        np.testing.assert_allclose(pin.rpy.rpyToMatrix(found[3:6]), R, rtol=0, atol=2e-15)
    np.testing.assert_allclose(robot.fk(from_angles(again)), robot.fk(q), rtol=0, atol=1e-14)
    np.testing.assert_array_equal(again[:5, 5], 0.0)  # at lock, yaw is zero
    np.testing.assert_allclose(again[20:], x[20:], rtol=0, atol=1e-13)
    rates, h = rng.normal(size=(60, robot.nv)), 1e-6
    J = rotations.euler_rate_jacobian(x[:, 3:6], "xyz", axes="fixed", expressed_in="moving")
    R = robot.rotation(q, robot.tree.root)
    v = rates.copy()
    v[:, :3] = np.einsum("nji,nj->ni", R, rates[:, :3])
    v[:, 3:6] = np.einsum("nij,nj->ni", J, rates[:, 3:6])
    for before, after, row in zip(from_angles(x - h * rates), from_angles(x + h * rates), v, strict=True):
        np.testing.assert_allclose(pin.difference(robot.model, before, after) / (2 * h), row, rtol=0, atol=1e-7)
