"""An arm that follows a ball.

Learn how your program answers when a user drags a target in the page, and how it shows an image and a plot.
"""

import sys
from pathlib import Path

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
viewer = nk.Viewer(nao)
viewer.display(nao.posture("Stand"))


def follow(p, time=None):
    """Move the hand to the ball, and plot how far away it is."""
    found = nk.ik.arm(nao, "L", p, near=viewer.q)
    viewer.display(found.q)
    viewer.plot("distance [mm]", 1000 * np.linalg.norm(nao.position(found.q, "LArm") - p), time=time)


ball = viewer.add_target("ball", [0.15, 0.15, 0.1], on_move=follow)
for t in np.linspace(0.0, 4.0, 81):  # in place of a user who drags the ball
    ball.place([0.15, 0.15 + 0.2 * np.sin(1.5 * t), 0.1 + 0.1 * np.sin(t)])
    follow(ball.T, t)
distance = np.linalg.norm(nao.position(viewer.q, "LArm") - ball.T)
print(f"the hand is {1000 * distance:.0f} mm from the ball")

rows, columns = np.mgrid[0:240, 0:320]
image = np.stack([columns * 0.8, rows * 1.06, 0 * rows + 120], axis=-1).astype(np.uint8)  # take yours from the camera
viewer.show_image("CameraTop", image)
print("see", viewer.save_html(folder / "follow_ball.html", overwrite=True))
# In a program that keeps running, viewer.open() shows the page, and the arm follows the ball that you drag.
