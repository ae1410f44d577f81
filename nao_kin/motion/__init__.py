"""Trajectories with keys for each joint: interpolation, checks, repair and editing; and motion files."""

from __future__ import annotations

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin._core.sides import Hips
from nao_kin.motion.checking import MotionReport, MotionViolation, check, plot
from nao_kin.motion.editing import complete, concatenate, loop, mirror, resample, reverse, time_warp
from nao_kin.motion.files import FORMATS, is_motion_file as is_motion_file, read_motion, write_motion
from nao_kin.motion.files.source import MotionFileWarning
from nao_kin.motion.interpolation import Interpolation
from nao_kin.motion.mending import Change, MendedMotion, clamp, share_motors, slow_down
from nao_kin.motion.motion import Motion, Trajectory

__all__ = [
    "FORMATS",
    "Change",
    "Hips",
    "Interpolation",
    "MendedMotion",
    "Motion",
    "MotionFileWarning",
    "MotionReport",
    "MotionViolation",
    "Trajectory",
    "check",
    "clamp",
    "complete",
    "concatenate",
    "loop",
    "mirror",
    "plot",
    "read_motion",
    "resample",
    "reverse",
    "share_motors",
    "slow_down",
    "time_warp",
    "write_motion",
]

globals().update(_public_attributes(__name__))
