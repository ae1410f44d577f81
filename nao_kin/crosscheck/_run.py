"""The run: configurations in, a report out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from nao_kin._arrays import Floats
from nao_kin._scalars import whole_number
from nao_kin.crosscheck._check import Check
from nao_kin.crosscheck._jacobians import Jacobians
from nao_kin.crosscheck._parameters import parameter_checks
from nao_kin.crosscheck._sample import Sample
from nao_kin.crosscheck._strata import stratified
from nao_kin.crosscheck._structure import Structure
from nao_kin.crosscheck._tally import Tally
from nao_kin.crosscheck._three_angles import three_angle_checks
from nao_kin.crosscheck.conversions import Conversions
from nao_kin.crosscheck.report import Report
from nao_kin.crosscheck.steps import Step, steps_of
from nao_kin.errors import BadArgument, NaoKinError
from nao_kin.robot import RobotModel, check_robot

# Configurations compared at once: few enough that memory stays small and a progress bar moves.
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

    At every configuration, every frame's pose three ways: by hand from elementary rotations and the robot's numbers
    alone, by Pinocchio, by yourdfpy; each frame's place in the one that carries it, and each joint's axis, sense and
    travel. For every rotation that the frames take (those parallel to the frame that carries them add none), every
    conversion in both directions against Pinocchio's or eigenpy's. Joint axes as lines against Pinocchio's Jacobians.

    Args:
        robot: a robot with a fixed base.
        samples: number of configurations: zero, inside and on the limits, at and beside multiples of π/2, beyond.
        seed: seed of the random ones; equal seeds give equal reports.
        conversions: the functions under test; the library's own by default.
        steps: the robot's numbers for the kinematics by hand; `steps_of(robot)` by default.
        progress: called with the number of configurations done and their total.

    Returns:
        The table, with the worst case of every row.

    Raises:
        BadArgument: no robot, a floating base, no configurations, no seed, no `Conversions`, no steps.
        UnknownName: a step that stands in an unknown frame.
        BadModel: the robot's URDF can no longer be read.
    """
    check_robot(robot)
    if conversions is not None and not isinstance(conversions, Conversions):
        raise BadArgument(f"conversions must be Conversions, got {type(conversions).__name__}")
    if steps is not None and not (isinstance(steps, Sequence) and all(isinstance(step, Step) for step in steps)):
        raise BadArgument("steps must be a sequence of Step")
    if robot.base != "fixed":
        raise BadArgument("a cross-check needs a robot with a fixed base: load it with base='fixed'")
    samples, seed = whole_number(samples, "samples", 1), whole_number(seed, "seed", 0)
    tested = conversions or Conversions()
    configurations = stratified(robot, samples, seed)
    chosen = tuple(steps_of(robot) if steps is None else steps)
    structure = Structure(robot, chosen, tested)
    jacobians = Jacobians(robot, tested, structure.frames)
    comparison = _Rotations(tested, [*three_angle_checks(), *parameter_checks()])
    turning = _turning(chosen, structure.frames)
    names = [structure.frames[i] for i in turning]
    for first in range(0, samples, _CHUNK):
        q = configurations.q[first : first + _CHUNK]
        T = structure.add(q, first)
        jacobians.add(q, first)
        comparison.add(T[:, turning, :3, :3], first, names)
        if progress:
            progress(min(first + _CHUNK, samples), samples)
    tallies = [*structure.tallies, *jacobians.tallies, *comparison.tallies]
    return Report(
        robot.name,
        robot.joint_names,
        seed,
        configurations.counts,
        tuple(tally.row(configurations) for tally in tallies),
    )


class _Rotations:
    """The rows about rotations."""

    def __init__(self, conversions: Conversions, checks: Sequence[Check]) -> None:
        self._conversions, self._checks = conversions, checks
        self.tallies = [Tally(check.convention, check.against, check.tolerance, check.note) for check in checks]

    def add(self, R: Floats, first: int, frames: Sequence[str]) -> None:
        """Compare the rotations R (n, m, 3, 3) of m frames."""
        shape = R.shape[0], R.shape[1]
        sample = Sample(np.ascontiguousarray(R.reshape(-1, 3, 3)))
        for check, tally in zip(self._checks, self.tallies, strict=True):
            try:
                tally.add(check.gap(sample, self._conversions).reshape(shape), first, frames)
            except Exception as error:  # whatever a conversion under test raises is its failure, not the check's
                reason = str(error) if isinstance(error, NaoKinError) else f"{type(error).__name__}: {error}"
                tally.refuse(reason, shape, first, frames)


def _turning(steps: Sequence[Step], frames: Sequence[str]) -> list[int]:
    """The frames whose rotation is not, by their step, that of the frame that carries them."""
    still = {step.name for step in steps if step.parent and not step.turns and (step.axis is None or step.sliding)}
    return [i for i, name in enumerate(frames) if name not in still]
