"""Cameras on a robot above level ground: pixels of points, points of the ground, and their uncertainty.

The world is that of `RobotModel.set_down`: z up, the floor at z = 0. With the eye e of the camera and the ray d of a
pixel, both in the world, the point on the plane z = h is p = e + t d with t = (h − e_z)/d_z; it is in front if t > 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    Floats,
    as_floats,
    as_pixels,
    check_tolerance,
    common_batch,
    first_index,
    rigid_inverse,
)
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, WrongShape, at_index
from nao_kin.robot import RobotModel, SetDown, check_robot, pose_of_body, rigid_poses
from nao_kin.world.cameras import LARGEST, Camera, outside_image, pixel_name


@dataclass(frozen=True, eq=False)
class ImagePoints:
    """Points in an image.

    Attributes:
        pixels: (u, v), shape (..., 2); NaN for a point that has no pixel, such as one behind the camera.
        visible: whether the pixel is inside the image, shape (...).
    """

    pixels: Floats
    visible: NDArray[np.bool_]


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
    robot: RobotModel, q: ArrayLike, points: ArrayLike, camera: Camera, *, T_world_base: ArrayLike | None = None
) -> ImagePoints:
    """Return the pixels of points in the world.

    Args:
        robot: the robot that carries the camera.
        q: configurations, shape (..., nq).
        points: in the world, shape (..., 3) [m]; their batch axes and those of q are broadcast.
        camera: from `camera` or a calibration.
        T_world_base: as in `camera_pose`.

    Raises:
        BadArgument: a single point has no pixel; as in `Camera.project`.

    Examples:
        >>> nao = nk.load_nao()
        >>> top = nk.world.camera(nao, "CameraTop")
        >>> seen = nk.world.project(nao, nao.posture("StandInit"), [[2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]], top)
        >>> seen.visible.tolist(), seen.pixels.round(0).tolist()
        ([True, False], [[320.0, 321.0], [nan, nan]])
    """
    T = rigid_inverse(placed(robot, q, camera, T_world_base)[0])
    p = as_floats(points, (3,), "points")
    common_batch("configurations and points", T.shape[:-2], p.shape[:-1])
    pixels = camera.project(_turned(T[..., :3, :3], p) + T[..., :3, 3])
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
    pixel_noise: float = 1.0,
    T_world_base: ArrayLike | None = None,
    height: ArrayLike = 0.0,
    support: str | None = None,
) -> Floats:
    """Return covariances of the points of `pixel_to_ground`, from noise of the joints and of the pixel.

    With p = e + t d on a level plane, P = 1 − d zᵀ/d_z, the camera's Jacobian (J_v; J_ω) with respect to the support,
    and the derivative D of the ray by the pixel,

        δp = P (J_v δq + t ((J_ω δq) × d + R D δpixel)),   Σ_p = G_q Σ_q G_qᵀ + σ² G_pixel G_pixelᵀ.

    Args:
        robot: the robot that carries the camera.
        q: configurations, shape (..., nq).
        pixels: as in `pixel_to_ground`.
        camera: from `camera` or a calibration.
        joint_noise: standard deviation of the joint angles: one number, or one for each velocity, shape (nv,); or their
            covariance, shape (nv, nv) [rad, rad²].
        pixel_noise: standard deviation of u and of v [pixel].
        T_world_base: as in `camera_pose`.
        height: as in `pixel_to_ground`.
        support: the frame that stands still in the world while the joints vary. None for the first sole that touches
            the floor, or with T_world_base, which is taken as exact, for the root link.

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
    noise = _joint_covariance(robot, joint_noise)
    check_tolerance(pixel_noise, "pixel_noise")
    if pixel_noise > LARGEST:
        raise BadArgument(f"pixel_noise must be at most {LARGEST} pixels, got {pixel_noise:g}")
    sight = _Sight.of(robot, T, pixels, camera, height)
    J = _relative_jacobian(robot, q, camera, T, down, T_world_base, support)
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
    found = by_joints @ noise @ np.swapaxes(by_joints, -1, -2)
    found = found + pixel_noise**2 * (by_pixel @ np.swapaxes(by_pixel, -1, -2))
    return np.where(sight.valid[..., None, None], found, np.nan)


# --- Poses, rays and Jacobians.


def placed(
    robot: RobotModel, q: ArrayLike, camera: Camera, T_world_base: ArrayLike | None
) -> tuple[Floats, SetDown | None]:
    """Return T_world_camera, and how the robot was set down, if it was."""
    check_robot(robot)
    if not isinstance(camera, Camera):
        raise BadArgument(f"camera must be a Camera, as from nk.world.camera, got {quoted(camera)}")
    T_base_camera = robot.fk(q, camera.frame, reference=robot.tree.root)
    T_optical_camera = pose_of_body(robot, camera.frame)
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
    if (given < 0.0).any():
        raise BadArgument("joint_noise must be standard deviations ≥ 0")
    return np.diag(np.broadcast_to(np.square(given), (n,)))


def _relative_jacobian(
    robot: RobotModel,
    q: ArrayLike,
    camera: Camera,
    T_world_camera: Floats,
    down: SetDown | None,
    T_world_base: ArrayLike | None,
    support: str | None,
) -> Floats:
    """Return Jacobians of the camera at its eye with respect to the support, in the axes of the world."""
    root, q = robot.tree.root, robot.checked(q)
    names: tuple[str, ...] = (support,) if support is not None else (root,)
    index = np.zeros(q.shape[:-1], dtype=np.intp)
    if support is None and down is not None:
        names, index = down.soles, down.touching.argmax(axis=-1) if down.soles else index
        without = np.asarray(~down.touching.any(axis=-1))
        if without.any():
            raise BadArgument(f"no sole touches the floor{at_index(first_index(without))}; name the support that does")
    base = down.T_world_base if down is not None else np.asarray(T_world_base, dtype=np.float64)
    # Jacobians are in the axes of the root, which is the world of q with a floating base.
    R = (base @ rigid_inverse(robot.fk(q, root)))[..., :3, :3]
    J_camera, p_camera = robot.jacobian(q, camera.frame), robot.position(q, camera.frame)
    found = np.zeros(J_camera.shape)
    for k, name in enumerate(names):
        J, arm = robot.jacobian(q, name), p_camera - robot.position(q, name)
        own = J_camera - J
        own[..., :3, :] -= np.swapaxes(np.cross(np.swapaxes(J[..., 3:, :], -1, -2), arm[..., None, :]), -1, -2)
        found = np.where((index == k)[..., None, None], own, found)
    return np.concatenate([R @ found[..., :3, :], R @ found[..., 3:, :]], axis=-2)
