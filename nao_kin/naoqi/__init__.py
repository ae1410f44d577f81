"""NAOqi's language: its names, orders, poses, spaces and limits, and a virtual NAO that speaks it.

What stands here needs neither NAOqi nor its Python binding, but for `QiServer`: pure functions of robots,
configurations and poses, with leading batch axes, and `VirtualNao`, which `nao_kin.naoqi.virtual` explains.
"""

from nao_kin.naoqi import _qi  # noqa: F401  (qi is loaded before Pinocchio, which the others import)
from nao_kin.naoqi.axis_mask import (
    AXES,
    AXIS_MASK_ALL,
    AXIS_MASK_NONE,
    AXIS_MASK_PLANEZ,
    AXIS_MASK_ROT,
    AXIS_MASK_VEL,
    AXIS_MASK_WX,
    AXIS_MASK_WY,
    AXIS_MASK_WYWZ,
    AXIS_MASK_WZ,
    AXIS_MASK_X,
    AXIS_MASK_XY,
    AXIS_MASK_Y,
    AXIS_MASK_Z,
    AXIS_MASKS,
    axis_mask,
    controlled_axes,
)
from nao_kin.naoqi.limits import limits
from nao_kin.naoqi.live import JointReading, JointSource, LolaSource, Lost, NaoqiSource, readings, recorded, vertical
from nao_kin.naoqi.lola import LOLA_ENTRIES, LOLA_SOCKET, LolaFrame, decode_lola, encode_lola, lola_frames
from nao_kin.naoqi.names import CHAINS, GROUPS, angles, chain_names, joint_names
from nao_kin.naoqi.orders import BODY_ORDERS, Hips, from_order, to_order
from nao_kin.naoqi.poses import pose, pose_from_list, position6d, transform_list
from nao_kin.naoqi.scripts import run_script
from nao_kin.naoqi.shown import light_colours, spoken_words
from nao_kin.naoqi.spaces import (
    EFFECTORS,
    FRAME_ROBOT,
    FRAME_TORSO,
    FRAME_WORLD,
    SPACES,
    frame_of,
    pose_in,
    robot_frame,
    space_number,
    torso_in,
)
from nao_kin.naoqi.virtual import Change, NaoqiError, OpenToOthersWarning, QiServer, State, VirtualNao

__all__ = [
    "AXES",
    "AXIS_MASKS",
    "AXIS_MASK_ALL",
    "AXIS_MASK_NONE",
    "AXIS_MASK_PLANEZ",
    "AXIS_MASK_ROT",
    "AXIS_MASK_VEL",
    "AXIS_MASK_WX",
    "AXIS_MASK_WY",
    "AXIS_MASK_WYWZ",
    "AXIS_MASK_WZ",
    "AXIS_MASK_X",
    "AXIS_MASK_XY",
    "AXIS_MASK_Y",
    "AXIS_MASK_Z",
    "BODY_ORDERS",
    "CHAINS",
    "EFFECTORS",
    "FRAME_ROBOT",
    "FRAME_TORSO",
    "FRAME_WORLD",
    "GROUPS",
    "LOLA_ENTRIES",
    "LOLA_SOCKET",
    "SPACES",
    "Change",
    "Hips",
    "JointReading",
    "JointSource",
    "LolaFrame",
    "LolaSource",
    "Lost",
    "NaoqiError",
    "NaoqiSource",
    "OpenToOthersWarning",
    "QiServer",
    "State",
    "VirtualNao",
    "angles",
    "axis_mask",
    "chain_names",
    "controlled_axes",
    "decode_lola",
    "encode_lola",
    "frame_of",
    "from_order",
    "joint_names",
    "light_colours",
    "limits",
    "lola_frames",
    "pose",
    "pose_from_list",
    "pose_in",
    "position6d",
    "readings",
    "recorded",
    "robot_frame",
    "run_script",
    "space_number",
    "spoken_words",
    "to_order",
    "torso_in",
    "transform_list",
    "vertical",
]
