"""Load an export in a tool, and print the results as one line of JSON.

Example:
    python -m tools_table.probes mujoco FOLDER
"""

from __future__ import annotations

import importlib
import json
import sys
import traceback
from pathlib import Path

from tools_table.probes.loaded import examine


def main() -> int:
    """Measure one tool with one folder that contains an export and its `reference.json`."""
    module, folder = sys.argv[1], Path(sys.argv[2])
    reference = json.loads((folder / "reference.json").read_text(encoding="utf-8"))
    try:
        probe = importlib.import_module(f"tools_table.probes.{module}")
        row = examine(probe.load(folder / reference["path"]), reference)
    except Exception as error:
        traceback.print_exc()
        row = {"loads": f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}"}
    print("\n" + json.dumps(row))
    return 0


if __name__ == "__main__":
    sys.exit(main())
