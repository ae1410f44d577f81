"""Robotics Toolbox for Python: kinematics, masses and meshes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from roboticstoolbox.models.URDF.URDFRobot import URDFRobot

from tools_table.probes.loaded import Loaded, Poses


def load(path: Path) -> Loaded:
    """Load a URDF with its meshes."""
    robot = URDFRobot(str(path.resolve()))
    moving = {link.jindex: link._joint_name for link in robot.links if link.isjoint}

    def poses(values: Mapping[str, float]) -> Poses:
        q = np.array([values[moving[index]] for index in range(robot.n)])
        found = robot.fkine_all(q)
        # The first is the base; the others are in the order of the links' numbers.
        return {link.name: np.asarray(found[link.number]) for link in robot.links}

    return Loaded(
        poses,
        mass=float(sum(link.m for link in robot.links)),
        meshes=sum(len(link.geometry) for link in robot.links),
    )
