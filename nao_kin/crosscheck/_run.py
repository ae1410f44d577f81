"""The run: configurations in, a report out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from nao_kin._core.arrays import whole_number
from nao_kin.crosscheck.by_hand import Step, steps_of, turns
from nao_kin.crosscheck.oracles import oracle_of
from nao_kin.crosscheck.report import Conversions, Report, Tally
from nao_kin.crosscheck.robot_checks import JacobianChecks, LimitChecks, PoseChecks
from nao_kin.crosscheck.rotation_checks import PARAMETER_CHECKS, three_angle_checks
from nao_kin.crosscheck.samples import RotationSample, sample_configurations
from nao_kin.errors import BadArgument
from nao_kin.robot import RobotModel, check_robot

# Configurations compared at once: few enough that memory stays small and a progress bar moves.
_CHUNK = 100
# More would take the better part of an hour, and show nothing that these do not.
_MOST_SAMPLES = 100_000
_LARGEST_SEED = 2**128 - 1


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

    At every configuration, every frame's pose by hand from elementary rotations and the robot's numbers alone, by the
    robot's methods, by Pinocchio called directly, by yourdfpy (of an MJCF: by MuJoCo); each frame's place in the one
    that carries it, and each joint's axis, sense and travel. For every rotation that the frames take (those parallel to
    the frame that carries them add none), every conversion in both directions against Pinocchio's or eigenpy's. Joint
    axes as lines against Pinocchio's Jacobians. Limits and mimics against two other readings of the URDF or one of the
    MJCF, limit violations and clamped values against a scalar formula.

    Whatever a function under test raises fails the rows that it is part of, and no others; their notes name the error.

    Args:
        robot: a robot with a fixed base.
        samples: number of configurations, 1 to 100000: zero, inside, on and outside the limits, at and beside multiples
            of π/2.
        seed: seed of the random ones, 0 to 2¹²⁸ − 1; equal seeds give equal reports.
        conversions: the functions under test; the library's own by default.
        steps: the robot's numbers for the kinematics by hand; `steps_of(robot)` by default.
        progress: called with the number of configurations done and their total.

    Returns:
        The table, with the worst case of every row.

    Raises:
        BadArgument: no robot, a floating base, samples or seed that are no such numbers, no `Conversions`, no steps.
        UnknownName: a step that stands in an unknown frame.
        BadModel: the robot's URDF can no longer be read.

    Examples:
        >>> report = nk.crosscheck.run(nk.load_nao(), samples=1)
        >>> report.ok
        True
    """
    check_robot(robot)
    if conversions is not None and not isinstance(conversions, Conversions):
        raise BadArgument(f"conversions must be Conversions, got {type(conversions).__name__}")
    if steps is not None and not (isinstance(steps, Sequence) and all(isinstance(step, Step) for step in steps)):
        raise BadArgument("steps must be a sequence of Step")
    if robot.base != "fixed":
        raise BadArgument("a cross-check needs a robot with a fixed base: load it with base='fixed'")
    samples = whole_number(samples, "samples", 1, _MOST_SAMPLES)
    seed = whole_number(seed, "seed", 0, _LARGEST_SEED)
    tested = conversions or Conversions()
    chosen = tuple(steps_of(robot) if steps is None else steps)
    second = oracle_of(robot)
    configurations = sample_configurations(robot, samples, seed)
    poses = PoseChecks(robot, chosen, tested, second)
    jacobians = JacobianChecks(robot, tested, poses.frames)
    limits = LimitChecks(robot, second)
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
    return Report(
        robot.name,
        robot.joint_names,
        seed,
        configurations.counts,
        tuple(tally.row(configurations) for tally in tallies),
    )
