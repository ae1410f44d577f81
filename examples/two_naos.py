"""Two NAOs shake hands.

Learn how to show several robots in one scene, and how to compute the pose of one relative to the other.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
new, old = nk.load_nao("v6"), nk.load_nao("v4")
arm = [0.25, 0.25, 1.2, 0.5, 0.6, 0.8]
q_new, q_old = new.posture("Stand", RArm=arm), old.posture("Stand", RArm=arm)

# FRAME_ROBOT is on the floor, between the feet.
T_new_hand = nk.naoqi.pose_in(new, q_new, "RArm", nk.naoqi.FRAME_ROBOT)
x, y, _ = T_new_hand[:3, 3]
T_new_old = nk.screws.pose(nk.rotations.rot_z(np.pi), [2 * x + 0.02, 2 * y, 0.0])  # in front, facing the first
T_old_hand = nk.naoqi.pose_in(old, q_old, "RArm", nk.naoqi.FRAME_ROBOT)
between = nk.screws.inverse(T_new_hand) @ T_new_old @ T_old_hand
print(f"the robots stand {1000 * np.linalg.norm(T_new_old[:3, 3]):.0f} mm apart")
print(f"their right hands are {1000 * np.linalg.norm(between[:3, 3]):.0f} mm apart")
print(f"and turned by {np.degrees(nk.rotations.angle_between(np.eye(3), between[:3, :3])):.0f}°")

viewer = nk.Viewer(new)
viewer.display(q_new)
viewer.add_robot(old, name="the old one", at=T_new_old).display(q_old)
print("see", viewer.save_html(folder / "two_naos.html", overwrite=True))
