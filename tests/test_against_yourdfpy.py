"""yourdfpy reads the same files with other code: every frame of every version must come out the same."""

from __future__ import annotations

import numpy as np
import yourdfpy

import nao_kin as nk


def test_every_frame_agrees_on_a_thousand_configurations(each_nao: nk.NaoModel) -> None:
    oracle = yourdfpy.URDF.load(str(each_nao.urdf_path), load_meshes=False, load_collision_meshes=False)
    parents = {joint.child: joint for joint in oracle.robot.joints}
    for q in each_nao.random(0, 1000):
        angles = each_nao.angles(q)
        oracle.update_cfg(np.array([angles[name] for name in oracle.actuated_joint_names]))
        # Poses composed along yourdfpy's own tree, each joint's transform once.
        poses = {oracle.base_link: np.eye(4)}
        for link in each_nao.link_names:
            _compose(link, poses, parents, oracle)
        expected = np.stack([poses[link] for link in each_nao.link_names])
        assert np.abs(each_nao.fk(q) - expected).max() < 1e-12


def _compose(link: str, poses: dict, parents: dict, oracle: yourdfpy.URDF) -> np.ndarray:
    if link not in poses:
        joint = parents[link]
        step, _ = oracle.scene.graph.transforms.edge_data[(joint.parent, link)]["matrix"], None
        poses[link] = _compose(joint.parent, poses, parents, oracle) @ step
    return poses[link]
