"""Sensor and effector frames of V6, and what they are for.

Where a source prints π or π/2 with five to seven digits (3.14159, 1.5708), the exact value is meant and stands here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from nao_kin._common.arrays import Vector
from nao_kin.parameters.rows import FrameRow, Version
from nao_kin.parameters.skeleton import FOOT_HEIGHT, HAND_OFFSET_X, HAND_OFFSET_Z, LEG_EFFECTOR_HEIGHT

# fmt: off
V6_FRAMES: tuple[FrameRow, ...] = (
    FrameRow("Accelerometer", "ImuTorsoAccelerometer_frame", "torso", (-0.008, 0.00606, 0.027), (0.0, 0.0, 0.0), "U6"),
    FrameRow("ChestBoard/Button", "ChestButton_frame", "torso", (0.049871, 0.001588, 0.055163), (0.0, 0.0, 0.0), "U6"),
    FrameRow("Gyrometer", "ImuTorsoGyrometer_frame", "torso", (-0.008, 0.006, 0.029), (0.0, 0.0, 0.0), "U6"),
    FrameRow("Sonar/Left", "LSonar_frame", "torso", (0.00558253, 0.0192068, 0.0623853), (-0.00478508, 0.0436497, 0.392441), "U6"),
    FrameRow("Sonar/Right", "RSonar_frame", "torso", (0.00558253, -0.0192068, 0.0623853), (0.00478508, 0.0436497, -0.392441), "U6"),
    FrameRow("CameraBottom", "CameraBottom_frame", "HeadPitch", (0.05071, 0.0, 0.01774), (0.0, 0.692896, 0.0), "U6"),
    FrameRow("CameraTop", "CameraTop_frame", "HeadPitch", (0.05871, 0.0, 0.06364), (0.0, 0.0209435, 0.0), "U6"),
    FrameRow("Gaze", "gaze", "HeadPitch", (0.043, 0.0, 0.0428), (0.0, 0.0, 0.0), "U6"),
    FrameRow("Head/Touch/Front", "HeadTouchFront_frame", "HeadPitch", (0.0312, 0.0, 0.1014), (0.0, -1.1861, 0.0), "U6"),
    FrameRow("Head/Touch/Middle", "HeadTouchMiddle_frame", "HeadPitch", (0.001, 0.0, 0.1099), (0.0, -math.pi / 2, 0.0), "U6"),
    FrameRow("Head/Touch/Rear", "HeadTouchRear_frame", "HeadPitch", (-0.0257, 0.0, 0.1045), (math.pi, -1.33319, math.pi), "U6"),
    FrameRow("MicroFrontLeft", None, "HeadPitch", (0.020626, 0.030938, 0.098582), (0.0, 0.0, 0.0), "U6"),
    FrameRow("MicroFrontRight", None, "HeadPitch", (0.020626, -0.030938, 0.098582), (0.0, 0.0, 0.0), "U6"),
    FrameRow("MicroRearLeft", None, "HeadPitch", (-0.021544, 0.055772, 0.077426), (0.0, 0.0, 0.0), "U6"),
    FrameRow("MicroRearRight", None, "HeadPitch", (-0.021544, -0.055772, 0.077426), (0.0, 0.0, 0.0), "U6"),
    FrameRow("MicrophoneFrame", None, "HeadPitch", (-0.000459, 0.0, 0.088004), (0.0, 0.0, 0.0), "U6"),
    FrameRow("SpeakerLeft", None, "HeadPitch", (0.0038, 0.0453, 0.0526), (0.0, 0.0, math.pi / 2), "U6"),
    FrameRow("SpeakerRight", None, "HeadPitch", (0.0038, -0.0453, 0.0526), (0.0, 0.0, -math.pi / 2), "U6"),
    FrameRow("LArm", "l_gripper", "LWristYaw", (HAND_OFFSET_X, 0.0, -HAND_OFFSET_Z), (0.0, 0.0, 0.0), "BP6"),
    FrameRow("LHand/Touch/Back", "LHandTouchBack_frame", "LWristYaw", (0.038, 0.0, 0.025), (0.0, -math.pi / 2, 0.0), "U6"),
    FrameRow("LHand/Touch/Left", "LHandTouchLeft_frame", "LWristYaw", (0.032, 0.025, 0.003), (0.0, 0.0, math.pi / 2), "U6"),
    FrameRow("LHand/Touch/Right", "LHandTouchRight_frame", "LWristYaw", (0.035, -0.025, 0.0035), (0.0, 0.0, -math.pi / 2), "U6"),
    FrameRow("LLeg", "l_sole", "LAnkleRoll", (0.0, 0.0, -LEG_EFFECTOR_HEIGHT), (0.0, 0.0, 0.0), "MIM"),
    FrameRow("LFoot/Bumper/Left", "LFootBumperLeft_frame", "LAnkleRoll", (0.0876, 0.019, -0.0353), (0.0, 0.0, 0.0), "U6"),
    FrameRow("LFoot/Bumper/Right", "LFootBumperRight_frame", "LAnkleRoll", (0.0876, -0.014, -0.0353), (0.0, 0.0, 0.0), "U6"),
    FrameRow("LFoot/FSR/FrontLeft", "LFsrFL_frame", "LAnkleRoll", (0.07025, 0.0299, -LEG_EFFECTOR_HEIGHT), (0.0, 0.0, 0.0), "U6"),
    FrameRow("LFoot/FSR/FrontRight", "LFsrFR_frame", "LAnkleRoll", (0.07025, -0.0231, -LEG_EFFECTOR_HEIGHT), (0.0, 0.0, 0.0), "U6"),
    FrameRow("LFoot/FSR/RearLeft", "LFsrRL_frame", "LAnkleRoll", (-0.03025, 0.0299, -LEG_EFFECTOR_HEIGHT), (0.0, 0.0, 0.0), "U6"),
    FrameRow("LFoot/FSR/RearRight", "LFsrRR_frame", "LAnkleRoll", (-0.02965, -0.0191, -LEG_EFFECTOR_HEIGHT), (0.0, 0.0, 0.0), "U6"),
    FrameRow("LFoot/Sole", None, "LAnkleRoll", (0.0, 0.0, -FOOT_HEIGHT), (0.0, 0.0, 0.0), "L6"),
    FrameRow("RLeg", "r_sole", "RAnkleRoll", (0.0, 0.0, -LEG_EFFECTOR_HEIGHT), (0.0, 0.0, 0.0), "MIM"),
    FrameRow("RFoot/Bumper/Left", "RFootBumperLeft_frame", "RAnkleRoll", (0.0876, 0.014, -0.0353), (0.0, 0.0, 0.0), "U6"),
    FrameRow("RFoot/Bumper/Right", "RFootBumperRight_frame", "RAnkleRoll", (0.0876, -0.019, -0.0353), (0.0, 0.0, 0.0), "U6"),
    FrameRow("RFoot/FSR/FrontLeft", "RFsrFL_frame", "RAnkleRoll", (0.07025, 0.0231, -LEG_EFFECTOR_HEIGHT), (0.0, 0.0, 0.0), "U6"),
    FrameRow("RFoot/FSR/FrontRight", "RFsrFR_frame", "RAnkleRoll", (0.07025, -0.0299, -LEG_EFFECTOR_HEIGHT), (0.0, 0.0, 0.0), "U6"),
    FrameRow("RFoot/FSR/RearLeft", "RFsrRL_frame", "RAnkleRoll", (-0.03025, 0.0191, -LEG_EFFECTOR_HEIGHT), (0.0, 0.0, 0.0), "U6"),
    FrameRow("RFoot/FSR/RearRight", "RFsrRR_frame", "RAnkleRoll", (-0.02965, -0.0299, -LEG_EFFECTOR_HEIGHT), (0.0, 0.0, 0.0), "U6"),
    FrameRow("RFoot/Sole", None, "RAnkleRoll", (0.0, 0.0, -FOOT_HEIGHT), (0.0, 0.0, 0.0), "L6"),
    FrameRow("RArm", "r_gripper", "RWristYaw", (HAND_OFFSET_X, 0.0, -HAND_OFFSET_Z), (0.0, 0.0, 0.0), "BP6"),
    FrameRow("RHand/Touch/Back", "RHandTouchBack_frame", "RWristYaw", (0.038, 0.0, 0.025), (0.0, -math.pi / 2, 0.0), "U6"),
    FrameRow("RHand/Touch/Left", "RHandTouchLeft_frame", "RWristYaw", (0.032, 0.025, 0.003), (0.0, 0.0, math.pi / 2), "U6"),
    FrameRow("RHand/Touch/Right", "RHandTouchRight_frame", "RWristYaw", (0.035, -0.025, 0.0035), (0.0, 0.0, -math.pi / 2), "U6"),
)
# fmt: on

# x right, y down, z forward, as image processing has it; body frames of cameras look along x.
OPTICAL_RPY = (-math.pi / 2, 0.0, -math.pi / 2)
CAMERAS: tuple[str, ...] = ("CameraTop", "CameraBottom")
# Horizontal and vertical field of view of both cameras [deg]. Sources: NAO6 datasheet of United Robotics Group, for V6;
# Aldebaran documentation 1.14, doc.aldebaran.com/1-14/family/robots/video_robot.html, for the others.
FIELDS_OF_VIEW: Mapping[Version, tuple[float, float]] = {
    "v6": (56.3, 43.7),
    "v5": (60.9, 47.6),
    "v4": (60.9, 47.6),
    "v3.3": (47.8, 36.8),
    "v3.2": (47.8, 36.8),
}
END_EFFECTORS: tuple[str, ...] = ("Head", "LArm", "RArm", "LLeg", "RLeg")
SOLES: tuple[str, ...] = ("LLeg", "RLeg")
ACCELEROMETERS: tuple[str, ...] = ("Accelerometer",)
GYROMETERS: tuple[str, ...] = ("Gyrometer",)
# Under the corners of both feet.
FORCE_SENSORS: tuple[str, ...] = tuple(frame.name for frame in V6_FRAMES if "/FSR/" in frame.name)

# Close views: name, direction from the robot to the camera, and the joints whose links it shows.
VIEWS: tuple[tuple[str, Vector, tuple[str, ...]], ...] = (
    ("hands", (1.0, 0.25, 0.55), ("LWristYaw", "RWristYaw")),
    ("feet", (1.0, 0.45, 0.42), ("LAnklePitch", "RAnklePitch")),
)
