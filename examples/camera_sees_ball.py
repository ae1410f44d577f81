"""Where is the ball in the picture?

Learn how to project a point on the floor to a pixel of a camera, and how to get from the pixel back to the floor.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
q = nao.posture("Stand", HeadYaw=0.2, HeadPitch=0.1)
camera = nk.world.camera(nao, "CameraBottom", "VGA")

# The world has the floor at z = 0; the robot stands on it.
T_world_torso = nao.set_down(q).T_world_base
T_world_foot = T_world_torso @ nao.fk(q, "LLeg")
ball = nk.screws.transform_point(T_world_foot, [0.32, 0.1, 0.05])  # its centre
pixel = nk.world.project(nao, q, ball, camera).pixels
print(f"in the picture of {camera.width} × {camera.height} the ball is at column {pixel[0]:.0f}, row {pixel[1]:.0f}")

# Back to the floor: the centre of the ball is on the plane at the height of its radius.
radius = ball[2]
seen = nk.world.pixel_to_ground(nao, q, pixel, camera, height=radius).points
covariance = nk.world.ground_covariance(nao, q, pixel, camera, height=radius, joint_noise=np.radians(0.5))
ahead, aside = np.sqrt(np.diag(covariance))
print(f"it is {seen[0]:.3f} m ahead and {seen[1]:.3f} m to the left, ± {ahead:.3f} m and ± {aside:.3f} m")

eye = nk.world.camera_pose(nao, q, camera)[:3, 3]
corners = nk.world.visible_ground(nao, q, camera)
viewer = nk.Viewer(nao)
viewer.display(q)
viewer.show_targets({"ball": nk.screws.transform_point(nk.screws.inverse(T_world_torso), seen)})  # in the torso
viewer.add_line("seen ground", [*corners, corners[0]], color=(0.1, 0.4, 0.8))
viewer.add_line("sides", [point for corner in corners for point in (eye, corner)], width=0.002)
viewer.add_line("ray", [eye, seen], color=(0.9, 0.3, 0.1))
print("see", viewer.save_html(folder / "camera_sees_ball.html", overwrite=True))
