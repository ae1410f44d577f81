"""The support polygon: the convex hull of the soles on the floor, seen from above.

The world's z axis points up. For flat soles on one floor the centre of mass must be above this polygon. For other soles
it is the hull of their projections; friction is not considered.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, as_numbers, shaped
from nao_kin._core.text import one_line_repr
from nao_kin._kernels.hulls import from_edge, hull_of
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot.kinematic_robot import KinematicRobot
from nao_kin.screws import rigid_poses

# Largest distance of a corner of the sole from the plane of the sole [m].
_FLAT = 1e-6


@one_line_repr
@dataclass(frozen=True, eq=False)
class SupportPolygon:
    """A convex polygon in the world's xy plane.

    Attributes:
        vertices: counter-clockwise, shape (k, 2) [m].
    """

    vertices: Floats

    @staticmethod
    def around(points: ArrayLike) -> SupportPolygon:
        """Return the convex hull of the x and y of points, shape (n, 2) or (n, 3).

        Raises:
            BadArgument: the points are collinear.

        Examples:
            >>> nk.robot.SupportPolygon.around([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]]).vertices.shape
            (4, 2)
        """
        ordered = sorted(set(map(tuple, _places(points).reshape(-1, 2).tolist())))
        x, y, hull = [x for x, _ in ordered], [y for _, y in ordered], [0] * (2 * len(ordered) + 1)
        corners = hull[: hull_of(x, y, len(x), hull)]
        if not corners:
            raise BadArgument("the soles have no area seen from above: do they stand upright?")
        return SupportPolygon(np.array([(x[i], y[i]) for i in corners]))

    @staticmethod
    def of_soles(soles: Iterable[tuple[Floats, Floats]]) -> SupportPolygon:
        """Return the support polygon of soles, each given as T_world_sole and its corners (k, 3) in the sole's frame.

        Examples:
            >>> nao = nk.load_nao()
            >>> T = nao.fk(nao.posture("StandInit"), ["LLeg", "RLeg"])
            >>> corners = [nao.sole_outline(sole, "sensors") for sole in ("LLeg", "RLeg")]
            >>> nk.robot.SupportPolygon.of_soles(zip(T, corners)).vertices.shape
            (5, 2)
        """
        corners = []
        for pose, outline in soles:
            T = rigid_poses(shaped(pose, (4, 4), "the pose of a sole"), "the pose of a sole")
            points = as_floats(outline, (3,), "corners of a sole").reshape(-1, 3)
            corners.append(points @ T[:3, :3].T + T[:3, 3])
        return SupportPolygon.around(np.concatenate(corners) if corners else np.empty((0, 3)))

    @property
    def _along(self) -> Floats:
        """The vectors from each vertex to the next, shape (k, 2)."""
        return np.asarray(self.vertices[np.arange(1 - len(self.vertices), 1)] - self.vertices)

    @property
    def half_planes(self) -> Floats:
        """The edges as (n_x, n_y, d), shape (k, 3), with the inward unit normal n: inside is where n·p ≥ d."""
        x, y = self._along.T
        normals = np.array([-y, x]) / np.sqrt(x * x + y * y)
        return np.array([*normals, (normals * self.vertices.T).sum(axis=0)]).T

    def signed_distance(self, points: ArrayLike) -> Floats:
        """Return the distances of points (..., 2) or (..., 3) from the edge, positive inside, shape (...) [m].

        Examples:
            >>> square = nk.robot.SupportPolygon.around([[0, 0], [1, 0], [1, 1], [0, 1]])
            >>> square.signed_distance([[0.5, 0.5], [0.5, -0.2]]).round(3).tolist()
            [0.5, -0.2]
        """
        lever = _places(points)[..., None, :] - self.vertices
        lines, squares = from_edge(lever[..., 0], lever[..., 1], *self._along.T)
        inside = lines.min(axis=-1)
        return np.asarray(np.where(inside >= 0.0, inside, -np.sqrt(squares.min(axis=-1))))


def _places(points: ArrayLike) -> Floats:
    """Return x and y of points, shape (..., 2)."""
    array = as_numbers(points, "points")
    if array.shape[-1:] not in ((2,), (3,)):
        raise WrongShape("points", "(..., 2) or (..., 3)", array.shape)
    return as_floats(array[..., :2], (2,), "points")


def named_soles(robot: KinematicRobot, soles: Sequence[str] | str | None, *, needed: bool = False) -> tuple[str, ...]:
    """Return the names of soles, by default those of the semantics, after checking that they are frames."""
    if soles is None:
        if needed and not robot.semantics.soles:
            raise BadArgument(
                f"{robot.name} has no soles in its semantics; name the standing frames, as in soles=[…] (--sole)"
            )
        return robot.semantics.soles
    robot.frame_ids(soles)
    names = (soles,) if isinstance(soles, str) else tuple(soles)
    if not names:
        raise BadArgument("soles must name at least one frame; None for the soles of the robot's semantics")
    return names


def sole_corners(robot: KinematicRobot, sole: str) -> NDArray[np.float64]:
    """Return the hull of the frames on the foot in the plane of a sole, in its own frame, shape (k, 3) [m].

    On a NAO the corners are the four pressure sensors, which carry the robot, inside the area that touches the floor
    (`RobotModel.sole_outline`). The hull is counter-clockwise.
    """
    model, table = robot.model, robot.frame_table
    own = model.frames[robot.frame_ids([sole])[0]]
    frames = [model.frames[index] for name, index in table.items() if name not in robot.tree.added]
    places = [frame.placement for frame in frames if frame.parentJoint == own.parentJoint]
    points = np.array([own.placement.actInv(place).translation for place in places])
    flat = points[np.abs(points[:, 2]) <= _FLAT]
    if len(np.unique(np.round(flat, 12), axis=0)) < 3:
        raise BadArgument(f"{robot.name} has no outline of {sole}: fewer than three frames lie in its plane")
    return np.pad(SupportPolygon.around(np.round(flat, 12)).vertices, ((0, 0), (0, 1)))


def support_polygon(
    robot: KinematicRobot, q: ArrayLike, soles: Sequence[str] | None, reference: str | None
) -> SupportPolygon:
    """Return the support polygon of a robot; the arguments are those of `RobotModel.support_polygon`."""
    names = named_soles(robot, soles, needed=True)
    row = robot.checked(q)
    if row.ndim != 1:
        raise WrongShape("q", f"({robot.nq},), one configuration", row.shape)
    poses = robot.fk(row, names, reference=names[0] if reference is None else reference)
    return SupportPolygon.of_soles((T, sole_corners(robot, name)) for T, name in zip(poses, names, strict=True))
