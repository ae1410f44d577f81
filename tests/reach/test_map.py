"""Reach maps: computed in parts or whole, the questions that they answer, and their files."""

from __future__ import annotations

import functools
import itertools
import operator
import re
import shutil
import struct
import threading
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError, NotFinite, UnknownName, WrongShape
from nao_kin.reach import ReachMap, workspace
from nao_kin.reach.reach_map import overlap, union
from nao_kin.reach.sampling import _without

SAMPLES = 40_000
VOXEL = 0.02


@pytest.fixture(scope="module")
def whole(nao: nk.NaoModel) -> ReachMap:
    return workspace(nao, "LArm", SAMPLES, voxel=VOXEL, seed=4)


# --- parts and wholes -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("threads", [1, 2, 7])
def test_any_number_of_threads_gives_the_same_map(nao: nk.NaoModel, whole: ReachMap, threads: int) -> None:
    assert workspace(nao, "LArm", SAMPLES, voxel=VOXEL, seed=4, threads=threads) == whole


@pytest.mark.parametrize("cuts", [(1,), (8191, 8192, 8193), (1, 2, 3, 17, 30_001), (20_000,)])
def test_any_split_adds_up_to_the_whole_in_any_order(nao: nk.NaoModel, whole: ReachMap, cuts: tuple[int, ...]) -> None:
    ends = [0, *cuts, SAMPLES]
    parts = [workspace(nao, "LArm", pair, voxel=VOXEL, seed=4) for pair in itertools.pairwise(ends)]
    assert functools.reduce(operator.add, parts) == whole
    assert functools.reduce(operator.add, parts[::-1]) == whole
    assert functools.reduce(operator.add, parts[1::2] + parts[::2]) == whole


def test_shards_are_all_samples_once(nao: nk.NaoModel, whole: ReachMap) -> None:
    shards = [workspace(nao, "LArm", SAMPLES, voxel=VOXEL, seed=4, shard=(k, 3)) for k in range(3)]
    assert sorted(shard.samples for shard in shards) == [13_333, 13_333, 13_334]
    assert shards[2] + shards[0] + shards[1] == whole


def test_a_map_is_what_counting_one_by_one_gives(nao: nk.NaoModel) -> None:
    found = workspace(nao, "LLeg", 2000, voxel=0.03, seed=1)
    joints = found.settings.joints
    uniform = np.random.Generator(np.random.Philox(1)).random((2000, len(joints)))
    everywhere = np.zeros((2000, len(nao.joint_names)))
    everywhere[:, [nao.joint_names.index(name) for name in joints]] = uniform

    class Given:
        def random(self, shape: tuple[int, ...]) -> np.ndarray:
            return everywhere

    q = nao._limits.random(Given(), (2000,))
    q[:, [i for i, name in enumerate(nao.joint_names) if name not in joints]] = 0.0
    cells = np.floor(nao.position(q, "LLeg") / 0.03).astype(int)
    moving = [nao.joint_names.index(name) for name in joints]
    w = np.linalg.svd(nao.jacobian(q, "LLeg")[:, :3, moving], compute_uv=False).prod(axis=-1)
    x = nao.rotation(q, "LLeg")[..., 0]
    nearest = np.argmax(x @ nk.reach.direction_cells().T, axis=1)
    rows, place, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    place = place.reshape(-1)  # NumPy 2.0 has another shape
    assert np.array_equal(found.indices, rows)
    assert np.array_equal(found.count, count)
    best, mean = np.zeros(len(rows)), np.zeros(len(rows))
    np.maximum.at(best, place, w)
    np.add.at(mean, place, w / count[place])
    assert np.abs(found.best - best).max() <= found.settings.step
    assert np.abs(found.mean - mean).max() <= found.settings.step
    assert w.max() / found.settings.step > 1e6  # steps are fine enough to mean something
    # The cell of a direction is mostly the one with the nearest middle.
    assert np.mean(found.directions[place, nearest]) > 0.9
    assert found.coverage == pytest.approx(found.directions.sum(axis=1) / 48)
    assert (found.directions.sum(axis=1) <= found.count).all()


def test_a_previous_map_is_continued_and_not_drawn_again(nao: nk.NaoModel, whole: ReachMap) -> None:
    asked = []
    middle = workspace(nao, "LArm", (10_000, 20_000), voxel=VOXEL, seed=4)
    continued = workspace(
        nao, "LArm", SAMPLES, voxel=VOXEL, seed=4, previous=middle, progress=lambda done, total: asked.append(total)
    )
    assert continued == whole
    assert set(asked) == {SAMPLES - 10_000}
    assert workspace(nao, "LArm", 5, voxel=VOXEL, seed=4, previous=whole) == whole


def test_stopped_half_way_it_returns_what_is_done_and_goes_on_later(nao: nk.NaoModel) -> None:
    asked = 50_000_000
    counted = []
    part = workspace(
        nao, "LArm", asked, voxel=VOXEL, progress=lambda done, total: counted.append(done), stop=lambda: counted[-1] > 0
    )
    assert 0 < part.samples < asked
    assert part.count.sum() == part.samples
    more = workspace(nao, "LArm", part.ranges[-1][1] + 5, voxel=VOXEL, previous=part)
    assert more == workspace(nao, "LArm", more.samples, voxel=VOXEL)


def test_an_error_in_the_progress_ends_all_threads(nao: nk.NaoModel) -> None:
    def fail(done: int, total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        workspace(nao, "LArm", 2**32, progress=fail)
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("nao_kin_reach")]


def test_another_seed_gives_another_map(nao: nk.NaoModel, whole: ReachMap) -> None:
    assert workspace(nao, "LArm", SAMPLES, voxel=VOXEL, seed=5) != whole


def test_ranges_are_joined_and_taken_away() -> None:
    assert union([(5, 7), (0, 2), (2, 4), (6, 9), (3, 3)]) == ((0, 4), (5, 9))
    assert _without((1, 8), ((0, 2), (4, 5), (7, 20))) == ((2, 4), (5, 7))
    assert _without((1, 8), ((0, 9),)) == ()
    assert _without((1, 8), ()) == ((1, 8),)
    assert _without((5, 8), ((0, 2),)) == ((5, 8),)
    assert overlap(((0, 3), (6, 9)), ((3, 6), (8, 12))) == (8, 9)
    assert overlap(((0, 3),), ((3, 6),)) is None


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"seed": 5}, "another seed: 5 instead of 4"),
        ({"voxel": 0.03}, "another voxel: 0.03 instead of 0.02"),
        ({"frame": "RArm"}, "another frame: RArm instead of LArm"),
        ({"reference": "Head"}, "another reference: Head instead of torso"),
        ({"robot": "nao_v5"}, "another robot: nao_v5 instead of nao_v6"),
        ({"chain": "0"}, "of a robot nao_v6 with other joints, limits or lengths"),
    ],
)
def test_maps_of_different_things_do_not_add_up(whole: ReachMap, change: dict[str, object], said: str) -> None:
    other = replace(whole, settings=replace(whole.settings, **change), ranges=((SAMPLES, 2 * SAMPLES),))
    with pytest.raises(BadArgument, match=said):
        whole + other


def test_versions_of_the_nao_differ(nao: nk.NaoModel, whole: ReachMap) -> None:
    older = workspace(nk.load_nao("v3.2"), "LArm", (SAMPLES, SAMPLES + 10), voxel=VOXEL, seed=4)
    with pytest.raises(BadArgument, match="another robot"):
        whole + older


def test_samples_are_never_counted_twice(whole: ReachMap, nao: nk.NaoModel) -> None:
    with pytest.raises(BadArgument, match="both maps hold the samples from 39999 to 40000"):
        whole + workspace(nao, "LArm", (39_999, 40_007), voxel=VOXEL, seed=4)
    with pytest.raises(TypeError):
        whole + 1  # type: ignore[operator]


def test_coarser_voxels_hold_the_same_samples(nao: nk.NaoModel, whole: ReachMap) -> None:
    coarse = whole.coarser(3)
    assert coarse.voxel == pytest.approx(0.06)
    assert coarse.samples == coarse.count.sum() == SAMPLES
    direct = workspace(nao, "LArm", SAMPLES, voxel=coarse.voxel, seed=4)
    assert np.array_equal(coarse.indices, direct.indices)
    assert np.array_equal(coarse.masks, direct.masks)
    assert np.array_equal(coarse.total_steps, direct.total_steps)
    assert len(whole.coarser(10**9).count) <= 8
    assert whole.coarser(1) == whole


# --- questions ------------------------------------------------------------------------------------------------------


def test_reachable_is_where_samples_fell(nao: nk.NaoModel, whole: ReachMap) -> None:
    assert whole.reachable(whole.centres).all()
    assert whole.reachable([[0.0, 0.098, 0.1], [0.0, 0.098, 3.0]]).tolist() == [False, False]
    assert whole.reachable(np.full((2, 3, 3), 1e300)).shape == (2, 3)
    assert not whole.reachable([1e300, -1e300, 0.0])
    assert not whole.reachable([2**20 * VOXEL * 2, 0, 0])
    around_origin = replace(whole, indices=whole.indices - whole.indices[0])
    assert around_origin.reachable([[VOXEL / 2] * 3, [1e300] * 3]).tolist() == [True, False]
    assert whole.reachable(np.zeros((0, 3))).shape == (0,)
    other = nao.random(11, 4000)
    assert whole.reachable(nao.position(other, "LArm")).mean() > 0.97
    assert whole.best_at(whole.centres) == pytest.approx(whole.best)
    assert whole.best_at([9.0, 9.0, 9.0]) == 0.0


def test_neighbouring_voxels_are_told_apart(whole: ReachMap) -> None:
    inside = {tuple(row) for row in whole.indices.tolist()}
    around = np.stack(np.meshgrid(*[np.arange(-20, 20)] * 3), axis=-1).reshape(-1, 3)
    expected = np.array([tuple(row) in inside for row in around.tolist()])
    assert np.array_equal(whole.reachable((around + 0.5) * VOXEL), expected)


@pytest.mark.parametrize("bad", [[1.0, 2.0], [[1.0, np.nan, 0.0]], "here"])
def test_points_that_are_none_are_refused(whole: ReachMap, bad: object) -> None:
    with pytest.raises((WrongShape, NotFinite, BadArgument)):
        whole.reachable(bad)


def exhaustive(reach: ReachMap, targets: np.ndarray, heights: np.ndarray, yaws: int) -> int:
    """The largest number of targets within reach from any place of the grid, tried one by one."""
    best = 0
    span = np.arange(-40, 40) * reach.voxel + 0.5 * reach.voxel
    places = np.stack(np.meshgrid(span, span, heights, indexing="ij"), axis=-1).reshape(-1, 3)
    for yaw in np.arange(yaws) * 2 * np.pi / yaws:
        R = nk.rotations.rot_z(yaw)
        seen = targets @ R - places[:, None, :]
        best = max(best, int(reach.reachable(seen).sum(axis=1).max()))
    return best


def test_no_place_of_the_grid_is_better_than_the_best_stance(whole: ReachMap) -> None:
    targets = np.random.default_rng(2).uniform((-0.3, -0.3, 0.2), (0.3, 0.3, 0.6), (7, 3))
    stance = whole.best_stance(targets, height=0.33, yaws=4)
    assert stance.count == exhaustive(whole, targets, np.array([0.33]), 4)
    assert stance.count > 0
    assert stance.position[2] == pytest.approx(0.33)
    seen = (targets - stance.position) @ nk.rotations.rot_z(stance.yaw)
    assert np.array_equal(whole.reachable(seen), stance.reached)
    inverse = np.linalg.inv(stance.pose)
    assert np.allclose(targets @ inverse[:3, :3].T + inverse[:3, 3], seen)
    assert np.array_equal(stance.manipulability > 0, stance.reached)


def test_a_range_of_heights_is_searched_too(whole: ReachMap) -> None:
    targets = np.random.default_rng(3).uniform((-0.2, -0.2, 0.2), (0.2, 0.2, 0.5), (5, 3))
    stance = whole.best_stance(targets, height=(0.30, 0.345), yaws=3)
    assert stance.count == exhaustive(whole, targets, np.array([0.30, 0.32, 0.34]), 3)
    assert 0.30 - 1e-12 <= stance.position[2] <= 0.345
    anywhere = whole.best_stance(targets, yaws=3)
    assert anywhere.count >= stance.count


def test_what_a_known_place_reaches_is_found_again(whole: ReachMap) -> None:
    rng = np.random.default_rng(8)
    R, place = nk.rotations.rot_z(2.0 * np.pi * 5 / 36), np.array([1.3, -0.7, 0.33])
    targets = whole.centres[rng.integers(0, len(whole.count), 12)] @ R.T + place
    stance = whole.best_stance(targets, height=0.33)
    assert stance.count >= 11
    assert whole.best_stance(targets).count >= 11


def test_one_target_is_put_where_the_hand_moves_best(whole: ReachMap) -> None:
    stance = whole.best_stance([[0.4, 0.2, 0.3]])
    assert stance.count == 1
    assert stance.manipulability[0] == whole.best.max()
    assert stance.yaw == 0.0


def test_targets_out_of_all_reach_are_counted_as_such(whole: ReachMap) -> None:
    stance = whole.best_stance([[0.1, 0.0, 5.0], [0.0, 0.0, 0.3]], height=0.33)
    assert stance.reached.tolist() == [False, True]
    assert whole.best_stance([[0.1, 0.0, 5.0]], height=0.33).count == 0


@pytest.mark.parametrize(
    ("targets", "more", "error", "said"),
    [
        ([], {}, NaoKinError, "targets"),
        ([0.1, 0.2, 0.3], {}, WrongShape, r"\(m, 3\)"),
        ([[0.1, 0.2, np.inf]], {}, NotFinite, "targets"),
        ([[0.1, 0.2, 0.3]], {"yaws": 0}, BadArgument, "yaws must be at least 1"),
        ([[0.1, 0.2, 0.3]], {"height": (0.4, 0.3)}, BadArgument, "from low to high"),
        ([[0.1, 0.2, 0.3]], {"height": (0.1, 0.2, 0.3)}, WrongShape, "height"),
        ([[0.1, 0.2, 0.3], [900.0, 900.0, 900.0]], {}, BadArgument, "too far apart"),
    ],
)
def test_stances_that_make_no_sense_are_refused(
    whole: ReachMap, targets: object, more: dict[str, object], error: type[Exception], said: str
) -> None:
    with pytest.raises(error, match=said):
        whole.best_stance(targets, **more)


# --- bad input ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "more", "said"),
    [
        (("LArn", 10), {}, "unknown frame or chain 'LArn' .*LArm"),
        (("LArm", 10), {"reference": "Hed"}, "unknown frame 'Hed'"),
        (("LArm", 10), {"reference": "LWristYaw"}, "no joint moves LArm in LWristYaw"),
        (("base_link", 10), {}, "no joint moves base_link in torso"),
        (("LArm", 0), {}, "samples must be at least 1, got 0"),
        (("LArm", 1e6), {}, "samples must be a whole number"),
        (("LArm", 2**32 + 1), {}, "at most"),
        (("LArm", (5, 5)), {}, "end of the samples must be at least 6"),
        (("LArm", 10), {"shard": (3, 3)}, "shard must be at most 2"),
        (("LArm", 10), {"shard": (0, 11)}, "number of shards must be at most 10"),
        (("LArm", 10), {"voxel": 0.0}, "voxel must be positive"),
        (("LArm", 10), {"voxel": 1e-4}, r"would make 8.66e\+10 voxels, more than 5e\+07; give at least"),
        (("LArm", 10), {"voxel": 5e-324}, "would make inf voxels.* at least 0.0012 m"),
        (("LArm", 10), {"seed": -1}, "seed must be at least 0"),
        (("LArm", 10), {"threads": 0}, "threads must be at least 1"),
    ],
)
def test_what_makes_no_sense_is_refused(
    nao: nk.NaoModel, arguments: tuple[object, ...], more: dict[str, object], said: str
) -> None:
    with pytest.raises(NaoKinError, match=said):
        workspace(nao, *arguments, **more)


@pytest.mark.full
def test_the_voxel_that_the_message_names_is_taken(nao: nk.NaoModel) -> None:
    with pytest.raises(BadArgument) as error:
        workspace(nao, "LArm", 10, voxel=1e-5)
    least = float(re.findall(r"at least (\S+) m", str(error.value))[0])
    assert workspace(nao, "LArm", 10, voxel=1.05 * least).samples == 10


def test_a_previous_map_of_something_else_is_refused_before_the_work(nao: nk.NaoModel, whole: ReachMap) -> None:
    with pytest.raises(BadArgument, match="the previous map is of another frame: LArm instead of RArm"):
        workspace(nao, "RArm", 2**32, voxel=VOXEL, seed=4, previous=whole)


def test_a_sliding_joint_without_limits_is_named(tmp_path: Path) -> None:
    tree = made_up(tmp_path, J("rail", kind="prismatic"), J("arm", xyz=(0.1, 0, 0))).tree
    rail, arm = tree.joints
    robot = nk.RobotModel(replace(tree, joints=(replace(rail, upper=np.inf), arm)))
    with pytest.raises(BadArgument, match="rail slides without limits"):
        workspace(robot, "arm_l", 10)


def test_a_turning_joint_without_limits_goes_all_the_way_round(tmp_path: Path) -> None:
    robot = made_up(tmp_path, J("turn", kind="continuous"), J("tip", kind="fixed", xyz=(0.5, 0, 0)))
    found = workspace(robot, "tip_l", 5000, voxel=0.05)
    angles = np.arctan2(found.centres[:, 1], found.centres[:, 0])
    assert np.diff(np.sort(angles)).max() < 0.2
    assert np.abs(found.best - 0.5).max() < 1e-9


# --- files ----------------------------------------------------------------------------------------------------------


def test_a_map_comes_back_from_its_file_and_equal_maps_give_equal_files(whole: ReachMap, tmp_path: Path) -> None:
    path = whole.save(tmp_path / "reach.npz")
    back = nk.reach.load(path)
    assert back == whole
    assert back.ranges == ((0, SAMPLES),)
    assert repr(back) == repr(whole)
    again = back.save(tmp_path / "again.npz")
    assert again.read_bytes() == path.read_bytes()


def test_parts_with_gaps_come_back(nao: nk.NaoModel, tmp_path: Path) -> None:
    parts = workspace(nao, "LArm", (5, 50)) + workspace(nao, "LArm", (90, 100))
    assert nk.reach.load(parts.save(tmp_path / "m.npz")).ranges == ((5, 50), (90, 100))


def files_that_are_no_maps(folder: Path, whole: ReachMap) -> list[Path]:
    good = whole.save(folder / "good.npz").read_bytes()
    contents = {"empty": b"", "text": b"hello", "cut": good[: len(good) // 2], "bad": good[:400] + b"x" + good[401:]}
    for name, content in contents.items():
        (folder / f"{name}.npz").write_bytes(content)
    with zipfile.ZipFile(folder / "good.npz") as archive, zipfile.ZipFile(folder / "header.npz", "w") as broken:
        for name in archive.namelist():
            broken.writestr(name, archive.read(name).replace(b"'descr'", b"(((((((", 1))
    np.savez(folder / "other.npz", a=np.arange(3))
    np.save(folder / "array.npy", np.arange(3))
    (folder / "picture.npz").write_bytes(b"\x80\x04N.")  # a pickle
    parts = dict(np.load(folder / "good.npz"))
    np.savez(folder / "short.npz", **{**parts, "count": parts["count"][1:]})
    np.savez(folder / "sum.npz", **{**parts, "ranges": parts["ranges"] + [[0, 1]]})
    np.savez(folder / "floats.npz", **{**parts, "masks": parts["masks"] * 1.0})
    np.savez(folder / "more.npz", **parts, extra=parts["count"])
    names = "empty text cut bad header other picture short sum floats more"
    return [*(folder / f"{name}.npz" for name in names.split()), folder / "array.npy", folder, folder / "none.npz"]


def test_files_that_are_no_maps_are_named(whole: ReachMap, tmp_path: Path) -> None:
    for path in files_that_are_no_maps(tmp_path, whole):
        with pytest.raises(BadInputFile, match=re.escape(path.name)):
            nk.reach.load(path)


def test_the_vtk_file_holds_every_voxel_at_its_place(whole: ReachMap, tmp_path: Path) -> None:
    content = whole.save_vtk(tmp_path / "reach.vtk").read_bytes()
    head, _, rest = content.partition(b"CELL_DATA ")
    lines = head.decode("ascii").splitlines()
    assert lines[:4] == ["# vtk DataFile Version 3.0", "nao_v6", "BINARY", "DATASET STRUCTURED_POINTS"]
    sides = np.array([int(word) - 1 for word in lines[4].removeprefix("DIMENSIONS ").split()])
    origin = np.array([float(word) for word in lines[5].removeprefix("ORIGIN ").split()])
    assert lines[6] == "SPACING 0.02 0.02 0.02"
    size, _, rest = rest.partition(b"\n")
    assert int(size) == sides.prod()
    found = {}
    while rest:
        title, table, rest = rest.split(b"\n", 2)
        assert table == b"LOOKUP_TABLE default"
        _, name, kind, _ = title.decode("ascii").split()
        assert kind == "double"
        found[name] = np.array(struct.unpack(f">{int(size)}d", rest[: 8 * int(size)]))
        rest = rest[8 * int(size) + 1 :]
    assert list(found) == ["best", "mean", "count", "coverage"]
    assert found["count"].sum() == SAMPLES
    centres = (np.indices(sides[::-1]).reshape(3, -1)[::-1].T + 0.5) * VOXEL + origin  # x runs fastest
    full = found["count"] > 0
    assert np.array_equal(whole.reachable(centres), full)
    for name, values in found.items():
        there = whole._rows(centres[full])
        assert np.array_equal(values[full], whole.column(name)[there])


@pytest.mark.parametrize("colour_by", ["best", "mean", "count", "coverage"])
def test_the_ply_file_holds_coloured_points(whole: ReachMap, tmp_path: Path, colour_by: str) -> None:
    cloud = trimesh.load(whole.save_ply(tmp_path / "reach.ply", by=colour_by))
    assert np.abs(cloud.vertices - whole.centres).max() < 1e-6
    values = whole.column(colour_by)
    assert cloud.colors[np.argmax(values)].tolist() == [189, 43, 31, 255]
    assert cloud.colors[np.argmin(values)].tolist() == [41, 82, 168, 255]


def test_exports_that_cannot_be_written_are_refused(whole: ReachMap, tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match="column of a reach map 'bset'"):
        whole.save_ply(tmp_path / "a.ply", by="bset")
    for save in (whole.save, whole.save_vtk, whole.save_ply):
        with pytest.raises(BadArgument, match="cannot write"):
            save(tmp_path / "no" / "a")
    nothing = replace(whole, ranges=(), **{name: getattr(whole, name)[:0] for name in nk.reach.reach_map.ROW_ARRAYS})
    for save in (nothing.save_vtk, nothing.save_ply):
        with pytest.raises(BadArgument, match="empty"):
            save(tmp_path / "a")
    with pytest.raises(BadArgument, match="empty"):
        nothing.best_stance([[0.1, 0.2, 0.3]])
    assert not nothing.reachable([0.0, 0.0, 0.0])
    assert nk.reach.load(nothing.save(tmp_path / "none.npz")) == nothing


def test_a_map_cannot_be_changed(whole: ReachMap) -> None:
    with pytest.raises(ValueError, match="read-only"):
        whole.count[0] = 3


def test_a_map_is_the_same_in_any_folder(whole: ReachMap, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole.save(tmp_path / "a.npz")
    monkeypatch.chdir(tmp_path)
    shutil.copy("a.npz", "b.npz")
    assert nk.reach.load("b.npz") == whole


@pytest.mark.parametrize(
    ("name", "shape", "kind"),
    [("count", (1 << 27,), np.int8), ("settings", (), f"U{1 << 28}"), ("more", (1, 1 << 27), np.int8)],
)
def test_a_reach_map_that_would_unpack_to_gigabytes_is_refused_before(
    tmp_path: Path, nao: nk.NaoModel, name: str, shape: tuple[int, ...], kind: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = nk.reach.workspace(nao, "LArm", 500, voxel=0.05).save(tmp_path / "map.npz")
    assert nk.reach.load(path).samples == 500
    with np.load(path) as archive:
        parts = dict(archive)
    stated = {"descr": np.lib.format.dtype_to_descr(np.dtype(kind)), "fortran_order": False, "shape": shape}
    with zipfile.ZipFile(path, "w") as archive:
        for part, array in parts.items():
            if part != name:
                with archive.open(f"{part}.npy", "w") as file:
                    np.lib.format.write_array(file, array)
        with archive.open(f"{name}.npy", "w") as file:
            np.lib.format.write_array_header_1_0(file, stated)
    monkeypatch.setattr(np.lib.format, "read_array", lambda *_, **__: pytest.fail("unpacked"))
    with pytest.raises(nk.errors.BadInputFile, match="map.npz"):
        nk.reach.load(path)
