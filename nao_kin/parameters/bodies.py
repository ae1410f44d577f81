"""What the links of V6 are: their inertia, NAOqi's collision primitives, and their meshes.

Masses, centres of mass and inertia tensors are as published: left and right are not exact mirrors of each other.
"""

from __future__ import annotations

from nao_kin._common.arrays import Vector
from nao_kin._common.choices import choice
from nao_kin.parameters.rows import (
    VERSIONS,
    InertialRow,
    ShapeRow,
    Version,
    VisualRow,
)

# fmt: off
V6_INERTIALS: tuple[InertialRow, ...] = (
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

# As printed in the official V6 URDF and used for every version. Cylinders stand for NAOqi's capsules. The boxes of the
# feet are printed turned by a right angle; here they stand along the axes of the foot: length, width, height.
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

# Red, green, blue, opacity.
COLOURS: dict[str, tuple[float, float, float, float]] = {
    "white": (0.93, 0.93, 0.94, 1.0),
    "grey": (0.66, 0.68, 0.71, 1.0),
    "dark": (0.23, 0.24, 0.27, 1.0),
    "black": (0.05, 0.05, 0.06, 1.0),
    "accent": (0.87, 0.33, 0.11, 1.0),
    "led": (0.70, 0.89, 1.0, 1.0),
}
_V6_ACCENT = (0.34, 0.36, 0.39, 1.0)


def colours_of(version: Version) -> dict[str, tuple[float, float, float, float]]:
    """The colours of a version's meshes: V6 was sold with dark grey accents, those before it in orange among others.

    Examples:
        >>> sorted(nk.parameters.colours_of("v6"))
        ['accent', 'black', 'dark', 'grey', 'led', 'white']
    """
    return COLOURS | ({"accent": _V6_ACCENT} if choice(version, VERSIONS, "NAO version") == "v6" else {})


def both_sides(parent: str, part: str, *colours: str) -> tuple[VisualRow, VisualRow]:
    """The part on the left and its mirror image on the right."""
    return VisualRow(f"L{parent}", f"l_{part}", colours), VisualRow(f"R{parent}", f"r_{part}", colours)


V6_VISUALS: tuple[VisualRow, ...] = (
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
