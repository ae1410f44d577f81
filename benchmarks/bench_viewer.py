"""How fast the live view is: one `display` beside thirty transforms sent through meshcat's own client, as JSON.

The two are timed in turns on the same machine, and both end when the server has them. With Playwright and a browser at
hand the page is measured too: how many configurations it takes in a second, and how many it draws in software.
"""

from __future__ import annotations

import argparse
import contextlib
import http.client
import io
import json
import statistics
import time
from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit

import nao_kin as nk
from nao_kin._common.arrays import Floats
from nao_kin.errors import NoBrowser
from nao_kin.viewer import Viewer
from nao_kin.viewer.browser import find_browser

TRANSFORMS = 30
_OPTIONS = ("--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=30, help="how often each is timed (default 30)")
    parser.add_argument("--seconds", type=float, default=2.0, help="how long the page is watched (default 2)")
    arguments = parser.parse_args()
    nao = nk.load_nao()
    qs = nao.random(1, 100)
    with Viewer(nao) as viewer:
        report = {
            **_beside_meshcat(nao, viewer, qs, arguments.rounds),
            "bytes": _bytes(viewer),
            "page": _page(viewer, qs, arguments.seconds),
        }
    print(json.dumps(report, indent=2))


def _beside_meshcat(nao: nk.NaoModel, viewer: Viewer, qs: Floats, rounds: int) -> dict[str, Any]:
    import meshcat

    names = nao.link_names[:TRANSFORMS]
    with contextlib.redirect_stdout(io.StringIO()):
        client = meshcat.Visualizer()
    try:
        nodes = [client[name] for name in names]

        def transforms(q: Floats) -> None:
            for node, pose in zip(nodes, nao.fk(q, names), strict=True):
                node.set_transform(pose)

        displayed, transformed = [], []
        for _ in range(rounds):
            displayed.append(_seconds(viewer.display, qs))
            transformed.append(_seconds(transforms, qs[:5]))
    finally:
        client.window.server_proc.kill()
        client.window.server_proc.wait()
        client.window.zmq_socket.close(linger=0)
    ours, theirs = statistics.median(displayed), statistics.median(transformed)
    return {
        "display_us": round(1e6 * ours, 1),
        "displays_per_second": round(1.0 / ours),
        f"meshcat_{TRANSFORMS}_transforms_us": round(1e6 * theirs, 1),
        "ratio": round(theirs / ours, 1),
    }


def _bytes(viewer: Viewer) -> dict[str, int]:
    """What the page takes on the wire: plain, as browsers ask for it, and when the browser has it already."""
    address = urlsplit(viewer.url)

    def asked(**headers: str) -> tuple[int, str]:
        connection = http.client.HTTPConnection(address.hostname or "", address.port)
        with contextlib.closing(connection):
            connection.request("GET", "/", headers=headers)
            answer = connection.getresponse()
            return len(answer.read()), answer.headers["ETag"]

    plain, tag = asked()
    known = {"If-None-Match": tag}
    return {"page": plain, "page_gzip": asked(**{"Accept-Encoding": "gzip"})[0], "page_again": asked(**known)[0]}


def _page(viewer: Viewer, qs: Floats, seconds: float) -> dict[str, Any] | str:
    try:
        from playwright.sync_api import sync_playwright

        program = find_browser()
    except (ImportError, NoBrowser) as error:
        return f"not measured: {error}"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(program), args=_OPTIONS)
        try:
            tab = browser.new_page(viewport={"width": 960, "height": 480})
            tab.goto(viewer.url)
            tab.wait_for_selector("body[data-ready]")
            return {
                "at_60_per_second": _watched(tab, viewer, qs, seconds, 60.0),
                "as_fast_as_possible": _watched(tab, viewer, qs, seconds, None),
            }
        finally:
            browser.close()


def _watched(tab: Any, viewer: Viewer, qs: Floats, seconds: float, rate: float | None) -> dict[str, float]:
    received, drawn = tab.evaluate("() => [naoKin.received, naoKin.drawn]")
    start, sent = time.perf_counter(), 0
    while (now := time.perf_counter() - start) < seconds:
        viewer.display(qs[sent % len(qs)])
        sent += 1
        if rate is not None:
            time.sleep(max(0.0, sent / rate - now))
    sending = time.perf_counter() - start
    tab.wait_for_function("(q) => naoKin.q.every((value, i) => value === q[i])", arg=viewer.q.tolist())
    took = time.perf_counter() - start
    received_then, drawn_then = tab.evaluate("() => [naoKin.received, naoKin.drawn]")
    return {
        "sent_per_second": round(sent / sending, 1),
        "taken_per_second": round((received_then - received) / took, 1),
        "drawn_per_second": round((drawn_then - drawn) / took, 1),
    }


def _seconds(show: Callable[[Floats], None], qs: Floats) -> float:
    start = time.perf_counter()
    for q in qs:
        show(q)
    return (time.perf_counter() - start) / len(qs)


if __name__ == "__main__":
    main()
