"""Fit the collision shapes of the NAO to its meshes and sort their pairs, or check that the files are up to date.

Two sets of shapes contain the meshes, and the fingers at all openings. Convex hulls, four of them for the trunk and one
for each phalanx, are used by `NaoModel.clearance`: each is bounded by planes that touch the mesh, and no corner is
farther than 2 mm from the mesh's hull, 1 mm for the head and the upper arms. V3.2 has hulls of its own of the links
that have another shape there; all others contain the meshes of every version, as the simple shapes do. Simple shapes
are used in the collision elements of the URDFs, which simulators read: a capsule of least volume for each link, and a
second one for the fingers; the trunk and the feet, which are flat and wide, have boxes. Lengths are rounded outwards.
The right side is the mirror image of the left one.

Needs the packages of `pip install nao-kin[dev]`. The same versions give the same rows, on any processor.

Example:
    python scripts/generate_collision_shapes.py            # writes nao_kin/robot/nao/collisions.toml and hulls
    python scripts/generate_collision_shapes.py --check    # exit 1 if a file differs
"""

from __future__ import annotations

import argparse
import functools
import itertools
import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import trimesh
from scipy.optimize import minimize
from scipy.spatial import ConvexHull, HalfspaceIntersection

from nao_kin._core.arrays import Floats, Vector
from nao_kin._core.files import write_text
from nao_kin.robot import load_nao, read_mesh
from nao_kin.robot.collision_pairs import DEFAULT, NEVER, never_touch
from nao_kin.robot.geometry import hulls_in
from nao_kin.robot.link_shapes import LinkShapes
from nao_kin.robot.nao import VERSIONS
from nao_kin.robot.nao.model import HULLS
from nao_kin.robot.nao.rows import ShapeRow

_TOP = Path(__file__).resolve().parent.parent
ROWS, HULLS_FILE = _TOP / "nao_kin" / "robot" / "nao" / "collisions.toml", _TOP / "urdf" / HULLS
# Edges of the triangles whose corners are inside the shapes, and the unit of lengths [m].
_FINE, _UNIT = 0.006, 1e-4
# How far a corner of a hull may be from the mesh's hull, less where links pass close to each other, and the unit of
# the corners [m].
_GAP, _GAPS = 0.002, {"HeadPitch": 0.001, "LShoulderRoll": 0.001, "LElbowRoll": 0.0015, "LShoulderPitch": 0.0003}
_FINE_UNIT = 1e-5
# Heights between the boxes of the trunk [m]: of its pelvis, waist, chest and neck.
_CUTS = (-math.inf, -0.046, 0.0, 0.1, math.inf)
# Enough openings that the hull of a finger at all of them also contains the finger between them.
_OPENINGS = np.linspace(0.0, 1.0, 81)
# What is symmetric is so across y, or a phalanx, whose mesh serves on both sides, across z.
_MIRROR, _MIRROR_Z = np.array([1.0, -1.0, 1.0]), np.array([1.0, 1.0, -1.0])
# Random configurations, and boxes in the proof that a pair of links never touches.
_SAMPLES = 20_000
_UP: Vector = (0.0, 0.0, 1.0)


def surfaces(versions: tuple[str, ...]) -> dict[tuple[str, str], Floats]:
    """Return joint and part → the triangles (n, 3, 3) of the torso and left links, of all these versions [m].

    For the fingers these are the corners of their hulls at all openings, shape (n, 1, 3).
    """
    found: dict[tuple[str, str], dict[object, Floats]] = {}
    for version in versions:
        nao = load_nao(version)
        joints = {"torso": "torso"} | {joint.link: joint.name for joint in nao.parameters.joints}
        for visual in nao.tree.visuals:
            path = visual.geometry.path(nao.tree.packages)  # type: ignore[union-attr]
            joint = joints.get(visual.link, "")
            if joint and not joint.startswith("R"):
                parts = found.setdefault((joint, ""), {})
                if path not in parts:
                    corners, faces = _subdivided(path)
                    parts[path] = corners[faces]
            elif not joint and visual.link.startswith("L"):
                T = nao.fk(nao.configuration({"LHand": _OPENINGS}, limits="ignore"), visual.link, reference="l_wrist")
                moved = _products(_hull(path), T[:, None, :3, :3]) + T[:, None, :3, 3]
                found.setdefault(("LWristYaw", "Fingers"), {})[version, visual.link] = moved.reshape(-1, 1, 3)
    return {key: np.concatenate(list(parts.values())) for key, parts in found.items()}


@functools.cache
def _subdivided(path: Path) -> tuple[Floats, Floats]:
    mesh = read_mesh(path, lambda scene: scene.to_geometry())
    return trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, _FINE, max_iter=30)  # type: ignore[no-any-return, no-untyped-call]


@functools.cache
def _hull(path: Path) -> Floats:
    corners, _ = _subdivided(path)
    return np.asarray(corners[ConvexHull(corners).vertices])


def pieces(versions: tuple[str, ...] = VERSIONS) -> Iterator[tuple[str, str, Floats]]:
    """Yield joint, name and points of the convex pieces of the torso and the left links, of all these versions [m]."""
    for (joint, part), triangles in surfaces(versions).items():
        if joint != "torso":
            yield joint, f"{joint}{part}", _corners(triangles, _MIRROR if joint.startswith("Head") else None)
            continue
        heights = triangles[..., 2]
        for number, (low, high) in enumerate(itertools.pairwise(_CUTS), 1):
            inside = (heights.max(axis=1) >= low) & (heights.min(axis=1) <= high)
            yield joint, f"torso{number}", _corners(triangles[inside], _MIRROR)


def _products(vectors: Floats, rows: Floats) -> Floats:
    """Return the products of vectors (n, 3) and rows (..., m, 3), shape (..., n, m).

    A matrix product rounds differently on other processors, and a search that follows it would end elsewhere.
    """
    return np.asarray((vectors[:, None] * rows).sum(axis=-1))


def _corners(triangles: Floats, mirror: Floats | None) -> Floats:
    points = triangles.reshape(-1, 3).round(6)
    points = np.unique(points if mirror is None else np.concatenate([points, points * mirror]), axis=0)
    return np.asarray(points[ConvexHull(points).vertices])


def shapes(found: list[tuple[str, str, Floats]]) -> Iterator[ShapeRow]:
    """Yield the simple shapes of the pieces, which are on the left or in the middle."""
    for joint, name, points in found:
        if joint in ("torso", "LAnkleRoll"):
            row = _box(f"{name.replace(joint, f'{joint}Shape')}", joint, points)
        else:
            row = _capsule(f"{name}Shape", joint, points)
        yield row


def hulls_text(found: list[tuple[str, str, Floats]]) -> str:
    """Return the OBJ file of the convex hulls, an object for each, in the frames of their links.

    After the hull of the fingers at all openings follow the phalanges, its parts, in their own frames. "LBicep@v3.2" is
    the hull of V3.2 where the hull of the meshes of all versions is farther from that of its mesh than the gap.
    """
    links = {joint.name: joint.link for joint in load_nao("v6").parameters.joints}
    file = _ObjFile()
    for joint, name, points, version in _by_version(found):
        link, part = links.get(joint, joint), name.removeprefix(joint)
        corners = _cover(points, _GAPS.get(joint, _GAP), None if joint.startswith("L") else _MIRROR)
        for side in (1.0, -1.0) if joint.startswith("L") else (1.0,):
            owner = (link if side > 0.0 else _mirrored(link)) + (f".{part}" if part else "")
            file.add(owner + version, corners * [1.0, side, 1.0])
            if part == "Fingers":
                for phalanx, hull in phalanges("L" if side > 0.0 else "R"):
                    file.add(f"{owner}.{phalanx}", _cover(hull, _GAP, _MIRROR_Z))
    return file.text


def _by_version(found: list[tuple[str, str, Floats]]) -> Iterator[tuple[str, str, Floats, str]]:
    """Yield the pieces, each followed by "" or, if the shape of V3.2 differs, for the others and then for "@v3.2"."""
    newer, older = ([points for *_, points in pieces(versions)] for versions in (VERSIONS[1:], VERSIONS[:1]))
    for (joint, name, points), new, old in zip(found, newer, older, strict=True):
        faces = ConvexHull(old).equations
        differs = (_products(points, faces[:, :3]) + faces[:, 3]).max() > _GAP
        yield joint, name, new if differs else points, ""
        if differs:
            yield joint, name, old, f"@{VERSIONS[0]}"


class _ObjFile:
    def __init__(self) -> None:
        self.text, self._count = "# nao_kin: generated by scripts/generate_collision_shapes.py\n", 0

    def add(self, name: str, corners: Floats) -> None:
        """Add the hull of corners as an object, its faces counter-clockwise from outside."""
        faces = [face if _outwards(corners, face) else face[::-1] for face in ConvexHull(corners).simplices.tolist()]
        lines = [f"o {name}", *(f"v {x:.5f} {y:.5f} {z:.5f}".replace("-0.00000", "0.00000") for x, y, z in corners)]
        lines += ["f " + " ".join(str(corner + self._count + 1) for corner in face) for face in faces]
        self.text, self._count = self.text + "\n".join(lines) + "\n", self._count + len(corners)


def phalanges(side: str) -> Iterator[tuple[str, Floats]]:
    """Yield link and points of the phalanges of a hand, of all versions, in their own frames [m]."""
    points: dict[str, list[Floats]] = {}
    for version in VERSIONS:
        nao = load_nao(version)
        jointed = {joint.link for joint in nao.parameters.joints}
        for visual in nao.tree.visuals:
            if visual.link not in jointed and visual.link.startswith(side):
                path = visual.geometry.path(nao.tree.packages)  # type: ignore[union-attr]
                points.setdefault(visual.link, []).append(_hull(path))
    yield from ((link, _corners(np.concatenate(hulls), _MIRROR_Z)) for link, hulls in points.items())


def _cover(points: Floats, gap: float, mirror: Floats | None) -> Floats:
    """Return the corners of a polytope that contains points, cut out by planes that touch them.

    Where a corner is farthest outside the points' hull, the plane parallel to that face of the hull is added, until no
    corner is farther outside than the gap.
    """
    faces = ConvexHull(points).equations
    normals = np.concatenate([np.eye(3), -np.eye(3)])
    while True:
        reach = _products(points, normals).max(axis=0) + _FINE_UNIT
        corners = HalfspaceIntersection(np.column_stack([normals, -reach]), points.mean(axis=0)).intersections
        corners = np.unique(corners.round(5), axis=0)
        if mirror is not None:
            half = corners[corners[:, mirror.argmin()] >= 0.0]
            corners = np.unique(np.concatenate([half, half * mirror]) + 0.0, axis=0)
        outside = _products(corners, faces[:, :3]) + faces[:, 3]
        if outside.max() <= gap:
            return np.asarray(corners[np.sort(ConvexHull(corners).vertices)])
        normal = faces[np.unravel_index(outside.argmax(), outside.shape)[1], :3]
        normals = np.vstack([normals, normal, *([] if mirror is None else [normal * mirror])])


def _outwards(corners: Floats, face: list[int]) -> bool:
    a, b, c = corners[face]
    return float(np.cross(b - a, c - a) @ (a - corners.mean(axis=0))) > 0.0


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
    symmetric = joint.startswith("Head")
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)

    def ends(x: Floats) -> Floats:
        return np.array([[x[0], -x[2], x[1]], [x[0], x[2], x[1]]]) if symmetric else x.reshape(2, 3)

    starts = [np.concatenate([middle - step, middle + step]) for step in np.diag(half)]
    found = []
    for start in [np.array([middle[0], middle[2], half[1]])] if symmetric else starts:
        for _ in range(3):  # restarted, because the simplex may collapse
            simplex = np.vstack([start, start + 0.01 * np.eye(len(start))])
            options = {"initial_simplex": simplex, "xatol": 1e-7, "fatol": 1e-12, "maxiter": 4000, "maxfev": 8000}
            result = minimize(lambda x: _volume(points, ends(x)), start, method="Nelder-Mead", options=options)
            start = result.x
        found.append((result.fun, start))
    one, other = np.round(ends(min(found, key=lambda each: each[0])[1]) / _UNIT) * _UNIT
    centre, along = _rounded(0.5 * (one + other)), _rounded(other - one)
    length = round(math.hypot(*along), 9)
    radius = math.ceil(_radius(points, np.array([one, other])) / _UNIT + 0.02) * _UNIT
    if not length:
        return ShapeRow(name, joint, "sphere", (round(radius, 9),), centre, _UP, "FIT")
    return ShapeRow(name, joint, "capsule", (round(radius, 9), length), centre, along, "FIT")


def _radius(points: Floats, ends: Floats) -> float:
    along = ends[1] - ends[0]
    offset = points - ends[0]
    share = np.clip((offset * along).sum(axis=1) / max(math.hypot(*along) ** 2, 1e-18), 0.0, 1.0)
    return math.sqrt(float(np.square(offset - share[:, None] * along).sum(axis=1).max()))


def _volume(points: Floats, ends: Floats) -> float:
    radius = _radius(points, ends)
    return math.pi * radius**2 * (math.hypot(*(ends[1] - ends[0])) + 4.0 / 3.0 * radius)


def pairs(hulls: str) -> Iterator[tuple[str, str, str]]:
    """Yield pairs of links that are not checked, with the reason: by the rules of an SRDF, for V6 and its hulls.

    The pairs with the reason "Default" touch in a posture in which the robot stands or, if two joints separate them, in
    any posture. A pair with the reason "Never" is proven apart within the limits of every version.
    """
    nao, *others = map(load_nao, reversed(VERSIONS))
    found, *older = (LinkShapes(robot, hulls_in(hulls, robot.version), disabled={}) for robot in (nao, *others))
    disabled = found.found_disabled(_SAMPLES, 0)
    standing = np.array([nao.posture(name) for name in nao.posture_names if name.startswith("Stand")])
    touching = found.count(standing, set(found.pairs) - set(disabled))
    disabled |= {pair: DEFAULT for pair, count in touching.items() if count}
    for (one, other), reason in sorted(disabled.items()):
        mirrored = min(_mirrored(one), _mirrored(other)), max(_mirrored(one), _mirrored(other))
        # Rounding may end the proof of a mirrored pair at another number of boxes.
        if mirrored in disabled and (
            reason != NEVER
            or all(
                never_touch(robot, shapes.capsules, pair, _SAMPLES)
                for robot, shapes in zip(others, older, strict=True)
                for pair in ((one, other), mirrored)
            )
        ):
            yield one, other, reason


def _mirrored(link: str) -> str:
    sides = {"L": "R", "R": "L", "l": "r", "r": "l"}
    return sides[link[0]] + link[1:] if link[0] in "LR" or link[1] == "_" else link


def texts() -> dict[Path, str]:
    """Return file → text: the rows, and the hulls."""
    found = list(pieces())
    hulls = hulls_text(found)
    rows = "".join(
        f"  {json.dumps([row.name, row.parent, row.kind, row.size_m, row.center_m, row.axis, 'FIT'])},\n"
        for row in shapes(found)
    )
    others: dict[tuple[str, str], list[str]] = {}
    for one, other, reason in pairs(hulls):
        others.setdefault((reason, one), []).append(other)
    unchecked = "".join(f"  {json.dumps([*of, ' '.join(names)])},\n" for of, names in sorted(others.items()))
    return {
        HULLS_FILE: hulls,
        ROWS: (
            "# The simple collision shapes of every NAO, those on the left also for the right, and the pairs of links "
            "that are not checked.\n"
            "# Generated by scripts/generate_collision_shapes.py from the meshes. Edit the script only.\n\n"
            f"shapes = [\n{rows}]\n\n"
            "# The reason, a link, and the links that are not checked against it.\n"
            f"unchecked = [\n{unchecked}]\n"
        ),
    }


def main(arguments: list[str] | None = None) -> int:
    """Write or check; return 1 if --check finds a difference, otherwise 0."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a file is out of date")
    check = parser.parse_args(arguments).check
    stale = 0
    for path, text in texts().items():
        if not check:
            write_text(path, text)
            print(path)
        elif not path.is_file() or path.read_text(encoding="utf-8") != text:
            print(f"not in step with the meshes: {path} (run scripts/generate_collision_shapes.py)", file=sys.stderr)
            stale = 1
    return stale


if __name__ == "__main__":
    sys.exit(main())
