"""The robot in its world: its balance on the floor, where it has walked, and what its cameras see."""

from nao_kin.world.balance import Balance, balance, feet_frame, margin
from nao_kin.world.cameras import Camera, camera
from nao_kin.world.odometry import (
    LOWER as LOWER,
    Odometry,
    odometry,
    sole_heights as sole_heights,
    standing_sole as standing_sole,
)

__all__ = ["Balance", "Camera", "Odometry", "balance", "camera", "feet_frame", "margin", "odometry"]
