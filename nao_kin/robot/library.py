"""Robots that the optional package example-robot-data brings, by name."""

from __future__ import annotations

from pathlib import Path

from nao_kin.errors import MissingExtra, UnknownName
from nao_kin.robot.build import Base
from nao_kin.robot.model import RobotModel

_PACKAGE = "example-robot-data"


def robot_names() -> tuple[str, ...]:
    """Names that `load_robot` takes: the URDF files of example-robot-data without their suffix.

    Raises:
        MissingExtra: example-robot-data is not installed.

    Examples:
        >>> "romeo" in nk.robot_names()
        True
    """
    return tuple(_files())


def load_robot(name: str, *, base: Base = "fixed") -> RobotModel:
    """A robot of example-robot-data by name, as `RobotModel.from_urdf` loads it.

    Args:
        name: "romeo", "talos_full_v2", "panda" … (`robot_names()` lists them).
        base: "fixed" or "floating".

    Raises:
        MissingExtra: example-robot-data is not installed.
        UnknownName: it has no such robot.
        BadModel: the robot's file makes no model.

    Examples:
        >>> romeo = nk.load_robot("romeo")
        >>> romeo.nv, romeo.joint_names[0]
        (33, 'LHipYaw')
    """
    files = _files()
    if not isinstance(name, str) or name not in files:
        raise UnknownName("robot", name, tuple(files))
    return RobotModel.from_urdf(files[name], base=base, semantics=_srdf(files[name]))


def _files() -> dict[str, Path]:
    """The package holds data and no module, so its folder is found through the list of its installed files."""
    import importlib.metadata  # takes as long to load as all the rest of this room

    try:
        installed = importlib.metadata.files(_PACKAGE) or []
    except importlib.metadata.PackageNotFoundError:
        raise MissingExtra("robots by name", "robots") from None
    found = {
        file.stem: Path(str(file.locate())) for file in installed if file.suffix == ".urdf" and "robots" in file.parts
    }
    return dict(sorted(found.items()))


def _srdf(urdf: Path) -> Path | None:
    """The SRDF of the same name, which example-robot-data keeps in the folder srdf beside that of the URDF."""
    path = urdf.parent.parent / "srdf" / f"{urdf.stem}.srdf"
    return path if path.is_file() else None
