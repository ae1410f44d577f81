"""The multi-DoF model: a robot as a Pinocchio model of revolute, universal and spherical joints."""

from nao_kin.multidof._readings import CouplingViolation
from nao_kin.multidof.multidof_model import CouplingPolicy, MultiDofModel

__all__ = ["CouplingPolicy", "CouplingViolation", "MultiDofModel"]
