"""Distances between the joints."""

from __future__ import annotations

from nao_kin.parameters.rows import VERSIONS, OffsetRow, Version

_V33_ON: tuple[Version, ...] = ("v3.3", "v4", "v5", "v6")
_V32: tuple[Version, ...] = ("v3.2",)

OFFSETS: tuple[OffsetRow, ...] = (
    OffsetRow("NeckOffsetZ", 126.5, VERSIONS, "L6"),
    OffsetRow("ShoulderOffsetY", 98.0, VERSIONS, "L6"),
    OffsetRow("ShoulderOffsetZ", 100.0, VERSIONS, "L6"),
    OffsetRow("ElbowOffsetY", 15.0, _V33_ON, "L6"),
    OffsetRow("ElbowOffsetY", 0.0, _V32, "L32"),
    OffsetRow("UpperArmLength", 105.0, _V33_ON, "L6"),
    OffsetRow("UpperArmLength", 90.0, _V32, "L32"),
    OffsetRow("LowerArmLength", 55.95, _V33_ON, "L6"),
    OffsetRow("LowerArmLength", 50.55, _V32, "L32"),
    OffsetRow("HandOffsetX", 57.75, _V33_ON, "L6"),
    OffsetRow("HandOffsetX", 58.0, _V32, "L32"),
    OffsetRow("HandOffsetZ", 12.31, _V33_ON, "L6"),
    OffsetRow("HandOffsetZ", 15.9, _V32, "L32"),
    OffsetRow("HipOffsetY", 50.0, VERSIONS, "L6"),
    OffsetRow("HipOffsetZ", 85.0, VERSIONS, "L6"),
    OffsetRow("ThighLength", 100.0, VERSIONS, "L6"),
    OffsetRow("TibiaLength", 102.9, VERSIONS, "L6"),
    # The documentation's foot height, and the one that NAOqi's own leg effector has: they differ by 0.08 mm.
    OffsetRow("FootHeight", 45.19, _V33_ON, "L6"),
    OffsetRow("FootHeight", 45.11, _V32, "L32"),
    OffsetRow("LegEffectorHeight", 45.11, VERSIONS, "MIM"),
)
