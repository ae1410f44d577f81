"""From the points of a recording to smooth ones: without a rest pose in front, outliers, gaps and fast motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, between_samples, norm, runs
from nao_kin._core.text import MAX_SHOWN, abbreviated
from nao_kin._core.warn import need_extra
from nao_kin.imitation.bones import believed
from nao_kin.imitation.layouts import LIMBS, SIDES
from nao_kin.imitation.skeleton import Skeleton, left_and_trunk
from nao_kin.rotations import nearest_rotation

# The points that nothing needs.
_NEEDLESS = ("chest", "left_thumb", "right_thumb")
# Straight lines across longer gaps than this [s] are noted with their length.
_NOTED = 1.0
# Times that differ from evenly spaced ones by less than this share of a frame are evenly spaced.
_EVEN = 0.01
# Order of the low-pass filter, which runs forward and backward.
_ORDER = 2
# A rest pose is in at most so many frames in front, with a jump of a hand or a foot by this part of the trunk, this
# many times as large as the steps of so many frames after it.
_REST_FRAMES, _JUMP, _TIMES, _AFTER = 5, 0.5, 5.0, 5
# A point that is farther than this part of the trunk, and than this many trunks per second reach in a frame, from its
# median over five frames jumps away and back.
_OUTSIDE, _FASTEST, _WINDOW = 0.3, 24.0, 5


def rest_frames(skeleton: Skeleton) -> int:
    """Return the number of frames in front that are a rest pose: a jump follows, and then a person's motion.

    Places are those of hands, elbows and feet about the middle of the shoulders, in trunks.
    """
    names = [side + part for limb in LIMBS for part in limb[1:] for side in SIDES]
    points = skeleton.points
    size = np.nanmedian(norm(left_and_trunk(points)[1]))
    middle = (points["left_shoulder"] + points["right_shoulder"]) / 2.0
    shown = np.stack([points[name] - middle for name in names if name in points] or [0.0 * middle])
    steps = norm(np.diff(shown[:, : _REST_FRAMES + _AFTER + 1], axis=1)) / size
    fastest = _FASTEST * np.diff(skeleton.times[: _AFTER + 1]).mean() if len(skeleton) > 1 else 0.0
    for k in range(1, min(_REST_FRAMES, steps.shape[1] - _AFTER) + 1):
        jump, after = (np.nanmax(part, initial=0.0) for part in (steps[:, :k], steps[:, k : k + _AFTER]))
        if jump > max(_JUMP, _TIMES * after) and after < fastest:
            return k
    return 0


def _outliers(times: Floats, places: Floats, size: float) -> NDArray[np.bool_]:
    """Return which known points (n, 3) jump away from their neighbours and back; `size` is the trunk's."""
    if len(places) < _WINDOW:
        return np.zeros(len(places), dtype=bool)
    beside = _WINDOW // 2
    padded, ends = (np.pad(a, ((beside, beside), (0, 0))[: a.ndim], mode="edge") for a in (places, times))
    medians = np.median(np.lib.stride_tricks.sliding_window_view(padded, _WINDOW, axis=0), axis=-1)
    steps = (ends[2 * beside :] - ends[: len(times)]) / (_WINDOW - 1)
    return np.asarray(norm(places - medians) > size * np.maximum(_OUTSIDE, _FASTEST * steps))


def filtered(skeleton: Skeleton, cutoff: float) -> tuple[Floats, dict[str, Floats], dict[str, Floats], tuple[str, ...]]:
    """Return evenly spaced times, points and orientations without gaps and without fast motion, and notes on them.

    A rest pose in front, which has no time to become the next frame, is left out.
    """
    notes, rest = [], rest_frames(skeleton)
    if rest:
        count = "the first frame is" if rest == 1 else f"the first {rest} frames are"
        notes.append(f"{count} a rest pose, far from the next one, and left out")
        skeleton = skeleton.between(float(skeleton.times[rest]))
    times = skeleton.times
    size = float(np.nanmedian(norm(left_and_trunk(skeleton.points)[1])))
    even, rate = times, 0.0
    if cutoff > 0.0 and len(times) > 1:
        rate = 1.0 / float(np.median(np.diff(times)))
        spaced = np.linspace(times[0], times[-1], round(float(times[-1] - times[0]) * rate) + 1)
        if len(spaced) != len(times) or np.abs(spaced - times).max() * rate > _EVEN:
            even = spaced
    found: list[dict[str, Floats]] = [{}, {}]
    jumping: dict[str, int] = {}
    needed = believed(skeleton.points, skeleton.confidence)
    for k, arrays in enumerate((needed, skeleton.orientations)):
        for name, array in arrays.items():
            if name in _NEEDLESS:
                continue
            columns = array.reshape(len(times), -1)
            known: NDArray[np.bool_] = np.asarray(np.isfinite(columns).all(axis=1))
            label = name.replace("_", " ")
            if not known.all():
                # From the known frame before to that after, or to an end.
                gaps = [(max(gap.start - 1, 0), min(gap.stop, len(times) - 1)) for gap in runs(~known)]
                longest = max(times[last] - times[first] for first, last in gaps)
                what = f"{label} is unknown" if k == 0 else f"{label}'s orientation is unknown"
                span = f", for up to {longest:.2g} s" if longest >= _NOTED else ""
                notes.append(f"{what} in {np.count_nonzero(~known)} of {len(times)} frames{span}")
            if k == 0 and cutoff > 0.0:
                away = np.flatnonzero(known)[_outliers(times[known], columns[known], size)]
                known[away] = False
                jumping[label] = len(away)
            columns = between_samples(np.where(known[:, None], columns, np.nan), times, even)
            if known.any() and 0.0 < cutoff < 0.5 * rate:
                columns = _low_pass(columns, cutoff / rate)
            values = columns.reshape(len(even), *array.shape[1:])
            found[k][name] = nearest_rotation(values) if k and known.any() else values
    most = max(jumping.values(), default=0)
    if most:
        names = abbreviated(", ".join(label for label, count in jumping.items() if count), MAX_SHOWN)
        notes.append(f"points jump away and back in up to {most} of {len(times)} frames, which are bridged: {names}")
    return even, found[0], found[1], tuple(notes)


def _low_pass(columns: Floats, cutoff: float) -> Floats:
    """Return columns without frequencies above the cut-off, given in cycles per row, and without delay."""
    need_extra("the filter of imitate (none with cutoff=0, --cutoff 0)", "calibration", "scipy")
    from scipy.signal import butter, sosfiltfilt

    sections = butter(_ORDER, 2.0 * cutoff, output="sos")
    return np.asarray(sosfiltfilt(sections, columns, axis=0, padlen=min(len(columns) - 1, int(2.0 / cutoff))))
