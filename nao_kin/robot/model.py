"""A robot model: what it is made of, its names and its limits.

What it answers stands in three more modules: how it comes from a file in `file_methods`, what its configurations are in
`configuration_methods`, and where they put its frames and its mass in `kinematic_methods`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, choice
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, MissingShapeWarning, UnknownName, WrongShape
from nao_kin.robot.answers import Answers, BatchKinematics
from nao_kin.robot.build import Base, build_model, numbers_of, restore_numbers
from nao_kin.robot.checks import ConfigurationChecks, Coordinates
from nao_kin.robot.configuration_methods import ConfigurationMethods
from nao_kin.robot.geometry import KINDS, GeometryKind, geometry_model
from nao_kin.robot.kinematic_methods import KinematicMethods
from nao_kin.robot.kinematics import FrameIds, FrameTable, Kinematics
from nao_kin.robot.limits import JointLimits
from nao_kin.robot.offsets import with_offsets
from nao_kin.robot.semantics import CoupledLimit, Mimic, Semantics
from nao_kin.robot.semantics_files import checked_semantics, semantics_beside
from nao_kin.robot.support_polygon import SupportPolygon, polygon_below, sole_corners
from nao_kin.robot.urdf import UrdfTree, read_mjcf, read_robot, read_urdf

# --- Robots from files: URDF, xacro and MJCF, with the semantics beside them and notes on what had to be changed.


class FileMethods(ABC):
    """The ways from a file to a `RobotModel`."""

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
        return cls._loaded(tree, semantics, own, base)

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
        return cls._loaded(tree, semantics, None, base)

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
        return cls._loaded(tree, semantics, own, base)

    # --- inside ---------------------------------------------------------------------------------------------------

    @classmethod
    @abstractmethod
    def _made(cls, tree: UrdfTree, semantics: Semantics, base: Base) -> RobotModel:
        """The robot of a tree."""

    @classmethod
    def _loaded(
        cls, tree: UrdfTree, given: Semantics | Path | str | None, own: Semantics | None, base: Base
    ) -> RobotModel:
        """The robot of a tree, with what it means and with notes on both.

        Args:
            tree: the file as read.
            given: the semantics that the caller gives, or None.
            own: those that the file itself has, None where its format has none.
            base: "fixed" or "floating".
        """
        notes: list[str] = []
        robot = cls._made(tree, semantics_beside(tree, given, notes, own), base)
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


# --- A robot model: what it is made of, its names and its limits.
#
# What it answers stands in three more modules: how it comes from a file in `file_methods`, what its configurations
# are in `configuration_methods`, and where they put its frames and its mass in `kinematic_methods`.

_Robot = TypeVar("_Robot", bound="RobotModel")


class RobotModel(FileMethods, ConfigurationMethods, KinematicMethods):
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
            tree: the URDF as `nao_kin.robot.urdf.read_urdf` reads it.
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
        choice(kind, KINDS, "kind of geometry")
        geometry, notes = geometry_model(self.model, self._frames, self.tree, kind)
        if notes:
            more = f" (and {len(notes) - 1} more)" if len(notes) > 1 else ""
            warn_caller(f"{self.name}: {notes[0]}{more}", MissingShapeWarning)
        return geometry

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
        if soles is not None:
            self.frame_ids((soles,) if isinstance(soles, str) else soles)
        names = self.semantics.soles if soles is None else (soles,) if isinstance(soles, str) else tuple(soles)
        if not names:
            raise BadArgument(f"{self.name} has no soles in its semantics; name frames that stand, as in soles=[…]")
        row = self._checks.checked(q)
        if row.ndim != 1:
            raise WrongShape("q", f"({self.nq},), one configuration", row.shape)
        poses = self.fk(row, names, reference=names[0] if reference is None else reference)
        return polygon_below((T, sole_corners(self, name)) for T, name in zip(poses, names, strict=True))

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

    @classmethod
    def _made(cls, tree: UrdfTree, semantics: Semantics, base: Base) -> RobotModel:
        # Not of `cls`: a NAO is made of the numbers of its version, whatever files its class is asked to read.
        return RobotModel(tree, semantics, base=base)

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


def _frozen(array: ArrayLike) -> Floats:
    """A read-only copy."""
    copy: Floats = np.array(array, dtype=np.float64)
    copy.flags.writeable = False
    return copy


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
