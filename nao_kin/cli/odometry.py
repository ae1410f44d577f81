"""`nao-kin odometry`: the trajectory of a robot's trunk, from a log of its joints."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np

from nao_kin._core import files as atomic
from nao_kin._core.arrays import Floats
from nao_kin._core.text import quoted
from nao_kin.cli.options import OUTPUT, OutputOptions, RobotOptions, argument, command, option
from nao_kin.cli.output import csv_text, degrees_per, print_json_list, print_written, units
from nao_kin.cli.sources import FileOptions, read_columns
from nao_kin.errors import BadArgument, BadInputFile, UnknownName

_ANGLES = ("roll", "pitch", "yaw")
_COLUMNS = ("time", "x", "y", "z", *_ANGLES, "support")


@command(
    "odometry",
    "Example: nao-kin odometry walk.csv; nao-kin odometry log.csv --forces LFsr,RFsr -o path.csv",
    without=("joint",),
)
def odometry(
    *,
    file: str = argument("FILE", "CSV or JSON file of configurations with times, or a motion; - for standard input."),
    sole: list[str] | None = option("NAME", "A sole that may be in place; repeatable. Default: those of the robot."),
    contacts: str | None = option("HEADINGS", "Columns of FILE, with commas: whether each sole touches the floor."),
    forces: str | None = option("HEADINGS", "Columns of FILE, with commas: the force on each sole, or on each sensor."),
    gyro: str | None = option("HEADINGS", "Columns of FILE, with commas: angular velocity about x, y and z [rad/s]."),
    output: str | None = option("FILE", "Write the CSV here.", *OUTPUT),
    given: FileOptions,
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Print the trajectory of the root link: one sole at a time is flat on the floor, and its leg carries the trunk.

    The world has its origin on the floor between the feet in the first row, x ahead and z up. Each row of FILE gives a
    row of CSV: time, position [m], roll, pitch, yaw, and the sole in place.
    """
    written.check({"--output": output}, kind="csv")
    named = (("contacts", contacts), ("forces", forces), ("gyro", gyro))
    headings = {what: [name.strip() for name in text.split(",")] for what, text in named if text is not None}
    if headings and file == "-":
        raise BadArgument(f"--{next(iter(headings))} reads FILE twice; name a file instead of -")
    from nao_kin.rotations import rpy_from_matrix
    from nao_kin.world import odometry as walked

    measured: Any = {what: _measured(file, columns) for what, columns in headings.items()}
    skipped = dict.fromkeys(f"{name}=" for columns in headings.values() for name in columns)
    read = replace(given, columns=[*(given.columns or ()), *skipped]) if skipped else given
    model, q, times, _ = read.configurations(robot, file, limits="ignore")
    if times is None:
        raise BadInputFile(file, "no column of times, which odometry needs")
    path = walked(model, times, q, soles=sole, **measured)
    T = path.T_world_base
    angles = rpy_from_matrix(T[:, :3, :3]) * degrees_per("rad", given.deg)
    numbers = np.column_stack([path.times, T[:, :3, 3], angles]).tolist()
    rows = [[*row, path.soles[k]] for row, k in zip(numbers, path.support.tolist(), strict=True)]
    if output is not None or not written.json:
        names = [f"{name}_deg" if given.deg and name in _ANGLES else name for name in _COLUMNS]
        text = csv_text(names, rows)
        if output is None:
            sys.stdout.write(text)
        else:
            atomic.write_text(output, text)
    if written.json:
        head = {"robot": model.name, "units": units(given.deg)}
        print_json_list(head, "rows", (dict(zip(_COLUMNS, row, strict=True)) for row in rows))
    elif output is not None:
        print_written(output)


def _measured(file: str, columns: list[str]) -> Floats:
    """Return the numbers in columns of a CSV file, shape (n, columns)."""

    def chosen(names: list[str], line: int) -> list[str]:
        for name in columns:
            if name not in names:
                raise UnknownName("column", name, names)
        return columns

    return read_columns(file, f"the column {quoted(columns[0])}", chosen)[1]
