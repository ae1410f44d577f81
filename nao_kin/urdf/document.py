"""The XML of a URDF, read as people write it: URDF knows no namespaces, and what xacro left behind is no part of it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET
from xml.parsers import expat

from nao_kin._text import abbreviated
from nao_kin.errors import BadModel

# What may hold ${…} without meaning that the file is still a source: it defines, and nothing uses it any more.
_DEFINITIONS = ("property", "arg", "include")
_BLANK = re.compile(rb"[ \t\r\n]*(\xef\xbb\xbf)?[ \t\r\n]*")


def read_document(path: Path | str, notes: list[str]) -> ET.Element:
    """The root element of an XML file, without what xacro left in it.

    Prefixes need not be bound and belong to the name; a namespace declaration is an attribute like any other; blank
    lines may stand before the XML declaration.

    Args:
        path: the file.
        notes: gets a line for what was dropped.

    Raises:
        BadModel: the file cannot be read, is not well-formed, or is a xacro source.
    """
    try:
        content = Path(path).read_bytes()
    except TypeError:
        raise BadModel(f"expected the path of a URDF file, got {abbreviated(repr(path))}") from None
    except OSError as error:
        raise BadModel(f"cannot read {abbreviated(path)}: {error.strerror or error}") from None
    except ValueError as error:  # a path no system takes
        raise BadModel(f"cannot read {abbreviated(path)}: {error}") from None
    try:
        document = _parsed(content)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        line = error.lineno + content[: _blank(content)].count(b"\n")
        where = f"line {line}, column {error.offset + 1}"
        raise BadModel(f"{path}, {where}: not well-formed XML ({reason})") from None
    except (LookupError, ValueError) as error:  # an encoding nobody knows
        raise BadModel(f"cannot read {path}: {error}") from None
    if b"xacro" in content or b"${" in content:
        _drop_xacro(document, Path(path), notes)
    return document


def _parsed(content: bytes) -> ET.Element:
    builder: ET.TreeBuilder = ET.TreeBuilder()
    parser = expat.ParserCreate()  # without namespaces: prefixes stay as they are written
    parser.buffer_text = True

    def start(tag: str, attributes: dict[str, str]) -> Any:
        builder.start(tag, attributes)

    parser.StartElementHandler = start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    parser.Parse(content[_blank(content) :], True)
    return builder.close()


def _blank(content: bytes) -> int:
    """How many bytes of blank lines, and of a byte order mark among them, stand before the text."""
    match = _BLANK.match(content)
    return match.end() if match else 0


def _drop_xacro(document: ET.Element, path: Path, notes: list[str]) -> None:
    """Take leftover xacro elements out.

    Raises:
        BadModel: the file is still a source: it defines macros, holds ${…} where a value should stand, or has links
            inside an element of xacro.
    """
    prefixes = {"xacro:"} | {
        f"{name.removeprefix('xmlns:')}:"
        for element in document.iter()
        for name, value in element.attrib.items()
        if name.startswith("xmlns:") and "xacro" in value
    }

    def xacro_name(element: ET.Element) -> str | None:
        prefix, colon, name = str(element.tag).partition(":")
        return name if prefix + colon in prefixes else None

    found = [name for element in document.iter() if (name := xacro_name(element)) is not None]
    unexpanded = sum(
        xacro_name(element) == "macro"
        or any("${" in value for value in element.attrib.values())
        or (xacro_name(element) is not None and element.find(".//link") is not None)
        for element in _used(document, xacro_name)
    )
    if unexpanded:
        target = path.name.removesuffix(".xacro").removesuffix(".urdf") + ".urdf"
        raise BadModel(
            f"{path}: a xacro source with {unexpanded} unexpanded macros, conditions or ${{…}}; expand it first: "
            f"xacro {path.name} -o {target if target != path.name else 'expanded.urdf'}"
        )
    if found:
        kinds = ", ".join(f"<xacro:{name}>" for name in dict.fromkeys(found))
        notes.append(f"{len(found)} leftover elements of xacro left out: {abbreviated(kinds)}")
        for parent in list(document.iter()):
            for child in [child for child in parent if xacro_name(child) is not None]:
                parent.remove(child)


def _used(element: ET.Element, xacro_name: Any) -> Iterator[ET.Element]:
    """The elements outside of what merely defines."""
    stack = [element]
    while stack:
        current = stack.pop()
        if xacro_name(current) not in _DEFINITIONS:
            yield current
            stack.extend(current)
