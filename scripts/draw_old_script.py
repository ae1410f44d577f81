"""Draw a virtual NAO while an old script runs: pictures side by side.

Example:
    python scripts/draw_old_script.py            # writes docs/images/old_script.jpg
"""

from __future__ import annotations

import argparse
import itertools
import os
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import numpy as np
from PIL import Image

import nao_kin as nk
from nao_kin.naoqi import QiServer, VirtualNao
from nao_kin.naoqi.compat import FOLDER

ROOT = Path(__file__).resolve().parent.parent
SCRIPT = ROOT / "examples" / "naoqi" / "timeline.py"
OUTPUT = ROOT / "docs" / "images" / "old_script.jpg"
# Robot times of the pictures, after the script's first command [s].
TIMES = (0.0, 0.8, 1.2, 1.6, 2.4)
# The middle of each picture is kept, and scaled down.
PART, SIZE = (660, 900), (330, 450)


def configurations() -> list[np.ndarray]:
    """Return the configurations at `TIMES` of a run of the script."""
    with VirtualNao(posture="StandInit", speed=0.5) as virtual, QiServer(virtual, port=0, quiet=True) as server:
        rows: list[tuple[float, np.ndarray]] = []
        ended = threading.Event()

        def watch() -> None:
            while not ended.wait(0.01):
                state = virtual.state()
                rows.append((state.time, state.q))

        watcher = threading.Thread(target=watch)
        watcher.start()
        environment = {**os.environ, "NAO_KIN_ENDPOINT": server.endpoint}
        subprocess.run([sys.executable, str(FOLDER), str(SCRIPT)], env=environment, check=True)
        ended.set()
        watcher.join()
    begin = next(time for (time, q), (_, later) in itertools.pairwise(rows) if not np.array_equal(q, later))
    times = np.array([time for time, _ in rows])
    return [rows[int(np.argmin(np.abs(times - begin - wanted)))][1] for wanted in TIMES]


def main() -> None:
    """Draw the pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=OUTPUT)
    arguments = parser.parse_args()
    width, height = SIZE
    strip = Image.new("RGB", (width * len(TIMES), height), "white")
    viewer = nk.Viewer(nk.load_nao())
    with tempfile.TemporaryDirectory() as folder:
        for place, q in enumerate(configurations()):
            viewer.display(q)
            file = Path(folder) / f"{place}.png"
            viewer.save_png(file, camera="front", size=(1100, 900))
            picture = Image.open(file).convert("RGB")
            left, top = (picture.width - PART[0]) // 2, (picture.height - PART[1]) // 2
            part = picture.crop((left, top, left + PART[0], top + PART[1]))
            strip.paste(part.resize(SIZE, Image.Resampling.LANCZOS), (place * width, 0))
    strip.save(arguments.output, quality=85)
    print(arguments.output)


if __name__ == "__main__":
    main()
