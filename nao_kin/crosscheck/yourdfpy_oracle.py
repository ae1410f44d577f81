"""Poses, limits and couplings by yourdfpy, which reads the robot's URDF with other code."""

from __future__ import annotations

import contextlib
import io
import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.robot import RobotModel
from nao_kin.urdf import Origin

# trimesh, which keeps the transforms for yourdfpy, drops a new one within 1e-8 of the old one; nothing is near this.
_STALE = np.full((4, 4), np.nan)

# Types of joints without a value of their own.
_STILL = ("fixed", "floating")


@dataclass(frozen=True)
class ParsedJoint:
    """A moving joint as another parser reads it, nothing mended.

    Attributes:
        continuous: whether it turns without limits.
        lower, upper, velocity, effort: the numbers of its <limit>; None where the file gives none.
        follows: (driving joint, multiplier, offset) of its <mimic>; None for a joint of its own.
    """

    continuous: bool
    lower: float | None
    upper: float | None
    velocity: float | None
    effort: float | None
    follows: tuple[str, float, float] | None = None


class YourdfpyOracle:
    """A robot as yourdfpy reads it.

    Attributes:
        name: what the report calls it.
        kinds: the limits that it gives.
        frames: the frames of the robot that yourdfpy can place, by the names the robot has for them.
        left_out: those it places otherwise: it lets a joint that mimics a joint that mimics a third one follow nothing,
            and does not bring the axis of a prismatic joint to unit length.
        joints: its moving joints.
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
        # By joints, not by links: a link that shares its name with a joint is called something else in the model.
        tree = robot.tree
        # A floating joint above the root is none of the robot's.
        self._base = tree.root if tree.root in self._oracle.link_map else self._oracle.base_link
        link_of = {tree.root: self._base}
        link_of |= {joint.child: joints[joint.name].child for joint in tree.joints}
        link_of |= {joint.name: joints[joint.name].child for joint in tree.joints if joint.kind != "fixed"}
        # A name that the file gives to a link and to a joint means the link.
        link_of |= {name: name for name in tree.shared_names}
        self.joints: Mapping[str, ParsedJoint] = {
            name: _parsed(joint) for name, joint in joints.items() if joint.type not in _STILL
        }
        self._actuated = list(self._oracle.actuated_joint_names)
        self._moving = [(joint.parent, joint.child) for joint in joints.values() if joint.type not in _STILL]
        self._walk, unplaced = self._order()
        known = {name: link for name, link in link_of.items() if name in robot.frame_names}
        self.frames = tuple(name for name, link in known.items() if link not in unplaced)
        self.left_out = tuple(name for name, link in known.items() if link in unplaced)
        self._place = {self._base: 0} | {child: i for i, (_, child) in enumerate(self._walk, 1)}
        self._selection = [self._place[known[name]] for name in self.frames]

    def poses(self, q: Floats) -> Floats:
        """T_root_frame, shape (n, frames, 4, 4), for configurations of shape (n, nq)."""
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
        """Values of the joints yourdfpy moves; where it moves one that follows in the model, the model's value."""
        columns = {name: index for index, name in enumerate(self._robot.joint_names)}
        values = np.zeros((len(q), len(self._actuated)))
        for index, name in enumerate(self._actuated):
            mimic = self._robot.mimics.get(name)
            if name not in self.joints:
                continue  # a floating joint, which yourdfpy takes for one that moves
            if mimic is None:
                values[:, index] = q[:, columns[name]]
            else:
                values[:, index] = mimic.value(q[:, columns[mimic.joint]])
        return values

    def _order(self) -> tuple[Sequence[tuple[str, str]], set[str]]:
        """The joints as (parent link, child link), parents first, and the links behind a joint it reads otherwise."""
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


def _parsed(joint: Any) -> ParsedJoint:
    limit, mimic = joint.limit, joint.mimic
    return ParsedJoint(
        continuous=joint.type == "continuous",
        lower=limit and limit.lower,
        upper=limit and limit.upper,
        velocity=limit and limit.velocity,
        effort=limit and limit.effort,
        follows=mimic and (mimic.joint, mimic.multiplier, mimic.offset),
    )


@contextlib.contextmanager
def _without_warnings() -> Iterator[None]:
    """Keep yourdfpy from warning, at every configuration, of the couplings that are counted in `left_out`."""
    logger = logging.getLogger("yourdfpy.urdf")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


def _with_offsets(source: io.BytesIO | str, offsets: Mapping[str, Origin]) -> io.BytesIO:
    """The URDF with the origins of its calibrated joints in place of its own."""
    document = ET.parse(source).getroot()
    for joint in document.findall("joint"):
        place = offsets.get(joint.get("name", ""))
        if place is not None:
            for origin in joint.findall("origin"):
                joint.remove(origin)
            xyz, rpy = (" ".join(map(repr, values)) for values in (place.xyz, place.rpy))
            ET.SubElement(joint, "origin", xyz=xyz, rpy=rpy)
    return io.BytesIO(ET.tostring(document))
