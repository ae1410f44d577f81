"""The table of tools: in step with its data, every export in it valid, and a wrong row is noticed."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import nao_kin as nk
from nao_kin.cli.app import app
from nao_kin.export.variants import Variant

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import measure_tools  # noqa: E402
from tools_table import measure, reference  # noqa: E402
from tools_table.page import page  # noqa: E402
from tools_table.probes.loaded import Loaded, examine, from_wxyz  # noqa: E402
from tools_table.record import differences, power_of_ten, recorded  # noqa: E402
from tools_table.tools import TOOLS, Tool  # noqa: E402

KNOWN: dict[str, Any] = json.loads(measure_tools.DATA.read_text(encoding="utf-8"))
BY_KEY = {tool.key: tool for tool in TOOLS}
PLAIN = BY_KEY["yourdfpy"]


def test_the_page_is_in_step_with_its_data() -> None:
    assert measure_tools.PAGE.read_text(encoding="utf-8") == page(KNOWN), "run scripts/measure_tools.py --page"


def test_every_tool_has_a_row_for_every_version() -> None:
    assert list(KNOWN) == list(BY_KEY)
    assert all(tuple(record["rows"]) == nk.parameters.VERSIONS for record in KNOWN.values())


@pytest.mark.parametrize("tool", TOOLS, ids=lambda tool: tool.key)
def test_no_row_is_wrong(tool: Tool) -> None:
    assert measure.faults(tool, KNOWN[tool.key]) == []


@pytest.mark.parametrize("tool", TOOLS, ids=lambda tool: tool.key)
def test_the_recommended_export_is_one_that_can_be_asked_for(tool: Tool, nao: nk.NaoModel) -> None:
    assert tool.options.keys() <= nk.export.options(tool.format).keys()
    if tool.format == "urdf":
        Variant(**{name: value for name, value in tool.options.items() if name != "meshes"}).tree_of(nao)
    options = tool.command.removeprefix("nao-kin export ").split()[1:]
    # An unknown format is refused before anything is read, and an option that does not exist before that.
    options[options.index("--format") + 1] = "none"
    refused = CliRunner().invoke(app, ["export", tool.output, *options])
    assert "format" in str(refused.exception), refused.output
    assert (ROOT / "scripts" / "tools_table" / "probes" / f"{tool.probe}.py").is_file()


def test_the_lines_that_load_an_export_name_what_is_written() -> None:
    for tool in TOOLS:
        assert tool.output in tool.snippet
        compile(tool.snippet, tool.name, "exec")


# Rows.


def _row(folder: Path, *, couple: bool, shift: float = 0.0, mass: float | None = None) -> dict[str, Any]:
    """The row of a tool that computes with this library what it reads."""
    expected = reference.write_export(PLAIN, "v5", folder)
    nao = nk.RobotModel.from_urdf(folder / expected["path"])
    free = nk.RobotModel(Variant(coupling="independent").tree_of(nao)[0])
    robot = nao if couple else free

    def poses(values: Mapping[str, float]) -> dict[str, np.ndarray]:
        q = robot.configuration({name: values[name] for name in robot.joint_names}, limits="ignore")
        T = robot.fk(q, robot.link_names)
        T[robot.link_names.index("l_ankle"), 0, 3] += shift
        # The whole robot stands elsewhere, which is no error.
        return dict(zip(robot.link_names, from_wxyz((0.5, 0.5, -0.5, 0.5), (1.0, 2.0, 3.0)) @ T, strict=True))

    return examine(Loaded(poses, mass=mass or nao.mass, meshes=75), expected) | {"expected_mass": expected["mass"]}


def test_a_tool_that_reads_right_has_a_right_row(tmp_path: Path) -> None:
    row = _row(tmp_path, couple=True)
    assert row["frames"] == len(nk.load_nao("v5").link_names)
    assert row["fk_error"] < 1e-12
    assert (row["hips"], row["fingers"]) == ("held", "held")
    assert measure.faults(PLAIN, {"snippet": "yes", "rows": {"v5": row}}) == []


def test_a_coupling_that_is_lost_is_a_fault_of_an_export_that_has_it(tmp_path: Path) -> None:
    row = _row(tmp_path, couple=False)
    assert row["fk_error"] < 1e-12
    said = measure.faults(PLAIN, {"snippet": "yes", "rows": {"v5": row}})
    assert said == ["yourdfpy, v5: hips are uncoupled", "yourdfpy, v5: fingers are uncoupled"]
    independent = replace(PLAIN, options={"coupling": "independent"})
    assert measure.faults(independent, {"snippet": "yes", "rows": {"v5": row}}) == []


def test_a_pose_and_a_mass_that_are_off_are_faults(tmp_path: Path) -> None:
    row = _row(tmp_path, couple=True, shift=2e-6, mass=104.0)
    said = measure.faults(PLAIN, {"snippet": "yes", "rows": {"v5": row | {"meshes": 0, "simulates": "falls"}}})
    assert said == [
        "yourdfpy, v5: poses are off by 2e-06",
        "yourdfpy, v5: weighs 104 kg instead of 5.3054 kg",
        "yourdfpy, v5: shows no mesh",
        "yourdfpy, v5: hips are uncoupled",
        "yourdfpy, v5: simulated, falls",
    ]


@pytest.mark.parametrize(
    ("angle", "said"),
    [(0.31, "yes"), (0.4, "RHipYawPitch is 0.1 rad away from LHipYawPitch"), (np.nan, "angles are not finite")],
)
def test_a_constraint_that_does_not_hold_is_said(angle: float, said: str, tmp_path: Path) -> None:
    expected = reference.write_export(PLAIN, "v5", tmp_path)
    nowhere = dict.fromkeys(expected["links"], np.eye(4))
    angles = {"LHipYawPitch": 0.305, "RHipYawPitch": angle}
    if angle == 0.4:
        angles["LHipYawPitch"] = 0.3
    row = examine(Loaded(lambda _: nowhere, held=["RHipYawPitch"], simulate=lambda: angles), expected)
    assert (row["simulates"], row["hips"], row["fingers"]) == (said, "constraint", "free")


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("kill -SEGV $$", "crashes, signal 11"),
        ("echo cannot read it >&2; exit 3", "cannot read it"),
        ("echo hello", "says nothing"),
    ],
)
def test_a_tool_that_crashes_is_a_row(program: str, said: str, tmp_path: Path) -> None:
    python = tmp_path / "python"
    python.write_text(f"#!/bin/sh\n{program}\n")
    python.chmod(0o755)
    row = measure._row(PLAIN, python, tmp_path)
    assert row == {"loads": said}
    record = recorded({"version": "1", "snippet": "yes", "rows": {"v6": row | {"expected_mass": 5.0}}})
    assert measure.faults(PLAIN, record) == [f"yourdfpy, v6: {said}"]
    assert f"| V6 | {said} |" in page({PLAIN.package: record})


def test_what_changes_from_one_run_to_the_next_is_said_and_rounding_is_not() -> None:
    now = json.loads(json.dumps(KNOWN["mujoco"]))
    assert differences(BY_KEY["mujoco"], KNOWN["mujoco"], now) == []
    now["rows"]["v6"] |= {"fk_error": 1e-9, "meshes": 3}
    now["rows"]["v4"]["simulates"] = "falls"
    said = differences(BY_KEY["mujoco"], KNOWN["mujoco"], now)
    assert [line.split(" was ")[0] for line in said] == ["MuJoCo, v4: simulates", "MuJoCo, v6: meshes"]
    assert differences(PLAIN, None, KNOWN["yourdfpy"]) == ["yourdfpy: not in the table"]


@pytest.mark.parametrize(
    ("error", "power"), [(0.0, 1e-14), (3e-16, 1e-14), (1e-14, 1e-14), (1.1e-14, 1e-13), (4e-7, 1e-6), (0.146, 1.0)]
)
def test_errors_are_kept_as_powers_of_ten(error: float, power: float) -> None:
    assert power_of_ten(error) == power
