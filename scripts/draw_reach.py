"""Draw the pictures of docs/reachability.md.

Example:
    python scripts/draw_reach.py            # writes reach_manipulability.jpg and reach_coverage.jpg into docs/images
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from PIL import Image

import nao_kin as nk

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "images"
SIZE = (1120, 760)
PICTURES = {"manipulability": ("best", ("x", 0.0)), "coverage": ("coverage", ("z", 0.1))}


def main() -> None:
    """Draw both pictures of the left arm."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=FOLDER, help="where (default: docs/images)")
    folder = parser.parse_args().folder
    nao = nk.load_nao()
    reach = nk.reach.workspace(nao, "LArm", 10_000_000)
    with nk.Viewer(nao) as viewer, tempfile.TemporaryDirectory() as temporary:
        viewer.display(nao.posture("StandInit"))
        for name, (by, cut) in PICTURES.items():
            viewer.show_reach(reach, by=by, cut=cut)
            picture = viewer.save_png(Path(temporary) / "picture.png", size=SIZE, overwrite=True)
            Image.open(picture).convert("RGB").save(folder / f"reach_{name}.jpg", quality=85)
            print(folder / f"reach_{name}.jpg")


if __name__ == "__main__":
    main()
