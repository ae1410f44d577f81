"""The calibration: the most likely offsets, usual mistakes in the observations, and which posture to observe next."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import date
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, choice, whole_number
from nao_kin._core.text import listed, one_line_repr
from nao_kin._core.warn import need_extra
from nao_kin.calibration.observations import BEHIND, Pixels
from nao_kin.calibration.problem import AnyObservation, Outlier, Problem, told
from nao_kin.calibration.unknowns import PRIORS, names_of
from nao_kin.errors import BadArgument, DegreesWarning, NaoKinError
from nao_kin.robot import RobotModel, write_offsets
from nao_kin.world import Camera

READING = next(row.deviation for row in PRIORS if row.of == "reading")
# With more outliers than this share of all items, the observations contradict each other.
_MOST_OUTLIERS = 1 / 3
# With more than this share, usual mistakes are tried.
_MANY_OUTLIERS = 0.07
# Ends of messages for which no usual mistake is found.
_WRONG = "; is the stated noise too small, or a point, a posture or the time of an image wrong (moving=…)?"
_CAUSES = "; is the place or size of a board, the lens or a time of the images wrong? prior=… allows larger offsets"
_MOST_PASSES = 5  # of leaving out items beyond their noise
_MOST_RANDOM = 100_000
# A gain that counts [nats].
_LEAST_GAIN = 1e-6


@one_line_repr
@dataclass(frozen=True)
class Calibration:
    """Offsets of a robot found from observations, with their covariance.

    Attributes:
        robot: the robot as it was before.
        joints: joint → offset, as `RobotModel.with_offsets` takes it [rad or m].
        frames: frame → (dx, dy, dz, roll, pitch, yaw), likewise [m, rad].
        cameras: name → the camera with the lens that was estimated because none was given as measured.
        clocks: name of a camera → by how much its images are later than their times, in the clock of the joints [s].
        poses: name → estimated pose of a board in its frame, of a body of markers in its frame, or of the reference
            frame in a world of motion capture; shape (4, 4).
        labels: the names of the numbers of offsets, lenses and clocks, as "HeadYaw offset", "yaw of CameraTop's
            mounting", "k1 of CameraTop's lens" and "clock of CameraTop".
        units: their units, "rad", "m" or "s", or "1" for a ratio and for numbers of a lens, which are added to its own:
            its focal length and the ratio of both as parts of them, its centre in widths of the image.
        values: these numbers, shape (n,).
        prior_deviations: their standard deviations before the calibration, shape (n,); infinite without a prior.
        covariance: the covariance of their errors for the stated noise, shape (n, n). Numbers held at zero have that
            of before, or 0.2 rad and 0.1 m without a prior; the others have the part of it that they take over.
        held: the labels of offsets held at zero, because the data do not determine them.
        notes: one sentence for each of these, with what to observe to determine it, and for outliers, unlikely offsets
            and residuals larger than the noise.
        residuals: for each observation, residuals in standard deviations, shape (items seen, numbers), without the
            effect of the most likely errors of the reported joint values.
        initial_residuals: those before the calibration, with this effect.
        outliers: items beyond their noise, the largest first, each with the number of its `observation`, its `kind`
            ("pixels", "lines", "poses" or "contacts"), its `item` ("posture 3, point 2"), and `sigmas`, the length of
            its residual in standard deviations.

    Examples:
        >>> nao = nk.load_nao()
        >>> qs = nao.random(rng=1, n=8)
        >>> hands = nao.with_offsets({"LElbowYaw": 0.05}).fk(qs, "LArm")
        >>> seen = nk.calibration.Poses(qs, "LArm", hands, noise=(0.001, 0.01))
        >>> found = nk.calibration.calibrate(nao, [seen], joints=["LElbowYaw"])
        >>> round(found.joints["LElbowYaw"], 3), found.outliers
        (0.048, ())
        >>> found.standard_deviations["LElbowYaw offset"] < 0.01
        True
    """

    robot: RobotModel
    joints: Mapping[str, float]
    frames: Mapping[str, tuple[float, ...]]
    cameras: Mapping[str, Camera]
    clocks: Mapping[str, float]
    poses: Mapping[str, Floats]
    labels: tuple[str, ...]
    units: tuple[str, ...]
    values: Floats
    prior_deviations: Floats
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
        """The standard deviation of each number's error by its label."""
        return dict(zip(self.labels, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def rms_before(self) -> float:
        """The root mean square of the residuals before the calibration, in standard deviations."""
        return _root_mean_square(self.initial_residuals)

    @property
    def rms_after(self) -> float:
        """The root mean square of the residuals; about 1 if the noise is as stated."""
        return _root_mean_square(self.residuals)

    @property
    def offsets(self) -> dict[str, Any]:
        """The offsets as `load_nao(offsets=…)` takes them; a joint that follows a calibrated one has its share.

        Lenses that were estimated are in the table "cameras".
        """
        lenses = {
            name: (lens.width, lens.height, lens.fx, lens.fy, lens.cx, lens.cy, *lens.distortion)
            for name, lens in self.cameras.items()
        }
        return {"joints": dict(self.joints), "frames": dict(self.frames)} | ({"cameras": lenses} if lenses else {})

    def calibrated(self) -> RobotModel:
        """Return the robot with the offsets."""
        return self.robot.with_offsets(**self.offsets)

    def save(self, path: Path | str, *, overwrite: bool = False) -> Path:
        """Write the offsets to a TOML file for `load_nao(offsets=…)` and `--offsets`, and return its path.

        The file names the robot, the date, the observations, the root mean square of the residuals before and after,
        and the standard deviation of each number. Joints whose offset the data do not determine are comments.

        Raises:
            BadArgument: the robot had offsets before, which the file would lack; or the file exists.
        """
        tree = self.robot.tree
        tools = {row.child: row for row in tree.joints if row.child in tree.added}
        if not tree.offsets.keys() <= {row.name for row in tools.values()}:
            raise BadArgument(f"{self.robot.name} had offsets before the calibration, which the file would lack")
        about: dict[str, Any] = {
            "robot": self.robot.name,
            "date": date.today().isoformat(),
            "observations": ", ".join(f"{one.kind} in {len(one.q)} postures" for one in self._problem.observations),
            "items": sum(map(len, self.residuals)),
            "outliers": len(self.outliers),
            "rms_before": self.rms_before,
            "rms_after": self.rms_after,
            "standard_deviations": self.standard_deviations,
        }
        remarks, offsets, known = dict[str, str](), self.offsets, self.robot.semantics
        # The file also has what the robot had been given: more frames, other lenses, and the errors of sensors.
        more = {name: (link, (*tools[name].origin.xyz, *tools[name].origin.rpy)) for name, link in tree.added.items()}
        offsets |= {"added_frames": more} if more else {}
        offsets["cameras"] = {**known.lenses, **offsets.get("cameras", {})}
        offsets |= {"sensors": known.sensors} | ({"version": known.version} if known.version else {})
        joints = offsets["joints"]
        for joint in self.joints:
            label = f"{self.robot.mimics[joint].joint if joint in self.robot.mimics else joint} offset"
            remarks[joint] = f"± {self.standard_deviations[label]:.2g}"
            if label in self.held:
                del joints[joint]
                remarks[joint] = f"not determined, ± {self.standard_deviations[label]:.2g}"
        things = {name: f"{name}'s mounting" for name in self.frames}
        for name, thing in {**things, **{f"lens of {name}": f"{name}'s lens" for name in self.cameras}}.items():
            held = [label.partition(" of ")[0] for label in self.held if label.endswith(f" of {thing}")]
            if held:
                remarks[name] = f"not determined: {', '.join(held)}"
        return write_offsets(path, offsets, about=about, remarks=remarks, overwrite=overwrite)


def _root_mean_square(residuals: Sequence[Floats]) -> float:
    flat = np.concatenate([part.ravel() for part in residuals])
    return float(np.sqrt(flat @ flat / max(flat.size, 1)))


def calibrate(
    robot: RobotModel,
    observations: Sequence[AnyObservation],
    *,
    joints: Iterable[str] = (),
    frames: Mapping[str, Iterable[str]] | Iterable[str] = (),
    start: Mapping[str, ArrayLike] | None = None,
    prior: Mapping[str, ArrayLike] | Literal["typical", "none"] = "typical",
    joint_noise: float = READING,
    indistinguishable: Literal["hold", "refuse"] = "hold",
    loss: Literal["huber", "linear"] = "huber",
) -> Calibration:
    """Return the most likely offsets of joints and frames, given observations and what is known before them.

    Minimises Σ ρ(rᵢ) + Σ ρ(xⱼ/sⱼ) over the offsets x and the unknown poses (maximum a posteriori). The residuals rᵢ
    are in units of their stated noise, s are the prior standard deviations of the offsets, and ρ is Huber's: r²/2 up to
    3, then 3|r| − 9/2. Items that noise does not explain are then left out. The Jacobian J of the residuals is
    analytic, and SciPy's `least_squares` searches. The covariance is (Jᵀ J + diag(1/s²))⁻¹ over the residuals up to 3.

    The reported value of each turning joint has an error in each posture, which moves all that is seen in it. The most
    likely errors are taken out of the residuals, and count as residuals themselves, divided by `joint_noise`.

    The data do not determine an offset if its standard deviation is still more than 0.8 s, or, without a prior, more
    than any offset in practice: 0.2 rad or 0.1 m. It is held at zero, the others are estimated again, and the notes say
    so: one offset after the other, until the data determine all others.
    The covariance then is the consider covariance: with the sensitivity S of the others to the held ones and the priors
    P of these, the others have Σ + S P Sᵀ.

    Source: Schmidt, Application of state-space methods to navigation problems, 1966 (consider covariance).

    Args:
        robot: the nominal robot.
        observations: `Pixels`, `Lines`, `Poses` and `Contacts`, in any mix.
        joints: the joints whose offsets are unknown. A joint that others follow is one motor: they share its offset.
        frames: frames fixed to a link whose mountings are unknown, or frame → which of "x", "y", "z", "roll", "pitch"
            and "yaw" are unknown, as in {"CameraTop": ["roll", "pitch", "yaw"]}.
        start: name → first estimate of an unknown pose, shape (4, 4); by default from the observations themselves.
        prior: "typical" for the prior standard deviations s in `PRIORS`, those of a NAO, and none for other numbers;
            "none" for no priors; or your own: joint → one number, frame → (x, y, z, roll, pitch, yaw) [rad, m], with
            typical ones for joints and frames not named.
        joint_noise: standard deviation of a turning joint's reported value in each posture [rad]; 0 for exact ones.
        indistinguishable: "hold" numbers that the data do not determine at zero, with a note; or "refuse".
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
        >>> found.held, np.degrees(list(found.standard_deviations.values())).round(2).tolist()
        (('RElbowYaw offset',), [0.14, 1.0])
    """
    need_extra("calibration", "calibration")
    choice(indistinguishable, ("hold", "refuse"), "indistinguishable")
    choice(loss, ("huber", "linear"), "loss")
    problem = Problem(robot, observations, joints, frames, {} if start is None else start, prior, joint_noise)
    if outside := problem.outside():
        raise BadArgument(outside + likely_mistake(problem))
    x, free, notes = np.zeros(problem.size), np.ones(problem.size, dtype=bool), list[str]()
    initial = problem.misfits(x)
    if any((residuals == BEHIND).any() for residuals in initial):
        text = "at the start, points seen are behind the camera or beyond its lens; check them, or give start=…"
        raise BadArgument(text + likely_mistake(problem))
    for _ in range(_MOST_PASSES):
        problem.take_readings(x)
        while True:
            x = problem.solved(x, free, loss)
            group = problem.undetermined(x, free)
            if group is None:
                break
            text = told(problem, *group)
            if indistinguishable == "refuse":
                raise BadArgument(f"{text}; observe more, or calibrate fewer")
            free[group[0]], x[group[0]] = False, 0.0
            notes.append(text)
        seen = problem.misfits(x)
        outliers, items = problem.outliers(seen)
        text = f"{len(outliers)} of {items} observed items are beyond their noise: {'; '.join(map(str, outliers[:3]))}"
        if len(outliers) > _MOST_OUTLIERS * items:
            raise BadArgument(f"the observations contradict each other: {text}{likely_mistake(problem) or _WRONG}")
        if loss == "linear" or not problem.leave_out(seen):
            break
    if outliers:
        if len(outliers) > _MANY_OUTLIERS * items and (mistake := likely_mistake(problem)):
            raise BadArgument(text + mistake)
        notes.append(text)
    unknowns, stated = problem.unknowns, problem.unknowns.stated
    ratio, of_readings = problem.noise_ratios(x, int(free[: unknowns.nuisances].sum()))
    if of_readings is not None:
        text = f"errors of the joint values are {of_readings:.2g} times as large as joint_noise explains"
        if mistake := likely_mistake(problem, of_readings=True):
            raise BadArgument(text + mistake)
        notes.append(f"{text}: is a board, a posture or a size wrong?")
    if unlikely := problem.unlikely(x):
        raise BadArgument(unlikely + (likely_mistake(problem) or _CAUSES))
    if ratio is not None:
        notes.append(
            f"residuals are {ratio:.2g} times as large as the stated noise explains; the standard deviations hold for "
            "the stated noise alone"
        )
    state, covariance = unknowns.at(x), problem.covariance(x, free, loss)
    named = unknowns.at(np.where(np.arange(problem.size) < unknowns.offsets, x, 0.0))
    loose, more = problem.loose(covariance)
    offsets = {name: float(x[i]) for i, name in enumerate(unknowns.joints)}
    followers = {name: m.multiplier * offsets[m.joint] for name, m in robot.mimics.items() if m.joint in offsets}
    return Calibration(
        robot=robot,
        joints=offsets | followers,
        frames={name: tuple(named.six(unknowns.frames[name]).tolist()) for name in unknowns.named},
        cameras={name: state.lens(camera) for name, camera in problem.nominal.items()},
        clocks={name: float(x[place]) for name, place in unknowns.clocks.items()},
        poses={name: state.pose(name).T for name in unknowns.poses},
        labels=tuple(problem.labels[i] for i in stated),
        units=tuple(unknowns.units[i] for i in stated),
        values=x[stated],
        prior_deviations=unknowns.prior[stated],
        covariance=covariance[np.ix_(stated, stated)],
        held=(*np.array(problem.labels)[~free].tolist(), *loose),
        notes=(*notes, *more),
        residuals=tuple(seen),
        initial_residuals=tuple(initial),
        outliers=tuple(outliers),
        _problem=problem,
        _x=x,
        _covariance=problem.covariance(x, np.ones(problem.size, dtype=bool), loss),
    )


@one_line_repr
@dataclass(frozen=True)
class NextPosture:
    """The posture whose observation would shrink the uncertainty of the offsets most.

    Attributes:
        q: the configuration, shape (nq,).
        gain: by how much the logarithm of the volume of the offsets' uncertainty shrinks, ½ log det Σ/Σ′, of each
            candidate, shape (candidates,).
        index: which candidate q is.
        standard_deviations: of the offsets after observing it, by label.
    """

    q: Floats
    gain: Floats
    index: int
    standard_deviations: dict[str, float]


def next_posture(
    calibration: Calibration,
    candidates: ArrayLike | None = None,
    *,
    joints: Iterable[str] | None = None,
    count: int = 500,
    rng: np.random.Generator | int | None = None,
) -> NextPosture:
    """Return the posture whose observation would shrink the uncertainty of the offsets most (D-optimality).

    Lenses and clocks that are estimated count as offsets, and so do those that the data did not determine.
    In every candidate posture, the items of each observation so far would be seen again with the same noise, as far as
    the camera has them in its image; other bodies may hide them. The covariance Σ of all unknowns becomes
    Σ′ = (Σ⁻¹ + Jᵀ R⁻¹ J)⁻¹ with the Jacobian J of what would be seen, and R its noise and that of the joint values. The
    gain is ½ log det Σ/Σ′ of the offsets.

    Args:
        calibration: the result so far.
        candidates: configurations, shape (m, nq); None for random ones inside the limits.
        joints: which joints are random; the others stay as in the first posture observed. None for those that differed
            between the observed postures.
        count: how many random candidates.
        rng: a generator, or a seed for one.

    Raises:
        BadArgument: no candidate shows anything; no joint moved so far, and none is named; candidates of `Contacts` are
            not given: random postures do not stand.

    Examples:
        >>> nao = nk.load_nao()
        >>> q = nao.random(rng=0, n=5)
        >>> seen = nk.calibration.Poses(q, "LArm", nao.fk(q, "LArm"))
        >>> found = nk.calibration.calibrate(nao, [seen], joints=["LShoulderRoll", "LElbowRoll"])
        >>> best = nk.calibration.next_posture(found, rng=0)
        >>> best.gain.shape, bool(best.gain[best.index] == best.gain.max())
        ((500,), True)
    """
    problem, robot = calibration._problem, calibration.robot
    offsets = problem.unknowns.stated
    if candidates is None:
        if any(one.kind == "contacts" for one in problem.observations):
            raise BadArgument("random postures do not stand on both soles: give candidates")
        q = _random(calibration, joints, whole_number(count, "count", 1, _MOST_RANDOM), rng)
    else:
        q = robot.checked(candidates).reshape(-1, robot.nq)
        if not len(q):
            raise BadArgument("candidates must have at least one configuration")
    state = problem.unknowns.at(calibration._x)
    rows, moved = [], []
    by_readings = problem.reading_jacobians(calibration._x, [q] * len(problem.observations), True)
    for one, part in zip(problem.observations, by_readings, strict=True):
        seen = one.measure(state, q, True)
        J = np.nan_to_num(seen.J)
        if seen.visible is not None:
            J[~seen.visible] = part[~seen.visible] = 0.0
        rows.append(J.reshape(len(q), -1, problem.size))
        moved.append(part.reshape(len(q), -1, part.shape[-1]))
    J, E = np.concatenate(rows, axis=1), np.concatenate(moved, axis=1)
    if not J[..., : problem.unknowns.nuisances].any():
        raise BadArgument("no candidate shows any of what was observed; try more, or other joints")
    # With errors of readings, E, the residuals have the covariance 1 + E Eᵀ, whose inverse is 1 − E (1 + Eᵀ E)⁻¹ Eᵀ.
    # With Σ = L Lᵀ, Σ′ = L (1 + Lᵀ Jᵀ (1 + E Eᵀ)⁻¹ J L)⁻¹ Lᵀ.
    values, vectors = np.linalg.eigh(calibration._covariance)
    L = vectors * np.sqrt(np.maximum(values, 0.0))
    JL, Et = J @ L, np.swapaxes(E, -1, -2)
    JL_weighed = JL - E @ np.linalg.solve(np.eye(E.shape[-1]) + Et @ E, Et @ JL)
    M = np.eye(problem.size) + np.swapaxes(JL, -1, -2) @ JL_weighed
    after = L[offsets] @ np.linalg.solve(
        M, np.broadcast_to(L[offsets].T, (len(q), problem.size, len(calibration.labels)))
    )
    now = np.linalg.slogdet(calibration._covariance[np.ix_(offsets, offsets)])[1]
    gain = 0.5 * (now - np.linalg.slogdet(after)[1])
    if gain.max() < _LEAST_GAIN:
        raise BadArgument("; ".join(("no candidate tells more about the offsets", *calibration.notes)))
    best = int(gain.argmax())
    deviations = np.sqrt(np.diagonal(after[best])).tolist()
    return NextPosture(q[best], gain, best, dict(zip(calibration.labels, deviations, strict=True)))


def _random(calibration: Calibration, joints: Iterable[str] | None, count: int, rng: Any) -> Floats:
    robot = calibration.robot
    observed = np.concatenate([one.q for one in calibration._problem.observations])
    first = robot.nq_base
    if joints is None:
        places = first + np.flatnonzero(np.ptp(observed[:, first:], axis=0) > 0.0)
        if not len(places):
            raise BadArgument("no joint differed between the observed postures: name joints=…, or give candidates")
    else:
        chosen = (choice(name, robot.joint_names, "joint") for name in names_of(joints, "joints"))
        places = first + np.array([robot.joint_names.index(name) for name in chosen], dtype=int)
    q = np.repeat(observed[:1], count, axis=0)
    q[:, places] = robot.random(rng, count)[:, places]
    return q


# --- Usual mistakes in pixels of known points: another order of the corners, another lens, a wrong size.

# A mistake is named if this quantile of the residuals is without it below this part of the one with it, and of σ.
_QUANTILE, _BETTER, _GOOD = 0.85, 0.25, 5.0
# The score of observations that no calibration explains.
_HOPELESS = 1e12
# Units that are taken for metres, and their size.
_UNITS = {"mm": 1e-3, "cm": 1e-2}
# Sizes of images, as multiples of the camera's, in which pixels are found by mistake.
_RESOLUTIONS = {"1/4 of": 0.25, "1/2 of": 0.5, "2 times": 2.0, "4 times": 4.0}
# Sizes of squares are seldom wrong by more; most sizes that are tried.
_LARGEST_RATIO, _MOST_SIZES = 2.0, 20
# By how much the right size reduces the sum of squares.
_LESS = 50.0
# Steps of a search, which needs fewer if the observations agree.
_STEPS = 25


def likely_mistake(problem: Problem, of_readings: bool = False) -> str:
    """Return which usual mistake explains bad residuals of `Pixels`, to end a message; "" if none does.

    Only a wrong size of the points shows in errors of readings alone.
    """
    from scipy.optimize import minimize_scalar

    given = [one.given for one in problem.observations]
    if not any(isinstance(one, Pixels) for one in given):
        return ""

    def score(changed: Sequence[AnyObservation]) -> float:
        with suppress(NaoKinError), warnings.catch_warnings():
            warnings.simplefilter("ignore", DegreesWarning)
            return _scores(problem.again(changed))[of_readings]
        return _HOPELESS

    def stretched(power: float) -> float:  # from the first point
        ratio = _LARGEST_RATIO**power
        return score(_changed(given, lambda one: _scaled("points", ratio, np.asarray(one.points)[0], one)))

    now = score(given)
    limit = now - _LESS if of_readings else min(_GOOD, _BETTER * now)
    if not of_readings:
        *tried, lens = [(score(changed), what) for what, changed in _changes(problem, given)]
        for best, what in (min(tried), lens):
            if best < limit:
                return f"; they agree if {what}"
    options = {"maxiter": _MOST_SIZES, "xatol": 1e-3}
    found = minimize_scalar(stretched, bounds=(-1.0, 1.0), method="bounded", options=options)
    if not found.fun < limit:
        return ""
    ratio = _LARGEST_RATIO**found.x
    return f"; they agree if the points are {ratio:.3g} times as far apart (is the size of a square right?)"


def _changes(problem: Problem, given: Sequence[AnyObservation]) -> Iterator[tuple[str, list[AnyObservation]]]:
    """Yield each mistake in words, and the observations without it."""
    state = problem.unknowns.at(np.zeros(problem.size))
    turned, named = list(given), list[str]()
    for number, one in enumerate(problem.observations):
        if isinstance(one.given, Pixels):
            predicted = one.measure(state, one.q).residuals
            off, back = (np.linalg.norm(seen - predicted, axis=-1) for seen in (one.measured, one.measured[:, ::-1]))
            reverse = np.nansum(back, axis=-1) < np.nansum(off, axis=-1)
            pixels = np.array(one.given.pixels, dtype=np.float64)
            rows = pixels.reshape(-1, *pixels.shape[-2:])
            rows[reverse] = rows[reverse, ::-1]
            turned[number] = replace(one.given, pixels=pixels)
            if reverse.any():
                where = "" if reverse.all() else f"posture {listed([*map(str, np.flatnonzero(reverse))])} of "
                named.append(f"{where}observation {number}")
    if named:
        yield f"the points are in reverse order in {'; '.join(named)}", turned
    changes: dict[str, Callable[[Pixels], dict[str, Any]]] = {
        "joint values are in degrees, not in radians": lambda one: {"q": np.radians(one.q), "moving": None}
    }
    for unit, metres in _UNITS.items():
        changes[f"the points are in {unit}, not in metres"] = partial(_scaled, "points", metres, 0.0)
    for size, ratio in _RESOLUTIONS.items():
        changes[f"the pixels are in images of {size} the size of the camera's"] = partial(
            _scaled, "pixels", 1.0 / ratio, -0.5
        )
    # A free lens bends to much else: it is the mistake if no other explains the residuals.
    changes["the lens is not the one given"] = lambda one: {"camera": replace(one.camera, nominal=True)}
    for what, change in changes.items():
        yield what, _changed(given, change)


def _changed(given: Sequence[AnyObservation], change: Callable[[Pixels], dict[str, Any]]) -> list[AnyObservation]:
    """Return observations, of which those of pixels have other attributes."""
    return [replace(one, **change(one)) if isinstance(one, Pixels) else one for one in given]


def _scaled(name: str, scale: float, centre: Floats | float, one: Pixels) -> dict[str, Any]:
    """Return points or pixels that are so many times as far from a centre."""
    return {name: centre + scale * (np.asarray(getattr(one, name)) - centre)}


def _scores(problem: Problem) -> tuple[float, float]:
    """Return a high quantile of the residuals of pixels after a calibration, in σ, and the sum of squares of all.

    They are hopeless if the search cannot start, or ends beyond the priors.
    """
    x = np.zeros(problem.size)
    if any((part == BEHIND).any() for part in problem.misfits(x)):
        return _HOPELESS, _HOPELESS
    problem.take_readings(x)
    x = problem.solved(x, np.ones(problem.size, dtype=bool), "linear", _STEPS)
    if problem.unlikely(x):
        return _HOPELESS, _HOPELESS
    seen = zip(problem.misfits(x), problem.observations, strict=True)
    pixels = np.concatenate([np.linalg.norm(part, axis=-1) for part, one in seen if isinstance(one.given, Pixels)])
    return float(np.quantile(pixels, _QUANTILE)), float(np.square(problem.residuals(x)).sum())
