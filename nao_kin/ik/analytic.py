"""`analytic`: all branches of the inverse kinematics of any chain of up to six revolute joints, by EAIK.

EAIK recognises intersecting and parallel axes of a chain and reduces its inverse kinematics to geometric subproblems
with closed forms. Its answers are verified here by forward kinematics, brought into the limits by whole turns, and
completed where the axes are dependent.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import LIMIT_TOLERANCE, Floats, SolverLimits, check_tolerance, join_poses
from nao_kin._core.text import quoted
from nao_kin._core.warn import need_extra
from nao_kin._kernels.chains import Chain, chain_of
from nao_kin.errors import BadArgument, UnknownName
from nao_kin.ik.closed_form import cached_limb, torso_frame
from nao_kin.ik.least_squares import ANGLE_WEIGHT, Goal, descended
from nao_kin.ik.limit_regions import LimitRegion, Violations
from nao_kin.ik.regular_branches import PRECISE, REGULAR, SAME, TURNS, Rules, regular_branches
from nao_kin.ik.results import Codes, Family, IKResult, Integers, Obstacles, Reason, without_collisions
from nao_kin.ik.targets import as_options, rigid_poses
from nao_kin.robot import CollisionRule, RobotModel, SerialChain, serial_chain
from nao_kin.robot.semantics import Mimic
from nao_kin.rotations import exp, log, rot_z

Rows = NDArray[np.intp]

# EAIK solves up to this number of joints. It misses solutions of chains of few joints for a point on their axes, so it
# is given a point beside the frame [m]. Number of poses with which its decomposition of a chain is tried.
_MOST_JOINTS, _TIP, _PROBES = 6, np.array([0.0731, 0.1137, 0.1913]), 4
# Targets solved at a time, and the least number that is worth EAIK's threads.
_BLOCK, _FEW = 2048, 200
# Error [m, rad] below which a search refines an answer: near a singularity, square roots have half the digits.
_REFINED = 1e-3
# Angles [rad] up to which two members of families are one; up to which a search would find the same.
_SAME_MEMBER, _NEAR = 1e-4, 1e-2
# A pose beside a target [m, rad], in the target's frame.
_BESIDE = join_poses(exp(np.array([0.6, -1.1, 0.8]) * 1e-4), np.array([-0.7, 0.5, 0.9]) * 1e-4)
# Axes are dependent if a singular value of the Jacobian, with lengths in units of `ANGLE_WEIGHT`, is below this.
_SINGULAR = 1e-7
# Steps along dependent axes [rad], of which in a family a share of at least `_STAYED` stays after a search for a
# solution with this error; starts and most steps of the search for the member nearest to `near`, with an error
# below `_MEMBER`; most steps of any search.
_STEPS, _STAYED, _ON_FAMILY, _MEMBER = (-0.1, -0.03, 0.03, 0.1), 0.4, 1e-13, 1e-10
_SPREAD, _APPROACH, _SEARCH = np.linspace(-math.pi, math.pi, 9), 40, 200


def analytic(
    robot: RobotModel,
    frame: str,
    target: ArrayLike,
    *,
    reference: str | None = None,
    locked: Mapping[str, float] | None = None,
    near: ArrayLike | None = None,
    limits: SolverLimits = "enforce",
    tolerance: float = 1e-8,
    threads: SupportsIndex | None = None,
    collisions: bool | CollisionRule = False,
) -> IKResult:
    """Return all joint values that bring a frame to a pose, for any robot, by closed forms that EAIK finds.

    The joints on the way from `reference` to the frame are solved for; there may be up to six, all revolute. EAIK
    derives the closed form from their axes at zero; nothing is generated or compiled. Each answer is verified by
    forward kinematics: one with an error above `tolerance`, such as the least-squares answers of EAIK for a target
    that a chain cannot meet, is not a solution, and `notes` says how many others were left out.

    If the target is not met, `best` and `q` are the nearest joint values that a search from these answers finds, inside
    the limits if these are enforced: with the smallest √(distance² + (0.1 m · angle)²).

    Args:
        robot: any robot.
        frame: the frame to place.
        target: poses T_reference_frame, shape (..., 4, 4) [m].
        reference: the frame in which targets are given, and from which the chain begins; None for the torso, the root
            of the robot's semantics, or else the root link.
        locked: joint name → value of joints of the chain that stay there [rad, m]: a chain of seven joints has a closed
            form if the right one is locked; the error without it names these joints.
        near: as in all solvers, see `nao_kin.ik`.
        limits: as in all solvers. With "enforce", a branch is listed with all whole turns inside the limits; for a
            joint with a range of more than three turns, with those nearest to `near`.
        threads: as in all solvers.
        collisions: as in all solvers.
        tolerance: largest error of a solution in position [m] and rotation [rad].

    Returns:
        All branches inside the limits. At a singularity EAIK misses some of them: searches from its answers for poses
        beside the target find these, and `notes` says for how many targets, and for how many a search failed. If
        `near` is a solution, it is listed. Where the axes are dependent, infinitely many solutions may form a family
        (`SINGULAR`): it is listed by the member nearest to `near` that a search finds, with all whole turns inside the
        limits.

    Raises:
        MissingExtra: EAIK is not installed.
        BadArgument: the chain has no closed form that EAIK knows; the message says why. Use `numeric` then.
        UnknownName: a locked joint that the chain does not have.
        OutsideLimits: a locked joint outside its limits.
        NotARotation: the rotation of a target is not one; has the argument, its index and its defect.

    Source: Ostermeier, Külz and Althoff, Automatic Geometric Decomposition for Analytical Inverse Kinematics, IEEE RA-L
    2025.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.posture("StandInit")
        >>> result = nk.ik.analytic(nao, "LLeg", nao.fk(q, "LLeg"), limits="ignore")
        >>> bool(result.success), int(result.count)
        (True, 8)
    """
    need_extra("nk.ik.analytic", "analytic")
    check_tolerance(tolerance)
    targets = rigid_poses(target, "target")
    batch = targets.shape[:-2]
    rest = robot.clamp(robot.neutral()) if near is None else robot.neutral()
    options = as_options(robot, rest, near, batch, limits, threads)
    rows = np.array(np.broadcast_to(options.near, (*batch, robot.nq)))
    base = torso_frame(robot) if reference is None else reference
    held = {} if locked is None else _held(robot, locked, "enforce" if options.enforce else "ignore")
    limb = _limb_of(robot, frame, base, held) if held else cached_limb(robot, _limb_of, frame, base)
    rows[..., list(limb.held)] = list(limb.held.values())
    given = robot, limb, options.enforce, float(tolerance), options.threads
    flat, starts = targets.reshape(-1, 4, 4), rows.reshape(-1, robot.nq)
    blocks = [slice(k, k + _BLOCK) for k in range(0, max(1, len(flat)), _BLOCK)]
    solved = [_Problem(*given, flat[k], starts[k]).solve() for k in blocks]
    return without_collisions(robot, _joined(limb, solved, rows, options.notes), collisions)


def _held(robot: RobotModel, locked: Mapping[str, float], limits: Literal["enforce", "ignore"]) -> dict[str, float]:
    """Return the values of the coordinates of locked joints, by name."""
    q = robot.configuration(locked, limits=limits)
    names = [robot.mimics[name].joint if name in robot.mimics else name for name in locked]
    for name in names:
        if q.ndim > 1 or name not in robot.joint_names:
            raise BadArgument(f"locked must have one value for each joint, got {quoted(name)}: {quoted(locked[name])}")
    return {name: float(q[_column(robot, name)]) for name in names}


def _column(robot: RobotModel, joint: str) -> int:
    return robot.nq_base + robot.joint_names.index(joint)


# --- The geometry of a chain.


@dataclass(frozen=True, eq=False)
class _Limb:
    """The c joints of a chain that EAIK solves."""

    base: str  # the frames between which the joints are
    frame: str
    names: tuple[str, ...]  # the joints whose coordinates move them
    columns: tuple[int, ...]  # indices of these coordinates in q
    held: dict[int, float]  # index in q → value of the locked joints
    chain: Chain  # for scalar code; value of a joint = `chain.ratio` · coordinate + `chain.offset`
    length: float  # if stretched [m]
    links: Floats  # placements, shape (c + 1, 4, 4): joint k turns about z after placement k
    solver: Any  # EAIK's solver, for the poses that `_for_eaik` returns with the rotation `turn`
    turn: Floats
    limited: LimitRegion
    free: LimitRegion


def _limb_of(robot: RobotModel, frame: str, base: str, locked: Mapping[str, float] | None = None) -> _Limb:
    """Return the chain between two frames with some joints locked at values of their coordinates."""
    from eaik.IK_HP import HPRobot

    whole, held = cached_limb(robot, serial_chain, base, frame), dict(locked or {})
    for name in held:
        if name not in whole.coordinates:
            raise UnknownName("joint", name, whole.coordinates, f"only joints between {base} and {frame} can be locked")

    def error(why: str) -> BadArgument:
        where = f"{robot.name} has no closed form from {quoted(base)} to {quoted(frame)}"
        return BadArgument(f"{where}: {why}; nk.ik.numeric takes any robot")

    links, drivers, fixed = list[Floats](), list[Mimic](), np.eye(4)
    for placement, slides, driver in zip(whole.placements, whole.slides, whole.drivers, strict=False):
        fixed = fixed @ join_poses(placement[:, :3], placement[:, 3])
        if driver.joint in held or driver.multiplier == 0.0:
            value = driver.multiplier * held.get(driver.joint, 0.0) + driver.offset
            along, about = (value, 0.0) if slides else (0.0, value)
            fixed = fixed @ join_poses(rot_z(about), np.array([0.0, 0.0, along]))
            continue
        if slides:
            raise error(f"{driver.joint} slides; lock it with locked={{{driver.joint!r}: …}}")
        if driver.joint in [other.joint for other in drivers]:
            raise error(f"{driver.joint} moves two of its joints")
        links.append(fixed)
        drivers.append(driver)
        fixed = np.eye(4)
    links.append(fixed @ join_poses(whole.placements[-1][:, :3], whole.placements[-1][:, 3]))
    names = tuple(driver.joint for driver in drivers)
    if not names:
        raise BadArgument(f"no joint moves {quoted(frame)} in {quoted(base)}")
    if len(names) > _MOST_JOINTS:
        lock = f"lock {len(names) - _MOST_JOINTS} of {', '.join(names)} with locked={{…}}"
        if len(names) == _MOST_JOINTS + 1:
            fit = [name for name in names if _fits(robot, frame, base, held, name)]
            lock = f"lock {' or '.join(fit)} with locked={{…}}" if fit else "none has a closed form if one is locked"
        raise error(f"{len(names)} joints, and EAIK solves {_MOST_JOINTS}; {lock}")
    placed = np.array(links)
    axes, points, ends = _axes(placed, np.zeros((1, len(names))))
    steps = np.diff(np.concatenate([np.zeros((1, 3)), points[0], ends[:, :3, 3] + _TIP]), axis=0)
    solver, turn = HPRobot(axes[0], steps), ends[0, :3, :3].T
    if not solver.hasKnownDecomposition() or "Unknown" in solver.getKinematicFamily():
        raise error(f"EAIK knows no decomposition for the axes of {', '.join(names)}")
    # Four poses tell whether the axes are dependent everywhere, and whether EAIK solves this chain.
    probes = np.random.default_rng(0).uniform(-1.5, 1.5, (_PROBES, len(names)))
    _, sizes, right = np.linalg.svd(_jacobians(placed, probes))
    if (sizes[:, -1] < _SINGULAR).all():
        moving = ", ".join(name for name, share in zip(names, right[0, -1], strict=True) if abs(share) > _SINGULAR)
        raise error(f"{moving} always move together without moving {quoted(frame)}; lock one with locked={{…}}")
    poses = _axes(placed, probes)[2]
    for pose, given in zip(poses, _for_eaik(poses, turn), strict=True):
        found = _axes(placed, np.reshape(solver.IK(given).Q, (-1, len(names))))[2]
        if not (np.abs(found - pose).max(axis=(-1, -2)) < _REFINED).any():
            raise error(f"EAIK's decomposition, {solver.getKinematicFamily()}, misses solutions for {', '.join(names)}")
    joints = np.array([robot.joint_names.index(name) for name in names], dtype=np.intp)
    reduced = SerialChain(np.ascontiguousarray(placed[:, :3]), (False,) * len(names), tuple(drivers))
    columns = tuple(_column(robot, name) for name in names)
    values = {_column(robot, name): value for name, value in held.items()}
    geometry = chain_of([reduced], names), reduced.length(robot), placed, solver, turn
    regions = LimitRegion(robot, joints), LimitRegion(robot, joints, enforced=False)
    return _Limb(base, frame, names, columns, values, *geometry, *regions)


def _fits(robot: RobotModel, frame: str, base: str, held: Mapping[str, float], name: str) -> bool:
    """Return whether a chain has a closed form if one more joint is locked, at a value that is nothing special."""
    place = robot.joint_names.index(name)
    value = 0.37 * max(float(robot.lower[place]), -math.pi) + 0.63 * min(float(robot.upper[place]), math.pi)
    try:
        _limb_of(robot, frame, base, {**held, name: value})
    except BadArgument:
        return False
    return True


def _for_eaik(poses: Floats, turn: Floats) -> Floats:
    """Return poses (n, 4, 4) for EAIK: with no rotation at zero, and of a point that is on no axis."""
    return np.asarray(poses @ join_poses(turn, turn @ _TIP))


def _axes(links: Floats, values: Floats) -> tuple[Floats, Floats, Floats]:
    """Return axes and origins (n, c, 3) of the joints at values (n, c), and poses of the frame (n, 4, 4)."""
    axes, points, ends = _columns(links, values)
    T = np.tile(np.eye(4), (len(values), 1, 1))
    T[:, :3] = ends.transpose(2, 1, 0)
    return axes.transpose(2, 0, 1), points.transpose(2, 0, 1), T


def _columns(links: Floats, values: Floats) -> tuple[Floats, Floats, Floats]:
    """Return axes and origins (c, 3, n) of the joints at values (n, c), and the columns of the frame's pose (4, 3, n).

    With the configurations along the last axis, each step is one product of matrices and a few of long rows.
    """
    axes, points = np.empty((2, values.shape[1], 3, len(values)))
    columns = np.repeat(links[0, :3].T[..., None], len(values), axis=-1)
    for k, (link, cosine, sine) in enumerate(zip(links[1:], np.cos(values.T), np.sin(values.T), strict=True)):
        axes[k], points[k] = columns[2], columns[3]
        x, y = columns[0] * cosine + columns[1] * sine, columns[1] * cosine - columns[0] * sine
        columns[0], columns[1] = x, y
        columns = (link.T @ columns.reshape(4, -1)).reshape(columns.shape)
    return axes, points, columns


def _jacobians(links: Floats, values: Floats) -> Floats:
    """Return the frame's Jacobians for joint values (n, c), with lengths in units of `ANGLE_WEIGHT`, (n, 6, c)."""
    axes, points, ends = _columns(links, values)
    levers = (ends[3] - points) / ANGLE_WEIGHT
    J = np.empty((len(values), 6, len(axes)))
    for row, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        J[:, row] = (axes[:, i] * levers[:, j] - axes[:, j] * levers[:, i]).T
        J[:, row + 3] = axes[:, row].T
    return J


# --- Solutions of a block of targets.


class _Answers(NamedTuple):
    """Answers to a block of targets: their targets, shape (N,), coordinates (N, c), errors (N, 2), families (N,)."""

    owner: Rows
    u: Floats
    errors: Floats
    families: Codes

    def where(self, chosen: NDArray[Any]) -> _Answers:
        """Return some of them."""
        return _Answers(*(part[chosen] for part in self))

    def at(self, targets: NDArray[np.bool_]) -> _Answers:
        """Return those of some targets."""
        return self.where(targets[self.owner])

    def replace(self, chosen: NDArray[Any], other: _Answers) -> None:
        """Replace some of them in place."""
        parts: tuple[Any, ...] = self
        for part, new in zip(parts, other, strict=True):
            part[chosen] = new

    def of(self, n: int) -> NDArray[np.bool_]:
        """Return which of n targets have an answer."""
        return np.asarray(np.bincount(self.owner, minlength=n) > 0)


def _together(*answers: _Answers) -> _Answers:
    """Return all, with targets ascending."""
    joined = _Answers(*(np.concatenate(parts) for parts in zip(*answers, strict=True)))
    return joined.where(np.argsort(joined.owner, kind="stable"))


def _places(owner: Rows) -> Rows:
    """Return the place of each answer among those of its target, shape (N,), for targets ascending."""
    return np.arange(len(owner)) - np.searchsorted(owner, owner)


def _least(cost: Floats, owner: Rows) -> Rows:
    """Return the index of the answer with the least cost for each target that has one."""
    order = np.lexsort((cost, owner))
    return np.asarray(order[_places(owner[order]) == 0])


class _Solved(NamedTuple):
    """Branches of a block of n targets, and the other arrays of `IKResult`; and the numbers of `_COUNTED`."""

    branches: Floats
    families: Codes
    number: Integers
    best: Floats
    residual: Floats
    reasons: Codes
    joint: Integers
    needed: Floats
    limit: Floats
    counted: Integers

    def widened(self, k: int) -> _Solved:
        """Return the same with room for k branches."""
        wider = max(0, k - self.branches.shape[1])
        branches = np.pad(self.branches, ((0, 0), (0, wider), (0, 0)), constant_values=np.nan)
        return self._replace(branches=branches, families=np.pad(self.families, ((0, 0), (0, wider))))


_COUNTED = (
    "answers of EAIK that are wrong are left out: {}",
    "{} of {} targets were reached by a search only, not by an answer of EAIK",
    "{} of {} targets have solutions that EAIK misses, found by searches from its answers for poses beside the targets",
    "{} of {} targets near a singularity may have more solutions: EAIK misses some, and a search for them failed",
    "{} of {} targets are not reached, and have least-squares answers of EAIK only",
)


@dataclass(frozen=True, eq=False)
class _Problem:
    """A block of n targets in the base, shape (n, 4, 4), with preferred configurations (n, nq)."""

    robot: RobotModel
    limb: _Limb
    enforce: bool
    tolerance: float
    threads: int | None
    targets: Floats
    preferred: Floats

    @property
    def near(self) -> Floats:
        """The preferred coordinates of the chain, shape (n, c)."""
        return self.preferred[:, self.limb.columns]

    def solve(self) -> _Solved:
        """Solve all targets."""
        n, limb, near = len(self.targets), self.limb, np.ascontiguousarray(self.near)
        owner, u, least_squares = self._asked(self.targets)
        firsts = np.searchsorted(owner, np.arange(n + 1))
        fixed = limb.limited.fixed_values(self.preferred[:, self.robot.nq_base :])
        rows = self.targets, near, fixed, firsts, u, self.threads
        rules = Rules(self.enforce, self.tolerance)
        branches, count, residual = regular_branches(limb.chain, limb.limited, rules, *rows)
        solved = _Solved(
            branches,
            families=np.zeros(branches.shape[:2], dtype=np.int8),
            number=count,
            best=branches[:, 0].copy() if branches.shape[1] else near.copy(),
            residual=residual,
            reasons=np.full(n, Reason.REACHED, dtype=np.int8),
            joint=np.full(n, -1, dtype=np.int64),
            needed=np.zeros(n),
            limit=np.zeros(n),
            counted=np.zeros(len(_COUNTED), dtype=np.int64),
        )
        left = count < 0
        if left.any():
            rest = np.flatnonzero(left)
            some = replace(self, targets=self.targets[rest], preferred=self.preferred[rest])
            chosen, place = left[owner], np.cumsum(left) - 1
            found, arrays, counted = some.completed(place[owner[chosen]], u[chosen], least_squares[chosen])
            count[rest] = np.bincount(found.owner, minlength=len(rest))
            parts: tuple[Any, ...] = solved[3:-1]
            for part, values in zip(parts, arrays, strict=True):
                part[rest] = values
            solved = solved.widened(int(count.max()))._replace(counted=counted)
            at = rest[found.owner], _places(found.owner)
            solved.branches[at], solved.families[at] = found.u, found.families
        return solved

    def completed(
        self, owner: Rows, u: Floats, least_squares: NDArray[np.bool_]
    ) -> tuple[_Answers, tuple[NDArray[Any], ...], Integers]:
        """Return all solutions, sorted, from answers of EAIK, which may lack some, and other arrays of `_Solved`."""
        n, limb = len(self.targets), self.limb
        given, itself = self._refined(self._verified(owner, u)), self._verified(np.arange(n), self.near)
        exact = self._is_exact(given)
        # A search tells whether EAIK missed the solutions of targets for which it has none.
        missed = ~given.where(exact).of(n)
        beside = self._descended(limb.free, self._beside(given, exact), PRECISE)
        found = self._descended(limb.free, _together(given.at(missed), itself.at(missed)), PRECISE)
        # A pose beside a target is met by six joints only, so only their answers there tell how many branches it has.
        lacking = beside.where(~self._is_exact(beside)).of(n) & (len(limb.names) == _MOST_JOINTS)
        same, found, beside = (each.where(self._is_exact(each)) for each in (itself, found, beside))
        solutions = self._distinct(_together(same, given.where(exact), found, beside))
        known = self._distinct(given.where(exact).at(beside.of(n)))
        more = known.of(n) & (np.bincount(solutions.owner, minlength=n) > np.bincount(known.owner, minlength=n))
        solutions, searched = self._with_members(solutions), missed & found.of(n)

        turned, _ = self._turned(solutions)
        outside = limb.limited.worst(self._values(turned))
        inside = turned.where(~outside.outside) if self.enforce else turned
        unmet = ~inside.of(n)
        starts = _together(given.at(unmet), turned.at(unmet), itself.at(unmet))
        near = self._descended(limb.limited if self.enforce else limb.free, starts, 0.0)
        if unmet.any():
            # Beside a singularity EAIK may have one member of what is nearly a family, and another one is inside.
            others = near.where(self._is_exact(near))
            others = others.where(_least(self._away(others), others.owner))
            others.families[self._null_projectors(others).any(axis=(-1, -2))] = Family.SINGULAR
            inside, searched = _together(inside, others), searched | others.of(n)
        inside = inside.where(np.lexsort((self._away(inside), inside.owner)))
        reached = inside.of(n)

        near = near.at(~reached)
        near = near.where(_least(np.hypot(near.errors[:, 0], ANGLE_WEIGHT * near.errors[:, 1]), near.owner))
        firsts = _together(inside.where(_places(inside.owner) == 0), near)  # one for each target
        unreached = ~solutions.of(n) & given.where(least_squares).of(n)
        counted = ~exact & ~least_squares, searched, more, lacking & solutions.of(n), unreached & ~reached
        counts = np.array([np.count_nonzero(each) for each in counted])
        return inside, (firsts.u, firsts.errors, *self._obstacles(turned, outside, reached)), counts

    def _obstacles(self, turned: _Answers, outside: Violations, reached: NDArray[np.bool_]) -> tuple[NDArray[Any], ...]:
        """Return reasons, joints, needed values and limits of all targets, as in `IKResult`."""
        n, limb = len(self.targets), self.limb
        reasons, joint = np.full(n, Reason.REACHED, dtype=np.int8), np.full(n, -1, dtype=np.int64)
        needed, limit = np.zeros(n), np.zeros(n)
        # The solution that exceeds the limits least is the reason why there is none inside them.
        order = _least(np.abs(outside.value - outside.limit), turned.owner)
        order = order[~reached[turned.owner[order]]]
        rows = turned.owner[order]
        reasons[rows] = np.where(outside.coupled[order], Reason.COUPLED_LIMIT, Reason.JOINT_LIMIT)
        joint[rows] = np.argmax(limb.limited.moving == outside.joint[order, None], axis=-1)
        needed[rows], limit[rows] = outside.value[order], outside.limit[order]
        never = ~turned.of(n) & ~reached
        beyond = np.linalg.norm(self.targets[never, :3, 3] - limb.links[0, :3, 3], axis=-1) - limb.length
        reasons[never] = np.where(beyond > 0.0, Reason.OUT_OF_REACH, Reason.NOT_ENOUGH_JOINTS)
        needed[never] = np.maximum(beyond, 0.0)
        return reasons, joint, needed, limit

    def _away(self, answers: _Answers) -> Floats:
        """Return the distances of answers to `near`, shape (N,)."""
        return np.asarray(np.linalg.norm(answers.u - self.near[answers.owner], axis=-1))

    def _is_exact(self, answers: _Answers) -> NDArray[np.bool_]:
        return np.asarray((answers.errors <= self.tolerance).all(axis=-1))

    def _refined(self, answers: _Answers) -> _Answers:
        """Return answers with those refined that are nearly solutions."""
        worst = answers.errors.max(axis=-1, initial=0.0)
        rough = np.flatnonzero((worst > PRECISE) & (worst < _REFINED))
        refined = self._descended(self.limb.free, answers.where(rough), PRECISE)
        met = self._is_exact(refined)
        answers.replace(rough[met], refined.where(met))
        return answers

    def _asked(self, targets: Floats) -> tuple[Rows, Floats, NDArray[np.bool_]]:
        """Return EAIK's answers as indices of targets, coordinates, and whether they are least-squares answers."""
        limb, poses = self.limb, list(_for_eaik(targets, self.limb.turn))
        if len(poses) < _FEW:
            answers = [limb.solver.IK(pose) for pose in poses]
        else:
            answers = limb.solver.IK_batched(poses, self.threads or os.cpu_count() or 1)
        rows = [answer.Q for answer in answers]  # each time a copy
        owner = np.repeat(np.arange(len(answers)), [len(row) for row in rows])
        values = np.concatenate([np.zeros((0, len(limb.names))), *(row for row in rows if len(row))])
        flags = np.array([flag for answer in answers for flag in answer.is_LS], dtype=np.bool_)
        finite = np.isfinite(values).all(axis=-1)
        return owner[finite], (values[finite] - limb.chain.offset) / limb.chain.ratio, flags[finite]

    def _beside(self, given: _Answers, exact: NDArray[np.bool_]) -> _Answers:
        """Return EAIK's answers for poses beside targets at a singularity, without those near an exact answer.

        At a singularity EAIK has answers with a wrong rotation in place of some branches, but beside it none is
        missing. If a branch of six joints does not reach a target, its least-squares answer has the right rotation.
        """
        wrong = given.where(~exact & (given.errors[:, 1] > SAME))
        rows = np.unique(wrong.owner[self._dependent(wrong)[0]])
        owner, u, _ = self._asked(self.targets[rows] @ _BESIDE)
        beside = self._verified(rows[owner], u)
        beside = beside.where(beside.errors.max(axis=-1, initial=0.0) < _REFINED)
        # A search from an answer near an exact one would find the same; no answer beside has an error of zero.
        known = given.where(exact).at(beside.of(len(self.targets)))
        beside = self._distinct(_together(known._replace(errors=0.0 * known.errors), beside), _NEAR)
        return beside.where(beside.errors[:, 0] > 0.0)

    def _values(self, answers: _Answers) -> Floats:
        """Return the values of all joints, shape (N, joints)."""
        q: Floats = self.preferred[answers.owner]
        q[:, self.limb.columns] = answers.u
        return q[:, self.robot.nq_base :]

    def _verified(self, owner: Rows, u: Floats) -> _Answers:
        """Return answers with their errors by forward kinematics."""
        q: Floats = self.preferred[owner]
        q[:, self.limb.columns] = self._apart(u, np.zeros(1)) / self.limb.chain.ratio  # without whole turns
        poses = self.robot.fk(q, self.limb.frame, reference=self.limb.base)
        R, wanted = poses[:, :3, :3], self.targets[owner]
        away = poses[:, :3, 3] - wanted[:, :3, 3], log(R.swapaxes(-1, -2) @ wanted[:, :3, :3])
        errors = np.linalg.norm(away, axis=-1).T
        return _Answers(owner, u, errors, np.zeros(len(owner), dtype=np.int8))

    def _descended(self, region: LimitRegion, starts: _Answers, tolerance: float) -> _Answers:
        """Return the ends of searches from starts, inside a region."""
        if not len(starts.owner):
            return starts
        values = region.project(self._values(starts))
        weights = np.array([1.0, 1.0, 1.0, *[ANGLE_WEIGHT] * 3])
        goal, targets = Goal(weights, tolerance, _SEARCH), self.targets[starts.owner].reshape(-1, 16)
        fixed, inside = region.fixed_values(values), values[:, region.moving]
        minimum = descended(self.limb.chain, region, goal, targets, fixed, inside, self.threads)
        return self._verified(starts.owner, minimum.q)._replace(families=starts.families)

    def _apart(self, u: Floats, other: Floats) -> Floats:
        """Return differences of coordinates as angles of the joints without whole turns, shape (N, c) [rad]."""
        turns = (u - other) * self.limb.chain.ratio / (2.0 * math.pi)
        return np.asarray(2.0 * math.pi * (turns - np.round(turns)))

    def _distinct(self, answers: _Answers, tolerance: float = SAME) -> _Answers:
        """Return answers without those that are another one up to whole turns."""
        place = _places(answers.owner)
        keep = np.ones(len(place), dtype=np.bool_)
        for back in range(1, int(place.max(initial=0)) + 1):
            later = np.flatnonzero(place >= back)
            away = np.abs(self._apart(answers.u[later], answers.u[later - back])).max(axis=-1)
            same = np.where(answers.families[later] == Family.SINGULAR, _SAME_MEMBER, tolerance)
            keep[later[(away < same) & keep[later - back]]] = False
        return answers.where(keep)

    def _turned(self, answers: _Answers) -> tuple[_Answers, Rows]:
        """Return answers with all whole turns inside the limits, or those that exceed them least; and their indices."""
        region, near, index = self.limb.limited, self.near, np.arange(len(answers.owner))
        for k, joint in enumerate(region.moving):
            turn, u = 2.0 * math.pi / abs(self.limb.chain.ratio[k]), answers.u[:, k]
            low, high = region.lower[joint], region.upper[joint]
            lowest, highest = np.ceil((low - LIMIT_TOLERANCE - u) / turn), np.floor((high + LIMIT_TOLERANCE - u) / turn)
            if self.enforce and high - low < TURNS * turn:
                first = np.where(lowest <= highest, lowest, np.round((0.5 * (low + high) - u) / turn))
                count = np.maximum(highest - lowest + 1.0, 1.0).astype(np.intp)
            else:
                first, count = np.round((near[answers.owner, k] - u) / turn), np.ones(len(u), dtype=np.intp)
                if self.enforce:
                    first = np.clip(first, lowest, highest)
            rows = np.repeat(np.arange(len(u)), count)
            answers, index = answers.where(rows), index[rows]
            answers.u[:, k] += turn * (first[rows] + _places(rows))
        return answers, index

    # Families: where axes are dependent, joints may move without moving the frame.

    def _dependent(self, answers: _Answers) -> tuple[Rows, Floats]:
        """Return the indices of answers where axes are dependent, or nearly so, and the Jacobians of these."""
        chain = self.limb.chain
        J = _jacobians(self.limb.links, chain.ratio * answers.u + chain.offset) * chain.ratio
        size = np.linalg.det(J) ** 2 if len(self.limb.names) == 6 else np.linalg.det(J.swapaxes(-1, -2) @ J)
        rows = np.flatnonzero(size < REGULAR)
        return rows, J[rows]

    def _null_projectors(self, answers: _Answers) -> Floats:
        """Return projectors onto the null space of the Jacobian, shape (N, c, c); zero where it has none."""
        projectors = np.zeros((len(answers.owner), *[len(self.limb.names)] * 2))
        rows, J = self._dependent(answers)
        _, sizes, right = np.linalg.svd(J)
        null = right * (sizes < _SINGULAR)[..., None]
        projectors[rows] = null.swapaxes(-1, -2) @ null
        return projectors

    def _with_members(self, answers: _Answers) -> _Answers:
        """Return answers with those of a family replaced by its member nearest to `near`."""
        projectors = self._null_projectors(answers)
        rows, columns = np.nonzero(np.einsum("nii->ni", projectors) > 1e-3)
        ways = projectors[rows, columns]
        ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
        leads = np.ones(len(rows), dtype=np.bool_)
        for step in _STEPS:  # both ways, for a branch that is near is only on one
            on = np.flatnonzero(leads)
            ahead = answers.where(rows[on])
            ahead = self._descended(self.limb.free, ahead._replace(u=ahead.u + step * ways[on]), _ON_FAMILY)
            along = np.sum(self._apart(ahead.u, answers.u[rows[on]]) * ways[on], axis=-1) / step
            leads[on] = (ahead.errors.max(axis=-1, initial=0.0) <= 2.0 * _ON_FAMILY) & (along > _STAYED)
        if not leads.any():
            return answers
        members, firsts = np.unique(rows[leads], return_index=True)
        answers.families[members] = Family.SINGULAR
        family, nearest = self._nearest_members(answers.where(members), ways[leads][firsts])
        alone = np.delete(np.arange(len(answers.owner)), np.asarray(members)[family])
        return self._distinct(_together(answers.where(alone), nearest))

    def _nearest_members(self, members: _Answers, ways: Floats) -> tuple[Rows, _Answers]:
        """Return the nearest allowed members of families, given one member and direction each; and their families."""
        region = self.limb.limited if self.enforce else self.limb.free
        family = np.repeat(np.arange(len(ways)), len(_SPREAD))
        starts = members.where(family)
        starts.u[...] += np.resize(_SPREAD, len(family))[:, None] * ways[family]
        # A family is searched for once, with the whole turns nearest to `near`.
        turned, index = self._turned(starts)
        nearest = self._descended(region, turned.where(_least(self._away(turned), index)), PRECISE)
        on = (nearest.errors.max(axis=-1) < _MEMBER) & self._null_projectors(nearest).any(axis=(-1, -2))
        nearest, family = nearest.where(on), family[on]
        near, share = self.near[nearest.owner], np.ones(len(family))
        for _ in range(_APPROACH):
            if not (share > 1e-3).any():
                break
            steps = np.einsum("nij,nj->ni", self._null_projectors(nearest), near - nearest.u)
            steps *= np.minimum(1.0, 0.5 / np.maximum(np.linalg.norm(steps, axis=-1, keepdims=True), 1e-300))
            ahead = self._descended(region, nearest._replace(u=nearest.u + share[:, None] * steps), PRECISE)
            nearer = (ahead.errors.max(axis=-1) < _MEMBER) & (self._away(ahead) < self._away(nearest) - 1e-9)
            share = np.where(nearer, 1.0, 0.25 * share)
            nearest.replace(nearer, ahead.where(nearer))
        best = _least(self._away(nearest), family)
        return family[best], nearest.where(best)


def _joined(limb: _Limb, blocks: list[_Solved], near: Floats, notes: tuple[str, ...]) -> IKResult:
    """Return the results of all blocks of a batch."""
    if len(blocks) > 1:
        k = max(block.branches.shape[1] for block in blocks)
        blocks = [block.widened(k) for block in blocks]
    *parts, counts = (part[0] if len(part) == 1 else np.concatenate(part) for part in zip(*blocks, strict=True))
    totals, n = counts.reshape(-1, len(_COUNTED)).sum(axis=0).tolist(), near.size // near.shape[-1]
    notes += tuple(text.format(total, n) for text, total in zip(_COUNTED, totals, strict=True) if total)
    shaped = (part.reshape(near.shape[:-1] + part.shape[1:]) for part in parts)
    branches, families, count, best, residual, reasons, joint, needed, limit = shaped
    why = Obstacles(joint, needed, limit)
    return IKResult(limb.names, limb.columns, near, best, branches, families, count, reasons, residual, why, notes)
