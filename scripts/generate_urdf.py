"""Write the URDF of every NAO version from the parameters, or check that the files are up to date.

Example:
    python scripts/generate_urdf.py            # writes urdf/nao_v32.urdf … urdf/nao_v6.urdf
    python scripts/generate_urdf.py --check    # exit 1 and the names of the files that differ
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from nao_kin._core.files import write_text
from nao_kin.robot.nao import VERSIONS, nao_parameters
from nao_kin.robot.nao.urdf_text import urdf_name, urdf_text

URDF = Path(__file__).resolve().parent.parent / "urdf"


def main(arguments: list[str] | None = None) -> int:
    """Write or check; return 1 if --check finds a difference, otherwise 0."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; fail when a file is not in step")
    parser.add_argument("--output", type=Path, default=URDF, help="folder of the files (default: urdf/)")
    options = parser.parse_args(arguments)

    stale = []
    for version in VERSIONS:
        path = options.output / urdf_name(version)
        text = urdf_text(nao_parameters(version))
        if options.check:
            if not path.is_file() or path.read_text(encoding="utf-8") != text:
                stale.append(path)
        else:
            write_text(path, text)
            print(path)
    if options.check:
        expected = {urdf_name(version) for version in VERSIONS}
        stale += sorted(path for path in options.output.glob("*.urdf") if path.name not in expected)
    for path in stale:
        print(f"not in step with nao_kin.robot.nao: {path} (run scripts/generate_urdf.py)", file=sys.stderr)
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
