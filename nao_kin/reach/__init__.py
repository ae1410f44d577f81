"""Reachability: voxel maps of the random positions of a hand, with manipulability and directions."""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.reach._kernels import direction_cells
from nao_kin.reach.reach_map import ReachMap, load
from nao_kin.reach.sampling import workspace

__all__ = [
    "ReachMap",
    "direction_cells",
    "load",
    "workspace",
]

globals().update(_public_attributes(__name__))
