"""What the image of a camera shows of level ground: the horizon, and the visible part of the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, shaped, whole_number
from nao_kin.errors import BadArgument
from nao_kin.robot import RobotModel
from nao_kin.world.camera_ground import placed
from nao_kin.world.cameras import LARGEST, Camera, pixel_name, positive

# Pixels along each side of the image of a camera with distortion, whose edge is curved; straight ones need no more.
_CURVED = 16
# Bisections of the largest distance in an image, to less than a tenth of a pixel.
_HALVINGS = 14


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
    T, _ = placed(robot, q, camera, T_world_base)
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
    plane, farthest = shaped(height, (), "height"), positive(max_distance, "max_distance")
    T, _ = placed(robot, q, camera, T_world_base)
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
