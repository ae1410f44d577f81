"""The XML of a URDF in practice: undeclared namespaces, leftovers of xacro, comments before the declaration."""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any
from urllib.parse import unquote
from xml.etree import ElementTree as ET
from xml.parsers import expat

from nao_kin._core.arrays import finite_decimal, is_several
from nao_kin._core.files import read_bounded
from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadArgument, BadInputFile, BadModel

# Definitions may contain ${…} even in an expanded file, because they are no longer used.
_DEFINITIONS = ("property", "arg", "include")
# The expressions of xacro; other programs also use $(…), but with other names.
_EXPRESSION = re.compile(r"\$\{|\$\((?:anon|arg|cwd|dirname|env|eval|find|optenv)\b")
# A byte order mark and blank lines before the text, and comments and instructions before an XML declaration.
_BEFORE = re.compile(
    rb"\A[ \t\r\n]*(?:\xef\xbb\xbf)?"
    rb"(?:(?:[ \t\r\n]|<!--[^-]*(?:-(?!->)[^-]*)*-->|<\?(?!xml\s)[^?]*(?:\?(?!>)[^?]*)*\?>)*(?=<\?xml\s)|[ \t\r\n]*)"
)


# A function that expands a xacro source; it takes a description of the source for messages, and returns the URDF.
Expand = Callable[[str], bytes]


def read_document(
    path: Path | str, content: bytes, notes: list[str], expand: Expand | None = None, *, always: bool = False
) -> tuple[ET.Element, str]:
    """Return the root element of an XML file without the elements of xacro, and the expanded text of a xacro source.

    Prefixes need not be bound and belong to the name; a namespace declaration is an ordinary attribute; blank lines and
    comments may precede the XML declaration. `expand` takes a description of a xacro source for messages, and returns
    its URDF; None if sources cannot be expanded. With `always`, it is called for any file that mentions xacro.
    """
    document = _document(path, content)
    if b"xacro" not in content and b"${" not in content and b"$(" not in content:
        return document, ""
    source = _Xacro(document, includes=Path(path).suffix == ".xacro")
    if not (source.is_unexpanded or always):
        source.drop(notes)
        return document, ""
    if expand is None:
        raise BadModel(f"{path}: {source.unexpanded}")
    expanded = expand(source.unexpanded)
    document = _document(path, expanded)
    _Xacro(document).drop(notes)
    return document, expanded.decode()


def root_tag(path: Path | str, content: bytes) -> str:
    """Return the name of the root element of an XML file; the rest of the file is not parsed."""
    try:
        return _document(path, content, _RootOnly()).tag
    except _RootFound as root:
        return str(root)


class _RootFound(Exception):
    """The name of the root element."""


class _RootOnly(ET.TreeBuilder):
    def start(self, tag: Any, attributes: Any, /) -> Any:
        raise _RootFound(tag)


def xml_text(content: bytes) -> bytes:
    """Return the content of an XML file from its declaration, or its first comment or element, on."""
    return _BEFORE.sub(b"", content, count=1)


def finite_numbers(text: str) -> list[float]:
    """Return the numbers in a text; an empty list if one of its words is not a finite number."""
    words = text.split()
    numbers = [number for word in words if (number := finite_decimal(word)) is not None]
    return numbers if len(numbers) == len(words) else []


def file_content(path: Path | str) -> bytes:
    """Return the content of a file, read once because it may be a pipe, an endless one: at most 2³⁰ bytes."""
    try:
        with Path(path).open("rb") as file:
            return read_bounded(file, abbreviated(path))
    except BadInputFile as error:
        raise BadModel(str(error)) from None
    except (OSError, ValueError) as error:  # a ValueError for an invalid path
        raise BadModel(f"cannot read {abbreviated(path)}: {getattr(error, 'strerror', None) or error}") from None


def _document(path: Path | str, content: bytes, builder: ET.TreeBuilder | None = None) -> ET.Element:
    """Return the root element; refuse a file that is not well-formed."""
    parser = expat.ParserCreate()  # without namespaces: prefixes are not resolved
    builder = builder or ET.TreeBuilder()
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = builder.start, builder.end
    parser.CharacterDataHandler = builder.data
    text = xml_text(content)
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        line = error.lineno + content[: len(content) - len(text)].count(b"\n")
        where = f"line {line}, column {error.offset + 1}"
        raise BadModel(f"{path}, {where}: not well-formed XML ({expat.ErrorString(error.code)})") from None
    except (LookupError, ValueError) as error:  # an unknown encoding
        raise BadModel(f"cannot read {path}: {error}") from None
    return builder.close()


class _Xacro:
    """The xacro elements in a document: the number of unexpanded ones, and whether the document is still a source.

    It is a source if it defines macros, has ${…} or $(find …) as a value, has links or joints inside an element of
    xacro, includes files and calls their macros, or has no link. With `includes` (a .xacro file), includes count as
    unexpanded.
    """

    def __init__(self, document: ET.Element, *, includes: bool = False) -> None:
        self._document = document
        self._prefixes = {"xacro:"} | {
            f"{name.removeprefix('xmlns:')}:"
            for element in document.iter()
            for name, value in element.attrib.items()
            if name.startswith("xmlns:") and "xacro" in value
        }
        self._found = [name for element in document.iter() if (name := self._name(element)) is not None]
        # Without a definition in this file or an included one, a call is a leftover that cannot be expanded.
        called = [element for element in document if self._name(element) not in (None, *_DEFINITIONS)]
        called = called if "include" in self._found else []
        self.count = sum(
            self._name(element) == "macro"
            or any(_EXPRESSION.search(value) for value in element.attrib.values())
            or (
                self._name(element) is not None
                and (any(part.tag in ("link", "joint") for part in element.iter()) or element in called)
            )
            for element in self._used()
        ) + includes * self._found.count("include")
        self.is_unexpanded = self.count > 0 or (bool(self._found) and document.find("link") is None)

    @property
    def unexpanded(self) -> str:
        """The description of the document in messages."""
        if not self.count:
            return "a xacro source without links of its own"
        return f"a xacro source with {self.count} unexpanded macros, conditions or ${{…}}"

    def drop(self, notes: list[str]) -> None:
        """Remove the elements of xacro."""
        if not self._found:
            return
        kinds = ", ".join(f"<xacro:{name}>" for name in dict.fromkeys(self._found))
        notes.append(f"{len(self._found)} leftover elements of xacro left out: {abbreviated(kinds)}")
        for parent in list(self._document.iter()):
            for child in [child for child in parent if self._name(child) is not None]:
                parent.remove(child)

    def _name(self, element: ET.Element) -> str | None:
        prefix, colon, name = str(element.tag).partition(":")
        return name if prefix + colon in self._prefixes else None

    def _used(self) -> Iterator[ET.Element]:
        """Yield the elements outside of definitions."""
        stack = [self._document]
        while stack:
            current = stack.pop()
            if self._name(current) not in _DEFINITIONS:
                yield current
                stack.extend(current)


# --- The search for files: beside the robot's file, in ROS packages and in Gazebo models.
#
# A package is searched in this order: in the folders given, in the folders above the file, by its `package.xml` at
# any depth of the folders given, in the folders of ROS_PACKAGE_PATH and AMENT_PREFIX_PATH, in those of
# CMAKE_PREFIX_PATH and of Gazebo's variables. The first place that has the file wins.

# Variables with lists of folders. For the first two, packages are in the subfolder "share"; for the others, directly in
# the folders.
_PREFIXES = ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH")
_MODEL_PATHS = ("GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH")
# ROS_PACKAGE_PATH names folders with packages at any depth; ROS searches to this depth.
_MAX_DEPTH = 6
_URI = re.compile(r"(package|model)://+([^/]+)/*(.*)", re.DOTALL)
_NAME = re.compile(rb"<name(?:\s[^>]*)?>\s*([^<\s]+)\s*</name>")
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)


class Packages:
    """The search for the files and packages that a robot's file names.

    Args:
        file: the robot's file.
        folders: packages, or folders of packages, to search first.

    Examples:
        >>> from pathlib import Path
        >>> nao = nk.load_nao()
        >>> packages = nk.urdf.Packages(nao.urdf_path)
        >>> packages.file(nao.tree.visuals[0].geometry.filename).is_file()
        True
    """

    def __init__(self, file: Path, folders: Iterable[Path] = ()) -> None:
        self._folder, self._given = Path(file).resolve().parent, tuple(map(Path, folders))
        self._places: dict[str, tuple[Path, ...]] = {}

    def file(self, name: str) -> Path | None:
        """Return the file that a name means, None if it does not exist.

        Args:
            name: a path relative to the robot's file or from the root, `file://…`, `package://package/…` or
                `model://model/…`.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.tree.packages.file(nao.tree.visuals[0].geometry.filename).is_file()
            True
        """
        try:
            match = _URI.fullmatch(name)
            if match is not None:
                places, inside = self._searched(match[2]), match[3]
            else:
                places, inside = (self._folder,), name.removeprefix("file://")
            candidates = (place / text for place in places for text in dict.fromkeys((inside, unquote(inside))))
            return next((path for path in candidates if path.is_file()), None)
        except (OSError, ValueError):  # an invalid name
            return None

    def folder(self, package: str) -> Path | None:
        """Return the folder of a package, None if it does not exist.

        Examples:
            >>> nk.load_nao().tree.packages.folder("an_unknown_package") is None
            True
        """
        try:
            return next((place for place in self._searched(package) if place.is_dir()), None)
        except (OSError, ValueError):
            return None

    def contain(self, file: Path) -> bool:
        """Return whether a file is in the robot's folder, in the package of that folder, or in a folder given.

        Symbolic links are followed first: a link in the package to a file elsewhere is not in the package.

        Examples:
            >>> nao = nk.load_nao()
            >>> nao.tree.packages.contain(nao.urdf_path), nao.tree.packages.contain("/etc/hostname")
            (True, False)
        """
        above = (self._folder, *self._folder.parents)
        package = next((folder for folder in above if (folder / "package.xml").is_file()), self._folder)
        real = Path(os.path.realpath(file))
        return any(real.is_relative_to(os.path.realpath(folder)) for folder in (package, *self._given))

    def _searched(self, package: str) -> tuple[Path, ...]:
        if package not in self._places:
            self._places[package] = tuple(dict.fromkeys(self._candidates(package)))
        return self._places[package]

    def _candidates(self, package: str) -> Iterator[Path]:
        for folder in (*self._given, *self._folder.parents, self._folder):
            yield folder / package
            if _is_package(folder, package):
                yield folder
        for folder in self._given:
            if not (folder / package).is_dir():
                yield from _below(folder, package, _MAX_DEPTH)
        for folder in _listed("ROS_PACKAGE_PATH"):
            yield from _below(folder, package, _MAX_DEPTH)
        for variable in (*_PREFIXES, *_MODEL_PATHS):
            inner = "share" if variable in _PREFIXES else ""
            yield from (folder / inner / package for folder in _listed(variable))


def checked_folders(folders: object) -> tuple[Path, ...]:
    """Return folders to search for packages as absolute paths; raise `BadArgument` if one does not exist."""
    if not is_several(folders):
        raise BadArgument(f"package_dirs must be several folders, as in a list, got {quoted(folders)}")
    found = tuple(Path(folder).absolute() for folder in folders)
    for folder in found:
        if not folder.is_dir():
            raise BadArgument(f"package_dirs: there is no folder {quoted(str(folder))}")
    return found


def _listed(variable: str) -> list[Path]:
    """Return the folders in an environment variable as absolute paths."""
    return [Path(entry).absolute() for entry in os.environ.get(variable, "").split(os.pathsep) if entry]


def _below(folder: Path, package: str, depth: int) -> Iterator[Path]:
    """Yield the folders of a package at or below a folder; packages contain no packages."""
    if folder.name == package or _is_package(folder, package):
        yield folder
    elif depth and not (folder / "package.xml").is_file():
        try:
            inside = sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
        except OSError:  # missing or not readable
            return
        for below in inside:
            yield from _below(below, package, depth - 1)


def _is_package(folder: Path, package: str) -> bool:
    """Return whether the package.xml of a folder names this package; the folder may have another name."""
    try:
        text = (folder / "package.xml").read_bytes()
    except OSError:
        return False
    match = _NAME.search(_COMMENT.sub(b"", text))
    return match is not None and match[1] == os.fsencode(package)


# --- Expansion of xacro sources by the package `xacro`, with our search for `$(find package)`.

# xacro keeps its current file, arguments and macros in variables of its module, so one thread uses it at a time.
_EXPANDING = threading.Lock()
# The package in which xacro looks up ROS packages; it is part of ROS 2 and not on PyPI.
_ROS_INDEX = "ament_index_python"


def expand_xacro(
    path: Path, content: bytes, notes: list[str], *, arguments: Mapping[str, object], packages: Packages, what: str
) -> bytes:
    """Return the URDF of a xacro source, whose expressions are Python code with all rights of this process."""
    try:
        import xacro
    except ImportError:
        target = path.name.removesuffix(".xacro").removesuffix(".urdf") + ".urdf"
        raise BadModel(
            f"{path}: {what}; pip install 'nao-kin[xacro]' to read it directly, or expand it first: "
            f"xacro {path.name} -o {target if target != path.name else 'expanded.urdf'}"
        ) from None
    warnings = io.StringIO()
    try:
        with _EXPANDING, _found_by(packages), contextlib.redirect_stderr(warnings):
            xacro.init_stacks(str(path.absolute()))
            document = xacro.parse(io.BytesIO(xml_text(content)))
            xacro.process_doc(document, mappings=xacro_values(arguments))
            expanded: bytes = document.toxml(encoding="utf-8")
    except (Exception, SystemExit) as error:  # its expressions may raise anything
        raise BadModel(f"{path}: xacro refuses it: {abbreviated(error) or type(error).__name__}") from None
    first = warnings.getvalue().split("\n", 1)[0]
    if first.strip():
        notes.append(f"xacro says: {abbreviated(first)}")
    return expanded


def xacro_values(arguments: Mapping[str, object] | None) -> dict[str, str]:
    """Return arguments for xacro as texts, with true and false in lower case; an empty dictionary for None."""
    given = (arguments or {}).items()
    return {name: str(value).lower() if isinstance(value, bool) else str(value) for name, value in given}


@contextlib.contextmanager
def _found_by(packages: Packages) -> Iterator[None]:
    """Make xacro find ROS packages as `packages` does."""

    def share_directory(name: str) -> str:
        folder = packages.folder(name)
        if folder is None:
            raise LookupError(
                f"package {quoted(name)} is in none of the folders given, nor in ROS_PACKAGE_PATH or AMENT_PREFIX_PATH"
            )
        return str(folder)

    module, inside = ModuleType(_ROS_INDEX), ModuleType(f"{_ROS_INDEX}.packages")
    inside.get_package_share_directory = share_directory  # type: ignore[attr-defined]
    module.packages = inside  # type: ignore[attr-defined]
    names = (_ROS_INDEX, f"{_ROS_INDEX}.packages")
    before = {name: sys.modules[name] for name in names if name in sys.modules}
    sys.modules.update(zip(names, (module, inside), strict=True))
    try:
        yield
    finally:
        for name in names:
            del sys.modules[name]
        sys.modules.update(before)
