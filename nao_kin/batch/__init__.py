"""Kinematics of many configurations at once: programs made of a robot's joints, run by compiled kernels."""

from nao_kin.batch.compiling import KernelState, cache_folder, kernel, warm_up
from nao_kin.batch.execution import execute
from nao_kin.batch.opcodes import aligned_empty
from nao_kin.batch.program import Program
from nao_kin.batch.questions import (
    com_jacobian_program,
    com_program,
    jacobian_program,
    motion_program,
    poses_program,
)
from nao_kin.batch.tree import JointTree, TreeFrame, TreeJoint

__all__ = [
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
    "warm_up",
]
