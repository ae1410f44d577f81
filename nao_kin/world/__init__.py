"""The robot in its world: its balance on the floor, where it has walked, and what its cameras see."""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.world.balance import Balance, balance, feet_frame, margin
from nao_kin.world.camera_ground import (
    SPL,
    GroundPoints,
    ImagePoints,
    camera_pose,
    configurations_at,
    ground_covariance,
    pixel_to_ground,
    project,
    upright_position,
)
from nao_kin.world.camera_views import Horizon, horizon, own_body, project_lines, visible_ground
from nao_kin.world.cameras import Camera, camera, outside_image as outside_image
from nao_kin.world.dynamic_balance import EDGES, DynamicBalance, dynamic_balance
from nao_kin.world.estimator import StateEstimator
from nao_kin.world.legs import standing_sole as standing_sole
from nao_kin.world.odometry import Odometry, odometry
from nao_kin.world.state import State, state

__all__ = [
    "EDGES",
    "SPL",
    "Balance",
    "Camera",
    "DynamicBalance",
    "GroundPoints",
    "Horizon",
    "ImagePoints",
    "Odometry",
    "State",
    "StateEstimator",
    "balance",
    "camera",
    "camera_pose",
    "configurations_at",
    "dynamic_balance",
    "feet_frame",
    "ground_covariance",
    "horizon",
    "margin",
    "odometry",
    "own_body",
    "pixel_to_ground",
    "project",
    "project_lines",
    "state",
    "upright_position",
    "visible_ground",
]

globals().update(_public_attributes(__name__))
