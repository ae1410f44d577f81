"""Setting a robot down on a level floor: which way is up, how high the root is, and what touches.

The robot is a rigid body in its configuration. What can touch the floor are the corners of its soles and the points of
its visual shapes; shapes that cannot be read are left out. The page of the viewer follows the same rules.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    TOUCHING,
    Floats,
    as_numbers,
    check_tolerance,
    choice,
    join_poses,
    rows_with_gravity,
    shaped,
)
from nao_kin._core.text import one_line_repr
from nao_kin._kernels.settling import ROLLING, settle
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot.geometry import hull_corners, shape_geometry
from nao_kin.robot.kinematic_robot import KinematicRobot
from nao_kin.robot.support_polygon import SupportPolygon, named_soles, sole_corners
from nao_kin.robot.urdf import Box, Cylinder, Sphere, UnreadableShape
from nao_kin.rotations import rotation_between

# Largest angle by which a robot turns from the plane of its soles until it rests on them [rad]: from a sole that its
# centre of mass is above, because another foot is lower, and otherwise onto another foot. Backlash of the joints makes
# angles up to the second; a robot that would turn farther onto a foot in the air falls.
_FROM_OWN, _ONTO_OTHER = math.radians(5.0), math.radians(1.5)
# How far above its lowest point a sole is taken for flat, if only its shapes are known [m].
_FLAT = 0.002
# How far other links may be below the soles of a robot that stands on them [m].
_BELOW = 0.001
# A foot is flat on the floor up to this angle of its sole [rad]: the edges of a NAO's foot are then 0.08 mm below it.
_FLAT_FOOT = np.radians(1.0)
# A sole carries if the force on it is at least this share of the total.
_CARRYING = 0.1
# Largest difference that counts between a joint and that of a posture [rad]: one moved arm makes no other posture.
_ELSEWHERE = 0.5
# Directions in which the outermost points of a link are found: a rounded link is then placed on the floor to a small
# fraction of a millimetre.
_DIRECTIONS = 800
# Configurations that are set down at a time: larger products of matrices are split among threads, which costs more.
_AT_ONCE = 256
_HALF_TURN = np.array([[np.pi]])
_UPRIGHT = np.array([0.0, 0.0, 1.0])

OutlineKind = Literal["sole", "sensors"]
OUTLINE_KINDS: tuple[str, ...] = get_args(OutlineKind)


@one_line_repr
@dataclass(frozen=True, eq=False)
class SetDown:
    """A robot on a level floor, for one configuration or a batch.

    Attributes:
        T_world_base: pose of the root link, shape (..., 4, 4). The floor is z = 0, z points up, the root link is above
            the origin, and its heading is that of the smallest rotation that makes it upright [m].
        soles: names of the soles, n of them.
        touching: whether each sole touches the floor, shape (..., n).
        corners: the corners of all soles in the world, sole after sole, shape (..., k, 3) [m].
        corner_soles: the index of each corner's sole, shape (k,).
        corners_touching: whether each corner touches the floor, shape (..., k): it is at most `tolerance` above the
            floor, or on a sole that is known to carry, by contacts or forces.
        links: whether each link touches the floor with its shapes, in the order of `robot.link_names`.
        stands: whether it was set down on soles, also if it falls from them; otherwise it rests on its lowest points;
            shape (...).
    """

    T_world_base: Floats
    soles: tuple[str, ...]
    touching: NDArray[np.bool_]
    corners: Floats
    corner_soles: NDArray[np.intp]
    corners_touching: NDArray[np.bool_]
    links: NDArray[np.bool_]
    stands: NDArray[np.bool_]


def set_down(
    robot: KinematicRobot,
    q: ArrayLike,
    *,
    soles: Sequence[str] | str | None = None,
    contacts: ArrayLike | None = None,
    forces: ArrayLike | None = None,
    gravity: ArrayLike | None = None,
    tolerance: float = TOUCHING,
) -> SetDown:
    """Set a robot down; the arguments are those of `RobotModel.set_down`."""
    floor = _floor_of(robot)
    check_tolerance(tolerance)
    tolerance = float(tolerance)  # unsigned numbers have no negative ones
    feet = Feet.of(robot, soles, or_origin=True)
    names = feet.names
    if not names and not floor.links:
        raise BadArgument(f"{robot.name} has neither soles nor shapes to be set down on")
    batch, rows, down = rows_with_gravity(robot.checked(q), gravity)
    measured = _carrying(robot, feet, batch, contacts, forces)
    known = np.full((*batch, len(names)), soles is not None) if measured is None else measured
    known = known.reshape(len(rows), len(names))
    given = measured is not None
    parts = [
        _rows_down(robot, floor, feet, rows[k], known[k], given, None if down is None else down[k], tolerance)
        for k in (slice(first, first + _AT_ONCE) for first in range(0, max(1, len(rows)), _AT_ONCE))
    ]
    T, corners, on_floor, links, stands = (
        np.concatenate(part).reshape((*batch, *part[0].shape[1:])) for part in zip(*parts, strict=True)
    )
    return SetDown(T, names, on_floor @ feet.corners_of, corners, feet.owner, on_floor, links, stands)


def _carrying(
    robot: KinematicRobot, feet: Feet, batch: tuple[int, ...], contacts: ArrayLike | None, forces: ArrayLike | None
) -> NDArray[np.bool_] | None:
    """Return which soles carry by contacts or forces, shape (*batch, S); None if neither is given."""
    if contacts is not None and forces is not None:
        raise BadArgument("give contacts or forces, not both")
    if contacts is not None:
        return np.asarray(shaped(contacts, (*batch, len(feet.names)), "contacts") != 0.0)
    if forces is None:
        return None
    return feet.loaded(feet.forces(robot, forces, batch))


class Feet(NamedTuple):
    """Soles and their corners: points of all soles in their frames, shape (k, 3) [m], and the index of each sole."""

    names: tuple[str, ...]
    points: Floats
    owner: NDArray[np.intp]

    @staticmethod
    def of(
        robot: KinematicRobot,
        soles: Sequence[str] | str | None,
        kind: OutlineKind = "sole",
        *,
        needed: bool = False,
        or_origin: bool = False,
    ) -> Feet:
        """Return soles with their outlines, by default those of the semantics; refuse none at all if `needed`.

        With `or_origin`, the origin replaces a missing outline.
        """
        names, outlines = named_soles(robot, soles, needed=needed), []
        for name in names:
            try:
                outlines.append(sole_outline(robot, name, kind))
            except BadArgument:
                if not or_origin:
                    raise
                outlines.append(np.zeros((1, 3)))
        points = np.concatenate([*outlines, np.empty((0, 3))])
        return Feet(names, points, np.repeat(np.arange(len(names)), [len(outline) for outline in outlines]))

    @property
    def corners_of(self) -> NDArray[np.bool_]:
        """Which corners belong to each sole, shape (k, S)."""
        return np.asarray(np.equal.outer(self.owner, np.arange(len(self.names))))

    def placed(self, T_soles: Floats) -> Floats:
        """Return the corners of soles at T_soles (n, S, 4, 4), shape (n, k, 3)."""
        placed = np.empty((len(T_soles), len(self.points), 3))
        for k in range(len(self.names)):
            own, T = self.owner == k, T_soles[:, k]
            placed[:, own] = self.points[own] @ T[:, :3, :3].swapaxes(1, 2) + T[:, None, :3, 3]
        return placed

    def from_above(self, T_soles: Floats, points: Floats, down: Floats | None) -> tuple[Floats, Floats]:
        """Return x and y of the corners of soles at T_soles (n, S, 4, 4), and of points (n, 3), seen along `down`.

        Shapes (n, k, 2) and (n, 2); without directions down (n, 3), along the mean of the soles' normals.
        """
        across = level_axes(-common_down(T_soles) if down is None else -down)
        corners = np.empty((len(T_soles), 2, len(self.points)))
        for k in range(len(self.names)):
            own, T = self.owner == k, T_soles[:, k]
            turned = (T[:, :3, :3].reshape(-1, 3) @ self.points[own].T).reshape(len(T), 3, -1)
            corners[:, :, own] = np.einsum("nai,nim->nam", across, turned + T[:, :3, 3:])
        return corners.swapaxes(1, 2), np.einsum("nai,ni->na", across, points)

    def below(self, T_soles: Floats, points: Floats) -> NDArray[np.bool_]:
        """Return which soles at T_soles (n, S, 4, 4) have points (n, 3) above their outlines, shape (n, S)."""
        found = np.zeros((len(T_soles), len(self.names)), dtype=np.bool_)
        for k in range(len(self.names)):
            try:
                edges = SupportPolygon.around(self.points[self.owner == k]).half_planes
            except BadArgument:
                continue
            local = ((points - T_soles[:, k, :3, 3])[:, None] @ T_soles[:, k, :3, :2])[:, 0]
            found[:, k] = (local @ edges[:, :2].T >= edges[:, 2]).all(axis=1)
        return found

    def on_ground(self, T_soles: Floats) -> Floats:
        """Return the poses of soles (..., S, 4, 4), each moved along its z axis to its lowest corner."""
        T = np.array(T_soles)
        T[..., :3, 3] += T[..., :3, 2] * self.heights[:, None]
        return T

    @property
    def heights(self) -> Floats:
        """The z of the lowest corner of each sole in its frame, shape (S,) [m]."""
        return np.array([self.points[self.owner == k, 2].min() for k in range(len(self.names))])

    def forces(self, robot: KinematicRobot, forces: ArrayLike, batch: tuple[int, ...]) -> Floats:
        """Return the force on each sole, none below zero, shape (*batch, S), from those on the soles or sensors."""
        values, sensors = as_numbers(forces, "forces"), robot.semantics.force_sensors
        own, all_sensors = (*batch, len(self.names)), (*batch, len(sensors))
        if values.shape != own and (values.shape != all_sensors or not sensors):
            raise WrongShape("forces", f"{own}" + (f" or {all_sensors}" if sensors else ""), values.shape)
        pressed = np.maximum(shaped(forces, values.shape, "forces"), 0.0)
        return pressed if values.shape == own else pressed @ self.carried(robot, sensors).T

    @staticmethod
    def loaded(pressed: Floats) -> NDArray[np.bool_]:
        """Return which soles carry the robot, given the force on each, shape (..., S)."""
        total = pressed.sum(axis=-1, keepdims=True)
        return np.asarray((total > 0.0) & (pressed >= _CARRYING * total))

    def carried(self, robot: KinematicRobot, links: Sequence[str]) -> NDArray[np.bool_]:
        """Return which links move with each sole, shape (S, L)."""
        return _on_one_body(robot, self.names, links)

    @staticmethod
    def points_on_floor(robot: KinematicRobot, q: Floats, T_world_base: Floats, tolerance: float) -> Floats:
        """Return the vertices of all shapes, feet included, that touch the floor in one configuration, (k, 3) [m]."""
        floor = _floor_of(robot)
        T_links = T_world_base @ robot.fk(q, floor.links, reference=robot.tree.root)
        near = np.flatnonzero(floor._deepest(T_links[None], -_UPRIGHT[None])[0] + tolerance >= 0.0)
        points = _placed([floor.vertices[k] for k in near], T_links[near])
        return points[points[:, 2] <= tolerance]

    def others(self, robot: KinematicRobot, links: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return the columns of all links (n, L) without those that move with a sole."""
        return links[:, ~self.carried(robot, robot.link_names).any(axis=0)]


def sole_outline(robot: KinematicRobot, sole: str, kind: OutlineKind = "sole") -> Floats:
    """Return the outline of a sole; the arguments are those of `RobotModel.sole_outline`."""
    choice(kind, OUTLINE_KINDS, "kind of outline")
    if kind == "sensors":
        return sole_corners(robot, sole)
    named = robot.semantics.outlines.get(sole)
    if named is not None:
        return np.array([(*corner, 0.0)[:3] for corner in named])
    try:
        return sole_corners(robot, sole)
    except BadArgument:
        floor = _floor_of(robot)
        carried = np.flatnonzero(_on_one_body(robot, (sole,), floor.links)[0])
        T_sole_links = robot.fk(robot.neutral(), floor.links, reference=sole)
        near = _placed([floor.vertices[k] for k in carried], T_sole_links[carried])
        lowest = near[:, 2].min(initial=np.inf)
        points = near[near[:, 2] <= lowest + _FLAT]
        if len(points) < 3:
            raise
    vertices = SupportPolygon.around(points).vertices
    return np.pad(vertices, ((0, 0), (0, 1)), constant_values=lowest)


# --- The points that can touch the floor.


class Floor(NamedTuple):
    """The points of a robot that can touch a floor."""

    links: tuple[str, ...]  # names of the links that have shapes
    rows: NDArray[np.intp]  # their indices in `robot.link_names`
    centres: Floats  # of a sphere around the vertices of each link
    radii: Floats
    vertices: tuple[Floats, ...]  # of each link, in its frame, for the height of the floor [m]
    outermost: tuple[Floats, ...]  # those that are farthest in some direction, which suffice for the floor's direction

    def lowest(
        self, T: Floats, down: Floats, known: Floats, *, without: NDArray[np.bool_] | None = None, exact: bool = True
    ) -> Floats:
        """Return how far down the lowest of a known point and all vertices is, shape (n,), `without` links (n, L)."""
        lowest = np.array(known)
        if not self.links or not len(T):
            return lowest
        # A link is looked at where its sphere reaches lower than all links before, the deepest ones first.
        most = self._deepest(T, down)
        if without is not None:
            most[without] = -np.inf
        peaks = most.max(axis=0)
        for k in np.argsort(-peaks, kind="stable"):
            if peaks[k] <= lowest.min():
                break
            rows = np.flatnonzero(most[:, k] > lowest)
            lowest[rows] = np.maximum(lowest[rows], self._depth_of(k, T[rows], down[rows], exact))
        return lowest

    def _deepest(self, T: Floats, down: Floats) -> Floats:
        """Return how far down the spheres of the links reach, shape (n, L)."""
        centres = np.pad(self.centres, ((0, 0), (0, 1)), constant_values=1.0)
        return np.asarray(np.einsum("nlij,ni,lj->nl", T[..., :3, :], down, centres) + self.radii)

    def _depth_of(self, k: int, T: Floats, down: Floats, exact: bool = False) -> Floats:
        points = (self.vertices if exact else self.outermost)[k]
        towards = np.einsum("nij,ni->nj", T[:, k, :3, :3], down)
        return np.asarray((towards @ points.T).max(axis=1) + np.einsum("nk,nk->n", down, T[:, k, :3, 3]))

    def touching(self, T: Floats, down: Floats, least: Floats) -> NDArray[np.bool_]:
        """Return which links have a point at least so far down, shape (n, L)."""
        found: NDArray[np.bool_] = self._deepest(T, down) >= least[:, None]
        for k in np.flatnonzero(found.any(axis=0)).tolist():
            rows = np.flatnonzero(found[:, k])
            found[rows, k] = self._depth_of(k, T[rows], down[rows]) >= least[rows]
        return found


def _placed(parts: Iterable[Floats], T: Floats) -> Floats:
    """Return the points of links, each given in its link, for links at T (L, 4, 4), shape (p, 3)."""
    placed = (points @ pose[:3, :3].T + pose[:3, 3] for points, pose in zip(parts, T, strict=True))
    return np.concatenate([*placed, np.empty((0, 3))])


def _on_one_body(robot: KinematicRobot, frames: Sequence[str], links: Sequence[str]) -> NDArray[np.bool_]:
    """Return which links move with which frames, shape (F, L)."""
    every = robot.model.frames
    one, other = ([every[i].parentJoint for i in robot.frame_ids(each)] for each in (frames, links))
    return np.asarray(np.equal.outer(one, other))


def _floor_of(robot: KinematicRobot) -> Floor:
    """Return the points of a robot, which are read once for all robots that are made from its tree."""
    made = robot.tree.made
    if Floor not in made:
        made[Floor] = _read_floor(robot)
    floor: Floor = made[Floor]
    return floor


def _read_floor(robot: KinematicRobot) -> Floor:
    tree, outlines = robot.tree, dict[str, list[Floats]]()
    packages = tree.packages
    for visual in tree.visuals:
        try:
            points = _outermost(visual.geometry, packages)
        except UnreadableShape:
            continue
        T = visual.origin.matrix
        outlines.setdefault(visual.link, []).append(points @ T[:3, :3].T + T[:3, 3])
    links = tuple(name for name in robot.link_names if name in outlines)
    vertices = tuple(np.unique(np.concatenate(outlines[name]), axis=0) for name in links)
    outermost = tuple(own[np.unique((own @ _directions().T).argmax(axis=0))] for own in vertices)
    centres = np.array([(own.min(axis=0) + own.max(axis=0)) / 2.0 for own in vertices]).reshape(-1, 3)
    radii = np.array([np.linalg.norm(own - c, axis=1).max() for own, c in zip(vertices, centres, strict=True)])
    rows = np.array([robot.link_names.index(name) for name in links], dtype=np.intp)
    for array in (rows, centres, radii, *vertices, *outermost):
        array.flags.writeable = False  # robots share them
    return Floor(links, rows, centres, radii, vertices, outermost)


def _outermost(shape: Any, packages: Any) -> Floats:
    """Return points of a shape that are outermost in some direction; all vertices of a mesh."""
    if isinstance(shape, Sphere):
        return np.asarray(shape.radius * _directions())
    if isinstance(shape, Cylinder):
        across = _directions()[:, :2] / np.linalg.norm(_directions()[:, :2], axis=1)[:, None]
        ends = 0.5 * shape.length * np.sign(_directions()[:, 2:])
        return np.column_stack([shape.radius * across, ends])
    if isinstance(shape, Box):
        return hull_corners(shape, packages)
    return np.asarray(shape_geometry(shape, packages).vertices(), dtype=np.float64)


@functools.cache
def _directions() -> Floats:
    """Return directions spread evenly over the sphere, each turned by the golden angle from the one before.

    None is in a plane of symmetry of a shape, where two vertices would be equally far out.
    """
    middle = np.arange(_DIRECTIONS) + 0.5
    z = 1.0 - 2.0 * middle / _DIRECTIONS
    turn = np.pi * (3.0 - np.sqrt(5.0)) * middle
    radius = np.sqrt(1.0 - z * z)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), z])


# --- The direction up.


def _rows_down(
    robot: KinematicRobot,
    floor: Floor,
    feet: Feet,
    rows: Floats,
    known: NDArray[np.bool_],
    measured: bool,
    gravity: Floats | None,
    tolerance: float,
) -> tuple[Floats, Floats, NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Return T_world_base, the corners, which of them touch, which links touch, and which rows stand.

    `known` is which soles carry, shape (n, S), none where this is not known. Where it is `measured`, all corners of
    these soles touch; elsewhere, the corners that are at most `tolerance` above the floor.
    """
    T = np.asarray(robot.fk(rows, (*floor.links, *feet.names), reference=robot.tree.root))
    T_links, T_soles = T[:, : len(floor.links)], T[:, len(floor.links) :]
    corners = feet.placed(T_soles)
    used, stands = known.copy(), np.asarray(known.any(axis=1))
    carrying = known & measured
    free = np.flatnonzero(~stands)
    down = np.empty((len(rows), 3)) if gravity is None else gravity
    if gravity is None:
        down[stands] = common_down(T_soles[stands], known[stands])
        down[free], used[free], stands[free] = _down_of(
            robot, floor, feet, rows[free], T_links[free], T_soles[free], corners[free]
        )
    heights = (corners @ down[..., None])[..., 0]
    counts = known | ~known.any(axis=1, keepdims=True)
    deepest = np.where(counts[:, feet.owner], heights, -np.inf).max(axis=1, initial=-np.inf)
    # Of the feet that the robot stands on, the planes of the soles are on the floor, whatever the shapes.
    on_soles = (used[free] & _are_flat(T_soles[free], down[free])) @ feet.carried(robot, floor.links)
    deepest[free] = floor.lowest(T_links[free], down[free], deepest[free], without=on_soles)
    R = rotation_between(-down, _UPRIGHT, axis=[0.0, 1.0, 0.0])
    T_world_base = join_poses(R, deepest[:, None] * _UPRIGHT)
    in_world = corners @ R.swapaxes(1, 2) + T_world_base[:, None, :3, 3]
    links = np.zeros((len(rows), len(robot.link_names)), dtype=np.bool_)
    links[:, floor.rows] = floor.touching(T_links, down, deepest - tolerance)
    touching = np.where(carrying.any(axis=1, keepdims=True), carrying[:, feet.owner], in_world[..., 2] <= tolerance)
    return T_world_base, in_world, touching, links, stands


def _are_flat(T_soles: Floats, down: Floats) -> NDArray[np.bool_]:
    """Return which soles at T_soles (n, S, 4, 4) are flat on a floor across `down` (n, 3), shape (n, S)."""
    return np.asarray(-(T_soles[..., :3, 2] @ down[..., None])[..., 0] > np.cos(_FLAT_FOOT))


def common_down(T_soles: Floats, carrying: NDArray[np.bool_] | None = None) -> Floats:
    """Return the unit mean of the directions down of soles (n, S, 4, 4), or of those that carry (n, S).

    Raises:
        BadArgument: a mean is zero.
    """
    down, length = _mean_down(T_soles, carrying)
    if not length.all():
        raise BadArgument("the soles face opposite directions: name one of them, or give gravity")
    return down


def _mean_down(T_soles: Floats, carrying: NDArray[np.bool_] | None = None) -> tuple[Floats, Floats]:
    """Return the unit mean of the directions down of soles (n, S, 4, 4) that carry, and its length before."""
    normals = T_soles[..., :3, 2]
    down = -(normals if carrying is None else normals * carrying[..., None]).sum(axis=1)
    length = np.linalg.norm(down, axis=-1)
    far = length > 1e-9
    return np.where(far[:, None], down, -_UPRIGHT) / np.where(far, length, 1.0)[:, None], np.where(far, length, 0.0)


def _down_of(
    robot: KinematicRobot, floor: Floor, feet: Feet, rows: Floats, T_links: Floats, T_soles: Floats, corners: Floats
) -> tuple[Floats, NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the direction down of each row, its soles on the floor, shape (n, S), and whether it stands on them."""
    has_mass = robot.mass > 0.0
    # Without masses, the centre is above the middle of the soles.
    centres = robot.com(rows, reference=robot.tree.root) if has_mass else corners.sum(axis=1) / max(1, len(feet.points))
    down, used, rests = _on_soles(robot, floor, feet, centres, T_links, T_soles, corners)
    stands: NDArray[np.bool_] = np.asarray(used.any(axis=1))
    ups = [robot.semantics.postures[name].up for name in robot.posture_names]
    falling = np.flatnonzero(~rests)
    if not any(ups) or not floor.links or not has_mass or not len(falling):
        return down, used, stands
    joints = slice(robot.nq_base, None)
    known = np.stack([robot.posture(name)[joints] for name in robot.posture_names])
    away = np.minimum(np.abs(known - rows[falling, None, joints]), _ELSEWHERE).sum(axis=-1).argmin(axis=1)
    for k, posture in zip(falling.tolist(), away.tolist(), strict=True):
        up = ups[posture]
        if up is not None:
            begin = -np.array(up, dtype=np.float64) / np.linalg.norm(up)
            points = _placed(floor.outermost, T_links[k])
            down[k] = settle(points[None], centres[k : k + 1], begin[None, None], _HALF_TURN)[0][0]
            stands[k], used[k] = False, False
    return down, used, stands


def _on_soles(
    robot: KinematicRobot, floor: Floor, feet: Feet, centres: Floats, T_links: Floats, T_soles: Floats, corners: Floats
) -> tuple[Floats, NDArray[np.bool_], NDArray[np.bool_]]:
    """Return the direction down, the soles on the floor, shape (n, S), and whether the robot rests on them.

    The robot is put down on all soles, or on one, and turns until its centre of mass is above the corners on the floor.
    A robot that does not come to rest is level with the soles on the floor from which it falls, or, if other links are
    then below them, its root is upright.
    """
    n, count = T_soles.shape[:2]
    down, used, rests = np.tile(-_UPRIGHT, (n, 1)), np.zeros((n, count), dtype=np.bool_), np.zeros(n, dtype=np.bool_)
    if not count:
        return down, used, rests
    starts = -T_soles[..., :3, 2]
    most = np.where(feet.below(T_soles, centres), _FROM_OWN, _ONTO_OTHER)
    if count > 1:
        mean, length = _mean_down(T_soles)
        starts = np.concatenate([np.where(length > 0.0, mean.T, np.nan).T[:, None], starts], axis=1)
        most = np.column_stack([np.full(n, _ONTO_OTHER), most])
    left: NDArray[np.intp] = np.arange(n)
    carried = feet.carried(robot, floor.links)

    def lowest(rows: NDArray[np.intp], down: Floats) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return which soles are on the floor across `down` (m, 3), shape (m, S), and whether no link is below them."""
        heights = (corners[rows] @ down[..., None])[..., 0]
        deepest = heights.max(axis=1)
        on_floor = heights >= deepest[:, None] - 2.0 * ROLLING
        soles = on_floor @ feet.corners_of
        least = deepest + _BELOW
        flat = soles & _are_flat(T_soles[rows], down)
        under = floor.lowest(T_links[rows], down, least, without=flat @ carried, exact=False) <= least
        return soles, np.asarray(under)

    for _ in range(starts.shape[1]):
        found, away, chosen = settle(corners[left], centres[left], starts[left], most[left])
        soles, under = lowest(left, found)
        rows = left[under]
        down[rows], rests[rows], used[rows] = found[under], away[under] == 0.0, soles[under]
        starts[left, chosen] = np.nan
        left = left[~under & (chosen >= 0)]
        if not len(left):
            break
    falls = np.flatnonzero(used.any(axis=1) & ~rests)
    level = _mean_down(T_soles[falls], used[falls])[0]
    soles, under = lowest(falls, level)
    down[falls], used[falls] = np.where(under[:, None], level, -_UPRIGHT), soles & under[:, None]
    return down, used, rests


def level_axes(up: Floats) -> Floats:
    """Return two horizontal directions for directions up (..., 3), counter-clockwise seen from above, (..., 2, 3).

    Source: Duff et al., Building an orthonormal basis, revisited, 2017.
    """
    x, y, z = np.moveaxis(up, -1, 0)
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    return np.stack([first, np.stack([b, sign + y * y * a, -y], axis=-1)], axis=-2)
