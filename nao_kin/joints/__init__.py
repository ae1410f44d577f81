"""Joint types: the kinematic pairs, a robot's revolute, universal and spherical joints, and anatomy."""

from nao_kin.joints._readings import CouplingViolation
from nao_kin.joints.grouping import JointAxes, Rule as Rule, group_joints
from nao_kin.joints.multidof_model import CouplingPolicy as CouplingPolicy, MultiDofModel
from nao_kin.joints.pairs import (
    KINEMATIC_PAIRS,
    JointGroups,
    KinematicPair,
    MultiDofJoint,
    Singularity,
    kinematic_pair,
    mobility,
)
from nao_kin.joints.tables import (
    ANATOMY,
    NAO_ANATOMY,
    AnatomicalJoint,
    AnatomyTable,
    BodyPart,
    JointTable,
    JointTableRow,
    joint_table,
)

# The names of the two classes in `nk.typed` and in the paper.
TypedModel = MultiDofModel
LowerPair = KinematicPair

__all__ = [
    "ANATOMY",
    "KINEMATIC_PAIRS",
    "NAO_ANATOMY",
    "AnatomicalJoint",
    "AnatomyTable",
    "BodyPart",
    "CouplingViolation",
    "JointAxes",
    "JointGroups",
    "JointTable",
    "JointTableRow",
    "KinematicPair",
    "LowerPair",
    "MultiDofJoint",
    "MultiDofModel",
    "Singularity",
    "TypedModel",
    "group_joints",
    "joint_table",
    "kinematic_pair",
    "mobility",
]
