"""People of simple shapes who walk, squat and clap, as points with known places."""

from __future__ import annotations

import numpy as np

import nao_kin as nk
from nao_kin._core.arrays import Floats
from nao_kin.imitation import Skeleton
from nao_kin.rotations import rot_y, rot_z

RATE = 20.0


def walker(
    seconds: float = 4.0,
    *,
    rate: float = 20.0,
    step: float = 0.15,
    period: float = 2.4,
    squat: float = 0.15,
    lift: float = 0.12,
    noise: float = 0.0,
) -> Skeleton:
    """A person of 1.7 m who steps left and right, bends the knees and the trunk, and swings the arms."""
    times = np.arange(0.0, seconds, 1.0 / rate)
    phase, count = (times / period) % 1.0, np.floor(times / period)
    ones = np.ones(len(times))
    feet = []
    for side, first in ((1.0, 0.1), (-1.0, 0.6)):
        u = np.clip((phase - first) / 0.3, 0.0, 1.0)
        ahead = step * (count + u * u * (3.0 - 2.0 * u))
        feet.append(np.stack([ahead, 0.1 * side * ones, 0.09 + lift * np.sin(np.pi * u) ** 2], axis=1))
    low = squat * np.clip(np.sin(4.0 * np.pi * times / seconds), 0.0, 1.0)
    sway = 0.03 * np.sin(2.0 * np.pi * times / period)
    pelvis = np.stack([(feet[0][:, 0] + feet[1][:, 0]) / 2.0, sway, 0.92 - low], axis=1)
    trunk = rot_y(0.15 * np.sin(2.0 * np.pi * times / seconds))
    points: dict[str, Floats] = {}
    for name, side, ankle in (("left", 1.0, feet[0]), ("right", -1.0, feet[1])):
        hip = pelvis + np.array([0.0, 0.1 * side, 0.0])
        half = np.linalg.norm(hip - ankle, axis=1) / 2.0
        bend = np.sqrt(np.maximum(0.45**2 - half**2, 0.0))
        knee = (hip + ankle) / 2.0 + np.stack([bend, 0.0 * bend, 0.0 * bend], axis=1)
        shoulder = pelvis + trunk @ (0.0, 0.19 * side, 0.5)
        swing = 0.4 * side * np.sin(2.0 * np.pi * times / period)
        upper, fore = (
            np.stack([np.sin(swing + more), 0.2 * side * ones, -np.cos(swing + more)], axis=1) for more in (0.0, 0.6)
        )
        points |= {f"{name}_hip": hip, f"{name}_knee": knee, f"{name}_ankle": ankle}
        points |= {f"{name}_toe": ankle + np.array([0.2, 0.05 * side, -0.06]), f"{name}_shoulder": shoulder}
        points |= {f"{name}_elbow": shoulder + 0.28 * upper, f"{name}_wrist": shoulder + 0.28 * upper + 0.25 * fore}
        points |= {f"{name}_ear": pelvis + trunk @ (0.0, 0.08 * side, 0.72)}
    points["nose"] = pelvis + trunk @ (0.12, 0.0, 0.7)
    rng = np.random.default_rng(0)
    return Skeleton(times, {name: p + rng.normal(0.0, noise, p.shape) for name, p in points.items()})


def both(text: str, first: str = "left") -> list[str]:
    """Return names of one side, then of the other."""
    sides = (first, "right" if first == "left" else "left")
    return [f"{side}_{part}" for side in sides for part in text.split()]


def pairs(text: str) -> list[str]:
    return [f"{side}_{part}" for part in text.split() for side in ("left", "right")]


# The orders as their makers document them, by the names of this library and some more.
SMPL22 = [
    *["pelvis", *pairs("hip"), "chest", *pairs("knee"), "chest", *pairs("ankle"), "chest", *pairs("toe")],
    *["neck", *pairs("collar"), "head", *pairs("shoulder elbow wrist")],
]
ORDERS = {
    "mediapipe": [
        *["nose", *["left_eye"] * 3, *["right_eye"] * 3, *pairs("ear mouth shoulder elbow wrist hand hand thumb")],
        *pairs("hip knee ankle heel toe"),
    ],
    "kinect_v2": [
        *["pelvis", "chest", "neck", "head", *both("shoulder elbow wrist hand"), *both("hip knee ankle toe"), "neck"],
        *both("hand thumb"),
    ],
    "body25": [
        *["nose", "neck", *both("shoulder elbow wrist", "right"), "pelvis", *both("hip knee ankle", "right")],
        *["right_eye", "left_eye", "right_ear", "left_ear", *both("toe toe heel")],
    ],
    "azure_kinect": [
        *["pelvis", "chest", "chest", "neck", *both("collar shoulder elbow wrist hand hand thumb")],
        *[*both("hip knee ankle toe"), "head", "nose", *both("eye ear")],
    ],
    "h36m32": [
        *["pelvis", *both("hip knee ankle toe toe", "right"), "pelvis", "chest", "neck", "nose", "head"],
        *[
            x
            for side in ("left", "right")
            for x in ["neck", *(f"{side}_{part}" for part in ("shoulder elbow wrist wrist thumb hand hand".split()))]
        ],
    ],
    "coco17": ["nose", *pairs("eye ear shoulder elbow wrist hip knee ankle")],
    "h36m17": [
        *["pelvis", *both("hip knee ankle", "right"), "chest", "neck", "nose", "head", *both("shoulder elbow wrist")]
    ],
    "smpl": [*SMPL22, *pairs("hand")],
    "kinect_v1": ["pelvis", "chest", "neck", "head", *both("shoulder elbow wrist hand"), *both("hip knee ankle toe")],
    "msr": [
        *[*pairs("shoulder"), "neck", "chest", *pairs("hip"), "pelvis", *pairs("elbow wrist hand knee ankle toe")],
        "head",
    ],
    "nite": ["head", "neck", *pairs("shoulder elbow wrist"), "chest", *pairs("hip knee ankle")],
    "kard": [
        *["head", "neck", *both("shoulder elbow wrist", "right"), "chest", *both("hip knee ankle", "right")],
    ],
    "cad60": ["head", "neck", "chest", *both("shoulder elbow"), *both("hip knee"), *pairs("wrist ankle")],
    "coco18": [
        *["nose", "neck", *both("shoulder elbow wrist", "right"), *both("hip knee ankle", "right")],
        *["right_eye", "left_eye", "right_ear", "left_ear"],
    ],
}
OTHERS_OF_SMPL = {
    22: SMPL22,
    52: [*SMPL22, *["left_hand"] * 15, *["right_hand"] * 15],
    55: [*SMPL22, "head", *pairs("eye"), *["left_hand"] * 15, *["right_hand"] * 15],
}


def person(
    rng: np.random.Generator, noise: float = 0.0, seconds: float = 4.0, turning: float = 4.0
) -> dict[str, Floats]:
    """Return someone who walks and turns, with one arm that is raised, with errors in all points [m]."""
    made = walker(seconds, rate=RATE)
    points = {name: values.copy() for name, values in made.points.items()}
    up = np.linspace(0.0, 2.0, len(made))
    for part, length in (("elbow", 0.28), ("wrist", 0.25)):
        before = points["left_shoulder" if part == "elbow" else "left_elbow"]
        points["left_" + part] = before + length * np.stack([np.sin(up), 0.3 + 0.0 * up, -np.cos(up)], axis=1)
    points["pelvis"] = (points["left_hip"] + points["right_hip"]) / 2.0
    points["neck"] = (points["left_shoulder"] + points["right_shoulder"]) / 2.0 + (0.0, 0.0, 0.03)
    points["chest"] = 0.6 * points["neck"] + 0.4 * points["pelvis"]
    points["head"] = (points["left_ear"] + points["right_ear"]) / 2.0
    for side in ("left_", "right_"):
        along = points[side + "wrist"] - points[side + "elbow"]
        points[side + "hand"] = points[side + "wrist"] + 0.3 * along
        points[side + "thumb"] = points[side + "wrist"] + 0.25 * along + (0.0, 0.0, 0.03)
        points[side + "eye"] = 0.7 * points["nose"] + 0.3 * points[side + "ear"] + (0.0, 0.0, 0.03)
        points[side + "mouth"] = 0.8 * points["nose"] + 0.2 * points[side + "ear"] - (0.0, 0.0, 0.05)
        points[side + "heel"] = points[side + "ankle"] + (-0.05, 0.0, -0.06)
        points[side + "collar"] = 0.7 * points["neck"] + 0.3 * points[side + "shoulder"]
    turn = rot_z(np.linspace(0.0, float(rng.uniform(-turning, turning)), len(made)))
    return {
        name: np.einsum("nij,nj->ni", turn, values) + rng.normal(0.0, noise, values.shape)
        for name, values in points.items()
    }


def array_of(points: dict[str, Floats], order: list[str], source: str) -> Floats:
    """Return points in an order and in the axes of a camera, as its maker documents them; else with y up."""
    ahead, left, up = np.moveaxis(np.stack([points[name] for name in order], axis=1), -1, 0)
    if source in ("kinect_v2", "kinect_v1", "msr", "nite", "kard", "cad60"):
        return np.stack([-left, up, 2.5 - ahead], axis=-1)
    if source in ("mediapipe", "azure_kinect"):
        return np.stack([left, -up, 2.5 - ahead], axis=-1)
    return np.stack([left, up, ahead], axis=-1)


# --- The robot itself as a person.

LETTERS = (("left", "L"), ("right", "R"))
ARM = ("ShoulderPitch", "ShoulderRoll", "ElbowYaw", "ElbowRoll", "WristYaw")
MOVED = [letter + joint for _, letter in LETTERS for joint in ARM] + ["HeadYaw", "HeadPitch"]
_FRAMES = {"shoulder": "Shoulder", "elbow": "Elbow", "wrist": "WristYaw", "hip": "HipPitch"}


def points_of(robot: nk.RobotModel, q: Floats) -> dict[str, Floats]:
    """The points of the robot itself, named as those of a person."""
    return {
        f"{side}_{name}": robot.fk(q, letter + frame)[:, :3, 3]
        for side, letter in LETTERS
        for name, frame in _FRAMES.items()
    }


def orientations_of(robot: nk.RobotModel, q: Floats) -> dict[str, Floats]:
    frames = {"left_hand": "LWristYaw", "right_hand": "RWristYaw", "head": "Head"}
    return {name: robot.fk(q, frame)[:, :3, :3] for name, frame in frames.items()}


def columns_of(robot: nk.RobotModel) -> list[int]:
    return [robot.nq_base + robot.joint_names.index(name) for name in MOVED]
