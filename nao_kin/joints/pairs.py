"""Joint types of mechanism theory, their freedoms and Pinocchio joints, and the Grübler–Kutzbach count."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, as_floats, as_numbers, choice, unit, whole_number
from nao_kin._core.text import html_table, quoted
from nao_kin.errors import BadArgument, UnknownName, WrongShape
from nao_kin.robot.semantics import Mimic
from nao_kin.screws.lines import PluckerLine

# Directions with a smaller angle between them count as parallel [rad].
PARALLEL = 1e-6


@dataclass(frozen=True)
class KinematicPair:
    """A kind of joint between two rigid bodies.

    Attributes:
        name: its name, a key of `KINEMATIC_PAIRS`.
        symbol: its letter in mechanism theory.
        rotations: independent rotations that it allows.
        translations: independent translations that it allows. A helical joint turns and slides, but not independently:
            it counts as one rotation and no translation.
        axes: number of directions that define it: the axis, the two axes of a universal joint, the normal of a plane.
        pinocchio: the Pinocchio joint that moves this way.
        lower: True for Reuleaux's six lower pairs, whose bodies touch on a surface. A universal joint is two revolute
            joints with a cross between them, a condyloid touches on a line or point, and a free body touches nothing.
    """

    name: str
    symbol: str
    rotations: int
    translations: int
    axes: int
    pinocchio: str
    lower: bool

    @property
    def freedoms(self) -> int:
        """Degrees of freedom that it allows."""
        return self.rotations + self.translations

    @property
    def constraints(self) -> int:
        """Degrees of freedom that it forbids, 6 − freedoms."""
        return 6 - self.freedoms

    def joint_model(self, axes: ArrayLike = (), *, pitch: float | None = None) -> pin.JointModel:
        """Return a Pinocchio joint of this kind; its nv is `freedoms`.

        A planar joint is Pinocchio's, q = (x, y, cos, sin), when its normal is z; for any other normal it is composed,
        q = (u, v, angle) with u and v along two directions of the plane.

        Args:
            axes: the directions that define it, in the joint frame, of any nonzero length: shape (3,) for one, (n, 3)
                for several. A universal joint turns about the first, then about the second as moved by the first turn.
            pitch: advance of a helical joint per radian [m/rad].

        Raises:
            BadArgument: two parallel axes; a pitch missing, or given to another joint.
            WrongShape: not as many directions as `axes` says.

        Examples:
            >>> nk.joints.kinematic_pair("spherical").joint_model().shortname()
            'JointModelSpherical'
        """
        directions = self._directions(axes)
        if (pitch is not None) != (self.name == "helical"):
            raise BadArgument(f"a {self.name} joint {'needs a' if self.name == 'helical' else 'has no'} pitch")
        make = _COMPOSED.get(self.name) or getattr(pin, self.pinocchio)
        advance = () if pitch is None else (float(as_floats(pitch, (), "pitch")),)
        return pin.JointModel(make(*directions, *advance))

    def _directions(self, axes: ArrayLike) -> Floats:
        what = f"axes of a {self.name} joint"
        directions = as_numbers(axes, what)
        if self.axes == 0 and directions.size == 0:
            return np.zeros((0, 3))
        if directions.shape != (self.axes, 3) and not (self.axes == 1 and directions.shape == (3,)):
            expected = "(0,)" if self.axes == 0 else "(3,)" if self.axes == 1 else f"({self.axes}, 3)"
            raise WrongShape(what, expected, directions.shape)
        units, _ = unit(as_floats(directions.reshape(self.axes, 3), (3,), what), what)
        if self.axes == 2 and np.linalg.norm(np.cross(*units)) < PARALLEL:
            raise BadArgument(f"the two axes of a {self.name} joint must not be parallel, got {directions.tolist()}")
        return units

    def __str__(self) -> str:
        return self.name


def _composite(*parts: pin.JointModel) -> pin.JointModelComposite:
    composite = pin.JointModelComposite()
    for part in parts:
        composite.addJoint(part)
    return composite


def _cylindrical(axis: Floats) -> pin.JointModel:
    return _composite(pin.JointModelPrismaticUnaligned(axis), pin.JointModelRevoluteUnaligned(axis))


def _planar(normal: Floats) -> pin.JointModel:
    if np.array_equal(normal, (0.0, 0.0, 1.0)):
        return pin.JointModelPlanar()
    u, _ = unit(np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))]), "a direction of the plane")
    slides = [pin.JointModelPrismaticUnaligned(direction) for direction in (u, np.cross(normal, u))]
    return _composite(*slides, pin.JointModelRevoluteUnaligned(normal))


# The kinds of joint that need a function, because they are not simply the Pinocchio joint named in the table.
_COMPOSED: dict[str, Callable[[Floats], pin.JointModel]] = {"cylindrical": _cylindrical, "planar": _planar}

_PAIRS = (
    KinematicPair("revolute", "R", 1, 0, 1, "JointModelRevoluteUnaligned", True),
    KinematicPair("prismatic", "P", 0, 1, 1, "JointModelPrismaticUnaligned", True),
    KinematicPair("helical", "H", 1, 0, 1, "JointModelHelicalUnaligned", True),
    KinematicPair("cylindrical", "C", 1, 1, 1, "JointModelComposite of a prismatic and a revolute", True),
    KinematicPair("universal", "U", 2, 0, 2, "JointModelUniversal", False),
    KinematicPair("condyloid", "U", 2, 0, 2, "JointModelUniversal", False),
    KinematicPair("spherical", "S", 3, 0, 0, "JointModelSpherical", True),
    KinematicPair("planar", "E", 1, 2, 1, "JointModelPlanar; with another normal, JointModelComposite", True),
    KinematicPair("free", "F", 3, 3, 0, "JointModelFreeFlyer", False),
)
KINEMATIC_PAIRS = MappingProxyType({pair.name: pair for pair in _PAIRS})
"""The pairs by name. Source: Reuleaux, The Kinematics of Machinery, 1876; Hartenberg and Denavit, Kinematic Synthesis
of Linkages, 1964, ch. 2."""


def kinematic_pair(name: str) -> KinematicPair:
    """Return the pair with this name.

    Examples:
        >>> nk.joints.kinematic_pair("universal").pinocchio
        'JointModelUniversal'
    """
    return KINEMATIC_PAIRS[choice(name, KINEMATIC_PAIRS, "pair")]


def mobility(
    pairs: Iterable[KinematicPair | str], *, links: int | None = None, couplings: int = 0, space: Literal[3, 6] = 6
) -> int:
    """Return the degrees of freedom of a mechanism, M = d (n − 1 − j) + Σ fᵢ − c.

    n links, the frame included, are connected by j joints with fᵢ freedoms in a space of d = 6 motions; every coupling
    (one motor for two joints, a gear, a tendon) removes one more. In a chain or tree n − 1 = j, and the count is the
    sum of the freedoms less the couplings, exact for all dimensions. In a mechanism with loops it is a lower bound:
    special dimensions can make constraints redundant (a planar four-bar linkage counted in space has −2; count it with
    space=3).

    Args:
        pairs: the joints, as pairs or their names.
        links: n; None for a chain or tree, where n = j + 1.
        couplings: c.
        space: d: 6, or 3 for a mechanism that moves in a plane.

    Raises:
        BadArgument: more links than the joints can connect; a joint with more freedoms than the space has.

    Source: Hartenberg and Denavit, Kinematic Synthesis of Linkages, 1964, ch. 5.

    Examples:
        >>> nk.joints.mobility(["revolute"] * 4, links=4, space=3)
        1
    """
    known = [pair if isinstance(pair, KinematicPair) else kinematic_pair(pair) for pair in pairs]
    if space not in (3, 6):
        raise BadArgument(f"space must be 3 or 6, got {quoted(space)}")
    freest = max((pair.freedoms for pair in known), default=0)
    if freest > space:
        raise BadArgument(f"a joint of {freest} freedoms does not fit a space of {space}")
    n = len(known) + 1 if links is None else whole_number(links, "links", 1)
    if n > len(known) + 1:
        raise BadArgument(f"{len(known)} joints cannot connect {n} links")
    c = whole_number(couplings, "couplings", 0)
    return space * (n - 1 - len(known)) + sum(pair.freedoms for pair in known) - c


# --- Joints of one, two or three axes in a robot.


@dataclass(frozen=True)
class Singularity:
    """The singularity of a joint of three axes, where its third axis is parallel to the first.

    Attributes:
        joint: the joint of the middle axis, on which it depends.
        at: its two singular values, in (−π, π] [rad].
        lower: smallest value its limits allow [rad].
        upper: largest value its limits allow [rad].
    """

    joint: str
    at: tuple[float, float]
    lower: float
    upper: float

    @property
    def margin(self) -> float:
        """Distance between the limits and the nearest singular value; negative when they allow one [rad]."""
        return min(self._outside(value) for value in self.at)

    @property
    def reachable(self) -> bool:
        """Whether the limits allow a singular value."""
        return self.margin <= 0.0

    def _outside(self, value: float) -> float:
        first, last = -1, 1
        if math.isfinite(self.upper - self.lower):
            first = math.floor((self.lower - value) / (2.0 * math.pi))
            last = math.ceil((self.upper - value) / (2.0 * math.pi))
        turns = [value + 2.0 * math.pi * k for k in range(first, last + 1)]
        return min(max(self.lower - angle, angle - self.upper) for angle in turns)


@dataclass(frozen=True, eq=False)
class MultiDofJoint:
    """One joint of the robot, made of one to three joints of its URDF.

    Attributes:
        name: the names of its parts, joined by "+".
        pair: its kind.
        joints: its parts, from the root outwards.
        parent: name of the joint that carries it, "" for the root.
        centre: the common point of its axes, or the joint centre of a single axis, in the root's frame with all joints
            at zero, shape (3,) [m].
        axes: unit vectors of its axes in the root's frame with all joints at zero, shape (n, 3); none for a free base.
        angles_between: angles between consecutive axes, shape (n − 1,) [rad].
        residual: largest distance of an axis from the centre [m].
        lower: smallest value of each part, shape (n,) [rad or m].
        upper: largest value of each part, shape (n,) [rad or m].
        units: unit of each part's value.
        singularity: of a joint of three axes: `joint` of the middle axis, its singular values `at` [rad], and the
            smallest and largest value, `lower` and `upper`, that its limits allow [rad].
    """

    name: str
    pair: KinematicPair
    joints: tuple[str, ...]
    parent: str
    centre: Floats
    axes: Floats
    angles_between: Floats
    residual: float
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    units: tuple[str, ...]
    singularity: Singularity | None = None

    @property
    def lines(self) -> PluckerLine:
        """The axes as lines of the root's frame with all joints at zero, batch shape (n,)."""
        return PluckerLine.from_point_direction(self.centre, self.axes)

    def __repr__(self) -> str:
        x, y, z = (f"{value + 0.0:.4g}" for value in self.centre)
        return f"<{type(self).__name__} {self.name}: {self.pair.name} at ({x}, {y}, {z}) m>"


@dataclass(frozen=True, eq=False)
class JointGroups:
    """All joints of a robot, and the couplings between them; iterating yields the joints, `len` counts them.

    Attributes:
        joints: the joints, parents first. Each has a `name`, its `pair`, the `joints` of the URDF that are its parts,
            its `parent` joint ("" for the root), the common point `centre` of its axes [m], the unit vectors `axes`,
            the `angles_between` them [rad], the axes as `lines`, and the largest distance of an axis from the centre,
            `residual` [m], all in the root's frame with all joints at zero; `lower`, `upper` and `units` of its parts;
            and, with three axes, a `singularity`, else None: the middle `joint`, its two singular values `at` [rad],
            the `margin` between its limits and the nearest of them [rad], and whether one is `reachable`.
        mimics: joints that follow another one, and how; each removes a freedom.
        driven: joints of the URDF that follow another one and carry none with its own coordinate, such as fingers that
            follow the hand: each adds a freedom and removes it again, so they are not among `joints`.
        rule: the rule that merged them.
        tolerance: largest distance of centres or axes from their common point [m].
    """

    joints: tuple[MultiDofJoint, ...]
    mimics: Mapping[str, Mimic]
    driven: tuple[str, ...]
    rule: str
    tolerance: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "mimics", MappingProxyType(dict(self.mimics)))

    def __iter__(self) -> Iterator[MultiDofJoint]:
        return iter(self.joints)

    def __len__(self) -> int:
        return len(self.joints)

    def __getitem__(self, name: str) -> MultiDofJoint:
        """Return the joint with this name, or the joint of which this joint of the URDF is a part."""
        for joint in self.joints:
            if name in (joint.name, *joint.joints):
                return joint
        raise UnknownName("joint", name, [part for joint in self.joints for part in joint.joints])

    @property
    def mobility(self) -> int:
        """Degrees of freedom of the robot by the Grübler–Kutzbach count, couplings included."""
        return mobility([joint.pair for joint in self.joints], couplings=len(self.mimics))

    @property
    def summary(self) -> str:
        """The count in one line, such as "25 DOF = 2×3 + 7×2 + 6×1 − 1": joints × freedoms each, less the couplings."""
        counts = Counter(joint.pair.freedoms for joint in self.joints)
        terms = " + ".join(f"{count}×{freedoms}" for freedoms, count in sorted(counts.items(), reverse=True)) or "0"
        return f"{self.mobility} DOF = {terms}" + (f" − {len(self.mimics)}" if self.mimics else "")

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.rule}: {len(self)} joints, {self.summary}>"

    def _repr_html_(self) -> str:
        rows = [
            (joint.name, joint.pair.name, joint.parent or "–", " ".join(f"{value + 0.0:.4g}" for value in joint.centre))
            for joint in self
        ]
        return html_table(f"{self.summary} ({self.rule})", ("joint", "pair", "carried by", "centre [m]"), rows)
