"""A run that is cut at any write, as by a power cut, leaves the old file, and goes on to the same bytes."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from loops import full

import nao_kin as nk
from nao_kin.errors import BadArgument
from nao_kin.stream import run, sources

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs a POSIX file system")

ROWS = 90
_CALLS = ("replace", "rename", "unlink", "rmdir", "fsync")


class _File:
    """A file whose writes are counted; the one that is cut writes half of its content."""

    def __init__(self, file: Any, disk: Disk) -> None:
        self._file, self._disk = file, disk

    def write(self, content: Any) -> int:
        half = len(memoryview(content).cast("B")) // 2
        self._disk.count(lambda: self._file.write(memoryview(content).cast("B")[:half]))
        return self._file.write(content)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def __enter__(self) -> _File:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()


class Disk:
    """A folder whose power is cut at one of the calls that change it; no later call has an effect.

    Names change in the order of the calls, as in a journal. The content of a file that has not been synchronised since
    it was written is lost: it is full of zeros.
    """

    def __init__(self, folder: Path, calls: float = float("inf")) -> None:
        self.folder, self.left, self.counted = folder, calls, 0
        self._synced: dict[int, bytes] = {}  # inode → content

    def count(self, torn: Any = None) -> None:
        """Count a call, or fail if the power is off."""
        self.left -= 1
        self.counted += 1
        if self.left < 0:
            if self.left == -1 and torn is not None:
                torn()
            raise OSError("no power")

    @contextmanager
    def running(self) -> Iterator[None]:
        """Count the calls inside the context, and lose at its end what was not synchronised."""
        with pytest.MonkeyPatch.context() as patch:
            for name in _CALLS:
                patch.setattr(os, name, self._counted(getattr(os, name), name))
            opened = io.open

            def open_(file: Any, mode: str = "r", *arguments: Any, **options: Any) -> Any:
                opening = opened(file, mode, *arguments, **options)
                ours = "w" in mode and str(file).startswith(str(self.folder))
                return _File(opening, self) if ours else opening

            patch.setattr(io, "open", open_)
            yield
        if self.left < 0:
            for path in self.folder.rglob("*"):
                if path.is_file():
                    content = path.read_bytes()
                    if self._synced.get(path.stat().st_ino) != content:
                        path.write_bytes(bytes(len(content)))

    def _counted(self, call: Any, name: str) -> Any:
        def counted(*arguments: Any, **options: Any) -> Any:
            self.count()
            done = call(*arguments, **options)
            if name == "fsync":
                path = Path(f"/proc/self/fd/{arguments[0]}")
                self._synced[path.stat().st_ino] = path.read_bytes()
            return done

        return counted


@pytest.fixture
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sources, "ROWS_AT_ONCE", 20)
    monkeypatch.setattr(run, "_BLOCKS_OF_PART", 2)


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")
@pytest.mark.parametrize("sink", ["csv", *full("npy", "parquet", "arrow")])
def test_a_run_that_is_cut_at_any_write_leaves_the_old_file_and_goes_on_to_the_same_bytes(
    nao: nk.NaoModel, tmp_path: Path, small_parts: None, sink: str
) -> None:
    source = tmp_path / "q.npy"
    np.save(source, nao.random(0, ROWS))
    whole = tmp_path / f"whole.{sink}"

    def poses(path: Path) -> int:
        return nk.stream.fk(nao, source, path, frame=["LArm"], as_="rpy", overwrite=True).rows_resumed

    poses(whole)
    expected = whole.read_bytes()
    resumed, call = [], 0
    while True:
        folder = tmp_path / f"cut{call}"
        folder.mkdir()
        path = folder / f"poses.{sink}"
        path.write_bytes(b"old")
        disk = Disk(folder, call)
        disk._synced[path.stat().st_ino] = b"old"
        with disk.running():
            try:
                poses(path)
            except BadArgument:
                assert disk.left < 0
        assert path.read_bytes() in (b"old", expected)
        if disk.left >= 0:
            break
        resumed.append(poses(path) if path.read_bytes() == b"old" else ROWS)
        assert path.read_bytes() == expected
        call += 1
    assert path.read_bytes() == expected
    # Every later cut finds at least the rows of every earlier one, part after part.
    assert resumed == sorted(resumed)
    assert sorted({*resumed}) == [0, 40, 80, ROWS]
