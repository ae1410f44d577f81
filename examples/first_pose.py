"""A first pose.

Learn how to compute the positions of a NAO's hands, feet and cameras, and how to display them.
"""

import sys
from pathlib import Path

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
frames = ["LArm", "RArm", "LLeg", "RLeg", "CameraTop"]  # NAOqi's names; an arm's frame is in the hand

nao = nk.load_nao("v6")
q = nao.posture("StandInit")  # 25 joint values [rad]
T_torso_frame = nao.fk(q, frames)  # (5, 4, 4): rotation and position in the torso's frame [m]

for name, T in zip(frames, T_torso_frame):
    x, y, z = 1000 * T[:3, 3]
    print(f"{name:9} x {x:7.1f}   y {y:7.1f}   z {z:7.1f} mm")

viewer = nk.Viewer(nao)
viewer.display(q)
viewer.show_frames(["torso", *frames], size=0.08)
print("see", viewer.save_html(folder / "first_pose.html", overwrite=True))
