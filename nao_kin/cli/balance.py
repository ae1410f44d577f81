"""`nao-kin balance` and `collisions`: how far a robot is from tipping, and from touching itself."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import typer

from nao_kin._core.arrays import Floats, LimitPolicy, finite_or_none
from nao_kin.cli import options as shared
from nao_kin.cli.options import RobotOptions, command, option
from nao_kin.cli.output import degrees_per, print_json, print_json_list, print_note, print_table, units
from nao_kin.cli.sources import FileOptions, OverlapOptions, numbers_of
from nao_kin.errors import BadArgument

if TYPE_CHECKING:
    from collections.abc import Sequence

    from nao_kin.robot import Contact, RobotModel
    from nao_kin.world import Balance

# Rows of a file that are set down at a time.
_CHUNK = 8192


@command(
    "balance",
    "Example: nao-kin balance --posture Crouch; nao-kin balance walk.csv --sole LLeg --json",
)
def balance(
    *,
    file: str | None = shared.CONFIGURATIONS,
    given: FileOptions,
    sole: list[str] | None = option("NAME", "A sole on the floor; repeatable. Default: what is lowest."),
    gravity: str | None = option("X,Y,Z", "Direction of gravity in the root link. Default: normal to the soles."),
    outline: Literal["sole", "sensors"] = option(None, "Outline of a sole.", default="sole"),
    limits: LimitPolicy = shared.LIMITS,
    json: bool = shared.JSON,
    robot: RobotOptions,
) -> None:
    """Set a robot down, and print what touches the floor, its margin and its tilt angles.

    The margin is the distance of the centre of mass, seen from above, from the edge of the support polygon, negative
    outside. The robot tips over an edge when it is tilted by more than the tilt angle. FILE is as for nao-kin fk; a row
    whose contacts span no area has no margin.
    """
    down = None if gravity is None else numbers_of(gravity, "--gravity", 3)
    model = robot.load()
    log = given.configurations(model, file, limits=limits)
    measured, (q, times, many, _) = log.measured(model, sole, "contacts", "forces"), log
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
        (k, balance(model, q[k : k + _CHUNK], **options, **{name: m[k : k + _CHUNK] for name, m in measured.items()}))
        for k in range(0, len(q), _CHUNK)
    )
    rows = (row for k, part in parts for row in _rows(part, k, times, deg))
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


# --- `nao-kin collisions`.


@command(
    "collisions", "Example: nao-kin collisions --posture Crouch --margin 0.005; nao-kin collisions walk.csv --json"
)
def collisions(
    *,
    file: str | None = shared.CONFIGURATIONS,
    given: FileOptions,
    margin: float = option(
        "M", "List links nearer than this [m]; negative: only those that overlap by more.", default=0.0
    ),
    accepted: OverlapOptions,
    limits: LimitPolicy = shared.LIMITS,
    json: bool = shared.JSON,
    robot: RobotOptions,
) -> None:
    """Print the links that overlap, and the clearance: of one configuration, or of every row of a file.

    Input is as for nao-kin fk. Links that a joint connects, or that always or never touch, are not compared. A motion
    gives one row for each of its key times, or --rate rows per second. Exit code 1 if links overlap.
    """
    model, rule = robot.load(), accepted.rule
    q, times, *_ = given.configurations(model, file, limits=limits)
    q = q[0] if file is None else q
    options: Any = {"tolerance": rule.tolerance, "allowed": rule.allowed, "exact": rule.exact}
    clearance = model.clearance(q, **options)
    contacts = model.collisions(q, margin=margin, **options)
    print_note(*clearance.notes)
    free = np.asarray(clearance.is_free)
    if json:
        head = {"robot": model.name, "margin": margin, "units": {"length": "m"}}
        rows = [_contact_row(contact, times) for contact in contacts]
        if file is None:
            print_json({**head, "clearance": clearance.as_dict(), "contacts": rows})
        else:
            print_json({**head, "configurations": len(q), "overlapping": int((~free).sum()), "contacts": rows})
    elif file is None:
        if contacts:
            cells = [(_pair(contact), _mm(contact.distance)) for contact in contacts]
            print_table(("links", "distance\n[mm]"), cells, numbers=("distance\n[mm]",))
        if clearance.pair_index >= 0:
            one, other = clearance.pairs[int(clearance.pair_index)]
            print(f"clearance {_mm(float(clearance.distance))} mm: {one} and {other}")
        else:
            print("no clearance: there are no pairs of links to compare")
    else:
        if contacts:
            _print_pairs(contacts, times)
        print(f"links overlap in {int((~free).sum())} of {len(q)} configurations")
    if not free.all():
        raise typer.Exit(1)


def _contact_row(contact: Contact, times: Floats | None) -> dict[str, Any]:
    where: dict[str, Any] = {"row": contact.index[0]} if contact.index else {}
    if times is not None:
        where["time"] = float(times[contact.index[0]])
    return {**where, **contact.as_dict()}


def _print_pairs(contacts: Sequence[Contact], times: Floats | None) -> None:
    """Print one line for each pair of links: in how many rows it is listed, and the worst."""
    of_pair: dict[str, list[Contact]] = {}
    for contact in contacts:
        of_pair.setdefault(_pair(contact), []).append(contact)
    rows = []
    for names, several in of_pair.items():
        worst = min(several, key=lambda contact: contact.distance)
        row = worst.index[0]
        when = str(row) if times is None else f"{times[row]:.6g}"
        rows.append((names, str(len(several)), _mm(worst.distance), when))
    columns = ("links", "rows", "least distance\n[mm]", "in row" if times is None else "at\n[s]")
    print_table(columns, sorted(rows, key=lambda cells: float(cells[2])), numbers=columns[1:])


def _pair(contact: Contact) -> str:
    return f"{contact.links[0]}, {contact.links[1]}"


def _mm(distance: float) -> str:
    return f"{distance * 1e3:.1f}"
