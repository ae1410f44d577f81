"""The reader of URDF files: lenient, with a note for every repair.

Real files couple joints in an order that Pinocchio refuses, name a joint and a link alike, let a `continuous` joint
mimic a `revolute` one, or round their axes. `read_urdf` repairs all of that; other faults are refused. Notes also name
what this library does not use, and numbers that no robot has.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal
from xml.etree import ElementTree as ET

from nao_kin._core.arrays import Vector, flag
from nao_kin._core.text import abbreviated, quoted
from nao_kin.errors import BadArgument, BadModel
from nao_kin.robot.semantics import Mimic, Semantics
from nao_kin.robot.urdf.couplings import Refused, depth_first, drive_order, resolve_chains, share_limits
from nao_kin.robot.urdf.document import (
    Packages,
    checked_folders,
    expand_xacro,
    file_content,
    finite_numbers,
    read_document,
    root_tag,
    xacro_values,
)
from nao_kin.robot.urdf.mjcf import read_mjcf
from nao_kin.robot.urdf.notes import notes_on_elements, notes_on_numbers, notes_on_shapes, notes_on_words
from nao_kin.robot.urdf.tree import (
    TENSOR_LABELS,
    Inertial,
    Origin,
    UnreadableShape,
    UrdfJoint,
    UrdfTree,
    has_quaternions,
    read_origin,
    read_shapes,
    rename_links,
)

# The owner of an attribute, for messages: "joint" or "link", and its name.
Owner = tuple[str, str]

_MOVING = ("revolute", "continuous", "prismatic")
_FLOATING = "floating"


def read_urdf(
    path: Path | str,
    *,
    package_dirs: Iterable[Path | str] = (),
    xacro: bool | None = None,
    xacro_arguments: Mapping[str, object] | None = None,
    content: bytes | None = None,
) -> UrdfTree:
    """Return the tree of a URDF file, or of a xacro source (nao-kin[xacro]); the arguments are those of `read_robot`.

    The expressions of a xacro source are Python code, so a file is expanded only on request.
    """
    content, path = file_content(path) if content is None else content, Path(path).absolute()
    notes: list[str] = []
    folders = checked_folders(package_dirs)
    given = xacro_values(xacro_arguments)
    asked = path.suffix == ".xacro" if xacro is None else flag(xacro, "xacro")
    if given and not asked:
        raise BadArgument(f"{path} takes arguments with xacro=True only, got {', '.join(given)}")

    def expand(what: str) -> bytes:
        if not asked:
            raise BadModel(f"{path}: {what}; xacro=True (--xacro) expands it, which runs the code of its author")
        return expand_xacro(path, content, notes, arguments=given, packages=Packages(path, folders), what=what)

    document, expanded = read_document(path, content, notes, expand, always=bool(given or xacro))
    if given and not expanded:
        raise BadArgument(f"{path} is not a xacro source and takes no arguments, got {', '.join(given)}")
    try:
        tree = _UrdfReader(document, path, folders, notes).tree()
    except Refused as refusal:
        raise BadModel(f"{path}: {refusal}") from None
    return replace(tree, expanded=expanded)


class _UrdfReader:
    def __init__(self, document: ET.Element, path: Path, folders: tuple[Path, ...], notes: list[str]) -> None:
        self.document, self.path, self.folders, self.notes = document, path, folders, notes
        self.speedless: list[str] = []  # joints with a velocity limit of 0
        self.quaternions = has_quaternions(document)

    def tree(self) -> UrdfTree:
        if self.document.tag != "robot":
            other = "; it is MJCF, which RobotModel.from_mjcf reads" if self.document.tag == "mujoco" else ""
            raise Refused(f"the root element is <{abbreviated(self.document.tag)}>, a URDF has <robot>{other}")
        links, joint_elements = self._unique("link"), self._unique("joint")
        renamed = rename_links(links, joint_elements, self.notes)
        links = {renamed.get(name, name): element for name, element in links.items()}
        joints = {name: self._joint(name, element, renamed) for name, element in joint_elements.items()}
        root = self._base(self._root(list(links), joints.values()), links, joints)
        joints = resolve_chains(joints, self.notes)
        given = drive_order(joints, root)
        order = share_limits(given, self.notes)
        found = {name: self._inertial(element) for name, element in links.items()}
        inertials = {name: inertial for name, inertial in found.items() if inertial is not None}
        shapes = read_shapes(self.document, links)
        self._note_missing_meshes()
        self.notes += [*notes_on_words(self.document), *notes_on_elements(self.document)]
        self.notes += [*notes_on_numbers(given, inertials, self.speedless), *notes_on_shapes(shapes)]
        return UrdfTree(
            path=self.path,
            name=self.document.get("name", "robot"),
            root=root,
            links=tuple(links),
            inertials=inertials,
            joints=tuple(order),
            shared_names=renamed,
            notes=tuple(self.notes),
            package_dirs=self.folders,
            **shapes,
        )

    def _unique(self, tag: str) -> dict[str, ET.Element]:
        """Return the elements of one kind by name, without those inside transmissions and plugins."""
        found: dict[str, ET.Element] = {}
        for element in self.document.findall(tag):
            name = element.get("name", "")
            if not name:
                raise Refused(f"a <{tag}> without a name")
            if name in found:
                raise Refused(f"two {tag}s named {quoted(name)}")
            found[name] = element
        if tag == "link" and not found:
            raise Refused("no links")
        return found

    def _joint(self, name: str, element: ET.Element, renamed: dict[str, str]) -> UrdfJoint:
        kind = element.get("type", "")
        if kind not in (*_MOVING, "fixed", _FLOATING):
            raise Refused(
                f"joint {quoted(name)} has type {quoted(kind)}; supported: {', '.join(_MOVING)}, fixed, and floating "
                "if it is the only joint on the root link"
            )
        ends = []
        for tag in ("parent", "child"):
            end = element.find(tag)
            if end is None or not end.get("link"):
                raise Refused(f"joint {quoted(name)} names no {tag} link")
            ends.append(renamed.get(str(end.get("link")), str(end.get("link"))))
        joint = UrdfJoint(name, kind, ends[0], ends[1], self._origin(("joint", name), element.find("origin")))
        if kind in ("fixed", _FLOATING):
            return joint
        limit, mimic, dynamics = element.find("limit"), element.find("mimic"), element.find("dynamics")
        found: dict[str, Any] = {"axis": self._axis(name, element.find("axis"))}
        if limit is not None:
            found |= {attribute: self._bound(name, limit, attribute) for attribute in ("velocity", "effort")}
        if dynamics is not None:
            found |= {attribute: self._loss(name, dynamics, attribute) for attribute in ("damping", "friction")}
        if kind == "continuous":
            found["kind"] = "revolute"
            what = "one revolute coordinate without limits" if mimic is None else "taken as revolute"
            follows = "" if mimic is None else " and follows another"
            self.notes.append(f"joint {quoted(name)} is continuous{follows}: {what}")
        else:
            found["lower"], found["upper"] = self._range(name, limit)
        if mimic is not None:
            found["mimic"] = Mimic(
                str(mimic.get("joint", "")),
                self._number(("joint", name), mimic, "multiplier", 1.0),
                self._number(("joint", name), mimic, "offset", 0.0),
            )
        return replace(joint, **found)

    def _range(self, joint: str, limit: ET.Element | None) -> tuple[float, float]:
        """Return the smallest and largest value; if limits are missing or contradictory, the joint has none."""
        if limit is None or (limit.get("lower") is None and limit.get("upper") is None):
            what = "no limits" if limit is None else "a limit without lower and upper: taken as unlimited"
            self.notes.append(f"joint {quoted(joint)} has {what}")
            return -math.inf, math.inf
        lower, upper = (self._end(joint, limit, bound, sign) for bound, sign in (("lower", "-"), ("upper", "")))
        open_ends = [bound for bound, value in (("lower", lower), ("upper", upper)) if math.isinf(value)]
        if open_ends:
            self.notes.append(f"joint {quoted(joint)} has no {' and no '.join(open_ends)} limit")
            return lower, upper
        if lower > upper:
            self.notes.append(f"joint {quoted(joint)} has lower limit {lower:g} above upper limit {upper:g}: unlimited")
            return -math.inf, math.inf
        if math.isinf(upper - lower):
            raise Refused(
                f"joint {quoted(joint)} has a range from {lower:g} to {upper:g}, which is too large for floating point"
            )
        return lower, upper

    def _axis(self, joint: str, element: ET.Element | None) -> Vector:
        text = "1 0 0" if element is None else element.get("xyz", "1 0 0")
        numbers = finite_numbers(text)
        if len(numbers) != 3:
            raise Refused(f"joint {quoted(joint)} has axis {quoted(text)}, expected three numbers")
        x, y, z = numbers
        length = math.hypot(x, y, z)
        if not 1e-9 < length < 1e9:
            raise Refused(f"joint {quoted(joint)} has axis {quoted(text)}, which has no direction")
        if abs(length - 1.0) > 1e-12:
            self.notes.append(f"joint {quoted(joint)} has axis {quoted(text)} of length {length:.7g}: normalised")
        return x / length, y / length, z / length

    def _inertial(self, link: ET.Element) -> Inertial | None:
        element, owner = link.find("inertial"), ("link", link.get("name", ""))
        if element is None:
            return None
        mass = element.find("mass")
        if mass is None or mass.get("value") is None:
            self.notes.append(f"{_name(owner)} has an inertia and no mass: taken as massless")
            return None
        value = self._number(owner, mass, "value", 0.0)
        if value < 0.0:
            raise Refused(f"{_name(owner)} has mass {value:g}")
        tensor = element.find("inertia")
        if tensor is None:
            self.notes.append(f"{_name(owner)} has a mass and no inertia: taken as a point mass")
        xx, xy, xz, yy, yz, zz = (0.0 if tensor is None else self._number(owner, tensor, k, 0.0) for k in TENSOR_LABELS)
        return Inertial(value, self._origin(owner, element.find("origin")), (xx, xy, xz, yy, yz, zz))

    def _origin(self, owner: Owner, element: ET.Element | None) -> Origin:
        try:
            return read_origin(element, self.quaternions)
        except UnreadableShape as reason:
            raise Refused(f"{_name(owner)}: {reason}") from None

    def _number(self, owner: Owner, element: ET.Element, attribute: str, default: float) -> float:
        text = element.get(attribute)
        if text is None:
            return default
        numbers = finite_numbers(text)
        if len(numbers) != 1:
            raise Refused(f"{_name(owner)} has {attribute} {quoted(text)}, expected a number")
        return numbers[0]

    def _end(self, joint: str, limit: ET.Element, bound: str, sign: str) -> float:
        """Return the smallest or the largest value; infinite for "-inf" and "inf"."""
        if limit.get(bound, "").strip().lower().removeprefix("+") in (f"{sign}inf", f"{sign}infinity"):
            return float(f"{sign}inf")
        return self._number(("joint", joint), limit, bound, 0.0)

    def _bound(self, joint: str, limit: ET.Element, attribute: str) -> float:
        """Return a largest speed or effort, infinite for "inf", a negative number or a missing attribute.

        A speed of 0 is infinite too: a URDF must have the attribute, and 0 means that nobody filled it in. MoveIt and
        pink read it so, and a joint that cannot move would be a fixed one.
        """
        if limit.get(attribute, "inf").strip().lower() in ("inf", "+inf", "infinity"):
            return math.inf
        value = self._number(("joint", joint), limit, attribute, math.inf)
        if value == 0.0 and attribute == "velocity":
            self.speedless.append(joint)
            return math.inf
        if value < 0.0:
            self.notes.append(f"joint {quoted(joint)} has {attribute} {value:g}: taken as unlimited")
            return math.inf
        return value

    def _loss(self, joint: str, dynamics: ET.Element, attribute: str) -> float:
        """Return damping or friction; kinematics does not depend on them, so an unreadable value means zero."""
        text = dynamics.get(attribute, "0")
        numbers = finite_numbers(text)
        value = numbers[0] if len(numbers) == 1 else -1.0
        if not 0.0 <= value < math.inf:
            self.notes.append(f"joint {quoted(joint)} has {attribute} {quoted(text)}: taken as none")
            return 0.0
        return value

    def _root(self, links: list[str], joints: Iterable[UrdfJoint]) -> str:
        """Return the one link that no joint moves; refuse graphs that are not a tree."""
        known, carried = set(links), dict[str, str]()
        for joint in joints:
            for end in (joint.parent, joint.child):
                if end not in known:
                    raise Refused(f"joint {quoted(joint.name)} names a link {quoted(end)} that does not exist")
            if joint.child in carried:
                raise Refused(
                    f"link {quoted(joint.child)} is moved by two joints, {quoted(carried[joint.child])} "
                    f"and {quoted(joint.name)}"
                )
            carried[joint.child] = joint.name
        roots = [name for name in links if name not in carried]
        if len(roots) != 1:
            found = ", ".join(map(quoted, roots[:4])) or "none: the joints form a loop"
            raise Refused(f"a robot has one root link, found {found}")
        # With one root and one parent per link, links that cannot be reached from the root form a loop.
        children: dict[str, list[UrdfJoint]] = {}
        for joint in joints:
            children.setdefault(joint.parent, []).append(joint)
        reached = {roots[0], *(joint.child for joint in depth_first(children, roots[0]))}
        if len(reached) != len(links):
            raise Refused(f"link {quoted(next(n for n in links if n not in reached))} is part of a loop of joints")
        return roots[0]

    def _base(self, root: str, links: dict[str, ET.Element], joints: dict[str, UrdfJoint]) -> str:
        """Return the root; drop a root whose only joint is floating, and return the link below it."""
        floating = [joint for joint in joints.values() if joint.kind == _FLOATING]
        if not floating:
            return root
        joint = floating[0]
        if len(floating) > 1 or [other for other in joints.values() if other.parent == root] != [joint]:
            raise Refused(
                f"joint {quoted(joint.name)} is floating, which is read only if it is the only floating joint, and the "
                f"only joint on the root link {quoted(root)}"
            )
        del links[root], joints[joint.name]
        self.notes.append(
            f"joint {quoted(joint.name)} is floating: {quoted(joint.child)} is the base, and {quoted(root)} is left "
            "out; base='floating' gives it coordinates"
        )
        return joint.child

    def _note_missing_meshes(self) -> None:
        packages = Packages(self.path, self.folders)
        meshes = {mesh.get("filename", "") for mesh in self.document.iter("mesh")}
        missing = sorted(name for name in meshes if packages.file(name) is None)
        if missing:
            self.notes.append(f"{len(missing)} of {len(meshes)} mesh files are missing, first {quoted(missing[0])}")


def _name(owner: Owner) -> str:
    return f"{owner[0]} {quoted(owner[1])}"


# --- The format of a file, recognised by its content: file names are not reliable.

_FORMATS: dict[str, Literal["urdf", "mjcf"]] = {"robot": "urdf", "mujoco": "mjcf"}
# Root elements of files that are not read, and advice.
_OTHERS = {
    "mujocoinclude": "a part of an MJCF that another file includes; read that one",
    "sdf": "an SDF; convert it to URDF or MJCF first",
}


def file_format(path: Path | str, content: bytes | None = None) -> Literal["urdf", "mjcf"]:
    """Return the format of a robot's file: "urdf" for URDF and its xacro sources, "mjcf" for MuJoCo's format."""
    tag = root_tag(path, file_content(path) if content is None else content)
    if tag not in _FORMATS:
        other = f": {_OTHERS[tag]}" if tag in _OTHERS else ""
        raise BadModel(
            f"{path}: the root element is <{abbreviated(tag)}>, a URDF has <robot> and an MJCF <mujoco>{other}"
        )
    return _FORMATS[tag]


def read_robot(
    path: Path | str,
    *,
    package_dirs: Iterable[Path | str] = (),
    xacro: bool | None = None,
    xacro_arguments: Mapping[str, object] | None = None,
) -> tuple[UrdfTree, Semantics | None]:
    """Read a URDF, xacro or MJCF file once; it may be a pipe.

    Args:
        path: the file.
        package_dirs: folders to search for packages and meshes, before ROS_PACKAGE_PATH and the like.
        xacro: whether to expand the file as a xacro source, which runs the code of its author; None to expand only
            files named .xacro.
        xacro_arguments: values of the arguments of a xacro source, by name.

    Returns:
        The tree, and the semantics of an MJCF; None for a URDF, which has none.

    Raises:
        BadModel: the file cannot be read, has another format, or describes no tree of supported joints; or a xacro
            source cannot or must not be expanded.
        BadArgument: a folder that does not exist, or arguments for a file that is not expanded.
        MissingExtra: MuJoCo, which reads MJCF, is not installed.

    Examples:
        >>> tree, semantics = nk.urdf.read_robot(nk.load_nao().urdf_path)
        >>> tree.root, semantics
        ('base_link', None)
    """
    content = file_content(path)
    is_mjcf = file_format(path, content) == "mjcf"
    if is_mjcf and not xacro_arguments and not xacro:
        return read_mjcf(path, package_dirs=package_dirs, content=content)
    # An MJCF comes here only with xacro=True or with arguments; this call refuses both.
    tree = read_urdf(path, package_dirs=package_dirs, xacro=xacro, xacro_arguments=xacro_arguments, content=content)
    return tree, None
