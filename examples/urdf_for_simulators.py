"""A URDF for PyBullet and Drake.

Learn how to export a robot for tools that support less than URDF, and how each change is reported.
"""

import tempfile
from pathlib import Path

import numpy as np

import nao_kin as nk

nao = nk.load_nao()
with tempfile.TemporaryDirectory() as temporary:
    # Fixed joints are merged, so that no massless frame remains; inertias are made physical.
    done = nk.export.urdf(nao, Path(temporary) / "nao.urdf", frames="none", meshes="none", inertia="physical")
    written = nk.RobotModel.from_urdf(done.path)

print(f"{len(nao.link_names)} links became {len(written.link_names)}, {nao.mass:.3f} kg stayed {written.mass:.3f} kg")
print(f"{len(done.changes)} changes, the first ones:")
for change in done.changes[:3]:
    print(" ", change)

q = nao.random(rng=0, n=100)
there = written.fk(written.configuration(nao.angles(q)), "l_ankle", reference="Head")
difference = np.abs(there - nao.fk(q, "l_ankle", reference="Head")).max()
print("every pose is the same, to 1e-12:", bool(difference < 1e-12))
