"""How the joints of a robot relate: chains between two frames, branches and couplings, mirror images."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from nao_kin._core.arrays import COUPLING_TOLERANCE, Floats, choice
from nao_kin._core.sides import other_sides
from nao_kin._core.text import one_line_repr
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.robot.kinematic_robot import KinematicRobot
from nao_kin.robot.semantics import Mimic


@one_line_repr
@dataclass(frozen=True, eq=False)
class SerialChain:
    """The n joints that lead from a base to a frame; a floating base counts as fixed.

    Attributes:
        placements: rotations and translations, shape (n + 1, 3, 4) [m]. Placement k leads to a frame whose z axis is
            the axis of joint k; placement n leads from joint n − 1 to the frame.
        slides: which joints slide along their axis instead of turning about it, n of them.
        drivers: the coordinate that moves each joint, with multiplier and offset; negated where the chain passes a
            joint from child to parent.
    """

    placements: Floats
    slides: tuple[bool, ...]
    drivers: tuple[Mimic, ...]

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Joints whose coordinates move the frame, from the base outwards, without drivers whose multiplier is 0."""
        return tuple(dict.fromkeys(driver.joint for driver in self.drivers if driver.multiplier != 0.0))

    def length(self, robot: KinematicRobot) -> float:
        """Return the length of the chain stretched to a straight line [m]; infinite with an unlimited sliding joint.

        Examples:
            >>> nao = nk.load_nao()
            >>> round(nk.robot.serial_chain(nao, "Torso", "LArm").length(nao), 3)
            0.221
        """
        total = float(np.linalg.norm(self.placements[1:, :, 3], axis=-1).sum())
        for slides, driver in zip(self.slides, self.drivers, strict=True):
            if slides:
                place = robot.joint_names.index(driver.joint)
                total += max(map(abs, driver.range(float(robot.lower[place]), float(robot.upper[place]))))
        return total


def serial_chain(robot: KinematicRobot, base: str, frame: str) -> SerialChain:
    """Return the chain of joints from one frame to another, such as from the left foot to the right hand.

    Examples:
        >>> chain = nk.robot.serial_chain(nk.load_nao(), "LLeg", "RLeg")
        >>> len(chain.drivers), chain.coordinates[:2], chain.drivers[6]
        (12, ('LAnkleRoll', 'LAnklePitch'), Mimic(joint='LHipYawPitch', multiplier=1.0, offset=0.0))
    """
    table = robot.joints
    (first, T_last_base), (last, T_last_frame) = robot.frame_placement(base), robot.frame_placement(frame)
    up, down = table.paths(first, last)
    placements, fixed, drivers = [], np.linalg.inv(T_last_base), list[Mimic]()
    for k, sign in (*((k, -1.0) for k in reversed(up)), *((k, 1.0) for k in down)):
        T_parent_joint, turn = table.placements[k], _z_along(table.axes[k])
        placements.append(fixed @ turn if sign < 0.0 else fixed @ T_parent_joint @ turn)
        fixed = turn.T @ np.linalg.inv(T_parent_joint) if sign < 0.0 else turn.T
        motor = robot.joint_names[table.coordinates[k] - robot.nq_base]
        drivers.append(Mimic(motor, sign * float(table.multipliers[k]), sign * float(table.offsets[k])))
    placements.append(fixed @ T_last_frame)
    slides = tuple(table.slides[[*reversed(up), *down]].tolist())
    return SerialChain(np.ascontiguousarray(np.array(placements)[:, :3]), slides, tuple(drivers))


def _z_along(z: Floats) -> Floats:
    """Return a rotation (4, 4) that takes z to an axis, without rounding if the axis is x, y or z."""
    x = np.zeros(3)
    x[(int(np.argmax(np.abs(z))) + 1) % 3] = 1.0
    x -= (x @ z) * z
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    return T


# --- The structure of a robot: serial chains, closed loops, couplings.


@one_line_repr
@dataclass(frozen=True)
class Topology:
    """The structure of a robot.

    Attributes:
        degrees_of_freedom: joints that move independently, without a floating base.
        moving_joints: all joints that move, mimic joints included.
        closed_loops: independent loops of the graph of links and joints, joints − links + 1; 0 for a tree.
        chains: the serial chains, each from the root outwards: the longest runs of joints without a branch. Joints that
            follow a joint of the same limb are left out: they belong to a hand or a mechanism.
        couplings: joints that follow another one, and how, from the root outwards.
        couplings_between_limbs: the couplings between different limbs, such as NAO's right HipYawPitch; fingers that
            follow the motor of their hand are not included.
    """

    degrees_of_freedom: int
    moving_joints: int
    closed_loops: int
    chains: tuple[tuple[str, ...], ...]
    couplings: Mapping[str, Mimic]
    couplings_between_limbs: Mapping[str, Mimic]


def topology(robot: KinematicRobot) -> Topology:
    """Return the structure of a robot: its degrees of freedom, serial chains, closed loops and couplings.

    Examples:
        >>> topology = nk.robot.topology(nk.load_nao())
        >>> topology.degrees_of_freedom, topology.moving_joints, topology.closed_loops
        (25, 42, 0)
        >>> topology.chains[0]
        ('HeadYaw', 'HeadPitch')
        >>> {joint: mimic.joint for joint, mimic in topology.couplings_between_limbs.items()}
        {'RHipYawPitch': 'LHipYawPitch'}
    """
    table = robot.joints
    # Joint → the joints from the root to this one, which is the last.
    paths = {name: [table.names[above] for above in table.path(k)] for k, name in enumerate(table.names)}
    couplings = {name: robot.mimics[name] for name in paths if name in robot.mimics}
    between_limbs = {name: mimic for name, mimic in couplings.items() if paths[name][0] != paths[mimic.joint][0]}
    left_out = couplings.keys() - between_limbs
    return Topology(
        degrees_of_freedom=len(robot.joint_names),
        moving_joints=len(paths),
        closed_loops=len(robot.tree.joints) - len(robot.tree.links) + 1,
        chains=_serial_chains([name for name in paths if name not in left_out], paths),
        couplings=couplings,
        couplings_between_limbs=between_limbs,
    )


def _serial_chains(names: list[str], paths: Mapping[str, Sequence[str]]) -> tuple[tuple[str, ...], ...]:
    known = set(names)
    above = {name: next((joint for joint in paths[name][-2::-1] if joint in known), None) for name in names}
    carried: dict[str | None, list[str]] = {}
    for name in names:
        carried.setdefault(above[name], []).append(name)
    chains = []
    for first in names:
        if above[first] is not None and len(carried[above[first]]) == 1:
            continue
        chain = [first]
        while len(carried.get(chain[-1], [])) == 1:
            chain.append(carried[chain[-1]][0])
        chains.append(tuple(chain))
    return tuple(chains)


# --- Mirror images: which joint is on the other side, and how it follows.

# How far a joint may be from the mirror image of the joint on the other side, as a share of the robot's size, and by
# how much the directions of their axes may differ [rad]: more than calibration finds.
_APART = 0.05
_MIRROR = np.array([1.0, -1.0, 1.0])
# Signs of a floating base: its position, and its quaternion (x, y, z, w), whose vector turns as an axis does.
_BASE = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0])


class _Image(NamedTuple):
    """How a joint of the mirror image follows the joint on the other side; how far it is from that joint's image."""

    of: Mimic
    metres: float = 0.0
    radians: float = 0.0
    fits: bool = True


def mirrored(robot: KinematicRobot, q: Floats) -> Floats:
    """Return the mirror images of configurations."""
    images = _images(robot)
    for name in robot.joint_names:
        _check(robot, name, images)
    return _mirrored(robot, q, images)


def mirror_image(robot: KinematicRobot, name: str) -> Mimic:
    """Return how a joint of the mirror image follows the joint on the other side; both must fit to their motors."""
    choice(name, (*robot.joint_names, *robot.mimics), "joint")
    images = _images(robot)
    _check(robot, name, images)
    return images[name].of


def _mirrored(robot: KinematicRobot, q: Floats, images: dict[str, _Image]) -> Floats:
    image = np.empty_like(q)
    image[..., : robot.nq_base] = _BASE[: robot.nq_base] * q[..., : robot.nq_base]
    column = {name: robot.nq_base + index for index, name in enumerate(robot.joint_names)}
    for name in robot.joint_names:
        of = _of_motor(robot, images[name].of)
        image[..., column[name]] = of.value(q[..., column[of.joint]])
    return image + 0.0  # takes the sign off a negative zero


def _of_motor(robot: KinematicRobot, of: Mimic) -> Mimic:
    """Return how the value follows the driving joint, if the joint that it follows has one."""
    return of.through(robot.mimics[of.joint]) if of.joint in robot.mimics else of


def _images(robot: KinematicRobot) -> dict[str, _Image]:
    """Pair the joints by names and by their places at zero; compare a random configuration with its mirror image."""
    table = robot.joints
    names, slides = table.names, table.slides
    if not names:
        return {}
    rows = {name: row for row, name in enumerate(names)}
    axes = table.axes / np.linalg.norm(table.axes, axis=-1, keepdims=True)
    signs = np.where(slides[:, None], _MIRROR, -_MIRROR)  # what turns one way turns the other way in the mirror

    def placed(q: Floats) -> tuple[Floats, Floats]:
        T = robot.fk(q, table.links, reference=robot.tree.root)
        return T[:, :3, 3], np.einsum("nij,nj->ni", T[:, :3, :3], axes)

    q = robot.random(0)
    p, a = placed(np.where(np.arange(robot.nq) < robot.nq_base, q, 0.0))
    size = np.linalg.norm(p, axis=-1).max()
    others, images = [], {}
    for row, name in enumerate(names):
        candidates = [rows[other] for other in other_sides(name) if other in rows] or [row]
        others.append(min(candidates, key=lambda other: np.linalg.norm(p[other] - _MIRROR * p[row])))
        opposite = robot.unit(name) != "1" and signs[row] * a[others[row]] @ a[row] < 0.0
        images[name] = _Image(Mimic(names[others[row]], -1.0 if opposite else 1.0))
    (p_image, a_image), (p, a) = placed(_mirrored(robot, q, images)), placed(q)
    away = p_image - (_MIRROR * p)[others]
    # The origin of a joint that turns is anywhere on its axis, but a joint that is its own image must not lie aside.
    free = ~slides & (others != np.arange(len(names)))
    away -= (free * np.sum(away * a_image, axis=-1))[:, None] * a_image
    multipliers = np.array([[image.of.multiplier] for image in images.values()])
    metres = np.linalg.norm(away, axis=-1)
    radians = np.linalg.norm(multipliers * a_image - (signs * a)[others], axis=-1)
    ratios = np.array([robot.unit(name) == "1" for name in names])
    fits = ratios | (metres <= _APART * size + 1e-9) & (radians <= _APART)
    found = zip(images.items(), metres.tolist(), radians.tolist(), fits.tolist(), strict=True)
    return {name: _Image(image.of, *apart) for (name, image), *apart in found}


def _check(robot: KinematicRobot, name: str, images: dict[str, _Image]) -> None:
    """Raise an error if a joint and the one on the other side are no mirror images, or do not follow as those."""
    image = images[name]
    other = image.of.joint
    if robot.unit(name) != robot.unit(other):
        raise BadArgument(f"{name} and {other} are not mirror images: one is in {robot.unit(name)}, the other is not")
    for one in (name, other):
        if one in robot.mimics:
            mimic = robot.mimics[one]
            found = _of_motor(robot, images[one].of)
            wanted = mimic.through(_of_motor(robot, images[mimic.joint].of))
            differ = max(abs(found.multiplier - wanted.multiplier), abs(found.offset - wanted.offset))
            if found.joint != wanted.joint or differ > COUPLING_TOLERANCE:
                how = f"{one} = {mimic.multiplier:g} {mimic.joint} {mimic.offset:+g}"
                raise BadArgument(f"no mirror image: {how} of the mimic joint would not hold in it")
    if image.fits:
        return
    apart = f"{image.metres:.3g} m and {image.radians:.3g} rad apart in a random configuration"
    if other != name:
        raise BadArgument(f"{name} and {other} are not mirror images at y = 0: {apart}")
    if sides := other_sides(name):
        hint = f"the other side of {name}, which is not its own mirror image at y = 0: {apart}"
        raise UnknownName("joint", sides[0], tuple(images), hint)
    raise BadArgument(f"{name} is not its own mirror image at y = 0, {apart}, and its name shows no side")
