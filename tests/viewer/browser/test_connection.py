"""Live pages in a real browser: programs that go and come, two pages of one robot, and what a page may connect to."""

from __future__ import annotations

import re
import time
from contextlib import ExitStack
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from free_ports import free_port
from viewer_pages import Page, opened, until, visitor

import nao_kin as nk
from nao_kin.viewer import Viewer
from nao_kin.viewer.access import PageHandler


def _live(page: Page, state: str) -> None:
    page.tab.wait_for_selector(f'body[data-live="{state}"]', timeout=15_000)


def _shows(page: Page, q: np.ndarray) -> bool:
    return until(lambda: bool(np.abs(page.q - q).max() <= 1e-9), 10.0)


def _grip(page: Page, joint: str) -> tuple[float, float, float]:
    """Press the mouse on the thumb of a slider; return its position, and how far it can move to the right."""
    page.slider(joint).scroll_into_view_if_needed()
    box = page.slider(joint).bounding_box()
    share = page.slider(joint).evaluate("(s) => (s.value - s.min) / (s.max - s.min)")
    x, y = box["x"] + 7 + share * (box["width"] - 14), box["y"] + box["height"] / 2
    page.tab.mouse.move(x, y)
    page.tab.mouse.down()
    return x, y, box["x"] + box["width"] - 8 - x


@pytest.mark.full
def test_a_page_waits_for_its_program_and_takes_up_what_the_next_one_shows(browser: Any, nao: nk.NaoModel) -> None:
    port = free_port()
    first = Viewer(nao, port=port)
    first.display(nao.posture("Sit"))
    first.show_ghosts(nao.posture("Stand"))
    first.add_robot(nk.load_nao("v4"))
    first.add_robot(nao)
    page = Page(browser, first.url)
    try:
        page.run("() => { window.here = true; }")
        assert _shows(page, nao.posture("Sit"))
        page.tab.locator("#cameras button", has_text="side").click()
        page.animation_frames(2)  # the camera's matrix is that of the last picture
        looks = page.run("() => [...naoKin.viewer.camera.matrixWorld.elements]")
        first.close()
        _live(page, "ended")
        assert "The panel still works" in page.tab.locator("#notice").inner_text()
        page.type_number("HeadYaw", "20")
        assert abs(page.q[nao.joint_names.index("HeadYaw")] - np.radians(20.0)) < 1e-9

        q = nao.posture("Crouch")
        with Viewer(nao, port=port) as second:
            second.display(q)
            second.show_com()
            second.add_robot(nao, name="twin")
            start = time.monotonic()
            _live(page, "live")
            assert time.monotonic() - start < 12.0
            assert _shows(page, q)
            assert page.run("() => window.here")  # not loaded anew
            page.tab.wait_for_function(
                "() => [...naoKin.others.robots.values()].map((it) => it.name).join() === 'twin'"
            )
            page.tab.wait_for_function("() => naoKin.parts.models.size === 1")
            geometries = "({ meshes }) => meshes.map(({ mesh }) => mesh.geometry.uuid).join()"
            assert page.run(f"() => new Set(naoKin.studio.robots.map({geometries})).size") == 1
            assert page.tab.locator("#notice").is_hidden()
            assert page.tab.locator("[data-shown=com]").get_attribute("aria-pressed") == "true"
            # Drawing turns the camera by roundings.
            assert np.allclose(page.run("() => [...naoKin.viewer.camera.matrixWorld.elements]"), looks, atol=1e-9)
            assert np.abs(page.poses(nao.frame_names) - nao.fk(q, nao.frame_names)).max() < 1e-6
            page.type_number("HeadYaw", "-30")
            assert _until_here(second, nao, "HeadYaw", np.radians(-30.0))
            second.wait(5.0)
        _live(page, "ended")

        page.tab.get_by_role("button", name="Try now").click()  # in vain, but the next tries come soon again
        other = nk.load_nao("v4")
        with Viewer(other, port=port) as third:
            page.tab.wait_for_function(
                "() => document.title === 'nao_v4' && document.body.dataset.ready", timeout=20_000
            )
            assert page.run("() => window.here") is None  # another robot: loaded anew
            third.display(q)
            assert _shows(page, q)
        # While nobody answers, the browser itself says so; nothing else is wrong.
        assert [line for line in page.errors if "ERR_CONNECTION_REFUSED" not in line] == []
    finally:
        page.close()


def _until_here(viewer: Viewer, nao: nk.NaoModel, joint: str, value: float) -> bool:
    column = nao.joint_names.index(joint)
    return until(lambda: bool(abs(viewer.q[column] - value) <= 1e-9))


@pytest.mark.full
def test_however_often_it_is_told_to_try_a_page_opens_one_socket(browser: Any, nao: nk.NaoModel) -> None:
    port = free_port()
    sockets: list[str] = []
    with Viewer(nao, port=port) as first, opened(browser, first.url) as page:
        first.close()
        _live(page, "ended")
        page.tab.on("websocket", lambda socket: sockets.append(socket.url))
        with Viewer(nao, port=port):
            page.tab.get_by_role("button", name="Try now").dblclick()
            _live(page, "live")
            page.tab.wait_for_timeout(300)
        page.errors.clear()  # the browser's own, of the socket that it could not open
    assert len(sockets) == 1


@pytest.mark.full
def test_a_page_that_loses_its_program_before_it_knows_what_that_has_is_loaded_anew(
    browser: Any, nao: nk.NaoModel
) -> None:
    errors: list[str] = []
    sockets: list[Any] = []

    def break_the_first(socket: Any) -> None:
        sockets.append(socket)
        server, is_first = socket.connect_to_server(), len(sockets) == 1

        def pass_on(message: bytes) -> None:
            if is_first and b"\xa4kind\xa7version" in message:
                socket.close()
            else:
                socket.send(message)

        server.on_message(pass_on)

    with Viewer(nao) as viewer, visitor(browser, viewport={"width": 900, "height": 600}) as context:
        viewer.display(nao.posture("Crouch"))
        tab = context.new_page()
        tab.on("console", lambda line: errors.append(line.text) if line.type == "error" else None)
        tab.on("pageerror", lambda error: errors.append(str(error)))
        tab.route_web_socket(re.compile("/live"), break_the_first)
        tab.goto(viewer.url)
        tab.wait_for_selector("body[data-ready]", timeout=30_000)
        assert len(sockets) == 3  # the one that broke, the one that sent the scene again, that of the new page
        assert tab.evaluate("() => performance.getEntriesByType('navigation')[0].type") == "reload"
        crouched = tab.evaluate("() => [...naoKin.q]")
        assert np.allclose(crouched, nao.posture("Crouch"))
        assert [tab.locator(one).count() for one in ("#fold", "#eye", "button.view", ".play")] == [1, 1, 1, 1]
        tab.get_by_role("button", name="Stand", exact=True).click()
        tab.keyboard.press("Control+z")  # once: there is one panel
        assert tab.evaluate("() => [...naoKin.q]") == crouched
    assert not errors


@pytest.mark.full
def test_a_page_whose_token_is_the_old_one_says_so_and_asks_no_more(browser: Any, nao: nk.NaoModel) -> None:
    port = free_port()
    with Viewer(nao, port=port, token=True) as first:
        page = Page(browser, first.url)
    try:
        _live(page, "ended")
        with Viewer(nao, port=port, token=True):
            page.tab.locator("#notice", has_text="only the new address").wait_for(timeout=15_000)
            before = len(page.requests)
            page.tab.wait_for_timeout(1500)
            assert len(page.requests) == before
    finally:
        page.close()


@pytest.mark.full
def test_two_pages_whose_sliders_are_dragged_at_once_end_with_one_configuration(browser: Any, nao: nk.NaoModel) -> None:
    with Viewer(nao) as viewer, opened(browser, viewer.url) as one, opened(browser, viewer.url) as other:
        pages = (one, other)
        for joints in (("HeadYaw", "HeadPitch"), ("HeadYaw", "HeadYaw")):
            grips = [_grip(page, joint) for page, joint in zip(pages, joints, strict=True)]
            for step in range(1, 13):
                for page, (x, y, room) in zip(pages, grips, strict=True):
                    page.tab.mouse.move(x + room * (-1) ** step * step / 40, y)
            for page in pages:
                page.tab.mouse.up()
            for page in pages:
                page.animation_frames(5)
            # What a page has reported may be on its way to the program, and from there to the other page.
            assert until(lambda: all(np.abs(page.q - viewer.q).max() <= 1e-9 for page in pages), 10.0)
            # Nothing goes round and round.
            received = [page.run("() => naoKin.received") for page in pages]
            reports = [page.run("() => naoKin.reports.count") for page in pages]
            one.tab.wait_for_timeout(300)
            assert [page.run("() => naoKin.received") for page in pages] == received
            assert [page.run("() => naoKin.reports.count") for page in pages] == reports
            assert np.array_equal(one.q, other.q)
            assert np.array_equal(one.q, viewer.q)


@pytest.mark.full
def test_a_report_that_another_page_overtakes_is_kept_where_it_came_last(browser: Any, nao: nk.NaoModel) -> None:
    """The other page's report arrives between this page's own report and its echo from the program."""
    with Viewer(nao) as viewer, opened(browser, viewer.url) as page:
        page.type_number("HeadYaw", "25")
        assert _until_here(viewer, nao, "HeadYaw", np.radians(25.0))
        q = viewer.q
        mine = page.run("() => `${naoKin.reports.source} ${naoKin.reports.count}`")
        page.run("() => naoKin.set([...naoKin.q].fill(0), null, false)")
        viewer._receive({"kind": "joints", "q": q.tolist(), "up": None, "source": mine})
        assert _shows(page, q)


@pytest.mark.full
@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "nao.localhost"])
def test_a_page_reaches_its_own_server_and_no_other(browser: Any, nao: nk.NaoModel, host: str) -> None:
    with Viewer(nao, token=True) as viewer, Viewer(nao) as other:
        page = Page(browser, viewer.url.replace("127.0.0.1", host))
        try:
            _live(page, "live")
            assert page.errors == []
            tries = """async (port) => {
                const refused = [];
                addEventListener("securitypolicyviolation", (event) => refused.push(event.effectiveDirective));
                const shut = (address) => new Promise((resolve) => {
                    try {
                        const socket = new WebSocket(address);
                        socket.onopen = () => resolve(false);
                        socket.onerror = () => resolve(true);
                    } catch { resolve(true); }
                });
                const closed = [
                    await shut(`ws://${location.hostname}:${port}/live`),
                    await shut("ws://evil.example/live"),
                    await fetch(`http://${location.hostname}:${port}/`).then(() => false, () => true),
                ];
                await new Promise((resolve) => setTimeout(resolve, 200));
                return { closed, refused };
            }"""
            found = page.run(tries, urlsplit(other.url).port)
            assert found["closed"] == [True, True, True]
            assert len(found["refused"]) >= 3
            assert set(found["refused"]) == {"connect-src"}
        finally:
            page.close()


@pytest.mark.full
def test_self_in_the_policy_covers_the_socket_where_a_proxy_changes_the_name(
    browser: Any, nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The other address in the policy is then one that the browser does not know."""
    policy = PageHandler._policy

    def renamed(handler: PageHandler) -> str:
        return re.sub(r" wss?://[^ ;]+", " ws://inner:1", policy(handler))

    monkeypatch.setattr(PageHandler, "_policy", renamed)
    with Viewer(nao) as viewer, opened(browser, viewer.url) as page:
        _live(page, "live")
        viewer.display(nao.posture("Sit"))
        assert _shows(page, nao.posture("Sit"))


@pytest.mark.full
def test_a_notebook_of_this_machine_may_frame_the_page_and_a_stranger_may_not(browser: Any, nao: nk.NaoModel) -> None:
    with Viewer(nao, token=True) as viewer, ExitStack() as running:
        frame = f'<!DOCTYPE html><iframe src="{viewer.url}" width="700" height="400"></iframe>'

        class Notebook(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                self.send_response(200)
                self.send_header("Content-Type", "text/html")
                self.end_headers()
                self.wfile.write(frame.encode())

            def log_message(self, *_: object) -> None:
                pass

        server = running.enter_context(ThreadingHTTPServer(("127.0.0.1", 0), Notebook))
        Thread(target=server.serve_forever, daemon=True).start()
        running.callback(server.shutdown)
        tab = running.enter_context(visitor(browser, viewport={"width": 760, "height": 420})).new_page()
        tab.goto(f"http://localhost:{server.server_port}/")
        inside = tab.frame_locator("iframe").locator('body[data-live="live"][data-ready]')
        inside.wait_for(state="attached", timeout=30_000)
        tab.goto("about:blank")
        tab.set_content(frame)
        tab.wait_for_timeout(1500)
        assert tab.frame_locator("iframe").locator("#panel").count() == 0


def test_the_browser_asks_again_and_is_told_that_it_has_the_page(browser: Any, nao: nk.NaoModel) -> None:
    # What the page does is of no matter here.
    with Viewer(nao) as viewer, visitor(browser, java_script_enabled=False) as context:
        tab = context.new_page()
        answers: list[Any] = []
        tab.on("response", lambda response: answers.append(response))
        sizes = []
        for _ in range(2):
            tab.goto(viewer.url)
            sizes.append(answers[-1].request.sizes()["responseBodySize"])
            tab.goto("about:blank")
        assert 0 < sizes[0] < 400_000
        assert sizes[1] == 0
