"""The path of a hand.

Learn how to compute the path of a hand from a batch of configurations, here while one joint after the other turns.

Needs nao-kin[plot].
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

try:
    import matplotlib.pyplot as plt
except ImportError:
    sys.exit("matplotlib draws this: pip install 'nao-kin[plot]'")

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
stand = nao.posture("StandInit")
turns = {
    "LShoulderPitch": [1.4, 0.0],
    "LShoulderRoll": [0.3, 1.2],
    "LElbowRoll": [-1.0, -0.1],
    "LElbowYaw": [-1.4, 1.4],
}

figure, (side, front) = plt.subplots(1, 2, figsize=(7, 4.0), sharey=True, layout="constrained")
q = stand
for joint, (start, end) in turns.items():
    # One row for each step; the joints that turned before keep their last values.
    path = np.repeat(q[None], 101, axis=0)
    path[:, nao.joint_names.index(joint)] = np.linspace(start, end, 101)
    hand = nao.position(path, "LArm")  # (101, 3)
    length = np.linalg.norm(np.diff(hand, axis=0), axis=1).sum()
    print(f"{joint:14} {start:4.1f} to {end:4.1f} rad moves the hand along {1000 * length:5.1f} mm")
    side.plot(hand[:, 0], hand[:, 2], linewidth=2.5, label=joint)
    front.plot(hand[:, 1], hand[:, 2], linewidth=2.5)
    q = path[-1]

for axes, column, label in ((side, 0, "x, ahead [m]"), (front, 1, "y, to the left [m]")):
    # The shoulder, the elbow and the hand at the end.
    arm = nao.position(q, ["LShoulderPitch", "LElbowYaw", "LArm"])
    axes.plot(arm[:, column], arm[:, 2], "o-", color="0.6", zorder=0)
    axes.set(xlabel=label, aspect="equal", xlim=[(-0.02, 0.24), (0.08, 0.34)][column])
    axes.grid(alpha=0.3)
side.set_ylabel("z, up [m]")
figure.legend(loc="outside upper center", ncols=4, frameon=False)
figure.savefig(folder / "hand_path.png", dpi=100)
print("see", folder / "hand_path.png")
