"""Files as sensors, estimators and motion capture write them, made from one person: all give this person back."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from people import ORDERS, OTHERS_OF_SMPL, array_of, both, pairs, person

import nao_kin as nk
from nao_kin.imitation.layouts import LAYOUTS

Floats = NDArray[np.float64]
FRAMES, RATE = 12, 30.0
PERSON = {name: places[20 : 20 + FRAMES] for name, places in person(np.random.default_rng(2), turning=1.0).items()}
TIMES = np.arange(FRAMES) / RATE
ARMS = both("shoulder elbow wrist")
LIMBS = [*ARMS, *both("hip knee ankle")]


def points_in(source: str, order: list[str] | None = None, unit: float = 1.0) -> Floats:
    """Return the points in the order and axes of a source, shape (n, k, 3)."""
    return array_of(PERSON, order or ORDERS[source], source) / unit


def with_state(points: Floats, state: float) -> Floats:
    return np.concatenate([points, np.full((*points.shape[:2], 1), state)], axis=-1)


def lines(rows: Any, sign: str = " ") -> str:
    return "\n".join(sign.join(f"{value:.9g}" for value in np.ravel(row)) for row in rows) + "\n"


def ntu() -> str:
    """Two bodies in a frame; the second one, which is there in half of the frames, is somewhere else."""
    text = [str(FRAMES)]
    for k, frame in enumerate(points_in("kinect_v2")):
        bodies = [frame] if k % 2 else [frame + 1.0, frame]
        text.append(str(len(bodies)))
        for body, joints in enumerate(bodies):
            text += [f"{72057594037944738 + len(bodies) - 1 - body} 0 1 1 1 1 0 0.01 -0.25 2", "25"]
            text += [lines([joint]).strip() + " 254.6 170.0 1031.2 477.3 0.2 0.04 0.97 -0.01 2" for joint in joints]
    return "\n".join(text) + "\n"


def cad60() -> str:
    """Eleven joints with an orientation before their place, and four without."""
    rows = []
    for k, frame in enumerate(points_in("cad60", unit=0.001)):
        joints = [
            [*np.eye(3).ravel(), 1.0, *place, 1.0] if at < 11 else [*place, 1.0] for at, place in enumerate(frame)
        ]
        rows.append(f"{k + 1}," + ",".join(f"{value:.9g}" for joint in joints for value in joint) + ",")
    return "\n".join([*rows, "END"][:-1]) + "\n"


def daily_activity() -> str:
    """Each joint has a row with its place, and one with that in the image."""
    text = f"{FRAMES} 20\n"
    for frame in points_in("kinect_v1"):
        image = np.column_stack([frame[:, :2] * 100.0 + 200.0, 1000.0 * frame[:, 2], np.ones(20)])
        both_rows = np.stack([np.column_stack([frame, np.ones(20)]), image], axis=1)
        text += "40\n" + lines(both_rows.reshape(40, 4))
    return text


def named_table(source: str, ends: str, *states: Any, unit: float = 1.0, sign: str = ",") -> str:
    """A column of times, then columns such as Head_X, of which the last ones are a state, the same in all frames."""
    names = LAYOUTS[source].orders[0]
    heads = [f"{name}{end}" for name in names for end in ends.split()]
    rows = [
        sign.join([f"{t:.9g}", *(f"{value}" for joint in frame for value in [*joint, *states])])
        for t, frame in zip(TIMES, points_in(source, unit=unit), strict=True)
    ]
    return "\n".join([sign.join(["time", *heads]), *rows]) + "\n"


def mediapipe_rows(first: int | None) -> str:
    """Columns x1, y1, z1, v1 …; or the headings 0 … 131 of a table that pandas wrote."""
    table = with_state(points_in("mediapipe"), 0.9).reshape(FRAMES, -1)
    heads = map(str, range(132)) if first is None else (f"{what}{k + first}" for k in range(33) for what in "xyzv")
    return ",".join(heads) + "\n" + lines(table, ",")


def objects(points: Floats, names: list[str] | None = None) -> list[list[dict[str, Any]]]:
    """Return frames of points as objects with x, y, z and visibility, and perhaps a name."""
    return [
        [
            dict(
                zip("xyz", map(float, place), strict=True), **({"visibility": 0.9} if names is None else {"score": 0.9})
            )
            | ({} if names is None else {"name": names[k]})
            for k, place in enumerate(frame)
        ]
        for frame in points
    ]


MEDIAPIPE = objects(points_in("mediapipe"))
IMAGE = [[{"x": 0.5, "y": 0.5, "z": 0.0}] * 33] * FRAMES
STAMPS = TIMES.tolist()
AZURE = points_in("azure_kinect", unit=0.001).tolist()
STAMPED = [*zip(STAMPS, MEDIAPIPE, strict=True)]
HOLISTIC = [{"frame_index": 0, "poseLandmarks": IMAGE[0], "poseWorldLandmarks": frame} for frame in MEDIAPIPE]
TASKS = [{"timestampMs": 1e3 * t, "landmarks": [IMAGE[0]], "worldLandmarks": [frame]} for t, frame in STAMPED]
WORLD = [{"time": t, "pose_world_landmarks": {"landmark": frame}} for t, frame in STAMPED]
NAMED = objects(points_in("mediapipe"), list(LAYOUTS["mediapipe"].orders[0]))
JSON: dict[str, tuple[Any, str]] = {
    "landmarks, times": ({"times": STAMPS, "landmarks": MEDIAPIPE}, "mediapipe"),
    "landmarks, timestamps": ({"timestamps": [1e3 * t for t in STAMPS], "landmarks": MEDIAPIPE}, "mediapipe"),
    "landmarks, fps": ({"fps": RATE, "landmarks": MEDIAPIPE}, "mediapipe"),
    "frames of a solution": ({"frames": [{"timestamp": t, "landmarks": own} for t, own in STAMPED]}, "mediapipe"),
    "holistic": ({"frames": HOLISTIC, "fps": RATE}, "mediapipe"),
    "tasks-vision": (TASKS, "mediapipe"),
    "pose_world_landmarks": (
        [{"time": t, "pose_world_landmarks": {"landmark": own}} for t, own in STAMPED],
        "mediapipe",
    ),
    "a list of frames": (points_in("mediapipe").tolist(), "mediapipe"),
    "TensorFlow.js": ([[{"score": 0.9, "keypoints": IMAGE[0], "keypoints3D": own}] for own in NAMED], "mediapipe"),
    "Azure Kinect, JSON": (
        {
            "frames": [
                {
                    "timestamp_usec": round(1e6 * t),
                    "num_bodies": 1,
                    "bodies": [{"body_id": 1, "joint_positions": frame}],
                }
                for t, frame in zip(STAMPS, AZURE, strict=True)
            ]
        },
        "azure_kinect",
    ),
    "names of joints": (
        [
            {
                "time": t,
                "joints": {
                    name: dict(zip("xyz", map(float, PERSON[name][k][[1, 2, 0]]), strict=True))
                    for name in LIMBS[:: 1 - 2 * (k % 2)]  # in another order in every other frame
                    if (k, name) != (5, "left_wrist")
                },
            }
            for k, t in enumerate(STAMPS)
        ],
        "coco17",
    ),
}


def openpose(order: list[str], easy: bool = False) -> Callable[[Path], Path]:
    """Return what writes a folder with a JSON file for each frame, without a person in one of them."""

    def write(folder: Path) -> Path:
        (folder / "json").mkdir()
        for k, frame in enumerate(with_state(points_in("body25", order), 0.8)):
            keypoints = {"pose_keypoints_2d": [1.0] * 3, "pose_keypoints_3d": frame.ravel().tolist()}
            people: list[Any] = [{"person_id": [-1], **keypoints}] if k != 3 else []
            document: Any = {"version": 1.3, "people": people}
            if easy:
                document = [{"id": 0, "keypoints3d": frame.tolist()}]
            (folder / "json" / f"take_{k:09d}_keypoints.json").write_text(json.dumps(document))
        return folder / "json"

    return write


def motive() -> str:
    """Rotations and positions of bones in metres, as Motive 2 exports them, with an empty cell."""
    names = {"shoulder": "UArm", "elbow": "FArm", "wrist": "Hand", "hip": "Thigh", "knee": "Shin", "ankle": "Foot"}
    bones = [
        ("pelvis", "Hip"),
        ("neck", "Neck"),
        *((f"{s}_{p}", f"{s[0].upper()}{n}") for s in ("left", "right") for p, n in names.items()),
    ]
    columns = [("Rotation", axis) for axis in "XYZW"] + [("Position", axis) for axis in "XYZ"]
    head = [
        "Format Version,1.23,Take Name,wave,Capture Frame Rate,30.000000,Export Frame Rate,30.000000,"
        f"Total Frames in Take,{FRAMES},Rotation Type,Quaternion,Length Units,Meters,Coordinate Space,Global",
        "",
        ",Type" + ",Bone" * 7 * len(bones) + ",Bone Marker" * 3,
        ",Name" + "".join(f",Ann:{name}" * 7 for _, name in bones) + ",Ann:LUArm" * 3,
        ",ID" + ",1" * 7 * len(bones) + ",2" * 3,
        ",," + ",".join([kind for _ in bones for kind, _ in columns] + ["Position"] * 3),
        "Frame,Time (Seconds)," + ",".join([axis for _ in bones for _, axis in columns] + [*"XYZ"]),
    ]
    rows = []
    for k, t in enumerate(TIMES):
        cells = [f"0,0,0,1,{y:.9g},{z:.9g},{x:.9g}" for x, y, z in (PERSON[name][k] for name, _ in bones)]
        rows.append(f"{k},{t:.6f}," + ",".join(cells) + ",9,9,9")
    rows[4] = rows[4].replace(rows[4].split(",")[6], "", 1)
    return "\n".join([*head, *rows]) + "\n"


def trc() -> str:
    """Markers of a triangulation in millimetres, with names of BODY_25."""
    names = dict(zip(LAYOUTS["body25"].orders[0], ORDERS["body25"], strict=True))
    head = [
        "PathFileType\t4\t(X/Y/Z)\ttake.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"30\t30\t{FRAMES}\t{len(names)}\tmm\t30\t1\t{FRAMES}",
        "Frame#\tTime\t" + "\t\t\t".join(names),
        "\t\t" + "\t".join(f"{axis}{k + 1}" for k in range(len(names)) for axis in "XYZ"),
    ]
    rows = [
        f"{k + 1}\t{t:.6f}\t" + lines([frame], "\t")
        for k, (t, frame) in enumerate(zip(TIMES, points_in("body25", unit=0.001), strict=True))
    ]
    return "\n".join(head) + "\n\n" + "".join(rows)


@dataclass(frozen=True)
class Case:
    """A file of a format: its content, or what writes it, and what must be found in it."""

    source: str
    file: str
    content: str | Floats | Callable[[Path], Path]
    timed: bool = True
    note: str = ""


V2 = with_state(points_in("kinect_v2"), 2.0).reshape(FRAMES, -1)
TICKS = [f"{89810293609 + round(1e7 * t)}," for t in TIMES]
MSR = with_state(points_in("msr"), 1.0)
NUMBERED = np.column_stack([100 + np.arange(FRAMES), points_in("kinect_v1").reshape(FRAMES, -1)])
NITE = with_state(points_in("nite", unit=0.001), 1.0)
SMPL = {count: points_in("smpl", order) for count, order in OTHERS_OF_SMPL.items()}
CASES = {
    "NTU": Case("kinect_v2", "a.skeleton", ntu(), note="2 people: the one in most frames"),
    "MSR Action3D": Case("msr", "a.txt", lines(MSR.reshape(-1, 4)), timed=False, note="15 frames per second"),
    "MSR Daily Activity": Case("kinect_v1", "a.txt", daily_activity(), note="30 frames per second as of kinect_v1"),
    "UTKinect": Case("kinect_v1", "joints.txt", lines(NUMBERED), note="frames are numbered"),
    "KARD": Case("kard", "realworld.txt", lines(points_in("kard", unit=0.001).reshape(-1, 3)), note="face the sensor"),
    "NiTE": Case("nite", "nite.csv", lines(NITE, ",")),
    "NiTE, x the other way": Case("nite", "nite.csv", lines(points_in("nite") * (-1, 1, 1), ",")),
    "CAD-60": Case("cad60", "cad.txt", cad60(), note="frames are numbered"),
    "Kinect v2 without header": Case(
        "kinect_v2", "j.csv", "".join(map(str.__add__, TICKS, lines(V2, ",").splitlines(True))), note="ticks of 100 ns"
    ),
    "Kinect v2": Case("kinect_v2", "k.csv", named_table("kinect_v2", "_X _Y _Z _TrackingState", 2)),
    "Kinect v2, words": Case("kinect_v2", "k.csv", named_table("kinect_v2", ".X .Y .Z .State", "Tracked")),
    "Kinect v2, Conf": Case("kinect_v2", "k.csv", named_table("kinect_v2", "_X _Y _Z _Conf", 2)),
    "Kinect v2, inferred": Case("kinect_v2", "k.csv", named_table("kinect_v2", "_x _y _z _inferred", "False")),
    "Azure Kinect": Case(
        "azure_kinect", "a.csv", named_table("azure_kinect", "_x _y _z _confidence", 3, unit=0.001, sign=";")
    ),
    "OpenPose BODY_25": Case("body25", "", openpose(ORDERS["body25"]), timed=False),
    "OpenPose COCO-18": Case("coco18", "", openpose(ORDERS["coco18"]), timed=False),
    "EasyMocap": Case("body25", "", openpose(ORDERS["body25"], easy=True), timed=False),
    "HumanML3D": Case("smpl", "012314.npy", SMPL[22], timed=False),
    "MDM": Case("smpl", "motion.npy", np.moveaxis(SMPL[22], 0, 2), timed=False, note="(points, 3, frames)"),
    "SMPL-X, flat": Case("smpl", "x.npy", SMPL[55].reshape(FRAMES, -1), timed=False),
    "MediaPipe, x1": Case("mediapipe", "coords.csv", mediapipe_rows(1), timed=False),
    "MediaPipe, x0": Case("mediapipe", "coords.csv", mediapipe_rows(0), timed=False),
    "MediaPipe, 0 … 131": Case("mediapipe", "coords.csv", mediapipe_rows(None), timed=False),
    "MediaPipe, names": Case("mediapipe", "m.csv", named_table("mediapipe", "_x _y _z _visibility", 0.9)),
    "Motive": Case("names", "take.csv", motive()),
    "TRC": Case("body25", "take.trc", trc()),
    **{
        label: Case(source, "pose.json", json.dumps(document), timed=label not in ("a list of frames", "TensorFlow.js"))
        for label, (document, source) in JSON.items()
    },
}


def read(folder: Path, case: Case, **options: Any) -> nk.imitation.Skeleton:
    """Write the file of a case, and read it."""
    file = folder / case.file
    if callable(case.content):
        file = case.content(folder)
    elif isinstance(case.content, str):
        file.write_text(case.content, encoding="utf-8")
    else:
        np.save(file, case.content)
    return nk.imitation.read_skeleton(file, **options)


def check(found: nk.imitation.Skeleton, points: Sequence[str] = LIMBS, atol: float = 2e-6) -> None:
    """Compare places about the left hip with those of the person."""
    for name in points:
        own = found.points[name] - found.points["left_hip"]
        seen = np.isfinite(own).all(axis=1)
        assert np.count_nonzero(seen) >= FRAMES - 1
        np.testing.assert_allclose(own[seen], (PERSON[name] - PERSON["left_hip"])[seen], atol=atol, err_msg=name)


@pytest.mark.parametrize("label", CASES)
def test_a_person_is_read_from_every_format(tmp_path: Path, label: str) -> None:
    case = CASES[label]
    found = read(tmp_path, case, rate=None if case.timed or case.note.startswith("15") else RATE)
    assert found.source == case.source
    assert not any("mirrored" in note or "are these" in note for note in found.notes), found.notes
    assert any(case.note in note for note in found.notes)
    stamps = TIMES * 2.0 if case.note.startswith("15") else TIMES
    np.testing.assert_allclose(found.times - found.times[0], stamps, atol=1e-6)
    check(found)
    for name in ("nose", "left_ear", "left_toe", "right_toe"):
        if name in found.points and name in ORDERS.get(case.source, ()):
            check(found, (name,))


def test_confidence_is_read_in_every_form(tmp_path: Path) -> None:
    for label, sure in {
        "NTU": 1.0,
        "Kinect v2": 1.0,
        "Kinect v2, words": 1.0,
        "Kinect v2, Conf": 1.0,
        "Kinect v2, inferred": 1.0,
        "Azure Kinect": 1.0,
        "MediaPipe, names": 0.9,
        "tasks-vision": 0.9,
        "TensorFlow.js": 0.9,
        "OpenPose BODY_25": 0.8,
    }.items():
        (tmp_path / label[:3]).mkdir(exist_ok=True)
        found = read(tmp_path / label[:3], CASES[label], rate=RATE)
        assert np.median(found.confidence["left_wrist"]) == pytest.approx(sure), label
    inferred = CASES["Kinect v2, inferred"]
    text = str(inferred.content).replace("False", "True")
    (tmp_path / "inferred.csv").write_text(text)
    assert nk.imitation.read_skeleton(tmp_path / "inferred.csv").confidence["left_wrist"].tolist() == [0.5] * FRAMES


@pytest.mark.filterwarnings("ignore:No analog data")
def test_markers_of_plug_in_gait_stand_for_joints(tmp_path: Path) -> None:
    """The hip is between its front and its back marker, the wrist between both sides of it."""
    c3d = pytest.importorskip("c3d")
    places = {}
    for side, s in (("left", "L"), ("right", "R")):
        for part, label in (("shoulder", "SHO"), ("elbow", "ELB"), ("knee", "KNE"), ("ankle", "ANK"), ("toe", "TOE")):
            places[s + label] = PERSON[f"{side}_{part}"]
        for part, labels, apart in (
            ("wrist", ("WRA", "WRB"), (0.0, 0.0, 0.03)),
            ("hip", ("ASI", "PSI"), (0.1, 0.0, 0.0)),
        ):
            for label, sign in zip(labels, (1.0, -1.0), strict=True):
                places[s + label] = PERSON[f"{side}_{part}"] + sign * np.array(apart)
    writer = c3d.Writer(point_rate=RATE)
    writer.set_point_labels([f"Ann:{label}" for label in places])
    for k in range(FRAMES):
        rows = np.zeros((len(places), 5), dtype=np.float32)
        rows[:, :3] = [1000.0 * place[k] for place in places.values()]
        if k == 2:
            rows[[*places].index("LELB"), 3] = -1.0
        writer.add_frames([(rows, np.zeros((0, 0)))])
    with (tmp_path / "gait.c3d").open("wb") as file:
        writer.write(file)
    found = nk.imitation.read_skeleton(tmp_path / "gait.c3d", up="z", units="mm")
    assert np.isnan(found.points["left_elbow"][2]).all()
    assert any("markers on the skin" in note for note in found.notes)
    check(found, atol=1e-4)


OTHER_FILES = {
    "walk.fbx": (b"Kaydara FBX Binary  \x00\x1a\x00" + bytes(50), r"an FBX file: import it in Blender, .*\.bvh"),
    "walk2.fbx": (b"; FBX 7.4.0 project file\n", r"an FBX file: import it in Blender"),
    "walk.glb": (b"glTF\x02\x00", r"a glTF file: import it in Blender"),
    "walk.pkl": (b"\x80\x04\x95", "a pickle, which would run code"),
    "walk.mat": (b"MATLAB 5.0 MAT-file", "numpy.savez"),
    "walk.mp4": (b"\x00\x00\x00\x20ftypisom", "a video: examples/webcam.py"),
    "walk.amc": (b"#!OML:ASF H:\\\n:FULLY-SPECIFIED", "Acclaim: convert both together to BVH"),
    "walk.trc": (b"PathFileType\t4\t(X/Y/Z)\tw.trc\nDataRate\n100\n", "no row Frame#, Time and names"),
    "take.csv": (b"Format Version,1.23,Take Name,a\n,Type\n", r"no row Frame, Time \(Seconds\)"),
    "box.csv": (
        b"Format Version,1.23\n,Type,Rigid Body\n,Name,Box\n,,Position\nFrame,Time (Seconds),X\n0,0,1\n",
        "no positions of bones or markers of a person; types: Rigid Body",
    ),
    "short.skeleton": (
        b"2\n1\n" + b"1 2 3 4 5 6 7 8 9 10\n25\n" + b"1 2 3 4 5 6 7 8 9 10 11 12\n" * 7,
        "line 12: the end of",
    ),
    "2d.json": (json.dumps([{"people": [{"pose_keypoints_2d": [1, 2, 3] * 25}]}]).encode(), "pose_keypoints_2d alone"),
    "odd.txt": (b"1 2 3 4\n1 2 3\n", "line 2: 3 numbers, the first row has 4"),
    "word.txt": (b"1 2 3 4\n1 2 a 4\n", "line 2, column 3: 'a', expected a number"),
    "few.txt": (b"1 2\n3 4\n", "rows of fewer than 3 numbers"),
    "many.txt": (lines(np.zeros((2, 50))).encode(), "2 rows of 50 numbers without headings: no source has so many"),
    "vecs.txt": (lines(np.zeros((2, 263))).encode(), "features of HumanML3D, whose folder new_joints"),
    "damaged.c3d": (b"\x02\x50" + bytes(600), "not a readable C3D file|needs"),
}


@pytest.mark.parametrize("name", OTHER_FILES)
def test_files_that_are_not_read_are_called_by_their_names(tmp_path: Path, name: str) -> None:
    data, what = OTHER_FILES[name]
    (tmp_path / name).write_bytes(data)
    with pytest.raises((nk.errors.BadInputFile, nk.errors.MissingExtra), match=what):
        nk.imitation.read_skeleton(tmp_path / name)


def test_a_folder_without_frames_is_refused(tmp_path: Path) -> None:
    with pytest.raises(nk.errors.BadInputFile, match="a folder without JSON files"):
        nk.imitation.read_skeleton(tmp_path)


def test_places_in_an_image_are_noted(tmp_path: Path) -> None:
    """As in the skeletons of MSR Action3D that have pixels and depths: y points down."""
    (tmp_path / "image.txt").write_text(lines((MSR * (100.0, -100.0, 100.0, 1.0)).reshape(-1, 4)))
    notes = nk.imitation.read_skeleton(tmp_path / "image.txt").notes
    assert any(note.startswith("upside down in the axes of msr") for note in notes)


def test_several_people_are_noted(tmp_path: Path) -> None:
    frames = [[frame, frame] for frame in MEDIAPIPE]
    (tmp_path / "two.json").write_text(
        json.dumps({"fps": RATE, "frames": [{"landmarks": people} for people in frames]})
    )
    notes = nk.imitation.read_skeleton(tmp_path / "two.json").notes
    assert "several people: the first one of each frame is taken" in notes


def test_pairs_of_sides_are_those_of_the_sensor() -> None:
    """Toes and the right arms of MSR Action3D's actions show the sides; most lists of its joints have the opposite."""
    order = LAYOUTS["msr"].orders[0]
    assert [order[k] for k in (0, 7, 9, 11)] == ["LeftShoulder", "LeftElbow", "LeftWrist", "LeftHand"]
    assert pairs("shoulder") == ORDERS["msr"][:2]
