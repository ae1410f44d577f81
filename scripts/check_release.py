"""Check that a tag is that of a release: the version of the package, named in the changelog and in CITATION.cff.

Example:
    python scripts/check_release.py v0.4.0
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def problems(tag: str, root: Path = ROOT) -> list[str]:
    """Return what is wrong with a tag, one sentence each."""
    source = (root / "nao_kin" / "_core" / "__init__.py").read_text(encoding="utf-8")
    version = re.search(r'^__version__ = "(.+)"$', source, re.M)
    own = version.group(1) if version else "none"
    found = []
    if tag != f"v{own}":
        found.append(f"the tag is {tag}, the version of the package is {own}")
    if not re.fullmatch(r"v\d+\.\d+\.\d+", tag):
        found.append(f"{tag} is no release: v, and three numbers")
    changelog = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    dated = re.search(rf"^## \[{re.escape(tag[1:])}\] - (\d{{4}}-\d\d-\d\d)$", changelog, re.M)
    if dated is None:
        found.append(f"CHANGELOG.md has no section ## [{tag[1:]}] with a date")
    citation = (root / "CITATION.cff").read_text(encoding="utf-8")
    if f"\nversion: {tag[1:]}\n" not in citation:
        found.append(f"CITATION.cff is not of version {tag[1:]}")
    elif dated is not None and f"\ndate-released: {dated.group(1)}\n" not in citation:
        found.append(f"CITATION.cff is not of {dated.group(1)}, the date in CHANGELOG.md")
    return found


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] in ("-h", "--help"):
        print(__doc__)
        sys.exit(0 if len(sys.argv) == 2 else 2)
    wrong = problems(sys.argv[1])
    print("\n".join(wrong) or f"{sys.argv[1]} can be released")
    sys.exit(bool(wrong))
