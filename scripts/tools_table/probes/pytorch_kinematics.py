"""pytorch_kinematics: kinematics of batches of configurations, and their derivatives."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytorch_kinematics
import torch

from tools_table.probes.loaded import Loaded, Poses


def load(path: Path) -> Loaded:
    """Load a URDF in double precision."""
    chain = pytorch_kinematics.build_chain_from_urdf(path.read_bytes()).to(dtype=torch.float64)

    def poses(values: Mapping[str, float]) -> Poses:
        known = {name: values.get(name, 0.0) for name in chain.get_joint_parameter_names()}
        return {link: pose.get_matrix()[0].numpy() for link, pose in chain.forward_kinematics(known).items()}

    return Loaded(poses)
