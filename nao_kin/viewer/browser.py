"""A headless browser, and pictures of the scene drawn by it."""

from __future__ import annotations

import base64
import os
import queue
import secrets
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from nao_kin._core.arrays import whole_number
from nao_kin._core.process import before_ending, uninterrupted
from nao_kin._core.text import quoted
from nao_kin.errors import BadArgument, NoBrowser
from nao_kin.viewer.messages import panel_message
from nao_kin.viewer.server import Answer, LiveServer

VARIABLE = "NAO_KIN_BROWSER"
_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge")
_MAC_APPLICATIONS = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
)
_PREFIX = "nao_kin_browser_"
_RANDOM = 8  # characters that a temporary folder's name ends in
# A socket's path has at most 107 bytes, and the browser's adds /org.chromium.Chromium.XXXXXX/SingletonSocket.
_LONGEST_PATH = 60
_OPTIONS = """
    --headless=new --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --disable-gpu
    --disable-dev-shm-usage --disable-background-networking --disable-breakpad --disable-component-update
    --disable-crash-reporter --disable-default-apps --disable-extensions --disable-quic --disable-sync
    --hide-scrollbars --mute-audio --no-default-browser-check --no-first-run --password-store=basic
""".split()
_SUPERVISOR = str(Path(__file__).resolve().parents[1] / "_core" / "supervisor.py")
# Killing and removing take less time; if the disk is slow, the supervisor continues alone.
_END_SECONDS = 0.7
_LOOK_SECONDS = 0.05
_KEY_BYTES = 16
# Width and height of a picture in pixels.
_MIN_EDGE, _MAX_EDGE = 16, 8192


class Screenshots:
    """Open a separate page for every picture, and match answers with requests."""

    def __init__(self) -> None:
        self._waiting: dict[str, queue.Queue[Answer]] = {}

    def picture(self, server: LiveServer, camera: str, size: tuple[int, int], timeout: float) -> bytes:
        """Return a PNG of the scene from a camera, `size` pixels in width and height, within `timeout` seconds.

        Raises:
            BadArgument: a size out of range.
            NoBrowser: there is no browser, it ends, or it sends no picture in time.
        """
        if not isinstance(size, (tuple, list)) or len(size) != 2:
            raise BadArgument(f"size must be two whole numbers from {_MIN_EDGE} to {_MAX_EDGE}, got {quoted(size)}")
        width, height = (whole_number(edge, "size", _MIN_EDGE, _MAX_EDGE) for edge in size)
        end = time.monotonic() + timeout
        # A random role, so that no other page can answer for the browser.
        mine = secrets.token_urlsafe(_KEY_BYTES)
        role = f"capture-{mine}"
        answers = self._waiting[mine] = queue.Queue(1)
        try:
            with server.expected(role) as address, headless(address, size=(width, height)) as browser:
                while not server.wait_for_page(_LOOK_SECONDS, role):
                    browser.check("before it showed the scene")
                    if time.monotonic() > end:
                        raise NoBrowser(f"the browser did not show the scene within {timeout:g} s")
                request = {"id": mine, "camera": camera, "width": width, "height": height}
                server.send_once(panel_message("capture", request), role)
                while True:
                    with suppress(queue.Empty):
                        answer = answers.get(timeout=_LOOK_SECONDS)
                        return base64.b64decode(str(answer["data"]).partition(",")[2], validate=True)
                    browser.check("before it gave a picture")
                    if not server.is_shown(role) and answers.empty():
                        raise NoBrowser("the page crashed in the browser before it gave a picture")
                    if time.monotonic() > end:
                        raise NoBrowser(f"the browser gave no picture within {timeout:g} s")
        except (KeyError, ValueError):
            raise NoBrowser("the browser's answer is not a picture") from None
        finally:
            del self._waiting[mine]

    def deliver(self, answer: Answer) -> None:
        """Pass an answer to the request that waits for it."""
        number = answer.get("id")
        waiting = self._waiting.get(number) if isinstance(number, str) else None
        if waiting is not None:
            with suppress(queue.Full):
                waiting.put_nowait(answer)


def find_browser() -> Path:
    """Return the program of a Chromium or Chrome: the one in the variable NAO_KIN_BROWSER, or the first on the path."""
    named = os.environ.get(VARIABLE, "")
    for name in [named] if named else [*_NAMES, *_MAC_APPLICATIONS]:
        found = shutil.which(name)
        if found is not None:
            return Path(found)
    if named:
        raise NoBrowser(f"{VARIABLE} names {quoted(named)}, which is not a program")
    raise NoBrowser(
        f"a picture needs Chromium or Chrome, and none was found: install one (Debian: apt install chromium) "
        f"or name it in {VARIABLE}"
    )


class Browser:
    """A browser that runs under a supervisor process."""

    def __init__(self, program: Path, supervisor: subprocess.Popen[bytes]) -> None:
        self.program, self._supervisor = program, supervisor

    def check(self, when: str) -> None:
        """Raise `NoBrowser` if the browser has ended; `when` ends the message."""
        if self._supervisor.poll() is not None and self._supervisor.stdout is not None:
            line = self._supervisor.stdout.read().decode("utf-8", "replace").strip() or "was ended"
            raise NoBrowser(f"the browser {self.program} {line}" + ("" if "start" in line else f" {when}"))

    def end(self) -> None:
        """Let the supervisor end the browser and remove its files; wait briefly until that is done."""
        with suppress(OSError, ValueError):
            if self._supervisor.stdin is not None:
                # A byte, because the pipe stays open if a copy of this process has inherited it.
                self._supervisor.stdin.write(b"\n")
                self._supervisor.stdin.close()
        end = time.monotonic() + _END_SECONDS
        while self._supervisor.poll() is None and time.monotonic() < end:
            time.sleep(0.005)


@contextmanager
def headless(url: str, *, size: tuple[int, int]) -> Iterator[Browser]:
    """Open `url` in a browser without a window, which ends with the context, even if this process is killed.

    All that the browser writes is in a temporary folder, which is removed too: `nao_kin._core.supervisor` runs the
    browser for as long as this process lives.
    """
    program = find_browser()
    python = _python()
    with uninterrupted():
        profile = tempfile.mkdtemp(prefix=_PREFIX, dir=_short_folder())
        options = [*_OPTIONS, f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}"]
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
        browser = Browser(program, supervisor)
        registered = before_ending(browser.end)
    with registered, supervisor:
        try:
            yield browser
        finally:
            browser.end()


def _python() -> str:
    """Return a Python interpreter for the supervisor; a program that embeds Python cannot be used."""
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
