"""The figures of the explanations are drawn from the robot's numbers, and show what their pages say."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

import nao_kin as nk

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import draw_explanations  # noqa: E402 - found in scripts
from explanations.drawing import Drawing, View, circle_points  # noqa: E402
from explanations.frames import spread  # noqa: E402
from explanations.limits import Chart  # noqa: E402
from explanations.robot_outline import nao_shapes  # noqa: E402

pytestmark = pytest.mark.full

NAMES = sorted(draw_explanations.figures())
IMAGES = ROOT / "docs" / "images"
TEXT = "{http://www.w3.org/2000/svg}text"


def test_a_stale_or_missing_figure_is_reported(tmp_path, capsys) -> None:
    only = ["--only", "quaternion", "--folder", str(tmp_path)]
    assert draw_explanations.main(["--check", *only]) == 1
    assert "quaternion_order.svg" in capsys.readouterr().err
    assert draw_explanations.main(only) == 0
    assert draw_explanations.main(["--check", *only]) == 0
    figure = tmp_path / "quaternion_order.svg"
    figure.write_text(figure.read_text(encoding="utf-8").replace("0.866", "0.867"), encoding="utf-8")
    assert draw_explanations.main(["--check", *only]) == 1


@pytest.mark.parametrize("name", NAMES)
def test_each_figure_is_on_a_page_and_has_a_title(name: str) -> None:
    drawing = ET.parse(IMAGES / f"{name}.svg").getroot()
    assert drawing.attrib["role"] == "img"
    assert "".join(drawing[0].itertext()).strip()
    pages = [path.name for path in (ROOT / "docs").glob("*.md") if f"images/{name}.svg" in path.read_text("utf-8")]
    assert pages


@pytest.mark.parametrize("name", NAMES)
def test_no_two_labels_of_a_figure_overlap(name: str) -> None:
    # Widths as of Helvetica, about 0.56 em for a letter.
    boxes = []
    for label in ET.parse(IMAGES / f"{name}.svg").getroot().iter(TEXT):
        words, size = "".join(label.itertext()), float(label.attrib["font-size"])
        x, y, width = float(label.attrib["x"]), float(label.attrib["y"]), 0.56 * size * len(words)
        x -= {"start": 0.0, "middle": width / 2, "end": width}[label.attrib["text-anchor"]]
        boxes.append((x, x + width, y - 0.7 * size, y, words))
    for k, (a, b, top, foot, words) in enumerate(boxes):
        for c, d, other_top, other_foot, others in boxes[:k]:
            assert b <= c or d <= a or foot <= other_top or other_foot <= top, (words, others)


def test_the_ground_that_the_cameras_see_begins_where_the_figure_says() -> None:
    nao = nk.load_nao("v6")
    q = nao.neutral()
    marks = re.findall(r">(\d\.\d\d) m<", (IMAGES / "cameras_fields_of_view.svg").read_text("utf-8"))
    expected = []
    for camera, edge in (("CameraBottom", 1.0), ("CameraTop", 1.0), ("CameraBottom", -1.0)):
        pitch = nk.rotations.rpy_from_matrix(nao.rotation(q, camera))[1]
        pitch += edge * nao.semantics.fields_of_view[camera][1] / 2
        x, _, z = nao.position(q, camera) - nao.position(q, "LLeg") * [0.0, 0.0, 1.0]
        expected.append(x + z / np.tan(pitch))
    np.testing.assert_allclose([float(mark) for mark in marks], expected, atol=0.006)


def test_the_outline_of_the_robot_covers_all_limbs() -> None:
    nao, shapes = nao_shapes()
    carried = {nao.model.names[joint] for joint, _ in shapes}
    assert {"HeadPitch", "LWristYaw", "RWristYaw", "LAnkleRoll", "RAnkleRoll", "LHandThumb2"} <= carried


def test_labels_are_spread_as_little_as_needed() -> None:
    assert spread([0.0, 50.0, 100.0], 20.0) == [0.0, 50.0, 100.0]
    assert spread([0.0, 0.0, 100.0], 20.0) == [-10.0, 10.0, 100.0]
    assert np.diff(spread([0.0, 1.0, 2.0, 25.0], 20.0)).min() >= 20.0


def test_an_axis_towards_the_reader_is_a_ring() -> None:
    drawing = Drawing(100, 100, "a frame")
    View((50.0, 50.0), 100.0, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)).triad(drawing, np.eye(4), 0.3)
    rings = re.findall(r'<circle [^>]*stroke="([^"]*)"', str(drawing))
    assert "#dc2626" in rings
    assert "#15803d" not in rings


def test_a_projection_keeps_lengths_in_its_plane() -> None:
    view = View.around((10.0, 20.0), 3.0, 40.0, 25.0)
    np.testing.assert_allclose(view.flat(np.zeros(3)), [10.0, 20.0])
    np.testing.assert_allclose(view.flat(view.towards), [10.0, 20.0], atol=1e-12)
    ring = circle_points(np.zeros(3), view.right, view.up, 0.0, 360.0)
    np.testing.assert_allclose(np.linalg.norm(view.flat(ring) - [10.0, 20.0], axis=1), 3.0)


def test_a_chart_shows_the_coupled_limits_of_every_version_alike() -> None:
    def region(version: nk.Version) -> str:
        drawing = Drawing(760, 400, "limits")
        chart = Chart(drawing, (0.0, 0.0, 700.0, 300.0), (-130.0, 130.0), (-45.0, 35.0), (30.0, 10.0))
        chart.limits(nk.load_nao(version), "HeadPitch")
        return str(drawing)

    assert len({region(version) for version in ("v3.2", "v3.3", "v4", "v5", "v6")}) == 1
