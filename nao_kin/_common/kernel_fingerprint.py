"""Fingerprints of compiled kernels, which change with the code, the compiler and the processor, and nothing else."""

from __future__ import annotations

import ast
import hashlib
import importlib.metadata
import inspect
import os
import platform
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import numpy as np

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
            modules.add(value.__module__)
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
