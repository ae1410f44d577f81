"""viser: the scene that it sends to a browser, frame by frame."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import viser
from viser.extras import ViserUrdf

from tools_table.probes.loaded import Loaded, Poses, from_wxyz


def load(path: Path) -> Loaded:
    """Load a URDF with its meshes, and measure the resulting scene."""
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    robot = ViserUrdf(server, path)
    names = robot.get_actuated_joint_names()

    def poses(values: Mapping[str, float]) -> Poses:
        robot.update_cfg(np.array([values[name] for name in names]))
        nodes = {frame.name: from_wxyz(frame.wxyz, frame.position) for frame in robot._joint_frames}
        return {link: _pose(node, nodes) for node in nodes for link in _names(node)}

    return Loaded(poses, meshes=len(robot._meshes))


def _pose(node: str, nodes: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the pose of a node: the product of the poses of all nodes whose paths begin its path."""
    T = np.eye(4)
    parts = node.split("/")
    for length in range(1, len(parts) + 1):
        T = T @ nodes.get("/".join(parts[:length]), np.eye(4))
    return T


def _names(node: str) -> list[str]:
    """Return the possible names of the link at this node: the names of some links contain slashes."""
    parts = node.split("/")
    return ["/".join(parts[-length:]) for length in (1, 2, 3)]
