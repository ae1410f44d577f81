"""A camera with its measured mounting.

Learn how to give a robot the measured mounting of a camera and the zero of a joint, and see their effect.
"""

import numpy as np

import nao_kin as nk

nao = nk.load_nao()
q = nao.posture("StandInit", HeadYaw=0.2)

# Found by a calibration: the camera looks 1.5° further down and is 2 mm higher, and the neck's zero is off by 1°.
offsets = {
    "joints": {"HeadYaw": np.radians(1.0)},  # true angle = reported angle + offset
    "frames": {"CameraTop": (0.0, 0.0, 0.002, 0.0, np.radians(1.5), 0.0)},  # dx, dy, dz, roll, pitch, yaw
}
mine = nk.load_nao(offsets=offsets)
for note in mine.load_notes:
    print(note)


def on_the_ground(robot):
    """Return the point of the ground at the centre of the camera's picture, in the left sole."""
    T_sole_camera = robot.fk(q, "CameraTop", reference="LLeg")
    eye, ahead = T_sole_camera[:3, 3], T_sole_camera[:3, 0]
    return eye - eye[2] / ahead[2] * ahead


nominal, true = on_the_ground(nao), on_the_ground(mine)
print("by the data sheet it looks at", nominal[:2].round(2), "m")
print("in truth it looks at", true[:2].round(2), "m")
print(f"a ball there is {np.linalg.norm(true - nominal):.2f} m from where it seemed to be")
