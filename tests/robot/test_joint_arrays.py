"""The table of joints holds what Pinocchio's model and yourdfpy's reading of the file hold."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import MissingExtra, UnknownName
from nao_kin.robot import JointArrays

ROBOTS = ("v3.2", "v3.3", "v4", "v5", "v6", "v6 floating", "romeo", "ur10_robot", "sliding", "mimic chain")


@pytest.fixture(params=ROBOTS)
def robot(request: pytest.FixtureRequest, tmp_path: Path) -> nk.RobotModel:
    name = request.param
    if name == "sliding":
        return made_up(
            tmp_path,
            J("lift", kind="prismatic", axis=(0.0, 0.6, 0.8)),
            J("turn", xyz=(0.0, 0.1, 0.0), rpy=(0.1, 0.2, 0.3), axis=(0.48, 0.6, 0.64)),
            J("reach", kind="prismatic", axis=(1.0, 0.0, 0.0)),
            base="floating",
        )
    if name == "mimic chain":
        return made_up(
            tmp_path,
            J("a", axis=(0.0, 1.0, 0.0)),
            J("b", xyz=(0.1, 0.0, 0.2), rpy=(0.3, -0.2, 0.1), follows=("a", -2.0, 0.3)),
            J("c", kind="prismatic", follows=("b", 0.1, 0.0)),
            J("held", follows=("a", 0.0, 0.4)),
        )
    if name.startswith("v"):
        version, *base = name.split()
        return nk.load_nao(version, base=base[0] if base else "fixed")
    try:
        return nk.load_robot(name)
    except MissingExtra:
        pytest.skip("needs example-robot-data")


def _motion(table: JointArrays, k: int, value: float) -> np.ndarray:
    T = np.eye(4)
    if table.kinds[k] == "prismatic":
        T[:3, 3] = value * table.axes[k]
    else:
        T[:3, :3] = pin.exp3(value * table.axes[k])
    return T


def _poses(table: JointArrays, values: np.ndarray) -> np.ndarray:
    """Poses of the joints in the root link, by the formula of the table."""
    poses: list[np.ndarray] = []
    for k, parent in enumerate(table.parents):
        above = np.eye(4) if parent < 0 else poses[parent]
        poses.append(above @ table.placements[k] @ _motion(table, k, values[k]))
    return np.array(poses)


def _q(robot: nk.RobotModel, seed: int) -> np.ndarray:
    q = robot.random(seed)
    if robot.base == "floating":
        rng = np.random.default_rng(seed)
        q[:7] = rng.normal(size=7)
        q[3:7] /= np.linalg.norm(q[3:7])
    return q


def test_placements_axes_and_couplings_give_the_poses_of_pinocchio(robot: nk.RobotModel) -> None:
    table, model = robot.joints, robot.model
    data = model.createData()
    for seed in range(5):
        q = _q(robot, seed)
        pin.forwardKinematics(model, data, q)
        T_world_root = pin.XYZQUATToSE3(q[:7]).homogeneous if robot.base == "floating" else np.eye(4)
        expected = np.array([data.oMi[model.getJointId(name)].homogeneous for name in table.names])
        assert np.abs(T_world_root @ _poses(table, table.values(q)) - expected).max() < 1e-12


def test_the_coordinate_of_a_joint_moves_it_in_the_column_of_the_jacobian(robot: nk.RobotModel) -> None:
    table, q = robot.joints, _q(robot, 7)
    values, poses = table.values(q), robot.fk(q, list(table.links))
    for k, link in enumerate(table.links):
        J = np.zeros((6, robot.nv))
        for above in table.path(k):
            axis = poses[above, :3, :3] @ table.axes[above]
            lever = poses[k, :3, 3] - poses[above, :3, 3]
            twist = np.r_[axis, 0.0 * axis] if table.kinds[above] == "prismatic" else np.r_[np.cross(axis, lever), axis]
            J[:, table.columns[above]] += table.multipliers[above] * twist
        first = robot.nv - len(robot.joint_names)
        assert np.abs(J - robot.jacobian(q, link))[:, first:].max(initial=0.0) < 1e-12
        moved = q.copy()
        moved[table.coordinates[k]] += 0.1
        assert table.values(moved)[k] == pytest.approx(values[k] + 0.1 * table.multipliers[k], abs=1e-14)


def test_the_bodies_of_the_joints_and_of_the_root_are_the_whole_robot(robot: nk.RobotModel) -> None:
    table, q = robot.joints, robot.random(1)
    poses = _poses(table, table.values(q))
    centres = np.einsum("nij,nj->ni", poses[:, :3, :3], table.centres_of_mass) + poses[:, :3, 3]
    mass = table.root_mass + table.masses.sum()
    moment = table.root_mass * table.root_centre_of_mass + table.masses @ centres
    assert mass == pytest.approx(robot.mass, rel=1e-14)
    if mass > 0.0:
        assert np.abs(moment / mass - robot.com(q, reference=robot.tree.root)).max() < 1e-12


def test_limits_are_those_of_the_robot_and_of_the_driving_joint(robot: nk.RobotModel) -> None:
    table = robot.joints
    for k, name in enumerate(table.names):
        driver = robot.mimics.get(name)
        place = robot.joint_names.index(driver.joint if driver else name)
        ends = np.array([robot.lower[place], robot.upper[place]])
        if driver is None:
            assert table.limits(name) == (*ends, robot.velocity_limits[place])
        elif driver.multiplier:
            assert [table.lower[k], table.upper[k]] == sorted(driver.multiplier * ends + driver.offset)
            assert table.velocity_limits[k] == abs(driver.multiplier) * robot.velocity_limits[place]
        else:
            assert table.limits(name) == (driver.offset, driver.offset, 0.0)


def test_frames_are_placed_in_their_joints(robot: nk.RobotModel) -> None:
    q = robot.random(2)
    poses = _poses(robot.joints, robot.joints.values(q))
    for frame in robot.frame_names:
        row, T_joint_frame = robot.frame_placement(frame)
        T_root_frame = T_joint_frame if row < 0 else poses[row] @ T_joint_frame
        assert np.abs(T_root_frame - robot.fk(q, frame, reference=robot.tree.root)).max() < 1e-12


def test_the_table_is_made_once_and_nobody_can_write_into_it(robot: nk.RobotModel) -> None:
    table = robot.joints
    assert robot.joints is table
    arrays = [getattr(table, field.name) for field in fields(table)]
    assert all(not array.flags.writeable for array in arrays if isinstance(array, np.ndarray))
    with pytest.raises(ValueError, match="read-only"):
        table.placements[0, 0, 3] = 1.0
    with pytest.raises(AttributeError):
        table.masses = table.masses  # type: ignore[misc]


def test_a_change_of_the_model_gives_a_new_table() -> None:
    nao = nk.load_nao()
    before = nao.joints
    k = before.row("LKneePitch")
    index = nao.model.getJointId("LKneePitch")
    nao.model.jointPlacements[index] = pin.SE3(np.eye(3), np.array([0.01, 0.02, -0.11]))
    assert nao.joints is not before
    assert nao.joints.placements[k, :3, 3].tolist() == [0.01, 0.02, -0.11]
    assert before.placements[k, :3, 3].tolist() == [0.0, 0.0, -0.1]
    nao.model.inertias[index].mass = 2.0
    assert nao.joints.masses[k] == 2.0


def test_an_unknown_joint_is_refused_with_the_nearest_name() -> None:
    with pytest.raises(UnknownName, match="HeadYaw"):
        nk.load_nao().joints.row("HeadYau")
