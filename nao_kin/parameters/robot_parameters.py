"""The numbers of one NAO version in SI units, every distance and name resolved."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from nao_kin.errors import UnknownName
from nao_kin.parameters.rows import InertialRow, ShapeRow, Vector, Version, VisualRow
from nao_kin.semantics import CoupledLimit, Mimic


@dataclass(frozen=True)
class Joint:
    """One joint of one version.

    Attributes:
        name: NAOqi's name.
        chain: NAOqi's chain.
        parent: the joint that carries it, or "torso".
        link: the link it moves.
        xyz: position in the parent's joint frame [m]; all joint frames are parallel to the torso at zero.
        axis: unit vector of the axis.
        lower: smallest value [rad; 1 for a hand].
        upper: largest value [rad; 1 for a hand].
        unit: "rad", or "1" for the opening of a hand.
        velocity: largest speed [rad/s; 1/s for a hand].
        effort: largest torque [N m].
        mimic: the joint whose motor drives this one too, at the same value; None for a motor of its own.
    """

    name: str
    chain: str
    parent: str
    link: str
    xyz: Vector
    axis: Vector
    lower: float
    upper: float
    unit: str
    velocity: float
    effort: float
    mimic: str | None


@dataclass(frozen=True)
class Finger:
    """The joint of one phalanx, which follows the opening of its hand: angle = multiplier · opening.

    The joints are named after the hand, so that they sort after it: a parser that takes siblings in alphabetical order
    then meets the driving joint first, as Pinocchio needs.

    Attributes:
        name: the joint, "LHandFinger11".
        phalanx: the phalanx without its side, "Finger11".
        parent: the joint that carries it: the wrist or the phalanx before.
        parent_link: the link that carries it.
        link: the link it moves, "LFinger11_link".
        driver: the joint of the hand, "LHand".
        multiplier: angle at opening 1 [rad].
        xyz: position in the parent's frame [m].
        rpy: orientation in the parent's frame at opening 0, R = Rz(yaw) Ry(pitch) Rx(roll) [rad].
        axis: unit vector of the axis, in the joint's own frame.
        lower: smallest angle [rad].
        upper: largest angle [rad].
        velocity: largest speed [rad/s].
        effort: largest torque [N m].
    """

    name: str
    phalanx: str
    parent: str
    parent_link: str
    link: str
    driver: str
    multiplier: float
    xyz: Vector
    rpy: Vector
    axis: Vector
    lower: float
    upper: float
    velocity: float
    effort: float


@dataclass(frozen=True)
class Frame:
    """One sensor or effector frame of one version.

    Attributes:
        name: NAOqi's name.
        ros_name: the official ROS link at the same place, if there is one.
        parent: the joint that carries it, or "torso".
        xyz: position in the parent's joint frame [m].
        rpy: orientation, R = Rz(yaw) Ry(pitch) Rx(roll) [rad].
    """

    name: str
    ros_name: str | None
    parent: str
    xyz: Vector
    rpy: Vector


@dataclass(frozen=True, repr=False)
class NaoParameters:
    """The numbers of one NAO version, SI units.

    Attributes:
        version: "v3.2" … "v6".
        offsets: Aldebaran's named distances [m].
        joints: the 26 joints in NAOqi's Body order.
        fingers: the 16 phalanges, left hand first, each after the one that carries it.
        inertials: mass, centre of mass and inertia by the joint that moves the link, and "torso".
        placeholder: what links without a mass of their own are given; None for nothing.
        frames: sensor and effector frames.
        coupled_limits: the anti-collision tables.
        visuals: the meshes of the links, by the joint that moves the link, "torso", or a phalanx without its side.
        collision_shapes: NAOqi's collision primitives.
    """

    version: Version
    offsets: Mapping[str, float]
    joints: tuple[Joint, ...]
    fingers: tuple[Finger, ...]
    inertials: Mapping[str, InertialRow]
    placeholder: InertialRow | None
    frames: tuple[Frame, ...]
    coupled_limits: tuple[CoupledLimit, ...]
    visuals: tuple[VisualRow, ...]
    collision_shapes: tuple[ShapeRow, ...]

    def __repr__(self) -> str:
        return (
            f"<NaoParameters {self.version}: {len(self.joints)} joints, {len(self.fingers)} phalanges, "
            f"{len(self.frames)} frames, {self.mass:.3f} kg>"
        )

    @property
    def mass(self) -> float:
        """Mass of all bodies [kg]; the placeholders of massless links, 0.05 g in all, not counted."""
        return math.fsum(row.mass_kg for row in self.inertials.values())

    @property
    def mimics(self) -> Mapping[str, Mimic]:
        """The joints without a motor of their own, and what they follow: `RHipYawPitch` and the phalanges."""
        joints = {joint.name: Mimic(joint.mimic) for joint in self.joints if joint.mimic is not None}
        return MappingProxyType(joints | {row.name: Mimic(row.driver, row.multiplier) for row in self.fingers})

    def joint(self, name: str) -> Joint:
        """The joint of that name.

        Raises:
            UnknownName: no such joint.
        """
        for joint in self.joints:
            if joint.name == name:
                return joint
        raise UnknownName("joint", name, [joint.name for joint in self.joints])

    def frame(self, name: str) -> Frame:
        """The sensor or effector frame of that name, NAOqi's.

        Raises:
            UnknownName: no such frame.
        """
        for frame in self.frames:
            if frame.name == name:
                return frame
        raise UnknownName("frame", name, [frame.name for frame in self.frames])
