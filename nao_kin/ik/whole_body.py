"""`whole_body`: a pose of the whole NAO, its feet standing, for hands, gaze and centre of mass."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import MOST_SEARCHES, Floats, as_vectors, check_tolerance, common_batch, whole_number
from nao_kin._core.process import usable_cores
from nao_kin.ik.body import SIDES, Ints
from nao_kin.ik.body_errors import POSE
from nao_kin.ik.body_search import BOTH, LACKING, NOT_STANDING, REACHED, START, STATUS, STEPS, STOPPED, whole_bodies
from nao_kin.ik.body_targets import (
    DEFAULT_POSTURE,
    DEFAULT_WEIGHTS,
    BodyTables,
    PreparedRobot,
    Target,
    all_targets,
    checked_weights,
    factor,
    feet_beyond,
    margin_beyond,
    plan_of,
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

# The second foot as a target of the search that brings the robot to stand.
_FOOT_WEIGHTS = (1.0, 0.1)
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
    counts = (
        whole_number(restarts, "restarts", 0, MOST_SEARCHES),
        whole_number(iterations, "iterations", 1, MOST_SEARCHES),
    )
    workers = check_threads(threads)
    given, notes = (ready.rest, ()) if reference is None else _configurations(robot, reference, "reference", enforce)
    at_reference = np.asarray(robot.fk(given, ["LLeg", "RLeg"]))
    standing = standing_feet(feet, at_reference)
    asked = all_targets(tables, standing, targets, com, gaze, torso, factors)
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
    problem = _Problem.laid_out(ready, tables, standing, asked, batch, float(margin) if support else None)
    pull = factor("posture", factors) * DEFAULT_POSTURE
    begin, near = (_rows(q[..., tables.order], batch, 1) for q in (given, wanted))
    unwound = (begin, near) if enforce else (tables.unwound(begin, 0.0), tables.unwound(near, 0.0))
    starts = _Starts(tables, unwound[0], counts[0], whole_number(seed, "seed", 0))
    search = _Search(ready, tables, problem, starts, unwound[1], pull, float(tolerance), counts[1], workers)
    found = search.run(asked, weight, as_is=posture is None, restarts=False)
    again = np.flatnonzero(found.report[:, STATUS] != REACHED)
    if again.size and counts[0]:
        found.put(again, search.run(asked, weight, as_is=False, rows=again))
    if not enforce:
        found.x[:] = tables.unwound(found.x, near)
    return _result(search, asked, weight, found, _rows(given, batch, 1), batch, tuple(standing), notes + more)


@dataclass(frozen=True, eq=False)
class _Problem:
    """n poses to find, seen from the first foot that stands, so that a far origin costs no digits.

    Attributes:
        stance: 0 for the left foot, 1 for the right one, 2 for both.
        origin: where the first foot is in the world, shape (n, 3) [m].
        feet: T_origin_foot, shape (n, 2, 4, 4).
        targets: shape (n, t, 4, 4).
        polygons: below the feet, from the origin; one of each pose, or one for all.
        margin: how far inside them the centre of mass is to be [m].
        planes: their half planes moved inwards by the margin, shape (n, k, 3).
        edges: how many of each count, shape (n,).
    """

    stance: int
    origin: Floats
    feet: Floats
    targets: Floats
    polygons: tuple[SupportPolygon, ...]
    margin: float
    planes: Floats
    edges: Ints

    @staticmethod
    def laid_out(
        ready: PreparedRobot,
        tables: BodyTables,
        standing: Mapping[str, Floats],
        asked: list[Target],
        batch: tuple[int, ...],
        margin: float | None,
    ) -> _Problem:
        """All arguments as rows, one for each pose; without a margin, the polygon asks for nothing."""
        n = math.prod(batch)
        feet = np.broadcast_to(np.eye(4), (n, 2, 4, 4)).copy()
        for side, T in standing.items():
            feet[:, SIDES.index(side)] = _rows(T, batch, 2)
        first = SIDES.index(next(iter(standing)))
        origin = feet[:, first, :3, 3].copy()
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
            planes[i, : edges[i], 2] += margin or 0.0
        if alike:
            planes, edges = np.repeat(planes, n, axis=0), np.repeat(edges, n)
        stance = BOTH if len(standing) == BOTH else first
        return _Problem(stance, origin, feet, targets, polygons, margin or 0.0, planes, edges)

    def margins(self, com: Floats) -> Floats:
        """How far centres of mass, from the origin, are inside the polygons, shape (n,) for (n, 3)."""
        if len(self.polygons) == 1:
            return self.polygons[0].signed_distance(com)
        return np.array([polygon.signed_distance(c) for polygon, c in zip(self.polygons, com, strict=True)])


@dataclass(frozen=True, eq=False)
class _Found:
    """What the kernel writes, n rows each: variables, T_origin_torso, residuals, centres of mass and reports."""

    x: Floats
    torso: Floats
    residuals: Floats
    com: Floats
    report: Floats

    def put(self, rows: Ints, other: _Found) -> None:
        """Write the rows of another search over some of these."""
        self.x[rows], self.torso[rows], self.residuals[rows] = other.x, other.torso, other.residuals
        self.com[rows], self.report[rows] = other.com, other.report


class _Starts:
    """Where searches begin: at the references, and at random configurations, which are drawn when they are needed."""

    def __init__(self, tables: BodyTables, first: Floats, count: int, seed: int) -> None:
        self.first, self.count = first, count
        self._tables, self._seed = tables, seed

    def rows(self, rows: Ints, *, restarts: bool) -> Floats:
        """Variables of all starts for some poses, the hands as in the reference, shape (n, starts, variables)."""
        starts = np.repeat(self.first[rows, None], 1 + (self.count if restarts else 0), axis=1)
        if restarts:
            moving = self._tables.body.moving
            random = self._tables.robot.random(np.random.default_rng(self._seed), self.count)
            starts[:, 1:, :moving] = random[:, self._tables.order[:moving]]
        return starts


@dataclass(frozen=True, eq=False)
class _Search:
    """The compiled search with all that does not change from call to call."""

    ready: PreparedRobot
    tables: BodyTables
    problem: _Problem
    starts: _Starts
    posture: Floats
    pull: float
    tolerance: float
    iterations: int
    threads: int | None

    def run(
        self,
        asked: list[Target],
        support: float,
        *,
        as_is: bool,
        restarts: bool = True,
        rows: Ints | None = None,
        places: list[int] | None = None,
    ) -> _Found:
        """Search for some of the poses, with some of the targets; for all with all where nothing is said."""
        problem, body = self.problem, self.tables.body
        some = np.arange(len(self.posture)) if rows is None else rows
        which = list(range(len(asked))) if places is None else places
        plan = plan_of([asked[k] for k in which], support, self.pull)
        sole = Target("", POSE, int(body.legs[1, -1]), body.ankle_to_sole[1], np.eye(4), _FOOT_WEIGHTS)
        feet_plan = plan_of([sole], 0.0, DEFAULT_POSTURE)
        n, width = len(some), len(self.tables.order)
        found = _Found(
            np.zeros((n, width)), np.zeros((n, 4, 4)), np.zeros((n, len(which), 2)), np.zeros((n, 3)), np.zeros((n, 4))
        )
        feet, targets, planes, near = (
            np.ascontiguousarray(array[some])
            for array in (problem.feet, problem.targets[:, which], problem.planes, self.posture)
        )
        edges, begin = problem.edges[some], self.starts.rows(some, restarts=restarts)

        def solve(function: Callable[..., object], part: slice) -> None:
            function(
                body, self.ready.legs, plan, feet_plan, problem.stance, feet[part], targets[part], planes[part],
                edges[part], near[part], begin[part], as_is, self.tolerance, self.iterations,
                found.x[part], found.torso[part], found.residuals[part], found.com[part], found.report[part],
            )  # fmt: skip

        if n:
            workers, each = min(n, self.threads or usable_cores()), begin.shape[1] * _PYTHON_SECONDS
            run_rows(whole_bodies, solve, n, workers, each=each)
        return found


def _result(
    search: _Search,
    asked: list[Target],
    support: float,
    found: _Found,
    reference: Floats,
    batch: tuple[int, ...],
    standing: tuple[str, ...],
    notes: tuple[str, ...],
) -> WholeBodyResult:
    robot, tables, problem = search.tables.robot, search.tables, search.problem
    status = found.report[:, STATUS]
    residuals = {target.name: found.residuals[:, k].copy() for k, target in enumerate(asked)}
    weights = [target.weights for target in asked]
    if support > 0.0:
        residuals[COM] = np.column_stack([found.report[:, LACKING], np.zeros(len(status))])
        weights.append((support, 0.0))
    away = np.array(
        [np.hypot(*(residual * pair).T) for residual, pair in zip(residuals.values(), weights, strict=True)]
    )
    stands = status != NOT_STANDING
    failed = np.flatnonzero((status != REACHED) & stands)
    worst, beyond = np.full(len(status), -1), np.zeros(len(status))
    reasons = np.full(len(status), Reason.REACHED, np.int8)
    if not stands.all():
        beyond[~stands] = feet_beyond(tables.body, problem.feet[~stands])
        reasons[~stands] = np.where(beyond[~stands] > 0.0, Reason.OUT_OF_REACH, Reason.NOT_CONVERGED)
    if failed.size:
        # What is met does not give way, however much its rounding weighs.
        unmet = np.array([(residual > search.tolerance).any(axis=-1) for residual in residuals.values()])
        worst[failed] = np.argmax(np.where(unmet | ~unmet.any(axis=0), away, -1.0)[:, failed], axis=0)
        beyond[failed] = _beyond(search, asked, standing, failed, worst)
        reasons[failed] = _why(search, asked, support, failed, worst, beyond, found)
    q = reference.copy()
    q[:, tables.order] = found.x
    torso = found.torso.copy()
    torso[:, :3, 3] += problem.origin
    if robot.base == "floating":
        T_world_root = torso @ np.linalg.inv(tables.torso_in_root)
        q[:, :3], q[:, 3:7] = T_world_root[:, :3, 3], quat_to_xyzw(quat_from_matrix(T_world_root[:, :3, :3]))
    com = found.com + problem.origin
    values = found.x[:, : tables.body.moving]
    names = tuple(robot.joint_names[int(k) - (robot.nq - len(robot.joint_names))] for k in tables.order)
    near = np.minimum(values - tables.body.lower[: values.shape[1]], tables.body.upper[: values.shape[1]] - values)
    margins = problem.margins(found.com)
    for array in (q, torso, com, margins, *residuals.values()):
        array[~stands] = np.nan
    return WholeBodyResult(
        q=q.reshape(*batch, robot.nq),
        torso=torso.reshape(*batch, 4, 4),
        reasons=reasons.reshape(batch),
        residuals={name: residual.reshape(*batch, 2) for name, residual in residuals.items()},
        beyond=beyond.reshape(batch),
        worst=worst.reshape(batch),
        com=com.reshape(*batch, 3),
        margin=margins.reshape(batch),
        at_limits=(near <= _AT_LIMIT).reshape(*batch, values.shape[1]),
        joints=names[: values.shape[1]],
        iterations=found.report[:, STEPS].astype(np.int64).reshape(batch),
        starts=np.where(stands, found.report[:, START].astype(np.int64) + 1, 1 + search.starts.count).reshape(batch),
        standing=standing,
        notes=notes + _crossing(search, found, stands.reshape(batch)),
    )


def _beyond(search: _Search, asked: list[Target], standing: tuple[str, ...], failed: Ints, worst: Ints) -> Floats:
    """How far the targets that give way are certainly out of reach; 0 where that is not more than the tolerance."""
    problem, beyond = search.problem, np.zeros(len(failed))
    for place in np.unique(worst[failed]).tolist():
        mine = np.flatnonzero(worst[failed] == place)
        rows = failed[mine]
        if place < len(asked):
            places = problem.targets[rows, place, :3, 3]
            beyond[mine] = target_beyond(search.tables.body, asked[place], standing, problem.feet[rows], places)
        else:
            polygons = problem.polygons if len(problem.polygons) > 1 else problem.polygons * len(worst)
            beyond[mine] = [margin_beyond(polygons[row], problem.margin) for row in rows]
    return np.where(beyond > search.tolerance, beyond, 0.0)


def _why(
    search: _Search, asked: list[Target], support: float, failed: Ints, worst: Ints, beyond: Floats, found: _Found
) -> Codes:
    """Whether the targets that give way are out of reach, or are met if there are no others."""
    status = found.report[failed, STATUS]
    reasons = np.where(status == STOPPED, Reason.NOT_CONVERGED, Reason.TARGETS_DISAGREE).astype(np.int8)
    reasons[beyond[failed] > 0.0] = Reason.OUT_OF_REACH
    count = len(asked) + (support > 0.0)
    for place in np.unique(worst[failed]).tolist():
        mine = np.flatnonzero((worst[failed] == place) & (reasons == Reason.TARGETS_DISAGREE))
        rows = failed[mine]
        is_com = place == len(asked)
        alone = _Found(found.x, found.torso, found.residuals, found.com, found.report[rows])
        if count > 1:
            weight = support if is_com else 0.0
            alone = search.run(asked, weight, as_is=False, rows=rows, places=[] if is_com else [place])
        reasons[mine[alone.report[:, STATUS] != REACHED]] = Reason.NOT_CONVERGED
    return reasons


def _crossing(search: _Search, found: _Found, stands: NDArray[np.bool_]) -> tuple[str, ...]:
    """Whether ankles are on swapped sides of the torso, as `legs` notes it."""
    if search.problem.stance != BOTH:
        return ()
    sole_to_ankle = np.linalg.inv(search.tables.body.ankle_to_sole)
    ankles = (search.problem.feet @ sole_to_ankle)[:, :, :3, 3]
    left = np.einsum("ni,ni->n", found.torso[:, :3, 1], ankles[:, 0] - ankles[:, 1])
    crossed = stands & (left < 0.0).reshape(stands.shape)
    return crossing_in_words(crossed, "poses")


def _configurations(robot: RobotModel, given: ArrayLike, what: str, enforce: bool) -> tuple[Floats, tuple[str, ...]]:
    """Configurations with unit quaternions, inside the limits if these are enforced, and notes."""
    array = as_vectors(given, what, robot.nq)
    return inside_limits(robot, array, what) if enforce else (with_unit_quaternion(robot, array, what), ())


def _rows(array: Floats, batch: tuple[int, ...], tail: int) -> Floats:
    """An array of shape (..., *tail) as rows, one for each pose; a copy."""
    own = array.shape[array.ndim - tail :]
    return np.array(np.broadcast_to(array, (*batch, *own)).reshape(-1, *own))
