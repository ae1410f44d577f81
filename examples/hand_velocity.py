"""How fast is the hand?

Learn how a Jacobian maps joint velocities to the velocity of a hand, and how to find joint velocities for a wanted
velocity of the hand.
"""

import numpy as np

import nao_kin as nk

nao = nk.load_nao()
q = nao.posture("StandInit")
v = np.zeros(nao.nv)
v[nao.joint_names.index("LShoulderPitch")] = -1.0  # [rad/s]
v[nao.joint_names.index("LElbowRoll")] = 0.5

J = nao.jacobian(q, "LArm")  # (6, 25): linear rows first, in the axes of the torso
twist = J @ v
print("linear  ", np.round(twist[:3], 4), "m/s")
print("angular ", np.round(twist[3:], 4), "rad/s")

# The same from a finite difference, without the Jacobian.
step = 1e-6
moved = nao.position(q + step * v, "LArm") - nao.position(q - step * v, "LArm")
print("a finite difference agrees to 1e-8 m/s:", bool(np.allclose(moved / (2 * step), twist[:3], atol=1e-8)))

# The inverse: the smallest joint velocities that raise the hand by 10 cm/s, with any angular velocity.
wanted = [0.0, 0.0, 0.1]
v = np.linalg.pinv(J[:3]) @ wanted
for joint in nao.chains["LArm"][:4]:
    print(f"{joint:14} {v[nao.joint_names.index(joint)]:7.4f} rad/s")
print("the hand then moves with", np.round(J[:3] @ v, 4) + 0.0, "m/s")
