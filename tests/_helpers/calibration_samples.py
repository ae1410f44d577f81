"""Made-up observations of a NAO that looks at marks on its own hands and feet."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

import nao_kin as nk

MARKS = np.array([[x, y, 0.01] for x in (0.0, 0.03, 0.06) for y in (-0.02, 0.0, 0.02)])
LIMBS = ("LArm", "RArm", "LLeg", "RLeg")
ANGLES = ("roll", "pitch", "yaw")
# The cameras of these robots are where they should be, and turned as the priors say.
IN_PLACE = {name: (1e-5, 1e-5, 1e-5, *np.radians((1.0, 5.0, 2.0))) for name in ("CameraTop", "CameraBottom")}


def measured(robot: nk.RobotModel, name: str = "CameraTop") -> nk.world.Camera:
    """Return a camera of the robot whose lens is known: that of the data sheet."""
    return replace(nk.world.camera(robot, name), nominal=False)


def pixels_of(robot: nk.RobotModel, camera: nk.world.Camera, q: np.ndarray, T_root_points: np.ndarray) -> np.ndarray:
    """Return the pixels (n, k, 2) of marks at poses; all NaN for a posture in which a mark is outside the image."""
    T = nk.screws.inverse(robot.fk(q, camera.frame)) @ T_root_points
    pixels = camera.project(nk.screws.transform_point(T[:, None], MARKS))
    pixels[~camera.sees(pixels).all(axis=-1)] = np.nan
    return pixels


def seen(
    true: nk.RobotModel,
    camera: nk.world.Camera,
    q: np.ndarray,
    frame: str,
    rng: np.random.Generator,
    noise: float = 0.5,
) -> nk.calibration.Pixels:
    """Return what a camera of the true robot sees of the marks on a frame."""
    pixels = pixels_of(true, camera, q, true.fk(q, frame))
    return nk.calibration.Pixels(q, camera, pixels + rng.normal(0.0, noise, pixels.shape), MARKS, frame, noise=noise)


def misread(observations: Sequence[nk.calibration.Pixels], rng: np.random.Generator) -> list[nk.calibration.Pixels]:
    """Return observations of the same postures with the errors of their reported joint values."""
    noise = rng.normal(0.0, np.radians(0.1), np.shape(observations[0].q))
    return [replace(one, q=np.asarray(one.q) + noise) for one in observations]


def looking(
    robot: nk.RobotModel, rng: np.random.Generator, count: int, limbs: Iterable[str] = LIMBS, camera: str = "CameraTop"
) -> np.ndarray:
    """Postures in which a camera sees the marks on some limb, each limb in turn; shape (count, nq)."""
    limbs, lens = list(limbs), measured(robot, camera)
    stock = {limb: list[np.ndarray]() for limb in limbs}
    found = list[np.ndarray]()
    for k in range(count):
        left = stock[limb := limbs[k % len(limbs)]]
        while not left:
            q = robot.random(rng, 500)
            left += list(q[np.isfinite(pixels_of(robot, lens, q, robot.fk(q, limb))[:, 0, 0])])
        found.append(left.pop(0))
    return np.array(found)


def planted(
    robot: nk.RobotModel, rng: np.random.Generator, joints: Sequence[str], cameras: Sequence[str] = ()
) -> tuple[nk.RobotModel, np.ndarray]:
    """A robot whose joints and cameras are wrong as the priors say, and these numbers."""
    numbers = [np.radians(rng.normal(0.0, 1.0, len(joints)))]
    frames: Mapping[str, np.ndarray] = {name: np.radians(rng.normal(0.0, (1.0, 5.0, 2.0))) for name in cameras}
    offsets = dict(zip(joints, numbers[0].tolist(), strict=True))
    followers = {name: m.multiplier * offsets[m.joint] for name, m in robot.mimics.items() if m.joint in offsets}
    true = robot.with_offsets(offsets | followers, {name: (0, 0, 0, *six) for name, six in frames.items()})
    return true, np.concatenate([*numbers, *frames.values()])


def whole_body(nao: nk.RobotModel, seed: int, postures: int = 30) -> tuple[nk.calibration.Calibration, np.ndarray]:
    """Return the calibration of 23 joints and both cameras from views of the limbs, and the true numbers."""
    rng = np.random.default_rng(seed)
    joints = [name for name in nao.joint_names if name not in ("LHand", "RHand")]
    cameras = ("CameraTop", "CameraBottom")
    true, numbers = planted(nao, rng, joints, cameras)
    arms, bottom = LIMBS[:2], "CameraBottom"  # the top camera never sees the feet
    q = np.concatenate(
        (looking(true, rng, postures // 3, arms), looking(true, rng, postures - postures // 3, camera=bottom))
    )
    pairs = [("CameraTop", limb) for limb in arms] + [(bottom, limb) for limb in LIMBS]
    observations = [seen(true, measured(nao, name), q, limb, rng) for name, limb in pairs]
    observations = misread(observations, rng)
    frames = dict.fromkeys(cameras, ANGLES)
    found = nk.calibration.calibrate(nao, observations, joints=joints, frames=frames, prior=IN_PLACE)
    return found, numbers
