"""Trajectories: joints with keys of their own, interpolated, checked, mended and edited; and files of many kinds."""

from __future__ import annotations

from nao_kin.motion.interpolation import INTERPOLATIONS, Interpolation, smooth_slopes
from nao_kin.motion.motion import Motion

__all__ = ["INTERPOLATIONS", "Interpolation", "Motion", "smooth_slopes"]
