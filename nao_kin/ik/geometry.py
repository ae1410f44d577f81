"""The limbs of a robot as the closed forms need them, and closed forms run on targets.

Joints are read off the model with all of them at zero, in the axes of the torso: where each stands, and its axis. What
the closed forms suppose of these (axes that meet, are perpendicular, point along x, y or z) is verified here, and limbs
that are not a NAO's are refused.

A closed form runs as Python on one target where nothing is compiled yet, and compiled on many; its numbers are made
into an `IKResult`.
"""

from __future__ import annotations

import math
import threading
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, TypeVar, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, choice
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik.compiling import borrowed, cached_kernel, run_rows
from nao_kin.ik.ranges import (
    ANGLE_ERROR,
    BEST,
    EXTRAS,
    JOINT,
    LIMIT,
    MOST_BENDS,
    MOST_TURNED,
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
)
from nao_kin.ik.results import IKResult, Integers, Obstacles, result_made_later
from nao_kin.robot import ModelNumbers, RobotModel, check_robot

# Axes and places that are off by no more than this [rad, m] are as they should be: a URDF has so many digits.
_TOLERANCE = 1e-9

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_SIDES = ("L", "R")

_Made = TypeVar("_Made")


@dataclass(frozen=True, eq=False)
class Limb:
    """A limb that a closed form solves.

    Attributes:
        joints: its joints, from the torso outwards.
        columns: which coordinates of q move them.
        index: the same as an array, shape (c,).
        multiplier: value of a joint = multiplier · coordinate + offset; shape (c,).
        offset: of the same, shape (c,) [rad].
        ranges: limits of the joints, and of a joint whose range depends on another: `Ranges`; of two limbs, of each.
        numbers: its geometry, as its closed form takes it.
        frame: the frame whose pose is asked for.
        torso: the frame in which it is given.
        rest: the whole robot with all joints at zero, or at the limit nearest to it, shape (nq,).
        follows: whether a joint is not its coordinate itself.
    """

    joints: tuple[str, ...]
    columns: tuple[int, ...]
    index: NDArray[np.intp]
    multiplier: Floats
    offset: Floats
    ranges: Any
    numbers: Any
    frame: str
    torso: str
    rest: Floats
    follows: bool


@dataclass(frozen=True, eq=False)
class ChainAtZero:
    """The joints of a limb with all joints at zero, and a frame that the last of them carries.

    Attributes:
        robot: whose.
        limb: what it is called in messages.
        joints: the names.
        points: where they stand in the torso, shape (c, 3) [m].
        axes: their axes, unit vectors, shape (c, 3).
        rotation: of the frame, shape (3, 3).
        point: its origin, shape (3,) [m].
    """

    robot: RobotModel
    limb: str
    joints: tuple[str, ...]
    points: Floats
    axes: Floats
    rotation: Floats
    point: Floats

    def require_axis(self, index: int, axis: Sequence[float]) -> None:
        """Refuse a joint that turns about another axis.

        Raises:
            BadArgument: it does.
        """
        if np.abs(self.axes[index] - axis).max() > _TOLERANCE:
            found = ", ".join(f"{value:.6g}" for value in self.axes[index])
            wanted = "xyz"[int(np.argmax(axis))]
            raise self.missing(f"{self.joints[index]} turns about ({found}), not about {wanted}")

    def require_meeting(self, first: int, last: int) -> None:
        """Refuse joints that do not stand in one point.

        Raises:
            BadArgument: they do not.
        """
        apart = float(np.linalg.norm(self.points[last] - self.points[first]))
        if apart > _TOLERANCE:
            raise self.missing(
                f"the axes of {self.joints[first]} and {self.joints[last]} do not meet, they are {apart:.3g} m apart"
            )

    def require_zero(self, what: str, values: Floats) -> None:
        """Refuse offsets that should not be there.

        Raises:
            BadArgument: one is there.
        """
        if np.abs(values).max() > _TOLERANCE:
            raise self.missing(f"{what} by {float(np.abs(values).max()):.3g} m")

    def frame_in_link(self, origin: Floats) -> tuple[float, Rotation, Vector]:
        """Whether the frame is turned against its link, 0 or 1; its rotation, and its place from a point."""
        turned = 0.0 if np.array_equal(self.rotation, np.eye(3)) else 1.0
        return turned, tuple(self.rotation.ravel().tolist()), tuple((self.point - origin).tolist())

    def missing(self, why: str) -> BadArgument:
        """The error for a limb that the closed form does not fit."""
        return missing_geometry(self.robot, self.limb, why)


def missing_geometry(robot: RobotModel, limb: str, why: str) -> BadArgument:
    """The error for a robot that lacks what a closed form needs, with what to use instead."""
    return BadArgument(f"{robot.name} has no {limb} that the closed form fits: {why}; nk.ik.numeric takes any robot")


def check_side(side: object) -> str:
    """The side, "L" or "R".

    Raises:
        UnknownName: neither.
    """
    return choice(side, _SIDES, "side", "the sides are the robot's own, L for left and R for right")


# --- limbs are kept until the numbers of their model change ----------------------------------------------------------


class _Limbs:
    """What of one robot was asked for: limbs, and chains to be searched."""

    def __init__(self, robot: RobotModel) -> None:
        self.numbers = ModelNumbers(robot.model)
        self.limbs: dict[tuple[Any, ...], Any] = {}


_KEPT: weakref.WeakKeyDictionary[RobotModel, _Limbs] = weakref.WeakKeyDictionary()
_LOCK = threading.Lock()


def kept_limb(robot: RobotModel, make: Callable[..., _Made], *arguments: str) -> _Made:
    """What `make(robot, *arguments)` returns; made anew when somebody has written into `robot.model`.

    Raises:
        BadArgument: no robot model; or as `make`.
        UnknownName: an argument is no name.
    """
    check_robot(robot)
    for name in arguments:
        if not isinstance(name, str):
            raise UnknownName("frame", name, robot.frame_names)
    key = (make, *arguments)
    with _LOCK:
        kept = _KEPT.get(robot)
        if kept is None or kept.numbers.placements_changed():
            kept = _KEPT[robot] = _Limbs(robot)
        limb: _Made | None = kept.limbs.get(key)
    if limb is None:
        limb = kept.limbs[key] = make(robot, *arguments)
    return limb


def chain_at_zero(robot: RobotModel, limb: str, joints: tuple[str, ...], frame: str) -> ChainAtZero:
    """The joints of a limb and the frame that it carries.

    Raises:
        UnknownName: no such frame.
        BadArgument: a joint is missing, slides or hangs elsewhere, or the frame is not on the last link.
    """
    rows = {joint.name: joint for joint in robot.tree.moving_joints}
    model = robot.model
    for joint in joints:
        if joint not in rows:
            raise missing_geometry(robot, limb, f"there is no joint {quoted(joint)}")
        if rows[joint].kind == "prismatic":
            raise missing_geometry(robot, limb, f"{joint} slides")
    ids = [int(model.getJointId(joint)) for joint in joints]
    base = 1 if robot.base == "floating" else 0
    for parent, own in zip([base, *ids], ids, strict=False):
        if int(model.parents[own]) != parent:
            above = model.names[int(model.parents[own])]
            raise missing_geometry(robot, limb, f"{model.names[own]} hangs on {above}")
    place = model.frames[robot.frame_ids([frame])[0]]
    if int(place.parentJoint) != ids[-1]:
        carried = [name for name, i in robot.frame_table.items() if int(model.frames[i].parentJoint) == ids[-1]]
        raise BadArgument(f"frame {quoted(frame)} is not carried by {joints[-1]}; its frames are {', '.join(carried)}")
    T = np.linalg.inv(torso_in_trunk(robot))
    points, axes = [], []
    for joint, own in zip(joints, ids, strict=True):
        T = T @ np.array(model.jointPlacements[own].homogeneous)
        points.append(T[:3, 3])
        axes.append(T[:3, :3] @ np.array(rows[joint].axis))
    T = T @ np.array(place.placement.homogeneous)
    return ChainAtZero(robot, limb, joints, np.array(points), np.array(axes), T[:3, :3], T[:3, 3])


def limb_of(chain: ChainAtZero, frame: str, numbers: Any) -> Limb:
    """A limb with its limits and coordinates; joints that follow others are moved through these."""
    robot, joints = chain.robot, chain.joints
    mimics = [robot.mimics.get(joint) for joint in joints]
    drivers = [joint if mimic is None else mimic.joint for joint, mimic in zip(joints, mimics, strict=True)]
    columns = [robot.joint_names.index(driver) for driver in drivers]
    multiplier = np.array([1.0 if mimic is None else mimic.multiplier for mimic in mimics])
    offset = np.array([0.0 if mimic is None else mimic.offset for mimic in mimics])
    if not multiplier.all():
        raise chain.missing(f"{joints[int(np.argmin(np.abs(multiplier)))]} stands still")
    lower, upper = np.sort(multiplier * [robot.lower[columns], robot.upper[columns]] + offset, axis=0).tolist()
    tables = [table for table in robot.coupled_limits if table.joint in joints and table.of in joints]
    if len(tables) > 1:
        raise chain.missing(f"{len(tables)} of its joints have limits that depend on others")
    bends, bounds, places = 0, np.zeros((3, MOST_BENDS)), (0, 0)
    for table in tables:
        bends, places = len(table.at), (joints.index(table.joint), joints.index(table.of))
        if bends > MOST_BENDS:
            raise chain.missing(f"the table of {table.joint} has more than {MOST_BENDS} rows")
        bounds[:, :bends] = table.at, table.lower, table.upper
    at, low, high = (tuple(row) for row in bounds.tolist())
    ranges = Ranges(tuple(lower), tuple(upper), bends, at, low, high, *places)
    index = np.array(columns, dtype=np.intp) + robot.nq - len(robot.joint_names)
    return Limb(
        joints,
        tuple(index.tolist()),
        index,
        multiplier,
        offset,
        ranges,
        numbers,
        frame,
        torso_frame(robot),
        robot.clamp(robot.neutral()),
        follows=bool(np.any(multiplier != 1.0) or offset.any()),
    )


def torso_frame(robot: RobotModel) -> str:
    """The frame in which targets are given: the one that people call the torso, or the root link."""
    root = robot.semantics.root
    return root if root in robot.frame_table else robot.tree.root


def torso_in_trunk(robot: RobotModel) -> Floats:
    """The torso's frame in the trunk, the body that carries all limbs."""
    place = robot.model.frames[robot.frame_ids([torso_frame(robot)])[0]]
    if int(place.parentJoint) != (1 if robot.base == "floating" else 0):
        raise missing_geometry(robot, "torso", f"{torso_frame(robot)} is carried by a joint")
    return np.array(place.placement.homogeneous)


# --- Closed forms run on targets.

# Where in a row that a kernel writes the report begins; the number of branches stands before it.
REPORT = 1


class ClosedForm:
    """A closed form of a limb, and the kernel that solves rows of targets with it.

    The kernel writes a row for each target: how many branches there are, the report, and the branches as far as there
    is room.

    Args:
        name: of the kernel.
        solve: solves one target, as `ranges` says.
        types: makes the types of a limb's geometry and of its limits.
        max_branches: the most that `solve` finds.
        alone: `solve`, or the part of it without search, which solves one target as Python; None where all of it is a
            search. Where it finds nothing, the kernel searches for the nearest pose.
        usual: how many branches there are inside the limits; where there are more, all targets are solved once more.
        more: how many numbers follow the joints in a report.
        scratch: how many numbers are needed in q beside the joints.
        seconds: about how long the kernel takes to compile [s].
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

        def run(limb: Any, ranges: Any, targets: Floats, references: Floats, enforce: bool, out: Floats) -> None:
            joints = references.shape[1]
            branches = REPORT + BEST + joints + more
            owner = np.empty(joints + scratch + max_branches * (joints + EXTRAS))
            q, found = borrowed(owner[: joints + scratch]), borrowed(owner[joints + scratch :])
            targets, references, out = borrowed(targets), borrowed(references), borrowed(out)
            for i in range(targets.shape[0]):
                work = Workspace(q, found, out[i, REPORT:branches])
                count = solve(limb, targets[i], Selection(ranges, references[i], enforce), work)
                out[i, 0] = count
                write_branches(found, count, joints, out[i, branches:])
            owner[0] = 0.0  # used once more, as `borrowed` asks

        def signature() -> tuple[Any, ...]:
            import numba

            rows = numba.float64[:, ::1]
            return *types(), rows, rows, numba.boolean, rows

        run.__module__ = solve.__module__  # which a process that compiles it has to import
        self.kernel = cached_kernel(name, signature, seconds)(run)


def limb_types(numbers: type[Any], joints: int) -> tuple[Any, Any]:
    """Numba's types of a limb's geometry and of its limits.

    Args:
        numbers: the named tuple of a limb's geometry: numbers, and tuples of numbers.
        joints: how many joints the limb has.
    """
    from numba import types

    lengths = [len(get_args(hint)) for hint in get_type_hints(numbers).values()]
    parts = [types.UniTuple(types.float64, length) if length else types.float64 for length in lengths]
    limits, table = types.UniTuple(types.float64, joints), types.UniTuple(types.float64, MOST_BENDS)
    ranges = limits, limits, types.int64, table, table, table, types.int64, types.int64
    return types.NamedTuple(parts, numbers), types.NamedTuple(ranges, Ranges)


class Found(NamedTuple):
    """What a closed form writes for n targets.

    Attributes:
        rows: for each target the number of its solutions, its report and its branches, shape (n, _).
        joints: how many joints the limb has.
        length: how long a report is.
    """

    rows: Floats
    joints: int
    length: int

    @property
    def is_complete(self) -> bool:
        """Whether there is a solution for every target."""
        rows = self.rows
        return bool(rows[0, 0] > 0.0 if len(rows) == 1 else (rows[:, 0] > 0.0).all())

    @property
    def counts(self) -> Integers:
        """How many solutions there are, shape (n,)."""
        return self.rows[:, 0].astype(np.int64)

    @property
    def report(self) -> Floats:
        """Shape (n, BEST + c + more)."""
        return self.rows[:, REPORT : REPORT + self.length]

    @property
    def branches(self) -> Floats:
        """Joint values, distance, errors in position and angle, and family of each, shape (n, k, c + 4)."""
        most = int(self.rows[0, 0] if len(self.rows) == 1 else self.rows[:, 0].max(initial=0.0))
        width, first = self.joints + EXTRAS, REPORT + self.length
        return self.rows[:, first : first + most * width].reshape(len(self.rows), most, width)


def solved(
    form: ClosedForm,
    limb: Limb,
    targets: Floats,
    references: tuple[Floats, tuple[str, ...]],
    enforce: bool,
    threads: int | None,
    refuse: Callable[[], object] = lambda: None,
) -> IKResult:
    """Solve targets, shape (..., m), see `found_for`."""
    found = found_for(form, limb, targets, references[0], enforce, threads, refuse)
    return result_of(limb, targets.shape[:-1], found, references)


def found_for(
    form: ClosedForm,
    limb: Limb,
    targets: Floats,
    reference: Floats,
    enforce: bool,
    threads: int | None,
    refuse: Callable[[], object] = lambda: None,
) -> Found:
    """What a closed form finds for targets, shape (..., m).

    Args:
        form: how.
        limb: of which limb.
        targets: what `form.alone` takes, one row for each.
        reference: configurations of shape (..., nq) that broadcast with the targets.
        enforce: leave out branches outside the limits.
        threads: how many; None for all cores where that is worthwhile.
        refuse: raises for the first target that cannot be one.
    """
    batch, c = targets.shape[:-1], len(limb.joints)
    joints = reference[..., limb.index]
    if limb.follows:
        joints = joints * limb.multiplier + limb.offset
    # As the kernel is compiled for: one type of array.
    joints = _plain((np.broadcast_to(joints, (*batch, c)) if batch else joints).reshape(-1, c))
    flat = _plain(targets.reshape(math.prod(batch), targets.shape[-1]))
    if batch:
        # Room for the usual number of branches; for all where there are more.
        room = min(form.usual, form.max_branches) if enforce else form.max_branches
        found = _by_kernel(form, limb, flat, joints, enforce, room, threads)
        if found.rows[:, 0].max(initial=0.0) > room:
            found = _by_kernel(form, limb, flat, joints, enforce, form.max_branches, threads)
        rigid = found.report[:, REASON].min(initial=0.0) != NOT_RIGID
    else:
        found = _one(form, limb, flat, joints, enforce)
        rigid = found.rows[0, REPORT + REASON] != NOT_RIGID
    if not rigid:
        refuse()
    if not enforce and not found.is_complete:
        # The nearest poses of targets that are missed, turned to within half a turn of the reference.
        missed, report = found.rows[:, 0] == 0.0, found.report
        near, best = joints[missed], report[missed, BEST : BEST + c]
        turns = np.floor((near - best) / (2.0 * math.pi) + 0.5)
        report[missed, BEST : BEST + c] = best + 2.0 * math.pi * np.where(np.abs(near) > MOST_TURNED, 0.0, turns)
    return found


def _one(form: ClosedForm, limb: Limb, target: Floats, reference: Floats, enforce: bool) -> Found:
    """One target: by the kernel where it is in memory, else by the function as it stands in Python."""
    quick = form.kernel.entry_point
    if quick is not None:
        found = _space(form, limb, 1, form.max_branches)
        quick(limb.numbers, limb.ranges, target, reference, enforce, found.rows)
        return found
    if form.alone is not None:
        c = len(limb.joints)
        values = [0.0] * (form.max_branches * (c + EXTRAS))
        report = [0.0] * BEST + [math.nan] * (c + form.more)
        selection = Selection(limb.ranges, reference[0].tolist(), enforce)
        work = Workspace([0.0] * (c + form.scratch), values, report)
        count = form.alone(limb.numbers, target[0].tolist(), selection, work)
        if count > 0 or not form.searches or report[REASON] == NOT_RIGID:
            return Found(np.array([[count, *report, *values]]), c, len(report))
    return _by_kernel(form, limb, target, reference, enforce, form.max_branches, 1)


def _by_kernel(
    form: ClosedForm, limb: Limb, targets: Floats, references: Floats, enforce: bool, room: int, threads: int | None
) -> Found:
    """Targets by the kernel's function, with room for so many branches of each."""
    found = _space(form, limb, len(targets), room)

    def solve(function: Callable[..., object], part: slice) -> None:
        function(limb.numbers, limb.ranges, targets[part], references[part], enforce, found.rows[part])

    run_rows(form.kernel, solve, len(targets), threads)
    return found


def _space(form: ClosedForm, limb: Limb, n: int, room: int) -> Found:
    """An array for what is found of n targets, with room for so many branches of each."""
    c = len(limb.joints)
    length = BEST + c + form.more
    return Found(np.empty((n, REPORT + length + room * (c + EXTRAS))), c, length)


def _plain(rows: Floats) -> Floats:
    """The same numbers in the order of C, aligned, and writeable."""
    return rows if rows.flags.carray else np.array(rows, order="C")


def result_of(limb: Limb, batch: tuple[int, ...], found: Found, references: tuple[Floats, tuple[str, ...]]) -> IKResult:
    """The `IKResult` for targets of a batch shape."""
    if batch:
        return IKResult(**parts_of_result(limb, batch, found, references))
    return result_made_later(partial(parts_of_result, limb, batch, found, references), references[1])


def parts_of_result(
    limb: Limb, batch: tuple[int, ...], found: Found, references: tuple[Floats, tuple[str, ...]]
) -> dict[str, Any]:
    """What an `IKResult` for targets of a batch shape is made of."""
    reference, notes = references
    c, branches = len(limb.joints), found.branches
    report = found.report.reshape(*batch, found.length)
    branches = branches.reshape(*batch, *branches.shape[1:])
    values, best = branches[..., :c], report[..., BEST : BEST + c]
    if limb.follows:
        values, best = (values - limb.offset) / limb.multiplier, (best - limb.offset) / limb.multiplier
    joint, needed, limit = (np.asarray(report[..., place]) for place in (JOINT, NEEDED, LIMIT))
    return {
        "joints": limb.joints,
        "columns": limb.columns,
        "reference": reference,
        "best": best,
        "branches": values,
        "families": branches[..., c + 3].astype(np.int8),
        "count": found.counts.reshape(batch),
        "reasons": np.asarray(report[..., REASON], dtype=np.int8),
        "residual": report[..., POSITION_ERROR : ANGLE_ERROR + 1],
        "obstacles": Obstacles(joint.astype(np.int64), needed, limit),
        "notes": notes,
    }
