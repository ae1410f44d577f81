"""The questions a robot model answers: poses, Jacobians, centres of mass, velocities and accelerations."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from nao_kin._core.arrays import Floats
from nao_kin.robot.answers import Answers, Output
from nao_kin.robot.checks import ConfigurationChecks
from nao_kin.robot.kinematics import (
    Expression,
    FrameTable,
    Kinematics,
    PoseForm,
    Question,
    check_expression,
    check_pose_form,
    expression_named,
)
from nao_kin.robot.limits import LimitPolicy, check_policy

WORLD = "world"


class KinematicMethods(ABC):
    """What every `RobotModel` answers about configurations q of shape (..., nq), with any leading batch shape.

    A few configurations are answered by Pinocchio; many by compiled kernels, which agree with it to 1e-12. The methods
    share three arguments.

    `dtype` is the precision of the result, np.float64 or np.float32; with float32, many configurations are also
    computed in it: poses, Jacobians and centres of mass to 2e-6 where joints are within a turn of zero; angles and
    rates of motion, which enlarge rounding, to several times that. None stands for that of `out`, or float64.

    `out` is an array to write the result into and return: of its shape and precision, contiguous, apart from the input.

    `threads` says how many threads may work on many configurations; None for all cores where that is worthwhile. With a
    number given, the kernels answer however few there are: the same bits for a configuration, whatever batch it is in.

    Examples:
        >>> nao = nk.load_nao()
        >>> isinstance(nao, nk.robot.KinematicMethods)
        True
    """

    _frames: FrameTable
    _kinematics: Kinematics
    _checks: ConfigurationChecks
    _answers: Answers

    def fk(
        self,
        q: ArrayLike,
        frame: str | Sequence[str] | None = None,
        *,
        reference: str | None = None,
        limits: LimitPolicy = "ignore",
        as_: PoseForm = "matrix",
        dtype: DTypeLike | None = None,
        out: NDArray[Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> NDArray[Any]:
        """Poses of frames: T_reference_frame maps coordinates in the frame to coordinates in the reference.

        Args:
            q: configurations, shape (..., nq).
            frame: a frame name, several, or None for all links in the order of `link_names`.
            reference: the frame to express the poses in. None for the root: the trunk with a fixed base, the world
                with a floating one. "world" names the latter in both cases.
            limits: "ignore" computes the pose wherever the joints are; "raise" and "clamp" look at the limits first.
            as_: "matrix" for homogeneous matrices; "position_quaternion" for (x, y, z, r0, r1, r2, r3), the quaternion
                scalar first and in canonical sign as `rotations.quat_from_matrix` has it; "position6d" for
                (x, y, z, roll, pitch, yaw) with R = Rz(yaw) Ry(pitch) Rx(roll), NAOqi's Position6D.
            dtype: precision of the result.
            out: where to write it.
            threads: how many threads may work on it.

        Returns:
            With one name homogeneous matrices of shape (..., 4, 4), (..., 7) or (..., 6); with n names
            (..., n, 4, 4), (..., n, 7) or (..., n, 6) [m, rad].

        Raises:
            UnknownName: no such frame or form.
            WrongShape, NotFinite: q is no configuration.
            OutsideLimits: with limits="raise".
            BadArgument: no such precision, or `out` or `threads` cannot be used.

        Examples:
            >>> nao = nk.load_nao()
            >>> T_torso_hand = nao.fk(nao.posture("StandInit"), "LArm")
            >>> T_torso_hand[:3, 3].round(3).tolist()
            [0.119, 0.133, -0.044]
            >>> nao.fk(nao.random(rng=0, n=5), ["LArm", "RArm"]).shape
            (5, 2, 4, 4)
        """
        one = isinstance(frame, str)
        ids = self._frames.ids((frame,) if one else frame)  # type: ignore[arg-type]
        if not _are_names(as_, limits):
            check_pose_form(as_)
            check_policy(limits)
        if as_ == "matrix" and _is_plain(q, dtype, out, threads):
            q = self._checks.posed(q) if limits == "ignore" else self._within(self._checks.checked(q), limits)
            if self._is_root(reference):
                poses = self._kinematics.poses(q, ids)
            else:
                poses = self._kinematics.relative_poses(q, ids, self._frames.id(reference))
            return poses[0] if one else poses
        check_pose_form(as_)
        output = Output(dtype, out, threads)
        if limits != "ignore":
            output.check_apart(q)
            q = self._within(self._checks.checked(q), limits)
        question = Question("poses", ids, self._reference_id(reference), as_)
        return self._answers.answer(question, (q,), output, one=one)

    def rotation(
        self,
        q: ArrayLike,
        frame: str | Sequence[str] | None = None,
        *,
        reference: str | None = None,
        dtype: DTypeLike | None = None,
        out: NDArray[Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> NDArray[Any]:
        """Rotations of frames, R_reference_frame; arguments as in `fk`, shape (..., 3, 3) or (..., n, 3, 3).

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.rotation(nao.neutral(), "CameraTop").shape
            (3, 3)
        """
        return self._part("rotation", q, frame, reference, Output(dtype, out, threads))

    def position(
        self,
        q: ArrayLike,
        frame: str | Sequence[str] | None = None,
        *,
        reference: str | None = None,
        dtype: DTypeLike | None = None,
        out: NDArray[Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> NDArray[Any]:
        """Positions of frame origins in the reference; arguments as in `fk`, shape (..., 3) or (..., n, 3) [m].

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.position(nao.neutral(), "LArm").round(4).tolist()
            [0.2187, 0.113, 0.0877]
        """
        return self._part("position", q, frame, reference, Output(dtype, out, threads))

    def jacobian(
        self,
        q: ArrayLike,
        frame: str,
        expressed_in: Expression = "mixed",
        *,
        dtype: DTypeLike | None = None,
        out: NDArray[Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> NDArray[Any]:
        """Geometric Jacobian of a frame with respect to the root: J(q) · velocity = twist (linear; angular).

        Args:
            q: configurations, shape (..., nq).
            frame: a frame name.
            expressed_in: "frame": twist at the frame's origin in the frame's axes; "mixed": at the frame's origin in
                the root's axes; "root": the spatial twist, at the root's origin in the root's axes.
            dtype: precision of the result.
            out: where to write it.
            threads: how many threads may work on it.

        Returns:
            Shape (..., 6, nv): rows vx vy vz ωx ωy ωz, columns in the order of the velocities; a joint that drives
            others carries their motion in its column [m/s and rad/s per unit of joint speed].

        Raises:
            UnknownName: no such frame or expression.
            WrongShape, NotFinite: q is no configuration.
            BadArgument: no such precision, or `out` or `threads` cannot be used.

        Examples:
            >>> nao = nk.load_nao()
            >>> J = nao.jacobian(nao.posture("Stand"), "LArm")
            >>> J.shape, np.flatnonzero(J.any(axis=0)).tolist()
            ((6, 25), [8, 9, 10, 11, 12])
        """
        if _is_plain(q, dtype, out, threads):
            q, expression = self._checks.posed(q), expression_named(expressed_in)
            return self._kinematics.jacobians(q, self._frames.id(frame), expression)
        check_expression(expressed_in)
        question = Question("jacobian", (self._frames.id(frame),), form=expressed_in)
        return self._answers.answer(question, (q,), Output(dtype, out, threads))

    def velocity(
        self,
        q: ArrayLike,
        v: ArrayLike,
        frame: str | Sequence[str],
        expressed_in: Expression = "mixed",
        *,
        dtype: DTypeLike | None = None,
        out: NDArray[Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> NDArray[Any]:
        """Twists of frames with respect to the root, J(q) · v, without making the Jacobian.

        Args:
            q: configurations, shape (..., nq).
            v: velocities in the order of the Jacobian's columns, shape (..., nv); broadcasts with q. Of a floating
                base, the first six are its linear and angular velocity in its own axes.
            frame: a frame name, or several.
            expressed_in: as in `jacobian`.
            dtype: precision of the result.
            out: where to write it.
            threads: how many threads may work on it.

        Returns:
            (vx, vy, vz, ωx, ωy, ωz), shape (..., 6) for one name, (..., n, 6) for several [m/s, rad/s].

        Raises:
            UnknownName: no such frame or expression.
            WrongShape, NotFinite: q is no configuration, or v no velocity.
            BadArgument: shapes that do not broadcast, or options that cannot be used.

        Examples:
            >>> nao = nk.load_nao()
            >>> v = np.zeros(nao.nv)
            >>> v[nao.joint_names.index("HeadYaw")] = 1.0
            >>> nao.velocity(nao.neutral(), v, "CameraTop").round(4).tolist()
            [0.0, 0.0587, 0.0, 0.0, 0.0, 1.0]
        """
        return self._motion("velocity", (q, v), frame, expressed_in, Output(dtype, out, threads))

    def acceleration(
        self,
        q: ArrayLike,
        v: ArrayLike,
        a: ArrayLike,
        frame: str | Sequence[str],
        expressed_in: Expression = "mixed",
        *,
        dtype: DTypeLike | None = None,
        out: NDArray[Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> NDArray[Any]:
        """The derivatives of the six numbers of `velocity`: J(q) · a + dJ/dt · v.

        In the "mixed" expression these are the acceleration of the frame's origin, p̈, and the angular acceleration, as
        an observer in the root sees them; what an accelerometer in the frame shows is Rᵀ(p̈ − g). In the "frame" and in
        the "root" they are the spatial acceleration, in which p̈ is not to be seen alone.

        Args:
            q: configurations, shape (..., nq).
            v: velocities, shape (..., nv).
            a: accelerations, the derivatives of the numbers of v, shape (..., nv).
            frame: a frame name, or several.
            expressed_in: as in `jacobian`.
            dtype: precision of the result.
            out: where to write it.
            threads: how many threads may work on it.

        Returns:
            Shape (..., 6) for one name, (..., n, 6) for several [m/s², rad/s²].

        Raises:
            UnknownName, WrongShape, NotFinite, BadArgument: as `velocity`.

        Examples:
            >>> nao = nk.load_nao()
            >>> v = np.zeros(nao.nv)
            >>> v[nao.joint_names.index("HeadYaw")] = 1.0
            >>> nao.acceleration(nao.neutral(), v, 0 * v, "CameraTop")[:3].round(4).tolist()
            [-0.0587, 0.0, 0.0]
        """
        return self._motion("acceleration", (q, v, a), frame, expressed_in, Output(dtype, out, threads))

    def com(
        self,
        q: ArrayLike,
        *,
        reference: str | None = None,
        dtype: DTypeLike | None = None,
        out: NDArray[Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> NDArray[Any]:
        """Centre of mass of the whole robot, the root link included.

        Args:
            q: configurations, shape (..., nq).
            reference: the frame to express it in, as in `fk`.
            dtype: precision of the result.
            out: where to write it.
            threads: how many threads may work on it.

        Returns:
            Position, shape (..., 3) [m].

        Raises:
            BadArgument: the robot has no mass, or options that cannot be used.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.com(nao.posture("Stand")).round(3).tolist()
            [0.005, 0.0, -0.052]
        """
        if reference is None and _is_plain(q, dtype, out, threads):
            return self._kinematics.centres_of_mass(self._checks.posed(q))
        question = Question("com", reference_id=self._reference_id(reference))
        return self._answers.answer(question, (q,), Output(dtype, out, threads))

    def com_jacobian(
        self,
        q: ArrayLike,
        *,
        dtype: DTypeLike | None = None,
        out: NDArray[Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> NDArray[Any]:
        """Jacobian of the centre of mass in the root's axes: J(q) · velocity = velocity of the centre of mass.

        Args:
            q: configurations, shape (..., nq).
            dtype: precision of the result.
            out: where to write it.
            threads: how many threads may work on it.

        Returns:
            Shape (..., 3, nv), columns as in `jacobian` [m/s per unit of joint speed].

        Raises:
            BadArgument: the robot has no mass, or options that cannot be used.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.com_jacobian(nao.neutral()).shape
            (3, 25)
        """
        return self._answers.answer(Question("com_jacobian"), (q,), Output(dtype, out, threads))

    # --- inside ---------------------------------------------------------------------------------------------------

    @abstractmethod
    def _within(self, q: Floats, limits: str) -> Floats:
        """Configurations after the limits were looked at."""

    def _is_root(self, reference: str | None) -> bool:
        """Whether `reference` is the root; a link that is called "world" is a link like any other."""
        return reference is None or (
            isinstance(reference, str) and reference == WORLD and WORLD not in self._frames.names
        )

    def _reference_id(self, reference: str | None) -> int | None:
        return None if self._is_root(reference) else self._frames.id(reference)

    def _part(
        self, part: str, q: ArrayLike, frame: str | Sequence[str] | None, reference: str | None, output: Output
    ) -> NDArray[Any]:
        one = isinstance(frame, str)
        ids = self._frames.ids((frame,) if one else frame)  # type: ignore[arg-type]
        question = Question("poses", ids, self._reference_id(reference), part)
        return self._answers.answer(question, (q,), output, one=one)

    def _motion(
        self, kind: str, inputs: Sequence[ArrayLike], frame: str | Sequence[str], expressed_in: str, output: Output
    ) -> NDArray[Any]:
        check_expression(expressed_in)
        one = isinstance(frame, str)
        question = Question(kind, self._frames.ids((frame,) if one else frame), form=expressed_in)  # type: ignore[arg-type]
        return self._answers.answer(question, inputs, output, one=one)


def _are_names(form: object, limits: object) -> bool:
    """Whether both are texts, for an array would be compared with a name entry by entry."""
    return isinstance(form, str) and isinstance(limits, str)


def _is_plain(q: ArrayLike, dtype: object, out: object, threads: object) -> bool:
    """Whether one configuration is asked about, and nothing else: to be answered in as few steps as possible."""
    return type(q) is np.ndarray and q.ndim == 1 and dtype is None and out is None and threads is None
