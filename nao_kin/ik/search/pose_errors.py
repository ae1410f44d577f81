"""How far a frame is from where it should be, with the exact derivative."""

from __future__ import annotations

import weakref
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import NDArray

from nao_kin._common.arrays import Floats
from nao_kin._text import quoted
from nao_kin.errors import BadArgument
from nao_kin.ik.search.descent_equations import Chain
from nao_kin.robot import Expression, RobotModel, serial_chain
from nao_kin.rotations import left_jacobian_inverse, log, matrix_from_quat, quat_from_xyzw
from nao_kin.semantics import Mimic


class FrameMotion:
    """What moves a frame: some joints of a robot. All other joints and a floating base stay where they are.

    Attributes:
        frame: the frame.
        joints: places of the joints that move it in `RobotModel.joint_names`, from the base outwards, shape (m,).
        names: their names.
        columns: their places in q, shape (m,).
        velocity_columns: their places in velocities, shape (m,).

    Raises:
        UnknownName: no such frame.
        BadArgument: no joint moves the frame.
    """

    def __init__(self, robot: RobotModel, frame: str) -> None:
        # What is kept of a robot must not keep the robot.
        self._robot, self.frame = weakref.ref(robot), frame
        self._serial_chain = serial_chain(robot, robot.tree.root, frame)
        self.names = self._serial_chain.coordinates
        if not self.names:
            raise BadArgument(f"no joint moves {quoted(frame)}")
        self.joints = np.array([robot.joint_names.index(name) for name in self.names], dtype=np.intp)
        self._offset = robot.nq - len(robot.joint_names)
        self.columns = self._offset + self.joints
        self.velocity_columns = robot.nv - len(robot.joint_names) + self.joints

    @property
    def robot(self) -> RobotModel:
        """Whose frame it is."""
        return cast(RobotModel, self._robot())  # whoever asks has it

    @cached_property
    def chain(self) -> Chain:
        """The joints from the base to the frame, for scalar code."""
        chain = self._serial_chain
        place = {name: k for k, name in enumerate(self.names)}
        return Chain(
            joints=np.array([len(chain.drivers)], dtype=np.int64),
            links=chain.placements.reshape(-1).copy(),
            slides=np.array(chain.slides, dtype=np.float64),
            place=np.array([place.get(driver.joint, -1) for driver in chain.drivers], dtype=np.int64),
            ratio=np.array([driver.multiplier for driver in chain.drivers], dtype=np.float64),
            offset=np.array([driver.offset for driver in chain.drivers], dtype=np.float64),
        )

    def joint_values(self, q: Floats) -> Floats:
        """The values of all joints, shape (n, joints); a view."""
        return q[:, self._offset :]

    def poses(self, q: Floats) -> Floats:
        """T_root_frame, shape (n, 4, 4)."""
        if len(q) == 1:  # one configuration is answered in fewer steps
            return np.asarray(self.robot.fk(q[0], self.frame))[None]
        return np.asarray(self.robot.fk(q, self.frame))

    def jacobians(self, q: Floats, expressed_in: Expression = "mixed") -> Floats:
        """Twists of the frame for unit speeds of the joints that move it, shape (n, 6, m)."""
        if len(q) == 1:
            return np.asarray(self.robot.jacobian(q[0], self.frame, expressed_in)[None, :, self.velocity_columns])
        return np.asarray(self.robot.jacobian(q, self.frame, expressed_in)[..., self.velocity_columns])

    def moved(self, q: Floats, steps: Floats) -> Floats:
        """Configurations after steps of shape (n, m), limits not looked at."""
        result: Floats = q.copy()
        result[:, self.columns] += steps
        return result

    def in_base(self, poses: Floats, q: Floats) -> Floats:
        """T_base_frame from T_root_frame, shape (n, 4, 4): the same with a fixed base."""
        if self.robot.base == "fixed":
            return poses
        R = matrix_from_quat(quat_from_xyzw(q[:, 3:7])).swapaxes(-1, -2)
        moved: Floats = poses.copy()
        moved[:, :3, :3] = R @ poses[:, :3, :3]
        moved[:, :3, 3] = np.einsum("nij,nj->ni", R, poses[:, :3, 3] - q[:, :3])
        return moved

    def reach(self, q: Floats) -> tuple[Floats, float]:
        """Where the frame can be at most: a point that stays, shape (n, 3), and a distance from it [m].

        The point is the first joint's; the distance is that of the chain drawn out to a straight line, which the frame
        cannot exceed whatever the joints do. Infinite with a sliding joint that has no limits.
        """
        robot, model = self.robot, self.robot.model
        place = model.frames[robot.frame_ids([self.frame])[0]]
        chain, joint_id = [], int(place.parentJoint)
        while joint_id > 0 and (joint_id > 1 or robot.base == "fixed"):
            chain.append(joint_id)
            joint_id = int(model.parents[joint_id])
        distance = float(np.linalg.norm(place.placement.translation))
        distance += sum(float(np.linalg.norm(model.jointPlacements[index].translation)) for index in chain[:-1])
        slides = {joint.name for joint in robot.tree.moving_joints if joint.kind == "prismatic"}
        for name in slides & {str(model.names[index]) for index in chain}:
            mimic = robot.mimics.get(name, Mimic(name))
            driver = robot.joint_names.index(mimic.joint)
            ends = mimic.range(float(robot.lower[driver]), float(robot.upper[driver]))
            distance += max(map(abs, ends))
        first: Floats = np.broadcast_to(model.jointPlacements[chain[-1]].translation, (len(q), 3))
        if robot.base == "floating":
            R = matrix_from_quat(quat_from_xyzw(q[:, 3:7]))
            first = q[:, :3] + np.einsum("nij,nj->ni", R, first)
        return first, distance


class PoseErrors:
    """Weighted differences between the poses of a frame and its targets, in the axes of the targets.

    With the target (R_t, p_t) and the pose (R, p), e = w · (R_tᵀ (p_t − p); log(Rᵀ R_t)). The logarithm is the turn
    that is left to make; its coordinates are the same in the axes of the frame and of the target.

    Attributes:
        motion: what moves the frame.
        targets: T_root_target, shape (n, 4, 4).
        weights: of the six numbers, shape (6,).
    """

    def __init__(self, motion: FrameMotion, targets: Floats, weights: Floats) -> None:
        self.motion, self.targets, self.weights = motion, targets, weights

    def __call__(self, q: Floats, rows: NDArray[np.intp]) -> tuple[Floats, Floats]:
        """Errors and their derivatives.

        Args:
            q: configurations, shape (n, nq).
            rows: the target of each, shape (n,).

        Returns:
            Weighted errors, shape (n, 6), and what they change by for each unit of a step, shape (n, 6, m).
        """
        targets, poses = self.targets[rows], self.motion.poses(q)
        errors = _pose_errors(poses, targets)
        J = self.motion.jacobians(q)
        derivatives = np.empty_like(J)
        derivatives[:, :3] = -targets[:, :3, :3].swapaxes(-1, -2) @ J[:, :3]
        # The turn left to make is Rᵀ R_t, which a rotation of the frame changes from the left.
        derivatives[:, 3:] = -(left_jacobian_inverse(errors[:, 3:]) @ poses[:, :3, :3].swapaxes(-1, -2)) @ J[:, 3:]
        return errors * self.weights, derivatives * self.weights[:, None]

    def met(self, errors: Floats, tolerance: float) -> NDArray[np.bool_]:
        """Which weighted errors (n, 6) are small enough in what has a weight, shape (n,)."""
        scale = np.divide(1.0, self.weights, out=np.zeros(6), where=self.weights > 0.0)
        squares = np.square(errors * scale)
        return np.asarray((squares[:, :3].sum(axis=-1) <= tolerance**2) & (squares[:, 3:].sum(axis=-1) <= tolerance**2))

    def residuals(self, q: Floats) -> Floats:
        """Errors without weights of one configuration for each target, shape (n, 6) [m, rad]."""
        return _pose_errors(self.motion.poses(q), self.targets)


def _pose_errors(poses: Floats, targets: Floats) -> Floats:
    """(R_tᵀ (p_t − p); log(Rᵀ R_t)) of poses (n, 4, 4) and targets (n, 4, 4), shape (n, 6) [m, rad]."""
    R, R_target = poses[:, :3, :3], targets[:, :3, :3]
    errors = np.empty((len(poses), 6))
    errors[:, :3] = np.einsum("nji,nj->ni", R_target, targets[:, :3, 3] - poses[:, :3, 3])
    errors[:, 3:] = log(R.swapaxes(-1, -2) @ R_target)
    return errors
