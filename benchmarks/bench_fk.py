"""Forward kinematics beside plain Pinocchio, as ratios measured side by side in one run.

Example:
    python benchmarks/bench_fk.py
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import timeit
from collections.abc import Callable

import numpy as np
import pinocchio as pin

import nao_kin as nk

LIMITS = {"fk_one_frame": 2.5, "fk_all_links": 2.0, "load_nao": 3.0, "import_seconds": 0.1}


def ratio(ours: Callable[[], object], raw: Callable[[], object], number: int, rounds: int) -> dict[str, float]:
    """Medians of paired timings [µs] and of their ratio; the two alternate, so that both meet the same machine."""
    pairs = []
    for _ in range(rounds):
        pairs.append((timeit.timeit(ours, number=number) / number, timeit.timeit(raw, number=number) / number))
    return {
        "ours_us": round(statistics.median(a for a, _ in pairs) * 1e6, 3),
        "raw_us": round(statistics.median(b for _, b in pairs) * 1e6, 3),
        "ratio": round(statistics.median(a / b for a, b in pairs), 3),
    }


def strided_view(data: pin.Data, count: int) -> np.ndarray:
    """All placements of Pinocchio's data as one (count, 3, 4) view, the fastest plain read-out there is."""
    return np.lib.stride_tricks.as_strided(data.oMf[0].rotation, (count, 3, 4), (96, 8, 24), writeable=False)


def seconds_to_import(statement: str) -> float:
    """Time of an import in a fresh interpreter [s], measured inside it."""
    code = f"import time; t = time.perf_counter(); {statement}; print(time.perf_counter() - t)"
    return float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)


def measure(rounds: int) -> dict[str, dict[str, float]]:
    """All figures."""
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
    return {
        "fk_one_frame": ratio(lambda: nao.fk(q, "LFoot"), raw_one, 4000, rounds),
        "fk_all_links": ratio(lambda: nao.fk(q), raw_all, 4000, rounds),
        "load_nao": ratio(nk.load_nao, lambda: pin.buildModelFromUrdf(path, mimic=True), 10, rounds),
        "import_seconds": {"added": round(statistics.median(imports), 4)},
    }


def main() -> int:
    """Print the figures as JSON; 1 when one exceeds its limit."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=15, help="paired timings of each figure (default 15)")
    figures = measure(parser.parse_args().rounds)
    verdicts = {
        name: {**figure, "limit": LIMITS[name], "met": next(reversed(figure.values())) <= LIMITS[name]}
        for name, figure in figures.items()
    }
    print(json.dumps(verdicts, indent=2))
    return 0 if all(verdict["met"] for verdict in verdicts.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
