"""Many configurations at once: the questions of a robot as programs for the batch kernels."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from nao_kin import batch
from nao_kin.robot.joint_tree import joint_tree, tree_frame
from nao_kin.robot.model_numbers import ModelNumbers
from nao_kin.robot.questions import Question
from nao_kin.urdf import UrdfTree

# So many configurations, and more, are answered by the kernels. Once these are in memory they are as quick as Pinocchio
# at 16; but reading them takes as long as tens of thousands of configurations, and a handful should not have to wait.
CROSSOVER = 64

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
