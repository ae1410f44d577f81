"""Draw the picture of docs/whole_body.md.

Example:
    python scripts/draw_whole_body.py       # writes whole_body.jpg into docs/images
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import nao_kin as nk

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "images"
SIZE = (560, 640)


def main() -> None:
    """Draw a crouch with both hands forward, and a stand on the left foot with the hand and the gaze to the side."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=FOLDER, help="where (default: docs/images)")
    folder = parser.parse_args().folder
    nao = nk.load_nao(base="floating")
    q = nao.posture("StandInit")
    left, right = nao.fk(q, ["LLeg", "RLeg"])
    level = np.linalg.inv(left)
    feet = {"L": np.eye(4), "R": level @ right}
    crouch = nk.ik.whole_body(
        nao,
        {"LArm": [0.16, 0.02, 0.20], "RArm": [0.16, -0.12, 0.20]},
        feet=feet,
        torso=[0.01, -0.05, 0.25],
        com="support",
        margin=0.02,
        gaze=[0.4, -0.05, 0.0],
    )
    lifted = feet["R"].copy()
    lifted[:3, 3] += [-0.04, -0.05, 0.06]
    point = [0.15, 0.20, 0.42]
    lean = nk.ik.whole_body(
        nao, {"LArm": point, "RLeg": lifted}, feet={"L": np.eye(4)}, com="support", margin=0.01, gaze=point
    )
    pictures = []
    with nk.Viewer(nao) as viewer, tempfile.TemporaryDirectory() as temporary:
        for found in (crouch, lean):
            print(found)
            viewer.display(found.q)
            picture = viewer.save_png(Path(temporary) / "picture.png", size=SIZE, overwrite=True)
            pictures.append(np.asarray(Image.open(picture).convert("RGB")))
    Image.fromarray(np.concatenate(pictures, axis=1)).save(folder / "whole_body.jpg", quality=85)


if __name__ == "__main__":
    main()
