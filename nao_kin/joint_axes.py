"""`nao_kin.robot.JointAxes` under its former name."""

from nao_kin.robot import JointAxes

__all__ = ["JointAxes"]
