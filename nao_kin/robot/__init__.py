"""Robot models: any URDF as a Pinocchio model that answers kinematic questions."""

from nao_kin.robot.answers import CROSSOVER
from nao_kin.robot.build import LIMIT_ARRAYS, Base, ModelNumbers
from nao_kin.robot.chains import SerialChain, Topology, joint_rows, joints_below, serial_chain, topology
from nao_kin.robot.configurations import COUPLING_TOLERANCE, UNIT_TOLERANCE
from nao_kin.robot.geometry import GeometryKind, mesh_path, read_mesh, shape_geometry
from nao_kin.robot.kinematics import WORLD, Expression, FrameIds, Kinematics, PoseForm, expression_named
from nao_kin.robot.library import load_robot, robot_names
from nao_kin.robot.limits import LIMIT_TOLERANCE, LimitPolicy, LimitViolation
from nao_kin.robot.model import RobotModel, check_robot
from nao_kin.robot.nao.model import NaoModel, load_nao
from nao_kin.robot.offsets import read_offsets
from nao_kin.robot.support_polygon import SupportPolygon, polygon_below, sole_corners

__all__ = [
    "COUPLING_TOLERANCE",
    "CROSSOVER",
    "LIMIT_ARRAYS",
    "LIMIT_TOLERANCE",
    "UNIT_TOLERANCE",
    "WORLD",
    "Base",
    "Expression",
    "FrameIds",
    "GeometryKind",
    "Kinematics",
    "LimitPolicy",
    "LimitViolation",
    "ModelNumbers",
    "NaoModel",
    "PoseForm",
    "RobotModel",
    "SerialChain",
    "SupportPolygon",
    "Topology",
    "check_robot",
    "expression_named",
    "joint_rows",
    "joints_below",
    "load_nao",
    "load_robot",
    "mesh_path",
    "polygon_below",
    "read_mesh",
    "read_offsets",
    "robot_names",
    "serial_chain",
    "shape_geometry",
    "sole_corners",
    "topology",
]
