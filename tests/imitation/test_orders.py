"""Orders of points without names: found by their number and by a person's bones, asked for, or doubted."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from people import ORDERS, OTHERS_OF_SMPL, RATE, array_of, pairs, person, walker

import nao_kin as nk
from nao_kin.errors import BadInputFile
from nao_kin.imitation.bones import misfit

Floats = NDArray[np.float64]


def saved(folder: Path, array: Floats) -> Path:
    np.save(folder / "points.npy", array)
    return folder / "points.npy"


CASES = [*ORDERS.items(), *(("smpl", order) for order in OTHERS_OF_SMPL.values())]


@pytest.mark.parametrize(("source", "order"), CASES, ids=[f"{name}, {len(order)}" for name, order in CASES])
@pytest.mark.parametrize("noise", [0.0, 0.01, 0.03])
def test_the_bones_show_the_order(tmp_path: Path, source: str, order: list[str], noise: float) -> None:
    rng = np.random.default_rng([len(order), int(1e3 * noise)])
    points = person(rng, noise)
    array = array_of(points, order, source)
    array[rng.random(array.shape[:2]) < 0.1] = np.nan  # points that are not seen
    found = nk.imitation.read_skeleton(saved(tmp_path, array), rate=RATE)
    assert found.source == source
    assert any(f"{len(order)} points" in note and source in note for note in found.notes)
    assert not any("mirrored" in note or "bones" in note.split(",")[0] for note in found.notes)
    arm = found.points["left_wrist"] - found.points["left_shoulder"]
    own = points["left_wrist"] - points["left_shoulder"]
    seen = np.isfinite(arm).all(axis=1)
    np.testing.assert_allclose(np.linalg.norm(arm, axis=1)[seen], np.linalg.norm(own, axis=1)[seen], rtol=1e-9)
    if noise == 0.0:  # a person who stands still, of whom a single frame is enough
        nk.imitation.read_skeleton(saved(tmp_path, array_of(points, order, source)[:1]), source=source)


@pytest.mark.parametrize("count", [17, 25, 32])
def test_an_order_that_cannot_be_known_is_asked_for(tmp_path: Path, count: int) -> None:
    names = sorted(name for name, order in ORDERS.items() if len(order) == count)
    array = np.random.default_rng(0).normal(size=(30, count, 3))
    with pytest.raises(BadInputFile, match="state source=") as caught:
        nk.imitation.read_skeleton(saved(tmp_path, array), rate=RATE)
    assert all(name in str(caught.value) for name in names)


def test_a_single_frame_that_may_have_several_orders_is_asked_about(tmp_path: Path) -> None:
    array = array_of(person(np.random.default_rng(0)), ORDERS["kinect_v2"], "kinect_v2")[:1]
    with pytest.raises(BadInputFile, match="25 points: .*kinect_v2.*; state source="):
        nk.imitation.read_skeleton(saved(tmp_path, array))
    assert len(nk.imitation.read_skeleton(saved(tmp_path, array), source="kinect_v2")) == 1


def test_another_order_of_as_many_points_is_refused_or_doubted(tmp_path: Path) -> None:
    points = person(np.random.default_rng(3), 0.01)
    scrambled = np.roll(array_of(points, ORDERS["mediapipe"], "mediapipe"), -1, axis=1)
    with pytest.raises(BadInputFile, match=r"33 points: mediapipe, but .*; state source="):
        nk.imitation.read_skeleton(saved(tmp_path, scrambled), rate=RATE)
    for source, other in itertools.permutations(("kinect_v2", "body25", "azure_kinect", "h36m32"), 2):
        if len(ORDERS[source]) == len(ORDERS[other]):
            file = saved(tmp_path, array_of(points, ORDERS[source], source))
            stated = nk.imitation.read_skeleton(file, rate=RATE, source=other)
            assert any(f"are these the points of {other}?" in note for note in stated.notes)
            assert not any("mirrored" in note for note in stated.notes)


def table(folder: Path, array: Floats, numbers: range, kept: slice = slice(None)) -> Path:
    """Write columns x1, y1, z1, v1, … of some points, after a column of classes, as most do for MediaPipe."""
    chosen = [*numbers][kept]
    heads = ["time", "class", *(f"{what}{number}" for number in chosen for what in "xyzv")]
    rows = [
        ",".join([repr(k / RATE), "bow", *map(repr, np.column_stack([frame, np.full(len(frame), 3)]).ravel().tolist())])
        for k, frame in enumerate(array[:, kept])
    ]
    (folder / "coords.csv").write_text("\n".join([",".join(heads), *rows]))
    return folder / "coords.csv"


@pytest.mark.parametrize("first", [0, 1])
def test_landmarks_are_numbered_from_0_or_from_1(tmp_path: Path, first: int) -> None:
    array = array_of(person(np.random.default_rng(4), 0.02), ORDERS["mediapipe"], "mediapipe")
    truth = nk.imitation.Skeleton.from_landmarks(array, "mediapipe", rate=RATE)
    numbers = range(first, first + 33)
    # All; those from the shoulders on, of which the last number tells; those to the knees, of which the first one does;
    # those of the limbs, of which neither does. One landmark off, bones are nearly as equal.
    for kept in (slice(None), slice(11, 33), slice(0, 29), slice(11, 29))[: 4 if first == 0 else 3]:
        found = nk.imitation.read_skeleton(table(tmp_path, array, numbers, kept))
        assert any(f"mediapipe, counted from {first}" in note for note in found.notes)
        np.testing.assert_allclose(found.points["left_wrist"], truth.points["left_wrist"], atol=1e-12)
        np.testing.assert_allclose(found.points["right_knee"], truth.points["right_knee"], atol=1e-12)


def test_numbers_that_names_state_are_those_of_the_file(tmp_path: Path) -> None:
    array = array_of(person(np.random.default_rng(5)), ORDERS["mediapipe"], "mediapipe")
    names = dict(zip(pairs("shoulder elbow wrist"), map(str, range(11, 17)), strict=True))
    names |= {"left_hip": "23", "right_hip": "24"}
    file = table(tmp_path, array, range(33), slice(11, 29))
    found = nk.imitation.read_skeleton(file, names=names, up="-y")
    np.testing.assert_allclose(
        found.points["left_wrist"] - found.points["left_hip"],
        (array[:, 15] - array[:, 23]) @ [[0, 1, 0], [0, 0, -1], [-1, 0, 0]],
        atol=1e-12,
    )


def test_numbered_points_of_another_source(tmp_path: Path) -> None:
    points = person(np.random.default_rng(6), 0.02)
    for source in ("coco17", "body25", "kinect_v2", "azure_kinect"):
        array = array_of(points, ORDERS[source], source)
        for first in (0, 1):
            found = nk.imitation.read_skeleton(table(tmp_path, array, range(first, first + array.shape[1])))
            assert found.source == source


def test_a_person_who_kneels_is_not_mirrored() -> None:
    """Toes point back, and no nose shows where the face is."""
    points = person(np.random.default_rng(7))
    for side in ("left_", "right_"):
        knee = points[side + "knee"] = points[side + "hip"] - (0.0, 0.0, 0.42)
        points[side + "ankle"] = knee - (0.42, 0.0, 0.02)
        points[side + "toe"] = points[side + "ankle"] - (0.15, 0.0, 0.05)
    array = array_of(points, ORDERS["kinect_v2"], "kinect_v2")[:1]
    assert not any("mirrored" in note for note in nk.imitation.Skeleton.from_landmarks(array, "kinect_v2").notes)
    flipped = nk.imitation.Skeleton.from_landmarks(array * (-1.0, 1.0, 1.0), "kinect_v2")
    assert not any("bones" in note for note in flipped.notes)  # which are the same in a mirror


def test_points_that_are_missing_are_noted(nao: nk.NaoModel) -> None:
    whole = nk.imitation.read_skeleton(nk.imitation.SAMPLES["wave"])
    assert not any(note.startswith("no ") for note in whole.notes)
    points = {name: values for name, values in whole.points.items() if name not in ("left_wrist", "head")}
    made = nk.imitation.imitate(
        nao, nk.imitation.Skeleton(whole.times, points).between(0.0, 0.2), legs="ignore", collisions=False
    )
    assert "no left_wrist: the left forearm keeps StandInit" in made.notes
    assert any(note.endswith("the head keeps StandInit") for note in made.notes)
    column = nao.joint_names.index("LElbowRoll")
    np.testing.assert_allclose(made.q[:, column], nao.posture("StandInit")[column], atol=1e-12)


def test_a_person_whose_bones_grow_and_shrink_is_doubted() -> None:
    person = walker(4.0)
    sizes = np.where(np.arange(len(person.times)) % 2, 1.0, 2.5)[:, None]
    points = {name: places * sizes for name, places in person.points.items()}
    assert misfit(person.points, {})[1] == ""
    assert misfit(points, {})[1].startswith("the lengths of bones change by")
