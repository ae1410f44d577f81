"""What a probe hands over of a loaded robot, and how that is compared with the reference."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Poses = Mapping[str, Floats]

# Of a pose [m, and entries of the rotation], and of two coupled joints in a simulation [rad].
SAME_POSE = 1e-6
SAME_ANGLE = 0.01


@dataclass(frozen=True)
class Loaded:
    """A robot in a tool.

    Attributes:
        poses: angle of every joint → pose (4, 4) of every frame that the tool knows, in any common frame.
        mass: what the tool thinks that the robot weighs [kg]; None where it has no masses.
        meshes: how many meshes it shows; None where it shows none.
        held: joints that a constraint of the tool holds, in simulation or in a solver.
        told: joints of which the tool says what they follow, and leaves it to the caller.
        simulate: let it move for a moment; the angles of the joints afterwards. None where it does not simulate.
    """

    poses: Callable[[Mapping[str, float]], Poses]
    mass: float | None = None
    meshes: int | None = None
    held: Iterable[str] = ()
    told: Iterable[str] = ()
    simulate: Callable[[], Mapping[str, float]] | None = None


def matrix(R: npt.ArrayLike, p: npt.ArrayLike) -> Floats:
    """The pose of a rotation, shape (3, 3) or nine numbers by rows, and a position."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.reshape(R, (3, 3)), p
    return T


def from_wxyz(quaternion: npt.ArrayLike, p: npt.ArrayLike) -> Floats:
    """The pose of a unit quaternion, scalar first, and a position."""
    w, x, y, z = np.asarray(quaternion, dtype=float) / np.linalg.norm(quaternion)
    R = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return matrix(R, p)


def examine(robot: Loaded, reference: Mapping[str, Any]) -> dict[str, Any]:
    """The row of a robot: what it knows and how far that is from the reference."""
    expected = dict(zip(reference["links"], np.moveaxis(np.array(reference["poses"]), 1, 0), strict=True))
    drivers, followers = reference["drivers"], reference["followers"]
    coupled, alone = dict[str, float](), dict[str, float]()
    for sample in range(len(reference["poses"])):
        values = {name: series[sample] for name, series in drivers.items()}
        both = values | {name: series[sample] for name, series in followers.items()}
        _worst(coupled, robot.poses(both), expected, sample)
        # What follows by itself is right although its own value is not.
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
    """Raise the error of each frame to that of this sample, all seen from the trunk."""
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
