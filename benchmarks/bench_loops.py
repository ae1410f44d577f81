"""Measure the time per configuration in batches: limits, conversion by names, typed models, clips of the viewer.

Poses, Jacobians and centres of mass have a benchmark of their own. Every row is the best of several runs, in
microseconds of processor time per configuration, which other programs disturb less than elapsed time. The limit of each
row is 5 µs, at all counts.

Example:
    python benchmarks/bench_loops.py
    python benchmarks/bench_loops.py --counts 1000000 --json
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
import timeit
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import nao_kin as nk
from nao_kin.crosscheck.samples import sample_configurations
from nao_kin.errors import NaoKinWarning

LIMIT = 5.0  # µs per configuration
COUNTS = (10_000, 100_000)
Call = Callable[[], object]


def calls(nao: nk.NaoModel, count: int, folder: Path) -> dict[str, Call]:
    """Return the timed calls by name, for `count` configurations."""
    rng = np.random.default_rng(0)
    inside = nao.random(rng, count)
    beyond = rng.uniform(-2.0, 2.0, inside.shape)
    rare = inside.copy()
    rare[::100] = beyond[::100]
    head = nao.coupled_limits[0]
    yaw = inside[:, nao.joint_names.index(head.of)]
    angles, body = nao.angles(inside), nao.to_body(inside)
    typed, dropped = nk.joints.MultiDofModel(nao), nk.joints.MultiDofModel(nao, intermediate="drop")
    q_typed, q_dropped = typed.from_q(inside), dropped.from_q(inside)
    viewer, page = nk.Viewer(nao), folder / "clip.html"
    viewer.animate(inside)
    return {
        "CoupledLimit.range": lambda: head.range(yaw),
        "within_limits": lambda: nao.within_limits(beyond),
        "within_limits, per joint": lambda: nao.within_limits(beyond, per_joint=True),
        "check_limits": lambda: nao.check_limits(inside),
        "limit_violations, 1 in 100 outside": lambda: nao.limit_violations(rare),
        "clamp": lambda: nao.clamp(beyond),
        "random": lambda: nao.random(0, count),
        "configuration": lambda: nao.configuration(angles),
        "configuration, clamped": lambda: nao.configuration(angles, limits="clamp"),
        "angles": lambda: nao.angles(inside),
        "to_body": lambda: nao.to_body(inside),
        "from_body": lambda: nao.from_body(body),
        "typed from_q": lambda: typed.from_q(inside),
        "typed to_q": lambda: typed.to_q(q_typed),
        "typed to_q, with a reference": lambda: typed.to_q(q_typed, near=inside),
        "typed ball_angles": lambda: typed.ball_angles(q_typed, "LHipRoll"),
        "typed from_q, links dropped": lambda: dropped.from_q(inside),
        "typed to_q, links dropped": lambda: dropped.to_q(q_dropped),
        "crosscheck samples": lambda: sample_configurations(nao, count, 0),
        "viewer animate": lambda: viewer.animate(inside),
        "viewer animate, outside the limits": lambda: viewer.animate(beyond),
        "viewer save_html": lambda: viewer.save_html(page, overwrite=True),
    }


def measure(counts: tuple[int, ...], rounds: int) -> dict[str, dict[str, Any]]:
    """Return processor time per configuration [µs] by call and count, and whether each call is below the limit."""
    nao = nk.load_nao()
    times: dict[str, dict[str, float]] = {}
    for count in counts:
        with tempfile.TemporaryDirectory() as folder:
            for name, call in calls(nao, count, Path(folder)).items():
                best = min(timeit.repeat(call, timer=time.process_time, number=1, repeat=rounds))
                times.setdefault(name, {})[str(count)] = round(best / count * 1e6, 3)
    return {
        name: {"us_per_configuration": row, "limit": LIMIT, "met": max(row.values()) <= LIMIT}
        for name, row in times.items()
    }


def table(figures: dict[str, dict[str, Any]], counts: tuple[int, ...]) -> str:
    """Return the figures as lines of text."""
    width = max(map(len, figures))
    lines = [f"{'µs per configuration, N =':{width}}" + "".join(f"{count:>10}" for count in counts)]
    for name, figure in figures.items():
        row = "".join(f"{time:10.3f}" for time in figure["us_per_configuration"].values())
        lines.append(f"{name:{width}}{row}   {'met' if figure['met'] else f'above {LIMIT:g}'}")
    return "\n".join(lines)


def main() -> int:
    """Print the figures; return 1 if one exceeds the limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counts", type=int, nargs="+", default=COUNTS, help="batch sizes (default 10000 100000)")
    parser.add_argument("--rounds", type=int, default=5, help="runs of each call; the best one is used (default 5)")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    arguments = parser.parse_args()
    counts = tuple(arguments.counts)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NaoKinWarning)  # configurations outside the limits are intended here
        figures = measure(counts, arguments.rounds)
    print(json.dumps(figures, indent=2) if arguments.json else table(figures, counts))
    return 0 if all(figure["met"] for figure in figures.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
