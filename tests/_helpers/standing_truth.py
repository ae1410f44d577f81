"""Configurations of the legs whose contacts with the floor are known: walks, gestures on one leg, feet on a floor."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import nao_kin as nk


class Standing(NamedTuple):
    """Configurations (n, nq), the contacts of LLeg and RLeg (n, 2), and the true margins (n,) [m]."""

    q: np.ndarray
    contacts: np.ndarray
    margin: np.ndarray


def _pose(x: float, y: float, z: float, pitch: float = 0.0, roll: float = 0.0) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = nk.rotations.rot_y(pitch) @ nk.rotations.rot_x(roll)
    T[:3, 3] = x, y, z
    return T


def _made(nao: nk.NaoModel, rows: list[tuple[np.ndarray, np.ndarray, np.ndarray, tuple[bool, bool]]]) -> Standing:
    """Return the rows (torso, left foot, right foot, contacts) whose feet are both reached, and their true margins."""
    torso, left, right = (np.stack([row[k] for row in rows]) for k in range(3))
    contacts = np.array([row[3] for row in rows])
    found = nk.ik.legs(nao, np.linalg.inv(torso) @ left, np.linalg.inv(torso) @ right)
    # Where the hips disagree, a foot turns about the normal of its sole.
    ok = np.isin(found.reasons, (nk.ik.Reason.REACHED, nk.ik.Reason.HIPS_DISAGREE))
    q, contacts, world = found.q[ok], contacts[ok], torso[ok]
    com = np.einsum("nij,nj->ni", world[:, :3, :3], nao.com(q)) + world[:, :3, 3]
    margins = []
    for k in range(len(q)):
        points = [
            nao.sole_outline(name) @ T[:3, :3].T + T[:3, 3]
            for name, T, on in zip(
                ("LLeg", "RLeg"), world[k] @ nao.fk(q[k], ["LLeg", "RLeg"]), contacts[k], strict=True
            )
            if on
        ]
        margins.append(float(nk.robot.SupportPolygon.around(np.concatenate(points)).signed_distance(com[k])))
    return Standing(q, contacts, np.array(margins))


def walk(nao: nk.NaoModel, steps: int = 12, samples: int = 30, height: float = 0.02, sway: float = 0.0) -> Standing:
    """Return a walk of steps of 40 mm: the trunk sways less than it would have to at rest."""
    rows, feet = [], {"L": 0.0, "R": 0.0}
    for step in range(steps):
        swing, other = ("L", "R") if step % 2 else ("R", "L")
        begin, end = feet[swing], feet[other] + 0.02
        for s in np.linspace(0.0, 1.0, samples):
            air = float(np.clip((s - 0.15) / 0.7, 0.0, 1.0))
            at = dict(feet)
            at[swing] = begin + (end - begin) * air
            z = height * np.sin(np.pi * air)
            side = 1.0 if other == "L" else -1.0
            torso = _pose(
                0.25 * (feet["L"] + feet["R"] + at["L"] + at["R"]), side * sway * np.sin(np.pi * s) ** 0.5, 0.32
            )
            single = 0.0 < air < 1.0
            rows.append(
                (
                    torso,
                    _pose(at["L"], 0.05, z if swing == "L" else 0.0),
                    _pose(at["R"], -0.05, z if swing == "R" else 0.0),
                    (swing == "R" or not single, swing == "L" or not single),
                )
            )
        feet[swing] = end
    return _made(nao, rows)


def gestures(nao: nk.NaoModel, seed: int = 0, count: int = 300) -> Standing:
    """Return configurations on the left leg with the toe of the right foot about 3 mm below the floor to 3 mm above."""
    rng, rows = np.random.default_rng(seed), []
    while len(rows) < count:
        pitch, roll = rng.uniform(0.0, 0.15), rng.uniform(-0.05, 0.05)
        R = nk.rotations.rot_y(pitch) @ nk.rotations.rot_x(roll)
        lowest = (nao.sole_outline("RLeg") @ R.T)[:, 2].min()
        x, y = rng.uniform(-0.04, 0.04), rng.uniform(-0.09, -0.06)
        right = _pose(x, y, rng.uniform(-0.0035, 0.003) - lowest, pitch, roll)
        torso = _pose(rng.uniform(-0.02, 0.02), rng.uniform(0.02, 0.06), 0.28, 0.0, rng.uniform(-0.1, 0.1))
        rows.append((torso, _pose(0.0, 0.05, 0.0), right, (True, False)))
    return _made(nao, rows)


def feet_on_the_floor(nao: nk.NaoModel, seed: int = 0, count: int = 300) -> Standing:
    """Return configurations with both feet flat on the floor, in and out of balance."""
    rng, rows = np.random.default_rng(seed), []
    for _ in range(count):
        torso = _pose(
            rng.uniform(-0.09, 0.12), rng.uniform(-0.04, 0.04), rng.uniform(0.27, 0.31), rng.uniform(-0.3, 0.3)
        )
        rows.append((torso, _pose(rng.uniform(-0.03, 0.03), 0.05, 0.0), _pose(0.0, -0.05, 0.0), (True, True)))
    return _made(nao, rows)


def with_backlash(nao: nk.NaoModel, q: np.ndarray, seed: int = 0, degrees: float = 0.5) -> np.ndarray:
    """Return configurations with an error of up to so many degrees at every joint."""
    limit = np.radians(degrees)
    return q + np.random.default_rng(seed).uniform(-limit, limit, q.shape)
