from __future__ import annotations

import functools
import math
import pickle

import numpy as np
import pinocchio as pin
import pytest
from loops import EACH_VERSION, for_all, full
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import BadArgument, NotFinite, UnknownName, WrongShape
from nao_kin.joints import MultiDofModel
from nao_kin.joints.grouping import RULES

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
BATCHES = [(), (1,), (0,), (2, 3)]


@functools.cache
def typed_nao(version: str = "v6", rule: str = "coincident") -> MultiDofModel:
    return MultiDofModel(nk.load_nao(version), rule=rule)


def wide(robot: nk.RobotModel, n: int, seed: int = 1) -> np.ndarray:
    """Configurations, half inside the limits and half far outside, where every branch and lock is met."""
    q = robot.random(seed, n)
    joints = slice(robot.nq_base, None)
    q[n // 2 :, joints] = np.random.default_rng(seed).uniform(-3.1, 3.1, q[n // 2 :, joints].shape)
    if robot.base == "floating":
        rng = np.random.default_rng(seed + 1)
        q[:, :3], turns = rng.normal(size=(n, 3)), rng.normal(size=(n, 4))
        q[:, 3:7] = turns / np.linalg.norm(turns, axis=1, keepdims=True)
    return q


def frames(model: pin.Model, q: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poses (count, 4, 4), Jacobians (count, 6, nv) and the centre of mass of what moves, straight from Pinocchio."""
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    poses = np.array([data.oMf[i].homogeneous for i in range(count)])
    jacobians = np.array([pin.getFrameJacobian(model, data, i, pin.LOCAL_WORLD_ALIGNED) for i in range(count)])
    return poses, jacobians, np.array(pin.centerOfMass(model, data, q))


def worst_differences(robot: nk.RobotModel, typed: MultiDofModel, q: np.ndarray) -> tuple[float, float, float]:
    """Largest difference of any frame's pose, any frame's velocity map, and the centre of mass."""
    q_typed, E, count = typed.from_q(q), typed.velocity_matrix(q), robot.model.nframes
    worst = np.zeros(3)
    for row, typed_row, matrix in zip(q, q_typed, E, strict=True):
        poses, jacobians, com = frames(robot.model, row, count)
        typed_poses, typed_jacobians, typed_com = frames(typed.model, typed_row, count)
        differences = (typed_poses - poses, typed_jacobians @ matrix - jacobians, typed_com - com)
        worst = np.maximum(worst, [np.abs(difference).max() for difference in differences])
    return float(worst[0]), float(worst[1]), float(worst[2])


def mass_matrix(model: pin.Model, q: np.ndarray) -> np.ndarray:
    """Σ Jᵢᵀ Iᵢ Jᵢ over all bodies."""
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    M = np.zeros((model.nv, model.nv))
    for index in range(1, model.njoints):
        J = pin.getJointJacobian(model, data, index, pin.LOCAL)
        M += J.T @ model.inertias[index].matrix() @ J
    return M


def composite_mass_matrix(model: pin.Model, q: np.ndarray) -> np.ndarray:
    # Fresh data: with mimic joints and a free base, crba adds to what the data already hold.
    upper = np.triu(pin.crba(model, model.createData(), q))
    return upper + np.triu(upper, 1).T


def inverse_dynamics_mass_matrix(model: pin.Model, q: np.ndarray) -> np.ndarray:
    rest = np.zeros(model.nv)
    at_rest = pin.rnea(model, model.createData(), q, rest, rest).copy()
    columns = [pin.rnea(model, model.createData(), q, rest, unit) - at_rest for unit in np.eye(model.nv)]
    return np.array(columns).T


# --- equality with the NAO --------------------------------------------------------------------------------------------


@for_all("rule", RULES)
@pytest.mark.parametrize("version", ["v3.2", *EACH_VERSION[:-1]])  # the shoulder of V3.2 is spherical
def test_all_frames_velocities_and_the_centre_of_mass_are_the_naos(version, rule) -> None:
    typed = typed_nao(version, rule)
    pose, velocity, com = worst_differences(typed.robot, typed, wide(typed.robot, 80))
    assert pose < 1e-13
    assert velocity < 1e-13
    assert com < 1e-13


@for_all("rule", RULES)
@pytest.mark.parametrize("version", EACH_VERSION)
def test_the_mass_matrix_is_the_naos_seen_through_the_velocity_matrix(version, rule) -> None:
    typed = typed_nao(version, rule)
    for q in wide(typed.robot, 6):
        E, q_typed = typed.velocity_matrix(q), typed.from_q(q)
        expected = mass_matrix(typed.robot.model, q)
        for algorithm in (mass_matrix, composite_mass_matrix, inverse_dynamics_mass_matrix):
            M = E.T @ algorithm(typed.model, q_typed) @ E
            assert np.allclose(M, expected, rtol=0, atol=1e-14), algorithm.__name__


@for_all("rule", RULES)
def test_the_velocity_matrix_is_the_derivative_of_the_typed_configuration(rule) -> None:
    typed, rng, h = typed_nao("v6", rule), np.random.default_rng(3), 1e-6
    for q in wide(typed.robot, 20):
        v = rng.normal(size=25)
        ahead, behind = typed.from_q(q + h * v), typed.from_q(q - h * v)
        rate = pin.difference(typed.model, behind, ahead) / (2 * h)
        assert np.allclose(typed.velocity_matrix(q) @ v, rate, rtol=0, atol=1e-8)


# --- what it is made of -----------------------------------------------------------------------------------------------


def test_joints_really_are_universal_spherical_and_revolute(nao) -> None:
    typed = typed_nao()
    kinds = {"universal": "JointModelUniversal", "spherical": "JointModelSpherical"}
    for joint in typed.pairs:
        name = typed.model.joints[typed.model.getJointId(joint.name)].shortname()
        assert name == kinds.get(joint.pair.name, name)
        if joint.pair.name == "revolute":
            assert name == nao.model.joints[nao.model.getJointId(joint.name)].shortname()
    assert len(typed.pairs) == 15


def test_columns_cover_the_configuration_joint_by_joint() -> None:
    typed = typed_nao()
    pairs = {joint.name: typed.columns[joint.name] for joint in typed.pairs}
    sizes = {"revolute": 1, "universal": 2, "spherical": 4}
    assert all(pairs[j.name].stop - pairs[j.name].start == sizes[j.pair.name] for j in typed.pairs)
    assert sorted(i for part in typed.columns.values() for i in range(part.start, part.stop)) == list(range(typed.nq))
    assert sorted(i for part in typed.rows.values() for i in range(part.start, part.stop)) == list(range(typed.nv))


def test_only_the_links_inside_balls_need_coordinates_beside_the_fifteen_joints() -> None:
    typed = typed_nao()
    extra = set(typed.columns) - {joint.name for joint in typed.pairs}
    # The right hip's first link follows the left one's, as its motor does.
    assert extra == {"LHipYawPitch", "LHipRoll", "RHipRoll"}
    assert extra < set(typed.carriers)
    assert typed.nv - len(extra) == 26
    assert typed.nv - len(extra) - len(typed.groups.mimics) == typed.robot.nv == 25


def test_the_universal_coordinates_are_the_angles_and_the_quaternion_is_the_rotation(nao) -> None:
    typed = typed_nao()
    q = nao.random(1)
    values, q_typed = nao.angles(q), typed.from_q(q)
    neck = q_typed[typed.columns["HeadYaw+HeadPitch"]]
    assert neck.tolist() == [values["HeadYaw"], values["HeadPitch"]]
    x, y, z, w = q_typed[typed.columns["RHipYawPitch+RHipRoll+RHipPitch"]]
    R = pin.Quaternion(w, x, y, z).toRotationMatrix()
    assert np.allclose(R, nao.rotation(q, "RThigh"), rtol=0, atol=1e-15)


def test_limits_carry_over_where_a_coordinate_is_a_joint_value(nao) -> None:
    typed, model = typed_nao(), typed_nao().model
    table = {
        name: row
        for name, *row in zip(
            nao.joint_names, nao.lower, nao.upper, nao.velocity_limits, nao.effort_limits, strict=True
        )
    }
    checked = 0
    for joint in typed.pairs:
        columns, rows = typed.columns[joint.name], typed.rows[joint.name]
        if joint.pair.name == "spherical":
            assert np.all(model.upperPositionLimit[columns] > 1e300)
            continue
        for part, column, row in zip(joint.joints, range(*columns.indices(99)), range(*rows.indices(99)), strict=True):
            lower, upper, speed, effort = table[part]
            assert (model.lowerPositionLimit[column], model.upperPositionLimit[column]) == (lower, upper)
            assert (model.lowerVelocityLimit[row], model.upperVelocityLimit[row]) == (-speed, speed)
            assert (model.lowerEffortLimit[row], model.upperEffortLimit[row]) == (-effort, effort)
            checked += 1
    assert checked == 20
    column = typed.columns["LHipRoll"].start
    assert model.upperPositionLimit[column] == table["LHipRoll"][1]


def test_a_follower_is_as_fast_as_its_driver_makes_it(tmp_path) -> None:
    motor, universal = J("m", Z), [J("a", Z, parent="base", follows=("m", -0.5, 0.2)), J("b", X)]
    typed = MultiDofModel(made_up(tmp_path, motor, *universal))
    row, speed = typed.rows["a+b"].start, typed.model.upperVelocityLimit[typed.rows["m"].start]
    assert speed > 0.0
    assert typed.model.upperVelocityLimit[row] == 0.5 * speed
    assert typed.model.lowerVelocityLimit[row] == -0.5 * speed


def test_masses_and_frames_are_the_robots(each_nao) -> None:
    typed = MultiDofModel(each_nao, rule="concurrent")
    assert sum(inertia.mass for inertia in typed.model.inertias) == pytest.approx(each_nao.mass, abs=1e-14)
    count = each_nao.model.nframes
    for mine, theirs in zip(list(typed.model.frames)[:count], each_nao.model.frames, strict=True):
        assert (mine.name, mine.type, mine.parentFrame) == (theirs.name, theirs.type, theirs.parentFrame)
    added = [frame.name for frame in list(typed.model.frames)[count:]]
    assert added == [joint.name for joint in typed.pairs if len(joint.joints) > 1]


# --- the model's own methods ------------------------------------------------------------------------------------------


@for_all("batch", BATCHES)
def test_methods_take_every_batch_shape_and_agree_with_the_robot(nao, batch) -> None:
    typed = typed_nao()
    q = nao.random(2, batch)
    q_typed = typed.from_q(q)
    assert q_typed.shape == (*batch, typed.nq)
    E = typed.velocity_matrix(q)
    assert E.shape == (*batch, typed.nv, 25)
    assert np.allclose(typed.fk(q_typed, "LFoot"), nao.fk(q, "LFoot"), rtol=0, atol=1e-14)
    assert np.allclose(typed.fk(q_typed, ["LArm", "Neck"]), nao.fk(q, ["LArm", "Neck"]), rtol=0, atol=1e-14)
    assert np.allclose(typed.fk(q_typed), nao.fk(q), rtol=0, atol=1e-14)
    assert np.allclose(typed.com(q_typed), nao.com(q), rtol=0, atol=1e-15)
    for expressed_in in ("frame", "root", "mixed"):
        J = typed.jacobian(q_typed, "RHip", expressed_in)
        assert J.shape == (*batch, 6, typed.nv)
        assert np.allclose(J @ E, nao.jacobian(q, "RHip", expressed_in), rtol=0, atol=1e-14)
    back = typed.to_q(q_typed)
    assert back.shape == q.shape
    assert np.allclose(back, q, rtol=0, atol=1e-14)


def test_a_typed_model_survives_pickling(nao) -> None:
    typed = typed_nao("v3.2", "concurrent")
    copy = pickle.loads(pickle.dumps(typed))
    q = typed.robot.random(1)
    assert copy.groups.rule == "concurrent"
    assert np.array_equal(copy.fk(copy.from_q(q)), typed.fk(typed.from_q(q)))
    assert "concurrent" in repr(copy)


# --- other robots -----------------------------------------------------------------------------------------------------


@for_all("rule", RULES)
@pytest.mark.parametrize(
    ("name", "base"), [("romeo", "floating"), ("panda", "fixed"), *full(("romeo", "fixed"), ("talos_full_v2", "fixed"))]
)
def test_other_robots_keep_their_frames_velocities_and_centre_of_mass(name, base, rule) -> None:
    robot = nk.load_robot(name, base=base)
    typed = MultiDofModel(robot, rule=rule)
    q = wide(robot, 20)
    pose, velocity, com = worst_differences(robot, typed, q)
    assert max(pose, velocity, com) < 1e-12
    assert np.abs(typed.com(typed.from_q(q)) - robot.com(q)).max() < 1e-12
    for row in q[-3:]:
        E = typed.velocity_matrix(row)
        M = E.T @ composite_mass_matrix(typed.model, typed.from_q(row)) @ E
        assert np.allclose(M, mass_matrix(robot.model, row), rtol=0, atol=1e-11)


CHAINS = {
    "universal": [J("a", Z), J("b", X)],
    "oblique universal": [J("a", (1, 2, 3)), J("b", (0, 1, 1))],
    "ball": [J("a", (1, 2, -2)), J("b", (2, 1, 2)), J("c", (2, -2, -1))],
    "turned frames": [J("a", X, (1, 2, 3), (0.1, 0.2, 0.3)), J("b", X, rpy=(0, 0, math.pi / 2)), J("c", X, (1, 0, 0))],
    "prismatic between": [J("a", Z), J("s", (1, 1, 0), kind="prismatic"), J("b", X), J("c", Y)],
    "parallel": [J("a", Z), J("b", Z), J("c", Z, (0.2, 0, 0))],
    "skew": [J("a", Z), J("b", X, (0, 0.1, 0)), J("c", Y, (0, 0, 0.1))],
    "four through a point": [J("a", Z), J("b", X), J("c", Y), J("d", X)],
    "meeting away": [J("a", Z, (0.4, 0.5, 0.6)), J("b", X, (0.3, 0, 0.2)), J("c", Z, (-0.3, 0, 0))],
    "branch": [J("a", Z), J("b", X), J("c", Y, parent="a"), J("d", Z)],
    "follower inside": [J("a", Z), J("b", X), J("f", Y, parent="a", follows=("b", 2.0, 0.1)), J("g", Z)],
    "follower inside a ball": [J("a", Z), J("b", X), J("c", Y), J("f", Y, parent="a", follows=("b", 0.5, 0.0))],
    "follower of a ball's last": [J("a", Z), J("b", X), J("c", Y), J("f", (1, 1, 0), follows=("c", 2.0, 0.1))],
    "follower in a ball of its end": [J("a", Z), J("b", X), J("c", Y), J("f", X, parent="b", follows=("c", -1.0, 0.0))],
    "follower of the next joint": [
        J("a", Z),
        J("b", X),
        J("c", Y),
        J("d", Y, (0, 0, 0.2)),
        J("f", X, parent="b", follows=("d", 3.0, 0.0)),
    ],
    "follower behind a universal": [J("a", Z), J("b", X), J("f", X, (0, 0.1, 0), follows=("b", 1.5, 0.0))],
    "follower elsewhere": [J("a", Z), J("b", X), J("f", X, (0, 0.1, 0), parent="base", follows=("b", 1.5, 0.0))],
    "follower on a revolute": [J("a", Z), J("b", X, (0, 0.1, 0)), J("f", X, (0, 0.1, 0), follows=("b", 1.5, 0.0))],
    "coupled universal": [J("m", Z), J("a", Z, parent="base", follows=("m", -0.5, 0.2)), J("b", X)],
    "coupled ball": [J("m", Z), J("a", Z, parent="base", follows=("m", 2.0, -0.3)), J("b", X), J("c", Y)],
    "coupled to a universal": [J("m", Z), J("n", X), J("a", Z, parent="base", follows=("m", 1.5, 0.0)), J("b", X)],
    "still": [J("a", Z), J("still", X, follows=("a", 0.0, 0.4)), J("b", Y, (0, 0, 0.2)), J("c", X)],
    "sliding follower": [J("a", Z), J("b", X), J("s", Y, kind="prismatic", follows=("a", 0.1, 0.05))],
    "limitless": [J(name, axis, kind="continuous") for name, axis in (("a", Z), ("b", X), ("c", Z))],
    "only prismatic": [J("x", X, kind="prismatic"), J("y", Y, kind="prismatic")],
}


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(
    ("name", "base"), [*((name, "fixed") for name in CHAINS), ("ball", "floating"), ("coupled universal", "floating")]
)
def test_made_up_robots_keep_their_frames_velocities_and_centre_of_mass(tmp_path, name, rule, base) -> None:
    robot = made_up(tmp_path, *CHAINS[name], base=base)
    typed = MultiDofModel(robot, rule=rule)
    q = wide(robot, 10)
    assert max(worst_differences(robot, typed, q)) < 1e-13
    assert np.allclose(typed.com(typed.from_q(q)), robot.com(q), rtol=0, atol=1e-14)
    for row in q[-1:]:
        E = typed.velocity_matrix(row)
        for algorithm in (mass_matrix, composite_mass_matrix, inverse_dynamics_mass_matrix):
            M = E.T @ algorithm(typed.model, typed.from_q(row)) @ E
            assert np.allclose(M, mass_matrix(robot.model, row), rtol=0, atol=1e-12), algorithm.__name__
    assert np.allclose(typed.to_q(typed.from_q(q), near=q), q, rtol=0, atol=1e-11)


def test_a_robot_without_joints_is_its_own_typed_model(tmp_path) -> None:
    robot = made_up(tmp_path)
    typed = MultiDofModel(robot)
    assert typed.from_q(np.zeros((2, 0))).shape == (2, 0)
    assert typed.to_q(np.zeros((2, 0))).shape == (2, 0)
    assert np.allclose(typed.com([]), robot.com([]), rtol=0, atol=1e-15)


@pytest.mark.parametrize("size", [1e-9, 1e-2])
def test_nearly_meeting_axes_cost_no_more_than_they_miss_by(tmp_path, size) -> None:
    joints = [J("a", Z), J("b", X, (0.1, size, 0)), J("c", Y, (-0.1, 0.2, size)), J("d", Z, (0.3, 0, 0.1))]
    robot = made_up(tmp_path, *joints)
    typed = MultiDofModel(robot, rule="concurrent", tolerance=size)
    assert len(typed.pairs) == 2
    residual = typed.pairs[0].residual
    assert 0 < residual <= size
    q = wide(robot, 200)
    difference = typed.fk(typed.from_q(q)) - robot.fk(q)
    assert np.abs(difference[..., :3, :3]).max() < 1e-14
    off = np.linalg.norm(difference[..., :3, 3], axis=-1).max()
    assert 0.1 * residual < off <= 3 * 2 * residual
    assert np.allclose(typed.fk(typed.neutral()), robot.fk(robot.neutral()), rtol=0, atol=1e-15)


# --- bad input --------------------------------------------------------------------------------------------------------


def test_what_is_no_configuration_is_refused(nao) -> None:
    typed = typed_nao()
    for method in (typed.to_q, typed.fk, typed.com, typed.violations, lambda q: typed.jacobian(q, "LFoot")):
        with pytest.raises(WrongShape):
            method(nao.neutral())
        with pytest.raises(NotFinite):
            method(np.full(typed.nq, math.nan))
    for method in (typed.from_q, typed.velocity_matrix):
        with pytest.raises(WrongShape):
            method(typed.neutral())
        with pytest.raises(NotFinite):
            method(np.full(25, math.inf))
    with pytest.raises(WrongShape):
        typed.to_q(typed.from_q(nao.random(1, (2,))), near=nao.random(1, (3,)))


def test_unknown_names_are_refused_with_the_nearest(nao) -> None:
    typed = typed_nao()
    with pytest.raises(UnknownName, match="LFoot"):
        typed.fk(typed.neutral(), "LFot")
    with pytest.raises(UnknownName):
        typed.jacobian(typed.neutral(), "LFoot", "world")
    with pytest.raises(UnknownName, match="nearest"):
        typed.to_q(typed.neutral(), couplings="neares")
    with pytest.raises(UnknownName, match="LHip"):
        typed.ball_angles(typed.neutral(), "LKneePitch")
    with pytest.raises(UnknownName, match="rule"):
        MultiDofModel(nao, rule="none")
    with pytest.raises(BadArgument, match="tolerance"):
        MultiDofModel(nao, tolerance=0.0)


def test_a_robot_without_mass_has_no_centre_of_mass(tmp_path) -> None:
    path = tmp_path / "massless.urdf"
    path.write_text('<robot name="massless"><link name="only"/></robot>')
    with pytest.raises(BadArgument, match="no mass"):
        MultiDofModel(nk.RobotModel.from_urdf(path)).com([])
