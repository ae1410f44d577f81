"""`nao-kin camera`, as people use it: a posture, pixels, points, files, and wrong words."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import command_line
import numpy as np
import pytest
from command_line import Capture

import nao_kin as nk
from nao_kin.cli.app import run

_STAND = ("--posture", "StandInit")


said = partial(command_line.said, "camera")
refused = partial(command_line.refused, "camera")


def test_it_prints_the_numbers_of_a_camera(capsys: Capture, nao: nk.NaoModel) -> None:
    out = said(capsys, *_STAND)
    assert "56.3° × 43.7°" in out
    assert "from (0, 167) to (640, 167)" in out
    assert "from 0.99 m ahead to the horizon" in out
    below = said(capsys, "CameraBottom", *_STAND)
    assert "not in the image" in below
    assert "from 0.26 m ahead to 1.12 m" in below
    assert "80.0° up" in said(capsys, "--posture", "LyingBack")
    document = json.loads(said(capsys, "CameraBottom", *_STAND, "--json", "--deg", "--resolution", "320x240"))
    camera = nk.world.camera(nao, "CameraBottom", "QVGA")
    q = nao.posture("StandInit")
    assert document["focal_lengths"] == [camera.fx, camera.fy]
    assert document["field_of_view"] == pytest.approx([56.3, 43.7])
    assert np.array_equal(document["visible_ground"], nk.world.visible_ground(nao, q, camera)[:, :2])
    assert not document["horizon"]["visible"]


def test_a_pixel_leads_to_the_ground_and_back(capsys: Capture) -> None:
    found = json.loads(said(capsys, "CameraBottom", *_STAND, "--pixel", "300 200", "--height", "0.05", "--json"))
    assert found["valid"]
    assert found["z"] == pytest.approx(0.05)
    back = ("--point", f"{found['x']} {found['y']} {found['z']}")
    again = json.loads(said(capsys, "CameraBottom", *_STAND, *back, "--json"))
    assert [again["u"], again["v"], again["visible"]] == [pytest.approx(300.0), pytest.approx(200.0), True]
    assert "300.00000" in said(capsys, "CameraBottom", *_STAND, *back)


def test_files_have_one_answer_per_row(capsys: Capture, tmp_path: Path, nao: nk.NaoModel) -> None:
    file = tmp_path / "pixels.csv"
    file.write_text("v,name,u\n400,ball,320\n\n10,sky,320\n")
    lines = said(capsys, "CameraTop", str(file), *_STAND, "--csv").splitlines()
    assert lines[0] == "u,v,x,y,z,valid"
    point = nk.world.pixel_to_ground(nao, nao.posture("StandInit"), [320.0, 400.0], nk.world.camera(nao, "CameraTop"))
    assert [float(cell) for cell in lines[1].split(",")[2:5]] == point.points.tolist()
    assert lines[2] == "320.0,10.0,,,,false"
    rows = json.loads(said(capsys, "CameraTop", str(file), *_STAND, "--json"))["rows"]
    assert rows[1] == {"u": 320.0, "v": 10.0, "x": None, "y": None, "z": None, "valid": False}
    file.write_text("x;y;z\n1;0;0\n-1;0;0\n")
    assert "–" in said(capsys, "CameraTop", str(file), *_STAND)


def test_pixels_outside_the_image_are_not_valid_and_the_resolution_that_fits_is_named(
    capsys: Capture, tmp_path: Path
) -> None:
    says = "outside the image of CameraTop, 640 × 480 pixels (VGA); 4VGA, 1280 × 960, contains"
    assert f"the pixel (1000, 700) is {says} it" in refused(capsys, "CameraTop", *_STAND, "--pixel", "1000 700")
    assert "yes" in said(capsys, "CameraTop", *_STAND, "--pixel", "1000 700", "--resolution", "4VGA")
    file = tmp_path / "pixels.csv"
    file.write_text("u,v\n1000,700\n320,400\n800,500\n")
    assert run(["camera", "CameraTop", str(file), *_STAND, "--csv"]) == 0
    printed = capsys.readouterr()
    assert [line.rsplit(",")[-1] for line in printed.out.splitlines()] == ["valid", "false", "true", "false"]
    assert f"2 of 3 pixels are {says} them" in printed.err


def test_wrong_words_are_one_line(capsys: Capture, tmp_path: Path) -> None:
    assert "640 × 480" in refused(capsys, "CameraTop", "--resolution", "480x640")
    assert "above the horizon" in refused(capsys, "CameraTop", *_STAND, "--pixel", "320 0")
    behind = refused(capsys, "CameraTop", *_STAND, "--point", "-1 0 0")
    assert "the point is not in front of CameraTop" in behind
    assert "expected 2" in refused(capsys, "CameraTop", "--pixel", "320 0 1")
    assert "give one" in refused(capsys, "CameraTop", "--pixel", "320 0", "--point", "1 0 0")
    assert "--csv needs FILE" in refused(capsys, "CameraTop", "--csv")
    file = tmp_path / "a.csv"
    for text, words in (
        ("a,b\n1,2\n", "line 1: has the columns a, b; expected u, v or x, y, z"),
        ("u,v\n1,x\n", "line 2, column 2: v is 'x', expected a finite number"),
        ("u,v\n1,2\n1\n", "line 3: 1 values, the header names 2"),
    ):
        file.write_text(text)
        assert words in refused(capsys, "CameraTop", str(file))
    assert "Example: nao-kin camera" in said(capsys, "--help")
