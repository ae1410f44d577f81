"""The kernel is compiled once on a machine, says so, and works wherever it cannot be kept."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from forked import Forks, forks
from loops import full

import nao_kin as nk
from nao_kin._kernels import cache as kernel_cache
from nao_kin._kernels.folder import private_folder, read_file, write_file

ROOT = Path(nk.__file__).parent.parent
ASK = """
import numpy as np, nao_kin as nk
nao = nk.load_nao()
q = nao.random(0, 40)
ours, pinocchios = nao.fk(q, threads=1), np.array([nao.fk(row) for row in q])
assert abs(ours - pinocchios).max() < 1e-14
print("right")
"""


def start(code: str, *arguments: str | Path, **environment: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", code, *arguments],
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


# Kernels that are compiled in no time.
SMALL = """
import sys
from pathlib import Path
sys.path.insert(0, {folder!r})
import small
from nao_kin._kernels.cache import CachedKernel
first, second = (
    CachedKernel(function, "a small kernel", function.__name__, lambda: "float64(float64)")
    for function in (small.doubled, small.halved)
)
assert first(3.0) == 6.0 and second(3.0) == 1.5
print("right")
"""
SAID = "nao_kin: compiling a small kernel (about 10 s), once on this machine …\n"
WAITING = "nao_kin: waiting for another process that compiles a small kernel (about 10 s) …\n"


KERNELS = """
SHARE = 0.5


def doubled(x):
    return 2 * x


def halved(x):
    return SHARE * x
"""


@pytest.fixture
def small(tmp_path: Path) -> str:
    """A program with two kernels."""
    folder = tmp_path / "sources"
    folder.mkdir()
    (folder / "small.py").write_text(KERNELS)
    return SMALL.format(folder=str(folder))


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forks]:
    """A process that has loaded the compiler."""
    imports = "import numba, nao_kin._kernels.cache\nnumba.njit('float64(float64)')(lambda x: x)"
    with forks(imports, tmp_path_factory.mktemp("programs")) as programs:
        yield programs


# Waits until three programs are about to need the kernel.
TOGETHER = """
import os, time
Path(os.environ["READY"], str(os.getpid())).touch()
while len(os.listdir(os.environ["READY"])) < 3:
    time.sleep(0.01)
"""


@pytest.mark.full
def test_of_processes_that_need_a_kernel_at_once_one_compiles_it_and_the_next_need_not(
    programs: Forks, small: str, tmp_path: Path
) -> None:
    (tmp_path / "ready").mkdir()
    where = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "READY": str(tmp_path / "ready")}
    alone = small.replace(" and second(3.0) == 1.5", "")
    together = alone.replace("assert first", f"{TOGETHER}assert first")
    outcomes = [outcome(each) for each in [start(together, **where) for _ in range(3)]]
    assert [out for out, _ in outcomes] == ["right\n"] * 3
    said = [err for _, err in outcomes]
    assert said.count(SAID) == 1
    assert set(said) <= {SAID, WAITING, ""}
    assert programs.run(alone, cwd=tmp_path, **where) == (0, "right\n", "")


def test_a_folder_that_cannot_be_written_costs_one_warning(programs: Forks, small: str, tmp_path: Path) -> None:
    occupied = tmp_path / "file"
    occupied.write_text("not a folder")
    code, out, err = programs.run(small, cwd=tmp_path, NUMBA_CACHE_DIR=str(occupied))
    assert (code, out) == (0, "right\n")
    assert err.count("NotCachedWarning") == 1
    assert err.count("nao_kin: compiling a small kernel (about 10 s) …\n") == 1
    assert str(occupied) in err
    assert "set NUMBA_CACHE_DIR to a folder that only you can write to" in err
    assert occupied.read_text() == "not a folder"


@pytest.mark.full
def test_a_full_disk_costs_one_warning(small: str, tmp_path: Path) -> None:
    code = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (1, 1))\n" + small
    out, err = outcome(start(code, NUMBA_CACHE_DIR=str(tmp_path / "cache")))
    assert out == "right\n"
    assert err.count("NotCachedWarning") == 1
    assert not list(tmp_path.rglob("*.kernel*"))


@pytest.mark.full
def test_damaged_files_are_made_anew(programs: Forks, small: str, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    assert programs.run(small, cwd=tmp_path, NUMBA_CACHE_DIR=str(cache)) == (0, "right\n", SAID)
    for damage in (lambda content: b"", lambda content: content[:-100], lambda content: content[:9] + content):
        for path in cache.rglob("*.kernel"):
            path.write_bytes(damage(path.read_bytes()))
        assert programs.run(small, cwd=tmp_path, NUMBA_CACHE_DIR=str(cache)) == (0, "right\n", SAID)
        assert programs.run(small, cwd=tmp_path, NUMBA_CACHE_DIR=str(cache)) == (0, "right\n", "")


@pytest.mark.full
def test_kernels_are_read_where_nobody_may_write(programs: Forks, small: str, tmp_path: Path) -> None:
    """As in the image of a container."""
    cache = tmp_path / "cache"
    programs.run(small, cwd=tmp_path, NUMBA_CACHE_DIR=str(cache))
    kept = {path: path.stat().st_mtime_ns for path in cache.rglob("*")}
    forbidden = """
import os
def refused(*_, **__):
    raise OSError(30, "Read-only file system")
def reading(path, flags, *rest, open=os.open, **where):
    return refused() if flags & (os.O_WRONLY | os.O_RDWR) else open(path, flags, *rest, **where)
os.open, os.utime = reading, refused  # root may write everywhere
"""
    assert programs.run(forbidden + small, cwd=tmp_path, NUMBA_CACHE_DIR=str(cache)) == (0, "right\n", "")
    assert kept == {path: path.stat().st_mtime_ns for path in cache.rglob("*")}


def test_kernels_that_nobody_has_used_for_a_month_are_removed(tmp_path: Path) -> None:
    first, second, third, other = "0" * 16 + ".kernel", "1" * 16 + ".kernel", "2" * 16 + ".kernel", "notes.txt"

    def age(name: str, days: float) -> None:
        then = time.time() - 86400 * days
        os.utime(tmp_path / "nao_kin" / name, (then, then))

    with private_folder(tmp_path / "nao_kin") as folder:
        for name in (first, second, other):
            write_file(folder, name, b"")
            age(name, 29 if name == first else 31)
        assert read_file(folder, first) == b""  # which counts as its use
        write_file(folder, third, b"")
        assert sorted(os.listdir(folder)) == [first, third, other]


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


def test_without_a_home_or_anybody_who_listens_it_works(
    programs: Forks, small: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")
    nowhere = dict.fromkeys(names, "")
    assert programs.run(NOWHERE + small, cwd=tmp_path, **nowhere) == (0, "right\n", "")
    for name in names:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", lambda: (_ for _ in ()).throw(RuntimeError("no home")))
    assert nk.cache_folder() is None


@pytest.mark.full
def test_a_changed_comment_costs_no_compilation_and_a_changed_constant_does(
    programs: Forks, small: str, tmp_path: Path
) -> None:
    cache, source = tmp_path / "cache", tmp_path / "sources" / "small.py"
    ask = small.replace("== 6.0", "> 0.0").replace("== 1.5", "> 0.0")
    assert programs.run(ask, cwd=tmp_path, NUMBA_CACHE_DIR=str(cache)) == (0, "right\n", SAID)
    kept = sorted(cache.rglob("*"))
    source.write_text('"""What this is."""\n# A comment.\n' + KERNELS.replace("(x):", '(x):\n    """Say it."""'))
    assert programs.run(ask, cwd=tmp_path, NUMBA_CACHE_DIR=str(cache)) == (0, "right\n", "")
    assert sorted(cache.rglob("*")) == kept
    source.write_text(KERNELS.replace("0.5", "0.25"))
    changed = small.replace("1.5", "0.75")
    assert programs.run(changed, cwd=tmp_path, NUMBA_CACHE_DIR=str(cache)) == (0, "right\n", SAID)


# A kernel, what it calls and what that calls, each in a module of its own.
CHAIN = {
    "first.py": "from factory import made\nfrom second import Numbers, middle\n"
    "def solve(x: Numbers):\n    return middle(x.one)\nkernel = made(solve)\n",
    "factory.py": "def made(solve):\n    def run(x):\n        return 2.0 * solve(x)\n"
    "    run.__module__ = solve.__module__\n    return run\n",
    "second.py": "from typing import NamedTuple\nfrom third import LENGTHS, last\n"
    "class Numbers(NamedTuple):\n    one: float\n"
    "def middle(x):\n    return [last(y) for y in (x, LENGTHS[0])][0]\n",
    "third.py": "import numpy as np\nLENGTHS = np.array([1.0, 2.0])\ndef last(x):\n    return x + 1.0\n",
    "fourth.py": "def unrelated(x):\n    return x\n",
}
FINGERPRINTS = """
import importlib, sys
from nao_kin._kernels import folder
for path in sys.argv[1:]:
    for name in [name for name in sys.modules if name.startswith("made_up")]:
        del sys.modules[name]
    folder._tree.cache_clear()
    sys.path.insert(0, path)
    print(folder.fingerprint(importlib.import_module("made_up.first").kernel, "kernel"))
"""
CHANGES = [
    ("first.py", "", "", False),
    ("first.py", "x.one", "-x.one", True),
    ("factory.py", "2.0 *", "3.0 *", True),
    ("second.py", "middle(x):", "middle(x):  # quick", False),
    ("second.py", "[0]\n", "[1]\n", True),
    ("second.py", "one: float", "one: float; two: float", True),
    ("third.py", "x + 1.0", "x + 1.5", True),
    ("third.py", "2.0]", "2.5]", True),
    ("third.py", "last(x):", 'last(x):\n    """Add one."""', False),
    ("fourth.py", "return x", "return -x", False),
]


@pytest.mark.full
def test_a_fingerprint_depends_on_all_that_a_kernel_calls_and_on_nothing_else(tmp_path: Path) -> None:
    folders = []
    for number, (file, old, new, _) in enumerate(CHANGES):
        folders.append(tmp_path / str(number))
        (folders[-1] / "made_up").mkdir(parents=True)
        for name, text in CHAIN.items():
            source = re.sub(r"^from (second|third|factory) ", r"from made_up.\1 ", text, flags=re.MULTILINE)
            if name == file:
                assert old in source
                source = source.replace(old, new)
            (folders[-1] / "made_up" / name).write_text(source)
    (first, *others), again = (
        outcome(start(FINGERPRINTS, *folders, PYTHONHASHSEED=seed))[0].split() for seed in ("1", "2")
    )
    assert [first, *others] == again
    assert [digest != first for digest in others] == [counts for *_, counts in CHANGES[1:]]


# A kernel that is quicker to run as Python once than to compile, in a program that ends at once.
SLOW_KERNEL = """
from nao_kin._kernels.cache import CachedKernel


def total(values):
    result = 0.0
    for i in range(200_000):
        result += values[i % len(values)]
    values[0] = result


def row():
    from numba import types

    return (types.float64[::1],)


kernel = CachedKernel(total, "a slow kernel", "total", row)
"""
ONE_ROW = """
import sys
sys.path.insert(0, {folder!r})
import numpy as np, slow
from nao_kin._kernels.cache import first_rows
values = np.ones(3)
print(first_rows([slow.kernel], lambda part: slow.kernel.uncompiled(values), 1), values[0], "numba" in sys.modules)
"""
BACKGROUND = "nao_kin: compiling a slow kernel (about 10 s) in the background, once on this machine …\n"


@pytest.fixture
def slow(tmp_path: Path) -> str:
    """A program that needs one row of a kernel."""
    folder = tmp_path / "sources"
    folder.mkdir()
    (folder / "slow.py").write_text(SLOW_KERNEL)
    return ONE_ROW.format(folder=str(folder))


def has_a_kernel(cache: Path) -> bool:
    """Return whether a compiled kernel comes to be in a cache within minutes."""
    end = time.monotonic() + 300.0
    while not list(cache.rglob("*.kernel")) and time.monotonic() < end:
        time.sleep(0.05)
    return len(list(cache.rglob("*.kernel"))) == 1


@pytest.mark.full
def test_a_short_program_is_answered_at_once_and_the_kernel_is_compiled_after_its_end(
    slow: str, tmp_path: Path
) -> None:
    cache = tmp_path / "cache"
    assert outcome(start(slow, NUMBA_CACHE_DIR=str(cache))) == ("1 200000.0 False\n", BACKGROUND)
    assert has_a_kernel(cache)
    # The next program has nothing to compile, and reads the kernel when it has worked for long enough.
    assert outcome(start(slow, NUMBA_CACHE_DIR=str(cache))) == ("1 200000.0 False\n", "")
    again = slow + "slow.kernel.ready()\nslow.kernel(values)\nprint(values[0])"
    out, err = outcome(start(again, NUMBA_CACHE_DIR=str(cache)))
    assert (out.splitlines()[0], err) == ("1 200000.0 False", "")


@pytest.mark.parametrize(
    ("before", "environment"),
    [
        ("", {"NUMBA_DISABLE_JIT": "1"}),
        ("sys.frozen = True", {}),
        ("sys.executable = '/nowhere/python3'", {}),
        *full(
            ("sys.executable = '/usr/bin/uwsgi'", {}),
            ("sys.executable = None", {}),
            ("", {"NUMBA_CACHE_DIR": "/dev/null"}),
        ),
    ],
)
def test_the_answer_comes_where_no_process_can_be_started(
    slow: str, tmp_path: Path, before: str, environment: dict[str, str]
) -> None:
    told = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), **environment}
    out, err = outcome(start(f"import sys\n{before}\n{slow}", **told))
    assert out.split()[0] == ("0" if "NUMBA_DISABLE_JIT" in environment else "1")
    assert err == (BACKGROUND if "nowhere" in before else "")


def test_rows_are_run_as_python_until_the_rest_would_take_longer_than_to_compile(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    started: list[str] = []
    monkeypatch.setattr(kernel_cache.CachedKernel, "compile_in_background", lambda self: started.append(self.name))
    monkeypatch.setattr(kernel_cache, "KERNELS", {})
    clock = [0.0]
    monkeypatch.setattr(kernel_cache.time, "perf_counter", lambda: clock[0])

    def rows(kernel: kernel_cache.CachedKernel, count: int, each: float) -> int:
        def run(part: slice) -> None:
            clock[0] += each * (part.stop - part.start)

        return kernel_cache.first_rows([kernel], run, count)

    def kernel() -> kernel_cache.CachedKernel:
        return kernel_cache.CachedKernel(_identity, "a kernel", "made up", lambda: "float64(float64)", 10.0)

    assert rows(kernel(), 1, 50.0) == 1  # one target is never waited for
    assert started == ["made up"]
    assert rows(kernel(), 100, 0.05) == 100
    assert rows(kernel(), 1000, 0.05) == 1  # 50 s are longer than to compile
    assert rows(kernel(), 1000, 1e-6) == 1000
    many = kernel()
    done = [rows(many, 10, 0.1) for _ in range(15)]
    assert done[:9] == [10] * 9
    assert done[-1] < 10  # ten seconds have been spent
    assert rows(kernel(), 0, 1.0) == 0
    assert kernel_cache.first_rows([kernel()], lambda part: pytest.fail("ran"), 3, each=4.0) == 0


def _identity(x: float) -> float:
    return x


@pytest.mark.full
def test_the_lock_of_a_process_that_was_killed_holds_nobody_up(small: str, tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    hanging = small.replace(
        "assert first",
        "import time; from numba.core import compiler\n"
        "compiler.compile_extra = lambda *_, **__: print('has it', flush=True) or time.sleep(600)\nassert first",
    )
    holder = start(hanging, NUMBA_CACHE_DIR=str(cache))
    assert holder.stdout is not None
    assert holder.stdout.readline() == "has it\n"
    waiting = start(small, NUMBA_CACHE_DIR=str(cache))
    assert waiting.stderr is not None
    assert waiting.stderr.readline() == WAITING
    holder.kill()
    holder.communicate()
    assert outcome(waiting) == ("right\n", SAID)


def test_without_compiling_pinocchio_answers() -> None:
    assert outcome(start(ASK, NUMBA_DISABLE_JIT="1", PYTHONWARNINGS="ignore")) == ("right\n", "")


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
        "import sys, nao_kin as nk; nao = nk.load_nao(); nao.fk(nao.random(0, nk._core.arrays.CROSSOVER - 1)); "
        "print('numba' in sys.modules)"
    )
    assert outcome(start(code)) == ("False\n", "")


@pytest.mark.full
def test_warmup_says_what_is_ready_and_where() -> None:
    nk.warm_up([name for name, kernel in nk._kernels.KERNELS.items() if not (kernel.file and kernel.file.exists())])
    out, err = outcome(start("from nao_kin.cli.app import run\nrun(['warmup'])\nrun(['warmup', '--json'])"))
    table, _, document = out.partition("{")
    kernels = json.loads("{" + document)["kernels"]
    assert err == ""
    rooms = Counter(kernel["name"].split(" kernel, ")[0] for kernel in kernels)
    assert rooms == {"batch": 3, "collision": 1, "reach": 4, "ik": 12, "world": 2}
    assert not any(kernel["compiled"] for kernel in kernels)
    assert all(Path(kernel["folder"]).is_dir() for kernel in kernels)
    assert table.count("found") == len(kernels)


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
    assert nk.cache_folder() == Path(folder)
