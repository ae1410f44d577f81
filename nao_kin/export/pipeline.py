"""What every export does first and last: check the robot and the path, and write files, all or none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template
from xml.etree import ElementTree as ET

from nao_kin._core.files import check_folder, check_replaceable, write_document, write_folder
from nao_kin.robot import RobotModel, check_robot


@dataclass(frozen=True)
class Exported:
    """An export that is done.

    Attributes:
        path: the file to load, or the folder of the package.
        files: every file that was written.
        changes: what in them differs from the robot, one line each.

    Examples:
        >>> done = nk.export.urdf(nk.load_nao("v5"), "nao.urdf", coupling="locked", meshes="none")
        >>> [str(file) for file in done.files], done.changes[1]
        (['nao.urdf'], 'LHipYawPitch is fixed at 0, and with it what follows it: RHipYawPitch')
    """

    path: Path
    files: tuple[Path, ...]
    changes: tuple[str, ...] = ()


class Target:
    """Where an export goes, checked before the work whose result is written there.

    Args:
        robot: what is exported.
        path: the file or folder to write.
        overwrite: replace what is there.
        folder: write a folder, not a document with files beside it.

    Raises:
        BadArgument: no robot; something is there already, or nothing can be written there.
    """

    def __init__(self, robot: RobotModel, path: Path | str, *, overwrite: bool, folder: bool = False) -> None:
        check_robot(robot)
        (check_folder if folder else check_replaceable)(path, overwrite=overwrite)
        self._path, self._overwrite, self._folder = path, overwrite, folder

    def write(self, files: Mapping[str, bytes], changes: tuple[str, ...], main: str = "") -> Exported:
        """Write the files, all or none.

        Args:
            files: name → content. In a folder the names are relative to it; "" is the document where that is one file,
                and the other names are relative to the folder that it lies in.
            changes: what in them differs from the robot, one line each.
            main: name of the file to load; "" for the document or the folder itself.
        """
        if self._folder:
            written = write_folder(self._path, files, overwrite=self._overwrite)
        else:
            beside = {name: content for name, content in files.items() if name}
            written = write_document(self._path, files[""], beside, overwrite=self._overwrite)
        return Exported(Path(self._path) / main, written, changes)


def xml_text(root: ET.Element) -> str:
    """Return the document, indented, with its declaration and a newline at its end."""
    ET.indent(root)
    return '<?xml version="1.0"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def add_texts(element: ET.Element, texts: Mapping[str, str]) -> None:
    """Add to an element one with a text for each entry."""
    for tag, text in texts.items():
        ET.SubElement(element, tag).text = text


_TEMPLATES = Path(__file__).resolve().parent / "templates"


def filled(template: str, **values: object) -> str:
    """Return the text of a file in templates/, with values for what stands in it as $name."""
    return Template((_TEMPLATES / f"{template}.in").read_text(encoding="utf-8")).substitute(values)
