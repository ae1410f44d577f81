"""Kernels are read and written only where no other user can have written: whoever writes a kernel runs code."""

from __future__ import annotations

import os
import pickle
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from forked import Forks, forks

from nao_kin._kernels import cache as kernel_cache
from nao_kin._kernels.folder import locked, private_folder, read_file, write_file

NOBODY = 65534
needs_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root can act as two users")

# A kernel that is compiled in no time; its folder is printed.
PROGRAM = """
import small
from nao_kin._kernels.cache import CachedKernel
kernel = CachedKernel(small.doubled, "a small kernel", "doubled", lambda: "float64(float64)")
assert kernel(3.0) == 6.0
print(kernel.file)
"""
AS_NOBODY = f"""
import os
os.setgroups([])
os.setgid({NOBODY})
os.setuid({NOBODY})
"""
COMPILED = "nao_kin: compiling a small kernel (about 10 s), once on this machine …\n"


class Poison:
    """A pickle that makes a file when it is read."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[object, ...]:
        return os.mkdir, (str(self.mark),)


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forks]:
    """A process that has compiled a kernel, and so has loaded everything that another user may not be able to read."""
    folder = tmp_path_factory.mktemp("programs")
    (folder / "small.py").write_text("def doubled(x):\n    return 2 * x\n")
    where = f"import os, sys\nsys.path.insert(0, {str(folder)!r})\nos.environ['NUMBA_CACHE_DIR'] = {str(folder)!r}\n"
    again = "from nao_kin._kernels import cache\ncache._printed.clear()  # a program says again what it does"
    with forks(where + PROGRAM * 2 + again, folder) as programs:
        yield programs


@pytest.fixture
def shared() -> Iterator[Path]:
    """A folder in which every user may look for files; the folders of pytest are closed to others."""
    folder = Path(tempfile.mkdtemp(prefix="nk_"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


def poisoned(programs: Forks, root: Path, mark: Path) -> Path:
    """Return the file of a kernel in a cache at `root`, which runs code of another user when it is read."""
    code, out, err = programs.run(PROGRAM, cwd=root.parent, NUMBA_CACHE_DIR=str(root))
    assert (code, err) == (0, COMPILED)
    file = Path(out.strip())
    file.write_bytes(pickle.dumps(Poison(mark)))
    return file


# What another user may write: the file of the kernel or its folder, the owner, and the mode.
OPEN = {
    "a folder of another user": ("folder", NOBODY, 0o755),
    "a folder that all may write": ("folder", 0, 0o777),
    "a folder that all may write, with a sticky bit": ("folder", 0, 0o1777),
    "a folder that the group may write": ("folder", 0, 0o775),
    "a kernel of another user": ("file", NOBODY, 0o644),
    "a kernel that all may write": ("file", 0, 0o666),
}


@needs_root
@pytest.mark.parametrize("place", OPEN)
def test_what_another_user_can_have_written_is_neither_read_nor_changed(
    programs: Forks, shared: Path, place: str
) -> None:
    mark, root = shared / "code-of-another-user-ran", shared / "root"
    file = poisoned(programs, root, mark)
    what, owner, mode = OPEN[place]
    changed = file if what == "file" else file.parent
    os.chown(changed, owner, 0)
    changed.chmod(mode)
    before = {path: path.stat().st_mtime_ns for path in root.rglob("*")}
    code, _, err = programs.run(PROGRAM, cwd=shared, NUMBA_CACHE_DIR=str(root))
    assert code == 0, err
    assert not mark.exists()
    assert err.count("NotCachedWarning") == 1
    assert f"other users may write to '{file.name if what == 'file' else changed}'" in err
    assert {path: path.stat().st_mtime_ns for path in root.rglob("*")} == before


@needs_root
def test_what_this_user_alone_can_write_is_read(programs: Forks, shared: Path) -> None:
    """It also shows that the kernel of the other test runs code where it is read."""
    mark, root = shared / "code-ran", shared / "root"
    file = poisoned(programs, root, mark)
    root.chmod(0o777)  # whoever puts another folder there owns it
    assert programs.run(PROGRAM, cwd=shared, NUMBA_CACHE_DIR=str(root)) == (0, f"{file}\n", COMPILED)
    assert mark.exists()
    mark.rmdir()
    assert programs.run(PROGRAM, cwd=shared, NUMBA_CACHE_DIR=str(root)) == (0, f"{file}\n", "")
    assert not mark.exists()


def test_a_folder_that_is_exchanged_while_it_is_open_stays_the_one_that_was_checked(tmp_path: Path) -> None:
    path, other = tmp_path / "nao_kin", tmp_path / "other"
    other.mkdir()
    (other / "kernel").write_bytes(b"of another user")
    with private_folder(path) as folder:
        write_file(folder, "kernel", b"ours")
        path.rename(tmp_path / "away")
        path.symlink_to(other)
        assert read_file(folder, "kernel") == b"ours"
        write_file(folder, "second", b"ours too")
    assert [file.name for file in other.iterdir()] == ["kernel"]
    with pytest.raises(OSError, match="director"), private_folder(path):
        pass  # a link may lead anywhere


@needs_root
@pytest.mark.parametrize("umask", [0o022, 0o002, 0o000])
def test_kernels_compiled_by_root_are_for_all_users_who_cannot_change_them(
    programs: Forks, shared: Path, umask: int
) -> None:
    root = shared / "root" / "kernels"
    (shared / "root").mkdir()
    made = programs.run(f"import os\nos.umask({umask})\n{PROGRAM}", cwd=shared, NUMBA_CACHE_DIR=str(root))
    assert (made[0], made[2]) == (0, COMPILED)
    assert not any(path.stat().st_mode & 0o022 for path in root.rglob("*"))
    before = {path: path.stat().st_mtime_ns for path in root.rglob("*")}
    assert programs.run(AS_NOBODY + PROGRAM, cwd=shared, NUMBA_CACHE_DIR=str(root)) == (0, made[1], "")
    assert before == {path: path.stat().st_mtime_ns for path in root.rglob("*")}


@needs_root
def test_the_folder_of_a_user_is_closed_to_others_whatever_the_umask(programs: Forks, shared: Path) -> None:
    os.chown(shared, NOBODY, NOBODY)
    as_nobody = f"{AS_NOBODY}os.umask(0)\n{PROGRAM}"
    root = shared / "home" / "cache"
    code, out, err = programs.run(as_nobody, cwd=shared, NUMBA_CACHE_DIR=str(root))
    assert (code, err) == (0, COMPILED)
    file = Path(out.strip())
    assert file.parent.stat().st_mode & 0o777 == 0o700
    assert not any(path.stat().st_mode & 0o022 for path in file.parent.iterdir())
    assert programs.run(as_nobody, cwd=shared, NUMBA_CACHE_DIR=str(root)) == (0, out, "")


def test_no_process_compiles_into_a_folder_that_others_can_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel_cache, "KERNELS", {})
    monkeypatch.setattr("subprocess.run", lambda *_, **__: pytest.fail("a process was started"))
    kernel = kernel_cache.CachedKernel(len, "a kernel", "made up")
    vars(kernel)["file"] = tmp_path / "nao_kin" / "0123.kernel"
    (tmp_path / "nao_kin").mkdir()
    (tmp_path / "nao_kin").chmod(0o777)
    kernel.compile_in_background()
    assert list(tmp_path.rglob("*")) == [tmp_path / "nao_kin"]


@pytest.mark.skipif(sys.platform != "linux", reason="the errors of links differ")
def test_a_lock_is_not_written_through_a_link(tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_text("precious")
    with private_folder(tmp_path / "nao_kin") as folder:
        (tmp_path / "nao_kin" / "lock").symlink_to(victim)
        with pytest.raises(OSError, match="symbolic links"), locked(folder, "lock"):
            pass
    assert victim.read_text() == "precious"
