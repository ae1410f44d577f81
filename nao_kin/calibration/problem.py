"""The least squares of a calibration: residuals, what the data determine, outliers, and first estimates of poses."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, check_tolerance, choice, join_poses, rigid_inverse, shaped
from nao_kin._core.text import listed, quoted
from nao_kin.calibration.observations import PLACE, Checked, Contacts, Lines, Pixels, Poses, camera_at, errors_of
from nao_kin.calibration.unknowns import COORDINATES, FIXED, PLANAR, State, Unknowns
from nao_kin.errors import BadArgument, DegreesWarning
from nao_kin.robot import RobotModel, serial_chain
from nao_kin.rotations import exp, mean_rotation, nearest_rotation, rot_z
from nao_kin.screws import nearest_pose, pose
from nao_kin.world import outside_image

AnyObservation = Pixels | Lines | Poses | Contacts
# Residuals beyond this many standard deviations count with their magnitude, not with its square.
_HUBER = 3.0
# An item is an outlier if noise alone makes its residual so large with a smaller probability than this.
_RARE = 1e-6
# The data determine an offset if its standard deviation after the calibration is below this share of the one before.
_DETERMINED = 0.8
# Numbers beyond so many of their prior standard deviations are refused.
_UNLIKELY = 4.0
# Unknowns with a smaller correlation to an undetermined offset are not named together with it.
_CORRELATED = 0.3
# Numbers without a prior have one that is wider than any in practice by this factor.
_WIDER = 1e3
# Pixels outside of their image by more than so many standard deviations are in another one.
_OUTSIDE = 10.0


@dataclass(frozen=True)
class Outlier:
    """An observed item whose residual is larger than its noise explains.

    Attributes:
        observation: the number of the observation in the list given.
        kind: "pixels", "lines", "poses" or "contacts".
        item: the posture, and for pixels the point, as in "posture 3, point 2".
        sigmas: length of the residual in standard deviations of its noise.
    """

    observation: int
    kind: str
    item: str
    sigmas: float

    def __str__(self) -> str:
        return f"observation {self.observation} ({self.kind}), {self.item}: {self.sigmas:.1f} σ"


class Problem:
    """Checked observations and the unknowns that explain them."""

    def __init__(
        self,
        robot: RobotModel,
        observations: Sequence[AnyObservation],
        joints: Iterable[str],
        frames: Mapping[str, Iterable[str]] | Iterable[str],
        start: Mapping[str, ArrayLike],
        prior: Mapping[str, ArrayLike] | Literal["typical", "none"] = "typical",
        joint_noise: float = 0.0,
    ) -> None:
        if isinstance(observations, str):  # type: ignore[unreachable]
            raise BadArgument("observations are expected, not a file; read_observations(robot, path) reads them")
        self.observations: list[Checked] = []
        for number, one in enumerate(observations):
            with errors_of(f"observation {number}"):
                self.observations.append(one._checked(robot))
                robot.frame_ids([end for end in self.observations[-1].ends if end is not None])
        names = dict[str, str]()
        for name, meaning in (named for one in self.observations for named in one.poses):
            if names.setdefault(name, meaning) != meaning:
                raise BadArgument(f"{quoted(name)} names a {names[name]} and a {meaning}: give them different names")
        coordinates = {name: PLANAR if names[name].startswith(PLACE) else COORDINATES for name in names}
        paths = [serial_chain(robot, *(end or robot.tree.root for end in one.ends)) for one in self.observations]
        zeros = dict.fromkeys(name for path in paths for name in path.coordinates if robot.unit(name) == "rad")
        cameras = [one.given.camera for one in self.observations if isinstance(one.given, Pixels | Lines)]
        self.nominal = {robot.body_frame(camera.frame): camera for camera in cameras if camera.nominal}
        bodies = dict.fromkeys(robot.body_frame(camera.frame) for camera in cameras)
        mounted = [body for body in bodies if body in robot.semantics.cameras]
        clocks = dict.fromkeys(one.motion.camera for one in self.observations if one.motion is not None)
        more: dict[str, Any] = {"zeros": zeros, "cameras": mounted, "lenses": self.nominal, "clocks": clocks}
        self.unknowns = unknowns = Unknowns(robot, joints, frames, coordinates, prior, **more)
        self.labels, self.size = unknowns.labels, len(unknowns.labels)
        if not unknowns.nuisances:
            raise BadArgument("nothing to calibrate: name joints or frames, or unknown poses in the observations")
        known = np.isfinite(unknowns.prior)
        self._deviations = np.where(known, unknowns.prior, _WIDER * unknowns.scales)
        self._limits = np.where(known, _DETERMINED * unknowns.prior, unknowns.scales)
        self._limits[unknowns.nuisances :] = np.inf  # they keep their prior
        self._sizes = [int(one.mask.sum()) * one.measured.shape[-1] for one in self.observations]
        count = sum(self._sizes)
        needed = max(unknowns.nuisances - unknowns.offsets, 1)
        if count < needed:
            raise BadArgument(f"too few observations: {count} numbers for {needed} of unknown poses")
        for name in start:
            choice(name, names, "board, marker or world")
        starts = {name: nearest_pose(shaped(T, (4, 4), f"start of {name}")) for name, T in start.items()}
        nominal = Unknowns(robot, (), (), {}).at(np.zeros(0))
        # Observations that share a pose with a richer one are started by it.
        for rich in sorted(self.observations, key=lambda one: -int(one.mask.sum())):
            add_starts(nominal, rich, starts)
        starts |= place_starts(nominal, self.observations, starts)
        for name, block in unknowns.poses.items():
            unknowns.poses[name] = replace(block, start=starts[name])
        self._kept = np.ones(count)
        self._last: tuple[bytes, tuple[Floats, Floats]] | None = None
        check_tolerance(joint_noise, "joint_noise")
        self._joint_noise = joint_noise
        self._readings: Readings | None = None
        self._given: Any = {"joints": unknowns.joints, "frames": unknowns.named, "start": start, "prior": prior}

    def again(self, observations: Sequence[AnyObservation]) -> Problem:
        """Return the same problem with other observations."""
        return Problem(self.unknowns.robot, observations, joint_noise=self._joint_noise, **self._given)

    def _seen(self, x: Floats) -> tuple[Floats, Floats]:
        """Return the residuals of everything that was seen, shape (m,), and their derivatives, shape (m, unknowns)."""
        key = x.tobytes()  # residuals and derivatives are asked for one after the other
        if self._last is None or self._last[0] != key:
            state = self.unknowns.at(x)
            parts = [one.at(state) for one in self.observations]
            J = np.concatenate([part.J.reshape(-1, self.size) for part in parts])
            self._last = key, (np.concatenate([part.residuals.ravel() for part in parts]), J)
        return self._last[1]

    def outside(self) -> str:
        """Return a message on pixels outside of their image by more than noise explains; "" if there are none."""
        for number, one in enumerate(self.observations):
            if isinstance(one.given, Pixels | Lines):
                lens, pixels = one.given.camera, np.asarray(one.given.pixels, dtype=np.float64).reshape(-1, 2)
                last = np.array([lens.width, lens.height]) - 0.5
                beyond = np.maximum(-0.5 - pixels, pixels - last).max(axis=-1) > _OUTSIDE * one.given.noise
                if beyond.any():
                    text = outside_image(self.unknowns.robot, lens, pixels[beyond])
                    return f"observation {number}: {beyond.sum()} pixels are {text}"
        return ""

    def take_readings(self, x: Floats) -> None:
        """Take errors of the reported joint values out of the residuals from now on, as their effects are at x."""
        if not self._joint_noise > 0.0:
            return
        by_readings = self.reading_jacobians(x, [one.q for one in self.observations])
        pairs = list(zip(self.observations, by_readings, strict=True))
        postures = [np.repeat(one.q[np.nonzero(one.mask)[0]], one.measured.shape[-1], axis=0) for one, _ in pairs]
        rows = [J[one.mask].reshape(-1, J.shape[-1]) for one, J in pairs]
        self._readings = Readings(np.concatenate(postures), np.concatenate(rows), self._kept)

    def reading_jacobians(self, x: Floats, qs: Sequence[Floats], trial: bool = False) -> list[Floats]:
        """Return the derivatives of each observation's predictions at configurations by the readings' noise."""
        robot, state = self.unknowns.robot, self.unknowns.at(x)
        turning = [name for name in robot.joint_names if robot.unit(name) == "rad" and name not in robot.mimics]
        readings = Unknowns(robot, turning, (), {})
        for name in self.unknowns.poses:
            readings.poses[name] = replace(FIXED, start=state.pose(name).T)
        at = readings.at(np.zeros(len(turning)))
        return [
            np.nan_to_num(one.measure(at, self.unknowns.reported(x, q), trial).J) * self._joint_noise
            for one, q in zip(self.observations, qs, strict=True)
        ]

    def _counted(self, rows: Floats) -> Floats:
        """Return rows of residuals or derivatives, zero for items left out, and then those of readings."""
        kept = rows * (self._kept if rows.ndim == 1 else self._kept[:, None])
        return np.asarray(kept if self._readings is None else self._readings.taken_out(kept))

    def residuals(self, x: Floats) -> Floats:
        """Return all residuals, zero for items left out, and then the errors of readings over their noise."""
        return self._counted(self._seen(x)[0])

    def jacobian(self, x: Floats) -> Floats:
        """Return the derivatives of all residuals, shape (m, unknowns)."""
        return self._counted(self._seen(x)[1])

    def misfits(self, x: Floats) -> list[Floats]:
        """Return the residuals of each observation, shape (items seen, numbers), without the effect of the readings."""
        r = self._seen(x)[0]
        parts = np.split(r if self._readings is None else self._readings.misfits(r), np.cumsum(self._sizes)[:-1])
        return [part.reshape(-1, one.measured.shape[-1]) for part, one in zip(parts, self.observations, strict=True)]

    def solved(self, x: Floats, free: NDArray[np.bool_], loss: str, steps: int | None = None) -> Floats:
        """Return the unknowns of least loss, after at most so many `steps`; those that are not free stay."""
        from scipy.optimize import least_squares

        if not free.any():
            return x
        prior, exact = np.diag(1.0 / self._deviations[free]), dict.fromkeys(("xtol", "ftol", "gtol"), 1e-12)
        options: dict[str, Any] = {"x_scale": self.unknowns.scales[free], "f_scale": _HUBER, "max_nfev": steps, **exact}

        def whole(part: Floats) -> Floats:
            found: Floats = x.copy()
            found[free] = part
            return found

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DegreesWarning)  # of steps that are taken back
            for stage in dict.fromkeys(("linear", loss)):  # squares first: they lead there from far away
                found = least_squares(
                    lambda part: np.concatenate((self.residuals(whole(part)), prior @ part)),
                    x[free],
                    lambda part: np.concatenate((self.jacobian(whole(part))[:, free], prior)),
                    loss=stage,
                    **options,
                )
                x = whole(found.x)
        return x

    def covariance(self, x: Floats, free: NDArray[np.bool_], loss: str) -> Floats:
        """Return the covariance of the errors of the unknowns, those that are not free at zero."""
        J = self.jacobian(x)
        if loss != "linear":
            J = J[np.abs(self.residuals(x)) <= _HUBER]
        part = _posterior(J[:, free], self._deviations[free])
        # The errors of the free ones change with the errors of the others by −S.
        S = part @ J[:, free].T @ J[:, ~free]
        others = np.diag(np.minimum(self.unknowns.prior, self.unknowns.scales)[~free] ** 2)
        by_others = np.zeros((self.size, len(others)))
        by_others[free], by_others[~free] = -S, np.eye(len(others))
        found = by_others @ others @ by_others.T
        found[np.ix_(free, free)] += part
        return np.asarray(found)

    def undetermined(self, x: Floats, free: NDArray[np.bool_]) -> tuple[int, list[int]] | None:
        """Return the free number that the data determine least, and those correlated with it; None if they do all.

        Numbers of unknown poses follow when all offsets are determined: if they are still free by more than any offset.
        """
        places = np.flatnonzero(free)
        if not len(places):
            return None
        covariance = _posterior(self.jacobian(x)[:, free], self._deviations[free])
        deviations = np.sqrt(np.diag(covariance))
        is_offset = places < self.unknowns.offsets
        rest = deviations / self._limits[free]
        for kind in (is_offset, ~is_offset):
            if (kind & (rest > 1.0)).any():
                worst = int(np.where(kind, rest, 0.0).argmax())
                return int(places[worst]), places[_correlated(covariance, worst)].tolist()
        return None

    def unlikely(self, x: Floats) -> str:
        """Return a message on the number that is farthest beyond its prior; "" if all are within it."""
        ratios = np.abs(x) / self.unknowns.prior
        worst = int(ratios.argmax())
        if not ratios[worst] > _UNLIKELY:
            return ""
        size, prior = (size_of(y[worst], self.unknowns.units[worst]) for y in (x, self.unknowns.prior))
        return f"{self.labels[worst]} would be {size}, {ratios[worst]:.1f} times its prior standard deviation, {prior}"

    def loose(self, covariance: Floats) -> tuple[list[str], list[str]]:
        """Return the labels of numbers of lenses and clocks that the data do not determine, and notes on nuisances."""
        unknowns, deviations = self.unknowns, np.sqrt(np.diag(covariance))
        free = deviations > _DETERMINED * unknowns.prior
        notes = [
            told(self, places[0], np.flatnonzero(_correlated(covariance, places[0])).tolist())
            for places in unknowns.lenses.values()
            if free[places[0]]
        ]
        others = [
            self.labels[i]
            for i in range(unknowns.nuisances, self.size)
            if i not in unknowns.stated and _correlated(covariance, i)[: unknowns.offsets].any()
        ]
        if others:
            notes.append(
                f"{listed(others)} are unknown too, and in the standard deviations; name them in joints and frames to "
                "have them in the result"
            )
        return [self.labels[i] for i in unknowns.stated[unknowns.offsets :] if free[i]], notes

    def leave_out(self, seen: list[Floats]) -> bool:
        """Leave out just the items that are beyond their noise at these residuals; return whether that is a change."""
        before = self._kept
        self._kept = np.concatenate([np.repeat(~_beyond(part), part.shape[1]) for part in seen]).astype(float)
        return not np.array_equal(before, self._kept)

    def outliers(self, seen: list[Floats]) -> tuple[list[Outlier], int]:
        """Return the items beyond their noise, the largest first, and the number of all items."""
        found = []
        for number, (one, residuals) in enumerate(zip(self.observations, seen, strict=True)):
            sizes = np.linalg.norm(residuals, axis=1)
            for row in np.flatnonzero(_beyond(residuals)):
                found.append(Outlier(number, one.kind, one.describe(int(row)), float(sizes[row])))
        return sorted(found, key=lambda outlier: -outlier.sigmas), sum(map(len, seen))

    def noise_ratios(self, x: Floats, unknowns: int) -> tuple[float | None, float | None]:
        """Return the ratios of residuals and of errors of readings to their noise; None where chance explains it."""
        seen = self.misfits(x)
        near = np.concatenate([part[~_beyond(part)].ravel() for part in seen])
        # Errors of readings have a part of the freedom of the residuals, at most their number.
        errors = self.residuals(x)[sum(part.size for part in seen) :]
        return _ratio(near, near.size - unknowns, errors), _ratio(errors, errors.size)


def _beyond(residuals: Floats) -> NDArray[np.bool_]:
    """Return which items, rows of residuals, noise alone does not explain."""
    from scipy.stats import chi2

    return np.asarray((residuals**2).sum(axis=1) > chi2.isf(_RARE, residuals.shape[1]))


def _ratio(residuals: Floats, freedom: int, *more: Floats) -> float | None:
    from scipy.stats import chi2

    total = float(residuals @ residuals) + sum(float(part @ part) for part in more)
    if freedom <= 0 or chi2.sf(total, freedom) > _RARE:
        return None
    return float(np.sqrt(total / freedom))


class Readings:
    """Errors of the reported joint values in each posture, which move all residuals r in it by J d.

    With the most likely errors d = −K r, K = (Jᵀ J + 1)⁻¹ Jᵀ, the residuals are (r + J d, d): the sum of their squares
    is rᵀ (1 + J Jᵀ)⁻¹ r, that of residuals whose covariance is 1 + J Jᵀ.
    """

    def __init__(self, postures: Floats, J: Floats, kept: Floats) -> None:
        from scipy.sparse import coo_array, eye_array
        from scipy.sparse.linalg import splu

        self._group = np.unique(postures, axis=0, return_inverse=True)[1].ravel()
        rows, joints = np.nonzero(J)
        # One column for each joint that matters in a posture.
        moved, columns = np.unique(self._group[rows] * J.shape[1] + joints, return_inverse=True)
        self._owner = moved // J.shape[1]
        self._effects = coo_array((J[rows, joints], (rows, columns)), (len(J), len(moved))).tocsr()
        self._counted = (self._effects * kept[:, None]).T.tocsr()
        self._solve = splu((self._counted @ self._counted.T + eye_array(len(moved))).tocsc()).solve
        self._kept = kept

    def _errors(self, r: Floats) -> Floats:
        return np.asarray(-self._solve(self._counted @ r))

    def taken_out(self, r: Floats) -> Floats:
        """Return residuals of kept items, or derivatives, without the effects of the errors, and then the errors."""
        d = self._errors(r)
        return np.concatenate((r + self._counted.T @ d, d))

    def misfits(self, r: Floats) -> Floats:
        """Return the residuals of all items, without the effects of the errors that the kept ones show.

        Errors that are improbable in a posture are not taken out of its residuals.
        """
        from scipy.stats import chi2

        d = self._errors(r)
        counts = np.bincount(self._owner, minlength=int(self._group.max()) + 1)
        sizes = np.bincount(self._owner, d * d, len(counts))
        return np.asarray(r + (sizes <= chi2.isf(_RARE, np.maximum(counts, 1)))[self._group] * (self._effects @ d))


def _posterior(J: Floats, deviations: Floats) -> Floats:
    """Return (Jᵀ J + diag(1/s²))⁻¹ for prior standard deviations s, by singular values."""
    _, sizes, V = np.linalg.svd(np.concatenate((J * deviations, np.eye(len(deviations)))), full_matrices=False)
    root = deviations[:, None] * V.T / sizes
    return np.asarray(root @ root.T)


def _correlated(covariance: Floats, place: int) -> NDArray[np.bool_]:
    """Return which numbers are correlated with one of them, itself too."""
    deviations = np.sqrt(np.diag(covariance))
    return np.asarray(np.abs(covariance[place]) > _CORRELATED * deviations * deviations[place])


def size_of(value: float, unit: str) -> str:
    """Return a number for a message, angles in degrees."""
    return f"{np.degrees(value):.2g}°" if unit == "rad" else f"{value:.2g}" + f" {unit}" * (unit != "1")


def told(problem: Problem, held: int, members: Sequence[int]) -> str:
    """Return a note on an undetermined number and on those that trade with it, with what to observe."""
    unknowns, label, offsets = problem.unknowns, problem.labels[held], problem.unknowns.offsets
    left = f"{label} is held at 0" if held < unknowns.nuisances else f"{label} is not determined"
    if held < offsets or held >= unknowns.nuisances:
        left += f" ± {size_of(min(unknowns.prior[held], unknowns.scales[held]), unknowns.units[held])}"
    if len(members) == 1:
        return f"the data say nothing about {label}: {left}; observe what it moves"
    advice = "observe postures and points in which these differ"
    if held >= unknowns.nuisances:
        advice = "give the measured lens, or observe a board at a measured place, from several distances"
    elif any(offsets <= i < unknowns.nuisances for i in members):
        advice = "observe points at measured places, or marks on the robot itself"
    return f"the data cannot tell apart {listed([problem.labels[i] for i in members])}: {left}; {advice}"


# --- First estimates of unknown poses, from the nominal robot.

# Postures from which a board's pose is estimated; the best estimate counts.
_TRIED = 10
# Ratio of the least to the greatest extent of points that lie in a plane, and of those on a line.
_FLAT = 1e-6


def add_starts(state: State, observation: Checked, starts: dict[str, Floats]) -> None:
    """Estimate the poses that an observation needs and that have no start yet."""
    if all(name in starts or meaning.startswith(PLACE) for name, meaning in observation.poses):
        return
    given = observation.given
    if isinstance(given, Pixels):
        starts[str(given.board)] = _board(state, observation, given)
    elif isinstance(given, Poses):
        frames = state.frame(observation.q, given.reference).inverse() @ state.frame(observation.q, given.frame)
        starts |= _markers(frames.T, np.reshape(given.poses, (-1, 4, 4)), given, starts)


def _board(state: State, observation: Checked, given: Pixels) -> Floats:
    """Return the pose of a board in its frame: of those estimated from single postures, the one that suits all best."""
    points, mask = np.reshape(given.points, (-1, 3)), observation.mask
    pixels = observation.measured * given.noise
    T_frame_cameras = (
        state.frame(observation.q, given.frame).inverse() @ camera_at(state, observation.q, given.camera)
    ).T
    found = list[tuple[float, Floats]]()
    for n in np.argsort(-mask.sum(axis=1), kind="stable")[:_TRIED]:
        rays = np.asarray(given.camera.ray(pixels[n]))
        usable = np.isfinite(rays).all(axis=-1)
        T_camera_board = _pose_of_points(points[usable], rays[usable])
        if T_camera_board is None:
            continue
        T_frame_board = T_frame_cameras[n] @ T_camera_board
        T = rigid_inverse(T_frame_cameras) @ T_frame_board
        seen = T[:, None, :3, :3] @ points[:, :, None]
        error = np.abs(given.camera.project(seen[..., 0] + T[:, None, :3, 3]) - pixels)[mask]
        found.append((float(np.median(np.nan_to_num(error, nan=np.inf))), T_frame_board))
    if not found:
        raise BadArgument(
            f"the pose of board {given.board} needs a posture that sees four of its points in a plane, or six; "
            f"or give start={{{given.board!r}: pose}}"
        )
    return min(found, key=lambda pair: pair[0])[1]


def _pose_of_points(points: Floats, rays: Floats) -> Floats | None:
    """Return the pose of a body in the camera's frame from the rays to its points; None for too few of them.

    The direct linear transform: ray × (R X + t) = 0 is linear in the columns of R that the points span, and in t. Its
    solution is fixed up to a factor, which the lengths of the columns and the side of the camera give.
    Source: Hartley and Zisserman, Multiple View Geometry, 7.1.
    """
    if len(points) < 4:
        return None
    centre = points.mean(axis=0)
    _, spread, axes = np.linalg.svd(points - centre)
    rank = int((spread > _FLAT * spread.max()).sum())
    if rank < 2 or (rank == 3 and len(points) < 6):
        return None
    B = axes[:rank].T
    size = spread[0] / np.sqrt(len(points))
    local = np.concatenate(((points - centre) @ B / size, np.ones((len(points), 1))), axis=1)
    x, y, z = rays.T
    o = np.zeros_like(x)
    skew = np.array([[o, -z, y], [z, o, -x], [-y, x, o]]).transpose(2, 0, 1)
    rows = np.einsum("nij,nk->nijk", skew, local).reshape(3 * len(points), -1)
    M = np.linalg.svd(rows)[2][-1].reshape(3, rank + 1)
    M /= (
        np.cbrt(np.linalg.norm(M[:, :rank], axis=0).prod())
        if rank == 3
        else np.sqrt(np.linalg.norm(M[:, :2], axis=0).prod())
    )
    M *= np.sign((rays * (local @ M.T)).sum())
    columns = M[:, :rank] if rank == 3 else np.column_stack((M[:, :2], np.cross(M[:, 0], M[:, 1])))
    full = B if rank == 3 else np.column_stack((B, np.cross(B[:, 0], B[:, 1])))
    try:
        R = nearest_rotation(columns @ full.T)
    except BadArgument:  # the rays are in a plane, or nearly one ray
        return None
    return join_poses(R, size * M[:, rank] - R @ centre)


def _markers(frames: Floats, poses: Floats, given: Poses, starts: dict[str, Floats]) -> dict[str, Floats]:
    """Return the unknown of T_world_marker = T_world_reference · T_reference_frame · T_frame_marker."""
    world = np.eye(4) if given.world is None else starts.get(given.world)
    marker = np.eye(4) if given.marker is None else starts.get(given.marker)
    if world is None and marker is not None:
        return {str(given.world): _mean(poses @ rigid_inverse(frames @ marker))}
    if world is None:
        world = _world(frames, poses)
    marker = _mean(rigid_inverse(world @ frames) @ poses)
    return {name: T for name, T in ((given.world, world), (given.marker, marker)) if name is not None}


def _world(frames: Floats, poses: Floats) -> Floats:
    """Return T_world_reference if both ends are unknown: P N = W F with N = T_marker_frame is linear in W and N.

    Source: Shah, Solving the robot-world/hand-eye calibration problem using the Kronecker product, 2013.
    """
    R_P, R_F, one = poses[:, :3, :3], frames[:, :3, :3], np.eye(3)
    rows = np.concatenate([np.hstack((np.kron(P, one), -np.kron(one, F.T))) for P, F in zip(R_P, R_F, strict=True)])
    W = np.linalg.svd(rows)[2][-1].reshape(2, 3, 3)[1]
    R_W = nearest_rotation(W * np.sign(np.linalg.det(W)))
    # R_P t_N + t_P = R_W t_F + t_W
    A = np.concatenate([np.hstack((P, -one)) for P in R_P])
    b = (frames[:, :3, 3] @ R_W.T - poses[:, :3, 3]).ravel()
    return join_poses(R_W, np.linalg.lstsq(A, b, rcond=None)[0][3:])


def _mean(T: Floats) -> Floats:
    return join_poses(mean_rotation(T[:, :3, :3]).rotation, T[:, :3, 3].mean(axis=0))


# --- First estimates of places, from the nominal robot.

# Directions from which the search starts, and those of least error that are continued.
_DIRECTIONS, _CONTINUED = 24, 6
# Pixels that show points of the floor farther away do not count [m].
_FAR = 8.0
# Errors of a pixel's direction and of the tilt of the robot that are expected, and the largest tilt [rad]; a robot
# hardly ever stands farther beyond the border of the field, which is so wide [m].
_PIXEL, _TILT, _LARGEST_TILT, _BEYOND, _BORDER = 5e-3, 0.03, 0.12, 0.01, 0.7


def place_starts(state: State, observations: Sequence[Checked], starts: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return the places of the field in a sole that have no start yet, as poses."""
    found = dict[str, Floats]()
    for name in dict.fromkeys(name for one in observations for name, what in one.poses if what.startswith(PLACE)):
        if name not in starts:
            own = [one for one in observations if any(name == known for known, _ in one.poses)]
            shown = [_shown(state, one) for one in own]
            eyes, rays, X, C, L = (np.concatenate(parts) for parts in zip(*shown, strict=True))
            if 2 * np.isfinite(X[:, 0]).sum() + np.isnan(X[:, 0]).sum() < 3:
                raise BadArgument(f"the place {name} needs at least three numbers: two points, or pixels on two lines")
            found[name] = _placed(eyes, rays, X, C, L, np.max([_ends(one) for one in own], axis=0))
    return found


def _shown(state: State, one: Checked) -> tuple[Floats, ...]:
    """Return eyes and rays (m, 3) in the sole, and the point (m, 2), conic and line that each shows."""
    given, q = one.given, one.q
    shape = len(q), one.measured.shape[1]
    T = (state.frame(q, given.frame).inverse() @ camera_at(state, q, given.camera)).T
    d = np.asarray(given.camera.ray(np.reshape(given.pixels, (*shape, 2)))) @ np.swapaxes(T[:, :3, :3], -1, -2)
    e = np.broadcast_to(T[:, None, :3, 3], d.shape)
    with np.errstate(invalid="ignore"):
        near = -_FAR * d[..., 2] > e[..., 2] * np.hypot(d[..., 0], d[..., 1])
    X, C, L = np.full((shape[1], 2), np.nan), np.zeros((shape[1], 3, 3)), np.zeros((shape[1], 3))
    if isinstance(given, Lines):
        C, L = given._curves()
    else:
        X = np.asarray(given.points, dtype=np.float64)[:, :2]
    return e[near], d[near], *(np.broadcast_to(part, (len(q), *part.shape))[near] for part in (X, C, L))


def _ends(one: Checked) -> Floats:
    """Return the largest x and y of a sole that stands on the field or on its border; infinite for marks of others."""
    if not isinstance(one.given, Lines):
        return np.full(2, np.inf)
    field = one.given.own_field
    return 0.5 * np.array([field.length, field.width]) + _BORDER


def _placed(eyes: Floats, rays: Floats, X: Floats, C: Floats, L: Floats, ends: Floats) -> Floats:
    """Return the pose of the field in the sole that fits best to what rays show.

    The robot may be somewhat tilted, and is not beyond the ends (x, y) of the field.
    """
    from scipy.optimize import least_squares

    is_point, is_circle = np.isfinite(X[:, 0]), C[:, 0, 0] != 0.0
    # A pixel on the circle is near its centre; the points of lines are known across them.
    near = np.where(is_point[:, None], X, np.where((is_circle & ~is_point)[:, None], 0.0, np.nan))
    both, across = np.isfinite(near[:, 0]), ~is_point & ~is_circle

    def on_floor(tilt: Floats) -> Floats:
        d = rays @ exp([*tilt, 0.0]).T
        return np.asarray(eyes[:, :2] - (eyes[:, 2] / np.minimum(d[:, 2], -1e-3))[:, None] * d[:, :2])

    def off(place: Floats) -> Floats:
        p = on_floor(place[3:])
        # From a distance on the floor to the angle that the eye sees.
        angles = eyes[:, 2] / (eyes[:, 2] ** 2 + ((p - eyes[:, :2]) ** 2).sum(axis=-1)) / _PIXEL
        f = np.concatenate(((p - place[:2]) @ rot_z(place[2])[:2, :2], np.ones((len(p), 1))), axis=-1)
        c = 2.0 * np.einsum("mij,mj->mi", C, f) + L
        off_line = (f * (c + L)).sum(axis=-1) / 2.0 / np.maximum(np.hypot(c[:, 0], c[:, 1]), 1e-9)
        points = (f[is_point, :2] - X[is_point]) * angles[is_point, None]
        beyond = np.maximum(np.abs(place[:2] @ rot_z(place[2])[:2, :2]) - ends, 0.0) / _BEYOND
        return np.concatenate((points.ravel(), (off_line * angles)[~is_point], place[3:] / _TILT, beyond))

    p, tried = on_floor(np.zeros(2)), []
    for yaw in np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False):
        R = rot_z(yaw)[:2, :2]
        normals = L[across, :2] @ R.T
        rows = np.concatenate((np.tile(np.eye(2), (int(both.sum()), 1)), normals))
        right = (p[across] * normals).sum(axis=-1) + L[across, 2]
        t = np.linalg.lstsq(rows, np.concatenate(((p[both] - near[both] @ R.T).ravel(), right)), rcond=None)[0]
        tried.append(np.array([*t, yaw, 0.0, 0.0]))
    tried.sort(key=lambda place: float(np.abs(off(place)).sum()))
    bound = np.array([np.inf, np.inf, np.inf, _LARGEST_TILT, _LARGEST_TILT])
    searches = (least_squares(off, x, loss="soft_l1", f_scale=3.0, bounds=(-bound, bound)) for x in tried[:_CONTINUED])
    best = min(searches, key=lambda one: float(one.cost))
    return pose(rot_z(best.x[2]), (*best.x[:2], 0.0))
