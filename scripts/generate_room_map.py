"""Draw the rooms of the package and their imports from each other, or check the drawing.

Rooms are in rows, each above all rooms that it imports. Arrows that follow from others are left out.

Example:
    python scripts/generate_room_map.py            # writes docs/images/rooms.svg
    python scripts/generate_room_map.py --check    # exit 1 if the file differs
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "nao_kin"
OUTPUT = ROOT / "docs" / "images" / "rooms.svg"

# Entry points of the package, which import everything.
ENTRANCES = ("__init__", "__main__")
# Rooms used by all others; arrows to them would only hide the other arrows.
FOUNDATIONS = ("_core",)

WIDTH, MARGIN = 900.0, 24.0
BOX_HEIGHT, ROW_STEP = 34.0, 86.0
LETTER = 8.2  # width of a letter at 14 pixels
INK, LINE, EDGE = "#1f2937", "#64748b", "#94a3b8"
FILLS = ("#dbeafe", "#dcfce7", "#fef9c3", "#ffedd5", "#fce7f3", "#ede9fe", "#e0f2fe", "#f1f5f9")

Arrows = dict[str, set[str]]


class Box(NamedTuple):
    """Left and top edge, and width."""

    x: float
    y: float
    width: float

    @property
    def middle(self) -> float:
        """The horizontal centre."""
        return self.x + self.width / 2


def room_of(module: Path) -> str:
    """Return the room of a file: the folder directly inside the package; `errors` belongs to `_core`."""
    return _room(module.relative_to(PACKAGE).parts[0].removesuffix(".py"))


def _room(name: str) -> str:
    return "_core" if name == "errors" else name


def imported_rooms(module: Path, rooms: set[str]) -> set[str]:
    """Return the rooms that a file imports at run time, at its top or inside its functions."""
    tree = ast.parse(module.read_text(encoding="utf-8"))
    for_types = {
        inner
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
        for statement in node.body
        for inner in ast.walk(statement)
    }
    names: set[str] = set()
    for node in ast.walk(tree):
        if node in for_types:
            continue
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.add(node.module)
            if node.module == "nao_kin":
                names |= {f"nao_kin.{alias.name}" for alias in node.names}
    return {_room(parts[1]) for name in names if (parts := name.split("."))[0] == "nao_kin" and len(parts) > 1} & rooms


def read_arrows() -> Arrows:
    """Return the rooms that each room imports."""
    modules = sorted(PACKAGE.rglob("*.py"))
    rooms = {room_of(module) for module in modules} - set(ENTRANCES)
    arrows: Arrows = {room: set() for room in sorted(rooms)}
    for module in modules:
        if room_of(module) in rooms:
            arrows[room_of(module)] |= imported_rooms(module, rooms) - {room_of(module)}
    return arrows


def levels(arrows: Mapping[str, set[str]]) -> dict[str, int]:
    """Return the height of each room: 0 without imports, otherwise one above the highest imported room.

    Raises:
        ValueError: rooms import each other in a circle.
    """
    heights: dict[str, int] = {}
    while len(heights) < len(arrows):
        ready = [room for room, lower in arrows.items() if room not in heights and lower <= heights.keys()]
        if not ready:
            raise ValueError(
                f"rooms import each other in a circle: {', '.join(sorted(arrows.keys() - heights.keys()))}"
            )
        heights |= {room: 1 + max((heights[lower] for lower in arrows[room]), default=-1) for room in ready}
    return heights


def reduced(arrows: Mapping[str, set[str]]) -> Arrows:
    """Return the arrows that do not follow from two others."""
    below: Arrows = {}
    for room in sorted(arrows, key=levels(arrows).__getitem__):
        below[room] = arrows[room].union(*(below[lower] for lower in arrows[room]))
    return {
        room: {lower for lower in direct if not any(lower in below[other] for other in direct)}
        for room, direct in arrows.items()
    }


def paths_through(heights: Mapping[str, int], arrows: Mapping[str, set[str]]) -> list[list[str]]:
    """Return the spots of each arrow, one per row: its room, spaces reserved for it, and the lower room."""
    return [
        [room, *(f"{room}>{lower}@{level}" for level in range(heights[room] - 1, heights[lower], -1)), lower]
        for room in sorted(arrows)
        for lower in sorted(arrows[room])
    ]


def ordered_rows(heights: Mapping[str, int], paths: list[list[str]]) -> list[list[str]]:
    """Return the spots of each height from left to right, near the spots connected with them."""
    rows: list[list[str]] = [[] for _ in range(max(heights.values()) + 1)]
    for room, level in sorted(heights.items()):
        rows[level].append(room)
    joined: dict[str, list[str]] = {room: [] for room in heights}
    for path in paths:
        for k, spot in enumerate(path):
            if spot not in heights:
                rows[heights[path[0]] - k].append(spot)
            joined.setdefault(spot, []).extend(path[max(k - 1, 0) : k] + path[k + 1 : k + 2])
    for _ in range(24):
        for row in [*rows, *reversed(rows)]:
            place = {spot: (k + 0.5) / len(each) for each in rows for k, spot in enumerate(each)}
            mean = {spot: sum(place[n] for n in joined[spot] or [spot]) / len(joined[spot] or [spot]) for spot in row}
            row.sort(key=lambda spot: (round(mean[spot], 9), spot))
    return rows


def placed(rows: list[list[str]]) -> dict[str, Box]:
    """Return the box of each room, and a narrow box for each reserved space."""
    boxes = {}
    for level, row in enumerate(rows):
        widths = [10.0 if "@" in spot else len(spot) * LETTER + 26.0 for spot in row]
        gap = max(8.0, min(80.0, (WIDTH - 2 * MARGIN - sum(widths)) / (len(row) + 1)))
        x = (WIDTH - sum(widths) - gap * (len(row) - 1)) / 2
        for spot, width in zip(row, widths, strict=True):
            boxes[spot] = Box(x, MARGIN + (len(rows) - 1 - level) * ROW_STEP, width)
            x += width + gap
    return boxes


def drawing(arrows: Mapping[str, set[str]]) -> str:
    """Return the SVG."""
    shown = {room: lower - set(FOUNDATIONS) for room, lower in arrows.items() if room not in FOUNDATIONS}
    heights = levels(shown)
    paths = paths_through(heights, reduced(shown))
    rows = ordered_rows(heights, paths)
    boxes = placed(rows)
    height = 2 * MARGIN + (len(rows) - 1) * ROW_STEP + BOX_HEIGHT + 26.0
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_n(WIDTH)} {_n(height)}" '
        'font-family="Helvetica, Arial, sans-serif" role="img" aria-labelledby="title">',
        '<title id="title">The rooms of nao_kin and what they import</title>',
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
        f'<path d="M 0 0 L 8 4 L 0 8 z" fill="{LINE}"/></marker></defs>',
        '<rect width="100%" height="100%" rx="8" fill="white"/>',
        *(_arrow([boxes[spot] for spot in path]) for path in paths),
    ]
    for room, level in sorted(heights.items()):
        box, fill = boxes[room], FILLS[level % len(FILLS)]
        lines.append(
            f'<rect x="{_n(box.x)}" y="{_n(box.y)}" width="{_n(box.width)}" height="{_n(BOX_HEIGHT)}" rx="7" '
            f'fill="{fill}" stroke="{EDGE}"/>'
            f'<text x="{_n(box.middle)}" y="{_n(box.y + BOX_HEIGHT / 2 + 5)}" font-size="14" text-anchor="middle" '
            f'fill="{INK}">{room}</text>'
        )
    below_all = " and ".join(sorted(set(FOUNDATIONS) & arrows.keys()))
    note = f"An arrow is an import. All rooms may import {below_all}; arrows that follow from others are left out."
    lines.append(
        f'<text x="{_n(WIDTH / 2)}" y="{_n(height - 14)}" font-size="12" text-anchor="middle" fill="{LINE}">'
        f"{note}</text>"
    )
    return "\n".join([*lines, "</svg>", ""])


def _arrow(boxes: list[Box]) -> str:
    """Return a curve that starts downwards, passes the reserved spaces and arrives from above."""
    first, last = boxes[0], boxes[-1]
    # Arrows of one box start at different points.
    out, into = (
        max(-0.38, min(0.38, 2.0 * (there.middle - here.middle) / WIDTH))
        for here, there in ((first, boxes[1]), (last, boxes[-2]))
    )
    points = [(first.middle + out * first.width, first.y + BOX_HEIGHT)]
    for free in boxes[1:-1]:
        points += [(free.middle, free.y), (free.middle, free.y + BOX_HEIGHT)]
    points.append((last.middle + into * last.width, last.y - 2.0))
    way = f"M {_n(points[0][0])} {_n(points[0][1])}"
    for (x1, y1), (x2, y2) in pairwise(points):
        bend = 0.5 * (y2 - y1)
        way += f" C {_n(x1)} {_n(y1 + bend)} {_n(x2)} {_n(y2 - bend)} {_n(x2)} {_n(y2)}"
    return f'<path d="{way}" fill="none" stroke="{LINE}" stroke-width="1.2" opacity="0.8" marker-end="url(#tip)"/>'


def _n(value: float) -> str:
    """Return a coordinate to a tenth of a pixel, as short as possible, without −0."""
    return f"{round(value, 1) + 0.0:g}"


def main(arguments: list[str] | None = None) -> int:
    """Write or check; return 1 if --check finds a difference, otherwise 0."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; fail if the file is out of date")
    parser.add_argument("--output", type=Path, default=OUTPUT, help="the file (default: docs/images/rooms.svg)")
    options = parser.parse_args(arguments)
    text = drawing(read_arrows())
    if not options.check:
        options.output.parent.mkdir(parents=True, exist_ok=True)
        options.output.write_text(text, encoding="utf-8")
        print(options.output)
        return 0
    if options.output.is_file() and options.output.read_text(encoding="utf-8") == text:
        return 0
    print(f"not in step with the imports: {options.output} (run scripts/generate_room_map.py)", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
