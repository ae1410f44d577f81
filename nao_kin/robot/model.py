"""A robot model: its parts, and the methods that answer questions about configurations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, SupportsIndex, TypeVar

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, DTypeLike, NDArray

from nao_kin._core.arrays import (
    TOUCHING,
    Floats,
    LimitPolicy,
    as_floats,
    check_kind,
    choice,
    flag,
    limit_policy,
    shaped,
    texts,
    whole_number,
)
from nao_kin._core.guesses import Guessing
from nao_kin._core.sides import Hips, check_hips
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, NotFinite, OtherRobotWarning
from nao_kin.robot.answers import Answers, Output
from nao_kin.robot.build import Base, build_model, numbers_of, restore_numbers
from nao_kin.robot.collisions import Clearance, CollisionRule, Contact, Obstacle, random_free
from nao_kin.robot.configurations import (
    ConfigurationSpace,
    Coordinates,
    DataFrame,
    Series,
    joints_by_motor,
    motor_values,
    values_by_name,
    with_shared_motors,
    without_gaps,
)
from nao_kin.robot.geometry import GeometryKind, geometry_model, unit_notes
from nao_kin.robot.ground import OutlineKind, SetDown, set_down, sole_outline
from nao_kin.robot.joint_arrays import JointArrays
from nao_kin.robot.kinematics import (
    EXPRESSIONS,
    POSE_FORMS,
    Expression,
    FrameIds,
    FrameTable,
    Kinematics,
    PoseForm,
    Question,
)
from nao_kin.robot.limits import JointLimits, LimitViolation
from nao_kin.robot.link_shapes import LinkShapes, Shape, shapes_of
from nao_kin.robot.mirror import mirror_image, mirrored
from nao_kin.robot.offsets import with_offsets
from nao_kin.robot.semantics import Mimic, Semantics
from nao_kin.robot.semantics_files import checked_semantics, find_semantics
from nao_kin.robot.support_polygon import SupportPolygon, support_polygon
from nao_kin.robot.urdf import Collision, UrdfTree, Visual, read_mjcf, read_robot, read_urdf

_Robot = TypeVar("_Robot", bound="RobotModel")


class RobotModel(Guessing):
    """A robot from a URDF or MJCF, with one coordinate for each joint that moves independently.

    Configurations are arrays q of shape (..., nq). With a fixed base, q holds the joint values in the order of
    `joint_names`. With a floating base, the seven numbers of Pinocchio's free-flyer precede them: the position of the
    base in the world and its orientation as a unit quaternion (x, y, z, w).

    All methods take any leading batch shape, return new arrays, and may be called from several threads concurrently.

    Pinocchio computes a few configurations; compiled kernels, which agree with it to 1e-12, compute many. The methods
    for poses, Jacobians, motions and centres of mass share three arguments:

    - `dtype`: precision of the result, np.float64 or np.float32; None for that of `out`, or float64. With float32, many
      configurations are also computed in float32. Poses, Jacobians and centres of mass are then accurate to 2e-6 where
      joints are within a turn of zero; angles and rates of motion, which enlarge rounding, to several times that.
    - `out`: an array for the result, which is also returned. It must have the shape and precision of the result, be
      contiguous, and not share memory with the input; otherwise BadArgument or WrongShape is raised.
    - `threads`: how many threads may compute many configurations; None for all cores where that is worthwhile. If it
      is a number, the kernels compute any batch, however small, and the result of a configuration is the same to the
      last bit in every batch.

    Attributes:
        model: the Pinocchio model, nq coordinates and nv velocities.
        tree: the URDF as read: links, joints, inertias and shapes.
        semantics: what the URDF lacks: chains, end effectors, postures, coupled limits.
        urdf_path: the file that was read.
        base: "fixed" or "floating".
        load_notes: changes made on loading, one line each.
        joint_names: names of the independent joints, in the order of q.
        joint_units: unit of each joint's value: "rad", "m", or "1" for a ratio.
        mimics: the joints that follow another one, by name.
        chains: named chains, each with its joints from the trunk outwards; empty without semantics.
        posture_names: the names that `posture` takes.
        frame_names: every name `fk` takes: links and joints. A joint's frame moves with the joint; a name that the URDF
            gives to a link and to a joint means the link.
        frame_table: frame name → index in Pinocchio's list, in the order of `frame_names`.
        link_names: the links, in the order in which `fk(q)` returns them.
        lower: smallest joint values, shape (n,).
        upper: largest joint values, shape (n,).
        velocity_limits: largest joint speeds, above 0, shape (n,); ∞ for a joint without a speed limit, which is also
            the meaning of a 0 in the file.
        effort_limits: largest joint torques or forces, shape (n,).
        coupled_limits: tables in which one joint's range depends on another's value.

    The limits are those of the file; changing them in `model` affects Pinocchio, not the checks of this class.

    Examples:
        >>> nao = nk.load_nao()
        >>> isinstance(nao, nk.RobotModel), nao.name, round(float(nao.upper[0]), 3)
        (True, 'nao_v6', 2.086)
    """

    def __init__(self, tree: UrdfTree, semantics: Semantics | None = None, *, base: Base = "fixed") -> None:
        """Make a robot from the tree of its URDF, its semantics, and a "fixed" or "floating" base.

        Raises:
            BadModel: more joints than Pinocchio can take, or semantics that name missing parts.
        """
        check_kind(tree, "tree", UrdfTree)
        check_kind(semantics, "semantics", (Semantics, type(None)))
        self.model = model = build_model(tree, base)
        self.tree, self.urdf_path, self.load_notes = tree, tree.path, tree.notes
        self.base: Base = base
        self.mimics: Mapping[str, Mimic] = MappingProxyType(tree.mimics)
        own = {joint.name: joint for joint in tree.moving_joints if joint.mimic is None}
        self.joint_names: tuple[str, ...] = tuple(own)
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
        self._link_shapes: LinkShapes | None = None

    # --- from files -----------------------------------------------------------------------------------------------

    @classmethod
    def from_file(
        cls,
        path: Path | str,
        *,
        base: Base = "fixed",
        semantics: Semantics | Path | str | None = None,
        package_dirs: Iterable[Path | str] = (),
        xacro: bool | None = None,
        xacro_arguments: Mapping[str, object] | None = None,
    ) -> RobotModel:
        """Return a robot from a URDF, xacro or MJCF file; the format is recognised by the content.

        Args:
            path: the file; it is read once, and may be a pipe.
            base: "fixed", or "floating" for a free base.
            semantics: chains, end effectors, postures …, as for `from_urdf`.
            package_dirs: folders to search for packages and meshes, as `from_urdf` and `from_mjcf` take them.
            xacro: whether to expand the file as a xacro source, as for `from_urdf`.
            xacro_arguments: values of the arguments of a xacro source, by name.

        Raises:
            BadModel: the file has none of the three formats, or its reader refuses it.
            MissingExtra: MuJoCo, which reads MJCF, is not installed.
            BadArgument: xacro arguments for a file that is not expanded.

        Examples:
            >>> robot = nk.RobotModel.from_file(nk.load_nao().urdf_path)
            >>> robot.nv, robot.load_notes
            (25, ())
        """
        tree, own = read_robot(path, package_dirs=package_dirs, xacro=xacro, xacro_arguments=xacro_arguments)
        return _loaded(tree, semantics, own, base)

    @classmethod
    def from_urdf(
        cls,
        path: Path | str,
        *,
        base: Base = "fixed",
        semantics: Semantics | Path | str | None = None,
        package_dirs: Iterable[Path | str] = (),
        xacro: bool | None = None,
        xacro_arguments: Mapping[str, object] | None = None,
    ) -> RobotModel:
        """Return a robot from any URDF, with every joint coupling.

        Descriptions that Pinocchio refuses are repaired (see `load_notes`): joints are ordered so that the driving one
        comes first, `continuous` joints become revolute ones without limits, axes are normalised, a link that shares
        its name with a joint is renamed ("…_link", or "…_frame" if that is taken) and found under both names. Meshes
        are not read. A xacro source is expanded if it is named .xacro or `xacro` asks for it (nao-kin[xacro]).

        Args:
            path: the URDF file, or its xacro source.
            base: "fixed", or "floating" for a free base.
            semantics: what the URDF lacks: a `Semantics`, or the path of a TOML file (as
                `nk.semantics.read_semantics` takes it) or of an SRDF. None for the .toml or .srdf file of the same name
                beside the URDF, or for the SRDF in its package's folder srdf that fits the robot; `load_notes` says
                which was found.
            package_dirs: ROS packages, or folders of packages, for `package://` and `$(find …)`; they are searched
                before the folders above the file, ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.
            xacro: whether to expand the file as a xacro source, which runs the code of its author; None to expand only
                files named .xacro.
            xacro_arguments: values of the arguments of a xacro source, by name.

        Raises:
            BadModel: the file cannot be read or describes no tree of revolute, continuous, prismatic and fixed joints;
                a xacro source cannot or must not be expanded; or the semantics name missing parts.
            BadInputFile: the TOML file cannot be read.
            BadArgument: a folder that does not exist, or arguments for a file that is not expanded.

        Examples:
            >>> robot = nk.RobotModel.from_urdf(nk.load_nao().urdf_path, base="floating")
            >>> robot.nq, robot.nv
            (32, 31)
        """
        tree = read_urdf(path, package_dirs=package_dirs, xacro=xacro, xacro_arguments=xacro_arguments)
        return _loaded(tree, semantics, None, base)

    @classmethod
    def from_mjcf(
        cls,
        path: Path | str,
        *,
        base: Base = "fixed",
        semantics: Semantics | Path | str | None = None,
        package_dirs: Iterable[Path | str] = (),
    ) -> RobotModel:
        """Return a robot from an MJCF, MuJoCo's own format, compiled by MuJoCo (nao-kin[mujoco]).

        Bodies become links; hinges and slides become joints, with MuJoCo's values; a ball joint becomes three joints
        about x, y and z; linear equality constraints between joints become couplings; sites and cameras become frames;
        named keyframes become postures. `load_notes` lists the parts that a tree of joints cannot express:
        closed loops, bodies that are not part of the robot, nonlinear couplings.

        Args:
            path: the MJCF file.
            base: "fixed", or "floating" for a free base; a free joint of the file is the joint of the base.
            semantics: as for `from_urdf`; a TOML or SRDF file takes precedence over the MJCF part by part, a
                `Semantics` replaces all parts.
            package_dirs: folders to search for meshes that are not where the file says.

        Raises:
            MissingExtra: MuJoCo is not installed.
            BadModel: the file cannot be read, is no MJCF, is refused by MuJoCo, or has no body; or the semantics name
                missing parts.
            BadInputFile: the TOML file cannot be read.
            BadArgument: a folder that does not exist.

        Examples:
            >>> panda = nk.RobotModel.from_mjcf("panda.xml")  # doctest: +SKIP
            >>> panda.fk(panda.posture("home"), "hand")  # doctest: +SKIP
        """
        tree, own = read_mjcf(path, package_dirs=package_dirs)
        return _loaded(tree, semantics, own, base)

    # --- properties -----------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the robot in its URDF."""
        return str(self.model.name)

    @property
    def nq(self) -> int:
        """Number of coordinates in q."""
        return int(self.model.nq)

    @property
    def nq_base(self) -> int:
        """Number of coordinates of the base, which are first in q: 7 of a floating base, 0 of a fixed one."""
        return self.nq - len(self.joint_names)

    @property
    def nv(self) -> int:
        """Number of velocity coordinates: the degrees of freedom."""
        return int(self.model.nv)

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
        if not isinstance(joint, str) or joint not in self._units:
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

    def with_offsets(
        self: _Robot,
        joints: Mapping[str, ArrayLike] | None = None,
        frames: Mapping[str, ArrayLike] | None = None,
        *,
        found_for: str | None = None,
    ) -> _Robot:
        """Return the same robot with calibrated joints and frames.

        The offsets are in the tree of the new robot, and so in its Pinocchio model, batch kernels, inverse kinematics
        and exports. Closed forms whose geometry no longer holds are refused with the reason; `nk.ik.numeric` takes any
        robot. New offsets add to the offsets that this robot already has. Changes in `model` are not copied.

        Args:
            joints: name → offset δ [rad; m for a sliding joint]. True value = reported value + δ, where q holds the
                reported value: `new.fk(q) == old.fk(q + δ)`. Each joint has its own mounting, so an offset of
                LHipYawPitch turns the left leg alone, and RHipYawPitch has its own offset. The limits of the reported
                values do not change.
            frames: name of a frame that is fixed to a link, such as a camera or hand → its true pose in the old frame,
                `T_link_new = T_link_old @ T_old_new`: a matrix, shape (4, 4), or (dx, dy, dz, roll, pitch, yaw),
                R = Rz(yaw) Ry(pitch) Rx(roll), in the axes of the old frame [m, rad]. Frames fixed to it move with it.
                The offset of a camera's optical frame is in the axes of that frame, and moves the whole camera.
            found_for: name of the robot that the offsets were found for, as files of `nk.calibration` say it. If this
                robot has another name, a warning says so; it may be the same robot with your own URDF.

        Raises:
            BadArgument: a frame that a joint moves, a value that is not a pose, or an angle of more than half a turn. A
                warning names offsets of more than 0.2 rad or 0.1 m, which no calibration finds.

        Examples:
            >>> nao = nk.load_nao()
            >>> mine = nao.with_offsets(joints={"HeadYaw": 0.01}, frames={"CameraTop": (0, 0, 0.002, 0, 0.02, 0)})
            >>> q = nao.configuration({"HeadYaw": 0.3})
            >>> np.allclose(mine.fk(q, "Head"), nao.fk(nao.configuration({"HeadYaw": 0.31}), "Head"))
            True
        """
        if not isinstance(found_for, str | None):
            raise BadArgument(f"found_for must be the name of a robot, got {quoted(found_for)}")
        if found_for is not None and found_for != self.name:
            warn_caller(f"these offsets were found for {found_for}, and this robot is {self.name}", OtherRobotWarning)
        given = {} if joints is None else joints, {} if frames is None else frames
        tree = with_offsets(self.tree, *given, self.semantics.cameras)
        notes = (*self.load_notes, *tree.notes[len(self.tree.notes) :])
        robot = type(self).__new__(type(self))
        robot.__setstate__({**self.__getstate__(), "tree": tree, "load_notes": notes, "numbers": None})
        return robot

    def geometry(self, kind: GeometryKind) -> pin.GeometryModel:
        """Return the shapes of the links as a new Pinocchio `GeometryModel`, placed on the joints of `model`.

        Pinocchio's visualizers draw it, and its collision library coal computes distances and collisions with it, after
        `addAllCollisionPairs` or `addCollisionPair`: it has no collision pairs yet.

        Args:
            kind: "visual" for the displayed shapes of the links, "collision" for their simplified shapes in contacts.

        Returns:
            One object per shape, named as Pinocchio's own parser names it: the link, "_", and its number from 0. A
            capsule is three shapes, a cylinder and two spheres.

        Warns:
            MissingShapeWarning: some shapes are left out, because their meshes are missing or they cannot be read.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.geometry("collision").ngeoms
            72
        """
        return geometry_model(self.model, self._frames, self.tree, kind)

    # --- configurations -------------------------------------------------------------------------------------------

    def neutral(self) -> Floats:
        """Return the configuration with all joints at zero and a floating base at the world's origin; shape (nq,).

        The robot's frames are defined in this configuration. It need not be inside the limits: the NAO's elbows stop 2°
        before zero.

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

        Joints that the posture does not name are at zero. Without `angles` and `joints` the limits are not checked;
        with them the whole posture is, because a coupled limit may link a named joint with another one.

        Args:
            name: one of `posture_names`.
            angles: joint or chain → value, as for `configuration`.
            limits: what to do with joints outside their limits: "enforce", "clamp", "ignore" or "measured".
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

    def random(
        self,
        rng: np.random.Generator | int | None = None,
        n: int | tuple[int, ...] | None = None,
        *,
        collision_free: bool | CollisionRule = False,
    ) -> Floats:
        """Return configurations inside all limits, coupled ones included, each joint uniform in its range.

        Joints without limits are uniform in [−π, π]; a floating base is at the world's origin.

        Args:
            rng: a generator, or a seed for one.
            n: how many, or a batch shape; None for one configuration of shape (nq,).
            collision_free: draw configurations again if links overlap, as `clearance` finds: True, or a
                `nk.robot.CollisionRule`.

        Returns:
            Configurations, shape (n…, nq).

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.random(rng=0, n=(2, 3))
            >>> q.shape, bool(nao.within_limits(q).all())
            ((2, 3, 25), True)
        """
        rule = CollisionRule.of(collision_free, "collision_free")
        if rule is not None:
            return random_free(self, rule, rng, n)
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
            BadArgument: batch shapes that do not broadcast, or a joint named twice.

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
            angles = angles if hips is None else with_shared_motors(self.mimics, angles, hips)
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

    def mirror(self, q: ArrayLike) -> Floats:
        """Return configurations mirrored at the plane between left and right, y = 0, which may be outside the limits.

        The mirror image of a point p is M p, with M = diag(1, −1, 1). The image of a joint that turns about the axis a
        turns about −M a: its value changes its sign if the joint on the other side has the opposite axis. A floating
        base at the position p with the rotation R goes to M p and M R M. `nk.motion.mirror` does the same with motions.

        Args:
            q: configurations, shape (..., nq).

        Returns:
            Shape (..., nq).

        Raises:
            UnknownName: a joint has no other side.
            BadArgument: the joint on the other side is not its mirror image, or a mimic joint does not follow as that.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.mirror(nao.configuration({"LShoulderRoll": 0.5, "HeadYaw": 0.2}, limits="ignore"))
            >>> nao.angles(q)["RShoulderRoll"], nao.angles(q)["HeadYaw"]
            (-0.5, -0.2)
        """
        return mirrored(self, self._configurations.checked(q))

    def mirror_image(self, joint: str) -> Mimic:
        """Return how a joint of the mirror image follows the joint on the other side: with the multiplier 1 or −1.

        Raises:
            UnknownName: the joint has no other side.
            BadArgument: the joint on the other side is not its mirror image, or a mimic joint does not follow as that.

        Examples:
            >>> nk.load_nao().mirror_image("LShoulderRoll")
            Mimic(joint='RShoulderRoll', multiplier=-1.0, offset=0.0)
        """
        return mirror_image(self, joint)

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
        limit = None if max_configurations is None else whole_number(max_configurations, "max_configurations", 0)
        return self._limits.violations(self._configurations.joints(q), max_configurations=limit)

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
            as_: "matrix" for homogeneous matrices; "position_quaternion" for (x, y, z, r0, r1, r2, r3), the quaternion
                scalar first and in canonical sign, as from `rotations.quat_from_matrix`; "position6d" for
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
        if not isinstance(limits, str):  # an array would be compared with a name entry by entry
            limit_policy(limits)  # type: ignore[unreachable]
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
        return self._answers.answer(Question("poses", ids, reference_id, as_), (q,), output, one=one)

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
        """Return origins of frames in the reference; arguments as in `fk`, shape (..., 3) or (..., n, 3) [m].

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
        return self._motion("acceleration", (q, v, a), frame, expressed_in, Output(dtype, out, threads))

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

    def support_polygon(
        self, q: ArrayLike, soles: Sequence[str] | None = None, *, reference: str | None = None
    ) -> SupportPolygon:
        """Return the convex hull of the soles on the floor, seen along the z axis of a frame on the floor.

        Args:
            q: one configuration, shape (nq,).
            soles: frames of the soles on the floor; None for all soles of the robot's semantics.
            reference: frame whose xy plane contains the polygon; None for the first of the soles.

        Returns:
            The polygon, with vertices in the xy plane of the reference [m]; its `signed_distance` takes points in that
            frame, such as the centre of mass.

        Raises:
            BadArgument: no soles; a sole without outline; soles without area.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("StandInit")
            >>> polygon = nao.support_polygon(q)
            >>> T_sole_torso = np.linalg.inv(nao.fk(q, nao.semantics.soles[0]))
            >>> com = T_sole_torso[:3, :3] @ nao.com(q) + T_sole_torso[:3, 3]
            >>> bool(polygon.signed_distance(com) > 0.02)
            True
        """
        return support_polygon(self, q, soles, reference)

    def sole_outline(self, sole: str, kind: OutlineKind = "sole") -> Floats:
        """Return the corners of a sole in its own frame, counter-clockwise, shape (k, 3) [m].

        "sole" is the area that touches the floor: the outline in the semantics; without one, the hull of the frames on
        the foot in the plane of the sole; without three of these, the hull of its visual shapes within 2 mm of their
        lowest point, at the height of that point. "sensors" is the hull of the frames on the foot in the plane of the
        sole, which `support_polygon` and the whole-body poses take: on a NAO the four force sensors, 100 mm long, 53 mm
        wide in front and 49 mm behind, inside the sole of 142 × 81 mm.

        Raises:
            BadArgument: the sole has no outline.

        Examples:
            >>> nao = nk.load_nao()
            >>> outline = nao.sole_outline("LLeg")
            >>> np.ptp(outline, axis=0).round(3).tolist()
            [0.142, 0.081, 0.0]
        """
        return sole_outline(self, sole, kind)

    def set_down(
        self,
        q: ArrayLike,
        *,
        soles: Sequence[str] | str | None = None,
        contacts: ArrayLike | None = None,
        forces: ArrayLike | None = None,
        gravity: ArrayLike | None = None,
        tolerance: float = TOUCHING,
    ) -> SetDown:
        """Set the robot down on the floor z = 0 as a rigid body; return its pose and the parts that touch the floor.

        With `gravity`, the vertical is known. With `soles`, the lowest of their corners is on the floor, wherever other
        links are; without `gravity`, the mean of the soles' normals is then vertical. `contacts` or `forces` do the
        same for each configuration, and all corners of the soles that carry touch the floor; a row in which none
        carries is set down as without them. With none of these arguments:

        1. The robot is put down on all soles, or on one of them, and turns over its edges until its centre of mass is
           above the corners on the floor. It stands if no other link is lower by more than 1 mm, and if it turns by at
           most 5° from a sole that the centre of mass is above, or by at most 1.5° onto another foot.
        2. Otherwise the nearest posture of the semantics is considered. If that posture rests on other links, the robot
           is put down with the vertical of the posture, and rolls over its edges until its centre of mass is above the
           area that touches the floor.
        3. In all other cases the robot stands on the soles from which it falls, with the mean of their normals
           vertical, or, if other links are then lower, its root is upright.

        Links other than the feet stay above the floor, so the soles of a robot that sits may be in the air. A robot
        that does not stand has the lowest point of its shapes and soles on the floor.

        Args:
            q: configurations, shape (..., nq). The pose of a floating base in them is not used.
            soles: frames of the soles on the floor; None for those of the robot's semantics.
            contacts: whether each of the s soles touches the floor, shape (..., s).
            forces: force on each sole, shape (..., s), or on each of the `force_sensors` of the semantics, shape
                (..., f), of any unit; a sole carries with at least 10 % of the total.
            gravity: direction of gravity in the frame of the root link, shape (..., 3), of any length but zero: the
                measurement of an accelerometer at rest with opposite sign. Broadcasts with q.
            tolerance: height up to which a point touches the floor [m].

        Returns:
            The pose T_world_base of the root link and the soles, corners and links that touch.

        Raises:
            BadArgument: the robot has neither soles nor shapes, or the soles face opposite directions.
            ZeroNorm: zero gravity.

        Examples:
            >>> nao = nk.load_nao()
            >>> down = nao.set_down(nao.posture("StandInit"))
            >>> down.touching.tolist(), down.T_world_base[:3, 3].round(3).tolist()
            ([True, True], [0.0, 0.0, 0.32])
        """
        return set_down(self, q, soles=soles, contacts=contacts, forces=forces, gravity=gravity, tolerance=tolerance)

    # --- self-collision -------------------------------------------------------------------------------------------

    @property
    def link_shapes(self) -> LinkShapes:
        """The shapes of the links for self-collision, and the pairs that are checked; prepared on first use."""
        if self._link_shapes is None:
            self._link_shapes = LinkShapes(self)
        return self._link_shapes

    def _collision_shapes(self) -> Iterable[Shape]:
        """Return the shapes of `link_shapes`: those of the collision elements, or of the visuals if there are none."""
        return shapes_of(self.tree)

    def _exact_shapes(self) -> tuple[Visual, ...] | tuple[Collision, ...]:
        """Return the shapes that the hulls of `link_shapes` contain."""
        return self.tree.collisions or self.tree.visuals

    def clearance(
        self,
        q: ArrayLike,
        *,
        tolerance: float = 0.0,
        allowed: Sequence[tuple[str, str]] = (),
        exact: bool = False,
        obstacles: Sequence[Obstacle] = (),
    ) -> Clearance:
        """Return the smallest distance between links, and the two links that have it.

        The shapes of a NAO are the convex hulls of its meshes. Those of another robot are its collision elements, or
        its visuals if it has none: balls, capsules (a cylinder with a sphere at each end) and the convex hulls of
        boxes, cylinders and meshes. Pairs of links that a joint connects, that always touch or that never touch are
        left out: the pairs in `semantics.disabled_collisions` (of an SRDF) or, if there are none, those found on the
        first call by the rules of `nk.export.srdf`.

        Args:
            q: configurations, shape (..., nq).
            tolerance: overlap that `is_free` accepts [m].
            allowed: pairs of links that may overlap, and are not checked.
            exact: whether coal compares the meshes where hulls overlap.
            obstacles: objects near the robot, made by `nk.robot.Obstacle`; each is compared with all links.

        Returns:
            Distances, shape (...) [m]. Where links overlap, the distance is negative: minus the length of the least
            translation that separates them.

        Raises:
            BadArgument: the robot has no shapes.

        Warns:
            MissingShapeWarning: some shapes are left out, because their meshes are missing or they cannot be read.

        Examples:
            >>> nao = nk.load_nao()
            >>> found = nao.clearance(nao.posture("StandInit", LShoulderRoll=-0.3, LElbowRoll=-1.2))
            >>> found.distance.round(4).tolist(), found.pair
            (-0.0028, ('LForeArm', 'torso'))
            >>> nao.clearance(nao.random(rng=0, n=1000)).is_free.sum().tolist()
            643
        """
        rule = CollisionRule(tolerance, allowed, exact, obstacles)
        shapes = self.link_shapes.among(rule.obstacles)
        checked = ~shapes.allowed(rule)
        return shapes.clearance(self.checked(q), tolerance=rule.tolerance, checked=checked, exact=exact)

    def collisions(
        self,
        q: ArrayLike,
        *,
        margin: float = 0.0,
        tolerance: float = 0.0,
        allowed: Sequence[tuple[str, str]] = (),
        exact: bool = False,
        obstacles: Sequence[Obstacle] = (),
    ) -> tuple[Contact, ...]:
        """Return the pairs of links that overlap, or are nearer than a margin, with their nearest points.

        Making one object per contact takes time; for many configurations use `clearance`, which also describes the
        shapes and the pairs.

        Args:
            q: configurations, shape (..., nq).
            margin: distance below which links are listed; negative for those that overlap by more [m].
            tolerance: overlap that is accepted, subtracted from `margin` [m].
            allowed: pairs of links that may overlap, and are not listed.
            exact: as in `clearance`.
            obstacles: as in `clearance`.

        Returns:
            The contacts, by configuration and then by distance. Each has the names of its `links`; their `distance`,
            negative if they overlap [m]; the nearest `points` of the two, or the deepest ones, in the root's frame,
            shape (2, 3) [m]; and the `index` of the configuration in the batch. `describe()` says it in words.

        Raises:
            BadArgument: the robot has no shapes.
            NotFinite: the margin is not a finite number.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"LShoulderRoll": -0.3, "LElbowRoll": -1.5, "RElbowRoll": 0.04, "LHand": 1.0})
            >>> [contact.links for contact in nao.collisions(q)]
            [('RBicep', 'l_wrist')]
        """
        rule = CollisionRule(tolerance, allowed, exact, obstacles)
        shapes, distance = self.link_shapes.among(rule.obstacles), float(shaped(margin, (), "margin"))
        return shapes.contacts(self.checked(q), distance - rule.tolerance, rule)

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

    def _part(
        self, part: str, q: ArrayLike, frame: str | Sequence[str] | None, reference: str | None, output: Output
    ) -> NDArray[Any]:
        question = Question("poses", self._frames.ids(frame), self._frames.reference_id(reference), part)
        return self._answers.answer(question, (q,), output, one=isinstance(frame, str))

    def _motion(
        self, kind: str, inputs: Sequence[ArrayLike], frame: str | Sequence[str], expressed_in: str, output: Output
    ) -> NDArray[Any]:
        choice(expressed_in, EXPRESSIONS, "expression")
        question = Question(kind, self._frames.ids(frame), form=expressed_in)
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
        RobotModel.__init__(self, state["tree"], state["semantics"], base=state["base"])
        self.load_notes = state["load_notes"]
        if state["numbers"] is not None:
            restore_numbers(self.model, state["numbers"])

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}: {self.nv} degrees of freedom, {len(self.link_names)} links>"


def _loaded(tree: UrdfTree, given: Semantics | Path | str | None, implied: Semantics | None, base: Base) -> RobotModel:
    """Return the robot of a tree, with the semantics given or implied by its file, and notes on both."""
    notes: list[str] = []
    # A RobotModel even if the caller used NaoModel: a NaoModel always has the numbers of its version.
    robot = RobotModel(tree, find_semantics(tree, given, notes, implied), base=base)
    for name in robot.posture_names:
        outside = [violation.joint for violation in robot.limit_violations(robot.posture(name))]
        if outside:
            notes.append(f"posture {quoted(name)} is outside the limits of {abbreviated(', '.join(outside))}")
    robot.load_notes = (*tree.notes, *unit_notes(tree), *notes)
    return robot


def _is_plain(q: ArrayLike, dtype: object, out: object, threads: object) -> bool:
    """Return whether the arguments are one configuration and no options, the case with a shortcut."""
    return type(q) is np.ndarray and q.ndim == 1 and dtype is None and out is None and threads is None


def check_robot(robot: object) -> None:
    """Raise `BadArgument` unless `robot` is a robot model."""
    if not isinstance(robot, RobotModel):
        raise BadArgument(f"robot must be a RobotModel, got {type(robot).__name__}")
