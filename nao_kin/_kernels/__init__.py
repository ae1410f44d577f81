"""Compiled code: the cache of kernels, and programs that compute the kinematics of many configurations together."""

from nao_kin._kernels.cache import KERNELS, KernelState
from nao_kin._kernels.folder import cache_folder
from nao_kin._kernels.program import Program, aligned_empty
from nao_kin._kernels.program_run import execute, kernel
from nao_kin._kernels.robot_programs import (
    JointTree,
    TreeFrame,
    TreeJoint,
    com_jacobian_program,
    com_program,
    jacobian_program,
    motion_program,
    poses_program,
)

__all__ = [
    "KERNELS",
    "JointTree",
    "KernelState",
    "Program",
    "TreeFrame",
    "TreeJoint",
    "aligned_empty",
    "cache_folder",
    "com_jacobian_program",
    "com_program",
    "execute",
    "jacobian_program",
    "kernel",
    "motion_program",
    "poses_program",
]
