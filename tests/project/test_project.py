"""The project's own files agree with each other: versions, Pythons, faults to plant, the map."""

from __future__ import annotations

import re
import subprocess
import sys
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
    for workflow in (ROOT / ".github" / "workflows").glob("*.yml"):
        for line in re.findall(r"python(?:-version)?: (.*\d.*)", workflow.read_text(encoding="utf-8")):
            assert set(re.findall(r'"(3\.\d+)"', line)) <= named, f"{workflow.name}: {line}"


def test_the_lowest_python_is_the_same_everywhere() -> None:
    assert PROJECT["requires-python"].startswith(">=3.10,")
    assert 'target-version = "py310"' in PYPROJECT
    assert 'python_version = "3.10"' in PYPROJECT


def test_make_and_the_hooks_call_what_is_there() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    for path in re.findall(r"(?:scripts|benchmarks)/\w+\.py", makefile + hooks):
        assert (ROOT / path).is_file(), path
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE))
    for page in (
        *ROOT.glob("*.md"),
        *(ROOT / "docs").glob("*.md"),
        *(ROOT / ".github").rglob("*.*"),
        ROOT / ".ci" / "run",
        ROOT / ".ci" / "slow",
    ):
        for words in re.findall(r"(?:^|`|run: )make ((?:[a-z-]+ ?)+)", page.read_text(encoding="utf-8"), re.MULTILINE):
            assert set(words.split()) <= targets, f"{page.name}: make {words}"


@pytest.mark.parametrize("target", ["quick", "unit", "test-full", "test-lowest", "coverage"])
def test_kernels_are_compiled_before_the_time_of_a_test_is_measured(target: str) -> None:
    done = subprocess.run(["make", "-n", target], cwd=ROOT, capture_output=True, text=True, check=True)
    kernels = min(done.stdout.find(words) % len(done.stdout) for words in ("warm_up(", "nao-kin warmup"))
    assert kernels < done.stdout.index("pytest")


def test_every_mutation_can_be_planted() -> None:
    wrong = []
    for mutation in mutate.MUTATIONS:
        try:
            source = mutate.planted(mutation)
            if mutation.file.endswith(".py"):  # those of the page are tried in test_viewer_closed_forms
                compile(source, mutation.file, "exec")
        except (mutate.NotPlanted, SyntaxError) as error:
            wrong.append(f"{mutation.name}: {error}")
        wrong += [f"{mutation.name}: no {test}" for test in mutation.tests if not _is_there(test)]
        if mutation.new == mutation.old:
            wrong.append(f"{mutation.name} changes nothing")
    assert not wrong


def _is_there(test: str) -> bool:
    module, *names = test.split("::")
    source = (ROOT / module).read_text(encoding="utf-8") if (ROOT / module).is_file() else ""
    return bool(source) and all(f"\ndef {name}(" in source for name in names)


def test_mutations_have_names_of_their_own() -> None:
    names = [mutation.name for mutation in mutate.MUTATIONS]
    assert len(set(names)) == len(names)


def test_a_mutation_whose_text_is_gone_is_named() -> None:
    gone = mutate.Mutation("gone", "nao_kin/__init__.py", "no such text", "", ())
    with pytest.raises(mutate.NotPlanted, match=r"gone: its text occurs 0 times in nao_kin/__init__\.py"):
        mutate.planted(gone)


def test_the_map_of_the_rooms_is_in_step() -> None:
    assert generate_room_map.main(["--check"]) == 0


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
