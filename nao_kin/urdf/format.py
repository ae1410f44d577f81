"""What a robot's file is, by what stands in it: people name their files as they like."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from nao_kin._text import abbreviated
from nao_kin.errors import BadModel
from nao_kin.urdf.document import root_tag

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
    tag = root_tag(path)
    if tag not in _FORMATS:
        other = f": {_OTHERS[tag]}" if tag in _OTHERS else ""
        raise BadModel(
            f"{path}: the root element is <{abbreviated(tag)}>, a URDF has <robot> and an MJCF <mujoco>{other}"
        )
    return _FORMATS[tag]
