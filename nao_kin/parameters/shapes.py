"""NAOqi's collision primitives."""

from __future__ import annotations

from nao_kin.parameters.rows import ShapeRow, Vector

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
