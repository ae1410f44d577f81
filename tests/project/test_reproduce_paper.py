from __future__ import annotations

import importlib
import json
import math
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

pytestmark = pytest.mark.full

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
S3, S2 = math.sqrt(3), math.sqrt(2)
AXIS_9 = [-0.678598344546, 0.678598344546, -0.281084637715]
R_9 = [-0.353553390593, 0.353553390593, -0.146446609407]
Q_10 = [
    [0.433012701892, -0.25, 0.866025403784],
    [0.808012701892, 0.533493649054, -0.25],
    [-0.399519052838, 0.808012701892, 0.433012701892],
]
R_9_MATRIX = [[1 / S2, 0, 1 / S2], [-1 / 2, 1 / S2, 1 / 2], [-1 / 2, -1 / S2, 1 / 2]]
QUARTER_Y = [[1 / S2, 0, 1 / S2], [0, 1, 0], [-1 / S2, 0, 1 / S2]]
HALF_DIAGONAL = [[-1 / 3, 2 / 3, 2 / 3], [2 / 3, -1 / 3, 2 / 3], [2 / 3, 2 / 3, -1 / 3]]
U_6 = [
    [1, 0, 0, 0, 0, 0],
    [0, 1, 0, 0, 0, 0],
    [0, 0, 1, 0, 0, 0],
    [0, 1, 0, 1, 0, 0],
    [-1, 0, 0, 0, 1, 0],
    [0, 0, 0, 0, 0, 1],
]
# The paper's numbers, typed a second time on purpose: the script may not be its own judge.
NUMBERS: dict[tuple[str, str], Any] = {
    ("2", "degrees of freedom"): 25,
    ("2", "closed loops"): 0,
    ("2", "serial chains"): 5,
    ("2", "they are head, arms and legs"): True,
    ("2", "couplings between chains"): 1,
    ("2", "it is one motor for both HipYawPitch joints"): True,
    ("3", "hinge: same equivalents"): True,
    ("3", "hinge: freedoms"): [1],
    ("3", "hinge: constraints"): [5],
    ("3", "pivot: same equivalents"): True,
    ("3", "pivot: freedoms"): [1, 2],
    ("3", "pivot: constraints"): [5, 4],
    ("3", "ball and socket: same equivalents"): True,
    ("3", "ball and socket: freedoms"): [3],
    ("3", "ball and socket: constraints"): [3],
    ("3", "ellipsoid: same equivalents"): True,
    ("3", "ellipsoid: freedoms"): [2],
    ("3", "ellipsoid: constraints"): [4],
    ("3", "saddle: same equivalents"): True,
    ("3", "saddle: freedoms"): [2],
    ("3", "saddle: constraints"): [4],
    ("3", "plane: same equivalents"): True,
    ("3", "plane: freedoms"): [3, 1],
    ("3", "plane: constraints"): [3, 5],
    ("3", "NAO's revolute joints"): 6,
    ("3", "NAO's universal joints"): 7,
    ("3", "NAO's spherical joints"): 2,
    ("4", "largest |T w − λ w| over 1000 pairs"): 0,
    ("4", "largest |vᵀ w| of the first two"): 0,
    ("4", "largest |det T − (1 + u·v)|"): 0,
    ("4", "eigenvalues, u = (1, 2, 3), v = (4, 5, 6)"): [1, 1, 33],
    ("4", "eigenvalues, u·v = 0"): [1, 1, 1],
    ("4", "u·v = 0 is defective"): True,
    ("4", "its Jordan form"): [[1, 0, 0], [0, 1, 1], [0, 0, 1]],
    ("4", "eigenvalues, u·v = −1"): [1, 1, 0],
    ("4", "determinant, u·v = −1"): 0,
    ("4", "u·v = −1 has no inverse"): True,
    ("4", "det T − 1 − u·v = 0 for all u, v"): True,
    ("4", "T u = (1 + u·v) u for all u, v"): True,
    ("5", "first solution [deg]"): [30, 60, 30],
    ("5", "second solution [deg]"): [-150, 120, -150],
    ("5", "largest difference of their matrices from Q"): 0,
    ("6", "direction e"): [1 / S3, 1 / S3, 1 / S3],
    ("6", "moment about a = (0, 0, 0)"): [-1 / S3, 2 / S3, -1 / S3],
    ("6", "moment about b = (0, 0, 1)"): [0, 1 / S3, -1 / S3],
    ("6", "transfer matrix U"): U_6,
    ("6", "k_b − U k_a"): [0] * 6,
    ("6", "k_b − k_a transferred"): [0] * 6,
    ("7", "7.1 matrix"): [[3 / 4, -1 / 2, S3 / 4], [S3 / 4, S3 / 2, 1 / 4], [-1 / 2, 0, S3 / 2]],
    ("7", "7.2 angle φ [deg]"): 42.181162357998204,
    ("7", "7.2 vect R"): [-0.125, 0.466506350946, 0.466506350946],
    ("7", "7.2 axis e"): [-0.186156787897, 0.694746590607, 0.694746590607],
    ("8", "largest |R(t) − rotation by αt|, αt in [0, 2π]"): 0,
    ("8", "largest error of (r, r0) as functions of αt in [0, π]"): 0,
    ("8", "αt = π/2: r0"): S2 / 2,
    ("8", "αt = π/2: r"): [0.408248290464] * 3,
    ("8", "αt = π: r0"): 0,
    ("8", "αt = π: r, of its two signs"): [1 / S3] * 3,
    ("8", "αt = π: φ"): math.pi,
    ("8", "αt = π: e eᵀ − ½ (I + R)"): [[0] * 3] * 3,
    ("8", "αt = 2π: r0"): 1,
    ("8", "αt = 2π: r"): [0, 0, 0],
    ("8", "R = I: φ"): 0,
    ("8", "R = I: no axis, reported as zero"): [0, 0, 0],
    ("8", "R(t) − rotation by αt about (1, 1, 1)/√3 = 0 for all t"): True,
    ("8", "r = sin(αt/2) (1, 1, 1)/√3, r0 = cos(αt/2) give R(t) for all t"): True,
    ("9", "det R − 1"): 0,
    ("9", "largest entry of RᵀR − 1"): 0,
    ("9", "angle φ [deg]"): 62.79942961983808,
    ("9", "axis e"): AXIS_9,
    ("9", "r0"): 0.853553390593,
    ("9", "r"): R_9,
    ("10", "10.1 rotation Q from two triads"): Q_10,
    ("10", "10.1 least squares − triads"): [[0] * 3] * 3,
    ("10", "10.1 det Q − 1"): 0,
    ("10", "10.1 largest entry of QᵀQ − 1"): 0,
    ("10", "10.1 arms after − Q · arms before"): [[0] * 3] * 3,
    ("10", "10.3 first solution [deg]"): [30, 60, 30],
    ("10", "10.3 second solution [deg]"): [-150, 120, -150],
    ("10", "10.4 tail point d′"): [99.732050807569, 1003.767949192431, 407.330127018922],
    ("11", "11.1 φ [deg]"): 62.79942961983808,
    ("11", "11.1 e"): AXIS_9,
    ("11", "11.2 q0"): 0.457106781187,
    ("11", "11.2 q"): [-0.603553390593, 0.603553390593, -0.25],
    ("11", "11.3 r0"): 0.853553390593,
    ("11", "11.3 r"): R_9,
    ("11", "11.4 back from (e, φ)"): R_9_MATRIX,
    ("11", "11.4 back from (q, q0)"): R_9_MATRIX,
    ("11", "11.4 back from (r, r0)"): R_9_MATRIX,
    ("11", "11.4 (b) there and back by (q, q0)"): QUARTER_Y,
    ("11", "11.4 (a) from (q, q0) is rejected: it contains no axis"): True,
    ("11", "11.4 product of quaternions"): [-5, -9.75, -2.5, 11.75],
    ("11", "11.4 matrix of a quaternion"): [
        [-20 / 30, 4 / 30, 22 / 30],
        [20 / 30, -10 / 30, 20 / 30],
        [10 / 30, 28 / 30, 4 / 30],
    ],
    **{
        ("11", f"11.4 {case}{way}"): matrix
        for case, matrix in {
            "(a) π about x": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
            "(b) π/4 about y": QUARTER_Y,
            "(c) π about (1, 1, 1)/√3": HALF_DIAGONAL,
        }.items()
        for way in ("", ", there and back by (e, φ)", ", there and back by (r, r0)")
    },
}
ERRATA = [
    "problem 2, part 3",
    "appendix A",
    "problem 5",
    "problem 7, equation 13",
    "problem 8, part 3",
    "problem 8, text",
    "problem 8, part 2",
    "problem 9, equation 17",
    "problem 11.4, text",
    "problem 11.4, text",
    "appendix C",
]


@pytest.fixture(scope="module")
def script() -> ModuleType:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(SCRIPTS))
        return importlib.import_module("reproduce_paper")


@pytest.fixture(scope="module")
def report() -> dict[str, Any]:
    """Return the output of --json, run as a user runs it."""
    command = [sys.executable, str(SCRIPTS / "reproduce_paper.py"), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    return json.loads(done.stdout)


def rows_of(report: dict[str, Any]) -> dict[tuple[str, str], dict[str, Any]]:
    return {(problem["problem"], row["quantity"]): row for problem in report["problems"] for row in problem["rows"]}


@pytest.mark.parametrize("key", NUMBERS, ids=" ".join)
def test_every_number_of_the_paper_comes_out_to_1e_9(report, key) -> None:
    got = np.array(rows_of(report)[key]["value"], dtype=float)
    expected = np.array(NUMBERS[key], dtype=float)
    assert got.shape == expected.shape
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-9)


def test_every_row_is_checked_here_and_agrees_there(report) -> None:
    rows = rows_of(report)
    known = {key for key in rows if key[0] in {number for number, _ in NUMBERS}}
    assert known == set(NUMBERS)
    assert report["ok"]
    assert all(row["agrees"] and row["difference"] <= 1e-9 for row in rows.values())
    assert all(problem["ok"] for problem in report["problems"])


def test_no_result_is_nan_or_infinite(report) -> None:
    json.dumps(report, allow_nan=False)


def test_every_result_names_a_public_function(report) -> None:
    for row in rows_of(report).values():
        if row["function"] != "sympy":
            thing: Any = importlib.import_module("nao_kin")
            for name in row["function"].split("."):
                assert not name.startswith("_")
                thing = getattr(thing, name)
            assert callable(thing) or name.isupper()  # a function, or a public table


def test_every_erratum_is_stated_beside_the_right_value_and_refuted(report) -> None:
    errata = [erratum for problem in report["problems"] for erratum in problem["errata"]]
    assert [erratum["where"] for erratum in errata] == ERRATA
    for erratum in errata:
        assert erratum["refuted"] is True
        assert erratum["printed"]
        assert erratum["right"]
        assert erratum["evidence"]


def test_the_printed_second_solution_of_problem_5_is_refuted(report) -> None:
    erratum = next(e for problem in report["problems"] for e in problem["errata"] if e["where"] == "problem 5")
    assert "(150°, 120°, 150°)" in erratum["printed"]
    assert "(−150°, 120°, −150°)" in erratum["right"]
    assert "0.5 away" in erratum["evidence"]

    def rpy(roll: float, pitch: float, yaw: float) -> np.ndarray:
        (cr, cp, cy), (sr, sp, sy) = np.cos(np.deg2rad([roll, pitch, yaw])), np.sin(np.deg2rad([roll, pitch, yaw]))
        return np.array(
            [
                [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                [-sp, cp * sr, cp * cr],
            ]
        )

    Q = [
        [S3 / 4, -S3 / 4 + 3 / 8, 1 / 4 + 3 * S3 / 8],
        [1 / 4, 3 / 4 + S3 / 8, -S3 / 4 + 3 / 8],
        [-S3 / 2, 1 / 4, S3 / 4],
    ]
    np.testing.assert_allclose(rpy(-150, 120, -150), Q, rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.abs(rpy(150, 120, 150) - Q).max(), 0.5, rtol=0, atol=1e-15)


def test_the_page_of_the_documentation_names_every_function_used_and_every_erratum(report) -> None:
    page = (SCRIPTS.parent / "docs" / "paper.md").read_text(encoding="utf-8")
    for row in rows_of(report).values():
        assert row["function"] == "sympy" or f"`{row['function']}`" in page
    for problem in report["problems"]:
        for erratum in problem["errata"]:
            assert f"| {erratum['where']} |" in page


def test_the_example_on_the_page_of_the_documentation_runs(capsys) -> None:
    page = (SCRIPTS.parent / "docs" / "paper.md").read_text(encoding="utf-8")
    exec(page.split("```python\n")[1].split("```")[0], {})
    assert float(capsys.readouterr().out) < 5e-15


def test_the_text_report_flags_each_erratum_inside_its_problem(script, capsys) -> None:
    assert script.main([]) == 0
    output = capsys.readouterr().out
    sections = output.split("\nProblem ")
    fifth = next(section for section in sections if section.startswith("5:"))
    assert "! problem 5\n" in fifth
    assert "(150°, 120°, 150°)" in fifth
    assert output.count("\n! ") >= len(ERRATA)
    assert "✗" not in output


def test_without_sympy_the_script_says_so_and_carries_on(script, capsys, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "sympy", None)
    assert script.main(["--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    notes = {problem["problem"]: " ".join(problem["notes"]) for problem in report["problems"]}
    for number in ("4", "8"):
        assert "sympy is not installed" in notes[number]
    assert set(NUMBERS) - set(rows_of(report)) == {
        key for key in NUMBERS if key[1].endswith(("for all t", "for all u, v"))
    }


def test_a_wrong_number_or_an_erratum_that_holds_makes_the_script_fail(script, capsys, monkeypatch) -> None:
    paper = importlib.import_module("paper")
    wrong = paper.Problem("99", "wrong", rows=(paper.Row("q", "f", [1.0, 2.0], [1.0, 2.0 + 2e-9]),))
    broken = paper.Problem("98", "broken", rows=(paper.Row("q", "f", [float("nan")], [0.0]),))
    misshapen = paper.Problem("97", "misshapen", rows=(paper.Row("q", "f", [0.0], [0.0, 0.0]),))
    holds = paper.Problem("96", "holds", rows=(), errata=(paper.Erratum("w", "p", "r", "e", refuted=False),))
    for problem in (wrong, broken, misshapen, holds):
        assert not problem.ok
    monkeypatch.setattr(script, "PROBLEMS", (lambda: wrong, lambda: holds))
    assert script.main([]) == 1
    output = capsys.readouterr().out
    assert "✗ q" in output
    assert "✗ not refuted" in output
    assert script.main(["--json"]) == 1
    assert json.loads(capsys.readouterr().out)["ok"] is False


def test_help_says_what_the_script_does(script, capsys) -> None:
    with pytest.raises(SystemExit) as stop:
        script.main(["--help"])
    assert stop.value.code == 0
    assert "--json" in capsys.readouterr().out
