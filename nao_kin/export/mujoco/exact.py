"""Full precision in what MuJoCo writes: it writes six digits, by which the feet would be off by some micrometres."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

# Element → its attributes, as the specification has them too.
_ATTRIBUTES = {
    "body": ("pos", "quat"),
    "joint": ("axis", "range", "damping", "armature", "frictionloss"),
    "geom": ("pos", "quat", "size"),
    "site": ("pos", "quat", "size"),
    "camera": ("pos", "quat", "fovy"),
    "general": ("ctrlrange", "forcerange", "gainprm", "biasprm"),
    "key": ("qpos", "ctrl"),
}
_DEFAULTS = {"pos": (0.0, 0.0, 0.0), "quat": (1.0, 0.0, 0.0, 0.0)}
# What MuJoCo has written must be the same number, to its six digits.
_ROUNDED = 2e-5


def exact_xml(spec: Any) -> str:
    """The XML of a compiled specification, with the numbers that it holds and not their first six digits."""
    root = ET.fromstring(spec.to_xml())
    sources = {
        "body": spec.bodies,
        "joint": spec.joints,
        "geom": spec.geoms,
        "site": spec.sites,
        "camera": spec.cameras,
        "general": spec.actuators,
        "key": spec.keys,
    }
    for tag, attributes in _ATTRIBUTES.items():
        named = {one.name: one for one in sources[tag]}
        for element in _elements(root, tag):
            one = named[element.get("name", "")]
            for attribute in attributes:
                _put(element, attribute, _numbers(getattr(one, attribute)))
    for body, element in _pairs(spec.bodies, _elements(root, "body")):
        inertial = element.find("inertial")
        if inertial is not None:
            inertial.attrib.clear()
            for attribute in ("pos", "mass", "fullinertia"):
                value = body.ipos if attribute == "pos" else getattr(body, attribute)
                inertial.set(attribute, _text(_numbers(value)))
    for equality, element in _pairs(spec.equalities, root.iterfind("equality/joint")):
        element.set("polycoef", _text(_numbers(equality.data)[:5]))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _elements(root: ET.Element, tag: str) -> Iterator[ET.Element]:
    """The elements of a kind that have a name; those of a class have none."""
    part = {"general": "actuator", "key": "keyframe"}.get(tag, "worldbody")
    return (element for element in root.iterfind(f"{part}//{tag}") if element.get("name"))


def _pairs(named: Iterable[Any], elements: Iterable[ET.Element]) -> Iterator[tuple[Any, ET.Element]]:
    by_name = {one.name: one for one in named}
    return ((by_name[element.get("name", "")], element) for element in elements)


def _put(element: ET.Element, attribute: str, exact: list[float]) -> None:
    written = element.get(attribute)
    if written is None:
        default = _DEFAULTS.get(attribute)
        if default is not None and tuple(exact) != default and np.allclose(exact, default, atol=_ROUNDED):
            element.set(attribute, _text(exact))
        return
    rough = [float(word) for word in written.split()]
    exact = exact[: len(rough)]
    if np.allclose(rough, exact, rtol=_ROUNDED, atol=1e-12):
        element.set(attribute, _text(exact))


def _numbers(value: Any) -> list[float]:
    return [float(number) + 0.0 for number in np.atleast_1d(value)]


def _text(numbers: Iterable[float]) -> str:
    return " ".join(repr(number).removesuffix(".0") for number in numbers)
