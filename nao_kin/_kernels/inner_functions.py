"""Compile the functions inside a kernel as parts of it alone, in less than half of the time.

Numba optimises the code of each function, which contains that of all functions that it calls, and makes machine code of
it. In a kernel only the outermost function is called from Python: its code is optimised as a whole, and the machine
code of the others is never used.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

# Numba's wrapper that is called from Python begins so.
_CALLABLE = "_ZN7cpython"


@contextmanager
def as_parts_of(kernel: str) -> Iterator[None]:
    """Leave out what is compiled twice for the functions that this thread compiles, but not for the kernel of a name.

    Functions that can be called from Python, other threads, and versions of Numba with other methods are compiled as
    usual. Functions that are compiled later may call those inside.
    """
    from numba.core.codegen import JITCodeLibrary
    from numba.core.cpu import CPUContext

    owner, usual = threading.get_ident(), dict[tuple[type, str], Callable[..., Any]]()

    def finalize(library: Any) -> None:
        library._finalize_dynamic_globals()
        library._verify_declare_only_symbols()
        library._finalized = True

    def replace(what: type, name: str, library: int, instead: Callable[..., Any]) -> None:
        """Replace a method, one of whose arguments is the library of a function."""
        method = usual[what, name] = getattr(what, name)

        def replaced(*args: Any) -> Any:
            code = args[library]
            inner = threading.get_ident() == owner and code.name != kernel
            inner = inner and not any(function.name.startswith(_CALLABLE) for function in code._final_module.functions)
            return (instead if inner else method)(*args)

        setattr(what, name, replaced)

    try:
        with suppress(AttributeError):
            replace(JITCodeLibrary, "_optimize_final_module", 0, lambda library: None)
            replace(JITCodeLibrary, "_finalize_final_module", 0, finalize)
            # Numba wants a built-in function, another one for each; this one takes no arguments.
            replace(CPUContext, "get_executable", 1, lambda *args: [].clear)
        yield
    finally:
        for (what, name), method in usual.items():
            setattr(what, name, method)
