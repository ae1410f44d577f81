"""The other readers of a robot's file: yourdfpy and Pinocchio's parser for a URDF, MuJoCo for an MJCF."""

from __future__ import annotations

import contextlib
import io
import logging
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin

from nao_kin._core.arrays import Floats
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import mujoco_warnings, need_extra
from nao_kin.errors import BadArgument, BadModel
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import file_format, has_quaternions, read_document
from nao_kin.rotations import matrix_from_euler, quat_from_matrix

# --- Joints, and the text of a robot's URDF, as the other parsers read it.


@dataclass(frozen=True)
class ParsedJoint:
    """A moving joint read by another parser, without corrections; None for values that the file lacks."""

    continuous: bool
    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None
    follows: tuple[str, float, float] | None = None  # (driving joint, multiplier, offset) of its <mimic>


def driver_of(name: str, joints: Mapping[str, ParsedJoint]) -> tuple[str, float, float]:
    """Return the joint at the end of a chain of mimics, and the multiplier and offset that lead back from it."""
    multiplier, offset = 1.0, 0.0
    for _ in joints:
        follows = joints[name].follows if name in joints else None
        if follows is None:
            break
        name, offset, multiplier = follows[0], offset + multiplier * follows[2], multiplier * follows[1]
    return name, multiplier, offset


def _kinematics_of(robot: RobotModel) -> ET.Element:
    """Return the links, without their contents, and the joints of a robot's URDF, with calibrated origins.

    The parsers report other elements that they do not know on standard error, or refuse them.
    """
    content = robot.tree.expanded.encode() or robot.urdf_path.read_bytes()
    document, _ = read_document(robot.urdf_path, content, [])
    document.attrib.pop("xmlns", None)  # a default namespace hides every element from lxml
    document[:] = [element for element in document if element.tag in ("link", "joint")]
    for link in document.findall("link"):
        del link[:]
    in_file = {link: name for name, link in robot.tree.shared_names.items()}
    for row in (row for row in robot.tree.joints if row.child in robot.tree.added):
        ET.SubElement(document, "link", name=row.child)
        joint = ET.SubElement(document, "joint", name=row.name, type="fixed")
        ET.SubElement(joint, "parent", link=in_file.get(row.parent, row.parent))
        ET.SubElement(joint, "child", link=row.child)
    for joint in document.findall("joint"):
        place = robot.tree.offsets.get(joint.get("name", ""))
        if place is not None:
            for origin in joint.findall("origin"):
                joint.remove(origin)
            xyz, rpy = (" ".join(map(repr, values)) for values in (place.xyz, place.rpy))
            ET.SubElement(joint, "origin", xyz=xyz, rpy=rpy)
    return document


def _links_of_frames(robot: RobotModel, links: Mapping[str, str]) -> dict[str, str]:
    """Return frame of a robot → link of the file at its pose; `links` is joint of the file → the link it moves.

    By joints, not by links: a link that shares its name with a joint is renamed in the model.
    """
    tree = robot.tree
    found = {joint.child: links[joint.name] for joint in tree.joints}
    found |= {joint.name: links[joint.name] for joint in tree.joints if joint.kind != "fixed"}
    # A name that the file gives to a link and to a joint means the link.
    found |= {name: name for name in tree.shared_names}
    return {name: link for name, link in found.items() if name in robot.frame_names}


def _joint_values(robot: RobotModel, q: Floats) -> dict[str, Floats]:
    """Return values (n,) of all moving joints by name; those of mimic joints follow the couplings."""
    values = dict(zip(robot.joint_names, q.T, strict=True))
    return values | {name: mimic.value(values[mimic.joint]) for name, mimic in robot.mimics.items()}


# --- Poses, limits and couplings by yourdfpy, which reads the robot's URDF with other code.

# trimesh keeps the transforms for yourdfpy, and ignores a new one within 1e-8 of the old one; none is near this one.
_STALE = np.full((4, 4), np.nan)

# Types of joints without a value.
_WITHOUT_VALUE = ("fixed", "floating")


class YourdfpyOracle:
    """A robot read by yourdfpy: its kinds of limits, its moving joints, and poses of `frames`.

    `left_out` are frames with other poses in yourdfpy, which does not move a joint that mimics a mimic joint or a fixed
    one, does not normalise the axis of a prismatic joint, and does not know `quat_xyzw`.
    """

    name = "yourdfpy"
    kinds = ("lower", "upper", "velocity", "effort")

    def __init__(self, robot: RobotModel) -> None:
        import yourdfpy

        self._robot, document = robot, _kinematics_of(robot)
        with _without_warnings():
            source = io.BytesIO(ET.tostring(document))
            self._oracle = yourdfpy.URDF.load(source, load_meshes=False, load_collision_meshes=False)
        joints = {joint.name: joint for joint in self._oracle.robot.joints}
        # The robot has no floating joint above its root.
        root = robot.tree.root
        self._base = root if root in self._oracle.link_map else self._oracle.base_link
        links = _links_of_frames(robot, {name: joint.child for name, joint in joints.items()})
        known = {root: self._base, **links}
        self._turned = {
            joint.get("name", "")
            for joint in document.findall("joint")
            if has_quaternions(document) and joint.find("origin[@quat_xyzw]") is not None
        }
        self.joints: Mapping[str, ParsedJoint] = {
            name: _parsed_by_yourdfpy(joint) for name, joint in joints.items() if joint.type not in _WITHOUT_VALUE
        }
        self._actuated = list(self._oracle.actuated_joint_names)
        self._moving = [(joint.parent, joint.child) for joint in joints.values() if joint.type not in _WITHOUT_VALUE]
        self._walk, unplaced = self._order()
        self.frames = tuple(name for name, link in known.items() if link not in unplaced)
        self.left_out = tuple(name for name, link in known.items() if link in unplaced)
        self._place = {self._base: 0} | {child: i for i, (_, child) in enumerate(self._walk, 1)}
        self._selection = [self._place[known[name]] for name in self.frames]

    def poses(self, q: Floats) -> Floats:
        """Return T_root_frame, shape (n, frames, 4, 4), for configurations of shape (n, nq)."""
        values = self._values(q)
        T = np.empty((len(q), len(self._place), 4, 4))
        T[:, 0] = np.eye(4)
        edges = self._oracle.scene.graph.transforms.edge_data
        for row, joint_values in enumerate(values):
            for edge in self._moving:
                edges[edge]["matrix"] = _STALE
            with _without_warnings():
                self._oracle.update_cfg(joint_values)
            for edge in self._walk:
                T[row, self._place[edge[1]]] = edges[edge]["matrix"]
        for parent, child in self._walk:
            T[:, self._place[child]] = T[:, self._place[parent]] @ T[:, self._place[child]]
        return T[:, self._selection]

    def _values(self, q: Floats) -> Floats:
        """Return values of the joints that yourdfpy moves."""
        values = _joint_values(self._robot, q)
        # A floating joint, which yourdfpy counts among the moving ones, has no value.
        zero = np.zeros(len(q))
        columns = [values[name] if name in self.joints else zero for name in self._actuated]
        return np.stack(columns, axis=1) if columns else np.zeros((len(q), 0))

    def _order(self) -> tuple[Sequence[tuple[str, str]], set[str]]:
        """Return (parent link, child link) of joints, parents first, and links behind joints read differently."""
        children: dict[str, list[str]] = {}
        unplaced = set()
        for joint in self._oracle.robot.joints:
            children.setdefault(joint.parent, []).append(joint.child)
            slides = joint.type == "prismatic" and abs(np.linalg.norm(joint.axis) - 1.0) > 1e-12
            follows = joint.mimic is not None and joint.mimic.joint not in self._actuated
            if slides or follows or joint.name in self._turned:
                unplaced.add(joint.child)
        walk: list[tuple[str, str]] = []
        waiting = [self._base]
        while waiting:
            parent = waiting.pop()
            for child in children.get(parent, []):
                walk.append((parent, child))
                waiting.append(child)
                if parent in unplaced:
                    unplaced.add(child)
        return walk, unplaced


def _parsed_by_yourdfpy(joint: Any) -> ParsedJoint:
    limits, mimic = {kind: joint.limit and getattr(joint.limit, kind) for kind in YourdfpyOracle.kinds}, joint.mimic
    follows = mimic and (mimic.joint, mimic.multiplier, mimic.offset)
    return ParsedJoint(continuous=joint.type == "continuous", **limits, follows=follows)


@contextlib.contextmanager
def _without_warnings() -> Iterator[None]:
    """Keep yourdfpy from warning, at every configuration, about the couplings counted in `left_out`."""
    logger = logging.getLogger("yourdfpy.urdf")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


# --- Poses and limits by Pinocchio's own parser, which reads the robot's URDF again.


class PinocchioOracle:
    """A robot's URDF read by Pinocchio's parser: its moving `joints`, and poses of all `frames`.

    Couplings are not Pinocchio's: every joint gets its value, so that a file is read in any order of its joints.
    """

    name = "pin.buildModelFromUrdf"

    def __init__(self, robot: RobotModel, model: pin.Model, joints: Mapping[str, ParsedJoint]) -> None:
        self._robot, self._model, self._joints = robot, model, joints
        bodies = {f.name: index for index, f in enumerate(model.frames) if f.type == pin.FrameType.BODY}
        given = {new: old for old, new in robot.tree.shared_names.items()}
        links = {joint.name: given.get(joint.child, joint.child) for joint in robot.tree.joints}
        known = {robot.tree.root: given.get(robot.tree.root, robot.tree.root), **_links_of_frames(robot, links)}
        self.frames = tuple(known)
        self._ids = [bodies[link] for link in known.values()]
        self.joints = {name: self._parsed(name, joint) for name, joint in joints.items()}

    def poses(self, q: Floats) -> Floats:
        """Return T_root_frame, shape (n, frames, 4, 4), for configurations of shape (n, nq)."""
        model, data, values = self._model, self._model.createData(), _joint_values(self._robot, q)
        T = np.empty((len(q), len(self.frames), 4, 4))
        for name in self._joints.keys() - values.keys():  # those that follow a fixed joint
            driver, multiplier, offset = driver_of(name, self._joints)
            values[name] = multiplier * values.get(driver, np.zeros(len(q))) + offset
        places = [(model.joints[model.getJointId(name)], values[name]) for name in self._joints]
        for row in range(len(q)):
            configuration = pin.neutral(model)
            for joint, value in places:
                v = value[row]
                configuration[joint.idx_q : joint.idx_q + joint.nq] = [v] if joint.nq == 1 else [np.cos(v), np.sin(v)]
            pin.framesForwardKinematics(model, data, configuration)
            T_root_world = data.oMf[self._ids[0]].inverse()
            for column, index in enumerate(self._ids):
                T[row, column] = (T_root_world * data.oMf[index]).homogeneous
        return T

    def _parsed(self, name: str, joint: ParsedJoint) -> ParsedJoint:
        """Return the joint with the limits that Pinocchio reads."""
        model, index = self._model, self._model.joints[self._model.getJointId(name)]
        speeds = float(model.upperVelocityLimit[index.idx_v]), float(model.upperEffortLimit[index.idx_v])
        found = replace(joint, velocity=speeds[0], effort=speeds[1])
        # A limit without lower and upper is [0, 0] to this parser, which cannot confirm a missing range.
        if joint.continuous or (joint.lower is None and joint.upper is None):
            return found
        lower, upper = float(model.lowerPositionLimit[index.idx_q]), float(model.upperPositionLimit[index.idx_q])
        return replace(found, lower=lower, upper=upper)


def read_by_pinocchio(robot: RobotModel, joints: Mapping[str, ParsedJoint]) -> tuple[PinocchioOracle | None, str]:
    """Return the URDF as Pinocchio's parser reads it; or None and a note with the reason, if it does not."""
    not_compared = "not compared with Pinocchio's own parser, which"
    for name, joint in joints.items():
        # The parser would report missing values on standard error.
        if not joint.continuous and (joint.velocity is None or joint.effort is None):
            return None, f"{not_compared} needs velocity and effort of {quoted(name)}"
    try:
        model = pin.buildModelFromXML(ET.tostring(_kinematics_of(robot), encoding="unicode"))
    except (RuntimeError, ValueError) as error:
        return None, f"{not_compared} refuses the file: {abbreviated(error)}"
    missing = [name for name in joints if not model.existJointName(name)]
    if missing:
        return None, f"{not_compared} has no joint {quoted(missing[0])}"
    return PinocchioOracle(robot, model, joints), ""


# --- Poses, limits and couplings by MuJoCo, which reads the robot's MJCF again, and the choice of the oracle.

_BALL, _FREE = 1, 0  # as `mujoco.mjtJoint` numbers them
_JOINT_EQUALITY = 2  # as `mujoco.mjtEq` numbers them


class MujocoOracle:
    """A robot's MJCF read by MuJoCo, by the names of bodies, sites and joints; attributes as `YourdfpyOracle`."""

    name = "MuJoCo"
    kinds = ("lower", "upper")
    left_out: tuple[str, ...] = ()

    def __init__(self, robot: RobotModel) -> None:
        need_extra("the cross-check of an MJCF", "mujoco")
        if robot.tree.offsets:
            raise BadArgument("MuJoCo reads the file without the offsets; cross-check the robot without them")
        import mujoco

        self._mujoco, self._robot = mujoco, robot
        try:
            name = f"{robot.urdf_path}.xml"  # the only suffix with which every version reads MJCF
            with mujoco_warnings(mujoco):
                spec = mujoco.MjSpec.from_file(name, include={name: robot.urdf_path.read_bytes()})
                self._model: Any = spec.compile()
        except (ValueError, mujoco.FatalError) as error:
            raise BadModel(f"{robot.urdf_path}: MuJoCo refuses it: {abbreviated(error)}") from None
        model, self._data = self._model, mujoco.MjData(self._model)
        self._bodies = {model.body(body).name or f"body_{body}": body for body in range(model.nbody)}
        self._joint_names = [model.joint(joint).name for joint in range(model.njnt)]
        # Follower, driver, and the coefficients of the polynomial from the driver's value to the follower's.
        self._equalities = [
            (int(model.eq_obj1id[row]), int(model.eq_obj2id[row]), model.eq_data[row, :5].tolist())
            for row in range(model.neq)
            if model.eq_type[row] == _JOINT_EQUALITY and model.eq_active0[row]
        ]
        self.joints: Mapping[str, ParsedJoint] = self._parsed_joints()
        self._places = self._placed()
        self.frames = tuple(self._places)

    def poses(self, q: Floats) -> Floats:
        """Return T_root_frame, shape (n, frames, 4, 4), for configurations of shape (n, nq)."""
        T = np.tile(np.eye(4), (len(q), 1 + len(self.frames), 1, 1))
        root = "body", self._body(self._robot.tree.root)
        for row, configuration in zip(T, q, strict=True):
            self._data.qpos[:] = self._qpos(configuration)
            self._mujoco.mj_kinematics(self._model, self._data)
            for pose, (kind, index) in zip(row, (root, *self._places.values()), strict=True):
                where = getattr(self._data, kind)(index)
                pose[:3, :3], pose[:3, 3] = where.xmat.reshape(3, 3), where.xpos
        return np.asarray(np.linalg.solve(T[:, :1], T[:, 1:]), dtype=np.float64)

    def _qpos(self, q: Floats) -> Floats:
        """Return MuJoCo's configuration; joints that the robot does not move stay at their reference."""
        values = dict(zip(self._robot.joint_names, q.tolist(), strict=True))
        values |= {name: float(mimic.value(values[mimic.joint])) for name, mimic in self._robot.mimics.items()}
        model, qpos = self._model, np.array(self._model.qpos0)
        self._set_coupled(qpos, {joint for joint, name in enumerate(self._joint_names) if name in values})
        for joint, name in enumerate(self._joint_names):
            first = model.jnt_qposadr[joint]
            if model.jnt_type[joint] != _BALL:
                qpos[first] = values.get(name, qpos[first])
            elif self._is_known(joint):
                R = matrix_from_euler([values.get(part, 0.0) for part in _parts(name)], "xyz", axes="moving")
                qpos[first : first + 4] = quat_from_matrix(R)
        return qpos

    def _set_coupled(self, qpos: Floats, moving: set[int]) -> None:
        """Set the joints that equalities fix at a value, and those coupled to them; `moving` ones are set already."""
        start, known, address = np.array(qpos), set[int](), self._model.jnt_qposadr
        for _ in self._equalities:
            for follower, driver, (constant, slope, *higher) in self._equalities:
                if any(higher):
                    continue
                y, x = address[follower], address[driver]
                alone = driver < 0 or not slope
                if follower not in known | moving and (alone or driver in known):
                    qpos[y] = start[y] + constant + (0.0 if alone else slope * (qpos[x] - start[x]))
                    known.add(follower)
                elif not alone and follower in known and driver not in known | moving:
                    qpos[x] = start[x] + (qpos[y] - start[y] - constant) / slope
                    known.add(driver)

    def _placed(self) -> dict[str, tuple[str, int]]:
        """Return frame → ("body" or "site", index), without frames behind joints that have no name."""
        model, found = self._model, dict[str, tuple[str, int]]()
        nameless = {int(model.jnt_bodyid[joint]) for joint in range(model.njnt) if not self._is_known(joint)}
        known = [0]
        for body in range(1, model.nbody):
            if body not in nameless and model.body_parentid[body] in known:
                known.append(body)
        for link in self._robot.link_names:
            body = self._body(link)
            if body in known and (body or link == self._robot.tree.root):
                found[link] = "body", body
        for site in range(model.nsite):
            name = model.site(site).name
            link = f"{name}_site" if f"{name}_site" in self._robot.link_names else name
            if link in self._robot.link_names and link not in found and model.site_bodyid[site] in known:
                found[link] = "site", site
        return found

    def _is_known(self, joint: int) -> bool:
        """Return whether the robot has the joint, or the three of a ball, under the same name."""
        name, kind = self._joint_names[joint], self._model.jnt_type[joint]
        return kind == _FREE or (bool(name) and (kind != _BALL or not set(_parts(name)) & set(self._joint_names)))

    def _body(self, link: str) -> int:
        """Return the body of a link; 0, the world, if there is none."""
        given = {new: old for old, new in self._robot.tree.shared_names.items()}
        return self._bodies.get(given.get(link, link), 0)

    def _parsed_joints(self) -> dict[str, ParsedJoint]:
        model, names = self._model, self._joint_names
        moving = {joint.name: joint for joint in self._robot.tree.moving_joints}
        follows = {}
        for follower, driver, (constant, slope, *higher) in self._equalities:
            if driver >= 0 and slope and not any(higher):
                y, x = (float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (follower, driver))
                follows[names[follower]] = names[driver], slope, y + constant - slope * x
        found = {}
        for joint, name in enumerate(names):
            limited = bool(model.jnt_limited[joint])
            lower, upper = (float(value) if limited else math.nan for value in model.jnt_range[joint])
            if name in moving:
                found[name] = _parsed_by_mujoco(lower, upper, follows.get(name))
            elif model.jnt_type[joint] == _BALL and self._is_known(joint):
                # The box that contains every turn of at most the largest angle.
                narrow = upper <= math.pi / 2
                boxes = (upper if narrow else math.nan, min(upper, math.pi / 2), upper if narrow else math.nan)
                for part, limit in zip(_parts(name), boxes, strict=True):
                    found[part] = _parsed_by_mujoco(-limit, limit)
        # Joints without names in the file are taken from the robot, and so compared with themselves.
        own = {name: _parsed_by_mujoco(joint.lower, joint.upper) for name, joint in moving.items()}
        return own | found


def _parts(ball: str) -> tuple[str, str, str]:
    """Return the names of the three joints that a ball joint becomes."""
    return f"{ball}_x", f"{ball}_y", f"{ball}_z"


def _parsed_by_mujoco(lower: float, upper: float, follows: tuple[str, float, float] | None = None) -> ParsedJoint:
    """Return a joint with these limits; without any where they are not finite."""
    if math.isfinite(lower) and math.isfinite(upper):
        return ParsedJoint(False, lower, upper, follows=follows)
    return ParsedJoint(True, follows=follows)


Oracle = YourdfpyOracle | MujocoOracle


def oracle_of(robot: RobotModel) -> Oracle:
    """Return the second reader of a robot's file: yourdfpy of a URDF, MuJoCo of an MJCF."""
    if not robot.tree.expanded and file_format(robot.urdf_path) == "mjcf":
        return MujocoOracle(robot)
    return YourdfpyOracle(robot)
