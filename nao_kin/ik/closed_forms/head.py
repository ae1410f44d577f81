"""`head` and `look_at`: the two joints of the neck, for an orientation or for a point that a camera is to see."""

from __future__ import annotations

from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._common.arrays import Floats, as_floats
from nao_kin._common.vectors import as_vectors
from nao_kin.errors import UnknownName
from nao_kin.ik.closed_forms.head_equations import JOINTS, MOST_BRANCHES, Head, solve_gaze, solve_head
from nao_kin.ik.closed_forms.ranges import BESIDE, Ranges, laid_down
from nao_kin.ik.closed_forms.solving import ClosedForm, solved
from nao_kin.ik.compiling import kept, limb_arguments
from nao_kin.ik.geometry import Limb, Y, Z, chain_at_zero, kept_limb, limb_of
from nao_kin.ik.results import IKResult, Integers
from nao_kin.ik.targets import Limits, as_reference, check_threads, is_enforced, refuse_not_rotation
from nao_kin.robot import RobotModel, check_robot

_JOINTS = ("HeadYaw", "HeadPitch")


def head(
    robot: RobotModel,
    R_torso_head: ArrayLike,
    *,
    frame: str = "Head",
    reference: ArrayLike | None = None,
    limits: Limits = "enforce",
    threads: SupportsIndex | None = None,
) -> IKResult:
    """The joint values with which the head has an orientation, or comes nearest to it.

    Two joints make two of three turns: an orientation that leans to a side is out of their reach. `best` and `q` then
    hold the joint values that are nearest by angle, inside the limits if these are enforced, and `residual` how far
    they are off; so they do where only the limits are in the way.

    Args:
        robot: a NAO of any version, or another robot with a neck of its geometry.
        R_torso_head: orientations of the frame in the torso, shape (..., 3, 3).
        frame: a frame on the head, a camera for instance.
        reference: configurations that broadcast with the targets, shape (..., nq), from which the other joints are
            taken; None for all joints at zero, or at the limit nearest to it.
        limits: "enforce" keeps joints inside their limits, the range of HeadPitch at this HeadYaw included.
        threads: how many threads may work on a batch; None for all cores where that is worthwhile.

    Returns:
        One solution at most, to within 1e-10 rad. Two joints make no orientation that is rounded, to float32 for
        instance: its reason is `NOT_ENOUGH_JOINTS`, `q` the nearest and `residual` what is left, some 1e-8 rad.

    Raises:
        UnknownName: no such frame or policy.
        BadArgument: the robot has no such neck; the message says what is missing.
        NotARotation: a target is no rotation; names the argument, its index and its defect.
        WrongShape, NotFinite: arrays of other shapes, NaN or infinity.

    Examples:
        >>> nao = nk.load_nao()
        >>> result = nk.ik.head(nao, nk.rotations.rot_z(0.5))
        >>> nao.angles(result.q)["HeadYaw"]
        0.5
    """
    limb = head_limb(robot, frame)
    R = as_vectors(as_floats(R_torso_head, (3, 3), "R_torso_head"), "R_torso_head", rows=True)
    enforce, batch = is_enforced(limits), R.shape[:-2]
    references = as_reference(robot, limb.rest, reference, batch, enforce)
    T = np.zeros((*batch, 4, 4))
    T[..., :3, :3], T[..., 3, 3] = R, 1.0
    targets = T.reshape(*batch, 16)
    workers = check_threads(threads)
    return solved(_HEAD, limb, targets, references, enforce, workers, lambda: refuse_not_rotation(R, "R_torso_head"))


def look_at(
    robot: RobotModel,
    point: ArrayLike,
    camera: str = "CameraTop",
    *,
    reference: ArrayLike | None = None,
    limits: Limits = "enforce",
    threads: SupportsIndex | None = None,
) -> IKResult:
    """The joint values with which a camera has a point on its optical axis, before it.

    The camera's place and tilt in the head are exact. There are two solutions, the second with the head turned round
    and looking over the crown. For a point on the axis of HeadYaw any yaw will do (`YAW_AXIS`). What is in the way of
    the limits, or too near the neck to be looked at, is answered with the joint values that leave the smallest angle
    between the optical axis and the direction to the point; `residual` has that angle.

    Args:
        robot: a NAO of any version, or another robot with a neck of its geometry.
        point: points in the torso, shape (..., 3) [m].
        camera: one of the robot's cameras, or any frame on the head that looks along its x axis and has its origin and
            this axis in the plane of x and z.
        reference: as in `head`.
        limits: as in `head`.
        threads: as in `head`.

    Raises:
        UnknownName: no such camera or policy.
        BadArgument: the robot has no such neck, or the camera is not in the head's plane of symmetry. Or a number is
            beyond ±1e150.
        WrongShape, NotFinite: no points, NaN or infinity.

    Examples:
        >>> nao = nk.load_nao()
        >>> result = nk.ik.look_at(nao, [1.0, 0.3, 0.1])
        >>> point = np.append([1.0, 0.3, 0.1], 1.0)
        >>> (np.linalg.inv(nao.fk(result.q, "CameraTop_optical_frame")) @ point)[:2].round(9).tolist()
        [0.0, 0.0]
    """
    check_robot(robot)
    if not isinstance(camera, str) or camera not in robot.frame_table:
        raise UnknownName("camera", camera, robot.semantics.cameras)
    limb = camera_limb(robot, camera)
    points = as_vectors(point, "point")
    enforce, batch = is_enforced(limits), points.shape[:-1]
    references = as_reference(robot, limb.rest, reference, batch, enforce)
    return solved(_GAZE, limb, points, references, enforce, check_threads(threads), lambda: None)


def head_limb(robot: RobotModel, frame: str) -> Limb:
    """The head of a robot as the closed form takes it.

    Raises:
        BadArgument: the robot has none of this geometry.
        UnknownName: no such frame.
    """
    return kept_limb(robot, _head_of, frame)


def camera_limb(robot: RobotModel, camera: str) -> Limb:
    """The same for a camera, which has to be in the head's plane of symmetry.

    Raises:
        BadArgument, UnknownName: as `head_limb`; or it is beside that plane.
    """
    return kept_limb(robot, _camera_of, camera)


def _head_of(robot: RobotModel, frame: str) -> Limb:
    chain = chain_at_zero(robot, "head", _JOINTS, frame)
    chain.require_axis(0, Z)
    chain.require_axis(1, Y)
    chain.require_meeting(0, 1)
    place = chain.point - chain.points[0]
    numbers = (*chain.points[0], *chain.rotation.ravel(), place[0], place[2])
    return limb_of(chain, frame, Head(*(float(value) for value in numbers)))


def _camera_of(robot: RobotModel, camera: str) -> Limb:
    chain = chain_at_zero(robot, "head", _JOINTS, camera)
    aside = np.array([chain.point[1] - chain.points[0][1], chain.rotation[1, 0]])
    chain.require_zero(f"{camera} is beside the head's plane of symmetry, or looks out of it", aside)
    return _head_of(robot, camera)


_ARGUMENTS = Head, len(Head._fields), JOINTS


@kept("heads", lambda: limb_arguments(*_ARGUMENTS))
def _heads(
    limb: Head,
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
        count[i] = solve_head(limb, ranges, targets[i], references[i], enforce, q, found, report[i])
        laid_down(found, count[i], values[i], beside[i])


@kept("gazes", lambda: limb_arguments(*_ARGUMENTS))
def _gazes(
    limb: Head,
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
        count[i] = solve_gaze(limb, ranges, targets[i], references[i], enforce, q, found, report[i])
        laid_down(found, count[i], values[i], beside[i])


_HEAD = ClosedForm(solve_head, _heads, MOST_BRANCHES)
_GAZE = ClosedForm(solve_gaze, _gazes, MOST_BRANCHES)

HEAD_KERNELS = (_heads, _gazes)
