"""Bodies, joints and couplings in MuJoCo's specification."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from nao_kin._common.free_names import fresh_name
from nao_kin.export.mujoco.actuators import proper_range, servo, weakest
from nao_kin.export.mujoco.bodies import Bodies, Body, BodyJoint
from nao_kin.export.mujoco.frames import pos_quat

# Couplings as stiff as MuJoCo takes them: a time constant of two steps of the simulation, critically damped, and
# constraint forces that give way to a ten-thousandth.
_COUPLING_SOLREF = (0.004, 1.0)
_COUPLING_SOLIMP = (0.9999, 0.9999, 0.001, 0.5, 2.0)


def add_bodies(spec: Any, bodies: Bodies, *, floating: bool) -> list[Any]:
    """Add bodies with their masses and joints, and one equality for each joint that follows another.

    Args:
        spec: the specification.
        bodies: of the robot.
        floating: whether the root moves freely.

    Returns:
        What the specification has for each body.
    """
    import mujoco

    added: list[Any] = []
    for body in bodies.bodies:
        parent = spec.worldbody if body.parent < 0 else added[body.parent]
        one = parent.add_body(name=body.name, **pos_quat(body.T_parent))
        _set_inertia(one, body)
        for joint in body.joints:
            _add_joint(one, joint)
        added.append(one)
    if floating:
        added[0].add_freejoint(name=free_name(bodies))
    for joint in bodies.joints():
        mimic = joint.rows[0].mimic
        if joint.kind != "ball" and mimic is not None:
            equality = spec.add_equality(
                name=joint.name,
                type=mujoco.mjtEq.mjEQ_JOINT,
                objtype=mujoco.mjtObj.mjOBJ_JOINT,
                name1=joint.name,
                name2=mimic.joint,
                solref=_COUPLING_SOLREF,
                solimp=_COUPLING_SOLIMP,
            )
            # Coefficients of a polynomial; the length of the array differs between versions of MuJoCo.
            equality.data[:5] = mimic.offset, mimic.multiplier, 0.0, 0.0, 0.0
    return added


def free_name(bodies: Bodies) -> str:
    """Name of the root's free joint: "root_joint", or the first of its kind that no joint has."""
    return fresh_name("root_joint", {joint.name for joint in bodies.joints()})


def _set_inertia(one: Any, body: Body) -> None:
    if body.inertia.mass == 0.0 and not np.any(body.inertia.inertia) and not body.joints:
        return
    tensor = body.inertia.inertia
    one.mass, one.ipos = float(body.inertia.mass), body.inertia.lever.tolist()
    one.fullinertia = [float(tensor[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    one.explicitinertial = True


def _add_joint(one: Any, joint: BodyJoint) -> None:
    import mujoco

    motor, row = weakest(map(servo, joint.rows)), joint.rows[0]
    kind = {"hinge": "HINGE", "slide": "SLIDE", "ball": "BALL"}[joint.kind]
    added = one.add_joint(name=joint.name, type=getattr(mujoco.mjtJoint, f"mjJNT_{kind}"))
    if joint.kind != "ball":
        added.axis = joint.axes[0].tolist()
    if joint.kind == "ball":
        _set_passive(added, motor.damping, motor.armature, max(part.friction for part in joint.rows))
    elif row.mimic is not None:
        # The driving joint has the motor and the limits of both.
        _set_passive(added, row.damping, 0.0, row.friction)
    else:
        _set_passive(added, motor.damping, motor.armature, row.friction)
        if math.isfinite(row.lower) and math.isfinite(row.upper):
            added.range = proper_range(row.lower, row.upper)


def _set_passive(added: Any, damping: float, armature: float, friction: float) -> None:
    # A polynomial of the speed since MuJoCo 3.10, a number before.
    added.damping = damping if np.ndim(added.damping) == 0 else [damping, 0.0, 0.0]
    added.armature = armature
    added.frictionloss = friction
