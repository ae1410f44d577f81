"""Measure the cost of an installation: megabytes by package, and seconds to install, to import and to load a NAO.

Builds the wheel, installs it into fresh environments below the temporary directory, and prints Markdown tables. The
packages come from pip's configured registry, once without pip's cache and once from it.

Example:
    python scripts/measure_install.py                             # the default installation
    python scripts/measure_install.py --extra batch --extra robots  # and what each of these adds to it
    python scripts/measure_install.py --wheel dist/nao_kin-0.3.0-py3-none-any.whl
"""

from __future__ import annotations

import argparse
import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PROGRAMS = {
    "import nao_kin": "import nao_kin",
    "load_nao()": "import nao_kin as nk; nk.load_nao()",
    "one pose": "import nao_kin as nk; nao = nk.load_nao(); nao.fk(nao.neutral(), 'LArm')",
    "one inverse": "import nao_kin as nk; n = nk.load_nao(); nk.ik.arm(n, 'L', n.fk(n.posture('Stand'), 'LArm'))",
}
RUNS = 7
SHOWN_BYTES = 3e6

# Runs in the measured environment: bytes of each distribution, .pyc separately, and its requirements.
LIST = """
import importlib.metadata, json, os, re
sizes, asked = {}, {}
for found in importlib.metadata.distributions():
    plain = compiled = 0
    for file in found.files or ():
        path = str(found.locate_file(file))
        if os.path.isfile(path) and not os.path.islink(path):
            if path.endswith(".pyc"):
                compiled += os.path.getsize(path)
            else:
                plain += os.path.getsize(path)
    name = re.sub(r"[-_.]+", "-", found.name).lower()
    sizes[name] = plain, compiled
    asked[name] = found.requires or []
print(json.dumps([sizes, asked]))
"""

Sizes = dict[str, tuple[int, int]]


def build(folder: Path) -> Path:
    """Build the wheel of this checkout."""
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return next(folder.glob("*.whl"))


def environment(folder: Path) -> Path:
    """Create a fresh environment, and return its Python."""
    venv.create(folder, with_pip=True)
    return folder / "bin" / "python"


def install(python: Path, wheel: Path, extras: tuple[str, ...], *options: str) -> str:
    """Install the wheel; return the elapsed time and the processor time, which other processes do not affect."""
    started, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    target = f"{wheel}[{','.join(extras)}]" if extras else str(wheel)
    subprocess.run([python, "-m", "pip", "install", "--quiet", *options, target], check=True, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    busy = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return f"{time.perf_counter() - started:.0f} s ({busy:.0f} s of processor)"


def listed(python: Path) -> tuple[Sizes, dict[str, list[str]]]:
    """Return bytes and requirements of every distribution, except those of an empty environment."""
    out = subprocess.run([python, "-c", LIST], check=True, capture_output=True, text=True).stdout
    sizes, asked = json.loads(out)
    return {name: tuple(size) for name, size in sizes.items() if name not in ("pip", "setuptools")}, asked


def brought(root: str, asked: dict[str, list[str]], without: str = "") -> set[str]:
    """Return a distribution and all that it requires, without the distribution `without` and its requirements."""
    from packaging.requirements import Requirement
    from packaging.utils import canonicalize_name

    found: set[tuple[str, frozenset[str]]] = set()
    waiting = [(root, frozenset[str]())]
    while waiting:
        name, extras = waiting.pop()
        if (name, extras) in found or name == without or name not in asked:
            continue
        found.add((name, extras))
        for requirement in map(Requirement, asked[name]):
            marker = requirement.marker
            if marker is None or any(marker.evaluate({"extra": extra}) for extra in ("", *extras)):
                waiting.append((str(canonicalize_name(requirement.name)), frozenset(requirement.extras)))
    return {name for name, _ in found}


def seconds(python: Path, program: str) -> float:
    """Return the median time of a program in a fresh process, including the start of Python."""
    times = []
    for _ in range(RUNS):
        started = time.perf_counter()
        subprocess.run([python, "-c", program], check=True, cwd=tempfile.gettempdir())
        times.append(time.perf_counter() - started)
    return statistics.median(times)


def megabytes(sizes: Sizes, part: int = 0) -> float:
    """Return the sum over distributions: without compiled files, or only those with part=1."""
    return sum(size[part] for size in sizes.values()) / 1e6


def print_table(head: tuple[str, ...], rows: list[tuple[Any, ...]]) -> None:
    """Print a Markdown table; numbers with one digit."""
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(f"{cell:.1f}" if isinstance(cell, float) else str(cell) for cell in row) + " |")
    print()


def measure_default(wheel: Path, folder: Path) -> Sizes:
    """Print the tables of the default installation; return its sizes."""
    cache = ("--cache-dir", str(folder / "cache"))
    cold = install(environment(folder / "cold"), wheel, (), "--no-cache-dir")
    install(environment(folder / "filling"), wheel, (), *cache)
    python = environment(folder / "warm")
    warm = install(python, wheel, (), *cache)
    sizes, asked = listed(python)
    print(f"## Default: {len(sizes)} packages, {megabytes(sizes):.0f} MB, and {megabytes(sizes, 1):.0f} MB of .pyc\n")
    print(f"Installed in {cold} without pip's cache, in {warm} from it.\n")
    nothing: dict[str, list[str]] = {name: [] for name in asked}
    direct, every = brought("nao-kin", nothing | {"nao-kin": asked["nao-kin"]}), brought("nao-kin", asked)
    rows = []
    for name in direct - {"nao-kin"}:
        alone = every - brought("nao-kin", asked, without=name)
        biggest = sorted(alone, key=lambda part: -sizes[part][0])
        large = ", ".join(f"{part} {sizes[part][0] / 1e6:.0f}" for part in biggest if sizes[part][0] > SHOWN_BYTES)
        rows.append((name, len(alone), megabytes({part: sizes[part] for part in alone}), large))
    rows.sort(key=lambda row: -row[2])
    print_table(("asked for", "packages that come with it alone", "MB", "of which, MB"), rows)
    print_table(
        ("in a fresh process", "s"), [(name, f"{seconds(python, code):.2f}") for name, code in PROGRAMS.items()]
    )
    return sizes


def main(arguments: list[str] | None = None) -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--extra", action="append", default=[], metavar="NAME", help="also measure what this extra adds"
    )
    parser.add_argument("--wheel", type=Path, metavar="FILE", help="use this wheel instead of building one")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix="nao_kin_install_") as name:
        folder = Path(name)
        wheel = options.wheel.resolve() if options.wheel else build(folder)
        default = measure_default(wheel, folder)
        rows = []
        for extra in options.extra:
            python = environment(folder / extra)
            took = install(python, wheel, (extra,), "--cache-dir", str(folder / "cache"))
            sizes = {part: size for part, size in listed(python)[0].items() if part not in default}
            rows.append((extra, len(sizes), megabytes(sizes), took, ", ".join(sorted(sizes))))
        if rows:
            print_table(("extra", "packages", "MB more", "installed in", "which"), rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
