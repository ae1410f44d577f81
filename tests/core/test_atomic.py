"""Output files: whole or not at all, and only files are replaced."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from nao_kin._core import files as atomic
from nao_kin.errors import BadArgument

ROOT = hasattr(os, "geteuid") and os.geteuid() == 0
pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs a POSIX file system")


def _device(path: Path, minor: int) -> Path:
    """Make a memory device, by its minor number: 3 accepts and discards everything, 7 is always full."""
    try:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, minor))
    except PermissionError:
        pytest.skip("only root makes device nodes")
    os.chmod(path, 0o666)
    try:
        path.open("wb").close()
    except PermissionError:
        pytest.skip("this file system has no devices")
    return path


def _refused(path: Path | str, reason: str) -> None:
    """Check that both the early check and the writing refuse a path with the same message."""
    for attempt in (atomic.check_writable, lambda p: atomic.write_bytes(p, b"new")):
        with pytest.raises(BadArgument) as caught:
            attempt(path)
        assert str(caught.value) == f"cannot write {path}: {reason}"


def test_a_new_file_has_the_mode_of_any_new_file(tmp_path: Path) -> None:
    path = tmp_path / "new"
    before = os.umask(0o027)
    try:
        atomic.check_writable(path)
        assert list(tmp_path.iterdir()) == []
        atomic.write_text(path, "größer")
    finally:
        os.umask(before)
    assert path.read_bytes() == "größer".encode()
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("mode", [0o600, 0o644, 0o755, 0o220])
def test_an_existing_file_keeps_its_mode(tmp_path: Path, mode: int) -> None:
    path = tmp_path / "old"
    path.write_bytes(b"old, and longer than what comes")
    path.chmod(mode)
    atomic.write_bytes(path, b"new")
    assert stat.S_IMODE(path.stat().st_mode) == mode
    path.chmod(0o600)
    assert path.read_bytes() == b"new"


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")
@pytest.mark.parametrize("how", ["a file", "a finished file", "a document", "a folder"])
def test_content_is_on_the_disk_before_it_replaces_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    synced, renamed = {}, []

    def fsync(descriptor: int, fsync: Callable[[int], None] = os.fsync) -> None:
        fsync(descriptor)
        path = Path(f"/proc/self/fd/{descriptor}")
        synced[path.stat().st_ino] = path.read_bytes()

    def renaming(rename: Callable[..., None]) -> Callable[..., None]:
        def called(old: Path, new: Path) -> None:
            for file in [Path(old), *Path(old).rglob("*")]:
                if file.is_file() and file.read_bytes().startswith(b"new"):
                    renamed.append(synced.get(file.stat().st_ino) == file.read_bytes())
            rename(old, new)

        return called

    folder, path = tmp_path / "folder", tmp_path / "folder" / "file"
    folder.mkdir()
    for name in ("file", "mesh"):
        (folder / name).write_bytes(b"old")
    monkeypatch.setattr(os, "fsync", fsync)
    for name in ("replace", "rename"):
        monkeypatch.setattr(os, name, renaming(getattr(os, name)))
    if how == "a file":
        atomic.write_bytes(path, b"new")
    elif how == "a finished file":
        (tmp_path / "finished").write_bytes(b"new")
        atomic.move_into_place(tmp_path / "finished", path)
    elif how == "a document":
        atomic.write_document(path, b"new", {"mesh": b"new mesh"}, overwrite=True)
    else:
        atomic.write_folder(folder, {"file": b"new", "mesh": b"new mesh"}, overwrite=True)
    assert path.read_bytes() == b"new"
    assert renamed == [True] * (2 if how in ("a document", "a folder") else 1)


@pytest.mark.skipif(not ROOT, reason="only root gives files away")
@pytest.mark.parametrize(("owner", "group"), [(12345, 23456), (0, 23456), (12345, 0)])
def test_an_existing_file_keeps_its_owner_and_its_group(tmp_path: Path, owner: int, group: int) -> None:
    path = tmp_path / "old"
    path.write_bytes(b"old")
    os.chown(path, owner, group)
    path.chmod(0o660)
    atomic.write_bytes(path, b"new")
    state = path.stat()
    assert (state.st_uid, state.st_gid, stat.S_IMODE(state.st_mode)) == (owner, group, 0o660)
    assert path.read_bytes() == b"new"


def test_a_read_only_file_is_refused_by_root_too(tmp_path: Path) -> None:
    path, link = tmp_path / "old", tmp_path / "link"
    path.write_bytes(b"old")
    path.chmod(0o444)
    link.symlink_to("old")
    _refused(path, "it is read-only (mode 0444)")
    _refused(link, "it is read-only (mode 0444)")
    assert path.read_bytes() == b"old"
    assert sorted(tmp_path.iterdir()) == [link, path]


def test_folders_are_refused(tmp_path: Path) -> None:
    _refused(tmp_path, "it is a folder")
    (tmp_path / "link").symlink_to(tmp_path)
    _refused(tmp_path / "link", "it is a folder")
    _refused(f"{tmp_path}/new/", "the path names a folder")
    _refused(tmp_path / "no" / "x", "No such file or directory")
    (tmp_path / "file").touch()
    _refused(tmp_path / "file" / "x", "Not a directory")
    for nothing in ("", "/", "."):
        with pytest.raises(BadArgument, match="no file name"):
            atomic.check_writable(nothing)


@pytest.mark.parametrize("relative", [True, False])
@pytest.mark.parametrize("dangling", [True, False])
def test_a_link_stays_and_its_target_is_written(tmp_path: Path, relative: bool, dangling: bool) -> None:
    for folder in ("here", "there"):
        (tmp_path / folder).mkdir()
    target = tmp_path / "there" / "target"
    if not dangling:
        target.write_bytes(b"old")
        target.chmod(0o640)
    first, second = tmp_path / "here" / "first", tmp_path / "there" / "second"
    first.symlink_to("../there/second" if relative else second)
    second.symlink_to("target" if relative else target)
    atomic.check_writable(first)
    assert target.exists() != dangling
    atomic.write_bytes(first, b"new")
    assert first.is_symlink()
    assert second.is_symlink()
    assert target.read_bytes() == b"new"
    assert not target.is_symlink()
    if not dangling:
        assert stat.S_IMODE(target.stat().st_mode) == 0o640
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["first", "here", "second", "target", "there"]


def test_links_that_lead_nowhere_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    _refused(tmp_path / "a", "Too many levels of symbolic links")
    (tmp_path / "c").symlink_to("no/x")
    _refused(tmp_path / "c", "No such file or directory")


def test_a_device_stays_a_device(tmp_path: Path) -> None:
    null = _device(tmp_path / "null", 3)
    (tmp_path / "link").symlink_to(null)
    for path in (null, tmp_path / "link"):
        atomic.check_writable(path)
        atomic.write_bytes(path, b"new")
    assert stat.S_ISCHR(null.stat().st_mode)
    assert (tmp_path / "link").is_symlink()
    assert len(list(tmp_path.iterdir())) == 2


def test_a_full_device_is_named(tmp_path: Path) -> None:
    full = _device(tmp_path / "full", 7)
    with pytest.raises(BadArgument, match="full: No space left on device"):
        atomic.write_bytes(full, b"new")
    assert stat.S_ISCHR(full.stat().st_mode)


def test_a_pipe_is_written_to(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    received: list[bytes] = []
    reader = threading.Thread(target=lambda: received.append(pipe.read_bytes()), daemon=True)
    reader.start()
    atomic.check_writable(pipe)
    content = bytes(range(256)) * 4000  # more than a pipe holds
    atomic.write_bytes(pipe, content)
    reader.join(10.0)
    assert received == [content]
    assert stat.S_ISFIFO(pipe.stat().st_mode)


_TO_A_DESCRIPTOR = """
import sys
from nao_kin._core import files as atomic
print("before")
atomic.check_writable(sys.argv[1])
atomic.write_text(sys.argv[1], "content\\n")
print("after", atomic.leads_to_standard_output(sys.argv[1]))
"""


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")
@pytest.mark.parametrize("name", ["/proc/self/fd/1", "/dev/stdout", "/dev/fd/1"])
def test_standard_output_is_written_after_what_was_printed(tmp_path: Path, name: str) -> None:
    command = [sys.executable, "-c", _TO_A_DESCRIPTOR, name]
    # What is printed waits in a buffer, as it does for most.
    buffered = {key: value for key, value in os.environ.items() if key != "PYTHONUNBUFFERED"}
    piped = subprocess.run(command, capture_output=True, text=True, check=False, env=buffered)
    assert (piped.stdout, piped.stderr) == ("before\ncontent\nafter True\n", "")
    log = tmp_path / "log"
    log.write_text("earlier\n")
    with log.open("a") as file:
        subprocess.run(command, stdout=file, check=True, env=buffered)
    assert log.read_text() == "earlier\nbefore\ncontent\nafter True\n"


def test_a_picture_is_written_as_what_its_name_says_in_either_letter_case(tmp_path: Path) -> None:
    for name in ("a.png", "a.PNG", "a", "/dev/null"):
        atomic.check_writable(tmp_path / name, kind="png")
    for name in ("a.jpg", "a.png.jpg"):
        with pytest.raises(BadArgument, match=r"a picture is written as PNG; end the name in \.png"):
            atomic.check_writable(tmp_path / name, kind="png")


@pytest.mark.skipif(ROOT, reason="root may write everywhere")
def test_permissions_are_respected(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        _refused(tmp_path / "new", "Permission denied")
    finally:
        tmp_path.chmod(0o700)


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "old"
    path.write_bytes(b"old")

    def broken(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", broken)
    with pytest.raises(BadArgument, match="No space left on device"):
        atomic.write_bytes(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]
    monkeypatch.undo()
    long = tmp_path / ("n" * 250)
    atomic.write_bytes(long, b"new")
    assert long.read_bytes() == b"new"
    with pytest.raises(BadArgument) as caught:
        atomic.write_bytes(tmp_path / ("n" * 3000), b"new")
    assert "File name too long" in str(caught.value)
    assert len(str(caught.value)) < 300


def test_a_finished_file_takes_the_place_by_one_rename(tmp_path: Path) -> None:
    finished, path, link = tmp_path / "finished", tmp_path / "old", tmp_path / "link"
    path.write_bytes(b"old")
    path.chmod(0o640)
    link.symlink_to("old")
    finished.write_bytes(b"new")
    inode = finished.stat().st_ino
    assert atomic.replaced_file(link) == path
    atomic.move_into_place(finished, link)
    assert (path.read_bytes(), path.stat().st_ino, stat.S_IMODE(path.stat().st_mode)) == (b"new", inode, 0o640)
    assert link.is_symlink()
    assert not finished.exists()
    finished.write_bytes(b"first")
    atomic.move_into_place(finished, tmp_path / "fresh")
    assert (tmp_path / "fresh").read_bytes() == b"first"


def test_a_pipe_gets_the_content_of_a_finished_file(tmp_path: Path) -> None:
    pipe, finished = tmp_path / "pipe", tmp_path / "finished"
    os.mkfifo(pipe)
    finished.write_bytes(bytes(range(256)) * 4000)
    received: list[bytes] = []
    reader = threading.Thread(target=lambda: received.append(pipe.read_bytes()), daemon=True)
    reader.start()
    assert atomic.replaced_file(pipe) is None
    atomic.move_into_place(finished, pipe)
    reader.join(10.0)
    assert received == [bytes(range(256)) * 4000]
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert not finished.exists()
