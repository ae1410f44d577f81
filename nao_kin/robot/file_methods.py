"""Robots from files: URDF, xacro and MJCF, with the semantics beside them and notes on what had to be changed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from nao_kin._text import abbreviated, quoted
from nao_kin.robot.build import Base
from nao_kin.robot.semantics_files import semantics_beside
from nao_kin.semantics import Semantics
from nao_kin.urdf import UrdfTree, read_mjcf, read_robot, read_urdf

if TYPE_CHECKING:
    from nao_kin.robot.model import RobotModel


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
                `nao_kin.semantics.read_semantics` takes it) or of an SRDF. None for the file of the URDF's name with
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
