"""Fit the collision shapes of the NAO to its meshes and sort their pairs, or check that the rows are up to date.

Each link has one capsule of least volume that contains its mesh, of every version; the hand has a second one for its
fingers at all openings. The trunk and the feet, which are flat and wide, have boxes. Lengths are rounded to 0.1 mm,
outwards. The right side is the mirror image of the left one.

Needs the packages of `pip install nao-kin[dev]`. The same versions give the same rows.

Example:
    python scripts/generate_collision_shapes.py            # writes nao_kin/robot/nao/collision_rows.py
    python scripts/generate_collision_shapes.py --check    # exit 1 if the file differs
"""

from __future__ import annotations

import argparse
import itertools
import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import trimesh
from generate_urdf import nao_tree
from scipy.optimize import minimize
from scipy.spatial import ConvexHull

from nao_kin._core.arrays import Floats, Vector
from nao_kin._core.files import write_text
from nao_kin.robot import RobotModel, load_nao, mesh_path, read_mesh
from nao_kin.robot.collisions import LinkShapes, covering_capsule
from nao_kin.robot.contacts import DEFAULT, disabled_collisions
from nao_kin.robot.nao import VERSIONS, nao_parameters
from nao_kin.robot.nao.rows import ShapeRow

ROWS = Path(__file__).resolve().parent.parent / "nao_kin" / "robot" / "nao" / "collision_rows.py"
# Edges of the triangles whose corners are inside the shapes, and the unit of lengths [m].
_FINE, _UNIT = 0.006, 1e-4
# Heights between the boxes of the trunk [m]: of its pelvis, waist, chest and neck.
_CUTS = (-math.inf, -0.046, 0.0, 0.1, math.inf)
_OPENINGS = np.linspace(0.0, 1.0, 11)
_SAMPLES = 100_000
_UP: Vector = (0.0, 0.0, 1.0)


def surfaces() -> dict[tuple[str, str], Floats]:
    """Return joint and part → the triangles (n, 3, 3) of the torso and left links, of all versions [m]."""
    found: dict[tuple[str, str], list[Floats]] = {}
    for version in VERSIONS:
        nao = load_nao(version)
        joints = {"torso": "torso"} | {joint.link: joint.name for joint in nao.parameters.joints}
        for visual in nao.tree.visuals:
            path = mesh_path(visual.geometry, nao.tree.packages)  # type: ignore[arg-type]
            mesh = read_mesh(path, lambda scene: scene.to_geometry())
            corners, faces = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, _FINE, max_iter=30)  # type: ignore[no-untyped-call]
            if visual.link in joints:
                found.setdefault((joints[visual.link], ""), []).append(corners[faces])
            elif visual.link.startswith("L"):
                for opening in _OPENINGS:
                    q = nao.configuration({"LHand": opening}, limits="ignore")
                    T = nao.fk(q, visual.link, reference="l_wrist")
                    moved = corners @ T[:3, :3].T + T[:3, 3]
                    found.setdefault(("LWristYaw", "Fingers"), []).append(moved[faces])
    return {key: np.concatenate(parts) for key, parts in found.items() if not key[0].startswith("R")}


def shapes() -> Iterator[ShapeRow]:
    """Yield the shapes of all links."""
    for (joint, part), triangles in surfaces().items():
        name = f"{joint}{part}Shape"
        if joint == "torso":
            heights = triangles[..., 2]
            for number, (low, high) in enumerate(itertools.pairwise(_CUTS), 1):
                inside = (heights.max(axis=1) >= low) & (heights.min(axis=1) <= high)
                yield _box(f"{name}{number}", joint, triangles[inside])
            continue
        points = np.unique(triangles.reshape(-1, 3).round(6), axis=0)
        points = points[ConvexHull(points).vertices]
        row = _box(name, joint, points) if joint == "LAnkleRoll" else _capsule(name, joint, points)
        yield row
        if joint.startswith("L"):
            x, y, z = row.center_m
            a, b, c = row.axis
            mirrored = replace(row, name=f"R{name[1:]}", parent=f"R{joint[1:]}", center_m=(x, -y + 0.0, z))
            yield replace(mirrored, axis=(a, -b + 0.0, c))


def _box(name: str, joint: str, points: Floats) -> ShapeRow:
    points = points.reshape(-1, 3)
    low, high = np.floor(points.min(axis=0) / _UNIT - 0.01), np.ceil(points.max(axis=0) / _UNIT + 0.01)
    if joint == "torso":
        high[1] = max(high[1], -low[1])
        low[1] = -high[1]
    return ShapeRow(
        name, joint, "box", _rounded((high - low) * _UNIT), _rounded(0.5 * (low + high) * _UNIT), _UP, "FIT"
    )


def _rounded(values: Floats) -> Vector:
    x, y, z = (round(float(value), 9) + 0.0 for value in values)
    return x, y, z


def _capsule(name: str, joint: str, points: Floats) -> ShapeRow:
    """Return a capsule of least volume; that of the head is symmetric, along y."""
    guess = covering_capsule(points)
    start = np.concatenate([guess.centre + sign * (guess.half[2] + 1e-3) * guess.axes[:, 2] for sign in (-1.0, 1.0)])
    symmetric = joint.startswith("Head")
    if symmetric:
        middle = points.mean(axis=0)
        start = np.array([middle[0], middle[2], 1e-2])

    def ends(x: Floats) -> Floats:
        return np.array([[x[0], -x[2], x[1]], [x[0], x[2], x[1]]]) if symmetric else x.reshape(2, 3)

    for _ in range(3):  # restarted, because the simplex may collapse
        simplex = np.vstack([start, start + 0.01 * np.eye(len(start))])
        options = {"initial_simplex": simplex, "xatol": 1e-7, "fatol": 1e-12, "maxiter": 4000, "maxfev": 8000}
        start = minimize(lambda x: _volume(points, ends(x)), start, method="Nelder-Mead", options=options).x
    one, other = np.round(ends(start) / _UNIT) * _UNIT
    centre, along = _rounded(0.5 * (one + other)), _rounded(other - one)
    length = round(float(np.linalg.norm(along)), 9)
    radius = math.ceil(_radius(points, np.array([one, other])) / _UNIT + 0.02) * _UNIT
    if not length:
        return ShapeRow(name, joint, "sphere", (round(radius, 9),), centre, _UP, "FIT")
    return ShapeRow(name, joint, "capsule", (round(radius, 9), length), centre, along, "FIT")


def _radius(points: Floats, ends: Floats) -> float:
    along = ends[1] - ends[0]
    share = np.clip((points - ends[0]) @ along / max(float(along @ along), 1e-18), 0.0, 1.0)
    return float(np.linalg.norm(points - ends[0] - share[:, None] * along, axis=1).max())


def _volume(points: Floats, ends: Floats) -> float:
    radius = _radius(points, ends)
    return math.pi * radius**2 * (float(np.linalg.norm(ends[1] - ends[0])) + 4.0 / 3.0 * radius)


def pairs(rows: tuple[ShapeRow, ...]) -> Iterator[tuple[str, str, str]]:
    """Yield pairs of links that are not checked, with the reason: by the rules of an SRDF, for V6.

    "Default" are those that touch in a posture in which the robot stands.
    """
    nao = load_nao("v6")
    parameters = replace(nao_parameters("v6"), collision_shapes=rows)
    robot = RobotModel(nao_tree(parameters), replace(nao.semantics, disabled_collisions=()))
    found = LinkShapes(robot, {})
    standing = np.array([robot.posture(name) for name in robot.posture_names if name.startswith("Stand")])
    disabled = disabled_collisions(robot, found, samples=_SAMPLES, seed=0)
    touching = found.count(standing, set(found.pairs) - set(disabled))
    disabled |= {pair: DEFAULT for pair, count in touching.items() if count}
    for (one, other), reason in sorted(disabled.items()):
        mirrored = sorted((_mirrored(one), _mirrored(other)))
        if (mirrored[0], mirrored[1]) in disabled:  # else found on one side only, so it is rare but not impossible
            yield one, other, reason


def _mirrored(link: str) -> str:
    sides = {"L": "R", "R": "L", "l": "r", "r": "l"}
    return sides[link[0]] + link[1:] if link[0] in "LR" or link[1] == "_" else link


def module_text() -> str:
    """Return the text of the module of rows."""
    rows = tuple(shapes())
    lines = "".join(
        f'    ShapeRow("{row.name}", "{row.parent}", "{row.kind}", {row.size_m}, {row.center_m}, {row.axis}, "FIT"),\n'
        for row in rows
    )
    disabled = "".join(f'    ("{one}", "{other}", "{reason}"),\n' for one, other, reason in pairs(rows))
    return (
        '"""The collision shapes of every NAO, and the pairs of links that are not checked.\n\n'
        'Generated by scripts/generate_collision_shapes.py from the meshes: edit that.\n"""\n\n'
        "from __future__ import annotations\n\nfrom nao_kin.robot.nao.rows import ShapeRow\n\n# fmt: off\n"
        f"FITTED_SHAPES: tuple[ShapeRow, ...] = (\n{lines})\n"
        f"DISABLED_COLLISIONS: tuple[tuple[str, str, str], ...] = (\n{disabled})\n# fmt: on\n"
    )


def main(arguments: list[str] | None = None) -> int:
    """Write or check; return 1 if --check finds a difference, otherwise 0."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; fail when the file is not in step")
    check = parser.parse_args(arguments).check
    text = module_text()
    if not check:
        write_text(ROWS, text)
        print(ROWS)
    elif not ROWS.is_file() or ROWS.read_text(encoding="utf-8") != text:
        print(f"not in step with the meshes: {ROWS} (run scripts/generate_collision_shapes.py)", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
