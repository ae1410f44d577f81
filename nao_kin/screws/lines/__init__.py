"""Lines in space in Plücker coordinates: direction and moment, about any origin.

A line through the point p with unit direction e has the moment n = (p − o) × e about the origin o, which is the same
for all points p of the line. The six numbers (e; n), in this order, are its Plücker coordinates.
"""

from __future__ import annotations

from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin.screws.lines._line import PlaneMeeting, PluckerLine, meet_plane
from nao_kin.screws.lines._pairs import (
    CommonNormal,
    angle,
    common_normal,
    distance,
    geometric_jacobian,
    incident,
    motion_matrix,
    reciprocal_product,
    transfer_matrix,
)

__all__ = [
    "CommonNormal",
    "PlaneMeeting",
    "PluckerLine",
    "angle",
    "common_normal",
    "distance",
    "geometric_jacobian",
    "incident",
    "meet_plane",
    "motion_matrix",
    "reciprocal_product",
    "transfer_matrix",
]

globals().update(_public_attributes(__name__))
