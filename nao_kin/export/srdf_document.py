"""SRDF: what MoveIt asks about a robot beside its URDF."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree as ET

from nao_kin._common.scalars import whole_number
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import UnknownName
from nao_kin.export.disabled_collisions import disabled_collisions
from nao_kin.export.exported import Exported
from nao_kin.export.link_contacts import LinkContacts, LinkPair
from nao_kin.export.planning_groups import Group, Planning, planning
from nao_kin.robot import RobotModel, check_robot
from nao_kin.urdf import UrdfTree

Attachment = Literal["fixed", "floating", "planar"]
ATTACHMENTS: tuple[Attachment, ...] = ("fixed", "floating", "planar")
WORLD = "world"

# MoveIt, "URDF and SRDF": characters that joint names should not contain.
_TROUBLESOME = re.compile(r"[-\[\](),]")


def srdf(
    robot: RobotModel,
    path: Path | str,
    *,
    attachment: Attachment | None = None,
    samples: int = 10_000,
    seed: int = 0,
    force: bool = False,
) -> Exported:
    """Write the robot's planning groups, end effectors, postures and needless collision checks as an SRDF."""
    raise NotImplementedError
