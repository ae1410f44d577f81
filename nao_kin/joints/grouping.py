"""Grouping of a robot's revolute joints into universal and spherical joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar, get_args

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, choice, dot, norm, rigid_inverse
from nao_kin.errors import BadArgument
from nao_kin.joints.pairs import KINEMATIC_PAIRS, PARALLEL, JointGroups, MultiDofJoint, Singularity
from nao_kin.robot import Expression, RobotModel
from nao_kin.robot.semantics import Mimic
from nao_kin.screws.lines import PluckerLine, geometric_jacobian

TURN = 2.0 * math.pi

# --- The joint tree of a robot, with every axis at zero.


@dataclass(frozen=True, eq=False)
class JointNode:
    """One joint of the tree; its value is coupling.multiplier · q[column] + coupling.offset."""

    index: int  # index in the model's joints
    name: str
    parent: int  # index of the joint that carries it, 0 for the root
    children: tuple[int, ...]  # indices of the joints that it carries
    kind: str  # "revolute", "prismatic", "free", or "fixed" for a mimic joint with the multiplier zero
    axis: Floats  # unit vector in its frame; zero for "free" and "fixed"
    T_root: pin.SE3  # pose of its frame in the root's, all joints at zero; includes the offset of "fixed"
    mimic: Mimic | None  # how it follows another joint; None with its own coordinate
    lower: float
    upper: float
    unit: str  # of its value
    moves: bool  # whether it or a joint that it carries has its own coordinate; fingers that follow the hand do not
    column: int  # index of the coordinate that moves it in a configuration of the robot
    row: int  # index of the rate of that coordinate in the velocity

    @property
    def coupling(self) -> Mimic:
        """How it follows the coordinate that moves it; a joint with its own coordinate follows itself."""
        return self.mimic or Mimic(self.name)

    @property
    def axis_root(self) -> Floats:
        """Its axis in the root's frame, all joints at zero."""
        return np.asarray(self.T_root.rotation @ self.axis)

    @property
    def centre_root(self) -> Floats:
        """The origin of its frame in the root's frame, all joints at zero [m]."""
        return np.array(self.T_root.translation)

    def of(self, q: Floats) -> Floats:
        """Return its values at configurations of the robot, shape (..., nq) → (...)."""
        return self.coupling.value(q[..., self.column])

    def excess(self, value: Floats, driver: Floats) -> Floats:
        """Return a value minus the value that its driver requires; for a revolute joint up to whole turns."""
        difference = value - self.coupling.value(driver)
        return wrapped(difference) if self.kind == "revolute" else np.asarray(difference)


def wrapped(angle: Floats) -> Floats:
    """Return the angle, moved by whole turns into [−π, π]."""
    return np.asarray(angle - TURN * np.round(angle / TURN))


def read_joint_tree(robot: RobotModel) -> dict[int, JointNode]:
    """Return joint index → joint, with placements of `robot.model`, and kinds, axes and couplings of `robot.tree`."""
    model, table = robot.model, robot.joints
    first, nodes = int(model.njoints) - len(table.names), dict[int, JointNode]()
    for index in range(1, model.njoints):
        name, parent = str(model.names[index]), int(model.parents[index])
        T_root = (nodes[parent].T_root if parent else pin.SE3.Identity()) * model.jointPlacements[index]
        children = tuple(map(int, model.children[index]))
        moves = any(model.joints[carried].nq > 0 for carried in model.subtrees[index])
        kind, axis, mimic, lower, upper, unit, column, row = "free", np.zeros(3), None, -np.inf, np.inf, "", 0, 0
        if index >= first:
            k, mimic, unit = index - first, robot.mimics.get(name), robot.unit(name)
            kind, axis, (lower, upper, _) = table.kinds[k], table.axes[k], table.limits(name)
            column, row = int(table.coordinates[k]), int(table.columns[k])
            if table.multipliers[k] == 0.0:
                T_root = T_root * pin.SE3(robot.tree.moving_joints[k].travel(float(table.offsets[k])))
                kind, axis = "fixed", np.zeros(3)
        nodes[index] = JointNode(
            index, name, parent, children, kind, axis, T_root, mimic, lower, upper, unit, moves, column, row
        )
    return nodes


# --- Universal and spherical joints in a robot whose file has revolute joints only.

_Item = TypeVar("_Item")

Rule = Literal["coincident", "concurrent"]
RULES: tuple[Rule, ...] = ("coincident", "concurrent")

# The smallest tolerance, below which rounding dominates, and the largest one; a larger offset is intended [m].
_TOLERANCES = (1e-15, 1e-2)
# Three turns reach every rotation only if consecutive axes are perpendicular: a1·a2 up to rounding, and less than the
# 1e-9 that `davenport_angles` allows, so that every quaternion of a ball has angles.
_PERPENDICULAR = 0.9e-9
_MERGED = {2: "universal", 3: "spherical"}


def group_joints(robot: RobotModel, *, rule: Rule = "coincident", tolerance: float = 1e-9) -> JointGroups:
    """Merge runs of consecutive revolute joints of a robot into universal and spherical joints.

    A run goes from parent to child as long as the link between them carries nothing else with its own coordinate. Two
    neighbours in a run make a universal joint, three a spherical one, if they satisfy the rule:

    - "coincident": their centres, the origins of their frames, coincide;
    - "concurrent": their axes meet in one point. Axes that meet at zero meet in every configuration, because a turn
      about one of them does not move the point.

    In addition, neighbouring axes must not be parallel, those of a spherical joint must be perpendicular (otherwise the
    three turns would not reach every rotation, and the ball would be freer than the robot), and no motor may turn two
    of the joints.

    If a run can be cut in several ways, the cut with the fewest joints is used; among these cuts, the one with the
    largest joints (sum of squares of their numbers of axes), and then the one whose larger joint is closer to the root.

    Args:
        robot: any robot.
        rule: "coincident" or "concurrent".
        tolerance: largest distance of a centre, or an axis, from the common point [m], in [1e-15, 0.01].

    Raises:
        BadArgument: a tolerance outside these bounds.

    Examples:
        >>> groups = nk.joints.group_joints(nk.load_nao())
        >>> groups.joints[0].name, groups.joints[0].pair.name
        ('HeadYaw+HeadPitch', 'universal')
    """
    choice(rule, RULES, "rule")
    smallest, largest = _TOLERANCES
    if not smallest <= tolerance <= largest:
        raise BadArgument(f"tolerance must be in [{smallest:g}, {largest:g}] m, got {tolerance}")
    nodes = read_joint_tree(robot)
    return _grouped(nodes, _cut(nodes, rule, float(tolerance)), rule, float(tolerance))


def unmerged_joints(robot: RobotModel) -> JointGroups:
    """Return the robot's joints as its file has them, one by one; their rule is "none"."""
    nodes = read_joint_tree(robot)
    return _grouped(nodes, [[node] for node in nodes.values() if _counts(node)], "none", 0.0)


def _grouped(
    nodes: Mapping[int, JointNode], pieces: Iterable[Sequence[JointNode]], rule: str, tolerance: float
) -> JointGroups:
    groups: dict[int, MultiDofJoint] = {}
    for members in pieces:
        joint = _merged_joint(members, _parent(nodes, members[0], groups), rule)
        groups |= {node.index: joint for node in members}
    return JointGroups(
        joints=tuple(dict.fromkeys(groups.values())),
        mimics={node.name: node.mimic for node in nodes.values() if node.index in groups and node.mimic is not None},
        driven=tuple(node.name for node in nodes.values() if node.index not in groups),
        rule=rule,
        tolerance=tolerance,
    )


def _cut(nodes: Mapping[int, JointNode], rule: Rule, tolerance: float) -> list[list[JointNode]]:
    """Return the parts of every joint, in the order of the model."""

    def mergeable(members: Sequence[JointNode]) -> bool:
        axes = np.array([node.axis_root for node in members])
        if len({node.coupling.joint for node in members}) < len(members) or not spans_a_joint(axes):
            return False
        centres = np.array([node.centre_root for node in members])
        centre = _centre(centres, axes, rule)
        missed = np.linalg.norm(centres - centre, axis=1) if rule == "coincident" else distances(centre, centres, axes)
        return bool(missed.max() <= tolerance)

    pieces = [piece for run in _runs(nodes) for piece in partition(run, mergeable, max(_MERGED))]
    return sorted(pieces, key=lambda piece: piece[0].index)


def _runs(nodes: Mapping[int, JointNode]) -> list[list[JointNode]]:
    """Return the longest runs of revolute joints, and each joint of another kind alone; only joints that count."""
    runs: dict[int, list[JointNode]] = {}
    for node in nodes.values():
        if not _counts(node):
            continue
        parent = nodes.get(node.parent)
        continues = (
            parent is not None
            and node.kind == parent.kind == "revolute"
            and sum(nodes[child].moves for child in parent.children) == 1
        )
        run = runs[node.parent] if continues else []
        run.append(node)
        runs[node.index] = run
    return list({id(run): run for run in runs.values()}.values())


def _counts(node: JointNode) -> bool:
    """Return whether a joint counts: it adds a degree of freedom, or carries a joint that does."""
    return node.moves and node.kind != "fixed"


def _parent(nodes: Mapping[int, JointNode], node: JointNode, groups: Mapping[int, MultiDofJoint]) -> str:
    index = node.parent
    while index in nodes and index not in groups:
        index = nodes[index].parent
    return groups[index].name if index in groups else ""


def _merged_joint(members: Sequence[JointNode], parent: str, rule: str) -> MultiDofJoint:
    first = members[0]
    kind = _MERGED.get(len(members), first.kind)
    axes = np.zeros((0, 3)) if kind == "free" else np.array([node.axis_root for node in members])
    centres = np.array([node.centre_root for node in members])
    centre = _centre(centres, axes, rule) if len(members) > 1 else centres[0]
    for array in (axes, centre):
        array.flags.writeable = False
    middle = members[1] if len(members) == 3 else None
    return MultiDofJoint(
        name="+".join(node.name for node in members),
        pair=KINEMATIC_PAIRS[kind],
        joints=tuple(node.name for node in members),
        parent=parent,
        centre=centre,
        axes=axes,
        angles_between=angles_between(axes),
        residual=float(distances(centre, centres, axes).max()) if len(members) > 1 else 0.0,
        lower=tuple(node.lower for node in members),
        upper=tuple(node.upper for node in members),
        units=tuple(node.unit for node in members),
        singularity=None if middle is None else Singularity(middle.name, lock_angles(axes), middle.lower, middle.upper),
    )


def _centre(centres: Floats, axes: Floats, rule: str) -> Floats:
    """Return the common point of several axes through `centres` (n, 3), with unit directions (n, 3), by a rule."""
    if rule == "coincident":
        # The mean of the differences is exactly zero where the centres are equal.
        return np.asarray(centres[0] + (centres - centres[0]).mean(axis=0))
    # The point nearest to all axes by least squares, relative to the first centre; for two axes it is halfway along
    # their common normal. A point x of the line through p along e satisfies (1 − e eᵀ) x = (1 − e eᵀ) p.
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    offsets = np.einsum("nij,nj->ni", across, centres - centres[0])
    solution, *_ = np.linalg.lstsq(across.reshape(-1, 3), offsets.reshape(-1), rcond=None)
    return np.asarray(centres[0] + solution)


def partition(run: Sequence[_Item], mergeable: Callable[[Sequence[_Item]], bool], longest: int) -> list[list[_Item]]:
    """Return the best cut of a run into pieces that are single or mergeable: the fewest, then the largest, pieces."""
    count = len(run)
    # best[i], for the run from i on: (number of pieces, −sum of squares, negated lengths of pieces). Smaller is better.
    best: list[tuple[int, int, tuple[int, ...]]] = [(0, 0, ())] * (count + 1)
    for start in reversed(range(count)):
        options = []
        for length in range(1, min(longest, count - start) + 1):
            if length == 1 or mergeable(run[start : start + length]):
                pieces, squares, lengths = best[start + length]
                options.append((pieces + 1, squares - length * length, (-length, *lengths)))
        best[start] = min(options)
    cuts, start = [], 0
    for negative in best[0][2]:
        cuts.append(list(run[start : start - negative]))
        start -= negative
    return cuts


def distances(point: Floats, centres: Floats, axes: Floats) -> Floats:
    """Return the distance of a point from each axis, shape (n,) [m]."""
    return norm(np.cross(centres - point, axes))


def angles_between(axes: Floats) -> Floats:
    """Return the angles between consecutive axes, shape (n − 1,), in [0, π] [rad]."""
    sines = norm(np.cross(axes[:-1], axes[1:]))
    return np.asarray(np.arctan2(sines, dot(axes[:-1], axes[1:])))


def spans_a_joint(axes: Floats) -> bool:
    """Return whether turns about these axes through one point make a universal or a spherical joint."""
    between = angles_between(axes)
    if np.any(np.minimum(between, math.pi - between) < PARALLEL):
        return False
    return len(axes) == 2 or bool(np.all(np.abs(dot(axes[:-1], axes[1:])) <= _PERPENDICULAR))


def lock_angles(axes: Floats) -> tuple[float, float]:
    """Return the two values of the middle angle, in (−π, π], at which the third axis is parallel to the first.

    With δ the angle from a1 to a3 about a2 they are −δ and π − δ.
    """
    first, second, third = axes
    delta = math.atan2(float(second @ np.cross(first, third)), float(first @ third))
    angles = (-delta, math.pi - delta)
    lower, upper = sorted(angle - TURN * math.ceil((angle - math.pi) / TURN) + 0.0 for angle in angles)
    return lower, upper


# --- The joint axes of a robot as lines in space, and their Jacobian, computed independently of Pinocchio.


class JointAxes:
    """All moving joints of a robot as lines, and the Jacobian that these lines make.

    Positions come from the robot's forward kinematics, directions and couplings from its URDF.

    Attributes:
        robot: the robot.
        names: its m moving joints, mimic joints included.
        sliding: which of them are prismatic, shape (m,).

    Examples:
        >>> axes = nk.joints.JointAxes(nk.load_nao())
        >>> len(axes.names), axes.names[0]
        (42, 'HeadYaw')
    """

    def __init__(self, robot: RobotModel) -> None:
        table = robot.joints
        self.robot, self.names, self._links, self._directions = robot, table.names, table.links, table.axes
        self.sliding: NDArray[np.bool_] = table.slides

    def lines(self, q: ArrayLike) -> PluckerLine:
        """Return the axes in the root's frame, moments about its origin; batch shape (..., m), in the order of `names`.

        The line of a prismatic joint passes through the joint's origin, because only its direction matters.

        Args:
            q: configurations, shape (..., nq).

        Examples:
            >>> nao = nk.load_nao()
            >>> nk.joints.JointAxes(nao).lines(nao.neutral()).direction[0].round(9).tolist()
            [0.0, 0.0, 1.0]
        """
        # A joint's frame is that of the link it moves.
        poses = self.robot.fk(q, self._links)
        directions = np.einsum("...mij,mj->...mi", poses[..., :3, :3], self._directions)
        return PluckerLine.from_point_direction(poses[..., :3, 3], directions)

    def coupling(self, frame: str) -> Floats:
        """Return ∂(joint value)/∂(coordinate), shape (m, n), with zero rows for joints that do not carry the frame.

        Columns are in the order of the robot's `joint_names`: a mimic joint has its multiplier in the column of its
        driver.

        Args:
            frame: a frame name.

        Examples:
            >>> axes = nk.joints.JointAxes(nk.load_nao())
            >>> axes.coupling("RLeg")[axes.names.index("RHipYawPitch")].nonzero()[0].tolist()
            [2]
        """
        table = self.robot.joints
        rows = table.path(self.robot.frame_placement(frame)[0])
        C = np.zeros((len(self.names), len(self.robot.joint_names)))
        C[rows, table.coordinates[rows] - self.robot.nq_base] = table.multipliers[rows]
        return C

    def jacobian(self, q: ArrayLike, frame: str, expressed_in: Expression = "mixed") -> Floats:
        """Return the Jacobian of `RobotModel.jacobian`, computed from the Plücker coordinates of the axes alone.

        Args:
            q: configurations, shape (..., nq).
            frame: a frame name.
            expressed_in: as in `RobotModel.jacobian`.

        Returns:
            Shape (..., 6, n), columns in the order of `joint_names`, without those of a floating base.

        Examples:
            >>> nao = nk.load_nao()
            >>> q = nao.posture("Stand")
            >>> np.allclose(nk.joints.JointAxes(nao).jacobian(q, "LArm"), nao.jacobian(q, "LArm"))
            True
        """
        choice(expressed_in, get_args(Expression), "expression")
        coupling = self.coupling(frame)
        axes, pose = self.lines(q), self.robot.fk(q, frame)
        at = pose[..., :3, 3] if expressed_in == "mixed" else np.zeros(3)
        if expressed_in == "frame":
            axes = axes.transformed(rigid_inverse(pose)[..., None, :, :])
        return geometric_jacobian(axes, at=at, coupling=coupling, sliding=self.sliding)
