"""Step by step: where each frame stands in the one that carries it, and what its joint does there.

A wrong step moves everything behind it; only the row of the step itself says which one it was.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nao_kin._arrays import Floats
from nao_kin.crosscheck._forward import HandRolled
from nao_kin.crosscheck._tally import TOLERANCE, Tally
from nao_kin.robot import RobotModel


class Motion:
    """The rows about single steps, against what Pinocchio's poses say of the same two frames.

    The motion of a joint is measured as M, the pose of its frame in its own pose at zero. A turn by v about e has
    vect M = sin v e and (tr M − 1)/2 = cos v; a slide has the displacement v e. How far a joint goes and along which
    axis it goes are two rows.
    """

    def __init__(self, robot: RobotModel, by_hand: HandRolled, frames: Sequence[str]) -> None:
        self._by_hand = by_hand
        column = {name: i for i, name in enumerate(frames)}
        steps = [step for step in by_hand.steps if step.name in column and step.parent in column]
        self._frame = np.array([column[step.name] for step in steps], dtype=np.intp)
        self._parent = np.array([column[str(step.parent)] for step in steps], dtype=np.intp)
        moving = [i for i, step in enumerate(steps) if step.axis is not None]
        self._moving, self._joints = moving, [steps[i] for i in moving]
        self._own = np.array([joint.name in robot.joint_names for joint in self._joints], dtype=np.bool_)
        self._axes = np.array([joint.axis for joint in self._joints], dtype=np.float64).reshape(-1, 3)
        self._sliding = np.array([joint.sliding for joint in self._joints], dtype=np.bool_)
        self._astray = np.zeros(len(moving), dtype=np.bool_)

        self._axis = Tally("axis and sense of a joint", "Pinocchio")
        self._travel = Tally("travel of a joint", "Pinocchio")
        self._coupled = Tally("travel of a coupled joint", "Pinocchio")
        self._position = Tally("position in the carrying frame", "Pinocchio")
        self._orientation = Tally("orientation in the carrying frame", "Pinocchio")
        zero = robot.neutral()[None]
        self._R_zero, self._p_zero = self._relative(robot.fk(zero, frames))
        by_hand_zero = [by_hand.relative(step, zero) for step in steps]
        names = [step.name for step in steps]
        R = np.array([R.reshape(-1, 3, 3)[0] for R, _ in by_hand_zero]).reshape(-1, 3, 3)
        p = np.array([p.reshape(-1, 3)[0] for _, p in by_hand_zero]).reshape(-1, 3)
        self._orientation.add(np.abs(R - self._R_zero[0]).max(axis=(1, 2), initial=0.0)[None], 0, names)
        self._position.add(np.abs(p - self._p_zero[0]).max(axis=1, initial=0.0)[None], 0, names)

    @property
    def tallies(self) -> list[Tally]:
        """The rows; none of what the robot has not."""
        rows = [self._position, self._orientation] if len(self._frame) else []
        rows += [self._axis] if len(self._own) else []
        rows += [self._travel] if self._own.any() else []
        return [*rows, self._coupled] if not self._own.all() else rows

    def add(self, T: Floats, q: Floats, first: int) -> None:
        """Compare the poses T (n, frames, 4, 4) of configurations q (n, nq)."""
        if not self._moving:
            return
        R, p = self._relative(T)
        R_zero_transposed = np.swapaxes(self._R_zero[:, self._moving], -1, -2)
        M = R_zero_transposed @ R[:, self._moving]
        shift = (R_zero_transposed @ (p - self._p_zero)[:, self._moving, :, None])[..., 0]
        value = np.stack([self._by_hand.value(joint, q) - joint.offset for joint in self._joints], axis=1)

        sine = np.where(self._sliding, value, np.sin(value))
        cosine = np.where(self._sliding, 0.0, np.cos(value))
        vector = np.where(self._sliding[:, None], shift, _vect(M))
        trace = np.where(self._sliding, 0.0, 0.5 * (np.trace(M, axis1=-2, axis2=-1) - 1.0))
        length = np.sqrt(np.square(vector).sum(axis=-1))
        travel = np.maximum(np.abs(length - np.abs(sine)), np.abs(trace - cosine))

        along = length[..., None] * self._axes
        with_sense = np.abs(vector - np.sign(sine)[..., None] * along).max(axis=-1)
        either_sense = np.minimum(np.abs(vector - along).max(axis=-1), np.abs(vector + along).max(axis=-1))
        # Which sense is the right one cannot be told of a joint that does not go as far as it should.
        self._astray |= (travel > TOLERANCE).any(axis=0)
        names = [joint.name for joint in self._joints]
        self._axis.add(np.where(self._astray, either_sense, with_sense), first, names)
        for tally, which in ((self._travel, self._own), (self._coupled, ~self._own)):
            tally.add(travel[:, which], first, [name for name, chosen in zip(names, which, strict=True) if chosen])

    def _relative(self, T: Floats) -> tuple[Floats, Floats]:
        """Rotations (n, steps, 3, 3) and origins (n, steps, 3) of all steps in the frames that carry them."""
        R, p = T[..., :3, :3], T[..., :3, 3]
        R_parent_transposed = np.swapaxes(R[:, self._parent], -1, -2)
        apart = p[:, self._frame] - p[:, self._parent]
        return R_parent_transposed @ R[:, self._frame], (R_parent_transposed @ apart[..., None])[..., 0]


def _vect(M: Floats) -> Floats:
    """The vector of the antisymmetric part, (m32 − m23, m13 − m31, m21 − m12)/2."""
    return 0.5 * np.stack(
        [M[..., 2, 1] - M[..., 1, 2], M[..., 0, 2] - M[..., 2, 0], M[..., 1, 0] - M[..., 0, 1]], axis=-1
    )
