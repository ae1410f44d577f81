"""Balance of a robot on the floor: its support polygon, and how far it is from tipping over each edge.

Statics only: the centre of mass along gravity, no inertial forces. The robot is set down by `RobotModel.set_down`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import TOUCHING, Floats, as_floats, join_poses, rigid_inverse, rows_with_gravity
from nao_kin._core.text import one_line_repr
from nao_kin._kernels.cache import Ints1
from nao_kin._kernels.hulls import hulls
from nao_kin.errors import BadArgument
from nao_kin.robot import Feet, OutlineKind, RobotModel, SetDown, SupportPolygon
from nao_kin.rotations import rot_z

# Configurations whose margins are computed at a time: larger products of matrices are split among threads.
_AT_ONCE = 2048


@one_line_repr
@dataclass(frozen=True, eq=False)
class Balance:
    """Balance of one configuration or of a batch, in the world of `set_down`.

    The support polygon has up to e vertices; where one of a batch has fewer, the last ones are NaN. In a batch, a
    configuration whose contacts span no area has NaN throughout.

    Attributes:
        down: the robot set down: pose of the root link, and what touches.
        com: centre of mass, shape (..., 3) [m].
        vertices: corners of the support polygon, counter-clockwise, shape (..., e, 2) [m].
        distances: signed distance of the centre of mass, seen from above, from the line of the edge that begins at each
            vertex, positive inside, shape (..., e) [m].
        tilts: angle by which the robot can be tilted over each edge before it tips, atan2(distance, height of the
            centre of mass); negative if it falls over that edge by itself, shape (..., e) [rad].
        margin: signed distance of the centre of mass from the polygon's edge, positive inside, shape (...) [m].
        nearest: index of the nearest edge, −1 for none, shape (...).
        T_sole_base: the root link in the frame of each sole of `down.soles`, shape (..., n, 4, 4).
        T_robot_base: the root link in the frame between the feet, `feet_frame`; NaN without soles, shape (..., 4, 4).
    """

    down: SetDown
    com: Floats
    vertices: Floats
    distances: Floats
    tilts: Floats
    margin: Floats
    nearest: Ints1
    T_sole_base: Floats
    T_robot_base: Floats


def balance(
    robot: RobotModel,
    q: ArrayLike,
    *,
    soles: Sequence[str] | str | None = None,
    contacts: ArrayLike | None = None,
    forces: ArrayLike | None = None,
    gravity: ArrayLike | None = None,
    outline: OutlineKind = "sole",
    tolerance: float = TOUCHING,
) -> Balance:
    """Set a robot down and return its support polygon, margin and tilt angles.

    The support polygon is the convex hull of the corners of the soles that touch the floor and, without `soles`, of all
    points of other links that touch it, as in a robot that sits or lies.

    Args:
        robot: any robot whose semantics name soles, or for which `soles` does.
        q: configurations, shape (..., nq).
        soles: frames of the soles on the floor, as in `RobotModel.set_down`.
        contacts: whether each sole touches the floor, shape (..., s), as in `RobotModel.set_down`.
        forces: force on each sole or sensor, as in `RobotModel.set_down`.
        gravity: direction of gravity in the root link, as in `RobotModel.set_down`.
        outline: corners of a sole, "sole" for the area that touches the floor or "sensors", as in
            `RobotModel.sole_outline`.
        tolerance: height up to which a point touches the floor [m].

    Raises:
        BadArgument: a single configuration whose contacts span no area; a sole without outline; a robot without mass;
            what `set_down` refuses.
        ZeroNorm: zero gravity.

    Examples:
        >>> nao = nk.load_nao()
        >>> found = nk.world.balance(nao, nao.posture("StandInit"))
        >>> round(float(found.margin), 3), round(float(np.degrees(found.tilts.min())), 1)
        (0.069, 14.1)
    """
    feet = Feet.of(robot, soles, outline)
    names = feet.names
    down = robot.set_down(q, soles=soles, contacts=contacts, forces=forces, gravity=gravity, tolerance=tolerance)
    batch = down.stands.shape
    rows = np.broadcast_to(robot.checked(q), (*batch, robot.nq)).reshape(-1, robot.nq)
    T_world_base = down.T_world_base.reshape(-1, 4, 4)
    T_base_soles = np.asarray(robot.fk(rows, names, reference=robot.tree.root)).reshape(len(rows), len(names), 4, 4)
    T_world_soles = T_world_base[:, None] @ T_base_soles
    com = robot.com(rows, reference=robot.tree.root)
    com = np.einsum("nij,nj->ni", T_world_base[:, :3, :3], com) + T_world_base[:, :3, 3]
    corners = feet.placed(T_world_soles)
    points = np.where(on_floor(down, feet, corners, tolerance)[..., None], corners[..., :2], np.nan)
    if soles is None:
        others = feet.others(robot, down.links.reshape(len(rows), len(robot.link_names)))
        if contacts is not None or forces is not None:
            others &= ~down.stands.reshape(-1, 1)
        for k in np.flatnonzero(others.any(axis=1)).tolist():
            points = _with_hull(points, k, feet.points_on_floor(robot, rows[k], T_world_base[k], tolerance))
    vertices, distances, margins, nearest = hulls(points, com[:, :2])
    if not batch and nearest[0] < 0:
        raise BadArgument(f"the contacts of {robot.name} with the floor span no area: there is no support polygon")
    most = max(3, int(np.isfinite(distances).sum(axis=1).max(initial=3)))
    vertices, distances = vertices[:, :most], distances[:, :most]
    T_robot_base = np.full((len(rows), 4, 4), np.nan)
    if names:
        T_robot_base = rigid_inverse(feet_frame(feet.on_ground(T_world_soles))) @ T_world_base
    tilts = np.arctan2(distances, com[:, None, 2])
    results = com, vertices, distances, tilts, margins, nearest, rigid_inverse(T_base_soles), T_robot_base
    return Balance(down, *(part.reshape((*batch, *part.shape[1:])) for part in results))


def margin(
    robot: RobotModel,
    q: ArrayLike,
    *,
    soles: Sequence[str] | str | None = None,
    gravity: ArrayLike | None = None,
    outline: OutlineKind = "sole",
) -> Floats:
    """Return the margins of configurations whose named soles are all on the floor, without setting the robot down.

    Arguments as in `balance`; all corners of the soles count as contacts, and `soles` of None means all soles of the
    semantics. Without `gravity` the mean of their normals is vertical.

    Returns:
        Signed distances of the centre of mass, seen from above, from the edge of the support polygon, positive inside;
        NaN for soles without area seen from above, shape (...) [m].

    Raises:
        BadArgument: no soles, a sole without outline, a robot without mass.
        ZeroNorm: zero gravity.

    Examples:
        >>> nao = nk.load_nao()
        >>> nk.world.margin(nao, [nao.posture("StandInit"), nao.posture("Crouch")]).round(3).tolist()
        [0.069, 0.067]
    """
    feet = Feet.of(robot, soles, outline, needed=True)
    batch, rows, given = rows_with_gravity(robot.checked(q), gravity)
    found = np.empty(len(rows))
    for start in range(0, len(rows), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        T = np.asarray(robot.fk(rows[part], feet.names, reference=robot.tree.root))
        com = robot.com(rows[part], reference=robot.tree.root)
        found[part] = hulls(*feet.from_above(T, com, None if given is None else given[part]))[2]
    return found.reshape(batch)


def feet_frame(T_world_feet: ArrayLike) -> Floats:
    """Return the frame between feet, NAOqi's FRAME_ROBOT: T_world_robot.

    Its origin is the mean of the feet's origins, at the height of the lowest one; its z axis is the vertical, its yaw
    the mean direction of the feet's x axes.

    Args:
        T_world_feet: poses of n feet in a world whose z axis is the vertical, shape (..., n, 4, 4).

    Returns:
        Shape (..., 4, 4).

    Examples:
        >>> nao = nk.load_nao()
        >>> feet = nao.fk(nao.posture("StandInit"), nao.semantics.soles)
        >>> nk.world.feet_frame(feet)[:3, 3].round(3).tolist()
        [0.023, 0.0, -0.32]
    """
    T = as_floats(T_world_feet, (4, 4), "T_world_feet")
    if T.ndim < 3 or not T.shape[-3]:
        raise BadArgument("T_world_feet must have shape (..., n, 4, 4), with one foot at least")
    x, places = T[..., :2, 0], T[..., :3, 3]
    ahead = (x / np.maximum(np.linalg.norm(x, axis=-1, keepdims=True), 1e-12)).sum(axis=-2)
    origin = np.concatenate([places[..., :2].mean(axis=-2), places[..., 2:].min(axis=-2)], axis=-1)
    return join_poses(rot_z(np.arctan2(ahead[..., 1], ahead[..., 0])), origin)


def on_floor(down: SetDown, feet: Feet, corners: Floats, tolerance: float) -> NDArray[np.bool_]:
    """Return which corners (n, k, 3) of soles are on the floor: all of a sole that touches with its whole outline."""
    touching = down.corners_touching.reshape(len(corners), len(down.corner_soles))
    some, whole = np.zeros((2, len(corners), len(feet.names)), dtype=np.bool_)
    for k in range(len(feet.names)):
        own = touching[:, down.corner_soles == k]
        some[:, k], whole[:, k] = own.any(axis=1), own.all(axis=1)
    return np.asarray(whole[:, feet.owner] | some[:, feet.owner] & (corners[..., 2] <= tolerance))


def _with_hull(points: Floats, k: int, more: Floats) -> Floats:
    """Return points (n, m, 2), with m as large as needed, whose k-th row is the hull of its points and more."""
    own = np.concatenate([points[k][np.isfinite(points[k, :, 0])], more[:, :2]])
    try:
        corners = SupportPolygon.around(own).vertices
    except BadArgument:
        return points
    missing = max(0, len(corners) - points.shape[1])
    wider = np.pad(points, ((0, 0), (0, missing), (0, 0)), constant_values=np.nan)
    wider[k] = np.nan
    wider[k, : len(corners)] = corners
    return wider
