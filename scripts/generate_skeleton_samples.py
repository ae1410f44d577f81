"""Write the sample skeletons of `nao_kin.imitation`: motions of a simple articulated person, made of sines.

    python scripts/generate_skeleton_samples.py [FOLDER]

The person has the joints of a Mixamo rig. A wave and slow circles of the arms are BVH files; a bow is a JSON file of
the world landmarks of MediaPipe.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

import nao_kin as nk
from nao_kin._core.files import write_text
from nao_kin.imitation.layouts import LAYOUTS

FOLDER = Path(__file__).resolve().parents[1] / "nao_kin" / "imitation" / "samples"

# Joint → where it is from its parent in the rest pose, arms stretched out [cm]; x to the left, y up, z ahead. The
# proportions are those of an adult of 1.7 m. "*" stands for Left and Right; on the right x is negative.
BODY = {
    "Hips": ("", (0, 95, 0)),
    "Spine": ("Hips", (0, 10, 0)),
    "Spine1": ("Spine", (0, 12, 0)),
    "Spine2": ("Spine1", (0, 13, 0)),
    "Neck": ("Spine2", (0, 18, 0)),
    "Head": ("Neck", (0, 9, 2)),
    "*Shoulder": ("Spine2", (4, 14, 0)),
    "*Arm": ("*Shoulder", (14, 0, 0)),
    "*ForeArm": ("*Arm", (31, 0, 0)),
    "*Hand": ("*ForeArm", (25, 0, 0)),
    "*HandMiddle1": ("*Hand", (9, 0, 0)),
    "*UpLeg": ("Hips", (9, -4, 0)),
    "*Leg": ("*UpLeg", (0, -42, 0)),
    "*Foot": ("*Leg", (0, -42, 0)),
    "*ToeBase": ("*Foot", (0, -7, 13)),
}
ENDS = {"Head": (0, 18, 0), "*HandMiddle1": (9, 0, 0), "*ToeBase": (0, 0, 7)}
# Points of the face in the frame of the head (ahead, left, up), and of hands and feet in theirs [m].
FACE = {
    "nose": (0.10, 0.0, 0.06),
    "eye_inner": (0.08, 0.015, 0.09),
    "eye": (0.08, 0.03, 0.09),
    "eye_outer": (0.075, 0.045, 0.09),
    "ear": (0.0, 0.075, 0.07),
    "mouth": (0.085, 0.025, 0.02),
}
HAND = {"pinky": (0.08, 0.035, 0.0), "index": (0.09, -0.03, 0.0), "thumb": (0.06, -0.06, -0.01)}

# Angles of joints at a time: joint → (z, x, y) [degrees], about moving axes.
Angles = Mapping[str, tuple[float, float, float]]


def hierarchy() -> tuple[str, list[str]]:
    """Return the hierarchy of a BVH file, and its joints in the order of their channels."""
    bones = {}
    for name, (parent, offset) in BODY.items():
        for side, sign in (("Left", 1), ("Right", -1)) if "*" in name else (("", 1),):
            end = ENDS.get(name)
            bones[name.replace("*", side)] = (
                parent.replace("*", side),
                (sign * offset[0], *offset[1:]),
                end and (sign * end[0], *end[1:]),
            )
    lines, order = ["HIERARCHY"], []

    def write(name: str, depth: int) -> None:
        _, offset, end = bones[name]
        indent = "  " * depth
        position = "" if depth else "Xposition Yposition Zposition "
        order.append(name)
        lines.extend([f"{indent}{'JOINT' if depth else 'ROOT'} {name}", f"{indent}{{"])
        lines.append(f"{indent}  OFFSET {' '.join(map(str, offset))}")
        lines.append(f"{indent}  CHANNELS {3 if depth else 6} {position}Zrotation Xrotation Yrotation")
        for child, (parent, *_) in bones.items():
            if parent == name:
                write(child, depth + 1)
        if end:
            place = " ".join(map(str, end))
            lines.extend([f"{indent}  End Site", f"{indent}  {{", f"{indent}    OFFSET {place}", f"{indent}  }}"])
        lines.append(f"{indent}}}")

    write("Hips", 0)
    return "\n".join(lines), order


def bvh(motion: Callable[[float], tuple[tuple[float, float, float], Angles]], seconds: float, rate: int) -> str:
    """Return the BVH file of a motion: time in seconds → position of the hips [cm] and angles."""
    text, order = hierarchy()
    count = round(seconds * rate) + 1
    rows = []
    for frame in range(count):
        hips, angles = motion(frame / rate)
        values = [*hips, *(value for joint in order for value in angles.get(joint, (0.0, 0.0, 0.0)))]
        rows.append(" ".join(f"{value:.1f}".replace("-0.0", "0.0").removesuffix(".0") for value in values))
    return "\n".join([text, "MOTION", f"Frames: {count}", f"Frame Time: {1 / rate:.6f}", *rows]) + "\n"


def rising(time: float, begin: float, end: float) -> float:
    """Return 0 before `begin`, 1 after `end`, smoothly between."""
    s = min(max((time - begin) / (end - begin), 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


def wave(time: float) -> tuple[tuple[float, float, float], Angles]:
    """Raise the right arm, wave four times, lower it."""
    up = rising(time, 0.0, 0.8) - rising(time, 2.4, 3.2)
    swing = np.sin(2.0 * np.pi * 2.5 * (time - 0.8)) * (rising(time, 0.7, 0.9) - rising(time, 2.3, 2.5))
    return (0.0, 95.0, 0.0), {
        "LeftArm": (-75.0, 0.0, 0.0),
        "LeftForeArm": (0.0, 0.0, -15.0),
        "RightArm": (75.0 - 80.0 * up, 0.0, 20.0 * up),
        "RightForeArm": (-(80.0 * up + 25.0 * swing), 0.0, 15.0 * (1.0 - up)),
        "Head": (6.0 * up, 0.0, -10.0 * up),
    }


def bow(time: float) -> tuple[tuple[float, float, float], Angles]:
    """Bend the trunk by 60° and straighten it, with the hands along the thighs."""
    down = rising(time, 0.3, 1.2) - rising(time, 1.8, 2.7)
    leg, shoulder = (0.0, -20.0 * down, 0.0), (0.0, -50.0 * down, 0.0)
    return (0.0, 95.0, -6.0 * down), {
        "Hips": (0.0, 20.0 * down, 0.0),
        **dict.fromkeys(("Spine", "Spine1", "Spine2"), (0.0, 40.0 / 3.0 * down, 0.0)),
        "LeftUpLeg": leg,
        "RightUpLeg": leg,
        "LeftShoulder": shoulder,
        "RightShoulder": shoulder,
        "LeftArm": (-80.0, 0.0, 0.0),
        "RightArm": (80.0, 0.0, 0.0),
    }


def circles(time: float) -> tuple[tuple[float, float, float], Angles]:
    """Move the hands in slow opposite circles before the body, with bent knees, and turn the trunk along."""
    phase, on = 2.0 * np.pi * time / 4.0, rising(time, 0.0, 1.0) - rising(time, 7.0, 8.0)
    bend = 18.0 * on
    angles = {"Spine1": (0.0, 0.0, 20.0 * on * np.sin(phase))}
    for side, sign, own in (("Left", 1.0, phase), ("Right", -1.0, phase + np.pi)):
        rise, ahead = 15.0 * np.cos(own), 60.0 + 20.0 * np.sin(own)
        angles[f"{side}Arm"] = (sign * (-75.0 + on * (50.0 + rise)), 0.0, -sign * on * ahead)
        angles[f"{side}ForeArm"] = (0.0, 0.0, -sign * (10.0 + on * (50.0 + 15.0 * np.cos(own))))
        angles[f"{side}UpLeg"] = (0.0, -bend, 0.0)
        angles[f"{side}Leg"] = (0.0, 2.0 * bend, 0.0)
        angles[f"{side}Foot"] = (0.0, -bend, 0.0)
    return (0.0, 95.0 - 84.0 * (1.0 - np.cos(np.radians(bend))), 0.0), angles


def landmarks(text: str) -> str:
    """Return the world landmarks of MediaPipe, JSON, of the person in a BVH file, who faces the camera."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "person.bvh")
        file.write_text(text)
        person = nk.imitation.read_skeleton(file)
    points = dict(person.points)
    for side in ("left_", "right_"):
        sign = 1.0 if side == "left_" else -1.0
        for part, (ahead, left, up) in FACE.items():
            name = part if part == "nose" else f"mouth_{side[:-1]}" if part == "mouth" else side + part
            points[name] = points["head"] + person.orientations["head"] @ (ahead, sign * left, up)
        for part, (along, across, out) in HAND.items():
            points[side + part] = points[side + "wrist"] + person.orientations[side + "hand"] @ (
                along,
                sign * across,
                out,
            )
        points[side + "heel"] = points[side + "ankle"] + (-0.05, 0.0, -0.06)
        points[side + "foot_index"] = points[side + "toe"]
    middle = (points["left_hip"] + points["right_hip"]) / 2.0
    ordered = np.stack([points[name] - middle for name in LAYOUTS["mediapipe"].orders[0]], axis=1)
    image = np.stack([ordered[..., 1], -ordered[..., 2], -ordered[..., 0], np.ones(ordered.shape[:2])], axis=-1)
    document = {"times": person.times.round(4).tolist(), "landmarks": (image.round(3) + 0.0).tolist()}
    return json.dumps(document, separators=(",", ":")).replace("]],[[", "]],\n[[") + "\n"


def main() -> None:
    """Write the samples."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=FOLDER)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / "wave.bvh", bvh(wave, 3.2, 20))
    write_text(folder / "circles.bvh", bvh(circles, 8.0, 10))
    write_text(folder / "bow.json", landmarks(bvh(bow, 3.0, 10)))


if __name__ == "__main__":
    main()
