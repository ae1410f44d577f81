"""Files that are either the old ones or the new ones, never half of each; and nothing but a file is ever replaced.

A symbolic link is followed and stays. A device, a pipe and a descriptor of this process ("/dev/stdout") are written
to as they are. An existing file keeps its mode and its owner.
"""

from __future__ import annotations

import gzip
import json
import math
import os
import re
import secrets
import shutil
import stat
import sys
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, cast

from nao_kin._core.process import before_ending, uninterrupted
from nao_kin._core.text import MOST_SHOWN, abbreviated, quoted
from nao_kin.errors import BadArgument, BadInputFile

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


def would_replace(path: Path | str) -> bool:
    """Whether writing to `path` takes the place of a file that is there.

    Raises:
        BadArgument: as `check_writable`.
    """
    check_writable(path)
    target = replaced_file(path)
    return target is not None and target.exists()


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
        if not (target.replaceable and _replace(target, content)):
            with _opened(target) as stream:
                stream.write(content)


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
        with finished.open("rb") as content, _opened(target) as stream:
            shutil.copyfileobj(content, stream, _COPIED_AT_ONCE)
        finished.unlink()


@contextmanager
def _opened(target: _Target) -> Iterator[BinaryIO]:
    """A device, a pipe, a descriptor, or a file that keeps its place, open for writing."""
    if target.descriptor == _STANDARD_OUTPUT and sys.stdout is not None:
        sys.stdout.flush()  # what was printed before stays before
    place = target.path if target.descriptor is None else os.dup(target.descriptor)
    # Half a file is nobody's; a pipe may take as long as its reader likes.
    with uninterrupted() if target.replaceable else nullcontext(), open(place, "wb") as stream:
        yield stream


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
        import fcntl

        if fcntl.fcntl(descriptor, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
            raise OSError("it is not open for writing")
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

    with before_ending(remove):
        try:
            yield os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), temporary
        finally:
            remove()


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


# --- Folders of files that are written whole or not at all, and that never take away what somebody else has put there.


def check_folder(path: Path | str, *, overwrite: bool) -> None:
    """Raise what `write_folder` would raise whatever the files are, before the work whose result they are.

    Raises:
        BadArgument: no path, a file is there, the folder is there and may not be replaced, or none can be there.
    """
    with errors_naming(path):
        _folder_target(path, overwrite)


def write_folder(path: Path | str, files: Mapping[str, bytes], *, overwrite: bool = False) -> tuple[Path, ...]:
    """Make `path` a folder with these files and no others.

    The files are written to a temporary folder first. A new folder is that one, by one rename; one that is there
    already stays, with its mode, for somebody may be working in it, and files get into it by renames. Files there are
    replaced only where that is asked for, and only where there are none of other names.

    Args:
        path: the folder; the one it lies in must be there.
        files: name relative to the folder, with "/" between folders → content.
        overwrite: replace the files of a folder that is there.

    Returns:
        The files, in the given order.

    Raises:
        BadArgument: no path, a file is there, the folder is there and may not be replaced, or it cannot be written.
    """
    with errors_naming(path):
        target = _folder_target(path, overwrite)
        if target.is_dir():
            strange = sorted({file.relative_to(target).as_posix() for file in _files_in(target)} - {*files})
            if strange:
                others = f"it holds {len(strange)} other files, first {quoted(strange[0])}"
                raise BadArgument(f"cannot replace {abbreviated(target)}: {others}")
            _swap(target, files)
        else:
            with filled_folder(target.parent, files) as fresh:
                fresh.rename(target)
    return tuple(Path(path) / name for name in files)


@contextmanager
def filled_folder(parent: Path, files: Mapping[str, bytes]) -> Iterator[Path]:
    """A new folder in `parent` that holds the files; whatever happens, nothing of that name is left afterwards."""
    fresh = parent / f".nao_kin-{secrets.token_hex(8)}"

    def remove() -> None:
        shutil.rmtree(fresh, ignore_errors=True)

    with before_ending(remove):
        try:
            fresh.mkdir()
            for name, content in files.items():
                file = fresh / name
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(content)
            yield fresh
        finally:
            remove()


def is_there(path: Path | str, how: str = "already") -> BadArgument:
    """What to raise for a path that is there and may not be replaced."""
    return BadArgument(f"{abbreviated(path)} is there {how}; overwrite=True (--force) replaces it")


def _folder_target(path: Path | str, overwrite: bool) -> Path:
    """The folder that a path leads to, as far as it may be filled whatever the files are."""
    if not os.fspath(path):
        raise ValueError("no folder name")
    target = Path(os.path.realpath(path))
    if target.is_dir():
        if not overwrite and next(_files_in(target), None) is not None:
            raise is_there(target)
    elif os.path.exists(path):
        raise BadArgument(f"cannot write {abbreviated(path)}: it is a file, and a folder is to be written")
    else:
        os.stat(f"{target.parent}{os.sep}")  # with a separator at its end, a file is an error
    return target


def _files_in(folder: Path) -> Iterator[Path]:
    """All that is no folder, links to folders too."""
    return (path for path in folder.rglob("*") if path.is_symlink() or not path.is_dir())


def _swap(target: Path, files: Mapping[str, bytes]) -> None:
    """Put what is at the top of the new folder in the place of what is there; all of it, or nothing."""
    tops = dict.fromkeys(name.split("/")[0] for name in files)
    with filled_folder(target, {f"new/{name}": content for name, content in files.items()}) as fresh, uninterrupted():
        (fresh / "old").mkdir()
        done: list[tuple[Path, Path]] = []
        try:
            for top in tops:
                if os.path.lexists(target / top):
                    done.append((target / top, (target / top).rename(fresh / "old" / top)))
                done.append((fresh / "new" / top, (fresh / "new" / top).rename(target / top)))
        except BaseException:
            for before, after in reversed(done):
                after.rename(before)
            raise


# --- A document and the files that it names, put beside each other whole or not at all.


def check_replaceable(path: Path | str, *, overwrite: bool) -> None:
    """Raise what `write_document` would raise for the document alone, before the work whose result it is.

    Raises:
        BadArgument: no path, a file that is there, or one that cannot be written.
    """
    if would_replace(path) and not overwrite:
        raise is_there(path)


def write_document(
    path: Path | str, content: bytes, beside: Mapping[str, bytes] | None = None, *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Write a document, and files in its folder that it names.

    All of them are written to a folder of their own first and get to their places by renames, the document last. Files
    beside it that are there already with the same content stay as they are.

    Args:
        path: the document.
        content: what it holds.
        beside: name relative to the document's folder, with "/" between folders → content.
        overwrite: replace what is there.

    Returns:
        The document, and the files beside it in the given order.

    Raises:
        BadArgument: no path, a file is there and may not be replaced, or one cannot be written.
    """
    beside = beside or {}
    check_replaceable(path, overwrite=overwrite)
    target = replaced_file(path)
    if target is None:
        if beside:
            raise BadArgument(f"{abbreviated(path)} takes one file, and {len(beside)} are to stand beside it")
        write_bytes(path, content)
        return (Path(path),)
    folder = Path(path).parent
    with errors_naming(path):
        fresh = {name: data for name, data in beside.items() if not _is_there(folder / name, data, overwrite)}
        _put(folder, fresh, path, content)
    return (Path(path), *(folder / name for name in beside))


def _is_there(file: Path, data: bytes, overwrite: bool) -> bool:
    """Whether the file is there with this content.

    Raises:
        BadArgument: it is there with another one, and may not be replaced.
    """
    if not file.exists():
        return False
    if file.is_file() and file.stat().st_size == len(data) and file.read_bytes() == data:
        return True
    if not overwrite or not file.is_file():
        raise is_there(file, "with another content")
    return False


def _put(folder: Path, beside: Mapping[str, bytes], path: Path | str, content: bytes) -> None:
    if not beside:
        write_bytes(path, content)
        return
    made: list[Path] = []
    with filled_folder(folder, beside) as fresh, uninterrupted():
        try:
            for name in beside:
                place = folder / name
                for parent in reversed([parent for parent in place.parents if not parent.exists()]):
                    parent.mkdir()
                    made.append(parent)
                if not place.exists():
                    made.append(place)
                os.replace(fresh / name, place)
            write_bytes(path, content)
        except BaseException:
            for there in reversed(made):
                there.rmdir() if there.is_dir() else there.unlink(missing_ok=True)
            raise


# --- The text of a file that a user names, or of standard input.

# Of what is unpacked, and of a pipe or device, which may have no end.
MOST_BYTES = 1 << 30


def read_bounded(file: BinaryIO | gzip.GzipFile, name: str) -> bytes:
    """All of an open file.

    Raises:
        BadInputFile: it is no regular file, or is unpacked while it is read, and has more than 2³⁰ bytes.
    """
    try:
        regular = not isinstance(file, gzip.GzipFile) and stat.S_ISREG(os.fstat(file.fileno()).st_mode)
    except (OSError, ValueError):  # held in memory
        regular = True
    if regular:
        return file.read()
    data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        what = "when it is unpacked" if isinstance(file, gzip.GzipFile) else "and no regular file; it may have no end"
        raise BadInputFile(name, f"more than {MOST_BYTES} bytes {what}")
    return data


def opened(name: str, *, unpack: bool = True) -> BinaryIO:
    """A file, unpacked where its name ends in .gz and that is wanted, or standard input for "-", open to be read."""
    if name == "-":
        if sys.stdin is None:
            raise BadInputFile(name, "closed; there is nothing to read")
        return sys.stdin.buffer
    return cast(BinaryIO, gzip.open(name)) if unpack and name.lower().endswith(".gz") else Path(name).open("rb")


def read_bytes(name: str, *, unpack: bool = True) -> bytes:
    """All of what `opened` opens.

    Raises:
        BadInputFile: it cannot be read.
    """
    try:
        file = opened(name, unpack=unpack)
        with nullcontext() if name == "-" else file:
            return read_bounded(file, name)
    except OSError as error:
        raise BadInputFile(name, f"cannot be read: {error.strerror or error}") from None
    except (EOFError, zlib.error) as error:
        raise BadInputFile(name, f"no whole gzip file: {error}") from None
    except ValueError as error:  # a NUL in its name
        raise BadInputFile(abbreviated(name), f"cannot be read: {error}") from None


def read_text(name: str, advice: str = "") -> str:
    """The text of a file, unpacked where its name ends in .gz, or of standard input for "-"; no byte order mark.

    Args:
        name: which.
        advice: what the message says of a file that is no text.

    Raises:
        BadInputFile: it cannot be read, or is no UTF-8 text.
    """
    try:
        return read_bytes(name).decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise BadInputFile(name, f"not UTF-8 text (byte {error.start}){advice}") from None


# --- TOML files.


def read_toml(path: Path | str) -> dict[str, Any]:
    """Return the document in a TOML file.

    Raises:
        BadArgument: no path.
        BadInputFile: the file cannot be read, or is no TOML.
    """
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        with Path(path).open("rb") as file:
            document: dict[str, Any] = tomllib.loads(read_bounded(file, str(path)).decode())
    except TypeError:
        raise BadArgument(f"expected the path of a TOML file, got {quoted(path)}") from None
    except OSError as error:
        raise BadInputFile(str(path), f"cannot be read: {error.strerror or error}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise BadInputFile(str(path), f"not well-formed TOML: {error}") from None
    except ValueError as error:  # a path that no system takes, a number of thousands of digits
        raise BadInputFile(str(path), f"cannot be read: {error}") from None
    return document


# --- JSON files.


class JsonConstant(str):
    """NaN, Infinity or -Infinity, which JSON does not know and Python's reader takes; kept to be refused by name."""


def read_json(name: str, text: str) -> Any:
    """The value of a JSON text.

    Raises:
        BadInputFile: no JSON, with line and column; a name twice in one object, too deep.
    """

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            keys = [key for key, _ in pairs]
            twice = next(key for index, key in enumerate(keys) if key in keys[:index])
            raise BadInputFile(name, f"{quoted(twice)} is given twice in one object")
        return found

    try:
        return json.loads(text, object_pairs_hook=unique, parse_constant=JsonConstant)
    except json.JSONDecodeError as error:
        raise BadInputFile(name, f"malformed JSON: {error.msg}", error.lineno, error.colno) from None
    except BadInputFile:
        raise
    except (ValueError, RecursionError) as error:  # a number of thousands of digits, lists in lists in lists
        raise BadInputFile(name, f"JSON of too long numbers or too deep lists: {error}") from None


def is_finite_number(value: Any) -> bool:
    """Whether a JSON value is a number that floating point can hold."""
    try:
        return type(value) in (int, float) and math.isfinite(value)
    except OverflowError:
        return False


def described(value: Any) -> str:
    """What stands in a file where something else was expected."""
    if isinstance(value, JsonConstant):
        return str(value)
    if value is None or isinstance(value, bool):
        return "null" if value is None else str(value).lower()
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    if isinstance(value, (int, float)) and not is_finite_number(value):
        return "a number too large for floating point"
    return abbreviated(quoted(value, MOST_SHOWN), MOST_SHOWN)
