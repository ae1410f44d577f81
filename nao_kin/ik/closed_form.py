"""The limbs of a robot for the closed forms, and running the closed forms on targets.

The positions and axes of the joints are read from the model, in the axes of the torso, with each joint at the value at
which the axes are those of the closed form. This value is zero, unless the robot is calibrated or counts from another
zero; a closed form counts from it. The assumptions of the closed forms (axes that meet, are perpendicular, point along
x, y or z) are verified here; other limbs are rejected.

A closed form runs as Python for one target while nothing is compiled yet, and compiled for many.
"""

from __future__ import annotations

import math
import time
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, choice, join_poses
from nao_kin._core.text import quoted
from nao_kin._kernels.cache import READ_SECONDS, CachedKernel, Floats1, Floats2, numba_type
from nao_kin._kernels.rows import borrowed, packed, register_borrowed, register_unpacking, run_rows
from nao_kin.errors import BadArgument
from nao_kin.ik.branches import (
    ANGLE_ERROR,
    BEST,
    EXTRAS,
    JOINT,
    LIMIT,
    MAX_BENDS,
    NEEDED,
    NOT_RIGID,
    POSITION_ERROR,
    REASON,
    Ranges,
    Rotation,
    Selection,
    Vector,
    Workspace,
    write_branches,
    write_coordinates,
    write_values,
)
from nao_kin.ik.results import IKResult, Obstacles, deferred_result
from nao_kin.ik.targets import Options
from nao_kin.robot import ModelNumbers, RobotModel
from nao_kin.robot.semantics import Mimic
from nao_kin.rotations import exp, nearest_rotation, quat_from_matrix, quat_to_xyzw

# Tolerance of axes and positions [rad, m]: a URDF rounds its numbers.
TOLERANCE = 1e-9
_AXES = dict(zip("xyz", np.eye(3), strict=True))

_SIDES = ("L", "R")

_Made = TypeVar("_Made")


@dataclass(frozen=True, eq=False)
class Limb:
    """A limb that a closed form solves, with c joints from the torso outwards."""

    joints: tuple[str, ...]
    columns: tuple[int, ...]  # indices of the coordinates that move the joints in q
    index: NDArray[np.intp]  # `columns` as an array
    zeros: Floats  # values of the joints at which the axes are those of the closed form, shape (c,)
    multiplier: Floats  # value in the closed form, from `zeros` = multiplier · coordinate + offset, shapes (c,)
    offset: Floats
    ranges: Any  # limits of these values: `Ranges`, or `LegsRanges` of both legs
    numbers: Any  # its geometry, the first argument of its closed form
    frame: str  # the frame whose pose is the target
    torso: str  # the frame in which targets are given
    rest: Floats  # all joints at zero, or at the limit nearest to it, shape (nq,)

    @cached_property
    def motors(self) -> Floats:
        """Multipliers, offsets and zeros for kernels, shape (3c,)."""
        return np.concatenate([self.multiplier, self.offset, self.zeros])

    @cached_property
    def at_rest(self) -> Floats:
        """The coordinates at rest, shape (1, c); read only."""
        return self.rest[self.index][None]

    @cached_property
    def packed(self) -> Floats:
        """Its geometry and limits in one array, for kernels."""
        return packed((self.numbers, self.ranges))

    def coordinates(self, values: Floats) -> Floats:
        """Return the coordinates for values in the closed form, shape (..., c)."""
        return (values - self.offset) / self.multiplier


@dataclass(frozen=True, eq=False)
class ChainAtZero:
    """The joints of a limb at the zeros of its closed form, and a frame on its last link, in the torso."""

    robot: RobotModel
    limb: str  # name in messages
    joints: tuple[str, ...]
    zeros: Floats  # values of the joints, shape (c,)
    points: Floats  # on the axes of the joints, shape (c, 3) [m]
    axes: Floats  # unit vectors, shape (c, 3)
    rotation: Floats  # of the frame
    point: Floats  # the frame's origin [m]

    def require_axis(self, index: int, axis: ArrayLike) -> None:
        """Raise if a joint turns about another axis."""
        if np.abs(self.axes[index] - axis).max() > TOLERANCE:
            actual = ", ".join(f"{value:.6g}" for value in self.axes[index])
            wanted = "xyz"[int(np.argmax(axis))]
            raise self.error(f"{self.joints[index]} turns about ({actual}), not about {wanted}")

    def require_meeting(self, *pairs: tuple[int, int]) -> None:
        """Raise if two joints of a pair are not at one point."""
        for one, other in pairs:
            gap = float(np.linalg.norm(self.points[other] - self.points[one]))
            if gap > TOLERANCE:
                names = f"{self.joints[one]} and {self.joints[other]}"
                raise self.error(f"the axes of {names} do not meet, they are {gap:.3g} m apart")

    def require_zero(self, what: str, values: Floats) -> None:
        """Raise if some of the values are not zero [m]."""
        if np.abs(values).max() > TOLERANCE:
            raise self.error(f"{what} by {float(np.abs(values).max()):.3g} m")

    def frame_in_link(self, origin: Floats) -> tuple[float, Rotation, Vector]:
        """Return 1 if the frame is rotated in its link, else 0; its rotation; and its position from `origin`."""
        turned = 0.0 if np.array_equal(self.rotation, np.eye(3)) else 1.0
        rotation, point = self.rotation.ravel().tolist(), (self.point - origin).tolist()
        return turned, cast(Rotation, tuple(rotation)), cast(Vector, tuple(point))

    def error(self, why: str) -> BadArgument:
        """Return the error for a limb that the closed form does not fit."""
        return geometry_error(self.robot, self.limb, why)


def geometry_error(robot: RobotModel, limb: str, why: str) -> BadArgument:
    """Return the error for a robot without a limb of this geometry, with what to use instead."""
    return BadArgument(f"{robot.name} has no {limb} that the closed form fits: {why}; nk.ik.numeric takes any robot")


def check_side(side: object, limb: str) -> str:
    """Return the side, "L" or "R", of a side or an end effector such as "LArm", or raise UnknownName."""
    if isinstance(side, str) and side.removesuffix(limb) in _SIDES:
        return side.removesuffix(limb)
    return choice(side, _SIDES, "side", "the sides are the robot's own, L for left and R for right")


# --- Limbs are cached until the numbers of their model change.


class _Cache:
    """The limbs and chains of one robot, and the numbers of its model when they were made."""

    def __init__(self, robot: RobotModel) -> None:
        self.numbers = ModelNumbers(robot.model)
        # Each with the frames on which it depends; None for all.
        self.limbs: dict[tuple[Any, ...], tuple[Any, Any]] = {}

    def frames_of(self, robot: RobotModel, arguments: tuple[str, ...]) -> Any:
        """Return the frames on which a limb depends; None if they are not known, for a frame under a former name."""
        names = {*arguments, torso_frame(robot), robot.tree.root}
        ids = {robot.frame_table.get(name, -1) for name in names if name in robot.frame_table or name not in _SIDES}
        return None if -1 in ids else self.numbers.some_frames(ids)


_CACHES: weakref.WeakKeyDictionary[RobotModel, _Cache] = weakref.WeakKeyDictionary()


def cached_limb(robot: RobotModel, make: Callable[..., _Made], *arguments: str) -> _Made:
    """Return `make(robot, *arguments)`, computed again if `robot.model` has changed since the last call.

    The arguments are sides and frames. `make` may depend on the placements of all joints and of these frames, the torso
    and the root.
    """
    cache = _CACHES.get(robot)
    key = (make, *arguments)
    try:
        limb, frames = (None, None) if cache is None else cache.limbs.get(key, (None, None))
    except TypeError:  # an array, in the place of a name
        robot.frame_ids(arguments)
        raise
    if cache is None or cache.numbers.placements_changed(frames):
        # Two threads may do this at a time; each then uses its own.
        cache = _CACHES[robot] = _Cache(robot)
        limb = None
    if limb is None:
        limb = make(robot, *arguments)
        cache.limbs[key] = limb, cache.frames_of(robot, arguments)
    made: _Made = limb
    return made


def chain_at_zero(robot: RobotModel, limb: str, joints: tuple[str, ...], axes: str, frame: str) -> ChainAtZero:
    """Return the joints of a limb at its closed form's zeros, and the frame on its last link.

    Refuse missing, prismatic or reordered joints, and joints that turn about other axes than these; "?" is any axis.
    A joint is at zero in the closed form if the next one turns about its own axis there; of parallel axes, if the next
    is below. The last joint is at zero if the axes of its link are parallel to the torso's.
    """
    table, model = robot.joints, robot.model
    for joint in joints:
        if joint not in table.names:
            raise geometry_error(robot, limb, f"there is no joint {quoted(joint)}")
        if table.kinds[table.row(joint)] == "prismatic":
            raise geometry_error(robot, limb, f"{joint} slides")
    rows = [table.row(joint) for joint in joints]
    for joint, parent, own in zip(joints, [-1, *rows], rows, strict=False):
        above = int(table.parents[own])
        if above != parent:
            carrier = robot.tree.root if above < 0 else table.names[above]
            raise geometry_error(robot, limb, f"{joint} is carried by {carrier}")
    row, T_joint_frame = robot.frame_placement(frame)
    if row != rows[-1]:
        first = int(model.njoints) - len(table.names)
        carried = [name for name, i in robot.frame_table.items() if model.frames[i].parentJoint - first == rows[-1]]
        raise BadArgument(f"frame {quoted(frame)} is not carried by {joints[-1]}; its frames are {', '.join(carried)}")
    T = np.linalg.inv(torso_in_trunk(robot))
    zeros, points, directions = np.zeros(len(rows)), [], []
    for k, own in enumerate(rows):
        T = T @ table.placements[own]
        points.append(T[:3, 3])
        directions.append(T[:3, :3] @ table.axes[own])
        if k + 1 < len(rows):
            T_next, wanted = T @ table.placements[rows[k + 1]], _AXES[axes[k + 1]]
            actual = T_next[:3, :3] @ table.axes[rows[k + 1]]
            if axes[k + 1] == axes[k]:
                actual, wanted = T_next[:3, 3] - T[:3, 3], -_AXES["z"]
            zeros[k] = _angle_about(directions[k], actual, wanted)
        else:
            zeros[k] = _zero_of_last(T[:3, :3], directions[k], _motors_of(robot, joints[k:])[3])
        if zeros[k] != 0.0:
            T = T @ join_poses(exp(zeros[k] * table.axes[own]), np.zeros(3))
    T = T @ T_joint_frame
    chain = ChainAtZero(robot, limb, joints, zeros, np.array(points), np.array(directions), T[:3, :3], T[:3, 3])
    for k, axis in enumerate(axes):
        if axis in _AXES:
            chain.require_axis(k, _AXES[axis])
    return chain


def _zero_of_last(R: Floats, axis: Floats, limits: Floats) -> float:
    """Return the value of the last joint at which its link, at R, has axes parallel to the torso's.

    Of several, it is the one nearest to zero, or to the middle of limits that are more than half a turn away. If there
    is none, any value will do.
    """
    near = limits.mean() if math.pi < np.abs(limits).max() < math.inf else 0.0
    angle, quarter = _angle_about(axis, R[:, 2], _AXES["z"]), 0.5 * math.pi
    aligned = exp(angle * axis) @ R
    if np.abs(aligned - np.round(aligned)).max() > TOLERANCE:
        return float(near)
    return float(angle + quarter * np.round((near - angle) / quarter))


def _angle_about(axis: Floats, actual: Floats, wanted: Floats) -> float:
    """Return the angle about an axis by which one vector turns to the direction of another; 0 within the tolerance."""
    sine, cosine = axis @ np.cross(actual, wanted), actual @ wanted - (axis @ actual) * (axis @ wanted)
    angle = math.atan2(sine, cosine)
    return angle if abs(angle) > TOLERANCE else 0.0


def limb_of(chain: ChainAtZero, frame: str, numbers: Any) -> Limb:
    """Return a limb with its limits and coordinates; mimic joints are moved by the joints that drive them."""
    robot, joints = chain.robot, chain.joints
    columns, multiplier, offset, limits = _motors_of(robot, joints)
    if not multiplier.all():
        raise chain.error(f"{joints[int(np.argmin(np.abs(multiplier)))]} does not move")
    # Of the zeros that differ by whole turns, the one nearest to the middle of the joint's range.
    middle = np.where(np.isfinite(limits).all(axis=0), limits, chain.zeros).mean(axis=0)
    zeros = chain.zeros + 2.0 * math.pi * np.round((middle - chain.zeros) / (2.0 * math.pi))
    tables = [table for table in robot.coupled_limits if table.joint in joints and table.of in joints]
    if len(tables) > 1:
        raise chain.error(f"{len(tables)} of its joints have limits that depend on others")
    bends, bounds, places = 0, np.zeros((3, MAX_BENDS)), (0, 0)
    for table in tables:
        bends, places = len(table.at), (joints.index(table.joint), joints.index(table.of))
        if bends > MAX_BENDS:
            raise chain.error(f"the table of {table.joint} has more than {MAX_BENDS} rows")
        bounds[:, :bends] = table.at, table.lower, table.upper
    lower, upper, at, low, high = (tuple(row) for row in (*limits.tolist(), *bounds.tolist()))
    ranges = shifted(Ranges(lower, upper, bends, at, low, high, *places), zeros)
    offset = offset - zeros
    index = np.array(columns, dtype=np.intp) + robot.nq_base
    motors = tuple(index.tolist()), index, zeros, multiplier, offset
    return Limb(joints, *motors, ranges, numbers, frame, torso_frame(robot), robot.clamp(robot.neutral()))


def _motors_of(robot: RobotModel, joints: tuple[str, ...]) -> tuple[list[int], Floats, Floats, Floats]:
    """Return the coordinates of joints, their multipliers and offsets (c,), and the limits of the joints (2, c)."""
    drivers = [robot.mimics.get(joint, Mimic(joint)) for joint in joints]
    columns = [robot.joint_names.index(driver.joint) for driver in drivers]
    multiplier, offset = np.array([(driver.multiplier, driver.offset) for driver in drivers]).T
    limits = multiplier * [robot.lower[columns], robot.upper[columns]] + offset
    return columns, multiplier, offset, np.sort(limits, axis=0)


def shifted(ranges: Ranges, zeros: Floats) -> Ranges:
    """Return the limits of values that are counted from these values of the joints, shape (c,)."""
    lower, upper, bends, at, low, high, joint, of = ranges
    changes = ((lower, zeros), (upper, zeros), (at, zeros[of]), (low, zeros[joint]), (high, zeros[joint]))
    lower, upper, at, low, high = (tuple((np.array(row) - zero).tolist()) for row, zero in changes)
    return Ranges(lower, upper, bends, at, low, high, joint, of)


def torso_frame(robot: RobotModel) -> str:
    """Return the frame in which targets are given: the semantics' root frame if there is one, else the root link."""
    root = robot.semantics.root
    return root if root in robot.frame_table else robot.tree.root


def torso_in_trunk(robot: RobotModel) -> Floats:
    """Return the pose of the torso's frame in the trunk, the body that carries all limbs, shape (4, 4)."""
    row, T_root_torso = robot.frame_placement(torso_frame(robot))
    if row >= 0:
        raise geometry_error(robot, "torso", f"{torso_frame(robot)} is carried by a joint")
    return T_root_torso


def base_coordinates(robot: RobotModel, torso: Floats) -> Floats:
    """Return the first seven entries of q for poses of the torso in the world: position and quaternion of the root."""
    root = torso @ np.linalg.inv(torso_in_trunk(robot))
    quaternions = quat_to_xyzw(quat_from_matrix(nearest_rotation(root[..., :3, :3])))
    return np.concatenate([root[..., :3, 3], quaternions], axis=-1)


# --- Closed forms run on targets.

# In a row that a kernel writes, the report follows the number of branches.
REPORT = 1


class ClosedForm:
    """A closed form of a limb, and the kernel that solves rows of targets with it.

    The kernel writes a row for each target: the number of branches, the report, and as many branches as fit. `solve`
    solves one target with at most `max_branches` branches. `alone` solves one as Python: it is `solve`, its part
    without search, or None if all of it is a search. If `alone` finds nothing, the kernel searches for the nearest
    pose. If a target has more than the `usual` number of branches, all are solved again with more space. In a report,
    `more` numbers follow the joints; `scratch` numbers follow them in q. `types` returns Numba's types of geometry and
    limits; compiling takes `seconds`. References and rows have coordinates, `solve` has the values of the joints.
    """

    def __init__(
        self,
        name: str,
        solve: Callable[..., int],
        types: Callable[[], tuple[Any, Any]],
        max_branches: int,
        *,
        alone: Callable[..., int] | None,
        usual: int = 2,
        more: int = 0,
        scratch: int = 0,
        seconds: float = 10.0,
    ) -> None:
        self.alone, self.searches, self.max_branches = alone, alone is not solve, max_branches
        self.usual, self.more, self.scratch = usual, more, scratch

        def unpacked(numbers: Any) -> Any:
            return numbers  # as Python, `run` takes the tuples themselves

        def run(numbers: Any, motors: Floats, targets: Floats, near: Floats, enforce: bool, out: Floats) -> None:
            joints = near.shape[1]
            first = REPORT + BEST + joints + more
            limb, ranges = unpacked(numbers)
            owner = np.empty(2 * joints + scratch + max_branches * (joints + EXTRAS))
            reference, q = borrowed(owner[:joints]), borrowed(owner[joints : 2 * joints + scratch])
            branches = borrowed(owner[2 * joints + scratch :])
            motors, targets, near, out = borrowed(motors), borrowed(targets), borrowed(near), borrowed(out)
            for i in range(targets.shape[0]):
                write_values(motors, near[i], reference)
                selection, work = Selection(ranges, reference, enforce), Workspace(q, branches, out[i, REPORT:first])
                count = solve(limb, targets[i], selection, work)
                write_coordinates(motors, selection, work, count)
                out[i, 0] = count
                write_branches(branches, count, joints, out[i, first:])
            owner[0] = 0.0  # used once more, as `borrowed` requires

        def signature() -> tuple[Any, ...]:
            register_borrowed()
            register_unpacking(unpacked, types())
            return tuple(map(numba_type, (Floats1, Floats1, Floats2, Floats2, bool, Floats2)))

        run.__module__ = solve.__module__  # the module that a compiling process has to import
        self.kernel = CachedKernel(
            run, f"a kernel of inverse kinematics, {name}", f"ik kernel, {name}", signature, seconds
        )


def limb_types(numbers: type[Any], joints: int) -> tuple[Any, Any]:
    """Return Numba's types of a limb's geometry and of its limits."""
    from numba import types

    limits, table = types.UniTuple(types.float64, joints), types.UniTuple(types.float64, MAX_BENDS)
    ranges = limits, limits, types.int64, table, table, table, types.int64, types.int64
    return numba_type(numbers), types.NamedTuple(ranges, Ranges)


class KernelOutput(NamedTuple):
    """The output of a closed form for n targets of a limb with c joints."""

    rows: Floats  # number of branches, a report of `length` numbers, and the branches, for each target
    joints: int
    length: int

    @property
    def is_complete(self) -> bool:
        """Whether every target has a solution."""
        rows = self.rows
        return rows.item(0) > 0.0 if len(rows) == 1 else bool((rows[:, 0] > 0.0).all())

    @property
    def report(self) -> Floats:
        """The reports, shape (n, BEST + c + more)."""
        return self.rows[:, REPORT : REPORT + self.length]

    @property
    def branches(self) -> Floats:
        """Joint values, distance, errors in position and angle, and family of each, shape (n, k, c + 4)."""
        count = int(self.rows[0, 0] if len(self.rows) == 1 else self.rows[:, 0].max(initial=0.0))
        width, first = self.joints + EXTRAS, REPORT + self.length
        return self.rows[:, first : first + count * width].reshape(len(self.rows), count, width)


def solve_targets(
    form: ClosedForm, limb: Limb, targets: Floats, options: Options, refuse: Callable[[], object] = lambda: None
) -> KernelOutput:
    """Solve targets of shape (..., m) with a closed form; the output has coordinates.

    `refuse` raises for the first target that is not rigid.
    """
    enforce, batch, c = options.enforce, targets.shape[:-1], len(limb.joints)
    joints = limb.at_rest if options.near is limb.rest else options.near[..., limb.index]
    if batch:
        # The kernel is compiled for one type of array.
        joints = _contiguous(np.broadcast_to(joints, (*batch, c)).reshape(-1, c))
        flat = _contiguous(targets.reshape(math.prod(batch), targets.shape[-1]))
        # First with space for the usual number of branches; if there are more, again with space for all.
        space = min(form.usual, form.max_branches) if enforce else form.max_branches
        output = _solve_by_kernel(form, limb, flat, joints, enforce, space, options.threads)
        if output.rows[:, 0].max(initial=0.0) > space:
            output = _solve_by_kernel(form, limb, flat, joints, enforce, form.max_branches, options.threads)
    else:
        joints = joints.reshape(1, c)
        output = _solve_one(form, limb, _contiguous(targets.reshape(1, targets.size)), joints, enforce)
    if not output.is_complete and output.report[:, REASON].min(initial=0.0) == NOT_RIGID:
        refuse()
    return output


def _solve_one(form: ClosedForm, limb: Limb, target: Floats, reference: Floats, enforce: bool) -> KernelOutput:
    """Solve one target, with the kernel if it is in memory or worth loading, else as Python."""
    quick = form.kernel.entry_point
    if quick is not None:
        output = _empty_output(form, limb, 1, form.max_branches)
        quick(limb.packed, limb.motors, target, reference, enforce, output.rows)
        return output
    is_early = form.kernel.python_seconds < READ_SECONDS
    if form.alone is not None and (is_early or not form.kernel.is_worthwhile()):
        started, c = time.perf_counter(), len(limb.joints)
        values = [0.0] * (form.max_branches * (c + EXTRAS))
        report = [0.0] * BEST + [math.nan] * (c + form.more)
        near, motors = [0.0] * c, limb.motors.tolist()
        write_values(motors, reference[0].tolist(), near)
        selection, work = Selection(limb.ranges, near, enforce), Workspace([0.0] * (c + form.scratch), values, report)
        count = form.alone(limb.numbers, target[0].tolist(), selection, work)
        write_coordinates(motors, selection, work, count)
        form.kernel.python_seconds += time.perf_counter() - started
        if count > 0 or not form.searches or report[REASON] == NOT_RIGID:
            return KernelOutput(np.array([[count, *report, *values]]), c, len(report))
    return _solve_by_kernel(form, limb, target, reference, enforce, form.max_branches, 1)


def _solve_by_kernel(
    form: ClosedForm, limb: Limb, targets: Floats, references: Floats, enforce: bool, space: int, threads: int | None
) -> KernelOutput:
    """Solve targets with the kernel, with space for `space` branches of each."""
    output = _empty_output(form, limb, len(targets), space)

    def solve(function: Callable[..., object], part: slice) -> None:
        numbers = (limb.numbers, limb.ranges) if function == form.kernel.uncompiled else limb.packed
        function(numbers, limb.motors, targets[part], references[part], enforce, output.rows[part])

    run_rows(form.kernel, solve, len(targets), threads)
    return output


def _empty_output(form: ClosedForm, limb: Limb, n: int, space: int) -> KernelOutput:
    c = len(limb.joints)
    length = BEST + c + form.more
    return KernelOutput(np.empty((n, REPORT + length + space * (c + EXTRAS))), c, length)


def _contiguous(rows: Floats) -> Floats:
    """Return the same numbers in the order of C, aligned, and writeable."""
    return rows if rows.flags.carray else np.array(rows, order="C")


def result_of(limb: Limb, batch: tuple[int, ...], output: KernelOutput, options: Options) -> IKResult:
    """Return the result for targets of a batch shape."""
    if batch:
        return IKResult(**result_fields(limb, batch, output, options))
    return deferred_result(partial(result_fields, limb, batch, output, options), options.notes)


def result_fields(limb: Limb, batch: tuple[int, ...], output: KernelOutput, options: Options) -> dict[str, Any]:
    """Return the fields of an `IKResult` for targets of a batch shape."""
    c, branches = len(limb.joints), output.branches
    report = output.report.reshape(*batch, output.length)
    branches = branches.reshape(*batch, *branches.shape[1:])
    values, best = branches[..., :c], report[..., BEST : BEST + c]
    joint = np.asarray(report[..., JOINT].astype(np.int64))
    needed, limit = (np.asarray(report[..., place]) for place in (NEEDED, LIMIT))
    return {
        "joints": limb.joints,
        "columns": limb.columns,
        "near": options.near.copy() if options.near is limb.rest else options.near,
        "best": best,
        "branches": values,
        "families": branches[..., c + 3].astype(np.int8),
        "count": output.rows[:, 0].astype(np.int64).reshape(batch),
        "reasons": np.asarray(report[..., REASON], dtype=np.int8),
        "residual": report[..., POSITION_ERROR : ANGLE_ERROR + 1],
        "obstacles": Obstacles(joint, needed, limit),
        "notes": options.notes,
    }


# --- Targets without a solution: the nearest joint values.

# Targets searched for at a time.
_BLOCK = 2048


def missed_targets(result: IKResult, options: Options) -> tuple[NDArray[np.bool_], Options]:
    """Return which targets have neither solution nor joint values, shape (...), and the options for these n targets."""
    missed = np.asarray((result.count == 0) & np.isnan(result.best).any(axis=-1))
    reference = np.broadcast_to(options.near, (*missed.shape, options.near.shape[-1]))[missed]
    return missed, options._replace(near=reference)


def solve(
    form: ClosedForm,
    limb: Limb,
    rows: Floats,
    options: Options,
    refuse: Callable[[], object] = lambda: None,
    nearest: Callable[[Floats, Options], tuple[Floats, Floats]] | None = None,
) -> IKResult:
    """Return the result for targets of shape (..., m), as `solve_targets`.

    Without a solution or joint values of the closed form, it has those from `nearest`.
    """
    output = solve_targets(form, limb, rows, options, refuse)
    result = result_of(limb, rows.shape[:-1], output, options)
    if nearest is not None and not output.is_complete:
        missed, options = missed_targets(result, options)
        blocks = [slice(k, k + _BLOCK) for k in range(0, np.count_nonzero(missed), _BLOCK)]
        values = [nearest(rows[missed][k], options._replace(near=options.near[k])) for k in blocks]
        result.best[missed], result.residual[missed] = (np.concatenate(each) for each in zip(*values, strict=True))
    return result


def unlimited_branches(form: ClosedForm, limb: Limb, targets: Floats) -> list[Floats]:
    """Return the coordinates (n, c) of each branch for targets (n, m) without limits; those at rest if missing."""
    output = solve_targets(form, limb, targets if len(targets) > 1 else targets[0], Options(limb.rest, (), False, None))
    branches = output.branches[..., : len(limb.joints)]
    return list(np.where(np.isnan(branches), limb.rest[limb.index], branches).swapaxes(0, 1))
