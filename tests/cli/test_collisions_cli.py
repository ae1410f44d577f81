"""`nao-kin collisions`: one configuration, logs and motions."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import Capture

import nao_kin as nk
from nao_kin.cli.app import run


def test_overlapping_links_of_a_posture_are_listed_with_the_clearance(capsys: Capture) -> None:
    assert run(["collisions", "--posture", "Crouch", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    nao = nk.load_nao()
    contacts = nao.collisions(nao.posture("Crouch"))
    assert [row["links"] for row in found["contacts"]] == [list(contact.links) for contact in contacts]
    assert found["clearance"]["distance"] == pytest.approx(float(nao.clearance(nao.posture("Crouch")).distance))
    assert run(["collisions", "--posture", "Crouch"]) == 1
    assert "l_ankle, r_ankle" in capsys.readouterr().out


def test_a_free_posture_has_exit_code_0_and_its_margin(capsys: Capture) -> None:
    assert run(["collisions", "--posture", "Stand"]) == 0
    assert capsys.readouterr().out.startswith("clearance ")
    assert run(["collisions", "--posture", "Stand", "--margin", "0.02", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["contacts"]
    assert rows
    assert all(0.0 < row["distance"] < 0.02 for row in rows)


def test_a_log_and_a_motion_name_rows_and_times(tmp_path: Path, capsys: Capture) -> None:
    nao = nk.load_nao()
    q = nao.random(0, 20)
    log = tmp_path / "log.csv"
    np.savetxt(log, q, delimiter=",", header=",".join(nao.joint_names), comments="", fmt="%.17g")
    assert run(["collisions", str(log), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    overlapping = np.flatnonzero(nao.clearance(q).distance < 0.0)
    assert found["overlapping"] == len(overlapping)
    assert {row["row"] for row in found["contacts"]} == set(overlapping.tolist())
    assert run(["collisions", str(log)]) == 1
    assert f"links overlap in {len(overlapping)} of 20 configurations" in capsys.readouterr().out
    motion = nk.Motion([0.0, 0.2], ["LShoulderRoll", "LElbowRoll"], [[0.2, -0.5], [-0.31, -1.0]])
    nk.motion.write_motion(motion, tmp_path / "m.json")
    assert run(["collisions", str(tmp_path / "m.json"), "--rate", "200", "--json"]) == 1
    rows = json.loads(capsys.readouterr().out)["contacts"]
    assert rows[-1]["time"] == 0.2
    assert 0.0 < rows[0]["time"] < 0.2
    assert run(["motion", "check", str(tmp_path / "m.json"), "--collisions"]) == 1
    out = capsys.readouterr().out
    assert "collision" in out
    assert "collisions were sampled 1000 times per second" in out
    assert run(["motion", "check", str(tmp_path / "m.json")]) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--margin", "nan"], "--margin 'nan': expected a number"),
        (["--rate", "5"], "--rate needs FILE"),
    ],
)
def test_wrong_input_is_one_line(arguments: list[str], message: str, capsys: Capture) -> None:
    assert run(["collisions", *arguments]) == 2
    output = capsys.readouterr()
    assert message in output.err
    assert output.err.count("\n") == 1
    assert output.out == ""


def test_overlaps_may_be_accepted(tmp_path: Path, capsys: Capture) -> None:
    crouch = ["collisions", "--posture", "Crouch"]
    for accepted in (["--tolerance", "0.006"], ["--allow", "r_ankle, l_ankle"]):
        assert run([*crouch, *accepted, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["contacts"] == []
    # The shins' hulls overlap by 5 mm; the meshes are apart by 2 mm.
    legs = {"LHipYawPitch": -0.18, "LHipRoll": -0.07, "LHipPitch": -0.24, "LKneePitch": 0.89}
    legs |= {"RHipRoll": 0.32, "RHipPitch": 0.34, "RKneePitch": 1.42}
    step = ["collisions", "--posture", "StandInit", *(f"--joint={name}={value}" for name, value in legs.items())]
    assert run(step) == 1
    assert run([*step, "--exact"]) == 0
    capsys.readouterr()
    motion = nk.Motion([0.0, 0.2], ["LShoulderRoll", "LElbowRoll"], [[0.2, -0.5], [-0.31, -1.0]])
    nk.motion.write_motion(motion, tmp_path / "m.json")
    check = ["motion", "check", str(tmp_path / "m.json"), "--rate", "50"]
    assert run([*check, "--collisions", "--tolerance", "0.03"]) == 0
    capsys.readouterr()
    for wrong, reason in (
        ([*crouch, "--allow", "l_ankle"], "expected two links"),
        ([*crouch, "--allow", "l_ankel,r_ankle"], "unknown link 'l_ankel'"),
        ([*crouch, "--tolerance", "-1"], "tolerance"),
        ([*check, "--tolerance", "0.01"], "needs --collisions"),
    ):
        assert run(wrong) == 2
        assert reason in capsys.readouterr().err
