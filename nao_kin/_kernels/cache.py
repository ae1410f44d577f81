"""Functions that Numba compiles once on a machine and caches on its disk.

Each kernel has a folder in the user's cache, so that the package may be installed in a read-only place. The folder's
name is the kernel's fingerprint; folders with old fingerprints are removed after a month without use. Kernels are also
read from a read-only cache, as in a container image. If there is no cache, every process compiles them and warns once.

`first_rows` runs a kernel that is not compiled yet as Python, as long as this is faster than waiting, while another
process compiles it. A lock for each kernel keeps two processes from compiling the same one.
"""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import sys
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Annotated, Any, TypeAlias, TypeVar, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, is_several
from nao_kin._core.extras import command
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import need_extra, warn_caller
from nao_kin._kernels.folder import (
    IS_POSIX,
    WAITING,
    NotTrusted,
    cache_folder,
    compile_lock,
    fingerprint,
    folder_mode,
    lock_file,
    trusted,
)
from nao_kin.errors import BadArgument, MissingExtra, NotCachedWarning, NotCompiledWarning, UnknownName

if IS_POSIX:
    import fcntl

# --- With Numba, kernels are compiled; without Numba, they run as Python.

_NOTICEABLE_SECONDS = 2.0  # s


@cache
def numba_problem() -> str:
    """Return why Numba cannot be used, or "". It imports Numba, which takes half a second, so call it late."""
    if not IS_POSIX:
        return "compiled kernels need Linux, macOS or WSL"
    try:
        need_extra("", "batch")
    except MissingExtra as error:
        return f"numba does not load ({error.reason})" if error.reason else "numba is not installed"
    return ""


def has_numba() -> bool:
    """Return whether Numba can be used; NUMBA_DISABLE_JIT may still forbid compilation."""
    return not numba_problem()


def compiles() -> bool:
    """Return whether functions are compiled: Numba can be used, and NUMBA_DISABLE_JIT is not set."""
    if not has_numba():
        return False
    import numba

    return not numba.config.DISABLE_JIT


def may_compile() -> bool:
    """Return whether functions are compiled, as far as this is known without importing Numba."""
    if "numba" in sys.modules:
        return compiles()
    return IS_POSIX and _numba_is_installed() and os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")


@cache
def _numba_is_installed() -> bool:
    return importlib.util.find_spec("numba") is not None


class _Slowness:
    """The time spent in Python code that would be faster compiled."""

    def __init__(self) -> None:
        self._seconds, self._warned = 0.0, False

    def add(self, seconds: float) -> None:
        """Add seconds to the total, and warn once when the total becomes noticeable."""
        self._seconds += seconds
        if self._warned or self._seconds < _NOTICEABLE_SECONDS or has_numba():
            return
        self._warned = True
        warn_caller(
            f"{numba_problem()}: this runs as plain Python, with the same result but slowly; {command('batch')}",
            NotCompiledWarning,
        )


note_slowness = _Slowness().add
"""Called with the seconds that uncompiled code took; warns once in a process when they add up to two."""


# --- The kernels and their cache.

_THREADS = threading.RLock()  # one thread compiles, the others wait
_printed: set[str] = set()
KERNELS: dict[str, CachedKernel] = {}
"""The kernels of all modules that have been imported, by name."""
# Importing these modules makes all kernels.
_KERNEL_MODULES = "nao_kin._kernels.operations", "nao_kin.reach", "nao_kin.ik", "nao_kin.imitation.limbs"

# Time to read a kernel, with and without the import of Numba [s].
_IMPORT_SECONDS, READ_SECONDS = 1.0, 0.2
# If the rows take less time than this as Python, neither reading nor compiling a kernel pays [s].
_WORTH_COMPILING = 0.01
# After a background process that ended without a kernel, no other one is started for this time [s].
_PAUSE_SECONDS = 600.0
# Interval at which the use of a cached kernel is noted, and time after which an unused kernel may be removed [s].
_TOUCH_SECONDS, _UNUSED_SECONDS = 86400.0, 30 * 86400.0

# The program of the background process. It forks immediately, so that the starting process need not wait, and ends
# itself after an hour. It takes over `sys.path`, and so has the same packages without running start-up files again.
_BACKGROUND = """
import json, os, signal, sys
if os.fork():
    os._exit(0)
signal.alarm(3600)
os.nice(10)
sys.path[:] = json.loads(sys.argv[1])
from nao_kin._kernels.cache import compile_kernel
compile_kernel(sys.argv[2], sys.argv[3])
"""


@dataclass(frozen=True)
class KernelState:
    """A kernel that is ready to run.

    Attributes:
        name: its name.
        seconds: the time to load or compile it.
        compiled: whether it had to be compiled because it was not cached on disk.
        folder: the folder of its cache; None if it could not be cached.
    """

    name: str
    seconds: float
    compiled: bool
    folder: Path | None


class CachedKernel:
    """A function that is compiled, or read from the cache, when it is first needed; without Numba it runs as Python.

    `what` describes it on standard error, `name` also names the file that marks it as cached, `signature` returns the
    types of its arguments (None for those of its annotations), and `seconds` is the approximate time to compile it [s].
    """

    def __init__(
        self,
        function: Callable[..., Any],
        what: str,
        name: str,
        signature: Callable[[], Any] | None = None,
        seconds: float = 10.0,
    ) -> None:
        self._function, self.name = function, name
        self._signature = signature or partial(_argument_types, function)
        self._what, self._seconds = f"{what} (about {seconds:g} s)", seconds
        self._compiled: Callable[..., Any] | None = None
        self.entry_point: Callable[..., Any] | None = None
        self.python_seconds, self._started = 0.0, False
        KERNELS[name] = self

    @property
    def in_memory(self) -> bool:
        """Whether the compiled function is in memory, so that a call does not wait."""
        return self._compiled is not None

    def __call__(self, *arguments: Any) -> Any:
        """Return the result of the function."""
        return (self._compiled or self.ready())(*arguments)

    def ready(self) -> Callable[..., Any]:
        """Return the function to call: the compiled one if possible, otherwise the Python function."""
        if self._compiled is not None:
            return self._compiled
        if not compiles():
            return self.uncompiled
        with _THREADS:
            if self._compiled is None:
                self._compiled = self._load_or_compile()
            return self._compiled

    def uncompiled(self, *arguments: Any) -> Any:
        """Return the result of the function, run as Python."""
        started = time.thread_time()
        with np.errstate(all="ignore"):  # compiled code does not warn of infinities
            result = self._function(*arguments)
        note_slowness(time.thread_time() - started)
        return result

    def warm_up(self) -> KernelState:
        """Load the kernel or compile it now."""
        found, started = self._is_cached(), time.perf_counter()
        self.ready()
        seconds = time.perf_counter() - started
        return KernelState(self.name, seconds, not found, self.folder if self._is_cached() else None)

    def seconds_until_better(self) -> float:
        """Return how long to continue as Python before waiting for the kernel [s]; the time already spent counts."""
        # This is asked for every row; to check whether the folder is trusted takes longer than a row.
        if self.folder is not None and os.path.exists(self.folder / self.name):
            return (READ_SECONDS if "numba" in sys.modules else _IMPORT_SECONDS) - self.python_seconds
        return self._seconds - self.python_seconds

    def is_worthwhile(self) -> bool:
        """Return whether calls as Python have taken longer than to load the kernel; if it is not cached, compile it.

        Another process compiles it. The caller adds the time of each call to `python_seconds`, and asks after
        `READ_SECONDS`. So a loop of calls takes at most twice as long as with the better choice from the beginning,
        without knowing how many calls follow.
        """
        if not may_compile():
            return False
        if self.seconds_until_better() <= 0.0:
            return True
        if self.python_seconds >= _IMPORT_SECONDS:
            self.compile_in_background()
        return False

    def compile_in_background(self) -> None:
        """Start one process that compiles the kernel and may outlive this one, unless another process compiles it."""
        if self._started:
            return
        self._started = True
        # In a frozen program, or in one that embeds Python, `sys.executable` is not Python.
        is_python = Path(sys.executable or "").name.startswith("python") and not getattr(sys, "frozen", False)
        if self.folder is None or not is_python:
            return
        import subprocess

        try:
            if self._is_stored():
                return
            with _THREADS, lock_file(self.folder) as lock:
                # This raises an error if another process has locked a part of the file.
                fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                state = os.fstat(lock)
                if state.st_size and time.time() - state.st_mtime < _PAUSE_SECONDS:
                    return
            places = [*(entry for entry in sys.path if isinstance(entry, str)), str(Path(__file__).parents[2])]
            path = json.dumps([str(Path(entry).absolute()) for entry in places])
            _print_once(f"compiling {self._what} in the background, once on this machine …")
            subprocess.run(
                [sys.executable, "-I", "-S", "-c", _BACKGROUND, path, self._function.__module__, self.name],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
                timeout=60,
            )
        except NotTrusted as error:
            _warn_not_cached(str(error))
        except (OSError, subprocess.SubprocessError):
            pass

    def _load_or_compile(self) -> Callable[..., Any]:
        import shutil
        import tempfile

        folder, obstacle = self.folder, "no home directory, or no source of the kernels"
        if folder is not None:
            try:
                if self._is_stored():
                    self._mark_used(folder)
                    # Files damaged by a crash or another program are written again.
                    with suppress(Exception):
                        return self._compile(folder)
                waiting = f"waiting for another process that compiles {self._what} …"
                with compile_lock(folder, partial(_print_once, waiting)):
                    if self._is_stored():
                        with suppress(Exception):
                            return self._compile(folder)
                    shutil.rmtree(folder, ignore_errors=True)
                    folder.mkdir(folder_mode())
                    with tempfile.TemporaryFile(dir=folder):
                        pass
                    _print_once(f"compiling {self._what}, once on this machine …")
                    made = self._compile(folder)
                    (folder / self.name).touch()
                    for file in folder.iterdir():  # whatever the umask
                        file.chmod(file.stat().st_mode & ~0o022)
                    self._remove_unused(folder)
                    return made
            except (OSError, RuntimeError) as error:  # Numba raises a RuntimeError for a read-only folder
                obstacle = f"{quoted(str(folder))}: {error}"
        _warn_not_cached(obstacle)
        _print_once(f"compiling {self._what} …")
        return self._compile(None)

    def _compile(self, folder: Path | None) -> Callable[..., Any]:
        """Return the function compiled or read from a folder, and cached there unless it is None."""
        import numba

        register_functions()
        signature = self._signature()
        compiled = numba.njit(nogil=True, error_model="numpy")(self._function)
        with ExitStack() as opened:
            if folder is not None:
                compiled._cache = _numba_cache(self._function, opened.enter_context(trusted(folder)), folder.name)
            compiled.compile(signature)
        compiled.disable_compile()
        self.entry_point = next(iter(compiled.overloads.values())).entry_point
        return compiled  # type: ignore[no-any-return]

    def _mark_used(self, folder: Path) -> None:
        """Note the use of the kernel, which keeps it from being removed for a month, if its folder is writable."""
        marker = folder / self.name
        with suppress(OSError):
            if time.time() - marker.stat().st_mtime > _TOUCH_SECONDS:
                marker.touch()
                self._remove_unused(folder)

    def _remove_unused(self, folder: Path) -> None:
        """Remove folders of this kernel with other fingerprints that have not been used for long."""
        import shutil

        with suppress(OSError):
            for former in set(folder.parent.iterdir()) - {folder}:
                marker = former / self.name
                with suppress(OSError):  # it belongs to another kernel, is read-only or in use
                    if time.time() - marker.stat().st_mtime > _UNUSED_SECONDS:
                        with lock_file(former) as lock:
                            fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                            # A process that is reading here finds files missing, and compiles the kernel.
                            marker.unlink()
                            shutil.rmtree(former)
                            former.with_suffix(".lock").unlink()

    def _is_cached(self) -> bool:
        with suppress(OSError):
            return self._is_stored()
        return False

    def _is_stored(self) -> bool:
        """Do as `_is_cached`, but raise `NotTrusted` if others may have written the kernel."""
        if self.folder is None or not os.path.exists(self.folder / self.name):
            return False
        with trusted(self.folder):
            return True

    @cached_property
    def folder(self) -> Path | None:
        """The folder of its cache; None if it cannot be cached."""
        parent = cache_folder()
        if parent is None:
            return None
        try:
            return Path(os.path.realpath(parent)) / fingerprint(self._function, self.name)
        except OSError:
            return None


def first_rows(
    kernels: Sequence[CachedKernel], run: Callable[[slice], object], count: int, at_once: int = 1, each: float = 0.0
) -> int:
    """Run the first rows as Python as long as this is faster than waiting for the kernels; return their number.

    `run` computes a slice of `at_once` rows with `CachedKernel.uncompiled`; `each` is an upper bound for the time of a
    row as Python [s], which measured times replace.
    """
    lacking = [kernel for kernel in kernels if not kernel.in_memory]
    if not lacking or not may_compile():
        return 0
    done, seconds, left = 0, 0.0, count * each
    while True:
        if left + sum(kernel.python_seconds for kernel in lacking) >= _WORTH_COMPILING:
            if done < count and left >= sum(kernel.seconds_until_better() for kernel in lacking):
                return done
            for kernel in lacking if done else ():
                kernel.compile_in_background()
        if done == count:
            return done
        part, started = slice(done, min(done + at_once, count)), time.perf_counter()
        run(part)
        took = time.perf_counter() - started
        for kernel in lacking:
            kernel.python_seconds += took / len(lacking)
        done, seconds = part.stop, seconds + took
        left = seconds / done * (count - done)


def warm_up(names: Iterable[str] | None = None) -> tuple[KernelState, ...]:
    """Compile kernels, or read them from the cache, so that later calls do not wait for them.

    Args:
        names: names of kernels, such as "ik kernel, legs"; None for all kernels of the package.

    Returns:
        The state of each kernel; empty without Numba, where nothing is compiled.

    Examples:
        >>> [state.name for state in nk.warm_up(["ik kernel, heads"])]
        ['ik kernel, heads']
    """
    if names is not None and not is_several(names):
        raise BadArgument(f"names must be names of kernels, got {quoted(names)}")
    if not has_numba():
        return ()
    for module in _KERNEL_MODULES:
        importlib.import_module(module)
    wanted = tuple(KERNELS if names is None else names)
    for name in wanted:
        if not isinstance(name, str) or name not in KERNELS:
            raise UnknownName("kernel", name, tuple(KERNELS))
    return tuple(KERNELS[name].warm_up() for name in wanted)


def compile_kernel(module: str, name: str) -> None:
    """Compile and cache a kernel of a module, one kernel at a time, unless another process waits to compile it."""
    importlib.import_module(module)
    kernel, folder = KERNELS[name], KERNELS[name].folder
    if folder is None or not compiles():
        return
    with suppress(BlockingIOError, PermissionError), lock_file(folder) as lock:
        fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, WAITING)
        with lock_file(folder.with_name("background")) as turn:
            fcntl.lockf(turn, fcntl.LOCK_EX)
            kernel.warm_up()


def _numba_cache(function: Callable[..., Any], folder: Path, stamp: str) -> Any:
    """Return Numba's cache of a function in a folder; the stamp identifies the source.

    Numba's own choice depends on the bytes and lines of the function's file, and ignores the functions that it calls;
    and it does not read from a read-only folder.
    """
    from numba.core import caching

    class Locator(caching._CacheLocator):  # type: ignore[misc]
        _py_file = function.__code__.co_filename

        def get_cache_path(self) -> str:
            return str(folder)

        def get_source_stamp(self) -> str:
            return stamp

        def get_disambiguator(self) -> str:
            return "kernel"

        @classmethod
        def from_function(cls, function: Callable[..., Any], file: str) -> Locator:
            return cls()

    class Implementation(caching.CompileResultCacheImpl):  # type: ignore[misc]
        _locator_classes = (Locator,)

    class Cache(caching.FunctionCache):  # type: ignore[misc]
        _impl_class = Implementation

        def _index_key(self, signature: Any, codegen: Any) -> tuple[Any, ...]:
            # Numba adds a pickle of the closure. It contains paths, and its bytes change when Python reads the module
            # from its bytecode file; then the kernel would be compiled again. The stamp identifies the closure.
            return signature, codegen.magic_tuple()

    return Cache(function)


def _warn_not_cached(obstacle: str) -> None:
    """Warn once in a process that kernels are neither read from the cache nor written there."""
    if "warning" not in _printed:
        _printed.add("warning")
        warn_caller(
            f"compiled kernels cannot be cached ({abbreviated(obstacle)}); every process compiles them again "
            "(set NUMBA_CACHE_DIR to a folder that only you can write to)",
            NotCachedWarning,
        )


def _print_once(message: str) -> None:
    """Print the reason for a delay to standard error, once in a process."""
    if message not in _printed and sys.stderr is not None:
        with suppress(OSError, ValueError):
            # In one write, because another thread may print at the same time.
            print(f"nao_kin: {message}\n", end="", file=sys.stderr)  # noqa: T201
    _printed.add(message)


# --- Functions that run as Python and that compiled code may call, too.

_Function = TypeVar("_Function", bound=Callable[..., Any])
_unregistered: list[Callable[..., Any]] = []


def both_ways(function: _Function) -> _Function:
    """Return the function itself, and let compiled code call it too."""
    _unregistered.append(function)
    return function


def register_functions() -> None:
    """Register the functions marked with `both_ways` in Numba, before a kernel is compiled or read."""
    from numba.extending import register_jitable

    while _unregistered:
        register_jitable(error_model="numpy", no_cfunc_wrapper=True)(_unregistered.pop())


# --- Types of the arguments of kernels.

# Contiguous arrays: the type of number, and the number of axes. As Python, a `Row` may also be a list.
Row: TypeAlias = Annotated[Any, "float64", 1]
Floats1: TypeAlias = Annotated[Floats, "float64", 1]
Floats2: TypeAlias = Annotated[Floats, "float64", 2]
Floats3: TypeAlias = Annotated[Floats, "float64", 3]
Floats4: TypeAlias = Annotated[Floats, "float64", 4]
IntRow: TypeAlias = Annotated[Any, "int64", 1]
Ints1: TypeAlias = Annotated[NDArray[np.int64], "int64", 1]
Ints2: TypeAlias = Annotated[NDArray[np.int64], "int64", 2]


def numba_type(hint: Any) -> Any:
    """Return Numba's type of a type hint: a number, an array as above, or a tuple, named or not, of such types."""
    from numba import types

    if hasattr(hint, "__metadata__"):
        number, axes = hint.__metadata__
        return types.Array(getattr(types, number), axes, "C")
    if hint in (bool, int, float):
        return {bool: types.boolean, int: types.int64, float: types.float64}[hint]
    parts, named = get_args(hint), None
    if not parts:
        parts, named = tuple(get_type_hints(hint, include_extras=True).values()), hint
    return types.BaseTuple.from_types([numba_type(part) for part in parts], named)


def _argument_types(function: Callable[..., Any]) -> tuple[Any, ...]:
    hints = get_type_hints(function, include_extras=True)
    return tuple(numba_type(hint) for name, hint in hints.items() if name != "return")
