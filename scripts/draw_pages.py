"""Draw the pictures in docs/images that show the robot in its viewer, or check them.

Needs a Chromium and playwright (`pip install nao-kin[dev-full]`).

Example:
    python scripts/draw_pages.py              # draws all
    python scripts/draw_pages.py ghosts view  # draws these
    python scripts/draw_pages.py --check      # exit 1 if a picture shows something else than what is drawn now
"""

from __future__ import annotations

import argparse
import io
import itertools
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import trimesh
from people_and_robots import TAKES
from PIL import Image
from walk_and_draw import last_pose

import nao_kin as nk
from nao_kin._core.process import find_browsers
from nao_kin.cli.naoqi import camera_pictures

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"
# Size of the page [CSS pixels].
WIDTH, HEIGHT = 1280, 800
# Largest mean difference of a checked picture, of 255 grey levels, at an eighth of its size.
DIFFERENCE = 1.0
# Chromium draws without a graphics card; this long after the last change the picture is final [ms].
OPTIONS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
AT_REST = 3000


def shot(viewer: nk.Viewer, size: tuple[int, int], camera: str | np.ndarray = "three-quarter") -> Image.Image:
    """Return a picture of the viewer's scene."""
    with tempfile.TemporaryDirectory() as folder:
        path = viewer.save_png(Path(folder) / "picture.png", camera=camera, size=size, timeout=180.0)
        return Image.open(path).convert("RGB")


def beside(pictures: list[Image.Image]) -> Image.Image:
    """Return pictures of one height beside each other."""
    return Image.fromarray(np.concatenate([np.asarray(picture) for picture in pictures], axis=1))


def page(viewer: nk.Viewer, at_half: bool = False) -> Image.Image:
    """Return a picture of the whole page with its panel."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        browser = playwright.chromium.launch(executable_path=str(find_browsers()[0]), args=OPTIONS)
        tab = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, device_scale_factor=1.5)
        tab.add_init_script("localStorage.setItem('nao-kin.hint', 'seen')")
        tab.goto(viewer.save_html(Path(folder) / "page.html").as_uri())
        tab.wait_for_selector("body[data-ready]")
        if at_half:
            tab.get_by_label("Time").click()  # the middle of the slider
        tab.mouse.move(0, 0)
        tab.wait_for_timeout(AT_REST)
        picture = Image.open(io.BytesIO(tab.screenshot(timeout=120_000))).convert("RGB")
        browser.close()
    return picture.resize((WIDTH, HEIGHT), Image.Resampling.LANCZOS)


def view() -> Image.Image:
    """Draw the page in its initial state."""
    nao = nk.load_nao()
    with nk.Viewer(nao) as viewer:
        viewer.display(nao.posture("Stand"))
        return page(viewer)


def clip() -> Image.Image:
    """Draw the page with a clip, halfway, and the joint axes."""
    nao = nk.load_nao()
    with nk.Viewer(nao) as viewer:
        viewer.show_joint_axes()
        viewer.animate(np.linspace(nao.posture("Stand"), nao.posture("Crouch"), 121), 30.0, play=False)
        return page(viewer, at_half=True)


def ghosts() -> Image.Image:
    """Draw all branches of the left leg, raised in front of the robot."""
    nao = nk.load_nao()
    raised = {"LHipRoll": 0.35, "LHipPitch": -1.0, "LKneePitch": 1.2, "LAnklePitch": -0.2}
    q = nao.configuration({**nao.angles(nao.posture("StandInit")), **raised})
    found = nk.ik.leg(nao, "L", nao.fk(q, "LLeg"), near=q, limits="ignore")
    with nk.Viewer(nao) as viewer:
        viewer.display(q)
        viewer.show_ghosts(found.solutions, opacity=0.4)
        return shot(viewer, (1280, 1000), "side").crop((260, 380, 1020, 900))


def imitation(name: str) -> Image.Image:
    """Draw a NAO beside the person whom it imitates."""
    nao, take = nk.load_nao(), TAKES[name]
    made, time = take.imitated(nao)
    with nk.Viewer(nao) as viewer:
        q = made.motion.configurations(nao, times=[time]).q
        viewer.animate(q, play=False, figure=made.figure([time]))
        return shot(viewer, (960, 760), take.view()).resize((480, 380), Image.Resampling.LANCZOS)


def lights() -> Image.Image:
    """Draw the virtual NAO after the commands of a script: the right hand waves, and the eyes have all colours."""
    greeting = {"RShoulderPitch": -0.9, "RShoulderRoll": -0.45, "RElbowRoll": 1.2, "RElbowYaw": 0.9, "RHand": 0.9}
    greeting |= {"HeadYaw": 0.25, "HeadPitch": -0.12}
    rainbow = (0xFF0000, 0xFF8000, 0xFFE000, 0x00FF00, 0x00FFFF, 0x0040FF, 0x8000FF, 0xFF0090)
    with nk.naoqi.VirtualNao(stepped=True, posture="Stand") as robot:
        robot.call("ALMotion", "wakeUp")
        robot.call("ALMotion", "angleInterpolation", list(greeting), list(greeting.values()), 2.0, True)
        for number, colour in enumerate(rainbow):
            robot.call("ALLeds", "fadeRGB", f"FaceLed{number}", colour, 0.0)
        robot.call("ALLeds", "fadeRGB", "ChestLeds", "green", 0.0)
        state = robot.state()
        with nk.Viewer(robot.robot) as viewer:
            viewer.display(state.q)
            viewer.show_lights(nk.naoqi.light_colours(state.leds))
            part = shot(viewer, (2400, 1900), "three-quarter").crop((720, 170, 2280, 990))
    return part.resize((960, round(960 * part.height / part.width)), Image.Resampling.LANCZOS)


def virtual_camera() -> Image.Image:
    """Draw what both cameras of the virtual NAO see while its right hand points at a ball."""
    viewer = nk.Viewer(nk.load_nao(base="floating"))
    ball, shape = [0.42, -0.06, 0.05], trimesh.creation.icosphere(4, 0.05)
    viewer.add_mesh("ball", shape.vertices + ball, shape.faces, color=[0.9, 0.05, 0.05])
    viewer.add_mesh("far", shape.vertices + np.array([1.5, 0.25, 0.05]), shape.faces, color=[0.95, 0.6, 0.0])
    drawn = camera_pictures(lambda: viewer)
    with viewer, nk.naoqi.VirtualNao(stepped=True, posture="Stand") as robot:
        robot.call("ALMotion", "wakeUp")
        robot.call("ALTracker", "pointAt", "RArm", ball, 2, 0.5)  # in FRAME_ROBOT
        robot.call("ALMotion", "angleInterpolation", ["HeadPitch", "RHand"], [0.25, 1.0], 1.0, True)
        return beside(
            [Image.fromarray(drawn(robot.state(), camera, (480, 360))) for camera in robot.robot.semantics.cameras]
        )


def old_script() -> Image.Image:
    """Draw a script for NAOqi on the virtual NAO, at five times after its first command [s]."""
    times = (0.0, 0.8, 1.2, 1.6, 2.4)
    virtual = nk.naoqi.VirtualNao(posture="StandInit", speed=0.5)
    with virtual, nk.naoqi.QiServer(virtual, port=0, quiet=True) as server:
        rows: list[tuple[float, np.ndarray]] = []
        ended = threading.Event()

        def watch() -> None:
            while not ended.wait(0.01):
                state = virtual.state()
                rows.append((state.time, state.q))

        watcher = threading.Thread(target=watch)
        watcher.start()
        environment = {**os.environ, "NAO_KIN_ENDPOINT": server.endpoint}
        script = ROOT / "examples" / "naoqi" / "timeline.py"
        subprocess.run([sys.executable, str(nk.naoqi.compat.FOLDER), str(script)], env=environment, check=True)
        ended.set()
        watcher.join()
    begin = next(time for (time, q), (_, later) in itertools.pairwise(rows) if not np.array_equal(q, later))
    logged = np.array([time for time, _ in rows])
    pictures = []
    with nk.Viewer(nk.load_nao()) as viewer:
        for time in times:
            viewer.display(rows[int(np.argmin(np.abs(logged - begin - time)))][1])
            part = shot(viewer, (1100, 900), "front").crop((220, 0, 880, 900))
            pictures.append(part.resize((330, 450), Image.Resampling.LANCZOS))
    return beside(pictures)


def _reach(by: str, cut: tuple[str, float]) -> Image.Image:
    nao = nk.load_nao()
    reach = nk.reach.workspace(nao, "LArm", 10_000_000)
    with nk.Viewer(nao) as viewer:
        viewer.display(nao.posture("StandInit"))
        viewer.show_reach(reach, by=by, cut=cut)
        return shot(viewer, (1120, 760))


def tutorial_reach() -> Image.Image:
    """Draw an arm that reaches a ball, as the tutorial computes it."""
    nao, ball = nk.load_nao("v6"), [0.17, 0.10, 0.08]
    with nk.Viewer(nao) as viewer:
        viewer.display(nk.ik.arm(nao, "L", ball, near=nao.posture("StandInit", HeadYaw=0.5, HeadPitch=-0.2)).q)
        viewer.show_targets({"ball": ball})
        return shot(viewer, (1280, 1000)).crop((390, 100, 1010, 880))


def tutorial_wave() -> Image.Image:
    """Draw the wave of the tutorial at four times."""
    nao = nk.load_nao("v6")
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
        return shot(viewer, (1280, 1000)).crop((390, 100, 1010, 880))


def whole_body() -> Image.Image:
    """Draw a crouch with both hands forward, and a stand on the left foot with the hand and the gaze to the side."""
    nao = nk.load_nao(base="floating")
    left, right = nao.fk(nao.posture("StandInit"), ["LLeg", "RLeg"])
    feet = {"L": np.eye(4), "R": np.linalg.inv(left) @ right}
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
    with nk.Viewer(nao) as viewer:
        for found in (crouch, lean):
            viewer.display(found.q)
            pictures.append(shot(viewer, (560, 640)))
    return beside(pictures)


def walk_and_draw() -> Image.Image:
    """Draw a NAO on its left leg that draws a figure eight in the air."""
    with last_pose() as viewer:
        return shot(viewer, (1120, 760))


PICTURES: dict[str, Callable[[], Image.Image]] = {
    "view": view,
    "viewer": clip,
    "ghosts": ghosts,
    **{f"imitation_{name}": partial(imitation, name) for name in TAKES},
    "lights": lights,
    "virtual_camera": virtual_camera,
    "old_script": old_script,
    "reach_manipulability": lambda: _reach("best", ("x", 0.0)),
    "reach_coverage": lambda: _reach("coverage", ("z", 0.1)),
    "tutorial_reach": tutorial_reach,
    "tutorial_wave": tutorial_wave,
    "whole_body": whole_body,
    "walk_and_draw": walk_and_draw,
}


def differs(drawn: Image.Image, path: Path) -> bool:
    """Return whether a picture shows something else than the file, beyond what compression and software change."""
    if not path.is_file():
        return True
    kept = Image.open(path).convert("RGB")
    if kept.size != drawn.size:
        return True
    small = (drawn.width // 8, drawn.height // 8)
    a, b = (np.asarray(one.resize(small, Image.Resampling.BOX), dtype=float) for one in (drawn, kept))
    return bool(np.abs(a - b).mean() > DIFFERENCE)


def main() -> int:
    """Draw or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(PICTURES)} (default: all)")
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a picture differs")
    options = parser.parse_args()
    differing = []
    for name in options.names or PICTURES:
        picture, path = PICTURES[name](), IMAGES / f"{name}.jpg"
        if not options.check:
            picture.save(path, quality=85, optimize=True)
            print(path)
        elif differs(picture, path):
            differing.append(path.name)
    if differing:
        print(f"differ from what is drawn now: {', '.join(differing)}", file=sys.stderr)
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
