"""Results of inverse kinematics: the solutions, or the reason why there are none, in numbers and words.

Every solver of this package returns an `IKResult`, for one target or for a batch of any shape. It stores the joints
that were solved for; `q` and `solutions` insert them into whole configurations on request.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, batch_index, first_index
from nao_kin._core.text import one_line_repr
from nao_kin.robot import CollisionRule, RobotModel

Integers = NDArray[np.int64]
Codes = NDArray[np.int8]
_Result = TypeVar("_Result", bound="IKResult")

# A target that is out of reach by more than this was likely written in millimetres.
MILLIMETRES_FROM = 10.0


class Reason(enum.IntEnum):
    """Why a target is or is not reached; arrays of a batch hold its number.

    A closed form proves its reason; a search reports a reason that none of its starts has disproved.

    Attributes:
        REACHED: the pose is met, inside the limits if they are enforced.
        OUT_OF_REACH: the target is farther from the limb's base, or nearer to it, than the limb can be.
        NOT_ENOUGH_JOINTS: in reach, but the joints of this limb cannot reach this pose, whatever their limits.
        JOINT_LIMIT: every solution has a joint outside its own range.
        COUPLED_LIMIT: every solution has a joint outside its limits; in the best one, outside the range at the value of
            another joint.
        HIPS_DISAGREE: the two feet need different values of the one motor that drives both hips.
        NOT_CONVERGED: a numerical solver stopped without a solution; there may be one.
        TARGETS_DISAGREE: a target that is met alone was not met together with the others.
        COLLISION: every solution found has links that overlap.

    Examples:
        >>> nk.ik.Reason(1).name
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
    COLLISION = 8


class Family(enum.IntEnum):
    """The one-parameter family of solutions that a solution represents; arrays of a batch hold its number.

    Attributes:
        NONE: the solution is isolated.
        HIP_LOCK: the axis of HipPitch is parallel to that of HipYawPitch; only the sum of both turns is determined.
        ANKLE_AXIS: the axis of AnkleRoll passes through the hip; the leg may turn about it.
        SHOULDER_AXIS: the elbow is on the axis of ShoulderPitch; the arm may turn about it.
        ELBOW_LOCK: the arm is stretched, and ElbowYaw and WristYaw turn about one axis.
        YAW_AXIS: the point is on the axis of HeadYaw, or the camera would look along it.
        REDUNDANT: the target has fewer numbers than the limb has joints; the criterion selects the solution.
        SINGULAR: for any chain (`analytic`): its axes are linearly dependent, and joints can move without moving the
            frame.

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
    SINGULAR = 7


# An int: comparing arrays with it is four times as fast.
_REACHED = int(Reason.REACHED)


@one_line_repr
@dataclass(frozen=True, eq=False)
class Obstacles:
    """The obstacle to each target.

    Attributes:
        joint: which of the joints solved for is outside its limits, shape (...); −1 if none is.
        needed: the value that this joint needs [rad, m]; without a joint, how far the target is out of reach at least
            [m], or by how much the hips disagree [rad] or links overlap [m]; 0 if the target is reached; shape (...).
        limit: the limit that the joint exceeds, shape (...) [rad, m]; 0 without a joint.
        links: which of `pairs` overlaps in the solution with the largest clearance, shape (...); −1 if none does. None
            if collisions were not checked.
        pairs: the pairs of links that are checked for collisions.
    """

    joint: Integers
    needed: Floats
    limit: Floats
    links: Integers | None = None
    pairs: tuple[tuple[str, str], ...] = ()


class Outcome:
    """The reason for each target of a batch shape (...), as a number, as a sentence, and as whether it is reached."""

    reasons: Codes

    @property
    def success(self) -> bool | NDArray[np.bool_]:
        """Whether the target is reached: a bool, or for a batch an array of shape (...)."""
        reached = self.reasons == _REACHED
        return bool(reached) if self.reasons.ndim == 0 else np.asarray(reached)

    @property
    def reason(self) -> Reason | Codes:
        """The `Reason`, or for a batch their numbers, shape (...)."""
        return Reason(int(self.reasons)) if self.reasons.ndim == 0 else self.reasons

    @property
    def message(self) -> str:
        """The reason in a sentence; for a batch a line for each target, in the order of its indices."""
        return "\n".join(map(self.describe, np.ndindex(*self.reasons.shape)))

    def describe(self, index: tuple[int, ...] = ()) -> str:
        """Return the reason of one target as a sentence."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class IKResult(Outcome):
    """Solutions of inverse kinematics for targets of a batch shape (...); () for one target.

    Attributes:
        joints: the joints solved for, by name.
        columns: their indices in q.
        near: the configurations that give the other joints, and with which solutions are compared, shape
            (..., nq); inside the limits if these are enforced.
        best: values of the joints, shape (..., c): the first solution; for a target that is not reached, the nearest
            pose if the solver finds it, else nan.
        branches: all solutions, shape (..., k, c), by the Euclidean distance of `joints` to `near`; nan from
            `count` on.
        families: the `Family` of each, shape (..., k).
        count: the number of solutions, shape (...).
        reasons: a `Reason` for each target as a number, shape (...).
        residual: errors of the pose at `best` in position and rotation angle, shape (..., 2) [m, rad]; 0 for a part
            that is not in the target; nan where `best` is.
        obstacles: the obstacle to each target.
        notes: remarks about the call, one line each.
        units: the unit of each joint; empty if all are rad.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.arm(nao, "L", nao.fk(q, "LArm"))
        >>> bool(result.success), len(result.solutions), result.joints[0]
        (True, 1, 'LShoulderPitch')
    """

    joints: tuple[str, ...]
    columns: tuple[int, ...]
    near: Floats
    best: Floats
    branches: Floats
    families: Codes
    count: Integers
    reasons: Codes
    residual: Floats
    obstacles: Obstacles
    notes: tuple[str, ...] = field(default=())
    units: tuple[str, ...] = field(default=())

    if not TYPE_CHECKING:  # for type checkers, every name would exist

        def __getattr__(self, name: str) -> Any:
            own = self.__dict__
            if (parts := own.get("_parts")) is not None:
                for attribute, value in parts().items():
                    own.setdefault(attribute, value)  # the first of two threads wins
                own.pop("_parts", None)
            if name in own:
                return own[name]
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self)

    @property
    def q(self) -> Floats:
        """The best configuration, shape (..., nq): `near` with the values of `best`; nan if `best` is nan."""
        q = np.array(np.broadcast_to(self.near, (*self.best.shape[:-1], self.near.shape[-1])))
        q[..., self.columns] = self.best
        q[np.isnan(self.best).any(axis=-1)] = np.nan
        return q

    @property
    def solutions(self) -> Floats:
        """All solutions as configurations, best first, shape (k, nq), for a batch (..., k, nq); nan from `count` on."""
        nq = self.near.shape[-1]
        batch, k = self.branches.shape[:-2], self.branches.shape[-2]
        solutions = np.array(np.broadcast_to(self.near[..., None, :], (*batch, k, nq)))
        solutions[..., self.columns] = self.branches
        solutions[np.arange(k) >= self.count[..., None]] = np.nan
        return solutions

    @property
    def family(self) -> Family | Codes:
        """The family of the best solution: a `Family`, or for a batch their numbers, shape (...)."""
        none = np.zeros(self.reasons.shape, dtype=np.int8)
        first = self.families[..., 0] if self.families.shape[-1] else none
        return Family(int(first)) if first.ndim == 0 else first

    def describe(self, index: tuple[int, ...] = (), *, degrees: bool = False) -> str:
        """Return the reason of one target as a sentence.

        Args:
            index: index of the target in the batch; () for a single one.
            degrees: whether angles are in degrees.

        Examples:
            >>> nk.ik.arm(nk.load_nao(), "L", [1.0, 0.0, 0.0]).describe()
            'out of reach; the nearest pose is off by 789.3 mm'
        """
        index = batch_index(index, self.reasons.shape)
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
            return f"out of reach{nearest or f' by at least {length_in_words(needed)}'}{hint}"
        if reason is Reason.NOT_ENOUGH_JOINTS:
            return f"{len(self.joints)} joints do not make this pose{nearest}"
        if reason is Reason.HIPS_DISAGREE:
            return f"the hips disagree by {angle_in_words(needed, degrees)}{nearest}"
        if reason is Reason.COLLISION and self.obstacles.links is not None:
            return overlap_in_words(self.obstacles.pairs[int(self.obstacles.links[index])], needed)
        if reason is Reason.NOT_CONVERGED:
            return f"no solution found{nearest}"
        place = int(self.obstacles.joint[index])
        joint, unit = self.joints[place], self.units[place] if self.units else "rad"
        which = "limit" if reason is Reason.JOINT_LIMIT else "coupled limit there"
        if unit == "rad" and degrees:
            needed, limit, unit = math.degrees(needed), math.degrees(limit), "°"
        unit = unit if unit == "°" else f" {unit}"
        # As many digits as distinguish the two.
        digits = next((n for n in range(3, 16) if f"{needed:.{n}g}" != f"{limit:.{n}g}"), 16)
        return f"{joint} needs {needed:.{digits}g}{unit}, {which} {limit:.{digits}g}{nearest}"

    def __repr__(self) -> str:
        if self.reasons.ndim == 0:
            return f"<IKResult of {', '.join(self.joints)}: {self.describe()}>"
        reached = int(np.count_nonzero(self.success))
        return f"<IKResult of {', '.join(self.joints)}: {reached} of {self.reasons.size} targets reached>"


def deferred_result(parts: Callable[[], dict[str, Any]], notes: tuple[str, ...]) -> IKResult:
    """Return a result that computes its attributes except `notes` on first use: that takes as long as solving."""
    result = object.__new__(IKResult)
    result.__dict__["_parts"], result.__dict__["notes"] = parts, notes
    return result


def errors_in_words(away: float, turned: float, degrees: bool) -> str:
    """Return errors in position and angle in words; a zero is left out if the other is not zero."""
    words = (away, length_in_words(away)), (turned, angle_in_words(turned, degrees))
    return " and ".join(text for error, text in words if error > 0.0) or length_in_words(0.0)


def overlap_in_words(links: tuple[str, str], depth: float) -> str:
    """Return that links overlap in every solution, in the best one by this depth [m]."""
    return f"every solution has links that overlap: {' and '.join(links)} by {length_in_words(depth)} or more"


def angle_in_words(radians: float, degrees: bool) -> str:
    """Return an angle to three digits."""
    return f"{math.degrees(radians):.3g}°" if degrees else f"{radians:.3g} rad"


def length_in_words(metres: float) -> str:
    """Return a length to four digits, in the unit that suits it."""
    rounded = abs(float(f"{metres:.3e}"))  # 0.9999999 mm is written 1 mm, not 1000 µm
    for unit, scale in (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6)):
        if rounded >= scale:
            return f"{metres / scale:.4g} {unit}"
    return f"{metres / 1e-9:.4g} nm"


def crossing_in_words(crossed: NDArray[np.bool_], what: str) -> tuple[str, ...]:
    """Return a note if some pairs of feet of a batch of `what` have their ankles on swapped sides."""
    if not crossed.any():
        return ()
    which = f" in {np.count_nonzero(crossed)} of {crossed.size} {what}, first at index {list(first_index(crossed))}"
    return (f"the feet cross: the left ankle is to the right of the right one{which if crossed.ndim else ''}",)


def without_collisions(
    robot: RobotModel, result: _Result, collisions: bool | CollisionRule = True, begin: Floats | None = None
) -> _Result:
    """Return a result without the solutions in which links overlap, and with a note on their number.

    Only pairs that the joints of the result move are checked; those that overlap in a configuration at the beginning,
    `near` if None, may not overlap more. If links overlap in all solutions of a target, `best` is the one with the
    largest clearance.
    """
    rule = None if collisions is False else CollisionRule.of(collisions)
    if rule is None:
        return result
    q = result.solutions
    exists = np.arange(q.shape[-2]) < result.count[..., None]
    near = result.near[..., None, :]
    q = np.where(exists[..., None], q, near)
    clearance = robot.link_shapes.clearance_from(q, near if begin is None else begin, rule, result.columns)
    keep = exists & clearance.is_free
    left_out = int(np.count_nonzero(exists & ~keep))
    if not left_out:
        return result
    order = np.argsort(~keep, axis=-1, kind="stable")
    count = keep.sum(axis=-1)
    gone = np.arange(q.shape[-2]) >= count[..., None]
    branches = np.take_along_axis(result.branches, order[..., None], axis=-2)
    families = np.take_along_axis(result.families, order, axis=-1)
    lost = (result.count > 0) & (count == 0)
    widest = np.argmax(np.where(exists, clearance.distance, -np.inf), axis=-1)[..., None]
    overlapping = np.take_along_axis(result.branches, widest[..., None], axis=-2)[..., 0, :]
    best = np.where((count > 0)[..., None], branches[..., 0, :], np.where(lost[..., None], overlapping, result.best))
    branches[gone], families[gone] = np.nan, 0
    pair = np.take_along_axis(clearance.pair_index, widest, axis=-1)[..., 0]
    depth = np.take_along_axis(-clearance.distance, widest, axis=-1)[..., 0]
    obstacles = replace(
        result.obstacles,
        needed=np.where(lost, depth, result.obstacles.needed),
        links=np.where(lost, pair, -1),
        pairs=clearance.pairs,
    )
    note = f"{left_out} of {np.count_nonzero(exists)} solutions are left out: links overlap"
    return replace(
        result,
        best=best,
        branches=branches,
        families=families,
        count=count,
        reasons=np.where(lost, np.int8(Reason.COLLISION), result.reasons),
        obstacles=obstacles,
        notes=(*result.notes, note),
    )
