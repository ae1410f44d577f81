"""Calibration: joint offsets and camera mountings from photos, lines of a soccer field, motion capture and contacts."""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.calibration.files import from_photos, read_observations
from nao_kin.calibration.observations import FIELDS, Contacts, Field, Lines, Pixels, Poses
from nao_kin.calibration.solve import Calibration, NextPosture, calibrate, next_posture
from nao_kin.calibration.unknowns import PRIORS

__all__ = [
    "FIELDS",
    "PRIORS",
    "Calibration",
    "Contacts",
    "Field",
    "Lines",
    "NextPosture",
    "Pixels",
    "Poses",
    "calibrate",
    "from_photos",
    "next_posture",
    "read_observations",
]

globals().update(_public_attributes(__name__))
