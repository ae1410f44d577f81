"""`nao-kin export`, as people use it, and wrong words."""

from __future__ import annotations

import json
import os
from functools import partial
from pathlib import Path

import command_line
import pytest
from command_line import Capture

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.robot.urdf.reader import read_urdf


def said(capsys: Capture, *arguments: str) -> tuple[str, list[str]]:
    """Return standard output, and the lines on standard error."""
    assert run(["export", *arguments]) == 0
    out, err = capsys.readouterr()
    return out, [line.removeprefix("nao-kin: ") for line in err.splitlines()]


refused = partial(command_line.refused, "export")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_command_offers_every_option_of_every_format_with_its_help(capsys: Capture) -> None:
    help = " ".join(said(capsys, "--help")[0].split())
    for name in {name for format in nk.export.FORMATS for name in nk.export.options(format)}:
        assert f" --{name.replace('_', '-')} " in help, name
    assert "--posture NAME gltf: a posture of the robot; by default its start posture" in help
    assert "mjcf: physical corrects impossible inertias, which MuJoCo refuses; published does not change them." in help
    assert "Default: published; physical (mjcf, sdf). --typed urdf: write three joints with one centre" in help


def test_the_file_is_named_and_the_changes_are_said(capsys: Capture) -> None:
    out, notes = said(capsys, "nao.urdf", "--format", "urdf", "--frames", "none", "--inertia", "physical")
    assert out == "nao.urdf\n"
    assert notes[0] == "base_link has neither mass nor shapes: torso is the root instead"
    assert "l_wrist: mass 0.18533 → 0.183477 kg, the rest given to links on it" in notes
    assert len(os.listdir("meshes")) == 64


def test_the_ending_of_the_file_is_its_format(capsys: Capture, folder: Path) -> None:
    said(capsys, "nao.urdf", "--meshes", "none")
    assert read_urdf("nao.urdf").name == "nao_v6"
    box = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    (folder / "box.urdf").write_text(f'<robot name="r"><link name="l">{box}</link></robot>', encoding="utf-8")
    said(capsys, "box.GLB", "--urdf", "box.urdf")
    assert (folder / "box.GLB").read_bytes()[:4] == b"glTF"
    assert "--format is missing: give one of urdf, " in refused(capsys, "nao.xml")


def test_json_has_the_files_and_the_changes(capsys: Capture) -> None:
    out, notes = said(capsys, "nao.urdf", "--format", "urdf", "--coupling", "locked", "--meshes", "none", "--json")
    document = json.loads(out)
    assert document["path"] == "nao.urdf"
    assert document["files"] == ["nao.urdf"]
    assert document["changes"] == notes
    assert "LHipYawPitch is fixed at 0, together with its followers: RHipYawPitch" in notes


def test_a_dash_writes_to_standard_output(capfd: Capture) -> None:
    assert run(["export", "-", "--format", "urdf", "--meshes", "none"]) == 0
    assert capfd.readouterr().out.startswith('<?xml version="1.0" encoding="utf-8"?>\n<robot name="nao_v6">')


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--format", "urfd"], "unknown format 'urfd' (nearest: urdf"),
        (["--format", "urdf", "--inertia", ""], "--inertia is empty"),
        (["--format", "urdf", "--meshes", "package:/x"], "unknown choice of meshes 'package:/x'"),
    ],
)
def test_what_cannot_be_is_one_line_and_nothing_is_written(arguments: list[str], message: str, capsys: Capture) -> None:
    assert message in refused(capsys, "nao.urdf", *arguments)
    assert os.listdir() == []


def test_a_file_that_is_there_is_replaced_by_force_only(capsys: Capture) -> None:
    arguments = ("nao.urdf", "--format", "urdf", "--meshes", "none")
    said(capsys, *arguments)
    assert refused(capsys, *arguments) == "nao-kin: nao.urdf already exists; overwrite=True (--force) replaces it\n"
    said(capsys, *arguments, "--force")


def test_places_that_take_no_file_are_named(capsys: Capture) -> None:
    os.mkdir("there")
    assert "cannot write there: it is a folder" in refused(capsys, "there", "--format", "urdf")
    assert "No such file or directory" in refused(capsys, "gone/nao.urdf", "--format", "urdf")
    assert "both write to standard output" in refused(capsys, "-", "--format", "urdf", "--json")
    assert "takes one file, but 64 more must be next to it" in refused(capsys, "-", "--format", "urdf")
    for name in ("mjcf", "ros2", "sdf"):
        assert "it is a file, and a folder is needed" in refused(capsys, "-", "--format", name)
        assert "No such file or directory" in refused(capsys, "gone/nao", "--format", name)
        assert "no folder name" in refused(capsys, "", "--format", name)
    assert os.listdir() == ["there"]


TWO_MOTIONS = """def up():
    names = ["HeadYaw"]; times = [[0.0, 1.0]]; keys = [[0.0, 0.5]]
def down():
    names = ["HeadPitch"]; times = [[0.0, 1.0]]; keys = [[0.0, 0.2]]
""".replace("; ", "\n    ")


def test_one_of_several_motions_in_a_file_is_chosen(folder: Path, capsys: Capture) -> None:
    (folder / "two.py").write_text(TWO_MOTIONS, encoding="utf-8")
    assert "choose one with timeline= or --timeline" in refused(
        capsys, "a.glb", "--format", "gltf", "--motion", "two.py"
    )
    said(capsys, "a.glb", "--format", "gltf", "--motion", "two.py", "--timeline", "down")
    nk.export.gltf(nk.load_nao(), "b.glb", motion=nk.motion.read_motion("two.py", timeline="down"))
    assert Path("a.glb").read_bytes() == Path("b.glb").read_bytes()
    said(capsys, "a.glb", "--motion", "two.py", "--timeline", "down", "--file-deg", "--force")
    nod = nk.motion.read_motion("two.py", timeline="down", degrees=True)
    nk.export.gltf(nk.load_nao(), "b.glb", motion=nod, overwrite=True)
    assert Path("a.glb").read_bytes() == Path("b.glb").read_bytes()
    assert "--timeline needs --motion" in refused(capsys, "c.glb", "--format", "gltf", "--timeline", "down")
