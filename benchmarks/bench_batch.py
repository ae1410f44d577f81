"""Compare batches of this library with loops over Pinocchio, with NumPy, and with other libraries that are installed.

All contenders compute the same quantities for the same configurations in one run, in turns, into existing arrays, and
must agree. Loops get at most 10 000 configurations, because their cost per configuration is constant. Times are per
configuration, the best of several rounds; the targets are ratios at 10 000 configurations and one thread.

Example:
    python benchmarks/bench_batch.py
    python benchmarks/bench_batch.py --counts 100 10000 --robots nao --json
    python benchmarks/bench_batch.py --plot docs/images/batch.svg
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
import tracemalloc
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from batch_contenders import (
    QUESTIONS,
    Answer,
    answer_shape,
    frames_of,
    installed_others,
    numpy_arrays,
    ours,
    pinocchio_loop,
    pinocchio_strided,
)
from numpy.typing import NDArray

import nao_kin as nk

COUNTS = (1, 100, 10_000, 1_000_000)
LOOPED = 10_000
MAX_BYTES = 4 << 30
JUDGED = 10_000  # the number of configurations at which ratios are compared with their targets

LOOP, STRIDED, ONE, ALL, SINGLE = (
    "Pinocchio loop",
    "Pinocchio strided",
    "nao_kin",
    "nao_kin, all cores",
    "nao_kin float32",
)
# Quantity and contender → the least factor by which this library must be faster.
FASTER = {
    ("effectors", LOOP): 80.0,
    ("effectors", STRIDED): 30.0,
    ("joints", STRIDED): 14.0,
    ("com", LOOP): 20.0,
    ("jacobian", LOOP): 8.0,
}
BANDWIDTH, CORES, HALF, MEMORY = 0.6, 1.7, 1.5, 1.1


@dataclass(frozen=True)
class Timing:
    """The time of one contender.

    Attributes:
        robot, question, count, contender: the measured case.
        nanoseconds: for each configuration.
        error: largest difference from Pinocchio's results.
    """

    robot: str
    question: str
    count: int
    contender: str
    nanoseconds: float
    error: float


@dataclass(frozen=True)
class Verdict:
    """A target, and the measured value."""

    what: str
    reached: float
    wanted: float
    met: bool


def contenders(robot: nk.RobotModel, question: str) -> dict[str, Answer]:
    """Return the contenders for a quantity, by name."""
    cores = os.cpu_count() or 1
    found = {LOOP: pinocchio_loop(robot, question)}
    if question in ("effectors", "joints", "links"):
        found[STRIDED] = pinocchio_strided(robot, question)
        if question != "links":
            found["NumPy"] = numpy_arrays(robot, question)
        for name, make in installed_others().items():
            try:
                found[name] = make(robot, question)
            except Exception as error:  # another library may fail in any way for a robot
                print(f"{name} does not take {robot.name}: {error}".split("\n")[0], file=sys.stderr)
    return found | {ONE: ours(robot, question, 1), ALL: ours(robot, question, cores), SINGLE: ours(robot, question, 1)}


def measure(robot: nk.RobotModel, question: str, count: int, rounds: int) -> list[Timing]:
    """Time all contenders in turns."""
    shape = answer_shape(robot, question)
    size = 8 * int(np.prod(shape))
    rows = min(count, MAX_BYTES // size)
    q = robot.random(0, rows)
    memory = empty_like_results(robot, q, shape)
    expected = np.empty((min(rows, 200), *shape))
    runs, errors = {}, {}
    for name, answer in contenders(robot, question).items():
        mine = q if name.startswith("nao_kin") else q[:LOOPED]
        out: NDArray[Any] = memory[: len(mine)]
        if name == SINGLE:
            out = memory.reshape(-1).view(np.float32)[: out.size].reshape(out.shape)
        try:
            answer(mine, out)
        except Exception as error:  # as above
            print(f"{name} does not answer for {robot.name}: {error}".split("\n")[0], file=sys.stderr)
            continue
        if name == LOOP:
            expected[...] = out[: len(expected)]
        errors[name] = float(np.abs(out[: len(expected)] - expected).max())
        # The other libraries read the file themselves, and may store its numbers in single precision.
        if errors[name] > (1e-12 if name in (LOOP, STRIDED, "NumPy", ONE, ALL) else 2e-6):
            raise SystemExit(f"{name} gives other {question} for {robot.name}: off by {errors[name]:.1e}")
        runs[name] = (answer, mine, out)
    best = dict.fromkeys(runs, np.inf)
    for _ in range(rounds):
        for name, (answer, mine, out) in runs.items():
            best[name] = min(best[name], best_call(lambda a=answer, q=mine, o=out: a(q, o)) / len(mine))  # type: ignore[misc]
    return [Timing(robot.name, question, count, name, round(1e9 * best[name], 2), errors[name]) for name in runs]


def best_call(call: Callable[[], None]) -> float:
    """Return the time of the quickest call [s], of those that fit into a twentieth of a second, but of at least two."""
    best, calls, started = np.inf, 0, time.perf_counter()
    before = started
    while calls < 2 or before - started < 0.05:
        call()
        now = time.perf_counter()
        best, before, calls = min(best, now - before), now, calls + 1
    return float(best)


def empty_like_results(robot: nk.RobotModel, q: NDArray[np.float64], shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Allocate an array as the library does for its results: aligned for vector instructions."""
    room = nk._kernels.aligned_empty(len(q) * int(np.prod(shape)), np.dtype(np.float64))
    room.fill(0.0)
    return room.reshape(len(q), *shape)


def bandwidth(robot: nk.RobotModel, rounds: int) -> tuple[float, float]:
    """Return bytes per second of writing the poses of all links, and of a copy into the same array."""
    q = robot.random(0, JUDGED)
    out = empty_like_results(robot, q, answer_shape(robot, "links"))
    source = np.ones_like(out)
    answer = ours(robot, "links", 1)
    mine = copy = np.inf
    for _ in range(3 * rounds):
        started = time.perf_counter()
        answer(q, out)
        mine = min(mine, time.perf_counter() - started)
        started = time.perf_counter()
        np.copyto(out, source)
        copy = min(copy, time.perf_counter() - started)
    return out.nbytes / mine, out.nbytes / copy


def memory_ratio(robot: nk.RobotModel) -> float:
    """Return the peak memory for the effectors of a million configurations, divided by the size of the result."""
    q = robot.random(0, 1_000_000)
    frames = frames_of(robot, "effectors")
    robot.fk(q[:100], frames, threads=1)
    tracemalloc.start()
    result = robot.fk(q, frames)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak / result.nbytes


def verdicts(timings: Sequence[Timing], bytes_a_second: tuple[float, float] | None, memory: float) -> list[Verdict]:
    """Return the targets and the measured values, for the NAO."""
    table: Mapping[tuple[str, int, str], float] = {
        (t.question, t.count, t.contender): t.nanoseconds for t in timings if t.robot.startswith("nao")
    }
    found = []

    def judge(what: str, reached: float, wanted: float, *, at_most: bool = False) -> None:
        met = reached <= wanted if at_most else reached >= wanted
        found.append(Verdict(what, round(reached, 2), wanted, met))

    for (question, other), wanted in FASTER.items():
        if (question, JUDGED, other) in table:
            judge(f"{question}: × {other}", table[question, JUDGED, other] / table[question, JUDGED, ONE], wanted)
    if ("effectors", JUDGED, SINGLE) in table:
        judge(
            "effectors: float32 × float64", table["effectors", JUDGED, ONE] / table["effectors", JUDGED, SINGLE], HALF
        )
    if ("com", 1_000_000, ALL) in table:
        judge("com, a million: all cores × one", table["com", 1_000_000, ONE] / table["com", 1_000_000, ALL], CORES)
    if bytes_a_second:
        judge("links: bytes a second / np.copyto", bytes_a_second[0] / bytes_a_second[1], BANDWIDTH)
    judge("effectors, a million: peak memory / result", memory, MEMORY, at_most=True)
    return found


def print_timings(timings: Sequence[Timing]) -> None:
    """Print a table for each robot and quantity: contenders by counts, in nanoseconds per configuration."""
    counts = sorted({t.count for t in timings})
    for robot in dict.fromkeys(t.robot for t in timings):
        for question in dict.fromkeys(t.question for t in timings):
            here = [t for t in timings if (t.robot, t.question) == (robot, question)]
            if not here:
                continue
            print(f"\n{robot}, {question} [ns a configuration]")
            print(f"{'':24}" + "".join(f"{count:>12,}" for count in counts))
            for name in dict.fromkeys(t.contender for t in here):
                by_count = {t.count: t.nanoseconds for t in here if t.contender == name}
                print(f"{name:24}" + "".join(f"{by_count.get(count, float('nan')):12,.1f}" for count in counts))


def main() -> int:
    """Print the timings and verdicts; return 1 if a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counts", type=int, nargs="+", default=list(COUNTS), metavar="N")
    parser.add_argument("--questions", nargs="+", default=list(QUESTIONS), choices=QUESTIONS)
    parser.add_argument("--robots", nargs="+", default=["nao", "romeo"], help="nao, or a name of example-robot-data")
    parser.add_argument("--rounds", type=int, default=7, help="turns of each contender (default 7)")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    parser.add_argument("--plot", metavar="FILE.svg", help="draw cost against count, frames and threads")
    options = parser.parse_args()
    precisions = "double", "double to single", "single"
    nk.warm_up([f"batch kernel, {precision} precision" for precision in precisions])
    timings: list[Timing] = []
    robots = {name: nk.load_nao() if name == "nao" else nk.load_robot(name) for name in options.robots}
    for robot in robots.values():
        for question in options.questions:
            for count in options.counts:
                timings += measure(robot, question, count, options.rounds)
                print(f"{robot.name}, {question}, {count:,} done", file=sys.stderr)
    nao = robots.get("nao") or nk.load_nao()
    bytes_a_second = bandwidth(nao, options.rounds) if "links" in options.questions else None
    found = verdicts(timings, bytes_a_second, memory_ratio(nao))
    if options.json:
        document: dict[str, Any] = {
            "timings": [asdict(timing) for timing in timings],
            "verdicts": [asdict(verdict) for verdict in found],
        }
        print(json.dumps(document, indent=2))
    else:
        print_timings(timings)
        print()
        for verdict in found:
            print(
                f"{'met' if verdict.met else 'NOT MET':8} {verdict.what:48} {verdict.reached:8.2f}  ({verdict.wanted})"
            )
    if options.plot:
        from batch_plot import draw

        draw(nao, [timing for timing in timings if timing.robot == nao.name], options.plot)
    return 0 if all(verdict.met for verdict in found) else 1


if __name__ == "__main__":
    raise SystemExit(main())
