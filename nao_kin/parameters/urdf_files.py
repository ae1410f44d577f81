"""Where the generated URDFs are: inside the wheel, or beside the package in a checkout."""

from __future__ import annotations

from pathlib import Path

from nao_kin.errors import BadModel

_PACKAGE = Path(__file__).resolve().parent.parent


def urdf_directory() -> Path:
    """The folder of the generated URDFs.

    Raises:
        BadModel: the installation lacks it.
    """
    for folder in (_PACKAGE / "_urdf_files", _PACKAGE.parent / "urdf"):
        if (folder / "nao_v6.urdf").is_file():
            return folder
    raise BadModel(f"no urdf folder with nao_v6.urdf in {_PACKAGE} or beside it; reinstall nao-kin")


def nao_urdf_path(version: str) -> Path:
    """The URDF of one NAO version, "v3.2" … "v6"."""
    return urdf_directory() / urdf_name(version)


def urdf_name(version: str) -> str:
    """File name of the URDF of one version: "v3.2" → "nao_v32.urdf"."""
    return f"nao_{version.replace('.', '')}.urdf"
