"""`nao-kin odometry`: the trajectory of a robot's trunk, from a log of its joints."""

from __future__ import annotations

import sys

import numpy as np

from nao_kin._core import files as atomic
from nao_kin.cli.options import OUTPUT, OutputOptions, RobotOptions, argument, command, option
from nao_kin.cli.output import csv_text, degrees_per, print_json_list, print_written, units
from nao_kin.cli.shared import CONTACTS, FORCES
from nao_kin.cli.sources import FileOptions
from nao_kin.errors import BadInputFile

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
    contacts: str | None = CONTACTS,
    forces: str | None = FORCES,
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
    from nao_kin.rotations import rpy_from_matrix
    from nao_kin.world import odometry as walked

    read, measured = given.measured(file, contacts=contacts, forces=forces, gyro=gyro)
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
