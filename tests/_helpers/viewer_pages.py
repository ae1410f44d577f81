"""Pages of the viewer in a real browser, for tests: one headless Chromium, watched for errors and for calls home."""

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
    # A list replaces Playwright's own, which is therefore here too. The first three make two more renderers for the
    # address bar of each new page, which take as long as the page itself.
    "--disable-features=WebUIOmniboxPopup,WebUIOmniboxAimPopup,WebUIOmniboxFullPopup,"
    "AimEnabled,AvoidCorsURLLoaderRestartOnRedirect,AvoidUnnecessaryBeforeUnloadCheckSync,DestroyProfileOnBrowserClose,"
    "HttpsFirstBalancedModeAutoEnable,HttpsUpgrades,LensOverlay,MediaRouter,NetworkTimeServiceQuerying,OptimizationHints,"
    "PaintHolding,PreconnectToSearch,TcpPortRandomizationWin,ThirdPartyStoragePartitioning"
).split()

# Without a graphics card drawing takes most of the time of a test; all else goes on without it.
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
    """A browser, closed whatever happens; the test is skipped where there is none."""
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
    """A browser's context of its own: with a memory of its own, and pages that draw nothing into their canvas."""
    context = browser.new_context(**options)
    context.add_init_script(_DRAW_NOTHING)
    try:
        yield context
    finally:
        context.close()


class Page:
    """An open page, with the errors and requests that it made while it was open.

    It draws nothing into its canvas unless it is told to; all else is as if it did.
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
        """What a hand on the slider does: a new value, and the event that announces it."""
        self.slider(joint).evaluate(
            "(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input', {bubbles: true})); }",
            value,
        )

    def type_number(self, joint: str, text: str) -> Any:
        """Click into a joint's number, type over it and press Enter, key by key; gives the field."""
        field = self.tab.locator(f'.joint[data-joint="{joint}"] input[type="text"]')
        field.click()
        self.tab.keyboard.press("ControlOrMeta+A")
        self.tab.keyboard.press("Delete")
        self.tab.keyboard.type(text)
        self.tab.keyboard.press("Enter")
        return field

    def switch(self, name: str) -> bool:
        """Press a button of the menu View, which is open for that only; gives whether it is on now."""
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
        """Wait until the page has gone through so many steps of its animation loop."""
        self.run(
            """(count) => new Promise((resolve) => {
                const step = (left) => (left > 0 ? requestAnimationFrame(() => step(left - 1)) : resolve());
                step(count);
            })""",
            count,
        )

    def draw(self, on: bool) -> None:
        """Whether to draw from now on."""
        self.run("(on) => { window.draws = on; naoKin.viewer.set_dirty(); }", on)

    def picture(self) -> np.ndarray:
        return read_png(self.tab.locator("#pane").screenshot())

    def close(self) -> None:
        self.tab.close()


@contextmanager
def opened(
    browser: Any, where: Path | str, size: tuple[int, int] = (760, 420), *, draws: bool = False
) -> Iterator[Page]:
    """A page that must neither complain nor ask anybody for anything but itself."""
    page = Page(browser, where.as_uri() if isinstance(where, Path) else where, size, draws=draws)
    try:
        yield page
        assert page.errors == []
    finally:
        page.close()


# How long a test waits for what must come [s]: minutes, for a machine may have twenty other things to do.
PATIENCE = 180.0


def until(condition: Callable[[], bool], seconds: float = PATIENCE) -> bool:
    """Wait for what other threads do; False if it does not come in time."""
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
    """Command lines of the running processes that name something."""
    found = []
    for process in Path("/proc").glob("[0-9]*/cmdline"):
        with suppress(OSError):
            found.append(process.read_bytes().replace(b"\0", b" ").decode("utf-8", "replace"))
    return [line for line in found if mark in line]
