"""Draw the picture of ghosts in docs/viewer_python.md: all branches of a leg for one pose of its foot.

Example:
    python scripts/draw_ghosts.py            # writes ghosts.jpg into docs/images
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from PIL import Image

import nao_kin as nk

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "images"
SIZE = (1280, 1000)
# The part of the picture to keep: left, top, right and bottom.
PART = (260, 380, 1020, 900)
RAISED = {"LHipRoll": 0.35, "LHipPitch": -1.0, "LKneePitch": 1.2, "LAnklePitch": -0.2}


def main() -> None:
    """Draw the left leg raised in front of the robot."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=FOLDER, help="where (default: docs/images)")
    folder = parser.parse_args().folder
    nao = nk.load_nao()
    q = nao.configuration({**nao.angles(nao.posture("StandInit")), **RAISED})
    found = nk.ik.leg(nao, "L", nao.fk(q, "LLeg"), near=q, limits="ignore")
    with nk.Viewer(nao) as viewer, tempfile.TemporaryDirectory() as temporary:
        viewer.display(q)
        viewer.show_ghosts(found.solutions, opacity=0.4)
        picture = viewer.save_png(Path(temporary) / "picture.png", camera="side", size=SIZE)
        Image.open(picture).convert("RGB").crop(PART).save(folder / "ghosts.jpg", quality=85)
    print(folder / "ghosts.jpg")


if __name__ == "__main__":
    main()
