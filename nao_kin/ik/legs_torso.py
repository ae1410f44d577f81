"""Both feet in the world, and one number s of the torso's pose that gives way until they agree; or feet in the torso.

The roots of ψ of both feet have tangents −Y_cos / Y_sin, which are equal where

    G(s) = Y_cos,L Y_sin,R − Y_sin,L Y_cos,R

is zero: of second degree in the height, and of fourth in the cosine and sine of a lean or a yaw, without a branch or a
wrap. So even steps of s leave no root between two of them but for a double one, which is looked for where |G| is least.
"""

from __future__ import annotations

import math

import numpy as np

from nao_kin._kernels.cache import both_ways
from nao_kin.ik.compiling import Row
from nao_kin.ik.leg import Leg, foot_of, within_reach
from nao_kin.ik.legs_apart import separate_legs, split_turns
from nao_kin.ik.legs_equations import (
    BLAMED,
    JOINTS,
    LEFT,
    LEFT_FOOT,
    MOVED,
    NEITHER,
    OF_ONE,
    PRIORITY,
    RIGHT,
    RIGHT_FOOT,
    Legs,
    foot_yaw,
    solve_legs,
)
from nao_kin.ik.ranges import NOT_RIGID, POSITION_ERROR, REASON, Selection, Workspace, add_shortfall
from nao_kin.ik.searches import add_roots

# What of the torso gives way, as a number in a target; nothing where the feet are given in the torso.
NOTHING, HEIGHT, LEAN, YAW = -1.0, 0.0, 1.0, 2.0
# Where in a target what gives way stands, and where the wished pose of the torso begins; how long a target is in the
# torso and in the world.
FREE, TORSO = PRIORITY + 1, PRIORITY + 2
LENGTH, LENGTH_IN_WORLD = TORSO, TORSO + 16
# Numbers in q beside the joints: of both legs alone, and a target in the torso.
IN_TORSO = 2 * OF_ONE
SCRATCH = IN_TORSO + PRIORITY + 1

# Steps over the bounds, and halvings of a bracket.
_STEPS, _HALVINGS = 96, 60
_MOST_LEAN = 0.5 * math.pi
# Hips that are less apart [rad] wherever the torso stands agree everywhere.
_AGREE = 1e-10


@both_ways
def solve_at_wish(legs: Legs, target: Row, selection: Selection, work: Workspace) -> int:
    """All joint values that meet both feet, with the torso where it is wished; see `ranges` for the arguments."""
    short = _write_at_wish(legs, target, work.q)
    count = solve_legs(legs, work.q[IN_TORSO:SCRATCH], selection, work)
    _add_shortfalls(short, count, work)
    return count


@both_ways
def solve_pair(legs: Legs, target: Row, selection: Selection, work: Workspace) -> int:
    """The same, or the best where the hips disagree; in the world with the torso moved as little as it takes."""
    short, moved = _write_at_wish(legs, target, work.q), 0.0
    in_torso = work.q[IN_TORSO:SCRATCH]
    count = solve_legs(legs, in_torso, selection, work)
    if count > 0 or work.report[REASON] == NOT_RIGID:
        _add_shortfalls(short, count, work)
        return count
    if target[FREE] != NOTHING:
        moved = _least_move(legs, target, selection, work)
        move_torso(legs, target, moved, work.q)
        count = solve_legs(legs, in_torso, selection, work)
    if count == 0:
        count = split_turns(legs, in_torso, selection, work)
    _add_shortfalls(short, count, work)
    work.report[MOVED] = moved
    return count


@both_ways
def _write_at_wish(legs: Legs, target: Row, q: Row) -> tuple[float, float]:
    """Write the target in the torso where it is wished; with feet in the torso each as `within_reach`, and how far."""
    move_torso(legs, target, 0.0, q)
    if target[FREE] != NOTHING:
        return 0.0, 0.0  # the torso gives way
    return _into_reach(legs.left, q, IN_TORSO + LEFT), _into_reach(legs.right, q, IN_TORSO + RIGHT)


@both_ways
def _into_reach(leg: Leg, q: Row, first: int) -> float:
    """Move the foot that begins there as `within_reach` does; how far."""
    foot = foot_of(leg, q[first : first + 16])[1]
    moved, short = within_reach(leg, foot)
    if short > 0.0:
        x, y, z = moved.x - foot.x, moved.y - foot.y, moved.z - foot.z
        q[first + 3] += x
        q[first + 7] += leg.cos_kappa * y - leg.sin_kappa * z
        q[first + 11] += leg.sin_kappa * y + leg.cos_kappa * z
    return short


@both_ways
def _add_shortfalls(short: tuple[float, float], count: int, work: Workspace) -> None:
    """Add to the errors in position what the feet were moved by."""
    report = work.report
    if max(short[0], short[1]) > 0.0:
        add_shortfall(work.found, JOINTS, count, max(short[0], short[1]))
        report[LEFT_FOOT] += short[0]
        report[RIGHT_FOOT] += short[1]
        report[POSITION_ERROR] = max(report[LEFT_FOOT], report[RIGHT_FOOT])


@both_ways
def _least_move(legs: Legs, target: Row, selection: Selection, work: Workspace) -> float:
    """The s with which the feet are met, nearest to the wish; or with which the hips are least apart."""
    low, high = _bounds(legs, target)
    if _agree_everywhere(legs, target, low, high, work.q):
        return _nearest_reached(legs, target, low, high, selection, work)
    values = np.empty(4 * _STEPS + 4)
    count = add_roots(_disagreement, (legs, target, work.q), low, high, _STEPS, values, 0) if low < high else 0
    for k in np.argsort(np.abs(values[:count])):
        if _reaches(legs, target, values[k], selection, work):
            return float(values[k])
    return _least_apart(legs, target, low, high, selection, work)


@both_ways
def _reaches(legs: Legs, target: Row, moved: float, selection: Selection, work: Workspace) -> bool:
    """Whether both feet are met with the torso moved by s."""
    move_torso(legs, target, moved, work.q)
    return solve_legs(legs, work.q[IN_TORSO:SCRATCH], selection, work) > 0


@both_ways
def move_torso(legs: Legs, target: Row, moved: float, q: Row) -> None:
    """Write the target in the torso, with the torso moved by s, into q from `IN_TORSO` on."""
    mode = target[FREE]
    if mode == NOTHING:
        q[IN_TORSO:SCRATCH] = target[LEFT : PRIORITY + 1]
        return
    left, right = legs.left.hip, legs.right.hip
    cx, cy, cz = 0.5 * (left[0] + right[0]), 0.5 * (left[1] + right[1]), 0.5 * (left[2] + right[2])
    s, c = math.sin(moved), math.cos(moved)
    for side in range(2):
        first = LEFT if side == 0 else RIGHT
        for column in range(4):
            # A column of the foot's pose in the world, with the place from the torso's origin.
            vx, vy, vz = target[first + column], target[first + 4 + column], target[first + 8 + column]
            if column == 3:
                vx, vy, vz = vx - target[TORSO + 3], vy - target[TORSO + 7], vz - target[TORSO + 11]
                if mode == HEIGHT:
                    vz -= moved
            x, y, z = _in_torso(target, vx, vy, vz)
            if mode == LEAN:
                if column == 3:
                    x, z = x - cx, z - cz
                x, z = c * x - s * z, s * x + c * z
                if column == 3:
                    x, z = x + cx, z + cz
            elif mode == YAW:
                # About the vertical, seen from the torso: back by s, by Rodrigues' formula.
                if column == 3:
                    x, y, z = x - cx, y - cy, z - cz
                ux, uy, uz = target[TORSO + 8], target[TORSO + 9], target[TORSO + 10]
                along = (1.0 - c) * (ux * x + uy * y + uz * z)
                x, y, z = (
                    c * x - s * (uy * z - uz * y) + along * ux,
                    c * y - s * (uz * x - ux * z) + along * uy,
                    c * z - s * (ux * y - uy * x) + along * uz,
                )
                if column == 3:
                    x, y, z = x + cx, y + cy, z + cz
            at = IN_TORSO + first + column
            q[at], q[at + 4], q[at + 8] = x, y, z
            q[at + 12] = target[first + 12 + column]
    q[IN_TORSO + PRIORITY] = target[PRIORITY]


@both_ways
def _in_torso(target: Row, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector of the world in the axes of the torso where it is wished."""
    t = TORSO
    return (
        target[t] * x + target[t + 4] * y + target[t + 8] * z,
        target[t + 1] * x + target[t + 5] * y + target[t + 9] * z,
        target[t + 2] * x + target[t + 6] * y + target[t + 10] * z,
    )


@both_ways
def _bounds(legs: Legs, target: Row) -> tuple[float, float]:
    """How far the torso may be moved: as far as both legs reach, or a quarter of a turn."""
    if target[FREE] != HEIGHT:
        return -_MOST_LEAN, _MOST_LEAN
    low, high = -math.inf, math.inf
    for side in range(2):
        leg, first = (legs.left, LEFT) if side == 0 else (legs.right, RIGHT)
        foot = foot_of(leg, target[first : first + 16])[1]
        # The ankle as it stands in the world: in axes turned by κ, from a hip in the world's origin.
        C, S, hip = leg.cos_kappa, leg.sin_kappa, leg.hip
        ax, ay, az = foot.x + hip[0], C * foot.y - S * foot.z + hip[1], S * foot.y + C * foot.z + hip[2]
        hx, hy, hz = _hip_in_world(leg, target)
        aside = (ax - hx) * (ax - hx) + (ay - hy) * (ay - hy)
        longest = leg.thigh + leg.tibia
        span = math.sqrt(max(0.0, longest * longest - aside))
        low, high = max(low, az - hz - span), min(high, az - hz + span)
    return low, high


@both_ways
def _hip_in_world(leg: Leg, target: Row) -> tuple[float, float, float]:
    t, (x, y, z) = TORSO, leg.hip
    return (
        target[t] * x + target[t + 1] * y + target[t + 2] * z + target[t + 3],
        target[t + 4] * x + target[t + 5] * y + target[t + 6] * z + target[t + 7],
        target[t + 8] * x + target[t + 9] * y + target[t + 10] * z + target[t + 11],
    )


# --- where the hips agree ---------------------------------------------------------------------------------------------


@both_ways
def _tangents(legs: Legs, target: Row, moved: float, q: Row) -> tuple[float, float]:
    """G, the sine between the directions of which the roots of both feet are the tangents, and the cosine."""
    move_torso(legs, target, moved, q)
    left = foot_yaw(foot_of(legs.left, q[IN_TORSO + LEFT : IN_TORSO + RIGHT])[1])
    right = foot_yaw(foot_of(legs.right, q[IN_TORSO + RIGHT : IN_TORSO + PRIORITY])[1])
    return left.y_cos * right.y_sin - left.y_sin * right.y_cos, left.y_cos * right.y_cos + left.y_sin * right.y_sin


@both_ways
def _disagreement(given: tuple[Legs, Row, Row], moved: float) -> float:
    """G for a target."""
    legs, target, q = given
    return _tangents(legs, target, moved, q)[0]


@both_ways
def _agree_everywhere(legs: Legs, target: Row, low: float, high: float, q: Row) -> bool:
    """Whether the hips agree for every s between two."""
    if not low < high:
        return False
    for k in range(_STEPS + 1):
        sine, cosine = _tangents(legs, target, low + (high - low) / _STEPS * k, q)
        if math.atan2(abs(sine), abs(cosine)) >= _AGREE:
            return False
    return True


# --- where they do everywhere, or nowhere -----------------------------------------------------------------------------


@both_ways
def _nearest_reached(legs: Legs, target: Row, low: float, high: float, selection: Selection, work: Workspace) -> float:
    """Of the s where the legs reach their feet, the one nearest to the wish; 0 where there is none among even steps."""
    inside = math.inf
    for k in range(_STEPS + 1):
        moved = low + (high - low) * k / _STEPS
        if abs(moved) < abs(inside) and _reaches(legs, target, moved, selection, work):
            inside = moved
    if inside == math.inf:
        return 0.0
    outside = inside - math.copysign(min(abs(inside), (high - low) / _STEPS), inside)
    for _ in range(_HALVINGS):
        moved = 0.5 * (inside + outside)
        if _reaches(legs, target, moved, selection, work):
            inside = moved
        else:
            outside = moved
    return inside


@both_ways
def _least_apart(legs: Legs, target: Row, low: float, high: float, selection: Selection, work: Workspace) -> float:
    """The s with the hips least apart where each leg reaches its foot; 0 where none does among even steps."""
    best, least, step = 0.0, math.inf, (high - low) / _STEPS
    for k in range(_STEPS + 1 + 2 * _HALVINGS if low < high else 0):
        if k <= _STEPS:
            moved = low + step * k
        elif least == math.inf:
            break
        else:
            # To both sides of the best, nearer and nearer.
            nearer = step * 0.5 ** ((k - _STEPS - 1) // 2)
            moved = max(low, best - nearer) if k % 2 == 0 else min(high, best + nearer)
        move_torso(legs, target, moved, work.q)
        gap = separate_legs(legs, work.q[IN_TORSO:SCRATCH], selection, work)
        if work.report[BLAMED] == NEITHER and gap < least:
            best, least = moved, gap
    return best
