"""The examples in docstrings run, and print what they say."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import numpy as np
import pytest

import nao_kin as nk

PACKAGE = Path(nk.__file__).parent


def _runs(code: str) -> bool:
    """Return whether the examples run; examples that need a network or a file of the reader are only shown."""
    return any(">>> " in line and "+SKIP" not in line for line in code.splitlines())


MODULES = sorted(
    ".".join(("nao_kin", *path.relative_to(PACKAGE).with_suffix("").parts))
    for path in PACKAGE.rglob("*.py")
    if _runs(path.read_text(encoding="utf-8"))
)


# Pictures, packages and proofs, which take seconds each.
SLOW = ("nao_kin.viewer.viewer", "nao_kin.crosscheck.report", "nao_kin.export.ros2", "nao_kin.export.srdf")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.full if name in SLOW else ()) for name in MODULES]
)
def test_the_examples_of_a_module_print_what_they_say(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if name == "nao_kin.ik.analytic":
        pytest.importorskip("eaik")
    monkeypatch.chdir(tmp_path)  # for examples that write files
    module = importlib.import_module(name)
    with np.printoptions(precision=4, suppress=True):
        result = doctest.testmod(module, extraglobs={"nk": nk, "np": np}, optionflags=doctest.ELLIPSIS)
    assert result.attempted > 0
    assert result.failed == 0
