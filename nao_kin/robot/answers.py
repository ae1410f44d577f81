"""Dispatch of questions: Pinocchio answers them for a few configurations, the batch kernels for many."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Sequence
from typing import Any, NamedTuple, SupportsIndex

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, DTypeLike, NDArray

from nao_kin import _kernels as kernels
from nao_kin._core.arrays import (
    CROSSOVER,
    LARGEST,
    MAX_THREADS,
    as_numbers,
    as_vectors,
    refuse_non_finite,
    whole_number,
)
from nao_kin._core.text import quoted
from nao_kin._core.warn import TURN
from nao_kin._kernels.cache import has_numba, note_slowness
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot.build import ModelNumbers, only_links
from nao_kin.robot.configurations import ConfigurationSpace
from nao_kin.robot.joint_arrays import JointArrays, joint_arrays
from nao_kin.robot.kinematics import FrameIds, Kinematics, Question
from nao_kin.robot.urdf import UrdfTree

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


def empty_answers(count: int, numbers: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return memory for answers, shape (count, *numbers), aligned for vector instructions."""
    return kernels.aligned_empty(count * math.prod(numbers), dtype).reshape(count, *numbers)


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
            single = self.out is not None and isinstance(self.out, np.ndarray) and self.out.dtype == _SINGLE
            return _SINGLE if single else _DOUBLE
        for kind in (_DOUBLE, _SINGLE):
            try:
                if kind == self.dtype:
                    return kind
            except (TypeError, ValueError):  # not a type
                break
        raise BadArgument(f"dtype must be float64 or float32, got {quoted(self.dtype)}")

    def check(self, shape: tuple[int, ...], kind: np.dtype[Any], inputs: Sequence[NDArray[Any]]) -> None:
        """Raise `BadArgument` or `WrongShape` for an `out` that cannot take the result."""
        out = self.out
        if out is None:
            return
        if not isinstance(out, np.ndarray) or out.dtype != kind:
            found = out.dtype if isinstance(out, np.ndarray) else type(out).__name__
            raise BadArgument(f"out must be an array of {kind}, got {found}")
        if out.shape != shape:
            raise WrongShape("out", str(shape), out.shape)
        if not out.flags.c_contiguous or not out.flags.writeable or not out.flags.aligned:
            raise BadArgument("out must be contiguous, aligned and writable")
        for values in inputs:
            self.check_no_overlap(values)

    def check_no_overlap(self, values: object) -> None:
        """Raise `BadArgument` for an `out` that shares memory with an input."""
        both = isinstance(self.out, np.ndarray) and isinstance(values, np.ndarray)
        if both and np.may_share_memory(self.out, values):
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
        if (threads is None and count < CROSSOVER) or not has_numba():
            slow = count >= CROSSOVER
            started = time.thread_time() if slow else 0.0  # a call into the system, as long as a single answer
            q, nv = self._checks.posed(arrays[0]), self._nv
            rates = [as_vectors(array, name, nv) for array, name in zip(arrays[1:], _NAMES[1:], strict=False)]
            few = self._kinematics.answer(question, q, *rates).reshape(shape)
            if slow:
                note_slowness(time.thread_time() - started)
            with np.errstate(over="ignore"):
                if out is None:
                    return few.astype(kind, copy=False)
                out[...] = few
            return out
        answers = empty_answers(count, numbers, kind) if out is None else out
        self._by_kernels(question, arrays, answers.reshape(count, math.prod(numbers)), threads)
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
            # The inputs are finite in double precision, but infinite in single precision.
            double = empty_answers(len(answers), answers.shape[1:], _DOUBLE)
            kernels.execute(program, arrays, double, threads)
            with np.errstate(over="ignore"):
                answers[...] = double
        if not peak <= TURN:
            if peak > LARGEST:
                for values, name in zip(arrays[1:], _NAMES[1:], strict=False):
                    as_vectors(values, name, self._nv)
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
        try:
            batch = np.broadcast_shapes(*(array.shape[:-1] for array in arrays))
        except ValueError:
            found = ", ".join(f"{name} {array.shape}" for name, array in zip(_NAMES, arrays, strict=False))
            raise BadArgument(f"configurations and their derivatives must share one batch shape, got {found}") from None
        return [np.broadcast_to(array, (*batch, array.shape[-1])) for array in arrays]
