"""Where a hand can be: voxel maps of positions drawn at random, with manipulability and directions."""

from nao_kin.reach._kernels import DIRECTION_COUNT, direction_cells
from nao_kin.reach.files import MOST_SAMPLES, MOST_VOXELS, check_column
from nao_kin.reach.reach_map import ReachMap, ReachSettings, Stance, load
from nao_kin.reach.sampling import map_settings, workspace

__all__ = [
    "DIRECTION_COUNT",
    "MOST_SAMPLES",
    "MOST_VOXELS",
    "ReachMap",
    "ReachSettings",
    "Stance",
    "check_column",
    "direction_cells",
    "load",
    "map_settings",
    "workspace",
]
