"""nao_kin: the kinematics of the NAO humanoid.

Conventions: metres, radians, kilograms; rotations are active, R_ab maps coordinates in b to coordinates in a;
quaternions are scalar first; every array function takes leading batch axes.
"""

from nao_kin import errors
from nao_kin.errors import NaoKinError
from nao_kin.nao import NaoModel, load_nao
from nao_kin.robot import LimitViolation, RobotModel, load_robot, robot_names

__version__ = "0.1.0"

__all__ = [
    "LimitViolation",
    "NaoKinError",
    "NaoModel",
    "RobotModel",
    "errors",
    "load_nao",
    "load_robot",
    "robot_names",
]
