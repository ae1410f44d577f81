"""V5 beside V6: another head, with four microphones around it and infrared."""

from __future__ import annotations

from nao_kin.parameters.overlay import VersionPage
from nao_kin.parameters.rows import FrameRow, InertialRow, VisualRow

# What the official files up to V5 give to links that have no mass of their own (phalanges, hand, force sensors); a mass
# matrix needs it to be regular. The V6 file has none.
_PLACEHOLDER = InertialRow("", 2e-06, (0.0, 0.0, 0.0), (1.1e-09, 0.0, 0.0, 1.1e-09, 0.0, 1.1e-09), "U5")

# fmt: off
V5 = VersionPage(
    version="v5",
    base="v6",
    inertials=(
        InertialRow("HeadPitch", 0.60533, (-0.00112, 0.0, 0.05258), (0.000957766, 8.78814e-06, 5.33702e-06, 0.000816836, -2.99579e-05, 0.000984976), "U5"),
    ),
    placeholder=_PLACEHOLDER,
    frames=(
        FrameRow("Gaze", "gaze", "HeadPitch", (0.05871, 0.0, 0.06364), (0.0, 0.0, 0.0), "U5"),
        FrameRow("MicroFrontCenter", "MicroFrontCenter_frame", "HeadPitch", (0.041, 0.0, 0.091), (0.0, 0.0, 0.0), "U4"),
        FrameRow("MicroRearCenter", "MicroRearCenter_frame", "HeadPitch", (-0.0577, 0.0, 0.0693), (0.0, 0.0, 0.0), "U4"),
        FrameRow("MicroSurroundLeft", "MicroSurroundLeft_frame", "HeadPitch", (-0.0195, 0.0606, 0.0331), (0.0, 0.0, 0.0), "U4"),
        FrameRow("MicroSurroundRight", "MicroSurroundRight_frame", "HeadPitch", (-0.0195, -0.0606, 0.0331), (0.0, 0.0, 0.0), "U4"),
        FrameRow("InfraredL", "LInfraRed_frame", "HeadPitch", (0.0441, 0.0257, 0.0466), (0.0, 0.0, 0.0), "U5"),
        FrameRow("InfraredR", "RInfraRed_frame", "HeadPitch", (0.0441, -0.0257, 0.0466), (0.0, 0.0, 0.0), "U5"),
    ),
    without_frames=(
        "MicroFrontLeft",
        "MicroFrontRight",
        "MicroRearLeft",
        "MicroRearRight",
        "MicrophoneFrame",
    ),
    visuals=(VisualRow("HeadPitch", "sensors_v5", ("dark", "black")),),
    without_visuals=("HeadPitch/sensors",),
)
# fmt: on
