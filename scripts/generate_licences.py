"""Write the table in docs/licences.md: the licences of what an installation brings, by the metadata of its packages.

Run it where nao-kin[all] is installed: a package that is absent has no row.
"""

from __future__ import annotations

import argparse
import re
from collections import defaultdict
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PAGE = Path(__file__).resolve().parents[1] / "docs" / "licences.md"
HEAD = "| comes with | licence | packages |\n|---|---|---|\n"
# What metadata call a licence → its SPDX name; for packages whose metadata name none, what their licence file says.
_NAMES = {
    "MIT License": "MIT",
    "BSD License": "BSD",
    "Apache Software License": "Apache-2.0",
    "Apache 2.0": "Apache-2.0",
    "ISC License (ISCL)": "ISC",
    "BSD 3-Clause License": "BSD-3-Clause",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "Python Software Foundation License": "PSF-2.0",
}
_BY_FILE = {
    "cmeel-qhull": "Qhull",
    "embreex": "BSD-2-Clause",
    "pyglet": "BSD-3-Clause",
    "vhacdx": "MIT",
    "xacro": "BSD",
}
# Licences that reach beyond their own files, such as GPL, LGPL, MPL and EPL.
COPYLEFT = re.compile(r"GPL|MPL|EPL|GNU|Mozilla")


def licence(package: str) -> str:
    """Return the licence of an installed package: its SPDX expression, or else its classifiers or its text."""
    about = metadata.metadata(package)
    classified = [text.rpartition(" :: ")[2] for text in about.get_all("Classifier") or () if text[:7] == "License"]
    named = ", ".join(name for name in classified if name != "OSI Approved")
    own = {key: about[key] for key in ("License-Expression", "License") if key in about}
    text = own.get("License-Expression") or named or own.get("License", "").partition("\n")[0]
    return _BY_FILE.get(package) or _NAMES.get(text, text) or "not stated"


def required(extra: str = "") -> set[str]:
    """Return the installed packages that nao-kin requires, with an extra, and those that these require."""
    done, left = set[tuple[str, str]](), [("nao-kin", extra)]
    while left:
        package, extra = left.pop()
        if (package, extra) in done:
            continue
        try:
            rows = map(Requirement, metadata.requires(package) or ())
        except metadata.PackageNotFoundError:
            continue
        done.add((package, extra))
        for row in rows:
            if row.marker is None or row.marker.evaluate({"extra": extra}):
                left += [(canonicalize_name(row.name), one) for one in ("", *row.extras)]
    return {package for package, _ in done} - {"nao-kin"}


def table() -> str:
    """Return the rows: for the default installation and each extra, the packages of each licence."""
    own = metadata.metadata("nao-kin").get_all("Provides-Extra") or ()
    extras = [extra for extra in own if not re.match("all|dev|docs|test", extra)]
    lines, core = list[str](), required()
    for title, packages in [("the default installation", core), *((f"`{e}`", required(e) - core) for e in extras)]:
        by_licence = defaultdict[str, list[str]](list)
        for package in sorted(packages):
            by_licence[licence(package)].append(package)
        lines += [f"| {title} | {name} | {', '.join(found)} |" for name, found in sorted(by_licence.items())]
    return HEAD + "\n".join(lines) + "\n"


def main() -> None:
    """Replace the table in the page."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    before, _, after = PAGE.read_text(encoding="utf-8").partition(HEAD)
    PAGE.write_text(before + table() + re.sub(r"\A(\|.*\n)*", "", after), encoding="utf-8")


if __name__ == "__main__":
    main()
