"""Another robot: Romeo.

Learn how to use the library with other robots, here with Romeo and numeric inverse kinematics.

Needs nao-kin[robots].
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
try:
    romeo = nk.load_robot("romeo")
except nk.errors.MissingExtra as error:
    sys.exit(str(error))
print(f"{romeo.name}: {romeo.nq} joints, {romeo.mass:.1f} kg")

q = romeo.neutral()
T = romeo.fk(q, "LWristPitch")
T[:3, 3] += [0.1, 0.05, 0.1]
found = nk.ik.numeric(romeo, "LWristPitch", T, near=q)
print("the left wrist moved by 15 cm:", found.message)
moved = [name for name, before, now in zip(romeo.joint_names, q, found.q) if abs(now - before) > 1e-3]
print("moved:", ", ".join(moved))

viewer = nk.Viewer(romeo)
viewer.display(found.q)
viewer.show_targets({"wrist": T})
nao = viewer.add_robot(nk.load_nao(), at=nk.screws.pose(np.eye(3), [0.0, 0.75, 0.0]))
nao.display(nk.load_nao().posture("Stand"))
print("see", viewer.save_html(folder / "romeo.html", overwrite=True))
