"""The tables of V6: distances, joints, ranges, bodies, frames and postures, each row with its source.

Distances are those of V6; `versions` contains the differences of other versions.
"""

from __future__ import annotations

import math

from nao_kin._core.arrays import Vector
from nao_kin.robot.nao.rows import (
    ActuatorRow,
    CameraRow,
    Colour,
    CoupledLimitRow,
    FingerRow,
    FrameRow,
    InertialRow,
    JointRow,
    LimitRow,
    Offset,
    OffsetRow,
    OutlineRow,
    PostureRow,
    ResolutionRow,
    ShapeRow,
    VersionTables,
    VisualRow,
)

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
# The foot height of the documentation, and that of NAOqi's own leg effector: they differ by 0.08 mm.
FOOT_HEIGHT = Offset("FootHeight")
LEG_EFFECTOR_HEIGHT = Offset("LegEffectorHeight")

_OFFSETS: tuple[OffsetRow, ...] = (
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
_ORIGIN = (0.0, 0.0, 0.0)
_ELBOW_L, _ELBOW_R = (UPPER_ARM_LENGTH, ELBOW_OFFSET_Y, 0.0), (UPPER_ARM_LENGTH, -ELBOW_OFFSET_Y, 0.0)
_SHOULDER_L, _SHOULDER_R = (0.0, SHOULDER_OFFSET_Y, SHOULDER_OFFSET_Z), (0.0, -SHOULDER_OFFSET_Y, SHOULDER_OFFSET_Z)
_HIP_L, _HIP_R = (0.0, HIP_OFFSET_Y, -HIP_OFFSET_Z), (0.0, -HIP_OFFSET_Y, -HIP_OFFSET_Z)
_WRIST = (LOWER_ARM_LENGTH, 0.0, 0.0)
_HAND = (HAND_OFFSET_X, 0.0, -HAND_OFFSET_Z)
_KNEE = (0.0, 0.0, -THIGH_LENGTH)
_ANKLE = (0.0, 0.0, -TIBIA_LENGTH)

# The joints are in NAOqi's Body order. Roll turns about x, pitch about y, yaw about z, except in the arm, whose names follow
# the arm hanging down: ShoulderRoll and ElbowRoll turn about z, ElbowYaw and WristYaw about x.
JOINTS: tuple[JointRow, ...] = (
    JointRow("HeadYaw", "Head", "torso", "Neck", (0.0, 0.0, NECK_OFFSET_Z), _Z, "twist", "J6"),
    JointRow("HeadPitch", "Head", "HeadYaw", "Head", _ORIGIN, _Y, "front/back", "J6"),
    JointRow("LShoulderPitch", "LArm", "torso", "LShoulder", _SHOULDER_L, _Y, "front/back", "J6"),
    JointRow("LShoulderRoll", "LArm", "LShoulderPitch", "LBicep", _ORIGIN, _Z, "right/left", "J6"),
    JointRow("LElbowYaw", "LArm", "LShoulderRoll", "LElbow", _ELBOW_L, _X, "twist", "J6"),
    JointRow("LElbowRoll", "LArm", "LElbowYaw", "LForeArm", _ORIGIN, _Z, "bend", "J6"),
    JointRow("LWristYaw", "LArm", "LElbowRoll", "l_wrist", _WRIST, _X, "twist", "J6"),
    JointRow("LHand", "LArm", "LWristYaw", "LHand_link", _HAND, _X, "open/close", "J6"),
    JointRow("LHipYawPitch", "LLeg", "torso", "LPelvis", _HIP_L, (0.0, 1.0, -1.0), "twist at 45°", "J6"),
    JointRow("LHipRoll", "LLeg", "LHipYawPitch", "LHip", _ORIGIN, _X, "right/left", "J6"),
    JointRow("LHipPitch", "LLeg", "LHipRoll", "LThigh", _ORIGIN, _Y, "front/back", "J6"),
    JointRow("LKneePitch", "LLeg", "LHipPitch", "LTibia", _KNEE, _Y, "bend", "J6"),
    JointRow("LAnklePitch", "LLeg", "LKneePitch", "LAnklePitch_link", _ANKLE, _Y, "front/back", "J6"),
    JointRow("LAnkleRoll", "LLeg", "LAnklePitch", "l_ankle", _ORIGIN, _X, "right/left", "J6"),
    JointRow("RHipYawPitch", "RLeg", "torso", "RPelvis", _HIP_R, (0.0, 1.0, 1.0), "twist at 45°", "J6", "LHipYawPitch"),
    JointRow("RHipRoll", "RLeg", "RHipYawPitch", "RHip", _ORIGIN, _X, "right/left", "J6"),
    JointRow("RHipPitch", "RLeg", "RHipRoll", "RThigh", _ORIGIN, _Y, "front/back", "J6"),
    JointRow("RKneePitch", "RLeg", "RHipPitch", "RTibia", _KNEE, _Y, "bend", "J6"),
    JointRow("RAnklePitch", "RLeg", "RKneePitch", "RAnklePitch_link", _ANKLE, _Y, "front/back", "J6"),
    JointRow("RAnkleRoll", "RLeg", "RAnklePitch", "r_ankle", _ORIGIN, _X, "right/left", "J6"),
    JointRow("RShoulderPitch", "RArm", "torso", "RShoulder", _SHOULDER_R, _Y, "front/back", "J6"),
    JointRow("RShoulderRoll", "RArm", "RShoulderPitch", "RBicep", _ORIGIN, _Z, "right/left", "J6"),
    JointRow("RElbowYaw", "RArm", "RShoulderRoll", "RElbow", _ELBOW_R, _X, "twist", "J6"),
    JointRow("RElbowRoll", "RArm", "RElbowYaw", "RForeArm", _ORIGIN, _Z, "bend", "J6"),
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


# --- Ranges, speeds and torques of the joints of V6, and the ranges that depend on another joint.

# Degrees, as in the documentation; the official URDF has the same values in radians. A joint that shares the motor of
# another one uses the row of that joint.
_LIMITS: tuple[LimitRow, ...] = (
    LimitRow("HeadYaw", -119.5, 119.5, "deg", "J6"),
    LimitRow("HeadPitch", -38.5, 29.5, "deg", "J6"),
    LimitRow("LShoulderPitch", -119.5, 119.5, "deg", "J6"),
    LimitRow("LShoulderRoll", -18.0, 76.0, "deg", "J6"),
    LimitRow("LElbowYaw", -119.5, 119.5, "deg", "J6"),
    LimitRow("LElbowRoll", -88.5, -2.0, "deg", "J6"),
    LimitRow("LWristYaw", -104.5, 104.5, "deg", "J6"),
    LimitRow("LHand", 0.0, 1.0, "1", "J6"),
    LimitRow("LHipYawPitch", -65.62, 42.44, "deg", "J6"),
    LimitRow("LHipRoll", -21.74, 45.29, "deg", "J6"),
    LimitRow("LHipPitch", -88.0, 27.73, "deg", "J6"),
    LimitRow("LKneePitch", -5.29, 121.04, "deg", "J6"),
    LimitRow("LAnklePitch", -68.15, 52.86, "deg", "J6"),
    LimitRow("LAnkleRoll", -22.79, 44.06, "deg", "J6"),
    LimitRow("RShoulderPitch", -119.5, 119.5, "deg", "J6"),
    LimitRow("RShoulderRoll", -76.0, 18.0, "deg", "J6"),
    LimitRow("RElbowYaw", -119.5, 119.5, "deg", "J6"),
    LimitRow("RElbowRoll", 2.0, 88.5, "deg", "J6"),
    LimitRow("RWristYaw", -104.5, 104.5, "deg", "J6"),
    LimitRow("RHand", 0.0, 1.0, "1", "J6"),
    LimitRow("RHipRoll", -45.29, 21.74, "deg", "J6"),
    LimitRow("RHipPitch", -88.0, 27.73, "deg", "J6"),
    LimitRow("RKneePitch", -5.9, 121.47, "deg", "J6"),
    LimitRow("RAnklePitch", -67.97, 53.4, "deg", "J6"),
    LimitRow("RAnkleRoll", -44.06, 22.8, "deg", "J6"),
)


def actuators(velocity: float, effort: float, source: str, *joints: str) -> tuple[ActuatorRow, ...]:
    """Return the rows of joints with the same motor and gear."""
    return tuple(ActuatorRow(joint, velocity, effort, source) for joint in joints)


# The speeds are the no-load speeds of the V3.x motors; the official URDFs of all later versions repeat them.
_ACTUATORS: tuple[ActuatorRow, ...] = (
    *actuators(8.26797, 1.547, "U6", "HeadYaw", "LElbowYaw", "RElbowYaw"),
    *actuators(7.19407, 1.532, "U6", "HeadPitch", "LElbowRoll", "RElbowRoll"),
    *actuators(8.26797, 1.329, "U6", "LShoulderPitch", "RShoulderPitch"),
    *actuators(7.19407, 1.7835, "U6", "LShoulderRoll"),
    *actuators(7.19407, 1.783, "U6", "RShoulderRoll"),
    *actuators(24.6229, 0.4075, "U6", "LWristYaw", "RWristYaw"),
    *actuators(8.33, 0.292, "U6", "LHand", "RHand"),
    *actuators(4.16174, 3.348, "U6", "LHipYawPitch", "LHipRoll", "LAnkleRoll", "RHipRoll", "RAnkleRoll"),
    *actuators(6.40239, 3.023, "U6", "LHipPitch", "LKneePitch", "LAnklePitch"),
    *actuators(6.40239, 3.0226, "U6", "RHipPitch", "RKneePitch", "RAnklePitch"),
)

# Torques of the joints while their motors are stalled [N m]: those of the V3.3 motors, as the speeds are, times the
# reductions, the same for every version. V4 and later versions have 14 % more in the legs (68 mN m), and gears lose some.
# The efforts in the URDFs are a third of them in the legs: what the motors can give for long.
STALL_TORQUES: dict[str, float] = {
    joint: 1e-3 * torque * reduction  # source "M33"
    for torque, reduction, joints in (
        (15.1, 150.27, "HeadYaw LShoulderPitch RShoulderPitch LElbowYaw RElbowYaw"),
        (15.1, 173.22, "HeadPitch LShoulderRoll RShoulderRoll LElbowRoll RElbowRoll"),
        (15.1, 50.61, "LWristYaw RWristYaw"),
        (15.1, 36.24, "LHand RHand"),
        (59.5, 201.3, "LHipYawPitch LHipRoll RHipRoll LAnkleRoll RAnkleRoll"),
        (59.5, 130.85, "LHipPitch RHipPitch LKneePitch RKneePitch LAnklePitch RAnklePitch"),
    )
    for joint in joints.split()
}

# One table for all versions.
# fmt: off
# The right ankle has the mirror image.
_LEFT_ANKLE = (
    (-68.15, -2.86, 4.3),
    (-48.13, -10.31, 9.74),
    (-40.11, -22.8, 12.61),
    (-25.78, -22.8, 44.06),
    (5.73, -22.8, 44.06),
    (20.05, -22.8, 31.54),
    (52.87, 0.0, 2.86),
)
COUPLED_LIMITS: tuple[CoupledLimitRow, ...] = (
    CoupledLimitRow("HeadPitch", "HeadYaw", (
        (-119.52, -25.73, 18.91),
        (-87.49, -18.91, 11.46),
        (-62.45, -24.64, 17.19),
        (-51.74, -27.5, 18.91),
        (-43.32, -31.4, 21.2),
        (-27.85, -38.5, 24.18),
        (0.0, -38.5, 29.51),
        (27.85, -38.5, 24.18),
        (43.32, -31.4, 21.2),
        (51.74, -27.5, 18.91),
        (62.45, -24.64, 17.19),
        (87.49, -18.91, 11.46),
        (119.52, -25.73, 18.91),
    ), "J6"),
    CoupledLimitRow("LAnkleRoll", "LAnklePitch", _LEFT_ANKLE, "J6"),
    CoupledLimitRow("RAnkleRoll", "RAnklePitch", tuple((at, 0.0 - high, 0.0 - low) for at, low, high in _LEFT_ANKLE), "J6"),
)
# fmt: on


# --- The links of V6: inertia, NAOqi's collision primitives, and meshes.
#
# Masses, centres of mass and inertia tensors are as published: left and right are not exact mirrors of each other.

# fmt: off
_INERTIALS: tuple[InertialRow, ...] = (
    InertialRow("torso", 1.04956, (-0.00413, 0.0, 0.04342), (0.00308361, 1.43116e-05, -3.30211e-05, 0.0028835, -2.70793e-05, 0.0015924), "U6"),
    InertialRow("HeadYaw", 0.07842, (-1e-05, 0.0, -0.02742), (1.60324e-05, 1.57e-09, 3.16276e-09, 1.70394e-05, -5.295e-08, 5.53372e-06), "U6"),
    InertialRow("HeadPitch", 0.65973, (0.00108886, 0.00146278, 0.0571855), (0.00077097, 4.76784e-06, 9.62477e-06, 0.000680374, -1.85791e-05, 0.000714702), "U6"),
    InertialRow("LShoulderPitch", 0.09304, (-0.00165, -0.02663, 0.00014), (1.83025e-05, 2.06011e-06, 1.88776e-09, 1.39005e-05, -3.66592e-07, 2.01862e-05), "U6"),
    InertialRow("LShoulderRoll", 0.15777, (0.02455, 0.00563, 0.0033), (8.7181e-05, -2.53381e-05, -1.4213e-05, 0.000274712, 4.71439e-07, 0.000241812), "U6"),
    InertialRow("LElbowYaw", 0.06483, (-0.02744, 0.0, -0.00014), (5.59588e-06, 4.21e-09, 2.92241e-07, 2.66179e-05, -1.84e-09, 2.76294e-05), "U6"),
    InertialRow("LElbowRoll", 0.07761, (0.02556, 0.00281, 0.00076), (2.46746e-05, 3.23152e-06, 1.58221e-06, 3.83837e-05, 1.39194e-07, 3.59708e-05), "U6"),
    InertialRow("LWristYaw", 0.18533, (0.03434, -0.00088, 0.00308), (6.86477e-05, 1.15465e-07, -2.87254e-06, 0.000135756, 2.67539e-06, 0.000133228), "U6"),
    InertialRow("LHipYawPitch", 0.06981, (-0.00781, -0.01114, 0.02661), (2.3407e-05, 1.07922e-06, -1.76003e-06, 4.76355e-05, 2.76058e-06, 4.97021e-05), "U6"),
    InertialRow("LHipRoll", 0.14053, (-0.01549, 0.00029, -0.00515), (2.38445e-05, -6.53605e-07, 7.12893e-06, 6.08246e-05, -2.14072e-07, 5.43691e-05), "U6"),
    InertialRow("LHipPitch", 0.38968, (0.00138, 0.00221, -0.05373), (0.000509844, 2.11296e-06, 5.64129e-05, 0.000465358, -7.91029e-06, 0.000301098), "U6"),
    InertialRow("LKneePitch", 0.30142, (0.00453, 0.00225, -0.04936), (0.000446171, 3.70584e-06, -3.09008e-05, 0.000388084, 6.01953e-06, 0.000185516), "U6"),
    InertialRow("LAnklePitch", 0.13416, (0.00045, 0.00029, 0.00685), (3.22034e-05, -8.83212e-09, 4.27549e-06, 6.7943e-05, 2.84849e-07, 5.48269e-05), "U6"),
    InertialRow("LAnkleRoll", 0.17184, (0.02542, 0.0033, -0.03239), (8.72911e-05, 8.71925e-06, -2.10563e-06, 0.000353024, 3.73459e-07, 0.000412846), "U6"),
    InertialRow("RHipYawPitch", 0.06981, (-0.00781, 0.01114, 0.02661), (3.18766e-05, -1.07152e-06, -1.77295e-06, 5.18361e-05, -7.00664e-06, 5.39657e-05), "U6"),
    InertialRow("RHipRoll", 0.14053, (-0.01549, -0.00029, -0.00515), (2.38475e-05, 6.12085e-07, 7.10235e-06, 6.0824e-05, 2.12392e-07, 5.43727e-05), "U6"),
    InertialRow("RHipPitch", 0.38968, (0.00138, -0.00221, -0.05373), (0.000510607, -2.02799e-06, 5.69893e-05, 0.0004665, 7.09563e-06, 0.000301333), "U6"),
    InertialRow("RKneePitch", 0.30142, (0.00453, -0.00225, -0.04936), (0.000446921, -3.96872e-06, -3.94009e-05, 0.000387711, -5.00034e-06, 0.000183741), "U6"),
    InertialRow("RAnklePitch", 0.13416, (0.00045, -0.00029, 0.00685), (3.22017e-05, 4.68321e-08, 4.28821e-06, 6.79885e-05, -2.71089e-07, 5.48747e-05), "U6"),
    InertialRow("RAnkleRoll", 0.17184, (0.02542, -0.0033, -0.03239), (8.71513e-05, -8.53992e-06, -2.35184e-06, 0.000352156, -4.81708e-07, 0.000412125), "U6"),
    InertialRow("RShoulderPitch", 0.09304, (-0.00165, 0.02663, 0.00014), (1.83025e-05, -2.06011e-06, 1.88776e-09, 1.39005e-05, 3.66592e-07, 2.01862e-05), "U6"),
    InertialRow("RShoulderRoll", 0.15777, (0.02455, -0.00563, 0.0033), (0.000103401, 5.48849e-05, -1.32643e-05, 0.00027077, 9.16707e-06, 0.000254529), "U6"),
    InertialRow("RElbowYaw", 0.06483, (-0.02744, 0.0, -0.00014), (5.59588e-06, 4.21e-09, 2.92241e-07, 2.66179e-05, -1.84e-09, 2.76294e-05), "U6"),
    InertialRow("RElbowRoll", 0.07761, (0.02556, -0.00281, 0.00076), (2.47331e-05, -3.2418e-06, 9.06451e-07, 3.84719e-05, -1.38804e-07, 3.59319e-05), "U6"),
    InertialRow("RWristYaw", 0.18533, (0.03434, 0.00088, 0.00308), (6.86477e-05, 1.13165e-05, -2.87254e-06, 0.000135756, 3.68003e-06, 0.000133228), "U6"),
)
# fmt: on

_UP: Vector = (0.0, 0.0, 1.0)

# From the official V6 URDF, and the same for every version. Cylinders represent NAOqi's capsules. In that URDF the boxes
# of the feet are turned by a right angle; these rows are along the axes of the foot: length, width, height. The URDFs of
# this package have the shapes of `collision_rows` instead, which contain the meshes.
# fmt: off
COLLISION_SHAPES: tuple[ShapeRow, ...] = (
    ShapeRow("TorsoDownBackCollision", "torso", "sphere", (0.04,), (-0.03, 0.0, -0.06), _UP, "U6"),
    ShapeRow("TorsoDownCollision", "torso", "sphere", (0.0453,), (0.0006, 0.0, -0.015), _UP, "U6"),
    ShapeRow("TorsoUpBackCollision", "torso", "sphere", (0.06,), (-0.01, 0.0, 0.0), _UP, "U6"),
    ShapeRow("TorsoUpCollision", "torso", "sphere", (0.0642,), (0.0019, 0.0, 0.056), _UP, "U6"),
    ShapeRow("HeadPitchBothCollision", "HeadPitch", "cylinder", (0.053, 0.141), (0.0, 0.0, 0.053), (0.0, -1.0, 0.0), "U6"),
    ShapeRow("LElbowRollBothCollision", "LElbowRoll", "cylinder", (0.036, 0.1743), (0.06485, 0.0, 0.0), (1.0, 0.0, 0.0), "U6"),
    ShapeRow("LElbowRollSphereCollision", "LElbowRoll", "sphere", (0.04,), (0.116, 0.0, 0.0), _UP, "U6"),
    ShapeRow("LHipYawPitchCollision", "LHipYawPitch", "sphere", (0.035,), (-0.0225, -0.0025001, 0.0079999), _UP, "U6"),
    ShapeRow("LHipPitchBothCollision", "LHipPitch", "cylinder", (0.045, 0.132718), (0.0022251, 0.0019999, -0.04), (0.33826, -0.093641, -0.93638), "U6"),
    ShapeRow("LHipPitchMidCollision", "LHipPitch", "sphere", (0.05,), (0.0, 0.0059998, -0.0435), _UP, "U6"),
    ShapeRow("LKneePitchBothCollision", "LKneePitch", "cylinder", (0.047, 0.1404), (-0.0039998, 0.0039998, -0.0575), (-0.1724, 0.17241, -0.96982), "U6"),
    ShapeRow("LAnklePitchSphereCollision", "LAnklePitch", "sphere", (0.05,), (0.01, -0.005, 0.01), _UP, "U6"),
    ShapeRow("LAnkleRollBothCollision", "LAnkleRoll", "box", (0.16, 0.09, 0.035), (0.0225, 0.0075003, -0.027), _UP, "U6"),
    ShapeRow("RHipYawPitchCollision", "RHipYawPitch", "sphere", (0.035,), (-0.0225, 0.0025001, 0.0079999), _UP, "U6"),
    ShapeRow("RHipPitchBothCollision", "RHipPitch", "cylinder", (0.045, 0.132718), (0.0022251, -0.0020001, -0.04), (0.33827, 0.093635, -0.93638), "U6"),
    ShapeRow("RHipPitchMidCollision", "RHipPitch", "sphere", (0.05,), (0.0, -0.0060002, -0.0435), _UP, "U6"),
    ShapeRow("RKneePitchBothCollision", "RKneePitch", "cylinder", (0.047, 0.1404), (-0.0039998, -0.0040002, -0.0575), (-0.17241, -0.17242, -0.96982), "U6"),
    ShapeRow("RAnklePitchSphereCollision", "RAnklePitch", "sphere", (0.05,), (0.01, 0.005, 0.01), _UP, "U6"),
    ShapeRow("RAnkleRollBothCollision", "RAnkleRoll", "box", (0.16, 0.09, 0.035), (0.0225, -0.0074997, -0.027), _UP, "U6"),
    ShapeRow("RElbowRollBothCollision", "RElbowRoll", "cylinder", (0.036, 0.1743), (0.06485, 0.0, 0.0), (1.0, 0.0, 0.0), "U6"),
    ShapeRow("RElbowRollSphereCollision", "RElbowRoll", "sphere", (0.04,), (0.116, 0.0, 0.0), _UP, "U6"),
)
# fmt: on

# No outline of a sole is published. These corners are on the edge of the flat underside of our foot mesh, and are used for every
# version: 142 × 81 mm, inside the box of 160 × 90 mm around the foot.
# fmt: off
SOLE_OUTLINES: tuple[OutlineRow, ...] = (
    OutlineRow("LLeg", ((-0.0495, -0.005), (-0.0402, -0.0247), (-0.0215, -0.0334), (0.014, -0.0351), (0.0684, -0.0285), (0.0925, -0.0153), (0.0925, 0.0199), (0.0684, 0.0372), (0.0422, 0.0436), (-0.0071, 0.0458), (-0.0348, 0.0372), (-0.0471, 0.0199)), "GEN"),
    OutlineRow("RLeg", ((-0.0471, -0.0199), (-0.0348, -0.0372), (-0.0071, -0.0458), (0.0422, -0.0436), (0.0684, -0.0372), (0.0925, -0.0199), (0.0925, 0.0153), (0.0684, 0.0285), (0.014, 0.0351), (-0.0215, 0.0334), (-0.0402, 0.0247), (-0.0495, 0.005)), "GEN"),
)
# fmt: on

_COLOURS: dict[str, Colour] = {
    "white": (0.93, 0.93, 0.94, 1.0),
    "grey": (0.66, 0.68, 0.71, 1.0),
    "dark": (0.23, 0.24, 0.27, 1.0),
    "black": (0.05, 0.05, 0.06, 1.0),
    "accent": (0.34, 0.36, 0.39, 1.0),
    "led": (0.70, 0.89, 1.0, 1.0),
}


def both_sides(parent: str, part: str, *colours: str) -> tuple[VisualRow, VisualRow]:
    """Return the rows of a part on the left and of its mirror image on the right."""
    return VisualRow(f"L{parent}", f"l_{part}", colours), VisualRow(f"R{parent}", f"r_{part}", colours)


_VISUALS: tuple[VisualRow, ...] = (
    VisualRow("torso", "torso", ("white", "accent", "dark", "grey", "led")),
    VisualRow("HeadYaw", "neck", ("dark",)),
    VisualRow("HeadPitch", "head", ("white", "grey", "dark", "black", "led")),
    VisualRow("HeadPitch", "ears", ("accent", "grey", "dark")),
    VisualRow("HeadPitch", "sensors", ("dark", "black")),
    *both_sides("ShoulderPitch", "shoulder", "dark"),
    *both_sides("ShoulderRoll", "shoulder_pad", "accent"),
    *both_sides("ShoulderRoll", "upper_arm", "white"),
    *both_sides("ElbowYaw", "elbow", "dark"),
    *both_sides("ElbowRoll", "hinge", "grey"),
    *both_sides("ElbowRoll", "forearm", "white", "accent"),
    *both_sides("WristYaw", "hand", "white", "dark"),
    *both_sides("HipYawPitch", "pelvis", "white"),
    *both_sides("HipRoll", "hip", "white", "grey"),
    *both_sides("HipPitch", "thigh", "white", "accent", "grey"),
    *both_sides("KneePitch", "shin", "white", "accent", "grey"),
    *both_sides("AnklePitch", "ankle", "grey"),
    *both_sides("AnkleRoll", "foot", "white", "accent", "dark", "led"),
    *(VisualRow(f"Finger{n}", "phalanx", ("dark",)) for n in (11, 12, 21, 22)),
    *(VisualRow(f"Finger{n}", "fingertip", ("dark",)) for n in (13, 23)),
    VisualRow("Thumb1", "phalanx", ("dark",)),
    VisualRow("Thumb2", "fingertip", ("dark",)),
)


# --- Sensor and effector frames of V6, and their uses.
#
# Where a source has π or π/2 with five to seven digits (3.14159, 1.5708), the rows have the exact value.

# fmt: off
_FRAMES: tuple[FrameRow, ...] = (
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

CAMERAS: tuple[str, ...] = ("CameraTop", "CameraBottom")
# x right, y down, z forward, as in image processing; the camera frames themselves look along x.
OPTICAL_RPY = (-math.pi / 2, 0.0, -math.pi / 2)

RESOLUTIONS: tuple[ResolutionRow, ...] = (
    ResolutionRow("QQQQVGA", 40, 30, "VIS"),
    ResolutionRow("QQQVGA", 80, 60, "VIS"),
    ResolutionRow("QQVGA", 160, 120, "VIS"),
    ResolutionRow("QVGA", 320, 240, "VIS"),
    ResolutionRow("VGA", 640, 480, "VIS"),
    ResolutionRow("4VGA", 1280, 960, "VIS"),
    ResolutionRow("16VGA", 2560, 1920, "VIS"),
)


def both_cameras(
    sensor: str, field_of_view_deg: tuple[float, float], largest: str, source: str
) -> tuple[CameraRow, ...]:
    """Return the rows of two cameras that differ in their pose only."""
    return tuple(CameraRow(name, sensor, field_of_view_deg, largest, source) for name in CAMERAS)


V6 = VersionTables(
    offsets=_OFFSETS,
    limits=_LIMITS,
    actuators=_ACTUATORS,
    inertials=_INERTIALS,
    frames=_FRAMES,
    cameras=both_cameras("OV5640", (56.3, 43.7), "16VGA", "DS6"),
    visuals=_VISUALS,
    colours=_COLOURS,
)


# --- NAOqi's predefined postures, and the vertical in those in which the robot does not stand.

# NAOqi's values in single precision; residues below 1e-9 (1.4e-45, 1.1e-13 …) are written as zero.
# fmt: off
POSTURES: tuple[PostureRow, ...] = (
    PostureRow("Stand", (0.0, -0.170000032, 1.4425844, 0.224456817, -1.20227683, -0.417271525, 0.0999999791, 0.300000012, -0.170009688, 0.119108438, 0.12741895, -0.0923279151, 0.0874193981, -0.110793173, -0.170009688, -0.119102433, 0.127419189, -0.0923279151, 0.0874193311, 0.110789023, 1.44258487, -0.224456757, 1.20227683, 0.417271346, 0.099999994, 0.300000012), "QB"),
    PostureRow("StandInit", (0.0, 0.0, 1.4000001, 0.299999982, -1.38999987, -1.00999987, 0.0, 0.25, 0.0, 0.0, -0.449999988, 0.699999988, -0.349999994, 0.0, 0.0, 0.0, -0.449999988, 0.699999988, -0.349999994, 0.0, 1.4000001, -0.300000042, 1.38999987, 1.00999987, 0.0, 0.25), "QB"),
    PostureRow("StandZero", (0.0, 0.0, 0.0, 0.00872664712, 0.0, -0.0349065885, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.00872664712, 0.0, 0.0349065885, 0.0, 0.0), "QB"),
    PostureRow("Crouch", (0.0, 0.100000001, 1.39685857, 0.159609884, -0.791683376, -1.07368624, 0.149999991, 0.0, -0.25, -0.0799999982, -0.699999988, 2.1099999, -1.17999995, 0.0769999996, -0.25, 0.0799999982, -0.699999988, 2.1099999, -1.17999995, -0.0769999996, 1.39685857, -0.159609884, 0.791683376, 1.07368624, -0.149999991, 0.0), "QB"),
    PostureRow("Sit", (-0.0460619926, -0.0399260521, 0.881872058, 0.259543777, -0.452065587, -1.19049561, -0.0169160366, 0.289200008, -0.607422113, 0.273093939, -1.53242409, 1.38976204, 0.839056015, -0.0122299194, -0.607422113, -0.259204149, -1.53588974, 1.40211821, 0.848344088, 0.0230519772, 0.938332558, -0.318750441, 0.527359486, 1.23205638, 0.00609397888, 0.291599989), "QB"),
    PostureRow("SitRelax", (-0.0245859623, 0.0183660984, 2.08566761, 0.0887396112, -2.08165431, -0.199512929, -0.949999928, 0.138399959, -0.521517992, 0.131965876, -1.11517596, -0.0414600372, 0.921999991, 0.0, -0.521517992, -0.220854044, -1.06003618, -0.0919981003, 0.921999991, 0.0, 2.08566689, -0.154630423, 2.07549071, 0.0431277193, 0.950000048, 0.139600039), "QB"),
    PostureRow("LyingBelly", (-0.688000023, -0.307282031, -1.16546321, 0.133779854, -0.166860506, -1.08266199, -1.59386766, 0.0124000311, -0.0214340687, 0.0798099041, 0.299171925, -0.0923279151, 0.742413998, -0.0122299194, -0.0214340687, -0.165630102, 0.124212027, -0.0904641151, 0.921999991, 0.0, -0.672019422, -0.422265947, 0.706398547, 1.50837064, 1.6259979, 0.171599984), "QB"),
    PostureRow("LyingBack", (-0.00310993195, 0.153357983, 1.6777612, 0.214862406, -0.880382538, -1.53163767, 0.246932015, 0.303200006, -0.510780096, 0.112024069, 0.375871897, -0.0923279151, 0.863600016, -0.0383081436, -0.510780096, -0.082793951, -0.400415897, 1.73806381, 0.645855904, -0.282214165, 1.69333243, -0.243266225, 0.879038453, 1.54461634, 0.179435983, 0.360799968), "QB"),
)
# fmt: on

# NAOqi's postures do not contain the pose of the trunk. A robot that does not stand rests where its centre of mass is
# lowest. These vectors are the vertical in that pose, in the torso's frame, found by turning the shapes of V6 until no
# small rotation lowers the centre of mass.
REST: dict[str, Vector] = {
    "Sit": (0.310, -0.001, 0.951),
    "SitRelax": (0.155, -0.005, 0.988),
    "LyingBelly": (-0.985, -0.117, 0.130),
    "LyingBack": (1.000, -0.019, 0.001),
}
