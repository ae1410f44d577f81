"""Crouch with both feet in place.

Learn how to solve both legs together, because one motor drives both hips.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
stand = nao.posture("StandInit")
T_left, T_right = nao.fk(stand, ["LLeg", "RLeg"])  # the feet in the torso

for lower in (0.02, 0.04, 0.06, 0.08):
    up = np.eye(4)
    up[2, 3] = lower  # the torso goes down: seen from it, the feet come up
    found = nk.ik.legs(nao, up @ T_left, up @ T_right, near=stand)
    angles = nao.angles(found.q)
    print(
        f"{1000 * lower:2.0f} mm lower: knees {np.degrees(angles['LKneePitch']):5.1f}°, "
        f"ankles {np.degrees(angles['LAnklePitch']):5.1f}°, {found.message}"
    )

turned = T_left.copy()
turned[:3, :3] = turned[:3, :3] @ nk.rotations.rot_z(0.2)  # the left toes outwards, the right foot unchanged
print("one foot turned:", nk.ik.legs(nao, turned, T_right, near=stand).message)

viewer = nk.Viewer(nao)
viewer.display(found.q)
viewer.show_com()
viewer.show_support_polygon()
viewer.add_robot(nao, name="before").display(stand)
print("see", viewer.save_html(folder / "crouch.html", overwrite=True))
