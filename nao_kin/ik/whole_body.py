"""`whole_body`: a pose of the whole NAO, standing on its feet, for hands, gaze and centre of mass."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    MAX_SEARCHES,
    Floats,
    SolverLimits,
    batch_index,
    check_tolerance,
    common_batch,
    whole_number,
)
from nao_kin._core.process import usable_cores
from nao_kin._core.text import listed
from nao_kin._kernels.rows import run_rows
from nao_kin.ik.body_errors import BOTH, DEFAULT_POSTURE, SIDES, Body, Plan
from nao_kin.ik.body_search import (
    NOT_STANDING,
    REACHED,
    SHORTFALL,
    START,
    STATUS,
    STEPS,
    STOPPED,
    Problems,
    Solutions,
    whole_bodies,
)
from nao_kin.ik.body_targets import (
    COM,
    GAZE,
    BodyTarget,
    PreparedRobot,
    all_targets,
    factor,
    feet_beyond,
    margin_beyond,
    prepared,
    standing_feet,
    target_beyond,
)
from nao_kin.ik.closed_form import base_coordinates
from nao_kin.ik.results import (
    MILLIMETRES_FROM,
    Codes,
    Integers,
    Outcome,
    Reason,
    crossing_in_words,
    length_in_words,
    overlap_in_words,
)
from nao_kin.ik.targets import check_threads, checked_reference, is_enforced, rows_of
from nao_kin.robot import Clearance, CollisionRule, RobotModel, SupportPolygon

# --- The result: the pose, the residual of each target, and the target that gives way.

FEET = "feet"
_MAX_NAMES = 4
_METRES = "; targets are in metres"
_WHY = {
    Reason.OUT_OF_REACH: "out of reach",
    Reason.TARGETS_DISAGREE: "met without the other targets, not with them",
}


@dataclass(frozen=True, eq=False)
class WholeBodyResult(Outcome):
    """Poses of the whole robot for targets of a batch shape (...); () for one.

    Attributes:
        q: configurations, shape (..., nq), including a floating base; nan if the robot cannot stand on both feet. If
            targets are not met, the pose inside the limits with the least weighted sum of squares.
        torso: T_world_torso, shape (..., 4, 4).
        reasons: a `Reason` for each pose as a number, shape (...).
        residuals: name of a target → errors of its position and rotation in the components with a weight, shape
            (..., 2) [m, rad]; for "com" the horizontal distance, or the missing margin.
        beyond: a lower bound on how far the target that gives way is out of reach of the stretched robot, or on how
            much too far apart the feet are, shape (...) [m]; 0 if the reason is another one.
        worst: index in `residuals` of the target that gives way, shape (...); −1 for none.
        com: the centre of mass in the world, shape (..., 3) [m].
        margin: the distance of the centre of mass inside the support polygon, negative outside, shape (...) [m].
        at_limits: which joints are at a limit, in the order of `joints`, shape (..., joints).
        joints: names of the joints.
        iterations: steps of all searches together, shape (...).
        starts: number of searches started, shape (...).
        standing: the standing feet.
        notes: notes on the call, one line each.
        clearance: the clearance of `q`, nan and without links where `q` is nan; None if collisions were not checked.
    """

    q: Floats
    torso: Floats
    reasons: Codes
    residuals: Mapping[str, Floats]
    beyond: Floats
    worst: Integers
    com: Floats
    margin: Floats
    at_limits: NDArray[np.bool_]
    joints: tuple[str, ...]
    iterations: Integers
    starts: Integers
    standing: tuple[str, ...]
    notes: tuple[str, ...] = field(default=())
    clearance: Clearance | None = None

    @property
    def gives_way(self) -> str | NDArray[np.object_]:
        """The target with the largest weighted residual; "feet" if the robot cannot stand on both; "" if all are met.

        For a batch it is an array of shape (...).
        """
        names = np.array([*self.residuals, FEET, ""], dtype=object)
        feet = np.isnan(self.q).any(axis=-1)
        solutions = names[np.where(feet, len(names) - 2, np.where(self.worst < 0, len(names) - 1, self.worst))]
        return str(solutions) if self.reasons.ndim == 0 else np.asarray(solutions)

    def describe(self, index: tuple[int, ...] = ()) -> str:
        """Return the reason of one pose in a sentence; `index` selects it in a batch.

        Examples:
            >>> nao = nk.load_nao()
            >>> result = nk.ik.whole_body(nao, {"LArm": [0.18, 0.1, 0.25]})
            >>> result.describe()
            'reached; centre of mass 35.72 mm inside the support polygon'
        """
        index = batch_index(index, self.reasons.shape)
        reason = Reason(int(self.reasons[index]))
        beyond = float(self.beyond[index])
        if np.isnan(self.q[index]).any():
            if reason is not Reason.OUT_OF_REACH:
                return "no pose found that stands on both feet: do their directions fit the shared hip motor?"
            hint = _METRES if beyond > MILLIMETRES_FROM else ""
            return f"the feet cannot both be stood on: too far apart by at least {length_in_words(beyond)}{hint}"
        margin = float(self.margin[index])
        side = "inside" if margin >= 0.0 else "outside"
        where = f"centre of mass {length_in_words(abs(margin))} {side} the support polygon"
        if reason is Reason.REACHED:
            return f"reached; {where}"
        if reason is Reason.COLLISION and self.clearance is not None:
            pair = self.clearance.pairs[int(self.clearance.pair_index[index])]
            return overlap_in_words(pair, -float(self.clearance.distance[index]))
        name = list(self.residuals)[int(self.worst[index])]
        distance, angle = (float(error) for error in self.residuals[name][index])
        errors = (length_in_words(distance), distance), (f"{angle:.3g} rad", angle)
        amount = " and ".join(text for text, size in errors if size > 1e-9) or length_in_words(distance)
        why = _WHY.get(reason, "no pose found that meets it")
        names = [joint for joint, is_at in zip(self.joints, self.at_limits[index], strict=True) if is_at]
        limits = f"; at their limits: {listed(names, _MAX_NAMES)}" if names else ""
        hint = _METRES if distance > MILLIMETRES_FROM else ""
        return f"{name} gives way by {amount}: {why}{limits}{hint}"

    def __repr__(self) -> str:
        feet = " and ".join(self.standing)
        if self.reasons.ndim == 0:
            return f"<WholeBodyResult standing on {feet}: {self.describe()}>"
        reached = int(np.count_nonzero(self.success))
        return f"<WholeBodyResult standing on {feet}: {reached} of {self.reasons.size} poses reached>"


# --- `whole_body`.

# Duration of a search from one start as Python, before the kernel has been compiled [s].
_PYTHON_SECONDS = 0.25
# A joint is at its limit if it is nearer to it than this [rad].
_AT_LIMIT = 1e-6
# Largest number of steps of one search.
_STEPS = 100


def whole_body(
    robot: RobotModel,
    targets: Mapping[str, ArrayLike],
    *,
    feet: Mapping[str, ArrayLike] | None = None,
    com: ArrayLike | str | None = None,
    margin: float = 0.0,
    gaze: ArrayLike | tuple[ArrayLike, str] | None = None,
    torso: ArrayLike | None = None,
    posture: ArrayLike | None = None,
    weights: Mapping[str, ArrayLike | tuple[ArrayLike, ArrayLike]] | None = None,
    near: ArrayLike | None = None,
    limits: SolverLimits = "enforce",
    restarts: SupportsIndex = 50,
    tolerance: float = 1e-8,
    threads: SupportsIndex | None = None,
    collisions: bool | CollisionRule = False,
) -> WholeBodyResult:
    """Return a pose of the whole NAO that stands on one or both feet and meets targets in the world.

    The standing feet are met exactly, by the closed form of the legs. For all other targets, Levenberg–Marquardt steps
    with exact derivatives minimise ½ Σ ‖w · e‖² inside all limits over the pose of the torso, the arms, the head and a
    leg that does not stand. Redundancy is resolved by a pull to `posture` that ends before the last steps and so does
    not affect the targets. The same arguments give the same answer. The derivation is in docs/whole_body.md.

    Every argument may have leading batch axes (...); they broadcast. If targets cannot be met, nothing is raised:
    the result has the pose with the least sum, and names the target that gives way.

    Args:
        robot: a NAO of any version, or another robot with legs of its geometry.
        targets: name of a frame → its pose T_world_frame, shape (..., 4, 4), or its position, shape (..., 3) [m]. If
            empty, the robot only stands.
        feet: the standing feet, "L", "R" or both, with T_world_foot of the frames "LLeg" and "RLeg", (..., 4, 4). None:
            both feet stay where `near` has them.
        com: position (x, y) of the centre of mass, shape (..., 2) [m]; "support" for any point above the support
            polygon of the standing feet; None to leave it free. The world's z axis points up.
        margin: distance of the centre of mass inside the support polygon, with com="support" [m].
        gaze: a point to be on the optical axis of CameraTop, shape (..., 3) [m]; or (point, camera).
        torso: a pose or position for the torso, as in `targets`.
        posture: preferred configurations, shape (..., nq); None for `near`. Outside the limits they are
            projected onto them, and `notes` says so.
        weights: name of a target, "com", "gaze", "torso" or "posture" → a factor on its default weight; for a target
            also two weights, for metres and radians, or six, for x, y, z and the rotations about x, y, z in the axes of
            the target; or (six weights, R_world_axes) for other axes, shape (3, 3). Zero frees a component:
            (0, 0, 1, 0.1, 0.1, 0) leaves x, y and the rotation about z free. Defaults are 1 per metre and 0.1 per
            radian, and 0.01 per radian of difference to the posture. A position has the axes of the world, and no
            rotation errors; "com" has x and y alone, "gaze" the rotations about y and z of the camera.
        near: start of the search, shape (..., nq), and the values of the hands. None for all joints at zero, or at
            the limit nearest to it. The torso of a fixed base is at the origin of the world, a floating base has its
            pose in `near`. Outside the limits it is projected onto them, and `notes` says so.
        restarts: the maximum of other starts if the first does not meet the targets.
        tolerance: a target is met within this error [m and rad].
        limits: as in all solvers, see `nao_kin.ik`; "ignore" brings joint values within half a turn of
            those of the posture.
        threads: as in all solvers.
        collisions: as in all solvers; up to `restarts` more searches start farther and farther from a pose in which
            links overlap.

    Raises:
        UnknownName: a frame, camera, foot or weight that does not exist.
        BadArgument: contradicting targets (a frame on a standing foot, the torso twice, no foot), or a robot without
            the legs of a NAO.
        NotARotation: a pose is not rigid; the error has its index and its defect.

    Examples:
        >>> nao = nk.load_nao()
        >>> result = nk.ik.whole_body(nao, {"LArm": [0.18, 0.1, 0.25]})
        >>> bool(result.success), result.standing
        (True, ('L', 'R'))
    """
    ready = prepared(robot)
    enforce = is_enforced(limits)
    weights = weights or {}
    check_tolerance(tolerance)
    check_tolerance(margin, "margin")
    searches = whole_number(restarts, "restarts", 0, MAX_SEARCHES)
    workers = check_threads(threads)
    given, notes = (ready.rest, ()) if near is None else checked_reference(robot, near, enforce)
    standing = standing_feet(feet) if feet is not None else ready.feet(robot, None if near is None else given)
    requested = all_targets(robot, ready, standing, targets, com, gaze, torso, weights)
    preferred, more = (given, ()) if posture is None else checked_reference(robot, posture, enforce, "posture")
    shapes = [T.shape[:-2] for T in (*(target.values for target in requested), *standing.values())]
    shapes += [given.shape[:-1], preferred.shape[:-1]]
    batch = common_batch("targets, feet, posture and near", *shapes)
    support = isinstance(com, str)
    plan = Plan(
        np.array([target.row for target in requested], np.int64),
        np.array([target.name == GAZE for target in requested], np.int64),
        np.array([target.weights for target in requested]).reshape(-1, 6),
        support=factor(COM, weights) if support else 0.0,
        posture=factor("posture", weights) * DEFAULT_POSTURE,
        stance=BOTH if len(standing) == BOTH else SIDES.index(next(iter(standing))),
        as_is=False,
        tolerance=float(tolerance),
        steps=_STEPS,
    )
    begin, pull = (np.array(rows_of(q[..., ready.order], batch, 1)) for q in (given, preferred))
    ends = (pull, begin) if enforce else (ready.unwound(pull, 0.0), ready.unwound(begin, 0.0))
    inside = float(margin) if support else 0.0
    problems, origin, polygons = _problems(ready, standing, requested, batch, inside, *ends)
    feet_names = tuple(standing)
    body = ready.body if enforce else ready.unlimited
    search = _Search(
        robot, ready, body, requested, feet_names, plan, problems, origin, polygons, inside, searches, workers
    )
    solutions = search.run(slice(None), as_is=posture is None, restarts=0)
    again = np.flatnonzero(solutions.report[:, STATUS] != REACHED)
    if again.size and searches:
        for all_rows, rows in zip(solutions, search.run(again), strict=True):
            all_rows[again] = rows
    reference_rows, rule = np.array(rows_of(given, batch, 1)), CollisionRule.of(collisions)
    if rule is not None:
        _search_without_overlap(search, solutions, reference_rows, rule)
    if not enforce:
        solutions.x[:] = ready.unwound(solutions.x, pull)
    return _result(search, solutions, reference_rows, batch, notes + more, rule)


def _problems(
    ready: PreparedRobot,
    standing: Mapping[str, Floats],
    requested: list[BodyTarget],
    batch: tuple[int, ...],
    margin: float,
    posture: Floats,
    first: Floats,
) -> tuple[Problems, Floats, tuple[SupportPolygon, ...]]:
    """Return the arguments as rows, relative to the first standing foot, which keeps digits far from the origin.

    Also return the position of that foot in the world, shape (n, 3) [m], and the support polygons relative to it, one
    for each pose or one for all.
    """
    n = math.prod(batch)
    feet = np.zeros((n, len(SIDES), 4, 4))
    for side, T in standing.items():
        feet[:, SIDES.index(side)] = rows_of(T, batch, 2)
    origin = feet[:, SIDES.index(next(iter(standing))), :3, 3].copy()
    frames, targets = np.empty((n, len(requested), 4, 4)), np.empty((n, len(requested), 4, 4))
    for k, target in enumerate(requested):
        frames[:, k], targets[:, k] = rows_of(target.frames, batch, 2), rows_of(target.values, batch, 2)
    feet[:, :, :3, 3] -= origin[:, None]
    targets[:, :, :3, 3] -= origin[:, None]
    is_common = all(T.ndim == 2 for T in standing.values())
    sides = [(feet[:, SIDES.index(side)], ready.corners[side]) for side in standing]
    corners = np.concatenate([c @ T[:, :3, :3].swapaxes(-1, -2) + T[:, None, :3, 3] for T, c in sides], axis=1)
    polygons = tuple(map(SupportPolygon.around, corners[: 1 if is_common else n]))
    edges = np.array([len(polygon.vertices) for polygon in polygons], np.int64)
    planes = np.zeros((len(polygons), int(edges.max(initial=0)), 3))
    for i, polygon in enumerate(polygons):
        planes[i, : edges[i]] = polygon.half_planes
        planes[i, : edges[i], 2] += margin
    if is_common:
        planes, edges = np.repeat(planes, n, axis=0), np.repeat(edges, n)
    return Problems(feet, frames, targets, planes, edges, posture, first[:, None]), origin, polygons


@dataclass(frozen=True, eq=False)
class _Search:
    """The compiled search for n poses; problems, origin and polygons are as from `_problems`."""

    robot: RobotModel
    ready: PreparedRobot
    body: Body
    targets: list[BodyTarget]
    standing: tuple[str, ...]
    plan: Plan
    problems: Problems
    origin: Floats
    polygons: tuple[SupportPolygon, ...]
    margin: float
    restarts: int
    threads: int | None

    def run(
        self,
        rows: Integers | slice,
        *,
        targets: list[int] | None = None,
        as_is: bool = False,
        restarts: int | None = None,
        start: Floats | None = None,
    ) -> Solutions:
        """Search for the poses of some rows.

        `targets` selects targets, None for all, an empty list for the support polygon alone; `as_is` keeps a reference
        that meets all targets. With a `start` (rows, variables) in place of the reference, the posture does not pull.
        """
        plan, body, problems = self.plan._replace(as_is=as_is), self.body, self.problems
        if start is not None:
            plan = plan._replace(posture=0.0)
        if targets is not None:
            parts = {name: getattr(plan, name)[targets] for name in ("row", "aims", "weights")}
            plan = plan._replace(support=0.0 if targets else plan.support, **parts)
            problems = problems._replace(frames=problems.frames[:, targets], targets=problems.targets[:, targets])
        count = self.restarts if restarts is None else restarts
        problems = Problems._make(np.ascontiguousarray(part[rows]) for part in problems)
        if start is not None:
            problems = problems._replace(starts=start[:, None])
        if count:
            random = self.random(count)
            starts = np.repeat(problems.starts, 1 + count, axis=1)
            starts[:, 1:, : body.moving] = random  # the hands as in the reference
            problems = problems._replace(starts=starts)
        n, width = problems.posture.shape
        shapes = (width,), (4, 4), (len(plan.row), 3), (3,), (5,)
        solutions = Solutions._make(np.zeros((n, *shape)) for shape in shapes)

        def solve(function: Callable[..., object], part: slice) -> None:
            some = Problems._make(array[part] for array in problems)
            function(body, self.ready.second_leg, plan, some, Solutions._make(array[part] for array in solutions))

        if n:
            threads = 1 if n == 1 else self.threads or usable_cores()
            run_rows(whole_bodies, solve, n, min(n, threads), each=(1 + count) * _PYTHON_SECONDS)
        return solutions

    def random(self, count: int) -> Floats:
        """Return random values of the moving variables, shape (count, moving)."""
        q = self.robot.random(np.random.default_rng(0), count)
        return q[:, self.ready.order[: self.body.moving]]


def _clearance(search: _Search, q: Floats, reference: Floats, rule: CollisionRule) -> Clearance:
    """Return the clearance of poses q (n, nq) that a search from references (n, nq) found."""
    return search.robot.link_shapes.clearance_from(q, reference, rule, search.ready.order.tolist())


def _search_without_overlap(search: _Search, solutions: Solutions, reference: Floats, rule: CollisionRule) -> None:
    """Replace poses in which links overlap, by searches from starts farther and farther from these poses."""
    moving = search.body.moving

    def distances(x: Floats, rows: Integers) -> Floats:
        q = reference[rows]
        q[:, search.ready.order] = x
        return _clearance(search, q, reference[rows], rule).distance

    best = distances(solutions.x, np.arange(len(solutions.x)))
    for number, random in enumerate(search.random(search.restarts), 1):
        rows = np.flatnonzero((solutions.report[:, STATUS] == REACHED) & (best < -rule.tolerance))
        if not rows.size:
            return
        start = solutions.x[rows]
        start[:, :moving] += number / search.restarts * (random - start[:, :moving])
        other = search.run(rows, restarts=0, start=start)
        solutions.report[rows, STEPS] += other.report[:, STEPS]
        solutions.report[rows, START] += 1.0
        other.report[:, [STEPS, START]] = solutions.report[rows][:, [STEPS, START]]
        distance = distances(other.x, rows)
        better = (other.report[:, STATUS] == REACHED) & (distance > best[rows])
        best[rows[better]] = distance[better]
        for all_rows, own in zip(solutions, other, strict=True):
            all_rows[rows[better]] = own[better]


def _result(
    search: _Search,
    solutions: Solutions,
    reference: Floats,
    batch: tuple[int, ...],
    notes: tuple[str, ...],
    rule: CollisionRule | None,
) -> WholeBodyResult:
    robot, ready, body = search.robot, search.ready, search.body
    status = solutions.report[:, STATUS]
    residuals = {target.name: solutions.residuals[:, k, :2].copy() for k, target in enumerate(search.targets)}
    if search.plan.support > 0.0:
        residuals[COM] = solutions.report[:, SHORTFALL:].copy()
    stands = status != NOT_STANDING
    failed = np.flatnonzero((status != REACHED) & stands)
    worst, beyond = np.full(len(status), -1), np.zeros(len(status))
    reasons, all_stand = np.zeros(len(status), np.int8), stands.all()
    if not all_stand:
        beyond[~stands] = feet_beyond(body, search.problems.feet[~stands])
        reasons[~stands] = np.where(beyond[~stands] > 0.0, Reason.OUT_OF_REACH, Reason.NOT_CONVERGED)
    if failed.size:
        # A target that is met does not give way, even if its rounding has a large weight.
        unmet = np.array([(residual > search.plan.tolerance).any(axis=-1) for residual in residuals.values()])
        shortfall = search.plan.support * solutions.report[:, SHORTFALL]
        weighted = np.vstack([solutions.residuals[:, :, 2].T, shortfall])[: len(unmet)]
        worst[failed] = np.argmax(np.where(unmet | ~unmet.any(axis=0), weighted, -1.0)[:, failed], axis=0)
        beyond[failed] = _beyond(search, failed, worst)
        reasons[failed] = _failure_reasons(search, failed, worst, beyond, solutions)
    q = reference.copy()
    q[:, ready.order] = solutions.x
    torso = solutions.T_world_torso.copy()
    torso[:, :3, 3] += search.origin
    if robot.base == "floating":
        q[stands, :7] = base_coordinates(robot, torso[stands])
    com = solutions.com + search.origin
    values = solutions.x[:, : body.moving]
    near = np.minimum(values - body.limits.lower, body.limits.upper - values)
    if len(search.polygons) == 1:
        planes = search.problems.planes[0]
        margins = (solutions.com[:, :2] @ planes[:, :2].T - planes[:, 2]).min(axis=-1) + search.margin
        outside = margins < 0.0
        if outside.any():
            margins[outside] = search.polygons[0].signed_distance(solutions.com[outside])
    else:
        below = zip(search.polygons, solutions.com, strict=True)
        margins = np.array([polygon.signed_distance(place) for polygon, place in below])
    clearance = None
    if rule is not None:
        clearance = _clearance(search, q, reference, rule)
        reasons[(status == REACHED) & ~np.asarray(clearance.is_free)] = Reason.COLLISION
        distance = np.where(stands, clearance.distance, np.nan).reshape(batch)
        pair_index = np.where(stands, clearance.pair_index, -1).reshape(batch)
        clearance = replace(clearance, distance=distance, pair_index=pair_index)
    for array in () if all_stand else (q, torso, com, margins, *residuals.values()):
        array[~stands] = np.nan
    return WholeBodyResult(
        q=q.reshape(*batch, q.shape[-1]),
        torso=torso.reshape(*batch, 4, 4),
        reasons=reasons.reshape(batch),
        residuals={name: residual.reshape(*batch, 2) for name, residual in residuals.items()},
        beyond=beyond.reshape(batch),
        worst=worst.reshape(batch),
        com=com.reshape(*batch, 3),
        margin=margins.reshape(batch),
        at_limits=(near <= _AT_LIMIT).reshape(*batch, body.moving),
        joints=ready.names[: body.moving],
        iterations=solutions.report[:, STEPS].astype(np.int64).reshape(batch),
        starts=np.where(stands, solutions.report[:, START].astype(np.int64) + 1, 1 + search.restarts).reshape(batch),
        standing=search.standing,
        notes=notes + _crossing(search, solutions, stands.reshape(batch)),
        clearance=clearance,
    )


def _beyond(search: _Search, failed: Integers, worst: Integers) -> Floats:
    """Return lower bounds on how far the targets that give way are out of reach; 0 within the tolerance."""
    problems, polygons, beyond = search.problems, search.polygons, np.zeros(len(failed))
    for index in np.unique(worst[failed]).tolist():
        mine = np.flatnonzero(worst[failed] == index)
        rows = failed[mine]
        if index < len(search.targets):
            target, given = search.targets[index], problems.targets[rows, index]
            beyond[mine] = target_beyond(search.body, target, search.standing, problems.feet[rows], given)
        else:
            below = polygons if len(polygons) > 1 else polygons * len(worst)
            beyond[mine] = [margin_beyond(below[row], search.margin) for row in rows]
    return np.where(beyond > search.plan.tolerance, beyond, 0.0)


def _failure_reasons(search: _Search, failed: Integers, worst: Integers, beyond: Floats, solutions: Solutions) -> Codes:
    """Return whether the targets that give way are out of reach, or are met without the other targets."""
    status = solutions.report[failed, STATUS]
    reasons = np.where(status == STOPPED, Reason.NOT_CONVERGED, Reason.TARGETS_DISAGREE).astype(np.int8)
    reasons[beyond[failed] > 0.0] = Reason.OUT_OF_REACH
    is_alone = len(search.targets) + (search.plan.support > 0.0) == 1
    for index in np.unique(worst[failed]).tolist():
        mine = np.flatnonzero((worst[failed] == index) & (reasons == Reason.TARGETS_DISAGREE))
        targets = [index] if index < len(search.targets) else []
        report = solutions.report[failed[mine]] if is_alone else search.run(failed[mine], targets=targets).report
        reasons[mine[report[:, STATUS] != REACHED]] = Reason.NOT_CONVERGED
    return reasons


def _crossing(search: _Search, solutions: Solutions, stands: NDArray[np.bool_]) -> tuple[str, ...]:
    """Return a note, as in `legs`, if ankles are on swapped sides of the torso."""
    if search.plan.stance != BOTH:
        return ()
    ankles = (search.problems.feet @ search.ready.ankles)[..., 0]
    left = (solutions.T_world_torso[:, :, 1] * (ankles[:, 0] - ankles[:, 1])).sum(axis=-1)
    crossed = stands & (left < 0.0).reshape(stands.shape)
    return crossing_in_words(crossed, "poses") if crossed.any() else ()
