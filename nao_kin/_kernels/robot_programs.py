"""The programs of a robot: poses, Jacobians, centres of mass, velocities and accelerations.

Programs have no names and no units; a frame is given by its joint and its pose relative to the joint. Jacobians and
twists are (linear; angular), and expressed "mixed" (at the frame's origin in the root's axes), in the "frame" (at its
origin in its own axes) or in the "root" (at the root's origin in the root's axes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from nao_kin._core.arrays import Floats
from nao_kin._kernels.program import Builder, Columns, Component, FrameRegisters, Program, Register, components

# --- The joints of a robot as numbers, from which programs are built.

ROOT = -1


@dataclass(frozen=True)
class TreeJoint:
    """One joint; its value is ratio · q[coordinate] + offset."""

    kind: str  # "revolute", "prismatic" or "free", for a floating base
    parent: int  # index of the parent joint; −1 for the root
    R: Floats = field(repr=False)  # orientation of its frame at zero in the parent's
    t: Floats = field(repr=False)  # position of its frame at zero in the parent's [m]
    axis: tuple[float, float, float]  # unit vector
    coordinate: int  # index in q, of the first of seven for a floating base
    velocity: int  # index in the velocity, of the first of six for a floating base
    ratio: float = 1.0  # 1 except for mimic joints
    offset: float = 0.0
    mass: float = 0.0  # of its body [kg]
    moment: tuple[float, float, float] = (0.0, 0.0, 0.0)  # mass · centre of mass of its body in its frame [kg m]

    @cached_property
    def principal(self) -> tuple[int, float]:
        """The coordinate axis nearest to the joint's axis, and the sign of the joint's axis along it."""
        k = int(np.argmax(np.abs(self.axis)))
        return k, (1.0 if self.axis[k] > 0.0 else -1.0)

    @cached_property
    def alignment(self) -> Floats:
        """The shortest rotation of the coordinate axis onto the joint's axis, or its opposite: R e = ±axis."""
        k, sign = self.principal
        e, axis = np.eye(3)[k], sign * np.asarray(self.axis)
        v = np.cross(e, axis)
        cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
        return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + e @ axis))

    @cached_property
    def is_straight(self) -> bool:
        """Whether its frame at zero has the axes of the parent's."""
        return bool((np.eye(3) == self.R).all())

    @property
    def aligned(self) -> bool:
        """Whether the joint's axis is a coordinate axis."""
        return not any(self.axis[k] for k in range(3) if k != self.principal[0])


@dataclass(frozen=True)
class JointTree:
    """All joints of a robot, every parent before its children."""

    nq: int
    nv: int
    joints: tuple[TreeJoint, ...] = field(repr=False)
    mass: float = 0.0  # of the root's body [kg]
    moment: tuple[float, float, float] = (0.0, 0.0, 0.0)  # mass · centre of mass of the root's body [kg m]

    @cached_property
    def total_mass(self) -> float:
        """Mass of the whole robot [kg]."""
        return self.mass + sum(joint.mass for joint in self.joints)

    @cached_property
    def children(self) -> dict[int, list[int]]:
        """The child joints of each joint and of the root."""
        children: dict[int, list[int]] = {k: [] for k in range(ROOT, len(self.joints))}
        for k, joint in enumerate(self.joints):
            children[joint.parent].append(k)
        return children

    @cached_property
    def carried_masses(self) -> tuple[float, ...]:
        """Mass that each joint moves [kg]."""
        masses = [joint.mass for joint in self.joints]
        for k in range(len(masses) - 1, -1, -1):
            if self.joints[k].parent != ROOT:
                masses[self.joints[k].parent] += masses[k]
        return tuple(masses)

    def chain(self, joint: int) -> list[int]:
        """Return the joints from the root to this one."""
        chain = []
        while joint != ROOT:
            chain.append(joint)
            joint = self.joints[joint].parent
        return chain[::-1]

    def common_joint(self, joints: Sequence[int]) -> int:
        """Return the last joint that is in the chains of all of these; −1 for the root."""
        common = ROOT
        for places in zip(*(self.chain(joint) for joint in joints), strict=False):
            if len(set(places)) > 1:
                break
            common = places[0]
        return common


@dataclass(frozen=True)
class TreeFrame:
    """A frame fixed to a joint: the joint, and the pose of the frame relative to it."""

    joint: int
    R: Floats = field(repr=False)
    t: Floats = field(repr=False)


# --- Frames of a robot's joints in the registers of a program.


class PosedTree:
    """Frames of joints in registers, made on demand; `origin` is the joint whose frame is the identity."""

    def __init__(self, builder: Builder, tree: JointTree, origin: int = ROOT) -> None:
        self.builder, self.tree = builder, tree
        self._frames: dict[int, FrameRegisters] = {origin: builder.root}
        # The axis of each joint in the root's axes.
        self._axes: dict[int, Register] = {}

    def frame(self, joint: int) -> FrameRegisters:
        """Return the frame of a joint."""
        for place in self.tree.chain(joint):
            if place not in self._frames:
                parent = self.tree.joints[place].parent
                if parent in self._frames:
                    self._frames[place] = self._moved(place, self._frames[parent])
        return self._frames[joint]

    def placed(self, frame: TreeFrame) -> FrameRegisters:
        """Return a frame fixed to a joint."""
        return self.builder.placed(self.frame(frame.joint), frame.R, frame.t)

    def axis(self, joint: int) -> tuple[Register, float]:
        """Return the direction of a joint's axis, and the speed along or about it per rate of its coordinate."""
        self.frame(joint)
        row = self.tree.joints[joint]
        return self._axes[joint], row.ratio if row.kind == "prismatic" else row.ratio * row.principal[1]

    def _moved(self, place: int, parent: FrameRegisters) -> FrameRegisters:
        builder, joint = self.builder, self.tree.joints[place]
        if joint.kind == "free":
            first = joint.coordinate  # a floating base has its pose in the root
            return FrameRegisters(*builder.orientation(first + 3), builder.position(first))
        k, sign = joint.principal
        if joint.kind == "prismatic":
            frame = builder.placed(parent, joint.R, joint.t)
            direction = builder.combination(builder.zero, zip(frame.columns, joint.axis, strict=True))
            self._axes[place] = direction
            origin = builder.combination(frame.origin, [(direction, joint.offset)])
            return FrameRegisters(*frame.columns, builder.scaled(origin, direction, joint.coordinate, joint.ratio))
        R = joint.R if joint.aligned else joint.R @ joint.alignment
        frame = builder.placed(parent, R, joint.t)
        self._axes[place] = frame.columns[k]
        angle = builder.angle(joint.coordinate, sign * joint.ratio, sign * joint.offset)
        turned = builder.turned(frame, k, angle)
        return turned if joint.aligned else builder.placed(turned, joint.alignment.T, np.zeros(3))


# --- Velocities and accelerations of a robot's joints in the registers of a program.


@dataclass(frozen=True)
class BodyMotion:
    """The motion of a body at one of its points, in the root's axes."""

    point: Register
    v: Register  # velocity of the point
    w: Register  # angular velocity of the body
    dv: Register  # acceleration of the point
    dw: Register  # angular acceleration


class MovingTree:
    """Motions of the frames of joints, made on demand; `derivatives` is 1 for velocities, 2 for accelerations too."""

    def __init__(self, posed: PosedTree, derivatives: int) -> None:
        self.posed, self.builder = posed, posed.builder
        self._accelerated = derivatives > 1
        zero = self.builder.zero
        self._motions = {ROOT: BodyMotion(zero, zero, zero, zero, zero)}

    def motion(self, joint: int, point: Register) -> BodyMotion:
        """Return the motion of the body of a joint, at a point of it."""
        for place in self.posed.tree.chain(joint):
            if place not in self._motions:
                self._motions[place] = self._moved(place)
        return self._at(self._motions[joint], point)

    def twist(self, motion: BodyMotion, frame: FrameRegisters, expression: str) -> tuple[Register, Register]:
        """Return linear and angular velocity in the given expression."""
        builder = self.builder
        if expression == "frame":
            return builder.projected(frame.columns, motion.v), builder.projected(frame.columns, motion.w)
        if expression == "root":
            return builder.cross(motion.point, motion.w, 1.0, motion.v), motion.w
        return motion.v, motion.w

    def twist_rate(self, motion: BodyMotion, frame: FrameRegisters, expression: str) -> tuple[Register, Register]:
        """Return the derivative of the numbers of the twist in the given expression."""
        builder = self.builder
        if expression == "frame":
            linear = builder.cross(motion.w, motion.v, -1.0, motion.dv)
            return builder.projected(frame.columns, linear), builder.projected(frame.columns, motion.dw)
        if expression == "root":
            linear = builder.cross(motion.v, motion.w, 1.0, motion.dv)
            return builder.cross(motion.point, motion.dw, 1.0, linear), motion.dw
        return motion.dv, motion.dw

    def _at(self, motion: BodyMotion, point: Register) -> BodyMotion:
        """Return the motion at another point of the body: v + ω × r and v̇ + ω̇ × r + ω × (ω × r)."""
        if point == motion.point:
            return motion
        builder = self.builder
        r = builder.difference(point, motion.point)
        swing = builder.cross(motion.w, r)
        v = builder.combination(motion.v, [(swing, 1.0)])
        dv = motion.dv
        if self._accelerated:
            dv = builder.cross(motion.w, swing, 1.0, builder.cross(motion.dw, r, 1.0, dv))
        return BodyMotion(point, v, motion.w, dv, motion.dw)

    def _moved(self, place: int) -> BodyMotion:
        builder, joint = self.builder, self.posed.tree.joints[place]
        origin = self.posed.frame(place).origin
        carried = self._at(self._motions[joint.parent], origin)
        if joint.kind == "free":
            return self._floating(place, origin)
        axis, weight = self.posed.axis(place)
        speed = builder.scaled(builder.zero, axis, builder.velocity(joint.velocity), weight)
        v, w, dv, dw = carried.v, carried.w, carried.dv, carried.dw
        if joint.kind == "prismatic":
            v = builder.combination(v, [(speed, 1.0)])
        else:
            w = builder.combination(w, [(speed, 1.0)])
        if self._accelerated:
            rate = builder.acceleration(joint.velocity)
            if joint.kind == "prismatic":
                dv = builder.scaled(builder.cross(carried.w, speed, 2.0, dv), axis, rate, weight)
            else:
                dw = builder.scaled(builder.cross(carried.w, speed, 1.0, dw), axis, rate, weight)
        return BodyMotion(origin, v, w, dv, dw)

    def _floating(self, place: int, origin: Register) -> BodyMotion:
        """Return the motion of a floating base, whose velocity and acceleration are given in its own axes."""
        builder, first = self.builder, self.posed.tree.joints[place].velocity
        columns = self.posed.frame(place).columns
        v = w = dv = dw = builder.zero
        for k, axis in enumerate(columns):
            v = builder.scaled(v, axis, builder.velocity(first + k))
            w = builder.scaled(w, axis, builder.velocity(first + 3 + k))
            if self._accelerated:
                dv = builder.scaled(dv, axis, builder.acceleration(first + k))
                dw = builder.scaled(dw, axis, builder.acceleration(first + 3 + k))
        # The components of v change with the axes, too.
        return BodyMotion(origin, v, w, builder.cross(w, v, 1.0, dv) if self._accelerated else dv, dw)


# --- Poses, Jacobians, centres of mass, velocities and accelerations.


def poses_program(
    tree: JointTree, frames: Sequence[TreeFrame], reference: TreeFrame | None = None, form: str = "matrix"
) -> Program:
    """Return the program of poses of frames in the root or a reference frame, in a form of `POSE_SHAPES`."""
    builder = Builder(tree.nq, tree.nv)
    if reference is None:
        posed = PosedTree(builder, tree)
        poses = [posed.placed(frame) for frame in frames]
    else:
        common = tree.common_joint([frame.joint for frame in (*frames, reference)])
        posed = PosedTree(builder, tree, common)
        origin = posed.placed(reference)
        poses = [_seen_from(builder, origin, posed.placed(frame)) for frame in frames]
    return builder.build([number for pose in poses for number in _form(builder, pose, form)])


def jacobian_program(tree: JointTree, frame: TreeFrame, expression: str, reference: TreeFrame | None = None) -> Program:
    """Return the program of the Jacobian of a frame with respect to the root or a reference frame, shape (6, nv).

    Joints between the reference and the common joint of the two move the frame in the opposite direction.
    """
    builder = Builder(tree.nq, tree.nv)
    common = ROOT if reference is None else tree.common_joint([frame.joint, reference.joint])
    posed = PosedTree(builder, tree, common)
    at = posed.placed(frame)
    root = builder.root if reference is None else posed.placed(reference)
    point, axes = (root if expression == "root" else at).origin, (at if expression == "frame" else root).columns
    linear, angular = [builder.zero] * tree.nv, [builder.zero] * tree.nv
    shared = len(tree.chain(common))
    joints = [(joint, 1.0) for joint in tree.chain(frame.joint)[shared:]]
    if reference is not None:
        joints += [(joint, -1.0) for joint in tree.chain(reference.joint)[shared:]]
    for joint, direction in joints:
        row, origin = tree.joints[joint], posed.frame(joint).origin
        lever = builder.difference(point, origin) if direction > 0.0 else builder.difference(origin, point)
        _add_motion(posed, joint, direction, lever, linear)
        if row.kind == "free":
            angular[row.velocity + 3 : row.velocity + 6] = posed.frame(joint).columns
        elif row.kind == "revolute":
            axis, speed = posed.axis(joint)
            angular[row.velocity] = builder.combination(angular[row.velocity], [(axis, direction * speed)])
    linear, angular = ([_projected(builder, axes, column) for column in part] for part in (linear, angular))
    return builder.build([*_rows(linear), *_rows(angular)])


def com_program(tree: JointTree, reference: TreeFrame | None = None) -> Program:
    """Return the program of the centre of mass in the root or in a reference frame, shape (3,).

    First moments are summed from the tips to the root, and each joint rotates the moment of all bodies behind it: a
    third of the work of computing the pose of every body.
    """
    builder = Builder(tree.nq, tree.nv)
    centre = builder.combination(_gathered(builder, tree, -1), [(_moment(builder, tree, -1), 1.0)])
    if reference is not None:
        origin = PosedTree(builder, tree).placed(reference)
        centre = builder.projected(origin.columns, builder.difference(centre, origin.origin))
    return builder.build(components(centre))


def com_jacobian_program(tree: JointTree, reference: TreeFrame | None = None) -> Program:
    """Return the program of the Jacobian of the centre of mass in the root or in a reference frame, shape (3, nv).

    Joints between the root and the reference move the centre, as seen from the reference, in the opposite direction.
    """
    builder = Builder(tree.nq, tree.nv)
    posed = PosedTree(builder, tree)
    moments: list[Register] = []
    for k, joint in enumerate(tree.joints):
        frame, share = posed.frame(k), joint.mass / tree.total_mass
        terms = [(frame.origin, share), *zip(frame.columns, _shares(tree, joint.moment), strict=True)]
        moments.append(builder.combination(builder.zero, terms))
    for k in range(len(moments) - 1, -1, -1):
        if (parent := tree.joints[k].parent) >= 0:
            moments[parent] = builder.combination(moments[parent], [(moments[k], 1.0)])
    columns = [builder.zero] * tree.nv
    for k in range(len(tree.joints)):
        share = tree.carried_masses[k] / tree.total_mass
        _add_motion(posed, k, share, builder.combination(moments[k], [(posed.frame(k).origin, -share)]), columns)
    if reference is not None:
        at = posed.placed(reference)
        first = [(moments[k], 1.0) for k, joint in enumerate(tree.joints) if joint.parent < 0]
        centre = builder.combination(_moment(builder, tree, -1), first)
        for k in tree.chain(reference.joint):
            _add_motion(posed, k, -1.0, builder.difference(posed.frame(k).origin, centre), columns)
        columns = [_projected(builder, at.columns, column) for column in columns]
    return builder.build(_rows(columns))


def motion_program(tree: JointTree, frames: Sequence[TreeFrame], expression: str, derivatives: int) -> Program:
    """Return the program of the twists of frames, shape (6,) each; with `derivatives` 2, of their time derivatives."""
    builder = Builder(tree.nq, tree.nv, derivatives)
    posed = PosedTree(builder, tree)
    moving = MovingTree(posed, derivatives)
    result: list[Component] = []
    for frame in frames:
        at = posed.placed(frame)
        motion = moving.motion(frame.joint, at.origin)
        vectors = (moving.twist if derivatives == 1 else moving.twist_rate)(motion, at, expression)
        result += [number for vector in vectors for number in components(vector)]
    return builder.build(result)


# --- poses ------------------------------------------------------------------------------------------------------------


def _seen_from(builder: Builder, reference: FrameRegisters, frame: FrameRegisters) -> FrameRegisters:
    columns = [builder.projected(reference.columns, column) for column in frame.columns]
    origin = builder.projected(reference.columns, builder.difference(frame.origin, reference.origin))
    return FrameRegisters(columns[0], columns[1], columns[2], origin)


def _form(builder: Builder, frame: FrameRegisters, form: str) -> list[Component]:
    columns, origin = [components(column) for column in frame.columns], components(frame.origin)
    if form == "position":
        return [*origin]
    if form == "rotation":
        return [column[row] for row in range(3) for column in columns]
    if form == "quaternion":
        return [*origin, *builder.quaternion(frame)]
    if form == "rpy":
        return [*origin, *builder.rpy(frame)]
    last = [Component(builder.zero, 0)] * 3 + [Component(builder.root.x, 0)]
    return [column[row] for row in range(3) for column in (*columns, origin)] + last


# --- Jacobians --------------------------------------------------------------------------------------------------------


def _add_motion(posed: PosedTree, joint: int, share: float, lever: Register, columns: list[Register]) -> None:
    """Add what the rates of one joint contribute to the velocity of a point, as columns of its Jacobian.

    Args:
        posed: the frames of the joints.
        joint: the joint.
        share: the part of the point that the joint moves, such as its share of the mass; negative in the opposite
            direction.
        lever: the share times the vector from the joint's origin to the point.
        columns: a column for each number of the velocity; changed in place.
    """
    builder, row = posed.builder, posed.tree.joints[joint]
    v = row.velocity
    if row.kind == "free":
        for k, axis in enumerate(posed.frame(joint).columns):
            columns[v + k] = builder.combination(columns[v + k], [(axis, share)])
            columns[v + 3 + k] = builder.cross(axis, lever, 1.0, columns[v + 3 + k])
        return
    axis, weight = posed.axis(joint)
    if row.kind == "prismatic":
        columns[v] = builder.combination(columns[v], [(axis, weight * share)])
    else:
        columns[v] = builder.cross(axis, lever, weight, columns[v])


def _projected(builder: Builder, axes: Columns, vector: Register) -> Register:
    return vector if vector == builder.zero else builder.projected(axes, vector)


def _rows(columns: Sequence[Register]) -> list[Component]:
    return [Component(column, row) for row in range(3) for column in columns]


# --- centres of mass --------------------------------------------------------------------------------------------------


def _shares(tree: JointTree, moment: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = (number / tree.total_mass for number in moment)
    return x, y, z


def _moment(builder: Builder, tree: JointTree, joint: int) -> Register:
    """Return the first moment of a joint's own body, divided by the total mass."""
    return builder.constant(*_shares(tree, tree.moment if joint < 0 else tree.joints[joint].moment))


def _gathered(builder: Builder, tree: JointTree, joint: int) -> Register:
    """Return the first moment, in the frame of a joint, of all bodies behind it."""
    total = builder.zero
    for child in tree.children[joint]:
        if tree.carried_masses[child] == 0.0:
            continue
        total = _carried_moment(builder, tree, child, total)
    return total


def _carried_moment(builder: Builder, tree: JointTree, place: int, start: Register) -> Register:
    """Return `start`, in the parent's frame, plus the first moment of a joint's body and the bodies behind it."""
    joint, share = tree.joints[place], tree.carried_masses[place] / tree.total_mass
    inside = builder.combination(_gathered(builder, tree, place), [(_moment(builder, tree, place), 1.0)])
    if joint.kind == "free":
        turned = builder.projected(builder.orientation(joint.coordinate + 3, inverse=True), inside)
        return builder.combination(start, [(turned, 1.0), (builder.position(joint.coordinate), share)])
    k, sign = joint.principal
    offset = [share * number for number in joint.t.tolist()]
    if joint.kind == "prismatic":
        along = builder.constant(*joint.axis)
        inside = builder.combination(inside, [(along, share * joint.offset)])
        inside = builder.scaled(inside, along, joint.coordinate, share * joint.ratio)
        moved = inside if joint.is_straight else builder.transformed(builder.zero, joint.R, inside)
        return builder.combination(start, [(moved, 1.0), (builder.constant(*offset), 1.0)])
    angle = builder.angle(joint.coordinate, sign * joint.ratio, sign * joint.offset)
    if joint.aligned and joint.is_straight:
        return builder.hinged(start, inside, k, angle, offset)
    if not joint.aligned:
        inside = builder.transformed(builder.zero, joint.alignment.T, inside)
    turned = builder.hinged(builder.zero, inside, k, angle, (0.0, 0.0, 0.0))
    W = joint.R if joint.aligned else joint.R @ joint.alignment
    moved = builder.transformed(start, W, turned)
    return builder.combination(moved, [(builder.constant(*offset), 1.0)])
