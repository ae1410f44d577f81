"""`nao-kin warmup`: the batch kernels compiled ahead."""

from __future__ import annotations

import typer

from nao_kin.cli.options import JsonOption
from nao_kin.cli.output import print_json, print_table


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("warmup", epilog="Example: nao-kin warmup")(warmup)


def warmup(json: JsonOption = False) -> None:
    """Compile the kernels for large batches ahead, once on a machine; they are kept in the user's cache.

    NUMBA_CACHE_DIR names another folder. Without this command, the first large batch compiles them.
    """
    from nao_kin.batch import warm_up

    states = warm_up()
    if json:
        print_json(
            {
                "kernels": [
                    {
                        "precision": state.precision,
                        "compiled": state.compiled,
                        "seconds": round(state.seconds, 3),
                        "folder": None if state.folder is None else str(state.folder),
                    }
                    for state in states
                ]
            }
        )
        return
    rows = [
        (state.precision, "compiled" if state.compiled else "found", f"{state.seconds:.1f}", str(state.folder or "–"))
        for state in states
    ]
    print_table(("precision", "", "s", "kept in"), rows, numbers=("s",))
