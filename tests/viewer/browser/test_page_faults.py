"""The faults that are planted in the page's modules."""

from __future__ import annotations

import importlib
import subprocess
from pathlib import Path

import pytest

WEB = Path(__file__).resolve().parents[3] / "web"


def node() -> str:
    """The Node that Playwright brings with it."""
    driver = pytest.importorskip("playwright._impl._driver", reason="playwright is not installed")
    return str(driver.compute_driver_executable()[0])


def packages() -> Path:
    """The packages of `npm ci`, of which esbuild makes JavaScript of the page's TypeScript."""
    found = WEB / "node_modules"
    if not found.is_dir():
        pytest.skip("npm ci was not run in web/")
    return found


@pytest.mark.full
def test_a_fault_planted_in_the_page_is_no_mistake_in_its_grammar(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).resolve().parents[3] / "scripts")
    mutate = importlib.import_module("mutate")
    faults = [fault for fault in mutate.read_faults() if fault.path.endswith(".ts")]
    assert faults
    for number, fault in enumerate(faults):
        (tmp_path / f"{number}.ts").write_text(mutate.planted(fault), encoding="utf-8")
    command = [node(), str(packages() / "esbuild" / "bin" / "esbuild"), f"--outdir={tmp_path / 'out'}"]
    done = subprocess.run([*command, *map(str, tmp_path.glob("*.ts"))], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
