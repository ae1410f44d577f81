"""Poses, Jacobians and centres of mass of configurations: the questions, the frames, and Pinocchio's answers."""

from __future__ import annotations

import functools
import math
import threading
from collections.abc import Iterable, Sequence
from types import MappingProxyType
from typing import Literal, NamedTuple, get_args

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, texts
from nao_kin._core.text import quoted
from nao_kin._core.warn import warn_caller
from nao_kin.errors import BadArgument, RenamedFrameWarning, UnknownName
from nao_kin.robot.build import Base, address
from nao_kin.robot.urdf import UrdfTree
from nao_kin.rotations import quat_from_matrix, rpy_from_matrix

# --- The questions about configurations that a robot answers.

Expression = Literal["frame", "root", "mixed"]
PoseForm = Literal["matrix", "position_quaternion", "position6d"]
FrameIds = tuple[int, ...]

# Name of the root as a reference, unless the robot has a frame with this name.
WORLD = "world"
POSE_FORMS: tuple[str, ...] = get_args(PoseForm)

# The shape of one frame's pose in each form.
POSE_SHAPES = {"matrix": (4, 4), "rotation": (3, 3), "position": (3,), "position_quaternion": (7,), "position6d": (6,)}


class Question(NamedTuple):
    """One question about configurations, for any number of them."""

    kind: str  # "poses", "jacobian", "com", "com_jacobian", "velocity" or "acceleration"
    frame_ids: FrameIds = ()
    reference_id: int | None = None  # of the frame that takes the root's place; None for the root
    form: str = ""  # for poses, one of POSE_SHAPES; for Jacobians and motions, the expression

    def shape(self, nv: int) -> tuple[int, ...]:
        """Return the shape of the answer for one configuration."""
        if self.kind == "poses":
            return (len(self.frame_ids), *POSE_SHAPES[self.form])
        shapes = {"jacobian": (6, nv), "com": (3,), "com_jacobian": (3, nv)}
        return shapes.get(self.kind, (len(self.frame_ids), 6))


# --- The answers of Pinocchio.
#
# Pinocchio keeps the placements of all frames in one block of memory: twelve doubles each, the columns of R, then p.
# A pose as a 4×4 matrix is therefore a fixed selection of that block; its zeros and its one are taken from the first
# frame, the universe, whose placement is always the identity. Selecting takes a tenth of the time of reading the
# placements one by one.

_DOUBLES = 12
_ONE, _ZERO = 0, 1  # where the universe's rotation, stored by columns, holds a one and a zero
# Up to this number, placing frames one by one is faster than placing all.
_FEW = 10
# Sizes of the caches of selections and of ids, one for each set of frames: more than programs use in turn.
_MAX_SELECTIONS, _MAX_SETS = 256, 1000

# The point and the axes of a twist, by the names that methods use.
EXPRESSIONS = {
    "frame": pin.ReferenceFrame.LOCAL,
    "root": pin.ReferenceFrame.WORLD,
    "mixed": pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
}


class Kinematics:
    """Pinocchio's answers for checked configurations (..., nq), with separate Pinocchio data for each thread."""

    def __init__(self, model: pin.Model) -> None:
        self.model = model
        self._inertias = model.inertias  # a live view; making it takes as long as computing a centre of mass
        self._local = threading.local()
        self._moving: dict[FrameIds, list[int]] = {}  # columns of the joints that are on the way between two frames

    def answer(self, question: Question, q: Floats, *rates: Floats) -> Floats:
        """Return the answer for configurations, and for velocities and accelerations if the question needs them."""
        if question.kind == "poses":
            ids, reference = question.frame_ids, question.reference_id
            poses = self.poses(q, ids) if reference is None else self.relative_poses(q, ids, reference)
            return _in_form(poses, question.form)
        if question.kind == "jacobian":
            return self.jacobians(q, question.frame_ids[0], question.form, question.reference_id)
        if question.kind == "com_jacobian":
            return self.com_jacobians(q, question.reference_id)
        if question.kind in ("velocity", "acceleration"):
            return self.motions(question.frame_ids, question.form, q, *rates)
        centres = self.centres_of_mass(q)
        if question.reference_id is None:
            return centres
        T_root_reference = self.poses(q, (question.reference_id,))[..., 0, :, :]
        lever = centres - T_root_reference[..., :3, 3]
        return np.asarray(np.einsum("...ji,...j->...i", T_root_reference[..., :3, :3], lever))

    def poses(self, q: Floats, frame_ids: FrameIds) -> Floats:
        """Return T_root_frame of several frames, shape (..., frames, 4, 4); a new array."""
        workspace, selection = self._workspace(), _selection_of(frame_ids)
        if q.ndim == 1:
            workspace.place(q, frame_ids)
            pose: Floats = workspace.placements().take(selection)
            return pose
        poses = np.empty((*q.shape[:-1], *selection.shape))
        for row, T in _rows(q, poses, selection.ndim):
            workspace.place(row, frame_ids)
            workspace.placements().take(selection, out=T, mode="clip")
        return poses

    def relative_poses(self, q: Floats, frame_ids: FrameIds, reference_id: int) -> Floats:
        """Return T_reference_frame = T_root_reference⁻¹ T_root_frame of several frames, shape (..., frames, 4, 4)."""
        poses = self.poses(q, (*frame_ids, reference_id))
        if poses.shape == (2, 4, 4):  # the same as below; plain indices halve the time
            T, T_reference = poses[0], poses[1]
            T[:3, 3] -= T_reference[:3, 3]
            relative: Floats = T.copy()
            np.matmul(T_reference[:3, :3].T, T[:3], out=relative[:3])
            return relative[None]
        T, T_reference = poses[..., :-1, :, :], poses[..., -1:, :, :]
        T[..., :3, 3] -= T_reference[..., :3, 3]
        relative = T.copy()
        np.matmul(T_reference[..., :3, :3].swapaxes(-1, -2), T[..., :3, :], out=relative[..., :3, :])
        return relative

    def jacobians(self, q: Floats, frame_id: int, expressed_in: str, reference_id: int | None = None) -> Floats:
        """Return the geometric Jacobians of one frame, linear rows first, shape (..., 6, nv); a new array."""
        if reference_id is not None:
            return self.relative_jacobians(q, frame_id, expressed_in, reference_id)
        expression = EXPRESSIONS[expressed_in]
        model, data = self.model, self._workspace().data
        shape = 6, model.nv  # with one degree of freedom, Pinocchio returns a vector
        if q.ndim == 1:
            jacobian: Floats = pin.computeFrameJacobian(model, data, q, frame_id, expression)
            return jacobian.reshape(shape)
        jacobians = np.empty((*q.shape[:-1], *shape))
        for row, J in _rows(q, jacobians, 2):
            J[...] = pin.computeFrameJacobian(model, data, row, frame_id, expression).reshape(shape)
        return jacobians

    def relative_jacobians(self, q: Floats, frame_id: int, expressed_in: str, reference_id: int) -> Floats:
        """Return Jacobians with respect to a frame, Ad (J_frame − Ad(T_frame_reference) J_reference), both "frame"."""
        model, workspace, local = self.model, self._workspace(), EXPRESSIONS["frame"]
        ids, data, identity = (frame_id, reference_id), workspace.data, pin.SE3.Identity()
        moving = self._moving.get(ids)
        if moving is None:  # a column of a joint that moves both frames alike is zero, without rounding
            one, other = (set(model.supports[model.frames[index].parentJoint]) for index in ids)
            moving = self._moving[ids] = sorted({model.joints[joint].idx_v for joint in one ^ other})
        jacobians = np.zeros((*q.shape[:-1], 6, model.nv))
        for row, J in _rows(q, jacobians, 2):
            frame, reference = (
                pin.computeFrameJacobian(model, data, row, index, local).reshape(J.shape)[:, moving] for index in ids
            )
            workspace.place(row, ids)
            T = data.oMf[reference_id].actInv(data.oMf[frame_id])
            change = {"frame": identity, "mixed": pin.SE3(T.rotation, np.zeros(3)), "root": T}[expressed_in]
            J[:, moving] = change.toActionMatrix() @ (frame - T.toActionMatrixInverse() @ reference)
        return jacobians

    def centres_of_mass(self, q: Floats) -> Floats:
        """Return centres of mass of all bodies, those fixed to the world included, shape (..., 3)."""
        model, data = self.model, self._workspace().data
        # Pinocchio includes only the moving bodies, and divides by their mass.
        held, moving = self._inertias[0], pin.computeTotalMass(model)
        total = moving + held.mass
        if total <= 0.0:
            self.check_mass()
        share, rest = moving / total, held.mass / total
        if q.ndim == 1 and moving > 0.0:  # adding three numbers one by one is faster
            x, y, z = pin.centerOfMass(model, data, q).tolist()
            held_x, held_y, held_z = held.lever.tolist()
            return np.array((share * x + rest * held_x, share * y + rest * held_y, share * z + rest * held_z))
        centres = np.zeros((*q.shape[:-1], 3))
        if moving > 0.0:
            for row, centre in _rows(q, centres, 1):
                centre[...] = pin.centerOfMass(model, data, row)
        return np.asarray(share * centres + rest * held.lever)

    def com_jacobians(self, q: Floats, reference_id: int | None = None) -> Floats:
        """Return the Jacobians of the centres of mass in the root or in a reference frame, shape (..., 3, nv)."""
        model, data = self.model, self._workspace().data
        share = pin.computeTotalMass(model) / self.check_mass()
        jacobians = np.zeros((*q.shape[:-1], 3, model.nv))
        if share > 0.0:
            for row, J in _rows(q, jacobians, 2):
                J[...] = share * pin.jacobianCenterOfMass(model, data, row).reshape(3, model.nv)
        if reference_id is None:
            return jacobians
        T = self.poses(q, (reference_id,))[..., 0, :, :]
        lever = self.centres_of_mass(q) - T[..., :3, 3]
        carried = self.jacobians(q, reference_id, "mixed")  # the point of the reference at the centre of mass moves too
        swing = np.cross(carried[..., 3:, :], lever[..., None], axis=-2)
        return np.asarray(T[..., :3, :3].swapaxes(-1, -2) @ (jacobians - carried[..., :3, :] - swing))

    def motions(self, frame_ids: FrameIds, form: str, q: Floats, v: Floats, a: Floats | None = None) -> Floats:
        """Return the twists of frames, or with accelerations their time derivatives, shape (..., frames, 6)."""
        model, data, expression = self.model, self._workspace().data, EXPRESSIONS[form]
        motions = np.empty((*q.shape[:-1], len(frame_ids), 6))
        count = math.prod(q.shape[:-1])
        rows = [array.reshape(count, array.shape[-1]) for array in (q, v, *(() if a is None else (a,)))]
        flat = motions.reshape(count, len(frame_ids), 6)
        # Only for a "mixed" twist does the derivative contain the classical acceleration of the point.
        rate = pin.getFrameClassicalAcceleration if form == "mixed" else pin.getFrameAcceleration
        for i in range(count):
            pin.forwardKinematics(model, data, *(values[i] for values in rows))
            for k, frame_id in enumerate(frame_ids):
                pin.updateFramePlacement(model, data, frame_id)
                found = (pin.getFrameVelocity if a is None else rate)(model, data, frame_id, expression)
                flat[i, k] = found.vector
        return motions

    def check_mass(self) -> float:
        """Return the mass of all bodies [kg]; raise `BadArgument` if there is none."""
        mass = self.mass
        if mass <= 0.0:
            raise BadArgument(f"{self.model.name} has no mass, so no centre of mass")
        return mass

    @property
    def mass(self) -> float:
        """Mass of all bodies, those fixed to the world included [kg]."""
        return float(pin.computeTotalMass(self.model) + self._inertias[0].mass)

    def _workspace(self) -> _Workspace:
        try:
            workspace: _Workspace = self._local.workspace
        except AttributeError:
            workspace = self._local.workspace = _Workspace(self.model)
        return workspace


def _in_form(poses: Floats, form: str) -> Floats:
    """Return poses in one of the forms of `POSE_SHAPES`."""
    R, p = poses[..., :3, :3], poses[..., :3, 3]
    if form == "matrix":
        return poses
    if form == "rotation":
        return np.array(R)
    if form == "position":
        return np.array(p)
    turn = quat_from_matrix(R) if form == "position_quaternion" else rpy_from_matrix(R)
    return np.concatenate((p, turn), axis=-1)


def _rows(q: Floats, results: Floats, axes: int) -> Iterable[tuple[Floats, Floats]]:
    """Return pairs of one configuration and a view of its result, which has `axes` axes."""
    count = math.prod(q.shape[:-1])
    flat = results.reshape(count, *results.shape[results.ndim - axes :])
    return zip(q.reshape(count, q.shape[-1]), flat, strict=True)


@functools.lru_cache(_MAX_SELECTIONS)
def _selection_of(frame_ids: FrameIds) -> NDArray[np.intp]:
    """Return the indices, in the block of placements, of the entries of these frames' poses, shape (n, 4, 4)."""
    selection = np.full((len(frame_ids), 4, 4), _ZERO, dtype=np.intp)
    row, column = np.indices((3, 4))
    selection[:, :3] = _DOUBLES * np.asarray(frame_ids, dtype=np.intp)[:, None, None] + 3 * column + row
    selection[:, 3, 3] = _ONE
    return selection


class _Workspace:
    """The Pinocchio data of one thread, and a view of all its placements."""

    def __init__(self, model: pin.Model) -> None:
        self._model = model
        self.data = model.createData()
        self._block = _block_of(self.data, model.nframes)

    def place(self, q: Floats, frame_ids: FrameIds) -> None:
        """Compute the placements of these frames at one configuration."""
        if len(frame_ids) > _FEW:
            pin.framesForwardKinematics(self._model, self.data, q)
            return
        pin.forwardKinematics(self._model, self.data, q)
        for frame_id in frame_ids:
            pin.updateFramePlacement(self._model, self.data, frame_id)

    def placements(self) -> Floats:
        """Return the placements of all frames, twelve doubles each, flat."""
        if self._block is not None:
            return self._block
        return np.concatenate([np.append(pose.rotation.T, pose.translation) for pose in self.data.oMf])


def _block_of(data: pin.Data, count: int) -> Floats | None:
    """Return a view of all placements as one array; None if this version of Pinocchio has another layout."""
    first: Floats = data.oMf[0].rotation
    start = address(first)
    for i in {0, count // 2, count - 1}:
        rotation, translation = data.oMf[i].rotation, data.oMf[i].translation
        expected = start + i * _DOUBLES * 8
        if address(rotation) != expected or address(translation) != expected + 9 * 8 or rotation.strides != (8, 24):
            return None
    return np.lib.stride_tricks.as_strided(first, shape=(count * _DOUBLES,), strides=(8,), writeable=False)


# --- The frames of a robot by name.


class FrameTable:
    """Frame name → id in a Pinocchio model.

    The frames of fixed joints are left out: they coincide with the frames of the links that these joints carry. A name
    that the URDF gives to a link and to a joint means the link, as in every tool that knows only links. If the joint's
    frame is another one, the first use of the name warns that the joint's frame has the name of the link it moves.
    """

    def __init__(self, model: pin.Model, tree: UrdfTree, base: Base) -> None:
        self._floating = base == "floating"
        links, joints = dict[str, int](), dict[str, int]()
        for index, frame in enumerate(model.frames):
            if frame.type == pin.FrameType.BODY:
                links[frame.name] = index
            elif index > 0 and frame.type != pin.FrameType.FIXED_JOINT:
                joints[frame.name] = index
        self._ids = {name: links[link] for name, link in tree.shared_names.items()} | links
        moved = {joint.name: joint.child for joint in tree.moving_joints}
        # Shared name → the link that it means, and the link that has the joint's frame.
        self._ambiguous = {
            name: (link, moved[name])
            for name, link in tree.shared_names.items()
            if name in moved and moved[name] != link
        }
        for name, index in joints.items():
            self._ids.setdefault(name, index)
        order = self._ids | joints
        self.names = tuple(sorted(self._ids, key=order.__getitem__))
        self.places = MappingProxyType({name: self._ids[name] for name in self.names})
        self.link_names = tuple(links)
        self._link_ids, self._links = tuple(links.values()), links
        self._shared_names = tree.shared_names
        self._known = functools.lru_cache(_MAX_SETS)(lambda key: tuple(map(self.id, key)))

    def id(self, name: object) -> int:
        """Return the id of a frame."""
        if not isinstance(name, str) or name not in self._ids:
            raise UnknownName("frame", name, self.names, self._about_world if str(name) == WORLD else "")
        frames = self._ambiguous.pop(name, None)  # removed, so that only the first call warns
        if frames is not None:
            link, moved = frames
            warn_caller(
                f"frame {quoted(name)}: the URDF has a link and a joint of this name. This is the link's frame "
                f"({quoted(link)}); the joint's own frame is {quoted(moved)}",
                RenamedFrameWarning,
            )
        return self._ids[name]

    def link_ids(self, names: str | Sequence[str]) -> FrameIds:
        """Return the ids of links, each once, in the order of `link_names`; `names` may be one name."""
        given = {
            self._shared_names.get(name, name)
            for name in ((names,) if isinstance(names, str) else texts(names, "links"))
        }
        for name in sorted(given - self._links.keys()):
            raise UnknownName("link", name, self.link_names)
        return tuple(index for link, index in self._links.items() if link in given)

    def reference_id(self, name: object) -> int | None:
        """Return the id of a frame; None for the root, which None means and, with a floating base, "world"."""
        if name is None or (self._floating and isinstance(name, str) and name == WORLD and name not in self._ids):
            return None
        return self.id(name)

    @property
    def _about_world(self) -> str:
        """How poses in the world are obtained, where the world is no frame."""
        if self._floating:
            return 'the world is a reference only: poses with reference="world", or without a reference, are in it'
        return 'the place of a fixed base in the world is not known; load the robot with base="floating"'

    def ids(self, names: str | Sequence[str] | None) -> FrameIds:
        """Return the ids of the frames with these names, or with one name; for None, those of all links."""
        if names is None:
            return self._link_ids
        try:
            key = (names,) if isinstance(names, str) else tuple(names)
        except TypeError:  # neither a name nor several names
            raise UnknownName("frame", names, self.names) from None
        try:
            return self._known(key)
        except TypeError:  # not names
            return tuple(map(self.id, key))
