"""A URDF for PyBullet and Drake.

Learn how one robot is written for tools that read less of a URDF, and how each change is said.
"""

import tempfile
from pathlib import Path

import numpy as np

import nao_kin as nk

nao = nk.load_nao()
with tempfile.TemporaryDirectory() as temporary:
    # Fixed joints merged, so that no frame without a mass remains; inertias that a body can have.
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
