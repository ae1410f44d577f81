"""Load every export in its tool, and write the results: docs/tools.json, docs/tools.md.

Each tool is installed once, in an environment of its own below a cache folder, with pip.

Example:
    python scripts/measure_tools.py                  # measure all, and write
    python scripts/measure_tools.py --check          # measure all, and compare with docs/tools.json
    python scripts/measure_tools.py --tool pybullet  # measure one again, and write
    python scripts/measure_tools.py --page           # the page again, from docs/tools.json
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from tools_table.environments import default_cache
from tools_table.measure import faults, measure
from tools_table.page import page
from tools_table.record import differences, recorded
from tools_table.tools import TOOLS

DOCS = Path(__file__).resolve().parent.parent / "docs"
DATA, PAGE = DOCS / "tools.json", DOCS / "tools.md"


def main(arguments: list[str] | None = None) -> int:
    """Measure, and write or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    keys = [tool.key for tool in TOOLS]
    parser.add_argument("--tool", action="append", choices=keys, metavar="PACKAGE", help="default: all")
    parser.add_argument("--cache", type=Path, default=default_cache(), metavar="FOLDER", help="default: %(default)s")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true", help="compare with the written results; exit 1 if they differ")
    what.add_argument("--page", action="store_true", help="write the page only, and measure nothing")
    options = parser.parse_args(arguments)

    known: dict[str, Any] = json.loads(DATA.read_text(encoding="utf-8")) if DATA.is_file() else {}
    wrong = list[str]()
    for tool in () if options.page else TOOLS:
        if options.tool and tool.key not in options.tool:
            continue
        measured = measure(tool, options.cache)
        said = faults(tool, measured)
        new = recorded(measured)
        if options.check:
            said += differences(tool, known.get(tool.key), new)
        known[tool.key] = new
        wrong += said
        print(f"{tool.name} {measured['version']}:", "; ".join(said) or "right", flush=True)
    if not options.check:
        known = {tool.key: known[tool.key] for tool in TOOLS if tool.key in known}
        DATA.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
        PAGE.write_text(page(known), encoding="utf-8")
    for line in wrong:
        print(line, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
