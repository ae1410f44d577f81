"""The mean of many rotations.

Learn how noisy measurements of an orientation are averaged, and why the mean of their angles will not do.

Needs nao-kin[plot].
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from nao_kin import rotations as rot

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
true = rot.matrix_from_rpy(np.radians([20, 86, -30]))  # a head looks almost straight down
measured = rot.random_rotation_near(true, np.radians(6), 3, 500)  # (500, 3, 3), 6° about every axis

mean = rot.mean_rotation(measured)
of_angles = rot.matrix_from_rpy(rot.rpy_from_matrix(measured).mean(axis=0))
print(f"the measurements scatter by {np.degrees(mean.spread):.1f}°")
print(f"their mean is off by                     {np.degrees(rot.angle_between(mean.rotation, true)):5.2f}°")
print(f"the mean of roll, pitch and yaw is off by {np.degrees(rot.angle_between(of_angles, true)):4.2f}°")

figure = plt.figure(figsize=(5, 4.6))
axes = figure.add_axes((0, 0, 1, 1), projection="3d", computed_zorder=False)
u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 49), np.linspace(0, np.pi, 25))
sphere = 0.985 * np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
axes.plot_surface(*sphere, color="#e8edf3", linewidth=0, alpha=0.9, zorder=0)
axes.view_init(28, 35)
for column, colour in enumerate(("#c4572e", "#3a8f4d", "#1f6fb2")):
    for tips, size, shade in ((measured[:, :, column], 3, colour), (mean.rotation[None, :, column], 90, "#1f2937")):
        seen = tips @ [np.cos(0.49) * np.cos(0.61), np.cos(0.49) * np.sin(0.61), np.sin(0.49)] > 0  # the near side
        axes.scatter(*tips[seen].T, s=size, color=shade, marker="." if size < 9 else "+", zorder=2, depthshade=False)
axes.set_box_aspect((1, 1, 1), zoom=1.6)
axes.set_axis_off()
figure.savefig(folder / "mean_rotation.png", dpi=100)
print("see", folder / "mean_rotation.png")
