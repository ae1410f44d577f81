"""placo: kinematics, and inverse kinematics in which a gear task couples the hips."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import placo

from tools_table.probes.loaded import Loaded, Poses


def load(path: Path) -> Loaded:
    """Load a URDF."""
    robot = placo.RobotWrapper(str(path), placo.Flags.ignore_collisions)
    frames, joints = list(robot.frame_names()), set(robot.joint_names())

    def poses(values: Mapping[str, float]) -> Poses:
        for name, value in values.items():
            if name in joints:
                robot.set_joint(name, value)
        robot.update_kinematics()
        return {frame: robot.get_T_world_frame(frame) for frame in frames}

    return Loaded(
        poses,
        mass=robot.total_mass(),
        meshes=len(robot.visual_model.geometryObjects),
        held=["RHipYawPitch"],
        simulate=lambda: _move(robot, joints),
    )


def _move(robot: placo.RobotWrapper, joints: set[str]) -> dict[str, float]:
    """Turn the left hip; a gear task moves the right one with it."""
    solver = placo.KinematicsSolver(robot)
    solver.mask_fbase(True)
    solver.add_gear_task().set_gear("RHipYawPitch", "LHipYawPitch", 1.0)
    angles = solver.add_joints_task()
    angles.set_joints({"LHipYawPitch": -0.5, "LHipRoll": 0.2})
    for _ in range(50):
        robot.update_kinematics()
        solver.solve(True)
    robot.update_kinematics()
    if abs(robot.get_joint("LHipYawPitch") + 0.5) > 1e-3:
        raise RuntimeError("the hip does not reach its angle")
    return {name: robot.get_joint(name) for name in joints}
