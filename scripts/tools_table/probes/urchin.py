"""urchin: kinematics with couplings, and meshes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import urchin

from tools_table.probes.loaded import Loaded, Poses


def load(path: Path) -> Loaded:
    """Load a URDF with its meshes."""
    robot = urchin.URDF.load(str(path))
    own = {joint.name for joint in robot.actuated_joints}

    def poses(values: Mapping[str, float]) -> Poses:
        found = robot.link_fk({name: value for name, value in values.items() if name in own})
        return {link.name: pose for link, pose in found.items()}

    shown = [visual for link in robot.links for visual in link.visuals if visual.geometry.mesh is not None]
    return Loaded(poses, mass=sum(link.inertial.mass for link in robot.links), meshes=len(shown))
