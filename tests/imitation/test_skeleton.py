"""Points of every source in the documented axes and units; AMASS by its rotations; what is no skeleton."""

from __future__ import annotations

import itertools
import json
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loops import every_value
from numpy.typing import NDArray
from people import ORDERS, array_of, pairs, person as made_up
from scipy.spatial.transform import Rotation

import nao_kin as nk
from nao_kin.imitation.layouts import LAYOUTS
from nao_kin.imitation.skeleton import left_and_trunk

Floats = NDArray[np.float64]
BOW = nk.imitation.SAMPLES["bow"]
RATE = 25.0

SMPL_PARENTS = (-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21)


@pytest.fixture(scope="module")
def person() -> dict[str, Floats]:
    """A person who walks and turns, with z up [m]."""
    return {name: values[::9].copy() for name, values in made_up(np.random.default_rng(0), turning=1.0).items()}


def array_in(person: dict[str, Floats], source: str) -> Floats:
    return array_of(person, ORDERS[source], source)


def times(count: int) -> Floats:
    return np.arange(count) / RATE


def cube() -> list[Floats]:
    return [R.as_matrix() for R in Rotation.create_group("O")]


def check_upright(found: nk.imitation.Skeleton, truth: dict[str, Floats]) -> None:
    """Compare points, but for the heading."""
    names = found.points.keys() & truth.keys() - {"left_hand", "right_hand", "left_eye", "right_eye", "chest", "neck"}
    own, other = (
        np.concatenate([points[name] - points["left_hip"][0] for name in sorted(names)])
        for points in (found.points, truth)
    )
    turn, distance = Rotation.align_vectors(own, other)
    assert distance < 1e-5
    assert turn.as_matrix()[2, 2] == pytest.approx(1.0)


@pytest.mark.parametrize(("source", "form"), every_value(["coco17", "h36m17"], ["npy", "npz", "json"]))
def test_coco_and_human36m_in_any_axes(tmp_path: Path, person: dict[str, Floats], source: str, form: str) -> None:
    array = array_in(person, source)
    n, file = len(array), tmp_path / f"pose.{form}"
    for R in Rotation.create_group("O").as_matrix():
        given = (array @ R.T) * 1000.0
        if form == "npy":
            np.save(file, given)
        elif form == "npz":
            np.savez(file, keypoints=given, times=times(n), other=np.zeros(3))
        else:
            file.write_text(json.dumps({"times": times(n).tolist(), "landmarks": given.tolist()}))
        skeleton = nk.imitation.read_skeleton(file, source=source, rate=RATE if form == "npy" else None)
        np.testing.assert_allclose(skeleton.times, times(n))
        assert "unit mm" in skeleton.notes[-1]
        check_upright(skeleton, person)


def test_the_axis_that_points_up_may_be_stated(person: dict[str, Floats]) -> None:
    array = np.stack([person[name] for name in ORDERS["h36m17"]], axis=1)[:1]
    lying = array @ nk.rotations.rot_y(np.pi / 2).T
    found = nk.imitation.Skeleton.from_landmarks(lying, "h36m17")
    stated = nk.imitation.Skeleton.from_landmarks(lying, "h36m17", up="z", units="m")
    assert np.ptp(found.points["head"] - found.points["pelvis"], axis=-1)[0] > 0.5
    np.testing.assert_allclose(stated.points["head"], lying[:, ORDERS["h36m17"].index("head")])
    with pytest.raises(nk.errors.UnknownName, match="unknown axis 'up'"):
        nk.imitation.Skeleton.from_landmarks(lying, "h36m17", up="up")
    with pytest.raises(nk.errors.UnknownName, match="unknown unit 'metre'"):
        nk.imitation.Skeleton.from_landmarks(lying, "h36m17", units="metre")


@pytest.mark.parametrize("columns", [66, 72, 156, 165])
def test_amass_turns_the_bones_of_smpl(tmp_path: Path, columns: int) -> None:
    rng = np.random.default_rng(columns)
    n, file = 5, tmp_path / "amass.npz"
    upright = Rotation.from_rotvec([np.pi / 2, 0.0, 0.0])  # SMPL has y up, AMASS z
    poses = np.zeros((n, columns))
    poses[:, :3] = upright.as_rotvec()
    trans = rng.normal(size=(n, 3))
    np.savez(file, poses=poses, trans=trans, mocap_framerate=np.array(120.0), betas=np.zeros(16), gender="neutral")
    rest = nk.imitation.read_skeleton(file)
    np.testing.assert_allclose(rest.times, np.arange(n) / 120.0)
    for part in ("pelvis", "head"):
        R = rest.orientations[part][0]
        np.testing.assert_allclose(R[:, 2], [0, 0, 1], atol=1e-12)
        feet = (rest.points["left_toe"] - rest.points["left_ankle"])[0]
        assert R[:, 0] @ feet > 0.8 * np.linalg.norm(feet)
    # Arms stretched out to the sides, legs down.
    for side, sign in (("left_", 1.0), ("right_", -1.0)):
        arm = (rest.points[side + "wrist"] - rest.points[side + "shoulder"])[0]
        assert sign * arm @ rest.orientations["pelvis"][0][:, 1] > 0.98 * np.linalg.norm(arm)
        leg = (rest.points[side + "ankle"] - rest.points[side + "hip"])[0]
        assert -leg[2] > 0.98 * np.linalg.norm(leg)
    # All joints turned: bones are those of the rest pose, by SciPy's rotations along the path from the root.
    poses[:, :66] += rng.normal(scale=0.3, size=(n, 66))
    np.savez(file, poses=poses.astype(np.float32), trans=trans, mocap_frame_rate=60)
    moved = nk.imitation.read_skeleton(file, units="m", up="z")
    still = nk.imitation.read_skeleton(_rest_in_source_axes(tmp_path, columns), units="m", up="z")
    joints = {"left_elbow": 18, "right_wrist": 21, "right_hand": 23, "left_toe": 10, "head": 15}
    before = {"left_elbow": "left_shoulder", "right_wrist": "right_elbow", "right_hand": "right_wrist"}
    before |= {"left_toe": "left_ankle", "head": "neck"}
    for name, joint in joints.items():
        R, k = Rotation.identity(n), SMPL_PARENTS[joint]
        while k >= 0:
            own = Rotation.from_rotvec(poses[:, 3 * k : 3 * k + 3]) if k < 22 else Rotation.identity(n)
            R, k = own * R, SMPL_PARENTS[k]
        bone = still.points[name] - still.points[before[name]]
        np.testing.assert_allclose(moved.points[name] - moved.points[before[name]], R.apply(bone[0]), atol=1e-6)
    np.testing.assert_allclose(moved.points["pelvis"], trans, atol=1e-12)


def _rest_in_source_axes(folder: Path, columns: int) -> Path:
    file = folder / "rest.npz"
    np.savez(file, poses=np.zeros((1, columns)), trans=np.zeros((1, 3)), mocap_framerate=1.0)
    return file


@pytest.mark.parametrize("source", ["mediapipe", "coco17", "h36m17"])
def test_mirrored_points_are_found_and_set_right(person: dict[str, Floats], source: str) -> None:
    array = array_in(person, source)
    truth = nk.imitation.Skeleton.from_landmarks(array, source, rate=RATE)
    assert not any("mirrored" in note for note in truth.notes)
    for axis in range(3):
        signs = np.where(np.arange(3) == axis, -1.0, 1.0)
        if axis == 1 and source == "mediapipe":
            continue  # upside down as well
        skeleton = nk.imitation.Skeleton.from_landmarks(
            array * signs, source, rate=RATE, up="-y" if axis == 1 else None
        )
        assert "mirrored: face, toes and knees point backwards" in skeleton.notes[-1]
        check_upright(skeleton, dict(truth.points))


def test_a_person_who_sees_behind_is_not_taken_for_mirrored(person: dict[str, Floats]) -> None:
    """Toes and knees outvote a head that is turned as far as it goes."""
    array = array_in(person, "mediapipe")
    order = LAYOUTS["mediapipe"].orders[0]
    head = array[:, :11] - array[:, 7:9].mean(axis=1, keepdims=True)
    array[:, :11] = head @ nk.rotations.rot_y(np.radians(100.0)).T + array[:, 7:9].mean(axis=1, keepdims=True)
    assert order[10] == "mouth_right"
    assert "mirrored" not in str(nk.imitation.Skeleton.from_landmarks(array, "mediapipe", rate=RATE).notes)


def test_unknown_points_stay_unknown(person: dict[str, Floats]) -> None:
    array = array_in(person, "mediapipe")
    array = np.concatenate([array, np.ones((*array.shape[:2], 1))], axis=-1)
    array[2, 13, :3] = np.nan
    array[3] = np.nan
    skeleton = nk.imitation.Skeleton.from_landmarks(array, "mediapipe", rate=RATE)
    assert np.isnan(skeleton.points["left_elbow"]).all(axis=1).tolist() == [k in (2, 3) for k in range(len(array))]
    assert skeleton.confidence["left_elbow"][3] == 0.0


def test_the_trunk_begins_between_the_hips_or_where_one_is_known(person: dict[str, Floats]) -> None:
    hips = {name: person[name].copy() for name in ("pelvis", "left_hip", "right_hip")}
    middle = (hips["left_hip"] + hips["right_hip"]) / 2.0
    shoulders = (person["left_shoulder"] + person["right_shoulder"]) / 2.0
    hips["right_hip"][1:] = np.nan
    hips["pelvis"][2:] = np.nan
    for names in (("pelvis", "left_hip", "right_hip"), ("left_hip", "right_hip"), ("pelvis",)):
        points = {name: person[name] for name in ("left_shoulder", "right_shoulder")}
        points |= {name: hips[name] for name in names}
        below = shoulders - left_and_trunk(points)[1]
        if len(names) > 1:
            np.testing.assert_allclose(below[0], middle[0])
            np.testing.assert_allclose(below[2:], hips["left_hip"][2:])
        if "pelvis" in names:
            np.testing.assert_allclose(below[1], hips["pelvis"][1])


def test_a_frame_without_a_person_is_unknown(tmp_path: Path) -> None:
    document = json.loads(BOW.read_text(encoding="utf-8"))
    document["landmarks"][4] = None
    document["landmarks"][5] = []
    document["landmarks"][6][0] = [None, None, None, 0]
    file = tmp_path / "bow.json"
    file.write_text(json.dumps(document))
    skeleton = nk.imitation.read_skeleton(file)
    assert np.flatnonzero(np.isnan(skeleton.points["nose"][:, 0])).tolist() == [4, 5, 6]
    assert np.flatnonzero(np.isnan(skeleton.points["left_wrist"][:, 0])).tolist() == [4, 5]
    assert skeleton.confidence["nose"][3:8].tolist() == [1, 0, 0, 0, 1]


def test_one_frame_without_a_shoulder_has_the_usual_unit(person: dict[str, Floats]) -> None:
    array = array_in(person, "mediapipe")[:1]
    truth = nk.imitation.Skeleton.from_landmarks(array, "mediapipe")
    array[0, 11, :3] = np.nan
    skeleton = nk.imitation.Skeleton.from_landmarks(array, "mediapipe")
    assert skeleton.notes == ("unit m, as usual",)
    np.testing.assert_array_equal(skeleton.points["left_wrist"], truth.points["left_wrist"])
    coco = array_in(person, "coco17")[:1]
    coco[0, 5] = np.nan
    with pytest.raises(nk.errors.DegeneratePoints, match="no frame has shoulders and hips, which show the axis"):
        nk.imitation.Skeleton.from_landmarks(coco, "coco17")
    with pytest.raises(nk.errors.DegeneratePoints, match="no frame has shoulders and hips that differ"):
        nk.imitation.Skeleton.from_landmarks(coco, "coco17", up="z")
    assert nk.imitation.Skeleton.from_landmarks(coco, "coco17", up="z", units="m").names


def test_image_landmarks_are_noted(person: dict[str, Floats]) -> None:
    array = array_in(person, "mediapipe") * 0.25 + 0.5
    assert "pose_landmarks" in nk.imitation.Skeleton.from_landmarks(array, "mediapipe", rate=RATE).notes[-1]


def test_a_skeleton_shares_no_memory_and_cannot_change(person: dict[str, Floats]) -> None:
    person = {name: person[name] for name in nk.imitation.POINTS if name in person}
    stamps = times(len(person["head"]))
    skeleton = nk.imitation.Skeleton(stamps, person)
    stamps += 1.0
    person["head"][0] += 1.0
    assert skeleton.times[0] == 0.0
    assert skeleton.points["head"][0, 2] != person["head"][0, 2]
    person["head"][0] -= 1.0
    with pytest.raises(ValueError, match="read-only"):
        skeleton.points["head"][0] = 0.0
    with pytest.raises(TypeError):
        skeleton.points["head"] = person["head"]  # type: ignore[index]
    assert skeleton.names == tuple(name for name in nk.imitation.POINTS if name in person)
    assert len(skeleton) == len(stamps)


DOCUMENT = json.loads(BOW.read_text(encoding="utf-8"))
BOWING = DOCUMENT["landmarks"]
TINY = [[[*(1e-300 * x for x in p[:3]), 1] for p in frame] for frame in BOWING]
BAD_JSON: dict[str, tuple[dict[str, Any] | str, str]] = {
    "no landmarks": ({"landmarks": 3}, 'expected {"times"'),
    "no frames": ({"landmarks": []}, "0 points: no source has as many"),
    "a word for a coordinate": (
        {"landmarks": [[["a", 0, 0], *frame[1:]] for frame in BOWING]},
        "landmarks[0][0]: expected [x, y, z] or [x, y, z, visibility], got a list of 3",
    ),
    "a list": ("[1, 2]", 'expected {"times"'),
    "malformed": (json.dumps(DOCUMENT)[:-30], "malformed JSON"),
    "times run back": ({"times": [0.0, 0.2, 0.1, *np.arange(3, 31) / 10]}, "must ascend, but 0.1 follows 0.2 (time 2)"),
    "too few times": ({"times": [0.0, 1.0]}, "times must have shape (31,), got (2,)"),
    "no times": ({"times": None}, "31 frames without times; state the frames per second with rate="),
    "a word": ({"times": ["x"] * 31}, "times must be real numbers, got"),
    "17 points": ({"landmarks": [frame[:17] for frame in BOWING]}, "17 points: coco17 or h36m17; state"),
    "one frame of 5": (
        {"landmarks": [BOWING[0][:5], *BOWING[1:]]},
        "landmarks[0] has 5 points, another frame has 33",
    ),
    "two coordinates": (
        {"landmarks": [[entry[:2] for entry in frame] for frame in BOWING]},
        "landmarks[0][0]: expected [x, y, z] or [x, y, z, visibility], got a list of 2; two coordinates give no",
    ),
    "z is 0": (
        {"landmarks": [[[*entry[:2], 0.0] for entry in frame] for frame in BOWING]},
        "z is the same for all points: two-dimensional points give no directions",
    ),
    "all equal": ({"landmarks": [[[1, 2, 3]] * 33] * 31}, "all points are equal, at [1.0, 2.0, 3.0]"),
    "in attometres": ({"landmarks": TINY}, "shoulders and hips coincide"),
    "all unknown": ({"landmarks": [None, *[[[None] * 3] * 33] * 30]}, "no point is known in any frame"),
    "huge": (json.dumps(DOCUMENT).replace("[[[", "[[[1e999,0,0,0],[", 1), "landmarks[0][0]: expected [x, y, z]"),
}


@pytest.mark.parametrize("fault", BAD_JSON)
def test_bad_json_is_refused(tmp_path: Path, fault: str) -> None:
    content, expected = BAD_JSON[fault]
    file = tmp_path / "pose.json"
    file.write_text(content if isinstance(content, str) else json.dumps({**DOCUMENT, **content}))
    with pytest.raises(nk.errors.BadInputFile, match=re.escape(expected)) as caught:
        nk.imitation.read_skeleton(file)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


BAD_CSV = {
    "two coordinates": ("time,left_wrist_x,left_wrist_y\n0,1,2", "only x and y: two coordinates give no directions"),
    "joint angles": ("time,HeadYaw\n0,1", "no columns such as left_wrist_x"),
    "no rows": ("time," + ",".join(f"{side}Shoulder_{c}" for side in "LR" for c in "xyz"), "a header and no rows"),
    "a word": ("time,Head_x,Head_y,Head_z\n0,1,2,a", "line 2, column 4: Head_z is 'a', expected a finite number"),
    "no shoulders": ("time,Head_x,Head_y,Head_z\n0,1,2,3\n1,2,3,4", "no arms: no left_shoulder and no right_shoulder"),
    "units differ": (
        "time,ShoulderLeft_x [mm],ShoulderLeft_y [m],ShoulderLeft_z [m]\n0,1,2,3\n1,3,4,5",
        "columns in different units: m, mm",
    ),
    "twice": ("time,Head_x,Head_x\n0,1,2", "given twice"),
    "no hips": (
        "time," + ",".join(f"{j}_{c}" for j in ("ShoulderLeft", "ShoulderRight", "Head") for c in "xyz") + "\n"
        "0,0,0,0,1,1,1,2,3,4",
        "no left_hip, right_hip or pelvis among the points: left_shoulder, right_shoulder, head, neck",
    ),
    "not a table": ("\0\1\2", "no columns such as left_wrist_x"),
}


@pytest.mark.parametrize("fault", BAD_CSV)
def test_bad_tables_are_refused(tmp_path: Path, fault: str) -> None:
    text, expected = BAD_CSV[fault]
    file = tmp_path / "bodies.csv"
    file.write_text(text)
    with pytest.raises(nk.errors.BadInputFile, match=re.escape(expected)):
        nk.imitation.read_skeleton(file)


def moments(folder: Path, form: str, given: Floats) -> Path:
    """Write the bow with other times."""
    points, file = np.array(BOWING), folder / f"bow.{form}"
    if form == "json":
        file.write_text(json.dumps({"times": given.tolist(), "landmarks": points.tolist()}))
    elif form == "npz":
        np.savez(file, points=points, times=given)
    else:
        heads = ["time", *(f"{what}{k}" for k in range(33) for what in "xyzv")]
        rows = [
            ",".join(map(repr, [t, *frame]))
            for t, frame in zip(given.tolist(), points.reshape(31, -1).tolist(), strict=True)
        ]
        file.write_text("\n".join([",".join(heads), *rows]))
    return file


FORMS = pytest.mark.parametrize("form", ["json", "npz", "csv"])


@FORMS
@pytest.mark.parametrize("since", [0.0, 1.7e9], ids=["since a start", "since 1970"])
@pytest.mark.parametrize(("unit", "per_second"), [("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_units_of_times_follow_one_rule_in_all_forms(
    tmp_path: Path, form: str, since: float, unit: str, per_second: float
) -> None:
    rng = np.random.default_rng(8)
    own = since + 0.1 * np.arange(31) + rng.uniform(-0.01, 0.01, 31)  # of a webcam
    skeleton = nk.imitation.read_skeleton(moments(tmp_path, form, own * per_second))
    np.testing.assert_allclose(np.diff(skeleton.times), np.diff(own), atol=1e-5)
    assert any(f"times are taken as {unit} " in note for note in skeleton.notes) == (unit != "s")


@FORMS
def test_times_that_fit_no_recording_are_refused_or_replaced(tmp_path: Path, form: str) -> None:
    even = 0.1 * np.arange(31)
    late = np.where(even > 0.0, 1.7e9 + even, 0.0)
    for given in (late, np.where(even > 1.5, 1e5 + even, even), 1e-5 * even):
        file = moments(tmp_path, form, given)
        with pytest.raises(nk.errors.BadInputFile, match=r"at most a day|expected 1 to 1000"):
            nk.imitation.read_skeleton(file)
        stated = nk.imitation.read_skeleton(file, rate=10.0)
        np.testing.assert_allclose(stated.times, even, atol=1e-12)


def test_a_small_archive_of_large_arrays_is_not_unpacked(tmp_path: Path) -> None:
    import zipfile

    file = tmp_path / "bomb.npz"
    for name, shape in (("points", (20_000_000, 33, 3)), ("poses", (40_000_000, 66))):
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive, archive.open(f"{name}.npy", "w") as member:
            np.lib.format.write_array_header_1_0(member, {"descr": "<f8", "fortran_order": False, "shape": shape})
            member.write(bytes(1 << 20))
        with pytest.raises(nk.errors.BadInputFile):
            nk.imitation.read_skeleton(file)


def test_a_long_heading_takes_no_longer_than_its_length(tmp_path: Path) -> None:
    file = tmp_path / "long.csv"
    for blank in (" ", "_", "x "):
        file.write_text(f"time,a{blank * 50_000}b\n0,1\n")
        began = time.process_time()
        with pytest.raises(nk.errors.BadInputFile):
            nk.imitation.read_skeleton(file)
        assert time.process_time() - began < 5.0  # it took minutes


def test_a_large_table_without_points_is_refused(tmp_path: Path) -> None:
    """Above 1 MiB, tables are read by another program, which takes no columns for all columns."""
    file = tmp_path / "large.csv"
    file.write_text("a,b\n" + "".join(f"{k},{k}\n" for k in range(100_000)))
    with pytest.raises(nk.errors.BadInputFile, match="no columns such as left_wrist_x"):
        nk.imitation.read_skeleton(file)


BAD_ARRAYS: dict[str, tuple[dict[str, Any], str]] = {
    "poses too narrow": (
        {"poses": np.zeros((3, 63)), "trans": np.zeros((3, 3))},
        "poses must be finite numbers (n, 66",
    ),
    "trans too short": ({"poses": np.zeros((3, 66)), "trans": np.zeros((2, 3))}, "trans must be finite numbers (3, 3)"),
    "no rate": ({"poses": np.zeros((3, 66)), "trans": np.zeros((3, 3))}, "3 frames without times; state the frames"),
    "rate 0": ({"poses": np.zeros((3, 66)), "mocap_framerate": 0.0}, "rate must be positive, got 0"),
    "no frames": ({"poses": np.zeros((0, 66)), "mocap_framerate": 30.0}, "poses has no frames"),
    "two rates": ({"poses": np.zeros((3, 66)), "mocap_framerate": [30.0, 60.0]}, "mocap_framerate must be one number"),
    "two arrays": ({"a": np.zeros((3, 17, 3)), "b": np.zeros((3, 17, 3))}, "expected one array of points"),
    "pickled": ({"a": np.array([{}], dtype=object)}, "not a readable file of NumPy"),
    "complex": ({"a": np.zeros((3, 33, 3), dtype=complex), "times": np.arange(3)}, "landmarks must be real numbers"),
    "infinite": ({"a": np.full((3, 33, 3), np.inf), "times": np.arange(3)}, "landmarks must be finite"),
    "2-D": ({"a": np.zeros((3, 33, 2)), "times": np.arange(3)}, "two coordinates give no directions, got (3, 33, 2)"),
}


@pytest.mark.parametrize("fault", BAD_ARRAYS)
def test_bad_arrays_are_refused(tmp_path: Path, fault: str) -> None:
    arrays, expected = BAD_ARRAYS[fault]
    file = tmp_path / "poses.npz"
    np.savez(file, **arrays)
    with pytest.raises(nk.errors.BadInputFile, match=re.escape(expected)):
        nk.imitation.read_skeleton(file)
    data = file.read_bytes()
    file.write_bytes(data[: len(data) // 2])
    with pytest.raises(nk.errors.BadInputFile, match="not a readable file of NumPy"):
        nk.imitation.read_skeleton(file)


def test_bad_arguments_are_refused(person: dict[str, Floats], tmp_path: Path) -> None:
    person = {name: person[name] for name in nk.imitation.POINTS if name in person}
    stamps = times(len(person["head"]))
    Skeleton, errors = nk.imitation.Skeleton, nk.errors
    with pytest.raises(errors.UnknownName, match=r"unknown point 'left_wirst' \(nearest: left_wrist"):
        Skeleton(stamps, {**person, "left_wirst": person["head"]})
    with pytest.raises(errors.UnknownName, match="unknown part with an orientation 'nose'"):
        Skeleton(stamps, person, {"nose": np.eye(3)})
    with pytest.raises(errors.BadArgument, match="no right_shoulder among the points"):
        Skeleton(stamps, {name: values for name, values in person.items() if name != "right_shoulder"})
    with pytest.raises(errors.WrongShape, match=r"points of head must have shape \(9, 3\), got \(8, 3\)"):
        Skeleton(stamps, {**person, "head": person["head"][1:]})
    with pytest.raises(errors.WrongShape, match="times must have shape"):
        Skeleton([], {})
    with pytest.raises(errors.UnknownName, match=r"unknown source 'mediapip' \(nearest: mediapipe"):
        Skeleton.from_landmarks(np.zeros((33, 3)), "mediapip")
    with pytest.raises(errors.WrongShape, match=r"landmarks must have shape \(n, 33, 3 or 4\) for mediapipe"):
        Skeleton.from_landmarks(np.zeros((9, 32, 3)), "mediapipe")
    with pytest.raises(errors.BadInputFile, match="cannot be read: No such file"):
        nk.imitation.read_skeleton(tmp_path / "missing.bvh")
    with pytest.raises(errors.BadInputFile, match="names= is for joints with names"):
        nk.imitation.read_skeleton(BOW, names={"head": "nose"})


def test_every_layout_has_the_points_of_arms_and_legs() -> None:
    for layout in LAYOUTS.values():
        for order in layout.orders:
            needed = {*pairs("shoulder elbow wrist hip knee ankle"), "pelvis", "head"}
            assert needed <= layout.resolved(order).keys(), layout.name
    for one, other in itertools.combinations(LAYOUTS.values(), 2):
        assert not {*one.orders} & {*other.orders}, (one.name, other.name)


@pytest.mark.full
def test_the_samples_are_those_of_the_script(tmp_path: Path) -> None:
    import subprocess
    import sys

    script = Path(__file__).resolve().parents[2] / "scripts" / "generate_skeleton_samples.py"
    subprocess.run([sys.executable, script, tmp_path], check=True)
    assert {file.name for file in tmp_path.iterdir()} == {file.name for file in nk.imitation.SAMPLES.values()}
    for file in nk.imitation.SAMPLES.values():
        ours, theirs = (re.findall(r"[-\d.]+", path.read_text()) for path in (file, tmp_path / file.name))
        np.testing.assert_allclose(np.array(ours, dtype=float), np.array(theirs, dtype=float), atol=0.11)
    assert sum(file.stat().st_size for file in nk.imitation.SAMPLES.values()) < 100_000
