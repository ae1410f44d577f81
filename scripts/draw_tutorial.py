"""Draw the pictures of docs/getting_started.md: a hand at a ball, and a wave with its earlier configurations.

Example:
    python scripts/draw_tutorial.py          # writes tutorial_reach.jpg and tutorial_wave.jpg into docs/images
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from PIL import Image

import nao_kin as nk

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "images"
SIZE = (1280, 1000)
# The part of a picture to keep: left, top, right and bottom.
PART = (390, 100, 1010, 880)
BALL = [0.17, 0.10, 0.08]


def main() -> None:
    """Draw both pictures with the results of the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=FOLDER, help="where (default: docs/images)")
    folder = parser.parse_args().folder
    nao = nk.load_nao("v6")
    looking = nao.posture("StandInit", HeadYaw=0.5, HeadPitch=-0.2)
    with nk.Viewer(nao) as viewer:
        viewer.display(nk.ik.arm(nao, "L", BALL, near=looking).q)
        viewer.show_targets({"ball": BALL})
        _save(viewer, folder / "tutorial_reach.jpg")
    wave = nk.Motion(
        [0.0, 0.4, 0.6, 0.8, 1.0, 1.4],
        ["LShoulderPitch", "LElbowRoll"],
        [[1.4, -1.0], [-1.0, -1.4], [-1.0, -0.4], [-1.0, -1.4], [-1.0, -0.4], [1.4, -1.0]],
        "smooth",
    )
    q = wave.configurations(nao, times=[0.0, 0.2, 0.4, 0.6]).q
    with nk.Viewer(nao) as viewer:
        viewer.display(q[-1])
        viewer.show_ghosts(q[:-1])
        _save(viewer, folder / "tutorial_wave.jpg")


def _save(viewer: nk.Viewer, target: Path) -> None:
    with tempfile.TemporaryDirectory() as temporary:
        picture = viewer.save_png(Path(temporary) / "picture.png", size=SIZE)
        Image.open(picture).convert("RGB").crop(PART).save(target, quality=85)
    print(target)


if __name__ == "__main__":
    main()
