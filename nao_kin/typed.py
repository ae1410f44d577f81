"""The earlier name of `nao_kin.multidof`; what is here is the same."""

from nao_kin.multidof import CouplingPolicy, CouplingViolation, MultiDofModel

TypedModel = MultiDofModel

__all__ = ["CouplingPolicy", "CouplingViolation", "TypedModel"]
