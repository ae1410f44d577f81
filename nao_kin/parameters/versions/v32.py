"""V3.2 beside V3.3: shorter arms without an offset in the elbow, other ranges in them, and no touch sensors on the hands."""

from __future__ import annotations

from nao_kin.parameters.bodies import both_sides
from nao_kin.parameters.overlay import VersionPage
from nao_kin.parameters.rows import ActuatorRow, InertialRow, LimitRow, OffsetRow
from nao_kin.parameters.skeleton import (
    ELBOW_OFFSET_Y,
    FOOT_HEIGHT,
    HAND_OFFSET_X,
    HAND_OFFSET_Z,
    LOWER_ARM_LENGTH,
    UPPER_ARM_LENGTH,
)

# fmt: off
V32 = VersionPage(
    version="v3.2",
    base="v3.3",
    offsets=(
        OffsetRow(ELBOW_OFFSET_Y, 0.0, "L32"),
        OffsetRow(UPPER_ARM_LENGTH, 90.0, "L32"),
        OffsetRow(LOWER_ARM_LENGTH, 50.55, "L32"),
        OffsetRow(HAND_OFFSET_X, 58.0, "L32"),
        OffsetRow(HAND_OFFSET_Z, 15.9, "L32"),
        OffsetRow(FOOT_HEIGHT, 45.11, "L32"),
    ),
    limits=(
        LimitRow("LShoulderRoll", 0.5, 94.5, "deg", "J32"),
        LimitRow("LElbowRoll", -89.5, -0.5, "deg", "J32"),
        LimitRow("RShoulderRoll", -94.5, -0.5, "deg", "J32"),
        LimitRow("RElbowRoll", 0.5, 89.5, "deg", "J32"),
    ),
    actuators=(
        ActuatorRow("LWristYaw", 5.03144, 0.3891, "U32"),
        ActuatorRow("LHand", 3.71, 0.292, "U32"),
        ActuatorRow("RWristYaw", 5.03144, 0.3891, "U32"),
        ActuatorRow("RHand", 3.71, 0.292, "U32"),
    ),
    inertials=(
        InertialRow("torso", 1.02628, (-0.0048, 0.0, 0.04227), (0.00304582, 1.42859e-05, -1.27716e-05, 0.00284625, -2.22459e-05, 0.00154349), "U32"),
        InertialRow("HeadYaw", 0.05959, (-3e-05, 0.0, -0.02573), (2.27831e-05, 0.0, -2.84825e-08, 2.37937e-05, -1.0416e-07, 5.49457e-06), "U32"),
        InertialRow("HeadPitch", 0.47672, (0.00383, 0.0, 0.05156), (0.0036122, 1.42859e-05, 0.000289597, 0.00342929, -2.22459e-05, 0.00156014), "U32"),
        InertialRow("LShoulderPitch", 0.06984, (-0.00178, -0.02507, 0.00019), (2.71212e-05, 1.092e-06, -6.48989e-09, 1.38254e-05, -3.76769e-07, 2.90286e-05), "U32"),
        InertialRow("LShoulderRoll", 0.12166, (0.02067, 0.00388, 0.00362), (5.58921e-05, 7.81779e-06, 7.53876e-06, 0.000148637, -1.97852e-06, 0.000130405), "U32"),
        InertialRow("LElbowYaw", 0.05959, (-0.02573, -1e-05, -0.0002), (5.49223e-06, -7.08749e-09, 3.7436e-07, 2.2795e-05, 5.70918e-09, 2.37796e-05), "U32"),
        InertialRow("LElbowRoll", 0.0377, (0.0194, 0.00304, 0.0025), (1.2127e-05, 9.08795e-07, 3.9219e-07, 1.61446e-05, 7.966e-08, 1.52257e-05), "U32"),
        InertialRow("LWristYaw", 0.14314, (0.03241, 0.00268, -0.00272), (5.48391e-05, 4.21084e-06, -1.25566e-06, 0.000120895, 7.74367e-07, 0.00011473), "U32"),
        InertialRow("LHipYawPitch", 0.07244, (-0.00717, -0.01187, 0.02705), (2.74339e-05, 1.27703e-06, -1.83038e-06, 4.99292e-05, 4.57891e-06, 5.3498e-05), "U32"),
        InertialRow("LKneePitch", 0.29714, (0.00471, 0.0021, -0.04891), (0.000468213, 3.24443e-06, -2.82799e-05, 0.000411872, 5.21684e-06, 0.000185588), "U32"),
        InertialRow("LAnkleRoll", 0.16304, (0.02489, 0.0033, -0.03208), (9.80337e-05, 7.46444e-06, 7.11645e-06, 0.000374354, 1.43763e-06, 0.000423717), "U32"),
        InertialRow("RHipYawPitch", 0.07244, (-0.00717, 0.01187, 0.02705), (2.74339e-05, -1.27703e-06, -1.83038e-06, 4.99292e-05, -4.57891e-06, 5.3498e-05), "U32"),
        InertialRow("RKneePitch", 0.29714, (0.00471, -0.0021, -0.04891), (0.000468213, -3.24443e-06, -2.82799e-05, 0.000411872, -5.21684e-06, 0.000185588), "U32"),
        InertialRow("RAnkleRoll", 0.16304, (0.02489, -0.0033, -0.03208), (9.80337e-05, -7.46444e-06, -0.000116453, 0.000374354, -1.43763e-06, 0.000423717), "U32"),
        InertialRow("RShoulderPitch", 0.06984, (-0.00178, 0.02507, 0.00019), (2.71212e-05, -1.092e-06, -6.48989e-09, 1.38254e-05, 3.76769e-07, 2.90286e-05), "U32"),
        InertialRow("RShoulderRoll", 0.12166, (0.02067, -0.00388, 0.00362), (5.58921e-05, -7.81779e-06, -6.54177e-06, 0.000148637, 1.97852e-06, 0.000130405), "U32"),
        InertialRow("RElbowYaw", 0.05959, (-0.02573, 1e-05, -0.0002), (5.49223e-06, 7.08749e-09, 3.7436e-07, 2.2795e-05, -5.70918e-09, 2.37796e-05), "U32"),
        InertialRow("RElbowRoll", 0.0377, (0.0194, -0.00304, 0.0025), (1.2127e-05, -9.08795e-07, 3.9219e-07, 1.61446e-05, -7.966e-08, 1.52257e-05), "U32"),
        InertialRow("RWristYaw", 0.14314, (0.03241, -0.00268, -0.00272), (5.48391e-05, -4.21084e-06, -1.25566e-06, 0.000120895, -7.74367e-07, 0.00011473), "U32"),
    ),
    without_frames=(
        "LHand/Touch/Back",
        "LHand/Touch/Left",
        "LHand/Touch/Right",
        "RHand/Touch/Back",
        "RHand/Touch/Left",
        "RHand/Touch/Right",
    ),
    visuals=(
        *both_sides("ShoulderRoll", "upper_arm_v32", "white"),
        *both_sides("ElbowRoll", "forearm_v32", "white"),
    ),
    without_visuals=(
        "LShoulderRoll/l_upper_arm",
        "RShoulderRoll/r_upper_arm",
        "LElbowRoll/l_forearm",
        "RElbowRoll/r_forearm",
    ),
)
# fmt: on
