"""NAOqi: its names, orders, poses, spaces and limits, and a virtual NAO that implements its protocol.

Only `QiServer` and `NaoqiSource` need qi, NAOqi's Python binding. `nao_kin.naoqi.virtual` documents `VirtualNao`. The
functions of names, orders, poses, spaces and limits are pure; configurations and poses may have leading batch axes.
"""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.naoqi import _qi  # noqa: F401  (loads qi before the other modules load Pinocchio)
from nao_kin.naoqi.compat import run_script
from nao_kin.naoqi.conventions import (
    BODY_ORDERS,
    FRAME_ROBOT,
    FRAME_TORSO,
    FRAME_WORLD,
    AxisMask,
    angles,
    axis_mask,
    chain_names,
    controlled_axes,
    from_order,
    joint_names,
    limits,
    pose,
    pose_from_list,
    pose_in,
    position6d,
    to_order,
    transform_list,
)
from nao_kin.naoqi.live import (
    LOLA_ENTRIES,
    JointReading,
    JointSource,
    LolaSource,
    Lost,
    NaoqiSource,
    decode_lola,
    encode_lola,
    lola_frames,
    readings,
    recorded,
    vertical,
)
from nao_kin.naoqi.virtual.engine import Event, NaoqiError
from nao_kin.naoqi.virtual.expression import light_colours, spoken_words
from nao_kin.naoqi.virtual.qi_server import OpenToOthersWarning, QiServer
from nao_kin.naoqi.virtual.virtual_nao import State, VirtualNao

__all__ = [
    "BODY_ORDERS",
    "FRAME_ROBOT",
    "FRAME_TORSO",
    "FRAME_WORLD",
    "LOLA_ENTRIES",
    "AxisMask",
    "Event",
    "JointReading",
    "JointSource",
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
    "run_script",
    "spoken_words",
    "to_order",
    "transform_list",
    "vertical",
]

globals().update(_public_attributes(__name__))
