"""Motions for a simulated NAO: walks and kicks that keep their balance, and gestures; a configuration every 2 ms."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import solve_banded

import nao_kin as nk

LEGS = ("LLeg", "RLeg")
STEP, GRAVITY = 0.002, 9.81


def smooth(u: np.ndarray) -> np.ndarray:
    """Return 0 to 1 with rest at both ends: 10u³ − 15u⁴ + 6u⁵."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u**3 * (10.0 + u * (6.0 * u - 15.0)))


# --- Walks and kicks, from the places of both feet and of the centre of mass.

# Rows in a second; height of the torso over the soles and distance of each foot from the middle [m]; time in which the
# weight is shifted [s].
_RATE, _HEIGHT, _APART, SHIFT = 100, 0.308, 0.05, 1.0


def _flat(places: np.ndarray, heights: np.ndarray | float) -> np.ndarray:
    """Return level poses (n, 4, 4) of places (n, 3): x, y and heading."""
    T = np.tile(np.eye(4), (len(places), 1, 1))
    T[:, :3, :3] = nk.rotations.rot_z(places[:, 2])
    T[:, :2, 3], T[:, 2, 3] = places[:, :2], heights
    return T


def _legs(
    nao: nk.NaoModel, feet: Sequence[np.ndarray], heights: Sequence[np.ndarray], centre: np.ndarray, start: np.ndarray
) -> np.ndarray:
    """Return configurations, one every 2 ms, with both feet and the centre of mass (n, 2) where they shall be."""
    turn = 0.5 * (feet[0][:, 2] + feet[1][:, 2])
    lever = nao.com(start)[:2]
    R = nk.rotations.rot_z(turn)[:, :2, :2]
    torso = _flat(np.column_stack([centre - R @ lever, turn]), _HEIGHT)
    T_left, T_right = (_flat(places, height) for places, height in zip(feet, heights, strict=True))
    found = nk.ik.legs(nao, T_left, T_right, base="floating", torso=torso, free="yaw", near=start, limits="ignore")
    q = found.q
    t, finer = np.arange(len(q)) / _RATE, STEP * np.arange(round((len(q) - 1) / _RATE / STEP))
    return np.column_stack([np.interp(finer, t, column) for column in q.T])


def _balanced(zmp: np.ndarray, height: float = 0.26) -> np.ndarray:
    """Return the centre of mass (n, 2) of an inverted pendulum with this zero-moment point: c − z/g c″ = p."""
    k = height / GRAVITY * _RATE**2
    n = len(zmp)
    bands = np.array([np.full(n, -k), np.full(n, 1.0 + 2.0 * k), np.full(n, -k)])
    bands[1, [0, -1]] = 1.0 + k  # at rest at both ends
    return solve_banded((1, 1), bands, zmp)


def walk(
    nao: nk.NaoModel, steps: int = 8, x: float = 0.04, y: float = 0.0, turn: float = 0.0, period: float = 0.4
) -> np.ndarray:
    """Return a walk of `steps` steps, each ahead, aside and turning by so much, and of one that closes the feet.

    The first and the last second are shifts of the weight.
    """
    start = nao.posture("StandInit")
    middle = np.zeros(3)
    feet = [np.array([0.0, _APART, 0.0]), np.array([0.0, -_APART, 0.0])]
    rows: list[tuple[np.ndarray, ...]] = []
    n, rest = round(period * _RATE), round(SHIFT * _RATE)
    ahead = float(nao.sole_outline("LLeg")[:, 0].mean()) * 0.5
    swing = smooth((np.arange(n) / n - 0.1) / 0.8)[:, None]
    lift = 0.03 * np.sin(np.pi * swing[:, 0]) ** 2

    def zmp_of(foot: np.ndarray) -> np.ndarray:
        return foot[:2] + ahead * np.array([np.cos(foot[2]), np.sin(foot[2])])

    both = 0.5 * (zmp_of(feet[0]) + zmp_of(feet[1]))
    rows += [(feet[0], feet[1], 0.0, 0.0, both)] * rest
    first = 0 if y > 0.0 or turn > 0.0 else 1
    for k in range(steps + 1):
        side = (first + k) % 2
        if k < steps:
            c, s = np.cos(middle[2]), np.sin(middle[2])
            middle = middle + np.array([c * x - s * y, s * x + c * y, turn])
        sign = 1.0 if side == 0 else -1.0
        goal = middle + _APART * sign * np.array([-np.sin(middle[2]), np.cos(middle[2]), 0.0])
        begin = feet[side]
        for u, z in zip(swing, lift, strict=True):
            moving = begin + u * (goal - begin)
            now = (moving, feet[1], z, 0.0) if side == 0 else (feet[0], moving, 0.0, z)
            rows.append((*now, zmp_of(feet[1 - side])))
        feet[side] = goal
    both = 0.5 * (zmp_of(feet[0]) + zmp_of(feet[1]))
    rows += [(feet[0], feet[1], 0.0, 0.0, both)] * rest
    left, right, up, raised, zmp = (np.array(part) for part in zip(*rows, strict=True))
    centre = _balanced(zmp)
    return _legs(nao, (left, right), (up, raised), centre, start)


def kick(nao: nk.NaoModel, side: int = 1, swing: float = 0.06, seconds: float = 0.3) -> np.ndarray:
    """Return a kick: the weight on one foot, the other one lifted, swung back and ahead, and put down."""
    start = nao.posture("StandInit")
    ahead = float(nao.sole_outline("LLeg")[:, 0].mean()) * 0.5
    over = np.array([ahead, (_APART - 0.004) * (1.0 if side == 1 else -1.0)])
    keys = [0.3, 1.2, 0.5, 0.4, seconds, 0.5, 0.4, 1.2, 0.3]
    ways = [0.0, 0.0, 0.0, -0.6 * swing, swing, 0.0, 0.0, 0.0, 0.0]
    heights = [0.0, 0.0, 0.03, 0.03, 0.03, 0.03, 0.0, 0.0, 0.0]
    shares = [0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]
    rows, before = [], np.zeros(3)
    for duration, *to in zip(keys, ways, heights, shares, strict=True):
        u = smooth(np.arange(1, round(duration * _RATE) + 1) / round(duration * _RATE))[:, None]
        rows.append(before + u * (np.array(to) - before))
        before = np.array(to)
    way, height, share = np.concatenate(rows).T
    still, moving = (
        np.tile([0.0, sign * _APART, 0.0], (len(way), 1)) for sign in ((1.0, -1.0) if side == 1 else (-1.0, 1.0))
    )
    moving[:, 0] += way
    zmp = np.array([ahead, 0.0]) + share[:, None] * (over - [ahead, 0.0])
    feet, heights_ = (
        ((still, moving), (0.0 * height, height)) if side == 1 else ((moving, still), (height, 0.0 * height))
    )
    return _legs(nao, feet, heights_, zmp, start)


def gesture(
    nao: nk.NaoModel,
    q: np.ndarray,
    seconds: float,
    rng: np.random.Generator,
    joints: Sequence[str] = ("Head", "Shoulder", "Elbow", "Wrist"),
) -> np.ndarray:
    """Return a motion of some joints about a configuration, by random sines, inside their limits."""
    t = STEP * np.arange(round(seconds / STEP))
    begin = smooth(t / 1.0) * smooth((seconds - t) / 1.0)
    found = np.tile(q, (len(t), 1))
    for k, name in enumerate(nao.joint_names):
        if any(word in name for word in joints):
            wide = 0.3 * (nao.upper[k] - nao.lower[k])
            found[:, k] += (
                begin
                * np.clip(wide, 0.0, 0.4)
                * np.sin(2.0 * np.pi * rng.uniform(0.1, 0.5) * t + rng.uniform(0.0, 6.3))
            )
    return nao.clamp(found)
