"""The second readers of a robot's file: yourdfpy for a URDF, MuJoCo for an MJCF."""

from __future__ import annotations

import contextlib
import io
import logging
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._core.text import abbreviated
from nao_kin._core.warn import mujoco_warnings, need_extra
from nao_kin.errors import BadArgument, BadModel
from nao_kin.robot import RobotModel
from nao_kin.robot.urdf import Origin, file_format
from nao_kin.rotations import matrix_from_euler, quat_from_matrix

# --- Poses, limits and couplings by yourdfpy, which reads the robot's URDF with other code.

# trimesh keeps the transforms for yourdfpy, and ignores a new one within 1e-8 of the old one; none is near this one.
_STALE = np.full((4, 4), np.nan)

# Types of joints without a value.
_WITHOUT_VALUE = ("fixed", "floating")


@dataclass(frozen=True)
class ParsedJoint:
    """A moving joint read by another parser, without corrections; None for values that the file lacks."""

    continuous: bool
    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    effort: float | None = None
    follows: tuple[str, float, float] | None = None  # (driving joint, multiplier, offset) of its <mimic>


class YourdfpyOracle:
    """A robot read by yourdfpy: its kinds of limits, its moving joints, and poses of `frames`.

    `left_out` are frames with other poses in yourdfpy, which does not move a joint that mimics a mimic joint, and does
    not normalise the axis of a prismatic joint.
    """

    name = "yourdfpy"
    kinds = ("lower", "upper", "velocity", "effort")

    def __init__(self, robot: RobotModel) -> None:
        import yourdfpy

        self._robot = robot
        with _without_warnings():
            expanded = robot.tree.expanded
            source = io.BytesIO(expanded.encode()) if expanded else str(robot.urdf_path)
            if robot.tree.offsets:
                source = _with_offsets(source, robot.tree.offsets)
            self._oracle = yourdfpy.URDF.load(source, load_meshes=False, load_collision_meshes=False)
        joints = {joint.name: joint for joint in self._oracle.robot.joints}
        # By joints, not by links: a link that shares its name with a joint is renamed in the model.
        tree = robot.tree
        # The robot has no floating joint above its root.
        self._base = tree.root if tree.root in self._oracle.link_map else self._oracle.base_link
        link_of = {tree.root: self._base}
        link_of |= {joint.child: joints[joint.name].child for joint in tree.joints}
        link_of |= {joint.name: joints[joint.name].child for joint in tree.joints if joint.kind != "fixed"}
        # A name that the file gives to a link and to a joint means the link.
        link_of |= {name: name for name in tree.shared_names}
        self.joints: Mapping[str, ParsedJoint] = {
            name: _parsed_by_yourdfpy(joint) for name, joint in joints.items() if joint.type not in _WITHOUT_VALUE
        }
        self._actuated = list(self._oracle.actuated_joint_names)
        self._moving = [(joint.parent, joint.child) for joint in joints.values() if joint.type not in _WITHOUT_VALUE]
        self._walk, unplaced = self._order()
        known = {name: link for name, link in link_of.items() if name in robot.frame_names}
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
        """Return values of the joints that yourdfpy moves; those of mimic joints follow the couplings."""
        values = dict(zip(self._robot.joint_names, q.T, strict=True))
        values |= {name: mimic.value(values[mimic.joint]) for name, mimic in self._robot.mimics.items()}
        # A floating joint, which yourdfpy counts among the moving ones, has no value.
        still = np.zeros(len(q))
        columns = [values[name] if name in self.joints else still for name in self._actuated]
        return np.stack(columns, axis=1) if columns else np.zeros((len(q), 0))

    def _order(self) -> tuple[Sequence[tuple[str, str]], set[str]]:
        """Return (parent link, child link) of joints, parents first, and links behind joints read differently."""
        children: dict[str, list[str]] = {}
        unplaced = set()
        for joint in self._oracle.robot.joints:
            children.setdefault(joint.parent, []).append(joint.child)
            slides = joint.type == "prismatic" and abs(np.linalg.norm(joint.axis) - 1.0) > 1e-12
            if slides or (joint.mimic is not None and joint.mimic.joint not in self._actuated):
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


def _with_offsets(source: io.BytesIO | str, offsets: Mapping[str, Origin]) -> io.BytesIO:
    """Return the URDF with the calibrated origins of joints in place of the original ones."""
    document = ET.parse(source).getroot()
    for joint in document.findall("joint"):
        place = offsets.get(joint.get("name", ""))
        if place is not None:
            for origin in joint.findall("origin"):
                joint.remove(origin)
            xyz, rpy = (" ".join(map(repr, values)) for values in (place.xyz, place.rpy))
            ET.SubElement(joint, "origin", xyz=xyz, rpy=rpy)
    return io.BytesIO(ET.tostring(document))


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
                for part, most in zip(_parts(name), boxes, strict=True):
                    found[part] = _parsed_by_mujoco(-most, most)
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
