"""The calibration: the most likely offsets, their covariance, what the data cannot tell apart, and usual mistakes."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, choice, shaped
from nao_kin._core.text import quoted
from nao_kin._core.warn import need_extra
from nao_kin.calibration.observations import (
    BEHIND,
    AnyObservation,
    Checked,
    Contacts,
    Pixels,
    Poses,
    Seen,
    add_starts,
    errors_of,
)
from nao_kin.calibration.unknowns import COORDINATES, LARGEST_ANGLE, LARGEST_SHIFT, Unknowns
from nao_kin.errors import BadArgument, DegreesWarning, NaoKinError
from nao_kin.robot import RobotModel, check_robot, write_offsets
from nao_kin.screws import nearest_pose

# Residuals beyond this many standard deviations count with their magnitude, not with its square.
_HUBER = 3.0
# An item is an outlier if noise alone makes its residual so large with a smaller probability than this.
_RARE = 1e-6
# With more outliers than this share of all items, the observations contradict each other.
_MOST_OUTLIERS = 1 / 3
# With more than this share, usual mistakes are tried.
_MANY_OUTLIERS = 0.1
# Unknowns with a smaller part in an undetermined combination are not named.
_SMALL_PART = 0.05
_MOST_NAMED = 8
_PRIOR = 1e-3
_MOST_PASSES = 5  # of leaving out items beyond their noise


@dataclass(frozen=True)
class Outlier:
    """An observed item whose residual is larger than its noise explains.

    Attributes:
        observation: the number of the observation in the list given.
        kind: "pixels", "poses" or "contacts".
        item: the posture, and for pixels the point, as in "posture 3, point 2".
        sigmas: length of the residual in standard deviations of its noise.
    """

    observation: int
    kind: str
    item: str
    sigmas: float

    def __str__(self) -> str:
        return f"observation {self.observation} ({self.kind}), {self.item}: {self.sigmas:.1f} σ"


@dataclass(frozen=True)
class Calibration:
    """Offsets of a robot found from observations, with their covariance.

    Attributes:
        robot: the robot as it was before.
        joints: joint → offset, as `RobotModel.with_offsets` takes it [rad or m].
        frames: frame → (dx, dy, dz, roll, pitch, yaw), likewise [m, rad].
        poses: name → estimated pose of a board in its frame, of a body of markers in its frame, or of the reference
            frame in a world of motion capture; shape (4, 4).
        labels: the names of the offsets' numbers, as "HeadYaw offset" and "yaw of CameraTop's mounting".
        units: their units, "rad" or "m", or "1" for a ratio.
        values: these numbers, shape (n,).
        covariance: their covariance for the stated noise, shape (n, n); zero for numbers held at zero.
        held: the labels of numbers held at zero, because the data cannot tell them from others.
        notes: one sentence for each of these, and for outliers and residuals larger than the noise.
        residuals: for each observation, residuals in standard deviations, shape (items seen, numbers).
        initial_residuals: the same before the calibration.
        outliers: items beyond their noise, the largest first, each with the number of its `observation`, its `kind`
            ("pixels", "poses" or "contacts"), its `item` ("posture 3, point 2"), and `sigmas`, the length of its
            residual in standard deviations.

    Examples:
        >>> nao = nk.load_nao()
        >>> qs = nao.random(rng=1, n=8)
        >>> hands = nao.with_offsets({"LElbowYaw": 0.05}).fk(qs, "LArm")
        >>> seen = nk.calibration.Poses(qs, "LArm", hands, noise=(0.001, 0.01))
        >>> found = nk.calibration.calibrate(nao, [seen], joints=["LElbowYaw"])
        >>> round(found.joints["LElbowYaw"], 6), found.outliers
        (0.05, ())
        >>> found.standard_deviations["LElbowYaw offset"] < 0.01
        True
    """

    robot: RobotModel
    joints: Mapping[str, float]
    frames: Mapping[str, tuple[float, ...]]
    poses: Mapping[str, Floats]
    labels: tuple[str, ...]
    units: tuple[str, ...]
    values: Floats
    covariance: Floats
    held: tuple[str, ...]
    notes: tuple[str, ...]
    residuals: tuple[Floats, ...]
    initial_residuals: tuple[Floats, ...]
    outliers: tuple[Outlier, ...]
    _problem: Problem = field(repr=False)
    # The offsets and the numbers of unknown poses, and the covariance of all.
    _x: Floats = field(repr=False)
    _covariance: Floats = field(repr=False)

    @property
    def standard_deviations(self) -> dict[str, float]:
        """The standard deviation of each number by its label; zero if it was held at zero."""
        return dict(zip(self.labels, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def offsets(self) -> dict[str, Any]:
        """The offsets as `load_nao(offsets=…)` takes them; a joint that follows a calibrated one has its share."""
        return {"joints": dict(self.joints), "frames": dict(self.frames)}

    def calibrated(self) -> RobotModel:
        """Return the robot with the offsets."""
        return self.robot.with_offsets(**self.offsets)

    def save(self, path: Path | str, *, overwrite: bool = False) -> Path:
        """Write the offsets to a TOML file for `load_nao(offsets=…)` and `--offsets`, and return its path.

        Raises:
            BadArgument: the robot had offsets before, which the file would lack; or the file exists.
        """
        if self.robot.tree.offsets:
            raise BadArgument(f"{self.robot.name} had offsets before the calibration, which the file would lack")
        return write_offsets(path, self.offsets, overwrite=overwrite)


def calibrate(
    robot: RobotModel,
    observations: Sequence[AnyObservation],
    *,
    joints: Iterable[str] = (),
    frames: Mapping[str, Iterable[str]] | Iterable[str] = (),
    start: Mapping[str, ArrayLike] | None = None,
    indistinguishable: Literal["hold", "refuse"] = "hold",
    loss: Literal["huber", "linear"] = "huber",
) -> Calibration:
    """Return the offsets of joints and frames that explain observations best.

    Minimises Σ ρ(rᵢ) over the offsets and the unknown poses, where the residuals rᵢ are in units of their stated noise
    and ρ is Huber's: r²/2 up to 3, then 3|r| − 9/2. Items that noise does not explain are then left out. The Jacobian J
    of the residuals is analytic, and SciPy's `least_squares` searches. The covariance is (Jᵀ J)⁻¹ over the residuals up
    to 3.

    The data do not determine a combination of unknowns if the standard deviation along it, from the singular values of
    J, is larger than any offset in practice: 0.2 rad or 0.1 m. Of each such combination one offset is held at zero.

    Args:
        robot: the nominal robot.
        observations: `Pixels`, `Poses` and `Contacts`, in any mix.
        joints: the joints whose offsets are unknown. A joint that others follow is one motor: they share its offset.
        frames: frames fixed to a link whose mountings are unknown, or frame → which of "x", "y", "z", "roll", "pitch"
            and "yaw" are unknown, as in {"CameraTop": ["roll", "pitch", "yaw"]}.
        start: name → first estimate of an unknown pose, shape (4, 4); by default from the observations themselves.
        indistinguishable: "hold" numbers that the data cannot tell from others at zero, with a note; or "refuse".
        loss: "huber", or "linear" for r²/2 of all items.

    Returns:
        The offsets, their covariance, and notes.

    Raises:
        BadArgument: too few observations; observations that contradict each other, by name; indistinguishable numbers
            with "refuse", by name; a joint that follows another; a frame that a joint moves.
        UnknownName: a joint or frame that does not exist.
        MissingExtra: SciPy is not installed.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.random(rng=0, n=20)
        >>> hands = nk.calibration.Poses(q, "LArm", nao.fk(q, "LArm"))
        >>> found = nk.calibration.calibrate(nao, [hands], joints=["LElbowYaw", "RElbowYaw"])
        >>> found.notes
        ('the data say nothing about RElbowYaw offset: RElbowYaw offset is held at 0',)
    """
    check_robot(robot)
    need_extra("calibration", "calibration")
    choice(indistinguishable, ("hold", "refuse"), "indistinguishable")
    choice(loss, ("huber", "linear"), "loss")
    problem = Problem(robot, observations, joints, frames, {} if start is None else start)
    x, free, notes = np.zeros(problem.size), np.ones(problem.size, dtype=bool), list[str]()
    initial = [seen.residuals for seen in problem.seen(x)]
    if any((residuals == BEHIND).any() for residuals in initial):
        raise BadArgument(
            "at the start, points seen are behind the camera or beyond its lens; check them, or give start=…"
            + likely_mistake(problem, problem.again)
        )
    known: list[Outlier] = []
    for _ in range(_MOST_PASSES):
        while True:
            x = problem.solved(x, free, loss)
            groups, x_held = problem.undetermined(x, free)
            if not groups:
                break
            told = [_told(problem.labels, held, members) for held, members in groups]
            if indistinguishable == "refuse":
                raise BadArgument(f"{'; '.join(told)}; observe more, or calibrate fewer")
            for text, (held, _) in zip(told, groups, strict=True):
                free[held] = False
                notes.append(f"{text}: {problem.labels[held]} is held at 0")
            x = x_held
        seen = [part.residuals for part in problem.seen(x)]
        outliers, items = problem.outliers(seen)
        if len(outliers) > _MOST_OUTLIERS * items:
            raise BadArgument(
                f"the observations contradict each other: {len(outliers)} of {items} are beyond their noise: "
                f"{'; '.join(map(str, outliers[:3]))}"
                + (
                    likely_mistake(problem, problem.again)
                    or "; is the stated noise too small, or a point or posture wrong?"
                )
            )
        if loss == "linear" or {(o.observation, o.item) for o in outliers} == {(o.observation, o.item) for o in known}:
            break
        known = outliers
        problem.leave_out(seen)
    if outliers:
        listed = "; ".join(map(str, outliers[:3]))
        mistake = likely_mistake(problem, problem.again) if len(outliers) > _MANY_OUTLIERS * items else ""
        notes.append(f"{len(outliers)} of {items} observed items are beyond their noise: {listed}{mistake}")
    ratio = problem.noise_ratio(seen, int(free.sum()))
    if ratio is not None:
        notes.append(f"residuals are {ratio:.2g} times as large as the stated noise explains: so are the true errors")
    unknowns = problem.unknowns
    state, n, covariance = unknowns.at(x), unknowns.offsets, problem.covariance(x, free, loss)
    offsets = {name: float(x[i]) for i, name in enumerate(unknowns.joints)}
    followers = {name: m.multiplier * offsets[m.joint] for name, m in robot.mimics.items() if m.joint in offsets}
    return Calibration(
        robot=robot,
        joints=offsets | followers,
        frames={name: tuple(state.six(block).tolist()) for name, block in unknowns.frames.items()},
        poses={name: state.pose(name).T for name in unknowns.poses},
        labels=tuple(problem.labels[:n]),
        units=tuple(unknowns.units[:n]),
        values=x[:n],
        covariance=covariance[:n, :n],
        held=tuple(np.array(problem.labels)[~free].tolist()),
        notes=tuple(notes),
        residuals=tuple(seen),
        initial_residuals=tuple(initial),
        outliers=tuple(outliers),
        _problem=problem,
        _x=x,
        _covariance=covariance,
    )


class Problem:
    """Checked observations and the unknowns that explain them."""

    def __init__(
        self,
        robot: RobotModel,
        observations: Sequence[AnyObservation],
        joints: Iterable[str],
        frames: Mapping[str, Iterable[str]] | Iterable[str],
        start: Mapping[str, ArrayLike],
    ) -> None:
        several = isinstance(observations, Iterable) and getattr(observations, "ndim", 1) > 0
        given = list(observations) if several else [observations]
        if not isinstance(start, Mapping):
            raise BadArgument(f"start must map names to poses, got {quoted(start)}")
        self.observations: list[Checked] = []
        for number, one in enumerate(given):
            if not isinstance(one, Pixels | Poses | Contacts):
                raise BadArgument(f"expected observations: Pixels, Poses or Contacts, got {quoted(one)}")
            with errors_of(f"observation {number}"):
                self.observations.append(one._checked(robot))
        names = dict[str, str]()
        for name, meaning in (pose for one in self.observations for pose in one.poses):
            if names.setdefault(name, meaning) != meaning:
                raise BadArgument(f"{quoted(name)} names a {names[name]} and a {meaning}: give them different names")
        self.unknowns = Unknowns(robot, joints, frames, names)
        self.labels, self.size = self.unknowns.labels, len(self.unknowns.labels)
        self._scales = np.where(np.array(self.unknowns.units) == "m", LARGEST_SHIFT, LARGEST_ANGLE)
        if not self.unknowns.offsets:
            raise BadArgument("nothing to calibrate: name joints, or frames")
        count = sum(int(one.mask.sum()) * one.measured.shape[-1] for one in self.observations)
        if count < self.size:
            raise BadArgument(f"too few observations: {count} numbers for {self.size} unknowns")
        for name in start:
            choice(name, names, "board, marker or world")
        starts = {name: nearest_pose(shaped(T, (4, 4), f"start of {name}")) for name, T in start.items()}
        nominal = Unknowns(robot, (), (), ()).at(np.zeros(0))
        # Observations that share a pose with a richer one are started by it.
        for rich in sorted(self.observations, key=lambda one: -int(one.mask.sum())):
            add_starts(nominal, rich, starts)
        for name, block in self.unknowns.poses.items():
            self.unknowns.poses[name] = replace(block, start=starts[name])
        self._kept = [np.ones(int(one.mask.sum())) for one in self.observations]
        self._last: tuple[bytes, list[Seen]] | None = None
        self._start = dict(start)

    def again(self, observations: Sequence[AnyObservation]) -> Problem:
        """Return the same problem with other observations."""
        unknowns = self.unknowns
        frames = {
            name: [coordinate for coordinate, place in zip(COORDINATES, block.places, strict=True) if place >= 0]
            for name, block in unknowns.frames.items()
        }
        return Problem(unknowns.robot, observations, unknowns.joints, frames, self._start)

    def seen(self, x: Floats) -> list[Seen]:
        """Return the residuals of each observation, and their derivatives."""
        key = x.tobytes()  # residuals and derivatives are asked for one after the other
        if self._last is None or self._last[0] != key:
            state = self.unknowns.at(x)
            self._last = key, [one.at(state) for one in self.observations]
        return self._last[1]

    def residuals(self, x: Floats) -> Floats:
        """Return all residuals, shape (m,), zero for items left out."""
        return np.concatenate(
            [(part.residuals * kept[:, None]).ravel() for part, kept in zip(self.seen(x), self._kept, strict=True)]
        )

    def jacobian(self, x: Floats) -> Floats:
        """Return the derivatives of all residuals, shape (m, unknowns)."""
        parts = [part.J * kept[:, None, None] for part, kept in zip(self.seen(x), self._kept, strict=True)]
        return np.asarray(np.concatenate([part.reshape(-1, self.size) for part in parts]))

    def solved(self, x: Floats, free: NDArray[np.bool_], loss: str, steps: int | None = None) -> Floats:
        """Return the unknowns of least loss, after at most so many `steps`; those that are not free stay."""
        from scipy.optimize import least_squares

        scales = self._scales[free]
        if not len(scales):
            return x

        def whole(part: Floats) -> Floats:
            found: Floats = x.copy()
            found[free] = part
            return found

        # A prior a thousand times wider than the scales keeps numbers without any effect where they are.
        prior = _PRIOR * np.eye(len(scales)) / scales
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DegreesWarning)  # of steps that are taken back
            for stage in dict.fromkeys(("linear", loss)):  # squares first: they lead there from far away
                x = whole(
                    least_squares(
                        lambda part: np.concatenate((self.residuals(whole(part)), prior @ part)),
                        x[free],
                        lambda part: np.concatenate((self.jacobian(whole(part))[:, free], prior)),
                        x_scale=scales,
                        loss=stage,
                        f_scale=_HUBER,
                        xtol=1e-12,
                        ftol=1e-12,
                        gtol=1e-12,
                        max_nfev=steps,
                    ).x
                )
        return x

    def _scaled(self, x: Floats, free: NDArray[np.bool_], loss: str) -> Floats:
        """Return the derivatives by each free unknown in its scale, of residuals that count fully."""
        J = self.jacobian(x)[:, free] * self._scales[free]
        return J if loss == "linear" else J[np.abs(self.residuals(x)) <= _HUBER]

    def covariance(self, x: Floats, free: NDArray[np.bool_], loss: str) -> Floats:
        """Return the covariance of the unknowns, zero where they are not free."""
        _, sizes, V = np.linalg.svd(self._scaled(x, free, loss), full_matrices=False)
        root = V.T / sizes * self._scales[free, None]
        found = np.zeros((self.size, self.size))
        found[np.ix_(free, free)] = root @ root.T
        return found

    def undetermined(self, x: Floats, free: NDArray[np.bool_]) -> tuple[list[tuple[int, list[int]]], Floats]:
        """Return each undetermined combination as its number to hold at zero and its members, and the moved x.

        The unknowns x are moved along the combinations until these numbers are zero.
        """
        from scipy.linalg import qr

        places = np.flatnonzero(free)
        _, sizes, V = np.linalg.svd(self._scaled(x, free, "linear"))
        null = V[int((sizes >= 1.0).sum()) :].T
        if not null.shape[1]:
            return [], x
        # Mountings are held before joints, and poses of boards only if no offset takes part.
        weights = np.where(places < len(self.unknowns.joints), 0.7, np.where(places < self.unknowns.offsets, 1.0, 1e-4))
        held = np.sort(qr(null.T * weights, pivoting=True, mode="r")[1][: null.shape[1]])
        parts = null @ np.linalg.inv(null[held])
        large = np.abs(parts) > _SMALL_PART * np.abs(parts).max(axis=0)
        groups = [(int(places[k]), places[large[:, j]].tolist()) for j, k in enumerate(held)]
        moved, scales = x.copy(), self._scales[free]
        moved[places] -= scales * (parts @ (x[places][held] / scales[held]))
        moved[places[held]] = 0.0
        return groups, moved

    def leave_out(self, seen: list[Floats]) -> None:
        """Leave out the items that are beyond their noise at these residuals, and no others."""
        self._kept = [(~_beyond(residuals)).astype(float) for residuals in seen]

    def outliers(self, seen: list[Floats]) -> tuple[list[Outlier], int]:
        """Return the items beyond their noise, the largest first, and the number of all items."""
        found = []
        for number, (one, residuals) in enumerate(zip(self.observations, seen, strict=True)):
            sizes = np.linalg.norm(residuals, axis=1)
            for row in np.flatnonzero(_beyond(residuals)):
                found.append(Outlier(number, one.kind, one.describe(int(row)), float(sizes[row])))
        return sorted(found, key=lambda outlier: -outlier.sigmas), sum(map(len, seen))

    def noise_ratio(self, seen: list[Floats], unknowns: int) -> float | None:
        """Return the ratio of residuals and stated noise; None if chance explains it."""
        from scipy.stats import chi2

        near = np.concatenate([part[~_beyond(part)].ravel() for part in seen])
        freedom, total = near.size - unknowns, float(near @ near)
        if freedom <= 0 or chi2.sf(total, freedom) > _RARE:
            return None
        return float(np.sqrt(total / freedom))


def _beyond(residuals: Floats) -> NDArray[np.bool_]:
    """Return which items, rows of residuals, noise alone does not explain."""
    from scipy.stats import chi2

    return np.asarray((residuals**2).sum(axis=1) > chi2.isf(_RARE, residuals.shape[1]))


def _told(labels: Sequence[str], held: int, members: Sequence[int]) -> str:
    if len(members) == 1:
        return f"the data say nothing about {labels[held]}"
    names = [labels[i] for i in members]
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return f"the data cannot tell apart {', '.join(names[:_MOST_NAMED])}{more}"


# --- Usual mistakes in pixels of known points: another order of the corners, exchanged coordinates, a wrong size.

# A mistake is named if this quantile of the residuals is without it below this part of the one with it, and of σ.
_QUANTILE, _BETTER, _GOOD = 0.85, 0.25, 5.0
# Units that are taken for metres, and their size.
_UNITS = {"mm": 1e-3, "cm": 1e-2, "inches": 0.0254}
# Sizes of squares are seldom wrong by more; most sizes that are tried.
_LARGEST_RATIO, _MOST_SIZES = 2.0, 20
_MAX_NAMED = 5
# Steps of a search, which needs fewer if the observations agree.
_STEPS = 25


def likely_mistake(problem: Problem, again: Callable[[Sequence[AnyObservation]], Problem]) -> str:
    """Return which usual mistake explains bad residuals of `Pixels`, to end a message; "" if none does.

    Args:
        problem: the observations as given.
        again: makes the same problem with other observations.
    """
    given = [one.given for one in problem.observations]
    if not any(isinstance(one, Pixels) for one in given):
        return ""
    limit = min(_GOOD, _BETTER * _misfit(problem))

    def misfit(changed: Sequence[AnyObservation]) -> float:
        try:
            return _misfit(again(changed))
        except NaoKinError:
            return np.inf

    tried = [(misfit(changed), what) for what, changed in _changes(problem, given)]
    best, what = min(tried, key=lambda pair: pair[0])
    if best < limit:
        return f"; they agree if {what}"
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda power: misfit(_stretched(given, _LARGEST_RATIO**power)),
        bounds=(-1.0, 1.0),
        method="bounded",
        options={"maxiter": _MOST_SIZES, "xatol": 1e-3},
    )
    if found.fun < limit:
        ratio = _LARGEST_RATIO**found.x
        return f"; they agree if the points are {ratio:.3g} times as far apart (is the size of a square right?)"
    return ""


def _changes(problem: Problem, given: Sequence[AnyObservation]) -> Iterator[tuple[str, list[AnyObservation]]]:
    """Yield each mistake in words, and the observations without it."""
    state = problem.unknowns.at(np.zeros(problem.size))
    turned, named = list(given), list[str]()
    for number, one in enumerate(problem.observations):
        if isinstance(one.given, Pixels):
            predicted = one.measure(state, one.q).residuals
            reverse = _distances(one.measured[:, ::-1], predicted) < _distances(one.measured, predicted)
            pixels = np.array(one.given.pixels, dtype=np.float64)
            rows = pixels.reshape(-1, *pixels.shape[-2:])
            rows[reverse] = rows[reverse, ::-1]
            turned[number] = replace(one.given, pixels=pixels)
            if reverse.any():
                named.append(_postures(number, one, np.flatnonzero(reverse).tolist()))
    if named:
        yield f"the points are in reverse order in {'; '.join(named)}", turned
    yield (
        "u and v are exchanged",
        [replace(one, pixels=np.asarray(one.pixels)[..., ::-1]) if isinstance(one, Pixels) else one for one in given],
    )
    for unit, size in _UNITS.items():
        yield (
            f"the points are in {unit}, not in metres",
            [replace(one, points=size * np.asarray(one.points)) if isinstance(one, Pixels) else one for one in given],
        )


def _stretched(given: Sequence[AnyObservation], size: float) -> list[AnyObservation]:
    """Return observations with points that are so many times as far from the first one."""
    changed = list(given)
    for number, one in enumerate(given):
        if isinstance(one, Pixels):
            points = np.asarray(one.points, dtype=np.float64)
            changed[number] = replace(one, points=points[0] + size * (points - points[0]))
    return changed


def _postures(number: int, one: Checked, rows: list[int]) -> str:
    """Return the name of an observation, and of its postures if they are not all of it."""
    if len(rows) == len(one.q):
        return f"observation {number}"
    listed = ", ".join(map(str, rows[:_MAX_NAMED])) + (" …" if len(rows) > _MAX_NAMED else "")
    return f"posture {listed} of observation {number}"


def _distances(measured: Floats, predicted: Floats) -> Floats:
    """Return the mean distance of the points that are seen in each posture, shape (n,); 0 if there is none."""
    distances = np.linalg.norm(measured - predicted, axis=-1)
    known = np.isfinite(distances)
    return np.asarray(np.where(known, distances, 0.0).sum(axis=-1) / np.maximum(known.sum(axis=-1), 1))


def _misfit(problem: Problem) -> float:
    """Return a high quantile of the residuals of pixels after a calibration, in σ; infinite if it cannot start."""
    x = np.zeros(problem.size)
    if any((part.residuals == BEHIND).any() for part in problem.seen(x)):
        return np.inf
    seen = problem.seen(problem.solved(x, np.ones(problem.size, dtype=bool), "linear", _STEPS))
    pixels = [part for part, one in zip(seen, problem.observations, strict=True) if isinstance(one.given, Pixels)]
    return float(np.quantile(np.concatenate([np.linalg.norm(part.residuals, axis=-1) for part in pixels]), _QUANTILE))
