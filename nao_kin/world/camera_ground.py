"""Cameras on a robot above level ground: pixels of points, points of the ground, the horizon, and uncertainty.

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
    shaped,
    whole_number,
)
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, WrongShape, at_index
from nao_kin.robot import RobotModel, SetDown, check_robot, pose_of_body, rigid_poses
from nao_kin.world.cameras import LARGEST, Camera, outside_image, pixel_name

# Pixels along each side of the image of a camera with distortion, whose edge is curved; straight ones need no more.
_CURVED = 16
# Bisections of the largest distance in an image, to less than a tenth of a pixel.
_HALVINGS = 14


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


@dataclass(frozen=True, eq=False)
class Horizon:
    """The horizon of level ground in an image.

    Attributes:
        line: (a, b, c) with a u + b v + c = 0 on the horizon and > 0 on the ground, for pixels without distortion, with
            a² + b² = 1, inside the image or not; (0, 0, ±1) if the camera looks straight down or up; shape (..., 3).
        visible: whether the horizon crosses the image, shape (...).
        pixels: the part inside the image, distortion included, from left to right, shape (..., n, 2); NaN if there is
            none.
    """

    line: Floats
    visible: NDArray[np.bool_]
    pixels: Floats


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
    return _placed(robot, q, camera, T_world_base)[0]


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
    T = rigid_inverse(_placed(robot, q, camera, T_world_base)[0])
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
    T, _ = _placed(robot, q, camera, T_world_base)
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
    T, down = _placed(robot, q, camera, T_world_base)
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


def horizon(
    robot: RobotModel, q: ArrayLike, camera: Camera, *, T_world_base: ArrayLike | None = None, n: int = 33
) -> Horizon:
    """Return the horizon of level ground in the image, with n points of its visible part.

    Corners of the image in which the distortion is not invertible do not count as visible.

    The horizon is where rays are level: with the vertical (n_x, n_y, n_z) in the camera's frame, n_x = n_y a + n_z b.

    Args:
        robot: the robot that carries the camera.
        q: configurations, shape (..., nq).
        camera: from `camera` or a calibration.
        T_world_base: as in `camera_pose`.
        n: points of the visible part, at least two.

    Examples:
        >>> nao = nk.load_nao()
        >>> found = nk.world.horizon(nao, nao.posture("StandInit"), nk.world.camera(nao, "CameraTop"))
        >>> bool(found.visible), found.line.round(3).tolist()  # 73 rows above the middle of the image
        (True, [0.0, 1.0, -166.757])
    """
    count = whole_number(n, "n", 2, LARGEST)
    T, _ = _placed(robot, q, camera, T_world_base)
    up = T[..., 2, :3]
    line = np.stack([up[..., 1] / camera.fx, up[..., 2] / camera.fy, -up[..., 0]], axis=-1)
    line[..., 2] -= line[..., 0] * camera.cx + line[..., 1] * camera.cy
    size = np.hypot(line[..., 0], line[..., 1])
    straight = size < 1e-12
    line[straight, :2] = 0.0
    line /= np.where(straight, np.abs(line[..., 2]), size)[..., None]
    rays = _border_rays(camera)
    height = np.einsum("...k,mk->...m", up, rays)
    above = height > 0.0
    crossing = above != np.roll(above, -1, axis=-1)
    visible = crossing.any(axis=-1)
    first, last = crossing.argmax(axis=-1), len(rays) - 1 - crossing[..., ::-1].argmax(axis=-1)
    ends = []
    for i in (first, last):
        j = (i + 1) % len(rays)
        one, other = (np.take_along_axis(height, k[..., None], axis=-1) for k in (i, j))
        with np.errstate(all="ignore"):
            ends.append((rays[i] * other - rays[j] * one) / (other - one))
    share = np.linspace(0.0, 1.0, count)[:, None]
    with np.errstate(invalid="ignore"):
        pixels = camera.project(np.where(visible[..., None, None], _between(ends[0], ends[1], share), (-1.0, 0.0, 0.0)))
        backwards = pixels[..., :1, 0] > pixels[..., -1:, 0]
    return Horizon(line, visible, np.where(backwards[..., None], pixels[..., ::-1, :], pixels))


def visible_ground(
    robot: RobotModel,
    q: ArrayLike,
    camera: Camera,
    *,
    T_world_base: ArrayLike | None = None,
    height: float = 0.0,
    max_distance: float = 10.0,
) -> Floats:
    """Return the part of level ground that the image shows, as a polygon.

    Corners of the image in which the distortion is not invertible show nothing.

    Args:
        robot: the robot that carries the camera.
        q: configurations, shape (..., nq).
        camera: from `camera` or a calibration.
        T_world_base: as in `camera_pose`.
        height: of the plane above the floor [m].
        max_distance: where a part that extends to the horizon is cut off, measured along the line of sight [m].

    Returns:
        Corners in the order of the edge of the image, clockwise from its upper left, shape (k, 3) [m], and (0, 3) if no
        ground is visible. For a batch (..., m, 3), with rows of NaN that are no corners.

    Examples:
        >>> nao = nk.load_nao()
        >>> bottom = nk.world.camera(nao, "CameraBottom")
        >>> nk.world.visible_ground(nao, nao.posture("StandInit"), bottom).round(2)[:, :2].tolist()
        [[1.12, 0.57], [1.12, -0.57], [0.26, -0.25], [0.26, 0.25]]
    """
    plane, farthest = shaped(height, (), "height"), shaped(max_distance, (), "max_distance")
    if farthest <= 0.0:
        raise BadArgument(f"max_distance must be positive, got {quoted(max_distance)}")
    T, _ = _placed(robot, q, camera, T_world_base)
    d = np.einsum("...ij,mj->...mi", T[..., :3, :3], _border_rays(camera))
    eye = T[..., None, :3, 3]
    forward = T[..., None, :2, 0]
    # A camera that looks straight down has its image's upward direction forward.
    level = np.linalg.norm(forward, axis=-1, keepdims=True) > 1e-9
    forward = np.where(level, forward, T[..., None, :2, 2])
    forward = forward / np.linalg.norm(forward, axis=-1, keepdims=True)
    above = eye[..., 2] - plane
    # Positive for rays that meet the plane before the distance; linear, so that edges are cut where it is zero.
    inside = -farthest * d[..., 2] - above * (d[..., :2] * forward).sum(axis=-1)
    following, other = np.roll(inside, -1, axis=-1), np.roll(d, -1, axis=-2)
    with np.errstate(all="ignore"):
        cut = (d * following[..., None] - other * inside[..., None]) / (following - inside)[..., None]
        corners = np.stack([d, cut], axis=-2)
        kept = np.stack([inside >= 0.0, (inside >= 0.0) != (following >= 0.0)], axis=-1)
        t = -above[..., None] / corners[..., 2]
        kept &= (t > 0.0) & (above > 0.0)[..., None]
        points = np.where(kept[..., None], eye[..., None, :] + t[..., None] * corners, np.nan)
    points = points.reshape(*points.shape[:-3], 2 * points.shape[-3], 3)
    return points[np.isfinite(points[:, 0])] if points.ndim == 2 else points


# --- Poses, rays and Jacobians.


def _placed(
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


def _between(start: Floats, end: Floats, share: Floats) -> Floats:
    return start[..., None, :] + share * (end - start)[..., None, :]


def _border_rays(camera: Camera) -> Floats:
    """Return rays around the edge of the image, or of the part with an invertible distortion, shape (m, 3)."""
    pixels = camera.border(_CURVED if camera.distortion else 1)
    rays = camera.ray(pixels)
    beyond = np.isnan(rays[:, 0])
    if beyond.any():
        # By bisection from the optical axis, or the place nearest to it in the image.
        outer = pixels[beyond]
        inner = np.clip(np.broadcast_to((camera.cx, camera.cy), outer.shape), pixels.min(axis=0), pixels.max(axis=0))
        for _ in range(_HALVINGS):
            middle = (inner + outer) / 2.0
            fine = np.isfinite(camera.ray(middle))[:, :1]
            inner, outer = np.where(fine, middle, inner), np.where(fine, outer, middle)
        rays[beyond] = camera.ray(inner)
        if np.isnan(rays).any():
            raise BadArgument(f"the distortion of {camera.name} cannot be inverted at {pixel_name(inner[0])}")
    return rays


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
