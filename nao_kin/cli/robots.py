"""`nao-kin info`, `joints` and `check`: a robot, its joints, and how it compares with other implementations."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import typer

from nao_kin._core.arrays import finite_or_none
from nao_kin.cli import options as shared
from nao_kin.cli.options import RobotOptions, command, flag, option
from nao_kin.cli.output import csv_text, degrees_per, print_json, print_note, print_table, progress, units

if TYPE_CHECKING:
    from nao_kin.crosscheck import Report
    from nao_kin.joints import DHTable, JointTable, JointTableRow
    from nao_kin.robot import RobotModel


@command("info", "Example: nao-kin info --nao v6 --compare v5", needs={"deg": "compare"})
def info(
    *,
    compare: str | None = option("V", "Print the lengths, limits and masses that differ in this version of the NAO."),
    deg: bool = shared.DEG,
    json: bool = shared.JSON,
    robot: RobotOptions,
) -> None:
    """Print a robot's name, degrees of freedom, mass, chains, postures and file."""
    model = robot.load()
    if compare is not None:
        from nao_kin.robot import load_nao

        other = load_nao(compare)
        rows = list(_differences(model, other, deg))
        if json:
            print_json({"robots": [model.name, other.name], "differences": {what: pair for what, *pair in rows}})
        else:
            cells = ((what, *(" ".join(f"{x + 0.0:.6g}" for x in values) for values in pair)) for what, *pair in rows)
            print_table(("", model.name, other.name), cells)
        return
    facts: dict[str, object] = {
        "name": model.name,
        "degrees_of_freedom": model.nv,
        "joints": len(model.joint_names),
        "following_joints": len(model.mimics),
        "links": len(model.link_names),
        "frames": len(model.frame_names),
        "mass_kg": round(model.mass, 9),
        "urdf": str(model.urdf_path),
        "load_notes": list(model.load_notes),
    }
    if model.semantics.version:
        facts["version"] = model.semantics.version
    if model.chains:
        facts["chains"] = {chain: list(names) for chain, names in model.chains.items()}
    if model.posture_names:
        facts["postures"] = list(model.posture_names)
    if json:
        print_json(facts)
        return
    print_table(
        ("fact", "value"), [(key.replace("_", " "), _text(value)) for key, value in facts.items() if value != []]
    )


def _text(value: object) -> str:
    if isinstance(value, dict):
        return "\n".join(f"{key}: {', '.join(names)}" for key, names in value.items())
    if isinstance(value, list):
        return "\n".join(value) if any(" " in str(item) for item in value) else ", ".join(value)
    return f"{value:.5f}" if isinstance(value, float) else str(value)


def _differences(one: RobotModel, other: RobotModel, deg: bool) -> Iterator[tuple[str, list[float], list[float]]]:
    """Yield what differs between two robots: a name with the unit, and the numbers of both."""
    first, second = _facts(one, deg), _facts(other, deg)
    for what, values in first.items():
        others = second.get(what, values)
        if not np.allclose(values, others, rtol=1e-9, atol=1e-9):
            yield what, list(values), list(others)


def _facts(robot: RobotModel, deg: bool) -> dict[str, tuple[float, ...]]:
    """Return the masses, and places, ranges, speeds and efforts of joints and frames, by a name with the unit."""
    found: dict[str, tuple[float, ...]] = {"mass [kg]": (robot.mass,)}
    found |= {f"mass of {link} [kg]": (body.mass,) for link, body in robot.tree.inertials.items()}
    angle, turned = ("°", math.degrees(1.0)) if deg else ("rad", 1.0)
    for joint in robot.tree.joints:
        name = joint.child if joint.kind == "fixed" else joint.name
        found[f"place of {name} [mm]"] = tuple(1000.0 * x for x in joint.origin.xyz)
        found[f"roll, pitch, yaw of {name} [{angle}]"] = tuple(turned * x for x in joint.origin.rpy)
        if joint.kind != "fixed":
            scale = degrees_per(robot.unit(name), deg)
            unit = {"1": "", "rad": angle}.get(robot.unit(name), robot.unit(name))
            found[f"range of {name}{unit and f' [{unit}]'}"] = joint.lower * scale, joint.upper * scale
            found[f"speed of {name}{unit and f' [{unit}/s]'}"] = (joint.velocity * scale,)
            found[f"effort of {name}"] = (joint.effort,)
    return found


# --- `nao-kin joints`.


@command(
    "joints",
    "Example: nao-kin joints --typed --deg; nao-kin joints --dh LArm --modified --latex",
    needs=dict.fromkeys(("modified", "symbolic", "csv", "latex"), "dh"),
)
def joints(
    *,
    dh: str | None = option("FRAME", "Print the Denavit–Hartenberg parameters of the chain from the root to FRAME."),
    modified: bool = flag("Craig's convention: a and α come before the joint."),
    symbolic: bool = flag("Also print the pose of FRAME as a formula of the joints' values; needs sympy."),
    csv: bool = shared.CSV,
    latex: bool = flag("Print a table of LaTeX."),
    typed: bool = flag("Merge revolute joints that share a centre into one joint."),
    rule: str | None = option("RULE", "Merge by coincident joint centres (default) or concurrent axes."),
    tolerance: float | None = option("M", "Largest distance of merged axes from their common point [m]."),
    deg: bool = shared.DEG,
    json: bool = shared.JSON,
    robot: RobotOptions,
) -> None:
    """Print each joint's axis, centre, limits, lower pair and anatomical name, and its axis as Plücker coordinates.

    The Plücker coordinates are the direction and the moment of the axis, in the root frame with all joints at zero.
    --json adds the largest speed and torque, and the mimic joints of each joint.

    --dh prints the table of a chain: with the joints' values s, the pose of its end is B A1(s1) … An(sn) E. The
    constant B and E are printed below the table.
    """
    from nao_kin.joints import dh_table, joint_table

    model = robot.load()
    if dh is not None:
        table_of_dh = dh_table(model, dh, "modified" if modified else "classic")
        print_note(*table_of_dh.notes)
        if latex:
            print(table_of_dh.as_latex())
        else:
            _print_dh(table_of_dh, deg, symbolic, "json" if json else "csv" if csv else "")
        return
    chosen = {name: value for name, value in (("rule", rule), ("tolerance", tolerance)) if value is not None}
    table = joint_table(model, typed=typed or bool(chosen), **chosen)  # type: ignore[arg-type]
    if json:
        print_json(_document(model, table, deg))
        return
    for chain in dict.fromkeys(row.chain for row in table.rows):
        rows = [_cells(model, row, deg) for row in table.rows if row.chain == chain]
        print(f"\n{chain or table.robot}")
        print_table(("joint", "lower pair", "body", "like a", "axis", "centre [m]", "range", "moment [m]"), rows)
    print(table.summary)


def _document(model: RobotModel, table: JointTable, deg: bool) -> dict[str, Any]:
    document = table.as_dict()
    for row in document["rows"]:
        scales = [degrees_per(unit, deg) for unit in row["units"]]
        for bound in ("lower", "upper"):
            row[bound] = [None if v is None else v * s for v, s in zip(row[bound], scales, strict=True)]
        # A mimic joint has the motor of the joint that it follows.
        drivers = [model.mimics[part].joint if part in model.mimics else part for part in row["parts"]]
        columns = [model.joint_names.index(name) for name in drivers]
        row["velocity"] = [
            finite_or_none(float(model.velocity_limits[i]) * s) for i, s in zip(columns, scales, strict=True)
        ]
        row["effort"] = [finite_or_none(float(model.effort_limits[i])) for i in columns]
        row["followed_by"] = [name for name, mimic in model.mimics.items() if mimic.joint in row["parts"]]
        row["units"] = ["deg" if scale != 1.0 else unit for unit, scale in zip(row["units"], scales, strict=True)]
    return document


def _cells(model: RobotModel, row: JointTableRow, deg: bool) -> list[str]:
    names = [f"{part} (with {model.mimics[part].joint})" if part in model.mimics else part for part in row.parts]
    ranges = []
    for lower, upper, unit in zip(row.lower, row.upper, row.units, strict=True):
        scale = degrees_per(unit, deg)
        symbol = "°" if scale != 1.0 else "" if unit == "1" else f" {unit}"
        ranges.append(f"{_number(lower * scale)} … {_number(upper * scale)}{symbol}")
    return [
        "\n".join(names),
        row.pair,
        row.body,
        row.anatomical,
        "\n".join(_vector(axis) for axis in row.axes),
        _vector(row.centre),
        "\n".join(ranges),
        "\n".join(_vector(screw[3:]) for screw in row.screws),
    ]


def _number(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else "–"


def _vector(values: tuple[float, ...]) -> str:
    return " ".join(f"{round(value, 4) + 0.0:.4g}" for value in values)  # adding zero turns −0 into 0


def _print_dh(table: DHTable, deg: bool, symbolic: bool, form: str) -> None:
    """Print Denavit–Hartenberg parameters as JSON, as CSV, or for people."""
    scale = degrees_per("rad", deg)
    if form == "json":
        document = table.as_dict() | {"units": units(deg)}
        for row in document["rows"]:
            row |= {"alpha": row["alpha"] * scale, "theta": row["theta"] * scale}
        document["residual"]["rotation"] *= scale
        print_json(document | ({"symbolic": [str(entry) for entry in table.symbolic()]} if symbolic else {}))
        return
    columns = zip(table.joints, table.a, table.alpha * scale, table.d, table.theta * scale, strict=True)
    if form == "csv":
        turned = "deg" if deg else "rad"
        names = ("joint", "a [m]", f"alpha [{turned}]", "d [m]", f"theta [{turned}]")
        sys.stdout.write(csv_text(names, ((joint, *map(float, values)) for joint, *values in columns)))
        return
    angle = "°" if deg else "rad"
    rows = [[joint, *(_rounded(value) for value in values)] for joint, *values in columns]
    print_table(("joint", "a [m]", f"α [{angle}]", "d [m]", f"θ [{angle}]"), rows, numbers=("a [m]", "d [m]"))
    for name, T in (("B", table.base), ("E", table.tool)):
        lines = ["  ".join(f"{_rounded(value):>8}" for value in line) for line in T]
        print("\n".join(f"{name if i == 0 else '':>2}  {line}" for i, line in enumerate(lines)))
    if symbolic:
        T = table.symbolic()
        for i in range(3):
            print("\n".join(f"T[{i}, {k}] = {T[i, k]}" for k in range(4)))


def _rounded(value: float) -> str:
    return f"{round(float(value), 6) + 0.0:g}"  # adding zero turns −0 into 0


# --- `nao-kin check`.


@command("check", "Example: nao-kin check --nao v5 --samples 100 --json")
def check(
    *,
    robot: RobotOptions,
    samples: int = option("N", "Number of configurations, at least 1.", default=500),
    seed: int = shared.SEED,
    json: bool = shared.JSON,
) -> None:
    """Compare poses, rotations, Jacobians and limits with Pinocchio, eigenpy, yourdfpy; exit code 1 if they differ."""
    from nao_kin import crosscheck

    model = robot.load()
    with progress("cross-check") as say:
        report = crosscheck.run(model, samples, seed, progress=say)
    if json:
        print_json(report.as_dict())
    else:
        _print(report)
    if not report.ok:
        raise typer.Exit(1)


def _print(report: Report) -> None:
    print_table(report.columns, [row.cells for row in report.rows], numbers=("pairs", "worst", "tolerance"))
    for row in report.rows:
        if row.note:
            print(f"{row.convention} against {row.against}: {row.note}")
    for row in report.failures:
        where = ", ".join(row.failing[:8]) + (f" and {len(row.failing) - 8} more" if len(row.failing) > 8 else "")
        print(f"FAILS: {row.convention} against {row.against}: {where or 'nothing to compare'}")
    counts = ", ".join(f"{count} {kind}" for kind, count in report.strata.items())
    print(f"{report.robot}, seed {report.seed}, configurations: {counts}")
    print("All conventions agree." if report.ok else f"{len(report.failures)} of {len(report.rows)} rows disagree.")
