"""Look at a point.

Learn how the head turns a camera towards a point, and what is reported for a point that it cannot see.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
q = nao.posture("Stand")
points = {"hand": [0.2, 0.25, -0.1], "ball": [0.25, -0.15, -0.1], "heel": [-0.4, 0.0, -0.3]}

for name, point in points.items():
    found = nk.ik.look_at(nao, point, "CameraBottom", near=q)
    yaw, pitch = (np.degrees(nao.angles(found.q)[joint]) for joint in ("HeadYaw", "HeadPitch"))
    print(f"{name}: yaw {yaw:6.1f}°, pitch {pitch:5.1f}°, {found.message}")

found = nk.ik.look_at(nao, points["ball"], "CameraBottom", near=q)
camera = nao.position(found.q, "CameraBottom")
viewer = nk.Viewer(nao)
viewer.display(found.q)
viewer.show_targets({"ball": points["ball"]})
viewer.add_line("gaze", [camera, points["ball"]], color=(0.9, 0.3, 0.1), frame="torso")
print("see", viewer.save_html(folder / "look_at.html", overwrite=True))
