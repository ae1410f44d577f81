"""Who answers a question about configurations: Pinocchio where they are few, the batch kernels where they are many."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from nao_kin._common.arrays import as_floats, as_numbers, refuse_non_finite
from nao_kin._common.compiler import has_numba, note_slowness
from nao_kin._common.scalars import MOST_THREADS, whole_number
from nao_kin._text import quoted
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot.batch_kinematics import CROSSOVER, BatchKinematics, empty_answers
from nao_kin.robot.checks import TURN, ConfigurationChecks
from nao_kin.robot.kinematics import Kinematics
from nao_kin.robot.questions import Question

_DOUBLE, _SINGLE = np.dtype(np.float64), np.dtype(np.float32)
_NAMES = ("q", "v", "a")


@dataclass(frozen=True)
class Output:
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
            return self.out.dtype if isinstance(self.out, np.ndarray) and self.out.dtype == _SINGLE else _DOUBLE
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
