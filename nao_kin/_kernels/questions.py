"""The programs that answer what a robot is asked: poses, Jacobians, centres of mass, velocities and accelerations.

Programs know no names and no units; frames are given by the joints that hold them. Jacobians and twists have the three
linear numbers first, and are expressed "mixed" (at the frame's origin in the root's axes), in the "frame" (at its
origin in its own axes) or in the "root" (at the root's origin in the root's axes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from nao_kin._kernels.program import Builder, Frame, Number, Program, Register, numbers
from nao_kin._kernels.tree import ROOT, JointTree, TreeFrame

# --- Frames of a robot's joints in the registers of a program.


class PosedTree:
    """Frames of joints in registers, made when they are asked for.

    Args:
        builder: where the operations go.
        tree: the joints.
        origin: the joint whose frame is the identity: all that is asked for must hang on it.
    """

    def __init__(self, builder: Builder, tree: JointTree, origin: int = ROOT) -> None:
        self.builder, self.tree = builder, tree
        self._frames: dict[int, Frame] = {origin: builder.root}
        # The axis of each joint as its own frame has it before the joint moves.
        self._axes: dict[int, Register] = {}

    def frame(self, joint: int) -> Frame:
        """The frame of a joint."""
        for place in self.tree.chain(joint):
            if place not in self._frames:
                parent = self.tree.joints[place].parent
                if parent in self._frames:
                    self._frames[place] = self._moved(place, self._frames[parent])
        return self._frames[joint]

    def placed(self, frame: TreeFrame) -> Frame:
        """A frame held to a joint."""
        return self.builder.placed(self.frame(frame.joint), frame.R, frame.t)

    def axis(self, joint: int) -> tuple[Register, float]:
        """The direction of a joint's axis, and the weight of its speed along or about it."""
        self.frame(joint)
        row = self.tree.joints[joint]
        return self._axes[joint], row.ratio if row.kind == "prismatic" else row.ratio * row.principal[1]

    def _moved(self, place: int, parent: Frame) -> Frame:
        builder, joint = self.builder, self.tree.joints[place]
        if joint.kind == "free":
            first = joint.coordinate  # a floating base stands in the world, where no joint carries it
            return Frame(*builder.orientation(first + 3), builder.position(first))
        k, sign = joint.principal
        if joint.kind == "prismatic":
            frame = builder.placed(parent, joint.R, joint.t)
            direction = builder.combination(builder.zero, zip(frame.columns, joint.axis, strict=True))
            self._axes[place] = direction
            origin = builder.combination(frame.origin, [(direction, joint.offset)])
            return Frame(*frame.columns, builder.scaled(origin, direction, joint.coordinate, joint.ratio))
        R = joint.R if joint.aligned else joint.R @ joint.alignment
        frame = builder.placed(parent, R, joint.t)
        self._axes[place] = frame.columns[k]
        angle = builder.angle(joint.coordinate, sign * joint.ratio, sign * joint.offset)
        turned = builder.turned(frame, k, angle)
        if joint.aligned:
            return turned
        columns = (
            builder.combination(builder.zero, zip(turned.columns, row, strict=True)) for row in joint.alignment.tolist()
        )
        x, y, z = columns
        return Frame(x, y, z, turned.origin)


# --- Velocities and accelerations of a robot's joints in the registers of a program.


@dataclass(frozen=True)
class Motion:
    """How a body moves at one of its points, in the root's axes.

    Attributes:
        point: the point.
        v: its velocity.
        w: angular velocity of the body.
        dv: acceleration of the point.
        dw: angular acceleration.
    """

    point: Register
    v: Register
    w: Register
    dv: Register
    dw: Register


class MovingTree:
    """Motions of the frames of joints, made when they are asked for.

    Args:
        posed: the frames.
        derivatives: 1 for velocities, 2 for accelerations too.
    """

    def __init__(self, posed: PosedTree, derivatives: int) -> None:
        self.posed, self.builder = posed, posed.builder
        self._accelerated = derivatives > 1
        zero = self.builder.zero
        self._motions = {ROOT: Motion(zero, zero, zero, zero, zero)}

    def motion(self, joint: int, point: Register) -> Motion:
        """The motion of what a joint carries, at a point of it."""
        for place in self.posed.tree.chain(joint):
            if place not in self._motions:
                self._motions[place] = self._moved(place)
        return self._at(self._motions[joint], point)

    def twist(self, motion: Motion, frame: Frame, expression: str) -> tuple[Register, Register]:
        """Linear and angular velocity, as the expression has them."""
        builder = self.builder
        if expression == "frame":
            return builder.projected(frame.columns, motion.v), builder.projected(frame.columns, motion.w)
        if expression == "root":
            return builder.cross(motion.point, motion.w, 1.0, motion.v), motion.w
        return motion.v, motion.w

    def twist_rate(self, motion: Motion, frame: Frame, expression: str) -> tuple[Register, Register]:
        """The derivative of the numbers of the twist, as the expression has them."""
        builder = self.builder
        if expression == "frame":
            linear = builder.cross(motion.w, motion.v, -1.0, motion.dv)
            return builder.projected(frame.columns, linear), builder.projected(frame.columns, motion.dw)
        if expression == "root":
            linear = builder.cross(motion.v, motion.w, 1.0, motion.dv)
            return builder.cross(motion.point, motion.dw, 1.0, linear), motion.dw
        return motion.dv, motion.dw

    def _at(self, motion: Motion, point: Register) -> Motion:
        """The same body at another of its points: v + ω × r and v̇ + ω̇ × r + ω × (ω × r)."""
        if point == motion.point:
            return motion
        builder = self.builder
        r = builder.difference(point, motion.point)
        swing = builder.cross(motion.w, r)
        v = builder.combination(motion.v, [(swing, 1.0)])
        dv = motion.dv
        if self._accelerated:
            dv = builder.cross(motion.w, swing, 1.0, builder.cross(motion.dw, r, 1.0, dv))
        return Motion(point, v, motion.w, dv, motion.dw)

    def _moved(self, place: int) -> Motion:
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
        return Motion(origin, v, w, dv, dw)

    def _floating(self, place: int, origin: Register) -> Motion:
        """A floating base, whose velocity and acceleration are given in its own axes."""
        builder, first = self.builder, self.posed.tree.joints[place].velocity
        columns = self.posed.frame(place).columns
        v = w = dv = dw = builder.zero
        for k, axis in enumerate(columns):
            v = builder.scaled(v, axis, builder.velocity(first + k))
            w = builder.scaled(w, axis, builder.velocity(first + 3 + k))
            if self._accelerated:
                dv = builder.scaled(dv, axis, builder.acceleration(first + k))
                dw = builder.scaled(dw, axis, builder.acceleration(first + 3 + k))
        # The numbers of v change with the axes, too.
        return Motion(origin, v, w, builder.cross(w, v, 1.0, dv) if self._accelerated else dv, dw)


# --- The programs that answer what a robot is asked: poses, Jacobians, centres of mass, velocities and accelerations.


def poses_program(
    tree: JointTree, frames: Sequence[TreeFrame], reference: TreeFrame | None = None, form: str = "matrix"
) -> Program:
    """Poses of frames in the root or in a reference frame, one frame after another.

    The form is "matrix", "rotation", "position", "position_quaternion" or "position6d". With a reference, the joints
    that carry all of the frames do not matter and are left out.

    Examples:
        >>> turn = nk._kernels.TreeJoint("revolute", -1, np.eye(3), np.zeros(3), (0.0, 0.0, 1.0), 0, 0)
        >>> tree = nk._kernels.JointTree(1, 1, (turn,))
        >>> tip = nk._kernels.TreeFrame(0, np.eye(3), np.array([0.1, 0.0, 0.0]))
        >>> program = nk._kernels.poses_program(tree, [tip], form="position")
        >>> out = np.empty((2, 3))
        >>> _ = nk._kernels.execute(program, [np.array([[0.0], [0.5]])], out)
        >>> out.round(4).tolist()
        [[0.1, 0.0, 0.0], [0.0878, 0.0479, 0.0]]
    """
    builder = Builder(tree.nq, tree.nv)
    if reference is None:
        posed = PosedTree(builder, tree)
        poses = [posed.placed(frame) for frame in frames]
    else:
        common = tree.common_joint([frame.joint for frame in (*frames, reference)])
        posed = PosedTree(builder, tree, common)
        origin = posed.placed(reference)
        poses = [_seen_from(builder, origin, posed.placed(frame)) for frame in frames]
    return builder.finished([number for pose in poses for number in _form(builder, pose, form)])


def jacobian_program(tree: JointTree, frame: TreeFrame, expression: str) -> Program:
    """The Jacobian of a frame, shape (6, nv).

    Examples:
        >>> turn = nk._kernels.TreeJoint("revolute", -1, np.eye(3), np.zeros(3), (0.0, 0.0, 1.0), 0, 0)
        >>> tree = nk._kernels.JointTree(1, 1, (turn,))
        >>> tip = nk._kernels.TreeFrame(0, np.eye(3), np.array([0.1, 0.0, 0.0]))
        >>> program = nk._kernels.jacobian_program(tree, tip, "mixed")
        >>> out = np.empty((1, 6))
        >>> _ = nk._kernels.execute(program, [np.zeros((1, 1))], out)
        >>> out.tolist()
        [[0.0, 0.1, 0.0, 0.0, 0.0, 1.0]]
    """
    builder = Builder(tree.nq, tree.nv)
    posed = PosedTree(builder, tree)
    at = posed.placed(frame)
    linear, angular = [builder.zero] * tree.nv, [builder.zero] * tree.nv
    for joint in tree.chain(frame.joint):
        row, origin = tree.joints[joint], posed.frame(joint).origin
        if row.kind == "free":
            lever = _lever(builder, at.origin, origin, expression)
            for k, axis in enumerate(posed.frame(joint).columns):
                linear[row.velocity + k] = axis
                angular[row.velocity + 3 + k] = axis
                linear[row.velocity + 3 + k] = builder.cross(axis, lever)
            continue
        axis, weight = posed.axis(joint)
        v = row.velocity
        if row.kind == "prismatic":
            linear[v] = builder.combination(linear[v], [(axis, weight)])
        else:
            lever = _lever(builder, at.origin, origin, expression)
            angular[v] = builder.combination(angular[v], [(axis, weight)])
            linear[v] = builder.cross(axis, lever, weight, linear[v])
    if expression == "frame":
        linear, angular = ([_projected(builder, at, column) for column in part] for part in (linear, angular))
    return builder.finished([*_rows(linear), *_rows(angular)])


def com_program(tree: JointTree, reference: TreeFrame | None = None) -> Program:
    """The centre of all masses in the root or in a reference frame, shape (3,).

    First moments are gathered from the tips to the root, each joint turning the moment of what it carries: a third of
    the work of posing every body first.

    Examples:
        >>> turn = nk._kernels.TreeJoint(
        ...     "revolute", -1, np.eye(3), np.zeros(3), (0.0, 0.0, 1.0), 0, 0, mass=2.0, moment=(0.2, 0.0, 0.0)
        ... )
        >>> tree = nk._kernels.JointTree(1, 1, (turn,))
        >>> out = np.empty((1, 3))
        >>> _ = nk._kernels.execute(nk._kernels.com_program(tree), [np.zeros((1, 1))], out)
        >>> out.tolist()
        [[0.1, 0.0, 0.0]]
    """
    builder = Builder(tree.nq, tree.nv)
    centre = builder.combination(_gathered(builder, tree, -1), [(_moment(builder, tree, -1), 1.0)])
    if reference is not None:
        origin = PosedTree(builder, tree).placed(reference)
        centre = builder.projected(origin.columns, builder.difference(centre, origin.origin))
    return builder.finished(numbers(centre))


def com_jacobian_program(tree: JointTree) -> Program:
    """The Jacobian of the centre of all masses in the root's axes, shape (3, nv).

    Examples:
        >>> turn = nk._kernels.TreeJoint(
        ...     "revolute", -1, np.eye(3), np.zeros(3), (0.0, 0.0, 1.0), 0, 0, mass=2.0, moment=(0.2, 0.0, 0.0)
        ... )
        >>> tree = nk._kernels.JointTree(1, 1, (turn,))
        >>> out = np.empty((1, 3))
        >>> _ = nk._kernels.execute(nk._kernels.com_jacobian_program(tree), [np.zeros((1, 1))], out)
        >>> out.tolist()
        [[0.0, 0.1, 0.0]]
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
    for k, joint in enumerate(tree.joints):
        share, frame, v = tree.carried_masses[k] / tree.total_mass, posed.frame(k), joint.velocity
        lever = builder.combination(moments[k], [(frame.origin, -share)])
        if joint.kind == "free":
            for i, axis in enumerate(frame.columns):
                columns[v + i] = builder.combination(builder.zero, [(axis, share)])
                columns[v + 3 + i] = builder.cross(axis, lever)
            continue
        axis, weight = posed.axis(k)
        if joint.kind == "prismatic":
            columns[v] = builder.combination(columns[v], [(axis, weight * share)])
        else:
            columns[v] = builder.cross(axis, lever, weight, columns[v])
    return builder.finished(_rows(columns))


def motion_program(tree: JointTree, frames: Sequence[TreeFrame], expression: str, derivatives: int) -> Program:
    """Twists of frames, shape (6,) each; with two derivatives the rates at which the numbers of the twists change.

    Examples:
        >>> turn = nk._kernels.TreeJoint("revolute", -1, np.eye(3), np.zeros(3), (0.0, 0.0, 1.0), 0, 0)
        >>> tree = nk._kernels.JointTree(1, 1, (turn,))
        >>> tip = nk._kernels.TreeFrame(0, np.eye(3), np.array([0.1, 0.0, 0.0]))
        >>> program = nk._kernels.motion_program(tree, [tip], "mixed", 1)
        >>> out = np.empty((1, 6))
        >>> _ = nk._kernels.execute(program, [np.zeros((1, 1)), np.array([[2.0]])], out)
        >>> out.tolist()
        [[0.0, 0.2, 0.0, 0.0, 0.0, 2.0]]
    """
    builder = Builder(tree.nq, tree.nv, derivatives)
    posed = PosedTree(builder, tree)
    moving = MovingTree(posed, derivatives)
    result: list[Number] = []
    for frame in frames:
        at = posed.placed(frame)
        motion = moving.motion(frame.joint, at.origin)
        vectors = (moving.twist if derivatives == 1 else moving.twist_rate)(motion, at, expression)
        result += [number for vector in vectors for number in numbers(vector)]
    return builder.finished(result)


# --- poses ------------------------------------------------------------------------------------------------------------


def _seen_from(builder: Builder, reference: Frame, frame: Frame) -> Frame:
    columns = [builder.projected(reference.columns, column) for column in frame.columns]
    origin = builder.projected(reference.columns, builder.difference(frame.origin, reference.origin))
    return Frame(columns[0], columns[1], columns[2], origin)


def _form(builder: Builder, frame: Frame, form: str) -> list[Number]:
    columns, origin = [numbers(column) for column in frame.columns], numbers(frame.origin)
    if form == "position":
        return [*origin]
    if form == "rotation":
        return [column[row] for row in range(3) for column in columns]
    if form == "position_quaternion":
        return [*origin, *builder.quaternion(frame)]
    if form == "position6d":
        return [*origin, *builder.rpy(frame)]
    last = [Number(builder.zero, 0)] * 3 + [Number(builder.root.x, 0)]
    return [column[row] for row in range(3) for column in (*columns, origin)] + last


# --- Jacobians --------------------------------------------------------------------------------------------------------


def _lever(builder: Builder, point: Register, origin: Register, expression: str) -> Register:
    """From a joint's origin to where the linear velocity is taken."""
    return builder.difference(builder.zero if expression == "root" else point, origin)


def _projected(builder: Builder, frame: Frame, vector: Register) -> Register:
    return vector if vector == builder.zero else builder.projected(frame.columns, vector)


def _rows(columns: Sequence[Register]) -> list[Number]:
    return [Number(column, row) for row in range(3) for column in columns]


# --- centres of mass --------------------------------------------------------------------------------------------------


def _shares(tree: JointTree, moment: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = (number / tree.total_mass for number in moment)
    return x, y, z


def _moment(builder: Builder, tree: JointTree, joint: int) -> Register:
    """First moment of what a joint moves itself, as a share of the total mass."""
    return builder.constant(*_shares(tree, tree.moment if joint < 0 else tree.joints[joint].moment))


def _gathered(builder: Builder, tree: JointTree, joint: int) -> Register:
    """First moment, in the frame of a joint, of all that its children carry."""
    total = builder.zero
    for child in tree.children[joint]:
        total = _carried_moment(builder, tree, child, total)
    return total


def _carried_moment(builder: Builder, tree: JointTree, place: int, start: Register) -> Register:
    """`start`, in the frame of its parent, and the first moment of what a joint carries."""
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
