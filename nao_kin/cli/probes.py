"""Libraries tried in a process of their own, for mixed binary libraries do not raise, they crash."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from functools import partial

from nao_kin._common.ending import before_ending, kill_group, uninterrupted
from nao_kin._extras import with_remedy
from nao_kin._text import abbreviated

_PROBE = """
import nao_kin
nao = nao_kin.load_nao()
print(nao.nv, *nao.position(nao.neutral(), "LArm"))
"""
_NUMBA_PROBE = """
from nao_kin._common.compiler import numba_problem
print(numba_problem())
"""
_PROBE_SECONDS = 120


def model_problem(variables: Mapping[str, str]) -> list[str]:
    """What is wrong where the NAO does not load, if anything."""
    code, out, problem = _probed(_PROBE, variables)
    if code == 0 and out.startswith("25 "):
        return []
    return [
        f"the model could not be tried: {problem}" if code is None else f"the NAO does not load: {with_remedy(problem)}"
    ]


def numba_problem(variables: Mapping[str, str]) -> list[str]:
    """What is wrong where Numba is installed and does not load: it refuses a NumPy newer than itself."""
    code, out, problem = _probed(_NUMBA_PROBE, variables)
    return [found] if (found := out.strip() if code == 0 else f"numba does not load: {problem}") else []


def _probed(program: str, variables: Mapping[str, str]) -> tuple[int | None, str, str]:
    """Exit code and output of a program in a process of its own, and what it ended with; no code where it did not."""
    try:
        with uninterrupted():
            probe = subprocess.Popen(
                [sys.executable, "-c", program],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                env=dict(variables),
                start_new_session=True,
            )
            take_back = before_ending(partial(kill_group, probe.pid))
    except OSError as error:
        return None, "", str(error)
    try:
        with probe:
            try:
                out, errors = probe.communicate(timeout=_PROBE_SECONDS)
            except BaseException:
                probe.kill()
                raise
    except subprocess.TimeoutExpired:
        return None, "", f"it did not load within {_PROBE_SECONDS} s"
    finally:
        take_back()
    lines = errors.strip().splitlines()
    return probe.returncode, out, abbreviated(lines[-1]) if lines else f"the process ended with code {probe.returncode}"
