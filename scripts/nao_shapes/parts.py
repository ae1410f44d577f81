"""All parts of the robot, by the names that nao_kin.parameters.VISUALS gives them, as the text of their files."""

from __future__ import annotations

from collections.abc import Iterator

from nao_kin.parameters import nao_parameters
from nao_shapes.arm import elbow, fingertip, forearm, hinge, palm, phalanx, shoulder, shoulder_pad, upper_arm
from nao_shapes.leg import ankle, foot, hip, pelvis, shin, thigh
from nao_shapes.solids import Part
from nao_shapes.surface import obj_text, surface_of
from nao_shapes.trunk import head, neck, torso


def mesh_texts() -> Iterator[tuple[str, str]]:
    """Name and OBJ text of every mesh; equal every time."""
    for name, part in {"torso": torso(), "neck": neck(), "head": head()}.items():
        for colour, solid in part.items():
            yield f"{name}_{colour}", obj_text(f"{name}_{colour}", surface_of(solid, symmetric=True))
    for name, part in {"phalanx": phalanx(), "fingertip": fingertip()}.items():
        for colour, solid in part.items():
            yield f"{name}_{colour}", obj_text(f"{name}_{colour}", surface_of(solid))
    for name, part in _left_parts().items():
        for colour, solid in part.items():
            left = surface_of(solid)
            yield f"l_{name}_{colour}", obj_text(f"l_{name}_{colour}", left)
            yield f"r_{name}_{colour}", obj_text(f"r_{name}_{colour}", left, mirrored=True)


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
