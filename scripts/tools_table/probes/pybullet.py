"""PyBullet: kinematics, and a moment of free fall."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pybullet

from tools_table.probes.loaded import Loaded, Poses, matrix

_STEPS = 120


def load(path: Path) -> Loaded:
    """Load a URDF."""
    pybullet.connect(pybullet.DIRECT)
    robot = pybullet.loadURDF(str(path))
    # Mass, friction, inertia, centre of mass, …; number, name, kind, …, name of the link.
    dynamics = [pybullet.getDynamicsInfo(robot, link) for link in range(-1, pybullet.getNumJoints(robot))]
    joints = [pybullet.getJointInfo(robot, index) for index in range(pybullet.getNumJoints(robot))]
    moving = {joint[1].decode(): joint[0] for joint in joints if joint[2] == pybullet.JOINT_REVOLUTE}
    shapes = pybullet.getVisualShapeData(robot)
    root = pybullet.getBodyInfo(robot)[0].decode()

    def poses(values: Mapping[str, float]) -> Poses:
        for name, value in values.items():
            pybullet.resetJointState(robot, moving[name], value)
        centre, turn = pybullet.getBasePositionAndOrientation(robot)
        here = pybullet.multiplyTransforms(centre, turn, *pybullet.invertTransform(*dynamics[0][3:5]))
        found = {root: matrix(pybullet.getMatrixFromQuaternion(here[1]), here[0])}
        for joint in joints:
            state = pybullet.getLinkState(robot, joint[0], computeForwardKinematics=True)
            found[joint[12].decode()] = matrix(pybullet.getMatrixFromQuaternion(state[5]), state[4])
        return found

    def simulate() -> dict[str, float]:
        pybullet.setGravity(0.0, 0.0, -9.81)
        for _ in range(_STEPS):
            pybullet.stepSimulation()
        return {name: pybullet.getJointState(robot, index)[0] for name, index in moving.items()}

    return Loaded(
        poses,
        mass=sum(body[0] for body in dynamics),
        meshes=sum(shape[2] == pybullet.GEOM_MESH for shape in shapes),
        simulate=simulate,
    )
