"""Joint types: what revolute, universal and spherical joints are, and where a robot has them."""

from nao_kin.joints._readings import CouplingViolation
from nao_kin.joints.grouping import RULES, JointAxes, JointNode, Rule, group_joints, read_joint_tree, unmerged_joints
from nao_kin.joints.multidof_model import CouplingPolicy, MultiDofModel
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
    anatomical_kind,
    body_part,
    joint_table,
)

# The class under its former name.
TypedModel = MultiDofModel

__all__ = [
    "ANATOMY",
    "KINEMATIC_PAIRS",
    "LOWER_PAIRS",
    "NAO_ANATOMY",
    "RULES",
    "AnatomicalJoint",
    "AnatomyTable",
    "BodyPart",
    "CouplingPolicy",
    "CouplingViolation",
    "JointAxes",
    "JointGroups",
    "JointNode",
    "JointRow",
    "JointTable",
    "JointTableRow",
    "KinematicPair",
    "LowerPair",
    "MultiDofJoint",
    "MultiDofModel",
    "Rule",
    "Singularity",
    "TypedJoint",
    "TypedModel",
    "anatomical_kind",
    "body_part",
    "group_joints",
    "joint_table",
    "kinematic_pair",
    "lower_pair",
    "mobility",
    "read_joint_tree",
    "unmerged_joints",
]


# Names of earlier versions.
LOWER_PAIRS = KINEMATIC_PAIRS
LowerPair = KinematicPair
lower_pair = kinematic_pair
JointRow = JointTableRow
TypedJoint = MultiDofJoint
