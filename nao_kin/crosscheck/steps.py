"""A robot as steps from frame to frame, and its forward kinematics from elementary rotations alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from nao_kin._core.arrays import Floats, Vector
from nao_kin.crosscheck.report import Conversions, Function
from nao_kin.errors import UnknownName
from nao_kin.robot import RobotModel
from nao_kin.robot.nao import CAMERAS, OPTICAL_RPY, NaoParameters
from nao_kin.robot.semantics import Mimic
from nao_kin.robot.urdf import UrdfTree

Turns = tuple[tuple[str, float], ...]

_ORIGIN: Vector = (0.0, 0.0, 0.0)
# Names of bodies in NAOqi that the ROS description lacks → the frame with the same pose.
_BODIES = {"Torso": "torso", "LFoot": "LAnkleRoll", "RFoot": "RAnkleRoll"}


@dataclass(frozen=True)
class Step:
    """A frame, its pose in its parent frame, and its motion there.

    T_parent_frame = translation(xyz) · turns, in the order written · motion of the joint, if there is one.

    Attributes:
        name: the frame.
        parent: its parent frame; None for the root.
        xyz: position of its origin in the parent [m].
        turns: elementary turns about moving axes, ("z", yaw), ("y", pitch), ("x", roll) for a URDF's rpy [rad].
        axis: unit vector along the joint's axis; None if the frame is fixed in its parent.
        sliding: whether the joint is prismatic.
        mimic: the coordinate that moves the joint, its own or another joint's, and how; None without a joint.
    """

    name: str
    parent: str | None
    xyz: Vector = _ORIGIN
    turns: Turns = ()
    axis: Vector | None = None
    sliding: bool = False
    mimic: Mimic | None = None


def steps_of(robot: RobotModel) -> tuple[Step, ...]:
    """Return the steps of a robot: from the parameters for a NAO, from the URDF for another or a calibrated robot.

    Examples:
        >>> [step.name for step in steps_of(nk.load_nao()) if step.axis][:2]
        ['HeadYaw', 'HeadPitch']
    """
    nominal = robot.parameters is not None and not robot.tree.offsets
    return steps_of_nao(robot.parameters) if nominal else steps_of_tree(robot.tree)


def steps_of_nao(parameters: NaoParameters) -> tuple[Step, ...]:
    """Return the steps of a NAO from its parameters alone, under all names that its model has for them.

    A step is a frame with its `name`, its `parent` frame or None, and its pose there: position `xyz` [m], elementary
    `turns` about moving axes [rad], and the `axis` of its joint or None, whether it is `sliding`, and the `mimic` of
    the coordinate that moves it.

    Examples:
        >>> steps = nk.crosscheck.steps_of_nao(nk.parameters.nao_parameters("v6"))
        >>> sum(step.axis is not None for step in steps)
        42
    """
    steps = [Step("base_link", None), Step("torso", "base_link")]
    for joint in parameters.joints:
        steps.append(Step(joint.name, joint.parent, joint.xyz, axis=joint.axis, mimic=Mimic(joint.mimic or joint.name)))
        steps.append(Step(joint.link, joint.name))
        for finger in parameters.fingers if joint.unit == "1" else ():
            if finger.driver == joint.name:
                turns = _turns(finger.rpy)
                mimic = Mimic(finger.driver, finger.multiplier)
                steps.append(Step(finger.name, finger.parent, finger.xyz, turns, finger.axis, mimic=mimic))
                steps.append(Step(finger.link, finger.name))
    steps += [Step(name, carrier) for name, carrier in _BODIES.items()]
    for frame in parameters.frames:
        steps.append(Step(frame.name, frame.parent, frame.xyz, _turns(frame.rpy)))
        if frame.ros_name is not None:
            steps.append(Step(frame.ros_name, frame.name))
        if frame.name in CAMERAS:
            steps.append(Step(f"{frame.name}_optical_frame", frame.name, turns=_turns(OPTICAL_RPY)))
    return tuple(steps)


def steps_of_tree(tree: UrdfTree) -> tuple[Step, ...]:
    """Return the steps of a URDF; every moving joint is a frame too, and a shared name means the link."""
    steps = [Step(tree.root, None)]
    for joint in tree.joints:
        fixed = Step(joint.child, joint.parent, joint.origin.xyz, _turns(joint.origin.rpy))
        if joint.kind == "fixed":
            steps.append(fixed)
            continue
        mimic = joint.mimic or Mimic(joint.name)
        moved = replace(fixed, axis=joint.axis, sliding=joint.kind == "prismatic", mimic=mimic)
        if joint.name in tree.shared_names:
            steps.append(moved)
        else:
            steps += [replace(moved, name=joint.name), Step(joint.child, joint.name)]
    steps += [Step(name, link) for name, link in tree.shared_names.items()]
    return tuple(steps)


class StepKinematics:
    """Poses of all frames of a robot from its steps; UnknownName for a step whose parent is not an earlier step."""

    def __init__(self, steps: Sequence[Step], joint_names: Sequence[str], conversions: Conversions) -> None:
        self.steps = tuple(steps)
        self._column = {name: index for index, name in enumerate(joint_names)}
        self._rot: dict[str, Function] = {"x": conversions.rot_x, "y": conversions.rot_y, "z": conversions.rot_z}
        self.parents: list[int | None] = []
        known: dict[str, int] = {}
        for index, step in enumerate(self.steps):
            if step.parent is not None and step.parent not in known:
                raise UnknownName("frame", step.parent, tuple(known))
            self.parents.append(None if step.parent is None else known[step.parent])
            known[step.name] = index

    def value(self, step: Step, q: Floats) -> Floats:
        """Return joint values of one step, shape (n,); a joint without a coordinate stays at its offset."""
        mimic = step.mimic or Mimic("", 0.0)
        column = self._column.get(mimic.joint)
        coordinate = np.zeros(len(q)) if column is None else q[:, column]
        return np.asarray(mimic.multiplier * coordinate + mimic.offset)

    def poses(self, q: Floats) -> Floats:
        """Return T_root_frame of every step, shape (n, steps, 4, 4), for configurations (n, nq)."""
        T = np.zeros((len(q), len(self.steps), 4, 4))
        T[..., 3, 3] = 1.0
        R, p = T[..., :3, :3], T[..., :3, 3]
        for index, (step, parent) in enumerate(zip(self.steps, self.parents, strict=True)):
            if parent is None:
                R[:, index], p[:, index] = self.rotation(step, q), self.position(step, q)
            else:
                R[:, index] = R[:, parent] @ self.rotation(step, q) if turns(step) else R[:, parent]
                p[:, index] = p[:, parent] + (R[:, parent] @ self.position(step, q)[..., None])[..., 0]
        return T

    def rotation(self, step: Step, q: Floats) -> Floats:
        """Return R_parent_frame, shape (3, 3), or (n, 3, 3) if it depends on q."""
        R = self._fixed_rotation(step)
        if step.axis is None or step.sliding:
            return R
        return np.asarray(R @ self._turn_about(step.axis, self.value(step, q)))

    def position(self, step: Step, q: Floats) -> Floats:
        """Return the origin of the frame in its parent, shape (3,), or (n, 3) if a joint moves it [m]."""
        p = np.array(step.xyz)
        if step.axis is None or not step.sliding:
            return p
        value = self.value(step, q)
        return np.asarray(p + value[:, None] * (self._fixed_rotation(step) @ step.axis)) if value.any() else p

    def _fixed_rotation(self, step: Step) -> Floats:
        """Return the product of the turns before the motion of the joint."""
        R = np.eye(3)
        for axis, angle in step.turns:
            R = R @ self._rot[axis](angle)
        return R

    def _turn_about(self, axis: Vector, angle: Floats) -> Floats:
        """Return the turn about any axis e = Rz(a) Ry(b) z: Rz(a) Ry(b) Rz(angle) Ry(−b) Rz(−a)."""
        x, y, z = axis
        for name, component in zip("xyz", axis, strict=True):
            if abs(component) == math.hypot(x, y, z):
                return np.asarray(self._rot[name](math.copysign(1.0, component) * angle))
        a, b = math.atan2(y, x), math.atan2(math.hypot(x, y), z)
        rot_y, rot_z = self._rot["y"], self._rot["z"]
        return np.asarray(rot_z(a) @ rot_y(b) @ rot_z(angle) @ rot_y(-b) @ rot_z(-a))


def turns(step: Step) -> bool:
    """Return whether a frame is rotated, or can rotate, in its parent frame."""
    return bool(step.turns) or (step.axis is not None and not step.sliding)


def _turns(rpy: Vector) -> Turns:
    """Return the turns of R = Rz(yaw) Ry(pitch) Rx(roll); none for no rotation."""
    roll, pitch, yaw = rpy
    return (("z", yaw), ("y", pitch), ("x", roll)) if any(rpy) else ()
