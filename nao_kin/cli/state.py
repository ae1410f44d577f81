"""`nao-kin state`: where a robot has walked, and what it has been doing, from a log."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nao_kin._core import files as atomic
from nao_kin._core.arrays import LimitPolicy
from nao_kin.cli import options as shared
from nao_kin.cli.options import OutputOptions, RobotOptions, argument, command, option
from nao_kin.cli.output import column_writer, degrees_per, print_json, print_note, print_table, print_written, units
from nao_kin.cli.sources import FileOptions
from nao_kin.errors import BadInputFile

if TYPE_CHECKING:
    from nao_kin.world import State


@command(
    "state",
    "Example: nao-kin state walk.csv -o -; nao-kin state log.csv --columns AngleX= --json",
    without=("joint",),
)
def state(
    *,
    file: str = argument("FILE", "CSV or JSON file of configurations with times, or a motion; - for standard input."),
    sole: list[str] | None = option("NAME", "A sole that may be in place; repeatable. Default: those of the robot."),
    limits: LimitPolicy = option(None, shared.OUTSIDE, default="ignore"),
    longest_gap: float = option("S", "Largest time between two rows of a segment [s].", default=0.5),
    output: str | None = option("FILE", "Write the rows: .csv, .npz, .parquet, .arrow or .feather; - prints CSV."),
    given: FileOptions,
    written: OutputOptions,
    robot: RobotOptions,
) -> None:
    """Print how long a robot stood, walked, sat, lay, fell and was carried, and how far; write its trajectory.

    The world has its origin on the floor between the feet in the first row, x ahead and z up. A row has what the robot
    does, support and segment, the pose of the root link with standard deviations, if the robot stands or walks, its
    velocity (ahead, to the left, of the heading), the centre of pressure in the world, and the force and the centre of
    pressure of each sole. What is not known is empty or NaN. Sensors of the feet and of the inertial unit are found by
    the names of their columns, in ALMemory, LoLA and ROS; a note says which are used.
    """
    output = "/dev/stdout" if output == "-" else output
    written.check({"--output": output})
    write = None if output is None else column_writer(output)
    from nao_kin.world import state as found_in

    model = robot.load()
    log = given.recording(model, file, sole, limits=limits)
    if log.times is None:
        raise BadInputFile(file, "no column of times, which odometry needs")
    found = found_in(model, log.q, log.times, soles=sole, longest_gap=longest_gap, **log.measured(model, sole))
    print_note(*found.notes)
    if write is not None:
        write(_columns(found, given.deg))
    path = found.odometry
    summary = {"steps": int(path.steps.sum()), "distance": path.distance, "segments": path.segments}
    if written.json:
        head = {"robot": model.name, "units": units(given.deg), "rows": len(found.times)}
        print_json(head | {"valid_rows": int(found.valid.sum()), "seconds": found.seconds, **summary})
        return
    if output is not None:
        print_written(output)
    if output is None or not atomic.leads_to_standard_output(output):
        lines = {name: f"{seconds:.2f} s" for name, seconds in found.seconds.items()}
        lines |= {"steps": str(summary["steps"]), "distance": f"{path.distance:.3f} m"}
        print_table(["", model.name], (lines | {"segments": str(path.segments)}).items())


def _columns(found: State, deg: bool) -> dict[str, Any]:
    """Return the columns of the rows of a state."""
    path, unit = found.odometry, degrees_per("rad", deg)
    end = "_deg" if deg else ""
    roll_pitch, pose, deviations = found.roll_pitch * unit, path.pose, np.sqrt(np.diagonal(path.covariance, 0, 1, 2))
    tilt = np.sqrt(np.diagonal(found.covariance, 0, 1, 2))
    columns: dict[str, Any] = {
        "time": found.times,
        "doing": found.doing,
        "support": found.support,
        "segment": path.segment,
        **dict(zip("xyz", found.T_world_base[:, :3, 3].T, strict=True)),
        f"roll{end}": roll_pitch[:, 0],
        f"pitch{end}": roll_pitch[:, 1],
        f"yaw{end}": pose[:, 2] * unit,
        "vx": path.velocity[:, 0],
        "vy": path.velocity[:, 1],
        f"vyaw{end}": path.velocity[:, 2] * unit,
        "sigma_x": deviations[:, 0],
        "sigma_y": deviations[:, 1],
        "sigma_z": tilt[:, 2],
        f"sigma_roll{end}": tilt[:, 0] * unit,
        f"sigma_pitch{end}": tilt[:, 1] * unit,
        f"sigma_yaw{end}": deviations[:, 2] * unit,
        "pressure_x": found.centre_of_pressure[:, 0],
        "pressure_y": found.centre_of_pressure[:, 1],
    }
    for k, name in enumerate(found.soles):
        columns[f"{name}_force"] = found.forces[:, k]
        columns[f"{name}_pressure_x"], columns[f"{name}_pressure_y"] = found.sole_pressure[:, k].T
    return columns
