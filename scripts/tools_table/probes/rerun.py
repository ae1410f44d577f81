"""rerun: the transforms of its URDF loader, joint by joint, and the meshes that it logs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import rerun
from rerun.urdf import UrdfTree

from tools_table.probes.loaded import Loaded, Poses, from_wxyz


def load(path: Path) -> Loaded:
    """Load a URDF, and log it into memory."""
    tree = UrdfTree.from_file_path(str(path))
    rerun.init("nao", spawn=False)
    rerun.memory_recording()
    tree.log_urdf_to_recording()
    joints = tree.joints()

    def poses(values: Mapping[str, float]) -> Poses:
        found = {tree.root_link().name: np.eye(4)}
        waiting = list(joints)
        while waiting:
            ready = [joint for joint in waiting if joint.parent_link in found]
            for joint in ready:
                found[joint.child_link] = found[joint.parent_link] @ _transform(joint, values.get(joint.name, 0.0))
            waiting = [joint for joint in waiting if joint not in ready]
        return found

    links = {joint.child_link for joint in joints} | {tree.root_link().name}
    return Loaded(
        poses,
        meshes=sum(len(tree.get_visual_geometry_paths(link)) for link in links),
        told=[joint.name for joint in joints if joint.mimic is not None],
    )


def _transform(joint: rerun.urdf.UrdfJoint, value: float) -> np.ndarray:
    found = joint.compute_transform(value)
    x, y, z, w = found.quaternion.as_arrow_array().to_pylist()[0]
    return from_wxyz((w, x, y, z), found.translation.as_arrow_array().to_pylist()[0])
