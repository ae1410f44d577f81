"""`nao-kin collisions`: the links that overlap at given joint values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import typer

from nao_kin._core.arrays import Floats, LimitPolicy
from nao_kin.cli.options import ALLOW, CONFIGURATIONS, EXACT, JSON, LIMITS, TOLERANCE, RobotOptions, command, option
from nao_kin.cli.output import print_json, print_note, print_table
from nao_kin.cli.sources import FileOptions, pairs_of

if TYPE_CHECKING:
    from nao_kin.robot import Contact


@command(
    "collisions", "Example: nao-kin collisions --posture Crouch --margin 0.005; nao-kin collisions walk.csv --json"
)
def collisions(
    *,
    file: str | None = CONFIGURATIONS,
    given: FileOptions,
    margin: float | None = option(
        "M", "List links nearer than this [m]; negative: only those that overlap by more. Default: 0."
    ),
    tolerance: float = TOLERANCE,
    allow: list[str] | None = ALLOW,
    exact: bool = EXACT,
    limits: LimitPolicy = LIMITS,
    json: bool = JSON,
    robot: RobotOptions,
) -> None:
    """Print the links that overlap, and the clearance: of one configuration, or of every row of a file.

    Input is as for nao-kin fk. Links that a joint connects, or that always or never touch, are not compared. A motion
    gives one row for each of its key times, or --rate rows per second. Exit code 1 if links overlap.
    """
    model, q, times, _ = given.configurations(robot, file, limits=limits)
    q = q[0] if file is None else q
    accepted: Any = {"tolerance": tolerance, "allowed": pairs_of(allow), "exact": exact}
    clearance = model.clearance(q, **accepted)
    contacts = model.collisions(q, margin=margin or 0.0, **accepted)
    print_note(*clearance.notes)
    free = np.asarray(clearance.is_free)
    if json:
        head = {"robot": model.name, "margin": margin or 0.0, "units": {"length": "m"}}
        rows = [_as_dict(contact, times) for contact in contacts]
        if file is None:
            print_json({**head, "clearance": clearance.as_dict(), "contacts": rows})
        else:
            print_json({**head, "configurations": len(q), "overlapping": int((~free).sum()), "contacts": rows})
    elif file is None:
        if contacts:
            cells = [(_names(contact), _mm(contact.distance)) for contact in contacts]
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


def _as_dict(contact: Contact, times: Floats | None) -> dict[str, Any]:
    where: dict[str, Any] = {"row": contact.index[0]} if contact.index else {}
    if times is not None:
        where["time"] = float(times[contact.index[0]])
    return {**where, **contact.as_dict()}


def _print_pairs(contacts: Sequence[Contact], times: Floats | None) -> None:
    """Print one line for each pair of links: in how many rows it is listed, and the worst."""
    of_pair: dict[str, list[Contact]] = {}
    for contact in contacts:
        of_pair.setdefault(_names(contact), []).append(contact)
    rows = []
    for names, several in of_pair.items():
        worst = min(several, key=lambda contact: contact.distance)
        row = worst.index[0]
        when = str(row) if times is None else f"{times[row]:.6g}"
        rows.append((names, str(len(several)), _mm(worst.distance), when))
    columns = ("links", "rows", "least distance\n[mm]", "in row" if times is None else "at\n[s]")
    print_table(columns, sorted(rows, key=lambda cells: float(cells[2])), numbers=columns[1:])


def _names(contact: Contact) -> str:
    return f"{contact.links[0]}, {contact.links[1]}"


def _mm(distance: float) -> str:
    return f"{distance * 1e3:.1f}"
