"""Where a hand can be.

Learn how to compute a map of the positions that a hand reaches, and how to query it.

Quicker with nao-kin[batch].
"""

import sys
from pathlib import Path

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
reach = nk.reach.workspace(nao, "LArm", samples=200_000, voxel=0.02, seed=0)

print(f"{reach.samples:,} samples fell into {len(reach.centres):,} voxels of 2 cm: {1000 * reach.volume:.1f} litres")
for name, point in {"before the chest": [0.15, 0.05, 0.1], "behind the back": [-0.15, 0.0, 0.0]}.items():
    can = "reaches" if reach.reachable(point) else "does not reach"
    print(f"{name}: the left hand {can} {point} m")
best = reach.centres[reach.best.argmax()]
print("it moves most freely at", [round(float(number), 2) for number in best], "m")

viewer = nk.Viewer(nao)
viewer.display(nao.posture("StandInit"))
viewer.show_reach(reach, by="best", cut=("x", 0.0))  # red: moves well in all directions
print("see", viewer.save_html(folder / "workspace.html", overwrite=True))
