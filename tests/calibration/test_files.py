"""Files of observations, and the command that reads them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calibration_samples import MARKS, looking, seen

import nao_kin as nk
from nao_kin.calibration import calibrate, read_observations
from nao_kin.cli.app import run
from nao_kin.errors import BadInputFile

TRUE = {"HeadYaw": 0.03, "LElbowYaw": -0.04}


@pytest.fixture(scope="module")
def document(nao: nk.NaoModel) -> dict[str, Any]:
    true, rng = nao.with_offsets(TRUE), np.random.default_rng(0)
    q = looking(true, rng, 12, ["LArm"])
    pixels: Any = np.array(seen(true, nk.world.camera(nao, "CameraTop"), q, "LArm", rng).pixels).tolist()
    pixels[2][4] = None
    joints = [dict(zip(nao.joint_names, row.tolist(), strict=True)) for row in q]
    yaws = (-0.1, 0.1, 0.3)
    stand = true.fk(nao.posture("StandInit", HeadYaw=yaws), "Gaze")
    gaze = [{"joints": {"HeadYaw": yaw}, "pose": T.tolist()} for yaw, T in zip(yaws, stand, strict=True)]
    gaze[1]["pose"] = [*stand[1, :3, 3], *nk.rotations.rpy_from_matrix(stand[1, :3, :3])]
    hand = [{"joints": j, "pixels": p} for j, p in zip(joints, pixels, strict=True)]
    lens = nk.world.camera(nao, "CameraTop")
    numbers = {"intrinsics": [lens.fx, lens.fy, lens.cx, lens.cy]}
    camera = {"camera": "CameraTop", "resolution": [640, 480], "noise": 0.5, **numbers}
    return {
        "joints": ["HeadYaw", "LElbowYaw"],
        "frames": {"CameraTop": ["roll"]},
        "observations": [
            {"type": "pixels", **camera, "frame": "LArm", "points": MARKS.tolist(), "seen": hand},
            {"type": "poses", "posture": "StandInit", "frame": "Gaze", "noise": [0.01, 0.01], "seen": gaze},
        ],
    }


@pytest.fixture
def path(tmp_path: Path, document: dict[str, Any]) -> Iterator[Path]:
    path = tmp_path / "observations.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def test_a_file_says_what_calibrate_takes(nao: nk.NaoModel, path: Path, document: dict[str, Any]) -> None:
    arguments = read_observations(nao, path)
    pixels, poses = arguments["observations"]
    assert np.isnan(np.array(pixels.pixels)[2, 4]).all()
    assert np.isfinite(np.array(pixels.pixels)).sum() == 12 * 9 * 2 - 2
    assert np.array_equal(poses.q, nao.posture("StandInit", HeadYaw=[-0.1, 0.1, 0.3]))
    assert np.allclose(poses.poses[1], nao.with_offsets(TRUE).fk(poses.q[1], "Gaze"), atol=1e-12)
    found = calibrate(nao, **arguments)
    assert found.joints == pytest.approx(TRUE, abs=0.003)
    lens = json.loads(json.dumps(document))
    lens["observations"][0] |= {"intrinsics": [560, 561, 320, 240], "distortion": [0.1, 0.2, 0, 0, 0]}
    path.write_text(json.dumps(lens))
    camera = read_observations(nao, path)["observations"][0].camera
    assert (camera.fx, camera.cy, camera.distortion, camera.width) == (560, 240, (0.1, 0.2, 0, 0, 0), 640)


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("observation",), [], "unknown member 'observation' (nearest: observations"),
        (("observations",), [], "observations must be a list that is not empty"),
        (("joints",), "HeadYaw", "joints must be a list of names"),
        (("observations", 0, "type"), "pixel", "observation 0: unknown type of observation 'pixel' (nearest: pixels"),
        (("observations", 0, "camera"), "CameraTip", "observation 0: unknown camera of nao_v6 'CameraTip'"),
        (("observations", 0, "camera"), None, "observation 0: camera must be given"),
        (("observations", 0, "pixel"), [], "observation 0: unknown member 'pixel'"),
        (("observations", 0, "points"), [[1, 2]], "points must have shape"),
        (("observations", 0, "points"), [[1, 2, "x"]], "points must be real numbers"),
        (("observations", 0, "seen", 3, "pixels"), [[1, 2]], "pixels of seen 3 must be [u, v] or null for each of 9"),
        (("observations", 0, "seen", 3, "pixels"), [[1, "x"]] * 9, "pixels of seen 3 must be [u, v]"),
        (("observations", 0, "seen", 3, "joints"), {"HeadYa": 0}, "observation 0: seen 3: unknown joint 'HeadYa'"),
        (("observations", 0, "seen", 3, "joint"), {}, "seen 3: member 'joint'"),
        (("observations", 1, "posture"), "Sitt", "observation 1: seen 0: unknown posture 'Sitt'"),
        (("observations", 1, "seen", 0, "pose"), [1, 2], "pose of seen 0 must have shape (6,) or (4, 4)"),
        (("observations", 1, "frame"), 3, "observation 1: frame must be given"),
        (("observations", 1, "noise"), -1, "observation 1: noise of poses must have shape"),
        (("observations", 1, "world"), ["x"], "world must be a text, got ['x']"),
        (("start",), {"board": 3}, "start of board must have shape (6,) or (4, 4)"),
        (("prior",), "wide", "unknown prior 'wide' (valid: typical, none)"),
        (("prior",), {"HeadYaw": "x"}, "prior of HeadYaw must be"),
        (("joint_noise",), -1, "joint_noise must be"),
        (("observations", 0, "intrinsics"), [280, 280, 160, 120], "intrinsics are of images of about 320 × 240 pixels"),
        (("observations", 0, "intrinsics"), [560, 560, 160, 120], "intrinsics are of images of about 320 × 240 pixels"),
        (
            ("observations", 0),
            {
                "type": "pixels",
                "camera": "CameraTop",
                "resolution": "QVGA",
                "points": [[1.0, 0.0, 0.3]],
                "seen": [{"pixels": [[400, 100]]}],
            },
            "pixels are outside the image of CameraTop, 320 × 240 pixels (QVGA)",
        ),
        (("observations", 0, "points"), ["centre"], "points must be real numbers"),
        (("observations", 0, "field"), "SPL 2030", "observation 0: unknown field 'SPL 2030'"),
        (("observations", 0, "seen", 3, "velocities"), {"HeadYa": 0}, "seen 3: unknown joint 'HeadYa'"),
        (("observations", 0, "seen", 3, "velocities"), [0.1], "observation 0: seen 3: velocities must be an object"),
        (("observations", 0, "seen", 3, "velocities"), {"HeadYaw": None}, "observation 0: seen 3: HeadYaw must be"),
        (("observations", 1, "seen", 0, "velocities"), {}, "observation 1: unknown seen 0: member 'velocities'"),
    ],
)
def test_what_a_file_says_wrongly_is_named(
    path: Path,
    document: dict[str, Any],
    place: tuple[Any, ...],
    value: Any,
    message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    wrong = json.loads(json.dumps(document))
    part = wrong
    for step in place[:-1]:
        part = part[step]
    part[place[-1]] = value
    path.write_text(json.dumps(wrong))
    assert run(["calibrate", str(path)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert message in err


def test_a_file_that_is_not_json_is_named(nao: nk.NaoModel, path: Path) -> None:
    path.write_text("{")
    with pytest.raises(BadInputFile, match=r"observations\.json, line 1"):
        read_observations(nao, path)


def test_the_command_prints_and_writes_the_offsets(
    path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = tmp_path / "nao_7.toml"
    assert run(["calibrate", str(path), "-o", str(output), "--deg", "--next"]) == 0
    out, err = capsys.readouterr()
    assert err.startswith("nao-kin: zero of LShoulderPitch, zero of LWristYaw, y of CameraTop's mounting, yaw")
    assert err.count("\n") == 1
    assert "HeadYaw offset" in out
    assert "roll of CameraTop's mounting" in out
    assert "σ after" in out
    assert "next posture [°], gain" in out
    assert out.endswith(f"{output}\n")
    assert nk.load_nao(offsets=output).tree.offsets.keys() >= {"HeadYaw", "LElbowYaw"}
    assert run(["fk", "--frame", "Head", "--offsets", str(output)]) == 0
    capsys.readouterr()
    before = output.read_bytes()
    assert run(["calibrate", str(path), "-o", str(tmp_path / "nao_7.json")]) == 2
    assert "a table of offsets is written as TOML; end the name in .toml" in capsys.readouterr().err
    assert run(["calibrate", str(path), "-o", str(output)]) == 2
    assert "already exists" in capsys.readouterr().err
    assert output.read_bytes() == before
    found = []
    for degrees in ((), ("--deg",)):
        assert run(["calibrate", str(path), "-o", str(output), "--force", "--json", *degrees]) == 0
        found.append(json.loads(capsys.readouterr().out))
    assert [one["units"]["angle"] for one in found] == ["rad", "deg"]
    for name in ("joints", "standard_deviations"):
        plain, turned = ([one[name][key] for key in sorted(one[name]) if "Yaw" in key] for one in found)
        assert np.degrees(plain) == pytest.approx(turned, rel=1e-12)
    assert run(["calibrate", str(path), "-o", str(tmp_path / "more.toml"), "--offsets", str(output)]) == 2
    assert "had offsets before" in capsys.readouterr().err
    assert not (tmp_path / "more.toml").exists()


def test_the_command_prints_json(path: Path, document: dict[str, Any], capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["calibrate", str(path), "--json", "--next"]) == 0
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert "are unknown too, and in the standard deviations; name them in joints and frames" in err
    assert (found["cameras"], found["clocks"]) == ({}, {})
    assert found["joints"] == pytest.approx(TRUE, abs=0.003)
    assert set(found["standard_deviations"]) == {"HeadYaw offset", "LElbowYaw offset", "roll of CameraTop's mounting"}
    assert found["rms_before"] > 5.0 > 1.2 > found["rms_after"]
    assert found["next"]["joints"].keys() >= {"HeadYaw"}
    held = json.loads(json.dumps(document))
    held["joints"].append("RKneePitch")
    path.write_text(json.dumps(held))
    assert run(["calibrate", str(path), "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["held"] == ["RKneePitch offset"]
    assert err.startswith("nao-kin: the data say nothing about RKneePitch offset: RKneePitch offset is held at 0 ± 1°;")
    assert run(["calibrate", str(path), "--refuse"]) == 2
    assert "say nothing about RKneePitch offset" in capsys.readouterr().err
    assert run(["calibrate", str(path), "--json", "-o", "/dev/stdout"]) == 2


FIELD = {"type": "lines", "camera": "CameraTop", "posture": "StandInit", "noise": 0.5}
MARK = {"type": "pixels", "camera": "CameraTop", "posture": "StandInit", "frame": "LLeg", "board": "field"}


@pytest.fixture
def on_field(nao: nk.NaoModel, tmp_path: Path) -> tuple[Path, dict[str, Any]]:
    """Two observations of a robot that stands on a field: pixels on lines, and of a named point."""
    from test_field import drawn, seen as of_field, stand

    camera, field = nk.world.camera(nao, "CameraTop"), nk.calibration.FIELDS["SPL 2020"]
    q, T = stand(nao, (2.0, -0.5, 0.3))
    lines, marks = [], []
    mark = of_field(nao, camera, q, T, np.array([field.points["opponent penalty mark"]]))[:, 0]
    for k, row in enumerate(q):
        joints = dict(zip(("HeadYaw", "HeadPitch"), row[:2].tolist(), strict=True))
        shown = {}
        for name in ("opponent goal line", "opponent penalty area line", "opponent left penalty area line"):
            pixels = of_field(nao, camera, q[k : k + 1], T, drawn(name, 7))[0]
            shown[name] = pixels[np.isfinite(pixels[:, 0])].tolist()
        lines.append({"joints": joints, "lines": {name: pixels for name, pixels in shown.items() if pixels}})
        marks.append({"joints": joints, "pixels": [mark[k].tolist() if np.isfinite(mark[k, 0]) else None]})
    names = {"points": ["opponent penalty mark"], "field": "SPL 2020", "on_floor": True}
    observations = [FIELD | {"seen": [one for one in lines if one["lines"]]}, MARK | names | {"seen": marks}]
    document = {"joints": ["HeadPitch"], "frames": {"CameraTop": ["roll"]}, "observations": observations}
    return tmp_path / "field.json", document


def test_a_file_may_have_lines_and_named_points_of_a_field(
    nao: nk.NaoModel, on_field: tuple[Path, dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    path, document = on_field
    path.write_text(json.dumps(document))
    lines, marks = read_observations(nao, path)["observations"]
    assert len(lines.lines) == np.shape(lines.pixels)[1] >= 12
    assert np.isnan(np.asarray(lines.pixels)).any()  # fewer pixels in some postures
    assert np.array_equal(marks.points, [[3.2, 0.0, 0.0]])
    assert run(["calibrate", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert abs(found["joints"]["HeadPitch"]) < 1e-6
    assert found["poses"]["field"][0][3] == pytest.approx(-1.763, abs=1e-3)
    assert found["prior_deviations"]["HeadPitch offset"] == pytest.approx(np.radians(1.0))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"lines": {"goal line": [[1, 2]]}}, "unknown line of the field SPL 2020 'goal line'"),
        ({"lines": {}}, "observation 0: lines must name at least one line"),
        ({"lines": [[1, 2]]}, "lines of seen 0 must be an object"),
        ({"lines": {"opponent goal line": [[1, 2, 3]]}}, "opponent goal line of seen 0 must be [u, v]"),
        ({"pixels": []}, "seen 0: member 'pixels'"),
    ],
)
def test_what_a_file_says_wrongly_of_lines_is_named(
    on_field: tuple[Path, dict[str, Any]], change: dict[str, Any], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path, document = on_field
    one = {"joints": {}, **change}
    document["observations"] = [FIELD | {"seen": [one]}]
    path.write_text(json.dumps(document))
    assert run(["calibrate", str(path)]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert message in err


def test_a_file_may_have_velocities_for_the_clock_of_the_camera(
    nao: nk.NaoModel, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from test_systematic import GRID, T_TORSO_BOARD, measured

    rng, camera, late = np.random.default_rng(0), measured(nao), 0.03
    heads, speeds = rng.uniform(-0.25, 0.25, (12, 2)), rng.uniform(-6.0, 6.0, (12, 2))
    q = np.array([nao.configuration({"HeadYaw": y, "HeadPitch": p}) for y, p in heads + late * speeds])
    points = nk.screws.transform_point(T_TORSO_BOARD, GRID)
    pixels = camera.project(nk.screws.transform_point(nk.screws.inverse(nao.fk(q, "CameraTop"))[:, None], points))
    rows: Any = np.where(camera.sees(pixels)[..., None], pixels, np.nan).tolist()
    seen = [
        {
            "joints": {"HeadYaw": yaw, "HeadPitch": pitch},
            "velocities": {"HeadYaw": fast, "HeadPitch": slow},
            "pixels": [None if np.isnan(row[0]) else row for row in pixel],
        }
        for (yaw, pitch), (fast, slow), pixel in zip(heads.tolist(), speeds.tolist(), rows, strict=True)
    ]
    one = {"type": "pixels", "camera": "CameraTop", "points": points.tolist(), "seen": seen}
    one["intrinsics"] = [camera.fx, camera.fy, camera.cx, camera.cy]
    path = tmp_path / "moving.json"
    path.write_text(json.dumps({"joints": ["HeadYaw"], "observations": [one]}))
    assert run(["calibrate", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["clocks"]["CameraTop"] == pytest.approx(late, abs=2e-3)
    assert abs(found["joints"]["HeadYaw"]) < 3e-3
