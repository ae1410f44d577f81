"""Draw the figures of the explanations in docs/ with the library's own numbers, or check the drawings.

Example:
    python scripts/draw_explanations.py                  # writes them into docs/images
    python scripts/draw_explanations.py --only cameras   # only figures whose names begin with this
    python scripts/draw_explanations.py --check          # exit 1 if a file differs
"""

from __future__ import annotations

import argparse
import importlib
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from explanations.drawing import Drawing

from nao_kin._core.files import write_text

IMAGES = Path(__file__).resolve().parent.parent / "docs" / "images"
MODULES = (
    "frames",
    "turns",
    "poses",
    "cameras",
    "pairs",
    "couplings",
    "limits",
    "balance",
    "state",
    "collisions",
    "calibration",
    "imitation",
)
# Figures by matplotlib, whose coordinates may differ in their last digits.
PLOTS = ("inverse_kinematics",)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
TOLERANCE = 0.01


def figures(modules: Sequence[str] = MODULES) -> dict[str, Callable[[], Drawing]]:
    """Return file → the function that draws it."""
    return {
        name: draw
        for module in modules
        for name, draw in importlib.import_module(f"explanations.{module}").FIGURES.items()
    }


def differ(text: str, kept: str, tolerance: float) -> bool:
    """Return whether two figures differ in more than their numbers, or by more than a tolerance in these."""
    if text == kept or NUMBER.sub("", text) != NUMBER.sub("", kept):
        return text != kept
    now, before = (np.array(NUMBER.findall(one), dtype=float) for one in (text, kept))
    return not np.allclose(now, before, rtol=0.0, atol=tolerance)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a file differs")
    parser.add_argument("--folder", type=Path, default=IMAGES, help="where the figures are (default: docs/images)")
    parser.add_argument("--only", default="", metavar="START", help="only figures whose names begin with this")
    options = parser.parse_args(arguments)
    differing, plots = [], figures(PLOTS)
    for name, draw in (figures() | plots).items():
        if not name.startswith(options.only):
            continue
        path, text = options.folder / f"{name}.svg", str(draw())
        kept = path.read_text(encoding="utf-8") if path.is_file() else ""
        if options.check and differ(text, kept, TOLERANCE if name in plots else 0.0):
            differing.append(path.name)
        elif not options.check:
            write_text(path, text)
            print(path)
    if differing:
        print(f"differ from what is drawn now: {', '.join(differing)}", file=sys.stderr)
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
