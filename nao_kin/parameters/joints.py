"""The joints, their axes, and the fingers they drive."""

from __future__ import annotations

import math

from nao_kin.parameters.rows import FingerRow, JointRow

_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_HERE = (0.0, 0.0, 0.0)
_ELBOW_L, _ELBOW_R = ("UpperArmLength", "ElbowOffsetY", 0.0), ("UpperArmLength", "-ElbowOffsetY", 0.0)
_SHOULDER_L, _SHOULDER_R = (0.0, "ShoulderOffsetY", "ShoulderOffsetZ"), (0.0, "-ShoulderOffsetY", "ShoulderOffsetZ")
_HIP_L, _HIP_R = (0.0, "HipOffsetY", "-HipOffsetZ"), (0.0, "-HipOffsetY", "-HipOffsetZ")
_WRIST = ("LowerArmLength", 0.0, 0.0)
_HAND = ("HandOffsetX", 0.0, "-HandOffsetZ")
_KNEE = (0.0, 0.0, "-ThighLength")
_ANKLE = (0.0, 0.0, "-TibiaLength")

# In NAOqi's Body order. Roll turns about x, pitch about y, yaw about z, except in the arm, whose names follow
# the arm hanging down: ShoulderRoll and ElbowRoll turn about z, ElbowYaw and WristYaw about x.
JOINTS: tuple[JointRow, ...] = (
    JointRow("HeadYaw", "Head", "torso", "Neck", (0.0, 0.0, "NeckOffsetZ"), _Z, "twist", "J6"),
    JointRow("HeadPitch", "Head", "HeadYaw", "Head", _HERE, _Y, "front/back", "J6"),
    JointRow("LShoulderPitch", "LArm", "torso", "LShoulder", _SHOULDER_L, _Y, "front/back", "J6"),
    JointRow("LShoulderRoll", "LArm", "LShoulderPitch", "LBicep", _HERE, _Z, "right/left", "J6"),
    JointRow("LElbowYaw", "LArm", "LShoulderRoll", "LElbow", _ELBOW_L, _X, "twist", "J6"),
    JointRow("LElbowRoll", "LArm", "LElbowYaw", "LForeArm", _HERE, _Z, "bend", "J6"),
    JointRow("LWristYaw", "LArm", "LElbowRoll", "l_wrist", _WRIST, _X, "twist", "J6"),
    JointRow("LHand", "LArm", "LWristYaw", "LHand_link", _HAND, _X, "open/close", "J6"),
    JointRow("LHipYawPitch", "LLeg", "torso", "LPelvis", _HIP_L, (0.0, 1.0, -1.0), "twist at 45°", "J6"),
    JointRow("LHipRoll", "LLeg", "LHipYawPitch", "LHip", _HERE, _X, "right/left", "J6"),
    JointRow("LHipPitch", "LLeg", "LHipRoll", "LThigh", _HERE, _Y, "front/back", "J6"),
    JointRow("LKneePitch", "LLeg", "LHipPitch", "LTibia", _KNEE, _Y, "bend", "J6"),
    JointRow("LAnklePitch", "LLeg", "LKneePitch", "LAnklePitch_link", _ANKLE, _Y, "front/back", "J6"),
    JointRow("LAnkleRoll", "LLeg", "LAnklePitch", "l_ankle", _HERE, _X, "right/left", "J6"),
    JointRow("RHipYawPitch", "RLeg", "torso", "RPelvis", _HIP_R, (0.0, 1.0, 1.0), "twist at 45°", "J6", "LHipYawPitch"),
    JointRow("RHipRoll", "RLeg", "RHipYawPitch", "RHip", _HERE, _X, "right/left", "J6"),
    JointRow("RHipPitch", "RLeg", "RHipRoll", "RThigh", _HERE, _Y, "front/back", "J6"),
    JointRow("RKneePitch", "RLeg", "RHipPitch", "RTibia", _KNEE, _Y, "bend", "J6"),
    JointRow("RAnklePitch", "RLeg", "RKneePitch", "RAnklePitch_link", _ANKLE, _Y, "front/back", "J6"),
    JointRow("RAnkleRoll", "RLeg", "RAnklePitch", "r_ankle", _HERE, _X, "right/left", "J6"),
    JointRow("RShoulderPitch", "RArm", "torso", "RShoulder", _SHOULDER_R, _Y, "front/back", "J6"),
    JointRow("RShoulderRoll", "RArm", "RShoulderPitch", "RBicep", _HERE, _Z, "right/left", "J6"),
    JointRow("RElbowYaw", "RArm", "RShoulderRoll", "RElbow", _ELBOW_R, _X, "twist", "J6"),
    JointRow("RElbowRoll", "RArm", "RElbowYaw", "RForeArm", _HERE, _Z, "bend", "J6"),
    JointRow("RWristYaw", "RArm", "RElbowRoll", "r_wrist", _WRIST, _X, "twist", "J6"),
    JointRow("RHand", "RArm", "RWristYaw", "RHand_link", _HAND, _X, "open/close", "J6"),
)

# Every phalanx turns about its z axis by FINGER_RATIO [rad] times the opening; at opening 1 the fingers are straight.
FINGER_RATIO = 0.999899
_FOLDED = (0.0, 0.0, -FINGER_RATIO)
_PHALANX = (0.01436, 0.0, 0.0)

# The same numbers on both hands: they are not mirrored.
FINGERS: tuple[FingerRow, ...] = (
    FingerRow("Finger11", "WristYaw", (0.06907, 0.01157, -0.00304), (1.8862, 0.976662, 0.264067), "U5"),
    FingerRow("Finger12", "Finger11", _PHALANX, _FOLDED, "U5"),
    FingerRow("Finger13", "Finger12", _PHALANX, _FOLDED, "U5"),
    FingerRow("Finger21", "WristYaw", (0.06907, -0.01157, -0.00304), (1.25539, 0.976662, -0.264067), "U5"),
    FingerRow("Finger22", "Finger21", _PHALANX, _FOLDED, "U5"),
    FingerRow("Finger23", "Finger22", _PHALANX, _FOLDED, "U5"),
    FingerRow("Thumb1", "WristYaw", (0.04895, 0.0, -0.02638), (-math.pi / 2, 0.0472984, 0.0), "U5"),
    FingerRow("Thumb2", "Thumb1", _PHALANX, _FOLDED, "U5"),
)
