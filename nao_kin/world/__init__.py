"""The robot in its world: balance on the floor, and what its cameras see."""

from nao_kin.world.balance import Balance, balance, feet_frame, margin
from nao_kin.world.cameras import Camera, camera

__all__ = ["Balance", "Camera", "balance", "camera", "feet_frame", "margin"]
