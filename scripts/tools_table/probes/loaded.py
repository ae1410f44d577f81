"""The data that a probe returns about a loaded robot, and their comparison with the reference."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Poses = Mapping[str, Floats]

# Tolerances of a pose [m, and entries of the rotation], and of two coupled joints in a simulation [rad].
SAME_POSE = 1e-6
SAME_ANGLE = 0.01


@dataclass(frozen=True)
class Loaded:
    """A robot in a tool.

    Attributes:
        poses: maps the angles of all joints to the pose (4, 4) of every frame of the tool, in any common frame.
        mass: the mass of the robot in the tool [kg]; None if the tool has no masses.
        meshes: the number of meshes that the tool shows; None if it shows no meshes.
        held: mimic joints that a constraint of the tool couples, in simulation or in a solver.
        told: mimic joints whose coupling the tool reports, and leaves to the caller.
        simulate: simulates a moment, and returns the angles of the joints afterwards; None if the tool cannot simulate.
    """

    poses: Callable[[Mapping[str, float]], Poses]
    mass: float | None = None
    meshes: int | None = None
    held: Iterable[str] = ()
    told: Iterable[str] = ()
    simulate: Callable[[], Mapping[str, float]] | None = None


def matrix(R: npt.ArrayLike, p: npt.ArrayLike) -> Floats:
    """Return the pose with a rotation, shape (3, 3) or nine numbers by rows, and a position."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.reshape(R, (3, 3)), p
    return T


def from_wxyz(quaternion: npt.ArrayLike, p: npt.ArrayLike) -> Floats:
    """Return the pose with a unit quaternion, scalar first, and a position."""
    w, x, y, z = np.asarray(quaternion, dtype=float) / np.linalg.norm(quaternion)
    R = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return matrix(R, p)


def examine(robot: Loaded, reference: Mapping[str, Any]) -> dict[str, Any]:
    """Return the row of a robot: its data in the tool, and their differences from the reference."""
    expected = dict(zip(reference["links"], np.moveaxis(np.array(reference["poses"]), 1, 0), strict=True))
    drivers, followers = reference["drivers"], reference["followers"]
    coupled, alone = dict[str, float](), dict[str, float]()
    for sample in range(len(reference["poses"])):
        values = {name: series[sample] for name, series in drivers.items()}
        both = values | {name: series[sample] for name, series in followers.items()}
        _worst(coupled, robot.poses(both), expected, sample)
        # If the tool couples mimic joints itself, the poses are right although the given values of these joints are 0.
        _worst(alone, robot.poses(values | dict.fromkeys(followers, 0.0)), expected, sample)
    fingers = [link for link in alone if "Finger" in link or "Thumb" in link]
    feet = [link for link in alone if link in ("l_ankle", "r_ankle")]
    groups = {"hips": (feet, [name for name in followers if "Hip" in name])}
    groups["fingers"] = fingers, [name for name in followers if "Hip" not in name]
    held, told = set(robot.held), set(robot.told)
    couplings = dict[str, str]()
    for group, (links, joints) in groups.items():
        follows = max((alone[link] for link in links), default=np.inf) < SAME_POSE
        bound = "constraint" if held.issuperset(joints) else "told" if told.issuperset(joints) else "free"
        couplings[group] = "held" if follows else bound
    return {
        "loads": "yes",
        "frames": len(coupled),
        "fk_error": max(coupled.values(), default=float("nan")),
        "mass": robot.mass,
        "meshes": robot.meshes,
        **couplings,
        "simulates": None if robot.simulate is None else _simulated(robot.simulate(), held, reference["couplings"]),
    }


def _worst(errors: dict[str, float], poses: Poses, expected: Mapping[str, Floats], sample: int) -> None:
    """Update the largest error of each frame with that of this sample; poses are relative to the trunk."""
    T_trunk_world = np.linalg.inv(poses["torso"])
    for link in poses.keys() & expected.keys():
        error = float(np.abs(T_trunk_world @ poses[link] - expected[link][sample]).max())
        errors[link] = max(errors.get(link, 0.0), error)


def _simulated(angles: Mapping[str, float], held: set[str], couplings: Mapping[str, Any]) -> str:
    if not np.isfinite(list(angles.values())).all():
        return "angles are not finite"
    for follower in sorted(held):
        driver, multiplier, offset = couplings[follower]
        apart = abs(angles[follower] - multiplier * angles[driver] - offset)
        if apart > SAME_ANGLE:
            return f"{follower} is {apart:.2g} rad away from {driver}"
    return "yes"
