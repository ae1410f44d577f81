"""NAOqi's Position6D, and back.

Learn how to convert NAOqi's six numbers and sixteen numbers to poses, and back.
"""

import numpy as np

import nao_kin as nk

nao = nk.load_nao()
q = nao.posture("StandInit")

# The result of getPosition("LArm", FRAME_ROBOT, True).
T_robot_hand = nk.naoqi.pose_in(nao, q, "LArm", nk.naoqi.FRAME_ROBOT)
six = nk.naoqi.position6d(T_robot_hand)
for name, number, unit in zip(("x", "y", "z", "wx", "wy", "wz"), six, ("m",) * 3 + ("rad",) * 3):
    print(f"{name:2} {number:8.5f} {unit}")

back = nk.naoqi.pose(six)
print("and back, to 1e-12:", bool(np.allclose(back, T_robot_hand, atol=1e-12)))
sixteen = nk.naoqi.transform_list(T_robot_hand)
print("getTransform's sixteen numbers begin with", np.round(sixteen[:4], 4))

# Recorded numbers have few digits; the result is an exact rotation all the same.
rounded = nk.naoqi.pose_from_list(np.round(sixteen, 4))
print("an exact rotation from four digits:", bool(nk.rotations.is_rotation(rounded[:3, :3], 1e-12)))
