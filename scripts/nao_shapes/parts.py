"""All parts of the robot, by the names that nao_kin.parameters.VISUALS gives them, as the text of their files."""

from __future__ import annotations

from collections.abc import Iterator

from nao_kin.parameters import CAMERAS, Version, nao_parameters
from nao_shapes.arm import elbow, forearm, hinge, shoulder, shoulder_pad, upper_arm
from nao_shapes.foot import foot
from nao_shapes.hand import fingertip, palm, phalanx
from nao_shapes.head import ears, head, neck, sensors
from nao_shapes.leg import ankle, hip, pelvis, shin, thigh
from nao_shapes.solids import Part
from nao_shapes.surface import TOLERANCE_MM, obj_text, surface_of
from nao_shapes.torso import torso

# The face is looked at from closer by than the rest: how far its surface may move [mm].
_FINE_MM = 0.2


def mesh_texts() -> Iterator[tuple[str, str]]:
    """Name and OBJ text of every mesh; equal every time."""
    for name, part in _middle_parts().items():
        for colour, solid in part.items():
            fine = _FINE_MM if name != "torso" else TOLERANCE_MM
            yield f"{name}_{colour}", obj_text(f"{name}_{colour}", surface_of(solid, symmetric=True, tolerance=fine))
    for name, part in {"phalanx": phalanx(), "fingertip": fingertip()}.items():
        for colour, solid in part.items():
            yield f"{name}_{colour}", obj_text(f"{name}_{colour}", surface_of(solid))
    for name, part in _left_parts().items():
        for colour, solid in part.items():
            left = surface_of(solid)
            yield f"l_{name}_{colour}", obj_text(f"l_{name}_{colour}", left)
            yield f"r_{name}_{colour}", obj_text(f"r_{name}_{colour}", left, mirrored=True)


def _middle_parts() -> dict[str, Part]:
    """The parts that are their own mirror images."""
    parts = {"torso": torso(), "neck": neck(), "head": head(), "ears": ears("accent"), "ears_v33": ears("grey")}
    for version, suffix in (("v6", ""), ("v5", "_v5"), ("v3.3", "_v33")):
        parts[f"sensors{suffix}"] = _sensors(version)
    return parts


def _sensors(version: Version) -> Part:
    frames = {row.name: row for row in nao_parameters(version).frames}
    mm = {name: tuple(1000 * value for value in row.xyz) for name, row in frames.items()}
    cameras = {name: (mm[name], frames[name].rpy[1]) for name in CAMERAS}
    return sensors(cameras, tuple(at for name, at in mm.items() if name.startswith("Micro") and name != "MicrophoneFrame"))


def _left_parts() -> dict[str, Part]:
    """The parts of the left side; those of the right are their mirror images."""
    parts = {
        "shoulder": shoulder(),
        "shoulder_pad": shoulder_pad(),
        "elbow": elbow(),
        "hinge": hinge(),
        "hand": palm(),
        "pelvis": pelvis(),
        "hip": hip(),
        "thigh": thigh(),
        "shin": shin(),
        "ankle": ankle(),
        "foot": foot(),
    }
    for version, suffix in (("v6", ""), ("v3.2", "_v32")):
        mm = {name: 1000 * value for name, value in nao_parameters(version).offsets.items()}
        parts[f"upper_arm{suffix}"] = upper_arm(mm["UpperArmLength"], mm["ElbowOffsetY"])
        parts[f"forearm{suffix}"] = forearm(mm["LowerArmLength"])
    return parts
