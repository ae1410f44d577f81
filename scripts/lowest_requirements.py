"""Print the lowest versions of the direct dependencies that pyproject.toml allows, as constraints for pip.

Example:
    python scripts/lowest_requirements.py > constraints.txt
    pip install --constraint constraints.txt --editable ".[test-full]"
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement
from packaging.version import Version

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PYPROJECT = Path(__file__).resolve().parent.parent / "pyproject.toml"
EXTRAS = ("test-full",)


def requirements(project: dict[str, Any], extras: Iterable[str]) -> Iterator[Requirement]:
    """Return the direct dependencies that apply to this Python, including those of extras that an extra requires."""
    waiting, seen = list(extras), set[str]()
    found = [Requirement(line) for line in project["dependencies"]]
    while waiting:
        extra = waiting.pop()
        if extra not in seen:
            seen.add(extra)
            found += map(Requirement, project["optional-dependencies"][extra])
            waiting += [name for other in found if other.name == project["name"] for name in other.extras]
    for requirement in found:
        if requirement.name != project["name"] and (requirement.marker is None or requirement.marker.evaluate()):
            yield requirement


def lowest(requirement: Requirement) -> Version:
    """Return the version after `>=` or `==`.

    Raises:
        ValueError: the requirement has no lower bound, so the tested version would be unknown.
    """
    bounds = [Version(part.version) for part in requirement.specifier if part.operator in (">=", "==")]
    if not bounds:
        raise ValueError(f"{requirement}: a lower bound is missing")
    return max(bounds)


def constraints(project: dict[str, Any], extras: Iterable[str] = EXTRAS) -> list[str]:
    """Return one line `name==version` per dependency, with the highest of several bounds."""
    versions: dict[str, Version] = {}
    for requirement in requirements(project, extras):
        versions[requirement.name] = max(lowest(requirement), versions.get(requirement.name, Version("0")))
    return [f"{name}=={version}" for name, version in sorted(versions.items())]


def main(arguments: list[str] | None = None) -> int:
    """Print the constraints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--extra", action="append", dest="extras", metavar="NAME", help="default: " + " and ".join(EXTRAS)
    )
    extras = parser.parse_args(arguments).extras or EXTRAS
    print("\n".join(constraints(tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["project"], extras)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
