"""A NAO that moves like a person before a webcam.

Learn how a program feeds landmarks of MediaPipe, frame by frame, to a robot: `pip install mediapipe opencv-python` and
a webcam, or without them a recorded bow.
"""

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from time import monotonic

import numpy as np

import nao_kin as nk

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
model = folder / "pose_landmarker.task"  # of ai.google.dev/edge/mediapipe/solutions/vision/pose_landmarker


def frames() -> Iterator[tuple[float, np.ndarray]]:
    """Yield time [s] and landmarks (33, 4), of a webcam or of a recording."""
    if not model.exists():
        recorded = json.loads(Path(nk.imitation.SAMPLES["bow"]).read_text(encoding="utf-8"))
        yield from zip(recorded["times"], np.array(recorded["landmarks"]), strict=True)
        return
    import cv2
    import mediapipe as mp

    vision, camera = mp.tasks.vision, cv2.VideoCapture(0)
    base = mp.tasks.BaseOptions(model_asset_path=str(model))
    options = vision.PoseLandmarkerOptions(base_options=base, running_mode=vision.RunningMode.VIDEO)
    with vision.PoseLandmarker.create_from_options(options) as landmarker:
        while (read := camera.read())[0]:
            ms = int(1000 * monotonic())
            image = mp.Image(image_format=mp.ImageFormat.SRGB, data=cv2.cvtColor(read[1], cv2.COLOR_BGR2RGB))
            for person in landmarker.detect_for_video(image, ms).pose_world_landmarks[:1]:
                yield ms / 1000.0, np.array([[p.x, p.y, p.z, p.visibility] for p in person])


with nk.naoqi.VirtualNao(stepped=True) as robot:  # for a real one: qi.Session().service("ALMotion").setAngles(…)
    viewer = nk.Viewer(robot.robot)
    follower = nk.imitation.Imitator(robot.robot, "mediapipe", mirror=True)
    joints = list(follower.joints)
    columns = [robot.robot.joint_names.index(name) for name in joints]
    robot.call("ALMotion", "wakeUp")
    for time, landmarks in frames():
        q = follower.step(landmarks, time)
        robot.call("ALMotion", "setAngles", joints, q[columns].tolist(), 0.8)
        viewer.display(q)  # viewer.open() before the loop shows it live
    print("the head is bowed by", f"{np.degrees(follower.q[robot.robot.joint_names.index('HeadPitch')]):.0f}°")
    print("see", viewer.save_html(folder / "webcam.html", overwrite=True))
