"""Run a script for NAOqi with its modules on the path, its connections redirected, and Python 2 translated.

    python nao_kin/naoqi/compat SCRIPT [ARGUMENT ...]

If NAO_KIN_ENDPOINT is set, proxies of `naoqi` and sessions of `qi` connect there, whatever address the script gives.
Scripts in Python 2 and modules in their folders are translated in memory; no file and no bytecode is written.
"""

from __future__ import annotations

import ast
import atexit
import builtins
import io
import os
import re
import sys
import time
import tokenize
import traceback
import types
import warnings
from collections.abc import Iterator
from importlib import machinery
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
    code = _code_of(script)
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


def _code_of(script: Path) -> Any:
    """Return the script's code; end the program with a one-line error if it has none."""
    try:
        content = script.read_bytes()
    except OSError as error:
        sys.exit(f"nao-kin: {script}: cannot be read: {error.strerror or error}")
    try:
        code, translated = compiled(content, str(script))
    except SyntaxError as error:
        traceback.print_exception(error, limit=0)
        sys.exit(1)
    except ValueError as error:
        sys.exit(f"nao-kin: {script}: not valid Python: {error}")
    if translated:
        sys.stderr.write(f"nao-kin: {script.name} is Python 2, and runs translated\n")
    find_modules_in(script.resolve().parent, old=translated)
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


# --- Python 2 as Python 3: scripts, and the modules of their folders.
#
# lib2to3 translates code that Python 3 cannot parse or that uses names of Python 2; two integers are then divided as in
# Python 2, `global` may follow a use of the name, and `async` and `await` are ordinary names.

_NAMES = frozenset("raw_input xrange unicode basestring unichr execfile long reduce".split())
_METHODS = frozenset(("has_key", "iteritems", "itervalues"))
# NAOqi 2.5 documents `qi.async`, which Python 3 cannot parse; qi 3 calls it `runAsync`.
_QI_ASYNC = re.compile(rb"(?<=\bqi\.)async\b")
_MODULES = frozenset(
    "BaseHTTPServer ConfigParser Queue SocketServer StringIO Tkinter cPickle cStringIO commands httplib thread "
    "tkFileDialog tkMessageBox urllib2 urlparse".split()
)
_DIVIDE = "__divide_as_python_2__"
_TRUE_DIVISION = re.compile(rb"^\s*from\s+__future__\s+import\s.*\bdivision\b", re.MULTILINE)


def compiled(content: bytes, path: str, *, old: bool = False) -> tuple[types.CodeType, bool]:
    """Return the code of a script or module, and whether it was translated; an `old` one belongs to Python 2."""
    content = _QI_ASYNC.sub(b"runAsync", content)
    try:
        tree = ast.parse(content, path)
        code = compile(tree, path, "exec", dont_inherit=True)
    except (SyntaxError, ValueError) as error:
        translated = _translated(content, path, getattr(error, "lineno", None) or 0)
        if translated is None:
            raise
        return translated, True
    if old or _only_in_python_2(tree):
        translated = _translated(content, path)
        if translated is not None:
            return translated, True
    return code, False


def find_modules_in(folder: Path, *, old: bool) -> None:
    """Translate modules of a script's folder when they are imported: those in Python 2, or all of an `old` script."""
    _Loader.old = old

    def finder(path: str) -> machinery.FileFinder:
        inside = Path(path).resolve()
        if folder not in (inside, *inside.parents) or "site-packages" in inside.parts:
            raise ImportError(f"{path} is not the script's")
        return machinery.FileFinder(
            path,
            (machinery.ExtensionFileLoader, machinery.EXTENSION_SUFFIXES),
            (_Loader, machinery.SOURCE_SUFFIXES),
        )

    sys.path_hooks.insert(0, finder)
    sys.path_importer_cache.clear()


class _Loader(machinery.SourceFileLoader):
    """Loads modules, and translates those in Python 2, or all if they belong to an `old` script."""

    old = False

    def path_stats(self, path: Any) -> Any:
        """Prevent bytecode files of translated modules, which another Python would take for the original's."""
        raise OSError

    def source_to_code(self, data: Any, path: Any, *, _optimize: int = -1) -> Any:  # type: ignore[override]
        """Return the code of a module."""
        code, translated = compiled(bytes(data), str(path), old=self.old)
        if translated and not self.old:
            sys.stderr.write(f"nao-kin: {Path(path).name} is Python 2, and runs translated\n")
        return code


def _only_in_python_2(tree: ast.AST) -> bool:
    """Return whether a tree uses names that Python 3 lacks, outside of a `try` that handles their absence."""
    nodes = list(_untried(tree))
    bound = {node.id for node in nodes if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load)}
    bound |= {node.arg for node in nodes if isinstance(node, ast.arg)}
    bound |= {node.name for node in nodes if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    for node in nodes:
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            bound |= {alias.asname or alias.name for alias in node.names}
    for node in nodes:
        if isinstance(node, ast.Name) and node.id in _NAMES - bound:
            return True
        if isinstance(node, ast.Attribute) and (node.attr in _METHODS or ast.unparse(node) == "time.clock"):
            return True
        if isinstance(node, ast.Import) and any(alias.name in _MODULES for alias in node.names):
            return True
        if isinstance(node, ast.ImportFrom) and node.level == 0:
            names = {alias.name for alias in node.names}
            if node.module in _MODULES or (node.module == "time" and "clock" in names):
                return True
    return False


def _untried(node: ast.AST) -> Iterator[ast.AST]:
    yield node
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Try) and any(_is_for_other_versions(handler) for handler in child.handlers):
            continue
        yield from _untried(child)


def _is_for_other_versions(handler: ast.ExceptHandler) -> bool:
    names = {node.id for node in ast.walk(handler.type) if isinstance(node, ast.Name)} if handler.type else set()
    return bool(names & {"ImportError", "ModuleNotFoundError", "NameError", "AttributeError"})


def _translated(content: bytes, path: str, read_to: int = 0) -> types.CodeType | None:
    """Return the code of a Python 2 script; None if it is not Python 2, or if there is no translator.

    Raise SyntaxError at a line after `read_to`, the line where Python 3 stopped, if Python 2 stops there.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # deprecated, but part of every Python for which qi has wheels
        try:
            from lib2to3.pgen2.parse import ParseError
            from lib2to3.refactor import RefactoringTool, get_fixers_from_package
        except ImportError:
            return None
        text = _text(content).expandtabs(8) + "\n"
        try:
            translated: Any = RefactoringTool(get_fixers_from_package("lib2to3.fixes")).refactor_string(text, path)
            for leaf in translated.leaves():
                if leaf.value in ("async", "await"):
                    leaf.value += "_"
            tree = ast.parse(str(translated), path)
            if not _TRUE_DIVISION.search(content):
                setattr(builtins, _DIVIDE, _divide)
                tree = _Divisions().visit(tree)
            tree = ast.fix_missing_locations(_Globals().visit(tree))
            code = compile(tree, path, "exec", dont_inherit=True)
        except ParseError as error:
            line, column = error.context[1]
            if read_to and line > read_to:
                shown = text.split("\n")[line - 1]
                raise SyntaxError("invalid syntax, also in Python 2", (path, line, column + 1, shown)) from None
            return None
        except Exception:  # a script that the translator cannot parse is not Python 2
            return None
    if not hasattr(time, "clock"):
        time.clock = time.process_time  # type: ignore[attr-defined]
    return code


def _text(content: bytes) -> str:
    """Return a script's text in its declared encoding; Latin-1 if it declares none and is not UTF-8."""
    try:
        encoding, _ = tokenize.detect_encoding(io.BytesIO(content).readline)
        text = content.decode(encoding)
    except (SyntaxError, UnicodeDecodeError):
        text = content.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _divide(one: Any, other: Any) -> Any:
    """Divide as Python 2: two integers give the floor."""
    return one // other if isinstance(one, int) and isinstance(other, int) else one / other


class _Divisions(ast.NodeTransformer):
    """Replaces every division with a call of `_divide`."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        return self._call(node, node.left, node.right) if isinstance(node.op, ast.Div) else node

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.AST:
        self.generic_visit(node)
        if not isinstance(node.op, ast.Div):
            return node
        read = ast.parse(ast.unparse(node.target), mode="eval").body
        divided = self._call(node, ast.copy_location(read, node), node.value)
        return ast.copy_location(ast.Assign([node.target], divided), node)

    def _call(self, node: ast.AST, one: ast.expr, other: ast.expr) -> ast.Call:
        function = ast.copy_location(ast.Name(_DIVIDE, ast.Load()), node)
        return ast.copy_location(ast.Call(function, [one, other], []), node)


class _Globals(ast.NodeTransformer):
    """Moves `global` to the beginning of its function or class: Python 2 allows uses of the names before it."""

    def __init__(self) -> None:
        self._names: list[str] = []

    def _visit_scope(self, node: Any) -> Any:
        outer, self._names = self._names, []
        self.generic_visit(node)
        if self._names:
            after = int(ast.get_docstring(node, clean=False) is not None)
            node.body.insert(after, ast.copy_location(ast.Global(sorted(set(self._names))), node))
        self._names = outer
        return node

    visit_FunctionDef = visit_ClassDef = _visit_scope

    def visit_Global(self, node: ast.Global) -> ast.AST:
        self._names += node.names
        return ast.copy_location(ast.Pass(), node)


if __name__ == "__main__":
    main()
