"""Trajectories with keys for each joint: interpolation, checks, repair and editing; and motion files."""

from __future__ import annotations

from nao_kin.motion.checking import MotionReport, MotionViolation as MotionViolation, check
from nao_kin.motion.editing import (
    complete,
    concatenate,
    loop,
    mirror,
    mirrored_joints as mirrored_joints,
    resample,
    reverse,
    time_warp,
)
from nao_kin.motion.files import FORMATS, is_motion_file as is_motion_file, read_motion, write_motion
from nao_kin.motion.files.source import MotionFileWarning
from nao_kin.motion.interpolation import Interpolation as Interpolation
from nao_kin.motion.mending import Change as Change, MendedMotion, clamp, share_motors, slow_down
from nao_kin.motion.motion import HOLD as HOLD, Motion, Trajectory
from nao_kin.motion.plotting import plot
from nao_kin.robot import Hips as Hips

__all__ = [
    "FORMATS",
    "MendedMotion",
    "Motion",
    "MotionFileWarning",
    "MotionReport",
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
