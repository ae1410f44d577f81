"""Self-collision: which overlaps count, and the answers of `RobotModel.clearance` and `collisions`.

Distances are negative where shapes overlap: the least translation that separates them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, check_tolerance, finite_or_none, flag, join_poses, positive
from nao_kin._core.text import one_line_repr, quoted
from nao_kin.errors import BadArgument, BadInputFile, WrongShape
from nao_kin.robot.collision_pairs import LinkPair
from nao_kin.robot.geometry import check_points, read_mesh, shape_geometry
from nao_kin.robot.urdf import Box, MeshFile, Packages, Sphere, UnreadableShape
from nao_kin.screws import rigid_poses


@one_line_repr
@dataclass(frozen=True, eq=False)
class Obstacle:
    """A box, a ball or a mesh near the robot, as made by `box`, `ball` and `mesh`.

    `at` is the position (3,) of its origin or its pose (4, 4) [m]: in the frame of the root with a fixed base, in the
    world with a floating one. For a table on the floor, transform its pose from a foot: `nao.fk(q, "LFoot") @ T`.

    Attributes:
        name: for answers, and for `allowed`; no name of a link.
        geometry: a box of a `size` (3,), a ball of a `radius`, or a mesh: a `filename`, and the `scale` along its axes
            to metres [m].
        T: the pose, shape (4, 4) [m].

    Examples:
        >>> nao = nk.load_nao()
        >>> table = nk.robot.Obstacle.box("table", [0.3, 0.6, 0.02], [0.2, 0.0, -0.05])
        >>> nao.clearance(nao.posture("StandZero"), obstacles=[table]).is_free
        True
        >>> q = nao.posture("StandZero", LShoulderPitch=0.6)
        >>> [contact.describe() for contact in nao.collisions(q, obstacles=[table])]
        ['l_wrist and table overlap by 19.1 mm']
    """

    name: str
    geometry: Box | Sphere | MeshFile
    T: Floats = field(repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "T", _pose(self.T))
        try:
            check_points(self.T[None, :3, 3])
            if isinstance(self.geometry, MeshFile):
                read_mesh(Path(self.geometry.filename), lambda _: None)
            shape_geometry(self.geometry, Packages(Path()))
        except UnreadableShape as reason:
            if isinstance(self.geometry, MeshFile):
                raise BadInputFile(self.geometry.filename, str(reason)) from None
            raise BadArgument(f"obstacle {quoted(self.name)}: {reason}") from None

    @staticmethod
    def box(name: str, size: ArrayLike, at: ArrayLike) -> Obstacle:
        """Return a box with edges along x, y, z of these lengths, shape (3,) [m], about its origin."""
        x, y, z = positive(size, f"size of {quoted(name)}", (3,)).tolist()
        return Obstacle(name, Box((x, y, z)), _pose(at))

    @staticmethod
    def ball(name: str, radius: float, at: ArrayLike) -> Obstacle:
        """Return a ball about its origin, of a radius [m]."""
        return Obstacle(name, Sphere(float(positive(radius, f"radius of {quoted(name)}"))), _pose(at))

    @staticmethod
    def mesh(name: str, path: str | Path, at: ArrayLike, *, scale: float = 1.0) -> Obstacle:
        """Return the convex hull of the mesh in a file, or with `exact=True` the mesh itself.

        `scale` is the unit of the file [m]; the units of COLLADA and 3MF are in the file, and are scaled by it.

        Raises:
            BadInputFile: the file is missing, or holds no mesh.
        """
        factor = float(positive(scale, f"scale of {quoted(name)}"))
        return Obstacle(name, MeshFile(str(Path(path).resolve()), (factor, factor, factor)), _pose(at))


def _pose(at: ArrayLike) -> Floats:
    array = as_floats(at, (), "at")
    if array.shape == (3,):
        return join_poses(np.eye(3), array)
    if array.shape != (4, 4):
        raise WrongShape("at", "(3,) or (4, 4)", array.shape)
    return rigid_poses(array, "at")


@one_line_repr
@dataclass(frozen=True)
class CollisionRule:
    """Which overlaps of links count as collisions, for functions with an argument `collisions`.

    Attributes:
        tolerance: overlap that is accepted, of every pair of links [m].
        allowed: pairs of links that may overlap.
        exact: whether the meshes decide, fingers at the opening of the hand, where hulls overlap: None for where they
            overlap by less than 3 mm, True for everywhere, False for nowhere.
        obstacles: what stands near the robot; its names serve in pairs as those of links do.

    Raises:
        BadArgument: a negative tolerance, or pairs that are no pairs of names.

    Examples:
        >>> nao = nk.load_nao()
        >>> rule = nk.robot.CollisionRule(tolerance=0.002, allowed=[("l_ankle", "r_ankle")])
        >>> rule.allowed
        (('l_ankle', 'r_ankle'),)
    """

    tolerance: float = 0.0
    allowed: Sequence[LinkPair] = ()
    exact: bool | None = None
    obstacles: Sequence[Obstacle] = ()

    def __post_init__(self) -> None:
        check_tolerance(self.tolerance)
        if self.exact is not None:
            flag(self.exact, "exact")
        for pair in self.allowed:
            if isinstance(pair, str) or len(pair) != 2:
                raise BadArgument(f"allowed must be pairs of names of links, got {quoted(pair)}")
        object.__setattr__(self, "allowed", tuple((min(a, b), max(a, b)) for a, b in self.allowed))
        object.__setattr__(self, "tolerance", float(self.tolerance))
        object.__setattr__(self, "obstacles", tuple(self.obstacles))

    @staticmethod
    def of(collisions: object, name: str = "collisions") -> CollisionRule | None:
        """Return the rule of an argument `collisions`, which may also be True for the default, or False for None."""
        if isinstance(collisions, CollisionRule):
            return collisions
        return CollisionRule() if flag(collisions, name) else None


@one_line_repr
@dataclass(frozen=True)
class Contact:
    """Two links that are nearer to each other than a margin.

    Attributes:
        links: their names.
        distance: distance of their shapes, negative if they overlap [m].
        points: the nearest point of each, or the deepest one if they overlap, in the root's frame, shape (2, 3) [m].
        index: index of the configuration in the batch.
    """

    links: LinkPair
    distance: float
    points: Floats
    index: tuple[int, ...] = ()

    def describe(self) -> str:
        """Return links and distance in words.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"LShoulderRoll": -0.3, "LElbowRoll": -1.5, "RElbowRoll": 0.04, "LHand": 1.0})
            >>> nao.collisions(q)[0].describe()
            'RBicep and l_wrist overlap by 10.2 mm'
        """
        apart = "overlap by" if self.distance < 0.0 else "are apart by"
        where = f" (configuration {', '.join(map(str, self.index))})" if self.index else ""
        return f"{self.links[0]} and {self.links[1]} {apart} {abs(self.distance) * 1e3:.1f} mm{where}"

    def as_dict(self) -> dict[str, Any]:
        """Return the fields for JSON [m]."""
        return {"links": list(self.links), "distance": self.distance, "points": self.points.tolist()}


@one_line_repr
@dataclass(frozen=True, eq=False)
class Clearance:
    """The least distance between links of a robot, for configurations of a batch shape (...); () for one.

    Attributes:
        distance: negative if some links overlap; infinite without links to check; shape (...) [m].
        pair_index: which of `pairs` has it, −1 for none, shape (...).
        pairs: the pairs of links that are checked, also those of a link and an obstacle, and those that the rule
            allows to overlap.
        tolerance: overlap that is accepted [m].
        notes: which pairs are left out because they touch at the start, if the robot's semantics name none.
    """

    distance: Floats
    pair_index: NDArray[np.int64]
    pairs: tuple[LinkPair, ...] = field(repr=False)
    tolerance: float = 0.0
    notes: tuple[str, ...] = field(default=(), repr=False)

    @property
    def pair(self) -> LinkPair | NDArray[np.object_] | None:
        """The two nearest links, None without links to check; of a batch an array of these, shape (...)."""
        if self.pair_index.ndim == 0:
            return self.pairs[int(self.pair_index)] if self.pair_index >= 0 else None
        found = np.empty(self.pair_index.shape, dtype=object)
        for index, pair in np.ndenumerate(self.pair_index):
            found[index] = self.pairs[pair] if pair >= 0 else None
        return found

    @property
    def is_free(self) -> bool | NDArray[np.bool_]:
        """Whether no links overlap by more than the tolerance: a bool, or of a batch an array of shape (...)."""
        free = self.distance >= -self.tolerance
        return bool(free) if free.ndim == 0 else free

    def as_dict(self) -> dict[str, Any]:
        """Return the clearance of one configuration for JSON [m]; None without links to check."""
        pair = self.pairs[int(self.pair_index)] if self.pair_index >= 0 else None
        return {"distance": finite_or_none(float(self.distance)), "pair": pair and list(pair)}
