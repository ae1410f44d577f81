"""The kinematics of a robot: its frames, configurations, limits, poses, Jacobians and centres of mass."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Literal, SupportsIndex

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, DTypeLike, NDArray

from nao_kin._core.arrays import Floats, LimitPolicy, as_floats, choice, flag, limit_policy, texts
from nao_kin._core.guesses import Guessing
from nao_kin._core.sides import Hips, check_hips
from nao_kin.errors import BadArgument, NotFinite
from nao_kin.robot.build import Base, FrameIds, FrameTable, build_model, numbers_of, restore_numbers
from nao_kin.robot.configurations import (
    ConfigurationSpace,
    Coordinates,
    DataFrame,
    Series,
    joints_by_motor,
    motor_values,
    values_by_name,
    without_gaps,
)
from nao_kin.robot.joint_arrays import JointArrays
from nao_kin.robot.kinematics import (
    EXPRESSIONS,
    POSE_FORMS,
    Answers,
    Expression,
    Kinematics,
    Output,
    PoseForm,
    Question,
)
from nao_kin.robot.limits import JointLimits, LimitViolation
from nao_kin.robot.semantics import Mimic, Semantics
from nao_kin.robot.semantics_files import checked_semantics
from nao_kin.robot.urdf import UrdfTree

Frames = str | Sequence[str] | None


class KinematicRobot(Guessing):
    """The part of `RobotModel` that its shapes, soles and offsets are computed from; its attributes are there."""

    def __init__(self, tree: UrdfTree, semantics: Semantics | None = None, *, base: Base = "fixed") -> None:
        """Make a robot from the tree of its URDF, its semantics, and a "fixed" or "floating" base.

        Raises:
            BadModel: more joints than Pinocchio can take, or semantics that name missing parts.
        """
        self.model = model = build_model(tree, base)
        self.name, self.nq, self.nv = str(model.name), int(model.nq), int(model.nv)
        self.tree, self.urdf_path, self.load_notes = tree, tree.path, tree.notes
        self.base: Base = base
        self.mimics: Mapping[str, Mimic] = MappingProxyType(tree.mimics)
        own = {joint.name: joint for joint in tree.moving_joints if joint.mimic is None}
        self.joint_names: tuple[str, ...] = tuple(own)
        self.nq_base = self.nq - len(own)
        self.semantics = checked_semantics(semantics or Semantics(), tree)
        self.chains, self.coupled_limits = self.semantics.chains, self.semantics.coupled_limits
        self.posture_names: tuple[str, ...] = tuple(self.semantics.postures)
        self._units = {joint.name: "m" if joint.kind == "prismatic" else "rad" for joint in tree.moving_joints}
        self._units |= self.semantics.units
        self.joint_units = tuple(map(self._units.__getitem__, own))
        ends = [(joint.lower, joint.upper, joint.velocity, joint.effort) for joint in own.values()]
        limits: Floats = np.array(np.reshape(ends, (-1, 4)).T, dtype=np.float64, order="C")
        limits.flags.writeable = False
        self.lower, self.upper, self.velocity_limits, self.effort_limits = limits
        self._frames = FrameTable(model, tree, base)
        self.frame_names, self.link_names = self._frames.names, self._frames.link_names
        self.frame_table: Mapping[str, int] = self._frames.places
        self._limits = JointLimits(self.joint_names, self.lower, self.upper, self.joint_units, self.coupled_limits)
        self._coordinates = Coordinates(self.joint_names, self.mimics, self.semantics.chains, tree.fixed_joints)
        self._configurations = ConfigurationSpace(
            self._coordinates, self._limits, pin.neutral(model), self._units, self.semantics.postures
        )
        self._kinematics = Kinematics(model)
        self._answers = Answers(self._kinematics, tree, self._configurations)

    @property
    def mass(self) -> float:
        """Mass of the whole robot, root link included [kg]."""
        return self._kinematics.mass

    @property
    def joints(self) -> JointArrays:
        """All moving joints as arrays, mimic joints included: placements, axes, couplings, limits and masses.

        The table is made on first use, and again after a placement or mass in `model` has changed.
        """
        return self._answers.joints()

    @property
    def parameters(self) -> Any:
        """The published numbers from which the URDF was made; None if there are none."""
        return None

    def unit(self, joint: str) -> str:
        """Return the unit of any joint's value, mimic joints included: "rad", "m", or "1" for a ratio.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.unit("HeadYaw"), nao.unit("LHand")
            ('rad', '1')
        """
        if joint not in self._units:
            raise self._coordinates.unknown(joint)
        return self._units[joint]

    def mass_of(self, links: str | Sequence[str]) -> float:
        """Return the mass of some links together, or of one, as the file gives it [kg].

        Raises:
            UnknownName: a link that does not exist.
            BadArgument: the frame at the end of a chain in place of the chain's links.

        Examples:
            >>> nao = nk.load_nao()
            >>> round(nao.mass_of(["Neck", "Head"]), 3)
            0.738
        """
        named = [self.model.frames[index].name for index in self._frames.link_ids(links)]
        if len(named) == 1 and named[0] in self.chains and named[0] not in self.tree.inertials:
            moved = ", ".join(self.joints.links[self.joints.row(joint)] for joint in self.chains[named[0]])
            raise BadArgument(f"{named[0]} is a frame without mass; its chain moves the links {moved}")
        return float(sum(self.tree.inertials[link].mass for link in named if link in self.tree.inertials))

    def frame_ids(self, frames: Sequence[str] | None) -> FrameIds:
        """Return the indices of frames in Pinocchio's list; those of all links for None.

        Examples:
            >>> nao = nk.load_nao()
            >>> len(nao.frame_ids(["LArm", "RArm"]))
            2
        """
        return self._frames.ids(frames)

    def frame_placement(self, frame: str) -> tuple[int, Floats]:
        """Return the row in `joints` of the joint that carries a frame, −1 for the root, and T_joint_frame (4, 4) [m].

        Examples:
            >>> nao = nk.load_nao()
            >>> row, T_joint_frame = nao.frame_placement("LArm")
            >>> nao.joints.names[row], T_joint_frame[:3, 3].round(4).tolist()
            ('LWristYaw', [0.0578, 0.0, -0.0123])
        """
        (index,) = self._frames.ids([frame])
        place = self.model.frames[index]
        # The universe, and a floating base, come before the joints of the tree.
        return int(place.parentJoint) - (2 if self.base == "floating" else 1), np.array(place.placement.homogeneous)

    def columns(self, name: str) -> NDArray[np.intp]:
        """Return the columns of q that move a joint, the joints of a chain, or a frame, from the trunk outwards.

        A name that a chain and a frame share means the chain, as in `configuration`. A joint that follows another one
        has the column of that one. The columns of velocities and of Jacobians are these plus nv − nq.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.columns("LArm").tolist(), nao.columns("CameraTop").tolist(), nao.columns("RHipYawPitch").tolist()
            ([8, 9, 10, 11, 12, 13], [0, 1], [2])
        """
        table, known = self.joints, {**self.frame_table, **self.chains, **self._units}
        choice(name, known, "joint, chain or frame")
        if name in self.chains or name in self._units:
            rows = [table.row(joint) for joint in self.chains.get(name, (name,))]
        else:
            rows = table.path(self.frame_placement(name)[0])
        moving = [int(table.coordinates[row]) for row in rows if table.multipliers[row]]
        return np.array(list(dict.fromkeys(moving)), dtype=np.intp)

    # --- configurations -------------------------------------------------------------------------------------------

    def neutral(self) -> Floats:
        """Return the configuration with all joints at zero and a floating base at the world's origin; shape (nq,).

        The robot's frames are defined in this configuration. It need not be inside the limits; the documentation's page
        on conventions says when that counts.

        Examples:
            >>> nk.load_nao().neutral().shape
            (25,)
        """
        return self._configurations.neutral()

    def posture(
        self,
        name: str,
        angles: Mapping[str, ArrayLike] | DataFrame | Series | None = None,
        /,
        *,
        limits: LimitPolicy = "enforce",
        **joints: ArrayLike,
    ) -> Floats:
        """Return a predefined posture, with other values for some joints.

        Joints that the posture does not name are at zero. Only the limits of joints that `angles` and `joints` name are
        checked, coupled limits of one of them included.

        Args:
            name: one of `posture_names`.
            angles: joint or chain → value, as for `configuration`.
            limits: what to do with a named joint outside its limits: "enforce", "clamp", "ignore" or "measured".
            **joints: further joints or chains → value, for names that are Python identifiers.

        Returns:
            q, shape (nq,), or (..., nq) for values of a batch shape.

        Raises:
            OutsideLimits: a joint is outside its limits.
            CouplingViolated: two joints of one motor have different values.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("Stand", HeadYaw=0.3)
            >>> nao.angles(q)["HeadYaw"]
            0.3
            >>> nao.posture("Stand", HeadYaw=[-0.3, 0.0, 0.3]).shape
            (3, 25)
        """
        return self._configurations.posture(name, angles, joints, limits)

    def random(self, rng: np.random.Generator | int | None = None, n: int | tuple[int, ...] | None = None) -> Floats:
        """Return configurations inside all limits, as `RobotModel.random` does.

        Examples:
            >>> nk.load_nao().random(rng=0, n=(2, 3)).shape
            (2, 3, 25)
        """
        return self._configurations.random(rng, n)

    def configuration(
        self,
        angles: Mapping[str, ArrayLike] | DataFrame | Series,
        *,
        limits: LimitPolicy = "enforce",
        degrees: bool = False,
        hips: Hips | None = None,
        missing: str | float | None = None,
        ignore_other: bool = False,
    ) -> Floats:
        """Return the configuration with the given joint values; joints not named are at zero, or as `missing` says.

        A mimic joint may be named too: alone, it sets its driving joint; if both are named, they must agree, or `hips`
        decides. The name of a chain means its joints, from the trunk outwards.

        Args:
            angles: joint name → value, or an array of values of one batch shape [rad, m or ratio]; chain name →
                the values of its joints, shape (..., number of joints). Or a data frame of pandas or
                polars, or a row of one of pandas.
            limits: what to do with a named joint outside its limits: "enforce", "clamp", "ignore" or "measured".
            degrees: whether the values of turning joints are in degrees.
            hips: value of a motor whose two joints differ, such as the two HipYawPitch as a NAO's sensors measure them:
                "average", or "left" or "right" for the joint of that side; None refuses them.
            missing: values of joints that are not named or NaN, moved to the nearest limit: those of a posture, or a
                number [rad, m or ratio]; None refuses NaN. A motor of which one joint is NaN has the other's value.
            ignore_other: leave out names that are no joints, such as the fingers in messages of ROS.

        Returns:
            q, shape (..., nq), in radians whatever `degrees` says.

        Raises:
            CouplingViolated: two joints of one motor have different values, and `hips` is None.
            OutsideLimits: a named joint is outside its limits.
            WrongShape: batch shapes that do not broadcast.
            BadArgument: a joint named twice.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"HeadYaw": 0.3, "RArm": [1.4, -0.2, 1.2, 0.4, 0.0, 0.5]})
            >>> nao.angles(q)["RShoulderPitch"]
            1.4
            >>> measured = {"LHipYawPitch": -0.20, "RHipYawPitch": -0.21, "LHand": np.nan, "LFinger11": 0.0}
            >>> q = nao.configuration(measured, hips="average", missing="Stand", ignore_other=True)
            >>> round(nao.angles(q)["LHipYawPitch"], 3), round(nao.angles(q)["LHand"], 3)
            (-0.205, 0.3)
        """
        if hips is not None:
            check_hips(hips)
        if missing is not None or hips is not None or flag(ignore_other, "ignore_other"):
            gaps = missing is not None
            given = self._configurations.by_joint(angles, degrees, ignore_other=ignore_other, gaps=gaps)
            angles = given if missing is None else self.fill_missing(given, missing)
            angles = angles if hips is None else motor_values(self.mimics, angles, hips)
            degrees = False
        try:
            return self._configurations.configuration(angles, limits, degrees)
        except NotFinite as error:
            advice = "missing= gives its value" if math.isnan(error.value) else ""
            raise NotFinite(error.what, error.index, error.value, advice) from None

    def fill_missing(self, values: Mapping[str, Floats], missing: str | float) -> dict[str, Floats]:
        """Return values of joints without gaps: joint → values, with one for each motor.

        Args:
            values: joint → values, in which NaN is a gap.
            missing: values of the joints that are absent or NaN, as in `configuration`.

        Examples:
            >>> hands = nk.load_nao().fill_missing({"LHand": np.array([np.nan, 0.5])}, 0.1)
            >>> hands["LHand"].tolist(), len(hands)
            ([0.1, 0.5], 25)
        """
        given = values_by_name(values, self._coordinates)
        return without_gaps(self.mimics, given, self._configurations.joints_for(missing))

    def angles(self, q: ArrayLike, *, degrees: bool = False) -> dict[str, Floats | float]:
        """Return the values of the independent joints by name: the inverse of `configuration`.

        Args:
            q: configurations, shape (..., nq).
            degrees: whether to give the values of turning joints in degrees.

        Returns:
            name → float, or → array of the batch shape [rad, m or ratio].

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.angles(nao.configuration({"HeadYaw": 0.3}))["HeadYaw"]
            0.3
        """
        return self._configurations.angles(q, degrees)

    def joints_by_motor(self, names: Iterable[str]) -> dict[str, list[str]]:
        """Return driving joint → the joints among `names` that its motor moves, the driving joint first.

        Mimic joints with the multiplier 0 do not move and are left out.

        Examples:
            >>> nk.load_nao().joints_by_motor(["RHipYawPitch", "HeadYaw", "LHipYawPitch"])
            {'HeadYaw': ['HeadYaw'], 'LHipYawPitch': ['LHipYawPitch', 'RHipYawPitch']}
        """
        return joints_by_motor(self.mimics, texts(names, "names"))

    def motor_values(self, values: Mapping[str, Floats], hips: Hips = "average") -> dict[str, Floats]:
        """Return driving joint → values, from values of any joints; a mimic joint gives (value − offset) / multiplier.

        Args:
            values: joint → values, of one shape.
            hips: value of a motor of which several joints are given: "average", or "left" or "right" for the joint of
                that side, if it is given.

        Examples:
            >>> hips = {"LHipYawPitch": np.array([-0.2, -0.3]), "RHipYawPitch": np.array([-0.2, -0.4])}
            >>> nk.load_nao().motor_values(hips)["LHipYawPitch"].round(9).tolist()
            [-0.2, -0.35]
        """
        check_hips(hips)
        values = {name: as_floats(each, (), name) for name, each in values_by_name(values, self._coordinates).items()}
        return motor_values(self.mimics, values, hips)

    def checked(self, q: ArrayLike) -> Floats:
        """Return `q` as an array of configurations of this robot; limits are not checked.

        Args:
            q: configurations, shape (..., nq).

        Returns:
            Shape (..., nq), perhaps `q` itself; the quaternion of a floating base has norm 1 to the last digit.

        Raises:
            BadArgument: the quaternion of a floating base is not of unit length.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.checked([[0.0] * 25] * 2).shape
            (2, 25)
        """
        return self._configurations.checked(q)

    # --- limits ---------------------------------------------------------------------------------------------------

    def within_limits(
        self, q: ArrayLike, *, per_joint: bool = False, limits: Literal["enforce", "measured"] = "enforce"
    ) -> NDArray[np.bool_]:
        """Return which configurations are inside all limits, coupled ones included.

        For many configurations, `(~nao.within_limits(q, per_joint=True)).sum(axis=0)` counts the violations of each
        joint.

        Args:
            q: configurations, shape (..., nq).
            per_joint: whether to return one answer for each joint, in the order of `joint_names`.
            limits: "measured" accepts joints that exceed their limits as sensors show, 5° or 0.02 of a ratio.

        Returns:
            Shape (...), or with `per_joint` (..., n).

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"HeadYaw": [0.0, 3.0], "LElbowRoll": -0.5, "RElbowRoll": 0.5}, limits="ignore")
            >>> nao.within_limits(q).tolist()
            [True, False]
        """
        policy = limit_policy(limits, ("enforce", "measured"))
        inside = self._limits.inside(self._configurations.joints(q), policy)
        return inside if per_joint else np.asarray(inside.all(axis=-1))

    def limit_violations(self, q: ArrayLike, *, max_configurations: int | None = None) -> tuple[LimitViolation, ...]:
        """Return every joint outside its limits, by configuration and then by distance.

        Making one object per violation takes time and memory; for many configurations use `within_limits`, which
        returns arrays.

        Args:
            q: configurations, shape (..., nq).
            max_configurations: stop after this many configurations with a violation; None for all.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("Stand")
            >>> q[0] = 3.0
            >>> [violation.joint for violation in nao.limit_violations(q)]
            ['HeadYaw']
        """
        return self._limits.violations(self._configurations.joints(q), max_configurations=max_configurations)

    def check_limits(self, q: ArrayLike) -> Floats:
        """Return `q` as an array if every joint is inside its limits, coupled ones included.

        Raises:
            OutsideLimits: some joints are outside their limits; carries the violations.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.check_limits(nao.posture("Stand")).shape
            (25,)
        """
        return np.array(self._configurations.within(self._configurations.checked(q), "enforce"), order="C")

    def clamp(self, q: ArrayLike) -> Floats:
        """Return the nearest configurations inside the limits: each joint's own limits first, then coupled limits.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.clamp(nao.configuration({"HeadYaw": 3.0}, limits="ignore"))
            >>> round(nao.angles(q)["HeadYaw"], 3)
            2.086
        """
        return self._configurations.within(self._configurations.checked(q), "clamp")

    # --- poses, Jacobians and centres of mass ---------------------------------------------------------------------

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
        """Return poses of frames: T_reference_frame maps coordinates in the frame to coordinates in the reference.

        Args:
            q: configurations, shape (..., nq).
            frame: a frame name, several, or None for all links in the order of `link_names`.
            reference: the frame to express the poses in. None for the root: the trunk with a fixed base, the world
                with a floating one, where "world" means the same unless a frame has this name.
            limits: "ignore" for any joint values; "enforce" and "clamp" check the limits first.
            as_: "matrix" for homogeneous matrices; "quaternion" for (x, y, z, r0, r1, r2, r3), the quaternion scalar
                first and in canonical sign, as from `rotations.quat_from_matrix`; "rpy" for
                (x, y, z, roll, pitch, yaw) with R = Rz(yaw) Ry(pitch) Rx(roll), NAOqi's Position6D.
            dtype: precision of the result.
            out: array for the result.
            threads: how many threads may work on it.

        Returns:
            With one name, shape (..., 4, 4), (..., 7) or (..., 6); with n names, (..., n, 4, 4), (..., n, 7) or
            (..., n, 6) [m, rad].

        Raises:
            OutsideLimits: with limits="enforce", a joint is outside its limits.

        Examples:
            >>> nao = nk.load_nao()
            >>> T_torso_hand = nao.fk(nao.posture("StandInit"), "LArm")
            >>> T_torso_hand[:3, 3].round(3).tolist()
            [0.119, 0.133, -0.044]
            >>> nao.fk(nao.random(rng=0, n=5), ["LArm", "RArm"]).shape
            (5, 2, 4, 4)
        """
        one = isinstance(frame, str)
        ids, reference_id = self._frames.ids(frame), self._frames.reference_id(reference)
        choice(as_, POSE_FORMS, "form of a pose")
        if as_ == "matrix" and _is_plain(q, dtype, out, threads):
            q = self._configurations.posed(q) if limits == "ignore" else self._within(q, limits)
            if reference_id is None:
                poses = self._kinematics.poses(q, ids)
            else:
                poses = self._kinematics.relative_poses(q, ids, reference_id)
            return poses[0] if one else poses
        output = Output(dtype, out, threads)
        if limits != "ignore":
            output.check_no_overlap(q)
            q = self._within(q, limits)
        return self._of_frames("poses", as_, (q,), frame, output, reference)

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
        """Return rotations of frames, R_reference_frame; arguments as in `fk`, shape (..., 3, 3) or (..., n, 3, 3).

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.rotation(nao.neutral(), "CameraTop").shape
            (3, 3)
        """
        return self._of_frames("poses", "rotation", (q,), frame, Output(dtype, out, threads), reference)

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
        """Return origins of frames in the reference; arguments as in `fk`, shape (..., 3) or (..., n, 3) [m].

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.position(nao.neutral(), "LArm").round(4).tolist()
            [0.2187, 0.113, 0.0877]
        """
        return self._of_frames("poses", "position", (q,), frame, Output(dtype, out, threads), reference)

    def jacobian(
        self,
        q: ArrayLike,
        frame: str,
        expressed_in: Expression = "mixed",
        *,
        reference: str | None = None,
        dtype: DTypeLike | None = None,
        out: NDArray[Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> NDArray[Any]:
        """Return geometric Jacobians of a frame: J(q) · velocity = twist (linear; angular) with respect to the root.

        Args:
            q: configurations, shape (..., nq).
            frame: a frame name.
            expressed_in: "frame": twist at the frame's origin in the frame's axes; "mixed": at the frame's origin in
                the root's axes; "root": the spatial twist, at the root's origin in the root's axes.
            reference: a frame that takes the root's place, as in `fk`: the twist is then the frame's motion as observed
                from the reference, such as that of one hand in the other.
            dtype: precision of the result.
            out: array for the result.
            threads: how many threads may work on it.

        Returns:
            Shape (..., 6, nv): rows vx vy vz ωx ωy ωz, columns in the order of the velocities; the column of a driving
            joint includes the motion of its mimic joints [m/s and rad/s per unit of joint speed].

        Examples:
            >>> nao = nk.load_nao()
            >>> J = nao.jacobian(nao.posture("Stand"), "LArm")
            >>> J.shape, np.flatnonzero(J.any(axis=0)).tolist()
            ((6, 25), [8, 9, 10, 11, 12])
            >>> J = nao.jacobian(nao.posture("Stand"), "LArm", reference="LElbow")
            >>> np.flatnonzero(J.any(axis=0)).tolist()
            [11, 12]
        """
        choice(expressed_in, EXPRESSIONS, "expression")
        if reference is None and _is_plain(q, dtype, out, threads):
            return self._kinematics.jacobians(self._configurations.posed(q), self._frames.id(frame), expressed_in)
        reference_id = self._frames.reference_id(reference)
        question = Question("jacobian", (self._frames.id(frame),), reference_id, expressed_in)
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
        """Return twists of frames with respect to the root, J(q) · v, without computing the Jacobian.

        Args:
            q: configurations, shape (..., nq).
            v: velocities in the order of the Jacobian's columns, shape (..., nv); broadcasts with q. With a floating
                base, the first six are the linear and angular velocity of the base in its own axes.
            frame: a frame name, or several.
            expressed_in: as in `jacobian`.
            dtype: precision of the result.
            out: array for the result.
            threads: how many threads may work on it.

        Returns:
            (vx, vy, vz, ωx, ωy, ωz), shape (..., 6) for one name, (..., n, 6) for several [m/s, rad/s].

        Examples:
            >>> nao = nk.load_nao()
            >>> v = np.zeros(nao.nv)
            >>> v[nao.joint_names.index("HeadYaw")] = 1.0
            >>> nao.velocity(nao.neutral(), v, "CameraTop").round(4).tolist()
            [0.0, 0.0587, 0.0, 0.0, 0.0, 1.0]
        """
        choice(expressed_in, EXPRESSIONS, "expression")
        return self._of_frames("velocity", expressed_in, (q, v), frame, Output(dtype, out, threads))

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
        """Return the derivatives of the six numbers of `velocity`: J(q) · a + dJ/dt · v.

        With "mixed" these are the acceleration p̈ of the frame's origin and the angular acceleration, as observed from
        the root; an accelerometer in the frame shows Rᵀ(p̈ − g). With "frame" and "root" they are the spatial
        acceleration, which does not contain p̈ separately. `a` contains the derivatives of the numbers of v, shape
        (..., nv); the other arguments are as in `velocity`.

        Returns:
            Shape (..., 6) for one name, (..., n, 6) for several [m/s², rad/s²].

        Examples:
            >>> nao = nk.load_nao()
            >>> v = np.zeros(nao.nv)
            >>> v[nao.joint_names.index("HeadYaw")] = 1.0
            >>> nao.acceleration(nao.neutral(), v, 0 * v, "CameraTop")[:3].round(4).tolist()
            [-0.0587, 0.0, 0.0]
        """
        choice(expressed_in, EXPRESSIONS, "expression")
        return self._of_frames("acceleration", expressed_in, (q, v, a), frame, Output(dtype, out, threads))

    def com(
        self,
        q: ArrayLike,
        *,
        links: str | Sequence[str] | None = None,
        reference: str | None = None,
        dtype: DTypeLike | None = None,
        out: NDArray[Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> NDArray[Any]:
        """Return centres of mass, Σ mᵢ cᵢ / Σ mᵢ over links, shape (..., 3) [m]; other arguments as in `fk`.

        Args:
            q: configurations, shape (..., nq).
            links: the links, or one of them, with the masses of the file. None for the whole robot, root link included,
                with the masses in `model`.
            reference: the frame to express the centres in, as in `fk`.
            dtype: precision of the result.
            out: array for the result.
            threads: how many threads may work on it.

        Raises:
            UnknownName: a link that does not exist.
            BadArgument: the robot, or the links, have no mass.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("Stand")
            >>> nao.com(q).round(3).tolist()
            [0.005, 0.0, -0.052]
            >>> nao.com(q, links=["Neck", "Head"], reference="Neck").round(3).tolist()
            [-0.008, 0.001, 0.048]
        """
        if links is None and reference is None and _is_plain(q, dtype, out, threads):
            return self._kinematics.centres_of_mass(self._configurations.posed(q))
        question = Question("com", reference_id=self._frames.reference_id(reference))
        return self._answers_for(links).answer(question, (q,), Output(dtype, out, threads))

    def com_jacobian(
        self,
        q: ArrayLike,
        *,
        links: str | Sequence[str] | None = None,
        reference: str | None = None,
        dtype: DTypeLike | None = None,
        out: NDArray[Any] | None = None,
        threads: SupportsIndex | None = None,
    ) -> NDArray[Any]:
        """Return Jacobians of the centre of mass: J(q) · v is the derivative of `com` with the same arguments.

        Returns:
            Shape (..., 3, nv); columns as in `jacobian` [m/s per unit of joint speed], arguments as in `com`.

        Raises:
            UnknownName: a link that does not exist.
            BadArgument: the robot, or the links, have no mass.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.com_jacobian(nao.neutral()).shape
            (3, 25)
            >>> J = nao.com_jacobian(nao.posture("Stand"), reference="LFoot")
            >>> J[:, nao.joint_names.index("LAnklePitch")].round(3).tolist()
            [-0.242, 0.001, -0.011]
        """
        question = Question("com_jacobian", reference_id=self._frames.reference_id(reference))
        return self._answers_for(links).answer(question, (q,), Output(dtype, out, threads))

    # --- internal -------------------------------------------------------------------------------------------------

    def _answers_for(self, links: str | Sequence[str] | None) -> Answers:
        if links is None:
            return self._answers
        ids = self._frames.link_ids(links)
        if not ids:
            raise BadArgument("links must name at least one link; None means the whole robot")
        return self._answers.of_links(ids)

    def _within(self, q: ArrayLike, limits: str) -> Floats:
        return self._configurations.within(self._configurations.checked(q), limits)

    def _of_frames(
        self, kind: str, form: str, inputs: Sequence[Any], frame: Frames, output: Output, reference: str | None = None
    ) -> NDArray[Any]:
        question = Question(kind, self._frames.ids(frame), self._frames.reference_id(reference), form)
        return self._answers.answer(question, inputs, output, one=isinstance(frame, str))

    def __getstate__(self) -> dict[str, Any]:
        return {
            "tree": self.tree,
            "semantics": self.semantics,
            "base": self.base,
            "load_notes": self.load_notes,
            "numbers": numbers_of(self.model),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        KinematicRobot.__init__(self, state["tree"], state["semantics"], base=state["base"])
        self.load_notes = state["load_notes"]
        if state["numbers"] is not None:
            restore_numbers(self.model, state["numbers"])

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}: {self.nv} degrees of freedom, {len(self.link_names)} links>"


def _is_plain(q: ArrayLike, dtype: object, out: object, threads: object) -> bool:
    """Return whether the arguments are one configuration and no options, the case with a shortcut."""
    return type(q) is np.ndarray and q.ndim == 1 and dtype is None and out is None and threads is None
