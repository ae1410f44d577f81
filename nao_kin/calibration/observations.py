"""What a calibration observes: pixels of known points, measured poses of frames, and soles that stand on one plane."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, as_pixels, cross_matrix, rigid_inverse, shaped
from nao_kin._core.text import quoted
from nao_kin.calibration.unknowns import Moving, State
from nao_kin.errors import BadArgument, NaoKinError, WrongShape
from nao_kin.robot import RobotModel, pose_of_body, rigid_poses
from nao_kin.rotations import log, right_jacobian_inverse
from nao_kin.world import Camera

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
