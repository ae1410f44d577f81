"""What arms do besides taking directions: hands at places, opened hands, and room for other links."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, between_samples, dot, norm
from nao_kin.imitation.directions import Directions
from nao_kin.imitation.layouts import SIDES
from nao_kin.imitation.limbs import LimbMap
from nao_kin.imitation.stance import slowly
from nao_kin.robot import CollisionRule, RobotModel

# From the wrist to the knuckles, as a share of the forearm, where the hand is unknown.
_HAND = 0.35
# Limbs keep this distance from other links, more than asked [m].
_ROOM = 0.002
# Between frames, overlaps are looked for where a joint has moved this far [rad].
_SPACING = 0.05
# How fast the share may change by which a limb makes room [1/s], its smallest change, and how often it grows.
_EASING, _STEP, _ROUNDS = 2.0, 0.03, 60


def places_of_hands(solver: LimbMap, points: Mapping[str, Floats], person: Directions) -> Floats:
    """Return places of hands from the robot's shoulders, in its torso, shape (n, 2, 3) [m]; NaN where unknown.

    From the middle of the shoulders, they are those of the person times the ratio of the spans.
    """
    left, right = points["left_shoulder"], points["right_shoulder"]
    middle, gaps = (left + right) / 2.0, np.full(left.shape, np.nan)
    hands, lengths = [], []
    for side in SIDES:
        elbow, wrist = (points.get(side + part, gaps) for part in ("elbow", "wrist"))
        hand = points.get(side + "hand", gaps)
        hands.append(np.where(np.isnan(hand), wrist + _HAND * (wrist - elbow), hand))
        lengths.append(norm(elbow - points[side + "shoulder"]) + norm(hands[-1] - elbow))
    shoulder, upper, fore = solver.lengths
    span = _median(norm(left - right)) / 2.0 + _median(np.array(lengths))
    seen = (np.stack(hands, axis=1) - middle[:, None]) @ person.torso
    from_shoulders = np.array([[0.0, -shoulder, 0.0], [0.0, shoulder, 0.0]])
    return np.asarray((shoulder + upper + fore) / span * seen + from_shoulders)


def _median(lengths: Floats) -> float:
    """Return the median of known lengths, NaN if there are none."""
    known = lengths[np.isfinite(lengths)]
    return float(np.median(known)) if len(known) else math.nan


def opened(robot: RobotModel, points: Mapping[str, Floats], q: Floats) -> list[int]:
    """Write the opening of hands whose fingertip is known into configurations; return their coordinates.

    With the bend β of the fingers, from the line of wrist and knuckles to that of knuckles and tip, it is
    (1 + cos β) / 2.
    """
    columns = []
    for side in SIDES:
        name, parts = f"{side[0].upper()}Hand", [side + part for part in ("wrist", "hand", "finger")]
        if name not in robot.joint_names or not all(part in points for part in parts):
            continue
        wrist, hand, tip = (points[part] for part in parts)
        with np.errstate(invalid="ignore", divide="ignore"):
            opening = 0.5 + 0.5 * dot(hand - wrist, tip - hand) / (norm(hand - wrist) * norm(tip - hand))
        if np.isfinite(opening).any():
            columns.append(robot.joint_names.index(name) + robot.nq_base)
            q[:, columns[-1]] = between_samples(opening[:, None])[:, 0]
    return columns


def make_room(
    robot: RobotModel, solver: LimbMap, times: Floats, q: Floats, rule: CollisionRule, changed: NDArray[np.bool_]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return configurations in which limbs make room where links overlap, and left arm, right arm or head (n, 3) do.

    Only frames that have `changed`, (n,), may overlap. ShoulderRoll goes the least share of the way to its outward
    limit, and the head of that to the middle, eased in and out in time. Overlaps are looked for in frames and on the
    straight lines between them.
    """
    n, share, made = len(q), np.zeros((len(q), 3)), np.array(q)
    links = [solver.links(limb) for limb in range(3)]
    pieces = np.maximum(np.ceil(np.abs(np.diff(q, axis=0)).max(axis=1, initial=0.0) / _SPACING), 1.0).astype(np.int64)
    first = np.append(np.repeat(np.arange(n - 1), pieces), n - 1)
    second = np.minimum(first + 1, n - 1)
    parts = np.append(np.concatenate([np.arange(count) / count for count in pieces] or [[]]), 0.0)
    for _ in range(_ROUNDS):
        todo = np.flatnonzero(changed[first] | changed[second])
        start, end, part = made[first[todo]], made[second[todo]], parts[todo, None]
        found = robot.clearance(start + part * (end - start), **vars(rule))
        close = np.flatnonzero(found.distance < _ROOM - rule.tolerance)
        more = np.zeros((n, 3))
        for i, k in zip(todo[close], np.asarray(found.pair_index)[close], strict=True):
            moving = [_STEP * (not own.isdisjoint(found.pairs[k])) for own in links]
            for frame in (first[i], second[i])[: 1 + (parts[i] > 0.0)]:
                more[frame] = np.maximum(more[frame], moving)
        more = np.where(share < 1.0, more, 0.0)
        if not more.any():
            break
        grown = -slowly(times, -np.minimum(share + more, 1.0), _EASING)
        changed = np.any(grown > share, axis=1)
        share = grown
        made[changed] = solver.outwards(q[changed], share[changed])
    return made, share > 0.0
