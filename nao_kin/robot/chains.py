"""The joints between two frames of a robot, one after the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.robot.build import rows_by_id
from nao_kin.robot.model import RobotModel, check_robot
from nao_kin.robot.semantics import Mimic
from nao_kin.robot.urdf import UrdfJoint


def joint_rows(robot: RobotModel) -> dict[int, UrdfJoint]:
    """Pinocchio's id → the joint of the file; the universe and a floating base, which come first, have none.

    Raises:
        BadArgument: no robot model.
    """
    check_robot(robot)
    return rows_by_id(robot.model, robot.tree)


@dataclass(frozen=True, eq=False)
class SerialChain:
    """n joints that lead from a base to a frame; a floating base stays where it is.

    Before joint k stands the placement k, and its axis is z there; the placement n leads from the last joint to the
    frame.

    Attributes:
        placements: rotation and translation, shape (n + 1, 3, 4) [m].
        slides: which joints slide instead of turning, n of them.
        drivers: for each joint, the coordinate that moves it, by the name of its joint, with multiplier and offset.
    """

    placements: Floats
    slides: tuple[bool, ...]
    drivers: tuple[Mimic, ...]

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Whose coordinates move the frame, from the base outwards; those of a follower that stands still do not."""
        return tuple(dict.fromkeys(driver.joint for driver in self.drivers if driver.multiplier != 0.0))

    def length(self, robot: RobotModel) -> float:
        """Return the way from the first joint to the frame, drawn out to a straight line [m].

        It is infinite with a sliding joint that has no limits.
        """
        total = float(np.linalg.norm(self.placements[1:, :, 3], axis=-1).sum())
        for slides, driver in zip(self.slides, self.drivers, strict=True):
            if slides:
                place = robot.joint_names.index(driver.joint)
                total += max(map(abs, driver.range(float(robot.lower[place]), float(robot.upper[place]))))
        return total


def serial_chain(robot: RobotModel, base: str, frame: str) -> SerialChain:
    """The joints between two frames.

    Raises:
        UnknownName: no such frame.
    """
    up, T_last_base = joints_below(robot, base)
    down, T_last_frame = joints_below(robot, frame)
    while up and down and up[0] == down[0]:  # joints that carry both
        up, down = up[1:], down[1:]
    rows = joint_rows(robot)
    placements, fixed, slides, drivers = [], np.linalg.inv(T_last_base), list[bool](), list[Mimic]()
    for joint_id, sign in (*((joint, -1.0) for joint in reversed(up)), *((joint, 1.0) for joint in down)):
        row, T_parent_joint = rows[joint_id], np.array(robot.model.jointPlacements[joint_id].homogeneous)
        turn, mimic = _z_along(row), row.coupling
        placements.append(fixed @ turn if sign < 0.0 else fixed @ T_parent_joint @ turn)
        fixed = turn.T @ np.linalg.inv(T_parent_joint) if sign < 0.0 else turn.T
        slides.append(row.kind == "prismatic")
        drivers.append(Mimic(mimic.joint, sign * mimic.multiplier, sign * mimic.offset))
    placements.append(fixed @ T_last_frame)
    return SerialChain(np.ascontiguousarray(np.array(placements)[:, :3]), tuple(slides), tuple(drivers))


def joints_below(robot: RobotModel, frame: str) -> tuple[list[int], Floats]:
    """Pinocchio's ids of the joints from the root to a frame, a floating base left out, and its pose in the last.

    Raises:
        UnknownName: no such frame.
    """
    rows, model = joint_rows(robot), robot.model
    place = model.frames[robot.frame_ids([frame])[0]]
    ids = [int(joint_id) for joint_id in model.supports[place.parentJoint] if joint_id in rows]
    return ids, np.array(place.placement.homogeneous)


def _z_along(row: UrdfJoint) -> Floats:
    """A rotation that takes z to the joint's axis; along an axis of the frame without rounding."""
    z = np.array(row.axis)
    x = np.zeros(3)
    x[(int(np.argmax(np.abs(z))) + 1) % 3] = 1.0
    x -= (x @ z) * z
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    return T


# --- How the joints of a robot hang together: serial chains, closed loops, couplings.


@dataclass(frozen=True)
class Topology:
    """The structure of a robot.

    Attributes:
        degrees_of_freedom: joints that can be moved on their own; a floating base is not counted.
        moving_joints: all joints that move, followers included.
        closed_loops: independent loops of the graph of links and joints, joints − links + 1; 0 for a tree.
        chains: the serial chains, each from the root outwards: the longest runs of joints without a branch. Joints that
            follow another one of their own limb are left out: they belong to a hand or a mechanism, not to a chain.
        couplings: joints that follow another one, and how, from the root outwards.
        couplings_between_limbs: those of them that follow a joint of another limb, as NAO's right HipYawPitch does; the
            fingers of a hand that follow its motor do not.

    Examples:
        >>> topology = nk.robot.topology(nk.load_nao())
        >>> topology.degrees_of_freedom, topology.moving_joints, topology.closed_loops
        (25, 42, 0)
        >>> topology.chains[0]
        ('HeadYaw', 'HeadPitch')
        >>> {joint: mimic.joint for joint, mimic in topology.couplings_between_limbs.items()}
        {'RHipYawPitch': 'LHipYawPitch'}
    """

    degrees_of_freedom: int
    moving_joints: int
    closed_loops: int
    chains: tuple[tuple[str, ...], ...]
    couplings: Mapping[str, Mimic]
    couplings_between_limbs: Mapping[str, Mimic]


def topology(robot: RobotModel) -> Topology:
    """The structure of a robot, read off its Pinocchio model; the loops are counted in its URDF.

    Raises:
        BadArgument: no robot model.

    Examples:
        >>> nk.robot.topology(nk.load_nao()).degrees_of_freedom
        25
    """
    rows = joint_rows(robot)
    # Joint → the joints from the root to it, itself the last.
    paths = {row.name: [rows[k].name for k in robot.model.supports[i] if k in rows] for i, row in rows.items()}
    names = list(paths)
    couplings = {name: robot.mimics[name] for name in names if name in robot.mimics}
    between_limbs = {name: mimic for name, mimic in couplings.items() if paths[name][0] != paths[mimic.joint][0]}
    left_out = couplings.keys() - between_limbs
    return Topology(
        degrees_of_freedom=len(robot.joint_names),
        moving_joints=len(names),
        closed_loops=len(robot.tree.joints) - len(robot.tree.links) + 1,
        chains=_serial_chains([name for name in names if name not in left_out], paths),
        couplings=couplings,
        couplings_between_limbs=between_limbs,
    )


def _serial_chains(names: list[str], paths: Mapping[str, Sequence[str]]) -> tuple[tuple[str, ...], ...]:
    above = {name: next((joint for joint in paths[name][-2::-1] if joint in names), None) for name in names}
    carried: dict[str | None, list[str]] = {}
    for name in names:
        carried.setdefault(above[name], []).append(name)
    chains = []
    for first in names:
        if above[first] is not None and len(carried[above[first]]) == 1:
            continue
        chain = [first]
        while len(carried.get(chain[-1], [])) == 1:
            chain.append(carried[chain[-1]][0])
        chains.append(tuple(chain))
    return tuple(chains)
