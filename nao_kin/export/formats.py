"""The export formats, and the options of each."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from nao_kin._core.arrays import choice
from nao_kin.export.gltf import gltf
from nao_kin.export.mjcf import mjcf
from nao_kin.export.pipeline import Exported
from nao_kin.export.ros2 import ros2
from nao_kin.export.sdf import sdf
from nao_kin.export.srdf import srdf
from nao_kin.export.urdf import urdf
from nao_kin.robot import RobotModel

# A format is a function of a robot and a path; its options are its keyword-only arguments.
FORMATS: Mapping[str, Callable[..., Exported]] = MappingProxyType(
    {"urdf": urdf, "mjcf": mjcf, "srdf": srdf, "ros2": ros2, "sdf": sdf, "gltf": gltf}
)


def options(format: str) -> dict[str, Any]:
    """Return the options of a format, each with its default, except "overwrite", which all formats have.

    Examples:
        >>> nk.export.options("urdf")["coupling"]
        'mimic'
    """
    parameters = inspect.signature(FORMATS[choice(format, FORMATS, "format")]).parameters.values()
    return {p.name: p.default for p in parameters if p.kind is p.KEYWORD_ONLY and p.name != "overwrite"}


def write(robot: RobotModel, path: Path | str, format: str, *, overwrite: bool = False, **chosen: Any) -> Exported:
    """Write a robot in a format.

    Args:
        robot: any robot.
        path: the file or folder to write.
        format: one of `FORMATS`.
        overwrite: replace existing files.
        **chosen: options of the format.

    Raises:
        UnknownName: an option that the format does not have; otherwise the errors of the format's function.

    Examples:
        >>> nk.export.write(nk.load_nao("v6"), "nao.urdf", "urdf", meshes="none").changes
        ('the meshes of 41 links are left out',)
    """
    known = options(format)
    for name in chosen:
        choice(name, known, f"option of the format {format}")
    return FORMATS[format](robot, path, overwrite=overwrite, **chosen)
