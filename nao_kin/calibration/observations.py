"""What a calibration observes: pixels of known points or of lines of a soccer field, poses of frames, and soles."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import Floats, as_floats, as_pixels, choice, cross_matrix, positive, rigid_inverse, shaped
from nao_kin._core.text import one_line_repr, quoted
from nao_kin.calibration.unknowns import Motion, Moving, State
from nao_kin.errors import BadArgument, NaoKinError, WrongShape
from nao_kin.robot import RobotModel
from nao_kin.rotations import log, right_jacobian_inverse
from nao_kin.screws import rigid_poses
from nao_kin.world import Camera

# Residual, in units of its noise, of a point that is behind the camera during the search.
BEHIND = 1e4
# The meanings of unknown poses with three numbers: where a robot stands on the floor.
PLACE = "place on the floor of"
_CIRCLE = "centre circle"
_ARRAYS = ("q", "pixels", "points", "poses", "lines")
# Times before and after an image at which the motion of the joints is asked for [s].
_ASIDE = 0.04
# Joints that move by less in this time are still: the noise of their values [rad].
_STILL = np.radians(0.6)


@dataclass(frozen=True)
class Seen:
    """Residuals in units of their noise, shape (n, items, numbers), and their derivatives (…, unknowns)."""

    residuals: Floats
    J: Floats
    visible: NDArray[np.bool_] | None = None  # which items are in the image, shape (n, items); None for all


class _Observed:
    """An observation, which keeps copies of the arrays that it is given."""

    def __post_init__(self) -> None:
        vars(self).update(copy.deepcopy({name: value for name, value in vars(self).items() if name in _ARRAYS}))


@one_line_repr
@dataclass(frozen=True)
class Pixels(_Observed):
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
        on_floor: whether the board is the floor that the frame, a sole, stands on: its points have z = 0, and its
            unknown pose is a place (x, y, yaw). Observations of `Lines` may share it.
        moving: for images of moving joints, a function that returns their configurations, shape (..., nq), a time [s]
            after those of the images: `lambda t: nk.world.configurations_at(robot, log_q, log_times, times + t)`. The
            clock of the camera is then unknown: by how much its images are later than their times say.
    """

    q: ArrayLike
    camera: Camera
    pixels: ArrayLike
    points: ArrayLike
    frame: str | None = None
    board: str | None = None
    noise: float = 0.5
    on_floor: bool = False
    moving: Callable[[float], ArrayLike] | None = None

    def _checked(self, robot: RobotModel) -> Checked:
        """Return the checked observation."""
        q = configurations(robot, self.q)
        points = as_floats(self.points, (3,), "points")
        if points.ndim != 2:
            raise WrongShape("points", "(k, 3)", points.shape)
        pixels = one_each(as_pixels(self.pixels), self.q, (len(points), 2), "pixels")
        noise = positive(self.noise, "noise of pixels")
        own = motion(robot, q, self.camera, self.moving)

        def measure(state: State, q: Floats, trial: bool = False) -> Seen:
            at = None if trial else own
            T_root_points = state.frame(q, self.frame, at) @ state.pose(self.board)
            place = camera_at(state, q, self.camera, at).inverse() @ T_root_points
            R, t = place.T[..., None, :3, :3], place.T[..., None, :3, 3]
            seen = (R @ points[..., None])[..., 0] + t
            # A point X of a body with the twist (v; ω) in the body's axes moves by R (v + ω × X).
            moved = R @ (place.J[..., None, :3, :] - cross_matrix(points) @ place.J[..., None, 3:, :])
            camera = state.lens(self.camera)
            J = camera.pixel_jacobian(seen) @ moved
            state.lens(self.camera, J, lambda lens: lens.project(seen))
            predicted = camera.project(seen)
            return Seen(predicted / noise, J / noise, camera.sees(predicted))

        meaning = f"board on {self.frame or 'the root'}"
        if self.on_floor:
            if self.board is None or self.frame is None or points[:, 2].any():
                raise BadArgument("on_floor needs a board, a sole as its frame, and points with z = 0")
            meaning = f"{PLACE} {self.frame}"
        poses = named((self.board, meaning))
        return Checked("pixels", "point", q, measure, pixels / noise, poses, self, (self.camera.frame, self.frame), own)


@one_line_repr
@dataclass(frozen=True)
class Poses(_Observed):
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
        q = configurations(robot, self.q)
        poses = one_each(rigid_poses(self.poses, "poses"), self.q, (4, 4), "poses")
        noise = np.repeat(positive(self.noise, "noise of poses", (2,)), 3)
        robot.frame_ids([self.frame])

        def measure(state: State, q: Floats, trial: bool = False) -> Seen:
            inside = state.frame(q, self.reference).inverse() @ state.frame(q, self.frame)
            place = state.pose(self.world) @ inside @ state.pose(self.marker)
            error = Moving(rigid_inverse(place.T if trial else poses), state.fixed.J) @ place
            R, turn = error.T[:, :3, :3], log(error.T[:, :3, :3])
            J = np.concatenate((R @ error.J[:, :3], right_jacobian_inverse(turn) @ error.J[:, 3:]), axis=1)
            residuals = np.concatenate((error.T[:, :3, 3], turn), axis=1)
            return Seen((residuals / noise)[:, None], (J / noise[:, None])[:, None])

        meaning = f"world of {self.reference or 'the root'}"
        names = named((self.world, meaning), (self.marker, f"marker on {self.frame}"))
        return Checked("poses", "", q, measure, np.zeros((len(q), 1, 6)), names, self, (self.reference, self.frame))


@one_line_repr
@dataclass(frozen=True)
class Contacts(_Observed):
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
        q = configurations(robot, self.q)
        height = shaped(self.height, (), "height")
        noise = positive(self.noise, "noise of contacts", (2,))[[0, 1, 1]]
        robot.frame_ids([self.frame, self.reference])

        def measure(state: State, q: Floats, trial: bool = False) -> Seen:
            place = state.frame(q, self.reference).inverse() @ state.frame(q, self.frame)
            R, up = place.T[:, :3, :3], np.array([0.0, 0.0, 1.0])
            residuals = np.stack((place.T[:, 2, 3] - height, R[:, 0, 2], R[:, 1, 2]), axis=1)
            turned = -R @ cross_matrix(up) @ place.J[:, 3:]
            J = np.concatenate(((R @ place.J[:, :3])[:, 2:], turned[:, :2]), axis=1)
            return Seen((residuals / noise)[:, None], (J / noise[:, None])[:, None])

        return Checked("contacts", "", q, measure, np.zeros((len(q), 1, 3)), (), self, (self.reference, self.frame))


@dataclass(frozen=True)
class Field:
    """The dimensions of a soccer field [m], as in the rule book of the RoboCup Standard Platform League (SPL).

    The origin is at its centre, x towards the opponent's goal, y to the left, and its lines have z = 0. All dimensions
    are between the middles of lines, as in the rule book.

    Attributes:
        name: name of the field, as in `FIELDS`.
        length, width: of the field.
        penalty_area, goal_area: length and width of these areas; (0, 0) for none.
        penalty_mark: distance of the penalty mark from the goal line.
        circle: diameter of the centre circle.
        source: where the numbers are from.

    Examples:
        >>> field = nk.calibration.FIELDS["SPL 2020"]
        >>> field.points["opponent penalty mark"], field.lines["halfway line"]
        ((3.2, 0.0, 0.0), ((0.0, -3.0), (0.0, 3.0)))
    """

    name: str
    length: float
    width: float
    penalty_area: tuple[float, float]
    goal_area: tuple[float, float]
    penalty_mark: float
    circle: float
    source: str

    @property
    def points(self) -> dict[str, tuple[float, float, float]]:
        """The named points: marks, and where lines meet; "own left corner", or "opponent right penalty area corner"."""
        found = {"centre": (0.0, 0.0, 0.0)}
        for side, y in (("left", 1.0), ("right", -1.0)):
            found[f"{side} end of halfway line"] = 0.0, y * self.width / 2.0, 0.0
        for half, x in (("own", -1.0), ("opponent", 1.0)):
            goal = x * self.length / 2.0
            found[f"{half} penalty mark"] = goal - x * self.penalty_mark, 0.0, 0.0
            for side, y in (("left", 1.0), ("right", -1.0)):
                found[f"{half} {side} corner"] = goal, y * self.width / 2.0, 0.0
                for area, (length, width) in self._areas.items():
                    found[f"{half} {side} {area} corner"] = goal - x * length, y * width / 2.0, 0.0
                    found[f"{half} {side} {area} at goal line"] = goal, y * width / 2.0, 0.0
        return found

    @property
    def lines(self) -> dict[str, tuple[tuple[float, float], tuple[float, float]]]:
        """The ends (x, y) of the named straight lines; the round one is "centre circle"."""
        half_length, half_width = self.length / 2.0, self.width / 2.0
        found = {"halfway line": ((0.0, -half_width), (0.0, half_width))}
        for side, y in (("left", half_width), ("right", -half_width)):
            found[f"{side} touchline"] = (-half_length, y), (half_length, y)
        for half, x in (("own", -1.0), ("opponent", 1.0)):
            goal = x * half_length
            found[f"{half} goal line"] = (goal, -half_width), (goal, half_width)
            for area, (length, width) in self._areas.items():
                front = goal - x * length
                found[f"{half} {area} line"] = (front, -width / 2.0), (front, width / 2.0)
                for side, y in (("left", width / 2.0), ("right", -width / 2.0)):
                    found[f"{half} {side} {area} line"] = (front, y), (goal, y)
        return found

    @property
    def _areas(self) -> dict[str, tuple[float, float]]:
        areas = {"penalty area": self.penalty_area, "goal area": self.goal_area}
        return {name: size for name, size in areas.items() if any(size)}


_BOOK = (
    "SPL rule books of 2020 to 2025; as in HULKs/hulk 716f64d6, etc/parameters/default.json (2025), and in "
    "BHumanCodeRelease d89d603f, Config/Locations/Default/fieldDimensions.cfg"
)
_OLD_BOOK = "SPL rule book of 2014, section 1.1 and figure 1; the field of 2013 to 2019, without goal areas"
FIELDS: Mapping[str, Field] = {
    "SPL 2020": Field("SPL 2020", 9.0, 6.0, (1.65, 4.0), (0.6, 2.2), 1.3, 1.5, _BOOK),
    "SPL 2013": Field("SPL 2013", 9.0, 6.0, (0.6, 2.2), (0.0, 0.0), 1.3, 1.5, _OLD_BOOK),
}


def _line(ends: ArrayLike) -> Floats:
    """Return the line l · h = 0, h = (x, y, 1), through two points."""
    points = as_floats(ends, (), "a line")
    if points.shape != (2, 2):
        raise WrongShape("a line", "(2, 2)", points.shape)
    x, y = points[1] - points[0]
    if not np.hypot(x, y) > 0.0:
        raise BadArgument(f"the two points of a line must differ, got {quoted(ends)}")
    normal = np.array([-y, x]) / np.hypot(x, y)
    return np.array([*normal, -normal @ points[0]])


@one_line_repr
@dataclass(frozen=True)
class Lines(_Observed):
    """Pixels on lines of a soccer field, seen by a robot that stands at an unknown place.

    One sole is flat on the field. Which point of its line a pixel shows is not known; the place of the robot, x, y and
    yaw of the field in the sole, is estimated. A pixel with the ray r shows the point h = H⁻¹ r of the field, where the
    columns of H are the field's x, y and origin in the camera. On a straight line g = l · h is zero, on the centre
    circle g = hᵀ C h. The residual is the distance of the pixel from the line in the image, g/‖∇g‖, divided by the
    noise; for the circle to first order (Sampson's distance).

    Attributes:
        q: reported configurations, shape (..., nq).
        camera: the camera, as in `Pixels`.
        pixels: pixels (u, v), shape (..., k, 2) [pixels]; NaN for one that is not seen.
        lines: the line of each pixel, k names of `Field.lines` or "centre circle", or two points (x, y) of each [m].
        frame: the sole that stands on the field.
        board: name of the place; observations with the same name are from the same place. Named points of the field are
            `Pixels` with this board and `on_floor`.
        field: the field, or its name in `FIELDS`.
        noise: standard deviation of a pixel across its line [pixels].
        moving: as in `Pixels`.

    Source: Sampson, Fitting conic sections to "very scattered" data, 1982; Hartley and Zisserman, 4.2.6.

    Examples:
        >>> nao, field = nk.load_nao(), nk.calibration.FIELDS["SPL 2020"]
        >>> q, camera = nao.posture("StandInit", HeadYaw=[-0.3, 0.0, 0.3]), nk.world.camera(nao, "CameraTop")
        >>> pixels = np.full((3, 2, 2), [[300.0, 350.0], [340.0, 360.0]])
        >>> seen = nk.calibration.Lines(q, camera, pixels, ["halfway line", "centre circle"])
    """

    q: ArrayLike
    camera: Camera
    pixels: ArrayLike
    lines: Sequence[str | ArrayLike]
    frame: str = "LLeg"
    board: str = "field"
    field: str | Field = "SPL 2020"
    noise: float = 1.0
    moving: Callable[[float], ArrayLike] | None = None

    def _checked(self, robot: RobotModel) -> Checked:
        """Return the checked observation."""
        q, (C, L) = configurations(robot, self.q), self._curves()
        pixels = one_each(as_pixels(self.pixels), self.q, (len(C), 2), "pixels")
        noise = positive(self.noise, "noise of lines")
        if np.isnan(_rays(self.camera, pixels)[..., 1:][np.isfinite(pixels)]).any():
            raise BadArgument(f"the distortion of {self.camera.name} cannot be inverted at some pixels")

        own, at_own = q, motion(robot, q, self.camera, self.moving)

        def measure(state: State, q: Floats, trial: bool = False) -> Seen:
            place = self._place(state, q, None if trial else at_own)
            R, v, w = place.T[:, :3, :3], place.J[:, :3], place.J[:, 3:]
            # The point (x, y, 0) has the direction H (x, y, 1). H's columns turn with ω, and the last moves with v.
            H, o = place.T[:, :3, [0, 1, 3]], np.zeros_like(w[:, 0])
            moved = np.array(((o, w[:, 2], -w[:, 1]), (-w[:, 2], o, w[:, 0]), (v[:, 0], v[:, 1], v[:, 2])))
            M, dH = np.linalg.inv(H), np.einsum("nij,cjnu->nicu", R, moved)
            camera, shown, visible = state.lens(self.camera), pixels, None
            if trial:  # the point of the field that the first posture showed
                back = np.linalg.inv(self._place(state, own, at_own).T[:, :3, [0, 1, 3]])
                there = _rays(camera, pixels) @ np.swapaxes(back, -1, -2)
                first = np.isfinite(there).all(axis=-1).argmax(axis=0)
                shown = camera.project(np.nan_to_num(there[first, np.arange(len(C))] @ np.swapaxes(H, -1, -2)))
                visible = camera.sees(shown)

            r = _rays(camera, shown)
            h = r @ np.swapaxes(M, -1, -2)
            c = 2.0 * np.einsum("kij,nkj->nki", C, h) + L
            g, G = (h * (c + L)).sum(axis=-1) / 2.0, c @ M
            dh = -np.einsum("nij,njcu,nkc->nkiu", M, dH, h)
            dg = np.einsum("nki,nkiu->nku", c, dh)
            dc = 2.0 * np.einsum("kij,nkju->nkiu", C, dh)
            dG = np.einsum("nji,nkju->nkiu", M, dc - np.einsum("njcu,nkj->nkcu", dH, G))
            # From the gradient by the ray to the one by the pixel, through the lens.
            D = -np.linalg.inv(camera.lens_jacobian(np.nan_to_num(-r[..., 1:])))
            s, ds = (np.einsum("nkji,nkj...->nki...", D, part[:, :, 1:]) for part in (G, dG))
            size = np.linalg.norm(s, axis=-1)
            J = dg / size[..., None] - (g / size**3)[..., None] * np.einsum("nki,nkiu->nku", s, ds)
            # Another lens moves the image of the line under the pixel; how it turns the line counts only far from it.
            normal, known = -s / size[..., None], np.nan_to_num(r)
            state.lens(self.camera, J, lambda lens: (normal * lens.project(known)).sum(axis=-1))
            return Seen((g / size / noise)[..., None], (J / noise)[..., None, :], visible)

        measured = np.where(np.isfinite(pixels).all(axis=-1), 0.0, np.nan)[..., None]
        poses, ends = named((self.board, f"{PLACE} {self.frame}")), (self.camera.frame, self.frame)
        return Checked("lines", "pixel", q, measure, measured, poses, self, ends, at_own)

    @property
    def own_field(self) -> Field:
        """The field."""
        return self.field if isinstance(self.field, Field) else FIELDS[choice(self.field, FIELDS, "field")]

    def _curves(self) -> tuple[Floats, Floats]:
        """Return the conic (k, 3, 3) and the straight line (k, 3) of each pixel; zero for the one that it is not."""
        field = self.own_field
        if isinstance(self.lines, str) or not self.lines:
            raise BadArgument(f"lines must be a list of names or of pairs of points, got {quoted(self.lines)}")
        straight, C, L = field.lines, np.zeros((len(self.lines), 3, 3)), np.zeros((len(self.lines), 3))
        for k, line in enumerate(self.lines):
            where = f"line of the field {field.name}"
            name = choice(line, [_CIRCLE, *straight], where) if isinstance(line, str) else ""
            if name == _CIRCLE:
                C[k] = np.diag([1.0, 1.0, -(field.circle**2) / 4.0])
            else:
                L[k] = _line(straight[name] if name else line)
        return C, L

    def _place(self, state: State, q: Floats, at: Motion | None) -> Moving:
        """Return T_camera_field."""
        T_root_field = state.frame(q, self.frame, at) @ state.pose(self.board)
        return camera_at(state, q, self.camera, at).inverse() @ T_root_field


def _rays(camera: Camera, pixels: Floats) -> Floats:
    """Return the directions (1, y, z) of pixels (n, k, 2); NaN where there is none."""
    rays, known = np.full((*pixels.shape[:2], 3), np.nan), np.isfinite(pixels).all(axis=-1)
    rays[known] = np.column_stack((np.ones(known.sum()), -camera.normalised(pixels[known])))
    return rays


@dataclass(frozen=True)
class Checked:
    """A checked observation: what is predicted for values of the unknowns, and what was measured."""

    kind: str  # "pixels", "lines", "poses" or "contacts"
    item: str  # the word for one of several things seen in a posture
    q: Floats
    measure: Callable[..., Seen]  # predicted numbers over their noise, at any configurations
    measured: Floats  # over their noise, shape (n, items, numbers); NaN where nothing was seen
    poses: tuple[tuple[str, str], ...]  # name and meaning of each unknown pose
    given: Any  # the observation as given
    ends: tuple[str | None, str | None]  # the frames between which joints count; None for the root
    motion: Motion | None = None  # of the joints, if they move

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


def configurations(robot: RobotModel, q: ArrayLike) -> Floats:
    """Return checked configurations, shape (n, nq)."""
    array = robot.checked(q).reshape(-1, robot.nq)
    if not len(array):
        raise BadArgument("an observation needs at least one configuration")
    return array


def one_each(array: Floats, q: ArrayLike, tail: tuple[int, ...], what: str) -> Floats:
    """Return an array with one entry for each configuration, shape (n, *tail)."""
    expected = (*np.shape(q)[:-1], *tail)
    if array.shape != expected:
        raise WrongShape(what, str(expected), array.shape)
    return array.reshape(-1, *tail)


def motion(robot: RobotModel, q: Floats, camera: Camera, moving: Callable[[float], ArrayLike] | None) -> Motion | None:
    """Return the motion of the joints at the times of images; None if they are still or nothing is known about it."""
    if moving is None:
        return None
    before, now, after = (
        shaped(np.reshape(moving(t), (-1, robot.nq)), q.shape, f"moving({t:g})")[:, robot.nq_base :]
        for t in (-_ASIDE, 0.0, _ASIDE)
    )
    if not np.allclose(now, q[:, robot.nq_base :], atol=1e-6):
        raise BadArgument("moving(0) must be q, the configurations at the times of the images")
    if np.abs(after - before).max() < _STILL:
        return None
    bend = (after - 2.0 * now + before) / _ASIDE**2
    return Motion(robot.body_frame(camera.frame), (after - before) / (2.0 * _ASIDE), bend)


def camera_at(state: State, q: Floats, camera: Camera, at: Motion | None = None) -> Moving:
    """Return T_root_camera, of the camera's body frame."""
    mounted = state.frame(q, camera.frame, at)
    T_mounted_body = state.unknowns.robot.pose_in_optical_frame(camera.frame)
    return mounted if T_mounted_body is None else mounted @ Moving(T_mounted_body, state.fixed.J)


@contextmanager
def errors_of(where: str) -> Iterator[None]:
    """Name the place of an error at the beginning of its message."""
    try:
        yield
    except NaoKinError as error:
        error.args = (f"{where}: {error}",)
        raise


def named(*poses: tuple[str | None, str]) -> tuple[tuple[str, str], ...]:
    """Return names and meanings of those poses that have a name."""
    return tuple((name, meaning) for name, meaning in poses if name is not None)
