"""Run a script for NAOqi: its modules on the path, its connections led elsewhere, Python 2 translated.

    python nao_kin/naoqi/compat SCRIPT [ARGUMENT ...]

Where NAO_KIN_ENDPOINT is set, proxies of `naoqi` and sessions of `qi` connect there, whatever address the script gives.
A script in Python 2 is translated in memory, with the modules beside it.
"""

from __future__ import annotations

import atexit
import importlib
import os
import sys
import traceback
import types
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parent
ENDPOINT_VARIABLE = "NAO_KIN_ENDPOINT"


def main() -> None:
    """Run the script that the first argument names, with the others as its own."""
    codes: list[int] = []
    atexit.register(_leave_qi, codes)  # the first to be registered, and so the last to be called
    script = Path(sys.argv[1])
    sys.argv = sys.argv[1:]
    # Behind everything else: an SDK that is installed, and modules beside the script, come first.
    sys.path[:] = [
        str(script.resolve().parent),
        *(entry for entry in sys.path[1:] if entry != str(FOLDER)),
        str(FOLDER),
    ]
    endpoint = os.environ.get(ENDPOINT_VARIABLE)
    if endpoint:
        _lead_qi_to(endpoint)
    code = compiled(script)
    module = types.ModuleType("__main__")
    module.__file__ = str(script)
    sys.modules["__main__"] = module
    try:
        exec(code, module.__dict__)
        codes.append(0)
    except KeyboardInterrupt:
        codes.append(130)
    except SystemExit as end:
        if not isinstance(end.code, (int, type(None))):
            sys.stderr.write(f"{end.code}\n")
        codes.append((end.code or 0) if isinstance(end.code, (int, type(None))) else 1)
    except Exception as error:
        # From the script on: how it was started is of no interest.
        trace = error.__traceback__
        traceback.print_exception(type(error), error, trace.tb_next if trace else None)
        codes.append(1)
    sys.exit(codes[0])


def _leave_qi(codes: list[int]) -> None:
    """Leave with the script's exit code, and without the rest of Python's end, where qi is loaded.

    Its threads go on, and want Python's lock for the objects that they still hold: while Python ends, that aborts the
    program.
    """
    if codes and "qi" in sys.modules:
        for stream in (sys.stdout, sys.stderr):
            try:
                stream.flush()
            except (OSError, ValueError):  # whoever read it has gone
                continue
        os._exit(codes[0] & 0xFF)


def compiled(script: Path) -> Any:
    """The script's code; ends the program with one line where there is none."""
    python2 = importlib.import_module("_python2")
    try:
        content = script.read_bytes()
    except OSError as error:
        sys.exit(f"nao-kin: {script}: cannot be read: {error.strerror or error}")
    try:
        code, translated = python2.compiled(content, str(script))
    except SyntaxError as error:
        traceback.print_exception(error, limit=0)
        sys.exit(1)
    except ValueError as error:
        sys.exit(f"nao-kin: {script}: no Python: {error}")
    if translated:
        sys.stderr.write(f"nao-kin: {script.name} is Python 2, and runs translated\n")
        python2.find_modules_in(script.resolve().parent)
    return code


def _lead_qi_to(endpoint: str) -> None:
    """Have the sessions and applications of `qi` connect to `endpoint`."""
    try:
        import qi
    except ImportError:
        return  # the script says so itself where it needs it
    make_session, make_application = qi.Session, qi.Application

    def Session(*arguments: Any) -> Any:
        session = make_session(*arguments)
        connect = session.connect
        session.connect = lambda *address, **more: connect(endpoint, **more)
        return session

    def Application(args: Any = None, raw: bool = False, autoExit: bool = True, url: Any = None) -> Any:
        given = list(sys.argv if args is None else args)
        kept = [word for word in given if not str(word).startswith("--qi-url")]
        return make_application(kept, raw, autoExit, endpoint)

    qi.Session, qi.Application, qi.ApplicationSession = Session, Application, Application


if __name__ == "__main__":
    main()
