"""Draw the picture of docs/imitation.md.

Example:
    python scripts/draw_imitation.py       # writes imitation.jpg into docs/images
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

import nao_kin as nk

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "images"
SIZE = (640, 560)
# Sample → the time that is drawn [s].
MOMENTS = {"wave": 1.45, "circles": 5.0}


def main() -> None:
    """Draw a NAO beside the person whom it imitates, in two samples."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=FOLDER, help="where (default: docs/images)")
    folder = parser.parse_args().folder
    nao, pictures = nk.load_nao(), []
    with nk.Viewer(nao) as viewer, tempfile.TemporaryDirectory() as temporary:
        for sample, time in MOMENTS.items():
            made = nk.imitation.imitate(nao, nk.imitation.read_skeleton(nk.imitation.SAMPLES[sample]))
            q = made.motion.configurations(nao, times=[time]).q
            viewer.animate(q, play=False, figure=made.figure([time]))
            picture = viewer.save_png(Path(temporary) / "picture.png", camera="front", size=SIZE, overwrite=True)
            pictures.append(np.asarray(Image.open(picture).convert("RGB")))
    Image.fromarray(np.concatenate(pictures, axis=1)).save(folder / "imitation.jpg", quality=85)


if __name__ == "__main__":
    main()
