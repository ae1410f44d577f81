"""Which of the links that fixed joints hold stay: all, those that the robot's semantics name, or none."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from nao_kin._common.choices import choice
from nao_kin.export.variants.mass import body_of, pseudo_inertia
from nao_kin.export.variants.placement import HERE, composed
from nao_kin.semantics import Semantics
from nao_kin.urdf import Collision, Inertial, Origin, UrdfJoint, UrdfTree, Visual

Frames = Literal["all", "effectors", "none"]
FRAMES: tuple[Frames, ...] = ("all", "effectors", "none")

_MOST_NAMED = 6


def keep_frames(tree: UrdfTree, frames: str, semantics: Semantics) -> tuple[UrdfTree, tuple[str, ...]]:
    """The tree with fewer of the links that fixed joints hold; the others are merged into the links that carry them.

    Mass and shapes of a merged link go to the link that carries it, so that every remaining link moves as before, and
    the mass and the centre of mass of the robot stay. A root without mass and shapes that holds one link at its own
    place, and nothing else, gives way to that link: simulators want the mass of the trunk on the root.

    Args:
        tree: the robot.
        frames: "all" changes nothing; "effectors" leaves the frames that `semantics` names: end effectors, soles,
            cameras, sensors; "none" leaves one link for each body.
        semantics: what the robot means.

    Returns:
        The tree, and one line for what has changed.

    Raises:
        UnknownName: no such choice.

    Examples:
        >>> from nao_kin.export.variants.frames import keep_frames
        >>> nao = nk.load_nao("v6")
        >>> tree, changes = keep_frames(nao.tree, "none", nao.semantics)
        >>> len(nao.tree.links), len(tree.links), tree.root
        (124, 43, 'torso')
    """
    choice(frames, FRAMES, "choice of frames")
    if frames == "all":
        return tree, ()
    named = {name for name, _ in semantics.frames()} if frames == "effectors" else set[str]()
    named |= {tree.shared_names[name] for name in named if name in tree.shared_names}
    fixed = [joint for joint in tree.joints if joint.kind == "fixed"]
    changes: list[str] = []
    bare = _bare_root(tree, fixed)
    if bare is not None:
        changes.append(f"{tree.root} has neither mass nor shapes: {bare} is the root instead of it")
        tree = _rooted_at(tree, bare)
    gone = [joint.child for joint in tree.joints if joint.kind == "fixed" and joint.child not in named]
    if gone:
        names = ", ".join(gone[:_MOST_NAMED]) + (", …" if len(gone) > _MOST_NAMED else "")
        changes.append(f"{len(gone)} links on fixed joints are merged into the links that carry them: {names}")
    return merged(tree, gone), tuple(changes)


def merged(tree: UrdfTree, gone: Collection[str]) -> UrdfTree:
    """The tree without the links `gone`, which fixed joints hold: what they have and carry goes to what holds them."""
    away = set(gone)
    # Link → the link it is part of, and where in that one's frame.
    hosts: dict[str, tuple[str, Origin]] = {tree.root: (tree.root, HERE)}
    joints: list[UrdfJoint] = []
    for joint in tree.joints:
        host, place = hosts[joint.parent]
        place = composed(place, joint.origin)
        if joint.child in away:
            hosts[joint.child] = host, place
        else:
            hosts[joint.child] = joint.child, HERE
            joints.append(joint if host == joint.parent else replace(joint, parent=host, origin=place))
    return replace(
        tree,
        links=tuple(link for link in tree.links if link not in away),
        joints=tuple(joints),
        inertials=_merged_bodies(tree, hosts),
        visuals=tuple(replace(v, link=hosts[v.link][0], origin=_in_host(v, hosts)) for v in tree.visuals),
        collisions=tuple(replace(c, link=hosts[c.link][0], origin=_in_host(c, hosts)) for c in tree.collisions),
        shared_names={old: new for old, new in tree.shared_names.items() if new not in away},
    )


def _in_host(shape: Visual | Collision, hosts: Mapping[str, tuple[str, Origin]]) -> Origin:
    return composed(hosts[shape.link][1], shape.origin)


def _merged_bodies(tree: UrdfTree, hosts: Mapping[str, tuple[str, Origin]]) -> dict[str, Inertial]:
    parts: dict[str, list[tuple[Inertial, Origin]]] = {}
    for link in tree.links:
        body = tree.inertials.get(link)
        if body is not None:
            host, place = hosts[link]
            parts.setdefault(host, []).append((body, place))
    bodies = dict[str, Inertial]()
    for host, several in parts.items():
        (first, place), *others = several
        if not others and place == HERE:
            bodies[host] = first  # with the numbers that the file has
        else:
            bodies[host] = body_of(np.sum([pseudo_inertia(body, place) for body, place in several], axis=0))
    return bodies


def _bare_root(tree: UrdfTree, fixed: Collection[UrdfJoint]) -> str | None:
    """The one link that a root without mass and shapes holds at its own place; None where it is not so."""
    root = tree.root
    held = [joint for joint in tree.joints if joint.parent == root]
    shaped = {visual.link for visual in tree.visuals} | {shape.link for shape in tree.collisions}
    if len(held) != 1 or held[0] not in fixed or held[0].origin != HERE or root in shaped or root in tree.inertials:
        return None
    return held[0].child


def _rooted_at(tree: UrdfTree, link: str) -> UrdfTree:
    return replace(
        tree,
        root=link,
        links=tuple(name for name in tree.links if name != tree.root),
        joints=tuple(joint for joint in tree.joints if joint.child != link),
        shared_names={old: new for old, new in tree.shared_names.items() if new != tree.root},
    )
