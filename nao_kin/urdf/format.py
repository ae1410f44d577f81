"""What a robot's file is, by what stands in it: people name their files as they like."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Literal

from nao_kin._text import abbreviated
from nao_kin.errors import BadModel
from nao_kin.semantics import Semantics
from nao_kin.urdf.document import file_content, root_tag
from nao_kin.urdf.mjcf import mjcf_tree
from nao_kin.urdf.reader import urdf_tree
from nao_kin.urdf.tree import UrdfTree
from nao_kin.urdf.xacro_source import xacro_values

_FORMATS: dict[str, Literal["urdf", "mjcf"]] = {"robot": "urdf", "mujoco": "mjcf"}
# Root elements of what people take for a robot's file, and what the file is.
_OTHERS = {
    "mujocoinclude": "a part of an MJCF that another file includes; read that one",
    "sdf": "an SDF; convert it to URDF or MJCF first",
}


def file_format(path: Path | str) -> Literal["urdf", "mjcf"]:
    """What a robot's file is: "urdf" for URDF and for xacro sources of one, "mjcf" for MuJoCo's format.

    Raises:
        BadModel: the file cannot be read, is not well-formed, or is neither.

    Examples:
        >>> nk.urdf.file_format(nk.load_nao().urdf_path)
        'urdf'
    """
    return _format(path, file_content(path))


def read_robot(
    path: Path | str,
    *,
    package_dirs: Iterable[Path | str] = (),
    xacro: bool | None = None,
    xacro_arguments: Mapping[str, object] | None = None,
) -> tuple[UrdfTree, Semantics | None]:
    """Read a robot's file of any format, once: it may be a pipe.

    Args:
        path: the file.
        package_dirs: folders to search for packages and meshes, as `read_urdf` and `read_mjcf` take them.
        xacro: expand the file as a xacro source, which runs the code that its author wrote; None to expand files named
            .xacro only, False to expand none.
        xacro_arguments: values of the arguments of a xacro source, by name.

    Returns:
        The tree, and what an MJCF says beyond it; None of a URDF, which says nothing.

    Raises:
        BadModel, BadArgument, MissingExtra: as `file_format`, and the reader of the format that it is.

    Examples:
        >>> tree, semantics = nk.urdf.read_robot(nk.load_nao().urdf_path)
        >>> tree.root, semantics
        ('base_link', None)
    """
    content = file_content(path)
    given = xacro_values({} if xacro_arguments is None else xacro_arguments)
    if _format(path, content) == "mjcf" and not given and (xacro is None or xacro is False):
        return mjcf_tree(Path(path).absolute(), content, package_dirs)
    # Which refuses to expand an MJCF, and arguments for a file that takes none.
    return urdf_tree(Path(path).absolute(), content, package_dirs, xacro, xacro_arguments), None


def _format(path: Path | str, content: bytes) -> Literal["urdf", "mjcf"]:
    tag = root_tag(path, content)
    if tag not in _FORMATS:
        other = f": {_OTHERS[tag]}" if tag in _OTHERS else ""
        raise BadModel(
            f"{path}: the root element is <{abbreviated(tag)}>, a URDF has <robot> and an MJCF <mujoco>{other}"
        )
    return _FORMATS[tag]
