"""The joint axes of a robot as lines of space, and the Jacobian they make: a second source beside Pinocchio's."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats
from nao_kin._common.vectors import rigid_inverse
from nao_kin.errors import UnknownName
from nao_kin.lines import PluckerLine, geometric_jacobian
from nao_kin.robot import Expression, RobotModel, check_robot, expression_named
from nao_kin.semantics import Mimic


class JointAxes:
    """All moving joints of a robot as lines: where their axes lie, and what they make of a motion.

    Positions come from the robot's forward kinematics, directions and couplings from its URDF.

    Attributes:
        robot: the robot.
        names: its m moving joints, those that follow another one included.
        sliding: which of them are prismatic, shape (m,).

    Raises:
        BadArgument: no robot model.

    Examples:
        >>> nao = nk.load_nao()
        >>> axes = nk.joints.JointAxes(nao)
        >>> len(axes.names), axes.names[0]
        (42, 'HeadYaw')
    """

    def __init__(self, robot: RobotModel) -> None:
        check_robot(robot)
        moving = robot.tree.moving_joints
        self.robot = robot
        self.names = tuple(joint.name for joint in moving)
        self.sliding: NDArray[np.bool_] = np.array([joint.kind == "prismatic" for joint in moving], dtype=np.bool_)
        self._directions = np.array([joint.axis for joint in moving], dtype=np.float64).reshape(-1, 3)
        self._above = {joint.child: joint for joint in robot.tree.joints}
        self._links_of_joints = {joint.name: joint.child for joint in moving}

    def lines(self, q: ArrayLike) -> PluckerLine:
        """The axes in the frame of the root, moments about its origin; batch shape (..., m), in the order of `names`.

        The line of a prismatic joint passes through the joint's own origin: only its direction matters.

        Args:
            q: configurations, shape (..., nq).

        Raises:
            WrongShape, NotFinite: q is no configuration.

        Examples:
            >>> nao = nk.load_nao()
            >>> lines = nk.joints.JointAxes(nao).lines(nao.neutral())
            >>> lines.direction[0].round(9).tolist()
            [0.0, 0.0, 1.0]
        """
        # A joint's frame is that of the link it moves.
        poses = self.robot.fk(q, [self._links_of_joints[name] for name in self.names])
        directions = np.einsum("...mij,mj->...mi", poses[..., :3, :3], self._directions)
        return PluckerLine.from_point_direction(poses[..., :3, 3], directions)

    def coupling(self, frame: str) -> Floats:
        """∂(value of a joint)/∂(coordinate), shape (m, n), with zero rows for joints that do not carry the frame.

        Columns are in the order of the robot's `joint_names`: a joint that follows another one has its multiplier in
        that one's column.

        Args:
            frame: a frame name.

        Raises:
            UnknownName: no such frame.

        Examples:
            >>> nao = nk.load_nao()
            >>> axes = nk.joints.JointAxes(nao)
            >>> axes.coupling("RLeg")[axes.names.index("RHipYawPitch")].nonzero()[0].tolist()
            [2]
        """
        carrying = self._carrying(frame)
        C = np.zeros((len(self.names), len(self.robot.joint_names)))
        for row, name in enumerate(self.names):
            if name in carrying:
                mimic = self.robot.mimics.get(name, Mimic(name))
                C[row, self.robot.joint_names.index(mimic.joint)] = mimic.multiplier
        return C

    def jacobian(self, q: ArrayLike, frame: str, expressed_in: Expression = "mixed") -> Floats:
        """What `RobotModel.jacobian` returns for the joints, made of nothing but the axes' Plücker coordinates.

        Args:
            q: configurations, shape (..., nq).
            frame: a frame name.
            expressed_in: as in `RobotModel.jacobian`.

        Returns:
            Shape (..., 6, n), columns in the order of `joint_names`; those of a floating base are left out.

        Raises:
            UnknownName: no such frame or expression.
            WrongShape, NotFinite: q is no configuration.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("Stand")
            >>> np.allclose(nk.joints.JointAxes(nao).jacobian(q, "LArm"), nao.jacobian(q, "LArm"))
            True
        """
        expression_named(expressed_in)
        coupling = self.coupling(frame)
        axes, pose = self.lines(q), self.robot.fk(q, frame)
        at = pose[..., :3, 3] if expressed_in == "mixed" else np.zeros(3)
        if expressed_in == "frame":
            axes = axes.transformed(rigid_inverse(pose)[..., None, :, :])
        return geometric_jacobian(axes, at=at, coupling=coupling, sliding=self.sliding)

    def _carrying(self, frame: str) -> set[str]:
        """The joints between the root and the frame."""
        if frame not in self.robot.frame_names:
            raise UnknownName("frame", frame, self.robot.frame_names)
        link = self.robot.tree.shared_names.get(frame, frame)
        link = link if link in self._above else self._links_of_joints.get(link, link)
        carrying = set()
        while link in self._above:
            carrying.add(self._above[link].name)
            link = self._above[link].parent
        return carrying
