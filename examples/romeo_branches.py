"""All ways to reach a pose, for another robot.

Learn how to get all solutions for a limb of any robot, here the seven joints of Romeo's arm, of which one is locked.

Needs nao-kin[analytic].
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

JOINTS = ["LShoulderPitch", "LShoulderYaw", "LElbowRoll", "LElbowYaw", "LWristRoll", "LWristYaw", "LWristPitch"]
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
try:
    romeo = nk.load_robot("romeo")
    q = romeo.neutral()
    q[[romeo.joint_names.index(joint) for joint in JOINTS]] = 0.6, 0.4, -0.7, -0.9, 0.3, 0.2, -0.2
    T_torso_wrist = romeo.fk(q, "LWristPitch", reference="torso")
    arm = {"robot": romeo, "frame": "LWristPitch", "target": T_torso_wrist, "reference": "torso"}
    free = nk.ik.analytic(**arm, locked={"LWristRoll": 0.3}, limits="ignore")
except nk.errors.MissingExtra as error:
    sys.exit(str(error))

print("     ", "  ".join(f"{joint:>14}" for joint in free.joints))
for number, solution in enumerate(free.solutions, start=1):
    angles = "  ".join(f"{angle:13.1f}°" for angle in np.degrees(solution[list(free.columns)]))
    print(f"{number}     {angles}  {'inside' if romeo.within_limits(solution) else 'outside'} the limits")
worst = np.abs(romeo.fk(free.solutions, "LWristPitch", reference="torso") - T_torso_wrist).max()
print("all have the wrist at the same pose, to 1e-12:", bool(worst < 1e-12))

# The seventh joint is a freedom: for each value the other six follow, and the elbow moves on a circle.
circle = []
for roll in np.linspace(-2.0, 0.5, 6):
    found = nk.ik.analytic(**arm, locked={"LWristRoll": roll}, near=q)
    circle += list(found.solutions[: found.count])
    print(f"LWristRoll {np.degrees(roll):6.1f}°: {found.message}")

viewer = nk.Viewer(romeo)
viewer.display(q)
viewer.show_ghosts(circle, opacity=0.3)
print("see", viewer.save_html(folder / "romeo_branches.html", overwrite=True))
