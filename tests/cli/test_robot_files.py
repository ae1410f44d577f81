"""The arguments of --urdf and --package-dir on the command line."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from command_line import Capture, refused_line as _refused
from mjcf_samples import BOX, write

import nao_kin as nk
from nao_kin.cli.app import run
from nao_kin.cli.options import COMMANDS
from nao_kin.cli.parsing import options_of

ARM = f"""<worldbody><body name="base">{BOX}<body name="hand" pos="0 0 .5"><joint name="J" axis="0 1 0" range="-1 1"/>
  {BOX}</body></body></worldbody>"""


def _json(capsys: Capture, *arguments: str) -> dict:
    assert run([*arguments, "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return json.loads(out)


def test_an_mjcf_is_a_robot_to_every_command(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("mujoco")
    path = str(write(tmp_path, ARM, "robot.txt"))  # known by what stands in it
    assert _json(capsys, "info", "--urdf", path)["joints"] == 1
    assert _json(capsys, "fk", "--urdf", path, "--joint", "J=0.5")["poses"]["hand"]["pitch"] == pytest.approx(0.5)
    assert _json(capsys, "check", "--urdf", path, "--samples", "5")["ok"]
    assert run(["view", "--urdf", path, "--html", str(tmp_path / "page.html")]) == 0


def test_a_xacro_source_is_a_robot(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("xacro")
    path = tmp_path / "robot.urdf.xacro"
    path.write_text('<robot name="${1 + 1}" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="l"/></robot>')
    assert _json(capsys, "info", "--urdf", str(path))["name"] == "2"


def test_a_plain_file_is_expanded_when_that_is_asked_for(tmp_path: Path, capsys: Capture) -> None:
    pytest.importorskip("xacro")
    path = tmp_path / "robot.urdf"
    path.write_text('<robot name="${1 + 1}"><link name="l"/></robot>')
    assert "xacro=True (--xacro) expands it" in _refused(capsys, "info", "--urdf", str(path))
    assert _json(capsys, "info", "--urdf", str(path), "--xacro")["name"] == "2"
    assert "--xacro needs --urdf" in _refused(capsys, "info", "--xacro")


def test_every_command_that_reads_a_robot_can_be_asked_to_expand_it() -> None:
    parameters = [options_of(name)[0] for name in COMMANDS]
    reading = [names for names in parameters if "urdf" in names]
    assert len(reading) > 10
    assert all("xacro" in names for names in reading)


def test_meshes_are_found_in_folders_given(tmp_path: Path, capsys: Capture) -> None:
    for package in ("one", "two"):
        (tmp_path / f"ws_{package}" / package).mkdir(parents=True)
        (tmp_path / f"ws_{package}" / package / "a.stl").touch()
    (tmp_path / "urdf").mkdir()
    path = tmp_path / "urdf" / "robot.urdf"
    meshes = "".join(
        f'<visual><geometry><mesh filename="package://{package}/a.stl"/></geometry></visual>'
        for package in ("one", "two")
    )
    path.write_text(f'<robot name="r"><link name="l">{meshes}</link></robot>')
    assert len(_json(capsys, "info", "--urdf", str(path))["load_notes"]) == 1
    folders = [f"--package-dir={tmp_path / f'ws_{package}'}" for package in ("one", "two")]
    assert _json(capsys, "info", "--urdf", str(path), *folders)["load_notes"] == []


def test_folders_and_files_that_make_no_sense_are_refused(
    tmp_path: Path, capsys: Capture, nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "--package-dir needs --urdf" in _refused(capsys, "info", "--package-dir", str(tmp_path))
    assert "there is no folder" in _refused(capsys, "fk", "--urdf", str(nao.urdf_path), "--package-dir", "nowhere")
    (tmp_path / "a.xml").write_text("<html/>")
    assert "a URDF has <robot> and an MJCF <mujoco>" in _refused(capsys, "info", "--urdf", str(tmp_path / "a.xml"))
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert "nao-kin[mujoco]" in _refused(capsys, "info", "--urdf", str(write(tmp_path, ARM)))
