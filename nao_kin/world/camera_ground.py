"""Cameras on a robot above level ground: pixels of points, points of pixels, and their uncertainty.

The world is that of `RobotModel.set_down`: z up, the floor at z = 0. With the eye e of the camera and the ray d of a
pixel, both in the world, the point on the plane z = h is p = e + t d with t = (h − e_z)/d_z; it is in front if t > 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    Floats,
    as_floats,
    as_numbers,
    as_pixels,
    check_tolerance,
    common_batch,
    first_index,
    positive,
    rigid_inverse,
)
from nao_kin._core.text import one_line_repr
from nao_kin.errors import BadArgument, WrongShape, at_index
from nao_kin.robot import RobotModel, SetDown
from nao_kin.rotations import slerp
from nao_kin.screws import rigid_poses
from nao_kin.world.cameras import Camera, outside_image, pixel_name
from nao_kin.world.sensors import Rows

# Steps of the search for the row in which a point is exposed, and the change of the row that ends it [pixel].
_MOST_STEPS, _SAME_ROW = 60, 1e-9


@dataclass(frozen=True)
class SoccerObjects:
    """Sizes of the objects that robots look for on a soccer field, and their source.

    Attributes:
        ball_radius: of the ball [m].
        post_height: of a goal post up to the lower edge of the crossbar [m].
        source: the rules.
    """

    ball_radius: float
    post_height: float
    source: str


SPL = SoccerObjects(0.05, 0.8, "RoboCup Standard Platform League rules 2025, Field Construction and Ball")


@one_line_repr
@dataclass(frozen=True, eq=False)
class ImagePoints:
    """Points in an image.

    Attributes:
        pixels: (u, v), shape (..., 2); NaN for a point that has no pixel, such as one behind the camera.
        visible: whether the pixel is inside the image, shape (...).
    """

    pixels: Floats
    visible: NDArray[np.bool_]


@one_line_repr
@dataclass(frozen=True, eq=False)
class GroundPoints:
    """Points of a level plane.

    Attributes:
        points: in the world, shape (..., 3) [m]; NaN for other pixels than `valid` ones.
        valid: whether the pixel is inside the image and shows a point of the plane, shape (...).
    """

    points: Floats
    valid: NDArray[np.bool_]


def camera_pose(robot: RobotModel, q: ArrayLike, camera: Camera, *, T_world_base: ArrayLike | None = None) -> Floats:
    """Return poses of a camera in the world, T_world_camera = T_world_base · T_base_camera(q).

    Args:
        robot: the robot that carries the camera.
        q: configurations, shape (..., nq).
        camera: from `camera` or a calibration.
        T_world_base: poses of the root link, shape (..., 4, 4); None to set the robot down on the floor.

    Returns:
        Shape (..., 4, 4), for a frame with x forward, y left, z up [m].

    Examples:
        >>> nao = nk.load_nao()
        >>> top = nk.world.camera(nao, "CameraTop")
        >>> nk.world.camera_pose(nao, nao.posture("StandInit"), top)[2, 3].round(3).item()
        0.504
    """
    return placed(robot, q, camera, T_world_base)[0]


def project(
    robot: RobotModel,
    q: ArrayLike | Callable[[Floats], ArrayLike],
    points: ArrayLike,
    camera: Camera,
    *,
    T_world_base: ArrayLike | Callable[[Floats], ArrayLike] | None = None,
    row_time: float = 0.0,
) -> ImagePoints:
    """Return the pixels of points in the world.

    A rolling shutter exposes row v at the time τ v after row 0, with the `row_time` τ, and the robot moves meanwhile.
    The pixel (u, v) of a point is then where the camera sees the point at the time τ v of its own row.

    Args:
        robot: the robot that carries the camera.
        q: configurations, shape (..., nq); or a function that returns them at times (...) after row 0 [s], such as
            `lambda t: nk.world.configurations_at(robot, log, times, start + t)`.
        points: in the world, shape (..., 3) [m]; their batch axes and those of q are broadcast.
        camera: from `camera` or a calibration.
        T_world_base: as in `camera_pose`, or a function of these times.
        row_time: time from one row to the next [s]; 0 if all rows are exposed at once. Points above or below the image
            are seen at the time of its first or last row.

    Raises:
        BadArgument: a single point has no pixel, as in `Camera.project`, or no row, because the robot moves too fast
            for the search; NaN in a batch.

    Examples:
        >>> nao = nk.load_nao()
        >>> top = nk.world.camera(nao, "CameraTop")
        >>> seen = nk.world.project(nao, nao.posture("StandInit"), [[2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]], top)
        >>> seen.visible.tolist(), seen.pixels.round(0).tolist()
        ([True, False], [[320.0, 321.0], [nan, nan]])
    """
    p = as_floats(points, (3,), "points")
    check_tolerance(row_time, "row_time")
    row = np.full(p.shape[:-1], 0.5 * (camera.height - 1))
    for _ in range(_MOST_STEPS):
        rows_q = q(row_time * row) if callable(q) else q
        rows_T = T_world_base(row_time * row) if callable(T_world_base) else T_world_base
        T = rigid_inverse(placed(robot, rows_q, camera, rows_T)[0])
        common_batch("configurations and points", T.shape[:-2], p.shape[:-1])
        pixels = camera.project(_turned(T[..., :3, :3], p) + T[..., :3, 3])
        if not row_time:
            break
        found = np.clip(np.where(np.isnan(pixels[..., 1]), row, pixels[..., 1]), 0.0, camera.height - 1.0)
        moved, row = np.abs(found - row) >= _SAME_ROW, found
        if not moved.any():
            break
    else:
        if p.ndim == 1:
            raise BadArgument(f"no row of {camera.name} shows the point when it is exposed: the robot moves too fast")
        pixels[moved] = np.nan
    return ImagePoints(pixels, camera.sees(pixels))


def pixel_to_ground(
    robot: RobotModel,
    q: ArrayLike,
    pixels: ArrayLike,
    camera: Camera,
    *,
    T_world_base: ArrayLike | None = None,
    height: ArrayLike = 0.0,
) -> GroundPoints:
    """Return the points of level ground that pixels show.

    Args:
        robot: the robot that carries the camera.
        q: configurations, shape (..., nq).
        pixels: (u, v), shape (..., 2); their batch axes and those of q are broadcast.
        camera: from `camera` or a calibration, for images of the size in which the pixels were found.
        T_world_base: as in `camera_pose`.
        height: of the plane above the floor, shape (...); the radius of a ball for the pixel of its centre [m].

    Raises:
        BadArgument: a single pixel is outside the image, or shows no point of the plane, as it is at or above the
            horizon, or its distortion cannot be inverted.

    Examples:
        >>> nao = nk.load_nao()
        >>> bottom = nk.world.camera(nao, "CameraBottom")
        >>> ground = nk.world.pixel_to_ground(nao, nao.posture("StandInit"), [[320, 240], [700, 240]], bottom)
        >>> ground.valid.tolist(), ground.points[0].round(3).tolist()
        ([True, False], [0.516, -0.001, 0.0])
    """
    T, _ = placed(robot, q, camera, T_world_base)
    sight = _Sight.of(robot, T, pixels, camera, height)
    return GroundPoints(T[..., :3, 3] + sight.t[..., None] * sight.d, sight.valid)


def ground_covariance(
    robot: RobotModel,
    q: ArrayLike,
    pixels: ArrayLike,
    camera: Camera,
    *,
    joint_noise: ArrayLike,
    base_noise: ArrayLike = 0.0,
    pixel_noise: float = 1.0,
    T_world_base: ArrayLike | None = None,
    height: ArrayLike = 0.0,
    support: str | None = None,
) -> Floats:
    """Return covariances of the points of `pixel_to_ground`, from noise of the joints, the root link and the pixel.

    With p = e + t d on a level plane, P = 1 − d zᵀ/d_z, the camera's Jacobian (J_v; J_ω) with respect to the support,
    the origin o of the support, and the derivative D of the ray by the pixel,

        δp = P (J_v δq + t ((J_ω δq) × d + R D δpixel) + δφ × (p − o) + z δh),

    where δφ = δroll x_base + δpitch y_level tilts the root link about its x axis and the level axis to the left of it,
    and δh lifts it. All these errors are independent.

    Args:
        robot: the robot that carries the camera.
        q: configurations, shape (..., nq).
        pixels: as in `pixel_to_ground`.
        camera: from `camera` or a calibration.
        joint_noise: standard deviation of the joint angles: one number, or one for each velocity, shape (nv,); or their
            covariance, shape (nv, nv) [rad, rad²].
        base_noise: standard deviation of roll and pitch of the root link, the largest error of a walking robot: one
            number [rad], or (roll, pitch), or (roll, pitch, height) [rad, rad, m]. The robot tilts about the origin of
            the support.
        pixel_noise: standard deviation of u and of v [pixel].
        T_world_base: as in `camera_pose`.
        height: as in `pixel_to_ground`.
        support: the frame that stands still in the world while the joints vary. None for the first sole that touches
            the floor, or with T_world_base for the root link.

    Returns:
        Covariance of x and y, shape (..., 2, 2) [m²]; NaN where `pixel_to_ground` is not valid.

    Raises:
        BadArgument: no sole touches the floor and no support is named; noise that is negative, or not a covariance; a
            single pixel is outside the image or shows no point of the plane.

    Examples:
        >>> nao = nk.load_nao()
        >>> top = nk.world.camera(nao, "CameraTop")
        >>> q = nao.posture("StandInit")
        >>> covariance = nk.world.ground_covariance(nao, q, [320, 321], top, joint_noise=np.radians(0.5))
        >>> np.sqrt(np.diag(covariance)).round(3).tolist()  # two metres ahead [m]
        [0.146, 0.022]
    """
    T, down = placed(robot, q, camera, T_world_base)
    noise, variances = _joint_covariance(robot, joint_noise), _base_variances(base_noise)
    check_tolerance(pixel_noise, "pixel_noise")
    sight = _Sight.of(robot, T, pixels, camera, height)
    base = down.T_world_base if down is not None else np.asarray(T_world_base, dtype=np.float64)
    J, lever = _relative_jacobian(robot, q, camera, base, down, support)
    d, t = sight.d, sight.t[..., None, None]
    # The part of a motion of the ray that remains in the plane: its first two rows.
    P = np.zeros((*d.shape[:-1], 2, 3))
    P[..., 0, 0] = P[..., 1, 1] = 1.0
    with np.errstate(all="ignore"):
        P[..., 2] = -d[..., :2] / d[..., 2:]
    turned = np.cross(np.swapaxes(J[..., 3:, :], -1, -2), d[..., None, :])
    by_joints = P @ (J[..., :3, :] + t * np.swapaxes(turned, -1, -2))
    # ∂d/∂(a, b) is minus the second and third axis of the camera.
    by_pixel = P @ (-t * T[..., :3, 1:3] @ np.linalg.inv(camera.lens_jacobian(sight.ab)))
    # R = Rz(yaw) Ry(pitch) Rx(roll): the axis of roll is R x, that of pitch is Rz(yaw) y.
    forward = base[..., :3, 0]
    yaw = np.arctan2(forward[..., 1], forward[..., 0])
    axes = np.stack([forward, np.stack([-np.sin(yaw), np.cos(yaw), np.zeros_like(yaw)], axis=-1)], axis=-2)
    tilted = np.cross(axes, (lever + sight.t[..., None] * d)[..., None, :])
    found = by_joints @ noise @ np.swapaxes(by_joints, -1, -2)
    for by, variance in (
        (by_pixel, pixel_noise**2),
        (P @ np.swapaxes(tilted, -1, -2), variances[:2]),
        (P[..., 2:], variances[2]),
    ):
        found = found + (variance * by) @ np.swapaxes(by, -1, -2)
    return np.where(sight.valid[..., None, None], found, np.nan)


def upright_position(
    robot: RobotModel,
    q: ArrayLike,
    pixels: ArrayLike,
    camera: Camera,
    *,
    height: float,
    T_world_base: ArrayLike | None = None,
) -> GroundPoints:
    """Return where upright objects of a known height stand, such as goal posts, from the pixels of foot and top.

    With the rays d₁, d₂ of foot and top in the world, the foot is the point e + s d₁ for which s d₁ + h z − t d₂ is
    shortest. This needs the tilt of the camera, but neither its height nor a level floor.

    Args:
        robot: the robot that carries the camera.
        q: configurations, shape (..., nq).
        pixels: of the foot and the top of each object, shape (..., 2, 2).
        camera: from `camera` or a calibration.
        height: from foot to top [m].
        T_world_base: as in `camera_pose`.

    Returns:
        The foot; not valid if a pixel is outside the image, or the top is not above the foot.

    Raises:
        BadArgument: the pixels of a single object are not valid.

    Examples:
        >>> nao, SPL = nk.load_nao(), nk.world.SPL
        >>> top, q = nk.world.camera(nao, "CameraTop"), nao.posture("StandInit")
        >>> post = [[2.5, 0.3, 0.0], [2.5, 0.3, SPL.post_height]]
        >>> pixels = nk.world.project(nao, q, post, top).pixels
        >>> nk.world.upright_position(nao, q, pixels, top, height=SPL.post_height).points[:2].round(6).tolist()
        [2.5, 0.3]
    """
    size, uv = float(positive(height, "height")), as_pixels(pixels)
    if uv.shape[-2:] != (2, 2):
        raise WrongShape("pixels of uprights", "(..., 2, 2)", uv.shape)
    T, _ = placed(robot, q, camera, T_world_base)
    common_batch("configurations and pixels", T.shape[:-2], uv.shape[:-2])
    d = np.einsum("...ij,...kj->...ki", T[..., :3, :3], camera.ray(uv))
    cosine, (z1, z2) = (d[..., 0, :] * d[..., 1, :]).sum(axis=-1), np.moveaxis(d[..., 2], -1, 0)
    with np.errstate(all="ignore"):
        share = size / np.square(np.cross(d[..., 0, :], d[..., 1, :])).sum(axis=-1)
        s, t = share * (cosine * z2 - z1), share * (z2 - cosine * z1)
        valid = (s > 0.0) & (t > 0.0) & np.isfinite(s) & camera.sees(uv).all(axis=-1)
        points = np.where(valid[..., None], T[..., :3, 3] + s[..., None] * d[..., 0, :], np.nan)
    if not valid.ndim and not valid:
        pair = " and ".join(map(pixel_name, uv))
        if np.isfinite(uv).all() and not camera.sees(uv).all():
            raise BadArgument(f"one of the pixels {pair} is {outside_image(robot, camera, uv)}")
        raise BadArgument(f"the pixels {pair} are not the foot and the top of an upright object in {camera.name}")
    return GroundPoints(points, valid)


def configurations_at(
    robot: RobotModel, q: ArrayLike, times: ArrayLike, at: ArrayLike, *, longest_gap: float = 0.1
) -> Floats:
    """Return the configurations of a log at other times, such as those of images, interpolated between its rows.

    Joints are interpolated linearly, the rotation of a floating base by `nk.rotations.slerp`.

    Args:
        robot: the robot of the log.
        q: configurations, shape (n, nq); rows with NaN are left out.
        times: of the n rows, ascending; of rows with one time the first value counts [s].
        at: times, shape (...) [s].
        longest_gap: largest time between the two rows around a time [s].

    Returns:
        Shape (..., nq); NaN in a batch for times outside the log or inside a larger gap.

    Raises:
        BadArgument: times that go back; a single time is outside the log or inside a larger gap.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = np.linspace(nao.posture("StandInit"), nao.posture("Crouch"), 3)
        >>> bool(np.allclose(nk.world.configurations_at(nao, q, [0.0, 0.02, 0.04], 0.01), q[:2].mean(axis=0)))
        True
    """
    rows, t = as_numbers(q, "q"), as_floats(at, (), "at")
    if rows.ndim != 2 or rows.shape[1] != robot.nq:
        raise WrongShape("q", f"(n, {robot.nq})", rows.shape)
    log = Rows.of(times, len(rows))
    rows, moments = log.merged(rows), log.times
    check_tolerance(longest_gap, "longest_gap")
    measured = ~np.isnan(rows).any(axis=-1)
    if not measured.any():
        raise BadArgument("the log has no row without NaN")
    rows, moments = robot.checked(rows[measured]), moments[measured]
    after = np.clip(np.searchsorted(moments, t), 0, len(rows) - 1)
    before = np.where(moments[after] == t, after, np.maximum(after - 1, 0))
    width = moments[after] - moments[before]
    share = (np.clip(t, moments[0], moments[-1]) - moments[before]) / np.where(width > 0.0, width, 1.0)
    found = np.asarray(rows[before] + share[..., None] * (rows[after] - rows[before]))
    if robot.nq_base:
        found[..., 3:7] = slerp(rows[before, 3:7], rows[after, 3:7], share)
    missing = (t < moments[0]) | (t > moments[-1]) | (width > longest_gap)
    if not t.ndim and missing:
        raise BadArgument(f"the log has no configuration at {t:.6g} s: it has a gap there, or does not reach it")
    found[missing] = np.nan
    return found


# --- Poses, rays and Jacobians.


def placed(
    robot: RobotModel, q: ArrayLike, camera: Camera, T_world_base: ArrayLike | None
) -> tuple[Floats, SetDown | None]:
    """Return T_world_camera, and how the robot was set down, if it was."""
    T_base_camera = robot.fk(q, camera.frame, reference=robot.tree.root)
    T_optical_camera = robot.pose_in_optical_frame(camera.frame)
    if T_optical_camera is not None:
        T_base_camera = T_base_camera @ T_optical_camera
    if T_world_base is not None:
        T = rigid_poses(T_world_base, "T_world_base")
        common_batch("configurations and T_world_base", T_base_camera.shape[:-2], T.shape[:-2])
        return np.asarray(T @ T_base_camera), None
    down = robot.set_down(q)
    return np.asarray(down.T_world_base @ T_base_camera), down


@dataclass(frozen=True)
class _Sight:
    """Normalised coordinates of pixels, their rays in the world, the multiples t of the rays, and which are valid."""

    ab: Floats
    d: Floats
    t: Floats
    valid: NDArray[np.bool_]

    @staticmethod
    def of(robot: RobotModel, T: Floats, pixels: ArrayLike, camera: Camera, height: ArrayLike) -> _Sight:
        uv = as_pixels(pixels)
        inside = camera.sees(uv)
        if uv.ndim == 1 and not inside and np.isfinite(uv).all():
            raise BadArgument(f"the pixel {pixel_name(uv)} is {outside_image(robot, camera, uv)}")
        ab = camera.normalised(uv)
        plane = as_floats(height, (), "height")
        shape = common_batch("configurations, pixels and heights", T.shape[:-2], ab.shape[:-1], plane.shape)
        d = _turned(-T[..., :3, 1:3], ab) + T[..., :3, 0]
        with np.errstate(all="ignore"):
            t = (plane - T[..., 2, 3]) / d[..., 2]
            valid = (t > 0.0) & (t < np.inf) & inside
        if not shape and not valid:
            side = "is not a number" if np.isnan(uv).any() else f"is {'above' if d[2] >= 0.0 else 'below'} the horizon"
            raise BadArgument(
                f"the pixel {pixel_name(uv)} of {camera.name} shows no point of the plane z = {float(plane):g} m: "
                f"it {side}, and the camera is at z = {T[2, 3]:.3g} m"
            )
        t = np.where(valid, t, np.nan)
        return _Sight(ab, d, np.broadcast_to(t, shape), np.broadcast_to(valid, shape))


def _turned(M: Floats, v: Floats) -> Floats:
    """Return M v for matrices (..., 3, k) and vectors (..., k); one matrix for many vectors is fastest."""
    return np.asarray(v @ M.T if M.ndim == 2 else np.einsum("...ij,...j->...i", M, v))


def _joint_covariance(robot: RobotModel, noise: ArrayLike) -> Floats:
    """Return the covariance of the velocities' coordinates, shape (nv, nv)."""
    given, n = as_floats(noise, (), "joint_noise"), robot.nv
    if given.shape == (n, n):
        values = np.linalg.eigvalsh(given)
        if np.abs(given - given.T).max() > 1e-9 * np.abs(given).max() or values.min() < -1e-9 * np.abs(values).max():
            raise BadArgument("joint_noise must be a covariance, symmetric without negative eigenvalues")
        return given
    if given.shape not in ((), (n,)):
        raise WrongShape("joint_noise", f"(), ({n},) or ({n}, {n})", given.shape)
    return np.diag(np.broadcast_to(_variances(given, "joint_noise"), (n,)))


def _base_variances(noise: ArrayLike) -> Floats:
    """Return the variances of roll, pitch and height of the root link, shape (3,)."""
    given = as_floats(noise, (), "base_noise")
    if given.shape not in ((), (2,), (3,)):
        raise WrongShape("base_noise", "(), (2,) or (3,)", given.shape)
    variances = _variances(given, "base_noise")
    return np.append(variances if given.ndim else [variances] * 2, 0.0)[:3]


def _variances(deviations: Floats, what: str) -> Floats:
    if not (deviations >= 0.0).all():
        raise BadArgument(f"{what} must be standard deviations ≥ 0")
    return np.square(deviations)


def _relative_jacobian(
    robot: RobotModel, q: ArrayLike, camera: Camera, T_world_base: Floats, down: SetDown | None, support: str | None
) -> tuple[Floats, Floats]:
    """Return Jacobians (..., 6, nv) of the camera at its eye with respect to the support, and the lever to its eye.

    Both are in the axes of the world; the lever is from the origin of the support, shape (..., 3).
    """
    root, q = robot.tree.root, robot.checked(q)
    names: tuple[str, ...] = (support,) if support is not None else (root,)
    index = np.zeros(q.shape[:-1], dtype=np.intp)
    if support is None and down is not None:
        names, index = down.soles, down.touching.argmax(axis=-1) if down.soles else index
        without = np.asarray(~down.touching.any(axis=-1))
        if without.any():
            raise BadArgument(f"no sole touches the floor{at_index(first_index(without))}; name the support that does")
    # Jacobians are in the axes of the root, which is the world of q with a floating base.
    R = (T_world_base @ rigid_inverse(robot.fk(q, root)))[..., :3, :3]
    J_camera, p_camera = robot.jacobian(q, camera.frame), robot.position(q, camera.frame)
    found, lever = np.zeros(J_camera.shape), np.zeros(p_camera.shape)
    for k, name in enumerate(names):
        J, arm = robot.jacobian(q, name), p_camera - robot.position(q, name)
        own = J_camera - J
        own[..., :3, :] -= np.swapaxes(np.cross(np.swapaxes(J[..., 3:, :], -1, -2), arm[..., None, :]), -1, -2)
        found = np.where((index == k)[..., None, None], own, found)
        lever = np.where((index == k)[..., None], arm, lever)
    J = np.concatenate([R @ found[..., :3, :], R @ found[..., 3:, :]], axis=-2)
    return J, np.einsum("...ij,...j->...i", R, lever)
