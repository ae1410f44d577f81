"""Every benchmark runs, on little: its figures are not checked, because the tests run at the same time."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"

pytestmark = pytest.mark.full

# The smallest arguments of each benchmark.
LITTLE = {
    "bench_batch": "--counts 40 --questions links --robots nao --rounds 1",
    "bench_calibration": "--robots 1",
    "bench_collisions": "--configurations 200 --verdicts 20 --rounds 1",
    "bench_fk": "--rounds 1",
    "bench_ik": "--targets 50 --rounds 1",
    "bench_ik_numeric": "--targets 4 --rounds 1 --robots nao",
    "bench_imitation": "--frames 60 --rounds 1",
    "bench_stream": "--rows 500 1000 --rounds 1",
    "bench_viewer": "--rounds 1 --seconds 0.2",
    "bench_whole_body": "--poses 2 --rounds 1",
}


def test_every_benchmark_is_run() -> None:
    assert set(LITTLE) == {path.stem for path in BENCHMARKS.glob("bench_*.py")}


@pytest.mark.parametrize("name", LITTLE)
def test_a_benchmark_runs_to_its_end(name: str) -> None:
    command = [sys.executable, str(BENCHMARKS / f"{name}.py"), *LITTLE[name].split()]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert "Traceback" not in done.stderr, done.stderr
    assert done.returncode in (0, 1), done.stderr  # 1: a limit is exceeded
    assert done.stdout
