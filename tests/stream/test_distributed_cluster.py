"""Worker processes compute what one process does, also when one of them is killed."""

from __future__ import annotations

import contextlib
import json
import os
import re
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import dask
import dask.array as da
import numpy as np
import pytest
from distributed import Client, futures_of

import nao_kin as nk
from nao_kin import distributed
from nao_kin.errors import BadArgument, NotFinite
from nao_kin.stream import distributed as pickled_robot

ROOT = Path(nk.__file__).parent.parent
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
# Programs of dask's that do what functions of this file say must find it.
TASKS_HERE = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(Path(__file__).parent)])}


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with distributed.connect(workers=2) as client:
        yield client


def _loads() -> tuple[int, int]:
    """How often this process has loaded a robot, and how often it has used one that was loaded."""
    info = pickled_robot._loaded.cache_info()
    return info.misses, info.hits


def _slowly(poses: np.ndarray) -> np.ndarray:
    time.sleep(0.08)
    return poses


def _answers(address: str) -> bool:
    host, port = re.fullmatch(r"tcp://(.*):(\d+)", address).groups()  # type: ignore[union-attr]
    with contextlib.closing(socket.socket()) as probe:
        return probe.connect_ex((host, int(port))) == 0


def _lives(pid: int) -> bool:
    """Return whether a process is running, and not only a zombie that its parent has not waited for."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def _wait_until(condition: Any, seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.mark.full
def test_each_worker_loads_the_robot_once_and_the_scheduler_never(client: Client, nao: nk.NaoModel) -> None:
    q, before = nao.random(0, 3000), client.run_on_scheduler(_loads)
    cut = da.from_array(q, chunks=(50, 9))
    assert np.array_equal(distributed.fk(nao, cut, ["LArm", "Head"]).compute(), nao.fk(q, ["LArm", "Head"], threads=1))
    assert np.array_equal(distributed.com(nao, cut).compute(), nao.com(q, threads=1))
    loaded, used = zip(*client.run(_loads).values(), strict=True)
    assert max(loaded) == 1
    assert sum(loaded) + sum(used) >= 2 * 60  # each chunk of both came by a worker
    assert client.run_on_scheduler(_loads) == before


@pytest.mark.full
def test_programs_that_run_already_do_the_work_though_one_is_killed(nao: nk.NaoModel, tmp_path: Path) -> None:
    q = nao.random(4, 2000)
    here, file = ("--host", "127.0.0.1"), tmp_path / "scheduler.json"
    with contextlib.ExitStack() as stack:
        scheduler = _dask(
            stack, "scheduler", *here, "--port", "0", "--dashboard-address", "127.0.0.1:0", "--scheduler-file", file
        )
        _wait_until(lambda: file.exists() or scheduler.poll() is not None)
        address = json.loads(file.read_text(encoding="utf-8"))["address"]
        victim, _ = (
            _dask(stack, "worker", address, *here, "--nthreads", "1", "--no-nanny", "--no-dashboard") for _ in range(2)
        )
        with distributed.connect(address=address) as client:
            client.wait_for_workers(2, timeout=30)
            lazy = distributed.com(nao, da.from_array(q, chunks=(50, -1)), reference="LFoot").map_blocks(_slowly)
            centres = lazy.persist()
            parts = futures_of(centres)
            _wait_until(lambda: sum(part.done() for part in parts) >= len(parts) // 2)
            victim.kill()
            victim.wait()
            assert np.array_equal(centres.compute(), nao.com(q, reference="LFoot", threads=1))
            assert len(client.run(os.getpid)) == 1
    _wait_until(lambda: not _answers(address))


def _dask(stack: contextlib.ExitStack, *arguments: str | Path) -> subprocess.Popen[bytes]:
    """One of dask's own programs, ended with the stack."""
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    program = stack.enter_context(
        subprocess.Popen([sys.executable, "-m", "dask", *map(str, arguments)], env=TASKS_HERE, **quiet)
    )
    stack.callback(program.kill)
    return program


@pytest.mark.full
def test_an_error_comes_back_from_a_worker_and_nothing_is_left_behind(nao: nk.NaoModel) -> None:
    q = nao.random(3, 200)
    q[130, nao.joint_names.index("HeadYaw")] = np.inf
    with distributed.connect(workers=1) as client:
        workers, address = client.run(os.getpid), client.scheduler.address
        assert _answers(address)
        assert all(_answers(worker) for worker in workers)
        with pytest.raises(NotFinite, match=r"\[30, \d+\] \(HeadYaw\); counted within q\.blocks\[2\]") as caught:
            distributed.position(nao, da.from_array(q, chunks=(50, -1)), "Head").compute()
        assert caught.value.value == np.inf
    _wait_until(lambda: not any(map(_lives, workers.values())))
    assert not _answers(address)
    assert not any(_answers(worker) for worker in workers)


def test_where_no_scheduler_answers_one_line_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(distributed, "_PATIENCE", 0.3)
    before = dask.config.get("scheduler", None)
    with contextlib.closing(socket.socket()) as taken:
        taken.bind(("127.0.0.1", 0))  # and nobody listens
        address = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(BadArgument, match=f"no dask scheduler answers at '{address}': .*"):
            distributed.connect(address)
    with pytest.raises(BadArgument, match="no dask scheduler answers at"):
        distributed.connect("nonsense://there")
    with pytest.raises(BadArgument, match="leave out either workers or address"):
        distributed.connect("tcp://127.0.0.1:1", workers=2)
    assert dask.config.get("scheduler", None) == before  # dask computes where it did


@pytest.mark.full
def test_the_program_of_the_documentation_runs(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "large_files.md").read_text(encoding="utf-8")
    block = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)[-1]
    program = tmp_path / "program.py"
    for shown, fewer in (("1_000_000", "10_000"), ("100_000", "1_000"), ("workers=2", "workers=1")):
        assert shown in block
        block = block.replace(shown, fewer)
    program.write_text(block, encoding="utf-8")
    done = subprocess.run([sys.executable, program], env=ENVIRONMENT, capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr
    assert len(re.findall(r"-?\d+\.\d+", done.stdout)) == 6
    assert done.stderr == ""
