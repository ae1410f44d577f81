"""The live page: one thread that serves it and updates every open page.

The server runs inside the process and ends with it. Each page gets the newest message of each kind; a slow page skips
outdated ones. The size, rate and number of pages' messages are limited, so that a faulty page neither fills the memory
nor delays the other pages. The number of connections, and the time that a request may take, are limited so that clients
do not take the files of the program, which are connections too.
"""

from __future__ import annotations

import asyncio
import errno
import json
import logging
import os
import socket
import threading
import time
import weakref
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any
from urllib.parse import urlencode

import tornado.httpserver
import tornado.ioloop
import tornado.iostream
import tornado.web
import tornado.websocket

from nao_kin._core.arrays import whole_number
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument
from nao_kin.viewer.access import Access, Document, Guarded, NotFound, PageHandler, Token
from nao_kin.viewer.messages import BLANKS, RetainedMessages, note_last, panel_message

_FIRST_PORT, _PORTS_TRIED = 7000, 200
_LARGEST_PICTURE, _LARGEST_ANSWER = 1 << 27, 1 << 20
# Requests here have no body; by default tornado would read 100 MB before it refuses one.
_LARGEST_BODY = 1 << 10
_MAX_PAGES = 64
# As many other connections as pages; a program on macOS may have 256 open files.
_MAX_CONNECTIONS = 2 * _MAX_PAGES
# For the headers of a request, its body, and between two requests of a connection; a page's socket has no such limit.
_SECONDS_FOR_A_REQUEST = 10.0
_SECONDS_BETWEEN_ATTEMPTS = 1.0
# More messages than any page sends, even if it draws 240 times a second.
_SECONDS_BETWEEN_ANSWERS = 1.0 / 500.0
_JOIN_SECONDS = 5.0
# Address that means all addresses → an address that a browser can open.
_HERE = {"": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}

_LOG = logging.getLogger(__name__)

Answer = dict[str, Any]


def weak_receiver(receive: Callable[[Answer], None]) -> Callable[[Answer], None]:
    """Return a function that calls a method without keeping its object alive; it does nothing without the object."""
    receiver = weakref.WeakMethod(receive)

    def on_answer(answer: Answer) -> None:
        method = receiver()
        if method is not None:
            method(answer)

    return on_answer


class LiveServer:
    """A server of a page and its messages on one port, the first free one for None, from construction until `close`.

    `on_answer` is called with each message of a page, in the server's thread.
    """

    def __init__(
        self,
        messages: RetainedMessages,
        document: Document,
        *,
        host: str,
        port: int | None,
        on_answer: Callable[[Answer], None],
        allow_hosts: tuple[str, ...] = (),
        token: Token = None,
    ) -> None:
        self.host = host
        listening = _listen(host, port)
        address, self.port = listening.getsockname()[:2]
        try:
            access = Access(address, host, allow_hosts, token)
        except BadArgument:
            listening.close()
            raise
        self._access, self.token = access, access.token
        self._messages, self._document, self._on_answer = messages, document, on_answer
        self._pages: set[_Page] = set()
        self._changed: dict[str, None] = {}
        self._lock = threading.Lock()
        self._arrival = threading.Condition()
        self._application = tornado.web.Application(
            [
                (r"/", PageHandler, {"document": document, "access": access}),
                (r"/live", _Page, {"server": self, "access": access}),
            ],
            default_handler_class=NotFound,
            default_handler_args={"access": access},
            log_function=lambda handler: None,
        )
        started = threading.Event()
        self._failures: list[OSError] = []
        self._thread = threading.Thread(target=self._run, args=(listening, started), name="nao_kin viewer", daemon=True)
        self._thread.start()
        started.wait()
        for failure in self._failures:
            listening.close()
            raise BadArgument(f"cannot serve the page: {failure.strerror or failure}")
        messages.watch(self._note_change)

    @property
    def address(self) -> str:
        """The address of the page, without the token."""
        host = _HERE.get(self.host, self.host)
        return f"http://{f'[{host}]' if ':' in host else host}:{self.port}/"

    @property
    def url(self) -> str:
        """The address of the page, with the token that it needs."""
        return self.address + (f"?{urlencode({'token': self.token})}" if self.token else "")

    @contextmanager
    def expected(self, role: str) -> Iterator[str]:
        """Expect one page in a random role, which needs no token and may send a picture; yield its address.

        Other users can read the address on a browser's command line; therefore the address opens only one socket.
        """
        self._access.expected.add(role)
        try:
            yield f"{self.address}?{urlencode({'role': role})}"
        finally:
            self._access.expected.discard(role)

    def close(self) -> None:
        """Close the connections of all pages and the port; does nothing the second time."""
        self._messages.unwatch(self._note_change)
        if self._thread.is_alive():
            self.call(self._stop.set)
            if self._thread is not threading.current_thread():  # it may drop the last reference to a viewer
                self._thread.join(_JOIN_SECONDS)
        with self._arrival:
            self._arrival.notify_all()

    def wait_for_page(self, timeout: float | None, role: str = "") -> bool:
        """Wait until a page in a role shows the scene; False after `timeout` seconds or if the server closed."""
        end = None if timeout is None else time.monotonic() + timeout
        with self._arrival:
            while not self.is_shown(role):
                left = None if end is None else end - time.monotonic()
                if not self._thread.is_alive() or (left is not None and left <= 0.0):
                    return False
                self._arrival.wait(1.0 if left is None else min(left, 1.0))
        return True

    def is_shown(self, role: str = "") -> bool:
        """Whether a page in this role is open and shows the scene."""
        return any(page.ready and page.role == role for page in tuple(self._pages))

    def replace(self, messages: RetainedMessages, removing: Callable[[str], bytes | None]) -> None:
        """Show the scene of other messages, as `RetainedMessages.copy`, before what is sent once from now on."""

        def replaced() -> None:
            self._messages.copy(messages, removing)
            # Now: an update that is only scheduled could come after messages that are waiting already.
            self._update_pages()

        self.call(replaced)

    def send_once(self, message: bytes, role: str = "") -> None:
        """Send a message to the open pages in one role, without retaining it."""

        def send() -> None:
            for page in tuple(self._pages):
                if page.role == role:
                    page.send_once(message)

        self.call(send)

    # --- the server's thread --------------------------------------------------------------------------------------

    def _run(self, listening: socket.socket, started: threading.Event) -> None:
        try:
            asyncio.run(self._serve(listening, started))
        except OSError as error:
            self._failures.append(error)
        finally:
            started.set()

    async def _serve(self, listening: socket.socket, started: threading.Event) -> None:
        self._loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        server = tornado.httpserver.HTTPServer(
            self._application,
            max_body_size=_LARGEST_BODY,
            idle_connection_timeout=_SECONDS_FOR_A_REQUEST,
            body_timeout=_SECONDS_FOR_A_REQUEST,
        )
        door = _Door(server, listening)
        started.set()
        await self._stop.wait()
        door.close()
        for page in tuple(self._pages):
            page.close(1001, "the viewer closed")
        await server.close_all_connections()

    def call(self, function: Callable[[], object]) -> None:
        """Schedule the call of a function in the server's thread; does nothing if the server is closed."""
        with suppress(RuntimeError):  # the loop may just have been closed
            self._loop.call_soon_threadsafe(function)

    def _note_change(self, key: str) -> None:
        """Schedule one update in the server's thread, for all changes until it runs."""
        if not self._pages:  # a page that opens later gets all messages
            return
        with self._lock:
            schedule = not self._changed
            note_last(self._changed, key)
        if schedule:
            self.call(self._update_pages)

    def _update_pages(self) -> None:
        with self._lock:
            changed, self._changed = self._changed, {}
        for page in tuple(self._pages):
            page.refresh(changed)

    def _page_opened(self, page: _Page) -> None:
        self._pages.add(page)
        messages = self._messages
        version = f"{self._document.tag}{messages.scene_tag}"
        had = page.get_query_argument("have", "")
        page.send_once(panel_message("version", {"version": version}))
        if had in ("", version):
            # A page that has the scene, from here or from an earlier program, keeps it and its camera.
            retained = messages.scene | {"camera"} if had else frozenset[str]()
            shown = messages.names()
            if had:
                # Remove the drawings of an earlier program.
                for key in BLANKS.keys() - set(shown):
                    page.send_once(BLANKS[key])
            page.refresh(key for key in shown if key not in retained)
            page.send_once(panel_message("complete", {}))

    def _page_answered(self, page: _Page, answer: Answer) -> None:
        if answer.get("kind") == "ready":
            page.ready = True
            with self._arrival:
                self._arrival.notify_all()
        self._on_answer(answer)


class _Door:
    """Accepts the connections of a server: `_MAX_CONNECTIONS` at once; the next ones wait in the socket's queue.

    tornado's own accepts any number, and reports each one that the process has no file for with a traceback.
    """

    def __init__(self, server: tornado.httpserver.HTTPServer, listening: socket.socket) -> None:
        self._server, self._listening = server, listening
        self._loop = tornado.ioloop.IOLoop.current()
        self._connections: list[socket.socket] = []
        self._told: set[str] = set()
        self._loop.add_handler(listening, self._accept, tornado.ioloop.IOLoop.READ)

    def close(self) -> None:
        """Accept no more connections and close the port."""
        self._loop.remove_handler(self._listening)
        self._listening.close()

    def _accept(self, *_: object) -> None:
        while True:
            self._connections = [connection for connection in self._connections if connection.fileno() >= 0]
            if len(self._connections) >= _MAX_CONNECTIONS:
                return self._pause(f"{_MAX_CONNECTIONS} connections are open")
            try:
                connection, address = self._listening.accept()
            except (BlockingIOError, ConnectionAbortedError):
                return None
            except OSError as error:
                return self._pause(error.strerror or str(error))
            self._connections.append(connection)
            self._server.handle_stream(tornado.iostream.IOStream(connection), address)

    def _pause(self, reason: str) -> None:
        """Accept nothing for a moment: the waiting connections would otherwise call `_accept` all the time."""
        if reason not in self._told:
            self._told.add(reason)
            _LOG.warning("pages that connect have to wait: %s", reason)
        self._loop.remove_handler(self._listening)
        self._loop.call_later(_SECONDS_BETWEEN_ATTEMPTS, self._continue)

    def _continue(self) -> None:
        if self._listening.fileno() >= 0:
            self._loop.add_handler(self._listening, self._accept, tornado.ioloop.IOLoop.READ)


class _Page(Guarded, tornado.websocket.WebSocketHandler):
    """One open page: the keys of the messages it lacks, and one task that sends them."""

    def initialize(self, server: LiveServer, access: Access) -> None:
        self.server, self.access, self.ready, self.role = server, access, False, ""
        self._pending: dict[str, None] = {}
        self._once: list[bytes] = []
        self._sending = False

    def prepare(self) -> None:
        super().prepare()
        if self._finished:
            return
        headers = self.request.headers
        refusal = self.access.refusal_of_origin(headers.get_list("Origin"), headers["Host"], self.given_token())
        if refusal is not None:
            self.refuse(403, refusal)
        elif len(self.server._pages) >= _MAX_PAGES:
            self.refuse(503, f"{_MAX_PAGES} pages are open already.")

    def check_origin(self, origin: str) -> bool:
        return True  # checked in `prepare`

    @property
    def max_message_size(self) -> int:
        return _LARGEST_PICTURE if self.role_asked_for() in self.access.expected else _LARGEST_ANSWER

    def get_compression_options(self) -> dict[str, Any] | None:
        """Compress for pages on other machines, to a third of the size; on this machine compression only takes time."""
        return None if self.request.remote_ip in ("127.0.0.1", "::1") else {"compression_level": 1}

    def open(self, *_: str, **__: str) -> None:
        self.set_nodelay(True)
        self.role = self.role_asked_for()
        self.access.expected.discard(self.role)
        self.server._page_opened(self)

    def on_close(self) -> None:
        self.server._pages.discard(self)

    async def on_message(self, message: str | bytes) -> None:
        answer = None
        with suppress(ValueError, RecursionError):
            answer = json.loads(message)
        if isinstance(answer, dict):
            self.server._page_answered(self, answer)
        # Until then no further message of this page is read: a fast page fills its own buffers, not ours.
        await asyncio.sleep(_SECONDS_BETWEEN_ANSWERS)

    def refresh(self, keys: Iterable[str]) -> None:
        for key in keys:
            note_last(self._pending, key)
        self._start_sending()

    def send_once(self, message: bytes) -> None:
        self._once.append(message)
        self._start_sending()

    def _start_sending(self) -> None:
        if not self._sending:
            self._sending = True
            asyncio.get_running_loop().create_task(self._send_pending())

    async def _send_pending(self) -> None:
        try:
            while self._pending or self._once:
                keys, self._pending = self._pending, {}
                for message in map(self.server._messages.get, keys):
                    if message is not None:
                        await self.write_message(message, binary=True)
                once, self._once = self._once, []
                for message in once:
                    await self.write_message(message, binary=True)
        except (tornado.websocket.WebSocketClosedError, tornado.iostream.StreamClosedError):
            pass
        finally:
            self._sending = False


def _listen(host: str, port: int | None) -> socket.socket:
    """Return a socket on the given port, or on the first free one."""
    if port is None:
        wanted = [*range(_FIRST_PORT, _FIRST_PORT + _PORTS_TRIED), 0]
    else:
        wanted = [whole_number(port, "port", 0, 0xFFFF)]
    for number in wanted:
        try:
            return _bound(host, number)
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise BadArgument(f"cannot listen on {quoted(host)} port {number}: {error.strerror or error}") from None
        except ValueError:
            raise BadArgument(f"{quoted(host)} is not an address") from None
    raise BadArgument(f"port {port} on {host} is in use; leave it out to take the next free one")


def _bound(host: str, port: int) -> socket.socket:
    """Return a listening socket, as tornado's bind_sockets does, but leave none open if the port is taken."""
    family, kind, protocol, _, address = socket.getaddrinfo(host or None, port, type=socket.SOCK_STREAM)[0]
    listening = socket.socket(family, kind, protocol)
    try:
        if os.name == "posix":
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.setblocking(False)
        listening.bind(address)
        listening.listen(128)
    except OSError:
        listening.close()
        raise
    return listening
