"""Any URDF, read leniently and made honest: what Pinocchio needs, and a note for everything that had to change.

Files in the wild couple joints in an order Pinocchio refuses, name a joint and a link alike, let a `continuous` joint
mimic a `revolute` one, or round their axes. `read_urdf` mends all of that and records it; what cannot be mended is
refused. Geometry plays no part here: links keep their inertia and lose their shapes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

from nao_kin._scalars import decimal
from nao_kin.errors import BadModel
from nao_kin.urdf_reader.coupling import CouplingRefused, drive_order, resolve_chains, share_limits
from nao_kin.urdf_reader.tree import Mimic, UrdfInertial, UrdfJoint, UrdfTree

_MOVING = ("revolute", "continuous", "prismatic")


def read_urdf(path: Path | str) -> UrdfTree:
    """Read and mend a URDF file.

    Raises:
        BadModel: the file cannot be read, is no URDF, or describes no tree of supported joints.
    """
    try:
        path = Path(path)
    except TypeError:
        raise BadModel(f"expected the path of a URDF file, got {path!r}") from None
    try:
        document = ET.parse(path).getroot()
    except OSError as error:
        raise BadModel(f"cannot read {path}: {error.strerror or error}") from None
    except (LookupError, ValueError) as error:  # an encoding nobody knows, a path no system takes
        raise BadModel(f"cannot read {path}: {error}") from None
    except ET.ParseError as error:
        line, column = error.position
        reason = str(error).split(":", 1)[0]
        raise BadModel(f"{path}, line {line}, column {column + 1}: not well-formed XML ({reason})") from None
    try:
        return _Reader(document, path).tree()
    except _Refused as refusal:
        raise BadModel(f"{path}: {refusal}") from None


class _Refused(Exception):
    """Why a file makes no model; `read_urdf` adds the file's name."""


class _Reader:
    def __init__(self, document: ET.Element, path: Path) -> None:
        self.document, self.path = document, path
        self.notes: list[str] = []

    def tree(self) -> UrdfTree:
        if self.document.tag != "robot":
            raise _Refused(f"the root element is <{self.document.tag}>, a URDF has <robot>")
        unexpanded = [element for element in self.document.iter() if "xacro" in str(element.tag)]
        if unexpanded:
            raise _Refused(f"a xacro source with {len(unexpanded)} unexpanded macros; run xacro on it first")
        links = self._unique("link")
        joint_elements = self._unique("joint")
        renamed = self._names_apart(links, joint_elements)
        joints = {name: self._joint(name, element, renamed) for name, element in joint_elements.items()}
        link_names = [renamed.get(name, name) for name in links]
        root = self._root(link_names, joints.values())
        try:
            joints = resolve_chains(joints, self.notes)
            order = share_limits(drive_order(joints, root, self.notes), self.notes)
        except CouplingRefused as error:
            raise _Refused(str(error)) from None
        self._note_missing_meshes()
        return UrdfTree(
            name=self.document.get("name", "robot"),
            root=root,
            links=tuple(link_names),
            inertials={
                renamed.get(name, name): inertial
                for name, element in links.items()
                if (inertial := self._inertial(name, element.find("inertial"))) is not None
            },
            joints=tuple(order),
            notes=tuple(self.notes),
        )

    def _unique(self, tag: str) -> dict[str, ET.Element]:
        """The elements of one kind by name; those inside transmissions and plugins are no part of the tree."""
        found: dict[str, ET.Element] = {}
        for element in self.document.findall(tag):
            name = element.get("name", "")
            if not name:
                raise _Refused(f"a <{tag}> without a name")
            if name in found:
                raise _Refused(f"two {tag}s named {name!r}")
            found[name] = element
        if tag == "link" and not found:
            raise _Refused("no links")
        return found

    def _names_apart(self, links: dict[str, ET.Element], joints: dict[str, ET.Element]) -> dict[str, str]:
        """New names for links that share theirs with a joint."""
        renamed: dict[str, str] = {}
        for name in links:
            if name in joints:
                endings = itertools.chain(("_link", "_frame"), (f"_frame_{n}" for n in itertools.count(2)))
                fresh = next(name + end for end in endings if name + end not in links and name + end not in joints)
                renamed[name] = fresh
                self.notes.append(f"link {name!r} renamed {fresh!r}: a joint has the same name")
        return renamed

    def _joint(self, name: str, element: ET.Element, renamed: dict[str, str]) -> UrdfJoint:
        kind = element.get("type", "")
        if kind not in (*_MOVING, "fixed"):
            raise _Refused(
                f"joint {name!r} has type {kind!r}; supported: {', '.join(_MOVING)}, fixed "
                "(a free base is asked for with base='floating')"
            )
        ends = []
        for tag in ("parent", "child"):
            end = element.find(tag)
            if end is None or not end.get("link"):
                raise _Refused(f"joint {name!r} names no {tag} link")
            ends.append(renamed.get(str(end.get("link")), str(end.get("link"))))
        xyz, rpy = self._origin(f"joint {name!r}", element.find("origin"))
        xyz_text, rpy_text = (" ".join(map(repr, vector)) for vector in (xyz, rpy))
        joint = UrdfJoint(name, kind, ends[0], ends[1], xyz_text, rpy_text, (1.0, 0.0, 0.0))
        return joint if kind == "fixed" else self._moving_joint(joint, element)

    def _moving_joint(self, joint: UrdfJoint, element: ET.Element) -> UrdfJoint:
        name = joint.name
        limit, mimic = element.find("limit"), element.find("mimic")
        joint = replace(joint, axis=self._axis(name, element.find("axis")))
        if limit is not None:
            joint = replace(
                joint,
                velocity=self._bound(name, limit, "velocity"),
                effort=self._bound(name, limit, "effort"),
            )
        if joint.kind == "continuous":
            joint = replace(joint, kind="revolute")
            if mimic is None:
                self.notes.append(f"joint {name!r} is continuous: one revolute coordinate without limits")
            else:
                self.notes.append(f"joint {name!r} is continuous and follows another: taken as revolute")
        elif limit is None:
            self.notes.append(f"joint {name!r} has no limits")
        else:
            lower, upper = (self._number(f"joint {name!r}", limit, bound, 0.0) for bound in ("lower", "upper"))
            if lower > upper:
                raise _Refused(f"joint {name!r} has lower limit {lower:g} above upper limit {upper:g}")
            if math.isinf(upper - lower):
                raise _Refused(f"joint {name!r} has a range from {lower:g} to {upper:g}, which is beyond all measure")
            joint = replace(joint, lower=lower, upper=upper)
        if mimic is not None:
            coupling = Mimic(
                str(mimic.get("joint", "")),
                self._number(f"joint {name!r}", mimic, "multiplier", 1.0),
                self._number(f"joint {name!r}", mimic, "offset", 0.0),
            )
            joint = replace(joint, mimic=coupling)
        return joint

    def _axis(self, joint: str, element: ET.Element | None) -> tuple[float, float, float]:
        text = "1 0 0" if element is None else element.get("xyz", "1 0 0")
        x, y, z = self._three(f"joint {joint!r}", "axis", text)
        length = math.hypot(x, y, z)
        if not 1e-9 < length < 1e9:
            raise _Refused(f"joint {joint!r} has axis {text!r}, which has no direction")
        if abs(length - 1.0) > 1e-12:
            self.notes.append(f"joint {joint!r} has axis {text!r} of length {length:.7g}: normalised")
        return x / length, y / length, z / length

    def _inertial(self, link: str, element: ET.Element | None) -> UrdfInertial | None:
        if element is None:
            return None
        owner = f"link {link!r}"
        mass = element.find("mass")
        if mass is None or mass.get("value") is None:
            self.notes.append(f"{owner} has an inertia and no mass: taken as massless")
            return None
        value = self._number(owner, mass, "value", 0.0)
        if value < 0.0:
            raise _Refused(f"{owner} has mass {value:g}")
        tensor = element.find("inertia")
        if tensor is None:
            self.notes.append(f"{owner} has a mass and no inertia: taken as a point mass")
        labels = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        xx, xy, xz, yy, yz, zz = (0.0 if tensor is None else self._number(owner, tensor, k, 0.0) for k in labels)
        return UrdfInertial(value, *self._origin(owner, element.find("origin")), (xx, xy, xz, yy, yz, zz))

    def _origin(
        self, owner: str, element: ET.Element | None
    ) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        if element is None:
            return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        xyz, rpy = element.get("xyz", "0 0 0"), element.get("rpy", "0 0 0")
        return self._three(owner, "origin xyz", xyz), self._three(owner, "origin rpy", rpy)

    def _three(self, owner: str, what: str, text: str) -> tuple[float, float, float]:
        try:
            x, y, z = map(decimal, text.split())
        except ValueError:
            raise _Refused(f"{owner} has {what} {text!r}, expected three numbers") from None
        return x, y, z

    def _number(self, owner: str, element: ET.Element, attribute: str, default: float) -> float:
        text = element.get(attribute)
        if text is None:
            return default
        try:
            return decimal(text)
        except ValueError:
            raise _Refused(f"{owner} has {attribute} {text!r}, expected a number") from None

    def _bound(self, joint: str, limit: ET.Element, attribute: str) -> float:
        """A largest speed or effort; "inf" and no word mean that there is none."""
        if limit.get(attribute, "inf").strip().lower() in ("inf", "+inf", "infinity"):
            return math.inf
        value = self._number(f"joint {joint!r}", limit, attribute, math.inf)
        if value < 0.0:
            raise _Refused(f"joint {joint!r} has {attribute} {value:g}, expected none or more")
        return value

    def _root(self, links: list[str], joints: Iterable[UrdfJoint]) -> str:
        """The one link that no joint moves, in a graph that is a tree."""
        known, carried = set(links), dict[str, str]()
        for joint in joints:
            for end in (joint.parent, joint.child):
                if end not in known:
                    raise _Refused(f"joint {joint.name!r} names a link {end!r} that does not exist")
            if joint.child in carried:
                raise _Refused(
                    f"link {joint.child!r} is moved by two joints, {carried[joint.child]!r} and {joint.name!r}"
                )
            carried[joint.child] = joint.name
        roots = [name for name in links if name not in carried]
        if len(roots) != 1:
            found = ", ".join(map(repr, roots[:4])) or "none: the joints form a loop"
            raise _Refused(f"a robot has one root link, found {found}")
        # One root and one parent each: what is still unreachable hangs in a loop of its own.
        children: dict[str, list[str]] = {}
        for joint in joints:
            children.setdefault(joint.parent, []).append(joint.child)
        reached, stack = set[str](), [roots[0]]
        while stack:
            link = stack.pop()
            reached.add(link)
            stack.extend(children.get(link, []))
        if len(reached) != len(links):
            raise _Refused(f"link {next(n for n in links if n not in reached)!r} hangs in a loop of joints")
        return roots[0]

    def _note_missing_meshes(self) -> None:
        meshes = {mesh.get("filename", "") for mesh in self.document.iter("mesh")}
        missing = sorted(name for name in meshes if not self._mesh_exists(name))
        if missing:
            self.notes.append(f"{len(missing)} of {len(meshes)} mesh files are not there, first {missing[0]!r}")

    def _mesh_exists(self, name: str) -> bool:
        folder = self.path.resolve().parent
        if not name.startswith("package://"):
            return (folder / name.removeprefix("file://")).is_file()
        inside = name.removeprefix("package://").lstrip("/")
        return any((parent / inside).is_file() for parent in folder.parents)
