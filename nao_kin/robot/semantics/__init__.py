"""What a robot means beyond the links and joints of its URDF: mimics, coupled limits, chains, effectors, postures."""

from nao_kin.robot.semantics.meaning import CoupledLimit, Mimic, Posture, Semantics, View
from nao_kin.robot.semantics.toml import read_semantics

__all__ = [
    "CoupledLimit",
    "Mimic",
    "Posture",
    "Semantics",
    "View",
    "read_semantics",
]
