"""Two NAOs face each other.

Learn how several robots stand in one scene, and how to ask where one is, seen from the other.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
new, old = nk.load_nao("v6"), nk.load_nao("v4")
T_world_old = nk.screws.pose(nk.rotations.rot_z(np.pi), [0.42, 0.0, 0.0])  # 42 cm ahead, and turned round

viewer = nk.Viewer(new)
q_new = new.posture("Stand", RArm=[0.0, -0.1, 1.2, 0.3, 0.0, 0.8])
q_old = old.posture("Stand", RArm=[0.0, -0.1, 1.2, 0.3, 0.0, 0.8])
viewer.display(q_new)
viewer.color_edition("blue")
viewer.add_robot(old, name="the old one", at=T_world_old).display(q_old)

# Both stand level on their soles, their torsos above the middle between their feet.
hands = []
for robot, q, T_world in ((new, q_new, np.eye(4)), (old, q_old, T_world_old)):
    T_robot_hand = nk.naoqi.pose_in(robot, q, "RArm", nk.naoqi.FRAME_ROBOT)
    hands.append(T_world @ T_robot_hand)
between = nk.screws.inverse(hands[0]) @ hands[1]
print(f"the right hands are {1000 * np.linalg.norm(between[:3, 3]):.0f} mm apart")
print(f"and turned by {np.degrees(nk.rotations.angle_between(np.eye(3), between[:3, :3])):.0f}°")
print("see", viewer.save_html(folder / "two_naos.html"))
