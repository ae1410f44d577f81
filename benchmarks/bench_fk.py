"""Compare forward kinematics with plain Pinocchio: ratios of times, measured in one run.

Example:
    python benchmarks/bench_fk.py
"""

from __future__ import annotations

import argparse
import importlib
import json
import statistics
import subprocess
import sys
import timeit
from collections.abc import Callable

import numpy as np
import pinocchio as pin

import nao_kin as nk

LIMITS = {
    "fk_one_frame": 2.5,
    "fk_all_links": 2.0,
    "one_leg": 2.5,
    "load_nao": 3.0,
    "first_load_nao": 5.0,
    "import_seconds": 0.1,
}
# A small call may take this many times as long as plain Pinocchio, plus this time [µs].
SMALL_TIMES, SMALL_EXTRA = 1.5, 3.0
# Limits for calls without a counterpart in Pinocchio [µs].
MICROSECONDS = {"posture": 10.0, "configuration_of_two": 10.0, "configuration_of_all": 10.0}
EFFECTORS = ["LArm", "RArm", "LLeg", "RLeg", "Head"]


def ratio(ours: Callable[[], object], raw: Callable[[], object], number: int, rounds: int) -> dict[str, float]:
    """Return medians of paired timings [µs] and of their ratio; the two calls alternate, so that load affects both."""
    pairs = []
    for _ in range(rounds):
        pairs.append((timeit.timeit(ours, number=number) / number, timeit.timeit(raw, number=number) / number))
    return {
        "ours_us": round(statistics.median(a for a, _ in pairs) * 1e6, 3),
        "raw_us": round(statistics.median(b for _, b in pairs) * 1e6, 3),
        "ratio": round(statistics.median(a / b for a, b in pairs), 3),
    }


def strided_view(data: pin.Data, count: int) -> np.ndarray:
    """Return all placements of Pinocchio's data as one view, shape (count, 3, 4): the fastest way to read them."""
    return np.lib.stride_tricks.as_strided(data.oMf[0].rotation, (count, 3, 4), (96, 8, 24), writeable=False)


def seconds_to_import(statement: str) -> float:
    """Return the time of an import in a new interpreter [s], measured inside it."""
    code = f"import time; t = time.perf_counter(); {statement}; print(time.perf_counter() - t)"
    return float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)


def measure(rounds: int) -> dict[str, dict[str, float]]:
    """Measure all figures."""
    nao = nk.load_nao()
    model, path = nao.model, str(nao.urdf_path)
    data = model.createData()
    q = nao.posture("StandInit")
    foot = model.getFrameId("LFoot")
    links = np.array([model.getFrameId(name) for name in nao.link_names])
    placements = strided_view(data, model.nframes)

    def raw_one() -> np.ndarray:
        pin.framesForwardKinematics(model, data, q)
        homogeneous: np.ndarray = data.oMf[foot].homogeneous
        return homogeneous

    def raw_all() -> np.ndarray:
        pin.framesForwardKinematics(model, data, q)
        rows: np.ndarray = placements[links]
        return rows

    assert np.array_equal(raw_one(), nao.fk(q, "LFoot"))
    assert np.array_equal(raw_all(), nao.fk(q)[:, :3])
    imports = [
        seconds_to_import("import pinocchio, nao_kin; nao_kin.load_nao") - seconds_to_import("import pinocchio")
        for _ in range(max(3, rounds // 3))
    ]
    T_leg = nao.fk(q, "LLeg")
    nk.warm_up(["ik kernel, legs"])
    read = importlib.import_module("nao_kin.robot.urdf").read_urdf
    return {
        "fk_one_frame": ratio(lambda: nao.fk(q, "LFoot"), raw_one, 4000, rounds),
        "fk_all_links": ratio(lambda: nao.fk(q), raw_all, 4000, rounds),
        # Inverse kinematics of a leg with all checks, in terms of forward kinematics.
        "one_leg": ratio(lambda: nk.ik.leg(nao, "L", T_leg), lambda: nao.fk(q, "LLeg"), 1000, rounds),
        "load_nao": ratio(nk.load_nao, lambda: pin.buildModelFromUrdf(path, mimic=True), 10, rounds),
        # The file of a NAO version is read only once in a process; other files are read each time.
        "first_load_nao": ratio(
            lambda: nk.RobotModel(read(path)), lambda: pin.buildModelFromUrdf(path, mimic=True), 10, rounds
        ),
        "import_seconds": {"added": round(statistics.median(imports), 4)},
    }


def measure_small(rounds: int) -> dict[str, dict[str, float | bool]]:
    """Measure the shortest calls for one configuration, each with the plain Pinocchio calls for the same result."""
    nao = nk.load_nao()
    model, q = nao.model, nao.posture("StandInit")
    data = model.createData()
    hand, foot = model.getFrameId("LArm"), model.getFrameId("LLeg")
    ids = [model.getFrameId(name) for name in EFFECTORS]
    world_aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

    def raw_five() -> list[np.ndarray]:
        pin.framesForwardKinematics(model, data, q)
        return [data.oMf[index].homogeneous for index in ids]

    def raw_relative() -> np.ndarray:
        pin.framesForwardKinematics(model, data, q)
        relative: np.ndarray = data.oMf[foot].actInv(data.oMf[hand]).homogeneous
        return relative

    figures: dict[str, dict[str, float | bool]] = {}
    for name, ours, raw in (
        ("five_frames", lambda: nao.fk(q, EFFECTORS), raw_five),
        ("one_frame_in_another", lambda: nao.fk(q, "LArm", reference="LLeg"), raw_relative),
        (
            "jacobian",
            lambda: nao.jacobian(q, "LArm"),
            lambda: pin.computeFrameJacobian(model, data, q, hand, world_aligned),
        ),
        ("centre_of_mass", lambda: nao.com(q), lambda: pin.centerOfMass(model, data, q)),
    ):
        figure = ratio(ours, raw, 4000, rounds)
        limit = round(SMALL_TIMES * figure["raw_us"] + SMALL_EXTRA, 3)
        figures[name] = {**figure, "limit_us": limit, "met": figure["ours_us"] <= limit}
    angles = nao.angles(q)
    for name, call in (
        ("posture", lambda: nao.posture("StandInit")),
        ("configuration_of_two", lambda: nao.configuration({"LShoulderPitch": 1.2, "LElbowRoll": -0.8})),
        ("configuration_of_all", lambda: nao.configuration(angles)),
    ):
        median = statistics.median(timeit.timeit(call, number=4000) / 4000 * 1e6 for _ in range(rounds))
        figures[name] = {
            "ours_us": round(median, 3),
            "limit_us": MICROSECONDS[name],
            "met": median <= MICROSECONDS[name],
        }
    return figures


def main() -> int:
    """Print the figures as JSON; return 1 if one exceeds its limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=15, help="paired timings of each figure (default 15)")
    rounds = parser.parse_args().rounds
    figures = measure(rounds)
    verdicts: dict[str, dict[str, float | bool]] = {
        name: {**figure, "limit": LIMITS[name], "met": next(reversed(figure.values())) <= LIMITS[name]}
        for name, figure in figures.items()
    } | measure_small(rounds)
    print(json.dumps(verdicts, indent=2))
    return 0 if all(verdict["met"] for verdict in verdicts.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
