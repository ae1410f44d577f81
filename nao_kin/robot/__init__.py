"""Robot models: any URDF as a Pinocchio model that answers kinematic questions."""

from nao_kin.robot.library import load_robot, robot_names
from nao_kin.robot.limits import LimitViolation
from nao_kin.robot.model import WORLD, RobotModel, check_robot

__all__ = ["WORLD", "LimitViolation", "RobotModel", "check_robot", "load_robot", "robot_names"]
