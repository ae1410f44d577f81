"""The typed model: a robot as a Pinocchio model of revolute, universal and spherical joints."""

from nao_kin.typed._violations import CouplingViolation
from nao_kin.typed.model import CouplingPolicy, TypedModel

__all__ = ["CouplingPolicy", "CouplingViolation", "TypedModel"]
