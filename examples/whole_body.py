"""Reach down without falling over.

Learn how to find a configuration of the whole body: both feet stand, a hand is at a point, the head looks at it, and
the centre of mass is above the feet.

Quicker with nao-kin[batch].
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
stand = nao.posture("StandInit")
T_left, T_right = nao.fk(stand, ["LLeg", "RLeg"])
T_world_torso = nk.screws.inverse(T_left)  # a world with its origin in the left sole, z up
feet = {"L": np.eye(4), "R": T_world_torso @ T_right}
ball = np.array([0.17, 0.06, 0.15])  # [m]

pose = nk.ik.whole_body(
    nao, {"LArm": ball}, feet=feet, com="support", margin=0.015, gaze=(ball, "CameraBottom"), near=stand
)
hand = (pose.torso @ nao.fk(pose.q, "LArm"))[:3, 3]
print("found:", bool(pose.success))
print(f"the hand is {1000 * np.linalg.norm(hand - ball):.3f} mm from the ball, {100 * hand[2]:.0f} cm above the floor")
print(f"the centre of mass is {1000 * pose.margin:.0f} mm inside the support polygon")
print(f"the torso came down by {1000 * (T_world_torso[2, 3] - pose.torso[2, 3]):.0f} mm")

far = nk.ik.whole_body(nao, {"LArm": [0.6, 0.0, 0.1]}, feet=feet, com="support", restarts=3, near=stand)
print("farther away,", far.gives_way, "gives way:", far.reason.name)

viewer = nk.Viewer(nao)
viewer.display(pose.q, up=pose.torso[2, :3])
viewer.show_com()
viewer.show_support_polygon()
viewer.show_targets({"ball": nk.screws.transform_point(nk.screws.inverse(pose.torso), ball)})
print("see", viewer.save_html(folder / "whole_body.html", overwrite=True))
