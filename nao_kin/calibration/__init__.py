"""Calibration: joint offsets and camera mountings from pixels, motion capture and contacts."""

from nao_kin.calibration.design import NextPosture, next_posture
from nao_kin.calibration.observations import Contacts, Pixels, Poses, read_observations
from nao_kin.calibration.solve import Calibration, calibrate

__all__ = [
    "Calibration",
    "Contacts",
    "NextPosture",
    "Pixels",
    "Poses",
    "calibrate",
    "next_posture",
    "read_observations",
]
