"""Functions inside a kernel are compiled as parts of it alone."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest

from nao_kin._kernels.inner_functions import as_parts_of

numba = pytest.importorskip("numba", reason="Numba is not installed")
FLOAT = (numba.float64,)
from numba.extending import register_jitable  # noqa: E402


@register_jitable
def inner(x: float) -> float:
    return x * x


@numba.njit
def called(x: float) -> float:
    return inner(x) + 1.0


@numba.njit
def kernel(x: float) -> float:
    return inner(x) + called(x)


@numba.njit
def own(x: float) -> float:
    return 2.0 * inner(x)


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_functions_inside_serve_functions_compiled_later_and_others_are_compiled_as_usual() -> None:
    from numba.core.codegen import JITCodeLibrary

    made, usual = list[str](), JITCodeLibrary._finalize_specific
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(JITCodeLibrary, "_finalize_specific", lambda one: (made.append(one.name), usual(one)))
        with as_parts_of("kernel"):
            kernel.compile(FLOAT)
            # A program may compile its own functions for C meanwhile, in another thread.
            with ThreadPoolExecutor() as pool:
                callback = pool.submit(numba.cfunc("float64(float64)"), own.py_func).result()
    assert sorted(made) == ["called", "inner", "kernel", "own"]  # that inside of own
    assert callback.ctypes(3.0) == 18.0
    assert (kernel(3.0), called(3.0), own(3.0)) == (19.0, 10.0, 18.0)
    assert own(3) == 18  # a type for which `inner` is compiled anew
