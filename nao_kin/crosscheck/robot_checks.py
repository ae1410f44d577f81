"""The rows about the robot itself: poses by several implementations, single steps, and Jacobians."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
import pinocchio as pin

from nao_kin._common.arrays import Floats
from nao_kin._common.compiler import has_numba
from nao_kin.crosscheck.by_hand import HandRolled, Step
from nao_kin.crosscheck.comparisons import LEFT_OUT, Conversions, difference, largest
from nao_kin.crosscheck.mujoco_oracle import Oracle
from nao_kin.crosscheck.report import TOLERANCE, Tally
from nao_kin.crosscheck.samples import turns_about
from nao_kin.robot import RobotModel

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_EXPRESSIONS: tuple[Literal["frame", "root", "mixed"], ...] = ("frame", "root", "mixed")


class PoseChecks:
    """Forward kinematics by hand, by the robot's methods, by the batch kernels, by Pinocchio, by another reader.

    Attributes:
        frames: the frames that the steps and the robot have in common.
    """

    def __init__(self, robot: RobotModel, steps: Sequence[Step], conversions: Conversions, second: Oracle) -> None:
        self._robot, self._conversions, self._second = robot, conversions, second
        self._by_hand = HandRolled(steps, robot.joint_names, conversions)
        known = set(robot.frame_names)
        self._mine = [i for i, step in enumerate(steps) if step.name in known]
        self.frames = tuple(steps[i].name for i in self._mine)
        column = {name: i for i, name in enumerate(self.frames)}
        self._shared = tuple(name for name in second.frames if name in column)
        self._columns = [column[name] for name in self._shared]
        self._second_columns = [second.frames.index(name) for name in self._shared]
        self._direct = _DirectPinocchio(robot, self.frames)
        self._steps = _StepChecks(robot, self._by_hand, self.frames)

        left_out = len(second.left_out)
        note = (
            f"{left_out} frames left out: {second.name} reads a coupling or a sliding axis otherwise"
            if left_out
            else ""
        )
        self._by_hand_pinocchio = Tally("pose in the root, by hand", "Pinocchio")
        self._by_hand_second = Tally("pose in the root, by hand", second.name, note=note)
        self._pinocchio_second = Tally("pose in the root, by Pinocchio", second.name, note=note)
        # Without Numba there are no kernels, and Pinocchio would be compared with itself.
        self._has_kernels = has_numba()
        self._robot_pinocchio = Tally("pose in the root, by the robot", "pin.framesForwardKinematics")
        self._kernels_pinocchio = Tally("pose in the root, by the batch kernels", "pin.framesForwardKinematics")
        self._elementary = {axis: Tally(f"rot_{axis}", "pin.AngleAxis") for axis in _AXES}
        self._names = Tally("frame names", "Pinocchio")
        by_hand = {step.name for step in steps}
        names = sorted(by_hand | known)
        self._names.add(np.array([[float((name in by_hand) != (name in known)) for name in names]]), 0, names)

    @property
    def tallies(self) -> list[Tally]:
        """The rows, in the order of the report."""
        poses = [self._by_hand_pinocchio, self._by_hand_second, self._pinocchio_second]
        poses += [self._robot_pinocchio, *([self._kernels_pinocchio] if self._has_kernels else [])]
        elementary = self._elementary.values() if self._robot.joint_names else ()
        return [*poses, self._names, *self._steps.tallies, *elementary]

    def add(self, q: Floats, first: int) -> Floats:
        """Compare configurations (n, nq), the first of which has the index `first`.

        Returns:
            The robot's poses of `frames`, shape (n, frames, 4, 4).
        """
        T, direct = self._robot.fk(q, self.frames), self._direct.poses(q)
        try:
            by_hand = self._by_hand.poses(q)[:, self._mine]
        except Exception as error:  # of an elementary rotation under test
            self._by_hand_pinocchio.refuse(error)
            self._by_hand_second.refuse(error)
            by_hand = np.full(T.shape, np.inf)
        second = self._second.poses(q)[:, self._second_columns]
        self._by_hand_pinocchio.add(_pose_difference(by_hand, direct), first, self.frames)
        self._by_hand_second.add(_pose_difference(by_hand[:, self._columns], second), first, self._shared)
        self._pinocchio_second.add(_pose_difference(direct[:, self._columns], second), first, self._shared)
        self._robot_pinocchio.add(_pose_difference(T, direct), first, self.frames)
        if self._has_kernels:
            kernels = self._robot.fk(q, self.frames, threads=1)  # with a number of threads, never by Pinocchio
            self._kernels_pinocchio.add(_pose_difference(kernels, direct), first, self.frames)
        self._steps.add(direct, q, first)
        for axis, tally in self._elementary.items():
            tally.compare(
                functools.partial(self._elementary_difference, axis, q), len(q), first, self._robot.joint_names
            )
        return T

    def _elementary_difference(self, axis: str, q: Floats) -> Floats:
        angles = q.ravel()
        ours = getattr(self._conversions, f"rot_{axis}")(angles)
        return difference(ours, turns_about(_AXES[axis], angles)).reshape(q.shape)


class _DirectPinocchio:
    """Poses by Pinocchio itself, one configuration at a time."""

    def __init__(self, robot: RobotModel, frames: Sequence[str]) -> None:
        self._model, self._data = robot.model, robot.model.createData()
        ids: dict[str, int] = {}
        for index, frame in enumerate(robot.model.frames):
            if frame.type == pin.FrameType.BODY or frame.name not in ids:
                ids[frame.name] = index
        self._ids = [ids[name] for name in frames]

    def poses(self, q: Floats) -> Floats:
        """T_root_frame, shape (n, frames, 4, 4), for configurations of shape (n, nq)."""
        T = np.empty((len(q), len(self._ids), 4, 4))
        for row, configuration in zip(T, q, strict=True):
            pin.framesForwardKinematics(self._model, self._data, configuration)
            for pose, frame_id in zip(row, self._ids, strict=True):
                pose[:] = self._data.oMf[frame_id].homogeneous
        return T


class _StepChecks:
    """The rows about single steps: where a frame stands in the one that carries it, and what its joint does there.

    A wrong step moves everything behind it; only the rows of the step itself say which one it was. The motion of a
    joint is measured as M, the pose of its frame in its own pose at zero. A turn by v about e has vect M = sin v e and
    (tr M − 1)/2 = cos v; a slide has the displacement v e. How far a joint goes and along which axis it goes are two
    rows.
    """

    def __init__(self, robot: RobotModel, by_hand: HandRolled, frames: Sequence[str]) -> None:
        self._by_hand = by_hand
        self._column = {name: i for i, name in enumerate(frames)}
        steps = [step for step in by_hand.steps if step.name in self._column and step.parent in self._column]
        moving = [step for step in steps if step.axis is not None]
        self._own = [step for step in moving if step.name in robot.joint_names]
        self._followers = [step for step in moving if step.name not in robot.joint_names]
        self._wrong_travel: set[str] = set()
        self._axis = Tally("axis and sense of a joint", "Pinocchio")
        self._travel = Tally("travel of a joint", "Pinocchio")
        self._coupled = Tally("travel of a coupled joint", "Pinocchio")
        position = Tally("position in the carrying frame", "Pinocchio")
        orientation = Tally("orientation in the carrying frame", "Pinocchio")
        self._places = [position, orientation] if steps else []

        zero = robot.neutral()[None]
        T_zero = robot.fk(zero, frames)
        self._zero = {step.name: self._relative(T_zero, step) for step in steps}
        for step in steps:
            position.compare(functools.partial(self._position_difference, step, zero), 1, 0, [step.name])
            orientation.compare(functools.partial(self._orientation_difference, step, zero), 1, 0, [step.name])

    @property
    def tallies(self) -> list[Tally]:
        """The rows; none of what the robot has not."""
        rows = list(self._places)
        rows += [self._axis] if self._own or self._followers else []
        rows += [self._travel] if self._own else []
        return [*rows, self._coupled] if self._followers else rows

    def add(self, T: Floats, q: Floats, first: int) -> None:
        """Compare the poses T (n, frames, 4, 4) of configurations q (n, nq)."""
        for tally, joints in ((self._travel, self._own), (self._coupled, self._followers)):
            for joint in joints:
                travel, axis = self._motion_differences(joint, T, q)
                tally.add(travel[:, None], first, [joint.name])
                self._axis.add(axis[:, None], first, [joint.name])

    def _position_difference(self, step: Step, zero: Floats) -> Floats:
        return np.asarray(np.abs(self._by_hand.position(step, zero) - self._zero[step.name][1]).max())

    def _orientation_difference(self, step: Step, zero: Floats) -> Floats:
        return np.asarray(np.abs(self._by_hand.rotation(step, zero) - self._zero[step.name][0]).max())

    def _motion_differences(self, joint: Step, T: Floats, q: Floats) -> tuple[Floats, Floats]:
        """How far one joint goes too far, and how far it goes along another axis, two arrays (n,)."""
        (R, p), (R_zero, p_zero) = self._relative(T, joint), self._zero[joint.name]
        value = self._by_hand.value(joint, q) - (joint.mimic.offset if joint.mimic else 0.0)
        if joint.sliding:
            vector, sine = (p - p_zero) @ R_zero[0], value
            turned = np.zeros(len(q))
        else:
            M = np.swapaxes(R_zero, -1, -2) @ R
            vector, sine = _vect(M), np.sin(value)
            turned = np.abs(0.5 * (np.trace(M, axis1=-2, axis2=-1) - 1.0) - np.cos(value))
        length = np.sqrt(np.square(vector).sum(axis=-1))
        travel = largest(np.abs(length - np.abs(sine)), turned)
        along = length[:, None] * np.array(joint.axis)
        # Which sense is the right one cannot be seen of a joint that does not go as far as it should.
        if (travel > TOLERANCE).any():
            self._wrong_travel.add(joint.name)
        if joint.name in self._wrong_travel:
            axis = np.minimum(np.abs(vector - along).max(axis=-1), np.abs(vector + along).max(axis=-1))
        else:
            axis = np.abs(vector - np.sign(sine)[:, None] * along).max(axis=-1)
        return travel, np.asarray(axis)

    def _relative(self, T: Floats, step: Step) -> tuple[Floats, Floats]:
        """Rotations (n, 3, 3) and origins (n, 3) of a step in the frame that carries it."""
        T_frame, T_parent = T[:, self._column[step.name]], T[:, self._column[str(step.parent)]]
        R_parent_transposed = np.swapaxes(T_parent[:, :3, :3], -1, -2)
        apart = (T_frame - T_parent)[:, :3, 3]
        return R_parent_transposed @ T_frame[:, :3, :3], (R_parent_transposed @ apart[..., None])[..., 0]


class JacobianChecks:
    """One row for each way to express a Jacobian: the columns are the axes' Plücker coordinates."""

    def __init__(self, robot: RobotModel, conversions: Conversions, frames: Sequence[str]) -> None:
        self._robot, self._conversions, self._frames = robot, conversions, frames
        note = "each frame at one configuration in a hundred"
        ways = _EXPRESSIONS if robot.joint_names else ()
        self._tallies = {way: Tally(f"joint axes as lines, {way}", "Pinocchio", note=note) for way in ways}

    @property
    def tallies(self) -> list[Tally]:
        """The rows; none without joints."""
        return list(self._tallies.values())

    def add(self, q: Floats, first: int) -> None:
        """Compare every frame at one of the configurations (n, nq), another one for each frame."""
        for way, tally in self._tallies.items():
            apart = np.full((len(q), len(self._frames)), LEFT_OUT)
            for column, frame in enumerate(self._frames):
                row = (first + column) % len(q)
                try:
                    apart[row, column] = self._difference(q[row], frame, way)
                except Exception as error:  # of the joint axes under test
                    tally.refuse(error)
                    apart[row, column] = np.inf
            tally.add(apart, first, self._frames)

    def _difference(self, q: Floats, frame: str, way: Literal["frame", "root", "mixed"]) -> float:
        ours = np.asarray(self._axes.jacobian(q, frame, expressed_in=way))
        return float(difference(ours[None], self._robot.jacobian(q, frame, expressed_in=way)[None])[0])

    @functools.cached_property
    def _axes(self) -> Any:
        return self._conversions.joint_axes(self._robot)


def _pose_difference(ours: Floats, theirs: Floats) -> Floats:
    """Largest difference of any entry of poses (n, m, 4, 4), shape (n, m)."""
    return np.asarray(np.abs(ours - theirs).max(axis=(2, 3), initial=0.0))


def _vect(M: Floats) -> Floats:
    """The vector of the antisymmetric part, (m32 − m23, m13 − m31, m21 − m12)/2."""
    return 0.5 * np.stack(
        [M[..., 2, 1] - M[..., 1, 2], M[..., 0, 2] - M[..., 2, 0], M[..., 1, 0] - M[..., 0, 1]], axis=-1
    )
