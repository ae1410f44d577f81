"""rerun: the transforms of its URDF loader, joint by joint, and the meshes that it logs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from rerun.urdf import UrdfJoint, UrdfTree

from tools_table.probes.loaded import Loaded, Poses, from_wxyz


def load(path: Path) -> Loaded:
    """Load a URDF, and count the meshes that would be logged."""
    tree = UrdfTree.from_file_path(str(path))
    joints = tree.joints()
    columns = [chunk.to_record_batch().schema.names for chunk in tree.stream().to_chunks()]

    def poses(values: Mapping[str, float]) -> Poses:
        found = {tree.root_link().name: np.eye(4)}
        waiting = list(joints)
        while waiting:
            ready = [joint for joint in waiting if joint.parent_link in found]
            for joint in ready:
                found[joint.child_link] = found[joint.parent_link] @ _transform(joint, values.get(joint.name, 0.0))
            waiting = [joint for joint in waiting if joint not in ready]
        return found

    return Loaded(
        poses,
        meshes=sum("Asset3D:blob" in names for names in columns),
        told=[joint.name for joint in joints if joint.mimic is not None],
    )


def _transform(joint: UrdfJoint, value: float) -> np.ndarray:
    found = joint.compute_transform(value)
    x, y, z, w = found.quaternion.as_arrow_array().to_pylist()[0]
    return from_wxyz((w, x, y, z), found.translation.as_arrow_array().to_pylist()[0])
