"""What holds for many public functions at once: batches, threads, places for results, files, and units."""

from __future__ import annotations

import csv
import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loops import for_all

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.errors import BadArgument

NAO = nk.load_nao()
FEET = ["LLeg", "RLeg"]
CAMERA = nk.world.camera(NAO, "CameraTop")
ONES = np.ones(NAO.nv)
# Above 31 rows compiled code computes the methods of a robot, 16 rows at a time.
COUNTS = (31, 32, 33, 47, 49)

METHODS: dict[str, Callable[..., Any]] = {
    "fk": lambda q, **o: NAO.fk(q, FEET, reference="Head", **o),
    "rotation": lambda q, out=None, **o: NAO.rotation(q, "LArm", out=out, **o),
    "position": lambda q, out=None, **o: NAO.position(q, FEET, out=out, **o),
    "jacobian": lambda q, out=None, **o: NAO.jacobian(q, "LArm", out=out, **o),
    "com": lambda q, **o: NAO.com(q, **o),
    "com_jacobian": lambda q, out=None, **o: NAO.com_jacobian(q, out=out, **o),
    "velocity": lambda q, out=None, dtype=None, **o: NAO.velocity(q, ONES, "LArm", out=out, dtype=dtype, **o),
    "acceleration": lambda q, out=None, **o: NAO.acceleration(q, ONES, ONES, FEET, out=out, **o),
}
WITHOUT_THREADS: dict[str, Callable[..., Any]] = {
    "set_down": lambda q: NAO.set_down(q),
    "balance": lambda q: nk.world.balance(NAO, q),
    "clearance": lambda q: NAO.clearance(q),
    "typed": lambda q: nk.joints.MultiDofModel(NAO).from_q(q),
    "velocity of joints": lambda q: nk.ik.velocity(NAO, q, [0.02, 0.0, 0.01, 0.0, 0.1, 0.0], "LArm"),
    "horizon": lambda q: nk.world.horizon(NAO, q, CAMERA),
    "ground": lambda q: nk.world.pixel_to_ground(NAO, q, np.full((*q.shape[:-1], 2), 300.0), CAMERA),
}
# Where one configuration without an answer raises: how far from standing the configurations may be.
ON_FLOOR = {"balance": 0.05, "ground": 0.05, "horizon": 0.1}
SOLVERS: dict[str, Callable[..., Any]] = {
    "analytic": lambda q, threads=None: nk.ik.analytic(NAO, "LLeg", NAO.fk(q, "LLeg"), threads=threads),
    "arm": lambda q, threads=None: nk.ik.arm(NAO, "L", NAO.fk(q, "LArm"), threads=threads),
    "hand": lambda q, threads=None: nk.ik.arm(NAO, "L", NAO.position(q, "LArm"), threads=threads),
    "leg": lambda q, threads=None: nk.ik.leg(NAO, "L", NAO.fk(q, "LLeg"), limits="ignore", threads=threads),
    "legs": lambda q, threads=None: nk.ik.legs(NAO, NAO.fk(q, "LLeg"), NAO.fk(q, "RLeg"), threads=threads),
    "head": lambda q, threads=None: nk.ik.head(NAO, NAO.rotation(q, "Head"), threads=threads),
    "look_at": lambda q, threads=None: nk.ik.look_at(NAO, NAO.position(q, "LArm"), threads=threads),
    "numeric": lambda q, threads=None: nk.ik.numeric(NAO, "LArm", NAO.fk(q, "LArm"), threads=threads),
}
EVERY = METHODS | WITHOUT_THREADS | SOLVERS


def numbers(value: Any) -> dict[str, np.ndarray]:
    """Return the arrays of a result with a row for each configuration, by name."""
    if isinstance(value, np.ndarray):
        return {"": value}
    if dataclasses.is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    given = value if isinstance(value, Mapping) else value._asdict()
    return {name: np.asarray(found) for name, found in given.items() if isinstance(found, np.ndarray | np.generic)}


@for_all("name", sorted(EVERY))
def test_rows_of_a_batch_are_those_one_by_one(name: str) -> None:
    if name == "analytic":
        pytest.importorskip("eaik")
    ask, q = EVERY[name], NAO.random(5, max(COUNTS))
    if name in ON_FLOOR:
        q = NAO.posture("StandInit") + ON_FLOOR[name] * (q - NAO.posture("StandInit"))
    tolerance = 1e-6 if name in SOLVERS else 1e-11  # searches end on either side of theirs
    alone, longest = [numbers(ask(row)) for row in q], numbers(ask(q))
    rows = [(what, array) for what, array in longest.items() if array.shape[:1] == (len(q),)]
    pairs = [(f"{what}, row {k}", one[what], array[k]) for what, array in rows for k, one in enumerate(alone)]
    for n in COUNTS[:-1]:
        shorter = numbers(ask(q[:n]))
        pairs += [(f"{what}, {n} rows", shorter[what], array[:n]) for what, array in rows]
    for what, array, others in pairs:
        # The axes that list solutions or corners are as long as the longest of the batch needs.
        cut = others[tuple(slice(size) for size in array.shape)]
        np.testing.assert_allclose(cut, array, rtol=0, atol=tolerance, err_msg=what)


@for_all("name", sorted(METHODS | SOLVERS))
def test_any_number_of_threads_gives_the_same_bits(name: str) -> None:
    if name == "analytic":
        pytest.importorskip("eaik")
    ask, q = (METHODS | SOLVERS)[name], NAO.random(5, 100)
    first, *others = (numbers(ask(q, threads=threads)) for threads in (1, 2, 3))
    for other in others:
        for what, array in first.items():
            np.testing.assert_array_equal(other[what], array, err_msg=what)


def test_a_path_has_the_same_bits_with_any_number_of_threads() -> None:
    path = {"LArm": np.linspace([0.15, 0.12, 0.0], [0.15, 0.12, 0.05], 40)}
    one, two = (nk.ik.follow(NAO, path, threads=threads).q for threads in (1, 2))
    np.testing.assert_array_equal(one, two)


def test_other_starts_of_a_search_come_from_the_seed() -> None:
    places = NAO.position(NAO.random(2, 300), "LArm")
    first, again, other = (nk.ik.numeric(NAO, "LArm", places, seed=seed) for seed in (0, 0, 1))
    assert first.success.all()
    assert other.success.all()
    np.testing.assert_array_equal(first.q, again.q)
    assert np.abs(first.q - other.q).max() > 0.01
    np.testing.assert_allclose(NAO.position(other.q, "LArm"), places, atol=1e-7)


MOTION = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
WRITERS: dict[str, Callable[..., Any]] = {
    "gltf": lambda path, overwrite=False: nk.export.gltf(NAO, path, overwrite=overwrite).path,
    "srdf": lambda path, overwrite=False: nk.export.srdf(NAO, path, samples=1, overwrite=overwrite).path,
    "write": lambda path, overwrite=False: nk.export.write(NAO, path, "urdf", meshes="none", overwrite=overwrite).path,
    "offsets": lambda path, overwrite=False: nk.robot.write_offsets(
        path, {"joints": {"LKneePitch": 0.01}}, overwrite=overwrite
    ),
    "map": lambda path, overwrite=False: nk.reach.workspace(NAO, "LArm", 50).save(path, overwrite=overwrite),
    "motion": lambda path, overwrite=False: (
        nk.motion.write_motion(MOTION, path, format="csv", overwrite=overwrite) or path
    ),
    "ply": lambda path, overwrite=False: nk.reach.workspace(NAO, "LArm", 50).save_ply(path, overwrite=overwrite),
    "vtk": lambda path, overwrite=False: nk.reach.workspace(NAO, "LArm", 50).save_vtk(path, overwrite=overwrite),
    "html": lambda path, overwrite=False: nk.Viewer(NAO).save_html(path, overwrite=overwrite) or path,
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_file_is_replaced_only_with_overwrite(tmp_path: Path, name: str) -> None:
    write, suffix = WRITERS[name], {"gltf": ".glb", "html": ".html"}.get(name, "")
    path, new = tmp_path / f"mine{suffix}", tmp_path / f"new{suffix}"
    path.write_bytes(b"mine")
    with pytest.raises(BadArgument, match=r"already exists; overwrite=True \(--force\) replaces it"):
        write(path)
    assert path.read_bytes() == b"mine"
    assert Path(write(path, overwrite=True)) == path
    assert path.read_bytes() == Path(write(new)).read_bytes()


def test_no_video_replaces_a_file_unasked(tmp_path: Path) -> None:
    (tmp_path / "nao.webm").write_bytes(b"mine")
    with pytest.raises(BadArgument, match="already exists"):
        nk.Viewer(NAO).save_video(tmp_path / "nao.webm", overwrite=False)


# --- Units.


def table(path: Path) -> dict[str, np.ndarray]:
    with path.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    columns = {}
    for name, column in zip(head, zip(*rows, strict=True), strict=True):
        try:
            columns[name] = np.array(column, dtype=np.float64)
        except ValueError:  # names of frames and soles
            continue
    return columns


WRITTEN: dict[str, list[str]] = {
    "fk": ["fk", "q.csv", "--frame", "LArm", "-o"],
    "state": ["state", "q.csv", "-o"],
}


@pytest.mark.parametrize("name", ["stream", *WRITTEN])
def test_columns_in_degrees_are_those_in_radians(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.chdir(tmp_path)
    q = np.linspace(NAO.posture("StandInit"), NAO.posture("Crouch"), 30)
    rows = np.column_stack([0.02 * np.arange(30), q]).tolist()
    lines = [("time", *NAO.joint_names), *rows]
    Path("q.csv").write_text("".join(",".join(map(str, line)) + "\n" for line in lines), encoding="utf-8")
    for path, degrees in (("rad.csv", False), ("deg.csv", True)):
        if name == "stream":
            nk.stream.fk(NAO, "q.csv", path, frame="LArm", as_="rpy", poses_in_degrees=degrees)
        else:
            assert run([*WRITTEN[name], path, *(["--deg"] if degrees else [])]) == 0
    rad, deg = table(Path("rad.csv")), table(Path("deg.csv"))
    turned = {heading for heading in deg if heading.endswith("_deg")}
    assert len(turned) >= 2
    assert {heading.removesuffix("_deg") for heading in deg} == {*rad}
    for heading, column in deg.items():
        scale = 57.29577951308232 if heading in turned else 1.0
        np.testing.assert_allclose(column, scale * rad[heading.removesuffix("_deg")], rtol=1e-9, atol=1e-9)
