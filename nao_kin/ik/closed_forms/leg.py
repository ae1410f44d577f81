"""`leg`: all branches of one leg for the pose of its foot, by the closed form of `leg_equations`."""

from __future__ import annotations

from functools import partial
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats
from nao_kin.ik.closed_forms.leg_equations import JOINTS, MOST_BRANCHES, Leg, solve_leg
from nao_kin.ik.closed_forms.nearest_feet import brought_into_reach, missed, nearest_feet
from nao_kin.ik.closed_forms.ranges import BESIDE, Ranges, laid_down
from nao_kin.ik.closed_forms.solving import ClosedForm, solved
from nao_kin.ik.compiling import kept, limb_arguments
from nao_kin.ik.geometry import Limb, X, Y, chain_at_zero, check_side, kappa_of, kept_limb, limb_of
from nao_kin.ik.results import IKResult, Integers
from nao_kin.ik.targets import Limits, as_poses, as_reference, check_threads, is_enforced, refuse_not_rigid
from nao_kin.robot import RobotModel

_JOINTS = ("HipYawPitch", "HipRoll", "HipPitch", "KneePitch", "AnklePitch", "AnkleRoll")


def leg(
    robot: RobotModel,
    side: str,
    T_torso_foot: ArrayLike,
    *,
    frame: str | None = None,
    reference: ArrayLike | None = None,
    limits: Limits = "enforce",
    threads: SupportsIndex | None = None,
) -> IKResult:
    """All joint values of a leg with which its foot has a given pose: up to eight branches, each verified.

    Where the target is not met, `best` and `q` are the nearest joint values that a search finds, inside the limits if
    these are enforced: with the smallest √(distance² + (0.1 m · angle)²); `residual` has the distance and the angle.

    Both legs share the motor of their HipYawPitch: a solution of the right leg sets the coordinate LHipYawPitch, and
    with it moves the left leg.

    Args:
        robot: a NAO of any version, or another robot with legs of its geometry.
        side: "L" or "R".
        T_torso_foot: the pose of the frame in the torso, shape (..., 4, 4) [m].
        frame: a frame on the foot; None for the end effector "LLeg" or "RLeg".
        reference: configurations that broadcast with the targets, shape (..., nq): solutions are sorted by their
            distance to it, and take from it the joints that are not of this leg. None for all joints at zero, or at
            the limit nearest to it.
        limits: "enforce" leaves out branches with a joint outside its own or a coupled limit; "ignore" gives all, each
            joint with the whole turns that bring it within half a turn of the reference.
        threads: how many threads may work on a batch; None for all cores where that is worthwhile.

    Returns:
        Solutions to within 1e-10 m and rad, the errors in `residual`: of the rotation nearest to the one of the target,
        so that rounded poses, to float32 for instance, are met too. For the same reason a straight leg solves a target
        that is out of its reach by up to 1e-6 m, and `residual` says by how much. A family of solutions is there once,
        by its member that is inside the limits and nearest to the reference: the hip at lock (`HIP_LOCK`), or the hip
        on the axis of AnkleRoll (`ANKLE_AXIS`). A knee within 1e-7 rad of straight is straight: its two branches are
        one.

    Raises:
        UnknownName: no such side, frame or policy.
        BadArgument: the robot has no such leg; the message says what is missing. Or the last row of a target is not
            0, 0, 0, 1, or a number is beyond ±1e150.
        NotARotation: a target has no rotation; names the argument, its index and its defect.
        WrongShape, NotFinite: arrays of other shapes, NaN or infinity.

    Source: the derivation is in docs/inverse_kinematics.md.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.leg(nao, "L", nao.fk(q, "LLeg"))
        >>> bool(result.success), result.solutions.shape
        (True, (1, 25))
    """
    limb = leg_limb(robot, check_side(side), frame)
    T = as_poses(T_torso_foot, "T_torso_foot")
    enforce, workers, batch = is_enforced(limits), check_threads(threads), T.shape[:-2]
    references = as_reference(robot, limb.rest, reference, batch, enforce)
    targets = T.reshape(*batch, 16)
    refuse = partial(refuse_not_rigid, T, "T_torso_foot")
    result = solved(_LEG, limb, targets, references, enforce, workers, refuse)
    away = missed(result)
    if away.any():
        near = np.broadcast_to(references[0], (*batch, robot.nq))[away]
        result.best[away], result.residual[away] = nearest_foot(robot, limb, T[away], near, enforce, workers)
    return result


def nearest_foot(
    robot: RobotModel, limb: Limb, T: Floats, reference: Floats, enforce: bool, threads: int | None
) -> tuple[Floats, Floats]:
    """Coordinates nearest to n targets, and their errors, shape (n, 2), as `nearest_feet`."""
    starts = _branches_in_reach(robot, limb, T)
    best, errors = nearest_feet(robot, (limb.frame,), limb, T[:, None], reference, starts, enforce, threads)
    return best, errors[:, 0]


def _branches_in_reach(robot: RobotModel, limb: Limb, T: Floats) -> list[Floats]:
    """The coordinates of all branches for n targets brought into reach, each of shape (n, c); whatever the limits."""
    targets = brought_into_reach(limb.numbers, T).reshape(-1, 16)
    references = np.broadcast_to(limb.rest, (len(T), robot.nq)), ()
    if len(T) == 1:
        found = solved(_LEG, limb, targets[0], (limb.rest, ()), False, None, lambda: None).branches[None]
    else:
        found = solved(_LEG, limb, targets, references, False, None, lambda: None).branches
    branches = np.where(np.isnan(found), limb.rest[limb.index], found)
    return list(branches.swapaxes(0, 1))


def leg_limb(robot: RobotModel, side: str, frame: str | None) -> Limb:
    """A leg of a robot as the closed form takes it.

    Raises:
        BadArgument: the robot has none of this geometry.
        UnknownName: no such frame.
    """
    return kept_limb(robot, _leg_of, side, f"{side}Leg" if frame is None else frame)


def _leg_of(robot: RobotModel, side: str, frame: str) -> Limb:
    chain = chain_at_zero(robot, "leg", tuple(side + joint for joint in _JOINTS), frame)
    for index, axis in ((1, X), (2, Y), (3, Y), (4, Y), (5, X)):
        chain.require_axis(index, axis)
    kappa = kappa_of(chain.axes[0])
    chain.require_axis(0, (0.0, float(np.cos(kappa)), float(np.sin(kappa))))
    chain.require_meeting(0, 1)
    chain.require_meeting(0, 2)
    chain.require_meeting(4, 5)
    hip, knee, ankle = chain.points[0], chain.points[3], chain.points[4]
    thigh, tibia = hip - knee, knee - ankle
    chain.require_zero("knee and ankle are not below the hip", np.concatenate([thigh[:2], tibia[:2]]))
    if min(thigh[2], tibia[2]) <= 0.0:
        raise chain.missing("knee and ankle are not below the hip")
    turned = 0.0 if np.array_equal(chain.rotation, np.eye(3)) else 1.0
    numbers = (*hip, kappa, *chain.axes[0][1:], thigh[2], tibia[2], turned)
    rest = (*chain.rotation.ravel(), *(chain.point - ankle))
    return limb_of(chain, frame, Leg(*(float(value) for value in (*numbers, *rest))))


@kept("legs", lambda: limb_arguments(Leg, len(Leg._fields), JOINTS))
def _legs(
    limb: Leg,
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
        count[i] = solve_leg(limb, ranges, targets[i], references[i], enforce, q, found, report[i])
        laid_down(found, count[i], values[i], beside[i])


_LEG = ClosedForm(solve_leg, _legs, MOST_BRANCHES)

LEG_KERNELS = (_legs,)
