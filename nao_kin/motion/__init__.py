"""Trajectories: joints with keys of their own, interpolated, checked, mended and edited; and files of many kinds."""

from __future__ import annotations

from nao_kin.motion.files import FORMATS, MotionFileWarning, read_motion, write_motion
from nao_kin.motion.interpolation import INTERPOLATIONS, Interpolation, smooth_slopes
from nao_kin.motion.motion import Motion

__all__ = [
    "FORMATS",
    "INTERPOLATIONS",
    "Interpolation",
    "Motion",
    "MotionFileWarning",
    "read_motion",
    "smooth_slopes",
    "write_motion",
]
