"""The robot's methods over dask arrays, on one machine or on many.

Needs the extra `dask`: pip install nao-kin[dask].
"""

from __future__ import annotations

import asyncio
import functools
import inspect
import math
import pickle
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec

import numpy as np
from numpy.typing import DTypeLike, NDArray

from nao_kin._core.arrays import float_dtype
from nao_kin._core.guesses import public_attributes as _public_attributes
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import need_extra
from nao_kin.errors import BadArgument, NaoKinError, WrongShape
from nao_kin.robot import RobotModel
from nao_kin.stream.parts import digest_of

if TYPE_CHECKING:
    from dask.array import Array
    from distributed import Client

__all__ = ["acceleration", "com", "com_jacobian", "connect", "fk", "jacobian", "position", "rotation", "velocity"]

globals().update(_public_attributes(__name__))


# --- A dask client for this machine's cores or for a scheduler elsewhere.

# Longest time to wait for a scheduler [s].
_PATIENCE = 30.0


def connect(address: str | None = None, *, workers: int | None = None) -> Client:
    """Return a client of the scheduler at an address, or of new worker processes on this machine.

    From then on dask computes all lazy arrays there until the client is closed, which also ends the new workers. Any
    other `distributed.Client` works as well. nao_kin must be installed in the same version on all machines.

        with nk.distributed.connect("tcp://10.0.0.7:8786"):  # or connect() for this machine
            poses = nk.distributed.fk(nao, q, "LArm").compute()

    A program that starts workers must do so under `if __name__ == "__main__":`, because the workers import the program.

    Args:
        address: address of a scheduler, as printed by `dask scheduler`; None starts workers that only this machine can
            reach.
        workers: number of workers to start; None for one for each core.

    Returns:
        The `distributed.Client`, which is a context manager.

    Raises:
        BadArgument: no scheduler answers at the address; both an address and workers.
        MissingExtra: dask is not installed.
    """
    need_extra("nao_kin.distributed", "dask")
    from distributed import Client

    if address is None:
        return Client(
            n_workers=workers, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address="127.0.0.1:0"
        )
    if workers is not None:
        raise BadArgument("workers are started on this machine only: leave out either workers or address")
    try:
        # A default client that fails to connect would remain dask's scheduler: another one tries first.
        Client(address, timeout=_PATIENCE, set_as_default=False).close()
        return Client(address, timeout=_PATIENCE)
    except (OSError, asyncio.TimeoutError, TypeError, ValueError) as error:
        raise BadArgument(f"no dask scheduler answers at {quoted(address)}: {abbreviated(error)}") from None


# --- A robot for other processes: its bytes are sent once in a graph, and loaded once in each process.

# Robots in the cache of a process: one takes milliseconds to load and a few megabytes.
_MAX_LOADED = 8
_LOADING = threading.Lock()


@dataclass(frozen=True)
class PickledRobot:
    """A copy of a robot; two are equal if their robots have equal numbers.

    Loading builds a Pinocchio model. Each process does this once for all chunks; a scheduler only passes the bytes on.
    """

    token: str  # identifies the robot, the same in every process
    data: bytes = field(repr=False, compare=False)

    @classmethod
    def of(cls, robot: RobotModel) -> PickledRobot:
        """Pickle a robot."""
        return cls(digest_of(robot), pickle.dumps(robot, pickle.HIGHEST_PROTOCOL))

    def load(self) -> RobotModel:
        """Return the robot, which all threads of a process may use at the same time."""
        with _LOADING:  # otherwise each thread of a worker would load it for its first chunk
            return _loaded(self)

    def __dask_tokenize__(self) -> tuple[str, str]:
        return "nao_kin.PickledRobot", self.token


@functools.lru_cache(_MAX_LOADED)
def _loaded(pickled: PickledRobot) -> RobotModel:
    robot: RobotModel = pickle.loads(pickled.data)
    return robot


# --- The robot's methods as lazy functions of dask arrays, chunk by chunk.

_Options = ParamSpec("_Options")
# The robot's arguments that have no meaning for an array that does not exist yet.
_EAGER = ("limits", "out", "threads")
_INPUTS = ("q", "v", "a")


def _lazily(
    method: Callable[Concatenate[Any, _Options], NDArray[Any]], what: str, example: str, shape: tuple[int, ...]
) -> Callable[Concatenate[RobotModel, _Options], Array]:
    """Return a method of the robot as a function of dask arrays."""
    name, signature = method.__name__, inspect.signature(method)
    kept = [parameter for parameter in signature.parameters.values() if parameter.name not in _EAGER]
    signature = signature.replace(
        parameters=[kept[0].replace(name="robot", annotation="RobotModel"), *kept[1:]], return_annotation="Array"
    )

    def lazy(*args: Any, **kwargs: Any) -> Array:  # noqa: D417, the arguments of the method
        """Return {what}, lazily: `RobotModel.{name}` of every chunk.

        Names are checked now, configurations when they are computed. Later changes of the robot have no effect. The
        results are those of a single process, bit for bit, for any chunks of q.

        Args:
            robot: any robot.
            q: configurations, a dask array of shape (..., nq) and any chunks, also of unknown length; the chunks of the
                last axis are joined. v and a, where the method takes them, are dask arrays with the leading axes of q.
            dtype: float32 or float64; None for that of q, or float64 if q is neither.

        All other arguments are those of the method, without limits, out and threads.

        Returns:
            A dask array of the shape that the method returns, with the chunks of q.

        Raises:
            MissingExtra: dask is not installed.
            NotFinite: when computed; the message names the block of q.

        Examples:
            >>> import dask.array as da
            >>> nao = nk.load_nao()
            >>> q = da.from_array(nao.random(rng=0, n=6), chunks=(3, -1))
            >>> nk.distributed.{name}(nao, q{example}).shape
            {shape}
        """
        given = signature.bind(*args, **kwargs).arguments
        robot, inputs = given.pop("robot"), [given.pop(name) for name in _INPUTS if name in given]
        return _mapped(robot, name, *inputs, dtype=given.pop("dtype", None), **given)

    lazy.__name__ = lazy.__qualname__ = name
    lazy.__doc__ = inspect.cleandoc(str(lazy.__doc__)).format(name=name, what=what, example=example, shape=shape)
    lazy.__signature__ = signature  # type: ignore[attr-defined]
    return lazy


_HAND = ', "LArm"'
fk = _lazily(RobotModel.fk, "poses of frames", _HAND, (6, 4, 4))
rotation = _lazily(RobotModel.rotation, "rotations of frames", _HAND, (6, 3, 3))
position = _lazily(RobotModel.position, "positions of frame origins", ', ["LArm", "RArm"]', (6, 2, 3))
jacobian = _lazily(RobotModel.jacobian, "geometric Jacobians of a frame", _HAND, (6, 6, 25))
velocity = _lazily(RobotModel.velocity, "twists of frames", ', 0 * q, "LArm"', (6, 6))
acceleration = _lazily(RobotModel.acceleration, "derivatives of `velocity`", ', 0 * q, 0 * q, "LArm"', (6, 6))
com = _lazily(RobotModel.com, "centres of mass", "", (6, 3))
com_jacobian = _lazily(RobotModel.com_jacobian, "Jacobians of the centre of mass", "", (6, 3, 25))


def _mapped(
    robot: RobotModel, method: str, q: Array, *rates: Array, dtype: DTypeLike | None, **arguments: Any
) -> Array:
    """Return the dask array of a method's results, with one task for each chunk of q and of the rates."""
    need_extra("nao_kin.distributed", "dask", "dask.array")
    from dask.array import map_blocks
    from dask.delayed import delayed
    from dask.tokenize import tokenize

    q = _checked(q, robot.nq, "q")
    rates = tuple(_along(q, _checked(rate, robot.nv, name), name) for rate, name in zip(rates, "va", strict=False))
    result_dtype = float_dtype(q.dtype if dtype is None and q.dtype == np.float32 else dtype)
    # A call without configurations checks the other arguments, and shows the shape of the result.
    none = [np.empty((0, length)) for length in (robot.nq, *(robot.nv for _ in rates))]
    tail = _chunk(robot, none, method, arguments, result_dtype).shape[1:]
    batch = q.ndim - 1
    pickled = PickledRobot.of(robot)
    # Keep several names as a tuple, which cannot change before its use.
    settled = tuple(
        (name, value if isinstance(value, str) or not isinstance(value, Sequence) else tuple(value))
        for name, value in sorted(arguments.items())
    )
    # A separate key in the graph: otherwise every task would carry the robot.
    shared = delayed(pickled, name=f"nao_kin-robot-{pickled.token}", traverse=False)
    return map_blocks(
        _block,
        q,
        shared,
        method,
        settled,
        result_dtype,
        *rates,
        name=f"nao_kin-{method}-{tokenize(pickled, q, *rates, settled, result_dtype)}",
        dtype=result_dtype,
        meta=np.empty((0,) * (batch + len(tail)), result_dtype),
        chunks=(*q.chunks[:-1], *((length,) for length in tail)),
        drop_axis=batch,
        new_axis=list(range(batch, batch + len(tail))),
    )


def _block(
    q: NDArray[Any],
    pickled: PickledRobot,
    method: str,
    arguments: tuple[tuple[str, Any], ...],
    dtype: np.dtype[Any],
    *rates: NDArray[Any],
    block_id: tuple[int, ...],
) -> NDArray[Any]:
    """Compute one chunk, in any process."""
    try:
        return _chunk(pickled.load(), (q, *rates), method, dict(arguments), dtype)
    except NaoKinError as error:
        error.args = (f"{error}; counted within q.blocks{list(block_id[: q.ndim - 1])}",)
        raise


def _chunk(
    robot: RobotModel, inputs: Sequence[NDArray[Any]], method: str, arguments: Mapping[str, Any], dtype: np.dtype[Any]
) -> NDArray[Any]:
    """Return the result of a method for one chunk."""
    # With kernels a configuration has the same bits in every chunk. A chunk without rows does not load them.
    answer: NDArray[Any] = getattr(robot, method)(
        *inputs, **arguments, dtype=dtype, threads=1 if inputs[0].size else None
    )
    return answer


def _checked(values: Array, length: int, name: str) -> Array:
    """Return a dask array with all numbers of a row in one chunk."""
    if values.ndim == 0 or values.shape[-1] != length:
        unknown = values.ndim > 0 and math.isnan(values.shape[-1])
        raise WrongShape(
            name,
            f"(..., {length})",
            f"an unknown last axis: call {name}.compute_chunk_sizes()" if unknown else values.shape,
        )
    return values if values.numblocks[-1] == 1 else values.rechunk({values.ndim - 1: -1})


def _along(q: Array, rates: Array, name: str) -> Array:
    """Return velocities or accelerations with the chunks of the configurations."""
    if rates.chunks[:-1] == q.chunks[:-1]:
        return rates
    if rates.shape[:-1] != q.shape[:-1]:
        raise WrongShape(name, f"({', '.join(map(str, q.shape[:-1]))}, {rates.shape[-1]})", rates.shape)
    return rates.rechunk((*q.chunks[:-1], (rates.shape[-1],)))
