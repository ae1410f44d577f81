"""Draw the picture of lights in docs/viewer_python.md: a virtual NAO that greets.

Example:
    python scripts/draw_lights.py            # writes lights.jpg into docs/images
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from PIL import Image

import nao_kin as nk

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "images"
SIZE = (2400, 1900)
# The part of the picture to keep: left, top, right and bottom; and its final size.
PART = (720, 170, 1640, 990)
WIDTH = 720
# The right hand waves, and the head turns slightly towards it.
GREETING = {"RShoulderPitch": -0.9, "RShoulderRoll": -0.45, "RElbowRoll": 1.2, "RElbowYaw": 0.9, "RHand": 0.9}
GREETING |= {"HeadYaw": 0.25, "HeadPitch": -0.12}
RAINBOW = (0xFF0000, 0xFF8000, 0xFFE000, 0x00FF00, 0x00FFFF, 0x0040FF, 0x8000FF, 0xFF0090)


def main() -> None:
    """Draw the virtual NAO after the commands of a script."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=FOLDER, help="where (default: docs/images)")
    folder = parser.parse_args().folder
    with nk.naoqi.VirtualNao(stepped=True, posture="Stand") as robot, tempfile.TemporaryDirectory() as temporary:
        robot.call("ALMotion", "wakeUp")
        robot.call("ALMotion", "angleInterpolation", list(GREETING), list(GREETING.values()), 2.0, True)
        for number, colour in enumerate(RAINBOW):
            robot.call("ALLeds", "fadeRGB", f"FaceLed{number}", colour, 0.0)
        robot.call("ALLeds", "fadeRGB", "ChestLeds", "green", 0.0)
        state = robot.state()
        viewer = nk.Viewer(robot.robot)
        viewer.display(state.q)
        viewer.show_lights(nk.naoqi.light_colours(state.leds))
        picture = viewer.save_png(Path(temporary) / "picture.png", camera="three-quarter", size=SIZE, timeout=180.0)
        part = Image.open(picture).convert("RGB").crop(PART)
        height = round(WIDTH * part.height / part.width)
        part.resize((WIDTH, height), Image.Resampling.LANCZOS).save(folder / "lights.jpg", quality=86, optimize=True)
    print(folder / "lights.jpg")


if __name__ == "__main__":
    main()
