"""Measure the speed of the live page: one `display`, compared with thirty transforms through meshcat's own client.

The two are timed in turns on the same machine; each time ends when the server has received them. If Playwright and a
browser are installed, the page is measured too: the time until it is ready, the configurations per second that it
accepts, its memory before and after (--seconds 30 shows a leak), and the frames per second that it draws in software
while the robot moves and while the camera moves around it, at 1400 × 900. With --beside FILE, a page of the same robot
saved by another version of this library, both pages are measured in turns and the ratio is printed. The time from
opening a live page to the first picture of the robot, and the pictures per second while a pointer turns the camera, are
compared with those of meshcat's page, and of viser's if it is installed. The output is JSON.
"""

from __future__ import annotations

import argparse
import contextlib
import http.client
import io
import json
import math
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np

import nao_kin as nk
from nao_kin._core.arrays import Floats
from nao_kin._core.process import find_browsers
from nao_kin.errors import NoBrowser
from nao_kin.viewer import MeshcatRobot, Viewer

TRANSFORMS = 30
# Moves the robot's joints, or the camera, in every frame for some seconds; returns the frames drawn per second.
_MOVE = """([joints, seconds]) => new Promise((done) => {
    const { camera, controls } = naoKin.viewer;
    const [q, place, up] = [[...naoKin.q], camera.position.clone(), new MeshCat.THREE.Vector3(0, 1, 0)];
    const [from, start] = [naoKin.drawn, performance.now()];
    let frame = 0;
    const step = () => {
        frame += 1;
        if (joints) naoKin.set(q.map((value, k) => value + 0.05 * Math.sin(0.3 * frame + k)));
        else camera.position.copy(place).sub(controls.target).applyAxisAngle(up, 0.02 * frame).add(controls.target);
        naoKin.viewer.set_dirty();
        const took = (performance.now() - start) / 1000;
        if (took < seconds) requestAnimationFrame(step);
        else done((naoKin.drawn - from) / took);
    };
    requestAnimationFrame(step);
})"""
# Notes the time since the navigation at which twenty shapes of the robot, and all before them, have been drawn; counts
# the pictures.
_PICTURES = """
    let shapes = 0;
    window.pictures = 0;
    let draws = false;
    for (const { prototype } of [WebGLRenderingContext, WebGL2RenderingContext]) {
        for (const [name, at] of [["drawElements", 1], ["drawArrays", 2]]) {
            const own = prototype[name];
            prototype[name] = function (...values) {
                own.apply(this, values);
                draws = true;
                if (values[at] < 300 || (shapes += 1) !== 20) return;
                setTimeout(() => {
                    this.readPixels(0, 0, 1, 1, this.RGBA, this.UNSIGNED_BYTE, new Uint8Array(4));
                    window.firstPicture = performance.now();
                });
            };
        }
    }
    const count = () => {
        window.pictures += draws ? 1 : 0;
        draws = false;
        requestAnimationFrame(count);
    };
    requestAnimationFrame(count);
"""
# Sets the robot down on the floor at each configuration; returns the milliseconds that each takes.
_SET_DOWN = """(qs) => qs.map((q) => {
    naoKin.robot.apply(q);
    naoKin.shown.standing.forget();
    const begin = performance.now();
    naoKin.shown.standing.place(q, null);
    return performance.now() - begin;
})"""
# The memory of the page: its heap after a garbage collection, and its objects on the graphics card.
_HELD = """() => {
    gc();
    const { memory } = naoKin.viewer.renderer.info;
    return { heap_mb: performance.memory.usedJSHeapSize / 1e6, ...memory };
}"""
_MEMORY = ("--enable-precise-memory-info", "--js-flags=--expose-gc")
_OPTIONS = ("--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=30, help="number of timings of each (default 30)")
    parser.add_argument("--seconds", type=float, default=2.0, help="how long the page is watched (default 2)")
    parser.add_argument("--beside", type=Path, help="a page saved by another version, to compare with this one's")
    arguments = parser.parse_args()
    nao = nk.load_nao()
    qs = nao.random(1, 100)
    with Viewer(nao) as viewer:
        report = {
            **_beside_meshcat(nao, viewer, qs, arguments.rounds),
            "bytes": _bytes(viewer),
            "page": _page(viewer, qs, arguments),
        }
    print(json.dumps(report, indent=2))


@contextlib.contextmanager
def _meshcat() -> Iterator[Any]:
    """Start meshcat's own server, and end it."""
    import meshcat

    with contextlib.redirect_stdout(io.StringIO()):
        client = meshcat.Visualizer()
    try:
        yield client
    finally:
        client.window.server_proc.kill()
        client.window.server_proc.wait()
        client.window.zmq_socket.close(linger=0)


def _beside_meshcat(nao: nk.NaoModel, viewer: Viewer, qs: Floats, rounds: int) -> dict[str, Any]:
    names = nao.link_names[:TRANSFORMS]
    with _meshcat() as client:
        nodes = [client[name] for name in names]

        def transforms(q: Floats) -> None:
            for node, pose in zip(nodes, nao.fk(q, names), strict=True):
                node.set_transform(pose)

        displayed, transformed = [], []
        for _ in range(rounds):
            displayed.append(_seconds(viewer.display, qs))
            transformed.append(_seconds(transforms, qs[:5]))
    ours, theirs = statistics.median(displayed), statistics.median(transformed)
    return {
        "display_us": round(1e6 * ours, 1),
        "displays_per_second": round(1.0 / ours),
        f"meshcat_{TRANSFORMS}_transforms_us": round(1e6 * theirs, 1),
        "ratio": round(theirs / ours, 1),
    }


def _bytes(viewer: Viewer) -> dict[str, int]:
    """Return the bytes transferred for the page: uncompressed, as browsers request it, and with a browser cache."""
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


def _page(viewer: Viewer, qs: Floats, arguments: argparse.Namespace) -> dict[str, Any] | str:
    seconds: float = arguments.seconds
    try:
        from playwright.sync_api import sync_playwright

        program = find_browsers()[0]
    except (ImportError, NoBrowser) as error:
        return f"not measured: {error}"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=str(program), args=[*_OPTIONS, *_MEMORY])
        try:
            tab = browser.new_page(viewport={"width": 960, "height": 480})
            tab.goto(viewer.url)
            tab.wait_for_selector("body[data-ready]")
            return {
                "at_60_per_second": _watched(tab, viewer, qs, seconds, 60.0),
                "as_fast_as_possible": _watched(tab, viewer, qs, seconds, None),
                "beside_others": _beside_others(browser, viewer, seconds),
                "drawn_at_1400x900": _drawn(browser, viewer, arguments.beside, max(seconds, 4.0)),
            }
        finally:
            browser.close()


def _watched(tab: Any, viewer: Viewer, qs: Floats, seconds: float, rate: float | None) -> dict[str, Any]:
    before = tab.evaluate(_HELD)
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
    after = tab.evaluate(_HELD)
    return {
        "sent_per_second": round(sent / sending, 1),
        "taken_per_second": round((received_then - received) / took, 1),
        "drawn_per_second": round((drawn_then - drawn) / took, 1),
        "held": {what: [round(before[what], 2), round(after[what], 2)] for what in before},
    }


@contextlib.contextmanager
def _viser(robot: nk.RobotModel, q: Floats) -> Iterator[str | None]:
    """Yield the address of viser's page with a robot, or None if viser is not installed."""
    try:
        import viser
        import viser.extras
    except ImportError:
        yield None
        return
    import yourdfpy

    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        shown = viser.extras.ViserUrdf(server, yourdfpy.URDF.load(str(robot.urdf_path)))
        server.scene.add_grid("/grid")
        angles = robot.angles(q)
        shown.update_cfg(np.array([angles[name] for name in shown.get_actuated_joint_names()]))
        yield f"http://127.0.0.1:{server.get_port()}"
    finally:
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()


def _beside_others(browser: Any, viewer: Viewer, seconds: float) -> dict[str, dict[str, float]]:
    """Return the medians of five turns: the seconds to the first picture of live pages, and pictures per second."""
    with _meshcat() as client, _viser(viewer.robot, viewer.q) as viser:
        MeshcatRobot(viewer.robot, client).display(viewer.q)
        pages = {"this": viewer.url, "meshcat": client.url(), **({} if viser is None else {"viser": viser})}
        found: dict[str, list[tuple[float, float]]] = {name: [] for name in pages}
        for _ in range(5):
            for name, address in pages.items():
                tab = browser.new_page(viewport={"width": 1400, "height": 900})
                tab.add_init_script(_PICTURES)
                tab.goto(address)
                tab.wait_for_function("() => window.firstPicture")
                first: float = tab.evaluate("() => window.firstPicture / 1000")
                tab.wait_for_timeout(4000)  # what a page draws after its first picture
                found[name].append((first, _turned(tab, seconds)))
                tab.close()
    medians = {name: [statistics.median(row) for row in zip(*rows, strict=True)] for name, rows in found.items()}
    report = {name: {"first_picture_s": round(s, 2), "pictures_per_s": round(n, 1)} for name, (s, n) in medians.items()}
    first, often = medians.pop("this")
    for name, (s, n) in medians.items():
        report[f"ratio to {name}"] = {"first_picture": round(first / s, 2), "pictures": round(often / n, 2)}
    return report


def _turned(tab: Any, seconds: float) -> float:
    """Return the pictures per second while a pointer turns the camera."""
    tab.mouse.move(480, 450)
    tab.mouse.down()
    before, start, step = tab.evaluate("() => window.pictures"), time.perf_counter(), 0
    while (took := time.perf_counter() - start) < seconds:
        step += 1
        tab.mouse.move(480 + 200 * math.sin(step / 15), 450 + 60 * math.sin(step / 22))
    tab.mouse.up()
    return float(tab.evaluate("() => window.pictures") - before) / took


def _drawn(browser: Any, viewer: Viewer, beside: Path | None, seconds: float) -> dict[str, Any]:
    """Return frames per second, the median of three turns, for pages of this library and of another version of it."""
    with tempfile.TemporaryDirectory() as folder:
        pages = {"this": viewer.save_html(Path(folder) / "this.html")}
        if beside is not None:
            pages["beside"] = beside.resolve()
        found: dict[str, list[dict[str, float]]] = {name: [] for name in pages}
        for _ in range(3):
            for name, path in pages.items():
                tab = browser.new_page(viewport={"width": 1400, "height": 900})
                start = time.perf_counter()
                tab.goto(path.as_uri())
                tab.wait_for_selector("body[data-ready]")
                row = {"ready_s": time.perf_counter() - start}
                tab.wait_for_timeout(1000)
                row["set_down_ms"] = statistics.median(tab.evaluate(_SET_DOWN, viewer.robot.random(8, 200).tolist()))
                for what in ("robot_moves", "camera_moves"):
                    row[f"{what}_per_s"] = tab.evaluate(_MOVE, [what == "robot_moves", seconds])
                tab.close()
                found[name].append(row)
    report: dict[str, Any] = {
        name: {what: round(statistics.median(row[what] for row in rows), 2) for what in rows[0]}
        for name, rows in found.items()
    }
    if beside is not None:
        moves = [what for what in report["this"] if what.endswith("per_s")]
        report["ratio"] = {what: round(report["this"][what] / report["beside"][what], 1) for what in moves}
    return report


def _seconds(show: Callable[[Floats], None], qs: Floats) -> float:
    start = time.perf_counter()
    for q in qs:
        show(q)
    return (time.perf_counter() - start) / len(qs)


if __name__ == "__main__":
    main()
