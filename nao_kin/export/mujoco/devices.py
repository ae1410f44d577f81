"""Actuators, sites, cameras and sensors of a robot in MuJoCo.

A URDF states the largest effort e and the largest speed v of a motor. Three estimates complete the servo:

- the full effort acts at an error of 0.05 rad (5 mm for a sliding joint): kp = e / 0.05;
- no effort is available at the largest speed, as for an ideal DC motor: damping = e / v;
- the rotor's inertia behind the gear is armature = 0.015 s · e / v: 0.007 kg m² for the NAO's knee, as for a rotor of
  4 g cm² behind the published ratio of 130.85.

The derivative gain makes the servo critically damped on its own rotor.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin

from nao_kin._core.arrays import Floats
from nao_kin.export.mujoco.bodies import Bodies, BodyJoint, pos_quat
from nao_kin.export.variants import link_of
from nao_kin.robot.semantics import Semantics
from nao_kin.robot.urdf import UrdfJoint, UrdfTree

# Estimates, not published.
FULL_EFFORT_ERROR = {"revolute": 0.05, "prismatic": 0.005}  # [rad, m]
ROTOR_TIME = 0.015  # armature / damping [s]
_NARROWEST = 1e-9  # half the range of a joint that cannot move [rad, m]
UNKNOWN_GAIN = 100.0  # where no effort is published [N m / rad, N / m]


@dataclass(frozen=True)
class Servo:
    """The parameters of a joint's motor, per unit of position or speed [N m, rad; or N, m]."""

    kp: float  # effort per error
    kv: float  # effort per speed of the controller
    damping: float  # viscous effort per speed of the joint
    armature: float  # inertia of the rotor behind the gear [kg m², or kg]
    effort: float  # largest effort, ∞ where none is published


def servo(row: UrdfJoint) -> Servo:
    """Return the motor of a joint from the published effort and speed; infinite values and effort 0 are unknown."""
    effort = row.effort if 0.0 < row.effort < math.inf else math.inf
    known = effort < math.inf and row.velocity < math.inf
    slope = effort / row.velocity if known else 0.0
    armature = ROTOR_TIME * slope
    kp = effort / FULL_EFFORT_ERROR[row.kind] if effort < math.inf else UNKNOWN_GAIN
    kv = max(2.0 * math.sqrt(kp * armature) - slope, 0.0) if known else 0.1 * kp
    return Servo(kp, kv, row.damping + slope, armature, effort)


def motor_of(joint: BodyJoint) -> Servo:
    """Return the motor of a joint; a ball has the weakest of its three, because all three reach this effort."""
    return min(map(servo, joint.rows), key=lambda motor: motor.effort)


def proper_range(lower: float, upper: float) -> tuple[float, float]:
    """Return limits for MuJoCo, which would ignore a range of zero width and let the joint move freely."""
    return (lower, upper) if lower < upper else (lower - _NARROWEST, upper + _NARROWEST)


def add_actuators(spec: Any, joints: Iterable[BodyJoint]) -> tuple[str, ...]:
    """Add a position actuator for each joint that is not a mimic joint; return a line on joints without effort.

    A ball has three, with the suffixes _x, _y, _z, because MuJoCo measures it by its rotation vector: their controls
    are the rotation vector of the wanted orientation in the frame of the joint (`nao_kin.rotations.log`).
    """
    unknown = []
    for joint in joints:
        motor = motor_of(joint)
        if joint.kind == "ball":
            for place, letter in enumerate("xyz"):
                _add_actuator(spec, f"{joint.name}_{letter}", joint.name, motor, (-math.pi, math.pi), place)
        elif joint.rows[0].mimic is None:
            _add_actuator(spec, joint.name, joint.name, motor, (joint.rows[0].lower, joint.rows[0].upper))
        else:
            continue
        if motor.effort == math.inf:
            unknown.append(joint.name)
    note = f"no effort is published for {', '.join(unknown)}: force without bounds, gain {UNKNOWN_GAIN:g}"
    return (note,) if unknown else ()


def _add_actuator(spec: Any, name: str, joint: str, motor: Servo, allowed: tuple[float, float], axis: int = 0) -> None:
    added = spec.add_actuator(name=name, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    added.set_to_position(kp=motor.kp, kv=motor.kv)
    added.gear = np.eye(6)[axis]
    if all(map(math.isfinite, allowed)):
        added.ctrlrange = proper_range(*allowed)
    if motor.effort < math.inf:
        added.forcerange = (-motor.effort, motor.effort)


# --- Sites, cameras and sensors at the frames of a robot.

_FRAME_GROUP, _SENSOR_GROUP = 4, 3
_DOT = 0.005
# Cameras look along x with z up; MuJoCo's look along −z with y up.
_R_FRAME_CAMERA = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
_IMAGE_HEIGHT = 480
# A force sensor measures contacts within this height [m].
_FELT = 0.01


def add_sites(
    spec: Any, added: list[Any], bodies: Bodies, tree: UrdfTree, semantics: Semantics, frames: str
) -> tuple[str, ...]:
    """Add a site for each link that is not a body, a camera for each camera, and all sensors; return the differences.

    `frames` selects the links with sites: "all", "effectors" for those in the semantics, "none" for sensors only.
    """
    felt = {link_of(tree, name) for name in semantics.force_sensors}
    sensing = {link_of(tree, name) for name in (*semantics.accelerometers, *semantics.gyrometers)} | felt
    named = {link_of(tree, name) for name in semantics.frames()}
    wanted = {"all": set(tree.links), "effectors": named | sensing, "none": sensing}[frames]
    for body, one in zip(bodies.bodies, added, strict=True):
        sizes = _felt_sizes({link: T for link, T in body.links.items() if link in felt})
        for link, T in body.links.items():
            if link not in sensing and (link not in wanted or link == body.name or link in bodies.between):
                continue
            site = one.add_site(name=link, group=_SENSOR_GROUP if link in sensing else _FRAME_GROUP, **pos_quat(T))
            site.size = [_DOT] * 3
            if link in sizes:
                site.type, site.size = mujoco.mjtGeom.mjGEOM_BOX, sizes[link].tolist()
    _add_sensors(spec, bodies, tree, semantics)
    return _add_cameras(added, bodies, tree, semantics)


def _felt_sizes(places: dict[str, pin.SE3]) -> dict[str, Floats]:
    """Return half lengths of a box about each force sensor; boxes do not overlap, so one sensor feels each contact."""
    sizes = {}
    for link, T in places.items():
        others = np.array([T.actInv(other).translation for name, other in places.items() if name != link])
        half = np.full(3, _FELT)
        for axis in (0, 1):
            # Neighbours along an axis are farther along it than across.
            along = [abs(p[axis]) for p in others if abs(p[axis]) > abs(p[1 - axis])]
            half[axis] = 0.5 * min(along) if along else 0.1
        sizes[link] = half
    return sizes


def _add_sensors(spec: Any, bodies: Bodies, tree: UrdfTree, semantics: Semantics) -> None:
    kinds, objects = mujoco.mjtSensor, mujoco.mjtObj

    def add(name: str, kind: Any, what: Any, of: str) -> None:
        spec.add_sensor(name=name, type=kind, objtype=what, objname=of)

    for names, kind, word in (
        (semantics.accelerometers, kinds.mjSENS_ACCELEROMETER, "acceleration"),
        (semantics.gyrometers, kinds.mjSENS_GYRO, "angular_velocity"),
        (semantics.force_sensors, kinds.mjSENS_TOUCH, "force"),
    ):
        for name in names:
            add(f"{name}_{word}", kind, objects.mjOBJ_SITE, link_of(tree, name))
    root = bodies.bodies[0].name
    add(f"{root}_orientation", kinds.mjSENS_FRAMEQUAT, objects.mjOBJ_XBODY, root)
    for joint in bodies.joints():
        measured = {"position": kinds.mjSENS_JOINTPOS, "velocity": kinds.mjSENS_JOINTVEL}
        if joint.kind == "ball":
            measured = {"orientation": kinds.mjSENS_BALLQUAT, "angular_velocity": kinds.mjSENS_BALLANGVEL}
        for word, kind in measured.items():
            add(f"{joint.name}_{word}", kind, objects.mjOBJ_JOINT, joint.name)


def _add_cameras(added: list[Any], bodies: Bodies, tree: UrdfTree, semantics: Semantics) -> tuple[str, ...]:
    changes = []
    for name in semantics.cameras:
        body, T = bodies.place(link_of(tree, name))
        one = added[bodies.bodies.index(body)]
        camera = one.add_camera(name=name, **pos_quat(T * pin.SE3(_R_FRAME_CAMERA, np.zeros(3))))
        if name in semantics.fields_of_view:
            horizontal, vertical = semantics.fields_of_view[name]
            camera.fovy = math.degrees(vertical)
            ratio = math.tan(0.5 * horizontal) / math.tan(0.5 * vertical)
            camera.resolution = [2 * round(0.5 * _IMAGE_HEIGHT * ratio), _IMAGE_HEIGHT]  # video needs even numbers
        else:
            changes.append(f"the field of view of {name} is unknown: MuJoCo's default, 45° vertically")
    return tuple(changes)
