"""Draw the picture of `bench_batch.py`: cost by number of configurations, of frames, and of threads."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from batch_contenders import answer_shape
from numpy.typing import NDArray

import nao_kin as nk

matplotlib.use("svg")
from matplotlib import pyplot

if TYPE_CHECKING:
    from bench_batch import Timing

ORDER = ("Pinocchio loop", "Pinocchio strided", "NumPy", "MuJoCo", "pytorch_kinematics", "JAX")
COLOURS = {
    "Pinocchio loop": "#9aa0a6",
    "Pinocchio strided": "#5f6368",
    "NumPy": "#c58af9",
    "MuJoCo": "#f29900",
    "pytorch_kinematics": "#e8710a",
    "JAX": "#34a853",
    "nao_kin": "#1a73e8",
    "nao_kin, all cores": "#0b3d91",
    "nao_kin float32": "#8ab4f8",
}


def draw(robot: nk.RobotModel, timings: Sequence[Timing], path: str) -> None:
    """Draw the timings of one robot, and measure the values of the other two panels."""
    from bench_batch import best_call, empty_like_results

    style = {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "svg.hashsalt": "nao_kin"}
    with pyplot.rc_context(style):
        figure, (left, middle, right) = pyplot.subplots(1, 3, figsize=(12, 3.8), layout="constrained")
        _counts(left, [timing for timing in timings if timing.question == "effectors"])
        _frames(middle, robot, best_call, empty_like_results)
        _threads(right, robot, best_call)
        figure.savefig(path, metadata={"Date": None})
        pyplot.close(figure)


def _counts(axes: Any, timings: Sequence[Timing]) -> None:
    for name in dict.fromkeys(timing.contender for timing in timings):
        here = sorted((t.count, t.nanoseconds) for t in timings if t.contender == name)
        width = 2.2 if name.startswith("nao_kin") else 1.4
        axes.loglog(*zip(*here, strict=True), "o-", color=COLOURS[name], linewidth=width, markersize=4, label=name)
    axes.set(xlabel="configurations in a batch", ylabel="ns a configuration", title="five effectors")
    axes.set_ylim(top=1e9)  # room for the names
    axes.legend(frameon=False, fontsize=7.5, ncols=2, loc="upper right")
    axes.grid(alpha=0.25)


def _frames(axes: Any, robot: nk.RobotModel, best_call: Callable[..., float], empty: Callable[..., Any]) -> None:
    q = robot.random(0, 10_000)
    counts = [1, 2, 5, 10, 20, 40, 80, len(robot.link_names)]
    for dtype, colour in ((np.float64, COLOURS["nao_kin"]), (np.float32, COLOURS["nao_kin float32"])):
        costs = []
        for count in counts:
            frames = list(robot.link_names[:: max(1, len(robot.link_names) // count)][:count])
            out = robot.fk(q, frames, dtype=dtype, threads=1)
            call = partial(robot.fk, q, frames, out=out, threads=1)
            costs.append(1e9 * min(best_call(call) for _ in range(3)) / len(q))
        axes.plot(counts, costs, "o-", color=colour, markersize=4, label=np.dtype(dtype).name)
    copied = empty(robot, q, answer_shape(robot, "links"))
    source = np.ones_like(copied)
    cost = 1e9 * min(best_call(lambda: np.copyto(copied, source)) for _ in range(5)) / len(q)
    axes.plot([0, counts[-1]], [0, cost], "--", color="#9aa0a6", label="np.copyto of as much, float64")
    axes.set(xlabel="frames", ylabel="ns a configuration", title="10 000 configurations, one thread", ylim=(0, None))
    axes.legend(frameon=False, fontsize=7.5)
    axes.grid(alpha=0.25)


def _threads(axes: Any, robot: nk.RobotModel, best_call: Callable[..., float]) -> None:
    q = robot.random(0, 1_000_000)
    threads = list(range(1, (os.cpu_count() or 1) + 1))
    questions = {
        "centre of mass": lambda n, out: robot.com(q, out=out, threads=n),
        "one hand, position": lambda n, out: robot.position(q, "LArm", out=out, threads=n),
        "five effectors": lambda n, out: robot.fk(q, list(robot.semantics.end_effectors), out=out, threads=n),
    }
    for name, ask in questions.items():
        out: NDArray[Any] = ask(1, None)  # type: ignore[no-untyped-call]
        costs = [min(best_call(partial(ask, k, out)) for _ in range(3)) for k in threads]
        axes.plot(threads, [costs[0] / cost for cost in costs], "o-", markersize=4, label=name)
    axes.plot(threads, threads, "--", color="#9aa0a6", label="as many times as fast")
    axes.set(xlabel="threads", ylabel="times as fast as one", title="a million configurations", xticks=threads)
    axes.legend(frameon=False, fontsize=7.5)
    axes.grid(alpha=0.25)
