"""Exports that are refused: wrong options, and files that are there already; nothing is written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from made_up_robots import J, made_up

import nao_kin as nk
from nao_kin.errors import BadArgument, UnknownName

NOD = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.3]])
WRONG = [
    *(("urdf", "meshes", value) for value in ("", "package://", "package:///", "Relative", "package://a b")),
    *(("urdf", name, "nonsense") for name in ("frames", "names", "coupling", "inertia", "axes")),
    *(("mjcf", name, "absolute") for name in ("frames", "coupling", "inertia", "meshes", "base")),
    *(("sdf", name, "absolute") for name in ("frames", "names", "coupling", "inertia", "meshes", "base")),
    *(("srdf", name, "loose") for name in ("frames", "names", "coupling", "base")),
    *(("ros2", name, "relative") for name in ("frames", "names", "coupling", "inertia", "meshes")),
    *(("gltf", name, "") for name in ("frames", "names", "posture")),
]
BAD: list[tuple[str, dict[str, Any], str]] = [
    ("urdf", {"typed": "yes"}, "typed must be True or False"),
    ("mjcf", {"typed": "yes"}, "typed must be True or False"),
    ("srdf", {"samples": 0}, "samples must be at least 1"),
    ("ros2", {"samples": 0}, "samples must be at least 1"),
    ("ros2", {"maintainer": "Me"}, "maintainer must have the form"),
    ("ros2", {"maintainer": "<me@here.org>"}, "maintainer must have the form"),
    ("ros2", {"maintainer": "M\x01 <me@here.org>"}, "maintainer must have the form"),
    ("ros2", {"license": ""}, "license must be one line"),
    ("ros2", {"license": "BSD\nMIT"}, "license must be one line"),
    *(
        ("ros2", {"package": name}, "package must be two or more lower-case letters")
        for name in ("Nao", "nao-description", "1nao", "nao__v6", "nao_", "_nao", "n", "näo", "nao v6", "")
    ),
    *(("gltf", {"fps": fps, "motion": motion}, "fps") for fps in (0, -1, float("nan"), 1e9) for motion in (None, NOD)),
    ("gltf", {"posture": "Stand", "motion": NOD}, "a posture or a motion"),
]


def _write(nao: nk.RobotModel, path: Path, format: str, **options: Any) -> nk.export.Exported:
    return nk.export.write(nao, path.with_suffix(".glb"), format, **options)


@pytest.mark.parametrize(("format", "option", "value"), WRONG)
def test_a_choice_that_there_is_not_is_refused(
    nao: nk.NaoModel, tmp_path: Path, format: str, option: str, value: str
) -> None:
    with pytest.raises(UnknownName) as error:
        _write(nao, tmp_path / "x", format, **{option: value})
    assert error.value.name == value
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("format", "options", "words"), BAD, ids=[f"{row[0]}-{row[1]}" for row in BAD])
def test_a_wrong_value_is_refused(
    nao: nk.NaoModel, tmp_path: Path, format: str, options: dict[str, Any], words: str
) -> None:
    with pytest.raises(BadArgument, match=words):
        _write(nao, tmp_path / "x", format, **options)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("format", nk.export.FORMATS)
def test_what_is_there_is_replaced_by_force_only(tmp_path: Path, format: str) -> None:
    options = {"package": "p1", "samples": 1} if format == "ros2" else {}
    robot, path = made_up(tmp_path, J("a")), tmp_path / "out" / "x"
    path.parent.mkdir()
    done = _write(robot, path, format, **options)
    before = {file: file.read_bytes() for file in done.files}
    with pytest.raises(BadArgument, match="already exists"):
        _write(robot, path, format, **options)
    assert _write(robot, path, format, overwrite=True, **options).files == done.files
    assert {file: file.read_bytes() for file in done.files} == before


FORCED: dict[str, Callable[[nk.RobotModel, Path], nk.export.Exported]] = {
    "mjcf": lambda robot, folder: nk.export.mjcf(robot, folder, overwrite=True),
    "sdf": lambda robot, folder: nk.export.sdf(robot, folder, overwrite=True),
    "ros2": lambda robot, folder: nk.export.ros2(robot, folder, package="p1", samples=1, overwrite=True),
}


@pytest.mark.parametrize("format", FORCED)
def test_a_folder_with_other_files_is_never_replaced(tmp_path: Path, format: str) -> None:
    robot, folder = made_up(tmp_path, J("a")), tmp_path / "x"
    done = FORCED[format](robot, folder)
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(BadArgument, match=r"notes\.txt"):
        FORCED[format](robot, folder)
    assert all(file.is_file() for file in done.files)


def test_other_formats_options_and_places_are_refused(nao: nk.NaoModel, tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match=r"unknown format 'urfd' \(nearest: urdf"):
        nk.export.write(nao, tmp_path / "x", "urfd")
    with pytest.raises(UnknownName, match=r"'frame' \(nearest: frames"):
        nk.export.write(nao, tmp_path / "x", "urdf", frame="none")
    with pytest.raises(BadArgument, match=r"end its name in \.glb"):
        nk.export.gltf(nao, str(tmp_path / "nao.gltf"))
    with pytest.raises(UnknownName, match="Tail"):
        nk.export.gltf(nao, tmp_path / "x.glb", motion=nk.Motion([0.0, 1.0], ["Tail"], [[0.0], [0.3]]))
    with pytest.raises(nk.NaoKinError):
        nk.export.gltf(nao, tmp_path / "x.glb", motion=tmp_path / "none.json")
    with pytest.raises(BadArgument, match="cannot write"):
        nk.export.srdf(nao, tmp_path / "nowhere" / "nao.srdf", samples=1)
    for name, near in (("NAO-Description", "nao_description"), ("6nao", "robot_6nao"), ("__", "robot")):
        with pytest.raises(BadArgument, match=f"nearest: {near}$"):
            nk.export.ros2(nao, tmp_path / "nao", package=name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("format", ["urdf", "srdf", "ros2", "sdf", "gltf"])
def test_a_robot_without_ros_names_has_none(tmp_path: Path, format: str) -> None:
    robot, path = made_up(tmp_path, J("a")), tmp_path / "out"
    path.mkdir()
    with pytest.raises(BadArgument, match="no ROS names are known"):
        _write(robot, path / "x", format, names="ros")
    assert not list(path.iterdir())
