"""Forward kinematics three ways: by hand, by Pinocchio, by yourdfpy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nao_kin._arrays import Floats
from nao_kin.crosscheck._forward import HandRolled
from nao_kin.crosscheck._gaps import gap
from nao_kin.crosscheck._motion import Motion
from nao_kin.crosscheck._sample import turns_about
from nao_kin.crosscheck._second_reader import SecondReader
from nao_kin.crosscheck._tally import Tally
from nao_kin.crosscheck.conversions import Conversions
from nao_kin.crosscheck.steps import Step
from nao_kin.robot import RobotModel

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class Structure:
    """The rows about the robot itself.

    Attributes:
        frames: the frames that the steps and the robot have in common.
    """

    def __init__(self, robot: RobotModel, steps: Sequence[Step], conversions: Conversions) -> None:
        self._robot, self._conversions = robot, conversions
        self._by_hand = HandRolled(steps, robot.joint_names, conversions)
        self._second = SecondReader(robot)
        known = set(robot.frame_names)
        self._mine = [i for i, step in enumerate(steps) if step.name in known]
        self.frames = tuple(steps[i].name for i in self._mine)
        column = {name: i for i, name in enumerate(self.frames)}
        self._shared = tuple(name for name in self._second.frames if name in column)
        self._columns = [column[name] for name in self._shared]
        self._second_columns = [self._second.frames.index(name) for name in self._shared]
        self._motion = Motion(robot, self._by_hand, self.frames)

        left_out = len(self._second.left_out)
        note = f"{left_out} frames left out: yourdfpy reads a coupling or a sliding axis otherwise" if left_out else ""
        self._by_hand_pinocchio = Tally("pose in the root, by hand", "Pinocchio")
        self._by_hand_yourdfpy = Tally("pose in the root, by hand", "yourdfpy", note=note)
        self._pinocchio_yourdfpy = Tally("pose in the root, by Pinocchio", "yourdfpy", note=note)
        self._elementary = {axis: Tally(f"rot_{axis}", "pin.AngleAxis") for axis in _AXES}
        self._names = Tally("frame names", "Pinocchio")
        by_hand = {step.name for step in steps}
        names = sorted(by_hand | known)
        self._names.add(np.array([[float((name in by_hand) != (name in known)) for name in names]]), 0, names)

    @property
    def tallies(self) -> list[Tally]:
        """The rows, in the order of the report."""
        poses = [self._by_hand_pinocchio, self._by_hand_yourdfpy, self._pinocchio_yourdfpy]
        elementary = self._elementary.values() if self._robot.joint_names else ()
        return [*poses, self._names, *self._motion.tallies, *elementary]

    def add(self, q: Floats, first: int) -> Floats:
        """Compare configurations (n, nq), the first of which has the index `first`.

        Returns:
            Pinocchio's poses of `frames`, shape (n, frames, 4, 4).
        """
        T = self._robot.fk(q, self.frames)
        by_hand = self._by_hand.poses(q)[:, self._mine]
        second = self._second.poses(q)[:, self._second_columns]
        self._by_hand_pinocchio.add(_pose_gap(by_hand, T), first, self.frames)
        self._by_hand_yourdfpy.add(_pose_gap(by_hand[:, self._columns], second), first, self._shared)
        self._pinocchio_yourdfpy.add(_pose_gap(T[:, self._columns], second), first, self._shared)
        self._motion.add(T, q, first)
        angles = q.ravel()
        for axis, tally in self._elementary.items():
            rot = getattr(self._conversions, f"rot_{axis}")
            apart = gap(rot(angles), turns_about(_AXES[axis], angles))
            tally.add(apart.reshape(q.shape), first, self._robot.joint_names)
        return T


def _pose_gap(ours: Floats, theirs: Floats) -> Floats:
    """Largest difference of any entry of poses (n, m, 4, 4), shape (n, m)."""
    return np.asarray(np.abs(ours - theirs).max(axis=(2, 3), initial=0.0))
