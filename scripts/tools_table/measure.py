"""Measure the rows of the table: each tool with each version, in a process of its own, so that a crash is a row too."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import nao_kin as nk
from tools_table.environments import environment, installed_version, python_of
from tools_table.probes.loaded import SAME_POSE
from tools_table.reference import write_export
from tools_table.tools import Tool

_SECONDS = 300.0


def measure(tool: Tool, cache: Path, versions: Iterable[str] = nk.parameters.VERSIONS) -> dict[str, Any]:
    """Measure a tool with the given versions; if it cannot be installed, return only pip's message."""
    try:
        python = python_of(tool, cache)
    except RuntimeError as error:
        return {"version": None, "rows": {}, "snippet": f"not installed: {error}"}
    rows, snippet = dict[str, Any](), ""
    for version in versions:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            reference = write_export(tool, version, folder)
            rows[version] = _row(tool, python, folder) | {"expected_mass": reference["mass"]}
            snippet = snippet or _said([python, "-c", tool.snippet], folder)[0]
    return {"version": installed_version(tool, python), "snippet": snippet or "yes", "rows": rows}


def faults(tool: Tool, measured: dict[str, Any]) -> list[str]:
    """Return the faults in the rows of a tool, one line each."""
    found = [] if measured["snippet"] == "yes" else [f"{tool.name}: the lines that load it: {measured['snippet']}"]
    for version, row in measured["rows"].items():
        wrong = []
        if row["loads"] != "yes":
            found.append(f"{tool.name}, {version}: {row['loads']}")
            continue
        if not row["fk_error"] <= SAME_POSE:
            wrong.append(f"poses are off by {row['fk_error']:.2g}")
        if row["mass"] is not None and abs(row["mass"] - row["expected_mass"]) > 1e-6:
            wrong.append(f"weighs {row['mass']:.6g} kg instead of {row['expected_mass']:.6g} kg")
        if tool.options.get("meshes") != "none" and row["meshes"] == 0:
            wrong.append("shows no mesh")
        if tool.options.get("coupling", "mimic") == "mimic":
            wrong += [f"{group} are uncoupled" for group in ("hips", "fingers") if row[group] == "free"]
        if row["simulates"] not in (None, "yes"):
            wrong.append(f"simulated, {row['simulates']}")
        found += [f"{tool.name}, {version}: {what}" for what in wrong]
    return found


def _row(tool: Tool, python: Path, folder: Path) -> dict[str, Any]:
    failed, output = _said([python, "-m", "tools_table.probes", tool.probe, str(folder)], folder)
    lines = [line for line in output.splitlines() if line.startswith("{")]
    if failed or not lines:
        return {"loads": failed or "says nothing"}
    row: dict[str, Any] = json.loads(lines[-1])
    return row


def _said(command: list[str | Path], folder: Path) -> tuple[str, str]:
    """Return the error of a process, "" for none, and its output."""
    try:
        done = subprocess.run(
            command, cwd=folder, env=environment(), capture_output=True, text=True, errors="replace", timeout=_SECONDS
        )
    except subprocess.TimeoutExpired:
        return f"no answer in {_SECONDS:.0f} s", ""
    if done.returncode < 0:
        return f"crashes, signal {-done.returncode}", done.stdout
    if done.returncode:
        return (done.stderr.strip().splitlines() or [f"ends with {done.returncode}"])[-1], done.stdout
    return "", done.stdout
