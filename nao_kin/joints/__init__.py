"""Joint types: what revolute, universal and spherical joints are, and where a robot has them."""

from nao_kin.joints.anatomy import ANATOMY, AnatomicalJoint, AnatomyTable, anatomical_kind, body_part
from nao_kin.joints.grouping import RULES, Rule, group_joints, unmerged_joints
from nao_kin.joints.joint_axes import JointAxes
from nao_kin.joints.joint_table import JointTable, JointTableRow, joint_table
from nao_kin.joints.joint_tree import JointNode, read_joint_tree
from nao_kin.joints.kinematic_pairs import KINEMATIC_PAIRS, KinematicPair, kinematic_pair, mobility
from nao_kin.joints.multidof_joint import Coupling, JointGroups, MultiDofJoint, Singularity
from nao_kin.joints.nao_anatomy import NAO_ANATOMY, BodyPart

# Names of earlier versions.
LOWER_PAIRS = KINEMATIC_PAIRS
LowerPair = KinematicPair
lower_pair = kinematic_pair
JointRow = JointTableRow
TypedJoint = MultiDofJoint

__all__ = [
    "ANATOMY",
    "KINEMATIC_PAIRS",
    "LOWER_PAIRS",
    "NAO_ANATOMY",
    "RULES",
    "AnatomicalJoint",
    "AnatomyTable",
    "BodyPart",
    "Coupling",
    "JointAxes",
    "JointGroups",
    "JointNode",
    "JointRow",
    "JointTable",
    "JointTableRow",
    "KinematicPair",
    "LowerPair",
    "MultiDofJoint",
    "Rule",
    "Singularity",
    "TypedJoint",
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
