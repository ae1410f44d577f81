"""BVH files against a second reader, with SciPy's rotations; names, axes and orientations; malformed files."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from loops import every_value
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin.imitation.layouts import resolved

Floats = NDArray[np.float64]
WAVE = nk.imitation.SAMPLES["wave"].read_text(encoding="utf-8")
# Points that no check of handedness uses.
MAPPED = ("left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist", "pelvis", "neck")


def second_reader(text: str) -> dict[str, Floats]:
    """Return joint → positions (frames, 3), by products of 4×4 matrices from the root, frame by frame."""
    head, body = re.split(r"(?i)Frame\s+Time:\s*\S+", text)
    rows = np.array([[float(word) for word in line.split()] for line in body.splitlines() if line.split()])
    words, path, joints, column = head.split(), [], {}, 0
    for i, word in enumerate(words):
        if word in ("ROOT", "JOINT"):
            joints[words[i + 1]] = {"path": [*path, words[i + 1]], "channels": []}
            name = words[i + 1]
        elif word == "Site":
            name = path[-1] + "_end"
            joints[name] = {"path": [*path, name], "channels": []}
        elif word == "{":
            path.append(name)
        elif word == "}":
            path.pop()
        elif word == "OFFSET":
            joints[path[-1]]["offset"] = [float(value) for value in words[i + 1 : i + 4]]
        elif word == "CHANNELS":
            count = int(words[i + 1])
            names = [channel.lower() for channel in words[i + 2 : i + 2 + count]]
            joints[path[-1]]["channels"] = list(zip(names, range(column, column + count), strict=True))
            column += count
    found: dict[str, Floats] = {}
    for joint, entry in joints.items():
        places = []
        for row in rows:
            T = np.eye(4)
            for name in entry["path"]:
                step, offset = np.eye(4), list(joints[name]["offset"])
                sequence, angles = "", []
                for channel, at in joints[name]["channels"]:
                    if channel.endswith("position"):
                        offset["xyz".index(channel[0])] = row[at]
                    else:
                        sequence += channel[0].upper()  # upper case: about moving axes
                        angles.append(row[at])
                step[:3, 3] = offset
                if sequence:
                    step[:3, :3] = Rotation.from_euler(sequence, np.reshape(angles, (1, -1)), degrees=True).as_matrix()[
                        0
                    ]
                T = T @ step
            places.append(T[:3, 3])
        found[joint] = np.array(places)
    return found


def made_up(rng: np.random.Generator, order: str, positions: str) -> str:
    """Return a BVH file of a random tree of joints j0, j1, …, with blanks and tabs in any number."""
    count = 12
    parents = [-1, *(int(rng.integers(max(0, k - 4), k)) for k in range(1, count))]
    lines, width = ["HIERARCHY"], 0

    def blank() -> str:
        return str(rng.choice([" ", "\t", "   ", " \t "]))

    def write(k: int) -> None:
        nonlocal width
        lines.append(("JOINT" if k else "ROOT") + blank() + f"j{k}")
        lines.append(blank() + "{")
        lines.append("OFFSET" + "".join(blank() + f"{value:.6f}" for value in rng.normal(size=3)))
        channels = [f"{axis}rotation" for axis in order][: 3 if k % 5 else int(rng.integers(1, 4))]
        if positions == "all" or (positions == "root" and not k):
            channels = [*(f"{axis}position" for axis in rng.permutation([*"XYZ"])), *channels]
        if positions == "some" and k % 2:
            channels.insert(1, "Yposition")
        width += len(channels)
        lines.append("CHANNELS" + blank() + str(len(channels)) + "".join(blank() + channel for channel in channels))
        children = [child for child, parent in enumerate(parents) if parent == k]
        for child in children:
            write(child)
        if not children:
            lines.append("End Site\n{\n OFFSET 0.1 0.2 -0.3\n}")
        lines.append("}")

    write(0)
    rows = rng.uniform(-180.0, 180.0, size=(4, width))
    body = ["\t".join(f"{value:.6f}" for value in row) + blank() for row in rows]
    return "\n".join([*lines, "MOTION", f"Frames:{blank()}4", f"Frame Time:{blank()}0.008333", *body, ""])


@pytest.mark.parametrize(
    ("positions", "order"),
    every_value(["none", "root", "some", "all"], ["".join(axes) for axes in itertools.permutations("XYZ")]),
)
def test_random_hierarchies_agree_with_a_second_reader(tmp_path: Path, order: str, positions: str) -> None:
    rng = np.random.default_rng([*order.encode(), len(positions)])
    text = made_up(rng, order, positions)
    file = tmp_path / "made up.bvh"
    file.write_bytes(text.replace("\n", "\r\n").encode())
    joints = second_reader(text)
    chosen = rng.choice([*joints], size=len(MAPPED), replace=False)
    names = dict(zip(MAPPED, map(str, chosen), strict=True))
    skeleton = nk.imitation.read_skeleton(file, names=names, units="m", up="z")
    np.testing.assert_allclose(skeleton.times, np.arange(4) * 0.008333, atol=1e-15)
    for name, joint in names.items():
        np.testing.assert_allclose(skeleton.points[name], joints[joint], atol=1e-12)


def test_a_sample_agrees_with_a_second_reader() -> None:
    skeleton, joints = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"]), second_reader(WAVE)
    for name, (joint, *_) in resolved(tuple(joints)).items():
        x, y, z = joints[joint].T / 100.0
        np.testing.assert_allclose(skeleton.points[name], np.stack([z, x, y], axis=1), atol=1e-12)


# The names of producers for the joints of the wave: those of left and right, "*" in the names of clavicle, arm, leg and
# toe, and the trunk.
WAVE_SIDE = ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")
WAVE_TRUNK = ("Hips", "Spine2", "Neck", "Head")
PRODUCERS = """
Mixamo | Left Right | mixamorig:*Shoulder mixamorig:*Arm mixamorig:*ForeArm mixamorig:*Hand mixamorig:*UpLeg \
    mixamorig:*Leg mixamorig:*Foot mixamorig:*ToeBase | Hips Spine2 Neck Head
LAFAN1 | Left Right | *Shoulder *Arm *ForeArm *Hand *UpLeg *Leg *Foot *Toe | Hips Spine2 Neck Head
Rokoko | Left Right | *Shoulder *Arm *ForeArm *Hand *Thigh *Shin *Foot *Toe | Hips Spine4 Neck Head
Xsens | Left Right | *Collar *Shoulder *Elbow *Wrist *Hip *Knee *Ankle *Toe | Hips Chest4 Neck Head
Biovision | Left Right | *Collar *UpArm *LowArm *Hand *UpLeg *LowLeg *Foot *Toe | Hips Chest Neck Head
Daz | l r | *Collar *Shldr *ForeArm *Hand *Thigh *Shin *Foot *Toe | hip chest neck head
Genesis | l r | *Collar *ShldrBend *ForearmBend *Hand *ThighBend *Shin *Foot *Toe | hip chest neckLower head
MocapNET | l r | *collar *shoulder *elbow *hand *hip *knee *foot toe1-1.* | hip chest neck head
MakeHuman | L R | clavicle.* upperarm01.* lowerarm01.* wrist.* upperleg01.* lowerleg01.* foot.* toe1-1.* \
    | root spine01 neck01 head
Bandai-Namco | L R | Shoulder_* UpperArm_* LowerArm_* Hand_* UpperLeg_* LowerLeg_* Foot_* Toes_* | Hips Chest Neck Head
3ds Max | L R | Bip01~*~Clavicle Bip01~*~UpperArm Bip01~*~Forearm Bip01~*~Hand Bip01~*~Thigh Bip01~*~Calf \
    Bip01~*~Foot Bip01~*~Toe0 | Bip01~Pelvis Bip01~Spine2 Bip01~Neck Bip01~Head
Unreal | l r | clavicle_* upperarm_* lowerarm_* hand_* thigh_* calf_* foot_* ball_* | pelvis spine_03 neck_01 head
VRM | L R | J_Bip_*_Shoulder J_Bip_*_UpperArm J_Bip_*_LowerArm J_Bip_*_Hand J_Bip_*_UpperLeg J_Bip_*_LowerLeg \
    J_Bip_*_Foot J_Bip_*_ToeBase | J_Bip_C_Hips J_Bip_C_Chest J_Bip_C_Neck J_Bip_C_Head
Rigify | L R | DEF-shoulder.* DEF-upper_arm.* DEF-forearm.* DEF-hand.* DEF-thigh.* DEF-shin.* DEF-foot.* DEF-toe.* \
    | hips chest neck head
Acclaim | l r | *clavicle *humerus *radius *wrist *femur *tibia *foot *toes | root thorax lowerneck head
Motive | L R | *Shoulder *UArm *FArm *Hand *Thigh *Shin *Foot *Toe | Hip Chest Neck Head
Kinect | Left Right | Clavicle* Shoulder* Elbow* Wrist* Hip* Knee* Ankle* Foot* | SpineBase SpineMid Neck Head
SMPL | left right | *_collar *_shoulder *_elbow *_wrist *_hip *_knee *_ankle *_foot | pelvis spine3 neck head
nao_kin | left right | *_clavicle *_shoulder *_elbow *_wrist *_hip *_knee *_ankle *_toe | pelvis chest neck head
"""
ROWS = [[part.split() for part in row.split("|")] for row in PRODUCERS.strip().splitlines()]


def renamed(sides: Sequence[str], limbs: Sequence[str], trunk: Sequence[str]) -> str:
    """Return the wave with the names of a producer, in which ~ is a blank."""
    names = dict(zip(WAVE_TRUNK, trunk, strict=True))
    for own, theirs in zip(("Left", "Right"), sides, strict=True):
        names |= {own + part: limb.replace("*", theirs) for part, limb in zip(WAVE_SIDE, limbs, strict=True)}
    return re.sub(
        r"(ROOT|JOINT) (\S+)\n",
        lambda match: f"{match[1]} {names.get(match[2], 'x' + match[2][::-1]).replace('~', ' ')}\n",
        WAVE,
    )


@pytest.mark.parametrize("row", ROWS, ids=["_".join(row[0]) for row in ROWS])
def test_joints_are_found_by_side_and_part_in_the_names_of_every_producer(tmp_path: Path, row: list[list[str]]) -> None:
    file = tmp_path / "person.bvh"
    file.write_text(renamed(*row[1:]))
    truth = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
    skeleton = nk.imitation.read_skeleton(file)
    assert skeleton.source == "names"
    assert skeleton.notes[0].startswith("joints by names: shoulder ")
    limbs = {
        side + part for side in ("left_", "right_") for part in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")
    }
    assert limbs | {"pelvis", "chest", "neck", "head", "left_toe"} <= skeleton.points.keys()
    for name in skeleton.points.keys() - {"left_hand", "right_hand", "chest", "left_thumb", "right_thumb"}:
        np.testing.assert_allclose(skeleton.points[name], truth.points[name], atol=1e-12, err_msg=name)


def test_a_common_prefix_and_letter_case_do_not_count(tmp_path: Path) -> None:
    file = tmp_path / "person.bvh"
    file.write_text(re.sub(r"(ROOT|JOINT) (\S+)", lambda m: f"{m[1]} Character1_{m[2].upper()}", WAVE))
    assert nk.imitation.read_skeleton(file).names == nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"]).names


@pytest.mark.parametrize(("unit", "metres"), [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("inch", 0.0254)])
def test_the_size_of_the_trunk_tells_the_unit(tmp_path: Path, unit: str, metres: float) -> None:
    def scaled(match: re.Match[str]) -> str:
        return "OFFSET " + " ".join(f"{float(value) * 0.01 / metres:.9g}" for value in match[1].split())

    head, body = re.sub(r"OFFSET ([-. \d]+)", scaled, WAVE).split("MOTION\n")
    label, frame_time, *rows = body.splitlines()
    for k, row in enumerate(rows):
        x, y, z, *angles = row.split()
        rows[k] = " ".join([*(f"{float(value) * 0.01 / metres:.9g}" for value in (x, y, z)), *angles])
    file = tmp_path / "person.bvh"
    file.write_text("\n".join([head + "MOTION", label, frame_time, *rows]))
    truth = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
    skeleton = nk.imitation.read_skeleton(file)
    assert any(f"unit {unit}," in note for note in skeleton.notes)
    np.testing.assert_allclose(skeleton.points["left_toe"], truth.points["left_toe"], atol=1e-6)
    stated = nk.imitation.read_skeleton(file, units="cm")
    np.testing.assert_allclose(stated.points["left_toe"] * metres / 0.01, truth.points["left_toe"], atol=1e-6)


def turned(**angles: tuple[float, float, float]) -> str:
    """Return the hierarchy of the wave with one frame, in which joints have the given angles (z, x, y) [degrees]."""
    head = WAVE.split("MOTION")[0]
    values = ["0 95 0"]
    for joint in re.findall(r"(?:ROOT|JOINT) (\S+)", head):
        values.append(" ".join(map(str, angles.get(joint, (0, 0, 0)))))
    return f"{head}MOTION\nFrames: 1\nFrame Time: 0.05\n{' '.join(values)}\n"


def test_parts_have_the_documented_axes(tmp_path: Path) -> None:
    file = tmp_path / "person.bvh"
    file.write_text(turned())
    rest = nk.imitation.read_skeleton(file)
    for part in ("pelvis", "chest", "head"):
        np.testing.assert_allclose(rest.orientations[part][0], np.eye(3), atol=1e-12)
    # Arms stretched out: from the wrist to the knuckles, and upwards out of the back.
    np.testing.assert_allclose(rest.orientations["left_hand"][0][:, [0, 2]].T, [[0, 1, 0], [0, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(rest.orientations["right_hand"][0][:, [0, 2]].T, [[0, -1, 0], [0, 0, 1]], atol=1e-12)
    # The head turned to the left by 30°, the left palm turned ahead: the thumb points up.
    file.write_text(turned(Head=(0, 0, 30), LeftHand=(0, -90, 0)))
    skeleton = nk.imitation.read_skeleton(file)
    np.testing.assert_allclose(skeleton.orientations["head"][0], nk.rotations.rot_z(np.pi / 6), atol=1e-12)
    np.testing.assert_allclose(skeleton.orientations["left_hand"][0][:, 2], [-1, 0, 0], atol=1e-12)


def test_a_rest_pose_that_does_not_stand_gives_points_and_no_orientations(tmp_path: Path) -> None:
    file = tmp_path / "person.bvh"
    # The legs along the spine, as in LAFAN1, whose bones all lie along x: half a turn of the thighs puts them right.
    text = re.sub(r"OFFSET 0 -(42|7)", r"OFFSET 0 \1", turned(LeftUpLeg=(180, 0, 0), RightUpLeg=(180, 0, 0)))
    file.write_text(text)
    skeleton = nk.imitation.read_skeleton(file)
    assert not skeleton.orientations
    assert skeleton.points["left_knee"][0, 2] < 0.6


def test_the_rest_pose_tells_someone_who_lies_from_a_file_with_z_up(tmp_path: Path) -> None:
    """Both turn the root by 90° in every frame: someone who lies is near zero along y, and anywhere along z."""
    head, body = WAVE.split("MOTION\n")
    label, frame_time, *rows = body.splitlines()
    file = tmp_path / "person.bvh"
    places = {
        "lies": lambda k: f"{30 + k} 12 {200 + k}",
        "stands": lambda k: f"{30 + k} 40 95",
        "stays": lambda k: "0 0 0",
    }
    for name, place in places.items():
        turned_rows = [" ".join([place(k), "0 90 0", *row.split()[6:]]) for k, row in enumerate(rows)]
        file.write_text("\n".join([head + "MOTION", label, frame_time, *turned_rows]))
        skeleton = nk.imitation.read_skeleton(file)
        trunk = np.median(skeleton.points["neck"] - skeleton.points["pelvis"], axis=0)
        assert (abs(trunk[2]) < 0.1) == (name == "lies")
        why = {
            "lies": "y points up, by the rest pose: the person lies along z; up= (--up) says otherwise",
            "stands": "z points up, by the direction of the trunk, not y of the rest pose: the feet are at 0 along it",
            "stays": "z points up, by the direction of the trunk, not y of the rest pose: the root stays where it is",
        }
        assert why[name] in skeleton.notes
        stated = nk.imitation.read_skeleton(file, up="z")
        assert np.median(stated.points["neck"] - stated.points["pelvis"], axis=0)[2] > 0.4


LAST = len(WAVE.splitlines())
FAULTS = {
    "empty": (lambda t: " \n", "empty; expected BVH"),
    "hierarchy cut off": (lambda t: t[: t.index("JOINT Neck")], "line 18: ends where OFFSET is expected"),
    "half of the frames": (lambda t: "\n".join(t.splitlines()[:-30]), "frame 35 is the last one, but 65 frames are"),
    "too many frames": (lambda t: t.replace("Frames: 65", "Frames: 60"), "frame 65 is the last one, but 60 frames"),
    "a word in a row": (lambda t: t.rstrip()[:-1] + "x\n", "expected a finite number"),
    "no braces": (lambda t: t.replace("{", "", 1), "OFFSET, expected { after the name"),
    "no offset": (lambda t: t.replace("OFFSET 0 10 0", "", 1), "ends without OFFSET"),
    "unknown channel": (
        lambda t: t.replace("Zrotation", "Zrotaton", 1),
        "'Zrotaton', expected Zrotation, or another of",
    ),
    "a channel twice": (
        lambda t: t.replace("Zrotation Xrotation", "Xrotation Xrotation", 1),
        "a channel twice in Hips",
    ),
    "unknown word": (lambda t: t.replace("JOINT", "JOIN", 1), "'JOIN', expected JOINT, or another of"),
    "a joint twice": (lambda t: t.replace("LeftArm", "RightArm"), "a second joint 'RightArm'"),
    "a second root": (lambda t: t.replace("MOTION", "ROOT Other\n{\n}\nMOTION"), "'ROOT', expected MOTION"),
    "no frame time": (
        lambda t: t.replace("Frame Time: 0.050000", "Frame Time: 0"),
        "frame time is 0, expected more than",
    ),
    "a frame in 17 minutes": (
        lambda t: t.replace("Frame Time: 0.050000", "Frame Time: 1e3"),
        "0.001 frames per second, expected 1 to 1000; rate= (--rate)",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_malformed_file_is_refused_with_its_place(tmp_path: Path, fault: str) -> None:
    change, expected = FAULTS[fault]
    file = tmp_path / "bad.bvh"
    file.write_text(change(WAVE))
    with pytest.raises(nk.errors.BadInputFile, match=re.escape(expected)) as caught:
        nk.imitation.read_skeleton(file)
    assert str(file) in str(caught.value)
    if fault not in ("empty", "a frame in 17 minutes"):
        assert caught.value.line > 0


def test_errors_name_line_and_column(tmp_path: Path) -> None:
    file = tmp_path / "bad.bvh"
    lines = WAVE.splitlines()
    row = lines[-3].split()
    lines[-3] = " ".join([*row[:7], "12,5", *row[8:]])
    file.write_text("\n".join(lines))
    with pytest.raises(nk.errors.BadInputFile) as caught:
        nk.imitation.read_skeleton(file)
    assert (caught.value.line, caught.value.column) == (LAST - 2, len(" ".join(row[:7])) + 2)
    file.write_text(WAVE.replace("Xposition", "Aposition"))
    with pytest.raises(nk.errors.BadInputFile) as caught:
        nk.imitation.read_skeleton(file)
    assert (caught.value.line, caught.value.column) == (5, WAVE.splitlines()[4].index("Xposition") + 1)


def test_every_cut_of_a_file_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "cut.bvh"
    data = "\n".join(WAVE.replace("Frames: 65", "Frames: 2").splitlines()[:-63]).encode()
    file.write_bytes(data)
    assert len(nk.imitation.read_skeleton(file)) == 2
    for end in range(0, len(data) - 4, 31):
        file.write_bytes(data[:end])
        with pytest.raises(nk.errors.BadInputFile):
            nk.imitation.read_skeleton(file)


def test_ends_may_have_numbers_and_names(tmp_path: Path) -> None:
    file = tmp_path / "person.bvh"
    truth = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
    for end in ("End Site-7", "End Site left tip", "end site"):
        file.write_text(WAVE.replace("End Site", end))
        found = nk.imitation.read_skeleton(file)
        np.testing.assert_allclose(found.points["left_toe"], truth.points["left_toe"], atol=1e-12)
    file.write_text(WAVE.replace("End Site", "End Sight", 1))
    with pytest.raises(nk.errors.BadInputFile, match="'Sight', expected Site") as caught:
        nk.imitation.read_skeleton(file)
    assert caught.value.line == WAVE[: WAVE.index("End Site")].count("\n") + 1


def test_joints_that_are_missing_are_noted_or_refused(tmp_path: Path) -> None:
    file = tmp_path / "person.bvh"
    file.write_text(WAVE.replace("Hand", "Klaue"))
    assert "no left_wrist, right_wrist: forearms keep StandInit" in nk.imitation.read_skeleton(file).notes
    for words, what in (
        (("Shoulder", "Arm", "Hand"), "no arms: no left_shoulder and no right_shoulder under a known name"),
        (("Shoulder", "Arm"), "under a known name"),
    ):
        text = WAVE
        for word in words:
            text = text.replace(word, "Vorn" + word[0])
        file.write_text(text)
        with pytest.raises(nk.errors.BadInputFile, match=what):
            nk.imitation.read_skeleton(file)
        file.write_text(text.replace("Spine1", "Tail1"))
        with pytest.raises(nk.errors.BadInputFile, match=r"an animal's \(Tail1\): no left_shoulder"):
            nk.imitation.read_skeleton(file)


def test_deep_hierarchies_need_no_recursion(tmp_path: Path) -> None:
    depth = 1500
    joints = "".join(f"JOINT a{k} {{ OFFSET 0 1 0 CHANNELS 1 Xrotation\n" for k in range(depth))
    text = f"HIERARCHY ROOT r {{ OFFSET 0 0 0 CHANNELS 0\n{joints}{'}' * depth}}}\nMOTION\nFrames: 1\nFrame Time: 1\n"
    file = tmp_path / "deep.bvh"
    file.write_text(text + "0 " * depth)
    with pytest.raises(nk.errors.BadInputFile, match="no left_shoulder"):
        nk.imitation.read_skeleton(file)


def test_names_of_ones_own(tmp_path: Path) -> None:
    file = tmp_path / "person.bvh"
    file.write_text(WAVE.replace("LeftArm", "upper arm 1").replace("RightArm", "upper arm 2"))
    bends = "LeftShoulder, found for left_shoulder, bends at upper arm 1 before the elbow; .*left_shoulder=upper arm 1"
    with pytest.raises(nk.errors.BadInputFile, match=bends):
        nk.imitation.read_skeleton(file)
    names = {"left_shoulder": "Upper Arm 1", "right_shoulder": "upper arm 2", "neck": "Neck + Head"}
    skeleton = nk.imitation.read_skeleton(file, names=names)
    truth = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
    np.testing.assert_allclose(skeleton.points["left_shoulder"], truth.points["left_shoulder"])
    np.testing.assert_allclose(skeleton.points["neck"], (truth.points["neck"] + truth.points["head"]) / 2.0)
    with pytest.raises(nk.errors.UnknownName, match=r"unknown point 'left_sholder' \(nearest: left_shoulder"):
        nk.imitation.read_skeleton(file, names={"left_sholder": "upper arm 1"})
    with pytest.raises(nk.errors.UnknownName, match=r"unknown joint for left_shoulder 'upper arm 3' \(nearest: upper"):
        nk.imitation.read_skeleton(file, names={"left_shoulder": "upper arm 3"})
    with pytest.raises(nk.errors.UnknownName, match=r"unknown source 'mediapip' \(nearest: mediapipe"):
        nk.imitation.read_skeleton(file, source="mediapip")
