"""MuJoCo: kinematics and two seconds of simulation on a floor."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import mujoco
import numpy as np

from tools_table.probes.loaded import Loaded, Poses, matrix

_SECONDS = 2.0


def load(path: Path) -> Loaded:
    """Load a scene."""
    return read(path, _simulate)


def read(path: Path, simulate: Callable[[mujoco.MjModel], Mapping[str, float]]) -> Loaded:
    """Load a scene, with a function that moves its robot."""
    model = mujoco.MjModel.from_xml_path(str(path))
    return Loaded(
        lambda values: poses(model, values),
        mass=float(model.body_subtreemass[model.body("torso").id]),
        meshes=shown_meshes(model),
        held=equal_joints(model),
        simulate=lambda: simulate(model),
    )


def poses(model: mujoco.MjModel, values: Mapping[str, float]) -> Poses:
    """Return the poses of bodies and sites."""
    data = mujoco.MjData(model)
    for name, value in values.items():
        data.joint(name).qpos = value
    mujoco.mj_kinematics(model, data)
    found = {model.site(i).name: matrix(data.site_xmat[i], data.site_xpos[i]) for i in range(model.nsite)}
    return found | {model.body(i).name: matrix(data.xmat[i], data.xpos[i]) for i in range(model.nbody)}


def shown_meshes(model: mujoco.MjModel) -> int:
    """Return the number of meshes that do not collide."""
    meshes = model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    return int(np.sum(meshes & (model.geom_contype == 0) & (model.geom_conaffinity == 0)))


def equal_joints(model: mujoco.MjModel) -> list[str]:
    """Return the joints that an equality constraint couples to another joint."""
    joints = model.eq_type == mujoco.mjtEq.mjEQ_JOINT
    return [model.joint(int(joint)).name for joint in model.eq_obj1id[joints]]


def _simulate(model: mujoco.MjModel) -> dict[str, float]:
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("StandInit").id)
    mujoco.mj_kinematics(model, data)
    height = float(data.body("torso").xpos[2])
    while data.time < _SECONDS:
        mujoco.mj_step(model, data)
    if abs(float(data.body("torso").xpos[2]) - height) > 0.02:
        raise RuntimeError("it does not stand")
    hinges = (model.joint(i) for i in range(model.njnt) if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_HINGE)
    return {joint.name: float(data.qpos[joint.qposadr[0]]) for joint in hinges}
