"""A robot on its way to other processes: its bytes travel once in a graph, and are loaded once in each process."""

from __future__ import annotations

import functools
import hashlib
import io
import pickle
import threading
from dataclasses import dataclass, field

from nao_kin.robot import RobotModel

# Robots that a process keeps loaded: one takes milliseconds to load and a few megabytes to keep.
_MOST_KEPT = 8
_LOADING = threading.Lock()


@dataclass(frozen=True)
class PickledRobot:
    """A robot as it was when this was made; two are equal when their robots have equal numbers.

    Loading builds a Pinocchio model, so that a process does it once, whatever the number of chunks, and a scheduler,
    which only passes this on, never.

    Attributes:
        token: what tells the robot from others, the same in every process.
        data: its pickle.
    """

    token: str
    data: bytes = field(repr=False, compare=False)

    @classmethod
    def of(cls, robot: RobotModel) -> PickledRobot:
        """The robot as it is now."""
        return cls(_token(robot), pickle.dumps(robot, pickle.HIGHEST_PROTOCOL))

    def load(self) -> RobotModel:
        """The robot; one for all threads of a process, which may use it at the same time."""
        with _LOADING:  # else all threads of a worker would load it for their first chunks
            return _loaded(self)

    def __dask_tokenize__(self) -> tuple[str, str]:
        return "nao_kin.PickledRobot", self.token


@functools.lru_cache(_MOST_KEPT)
def _loaded(pickled: PickledRobot) -> RobotModel:
    robot: RobotModel = pickle.loads(pickled.data)
    return robot


def _token(robot: RobotModel) -> str:
    """A digest of all that is pickled of a robot, and of nothing else: not of what its parts share in memory.

    dask's own `tokenize` is ten times slower here, and before 2025 puts dictionaries into an order that depends on the
    seed of their hashes.
    """
    written = io.BytesIO()
    pickler = pickle.Pickler(written, protocol=4)
    pickler.fast = True  # every value in full, none as a reference to an equal one before it
    pickler.dump((type(robot).__module__, type(robot).__qualname__, robot.__getstate__()))
    return hashlib.sha256(written.getvalue()).hexdigest()[:32]
