"""Functions that Numba compiles once on a machine and caches on its disk.

Each kernel is a file in the user's cache, so that the package may be installed in a read-only place. The file's name is
the kernel's fingerprint. Kernels are also read from a read-only cache, as in a container image. If there is no cache,
every process compiles them and warns once.

`first_rows` runs a kernel that is not compiled yet as Python, as long as this is faster than waiting, while a process
in the background compiles it. No two processes compile the same kernel.
"""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import pickle
import sys
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Annotated, Any, TypeAlias, TypeVar, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from nao_kin._core.arrays import Floats, choice, is_several
from nao_kin._core.extras import command
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import need_extra, warn_caller
from nao_kin._kernels.folder import (
    IS_POSIX,
    cache_folder,
    fingerprint,
    locked,
    private_folder,
    read_file,
    write_file,
)
from nao_kin._kernels.inner_functions import as_parts_of
from nao_kin.errors import BadArgument, MissingExtra, NotCachedWarning, NotCompiledWarning

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
    return IS_POSIX and _found("numba") is not None and os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")


_found = cache(importlib.util.find_spec)


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

# Time to read a kernel, with and without the import of Numba [s].
_IMPORT_SECONDS, READ_SECONDS = 1.0, 0.2
# If the rows take less time than this as Python, neither reading nor compiling a kernel pays [s].
_WORTH_COMPILING = 0.01
# While another background process runs, ask again after this time; after one for the same kernel, after this time [s].
_ASK_SECONDS, _PAUSE_SECONDS = 1.0, 600.0

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
        folder: the folder of compiled kernels; None if it could not be cached.
    """

    name: str
    seconds: float
    compiled: bool
    folder: Path | None


class CachedKernel:
    """A function that is compiled, or read from the cache, when it is first needed; without Numba it runs as Python.

    `what` describes it on standard error, `signature` returns the types of its arguments (None for those of its
    annotations), and `seconds` is the approximate time to compile it [s].
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
        self._was_compiled = True  # rather than read from the cache
        self._folder: Path | None = None  # where it is cached
        self.python_seconds = 0.0
        self.background_from = 0.0  # on the monotonic clock [s], the next time to ask for a background process
        KERNELS[name] = self

    @property
    def in_memory(self) -> bool:
        """Whether the compiled function is in memory, so that a call does not wait."""
        return self._compiled is not None

    @cached_property
    def file(self) -> Path | None:
        """The file of its cache; None if it cannot be cached."""
        folder = cache_folder()
        try:
            return folder and folder / f"{fingerprint(self._function, self.name)}.kernel"
        except (OSError, ImportError):  # no sources, or no metadata of Numba
            return None

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
        was_in_memory, started = self.in_memory, time.perf_counter()
        self.ready()
        seconds = time.perf_counter() - started
        return KernelState(self.name, seconds, self._was_compiled and not was_in_memory, self._folder)

    def seconds_until_better(self) -> float:
        """Return how long to continue as Python before waiting for the kernel [s]; the time already spent counts."""
        if self.file is not None and self.file.exists():
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
        """Start a process that compiles the kernel and may outlive this one, unless another one compiles any kernel."""
        now = time.monotonic()
        # In a frozen program, or in one that embeds Python, `sys.executable` is not Python.
        is_python = Path(sys.executable or "").name.startswith("python") and not getattr(sys, "frozen", False)
        if now < self.background_from or self.file is None or not is_python:
            return
        self.background_from = now + _ASK_SECONDS
        import subprocess

        try:
            with _THREADS, private_folder(self.file.parent) as folder, locked(folder, "background") as lock:
                tried = os.pread(lock, 99, 0) == self.file.name.encode()
                if self.file.exists() or (tried and time.time() - os.fstat(lock).st_mtime < _PAUSE_SECONDS):
                    return
            self.background_from = now + _PAUSE_SECONDS
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
        except (OSError, subprocess.SubprocessError):
            pass  # the kernel is compiled when it is waited for

    def _load_or_compile(self) -> Callable[..., Any]:
        import numba

        register_functions()
        signature = self._signature()
        compiled = numba.njit(nogil=True, error_model="numpy")(self._function)

        def compile_now() -> None:
            with as_parts_of(self._function.__qualname__):
                compiled.compile(signature)

        try:
            if self.file is None:
                raise OSError("no home directory, or no source of the kernels")
            with private_folder(self.file.parent) as folder:
                if not self._load(folder, compiled):
                    wait = partial(_print_once, f"waiting for another process that compiles {self._what} …")
                    with locked(folder, "lock", int(self.file.stem, 16) >> 1, wait):
                        if not self._load(folder, compiled):
                            _print_once(f"compiling {self._what}, once on this machine …")
                            compile_now()
                            self._store(folder, compiled)
            self._folder = self.file.parent
        except OSError as error:
            _warn_not_cached(f"{quoted(str(self.file.parent))}: {error}" if self.file else str(error))
        if not compiled.overloads:
            _print_once(f"compiling {self._what} …")
            compile_now()
        compiled.disable_compile()
        self.entry_point = next(iter(compiled.overloads.values())).entry_point
        return compiled  # type: ignore[no-any-return]

    # Numba's own cache depends on the bytes and lines of the function's file, ignores the functions that it calls, and
    # trusts folders that others can write to.

    def _load(self, folder: int, compiled: Any) -> bool:
        """Load the function from its file; return whether it is there, undamaged, and for this processor."""
        from numba.core.compiler import CompileResult

        context, content = compiled.targetctx, read_file(folder, self.file.name) if self.file else None
        context.refresh()
        with suppress(Exception):
            processor, reduced = pickle.loads(content or b"")
            if processor == context.codegen().magic_tuple():
                made = CompileResult._rebuild(context, *reduced)
                context.insert_user_function(made.entry_point, made.fndesc, [made.library])
                compiled.add_overload(made)
                self._was_compiled = False
        return bool(compiled.overloads)

    def _store(self, folder: int, compiled: Any) -> None:
        """Write the compiled function, unless Numba has put addresses of this process into it."""
        from numba.core.serialize import dumps

        (made,) = compiled.overloads.values()
        if self.file and not made.library.has_dynamic_globals:
            write_file(folder, self.file.name, dumps((made.codegen.magic_tuple(), made._reduce())))


def first_rows(kernels: Sequence[CachedKernel], run: Callable[[slice], object], count: int, each: float = 0.0) -> int:
    """Run the first rows as Python as long as this is faster than waiting for the kernels; return their number.

    `run` computes a slice of one row with `CachedKernel.uncompiled`; `each` is an upper bound for the time of a row as
    Python [s], which measured times replace.
    """
    lacking = [kernel for kernel in kernels if not kernel.in_memory]
    if not lacking or not may_compile():
        return 0
    seconds, left = 0.0, count * each
    for done in range(count + 1):
        if left + sum(kernel.python_seconds for kernel in lacking) >= _WORTH_COMPILING:
            if done < count and left >= sum(kernel.seconds_until_better() for kernel in lacking):
                return done
            for kernel in lacking if done else ():
                kernel.compile_in_background()
        if done < count:
            started = time.perf_counter()
            run(slice(done, done + 1))
            took = time.perf_counter() - started
            for kernel in lacking:
                kernel.python_seconds += took / len(lacking)
            seconds += took
            left = seconds / (done + 1) * (count - done - 1)
    return count


def warm_up(names: Iterable[str] | None = None) -> tuple[KernelState, ...]:
    """Compile kernels of imported modules, or read them from the cache; see `nao_kin.warm_up`."""
    if names is not None and not is_several(names):
        raise BadArgument(f"names must be names of kernels, got {quoted(names)}")
    if not has_numba():
        return ()
    wanted = [choice(name, KERNELS, "kernel") for name in (KERNELS if names is None else names)]
    return tuple(KERNELS[name].warm_up() for name in wanted)


def compile_kernel(module: str, name: str) -> None:
    """Compile and cache a kernel of a module, after the background processes that have begun before."""
    importlib.import_module(module)
    kernel = KERNELS[name]
    if kernel.file is not None and compiles():
        with private_folder(kernel.file.parent) as folder, locked(folder, "background", wait=int) as lock:
            os.pwrite(lock, kernel.file.name.encode(), 0)
            kernel.warm_up()


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
