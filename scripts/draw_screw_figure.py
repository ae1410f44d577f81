"""Draw the figure of docs/screws.md: a body that moves along a screw, the shorter and the longer way.

Example:
    python scripts/draw_screw_figure.py            # writes screw.svg into docs/images
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from draw_ik_figures import BODY, FOLDER, INK, PALE, STYLE, Floats, View

import nao_kin as nk

COLOURS = ("#c4572e", "#3a8f4d", "#1f6fb2")  # x, y, z
SHORTER, LONGER = "#7b4fa3", PALE


def draw_frame(view: View, T: Floats, length: float, width: float) -> None:
    """Draw three short axes."""
    for axis, colour in zip(T[:3, :3].T, COLOURS, strict=True):
        view.line([T[:3, 3], T[:3, 3] + length * axis], colour, width, zorder=6)


def draw_screw(path: Path) -> None:
    """Draw the axis, both paths of a body from one pose to another, and the foot of the perpendicular to the axis."""
    figure, axes = plt.subplots(figsize=(6.4, 4.2))
    view = View(axes, -62.0, 24.0)
    line = nk.lines.PluckerLine.from_point_direction([0, 0, 0], [0, 0, 1])
    T_0 = nk.screws.pose(nk.rotations.matrix_from_rpy([0.5, 0.3, -0.4]), [1.0, -0.3, 0.0])
    T_1 = nk.screws.Screw(line, 1.9, 0.8).pose @ T_0
    shorter = nk.screws.sclerp(T_0, T_1, np.linspace(0, 1, 101))
    longer = nk.screws.sclerp(T_0, T_1, np.linspace(0, 1, 101), longer=True)
    view.line(longer[:, :3, 3], LONGER, 1.3, linestyle=(0, (4, 3)), zorder=2)
    view.line(shorter[:, :3, 3], SHORTER, 2.0, zorder=4)
    for T in shorter[::20]:
        foot = line.closest_point(T[:3, 3])
        view.line([foot, T[:3, 3]], BODY, 1.0, zorder=1)
        draw_frame(view, T, 0.24, 2.0)
    for T in longer[20:100:20]:
        draw_frame(view, T, 0.16, 1.0)
    feet = line.closest_point(np.stack([T_0[:3, 3], T_1[:3, 3]]))
    view.axis(np.array([0.0, 0.0, 0.4]), np.array([0.0, 0.0, 1.0]), 0.9, INK, "axis")
    view.line(feet, INK, 3.0, zorder=5)
    view.text(0.5 * (feet[0] + feet[1]) + [-0.12, -0.06, 0.0], "slide", ha="right")
    view.text(T_0[:3, 3] + [0.12, 0.0, -0.2], "$T_0$")
    view.text(T_1[:3, 3] + [0.0, 0.0, 0.34], "$T_1$")
    view.text(shorter[50, :3, 3] + [0.2, 0.1, -0.12], "angle θ", SHORTER, ha="left")
    view.text(longer[30, :3, 3] + [0.0, 0.0, -0.2], "the longer way, θ − 2π", ha="right")
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def main() -> None:
    """Write the figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=FOLDER)
    with plt.rc_context(STYLE):
        draw_screw(parser.parse_args().folder / "screw.svg")


if __name__ == "__main__":
    main()
