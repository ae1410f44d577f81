"""`nao-kin balance`: what touches the floor, and how far a robot is from tipping."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from nao_kin._core.arrays import Floats, LimitPolicy, finite_or_none
from nao_kin.cli.options import CONFIGURATIONS, CONTACTS, FORCES, JSON, LIMITS, RobotOptions, command, option
from nao_kin.cli.output import degrees_per, print_json, print_json_list, print_table, units
from nao_kin.cli.sources import FileOptions, numbers_of
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from nao_kin.robot import RobotModel
    from nao_kin.world import Balance

# Rows of a file that are set down at a time.
_CHUNK = 8192


@command("balance", "Example: nao-kin balance --posture Crouch; nao-kin balance walk.csv --sole LLeg --json")
def balance(
    *,
    file: str | None = CONFIGURATIONS,
    given: FileOptions,
    sole: list[str] | None = option("NAME", "A sole on the floor; repeatable. Default: what is lowest."),
    contacts: str | None = CONTACTS,
    forces: str | None = FORCES,
    gravity: str | None = option("X,Y,Z", "Direction of gravity in the root link. Default: normal to the soles."),
    outline: Literal["sole", "sensors"] = option(None, "Outline of a sole.", default="sole"),
    limits: LimitPolicy = LIMITS,
    json: bool = JSON,
    robot: RobotOptions,
) -> None:
    """Set a robot down, and print what touches the floor, its margin and its tilt angles.

    The margin is the distance of the centre of mass, seen from above, from the edge of the support polygon, negative
    outside. The robot tips over an edge when it is tilted by more than the tilt angle. FILE is as for nao-kin fk; a row
    whose contacts span no area has no margin.
    """
    down = None if gravity is None else numbers_of(gravity, "--gravity", 3)
    read, measured = given.measured(file, contacts=contacts, forces=forces)
    model, q, times, many = read.configurations(robot, file, limits=limits)
    from nao_kin.world import balance

    elsewhere = [name for name in sole or () if not _on_a_foot(model, name)]
    if elsewhere:
        soles = ", ".join(model.semantics.soles)
        raise BadArgument(f"--sole {', '.join(elsewhere)}: not on the links of the robot's soles ({soles})")
    deg = given.deg
    options: Any = {"soles": sole, "gravity": down, "outline": outline}
    head = {"robot": model.name, "outline": outline, "units": units(deg)}
    if not many:
        found = balance(model, q[0], **options, **{what: rows[0] for what, rows in measured.items()})
        if json:
            print_json({**head, **_document(model, found, deg)})
        else:
            _print_one(model, found)
        return
    parts = (
        balance(model, q[k : k + _CHUNK], **options, **{what: rows[k : k + _CHUNK] for what, rows in measured.items()})
        for k in range(0, len(q), _CHUNK)
    )
    rows = (
        row
        for start, part in zip(range(0, len(q), _CHUNK), parts, strict=True)
        for row in _rows(part, start, times, deg)
    )
    if json:
        print_json_list(head, "configurations", rows)
        return
    print(f"{'row':>7}{'time':>12}  {'margin [mm]':>11}  {'tilt [°]':>8}  soles")
    for row in rows:
        time = "" if row.get("time") is None else f"{row['time']:.6f}"
        numbers = "          –         –"
        if row["margin"] is not None:
            tilt = row["tilt"] if deg else math.degrees(row["tilt"])
            numbers = f"{1000.0 * row['margin']:11.1f}  {tilt:8.1f}"
        print(f"{row['row']:>7}{time:>12}  {numbers:>21}  {', '.join(row['soles']) or '–'}")


def _document(model: RobotModel, found: Balance, deg: bool) -> dict[str, Any]:
    """Return the balance of one configuration for JSON."""
    unit = degrees_per("rad", deg)
    edges = zip(found.vertices.tolist(), found.distances.tolist(), (unit * found.tilts).tolist(), strict=True)
    return {
        "margin": float(found.margin),
        "nearest_edge": int(found.nearest),
        "edges": [{"from": begin, "distance": distance, "tilt": tilt} for begin, distance, tilt in edges],
        "centre_of_mass": found.com.tolist(),
        "stands": bool(found.down.stands),
        "soles": _names(found.down.soles, found.down.touching),
        "links": _names(model.link_names, found.down.links),
        "T_world_base": found.down.T_world_base.tolist(),
        "T_sole_base": dict(zip(found.down.soles, found.T_sole_base.tolist(), strict=True)),
        "T_robot_base": found.T_robot_base.tolist() if found.down.soles else None,
    }


def _on_a_foot(model: RobotModel, frame: str) -> bool:
    """Return whether a frame is on a link with a sole; true for a robot whose soles are not known."""
    soles = model.semantics.soles
    bodies = [model.model.frames[k].parentJoint for k in model.frame_ids([frame, *soles])]
    return not soles or bodies[0] in bodies[1:]


def _print_one(model: RobotModel, found: Balance) -> None:
    lines = {
        "touches the floor": ", ".join(_names(model.link_names, found.down.links) or ["the soles"]),
        "soles on the floor": ", ".join(_names(found.down.soles, found.down.touching)) or "–",
        "centre of mass": f"{1000.0 * found.com[2]:.1f} mm above the floor",
        "margin": f"{1000.0 * found.margin:.1f} mm" + ("" if found.margin >= 0.0 else ": it falls"),
        "height of the root": f"{1000.0 * found.down.T_world_base[2, 3]:.1f} mm",
    }
    print_table(["", model.name], lines.items())
    columns = ["x\n[mm]", "y\n[mm]", "distance\n[mm]", "tilt\n[°]"]
    table = []
    for k, (corner, distance, tilt) in enumerate(zip(found.vertices, found.distances, found.tilts, strict=True)):
        numbers = [*(1000.0 * corner), 1000.0 * distance, math.degrees(tilt)]
        table.append([f"{value + 0.0:.1f}" for value in numbers] + ["nearest" if k == found.nearest else ""])
    print_table([*columns, ""], table, numbers=columns)


def _rows(found: Balance, start: int, times: Floats | None, deg: bool) -> list[dict[str, Any]]:
    """Return the balance of a batch for JSON, one row for each configuration."""
    unit = degrees_per("rad", deg)
    tilts = np.where(
        found.nearest < 0, np.nan, unit * np.min(found.tilts, axis=-1, initial=np.inf, where=~np.isnan(found.tilts))
    )
    rows = []
    for k, (margin, tilt) in enumerate(zip(found.margin.tolist(), tilts.tolist(), strict=True)):
        row: dict[str, Any] = {"row": start + k} | ({} if times is None else {"time": float(times[start + k])})
        row |= {"margin": finite_or_none(margin), "tilt": finite_or_none(tilt)}
        rows.append(row | {"soles": _names(found.down.soles, found.down.touching[k])})
    return rows


def _names(names: tuple[str, ...], mask: Any) -> list[str]:
    return [name for name, on in zip(names, mask, strict=True) if on]
