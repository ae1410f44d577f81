"""Run a script for NAOqi with its modules on the path, its connections redirected, and Python 2 translated.

    python nao_kin/naoqi/compat SCRIPT [ARGUMENT ...]

If NAO_KIN_ENDPOINT is set, proxies of `naoqi` and sessions of `qi` connect there, whatever address the script gives.
Scripts in Python 2 and modules in their folders are translated in memory.
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
    """Run the script that the first argument names, with the other arguments."""
    codes: list[int] = []
    atexit.register(_leave_qi, codes)  # registered first, and so called last
    script = Path(sys.argv[1])
    sys.argv = sys.argv[1:]
    # Last on the path: an installed SDK, and modules in the script's folder, come first.
    sys.path[:] = [
        str(script.resolve().parent),
        *(entry for entry in sys.path[1:] if entry != str(FOLDER)),
        str(FOLDER),
    ]
    endpoint = os.environ.get(ENDPOINT_VARIABLE)
    if endpoint:
        _redirect_qi(endpoint)
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
        # The traceback begins in the script.
        trace = error.__traceback__
        traceback.print_exception(type(error), error, trace.tb_next if trace else None)
        codes.append(1)
    sys.exit(codes[0])


def _leave_qi(codes: list[int]) -> None:
    """Exit immediately with the script's code if qi is loaded.

    The threads of qi need Python's lock for their objects, which would abort the program while Python shuts down.
    """
    if codes and "qi" in sys.modules:
        for stream in (sys.stdout, sys.stderr):
            try:
                stream.flush()
            except (OSError, ValueError):  # its reader has closed the pipe
                continue
        os._exit(codes[0] & 0xFF)


def compiled(script: Path) -> Any:
    """Return the script's code; end the program with a one-line error if it has none."""
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
        sys.exit(f"nao-kin: {script}: not valid Python: {error}")
    if translated:
        sys.stderr.write(f"nao-kin: {script.name} is Python 2, and runs translated\n")
    python2.find_modules_in(script.resolve().parent, old=translated)
    return code


def _redirect_qi(endpoint: str) -> None:
    """Make the sessions and applications of `qi` connect to `endpoint`."""
    try:
        import qi
    except ImportError:
        return  # a script that needs qi reports that it is missing
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
