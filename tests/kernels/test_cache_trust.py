"""Kernels are read and written only where no other user can have written: whoever writes a kernel runs code."""

from __future__ import annotations

import grp
import os
import pickle
import pwd
import shutil
import sys
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest
from forked import Forks, forks

from nao_kin._kernels import cache as kernel_cache
from nao_kin._kernels.folder import lock_file
from nao_kin.errors import NotCachedWarning

NOBODY = 65534
needs_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root can act as two users")

# A kernel that is compiled in no time; its folder is printed.
PROGRAM = """
import small
from nao_kin._kernels.cache import CachedKernel
kernel = CachedKernel(small.doubled, "a small kernel", "doubled", lambda: "float64(float64)")
assert kernel(3.0) == 6.0
print(kernel.folder)
"""
AS_ANOTHER = """
import os
os.setgroups([])
os.setgid({gid})
os.setuid({uid})
"""
AS_NOBODY = AS_ANOTHER.format(uid=NOBODY, gid=NOBODY)
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
    """Return the folder of a kernel in a cache at `root`, whose index runs code of another user when it is read."""
    code, out, err = programs.run(PROGRAM, cwd=root.parent, NUMBA_CACHE_DIR=str(root))
    assert (code, err) == (0, COMPILED)
    folder = Path(out.strip())
    index = next(folder.glob("*.nbi"))
    index.write_bytes(pickle.dumps(Poison(mark)))
    return folder


# What another user may write: its place from the kernel's folder upwards, the owner, and the mode.
OPEN = {
    "the kernel's folder of another user": (0, NOBODY, 0o755),
    "the folder of all kernels of another user": (1, NOBODY, 0o755),
    "the home of another user, as after sudo": (2, NOBODY, 0o755),
    "a folder of /tmp's kind of another user": (2, NOBODY, 0o1777),
    "a kernel's folder that all may write": (0, 0, 0o777),
    "a kernel's folder with a sticky bit that all may write": (0, 0, 0o1777),
    "a folder of all kernels that the group may write": (1, 0, 0o775),
    "a folder of all kernels with a sticky bit": (1, 0, 0o1777),
    "a parent that all may write": (2, 0, 0o777),
    "a parent that the group may write": (2, 0, 0o775),
    "an index of another user": (None, NOBODY, 0o644),
    "an index that all may write": (None, 0, 0o666),
}


@needs_root
@pytest.mark.parametrize("place", OPEN)
def test_what_another_user_can_have_written_is_neither_read_nor_changed(
    programs: Forks, shared: Path, place: str
) -> None:
    mark, root = shared / "code-of-another-user-ran", shared / "root"
    folder = poisoned(programs, root, mark)
    up, owner, mode = OPEN[place]
    changed = next(folder.glob("*.nbi")) if up is None else (folder, *folder.parents)[up]
    os.chown(changed, owner, 0)
    changed.chmod(mode)
    before = {path: path.stat().st_mtime_ns for path in root.rglob("*")}
    code, _, err = programs.run(PROGRAM, cwd=shared, NUMBA_CACHE_DIR=str(root))
    assert code == 0, err
    assert not mark.exists()
    assert err.count("NotCachedWarning") == 1
    assert f"{'user 65534 owns' if owner else 'other users may write to'} '{changed}'"[:150] in err
    assert {path: path.stat().st_mtime_ns for path in root.rglob("*")} == before


@needs_root
@pytest.mark.parametrize("sticky", [False, True])
def test_what_this_user_alone_can_write_is_read(programs: Forks, shared: Path, sticky: bool) -> None:
    """It also shows that the index of the other test runs code where it is read."""
    mark, root = shared / "code-ran", shared / "root"
    folder = poisoned(programs, root, mark)
    if sticky:
        root.chmod(0o1777)  # as /tmp: nobody can replace what this user has there
    assert programs.run(PROGRAM, cwd=shared, NUMBA_CACHE_DIR=str(root)) == (0, f"{folder}\n", COMPILED)
    assert mark.exists()
    mark.rmdir()
    assert programs.run(PROGRAM, cwd=shared, NUMBA_CACHE_DIR=str(root)) == (0, f"{folder}\n", "")
    assert not mark.exists()


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
def test_folders_of_a_user_are_closed_to_others_whatever_the_umask(programs: Forks, shared: Path) -> None:
    os.chown(shared, NOBODY, NOBODY)
    as_nobody = f"{AS_NOBODY}os.umask(0)\n{PROGRAM}"
    root = shared / "home" / "cache"
    code, out, err = programs.run(as_nobody, cwd=shared, NUMBA_CACHE_DIR=str(root))
    assert (code, err) == (0, COMPILED)
    folder = Path(out.strip())
    assert [path.stat().st_mode & 0o777 for path in (folder, folder.parent, root)] == [0o700] * 3
    assert not any(path.stat().st_mode & 0o022 for path in folder.iterdir())
    assert programs.run(as_nobody, cwd=shared, NUMBA_CACHE_DIR=str(root)) == (0, out, "")


@needs_root
@pytest.mark.parametrize("alone", [True, False])
def test_the_group_of_one_user_alone_may_write(programs: Forks, shared: Path, alone: bool) -> None:
    """Debian has a user and a group "daemon"; nobody's group is called otherwise, and may have other members."""
    user = pwd.getpwnam("daemon" if alone else "nobody")
    if alone and grp.getgrgid(user.pw_gid) != ("daemon", "x", user.pw_gid, []):
        pytest.skip("no user with a group of its own")
    root = shared / "root"
    root.mkdir()
    os.chown(root, user.pw_uid, user.pw_gid)
    root.chmod(0o775)  # as the umask 002 makes it
    program = AS_ANOTHER.format(uid=user.pw_uid, gid=user.pw_gid) + PROGRAM
    code, _, err = programs.run(program, cwd=shared, NUMBA_CACHE_DIR=str(root))
    assert code == 0
    assert (err == COMPILED) == alone
    assert ("NotCachedWarning" in err) != alone


@pytest.mark.parametrize("opened", ["nao_kin", "nao_kin/0123"])
def test_no_process_compiles_into_a_folder_that_others_can_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, opened: str
) -> None:
    monkeypatch.setattr(kernel_cache, "KERNELS", {})
    monkeypatch.setattr(kernel_cache, "_printed", set())
    monkeypatch.setattr("subprocess.run", lambda *_, **__: pytest.fail("a process was started"))
    kernel = kernel_cache.CachedKernel(len, "a kernel", "made up")
    folder = vars(kernel)["folder"] = tmp_path / "nao_kin" / "0123"
    folder.mkdir(parents=True)
    (folder / "made up").touch()
    (tmp_path / opened).chmod(0o777)
    with pytest.warns(NotCachedWarning, match=f"other users may write to '{tmp_path / opened}'"):
        kernel.compile_in_background()
    kernel._started = False
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # once is enough
        kernel.compile_in_background()
    assert list(tmp_path.rglob("*")) == [folder.parent, folder, folder / "made up"]


@pytest.mark.skipif(sys.platform != "linux", reason="the errors of links differ")
def test_a_lock_is_not_written_through_a_link(tmp_path: Path) -> None:
    victim, folder = tmp_path / "victim", tmp_path / "nao_kin" / "0123"
    victim.write_text("precious")
    folder.parent.mkdir(mode=0o700)
    folder.with_suffix(".lock").symlink_to(victim)
    with pytest.raises(OSError, match="symbolic links"), lock_file(folder):
        pass
    assert victim.read_text() == "precious"
