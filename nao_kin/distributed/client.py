"""A dask client for this machine's cores or for a scheduler elsewhere."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from nao_kin._common.optional import need_extra
from nao_kin._common.scalars import whole_number
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from distributed import Client


def connect(
    address: str | None = None, *, workers: int | None = None, threads_per_worker: int = 1, timeout: float = 30.0
) -> Client:
    """A client of the scheduler at an address, or of worker processes on this machine.

    From then on whatever dask computes runs there, lazy arrays of `nao_kin.distributed` and all others, until the
    client is closed; with it end the workers that were started here. Any other way to make a `distributed.Client` is
    as good. nao_kin must be installed wherever there is a scheduler or a worker, in the same version.

        with nk.distributed.connect("tcp://10.0.0.7:8786"):  # or connect() for this machine
            poses = nk.distributed.fk(nao, q, "LArm").compute()

    A program that starts workers must do so under `if __name__ == "__main__":`, for they import it.

    Args:
        address: of a scheduler, as `dask scheduler` prints it; None to start workers here, which nobody reaches from
            elsewhere.
        workers: how many to start; None for one for each core.
        threads_per_worker: threads of each worker that is started.
        timeout: how long to wait for the scheduler [s].

    Returns:
        The `distributed.Client`, which is a context manager.

    Raises:
        BadArgument: no scheduler answers at the address; workers for a scheduler that has its own; no such numbers.
        MissingExtra: dask is not installed.
    """
    need_extra("nao_kin.distributed", "dask")
    from distributed import Client

    if address is None:
        count = None if workers is None else whole_number(workers, "workers", 1)
        threads = whole_number(threads_per_worker, "threads_per_worker", 1)
        return Client(
            n_workers=count,
            threads_per_worker=threads,
            processes=True,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
        )
    if workers is not None:
        raise BadArgument("workers are started on this machine only: leave out either workers or address")
    try:
        return Client(address, timeout=timeout)
    except (OSError, asyncio.TimeoutError, TypeError, ValueError) as error:
        raise BadArgument(f"no dask scheduler answers at {quoted(address)}: {abbreviated(error)}") from None
