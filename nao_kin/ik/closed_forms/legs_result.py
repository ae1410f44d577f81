"""What inverse kinematics of both legs answers beside an `IKResult`: each foot by itself, and the torso."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik.results import Codes, IKResult, Reason, angle_in_words, errors_in_words

_SIDES = "left", "right"


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class LegsResult(IKResult):
    """Solutions for both feet: HipYawPitch and five joints of each leg.

    `residual` is the larger of those of both feet.

    Attributes:
        foot_residuals: errors of the left and the right foot at `best` in position and rotation angle,
            shape (..., 2, 2) [m, rad].
        yaw_errors: how far the left and the right foot are turned about the normals of their soles against their
            targets, positive to the left, shape (..., 2) [rad]; nan where ankles and normals are not met.
        leg: which leg does not reach its own target, 0 the left and 1 the right one; −1 where none is to blame, shape
            (...).
        torso: the pose of the torso in the world where the feet were given there, shape (..., 4, 4) [m]; else None.
        base_coordinates: of a robot with a floating base, its base there as the first seven entries of q; else None.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.legs(nao, *nao.fk(q, ["LLeg", "RLeg"]))
        >>> bool(result.success), result.foot_residuals.shape
        (True, (2, 2))
    """

    foot_residuals: Floats
    yaw_errors: Floats
    leg: Codes
    torso: Floats | None = None
    base_coordinates: Floats | None = None

    @property
    def q(self) -> Floats:
        """The best configuration, shape (..., nq): `best`, and the base if it moves, in the reference."""
        q = super().q
        if self.base_coordinates is not None:
            unknown = np.isnan(self.best).any(axis=-1, keepdims=True)
            q[..., :7] = np.where(unknown, np.nan, self.base_coordinates)
        return q

    @property
    def solutions(self) -> Floats:
        """All solutions as configurations, best first, shape (k, nq), of a batch (..., k, nq); nan from `count` on."""
        solutions = super().solutions
        if self.base_coordinates is not None:
            there = np.arange(solutions.shape[-2]) < self.count[..., None]
            solutions[..., :7] = np.where(there[..., None], self.base_coordinates[..., None, :], np.nan)
        return solutions

    def describe(self, index: tuple[int, ...] = (), *, degrees: bool = False) -> str:
        """The reason of one pair of feet in a sentence.

        Args:
            index: which pair of the batch; () where there is one.
            degrees: angles in degrees.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("StandInit")
            >>> result = nk.ik.legs(nao, *nao.fk(q, ["LLeg", "RLeg"]))
            >>> result.describe()
            'reached, 1 solution'
        """
        reason = Reason(int(self.reasons[index]))
        if reason is Reason.REACHED:
            return super().describe(index, degrees=degrees)
        turns = [float(error) for error in self.yaw_errors[index]]
        left, right = (angle_in_words(turn, degrees) for turn in turns)
        feet = f"; the feet are turned by {left} (left) and {right} (right)"
        if np.isnan(turns[0]):
            off = [errors_in_words(float(away), float(turn), degrees) for away, turn in self.foot_residuals[index]]
            feet = f"; the nearest feet are off by {off[0]} (left) and {off[1]} (right)"
        if reason is Reason.HIPS_DISAGREE:
            return f"the hips disagree by {angle_in_words(float(self.obstacles.needed[index]), degrees)}{feet}"
        why, *hint = super().describe(index, degrees=degrees).split("; ")
        unit = "".join(f"; {part}" for part in hint if not part.startswith("the nearest pose"))
        return f"{_SIDES[int(self.leg[index])]} leg: {why}{unit}{feet}"
