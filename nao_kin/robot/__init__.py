"""Robot models: any URDF as a Pinocchio model that answers kinematic questions."""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.robot.build import Base, ModelNumbers as ModelNumbers
from nao_kin.robot.chains import SerialChain, Topology, serial_chain, topology
from nao_kin.robot.collisions import Clearance, CollisionRule, Contact, Obstacle
from nao_kin.robot.geometry import GeometryKind, capsules as capsules, read_mesh as read_mesh
from nao_kin.robot.ground import Feet as Feet, OutlineKind, SetDown
from nao_kin.robot.joint_arrays import JointArrays
from nao_kin.robot.kinematics import Expression, Kinematics as Kinematics, PoseForm
from nao_kin.robot.library import load_robot, robot_names
from nao_kin.robot.limits import LimitPolicy, LimitViolation, OutsideRows as OutsideRows
from nao_kin.robot.link_shapes import LinkShapes as LinkShapes
from nao_kin.robot.model import RobotModel
from nao_kin.robot.nao.model import NaoModel, load_nao
from nao_kin.robot.offsets import read_offsets, write_offsets
from nao_kin.robot.support_polygon import SupportPolygon

__all__ = [
    "Base",
    "Clearance",
    "CollisionRule",
    "Contact",
    "Expression",
    "GeometryKind",
    "JointArrays",
    "LimitPolicy",
    "LimitViolation",
    "NaoModel",
    "Obstacle",
    "OutlineKind",
    "PoseForm",
    "RobotModel",
    "SerialChain",
    "SetDown",
    "SupportPolygon",
    "Topology",
    "load_nao",
    "load_robot",
    "read_offsets",
    "robot_names",
    "serial_chain",
    "topology",
    "write_offsets",
]

globals().update(_public_attributes(__name__))
