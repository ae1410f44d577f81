"""The parameters as Markdown tables, written when the documentation is built."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from nao_kin.robot.nao import SOURCES, parameters, tables

_TABLES = {
    "Offsets [mm]": parameters.OFFSETS,
    "Joints": tables.JOINTS,
    "Limits": parameters.LIMITS,
    "Speed and torque [rad/s, N m]": parameters.ACTUATORS,
    "Coupled limits [°]": tables.COUPLED_LIMITS,
    "Inertia [kg, m, kg m²]": parameters.INERTIALS,
    "Frames [m, rad]": parameters.FRAMES,
    "Cameras [°]": parameters.CAMERA_ROWS,
    "Resolutions [pixel]": tables.RESOLUTIONS,
    "Fingers [m, rad]": tables.FINGERS,
    "Placeholder of links without a mass of their own [kg, m, kg m²]": (parameters.PLACEHOLDER,),
    "Collision shapes [m]": tables.NAOQI_SHAPES,
    "Outlines of the soles [m]": tables.SOLE_OUTLINES,
    "Meshes": parameters.VISUALS,
    "Postures, in Body order [rad; 0 to 1 for hands]": tables.POSTURES,
}


def write_tables(path: Path) -> None:
    """Write all tables, and the sources behind their codes."""
    parts = [f"## {title}\n\n{_table(rows)}" for title, rows in _TABLES.items()]
    sources = "\n".join(f"| {code} | {text} |" for code, text in SOURCES.items())
    parts.append(f"## Sources\n\n| code | source |\n|---|---|\n{sources}")
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _table(rows: Iterable[Any]) -> str:
    rows = list(rows)
    fields = [field.name for field in dataclasses.fields(rows[0])]
    last = [name for name in ("versions", "source") if name in fields]
    names = [name for name in fields if name not in last] + last
    lines = ["| " + " | ".join(name.replace("_", " ") for name in names) + " |", "|" + "---|" * len(names)]
    lines += ["| " + " | ".join(_text(getattr(row, name)) for name in names) + " |" for row in rows]
    return "\n".join(lines)


def _text(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, tuple):
        return (
            ", ".join(map(_text, value))
            if not (value and isinstance(value[0], tuple))
            else " · ".join(map(_text, value))
        )
    return f"{value:.9g}" if isinstance(value, float) else str(value)
