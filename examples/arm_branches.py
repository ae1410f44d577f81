"""All ways to hold a hand.

Learn that inverse kinematics has several answers: here every branch of an arm for one pose of the hand.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
q = nao.posture("StandInit", LArm=[0.2, 0.35, -1.2, -0.9, 0.3, 0.6])
T_torso_hand = nao.fk(q, "LArm")

found = nk.ik.arm(nao, "L", T_torso_hand, reference=q, limits="ignore")
columns = [nao.joint_names.index(joint) for joint in nao.chains["LArm"][:5]]
print("    ", "  ".join(f"{joint[1:]:>13}" for joint in nao.chains["LArm"][:5]))
for number, solution in enumerate(found.solutions, start=1):
    angles = "  ".join(f"{angle:12.1f}°" for angle in np.degrees(solution[columns]))
    print(f"{number}    {angles}  {'inside' if nao.within_limits(solution) else 'outside'} the limits")
worst = np.abs(nao.fk(found.solutions, "LArm") - T_torso_hand).max()
print("all have the hand at the same pose, to 1e-12:", bool(worst < 1e-12))

viewer = nk.Viewer(nao)
viewer.display(found.solutions[0])
viewer.show_ghosts(found.solutions[1:], first=2, opacity=0.45)
print("see", viewer.save_html(folder / "arm_branches.html"))
