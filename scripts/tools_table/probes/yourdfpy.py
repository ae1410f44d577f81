"""yourdfpy: kinematics with couplings, and meshes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import yourdfpy

from tools_table.probes.loaded import Loaded, Poses


def load(path: Path) -> Loaded:
    """Load a URDF with its meshes."""
    robot = yourdfpy.URDF.load(str(path))

    def poses(values: Mapping[str, float]) -> Poses:
        robot.update_cfg({name: values[name] for name in robot.actuated_joint_names})
        return {link: robot.get_transform(link) for link in robot.link_map}

    masses = (link.inertial.mass for link in robot.link_map.values() if link.inertial is not None)
    return Loaded(poses, mass=sum(masses), meshes=len(robot.scene.graph.nodes_geometry))
