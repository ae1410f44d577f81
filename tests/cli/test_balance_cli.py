"""`nao-kin balance`, as people use it: postures, files, and wrong words."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import command_line
import numpy as np
import pytest
from command_line import Capture

import nao_kin as nk

said = partial(command_line.said, "balance")
refused = partial(command_line.refused, "balance")


def test_it_prints_what_touches_and_the_margin(capsys: Capture, nao: nk.NaoModel) -> None:
    out = said(capsys, "--posture", "Sit")
    found = nk.world.balance(nao, nao.posture("Sit"))
    assert f"{1000 * found.margin:.1f} mm" in out
    assert "LHip" in out
    assert out.count("nearest") == 1
    assert "it falls" in said(capsys, "--posture", "StandInit", "--sole", "LLeg")


def test_json_of_one_posture(capsys: Capture, nao: nk.NaoModel) -> None:
    options = ("--posture", "StandInit", "--outline", "sensors", "--gravity", "0.1,0,-9.8", "--json")
    document = json.loads(said(capsys, *options, "--deg"))
    found = nk.world.balance(nao, nao.posture("StandInit"), outline="sensors", gravity=[0.1, 0.0, -9.8])
    assert document["margin"] == float(found.margin)
    assert document["units"] == {"length": "m", "angle": "deg"}
    assert [edge["tilt"] for edge in document["edges"]] == pytest.approx(np.degrees(found.tilts).tolist())
    radians = json.loads(said(capsys, *options))
    assert radians["edges"][0]["tilt"] == pytest.approx(float(found.tilts[0]))
    assert np.array_equal(document["T_robot_base"], found.T_robot_base)
    assert document["soles"] == [name for name, on in zip(("LLeg", "RLeg"), found.down.touching, strict=True) if on]


def test_a_file_gives_a_row_each(
    capsys: Capture, nao: nk.NaoModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("nao_kin.cli.balance._CHUNK", 2)  # of a long file, so that the last row is in a second one
    path = tmp_path / "log.csv"
    postures = [nao.posture(name) for name in ("Stand", "LyingBack", "Crouch")]
    rows = [",".join(map(repr, [k / 10, *q.tolist()])) for k, q in enumerate(postures)]
    path.write_text("\n".join([",".join(("time", *nao.joint_names)), *rows]))
    document = json.loads(said(capsys, str(path), "--json", "--limits", "ignore"))
    margins = nk.world.balance(nao, postures).margin
    assert [row["margin"] for row in document["configurations"]] == pytest.approx(margins.tolist(), abs=1e-12)
    assert [row["time"] for row in document["configurations"]] == [0.0, 0.1, 0.2]
    lines = said(capsys, str(path), "--limits", "ignore").splitlines()
    assert len(lines) == 4
    assert f"{1000 * margins[2]:.1f}" in lines[3]
    # On the tip of one sole no row has a margin, and no row is left out.
    tip = ("--sole", "LLeg", "--gravity=-0.5,-0.3,-1", "--limits", "ignore")
    document = json.loads(said(capsys, str(path), *tip, "--json"))
    assert document["configurations"][0]["margin"] is None
    assert len(said(capsys, str(path), *tip).splitlines()) == 4


def test_wrong_words_are_refused_in_one_line(capsys: Capture, tmp_path: Path) -> None:
    assert "--gravity '0,0': 2 numbers, expected 3" in refused(capsys, "--gravity", "0,0")
    assert "--sole LArm: not on the links of the robot's soles (LLeg, RLeg)" in refused(
        capsys, "--posture", "Stand", "--sole", "LArm", "--sole", "l_ankle"
    )
    assert "no support polygon" in refused(capsys, "--posture", "Stand", "--sole", "LLeg", "--gravity=-.5,-.3,-1")
    assert "whole configurations" in refused(capsys, "x.csv", "--joint", "HeadYaw=1")
    assert "--rate needs FILE" in refused(capsys, "--rate", "3")


def test_contacts_and_forces_are_columns_of_the_file(capsys: Capture, nao: nk.NaoModel, tmp_path: Path) -> None:
    q = np.stack([nao.posture("Stand"), nao.posture("Crouch")])
    contacts = np.array([[1.0, 1.0], [0.0, 1.0]])
    path = tmp_path / "log.csv"
    header = ",".join(["time", *nao.joint_names, "left", "right"])
    np.savetxt(path, np.column_stack([[0.0, 0.1], q, 20.0 * contacts]), delimiter=",", header=header, comments="")
    wanted = nk.world.balance(nao, q, contacts=contacts)
    words = (str(path), "--limits", "ignore", "--json")
    for end in ("TotalWeight", "Contact"):
        names = [word for name in ("left", "right") for word in ("--columns", f"{name}={name[0].upper()}Leg/{end}")]
        out, err = command_line.said_with_notes("balance", capsys, *words, *names)
        rows = json.loads(out)["configurations"]
        assert [row["margin"] for row in rows] == pytest.approx(wanted.margin.tolist(), abs=1e-9)
        assert [row["soles"] for row in rows] == [["LLeg", "RLeg"], ["RLeg"]]
        assert "left, right" in err
        # A sole that is named is on the floor, whatever was measured.
        out, err = command_line.said_with_notes("balance", capsys, *words, *names, "--sole", "RLeg")
        assert [row["soles"] for row in json.loads(out)["configurations"]] == [["RLeg"], ["RLeg"]]
        assert "of each sole are not used with --sole" in err
    assert "unknown joint 'left'" in refused(capsys, str(path))
