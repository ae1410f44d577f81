"""The common steps of all exports: check the robot and the path, and write all files or none."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._core.files import check_folder, check_replaceable, write_document, write_folder
from nao_kin._core.text import one_line_repr
from nao_kin.robot.urdf import Box, Cylinder, Sphere


@one_line_repr
@dataclass(frozen=True)
class Exported:
    """The result of an export.

    Attributes:
        path: the file to load, or the folder of the package.
        files: every file that was written.
        changes: how they differ from the robot, one line each.
    """

    path: Path
    files: tuple[Path, ...]
    changes: tuple[str, ...] = ()


class Destination:
    """The path of an export of a robot, checked before any work: a document with files next to it, or a folder."""

    def __init__(self, path: Path | str, *, overwrite: bool, folder: bool = False) -> None:
        (check_folder if folder else check_replaceable)(path, overwrite=overwrite)
        self._path, self._overwrite, self._folder = path, overwrite, folder

    def write(self, files: Mapping[str, bytes], changes: tuple[str, ...], main: str = "") -> Exported:
        """Write the files, all or none, with `changes` as lines of the result.

        The names in `files` are relative to the folder, or to the folder of the document, which itself has the name "".
        `main` is the name of the file to load; "" for the document or the folder itself.
        """
        if self._folder:
            written = write_folder(self._path, files, overwrite=self._overwrite)
        else:
            extras = {name: content for name, content in files.items() if name}
            written = write_document(self._path, files[""], extras, overwrite=self._overwrite)
        return Exported(Path(self._path) / main, written, changes)


def number(value: float) -> str:
    """Return the shortest text that reads back as the same float; no sign on zero."""
    text = repr(float(value) + 0.0)
    return text[:-2] if text.endswith(".0") else text


def numbers(values: Iterable[float]) -> str:
    """Return several numbers separated by blanks."""
    return " ".join(map(number, values))


def number_texts(values: Mapping[str, float]) -> dict[str, str]:
    """Return name → number as a text."""
    return {name: number(value) for name, value in values.items()}


def primitive_texts(shape: Box | Cylinder | Sphere) -> tuple[str, dict[str, str]]:
    """Return the element of a primitive shape and its dimensions as texts, the same in URDF and in SDFormat."""
    return type(shape).__name__.lower(), {name: numbers(np.atleast_1d(size)) for name, size in vars(shape).items()}


def xml_text(root: ET.Element, declaration: str = 'version="1.0"') -> str:
    """Return the document, indented, with its declaration and a newline at its end."""
    ET.indent(root)
    return f"<?xml {declaration}?>\n{ET.tostring(root, encoding='unicode')}\n"


# The declaration of URDF and SRDF files.
UTF_8 = 'version="1.0" encoding="utf-8"'


def add_texts(element: ET.Element, texts: Mapping[str, str]) -> None:
    """Add a subelement with a text for each entry."""
    for tag, text in texts.items():
        ET.SubElement(element, tag).text = text


_TEMPLATES = Path(__file__).resolve().parent / "templates"


def filled(template: str, **values: object) -> str:
    """Return a file of templates/ with values in place of $name."""
    return Template((_TEMPLATES / f"{template}.in").read_text(encoding="utf-8")).substitute(values)
