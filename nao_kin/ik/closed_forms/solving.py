"""A closed form run on targets: as Python on one, compiled on many, and its numbers made into an `IKResult`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from nao_kin._common.arrays import Floats
from nao_kin._common.kernel_cache import KeptKernel
from nao_kin.ik.closed_forms.ranges import (
    ANGLE_ERROR,
    BESIDE,
    BEST,
    JOINT,
    LIMIT,
    MOST_TURNED,
    NEEDED,
    NOT_RIGID,
    POSITION_ERROR,
    REASON,
)
from nao_kin.ik.compiling import run_rows
from nao_kin.ik.geometry import Limb
from nao_kin.ik.results import IKResult, Integers, Obstacles


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """A closed form of a limb.

    Attributes:
        solve: the function that solves one target, see `ranges`; None where that is a search.
        kernel: the same for rows of targets, compiled.
        branches: the most there are.
        searches: whether the kernel searches for the nearest where `solve` finds nothing.
        usual: how many there are inside the limits; where there are more, all targets are solved once more.
        more: how many numbers follow the joints in a report.
        scratch: how many numbers `solve` needs in q beside the joints.
    """

    solve: Callable[..., int] | None
    kernel: KeptKernel
    branches: int
    searches: bool = False
    usual: int = 2
    more: int = 0
    scratch: int = 0


@dataclass(frozen=True, eq=False)
class Found:
    """What a closed form writes for n targets: rows of `found` taken apart, and the reports.

    Attributes:
        values: shape (n, k, c).
        beside: distance, errors in position and angle, and family of each, shape (n, k, 4).
        count: shape (n,).
        report: shape (n, BEST + c + more).
    """

    values: Floats
    beside: Floats
    count: Integers
    report: Floats


def solved(
    form: ClosedForm,
    limb: Limb,
    targets: Floats,
    references: tuple[Floats, tuple[str, ...]],
    enforce: bool,
    threads: int | None,
    refuse: Callable[[], object],
) -> IKResult:
    """Solve targets, shape (..., m), see `found_for`."""
    found = found_for(form, limb, targets, references[0], enforce, threads, refuse)
    return IKResult(**parts_of_result(limb, targets.shape[:-1], found, references))


def found_for(
    form: ClosedForm,
    limb: Limb,
    targets: Floats,
    reference: Floats,
    enforce: bool,
    threads: int | None,
    refuse: Callable[[], object],
) -> Found:
    """What a closed form finds for targets, shape (..., m).

    Args:
        form: how.
        limb: of which limb.
        targets: what `form.solve` takes, one row for each.
        reference: configurations of shape (..., nq) that broadcast with the targets.
        enforce: leave out branches outside the limits.
        threads: how many; None for all cores where that is worthwhile.
        refuse: raises for the first target that cannot be one.
    """
    batch = targets.shape[:-1]
    joints = reference[..., limb.index]
    if limb.follows:
        joints = joints * limb.multiplier + limb.offset
    if not batch:
        if form.solve is not None and not form.kernel.in_memory:
            found = _one(form, limb, targets, joints, enforce)
        else:
            found = _one_by_kernel(form, limb, targets, joints, enforce)
        rigid = found.report[0, REASON] != NOT_RIGID
    else:
        count = math.prod(batch)
        rows = np.broadcast_to(joints, (*batch, len(limb.joints))).reshape(count, len(limb.joints))
        flat = targets.reshape(count, targets.shape[-1])
        found = _many(form, limb, flat, rows, enforce, threads)
        joints = rows
        rigid = found.report[:, REASON].min(initial=0.0) != NOT_RIGID
    if not rigid:
        refuse()
    if not enforce:
        _turn_missed(found, joints.reshape(-1, joints.shape[-1]))
    return found


def _turn_missed(found: Found, reference: Floats) -> None:
    """Turn the nearest poses of targets that are missed by whole turns to within half a turn of the reference."""
    missed, c = found.count == 0, found.values.shape[-1]
    if missed.any():
        near, best = reference[missed], found.report[missed, BEST : BEST + c]
        turns = np.floor((near - best) / (2.0 * math.pi) + 0.5)
        found.report[missed, BEST : BEST + c] = best + 2.0 * math.pi * np.where(np.abs(near) > MOST_TURNED, 0.0, turns)


def _one(form: ClosedForm, limb: Limb, target: Floats, reference: Floats, enforce: bool) -> Found:
    """One target, by the function as it stands in Python: before a batch has come, which the kernel is read for."""
    c = len(limb.joints)
    width = c + BESIDE
    values = [0.0] * (form.branches * width)
    report = [0.0] * BEST + [math.nan] * (c + form.more)
    q = [0.0] * (c + form.scratch)
    solve = cast(Callable[..., int], form.solve)
    count = solve(limb.numbers, limb.ranges, target.tolist(), reference.tolist(), enforce, q, values, report)
    if count == 0 and form.searches and report[REASON] != NOT_RIGID:
        return _one_by_kernel(form, limb, target, reference, enforce)
    rows = np.array(values[: count * width]).reshape(1, count, width)
    return Found(rows[..., :c], rows[..., c:], np.array([count]), np.array([report]))


def _one_by_kernel(form: ClosedForm, limb: Limb, target: Floats, reference: Floats, enforce: bool) -> Found:
    """One target, by the kernel's function, with room for all branches at once."""
    found = _by_kernel(form, limb, target[None], reference[None], enforce, form.branches, 1)
    count = int(found.count[0])
    return Found(found.values[:, :count], found.beside[:, :count], found.count, found.report)


def _many(
    form: ClosedForm, limb: Limb, targets: Floats, references: Floats, enforce: bool, threads: int | None
) -> Found:
    """Many targets, by the kernel's function."""
    room = min(form.usual, form.branches) if enforce else form.branches
    while True:
        found = _by_kernel(form, limb, targets, references, enforce, room, threads)
        most = int(found.count.max(initial=0))
        if most <= room:
            return Found(found.values[:, :most], found.beside[:, :most], found.count, found.report)
        room = form.branches


def _by_kernel(
    form: ClosedForm, limb: Limb, targets: Floats, references: Floats, enforce: bool, room: int, threads: int | None
) -> Found:
    """Targets by the kernel's function, with room for so many branches of each."""
    n, c = references.shape
    # As the kernel is compiled for: one type of array.
    targets, references = _plain(targets), _plain(references)
    found = _space(form, n, c, room)

    def solve(function: Callable[..., object], part: slice) -> None:
        function(
            limb.numbers,
            limb.ranges,
            targets[part],
            references[part],
            enforce,
            form.branches,
            found.values[part],
            found.beside[part],
            found.count[part],
            found.report[part],
        )

    run_rows(form.kernel, solve, n, threads)
    return found


def _space(form: ClosedForm, n: int, c: int, room: int) -> Found:
    """Arrays for what is found of n targets, with room for so many branches of each."""
    report = np.empty((n, BEST + c + form.more))
    return Found(np.empty((n, room, c)), np.empty((n, room, BESIDE)), np.empty(n, np.int64), report)


def _plain(rows: Floats) -> Floats:
    """The same numbers in the order of C, aligned, and writeable."""
    flags = rows.flags
    return rows if flags.c_contiguous and flags.writeable and flags.aligned else np.array(rows, order="C")


def parts_of_result(
    limb: Limb, batch: tuple[int, ...], found: Found, references: tuple[Floats, tuple[str, ...]]
) -> dict[str, Any]:
    """What an `IKResult` for targets of a batch shape is made of."""
    reference, notes = references
    c, k = len(limb.joints), found.values.shape[1]
    report, values = found.report.reshape(*batch, found.report.shape[1]), found.values.reshape(*batch, k, c)
    best, joint = report[..., BEST : BEST + c], report[..., JOINT].astype(np.int64)
    if limb.follows:
        values, best = (values - limb.offset) / limb.multiplier, (best - limb.offset) / limb.multiplier
    return {
        "joints": limb.joints,
        "columns": limb.columns,
        "reference": reference,
        "best": best,
        "branches": values,
        "families": found.beside[..., 3].astype(np.int8).reshape(*batch, k),
        "count": found.count.reshape(batch),
        "reasons": np.asarray(report[..., REASON], dtype=np.int8),
        "residual": report[..., POSITION_ERROR : ANGLE_ERROR + 1],
        "obstacles": Obstacles(np.asarray(joint), np.asarray(report[..., NEEDED]), np.asarray(report[..., LIMIT])),
        "notes": notes,
    }
