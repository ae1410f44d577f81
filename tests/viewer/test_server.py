"""The live server, over the connection that a page opens, without a browser."""

from __future__ import annotations

import asyncio
import gc
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import tracemalloc
import urllib.error
import urllib.request
import weakref
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import ExitStack, asynccontextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import umsgpack
from free_ports import free_port
from loops import full
from made_up_robots import J, made_up
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import WebSocketClientConnection, websocket_connect
from viewer_pages import PATIENCE, until

import nao_kin as nk
from nao_kin.errors import BadArgument, NoBrowser
from nao_kin.viewer import Viewer, server
from nao_kin.viewer.access import Document, live_page, policy
from nao_kin.viewer.messages import RetainedMessages
from nao_kin.viewer.server import LiveServer


@pytest.fixture
def viewer(nao: nk.NaoModel) -> Iterator[Viewer]:
    with Viewer(nao) as viewer:
        yield viewer


class Client:
    """A page without a browser: it reports that it is ready, and keeps what it receives."""

    def __init__(self, connection: WebSocketClientConnection) -> None:
        self.connection = connection
        self.received: list[dict[str, Any]] = []

    async def receive(self, kind: str, enough: Callable[[dict[str, Any]], bool] = lambda _: True) -> dict[str, Any]:
        while True:
            message = await asyncio.wait_for(self.connection.read_message(), 10.0)
            assert message is not None, "the server closed the connection"
            self.received.append(umsgpack.unpackb(message))
            if self.received[-1].get("kind") == kind and enough(self.received[-1]):
                return self.received[-1]

    async def send(self, **answer: Any) -> None:
        await self.connection.write_message(json.dumps(answer))


@asynccontextmanager
async def _client(viewer: Viewer) -> AsyncIterator[Client]:
    client = await _connected(viewer)
    try:
        await client.receive("complete")
        await client.send(kind="ready")
        yield client
    finally:
        await _closed(client.connection)


async def _closed(connection: WebSocketClientConnection) -> None:
    """Close a connection and wait until it is closed."""
    connection.close()
    while await connection.read_message() is not None:
        pass


async def _connected(viewer: Viewer, query: str = "") -> Client:
    address = viewer.url.replace("http:", "ws:") + "live" + query
    request = HTTPRequest(address, headers={"Origin": viewer.url.rstrip("/")})
    return Client(await websocket_connect(request, max_message_size=1 << 27))


def _q_of(message: dict[str, Any]) -> np.ndarray:
    return np.frombuffer(message["q"].data, dtype=np.float64)


_others: list[threading.Thread] = []


@pytest.fixture(autouse=True)
def _servers_of_others() -> None:
    """Note the servers of earlier tests in this process: nobody may have collected a viewer of theirs yet."""
    _others[:] = [thread for thread in threading.enumerate() if thread.name == "nao_kin viewer"]


def _viewer_threads() -> list[threading.Thread]:
    """Return the threads of the servers that the test itself has started."""
    return [thread for thread in threading.enumerate() if thread.name == "nao_kin viewer" and thread not in _others]


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=PATIENCE) as response:
            return response.status == 200
    except OSError:
        return False


def test_it_listens_on_this_machine_only_and_serves_the_page(viewer: Viewer) -> None:
    assert viewer.url.startswith("http://127.0.0.1:")
    with urllib.request.urlopen(viewer.url, timeout=PATIENCE) as response:
        page = response.read().decode("utf-8")
    assert "<title>nao_v6</title>" in page
    others = ["127.0.0.2"]  # on Linux an address of this machine, too: only a socket bound to all of them answers
    with suppress(OSError):
        others += [str(address[4][0]) for address in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)]
    port = int(viewer.url.rstrip("/").rpartition(":")[2])
    for address in set(others) - {"127.0.0.1"}:
        with socket.socket() as knock:
            knock.settimeout(2.0)
            assert knock.connect_ex((address, port)) != 0, address


def test_leaving_the_block_ends_the_server(nao: nk.NaoModel) -> None:
    with Viewer(nao, port=free_port()) as viewer:
        url = viewer.url
        assert _answers(url)
        assert len(_viewer_threads()) == 1
    assert not _answers(url)
    assert _viewer_threads() == []
    viewer.close()


def test_a_viewer_that_nobody_holds_ends_its_server(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao, port=free_port())
    url, alive = viewer.url, weakref.ref(viewer)
    del viewer
    gc.collect()
    assert alive() is None
    assert until(lambda: _viewer_threads() == [])
    assert not _answers(url)


def test_a_viewer_may_be_dropped_by_what_a_page_sends(nao: nk.NaoModel) -> None:
    ended = []

    class Dropped(Viewer):
        def _receive(self, answer: dict[str, Any]) -> None:
            ended.append(threading.current_thread())
            kept.clear()

    kept = [Dropped(nao)]
    seen = weakref.ref(kept[0])
    server, threads = kept[0]._started(), _viewer_threads()

    server.call(lambda: server._on_answer({"kind": "ready"}))  # as from a page
    assert until(lambda: seen() is None)
    assert ended == threads
    assert not server.wait_for_page(5.0, role="nobody")
    assert until(lambda: _viewer_threads() == [])


@pytest.mark.full
def test_servers_that_have_ended_leave_no_memory_behind(nao: nk.NaoModel) -> None:
    viewer = Viewer(nao)
    viewer._started()
    ended = [weakref.ref(viewer._started()._document)]
    for _ in range(3):
        viewer.close()
        ended.append(weakref.ref(viewer._started()._document))
    viewer.close()
    gc.collect()
    assert [document() for document in ended] == [None] * 4


def test_threads_that_ask_at_once_get_one_address(nao: nk.NaoModel) -> None:
    viewer, together, found = Viewer(nao), threading.Barrier(6), []

    def ask() -> None:
        together.wait(PATIENCE)
        found.append(viewer.url)

    threads = [threading.Thread(target=ask) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(_viewer_threads()) == 1
    assert set(found) == {viewer.url}
    viewer.close()
    assert _viewer_threads() == []


def test_a_process_without_free_files_is_told_so(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(coroutine: Any) -> None:
        coroutine.close()
        raise OSError(24, "Too many open files")

    monkeypatch.setattr("nao_kin.viewer.server.asyncio.run", full)
    with pytest.raises(BadArgument, match="cannot serve the page: Too many open files"), Viewer(nao):
        pass


def test_what_is_sent_along_with_a_request_is_not_read(viewer: Viewer) -> None:
    port = int(viewer.url.rstrip("/").rpartition(":")[2])
    with socket.create_connection(("127.0.0.1", port), timeout=10.0) as connection:
        # The body is never sent, so a server that waited for it would not answer.
        connection.sendall(f"POST / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Length: 90000000\r\n\r\n".encode())
        assert connection.recv(100).startswith(b"HTTP/1.1 400 ")


def _ends(connection: socket.socket) -> bool:
    """Whether the server closes a connection, after whatever it still sends."""
    with suppress(ConnectionResetError):
        while connection.recv(1 << 16):
            pass
    return True


def test_half_a_request_is_not_held_for_long_and_a_page_is(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nao_kin.viewer.server._SECONDS_FOR_A_REQUEST", 0.2)  # read when a server starts
    viewer = Viewer(nao)
    port = int(viewer.url.rstrip("/").rpartition(":")[2])
    head = f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n"
    parts = "", head, head + "\r\n", head + "Content-Length: 100\r\n\r\nnot a hundred"

    async def stay() -> None:
        async with _client(viewer) as page:
            with ExitStack() as opened:
                for part in parts:
                    connection = opened.enter_context(socket.create_connection(("127.0.0.1", port), timeout=PATIENCE))
                    connection.sendall(part.encode())
                    assert await asyncio.to_thread(_ends, connection), part
            viewer.display(viewer.robot.posture("Crouch"))
            await page.receive("joints", lambda message: np.array_equal(_q_of(message), viewer.q))

    with viewer:
        asyncio.run(stay())


def test_so_many_connections_are_open_at_once_and_the_next_ones_wait(
    viewer: Viewer, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("nao_kin.viewer.server._SECONDS_BETWEEN_ATTEMPTS", 0.05)
    port = int(viewer.url.rstrip("/").rpartition(":")[2])
    before = len(os.listdir("/dev/fd"))
    with ExitStack() as opened:
        for _ in range(200):
            connection = opened.enter_context(socket.create_connection(("127.0.0.1", port), timeout=PATIENCE))
            connection.sendall(b"GET / HTTP/1.1\r\nHost: loc")
        assert until(lambda: len(caplog.records) > 0)
        assert len(os.listdir("/dev/fd")) - before - 200 == 128
        last = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        last.sendall(f"HEAD / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
    with last:
        assert last.recv(12) == b"HTTP/1.1 200"
    assert [record.getMessage() for record in caplog.records] == [
        "pages that connect have to wait: 128 connections are open"
    ]


@pytest.mark.full
@pytest.mark.skipif(os.name != "posix", reason="limits of a process")
def test_a_program_without_free_files_says_so_in_one_line_and_pages_wait(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(
        "import os, resource, nao_kin as nk\n"
        "from nao_kin.viewer import Viewer\n"
        "with Viewer(nk.load_nao()) as viewer:\n"
        "    print(viewer.url, flush=True)\n"
        "    most, largest = resource.getrlimit(resource.RLIMIT_NOFILE)\n"
        "    free = os.dup(0)\n"
        "    os.close(free)\n"
        "    resource.setrlimit(resource.RLIMIT_NOFILE, (free, largest))\n"
        "    print('no file is free', flush=True)\n"
        "    input()\n"
        "    resource.setrlimit(resource.RLIMIT_NOFILE, (most, largest))\n"
        "    input()\n",
        encoding="utf-8",
    )
    pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, str(program)], text=True, **pipes) as process:
        try:
            assert process.stdin is not None
            assert process.stdout is not None
            assert process.stderr is not None
            port = int(process.stdout.readline().strip().rstrip("/").rpartition(":")[2])
            assert process.stdout.readline() == "no file is free\n"
            with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as page:
                page.sendall(f"HEAD / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
                assert process.stderr.readline() == "pages that connect have to wait: Too many open files\n"
                process.stdin.write("\n")
                process.stdin.flush()
                assert page.recv(12) == b"HTTP/1.1 200"
            _, errors = process.communicate("\n", timeout=PATIENCE)
            assert (process.returncode, errors) == (0, "")
        finally:
            process.kill()


def test_what_comes_and_goes_without_a_page_is_not_remembered(viewer: Viewer) -> None:
    viewer._started()
    for number in range(20):
        viewer.add_points(f"scan {number}", [[0.0, 0.0, 0.0]])
        viewer.remove(f"scan {number}")
    assert len(viewer._server._changed) == 0


def test_a_port_asked_for_is_taken_or_refused(nao: nk.NaoModel) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(BadArgument, match=f"port {port} on 127.0.0.1 is in use"), Viewer(nao, port=port):
            pass
        viewer = Viewer(nao, port=port)
        with pytest.raises(BadArgument, match="in use"):
            _ = viewer.url
    with viewer:
        assert viewer.url == f"http://127.0.0.1:{port}/"
        with pytest.raises(BadArgument, match="in use"), Viewer(nao, port=port):
            pass
    assert _viewer_threads() == []


@pytest.mark.full
@pytest.mark.parametrize(
    ("host", "port"),
    [("127.0.0.1", -1), ("127.0.0.1", 70000), ("127.0.0.1", "7000"), ("a" * 70, None), ("203.0.113.7", None)],
)
def test_addresses_that_cannot_be_had_are_refused(nao: nk.NaoModel, host: str, port: Any) -> None:
    with pytest.raises(BadArgument), Viewer(nao, host=host, port=port):
        pass


def test_an_unknown_host_is_refused(nao: nk.NaoModel, monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(*_: Any, **__: Any) -> None:
        raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")

    monkeypatch.setattr(socket, "getaddrinfo", unknown)
    with pytest.raises(BadArgument, match="cannot listen on 'elsewhere' port 7000: Name or service not known"):
        _ = Viewer(nao, host="elsewhere").url


def test_a_new_page_receives_everything_on_show(viewer: Viewer, nao: nk.NaoModel) -> None:
    q = nao.posture("Crouch")
    viewer.show_com()
    viewer.display(q)

    async def visit() -> list[dict[str, Any]]:
        async with _client(viewer) as page:
            return page.received

    received = asyncio.run(visit())
    kinds = [message.get("kind", message["type"]) for message in received]
    order = ("geometry", "model", "robot", "joints", "shown")
    assert sorted(order, key=kinds.index) == list(order)
    assert kinds[-1] == "complete"
    assert np.array_equal(_q_of(received[kinds.index("joints")]), q)


def test_a_page_that_has_the_scene_is_sent_only_the_rest(nao: nk.NaoModel) -> None:
    async def visit(viewer: Viewer, query: str) -> list[dict[str, Any]]:
        page = await _connected(viewer, query)
        try:
            await page.receive("complete")
        finally:
            await _closed(page.connection)
        return page.received

    def kinds(messages: list[dict[str, Any]]) -> list[str]:
        return [message.get("kind", message["type"]) for message in messages]

    with Viewer(nao) as before:
        before.show_ghosts(nao.posture("Stand"))
        received = asyncio.run(visit(before, ""))
        version = received[kinds(received).index("version")]["version"]
    with Viewer(nao) as viewer:
        viewer.camera("front")
        received = asyncio.run(visit(viewer, f"?have={version}"))
        seen = kinds(received)
        assert not {"geometry", "model", "robot", "camera"} & set(seen)
        assert np.array_equal(_q_of(received[seen.index("joints")]), viewer.q)
        assert received[seen.index("ghosts")]["count"] == 0


def test_a_robot_of_the_same_name_with_other_lengths_is_another_scene(tmp_path: Path) -> None:
    def version(length: float) -> str:
        with Viewer(made_up(tmp_path, J("turn"), J("bow", xyz=(0.0, 0.0, length)))) as viewer:
            return str(asyncio.run(_first(viewer, "?have=none"))["version"])

    assert version(0.1) == version(0.1)
    assert version(0.1) != version(0.2)


async def _first(viewer: Viewer, query: str) -> dict[str, Any]:
    page = await _connected(viewer, query)
    try:
        return await page.receive("version")
    finally:
        await _closed(page.connection)


def test_the_page_of_a_picture_opens_one_socket_without_a_token(nao: nk.NaoModel) -> None:
    async def visit(viewer: Viewer, query: str) -> int:
        port = viewer._server.port
        address = f"ws://127.0.0.1:{port}/live{query}"
        try:
            page = await websocket_connect(HTTPRequest(address, headers={"Origin": f"http://127.0.0.1:{port}"}))
        except HTTPClientError as error:
            return error.code
        await _closed(page)
        return 101

    with Viewer(nao, token=True) as viewer, viewer._server.expected("a-role-that-nobody-guesses"):
        assert asyncio.run(visit(viewer, "?role=some-other-role")) == 403
        assert asyncio.run(visit(viewer, "?role=a-role-that-nobody-guesses")) == 101
        assert asyncio.run(visit(viewer, "?role=a-role-that-nobody-guesses")) == 403


def test_a_page_follows_every_display_and_may_skip_what_is_out_of_date(viewer: Viewer, nao: nk.NaoModel) -> None:
    qs = nao.random(3, 500)

    async def follow() -> list[np.ndarray]:
        async with _client(viewer) as page:
            before = len(page.received)
            for q in qs:
                viewer.display(q)
            await page.receive("joints", lambda message: np.array_equal(_q_of(message), qs[-1]))
            return [_q_of(message) for message in page.received[before:] if message.get("kind") == "joints"]

    seen = asyncio.run(follow())
    places = [int(np.flatnonzero((qs == q).all(axis=1))[0]) for q in seen]
    assert places == sorted(places)
    assert places[-1] == len(qs) - 1


def test_a_slider_of_one_page_moves_the_robot_here_and_in_the_other_page(viewer: Viewer, nao: nk.NaoModel) -> None:
    q = nao.random(5)

    async def slide() -> None:
        async with _client(viewer) as one, _client(viewer) as other:
            await one.send(kind="joints", q=q.tolist(), up=None, source="one")
            received = await other.receive("joints", lambda message: message["source"] == "one")
            assert np.array_equal(_q_of(received), q)

    asyncio.run(slide())
    assert np.array_equal(viewer.q, q)


@pytest.mark.full
@pytest.mark.parametrize(
    "answer",
    [
        "not json",
        '{"kind": "joints"}',
        '{"kind": "joints", "q": [1, 2, 3]}',
        '{"kind": "joints", "q": [' + ", ".join(["NaN"] * 25) + "]}",
        '{"kind": "picture", "id": [1], "data": "x"}',
        '{"kind": {"a": 1}}',
        '{"kind": "joints", "q": [' + ", ".join(["1" + "0" * 400] * 25) + "]}",
        '{"kind": "joints", "q": [' + ", ".join(["0"] * 25) + '], "up": [1e999, 0, 0], "source": 1e999}',
        '{"kind": "joints", "q": {"__proto__": 1}, "up": "<script>"}',
        '{"kind": "no such kind", "q": [' + ", ".join(["0"] * 25) + "]}",
        '{"kind": "shown", "shown": {"\\ud800": true, "com": 1, "axes": "x"}}',
        '{"kind": "shown", "shown": [["com", true]], "source": "\\ud800"}',
        '{"kind": "shown", "shown": {"com": false}, "source": ' + "[" * 900 + "]" * 900 + "}",
        "\x00",
        "[" * 100_000,
    ],
)
def test_nonsense_from_a_page_changes_nothing(viewer: Viewer, answer: str, caplog: pytest.LogCaptureFixture) -> None:
    before, shown = viewer.q, viewer.shown

    async def talk() -> None:
        async with _client(viewer) as page:
            await page.connection.write_message(answer)
            await page.connection.write_message(b"\xff\xfe", binary=True)
            viewer.display(before)
            await page.receive("joints")

    asyncio.run(talk())
    assert np.array_equal(viewer.q, before)
    assert viewer.shown == shown
    assert caplog.records == []
    assert _answers(viewer.url)


def test_a_page_may_call_itself_what_it_likes(
    viewer: Viewer, nao: nk.NaoModel, caplog: pytest.LogCaptureFixture
) -> None:
    q = nao.posture("Crouch")

    async def talk() -> None:
        async with _client(viewer) as page:
            for number, source in enumerate(["\ud800", 1e999, None, {"a": []}, "x" * 100_000]):
                q[0] = 0.1 * number
                await page.send(kind="joints", q=q.tolist(), source=source)
                await page.receive("joints", lambda message: np.array_equal(_q_of(message), q))
                assert len(page.received[-1]["source"]) <= 64

    asyncio.run(talk())
    assert caplog.records == []


def test_a_page_with_too_much_to_say_is_shown_out(viewer: Viewer, nao: nk.NaoModel) -> None:
    async def shout() -> None:
        page = await _connected(viewer)
        await page.receive("complete")
        await page.connection.write_message('{"kind": "joints", "source": "' + "x" * (1 << 20) + '"}')
        while await asyncio.wait_for(page.connection.read_message(), 5.0) is not None:
            pass
        page.connection.close()

    asyncio.run(shout())
    assert until(lambda: len(viewer._server._pages) == 0)
    assert _answers(viewer.url)


def _time_to_answer(url: str) -> float:
    start = time.monotonic()
    assert _answers(url)
    return time.monotonic() - start


def _handshake(port: int) -> bytes:
    return (
        f"GET /live HTTP/1.1\r\nHost: localhost:{port}\r\nOrigin: http://localhost:{port}\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
    ).encode()


def test_a_page_that_floods_neither_fills_the_memory_nor_keeps_others_waiting(viewer: Viewer, nao: nk.NaoModel) -> None:
    port = int(viewer.url.rstrip("/").rpartition(":")[2])
    text = json.dumps({"kind": "joints", "q": nao.posture("Sit").tolist(), "source": "s" * 500}).encode()
    frame = b"\x81\xfe" + len(text).to_bytes(2, "big") + bytes(4) + text  # masked by zeros, as it is
    taken: list[float] = []
    take = viewer._server._on_answer
    viewer._server._on_answer = lambda answer: (taken.append(time.monotonic()), take(answer))
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        alone = [_time_to_answer(viewer.url) for _ in range(20)]
        with socket.create_connection(("127.0.0.1", port), timeout=0.2) as loud:
            loud.sendall(_handshake(port))
            ended = threading.Event()

            def shout() -> None:
                rest = b""
                while not ended.is_set():
                    rest = rest or 200 * frame
                    with suppress(TimeoutError):
                        rest = rest[loud.send(rest) :]

            shouting = threading.Thread(target=shout)
            shouting.start()
            try:
                assert until(lambda: np.array_equal(viewer.q, nao.posture("Sit")))
                beside_it, start = list[float](), time.monotonic()
                while time.monotonic() - start < 1.5 or len(beside_it) < 20:
                    beside_it.append(_time_to_answer(viewer.url))
                assert len(viewer._server._pages) == 1
            finally:
                ended.set()
                shouting.join()
        assert tracemalloc.get_traced_memory()[0] - before < 20_000_000
    finally:
        tracemalloc.stop()
    assert np.median(beside_it) < 50.0 * np.median(alone)
    assert 10 < len(taken) <= 1.0 + 500.0 * (taken[-1] - taken[0])
    assert until(lambda: len(viewer._server._pages) == 0)


def test_no_more_than_so_many_pages_are_served(viewer: Viewer) -> None:
    port = int(viewer.url.rstrip("/").rpartition(":")[2])
    with ExitStack() as open_ones:
        answers = []
        for _ in range(65):
            connection = open_ones.enter_context(socket.create_connection(("127.0.0.1", port), timeout=5.0))
            connection.sendall(_handshake(port))
            answers.append(connection.recv(12))
        assert answers == [b"HTTP/1.1 101"] * 64 + [b"HTTP/1.1 503"]
    assert until(lambda: len(viewer._server._pages) == 0)


def test_waiting_ends_when_a_page_is_ready_or_the_time_is_over(viewer: Viewer) -> None:
    with pytest.raises(NoBrowser, match=r"no browser opened the page within 0.05 s"):
        viewer.wait(0.05)
    done = threading.Event()
    waiting = threading.Thread(target=lambda: (viewer.wait(10.0), done.set()))
    waiting.start()

    async def visit() -> None:
        async with _client(viewer):
            assert await asyncio.to_thread(done.wait, 5.0)

    asyncio.run(visit())
    waiting.join(5.0)


@pytest.mark.full
@pytest.mark.skipif(os.name != "posix", reason="process groups")
@pytest.mark.parametrize("ending", ["interrupt", *full("error", "kill")])
def test_no_process_is_left_behind(tmp_path: Path, ending: str) -> None:
    program = tmp_path / "program.py"
    program.write_text(
        "import threading, nao_kin as nk\n"
        "from nao_kin.viewer import Viewer\n"
        f"with Viewer(nk.load_nao(), port={free_port()}) as viewer:\n"
        "    print(viewer.url, flush=True)\n"
        + ("    raise RuntimeError('oh')\n" if ending == "error" else "    threading.Event().wait()\n"),
        encoding="utf-8",
    )
    process = subprocess.Popen(
        [sys.executable, str(program)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        assert process.stdout is not None
        url = process.stdout.readline().strip()
        if ending != "error":
            assert _answers(url)
            process.send_signal(signal.SIGINT if ending == "interrupt" else signal.SIGKILL)
        _, errors = process.communicate(timeout=PATIENCE)
        assert ("KeyboardInterrupt" in errors) == (ending == "interrupt")
        assert ("RuntimeError: oh" in errors) == (ending == "error")
        assert not _answers(url)
        with pytest.raises(ProcessLookupError):
            os.killpg(process.pid, 0)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()


class _Tab:
    """An open page that writes what it is sent into a list."""

    role, ready = "picture", True
    refresh, send_once = server._Page.refresh, server._Page.send_once
    _start_sending, _send_pending = server._Page._start_sending, server._Page._send_pending

    def __init__(self, live: LiveServer) -> None:
        self.server, self._sending, self.sent = live, False, list[bytes]()
        self._pending, self._once = dict[str, None](), list[bytes]()

    async def write_message(self, message: bytes, binary: bool) -> None:
        await asyncio.sleep(0)
        self.sent.append(message)

    def close(self, *_: Any) -> None:
        """Nothing to close."""


@pytest.mark.parametrize("turns", range(2))
def test_a_scene_is_sent_before_the_request_for_its_picture(turns: int) -> None:
    messages, other = RetainedMessages(), RetainedMessages()
    messages.put("joints", b"before")
    other.put("joints", b"after")
    document = Document(live_page("nao_kin"), policy())
    live = LiveServer(messages, document, host="127.0.0.1", port=0, on_answer=lambda answer: None)
    tab = _Tab(live)
    live._pages.add(tab)  # type: ignore[arg-type]
    asked = threading.Event()

    def wait(turns: int) -> None:
        """Hold up the server in one of its next turns, while it sends, until all is asked of it."""
        if turns > 0:
            live.call(lambda: wait(turns - 1))
        else:
            asked.wait(5.0)

    live.call(lambda: (tab.send_once(b"still"), wait(turns)))
    time.sleep(0.01)
    live.replace(other, lambda key: None)
    live.send_once(b"capture", "picture")
    asked.set()
    assert until(lambda: b"capture" in tab.sent)
    live.close()
    assert tab.sent == [b"still", b"after", b"capture"]
