"""What a Pinocchio model is built from, and building it: once on loading, and again on unpickling."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal
from xml.etree import ElementTree as ET

import pinocchio as pin

from nao_kin.errors import BadArgument, BadModel
from nao_kin.urdf_reader import UrdfJoint, UrdfTree

Base = Literal["fixed", "floating"]

# The arrays of a model that its owner may change after loading (a calibration, a tighter limit).
_NUMBERS = (
    "lowerPositionLimit",
    "upperPositionLimit",
    "lowerVelocityLimit",
    "upperVelocityLimit",
    "lowerEffortLimit",
    "upperEffortLimit",
)


@dataclass(frozen=True)
class ModelSource:
    """A URDF text that Pinocchio takes, and what the text cannot say.

    Attributes:
        name: name of the robot.
        xml: the URDF text.
        base: "fixed" or "floating".
        names: joint names in the text → names in the model.
        joints: joints whose limits are not those of the text.
    """

    name: str
    xml: str = field(repr=False)
    base: Base = "fixed"
    names: Mapping[str, str] = field(default_factory=dict, repr=False)
    joints: tuple[UrdfJoint, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        if self.base not in ("fixed", "floating"):
            raise BadArgument(f"base must be 'fixed' or 'floating', got {self.base!r}")

    def build(self) -> pin.Model:
        """The model.

        Raises:
            BadModel: Pinocchio refuses the text.
        """
        root = (pin.JointModelFreeFlyer(),) if self.base == "floating" else ()
        try:
            model = pin.buildModelFromXML(self.xml, *root, mimic=True)
        except (RuntimeError, ValueError) as error:
            raise BadModel(f"{self.name}: Pinocchio refuses the model: {' '.join(str(error).split())}") from None
        model.name = self.name
        if self.names:
            _rename(model, self.names)
        for joint in self.joints:
            index = model.joints[model.getJointId(joint.name)]
            model.lowerPositionLimit[index.idx_q] = joint.lower
            model.upperPositionLimit[index.idx_q] = joint.upper
            model.upperVelocityLimit[index.idx_v] = joint.velocity
            model.upperEffortLimit[index.idx_v] = joint.effort
        # The parser leaves the velocity bound positive on both sides.
        model.lowerVelocityLimit = -model.upperVelocityLimit
        model.lowerEffortLimit = -model.upperEffortLimit
        return model


def source_of_tree(tree: UrdfTree, base: Base) -> ModelSource:
    """The source of a mended tree: its joints in the tree's order, its limits and its couplings."""
    # The parser takes siblings in alphabetical order, so joints go in under names that sort as the tree does.
    sortable = {joint.name: f"{index:06d}:{joint.name}" for index, joint in enumerate(tree.joints)}
    return ModelSource(
        name=tree.name,
        xml=ET.tostring(_minimal_urdf(tree, sortable), encoding="unicode"),
        base=base,
        names={short: name for name, short in sortable.items()},
        joints=tuple(joint for joint in tree.joints if joint.kind != "fixed" and joint.mimic is None),
    )


def numbers_of(model: pin.Model) -> dict[str, Any]:
    """All numbers of a model that may have been changed since it was built, in a form that pickles.

    A Pinocchio 4.1 model with mimic joints does not survive pickling itself: the copy crashes in forward kinematics.
    """
    return {
        "jointPlacements": list(model.jointPlacements),
        "inertias": list(model.inertias),
        "frames": [frame.placement for frame in model.frames],
        **{name: getattr(model, name).copy() for name in _NUMBERS},
    }


def restore_numbers(model: pin.Model, numbers: Mapping[str, Any]) -> None:
    """Give a freshly built model the numbers that `numbers_of` took from another."""
    for index, placement in enumerate(numbers["jointPlacements"]):
        model.jointPlacements[index] = placement
    for index, inertia in enumerate(numbers["inertias"]):
        model.inertias[index] = inertia
    for frame, placement in zip(model.frames, numbers["frames"], strict=True):
        frame.placement = placement
    for name in _NUMBERS:
        setattr(model, name, numbers[name])


def _minimal_urdf(tree: UrdfTree, names: Mapping[str, str]) -> ET.Element:
    robot = ET.Element("robot", name=tree.name)
    for name in tree.links:
        link = ET.SubElement(robot, "link", name=name)
        if name in tree.inertials:
            link.append(tree.inertials[name])
    for joint in tree.joints:
        element = ET.SubElement(robot, "joint", name=names[joint.name], type=joint.kind)
        ET.SubElement(element, "parent", link=joint.parent)
        ET.SubElement(element, "child", link=joint.child)
        ET.SubElement(element, "origin", xyz=joint.xyz, rpy=joint.rpy)
        if joint.kind != "fixed":
            _add_motion(element, joint, names)
    return robot


def _add_motion(element: ET.Element, joint: UrdfJoint, names: Mapping[str, str]) -> None:
    ET.SubElement(element, "axis", xyz=" ".join(map(repr, joint.axis)))
    # Placeholders: the parser knows no infinity; the true limits are set on the model.
    ET.SubElement(element, "limit", lower="0", upper="0", velocity="0", effort="0")
    if joint.mimic is not None:
        tie = joint.mimic
        values = {"joint": names[tie.joint], "multiplier": repr(tie.multiplier), "offset": repr(tie.offset)}
        ET.SubElement(element, "mimic", values)


def _rename(model: pin.Model, names: Mapping[str, str]) -> None:
    for index in range(model.njoints):
        model.names[index] = names.get(model.names[index], model.names[index])
    for frame in model.frames:
        frame.name = names.get(frame.name, frame.name)
