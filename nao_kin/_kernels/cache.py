"""Functions compiled by Numba once on a machine, and kept on its disk.

The folder is the user's own cache, so that the package may be installed where nobody can write. The name of a kernel's
folder is its fingerprint; folders of former fingerprints are removed when nobody has used them for a month. Kernels are
read from a folder that cannot be written, too, as in an image of a container.
Where nothing can be kept, they are compiled in every process, with one warning.

A kernel that has not been compiled yet need not be waited for: `first_rows` calls its source as Python for as long as
that is quicker, while a process of its own compiles. A lock for each kernel keeps two processes from compiling the
same one.
"""

from __future__ import annotations

import ast
import fcntl
import hashlib
import importlib
import importlib.metadata
import importlib.util
import inspect
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, TypeVar

import numpy as np

from nao_kin._core.extras import command
from nao_kin._core.text import abbreviated, quoted
from nao_kin._core.warn import need_extra, warn_caller
from nao_kin.errors import BadArgument, MissingExtra, NotCachedWarning, NotCompiledWarning, UnknownName

# --- Whether Numba is here: with it kernels are compiled, without it they run as the Python that they are written in.

_FELT = 2.0  # s


@cache
def numba_problem() -> str:
    """Why Numba cannot be used; "" where it can. Importing it takes half a second, so ask where it is needed next."""
    try:
        need_numba("")
    except MissingExtra as error:
        return f"numba does not load ({error.reason})" if error.reason else "numba is not installed"
    return ""


def need_numba(purpose: str) -> None:
    """Refuse to go on without Numba.

    Args:
        purpose: what needs it, as the message begins.

    Raises:
        MissingExtra: it is not installed, or does not load: it refuses a NumPy newer than itself.
    """
    need_extra(purpose, "batch")


def has_numba() -> bool:
    """Whether Numba can be used, though it may be told not to compile (NUMBA_DISABLE_JIT)."""
    return not numba_problem()


def compiles() -> bool:
    """Whether functions are compiled: Numba is here, and NUMBA_DISABLE_JIT is not set."""
    if not has_numba():
        return False
    import numba

    return not numba.config.DISABLE_JIT


def may_compile() -> bool:
    """Whether functions are compiled, as far as that can be seen without importing Numba."""
    if "numba" in sys.modules:
        return compiles()
    return importlib.util.find_spec("numba") is not None and os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")


class _Slowness:
    """What was computed where compiled code would have been quicker."""

    def __init__(self) -> None:
        self._seconds, self._said = 0.0, False

    def add(self, seconds: float) -> None:
        """Add up, and warn once when it is felt."""
        self._seconds += seconds
        if self._said or self._seconds < _FELT or has_numba():
            return
        self._said = True
        warn_caller(
            f"{numba_problem()}: this runs in plain Python, with the same result and slowly; {command('batch')}",
            NotCompiledWarning,
        )


note_slowness = _Slowness().add
"""Called with the seconds that something uncompiled took: after two of them in a process, a warning says so, once."""


# --- Fingerprints of compiled kernels, which change with the code, the compiler and the processor, and nothing else.

_CONSTANTS = (bool, int, float, complex, str, bytes, tuple, dict, np.generic, type(None))
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
# The lines of /proc/cpuinfo that tell one kind of processor from another.
_PROCESSOR_LINES = ("model name", "flags", "CPU part", "Features")


def fingerprint(function: Callable[..., Any], name: str) -> str:
    """Return sixteen hexadecimal digits that identify a kernel.

    They depend on Python, Numba, NumPy, the processor, the syntax trees of all modules that the function takes
    functions and classes from, directly or through other functions, and the values of the constants it uses. Comments,
    docstrings, line numbers and the place of the files do not count.

    Args:
        function: the source of the kernel.
        name: the name of the kernel.

    Raises:
        OSError: the source of a module is missing.
    """
    modules, constants = _dependencies(function)
    parts = [name, str(sys.implementation.cache_tag), _version("numba"), np.__version__, _processor()]
    parts += [os.environ.get(variable, "") for variable in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")]
    parts += [f"{module}: {_tree(module)}" for module in sorted(modules)]
    parts += sorted(constants)
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


def _dependencies(function: Callable[..., Any]) -> tuple[set[str], set[str]]:
    """The modules of a function and of all that it uses of its own package, and the constants it uses."""
    package = function.__module__.partition(".")[0]
    modules: set[str] = set()
    constants: set[str] = set()
    seen: set[int] = set()
    waiting: list[Any] = [function]
    while waiting:
        value = waiting.pop()
        # What Numba has made of a function has it as an attribute.
        value = getattr(value, "py_func", None) or getattr(value, "__wrapped__", value)
        if id(value) in seen:
            continue
        seen.add(id(value))
        if str(getattr(value, "__module__", "")).partition(".")[0] != package:
            continue
        if isinstance(value, type):
            modules.add(value.__module__)
            waiting += vars(value).values()
        elif isinstance(value, FunctionType):
            modules.update((value.__module__, value.__globals__["__name__"]))  # a factory may give it another one
            for place, used in _globals_used(value):
                name = f"{value.__module__}.{place}"
                if isinstance(used, np.ndarray):
                    constants.add(f"{name}: {used.dtype} {used.shape} {used.tobytes().hex()}")
                elif isinstance(used, _CONSTANTS):
                    constants.add(f"{name}: {used!r}")
                else:
                    waiting.append(used)
    return modules, constants


def _globals_used(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Global values and values of enclosing functions that a function names, in its code or its annotations."""
    names = set(_names(function.__code__))
    for annotation in function.__annotations__.values():
        names.update(re.findall(r"\w+", str(annotation)))
    for name in sorted(names & function.__globals__.keys()):
        yield name, function.__globals__[name]
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        with suppress(ValueError):  # not yet filled
            yield name, cell.cell_contents


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


@cache
def _tree(module: str) -> str:
    """The syntax tree of a module without docstrings."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    for node in ast.walk(tree):
        if isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            del node.body[0]
    return ast.dump(tree)


@cache
def _version(package: str) -> str:
    """The version of a package, which need not be imported for that."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return ""


@cache
def _processor() -> str:
    """The kind of processor. Numba compares it more closely when it reads a kernel; asking LLVM takes 0.1 s."""
    try:
        first = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").split("\n\n")[0]
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    return "\n".join(line for line in first.splitlines() if line.startswith(_PROCESSOR_LINES)) or platform.machine()


# --- Functions compiled by Numba once on a machine, and kept on its disk.

_THREADS = threading.RLock()  # one thread compiles, the others wait
_said: set[str] = set()
KERNELS: dict[str, KeptKernel] = {}
"""The kernels of all modules that have been imported, by name."""
# The modules that make kernels when they are imported, or import those that do.
_HOMES = "nao_kin._kernels.operations", "nao_kin.reach", "nao_kin.ik"

# How long it takes to read a kernel, with Numba to be imported first and without [s].
_IMPORT_SECONDS, _READ_SECONDS = 1.0, 0.2
# Below this, neither a look at the disk nor a process in the background is worth it [s].
_WORTH_COMPILING = 0.01
# A background process that ended without a kernel is not followed by another one for so long [s].
_PAUSE_SECONDS = 600.0
# A use of a kept kernel is noted once in so long, and what has not been used for so long may be removed [s].
_NOTED_SECONDS, _UNUSED_SECONDS = 86400.0, 30 * 86400.0
# The byte of a lock file that is locked by who compiles, and by who waits to do it in the background.
_COMPILES, _WAITS = 0, 1

# Leaves the process that started it at once, and ends itself by a signal if it takes longer than anybody would wait.
# By `sys.path` it finds the same packages, without running the site's or the user's start-up files once more.
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
        name: which one.
        seconds: how long it took to get it ready.
        compiled: whether it had to be compiled, and was not found on disk.
        folder: where it is kept; None where it could not be kept.

    Examples:
        >>> state = nk.warm_up(["ik kernel, heads"])[0]
        >>> isinstance(state.name, str), state.seconds >= 0
        (True, True)
    """

    name: str
    seconds: float
    compiled: bool
    folder: Path | None


class KeptKernel:
    """A function that is compiled, or read from the disk, when it is first needed.

    Attributes:
        spent: how long `first_rows` has run it as Python in this process [s].

    Args:
        function: plain Python that Numba can compile; run as it stands where Numba is not installed or
            NUMBA_DISABLE_JIT is set.
        what: what is being compiled, for the line on standard error.
        name: name of the file that says that the kernel has been kept.
        signature: makes the types of its arguments.
        seconds: about how long it takes to compile [s].
    """

    def __init__(
        self, function: Callable[..., Any], what: str, name: str, signature: Callable[[], Any], seconds: float = 10.0
    ) -> None:
        self._function, self._name, self._signature = function, name, signature
        self._what, self._seconds = f"{what} (about {seconds:g} s)", seconds
        self._compiled: Callable[..., Any] | None = None
        self._entry: Callable[..., Any] | None = None
        self.spent, self._started = 0.0, False
        KERNELS[name] = self

    @property
    def name(self) -> str:
        """Name of the file that says that the kernel has been kept."""
        return self._name

    @property
    def in_memory(self) -> bool:
        """Whether it is compiled and can be called at once."""
        return self._compiled is not None

    @property
    def quick(self) -> Callable[..., Any] | None:
        """The compiled function, which takes arguments of exactly its types unchecked; None where it is not in memory.

        To look at the types of a hundred numbers takes Numba longer than a closed form takes to solve.
        """
        return self._entry

    def __call__(self, *arguments: Any) -> Any:
        """The result of the function."""
        return (self._compiled or self.ready())(*arguments)

    def ready(self) -> Callable[..., Any]:
        """The function to call: compiled where that can be, else as it stands."""
        if self._compiled is not None:
            return self._compiled
        if not compiles():
            return self.uncompiled
        with _THREADS:
            if self._compiled is None:
                self._compiled = self._made()
            return self._compiled

    def uncompiled(self, *arguments: Any) -> Any:
        """The result of the function, run as Python."""
        started = time.thread_time()
        with np.errstate(all="ignore"):  # compiled code does not warn of infinities
            result = self._function(*arguments)
        note_slowness(time.thread_time() - started)
        return result

    def warm_up(self) -> KernelState:
        """Get it ready now."""
        found, started = self._is_kept(), time.perf_counter()
        self.ready()
        seconds = time.perf_counter() - started
        return KernelState(self._name, seconds, not found, self.folder if self._is_kept() else None)

    def seconds_until_better(self) -> float:
        """How much longer to run the function as Python rather than wait for the kernel [s].

        The time that has been spent already counts, so that many quick calls are compiled in the end, too.
        """
        if self._is_kept():
            return (_READ_SECONDS if "numba" in sys.modules else _IMPORT_SECONDS) - self.spent
        return self._seconds - self.spent

    def compile_in_background(self) -> None:
        """Start a process that compiles it, and that may outlive this one; once, and not while another one compiles."""
        if self._started or self._is_kept():
            return
        self._started = True
        # The executable of a frozen program, and of one that embeds Python, is no Python.
        is_python = Path(sys.executable or "").name.startswith("python") and not getattr(sys, "frozen", False)
        if self.folder is None or not is_python:
            return
        with suppress(OSError, subprocess.SubprocessError):
            self.folder.parent.mkdir(parents=True, exist_ok=True)
            with _THREADS, _lock_file(self.folder) as lock:
                fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # an error if somebody has a part of it
                state = os.fstat(lock)
                if state.st_size and time.time() - state.st_mtime < _PAUSE_SECONDS:
                    return
            places = [*(entry for entry in sys.path if isinstance(entry, str)), str(Path(__file__).parents[2])]
            path = json.dumps([str(Path(entry).absolute()) for entry in places])
            _say(f"compiling {self._what} in the background, once on this machine …")
            subprocess.run(
                [sys.executable, "-I", "-S", "-c", _BACKGROUND, path, self._function.__module__, self._name],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
                timeout=60,
            )

    def _made(self) -> Callable[..., Any]:
        folder, obstacle = self.folder, "there is no home directory, or no source of the kernels"
        if folder is not None:
            if self._is_kept():
                self._note_use(folder)
                # Whatever is wrong with files that a crash or another program has damaged: they are made anew.
                with suppress(Exception):
                    return self._by_numba(folder)
            try:
                folder.parent.mkdir(parents=True, exist_ok=True)
                with _locked(folder, f"waiting for another process that compiles {self._what} …"):
                    if self._is_kept():
                        with suppress(Exception):
                            return self._by_numba(folder)
                        shutil.rmtree(folder, ignore_errors=True)
                    folder.mkdir(exist_ok=True)
                    with tempfile.TemporaryFile(dir=folder):
                        pass
                    _say(f"compiling {self._what}, once on this machine …")
                    made = self._by_numba(folder)
                    (folder / self._name).touch()
                    self._remove_former(folder)
                    return made
            except (OSError, RuntimeError) as error:  # Numba says that a folder is not writable by a RuntimeError
                obstacle = f"{quoted(str(folder))}: {error}"
        if "warning" not in _said:
            _said.add("warning")
            warn_caller(
                f"compiled kernels cannot be kept ({abbreviated(obstacle)}); each process compiles them anew "
                "(NUMBA_CACHE_DIR names another folder)",
                NotCachedWarning,
            )
        _say(f"compiling {self._what} …")
        return self._by_numba(None)

    def _by_numba(self, folder: Path | None) -> Callable[..., Any]:
        """The function compiled, or read from a folder; kept there unless it is None."""
        import numba

        register_parts()
        signature = self._signature()
        made = numba.njit(nogil=True, error_model="numpy")(self._function)
        if folder is not None:
            made._cache = _numbas_cache(self._function, folder)
        made.compile(signature)
        made.disable_compile()
        self._entry = next(iter(made.overloads.values())).entry_point
        return made  # type: ignore[no-any-return]

    def _note_use(self, folder: Path) -> None:
        """Let nobody remove the kernel for the next weeks, where it can be written."""
        marker = folder / self._name
        with suppress(OSError):
            if time.time() - marker.stat().st_mtime > _NOTED_SECONDS:
                marker.touch()
                self._remove_former(folder)

    def _remove_former(self, folder: Path) -> None:
        """Remove what was kept of this kernel under other fingerprints, unless it has been used of late.

        A process that begins to read one at this moment finds parts missing, and compiles it.
        """
        with suppress(OSError):
            for former in set(folder.parent.iterdir()) - {folder}:
                marker = former / self._name
                with suppress(OSError):  # of another kernel, not to be written, or compiled or removed by a process
                    if time.time() - marker.stat().st_mtime > _UNUSED_SECONDS:
                        with _lock_file(former) as lock:
                            fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                            marker.unlink()
                            shutil.rmtree(former)
                            former.with_suffix(".lock").unlink()

    def _is_kept(self) -> bool:
        return self.folder is not None and (self.folder / self._name).exists()

    @cached_property
    def folder(self) -> Path | None:
        """Where it is kept; None where it cannot be."""
        parent = cache_folder()
        if parent is None:
            return None
        try:
            return parent / fingerprint(self._function, self._name)
        except OSError:
            return None


def first_rows(
    kernels: Sequence[KeptKernel], run: Callable[[slice], object], count: int, at_once: int = 1, each: float = 0.0
) -> int:
    """Run the first rows as Python, for as long as that is quicker than to wait for the compiled kernels.

    Args:
        kernels: those that the rows need.
        run: works on the rows of a slice, by `KeptKernel.uncompiled`.
        count: how many rows there are.
        at_once: how many are in one slice.
        each: what a row takes at most as Python, where that may be much [s]; the rows that have been run tell more.

    Returns:
        How many rows have been worked on; the others are left to the kernels.
    """
    lacking = [kernel for kernel in kernels if not kernel.in_memory]
    if not lacking or not may_compile():
        return 0
    done, seconds, left = 0, 0.0, count * each
    while True:
        if left + sum(kernel.spent for kernel in lacking) >= _WORTH_COMPILING:
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
            kernel.spent += took / len(lacking)
        done, seconds = part.stop, seconds + took
        left = seconds / done * (count - done)


def warm_up(names: Iterable[str] | None = None) -> tuple[KernelState, ...]:
    """Compile kernels, or read them from the disk, so that no later call has to wait for them.

    Args:
        names: names of kernels, such as "ik kernel, legs"; None for all kernels of the package.

    Returns:
        The state of each kernel. Empty where Numba is not installed, for nothing is compiled then.

    Raises:
        UnknownName: there is no such kernel; the message lists the names.
        BadArgument: `names` is not a sequence of names.

    Examples:
        >>> [state.name for state in nk.warm_up(["ik kernel, heads"])]
        ['ik kernel, heads']
    """
    if names is not None and (isinstance(names, str) or not isinstance(names, Iterable)):
        raise BadArgument(f"names must be names of kernels, got {quoted(names)}")
    if not has_numba():
        return ()
    for module in _HOMES:
        importlib.import_module(module)
    wanted = tuple(KERNELS if names is None else names)
    for name in wanted:
        if not isinstance(name, str) or name not in KERNELS:
            raise UnknownName("kernel", name, tuple(KERNELS))
    return tuple(KERNELS[name].warm_up() for name in wanted)


def compile_kernel(module: str, name: str) -> None:
    """Compile a kernel that a module makes, and keep it; one kernel at a time, and none that waits for that already."""
    importlib.import_module(module)
    kernel, folder = KERNELS[name], KERNELS[name].folder
    if folder is None or not compiles():
        return
    with suppress(BlockingIOError, PermissionError), _lock_file(folder) as lock:
        fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, _WAITS)
        with _lock_file(folder.with_name("background")) as turn:
            fcntl.lockf(turn, fcntl.LOCK_EX)
            kernel.warm_up()


def cache_folder() -> Path | None:
    """Where compiled kernels are kept: below NUMBA_CACHE_DIR if that is set, else in the user's cache directory.

    None where the user has no home.

    Examples:
        >>> folder = nk.cache_folder()
        >>> folder is None or folder.is_absolute()
        True
    """
    named = os.environ.get("NUMBA_CACHE_DIR")
    if named:
        return Path(named) / "nao_kin"
    try:
        if sys.platform == "darwin":
            return Path.home() / "Library" / "Caches" / "nao_kin"
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "nao_kin"
    except RuntimeError:
        return None


@contextmanager
def _lock_file(folder: Path) -> Iterator[int]:
    """The descriptor of the file beside a kernel's folder that is locked while the kernel is compiled.

    The locks are those of POSIX: they end with the process that has them, and a process forked meanwhile has none.
    """
    descriptor = os.open(folder.with_suffix(".lock"), os.O_RDWR | os.O_CREAT, 0o600)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


@contextmanager
def _locked(folder: Path, waiting: str) -> Iterator[None]:
    """Hold the lock of a kernel's folder; say that another process has it, and wait until it lets go or ends."""
    with _lock_file(folder) as lock:
        try:
            fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, _COMPILES)
        except (BlockingIOError, PermissionError):
            _say(waiting)
            fcntl.lockf(lock, fcntl.LOCK_EX, 1, _COMPILES)
        except OSError:
            pass  # a file system without locks: at worst two processes compile the same
        os.pwrite(lock, b"1", 0)  # when this was last tried
        yield


def _numbas_cache(function: Callable[..., Any], folder: Path) -> Any:
    """Numba's cache of a compiled function, in a folder whose name says for which source it is.

    Numba's own choice depends on the bytes and line numbers of a function's file, and on nothing that it calls; and
    it refuses to read where it cannot write.
    """
    from numba.core import caching

    class Locator(caching._CacheLocator):  # type: ignore[misc]
        _py_file = function.__code__.co_filename

        def get_cache_path(self) -> str:
            return str(folder)

        def get_source_stamp(self) -> str:
            return folder.name

        def get_disambiguator(self) -> str:
            return "kernel"

        @classmethod
        def from_function(cls, function: Callable[..., Any], file: str) -> Locator:
            return cls()

    class Implementation(caching.CompileResultCacheImpl):  # type: ignore[misc]
        _locator_classes = (Locator,)

    class Cache(caching.FunctionCache):  # type: ignore[misc]
        _impl_class = Implementation

    return Cache(function)


def _say(message: str) -> None:
    """Say once in a process why it takes a while, where anybody listens."""
    if message not in _said and sys.stderr is not None:
        with suppress(OSError, ValueError):
            print(f"nao_kin: {message}", file=sys.stderr)  # noqa: T201
    _said.add(message)


# --- Functions that run as Python and that compiled code may call, too.

_Function = TypeVar("_Function", bound=Callable[..., Any])
_waiting: list[Callable[..., Any]] = []


def both_ways(function: _Function) -> _Function:
    """The function itself, which compiled code may call too."""
    _waiting.append(function)
    return function


def register_parts() -> None:
    """Tell Numba of the functions marked with `both_ways`; to be called before a kernel is compiled or read."""
    from numba.extending import register_jitable

    while _waiting:
        register_jitable(error_model="numpy", no_cfunc_wrapper=True)(_waiting.pop())
