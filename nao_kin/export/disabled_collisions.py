"""Pairs of links that a planner need not look at, by the rules and words of MoveIt's setup assistant.

Source: MoveIt Setup Assistant, "Generate Self-Collision Matrix"; moveit_setup_srdf_plugins, compute_default_collisions.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection
from itertools import combinations

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.export.link_contacts import LinkContacts, LinkPair
from nao_kin.robot import RobotModel
from nao_kin.urdf import UrdfJoint, UrdfTree

ADJACENT, DEFAULT, ALWAYS, NEVER = "Adjacent", "Default", "Always", "Never"
# A pair that touches in more than this part of the configurations is taken to touch always.
ALWAYS_FROM = 0.95
# "Always" is decided by the first of the samples, for they must be counted to the last.
_COUNTED = 1000
# Configurations looked at together: at first few, for many pairs are soon decided.
_AT_ONCE, _REST_AT_ONCE = 50, 500


def disabled_collisions(robot: RobotModel, contacts: LinkContacts, *, samples: int, seed: int) -> dict[LinkPair, str]:
    """The pairs of links with shapes that need no collision check, and why.

    "Adjacent": `adjacent_links`. "Default": they touch in the posture that the robot starts in, or without one with
    every joint at zero, or in the middle of its range where zero is outside. "Always": they touch in more than 95 % of
    the configurations tried. "Never": they touch in none of them, and in no posture.

    Args:
        robot: the robot; its configurations are drawn inside its limits, coupled ones included.
        contacts: its shapes.
        samples: how many configurations are tried.
        seed: of the random numbers: the same seed gives the same pairs.
    """
    adjacent = adjacent_links(robot.tree, contacts.links)
    reasons = {pair: ADJACENT for pair in contacts.pairs() if pair in adjacent}
    unknown = set(contacts.pairs()) - set(reasons)
    touching = contacts.count(_default(robot)[None], unknown)
    reasons |= {pair: DEFAULT for pair in unknown if touching[pair]}
    unknown -= set(reasons)

    q, counts = robot.random(seed, samples), dict.fromkeys(unknown, 0)
    counted = min(samples, _COUNTED)
    for start in range(0, counted, _AT_ONCE):
        # A pair that has touched once, and been apart too often to touch always, needs no further look.
        still = {pair for pair in unknown if not counts[pair] or counted - start + counts[pair] > ALWAYS_FROM * counted}
        for pair, count in contacts.count(q[start : min(start + _AT_ONCE, counted)], still).items():
            counts[pair] += count
    reasons |= {pair: ALWAYS for pair in unknown if counts[pair] > ALWAYS_FROM * counted}
    rest = np.array([*(robot.posture(name) for name in robot.posture_names), *q[counted:]])
    unseen = {pair for pair in unknown if not counts[pair]}
    for start in range(0, len(rest), _REST_AT_ONCE):
        touching = contacts.count(rest[start : start + _REST_AT_ONCE], unseen, most=1)
        unseen = {pair for pair in unseen if not touching[pair]}
    return dict(sorted((reasons | dict.fromkeys(unseen, NEVER)).items()))


def adjacent_links(tree: UrdfTree, shaped: Collection[str]) -> set[LinkPair]:
    """Links with shapes whose contact says nothing: joined by a joint, or across links without shapes at one point.

    The setup assistant takes any two links for adjacent that have only links without shapes between them. Where an
    upper arm has no shape, a planner would then lead the forearm through the trunk.

    Args:
        tree: the robot.
        shaped: its links with shapes.
    """
    held: dict[str, list[UrdfJoint]] = defaultdict(list)
    for joint in tree.joints:
        held[joint.parent].append(joint)
    pairs: set[LinkPair] = set()
    # Link → itself if it has shapes, else the links with shapes that stand at the same point of it.
    here: dict[str, list[str]] = {}
    for link in reversed([tree.root, *(joint.child for joint in tree.joints)]):  # the outer ones first
        beyond = [here[joint.child] for joint in held[link] if link in shaped or _at_one_point(joint)]
        if link in shaped:
            pairs |= {(min(link, other), max(link, other)) for others in beyond for other in others}
            here[link] = [link]
        else:
            several = combinations(beyond, 2)
            pairs |= {(min(a, b), max(a, b)) for first, second in several for a in first for b in second}
            here[link] = [other for others in beyond for other in others]
    return pairs


def _at_one_point(joint: UrdfJoint) -> bool:
    """Whether what the joint moves stays where it is in its parent: at its origin, or rigidly held."""
    return joint.kind == "fixed" or (joint.kind == "revolute" and not any(joint.origin.xyz))


def _default(robot: RobotModel) -> Floats:
    if robot.semantics.start:
        return robot.posture(robot.semantics.start)
    values = {
        name: 0.0 if lower <= 0.0 <= upper else (lower + upper) / 2.0
        for name, lower, upper in zip(robot.joint_names, robot.lower, robot.upper, strict=True)
    }
    return robot.configuration(values, limits="ignore")
