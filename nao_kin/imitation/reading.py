"""From the points of a file to a skeleton: its times, its names or its order, which a person's bones show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nao_kin._core.arrays import Floats, shaped
from nao_kin._core.headings import seconds_of
from nao_kin.errors import BadArgument, BadInputFile, DegeneratePoints, NotFinite, WrongShape
from nao_kin.imitation.bones import misfit
from nao_kin.imitation.layouts import LAYOUTS, Layout, by_joint, check_names, landmark_array, layout_of, shown_joints
from nao_kin.imitation.skeleton import Points, Skeleton, assembled, check_points, frame_times, refuse_plane

# Times of a Kinect in ticks of 100 ns, between two frames of a sensor with 30 frames per second, or 15 in the dark.
_TICKS = (250_000.0, 800_000.0)
# An order is taken if its bones differ by less than this part of those of the next one. In a single frame, which does
# not show that lengths are constant, 4 of 1680 simulated people were taken in a wrong order.
_CLEARLY = 0.5
BY_SOURCE = "source= (--source)"


@contextmanager
def errors_of(name: str) -> Iterator[None]:
    """Name the file in errors about its points; numbers that become too large are refused as infinite ones."""
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            yield
    except (BadArgument, DegeneratePoints, NotFinite, WrongShape) as error:
        raise BadInputFile(name, str(error)) from None


@dataclass(frozen=True)
class Options:
    """The options of the caller, as in `read_skeleton`."""

    source: str | None = None
    names: Mapping[str, str] | None = None
    rate: float | None = None
    units: str | None = None
    up: str | None = None

    def named(self, points: Points, *, ordered: bool = True) -> Points:
        """Return points with the layout whose names they have, and a note; without `ordered`, with names alone."""
        joints = tuple(points.joints)
        layout = LAYOUTS[self.source] if self.source else layout_of(joints) if ordered else points.layout
        if self.names is not None:
            check_names(self.names, joints)
            layout = replace(layout, stated=self.names)
        note = f"names of {layout.name}" if layout.orders else f"joints by names: {shown_joints(layout, joints)}"
        return replace(points, layout=layout, notes=(*points.notes, note))

    @property
    def layouts(self) -> Sequence[Layout]:
        """The layout of the source, or all of them."""
        return [LAYOUTS[self.source]] if self.source else [*LAYOUTS.values()]


def seconds(
    name: str, points: Points, options: Options, advice: str = "rate= (--rate) says otherwise"
) -> tuple[Floats, tuple[str, ...]]:
    """Return the times of frames [s], or those of the caller's rate or of the sensor, and notes if they are guessed."""
    layout, unit, rate, notes, count = points.layout, points.time_unit, options.rate, tuple[str, ...](), len(points)
    if rate is None and points.times is None and layout.rate is not None and count > 1:
        rate, notes = layout.rate, (f"no times: {layout.rate:g} frames per second as of {layout.name}; {advice}",)
    if rate is not None or points.times is None:
        times, unit = frame_times(None, rate, count), "s"
    else:
        times = shaped(points.times, (count,), "times")
        if unit is None and layout.rate is not None and count > 1 and _TICKS[0] < np.median(np.diff(times)) < _TICKS[1]:
            times, unit, notes = times * 1e-7, "s", (f"times are taken as ticks of 100 ns, of {layout.name}; {advice}",)
    found, note = seconds_of(name, times, unit, frames=True, advice=advice)
    return found, (*notes, note) if note else notes


def skeleton_of(name: str, points: Points, options: Options, **advice: str) -> Skeleton:
    """Return the skeleton of points whose layout is known."""
    stamps, notes = seconds(name, points, options, **advice)
    stated = replace(points, units=options.units or points.units, notes=(*notes, *points.notes))
    return assembled(stamps, stated, options.up)


def _misfit(points: Points) -> tuple[float, str]:
    """Return how much the bones of points differ from a person's, and why they are not a person's, or ""."""
    try:
        places, sure = points.named()
        check_points(places)
    except BadArgument as error:
        return np.inf, str(error)
    return misfit(places, sure)


def person_among(what: str, cases: Mapping[str, Points], options: Options, advice: str = BY_SOURCE) -> Points:
    """Return the points in the order in which they are those of a person, if one fits clearly better than others.

    A note says so. The order of the caller needs not fit. Raises BadArgument if there is none, or more than one.
    """
    if options.source is not None and len(cases) == 1:
        return next(iter(cases.values()))
    found = sorted((*_misfit(points), label) for label, points in cases.items())
    fitting = [label for _, doubt, label in found if not doubt]
    several = len(next(iter(cases.values()))) > 1
    if fitting[:1] == [found[0][2]] and (len(found) == 1 or (several and found[0][0] < _CLEARLY * found[1][0])):
        best = fitting[0]
        others = " or ".join(label for label in cases if label != best)
        shown = f"by the lengths of bones, not {others}" if others else "by their number"
        return replace(cases[best], notes=(*cases[best].notes, f"{what} in the order of {best}, {shown}"))
    why = "" if fitting else f", but {found[0][1]}"
    raise BadArgument(f"{what}: {' or '.join(sorted(fitting or cases))}{why}; state {advice}")


def of_array(name: str, array: Any, options: Options, *, notes: Sequence[str] = (), times: Any = None) -> Skeleton:
    """Return the skeleton of points in the order of a source, which their number and their bones show."""
    array = np.asarray(array)
    if array.ndim == 3 and array.shape[1] == 3 and array.shape[2] not in (3, 4):
        array = np.moveaxis(array, 2, 0)  # (k, 3, n), as motion diffusion models write them
        notes = (*notes, f"an array (points, 3, frames), {len(array)} frames")
    count = array.shape[-2] if array.ndim > 1 else 0
    cases = {
        layout.name: Points(*by_joint(landmark_array(array, layout), layout), layout, times, notes=tuple(notes))
        for layout in options.layouts
        if options.source or layout.order_of(count)
    }
    if not cases:
        known = ", ".join(f"{layout.name} ({len(order)})" for layout in LAYOUTS.values() for order in layout.orders)
        raise BadArgument(f"{count} points: no source has as many; points of each: {known}; state {BY_SOURCE}")
    if options.names is not None:
        raise BadArgument(f"names= is for joints with names; an array has the order of {' or '.join(cases)}")
    refuse_plane(next(iter(cases.values())).joints)
    return skeleton_of(name, person_among(f"{count} points", cases, options), options)
