"""kinpy: kinematics of the whole tree in NumPy."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import kinpy

from tools_table.probes.loaded import Loaded, Poses


def load(path: Path) -> Loaded:
    """Load a URDF."""
    chain = kinpy.build_chain_from_urdf(path.read_bytes())

    def poses(values: Mapping[str, float]) -> Poses:
        return {link: pose.matrix() for link, pose in chain.forward_kinematics(dict(values)).items()}

    return Loaded(poses)
