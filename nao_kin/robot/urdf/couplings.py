"""Mimic joints: direct mimics instead of chains, driving joints first, shared limits."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from nao_kin._core.text import abbreviated, quoted
from nao_kin.robot.semantics import Mimic
from nao_kin.robot.urdf.tree import Origin, UrdfJoint

# Number of joints of a chain of mimics that a note names.
_MAX_NAMED = 8


class Refused(Exception):
    """The reason why a file is refused; the reader adds the file's name."""


def resolve_chains(joints: Mapping[str, UrdfJoint], notes: list[str]) -> dict[str, UrdfJoint]:
    """Return the joints with direct mimics: a follows b follows c becomes a follows c.

    A joint that follows a fixed one, which is at zero, becomes fixed at its offset.
    """
    direct: dict[str, Mimic] = {}
    for name in joints:
        chain, end = dict[str, Mimic](), name
        while end not in direct and (mimic := joints[end].mimic) is not None:
            chain[end] = mimic
            if mimic.joint not in joints:
                raise Refused(f"joint {quoted(end)} follows {quoted(mimic.joint)}, which does not exist")
            if mimic.joint in chain:
                circle = abbreviated(" → ".join([*chain, mimic.joint]))
                raise Refused(f"joints follow each other in a circle: {circle}")
            end = mimic.joint
        for follower, mimic in reversed(chain.items()):
            direct[follower] = mimic.through(direct[mimic.joint]) if mimic.joint in direct else mimic
    resolved = {}
    for name, joint in joints.items():
        mimic = direct.get(name)
        resolved[name] = replace(joint, mimic=mimic)
        if mimic is not None and joints[mimic.joint].kind == "fixed":
            place = Origin.of(joint.origin.matrix @ joint.travel(mimic.offset))
            resolved[name] = UrdfJoint(name, "fixed", joint.parent, joint.child, place)
            notes.append(
                f"joint {quoted(name)} follows {quoted(mimic.joint)}, which is fixed: fixed at {mimic.offset:g}"
            )
        elif joint.mimic is not None and joint.mimic.joint in direct:
            path = ", which follows ".join(map(quoted, itertools.islice(_drivers(joints, joint.mimic), _MAX_NAMED)))
            notes.append(f"joint {quoted(name)} follows {path}: made to follow {quoted(direct[name].joint)} directly")
    return resolved


def _drivers(joints: Mapping[str, UrdfJoint], mimic: Mimic | None) -> Iterator[str]:
    """Yield the joints of a chain of mimics, from the first driver to the last."""
    while mimic is not None:
        yield mimic.joint
        mimic = joints[mimic.joint].mimic


def drive_order(joints: Mapping[str, UrdfJoint], root: str) -> list[UrdfJoint]:
    """Return the joints in depth-first order, siblings by name, but every driving joint before its mimic joints.

    That is impossible if the driver is further out on the same branch, or if two branches drive each other.
    """
    order = _walk(joints, root)
    position = {joint.name: index for index, joint in enumerate(order)}
    for joint in order:
        mimic = joint.mimic
        if mimic is None:
            continue
        if position[mimic.joint] > position[joint.name]:
            raise Refused(
                f"joint {quoted(joint.name)} follows {quoted(mimic.joint)}, which comes after it in the tree; let "
                f"{quoted(mimic.joint)} follow {quoted(joint.name)} instead"
            )
        if not math.isfinite(mimic.multiplier + mimic.offset):
            raise Refused(
                f"joint {quoted(joint.name)} follows {quoted(mimic.joint)} with a multiplier or an offset "
                "too large for floating point"
            )
    return order


def share_limits(joints: list[UrdfJoint], notes: list[str]) -> list[UrdfJoint]:
    """Return the joints with every driving joint limited to values at which its mimic joints are inside their limits.

    Limits that were copied from joint to joint can leave at most one value to joints that can all move alone; for
    instance, a follower with the multiplier −1 has the limits [0, 1] of its driver. Then the driver's range does not
    change. If one of these joints cannot move alone and no value is left, the file is refused.
    """
    followers = _followers(joints)
    return [_sharing(joint, followers[joint.name], notes) if joint.name in followers else joint for joint in joints]


def _followers(joints: Iterable[UrdfJoint]) -> dict[str, list[UrdfJoint]]:
    """Return driving joint → its mimic joints, both in the order of `joints`."""
    found: dict[str, list[UrdfJoint]] = {}
    for joint in joints:
        if joint.mimic is not None:
            found.setdefault(joint.mimic.joint, []).append(joint)
    return found


def _sharing(driver: UrdfJoint, followers: Sequence[UrdfJoint], notes: list[str]) -> UrdfJoint:
    """Return the driving joint, limited to values at which its mimic joints are inside their limits."""
    turning = [follower for follower in followers if follower.coupling.multiplier != 0.0]
    lower, upper, velocity = driver.lower, driver.upper, driver.velocity
    confined: list[str] = []
    for follower in turning:
        low, high = (end + 0.0 for end in follower.coupling.driver_range(follower.lower, follower.upper))  # no −0
        before = lower, upper
        lower, upper = _larger(lower, low), -_larger(-upper, -high)
        velocity = -_larger(-velocity, -follower.velocity / abs(follower.coupling.multiplier))
        if (lower, upper) != before:
            confined.append(
                f"joint {quoted(driver.name)} confined to [{lower:.6g}, {upper:.6g}] by {quoted(follower.name)}"
            )
    collapsed = lower > upper or math.isclose(lower, upper, rel_tol=1e-9, abs_tol=1e-12)
    if not (collapsed and turning):
        notes += confined
        return replace(driver, lower=lower, upper=upper, velocity=velocity)
    names = ", ".join(quoted(follower.name) for follower in turning)
    if driver.lower < driver.upper and all(follower.lower < follower.upper for follower in turning):
        notes.append(
            f"joint {quoted(driver.name)} keeps its own range [{driver.lower:.6g}, {driver.upper:.6g}]: "
            f"the limits of {names} that follow it would leave it {'no' if lower > upper else 'a single'} value"
        )
        return replace(driver, velocity=velocity)
    if lower > upper:
        who, suits = (f"joint {names} follows", "both") if len(turning) == 1 else (f"joints {names} follow", "all")
        raise Refused(f"{who} {quoted(driver.name)}, and no value is inside the limits of {suits} of them")
    notes += confined
    return replace(driver, lower=lower, upper=upper, velocity=velocity)


def _larger(value: float, other: float) -> float:
    """Return the larger of two bounds; the first if they differ only by rounding."""
    return value if other <= value or math.isclose(value, other, rel_tol=1e-9, abs_tol=1e-12) else other


def _walk(joints: Mapping[str, UrdfJoint], root: str) -> list[UrdfJoint]:
    children: dict[str, list[UrdfJoint]] = {}
    for joint in sorted(joints.values(), key=lambda joint: joint.name):
        children.setdefault(joint.parent, []).append(joint)
    order = depth_first(children, root)
    if all(joint.mimic is None for joint in order):
        return order
    coupled = {name for joint in order if joint.mimic is not None for name in (joint.name, joint.mimic.joint)}
    # Joint → the coupled joints of its branch.
    branch: dict[str, set[str]] = {}
    for joint in reversed(order):
        own = {joint.name} & coupled
        branch[joint.name] = own.union(*(branch[child.name] for child in children.get(joint.child, [])))
    for siblings in children.values():
        if len(siblings) > 1:
            siblings[:] = _drivers_first(siblings, branch, joints)
    return depth_first(children, root)


def depth_first(children: Mapping[str, list[UrdfJoint]], root: str) -> list[UrdfJoint]:
    """Return the joints below a link in depth-first order, from link → the joints it carries."""
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
    """Return siblings sorted by name, but each after the siblings whose branches drive a joint of its branch."""
    holder = {name: sibling.name for sibling in siblings for name in branch[sibling.name]}
    before = {
        sibling.name: {
            holder[mimic.joint]
            for name in branch[sibling.name]
            if (mimic := joints[name].mimic) is not None and mimic.joint in holder
        }
        - {sibling.name}
        for sibling in siblings
    }
    waiting = {sibling.name: sibling for sibling in siblings}
    placed = list[UrdfJoint]()
    while waiting:
        ready = (name for name in waiting if before[name].isdisjoint(waiting))
        # Branches that drive each other have no order, which `drive_order` refuses.
        placed.append(waiting.pop(next(ready, next(iter(waiting)))))
    return placed
