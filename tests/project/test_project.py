"""The project's own files agree with each other: versions, Pythons, faults to plant, the map."""

from __future__ import annotations

import ast
import functools
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "scripts"
PYPROJECT = (ROOT / "pyproject.toml").read_text(encoding="utf-8")

sys.path.insert(0, str(SCRIPTS))
import generate_room_map  # noqa: E402
import lowest_requirements  # noqa: E402
import mutate  # noqa: E402

PROJECT = lowest_requirements.tomllib.loads(PYPROJECT)["project"]


def test_every_dependency_has_a_lower_and_an_upper_bound() -> None:
    for requirement in lowest_requirements.requirements(PROJECT, lowest_requirements.EXTRAS):
        lowest_requirements.lowest(requirement)
    for line in PROJECT["dependencies"]:
        assert "<" in line or ";" in line, line


def test_the_lowest_versions_are_the_bounds_of_the_metadata() -> None:
    project = {
        "name": "house",
        "dependencies": ["a>=1.2,<2", "a>=1.4; python_version >= '3.10'", "b>=7; python_version < '3'", "c==3.5.4"],
        "optional-dependencies": {
            "more": ["d>=6,<7", "house[other]"],
            "other": ["e>=3", "house[more]"],
            "no": ["f>=1"],
        },
    }
    assert lowest_requirements.constraints(project, ["more"]) == ["a==1.4", "c==3.5.4", "d==6", "e==3"]


def test_the_lowest_versions_of_all_that_the_tests_use_are_tried() -> None:
    constrained = {line.split("==")[0] for line in lowest_requirements.constraints(PROJECT)}
    assert {"mujoco", "numba", "xacro", "pyarrow", "dask", "matplotlib", "scipy", "pin"} <= constrained


def test_a_dependency_without_a_lower_bound_is_refused() -> None:
    project = {"name": "house", "dependencies": ["a<2"], "optional-dependencies": {}}
    with pytest.raises(ValueError, match="a<2: a lower bound is missing"):
        lowest_requirements.constraints(project, [])


def test_the_workflows_run_on_pythons_that_the_metadata_names() -> None:
    named = set(re.findall(r"Python :: (3\.\d+)", "\n".join(PROJECT["classifiers"])))
    for workflow in WORKFLOWS:
        for line in re.findall(r"python(?:-version)?: (.*\d.*)", workflow.read_text(encoding="utf-8")):
            assert set(re.findall(r'"(3\.\d+)"', line)) <= named, f"{workflow.name}: {line}"


def test_the_lowest_python_is_the_same_everywhere() -> None:
    assert PROJECT["requires-python"].startswith(">=3.10,")
    assert 'target-version = "py310"' in PYPROJECT


CI = sorted((ROOT / ".ci").iterdir())
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")


def test_make_and_the_hooks_call_what_is_there() -> None:
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    scripts = re.search(r"GENERATED := (.*)\nDRAWN := (.*)", MAKEFILE)
    assert scripts is not None
    named = [f"scripts/{name}.py" for name in " ".join(scripts.groups()).split()]
    for path in [*named, *re.findall(r"(?:scripts|benchmarks)/\w+\.py", MAKEFILE + hooks)]:
        assert (ROOT / path).is_file(), path
    targets = set(re.findall(r"^([a-z-]+)(?: [a-z-]+)*:", MAKEFILE, re.MULTILINE))
    pages = {*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / ".github").rglob("*.*"), *CI}
    for page in pages - {ROOT / "CHANGELOG.md"}:  # which names earlier commands, too
        text = page.read_text(encoding="utf-8")
        for words in re.findall(r"(?:^|`|run: )make (?:-j\d )?((?:[a-z-]+ ?)+)", text, re.MULTILINE):
            assert set(words.split()) <= targets, f"{page.name}: make {words}"
        for name in re.findall(r"(?<![\w/])\.ci/(\w+)", text):
            assert ROOT / ".ci" / name in CI, f"{page.name}: .ci/{name}"


def test_make_help_names_the_commands_for_people() -> None:
    done = subprocess.run(["make", "help"], cwd=ROOT, capture_output=True, text=True, check=True)
    names = re.findall(r"^make ([a-z-]+) +\S", done.stdout, re.MULTILINE)
    assert names == ["help", "demo", "test", "test-all", "docs", "generate", "bench", "clean"]


@pytest.mark.parametrize("target", ["test", "test-all", "test ROOM=ik"])
def test_kernels_are_compiled_before_the_time_of_a_test_is_measured(target: str) -> None:
    done = subprocess.run(["make", "-n", *target.split()], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.index("warm_up(") < done.stdout.index("pytest -n")


def test_every_job_of_continuous_integration_is_run_by_another_or_by_a_workflow() -> None:
    callers = [MAKEFILE, *(path.read_text(encoding="utf-8") for path in (*CI, *WORKFLOWS))]
    for job in CI:
        if job.name != "run":  # called from outside
            assert any(f".ci/{job.name}" in text for text in callers) or f" {job.name}" in MAKEFILE, job.name


def test_every_fault_can_be_planted() -> None:
    wrong = []
    for fault in sorted(mutate.read_faults(), key=lambda fault: fault.path):
        try:
            if fault.path.endswith(".py"):
                _plant(fault, _parsed(fault.path))
            else:  # bundled in test_closed_forms
                mutate.planted(fault)
            wrong += [f"{fault.name}: no {test}" for test in fault.arguments if not _is_there(test)]
        except (mutate.NotPlanted, SyntaxError, ValueError) as error:  # a ValueError for a test file that is not there
            wrong.append(f"{fault.name}: {error}")
        if fault.new == fault.old:
            wrong.append(f"{fault.name} changes nothing")
    assert not wrong


@functools.lru_cache(1)
def _parsed(path: str) -> ast.Module:
    return ast.parse((ROOT / path).read_text(encoding="utf-8"))


def _plant(fault: mutate.Fault, tree: ast.Module) -> None:
    """Plant a fault in a syntax tree, compile the class or function that has it, and restore the tree."""
    old, new = mutate.find(fault, tree)
    part = ast.Module([next(part for part in tree.body if (part.end_lineno or 0) >= old.lineno)], [])
    mutate.replace(part, old, new)
    try:
        compile(part, fault.path, "exec")
    finally:
        mutate.replace(part, new, old)


@functools.cache
def _is_there(test: str) -> bool:
    module, *names = test.split("::")
    source = (ROOT / module).read_text(encoding="utf-8") if (ROOT / module).is_file() else ""
    return bool(source) and all(f"\ndef {name}(" in source for name in names)


def test_faults_have_names_of_their_own() -> None:
    names = [fault.name for fault in mutate.read_faults()]
    assert len(set(names)) == len(names)


@pytest.fixture
def written(tmp_path: Path) -> Callable[[str, str, str, str, str], str]:
    """A function that plants a fault in a source: file name, source, place, old and new text."""

    def write(file: str, source: str, place: str, old: str, new: str) -> str:
        (tmp_path / "web").mkdir(exist_ok=True)
        (tmp_path / "web" / file).write_text(source)
        return mutate.planted(mutate.Fault("it", f"web/{file}", place, old, new, ""), tmp_path)

    return write


SOURCE = """
def f(x):  # a comment
    a = g( x,
           1 )
    return x

class C:
    def f(self, x):
        if x: return x
        return x
"""


def test_a_fault_is_found_by_its_place_however_the_source_is_written(written: Callable[..., str]) -> None:
    plain = mutate.ast.unparse(mutate.ast.parse(SOURCE))
    assert written("a.py", SOURCE, "f", "g(x,1)", "h") == plain.replace("g(x, 1)", "h")
    assert written("a.py", SOURCE, "f", "return x", "pass") == plain.replace("return x", "pass", 1)
    assert written("a.py", SOURCE, "C.f#2", "return x", "return 2").endswith("    return x\n        return 2")
    assert written("a.ts", "f( a,\n  b );  g(a)", "", "f(a, b)", "0") == "0;  g(a)"
    assert written("a.ts", "f(a);  g(a)", "#2", "( a )", "()") == "f(a);  g()"


@pytest.mark.parametrize(
    ("place", "old", "new", "reason"),
    [
        ("f", "no_such_text", "x", "occurs 0 times in web/a.py f, not once"),
        ("C.f", "return x", "pass", "occurs 2 times in web/a.py C.f, not once"),
        ("C.g", "x", "y", "web/a.py has no C.g"),
        ("f", "return x", "a = 1; b = 2", "expected two expressions, or two statements"),
    ],
)
def test_a_fault_that_cannot_be_planted_is_named(
    written: Callable[..., str], place: str, old: str, new: str, reason: str
) -> None:
    with pytest.raises(mutate.NotPlanted, match=f"it: .*{reason}"):
        written("a.py", SOURCE, place, old, new)


def test_rooms_that_import_each_other_are_refused() -> None:
    with pytest.raises(ValueError, match="circle: a, b"):
        generate_room_map.levels({"a": {"b"}, "b": {"a"}, "c": set()})


def test_the_map_leaves_out_arrows_that_follow() -> None:
    arrows = {"top": {"middle", "low"}, "middle": {"low"}, "low": set()}
    assert generate_room_map.reduced(arrows) == {"top": {"middle"}, "middle": {"low"}, "low": set()}
    assert generate_room_map.levels(arrows) == {"low": 0, "middle": 1, "top": 2}


@pytest.mark.parametrize("script", ["lowest_requirements.py", "generate_room_map.py", "measure_tools.py", "mutate.py"])
def test_a_script_says_what_it_does(script: str) -> None:
    done = subprocess.run([sys.executable, str(SCRIPTS / script), "--help"], capture_output=True, text=True, check=True)
    assert "Example:" in done.stdout
