"""What each link looks like: which meshes it wears, and in which colours."""

from __future__ import annotations

from dataclasses import dataclass

from nao_kin.parameters.rows import VERSIONS, Version

# Red, green, blue, opacity.
COLOURS: dict[str, tuple[float, float, float, float]] = {
    "white": (0.93, 0.93, 0.94, 1.0),
    "grey": (0.66, 0.68, 0.71, 1.0),
    "dark": (0.23, 0.24, 0.27, 1.0),
    "black": (0.05, 0.05, 0.06, 1.0),
    "accent": (0.87, 0.33, 0.11, 1.0),
    "led": (0.70, 0.89, 1.0, 1.0),
}


@dataclass(frozen=True)
class VisualRow:
    """The meshes of one link: a file per colour, in the frame of the joint that moves the link.

    Attributes:
        parent: the joint that moves the link, "torso", or a phalanx without its side ("Finger11").
        part: name of the part.
        colours: its colours; colour c stands in the file `{part}_{c}.obj`.
    """

    parent: str
    part: str
    colours: tuple[str, ...]
    versions: tuple[Version, ...] = VERSIONS
    source: str = "GEN"

    @property
    def meshes(self) -> tuple[str, ...]:
        """Names of the meshes, in the order of the colours."""
        return tuple(f"{self.part}_{colour}" for colour in self.colours)


_V32: tuple[Version, ...] = ("v3.2",)
_V33_ON: tuple[Version, ...] = ("v3.3", "v4", "v5", "v6")


def _both(
    parent: str, part: str, *colours: str, versions: tuple[Version, ...] = VERSIONS
) -> tuple[VisualRow, VisualRow]:
    """The part on the left and its mirror image on the right."""
    return (
        VisualRow(f"L{parent}", f"l_{part}", colours, versions),
        VisualRow(f"R{parent}", f"r_{part}", colours, versions),
    )


VISUALS: tuple[VisualRow, ...] = (
    VisualRow("torso", "torso", ("white", "accent", "dark", "grey", "led")),
    VisualRow("HeadYaw", "neck", ("dark",)),
    VisualRow("HeadPitch", "head", ("white", "accent", "grey", "dark", "black", "led")),
    *_both("ShoulderPitch", "shoulder", "dark"),
    *_both("ShoulderRoll", "shoulder_pad", "accent"),
    *_both("ShoulderRoll", "upper_arm", "white", versions=_V33_ON),
    *_both("ShoulderRoll", "upper_arm_v32", "white", versions=_V32),
    *_both("ElbowYaw", "elbow", "dark"),
    *_both("ElbowRoll", "hinge", "dark"),
    *_both("ElbowRoll", "forearm", "white", versions=_V33_ON),
    *_both("ElbowRoll", "forearm_v32", "white", versions=_V32),
    *_both("WristYaw", "hand", "white", "dark"),
    *_both("HipYawPitch", "pelvis", "white", "dark"),
    *_both("HipRoll", "hip", "grey"),
    *_both("HipPitch", "thigh", "white", "accent", "grey"),
    *_both("KneePitch", "shin", "white", "accent", "dark"),
    *_both("AnklePitch", "ankle", "dark"),
    *_both("AnkleRoll", "foot", "white", "accent", "dark", "led"),
    *(VisualRow(f"Finger{n}", "phalanx", ("dark",)) for n in (11, 12, 21, 22)),
    *(VisualRow(f"Finger{n}", "fingertip", ("dark",)) for n in (13, 23)),
    VisualRow("Thumb1", "phalanx", ("dark",)),
    VisualRow("Thumb2", "fingertip", ("dark",)),
)
