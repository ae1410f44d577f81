"""The part of a measurement that is the same on every machine."""

from __future__ import annotations

import math
from typing import Any

from tools_table.tools import Tool

_FACTS = ("loads", "frames", "meshes", "hips", "fingers", "simulates")


def recorded(measured: dict[str, Any]) -> dict[str, Any]:
    """Return the measurement with masses in milligrams and errors in powers of ten."""
    rows = dict[str, Any]()
    for version, row in measured["rows"].items():
        kept = {name: row[name] for name in _FACTS if name in row}
        if row["loads"] == "yes":
            kept["mass"] = None if row["mass"] is None else round(row["mass"], 6)
            kept["fk_error"] = power_of_ten(row["fk_error"])
        kept["expected_mass"] = round(row["expected_mass"], 6)
        rows[version] = kept
    return measured | {"rows": rows}


def power_of_ten(error: float) -> float:
    """Return the smallest power of ten that is not below an error; 10⁻¹⁴ for rounding errors."""
    return float(f"1e{math.ceil(math.log10(max(error, 1e-14)) - 1e-9)}")


def differences(tool: Tool, before: dict[str, Any] | None, now: dict[str, Any]) -> list[str]:
    """Return the changed facts, one line each; errors below the bound and versions of the tool may change."""
    if before is None:
        return [f"{tool.name}: not in the table"]
    found = []
    for version, row in now["rows"].items():
        old = before["rows"].get(version, {})
        for name in (*_FACTS, "mass", "expected_mass"):
            if row.get(name) != old.get(name):
                found.append(f"{tool.name}, {version}: {name} was {old.get(name)}, is {row.get(name)}")
    return found
