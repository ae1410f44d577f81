"""The semantics of a robot beside its tree: read from a TOML or SRDF file, checked, and the frames of its cameras.

SRDF is the file that MoveIt uses beside a URDF. Its groups, end effectors and group states are read.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import fields, replace
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._core.arrays import Floats, join_poses
from nao_kin._core.text import abbreviated, nearest_names, quoted
from nao_kin.errors import BadModel, NaoKinError
from nao_kin.robot.configurations import Coordinates
from nao_kin.robot.semantics import Posture, Semantics, read_semantics
from nao_kin.robot.urdf.document import file_content, finite_numbers, read_document
from nao_kin.robot.urdf.tree import UrdfJoint, UrdfTree

# Axes of an optical frame (z along the optical axis, x to the right, y down) in the body frame (x along the optical
# axis, y to the left, z up). Source: REP 103, which also gives the ending of the name.
_T_BODY_OPTICAL = join_poses(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), np.zeros(3))
_OPTICAL_ENDINGS = ("_optical", "_optical_frame")
# Largest difference from these axes in a file with rounded angles.
_ROUNDED = 1e-3


def find_semantics(
    tree: UrdfTree, given: Semantics | Path | str | None, notes: list[str], implied: Semantics | None = None
) -> Semantics:
    """Return the semantics given, or those in a file near the robot's file; a note says in which.

    This is the .toml or .srdf file of the same name beside it or, as in ROS packages, in the folder srdf beside its
    folder. Without one, it is the only file in that folder that fits the robot (`_fitting`). `implied` are those in the
    robot's own file (MJCF), which fill the parts that the other file leaves empty.
    """
    kind, implied = ("URDF", Semantics()) if implied is None else ("MJCF", implied)
    if isinstance(given, Semantics):
        return given
    if given is not None:
        return _filled(_read(Path(given), tree, notes), implied)
    own = tree.path.with_name(tree.path.name.removesuffix(".xacro"))
    folder = own.parent.parent / "srdf"
    named = [*(own.with_suffix(ending) for ending in (".toml", ".srdf")), folder / f"{own.stem}.srdf"]
    for path in [path for path in named if path.is_file()] or _fitting(folder, own.stem, tree, notes):
        where = f"beside the {kind}" if path.parent == own.parent else f"in the folder srdf near the {kind}"
        try:
            semantics = checked_semantics(_filled(_read(path, tree, notes), implied), tree)
        except NaoKinError as error:
            # The caller did not name this file, so an error in it does not keep the robot from loading.
            notes.append(f"{path.name} {where} is not used: {error}")
        else:
            notes.append(f"chains, effectors and postures from {path.name} {where}")
            return semantics
    return implied


NO_SEMANTICS = "no chains and postures"
# Pinocchio's name for the joint of a free base, which SRDF files use without a `<virtual_joint>`.
_FREE_BASE = "root_joint"
# Element of an SRDF → attributes that name joints and links of the robot.
_NAMING = {
    "joint": ("name",),
    "link": ("name",),
    "chain": ("base_link", "tip_link"),
    "end_effector": ("parent_link",),
    "disable_collisions": ("link1", "link2"),
}


def _fitting(folder: Path, stem: str, tree: UrdfTree, notes: list[str]) -> list[Path]:
    """Return the SRDF in a folder that is for this robot: with its name, and no joint or link that it lacks.

    A package has files for several variants. If several fit, it is the one whose own name begins that of the robot's
    file, as ur5.srdf for ur5_robot.urdf; none if that does not decide. A note says that none fits.
    """
    known, files = (
        {*(joint.name for joint in tree.joints), *tree.links, *tree.shared_names},
        sorted(folder.glob("*.srdf")),
    )
    fitting = []
    for path in files:
        try:
            document, _ = read_document(path, file_content(path), [])
        except BadModel:
            continue
        attributes = [(element, name) for element in document.iter() for name in _NAMING.get(element.tag, ())]
        named = {element.get(name, "") for element, name in attributes}
        named -= {_FREE_BASE, *(element.get("name", "") for element in document.findall("virtual_joint"))}
        if named and named <= known and document.get("name", "").casefold() == tree.name.casefold():
            fitting.append(path)
    if len(fitting) > 1:
        fitting = [path for path in fitting if stem.startswith(path.stem)]
    if files and len(fitting) != 1:
        names = abbreviated(", ".join(path.name for path in files), 100)
        notes.append(f"{NO_SEMANTICS}: no file in the folder srdf is certainly for this robot: {names}")
        return []
    return fitting


def _filled(semantics: Semantics, implied: Semantics) -> Semantics:
    """Return the semantics, with their empty parts taken from `implied`."""
    empty = Semantics()
    blank = {field.name for field in fields(Semantics) if getattr(semantics, field.name) == getattr(empty, field.name)}
    filled = replace(semantics, **{name: getattr(implied, name) for name in blank})
    return replace(filled, start="") if "start" in blank and filled.start not in filled.postures else filled


def _read(path: Path, tree: UrdfTree, notes: list[str]) -> Semantics:
    if path.suffix.lower() != ".srdf":
        return read_semantics(path)
    semantics, postures = read_srdf(path, tree, notes), dict[str, Posture]()
    coordinates = _coordinates(tree)
    for name, posture in semantics.postures.items():
        try:
            _check_posture(posture, coordinates)
            postures[name] = posture
        except NaoKinError as error:
            notes.append(f"group state {quoted(name)} of {path.name} is left out: {error}")
    return replace(semantics, postures=postures)


def _coordinates(tree: UrdfTree) -> Coordinates:
    own = tuple([joint.name for joint in tree.moving_joints if joint.mimic is None])
    return Coordinates(own, tree.mimics)


def _check_posture(posture: Posture, coordinates: Coordinates) -> None:
    """Raise an error for a posture that contradicts a mimic."""
    if coordinates.plain_values(dict(posture.angles)) is None:
        coordinates.values(posture.angles)


def checked_semantics(semantics: Semantics, tree: UrdfTree) -> Semantics:
    """Return the semantics; `BadModel` for missing joints, frames or postures, or conflicts with shared motors."""
    moving, mimics = [joint.name for joint in tree.moving_joints], tree.mimics
    _check(semantics.joints(), moving, "joint", tree)
    _check(semantics.frames(), {*moving, *tree.links, *tree.shared_names}, "frame", tree)
    if semantics.start and semantics.start not in semantics.postures:
        raise BadModel(
            f"semantics of {tree.name}: start names the posture {quoted(semantics.start)}, which does not exist"
        )
    coordinates = _coordinates(tree)
    for name, posture in semantics.postures.items():
        try:
            _check_posture(posture, coordinates)
        except NaoKinError as error:
            raise BadModel(f"semantics of {tree.name}: posture {quoted(name)}: {error}") from None
    for table in semantics.coupled_limits:
        for name in (table.joint, table.of):
            if name in mimics:
                raise BadModel(
                    f"semantics of {tree.name}: a coupled limit names {quoted(name)}, which follows another joint"
                )
    return semantics


def _check(named: Mapping[str, tuple[str, str]], valid: Collection[str], kind: str, tree: UrdfTree) -> None:
    known = set(valid)
    for name, (part, its_name) in named.items():
        if name not in known:
            where = f"{part} {quoted(its_name)}" if its_name else part
            near = ", ".join(nearest_names(name, valid))
            advice = f" (nearest: {near})" if near else ""
            fixed = "is fixed" if kind == "joint" else "is a fixed joint"
            why = fixed if name in tree.fixed_joints else "does not exist"
            raise BadModel(f"semantics of {tree.name}: {where} names the {kind} {quoted(name)}, which {why}{advice}")


# --- SRDF.


def read_srdf(path: Path | str, tree: UrdfTree, notes: list[str]) -> Semantics:
    """Return the chains, end effectors, postures and disabled collisions of an SRDF.

    A group is a chain if its moving joints follow one another on one branch. States of one name form one posture. One
    SRDF often serves several variants of a robot: parts that this robot lacks are left out with a note.
    """
    document, _ = read_document(path, file_content(path), notes)
    if document.tag != "robot":
        raise BadModel(f"{path}: the root element is <{abbreviated(document.tag)}>, an SRDF has <robot>")
    reader = _Groups(document, tree)
    ends = [reader.link(element.get("parent_link", "")) for element in document.findall("end_effector")]
    semantics = Semantics(
        chains=reader.chains(),
        end_effectors=tuple(dict.fromkeys(end for end in ends if end in tree.links)),
        postures=_postures(document, tree, reader.missing, Path(path).name, notes),
        disabled_collisions=tuple(_disabled(document, reader, tree.links)),
    )
    missing = dict.fromkeys([*reader.missing, *(end for end in ends if end not in tree.links)])
    if missing:
        names = abbreviated(", ".join(missing), 100)
        notes.append(f"{Path(path).name} names {len(missing)} joints and links that the robot does not have: {names}")
    return semantics


class _Groups:
    """The groups of joints of an SRDF; `missing` are joints and links that the robot does not have."""

    def __init__(self, document: ET.Element, tree: UrdfTree) -> None:
        self.missing: list[str] = []
        self._elements: Mapping[str, ET.Element] = {
            element.get("name", ""): element for element in document.findall("group")
        }
        self._joints = {joint.name: joint for joint in tree.joints}
        self._above = {joint.child: joint for joint in tree.joints}
        self._tree = tree
        self._links = set(tree.links)
        self._renamed = tree.shared_names
        self._order = {joint.name: index for index, joint in enumerate(tree.joints)}

    def chains(self) -> dict[str, tuple[str, ...]]:
        """Return group → its moving joints from the root outwards, if they follow one another on one branch."""
        found = {}
        for name, element in self._elements.items():
            members = {joint.name for joint in self._members(element, (name,)) if joint.kind != "fixed"}
            ordered = sorted(members, key=self._order.__getitem__)
            if ordered and members <= {joint.name for joint in self._tree.joints_to(self._joints[ordered[-1]].child)}:
                found[name] = tuple(ordered)
        return found

    def link(self, name: str) -> str:
        """Return a link's name in the tree, which differs from that in the files if a joint has the same name."""
        return self._renamed.get(name, name)

    def _members(self, group: ET.Element, inside: tuple[str, ...]) -> list[UrdfJoint]:
        members: list[UrdfJoint] = []
        for element in group:
            name = element.get("name", "")
            if element.tag == "joint":
                members += self._known(name, self._joints)
            elif element.tag == "link":
                members += self._known(self.link(name), self._above)
            elif element.tag == "chain":
                members += self._path(self.link(element.get("tip_link", "")), self.link(element.get("base_link", "")))
            elif element.tag == "group" and name in self._elements and name not in inside:
                members += self._members(self._elements[name], (*inside, name))
        return members

    def _known(self, name: str, joints: Mapping[str, UrdfJoint]) -> list[UrdfJoint]:
        if name in joints:
            return [joints[name]]
        if name not in self._links:  # the root link is known and has no joint
            self.missing.append(name)
        return []

    def _path(self, tip: str, base: str) -> list[UrdfJoint]:
        """Return the joints from the base link to the tip, or from the root if the base does not carry the tip."""
        self.missing += [name for name in (tip, base) if name and name not in self._links]
        return self._tree.joints_to(tip, base)


def _disabled(document: ET.Element, reader: _Groups, links: Collection[str]) -> Iterator[tuple[str, str, str]]:
    for element in document.findall("disable_collisions"):
        pair = [reader.link(element.get(name, "")) for name in ("link1", "link2")]
        unknown = [link for link in pair if link not in links]
        reader.missing += unknown
        if not unknown:
            yield pair[0], pair[1], element.get("reason", "")


def _postures(
    document: ET.Element, tree: UrdfTree, missing: list[str], file: str, notes: list[str]
) -> dict[str, Posture]:
    """Return the group states; one with a value that is no number is left out, as are values of fixed joints."""
    moving = {joint.name: joint for joint in tree.moving_joints}
    angles: dict[str, dict[str, float]] = {}
    wrong, fixed, motionless = dict[str, str](), dict[str, None](), tree.fixed_joints
    for state in document.findall("group_state"):
        values = angles.setdefault(state.get("name", ""), {})
        for element in state.findall("joint"):
            name, text = element.get("name", ""), element.get("value", "")
            value = _value(text)
            if name in moving and value is not None:
                values[name] = value
            elif name in moving:
                wrong[state.get("name", "")] = f"{quoted(name)} is {quoted(text)}, expected a number"
            elif name in motionless:
                fixed |= {name: None} if value else {}
            elif len(text.split()) == 1:
                missing.append(name)
    notes += [f"group state {quoted(name)} of {file} is left out: {reason}" for name, reason in wrong.items()]
    if fixed:
        notes.append(f"{file} gives values to {len(fixed)} fixed joints: {abbreviated(', '.join(fixed), 100)}")
    return {name: Posture(values) for name, values in angles.items() if values and name not in wrong}


def _value(text: str) -> float | None:
    """Return a joint's value; two numbers are cosine and sine of an angle, as Pinocchio writes unlimited joints."""
    numbers = finite_numbers(text)
    if len(numbers) == 2:
        return math.atan2(numbers[1], numbers[0])
    return numbers[0] if len(numbers) == 1 else None


# --- The frames of one camera: its body frame, and the optical frame in which images are processed.


def camera_of(tree: UrdfTree, cameras: Iterable[str], frame: str) -> tuple[str, Floats] | None:
    """Return the camera that has this frame beside its body frame, and T_body_frame; None for other frames.

    It is the camera's optical frame, or a second name of its body frame, as CameraTop_frame in ROS: a frame fixed to
    the body frame, without translation.
    """
    link = tree.shared_names.get(frame, frame)
    row = next((joint for joint in tree.joints if joint.child == link and joint.kind == "fixed"), None)
    if row is None:
        return None
    for camera in cameras:
        if tree.shared_names.get(camera, camera) == row.parent:
            for T in (np.eye(4), _T_BODY_OPTICAL):
                if np.abs(row.origin.matrix - T).max() < _ROUNDED:
                    return camera, T
    return None


def pose_of_body(tree: UrdfTree, cameras: Collection[str], frame: str) -> Floats | None:
    """Return the pose of a camera's body frame in its optical frame; None if `frame` is not an optical frame.

    An optical frame is that of one of the cameras, or has a name that ends as in REP 103.
    """
    if frame in cameras:
        return None
    found = camera_of(tree, cameras, frame)
    optical = frame.endswith(_OPTICAL_ENDINGS) if found is None else found[1] is _T_BODY_OPTICAL
    return _T_BODY_OPTICAL.T if optical else None
