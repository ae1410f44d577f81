"""The run of a cross-check: from configurations to a report."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from nao_kin._core.arrays import whole_number
from nao_kin.crosscheck.oracles import YourdfpyOracle, oracle_of, read_by_pinocchio
from nao_kin.crosscheck.report import Conversions, Report, Tally
from nao_kin.crosscheck.robot_checks import JacobianChecks, LimitChecks, PoseChecks
from nao_kin.crosscheck.rotation_checks import PARAMETER_CHECKS, three_angle_checks
from nao_kin.crosscheck.samples import RotationSample, sample_configurations
from nao_kin.crosscheck.steps import Step, steps_of, turns
from nao_kin.errors import BadArgument
from nao_kin.robot import RobotModel

# Configurations compared in one step, few enough to limit memory and to update a progress bar.
_CHUNK = 100


def run(
    robot: RobotModel,
    samples: int = 500,
    seed: int = 0,
    *,
    conversions: Conversions | None = None,
    steps: Sequence[Step] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Report:
    """Compare all of this library's conventions with those of independent implementations.

    At every configuration, every frame's pose is computed in five ways: from elementary rotations and the robot's
    numbers alone, by the robot's methods, by Pinocchio called directly, and, from the file, by yourdfpy and by
    Pinocchio's own parser (for an MJCF, by MuJoCo). Also compared are each frame's pose in its parent frame, and each
    joint's axis, sense and travel. For every rotation of a frame (without frames that stay parallel to their parent),
    every conversion is compared in both directions with Pinocchio's or eigenpy's. Joint axes as lines are compared with
    Pinocchio's Jacobians, limits and mimics with other readings of the URDF or one of the MJCF, limit violations and
    clamped values with a scalar formula.

    An error in a function under test fails only the rows of that function; their notes name the error.

    Args:
        robot: a robot with a fixed base.
        samples: number of configurations, at least 1: zero, inside, on and outside the limits, at and near multiples
            of π/2.
        seed: seed of the random configurations, at least 0; equal seeds give equal reports.
        conversions: the functions under test; None for the library's own.
        steps: the robot's numbers for the kinematics from elementary rotations, as `steps_of_nao` returns
            them; None for those of `robot`.
        progress: called with the number of configurations done and their total.

    Returns:
        The table, with the worst case of every row.

    Raises:
        BadArgument: a floating base.
        UnknownName: a step whose parent is not a frame.
        BadModel: the robot's URDF can no longer be read.

    Examples:
        >>> nk.crosscheck.run(nk.load_nao(), samples=1).ok
        True
    """
    if robot.base != "fixed":
        raise BadArgument("a cross-check needs a robot with a fixed base: load it with base='fixed'")
    samples = whole_number(samples, "samples", 1)
    seed = whole_number(seed, "seed", 0)
    tested = conversions or Conversions()
    chosen = tuple(steps_of(robot) if steps is None else steps)
    second = oracle_of(robot)
    configurations = sample_configurations(robot, samples, seed)
    is_urdf = isinstance(second, YourdfpyOracle)
    parsed, unparsed = read_by_pinocchio(robot, second.joints) if is_urdf else (None, "")
    poses = PoseChecks(robot, chosen, tested, second, parsed, unparsed)
    jacobians = JacobianChecks(robot, tested, poses.frames)
    limits = LimitChecks(robot, second, parsed, unparsed)
    checks = [*three_angle_checks(), *PARAMETER_CHECKS]
    rotations = [Tally(check.convention, check.against, note=check.note) for check in checks]
    turning = {step.name for step in chosen if step.parent is None or turns(step)}
    columns = [i for i, name in enumerate(poses.frames) if name in turning]
    names = [poses.frames[i] for i in columns]
    for first in range(0, samples, _CHUNK):
        q = configurations.q[first : first + _CHUNK]
        T = poses.add(q, first)
        jacobians.add(q, first)
        limits.add(q, first)
        sample = RotationSample(np.ascontiguousarray(T[:, columns, :3, :3].reshape(-1, 3, 3)))
        for check, tally in zip(checks, rotations, strict=True):
            tally.compare(first, len(q), names, check.difference, sample, tested)
        if progress:
            progress(min(first + _CHUNK, samples), samples)
    tallies = [*poses.tallies, *jacobians.tallies, *limits.tallies, *rotations]
    rows = tuple(tally.row(configurations) for tally in tallies)
    return Report(robot.name, robot.joint_names, seed, configurations.counts, rows)
