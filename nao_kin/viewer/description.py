"""What the panel offers for a robot, and all it has to know about it as one plain document."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, Vector, finite_or_none
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik import limbs
from nao_kin.joints import group_joints
from nao_kin.motion import mirrored_joints
from nao_kin.robot import RobotModel, topology
from nao_kin.robot.nao import BODY_ORDER
from nao_kin.viewer import overlays
from nao_kin.viewer.messages import Command
from nao_kin.viewer.scene import (
    Driver,
    carriers,
    drivers_of,
    link_paths,
    numbered,
    robot_drawables,
    scene_commands,
    width,
)

# Whole-body cameras: the direction from the robot to the camera.
_BODY_CAMERAS: Mapping[str, Vector] = {
    "front": (1.0, 0.0, 0.12),
    "side": (0.0, 1.0, 0.12),
    "three-quarter": (1.0, 0.62, 0.38),
}


@dataclass(frozen=True)
class Camera:
    """Where to look from.

    Attributes:
        direction: from what is looked at to the camera, in the world.
        links: look at these links and all they carry; empty for the whole robot.
    """

    direction: Vector
    links: tuple[str, ...] = ()


@dataclass(frozen=True)
class Presets:
    """What the panel offers for one robot.

    Attributes:
        cameras: views by name.
        effectors: frames whose pose is asked for most.
        chains: title → joints from the trunk outwards.
        root: what to call the frame that poses are given in.
        start: the configuration that a viewer opens with, shape (nq,).
        postures: name → configuration, shape (nq,); none for a robot that has no postures.
        soles: links with the floor in their xy plane when the robot stands on them.
        rest: posture → the vertical in the root's frame; postures not named stand on the soles.
    """

    cameras: Mapping[str, Camera]
    effectors: tuple[str, ...]
    chains: Mapping[str, tuple[str, ...]]
    root: str
    start: Floats
    postures: Mapping[str, Floats]
    soles: tuple[str, ...]
    rest: Mapping[str, Vector]


def presets_of(robot: RobotModel) -> Presets:
    """What the robot means; what its semantics leave open, from its tree: branches as chains, ends as effectors."""
    semantics, tree = robot.semantics, robot.tree
    chains = {**semantics.chains, **_branches(robot)}
    ends = tuple(dict.fromkeys(joints[-1] for joints in chains.values())) or robot.link_names[:1]
    child = {joint.name: joint.child for joint in tree.joints}
    cameras = {name: Camera(direction) for name, direction in _BODY_CAMERAS.items()}
    for name, view in semantics.views.items():
        cameras[name] = Camera(view.direction, tuple(child[joint] for joint in view.joints))
    return Presets(
        cameras=cameras,
        effectors=(*semantics.end_effectors, *semantics.cameras) or ends,
        chains=chains,
        root=semantics.root or tree.root,
        start=robot.posture(semantics.start) if semantics.start else robot.clamp(robot.neutral()),
        postures={name: robot.posture(name) for name in robot.posture_names},
        soles=semantics.soles,
        rest={name: posture.up for name, posture in semantics.postures.items() if posture.up is not None},
    )


class SceneRobot:
    """A robot as a scene has it: its shapes and links, and what the panel offers for it.

    Args:
        robot: any robot.
        number: of it among the robots of a scene; the first, which leads, has 0.

    Attributes:
        robot: the robot.
        drawables: its shapes.
        notes: what of its looks cannot be shown, one line each.
        presets: what the panel offers for it.
        paths: link → path of its node, parents first.
    """

    def __init__(self, robot: RobotModel, number: int = 0) -> None:
        self.robot, self._number = robot, number
        self.drawables, self.notes = robot_drawables(robot.tree)
        self.presets, self.paths = presets_of(robot), link_paths(robot.tree)
        self._places = {link: index for index, link in enumerate(self.paths)}
        self._moved = {joint.name: joint.child for joint in robot.tree.moving_joints}
        self._carriers = carriers(robot.tree, self.drawables)

    @property
    def reaches_aside(self) -> float:
        """How far to the left or right of its root's frame it reaches as it begins [m]."""
        return width(self.robot, self.drawables, self.presets.start)

    def link_of(self, frame: str) -> str:
        """The link in whose node a frame stands: the link itself, the one that a joint moves, else the root."""
        return frame if frame in self.paths else self._moved.get(frame, self.robot.tree.root)

    def commands(self, *, under: str = "", opacity: float = 1.0) -> Iterator[tuple[str, Command]]:
        """Key and command of everything that stands still, as `scene_commands`."""
        return scene_commands(self.robot, self.drawables, under=under, opacity=opacity)

    def colours(self, values: Mapping[str, float], low: float | None, high: float | None, label: str) -> bytes:
        """The message that colours its links by a number each."""
        return overlays.colours(self._places, self._carriers, values, low, high, label, self._number)

    def about(self) -> dict[str, Any]:
        """All that the panel has to know: joints, limits, postures, mirror image, frames, masses, cameras, lights.

        Links are named by their place in `links`, coordinates by their place in q. Names of other people's making are
        values, never keys: JavaScript gives some keys a meaning of its own. Joints that follow another one and carry
        none with a coordinate are no part of any pair.
        """
        robot, presets, place = self.robot, self.presets, self._places
        moving, drivers, views = robot.tree.moving_joints, drivers_of(robot), robot.semantics.fields_of_view
        child = {joint: place[link] for joint, link in self._moved.items()}
        column = {name: drivers[name].column for name in robot.joint_names}
        pairs = {
            part: (joint.pair.name, number) for number, joint in enumerate(group_joints(robot)) for part in joint.joints
        }
        return {
            "name": robot.name,
            "floating": robot.base == "floating",
            "root": "the world" if robot.base == "floating" else presets.root,
            "soles": [place[link] for link in presets.soles],
            "notes": list(self.notes),
            "links": [{"name": name, "path": path.split("/")} for name, path in self.paths.items()],
            "joints": [
                {"name": joint.name, "link": child[joint.name], "slides": joint.kind == "prismatic", "axis": joint.axis}
                | dict(zip(("pair", "group"), pairs.get(joint.name, ("", -1)), strict=True))
                | vars(drivers[joint.name])
                for joint in moving
            ],
            "coordinates": [
                {
                    "joint": name,
                    "column": column[name],
                    "lower": finite_or_none(lower),
                    "upper": finite_or_none(upper),
                    "velocity": finite_or_none(velocity),
                    "unit": unit,
                }
                for name, lower, upper, velocity, unit in zip(
                    robot.joint_names,
                    robot.lower.tolist(),
                    robot.upper.tolist(),
                    robot.velocity_limits.tolist(),
                    robot.joint_units,
                    strict=True,
                )
            ],
            "tables": [
                {"joint": column[table.joint], "of": column[table.of]}
                | {"at": table.at, "lower": table.lower, "upper": table.upper}
                for table in robot.coupled_limits
            ],
            "chains": [
                {"title": title, "joints": [{"name": name, **vars(drivers[name])} for name in names]}
                for title, names in presets.chains.items()
            ],
            "postures": _postures(robot, presets),
            "mirror": _mirror(robot, drivers),
            "naoqi": _naoqi_order(robot),
            "neutral": robot.neutral().tolist(),
            "frames": [{"name": name, "link": place[self.link_of(name)]} for name in robot.frame_names],
            "effectors": [name for name in presets.effectors if name in robot.frame_names],
            "bodies": _bodies(robot, child),
            "cameras": [
                {"name": name, "direction": camera.direction, "links": [place[link] for link in camera.links]}
                for name, camera in presets.cameras.items()
            ],
            "limbs": limbs(robot),
            "head": next((index for name, index in place.items() if "head" in name.lower()), None),
            "accents": [
                {"link": place[drawable.link], "visual": index}
                for index, drawable in numbered(self.drawables)
                if drawable.accent
            ],
            "lights": [
                {"name": drawable.light, "link": place[drawable.link], "visual": index}
                for index, drawable in numbered(self.drawables)
                if drawable.light
            ],
            "eyes": [
                {"name": name, "link": place[self.link_of(name)]}
                | dict(zip(("horizontal", "vertical"), views.get(name, (None, None)), strict=True))
                for name in robot.semantics.cameras
            ],
        }


def _branches(robot: RobotModel) -> dict[str, tuple[str, ...]]:
    """The joints that no chain of the semantics has, by the branches of the tree."""
    named = {joint for joints in robot.chains.values() for joint in joints}
    branches = (tuple(j for j in chain if j not in named) for chain in topology(robot).chains)
    return {joints[0] if len(joints) == 1 else f"{joints[0]} … {joints[-1]}": joints for joints in branches if joints}


def _postures(robot: RobotModel, presets: Presets) -> list[dict[str, Any]]:
    """Those of the robot; one without any has all joints at zero, or where their limits come nearest to it."""
    postures = presets.postures or {"Zero": robot.clamp(robot.neutral())}
    return [{"name": name, "q": q.tolist(), "up": presets.rest.get(name)} for name, q in postures.items()]


def _mirror(robot: RobotModel, drivers: Mapping[str, Driver]) -> list[dict[str, Any]]:
    """The mirror image of q: q[column] becomes multiplier · q[of] + offset. Empty for robots without two sides."""
    try:
        pairs = mirrored_joints(robot)
    except (BadArgument, UnknownName):
        return []
    if all(name == other for name, (other, _) in pairs.items()):
        return []
    rows = []
    for name, (other, sign) in pairs.items():
        driver = drivers[other]
        rows.append(
            {"column": drivers[name].column, "of": driver.column}
            | {"multiplier": sign * driver.multiplier, "offset": sign * driver.offset}
        )
    return rows


def _naoqi_order(robot: RobotModel) -> list[str]:
    """The robot's joints in the order of NAOqi's Body; empty where those names do not set every joint."""
    names = [name for name in BODY_ORDER if name in robot.joint_names or name in robot.mimics]
    moved = {robot.mimics[name].joint if name in robot.mimics else name for name in names}
    return names if moved == set(robot.joint_names) else []


def _bodies(robot: RobotModel, child: Mapping[str, int]) -> list[dict[str, Any]]:
    """Mass and centre of everything that moves as one, from the model: no matter how its links share them."""
    bodies = []
    for index, inertia in enumerate(robot.model.inertias):
        if inertia.mass > 0.0:
            link = child.get(robot.model.names[index], 0)
            bodies.append({"link": link, "mass": float(inertia.mass), "centre": np.array(inertia.lever).tolist()})
    return bodies
