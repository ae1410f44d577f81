"""What a calibration observes: pixels of known points, measured poses of frames, and soles that stand on one plane.

First estimates of the unknown poses are made from the observations and the nominal robot.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, as_pixels, cross_matrix, join_poses, rigid_inverse, shaped
from nao_kin._core.files import described, read_json, read_text
from nao_kin._core.text import quoted
from nao_kin.calibration.unknowns import Moving, State
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError, UnknownName, WrongShape
from nao_kin.robot import RobotModel, check_robot, pose_of, pose_of_body, rigid_poses
from nao_kin.rotations import log, mean_rotation, nearest_rotation, right_jacobian_inverse
from nao_kin.world import Camera, camera

# Residual, in units of its noise, of a point that is behind the camera during the search.
BEHIND = 1e4


@dataclass(frozen=True)
class Seen:
    """Residuals in units of their noise, shape (n, items, numbers), and their derivatives (…, unknowns)."""

    residuals: Floats
    J: Floats


@dataclass(frozen=True)
class Pixels:
    """Pixels of known points, seen by a camera of the robot.

    The points are fixed to a frame of the robot (its other hand, its feet), to the root, or to a board: an object whose
    unknown pose in that frame is estimated. Residuals are pixels minus `camera.project(points)`, divided by the noise.

    Attributes:
        q: reported configurations, shape (..., nq).
        camera: the camera, `nk.world.camera(robot, "CameraTop")` or one with your own intrinsics.
        pixels: the pixels of all points (u, v), shape (..., k, 2) [pixels]; NaN for a point that is not seen.
        points: the points, shape (k, 3), in the board, or else in the frame [m].
        frame: the frame that carries the points or the board; None for the root: the trunk with a fixed base, the
            world with a floating one.
        board: name of the board; observations with the same name see the same board.
        noise: standard deviation of u and of v [pixels].
    """

    q: ArrayLike
    camera: Camera
    pixels: ArrayLike
    points: ArrayLike
    frame: str | None = None
    board: str | None = None
    noise: float = 0.5

    def _checked(self, robot: RobotModel) -> Checked:
        """Return the checked observation."""
        if not isinstance(self.camera, Camera):
            raise BadArgument(f"camera must be a Camera, as nk.world.camera returns it, got {quoted(self.camera)}")
        q = _configurations(robot, self.q)
        points = as_floats(self.points, (3,), "points")
        if points.ndim != 2:
            raise WrongShape("points", "(k, 3)", points.shape)
        pixels = _one_each(as_pixels(self.pixels), self.q, (len(points), 2), "pixels")
        noise = _noise(self.noise, (), "noise of pixels")
        _known(robot, self.camera.frame, self.frame)

        def measure(state: State, q: Floats, trial: bool = False) -> Seen:
            T_root_points = state.frame(q, self.frame) @ state.pose(self.board)
            place = camera_at(state, q, self.camera).inverse() @ T_root_points
            R, t = place.T[..., None, :3, :3], place.T[..., None, :3, 3]
            seen = (R @ points[..., None])[..., 0] + t
            # A point X of a body with the twist (v; ω) in the body's axes moves by R (v + ω × X).
            moved = R @ (place.J[..., None, :3, :] - cross_matrix(points) @ place.J[..., None, 3:, :])
            return Seen(self.camera.project(seen) / noise, self.camera.pixel_jacobian(seen) @ moved / noise)

        poses = _named((self.board, f"board on {self.frame or 'the root'}"))
        return Checked("pixels", "point", q, measure, pixels / noise, poses, self)


@dataclass(frozen=True)
class Poses:
    """Poses of a frame measured from outside, for example by motion capture.

    T_world_marker = T_world_reference · T_reference_frame(q) · T_frame_marker, of which the first and the last are
    either known or unknown and estimated. Residuals are the translation and the rotation vector of
    T_predicted⁻¹ T_measured, divided by their noise.

    Attributes:
        q: reported configurations, shape (..., nq).
        frame: a frame of the robot.
        poses: the measured T_world_marker, shape (..., 4, 4).
        world: name of the unknown world in which the poses are measured; None if it is the reference frame.
        marker: name of the unknown body of markers on the frame; None if the poses are those of the frame itself.
        reference: the frame of the robot that does not move in the world; None for the root. With a foot here, a hand
            or another foot there, and no world, these are contacts at known places.
        noise: standard deviations of a coordinate of position [m] and of the rotation vector [rad].
    """

    q: ArrayLike
    frame: str
    poses: ArrayLike
    world: str | None = None
    marker: str | None = None
    reference: str | None = None
    noise: tuple[float, float] = (1e-3, 1e-2)

    def _checked(self, robot: RobotModel) -> Checked:
        """Return the checked observation."""
        q = _configurations(robot, self.q)
        poses = _one_each(rigid_poses(self.poses, "poses"), self.q, (4, 4), "poses")
        noise = np.repeat(_noise(self.noise, (2,), "noise of poses"), 3)
        robot.frame_ids([self.frame])
        _known(robot, self.reference)

        def measure(state: State, q: Floats, trial: bool = False) -> Seen:
            inside = state.frame(q, self.reference).inverse() @ state.frame(q, self.frame)
            place = state.pose(self.world) @ inside @ state.pose(self.marker)
            error = Moving(rigid_inverse(place.T if trial else poses), state.fixed.J) @ place
            R, turn = error.T[:, :3, :3], log(error.T[:, :3, :3])
            J = np.concatenate((R @ error.J[:, :3], right_jacobian_inverse(turn) @ error.J[:, 3:]), axis=1)
            residuals = np.concatenate((error.T[:, :3, 3], turn), axis=1)
            return Seen((residuals / noise)[:, None], (J / noise[:, None])[:, None])

        world = self.world, f"world of {self.reference or 'the root'}"
        names = _named(world, (self.marker, f"marker on {self.frame}"))
        return Checked("poses", "", q, measure, np.zeros((len(q), 1, 6)), names, self)


@dataclass(frozen=True)
class Contacts:
    """Two soles that lie flat on one floor, or on each other.

    In the frame of the one sole, the origin of the other has the height z, and its normal has neither x nor y. Sliding
    and turning on the floor are free; if the place is known as well, use `Poses` with a reference.

    Attributes:
        q: reported configurations, shape (..., nq).
        frame: one sole: a frame whose z is normal to it.
        reference: the other sole.
        height: z of the first sole in the second, for example the thickness of a foot that it stands on [m].
        noise: standard deviations of the height [m] and of the two tilts [rad].
    """

    q: ArrayLike
    frame: str
    reference: str
    height: float = 0.0
    noise: tuple[float, float] = (5e-4, 5e-3)

    def _checked(self, robot: RobotModel) -> Checked:
        """Return the checked observation."""
        q = _configurations(robot, self.q)
        height = shaped(self.height, (), "height")
        noise = _noise(self.noise, (2,), "noise of contacts")[[0, 1, 1]]
        robot.frame_ids([self.frame, self.reference])

        def measure(state: State, q: Floats, trial: bool = False) -> Seen:
            place = state.frame(q, self.reference).inverse() @ state.frame(q, self.frame)
            R, up = place.T[:, :3, :3], np.array([0.0, 0.0, 1.0])
            residuals = np.stack((place.T[:, 2, 3] - height, R[:, 0, 2], R[:, 1, 2]), axis=1)
            turned = -R @ cross_matrix(up) @ place.J[:, 3:]
            J = np.concatenate(((R @ place.J[:, :3])[:, 2:], turned[:, :2]), axis=1)
            return Seen((residuals / noise)[:, None], (J / noise[:, None])[:, None])

        return Checked("contacts", "", q, measure, np.zeros((len(q), 1, 3)), (), self)


AnyObservation = Pixels | Poses | Contacts


@dataclass(frozen=True)
class Checked:
    """A checked observation: what is predicted for values of the unknowns, and what was measured."""

    kind: str  # "pixels", "poses" or "contacts"
    item: str  # the word for one of several things seen in a posture
    q: Floats
    measure: Callable[..., Seen]  # predicted numbers over their noise, at any configurations
    measured: Floats  # over their noise, shape (n, items, numbers); NaN where nothing was seen
    poses: tuple[tuple[str, str], ...]  # name and meaning of each unknown pose
    given: Any  # the observation as given

    def at(self, state: State) -> Seen:
        """Return the residuals and their derivatives of everything that was seen, item by item."""
        seen = self.measure(state, self.q)
        mask = self.mask
        residuals, J = (seen.residuals - self.measured)[mask], seen.J[mask]
        lost = ~np.isfinite(residuals).all(axis=-1)
        residuals[lost], J[lost] = BEHIND, 0.0
        return Seen(residuals, J)

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Which items were seen, shape (n, items)."""
        return np.asarray(np.isfinite(self.measured).all(axis=-1))

    def describe(self, row: int) -> str:
        """Return the name of an item, given by its row in the residuals."""
        posture, item = np.argwhere(self.mask)[row]
        return f"posture {posture}" + (f", {self.item} {item}" if self.item else "")


def _configurations(robot: RobotModel, q: ArrayLike) -> Floats:
    array = robot.checked(q).reshape(-1, robot.nq)
    if not len(array):
        raise BadArgument("an observation needs at least one configuration")
    return array


def _one_each(array: Floats, q: ArrayLike, tail: tuple[int, ...], what: str) -> Floats:
    """Return an array with one entry for each configuration, shape (n, *tail)."""
    expected = (*np.shape(q)[:-1], *tail)
    if array.shape != expected:
        raise WrongShape(what, str(expected), array.shape)
    return array.reshape(-1, *tail)


def camera_at(state: State, q: Floats, camera: Camera) -> Moving:
    """Return T_root_camera, of the camera's body frame."""
    mounted, T_mounted_body = state.frame(q, camera.frame), pose_of_body(state.unknowns.robot, camera.frame)
    return mounted if T_mounted_body is None else mounted @ Moving(T_mounted_body, state.fixed.J)


def _known(robot: RobotModel, *frames: str | None) -> None:
    robot.frame_ids([frame for frame in frames if frame is not None])


@contextmanager
def errors_of(where: str) -> Iterator[None]:
    """Name the place of an error at the beginning of its message."""
    try:
        yield
    except NaoKinError as error:
        error.args = (f"{where}: {error}",)
        raise


def _named(*poses: tuple[str | None, str]) -> tuple[tuple[str, str], ...]:
    """Return names and meanings of those poses that have a name."""
    named = tuple((name, meaning) for name, meaning in poses if name is not None)
    for name, meaning in named:
        if not isinstance(name, str):
            raise BadArgument(f"the name of a {meaning} must be a text, got {quoted(name)}")
    return named


def _noise(values: ArrayLike, shape: tuple[int, ...], what: str) -> Floats:
    noise = shaped(values, shape, what)
    if not (noise > 0.0).all():
        raise BadArgument(f"{what} must be positive, got {quoted(values)}")
    return noise


# --- First estimates of unknown poses, from the nominal robot.

# Postures from which a board's pose is estimated; the best estimate counts.
_TRIED = 10
# Ratio of the least to the greatest extent of points that lie in a plane, and of those on a line.
_FLAT = 1e-6


def add_starts(state: State, observation: Checked, starts: dict[str, Floats]) -> None:
    """Estimate the poses that an observation needs and that have no start yet."""
    if all(name in starts for name, _ in observation.poses):
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


# --- Observations in a JSON file.

_HEAD = {"joints", "frames", "start", "observations"}
# Of each type of observation: the members that must be names, all others, and those of each posture.
_MEMBERS = {
    "pixels": (("camera",), {"resolution", "intrinsics", "distortion", "points", "frame", "board"}, {"pixels"}),
    "poses": (("frame",), {"world", "marker", "reference"}, {"pose"}),
    "contacts": (("frame", "reference"), {"height"}, set[str]()),
}
_COMMON = {"type", "noise", "posture", "seen"}
# Members that are the attributes of the same names.
_PASSED_ON = ("frame", "board", "world", "marker", "reference", "height", "noise")


def read_observations(robot: RobotModel, path: Path | str) -> dict[str, Any]:
    """Return the arguments of `calibrate` from a JSON file.

    The file has the members `observations` and, as for `calibrate`, `joints`, `frames` and `start`. An observation has
    a `type`: "pixels", "poses" or "contacts"; the attributes of `Pixels`, `Poses` or `Contacts`; and `seen`, a list
    with one object for each posture: `joints` (name → reported value [rad], joints not named as in the `posture` of
    the observation, or zero) and `pixels` ([u, v] or null for each point) or `pose` (six numbers, or rows of four).
    A camera is named, with a `resolution` and perhaps its own `intrinsics` [fx, fy, cx, cy] and `distortion`.

    Args:
        robot: the nominal robot.
        path: the file, "-" for standard input.

    Returns:
        {"observations": […], "joints": …, "frames": …, "start": …}, all of them arguments of `calibrate`.

    Raises:
        BadInputFile: the file cannot be read or is not valid; the message names the observation and posture.

    Examples:
        >>> arguments = nk.calibration.read_observations(nk.load_nao(), "observations.json")  # doctest: +SKIP
        >>> found = nk.calibration.calibrate(nk.load_nao(), **arguments)  # doctest: +SKIP
    """
    check_robot(robot)
    name = str(path)
    document = read_json(name, read_text(name))
    try:
        _check_members(document, _HEAD)
        given = _list(document.get("observations"), "observations")
        joints, frames = document.get("joints", []), document.get("frames", [])
        if not isinstance(joints, list) or not isinstance(frames, list | dict):
            raise BadArgument("joints must be a list of names, and frames too, or an object of lists")
        start = {
            board: pose_of(T, f"start of {board}") for board, T in _object(document.get("start", {}), "start").items()
        }
    except NaoKinError as error:
        raise BadInputFile(name, str(error)) from None
    observations = []
    for number, one in enumerate(given):
        try:
            observations.append(_observation(robot, one))
        except NaoKinError as error:
            raise BadInputFile(name, f"observation {number}: {error}") from None
    return {"observations": observations, "joints": joints, "frames": frames, "start": start}


def _observation(robot: RobotModel, given: Any) -> AnyObservation:
    kind = _object(given, "an observation").get("type")
    if not isinstance(kind, str) or kind not in _MEMBERS:
        raise UnknownName("type of observation", kind, tuple(_MEMBERS))
    names, others, of_seen = _MEMBERS[kind]
    _check_members(given, _COMMON | set(names) | others)
    for key in names:
        if not isinstance(given.get(key), str):
            raise BadArgument(f"{key} must be given: the name of a frame")
    seen, posture, rows = _list(given.get("seen"), "seen"), given.get("posture"), list[Floats]()
    for number, one in enumerate(seen):
        _check_members(one, {"joints"} | of_seen, f"seen {number}: ")
        joints = _object(one.get("joints", {}), f"joints of seen {number}")
        with_posture = robot.configuration if posture is None else partial(robot.posture, posture)
        with errors_of(f"seen {number}"):
            rows.append(with_posture(joints, limits="ignore"))
    own = {key: given[key] for key in _PASSED_ON if key in given}
    if kind == "contacts":
        return Contacts(np.array(rows), **own)
    if kind == "poses":
        poses = [pose_of(one.get("pose"), f"pose of seen {number}") for number, one in enumerate(seen)]
        return Poses(np.array(rows), poses=np.array(poses), **own)
    points = as_floats(_list(given.get("points"), "points"), (3,), "points")
    pixels = [_pixels(one.get("pixels"), len(points), f"pixels of seen {number}") for number, one in enumerate(seen)]
    return Pixels(np.array(rows), _camera(robot, given), np.array(pixels), points, **own)


def _camera(robot: RobotModel, given: Mapping[str, Any]) -> Any:
    resolution = given.get("resolution", "VGA")
    found = camera(robot, given["camera"], tuple(resolution) if isinstance(resolution, list) else resolution)
    if "intrinsics" in given:
        numbers = as_floats(given["intrinsics"], (4,), "intrinsics").tolist()
        found = replace(found, **dict(zip(("fx", "fy", "cx", "cy"), numbers, strict=True)))
    if "distortion" in given:
        found = replace(found, distortion=tuple(as_floats(given["distortion"], (), "distortion").ravel().tolist()))
    return found


def _pixels(given: Any, count: int, what: str) -> Floats:
    rows = [[np.nan, np.nan] if row is None else row for row in _list(given, what)]
    try:
        found = np.array(rows, dtype=np.float64)
    except (TypeError, ValueError):
        raise BadArgument(f"{what} must be [u, v] or null for each point") from None
    if found.shape != (count, 2):
        raise BadArgument(f"{what} must be [u, v] or null for each of {count} points, got {len(rows)}")
    return found


def _list(value: Any, what: str) -> list[Any]:
    if not isinstance(value, list) or not value:
        raise BadArgument(f"{what} must be a list that is not empty, got {quoted(described(value))}")
    return value


def _object(value: Any, what: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise BadArgument(f"{what} must be an object, got {quoted(described(value))}")
    return value


def _check_members(value: Any, known: set[str], where: str = "") -> None:
    for name in _object(value, f"{where}the document" if not where else where.rstrip(": ")):
        if name not in known:
            raise UnknownName(f"{where}member", name, sorted(known))
