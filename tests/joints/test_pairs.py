from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, strategies as st
from loops import for_all

from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.joints import ANATOMY, KINEMATIC_PAIRS, NAO_ANATOMY, kinematic_pair, mobility
from nao_kin.joints.tables import anatomical_kind, body_part
from nao_kin.robot.nao.tables import JOINTS

FREEDOMS = {
    "revolute": 1,
    "prismatic": 1,
    "helical": 1,
    "cylindrical": 2,
    "universal": 2,
    "condyloid": 2,
    "spherical": 3,
    "planar": 3,
    "free": 6,
}
OBLIQUE = np.array([[1.0, 2.0, -2.0], [2.0, 1.0, 2.0]]) / 3.0


def axes_of(name: str) -> np.ndarray | tuple[()]:
    count = KINEMATIC_PAIRS[name].axes
    return OBLIQUE[:count] if count else ()


def pitch_of(name: str) -> float | None:
    return 0.25 if name == "helical" else None


def moved(joint: pin.JointModel, rng: np.random.Generator) -> pin.SE3:
    """Return the pose of the joint's body in a random configuration."""
    model = pin.Model()
    model.addJoint(0, joint, pin.SE3.Identity(), "joint")
    data = model.createData()
    pin.forwardKinematics(model, data, pin.integrate(model, pin.neutral(model), rng.uniform(-2, 2, model.nv)))
    return data.oMi[1]


# --- the pairs --------------------------------------------------------------------------------------------------------


@for_all("name", FREEDOMS)
def test_freedoms_and_constraints_of_a_pair_make_six(name) -> None:
    pair = kinematic_pair(name)
    assert pair.freedoms == FREEDOMS[name]
    assert pair.freedoms + pair.constraints == 6


def test_reuleaux_knew_six_lower_pairs() -> None:
    assert "".join(sorted(pair.symbol for pair in KINEMATIC_PAIRS.values() if pair.lower)) == "CEHPRS"


@for_all("name", FREEDOMS)
def test_pinocchio_joint_has_the_freedoms_of_its_pair(name) -> None:
    pair = KINEMATIC_PAIRS[name]
    joint = pair.joint_model(axes_of(name), pitch=pitch_of(name))
    assert joint.nv == pair.freedoms
    assert joint.shortname() in pair.pinocchio
    model = pin.Model()
    model.addJoint(0, joint, pin.SE3.Identity(), "joint")
    q = pin.integrate(model, pin.neutral(model), np.linspace(0.3, 0.9, model.nv))
    motion = pin.computeJointJacobian(model, model.createData(), q, 1)
    assert np.linalg.matrix_rank(motion) == pair.freedoms
    turning = np.linalg.matrix_rank(motion[3:], tol=1e-9)
    assert turning == pair.rotations


@for_all("name", ["revolute", "cylindrical", "helical", "prismatic"])
def test_one_axis_stays_where_it_is(name) -> None:
    axis = OBLIQUE[0]
    pose = moved(KINEMATIC_PAIRS[name].joint_model(axis, pitch=pitch_of(name)), np.random.default_rng(1))
    assert np.allclose(pose.rotation @ axis, axis, rtol=0, atol=1e-14)
    assert np.allclose(np.cross(pose.translation, axis), 0, atol=1e-14)
    turned, slid = not np.allclose(pose.rotation, np.eye(3)), np.linalg.norm(pose.translation) > 1e-3
    assert turned == (name != "prismatic")
    assert slid == (name != "revolute")


def test_a_helical_joint_advances_by_its_pitch() -> None:
    pose = moved(KINEMATIC_PAIRS["helical"].joint_model(OBLIQUE[0], pitch=0.25), np.random.default_rng(1))
    assert pin.log3(pose.rotation) @ OBLIQUE[0] * 0.25 == pytest.approx(pose.translation @ OBLIQUE[0], abs=1e-14)


@for_all("name", ["universal", "condyloid", "spherical"])
def test_the_centre_of_a_turning_joint_stays_where_it_is(name) -> None:
    pose = moved(KINEMATIC_PAIRS[name].joint_model(axes_of(name)), np.random.default_rng(2))
    assert np.array_equal(pose.translation, np.zeros(3))


@for_all("normal", [(0, 0, 1), (0, 0, -1), (1, 2, -2)])
def test_a_planar_joint_stays_in_its_plane(normal) -> None:
    n = np.array(normal) / np.linalg.norm(normal)
    joint = KINEMATIC_PAIRS["planar"].joint_model(normal)
    assert joint.shortname() == ("JointModelPlanar" if normal == (0, 0, 1) else "JointModelComposite")
    pose = moved(joint, np.random.default_rng(3))
    assert np.allclose(pose.rotation @ n, n, rtol=0, atol=1e-14)
    assert abs(pose.translation @ n) < 1e-14
    assert np.linalg.norm(pose.translation) > 0.1
    assert pin.log3(pose.rotation) @ n != 0


def test_a_universal_joint_turns_about_the_carried_second_axis_at_any_angle_between_them() -> None:
    for second in ([0, 1, 0], [0, 1, 1], [0, 1, 50]):
        axes = np.array([[0, 0, 1.0], second])
        model = pin.Model()
        model.addJoint(0, KINEMATIC_PAIRS["universal"].joint_model(axes), pin.SE3.Identity(), "joint")
        data = model.createData()
        pin.forwardKinematics(model, data, np.array([0.7, -1.2]))
        unit = axes[1] / np.linalg.norm(axes[1])
        expected = pin.exp3(0.7 * axes[0]) @ pin.exp3(-1.2 * unit)
        assert np.allclose(data.oMi[1].rotation, expected, rtol=0, atol=1e-15)


@for_all(
    ("name", "axes", "pitch", "error"),
    [
        ("revolute", [[1, 0, 0], [0, 1, 0]], None, WrongShape),
        ("spherical", [1, 0, 0], None, WrongShape),
        ("universal", [[1, 0, 0], [-2, 0, 1e-8]], None, BadArgument),
        ("helical", [1, 0, 0], None, BadArgument),
        ("revolute", [1, 0, 0], 0.1, BadArgument),
    ],
)
def test_directions_that_define_no_such_joint_are_refused(name, axes, pitch, error) -> None:
    with pytest.raises(error):
        KINEMATIC_PAIRS[name].joint_model(axes, pitch=pitch)


def test_an_unknown_pair_is_refused_with_the_nearest_names() -> None:
    with pytest.raises(UnknownName, match="spherical"):
        kinematic_pair("sperical")


# --- mobility ---------------------------------------------------------------------------------------------------------


@given(st.lists(st.sampled_from(sorted(FREEDOMS)), max_size=20), st.integers(0, 5))
def test_mobility_of_a_tree_is_the_sum_of_freedoms_less_the_couplings(names, couplings) -> None:
    assert mobility(names, couplings=couplings) == sum(FREEDOMS[name] for name in names) - couplings


@for_all(
    ("names", "options", "expected"),
    [
        (["revolute"] * 26, {"couplings": 1}, 25),
        (["revolute"] * 4, {"links": 4, "space": 3}, 1),  # four-bar linkage in its plane
        (["revolute"] * 4, {"links": 4}, -2),  # the same in space: its constraints are redundant
        (["revolute", "spherical", "spherical", "revolute"], {"links": 4}, 2),  # RSSR, with the coupler's idle turn
        (["universal", "prismatic", "spherical"] * 6, {"links": 14}, 6),  # Stewart platform
        (["revolute"] * 3 + ["prismatic"], {"links": 4, "space": 3}, 1),  # slider-crank
        ([], {}, 0),
    ],
)
def test_mobility_of_known_mechanisms(names, options, expected) -> None:
    assert mobility(names, **options) == expected
    assert mobility([kinematic_pair(name) for name in names], **options) == expected


@for_all(
    "options",
    [
        {"links": 0},
        {"links": 4},
        {"couplings": -1},
        {"space": 4},
    ],
)
def test_counts_that_are_none_are_refused(options) -> None:
    with pytest.raises(BadArgument):
        mobility(["revolute", "revolute"], **options)


def test_a_joint_too_free_for_the_plane_is_refused() -> None:
    with pytest.raises(BadArgument, match="6 freedoms"):
        mobility(["free"], space=3)
    with pytest.raises(UnknownName):
        mobility(["hinge"])


# --- anatomy ----------------------------------------------------------------------------------------------------------


def test_anatomy_has_the_six_joints_with_their_equivalents_and_freedoms() -> None:
    assert {kind.name: dict(zip(kind.mechanical, kind.freedoms, strict=True)) for kind in ANATOMY} == {
        "hinge": {"revolute": 1},
        "pivot": {"revolute": 1, "cylindrical": 2},
        "ball and socket": {"spherical": 3},
        "ellipsoid": {"condyloid": 2},
        "saddle": {"universal": 2},
        "plane": {"planar": 3, "prismatic": 1},
    }
    assert [kind.table for kind in ANATOMY] == ["I"] * 5 + ["II"]


def test_every_joint_of_the_nao_has_its_place_in_the_body() -> None:
    placed = [
        f"{side}{joint}"
        for part in NAO_ANATOMY
        for joint in part.joints
        for side in ([""] if part.name == "neck" else "LR")
    ]
    assert sorted(placed) == sorted(row.name for row in JOINTS)
    known = {kind.name for kind in ANATOMY}
    assert all({part.anatomical, *part.human} <= known for part in NAO_ANATOMY)


@pytest.mark.parametrize("part", NAO_ANATOMY, ids=lambda part: part.name)
def test_the_anatomical_joint_of_a_part_has_as_many_freedoms_as_it_has_joints(part) -> None:
    kind = next(kind for kind in ANATOMY if kind.name == part.anatomical)
    assert len(part.joints) in kind.freedoms


@for_all(
    ("joint", "expected"),
    [
        ("HeadYaw", "neck"),
        ("LHipYawPitch", "left hip"),
        ("RElbowRoll", "right elbow"),
        ("LowerKnee", "knee"),
        ("TrunkYaw", ""),
    ],
)
def test_the_part_of_the_body_is_read_off_the_name(joint, expected) -> None:
    assert body_part(joint) == expected


def test_a_revolute_along_the_limb_is_a_pivot_and_across_it_a_hinge() -> None:
    revolute = KINEMATIC_PAIRS["revolute"]
    assert anatomical_kind(("LWristYaw",), revolute) == "pivot"
    assert anatomical_kind(("LKneePitch",), revolute) == "hinge"
    assert anatomical_kind(("whatever",), KINEMATIC_PAIRS["cylindrical"]) == "pivot"
    assert anatomical_kind(("whatever",), KINEMATIC_PAIRS["helical"]) == ""
