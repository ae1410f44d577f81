"""The robot in its world: balance on the floor, and what its cameras see."""

from nao_kin.world.balance import Balance, balance, feet_frame, margin
from nao_kin.world.camera_ground import (
    GroundPoints,
    Horizon,
    ImagePoints,
    camera_pose,
    ground_covariance,
    horizon,
    pixel_to_ground,
    project,
    visible_ground,
)
from nao_kin.world.cameras import Camera, camera

__all__ = [
    "Balance",
    "Camera",
    "GroundPoints",
    "Horizon",
    "ImagePoints",
    "balance",
    "camera",
    "camera_pose",
    "feet_frame",
    "ground_covariance",
    "horizon",
    "margin",
    "pixel_to_ground",
    "project",
    "visible_ground",
]
