"""Standing: where the torso is when feet stay where they are, and the legs with it.

The leg of the first foot carries the torso: its six joint values are the torso's pose. The leg of a second foot follows
in closed form (`solve_leg_exactly`), the branch nearest to where it was, and asks for a value of HipYawPitch of its
own. Both hips have one motor, so the torso is moved until both ask for the same: Newton's method on h₂ − h₁ over the
joints of the first leg. Both feet are then met to rounding.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin.ik.body.body import Body, add_chain, frame_pose, inverted, multiplied, place_chain
from nao_kin.ik.body.quadratic_program import cholesky, solve_cholesky
from nao_kin.ik.closed_forms.leg_equations import JOINTS, MOST_BRANCHES, Leg, solve_leg_exactly
from nao_kin.ik.closed_forms.ranges import BESIDE, BEST, NEEDED, OUT_OF_REACH, REASON, Ranges
from nao_kin.ik.compiling import both_ways

# Hips that differ by less agree [rad]; with rounding in the way, by less than the second.
_AGREE, _NEARLY = 1e-14, 1e-12
_MOST_STEPS = 15
# No joint of the first leg moves by more in one step [rad].
_LONGEST = 0.3


class Legs(NamedTuple):
    """The closed forms of both legs: their geometry and limits."""

    left: Leg
    right: Leg
    left_ranges: Ranges
    right_ranges: Ranges


def legs_types() -> Any:
    """Numba's type of `Legs`."""
    from numba import types

    from nao_kin.ik.compiling import limb_arguments

    leg, ranges = limb_arguments(Leg, len(Leg._fields), JOINTS)[:2]
    return types.NamedTuple((leg, leg, ranges, ranges), Legs)


@both_ways
def torso_over_foot(
    body: Body, side: int, feet: Floats, x: Floats, R: Floats, p: Floats, T_world_torso: Floats
) -> None:
    """Where the torso is when a foot is where it should be.

    Args:
        body: the robot.
        side: 0 for the left foot.
        feet: T_world_foot, shape (2, 4, 4).
        x: the variables.
        R: for the rotations of this leg's joints in the torso.
        p: for their places.
        T_world_torso: for the result.
    """
    T_torso_foot, T_foot_torso = np.empty((4, 4)), np.empty((4, 4))
    foot_in_torso(body, side, x, R, p, T_torso_foot)
    inverted(T_torso_foot, T_foot_torso)
    multiplied(feet[side], T_foot_torso, T_world_torso)


@both_ways
def foot_in_torso(body: Body, side: int, x: Floats, R: Floats, p: Floats, T: Floats) -> None:
    """T_torso_foot by the joints of a leg, which are placed in R and p."""
    for i in range(3):
        p[0, i] = 0.0
        for j in range(3):
            R[0, i, j] = 1.0 if i == j else 0.0
    for k in range(JOINTS):
        place_chain(body, body.legs[side, k], x, R, p)
    frame_pose(R, p, body.legs[side, JOINTS - 1], body.ankle_to_sole[side], T)


@both_ways
def stand_on_both(body: Body, legs: Legs, feet: Floats, x: Floats, T_world_torso: Floats) -> bool:
    """Change the joints of both legs so that both feet are met; whether that was possible near by."""
    rows, n = len(body.parent), body.moving
    R, p = np.zeros((rows, 3, 3)), np.zeros((rows, 3))
    T_torso_world, T_torso_foot = np.empty((4, 4)), np.empty((4, 4))
    target, values, width = np.empty(16), np.empty(JOINTS), JOINTS + BESIDE
    q, found, report = np.empty(JOINTS), np.empty(MOST_BRANCHES * width), np.empty(BEST + JOINTS)
    first, second = np.empty((6, n)), np.empty((6, n))
    hip = body.legs[1, 0]
    shared = body.variable[hip]
    last = math.inf
    for _ in range(_MOST_STEPS):
        torso_over_foot(body, 0, feet, x, R, p, T_world_torso)
        inverted(T_world_torso, T_torso_world)
        multiplied(T_torso_world, feet[1], T_torso_foot)
        for i in range(4):
            for j in range(4):
                target[4 * i + j] = T_torso_foot[i, j]
        for k in range(JOINTS):
            row = body.legs[1, k]
            values[k] = body.multiplier[row] * x[body.variable[row]] + body.offset[row]
        count = solve_leg_exactly(legs.right, legs.right_ranges, target, values, False, q, found, report)
        first[:] = 0.0
        add_chain(body, body.legs[0, JOINTS - 1], 1.0, R, p, first)
        if count == 0:
            if report[REASON] != OUT_OF_REACH or not _nearer(body, T_torso_foot, report[NEEDED], p[hip], first, x):
                return False
            continue
        for k in range(1, JOINTS):
            row = body.legs[1, k]
            x[body.variable[row]] = (found[k] - body.offset[row]) / body.multiplier[row]
        asked = (found[0] - body.offset[hip]) / body.multiplier[hip]
        gap = asked - x[shared]
        gap -= 2.0 * math.pi * round(gap / (2.0 * math.pi))
        if abs(gap) <= _AGREE or (abs(gap) <= _NEARLY and abs(gap) >= 0.5 * last):
            return True
        last = abs(gap)
        foot_in_torso(body, 1, x, R, p, T_torso_foot)
        second[:] = 0.0
        add_chain(body, body.legs[1, JOINTS - 1], 1.0, R, p, second)
        if not _agree(body, gap, shared, first, second, x):
            return False
    return last <= _NEARLY


@both_ways
def _agree(body: Body, gap: float, shared: int, first: Floats, second: Floats, x: Floats) -> bool:
    """One step of Newton's method on what the two hips differ by.

    With the foot at rest, a twist ξ of the torso asks the second leg for S₂ q̇ = −ξ, so for −y·ξ of the hip, where
    S₂ᵀ y = (1, 0, …, 0); and ξ = −S₁ q̇₁. Straight knees make S₂ singular but leave y·ξ as it is, hence the damping.
    """
    gram, y = np.zeros((6, 6)), np.empty(6)
    for i in range(6):
        y[i] = second[i, shared]
        for j in range(6):
            for k in range(JOINTS):
                v = body.variable[body.legs[1, k]]
                gram[i, j] += second[i, v] * second[j, v]
        gram[i, i] += 1e-10
    if not cholesky(gram, 6):
        return False
    solve_cholesky(gram, 6, y)
    slope = np.empty(JOINTS)
    for k in range(JOINTS):
        v = body.variable[body.legs[0, k]]
        slope[k] = -1.0 if v == shared else 0.0
        for i in range(6):
            slope[k] += y[i] * first[i, v]
    return _moved(body, -gap, slope, x)


@both_ways
def _nearer(body: Body, T_torso_foot: Floats, missing: float, hip: Floats, first: Floats, x: Floats) -> bool:
    """Move the torso so that the second hip comes nearer to its ankle by what is missing."""
    sole = body.ankle_to_sole[1]
    towards = np.empty(3)
    for i in range(3):
        towards[i] = T_torso_foot[i, 3] - hip[i]
        for j in range(3):  # from the sole back to the ankle
            for k in range(3):
                towards[i] -= T_torso_foot[i, j] * sole[k, j] * sole[k, 3]
    far = math.sqrt(towards[0] * towards[0] + towards[1] * towards[1] + towards[2] * towards[2])
    slope = np.empty(JOINTS)
    for k in range(JOINTS):
        v = body.variable[body.legs[0, k]]
        v0 = first[0, v] + first[4, v] * hip[2] - first[5, v] * hip[1]
        v1 = first[1, v] + first[5, v] * hip[0] - first[3, v] * hip[2]
        v2 = first[2, v] + first[3, v] * hip[1] - first[4, v] * hip[0]
        slope[k] = -(towards[0] * v0 + towards[1] * v1 + towards[2] * v2) / far
    return _moved(body, missing + 1e-9, slope, x)


@both_ways
def _moved(body: Body, wanted: float, slope: Floats, x: Floats) -> bool:
    """The least change of the first leg's joints by which a number with this slope changes as wanted."""
    squares = 0.0
    for k in range(JOINTS):
        squares += slope[k] * slope[k]
    if not squares > 1e-12:
        return False
    factor = wanted / squares
    largest = 0.0
    for k in range(JOINTS):
        largest = max(largest, abs(factor * slope[k]))
    if largest > _LONGEST:
        factor *= _LONGEST / largest
    for k in range(JOINTS):
        x[body.variable[body.legs[0, k]]] += factor * slope[k]
    return True
