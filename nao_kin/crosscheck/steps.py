"""A robot as rows of steps from frame to frame: what the hand-rolled forward kinematics walks along."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from nao_kin.nao import NaoModel
from nao_kin.parameters import CAMERAS, FINGER_RATIO, FINGERS, OPTICAL_RPY, NaoParameters, nao_parameters
from nao_kin.robot import RobotModel
from nao_kin.semantics import Mimic
from nao_kin.urdf import UrdfTree

Vector = tuple[float, float, float]
Turns = tuple[tuple[str, float], ...]

_HERE: Vector = (0.0, 0.0, 0.0)
# Bodies that NAOqi names and the ROS description does not, by the joint that moves them.
_BODIES = {"Torso": "torso", "LFoot": "LAnkleRoll", "RFoot": "RAnkleRoll"}


@dataclass(frozen=True)
class Step:
    """A frame, where it stands in the frame that carries it, and how it moves there.

    T_parent_frame = translation(xyz) · turns, in the order written · motion of the joint, if there is one.

    Attributes:
        name: the frame.
        parent: the frame that carries it; None for the root.
        xyz: position of its origin in the parent [m].
        turns: elementary turns about moving axes, ("z", yaw), ("y", pitch), ("x", roll) for a URDF's rpy [rad].
        axis: unit vector along the joint's axis; None where the frame is fixed in its parent.
        sliding: whether the joint is prismatic.
        driver: the joint whose coordinate moves this one: value = ratio · coordinate + offset.
        ratio: see `driver`.
        offset: see `driver`.
    """

    name: str
    parent: str | None
    xyz: Vector = _HERE
    turns: Turns = ()
    axis: Vector | None = None
    sliding: bool = False
    driver: str = ""
    ratio: float = 1.0
    offset: float = 0.0


def steps_of(robot: RobotModel) -> tuple[Step, ...]:
    """The steps of a robot: a NAO's from the rows of its parameters, any other's from its URDF.

    Raises:
        BadModel: the robot's URDF can no longer be read.
    """
    if isinstance(robot, NaoModel):
        return steps_of_nao(nao_parameters(robot.version))
    return steps_of_tree(robot.tree)


def steps_of_nao(parameters: NaoParameters) -> tuple[Step, ...]:
    """The steps of a NAO, made of its parameters alone, under all names that its model has for them."""
    steps = [Step("base_link", None), Step("torso", "base_link")]
    for joint in parameters.joints:
        steps.append(Step(joint.name, joint.parent, joint.xyz, axis=joint.axis, driver=joint.mimic or joint.name))
        steps.append(Step(joint.link, joint.name))
        if joint.unit == "1":
            steps += _fingers(joint.name, joint.parent)
    steps += [Step(name, carrier) for name, carrier in _BODIES.items()]
    for frame in parameters.frames:
        steps.append(Step(frame.name, frame.parent, frame.xyz, _turns(frame.rpy)))
        if frame.ros_name is not None:
            steps.append(Step(frame.ros_name, frame.name))
        if frame.name in CAMERAS:
            steps.append(Step(f"{frame.name}_optical_frame", frame.name, turns=_turns(OPTICAL_RPY)))
    return tuple(steps)


def steps_of_tree(tree: UrdfTree) -> tuple[Step, ...]:
    """The steps of a URDF, made of the numbers it prints; every moving joint is a frame beside the link it moves."""
    steps = [Step(tree.root, None)]
    for joint in tree.joints:
        held = Step(joint.child, joint.parent, joint.origin.xyz, _turns(joint.origin.rpy))
        if joint.kind == "fixed":
            steps.append(held)
            continue
        tie = joint.mimic or Mimic(joint.name)
        moved = replace(held, name=joint.name, axis=joint.axis, sliding=joint.kind == "prismatic")
        steps.append(replace(moved, driver=tie.joint, ratio=tie.multiplier, offset=tie.offset))
        steps.append(Step(joint.child, joint.name))
    return tuple(steps)


def _fingers(hand: str, wrist: str) -> Iterable[Step]:
    side = hand[0]
    for finger in FINGERS:
        joint, link = f"{hand}{finger.name}", f"{side}{finger.name}_link"
        parent = wrist if finger.parent == "WristYaw" else f"{hand}{finger.parent}"
        yield Step(joint, parent, finger.xyz_m, _turns(finger.rpy), (0.0, 0.0, 1.0), driver=hand, ratio=FINGER_RATIO)
        yield Step(link, joint)


def _turns(rpy: Vector) -> Turns:
    """The turns of R = Rz(yaw) Ry(pitch) Rx(roll); none for no rotation."""
    roll, pitch, yaw = rpy
    return (("z", yaw), ("y", pitch), ("x", roll)) if any(rpy) else ()
