"""What the NAO's frames are for, and how it rests in the postures that leave its feet."""

from __future__ import annotations

from nao_kin.parameters.rows import Vector

END_EFFECTORS: tuple[str, ...] = ("Head", "LArm", "RArm", "LLeg", "RLeg")
SOLES: tuple[str, ...] = ("LLeg", "RLeg")

# Close views: name, direction from the robot to the camera, and the joints whose links it shows.
VIEWS: tuple[tuple[str, Vector, tuple[str, ...]], ...] = (
    ("hands", (1.0, 0.25, 0.55), ("LWristYaw", "RWristYaw")),
    ("feet", (1.0, 0.45, 0.42), ("LAnklePitch", "RAnklePitch")),
)

# NAOqi's postures say nothing about the trunk. Off its feet the robot rests where its centre of mass is lowest: the
# vertical there in the torso's frame, found with the shapes of the V6 by turning them until no small turn lowers it.
REST: dict[str, Vector] = {
    "Sit": (0.384, -0.001, 0.923),
    "SitRelax": (0.177, 0.010, 0.984),
    "LyingBelly": (-0.976, -0.160, 0.146),
    "LyingBack": (1.000, -0.015, 0.003),
}
