"""What an MJCF says beyond links and joints: cameras, keyframes and sensors as semantics."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._text import quoted
from nao_kin.rotations import euler_from_matrix
from nao_kin.semantics import Posture, Semantics
from nao_kin.urdf.mjcf.joints import BALL, FREE, Motion, pose

R_CAMERA_FRAME = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
"""The axes of our cameras in those of MuJoCo's: ours look along x with z up, MuJoCo's along −z with y up."""

# Of `mujoco.mjtSensor` and `mujoco.mjtObj`: the sensors that stand in a site.
_SENSORS = {"mjSENS_ACCELEROMETER": "accelerometers", "mjSENS_GYRO": "gyrometers", "mjSENS_TOUCH": "force_sensors"}
# A base that is turned by less than this stands upright [rad].
_UPRIGHT = 1e-6


def fields_of_view(model: Any, cameras: Mapping[int, str]) -> dict[str, tuple[float, float]]:
    """Camera frame → horizontal and vertical field of view [rad], of the cameras whose picture has a known shape."""
    found = {}
    for camera, name in cameras.items():
        width, height = (float(size) for size in model.cam_sensorsize[camera])
        columns, rows = (int(count) for count in model.cam_resolution[camera])
        vertical = math.radians(float(model.cam_fovy[camera]))
        if width > 0.0 and height > 0.0:
            focal = [float(length) for length in model.cam_intrinsic[camera, :2]]
            fields = tuple(2.0 * math.atan2(size, 2.0 * f) for size, f in zip((width, height), focal, strict=True))
        elif columns > 1 and rows > 1:
            fields = (2.0 * math.atan(math.tan(vertical / 2.0) * columns / rows), vertical)
        else:
            continue
        if all(0.0 < angle < math.pi for angle in fields):
            found[name] = (fields[0], fields[1])
    return found


def sensor_frames(mujoco: Any, model: Any, sites: Mapping[int, str]) -> dict[str, tuple[str, ...]]:
    """Frames of accelerometers, gyrometers and sensors of pressing forces, under the names that the semantics have."""
    kinds = {int(getattr(mujoco.mjtSensor, name)): part for name, part in _SENSORS.items()}
    found: dict[str, list[str]] = {}
    for sensor in range(int(model.nsensor)):
        part, site = kinds.get(int(model.sensor_type[sensor])), int(model.sensor_objid[sensor])
        if part and site in sites and sites[site] not in found.get(part, []):
            found.setdefault(part, []).append(sites[site])
    return {part: tuple(frames) for part, frames in found.items()}


def postures(model: Any, own: Sequence[tuple[str, Motion]], base: int | None) -> Iterator[tuple[str, Posture]]:
    """The keyframes with a name, as postures.

    Args:
        model: the `mujoco.MjModel`.
        own: name and motion of each joint with a coordinate of its own.
        base: the free joint of the base, None without one.
    """
    for key in range(int(model.nkey)):
        name, q = str(model.key(key).name), model.key_qpos[key]
        if name:
            angles = {joint: value(model, q, motion) for joint, motion in own}
            yield name, Posture(angles, None if base is None else _up(q[model.jnt_qposadr[base] :][3:7]))


def value(model: Any, q: Floats, motion: Motion) -> float:
    """The value of one coordinate in a configuration of MuJoCo."""
    first = int(model.jnt_qposadr[motion.id])
    if int(model.jnt_type[motion.id]) != BALL:
        return float(q[first])
    turns = euler_from_matrix(pose((0.0, 0.0, 0.0), q[first : first + 4])[:3, :3], "xyz", axes="moving").angles
    return float(turns[motion.part])


def free_joint(model: Any, body: int) -> int | None:
    """The free joint of a body, None where it has none."""
    joint = int(model.body_jntadr[body])
    return joint if joint >= 0 and int(model.jnt_type[joint]) == FREE else None


def _up(quaternion: Floats) -> tuple[float, float, float] | None:
    """The vertical in the axes of a base; None where the base stands upright."""
    x, y, z = (float(component) for component in pose((0.0, 0.0, 0.0), quaternion)[2, :3])
    return None if math.hypot(x, y) < _UPRIGHT and z > 0.0 else (x, y, z)


def semantics_of(
    mujoco: Any,
    model: Any,
    *,
    own: Sequence[tuple[str, Motion]],
    base: int | None,
    cameras: Mapping[int, str],
    sites: Mapping[int, str],
    notes: list[str],
) -> Semantics:
    """The semantics: cameras with their fields of view, named keyframes as postures, sensors.

    The first keyframe is the posture that is shown first.
    """
    found = dict(postures(model, own, base))
    unnamed = int(model.nkey) - len(found)
    if unnamed:
        notes.append(f"keyframes without a name left out: {unnamed}")
    for name in found:
        if not all(math.isfinite(angle) for angle in found[name].angles.values()):
            raise ValueError(f"keyframe {quoted(name)} is not finite")
    sensors = sensor_frames(mujoco, model, sites)
    return Semantics(
        cameras=tuple(cameras.values()),
        fields_of_view=fields_of_view(model, cameras),
        postures=found,
        start=next(iter(found), ""),
        accelerometers=sensors.get("accelerometers", ()),
        gyrometers=sensors.get("gyrometers", ()),
        force_sensors=sensors.get("force_sensors", ()),
    )
