"""Logs of a simulated NAO with known truth: walks, falls, lifts, and sensors with noise, bias, delay and gaps.

The truth is a list of poses of the torso, made without the code under test: the walk is the virtual NAO's, a fall is a
rotation about an edge of the soles. The sensors are computed from it by finite differences and SciPy's rotations.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

import nao_kin as nk

LEGS = ("LLeg", "RLeg")
STEP = 0.01
GRAVITY = 9.81


@dataclass(frozen=True)
class Truth:
    """What happens in each row: configuration, pose of the torso, share of the weight on the left and right foot."""

    times: np.ndarray
    q: np.ndarray
    T: np.ndarray
    share: np.ndarray  # (n, 2); zeros where no foot carries
    doing: np.ndarray  # "standing", "walking", "falling", "front", "back", "left", "right" or "lifted"


@dataclass(frozen=True)
class Recording:
    """What the sensors say: arguments of `nk.world.state`."""

    times: np.ndarray
    q: np.ndarray
    forces: np.ndarray
    accelerometer: np.ndarray
    gyro: np.ndarray
    angles: np.ndarray


def walk(nao: nk.NaoModel, x: float, y: float = 0.0, turn: float = 0.0) -> Truth:
    """A walk of the virtual NAO after and before 1.5 s of standing."""
    rows = []
    with nk.naoqi.VirtualNao(nao, stepped=True, posture="StandInit") as virtual:
        virtual.call("ALMotion", "wakeUp")
        call = virtual.post("ALMotion", "moveTo", x, y, turn)
        while not call.done():
            state = virtual.state()
            rows.append((state.q, state.T_world_torso, LEGS.index(virtual.base.support)))
            virtual.step(STEP)
    q, T, support = (np.array(part) for part in zip(*rows, strict=True))
    # The weight moves within 60 ms.
    share = np.convolve(np.pad(support, 6, mode="edge"), np.full(7, 1.0 / 7.0), "same")[6:-6]
    still = round(1.5 / STEP)
    found = Truth(
        STEP * np.arange(len(q)), q, T, np.column_stack([1.0 - share, share]), np.full(len(q), "walking", dtype="<U8")
    )
    begin, end = stand(nao, still, found.q[0], found.T[0]), stand(nao, still, found.q[-1], found.T[-1])
    return joined(begin, found, end)


def stand(nao: nk.NaoModel, count: int, q: np.ndarray, T: np.ndarray) -> Truth:
    """A robot that stands on both feet."""
    return Truth(
        STEP * np.arange(count),
        np.tile(q, (count, 1)),
        np.tile(T, (count, 1, 1)),
        np.full((count, 2), 0.5),
        np.full(count, "standing", dtype="<U8"),
    )


SIDES = {"front": (0.0, 1.0), "back": (0.0, -1.0), "left": (-1.0, 0.0), "right": (1.0, 0.0)}


def fall(nao: nk.NaoModel, side: str, q: np.ndarray, T: np.ndarray, posture: str | None = None) -> Truth:
    """A fall in 0.8 s, 2 s of lying, and getting up within 3 s to the same place."""
    n, lying, rising = 80, 200, 300
    angle = np.concatenate([(np.arange(n) / n) ** 2, np.ones(lying), np.linspace(1.0, 0.0, rising)]) * np.pi / 2
    end = nao.posture(posture) if posture else q
    blend = np.concatenate([np.linspace(0.0, 1.0, n), np.ones(lying), np.linspace(1.0, 0.0, rising)])[:, None]
    axis = T[:3, :3] @ np.append(SIDES[side], 0.0)
    axis = axis * [1.0, 1.0, 0.0] / np.linalg.norm(axis[:2])
    turned = np.tile(np.eye(4), (len(angle), 1, 1))
    turned[:, :3, :3] = Rotation.from_rotvec(angle[:, None] * axis).as_matrix()
    edge = np.eye(4)
    edge[:3, 3] = T[:3, 3] * [1.0, 1.0, 0.0]
    share = np.where(np.degrees(angle)[:, None] < 20.0, 0.5, 0.0) * np.ones(2)
    doing = np.full(len(angle), "falling", dtype="<U8")
    doing[n : n + lying] = side
    return Truth(
        STEP * np.arange(len(angle)),
        (1.0 - blend) * q + blend * end,
        edge @ turned @ np.linalg.inv(edge) @ T,
        share,
        doing,
    )


def lift(nao: nk.NaoModel, q: np.ndarray, T: np.ndarray, seconds: float = 3.0) -> Truth:
    """A robot that is lifted by 0.2 m, tilted by up to 8° and put down elsewhere."""
    count = round(seconds / STEP)
    u = np.arange(count) / count
    moved = np.tile(T, (count, 1, 1))
    moved[:, 2, 3] += 0.2 * np.sin(np.pi * u)
    moved[:, 0, 3] += 0.3 * u
    tilt = np.radians(8.0) * np.sin(2.0 * np.pi * u)[:, None] * [1.0, 0.5, 0.0]
    moved[:, :3, :3] = Rotation.from_rotvec(tilt).as_matrix() @ T[:3, :3]
    share = np.where((u > 0.03) & (u < 0.97), 0.0, 0.5)[:, None] * np.ones(2)
    doing = np.where(share[:, 0] > 0.0, "standing", "lifted").astype("<U8")
    return Truth(STEP * np.arange(count), np.tile(q, (count, 1)), moved, share, doing)


def joined(*parts: Truth) -> Truth:
    """The parts one after the other."""
    whole = [np.concatenate([getattr(part, name) for part in parts]) for name in ("q", "T", "share", "doing")]
    return Truth(STEP * np.arange(len(whole[0])), *whole)


def life(nao: nk.NaoModel) -> Truth:
    """Stand, walk, fall to the front, get up, be lifted, and fall to the left, every 20 ms."""
    first = walk(nao, 0.3, 0.05, 0.3)
    q, T = first.q[-1], first.T[-1]
    up = lift(nao, q, T)
    still, placed = stand(nao, 100, q, T), stand(nao, 100, q, up.T[-1])
    whole = joined(first, fall(nao, "front", q, T), still, up, placed, fall(nao, "left", q, up.T[-1]))
    return Truth(*(part[:-350:2] for part in vars(whole).values()))


def recorded(nao: nk.NaoModel, truth: Truth, rng: np.random.Generator) -> Recording:
    """The truth as sensors see it: noise of 0.1° of encoders, 0.5° of angles, 0.01 rad/s and 0.3 m/s², and a bias."""
    n = len(truth.times)
    R = truth.T[:, :3, :3]
    step = truth.times[1] - truth.times[0]
    turns = Rotation.from_matrix(R[:-1].swapaxes(1, 2) @ R[1:]).as_rotvec() / step
    gyro = np.concatenate([turns[:1], 0.5 * (turns[1:] + turns[:-1]), turns[-1:]])
    at = truth.T[:, :3, 3]
    a = np.gradient(np.gradient(at, step, axis=0), step, axis=0)
    a = np.clip(a, -20.0, 20.0)
    a[:, 2] += GRAVITY
    force = np.einsum("nji,nj->ni", R, a)
    angles = np.column_stack([np.arctan2(R[:, 2, 1], R[:, 2, 2]), np.arcsin(np.clip(-R[:, 2, 0], -1.0, 1.0))])
    weight = 5.4 * truth.share * (1.0 + rng.normal(0.0, 0.03, (n, 2)))
    sensors = np.repeat(weight / 4.0, 4, axis=1) + np.abs(rng.normal(0.0, 0.02, (n, 8)))
    return Recording(
        truth.times,
        truth.q + rng.normal(0.0, np.radians(0.1), truth.q.shape),
        sensors,
        force + rng.normal(0.0, 0.3, (n, 3)),
        gyro + np.array([0.01, -0.02, 0.015]) + rng.normal(0.0, 0.01, (n, 3)),
        angles + rng.normal(0.0, np.radians(0.5), (n, 2)),
    )


def without(recording: Recording, nao: nk.NaoModel, rng: np.random.Generator) -> Recording:
    """The recording with hands of NaN, 1 % of rows with a joint of NaN, and NaN in the inertial unit."""
    q = recording.q.copy()
    q[:, [nao.joint_names.index(name) for name in ("LHand", "RHand")]] = np.nan
    q[rng.random(len(q)) < 0.01, nao.joint_names.index("LKneePitch")] = np.nan
    gyro, accelerometer, angles, forces = (
        np.array(part) for part in (recording.gyro, recording.accelerometer, recording.angles, recording.forces)
    )
    gone = rng.random(len(q)) < 0.01
    for part in (gyro, accelerometer, angles, forces):
        part[gone] = np.nan
    return replace(recording, q=q, gyro=gyro, accelerometer=accelerometer, angles=angles, forces=forces)
