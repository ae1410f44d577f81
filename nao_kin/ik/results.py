"""What inverse kinematics answers: solutions, and in numbers and words why there are none.

Every solver of this room returns an `IKResult`, for one target or for a batch of any shape. It keeps the joints that
were solved for; `q` and `solutions` put them into whole configurations when they are asked for.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, first_index

Integers = NDArray[np.int64]
Codes = NDArray[np.int8]

# Farther than this beyond the reach of a limb, a target was likely written in millimetres.
MILLIMETRES_FROM = 10.0


class Reason(enum.IntEnum):
    """Why a target is or is not reached; in batches as its number.

    What a closed form says of limits and joints is proven; from a search it is what none of its starts disproved.

    Attributes:
        REACHED: the pose is met, inside the limits if they are enforced.
        OUT_OF_REACH: the target is farther from the limb's base, or nearer to it, than any joint values take the limb.
        NOT_ENOUGH_JOINTS: in reach, but the joints of this limb do not make this pose whatever their limits.
        JOINT_LIMIT: every solution has a joint outside its own range.
        COUPLED_LIMIT: every solution has a joint outside its limits, in the best one a joint that is outside the range
            that another joint's value leaves it.
        HIPS_DISAGREE: the two feet ask for different values of the one motor that drives both hips.
        NOT_CONVERGED: a numerical solver gave up; there may be solutions.
        TARGETS_DISAGREE: a target that is met without the others was not met together with them.

    Examples:
        >>> far = nk.ik.arm(nk.load_nao(), "L", [1.0, 0.0, 0.0])
        >>> nk.ik.Reason(int(far.reasons)).name
        'OUT_OF_REACH'
    """

    REACHED = 0
    OUT_OF_REACH = 1
    NOT_ENOUGH_JOINTS = 2
    JOINT_LIMIT = 3
    COUPLED_LIMIT = 4
    HIPS_DISAGREE = 5
    NOT_CONVERGED = 6
    TARGETS_DISAGREE = 7


class Family(enum.IntEnum):
    """The one-parameter family of solutions that a solution stands for; in batches as its number.

    Attributes:
        NONE: the solution stands alone.
        HIP_LOCK: the axis of HipPitch is parallel to that of HipYawPitch; only the sum of both turns is determined.
        ANKLE_AXIS: the axis of AnkleRoll passes through the hip; the leg may turn about it.
        SHOULDER_AXIS: the elbow lies on the axis of ShoulderPitch; the arm may turn about it.
        ELBOW_LOCK: the arm is stretched, and ElbowYaw and WristYaw turn about one axis.
        YAW_AXIS: what is looked at lies on the axis of HeadYaw, or the camera would look along it.
        REDUNDANT: fewer numbers are asked for than the limb has joints; chosen by the criterion that was given.

    Examples:
        >>> nk.ik.Family.HIP_LOCK.name, int(nk.ik.Family.NONE)
        ('HIP_LOCK', 0)
    """

    NONE = 0
    HIP_LOCK = 1
    ANKLE_AXIS = 2
    SHOULDER_AXIS = 3
    ELBOW_LOCK = 4
    YAW_AXIS = 5
    REDUNDANT = 6


# As an int, which arrays are compared with four times as quickly.
_REACHED = int(Reason.REACHED)


@dataclass(frozen=True, eq=False)
class Obstacles:
    """What stood in the way, for each target.

    Attributes:
        joint: which of the joints solved for is outside its limits, shape (...); −1 where none is to blame.
        needed: with a joint, the value that it needs [rad, m]; else how far the target is out of reach [m], how far
            the two hips are apart [rad]; shape (...); 0 where the target is reached.
        limit: the end of the joint's range that is passed, shape (...) [rad, m]; 0 where there is no joint.

    Examples:
        >>> far = nk.ik.arm(nk.load_nao(), "L", [1.0, 0.0, 0.0])
        >>> int(far.obstacles.joint), float(far.obstacles.needed) > 0.7
        (-1, True)
    """

    joint: Integers
    needed: Floats
    limit: Floats

    @staticmethod
    def none(shape: tuple[int, ...]) -> Obstacles:
        """Nothing in the way of targets of this batch shape.

        Examples:
            >>> nk.ik.Obstacles.none((2,)).joint.tolist()
            [-1, -1]
        """
        return Obstacles(np.full(shape, -1, dtype=np.int64), np.zeros(shape), np.zeros(shape))


@dataclass(frozen=True, eq=False)
class IKResult:
    """Solutions of inverse kinematics for targets of a batch shape (...); () for one target.

    Attributes:
        joints: the joints solved for, by name.
        columns: their places in q.
        reference: the configurations that the joints not solved for are taken from, and to which solutions are
            compared, shape (..., nq); inside the limits if these are enforced.
        best: values of the joints, shape (..., c): the first solution, or the nearest pose where the solver offers one
            for a target that it does not reach, nan where there is neither.
        branches: all solutions, nearest to the reference first in the Euclidean norm of the differences of `joints`,
            shape (..., k, c); nan from `count` on.
        families: the `Family` of each, shape (..., k).
        count: how many solutions there are, shape (...).
        reasons: a `Reason` for each target as a number, shape (...).
        residual: errors of the pose at `best` in position and rotation angle, shape (..., 2) [m, rad]; of what was not
            asked for 0; nan where `best` is.
        obstacles: what stood in the way.
        notes: what else is to be said about the call, one line each.
        units: the unit of each joint; none where all are rad.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.arm(nao, "L", nao.fk(q, "LArm"))
        >>> bool(result.success), len(result.solutions), result.joints[0]
        (True, 1, 'LShoulderPitch')
    """

    joints: tuple[str, ...]
    columns: tuple[int, ...]
    reference: Floats
    best: Floats
    branches: Floats
    families: Codes
    count: Integers
    reasons: Codes
    residual: Floats
    obstacles: Obstacles
    notes: tuple[str, ...] = field(default=())
    units: tuple[str, ...] = field(default=())

    def __getattr__(self, name: str) -> Any:
        own = self.__dict__
        if (parts := own.get("_parts")) is not None:
            for attribute, value in parts().items():
                own.setdefault(attribute, value)  # of two threads the first counts
            own.pop("_parts", None)
        if name in own:
            return own[name]
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self)

    @property
    def success(self) -> bool | NDArray[np.bool_]:
        """Whether the target is reached: a bool, or of a batch an array of shape (...)."""
        reached = self.reasons == _REACHED
        return bool(reached) if self.reasons.ndim == 0 else np.asarray(reached)

    @property
    def reason(self) -> Reason | Codes:
        """Why: a `Reason`, or of a batch their numbers, shape (...)."""
        return Reason(int(self.reasons)) if self.reasons.ndim == 0 else self.reasons

    @property
    def q(self) -> Floats:
        """The best configuration, shape (..., nq): `best` in the reference; all nan where there is none."""
        q = np.array(np.broadcast_to(self.reference, (*self.best.shape[:-1], self.reference.shape[-1])))
        q[..., self.columns] = self.best
        q[np.isnan(self.best).any(axis=-1)] = np.nan
        return q

    @property
    def solutions(self) -> Floats:
        """All solutions as configurations, best first, shape (k, nq), of a batch (..., k, nq); nan from `count` on."""
        nq = self.reference.shape[-1]
        batch, k = self.branches.shape[:-2], self.branches.shape[-2]
        solutions = np.array(np.broadcast_to(self.reference[..., None, :], (*batch, k, nq)))
        solutions[..., self.columns] = self.branches
        solutions[np.arange(k) >= self.count[..., None]] = np.nan
        return solutions

    @property
    def family(self) -> Family | Codes:
        """The family of the best solution: a `Family`, or of a batch their numbers, shape (...)."""
        none = np.zeros(self.reasons.shape, dtype=np.int8)
        first = self.families[..., 0] if self.families.shape[-1] else none
        return Family(int(first)) if first.ndim == 0 else first

    @property
    def message(self) -> str | NDArray[np.object_]:
        """The reason in a sentence: a str, or of a batch an array of them, shape (...)."""
        return messages_of(self)

    def describe(self, index: tuple[int, ...] = (), *, degrees: bool = False) -> str:
        """The reason of one target in a sentence.

        Args:
            index: which target of the batch; () where there is one.
            degrees: angles in degrees.

        Examples:
            >>> nk.ik.arm(nk.load_nao(), "L", [1.0, 0.0, 0.0]).describe()
            'out of reach by 789.3 mm; the nearest pose is off by 789.3 mm'
        """
        reason = Reason(int(self.reasons[index]))
        needed, limit = float(self.obstacles.needed[index]), float(self.obstacles.limit[index])
        away, turned = (float(error) for error in self.residual[index])
        nearest = "" if np.isnan(away) else f"; the nearest pose is off by {errors_in_words(away, turned, degrees)}"
        if reason is Reason.REACHED:
            count = int(self.count[index])
            families = {Family(int(code)) for code in self.families[index][:count]} - {Family.NONE}
            if Family.REDUNDANT in families:
                return "reached, one of infinitely many solutions"
            named = f", of the family {', '.join(sorted(f.name for f in families))}" if families else ""
            return f"reached, {count} {'solution' if count == 1 else 'solutions'}{named}"
        if reason is Reason.OUT_OF_REACH:
            hint = "; targets are in metres" if needed > MILLIMETRES_FROM else ""
            return f"out of reach by {length_in_words(needed)}{nearest}{hint}"
        if reason is Reason.NOT_ENOUGH_JOINTS:
            return f"{len(self.joints)} joints do not make this pose{nearest}"
        if reason is Reason.HIPS_DISAGREE:
            return f"the hips disagree by {angle_in_words(needed, degrees)}{nearest}"
        if reason is Reason.NOT_CONVERGED:
            return f"no solution found{nearest}"
        place = int(self.obstacles.joint[index])
        joint, unit = self.joints[place], self.units[place] if self.units else "rad"
        which = "limit" if reason is Reason.JOINT_LIMIT else "coupled limit there"
        if unit == "rad" and degrees:
            needed, limit, unit = math.degrees(needed), math.degrees(limit), "°"
        unit = unit if unit == "°" else f" {unit}"
        # As many digits as it takes to tell the two apart.
        digits = next((n for n in range(3, 16) if f"{needed:.{n}g}" != f"{limit:.{n}g}"), 16)
        return f"{joint} needs {needed:.{digits}g}{unit}, {which} {limit:.{digits}g}{nearest}"

    def __repr__(self) -> str:
        if self.reasons.ndim == 0:
            return f"<IKResult of {', '.join(self.joints)}: {self.describe()}>"
        reached = int(np.count_nonzero(self.success))
        return f"<IKResult of {', '.join(self.joints)}: {reached} of {self.reasons.size} targets reached>"


def result_made_later(parts: Callable[[], dict[str, Any]], notes: tuple[str, ...]) -> IKResult:
    """A result whose other attributes are made when one of them is asked for: that takes as long as to solve."""
    result = object.__new__(IKResult)
    result.__dict__["_parts"], result.__dict__["notes"] = parts, notes
    return result


def messages_of(result: Any) -> str | NDArray[np.object_]:
    """What a result describes: a str, or of a batch an array of them, shape (...)."""
    if result.reasons.ndim == 0:
        return str(result.describe())
    messages = np.empty(result.reasons.shape, dtype=object)
    for index in np.ndindex(*result.reasons.shape):
        messages[index] = result.describe(index)
    return messages


def errors_in_words(away: float, turned: float, degrees: bool) -> str:
    """Errors in position and angle; what is exact, or was not asked for, is left out where the other is there."""
    words = (away, length_in_words(away)), (turned, angle_in_words(turned, degrees))
    return " and ".join(text for error, text in words if error > 0.0) or length_in_words(0.0)


def angle_in_words(radians: float, degrees: bool) -> str:
    """An angle to three digits."""
    return f"{math.degrees(radians):.3g}°" if degrees else f"{radians:.3g} rad"


def length_in_words(metres: float) -> str:
    """A length in the unit in which people say it, to four digits."""
    rounded = abs(float(f"{metres:.3e}"))  # 0.9999999 mm is said as 1 mm, not as 1000 µm
    for unit, scale in (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6)):
        if rounded >= scale:
            return f"{metres / scale:.4g} {unit}"
    return f"{metres / 1e-9:.4g} nm"


def crossing_in_words(crossed: NDArray[np.bool_], what: str) -> tuple[str, ...]:
    """A note on the feet whose ankles are on swapped sides, of a batch of any shape of `what`; none where none are."""
    if not crossed.any():
        return ()
    which = f" in {np.count_nonzero(crossed)} of {crossed.size} {what}, first at index {list(first_index(crossed))}"
    return (f"the feet cross: the left ankle is to the right of the right one{which if crossed.ndim else ''}",)
