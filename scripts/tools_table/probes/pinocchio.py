"""Pinocchio, and the models that pink and placo take from it: kinematics of a model with its couplings."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pinocchio

from tools_table.probes.loaded import Loaded, Poses


def load(path: Path) -> Loaded:
    """Load a URDF with its couplings."""
    return of_model(read(path))


def read(path: Path) -> pinocchio.RobotWrapper:
    """Return a robot with a floating base and its couplings."""
    floating = pinocchio.JointModelFreeFlyer()
    return pinocchio.RobotWrapper.BuildFromURDF(str(path), [str(path.parent)], floating, mimic=True)


def of_model(robot: pinocchio.RobotWrapper) -> Loaded:
    """Return the data of a robot that Pinocchio has read."""
    model = robot.model

    def poses(values: Mapping[str, float]) -> Poses:
        data, q = model.createData(), pinocchio.neutral(model)
        for name, joint in zip(model.names, model.joints, strict=True):
            # A mimic joint has an index in q too: that of its driver.
            if name in values and joint.shortname() != "JointModelMimic":
                q[joint.idx_q] = values[name]
        pinocchio.framesForwardKinematics(model, data, q)
        bodies = ((i, frame) for i, frame in enumerate(model.frames) if frame.type == pinocchio.BODY)
        return {frame.name: data.oMf[i].homogeneous for i, frame in bodies}

    return Loaded(
        poses,
        mass=float(pinocchio.computeTotalMass(model)),
        meshes=len(robot.visual_model.geometryObjects),
    )
