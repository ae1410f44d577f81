"""Lines of space in Plücker coordinates: direction and moment, seen from any origin.

A line through the point p with unit direction e has, about the origin o, the moment n = (p − o) × e, which is the same
for every p on it. The six numbers (e; n), in this order, are its Plücker coordinates.
"""

from nao_kin.lines._jacobian import geometric_jacobian
from nao_kin.lines._line import PluckerLine
from nao_kin.lines._pairs import CommonNormal, common_normal, distance, incident, reciprocal_product
from nao_kin.lines._transfer import motion_matrix, transfer_matrix

__all__ = [
    "CommonNormal",
    "PluckerLine",
    "common_normal",
    "distance",
    "geometric_jacobian",
    "incident",
    "motion_matrix",
    "reciprocal_product",
    "transfer_matrix",
]
