"""The XML of a URDF, read as people write it: URDF knows no namespaces, and what xacro left behind is no part of it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET
from xml.parsers import expat

from nao_kin._common.input_text import read_bounded
from nao_kin._text import abbreviated
from nao_kin.errors import BadInputFile, BadModel

# What may hold ${…} without meaning that the file is still a source: it defines, and nothing uses it any more.
_DEFINITIONS = ("property", "arg", "include")
# What xacro puts values in place of; other programs write $(…) too, with words of their own.
_EXPRESSION = re.compile(r"\$\{|\$\((?:anon|arg|cwd|dirname|env|eval|find|optenv)\b")
_BLANK = re.compile(rb"[ \t\r\n]*(\xef\xbb\xbf)?[ \t\r\n]*")


# Makes the text of a URDF of a xacro source, given what the source is in words.
Expand = Callable[[str], bytes]


def read_document(
    path: Path | str, content: bytes, notes: list[str], expand: Expand | None = None, *, always: bool = False
) -> tuple[ET.Element, str]:
    """The root element of an XML file, without what xacro left in it.

    Prefixes need not be bound and belong to the name; a namespace declaration is an attribute like any other; blank
    lines may stand before the XML declaration.

    Args:
        path: the file.
        content: what it holds.
        notes: gets a line for what was dropped.
        expand: what makes a URDF of a xacro source; None where there is nothing that does.
        always: expand whatever mentions xacro, whether or not it looks finished.

    Returns:
        The root element, and the text that it was read from where that is not the file's.

    Raises:
        BadModel: the file is not well-formed, or is a xacro source that cannot be expanded.
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
    """The name of the root element of an XML file; what stands behind it is not looked at.

    Args:
        path: the file.
        content: what it holds.

    Raises:
        BadModel: it does not begin as XML.
    """
    found: list[str] = []

    def start(tag: str, attributes: dict[str, str]) -> Any:
        found.append(tag)
        raise _Enough

    try:
        _parsed(content, start)
    except _Enough:
        return found[0]
    except expat.ExpatError as error:
        raise _not_well_formed(path, content, error) from None
    except (LookupError, ValueError) as error:  # an encoding nobody knows
        raise BadModel(f"cannot read {path}: {error}") from None
    raise BadModel(f"{path}: no element in it")


class _Enough(Exception):
    """The root element has been met."""


def file_content(path: Path | str) -> bytes:
    """What a file holds, read once: a pipe gives it no second time.

    Raises:
        BadModel: it cannot be read, or is a pipe or device of more than 2³⁰ bytes, which may have no end.
    """
    try:
        with Path(path).open("rb") as file:
            return read_bounded(file, abbreviated(path))
    except BadInputFile as error:
        raise BadModel(str(error)) from None
    except TypeError:
        raise BadModel(f"expected the path of a robot's file, got {abbreviated(repr(path))}") from None
    except OSError as error:
        raise BadModel(f"cannot read {abbreviated(path)}: {error.strerror or error}") from None
    except ValueError as error:  # a path no system takes
        raise BadModel(f"cannot read {abbreviated(path)}: {error}") from None


def _document(path: Path | str, content: bytes) -> ET.Element:
    builder: ET.TreeBuilder = ET.TreeBuilder()

    def start(tag: str, attributes: dict[str, str]) -> Any:
        builder.start(tag, attributes)

    try:
        _parsed(content, start, builder)
        return builder.close()
    except expat.ExpatError as error:
        raise _not_well_formed(path, content, error) from None
    except (LookupError, ValueError) as error:  # an encoding nobody knows
        raise BadModel(f"cannot read {path}: {error}") from None


def _not_well_formed(path: Path | str, content: bytes, error: expat.ExpatError) -> BadModel:
    line = error.lineno + content[: _blank(content)].count(b"\n")
    where = f"line {line}, column {error.offset + 1}"
    return BadModel(f"{path}, {where}: not well-formed XML ({expat.ErrorString(error.code)})")


def _parsed(content: bytes, start: Callable[[str, dict[str, str]], Any], builder: ET.TreeBuilder | None = None) -> None:
    parser = expat.ParserCreate()  # without namespaces: prefixes stay as they are written
    parser.buffer_text = True
    parser.StartElementHandler = start
    if builder is not None:
        parser.EndElementHandler = builder.end
        parser.CharacterDataHandler = builder.data
    parser.Parse(content[_blank(content) :], True)


def _blank(content: bytes) -> int:
    """How many bytes of blank lines, and of a byte order mark among them, stand before the text."""
    match = _BLANK.match(content)
    return match.end() if match else 0


def _holds_robot(element: ET.Element) -> bool:
    """Whether links or joints stand inside an element."""
    return element.find(".//link") is not None or element.find(".//joint") is not None


class _Xacro:
    """The elements of xacro in a document.

    Attributes:
        count: how much of it is unexpanded: macros, conditions, ${…}.
        is_unexpanded: whether the document is still a source: it defines macros, holds ${…} or $(find …) where a value
            should be, has links or joints inside an element of xacro, includes files and calls what they may define, or
            has no link at all.

    Args:
        document: the root element.
        includes: whether what it includes is missing from it, as in a file that is named a source.
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
        # Without a definition here or in a file that is included, a call is a leftover that nothing can expand.
        called = [element for element in document if self._name(element) not in (None, *_DEFINITIONS)]
        called = called if "include" in self._found else []
        self.count = sum(
            self._name(element) == "macro"
            or any(_EXPRESSION.search(value) for value in element.attrib.values())
            or (self._name(element) is not None and (_holds_robot(element) or element in called))
            for element in self._used()
        ) + includes * self._found.count("include")
        self.is_unexpanded = self.count > 0 or (bool(self._found) and document.find("link") is None)

    @property
    def unexpanded(self) -> str:
        """What the document is, in words."""
        if not self.count:
            return "a xacro source without links of its own"
        return f"a xacro source with {self.count} unexpanded macros, conditions or ${{…}}"

    def drop(self, notes: list[str]) -> None:
        """Take the elements out."""
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
        """The elements outside of what merely defines."""
        stack = [self._document]
        while stack:
            current = stack.pop()
            if self._name(current) not in _DEFINITIONS:
                yield current
                stack.extend(current)
