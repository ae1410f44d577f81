"""The joints between two frames of a robot as arrays: what the kernels need to know of it."""

from __future__ import annotations

import hashlib
import itertools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.robot import WORLD, RobotModel, joints_below, serial_chain
from nao_kin.semantics import CoupledLimit

Integers = NDArray[np.int64]

# Manipulability is counted in whole steps, so that sums do not depend on their order; its upper bound has this many.
_STEPS = 2**30
# Placements that differ by less come from another machine's trigonometry, not from another robot.
_DIGITS = 12


class ChainTables(NamedTuple):
    """A serial chain of n joints that c coordinates move, and the limits of those.

    Before joint k stands the placement k, and its axis is z there; the placement n leads from the last joint to the
    frame. The value of a joint is multiplier · coordinate + offset. Coordinates after the first `moving` move no joint
    of the chain: others' limits depend on them.

    Attributes:
        placements: shape (n + 1, 3, 4), rotation and translation [m].
        slides: which joints slide instead of turning, shape (n,).
        coordinate: which coordinate moves a joint, shape (n,).
        multiplier: shape (n,).
        offset: shape (n,) [rad or m].
        moving: number of coordinates that move the frame.
        low: smallest value of each coordinate drawn, shape (c,).
        high: largest value drawn, shape (c,).
        tables: limits that depend on another coordinate, in the order in which they are obeyed, shape (t, 4): the
            coordinate, the one it depends on, first bend, and the one after the last.
        bends: at, lower, upper, shape (b, 3).
    """

    placements: Floats
    slides: NDArray[np.bool_]
    coordinate: Integers
    multiplier: Floats
    offset: Floats
    moving: int
    low: Floats
    high: Floats
    tables: Integers
    bends: Floats


@dataclass(frozen=True, eq=False)
class MovedChain:
    """The joints that move a frame in a reference.

    Attributes:
        frame: name of the frame.
        reference: name of the reference.
        joints: names of the coordinates that are drawn.
        tables: the arrays.
    """

    frame: str
    reference: str
    joints: tuple[str, ...]
    tables: ChainTables

    @property
    def centre(self) -> Floats:
        """Where the first joint stands in the reference, shape (3,) [m]: the frame stays within `radius` of it."""
        return self.tables.placements[0, :, 3]

    @property
    def radius(self) -> float:
        """Length of the stretched chain [m]."""
        tables = self.tables
        links = np.linalg.norm(tables.placements[1:, :, 3], axis=-1).sum()
        ends = np.stack([tables.low, tables.high])[:, tables.coordinate] * tables.multiplier + tables.offset
        return float(links + np.abs(ends).max(axis=0)[tables.slides].sum()) * (1.0 + 1e-9)

    @property
    def manipulability_step(self) -> float:
        """A power of two: no manipulability of this chain has more than 2³⁰ steps of it.

        With r = min(3, moving), w² is at most the mean of the eigenvalues of J_v J_vᵀ to the power r, and their sum is
        that of the squared columns.
        """
        tables = self.tables
        longest = np.zeros(tables.moving)
        speeds = np.abs(tables.multiplier) * np.where(tables.slides, 1.0, self.radius)
        np.add.at(longest, tables.coordinate, speeds)
        rank = min(3, tables.moving)
        bound = (float(longest @ longest) / rank) ** (rank / 2)
        return 2.0 ** math.ceil(math.log2(bound / _STEPS)) if bound > 0.0 else 1.0

    @property
    def digest(self) -> str:
        """A fingerprint of geometry and limits, the same on every machine."""
        found = hashlib.sha256("\0".join(self.joints).encode())
        for part in self.tables:
            found.update((np.round(np.asarray(part, dtype=np.float64), _DIGITS) + 0.0).astype("<f8").tobytes())
        return found.hexdigest()


def moved_chain(robot: RobotModel, name: str, reference: str | None) -> MovedChain:
    """The chain that moves a frame.

    Args:
        robot: any robot; a floating base stays where it is.
        name: a frame, or a chain of the robot's semantics: the end effector that it carries, or its last link.
        reference: a frame; None or "world" for the root.

    Raises:
        UnknownName: no such frame or chain.
        BadArgument: nothing moves the frame in the reference, or a sliding joint has no limits.
    """
    frame = _frame_named(robot, name)
    if reference is not None and not isinstance(reference, str):
        raise UnknownName("frame", reference, robot.frame_names)
    is_root = reference is None or (reference == WORLD and WORLD not in robot.frame_names)
    root = robot.semantics.root if robot.semantics.root in robot.frame_names else robot.tree.root
    base = root if is_root or reference is None else reference
    chain = serial_chain(robot, base, frame)
    joints = list(chain.coordinates)
    if not joints:
        raise BadArgument(f"no joint moves {frame} in {base}")
    moving = len(joints)
    tables = _tables_of(robot, joints)
    column = {joint: index for index, joint in enumerate(joints)}
    low, high = _ranges(robot, joints)
    bends = [np.column_stack([table.at, table.lower, table.upper]) for table in tables]
    ends = list(itertools.accumulate(map(len, bends), initial=0))
    return MovedChain(
        frame,
        base,
        tuple(joints),
        ChainTables(
            placements=chain.placements,
            slides=np.array(chain.slides, dtype=np.bool_),
            coordinate=np.array([column.get(driver.joint, 0) for driver in chain.drivers], dtype=np.int64),
            multiplier=np.array([driver.multiplier for driver in chain.drivers], dtype=np.float64),
            offset=np.array([driver.offset for driver in chain.drivers], dtype=np.float64),
            moving=moving,
            low=low,
            high=high,
            tables=np.array(
                [(column[table.joint], column[table.of], *ends[i : i + 2]) for i, table in enumerate(tables)],
                dtype=np.int64,
            ).reshape(-1, 4),
            bends=np.concatenate(bends) if bends else np.zeros((0, 3)),
        ),
    )


def _frame_named(robot: RobotModel, name: str) -> str:
    if not isinstance(name, str) or (name not in robot.frame_names and name not in robot.chains):
        raise UnknownName("frame or chain", name, tuple(dict.fromkeys((*robot.chains, *robot.frame_names))))
    if name in robot.frame_names:
        return name
    names = robot.model.names
    carried = {
        effector: [names[i] for i in joints_below(robot, effector)[0]] for effector in robot.semantics.end_effectors
    }
    chain = robot.chains[name]
    found = [effector for effector, joints in carried.items() if chain[0] in joints]
    if found:
        return max(found, key=lambda effector: len(set(chain) & set(carried[effector])))
    return next(joint.child for joint in robot.tree.moving_joints if joint.name == chain[-1])


def _tables_of(robot: RobotModel, joints: list[str]) -> list[CoupledLimit]:
    """The tables of these joints in the robot's order; joints on which they depend are added to `joints`."""
    done = 0
    while done < len(joints):
        joints += [table.of for table in robot.coupled_limits if table.joint == joints[done] and table.of not in joints]
        joints[:] = dict.fromkeys(joints)
        done += 1
    return [table for table in robot.coupled_limits if table.joint in joints]


def _ranges(robot: RobotModel, joints: list[str]) -> tuple[Floats, Floats]:
    """Between which values the joints are drawn, by the rule of `RobotModel.random`."""
    columns = [robot.joint_names.index(joint) for joint in joints]
    lower, upper = robot.lower[columns], robot.upper[columns]
    for joint, column in zip(joints, columns, strict=True):
        bounded = math.isfinite(robot.lower[column]) and math.isfinite(robot.upper[column])
        if not bounded and robot.joint_units[column] != "rad":
            raise BadArgument(f"{joint} slides without limits: nothing bounds where it takes the frame")
    low = np.where(np.isfinite(lower), lower, np.where(np.isfinite(upper), upper - np.pi, -np.pi))
    high = np.where(np.isfinite(upper), upper, low + 2 * np.pi)
    return low, high
