"""The joints of a robot as arrays: the one table from which programs, chains and bodies are made."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, whole_number
from nao_kin._core.text import one_line_repr
from nao_kin.errors import UnknownName, WrongShape
from nao_kin.robot.urdf import UrdfTree

ROOT = -1


@one_line_repr
@dataclass(frozen=True, eq=False)
class JointArrays:
    """The n moving joints of a robot, mimic joints included, as read-only arrays; parents precede their children.

    A joint's frame is the frame of the link that it moves. Its pose in the frame of its parent joint, or in the root
    link if it has none, is T_parent_joint = T_k M_k(s): placement T_k, and a turn about the axis (revolute) or a
    translation along it (prismatic) M_k by the joint's value s = multiplier · q[coordinate] + offset.

    All links that are fixed to each other make one body: one body of each joint, and one of the root. A floating base
    is not a joint of the table; its pose in the world is in the first seven entries of q.

    Attributes:
        names: names of the joints.
        links: the link that each joint moves.
        kinds: "revolute" or "prismatic".
        parents: row of the parent joint, −1 for the root, shape (n,).
        placements: T_parent_joint with the joint at zero, shape (n, 4, 4) [m].
        axes: unit vectors of the axes in the joints' frames, shape (n, 3).
        coordinates: index in q of the coordinate that moves each joint, shape (n,).
        columns: index in v of that coordinate's rate, and of its column in Jacobians, shape (n,).
        multipliers: change of the joint's value per change of the coordinate, shape (n,); 1 for an independent joint.
        offsets: value of the joint when the coordinate is zero, shape (n,) [rad, m].
        lower: smallest value of the joint, shape (n,) [rad, m].
        upper: largest value of the joint, shape (n,) [rad, m].
        velocity_limits: largest speed of the joint, shape (n,) [rad/s, m/s].
        masses: mass of each joint's body, shape (n,) [kg].
        centres_of_mass: centre of mass of each joint's body in the joint's frame, shape (n, 3) [m].
        inertias: rotational inertia of each joint's body about its centre of mass, in the axes of the joint's frame,
            shape (n, 3, 3) [kg m²].
        root_mass: mass of the root's body [kg].
        root_centre_of_mass: its centre of mass in the root link, shape (3,) [m].
        root_inertia: its rotational inertia about its centre of mass, in the axes of the root link, (3, 3) [kg m²].

    Examples:
        >>> joints = nk.load_nao().joints
        >>> k = joints.row("RHipYawPitch")
        >>> joints.kinds[k], joints.axes[k].round(3).tolist(), int(joints.parents[k])
        ('revolute', [0.0, 0.707, 0.707], -1)
        >>> nk.load_nao().joint_names[joints.coordinates[k]], float(joints.multipliers[k])
        ('LHipYawPitch', 1.0)
    """

    names: tuple[str, ...]
    links: tuple[str, ...]
    kinds: tuple[str, ...]
    parents: NDArray[np.intp]
    placements: Floats
    axes: Floats
    coordinates: NDArray[np.intp]
    columns: NDArray[np.intp]
    multipliers: Floats
    offsets: Floats
    lower: Floats
    upper: Floats
    velocity_limits: Floats
    masses: Floats
    centres_of_mass: Floats
    inertias: Floats
    root_mass: float
    root_centre_of_mass: Floats
    root_inertia: Floats

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @property
    def slides(self) -> NDArray[np.bool_]:
        """Which joints are prismatic, shape (n,)."""
        return np.array([kind == "prismatic" for kind in self.kinds], dtype=np.bool_)

    def row(self, name: str) -> int:
        """Return the row of a joint.

        Examples:
            >>> nk.load_nao().joints.row("HeadPitch")
            1
        """
        if name not in self.names:
            raise UnknownName("joint", name, self.names)
        return self.names.index(name)

    def limits(self, name: str) -> tuple[float, float, float]:
        """Return the smallest and the largest value of a joint, and its speed limit.

        Examples:
            >>> [round(limit, 3) for limit in nk.load_nao().joints.limits("RHipYawPitch")]
            [-1.145, 0.741, 4.162]
        """
        k = self.row(name)
        return float(self.lower[k]), float(self.upper[k]), float(self.velocity_limits[k])

    def path(self, row: int) -> list[int]:
        """Return the rows of the joints from the root to a joint, which is the last; none for −1, the root.

        Examples:
            >>> joints = nk.load_nao().joints
            >>> [joints.names[k] for k in joints.path(joints.row("LKneePitch"))]
            ['LHipYawPitch', 'LHipRoll', 'LHipPitch', 'LKneePitch']
        """
        path, row = [], whole_number(row, "row", ROOT, len(self.names) - 1)
        while row != ROOT:
            path.append(row)
            row = int(self.parents[row])
        return path[::-1]

    def paths(self, row: int, other: int) -> tuple[list[int], list[int]]:
        """Return the paths to two joints, or to the root, without the joints that are on both.

        Examples:
            >>> joints = nk.load_nao().joints
            >>> paths = joints.paths(joints.row("LShoulderRoll"), joints.row("LElbowRoll"))
            >>> [[joints.names[k] for k in path] for path in paths]
            [[], ['LElbowYaw', 'LElbowRoll']]
        """
        path, across = self.path(row), self.path(other)
        while path and across and path[0] == across[0]:
            path, across = path[1:], across[1:]
        return path, across

    def values(self, q: ArrayLike) -> Floats:
        """Return the values of all joints at configurations (..., nq), shape (..., n) [rad, m].

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.joints.values(nao.posture("Stand")).shape
            (42,)
        """
        q = as_floats(q, (), "q")
        if q.ndim == 0 or q.shape[-1] <= self.coordinates.max(initial=-1):
            raise WrongShape("q", "(..., nq)", q.shape)
        return np.asarray(q[..., self.coordinates] * self.multipliers + self.offsets)


def joint_arrays(model: pin.Model, tree: UrdfTree) -> JointArrays:
    """Return the joints of a model that `build_model` made from this tree, with the numbers that the model has now."""
    rows = tree.moving_joints
    own = {row.name: k for k, row in enumerate(row for row in rows if row.mimic is None)}
    couplings = [row.coupling for row in rows]
    driver = np.array([own[coupling.joint] for coupling in couplings], dtype=np.intp)
    moving = {row.name: row for row in rows}
    limits = np.empty((len(rows), 3))
    for limit, coupling in zip(limits, couplings, strict=True):
        motor, multiplier = moving[coupling.joint], coupling.multiplier
        # A multiplier of 0 holds the joint still even if the motor has no speed limit.
        limit[:] = *coupling.range(motor.lower, motor.upper), abs(multiplier) * motor.velocity if multiplier else 0.0
    # The universe, and a floating base, come before the joints of the tree.
    first = int(model.njoints) - len(rows)
    ids, inertias = range(first, int(model.njoints)), list(model.inertias)[first - 1 :]
    held, *bodies = [(float(body.mass), np.array(body.lever), np.array(body.inertia)) for body in inertias]
    return JointArrays(
        names=tuple(moving),
        links=tuple(row.child for row in rows),
        kinds=tuple(row.kind for row in rows),
        parents=np.array([int(model.parents[index]) - first for index in ids], dtype=np.intp),
        placements=np.array([model.jointPlacements[index].homogeneous for index in ids]).reshape(-1, 4, 4),
        axes=np.array([row.axis for row in rows], dtype=np.float64).reshape(-1, 3),
        coordinates=driver + (int(model.nq) - len(own)),
        columns=driver + (int(model.nv) - len(own)),
        multipliers=np.array([coupling.multiplier for coupling in couplings], dtype=np.float64),
        offsets=np.array([coupling.offset for coupling in couplings], dtype=np.float64),
        lower=limits[:, 0].copy(),
        upper=limits[:, 1].copy(),
        velocity_limits=limits[:, 2].copy(),
        masses=np.array([mass for mass, _, _ in bodies], dtype=np.float64),
        centres_of_mass=np.array([centre for _, centre, _ in bodies]).reshape(-1, 3),
        inertias=np.array([inertia for _, _, inertia in bodies]).reshape(-1, 3, 3),
        root_mass=held[0],
        root_centre_of_mass=held[1],
        root_inertia=held[2],
    )
