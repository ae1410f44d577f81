"""The kernel is compiled once on a machine, says so, and works wherever it cannot be kept."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import nao_kin as nk
from nao_kin._common import kernel_cache

ROOT = Path(nk.__file__).parent.parent
ASK = """
import numpy as np, nao_kin as nk
nao = nk.load_nao()
q = nao.random(0, 40)
ours, pinocchios = nao.fk(q, threads=1), np.array([nao.fk(row) for row in q])
assert abs(ours - pinocchios).max() < 1e-14
print("right")
"""
ANNOUNCED = "nao_kin: compiling the batch kernel (double precision, about ten seconds), once on this machine …\n"


def start(code: str, **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def outcome(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Standard output and standard error of a process that must succeed."""
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    return out, err


def test_two_processes_may_compile_at_once_and_the_third_need_not(tmp_path: Path) -> None:
    both = [start(ASK, NUMBA_CACHE_DIR=str(tmp_path)) for _ in range(2)]
    for process in both:
        out, err = outcome(process)
        assert out == "right\n"
        assert err in ("", ANNOUNCED)
    out, err = outcome(start(ASK, NUMBA_CACHE_DIR=str(tmp_path)))
    assert (out, err) == ("right\n", "")


# The same with a kernel that is compiled in no time.
SMALL = """
import sys
from pathlib import Path
sys.path.insert(0, {folder!r})
import small
from nao_kin._common.kernel_cache import KeptKernel
first, second = (
    KeptKernel(function, "a small kernel", function.__name__, Path({folder!r}), lambda: "float64(float64)")
    for function in (small.doubled, small.halved)
)
assert first(3.0) == 6.0 and second(3.0) == 1.5
print("right")
"""
SAID = "nao_kin: compiling a small kernel, once on this machine …\n"


@pytest.fixture
def small(tmp_path: Path) -> str:
    """A program with two kernels."""
    folder = tmp_path / "sources"
    folder.mkdir()
    (folder / "small.py").write_text("def doubled(x):\n    return 2 * x\n\n\ndef halved(x):\n    return x / 2\n")
    return SMALL.format(folder=str(folder))


def test_a_folder_that_cannot_be_written_costs_one_warning(small: str, tmp_path: Path) -> None:
    occupied = tmp_path / "file"
    occupied.write_text("not a folder")
    out, err = outcome(start(small, NUMBA_CACHE_DIR=str(occupied)))
    assert out == "right\n"
    assert err.count("NotCachedWarning") == 1
    assert err.count("nao_kin: compiling a small kernel …\n") == 1
    assert str(occupied) in err
    assert "NUMBA_CACHE_DIR names another folder" in err
    assert occupied.read_text() == "not a folder"


def test_a_full_disk_costs_one_warning(small: str, tmp_path: Path) -> None:
    code = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (1, 1))\n" + small
    out, err = outcome(start(code, NUMBA_CACHE_DIR=str(tmp_path / "cache")))
    assert out == "right\n"
    assert err.count("NotCachedWarning") == 1
    assert not list(tmp_path.rglob("doubled"))


def test_damaged_files_are_made_anew(small: str, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    assert outcome(start(small, NUMBA_CACHE_DIR=str(cache))) == ("right\n", SAID)
    for ending in ("nbi", "nbc"):
        for path in cache.rglob(f"*.{ending}"):
            path.write_bytes(b"")
        assert outcome(start(small, NUMBA_CACHE_DIR=str(cache))) == ("right\n", SAID)
        assert outcome(start(small, NUMBA_CACHE_DIR=str(cache))) == ("right\n", "")


def test_kernels_are_read_where_nobody_may_write(small: str, tmp_path: Path) -> None:
    """As in the image of a container: from a copy, for Numba reads only where it may write."""
    cache = tmp_path / "cache"
    outcome(start(small, NUMBA_CACHE_DIR=str(cache)))
    kept = {path: path.stat().st_mtime_ns for path in cache.rglob("*")}
    forbidden = "import os\nos.access = lambda *_: False\n"  # root may write everywhere
    assert outcome(start(forbidden + small, NUMBA_CACHE_DIR=str(cache))) == ("right\n", "")
    assert kept == {path: path.stat().st_mtime_ns for path in cache.rglob("*")}


NOWHERE = """
import pathlib, sys
def home():
    raise RuntimeError("Could not determine home directory.")
pathlib.Path.home = home
class Full:
    def write(self, text):
        raise OSError(28, "No space left on device")
    def flush(self):
        pass
sys.stderr = Full()
"""


def test_without_a_home_or_anybody_who_listens_it_works(small: str, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")
    assert outcome(start(NOWHERE + small, **dict.fromkeys(names, ""))) == ("right\n", "")
    for name in names:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", lambda: (_ for _ in ()).throw(RuntimeError("no home")))
    assert nk.batch.cache_folder() is None


def test_what_is_kept_for_one_installation_is_not_taken_for_another(tmp_path: Path) -> None:
    folders = [tmp_path / name for name in "ab"]
    for folder in folders:
        folder.mkdir()
    assert kernel_cache._fingerprint(folders[0]) != kernel_cache._fingerprint(folders[1])
    (folders[0] / "more.py").write_text("x = 1")
    kernel_cache._fingerprint.cache_clear()
    before = kernel_cache._fingerprint(folders[0])
    (folders[0] / "more.py").write_text("x = 2")
    kernel_cache._fingerprint.cache_clear()
    assert kernel_cache._fingerprint(folders[0]) != before


def test_the_kernel_runs_uncompiled_too() -> None:
    code = ASK.replace("random(0, 40)", "random(0, 17)") + UNCOMPILED
    out, err = outcome(start(code, NUMBA_DISABLE_JIT="1", PYTHONWARNINGS="ignore"))
    assert (out, err) == ("right\nall right\n", "")


UNCOMPILED = """
import pinocchio as pin
v = a = np.random.default_rng(0).normal(size=q.shape)
rows = range(len(q))
def same(ours, theirs, tolerance=1e-13):
    assert abs(ours - np.array(theirs)).max() < tolerance
frames = ["LArm", "RLeg", "Head"]
for form in ("matrix", "position_quaternion", "position6d"):
    same(nao.fk(q, frames, as_=form, threads=1), [nao.fk(q[i], frames, as_=form) for i in rows])
same(nao.fk(q, "LArm", reference="Head", threads=1), [nao.fk(q[i], "LArm", reference="Head") for i in rows])
same(nao.fk(q, frames, dtype=np.float32, threads=1), nao.fk(q, frames), 2e-6)
for e in ("mixed", "frame", "root"):
    same(nao.jacobian(q, "LLeg", e, threads=1), [nao.jacobian(q[i], "LLeg", e) for i in rows])
    same(nao.velocity(q, v, "LLeg", e, threads=1), [nao.velocity(q[i], v[i], "LLeg", e) for i in rows])
    rates = [nao.acceleration(q[i], v[i], a[i], "LLeg", e) for i in rows]
    same(nao.acceleration(q, v, a, "LLeg", e, threads=1), rates, 1e-12)
same(nao.com(q, threads=1), [nao.com(q[i]) for i in rows])
same(nao.com_jacobian(q, threads=1), [nao.com_jacobian(q[i]) for i in rows])
far = q + 2 * np.pi * 100_000
same(nao.fk(far, frames, threads=1), nao.fk(q, frames), 1e-9)
floating = nk.load_nao(base="floating")
q = floating.random(0, 17)
same(floating.fk(q, frames, threads=1), [floating.fk(q[i], frames) for i in rows])
same(floating.com(q, threads=1), [floating.com(q[i]) for i in rows])
try:
    nao.fk(np.full((3, nao.nq), np.nan), threads=1)
except nk.errors.NotFinite:
    print("all right")
"""


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_fork_after_use_works(nao: nk.NaoModel) -> None:
    q = nao.random(0, 40_000)
    expected = nao.fk(q, "LArm", threads=2)
    child = os.fork()
    if child == 0:
        os._exit(0 if np.array_equal(nao.fk(q, "LArm", threads=2), expected) else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_a_small_batch_does_not_load_the_compiler() -> None:
    code = (
        "import sys, nao_kin as nk; nao = nk.load_nao(); nao.fk(nao.random(0, nk.robot.CROSSOVER - 1)); "
        "print('numba' in sys.modules)"
    )
    assert outcome(start(code)) == ("False\n", "")


def program(*arguments: str, **environment: str) -> Sequence[str]:
    done = subprocess.run(
        [sys.executable, "-m", "nao_kin", *arguments],
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    return done.stdout, done.stderr


def test_warmup_says_what_is_ready_and_where() -> None:
    program("warmup")
    out, err = program("warmup", "--json")
    kernels = json.loads(out)["kernels"]
    assert err == ""
    precisions = ["double", "double to single", "single"]
    assert [kernel["name"] for kernel in kernels[:3]] == [f"batch kernel, {name} precision" for name in precisions]
    assert [kernel["name"].split(",")[0] for kernel in kernels[3:7]] == ["reach kernel"] * 4
    assert not any(kernel["compiled"] for kernel in kernels)
    assert all(Path(kernel["folder"]).is_dir() for kernel in kernels)
    out, _ = program("warmup")
    assert out.count("found") == len(kernels)


@pytest.mark.parametrize(
    ("environment", "folder"),
    [
        ({"NUMBA_CACHE_DIR": "/a/b"}, "/a/b/nao_kin"),
        ({"XDG_CACHE_HOME": "/c"}, "/c/nao_kin"),
        ({"HOME": "/home/someone"}, "/home/someone/.cache/nao_kin"),
    ],
)
@pytest.mark.skipif(sys.platform == "darwin", reason="the user's caches are elsewhere there")
def test_compiled_kernels_are_kept_in_the_users_cache(
    monkeypatch: pytest.MonkeyPatch, environment: dict[str, str], folder: str
) -> None:
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert nk.batch.cache_folder() == Path(folder)
