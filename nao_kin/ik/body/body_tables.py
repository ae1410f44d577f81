"""A robot read into the arrays of `body`, and kept until somebody changes the numbers of its model."""

from __future__ import annotations

import math
import threading
import weakref

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik.body.body import SIDES, Body
from nao_kin.ik.body.stance import Legs
from nao_kin.ik.closed_forms.leg import leg_limb
from nao_kin.ik.geometry import Limb, torso_frame
from nao_kin.robot import ModelNumbers, RobotModel, check_robot, sole_corners


class BodyTables:
    """A robot as a `Body`, with what leads from its joints and frames there.

    Attributes:
        body: the arrays.
        order: place in q of each variable, shape (n,).
        turns: which variables may go round by whole turns, and everything is where it was, shape (n,).
        torso_in_root: T_root_torso, the torso's frame in the link that carries all, shape (4, 4).
    """

    def __init__(self, robot: RobotModel, legs: tuple[tuple[str, ...], tuple[str, ...]], enforce: bool) -> None:
        model = robot.model
        trunk = 1 if robot.base == "floating" else 0
        # Weakly, for what is kept for a robot must not keep the robot.
        self._robot, self.torso_in_root = weakref.ref(robot), self._placement(robot, torso_frame(robot))[1]
        moves = [unit == "rad" for unit in robot.joint_units]
        columns = np.argsort(np.logical_not(moves), kind="stable")
        self.order = robot.nq - len(moves) + columns
        variable = {robot.joint_names[int(column)]: k for k, column in enumerate(columns)}
        self._row = {joint: joint - trunk for joint in range(trunk, model.njoints)}
        rows = model.njoints - trunk
        T_torso_root = np.linalg.inv(self.torso_in_root)
        placements, levers = np.tile(np.eye(4), (rows, 1, 1)), np.zeros((rows, 3))
        axes, mass = np.zeros((rows, 3)), np.zeros(rows)
        parent, which = np.full(rows, -1, np.int64), np.full(rows, -1, np.int64)
        multiplier, offset = np.zeros(rows), np.zeros(rows)
        joint_of = {joint.name: joint for joint in robot.tree.moving_joints}
        for joint, row in self._row.items():
            inertia = model.inertias[joint]
            mass[row], levers[row] = inertia.mass, inertia.lever
            if row == 0:
                levers[0] = T_torso_root[:3, :3] @ inertia.lever + T_torso_root[:3, 3]
                continue
            name = str(model.names[joint])
            parent[row] = self._row[int(model.parents[joint])]
            T = np.array(model.jointPlacements[joint].homogeneous)
            placements[row] = T_torso_root @ T if parent[row] == 0 else T
            axes[row] = joint_of[name].axis
            mimic = robot.mimics.get(name)
            which[row] = variable[name if mimic is None else mimic.joint]
            multiplier[row], offset[row] = (1.0, 0.0) if mimic is None else (mimic.multiplier, mimic.offset)
        moving = int(np.count_nonzero(moves))
        tables = [table for table in robot.coupled_limits if max(variable[table.joint], variable[table.of]) < moving]
        table_rows = np.zeros((len(tables), 3, max([2, *(len(table.at) for table in tables)])))
        for k, table in enumerate(tables):
            table_rows[k, :, : len(table.at)] = table.at, table.lower, table.upper
        self.turns = np.arange(len(columns)) < moving
        self.turns[which[multiplier % 1.0 != 0.0]] = False
        unbounded = np.full(len(columns), math.inf)
        self.body = Body(
            parent,
            placements[:, :3, :3].copy(),
            placements[:, :3, 3].copy(),
            axes,
            which,
            multiplier,
            offset,
            mass,
            levers,
            np.array([[self._row[int(model.getJointId(joint))] for joint in leg] for leg in legs]),
            np.array([self.frame(f"{side}Leg")[1] for side in SIDES]),
            robot.lower[columns] if enforce else -unbounded,
            robot.upper[columns] if enforce else unbounded,
            moving,
            np.array([[variable[table.joint], variable[table.of]] for table in tables], np.int64).reshape(-1, 2),
            np.array([len(table.at) if enforce else 0 for table in tables], np.int64),
            table_rows,
        )

    @property
    def robot(self) -> RobotModel:
        """Whose tables these are."""
        robot = self._robot()
        if robot is None:
            raise ReferenceError("the robot of these tables is gone")
        return robot

    def frame(self, name: str) -> tuple[int, Floats]:
        """The row that carries a frame, and T of the frame in it.

        Raises:
            UnknownName: no such frame.
        """
        joint, T = self._placement(self.robot, name)
        row = self._row.get(joint, 0)
        return row, (np.linalg.inv(self.torso_in_root) @ T if row == 0 else T)

    def unwound(self, x: Floats, near: Floats | float) -> Floats:
        """Variables without whole turns: those that may go round within π of `near`, shape (..., n)."""
        turns = np.round((x - near) / (2.0 * math.pi))
        return np.asarray(np.where(self.turns & (turns != 0.0), x - 2.0 * math.pi * turns, x))

    @staticmethod
    def _placement(robot: RobotModel, name: str) -> tuple[int, Floats]:
        frame = robot.model.frames[robot.frame_ids([name])[0]]
        return int(frame.parentJoint), np.array(frame.placement.homogeneous)


class PreparedRobot:
    """All that whole-body poses need to know of a robot.

    Attributes:
        tables: as arrays, with and without limits.
        legs: the closed forms.
        corners: of the soles, by side, shape (k, 3) [m].
        rest: the configuration with all joints at zero, or at the limit nearest to it, shape (nq,).

    Raises:
        BadArgument: the robot has no legs of a NAO, or its soles have no outline.
    """

    def __init__(self, robot: RobotModel) -> None:
        limbs: list[Limb] = [leg_limb(robot, side, None) for side in SIDES]
        self.numbers = ModelNumbers(robot.model)
        joints = limbs[0].joints, limbs[1].joints
        self.tables = {enforce: BodyTables(robot, joints, enforce) for enforce in (True, False)}
        self.legs = Legs(limbs[0].numbers, limbs[1].numbers, limbs[0].ranges, limbs[1].ranges)
        self.corners = {side: sole_corners(robot, f"{side}Leg") for side in SIDES}
        self.rest = limbs[0].rest


_KEPT: weakref.WeakKeyDictionary[RobotModel, PreparedRobot] = weakref.WeakKeyDictionary()
_LOCK = threading.Lock()


def prepared(robot: RobotModel) -> PreparedRobot:
    """A robot, made ready; made anew when somebody has written into `robot.model`.

    Raises:
        BadArgument: no robot model, or one without the legs of a NAO.
    """
    check_robot(robot)
    with _LOCK:
        kept = _KEPT.get(robot)
        if kept is None or kept.numbers.changed():
            kept = _KEPT[robot] = PreparedRobot(robot)
    return kept
