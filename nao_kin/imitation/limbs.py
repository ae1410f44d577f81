"""The map of a person's directions to joint values of arms and head, frame by frame.

Directions are in the person's torso frame: x ahead, y left, z up. The upper arm is the line from shoulder to elbow, the
forearm that from elbow to wrist, of the person as of the robot. With the elbow at (e_x, e_y, 0) in the robot's upper
arm, κ = atan2(e_y, e_x) and ρ = ShoulderRoll + κ,

    upper arm = Ry(ShoulderPitch) Rz(ρ) x,  forearm = Ry(ShoulderPitch) Rz(ShoulderRoll) Rx(ElbowYaw) Rz(ElbowRoll) x,
    gaze = Rz(HeadYaw) Ry(HeadPitch) x.

So each pair of joints gives a longitude and a latitude: about the axis of ShoulderPitch with latitude ρ, about the
upper arm's axis with latitude π/2 − ElbowRoll, and about the axis of HeadYaw with latitude −HeadPitch. A direction has
two solutions, (longitude, latitude) and (longitude + π, π − latitude). If neither is inside the limits, the nearest
direction that the joints have is on the edge of their patch of the sphere: on one of its meridians and parallels, in
closed form; of the head, whose range of pitch depends on the yaw, by a search along its edge.

The upper arm comes first; the forearm follows from the direction that the upper arm has, and the wrist from that of the
forearm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import IntFlag
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, check_tolerance, cross, dot, norm, shaped
from nao_kin._kernels.cache import CachedKernel, Floats1, Floats2, Row, both_ways
from nao_kin._kernels.rows import in_lists, run_rows
from nao_kin.errors import BadArgument
from nao_kin.ik import LimitRegion, arm as solve_arm, head as solve_head, limbs
from nao_kin.robot import RobotModel
from nao_kin.rotations import rot_x, rot_y, rot_z

SIDES = ("left", "right")
DIRECTIONS = (*(f"{side}_{part}" for side in SIDES for part in ("upper_arm", "forearm", "hand")), "gaze")


class Clamp(IntFlag):
    """Why a direction is not met: the joints at their limits, or an unknown direction, whose joints keep their values.

    The first joint is ShoulderPitch, ElbowYaw, WristYaw or HeadYaw; the second is ShoulderRoll, ElbowRoll or HeadPitch.
    LINKS: the arm is farther out, because links would overlap.
    """

    NONE = 0
    FIRST = 1
    SECOND = 2
    UNKNOWN = 4
    LINKS = 8


# --- Directions of a person.


@dataclass(frozen=True, eq=False)
class Directions:
    """The directions of a person's limbs in the torso frame, for n frames; NaN where unknown.

    Attributes:
        torso: R_world_torso, shape (n, 3, 3): z from the hips to the shoulders, y to the left, x ahead.
        upper_arms: from shoulder to elbow, left and right, shape (n, 2, 3); made unit vectors, as the others.
        forearms: from elbow to wrist, shape (n, 2, 3).
        hands: R_torso_hand, x from the wrist to the knuckles, z out of the back, shape (n, 2, 3, 3).
        gaze: ahead of the face, shape (n, 3).
        notes: what was substituted for unknown points.
    """

    torso: Floats
    upper_arms: Floats
    forearms: Floats
    hands: Floats
    gaze: Floats
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("upper_arms", "forearms", "gaze"):
            object.__setattr__(self, name, _unit(getattr(self, name)))

    @classmethod
    def of(cls, points: Mapping[str, Floats], orientations: Mapping[str, Floats] | None = None) -> Directions:
        """Return the directions for points (n, 3) and orientations (n, 3, 3) of a `Skeleton`, by their names."""
        n = len(points["left_shoulder"])
        turned, gaps, no_part = orientations or {}, np.full((n, 3), np.nan), np.full((n, 3, 3), np.nan)

        def point(name: str) -> Floats:
            return points.get(name, gaps)

        def lines(start: str, end: str) -> Floats:
            return np.stack([point(f"{side}_{end}") - point(f"{side}_{start}") for side in SIDES], axis=1)

        torso, notes = _torso(point)
        hands = np.stack([turned.get(f"{side}_hand", no_part) for side in SIDES], axis=1)
        eyes, ears = ((point(f"left_{part}") + point(f"right_{part}")) / 2.0 for part in ("eye", "ear"))
        nose, up = point("nose"), _unit(point("head") - point("neck"))
        # The line from the ears to the eyes rises as much as that to the nose falls.
        ahead = _known_first((eyes + nose) / 2.0, nose, eyes) - ears
        beside = nose - point("neck")
        ahead = _known_first(turned.get("head", no_part)[..., 0], ahead, beside - dot(beside, up)[:, None] * up)
        return cls(
            torso=torso,
            upper_arms=lines("shoulder", "elbow") @ torso,
            forearms=lines("elbow", "wrist") @ torso,
            hands=np.swapaxes(torso, -1, -2)[:, None] @ hands,
            gaze=(ahead[:, None] @ torso)[:, 0],
            notes=notes,
        )

    def only(self, *, arms: bool, head: bool) -> Directions:
        """Return the directions with those of arms or head unknown."""
        parts = ("upper_arms", "forearms", "hands") * (not arms) + ("gaze",) * (not head)
        if not parts:
            return self
        return replace(self, **{name: np.full_like(getattr(self, name), np.nan) for name in parts})

    @property
    def rows(self) -> Floats:
        """All numbers of a frame in a row: upper arm, forearm and hand of both arms, then the gaze; shape (n, 33)."""
        n = len(self.gaze)
        arms = np.concatenate([self.upper_arms, self.forearms, self.hands.reshape(n, 2, 9)], axis=-1)
        return np.ascontiguousarray(np.concatenate([arms.reshape(n, 30), self.gaze], axis=-1))


def mirrored(
    points: Mapping[str, Floats], orientations: Mapping[str, Floats]
) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Return points and orientations in a mirror: those of left and right exchanged, and y reversed."""
    flip = np.array([1.0, -1.0, 1.0])

    def other(name: str) -> str:
        side, _, part = name.partition("_")
        return f"{SIDES[1 - SIDES.index(side)]}_{part}" if side in SIDES else name

    turned = {other(name): R * flip[:, None] * flip for name, R in orientations.items()}
    return {other(name): p * flip for name, p in points.items()}, turned


def _unit(v: Floats) -> Floats:
    """Return unit vectors; NaN for zero."""
    with np.errstate(invalid="ignore", divide="ignore"):
        return v / norm(v)[..., None]


def _unknown(v: Floats) -> NDArray[np.bool_]:
    """Return which vectors are unknown, shape (n,)."""
    return np.asarray(np.isnan(v).any(axis=-1))


def _known_first(*choices: Floats) -> Floats:
    """Return the first known vector of several, in each frame."""
    found = choices[0]
    for other in choices[1:]:
        unknown = _unknown(found)
        if not unknown.any():
            break
        found = np.where(unknown[:, None], other, found)
    return found


def _torso(point: Callable[[str], Floats]) -> tuple[Floats, tuple[str, ...]]:
    """Return R_world_torso, and notes on points that were substituted.

    A missing shoulder or hip is placed at the median distance from the other one, along the line of the other pair;
    with no hip at all, the trunk is vertical.
    """
    pairs = {part: (point(f"left_{part}"), point(f"right_{part}")) for part in ("shoulder", "hip")}
    leftwards = _unit(_known_first(*(left - right for left, right in pairs.values())))
    middles, notes = [], []
    for part, (left, right) in pairs.items():
        middle = (left + right) / 2.0
        if part == "hip":
            middle = _known_first(middle, point("pelvis"))
        lacking = _unknown(middle)
        if lacking.any():
            widths = norm(left - right)
            half = (np.nanmedian(widths) / 2.0 if np.isfinite(widths).any() else 0.0) * leftwards
            middle = _known_first(middle, left - half, right + half)
            count = np.count_nonzero(lacking & ~_unknown(middle))
            if count:
                notes.append(f"{count} frames lack a {part}, which is placed beside the other one")
        middles.append(middle)
    trunk = middles[0] - middles[1]
    lost = _unknown(trunk) & ~_unknown(leftwards)
    if lost.any():
        notes.append(f"{np.count_nonzero(lost)} frames lack both hips: their trunk is taken as vertical")
    up = _unit(np.where(lost[:, None], (0.0, 0.0, 1.0), trunk))
    ahead = _unit(cross(leftwards, up))
    return np.stack([ahead, cross(up, ahead), up], axis=-1), tuple(notes)


# --- Two joints and a direction, as longitude and latitude.

# Rounding of directions [rad]: nearer ones are the same.
_ROUNDING = 1e-13
# A solution that is outside of the limits by at most this is one at the limit [rad].
_AT_LIMIT = 1e-9
# At this multiple of the slack from a pole there is no slack.
_FADES = 4.0
# Limits of joints without limits: a few turns [rad].
_UNLIMITED = 8.0 * math.pi
# Steps of the golden-section search along the edge of the head's range.
_GOLDEN, _SECTIONS = 0.5 * (math.sqrt(5.0) - 1.0), 26


class Patch(NamedTuple):
    """Ranges of longitude and latitude [rad]; a latitude beyond ±π/2 continues over the pole."""

    west: float
    east: float
    south: float
    north: float


class ArmMap(NamedTuple):
    """The geometry and limits of an arm: the upper arm's angle κ to the axis of ElbowYaw, and ranges [rad]."""

    tilt: float
    shoulder: Patch
    elbow: Patch
    wrist_low: float
    wrist_high: float


class HeadMap(NamedTuple):
    """The range of HeadPitch, from `low` to `high` at HeadYaw `at`, linear between [rad]."""

    at: Row
    low: Row
    high: Row


@both_ways
def nearest_in(angle: float, low: float, high: float, near: float) -> float:
    """Return the value in a range nearest to an angle on the circle; of those whole turns apart, nearest to `near`."""
    turn = 2.0 * math.pi
    value = angle + turn * math.ceil((low - angle) / turn)
    if value > high:
        return high if value - high <= low + turn - value else low
    return value + turn * min(math.floor((high - value) / turn), max(0.0, math.floor((near - value) / turn + 0.5)))


@both_ways
def angle_between(longitude: float, latitude: float, other_longitude: float, other_latitude: float) -> float:
    """Return the angle between two directions, by the haversine formula, accurate for small angles."""
    sine, across = math.sin(0.5 * (latitude - other_latitude)), math.sin(0.5 * (longitude - other_longitude))
    square = sine * sine + math.cos(latitude) * math.cos(other_latitude) * across * across
    return 2.0 * math.asin(math.sqrt(min(max(square, 0.0), 1.0)))


@both_ways
def on_patch(
    patch: Patch, direction: tuple[float, float], near: tuple[float, float], slack: float, branch: int
) -> tuple[float, float, float]:
    """Return longitude, latitude and angle of the best direction of a patch.

    Branches 0 and 1 are the two exact solutions, with an infinite angle if outside of the patch. Branch 2 is the
    nearest point of the edge. The longitude is then moved towards that of `near` as far as the angle grows by at most
    `slack`, less a quarter of the direction's angle to the pole.
    """
    longitude, latitude = direction
    if branch == 1:
        longitude, latitude = longitude + math.pi, math.pi - latitude
    x, y, angle = 0.0, 0.0, math.inf
    if branch < 2:
        x = nearest_in(longitude, patch.west, patch.east, near[0])
        y = nearest_in(latitude, patch.south, patch.north, near[1])
        angle = angle_between(x, y, longitude, latitude)
        if angle > _AT_LIMIT:
            return x, y, math.inf
    else:
        s, c = math.sin(latitude), math.cos(latitude)
        for edge in range(4):
            if edge < 2:
                one = patch.west if edge == 0 else patch.east
                two = nearest_in(math.atan2(s, c * math.cos(one - longitude)), patch.south, patch.north, near[1])
            else:
                two = patch.south if edge == 2 else patch.north
                behind = 0.0 if math.cos(two) >= 0.0 else math.pi
                one = nearest_in(longitude + behind, patch.west, patch.east, near[0])
            away = angle_between(one, two, longitude, latitude)
            if away < angle:
                x, y, angle = one, two, away
        if math.cos(y) < 0.0:  # so that the meridian of the direction is on the side of the point
            longitude, latitude = longitude + math.pi, math.pi - latitude
    slack -= math.atan2(abs(math.cos(latitude)), abs(math.sin(latitude))) / _FADES
    change = towards_near(patch, latitude, x - longitude, near[0] - x, angle + max(slack, _ROUNDING))
    if change != 0.0:
        x = min(max(x + change, patch.west), patch.east)
        best = math.atan2(math.sin(latitude), math.cos(latitude) * math.cos(x - longitude))
        y = nearest_in(best, patch.south, patch.north, near[1])
        angle = angle_between(x, y, longitude, latitude)
    return x, y, angle


@both_ways
def towards_near(patch: Patch, latitude: float, offset: float, step: float, reach: float) -> float:
    """Return the largest part of a step of the longitude after which the angle to a direction is at most `reach`.

    The step begins at `offset` from the direction's longitude. The meridian at the offset m passes the direction at
    the angle asin(cos(latitude) sin(m)), or is nearest to it at an end of the range of latitudes.
    """
    if step == 0.0:
        return 0.0
    turn = 2.0 * math.pi
    latitude += turn * math.floor((0.5 * (patch.south + patch.north) - latitude) / turn + 0.5)
    s, c = math.sin(latitude), math.cos(latitude)
    sine = math.sin(min(reach, 0.5 * math.pi))
    most = math.asin(sine / abs(c)) if sine < abs(c) else math.pi
    # The latitude there goes from that of the direction over the pole, without a jump.
    foot = math.atan2(s, c * math.cos(most))
    foot += turn * math.floor((latitude - foot) / turn + 0.5)
    end = min(max(foot, patch.south), patch.north)
    if end != foot and math.cos(end) * c > 0.0:
        apart = abs(latitude - end)
        square = math.sin(0.5 * (reach + apart)) * math.sin(0.5 * (reach - apart)) / (math.cos(end) * c)
        most = 2.0 * math.asin(math.sqrt(min(max(square, 0.0), 1.0)))
    offset -= turn * math.floor(offset / turn + 0.5)
    goal = offset + step
    if abs(goal - turn * math.floor(goal / turn + 0.5)) <= most:
        return step
    return max(0.0, min(step, most - offset)) if step > 0.0 else min(0.0, max(step, -most - offset))


# --- An arm.

# Indices of a row for the kernel: of an arm, then of the head.
_FORE, _HAND, _ARM_ROW = 3, 6, 15
_GAZE = 2 * _ARM_ROW
# Joints of an arm, and of arms and head; the output has joint values, angles and codes.
_ARM_JOINTS, _JOINTS, _PARTS = 5, 12, len(DIRECTIONS)


@both_ways
def write_arm(arm: ArmMap, row: Row, first: int, near: Row, at: int, slack: float, out: Row, part: int) -> None:
    """Write the five values of an arm, from index `at`, and the angles and codes of its three parts, from `part`."""
    for j in range(_ARM_JOINTS):
        out[at + j] = near[at + j]
    angles, codes = _JOINTS + part, _JOINTS + _PARTS + part
    for k in range(3):
        out[angles + k], out[codes + k] = math.nan, 4.0
    ux, uy, uz = row[first], row[first + 1], row[first + 2]
    fx, fy, fz = row[first + _FORE], row[first + _FORE + 1], row[first + _FORE + 2]
    upper, forearm = ux == ux and uy == uy and uz == uz, fx == fx and fy == fy and fz == fz
    direction = math.atan2(-uz, ux), math.atan2(uy, math.sqrt(ux * ux + uz * uz))
    preferred = near[at], near[at + 1] + arm.tilt
    best, nearest, same = math.inf, math.inf, max(slack, _AT_LIMIT)
    for branch in range(3 if upper else 1):
        x, y, angle = preferred[0], preferred[1], math.nan
        if upper:
            if branch == 2 and best < math.inf:
                continue
            x, y, angle = on_patch(arm.shoulder, direction, preferred, slack, branch)
            if angle == math.inf:
                continue
        q3, q4, missed = near[at + 2], near[at + 3], 0.0
        if forearm:
            q3, q4, missed = elbow(arm, (x, y - arm.tilt), (fx, fy, fz), (q3, q4), slack)
        away = (x - near[at]) * (x - near[at]) + (y - preferred[1]) * (y - preferred[1])
        away += (q3 - near[at + 2]) * (q3 - near[at + 2]) + (q4 - near[at + 3]) * (q4 - near[at + 3])
        if missed < best - same or (missed <= best + same and away < nearest):
            best, nearest = missed, away
            out[at], out[at + 1], out[at + 2], out[at + 3] = x, y - arm.tilt, q3, q4
            if upper:
                out[angles], out[codes] = angle, clamped(arm.shoulder, x, y, angle)
            if forearm:
                out[angles + 1], out[codes + 1] = missed, clamped(arm.elbow, q3, 0.5 * math.pi - q4, missed)
    known = 0.0
    for k in range(first + _HAND, first + _ARM_ROW):
        known += row[k]
    if known == known:
        write_wrist(arm, row, first + _HAND, near[at + 4], out, at, angles + 2, codes + 2)


@both_ways
def clamped(patch: Patch, x: float, y: float, angle: float) -> float:
    """Return the code for a direction that is missed by an angle: the joints at their limits."""
    code = 0.0
    if angle > _AT_LIMIT:
        code += 1.0 if x <= patch.west + _AT_LIMIT or x >= patch.east - _AT_LIMIT else 0.0
        code += 2.0 if y <= patch.south + _AT_LIMIT or y >= patch.north - _AT_LIMIT else 0.0
    return code


@both_ways
def elbow(
    arm: ArmMap,
    shoulder: tuple[float, float],
    forearm: tuple[float, float, float],
    near: tuple[float, float],
    slack: float,
) -> tuple[float, float, float]:
    """Return ElbowYaw, ElbowRoll and the angle to the direction of the forearm, for values of the shoulder's joints."""
    s1, c1, s2, c2 = math.sin(shoulder[0]), math.cos(shoulder[0]), math.sin(shoulder[1]), math.cos(shoulder[1])
    fx, fy, fz = forearm
    # The direction in the upper arm, Rz(−ShoulderRoll) Ry(−ShoulderPitch) f
    level = c1 * fx - s1 * fz
    x, y, z = c2 * level + s2 * fy, c2 * fy - s2 * level, s1 * fx + c1 * fz
    direction = math.atan2(z, y), math.atan2(x, math.sqrt(y * y + z * z))
    preferred = near[0], 0.5 * math.pi - near[1]
    one, two, angle = on_patch(arm.elbow, direction, preferred, slack, 0)
    other = on_patch(arm.elbow, direction, preferred, slack, 1)
    if other[2] < math.inf:
        away = abs(other[0] - near[0]) + abs(other[1] - preferred[1])
        if angle == math.inf or away < abs(one - near[0]) + abs(two - preferred[1]):
            one, two, angle = other
    if angle == math.inf:
        one, two, angle = on_patch(arm.elbow, direction, preferred, slack, 2)
    return one, 0.5 * math.pi - two, angle


@both_ways
def write_wrist(arm: ArmMap, row: Row, first: int, near: float, out: Row, at: int, angle: int, code: int) -> None:
    """Write the WristYaw with the least angle between the robot's hand and the person's, that angle, and the code.

    With M = Fᵀ R, the hand's rotation in the forearm, it maximises M₀₀ + (M₁₁ + M₂₂) cos q + (M₂₁ − M₁₂) sin q, the
    trace of Rx(q)ᵀ M.
    """
    s1, c1, s2, c2 = math.sin(out[at]), math.cos(out[at]), math.sin(out[at + 1]), math.cos(out[at + 1])
    s3, c3, s4, c4 = math.sin(out[at + 2]), math.cos(out[at + 2]), math.sin(out[at + 3]), math.cos(out[at + 3])
    ahead = cosine = sine = 0.0
    for k in range(3):
        # Row k of Ry(q₁) Rz(q₂), and of the forearm.
        u0, u1, u2 = c1 * c2, -c1 * s2, s1
        if k == 1:
            u0, u1, u2 = s2, c2, 0.0
        elif k == 2:
            u0, u1, u2 = -s1 * c2, s1 * s2, c1
        f0, f1 = c4 * u0 + s4 * (c3 * u1 + s3 * u2), c4 * (c3 * u1 + s3 * u2) - s4 * u0
        f2 = c3 * u2 - s3 * u1
        r0, r1, r2 = row[first + 3 * k], row[first + 3 * k + 1], row[first + 3 * k + 2]
        ahead, cosine, sine = ahead + f0 * r0, cosine + f1 * r1 + f2 * r2, sine + f2 * r1 - f1 * r2
    wanted = near
    if abs(cosine) + abs(sine) > _ROUNDING:
        wanted = math.atan2(sine, cosine)
    value = nearest_in(wanted, arm.wrist_low, arm.wrist_high, near)
    out[at + 4] = value
    trace = ahead + cosine * math.cos(value) + sine * math.sin(value)
    out[angle] = 2.0 * math.asin(math.sqrt(min(max(0.25 * (3.0 - trace), 0.0), 1.0)))
    out[code] = 1.0 if abs(math.sin(0.5 * (value - wanted))) > _AT_LIMIT else 0.0


# --- The head.


@both_ways
def pitch_at(head: HeadMap, gaze: tuple[float, float, float], yaw: float, k: int) -> tuple[float, float, float]:
    """Return the best HeadPitch at a yaw, its squared distance from the gaze on the sphere, and the code of its limit.

    The yaw is between rows k and k + 1 of the table.
    """
    share = (yaw - head.at[k]) / (head.at[k + 1] - head.at[k])
    low = head.low[k] + share * (head.low[k + 1] - head.low[k])
    high = head.high[k] + share * (head.high[k + 1] - head.high[k])
    x, y, z = gaze
    c, s = math.cos(yaw), math.sin(yaw)
    best = math.atan2(-z, c * x + s * y)
    pitch = nearest_in(best, low, high, best)
    level = math.cos(pitch)
    dx, dy, dz = c * level - x, s * level - y, -math.sin(pitch) - z
    return pitch, dx * dx + dy * dy + dz * dz, 2.0 if abs(pitch - best) > _AT_LIMIT else 0.0


@both_ways
def write_head(head: HeadMap, row: Row, near: Row, out: Row) -> None:
    """Write the values of the head for the direction of the face, or the nearest inside the limits; angle and code."""
    at, angle, code, last = _JOINTS - 2, _JOINTS + _PARTS - 1, _JOINTS + 2 * _PARTS - 1, len(head.at) - 1
    out[at], out[at + 1], out[angle], out[code] = near[at], near[at + 1], math.nan, 4.0
    x, y, z = row[_GAZE], row[_GAZE + 1], row[_GAZE + 2]
    length = math.sqrt(x * x + y * y + z * z)
    if not length > 0.0:
        return
    gaze = x / length, y / length, z / length
    yaw, segment = nearest_in(math.atan2(y, x), head.at[0], head.at[last], near[at]), 0
    while segment < last - 1 and head.at[segment + 1] < yaw:
        segment += 1
    best = pitch_at(head, gaze, yaw, segment)[1]
    if best > _AT_LIMIT * _AT_LIMIT:
        # The best of the ends and the middles between rows of the table, and then between the rows beside it.
        start, end = max(0, segment - 1), min(last - 1, segment + 1)
        for i in range(2 * last + 1):
            k = min(i // 2, last - 1)
            trial = head.at[k] + (0.5 * i - k) * (head.at[k + 1] - head.at[k])
            away = pitch_at(head, gaze, trial, k)[1]
            if away < best:
                best, segment, yaw = away, k, trial
                start, end = max(0, (i - 1) // 2), k
        for k in range(start, end + 1):
            trial = between_rows(head, gaze, k)
            away = pitch_at(head, gaze, trial, k)[1]
            if away < best:
                best, segment, yaw = away, k, trial
    out[at] = yaw
    out[at + 1], square, limit = pitch_at(head, gaze, yaw, segment)
    out[angle], out[code] = 2.0 * math.asin(min(0.5 * math.sqrt(square), 1.0)), limit
    if best > _AT_LIMIT * _AT_LIMIT and (yaw == head.at[0] or yaw == head.at[last]):
        out[code] += 1.0


@both_ways
def between_rows(head: HeadMap, gaze: tuple[float, float, float], k: int) -> float:
    """Return the yaw between two rows of the table with the least angle, by golden sections."""
    low, high = head.at[k], head.at[k + 1]
    one, two = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    first, second = pitch_at(head, gaze, one, k)[1], pitch_at(head, gaze, two, k)[1]
    for _ in range(_SECTIONS):
        if first <= second:
            high, two, second = two, one, first
            one = high - _GOLDEN * (high - low)
            first = pitch_at(head, gaze, one, k)[1]
        else:
            low, one, first = one, two, second
            two = low + _GOLDEN * (high - low)
            second = pitch_at(head, gaze, two, k)[1]
    middle: float = 0.5 * (low + high)
    return middle


# --- Frames, one after another.


@both_ways
def _write_frame(left: ArmMap, right: ArmMap, head: HeadMap, row: Row, near: Row, slack: float, out: Row) -> None:
    """Write the joint values of a frame, nearest to those in `near`, and the angles and codes of its directions."""
    write_arm(left, row, 0, near, 0, slack, out, 0)
    write_arm(right, row, _ARM_ROW, near, _ARM_JOINTS, slack, out, 3)
    write_head(head, row, near, out)


@partial(CachedKernel, what="a kernel of imitation, arms and head", name="imitation kernel, arms and head")
def _frames(
    left: ArmMap, right: ArmMap, head: HeadMap, rows: Floats2, near: Floats1, slack: float, out: Floats2
) -> None:
    previous = near
    for i in range(rows.shape[0]):
        _write_frame(left, right, head, rows[i], previous, slack, out[i])
        previous = out[i]


@dataclass(frozen=True, eq=False)
class LimbValues:
    """Configurations that have the directions of a person, for n frames.

    Attributes:
        q: configurations, shape (n, nq).
        errors: angles between the person's directions and the robot's, in the order of `DIRECTIONS`, shape (n, 7)
            [rad]; NaN where the direction is unknown.
        codes: why directions are missed, as `Clamp`, shape (n, 7).
    """

    q: Floats
    errors: Floats
    codes: NDArray[np.int64]


class LimbMap:
    """The map of directions to the joint values of a robot's arms and head.

    Args:
        robot: a NAO of any version, or another robot with arms and a neck of its geometry.

    Raises:
        BadArgument: the robot lacks an arm or a neck of this geometry, or an arm has coupled limits.
    """

    def __init__(self, robot: RobotModel) -> None:
        self.robot = robot
        self._rest = robot.clamp(robot.neutral())
        found = {limb["kind"] + limb["side"]: limb for limb in limbs(robot)}
        for side in "LR":
            if "arm" + side not in found:
                solve_arm(robot, side, np.eye(4))  # raises, and says what is missing
        if "head" not in found:
            solve_head(robot, np.eye(3))
        used = [found[name] for name in ("armL", "armR", "head")]
        self._arms = used[:2]
        self.columns = np.concatenate([limb["columns"] for limb in used])
        self._multiplier = np.concatenate([limb["multiplier"] for limb in used])
        self._offset = np.concatenate([limb["offset"] for limb in used])
        self._numbers = _arm_map(robot, used[0]), _arm_map(robot, used[1]), _head_map(robot, used[2])
        self._maps: tuple[ArmMap, ArmMap] = self._numbers[:2]

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that move, of both arms and the head, as in `RobotModel.joint_names`."""
        return tuple(self.robot.joint_names[column - self.robot.nq_base] for column in self.columns)

    @property
    def lengths(self) -> tuple[float, float, float, float]:
        """From the middle to a shoulder, to the elbow, to the hand [m], and how far an elbow bends [rad]."""
        own = self._arms[0]["geometry"]
        arm, upper = self._numbers[0], math.hypot(own["elbow_x"], own["elbow_y"])
        bend = max(abs(0.5 * math.pi - arm.elbow.south), abs(0.5 * math.pi - arm.elbow.north))
        return abs(own["shoulder"][1]), upper, own["place"][0], bend

    def links(self, side: str) -> set[str]:
        """Return the links of an arm, from the shoulder to the fingers."""
        first, found = self._arms[SIDES.index(side)]["joints"][0], set[str]()
        for joint in self.robot.tree.joints:
            if joint.name == first or joint.parent in found:
                found.add(joint.child)
        return found

    def outwards(self, q: Floats, share: Floats) -> Floats:
        """Return configurations with ShoulderRoll a share (n, 2) of the way to its outward limit."""
        made = np.array(q)
        for k, limb in enumerate(self._arms):
            lower, upper = self._maps[k].shoulder[2:]
            roll = (upper if k == 0 else lower) - self._maps[k].tilt
            end = (roll - limb["offset"][1]) / limb["multiplier"][1]
            column = limb["columns"][1]
            made[:, column] += share[:, k] * (end - made[:, column])
        return made

    def errors(self, directions: Directions, q: Floats, solved: Floats) -> Floats:
        """Return the angles of configurations from directions, as in `LimbValues`; hands and gaze as solved."""
        angles = np.array(solved)
        for k, (limb, numbers) in enumerate(zip(self._arms, self._maps, strict=True)):
            values = q[:, limb["columns"]] * limb["multiplier"] + limb["offset"]
            upper = rot_y(values[:, 0]) @ rot_z(values[:, 1])
            fore = (upper @ rot_x(values[:, 2]) @ rot_z(values[:, 3]))[..., 0]
            lines = upper @ np.array([math.cos(numbers.tilt), math.sin(numbers.tilt), 0.0]), fore
            for part, (line, own) in enumerate(zip(lines, (directions.upper_arms, directions.forearms), strict=True)):
                angles[:, 3 * k + part] = 2.0 * np.arcsin(np.minimum(0.5 * norm(line - own[:, k]), 1.0))
        return angles

    def solve(self, directions: Directions, near: ArrayLike | None = None, *, slack: float = 0.0) -> LimbValues:
        """Return the configurations of n frames, one after another: each is nearest to the one before.

        Of the directions that a limb has, each frame takes the nearest: first that of the upper arm, then that of the
        forearm for this upper arm. Where several joint values give it, it takes those nearest to the frame before; so
        a joint that a direction does not determine keeps its value, such as ElbowYaw of a straight arm.

        Args:
            directions: of n frames.
            near: the configuration before the first frame, inside the limits, with the values of all other joints,
                shape (nq,); None for all joints at zero, or at the limit nearest to it.
            slack: the angle [rad] by which forearms in line with the upper arm, and upper arms along the axis of
                ShoulderPitch, may be farther from their directions than necessary, to move less: there, small errors
                of a direction turn a joint by large angles. It falls to zero at four times this angle from the line.
        """
        check_tolerance(slack, "slack")
        slack = min(float(slack), math.pi)
        q = self._rest if near is None else shaped(near, (self.robot.nq,), "near")
        rows = directions.rows
        n = len(rows)
        out = np.empty((n, _JOINTS + 2 * _PARTS))
        first = np.zeros(_JOINTS + 2 * _PARTS)
        first[:_JOINTS] = self._multiplier * q[self.columns] + self._offset

        def run(function: Callable[..., object], part: slice) -> None:
            before = out[part.start - 1] if part.start else first
            function(*self._numbers, rows[part], before, slack, out[part])

        def one_in_lists(part: slice) -> None:
            i = part.start
            before, written = (out[i - 1] if i else first).tolist(), [0.0] * out.shape[1]
            left, right, neck = self._numbers
            _write_frame(left, right, in_lists(neck), rows[i].tolist(), before, slack, written)
            out[i] = written

        run_rows(_frames, run, n, 1, uncompiled=one_in_lists)
        made = np.tile(q, (n, 1))
        made[:, self.columns] = (out[:, :_JOINTS] - self._offset) / self._multiplier
        return LimbValues(made, out[:, _JOINTS : _JOINTS + _PARTS], out[:, _JOINTS + _PARTS :].astype(np.int64))


def _limits(limb: Mapping[str, Any]) -> tuple[list[float], list[float]]:
    lower, upper = limb["lower"], limb["upper"]
    return [-_UNLIMITED if end is None else end for end in lower], [_UNLIMITED if end is None else end for end in upper]


def _arm_map(robot: RobotModel, limb: Mapping[str, Any]) -> ArmMap:
    if limb["table"] is not None:
        raise BadArgument(f"{robot.name}: imitation does not know coupled limits of arms, such as of {limb['frame']}")
    lower, upper = _limits(limb)
    tilt = math.atan2(limb["geometry"]["elbow_y"], limb["geometry"]["elbow_x"])
    shoulder = Patch(lower[0], upper[0], lower[1] + tilt, upper[1] + tilt)
    elbow_patch = Patch(lower[2], upper[2], 0.5 * math.pi - upper[3], 0.5 * math.pi - lower[3])
    return ArmMap(tilt, shoulder, elbow_patch, lower[4], upper[4])


def _head_map(robot: RobotModel, limb: Mapping[str, Any]) -> HeadMap:
    if limb["table"] is None:
        (west, low), (east, high) = _limits(limb)
        return HeadMap(np.array([west, east]), np.full(2, low), np.full(2, high))
    # The region of yaw and pitch as coordinates, with the corners where a bound of the table meets a joint's own limit.
    region = LimitRegion(robot, np.array(limb["columns"]) - robot.nq_base).numbers
    yaw, pitch = zip(limb["multiplier"], limb["offset"], strict=True)
    bounds = np.sort([pitch[0] * bound + pitch[1] for bound in (region.low, region.high)], axis=0)
    order = np.argsort(yaw[0] * region.at)
    return HeadMap(yaw[0] * region.at[order] + yaw[1], *np.ascontiguousarray(bounds[:, order]))
