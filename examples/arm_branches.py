"""All ways to reach a pose with a hand.

Learn that inverse kinematics has several solutions: four for a pose of the hand, and a whole family for its position
alone.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
q = nao.posture("StandInit", LArm=[0.65, 0.0, -1.6, -1.2, 0.0, 0.6])
T_torso_hand = nao.fk(q, "LArm")

found = nk.ik.arm(nao, "L", T_torso_hand, near=q, limits="ignore")
columns = [nao.joint_names.index(joint) for joint in nao.chains["LArm"][:5]]
print("    ", "  ".join(f"{joint[1:]:>13}" for joint in nao.chains["LArm"][:5]))
for number, solution in enumerate(found.solutions, start=1):
    angles = "  ".join(f"{angle:12.1f}°" for angle in np.degrees(solution[columns]))
    print(f"{number}    {angles}  {'inside' if nao.within_limits(solution) else 'outside'} the limits")
worst = np.abs(nao.fk(found.solutions, "LArm") - T_torso_hand).max()
print("all have the hand at the same pose, to 1e-12:", bool(worst < 1e-12))

# The position alone leaves two freedoms; the solution is the one nearest to the wish.
place = T_torso_hand[:3, 3]
wishes = [nao.posture("StandInit", LShoulderPitch=pitch, LElbowYaw=yaw) for pitch, yaw in ((0.1, -0.4), (-0.6, 1.5))]
family = np.array([nk.ik.arm(nao, "L", place, near=wish).q for wish in wishes])
for number, solution in enumerate(family, start=5):
    elbow = 1000 * nao.position(solution, "LElbowYaw")
    print(
        f"{number}    the same position of the hand, the elbow at ({elbow[0]:.0f}, {elbow[1]:.0f}, {elbow[2]:.0f}) mm"
    )

viewer = nk.Viewer(nao)
viewer.display(q)
viewer.show_ghosts(family, first=5, opacity=0.5)
print("see", viewer.save_html(folder / "arm_branches.html", overwrite=True))
