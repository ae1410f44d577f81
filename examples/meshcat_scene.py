"""A NAO in your own meshcat scene.

Learn how to draw the robot into any meshcat scene, next to the objects of other programs, and how Pinocchio's own
visualizer shows it.
"""

import contextlib
import sys
from pathlib import Path

import meshcat
import numpy as np
from pinocchio.visualize import MeshcatVisualizer

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
nao = nk.load_nao()
q = nao.posture("Crouch", LArm=[0.2, 0.3, -1.4, -0.8, 0.0, 1.0])
with contextlib.redirect_stdout(sys.stderr):  # meshcat prints its address
    scene = (
        meshcat.Visualizer()
    )  # or the scene of a server that runs: meshcat.Visualizer(zmq_url="tcp://127.0.0.1:6000")

# Our own
shown = nk.viewer.MeshcatRobot(nao, scene, path="nao")
shown.display(q)
shown.show_frames(["LArm", "CameraTop"], size=0.08)
T_sole_root = nao.fk(q, nao.tree.root, reference="LLeg")
scene["nao"].set_transform(T_sole_root)  # on its left sole, which is at the origin
print("left hand in the scene:", (T_sole_root @ nao.fk(q, "LArm"))[:3, 3].round(3))

# Pinocchio's
pinocchio = MeshcatVisualizer(nao.model, nao.geometry("collision"), nao.geometry("visual"))
pinocchio.initViewer(viewer=scene, loadModel=True)
pinocchio.display(q)
scene["pinocchio"].set_transform(nk.screws.pose(np.eye(3), [0.0, -0.5, 0.0]) @ T_sole_root)
print(pinocchio.visual_model.ngeoms, "visual shapes,", pinocchio.collision_model.ngeoms, "collision shapes")

# A page of the scene needs no server.
page = folder / "meshcat_scene.html"
page.write_text(scene.static_html(), encoding="utf-8")
print("the scene is saved in", page.name)
scene.window.server_proc.terminate()
