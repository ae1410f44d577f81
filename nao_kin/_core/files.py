"""Read files, and write them so that a reader sees either the old or the new content, never a part of it.

A symbolic link is followed and preserved. A device, a pipe and standard output are written directly.
"""

from __future__ import annotations

import gzip
import io
import json
import math
import os
import stat
import struct
import sys
import zlib
from collections.abc import Container, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import IO, Any, BinaryIO, cast

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.process import before_ending, uninterrupted
from nao_kin._core.text import MAX_SHOWN, abbreviated, quoted
from nao_kin.errors import BadArgument, BadInputFile, NaoKinError, WrongShape

# The folders of the URDFs of the NAO, one of which exists: in a wheel inside the package, in a checkout beside it.
URDF_FOLDERS = tuple(Path(__file__).resolve().parents[k] / name for k, name in ((1, "_urdf_files"), (2, "urdf")))

_COPIED_AT_ONCE = 1 << 20

# Kind of file → the noun for it, and the suffixes that its name may have.
_SUFFIXES = {
    "png": ("a picture", (".png",)),
    "video": ("a video", (".webm", ".zip")),
    "html": ("a page", (".html", ".htm")),
    "csv": ("a trajectory", (".csv", ".txt")),
    "toml": ("a table of offsets", (".toml",)),
}


def check_writable(path: Path | str, *, kind: str = "") -> None:
    """Raise the errors of `write_bytes` before the content is made; for a known kind, check the suffix too."""
    target = replaced_file(path)
    if target is not None:
        with errors_naming(path), _temporary_file(target):
            pass
    noun, suffixes = _SUFFIXES.get(kind, ("", ()))
    ending = Path(path).suffix
    if suffixes and ending and ending.lower() not in suffixes:
        written = f"{noun} is written as {suffixes[0][1:].upper()}"
        raise BadArgument(f"cannot write {abbreviated(path)}: {written}; end the name in {suffixes[0]}")


def leads_to_standard_output(path: Path | str) -> bool:
    """Return whether `path` is a name of this process's standard output."""
    return os.path.abspath(path) in ("/dev/stdout", "/dev/fd/1", "/proc/self/fd/1")


def replaced_file(path: Path | str) -> Path | None:
    """Return the file, without symbolic links, that `path` leads to; None for a device, a pipe or standard output."""
    with errors_naming(path):
        if not Path(path).name:
            raise ValueError("no file name")
        if os.fspath(path).endswith(os.sep):
            raise OSError("the path names a folder")
        if leads_to_standard_output(path):
            return None
        try:
            state = os.stat(path)
        except FileNotFoundError:
            return Path(os.path.realpath(path))
        if stat.S_ISDIR(state.st_mode):
            raise OSError("it is a folder")
        # A rename would replace a read-only file, and root may write to it.
        if not state.st_mode & 0o222:
            raise OSError(f"it is read-only (mode {stat.S_IMODE(state.st_mode):04o})")
        if not os.access(path, os.W_OK):
            raise OSError("permission denied")
        return Path(os.path.realpath(path)) if stat.S_ISREG(state.st_mode) else None


def write_text(path: Path | str, text: str) -> None:
    """Write `text` (UTF-8) to `path`, as `write_bytes` does."""
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path | str, content: bytes) -> None:
    """Write `content` to `path`: to a file by renaming a temporary file in the same folder, else directly."""
    target = replaced_file(path)
    with errors_naming(path), _temporary_file(target) if target else _opened(path) as file:
        file.write(content)
        if target:
            _rename(file, target)


def move_into_place(finished: Path, path: Path | str) -> None:
    """Rename a finished file to the target of `path`, in the same file system, or copy it to a device or a pipe."""
    target = replaced_file(path)
    with errors_naming(path), finished.open("rb") as content:
        if target:
            _rename(content, target)
            return
        import shutil

        with _opened(path) as stream:
            shutil.copyfileobj(content, stream, _COPIED_AT_ONCE)
        finished.unlink()


def _opened(path: Path | str) -> BinaryIO:
    """Open a device or a pipe for writing, or standard output after what has been printed."""
    if not leads_to_standard_output(path):
        return open(path, "wb")
    if sys.stdout is not None:
        sys.stdout.flush()
    return open(os.dup(1), "wb")


def _rename(finished: BinaryIO, target: Path) -> None:
    """Write a finished file to the disk, close it, and rename it to its target, whose mode and owner it takes over."""
    sync(finished)
    finished.close()
    with suppress(FileNotFoundError, PermissionError, AttributeError):  # Windows has no owners
        before = os.stat(target)
        os.chmod(finished.name, stat.S_IMODE(before.st_mode))
        os.chown(finished.name, before.st_uid, before.st_gid)
    os.replace(finished.name, target)


def sync(file: BinaryIO) -> None:
    """Write a file's content to the disk; a file that is renamed before may be empty after a power cut."""
    file.flush()
    os.fsync(file.fileno())


@contextmanager
def _temporary_file(target: Path) -> Iterator[BinaryIO]:
    """Yield a new file in the target's folder, which is removed at the end if it has not been renamed."""
    temporary = target.with_name(f".nao_kin-{os.urandom(8).hex()}")

    def remove() -> None:
        with suppress(OSError):
            temporary.unlink()

    with before_ending(remove):
        try:
            with temporary.open("xb") as file:
                yield file
        finally:
            remove()


@contextmanager
def errors_naming(path: object) -> Iterator[None]:
    """Turn errors inside the context into a `BadArgument` that says why the path cannot be written."""
    try:
        yield
    except BrokenPipeError:  # whoever reads has seen enough
        raise
    except OSError as error:
        raise BadArgument(f"cannot write {abbreviated(path)}: {error.strerror or error}") from None
    except (ValueError, TypeError) as error:
        raise BadArgument(f"cannot write {quoted(path)}: {error}") from None


# --- Folders of files, and documents with the extra files that they name. All files are written to a temporary folder
# first, and then renamed; other files are never removed.


def check_folder(path: Path | str, *, overwrite: bool) -> None:
    """Raise the errors of `write_folder` that do not depend on the files, before the work that produces them."""
    with errors_naming(path):
        _folder_target(path, overwrite)


def write_folder(path: Path | str, files: Mapping[str, bytes], *, overwrite: bool = False) -> tuple[Path, ...]:
    """Make `path` a folder with these files and no others; return the files, in the given order.

    A folder that has files is filled only with `overwrite`, and if it has no files of other names.
    """
    with errors_naming(path):
        target = _folder_target(path, overwrite)
        if target.is_dir():
            others = sorted({file.relative_to(target).as_posix() for file in _files_in(target)} - {*files})
            if others:
                reason = f"it contains {len(others)} other files, first {quoted(others[0])}"
                raise BadArgument(f"cannot replace {abbreviated(target)}: {reason}")
            with _filled_folder(target, files) as fresh, uninterrupted():
                _rename_all(fresh, target, files)
        else:
            with _filled_folder(target.parent, files) as fresh:
                fresh.rename(target)
    return tuple(Path(path) / name for name in files)


@contextmanager
def _filled_folder(parent: Path, files: Mapping[str, bytes]) -> Iterator[Path]:
    """Yield a new folder in `parent` that contains the files; it is removed at the end in any case."""
    import shutil

    fresh = parent / f".nao_kin-{os.urandom(8).hex()}"

    def remove() -> None:
        shutil.rmtree(fresh, ignore_errors=True)

    with before_ending(remove):
        try:
            fresh.mkdir()
            for name, content in files.items():
                (fresh / name).parent.mkdir(parents=True, exist_ok=True)
                with (fresh / name).open("xb") as file:
                    file.write(content)
                    sync(file)
            yield fresh
        finally:
            remove()


def _rename_all(fresh: Path, folder: Path, names: Iterable[str]) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        os.replace(fresh / name, folder / name)


def _already_exists(path: Path | str, how: str = "already exists") -> BadArgument:
    return BadArgument(f"{abbreviated(path)} {how}; overwrite=True (--force) replaces it")


def _folder_target(path: Path | str, overwrite: bool) -> Path:
    """Return the folder of a path, or raise if it may not be filled, whatever the files are."""
    if not os.fspath(path):
        raise ValueError("no folder name")
    target = Path(os.path.realpath(path))
    if target.is_dir():
        if not overwrite and next(_files_in(target), None) is not None:
            raise _already_exists(target)
    elif os.path.exists(path):
        raise BadArgument(f"cannot write {abbreviated(path)}: it is a file, and a folder is needed")
    else:
        os.stat(f"{target.parent}{os.sep}")  # the separator at the end makes a file raise an error
    return target


def _files_in(folder: Path) -> Iterator[Path]:
    """Yield everything that is not a folder, including links to folders."""
    return (path for path in folder.rglob("*") if path.is_symlink() or not path.is_dir())


def check_replaceable(path: Path | str, *, overwrite: bool) -> None:
    """Raise the errors of `write_document` for the document alone, before the work that produces it."""
    check_writable(path)
    target = replaced_file(path)
    if target is not None and target.exists() and not overwrite:
        raise _already_exists(path)


def write_document(
    path: Path | str, content: bytes, extras: Mapping[str, bytes] | None = None, *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Write a document, and the extra files in its folder that it names; return their paths.

    The document is renamed last. Extra files that have not changed stay.
    """
    extras = extras or {}
    check_replaceable(path, overwrite=overwrite)
    if extras and replaced_file(path) is None:
        raise BadArgument(f"{abbreviated(path)} takes one file, but {len(extras)} more must be next to it")
    folder = Path(path).parent
    with errors_naming(path):
        fresh = {name: data for name, data in extras.items() if not _is_unchanged(folder / name, data, overwrite)}
        if fresh:
            with _filled_folder(folder, fresh) as made, uninterrupted():
                _rename_all(made, folder, fresh)
                write_bytes(path, content)
        else:  # perhaps into a pipe, which takes as long as its reader likes
            write_bytes(path, content)
    return (Path(path), *(folder / name for name in extras))


def _is_unchanged(file: Path, data: bytes, overwrite: bool) -> bool:
    """Return whether the file exists with this content; raise `BadArgument` if it differs and may not be replaced."""
    if not file.exists():
        return False
    if file.is_file() and file.stat().st_size == len(data) and file.read_bytes() == data:
        return True
    if not overwrite or not file.is_file():
        raise _already_exists(file, "exists with other content")
    return False


# --- The content of a file that a user names, or of standard input.

# Largest content of a file that is read whole, and of all arrays in one: unpacked, in bytes and in numbers.
MAX_BYTES, MAX_NUMBERS = 1 << 30, 10**8


def read_bounded(file: BinaryIO | gzip.GzipFile, name: str) -> bytes:
    """Return the content of an open file, unpacked; at most 2³⁰ bytes: a pipe or a device may have no end."""
    content = io.BytesIO()
    while content.tell() <= MAX_BYTES and (block := file.read(_COPIED_AT_ONCE)):
        content.write(block)
    if content.tell() > MAX_BYTES:
        raise BadInputFile(name, f"more than {MAX_BYTES} bytes{' unpacked' * isinstance(file, gzip.GzipFile)}")
    return content.getvalue()


def opened(name: str, *, unpack: bool = True) -> BinaryIO:
    """Open a file to read, unpacked if its name ends in .gz and `unpack` is true, or standard input for "-"."""
    if name == "-":
        if sys.stdin is None:
            raise BadInputFile(name, "closed; there is nothing to read")
        return sys.stdin.buffer
    try:
        return cast(BinaryIO, gzip.open(name)) if unpack and name.lower().endswith(".gz") else Path(name).open("rb")
    except ValueError as error:  # a name that no file can have, such as one with a NUL
        raise BadInputFile(abbreviated(name), f"cannot be read: {error}") from None


def read_bytes(name: str, *, unpack: bool = True) -> bytes:
    """Return the content of what `opened` opens, or raise `BadInputFile`."""
    try:
        file = opened(name, unpack=unpack)
        with nullcontext() if name == "-" else file:
            return read_bounded(file, name)
    except OSError as error:
        raise BadInputFile(name, f"cannot be read: {error.strerror or error}") from None
    except (EOFError, zlib.error) as error:
        raise BadInputFile(name, f"not a complete gzip file: {error}") from None


def read_text(name: str, advice: str = "") -> str:
    """Return the text of a file (unpacked if named .gz) or of standard input for "-", without a byte order mark."""
    try:
        return read_bytes(name).decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise BadInputFile(name, f"not UTF-8 text (byte {error.start}){advice}") from None


def read_table_text(name: str, what: str, advice: str = "") -> tuple[str, bool]:
    """Return the text of a CSV or JSON file that holds `what`, as `read_text` does, and whether it is JSON."""
    text = read_text(name, advice or f"; expected {what}")
    if not text or text.isspace():
        raise BadInputFile(name, f"empty; expected {what}")
    return text, Path(name).suffix.lower() == ".json" or (name == "-" and text.lstrip()[0] in "[{")


# --- NumPy's files.


@contextmanager
def numpy_errors(name: str, wrong: str) -> Iterator[None]:
    """Turn errors of NumPy's and zipfile's readers inside the context into a `BadInputFile` that begins with `wrong`.

    Errors of the operating system pass, and too little memory: the file may be sound.
    """
    try:
        yield
    except (NaoKinError, MemoryError):
        raise
    except Exception as error:  # NumPy and zipfile raise errors of a dozen types for a broken file, tokenize's too
        if isinstance(error, OSError) and error.errno is not None:
            raise
        text = error.args[0] if error.args and isinstance(error.args[0], str) else error
        raise BadInputFile(name, f"{wrong}: {abbreviated(text)}") from None


_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


def read_arrays(
    name: str, data: bytes, wanted: Container[str] | None = None, *, wrong: str = "not a readable file of NumPy"
) -> dict[str, NDArray[Any]]:
    """Return the arrays in the bytes of a .npz file, by name, or the one of a .npy file under the name "".

    Nothing is unpickled. Only the `wanted` arrays of an archive are unpacked, and only after their stated sizes are
    found to be at most `MAX_BYTES` and `MAX_NUMBERS` together. An error is a `BadInputFile` that begins with `wrong`.
    """
    import zipfile  # imported late, because it imports shutil

    with numpy_errors(name, wrong):
        if not zipfile.is_zipfile(io.BytesIO(data)):
            _check_sizes(name, [(io.BytesIO(data), len(data))])
            return {"": np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)}
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            parts = {part.filename.removesuffix(".npy"): part for part in archive.infolist()}
            parts = {key: part for key, part in parts.items() if wanted is None or key in wanted}
            _check_sizes(name, ((archive.open(part), part.file_size) for part in parts.values()))
            found = {}
            for key, part in parts.items():
                with archive.open(part) as file:
                    found[key] = np.lib.format.read_array(file, allow_pickle=False)
            return found


def _check_sizes(name: str, files: Iterable[tuple[IO[bytes], int]]) -> None:
    """Refuse .npy files, each with its size, that state more than is read, or than they have."""
    size, count = 0, 0
    for opened_file, stated in files:
        with opened_file as file:
            shape, _, kind = _HEADERS[np.lib.format.read_magic(file)](file)
            if min(shape, default=0) < 0 or (math.prod(shape) * kind.itemsize > stated and not kind.hasobject):
                raise ValueError(f"{stated} bytes, too few for an array {abbreviated(shape)} of {abbreviated(kind)}")
            size, count = size + stated, count + math.prod(shape)
    if size > MAX_BYTES or count > MAX_NUMBERS:
        what = f"{size} bytes and {count} numbers unpacked"
        raise BadInputFile(name, f"{what}; at most {MAX_BYTES} bytes and {MAX_NUMBERS} numbers are read")


# --- TOML files.


def read_toml(path: Path | str) -> dict[str, Any]:
    """Return the document in a TOML file."""
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
    """NaN, Infinity or -Infinity: not valid JSON, but accepted by Python's reader; later checks refuse them by name."""


def read_json(name: str, text: str) -> Any:
    """Return the value of a JSON text, or raise `BadInputFile`, also for duplicate names and too deep nesting."""

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
        raise BadInputFile(name, f"JSON with a number too long or lists too deep: {error}") from None


def is_finite_number(value: Any) -> bool:
    """Return whether a JSON value is a number that floating point can hold."""
    try:
        return type(value) in (int, float) and math.isfinite(value)
    except OverflowError:
        return False


def described(value: Any) -> str:
    """Describe a value of a file, for a message that says that something else was expected."""
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
    return abbreviated(quoted(value, MAX_SHOWN), MAX_SHOWN)


def png(image: NDArray[np.uint8]) -> bytes:
    """Return an image, shape (h, w, 3) or (h, w) of type uint8, as a PNG file, packed fast rather than small."""
    array = np.asarray(image)
    if not (array.size and (array.ndim == 2 or (array.ndim == 3 and array.shape[2] == 3))):
        raise WrongShape("image", "(h, w, 3) or (h, w)", array.shape)
    if array.dtype != np.uint8:
        raise BadArgument(f"image must have the type uint8, values from 0 to 255, got {array.dtype}")
    height, width = array.shape[:2]
    rows = np.zeros((height, 1 + array[0].size), np.uint8)  # each row begins with its filter, 0 for none
    rows[:, 1:] = array.reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, 0 if array.ndim == 2 else 2, 0, 0, 0)
    chunks = {b"IHDR": header, b"IDAT": zlib.compress(rows.tobytes(), 1), b"IEND": b""}
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks.items()
    )
