"""Poses, Jacobians and centres of mass: questions that Pinocchio answers for few configurations, kernels for many."""

from __future__ import annotations

import functools
import math
import threading
import time
from collections.abc import Iterable, Sequence
from typing import Any, Literal, NamedTuple, SupportsIndex, get_args

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, DTypeLike, NDArray

from nao_kin import _kernels as kernels
from nao_kin._core.arrays import (
    CROSSOVER,
    MAX_THREADS,
    Floats,
    as_floats,
    as_numbers,
    common_batch,
    float_dtype,
    refuse_non_finite,
    whole_number,
)
from nao_kin._core.warn import TURN
from nao_kin._kernels.cache import compiles, note_slowness
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot.build import FrameIds, ModelNumbers, address, only_links
from nao_kin.robot.configurations import ConfigurationSpace
from nao_kin.robot.joint_arrays import JointArrays, joint_arrays
from nao_kin.robot.urdf import UrdfTree
from nao_kin.rotations import quat_from_matrix, rpy_from_matrix

# --- The questions about configurations that a robot answers.

Expression = Literal["frame", "root", "mixed"]
PoseForm = Literal["matrix", "quaternion", "rpy"]

POSE_FORMS: tuple[str, ...] = get_args(PoseForm)

# The shape of one frame's pose in each form.
POSE_SHAPES = {"matrix": (4, 4), "rotation": (3, 3), "position": (3,), "quaternion": (7,), "rpy": (6,)}


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
# Size of the cache of selections, one for each set of frames: more than programs use in turn.
_MAX_SELECTIONS = 256

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
    turn = quat_from_matrix(R) if form == "quaternion" else rpy_from_matrix(R)
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


# --- The joints of a robot for the batch kernels.


def joint_tree(table: JointArrays, nq: int, nv: int) -> kernels.JointTree:
    """Return the joints of a table, after a floating base if there is one, as the batch kernels take them."""
    root = table.root_mass, tuple((table.root_mass * table.root_centre_of_mass).tolist())
    joints = list[kernels.TreeJoint]()
    if nq != nv:  # the quaternion of a floating base has one number more than its angular velocity
        joints.append(kernels.TreeJoint("free", -1, np.eye(3), np.zeros(3), (1.0, 0.0, 0.0), 0, 0, 1.0, 0.0, *root))
        root = 0.0, (0.0, 0.0, 0.0)
    first = len(joints)
    moments = table.masses[:, None] * table.centres_of_mass
    columns = (table.axes, table.coordinates, table.columns, table.multipliers, table.offsets, table.masses, moments)
    rows = zip(table.kinds, table.parents.tolist(), table.placements, *(each.tolist() for each in columns), strict=True)
    for kind, parent, T, axis, coordinate, column, ratio, offset, mass, moment in rows:
        placed = parent + first, T[:3, :3], T[:3, 3], tuple(axis)
        joints.append(kernels.TreeJoint(kind, *placed, coordinate, column, ratio, offset, mass, tuple(moment)))
    return kernels.JointTree(nq, nv, tuple(joints), *root)


def tree_frame(model: pin.Model, frame_id: int) -> kernels.TreeFrame:
    """Return a frame of the model as the joint that carries it and the pose in that joint's frame."""
    frame = model.frames[frame_id]
    return kernels.TreeFrame(
        int(frame.parentJoint) - 1, np.array(frame.placement.rotation), np.array(frame.placement.translation)
    )


# --- The dispatch.

# Sizes of the caches of programs, and of sets of links: more than an application uses alternately.
_MAX_PROGRAMS, _MAX_LINK_SETS = 256, 32


_DOUBLE, _SINGLE = np.dtype(np.float64), np.dtype(np.float32)
_NAMES = ("q", "v", "a")


class Output(NamedTuple):
    """The options `dtype`, `out` and `threads` of a method."""

    dtype: DTypeLike | None = None
    out: NDArray[Any] | None = None
    threads: SupportsIndex | None = None

    def precision(self) -> np.dtype[Any]:
        """Return the precision of the result."""
        if self.dtype is None:
            return _SINGLE if getattr(self.out, "dtype", None) == _SINGLE else _DOUBLE
        return float_dtype(self.dtype)

    def check(self, shape: tuple[int, ...], kind: np.dtype[Any], inputs: Sequence[NDArray[Any]]) -> None:
        """Raise `BadArgument` or `WrongShape` for an `out` that cannot take the result."""
        out = self.out
        if out is None:
            return
        if out.dtype != kind:
            raise BadArgument(f"out must be an array of {kind}, got {out.dtype}")
        if out.shape != shape:
            raise WrongShape("out", str(shape), out.shape)
        if not out.flags.c_contiguous or not out.flags.writeable or not out.flags.aligned:
            raise BadArgument("out must be contiguous, aligned and writable")
        for values in inputs:
            self.check_no_overlap(values)

    def check_no_overlap(self, values: object) -> None:
        """Raise `BadArgument` for an `out` that shares memory with an input."""
        if self.out is not None and isinstance(values, np.ndarray) and np.may_share_memory(self.out, values):
            raise BadArgument("out must not be in the memory of an input")


class Answers:
    """Answers to questions about one robot, safe for use by several threads; `checks` checks its configurations."""

    def __init__(self, kinematics: Kinematics, tree: UrdfTree, checks: ConfigurationSpace) -> None:
        self._kinematics, self._urdf, self._checks = kinematics, tree, checks
        self._model = kinematics.model
        self._nq, self._nv = int(self._model.nq), int(self._model.nv)
        self._lock = threading.Lock()
        self._numbers: ModelNumbers | None = None
        self._programs: dict[Question, kernels.Program] = {}
        self._of_links: dict[FrameIds, Answers] = {}

    def answer(
        self, question: Question, inputs: Sequence[ArrayLike], output: Output, *, one: bool = False
    ) -> NDArray[Any]:
        """Return the answer for (q), (q, v) or (q, v, a), which broadcast; `one` drops the single frame's axis."""
        kind = output.precision()
        threads = None if output.threads is None else whole_number(output.threads, "threads", 1, MAX_THREADS)
        arrays = self._arrays(inputs)
        batch, numbers = arrays[0].shape[:-1], question.shape(self._nv)
        shape = (*batch, *(numbers[1:] if one else numbers))
        output.check(shape, kind, arrays)
        if question.kind in ("com", "com_jacobian"):
            self._kinematics.check_mass()
        count, out = math.prod(batch), output.out
        if (threads is None and count < CROSSOVER) or not compiles():
            slow = count >= CROSSOVER
            started = time.thread_time() if slow else 0.0  # a call into the system, as long as a single answer
            q = self._checks.posed(arrays[0])
            rates = [as_floats(array, (), name) for array, name in zip(arrays[1:], _NAMES[1:], strict=False)]
            few = self._kinematics.answer(question, q, *rates).reshape(shape)
            if slow:
                note_slowness(time.thread_time() - started)
            if out is None:
                return few.astype(kind, copy=False)
            out[...] = few
            return out
        size = math.prod(numbers)
        answers = kernels.aligned_empty(count * size, kind) if out is None else out
        self._by_kernels(question, arrays, answers.reshape(count, size), threads)
        return answers.reshape(shape) if out is None else out

    def _by_kernels(
        self, question: Question, arrays: Sequence[NDArray[Any]], answers: NDArray[Any], threads: int | None
    ) -> None:
        self._checks.check_base(arrays[0])
        program = self._program(question)
        # The largest magnitude of the inputs; if an input is NaN or infinite, so is this, and the answers mean nothing.
        peak = kernels.execute(program, arrays, answers, threads)
        if not math.isfinite(peak):
            self._checks.refuse_non_finite(arrays[0])
            for values, name in zip(arrays[1:], _NAMES[1:], strict=False):
                refuse_non_finite(values, name)
        if not peak <= TURN:
            self._checks.warn_of_degrees(arrays[0])

    def joints(self) -> JointArrays:
        """Return the joints of the model, the same table until a number of the model changes."""
        with self._lock:
            return self._table_now()

    def of_links(self, link_ids: FrameIds) -> Answers:
        """Return the answers for the robot in which only some links have mass, cached like a program."""
        with self._lock:
            self._table_now()
            if link_ids not in self._of_links:
                if len(self._of_links) >= _MAX_LINK_SETS:
                    self._of_links.clear()
                only = Kinematics(only_links(self._model, self._urdf, link_ids))
                self._of_links[link_ids] = Answers(only, self._urdf, self._checks)
            return self._of_links[link_ids]

    def _table_now(self) -> JointArrays:
        if self._numbers is None or self._numbers.changed():
            self._numbers, self._table = ModelNumbers(self._model), joint_arrays(self._model, self._urdf)
            self._programs.clear()
            self._of_links.clear()
            self._tree: kernels.JointTree | None = None
        return self._table

    def _program(self, question: Question) -> kernels.Program:
        """Return the program of a question, which is cached until a number of the model changes."""
        with self._lock:
            table = self._table_now()
            program = self._programs.get(question)
            if program is None:
                if len(self._programs) >= _MAX_PROGRAMS:
                    self._programs.clear()
                if self._tree is None:
                    self._tree = joint_tree(table, self._nq, self._nv)
                program = self._programs[question] = self._made(question, self._tree)
            return program

    def _made(self, question: Question, joints: kernels.JointTree) -> kernels.Program:
        kind, form, reference_id = question.kind, question.form, question.reference_id
        frames = [tree_frame(self._model, frame_id) for frame_id in question.frame_ids]
        reference = None if reference_id is None else tree_frame(self._model, reference_id)
        if kind == "poses":
            return kernels.poses_program(joints, frames, reference, form)
        if kind == "jacobian":
            return kernels.jacobian_program(joints, frames[0], form, reference)
        if kind == "com":
            return kernels.com_program(joints, reference)
        if kind == "com_jacobian":
            return kernels.com_jacobian_program(joints, reference)
        return kernels.motion_program(joints, frames, form, 1 if kind == "velocity" else 2)

    def _arrays(self, inputs: Sequence[ArrayLike]) -> list[NDArray[Any]]:
        """Return the inputs as arrays of numbers of one batch shape, without checking the numbers."""
        arrays = []
        for value, length, name in zip(inputs, (self._nq, self._nv, self._nv), _NAMES, strict=False):
            # Arrays in single precision are converted where they are used.
            single = type(value) is np.ndarray and value.dtype == _SINGLE
            array: NDArray[Any] = value if single else as_numbers(value, name)  # type: ignore[assignment]
            if array.ndim < 1 or array.shape[-1] != length:
                raise WrongShape(name, f"(..., {length})", array.shape)
            arrays.append(array)
        if len(arrays) == 1:
            return arrays
        batch = common_batch("configurations and their derivatives", *(array.shape[:-1] for array in arrays))
        return [np.broadcast_to(array, (*batch, array.shape[-1])) for array in arrays]
