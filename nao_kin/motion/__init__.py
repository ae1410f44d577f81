"""Trajectories: joints with keys of their own, interpolated, checked, mended and edited; and files of many kinds."""

from __future__ import annotations

from nao_kin.motion.checking import MotionReport, MotionViolation, check
from nao_kin.motion.configurations import HIPS, HOLD, Hips, Trajectory
from nao_kin.motion.editing import complete, concatenate, loop, mirror, mirrored_joints, resample, reverse, time_warp
from nao_kin.motion.files import FORMATS, is_motion_file, read_motion, write_motion
from nao_kin.motion.files.source import MotionFileWarning
from nao_kin.motion.interpolation import INTERPOLATIONS, Interpolation, smooth_slopes
from nao_kin.motion.mending import Change, Mended, clamp, share_motors, slow_down
from nao_kin.motion.motion import Motion
from nao_kin.motion.plotting import plot

__all__ = [
    "FORMATS",
    "HIPS",
    "HOLD",
    "INTERPOLATIONS",
    "Change",
    "Hips",
    "Interpolation",
    "Mended",
    "Motion",
    "MotionFileWarning",
    "MotionReport",
    "MotionViolation",
    "Trajectory",
    "check",
    "clamp",
    "complete",
    "concatenate",
    "is_motion_file",
    "loop",
    "mirror",
    "mirrored_joints",
    "plot",
    "read_motion",
    "resample",
    "reverse",
    "share_motors",
    "slow_down",
    "smooth_slopes",
    "time_warp",
    "write_motion",
]
