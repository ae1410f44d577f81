"""Joint types: the kinematic pairs, a robot's revolute, universal and spherical joints, and anatomy."""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.joints.dh import DHConvention, DHTable, dh_table
from nao_kin.joints.grouping import JointAxes, Rule, group_joints
from nao_kin.joints.multidof_model import CouplingPolicy, MultiDofModel
from nao_kin.joints.pairs import KINEMATIC_PAIRS, JointGroups, KinematicPair, MultiDofJoint, kinematic_pair, mobility
from nao_kin.joints.tables import ANATOMY, NAO_ANATOMY, JointTable, JointTableRow, joint_table

# The name in the paper.
LowerPair = KinematicPair

__all__ = [
    "ANATOMY",
    "KINEMATIC_PAIRS",
    "NAO_ANATOMY",
    "CouplingPolicy",
    "DHConvention",
    "DHTable",
    "JointAxes",
    "JointGroups",
    "JointTable",
    "JointTableRow",
    "KinematicPair",
    "LowerPair",
    "MultiDofJoint",
    "MultiDofModel",
    "Rule",
    "dh_table",
    "group_joints",
    "joint_table",
    "kinematic_pair",
    "mobility",
]

globals().update(_public_attributes(__name__))
