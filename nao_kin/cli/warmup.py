"""`nao-kin warmup`: the batch kernels compiled ahead."""

from __future__ import annotations

from nao_kin._common.compiler import need_numba
from nao_kin.cli.options import JsonOption, command
from nao_kin.cli.output import print_json, print_table


@command("warmup", "Example: nao-kin warmup")
def warmup(json: JsonOption = False) -> None:
    """Compile the kernels for large batches, reach maps and inverse kinematics ahead, once on a machine.

    They are kept in the user's cache; NUMBA_CACHE_DIR names another folder. Without this command, the first
    large batch, map or inverse kinematics compiles what it needs.
    """
    need_numba("warmup")
    from nao_kin import batch, ik, reach

    states = (*batch.warm_up(), *reach.warm_up(), *ik.warm_up())
    if json:
        print_json(
            {
                "kernels": [
                    {
                        "name": state.name,
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
        (state.name, "compiled" if state.compiled else "found", f"{state.seconds:.1f}", str(state.folder or "–"))
        for state in states
    ]
    print_table(("kernel", "", "s", "kept in"), rows, numbers=("s",))
