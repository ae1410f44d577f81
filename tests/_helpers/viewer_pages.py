"""Pages of the viewer in a headless Chromium, watched for errors and for requests to other servers."""

from __future__ import annotations

import base64
import io
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import umsgpack
from PIL import Image

import nao_kin as nk
from nao_kin.errors import NoBrowser
from nao_kin.viewer.browser import find_browser

OPTIONS = (
    "--no-sandbox --disable-gpu --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --disable-quic "
    "--disable-background-networking --disable-component-update --disable-sync --no-first-run --disable-dev-shm-usage "
    # A list replaces Playwright's own, which is therefore repeated here. The first three start two renderers for the
    # address bar of each new page, which take as long as the page itself.
    "--disable-features=WebUIOmniboxPopup,WebUIOmniboxAimPopup,WebUIOmniboxFullPopup,"
    "AimEnabled,AvoidCorsURLLoaderRestartOnRedirect,AvoidUnnecessaryBeforeUnloadCheckSync,DestroyProfileOnBrowserClose,"
    "HttpsFirstBalancedModeAutoEnable,HttpsUpgrades,LensOverlay,MediaRouter,NetworkTimeServiceQuerying,OptimizationHints,"
    "PaintHolding,PreconnectToSearch,TcpPortRandomizationWin,ThirdPartyStoragePartitioning"
).split()

# Without a graphics card, drawing takes most of the time of a test; everything else works without drawing.
_DRAW_NOTHING = """
    const drawing = /^(drawArrays|drawElements|blitFramebuffer|clear$)/;
    for (const { prototype } of [WebGLRenderingContext, WebGL2RenderingContext]) {
        for (const name of Object.keys(prototype).filter((key) => drawing.test(key))) {
            const own = prototype[name];
            prototype[name] = function (...values) { if (window.draws) own.apply(this, values); };
        }
    }
"""


@contextmanager
def chromium() -> Iterator[Any]:
    """Open a browser and close it at the end; the test is skipped if no browser is installed."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    try:
        program = find_browser()
    except NoBrowser as error:
        pytest.skip(f"no browser to test the viewer in: {error}")
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=str(program), args=OPTIONS)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def visitor(browser: Any, **options: Any) -> Iterator[Any]:
    """Open a browser context with its own storage, whose pages draw nothing into their canvas."""
    context = browser.new_context(**options)
    context.add_init_script(_DRAW_NOTHING)
    try:
        yield context
    finally:
        context.close()


class Page:
    """An open page, with the errors and requests that it made while it was open.

    Unless `draws` is set it draws nothing into its canvas; everything else works as if it did.
    """

    def __init__(self, browser: Any, url: str, size: tuple[int, int] = (760, 420), *, draws: bool = False) -> None:
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.tab = browser.new_page(viewport={"width": size[0], "height": size[1]})
        self.tab.on("console", lambda line: self.errors.append(line.text) if line.type == "error" else None)
        self.tab.on("pageerror", lambda error: self.errors.append(str(error)))
        self.tab.on("request", lambda request: self.requests.append(request.url))
        self.tab.add_init_script(_DRAW_NOTHING)
        if draws:
            self.tab.add_init_script("window.draws = true;")
        self.tab.goto(url)
        self.tab.wait_for_selector("body[data-ready]", timeout=30_000)

    def run(self, expression: str, argument: Any = None) -> Any:
        return self.tab.evaluate(expression, argument)

    @property
    def q(self) -> np.ndarray:
        return np.array(self.run("() => (naoKin.settle(), [...naoKin.q])"))

    def poses(self, names: tuple[str, ...]) -> np.ndarray:
        """Poses of frames in the robot's root, read back from the matrices of the scene, shape (n, 4, 4)."""
        return np.array(self.run("(names) => names.map((name) => naoKin.pose(name))", list(names))).reshape(-1, 4, 4)

    def set(self, q: np.ndarray) -> None:
        self.run("(q) => { naoKin.set(q); naoKin.settle(); }", q.tolist())

    def slider(self, joint: str) -> Any:
        return self.tab.locator(f'.joint[data-joint="{joint}"] input[type="range"]')

    def slide(self, joint: str, value: float) -> None:
        """Move a slider as a user does: set its value and send the input event."""
        self.slider(joint).evaluate(
            "(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input', {bubbles: true})); }",
            value,
        )

    def type_number(self, joint: str, text: str) -> Any:
        """Click into a joint's number, type a new one and press Enter; return the field."""
        field = self.tab.locator(f'.joint[data-joint="{joint}"] input[type="text"]')
        field.click()
        self.tab.keyboard.press("ControlOrMeta+A")
        self.tab.keyboard.press("Delete")
        self.tab.keyboard.type(text)
        self.tab.keyboard.press("Enter")
        return field

    def switch(self, name: str) -> bool:
        """Press a button of the menu View, opening and closing the menu; return whether the button is on."""
        menu, button = (
            self.tab.locator(".view-menu > summary"),
            self.tab.get_by_role("button", name=name, exact=True),
        )
        menu.click()
        button.click()
        on = button.get_attribute("aria-pressed") == "true"
        menu.click()
        return on

    def animation_frames(self, count: int) -> None:
        """Wait for a number of steps of the page's animation loop."""
        self.run(
            """(count) => new Promise((resolve) => {
                const step = (left) => (left > 0 ? requestAnimationFrame(() => step(left - 1)) : resolve());
                step(count);
            })""",
            count,
        )

    def draw(self, on: bool) -> None:
        """Switch drawing on or off."""
        self.run("(on) => { window.draws = on; naoKin.viewer.set_dirty(); }", on)

    def picture(self) -> np.ndarray:
        return read_png(self.tab.locator("#pane").screenshot())

    def close(self) -> None:
        self.tab.close()


@contextmanager
def opened(
    browser: Any, where: Path | str, size: tuple[int, int] = (760, 420), *, draws: bool = False
) -> Iterator[Page]:
    """Open a page that must report no error and send no request to another server."""
    page = Page(browser, where.as_uri() if isinstance(where, Path) else where, size, draws=draws)
    try:
        yield page
        assert page.errors == []
    finally:
        page.close()


# How long a test waits for an expected event [s]: minutes, because the machine may be busy.
PATIENCE = 180.0


def until(condition: Callable[[], bool], seconds: float = PATIENCE) -> bool:
    """Wait until a condition holds that other threads fulfil; return False if it does not in time."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


def messages_of(html: str) -> list[dict[str, Any]]:
    """The messages that a static page carries."""
    scene = re.search(r'<script type="text/plain" id="scene">(.*?)</script>', html, re.DOTALL)
    assert scene is not None
    return [umsgpack.unpackb(base64.b64decode(line)) for line in scene.group(1).split()]


def read_png(data: bytes) -> np.ndarray:
    """The pixels of a PNG, shape (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))


def made_of(nao: nk.NaoModel) -> list[np.ndarray]:
    """Configurations to look at: every posture, and a few at random, coupled limits included."""
    return [*(nao.posture(name) for name in nao.posture_names), *nao.random(7, 5)]


def processes(mark: str) -> list[str]:
    """Return the command lines of running processes that contain a text."""
    found = []
    for process in Path("/proc").glob("[0-9]*/cmdline"):
        with suppress(OSError):
            found.append(process.read_bytes().replace(b"\0", b" ").decode("utf-8", "replace"))
    return [line for line in found if mark in line]
