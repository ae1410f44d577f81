"""Draw all pictures in docs/ that show the robot or its page again, after a change of either.

Needs a Chromium and playwright (`pip install nao-kin[dev-full]`), and some minutes.

Example:
    python scripts/draw_pictures.py            # view.jpg, viewer.jpg, and what the other scripts here draw
    python scripts/draw_pictures.py --pages    # view.jpg and viewer.jpg alone
"""

from __future__ import annotations

import argparse
import io
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

import nao_kin as nk
from nao_kin._core.process import find_browsers

HERE = Path(__file__).resolve().parent
IMAGES = HERE.parent / "docs" / "images"
# Size of the page in CSS pixels, and screen pixels for each.
WIDTH, HEIGHT, SCALE = 1280, 800, 1.5
OTHERS = (
    "draw_ghosts",
    "draw_imitation",
    "draw_lights",
    "draw_old_script",
    "draw_reach",
    "draw_whole_body",
    "walk_and_draw",
)
# Chromium draws without a graphics card; this long after the last change the picture is final [ms].
OPTIONS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
AT_REST = 3000


def stand(nao: nk.NaoModel) -> nk.Viewer:
    """Show the page in its initial state."""
    viewer = nk.Viewer(nao)
    viewer.display(nao.posture("Stand"))
    return viewer


def crouch(nao: nk.NaoModel) -> nk.Viewer:
    """Show a clip, halfway, with the joint axes."""
    viewer = nk.Viewer(nao)
    viewer.show_joint_axes()
    viewer.animate(np.linspace(nao.posture("Stand"), nao.posture("Crouch"), 121), 30.0, play=False)
    return viewer


PAGES = {"view": stand, "viewer": crouch}


def draw_pages() -> None:
    """Draw pictures of the whole page with its panel."""
    nao = nk.load_nao()
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as temporary:
        browser = playwright.chromium.launch(executable_path=str(find_browsers()[0]), args=OPTIONS)
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, device_scale_factor=SCALE)
        page.add_init_script("localStorage.setItem('nao-kin.hint', 'seen')")
        for name, make in PAGES.items():
            html = make(nao).save_html(Path(temporary) / f"{name}.html")
            page.goto(html.as_uri())
            page.wait_for_selector("body[data-ready]")
            if name == "viewer":
                page.get_by_label("Time").click()  # the middle of the slider
            page.mouse.move(0, 0)
            page.wait_for_timeout(AT_REST)
            picture = Image.open(io.BytesIO(page.screenshot(timeout=120_000))).convert("RGB")
            picture = picture.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)
            picture.save(IMAGES / f"{name}.jpg", quality=85, optimize=True)
            print(IMAGES / f"{name}.jpg")
        browser.close()


def main() -> None:
    """Draw the pages, and the pictures of the other scripts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pages", action="store_true", help="only the pictures of the page")
    options = parser.parse_args()
    draw_pages()
    for name in () if options.pages else OTHERS:
        subprocess.run([sys.executable, HERE / f"{name}.py"], check=True)


if __name__ == "__main__":
    main()
