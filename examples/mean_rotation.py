"""The mean of many rotations.

Learn how to average noisy measurements of an orientation, and why the mean of their angles is wrong.

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

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
true = rot.matrix_from_rpy(np.radians([20, 86, -30]))  # a head looks almost straight down
measured = rot.random_rotation_near(true, np.radians(6), 3, 500)  # (500, 3, 3), 6° about every axis

mean = rot.mean_rotation(measured)
of_angles = rot.matrix_from_rpy(rot.rpy_from_matrix(measured).mean(axis=0))
print(f"the measurements scatter by {np.degrees(mean.spread):.1f}°")
print(f"their mean is off by                     {np.degrees(rot.angle_between(mean.rotation, true)):5.2f}°")
print(f"the mean of roll, pitch and yaw is off by {np.degrees(rot.angle_between(of_angles, true)):4.2f}°")

# The tips of the three axes on the unit sphere, seen from a direction in which all three are in front.
eye = true @ np.ones(3) / np.sqrt(3)
figure = plt.figure(figsize=(5, 5))
axes = figure.add_axes((0, 0, 1, 1), projection="3d", computed_zorder=False)
u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 37), np.linspace(0, np.pi, 19))
sphere = 0.99 * np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
axes.plot_surface(*sphere, color="#f3f5f8", edgecolor="#d5dbe3", linewidth=0.5, shade=False, zorder=0)
for column, colour in enumerate(("#c4572e", "#3a8f4d", "#1f6fb2")):
    axes.scatter(*measured[:, :, column].T, s=5, color=colour, zorder=1, depthshade=False)
    axes.scatter(*mean.rotation[:, column], s=160, color="#1f2937", marker="+", linewidth=2.5, zorder=2)
    axes.scatter(*of_angles[:, column], s=90, color="#1f2937", marker="x", linewidth=2, zorder=2)
axes.view_init(np.degrees(np.arcsin(eye[2])), np.degrees(np.arctan2(eye[1], eye[0])))
axes.set_box_aspect((1, 1, 1), zoom=1.7)
axes.set_axis_off()
figure.text(0.5, 0.04, "+ the mean    × the mean of the angles", ha="center")
figure.savefig(folder / "mean_rotation.png", dpi=100)
print("see", folder / "mean_rotation.png")
