"""The page of the documentation, from the record."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from tools_table.tools import TOOLS, Tool

_HEAD = """\
# Tools

<!-- Written by scripts/measure_tools.py from docs/tools.json. -->

Which export for which tool. Each export was loaded in its tool, for every version of the NAO, and what the tool makes
of it was compared with this library: poses of all links that it knows in random configurations, all seen from the
trunk, and the mass. The lines that load it were run as they stand. `make tools-table` does it again.

"""

_LEGEND = """
Poses: no entry of a matrix is off by more than this; 10⁻¹⁴ stands for rounding. Hips and fingers are joints that follow
others, and the tool

- *follows*: moves them by itself;
- *constraint*: holds them in simulation, or in its solver; where joints are set by hand, set both;
- *says*: tells what follows what, and leaves it to the caller;
- *set both*: knows of nothing; where the export is `--coupling independent`, the file claims nothing else.

What moves: simulators were run for a moment, solvers were given a target, and the couplings that they hold were looked
at afterwards. A dash: the tool has no such thing.
"""

_COUPLINGS = {"held": "follows", "constraint": "constraint", "told": "says", "free": "set both"}
_EXPONENTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def page(known: Mapping[str, Any]) -> str:
    """The text of the page."""
    measured = [(tool, known[tool.package]) for tool in TOOLS if tool.package in known]
    head = ("tool", "export", "poses", "mass", "meshes", "hips", "fingers", "moves")
    rows = [_summary(tool, record["rows"].values()) for tool, record in measured]
    return _HEAD + _table(head, rows) + _LEGEND + "".join(_section(tool, record) for tool, record in measured)


def _summary(tool: Tool, rows: Iterable[Mapping[str, Any]]) -> list[str]:
    """The worst of the versions."""
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
    """The one word of all versions; several where they differ."""
    return ", ".join(dict.fromkeys(words))


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    head = list(head)
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |\n" for line in lines)
