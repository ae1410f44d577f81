"""MJCF, MuJoCo's own format: parsed and compiled by MuJoCo, and turned into the tree that a URDF becomes."""

from nao_kin.urdf.mjcf.reader import read_mjcf

__all__ = ["read_mjcf"]
