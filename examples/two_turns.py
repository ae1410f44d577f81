"""Two quarter turns, in either order.

Learn that rotations do not commute: a turn about z and then about x is not the same as a turn about x and then about z.

Needs nao-kin[plot].
"""

import sys
from pathlib import Path

import numpy as np

from nao_kin import rotations as rot

try:
    import matplotlib.pyplot as plt
except ImportError:
    sys.exit("matplotlib draws this: pip install 'nao-kin[plot]'")

COLOURS = ("#c4572e", "#3a8f4d", "#1f6fb2")  # x, y, z
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
quarter = np.pi / 2
about_z, about_x = rot.rot_z(quarter), rot.rot_x(quarter)
orders = {"first z, then x": [about_z, about_x @ about_z], "first x, then z": [about_x, about_z @ about_x]}

figure = plt.figure(figsize=(8, 5), layout="constrained")
for row, (order, (half, whole)) in enumerate(orders.items()):
    axis, angle = rot.natural_invariants(whole)
    print(f"{order}: {np.degrees(angle):.0f}° about {np.round(axis, 3) + 0.0}")
    for column, R in enumerate([np.eye(3), half, whole]):
        axes = figure.add_subplot(2, 3, 3 * row + column + 1, projection="3d", computed_zorder=False)
        # A flat box whose edges lie along the axes of the frame, and the axes themselves.
        corners = np.array([[x, y, z] for x in (0, 0.9) for y in (0, 0.55) for z in (0, 0.25)]) @ R.T
        for i, j in [(0, 1), (0, 2), (0, 4), (1, 3), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 6), (5, 7), (6, 7)]:
            axes.plot(*corners[[i, j]].T, color="0.55", linewidth=1.2)
        for direction, colour in zip(R.T, COLOURS):
            axes.plot(*np.array([np.zeros(3), 1.25 * direction]).T, color=colour, linewidth=3)
        axes.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1), title=["before", order.split(",")[0], order][column])
        axes.view_init(25, 35)
        axes.set_box_aspect((1, 1, 1), zoom=1.3)
        axes.set_axis_off()
figure.savefig(folder / "two_turns.png", dpi=100)

apart = rot.angle_between(about_x @ about_z, about_z @ about_x)
print(f"the two results are {np.degrees(apart):.0f}° apart")
print("see", folder / "two_turns.png")
