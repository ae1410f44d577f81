"""The unknown numbers of a calibration, and poses that depend on them with their derivatives."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from nao_kin._core.arrays import Floats, choice, cross_matrix, join_poses, positive, rigid_inverse, texts
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.robot import RobotModel
from nao_kin.rotations import euler_rate_jacobian, matrix_from_rpy
from nao_kin.world import Camera

COORDINATES = ("x", "y", "z", "roll", "pitch", "yaw")
# The coordinates of a thing that lies on a plane z = 0.
PLANAR = ("x", "y", "yaw")
# Largest offsets in practice [rad or a joint's unit; m]: without a prior, the data do not determine a number whose
# standard deviation is larger.
LARGEST_ANGLE, LARGEST_SHIFT = 0.2, 0.1


@dataclass(frozen=True)
class PriorRow:
    """How accurately a number of a NAO is known before a calibration.

    Attributes:
        of: "joint" for the zero of a turning joint, "reading" for each value that one reports, "camera" for the
            mounting of a camera, "lens" for a lens that was not measured, or "clock" for the time of an image.
        coordinates: which coordinates of the mounting, or numbers of the lens; () for others.
        deviation: standard deviation [rad, m or s; numbers of a lens: relative, and of the centre in image widths].
        source: where it is from.
    """

    of: Literal["joint", "reading", "camera", "lens", "clock"]
    coordinates: tuple[str, ...]
    deviation: float
    source: str


_HULKS = "HULKs/hulk bf773f14, etc/parameters/head.*.json, 14 robots"
_ROS = "ros-naoqi/naoqi_driver aa837336, src/converters/camera_info_definitions.hpp"
PRIORS: tuple[PriorRow, ...] = (
    PriorRow("joint", (), np.radians(1.0), f"{_HULKS}: the torso leans by 0.3° and 0.6° rms"),
    PriorRow("reading", (), np.radians(0.1), "Aldebaran documentation 2.8, NAO6 joint position sensors: 12 bits"),
    PriorRow("camera", ("roll",), np.radians(1.0), f"{_HULKS}: 0.5° and 0.9° rms"),
    PriorRow("camera", ("pitch",), np.radians(5.0), f"{_HULKS}: 5.3° and 4.4° rms"),
    PriorRow("camera", ("yaw",), np.radians(2.0), f"{_HULKS}: 1.5° rms"),
    PriorRow("camera", ("x", "y", "z"), 0.003, "an estimate"),
    PriorRow("lens", ("focal length",), 0.03, f"{_ROS}: +2.3 %; BHumanCodeRelease, cameraIntrinsics.cfg: +3.4 %"),
    PriorRow("lens", ("aspect ratio",), 0.005, f"{_ROS}: 0.2 % and 0.4 %"),
    PriorRow("lens", ("cx", "cy"), 0.016, f"{_ROS}: 4 to 11 pixels of 640"),
    PriorRow("lens", ("k1",), 0.1, f"{_ROS}: -0.09 to 0.11"),
    PriorRow("lens", ("k2",), 0.15, f"{_ROS}: -0.31 to 0.13"),
    PriorRow("lens", ("p1", "p2"), 0.003, f"{_ROS}: up to 0.0055"),
    PriorRow("clock", (), 0.05, "an estimate: one or two periods of a camera with 30 images a second"),
)
# The numbers of a lens that was not measured.
LENS = tuple(name for row in PRIORS if row.of == "lens" for name in row.coordinates)
_TYPICAL: dict[tuple[str, str], float] = {
    (row.of, name): row.deviation for row in PRIORS for name in row.coordinates or ("",)
}
# Step of differences by a number of a lens, which are exact: pixels are linear in each of them.
_STEP = 1e-5


def with_lens(camera: Camera, numbers: Floats) -> Camera:
    """Return a camera whose lens differs from its own by these numbers, in the order of `LENS`."""
    focal, aspect, cx, cy = numbers[:4].tolist()
    coefficients = np.array(camera.distortion or (0.0,) * 4)
    coefficients[:4] += numbers[4:]
    return replace(
        camera,
        fx=camera.fx * (1.0 + focal),
        fy=camera.fy * (1.0 + focal) * (1.0 + aspect),
        cx=camera.cx + cx * camera.width,
        cy=camera.cy + cy * camera.width,
        distortion=tuple(coefficients.tolist()),
        nominal=False,
    )


@dataclass(frozen=True)
class Moving:
    """Poses T_ab, shape (..., 4, 4), and their derivatives J, shape (..., 6, unknowns): the twists of b in its axes."""

    T: Floats
    J: Floats

    def __matmul__(self, other: Moving) -> Moving:
        """T_ab T_bc, whose twist is that of b, moved to c, plus that of c in b."""
        return Moving(self.T @ other.T, _carried(other.T, self.J) + other.J)

    def inverse(self) -> Moving:
        """T_ba; a moves in b against the motion of b in a."""
        back = rigid_inverse(self.T)
        return Moving(back, -_carried(back, self.J))


def _carried(T_bc: Floats, J: Floats) -> Floats:
    """The twists of c in its axes, from those of b in its own, with which it moves: Rᵀ (v + ω × t) and Rᵀ ω."""
    back, t = np.swapaxes(T_bc[..., :3, :3], -1, -2), T_bc[..., :3, 3]
    linear = J[..., :3, :] - cross_matrix(t) @ J[..., 3:, :]
    return np.concatenate([back @ linear, back @ J[..., 3:, :]], axis=-2)


@dataclass(frozen=True)
class Block:
    """An unknown pose, start · (x, y, z, roll, pitch, yaw), with the places of its six numbers; −1 for a fixed zero."""

    places: tuple[int, ...]
    start: Floats = field(default_factory=lambda: np.eye(4))


FIXED = Block((-1,) * len(COORDINATES))


@dataclass(frozen=True, eq=False)
class Motion:
    """How the joints moved at the times of a camera's images: q(t) = q + rate t + bend t²/2, shapes (n, joints)."""

    camera: str
    rate: Floats
    bend: Floats


class Unknowns:
    """The unknown numbers of one calibration: offsets of joints and frames, poses of boards and the like, nuisances.

    Nuisances are numbers that are not asked for, and not known either: the zeros of other joints that move what is
    seen, the mountings of cameras, their lenses, and their clocks. All of them have a prior.
    """

    def __init__(
        self,
        robot: RobotModel,
        joints: Iterable[str],
        frames: Mapping[str, Iterable[str]] | Iterable[str],
        poses: Mapping[str, tuple[str, ...]],
        prior: Mapping[str, ArrayLike] | Literal["typical", "none"] = "none",
        *,
        zeros: Iterable[str] = (),
        cameras: Iterable[str] = (),
        lenses: Iterable[str] = (),
        clocks: Iterable[str] = (),
    ) -> None:
        self.robot = robot
        self.joints = _joints(robot, joints)
        self._parents = {joint.child: joint.parent for joint in robot.tree.joints if joint.kind == "fixed"}
        self.named = _coordinates(frames)  # the frames asked for, with their coordinates
        for frame in self.named:
            self._check_frame(frame)
        self._own = _own_priors(prior, {*self.joints, *zeros}, {*self.named, *cameras})
        self._typical = {} if prior == "none" else _TYPICAL
        # Of each number its name, its unit ("rad", "m", "s" or "1"), and its standard deviation before the calibration.
        self.labels, self.units, self._deviations = list[str](), list[str](), list[float]()
        self.zeros = {joint: self._add(f"{joint} offset", robot.unit(joint), "joint", joint) for joint in self.joints}
        self.frames = {frame: self._block(f"{frame}'s mounting", names, frame) for frame, names in self.named.items()}
        self.offsets = len(self.labels)  # how many numbers belong to offsets
        self.poses = {name: self._block(name, coordinates) for name, coordinates in poses.items()}
        self.nuisances = len(self.labels)  # from which number on
        self._typical = _TYPICAL
        for joint in zeros:
            if joint not in self.zeros:
                self.zeros[joint] = self._add(f"zero of {joint}", "rad", "joint", joint)
        for frame in cameras:
            named = self.frames.get(frame, FIXED).places
            rest = [name for name, place in zip(COORDINATES, named, strict=True) if place < 0]
            block = self._block(f"{frame}'s mounting", rest, frame)
            self.frames[frame] = replace(block, places=tuple(map(max, named, block.places)))
        first = len(self.labels)
        self.lenses = {
            camera: [self._add(f"{camera}'s lens", "1", "lens", coordinate=name) for name in LENS] for camera in lenses
        }
        self.clocks = {camera: self._add(f"clock of {camera}", "s", "clock") for camera in clocks}
        # The numbers of the result: offsets, lenses and clocks.
        self.stated = [*range(self.offsets), *range(first, len(self.labels))]
        self._places = np.array([*self.zeros.values()], dtype=int)
        # Columns of the joints in configurations and Jacobians, from the last one.
        names = robot.joint_names
        self._columns = np.array([names.index(joint) - len(names) for joint in self.zeros], dtype=int)
        self.scales = np.where(np.array(self.units) == "m", LARGEST_SHIFT, LARGEST_ANGLE)
        self.prior = np.array(self._deviations)  # infinite if it is not known
        self.scales[self.nuisances :] = self.prior[self.nuisances :]

    def _add(self, thing: str, unit: str, of: str = "", name: str = "", coordinate: str = "") -> int:
        """Add a number with its prior, your own or the typical one, and return its place."""
        self.labels.append(f"{coordinate} of {thing}" if coordinate else thing)
        self.units.append(unit)
        typical = self._typical.get((of, coordinate), np.inf) if of != "joint" or unit == "rad" else np.inf
        own = self._own.get(name)
        self._deviations.append(own[COORDINATES.index(coordinate or "x")] if own else typical)
        return len(self.labels) - 1

    def _block(self, label: str, chosen: Iterable[str], frame: str = "") -> Block:
        of = "camera" if frame in self.robot.semantics.cameras else ""
        units = {name: "m" if name in "xyz" else "rad" for name in COORDINATES}
        places = (self._add(label, unit, of, frame, name) if name in chosen else -1 for name, unit in units.items())
        return Block(tuple(places))

    def _check_frame(self, frame: str) -> None:
        robot = self.robot
        robot.frame_ids([frame])
        link = self._link(frame)
        if link not in self._parents:
            mover = next((j.name for j in robot.tree.moving_joints if link in (j.child, j.name)), None)
            why = "is the root link" if mover is None else f"is moved by {mover}"
            raise BadArgument(f"frame {quoted(frame)} {why}: a calibrated frame is fixed to a link")
        body = robot.body_frame(frame)
        if body != frame:
            raise BadArgument(f"frame {quoted(frame)} is another frame of {body}: calibrate {body}")
        for joint in robot.tree.moving_joints:
            if link in self._above(joint.parent):
                raise BadArgument(f"frame {quoted(frame)} carries the joint {joint.name}: calibrate that joint")

    def _link(self, frame: str) -> str:
        return self.robot.tree.shared_names.get(frame, frame)

    def _above(self, link: str) -> list[str]:
        """Return a link and the links it is fixed to, the outermost first."""
        chain = [link]
        while chain[-1] in self._parents:
            chain.append(self._parents[chain[-1]])
        return chain

    def reported(self, x: Floats, q: Floats) -> Floats:
        """Return joint values with their offsets."""
        q = q.copy()
        q[..., self._columns] += x[self._places]
        return q

    def at(self, x: Floats) -> State:
        """Return the poses of frames and boards for values of the unknowns."""
        return State(self, x)


class State:
    """Poses of frames and boards for values x of the unknowns, with their derivatives."""

    def __init__(self, unknowns: Unknowns, x: Floats) -> None:
        self.unknowns, self.x = unknowns, x
        self.fixed = Moving(np.eye(4), np.zeros((6, len(x))))
        # By configurations, frame and motion, which observations share.
        self._known: dict[tuple[bytes, str, int], Moving] = {}

    def frame(self, q: Floats, name: str | None, motion: Motion | None = None) -> Moving:
        """Return T_root_frame at reported joint values q, shape (n, nq), at the time of a camera's clock."""
        if name is None:
            return self.fixed
        key = q.tobytes(), name, id(motion)
        if key not in self._known:
            self._known[key] = self._frame(q, name, motion)
        return self._known[key]

    def lens(
        self, camera: Camera, J: Floats | None = None, measure: Callable[[Camera], Floats] | None = None
    ) -> Camera:
        """Return a camera with its estimated lens, and fill the columns of J with the derivatives of what is measured.

        A lens that was measured stays as it is.
        """
        places = self.unknowns.lenses.get(self.unknowns.robot.body_frame(camera.frame), [])
        if not (places and camera.nominal):
            return camera
        lens = with_lens(camera, self.x[places])
        if J is not None and measure is not None:
            now = measure(lens)
            for place, step in zip(places, _STEP * np.eye(len(places)), strict=True):
                J[..., place] = np.nan_to_num((measure(with_lens(camera, self.x[places] + step)) - now) / _STEP)
        return lens

    def _frame(self, q: Floats, name: str, motion: Motion | None) -> Moving:
        unknowns, robot = self.unknowns, self.unknowns.robot
        q, first_joint = unknowns.reported(self.x, q), -len(robot.joint_names)
        clock = None if motion is None else unknowns.clocks.get(motion.camera)
        late = 0.0 if clock is None else self.x[clock]
        if motion is not None:
            q[:, first_joint:] += late * (motion.rate + 0.5 * late * motion.bend)
        # The calibrated frames that carry this one, the outermost first.
        links = {unknowns._link(frame): frame for frame in unknowns.frames}
        chain = [links[link] for link in reversed(unknowns._above(unknowns._link(name))) if link in links]
        first = chain[0] if chain else name
        J = np.zeros((*q.shape[:-1], 6, len(self.x)))
        by_joints = robot.jacobian(q, first, "frame")
        J[..., unknowns._places] = by_joints[..., unknowns._columns]
        if motion is not None and clock is not None:
            speeds = motion.rate + late * motion.bend
            J[..., clock] = (by_joints[..., first_joint:] @ speeds[..., None])[..., 0]
        found = Moving(robot.fk(q, first), J)
        for frame, following in pairwise([*chain, name] if chain else ()):
            T = robot.fk(robot.neutral(), following, reference=frame)
            found = found @ self._moved(unknowns.frames[frame]) @ Moving(T, self.fixed.J)
        return found

    def pose(self, name: str | None) -> Moving:
        """Return the unknown pose of this name; the identity for None."""
        return self.fixed if name is None else self._moved(self.unknowns.poses[name])

    def _moved(self, block: Block) -> Moving:
        six, J = self.six(block), np.zeros((6, len(self.x) + 1))
        R = matrix_from_rpy(six[3:])
        # The last column is that of fixed coordinates, whose place is −1.
        J[:3, block.places[:3]] = R.T
        J[3:, block.places[3:]] = euler_rate_jacobian(six[3:], "xyz", axes="fixed", expressed_in="moving")
        return Moving(block.start @ join_poses(R, six[:3]), J[:, :-1])

    def six(self, block: Block) -> Floats:
        """Return (x, y, z, roll, pitch, yaw) of an unknown pose, from its start."""
        return np.append(self.x, 0.0)[list(block.places)]


def names_of(names: Iterable[str], what: str) -> tuple[str, ...]:
    """Return names, of which a single one may be given as a string, each once."""
    return tuple(dict.fromkeys(texts((names,) if isinstance(names, str) else names, what)))


def _joints(robot: RobotModel, joints: Iterable[str]) -> tuple[str, ...]:
    """Return the names of joints with an offset of their own."""
    names = names_of(joints, "joints")
    for name in names:
        if name in robot.mimics:
            driver = robot.mimics[name].joint
            raise BadArgument(f"joint {name} follows {driver} and has no offset of its own: calibrate {driver}")
        choice(name, robot.joint_names, "joint")
    return names


def _coordinates(frames: Mapping[str, Iterable[str]] | Iterable[str]) -> dict[str, tuple[str, ...]]:
    """Return which coordinates of frames are unknown; all of those of frames without a list of them."""
    given = frames if isinstance(frames, Mapping) else dict.fromkeys(names_of(frames, "frames"), COORDINATES)
    found = dict[str, tuple[str, ...]]()
    for frame, chosen in given.items():
        names = [
            choice(name, COORDINATES, f"coordinate of frame {quoted(frame)}:")
            for name in names_of(chosen, f"coordinates of {frame}")
        ]
        found[frame] = tuple(name for name in COORDINATES if name in names)
    return found


def _own_priors(prior: object, joints: Iterable[str], frames: Iterable[str]) -> dict[str, list[float]]:
    """Return the prior standard deviations that are given: one of a joint, six of a frame."""
    if not isinstance(prior, Mapping):
        choice(prior, ("typical", "none"), "prior")
        return {}
    found = dict[str, list[float]]()
    for name, values in prior.items():
        choice(name, [*joints, *frames], "calibrated joint or frame of prior:")
        found[name] = positive(values, f"prior of {name}", () if name in joints else (6,)).ravel().tolist()
    return found
