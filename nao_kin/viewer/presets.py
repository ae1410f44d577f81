"""What is particular to a robot: how its postures rest, where its cameras look, which frames matter most."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from nao_kin.nao import NaoModel
from nao_kin.robot import RobotModel
from nao_kin.topology import topology
from nao_kin.urdf_reader import UrdfTree

# Whole-body cameras: the direction from the robot to the camera.
_BODY_CAMERAS: Mapping[str, tuple[float, float, float]] = {
    "front": (1.0, 0.0, 0.12),
    "side": (0.0, 1.0, 0.12),
    "three-quarter": (1.0, 0.62, 0.38),
}
_NAO_CAMERAS: Mapping[str, tuple[tuple[float, float, float], tuple[str, ...]]] = {
    "hands": ((1.0, 0.25, 0.55), ("LWristYaw", "RWristYaw")),
    "feet": ((1.0, 0.45, 0.42), ("LAnklePitch", "RAnklePitch")),
}
# NAOqi's postures say nothing about the trunk. Off its feet the robot rests where its centre of mass is lowest: the
# vertical there in the torso's frame, found with the shapes of the V6 by turning them until no small turn lowers it.
_NAO_REST: Mapping[str, tuple[float, float, float]] = {
    "Sit": (0.384, -0.001, 0.923),
    "SitRelax": (0.177, 0.010, 0.984),
    "LyingBelly": (-0.976, -0.160, 0.146),
    "LyingBack": (1.000, -0.015, 0.003),
}
_NAO_EFFECTORS = ("Head", "LArm", "RArm", "LLeg", "RLeg", "CameraTop", "CameraBottom")
_NAO_SOLES = ("LLeg", "RLeg")


@dataclass(frozen=True)
class Camera:
    """Where to look from.

    Attributes:
        direction: from what is looked at to the camera, in the world.
        links: look at these links and all they carry; empty for the whole robot.
    """

    direction: tuple[float, float, float]
    links: tuple[str, ...] = ()


@dataclass(frozen=True)
class Presets:
    """What the panel offers for one robot.

    Attributes:
        cameras: views by name.
        effectors: frames whose pose is asked for most.
        chains: title → joints from the trunk outwards.
        root: what to call the frame that poses are given in.
        soles: links with the floor in their xy plane when the robot stands on them.
        rest: posture → the vertical in the root's frame; postures not named stand on the soles.
    """

    cameras: Mapping[str, Camera]
    effectors: tuple[str, ...]
    chains: Mapping[str, tuple[str, ...]]
    root: str
    soles: tuple[str, ...] = ()
    rest: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)


def presets_of(robot: RobotModel, tree: UrdfTree) -> Presets:
    """NAO's own, or what the tree of any other robot suggests: branches as chains, their ends as effectors."""
    cameras = {name: Camera(direction) for name, direction in _BODY_CAMERAS.items()}
    if isinstance(robot, NaoModel):
        child = {joint.name: joint.child for joint in tree.joints}
        for name, (direction, joints) in _NAO_CAMERAS.items():
            cameras[name] = Camera(direction, tuple(child[joint] for joint in joints))
        return Presets(cameras, _NAO_EFFECTORS, robot.chains, "torso", _NAO_SOLES, _NAO_REST)
    chains = topology(robot).chains
    return Presets(
        cameras,
        tuple(dict.fromkeys(chain[-1] for chain in chains)) or robot.link_names[:1],
        {chain[0] if len(chain) == 1 else f"{chain[0]} … {chain[-1]}": chain for chain in chains},
        tree.root,
    )
