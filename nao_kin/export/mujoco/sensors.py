"""Sites, cameras and sensors of the frames that a robot has."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pinocchio as pin

from nao_kin._common.arrays import Floats
from nao_kin.export.mujoco.bodies import Bodies
from nao_kin.export.mujoco.frames import link_of, pos_quat
from nao_kin.semantics import Semantics
from nao_kin.urdf import UrdfTree

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
    felt = {link_of(tree, name): name for name in semantics.force_sensors}
    sensing = {link_of(tree, name) for name in (*semantics.accelerometers, *semantics.gyrometers)} | felt.keys()
    named = {link_of(tree, name) for name, _ in semantics.frames()}
    wanted = {"all": set(tree.links), "effectors": named | sensing, "none": sensing}[frames]
    for body, one in zip(bodies.bodies, added, strict=True):
        sizes = _felt_sizes({link: T for link, T in body.links.items() if link in felt})
        for link, T in body.links.items():
            if link not in sensing and (link not in wanted or link == body.name or link in bodies.between):
                continue
            site = one.add_site(name=link, group=_SENSOR_GROUP if link in sensing else _FRAME_GROUP, **pos_quat(T))
            site.size = [_DOT] * 3
            if link in sizes:
                _make_box(site, sizes[link])
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


def _make_box(site: Any, half: Floats) -> None:
    import mujoco

    site.type = mujoco.mjtGeom.mjGEOM_BOX
    site.size = half.tolist()


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
