"""Plant small faults in a copy of the project, one by one, and check that the tests detect them.

`faults.tsv` lists the faults, one a row: a name, the file, the function (`Class.method`, empty for the module, with #2
for the second occurrence), the expression or statement that is replaced and its replacement, and the tests that must
detect it. In Python files the text is found in the syntax tree of the function, so that moving and formatting code
changes no row; in the page's files, blanks do not count.

First the tests run without a fault, because a test that fails anyway detects nothing. Then each fault is planted, its
tests run, and the source is restored. The checkout itself is never touched.

Example:
    python scripts/mutate.py --list
    python scripts/mutate.py --only rank-one-defective-a-million-times-too-easily
"""

from __future__ import annotations

import argparse
import ast
import csv
import functools
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

ROOT = Path(__file__).resolve().parent.parent
FILES = ("README.md", "CITATION.cff", "pyproject.toml", "Makefile")
COPIED = ("nao_kin", "urdf", "tests", "scripts", "examples", "docs", "web", *FILES)

_Hit = TypeVar("_Hit")

# Exit codes of pytest and node; other codes, such as that for no collected tests, say nothing about
# the fault.
PASSED, FAILED = 0, 1
VERDICTS = {PASSED: "survived", FAILED: "killed"}


class Fault(NamedTuple):
    """A row of `faults.tsv`; `file` is below nao_kin or web, `tests` are names of test files with ::test_name."""

    name: str
    file: str
    place: str
    old: str
    new: str
    tests: str

    @property
    def path(self) -> str:
        """The source file, from the root of the project."""
        return self.file if self.file.startswith("web/") else f"nao_kin/{self.file}"

    @property
    def arguments(self) -> list[str]:
        """Arguments for pytest, or files of `web/tests` for node."""
        return [f"web/tests/{test}" if _is_for_node(test) else _found(test) for test in self.tests.split()]


class NotPlanted(Exception):
    """The text of a fault does not occur in its place, or occurs more than once."""


def read_faults(path: Path = ROOT / "scripts" / "faults.tsv") -> list[Fault]:
    """Return the rows of the table; lines that begin with # are comments."""
    with path.open(encoding="utf-8", newline="") as file:
        lines = (line for line in file if not line.startswith("#"))
        rows = csv.reader(lines, delimiter="\t", quoting=csv.QUOTE_NONE)
        return [Fault(*row) for row in rows]


def planted(fault: Fault, root: Path = ROOT) -> str:
    """Return the source with the fault in it.

    Raises:
        NotPlanted: the old text does not occur in the function, or more than once without a number.
    """
    path = root / fault.path
    if not path.is_file():
        raise NotPlanted(f"{fault.name}: {fault.path} is not there")
    source = path.read_text(encoding="utf-8")
    return _planted_in_python(fault, source) if path.suffix == ".py" else _planted_in_text(fault, source)


def _planted_in_text(fault: Fault, source: str) -> str:
    """Replace the only occurrence of the text, or that with the number, whatever its blanks are."""
    pattern = r"\s*".join(map(re.escape, re.findall(r"\w+|[^\w\s]", fault.old)))
    hit = _chosen(fault, list(re.finditer(pattern, source)))
    return source[: hit.start()] + fault.new + source[hit.end() :]


def _chosen(fault: Fault, hits: list[_Hit]) -> _Hit:
    """Return the hit with the number of the fault, or the only one."""
    number = fault.place.partition("#")[2]
    chosen = hits[int(number) - 1 :][:1] if number else hits
    if len(chosen) != 1:
        raise NotPlanted(f"{fault.name}: its text occurs {len(hits)} times in {fault.path} {fault.place}, not once")
    return chosen[0]


def _planted_in_python(fault: Fault, source: str) -> str:
    """Replace one node of the syntax tree of a function, and return the tree as source without comments."""
    tree = ast.parse(source)
    replace(tree, *find(fault, tree))
    return ast.unparse(tree)


def find(fault: Fault, tree: ast.Module) -> tuple[ast.expr | ast.stmt, ast.expr | ast.stmt]:
    """Return the node of a file's syntax tree that a fault replaces, and the node that takes its place.

    Raises:
        NotPlanted: see `planted`.
    """
    scope: ast.AST = tree
    for name in filter(None, fault.place.partition("#")[0].split(".")):
        inside = next((node for node in ast.walk(scope) if getattr(node, "name", None) == name), None)
        if inside is None:
            raise NotPlanted(f"{fault.name}: {fault.path} has no {fault.place}")
        scope = inside
    old, new = _parsed(fault)
    hits = [node for node in ast.walk(scope) if isinstance(node, (ast.expr, ast.stmt)) and _same(node, old)]
    hits.sort(key=lambda node: (node.lineno, node.col_offset))
    return _chosen(fault, hits), new


def replace(tree: ast.AST, old: ast.AST, new: ast.AST) -> None:
    """Put a node of a syntax tree in the place of another; called with the nodes swapped, it restores the tree."""
    if isinstance(old, ast.expr) and hasattr(old, "ctx") and hasattr(new, "ctx"):
        new.ctx = old.ctx
    for node in ast.walk(tree):
        for field, value in vars(node).items():
            if value is old:
                setattr(node, field, new)
                return
            if isinstance(value, list) and any(one is old for one in value):
                value[next(k for k, one in enumerate(value) if one is old)] = new
                return


def _same(a: object, b: object) -> bool:
    """Return whether two parts of syntax trees are the same code; a variable that is read or set is the same."""
    if isinstance(a, ast.expr_context):
        return isinstance(b, ast.expr_context)
    if isinstance(a, ast.AST):
        return type(a) is type(b) and all(_same(getattr(a, field), getattr(b, field)) for field in a._fields)
    if isinstance(a, list):
        return isinstance(b, list) and len(a) == len(b) and all(map(_same, a, b))
    return type(a) is type(b) and a == b


def _parsed(fault: Fault) -> tuple[ast.expr | ast.stmt, ast.expr | ast.stmt]:
    """Return old and new as two expressions, or as two statements."""
    try:
        return ast.parse(fault.old, mode="eval").body, ast.parse(fault.new, mode="eval").body
    except SyntaxError:
        try:
            (old,), (new,) = ast.parse(fault.old).body, ast.parse(fault.new).body
        except (SyntaxError, ValueError):
            raise NotPlanted(f"{fault.name}: expected two expressions, or two statements") from None
        return old, new


def copy_project(target: Path) -> None:
    """Copy the parts of the project that the tests need."""
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            ignored = shutil.ignore_patterns("__pycache__", "_build", "_generated", "node_modules")
            shutil.copytree(source, target / name, ignore=ignored)
        elif source.is_file():
            shutil.copy2(source, target / name)
    if (packages := ROOT / "web" / "node_modules").is_dir():
        (target / "web" / "node_modules").symlink_to(packages)


def build_page(root: Path) -> None:
    """Bundle the page's modules, one of which has a fault."""
    subprocess.run(["node", "build.js"], cwd=root / "web", check=True)


def _is_for_node(test: str) -> bool:
    return test.endswith(".test.js")


@functools.cache
def _found(test: str) -> str:
    """Return a test with its folder: "test_pairs.py::test_name" as "tests/joints/test_pairs.py::test_name"."""
    file, sign, name = test.partition("::")
    (path,) = (ROOT / "tests").rglob(file)
    return f"{path.relative_to(ROOT)}{sign}{name}"


def run_tests(root: Path, tests: Iterable[str], timeout: float) -> int:
    """Return PASSED, or the exit code of the failed run; a test that never ends has failed."""
    for_node: list[str] = []
    for_pytest: list[str] = []
    for test in tests:
        (for_node if _is_for_node(test) else for_pytest).append(test)
    commands = []
    if for_node:
        commands.append(["node", "web/build.js", "--node", "web/build/tests.mjs", *for_node])
        commands.append(["node", "--test", "web/build/tests.mjs"])
    if for_pytest:
        commands.append([sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider", *for_pytest])
    return next((code for command in commands if (code := _exit_code(root, command, timeout)) != PASSED), PASSED)


def _exit_code(root: Path, command: Sequence[str], timeout: float) -> int:
    # Bytecode is neither written nor read: it would hide a fault of the same length within the same second.
    environment = {**os.environ, "PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        return subprocess.run(command, cwd=root, env=environment, capture_output=True, timeout=timeout).returncode
    except subprocess.TimeoutExpired:
        return FAILED


def run(faults: Sequence[Fault], timeout: float) -> int:
    """Print a line for each fault; return 0 if all are killed."""
    with tempfile.TemporaryDirectory(prefix="mutate-") as folder:
        root = Path(folder)
        copy_project(root)
        sources = {fault.name: planted(fault, root) for fault in faults}
        for path in {root / fault.path for fault in faults if fault.path.endswith(".py")}:
            # As all faults are planted, so that the tests pass with a source without comments, too.
            path.write_text(ast.unparse(ast.parse(path.read_text(encoding="utf-8"))), encoding="utf-8")
        tests = list(dict.fromkeys(test for fault in faults for test in fault.arguments))
        if (code := run_tests(root, tests, timeout * len(faults))) != PASSED:
            print(f"the tests do not pass without a fault (exit code {code}): {' '.join(tests)}", file=sys.stderr)
            return 2
        killed = 0
        for fault in faults:
            path = root / fault.path
            original = path.read_text(encoding="utf-8")
            path.write_text(sources[fault.name], encoding="utf-8")
            if path.suffix == ".ts":
                build_page(root)
            code = run_tests(root, fault.arguments, timeout)
            path.write_text(original, encoding="utf-8")
            if path.suffix == ".ts":
                build_page(root)
            killed += code == FAILED
            print(f"{VERDICTS.get(code, f'no verdict (exit code {code})'):9} {fault.name}", flush=True)
    print(f"{killed} of {len(faults)} killed")
    return 0 if killed == len(faults) else 1


def main(arguments: list[str] | None = None) -> int:
    """Return 0 if every fault was detected, 1 if one survived, 2 if there is no verdict."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="print the names and end")
    parser.add_argument("--only", action="append", metavar="NAME", help="this fault; may be repeated")
    parser.add_argument("--timeout", type=float, default=300.0, help="seconds for the tests of one (default 300)")
    options = parser.parse_args(arguments)
    names = {fault.name: fault for fault in read_faults()}
    if unknown := set(options.only or ()) - names.keys():
        parser.error(f"no fault is called {', '.join(sorted(unknown))}; see --list")
    chosen = [names[name] for name in options.only] if options.only else list(names.values())
    if options.list:
        for fault in chosen:
            print(f"{fault.name}  ({fault.path})")
        return 0
    try:
        return run(chosen, options.timeout)
    except NotPlanted as error:
        print(error, file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
