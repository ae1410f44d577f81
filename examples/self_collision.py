"""Links that collide.

Learn how to find links that overlap, how to measure the distance between links, and how to exclude solutions with
collisions.

Quicker with nao-kin[batch].
"""

import numpy as np

import nao_kin as nk

nao = nk.load_nao()

# The left hand in front of the belly.
q = nao.posture("StandInit", LShoulderRoll=-0.3, LElbowRoll=-1.2)
for contact in nao.collisions(q):
    print(contact.describe())

# The same position of the hand with another elbow: a search near each of 200 configurations.
hand = nao.position(q, "LArm")
starts = nao.random(rng=0, n=200, collision_free=True)
found = nk.ik.arm(nao, "L", np.tile(hand, (200, 1)), near=starts, collisions=True)
print(f"{np.count_nonzero(found.success)} of 200 solutions are free of collisions")
clearance = nao.clearance(found.q[found.success]).distance
print(f"the best has at least {1e3 * clearance.max():.1f} mm between any two links")

# Random configurations are inside the limits, but not always free of collisions.
share = nao.clearance(nao.random(rng=1, n=100_000)).is_free.mean()
print(f"{share:.0%} of 100 000 random configurations are free of collisions")
