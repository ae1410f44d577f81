"""Fingerprints of compiled kernels, which change only with the code, the compiler and the processor."""

from __future__ import annotations

import ast
import hashlib
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
# The lines of /proc/cpuinfo that identify the kind of processor.
_PROCESSOR_LINES = ("model name", "flags", "CPU part", "Features")


def fingerprint(function: Callable[..., Any], name: str) -> str:
    """Return sixteen hexadecimal digits that identify a kernel, given by its Python function and its name.

    They depend on Python, Numba, NumPy, the processor, the syntax trees of all modules from which the function takes
    functions and classes, also indirectly, and the constants it uses; not on comments, docstrings, lines and paths.
    """
    modules, constants = _dependencies(function)
    parts = [name, str(sys.implementation.cache_tag), _version("numba"), np.__version__, _processor()]
    parts += [os.environ.get(variable, "") for variable in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")]
    parts += [f"{module}: {_tree(module)}" for module in sorted(modules)]
    parts += sorted(constants)
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


def _dependencies(function: Callable[..., Any]) -> tuple[set[str], set[str]]:
    """Return the modules of a function and of everything it uses from its own package, and the constants it uses."""
    package = function.__module__.partition(".")[0]
    modules: set[str] = set()
    constants: set[str] = set()
    seen: set[int] = set()
    waiting: list[Any] = [function]
    while waiting:
        value = waiting.pop()
        # A function compiled by Numba holds the Python function in an attribute.
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
            modules.update((value.__module__, value.__globals__["__name__"]))  # a factory may set another __module__
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
    """Yield the globals and enclosing variables that a function names in its code or its annotations."""
    names = set(_names(function.__code__))
    for annotation in function.__annotations__.values():
        names.update(re.findall(r"\w+", str(annotation)))
    for name in sorted(names & function.__globals__.keys()):
        yield name, function.__globals__[name]
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        with suppress(ValueError):  # a variable that has no value yet
            yield name, cell.cell_contents


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


@cache
def _tree(module: str) -> str:
    """Return the syntax tree of a module without docstrings."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    for node in ast.walk(tree):
        if isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            del node.body[0]
    return ast.dump(tree)


@cache
def _version(package: str) -> str:
    """Return the version of a package without importing it."""
    import importlib.metadata  # takes a tenth of the time to import this package

    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return ""


@cache
def _processor() -> str:
    """Return the kind of processor. Numba compares it more closely when it reads a kernel; to ask LLVM takes 0.1 s."""
    try:
        first = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").split("\n\n")[0]
    except OSError:
        return f"{platform.machine()} {platform.processor()}"
    return "\n".join(line for line in first.splitlines() if line.startswith(_PROCESSOR_LINES)) or platform.machine()
