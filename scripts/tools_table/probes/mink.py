"""mink: kinematics, and inverse kinematics with the couplings."""

from __future__ import annotations

from pathlib import Path

import mink
import mujoco
import numpy as np

from tools_table.probes.loaded import Loaded
from tools_table.probes.mujoco import read


def load(path: Path) -> Loaded:
    """Load a scene."""
    return read(path, _move)


def _move(model: mujoco.MjModel) -> dict[str, float]:
    """Reach with the left hand and turn the left leg, with the couplings as tasks."""
    configuration = mink.Configuration(model)
    configuration.update_from_keyframe("StandInit")
    couplings = mink.EqualityConstraintTask(model, cost=1.0)
    ends = list[mink.FrameTask]()
    for site, shift in (("LArm", (0.03, 0.0, 0.02)), ("LLeg", (0.0, 0.02, 0.02))):
        task = mink.FrameTask(site, "site", position_cost=1.0, orientation_cost=0.0, lm_damping=1e-6)
        start = configuration.get_transform_frame_to_world(site, "site")
        task.set_target(mink.SE3.from_translation(np.array(shift)).multiply(start))
        ends.append(task)
    for _ in range(100):
        velocity = mink.solve_ik(
            configuration, [couplings, *ends], 0.1, "daqp", limits=[mink.ConfigurationLimit(model)]
        )
        configuration.integrate_inplace(velocity, 0.1)
    for task in ends:
        if abs(task.compute_error(configuration)[:3]).max() > 1e-3:
            raise RuntimeError(f"{task.frame_name} does not reach its target")
    q = configuration.q
    return {model.joint(i).name: float(q[model.jnt_qposadr[i]]) for i in range(model.njnt)}
