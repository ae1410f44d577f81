"""A million configurations.

Learn how to compute with arrays of configurations: how often do the two hands of a NAO meet by chance?

Quicker with nao-kin[batch].
"""

import numpy as np

import nao_kin as nk

nao = nk.load_nao()
q = nao.random(rng=0, n=1_000_000)  # (1000000, 25), inside all limits, including coupled ones
hands = nao.position(q, ["LArm", "RArm"])  # (1000000, 2, 3) [m]
apart = np.linalg.norm(hands[:, 0] - hands[:, 1], axis=-1)

print(f"{len(q):,} configurations, {hands.size:,} numbers")
print(f"the hands are between {1000 * apart.min():.1f} and {1000 * apart.max():.1f} mm apart")
for closer in (0.05, 0.10, 0.20, 0.40):
    print(f"closer than {100 * closer:2.0f} cm: {100 * np.mean(apart < closer):6.3f} %")
