"""Files that are either the old ones or the new ones, never half of each; and nothing but a file is ever replaced.

A symbolic link is followed and stays. A device, a pipe and a descriptor of this process ("/dev/stdout") are written
to as they are. An existing file keeps its mode and its owner.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from nao_kin._common.ending import before_ending, uninterrupted
from nao_kin._text import abbreviated, quoted
from nao_kin.errors import BadArgument

_DESCRIPTORS = re.compile(r"/(?:dev|proc/(?:self|thread-self|(?P<process>\d+)))/fd/(?P<descriptor>\d+)")
_MOST_LINKS = 40
_STANDARD_OUTPUT = 1
_COPIED_AT_ONCE = 1 << 20


@dataclass(frozen=True)
class _Target:
    """What a path leads to.

    Attributes:
        path: the path, without symbolic links.
        state: what is there, None for nothing.
        descriptor: of this process, if the path names one.
    """

    path: Path
    state: os.stat_result | None
    descriptor: int | None = None

    @property
    def replaceable(self) -> bool:
        """Whether a new file may take the place: of a file or of nothing, never of a device or a pipe."""
        return self.descriptor is None and (self.state is None or stat.S_ISREG(self.state.st_mode))


def check_writable(path: Path | str, *, suffix: str = "") -> None:
    """Raise what `write_bytes` would raise, before the work whose result is to be written.

    Args:
        path: the file.
        suffix: what its name must end in, if it ends in a suffix at all: another one promises another format.

    Raises:
        BadArgument: no path, a folder, a read-only file, a folder that does not exist or takes no file, or another
            suffix.
    """
    with errors_naming(path):
        target = _target_of(path)
        if target.replaceable:
            with _temporary_beside(target) as (descriptor, _):
                os.close(descriptor)
    ending = Path(path).suffix
    if suffix and ending and ending.lower() != suffix:
        kind = suffix.removeprefix(".").upper()
        raise BadArgument(f"cannot write {abbreviated(path)}: a picture is written as {kind}; end the name in {suffix}")


def leads_to_standard_output(path: Path | str) -> bool:
    """Whether `path` is another name of this process's standard output, such as "/dev/stdout"."""
    return _descriptor_of(os.fspath(path)) == _STANDARD_OUTPUT


def replaced_file(path: Path | str) -> Path | None:
    """The file, without symbolic links, that writing to `path` puts or replaces; None for a device, pipe, descriptor.

    Raises:
        BadArgument: as `write_bytes`.
    """
    with errors_naming(path):
        target = _target_of(path)
    return target.path if target.replaceable else None


def write_text(path: Path | str, text: str) -> None:
    """Write `text` (UTF-8) to `path`, as `write_bytes` does.

    Raises:
        BadArgument: no path, a folder, a read-only file, or a folder that does not exist or takes no file.
    """
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path | str, content: bytes) -> None:
    """Write `content` to `path`: a file through a temporary one in the same folder and one rename, all else directly.

    Raises:
        BadArgument: no path, a folder, a read-only file, or a folder that does not exist or takes no file.
    """
    with errors_naming(path):
        target = _target_of(path)
        if not target.replaceable:
            with _opened(target) as stream:
                stream.write(content)
        elif not _replace(target, content):
            with uninterrupted(), target.path.open("wb") as file:
                file.write(content)


def move_into_place(finished: Path, path: Path | str) -> None:
    """Make a file that is finished what `path` leads to, by one rename; a device or a pipe gets its content.

    Args:
        finished: the file, in the file system of `replaced_file(path)`.
        path: as in `write_bytes`.

    Raises:
        BadArgument: as `write_bytes`; the finished file is still there.
    """
    with errors_naming(path):
        target = _target_of(path)
        if target.replaceable and (target.state is None or _like_before(finished, target.state)):
            os.replace(finished, target.path)
            return
        with finished.open("rb") as content:
            if not target.replaceable:
                with _opened(target) as stream:
                    shutil.copyfileobj(content, stream, _COPIED_AT_ONCE)
            else:
                with uninterrupted(), target.path.open("wb") as file:
                    shutil.copyfileobj(content, file, _COPIED_AT_ONCE)
        finished.unlink()


def _opened(target: _Target) -> BinaryIO:
    """A device, a pipe or a descriptor, open for writing."""
    if target.descriptor is None:
        return target.path.open("wb")
    if target.descriptor == _STANDARD_OUTPUT and sys.stdout is not None:
        sys.stdout.flush()  # what was printed before stays before
    return os.fdopen(os.dup(target.descriptor), "wb")


def _target_of(path: Path | str) -> _Target:
    """Where writing to `path` leads, if it may lead there.

    Raises:
        OSError, ValueError, TypeError: it may not; or no path.
    """
    text = os.fspath(path)
    if not isinstance(text, str):
        raise TypeError("expected a path as text")
    if not Path(text).name:
        raise ValueError("no file name")
    descriptor = _descriptor_of(text)
    if descriptor is not None:
        _check_descriptor(descriptor)
        return _Target(Path(text), os.fstat(descriptor), descriptor)
    target = Path(os.path.realpath(text))
    try:
        state = os.stat(text)
    except FileNotFoundError:
        if text.endswith(os.sep):
            raise OSError("it is named as a folder") from None
        return _Target(target, None)
    if stat.S_ISDIR(state.st_mode):
        raise OSError("it is a folder")
    if stat.S_ISSOCK(state.st_mode):
        raise OSError("it is a socket")
    # Root may write to everything; that a file is marked read-only is meant for root too.
    if not state.st_mode & 0o222:
        raise OSError(f"it is read-only (mode {stat.S_IMODE(state.st_mode):04o})")
    if not os.access(text, os.W_OK):
        raise OSError("permission denied")
    return _Target(target, state)


def _descriptor_of(path: str) -> int | None:
    """The descriptor of this process that a path names, itself or through symbolic links."""
    for _ in range(_MOST_LINKS):
        match = _DESCRIPTORS.fullmatch(os.path.abspath(path))
        if match is not None and match["process"] in (None, str(os.getpid())):
            return int(match["descriptor"])
        try:
            path = os.path.join(os.path.dirname(path), os.readlink(path))
        except (OSError, ValueError):
            return None
    return None


def _check_descriptor(descriptor: int) -> None:
    import fcntl

    if fcntl.fcntl(descriptor, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
        raise OSError("it is not open for writing")


def _replace(target: _Target, content: bytes) -> bool:
    """Put a new file in the place; False, and nothing done, where it could not be given to the owner of the old one."""
    with _temporary_beside(target) as (descriptor, temporary):
        with os.fdopen(descriptor, "wb") as file:
            if target.state is not None and not _like_before(temporary, target.state):
                return False
            file.write(content)
        os.replace(temporary, target.path)
    return True


@contextmanager
def _temporary_beside(target: _Target) -> Iterator[tuple[int, Path]]:
    """Descriptor and path of a new file in the folder of the target; whatever happens, it is gone afterwards."""
    temporary = target.path.with_name(f".nao_kin-{secrets.token_hex(8)}")

    def remove() -> None:
        with suppress(OSError):
            temporary.unlink()

    take_back = before_ending(remove)
    try:
        yield os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), temporary
    finally:
        remove()
        take_back()


def _like_before(temporary: Path, before: os.stat_result) -> bool:
    """Give the new file the owner and the mode of the old one; False when it may not be given away."""
    now = temporary.stat()
    if (now.st_uid, now.st_gid) != (before.st_uid, before.st_gid):
        try:
            os.chown(temporary, before.st_uid, before.st_gid)
        except PermissionError:
            return False
    os.chmod(temporary, stat.S_IMODE(before.st_mode))
    return True


@contextmanager
def errors_naming(path: object) -> Iterator[None]:
    """Turn what goes wrong inside into `BadArgument`: that the path cannot be written, and why."""
    try:
        yield
    except OSError as error:
        raise BadArgument(f"cannot write {abbreviated(path)}: {error.strerror or error}") from None
    except (ValueError, TypeError) as error:
        raise BadArgument(f"cannot write {quoted(path)}: {error}") from None
