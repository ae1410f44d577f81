"""Both legs by brute force: HipYawPitch in fine steps, and the other joints for each by elementary geometry."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

import nao_kin as nk
from nao_kin.rotations import rot_x, rot_y

Floats = NDArray[np.float64]
JOINTS = ("HipRoll", "HipPitch", "KneePitch", "AnklePitch", "AnkleRoll")


def scanned(nao: nk.NaoModel, side: str, T: Floats, hips: Floats, *, enforce: bool) -> tuple[Floats, Floats]:
    """Return configurations (8, n, nq) that meet ankle and normal with each HipYawPitch, and the foot's turns (8, n).

    The turns are NaN outside the limits.
    """
    zero = nao.neutral()
    hip, knee, ankle = (nao.position(zero, side + joint) for joint in ("HipYawPitch", "KneePitch", "AnklePitch"))
    thigh, tibia = np.linalg.norm(hip - knee), np.linalg.norm(knee - ankle)
    turned = np.tile(nao.clamp(zero), (len(hips), 1))
    turned[:, nao.joint_names.index("LHipYawPitch")] = hips
    # A frame behind the motor, parallel to the torso with all joints at zero.
    R = nao.rotation(turned, side + "HipYawPitch") @ nao.rotation(zero, side + "HipYawPitch").T
    place = T[:3, 3] + T[:3, :3] @ (ankle - nao.position(zero, side + "Leg"))
    p = (place - hip) @ R
    n = T[:3, 2] @ R
    far = np.linalg.norm(place - hip)
    bend = np.arccos(np.clip((far**2 - thigh**2 - tibia**2) / (2.0 * thigh * tibia), -1.0, 1.0))
    rows, turns = [], []
    for sign, below, ahead in itertools.product((1.0, -1.0), repeat=3):
        roll = np.arctan2(below * p[:, 1], -below * p[:, 2])
        in_plane, normal = (np.einsum("nji,nj->ni", rot_x(roll), v) for v in (p, n))
        pitch = np.arctan2(-in_plane[:, 0], -in_plane[:, 2])
        # The angle between the line from hip to ankle and the thigh, by the law of sines.
        pitch = pitch - np.arctan2(tibia * np.sin(sign * bend), thigh + tibia * np.cos(bend))
        foot_roll = np.arctan2(-normal[:, 1], ahead * np.hypot(normal[:, 0], normal[:, 2]))
        foot_pitch = np.arctan2(ahead * normal[:, 0], ahead * normal[:, 2])
        values = (roll, pitch, np.full_like(roll, sign * bend), foot_pitch - pitch - sign * bend, foot_roll)
        q = turned.copy()
        for joint, value in zip(JOINTS, values, strict=True):
            q[:, nao.joint_names.index(side + joint)] = np.mod(value + np.pi, 2.0 * np.pi) - np.pi
        foot = R @ rot_x(roll) @ rot_y(foot_pitch) @ rot_x(foot_roll)
        against = np.einsum("ji,njk->nik", T[:3, :3], foot)
        turn = np.arctan2(against[:, 1, 0], against[:, 0, 0])
        rows.append(q)
        inside = (np.abs(nao.clamp(q) - q) <= 1e-9).all(axis=-1)  # of the limits themselves, without the tolerance
        turns.append(np.where(inside, turn, np.nan) if enforce else turn)
    return np.array(rows), np.array(turns)


def least_turns(
    nao: nk.NaoModel, T_left: Floats, T_right: Floats, steps: int, *, enforce: bool
) -> dict[str, tuple[float, float]]:
    """Return the least turns of both feet over HipYawPitch, by the priority that compares them.

    They are infinite without solutions.
    """
    column = nao.joint_names.index("LHipYawPitch")
    ends = (nao.lower[column], nao.upper[column]) if enforce else (-np.pi, np.pi)
    hips = np.linspace(*ends, steps)
    turns = []
    for side, T in (("L", T_left), ("R", T_right)):
        _, of_branches = scanned(nao, side, T, hips, enforce=enforce)
        turns.append(np.where(np.isnan(of_branches), np.inf, np.abs(of_branches)).min(axis=0))
    left, right = turns
    both = np.isfinite(left) & np.isfinite(right)
    if not both.any():
        left[:] = right[:] = np.inf
    costs = {"balanced": np.hypot(left, right), "left": left, "right": right}
    best = {priority: np.argmin(np.where(both, cost, np.inf)) for priority, cost in costs.items()}
    return {priority: (float(left[at]), float(right[at])) for priority, at in best.items()}
