"""What is particular to a robot: how its postures rest, where its cameras look, which frames matter most."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from nao_kin._arrays import Floats
from nao_kin.nao import NaoModel
from nao_kin.robot import RobotModel
from nao_kin.topology import topology
from nao_kin.urdf_reader import UrdfTree

Vector = tuple[float, float, float]

# Whole-body cameras: the direction from the robot to the camera.
_BODY_CAMERAS: Mapping[str, Vector] = {
    "front": (1.0, 0.0, 0.12),
    "side": (0.0, 1.0, 0.12),
    "three-quarter": (1.0, 0.62, 0.38),
}
_NAO_CLOSE_UPS: Mapping[str, tuple[Vector, tuple[str, ...]]] = {
    "hands": ((1.0, 0.25, 0.55), ("LWristYaw", "RWristYaw")),
    "feet": ((1.0, 0.45, 0.42), ("LAnklePitch", "RAnklePitch")),
}
# NAOqi's postures say nothing about the trunk. Off its feet the robot rests where its centre of mass is lowest: the
# vertical there in the torso's frame, found with the shapes of the V6 by turning them until no small turn lowers it.
_NAO_REST: Mapping[str, Vector] = {
    "Sit": (0.384, -0.001, 0.923),
    "SitRelax": (0.177, 0.010, 0.984),
    "LyingBelly": (-0.976, -0.160, 0.146),
    "LyingBack": (1.000, -0.015, 0.003),
}
_START = "StandInit"


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


def presets_of(robot: RobotModel, tree: UrdfTree) -> Presets:
    """What the robot means; what it leaves open, from its tree: branches as chains, their ends as effectors."""
    meaning = _meaning_of(robot)
    chains, effectors = meaning.chains, (*meaning.end_effectors, *meaning.cameras)
    if not chains:
        branches = topology(robot).chains
        chains = {joints[0] if len(joints) == 1 else f"{joints[0]} … {joints[-1]}": joints for joints in branches}
    if not effectors:
        effectors = tuple(dict.fromkeys(joints[-1] for joints in chains.values())) or robot.link_names[:1]
    child = {joint.name: joint.child for joint in tree.joints}
    cameras = {name: Camera(direction) for name, direction in _BODY_CAMERAS.items()}
    for name, (direction, joints) in meaning.close_ups.items():
        cameras[name] = Camera(direction, tuple(child[joint] for joint in joints))
    return Presets(
        cameras=cameras,
        effectors=effectors,
        chains=chains,
        root=meaning.root or tree.root,
        start=meaning.postures[_START] if _START in meaning.postures else robot.clamp(robot.neutral()),
        postures=meaning.postures,
        soles=meaning.soles,
        rest=meaning.rest,
    )


@dataclass(frozen=True)
class _Meaning:
    """What a robot means beyond its URDF, as far as the viewer asks; empty where nobody has said.

    Attributes:
        chains: name → joints from the trunk outwards.
        end_effectors: frames at the ends of the chains.
        cameras: frames of its cameras.
        soles: links that it stands on.
        postures: name → configuration, shape (nq,).
        root: name of the frame that poses are given in, where the URDF's root link is but a name for it.
        rest: posture → the vertical in the root's frame, for those that do not stand.
        close_ups: name → direction to the viewer's camera, and the joints whose links it looks at.
    """

    chains: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    end_effectors: tuple[str, ...] = ()
    cameras: tuple[str, ...] = ()
    soles: tuple[str, ...] = ()
    postures: Mapping[str, Floats] = field(default_factory=dict)
    root: str = ""
    rest: Mapping[str, Vector] = field(default_factory=dict)
    close_ups: Mapping[str, tuple[Vector, tuple[str, ...]]] = field(default_factory=dict)


def _meaning_of(robot: RobotModel) -> _Meaning:
    """The one place that knows which robot is a NAO."""
    if not isinstance(robot, NaoModel):
        return _Meaning()
    return _Meaning(
        chains=robot.chains,
        end_effectors=("Head", "LArm", "RArm", "LLeg", "RLeg"),
        cameras=("CameraTop", "CameraBottom"),
        soles=("LLeg", "RLeg"),
        postures={name: robot.posture(name) for name in robot.posture_names},
        root="torso",
        rest=_NAO_REST,
        close_ups=_NAO_CLOSE_UPS,
    )
