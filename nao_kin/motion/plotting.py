"""Diagrams of motions: every joint over time, between its limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._core.warn import need_extra
from nao_kin.errors import UnknownName
from nao_kin.motion.checking import check
from nao_kin.motion.motion import Motion, check_both, checked_names
from nao_kin.robot import RobotModel

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_SAMPLES = 2000
# Largest number of keys drawn as dots; more would look like a line.
_MAX_DOTS = 60
_COLUMNS = 3
_SIZE = (4.2, 2.0)
_LINE, _LIMIT, _OUTSIDE = "#1f6fb4", "#888888", "#d62728"


def plot(robot: RobotModel, motion: Motion, *, joints: Sequence[str] | None = None, speed: bool = False) -> Figure:
    """Draw a diagram for each joint: its values over time, its limits dashed, and violations of them in red.

    Args:
        robot: has all the joints named.
        motion: the motion to draw.
        joints: names of the joints to draw; None for all.
        speed: draw speeds and their limits instead.

    Returns:
        A matplotlib figure: `figure.savefig("motion.png")` writes it. Angles are in degrees.

    Raises:
        MissingExtra: matplotlib is not installed.

    Examples:
        >>> nod = nk.Motion([0.0, 0.5, 1.0], ["HeadPitch"], [[0.0], [0.3], [0.0]])
        >>> figure = nk.motion.plot(nk.load_nao(), nod)
        >>> len(figure.axes)
        1
    """
    need_extra("plotting a motion", "plot", "matplotlib.figure")
    from matplotlib.figure import Figure

    check_both(robot, motion)
    names = motion.joint_names if joints is None else checked_names(joints)
    for name in names:
        if name not in motion.joint_names:
            raise UnknownName("joint of the motion", name, motion.joint_names)
    violations = check(robot, motion).violations
    columns = min(_COLUMNS, len(names))
    rows = math.ceil(len(names) / columns)
    figure = Figure(figsize=(_SIZE[0] * columns, _SIZE[1] * rows + 0.4), layout="constrained")
    grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
    t = np.unique(np.concatenate([np.linspace(motion.start, motion.end, _SAMPLES), motion.key_times]))
    values = motion.speed(t) if speed else motion.sample(t)
    for axes, name in zip(grid.flat, names, strict=False):
        turns = robot.unit(name) == "rad"
        scale = math.degrees(1.0) if turns else 1.0
        column = motion.joint_names.index(name)
        kinds = ("speed",) if speed else ("limit", "coupled limit", "motor")
        bad = [row for row in violations if row.joint == name and row.kind in kinds]
        lower, upper, limit = robot.joints.limits(name)
        bounds = (-limit, limit) if speed else (lower, upper)
        _draw(axes, t, values[:, column] * scale, [bound * scale for bound in bounds], bad)
        if not speed and len(motion.keys[column]) <= _MAX_DOTS:
            axes.plot(motion.times[column], motion.keys[column] * scale, ".", color=_LINE, markersize=5)
        unit = "°" if turns else "" if robot.unit(name) == "1" else robot.unit(name)
        unit += "/s" if speed else ""
        axes.set_title(f"{name}{f' [{unit}]' if unit else ''}", fontsize=9)
    for index, axes in enumerate(grid.flat):
        if index >= len(names):
            axes.set_visible(False)
        elif index + columns >= len(names):
            axes.set_xlabel("time [s]", fontsize=8)
            axes.tick_params(labelbottom=True)
    return figure


def _draw(axes: Any, t: Any, values: Any, bounds: Sequence[float], bad: Sequence[Any]) -> None:
    finite = np.where(np.isfinite(values), values, np.nan)
    axes.plot(t, finite, color=_LINE, linewidth=1.2)
    # Only limits near the curve are drawn, so that a joint that hardly moves still shows its movement.
    low, high = float(np.nanmin(finite)), float(np.nanmax(finite))
    room = max(high - low, 1e-3)
    for bound in bounds:
        if low - room <= bound <= high + room:
            axes.axhline(bound, color=_LIMIT, linewidth=0.9, linestyle="--")
    for row in bad:
        axes.axvspan(row.start, row.end, color=_OUTSIDE, alpha=0.25, linewidth=1.0)
    axes.grid(alpha=0.3)
    axes.tick_params(labelsize=8)
    axes.margins(x=0.01)
