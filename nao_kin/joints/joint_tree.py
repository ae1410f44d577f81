"""The joint tree of a robot, every axis where it lies when all joints are at zero."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from nao_kin._common.arrays import Floats
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, BadModel
from nao_kin.robot import RobotModel
from nao_kin.semantics import Mimic


@dataclass(frozen=True, eq=False)
class JointNode:
    """One joint of the tree.

    Attributes:
        index: its place in the model's joints.
        name: its name.
        parent: index of the joint that carries it, 0 for the root.
        children: indices of the joints it carries.
        kind: "revolute", "prismatic", "free", or "fixed": a joint that follows another with the multiplier zero.
        axis: unit vector in the joint's frame; zero for "free" and "fixed".
        T_root: pose of the joint's frame in the root's, all joints at zero; what "fixed" has turned is in it.
        mimic: how it follows another joint; None for a joint of its own.
        lower: smallest value.
        upper: largest value.
        unit: unit of its value.
        moves: whether it or a joint it carries has a coordinate of its own. The joints that do not (fingers that follow
            the hand) add no freedom and carry none.

    Examples:
        >>> tree = nk.joints.read_joint_tree(nk.load_nao())
        >>> tree[1].name, tree[1].unit
        ('HeadYaw', 'rad')
    """

    index: int
    name: str
    parent: int
    children: tuple[int, ...]
    kind: str
    axis: Floats
    T_root: pin.SE3
    mimic: Mimic | None
    lower: float
    upper: float
    unit: str
    moves: bool

    @property
    def driver(self) -> str:
        """The joint whose coordinate moves it."""
        return self.name if self.mimic is None else self.mimic.joint

    @property
    def axis_root(self) -> Floats:
        """Its axis in the root's frame, all joints at zero."""
        return np.asarray(self.T_root.rotation @ self.axis)

    @property
    def centre_root(self) -> Floats:
        """Its centre, the origin of its frame, in the root's frame, all joints at zero [m]."""
        return np.array(self.T_root.translation)


def read_joint_tree(robot: RobotModel) -> dict[int, JointNode]:
    """Joint index → joint, in the order of the model.

    Raises:
        BadArgument: no robot model.
        BadModel: a joint that is neither revolute, prismatic nor the free base.

    Examples:
        >>> [node.name for node in nk.joints.read_joint_tree(nk.load_nao()).values()][:2]
        ['HeadYaw', 'HeadPitch']
    """
    model = getattr(robot, "model", None)
    if not isinstance(model, pin.Model):
        raise BadArgument(f"robot must be a RobotModel, got {type(robot).__name__}")
    children: dict[int, list[int]] = {index: [] for index in range(model.njoints)}
    moves = [False] * model.njoints
    for index in range(model.njoints - 1, 0, -1):
        moves[index] |= model.joints[index].nq > 0
        moves[model.parents[index]] |= moves[index]
        children[model.parents[index]].insert(0, index)
    ranges = {
        name: (float(lower), float(upper), unit)
        for name, lower, upper, unit in zip(robot.joint_names, robot.lower, robot.upper, robot.joint_units, strict=True)
    }
    poses = [pin.SE3.Identity()]
    nodes = {}
    for index in range(1, model.njoints):
        name = model.names[index]
        poses.append(poses[model.parents[index]] * model.jointPlacements[index])
        mimic = robot.mimics[name] if model.joints[index].nq == 0 else None
        kind, axis = _motion(model, index, mimic)
        if kind == "fixed":
            poses[-1] = poses[-1] * _motion_data(model, index).M
        if mimic is None:
            lower, upper, unit = ranges.get(name, (-np.inf, np.inf, ""))
        else:
            lower, upper = mimic.range(*ranges[mimic.joint][:2])
            unit = "m" if kind == "prismatic" else "rad"
        nodes[index] = JointNode(
            index=index,
            name=name,
            parent=int(model.parents[index]),
            children=tuple(children[index]),
            kind=kind,
            axis=axis,
            T_root=poses[index],
            mimic=mimic,
            lower=lower,
            upper=upper,
            unit=unit,
            moves=moves[index],
        )
    return nodes


def _motion(model: pin.Model, index: int, mimic: Mimic | None) -> tuple[str, Floats]:
    joint = model.joints[index]
    if joint.shortname() == "JointModelFreeFlyer":
        return "free", np.zeros(3)
    if joint.nq > 1:
        raise BadModel(f"joint {quoted(model.names[index])}: joints of {joint.nq} coordinates are not taken apart")
    if mimic is not None and mimic.multiplier == 0.0:
        return "fixed", np.zeros(3)
    screw = np.array(_motion_data(model, index).S, dtype=np.float64).reshape(6)
    if mimic is not None:
        # Pinocchio's mimic joint carries its multiplier in its motion subspace.
        screw /= mimic.multiplier
    turn = float(np.linalg.norm(screw[3:]))
    return ("revolute", screw[3:] / turn) if turn > 0.0 else ("prismatic", screw[:3] / np.linalg.norm(screw[:3]))


def _motion_data(model: pin.Model, index: int) -> pin.JointData:
    data = model.joints[index].createData()
    model.joints[index].calc(data, pin.neutral(model))
    return data
