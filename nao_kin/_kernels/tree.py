"""The joints of a robot as numbers, from which programs are built."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from nao_kin._core.arrays import Floats

ROOT = -1


@dataclass(frozen=True)
class TreeJoint:
    """One joint; its value is ratio · q[coordinate] + offset."""

    kind: str  # "revolute", "prismatic" or "free", for a floating base
    parent: int  # index of the parent joint; −1 for the root
    R: Floats = field(repr=False)  # orientation of its frame at zero in the parent's
    t: Floats = field(repr=False)  # position of its frame at zero in the parent's [m]
    axis: tuple[float, float, float]  # unit vector
    coordinate: int  # index in q, of the first of seven for a floating base
    velocity: int  # index in the velocity, of the first of six for a floating base
    ratio: float = 1.0  # 1 except for mimic joints
    offset: float = 0.0
    mass: float = 0.0  # of its body [kg]
    moment: tuple[float, float, float] = (0.0, 0.0, 0.0)  # mass · centre of mass of its body in its frame [kg m]

    @cached_property
    def principal(self) -> tuple[int, float]:
        """The coordinate axis nearest to the joint's axis, and the sign of the joint's axis along it."""
        k = int(np.argmax(np.abs(self.axis)))
        return k, (1.0 if self.axis[k] > 0.0 else -1.0)

    @cached_property
    def alignment(self) -> Floats:
        """The shortest rotation of the coordinate axis onto the joint's axis, or its opposite: R e = ±axis."""
        k, sign = self.principal
        e, axis = np.eye(3)[k], sign * np.asarray(self.axis)
        v = np.cross(e, axis)
        cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
        return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + e @ axis))

    @cached_property
    def is_straight(self) -> bool:
        """Whether its frame at zero has the axes of the parent's."""
        return bool((np.eye(3) == self.R).all())

    @property
    def aligned(self) -> bool:
        """Whether the joint's axis is a coordinate axis."""
        return not any(self.axis[k] for k in range(3) if k != self.principal[0])


@dataclass(frozen=True)
class JointTree:
    """All joints of a robot, every parent before its children."""

    nq: int
    nv: int
    joints: tuple[TreeJoint, ...] = field(repr=False)
    mass: float = 0.0  # of the root's body [kg]
    moment: tuple[float, float, float] = (0.0, 0.0, 0.0)  # mass · centre of mass of the root's body [kg m]

    @cached_property
    def total_mass(self) -> float:
        """Mass of the whole robot [kg]."""
        return self.mass + sum(joint.mass for joint in self.joints)

    @cached_property
    def children(self) -> dict[int, list[int]]:
        """The child joints of each joint and of the root."""
        children: dict[int, list[int]] = {k: [] for k in range(ROOT, len(self.joints))}
        for k, joint in enumerate(self.joints):
            children[joint.parent].append(k)
        return children

    @cached_property
    def carried_masses(self) -> tuple[float, ...]:
        """Mass that each joint moves [kg]."""
        masses = [joint.mass for joint in self.joints]
        for k in range(len(masses) - 1, -1, -1):
            if self.joints[k].parent != ROOT:
                masses[self.joints[k].parent] += masses[k]
        return tuple(masses)

    def chain(self, joint: int) -> list[int]:
        """Return the joints from the root to this one."""
        chain = []
        while joint != ROOT:
            chain.append(joint)
            joint = self.joints[joint].parent
        return chain[::-1]

    def common_joint(self, joints: Sequence[int]) -> int:
        """Return the last joint that is in the chains of all of these; −1 for the root."""
        common = ROOT
        for places in zip(*(self.chain(joint) for joint in joints), strict=False):
            if len(set(places)) > 1:
                break
            common = places[0]
        return common


@dataclass(frozen=True)
class TreeFrame:
    """A frame fixed to a joint: the joint, and the pose of the frame relative to it."""

    joint: int
    R: Floats = field(repr=False)
    t: Floats = field(repr=False)
