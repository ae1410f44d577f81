"""Feet that stand on their soles: boxes whose lower faces are nearly the soles' planes, moved to them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from nao_kin.export.mujoco.bodies import Bodies
from nao_kin.export.mujoco.frames import link_of, pose
from nao_kin.semantics import Semantics
from nao_kin.urdf import Box, Collision, Origin, UrdfTree

# A box that ends nearer than this to the plane of a sole is that of the foot [m].
_NEAR = 0.005
_PARALLEL = 1e-6


def on_their_soles(tree: UrdfTree, bodies: Bodies, semantics: Semantics) -> tuple[UrdfTree, tuple[str, ...]]:
    """The tree with the boxes of its feet ending in the planes of the soles.

    The published box of NAO's foot ends 0.6 mm above the sole: the frames of the soles would stand below the floor.

    Args:
        tree: the robot.
        bodies: of it.
        semantics: which frames are soles.

    Returns:
        The tree, and one line for each sole whose foot was changed, or has no shape.
    """
    collisions, changes = list(tree.collisions), []
    for sole in semantics.soles:
        body, T_sole = bodies.place(link_of(tree, sole))
        own = [(place, shape) for place, shape in enumerate(collisions) if shape.link in body.links]
        if not own:
            changes.append(f"no shape holds the sole {sole}: it touches nothing")
        for place, shape in own:
            T_shape = T_sole.actInv(body.links[shape.link] * pose(shape.origin))
            lowered = _to_the_plane(shape, T_shape)
            if lowered is not None:
                collisions[place], gap = lowered
                changes.append(f"the lower face of {shape.name or shape.link} is moved by {gap * 1e3:.2f} mm to {sole}")
    return replace(tree, collisions=tuple(collisions)), tuple(changes)


def _to_the_plane(shape: Collision, T_sole_shape: pin.SE3) -> tuple[Collision, float] | None:
    """A box that ends in the plane z = 0, and by how much it has grown downwards; None for what is no such box."""
    if not isinstance(shape.geometry, Box):
        return None
    down = T_sole_shape.rotation[2]
    axis = int(np.argmax(np.abs(down)))
    size = list(shape.geometry.size)
    gap = float(T_sole_shape.translation[2] - 0.5 * size[axis])
    if abs(down[axis]) < 1.0 - _PARALLEL or gap == 0.0 or abs(gap) > _NEAR:
        return None
    size[axis] += gap
    # The box grows along its own axis, away from the side that stays.
    shift = np.zeros(3)
    shift[axis] = -0.5 * gap * np.sign(down[axis])
    x, y, z = (np.array(shape.origin.xyz) + pose(shape.origin).rotation @ shift).tolist()
    return replace(shape, geometry=Box((size[0], size[1], size[2])), origin=Origin((x, y, z), shape.origin.rpy)), gap
