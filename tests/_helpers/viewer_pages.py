"""Pages of the viewer in a headless Chromium, watched for errors and for requests to other servers."""

from __future__ import annotations

import base64
import gzip
import io
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import urlsplit
from weakref import WeakKeyDictionary

import numpy as np
import pytest
import umsgpack
from PIL import Image

import nao_kin as nk
from nao_kin._core.process import find_browsers
from nao_kin.errors import NoBrowser

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
    // What is not drawn needs no shaders either: to compile them takes a quarter of the time of opening a page.
    let page;
    const skipUndrawn = (renderer) => {
        const own = renderer.renderBufferDirect;
        renderer.renderBufferDirect = (...values) => { if (window.draws) own(...values); };
    };
    Object.defineProperty(window, "naoKin", {
        configurable: true,
        get: () => page,
        set(made) {
            page = made;
            skipUndrawn(page.viewer.renderer);
        },
    });
"""


# Put everything back that a test may have left. What the controls were at first is kept when this runs first.
_RESET = """(q) => {
    const { drag, ghosts, panel, pick, player, stance, toggles } = naoKin;
    const fields = ":is(input:is([type=checkbox], [type=radio]), select):not(#legend *)";
    const controls = () => [...document.querySelectorAll(fields)];
    window.atFirst ??= {
        ...{ clip: player.clip, looping: player.looping, read: pick.selection.read, shown: { ...toggles.shown } },
        controls: new Map(controls().map((one) => [one, one.checked ?? one.value])),
    };
    if (drag.held) drag.cancel();
    for (const dialog of document.querySelectorAll("dialog[open]")) dialog.close();
    for (const sheet of document.querySelectorAll(":popover-open")) sheet.hidePopover();
    document.activeElement.blur();
    panel.messages.close();
    naoKin.notice();
    panel.layout.fold(false);
    panel.layout.resize(null);
    panel.joints.search.value = "";
    panel.joints.filter();
    pick.measure.clear();
    pick.selection.select(null);
    pick.selection.follow(atFirst.read);
    if (player.recording.recorder) player.recording.stop();
    const { editor, plots } = player;
    if (editor.frames.count > 0) editor.apply(new editor.frames.constructor(), -1);
    editor.open(false);
    if (!plots.element.hidden) plots.open(false);
    player.clip = atFirst.clip;
    if (player.playback !== player.clip) player.change(player.clip);
    player.pause();
    player.seek(0);
    player.setLoop(atFirst.looping);
    for (const one of controls()) {
        const before = atFirst.controls.get(one);
        if (before === undefined) continue;
        if (one.type === "radio" && before && !one.checked) one.click();
        if (one.type === "checkbox" && before !== one.checked) one.click();
        if (one.matches("select") && before !== one.value) {
            one.value = before;
            one.dispatchEvent(new Event("change", { bubbles: true }));
        }
    }
    for (const bar of document.querySelectorAll("[role=toolbar]"))
        bar.querySelectorAll("button").forEach((button, i) => (button.tabIndex = i === 0 ? 0 : -1));
    if (ghosts.copies.length > 0)
        naoKin.receive({ kind: "ghosts", qs: new Float64Array(0), count: 0, opacity: 1, first: null });
    const changed = Object.entries(atFirst.shown).filter(([name, on]) => toggles.shown[name] !== on);
    if (changed.length > 0) naoKin.show(Object.fromEntries(changed));
    stance.jump(q);
    stance.settle();
    naoKin.camera("three-quarter");
    for (const scrolled of document.querySelectorAll("#panel > .body, .menu")) scrolled.scrollTop = 0;
    panel.past.letGo();
    Object.assign(panel.past.history, { past: [], future: [] });
    panel.past.dispatchEvent(new Event("changed"));
    localStorage.clear();
    // The next Tab leads to the first control of the page.
    document.body.tabIndex = -1;
    document.body.focus();
    document.body.removeAttribute("tabindex");
}"""


@contextmanager
def chromium() -> Iterator[Any]:
    """Open a browser and close it at the end; the test is skipped if no browser is installed."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    try:
        program = find_browsers()[0]
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


class Tab:
    """A tab in a context of its own, in which one page after another is opened.

    Opening the next page there takes half as long as opening it in a new tab.
    """

    def __init__(self, browser: Any, draws: bool, options: dict[str, Any]) -> None:
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.tab = browser.new_page(**options)
        self.tab.on("console", lambda line: self.errors.append(line.text) if line.type == "error" else None)
        self.tab.on("pageerror", lambda error: self.errors.append(str(error)))
        self.tab.on("request", lambda request: self.requests.append(request.url))
        self.tab.add_init_script(_DRAW_NOTHING)
        if draws:
            self.tab.add_init_script("window.draws = true;")
        self.session = self.tab.context.new_cdp_session(self.tab)
        usual = {"color_scheme": "light", "reduced_motion": "no-preference", "forced_colors": "none"}
        self.media = {name: options.get(name, value) for name, value in usual.items()}

    def clear(self) -> None:
        """Leave the page, and bring the tab into the state of a new one."""
        self.tab.evaluate("() => { localStorage.clear(); sessionStorage.clear(); }")
        self.tab.mouse.move(-1, -1)
        self.tab.goto("about:blank")
        self.tab.context.clear_cookies()
        self.tab.context.clear_permissions()
        self.tab.emulate_media(**self.media)
        self.session.send("Page.resetNavigationHistory")


# The tabs of each browser that wait for their next page, by what they can do.
_free: WeakKeyDictionary[Any, dict[Any, list[Tab]]] = WeakKeyDictionary()


class Page:
    """An open page, with the errors and requests that it made while it was open.

    It draws nothing into its canvas unless it is told to; all else is as if it did.

    Args:
        browser: the browser.
        url: the address of the page.
        size: width and height of the window [px].
        draws: whether it draws into its canvas.
        options: of the browser's context, such as `has_touch`.
    """

    def __init__(
        self, browser: Any, url: str, size: tuple[int, int] = (760, 420), *, draws: bool = False, **options: Any
    ) -> None:
        self.size = size
        # A button that changes its colour little by little is painted for each picture on the way.
        options = {"reduced_motion": "reduce", **options}
        viewport = {"width": size[0], "height": size[1]}
        # A tab that goes from a file to a server, or back, takes a new process.
        kind = (urlsplit(url).scheme, draws, *sorted(options.items()))
        self._same = _free.setdefault(browser, {}).setdefault(kind, [])
        if self._same:
            self._tab = self._same.pop()
            if self._tab.tab.viewport_size != viewport:
                self._tab.tab.set_viewport_size(viewport)
        else:
            self._tab = Tab(browser, draws, {"viewport": viewport, **options})
        self.tab = self._tab.tab
        self.errors = self._tab.errors = []
        self.requests = self._tab.requests = []
        self.tab.goto(url)
        self.tab.wait_for_selector("body[data-ready]", timeout=30_000)

    def reset(self, q: np.ndarray, size: tuple[int, int] | None = None) -> None:
        """Put a page that several tests share into the state that it had at first.

        That is: no button down, menus and messages closed, nothing selected, measured, recorded, remembered or in the
        past, all switches and units as they were, the clip paused at its beginning.

        Args:
            q: the configuration to show.
            size: width and height of the window [px]; by default as they were when it was opened.
        """
        viewport = dict(zip(("width", "height"), size or self.size, strict=True))
        if self.tab.viewport_size != viewport:
            self.tab.set_viewport_size(viewport)
        self.tab.keyboard.up("Shift")
        self.tab.mouse.up()
        self.tab.mouse.move(-1, -1)
        self.run(_RESET, np.asarray(q).tolist())

    def leave(self) -> None:
        """Close the page, and keep its tab for the next one."""
        self._tab.clear()
        self._same.append(self._tab)

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

    def edit_number(self, joint: str) -> Any:
        """Click on a joint's number, and return the field that it becomes."""
        row = self.tab.locator(f'.joint[data-joint="{joint}"]')
        row.locator(".number").click()
        return row.locator('input[type="text"]')

    def type_number(self, joint: str, text: str) -> Any:
        """Click on a joint's number, type a new one and press Enter; return the field."""
        field = self.edit_number(joint)
        self.tab.keyboard.press("ControlOrMeta+A")
        self.tab.keyboard.press("Delete")
        self.tab.keyboard.type(text)
        self.tab.keyboard.press("Enter")
        return field

    def switch(self, name: str) -> bool:
        """Press a button of the menu View, opening and closing the menu; return whether the button is on."""
        menu, button = (
            self.tab.locator("button.view"),
            self.tab.get_by_role("button", name=name, exact=True),
        )
        menu.click()
        button.click()
        on = button.get_attribute("aria-pressed") == "true"
        menu.click()
        return on

    def touch(self, kind: str, *points: Any) -> None:
        """Send a touch event with one finger at each of the points."""
        touches = [{"x": float(x), "y": float(y), "id": i} for i, (x, y) in enumerate(points)]
        self._tab.session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})

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
        """Switch drawing on or off; shadows that were cast without drawing are cast again."""
        self.run("(on) => { window.draws = on; naoKin.studio.shadowsOld = Infinity; naoKin.viewer.set_dirty(); }", on)

    def picture(self) -> np.ndarray:
        return read_png(self.tab.locator("#pane").screenshot())

    def close(self) -> None:
        self.tab.close()


AnyPage = TypeVar("AnyPage", bound=Page)


@contextmanager
def opened(
    browser: Any,
    where: Path | str,
    size: tuple[int, int] = (760, 420),
    *,
    draws: bool = False,
    kind: type[AnyPage] = Page,  # type: ignore[assignment]
    **options: Any,
) -> Iterator[AnyPage]:
    """Open a page that must report no error and send no request to another server."""
    page = kind(browser, where.as_uri() if isinstance(where, Path) else where, size, draws=draws, **options)
    try:
        yield page
        assert page.errors == []
    except BaseException:
        page.close()  # a test that fails may leave a button pressed
        raise
    page.leave()


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


def messages_of(page: str) -> list[dict[str, Any]]:
    """The messages that a static page carries."""
    scene, messages = unpacked(page, "scene"), []
    while scene:
        end = 4 + int.from_bytes(scene[:4], "big")
        messages.append(umsgpack.unpackb(scene[4:end]))
        scene = scene[end:]
    return messages


def unpacked(page: str, part: str) -> bytes:
    """The scene or the scripts in a page."""
    found = re.search(f'<script type="text/plain" id="{part}">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    return gzip.decompress(base64.b64decode(found.group(1)))


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
