"""Write the page of the documentation from the record."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from tools_table.tools import TOOLS, Tool

_HEAD = """\
# Tools

<!-- Written by scripts/measure_tools.py from docs/tools.json. -->

This page lists the export to use for each tool. Each export was loaded in its tool, for every version of the NAO. The
mass, and the poses of all its links relative to the trunk in random configurations, were compared with this library.
The lines that load the export were run exactly as shown. `python scripts/measure_tools.py` repeats the measurement.
MJCF files are written with the extra `mujoco`: `pip install 'nao-kin[mujoco]'`.

"""

_LEGEND = """
Poses: no entry of a matrix is off by more than this; 10⁻¹⁴ means rounding. Hips and fingers have mimic joints, which
the tool supports in one of these ways:

- *follows*: the tool moves them with their driver;
- *constraint*: the tool's simulation or solver enforces the coupling; if you set joints directly, set both;
- *reports*: the tool reports the coupling, and you apply it;
- *set both*: the tool ignores couplings, and with `--coupling independent` the file has none.

Moves: simulators were run for a moment, solvers were given a target, and the couplings were checked afterwards. A dash
means that the tool has no such function.
"""

_OTHERS = """
## Other tools

These tools are not in the weekly measurement. Each was tried once, with V6.

- **mujoco-warp** 4.0.0 loads the file of `--format mjcf` and, after 50 steps from `StandInit`, agrees with MuJoCo to
  0.0004, in metres and radians; it computes in single precision.
- **Newton** 1.8.0 loads `--format mjcf` (with MuJoCo 3.17) and `--format urdf --inertia physical`, with the right mass.
- **Isaac Lab** was not run. Use `--format urdf --inertia physical`: isaaclab-robot-doctor 0.1.0 finds no error in this
  file, and 18 in the file with the published inertias, because hands and fingers move and have no mass. NVIDIA's
  urdf-usd-converter 0.3.4 converts all meshes to **OpenUSD**.

In a tool that checks self-collision, exclude the pairs that the SRDF or the MJCF file excludes. The collision shapes
contain the meshes, so those of neighbouring links overlap, by up to 6 cm between pelvis and thigh, and simulators push
them apart.
"""

_COUPLINGS = {"held": "follows", "constraint": "constraint", "told": "reports", "free": "set both"}
_EXPONENTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def page(known: Mapping[str, Any]) -> str:
    """Return the text of the page."""
    measured = [(tool, known[tool.key]) for tool in TOOLS if tool.key in known]
    head = ("tool", "export", "poses", "mass", "meshes", "hips", "fingers", "moves")
    rows = [_summary(tool, record["rows"].values()) for tool, record in measured]
    return _HEAD + _table(head, rows) + _LEGEND + "".join(_section(tool, record) for tool, record in measured) + _OTHERS


def _summary(tool: Tool, rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return the row of a tool in the first table: its worst result over all versions."""
    rows = list(rows)
    failed = [row["loads"] for row in rows if row["loads"] != "yes"]
    if failed or not rows:
        return [tool.name, f"`{_options(tool)}`", *failed[:1], *["–"] * (6 - bool(failed))]
    return [
        tool.name,
        f"`{_options(tool)}`",
        _power(max(row["fk_error"] for row in rows)),
        _all_or_none(["–" if row["mass"] is None else "right" if _right_mass(row) else "wrong" for row in rows]),
        _all_or_none(["–" if row["meshes"] is None else "yes" if row["meshes"] else "none" for row in rows]),
        _all_or_none([_COUPLINGS[row["hips"]] for row in rows]),
        _all_or_none([_COUPLINGS[row["fingers"]] for row in rows]),
        _all_or_none([_dash(row["simulates"]) for row in rows]),
    ]


def _section(tool: Tool, record: Mapping[str, Any]) -> str:
    head = ("NAO", "frames", "poses", "mass [kg]", "meshes", "hips", "fingers", "moves")
    rows = [_line(version, row) for version, row in record["rows"].items()]
    ran = "" if record["snippet"] == "yes" else f"\nThese lines fail: {record['snippet']}\n"
    said = f"\n{tool.remarks}\n" if tool.remarks else ""
    return (
        f"\n## {tool.name}\n\n`{tool.package}` {record['version']}\n\n"
        f"```{{code-block}} sh\n{tool.command}\n```\n\n"
        f"```{{code-block}} python\n{tool.snippet}```\n{ran}{said}\n{_table(head, rows)}"
    )


def _line(version: str, row: Mapping[str, Any]) -> list[str]:
    name = version.upper()
    if row["loads"] != "yes":
        return [name, row["loads"], *["–"] * 6]
    mass = "–" if row["mass"] is None else f"{row['mass']:.4f}"
    if not _right_mass(row):
        mass += f", not {row['expected_mass']:.4f}"
    couplings = [_COUPLINGS[row["hips"]], _COUPLINGS[row["fingers"]]]
    frames, poses = str(row["frames"]), _power(row["fk_error"])
    return [name, frames, poses, mass, _dash(row["meshes"]), *couplings, _dash(row["simulates"])]


def _right_mass(row: Mapping[str, Any]) -> bool:
    return row["mass"] is None or abs(row["mass"] - row["expected_mass"]) <= 2e-6


def _options(tool: Tool) -> str:
    return " ".join(word for word in tool.command.split()[3:])


def _power(error: float) -> str:
    return "10" + str(round(float(f"{error:e}".split("e")[1]))).translate(_EXPONENTS)


def _dash(value: object) -> str:
    return "–" if value is None else str(value)


def _all_or_none(words: list[str]) -> str:
    """Return the word that holds for all versions, or all words if the versions differ."""
    return ", ".join(dict.fromkeys(words))


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    head = list(head)
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |\n" for line in lines)
