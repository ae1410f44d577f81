"""What the image of a camera shows: the horizon, level ground, lines, and the robot's own body.

In normalised coordinates a straight line is straight, and a convex body a convex polygon; the lens bends them after
that. The edge of the image is a polygon of rays, which ends where the distortion cannot be inverted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    Floats,
    as_floats,
    as_pixels,
    choice,
    common_batch,
    positive,
    rigid_inverse,
    shaped,
    texts,
    whole_number,
)
from nao_kin._core.text import one_line_repr
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot import RobotModel, SupportPolygon
from nao_kin.world.camera_ground import ImagePoints, placed
from nao_kin.world.cameras import Camera, pixel_name, tangent_circle

# Pixels along each side of the image of a camera with distortion, whose edge is curved; straight ones need no more.
_CURVED = 16
# The same, if the lens does not reach the corners, which are cut off between two of these pixels.
_CLIPPED = 64
# Bisections of the largest distance in an image, to less than a tenth of a pixel.
_HALVINGS = 14
# Bodies are cut off at this distance in front of the camera [m].
_NEAR = 1e-4
# Directions around a round body.
_DIRECTIONS = 64
# Sine of the angle between the rays to the ends of a line, below which it leads through the camera.
_FLAT = 1e-12
# A point without pixel.
_BEHIND = (-1.0, 0.0, 0.0)


@one_line_repr
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
    count = whole_number(n, "n", 2)
    T, _ = placed(robot, q, camera, T_world_base)
    up = T[..., 2, :3]
    line = np.stack([up[..., 1] / camera.fx, up[..., 2] / camera.fy, -up[..., 0]], axis=-1)
    line[..., 2] -= line[..., 0] * camera.cx + line[..., 1] * camera.cy
    size = np.hypot(line[..., 0], line[..., 1])
    straight = size < 1e-12
    line[straight, :2] = 0.0
    line /= np.where(straight, np.abs(line[..., 2]), size)[..., None]
    ends, visible = _ends(camera, up)
    share = np.linspace(0.0, 1.0, count)[:, None]
    with np.errstate(invalid="ignore"):
        pixels = camera.project(np.where(visible[..., None, None], _between(ends, share), _BEHIND))
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
    plane, farthest = shaped(height, (), "height"), float(positive(max_distance, "max_distance"))
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


def project_lines(
    robot: RobotModel,
    q: ArrayLike,
    lines: ArrayLike,
    camera: Camera,
    *,
    T_world_base: ArrayLike | None = None,
    n: int = 33,
) -> ImagePoints:
    """Return the visible parts of lines in the world, without what is behind the camera or outside the image.

    Where a lens bends a line out of the image and in again, the points go on in between.

    Args:
        robot: the robot that carries the camera.
        q: configurations, shape (..., nq).
        lines: the two ends of each, shape (..., 2, 3) [m]; their batch axes and those of q are broadcast.
        camera: from `camera` or a calibration.
        T_world_base: as in `camera_pose`.
        n: points of the visible part, at least two; without distortion two are enough.

    Returns:
        For each line n pixels from its first end to the second, shape (..., n, 2), and whether a part of it is visible,
        shape (...); NaN if none is, as for a line through the camera.

    Examples:
        >>> nao = nk.load_nao()
        >>> top, q = nk.world.camera(nao, "CameraTop"), nao.posture("StandInit")
        >>> sideline = [[-1.0, 0.5, 0.0], [4.0, 0.5, 0.0]]
        >>> nk.world.project_lines(nao, q, sideline, top, n=2).pixels.round(0).tolist()
        [[12.0, 479.0], [244.0, 244.0]]
    """
    count, ends = whole_number(n, "n", 2), as_floats(lines, (2, 3), "lines")
    T, _ = placed(robot, q, camera, T_world_base)
    common_batch("configurations and lines", T.shape[:-2], ends.shape[:-2])
    with np.errstate(all="ignore"):
        p = np.einsum("...ji,...kj->...ki", T[..., :3, :3], ends - T[..., None, :3, 3])
        normal = np.cross(p[..., 0, :], p[..., 1, :])
        edge, visible = _ends(camera, normal)
        # Planes through the camera and each end of the visible part of the whole line; the other end is inside.
        planes = np.cross(normal[..., None, :], edge)
        planes *= np.sign((planes * edge[..., ::-1, :]).sum(axis=-1, keepdims=True))
        inside = np.einsum("...wi,...ki->...kw", planes, p)
        start, end = inside[..., 0, :], inside[..., 1, :]
        cut = start / (start - end)
        low, high = np.where(start < 0.0, cut, 0.0).max(axis=-1), np.where(end < 0.0, cut, 1.0).min(axis=-1)
        visible &= (low < high) & ((start > 0.0) | (end > 0.0)).all(axis=-1)
        visible &= np.linalg.norm(normal, axis=-1) > _FLAT * np.linalg.norm(p, axis=-1).prod(axis=-1)
        shown = p[..., :1, :] + np.stack([low, high], axis=-1)[..., None] * np.diff(p, axis=-2)
        rays = _between(shown / shown[..., :1], np.linspace(0.0, 1.0, count)[:, None])
        return ImagePoints(camera.project(np.where(visible[..., None, None], rays, _BEHIND)), visible)


def own_body(
    robot: RobotModel, q: ArrayLike, pixels: ArrayLike, camera: Camera, *, links: Sequence[str] | None = None
) -> NDArray[np.bool_]:
    """Return which pixels show the robot itself, shape (...).

    The bodies are the convex hulls of the links, as in `RobotModel.collisions`, with the fingers at the opening of the
    hand. Hulls are larger than the links, so that no pixel of the robot is missed where the model is right.

    Args:
        robot: the robot that carries the camera.
        q: one configuration, shape (nq,).
        pixels: (u, v), shape (..., 2); False for pixels outside the image, NaN, and where the lens has no ray.
        camera: from `camera` or a calibration.
        links: names of links; None for all but those that are fixed to the camera, such as the head, which its cameras
            do not see.

    Raises:
        UnknownName: a link that does not exist, or has no shape.

    Examples:
        >>> nao = nk.load_nao()
        >>> q, bottom = nao.posture("StandInit", HeadPitch=0.4), nk.world.camera(nao, "CameraBottom")
        >>> nk.world.own_body(nao, q, [[230, 470], [320, 470]], bottom).tolist()  # the left foot, and the floor
        [True, False]
    """
    row, uv = robot.checked(q), as_pixels(pixels)
    if row.ndim != 1:
        raise WrongShape("q", f"({robot.nq},), one configuration", row.shape)
    T_camera_root = rigid_inverse(placed(robot, row, camera, np.eye(4))[0])
    shapes = [part for shape in robot.link_shapes.shapes for part in shape.parts or (shape,)]
    own, known = robot.frame_placement(camera.frame)[0], {shape.link for shape in shapes}
    if links is None:
        wanted = {link for link in known if robot.frame_placement(link)[0] != own}
    else:
        wanted = {choice(link, sorted(known), "link with a shape") for link in texts(links, "links")}
    flat = uv.reshape(-1, 2)
    ab, found = camera.normalised(flat), np.zeros(len(flat), dtype=np.bool_)
    asked = np.flatnonzero(camera.sees(flat) & np.isfinite(ab[:, 0]))
    if len(asked):
        a, b = np.ascontiguousarray(ab[asked].T)
        box = np.array([[a.min(), b.min()], [a.max(), b.max()]])
        for shape in (shape for shape in shapes if shape.link in wanted):
            T = T_camera_root @ robot.fk(row, shape.link, reference=robot.tree.root)
            polygon = _seen(shape.points @ T[:3, :3].T + T[:3, 3], shape.radius, box)
            if polygon is not None:
                (left, top), (right, bottom) = polygon.vertices.min(axis=0), polygon.vertices.max(axis=0)
                near = np.flatnonzero((a >= left) & (a <= right) & (b >= top) & (b <= bottom))
                planes = polygon.half_planes
                inside = np.column_stack([a[near], b[near]]) @ planes[:, :2].T >= planes[:, 2]
                found[asked[near[inside.all(axis=-1)]]] = True
    return found.reshape(uv.shape[:-1])


# --- The edge of the image, and hulls in it.


def _ends(camera: Camera, normals: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Return where the planes of rays r with n·r = 0 meet the edge of the image, as rays (..., 2, 3), and whether.

    If they meet it more often, as the curved edge of a lens, it is the first and the last of these rays.
    """
    rays = _border_rays(camera)
    height = np.einsum("...k,mk->...m", normals, rays)
    above = height > 0.0
    crossing = above != np.roll(above, -1, axis=-1)
    first, last = crossing.argmax(axis=-1), len(rays) - 1 - crossing[..., ::-1].argmax(axis=-1)
    i = np.stack([first, last], axis=-1)
    j = (i + 1) % len(rays)
    one, other = (np.take_along_axis(height, k, axis=-1)[..., None] for k in (i, j))
    with np.errstate(all="ignore"):
        return (rays[i] * other - rays[j] * one) / (other - one), crossing.any(axis=-1)


def _between(ends: Floats, share: Floats) -> Floats:
    return ends[..., :1, :] + share * (ends[..., 1:, :] - ends[..., :1, :])


def _border_rays(camera: Camera) -> Floats:
    """Return rays around the edge of the image, or of the part with an invertible distortion, shape (m, 3)."""
    pixels = camera.border(_CURVED if camera.distortion else 1)
    rays = camera.ray(pixels)
    if np.isnan(rays).any():
        pixels = camera.border(_CLIPPED)
        rays = camera.ray(pixels)
        beyond = np.isnan(rays[:, 0])
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


def _seen(points: Floats, radius: float, box: Floats) -> SupportPolygon | None:
    """Return the normalised coordinates of a hull of points (n, 3) in the camera's frame, grown by a radius.

    None for a hull behind the camera, seen edge-on, or beside the box of normalised coordinates, [lowest, highest].
    """
    # In front of the camera a ≥ low is y + low x ≤ 0.
    sides, margins = points[:, None, 1:] + box * points[:, None, :1], radius * np.hypot(1.0, box)
    if (sides[:, 0] > margins[0]).all(axis=0).any() or (sides[:, 1] < -margins[1]).all(axis=0).any():
        return None
    if radius > 0.0:
        balls = []
        for centre in points:
            if np.linalg.norm(centre) > radius:
                balls.append(tangent_circle(centre, radius, _DIRECTIONS))
            else:  # an octahedron around the ball
                balls.append(centre + np.sqrt(3.0) * radius * np.concatenate([np.eye(3), -np.eye(3)]))
        points = np.concatenate(balls)
    ahead = points[:, 0] >= _NEAR
    front, behind = points[ahead], points[~ahead, None]
    share = (_NEAR - behind[..., :1]) / (front[:, :1] - behind[..., :1])
    points = np.concatenate([front, (behind + share * (front - behind)).reshape(-1, 3)])
    try:
        return SupportPolygon.around(-points[:, 1:] / points[:, :1])
    except BadArgument:
        return None
