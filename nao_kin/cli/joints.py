"""`nao-kin joints`: the joints and their limits."""

from __future__ import annotations

import math

import typer

from nao_kin.cli.options import Deg, Json, Robot, Urdf, Version, load
from nao_kin.cli.output import print_json, print_table


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("joints", epilog="Example: nao-kin joints --deg")(joints)


def joints(
    version: Version = "v6", urdf: Urdf = None, robot: Robot = None, deg: Deg = False, json: Json = False
) -> None:
    """The joints in the order of q: limits, speed, torque, and the joints that follow each."""
    model = load(version, urdf, robot)
    rows = []
    for index, name in enumerate(model.joint_names):
        unit = model.joint_units[index]
        scale = math.degrees(1.0) if deg and unit == "rad" else 1.0
        rows.append(
            {
                "index": index,
                "joint": name,
                "lower": _finite(model.lower[index] * scale),
                "upper": _finite(model.upper[index] * scale),
                "unit": "deg" if scale != 1.0 else unit,
                "velocity": _finite(model.velocity_limits[index] * scale),
                "effort": _finite(model.effort_limits[index]),
                "followed_by": [follower for follower, tie in model.mimics.items() if tie.joint == name],
            }
        )
    if json:
        print_json({"robot": model.name, "joints": rows})
        return
    columns = ("index", "joint", "lower", "upper", "unit", "velocity", "effort", "followed_by")
    table = [[_text(row[column]) for column in columns] for row in rows]
    numbers = ("index", "lower", "upper", "velocity", "effort")
    print_table([column.replace("_", " ") for column in columns], table, numbers=numbers)


def _finite(value: float) -> float | None:
    """JSON has no infinity: a joint without a limit has none."""
    return float(value) if math.isfinite(value) else None


def _text(value: object) -> str:
    if isinstance(value, list):
        shown = ", ".join(value[:2])
        return shown if len(value) <= 2 else f"{shown} and {len(value) - 2} more"
    if value is None:
        return "–"
    return f"{value:.4f}" if isinstance(value, float) else str(value)
