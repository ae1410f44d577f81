"""The screw of a displacement.

Learn that every change of pose, here that of a hand, is a rotation about a line and a translation along it.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
before = nao.posture("StandInit")
after = nao.posture("StandInit", LShoulderPitch=0.2, LShoulderRoll=0.9, LElbowYaw=-0.3)
T_before, T_after = nao.fk(before, "LArm"), nao.fk(after, "LArm")

screw = nk.screws.Screw.from_pose(T_after @ nk.screws.inverse(T_before))  # in the torso's frame
print(f"turn   {np.degrees(screw.angle):6.2f}°")
print(f"slide  {1000 * screw.slide:6.2f} mm")
print("along ", np.round(screw.axis.direction, 4))
print("through", np.round(screw.axis.point, 4), "m")

steps = nk.screws.sclerp(T_before, T_after, np.linspace(0, 1, 61))  # poses along the screw, at constant speed
middle = screw.axis.closest_point(T_before[:3, 3])
viewer = nk.Viewer(nao)
viewer.display(after)
viewer.show_ghosts(before)
ends = middle + np.outer([-0.18, 0.18], screw.axis.direction)
viewer.add_line("axis", ends, color=(0.15, 0.2, 0.3), frame="torso")
viewer.add_line("way", steps[:, :3, 3], color=(0.9, 0.3, 0.1), width=0.006, frame="torso")
for part in (0, 20, 40, 60):
    hand = steps[part, :3, 3]
    viewer.add_line(f"radius {part}", [screw.axis.closest_point(hand), hand], width=0.002, frame="torso")
print("see", viewer.save_html(folder / "screw_of_a_displacement.html", overwrite=True))
