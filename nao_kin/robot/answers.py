"""Who answers a question about configurations: Pinocchio where they are few, the batch kernels where they are many."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, SupportsIndex

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, DTypeLike, NDArray

from nao_kin import _kernels as batch
from nao_kin._core.arrays import MOST_THREADS, as_floats, as_numbers, refuse_non_finite, whole_number
from nao_kin._core.text import quoted
from nao_kin._kernels import JointTree, TreeFrame, TreeJoint
from nao_kin._kernels.cache import has_numba, note_slowness
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot.build import ModelNumbers
from nao_kin.robot.checks import TURN, ConfigurationChecks
from nao_kin.robot.kinematics import Kinematics, Question
from nao_kin.robot.urdf import UrdfTree

# --- The joints of a Pinocchio model as the batch kernels take them.


def joint_tree(model: pin.Model, tree: UrdfTree) -> JointTree:
    """The joints of a model that `build_model` made of this tree."""
    joints: list[TreeJoint] = []
    drivers: dict[str, pin.JointModel] = {}
    moving = list(tree.moving_joints)
    first = model.njoints - len(moving)  # 2 where a floating base comes before them
    for index in range(1, model.njoints):
        placement, inertia = model.jointPlacements[index], model.inertias[index]
        own = model.joints[index]
        kind, axis, ratio, offset = "free", (1.0, 0.0, 0.0), 1.0, 0.0
        if index >= first:
            row = moving[index - first]
            kind, axis = row.kind, row.axis
            if row.mimic is None:
                drivers[row.name] = own
            else:
                own, ratio, offset = drivers[row.mimic.joint], row.mimic.multiplier, row.mimic.offset
        joints.append(
            TreeJoint(
                kind=kind,
                parent=int(model.parents[index]) - 1,
                R=np.array(placement.rotation),
                t=np.array(placement.translation),
                axis=axis,
                coordinate=int(own.idx_q),
                velocity=int(own.idx_v),
                ratio=ratio,
                offset=offset,
                mass=float(inertia.mass),
                moment=tuple((inertia.mass * inertia.lever).tolist()),
            )
        )
    held = model.inertias[0]
    return JointTree(
        int(model.nq), int(model.nv), tuple(joints), float(held.mass), tuple((held.mass * held.lever).tolist())
    )


def tree_frame(model: pin.Model, frame_id: int) -> TreeFrame:
    """A frame of the model by the joint that holds it."""
    frame = model.frames[frame_id]
    return TreeFrame(
        int(frame.parentJoint) - 1, np.array(frame.placement.rotation), np.array(frame.placement.translation)
    )


# --- Many configurations at once: the questions of a robot as programs for the batch kernels.

# So many configurations, and more, are answered by the kernels. Once these are in memory they are as quick as Pinocchio
# at 3 to 8; but reading them takes as long as tens of thousands of configurations, and a handful should not wait.
CROSSOVER = 32

# Programs that are kept: more than anyone asks for in turn.
_MOST_PROGRAMS = 256


class BatchKinematics:
    """What the joints of a model answer for many configurations. May be called from several threads at once."""

    def __init__(self, model: pin.Model, tree: UrdfTree) -> None:
        self._model, self._urdf = model, tree
        self._lock = threading.Lock()
        self._numbers: ModelNumbers | None = None
        self._programs: dict[Question, batch.Program] = {}
        self._tree: batch.JointTree | None = None

    def answer(
        self, question: Question, inputs: Sequence[NDArray[Any]], out: NDArray[Any], threads: int | None
    ) -> float:
        """Answer a question about configurations, and velocities and accelerations where it needs them.

        Args:
            question: what is asked.
            inputs: arrays of one batch shape, (..., nq), (..., nv), (..., nv), in any layout and precision; unchecked.
            out: the answers, contiguous, shape (n, numbers).
            threads: how many threads; None for as many as there are cores, if that is worthwhile.

        Returns:
            The largest magnitude among the inputs: NaN or infinity if there is one, and then the answers mean nothing.
        """
        return batch.execute(self._program(question), inputs, out, threads)

    def _program(self, question: Question) -> batch.Program:
        with self._lock:
            if self._numbers is None or self._tree is None or self._numbers.changed():
                self._numbers, self._tree = ModelNumbers(self._model), joint_tree(self._model, self._urdf)
                self._programs.clear()
            program = self._programs.get(question)
            if program is None:
                if len(self._programs) >= _MOST_PROGRAMS:
                    self._programs.clear()
                program = self._programs[question] = self._made(question, self._tree)
            return program

    def _made(self, question: Question, tree: batch.JointTree) -> batch.Program:
        frames = [tree_frame(self._model, frame_id) for frame_id in question.frame_ids]
        reference = None if question.reference_id is None else tree_frame(self._model, question.reference_id)
        make: dict[str, Callable[[], batch.Program]] = {
            "poses": lambda: batch.poses_program(tree, frames, reference, question.form),
            "jacobian": lambda: batch.jacobian_program(tree, frames[0], question.form),
            "com": lambda: batch.com_program(tree, reference),
            "com_jacobian": lambda: batch.com_jacobian_program(tree),
            "velocity": lambda: batch.motion_program(tree, frames, question.form, 1),
            "acceleration": lambda: batch.motion_program(tree, frames, question.form, 2),
        }
        return make[question.kind]()


def empty_answers(count: int, numbers: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Memory for answers, shape (count, *numbers), that begins where a vector can be written at once."""
    return batch.aligned_empty(count * math.prod(numbers), dtype).reshape(count, *numbers)


# --- Who answers a question about configurations: Pinocchio where they are few, the batch kernels where they are many.

_DOUBLE, _SINGLE = np.dtype(np.float64), np.dtype(np.float32)
_NAMES = ("q", "v", "a")


class Output(NamedTuple):
    """How a result is wanted.

    Attributes:
        dtype: its precision; None for that of `out`, or float64.
        out: where to write it; None for a fresh array.
        threads: how many threads may work on it; None for as many as are worthwhile.
    """

    dtype: DTypeLike | None = None
    out: NDArray[Any] | None = None
    threads: SupportsIndex | None = None

    def precision(self) -> np.dtype[Any]:
        """The precision of the result.

        Raises:
            BadArgument: neither single nor double.
        """
        if self.dtype is None:
            single = self.out is not None and isinstance(self.out, np.ndarray) and self.out.dtype == _SINGLE
            return _SINGLE if single else _DOUBLE
        for kind in (_DOUBLE, _SINGLE):
            try:
                if kind == self.dtype:
                    return kind
            except (TypeError, ValueError):  # no name of a type at all
                break
        raise BadArgument(f"dtype must be float64 or float32, got {quoted(self.dtype)}")

    def check(self, shape: tuple[int, ...], kind: np.dtype[Any], inputs: Sequence[NDArray[Any]]) -> None:
        """Refuse an `out` that cannot take the result.

        Raises:
            BadArgument: another precision or layout, not writable, or in the memory of an input.
            WrongShape: another shape.
        """
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
            self.check_apart(values)

    def check_apart(self, values: object) -> None:
        """Refuse an `out` that is in the memory of an input.

        Raises:
            BadArgument: it is.
        """
        both = isinstance(self.out, np.ndarray) and isinstance(values, np.ndarray)
        if both and np.may_share_memory(self.out, values):
            raise BadArgument("out must not be in the memory of an input")


class Answers:
    """The answers of one robot."""

    def __init__(
        self, kinematics: Kinematics, batch: BatchKinematics, checks: ConfigurationChecks, nq: int, nv: int
    ) -> None:
        self._kinematics, self._batch, self._checks = kinematics, batch, checks
        self._nq, self._nv = nq, nv

    def answer(
        self, question: Question, inputs: Sequence[ArrayLike], output: Output, *, one: bool = False
    ) -> NDArray[Any]:
        """The answer to a question.

        Args:
            question: what is asked.
            inputs: q, or q and v, or q, v and a; with leading batch axes that broadcast.
            output: how it is wanted.
            one: leave out the axis of the frames, of which there is one.

        Raises:
            WrongShape, NotFinite, BadArgument: as the methods of `RobotModel` say.
        """
        kind = output.precision()
        threads = None if output.threads is None else whole_number(output.threads, "threads", 1, MOST_THREADS)
        arrays = self._arrays(inputs)
        batch, numbers = arrays[0].shape[:-1], question.shape(self._nv)
        shape = (*batch, *(numbers[1:] if one else numbers))
        output.check(shape, kind, arrays)
        if question.kind in ("com", "com_jacobian"):
            self._kinematics.check_mass()
        count, out = math.prod(batch), output.out
        if (threads is None and count < CROSSOVER) or not has_numba():
            started = time.thread_time()
            few = self._by_pinocchio(question, arrays).reshape(shape)
            if count >= CROSSOVER:
                note_slowness(time.thread_time() - started)
            with np.errstate(over="ignore"):
                if out is None:
                    return few.astype(kind, copy=False)
                out[...] = few
            return out
        answers = empty_answers(count, numbers, kind) if out is None else out
        self._by_kernels(question, arrays, answers.reshape(count, math.prod(numbers)), threads)
        return answers.reshape(shape) if out is None else out

    def _by_pinocchio(self, question: Question, arrays: Sequence[NDArray[Any]]) -> NDArray[Any]:
        q = self._checks.posed(arrays[0])
        rates = [as_floats(array, (self._nv,), name) for array, name in zip(arrays[1:], _NAMES[1:], strict=False)]
        return self._kinematics.answer(question, q, *rates)

    def _by_kernels(
        self, question: Question, arrays: Sequence[NDArray[Any]], answers: NDArray[Any], threads: int | None
    ) -> None:
        self._checks.check_base(arrays[0])
        peak = self._batch.answer(question, arrays, answers, threads)
        if not math.isfinite(peak):
            self._checks.refuse_non_finite(arrays[0])
            for values, name in zip(arrays[1:], _NAMES[1:], strict=False):
                refuse_non_finite(values, name)
            # Finite numbers that are infinite in single precision.
            double = empty_answers(len(answers), answers.shape[1:], _DOUBLE)
            self._batch.answer(question, arrays, double, threads)
            with np.errstate(over="ignore"):
                answers[...] = double
        if not peak <= TURN:
            self._checks.warn_of_degrees(arrays[0])

    def _arrays(self, inputs: Sequence[ArrayLike]) -> list[NDArray[Any]]:
        """The inputs as arrays of numbers of one batch shape, not looked at."""
        arrays = []
        for value, length, name in zip(inputs, (self._nq, self._nv, self._nv), _NAMES, strict=False):
            # Single precision stays what it is, to be converted where it is used.
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
