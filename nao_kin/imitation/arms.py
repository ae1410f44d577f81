"""What arms do besides taking directions: hands at places, opened hands, and room for other links."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, between_samples, dot, eased, norm
from nao_kin.imitation.limbs import SIDES, Directions, LimbMap
from nao_kin.imitation.stance import slowly
from nao_kin.robot import CollisionRule, RobotModel

TARGETS = ("direction", "place", "mixed")
# From the wrist to the knuckles, as a share of the forearm, where the hand is unknown.
_HAND = 0.35
# Hands are near each other below the first and apart above the second of these shares of the arm's length.
_NEAR, _APART = 0.25, 0.75
# An arm keeps this distance from other links, more than asked, for frames are joined by straight lines [m].
_ROOM = 0.002
# How fast the share may change by which an arm is out to the side [1/s], its smallest change, and how often it grows.
_EASING, _STEP, _ROUNDS = 2.0, 0.03, 60


def to_places(solver: LimbMap, points: Mapping[str, Floats], person: Directions, *, mixed: bool) -> Directions:
    """Return directions of arms with which the hands are at the person's places, times the ratio of the spans.

    Places count from the middle of the shoulders. The elbow is on the side of the line from shoulder to hand where the
    person's is; `mixed` is as in `imitate`.
    """
    left, right = points["left_shoulder"], points["right_shoulder"]
    middle, half = (left + right) / 2.0, float(np.nanmedian(norm(left - right))) / 2.0
    gaps = np.full(left.shape, np.nan)
    hands, lengths = [], []
    for side in SIDES:
        elbow, wrist = (points.get(f"{side}_{part}", gaps) for part in ("elbow", "wrist"))
        hand = points.get(f"{side}_hand", gaps)
        hand = np.where(np.isnan(hand), wrist + _HAND * (wrist - elbow), hand)
        hands.append(hand)
        lengths.append(norm(elbow - points[f"{side}_shoulder"]) + norm(hand - elbow))
    known = np.isfinite(lengths).any()
    reach = float(np.nanmedian(lengths)) if known else 1.0
    shoulder, upper, fore, bend = solver.lengths
    scale = (shoulder + upper + fore) / (half + reach)
    shortest = np.sqrt(upper**2 + fore**2 + 2.0 * upper * fore * np.cos(bend))
    share = np.ones(len(left))
    if mixed:
        away = np.clip((_APART - norm(hands[0] - hands[1]) / reach) / (_APART - _NEAR), 0.0, 1.0)
        share = np.nan_to_num(eased(away))
    uppers, forearms = np.array(person.upper_arms), np.array(person.forearms)
    for k, sign in enumerate((1.0, -1.0)):
        place = scale * ((hands[k] - middle)[:, None] @ person.torso)[:, 0] - (0.0, sign * shoulder, 0.0)
        distance = norm(place)
        along = place / np.maximum(distance, 1e-9)[:, None]
        distance = np.clip(distance, shortest, upper + fore)
        out = uppers[:, k] - dot(uppers[:, k], along)[:, None] * along
        length = norm(out)[:, None]
        down = (along[:, 2:] * along - (0.0, 0.0, 1.0)) / np.maximum(norm(along[:, :2]), 1e-9)[:, None]
        out = np.where(length > 1e-6, out / np.maximum(length, 1e-9), down)
        cosine = np.clip((upper**2 + distance**2 - fore**2) / (2.0 * upper * distance), -1.0, 1.0)
        one = cosine[:, None] * along + np.sqrt(1.0 - cosine**2)[:, None] * out
        two = (distance[:, None] * along - upper * one) / fore
        for own, new in ((uppers[:, k], one), (forearms[:, k], two)):
            found = own + share[:, None] * (new - own)
            own[:] = np.where(np.isnan(new), own, found)
    return replace(person, upper_arms=uppers, forearms=forearms)


def opened(robot: RobotModel, points: Mapping[str, Floats], q: Floats) -> list[int]:
    """Write the opening of hands whose fingertip is known into configurations; return their coordinates.

    With the bend β of the fingers, from the line of wrist and knuckles to that of knuckles and tip, it is
    (1 + cos β) / 2.
    """
    columns = []
    for side in SIDES:
        name, parts = f"{side[0].upper()}Hand", [f"{side}_{part}" for part in ("wrist", "hand", "finger")]
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
    robot: RobotModel, solver: LimbMap, times: Floats, q: Floats, rule: CollisionRule
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return configurations in which arms are out to the side where links overlap, and which arms, shape (n, 2).

    ShoulderRoll goes the least share of the way to its outward limit, eased in and out in time.
    """
    share, made = np.zeros((len(q), 2)), np.array(q)
    links = [solver.links(side) for side in SIDES]
    rows = np.arange(len(q))
    for _ in range(_ROUNDS):
        found = robot.clearance(made[rows], **vars(rule))
        close = found.distance < _ROOM - rule.tolerance
        more = np.zeros((len(q), 2))
        for i, k in zip(rows[close], np.asarray(found.pair_index)[close], strict=True):
            more[i] = [_STEP * (not own.isdisjoint(found.pairs[k])) for own in links]
        more = np.where(share < 1.0, more, 0.0)
        if not more.any():
            break
        grown = -slowly(times, -np.minimum(share + more, 1.0), _EASING)
        rows = np.flatnonzero((grown > share).any(axis=1))
        share = grown
        made[rows] = solver.outwards(q[rows], share[rows])
    return made, share > 0.0
