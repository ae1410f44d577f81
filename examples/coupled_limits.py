"""Limits that depend on another joint.

Learn that the range of a foot's roll depends on the pitch of its ankle, and how the library enforces this limit.

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

wanted = nao.configuration({"LAnklePitch": 0.8, "LAnkleRoll": 0.6}, limits="ignore")
print(nao.limit_violations(wanted)[0])
clamped = nao.angles(nao.clamp(wanted))
print(f"clamped to LAnkleRoll = {clamped['LAnkleRoll']:.4f}")

q = nao.random(rng=0, n=4000)
pitch, roll = (np.degrees(q[:, nao.joint_names.index(name)]) for name in ("LAnklePitch", "LAnkleRoll"))
figure, axes = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
axes.scatter(pitch, roll, s=2, color="#1f6fb2", alpha=0.4, label="random configurations")
for limit in nao.coupled_limits:
    if limit.joint == "LAnkleRoll":
        at, lower, upper = (np.degrees(numbers) for numbers in (limit.at, limit.lower, limit.upper))
        axes.plot([*at, *at[::-1], at[0]], [*upper, *lower[::-1], upper[0]], color="#1f2937", label="the limit")
before, after = np.degrees([0.8, 0.6]), np.degrees([clamped["LAnklePitch"], clamped["LAnkleRoll"]])
axes.annotate("", after, before, arrowprops={"arrowstyle": "->", "color": "#c4572e", "linewidth": 2})
axes.plot(*before, "o", color="#c4572e", label="wanted, and clamped")
axes.set(xlabel="LAnklePitch [°]", ylabel="LAnkleRoll [°]", ylim=(-28, 62))
axes.legend(loc="upper left", ncols=3, frameon=False, fontsize=9)
axes.grid(alpha=0.3)
figure.savefig(folder / "coupled_limits.png", dpi=100)
print("see", folder / "coupled_limits.png")
