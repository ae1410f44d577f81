"""Joints that follow another one: chains of mimics made direct, and an order in which the driving joint comes first."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from nao_kin.urdf_reader.tree import Mimic, UrdfJoint


class CouplingRefused(Exception):
    """Why the couplings of a file cannot be kept."""


def resolve_chains(joints: Mapping[str, UrdfJoint], notes: list[str]) -> dict[str, UrdfJoint]:
    """Every mimic tied to the joint at the end of its chain: a follows b follows c becomes a follows c.

    Raises:
        CouplingRefused: a joint follows itself, a joint that does not exist, or one that cannot move.
    """
    resolved = dict(joints)
    for name, joint in joints.items():
        if joint.mimic is None:
            continue
        multiplier, offset, driver, seen = 1.0, 0.0, joint, [name]
        while driver.mimic is not None:
            # joint = multiplier · driver + offset, and driver = m · next + o
            offset += multiplier * driver.mimic.offset
            multiplier *= driver.mimic.multiplier
            target = driver.mimic.joint
            if target not in joints:
                raise CouplingRefused(f"joint {driver.name!r} follows {target!r}, which does not exist")
            if target in seen:
                raise CouplingRefused(f"joints follow each other in a circle: {' → '.join([*seen, target])}")
            seen.append(target)
            driver = joints[target]
        if driver.kind == "fixed":
            raise CouplingRefused(f"joint {name!r} follows {driver.name!r}, which is fixed")
        if len(seen) > 2:
            path = ", which follows ".join(map(repr, seen[1:]))
            notes.append(f"joint {name!r} follows {path}: tied to {driver.name!r} directly")
        resolved[name] = replace(joint, mimic=Mimic(driver.name, multiplier, offset))
    return resolved


def drive_order(joints: Mapping[str, UrdfJoint], root: str, notes: list[str]) -> list[UrdfJoint]:
    """The joints as a depth-first walk meets them, siblings by name, but a driving joint before those that follow it.

    Where no walk can meet the driving joint first (it sits further out on the same branch, or two branches drive each
    other), the first joint of the coupled group drives the group instead: the motion is the same, the coordinate is
    another joint's, and the notes say so.

    Raises:
        CouplingRefused: such a change would divide by a multiplier of zero.
    """
    walk = _walk(joints, root)
    position = {joint.name: index for index, joint in enumerate(walk)}
    followers: dict[str, list[tuple[UrdfJoint, Mimic]]] = {}
    for joint in walk:
        if joint.mimic is not None:
            followers.setdefault(joint.mimic.joint, []).append((joint, joint.mimic))
    changed: dict[str, UrdfJoint] = {}
    for driver, group in followers.items():
        first, tie = group[0]
        if position[driver] < position[first.name]:
            continue
        if tie.multiplier == 0.0:
            raise CouplingRefused(f"joint {first.name!r} follows {driver!r} with multiplier 0 and comes before it")
        # driver = (first − offset) / multiplier, and the others accordingly
        inverse = Mimic(first.name, 1.0 / tie.multiplier, -tie.offset / tie.multiplier)
        changed[first.name] = replace(first, mimic=None)
        changed[driver] = replace(joints[driver], mimic=inverse)
        for joint, other in group[1:]:
            offset = other.offset + other.multiplier * inverse.offset
            changed[joint.name] = replace(joint, mimic=Mimic(first.name, other.multiplier * inverse.multiplier, offset))
        notes.append(f"joint {first.name!r} drives {driver!r}, not the other way round: it comes first in the tree")
    return [changed.get(joint.name, joint) for joint in walk]


def share_limits(joints: list[UrdfJoint], notes: list[str]) -> list[UrdfJoint]:
    """Every driving joint confined to the values at which all that follow it are inside their own limits too.

    Raises:
        CouplingRefused: there is no such value.
    """
    index = {joint.name: position for position, joint in enumerate(joints)}
    shared = list(joints)
    for follower in joints:
        tie = follower.mimic
        if tie is None:
            continue
        driver = shared[index[tie.joint]]
        lower, upper, velocity = driver.lower, driver.upper, driver.velocity
        if tie.multiplier != 0.0:
            ends = sorted((bound - tie.offset) / tie.multiplier for bound in (follower.lower, follower.upper))
            lower, upper = _larger(lower, ends[0]), -_larger(-upper, -ends[1])
            velocity = -_larger(-velocity, -follower.velocity / abs(tie.multiplier))
        if lower > upper:
            raise CouplingRefused(
                f"joint {follower.name!r} follows {driver.name!r}, and no value suits both their limits"
            )
        if (lower, upper) != (driver.lower, driver.upper):
            notes.append(f"joint {driver.name!r} confined to [{lower:.6g}, {upper:.6g}] by {follower.name!r}")
        shared[index[driver.name]] = replace(driver, lower=lower, upper=upper, velocity=velocity)
    return shared


def _larger(value: float, other: float) -> float:
    """The larger of two bounds; the first where they differ by rounding only."""
    return value if other <= value or math.isclose(value, other, rel_tol=1e-9, abs_tol=1e-12) else other


def _walk(joints: Mapping[str, UrdfJoint], root: str) -> list[UrdfJoint]:
    children: dict[str, list[UrdfJoint]] = {}
    for joint in sorted(joints.values(), key=lambda joint: joint.name):
        children.setdefault(joint.parent, []).append(joint)
    order = _depth_first(children, root)
    if all(joint.mimic is None for joint in order):
        return order
    branch: dict[str, set[str]] = {}
    for joint in reversed(order):
        branch[joint.name] = {joint.name}.union(*(branch[child.name] for child in children.get(joint.child, [])))
    for siblings in children.values():
        if len(siblings) > 1:
            siblings[:] = _drivers_first(siblings, branch, joints)
    return _depth_first(children, root)


def _depth_first(children: Mapping[str, list[UrdfJoint]], root: str) -> list[UrdfJoint]:
    order: list[UrdfJoint] = []
    stack = list(reversed(children.get(root, [])))
    while stack:
        joint = stack.pop()
        order.append(joint)
        stack.extend(reversed(children.get(joint.child, [])))
    return order


def _drivers_first(
    siblings: list[UrdfJoint], branch: Mapping[str, set[str]], joints: Mapping[str, UrdfJoint]
) -> list[UrdfJoint]:
    """Siblings by name, each after the siblings whose branches hold what drives a joint of its own branch."""
    wanted = {
        sibling.name: {tie.joint for name in branch[sibling.name] if (tie := joints[name].mimic) is not None}
        for sibling in siblings
    }
    waiting, placed = list(siblings), list[UrdfJoint]()
    while waiting:
        ready = (
            candidate
            for candidate in waiting
            if not any(wanted[candidate.name] & branch[other.name] for other in waiting if other is not candidate)
        )
        # Branches that drive each other have no right order: the first by name goes first.
        chosen = next(ready, waiting[0])
        waiting.remove(chosen)
        placed.append(chosen)
    return placed
