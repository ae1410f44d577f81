"""Trajectories: joints with keys of their own, interpolated, checked, mended and edited; and files of many kinds."""

from __future__ import annotations

from nao_kin.motion.checking import check
from nao_kin.motion.configurations import HIPS, HOLD, Hips, Trajectory
from nao_kin.motion.interpolation import INTERPOLATIONS, Interpolation, smooth_slopes
from nao_kin.motion.motion import Motion
from nao_kin.motion.report import MotionReport, MotionViolation

__all__ = [
    "HIPS",
    "HOLD",
    "INTERPOLATIONS",
    "Hips",
    "Interpolation",
    "Motion",
    "MotionReport",
    "MotionViolation",
    "Trajectory",
    "check",
    "smooth_slopes",
]
