"""The robot in a browser."""

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.viewer.handles import Recording, ShownRobot
from nao_kin.viewer.meshcat_robot import MeshcatRobot
from nao_kin.viewer.panels import Control
from nao_kin.viewer.shown_scene import OutsideLimitsWarning, Target
from nao_kin.viewer.viewer import Viewer

__all__ = [
    "Control",
    "MeshcatRobot",
    "OutsideLimitsWarning",
    "Recording",
    "ShownRobot",
    "Target",
    "Viewer",
]

globals().update(_public_attributes(__name__))
