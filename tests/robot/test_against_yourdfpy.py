"""yourdfpy reads the same files with other code: every frame of every version must come out the same."""

from __future__ import annotations

import numpy as np
import yourdfpy

import nao_kin as nk


def test_every_frame_agrees_on_many_configurations(each_nao: nk.NaoModel) -> None:
    oracle = yourdfpy.URDF.load(str(each_nao.urdf_path), load_meshes=False, load_collision_meshes=False)
    for q in each_nao.random(0, 100):
        angles = each_nao.angles(q)
        oracle.update_cfg(np.array([angles[name] for name in oracle.actuated_joint_names]))
        poses = _poses(oracle)
        expected = np.stack([poses[link] for link in each_nao.link_names])
        assert np.abs(each_nao.fk(q) - expected).max() < 1e-12


def _poses(oracle: yourdfpy.URDF) -> dict[str, np.ndarray]:
    """Poses of all links, each joint's transform taken from the scene once: its own look-up walks to the root."""
    steps = oracle.scene.graph.transforms.edge_data
    poses = {oracle.base_link: np.eye(4)}
    waiting = {joint.child: joint.parent for joint in oracle.robot.joints}
    while waiting:
        for child in [child for child, parent in waiting.items() if parent in poses]:
            parent = waiting.pop(child)
            poses[child] = poses[parent] @ steps[(parent, child)]["matrix"]
    return poses
