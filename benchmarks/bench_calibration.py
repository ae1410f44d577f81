"""How far a calibration can be trusted: errors of simulated robots before and after, for each kind of observation.

Twenty robots have joint zeros and camera angles that are wrong by N(0, 1°). Their corners have a noise of 0.5 pixels,
and their encoders one of 0.1°. The errors are those of the camera's axis in the torso, and of a ball on the floor 2 m
ahead of the left sole. Errors are medians over the robots; the shares say how often the error of a number is within
two of its standard deviations.

Example:
    python benchmarks/bench_calibration.py
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

import numpy as np

import nao_kin as nk

DEGREE = np.pi / 180.0
NOISE, ENCODERS = 0.5, 0.1 * DEGREE
GRID = 0.03 * np.array([[x, y, 0.0] for y in range(6) for x in range(9)])
T_TORSO_BOARD = nk.screws.pose(nk.rotations.matrix_from_rpy([0.2, -1.35, 0.1]), [0.6, -0.05, 0.05])
BALL = np.array([2.0, 0.0, 0.0])  # in the left sole
ANGLES = ("roll", "pitch", "yaw")
HEAD = ("HeadYaw", "HeadPitch")
LEGS = tuple(
    f"{side}{name}" for side in "LR" for name in ("HipRoll", "HipPitch", "KneePitch", "AnklePitch", "AnkleRoll")
)
LEGS = ("LHipYawPitch", *LEGS)

Floats = Any


def planted(nao: nk.RobotModel, rng: np.random.Generator, joints: tuple[str, ...]) -> nk.RobotModel:
    """Return a robot whose zeros and camera are wrong."""
    zeros = dict(zip(joints, rng.normal(0.0, DEGREE, len(joints)).tolist(), strict=True))
    if "LHipYawPitch" in zeros:
        zeros["RHipYawPitch"] = zeros["LHipYawPitch"]
    return nao.with_offsets(zeros, {"CameraTop": (0, 0, 0, *rng.normal(0.0, DEGREE, 3))})


def measured_camera(nao: nk.RobotModel) -> nk.world.Camera:
    """Return the top camera with a lens that is known."""
    return replace(nk.world.camera(nao, "CameraTop"), nominal=False)


def heads(nao: nk.RobotModel, rng: np.random.Generator, count: int) -> Floats:
    """Return postures with the head turned to the board or the floor, as a robot stands."""
    return nao.posture("StandInit", HeadYaw=rng.uniform(-0.35, 0.35, count), HeadPitch=rng.uniform(-0.2, 0.25, count))


def seen(true: nk.RobotModel, camera: nk.world.Camera, q: Floats, rng: np.random.Generator, points: Floats) -> Floats:
    """Return the noisy pixels (n, k, 2) of points in the torso, NaN outside the image."""
    T = nk.screws.inverse(true.fk(q, camera.frame))
    pixels = camera.project(nk.screws.transform_point(T[:, None], points))
    pixels[~camera.sees(pixels)] = np.nan
    return pixels + rng.normal(0.0, NOISE, pixels.shape)


def errors(true: nk.RobotModel, robot: nk.RobotModel, q: Floats, camera: nk.world.Camera) -> tuple[float, float]:
    """Return the error of the camera's axis in the torso [deg], and of the ball's place in the left sole [mm]."""
    axes = [one.fk(q, camera.frame)[..., :3, 0] for one in (true, robot)]
    angle = np.degrees(np.arccos(np.clip((axes[0] * axes[1]).sum(axis=-1), -1.0, 1.0))).mean()
    stand = true.posture("StandInit", HeadPitch=0.1)
    T_sole = [nk.screws.inverse(one.fk(stand, "LLeg")) for one in (true, robot)]
    pixel = nk.world.project(true, stand, BALL, camera, T_world_base=T_sole[0]).pixels
    place = nk.world.pixel_to_ground(robot, stand, pixel, camera, T_world_base=T_sole[1]).points
    return float(angle), float(1e3 * np.linalg.norm(place - BALL))


def chessboard(nao: nk.RobotModel, rng: np.random.Generator, known: bool) -> tuple[float, ...]:
    """Return errors before and after pictures of a chessboard at a known or an unknown place."""
    camera, true = measured_camera(nao), planted(nao, rng, HEAD)
    q = heads(nao, rng, 24)
    points = nk.screws.transform_point(T_TORSO_BOARD, GRID)
    pixels = seen(true, camera, q, rng, points)
    reported = q.copy()
    reported[:, :2] += rng.normal(0.0, ENCODERS, (len(q), 2))
    one = nk.calibration.Pixels(
        reported, camera, pixels, points if known else GRID, board=None if known else "board", noise=NOISE
    )
    found = nk.calibration.calibrate(nao, [one], joints=HEAD, frames={"CameraTop": ANGLES})
    return (*errors(true, nao, q, camera), *errors(true, found.calibrated(), q, camera))


def field_lines(nao: nk.RobotModel, rng: np.random.Generator, legs: bool) -> tuple[float, ...]:
    """Return errors before and after pixels on the lines in front of the opponent's goal, from an unknown place."""
    joints = (*HEAD, *(name for name in LEGS if name.startswith("L"))) if legs else HEAD
    camera, true = measured_camera(nao), planted(nao, rng, joints)
    yaws, pitches = np.meshgrid((-0.8, -0.4, 0.0, 0.4, 0.8), (0.0, 0.15, 0.3))
    q = nao.posture("StandInit", HeadYaw=yaws.ravel(), HeadPitch=pitches.ravel())
    T_field_sole = nk.screws.pose(nk.rotations.rot_z(0.3), [2.0, -0.5, 0.0])
    T_camera_field = nk.screws.inverse(true.fk(q, camera.frame)) @ true.fk(q, "LLeg") @ nk.screws.inverse(T_field_sole)
    parts, lines = list[Floats](), list[str]()
    for name, ends in nk.calibration.FIELDS["SPL 2020"].lines.items():
        points = np.linspace(*ends, 80)
        pixels = camera.project(nk.screws.transform_point(T_camera_field[:, None], np.pad(points, ((0, 0), (0, 1)))))
        near = np.linalg.norm(points - (2.0, -0.5), axis=-1) < 4.0
        seen = camera.sees(pixels) & near
        part = np.full((len(q), 5, 2), np.nan)
        for k in np.flatnonzero(seen.any(axis=1)):
            part[k] = pixels[k, rng.choice(np.flatnonzero(seen[k]), 5)]
        parts.append(part + rng.normal(0.0, NOISE, part.shape))
        lines += [name] * 5
    reported = q.copy()
    moved = [nao.joint_names.index(name) for name in HEAD]
    reported[:, moved] += rng.normal(0.0, ENCODERS, (len(q), 2))
    one = nk.calibration.Lines(reported, camera, np.concatenate(parts, axis=1), lines, noise=NOISE)
    found = nk.calibration.calibrate(nao, [one], joints=joints, frames={"CameraTop": ANGLES})
    return (*errors(true, nao, q, camera), *errors(true, found.calibrated(), q, camera))


def standing(true: nk.RobotModel, rng: np.random.Generator, count: int, spread: float) -> Floats:
    """Return postures in which both soles of a robot are flat on one floor."""
    q = true.posture("StandInit") + rng.uniform(-spread, spread, (20 * count, true.nq))
    # The shared motor of the hips stays where it is: the other five joints meet the two tilts and the height.
    moved = [true.joint_names.index(name) for name in true.chains["RLeg"] if name != "RHipYawPitch"]
    for _ in range(8):
        T = nk.screws.inverse(true.fk(q, "LLeg")) @ true.fk(q, "RLeg")
        error = np.stack((T[:, 2, 3], T[:, 0, 2], T[:, 1, 2]), axis=-1)
        R, J = T[:, :3, :3], true.jacobian(q, "RLeg", "frame")[..., moved]
        turned = R @ np.stack((J[:, 4], -J[:, 3], 0.0 * J[:, 5]), axis=1)
        rows = np.concatenate(((R @ J[:, :3])[:, 2:], turned[:, :2]), axis=1)
        q[:, moved] -= (np.linalg.pinv(rows) @ error[..., None])[..., 0]
        near = true.within_limits(q)
        q, error = q[near], error[near]
    return q[np.abs(error).max(axis=-1) < 1e-9][:count]


def contacts(nao: nk.RobotModel, rng: np.random.Generator, spread: float) -> tuple[float, float]:
    """Return the rms of the errors of the legs' zeros [deg], before and after 40 postures on both soles."""
    true = planted(nao, rng, LEGS)
    q = standing(true, rng, 40, spread)
    reported = q + rng.normal(0.0, ENCODERS, q.shape)
    one = nk.calibration.Contacts(reported, "RLeg", "LLeg")
    found = nk.calibration.calibrate(nao, [one], joints=LEGS)
    zeros = np.array([_zero(true, nao, name) for name in LEGS])
    after = zeros - [found.joints.get(name, 0.0) for name in LEGS]
    return float(np.degrees(np.sqrt((zeros**2).mean()))), float(np.degrees(np.sqrt((after**2).mean())))


def _zero(true: nk.RobotModel, nao: nk.RobotModel, joint: str) -> float:
    R = [one.rotation(one.neutral(), joint, reference=one.tree.root) for one in (nao, true)]
    parent = next(row.parent for row in nao.tree.joints if row.name == joint)
    before = [one.rotation(one.neutral(), parent) for one in (nao, true)]
    turned = nk.rotations.log(np.linalg.inv(np.linalg.inv(before[0]) @ R[0]) @ np.linalg.inv(before[1]) @ R[1])
    axis = np.array(next(row.axis for row in nao.tree.moving_joints if row.name == joint))
    return float(turned @ axis / np.linalg.norm(axis))


def main() -> None:
    """Print the errors before and after each kind of observation."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", type=int, default=20)
    robots = parser.parse_args().robots
    nao = nk.load_nao()
    for name, method, known in (
        ("chessboard, unknown place", chessboard, False),
        ("chessboard, known place", chessboard, True),
        ("field lines", field_lines, False),
        ("field lines, legs wrong", field_lines, True),
    ):
        if method is field_lines and not hasattr(nk.calibration, "Lines"):
            continue
        rows = np.array([method(nao, np.random.default_rng(seed), known) for seed in range(robots)])
        a, b, c, d = np.median(rows, axis=0)
        print(f"{name:28} camera {a:.2f}° -> {c:.2f}°   ball {b:.0f} mm -> {d:.0f} mm")
    for spread in (0.15, 0.04):
        rows = np.array([contacts(nao, np.random.default_rng(seed), spread) for seed in range(robots)])
        before, after = np.sqrt((rows**2).mean(axis=0))
        name = f"legs, 40 contacts, ± {spread} rad"
        print(f"{name:28} zeros  {before:.2f}° -> {after:.2f}° rms, worst robot {rows[:, 1].max():.2f}°")


if __name__ == "__main__":
    main()
