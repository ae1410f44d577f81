"""From the points of a file to a skeleton: its times, its names or its order, which a person's bones show."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from nao_kin._core.arrays import Floats, shaped
from nao_kin._core.headings import seconds_of
from nao_kin.errors import BadArgument, BadInputFile, DegeneratePoints, NotFinite, WrongShape
from nao_kin.imitation.bones import misfit
from nao_kin.imitation.layouts import (
    LAYOUTS,
    Layout,
    by_joint,
    check_names,
    check_shoulders,
    key_of,
    landmark_array,
    layout_of,
    shown_joints,
)
from nao_kin.imitation.skeleton import (
    Skeleton,
    assembled,
    check_points,
    frame_times,
    named_points,
    of_landmarks,
    refuse_plane,
)

# Times of a Kinect in ticks of 100 ns, between two frames of a sensor with 30 frames per second, or 15 in the dark.
_TICKS = (250_000.0, 800_000.0)
# An order is taken if its bones differ by less than this part of those of the next one.
_CLEARLY = 0.5


@dataclass(frozen=True)
class Options:
    """The options of the caller, as in `read_skeleton`."""

    source: str | None = None
    names: Mapping[str, str] | None = None
    rate: float | None = None
    units: str | None = None
    up: str | None = None

    def layout(self, joints: Sequence[str], *, ordered: bool = True) -> tuple[Layout, list[str]]:
        """Return the layout of points with names, and a note: the caller's, or one whose names the points have.

        Without `ordered`, layouts of other files do not count.
        """
        layout = LAYOUTS[self.source] if self.source else layout_of(joints) if ordered else Layout("names")
        if self.names is not None:
            check_names(self.names, joints)
            layout = replace(layout, stated=self.names)
        found = layout.resolved(joints)
        check_shoulders(found, joints)
        return layout, [f"names of {layout.name}" if layout.orders else f"joints by names: {shown_joints(found)}"]


@contextmanager
def errors_of(name: str) -> Iterator[None]:
    """Name the file in errors about its points; numbers that become too large are refused as infinite ones."""
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            yield
    except (BadArgument, DegeneratePoints, NotFinite, WrongShape) as error:
        raise BadInputFile(name, str(error)) from None


def seconds(
    name: str,
    options: Options,
    count: int,
    times: Any = None,
    unit: str | None = None,
    *,
    sensor: Layout | None = None,
    advice: str = "rate= (--rate) says otherwise",
) -> tuple[Floats, tuple[str, ...]]:
    """Return the times of a file's frames [s], or those of the caller's rate, and a note if they are guessed.

    Without times, they are those of the sensor.
    """
    if options.rate is not None or times is None:
        rate, notes = options.rate, tuple[str, ...]()
        if rate is None and sensor is not None and sensor.rate is not None and count > 1:
            rate, notes = sensor.rate, (f"no times: {sensor.rate:g} frames per second as of {sensor.name}; {advice}",)
        return seconds_of(name, frame_times(None, rate, count), "s", frames=True, advice=advice)[0], notes
    given = shaped(times, (count,), "times")
    step = float(np.median(np.diff(given))) if count > 1 else 0.0
    if unit is None and sensor is not None and sensor.rate is not None and _TICKS[0] < step < _TICKS[1]:
        given, unit = given * 1e-7, "s"
        note = f"times are taken as ticks of 100 ns, of {sensor.name}; {advice}"
        return seconds_of(name, given, unit, frames=True, advice=advice)[0], (note,)
    found, note = seconds_of(name, given, unit, frames=True, advice=advice)
    return found, (note,) if note else ()


def of_named(
    name: str,
    joints: Mapping[str, Floats],
    confidence: Mapping[str, Floats],
    times: Any,
    unit: str | None,
    options: Options,
    *,
    ordered: bool = True,
    units: str | None = None,
    notes: Sequence[str] = (),
    advice: str = "rate= (--rate) says otherwise",
) -> Skeleton:
    """Return the skeleton of points with names, or with numbers in the order of a source."""
    refuse_plane(joints)
    numbered = _numbered(joints, confidence, options)
    if numbered is None:
        layout, found = options.layout(list(joints), ordered=ordered)
    else:
        (layout, joints, confidence), found = numbered
        check_names(options.names or {}, list(joints))
        layout = replace(layout, stated=options.names)
    count = len(next(iter(joints.values())))
    stamps, noted = seconds(name, options, count, times, unit, sensor=layout, advice=advice)
    return assembled(
        stamps,
        joints,
        layout,
        confidence,
        units=options.units or units,
        up=options.up,
        notes=(*noted, *notes, *found),
    )


def of_array(
    name: str, array: Any, times: Any, options: Options, *, unit: str | None = None, notes: Sequence[str] = ()
) -> Skeleton:
    """Return the skeleton of points in the order of a source, which their number and their bones show."""
    array = np.asarray(array)
    if array.ndim == 3 and array.shape[1] == 3 and array.shape[2] not in (3, 4) and _fitting(array.shape[0]):
        array = np.moveaxis(array, 2, 0)  # (k, 3, n), as motion diffusion models write them
        notes = (*notes, f"an array (points, 3, frames), {array.shape[0]} frames")
    count = array.shape[-2] if array.ndim > 1 else 0
    fitting = _fitting(count)
    if options.source is not None:
        layout, found = LAYOUTS[options.source], list[str]()
    elif fitting:
        given = landmark_array(array, fitting[0])
        refuse_plane(by_joint(given, fitting[0])[0])
        orders = {layout.name: Ordered(layout, *by_joint(given, layout)) for layout in fitting}
        (layout, *_), *found = person_among(f"{count} points", orders, "source= (--source)")
    else:
        known = ", ".join(f"{layout.name} ({len(order)})" for layout in LAYOUTS.values() for order in layout.orders)
        raise BadArgument(f"{count} points: no source has as many; points of each: {known}; state source= (--source)")
    if options.names is not None:
        raise BadArgument(f"names= is for joints with names; an array has the order of {layout.name}")
    array = landmark_array(array, layout)
    stamps, noted = seconds(name, options, len(array), times, unit, sensor=layout)
    return of_landmarks(array, layout, times=stamps, units=options.units, up=options.up, notes=(*noted, *notes, *found))


def _fitting(count: int) -> list[Layout]:
    return [layout for layout in LAYOUTS.values() if layout.order_of(count)]


class Ordered(NamedTuple):
    """Points without names, which have those of a source if they are in its order."""

    layout: Layout
    joints: Mapping[str, Floats]
    confidence: Mapping[str, Floats]

    def misfit(self) -> tuple[float, str]:
        """Return how much the bones of these points differ from a person's, and why they are not a person's, or ""."""
        try:
            points, sure = named_points(self.joints, self.layout, self.confidence)
            check_points(points)
        except BadArgument as error:
            return np.inf, str(error)
        return misfit(points, sure)


def person_among(what: str, orders: Mapping[str, Ordered], advice: str) -> tuple[Ordered, str]:
    """Return the order in which points are those of a person, if one fits clearly better than others; and a note.

    Raises BadArgument if there is none, or more than one.
    """
    found = {label: order.misfit() for label, order in orders.items()}
    fitting = sorted((value, label) for label, (value, doubt) in found.items() if not doubt)
    if len(fitting) == 1 or (fitting and fitting[0][0] < _CLEARLY * fitting[1][0]):
        best = fitting[0][1]
        others = [label for label in orders if label != best]
        shown = f"by the lengths of bones, not {' or '.join(others)}" if others else "by their number"
        return orders[best], f"{what} in the order of {best}, {shown}"
    why = f", but {next(iter(found.values()))[1]}" if not fitting else ""
    raise BadArgument(
        f"{what}: {' or '.join(label for _, label in fitting) or ' or '.join(orders)}{why}; state {advice}"
    )


def _numbered(
    joints: Mapping[str, Floats], confidence: Mapping[str, Floats], options: Options
) -> tuple[Ordered, list[str]] | None:
    """Return points with numbers in the order of a source, and a note on it; None unless there are some.

    The order is that of a source with as many points, or of MediaPipe, counted from 0 or from 1. If the numbers allow
    several, the lengths of bones decide.
    """
    at = {int(key_of(joint)): joint for joint in joints if re.fullmatch("[0-9]{1,3}", key_of(joint))}
    if not at or any(key_of(part).isdecimal() for text in (options.names or {}).values() for part in text.split("+")):
        return None
    orders = {}
    for layout in LAYOUTS.values():
        for order in layout.orders:
            for first in (0, 1):
                whole = sorted(at) == [*range(first, first + len(order))]
                part = layout.name == (options.source or "mediapipe") and (
                    first <= min(at) and max(at) < first + len(order)
                )
                if options.source in (None, layout.name) and (whole or part):
                    named, sure = (
                        {order[k - first]: arrays[joint] for k, joint in at.items() if joint in arrays}
                        for arrays in (joints, confidence)
                    )
                    orders[f"{layout.name}, counted from {first}"] = Ordered(layout, named, sure)
    if not orders:
        return None
    what, advice = f"{len(at)} numbered points", "source= (--source), or names= (--names) such as left_shoulder=11"
    if options.source and len(orders) == 1:
        return next(iter(orders.values())), [f"{what} in the order of {next(iter(orders))}"]
    ordered, note = person_among(what, orders, advice)
    return ordered, [note]
