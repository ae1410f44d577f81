"""How the joints of a robot hang together: serial chains, closed loops, couplings."""

from __future__ import annotations

from dataclasses import dataclass

from nao_kin.robot.model import RobotModel, check_robot


@dataclass(frozen=True)
class SharedMotor:
    """A joint that has no motor of its own.

    Attributes:
        joint: the joint that follows.
        driver: the joint whose motor moves both.
        between_limbs: whether the two belong to different limbs, as NAO's two HipYawPitch joints do; the fingers of a
            hand that follow its motor do not.

    Examples:
        >>> motors = nk.robot.topology(nk.load_nao()).couplings
        >>> [(motor.joint, motor.driver) for motor in motors if motor.between_limbs]
        [('RHipYawPitch', 'LHipYawPitch')]
    """

    joint: str
    driver: str
    between_limbs: bool


@dataclass(frozen=True)
class Topology:
    """The structure of a robot.

    Attributes:
        degrees_of_freedom: joints that can be moved on their own; a floating base is not counted.
        moving_joints: all joints that move, followers included.
        closed_loops: independent loops of the graph of links and joints, joints − links + 1; 0 for a tree.
        chains: the serial chains, each from the root outwards: the longest runs of joints without a branch. Joints that
            follow another one of their own limb are left out: they belong to a hand or a mechanism, not to a chain.
        couplings: the joints that follow another one.

    Examples:
        >>> topology = nk.robot.topology(nk.load_nao())
        >>> topology.degrees_of_freedom, topology.moving_joints, topology.closed_loops
        (25, 42, 0)
        >>> topology.chains[0]
        ('HeadYaw', 'HeadPitch')
    """

    degrees_of_freedom: int
    moving_joints: int
    closed_loops: int
    chains: tuple[tuple[str, ...], ...]
    couplings: tuple[SharedMotor, ...]

    @property
    def couplings_between_limbs(self) -> tuple[SharedMotor, ...]:
        """The couplings between two limbs."""
        return tuple(coupling for coupling in self.couplings if coupling.between_limbs)


def topology(robot: RobotModel) -> Topology:
    """The structure of a robot, read off its Pinocchio model; the loops are counted in its URDF.

    Raises:
        BadArgument: no robot model.

    Examples:
        >>> nk.robot.topology(nk.load_nao()).degrees_of_freedom
        25
    """
    check_robot(robot)
    names, parents = _tree_of_joints(robot)
    limbs = {name: _ancestry(name, parents)[-1] for name in names}
    couplings = tuple(
        SharedMotor(name, robot.mimics[name].joint, limbs[name] != limbs[robot.mimics[name].joint])
        for name in names
        if name in robot.mimics
    )
    left_out = {coupling.joint for coupling in couplings if not coupling.between_limbs}
    return Topology(
        degrees_of_freedom=len(robot.joint_names),
        moving_joints=len(names),
        closed_loops=len(robot.tree.joints) - len(robot.tree.links) + 1,
        chains=_serial_chains([name for name in names if name not in left_out], parents),
        couplings=couplings,
    )


def _tree_of_joints(robot: RobotModel) -> tuple[list[str], dict[str, str | None]]:
    """The moving joints from the root outwards, and the joint that carries each; None for the base."""
    model = robot.model
    base = {0} | {joint.id for joint in list(model.joints)[1:] if joint.nq > 1}
    ids = [index for index in range(1, model.njoints) if index not in base]
    carrier = {index: int(model.parents[index]) for index in ids}
    names = {index: str(model.names[index]) for index in ids}
    return list(names.values()), {names[index]: names.get(carrier[index]) for index in ids}


def _ancestry(name: str, parents: dict[str, str | None]) -> list[str]:
    """The joint, then the joints that carry it, up to the one at the base."""
    path = [name]
    while (above := parents[path[-1]]) is not None:
        path.append(above)
    return path


def _serial_chains(names: list[str], parents: dict[str, str | None]) -> tuple[tuple[str, ...], ...]:
    kept = set(names)
    above = {name: next((a for a in _ancestry(name, parents)[1:] if a in kept), None) for name in names}
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
