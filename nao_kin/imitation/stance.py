"""Legs and trunk of a robot that moves like a person: places of the feet, lean, height, and the centre of mass.

A NAO that stands still does not fall while its centre of mass is above the feet on the floor. So each frame is a
problem of `nk.ik.whole_body` for arms and head that are known: the feet on the floor are met exactly, the trunk leans
as the person's does, and is where the centre of mass has its place.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, between_samples, eased, join_poses, norm, rigid_inverse, runs
from nao_kin.errors import BadArgument
from nao_kin.ik import limbs, whole_body
from nao_kin.imitation.layouts import LIMBS, SIDES

# mypy takes `nao_kin.ik.limbs` for the module of this name unless it has checked this file before.
from nao_kin.imitation.limbs import LimbMap as LimbMap
from nao_kin.robot import Feet, RobotModel
from nao_kin.rotations import nearest_rotation, power, rot_z

FEET = ("LLeg", "RLeg")
# The lean is smaller where it is missed by this [rad], or the place of the centre of mass by this [m].
_TILTED, _AWAY = 0.15, 0.01
# Distance of the centre of mass from its place at which no correction is needed [m].
_THERE = 0.0005
# Weights of the trunk's position and rotation, and how often the position is corrected.
_TRUNK, _CORRECTIONS = (1.0, 0.3), 4
# How fast the lean that the feet allow may change, as a share of the person's [1/s], and how often it is made smaller.
_EASING, _SMALLER, _TRIES = 2.0, 0.6, 6
# A foot of the robot that is higher than this above the other one is lifted [m], for at least this time [s].
_LIFTED, _SHORTEST = 0.012, 0.15
# Frames at both ends of a lift in which the foot is still on the floor.
_AT_ENDS = 2
# Ranges of a foot beside the other one: ahead and out to the side [m], and how far its toes point out [rad].
_NEAREST, _FARTHEST = (-0.05, 0.095, -0.1), (0.05, 0.16, 0.5)
# Height of the hips above the ankles, as shares of the stretched leg, and the largest lift of a foot [m].
_HEIGHTS, _HIGHEST = (0.65, 0.86), 0.06
# How far inside of the ankle the centre of mass is on one foot [m].
_INSIDE = 0.01
# The shortest time in which the weight goes from one foot to the other [s].
_SHIFT = 1.0


@dataclass(frozen=True, eq=False)
class Stance:
    """Where a robot is to stand in n frames.

    Attributes:
        feet: T_world_foot of `FEET`, shape (n, 2, 4, 4) [m].
        carries: which feet are on the floor, shape (n, 2).
        torso: desired R_world_torso, shape (n, 3, 3).
        height: of the middle of the hips, shape (n,) [m].
        com: place of the centre of mass on the floor, shape (n, 2) [m].
        least: the least times between frames, in which the weight is shifted, shape (n − 1,) [s].
        notes: what was changed, for the robot's legs are not the person's.
    """

    feet: Floats
    carries: NDArray[np.bool_]
    torso: Floats
    height: Floats
    com: Floats
    least: Floats
    notes: tuple[str, ...] = ()


def slowly(times: Floats, values: Floats, rate: float) -> Floats:
    """Return the largest values, below the given ones, that change by at most `rate` per second; shape (n, ...)."""
    ramp = (rate * times).reshape(-1, *[1] * (values.ndim - 1))
    ahead = np.minimum.accumulate(values - ramp, axis=0) + ramp
    return np.asarray(np.minimum.accumulate((ahead + ramp)[::-1], axis=0)[::-1] - ramp)


def upright(R: Floats) -> tuple[Floats, Floats]:
    """Return the headings of rotations R_world_part, shape (n,) [rad], and the rotations without them: R = Rz(ψ) R'."""
    heading = np.unwrap(np.arctan2(R[:, 1, 0], R[:, 0, 0]))
    return heading, rot_z(-heading) @ R


def in_place(robot: RobotModel, start: Floats, torso: Floats) -> Stance:
    """Return the stance of a robot whose feet stay where they are in a configuration, under R_world_torso (n, 3, 3)."""
    down, n = robot.set_down(start), len(torso)
    feet = down.T_world_base @ robot.fk(start, FEET, reference=robot.tree.root)
    com = np.mean([T[:2, 3] + T[:2, :2] @ middle for T, middle in zip(feet, _soles(robot), strict=True)], axis=0)
    height = np.full(n, down.T_world_base[2, 3] + _hips(robot)[2])
    carries = np.ones((n, 2), dtype=bool)
    return Stance(
        np.tile(feet, (n, 1, 1, 1)), carries, upright(torso)[1], height, np.tile(com, (n, 1)), np.zeros(n - 1)
    )


def stood(
    robot: RobotModel,
    times: Floats,
    q: Floats,
    stance: Stance,
    fixed: NDArray[np.intp],
    share: Floats,
    todo: NDArray[np.intp],
) -> tuple[Floats, Floats, NDArray[np.intp]]:
    """Return configurations in a stance, the share of the trunk's lean that the feet allow, (n,), and misses.

    Coordinates `fixed`, those of arms and head, keep their values, and all do in frames that are not `todo`, unless
    they must lean less than by their `share`. Misses are frames for which no pose was found; their legs are
    interpolated.
    """
    n, made, share = len(q), np.array(q), np.array(share)
    failed = np.zeros(n, dtype=bool)
    for _ in range(_TRIES):
        failed = np.zeros(n, dtype=bool)
        for carries in ((True, True), (True, False), (False, True)):
            rows = todo[(stance.carries[todo] == carries).all(axis=1)]
            if not len(rows):
                continue
            made[rows], failed[rows] = _solved(robot, q[rows], stance, rows, share[rows], fixed)
        if not failed.any():
            break
        share[failed] *= _SMALLER
        slower = slowly(times, share, _EASING)
        todo = np.flatnonzero(failed | (slower < share))
        share = slower
    if failed.any() and not failed.all():
        made = between_samples(np.where(failed[:, None], np.nan, made), times)
        made[:, fixed] = q[:, fixed]
    return made, share, np.flatnonzero(failed)


def base_in(robot: RobotModel, q: Floats, stance: Stance) -> Floats:
    """Return T_world_base, shape (n, 4, 4), of a robot whose feet on the floor have their places in a stance."""
    T = stance.feet @ rigid_inverse(robot.fk(q, FEET, reference=robot.tree.root))
    mean = (T * stance.carries[..., None, None]).sum(axis=1) / stance.carries.sum(axis=1)[:, None, None]
    return join_poses(nearest_rotation(mean[:, :3, :3]), mean[:, :3, 3])


def _solved(
    robot: RobotModel, q: Floats, stance: Stance, rows: NDArray[np.intp], share: Floats, fixed: NDArray[np.intp]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the poses of frames in which the same feet carry, with a share of the lean, and which of them are missed.

    The heading of the trunk gives way, for one motor turns both hips.
    """
    heading, lean = upright(stance.torso[rows])
    R, made = rot_z(heading) @ power(lean, share), np.array(q)
    place = np.column_stack([stance.com[rows], stance.height[rows] - (R @ _hips(robot))[:, 2]])
    place[:, :2] -= (R @ robot.com(made, reference=robot.tree.root)[..., None])[:, :2, 0]
    feet = stance.feet[rows]
    on_floor = {k: name for k, name in enumerate("LR") if stance.carries[rows[0], k]}
    stay = bool((feet[:, list(on_floor)] == feet[:1, list(on_floor)]).all())  # one support polygon is faster than n
    # The target `com` of the search would move the arms.
    for _ in range(_CORRECTIONS):
        found = whole_body(
            robot,
            {FEET[k]: feet[:, k] for k in range(2) if k not in on_floor},
            feet={name: feet[0, k] if stay else feet[:, k] for k, name in on_floor.items()},
            torso=join_poses(R, place),
            weights={"torso": _TRUNK},
            posture=made,
            near=made,
            restarts=0,
        )
        made = np.where(np.isnan(found.q), made, found.q)
        made[:, fixed] = q[:, fixed]
        away = stance.com[rows] - found.com[:, :2]
        if np.nanmax(norm(away), initial=0.0) < _THERE:
            break
        place[:, :2] += np.nan_to_num(away)
    tilt = 2.0 * np.arcsin(np.minimum(0.5 * norm(found.torso[:, :3, 2] - R[..., 2]), 1.0))
    # Not NaN, as where no pose stands on both feet.
    return made, ~((norm(away) < _AWAY) & (tilt < _TILTED))


# --- A person's steps.


def followed(robot: RobotModel, start: Floats, times: Floats, points: Mapping[str, Floats], torso: Floats) -> Stance:
    """Return the stance that follows a person's feet, hips and trunk, R_world_torso (n, 3, 3).

    Each ankle has the place beside its hip that the person's has, times the ratio of the legs. A foot on the floor
    stays where it came down; the lower one is always on the floor. The centre of mass is above a foot that carries
    alone.

    Raises:
        BadArgument: hips or ankles are unknown, or the robot has no legs of a NAO.
    """
    lacking = [side + part for part in ("hip", "ankle") for side in SIDES if not _known(points, side + part)]
    if lacking:
        raise BadArgument(f'legs="follow" needs hips and ankles, and the skeleton has no {", no ".join(lacking)}')
    own = _legs(robot)
    hips, ankles = (np.stack([points[side + part] for side in SIDES], axis=1) for part in ("hip", "ankle"))
    across = hips[:, 0] - hips[:, 1]
    heading = np.unwrap(np.arctan2(-across[:, 0], across[:, 1]))
    length, reach = _length(points), own["L"]["thigh"] + own["L"]["tibia"]
    beside = reach / length * ((ankles - hips) @ rot_z(heading))
    hip = np.array([own[side]["hip"] for side in "LR"])
    heading_of_feet = np.stack([_foot_heading(points, side, heading) for side in SIDES], axis=1)
    high = beside[..., 2] - beside[..., 2].min(axis=1, keepdims=True)
    carries = _on_floor(times, high)
    places = _walked(rot_z(heading - heading[0]), hip[:, :2] - hip[:, :2].mean(axis=0) + beside[..., :2], carries)
    raw = np.concatenate([places, heading_of_feet[..., None] - heading[0]], axis=-1)
    flat, notes = _steps(raw, carries)
    feet = join_poses(rot_z(flat[..., 2]), np.zeros((*flat.shape[:2], 3)))
    feet[..., :2, 3] = flat[..., :2]
    feet[..., 2, 3] = _lifts(high, carries)
    weight = _weight(times, carries)
    middles = flat[..., :2] + (rot_z(flat[..., 2])[..., :2, :2] @ _soles(robot)[..., None])[..., 0]
    com = (middles * weight[..., None]).sum(axis=1)
    R = rot_z(flat[..., 2].mean(axis=1)) @ upright(torso)[1]
    tall = np.clip(-beside[..., 2].min(axis=1) / reach, *_HEIGHTS) * reach - own["L"]["place"][2]
    least = np.abs(np.diff(weight[:, 0])) * _SHIFT
    return Stance(feet, carries, R, tall, com, least, notes)


def _legs(robot: RobotModel) -> dict[str, dict[str, Any]]:
    """Return the geometry of both legs, as in `nk.ik.limbs`."""
    own = {limb["side"]: limb["geometry"] for limb in limbs(robot) if limb["kind"] == "leg"}
    if own.keys() != {"L", "R"}:
        raise BadArgument(f'{robot.name} has no legs of a NAO; legs="ignore" moves arms and head alone')
    return own


def _hips(robot: RobotModel) -> Floats:
    """Return the middle of the hips in the torso, shape (3,) [m]."""
    return np.asarray(np.mean([leg["hip"] for leg in _legs(robot).values()], axis=0))


def _soles(robot: RobotModel) -> Floats:
    """Return the places of the centre of mass on one foot, in the frames of the feet, shape (2, 2) [m].

    They are in the middle of the soles' length, and inside of the ankles, for legs roll little.
    """
    return np.array(
        [[Feet.of(robot, (name,)).points[:, 0].mean(), y] for name, y in zip(FEET, (-_INSIDE, _INSIDE), strict=True)]
    )


def _known(points: Mapping[str, Floats], name: str) -> bool:
    return name in points and bool(np.isfinite(points[name]).all())


def _length(points: Mapping[str, Floats]) -> float:
    """Return the length of the person's leg, the mean of both [m]."""
    lengths = []
    for side in SIDES:
        hip, knee, ankle = (points.get(side + part, points[side + "hip"]) for part in LIMBS[1])
        if _known(points, side + "knee"):
            lengths.append(np.median(norm(knee - hip) + norm(ankle - knee)))
        else:
            lengths.append(np.quantile(norm(ankle - hip), 0.95))
    return float(np.mean(lengths))


def _foot_heading(points: Mapping[str, Floats], side: str, heading: Floats) -> Floats:
    """Return the heading of a foot, from the ankle to the toes, or that of the hips, shape (n,) [rad]."""
    if not _known(points, side + "toe"):
        return heading
    along = points[side + "toe"] - points[side + "ankle"]
    out = np.arctan2(along[:, 1], along[:, 0]) - heading
    return heading + (out + np.pi) % (2.0 * np.pi) - np.pi


def _phases(mask: NDArray[np.bool_]) -> list[tuple[slice, int]]:
    """Return the frames in which a foot is, or is not, on the floor, and the foot, by a mask (n, 2)."""
    return [(run, k) for k in range(2) for run in runs(mask[:, k])]


def _on_floor(times: Floats, high: Floats) -> NDArray[np.bool_]:
    """Return which feet are on the floor, by their heights above the lower one, shape (n, 2) [m]."""
    carries = high < _LIFTED
    for run, k in _phases(~carries):
        if times[run.stop - 1] - times[run.start] < _SHORTEST:
            carries[run, k] = True
        else:
            carries[run.start : run.start + _AT_ENDS, k] = carries[run.stop - _AT_ENDS : run.stop, k] = True
    return carries


def _walked(R: Floats, beside: Floats, carries: NDArray[np.bool_]) -> Floats:
    """Return places of both feet on the floor, (n, 2, 2), with places beside the hips, while feet that carry stay."""
    turned = beside @ R[:, :2, :2].swapaxes(1, 2)
    steps, both = np.diff(turned, axis=0), carries[1:] & carries[:-1]
    count = both.sum(axis=1, keepdims=True)
    slip = (steps * both[..., None]).sum(axis=1) / np.maximum(count, 1)
    travelled = np.concatenate([np.zeros((1, 2)), np.cumsum(-slip, axis=0)])
    return np.asarray(turned + travelled[:, None])


def _steps(raw: Floats, carries: NDArray[np.bool_]) -> tuple[Floats, tuple[str, ...]]:
    """Return place and heading of both feet, (n, 2, 3), from the person's: feet that carry stay, others swing.

    A foot is placed beside the other one as the person's is, as far as the robot's legs allow.
    """
    flat, clipped = np.array(raw), 0
    phases = sorted(_phases(carries), key=lambda phase: (phase[0].start, phase[0].stop))
    placed: list[tuple[Floats, Floats] | None] = [None, None]
    for run, k in phases:
        mean = raw[run, k].mean(axis=0)
        own, other = mean, placed[1 - k]
        if other is not None:
            own, off = _beside(mean, *other, k)
            clipped += bool(off > 1e-3)
        placed[k] = mean, own
        flat[run, k] = own
    swings = _phases(~carries)
    for run, k in swings:
        first, last = run.start, run.stop
        ends = max(first - 1, 0), min(last, len(raw) - 1)
        # The other foot stays meanwhile: of its phases, the one at the middle of the swing.
        middle = (first + last) // 2
        phase = next(phase for phase in runs(carries[:, 1 - k]) if phase.start <= middle < phase.stop)
        mean = raw[phase, 1 - k].mean(axis=0)
        rows = np.arange(ends[0], ends[1] + 1)
        moved = np.array([_beside(raw[i, k], mean, flat[middle, 1 - k], k)[0] for i in rows])
        share = np.linspace(0.0, 1.0, len(rows))[:, None]
        before = flat[ends[0], k] - moved[0] if carries[ends[0], k] else 0.0
        after = flat[ends[1], k] - moved[-1] if carries[ends[1], k] else before
        before = after if not carries[ends[0], k] else before
        flat[run, k] = (moved + (1.0 - share) * before + share * after)[first - ends[0] :][: last - first]
    notes = [f"{len(swings)} step{'s'[: len(swings) != 1]}"] if swings else []
    if clipped:
        notes.append(f"{clipped} of {len(phases)} places of feet are as near to the person's as the robot's legs allow")
    return flat, tuple(notes)


def _beside(pose: Floats, other: Floats, placed: Floats, k: int) -> tuple[Floats, float]:
    """Return the pose (x, y, heading) of a foot beside the other one, which is placed, and how much it is changed."""
    side = np.array([1.0, 1.0 - 2.0 * k, 1.0 - 2.0 * k])
    wanted = side * (rot_z(-other[2]) @ (pose - other))
    near = np.clip(wanted, _NEAREST, _FARTHEST)
    return placed + rot_z(placed[2]) @ (side * near), float(np.abs(near - wanted)[:2].max())


def _lifts(high: Floats, carries: NDArray[np.bool_]) -> Floats:
    """Return the heights of the feet, (n, 2) [m]: zero on the floor, and smoothly up and down."""
    lifts = np.zeros(high.shape)
    for run, k in _phases(~carries):
        share = np.linspace(0.0, 1.0, run.stop - run.start + 2)[1:-1]
        if run.stop == len(high):
            share = np.minimum(share, 0.25)
        ramp = np.clip(4.0 * np.minimum(share, 1.0 - share), 0.0, 1.0)
        lifts[run, k] = np.minimum(high[run, k], _HIGHEST) * eased(ramp)
    return lifts


def _weight(times: Floats, carries: NDArray[np.bool_]) -> Floats:
    """Return the shares of the weight on both feet, (n, 2): one on a foot alone, else shifted evenly in time."""
    both = carries.all(axis=1)
    left = np.where(both, 0.5, carries[:, 0])
    for run in runs(np.asarray(both)):
        start, end = times[run.start], times[run.stop - 1]
        before = left[run.start - 1] if run.start else 0.5
        # A take that ends with one foot in the air leaves no time to shift the weight to both.
        after = left[run.stop] if run.stop < len(left) else before if end - start < 0.5 * _SHIFT else 0.5
        knots, values = [start, end], [before, after]
        if end - start > 2.0 * _SHIFT:
            knots, values = [start, start + _SHIFT, end - _SHIFT, end], [before, 0.5, 0.5, after]
        left[run] = np.interp(times[run], knots, values)
    return np.stack([left, 1.0 - left], axis=1)
