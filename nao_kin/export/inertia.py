"""Poses and masses of a tree put together, and the nearest inertias to its own that a simulator takes."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection
from dataclasses import replace

import numpy as np

from nao_kin._core.arrays import Floats, Vector
from nao_kin.robot.urdf import Inertial, Origin, UrdfJoint, UrdfTree
from nao_kin.rotations import rpy_from_matrix

# --- Poses as a URDF writes them, put one after the other.

HERE = Origin()


def composed(first: Origin, second: Origin) -> Origin:
    """The pose `second` in the frame at `first`; exactly the other one where one of them is the identity."""
    if not any(first.xyz) and not any(first.rpy):
        return second
    if not any(second.xyz) and not any(second.rpy):
        return first
    T = first.matrix @ second.matrix
    if not any(second.rpy):
        return Origin(_vector(T[:3, 3]), first.rpy)
    if not any(first.rpy):
        return Origin(_vector(T[:3, 3]), second.rpy)
    return Origin(_vector(T[:3, 3]), rpy_of(T[:3, :3]))


def moved(joint: UrdfJoint, value: float) -> Origin:
    """The pose of a joint's frame at a value: turned about its axis, or moved along it."""
    T = joint.travel(value)
    return composed(joint.origin, Origin(_vector(T[:3, 3]), rpy_of(T[:3, :3])))


def hosts(tree: UrdfTree, gone: Collection[str]) -> dict[str, tuple[str, Origin]]:
    """Link → the link that it is part of where the links `gone` are parts of those that carry them, and its place."""
    found = {tree.root: (tree.root, HERE)}
    for joint in tree.joints:
        host, place = found[joint.parent]
        found[joint.child] = (host, composed(place, joint.origin)) if joint.child in gone else (joint.child, HERE)
    return found


def rpy_of(R: Floats) -> Vector:
    """Roll, pitch and yaw of a rotation, none of them −0."""
    return _vector(rpy_from_matrix(R))


def _vector(values: Floats) -> Vector:
    x, y, z = (values + 0.0).tolist()  # no −0
    return x, y, z


# --- How the mass of a body is spread, as a matrix that adds up.
#
# The pseudo-inertia of a body about a frame is P = ∫ x xᵀ dm with x = (position, 1): second moments, first moments and
# the mass in one symmetric 4×4 matrix. Those of two bodies held together add, and in another frame it is T P Tᵀ. A body
# of nowhere negative density has P ⪰ 0, and every such P belongs to one.
#
# Source: Wensing, Kim and Slotine, Linear Matrix Inequalities for Physically Consistent Inertial Parameter
# Identification, IEEE Robotics and Automation Letters 3(1), 2018.


def second_moments(inertia: Floats) -> Floats:
    """∫ x xᵀ dm of a tensor about the same point: Σ = ½ tr(I) 1 − I, shape (3, 3)."""
    return np.asarray(0.5 * np.trace(inertia) * np.eye(3) - inertia)


def tensor(moments: Floats) -> Floats:
    """The tensor of second moments about the same point: I = tr(Σ) 1 − Σ, shape (3, 3)."""
    return np.asarray(np.trace(moments) * np.eye(3) - moments)


def central_tensor(body: Inertial) -> Floats:
    """The tensor about the centre of mass along the axes of the link's frame, shape (3, 3) [kg m²]."""
    xx, xy, xz, yy, yz, zz = body.inertia
    found = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if any(body.origin.rpy):
        R = body.origin.matrix[:3, :3]
        found = R @ found @ R.T
    return found


def pseudo_inertia(body: Inertial, place: Origin | None = None) -> Floats:
    """P of a body, shape (4, 4): about its link's frame, or about the one in which that frame stands at `place`."""
    centre = np.array(body.origin.xyz)
    P = np.empty((4, 4))
    P[:3, :3] = second_moments(central_tensor(body)) + body.mass * np.outer(centre, centre)
    P[:3, 3] = P[3, :3] = body.mass * centre
    P[3, 3] = body.mass
    if place is None:
        return P
    T = place.matrix
    return np.asarray(T @ P @ T.T)


def body_of(P: Floats) -> Inertial:
    """The body of a pseudo-inertia, its tensor about the centre of mass along the axes of the frame."""
    mass = float(P[3, 3])
    centre = P[:3, 3] / mass if mass else np.zeros(3)
    return with_moments(mass, centre, P[:3, :3] - mass * np.outer(centre, centre))


def with_moments(mass: float, centre: Floats, moments: Floats) -> Inertial:
    """The body with these second moments about its centre of mass."""
    x, y, z = (np.asarray(centre) + 0.0).tolist()
    values = (tensor(moments) + 0.0)[np.triu_indices(3)].tolist()
    return Inertial(mass, Origin((x, y, z)), tuple(values))


# --- Inertias that a simulator takes.

# The least second moment of a body beside its largest: what is flatter is, to a simulator, flat.
_THINNEST = 1e-6
# What is within a micrometre of its centre of mass is nothing but rounding [m²].
_SMALLEST = 1e-12
# Of a link's mass, the massless links that it carries get this much together.
_GIVEN = 0.01
# What a massless link weighs where nothing that carries it has mass [kg].
_FROM_NOWHERE = 1e-3
_DENSITY_OF_WATER = 1000.0


def make_physical(tree: UrdfTree) -> tuple[UrdfTree, tuple[str, ...]]:
    """The tree with inertias that bodies can have, wherever the published ones are not.

    A body of nowhere negative density has second moments Σ = ½ tr(I) 1 − I ⪰ 0 about its centre of mass; that is
    A + B ≥ C for its principal moments. Three things are mended, and nothing else is touched:

    1. Σ with an eigenvalue below 10⁻⁶ of the largest: such eigenvalues are raised to that. Mass and centre of mass
       stay, and of all admissible tensors this one has the Σ nearest in the Frobenius norm (Higham 1988).
    2. Mass without any inertia, or with less than it has within a micrometre of its centre, 10⁻¹² m²: it becomes a
       ball of water, I = ⅖ m r².
    3. A link that moves and has no mass: it gets a ball on the axis of its joint, taken out of the link that carries
       it. A ball looks the same however it turns, so mass, centre of mass and inertia of the two together stay what
       they were in every configuration. Of massless links in a row each weighs as much as all it carries, and is
       spread so that with them it makes a ball again. A link gives away a hundredth of its mass in all. Where nothing
       that carries the link has mass, the mass is added.

    Returns:
        The tree, and one line for each link whose numbers have changed.

    Source: Wensing, Kim and Slotine 2018 (see above); Higham, Computing a Nearest Symmetric
    Positive Semidefinite Matrix, Linear Algebra and its Applications 103, 1988.

    Examples:
        >>> from nao_kin.export.inertia import make_physical
        >>> nao = nk.load_nao("v6")
        >>> tree, changes = make_physical(nao.tree)
        >>> print(changes[0])
        LHand_link: mass 0 → 0.000168 kg, a ball on the axis of LHand
        >>> abs(nk.RobotModel(tree).mass - nao.mass) < 1e-12
        True
    """
    bodies, changes = dict(tree.inertials), list[str]()
    _realize(tree, bodies, changes)
    _fill(tree, bodies, changes)
    _realize(tree, bodies, changes)  # what gave mass away may have been thin
    return replace(tree, inertials=bodies), tuple(changes)


def realizable(body: Inertial) -> bool:
    """Whether a body of nowhere negative density has this mass and this tensor, thin ones counted out."""
    values = np.linalg.eigvalsh(second_moments(central_tensor(body)))
    thick = values[0] >= (1.0 - 1e-9) * _THINNEST * values[2]
    return bool(body.mass > 0.0 and thick and values[2] > _SMALLEST * body.mass)


def _realize(tree: UrdfTree, bodies: dict[str, Inertial], changes: list[str]) -> None:
    """Mend every tensor that no body can have."""
    for link in tree.links:
        body = bodies.get(link)
        if body is None or body.mass == 0.0 or realizable(body):
            continue
        before = central_tensor(body)
        moments, axes = np.linalg.eigh(second_moments(before))
        if moments[2] <= _SMALLEST * body.mass:  # nothing of it can be kept
            what = "no" if moments[0] >= -_SMALLEST * body.mass else "a negative"
            bodies[link] = ball = _ball(body.mass, body.origin)
            changes.append(f"{link}: {what} inertia → a ball of water, {ball.inertia[0]:.3g} kg m²")
            continue
        # A hair above the bound, so that numbers rounded in a text stay above it.
        raised = np.maximum(moments, (1.0 + 1e-6) * _THINNEST * moments[2])
        bodies[link] = with_moments(body.mass, np.array(body.origin.xyz), (axes * raised) @ axes.T)
        changes.append(
            f"{link}: principal moments {_principal(before)} → {_principal(central_tensor(bodies[link]))} kg m²"
        )


def _fill(tree: UrdfTree, bodies: dict[str, Inertial], changes: list[str]) -> None:
    """Give a ball to every link that moves without mass, out of what carries it."""
    # Link → the innermost link that fixed joints hold it to, and its place there.
    groups = hosts(tree, {joint.child for joint in tree.joints if joint.kind == "fixed"})
    heavy = {group for group, _ in (groups[link] for link, body in bodies.items() if body.mass > 0.0)}
    light = {joint.child: joint for joint in tree.moving_joints if joint.child not in heavy}
    # Massless link → the massless links that it carries, outer ones first: a child comes after its parent in the tree.
    carried: dict[str, list[tuple[str, Origin]]] = {link: [] for link in light}
    donors: defaultdict[str, list[tuple[str, Origin]]] = defaultdict(list)
    for link, joint in light.items():
        group, place = groups[joint.parent]
        (carried if group in light else donors)[group].append((link, composed(place, joint.origin)))
    # Of a massless link with all that it carries, the mass in units: as much again as that of what it carries.
    sizes: dict[str, float] = {}
    for link in reversed(light):
        sizes[link] = max(1.0, 2.0 * sum(sizes[other] for other, _ in carried[link]))

    def whole(link: str, at: Origin, unit: float) -> Floats:
        """The ball that a massless link makes with all that it carries, as pseudo-inertia where it stands at `at`."""
        others = [whole(other, place, unit) for other, place in carried[link]]
        rest = np.asarray(sum(others, np.zeros((4, 4))))
        mass = sizes[link] * unit
        own = mass - rest[3, 3]
        # Second moments of the whole, such that what is left for the link alone is at least a ball of its own.
        needed = rest[:3, :3] + np.outer(rest[:3, 3], rest[:3, 3]) / own
        P = np.diag([float(np.linalg.eigvalsh(needed)[2]) + _ball_moment(own)] * 3 + [mass])
        bodies[link] = body_of(P - rest)
        what = "with all that it carries a ball" if others else "a ball"
        changes.append(f"{link}: mass 0 → {own:.3g} kg, {what} on the axis of {light[link].name}")
        return pseudo_inertia(body_of(P), at)

    masses = {link: bodies[link].mass for link in groups if link in bodies and bodies[link].mass > 0.0}
    for group, outermost in donors.items():
        members = [link for link in masses if groups[link][0] == group]
        giver = max(members, key=masses.__getitem__, default=None)
        total = sum(sizes[link] for link, _ in outermost)
        unit = _FROM_NOWHERE if giver is None else _GIVEN * masses[giver] / total
        wholes = {link: whole(link, at, unit) for link, at in outermost}
        if giver is None:
            changes.append(f"{group}: nothing that carries {', '.join(wholes)} has mass; {unit * total:.3g} kg added")
            continue
        P = pseudo_inertia(bodies[giver], groups[giver][1]) - sum(wholes.values())
        bodies[giver] = _seen_from(P, groups[giver][1])
        changes.append(
            f"{giver}: mass {masses[giver]:.6g} → {bodies[giver].mass:.6g} kg, the rest given to what it carries"
        )


def _seen_from(P: Floats, place: Origin) -> Inertial:
    """The body of a pseudo-inertia in the frame that stands at `place`."""
    if place == HERE:
        return body_of(P)
    inverse = np.linalg.inv(place.matrix)
    return body_of(inverse @ P @ inverse.T)


def _ball(mass: float, origin: Origin) -> Inertial:
    moment = 2.0 * _ball_moment(mass)
    return Inertial(mass, Origin(origin.xyz), (moment, 0.0, 0.0, moment, 0.0, moment))


def _ball_moment(mass: float) -> float:
    """Second moment along any direction of a ball of water about its centre, m r²/5."""
    radius = math.pow(3.0 * mass / (4.0 * math.pi * _DENSITY_OF_WATER), 1.0 / 3.0)
    return mass * radius**2 / 5.0


def _principal(inertia: Floats) -> str:
    return ", ".join(f"{value:.4g}" for value in np.linalg.eigvalsh(inertia))
