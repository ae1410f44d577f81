"""Gimbal lock.

Learn what happens to roll and yaw at a pitch of 90°: the body turns a little, and two angles jump.

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
pitch = np.radians(np.linspace(60, 120, 601))
tilt = rot.rot_x(np.radians([0.0, 0.1, 1.0, 5.0]))[:, None]  # the distance of each path from gimbal lock
found = rot.euler_from_matrix(tilt @ rot.rot_y(pitch), "zyx", axes="moving")  # yaw, pitch, roll
angles = np.degrees(found.angles)  # (4, 601, 3)

figure, plots = plt.subplots(1, 2, figsize=(8, 4), sharex=True, layout="constrained")
for number, name in ((2, "roll"), (1, "pitch")):
    axes = plots[0 if name == "roll" else 1]
    for distance, curve in zip((0, 0.1, 1, 5), angles[..., number]):
        axes.plot(np.degrees(pitch), curve, linewidth=2, label=f"{distance}° from lock")
    axes.set(xlabel="turn about y [°]", ylabel=f"{name} [°]")
    axes.grid(alpha=0.3)
figure.legend(*plots[0].get_legend_handles_labels(), loc="outside upper center", ncols=4, frameon=False)
figure.savefig(folder / "gimbal_lock.png", dpi=100)

print("locked:", [f"{np.degrees(turn):.0f}°" for turn in pitch[found.locked[0]]])
for distance, curve in zip((0, 0.1, 1, 5), angles[..., 2]):
    print(f"{distance:3}° from lock: roll jumps by up to {np.abs(np.diff(curve)).max():5.1f}° for a turn of 0.1°")
worst = np.abs(rot.matrix_from_euler(found.angles, "zyx", axes="moving") - tilt @ rot.rot_y(pitch)).max()
print("every triple still gives its rotation, to 1e-14:", bool(worst < 1e-14))
print("see", folder / "gimbal_lock.png")
