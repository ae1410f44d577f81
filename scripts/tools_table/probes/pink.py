"""pink: kinematics and inverse kinematics of a model with its couplings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pink
import pinocchio

from tools_table.probes.loaded import Loaded
from tools_table.probes.pinocchio import of_model, read


def load(path: Path) -> Loaded:
    """Load a URDF with its couplings."""
    robot = read(path)
    loaded = of_model(robot)
    return Loaded(loaded.poses, loaded.mass, loaded.meshes, simulate=lambda: _move(robot))


def _move(robot: pinocchio.RobotWrapper) -> dict[str, float]:
    """Lift the left foot by two centimetres, with a fixed trunk."""
    model = robot.model
    q = np.clip(robot.q0, model.lowerPositionLimit, model.upperPositionLimit)
    # A straight leg cannot be shortened: its first motion does not lift the foot.
    for name, angle in (("LHipPitch", -0.4), ("LKneePitch", 0.8), ("LAnklePitch", -0.4)):
        q[model.joints[model.getJointId(name)].idx_q] = angle
    configuration = pink.Configuration(model, robot.data, q)
    trunk = pink.tasks.FrameTask("torso", position_cost=100.0, orientation_cost=100.0)
    foot = pink.tasks.FrameTask("l_sole", position_cost=1.0, orientation_cost=0.0, lm_damping=1e-6)
    trunk.set_target_from_configuration(configuration)
    foot.set_target_from_configuration(configuration)
    foot.transform_target_to_world.translation += np.array([0.0, 0.0, 0.02])
    for _ in range(200):
        velocity = pink.solve_ik(configuration, [trunk, foot], 0.05, solver="daqp")
        configuration.integrate_inplace(velocity, 0.05)
    if abs(foot.compute_error(configuration)[:3]).max() > 1e-3:
        raise RuntimeError("the foot does not reach its target")
    return dict(zip(map(str, range(model.nq)), configuration.q.tolist(), strict=True))
