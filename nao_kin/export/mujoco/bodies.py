"""A tree of links as MuJoCo's bodies: one body for each moving link and all links fixed to it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from nao_kin._core.arrays import Floats
from nao_kin.export.inertia import central_tensor
from nao_kin.joints import JointGroups
from nao_kin.robot.urdf import Origin, UrdfJoint, UrdfTree
from nao_kin.rotations import quat_from_matrix

# --- Poses as MuJoCo writes them.


def pose(origin: Origin) -> pin.SE3:
    """Return the pose of a URDF's origin, to the last bit as in the robot's model."""
    return pin.SE3(pin.rpy.rpyToMatrix(*origin.rpy), np.array(origin.xyz))


def pos_quat(T: pin.SE3) -> dict[str, list[float]]:
    """Return position [m] and quaternion, scalar first."""
    return {"pos": (T.translation + 0.0).tolist(), "quat": (quat_from_matrix(T.rotation) + 0.0).tolist()}


# --- The bodies.

_BALL = (1e-3, 6.2e-3)  # mass [kg] and radius [m] of a ball of water


@dataclass(frozen=True, eq=False)
class BodyJoint:
    """A joint of a body."""

    name: str  # for a ball, the names of its parts joined by "+"
    kind: str  # "hinge", "slide" or "ball"
    axes: Floats  # in the body's frame with all joints at zero, shape (n, 3): one, or the three of a ball
    rows: tuple[UrdfJoint, ...]  # the joints of the tree for each axis


@dataclass(eq=False)
class Body:
    """A body."""

    name: str  # the name of a link in its frame
    parent: int  # index of the body that carries it, −1 for the root
    T_parent: pin.SE3  # its pose in the parent with all joints at zero
    joints: tuple[BodyJoint, ...]  # the joints between the two, the outermost last
    inertia: pin.Inertia = field(default_factory=pin.Inertia.Zero)  # of all its links, in its frame
    links: dict[str, pin.SE3] = field(default_factory=dict)  # link → its pose in the body


@dataclass(frozen=True, eq=False)
class Bodies:
    """The bodies of a robot."""

    bodies: tuple[Body, ...]  # parents first, beginning with the root
    between: frozenset[str]  # links between merged axes, fixed to the body before as with all joints at zero

    def place(self, link: str) -> tuple[Body, pin.SE3]:
        """Return the body of a link, and the link's pose in it."""
        return next((body, body.links[link]) for body in self.bodies if link in body.links)

    def joints(self) -> Iterator[BodyJoint]:
        """Yield all joints, parents first."""
        for body in self.bodies:
            yield from body.joints


def bodies_of(tree: UrdfTree, groups: JointGroups | None = None) -> Bodies:
    """Return the bodies of a tree, with the joints of `groups` merged.

    A universal joint becomes two hinges of one body, a spherical joint a ball, or three hinges of one body if one of
    its axes is coupled, because MuJoCo couples only joints of one coordinate.
    """
    runs = [group.joints for group in groups or () if len(group.axes) > 1]
    before_last = {name for run in runs for name in run[:-1]}
    run_of = {run[-1]: run for run in runs}
    rows = {joint.name: joint for joint in tree.joints}
    coupled = {name for joint, mimic in tree.mimics.items() for name in (joint, mimic.joint)}
    bodies = [Body(tree.root, -1, pin.SE3.Identity(), ())]
    places = {tree.root: (0, pin.SE3.Identity())}
    axes: dict[str, Floats] = {}  # of merged joints, in the frame of the body before them
    between: set[str] = set()
    for row in tree.joints:
        index, T_link = places[row.parent]
        T_joint = T_link * pose(row.origin)
        if row.kind == "fixed" or row.name in before_last:
            places[row.child] = index, T_joint
            if row.kind != "fixed":
                axes[row.name] = T_joint.rotation @ np.array(row.axis)
            if row.parent in between or row.name in before_last:
                between.add(row.child)
            continue
        run = run_of.get(row.name, (row.name,))
        axes[row.name] = T_joint.rotation @ np.array(row.axis)
        parts = [(row, np.array(row.axis))]
        if len(run) > 1:
            turned = [T_joint.rotation.T @ axes[name] for name in run]
            # Avoids the rounding of a rotation and its inverse.
            parts = [
                (rows[name], np.where(np.abs(e) < 1e-15, 0.0, e) + 0.0) for name, e in zip(run, turned, strict=True)
            ]
        elif row.parent in between:
            between.add(row.child)
        bodies.append(Body(row.child, index, T_joint, _joints(parts, coupled)))
        places[row.child] = len(bodies) - 1, pin.SE3.Identity()
    for link in tree.links:
        index, T_body = places[link]
        bodies[index].links[link] = T_body
        held = tree.inertials.get(link)
        if held is not None:
            inertia = pin.Inertia.Zero()
            inertia.mass, inertia.lever, inertia.inertia = held.mass, np.array(held.origin.xyz), central_tensor(held)
            bodies[index].inertia += T_body.act(inertia)
    bodies[0].name = _root_name(tree, bodies[0])
    return Bodies(tuple(bodies), frozenset(between))


def give_the_root_mass(bodies: Bodies) -> tuple[str, ...]:
    """Give a freely moving root without mass a ball of water of one gram; return a line if this was done."""
    root = bodies.bodies[0]
    if root.inertia.mass > 0.0:
        return ()
    root.inertia += pin.Inertia.FromSphere(*_BALL)
    return (f"{root.name}: mass 0 → {_BALL[0]:g} kg, because it moves freely",)


def _joints(parts: Sequence[tuple[UrdfJoint, Floats]], coupled: set[str]) -> tuple[BodyJoint, ...]:
    rows = tuple(row for row, _ in parts)
    if len(rows) == 3 and not coupled.intersection(row.name for row in rows):
        return (BodyJoint("+".join(row.name for row in rows), "ball", np.stack([axis for _, axis in parts]), rows),)
    return tuple(
        BodyJoint(row.name, "slide" if row.kind == "prismatic" else "hinge", axis[None], (row,)) for row, axis in parts
    )


def _root_name(tree: UrdfTree, root: Body) -> str:
    """Return the first link with mass at the root's frame; not "world", which is MuJoCo's own body."""
    identity = pin.SE3.Identity()
    heavy = (link for link, T in root.links.items() if link in tree.inertials and identity == T)
    name = next(heavy, tree.root)
    return name if name != "world" else "world_link"
