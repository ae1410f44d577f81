"""The unknown numbers of a calibration, and poses that depend on them with their derivatives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from nao_kin._core.arrays import Floats, choice, join_poses, rigid_inverse, texts
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.robot import RobotModel, body_frame_of
from nao_kin.rotations import euler_rate_jacobian, matrix_from_rpy
from nao_kin.screws import adjoint

COORDINATES = ("x", "y", "z", "roll", "pitch", "yaw")
# Largest offsets in practice [rad or a joint's unit; m]: the data do not determine a number with a larger standard
# deviation.
LARGEST_ANGLE, LARGEST_SHIFT = 0.2, 0.1


@dataclass(frozen=True)
class Moving:
    """Poses T_ab, shape (..., 4, 4), and their derivatives J, shape (..., 6, unknowns): the twists of b in its axes."""

    T: Floats
    J: Floats

    def __matmul__(self, other: Moving) -> Moving:
        """T_ab T_bc, whose twist is that of b, moved to c, plus that of c in b."""
        return Moving(self.T @ other.T, adjoint(rigid_inverse(other.T)) @ self.J + other.J)

    def inverse(self) -> Moving:
        """T_ba; a moves in b against the motion of b in a."""
        return Moving(rigid_inverse(self.T), -adjoint(self.T) @ self.J)


@dataclass(frozen=True)
class Block:
    """An unknown pose, start · (x, y, z, roll, pitch, yaw), with the places of its six numbers; −1 for a fixed zero."""

    label: str
    places: tuple[int, ...]
    start: Floats = field(default_factory=lambda: np.eye(4))


class Unknowns:
    """The unknown numbers of one calibration: offsets of joints, then of frames, then poses of boards and the like."""

    def __init__(
        self,
        robot: RobotModel,
        joints: Iterable[str],
        frames: Mapping[str, Iterable[str]] | Iterable[str],
        poses: Iterable[str],
    ) -> None:
        self.robot = robot
        self.joints = _joints(robot, joints)
        self.labels = [f"{joint} offset" for joint in self.joints]  # the name of each number
        self.units = [robot.unit(joint) for joint in self.joints]  # "rad", "m", or "1"
        self._columns = [robot.nv - len(robot.joint_names) + robot.joint_names.index(joint) for joint in self.joints]
        self._parents = {joint.child: joint.parent for joint in robot.tree.joints if joint.kind == "fixed"}
        choices = (
            frames.items()
            if isinstance(frames, Mapping)
            else ((frame, COORDINATES) for frame in names_of(frames, "frames"))
        )
        self.frames: dict[str, Block] = {}
        for frame, chosen in choices:
            self._check_frame(frame)
            self.frames[frame] = self._block(f"{frame}'s mounting", _coordinates(frame, chosen))
        self.offsets = len(self.labels)  # how many numbers belong to offsets
        self.poses = {name: self._block(name, COORDINATES) for name in poses}

    def _block(self, label: str, chosen: tuple[str, ...]) -> Block:
        places = tuple(len(self.labels) + chosen.index(c) if c in chosen else -1 for c in COORDINATES)
        self.labels += [f"{coordinate} of {label}" for coordinate in chosen]
        self.units += ["m" if coordinate in "xyz" else "rad" for coordinate in chosen]
        return Block(label, places)

    def _check_frame(self, frame: str) -> None:
        robot = self.robot
        robot.frame_ids([frame])
        link = self._link(frame)
        if link not in self._parents:
            mover = next((j.name for j in robot.tree.moving_joints if link in (j.child, j.name)), None)
            why = "is the root link" if mover is None else f"is moved by {mover}"
            raise BadArgument(f"frame {quoted(frame)} {why}: a calibrated frame is fixed to a link")
        body = body_frame_of(robot, frame)
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

    def at(self, x: Floats) -> State:
        """Return the poses of frames and boards for values of the unknowns."""
        return State(self, x)


class State:
    """Poses of frames and boards for values x of the unknowns, with their derivatives."""

    def __init__(self, unknowns: Unknowns, x: Floats) -> None:
        self.unknowns, self.x = unknowns, x
        self.fixed = Moving(np.eye(4), np.zeros((6, len(x))))
        self._known: dict[tuple[bytes, str], Moving] = {}  # by configurations and frame, which observations share

    def frame(self, q: Floats, name: str | None) -> Moving:
        """Return T_root_frame at reported joint values q, shape (n, nq)."""
        if name is None:
            return self.fixed
        key = q.tobytes(), name
        if key not in self._known:
            self._known[key] = self._frame(q, name)
        return self._known[key]

    def _frame(self, q: Floats, name: str) -> Moving:
        unknowns, robot = self.unknowns, self.unknowns.robot
        q = q.copy()
        for value, column in zip(self.x, unknowns._columns, strict=False):
            q[..., column + robot.nq - robot.nv] += value
        above = unknowns._above(unknowns._link(name))
        # The calibrated frames that carry this one, the outermost first.
        links = {unknowns._link(frame): frame for frame in unknowns.frames}
        chain = [links[link] for link in reversed(above) if link in links]
        first = chain[0] if chain else name
        J = np.zeros((*q.shape[:-1], 6, len(self.x)))
        J[..., : len(unknowns._columns)] = robot.jacobian(q, first, "frame")[..., unknowns._columns]
        found = Moving(robot.fk(q, first), J)
        for frame, following in pairwise([*chain, name] if chain else ()):
            T = robot.fk(robot.neutral(), following, reference=frame)
            found = found @ self._moved(unknowns.frames[frame]) @ Moving(T, self.fixed.J)
        return found

    def pose(self, name: str | None) -> Moving:
        """Return the unknown pose of this name; the identity for None."""
        return self.fixed if name is None else self._moved(self.unknowns.poses[name])

    def _moved(self, block: Block) -> Moving:
        six = self.six(block)
        R, J = matrix_from_rpy(six[3:]), self.fixed.J.copy()
        rates = np.zeros((6, 6))
        rates[:3, :3] = R.T
        rates[3:, 3:] = euler_rate_jacobian(six[3:], "xyz", axes="fixed", expressed_in="moving")
        for place, column in zip(block.places, rates.T, strict=True):
            if place >= 0:
                J[:, place] = column
        return Moving(block.start @ join_poses(R, six[:3]), J)

    def six(self, block: Block) -> Floats:
        """Return (x, y, z, roll, pitch, yaw) of an unknown pose, from its start."""
        return np.array([self.x[place] if place >= 0 else 0.0 for place in block.places])


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


def _coordinates(frame: str, chosen: Iterable[str]) -> tuple[str, ...]:
    names = names_of(chosen, f"coordinates of {frame}")
    for name in names:
        choice(name, COORDINATES, f"coordinate of frame {quoted(frame)}:")
    return tuple(name for name in COORDINATES if name in names)
