"""Write the meshes of the URDFs, or check that the files match the shapes.

The shapes are drawn in scripts/nao_shapes and made for this library. Needs the packages of `pip install nao-kin[dev]`.
The same versions give the same bytes; another manifold3d may divide flat faces into other triangles.

Example:
    python scripts/generate_meshes.py            # writes urdf/meshes/*.obj
    python scripts/generate_meshes.py --check    # exit 1 and the names of the files that differ
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from nao_shapes import mesh_texts

from nao_kin._core.files import write_text
from nao_kin.export.meshes import MESH_FOLDER

MESHES = Path(__file__).resolve().parent.parent / "urdf" / MESH_FOLDER


def main(arguments: list[str] | None = None) -> int:
    """Write or check; return 1 if --check finds a difference, otherwise 0."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a file is out of date")
    parser.add_argument("--output", type=Path, default=MESHES, help="folder of the files (default: urdf/meshes)")
    options = parser.parse_args(arguments)

    texts = {options.output / f"{name}.obj": text for name, text in mesh_texts()}
    if options.check:
        present = set(options.output.glob("*.obj"))
        stale = {path for path, text in texts.items() if path not in present or path.read_bytes() != text.encode()}
        for path in sorted(stale | (present - texts.keys())):
            print(f"not in step with scripts/nao_shapes: {path} (run scripts/generate_meshes.py)", file=sys.stderr)
        return 1 if stale or present - texts.keys() else 0
    options.output.mkdir(parents=True, exist_ok=True)
    for path, text in texts.items():
        write_text(path, text)
    print(f"{options.output}: {len(texts)} meshes, {sum(map(len, texts.values())) / 1e6:.2f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
