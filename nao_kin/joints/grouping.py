"""Joints of several axes, found in a robot whose file knows only revolutes."""

from __future__ import annotations

import math
import numbers
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

import numpy as np

from nao_kin._arrays import Floats
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.joints._meeting import angles_between, distances, lock_angles, meeting_point, spans_a_joint
from nao_kin.joints._runs import partition
from nao_kin.joints.pairs import LOWER_PAIRS
from nao_kin.joints.tree import Node, Robot, read_tree
from nao_kin.joints.typed_joint import Coupling, JointGroups, Singularity, TypedJoint

Rule = Literal["coincident", "concurrent"]
RULES: tuple[Rule, ...] = ("coincident", "concurrent")

# Below the first, rounding decides; an offset above the second is design.
_TOLERANCES = (1e-15, 1e-2)
_MERGED = {2: "universal", 3: "spherical"}


def group_joints(robot: Robot, *, rule: Rule = "coincident", tolerance: float = 1e-9) -> JointGroups:
    """The robot's joints, with runs of consecutive revolutes merged into universal and spherical joints.

    A run goes from parent to child as long as the link between carries nothing else that has a coordinate of its own.
    Two of its neighbours make a universal joint, three a spherical one, when

    - "coincident": their centres, the origins of their frames, coincide;
    - "concurrent": their axes meet in one point. Axes that do so at zero do so in every configuration, for each
      turn leaves the point where it is;

    and neighbouring axes are not parallel, those of a spherical joint perpendicular (else the three turns would not
    reach every rotation, and a ball would be freer than the robot), and no motor turns two of them.

    Where runs can be cut in several ways, the cut with the fewest joints is taken; among those the one with the largest
    joints (by the sum of squares of their axes); among those the one whose larger joint is closer to the root.

    Args:
        robot: any `RobotModel`.
        rule: "coincident" or "concurrent".
        tolerance: how far a centre, or an axis, may be from the common point [m], in [1e-15, 0.01].

    Raises:
        UnknownName: no such rule.
        BadArgument: a tolerance outside these bounds; no robot model.
        BadModel: a joint that is neither revolute, prismatic nor the free base.
    """
    if not isinstance(rule, str) or rule not in RULES:
        raise UnknownName("rule", rule, RULES)
    allowed = _checked_tolerance(tolerance)
    nodes = read_tree(robot)
    return _grouped(nodes, _cut(nodes, rule, allowed), rule, allowed)


def unmerged_joints(robot: Robot) -> JointGroups:
    """The robot's joints as its file has them, one by one; their rule is "none".

    Raises:
        BadArgument: no robot model.
        BadModel: a joint that is neither revolute, prismatic nor the free base.
    """
    nodes = read_tree(robot)
    return _grouped(nodes, [[node] for node in nodes.values() if _counts(node)], "none", 0.0)


def _grouped(nodes: Mapping[int, Node], pieces: Iterable[Sequence[Node]], rule: str, tolerance: float) -> JointGroups:
    groups: dict[int, TypedJoint] = {}
    joints = []
    for members in pieces:
        joint = _typed_joint(members, _parent(nodes, members[0], groups), rule)
        groups |= {node.index: joint for node in members}
        joints.append(joint)
    return JointGroups(
        joints=tuple(joints),
        couplings=tuple(
            Coupling(node.name, node.tie.joint, node.tie.multiplier, node.tie.offset)
            for node in nodes.values()
            if node.index in groups and node.tie is not None
        ),
        driven=tuple(node.name for node in nodes.values() if node.index not in groups),
        rule=rule,
        tolerance=tolerance,
    )


def _checked_tolerance(tolerance: object) -> float:
    least, most = _TOLERANCES
    if not isinstance(tolerance, numbers.Real):
        raise BadArgument(f"tolerance must be a length in metres, got {tolerance!r}")
    try:
        value = float(tolerance)
    except OverflowError:
        value = math.inf
    if not least <= value <= most:
        raise BadArgument(f"tolerance must be in [{least:g}, {most:g}] m, got {value:g}")
    return value


def _cut(nodes: Mapping[int, Node], rule: Rule, tolerance: float) -> list[list[Node]]:
    """The parts of every joint, in the order of the model."""

    def mergeable(members: Sequence[Node]) -> bool:
        axes = _stacked(node.axis_root for node in members)
        if len({node.driver for node in members}) < len(members) or not spans_a_joint(axes):
            return False
        centres = _stacked(node.centre_root for node in members)
        centre = _centre(centres, axes, rule)
        missed = np.linalg.norm(centres - centre, axis=1) if rule == "coincident" else distances(centre, centres, axes)
        return bool(missed.max() <= tolerance)

    pieces = [piece for run in _runs(nodes) for piece in partition(run, mergeable, max(_MERGED))]
    return sorted(pieces, key=lambda piece: piece[0].index)


def _runs(nodes: Mapping[int, Node]) -> list[list[Node]]:
    """Every joint that counts, in longest runs of revolutes; other kinds alone."""
    runs: dict[int, list[Node]] = {}
    for node in nodes.values():
        if not _counts(node):
            continue
        parent = nodes.get(node.parent)
        continues = (
            parent is not None
            and node.kind == parent.kind == "revolute"
            and sum(nodes[child].moves for child in parent.children) == 1
        )
        run = runs[node.parent] if continues else []
        run.append(node)
        runs[node.index] = run
    return list({id(run): run for run in runs.values()}.values())


def _counts(node: Node) -> bool:
    """Whether a joint adds a freedom, or carries one that does."""
    return node.moves and node.kind != "fixed"


def _parent(nodes: Mapping[int, Node], node: Node, groups: Mapping[int, TypedJoint]) -> str:
    index = node.parent
    while index in nodes and index not in groups:
        index = nodes[index].parent
    return groups[index].name if index in groups else ""


def _typed_joint(members: Sequence[Node], parent: str, rule: str) -> TypedJoint:
    first = members[0]
    kind = _MERGED.get(len(members), first.kind)
    axes = np.zeros((0, 3)) if kind == "free" else _stacked(node.axis_root for node in members)
    centres = _stacked(node.centre_root for node in members)
    centre = _centre(centres, axes, rule) if len(members) > 1 else centres[0]
    for array in (axes, centre):
        array.flags.writeable = False
    singularity = None
    if len(members) == 3:
        middle = members[1]
        singularity = Singularity(middle.name, lock_angles(axes), middle.lower, middle.upper)
    return TypedJoint(
        name="+".join(node.name for node in members),
        pair=LOWER_PAIRS[kind],
        joints=tuple(node.name for node in members),
        parent=parent,
        centre=centre,
        axes=axes,
        angles_between=angles_between(axes),
        residual=float(distances(centre, centres, axes).max()) if len(members) > 1 else 0.0,
        lower=tuple(node.lower for node in members),
        upper=tuple(node.upper for node in members),
        units=tuple(node.unit for node in members),
        singularity=singularity,
    )


def _centre(centres: Floats, axes: Floats, rule: str) -> Floats:
    if rule == "coincident":
        # The mean of the differences is exactly zero where the centres are exactly one.
        return np.asarray(centres[0] + (centres - centres[0]).mean(axis=0))
    return meeting_point(centres, axes)


def _stacked(vectors: Iterable[Floats]) -> Floats:
    return np.stack(list(vectors))
