"""Measure the conversion of files of configurations to files of poses: total time, and whether memory stays constant.

The command runs in a process of its own, as users run it, with kernels that `nao-kin warmup` has compiled.

Example:
    python benchmarks/bench_stream.py
    python benchmarks/bench_stream.py --rows 1000000 10000000
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import nao_kin as nk

# The limit for the poses of two feet from 200 000 rows of CSV, from the start to the complete CSV file [s].
ROWS, LIMIT_SECONDS = 200_000, 2.5
# The limit of the peak memory for the longest file, divided by that for the shortest.
LIMIT_GROWTH = 1.15


def write_csv(path: Path, rows: int) -> None:
    """Write random configurations as a log."""
    nao = nk.load_nao()
    with path.open("w", encoding="utf-8") as file:
        file.write(",".join(nao.joint_names) + "\n")
        for start in range(0, rows, 100_000):
            np.savetxt(file, nao.random(start, min(100_000, rows - start)), delimiter=",", fmt="%.9g")


def run(*arguments: str) -> tuple[float, float]:
    """Run a command, and return its seconds and peak memory [MB]."""
    started = time.perf_counter()
    process = os.posix_spawn(sys.executable, [sys.executable, "-m", "nao_kin", *arguments], dict(os.environ))
    _, status, usage = os.wait4(process, 0)
    if status:
        raise SystemExit(f"nao-kin {' '.join(arguments)} ended with {os.waitstatus_to_exitcode(status)}")
    kilobytes = usage.ru_maxrss / (1024 if sys.platform == "darwin" else 1)
    return time.perf_counter() - started, kilobytes / 1024


def main() -> int:
    """Print the figures as JSON; return 1 if a limit is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, nargs="+", default=[ROWS, 1_000_000], help="lengths of files to compare")
    parser.add_argument("--rounds", type=int, default=5, help="runs of the timed command (default 5)")
    options = parser.parse_args()
    nk.warm_up(["batch kernel, double precision"])
    figures: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        source = folder / "q.csv"
        timed = min(ROWS, *options.rows)
        write_csv(source, timed)
        feet = ("--frame", "LLeg", "--frame", "RLeg")
        for sink in ("poses.csv", "poses.parquet"):
            times = [
                run("fk", str(source), *feet, "--force", "-o", str(folder / sink))[0] for _ in range(options.rounds)
            ]
            figures[f"{timed} rows to {sink} [s]"] = round(min(times), 2)
            if sink == "poses.csv":
                quick = min(times) <= LIMIT_SECONDS
        peaks = []
        for rows in options.rows:
            write_csv(source, rows)
            seconds, megabytes = run("fk", str(source), *feet, "--force", "-o", str(folder / "poses.parquet"))
            figures[f"{rows} rows to Parquet [s]"] = round(seconds, 2)
            figures[f"{rows} rows to Parquet, peak [MB]"] = round(megabytes, 1)
            peaks.append(megabytes)
    growth = max(peaks) / min(peaks)
    figures |= {"limit [s]": LIMIT_SECONDS, "growth of memory": round(growth, 3), "limit of growth": LIMIT_GROWTH}
    figures["met"] = met = quick and growth <= LIMIT_GROWTH
    print(json.dumps(figures, indent=2))
    return 0 if met else 1


if __name__ == "__main__":
    raise SystemExit(main())
