"""ikpy: kinematics of one chain from the trunk to each end of the tree."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from ikpy.chain import Chain

from tools_table.probes.loaded import Loaded, Poses


def load(path: Path) -> Loaded:
    """Load a URDF chain by chain."""
    chains = [_chain(path, elements) for elements in _paths(path)]

    def poses(values: Mapping[str, float]) -> Poses:
        found = {"torso": np.eye(4)}
        for chain, links in chains:
            q = [values.get(joint.name, 0.0) for joint in chain.links]
            # The first of the frames is the chain's own origin.
            found |= zip(links, chain.forward_kinematics(q, full_kinematics=True)[1:], strict=True)
        return found

    return Loaded(poses)


def _chain(path: Path, elements: list[str]) -> tuple[Chain, list[str]]:
    return Chain.from_urdf_file(str(path), base_elements=elements.copy(), symbolic=False), elements[2::2]


def _paths(path: Path) -> Iterator[list[str]]:
    """Return the paths from the trunk to every link without children: link, joint, link, joint, …, link."""
    above = {}
    for joint in ET.parse(path).getroot().iter("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            above[child.attrib["link"]] = parent.attrib["link"], joint.attrib["name"]
    carrying = {parent for parent, _ in above.values()}
    for end in above:
        elements, link = [end], end
        while end not in carrying and link != "torso":
            link, joint_name = above[link]
            elements = [link, joint_name, *elements]
        if len(elements) > 1:
            yield elements
