"""What `whole_body` answers: the pose, what each target is off by, and which of them gives way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.ik.results import MILLIMETRES_FROM, Codes, Integers, Reason, length_in_words

FEET = "feet"
COM = "com"
_MOST_NAMES = 4
_METRES = "; targets are in metres"


@dataclass(frozen=True, eq=False)
class WholeBodyResult:
    """Poses of the whole robot for targets of a batch shape (...); () for one.

    Attributes:
        q: configurations, shape (..., nq), with a floating base the base included; nan where the feet cannot both be
            stood on. Where targets are not met, the pose inside the limits with the least weighted sum of squares.
        torso: T_world_torso, shape (..., 4, 4).
        reasons: a `Reason` for each pose as a number, shape (...).
        residuals: by the names of the targets, what they are off by, shape (..., 2) [m, rad]; of what was not asked
            for 0. Of "com" the horizontal distance, or what the margin lacks.
        beyond: how much farther than the stretched robot the target that gives way is, or the feet are apart, at
            least, shape (...) [m]; 0 where that is not what is in the way.
        worst: which target gives way, its place in `residuals`, shape (...); −1 where none does.
        com: the centre of mass in the world, shape (..., 3) [m].
        margin: how far it is inside the support polygon of the feet that stand, negative outside, shape (...) [m].
        at_limits: which joints are at a limit, in the order of `joints`, shape (..., joints).
        joints: names of the joints.
        iterations: steps of all searches together, shape (...).
        starts: how many searches were begun before the targets were met or all were used up, shape (...).
        standing: which feet stand.
        notes: what else is to be said about the call, one line each.

    Examples:
        >>> nao = nk.load_nao()
        >>> result = nk.ik.whole_body(nao, {"LArm": [0.18, 0.1, 0.25]})
        >>> bool(result.success), result.q.shape
        (True, (25,))
    """

    q: Floats
    torso: Floats
    reasons: Codes
    residuals: Mapping[str, Floats]
    beyond: Floats
    worst: Integers
    com: Floats
    margin: Floats
    at_limits: NDArray[np.bool_]
    joints: tuple[str, ...]
    iterations: Integers
    starts: Integers
    standing: tuple[str, ...]
    notes: tuple[str, ...] = field(default=())

    @property
    def success(self) -> bool | NDArray[np.bool_]:
        """Whether all targets are met: a bool, or of a batch an array of shape (...)."""
        reached = self.reasons == Reason.REACHED
        return bool(reached) if self.reasons.ndim == 0 else np.asarray(reached)

    @property
    def reason(self) -> Reason | Codes:
        """Why: a `Reason`, or of a batch their numbers, shape (...)."""
        return Reason(int(self.reasons)) if self.reasons.ndim == 0 else self.reasons

    @property
    def gives_way(self) -> str | NDArray[np.object_]:
        """The target that gives way, "feet" where these cannot both be stood on, "" where all are met.

        It is the one with the largest weighted residual; of a batch an array, shape (...).
        """
        names = np.array([*self.residuals, FEET, ""], dtype=object)
        feet = np.isnan(self.q).any(axis=-1)
        found = names[np.where(feet, len(names) - 2, np.where(self.worst < 0, len(names) - 1, self.worst))]
        return str(found) if self.reasons.ndim == 0 else np.asarray(found)

    @property
    def message(self) -> str | NDArray[np.object_]:
        """The reason in a sentence: a str, or of a batch an array of them, shape (...)."""
        if self.reasons.ndim == 0:
            return self.describe()
        messages = np.empty(self.reasons.shape, dtype=object)
        for index in np.ndindex(*self.reasons.shape):
            messages[index] = self.describe(index)
        return messages

    def describe(self, index: tuple[int, ...] = ()) -> str:
        """The reason of one pose in a sentence.

        Args:
            index: which pose of the batch; () where there is one.

        Examples:
            >>> nao = nk.load_nao()
            >>> result = nk.ik.whole_body(nao, {"LArm": [0.18, 0.1, 0.25]})
            >>> result.describe()
            'reached; centre of mass 35.72 mm inside the support polygon'
        """
        reason = Reason(int(self.reasons[index]))
        beyond = float(self.beyond[index])
        if np.isnan(self.q[index]).any():
            if reason is not Reason.OUT_OF_REACH:
                return "no pose found that stands on both feet: do their directions fit the one motor of the hips?"
            hint = _METRES if beyond > MILLIMETRES_FROM else ""
            return f"the feet cannot both be stood on: too far apart by {length_in_words(beyond)}{hint}"
        margin = float(self.margin[index])
        side = "inside" if margin >= 0.0 else "outside"
        where = f"centre of mass {length_in_words(abs(margin))} {side} the support polygon"
        if reason is Reason.REACHED:
            return f"reached; {where}"
        name = list(self.residuals)[int(self.worst[index])]
        away, turned = (float(error) for error in self.residuals[name][index])
        amount = " and ".join(
            text for text, size in ((length_in_words(away), away), (f"{turned:.3g} rad", turned)) if size > 1e-9
        )
        amount = amount or length_in_words(away)
        why = {
            Reason.OUT_OF_REACH: "out of reach",
            Reason.TARGETS_DISAGREE: "met without the other targets, not with them",
        }.get(reason, "no pose found that meets it")
        names = [joint for joint, is_at in zip(self.joints, self.at_limits[index], strict=True) if is_at]
        limits = f"; at their limits: {', '.join(names[:_MOST_NAMES])}" if names else ""
        if len(names) > _MOST_NAMES:
            limits += f" and {len(names) - _MOST_NAMES} more"
        hint = _METRES if away > MILLIMETRES_FROM else ""
        return f"{name} gives way by {amount}: {why}{limits}{hint}"

    def __repr__(self) -> str:
        feet = " and ".join(self.standing)
        if self.reasons.ndim == 0:
            return f"<WholeBodyResult standing on {feet}: {self.describe()}>"
        reached = int(np.count_nonzero(self.success))
        return f"<WholeBodyResult standing on {feet}: {reached} of {self.reasons.size} poses reached>"
