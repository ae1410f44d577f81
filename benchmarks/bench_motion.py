"""Compare the sampling of motions with scipy.interpolate: the ratio of speeds, and the largest difference.

26 joints with keys at the same times are sampled at times in random order. The motion, and scipy's interpolator of all
columns, are constructed in advance. The two libraries take turns, and the best turn is used. scipy has no curve that is
a cubic in both time and value. The Bezier motion whose handles are a third of their segment is a polynomial in time and
is compared with BPoly; the motion with handles of other lengths has no counterpart.

--files also measures how long a file of a million keys takes to write and to read in each format.
"""

from __future__ import annotations

import argparse
import json
import platform
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.interpolate import BPoly, CubicHermiteSpline, make_interp_spline

import nao_kin as nk
from nao_kin.motion import FORMATS, check, read_motion, write_motion
from nao_kin.motion.interpolation import smooth_slopes
from nao_kin.robot.nao import BODY_ORDER

Array = NDArray[Any]
Row = tuple[str, Callable[[Array], Any], Callable[[Array], Any] | None]

JOINTS = len(BODY_ORDER)


def main() -> None:
    """Print a table, or the rows as JSON with --json."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keys", type=int, default=1000, help="keys of each joint")
    parser.add_argument("--times", type=int, default=100_000, help="times to sample at")
    parser.add_argument("--turns", type=int, default=5, help="number of turns; the best one is used")
    parser.add_argument("--files", action="store_true", help="also files of a million keys in each format")
    parser.add_argument("--json", action="store_true", help="print JSON")
    chosen = parser.parse_args()
    rng = np.random.default_rng(0)
    times = np.cumsum(rng.uniform(0.01, 0.1, chosen.keys))
    keys = np.cumsum(rng.normal(size=(chosen.keys, JOINTS)) * 0.01, axis=0)
    at = rng.uniform(times[0], times[-1], chosen.times)
    rows = [_measured(row, at, chosen.turns) for row in _contenders(times, keys)]
    rows += [_checked(times, keys, chosen.turns)]
    if chosen.files:
        rows += _files()
    if chosen.json:
        print(json.dumps({"machine": platform.processor(), "scipy": scipy.__version__, "rows": rows}, indent=2))
        return
    print(f"{chosen.times} times, {JOINTS} joints, {chosen.keys} keys each; scipy {scipy.__version__}")
    print(f"{'what':34} {'ours':>10} {'scipy':>10} {'ratio':>7} {'difference':>11}")
    for row in rows:
        other = "–" if row["scipy_ms"] is None else f"{row['scipy_ms']:.1f} ms"
        ratio = "–" if row["scipy_ms"] is None else f"{row['scipy_ms'] / row['ours_ms']:.2f}"
        apart = "–" if row["difference"] is None else f"{row['difference']:.1e}"
        print(f"{row['what']:34} {row['ours_ms']:>7.1f} ms {other:>10} {ratio:>7} {apart:>11}")


def _contenders(times: Array, keys: Array) -> list[Row]:
    slopes = np.stack([smooth_slopes(times, column) for column in keys.T], axis=-1)
    hermite = CubicHermiteSpline(times, keys, slopes)
    straight = make_interp_spline(times, keys, k=1)
    motions = {kind: nk.Motion(times, BODY_ORDER, keys, kind) for kind in ("linear", "smooth", "bezier")}
    bezier = motions["bezier"]
    handles = np.stack(bezier.handles or ())
    controls = np.stack([keys[:-1], keys[:-1] + handles[:, :-1, 1, 1].T, keys[1:] + handles[:, 1:, 0, 1].T, keys[1:]])
    shorter = [offsets * (0.6, 1.0) for offsets in handles]
    uneven = nk.Motion(times, BODY_ORDER, keys, "bezier", shorter)
    speeds = hermite.derivative()
    return [
        ("linear", motions["linear"].sample, straight),
        ("smooth", motions["smooth"].sample, hermite),
        ("smooth, speed", motions["smooth"].speed, speeds),
        ("bezier, handles of a third", bezier.sample, BPoly(controls, times)),
        ("bezier, handles of a fifth", uneven.sample, None),
    ]


def _measured(row: Row, at: Array, turns: int) -> dict[str, Any]:
    what, ours, theirs = row
    contenders = [ours] if theirs is None else [ours, theirs]
    best = [np.inf] * len(contenders)
    for _ in range(turns):
        for index, contender in enumerate(contenders):
            best[index] = min(best[index], _seconds(contender, at))
    apart = None if theirs is None else float(np.abs(ours(at) - theirs(at)).max())
    other = None if theirs is None else best[1] * 1e3
    return {"what": what, "ours_ms": best[0] * 1e3, "scipy_ms": other, "difference": apart}


def _checked(times: Array, keys: Array, turns: int) -> dict[str, Any]:
    """Time a complete check of limits and speeds, which has no counterpart in scipy."""
    nao = nk.load_nao()
    motion = nk.Motion(times, BODY_ORDER, 0.1 * np.tanh(keys), "smooth")
    best = min(_seconds(lambda _: check(nao, motion), times) for _ in range(turns))
    return {"what": "check of the smooth motion", "ours_ms": best * 1e3, "scipy_ms": None, "difference": None}


def _files() -> list[dict[str, Any]]:
    """Time writing and reading a million keys in each format."""
    count = 1_000_000 // JOINTS + 1
    keys = np.random.default_rng(0).uniform(-0.3, 0.0, (count, JOINTS)).round(4)
    keys[:, BODY_ORDER.index("RHipYawPitch")] = keys[:, BODY_ORDER.index("LHipYawPitch")]
    motion = nk.Motion(np.arange(count) / 100, BODY_ORDER, keys)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, form in FORMATS.items():
            path = Path(folder) / f"motion{form.suffixes[0]}"
            for what, call in (
                ("written", lambda _, p=path, n=name: write_motion(motion, p, format=n, overwrite=True)),
                ("read", lambda _, p=path: read_motion(p)),
            ):
                milliseconds = 1e3 * _seconds(call, keys)
                rows.append(
                    {
                        "what": f"{name}, a million keys {what}",
                        "ours_ms": milliseconds,
                        "scipy_ms": None,
                        "difference": None,
                    }
                )
    return rows


def _seconds(call: Callable[[Array], Any], at: Array) -> float:
    start = time.perf_counter()
    call(at)
    return time.perf_counter() - start


if __name__ == "__main__":
    main()
