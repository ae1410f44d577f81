"""What a robot senses and is driven with in MuJoCo: actuators, sites, cameras and sensors.

A URDF says of a motor its largest effort e and its largest speed v. Of the rest, three estimates make a servo of it:

- the full effort acts at an error of 0.05 rad (5 mm for a sliding joint): kp = e / 0.05;
- no effort is left at the largest speed, the line of an ideal DC motor: damping = e / v;
- the rotor's inertia, as seen behind the gear, is armature = 0.015 s · e / v: 0.007 kg m² for NAO's knee, where a rotor
  of 4 g cm² behind the published ratio of 130.85 has as much.

The derivative gain makes the servo critically damped on its own rotor.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from nao_kin._core.arrays import Floats
from nao_kin.export.mujoco.bodies import Bodies, BodyJoint, link_of, pos_quat
from nao_kin.robot.semantics import Semantics
from nao_kin.robot.urdf import UrdfJoint, UrdfTree

# All three are estimates, not published.
FULL_EFFORT_ERROR = {"revolute": 0.05, "prismatic": 0.005}  # [rad, m]
ROTOR_TIME = 0.015  # armature / damping [s]
_NARROWEST = 1e-9  # half the range of a joint that cannot move [rad, m]
UNKNOWN_GAIN = 100.0  # where no effort is published [N m / rad, N / m]


@dataclass(frozen=True)
class Servo:
    """What the motor of a joint does.

    Attributes:
        kp: torque or force per unit of error.
        kv: torque or force per unit of speed that the controller adds.
        damping: viscous torque or force of the joint itself.
        armature: inertia of the rotor behind the gear [kg m², or kg].
        effort: largest torque or force, ∞ where none is published.
    """

    kp: float
    kv: float
    damping: float
    armature: float
    effort: float


def servo(row: UrdfJoint) -> Servo:
    """The motor of a joint, by the published effort and speed; those of zero or without a bound are not known."""
    effort = row.effort if 0.0 < row.effort < math.inf else math.inf
    known = effort < math.inf and 0.0 < row.velocity < math.inf
    slope = effort / row.velocity if known else 0.0
    armature = ROTOR_TIME * slope
    kp = effort / FULL_EFFORT_ERROR[row.kind] if effort < math.inf else UNKNOWN_GAIN
    kv = max(2.0 * math.sqrt(kp * armature) - slope, 0.0) if known else 0.1 * kp
    return Servo(kp, kv, row.damping + slope, armature, effort)


def motor_of(joint: BodyJoint) -> Servo:
    """The motor of a joint; a ball is turned by the weakest of its three, for it can do what all of them can."""
    return min(map(servo, joint.rows), key=lambda motor: motor.effort)


def proper_range(lower: float, upper: float) -> tuple[float, float]:
    """Limits as MuJoCo takes them: a range of no width is none to it, and the joint would move freely."""
    return (lower, upper) if lower < upper else (lower - _NARROWEST, upper + _NARROWEST)


def add_actuators(spec: Any, joints: Iterable[BodyJoint]) -> tuple[str, ...]:
    """A position actuator for each joint that does not follow another, of the joint's name.

    A ball has three, named with _x, _y, _z: their controls are the rotation vector of the wanted orientation in the
    frame of the joint (`nao_kin.rotations.log`), for MuJoCo measures a ball by its rotation vector.

    Returns:
        One line for each joint without a published effort.
    """
    unknown = []
    for joint in joints:
        motor = motor_of(joint)
        if joint.kind == "ball":
            for place, letter in enumerate("xyz"):
                _add(spec, f"{joint.name}_{letter}", joint.name, motor, (-math.pi, math.pi), place)
        elif joint.rows[0].mimic is None:
            _add(spec, joint.name, joint.name, motor, (joint.rows[0].lower, joint.rows[0].upper))
        else:
            continue
        if motor.effort == math.inf:
            unknown.append(joint.name)
    if not unknown:
        return ()
    return (f"no effort is published for {', '.join(unknown)}: force without bounds, gain {UNKNOWN_GAIN:g}",)


def _add(spec: Any, name: str, joint: str, motor: Servo, allowed: tuple[float, float], axis: int = 0) -> None:
    import mujoco

    added = spec.add_actuator(name=name, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    added.set_to_position(kp=motor.kp, kv=motor.kv)
    added.gear = np.eye(6)[axis]
    if all(map(math.isfinite, allowed)):
        added.ctrlrange = proper_range(*allowed)
    if motor.effort < math.inf:
        added.forcerange = (-motor.effort, motor.effort)


# --- Sites, cameras and sensors of the frames that a robot has.

_FRAME_GROUP, _SENSOR_GROUP = 4, 3
_DOT = 0.005
# Cameras look along x with z up; MuJoCo's look along −z with y up.
_R_FRAME_CAMERA = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
_IMAGE_HEIGHT = 480
# A force sensor feels what presses on the foot within this height of it [m].
_FELT = 0.01


def add_sites(
    spec: Any, added: list[Any], bodies: Bodies, tree: UrdfTree, semantics: Semantics, frames: str
) -> tuple[str, ...]:
    """A site for each link that is no body of its own, a camera for each camera, and all sensors.

    Args:
        spec: the specification.
        added: what it has for each body.
        bodies: of the robot.
        tree: its tree.
        semantics: what its frames mean.
        frames: which links get a site: "all", "effectors" for those that the semantics name, "none" for the sensors'.

    Returns:
        One line for each thing that is not as the robot has it.
    """
    import mujoco

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
    """Half lengths of a box about each force sensor of a body, that reaches half the way to its neighbours.

    The boxes cover the sole without overlapping, so that whatever presses on it is felt by one sensor.
    """
    sizes = {}
    for link, T in places.items():
        others = np.array([T.actInv(other).translation for name, other in places.items() if name != link])
        half = np.full(3, _FELT)
        for axis in (0, 1):
            # Neighbours along an axis lie more along it than across.
            along = [abs(p[axis]) for p in others if abs(p[axis]) > abs(p[1 - axis])]
            half[axis] = 0.5 * min(along) if along else 0.1
        sizes[link] = half
    return sizes


def _add_sensors(spec: Any, bodies: Bodies, tree: UrdfTree, semantics: Semantics) -> None:
    import mujoco

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
        if joint.kind == "ball":
            add(f"{joint.name}_orientation", kinds.mjSENS_BALLQUAT, objects.mjOBJ_JOINT, joint.name)
            add(f"{joint.name}_angular_velocity", kinds.mjSENS_BALLANGVEL, objects.mjOBJ_JOINT, joint.name)
        else:
            add(f"{joint.name}_position", kinds.mjSENS_JOINTPOS, objects.mjOBJ_JOINT, joint.name)
            add(f"{joint.name}_velocity", kinds.mjSENS_JOINTVEL, objects.mjOBJ_JOINT, joint.name)


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
            camera.resolution = [2 * round(0.5 * _IMAGE_HEIGHT * ratio), _IMAGE_HEIGHT]  # video wants even numbers
        else:
            changes.append(f"the field of view of {name} is not known: MuJoCo's own, 45° vertically")
    return tuple(changes)
