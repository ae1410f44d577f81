"""Steps by the quadratic programs of pink, where it is installed, in the place of damped least squares."""

from __future__ import annotations

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.optional import need_extra
from nao_kin.ik.search.least_squares import Minimum, Rows
from nao_kin.ik.search.limit_regions import LimitRegion
from nao_kin.ik.search.pose_errors import PoseErrors

# Damping of pink's task in proportion to the squared error, and of every joint.
_TASK_DAMPING, _JOINT_DAMPING = 1e-2, 1e-9
# A step by less has arrived [rad or m].
_STILL = 1e-9


def check_pink() -> None:
    """Refuse to go on without pink.

    Raises:
        MissingExtra: pink, or the solver of its quadratic programs, is not installed.
    """
    need_extra('solver="pink"', "pink")


def minimise_with_pink(
    errors: PoseErrors,
    region: LimitRegion,
    q: Floats,
    rows: Rows,
    tolerance: float,
    steps: int,
    threads: int | None = None,
) -> Minimum:
    """As `least_squares.minimise`, one start after the other, with the boxes as limits of each quadratic program.

    pink knows no coupled limits: after every step the joints are projected onto them.
    """
    import pink
    import pinocchio as pin
    from pink.limits import ConfigurationLimit
    from pink.tasks import FrameTask

    motion, weights = errors.motion, errors.weights
    model = motion.robot.model.copy()  # pink hangs its limits on the model
    name = model.frames[motion.robot.frame_table[motion.frame]].name
    limits = [ConfigurationLimit(model, config_limit_gain=1.0)] if region.enforced else []
    ends: Floats = q.copy()
    settled = np.zeros(len(q), dtype=np.bool_)
    for k, row in enumerate(rows):
        target = errors.targets[row]
        task = FrameTask(name, weights[:3], weights[3:], lm_damping=_TASK_DAMPING)
        task.set_target(pin.SE3(target[:3, :3], target[:3, 3]))
        for _ in range(steps):
            if errors.met(errors(ends[k : k + 1], rows[k : k + 1])[0], tolerance)[0]:
                break
            configuration = pink.Configuration(model, model.createData(), ends[k])
            step = pink.solve_ik(
                configuration,
                [task],
                1.0,
                solver="quadprog",
                damping=_JOINT_DAMPING,
                limits=limits,
                safety_break=False,
            )
            ahead = motion.moved(ends[k : k + 1], step[None, motion.velocity_columns])
            values = motion.joint_values(ahead)
            values[...] = region.project(values)
            region.unwind(values)
            settled[k] = np.abs(ahead[0] - ends[k]).max() < _STILL
            ends[k] = ahead[0]
            if settled[k]:
                break
    residuals = errors(ends, rows)[0]
    return Minimum(ends, 0.5 * np.square(residuals).sum(axis=-1), errors.met(residuals, tolerance), settled)
