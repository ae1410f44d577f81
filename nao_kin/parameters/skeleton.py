"""What holds the robot together: the distances between the joints, the joints, and the fingers that the hands drive.

Distances are those of V6; `nao_kin.parameters.versions` says where another version differs.
"""

from __future__ import annotations

import math

from nao_kin.parameters.rows import FingerRow, JointRow, Offset, OffsetRow

NECK_OFFSET_Z = Offset("NeckOffsetZ")
SHOULDER_OFFSET_Y = Offset("ShoulderOffsetY")
SHOULDER_OFFSET_Z = Offset("ShoulderOffsetZ")
ELBOW_OFFSET_Y = Offset("ElbowOffsetY")
UPPER_ARM_LENGTH = Offset("UpperArmLength")
LOWER_ARM_LENGTH = Offset("LowerArmLength")
HAND_OFFSET_X = Offset("HandOffsetX")
HAND_OFFSET_Z = Offset("HandOffsetZ")
HIP_OFFSET_Y = Offset("HipOffsetY")
HIP_OFFSET_Z = Offset("HipOffsetZ")
THIGH_LENGTH = Offset("ThighLength")
TIBIA_LENGTH = Offset("TibiaLength")
# The documentation's foot height, and the one that NAOqi's own leg effector has: they differ by 0.08 mm.
FOOT_HEIGHT = Offset("FootHeight")
LEG_EFFECTOR_HEIGHT = Offset("LegEffectorHeight")

V6_OFFSETS: tuple[OffsetRow, ...] = (
    OffsetRow(NECK_OFFSET_Z, 126.5, "L6"),
    OffsetRow(SHOULDER_OFFSET_Y, 98.0, "L6"),
    OffsetRow(SHOULDER_OFFSET_Z, 100.0, "L6"),
    OffsetRow(ELBOW_OFFSET_Y, 15.0, "L6"),
    OffsetRow(UPPER_ARM_LENGTH, 105.0, "L6"),
    OffsetRow(LOWER_ARM_LENGTH, 55.95, "L6"),
    OffsetRow(HAND_OFFSET_X, 57.75, "L6"),
    OffsetRow(HAND_OFFSET_Z, 12.31, "L6"),
    OffsetRow(HIP_OFFSET_Y, 50.0, "L6"),
    OffsetRow(HIP_OFFSET_Z, 85.0, "L6"),
    OffsetRow(THIGH_LENGTH, 100.0, "L6"),
    OffsetRow(TIBIA_LENGTH, 102.9, "L6"),
    OffsetRow(FOOT_HEIGHT, 45.19, "L6"),
    OffsetRow(LEG_EFFECTOR_HEIGHT, 45.11, "MIM"),
)

_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_HERE = (0.0, 0.0, 0.0)
_ELBOW_L, _ELBOW_R = (UPPER_ARM_LENGTH, ELBOW_OFFSET_Y, 0.0), (UPPER_ARM_LENGTH, -ELBOW_OFFSET_Y, 0.0)
_SHOULDER_L, _SHOULDER_R = (0.0, SHOULDER_OFFSET_Y, SHOULDER_OFFSET_Z), (0.0, -SHOULDER_OFFSET_Y, SHOULDER_OFFSET_Z)
_HIP_L, _HIP_R = (0.0, HIP_OFFSET_Y, -HIP_OFFSET_Z), (0.0, -HIP_OFFSET_Y, -HIP_OFFSET_Z)
_WRIST = (LOWER_ARM_LENGTH, 0.0, 0.0)
_HAND = (HAND_OFFSET_X, 0.0, -HAND_OFFSET_Z)
_KNEE = (0.0, 0.0, -THIGH_LENGTH)
_ANKLE = (0.0, 0.0, -TIBIA_LENGTH)

# In NAOqi's Body order. Roll turns about x, pitch about y, yaw about z, except in the arm, whose names follow
# the arm hanging down: ShoulderRoll and ElbowRoll turn about z, ElbowYaw and WristYaw about x.
JOINTS: tuple[JointRow, ...] = (
    JointRow("HeadYaw", "Head", "torso", "Neck", (0.0, 0.0, NECK_OFFSET_Z), _Z, "twist", "J6"),
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

BODY_ORDER: tuple[str, ...] = tuple(row.name for row in JOINTS)

CHAINS: dict[str, tuple[str, ...]] = {
    chain: tuple(row.name for row in JOINTS if row.chain == chain) for chain in ("Head", "LArm", "LLeg", "RLeg", "RArm")
}

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
