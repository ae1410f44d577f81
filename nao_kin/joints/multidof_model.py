"""A robot model with universal and spherical joints, with the same motion as the robot's own joints."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, Literal, get_args

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from nao_kin._core.arrays import UNIT_TOLERANCE, Floats, as_floats, choice, common_batch, first_index
from nao_kin.errors import BadArgument, DisagreeingJoints, UnknownName, at_index
from nao_kin.joints._assembly import Assembly
from nao_kin.joints._readings import (
    CouplingViolation,
    Mismatch,
    TurnSelection,
    angular_velocity_axes,
    coupling_violations,
    quaternion_of_turns,
    turns_of_quaternion,
)
from nao_kin.joints.grouping import Rule, group_joints, read_joint_tree
from nao_kin.joints.pairs import JointGroups, MultiDofJoint
from nao_kin.robot import Expression, Kinematics, RobotModel
from nao_kin.rotations import EulerAngles

CouplingPolicy = Literal["raise", "nearest"]
_POLICIES = ("raise", "nearest")
Intermediate = Literal["keep", "drop"]
_INTERMEDIATE = ("keep", "drop")


class MultiDofModel:
    """A robot whose runs of revolute joints are universal and spherical joints of a Pinocchio model.

    A configuration of the typed model, shape (..., nq), contains Pinocchio's coordinates of every joint in the order of
    the model: one value for a revolute or prismatic joint, two angles for a universal one, a unit quaternion (x, y, z,
    w) for a spherical one; `columns` gives their indices. Bodies, inertias, frame names and gravity are the robot's. So
    are the limits of revolute, prismatic and universal joints. The limits of a ball's three angles do not bound its
    quaternion; they are in `pairs`.

    The links between the axes of a merged joint are attached to `carriers`, revolute joints on a side branch. Carriers
    of a universal joint mimic it. Those of a ball have their own coordinates: `from_q` writes them, `to_q` reads them
    only where the limits leave a choice, and `from_q(to_q(q_typed))` makes them consistent. With intermediate="drop"
    there are no carriers: the links between the axes are left out, their masses are fixed to the body before the joint,
    and the model has the coordinates of its typed joints alone.

    Attributes:
        robot: the robot it was made from.
        model: the Pinocchio model. As with every fixed base, its `centerOfMass` leaves out the root link.
        groups: the merged joints, their couplings, and the joints that only follow.
        pairs: the merged joints, parents first, with the attributes that `JointGroups` lists.
        carriers: names of the joints that only carry links between the axes of merged joints.
        frame_names: its frames: those of the robot unless links were dropped.
        link_names: the links among them.
        notes: its differences from the robot, one sentence each; none unless links were dropped.
        columns: joint name → its part of a typed configuration.
        rows: joint name → its part of a typed velocity.

    Examples:
        >>> nao = nk.load_nao()
        >>> model = nk.joints.MultiDofModel(nao)
        >>> model.nq, model.nv
        (31, 29)
    """

    def __init__(
        self,
        robot: RobotModel,
        *,
        rule: Rule = "coincident",
        tolerance: float = 1e-9,
        intermediate: Intermediate = "keep",
    ) -> None:
        """Merge the joints of a robot.

        Args:
            robot: any robot.
            rule: which runs to merge, as in `group_joints`.
            tolerance: as in `group_joints`. If the axes of each joint meet to rounding, the model agrees with the robot
                to rounding. If they miss each other by up to r, rotations are still the robot's, and positions differ
                by up to 2 r for every merged axis on the way to the frame, but not with all joints at zero.
            intermediate: "keep" attaches the links between the axes of merged joints to carriers; all results are the
                robot's. "drop" leaves out these links and their frames: poses and Jacobians of all other frames and the
                total mass are the robot's; the centre of mass and the mass matrix are the robot's only where all merged
                joints are at zero, as `notes` says.

        Raises:
            BadArgument: as `group_joints`.
        """
        choice(intermediate, _INTERMEDIATE, "way with intermediate links")
        self.robot = robot
        self.groups: JointGroups = group_joints(robot, rule=rule, tolerance=tolerance)
        self.pairs: tuple[MultiDofJoint, ...] = self.groups.joints
        assembly = Assembly(robot, read_joint_tree(robot), self.groups, keep=intermediate == "keep")
        self._intermediate = intermediate
        self.model: pin.Model = assembly.model
        self.carriers = tuple(assembly.carriers)
        moving = {self.model.names[joint.id]: joint for joint in list(self.model.joints)[1:] if joint.nq > 0}
        columns = {name: slice(joint.idx_q, joint.idx_q + joint.nq) for name, joint in moving.items()}
        rows = {name: slice(joint.idx_v, joint.idx_v + joint.nv) for name, joint in moving.items()}
        self.columns: Mapping[str, slice] = MappingProxyType(columns)
        self.rows: Mapping[str, slice] = MappingProxyType(rows)
        self._slots, self._balls = tuple(assembly.slots), tuple(assembly.balls)
        self._base = (7, 6) if robot.base == "floating" else (0, 0)
        # Joint, or "base" → the column where its quaternion begins.
        self._quaternions = {"base": 3} if robot.base == "floating" else {}
        self._quaternions |= {ball.name: ball.column for ball in self._balls}
        self._selection = TurnSelection(self._balls, self._slots, assembly.followers, assembly.hints)
        # Index of a frame in the robot's model → its index in this model, whose first frames are the same.
        remaining = (i for i, frame in enumerate(robot.model.frames) if frame.parentJoint not in assembly.lumped)
        self._places = {theirs: own for own, theirs in enumerate(remaining)}
        self.frame_names = tuple(name for name, index in robot.frame_table.items() if index in self._places)
        self.link_names = tuple(name for name in robot.link_names if robot.frame_table[name] in self._places)
        self.notes = _notes(robot, assembly.lumped)
        self._kinematics = Kinematics(self.model)

    @property
    def nq(self) -> int:
        """Number of coordinates of a typed configuration."""
        return int(self.model.nq)

    @property
    def nv(self) -> int:
        """Number of velocity coordinates, including those of the carriers."""
        return int(self.model.nv)

    # --- configurations -------------------------------------------------------------------------------------------

    def neutral(self) -> Floats:
        """Return the configuration with all joints at zero, shape (nq,).

        Examples:
            >>> nk.joints.MultiDofModel(nk.load_nao()).neutral().shape
            (31,)
        """
        return self.from_q(self.robot.neutral())

    def from_q(self, q: ArrayLike) -> Floats:
        """Return the typed configuration (..., nq) of a configuration of the robot.

        Quaternions are products of the three turns' quaternions, and so continuous in the angles.

        Args:
            q: configurations of the robot, shape (..., robot.nq).

        Examples:
            >>> nao = nk.load_nao()
            >>> nk.joints.MultiDofModel(nao).from_q(nao.random(rng=0, n=4)).shape
            (4, 31)
        """
        values = self.robot.checked(q)
        typed = np.empty((*values.shape[:-1], self.nq))
        typed[..., : self._base[0]] = values[..., : self._base[0]]
        for slot in self._slots:
            typed[..., slot.column] = slot.joint.of(values)
        for ball in self._balls:
            typed[..., ball.column : ball.column + 4] = quaternion_of_turns(ball, ball.angles(values))
        return typed

    def to_q(self, q_typed: ArrayLike, *, near: ArrayLike | None = None, couplings: CouplingPolicy = "raise") -> Floats:
        """Return the configuration of the robot (..., robot.nq) for a typed configuration.

        A quaternion belongs to two triples of angles, each angle up to whole turns. Among all combinations, the first
        in this order is used: fewest followers that disagree with their drivers; nearest to `near`, or, without it,
        least outside the limits; nearest to the values of carriers and followers, whole turns included; nearest to
        the middle of the limits. So `to_q(from_q(q))` is q for every q inside limits, except for whole turns of the
        last angle of a ball, which has no carrier, when its limits span more than one turn and nothing follows it. At a
        lock, where a ball determines only the sum or the difference of its outer angles, more accurate values of joints
        of the same motor decide first, and then the same order.

        Revolute followers agree with their drivers up to whole turns, which do not change any pose. The whole turns
        considered are up to sixteen of a driver in each direction, and those nearest to the values of carriers and
        followers. Without limits, a joint has the value of its carrier, and the last angle of a ball is in [−π, π],
        unless a coupling requires more turns.

        Args:
            q_typed: typed configurations, shape (..., nq). The values of carriers are used only to resolve
                ambiguity.
            near: preferred configurations of the robot, shape (..., robot.nq).
            couplings: "raise" refuses joints of one motor that disagree by more than 1e-6 rad; "nearest" gives the
                motor the value that is nearest to all of them, and does not change the other angles.

        Raises:
            DisagreeingJoints: with couplings="raise".
            BadArgument: a quaternion, of a ball or of a floating base, whose norm is not 1 to 1e-6.

        Examples:
            >>> nao = nk.load_nao()
            >>> model = nk.joints.MultiDofModel(nao)
            >>> q = nao.posture("Stand")
            >>> np.allclose(model.to_q(model.from_q(q)), q)
            True
        """
        choice(couplings, _POLICIES, "couplings policy")
        q, mismatches, batch = self._read_typed(q_typed, near)
        if couplings == "raise":
            violations = coupling_violations(mismatches, batch)
            if violations:
                raise DisagreeingJoints(violations)
        for mismatch in mismatches:
            column = mismatch.follower.column
            q[:, column] = np.where(mismatch.violated, mismatch.nearest, q[:, column])
        return q.reshape(*batch, self.robot.nq)

    def violations(self, q_typed: ArrayLike, *, near: ArrayLike | None = None) -> tuple[CouplingViolation, ...]:
        """Return every pair of joints of one motor that disagree in a typed configuration, by configuration.

        Args:
            q_typed: typed configurations, shape (..., nq).
            near: as in `to_q`.

        Returns:
            The violations, each with its driving joint `primary` and the joint that follows it, `mimic`; their values
            `primary_value` and `mimic_value`; the `expected` value of the follower; the value of the driving joint
            that is `nearest` to the given ones; and the `index` of the configuration in the batch.

        Examples:
            >>> nao = nk.load_nao()
            >>> model = nk.joints.MultiDofModel(nao)
            >>> model.violations(model.from_q(nao.posture("Stand")))
            ()
        """
        _, mismatches, batch = self._read_typed(q_typed, near)
        return coupling_violations(mismatches, batch)

    def ball_angles(self, q_typed: ArrayLike, joint: str) -> EulerAngles:
        """Return both triples of angles of a spherical joint, as `davenport_angles` finds them.

        Args:
            q_typed: typed configurations, shape (..., nq).
            joint: name of the ball, or of one of its parts.

        Examples:
            >>> nao = nk.load_nao()
            >>> model = nk.joints.MultiDofModel(nao)
            >>> q = nao.configuration({"LHipYawPitch": -0.2, "LHipRoll": 0.1, "LHipPitch": -0.4})
            >>> model.ball_angles(model.from_q(q), "LHipRoll").angles.round(9).tolist()
            [-0.2, 0.1, -0.4]
        """
        typed = self._checked(q_typed)
        for ball in self._balls:
            if joint in (ball.name, *(part.name for part in ball.joints)):
                return turns_of_quaternion(ball, ball.quaternions(typed))
        raise UnknownName("spherical joint", joint, [ball.name for ball in self._balls])

    def velocity_matrix(self, q: ArrayLike) -> Floats:
        """Return E(q), shape (..., nv, robot.nv), with v_typed = E(q) v: typed velocities from the robot's.

        For revolute, prismatic and universal joints, and for carriers, the rates are the same: their rows of E contain
        a single 1 (or a follower's multiplier). For a ball with axes a1, a2, a3 E gives the angular velocity in the
        moved frame, ω = Rot(a3, −γ) Rot(a2, −β) a1 α' + Rot(a3, −γ) a2 β' + a3 γ'. The Jacobians are then J(q) =
        J_typed E(q), and the mass matrices M(q) = Eᵀ M_typed E.

        Args:
            q: configurations of the robot, shape (..., robot.nq).

        Examples:
            >>> nao = nk.load_nao()
            >>> nk.joints.MultiDofModel(nao).velocity_matrix(nao.neutral()).shape
            (29, 25)
        """
        values = self.robot.checked(q)
        E = np.zeros((*values.shape[:-1], self.nv, self.robot.nv))
        base = np.arange(self._base[1])
        E[..., base, base] = 1.0
        for slot in self._slots:
            E[..., slot.row, slot.joint.row] = slot.joint.coupling.multiplier
        for ball in self._balls:
            directions = angular_velocity_axes(ball, ball.angles(values))
            for k, joint in enumerate(ball.joints):
                E[..., ball.row : ball.row + 3, joint.row] = joint.coupling.multiplier * directions[..., k]
        return E

    # --- kinematics -----------------------------------------------------------------------------------------------

    def fk(self, q_typed: ArrayLike, frame: str | Sequence[str] | None = None) -> Floats:
        """Return poses of frames in the root's frame, as `RobotModel.fk` does.

        Args:
            q_typed: typed configurations, shape (..., nq).
            frame: a frame name of the robot, several, or None for all links in the order of `link_names`.

        Returns:
            Shape (..., 4, 4) for one name, (..., n, 4, 4) for several [m].

        Raises:
            BadArgument: a quaternion, of a ball or of a floating base, whose norm is not 1 to 1e-6.

        Examples:
            >>> nao = nk.load_nao()
            >>> model = nk.joints.MultiDofModel(nao)
            >>> q = nao.posture("Stand")
            >>> np.allclose(model.fk(model.from_q(q), "LLeg"), nao.fk(q, "LLeg"))
            True
        """
        typed = self._checked(q_typed)
        one = isinstance(frame, str)
        names = self.link_names if frame is None else (frame,) if one else frame
        poses = self._kinematics.poses(typed, self._frame_ids(names))  # type: ignore[arg-type]
        return poses[..., 0, :, :] if one else poses

    def jacobian(self, q_typed: ArrayLike, frame: str, expressed_in: Expression = "mixed") -> Floats:
        """Return the geometric Jacobian of a frame with respect to the velocities of the typed model.

        Args:
            q_typed: typed configurations, shape (..., nq).
            frame: a frame name of the robot.
            expressed_in: as in `RobotModel.jacobian`.

        Returns:
            J_typed, shape (..., 6, nv), linear rows first; J_typed E(q) is the robot's Jacobian.

        Examples:
            >>> nao = nk.load_nao()
            >>> model = nk.joints.MultiDofModel(nao)
            >>> q = nao.posture("Stand")
            >>> J = model.jacobian(model.from_q(q), "LLeg") @ model.velocity_matrix(q)
            >>> np.allclose(J, nao.jacobian(q, "LLeg"))
            True
        """
        choice(expressed_in, get_args(Expression), "expression")
        typed = self._checked(q_typed)
        (frame_id,) = self._frame_ids((frame,))
        return self._kinematics.jacobians(typed, frame_id, expressed_in)

    def com(self, q_typed: ArrayLike) -> Floats:
        """Return the centre of mass of the whole robot, root link included, in the root's frame, shape (..., 3) [m].

        Raises:
            BadArgument: the robot has no mass.

        Examples:
            >>> nao = nk.load_nao()
            >>> model = nk.joints.MultiDofModel(nao)
            >>> q = nao.posture("Stand")
            >>> np.allclose(model.com(model.from_q(q)), nao.com(q))
            True
        """
        return self._kinematics.centres_of_mass(self._checked(q_typed))

    # --- inside ---------------------------------------------------------------------------------------------------

    def _checked(self, q_typed: ArrayLike) -> Floats:
        """Return typed configurations with quaternions of norm 1 to rounding; a copy wherever there are any."""
        typed = as_floats(q_typed, (self.nq,), "q_typed")
        if not self._quaternions:
            return typed
        columns = np.array(list(self._quaternions.values()))[:, None] + np.arange(4)
        parts = typed[..., columns]
        norms = np.sqrt(np.sum(parts * parts, axis=-1))
        wrong = ~(np.abs(norms - 1.0) <= UNIT_TOLERANCE)
        if wrong.any():
            place = first_index(wrong)
            name, norm = list(self._quaternions)[place[-1]], f"{norms[place]:.8g}{at_index(place[:-1])}"
            raise BadArgument(f"{name} must be a unit quaternion (x, y, z, w), got one of norm {norm}")
        unit = np.array(typed)
        # The square of the norm would scale the rotation matrices.
        unit[..., columns] = parts / norms[..., None]
        return unit

    def _read_typed(self, q_typed: ArrayLike, near: ArrayLike | None) -> tuple[Floats, list[Mismatch], tuple[int, ...]]:
        """Return configurations (n, robot.nq), mismatches of followers, and the batch shape of n."""
        typed = self._checked(q_typed)
        target = None if near is None else self.robot.checked(near)
        batch = typed.shape[:-1]
        if target is not None:
            batch = common_batch("q_typed and near", batch, target.shape[:-1])
            target = np.broadcast_to(target, (*batch, self.robot.nq)).reshape(math.prod(batch), self.robot.nq)
        typed = np.broadcast_to(typed, (*batch, self.nq)).reshape(math.prod(batch), self.nq)
        angles, mismatches = self._selection.choose(typed, target)
        q = np.empty((len(typed), self.robot.nq))
        q[:, : self._base[0]] = typed[:, : self._base[0]]
        for slot in self._slots:
            if not slot.derived and slot.joint.mimic is None:
                q[:, slot.joint.column] = typed[:, slot.column]
        for joint in (joint for ball in self._balls for joint in ball.joints if joint.mimic is None):
            q[:, joint.column] = angles[joint.name]
        return q, mismatches, batch

    def _frame_ids(self, names: Sequence[str]) -> tuple[int, ...]:
        """Return the indices of frames in this model."""
        places = []
        for name, index in zip(names, self.robot.frame_ids(names), strict=True):
            if index not in self._places:
                raise UnknownName("frame", name, self.frame_names)
            places.append(self._places[index])
        return tuple(places)

    def __reduce__(self) -> tuple[Any, ...]:
        # A Pinocchio model with mimic joints cannot be pickled; the typed model is built again.
        rule, tolerance = self.groups.rule, self.groups.tolerance
        again = functools.partial(type(self), rule=rule, tolerance=tolerance, intermediate=self._intermediate)  # type: ignore[arg-type]
        return again, (self.robot,)

    def __repr__(self) -> str:
        dropped = ", links between dropped" if self._intermediate == "drop" else ""
        return f"<{type(self).__name__} {self.robot.name}: {self.groups.summary}, {self.groups.rule}{dropped}>"


def _notes(robot: RobotModel, lumped: Mapping[int, int]) -> tuple[str, ...]:
    """Return a sentence for every joint whose links are fixed to the body before the joint."""
    model = robot.model
    return tuple(
        f"{model.inertias[index].mass:.6g} kg carried by {model.names[index]} are fixed to the body "
        f"{f'carried by {model.names[before]}' if before else 'of the root'} as with all joints at zero; "
        "only in that configuration are the centre of mass and the mass matrix those of the robot"
        for index, before in sorted(lumped.items())
        if model.inertias[index].mass > 0.0
    )
