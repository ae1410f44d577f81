"""All parts of the robot, by the names that VISUALS gives them, as the text of their files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from manifold3d import Manifold

from nao_kin.robot.nao import Version, nao_parameters
from nao_kin.robot.nao.tables import CAMERAS
from nao_shapes.arm import elbow, forearm, hinge, shoulder, shoulder_pad, upper_arm
from nao_shapes.foot import foot
from nao_shapes.hand import fingertip, palm, phalanx
from nao_shapes.head import ears, head, neck, sensors
from nao_shapes.leg import ankle, hip, pelvis, shin, thigh
from nao_shapes.solids import Part, Point
from nao_shapes.surface import TOLERANCE_MM, obj_text, surface_of
from nao_shapes.torso import torso

# Largest movement of the surface [mm]; head and fingers have finer curves than the rest.
_FINE_MM = 0.25
# The skull has the largest round outline; with these tolerances the segments of an eye remain equal.
_TOLERANCES_MM = {
    "head_white": 0.18,
    "head_grey": 0.1,
    "head_led": 0.0,
    "torso_white": 0.2,
    "torso_dark": 0.4,
    "shoulder_pad_accent": 0.15,
    "hand_white": 0.25,
    "fingertip_dark": 0.1,
}


def mesh_texts() -> Iterator[tuple[str, str]]:
    """Return name and OBJ text of every mesh, the same every time."""
    for name, solid in _meshes(_middle_parts()):
        fine = _TOLERANCES_MM.get(name, _FINE_MM)
        yield name, obj_text(name, surface_of(solid, mirror="y", tolerance=fine))
    for name, solid in _meshes({"phalanx": phalanx(), "fingertip": fingertip()}):
        yield name, obj_text(name, surface_of(solid, mirror="z", tolerance=_TOLERANCES_MM.get(name, _FINE_MM)))
    for name, solid in _meshes(_left_parts()):
        left = surface_of(solid, tolerance=_TOLERANCES_MM.get(name, TOLERANCE_MM))
        yield f"l_{name}", obj_text(f"l_{name}", left)
        yield f"r_{name}", obj_text(f"r_{name}", left, mirrored=True)


def _meshes(parts: Mapping[str, Part]) -> Iterator[tuple[str, Manifold]]:
    for name, part in parts.items():
        for colour, solid in part.items():
            yield f"{name}_{colour}", solid


def _middle_parts() -> dict[str, Part]:
    """The parts that are their own mirror images."""
    parts = {"torso": torso(), "neck": neck(), "head": head(), "ears": ears("accent"), "ears_v33": ears("grey")}
    parts |= {"sensors": _sensors("v6"), "sensors_v5": _sensors("v5"), "sensors_v33": _sensors("v3.3")}
    return parts


def _sensors(version: Version) -> Part:
    frames = {frame.name: frame for frame in nao_parameters(version).frames}
    mm: dict[str, Point] = {}
    for name, frame in frames.items():
        x, y, z = frame.xyz
        mm[name] = (1000 * x, 1000 * y, 1000 * z)
    holes = [at for name, at in mm.items() if name.startswith("Micro") and name != "MicrophoneFrame"]
    return sensors([(mm[name], frames[name].rpy[1]) for name in CAMERAS], holes)


def _left_parts() -> dict[str, Part]:
    """The parts of the left side; those of the right are their mirror images."""
    new, old = _lengths("v6"), _lengths("v3.2")
    parts = {
        "shoulder": shoulder(),
        "shoulder_pad": shoulder_pad(),
        "elbow": elbow(),
        "hinge": hinge(),
        "hand": palm(),
        "pelvis": pelvis(),
        "hip": hip(),
        "thigh": thigh(new["ThighLength"]),
        "shin": shin(new["TibiaLength"]),
        "ankle": ankle(),
        "foot": foot(),
    }
    parts["upper_arm"] = upper_arm(new["UpperArmLength"], new["ElbowOffsetY"])
    parts["upper_arm_v32"] = upper_arm(old["UpperArmLength"], old["ElbowOffsetY"])
    parts["forearm"] = forearm(new["LowerArmLength"])
    # The coloured cover on the forearm came with V4.
    parts["forearm_v32"] = {"white": forearm(old["LowerArmLength"])["white"]}
    return parts


def _lengths(version: Version) -> dict[str, float]:
    return {name: 1000 * value for name, value in nao_parameters(version).offsets.items()}
