"""A robot model: its names, configurations and limits; what it computes stands in `kinematic_methods`."""

from __future__ import annotations

import operator
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from nao_kin._common.arrays import Floats
from nao_kin._common.scalars import whole_number
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument, OutsideLimits, UnknownName
from nao_kin.robot.answers import Answers
from nao_kin.robot.batch_kinematics import BatchKinematics
from nao_kin.robot.build import Base, build_model, numbers_of, restore_numbers
from nao_kin.robot.checks import ConfigurationChecks
from nao_kin.robot.coordinates import Coordinates, checked_mapping
from nao_kin.robot.frames import FrameTable
from nao_kin.robot.kinematic_methods import KinematicMethods, LimitPolicy
from nao_kin.robot.kinematics import Kinematics
from nao_kin.robot.limits import JointLimits, LimitViolation
from nao_kin.robot.questions import FrameIds
from nao_kin.robot.semantics_files import checked_semantics, semantics_beside
from nao_kin.semantics import CoupledLimit, Mimic, Semantics
from nao_kin.urdf import UrdfTree, file_format, read_mjcf, read_urdf

_POLICIES = ("raise", "clamp", "ignore")
# An error about a batch carries the violations of this many configurations, and counts the rest.
_MOST_LISTED = 100


class RobotModel(KinematicMethods):
    """A robot from a URDF or MJCF, with one coordinate per joint that can be moved on its own.

    Configurations are arrays q of shape (..., nq). With a fixed base, q holds the joint values in the order of
    `joint_names`. With a floating base, seven numbers of Pinocchio's free-flyer stand before them: the position of the
    base in the world and its orientation as a unit quaternion (x, y, z, w).

    All methods take any leading batch shape, return fresh arrays, and may be called from several threads at once.

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
            tree: the URDF as `nao_kin.urdf.read_urdf` reads it.
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
        own = [joint for joint in tree.moving_joints if joint.mimic is None]
        self.joint_names: tuple[str, ...] = tuple(joint.name for joint in own)
        self.semantics = checked_semantics(semantics or Semantics(), tree)
        self._units = {joint.name: "m" if joint.kind == "prismatic" else "rad" for joint in tree.moving_joints}
        self._units |= self.semantics.units
        self.joint_units = tuple(self._units[name] for name in self.joint_names)
        self._q_offset = model.nq - len(own)
        self._coordinates = Coordinates(self.joint_names, self.mimics, self.semantics.chains)
        self._places = {name: self._q_offset + column for name, column in self._coordinates.column.items()}
        self.lower, self.upper = _frozen([joint.lower for joint in own]), _frozen([joint.upper for joint in own])
        self.velocity_limits = _frozen([joint.velocity for joint in own])
        self.effort_limits = _frozen([joint.effort for joint in own])
        self._limits = JointLimits(
            self.joint_names, self.lower, self.upper, self.joint_units, self.semantics.coupled_limits
        )
        self._neutral: Floats = _frozen(pin.neutral(model))
        self._frames = FrameTable(model, tree)
        self.frame_names, self.link_names = self._frames.names, self._frames.link_names
        turning = [unit == "rad" for unit in self.joint_units]
        self._checks = ConfigurationChecks(base, model.nq, self.joint_names, turning, self.lower, self.upper)
        self._kinematics, batch = Kinematics(model), BatchKinematics(model, tree)
        self._answers = Answers(self._kinematics, batch, self._checks, int(model.nq), int(model.nv))
        self._postures = {
            name: _frozen(self.configuration(dict(posture.angles), limits="ignore"))
            for name, posture in self.semantics.postures.items()
        }

    @classmethod
    def from_file(
        cls,
        path: Path | str,
        *,
        base: Base = "fixed",
        semantics: Semantics | Path | str | None = None,
        package_dirs: Iterable[Path | str] = (),
        xacro_arguments: Mapping[str, object] | None = None,
    ) -> RobotModel:
        """A robot from a file of any format that can be read: URDF, xacro or MJCF, told apart by what stands in it.

        Args:
            path: the file.
            base: "fixed", or "floating" for a free base.
            semantics: what the robot means beyond its file, as `from_urdf` takes it.
            package_dirs: folders to search for packages and meshes, as `from_urdf` and `from_mjcf` take them.
            xacro_arguments: values of the arguments of a xacro source, by name.

        Raises:
            BadModel: the file is none of the three; and whatever the reader of its format raises.
            MissingExtra: MuJoCo, which reads MJCF, is not installed.
            BadArgument: xacro arguments for a file that is no xacro source.

        Examples:
            >>> robot = nk.RobotModel.from_file(nk.load_nao().urdf_path)
            >>> robot.nv, robot.load_notes
            (25, ())
        """
        if file_format(path) == "urdf":
            return cls.from_urdf(
                path, base=base, semantics=semantics, package_dirs=package_dirs, xacro_arguments=xacro_arguments
            )
        if xacro_arguments:
            raise BadArgument(f"{path} is no xacro source and takes no arguments, got {', '.join(xacro_arguments)}")
        return cls.from_mjcf(path, base=base, semantics=semantics, package_dirs=package_dirs)

    @classmethod
    def from_urdf(
        cls,
        path: Path | str,
        *,
        base: Base = "fixed",
        semantics: Semantics | Path | str | None = None,
        package_dirs: Iterable[Path | str] = (),
        xacro_arguments: Mapping[str, object] | None = None,
    ) -> RobotModel:
        """A robot from any URDF, with every joint coupling kept.

        Couplings that Pinocchio refuses are mended (see `load_notes`): joints are ordered so that the driving one comes
        first, `continuous` joints become revolute ones without limits, axes are normalised, a link that shares its name
        with a joint gets another one ("…_link", or "…_frame" where that is taken) and answers under both. Meshes are
        not read. A xacro source is expanded where the package xacro is installed (nao-kin[xacro]).

        Args:
            path: the URDF file, or its xacro source.
            base: "fixed", or "floating" for a free base.
            semantics: what the robot means beyond its URDF: a `Semantics`, or the path of a TOML file (as
                `nao_kin.semantics.read_semantics` takes it) or of an SRDF. None for the file of the URDF's name with
                the ending .toml or .srdf beside it, if there is one.
            package_dirs: folders that hold packages of ROS, or are one, for `package://` and `$(find …)`; they are
                searched before the folders above the file, ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.
            xacro_arguments: values of the arguments of a xacro source, by name.

        Raises:
            BadModel: the file cannot be read or describes no tree of revolute, continuous, prismatic and fixed joints;
                a xacro source that cannot be expanded; or the semantics name what the robot does not have.
            BadInputFile: the TOML file cannot be read.
            BadArgument: no such base, semantics of another kind, a folder that is not there, or arguments for a file
                that is no xacro source.

        Examples:
            >>> robot = nk.RobotModel.from_urdf(nk.load_nao().urdf_path, base="floating")
            >>> robot.nq, robot.nv
            (32, 31)
        """
        tree = read_urdf(_absolute(path), package_dirs=package_dirs, xacro_arguments=xacro_arguments)
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
    def parameters(self) -> Any:
        """The published numbers that the URDF was made of; None where the URDF is all there is."""
        return None

    @property
    def posture_names(self) -> tuple[str, ...]:
        """Names that `posture` takes."""
        return tuple(self._postures)

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

    # --- configurations -------------------------------------------------------------------------------------------

    def neutral(self) -> Floats:
        """All joints at zero, a floating base at the world's origin; shape (nq,).

        Zero is the configuration that the frames are defined in. It need not lie inside the limits: NAO's elbows
        stop 2° before it.

        Examples:
            >>> nk.load_nao().neutral().shape
            (25,)
        """
        return np.array(self._neutral)

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
        if not isinstance(name, str) or name not in self._postures:
            raise UnknownName("posture", name, self.posture_names)
        if angles is None and not joints:
            return np.array(self._postures[name])
        values, given = self._coordinates.values(joints if angles is None else {**checked_mapping(angles), **joints})
        q = np.empty((*values.shape[:-1], self.nq))
        q[...] = self._postures[name]
        columns = [self._coordinates.column[joint] for joint in given]
        q[..., [self._q_offset + column for column in columns]] = values[..., columns]
        return self._within(q, limits)

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
        try:
            generator = np.random.default_rng(rng)
            shape = () if n is None else tuple(map(operator.index, n if isinstance(n, Iterable) else (n,)))
        except (TypeError, ValueError) as error:
            raise BadArgument(f"random needs a generator or a seed, and a number or a shape: {error}") from None
        if any(length < 0 for length in shape):
            raise BadArgument(f"n must not be negative, got {n}")
        q = self._neutrals(shape)
        q[..., self._q_offset :] = self._limits.random(generator, shape)
        return q

    def configuration(self, angles: Mapping[str, ArrayLike], *, limits: LimitPolicy = "raise") -> Floats:
        """The configuration with the given joint values; joints not named are at zero.

        A joint that follows another one may be named too: alone it sets the driving joint, beside it the two must
        agree. A chain of the robot stands for its joints, from the trunk outwards.

        Args:
            angles: joint name → value, or an array of values of one batch shape [rad, m or ratio]; chain name →
                the values of its joints, shape (..., number of joints).
            limits: what to do with a named joint outside its limits: "raise", "clamp" or "ignore".

        Returns:
            q, shape (..., nq).

        Raises:
            UnknownName: no such joint or chain.
            CouplingViolated: two joints of one motor disagree.
            OutsideLimits: a named joint is outside its limits.
            WrongShape, NotFinite, BadArgument: values that are no numbers of one batch shape, or a joint named twice.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.configuration({"HeadYaw": 0.3, "RArm": [1.4, -0.2, 1.2, 0.4, 0.0, 0.5]})
            >>> nao.angles(q)["RShoulderPitch"]
            1.4
        """
        values = self._coordinates.plain_values(angles)
        if values is not None and (limits == "ignore" or (limits == "raise" and self._limits.surely_inside(values))):
            plain = self._neutral.tolist()
            places = self._places
            for name, value in values.items():
                plain[places[name]] = value
            return np.array(plain, dtype=np.float64)
        joints, given = self._coordinates.values(angles)
        q = self._neutrals(joints.shape[:-1])
        q[..., self._q_offset :] = joints
        return self._within(q, limits, given)

    def angles(self, q: ArrayLike) -> dict[str, Floats | float]:
        """Joint values by name, joints that follow another one not included: the inverse of `configuration`.

        Args:
            q: configurations, shape (..., nq).

        Returns:
            name → float, or → array of the batch shape.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.angles(nao.configuration({"HeadYaw": 0.3}))["HeadYaw"]
            0.3
        """
        return self._coordinates.by_name(self._checked(q)[..., self._q_offset :])

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
        inside = self._limits.inside(self._checked(q)[..., self._q_offset :])
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
        return self._limits.violations(self._checked(q)[..., self._q_offset :], most=limit)

    def check_limits(self, q: ArrayLike) -> Floats:
        """`q` as an array when every joint is inside its limits, the tables of coupled limits included.

        Raises:
            OutsideLimits: with the violations.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.check_limits(nao.posture("Stand")).shape
            (25,)
        """
        return np.array(self._within(self._checked(q), "raise"), order="C")

    def clamp(self, q: ArrayLike) -> Floats:
        """The nearest configurations inside the limits: first every joint into its box, then into its table.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.clamp(nao.configuration({"HeadYaw": 3.0}, limits="ignore"))
            >>> round(nao.angles(q)["HeadYaw"], 3)
            2.086
        """
        return self._within(self._checked(q), "clamp")

    # --- for the other rooms --------------------------------------------------------------------------------------

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

    # --- inside ---------------------------------------------------------------------------------------------------

    def _neutrals(self, shape: tuple[int, ...]) -> Floats:
        q = np.empty((*shape, self.nq))
        q[...] = self._neutral
        return q

    def _checked(self, q: ArrayLike) -> Floats:
        return self._checks.checked(q)

    def _within(self, q: Floats, limits: str, joints: Collection[str] | None = None) -> Floats:
        if limits == "ignore":
            return q
        _check_policy(limits)
        values = q[..., self._q_offset :]
        if limits == "raise":
            one = joints is None and values.ndim == 1
            if one and self._limits.surely_inside(dict(zip(self.joint_names, values.tolist(), strict=True))):
                return q
            count = self._limits.count(values, joints)
            if count:
                raise OutsideLimits(self._limits.violations(values, joints, most=_MOST_LISTED), count)
            return q
        inside = np.array(q, order="C")
        clamped = self._limits.clamp(values)
        if joints is None:
            inside[..., self._q_offset :] = clamped
        else:
            columns = [self._coordinates.column[name] for name in joints]
            inside[..., [self._q_offset + column for column in columns]] = clamped[..., columns]
        return inside

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
        restore_numbers(self.model, state["numbers"])

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}: {self.nv} degrees of freedom, {len(self.link_names)} links>"


def _absolute(path: Path | str) -> Path | str:
    """A path that stays the same wherever the process goes; what is no path is left for the reader to refuse."""
    try:
        return Path(path).absolute()
    except TypeError:
        return path


def _loaded(tree: UrdfTree, given: Semantics | Path | str | None, own: Semantics | None, base: Base) -> RobotModel:
    """The robot of a tree, with what it means and with notes on both.

    Args:
        tree: the file as read.
        given: the semantics that the caller gives, or None.
        own: those that the file itself has, None where its format has none.
        base: "fixed" or "floating".
    """
    notes: list[str] = []
    robot = RobotModel(tree, semantics_beside(tree, given, notes, own), base=base)
    for name in robot.posture_names:
        outside = [violation.joint for violation in robot.limit_violations(robot.posture(name))]
        if outside:
            notes.append(f"posture {quoted(name)} is outside the limits of {abbreviated(', '.join(outside))}")
    robot.load_notes = (*tree.notes, *notes)
    return robot


def _frozen(array: ArrayLike) -> Floats:
    """A read-only copy."""
    copy: Floats = np.array(array, dtype=np.float64)
    copy.flags.writeable = False
    return copy


def _check_policy(limits: str) -> None:
    if not isinstance(limits, str) or limits not in _POLICIES:
        raise UnknownName("limits policy", limits, _POLICIES)


def check_robot(robot: object) -> None:
    """Raise `BadArgument` for what is no robot model.

    Examples:
        >>> nk.robot.check_robot("nao")
        Traceback (most recent call last):
            ...
        nao_kin.errors.BadArgument: robot must be a RobotModel, got str
    """
    if not isinstance(robot, RobotModel):
        raise BadArgument(f"robot must be a RobotModel, got {type(robot).__name__}")
