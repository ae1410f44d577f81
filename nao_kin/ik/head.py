"""`head` and `look_at`: the two joints of the neck, for an orientation, a position, or a point on an optical axis."""

from __future__ import annotations

import dataclasses
import math
from functools import partial
from typing import NamedTuple, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, SolverLimits, as_floats
from nao_kin._core.text import quoted
from nao_kin._kernels.cache import Row, both_ways
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik.branches import (
    ANGLE_ERROR,
    BEST,
    EXCESS,
    LIMIT_ROUNDING,
    NEEDED,
    NOT_ENOUGH_JOINTS,
    NOT_RIGID,
    OUT_OF_REACH,
    POSITION_ERROR,
    REASON,
    VERIFIED,
    Rotation,
    Selection,
    Vector,
    Workspace,
    add_branch,
    angle_of_chord,
    check_limits,
    coupled_range,
    finish_report,
    least,
    link_rotation,
    start_report,
)
from nao_kin.ik.closed_form import TOLERANCE, ClosedForm, Limb, cached_limb, chain_at_zero, limb_of, limb_types, solve
from nao_kin.ik.results import Family, IKResult, Obstacles, Reason, without_collisions
from nao_kin.ik.targets import Options, as_options
from nao_kin.robot import CollisionRule, RobotModel
from nao_kin.rotations import check_rotation, rotation_between

_JOINTS = ("HeadYaw", "HeadPitch")


def head(
    robot: RobotModel,
    target: ArrayLike | None = None,
    *,
    position: ArrayLike | None = None,
    frame: str = "Head",
    near: ArrayLike | None = None,
    limits: SolverLimits = "enforce",
    threads: SupportsIndex | None = None,
    collisions: bool | CollisionRule = False,
) -> IKResult:
    """Compute the joint values that give the head an orientation, or a frame of it a position, or the nearest one.

    Two joints allow only two of the three rotations: they cannot tilt the head sideways. They move a frame on a sphere
    about the neck, which has a hole about the axis of HeadYaw, above and below, as wide as the frame is beside the
    head's middle. A measured position, of a marker for instance, is never exactly on it. If the target is not
    met, `best` and `q` are the joint values with the smallest angle to it, or distance from it, inside the limits if
    these are enforced.

    Args:
        robot: a NAO of any version, or another robot with a neck of its geometry.
        target: orientations of the frame in the torso, shape (..., 3, 3); None with `position`.
        position: positions of the frame's origin in the torso, shape (..., 3) [m]; None with `target`.
        frame: a frame on the head, a camera for instance.
        near: as in all solvers, see `nao_kin.ik`.
        limits: as in all solvers.
        threads: as in all solvers.
        collisions: as in all solvers.

    Returns:
        At most one solution for an orientation, to within 1e-10 rad. Two joints cannot meet an orientation that is
        rounded, for instance to float32: its reason is `NOT_ENOUGH_JOINTS`, and `q` are the nearest joint values, some
        1e-8 rad off. For a position up to two solutions, to within 1e-10 m, the second with the head turned backwards;
        off the sphere the reason is `OUT_OF_REACH`. At the centre of the neck all positions are equally near: `best` is
        nan.

    Raises:
        BadArgument: the robot has no such neck; the message says what is missing. Or not exactly one of `target`
            and `position` is given, or the frame is in the neck, which has one position.
        NotARotation: a target is not a rotation; the error has the argument, its index and its defect.

    Examples:
        >>> nao = nk.load_nao()
        >>> result = nk.ik.head(nao, nk.rotations.rot_z(0.5))
        >>> nao.angles(result.q)["HeadYaw"]
        0.5
        >>> marker = nao.position(nao.configuration({"HeadYaw": 0.5}), "HeadTouchFront_frame")
        >>> nk.ik.head(nao, position=1.01 * marker, frame="HeadTouchFront_frame").describe()
        'out of reach; the nearest pose is off by 2.271 mm'
    """
    limb = head_limb(robot, frame)
    if position is not None and target is None:
        points = as_floats(position, (3,), "position")
        options = as_options(robot, limb.rest, near, points.shape[:-1], limits, threads)
        return without_collisions(robot, _at_position(limb, points, options), collisions)
    if target is None or position is not None:
        raise BadArgument("give one of target and position")
    R = as_floats(target, (3, 3), "target")
    batch = R.shape[:-2]
    options = as_options(robot, limb.rest, near, batch, limits, threads)
    T = np.zeros((*batch, 4, 4))
    T[..., :3, :3], T[..., 3, 3] = R, 1.0
    result = solve(_HEAD, limb, T.reshape(*batch, 16), options, lambda: check_rotation(R, name="target"))
    return without_collisions(robot, result, collisions)


def look_at(
    robot: RobotModel,
    target: ArrayLike,
    camera: str = "CameraTop",
    *,
    near: ArrayLike | None = None,
    limits: SolverLimits = "enforce",
    threads: SupportsIndex | None = None,
    collisions: bool | CollisionRule = False,
) -> IKResult:
    """Compute the joint values with which a camera has a point on its optical axis, in front of the camera.

    There are two solutions, the second with the head turned backwards and looking over the crown. For a point on the
    axis of HeadYaw any yaw is possible (`YAW_AXIS`). If the limits exclude the solutions, or the point is too near to
    the neck, or to the axis of HeadYaw for a camera that looks past it, `best` and `q` have the smallest angle between
    the optical axis and the direction to the point.

    Args:
        robot: a NAO of any version, or another robot with a neck of its geometry.
        target: points in the torso, shape (..., 3) [m].
        camera: one of the robot's cameras, or any frame on the head; its x-axis is the optical axis.
        near: as in `head`.
        limits: as in `head`.
        threads: as in `head`.
        collisions: as in `head`.

    Raises:
        BadArgument: the robot has no such neck.

    Examples:
        >>> nao = nk.load_nao()
        >>> result = nk.ik.look_at(nao, [1.0, 0.3, 0.1])
        >>> point = np.append([1.0, 0.3, 0.1], 1.0)
        >>> (np.linalg.inv(nao.fk(result.q, "CameraTop_optical_frame")) @ point)[:2].round(9).tolist()
        [0.0, 0.0]
    """
    if camera not in robot.frame_table:
        raise UnknownName("camera", camera, robot.semantics.cameras)
    limb = camera_limb(robot, robot.body_frame(camera))
    points = as_floats(target, (3,), "target")
    options = as_options(robot, limb.rest, near, points.shape[:-1], limits, threads)
    result = solve(_GAZE, limb, points, options)
    return without_collisions(robot, result, collisions)


def _at_position(limb: Limb, points: Floats, options: Options) -> IKResult:
    """Return joint values for positions (..., 3) of a frame at o from the neck: o looks in the direction of the point.

    The angle θ that remains, and the distance d of the point from the neck, give the distance from the target,
    √((d − |o|)² + 4 d |o| sin²(θ/2)). Without limits the sphere is reached as far as o is beside the axis of HeadYaw.
    """
    place = np.array(limb.numbers.place)
    place[1] *= abs(place[1]) > TOLERANCE
    radius, across = float(np.linalg.norm(place)), abs(float(place[1]))
    if radius <= TOLERANCE:
        advice = "give an orientation, or look at a point"
        raise BadArgument(f"frame {quoted(limb.frame)} is in the neck, which has one position: {advice}")
    rotation = tuple(rotation_between([1.0, 0.0, 0.0], place).ravel().tolist())
    towards = limb.numbers._replace(place=(0.0, 0.0, 0.0), rotation=rotation)
    found = solve(_GAZE, dataclasses.replace(limb, numbers=towards), points, options)
    offset = points - limb.numbers.neck
    far, aside = np.linalg.norm(offset, axis=-1), np.hypot(offset[..., 0], offset[..., 1])
    away = np.hypot(far - radius, 2.0 * np.sqrt(far * radius) * np.sin(0.5 * found.residual[..., 1]))
    along = np.hypot(aside - across, np.abs(offset[..., 2]) - math.sqrt((radius - across) * (radius + across)))
    needed = np.where(aside * radius < across * far, along, np.abs(far - radius))
    off = needed > VERIFIED
    reasons = np.where(off, np.int8(Reason.OUT_OF_REACH), found.reasons)
    out, met = reasons == Reason.OUT_OF_REACH, reasons == Reason.REACHED
    obstacles = Obstacles(
        np.where(out, -1, found.obstacles.joint),
        np.where(out, needed, found.obstacles.needed),
        np.where(out, 0.0, found.obstacles.limit),
    )
    return dataclasses.replace(
        found,
        branches=np.where(met[..., None, None], found.branches, np.nan),
        families=np.where(met[..., None], found.families, np.int8(Family.NONE)),
        count=np.where(met, found.count, 0),
        reasons=reasons,
        residual=np.stack([away, 0.0 * away], axis=-1),
        obstacles=obstacles,
    )


# --- The geometry of a head, read from a robot.


class Head(NamedTuple):
    """The geometry of a head: the neck in the torso, and the frame in the head from the neck [m]."""

    neck: Vector
    turned: float  # 1 if the frame is rotated in the head
    rotation: Rotation
    place: Vector


def head_limb(robot: RobotModel, frame: str) -> Limb:
    """Return the head of a robot for the closed form."""
    return cached_limb(robot, _head_of, frame)


def camera_limb(robot: RobotModel, frame: str) -> Limb:
    """Return the head for a camera."""
    return cached_limb(robot, _camera_of, frame)


def _head_of(robot: RobotModel, frame: str) -> Limb:
    chain = chain_at_zero(robot, "head", _JOINTS, "zy", frame)
    chain.require_meeting((0, 1))
    neck = chain.points[0]
    return limb_of(chain, frame, Head(tuple(neck.tolist()), *chain.frame_in_link(neck)))


def _camera_of(robot: RobotModel, camera: str) -> Limb:
    limb = _head_of(robot, camera)
    (x, y, z), rotation = limb.numbers.place, limb.numbers.rotation
    if max(abs(y), abs(rotation[3])) > TOLERANCE:
        return limb
    # In the head's plane of symmetry to within rounding: the yaw is then free for points on its axis.
    in_plane = limb.numbers._replace(place=(x, 0.0, z), rotation=(*rotation[:3], 0.0, *rotation[4:]))
    return dataclasses.replace(limb, numbers=in_plane)


# --- The head: HeadYaw about z and HeadPitch about y meet in the neck, R = Rz(yaw) Ry(pitch).
#
# An orientation is possible if the z of its second column is zero; then there is one solution. A camera is at o, with
# the optical axis n, in the head. The point P is on this axis where
#
#     P = Rz(yaw) Ry(pitch) (u, v, w),  (u, v, w) = o + λ n,  λ > 0:
#
# |o + λ n| = |P| gives λ. The pitch turns (u, w) to (r, P_z), and the yaw turns (r, v) to (P_x, P_y), with
# r = ±√(P_x² + P_y² − v²). If a target is not met, a search finds the nearest joint values. For an orientation it is
# over the yaw, with the best pitch in closed form. For a gaze, whose error may have several valleys over yaw and pitch,
# it is on a grid and then from each of its valleys.

JOINTS = 2
MAX_BRANCHES = 4

_ALONE, _YAW_AXIS = float(Family.NONE), float(Family.YAW_AXIS)
# Below this distance of a point from the yaw's axis [m], every yaw is equally good.
_ON_AXIS = 1e-12
# Steps of the search for the nearest yaw.
_STEPS = 120
# The grid of gazes over yaw and pitch, and the last steps of the searches from it [rad].
_YAWS, _PITCHES, _LAST_STEP = 60, 40, 1e-10


@both_ways
def solve_head(head: Head, target: Row, selection: Selection, work: Workspace) -> int:
    """Find the joint values for an orientation of the frame, or the nearest to it, as `branches` describes."""
    q, report = work.q, work.report
    start_report(report)
    is_rigid, wanted = link_rotation(head, target)
    if not is_rigid:
        report[REASON] = NOT_RIGID
        return 0
    q[0], q[1] = math.atan2(-wanted[1], wanted[4]), math.atan2(-wanted[6], wanted[8])
    error = orientation_error(wanted, q[0], q[1])
    count = 0
    if error > VERIFIED:
        report[REASON] = NOT_ENOUGH_JOINTS
    elif check_limits(selection, q, report):
        count = add_branch(selection, work, (0.0, error), _ALONE, 0)
    if count == 0:
        _report_nearest(wanted, selection, work)
    finish_report(work, JOINTS, count)
    return count


@both_ways
def solve_gaze(head: Head, target: Row, selection: Selection, work: Workspace) -> int:
    """Find the joint values with which the frame's x-axis passes through a point, or nearest to it."""
    q, report = work.q, work.report
    start_report(report)
    point = target[0] - head.neck[0], target[1] - head.neck[1], target[2] - head.neck[2]
    x, y, z = point
    far, aside = math.sqrt(x * x + y * y + z * z), math.sqrt(x * x + y * y)
    # The optical axis, and the camera along and perpendicular to it.
    nx, ny, nz = head.rotation[0], head.rotation[3], head.rotation[6]
    forward, left, up = head.place
    along, across = forward * nx + left * ny + up * nz, _norm_of_cross(head.place, (nx, ny, nz))
    beyond = (far - across) * (far + across)
    radius = math.sqrt(forward * forward + left * left + up * up)
    count = 0
    if beyond < 0.0 or (along >= 0.0 and far <= radius):
        report[REASON] = OUT_OF_REACH
        report[NEEDED] = (radius if along >= 0.0 else across) - far
    else:
        for root in range(2):
            ahead = math.sqrt(beyond) if root == 0 else -math.sqrt(beyond)
            if ahead <= along or (root == 1 and beyond == 0.0):
                continue  # λ = ahead − along
            u, w = forward + (ahead - along) * nx, up + (ahead - along) * nz
            v = left + (ahead - along) * ny
            if max(aside, abs(v)) <= _ON_AXIS:
                q[1] = math.atan2(-u * z, w * z)
                q[0] = _free_yaw(selection, q[1])
                count = _add_look(head, point, _YAW_AXIS, selection, work, count)
                continue
            if abs(v) > aside + _ON_AXIS:
                # The camera looks past the yaw's axis at a larger distance than the point's.
                if report[EXCESS] == math.inf:
                    report[REASON], report[NEEDED] = OUT_OF_REACH, abs(v) - aside
                continue
            r = math.sqrt(max(0.0, (aside - abs(v)) * (aside + abs(v))))
            for back in range(2 if r > 0.0 else 1):
                r = r if back == 0 else -r
                q[0] = math.atan2(y * r - x * v, x * r + y * v)
                q[1] = math.atan2(w * r - u * z, u * r + w * z)
                count = _add_look(head, point, _ALONE, selection, work, count)
    if count == 0 and far > 0.0:
        _report_nearest_look(head, point, selection, report)
    finish_report(work, JOINTS, count)
    return count


@both_ways
def _add_look(head: Head, point: Vector, family: float, selection: Selection, work: Workspace, count: int) -> int:
    """Add a branch that looks at a point, if it is inside the limits."""
    q = work.q
    if not check_limits(selection, q, work.report):
        return count
    return add_branch(selection, work, (0.0, gaze_error(head, point, q[0], q[1])), family, count)


@both_ways
def _free_yaw(selection: Selection, pitch: float) -> float:
    """Return the yaw nearest to the reference's at which the pitch is allowed."""
    if not selection.enforce:
        return float(selection.reference[0])
    low, high = selection.ranges.lower[0], selection.ranges.upper[0]
    return least(_cost_of_yaw, (selection, pitch), low, high, selection.reference[0], _STEPS)


@both_ways
def _cost_of_yaw(given: tuple[Selection, float], yaw: float) -> float:
    """Return the distance of a yaw to the reference's, or much more if the pitch is not allowed at it."""
    selection, pitch = given
    low, high = coupled_range(selection.ranges, 1, yaw)
    outside = max(low - pitch, pitch - high)
    return 1e3 * (1.0 + outside) if outside > LIMIT_ROUNDING else abs(yaw - selection.reference[0])


@both_ways
def _report_nearest(wanted: Rotation, selection: Selection, work: Workspace) -> None:
    """Report the joint values with the nearest orientation, by a search over the yaw with the best pitch for each."""
    low, high = _joint_bounds(selection, 0)
    given = wanted, selection, work.q
    yaw = least(_error_at_yaw, given, low, high, math.atan2(-wanted[1], wanted[4]), _STEPS)
    report = work.report
    report[POSITION_ERROR], report[ANGLE_ERROR] = 0.0, _error_at_yaw(given, yaw)
    report[BEST], report[BEST + 1] = yaw, work.q[1]


@both_ways
def _error_at_yaw(given: tuple[Rotation, Selection, Row], yaw: float) -> float:
    """Write the best pitch at a yaw into q; return its error."""
    wanted, selection, q = given
    c, s = math.cos(yaw), math.sin(yaw)
    # The trace of Ry(−pitch) Rz(−yaw) R has one maximum.
    q[1] = math.atan2(wanted[2] * c + wanted[5] * s - wanted[6], wanted[0] * c + wanted[3] * s + wanted[8])
    if selection.enforce:
        low, high = coupled_range(selection.ranges, 1, yaw)
        if q[1] < low or q[1] > high:
            q[1] = low if orientation_error(wanted, yaw, low) < orientation_error(wanted, yaw, high) else high
    return orientation_error(wanted, yaw, q[1])


@both_ways
def _report_nearest_look(head: Head, point: Vector, selection: Selection, report: Row) -> None:
    """Report the joint values with the smallest gaze error, from the valleys of a grid."""
    low, high = _joint_bounds(selection, 0)
    lowest, highest = _joint_bounds(selection, 1)
    report[POSITION_ERROR], report[ANGLE_ERROR] = 0.0, math.inf
    current, pitch, previous = math.inf, 0.0, math.inf
    for i in range(_YAWS + 2):
        error, best = math.inf, 0.0
        if i <= _YAWS:
            yaw = low + (high - low) * i / _YAWS
            for k in range(_PITCHES + 1):
                other = _allowed_pitch(selection, yaw, lowest + (highest - lowest) * k / _PITCHES)
                angle = gaze_error(head, point, yaw, other)
                if angle < error:
                    error, best = angle, other
        if current <= previous and current <= error and current < math.inf:
            _descend(head, point, selection, low + (high - low) * (i - 1) / _YAWS, pitch, report)
        current, pitch, previous = error, best, current


@both_ways
def _descend(head: Head, point: Vector, selection: Selection, yaw: float, pitch: float, report: Row) -> None:
    """Run a pattern search from a gaze, also along the edge of the range; report its end if it is the best so far."""
    low, high = _joint_bounds(selection, 0)
    error, step = gaze_error(head, point, yaw, pitch), (high - low) / _YAWS
    while step > _LAST_STEP:
        previous = error
        for i in range(9):
            one = min(max(yaw + step * (i // 3 - 1), low), high)
            other = _allowed_pitch(selection, one, pitch + step * (i % 3 - 1))
            angle = gaze_error(head, point, one, other)
            if angle < error:
                error, yaw, pitch = angle, one, other
        if error == previous:
            step *= 0.5
    if error < report[ANGLE_ERROR]:
        report[BEST], report[BEST + 1], report[ANGLE_ERROR] = yaw, pitch, error


@both_ways
def _joint_bounds(selection: Selection, joint: int) -> tuple[float, float]:
    """Return the bounds of a search for a joint."""
    return (selection.ranges.lower[joint], selection.ranges.upper[joint]) if selection.enforce else (-math.pi, math.pi)


@both_ways
def _allowed_pitch(selection: Selection, yaw: float, pitch: float) -> float:
    """Return the nearest pitch that is allowed at a yaw."""
    if not selection.enforce:
        return pitch
    low, high = coupled_range(selection.ranges, 1, yaw)
    return min(max(pitch, low), high)


@both_ways
def orientation_error(wanted: Rotation, yaw: float, pitch: float) -> float:
    """Return the angle between Rz(yaw) Ry(pitch) and the desired orientation [rad]."""
    c, s, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    d0, d1, d2 = c * cp - wanted[0], -s - wanted[1], c * sp - wanted[2]
    d3, d4, d5 = s * cp - wanted[3], c - wanted[4], s * sp - wanted[5]
    d6, d7, d8 = -sp - wanted[6], -wanted[7], cp - wanted[8]
    squares = d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3 + d4 * d4 + d5 * d5
    return angle_of_chord(squares + d6 * d6 + d7 * d7 + d8 * d8)


@both_ways
def gaze_error(head: Head, point: Vector, yaw: float, pitch: float) -> float:
    """Return the angle [rad] between the optical axis and the direction to a point, given relative to the neck."""
    c, s, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    # The point in the head, Ry(−pitch) Rz(−yaw) P, from the camera.
    x, v = c * point[0] + s * point[1], c * point[1] - s * point[0] - head.place[1]
    u, w = cp * x - sp * point[2] - head.place[0], sp * x + cp * point[2] - head.place[2]
    axis = head.rotation[0], head.rotation[3], head.rotation[6]
    return math.atan2(_norm_of_cross((u, v, w), axis), u * axis[0] + v * axis[1] + w * axis[2])


@both_ways
def _norm_of_cross(one: Vector, other: Vector) -> float:
    """Return the length of the cross product of two vectors."""
    (a, b, c), (d, e, f) = one, other
    x, y, z = b * f - c * e, c * d - a * f, a * e - b * d
    return math.sqrt(x * x + y * y + z * z)


_types = partial(limb_types, Head, JOINTS)
_HEAD = ClosedForm("heads", solve_head, _types, MAX_BRANCHES, alone=solve_head)
_GAZE = ClosedForm("gazes", solve_gaze, _types, MAX_BRANCHES, alone=solve_gaze)
