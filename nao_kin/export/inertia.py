"""Composition of poses and masses of a tree, and the nearest inertias that a simulator accepts."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin.robot.urdf import Inertial, Origin, UrdfJoint, UrdfTree

# --- Composition of poses as a URDF writes them.

IDENTITY = Origin()


def composed(first: Origin, second: Origin) -> Origin:
    """Return the pose `second` in the frame at `first`; exactly one of them if the other is the identity."""
    if not any(first.xyz) and not any(first.rpy):
        return second
    if not any(second.xyz) and not any(second.rpy):
        return first
    T = first.matrix @ second.matrix
    found = Origin.of(T)
    if any(first.rpy) and any(second.rpy):
        return found
    return replace(found, rpy=first.rpy if any(first.rpy) else second.rpy)


def moved(joint: UrdfJoint, value: float) -> Origin:
    """Return the pose of a joint's frame at a value: turned about its axis, or moved along it."""
    return composed(joint.origin, Origin.of(joint.travel(value)))


def hosts(tree: UrdfTree, gone: Collection[str]) -> dict[str, tuple[str, Origin]]:
    """Return link → the link that contains it after the links `gone` are merged into their parents, and its pose."""
    found = {tree.root: (tree.root, IDENTITY)}
    for joint in tree.joints:
        host, place = found[joint.parent]
        found[joint.child] = (host, composed(place, joint.origin)) if joint.child in gone else (joint.child, IDENTITY)
    return found


# --- The mass distribution of a body as a matrix that is additive.
#
# The pseudo-inertia of a body about a frame is P = ∫ x xᵀ dm with x = (position, 1): second moments, first moments and
# the mass in one symmetric 4×4 matrix. Those of two bodies held together add up; in another frame P becomes T P Tᵀ. A
# body without negative density has P ⪰ 0, and every P ⪰ 0 belongs to such a body.
#
# Source: Wensing, Kim and Slotine, Linear Matrix Inequalities for Physically Consistent Inertial Parameter
# Identification, IEEE Robotics and Automation Letters 3(1), 2018.


def second_moments(inertia: Floats) -> Floats:
    """Return ∫ x xᵀ dm of a tensor about the same point: Σ = ½ tr(I) 1 − I, shape (3, 3)."""
    return np.asarray(0.5 * np.trace(inertia) * np.eye(3) - inertia)


def tensor(moments: Floats) -> Floats:
    """Return the tensor of second moments about the same point: I = tr(Σ) 1 − Σ, shape (3, 3)."""
    return np.asarray(np.trace(moments) * np.eye(3) - moments)


def central_tensor(body: Inertial) -> Floats:
    """Return the tensor about the centre of mass along the axes of the link's frame, shape (3, 3) [kg m²]."""
    xx, xy, xz, yy, yz, zz = body.inertia
    found = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if any(body.origin.rpy):
        R = body.origin.matrix[:3, :3]
        found = R @ found @ R.T
    return found


def pseudo_inertia(body: Inertial, place: Origin) -> Floats:
    """Return P of a body, shape (4, 4), about a frame in which its link's frame is at `place`."""
    centre = np.array(body.origin.xyz)
    P = np.empty((4, 4))
    P[:3, :3] = second_moments(central_tensor(body)) + body.mass * np.outer(centre, centre)
    P[:3, 3] = P[3, :3] = body.mass * centre
    P[3, 3] = body.mass
    T = place.matrix
    return np.asarray(T @ P @ T.T)


def body_of(P: Floats) -> Inertial:
    """Return the body of a pseudo-inertia, its tensor about the centre of mass along the axes of the frame."""
    mass = float(P[3, 3])
    centre = P[:3, 3] / mass if mass else np.zeros(3)
    return with_moments(mass, centre, P[:3, :3] - mass * np.outer(centre, centre))


def with_moments(mass: float, centre: Floats, moments: Floats) -> Inertial:
    """Return the body with these second moments about its centre of mass."""
    x, y, z = (np.asarray(centre) + 0.0).tolist()
    values = (tensor(moments) + 0.0)[np.triu_indices(3)].tolist()
    return Inertial(mass, Origin((x, y, z)), tuple(values))


# --- Inertias that a simulator accepts.

# The least ratio of a body's second moments; simulators treat thinner bodies as flat.
_THINNEST = 1e-6
# Second moments per mass below this are rounding [m²]: the mass would be within a micrometre of its centre.
_SMALLEST = 1e-12
# The share of a link's mass that all massless links on it get together.
_GIVEN_SHARE = 0.01
# The mass of a massless link if no link that carries it has mass [kg].
_ADDED_MASS = 1e-3
_DENSITY_OF_WATER = 1000.0


def make_physical(tree: UrdfTree) -> tuple[UrdfTree, tuple[str, ...]]:
    """Return the tree with physically possible inertias in place of impossible published ones, and the changes.

    A body without negative density has second moments Σ = ½ tr(I) 1 − I ⪰ 0 about its centre of mass, that is, A + B ≥
    C for its principal moments. Only three cases are corrected:

    1. Σ with an eigenvalue below 10⁻⁶ of the largest: such eigenvalues are raised to that value. Mass and centre of
       mass do not change, and among all admissible tensors this one has the nearest Σ in the Frobenius norm.
    2. A mass without inertia, or with less inertia than if all of it were within a micrometre of its centre (10⁻¹² m²
       times the mass): it becomes a ball of water, I = ⅖ m r².
    3. A moving link without mass: it gets a ball on the axis of its joint, whose mass is taken from the link that
       carries it. The inertia of a ball does not depend on its rotation, so mass, centre of mass and inertia of the two
       together do not change in any configuration. In a chain of massless links, each weighs as much as all that it
       carries, and is a ball together with them. If no link that carries the link has mass, the mass is added.

    Source: Wensing, Kim and Slotine 2018 (above); Higham, Computing a Nearest Symmetric Positive Semidefinite Matrix,
    Linear Algebra and its Applications 103, 1988.
    """
    bodies, changes = dict(tree.inertials), list[str]()
    _realize(tree, bodies, changes)
    _fill(tree, bodies, changes)
    _realize(tree, bodies, changes)  # links that gave mass away may have become too thin
    return replace(tree, inertials=bodies), tuple(changes)


def realizable(body: Inertial) -> bool:
    """Return whether a body without negative density can have this mass and this tensor, and is not too thin."""
    values = np.linalg.eigvalsh(second_moments(central_tensor(body)))
    thick = values[0] >= (1.0 - 1e-9) * _THINNEST * values[2]
    return bool(body.mass > 0.0 and thick and values[2] > _SMALLEST * body.mass)


def _realize(tree: UrdfTree, bodies: dict[str, Inertial], changes: list[str]) -> None:
    """Correct every impossible tensor."""
    for link in tree.links:
        body = bodies.get(link)
        if body is None or body.mass == 0.0 or realizable(body):
            continue
        before = central_tensor(body)
        moments, axes = np.linalg.eigh(second_moments(before))
        if moments[2] <= _SMALLEST * body.mass:  # no part of the tensor is usable
            what = "no" if moments[0] >= -_SMALLEST * body.mass else "a negative"
            bodies[link] = ball = _ball(body.mass, body.origin)
            changes.append(f"{link}: {what} inertia → a ball of water, {ball.inertia[0]:.3g} kg m²")
            continue
        # Slightly above the bound, so that numbers rounded in a text stay above it.
        raised = np.maximum(moments, (1.0 + 1e-6) * _THINNEST * moments[2])
        bodies[link] = with_moments(body.mass, np.array(body.origin.xyz), (axes * raised) @ axes.T)
        changes.append(
            f"{link}: principal moments {_principal(before)} → {_principal(central_tensor(bodies[link]))} kg m²"
        )


def _fill(tree: UrdfTree, bodies: dict[str, Inertial], changes: list[str]) -> None:
    """Give a ball to every massless moving link, from the mass of the link that carries it."""
    # Link → the innermost link that fixed joints connect it to, and its pose there.
    groups = hosts(tree, {joint.child for joint in tree.joints if joint.kind == "fixed"})
    heavy = {group for group, _ in (groups[link] for link, body in bodies.items() if body.mass > 0.0)}
    light = {joint.child: joint for joint in tree.moving_joints if joint.child not in heavy}
    # Massless link → the massless links that it carries, outer ones first: a child comes after its parent in the tree.
    carried: dict[str, list[tuple[str, Origin]]] = {link: [] for link in light}
    donors: defaultdict[str, list[tuple[str, Origin]]] = defaultdict(list)
    for link, joint in light.items():
        group, place = groups[joint.parent]
        (carried if group in light else donors)[group].append((link, composed(place, joint.origin)))
    # Massless link → mass of it and all that it carries, in units: twice the mass of all that it carries, at least 1.
    sizes: dict[str, float] = {}
    for link in reversed(light):
        sizes[link] = max(1.0, 2.0 * sum(sizes[other] for other, _ in carried[link]))

    def whole(link: str, at: Origin, unit: float) -> Floats:
        """Return the pseudo-inertia, at pose `at`, of the ball of a massless link and all that it carries."""
        others = [whole(other, place, unit) for other, place in carried[link]]
        rest = np.asarray(sum(others, np.zeros((4, 4))))
        mass = sizes[link] * unit
        own = mass - rest[3, 3]
        # Make the second moments of the whole so large that those of the link alone are at least those of a ball.
        needed = rest[:3, :3] + np.outer(rest[:3, 3], rest[:3, 3]) / own
        P = np.diag([float(np.linalg.eigvalsh(needed)[2]) + _ball_moment(own)] * 3 + [mass])
        bodies[link] = body_of(P - rest)
        what = "a ball with all that it carries" if others else "a ball"
        changes.append(f"{link}: mass 0 → {own:.3g} kg, {what} on the axis of {light[link].name}")
        return pseudo_inertia(body_of(P), at)

    masses = {link: bodies[link].mass for link in groups if link in bodies and bodies[link].mass > 0.0}
    for group, outermost in donors.items():
        members = [link for link in masses if groups[link][0] == group]
        giver = max(members, key=masses.__getitem__, default=None)
        total = sum(sizes[link] for link, _ in outermost)
        unit = _ADDED_MASS if giver is None else _GIVEN_SHARE * masses[giver] / total
        wholes = {link: whole(link, at, unit) for link, at in outermost}
        if giver is None:
            changes.append(f"{group}: no link that carries {', '.join(wholes)} has mass; {unit * total:.3g} kg added")
            continue
        P = pseudo_inertia(bodies[giver], groups[giver][1]) - sum(wholes.values())
        inverse = np.linalg.inv(groups[giver][1].matrix)
        bodies[giver] = body_of(inverse @ P @ inverse.T)
        changes.append(
            f"{giver}: mass {masses[giver]:.6g} → {bodies[giver].mass:.6g} kg, the rest given to links on it"
        )


def _ball(mass: float, origin: Origin) -> Inertial:
    moment = 2.0 * _ball_moment(mass)
    return Inertial(mass, Origin(origin.xyz), (moment, 0.0, 0.0, moment, 0.0, moment))


def _ball_moment(mass: float) -> float:
    """Return the second moment along any direction of a ball of water about its centre, m r²/5."""
    radius = math.pow(3.0 * mass / (4.0 * math.pi * _DENSITY_OF_WATER), 1.0 / 3.0)
    return mass * radius**2 / 5.0


def _principal(inertia: Floats) -> str:
    return ", ".join(f"{value:.4g}" for value in np.linalg.eigvalsh(inertia))
