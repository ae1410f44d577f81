"""A joint of one, two or three axes, as found in a robot, and the robot's joints taken together."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from nao_kin._common.arrays import Floats
from nao_kin._text import html_table
from nao_kin.errors import UnknownName
from nao_kin.joints.kinematic_pairs import KinematicPair, mobility
from nao_kin.lines import PluckerLine
from nao_kin.semantics import Mimic


@dataclass(frozen=True)
class Singularity:
    """Where a joint of three axes loses one: its third axis is carried parallel to the first.

    Attributes:
        joint: the joint of the middle axis, which decides.
        at: its two singular values, in (−π, π] [rad].
        lower: smallest value its limits allow [rad].
        upper: largest value its limits allow [rad].

    Examples:
        >>> groups = nk.joints.group_joints(nk.load_nao())
        >>> [(joint.singularity.joint, joint.singularity.reachable) for joint in groups if joint.singularity]
        [('LHipRoll', False), ('RHipRoll', False)]
    """

    joint: str
    at: tuple[float, float]
    lower: float
    upper: float

    @property
    def margin(self) -> float:
        """How far the limits keep the joint from the nearest singular value; negative when they allow one [rad]."""
        return min(self._outside(value) for value in self.at)

    @property
    def reachable(self) -> bool:
        """Whether the limits allow a singular value."""
        return self.margin <= 0.0

    def _outside(self, value: float) -> float:
        if math.isinf(self.lower) or math.isinf(self.upper):
            first, last = -1, 1
        else:
            first = math.floor((self.lower - value) / (2.0 * math.pi))
            last = math.ceil((self.upper - value) / (2.0 * math.pi))
        turns = [value + 2.0 * math.pi * k for k in range(first, last + 1)]
        return min(max(self.lower - angle, angle - self.upper) for angle in turns)


@dataclass(frozen=True)
class Coupling:
    """One motor for two joints: value of `joint` = multiplier · value of `driver` + offset.

    Attributes:
        joint: the joint that follows.
        mimic: how it follows.

    Examples:
        >>> groups = nk.joints.group_joints(nk.load_nao())
        >>> [(coupling.joint, coupling.mimic.joint) for coupling in groups.couplings][-1]
        ('RHipYawPitch', 'LHipYawPitch')
    """

    joint: str
    mimic: Mimic

    @property
    def driver(self) -> str:
        """The joint it follows."""
        return self.mimic.joint

    @property
    def multiplier(self) -> float:
        """Ratio of the two values."""
        return self.mimic.multiplier

    @property
    def offset(self) -> float:
        """Value when the driver is at zero."""
        return self.mimic.offset


@dataclass(frozen=True, eq=False)
class MultiDofJoint:
    """One joint of the robot, made of one to three joints of its URDF.

    Attributes:
        name: the names of its parts, joined by "+".
        pair: what kind of joint it is.
        joints: its parts, from the root outwards.
        parent: name of the joint that carries it, "" for the root.
        centre: the point common to its axes, or the joint centre of a single axis, in the root's frame with all joints
            at zero, shape (3,) [m].
        axes: unit vectors of its axes in the root's frame with all joints at zero, shape (n, 3); none for a free base.
        angles_between: angles between consecutive axes, shape (n − 1,) [rad].
        residual: largest distance of an axis from the centre [m].
        lower: smallest value of each part, shape (n,) [rad or m].
        upper: largest value of each part, shape (n,) [rad or m].
        units: unit of each part's value.
        singularity: for three axes, where they stop spanning space.

    Examples:
        >>> groups = nk.joints.group_joints(nk.load_nao())
        >>> [joint.name for joint in groups if joint.pair.name == "spherical"]
        ['LHipYawPitch+LHipRoll+LHipPitch', 'RHipYawPitch+RHipRoll+RHipPitch']
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
    """All joints of a robot, and the motors that several of them share.

    Iterating goes through the joints; `len` counts them.

    Attributes:
        joints: the joints, parents first.
        mimics: joints that follow another one, and how; each takes a freedom away.
        driven: joints of the URDF that follow another one and carry none with a coordinate of its own, such as fingers
            that follow the hand: each adds a freedom and takes it back, and none is a joint here.
        rule: the rule that merged them.
        tolerance: how far centres or axes may miss their common point [m].

    Examples:
        >>> groups = nk.joints.group_joints(nk.load_nao())
        >>> len(groups), groups.rule
        (15, 'coincident')
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
        """The joint of this name, or the one that this joint of the URDF is a part of.

        Raises:
            UnknownName: there is none.
        """
        for joint in self.joints:
            if name == joint.name or name in joint.joints:
                return joint
        raise UnknownName("joint", name, [part for joint in self.joints for part in joint.joints])

    @property
    def couplings(self) -> tuple[Coupling, ...]:
        """The motors that drive two joints, one row for each joint that follows."""
        return tuple(Coupling(joint, mimic) for joint, mimic in self.mimics.items())

    @property
    def mobility(self) -> int:
        """Degrees of freedom of the robot by the Grübler–Kutzbach count, couplings counted."""
        return mobility([joint.pair for joint in self.joints], couplings=len(self.mimics))

    @property
    def summary(self) -> str:
        """The count in one line, as "25 DOF = 2×3 + 7×2 + 6×1 − 1": joints × freedoms each, less the couplings."""
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
