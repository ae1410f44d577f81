"""A robot model: what it is made of, and what it answers about configurations.

Its methods stand here with all that is to be said about them; the work is done in the room's other modules.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, SupportsIndex, TypeVar

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, DTypeLike, NDArray

from nao_kin._core.arrays import Floats, choice, whole_number
from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.robot.answers import Answers, Output
from nao_kin.robot.build import Base, build_model, numbers_of, restore_numbers
from nao_kin.robot.configurations import Configurations, Coordinates
from nao_kin.robot.geometry import GeometryKind, geometry_model
from nao_kin.robot.kinematics import (
    EXPRESSIONS,
    POSE_FORMS,
    Expression,
    FrameIds,
    FrameTable,
    Kinematics,
    PoseForm,
    Question,
    expression_named,
)
from nao_kin.robot.limits import JointLimits, LimitPolicy, LimitViolation, check_policy
from nao_kin.robot.offsets import with_offsets
from nao_kin.robot.semantics import CoupledLimit, Mimic, Semantics
from nao_kin.robot.semantics_files import checked_semantics, semantics_beside
from nao_kin.robot.support_polygon import SupportPolygon, support_polygon
from nao_kin.robot.urdf import UrdfTree, read_mjcf, read_robot, read_urdf

_Robot = TypeVar("_Robot", bound="RobotModel")


class RobotModel:
    """A robot from a URDF or MJCF, with one coordinate per joint that can be moved on its own.

    Configurations are arrays q of shape (..., nq). With a fixed base, q holds the joint values in the order of
    `joint_names`. With a floating base, seven numbers of Pinocchio's free-flyer stand before them: the position of the
    base in the world and its orientation as a unit quaternion (x, y, z, w).

    All methods take any leading batch shape, return fresh arrays, and may be called from several threads at once.

    A few configurations are answered by Pinocchio; many by compiled kernels, which agree with it to 1e-12. Poses,
    Jacobians and their like share three arguments:

    - `dtype` is the precision of the result, np.float64 or np.float32; with float32, many configurations are also
      computed in it: poses, Jacobians and centres of mass to 2e-6 where joints are within a turn of zero; angles and
      rates of motion, which enlarge rounding, to several times that. None stands for that of `out`, or float64.
    - `out` is an array to write the result into and return: of its shape and precision, contiguous, apart from the
      input.
    - `threads` says how many threads may work on many configurations; None for all cores where that is worthwhile. With
      a number given, the kernels answer however few there are: the same bits for a configuration, whatever batch it is
      in.

    Attributes:
        model: the Pinocchio model, nq coordinates and nv velocities.
        tree: the URDF as read: links, joints, inertias and looks.
        semantics: what the robot means beyond its URDF: chains, end effectors, postures, coupled limits.
        urdf_path: the file it came from.
        base: "fixed" or "floating".
        load_notes: what had to be changed on loading, one line each.
        joint_names: names of the joints with a coordinate of their own, in the order of q.
        joint_units: unit of each: "rad", "m", or "1" for a ratio.
        mimics: the joints that follow another one, by name.
        frame_names: every name `fk` takes: links and joints. A joint's frame moves with the joint; a name that the URDF
            gives to a link and to a joint means the link.
        link_names: the links, in the order in which `fk(q)` returns them.
        lower: smallest joint values, shape (n,).
        upper: largest joint values, shape (n,).
        velocity_limits: largest joint speeds, shape (n,).
        effort_limits: largest joint torques or forces, shape (n,).
        coupled_limits: tables in which one joint's range depends on another's value.

    The limits are those of the file; changing them in `model` changes what Pinocchio knows, not what this class checks.

    Examples:
        >>> nao = nk.load_nao()
        >>> isinstance(nao, nk.RobotModel), nao.name, round(float(nao.upper[0]), 3)
        (True, 'nao_v6', 2.086)
    """

    def __init__(self, tree: UrdfTree, semantics: Semantics | None = None, *, base: Base = "fixed") -> None:
        """A robot from the tree of its URDF.

        Args:
            tree: the URDF as it was read.
            semantics: what the robot means beyond it.
            base: "fixed", or "floating" for a free base.

        Raises:
            BadArgument: no such base.
            BadModel: more joints than Pinocchio can take, or semantics that name what the robot does not have.
        """
        self.model = model = build_model(tree, base)
        self.tree, self.urdf_path, self.load_notes = tree, tree.path, tree.notes
        self.base: Base = base
        self.mimics: Mapping[str, Mimic] = MappingProxyType(tree.mimics)
        own = {joint.name: joint for joint in tree.moving_joints if joint.mimic is None}
        self.joint_names: tuple[str, ...] = tuple(own)
        self.semantics = checked_semantics(semantics or Semantics(), tree)
        self._units = {joint.name: "m" if joint.kind == "prismatic" else "rad" for joint in tree.moving_joints}
        self._units |= self.semantics.units
        self.joint_units = tuple(map(self._units.__getitem__, own))
        ends = [(joint.lower, joint.upper, joint.velocity, joint.effort) for joint in own.values()]
        limits: Floats = np.array(np.reshape(ends, (-1, 4)).T, dtype=np.float64, order="C")
        limits.flags.writeable = False
        self.lower, self.upper, self.velocity_limits, self.effort_limits = limits
        self._frames = FrameTable(model, tree)
        self.frame_names, self.link_names = self._frames.names, self._frames.link_names
        self._limits = JointLimits(self.joint_names, self.lower, self.upper, self.joint_units, self.coupled_limits)
        self._coordinates = Coordinates(self.joint_names, self.mimics, self.semantics.chains)
        self._configurations = Configurations(
            self._coordinates, self._limits, pin.neutral(model), self._units, self.semantics.postures
        )
        self._kinematics = Kinematics(model)
        self._answers = Answers(self._kinematics, tree, self._configurations)

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
        """A robot from a file of any format that can be read: URDF, xacro or MJCF, told apart by what stands in it.

        Args:
            path: the file; it is read once, and may be a pipe.
            base: "fixed", or "floating" for a free base.
            semantics: what the robot means beyond its file, as `from_urdf` takes it.
            package_dirs: folders to search for packages and meshes, as `from_urdf` and `from_mjcf` take them.
            xacro: expand the file as a xacro source, which runs the code that its author wrote; None to expand files
                named .xacro only, False to expand none.
            xacro_arguments: values of the arguments of a xacro source, by name.

        Raises:
            BadModel: the file is none of the three; and whatever the reader of its format raises.
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
        """A robot from any URDF, with every joint coupling kept.

        Couplings that Pinocchio refuses are mended (see `load_notes`): joints are ordered so that the driving one comes
        first, `continuous` joints become revolute ones without limits, axes are normalised, a link that shares its name
        with a joint gets another one ("…_link", or "…_frame" where that is taken) and answers under both. Meshes are
        not read. A xacro source is expanded when it is named .xacro or `xacro` asks for it (nao-kin[xacro]).

        Args:
            path: the URDF file, or its xacro source.
            base: "fixed", or "floating" for a free base.
            semantics: what the robot means beyond its URDF: a `Semantics`, or the path of a TOML file (as
                `nk.semantics.read_semantics` takes it) or of an SRDF. None for the file of the URDF's name with
                the ending .toml or .srdf beside it, if there is one.
            package_dirs: folders that hold packages of ROS, or are one, for `package://` and `$(find …)`; they are
                searched before the folders above the file, ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.
            xacro: expand the file as a xacro source, which runs the code that its author wrote; None to expand files
                named .xacro only, False to expand none.
            xacro_arguments: values of the arguments of a xacro source, by name.

        Raises:
            BadModel: the file cannot be read or describes no tree of revolute, continuous, prismatic and fixed joints;
                a xacro source that cannot be expanded or is not to be; or the semantics name what the robot does not
                have.
            BadInputFile: the TOML file cannot be read.
            BadArgument: no such base, semantics of another kind, a folder that is not there, or arguments for a file
                that is not expanded.

        Examples:
            >>> robot = nk.RobotModel.from_urdf(nk.load_nao().urdf_path, base="floating")
            >>> robot.nq, robot.nv
            (32, 31)
        """
        tree = read_urdf(_absolute(path), package_dirs=package_dirs, xacro=xacro, xacro_arguments=xacro_arguments)
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
        """A robot from an MJCF, MuJoCo's own format, as MuJoCo reads it (nao-kin[mujoco]).

        It answers like one from a URDF: bodies are links; hinges and slides are joints, with MuJoCo's values; a ball
        joint is three joints about x, y and z; linear equality constraints between joints are couplings; sites and
        cameras are frames; named keyframes are postures. What a tree of joints has no place for is in `load_notes`:
        closed loops, bodies beside the robot, curves between joints.

        Args:
            path: the MJCF file.
            base: "fixed", or "floating" for a free base; a free joint of the file is the base's.
            semantics: what the robot means beyond its file, as `from_urdf` takes it; it stands before what the MJCF
                itself says, part by part where it comes from a file.
            package_dirs: folders to search for meshes that are not where the file says.

        Raises:
            MissingExtra: MuJoCo is not installed.
            BadModel: the file cannot be read, is no MJCF, is refused by MuJoCo, holds no body; or the semantics name
                what the robot does not have.
            BadInputFile: the TOML file cannot be read.
            BadArgument: no such base, semantics of another kind, or a folder that is not there.

        Examples:
            >>> panda = nk.RobotModel.from_mjcf("panda.xml")  # doctest: +SKIP
            >>> panda.fk(panda.posture("home"), "hand")  # doctest: +SKIP
        """
        tree, own = read_mjcf(_absolute(path), package_dirs=package_dirs)
        return _loaded(tree, semantics, own, base)

    # --- what it is -----------------------------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the robot, as its URDF has it."""
        return str(self.model.name)

    @property
    def nq(self) -> int:
        """Number of coordinates in q."""
        return int(self.model.nq)

    @property
    def nv(self) -> int:
        """Number of velocity coordinates: the degrees of freedom."""
        return int(self.model.nv)

    @property
    def mass(self) -> float:
        """Mass of the whole robot, root link included [kg]."""
        return self._kinematics.mass

    @property
    def coupled_limits(self) -> tuple[CoupledLimit, ...]:
        """Tables in which one joint's range depends on another's value."""
        return self.semantics.coupled_limits

    @property
    def chains(self) -> Mapping[str, tuple[str, ...]]:
        """Named chains, each with its joints from the trunk outwards; none where the semantics name none."""
        return self.semantics.chains

    @property
    def posture_names(self) -> tuple[str, ...]:
        """Names that `posture` takes."""
        return tuple(self.semantics.postures)

    @property
    def parameters(self) -> Any:
        """The published numbers that the URDF was made of; None where the URDF is all there is."""
        return None

    def unit(self, joint: str) -> str:
        """Unit of a joint's value, of a joint that follows another one too: "rad", "m", or "1" for a ratio.

        Raises:
            UnknownName: no such joint.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.unit("HeadYaw"), nao.unit("LHand")
            ('rad', '1')
        """
        if not isinstance(joint, str) or joint not in self._units:
            raise UnknownName("joint", joint, (*self.joint_names, *self.mimics))
        return self._units[joint]

    def frame_ids(self, frames: Sequence[str] | None) -> FrameIds:
        """Places of frames in Pinocchio's list; of all links for None.

        Raises:
            UnknownName: no such frame.

        Examples:
            >>> nao = nk.load_nao()
            >>> len(nao.frame_ids(["LArm", "RArm"]))
            2
        """
        return self._frames.ids(frames)

    @property
    def frame_table(self) -> Mapping[str, int]:
        """Every frame name and its place in Pinocchio's list, in the order of `frame_names`."""
        return self._frames.places

    def with_offsets(
        self: _Robot,
        joints: Mapping[str, ArrayLike] | None = None,
        frames: Mapping[str, ArrayLike] | None = None,
    ) -> _Robot:
        """Return the same robot as calibrated: with offsets of its joints, and frames mounted otherwise.

        Every answer of the new robot knows them: its tree, Pinocchio model, batch kernels, inverse kinematics and
        exports. A closed form whose geometry no longer holds is refused with the reason; `nk.ik.numeric` takes any
        robot. Offsets add to those that this robot has already. What was written into `model` is not carried over.

        Args:
            joints: name → offset δ [rad; m for a joint that slides]. True value = reported value + δ, where the
                reported value is the one in q: `new.fk(q) == old.fk(q + δ)`. Each joint has its own mounting, so an
                offset of LHipYawPitch turns the left leg alone; RHipYawPitch has one of its own. Limits are those of
                the reported values, unchanged.
            frames: name of a frame that a link carries without a joint between, such as a camera or hand → its true
                pose in the frame of before, `T_link_new = T_link_old @ T_old_new`: a matrix, shape (4, 4), or
                (dx, dy, dz, roll, pitch, yaw), R = Rz(yaw) Ry(pitch) Rx(roll), in the axes of the old frame [m, rad].
                What the frame carries moves with it.

        Raises:
            UnknownName: no such joint, or no such frame.
            BadArgument: a frame that a joint moves; no mapping; no pose.
            WrongShape, NotFinite: an offset that is no number, or no pose.

        Examples:
            >>> nao = nk.load_nao()
            >>> mine = nao.with_offsets(joints={"HeadYaw": 0.01}, frames={"CameraTop": (0, 0, 0.002, 0, 0.02, 0)})
            >>> q = nao.configuration({"HeadYaw": 0.3})
            >>> np.allclose(mine.fk(q, "Head"), nao.fk(nao.configuration({"HeadYaw": 0.31}), "Head"))
            True
        """
        tree = with_offsets(self.tree, {} if joints is None else joints, {} if frames is None else frames)
        notes = (*self.load_notes, *tree.notes[len(self.tree.notes) :])
        robot = type(self).__new__(type(self))
        robot.__setstate__({**self.__getstate__(), "tree": tree, "load_notes": notes, "numbers": None})
        return robot

    def geometry(self, kind: GeometryKind) -> pin.GeometryModel:
        """Return the shapes of the links as a Pinocchio `GeometryModel`, placed on the joints of `model`.

        Pinocchio's visualizers draw it, and its collision library coal computes distances and collisions with it. Each
        call builds a new one; it holds no collision pairs yet (`addAllCollisionPairs` and `addCollisionPair` add them).

        Args:
            kind: "visual" for the looks of the links, "collision" for the shapes that stand for them in contacts.

        Returns:
            One object per shape, named as Pinocchio's own parser names it: the link, "_", and its number from 0.

        Raises:
            UnknownName: no such kind.

        Warns:
            MissingShapeWarning: some shapes are left out, because their meshes are missing or cannot be read.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.geometry("collision").ngeoms
            21
        """
        return geometry_model(self.model, self._frames, self.tree, kind)

    # --- configurations -------------------------------------------------------------------------------------------

    def neutral(self) -> Floats:
        """All joints at zero, a floating base at the world's origin; shape (nq,).

        Zero is the configuration that the frames are defined in. It need not lie inside the limits: NAO's elbows
        stop 2° before it.

        Examples:
            >>> nk.load_nao().neutral().shape
            (25,)
        """
        return self._configurations.neutral()

    def posture(
        self,
        name: str,
        angles: Mapping[str, ArrayLike] | None = None,
        /,
        *,
        limits: LimitPolicy = "raise",
        **joints: ArrayLike,
    ) -> Floats:
        """A predefined posture, with other values for some joints.

        Joints that the posture leaves open are at zero. Without `angles` and `joints` it is given as it is; with them
        all of it is held against the limits, for a coupled limit may reach from a joint that is named to one that is
        not.

        Args:
            name: one of `posture_names`.
            angles: joint or chain → value, as `configuration` takes them.
            limits: what to do with joints outside their limits: "raise", "clamp" or "ignore".
            **joints: joint or chain → value, too, for names that Python can write so.

        Returns:
            q, shape (nq,), or (..., nq) for values of a batch shape.

        Raises:
            UnknownName: no such posture, joint or chain.
            OutsideLimits: a joint is outside its limits.
            WrongShape, NotFinite, CouplingViolated, BadArgument: as `configuration`.

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
        """Configurations inside all limits, coupled ones included, each joint uniform in its range.

        Joints without limits are uniform in [−π, π]; a floating base stays at the world's origin.

        Args:
            rng: a generator, or a seed for one.
            n: how many, or a batch shape; None for one configuration of shape (nq,).

        Returns:
            Configurations, shape (n…, nq).

        Raises:
            BadArgument: no generator and no seed, or no batch shape.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.random(rng=0, n=(2, 3))
            >>> q.shape, bool(nao.within_limits(q).all())
            ((2, 3, 25), True)
        """
        return self._configurations.random(rng, n)

    def configuration(
        self, angles: Mapping[str, ArrayLike], *, limits: LimitPolicy = "raise", degrees: bool = False
    ) -> Floats:
        """The configuration with the given joint values; joints not named are at zero.

        A joint that follows another one may be named too: alone it sets the driving joint, beside it the two must
        agree. A chain of the robot stands for its joints, from the trunk outwards.

        Args:
            angles: joint name → value, or an array of values of one batch shape [rad, m or ratio]; chain name →
                the values of its joints, shape (..., number of joints).
            limits: what to do with a named joint outside its limits: "raise", "clamp" or "ignore".
            degrees: the values of turning joints are in degrees.

        Returns:
            q, shape (..., nq), in radians whatever `degrees` says.

        Raises:
            UnknownName: no such joint or chain, or no such limits policy.
            CouplingViolated: two joints of one motor disagree.
            OutsideLimits: a named joint is outside its limits.
            WrongShape, NotFinite, BadArgument: values that are no numbers of one batch shape, or a joint named twice.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"HeadYaw": 0.3, "RArm": [1.4, -0.2, 1.2, 0.4, 0.0, 0.5]})
            >>> nao.angles(q)["RShoulderPitch"]
            1.4
        """
        return self._configurations.configuration(angles, limits, degrees)

    def angles(self, q: ArrayLike, *, degrees: bool = False) -> dict[str, Floats | float]:
        """Joint values by name, joints that follow another one not included: the inverse of `configuration`.

        Args:
            q: configurations, shape (..., nq).
            degrees: give the values of turning joints in degrees.

        Returns:
            name → float, or → array of the batch shape [rad, m or ratio].

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.angles(nao.configuration({"HeadYaw": 0.3}))["HeadYaw"]
            0.3
        """
        return self._configurations.angles(q, degrees)

    def checked(self, q: ArrayLike) -> Floats:
        """Return `q` as an array, when it holds configurations of this robot, whether inside the limits or not.

        Args:
            q: configurations, shape (..., nq).

        Returns:
            Shape (..., nq); the quaternion of a floating base of norm 1 to the last digit. An array that is one already
            may be `q` itself.

        Raises:
            WrongShape, NotFinite: q is no configuration.
            BadArgument: q holds no numbers, or the quaternion of a floating base is not of unit length.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.checked([[0.0] * 25] * 2).shape
            (2, 25)
        """
        return self._configurations.checked(q)

    # --- limits ---------------------------------------------------------------------------------------------------

    def within_limits(self, q: ArrayLike, *, per_joint: bool = False) -> NDArray[np.bool_]:
        """Which configurations are inside all limits, the tables of coupled limits included.

        The answer for many configurations: `(~nao.within_limits(q, per_joint=True)).sum(axis=0)` counts, joint by
        joint, how many of a million are outside.

        Args:
            q: configurations, shape (..., nq).
            per_joint: one answer for each joint, in the order of `joint_names`.

        Returns:
            Shape (...), or with `per_joint` (..., n).

        Raises:
            WrongShape, NotFinite: q is no configuration.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"HeadYaw": [0.0, 3.0], "LElbowRoll": -0.5, "RElbowRoll": 0.5}, limits="ignore")
            >>> nao.within_limits(q).tolist()
            [True, False]
        """
        inside = self._limits.inside(self._configurations.joints(q))
        return inside if per_joint else np.asarray(inside.all(axis=-1))

    def limit_violations(self, q: ArrayLike, *, most: int | None = None) -> tuple[LimitViolation, ...]:
        """Every joint outside its limits, by configuration and then by how far; empty when all are inside.

        A row for each takes time and memory where there are many: `within_limits` answers with arrays.

        Args:
            q: configurations, shape (..., nq).
            most: stop after this many configurations with a violation; None for all.

        Raises:
            WrongShape, NotFinite: q is no configuration.
            BadArgument: `most` is no count.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("Stand")
            >>> q[0] = 3.0
            >>> [violation.joint for violation in nao.limit_violations(q)]
            ['HeadYaw']
        """
        limit = None if most is None else whole_number(most, "most", 0)
        return self._limits.violations(self._configurations.joints(q), most=limit)

    def check_limits(self, q: ArrayLike) -> Floats:
        """`q` as an array when every joint is inside its limits, the tables of coupled limits included.

        Raises:
            OutsideLimits: with the violations.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.check_limits(nao.posture("Stand")).shape
            (25,)
        """
        return np.array(self._configurations.within(self._configurations.checked(q), "raise"), order="C")

    def clamp(self, q: ArrayLike) -> Floats:
        """The nearest configurations inside the limits: first every joint into its box, then into its table.

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
        ids, reference_id = self._frames.ids(frame), self._frames.reference_id(reference)
        choice(as_, POSE_FORMS, "form of a pose")
        if not isinstance(limits, str):  # an array would be compared with a name entry by entry
            check_policy(limits)  # type: ignore[unreachable]
        if as_ == "matrix" and _is_plain(q, dtype, out, threads):
            q = self._configurations.posed(q) if limits == "ignore" else self._within(q, limits)
            if reference_id is None:
                poses = self._kinematics.poses(q, ids)
            else:
                poses = self._kinematics.relative_poses(q, ids, reference_id)
            return poses[0] if one else poses
        output = Output(dtype, out, threads)
        if limits != "ignore":
            output.check_apart(q)
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
            q, expression = self._configurations.posed(q), expression_named(expressed_in)
            return self._kinematics.jacobians(q, self._frames.id(frame), expression)
        choice(expressed_in, EXPRESSIONS, "expression")
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
            return self._kinematics.centres_of_mass(self._configurations.posed(q))
        question = Question("com", reference_id=self._frames.reference_id(reference))
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

    def support_polygon(
        self, q: ArrayLike, soles: Sequence[str] | None = None, *, reference: str | None = None
    ) -> SupportPolygon:
        """Return the convex hull of the soles that stand, seen along the z axis of a frame on the floor.

        Args:
            q: one configuration, shape (nq,).
            soles: frames of the soles that stand; None for all that the robot's semantics name.
            reference: frame in whose xy plane the polygon lies; None for the first of the soles.

        Returns:
            The polygon, with vertices in the xy plane of the reference [m]. `com(q)` mapped into that frame has its
            `signed_distance` from the edge.

        Raises:
            UnknownName: no such frame.
            BadArgument: no soles; a sole without outline; soles without area.
            WrongShape, NotFinite: q is not one configuration.

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

    # --- inside ---------------------------------------------------------------------------------------------------

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


def _loaded(tree: UrdfTree, given: Semantics | Path | str | None, own: Semantics | None, base: Base) -> RobotModel:
    """The robot of a tree, with what it means and with notes on both.

    Args:
        tree: the file as read.
        given: the semantics that the caller gives, or None.
        own: those that the file itself has, None where its format has none.
        base: "fixed" or "floating".
    """
    notes: list[str] = []
    # Never a NaoModel: a NAO is made of the numbers of its version, whatever files its class is asked to read.
    robot = RobotModel(tree, semantics_beside(tree, given, notes, own), base=base)
    for name in robot.posture_names:
        outside = [violation.joint for violation in robot.limit_violations(robot.posture(name))]
        if outside:
            notes.append(f"posture {quoted(name)} is outside the limits of {abbreviated(', '.join(outside))}")
    robot.load_notes = (*tree.notes, *notes)
    return robot


def _absolute(path: Path | str) -> Path | str:
    """A path that stays the same wherever the process goes; what is no path is left for the reader to refuse."""
    try:
        return Path(path).absolute()
    except TypeError:
        return path


def _is_plain(q: ArrayLike, dtype: object, out: object, threads: object) -> bool:
    """Whether one configuration is asked about, and nothing else: to be answered in as few steps as possible."""
    return type(q) is np.ndarray and q.ndim == 1 and dtype is None and out is None and threads is None


def check_robot(robot: object) -> None:
    """Raise `BadArgument` for what is no robot model."""
    if not isinstance(robot, RobotModel):
        raise BadArgument(f"robot must be a RobotModel, got {type(robot).__name__}")
