"""Joint types: what revolute, universal and spherical joints are, and where a robot has them."""

from nao_kin.joints.anatomy import ANATOMY, NAO_ANATOMY, AnatomicalJoint, BodyPart, anatomical_kind, body_part
from nao_kin.joints.grouping import RULES, Rule, group_joints, unmerged_joints
from nao_kin.joints.mobility import mobility
from nao_kin.joints.pairs import LOWER_PAIRS, LowerPair, lower_pair
from nao_kin.joints.table import JointRow, JointTable, joint_table
from nao_kin.joints.typed_joint import Coupling, JointGroups, Singularity, TypedJoint

__all__ = [
    "ANATOMY",
    "LOWER_PAIRS",
    "NAO_ANATOMY",
    "RULES",
    "AnatomicalJoint",
    "BodyPart",
    "Coupling",
    "JointGroups",
    "JointRow",
    "JointTable",
    "LowerPair",
    "Rule",
    "Singularity",
    "TypedJoint",
    "anatomical_kind",
    "body_part",
    "group_joints",
    "joint_table",
    "lower_pair",
    "mobility",
    "unmerged_joints",
]
