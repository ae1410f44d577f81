"""What a Pinocchio model is built from, and building it: once on loading, and again on unpickling."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal
from xml.etree import ElementTree as ET

import pinocchio as pin

from nao_kin.errors import BadArgument, BadModel
from nao_kin.urdf_reader import UrdfInertial, UrdfJoint, UrdfTree

Base = Literal["fixed", "floating"]

# Pinocchio's data grows with the cube of the number of joints: 0.6 GB for 200, 4 GB for 400.
MOST_JOINTS = 250

LIMIT_ARRAYS = (
    "lowerPositionLimit",
    "upperPositionLimit",
    "lowerVelocityLimit",
    "upperVelocityLimit",
    "lowerEffortLimit",
    "upperEffortLimit",
)
# Arrays of a model that its owner may change after loading.
_NUMBERS = ("armature", "rotorGearRatio", "rotorInertia", *LIMIT_ARRAYS)


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
    """The source of a mended tree: its joints in the tree's order, its limits and its couplings.

    Raises:
        BadModel: more joints than Pinocchio can take.
    """
    moving = sum(joint.kind != "fixed" for joint in tree.joints)
    if moving > MOST_JOINTS:
        raise BadModel(f"{tree.name}: {moving} moving joints; Pinocchio's memory grows too fast beyond {MOST_JOINTS}")
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
    """Placements, inertias, gravity, rotors and limits of a model, in a form that pickles.

    A Pinocchio 4.1 model with mimic joints does not survive pickling itself: the copy crashes in forward kinematics.
    """
    return {
        "gravity": model.gravity.vector.copy(),
        "jointPlacements": list(model.jointPlacements),
        "inertias": list(model.inertias),
        "frames": [frame.placement for frame in model.frames],
        **{name: getattr(model, name).copy() for name in _NUMBERS},
    }


def restore_numbers(model: pin.Model, numbers: Mapping[str, Any]) -> None:
    """Give a freshly built model the numbers that `numbers_of` took from another."""
    model.gravity.vector = numbers["gravity"]
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
            _add_inertial(link, tree.inertials[name])
    for joint in tree.joints:
        element = ET.SubElement(robot, "joint", name=names[joint.name], type=joint.kind)
        ET.SubElement(element, "parent", link=joint.parent)
        ET.SubElement(element, "child", link=joint.child)
        ET.SubElement(element, "origin", xyz=joint.xyz, rpy=joint.rpy)
        if joint.kind != "fixed":
            _add_motion(element, joint, names)
    return robot


def _add_inertial(link: ET.Element, inertial: UrdfInertial) -> None:
    element = ET.SubElement(link, "inertial")
    ET.SubElement(element, "origin", xyz=_numbers(inertial.xyz), rpy=_numbers(inertial.rpy))
    ET.SubElement(element, "mass", value=repr(inertial.mass))
    labels = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    ET.SubElement(element, "inertia", {k: repr(v) for k, v in zip(labels, inertial.inertia, strict=True)})


def _add_motion(element: ET.Element, joint: UrdfJoint, names: Mapping[str, str]) -> None:
    ET.SubElement(element, "axis", xyz=_numbers(joint.axis))
    # Placeholders: the parser knows no infinity; the true limits are set on the model.
    ET.SubElement(element, "limit", lower="0", upper="0", velocity="0", effort="0")
    if joint.mimic is not None:
        tie = joint.mimic
        values = {"joint": names[tie.joint], "multiplier": repr(tie.multiplier), "offset": repr(tie.offset)}
        ET.SubElement(element, "mimic", values)


def _numbers(values: Iterable[float]) -> str:
    return " ".join(map(repr, values))


def _rename(model: pin.Model, names: Mapping[str, str]) -> None:
    for index in range(model.njoints):
        model.names[index] = names.get(model.names[index], model.names[index])
    for frame in model.frames:
        frame.name = names.get(frame.name, frame.name)
