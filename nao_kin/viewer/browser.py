"""A headless browser, and pictures and films of the scene drawn by it."""

from __future__ import annotations

import atexit
import base64
import io
import os
import queue
import secrets
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import zipfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from nao_kin._core.arrays import whole_number
from nao_kin._core.process import BROWSER_VARIABLE, before_ending, find_browsers, uninterrupted
from nao_kin._core.text import abbreviated
from nao_kin.errors import NoBrowser
from nao_kin.viewer.access import Document, live_page, policy
from nao_kin.viewer.messages import BLANKS, RetainedMessages, panel_message
from nao_kin.viewer.overlays import SHOWN
from nao_kin.viewer.server import Answer, LiveServer

_PREFIX = "nao_kin_browser_"
_RANDOM = 8  # random characters at the end of a temporary folder's name
# A socket's path has at most 107 bytes, and the browser appends /org.chromium.Chromium.XXXXXX/SingletonSocket.
_LONGEST_PATH = 60
# The disabled features would start renderers for the address bar, which takes as long as the page itself.
_OPTIONS = """
    --headless=new --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --disable-gpu
    --disable-dev-shm-usage --disable-background-networking --disable-breakpad --disable-component-update
    --disable-crash-reporter --disable-default-apps --disable-extensions --disable-quic --disable-sync
    --disable-features=WebUIOmniboxPopup,WebUIOmniboxAimPopup,WebUIOmniboxFullPopup
    --hide-scrollbars --mute-audio --no-default-browser-check --no-first-run --password-store=basic
""".split()
_SUPERVISOR = str(Path(__file__).resolve().parents[1] / "_core" / "process.py")
# Killing the browser and removing its files take less time than this; if the disk is slow, the supervisor continues
# alone.
_END_SECONDS = 0.7
_LOOK_SECONDS = 0.05
_KEY_BYTES = 16
# The page's own window, in pixels: small, because the page draws there too. A picture has a size of its own.
_WINDOW = "640,480"
# Width and height of a picture in pixels.
_MIN_EDGE, _MAX_EDGE = 16, 8192


class PictureBrowser:
    """A browser that draws this program's pictures: it starts with the first one and ends with the program.

    Loading the page takes most of the time of a picture, so one page stays open for all viewers. A scene with other
    robots needs another page, and starts another browser.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._page: _PicturePage | None = None

    def draw(
        self,
        messages: RetainedMessages,
        kind: str,
        request: dict[str, Any],
        size: tuple[int, int],
        timeout: float,
        progress: Callable[[int, int], object] | None = None,
    ) -> bytes:
        """Return a scene as a PNG file ("capture"), or its clip as a film ("film"); `timeout` is per picture [s]."""
        width, height = (whole_number(edge, "size", _MIN_EDGE, _MAX_EDGE) for edge in size)
        with self._showing(messages, timeout) as page:
            return page.draw(kind, {**request, "width": width, "height": height}, timeout, progress)

    @contextmanager
    def _showing(self, messages: RetainedMessages, timeout: float) -> Iterator[_PicturePage]:
        """Yield the page, when it shows the scene or has been told to; any error ends the browser."""
        with self._lock:  # one picture at a time
            if self._page is not None and not self._page.can_show(messages):
                self.end()
            try:
                if self._page is None:
                    self._page = _PicturePage(messages, timeout)
                else:
                    self._page.show(messages)
                yield self._page
            except BaseException:  # an interrupt, too, leaves a page that may be busy
                self.end()
                raise

    def end(self) -> None:
        """End the browser, if one runs."""
        page, self._page = self._page, None
        if page is not None:
            page.end()

    def forget(self) -> None:
        """In a forked process, leave the browser to the parent process."""
        self._lock, self._page = threading.Lock(), None


class _PicturePage:
    """A page in a headless browser, which shows the scene in time or raises NoBrowser, and its server."""

    def __init__(self, messages: RetainedMessages, timeout: float) -> None:
        self._messages, self._answers = RetainedMessages(), queue.Queue[Answer]()
        self._messages.copy(messages, _removing)
        # A random role, so that no other page can answer for the browser.
        self._role = f"capture-{secrets.token_urlsafe(_KEY_BYTES)}"
        document = Document(live_page("nao_kin"), policy())
        with ExitStack() as started:
            self._server = LiveServer(
                self._messages, document, host="127.0.0.1", port=0, on_answer=self._receive, token=True
            )
            started.callback(self._server.close)
            self._browser = self._started(timeout)
            started.callback(self._browser.close)
            self.end = started.pop_all().close

    def _started(self, timeout: float) -> Browser:
        """Return the first browser that shows the page; after one that ends by itself, the next one is tried."""
        reasons, end = [], time.monotonic() + timeout
        for program in find_browsers():
            with ExitStack() as started, self._server.expected(self._role) as address:
                browser = start_browser(program, address)
                started.callback(browser.close)
                while not self._server.wait_for_page(_LOOK_SECONDS, self._role):
                    if reason := browser.ended("before it showed the scene"):
                        reasons.append(reason)
                        break
                    if time.monotonic() > end:
                        raise NoBrowser(f"the browser {program} did not show the scene within {timeout:g} s")
                else:
                    started.pop_all()
                    return browser
        remedy = "" if os.environ.get(BROWSER_VARIABLE) else f"; name a browser that works in {BROWSER_VARIABLE}"
        raise NoBrowser("; ".join(reasons) + remedy)

    def can_show(self, messages: RetainedMessages) -> bool:
        """Return whether the page is still open in one of `find_browsers`, with the robots of these messages."""
        return (
            self._server.is_shown(self._role)
            and self._browser.program in find_browsers()
            and self._messages.scene_tag == messages.scene_tag
        )

    def show(self, messages: RetainedMessages) -> None:
        """Replace the scene in the page by the scene of these messages."""
        self._server.replace(messages, _removing)
        self._server.send_once(panel_message("complete", {}), self._role)

    def draw(
        self,
        kind: str,
        request: dict[str, Any],
        timeout: float,
        progress: Callable[[int, int], object] | None,
    ) -> bytes:
        """Return the file that the page makes, or raise NoBrowser if it is silent for `timeout` seconds."""
        request, parts, answer = {"id": secrets.token_urlsafe(_KEY_BYTES), **request}, list[bytes](), Answer()
        self._server.send_once(panel_message(kind, request), self._role)
        while answer.get("last") is not True:
            answer = self._answer(request, timeout)
            if "error" in answer:
                raise NoBrowser(f"the browser made no video: {answer['error']}")
            if "data" in answer:
                parts.append(_data(answer))
            elif progress is not None:
                progress(int(answer["done"]), int(answer["all"]))
        self._server.send_once(BLANKS["clip"], self._role)  # a clip would play unseen until the program ends
        return b"".join(parts)

    def _answer(self, request: dict[str, Any], timeout: float) -> Answer:
        """Wait for the page's next answer to a request."""
        end = time.monotonic() + timeout
        while True:
            with suppress(queue.Empty):
                answer = self._answers.get(timeout=_LOOK_SECONDS)
                if answer.get("id") == request["id"]:
                    return answer
            if reason := self._browser.ended("before it gave a picture"):
                raise NoBrowser(reason)
            if not self._server.is_shown(self._role) and self._answers.empty():
                raise NoBrowser("the page crashed in the browser before it gave a picture")
            if time.monotonic() > end:
                raise NoBrowser(f"the browser gave no picture within {timeout:g} s")

    def _receive(self, answer: Answer) -> None:
        if answer.get("kind") in ("picture", "film"):
            self._answers.put(answer)


def _removing(key: str) -> bytes | None:
    """Return the message that undoes the effect of a key's message in a page; None if there is nothing to undo."""
    kind, _, button = key.partition(" ")
    if kind == "shown":
        return panel_message("shown", {"shown": {button: SHOWN.get(button, False)}, "source": ""})
    return BLANKS.get(key)


def _data(answer: Answer) -> bytes:
    try:
        return base64.b64decode(str(answer["data"]).partition(",")[2], validate=True)
    except (KeyError, ValueError):
        raise NoBrowser("the browser's answer is not a picture") from None


pictures = PictureBrowser()
atexit.register(pictures.end)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=pictures.forget)


class Browser:
    """A browser that runs under a supervisor process."""

    def __init__(self, program: Path, supervisor: subprocess.Popen[bytes]) -> None:
        self.program, self._supervisor = program, supervisor
        self._registered = before_ending(self.end)

    def ended(self, when: str) -> str:
        """Return how and with which last words the browser has ended, `when` after how; "" while it runs."""
        if self._supervisor.poll() is None or self._supervisor.stdout is None:
            return ""
        how, _, words = self._supervisor.stdout.read().decode("utf-8", "replace").strip().partition("\n")
        text = f"the browser {self.program} {how or 'was ended'}"
        return text + ("" if "start" in how else f" {when}") + (f": {abbreviated(words)}" if words else "")

    def end(self) -> None:
        """Let the supervisor end the browser and remove its files; wait a short time for that."""
        with suppress(OSError, ValueError):
            if self._supervisor.stdin is not None:
                # Send a byte: closing the pipe would not be enough if a copy of this process has inherited it.
                self._supervisor.stdin.write(b"\n")
                self._supervisor.stdin.close()
        end = time.monotonic() + _END_SECONDS
        while self._supervisor.poll() is None and time.monotonic() < end:
            time.sleep(0.005)

    def close(self) -> None:
        """End the browser, and wait until all its files are removed."""
        with self._registered, self._supervisor:
            self.end()


def start_browser(program: Path, url: str) -> Browser:
    """Open `url` in a headless browser, which ends with `Browser.close`, or if this process ends or is killed.

    All that the browser writes is in a temporary folder, which is removed too (`nao_kin._core.process`).
    """
    python = _python()
    with uninterrupted():
        profile = tempfile.mkdtemp(prefix=_PREFIX, dir=_short_folder())
        options = [*_OPTIONS, f"--user-data-dir={profile}", f"--window-size={_WINDOW}"]
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            options.append("--no-sandbox")  # Chromium refuses to run as root otherwise
        supervisor = subprocess.Popen(
            [python, "-I", "-S", _SUPERVISOR, profile, _PREFIX, str(program), *options, url],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            bufsize=0,
            start_new_session=True,
            env={**os.environ, "TMPDIR": profile},
        )
        return Browser(program, supervisor)


def _python() -> str:
    """Return a Python interpreter for the supervisor; a program that embeds Python cannot run it."""
    if "py" in Path(sys.executable or "").name.lower():
        return sys.executable
    found = shutil.which("python3")
    if found is None:
        raise NoBrowser("a picture needs python3 on the path, to watch over the browser")
    return found


def _short_folder() -> str:
    """Return the folder for temporary files, or a shorter one: the browser's socket in it needs a short path."""
    usual = tempfile.gettempdir()
    length = len(os.fsencode(usual)) + 1 + len(_PREFIX) + _RANDOM
    return usual if length <= _LONGEST_PATH or not os.access("/tmp", os.W_OK) else "/tmp"


def zipped(pictures: bytes) -> bytes:
    """Return PNG files, which are given one after another, as a ZIP file of 00000.png and so on."""
    end, file = b"\0\0\0\0IEND\xaeB`\x82", io.BytesIO()  # the last chunk of each PNG file
    with zipfile.ZipFile(file, "w") as archive:
        for number, picture in enumerate(pictures.split(end)[:-1]):
            archive.writestr(zipfile.ZipInfo(f"{number:05}.png"), picture + end)
    return file.getvalue()
