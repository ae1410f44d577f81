"""`arm`: the five joints of an arm, for a pose of the hand, its place and direction, or its place alone."""

from __future__ import annotations

import dataclasses
from typing import Any, Literal, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats, as_floats, as_numbers
from nao_kin._common.scalars import check_tolerance
from nao_kin._common.vectors import LARGEST, as_vectors, common_batch, unit
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.ik.closed_forms.arm_equations import JOINTS, MOST_BRANCHES, Arm, solve_arm, solve_direction
from nao_kin.ik.closed_forms.arm_search import (
    LIMITS,
    MANIPULABILITY,
    NEAREST,
    nearest_direction,
    nearest_pose,
    solve_position,
)
from nao_kin.ik.closed_forms.ranges import BESIDE, NOT_RIGID, REASON, Ranges, laid_down
from nao_kin.ik.closed_forms.solving import ClosedForm, solved
from nao_kin.ik.compiling import kept, limb_arguments
from nao_kin.ik.geometry import Limb, X, Y, Z, chain_at_zero, check_side, kept_limb, limb_of
from nao_kin.ik.results import IKResult, Integers
from nao_kin.ik.targets import Limits, as_poses, as_reference, check_threads, choice, is_enforced, refuse_not_rigid
from nao_kin.robot import RobotModel

Criterion = Literal["nearest", "limits", "manipulability"]
_CRITERIA = {"nearest": NEAREST, "limits": LIMITS, "manipulability": MANIPULABILITY}
_WEIGHT = 0.1
_JOINTS = ("ShoulderPitch", "ShoulderRoll", "ElbowYaw", "ElbowRoll", "WristYaw")


def arm(
    robot: RobotModel,
    side: str,
    target: ArrayLike,
    *,
    direction: ArrayLike | None = None,
    criterion: Criterion = "nearest",
    angle_weight: float = _WEIGHT,
    frame: str | None = None,
    reference: ArrayLike | None = None,
    limits: Limits = "enforce",
    threads: SupportsIndex | None = None,
) -> IKResult:
    """Joint values of an arm for a pose of its hand, for place and direction, or for a place.

    - A pose (..., 4, 4) is six numbers, one more than there are joints: the arm makes it where the elbow that it asks
      for is as far from the shoulder as the upper arm is long. Then all branches are given, up to four.
    - A place (..., 3) and a `direction` of the forearm, which is that of the hand, are five: up to eight branches.
    - A place alone leaves two joints free: the one member of that family that is best by `criterion`.

    Where a target is not met, `best` and `q` are the joint values nearest to it, inside the limits if these are
    enforced: with the smallest √(distance² + (angle_weight · angle)²); `residual` has the distance and the angle.
    `success` is then False and `reason` says why.

    Args:
        robot: a NAO of any version, or another robot with arms of its geometry.
        side: "L" or "R".
        target: poses of the frame in the torso, shape (..., 4, 4), or places of its origin, shape (..., 3) [m].
        direction: with places: where the forearm's x axis is to point, in the torso, of any length but zero; shape
            (..., 3), broadcasts with the places.
        criterion: with places alone: "nearest" to the reference, "limits" for the largest distance to the nearest
            limit as a share of that joint's range, or "manipulability" for the largest √det(J_v J_vᵀ). The choice is
            searched for on a grid, and from its valleys by steps down to 1e-9 rad.
        angle_weight: what one radian counts [m]: 0.1 makes 0.1 rad as bad as 10 mm.
        frame: a frame on the hand; None for the end effector "LArm" or "RArm".
        reference: configurations that broadcast with the targets, shape (..., nq): solutions are sorted by their
            distance to it, and take from it the joints that are not of this arm. None for all joints at zero, or at
            the limit nearest to it.
        limits: "enforce" leaves out branches with a joint outside its limits; "ignore" gives all, each joint with the
            whole turns that bring it within half a turn of the reference; with criterion "limits" within ±π.
        threads: how many threads may work on a batch; None for all cores where that is worthwhile.

    Returns:
        Solutions to within 1e-10 m and rad. Five joints make no pose that is rounded, to float32 for instance: its
        reason is `NOT_ENOUGH_JOINTS`, `q` the nearest, and `residual` what is left, some 1e-8 m and rad. A family of
        solutions is there once: the elbow on the axis of ShoulderPitch (`SHOULDER_AXIS`), the stretched arm
        (`ELBOW_LOCK`), a place alone (`REDUNDANT`).

    Raises:
        UnknownName: no such side, frame, criterion or policy.
        BadArgument: the robot has no such arm; the message says what is missing. Or the last row of a target is not
            0, 0, 0, 1, a number is beyond ±1e150, `angle_weight` no length above zero, or a direction comes with poses.
        NotARotation: a target has no rotation; names the argument, its index and its defect.
        ZeroNorm: a direction is zero.
        WrongShape, NotFinite: arrays of other shapes, NaN or infinity.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.arm(nao, "L", nao.fk(q, "LArm"))
        >>> bool(np.abs(nao.fk(result.q, "LArm") - nao.fk(q, "LArm")).max() < 1e-9)
        True
    """
    check_side(side)
    limb = arm_limb(robot, side, frame)
    enforce, workers = is_enforced(limits), check_threads(threads)
    wanted = _CRITERIA[choice(criterion, _CRITERIA, "criterion")]
    check_tolerance(angle_weight, "angle_weight")
    weight = float(angle_weight)
    if not 0.0 < weight <= LARGEST:
        raise BadArgument(f"angle_weight must be a length above zero, and at most {LARGEST:.0e}, got {angle_weight}")
    if weight != _WEIGHT:
        limb = dataclasses.replace(limb, numbers=limb.numbers._replace(weight=weight))
    numbers = as_numbers(target, "target")
    if numbers.shape[-2:] == (4, 4):
        if direction is not None:
            raise BadArgument("a direction goes with places (..., 3), a pose (..., 4, 4) has one")
        T = as_poses(numbers, "target")
        batch = T.shape[:-2]
        rows = T.reshape(*batch, 16)
        references = as_reference(robot, limb.rest, reference, batch, enforce)
        return solved(_POSE, limb, rows, references, enforce, workers, lambda: refuse_not_rigid(T, "target"))
    if numbers.shape[-1:] != (3,):
        raise WrongShape("target", "(..., 4, 4) for poses or (..., 3) for places", numbers.shape)
    places = as_vectors(numbers, "target")
    if direction is None:
        references = as_reference(robot, limb.rest, reference, places.shape[:-1], enforce)
        criteria = np.full((*places.shape[:-1], 1), wanted)
        rows = np.concatenate([places, criteria], axis=-1)
        return solved(_POSITION, limb, rows, references, enforce, workers, lambda: None)
    towards = as_floats(direction, (3,), "direction")
    try:
        batch = common_batch("direction", places.shape[:-1], towards.shape[:-1])
    except WrongShape:
        raise WrongShape("direction", f"{places.shape} as the places, or (3,)", towards.shape) from None
    rows = np.empty((*batch, 6))
    rows[..., :3], rows[..., 3:] = places, unit(towards, "direction")[0]
    references = as_reference(robot, limb.rest, reference, batch, enforce)
    return solved(_DIRECTION, limb, rows, references, enforce, workers, lambda: None)


def arm_limb(robot: RobotModel, side: str, frame: str | None) -> Limb:
    """An arm of a robot as the closed form takes it.

    Raises:
        BadArgument: the robot has none of this geometry.
        UnknownName: no such frame.
    """
    return kept_limb(robot, _arm_of, side, f"{side}Arm" if frame is None else frame)


def _arm_of(robot: RobotModel, side: str, frame: str) -> Limb:
    chain = chain_at_zero(robot, "arm", tuple(side + joint for joint in _JOINTS), frame)
    for index, axis in enumerate((Y, Z, X, Z, X)):
        chain.require_axis(index, axis)
    chain.require_meeting(0, 1)
    chain.require_meeting(2, 3)
    shoulder, elbow, wrist = chain.points[0], chain.points[2], chain.points[4]
    chain.require_zero("the axis of WristYaw passes the elbow", (wrist - elbow)[1:])
    chain.require_zero("the elbow is out of the plane of the upper arm", (elbow - shoulder)[2:])
    turned = 0.0 if np.array_equal(chain.rotation, np.eye(3)) else 1.0
    numbers = (*shoulder, *(elbow - shoulder)[:2], *(chain.point - elbow), _WEIGHT, turned, *chain.rotation.ravel())
    return limb_of(chain, frame, Arm(*(float(value) for value in numbers)))


_ARGUMENTS = Arm, len(Arm._fields), JOINTS


@kept("arms by pose", lambda: limb_arguments(*_ARGUMENTS))
def _poses(
    limb: Arm,
    ranges: Ranges,
    targets: Floats,
    references: Floats,
    enforce: bool,
    most: int,
    values: Any,
    beside: Any,
    count: Integers,
    report: Floats,
) -> None:
    found, q = np.empty(most * (references.shape[1] + BESIDE)), np.empty(references.shape[1])
    for i in range(targets.shape[0]):
        count[i] = solve_arm(limb, ranges, targets[i], references[i], enforce, q, found, report[i])
        if count[i] == 0 and report[i, REASON] != NOT_RIGID:
            nearest_pose(limb, ranges, targets[i], references[i], enforce, report[i])
        laid_down(found, count[i], values[i], beside[i])


@kept("arms by place and direction", lambda: limb_arguments(*_ARGUMENTS))
def _directions(
    limb: Arm,
    ranges: Ranges,
    targets: Floats,
    references: Floats,
    enforce: bool,
    most: int,
    values: Any,
    beside: Any,
    count: Integers,
    report: Floats,
) -> None:
    found, q = np.empty(most * (references.shape[1] + BESIDE)), np.empty(references.shape[1])
    for i in range(targets.shape[0]):
        count[i] = solve_direction(limb, ranges, targets[i], references[i], enforce, q, found, report[i])
        if count[i] == 0:
            nearest_direction(limb, ranges, targets[i], references[i], enforce, report[i])
        laid_down(found, count[i], values[i], beside[i])


@kept("arms by place", lambda: limb_arguments(*_ARGUMENTS))
def _places(
    limb: Arm,
    ranges: Ranges,
    targets: Floats,
    references: Floats,
    enforce: bool,
    most: int,
    values: Any,
    beside: Any,
    count: Integers,
    report: Floats,
) -> None:
    found, q = np.empty(most * (references.shape[1] + BESIDE)), np.empty(references.shape[1])
    for i in range(targets.shape[0]):
        count[i] = solve_position(limb, ranges, targets[i], references[i], enforce, q, found, report[i])
        laid_down(found, count[i], values[i], beside[i])


_POSE = ClosedForm(solve_arm, _poses, MOST_BRANCHES, searches=True)
_DIRECTION = ClosedForm(solve_direction, _directions, MOST_BRANCHES, searches=True)
_POSITION = ClosedForm(None, _places, 1)

ARM_KERNELS = (_poses, _directions, _places)
