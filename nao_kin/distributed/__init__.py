"""Poses, Jacobians and centres of mass of configurations in a dask array, on one machine or on many.

Needs the extra `dask`: pip install nao-kin[dask].
"""

from nao_kin.distributed.client import connect
from nao_kin.distributed.lazy_arrays import acceleration, com, com_jacobian, fk, jacobian, position, rotation, velocity

__all__ = [
    "acceleration",
    "com",
    "com_jacobian",
    "connect",
    "fk",
    "jacobian",
    "position",
    "rotation",
    "velocity",
]
