"""The programs that answer what a robot is asked: poses, Jacobians, centres of mass, velocities and accelerations.

Programs know no names and no units; frames are given by the joints that hold them. Jacobians and twists have the three
linear numbers first, and are expressed "mixed" (at the frame's origin in the root's axes), in the "frame" (at its
origin in its own axes) or in the "root" (at the root's origin in the root's axes).
"""

from __future__ import annotations

from collections.abc import Sequence

from nao_kin.batch.moving import MovingTree
from nao_kin.batch.posing import PosedTree
from nao_kin.batch.program import Builder, Frame, Number, Program, Register, numbers
from nao_kin.batch.tree import JointTree, TreeFrame


def poses_program(
    tree: JointTree, frames: Sequence[TreeFrame], reference: TreeFrame | None = None, form: str = "matrix"
) -> Program:
    """Poses of frames in the root or in a reference frame, one frame after another.

    The form is "matrix", "rotation", "position", "position_quaternion" or "position6d". With a reference, the joints
    that carry all of the frames do not matter and are left out.

    Examples:
        >>> turn = nk.batch.TreeJoint("revolute", -1, np.eye(3), np.zeros(3), (0.0, 0.0, 1.0), 0, 0)
        >>> tree = nk.batch.JointTree(1, 1, (turn,))
        >>> tip = nk.batch.TreeFrame(0, np.eye(3), np.array([0.1, 0.0, 0.0]))
        >>> program = nk.batch.poses_program(tree, [tip], form="position")
        >>> out = np.empty((2, 3))
        >>> _ = nk.batch.execute(program, [np.array([[0.0], [0.5]])], out)
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
        >>> turn = nk.batch.TreeJoint("revolute", -1, np.eye(3), np.zeros(3), (0.0, 0.0, 1.0), 0, 0)
        >>> tree = nk.batch.JointTree(1, 1, (turn,))
        >>> tip = nk.batch.TreeFrame(0, np.eye(3), np.array([0.1, 0.0, 0.0]))
        >>> program = nk.batch.jacobian_program(tree, tip, "mixed")
        >>> out = np.empty((1, 6))
        >>> _ = nk.batch.execute(program, [np.zeros((1, 1))], out)
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
        >>> turn = nk.batch.TreeJoint(
        ...     "revolute", -1, np.eye(3), np.zeros(3), (0.0, 0.0, 1.0), 0, 0, mass=2.0, moment=(0.2, 0.0, 0.0)
        ... )
        >>> tree = nk.batch.JointTree(1, 1, (turn,))
        >>> out = np.empty((1, 3))
        >>> _ = nk.batch.execute(nk.batch.com_program(tree), [np.zeros((1, 1))], out)
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
        >>> turn = nk.batch.TreeJoint(
        ...     "revolute", -1, np.eye(3), np.zeros(3), (0.0, 0.0, 1.0), 0, 0, mass=2.0, moment=(0.2, 0.0, 0.0)
        ... )
        >>> tree = nk.batch.JointTree(1, 1, (turn,))
        >>> out = np.empty((1, 3))
        >>> _ = nk.batch.execute(nk.batch.com_jacobian_program(tree), [np.zeros((1, 1))], out)
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
        >>> turn = nk.batch.TreeJoint("revolute", -1, np.eye(3), np.zeros(3), (0.0, 0.0, 1.0), 0, 0)
        >>> tree = nk.batch.JointTree(1, 1, (turn,))
        >>> tip = nk.batch.TreeFrame(0, np.eye(3), np.array([0.1, 0.0, 0.0]))
        >>> program = nk.batch.motion_program(tree, [tip], "mixed", 1)
        >>> out = np.empty((1, 6))
        >>> _ = nk.batch.execute(program, [np.zeros((1, 1)), np.array([[2.0]])], out)
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
