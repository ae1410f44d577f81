"""Join, mirror, reverse, resample, warp and repeat motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import LIMIT_TOLERANCE, Floats, check_tolerance, eased, positive, shaped, whole_number
from nao_kin.errors import BadArgument
from nao_kin.motion.curves import slowest
from nao_kin.motion.interpolation import Segments
from nao_kin.motion.motion import HOLD, MAX_SAMPLES, Motion, check_joints, filled, sampling_times
from nao_kin.robot import RobotModel

# Tolerance of values that must be equal without a gap in time.
_JUMP = 1e-9
# Times that are nearer to each other [s] differ by rounding.
_SAME_TIME = 1e-9
_BLEND_RATE = 100.0


def reverse(motion: Motion) -> Motion:
    """Return the motion run backwards in the same time interval: t becomes start + end − t.

    Examples:
        >>> turn = nk.Motion([0.0, 1.0], ["HeadYaw"], [[0.0], [0.5]])
        >>> nk.motion.reverse(turn).sample([0.0, 1.0]).tolist()
        [[0.5], [0.0]]
    """
    times = [(motion.start + motion.end) - column[::-1] for column in motion.times]
    keys = [column[::-1] for column in motion.keys]
    # Handles before and after a key are exchanged, and offsets in time change their sign.
    handles = [offsets[::-1, ::-1] * (-1.0, 1.0) for offsets in motion.handles or ()]
    return Motion(times, motion.joint_names, keys, motion.interpolation, handles or None)


def resample(
    motion: Motion,
    rate: float | None = None,
    *,
    times: ArrayLike | None = None,
    tolerance: float = 0.0,
    robot: RobotModel | None = None,
) -> Motion:
    """Return a linear motion with keys at given times, the same for all joints, and the values of the motion there.

    Args:
        motion: a motion of any interpolation.
        rate: keys per second, from the first key on; the last one is at the last key.
        times: the times instead of a rate, ascending, shape (n,) [s].
        tolerance: leave out keys of each joint that are at most so far away from the straight lines between the others
            [rad, m or ratio] (Ramer 1972; Douglas and Peucker 1973). No line is then steeper than before.
        robot: with a tolerance, keep the keys without which joints of this robot would leave their coupled limits.

    Raises:
        BadArgument: neither or both of rate and times, times that do not ascend, or more than 4 million keys.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.resample(nod, rate=10.0).times[0].size
        11
        >>> nk.motion.resample(nod, rate=10.0, tolerance=0.01).times[0].tolist()
        [0.0, 0.5, 1.0]
    """
    if rate is None and times is None:
        raise BadArgument("resample needs a rate or times")
    at = sampling_times(motion, rate, times)
    full = Motion(at, motion.joint_names, motion.sample(at))
    check_tolerance(tolerance)
    if not tolerance:
        return full
    kept = [_bends(at, keys, float(tolerance)) for keys in full.keys]
    while True:
        keys = [keys[rows] for keys, rows in zip(full.keys, kept, strict=True)]
        few = Motion([at[rows] for rows in kept], full.joint_names, keys)
        more = [] if robot is None else _outside_tables(robot, few, full)
        if not more:
            return few
        for column, rows in more:
            kept[column] = np.union1d(kept[column], rows)


def _bends(times: Floats, values: Floats, tolerance: float) -> NDArray[np.intp]:
    """Return the rows of the keys between which straight lines are within a tolerance of all keys."""
    kept, parts = [0, len(times) - 1], [(0, len(times) - 1)]
    while parts:
        first, last = parts.pop()
        line = np.interp(times[first : last + 1], times[[first, last]], values[[first, last]])
        away = np.abs(values[first : last + 1] - line)
        worst = first + int(away.argmax())
        if away.max() > tolerance:
            kept.append(worst)
            parts += [(first, worst), (worst, last)]
    return np.unique(kept)


def _outside_tables(robot: RobotModel, few: Motion, full: Motion) -> list[tuple[int, NDArray[np.intp]]]:
    """Return columns, and rows of the full motion, at which only the motion with few keys leaves coupled limits."""
    at = full.times[0]
    values, given, found = few.sample(at), full.sample(at), []
    for table in robot.coupled_limits:
        if {table.joint, table.of} <= set(few.joint_names):
            columns = [few.joint_names.index(name) for name in (table.joint, table.of)]
            away = [
                np.maximum(low - own, own - high)
                for own, low, high in (
                    (rows[:, columns[0]], *table.range(rows[:, columns[1]])) for rows in (values, given)
                )
            ]
            rows = np.flatnonzero(away[0] > np.maximum(away[1], 0.0) + LIMIT_TOLERANCE)
            found += [(column, rows) for column in columns if len(rows)]
    return found


def time_warp(motion: Motion, warp: float | Callable[[Floats], ArrayLike]) -> Motion:
    """Return the motion with its keys at other times.

    Args:
        motion: the motion to change.
        warp: a factor above zero by which the duration is multiplied, with the first key in place; or an increasing
            function from times to new times [s], both of shape (n,). Keys and the ends of handles move; the curve
            between them is interpolated in the new time. To warp the curve itself, `resample` it first.

    Raises:
        BadArgument: a factor that is not positive, or a function that does not increase from key to key.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.time_warp(nod, 2.0).end
        2.0
    """
    factor = 1.0 if callable(warp) else float(positive(warp, "warp"))

    def moved(times: Floats) -> Floats:
        scaled = motion.start + (times - motion.start) * factor
        return shaped(warp(np.array(times)) if callable(warp) else scaled, times.shape, "warped times")

    times = [moved(column) for column in motion.times]
    handles = [np.array(offsets) for offsets in motion.handles or ()]
    for column, new, offsets in zip(motion.times, times, handles, strict=False):
        # The outermost handles have no effect, and beyond the keys the function may be undefined.
        offsets[0, 0, 0] = offsets[-1, 1, 0] = 0.0
        offsets[1:, 0, 0] = np.minimum(moved(column[1:] + offsets[1:, 0, 0]) - new[1:], 0.0)
        offsets[:-1, 1, 0] = np.maximum(moved(column[:-1] + offsets[:-1, 1, 0]) - new[:-1], 0.0)
    return Motion(times, motion.joint_names, motion.keys, motion.interpolation, handles or None)


def concatenate(motions: Sequence[Motion], *, gap: float = 0.0, blend: float = 0.0) -> Motion:
    """Return motions one after another, the first at its own times.

    Each motion keeps its curves. In a gap every joint moves from its last value to its next one: straight between
    linear motions, otherwise from rest to rest. A joint that a motion does not name stands still during it, at its last
    value before, or else at its first value later. Motions of different interpolations, and smooth ones, become a
    Bezier motion.

    Args:
        motions: at least one.
        gap: time between the end of one motion and the beginning of the next [s]; with 0 no joint may jump.
        blend: instead of a gap, the time for which the end of one motion and the beginning of the next overlap [s]. The
            result passes from one to the other with weights 1 − w and w, w = 3 s² − 2 s³ over the share s of that time.
            It is linear. It has the keys of both motions and 100 more per second, in the overlap if both motions are
            linear, else everywhere.

    Raises:
        BadArgument: no motions, both a gap and a blend, a blend longer than one of the motions, or a joint that would
            jump.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.concatenate([nod, nod], gap=0.5).end
        2.5
    """
    if not motions:
        raise BadArgument("concatenate needs at least one motion")
    check_tolerance(gap, "gap")
    check_tolerance(blend, "blend")
    if gap and blend:
        raise BadArgument("gap and blend are two ways from one motion to the next; give one")
    result = motions[0]
    for motion in motions[1:]:
        result = _blended(result, motion, blend) if blend else _joined(result, motion, gap)
    return result


def loop(motion: Motion, n: int, *, gap: float = 0.0) -> Motion:
    """Return the motion repeated n times, with a gap between the repetitions.

    Args:
        motion: the motion to repeat.
        n: number of repetitions, at least 1, with at most 4 million keys of a joint in total.
        gap: time from the end back to the beginning [s]; 0 needs a motion that ends where it begins.

    Raises:
        BadArgument: an invalid number, or a joint that would jump without a gap.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> nk.motion.loop(nod, 3).end
        3.0
    """
    count = whole_number(n, "n", 1, maximum=max(1, MAX_SAMPLES // max(map(len, motion.keys))))
    # Repeated doubling, because each concatenation copies all keys.
    result, power = None, motion
    while count:
        if count & 1:
            result = power if result is None else concatenate([result, power], gap=gap)
        count >>= 1
        if count:
            power = concatenate([power, power], gap=gap)
    return motion if result is None else result


def complete(robot: RobotModel, motion: Motion, missing: str | ArrayLike = HOLD) -> Motion:
    """Return the motion with one more key for each joint of a robot that it does not name; these joints stand still.

    Args:
        robot: its joints with their own motor are added, in its order.
        motion: the motion to complete.
        missing: values of these joints, as in `Motion.configurations`.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> len(nk.motion.complete(nk.load_nao(), nod).joint_names)
        25
    """
    check_joints(robot, motion)
    angles = dict(zip(robot.joint_names, filled(robot, missing)[robot.nq_base :], strict=True))
    driven = {robot.mimics[name].joint for name in motion.joint_names if name in robot.mimics}
    absent = [name for name in robot.joint_names if name not in motion.joint_names and name not in driven]
    handles = None if motion.handles is None else [*motion.handles, *[np.zeros((1, 2, 2))] * len(absent)]
    return Motion(
        [*motion.times, *[np.array([motion.start])] * len(absent)],
        [*motion.joint_names, *absent],
        [*motion.keys, *(angles[name][None] for name in absent)],
        motion.interpolation,
        handles,
    )


def _joined(one: Motion, two: Motion, gap: float) -> Motion:
    linear = one.interpolation == two.interpolation == "linear"
    if not linear:
        one, two = one.as_bezier(), two.as_bezier()
    shift = one.end + gap - two.start
    names = tuple(dict.fromkeys((*one.joint_names, *two.joint_names)))
    times, keys, handles = list[Floats](), list[Floats](), list[Floats]()
    for name in names:
        parts = []
        if name in one.joint_names:
            parts.append(_held(one, name, 0.0, until=one.end if name in two.joint_names else None))
        if name in two.joint_names:
            parts.append(_held(two, name, shift, since=two.start if parts else None))
        if len(parts) == 2 and gap == 0.0:
            first, second = float(parts[0][1][-1]), float(parts[1][1][0])
            if abs(second - first) > _JUMP:
                raise BadArgument(
                    f"{name} would jump from {first:.6g} to {second:.6g} at {one.end:.6g} s; give a gap or a blend"
                )
            # The second motion's first key replaces the first motion's last key, and gets its handle before the key.
            parts[1][2][0, 0] = parts[0][2][-1, 0]
            parts[0] = parts[0][0][:-1], parts[0][1][:-1], parts[0][2][:-1]
        elif len(parts) == 2:
            # From rest to rest, in 3 s² − 2 s³.
            parts[0][2][-1, 1], parts[1][2][0, 0] = (gap / 3.0, 0.0), (-gap / 3.0, 0.0)
        for columns, column in zip((times, keys, handles), zip(*parts, strict=True), strict=True):
            columns.append(np.concatenate(column))
    if linear:
        return Motion(times, names, keys)
    return Motion(times, names, keys, "bezier", handles)


def _held(
    motion: Motion, name: str, shift: float, *, until: float | None = None, since: float | None = None
) -> tuple[Floats, Floats, Floats]:
    """Return times, keys and handles of a joint, with one more key if it stands still until or since a time."""
    column = motion.joint_names.index(name)
    times, keys = motion.times[column], motion.keys[column]
    handles = np.zeros((len(keys), 2, 2)) if motion.handles is None else np.array(motion.handles[column])
    # The outermost handles have no effect: between two motions the joints are at rest.
    handles[0, 0] = handles[-1, 1] = 0.0
    if until is not None and times[-1] < until:
        times, keys = np.append(times, until), np.append(keys, keys[-1])
        handles = np.concatenate([handles, np.zeros((1, 2, 2))])
    if since is not None and times[0] > since:
        times, keys = np.insert(times, 0, since), np.insert(keys, 0, keys[0])
        handles = np.concatenate([np.zeros((1, 2, 2)), handles])
    return times + shift, keys, handles


def _blended(one: Motion, two: Motion, blend: float) -> Motion:
    for motion in (one, two):
        if blend > motion.duration:
            raise BadArgument(f"blend = {blend:g} s is longer than a motion of {motion.duration:g} s")
    shift = one.end - blend - two.start
    second = Motion([times + shift for times in two.times], two.joint_names, two.keys, two.interpolation, two.handles)
    begin, end = one.end - blend, one.end
    linear = one.interpolation == two.interpolation == "linear"
    dense = (begin, end) if linear else (one.start, second.end)
    count = max(1, int(np.ceil((dense[1] - dense[0]) * _BLEND_RATE)))
    grid = np.unique(np.concatenate([one.key_times, second.key_times, [begin], np.linspace(*dense, count + 1)]))
    grid = grid[np.diff(grid, prepend=-np.inf) > _SAME_TIME]
    share = np.clip((grid - begin) / blend, 0.0, 1.0)
    weight = eased(share)
    names = tuple(dict.fromkeys((*one.joint_names, *two.joint_names)))
    before = dict(zip(one.joint_names, one.sample(grid).T, strict=True))
    after = dict(zip(second.joint_names, second.sample(grid).T, strict=True))
    columns = []
    for name in names:
        if name in before and name in after:
            columns.append((1.0 - weight) * before[name] + weight * after[name])
        else:
            columns.append(before[name] if name in before else after[name])
    return Motion(grid, names, np.stack(columns, axis=-1))


# --- More keys on the same curves.


def cut(motion: Motion, times: Floats) -> Motion:
    """Return the same curves with a key of every joint at each time within its keys; a smooth motion becomes Bezier."""
    if motion.interpolation == "linear":
        columns = [_with(own, times) for own in motion.times]
        rows = zip(columns, motion.times, motion.keys, strict=True)
        return Motion(columns, motion.joint_names, [np.interp(new, own, keys) for new, own, keys in rows])
    curves = motion.as_bezier()
    assert curves.handles is not None
    columns, values, offsets = [], [], []
    for own, keys, handles, curve in zip(curves.times, curves.keys, curves.handles, curves.segments, strict=True):
        new = _with(own, times)
        new = _with(new, _slow_times(curve, own, new))
        given = np.isin(new, own)
        columns.append(new)
        values.append(np.empty(len(new)))
        values[-1][given] = keys
        offsets.append(np.zeros((len(new), 2, 2)))
        offsets[-1][given] = handles
        if not given.all():
            _cut_curve(curve, new, ~given, values[-1], offsets[-1])
    return Motion(columns, motion.joint_names, values, "bezier", offsets)


def _with(own: Floats, times: Floats) -> Floats:
    """Return the times of a joint's keys, and the given times between them."""
    return np.union1d(own, times[(times > own[0]) & (times < own[-1])])


def _slow_times(curve: Segments, own: Floats, new: Floats) -> Floats:
    """Return the times at which segments must be cut too, so that handles end within the pieces.

    If the handles a and b together are longer than their segment, its time x runs slower and then faster again. A piece
    that contains both may begin or end more than three times as fast as its average, others do not.
    """
    if curve.lengths is None:
        return np.zeros(0)
    is_cut = np.searchsorted(new, own[1:]) - np.searchsorted(new, own[:-1]) > 1
    long = np.flatnonzero(is_cut & (curve.lengths.sum(axis=1) > 1.0))
    return curve.time(long, slowest(curve.time_slopes(long)))


def _cut_curve(curve: Segments, new: Floats, added: NDArray[np.bool_], values: Floats, offsets: Floats) -> None:
    """Fill in the values of added keys, and the handles next to them."""
    pieces = np.flatnonzero(added[:-1] | added[1:])
    segment = curve.at(new[pieces])
    u, v = curve.parameter(segment, new[pieces]), curve.parameter(segment, new[pieces + 1])
    points = curve.part(segment, u, v)
    points[:, 0] *= curve.width[segment]
    after, before = points[1] - points[0], points[2] - points[3]
    length = new[pieces + 1] - new[pieces]
    after[0], before[0] = np.clip(after[0], 0.0, length), np.clip(before[0], -length, 0.0)
    offsets[pieces, 1], offsets[pieces + 1, 0] = after.T, before.T
    starts = added[pieces]
    values[pieces[starts]] = curve.value(segment[starts], u[starts])


# --- The mirror image: left and right exchanged.


def mirror(robot: RobotModel, motion: Motion) -> Motion:
    """Return the motion mirrored at the plane between left and right, y = 0.

    RShoulderPitch gets the movement of LShoulderPitch; a motion mirrored twice is the original. The mirror image of a
    joint that turns about the axis a turns about −M a, with M = diag(1, −1, 1): its value changes sign if −M a is
    opposite to the axis of the joint on the other side. A sliding joint slides along M a; ratios, such as a hand's, do
    not change.

    Args:
        robot: its axes determine the signs.
        motion: the motion to mirror; names have left and right as in LHand, l_hand, arm_left_1 or FL_hip.

    Raises:
        UnknownName: a joint has no other side.
        BadArgument: the joint on the other side is not its mirror image.

    Examples:
        >>> wave = nk.Motion([0.0, 1.0], ["LShoulderRoll"], [[0.0], [0.5]])
        >>> mirrored = nk.motion.mirror(nk.load_nao(), wave)
        >>> mirrored.joint_names, mirrored.sample(1.0).tolist()
        (('RShoulderRoll',), [-0.5])
    """
    check_joints(robot, motion)
    images = [robot.mirror_image(name) for name in motion.joint_names]
    # Adding zero takes the sign off a negative zero.
    keys = [image.multiplier * column + 0.0 for image, column in zip(images, motion.keys, strict=True)]
    handles = [
        offsets * (1.0, image.multiplier) + 0.0 for image, offsets in zip(images, motion.handles or (), strict=False)
    ]
    return Motion(motion.times, [image.joint for image in images], keys, motion.interpolation, handles or None)
