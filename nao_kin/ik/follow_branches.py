"""The branch of a limb at each sample of a path, by dynamic programming for the least total motion.

The motion between two samples is Σ (Δq_j / v_j)² over the joints, with their speed limits v_j; its sum over the path is
the least of all sequences of branches (Bellman 1957; for inverse kinematics Ferrentino and Chiacchio, IEEE T-RO 2020).
Squares favour continuity: continuous motion of length L costs L²/m in m steps, a jump of the same length always L².

The joint values of a member of a family, or of a nearest pose, depend on the previous sample. Such a sample is solved
once for each branch of the previous one, with that branch as the reference; the result then follows that branch
only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats
from nao_kin._core.layers import reached, traced
from nao_kin.ik.follow_limbs import LimbPath
from nao_kin.ik.results import Codes, Family, IKResult, Integers, Reason
from nao_kin.robot import CollisionRule, RobotModel

# In a family, every branch of the previous sample adds its own member; only this many, the cheapest, are kept.
_MAX_CANDIDATES = 16
# Members that differ by less than this are the same [rad].
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class FollowedLimb:
    """One limb at n samples.

    Attributes:
        name: "LLeg", "RLeg", "legs" for both, "LArm", "RArm" or "Head".
        columns: the coordinates of q that it moves.
        reasons: a `Reason` for each sample as a number, shape (n,).
        residual: errors of the pose in position and rotation angle, shape (n, 2) [m, rad]; nan without values.
        messages: the reason in words for each sample that is not reached.
    """

    name: str
    columns: tuple[int, ...]
    reasons: Codes
    residual: Floats
    messages: Mapping[int, str]

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Which samples are reached, shape (n,)."""
        return np.asarray(self.reasons == Reason.REACHED)


class Choice(NamedTuple):
    """A limb at n samples: the values of its coordinates (n, c) or nan, and the sum of the squared motion [s²]."""

    limb: FollowedLimb
    values: Floats
    cost: float


class _Layer(NamedTuple):
    """Candidates at one sample, k of them."""

    sample: int
    values: Floats  # shape (k, c)
    cost: Floats  # least cost up to each, shape (k,)
    back: Integers  # index of its predecessor, shape (k,)
    answers: list[IKResult]  # the solver's result for each
    rows: Integers  # index of its target in that result


def choose(
    limb: LimbPath, reference: Floats, weights: Floats, *, start: Floats | None = None, end: Floats | None = None
) -> Choice:
    """Return the branches of a limb with the least motion, weighted by 1/v_j, from `start` and to `end` if given."""
    n = len(limb.targets[0])
    # If every sample depends on the previous one, only the first can be solved ahead.
    ahead = 1 if limb.follows_only else n
    first = limb.at(*range(ahead)).solve(reference[:ahead])
    columns = list(first.columns)
    layers: list[_Layer] = []
    before = None if start is None else _Layer(-1, start[None, columns], np.zeros(1), np.zeros(1, np.int64), [], _NONE)
    for i in range(n):
        layer = _layer(limb, first, i, before, reference, weights[columns])
        if layer is not None:
            layers.append(layer)
            before = layer
    chosen: list[tuple[_Layer, int]] = []
    cost = 0.0
    if layers:
        last = layers[-1].cost
        if end is not None:
            last = last + _squares((layers[-1].values - end[columns]) * weights[columns])
        place = int(np.argmin(last))
        cost = float(last[place])
        places = traced([layer.back for layer in layers], place)
        chosen = list(zip(layers, places, strict=True))
    return _choice(limb, first, reference, n, chosen, cost)


_NONE = np.zeros(0, dtype=np.int64)


def _answer(limb: LimbPath, first: IKResult, i: int, reference: Floats) -> tuple[IKResult, int]:
    """Return the solver's result for sample i and its target's index in it, taken from `first` or solved now."""
    return (first, i) if i < len(first.count) else (limb.at(i).solve(reference[i : i + 1]), 0)


def _layer(
    limb: LimbPath, first: IKResult, i: int, before: _Layer | None, reference: Floats, weights: Floats
) -> _Layer | None:
    """Return the candidates at sample i; None if there are none."""
    if before is None or i < len(first.count):
        answer, row = _answer(limb, first, i, reference)
        count = int(answer.count[row])
        values = answer.branches[row, :count] if count else answer.best[row : row + 1]
        if np.isnan(values).any():
            return None
        rows = np.full(len(values), row)
        if before is None:  # the first sample with candidates
            return _Layer(i, values, np.zeros(len(rows)), np.zeros_like(rows), [answer] * len(rows), rows)
        if count and (answer.families[row, :count] == Family.NONE).all():
            cost, back = reached(before.cost, before.values, values, weights)
            return _Layer(i, values, cost, back, [answer] * len(rows), rows)
    return _followed(limb, first, i, before, reference, weights)


def _followed(
    limb: LimbPath, first: IKResult, i: int, before: _Layer, reference: Floats, weights: Floats
) -> _Layer | None:
    """Return the candidates at a sample that is solved anew for each candidate of the previous one."""
    k = len(before.values)
    references = np.tile(reference[i], (k, 1))
    references[:, list(first.columns)] = before.values
    result = limb.at(*[i] * k).solve(references)
    # Branches outside families do not depend on the reference: those of the first row are those of all rows.
    single = np.flatnonzero(result.families[0, : result.count[0]] == Family.NONE)
    values = [result.branches[0, single]]
    cost, back = reached(before.cost, before.values, values[0], weights)
    costs, backs, rows = [cost], [back], [np.zeros(len(single), dtype=np.int64)]
    for p in range(k):
        members = result.branches[p, : result.count[p]][result.families[p, : result.count[p]] != Family.NONE]
        if not result.count.any():  # without any solution, the nearest poses
            members = result.best[p : p + 1]
        if not len(members) or np.isnan(members).any():
            continue
        values.append(members)
        costs.append(before.cost[p] + _squares((members - before.values[p]) * weights))
        backs.append(np.full(len(members), p))
        rows.append(np.full(len(members), p))
    joined, cost = np.concatenate(values), np.concatenate(costs)
    if not len(joined):
        return None
    kept = _cheapest(joined, cost)
    back, row = np.concatenate(backs)[kept], np.concatenate(rows)[kept]
    return _Layer(i, joined[kept], cost[kept], back, [result] * len(kept), row)


def _cheapest(values: Floats, cost: Floats) -> Integers:
    """Return the indices of the cheapest candidates, without equal ones."""
    order = np.argsort(cost, kind="stable")
    kept: list[int] = []
    for place in order:
        if all(np.abs(values[place] - values[other]).max() > _SAME for other in kept):
            kept.append(int(place))
        if len(kept) == _MAX_CANDIDATES:
            break
    return np.array(kept, dtype=np.int64)


def _choice(
    limb: LimbPath, first: IKResult, reference: Floats, n: int, chosen: list[tuple[_Layer, int]], cost: float
) -> Choice:
    values = np.full((n, len(first.columns)), np.nan)
    answers = {}
    for layer, place in chosen:
        answers[layer.sample] = layer.answers[place], int(layer.rows[place])
        values[layer.sample] = layer.values[place]
    residual, reasons, messages = np.full((n, 2), np.nan), np.zeros(n, dtype=np.int8), {}
    for i in range(n):
        answer, row = answers.get(i) or _answer(limb, first, i, reference)
        reasons[i] = answer.reasons[row]
        if i in answers:
            residual[i] = answer.residual[row]
        if reasons[i] or i not in answers:
            messages[i] = answer.describe((row,))
    return Choice(FollowedLimb(limb.name, first.columns, reasons, residual, messages), values, cost)


def _squares(displacements: Floats) -> Floats:
    return np.asarray((displacements**2).sum(axis=-1))


# --- Jumps: steps between two samples that do not become smaller with a finer path between the two targets.
#
# First, every joint moves linearly from one value to the other. If the limb halfway deviates by less than a quarter of
# the distance, the step follows the path as closely as the path is sampled, and is not a jump. Otherwise the path
# between the two poses is divided into fifteen pieces, with the branches of least motion. The largest step of these is
# divided again, and so on, three times in all. On a continuous path the largest step shrinks each time to a fifteenth;
# at a singularity, where joints move like a square root, to a quarter. A jump keeps its size.

# Steps smaller than this, the resolution of NAO's joint sensors (0.1°), are not jumps [rad].
_SMALLEST = 1.75e-3
# A step follows the path if the limb halfway deviates by less than this share of the distance.
_MAX_DEVIATION = 0.25
# An odd number, because there is no mean of opposite directions.
_PIECES = 15
_ZOOMS = 3
# A branch that moves by more between two samples, when it is continued without limits, has ended [rad].
_FAR = 1.0
# A step is a jump if the last division does not make it smaller than this share of its size.
_JUMP_SHRINKAGE = 0.5


@dataclass(frozen=True)
class Jump:
    """Two samples between which a limb cannot move continuously along the path.

    Attributes:
        index: the first of them.
        limb: "LLeg", "RLeg", "legs", "LArm", "RArm" or "Head".
        joint: the joint that takes longest at its speed limit.
        size: its change [rad].
        cause: where and why the branch before the jump ends.
    """

    index: int
    limb: str
    joint: str
    size: float
    cause: str

    def describe(self) -> str:
        """Return the jump in a sentence.

        Examples:
            >>> Jump(3, "LArm", "LElbowYaw", 2.1, "another branch").describe()
            'LArm jumps after sample 3: LElbowYaw by 2.1 rad; another branch'
        """
        return f"{self.limb} jumps after sample {self.index}: {self.joint} by {self.size:.3g} rad; {self.cause}"


def jumps_of(limb: LimbPath, choice: Choice, reference: Floats, weights: Floats) -> tuple[Jump, ...]:
    """Return the jumps of a limb; arguments as for `choose`."""
    columns = list(choice.limb.columns)
    known = np.asarray(np.isfinite(choice.values).all(axis=1))
    large = np.abs(np.diff(choice.values, axis=0)).max(axis=1, initial=0.0) > _SMALLEST
    steps = np.flatnonzero(known[:-1] & known[1:] & large)
    if not len(steps):
        return ()
    q = np.array(reference)
    q[:, columns] = choice.values
    jumps = []
    for i in steps[_leaves_path(limb, q[steps], q[steps + 1])]:
        if _stays(limb, q[i], q[i + 1], weights, columns):
            step = choice.values[i + 1] - choice.values[i]
            place = int(np.argmax(np.abs(step) * weights[columns]))
            joint = _joint_of(limb.robot, columns[place])
            jumps.append(Jump(int(i), limb.name, joint, float(step[place]), _cause(limb, q, int(i), columns)))
    return tuple(jumps)


def _leaves_path(limb: LimbPath, first: Floats, second: Floats) -> Floats:
    """Return whether the limb's points deviate from straight lines when its joints move linearly, shape (m,)."""
    ends = limb.points(first), limb.points(second)
    halfway = limb.points(0.5 * (first + second))
    distance = np.linalg.norm(ends[1] - ends[0], axis=-1).max(axis=-1)
    deviation = np.linalg.norm(halfway - 0.5 * (ends[0] + ends[1]), axis=-1).max(axis=-1)
    return np.asarray(deviation > _MAX_DEVIATION * distance)


def _stays(limb: LimbPath, first: Floats, second: Floats, weights: Floats, columns: list[int]) -> bool:
    """Return whether a step keeps its size when the path between its two poses is divided."""
    shares = np.arange(1, _PIECES) / _PIECES
    size = float(np.abs(second - first)[columns].max())
    for _ in range(_ZOOMS):
        inner = limb.between(first, second, shares)
        reference = np.tile(first, (len(shares), 1))
        values = choose(inner, reference, weights, start=first, end=second).values
        known = np.isfinite(values).all(axis=1)
        q = np.concatenate([[first], reference[known], [second]])
        q[1:-1, columns] = values[known]
        steps = np.abs(np.diff(q[:, columns], axis=0)).max(axis=1)
        place = int(np.argmax(steps))
        before, size = size, float(steps[place])
        if size < _SMALLEST:
            return False
        first, second = q[place], q[place + 1]
    return size > _JUMP_SHRINKAGE * before


def _cause(limb: LimbPath, q: Floats, i: int, columns: list[int]) -> str:
    """Return why the branch of sample i ends, by continuing it without limits until it is outside them."""
    now = q[i]
    for sample in range(i + 1, len(q)):
        found = limb.at(sample).solve(now[None], limits="ignore", collisions=False)
        if not found.count[0]:
            return f"its branch ends at sample {sample}: {found.describe((0,))}"
        step = found.branches[0, 0] - now[columns]
        if np.abs(step).max() > _FAR:
            return f"its branch ends at sample {sample}"
        now = np.array(q[sample])
        now[columns] = found.branches[0, 0]
        if sample == i + 1 and np.abs(now - q[sample]).max() < _SMALLEST:
            return "the limb cannot move straight from one pose to the other"
        moved = {_joint_of(limb.robot, column) for column in columns}
        outside = [row for row in limb.robot.limit_violations(now) if row.joint in moved]
        if outside and limb.options.get("limits") != "ignore":
            return f"its branch ends at sample {sample}, where {outside[0].describe()}"
        rule = CollisionRule.of(limb.options.get("collisions", False))
        if rule is not None:
            shapes = limb.robot.link_shapes.among(rule.obstacles)
            contacts = shapes.contacts(now, -rule.tolerance, rule)
            pairs = {pair for pair, moved in zip(shapes.pairs, shapes.moved(columns), strict=True) if moved}
            overlapping = [contact for contact in contacts if contact.links in pairs]
            if overlapping:
                return f"its branch ends at sample {sample}, where {overlapping[0].describe()}"
    return "its branch continues, but the jump reduces the total motion"


def _joint_of(robot: RobotModel, column: int) -> str:
    return robot.joint_names[column - robot.nq_base]
