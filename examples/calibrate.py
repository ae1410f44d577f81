"""Find out how a robot is really built.

Learn how to find the zeros of joints and the mounting of a camera from pictures of marks on the robot's own hand.

Needs nao-kin[calibration].
"""

import numpy as np

import nao_kin as nk

nao = nk.load_nao()
rng = np.random.default_rng(0)

# The real robot, with offsets that the calibration does not know.
real = nao.with_offsets({"HeadYaw": 0.03, "LElbowYaw": -0.05}, {"CameraTop": (0, 0, 0, 0.02, -0.03, 0.01)})
camera = nk.world.camera(nao, "CameraTop")
marks = np.array([[x, y, 0.01] for x in (0.0, 0.03, 0.06) for y in (-0.02, 0.02)])  # in the frame LArm [m]


def look_at_the_hand(robot, q):
    """Return the pixels of the marks, and whether all are in the picture."""
    T_camera_hand = nk.screws.inverse(robot.fk(q, "CameraTop")) @ robot.fk(q, "LArm")
    pixels = camera.project(nk.screws.transform_point(T_camera_hand[:, None], marks))
    return pixels, camera.sees(pixels).all(axis=1)


q = nao.random(rng, 2000)
q = q[look_at_the_hand(real, q)[1]][:20]
pixels = look_at_the_hand(real, q)[0] + rng.normal(0.0, 0.5, (20, 6, 2))

seen = nk.calibration.Pixels(q, camera, pixels, marks, frame="LArm", noise=0.5)
angles = ["roll", "pitch", "yaw"]
try:
    found = nk.calibration.calibrate(nao, [seen], joints=["HeadYaw", "LElbowYaw"], frames={"CameraTop": angles})
except nk.errors.MissingExtra as error:
    raise SystemExit(str(error)) from None
for (label, deviation), value, unit in zip(found.standard_deviations.items(), found.values, found.units):
    # The lens was not measured: its numbers are estimated too, as parts of its own.
    scale = np.degrees(1.0) if unit == "rad" else 1.0
    print(f"{label}: {scale * value:.3f} ± {scale * deviation:.3f}{'°' if unit == 'rad' else ''}")
print(found.save("nao_7.toml", overwrite=True))
