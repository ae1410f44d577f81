"""`nao-kin doctor`: is this installation sound."""

from __future__ import annotations

import typer

from nao_kin.cli.installation import inspect_installation
from nao_kin.cli.options import Json
from nao_kin.cli.output import print_json, print_table


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("doctor", epilog="Example: nao-kin doctor --json")(doctor)


def doctor(json: Json = False) -> None:
    """Versions, where each library comes from, known clashes, and a browser if any; exit 1 when something is wrong."""
    state = inspect_installation()
    if json:
        print_json(state.as_dict())
    else:
        rows = [("python", state.python, state.executable), ("system", state.system, "–")]
        rows += [(library.name, library.version or "–", library.location or "–") for library in state.libraries]
        rows.append(("browser", "found" if state.browser else "none", state.browser or "–"))
        print_table(("what", "version", "where"), rows)
        for problem in state.problems:
            print(f"problem: {problem}")
        if not state.problems:
            print("No problems found.")
    if state.problems:
        raise typer.Exit(1)
