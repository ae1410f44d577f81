"""Old scripts, run as they are: in a process of their own, with the modules that they import."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from nao_kin._common.ending import before_ending
from nao_kin._text import quoted
from nao_kin.errors import BadArgument
from nao_kin.naoqi.compat import FOLDER

ENDPOINT_VARIABLE = "NAO_KIN_ENDPOINT"


def run_script(script: Path | str, arguments: Sequence[str] = (), *, endpoint: str | None = None) -> int:
    """Run a script for NAOqi in a process of its own, and wait for its end.

    It finds the modules `naoqi`, `almath` and `motion`, those of an SDK before ours; Python 2 is translated.

    Args:
        script: the file.
        arguments: its own.
        endpoint: where all its connections lead, whatever address it gives: "tcp://127.0.0.1:9559"; None for the
            address that it gives.

    Returns:
        Its exit code; 128 + n where signal n ended it.

    Raises:
        BadArgument: no such file.

    Examples:
        >>> from pathlib import Path
        >>> _ = Path("names.py").write_text("import almath")
        >>> nk.naoqi.run_script("names.py")
        0
    """
    path = Path(script) if isinstance(script, str | os.PathLike) else None
    if path is None or "\0" in str(path) or not path.is_file():
        raise BadArgument(f"no script {quoted(str(script))}")
    environment = dict(os.environ)
    environment.pop(ENDPOINT_VARIABLE, None)
    if endpoint is not None:
        environment[ENDPOINT_VARIABLE] = endpoint
    command = [sys.executable, str(FOLDER), str(path), *arguments]
    with subprocess.Popen(command, env=environment) as process:
        take_back = before_ending(process.terminate)
        try:
            code = process.wait()
        finally:
            take_back()
    return 128 - code if code < 0 else code
