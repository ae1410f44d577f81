"""`nao_kin.joints.JointAxes` under its former name."""

from nao_kin.joints import JointAxes

__all__ = ["JointAxes"]
