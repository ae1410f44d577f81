"""Compare clearances with a Python loop over coal on the same shapes, and verdicts with coal on the meshes.

A collision of the meshes that the shapes miss is an error; a false alarm is a configuration in which the shapes overlap
and the meshes do not. Links that a joint connects, or that overlap in a standing posture, are not compared.

Example:
    python benchmarks/bench_collisions.py              # 100 000 verdicts, several minutes
    python benchmarks/bench_collisions.py --verdicts 2000
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from dataclasses import replace

import coal
import numpy as np

import nao_kin as nk
from nao_kin.robot import LinkShapes
from nao_kin.robot.urdf import Collision

# Limits: the time per configuration in a batch, the factor by which it is faster than the loop, and the price of the
# meshes, which decide by default where hulls overlap little.
LIMIT_SECONDS, LIMIT_RATIO, LIMIT_PRICE = 40e-6, 5.0, 2.0
_BLOCK = 1000


def coal_seconds(nao: nk.NaoModel, q: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the time of a loop over coal for given poses, per configuration [s], and the clearances."""
    shapes = [(whole.link, shape) for whole in nao.link_shapes.shapes for shape in whole.parts or (whole,)]
    of_link = {link: [k for k, (owner, _) in enumerate(shapes) if owner == link] for link in nao.link_shapes.links}
    pairs = [(a, b) for one, other in nao.link_shapes.pairs for a in of_link[one] for b in of_link[other]]
    geometries = [shape.geometry for _, shape in shapes]
    T = nao.fk(q, [shape.link for _, shape in shapes]) @ np.array([shape.T_link_geometry for _, shape in shapes])
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-10
    found = np.full(len(q), np.inf)
    start = time.perf_counter()
    for sample in range(len(q)):
        places = [coal.Transform3s(pose[:3, :3], pose[:3, 3]) for pose in T[sample]]
        result = coal.DistanceResult()
        for a, b in pairs:
            result.clear()
            args = geometries[a], places[a], geometries[b], places[b]
            found[sample] = min(found[sample], coal.distance(*args, request, result))
    return (time.perf_counter() - start) / len(q), found


def verdicts(nao: nk.NaoModel, n: int) -> dict[str, object]:
    """Compare whether links overlap, in n random configurations, with coal on the meshes."""
    above = {joint.child: joint.parent for joint in nao.tree.joints}

    def host(link: str) -> str:
        return link if link in nao.link_shapes.links else host(above[link])

    rows = tuple(Collision(row.link, row.origin, row.geometry, row.name) for row in nao.tree.visuals)
    meshes = LinkShapes.exact(nk.RobotModel(replace(nao.tree, collisions=rows), nao.semantics))
    hosts = {pair: tuple(sorted(map(host, pair))) for pair in meshes.pairs}
    skipped = {pair for pair, reason in nao.link_shapes.disabled.items() if reason != "Never"}
    compared = {pair for pair, both in hosts.items() if both[0] != both[1] and both not in skipped}
    q = nao.random(1, n)
    hulls, clearance = nao.clearance(q, exact=False), nao.clearance(q)
    touching = np.zeros(n, bool)
    for start in range(0, n, _BLOCK):
        hits = {start + sample for _, sample in meshes.touching(q[start : start + _BLOCK], compared)}
        touching[list(hits)] = True
    alarms = clearance.distance < 0.0
    false = (hulls.distance < 0.0) & ~touching
    depths = -1e3 * hulls.distance[false] if false.any() else np.zeros(1)
    causes = Counter(" and ".join(hulls.pairs[k]) for k in hulls.pair_index[false].tolist())
    return {
        "configurations": n,
        "meshes_touch": float(touching.mean()),
        "missed": int((touching & ~alarms).sum()),
        "false_alarms": float((alarms & ~touching).mean()),
        "false_alarms_of_the_hulls": float(false.mean()),
        "depth_of_false_alarms_of_the_hulls_mm": {
            "median": float(np.median(depths)),
            "largest": float(depths.max()),
        },
        "most_frequent": dict(causes.most_common(5)),
    }


def main() -> int:
    """Print the figures as JSON; return 1 if a limit is exceeded or a collision missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--configurations", type=int, default=20_000, help="in the batch that is timed")
    parser.add_argument("--verdicts", type=int, default=100_000, help="configurations compared with the meshes")
    parser.add_argument("--rounds", type=int, default=5, help="number of rounds; the best one is used (default 5)")
    arguments = parser.parse_args()
    nao = nk.load_nao()
    q = nao.random(0, arguments.configurations)
    nao.clearance(q[:100])  # compiles, and reads the meshes
    times, loops, defaults = [], [], []
    for _ in range(arguments.rounds):
        start = time.perf_counter()
        clearance = nao.clearance(q, exact=False)
        times.append((time.perf_counter() - start) / len(q))
        start = time.perf_counter()
        nao.clearance(q)
        defaults.append((time.perf_counter() - start) / len(q))
        loop, found = coal_seconds(nao, q[:200])
        loops.append(loop)
    figures: dict[str, object] = {
        "microseconds": min(times) * 1e6,
        "microseconds_of_the_loop": min(loops) * 1e6,
        "times_as_fast": min(loops) / min(times),
        "price_of_the_meshes": (price := min(defaults) / min(times)),
        "largest_difference_m": float(np.abs(found - clearance.distance[:200]).max()),
        "verdicts": (compared := verdicts(nao, arguments.verdicts)),
    }
    print(json.dumps(figures, indent=2))
    slow = min(times) > LIMIT_SECONDS or min(loops) / min(times) < LIMIT_RATIO or price > LIMIT_PRICE
    return 1 if slow or compared["missed"] else 0


if __name__ == "__main__":
    sys.exit(main())
