"""What is particular to a robot: how its postures rest, where its cameras look, which frames matter most."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from nao_kin._common.arrays import Floats
from nao_kin.robot import RobotModel, topology

Vector = tuple[float, float, float]

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


def _branches(robot: RobotModel) -> dict[str, tuple[str, ...]]:
    """The joints that no chain of the semantics has, by the branches of the tree."""
    named = {joint for joints in robot.chains.values() for joint in joints}
    branches = (tuple(j for j in chain if j not in named) for chain in topology(robot).chains)
    return {joints[0] if len(joints) == 1 else f"{joints[0]} … {joints[-1]}": joints for joints in branches if joints}
