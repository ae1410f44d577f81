"""Ranges, speeds and torques of the joints of V6, and the ranges that depend on another joint."""

from __future__ import annotations

from nao_kin.parameters.rows import ActuatorRow, CoupledLimitRow, LimitRow

# Degrees, as the documentation prints them; the official URDF prints the same values converted. A joint that shares
# another one's motor has that one's row.
V6_LIMITS: tuple[LimitRow, ...] = (
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

# The speeds are the no-load speeds of the V3.x motors, which the official URDF of every later version repeats.
V6_ACTUATORS: tuple[ActuatorRow, ...] = (
    ActuatorRow("HeadYaw", 8.26797, 1.547, "U6"),
    ActuatorRow("HeadPitch", 7.19407, 1.532, "U6"),
    ActuatorRow("LShoulderPitch", 8.26797, 1.329, "U6"),
    ActuatorRow("LShoulderRoll", 7.19407, 1.7835, "U6"),
    ActuatorRow("LElbowYaw", 8.26797, 1.547, "U6"),
    ActuatorRow("LElbowRoll", 7.19407, 1.532, "U6"),
    ActuatorRow("LWristYaw", 24.6229, 0.4075, "U6"),
    ActuatorRow("LHand", 8.33, 0.292, "U6"),
    ActuatorRow("LHipYawPitch", 4.16174, 3.348, "U6"),
    ActuatorRow("LHipRoll", 4.16174, 3.348, "U6"),
    ActuatorRow("LHipPitch", 6.40239, 3.023, "U6"),
    ActuatorRow("LKneePitch", 6.40239, 3.023, "U6"),
    ActuatorRow("LAnklePitch", 6.40239, 3.023, "U6"),
    ActuatorRow("LAnkleRoll", 4.16174, 3.348, "U6"),
    ActuatorRow("RShoulderPitch", 8.26797, 1.329, "U6"),
    ActuatorRow("RShoulderRoll", 7.19407, 1.783, "U6"),
    ActuatorRow("RElbowYaw", 8.26797, 1.547, "U6"),
    ActuatorRow("RElbowRoll", 7.19407, 1.532, "U6"),
    ActuatorRow("RWristYaw", 24.6229, 0.4075, "U6"),
    ActuatorRow("RHand", 8.33, 0.292, "U6"),
    ActuatorRow("RHipRoll", 4.16174, 3.348, "U6"),
    ActuatorRow("RHipPitch", 6.40239, 3.0226, "U6"),
    ActuatorRow("RKneePitch", 6.40239, 3.0226, "U6"),
    ActuatorRow("RAnklePitch", 6.40239, 3.0226, "U6"),
    ActuatorRow("RAnkleRoll", 4.16174, 3.348, "U6"),
)

# One table for all versions.
COUPLED_LIMITS: tuple[CoupledLimitRow, ...] = (
    CoupledLimitRow(
        "HeadPitch",
        "HeadYaw",
        (
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
        ),
        "J6",
    ),
    CoupledLimitRow(
        "LAnkleRoll",
        "LAnklePitch",
        (
            (-68.15, -2.86, 4.3),
            (-48.13, -10.31, 9.74),
            (-40.11, -22.8, 12.61),
            (-25.78, -22.8, 44.06),
            (5.73, -22.8, 44.06),
            (20.05, -22.8, 31.54),
            (52.87, 0.0, 2.86),
        ),
        "J6",
    ),
    CoupledLimitRow(
        "RAnkleRoll",
        "RAnklePitch",
        (
            (-68.15, -4.3, 2.86),
            (-48.13, -9.74, 10.31),
            (-40.11, -12.61, 22.8),
            (-25.78, -44.06, 22.8),
            (5.73, -44.06, 22.8),
            (20.05, -31.54, 22.8),
            (52.87, -2.86, 0.0),
        ),
        "J6",
    ),
)
