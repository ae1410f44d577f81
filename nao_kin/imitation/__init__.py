"""A person's motion, from motion capture or a webcam, as a motion of the robot."""

from __future__ import annotations

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.imitation.files import SAMPLES, read_skeleton
from nao_kin.imitation.imitate import Imitation, imitate
from nao_kin.imitation.layouts import POINTS
from nao_kin.imitation.live import Imitator
from nao_kin.imitation.skeleton import PARTS, Skeleton

__all__ = ["PARTS", "POINTS", "SAMPLES", "Imitation", "Imitator", "Skeleton", "imitate", "read_skeleton"]

globals().update(_public_attributes(__name__))
