"""MJCF, MuJoCo's own format: parsed and compiled by MuJoCo, and turned into the tree that a URDF becomes."""

from nao_kin.robot.urdf.mjcf.reader import mjcf_tree, read_mjcf

__all__ = [
    "mjcf_tree",
    "read_mjcf",
]
