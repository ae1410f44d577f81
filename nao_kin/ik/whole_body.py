"""`whole_body`: a pose of the whole NAO, its feet standing, for hands, gaze and centre of mass."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import MAX_SEARCHES, Floats, as_vectors, check_tolerance, common_batch, whole_number
from nao_kin._core.process import usable_cores
from nao_kin.ik.body import SIDES, Ints
from nao_kin.ik.body_errors import BOTH, DEFAULT_POSTURE, DEFAULT_WEIGHTS, Plan
from nao_kin.ik.body_search import (
    LACKING,
    NOT_STANDING,
    REACHED,
    START,
    STATUS,
    STEPS,
    STOPPED,
    Found,
    Poses,
    whole_bodies,
)
from nao_kin.ik.body_targets import (
    BodyTables,
    PreparedRobot,
    Target,
    all_targets,
    checked_weights,
    factor,
    feet_beyond,
    margin_beyond,
    prepared,
    standing_feet,
    target_beyond,
)
from nao_kin.ik.compiling import run_rows
from nao_kin.ik.results import (
    MILLIMETRES_FROM,
    Codes,
    Integers,
    Reason,
    crossing_in_words,
    length_in_words,
    messages_of,
)
from nao_kin.ik.targets import Limits, check_threads, inside_limits, is_enforced, with_unit_quaternion
from nao_kin.robot import RobotModel, SupportPolygon, polygon_below
from nao_kin.rotations import quat_from_matrix, quat_to_xyzw

# --- What `whole_body` answers: the pose, what each target is off by, and which of them gives way.

FEET = "feet"
COM = "com"
_MOST_NAMES = 4
_METRES = "; targets are in metres"


@dataclass(frozen=True, eq=False)
class WholeBodyResult:
    """Poses of the whole robot for targets of a batch shape (...); () for one.

    Attributes:
        q: configurations, shape (..., nq), with a floating base the base included; nan where the feet cannot both be
            stood on. Where targets are not met, the pose inside the limits with the least weighted sum of squares.
        torso: T_world_torso, shape (..., 4, 4).
        reasons: a `Reason` for each pose as a number, shape (...).
        residuals: by the names of the targets, what they are off by, shape (..., 2) [m, rad]; of what was not asked
            for 0. Of "com" the horizontal distance, or what the margin lacks.
        beyond: how much farther than the stretched robot the target that gives way is, or the feet are apart, at
            least, shape (...) [m]; 0 where that is not what is in the way.
        worst: which target gives way, its place in `residuals`, shape (...); −1 where none does.
        com: the centre of mass in the world, shape (..., 3) [m].
        margin: how far it is inside the support polygon of the feet that stand, negative outside, shape (...) [m].
        at_limits: which joints are at a limit, in the order of `joints`, shape (..., joints).
        joints: names of the joints.
        iterations: steps of all searches together, shape (...).
        starts: how many searches were begun before the targets were met or all were used up, shape (...).
        standing: which feet stand.
        notes: what else is to be said about the call, one line each.

    Examples:
        >>> nao = nk.load_nao()
        >>> result = nk.ik.whole_body(nao, {"LArm": [0.18, 0.1, 0.25]})
        >>> bool(result.success), result.q.shape
        (True, (25,))
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

    @property
    def success(self) -> bool | NDArray[np.bool_]:
        """Whether all targets are met: a bool, or of a batch an array of shape (...)."""
        reached = self.reasons == Reason.REACHED
        return bool(reached) if self.reasons.ndim == 0 else np.asarray(reached)

    @property
    def reason(self) -> Reason | Codes:
        """Why: a `Reason`, or of a batch their numbers, shape (...)."""
        return Reason(int(self.reasons)) if self.reasons.ndim == 0 else self.reasons

    @property
    def gives_way(self) -> str | NDArray[np.object_]:
        """The target that gives way, "feet" where these cannot both be stood on, "" where all are met.

        It is the one with the largest weighted residual; of a batch an array, shape (...).
        """
        names = np.array([*self.residuals, FEET, ""], dtype=object)
        feet = np.isnan(self.q).any(axis=-1)
        found = names[np.where(feet, len(names) - 2, np.where(self.worst < 0, len(names) - 1, self.worst))]
        return str(found) if self.reasons.ndim == 0 else np.asarray(found)

    @property
    def message(self) -> str | NDArray[np.object_]:
        """The reason in a sentence: a str, or of a batch an array of them, shape (...)."""
        return messages_of(self)

    def describe(self, index: tuple[int, ...] = ()) -> str:
        """The reason of one pose in a sentence.

        Args:
            index: which pose of the batch; () where there is one.

        Examples:
            >>> nao = nk.load_nao()
            >>> result = nk.ik.whole_body(nao, {"LArm": [0.18, 0.1, 0.25]})
            >>> result.describe()
            'reached; centre of mass 35.72 mm inside the support polygon'
        """
        reason = Reason(int(self.reasons[index]))
        beyond = float(self.beyond[index])
        if np.isnan(self.q[index]).any():
            if reason is not Reason.OUT_OF_REACH:
                return "no pose found that stands on both feet: do their directions fit the one motor of the hips?"
            hint = _METRES if beyond > MILLIMETRES_FROM else ""
            return f"the feet cannot both be stood on: too far apart by {length_in_words(beyond)}{hint}"
        margin = float(self.margin[index])
        side = "inside" if margin >= 0.0 else "outside"
        where = f"centre of mass {length_in_words(abs(margin))} {side} the support polygon"
        if reason is Reason.REACHED:
            return f"reached; {where}"
        name = list(self.residuals)[int(self.worst[index])]
        away, turned = (float(error) for error in self.residuals[name][index])
        amount = " and ".join(
            text for text, size in ((length_in_words(away), away), (f"{turned:.3g} rad", turned)) if size > 1e-9
        )
        amount = amount or length_in_words(away)
        why = {
            Reason.OUT_OF_REACH: "out of reach",
            Reason.TARGETS_DISAGREE: "met without the other targets, not with them",
        }.get(reason, "no pose found that meets it")
        names = [joint for joint, is_at in zip(self.joints, self.at_limits[index], strict=True) if is_at]
        limits = f"; at their limits: {', '.join(names[:_MOST_NAMES])}" if names else ""
        if len(names) > _MOST_NAMES:
            limits += f" and {len(names) - _MOST_NAMES} more"
        hint = _METRES if away > MILLIMETRES_FROM else ""
        return f"{name} gives way by {amount}: {why}{limits}{hint}"

    def __repr__(self) -> str:
        feet = " and ".join(self.standing)
        if self.reasons.ndim == 0:
            return f"<WholeBodyResult standing on {feet}: {self.describe()}>"
        reached = int(np.count_nonzero(self.success))
        return f"<WholeBodyResult standing on {feet}: {reached} of {self.reasons.size} poses reached>"


# --- `whole_body`: a pose of the whole NAO, its feet standing, for hands, gaze and centre of mass.

# What a search from one start takes as Python, before the kernel has been compiled [s].
_PYTHON_SECONDS = 0.25
# A joint is at its limit from here on [rad].
_AT_LIMIT = 1e-6


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
    weights: Mapping[str, float | tuple[float, float]] | None = None,
    reference: ArrayLike | None = None,
    limits: Limits = "enforce",
    restarts: SupportsIndex = 50,
    tolerance: float = 1e-8,
    iterations: SupportsIndex = 100,
    seed: SupportsIndex = 0,
    threads: SupportsIndex | None = None,
) -> WholeBodyResult:
    """A pose of the whole NAO that stands on one or both feet and meets targets in the world.

    The feet that stand are met exactly, by the closed form of the legs. All else is met by Levenberg–Marquardt steps
    with exact derivatives inside all limits: ½ Σ ‖w · e‖² is made small over the torso's pose, arms, head and a leg
    that does not stand. What the targets leave open is decided by a pull to `posture`, which costs them nothing: it
    ends before the last steps. The same arguments give the same answer.

    Every argument may be a batch of leading axes (...); they broadcast. What is not met raises nothing: the result
    then has the pose with the least sum, and names the target that gives way.

    Args:
        robot: a NAO of any version, or another robot with legs of its geometry.
        targets: by the name of a frame, its pose T_world_frame, shape (..., 4, 4), or its place, shape (..., 3) [m].
            May be empty: the robot stands.
        feet: the feet that stand, "L", "R" or both, with T_world_foot of the frames "LLeg" and "RLeg", (..., 4, 4).
            None for both where the reference has them.
        com: a place (x, y) that the centre of mass is to be above, shape (..., 2) [m]; or "support", for anywhere above
            the support polygon of the standing feet; None where it does not matter. The world's z axis points up.
        margin: how far inside the support polygon, with com="support" [m].
        gaze: a point that CameraTop is to see on its optical axis, shape (..., 3) [m]; or (point, camera).
        torso: a wished pose or place of the torso, as in `targets`.
        posture: configurations to stay near to, shape (..., nq); None for the reference. Outside the limits they are
            projected onto them, and `notes` says so.
        weights: by the names of targets, "com", "gaze", "torso" and "posture", a factor on the weight that a target has
            otherwise, or two weights of its own for metres and radians; a weight of 0 frees what it belongs to. Without
            it errors weigh 1 per metre and 0.1 per radian, differences to the posture 0.01 per radian.
        reference: where the search begins, shape (..., nq), and what the hands are at. None for all joints at zero, or
            at the limit nearest to it. With a fixed base its torso is at the origin of the world; a floating base
            stands where the reference has it. Outside the limits it is projected onto them, and `notes` says so.
        limits: "enforce" or "ignore" for boxes and coupled limits. Where they are ignored, joints may go round; their
            values are within half a turn of those of the posture.
        restarts: other starts to try where the first does not meet the targets, at most.
        tolerance: a target is met when it is off by at most so many metres and radians.
        iterations: steps of one search, at most.
        seed: of the other starts.
        threads: how many threads may work on a batch; None for all cores.

    Raises:
        UnknownName: no such frame, camera, foot, weight or choice.
        BadArgument: targets that contradict each other by form: a frame on a foot that stands, the torso twice, no
            foot. Options that make no sense, numbers above 1e150, weights above 1e12; a robot without the legs of a
            NAO.
        NotARotation, BadArgument: a pose that is not rigid; names it, its index and its defect.
        WrongShape, NotFinite: other shapes, or shapes that do not broadcast; NaN or infinity.

    Source: the derivation is in docs/whole_body.md.

    Examples:
        >>> nao = nk.load_nao()
        >>> result = nk.ik.whole_body(nao, {"LArm": [0.18, 0.1, 0.25]})
        >>> bool(result.success), result.standing
        (True, ('L', 'R'))
    """
    ready = prepared(robot)
    enforce = is_enforced(limits)
    tables = ready.tables[enforce]
    factors = checked_weights(weights)
    check_tolerance(tolerance)
    check_tolerance(margin, "margin")
    searches = whole_number(restarts, "restarts", 0, MAX_SEARCHES)
    steps = whole_number(iterations, "iterations", 1, MAX_SEARCHES)
    workers = check_threads(threads)
    given, notes = (ready.rest, ()) if reference is None else _configurations(robot, reference, "reference", enforce)
    standing = standing_feet(feet) if feet is not None else ready.feet(robot, None if reference is None else given)
    asked = all_targets(robot, tables, standing, targets, com, gaze, torso, factors)
    wanted, more = (given, ()) if posture is None else _configurations(robot, posture, "posture", enforce)
    batch = common_batch(
        "targets, feet, posture and reference",
        *(target.values.shape[:-2] for target in asked),
        *(T.shape[:-2] for T in standing.values()),
        given.shape[:-1],
        wanted.shape[:-1],
    )
    support = isinstance(com, str)
    weight = factor(COM, factors) * DEFAULT_WEIGHTS[0] if support else 0.0
    as_vectors([margin, margin * weight], "margin", 2)
    plan = Plan(
        np.array([target.kind for target in asked], np.int64),
        np.array([target.row for target in asked], np.int64),
        np.array([target.T_row_frame for target in asked]).reshape(-1, 4, 4),
        np.array([target.weights for target in asked]).reshape(-1, 2),
        support=weight,
        posture=factor("posture", factors) * DEFAULT_POSTURE,
        stance=BOTH if len(standing) == BOTH else SIDES.index(next(iter(standing))),
        as_is=False,
        tolerance=float(tolerance),
        steps=steps,
    )
    begin, near = (_rows(q[..., tables.order], batch, 1) for q in (given, wanted))
    poses, origin, polygons = _poses(
        ready,
        standing,
        asked,
        batch,
        margin if support else 0.0,
        near if enforce else tables.unwound(near, 0.0),
        begin if enforce else tables.unwound(begin, 0.0),
    )
    search = _Search(
        robot,
        ready,
        tables,
        asked,
        tuple(standing),
        plan,
        poses,
        origin,
        polygons,
        margin=float(margin) if support else 0.0,
        restarts=searches,
        seed=whole_number(seed, "seed", 0),
        threads=workers,
    )
    found = search.run(np.arange(len(begin)), as_is=posture is None, restarts=0)
    again = np.flatnonzero(found.report[:, STATUS] != REACHED)
    if again.size and searches:
        for all_rows, rows in zip(found, search.run(again), strict=True):
            all_rows[again] = rows
    if not enforce:
        found.x[:] = tables.unwound(found.x, near)
    return _result(search, found, _rows(given, batch, 1), batch, notes + more)


def _poses(
    ready: PreparedRobot,
    standing: Mapping[str, Floats],
    asked: list[Target],
    batch: tuple[int, ...],
    margin: float,
    posture: Floats,
    first: Floats,
) -> tuple[Poses, Floats, tuple[SupportPolygon, ...]]:
    """All arguments as rows, one for each pose, seen from the first foot that stands, which keeps digits far away.

    Returns:
        The rows, with one start for each pose; where the first foot is in the world, shape (n, 3) [m]; and the polygons
        below the feet, from there: one for each pose, or one for all.
    """
    n = math.prod(batch)
    feet = np.stack([_rows(standing.get(side, np.eye(4)), batch, 2) for side in SIDES], axis=1)
    origin = feet[:, SIDES.index(next(iter(standing))), :3, 3].copy()
    targets = np.empty((n, len(asked), 4, 4))
    for k, target in enumerate(asked):
        targets[:, k] = _rows(target.values, batch, 2)
    feet[:, :, :3, 3] -= origin[:, None]
    targets[:, :, :3, 3] -= origin[:, None]
    alike = all(T.ndim == 2 for T in standing.values())
    polygons = tuple(
        polygon_below((feet[i, SIDES.index(side)], ready.corners[side]) for side in standing)
        for i in range(min(n, 1) if alike else n)
    )
    edges = np.array([len(polygon.vertices) for polygon in polygons], np.int64)
    planes = np.zeros((len(polygons), int(edges.max(initial=0)), 3))
    for i, polygon in enumerate(polygons):
        planes[i, : edges[i]] = polygon.half_planes
        planes[i, : edges[i], 2] += margin
    if alike:
        planes, edges = np.repeat(planes, n, axis=0), np.repeat(edges, n)
    return Poses(feet, targets, planes, edges, posture, first[:, None]), origin, polygons


@dataclass(frozen=True, eq=False)
class _Search:
    """The compiled search for n poses.

    Attributes:
        robot: whose poses.
        ready: what is kept of it.
        tables: it as arrays, with or without limits.
        asked: the targets.
        standing: the feet that stand.
        plan: the targets for the kernel.
        poses: what `_poses` returns, with `origin` and `polygons`.
        origin: where the first foot is in the world, shape (n, 3) [m].
        polygons: below the feet.
        margin: how far inside them the centre of mass is to be [m].
        restarts: other starts to try, at most.
        seed: of these.
        threads: how many may work; None for all cores.
    """

    robot: RobotModel
    ready: PreparedRobot
    tables: BodyTables
    asked: list[Target]
    standing: tuple[str, ...]
    plan: Plan
    poses: Poses
    origin: Floats
    polygons: tuple[SupportPolygon, ...]
    margin: float
    restarts: int
    seed: int
    threads: int | None

    def run(
        self, rows: Ints, *, targets: list[int] | None = None, as_is: bool = False, restarts: int | None = None
    ) -> Found:
        """Search for some of the poses.

        Args:
            rows: which.
            targets: which of the targets to meet; an empty list for the support polygon alone, None for all.
            as_is: whether a reference that meets all targets is left as it is.
            restarts: other starts to try; None for all.
        """
        plan, body, poses = self.plan._replace(as_is=as_is), self.tables.body, self.poses
        if targets is not None:
            plan = plan._replace(
                kind=plan.kind[targets],
                row=plan.row[targets],
                T_row_frame=plan.T_row_frame[targets],
                weights=plan.weights[targets],
                support=0.0 if targets else plan.support,
            )
            poses = poses._replace(targets=poses.targets[:, targets])
        count = self.restarts if restarts is None else restarts
        poses = Poses._make(np.ascontiguousarray(part[rows]) for part in poses)
        if count:
            random = self.robot.random(np.random.default_rng(self.seed), count)[:, self.tables.order[: body.moving]]
            starts = np.repeat(poses.starts, 1 + count, axis=1)
            starts[:, 1:, : body.moving] = random  # the hands as in the reference
            poses = poses._replace(starts=starts)
        n, width = len(rows), poses.posture.shape[1]
        shapes = (width,), (4, 4), (len(plan.kind), 2), (3,), (4,)
        found = Found._make(np.zeros((n, *shape)) for shape in shapes)

        def solve(function: Callable[..., object], part: slice) -> None:
            some = Poses._make(array[part] for array in poses)
            function(body, self.ready.legs, plan, some, Found._make(array[part] for array in found))

        if n:
            threads = 1 if n == 1 else self.threads or usable_cores()
            run_rows(whole_bodies, solve, n, min(n, threads), each=(1 + count) * _PYTHON_SECONDS)
        return found


def _result(
    search: _Search, found: Found, reference: Floats, batch: tuple[int, ...], notes: tuple[str, ...]
) -> WholeBodyResult:
    robot, tables, body = search.robot, search.tables, search.tables.body
    status = found.report[:, STATUS]
    residuals = {target.name: found.residuals[:, k].copy() for k, target in enumerate(search.asked)}
    weights = [target.weights for target in search.asked]
    if search.plan.support > 0.0:
        residuals[COM] = np.column_stack([found.report[:, LACKING], np.zeros(len(status))])
        weights.append((search.plan.support, 0.0))
    away = np.array(
        [np.hypot(*(residual * pair).T) for residual, pair in zip(residuals.values(), weights, strict=True)]
    )
    stands = status != NOT_STANDING
    failed = np.flatnonzero((status != REACHED) & stands)
    worst, beyond = np.full(len(status), -1), np.zeros(len(status))
    reasons = np.full(len(status), Reason.REACHED, np.int8)
    if not stands.all():
        beyond[~stands] = feet_beyond(body, search.poses.feet[~stands])
        reasons[~stands] = np.where(beyond[~stands] > 0.0, Reason.OUT_OF_REACH, Reason.NOT_CONVERGED)
    if failed.size:
        # What is met does not give way, however much its rounding weighs.
        unmet = np.array([(residual > search.plan.tolerance).any(axis=-1) for residual in residuals.values()])
        worst[failed] = np.argmax(np.where(unmet | ~unmet.any(axis=0), away, -1.0)[:, failed], axis=0)
        beyond[failed] = _beyond(search, failed, worst)
        reasons[failed] = _why(search, failed, worst, beyond, found)
    q = reference.copy()
    q[:, tables.order] = found.x
    torso = found.T_world_torso.copy()
    torso[:, :3, 3] += search.origin
    if robot.base == "floating":
        T_world_root = torso @ np.linalg.inv(tables.torso_in_root)
        q[:, :3], q[:, 3:7] = T_world_root[:, :3, 3], quat_to_xyzw(quat_from_matrix(T_world_root[:, :3, :3]))
    com = found.com + search.origin
    values = found.x[:, : body.moving]
    near = np.minimum(values - body.limits.lower, body.limits.upper - values)
    if len(search.polygons) == 1:
        margins = search.polygons[0].signed_distance(found.com)
    else:
        pairs = zip(search.polygons, found.com, strict=True)
        margins = np.array([polygon.signed_distance(place) for polygon, place in pairs])
    for array in (q, torso, com, margins, *residuals.values()):
        array[~stands] = np.nan
    names = [robot.joint_names[int(k) - (robot.nq - len(robot.joint_names))] for k in tables.order]
    return WholeBodyResult(
        q=q.reshape(*batch, robot.nq),
        torso=torso.reshape(*batch, 4, 4),
        reasons=reasons.reshape(batch),
        residuals={name: residual.reshape(*batch, 2) for name, residual in residuals.items()},
        beyond=beyond.reshape(batch),
        worst=worst.reshape(batch),
        com=com.reshape(*batch, 3),
        margin=margins.reshape(batch),
        at_limits=(near <= _AT_LIMIT).reshape(*batch, body.moving),
        joints=tuple(names[: body.moving]),
        iterations=found.report[:, STEPS].astype(np.int64).reshape(batch),
        starts=np.where(stands, found.report[:, START].astype(np.int64) + 1, 1 + search.restarts).reshape(batch),
        standing=search.standing,
        notes=notes + _crossing(search, found, stands.reshape(batch)),
    )


def _beyond(search: _Search, failed: Ints, worst: Ints) -> Floats:
    """How far the targets that give way are certainly out of reach; 0 where that is not more than the tolerance."""
    poses, polygons, beyond = search.poses, search.polygons, np.zeros(len(failed))
    for place in np.unique(worst[failed]).tolist():
        mine = np.flatnonzero(worst[failed] == place)
        rows = failed[mine]
        if place < len(search.asked):
            target, places = search.asked[place], poses.targets[rows, place, :3, 3]
            beyond[mine] = target_beyond(search.tables.body, target, search.standing, poses.feet[rows], places)
        else:
            below = polygons if len(polygons) > 1 else polygons * len(worst)
            beyond[mine] = [margin_beyond(below[row], search.margin) for row in rows]
    return np.where(beyond > search.plan.tolerance, beyond, 0.0)


def _why(search: _Search, failed: Ints, worst: Ints, beyond: Floats, found: Found) -> Codes:
    """Whether the targets that give way are out of reach, or are met if there are no others."""
    status = found.report[failed, STATUS]
    reasons = np.where(status == STOPPED, Reason.NOT_CONVERGED, Reason.TARGETS_DISAGREE).astype(np.int8)
    reasons[beyond[failed] > 0.0] = Reason.OUT_OF_REACH
    is_alone = len(search.asked) + (search.plan.support > 0.0) == 1
    for place in np.unique(worst[failed]).tolist():
        mine = np.flatnonzero((worst[failed] == place) & (reasons == Reason.TARGETS_DISAGREE))
        targets = [place] if place < len(search.asked) else []
        report = found.report[failed[mine]] if is_alone else search.run(failed[mine], targets=targets).report
        reasons[mine[report[:, STATUS] != REACHED]] = Reason.NOT_CONVERGED
    return reasons


def _crossing(search: _Search, found: Found, stands: NDArray[np.bool_]) -> tuple[str, ...]:
    """Whether ankles are on swapped sides of the torso, as `legs` notes it."""
    if search.plan.stance != BOTH:
        return ()
    ankles = (search.poses.feet @ np.linalg.inv(search.tables.body.ankle_to_sole))[:, :, :3, 3]
    left = np.einsum("ni,ni->n", found.T_world_torso[:, :3, 1], ankles[:, 0] - ankles[:, 1])
    crossed = stands & (left < 0.0).reshape(stands.shape)
    return crossing_in_words(crossed, "poses") if crossed.any() else ()


def _configurations(robot: RobotModel, given: ArrayLike, what: str, enforce: bool) -> tuple[Floats, tuple[str, ...]]:
    """Configurations with unit quaternions, inside the limits if these are enforced, and notes."""
    array = as_vectors(given, what, robot.nq)
    return inside_limits(robot, array, what) if enforce else (with_unit_quaternion(robot, array, what), ())


def _rows(array: Floats, batch: tuple[int, ...], tail: int) -> Floats:
    """An array of shape (..., *tail) as rows, one for each pose; a copy."""
    own = array.shape[array.ndim - tail :]
    return np.array(np.broadcast_to(array, (*batch, *own)).reshape(-1, *own))
