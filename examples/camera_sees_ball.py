"""Where is the ball in the picture?

Learn how to transform a point on the floor from the foot's frame to the camera's, and project it to a pixel.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

WIDTH, HEIGHT = 640, 480
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
q = nao.posture("Stand", HeadYaw=0.2, HeadPitch=0.1)

# In the optical frame, z points ahead, x to the right and y down.
T_camera_torso = nao.fk(q, "torso", reference="CameraBottom_optical_frame")
T_torso_foot = nao.fk(q, "LLeg")
ball_in_foot = [0.32, 0.1, 0.05]
ball_in_torso = nk.screws.transform_point(T_torso_foot, ball_in_foot)
x, y, z = nk.screws.transform_point(T_camera_torso, ball_in_torso)

# A pinhole camera: from the centre to the edge is the tangent of half the field of view.
half_width, half_height = np.tan(np.array(nao.semantics.fields_of_view["CameraBottom"]) / 2)
column = WIDTH / 2 * (1 + x / z / half_width)
row = HEIGHT / 2 * (1 + y / z / half_height)
print(f"the ball is {z:.3f} m ahead of the camera")
print(f"in the picture of {WIDTH} × {HEIGHT} it is at column {column:.0f}, row {row:.0f}")

edge = [[-half_width, -half_height, 1], [half_width, -half_height, 1], [half_width, half_height, 1]]
edge = 0.3 * np.array([*edge, [-half_width, half_height, 1]])  # the corners of the picture, held 30 cm away
eye = np.zeros(3)
sides = [eye, edge[0], edge[1], eye, edge[2], edge[3], eye]
viewer = nk.Viewer(nao)
viewer.display(q)
viewer.show_targets({"ball": ball_in_torso})
viewer.add_line("picture", [*edge, edge[0]], frame="CameraBottom_optical_frame", color=(0.1, 0.4, 0.8))
viewer.add_line("sides", sides, frame="CameraBottom_optical_frame", width=0.002)
viewer.add_line("ray", [eye, [x, y, z]], frame="CameraBottom_optical_frame", color=(0.9, 0.3, 0.1))
print("see", viewer.save_html(folder / "camera_sees_ball.html", overwrite=True))
