"""The page about joints and its diagram are in step with the code."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree as ET

import pytest

import nao_kin as nk
from nao_kin.joints import ANATOMY, KINEMATIC_PAIRS, group_joints
from nao_kin.joints.grouping import unmerged_joints

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "joints.md").read_text(encoding="utf-8")
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("diagram", ROOT / "scripts" / "generate_joint_diagram.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def cells(line: str) -> list[str]:
    return [cell.strip().replace("`", "") for cell in line.strip("|").split("|")]


def test_the_diagram_is_in_step_with_the_model(script, capsys) -> None:
    assert script.main(["--check"]) == 0, capsys.readouterr().err


def test_a_stale_or_missing_diagram_is_reported(script, tmp_path, capsys) -> None:
    path = tmp_path / "images" / "tree.svg"
    assert script.main(["--check", "--output", str(path)]) == 1
    assert script.main(["--output", str(path)]) == 0
    assert script.main(["--check", "--output", str(path)]) == 0
    path.write_text(path.read_text().replace("knee", "ankle"))
    assert script.main(["--check", "--output", str(path)]) == 1
    assert str(path) in capsys.readouterr().err


def test_the_diagram_shows_every_joint_with_its_symbol(script, nao) -> None:
    drawing = ET.fromstring(script.diagram(nao))
    panels = [group for group in drawing.findall(f"{SVG}g") if "translate" in group.get("transform", "")]
    kinds = (unmerged_joints(nao), group_joints(nao), group_joints(nao, rule="concurrent"))
    assert len(panels) >= 3
    for panel, groups in zip(panels, kinds, strict=False):
        counted = {
            "universal": len(panel.findall(f"{SVG}circle[@r='9']")),
            "spherical": len(panel.findall(f"{SVG}circle[@r='6.6']")),
            "revolute": len(panel.findall(f"{SVG}g/{SVG}rect")) + len(panel.findall(f"{SVG}circle[@r='6']")),
        }
        pairs = [joint.pair.name for joint in groups]
        assert counted == {name: pairs.count(name) for name in counted}
        words = [text.text or "" for text in panel.findall(f"{SVG}text")]
        assert groups.summary in words


def test_the_page_lists_the_pairs_as_they_are() -> None:
    for pair in KINEMATIC_PAIRS.values():
        row = [pair.name, pair.symbol, str(pair.freedoms), str(pair.constraints), pair.pinocchio]
        assert row in [cells(line) for line in PAGE.splitlines() if line.startswith("| ")]


def test_the_page_names_every_anatomical_joint_with_its_equivalents() -> None:
    rows = {cells(line)[0]: line for line in PAGE.splitlines() if line.startswith("| ")}
    for kind in ANATOMY:
        assert all(name in rows[kind.name] for name in kind.mechanical)


def test_the_page_states_the_counts_of_the_robots() -> None:
    stated = re.findall(r'\.summary  # "(.*?)"', PAGE)
    assert stated == [
        group_joints(nk.load_nao()).summary,
        group_joints(nk.load_robot("romeo"), rule="concurrent").summary,
    ]
