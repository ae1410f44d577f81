"""Modules that scripts for NAOqi import: `naoqi`, `almath`, `motion` and `vision_definitions`.

`run_script` puts this folder at the end of a script's search path. For other programs, add it to `PYTHONPATH`.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from nao_kin._core.process import before_ending
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument

__all__ = ["FOLDER", "run_script"]

FOLDER = Path(__file__).resolve().parent
ENDPOINT_VARIABLE = "NAO_KIN_ENDPOINT"
_LOOK_SECONDS = 0.1


def run_script(script: Path | str, arguments: Sequence[str] = (), *, endpoint: str | None = None) -> int:
    """Run a script for NAOqi in a process of its own, and wait for its end.

    The script can import `naoqi`, `almath`, `motion` and `vision_definitions`, from an installed SDK if there is one;
    Python 2 is translated.

    Args:
        script: the file.
        arguments: the script's arguments.
        endpoint: the address for all its connections, "tcp://127.0.0.1:9559"; None for the address in the script.

    Returns:
        Its exit code; 128 + n if signal n ended it.

    Raises:
        BadArgument: the file does not exist.

    Examples:
        >>> from pathlib import Path
        >>> _ = Path("names.py").write_text("import almath")
        >>> nk.naoqi.run_script("names.py")
        0
    """
    path = Path(script) if isinstance(script, str | os.PathLike) else None
    if path is None or "\0" in str(path) or not path.is_file():
        raise BadArgument(f"no script {quoted(str(script))}")
    environment = {**os.environ, ENDPOINT_VARIABLE: endpoint or ""}
    command = [sys.executable, str(FOLDER), str(path), *arguments]
    with subprocess.Popen(command, env=environment) as process, before_ending(process.terminate):
        # In short waits, because a signal that arrives just before a wait begins does not end it.
        while (code := process.poll()) is None:
            with suppress(subprocess.TimeoutExpired):
                process.wait(_LOOK_SECONDS)
    return 128 - code if code < 0 else code
