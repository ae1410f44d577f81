"""The versions besides V6, each as its differences from another one, and the tables of all versions."""

from __future__ import annotations

from dataclasses import replace

from nao_kin.robot.nao.rows import (
    FrameRow,
    InertialRow,
    LimitRow,
    OffsetRow,
    Version,
    VersionPage,
    VersionTables,
    VisualRow,
)
from nao_kin.robot.nao.v6 import (
    ELBOW_OFFSET_Y,
    FOOT_HEIGHT,
    HAND_OFFSET_X,
    HAND_OFFSET_Z,
    LOWER_ARM_LENGTH,
    UPPER_ARM_LENGTH,
    V6,
    actuators,
    both_cameras,
    both_sides,
)


def mirrored(row: InertialRow) -> tuple[InertialRow, InertialRow]:
    """Return the row of a link on the left, and that of its mirror image in the xz plane on the right."""
    (x, y, z), (xx, xy, xz, yy, yz, zz) = row.com_m, row.inertia
    right = replace(row, link=f"R{row.link[1:]}", com_m=(x, -y, z), inertia=(xx, -xy, xz, yy, -yz, zz))
    return row, right


# Inertia that the official files up to V5 give to links without a mass (phalanges, hand, force sensors); without it the
# mass matrix is singular. The V6 file gives these links no inertia.
_PLACEHOLDER = InertialRow("", 2e-06, (0.0, 0.0, 0.0), (1.1e-09, 0.0, 0.0, 1.1e-09, 0.0, 1.1e-09), "U5")

# fmt: off
V5 = VersionPage(
    version="v5",
    base="v6",
    inertials=(
        InertialRow("HeadPitch", 0.60533, (-0.00112, 0.0, 0.05258), (0.000957766, 8.78814e-06, 5.33702e-06, 0.000816836, -2.99579e-05, 0.000984976), "U5"),
    ),
    placeholder=_PLACEHOLDER,
    colours={"accent": (0.87, 0.33, 0.11, 1.0)},
    cameras=both_cameras("MT9M114", (60.9, 47.6), "4VGA", "CAM"),
    frames=(
        FrameRow("Gaze", "gaze", "HeadPitch", (0.05871, 0.0, 0.06364), (0.0, 0.0, 0.0), "U5"),
        FrameRow("MicroFrontCenter", "MicroFrontCenter_frame", "HeadPitch", (0.041, 0.0, 0.091), (0.0, 0.0, 0.0), "U4"),
        FrameRow("MicroRearCenter", "MicroRearCenter_frame", "HeadPitch", (-0.0577, 0.0, 0.0693), (0.0, 0.0, 0.0), "U4"),
        FrameRow("MicroSurroundLeft", "MicroSurroundLeft_frame", "HeadPitch", (-0.0195, 0.0606, 0.0331), (0.0, 0.0, 0.0), "U4"),
        FrameRow("MicroSurroundRight", "MicroSurroundRight_frame", "HeadPitch", (-0.0195, -0.0606, 0.0331), (0.0, 0.0, 0.0), "U4"),
        FrameRow("InfraredL", "LInfraRed_frame", "HeadPitch", (0.0441, 0.0257, 0.0466), (0.0, 0.0, 0.0), "U5"),
        FrameRow("InfraredR", "RInfraRed_frame", "HeadPitch", (0.0441, -0.0257, 0.0466), (0.0, 0.0, 0.0), "U5"),
    ),
    without_frames=("MicroFrontLeft", "MicroFrontRight", "MicroRearLeft", "MicroRearRight", "MicrophoneFrame"),
    visuals=(VisualRow("HeadPitch", "sensors_v5", ("dark", "black")),),
    without_visuals=("HeadPitch/sensors",),
)
# fmt: on


# --- V4, compared with V5: neck, shoulders, hips, shins and feet are lighter.

# fmt: off
V4 = VersionPage(
    version="v4",
    base="v5",
    inertials=(
        InertialRow("HeadYaw", 0.06442, (-1e-05, 0.0, -0.02742), (2.65584e-05, 1.57e-09, 0.0, 2.75654e-05, -5.295e-08, 5.53372e-06), "U4"),
        *mirrored(InertialRow("LShoulderPitch", 0.07504, (-0.00165, -0.02663, 0.00014), (3.10677e-05, 1.2692e-06, 6.04576e-09, 1.39498e-05, -2.99484e-07, 3.30001e-05), "U4")),
        InertialRow("LHipRoll", 0.13053, (-0.01549, 0.00029, -0.00515), (2.41106e-05, -6.08684e-07, 6.33119e-06, 6.34892e-05, -1.99137e-07, 5.67694e-05), "U4"),
        InertialRow("LKneePitch", 0.29142, (0.00453, 0.00225, -0.04936), (0.000470586, 3.60392e-06, -2.86648e-05, 0.000412654, 7.13013e-06, 0.000185772), "U4"),
        InertialRow("LAnkleRoll", 0.16184, (0.02542, 0.0033, -0.03239), (9.78911e-05, 7.88039e-06, 6.1279e-06, 0.000369977, 1.44233e-06, 0.000419417), "U4"),
        InertialRow("RHipRoll", 0.13053, (-0.01549, -0.00029, -0.00515), (2.41136e-05, 5.67164e-07, 6.30461e-06, 6.34886e-05, 1.97457e-07, 5.6773e-05), "U4"),
        InertialRow("RKneePitch", 0.29142, (0.00453, -0.00225, -0.04936), (0.000471336, -3.8668e-06, -3.71648e-05, 0.00041228, -6.11093e-06, 0.000183997), "U4"),
        InertialRow("RAnkleRoll", 0.16184, (0.02542, -0.0033, -0.03239), (9.77513e-05, -7.70106e-06, 5.88169e-06, 0.000369108, -1.55058e-06, 0.000418695), "U4"),
    ),
)
# fmt: on


# --- V3.3, compared with V4: other masses and cameras.

# fmt: off
V33 = VersionPage(
    version="v3.3",
    base="v4",
    cameras=both_cameras("OV7670", (47.8, 36.8), "VGA", "CAM"),
    inertials=(
        InertialRow("torso", 1.03948, (-0.00415, 0.0, 0.04258), (0.00308278, 1.2474e-05, -1.92153e-05, 0.00288881, -2.47767e-05, 0.00157995), "U33"),
        InertialRow("HeadYaw", 0.0593, (-2e-05, 0.0, -0.02556), (2.30616e-05, -2.05e-09, -1.91658e-08, 2.40771e-05, -5.067e-08, 5.43975e-06), "U33"),
        InertialRow("HeadPitch", 0.52065, (0.0012, 0.0, 0.05353), (0.000773968, 7.87181e-06, 2.15179e-05, 0.000771553, -2.31846e-06, 0.000872983), "U33"),
        *mirrored(InertialRow("LShoulderPitch", 0.06996, (-0.00178, -0.02496, 0.00018), (2.74375e-05, 1.08357e-06, -5.19518e-09, 1.38341e-05, -3.05906e-07, 2.93591e-05), "U33")),
        *mirrored(InertialRow("LShoulderRoll", 0.12309, (0.01885, 0.00577, 0.00065), (7.81341e-05, -2.63927e-05, -6.01785e-06, 0.000246226, -1.0678e-06, 0.000220589), "U33")),
        *mirrored(InertialRow("LElbowYaw", 0.05971, (-0.0256, -1e-05, -0.00019), (5.50103e-06, -7.14424e-09, 3.05769e-07, 2.31203e-05, 5.70345e-09, 2.41197e-05), "U33")),
        *mirrored(InertialRow("LElbowRoll", 0.07724, (0.02556, 0.00273, 0.00096), (2.4548e-05, 3.22678e-06, 1.17682e-06, 3.837e-05, 9.43406e-08, 3.58311e-05), "U33")),
        *mirrored(InertialRow("LWristYaw", 0.16653, (0.0318, 0.00083, 0.00477), (5.7153e-05, -6.41007e-07, -1.36934e-05, 0.000107283, -2.27145e-06, 0.000111471), "U33")),
        *mirrored(InertialRow("LHipYawPitch", 0.07117, (-0.00766, -0.012, 0.02717), (2.71848e-05, 1.53981e-06, -2.07658e-06, 4.88082e-05, 4.49648e-06, 5.24594e-05), "U33")),
        *mirrored(InertialRow("LHipRoll", 0.1353, (-0.01649, 0.00029, -0.00475), (2.4849e-05, -5.97198e-07, 5.28803e-06, 6.16256e-05, -1.85886e-07, 0.000255291), "U33")),
        *mirrored(InertialRow("LHipPitch", 0.39798, (0.00131, 0.00201, -0.05386), (0.000509482, 1.48043e-06, 5.4425e-05, 0.000469814, -1.13419e-05, 0.000302638), "U33")),
        *mirrored(InertialRow("LKneePitch", 0.29159, (0.00422, 0.00252, -0.04868), (0.000460981, 3.87618e-06, -2.75884e-05, 0.000407591, 8.19688e-06, 0.000181566), "U33")),
        *mirrored(InertialRow("LAnklePitch", 0.13892, (0.00142, 0.00028, 0.00638), (3.31602e-05, 5.81459e-09, 3.47177e-06, 6.6181e-05, 2.54907e-07, 5.32289e-05), "U33")),
        *mirrored(InertialRow("LAnkleRoll", 0.16175, (0.0254, 0.00332, -0.03241), (9.79256e-05, 7.76315e-06, 6.0896e-06, 0.00036962, 1.46647e-06, 0.000419054), "U33")),
    ),
    frames=(
        FrameRow("CameraBottom", "CameraBottom_frame", "HeadPitch", (0.0488, 0.0, 0.02381), (0.0, 0.6981, 0.0), "U33"),
        FrameRow("CameraTop", "CameraTop_frame", "HeadPitch", (0.0539, 0.0, 0.0679), (0.0, 0.0, 0.0), "U33"),
    ),
    visuals=(
        VisualRow("HeadPitch", "ears_v33", ("grey", "dark")),
        VisualRow("HeadPitch", "sensors_v33", ("dark", "black")),
        *both_sides("ElbowRoll", "forearm", "white"),
    ),
    without_visuals=("HeadPitch/ears", "HeadPitch/sensors_v5"),
)
# fmt: on


# --- V3.2, compared with V3.3: shorter arms without an offset in the elbow, other ranges of arm joints, and no touch
# sensors on the hands.

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
        *actuators(5.03144, 0.3891, "U32", "LWristYaw", "RWristYaw"),
        *actuators(3.71, 0.292, "U32", "LHand", "RHand"),
    ),
    inertials=(
        InertialRow("torso", 1.02628, (-0.0048, 0.0, 0.04227), (0.00304582, 1.42859e-05, -1.27716e-05, 0.00284625, -2.22459e-05, 0.00154349), "U32"),
        InertialRow("HeadYaw", 0.05959, (-3e-05, 0.0, -0.02573), (2.27831e-05, 0.0, -2.84825e-08, 2.37937e-05, -1.0416e-07, 5.49457e-06), "U32"),
        InertialRow("HeadPitch", 0.47672, (0.00383, 0.0, 0.05156), (0.0036122, 1.42859e-05, 0.000289597, 0.00342929, -2.22459e-05, 0.00156014), "U32"),
        *mirrored(InertialRow("LShoulderPitch", 0.06984, (-0.00178, -0.02507, 0.00019), (2.71212e-05, 1.092e-06, -6.48989e-09, 1.38254e-05, -3.76769e-07, 2.90286e-05), "U32")),
        InertialRow("LShoulderRoll", 0.12166, (0.02067, 0.00388, 0.00362), (5.58921e-05, 7.81779e-06, 7.53876e-06, 0.000148637, -1.97852e-06, 0.000130405), "U32"),
        *mirrored(InertialRow("LElbowYaw", 0.05959, (-0.02573, -1e-05, -0.0002), (5.49223e-06, -7.08749e-09, 3.7436e-07, 2.2795e-05, 5.70918e-09, 2.37796e-05), "U32")),
        *mirrored(InertialRow("LElbowRoll", 0.0377, (0.0194, 0.00304, 0.0025), (1.2127e-05, 9.08795e-07, 3.9219e-07, 1.61446e-05, 7.966e-08, 1.52257e-05), "U32")),
        *mirrored(InertialRow("LWristYaw", 0.14314, (0.03241, 0.00268, -0.00272), (5.48391e-05, 4.21084e-06, -1.25566e-06, 0.000120895, 7.74367e-07, 0.00011473), "U32")),
        *mirrored(InertialRow("LHipYawPitch", 0.07244, (-0.00717, -0.01187, 0.02705), (2.74339e-05, 1.27703e-06, -1.83038e-06, 4.99292e-05, 4.57891e-06, 5.3498e-05), "U32")),
        *mirrored(InertialRow("LKneePitch", 0.29714, (0.00471, 0.0021, -0.04891), (0.000468213, 3.24443e-06, -2.82799e-05, 0.000411872, 5.21684e-06, 0.000185588), "U32")),
        InertialRow("LAnkleRoll", 0.16304, (0.02489, 0.0033, -0.03208), (9.80337e-05, 7.46444e-06, 7.11645e-06, 0.000374354, 1.43763e-06, 0.000423717), "U32"),
        InertialRow("RAnkleRoll", 0.16304, (0.02489, -0.0033, -0.03208), (9.80337e-05, -7.46444e-06, -0.000116453, 0.000374354, -1.43763e-06, 0.000423717), "U32"),
        InertialRow("RShoulderRoll", 0.12166, (0.02067, -0.00388, 0.00362), (5.58921e-05, -7.81779e-06, -6.54177e-06, 0.000148637, 1.97852e-06, 0.000130405), "U32"),
    ),
    without_frames=(
        "LHand/Touch/Back", "LHand/Touch/Left", "LHand/Touch/Right",
        "RHand/Touch/Back", "RHand/Touch/Left", "RHand/Touch/Right",
    ),
    visuals=(
        *both_sides("ShoulderRoll", "upper_arm_v32", "white"),
        *both_sides("ElbowRoll", "forearm_v32", "white"),
    ),
    without_visuals=(
        "LShoulderRoll/l_upper_arm", "RShoulderRoll/r_upper_arm", "LElbowRoll/l_forearm", "RElbowRoll/r_forearm",
    ),
)
# fmt: on


# --- The versions: the tables of V6 are complete, each other version is a page of changes.

# A page comes after the page of its base.
PAGES: tuple[VersionPage, ...] = (V5, V4, V33, V32)


TABLES: dict[Version, VersionTables] = {"v6": V6}
"""The complete tables of each version: the tables of its base with the changes of its page."""
for _page in PAGES:
    TABLES[_page.version] = _page.over(TABLES[_page.base])
