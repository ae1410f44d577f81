"""Plant small faults in a copy of the project, one by one, and check that the tests detect them.

First the tests run without a fault, because a test that fails anyway detects nothing. Then each fault of `mutations.py`
is planted, its tests run, and the source is restored. The checkout itself is never touched.

Example:
    python scripts/mutate.py --list
    python scripts/mutate.py --only rank-one-defective-a-million-times-too-easily
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from mutation import Mutation, is_for_node
from mutations import MUTATIONS

ROOT = Path(__file__).resolve().parent.parent
FILES = ("README.md", "CITATION.cff", "pyproject.toml", "Makefile")
COPIED = ("nao_kin", "urdf", "tests", "scripts", "examples", "docs", "web", *FILES)

# Exit codes of pytest and node; other codes, such as that for no collected tests, say nothing about
# the fault.
PASSED, FAILED = 0, 1
VERDICTS = {PASSED: "survived", FAILED: "killed"}


class NotPlanted(Exception):
    """The text of a mutation does not occur, or occurs more than once."""


def planted(mutation: Mutation, root: Path = ROOT) -> str:
    """Return the source with the fault in it.

    Raises:
        NotPlanted: the old text does not occur exactly once.
    """
    path = root / mutation.file
    if not path.is_file():
        raise NotPlanted(f"{mutation.name}: {mutation.file} is not there")
    source = path.read_text(encoding="utf-8")
    if (count := source.count(mutation.old)) != 1:
        raise NotPlanted(f"{mutation.name}: its text occurs {count} times in {mutation.file}, not once")
    return source.replace(mutation.old, mutation.new)


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


def run_tests(root: Path, tests: Iterable[str], timeout: float) -> int:
    """Return PASSED, or the exit code of the failed run; a test that never ends has failed."""
    for_node: list[str] = []
    for_pytest: list[str] = []
    for test in tests:
        (for_node if is_for_node(test) else for_pytest).append(test)
    commands = []
    if for_node:
        commands.append(["node", "web/build.js", "--node", "web/build", *for_node])
        commands.append(["node", "--test", *(f"web/build/{Path(test).stem}.mjs" for test in for_node)])
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


def run(mutations: Sequence[Mutation], timeout: float) -> int:
    """Print a line for each mutation; return 0 if all are killed."""
    with tempfile.TemporaryDirectory(prefix="mutate-") as folder:
        root = Path(folder)
        copy_project(root)
        sources = {mutation.name: planted(mutation, root) for mutation in mutations}
        tests = list(dict.fromkeys(test for mutation in mutations for test in mutation.tests))
        if (code := run_tests(root, tests, timeout * len(mutations))) != PASSED:
            print(f"the tests do not pass without a fault (exit code {code}): {' '.join(tests)}", file=sys.stderr)
            return 2
        killed = 0
        for mutation in mutations:
            path = root / mutation.file
            original = path.read_text(encoding="utf-8")
            path.write_text(sources[mutation.name], encoding="utf-8")
            if path.suffix == ".ts":
                build_page(root)
            code = run_tests(root, mutation.tests, timeout)
            path.write_text(original, encoding="utf-8")
            if path.suffix == ".ts":
                build_page(root)
            killed += code == FAILED
            print(f"{VERDICTS.get(code, f'no verdict (exit code {code})'):9} {mutation.name}", flush=True)
    print(f"{killed} of {len(mutations)} killed")
    return 0 if killed == len(mutations) else 1


def main(arguments: list[str] | None = None) -> int:
    """Return 0 if every fault was detected, 1 if one survived, 2 if there is no verdict."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="print the names and end")
    parser.add_argument("--only", action="append", metavar="NAME", help="this mutation; may be repeated")
    parser.add_argument("--timeout", type=float, default=300.0, help="seconds for the tests of one (default 300)")
    options = parser.parse_args(arguments)
    names = {mutation.name: mutation for mutation in MUTATIONS}
    if unknown := set(options.only or ()) - names.keys():
        parser.error(f"no mutation is called {', '.join(sorted(unknown))}; see --list")
    chosen = [names[name] for name in options.only] if options.only else list(MUTATIONS)
    if options.list:
        for mutation in chosen:
            print(f"{mutation.name}  ({mutation.file})")
        return 0
    try:
        return run(chosen, options.timeout)
    except NotPlanted as error:
        print(error, file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
