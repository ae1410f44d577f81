"""`nao-kin check`: do independent implementations agree."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from nao_kin.cli.options import (
    JsonOption,
    OffsetsOption,
    PackageDirOption,
    RobotOption,
    UrdfOption,
    VersionOption,
    XacroOption,
    command,
    load,
)
from nao_kin.cli.output import print_json, print_table

if TYPE_CHECKING:
    from nao_kin.crosscheck import Report
    from nao_kin.robot import RobotModel


@command("check", "Example: nao-kin check --version v5 --samples 100 --json")
def check(
    version: VersionOption = "v6",
    urdf: UrdfOption = None,
    robot: RobotOption = None,
    package_dir: PackageDirOption = None,
    xacro: XacroOption = False,
    offsets: OffsetsOption = None,
    samples: Annotated[
        int, typer.Option("--samples", metavar="N", help="Number of configurations, 1 to 100000.")
    ] = 500,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Seed of the random ones.")] = 0,
    json: JsonOption = False,
) -> None:
    """Poses, rotations, Jacobians, limits against Pinocchio, eigenpy, yourdfpy; exit 1 when a convention disagrees."""
    report = _run(load(version, urdf, robot, package_dir, xacro, offsets), samples, seed)
    if json:
        print_json(report.as_dict())
    else:
        _print(report)
    if not report.ok:
        raise typer.Exit(1)


def _run(model: RobotModel, samples: int, seed: int) -> Report:
    from rich.console import Console
    from rich.progress import Progress

    from nao_kin import crosscheck

    errors = Console(file=sys.stderr)
    with Progress(console=errors, disable=not errors.is_terminal, transient=True) as bar:
        task = bar.add_task("cross-check", total=None)
        return crosscheck.run(
            model, samples, seed, progress=lambda done, total: bar.update(task, completed=done, total=total)
        )


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
